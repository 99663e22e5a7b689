"""Tied surfaces: nodes of the slave follow the facets of the master that they lie on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from fecontact.app.decks.content import DeckPair
from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface

#: Distance of a node from the master, relative to the size of its facets, up to which it is tied unless the deck says
#: (Abaqus Analysis User's Guide, "Mesh tie constraints": 5 % of the typical size of the master's elements).
NEAR = 0.05


def tied(mesh: Mesh, ties: Sequence[DeckPair]) -> tuple[Mesh, tuple[str, ...]]:
    """The mesh with the nodes of slaves on their masters, which they follow by the masters' shape functions.

    Nodes further away than the tie reaches, a twentieth of the size of a facet unless the deck says otherwise, or
    beside the master, stay free; a warning says how many. A tied node is moved onto the master, so that rigid motions
    do not strain.

    Parameters
    ----------
    mesh : Mesh
        With the boundaries that the ties name.
    ties : sequence of DeckPair

    Returns
    -------
    mesh : Mesh
    warnings : tuple of str

    Raises
    ------
    InputError
        If no node of a slave lies on its master.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.mesh.mesh import merge
    >>> lower = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    >>> upper = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element="hex8").translated((0, 0, 1))
    >>> rename = lambda mesh, old, new: replace(mesh, boundaries={new: mesh.faces(old)})
    >>> both = merge([rename(upper, "bottom", "slave"), rename(lower, "top", "master")], 1e-9)
    >>> tied(both, [DeckPair("slave", "master", 0.0, "line 1")])[0].hanging
    HangingNodes(12 of 87 points)
    """
    nodes: list[IntArray] = []
    weights: list[sp.csr_matrix] = []
    loose: list[str] = []
    for tie in ties:
        master = FacetSurface(mesh.points, mesh.face_nodes(mesh.faces(tie.master)))
        slave = np.setdiff1d(mesh.boundary_nodes(tie.slave), master.nodes)
        if not len(slave):
            continue
        found = master.project(mesh.points[slave])
        assert found.weights is not None
        assert found.facet is not None
        size = np.sqrt(SurfaceMesh.of(mesh, tie.master).areas)[found.facet]
        reach = NEAR * size if tie.reach is None else np.full(len(slave), tie.reach)
        away = np.linalg.norm(found.points - mesh.points[slave], axis=1)
        on = np.flatnonzero(away <= reach)
        if not len(on):
            raise InputError(f"{tie.place}: no node of the tied surface {tie.slave!r} lies on {tie.master!r}.")
        if len(on) < len(slave):
            loose.append(
                f"{tie.place}: {len(slave) - len(on)} of {len(slave)} nodes of the tied {tie.slave!r} lie up to "
                f"{away.max():.3g} from {tie.master!r}, beyond the tie's reach of {reach.max():.3g}, and stay loose."
            )
        nodes.append(slave[on])
        weights.append(found.weights[on])
    if not nodes:
        return mesh, ()
    every, first = np.unique(np.concatenate(nodes), return_index=True)
    hanging = HangingNodes.closed(every, _normalised(sp.vstack(weights).tocsr()[first]))
    return replace(mesh, points=hanging.followed(mesh.points), hanging=hanging), tuple(loose)


def _normalised(weights: sp.csr_matrix) -> sp.csr_matrix:
    """Rows that sum to one, but for rounding of the projection."""
    return sp.csr_matrix(sp.diags(1 / np.asarray(weights.sum(axis=1)).ravel()) @ weights)
