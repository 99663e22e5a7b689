"""Fields of the half-space's part of a local body's answer, at points of the body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.analytic.face_loads import fields
from fecontact.bodies.local.pressed import Pressed
from fecontact.bodies.local.remainder import Remainder
from fecontact.common.arrays import Array
from fecontact.fem.stress import components, strain_of

NEAR = 0.5
"""Distance from the window, relative to its diagonal, beyond which the nodes' point loads stand for its cells."""


def pressed_fields(pressed: Sequence[tuple[Remainder, Array]], points: Array) -> tuple[Array, Array]:
    """Displacements (n, 3) and strains (n, 6) of half-spaces at points (n, 3) of the body, in the body's axes.

    Parameters
    ----------
    pressed : sequence of (Remainder, (nx, ny) array)
        Windows and the pressures on their cells.
    points : (n, 3) array

    Notes
    -----
    Far from the window the forces at its Chebyshev nodes stand for the pressures: there the field is as smooth in the
    point of the load as the remainder is, and on supports both cancel. Near it, see `pressed`.
    """
    u, strain = np.zeros(points.shape), np.zeros((len(points), 6))
    for found, p in pressed:
        window = found.window
        local = window.coordinates(points)
        beside = np.maximum(np.abs(local[:, :2]) - window.half, 0.0)
        near = np.hypot(np.linalg.norm(beside, axis=1), local[:, 2]) < NEAR * np.linalg.norm(2 * window.half)
        stress = np.zeros((*points.shape, 3))
        for weight, source in zip(found.term.gathered(p), found.sources, strict=True):
            more, sigma = fields(points[~near], source, found.material)
            u[~near] += weight * more.sum(axis=0)
            stress[~near] += weight * sigma.sum(axis=0)
        more, sigma = Pressed.of(window, p, found.material).fields(local[near])
        u[near] += more @ window.axes.T
        stress[near] = window.axes @ sigma @ window.axes.T
        strain += strain_of(components(stress), found.material)
    return u, strain
