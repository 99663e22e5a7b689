"""Closest points on a surface z = f(x, y) by Newton's method."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.surfaces.facet_surface import Projection

Heights = Callable[[Array, Array], Array]
Derivatives = Callable[[Array, Array], tuple[Array, Array, Array, Array, Array]]

MOST_STEPS = 60
SETTLED = 1e-14
"""Step, relative to the size of the surface, at convergence."""


def nearest(points: Array, heights: Heights, derivatives: Derivatives, size: float) -> Projection:
    """Projection of points (n, 3) on the surface of a rigid body that fills z >= f(x, y).

    Newton's method on half the squared distance, started vertically above or below, with Gauss-Newton's matrix where
    the Hessian is not positive definite. It finds the closest point for points near the surface, which are those that
    matter.

    Parameters
    ----------
    points : (n, 3) array
    heights : function of x, y
        Infinite where there is no surface.
    derivatives : function of x, y
        f_x, f_y, f_xx, f_xy, f_yy.
    size : float
        A length of the surface.

    Returns
    -------
    Feet
        Points outside the surface are marked.
    """
    X, Y, Z = points.T
    x, y = X.copy(), Y.copy()
    for _ in range(MOST_STEPS):
        f = heights(x, y)
        known = np.isfinite(f)
        f = np.where(known, f, 0.0)
        fx, fy, fxx, fxy, fyy = _finite(derivatives(x, y), known)
        lift = f - Z
        gx, gy = x - X + lift * fx, y - Y + lift * fy
        gauss = (1 + fx**2, fx * fy, 1 + fy**2)
        full = (gauss[0] + lift * fxx, gauss[1] + lift * fxy, gauss[2] + lift * fyy)
        good = (full[0] > 0.1) & (full[0] * full[2] - full[1] ** 2 > 0.1)
        a, b, c = (np.where(good, h, g) for h, g in zip(full, gauss, strict=True))
        det = a * c - b**2
        dx, dy = -(c * gx - b * gy) / det, -(a * gy - b * gx) / det
        x, y = x + dx, y + dy
        if max(float(np.abs(dx).max(initial=0.0)), float(np.abs(dy).max(initial=0.0))) <= SETTLED * size:
            break
    f = heights(x, y)
    outside = ~np.isfinite(f)
    f = np.where(outside, 0.0, f)
    fx, fy = _finite(derivatives(x, y)[:2], ~outside)
    normals = np.stack([fx, fy, -np.ones_like(fx)], axis=1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    projection = np.stack([x, y, f], axis=1)
    gap = np.einsum("ni,ni->n", points - projection, normals)
    return Projection(points - gap[:, None] * normals, normals, gap, outside)


def _finite(derivatives: Sequence[Array], known: Mask) -> list[Array]:
    """Derivatives with zeros off the surface, and at its rim, across which there are none."""
    return [np.where(known & np.isfinite(d), d, 0.0) for d in derivatives]


def differences(heights: Heights, step: float) -> Derivatives:
    """Derivatives of a function by central differences.

    Examples
    --------
    >>> import numpy as np
    >>> by = differences(lambda x, y: x**2 * y, 1e-3)
    >>> [round(float(d[0]), 6) for d in by(np.array([2.0]), np.array([3.0]))]
    [12.0, 4.0, 6.0, 4.0, 0.0]
    """

    def derivatives(x: Array, y: Array) -> tuple[Array, Array, Array, Array, Array]:
        h = step
        f = heights(x, y)
        e, w, n, s = heights(x + h, y), heights(x - h, y), heights(x, y + h), heights(x, y - h)
        ne, se, nw, sw = heights(x + h, y + h), heights(x + h, y - h), heights(x - h, y + h), heights(x - h, y - h)
        with np.errstate(invalid="ignore"):  # beyond the rim heights are infinite
            return (
                (e - w) / (2 * h),
                (n - s) / (2 * h),
                (e - 2 * f + w) / h**2,
                (ne - se - nw + sw) / (4 * h**2),
                (n - 2 * f + s) / h**2,
            )

    return derivatives
