"""Surfaces tied to each other: nodes of one follow the facets of the other by their functions.

A tied node is moved onto the master without strain, so that rigid motions do not strain; a gap that this closes is
warned of (`CLOSED`). A tie is exact for uniform stress where the
slave's facets lie in those of the master, elsewhere as accurate as ties of nodes to faces in other programs.

Source: Abaqus Analysis User's Guide, "Mesh tie constraints", of the reach by default.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import scipy.sparse as sp

from fecontact.common.arguments import instance, mapping
from fecontact.common.arrays import IntArray
from fecontact.common.checks import positive
from fecontact.common.errors import InputError
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.surface_mesh import SurfaceMesh, averaged_normals
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.section_curve import CurveSurface

M = TypeVar("M", bound=BaseMesh)
#: Distance of a node from the master, relative to the size of its facets, up to which it is tied by default.
NEAR = 0.05
#: Distance by which nodes are moved without a word: as a share of the facet's size, and over the rise of a smooth shape
#: above its facet, which turns by an angle t to the mean of its neighbours: a quarter of t times the size.
CLOSED, RISES = 1e-3, 2.0


@dataclass(frozen=True, eq=False)
class Followers:
    """Nodes of a slave (n,), weights (n, n_points) in the master; how many stay loose or are moved, in words."""

    nodes: IntArray
    weights: sp.csr_matrix
    loose: str = ""
    moved: str = ""

    @property
    def remarks(self) -> tuple[str, ...]:
        """What there is of these words."""
        return tuple(text for text in (self.loose, self.moved) if text)


def tied(mesh: Mesh, ties: Mapping[str, str], reach: float | None = None) -> Mesh:
    """A mesh whose parts are tied: nodes of slaves, boundaries or sets of nodes, follow the faces of their masters.

    Parameters
    ----------
    mesh : Mesh
        Of one body, such as `merge` makes it of several meshes.
    ties : mapping of slave to master
        Names of boundaries; the slave should be the finer one, and may be a set of nodes.
    reach : float, optional
        Distance up to which nodes are tied, by default a twentieth of the size of a facet. Others, and those beside
        the master, stay free. The mesh warns of these, and of a gap that is closed.

    Returns
    -------
    Mesh

    Raises
    ------
    InputError
        If no node of a slave lies on its master.

    Examples
    --------
    >>> import fecontact as fc
    >>> lower = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    >>> upper = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element="hex8").translated((0, 0, 1))
    >>> rename = lambda mesh, old, new: replace(mesh, boundaries={new: mesh.faces(old)})
    >>> both = fc.merge([rename(upper, "bottom", "slave"), rename(lower, "top", "master")], 1e-9)
    >>> fc.tied(both, {"slave": "master"}).hanging
    HangingNodes(12 of 87 points)
    """
    instance("the mesh of a tie", mesh, Mesh)
    if reach is not None:
        positive("the reach of a tie", reach)
    pairs = mapping("the ties of a mesh", ties).items()
    return joined_by(mesh, [followers(mesh, slave, master, reach) for slave, master in pairs])


def followers(mesh: BaseMesh, slave: str, master: str, reach: float | None = None) -> Followers:
    """Nodes of a slave that follow a master, see `tied`; none where all of them are its own.

    Raises
    ------
    InputError
        If no node of the slave lies on the master.
    """
    facets = mesh.face_nodes(mesh.faces(master))
    surface = (CurveSurface if mesh.is_flat else FacetSurface)(mesh.points, facets)
    nodes = np.setdiff1d(mesh.boundary_nodes(slave), surface.nodes)
    if not len(nodes):
        return Followers(nodes, sp.csr_matrix((0, len(mesh.points))))
    found = surface.project(mesh.points[nodes])
    assert found.weights is not None
    assert found.facet is not None
    sizes = np.sqrt(SurfaceMesh.of(mesh, master).areas) if isinstance(mesh, Mesh) else surface.mean_facet_size
    size = sizes[found.facet]
    limit = NEAR * size if reach is None else np.full(len(nodes), reach)
    away = np.linalg.norm(found.points - mesh.points[nodes], axis=1)
    on = np.flatnonzero(away <= limit)
    if not len(on):
        raise InputError(
            f"no node of the tied surface {slave!r} lies on {master!r}: the nearest is {away.min():.3g} away, the "
            f"tie's reach is {limit.max():.3g}.",
            code="tie-apart",
        )
    loose = ""
    if len(on) < len(nodes):
        loose = (
            f"{len(nodes) - len(on)} of {len(nodes)} nodes of the tied {slave!r} lie up to {away.max():.3g} from "
            f"{master!r}, beyond the tie's reach of {limit.max():.3g}, and stay loose."
        )
    faces = surface.spatial
    turned = np.arccos(np.clip(averaged_normals(faces.points, faces.facets)[1], -1.0, 1.0))[faces.facets].max(axis=1)
    rise = size * turned[found.facet] / 4
    far = away[on] > (CLOSED * size + RISES * rise)[on]
    moved = ""
    if far.any():
        moved = (
            f"{far.sum()} nodes of the tied {slave!r} are moved by up to {away[on].max():.3g} onto {master!r}: a gap "
            "between them is closed, without strain."
        )
    return Followers(nodes[on], _normalised(found.weights[on]), loose, moved)


def joined_by(mesh: M, ties: Sequence[Followers]) -> M:
    """The mesh with followers on their masters; of nodes with two masters the first counts."""
    ties = [tie for tie in ties if len(tie.nodes)]
    if not ties:
        return mesh
    every, first = np.unique(np.concatenate([tie.nodes for tie in ties]), return_index=True)
    hanging = HangingNodes.closed(every, sp.vstack([tie.weights for tie in ties]).tocsr()[first])
    told = (text for tie in ties for text in tie.remarks)
    return replace(mesh, points=hanging.followed(mesh.points), hanging=hanging, warnings=(*mesh.warnings, *told))


def _normalised(weights: sp.csr_matrix) -> sp.csr_matrix:
    """Rows that sum to one, but for rounding of the projection."""
    return sp.csr_matrix(sp.diags(1 / np.asarray(weights.sum(axis=1)).ravel()) @ weights)
