"""Rigid surfaces given by heights on a grid, or by a function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from fecontact.common.arrays import Array
from fecontact.common.checks import check_magnitude, heights_on, number_array, positive, positives
from fecontact.common.errors import InputError
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.rigid.shapes import differences, nearest

OVERHANG = 1e-9
"""Share of a cell outside the map within which a point counts as on its rim."""


@dataclass(frozen=True, eq=False)
class HeightMap:
    """A surface z(x, y) given at the centres of equal cells, centred on the origin, its lowest point at z = 0.

    Parameters
    ----------
    z : (nx, ny) array
        Heights, finite.
    size : (float, float)
        Sides of the map.

    Notes
    -----
    On a grid with the same cells the heights are returned unchanged; elsewhere they are interpolated by a cubic spline.

    Examples
    --------
    >>> import numpy as np
    >>> surface = HeightMap(np.array([[3.0, 2.0], [2.0, 4.0]]), (2.0, 2.0))
    >>> surface.heights(np.array([[-0.5], [0.5]]), np.array([[-0.5, 0.5]])).tolist()
    [[1.0, 0.0], [0.0, 2.0]]
    """

    z: Array
    size_xy: tuple[float, float]

    def __post_init__(self) -> None:
        z = number_array("the heights", self.z)
        if z.ndim != 2 or min(z.shape, default=0) < 2:
            raise InputError(f"Heights must be an array (nx, ny) of at least 2 x 2 numbers; found shape {z.shape}.")
        if not np.isfinite(z).all():
            raise InputError(
                f"Heights must be finite; found {int((~np.isfinite(z)).sum())} that are not. Fill the holes first."
            )
        check_magnitude("the heights", z)
        object.__setattr__(self, "size_xy", positives("a height map's size", self.size_xy, 2))
        object.__setattr__(self, "z", z - z.min())

    @property
    def size(self) -> float:
        """Longer side."""
        return max(self.size_xy)

    @cached_property
    def _axes(self) -> tuple[Array, Array]:
        x, y = ((np.arange(n) - (n - 1) / 2) * (s / n) for n, s in zip(self.z.shape, self.size_xy, strict=True))
        return x, y

    @cached_property
    def _spline(self) -> scipy.interpolate.RectBivariateSpline:
        orders = [min(3, n - 1) for n in self.z.shape]
        return scipy.interpolate.RectBivariateSpline(*self._axes, self.z, kx=orders[0], ky=orders[1])

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together; infinite beyond the outermost cells."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        if self._is_own_grid(x, y):
            return self.z.copy()
        xs, ys = np.broadcast_arrays(x, y)
        inside = np.ones(xs.shape, bool)
        for c, n, s in zip((xs, ys), self.z.shape, self.size_xy, strict=True):
            inside &= np.abs(c) <= s / 2 * (1 + OVERHANG / n)
        return np.where(inside, self._spline.ev(xs, ys), np.inf)

    def _is_own_grid(self, x: Array, y: Array) -> bool:
        if x.shape != (self.z.shape[0], 1) or y.shape != (1, self.z.shape[1]):
            return False
        own = self._axes
        cell = min(s / n for s, n in zip(self.size_xy, self.z.shape, strict=True))
        return bool(np.abs(x[:, 0] - own[0]).max() < 1e-9 * cell and np.abs(y[0] - own[1]).max() < 1e-9 * cell)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3)."""

        def derivatives(x: Array, y: Array) -> tuple[Array, Array, Array, Array, Array]:
            s = self._spline
            return s.ev(x, y, 1, 0), s.ev(x, y, 0, 1), s.ev(x, y, 2, 0), s.ev(x, y, 1, 1), s.ev(x, y, 0, 2)

        if min(self.z.shape) <= 3:  # splines of lower order, whose second derivatives are not offered
            step = 1e-4 * min(s / n for s, n in zip(self.size_xy, self.z.shape, strict=True))
            return nearest(points, self.heights, differences(self.heights, step), self.size)
        return nearest(points, self.heights, derivatives, self.size)


@dataclass(frozen=True, eq=False)
class FunctionSurface:
    """A surface z = f(x, y).

    Parameters
    ----------
    function : function of x, y
        Takes and returns arrays; infinite where there is no surface.
    size : float
        A length over which it varies.

    Examples
    --------
    >>> import numpy as np
    >>> FunctionSurface(lambda x, y: x**2 + y**2, size=1.0).heights(np.array([1.0]), np.array([2.0])).tolist()
    [5.0]
    """

    function: Callable[[Array, Array], Array]
    size: float = 1.0

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"Expected a function of x and y; found {type(self.function).__name__}.")
        positive("a surface's size", self.size)

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        return heights_on("the function of a surface", self.function(x, y), np.broadcast_shapes(x.shape, y.shape))

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3)."""
        return nearest(points, self.heights, differences(self.heights, 1e-4 * self.size), self.size)
