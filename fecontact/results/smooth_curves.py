"""Smooth curves through scattered points in order: waves shorter than a length are removed, longer ones are kept.

Points at equal steps along the curve are replaced by those that minimise the sum of squared offsets and of squared
third differences (Whittaker 1923, *On a new method of graduation*; Eilers 2003, *A perfect smoother*). Of a wave of
length L the share 1 / (1 + (L0 / L)^6) is left, nearly all or nothing: with L0 half the circumference a circle keeps
98.5 % of its radius, with a fifth 99.994 %.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fecontact.common.arrays import Array, Mask
from fecontact.results.outline import Mirror

#: Length of a wave of which half is left, in steps of scatter, and at most as a share of a closed curve.
WAVE, LARGEST_SHARE = 3.0, 0.25
#: Points for each step of scatter, and on a curve at least.
DENSITY, FEWEST = 6, 24
#: Length beyond the ends of a stretch, in waves, by which it is continued.
CONTINUED = 3
#: Distance from a plane of symmetry, in steps, that is on it.
ON_PLANE = 1e-3
#: Order of the differences.
ORDER = 3


def smoothed(points: Array, smooth: Mask, step: Array, mirrors: Sequence[Mirror] = ()) -> tuple[Array, Mask]:
    """A closed curve with some stretches smoothed, and which of its segments these are.

    Parameters
    ----------
    points : (n, d) array
        In order; the first follows the last.
    smooth : (n,) bool array
        Whether the segment from a point to the next is to be smoothed. Ends of a stretch stay where they are.
    step : (n,) array
        Length of the scatter at each point, such as the size of a facet.
    mirrors : sequence of Mirror
        Planes of symmetry: a stretch that ends on one is smooth with its mirror image.

    Examples
    --------
    A circle of 24 facets, its points off by a tenth of a facet to either side in turn:

    >>> angle = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    >>> radius = 1 + 0.026 * (-1.0) ** np.arange(48)
    >>> circle = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    >>> found, _ = smoothed(circle, np.ones(48, bool), np.full(48, 0.26))
    >>> bool(np.ptp(np.linalg.norm(found, axis=1)) < 2e-3)
    True
    """
    if smooth.all():
        found = _graduated(np.concatenate([points, points[:1]]), np.append(step, step[0]), closed=True)
        return found, np.ones(len(found), bool)
    if not smooth.any():
        return points, smooth
    start = int(np.flatnonzero(~smooth)[0])
    points, smooth, step = np.roll(points, -start, axis=0), np.roll(smooth, -start), np.roll(step, -start)
    breaks = np.flatnonzero(np.diff(smooth.astype(int))) + 1
    parts, kinds = [], []
    for chosen in np.split(np.arange(len(points)), breaks):
        piece = points[chosen]
        if smooth[chosen[0]]:
            ends = np.append(chosen, (chosen[-1] + 1) % len(points))
            piece = _graduated(points[ends], step[ends], mirrors=mirrors)[:-1]
        parts.append(piece)
        kinds.append(np.full(len(piece), smooth[chosen[0]]))
    return np.concatenate(parts), np.concatenate(kinds)


def _graduated(points: Array, step: Array, *, closed: bool = False, mirrors: Sequence[Mirror] = ()) -> Array:
    """Smoothed points (k, d) at equal steps along a polyline (n, d); of a closed one without the last."""
    place = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1) * 2 / (step[1:] + step[:-1])))
    n = max(FEWEST, int(np.ceil(DENSITY * place[-1])))
    even = np.linspace(0.0, place[-1], n + 1)
    x = np.stack([np.interp(even, place, column) for column in points.T], axis=1)
    # a stretch is half of a curve or less
    wave = n / place[-1] * min(WAVE, (1 if closed else 2) * LARGEST_SHARE * place[-1])
    beyond = min(n, int(np.ceil(CONTINUED * wave)))
    if closed:
        x = x[:-1]
        long = np.concatenate([x[-beyond:], x, x[:beyond]])
    else:
        first = _reflected(x[1 : beyond + 1], x[0], ON_PLANE * step[0], mirrors)[::-1]
        last = _reflected(x[-beyond - 1 : -1][::-1], x[-1], ON_PLANE * step[-1], mirrors)
        long = np.concatenate([first, x, last])
    rough = sp.eye_array(len(long), format="csc")
    for k in range(ORDER):
        rough = sp.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(len(long) - k - 1, len(long) - k)) @ rough
    penalty = (2 * np.sin(np.pi / wave)) ** (-2 * ORDER)
    found = spsolve(sp.csc_array(sp.eye_array(len(long)) + penalty * rough.T @ rough), long)
    return np.asarray(found[beyond : beyond + len(x)])


def _reflected(points: Array, end: Array, near: float, mirrors: Sequence[Mirror]) -> Array:
    """Points (n, d) beyond an end: mirror images if it lies on a plane of symmetry, else images in the end itself."""
    for mirror in mirrors:
        if abs((end - mirror.point) @ mirror.normal) < near:
            return mirror.image(points)
    return np.asarray(2 * end - points)
