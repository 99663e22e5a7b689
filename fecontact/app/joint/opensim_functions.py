"""Functions in models of OpenSim: lines, polynomials, splines through points, and multiples of them.

The spline (SimmSpline, called NaturalCubicSpline in files of version 2) is that of Forsythe, Malcolm & Moler, Computer
Methods for Mathematical Computations (1977), chapter 4: cubic pieces with two continuous derivatives, whose third
derivative in the first and the last piece is that of the cubic through the first and the last four points. Beyond its
ends it goes on straight.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

Element = ElementTree.Element
Function = Callable[[Array], Array]


@dataclass(frozen=True)
class Line:
    """slope * q + constant."""

    slope: float
    constant: float

    def __call__(self, q: Array) -> Array:
        """Values (n,)."""
        return self.slope * q + self.constant


@dataclass(frozen=True, eq=False)
class Pieces:
    """A function (n,) -> (n,) through points x, y, and its slopes at both ends, along which it goes on."""

    x: Array
    y: Array
    inside: Function
    slopes: tuple[float, float]

    def __call__(self, q: Array) -> Array:
        """Values (n,)."""
        below, above = np.minimum(q - self.x[0], 0.0), np.maximum(q - self.x[-1], 0.0)
        within = np.clip(q, self.x[0], self.x[-1])
        return np.asarray(self.inside(within) + self.slopes[0] * below + self.slopes[1] * above)


def spline(x: Array, y: Array) -> Pieces:
    """The spline of Forsythe, Malcolm & Moler through points (n,); a line through two, a parabola through three.

    Examples
    --------
    >>> x = np.array([0.0, 1.0, 3.0, 4.0, 6.0])
    >>> cubic = spline(x, x**3)
    >>> cubic(np.array([2.0, 5.0, 7.0])).round(9).tolist()  # a cubic between the points, straight beyond them
    [8.0, 125.0, 324.0]
    """
    n, h, rise = len(x), np.diff(x), np.diff(y) / np.diff(x)
    # the second derivatives at the points
    A, b = np.zeros((n, n)), np.zeros(n)
    inner = np.arange(1, n - 1)
    A[inner, inner - 1], A[inner, inner], A[inner, inner + 1] = h[:-1], 2 * (h[:-1] + h[1:]), h[1:]
    b[inner] = 6 * np.diff(rise)
    for row, (first, last), four in ((0, (0, 1), slice(0, 4)), (n - 1, (n - 2, n - 1), slice(n - 4, n))):
        A[row, first], A[row, last] = -1.0, 1.0
        if n > 3:
            b[row] = h[first] * 6 * np.polyfit(x[four] - x[four].mean(), y[four], 3)[0]
    bends = np.linalg.solve(A, b) if n > 2 else b
    slopes = np.append(rise - h * (2 * bends[:-1] + bends[1:]) / 6, rise[-1] + h[-1] * (bends[-2] + 2 * bends[-1]) / 6)
    return Pieces(x, y, CubicHermiteSpline(x, y, slopes), (float(slopes[0]), float(slopes[-1])))


def function_of(element: Element, place: str) -> Function:
    """A function of one coordinate from its element.

    Raises
    ------
    InputError
        If it is not known.
    """
    kind = element.tag
    if kind in ("function", "Function") and len(element):
        return function_of(element[0], place)
    if kind == "Constant":
        return Line(0.0, float(element.findtext("value") or 0.0))
    if kind == "MultiplierFunction":
        scale, inner = float(element.findtext("scale") or 1.0), element.find("function")
        times = function_of(element[0] if inner is None else inner, place)
        return lambda q: scale * times(q)
    numbers = {tag: np.array((element.findtext(tag) or "").split(), dtype=float) for tag in ("coefficients", "x", "y")}
    if kind == "LinearFunction" and len(numbers["coefficients"]) == 2:
        return Line(*numbers["coefficients"].tolist())
    if kind == "PolynomialFunction" and len(numbers["coefficients"]):
        return lambda q: np.asarray(np.polyval(numbers["coefficients"], q))
    x, y = numbers["x"], numbers["y"]
    if kind in ("SimmSpline", "NaturalCubicSpline", "PiecewiseLinearFunction"):
        if len(x) < 2 or x.shape != y.shape or (np.diff(x) <= 0).any():
            raise InputError(f"{place}: expected points with growing x; found {len(x)} x and {len(y)} y.")
        if kind != "PiecewiseLinearFunction":
            return spline(x, y)
        ends = np.diff(y) / np.diff(x)
        return Pieces(x, y, lambda q: np.interp(q, x, y), (float(ends[0]), float(ends[-1])))
    raise InputError(
        f"{place}: the function {kind} is not known, or has other numbers than it needs; there are Constant, "
        "LinearFunction, PolynomialFunction, PiecewiseLinearFunction, SimmSpline and MultiplierFunction.",
        code="unknown-function",
    )
