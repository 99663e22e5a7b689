"""Rims of contact surfaces: sharp edges of the body, or limits of the declared boundary only.

A contact may end at a body's sharp edge. Where the body continues smoothly beyond the rim of the declared boundary, a
contact that reaches the rim is truncated: its area is too small and its pressures are too high.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.layer import ElasticLayer
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.halfspace.grid import GridSurface
from fecontact.mesh.facets import sides_of, unit_vectors
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.pick import neighbouring_sides
from fecontact.mesh.section_mesh import SectionMesh, line_shapes
from fecontact.mesh.smooth_parts import SMOOTH
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.section_curve import CurveSurface

#: Points along a side of a rim used to find near sides, and the number of them examined.
ALONG, NEAREST = 5, 8
#: Relative rounding of distances.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Rim:
    """Sides at the rim of a surface, in the body's axes.

    Attributes
    ----------
    nodes : (n, 2) int array
        Nodes at the ends of the sides; equal on a section, where a rim consists of points.
    ends : (n, 2, 3) array
        Their positions.
    size : (n,) array
        Sizes of their faces.
    found : function
        Function for `smooth`, which is rarely needed.
    """

    nodes: IntArray
    ends: Array
    size: Array
    found: Callable[[], Mask]

    @cached_property
    def smooth(self) -> Mask:
        """Whether the body continues smoothly beyond each side (n,)."""
        return self.found()

    def within(self, points: Array, reach: Array, chosen: Mask, face: float = 0.0) -> Mask:
        """Mask of points (n, 3) within `reach` (n,) or `face` times the local face size of chosen sides.

        The sides examined are the nearest by points spread over them.
        """
        if not chosen.any():
            return np.zeros(len(points), bool)
        a, along = self.ends[chosen, 0], self.ends[chosen, 1] - self.ends[chosen, 0]
        t = (np.arange(ALONG)[:, None] + 0.5) / ALONG
        spread = (a[:, None] + t * along[:, None]).reshape(-1, 3)
        side = cKDTree(spread).query(points, k=min(NEAREST, len(spread)))[1].reshape(len(points), -1) // ALONG
        offset, d = points[:, None] - a[side], along[side]
        square = (d**2).sum(axis=2)
        where = np.divide((offset * d).sum(axis=2), square, out=np.zeros_like(square), where=square > 0)
        far = np.linalg.norm(offset - np.clip(where, 0.0, 1.0)[..., None] * d, axis=2)
        limit = np.maximum(reach[:, None], face * self.size[chosen][side])
        return np.asarray((far <= (1 + ROUNDING) * limit).any(axis=1))


def rim_of_surface(body: Body, name: str) -> Rim | None:
    """The rim of an elastic body's contact surface; None for other bodies, closed surfaces and nodes alone."""
    surface = body.surface(name)
    if not isinstance(surface, FacetSurface) or surface.of_nodes:
        return None
    if isinstance(surface, CurveSurface):
        assert isinstance(body, ElasticBody)
        return _of_section(surface, body.mesh, name)  # type: ignore[arg-type]
    facet, side = surface.rim_sides
    if len(facet) == 0:
        return None
    nodes = np.stack([surface.facets[facet, side], surface.facets[facet, (side + 1) % 4]], axis=1)

    def smooth() -> Mask:
        if isinstance(surface, GridSurface):
            return np.full(len(nodes), not (isinstance(body, HalfSpace) and body.periodic))
        covered = body.surface_of if isinstance(body, ElasticLayer) else None
        mesh = covered[0] if isinstance(covered, tuple) else getattr(body, "mesh", None)
        return _goes_on(mesh, name, nodes) if isinstance(mesh, Mesh) else np.zeros(len(nodes), bool)

    return Rim(nodes, surface.points[nodes], surface.mean_facet_size[facet], smooth)


def _goes_on(mesh: Mesh, name: str, sides: IntArray) -> Mask:
    """Whether a mesh continues smoothly beyond sides (n, 2) of a boundary, given by their nodes."""
    outer = mesh.outer_faces
    first, second, cosine = neighbouring_sides(mesh, outer)
    number = outer @ np.array([6, 1])
    inside = np.isin(number, mesh.faces(name) @ np.array([6, 1]))
    across = (cosine >= SMOOTH) & (inside[first // 4] != inside[second // 4])
    facets, side = mesh.face_nodes(outer), np.concatenate([first[across], second[across]])
    ends = sides_of(facets).reshape(-1, 2)[side]
    n = len(mesh.points)
    return np.isin(np.sort(sides, axis=1) @ np.array([n, 1]), np.sort(ends, axis=1) @ np.array([n, 1]))


def _of_section(surface: CurveSurface, mesh: SectionMesh, name: str) -> Rim | None:
    """Ends of a section's boundary, except those on an axis of revolution."""
    ends, count = np.unique(surface.facets[:, :2], return_counts=True)
    ends = ends[count == 1]
    if surface.out_of_plane.revolved:
        ends = ends[surface.points[ends, 0] > 1e-9 * surface.size]
    if len(ends) == 0:
        return None
    mine = mesh.face_nodes(mesh.faces(name))
    outer = mesh.face_nodes(mesh.outer_sides)
    others = outer[~np.isin(outer[:, 2], mine[:, 2])]
    smooth, size = np.zeros(len(ends), bool), np.zeros(len(ends))
    for k, node in enumerate(ends):  # usually two
        own = surface.facets[(surface.facets[:, :2] == node).any(axis=1)]
        beyond = others[(others[:, :2] == node).any(axis=1)]
        size[k] = np.linalg.norm(np.diff(surface.points[own[0, :2]], axis=0))
        smooth[k] = len(beyond) > 0 and float(_tangent(mesh, own[0], node) @ _tangent(mesh, beyond[0], node)) >= SMOOTH
    nodes = np.stack([ends, ends], axis=1)
    return Rim(nodes, surface.points[nodes], size, lambda: smooth)


def _tangent(mesh: SectionMesh, side: IntArray, node: int) -> Array:
    """Unit tangent (3,) of a side at one of its ends."""
    _, dN = line_shapes(np.array([0.0 if side[0] == node else 1.0]))
    t = dN[0] @ mesh.points[side]
    return np.asarray(t / np.linalg.norm(t))


def ends_near(body: Body, name: str, points: Array, normals: Array, size: Array) -> Mask:
    """Whether a rigid surface ends within `size` (n,) of points (n, 3), tangentially to normals (n, 3); in its axes."""
    surface = body.surface(name)
    across = np.eye(3)[np.abs(normals).argmin(axis=1)]
    one = np.cross(normals, across)
    one = unit_vectors(one)
    two = np.cross(normals, one)
    turn = np.arange(8)[:, None, None] * np.pi / 4
    around = points + size[:, None] * (np.cos(turn) * one + np.sin(turn) * two)
    return np.asarray(surface.project(around.reshape(-1, 3)).outside.reshape(8, -1).any(axis=0))
