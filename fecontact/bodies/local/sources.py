"""Point loads at the nodes of a window: Boussinesq's fields in a half-space of the body's material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.analytic import boussinesq
from fecontact.bodies.halfspace.symmetry import Even
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

ABOVE = 1e-7
"""Height over the tangent plane, relative to the distance from the load, that counts as rounding."""


@dataclass(frozen=True, eq=False)
class Source:
    """A unit load into a body at a point of its surface, with its mirror images in planes of symmetry.

    Attributes
    ----------
    points : (n, 3) array
        The point and its images.
    frames : (n, 3, 3) arrays
        Columns: two tangents and the direction into the body, in which the load acts.
    material : Material
    """

    points: Array
    frames: Array
    material: Material

    def displacement(self, x: Array) -> Array:
        """Displacements (..., 3) of a half-space below the tangent plane at points (..., 3)."""
        out = np.zeros(x.shape)
        for point, frame in zip(self.points, self.frames, strict=True):
            u = boussinesq.displacement(below(x, point, frame), force=(0.0, 0.0, 1.0), material=self.material)
            out += u @ frame.T
        return out

    def traction(self, x: Array, normals: Array) -> Array:
        """Tractions (..., 3) of that half-space on areas with normals (..., 3), of any length, at points (..., 3)."""
        out = np.zeros(x.shape)
        for point, frame in zip(self.points, self.frames, strict=True):
            stress = boussinesq.stress(below(x, point, frame), force=(0.0, 0.0, 1.0), material=self.material)
            out += np.einsum("...ij,...j->...i", stress, normals @ frame) @ frame.T
        return out


def below(x: Array, point: Array, frame: Array) -> Array:
    """Coordinates in a frame whose third axis points into the body; rounding above the plane is cut off.

    Raises
    ------
    InputError
        If the body reaches above the tangent plane.
    """
    local = (x - point) @ frame
    if (local[..., 2] < -ABOVE * np.linalg.norm(local, axis=-1)).any():
        worst = x.reshape(-1, 3)[np.argmin(local[..., 2])]
        raise InputError(
            f"The body reaches above the tangent plane of its window, at {np.array2string(worst, precision=4)} by "
            f"{-float(local[..., 2].min()):.3g}: a half-space is no start for it. Use an ElasticBody there, with "
            "accuracy= when the scene is solved."
        )
    local[..., 2] = np.maximum(local[..., 2], 0.0)
    return local


def images(points: Array, frame: Array, origin: Array, axes: Array, mirrored: Even) -> tuple[Array, Array]:
    """A point's mirror images about the middle of a window, itself the first, with mirrored frames.

    Parameters
    ----------
    points : (3,) array
    frame : (3, 3) array
    origin, axes : (3,) and (3, 3) arrays
        Middle and directions of the window.
    mirrored : (bool, bool)

    Returns
    -------
    points : (n, 3) array
    frames : (n, 3, 3) array

    Examples
    --------
    >>> images(np.array([1.0, 2.0, 0.0]), np.eye(3), np.zeros(3), np.eye(3), (True, False))[0].tolist()
    [[1.0, 2.0, 0.0], [-1.0, 2.0, 0.0]]
    """
    where, frames = [points], [frame]
    for axis in (0, 1):
        if mirrored[axis]:
            mirror = np.eye(3) - 2 * np.outer(axes[:, axis], axes[:, axis])
            where += [origin + mirror @ (p - origin) for p in where]
            frames += [mirror @ f for f in frames]
    return np.array(where), np.array(frames)
