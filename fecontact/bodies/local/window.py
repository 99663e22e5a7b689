"""Window of a local body: the tangent plane round the contact, its cells, and nodes for smooth functions on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.bodies.halfspace.grid import Grid
from fecontact.bodies.halfspace.symmetry import Even, part_of
from fecontact.common.arrays import Array


@dataclass(frozen=True, eq=False)
class Window:
    """A rectangle on the tangent plane of a body's surface, in cells.

    Attributes
    ----------
    origin : (3,) array
        Its middle, on the surface, in the body's axes.
    axes : (3, 3) array
        Columns: its two directions and the outward normal, right-handed.
    grid : Grid
        Its cells, those beyond planes of symmetry too.
    mirrored : (bool, bool)
        Directions whose middle is a plane of symmetry of the body; the body has the positive side.

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
    def cells(self) -> Array:
        """Centres (n_cells, 3) of the modelled cells, in the body's axes."""
        return self.at(*(c.ravel() for c in np.meshgrid(*self.along, indexing="ij")))

    def at(self, x: Array, y: Array) -> Array:
        """Points (n, 3) in the body's axes of coordinates on the plane."""
        return self.origin + np.stack([x, y], axis=-1) @ self.axes[:, :2].T

    def coordinates(self, points: Array) -> Array:
        """Coordinates (..., 3) along its directions and the outward normal, of points in the body's axes."""
        return (points - self.origin) @ self.axes


def chebyshev(half: float, order: int, mirrored: bool) -> Array:
    """Chebyshev nodes on (-half, half), increasing; of an even number, the positive ones where it is mirrored.

    Examples
    --------
    >>> chebyshev(1.0, 2, True).round(4).tolist()
    [0.7071]
    """
    x = -half * np.cos(np.pi * (np.arange(order) + 0.5) / order)
    return np.asarray(x[order // 2 :] if mirrored else x)


def polynomials(x: Array, half: float, order: int, mirrored: bool) -> Array:
    """Chebyshev polynomials (n, k) of x / half below an order; where it is mirrored, the even ones.

    Examples
    --------
    >>> polynomials(np.array([0.5]), 1.0, 4, True).round(12).tolist()
    [[1.0, -0.5]]
    """
    degree = np.arange(0, order, 2 if mirrored else 1)
    return np.asarray(np.cos(degree * np.arccos(np.clip(x / half, -1.0, 1.0))[:, None]))


def coefficients(half: float, order: int, mirrored: bool) -> Array:
    """Matrix (k, k) from values at `chebyshev` nodes to the coefficients of `polynomials`.

    Source: discrete orthogonality at the zeros of T_order (J. C. Mason, D. C. Handscomb, Chebyshev Polynomials, 2003,
    section 4.6).

    Examples
    --------
    >>> values = chebyshev(2.0, 4, False) ** 2
    >>> bool(np.allclose(coefficients(2.0, 4, False) @ values, [2.0, 0.0, 2.0, 0.0]))
    True
    """
    T = polynomials(chebyshev(half, order, mirrored), half, order, mirrored)
    scale = np.full(T.shape[1], 2.0 / len(T))
    scale[0] /= 2
    return np.asarray(scale[:, None] * T.T)


def interpolation(x: Array, half: float, order: int, mirrored: bool) -> Array:
    """Matrix (n, k) from values at `chebyshev` nodes to the interpolating polynomial at x (n,).

    Examples
    --------
    >>> x = np.array([0.3, 1.5])
    >>> (interpolation(x, 2.0, 3, False) @ chebyshev(2.0, 3, False) ** 2).round(12).tolist()
    [0.09, 2.25]
    """
    return np.asarray(polynomials(x, half, order, mirrored) @ coefficients(half, order, mirrored))
