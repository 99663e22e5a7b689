"""Smooth surfaces fitted to contact boundaries of a mesh, once, before any cell is divided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.check import check_size
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.placement import Placement
from fecontact.mesh.smooth_parts import SmoothParts, smooth_parts
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.smooth import SmoothSurface

#: Height of nodes on sides over the chords, relative to that of the arc between the corners' normals, below which sides
#: are straight: their nodes then say nothing about the surface.
STRAIGHT = 0.25


def fitted(mesh: Mesh, names: Sequence[str]) -> dict[str, Placement]:
    """Fit smooth surfaces to the curved parts of boundaries.

    Neighbouring faces of the body that continue a boundary smoothly count for the fit.

    Parameters
    ----------
    mesh : Mesh
        Without nodes in the middle of faces.
    names : sequence of str
        Boundaries; their faces are outer ones.

    Returns
    -------
    dict of str to Placement
        Of the boundaries that are not flat.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.quarter_sphere(1.0, contact_radius=0.1, level=1, element="hex8")
    >>> cap = fitted(mesh, ["cap", "sym_x"])["cap"]
    >>> bool(cap.surface.project(mesh.points[mesh.cells[0]]).gap.round(4).min() < 0)
    True
    """
    check_size(mesh.points)
    skin = mesh.outer
    if not names or len(skin) == 0:
        return {}
    # a ninth node is a point of the surface only in cells of 27
    facets = mesh.face_nodes(skin)[:, : 9 if mesh.cell_type == "hex27" else 8]
    number = skin @ np.array([6, 1])
    own = {name: np.isin(number, mesh.faces(name) @ np.array([6, 1])) for name in names}
    return fitted_facets(mesh.points, facets, own, mesh.hanging)


def fitted_facets(
    points: Array, facets: IntArray, own: Mapping[str, Mask], hanging: HangingNodes | None = None
) -> dict[str, Placement]:
    """Fit smooth surfaces to the curved ones of named facets.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array
        Of the whole body; those that continue named ones smoothly count for the fit.
    own : mapping of str to (n_facets,) bool array
    hanging : HangingNodes, optional
        Of the mesh, if it has any.

    Returns
    -------
    dict of str to Placement
        Of the names whose facets are not all flat.
    """
    parts = smooth_parts(points, facets, hanging)
    curved = {name: chosen & ~parts.flat for name, chosen in own.items() if (chosen & ~parts.flat).any()}
    if not curved:
        return {}
    among = np.any(list(curved.values()), axis=0)
    if facets.shape[1] > 4 and sides_are_straight(points, facets[among]):
        facets = facets[:, :4]
    continued = np.isin(parts.part, parts.part[among])
    sites, on_sites = _sites(facets[continued], parts.part[continued])
    out = {}
    for name, chosen in curved.items():
        used, base = np.unique(on_sites[chosen[continued]], return_inverse=True)
        surface = FacetSurface(points[sites][used], base.reshape(-1, facets.shape[1]), name)
        fit = SmoothSurface(surface, points[sites], on_sites, used)
        out[name] = Placement(fit, _planes(points, facets, parts, chosen, own[name]))
    return out


def _sites(facets: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Nodes (n_sites,), each once for every part it is on, and facets in these numbers."""
    n = int(facets.max()) + 1
    key, number = np.unique(part[:, None] * n + facets, return_inverse=True)
    return key % n, number.reshape(facets.shape)


def sides_are_straight(points: Array, facets: IntArray) -> bool:
    """Whether the sides of facets (n, 8) are chords of the arcs that their corners stand for."""
    normals = averaged_normals(points, facets[:, :4])[0]
    begin, end, middle = facets[:, :4], np.roll(facets[:, :4], -1, axis=1), facets[:, 4:8]
    real = begin != end
    chord = points[end] - points[begin]
    arc = np.einsum("nai,nai->na", chord, normals[end] - normals[begin])[real] / 8
    off = points[middle] - points[begin] - chord / 2
    height = np.einsum("nai,nai->na", off, normals[begin] + normals[end])[real] / 2
    return bool((height**2).sum() <= STRAIGHT**2 * (arc**2).sum())


def bordering(mesh: Mesh, name: str) -> Array:
    """Planes (n_planes, 4) of flat outer faces that are not part of a boundary and share a node with it."""
    skin = mesh.outer
    facets = mesh.face_nodes(skin)[:, :8]
    own = np.isin(skin @ np.array([6, 1]), mesh.faces(name) @ np.array([6, 1]))
    return _planes(mesh.points, facets, smooth_parts(mesh.points, facets, mesh.hanging), own, own & False)


def _planes(points: Array, facets: IntArray, parts: SmoothParts, curved: Mask, own: Mask) -> Array:
    """Planes (n_planes, 4) of flat facets that share a node with curved ones, or are among some own ones."""
    touched = np.zeros(len(points), bool)
    touched[facets[curved]] = True
    near = parts.flat & (touched[facets].any(axis=1) & ~curved | own)
    _, first = np.unique(parts.part[near], return_index=True)
    return parts.planes(points, facets)[near][first]
