"""Axes of slender members: nodes in order, their tangents, elements and lengths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError


def straight(start: ArrayLike, end: ArrayLike, n: int) -> Array:
    """Points (n + 1, 3) of n equal elements from start to end."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    return a + np.linspace(0, 1, n + 1)[:, None] * (b - a)


def axis_of(points: Array, tangents: ArrayLike | None) -> tuple[Array, IntArray, Array]:
    """Unit tangents at the nodes, elements and their lengths along an axis of nodes in order."""
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise InputError(f"An axis needs two nodes or more, (n, 3); found an array {points.shape}.")
    chords = np.diff(points, axis=0)
    lengths_ = np.linalg.norm(chords, axis=1)
    if not (lengths_ > 0).all():
        raise InputError(f"Elements must have lengths; {(~(lengths_ > 0)).sum()} have none.")
    if tangents is None:
        if not np.allclose(np.cross(chords, chords[0]), 0.0, atol=1e-12 * lengths_.max() ** 2):
            raise InputError("The axis is not straight: give the unit tangents at its nodes, tangents=.")
        t = np.repeat(chords[:1] / lengths_[0], len(points), axis=0)
    else:
        t = np.asarray(tangents, dtype=float)
        if t.shape != points.shape or not np.allclose(np.linalg.norm(t, axis=1), 1.0):
            raise InputError(f"tangents must be unit vectors {points.shape}; found an array {t.shape}.")
        # length of the cubic through both ends, by arcs: chord times angle over twice its sine
        half = np.arccos(np.clip((t[1:] * t[:-1]).sum(axis=1), -1.0, 1.0)) / 2
        lengths_ = lengths_ / np.sinc(half / np.pi)
    return t, np.stack([np.arange(len(points) - 1), np.arange(1, len(points))], axis=1), lengths_


def axes_of(
    points: ArrayLike | Sequence[ArrayLike], tangents: ArrayLike | None
) -> tuple[Array, Array, IntArray, Array]:
    """Nodes (n, 3), unit tangents, elements and lengths of one axis, or of several straight ones in order."""
    if np.ndim(points[0]) == 1:  # type: ignore[index]
        return np.asarray(points, dtype=float), *axis_of(np.asarray(points, dtype=float), tangents)
    if tangents is not None:
        raise InputError("Tangents are for one curved axis; several axes in one structure are straight.")
    nodes = [np.asarray(axis, dtype=float) for axis in points]  # type: ignore[union-attr]
    found = [axis_of(axis, None) for axis in nodes]
    starts = np.cumsum([0] + [len(axis) for axis in nodes])
    cells = np.concatenate([cells + start for (_, cells, _), start in zip(found, starts, strict=False)])
    t, size = (np.concatenate([each[k] for each in found]) for k in (0, 2))
    return np.concatenate(nodes), t, cells, size
