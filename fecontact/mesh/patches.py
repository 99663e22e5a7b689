"""Patches of a meridian plane, interpolated between four curves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array

Curve = Callable[[Array], Array]


def coons(top: Curve, bottom: Curve, left: Curve, right: Curve) -> Callable[[Array, Array], Array]:
    """Transfinite interpolation of curves [0, 1] -> (rho, z); top and bottom run along s, left and right along t."""
    zero, one = np.zeros(1), np.ones(1)
    c00, c10, c01, c11 = top(zero), top(one), bottom(zero), bottom(one)

    def patch(s: Array, t: Array) -> Array:
        a, b = s[:, None], t[:, None]
        corners = (1 - a) * (1 - b) * c00 + a * (1 - b) * c10 + (1 - a) * b * c01 + a * b * c11
        blended = ((1 - b) * top(s) + b * bottom(s)) + ((1 - a) * left(t) + a * right(t)) - corners
        return np.where(b == 0, top(s), blended)  # keeps the relative accuracy of a small sagitta

    return patch


def line(start: ArrayLike, end: ArrayLike) -> Curve:
    """Straight line (rho, z) from `start` to `end` over [0, 1]."""
    p, q = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    return lambda x: (1 - x)[:, None] * p + x[:, None] * q


def sagitta(r: Array, radius: float) -> Array:
    """Depth of a sphere's surface below its pole's tangent plane, r^2/(R + sqrt(R^2 - r^2)), without cancellation."""
    return r**2 / (radius + np.sqrt(np.maximum((radius - r) * (radius + r), 0.0)))


def spherical(extent: float, radius: float) -> Curve:
    """Surface of a sphere from its pole out to the distance `extent` from the axis; flat if the radius is infinite."""

    def curve(s: Array) -> Array:
        r = s * extent
        return np.stack([r, np.zeros_like(r) if np.isinf(radius) else sagitta(r, radius)], 1)

    return curve


def beyond_45_degrees(radius: float) -> Curve:
    """Surface of a sphere from 45 degrees off its pole to the equator."""

    def curve(s: Array) -> Array:
        angle = np.pi / 4 * (1 + s)
        return radius * np.stack([np.sin(angle), 2 * np.sin(angle / 2) ** 2], 1)

    return curve
