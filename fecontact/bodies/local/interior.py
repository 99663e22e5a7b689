"""Displacements of the mesh's nodes by the half-space's part of a local body's answer."""

from __future__ import annotations

import numpy as np

from fecontact.analytic import rectangle
from fecontact.analytic.face_loads import fields
from fecontact.bodies.local.remainder import Remainder
from fecontact.bodies.local.sources import images
from fecontact.common.arrays import Array

BLOCKS = 6
"""Blocks of cells along a side of the window that stand for the cells, at points near it."""

NEAR = 0.3
"""Distance from the window, relative to its diagonal, within which blocks serve instead of the nodes' point loads."""


def nodal_displacement(found: Remainder, points: Array, p: Array) -> Array:
    """Displacements (n, 3) of points (n, 3) of the body by pressures (nx, ny) on a half-space.

    Far from the window the forces at its Chebyshev nodes stand for the pressures: there the field is as smooth in the
    point of the load as the remainder is. Near it, pressures are uniform over blocks of cells.
    """
    window = found.window
    local = window.coordinates(points)
    beside = np.maximum(np.abs(local[:, :2]) - window.half, 0.0)
    near = np.hypot(np.linalg.norm(beside, axis=1), local[:, 2]) < NEAR * np.linalg.norm(2 * window.half)
    out = np.zeros(points.shape)
    weights = found.term.gathered(p)
    for weight, source in zip(weights, found.sources, strict=True):
        out[~near] += weight * fields(points[~near], source, found.material)[0].sum(axis=0)
    out[near] = _by_blocks(found, points[near], p)
    return out


def _by_blocks(found: Remainder, points: Array, p: Array) -> Array:
    window = found.window
    steps = [-(-n // BLOCKS) for n in p.shape]
    centres, sums = [], p
    for axis, (x, step) in enumerate(zip(window.along, steps, strict=True)):
        starts = np.arange(0, len(x), step)
        sums = np.add.reduceat(sums, starts, axis=axis)
        centres.append(x[0] + (starts + (step - 1) / 2) * window.grid.cell[axis])
    sides = (steps[0] * window.grid.cell[0] / 2, steps[1] * window.grid.cell[1] / 2)
    local = window.coordinates(points)
    depth = -local[:, 2]
    if window.relief is not None:  # below its own surface
        depth = depth - np.where(window.relief.covers(*local[:, :2].T), window.relief.depth(*local[:, :2].T), 0.0)
    below = np.stack([local[:, 0], local[:, 1], np.maximum(depth, 0.0)], axis=1)
    out = np.zeros(points.shape)
    for ix, iy in np.argwhere(sums > 0):  # at most BLOCKS^2
        pressure = float(sums[ix, iy]) / (steps[0] * steps[1])
        where = np.array([centres[0][ix], centres[1][iy], 0.0])
        for mirror in images(np.eye(3), window.mirrored):
            offset = below - mirror @ where
            out += rectangle.displacement(offset, half_sides=sides, pressure=pressure, material=found.material)
    return np.asarray(out @ (window.axes * np.array([1.0, 1.0, -1.0])).T)
