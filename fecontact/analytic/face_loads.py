"""Point loads on the face of a body, each with the fields of the half-space below its own tangent plane.

Loads act at points of a smooth face in any direction. Near a load the face is its tangent plane, up to its curvature,
and the fields are Boussinesq's and Cerruti's in the axes of that plane, with the first effect of the curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic import boussinesq, curvature_field
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

#: How far points may lie above the tangent plane of a load, as a share of their distance from it.
ABOVE = 0.95


@dataclass(frozen=True, eq=False)
class FaceLoads:
    """Point loads at places of a face, with the tangent planes there.

    Parameters
    ----------
    places : numpy.ndarray, shape (m, 3)
        Where the loads act.
    normals : numpy.ndarray, shape (m, 3)
        Normals of the face into the body, of any length but zero.
    forces : numpy.ndarray, shape (m, 3)
        Loads on the body, in global axes.
    curvatures : numpy.ndarray, shape (m, 3, 3), optional
        Curvature tensors of the face at the places, in global axes, convex positive: of a ball (I - n n^T)/radius. What
        a tensor has along the normal is not used. A plane face unless given.
    length : float, optional
        Unit of length in the logarithm of the curved face's displacement, needed with curvatures. It changes the
        displacements of a load by a translation.

    Raises
    ------
    InputError
        If the shapes differ, a normal has no length, or curvatures are given without a length.

    Examples
    --------
    >>> FaceLoads(np.zeros((1, 3)), np.array([[0, 0, -2.0]]), np.array([[0, 0, -1.0]])).axes[0, 2]
    array([ 0.,  0., -1.])
    """

    places: Array
    normals: Array
    forces: Array
    curvatures: Array | None = None
    length: float | None = None

    def __post_init__(self) -> None:
        shapes = {checks.point_array(n, getattr(self, n), 3).shape for n in ("places", "normals", "forces")}
        if len(shapes) > 1 or len(next(iter(shapes))) != 2:
            raise InputError(f"Expected places, normals and forces of one shape (m, 3); found {sorted(shapes)}.")
        if not np.all(np.linalg.norm(self.normals, axis=1) > 0):
            raise InputError("Expected normals into the body; found one of length zero.", code="normal-zero")
        if self.curvatures is None:
            return
        if self.curvatures.shape != (*self.places.shape, 3):
            raise InputError(f"Expected curvatures {(*self.places.shape, 3)}; found {self.curvatures.shape}.")
        if self.length is None:
            raise InputError("Expected length= with curvatures, such as the size of the contact; found None.")
        checks.lengths(length=self.length)

    @property
    def axes(self) -> Array:
        """Orthonormal axes of the tangent planes as rows, shape (m, 3, 3): two tangents, the normal into the body."""
        return tangent_axes(self.normals)


def tangent_axes(normals: Array) -> Array:
    """Return right-handed orthonormal axes to normals: two tangents and the unit normal.

    Parameters
    ----------
    normals : numpy.ndarray, shape (m, 3)
        Of any length but zero.

    Returns
    -------
    numpy.ndarray, shape (m, 3, 3)
        Axes as rows. The first tangent lies in the plane of the normal and of x, or of y where the normal is within 45
        degrees of x, so that nothing cancels.

    Examples
    --------
    >>> tangent_axes(np.array([[0.0, 0.0, 2.0]]))[0]
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    normal = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    guide = np.where(normal[:, :1] ** 2 < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = guide - (guide * normal).sum(axis=-1, keepdims=True) * normal
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normal, first), normal], axis=-2)


def fields(points: ArrayLike, loads: FaceLoads, material: Material) -> tuple[Array, Array]:
    """Return displacements and stresses of each load at each point.

    Parameters
    ----------
    points : array_like, shape (n, 3)
        In global axes; not at a load.
    loads : FaceLoads
        The m loads.
    material : Material
        Material of the body.

    Returns
    -------
    displacement : numpy.ndarray, shape (m, n, 3)
        In global axes, relative to points at infinity.
    stress : numpy.ndarray, shape (m, n, 3, 3)
        In global axes, tension positive.

    Raises
    ------
    InputError
        If a point is a place of a load, or lies above the tangent plane of a load by more than 0.95 of its distance:
        the fields, continued above their plane, are singular over the load.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, chapter 3; `curvature_field`.

    Examples
    --------
    >>> load = FaceLoads(np.zeros((1, 3)), np.array([[0, 0, -1.0]]), np.array([[0, 0, -np.pi]]))
    >>> fields([[1.0, 0.0, 0.0]], load, Material(1.0, 0.0))[0].round(6)
    array([[[-0.5,  0. , -1. ]]])
    """
    return displacements(points, loads, material), stresses(points, loads, material)


def displacements(points: ArrayLike, loads: FaceLoads, material: Material) -> Array:
    """Return displacements (m, n, 3) of each load at each point alone, see `fields`.

    Examples
    --------
    >>> load = FaceLoads(np.zeros((1, 3)), np.array([[0, 0, -1.0]]), np.array([[0, 0, -np.pi]]))
    >>> displacements([[1.0, 0.0, 0.0]], load, Material(1.0, 0.0)).round(6)
    array([[[-0.5,  0. , -1. ]]])
    """
    axes, local, forces, bent = _in_tangent_planes(points, loads)
    u = boussinesq.displacement(local, force=forces, material=material, above=ABOVE)
    if bent is not None and loads.length is not None:
        more = curvature_field.displacement(local, force=forces, curvature=bent, length=loads.length, material=material)
        u = u + more
    return u @ axes


def stresses(points: ArrayLike, loads: FaceLoads, material: Material) -> Array:
    """Return stresses (m, n, 3, 3) of each load at each point alone, see `fields`.

    Examples
    --------
    >>> load = FaceLoads(np.zeros((1, 3)), np.array([[0, 0, -1.0]]), np.array([[0, 0, -2 * np.pi]]))
    >>> stresses([[0.0, 0.0, -1.0]], load, Material(1.0, 0.25))[0, 0].diagonal()
    array([ 0.25,  0.25, -3.  ])
    """
    axes, local, forces, bent = _in_tangent_planes(points, loads)
    sigma = boussinesq.stress(local, force=forces, material=material, above=ABOVE)
    if bent is not None:
        sigma = sigma + curvature_field.stress(local, force=forces, curvature=bent, material=material)
    return np.asarray(np.swapaxes(axes, -1, -2)[:, None] @ sigma @ axes[:, None])


def _in_tangent_planes(points: ArrayLike, loads: FaceLoads) -> tuple[Array, Array, Array, Array | None]:
    """Axes (m, 3, 3) of the loads, and in them points (m, n, 3), forces (m, 1, 3) and curvatures (m, 1, 2, 2)."""
    axes = loads.axes
    local = (checks.point_array("points", points, 3) - loads.places[:, None]) @ np.swapaxes(axes, -1, -2)
    forces = (axes @ loads.forces[..., None])[:, None, :, 0]
    if loads.curvatures is None:
        return axes, local, forces, None
    return axes, local, forces, (axes @ loads.curvatures @ np.swapaxes(axes, -1, -2))[:, None, :2, :2]
