"""Window of a local body: the tangent plane round the contact, its cells, and nodes for smooth functions on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.bodies.halfspace.grid import Grid
from fecontact.bodies.halfspace.symmetry import Even, part_of
from fecontact.bodies.local.chebyshev import nodes
from fecontact.bodies.local.relief import Relief
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array

OPPOSITE = 1e-10
"""Difference of the axes of two windows, and of their middles relative to their size, that is rounding."""


@dataclass(frozen=True, eq=False)
class Window:
    """A rectangle on the tangent plane of a body's surface, in cells.

    Attributes
    ----------
    origin : (3,) array
        Its middle, on the surface, in the body's axes.
    axes : (3, 3) array
        Columns: its two directions and the outward normal; left-handed for a window that faces another one.
    grid : Grid
        Its cells, those beyond planes of symmetry too.
    mirrored : (bool, bool)
        Directions whose middle is a plane of symmetry of the body; the body has the positive side.
    relief : Relief, optional
        Depth of the surface below the plane, for slopes and curvatures; None for a flat surface.
    depths : (n_cells,) array, optional
        Depths of the surface at the modelled cells, as it is.

    Examples
    --------
    >>> window = Window(np.zeros(3), np.eye(3), Grid((2.0, 1.0), (4, 2)), (True, False))
    >>> window.shape, window.cells[0].tolist()
    ((2, 2), [0.25, -0.25, 0.0])
    """

    origin: Array
    axes: Array
    grid: Grid
    mirrored: Even
    relief: Relief | None = None
    depths: Array | None = None

    @property
    def normal(self) -> Array:
        """Outward normal (3,) of the tangent plane."""
        return self.axes[:, 2]

    @property
    def half(self) -> Array:
        """Half the sides (2,) of the whole window."""
        return np.array(self.grid.size) / 2

    @cached_property
    def along(self) -> tuple[Array, Array]:
        """Coordinates (nx,) and (ny,) of the modelled cells along either direction."""
        part = part_of(self.grid.shape, self.mirrored)
        return self.grid.x[part[0]], self.grid.y[part[1]]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of modelled cells."""
        return len(self.along[0]), len(self.along[1])

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """Coordinates (n_cells,) of the modelled cells on the plane."""
        x, y = np.meshgrid(*self.along, indexing="ij")
        return x.ravel(), y.ravel()

    @cached_property
    def cells(self) -> Array:
        """Centres (n_cells, 3) of the modelled cells on the surface, in the body's axes."""
        plane = self.at(*self.places)
        return plane if self.depths is None else plane - self.depths[:, None] * self.normal

    def node_places(self, order: int) -> tuple[Array, Array]:
        """Coordinates (k,) on the plane of the Chebyshev nodes of an order, see `chebyshev`."""
        along = (nodes(b, order, even) for b, even in zip(self.half, self.mirrored, strict=True))
        x, y = np.meshgrid(*along, indexing="ij")
        return x.ravel(), y.ravel()

    def at(self, x: Array, y: Array) -> Array:
        """Points (n, 3) of the plane in the body's axes."""
        return self.origin + np.stack([x, y], axis=-1) @ self.axes[:, :2].T

    def on_surface(self, x: Array, y: Array) -> Array:
        """Points (n, 3) of the surface, smoothed by its relief, in the body's axes."""
        plane = self.at(x, y)
        return plane if self.relief is None else plane - self.relief.depth(x, y)[..., None] * self.normal

    def faces(self, other: Window, pose: Pose) -> bool:
        """Whether its cells lie opposite those of another window, whose axes have a pose in its own."""
        if self.grid != other.grid or self.mirrored != other.mirrored:
            return False
        axes = pose.rotation @ other.axes * np.array([1.0, 1.0, -1.0])
        aside = (pose.to_world(other.origin[None])[0] - self.origin) @ self.axes[:, :2]
        return bool(np.abs(axes - self.axes).max() <= OPPOSITE and (np.abs(aside) <= OPPOSITE * self.half).all())

    def coordinates(self, points: Array) -> Array:
        """Coordinates (..., 3) along its directions and the outward normal, of points in the body's axes."""
        return (points - self.origin) @ self.axes
