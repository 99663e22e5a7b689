"""Boundary names by picking: outer faces on a plane, in a box, facing a direction, near another body, up to an edge.

Picks combine with ``&``, ``|`` and ``~`` and go into `Mesh.with_boundary`.

Examples
--------
>>> import fecontact as fc
>>> from fecontact.mesh import pick
>>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
>>> left = pick.facing((0, 0, 1)) & pick.box((0, 0, 0), (0.5, 1, 1))
>>> len(mesh.with_boundary("left half of the top", left).faces("left half of the top"))
2
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.common.checks import coordinates, number, positive, vector
from fecontact.common.errors import InputError, shown
from fecontact.mesh.facets import (
    components,
    edge_keys,
    facet_centres,
    facet_shapes,
    found,
    shapes_on_square,
    sides_of,
    triangular,
)
from fecontact.mesh.hanging_nodes import HangingNodes

__all__ = ["Pick", "box", "facing", "flood", "near", "plane"]


def __dir__() -> list[str]:
    """The public names."""
    return __all__


#: Points along each side of a facet used to measure the distance from it.
SAMPLES = 8


class Faces(Protocol):
    """The members of a mesh that a pick uses."""

    @property
    def points(self) -> Array:
        """Coordinates (n_points, 3)."""

    @property
    def hanging(self) -> HangingNodes | None:
        """Hanging nodes, if there are any."""

    def face_nodes(self, faces: IntArray) -> IntArray:
        """Nodes (n, k) of faces (n, 2)."""


@dataclass(frozen=True)
class Pick:
    """A selection of outer faces of a mesh.

    Attributes
    ----------
    chosen : callable
        ``chosen(mesh, faces (n, 2)) -> (n,) bool``.
    """

    chosen: Callable[[Faces, IntArray], Mask]

    def __and__(self, other: Pick) -> Pick:
        return Pick(lambda mesh, faces: self.chosen(mesh, faces) & other.chosen(mesh, faces))

    def __or__(self, other: Pick) -> Pick:
        return Pick(lambda mesh, faces: self.chosen(mesh, faces) | other.chosen(mesh, faces))

    def __invert__(self) -> Pick:
        return Pick(lambda mesh, faces: ~self.chosen(mesh, faces))


def _unit(direction: ArrayLike, what: str) -> Array:
    d = vector(f"the {what}", direction)
    length = np.linalg.norm(d)
    if length == 0:
        raise InputError(f"The {what} must be three finite numbers, not all zero; found {direction!r}.")
    return d / length


def _cosine(angle: float) -> float:
    """Cosine of an angle in degrees."""
    if not 0 <= number(angle) <= 180:
        raise InputError(f"The angle must lie between 0 and 180 degrees; found {shown(angle)}.")
    return float(np.cos(np.radians(angle)))


def _middles(mesh: Faces, faces: IntArray) -> tuple[Array, Array]:
    """Middles (n, 3) of faces and their outward unit normals there."""
    facets = mesh.face_nodes(faces)
    triangle = triangular(facets)
    N, dN = facet_shapes(facets.shape[1], triangle, facet_centres(triangle))
    x = mesh.points[facets]
    return np.einsum("na,nai->ni", N, x), _unit_normals(x, dN)


def _unit_normals(x: Array, dN: Array) -> Array:
    """Unit normals (n, 3) of facets with nodes x (n, k, 3) where their functions have the slopes dN (n, k, 2)."""
    t = np.einsum("naj,nai->nij", dN, x)
    normal = cross(t[:, :, 0], t[:, :, 1])
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def plane(point: ArrayLike, normal: ArrayLike, tolerance: float | None = None) -> Pick:
    """Faces with all nodes on a plane.

    Parameters
    ----------
    point, normal : three numbers
        A point of the plane and its normal, either way.
    tolerance : float, optional
        Largest distance from the plane; a millionth of the mesh's size unless given.
    """
    p, n = vector("the point of the plane", point), _unit(normal, "normal of the plane")
    width = None if tolerance is None else positive("the tolerance", tolerance)

    def chosen(mesh: Faces, faces: IntArray) -> Mask:
        near = 1e-6 * np.linalg.norm(np.ptp(mesh.points, axis=0)) if width is None else width
        on = np.asarray(np.abs((mesh.points - p) @ n) <= near)
        return np.asarray(on[mesh.face_nodes(faces)].all(axis=1))

    return Pick(chosen)


def box(low: ArrayLike, high: ArrayLike) -> Pick:
    """Faces with all nodes in a box between two opposite corners, with a tolerance for rounding."""
    a, b = vector("the lower corner", low), vector("the upper corner", high)
    if (a > b).any():
        raise InputError(f"The lower corner must not exceed the upper one; found {low!r} and {high!r}.")

    def chosen(mesh: Faces, faces: IntArray) -> Mask:
        slack = 1e-9 * np.linalg.norm(np.ptp(mesh.points, axis=0))
        inside = np.asarray(((mesh.points >= a - slack) & (mesh.points <= b + slack)).all(axis=1))
        return np.asarray(inside[mesh.face_nodes(faces)].all(axis=1))

    return Pick(chosen)


def facing(direction: ArrayLike, angle: float = 30.0) -> Pick:
    """Faces whose outward normal in their middle lies within `angle` (degrees) of a direction."""
    d, least = _unit(direction, "direction"), _cosine(angle)

    def chosen(mesh: Faces, faces: IntArray) -> Mask:
        normals = _middles(mesh, faces)[1]
        return np.asarray(normals @ d >= least)

    return Pick(chosen)


def near(other: Any, distance: float) -> Pick:
    """Faces whose middle is closer than `distance` to something else.

    Parameters
    ----------
    other : Mesh, SurfaceMesh, surface with ``project``, or (n, 3) array
        A mesh counts by its outer faces, points by the nearest one; all in the axes of the picked mesh. Meshes and
        surface meshes are measured at points spread over their facets, a seventh of a side apart; a surface with
        ``project``, such as `ElasticBody.surface`, exactly.
    distance : float
    """
    positive("the distance", distance)

    def chosen(mesh: Faces, faces: IntArray) -> Mask:
        middles, _ = _middles(mesh, faces)
        return np.asarray(_distance(middles, other) <= distance)

    return Pick(chosen)


def _distance(points: Array, other: Any) -> Array:
    """Distance (n,) from points to a surface or to other points."""
    if hasattr(other, "project"):
        return np.linalg.norm(points - other.project(points).points, axis=1)
    if hasattr(other, "outer_faces"):
        cloud = _spread(other.points, other.face_nodes(other.outer_faces))
    elif hasattr(other, "facets"):
        cloud = _spread(other.points, other.facets)
    else:
        cloud = coordinates("other", other)
    if cloud.ndim != 2 or cloud.shape[1] != 3 or not len(cloud):
        raise InputError(f"Expected a mesh, a surface or points of shape (n, 3); found {type(other).__name__}.")
    return cKDTree(cloud).query(points)[0]


def _spread(points: Array, facets: IntArray) -> Array:
    """Points (n, 3) spread over facets."""
    t = np.linspace(0.0, 1.0, SAMPLES)
    N, _ = shapes_on_square(facets, np.stack(np.meshgrid(t, t), axis=-1).reshape(-1, 2))
    return (N @ points[facets]).reshape(-1, 3)


def flood(seed: ArrayLike, angle: float = 30.0) -> Pick:
    """Faces connected to the one nearest to `seed` without crossing an edge sharper than `angle` degrees.

    The angle is that between the normals of neighbouring faces at the middle of their common side.
    """
    start, least = vector("the seed", seed), _cosine(angle)

    def chosen(mesh: Faces, faces: IntArray) -> Mask:
        first, second, cosine = neighbouring_sides(mesh, faces)
        first, second = first // 4, second // 4
        smooth = cosine >= least
        part = components(len(faces), np.stack([first, second], axis=1)[smooth])
        middles, _ = _middles(mesh, faces)
        nearest = np.argmin(np.linalg.norm(middles - start, axis=1))
        return np.asarray(part == part[nearest])

    return Pick(chosen)


def neighbouring_sides(mesh: Faces, faces: IntArray) -> tuple[IntArray, IntArray, Array]:
    """`shared_sides` of some faces of a mesh."""
    return shared_sides(mesh.points, mesh.face_nodes(faces), mesh.hanging)


def shared_sides(
    points: Array, facets: IntArray, hanging: HangingNodes | None = None
) -> tuple[IntArray, IntArray, Array]:
    """Sides shared by two facets, as 4 facet + side of each, and the cosine between the normals at their middles.

    With hanging nodes, a side divided by two other facets is shared with each of them.
    """
    ends = sides_of(facets).reshape(-1, 2)
    normals = side_normals(points, facets, triangular(facets)).reshape(-1, 3)
    keys, half = edge_keys(ends), np.zeros(len(ends), bool)
    if hanging is not None:
        divided = hanging.edges[found(edge_keys(hanging.edges[:, [0, 2]]), keys) >= 0]
        part = found(keys, edge_keys(divided[:, [[0, 1], [1, 2]]]).ravel())
        half = part >= 0
        keys[half] = edge_keys(divided[part[half] // 2][:, [0, 2]])
    real = np.flatnonzero(ends[:, 0] != ends[:, 1])
    # the undivided side comes first, the others are paired with it
    order = real[np.lexsort((half[real], keys[real]))]
    start = np.concatenate([[True], keys[order[1:]] != keys[order[:-1]]])
    first = order[np.flatnonzero(start)][np.cumsum(start) - 1]
    a, b = first[~start], order[~start]
    return a, b, np.einsum("ni,ni->n", normals[a], normals[b])


def side_normals(points: Array, facets: IntArray, triangle: Mask) -> Array:
    """Unit normals (n_facets, 4, 3) of facets at the middles of their sides; the third of a triangle is meaningless."""
    quad = np.array([[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]])
    tri = np.array([[0.5, 0.0], [0.5, 0.5], [0.25, 0.25], [0.0, 0.5]])
    out = np.empty((len(facets), 4, 3))
    for side in range(4):
        _, dN = facet_shapes(facets.shape[1], triangle, np.where(triangle[:, None], tri[side], quad[side]))
        out[:, side] = _unit_normals(points[facets], dN)
    return out
