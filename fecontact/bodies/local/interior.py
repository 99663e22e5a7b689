"""Fields of the half-space's part of a local body's answer, at points of the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fecontact.analytic.face_loads import displacements, stresses
from fecontact.bodies.local.pressed import Pressed
from fecontact.bodies.local.remainder import Remainder
from fecontact.common.arrays import Array, Mask
from fecontact.fem.stress import components, strain_of

NEAR = 0.5
"""Distance from the window, relative to its diagonal, beyond which the nodes' point loads stand for its cells."""


@dataclass(frozen=True, eq=False)
class BelowWindows:
    """Fields of half-spaces below windows under pressure, in the body's axes.

    Far from a window the forces at its Chebyshev nodes stand for the pressures: there the field is as smooth in the
    point of the load as the remainder is, and on supports both cancel. Near it, see `pressed`.

    Attributes
    ----------
    pressed : sequence of (Remainder, (nx, ny) array)
        Windows and the pressures on their cells.
    """

    pressed: Sequence[tuple[Remainder, Array]]

    def displacement(self, points: Array) -> Array:
        """Displacements (n, 3) at points (n, 3)."""
        out = np.zeros(points.shape)
        for found, p in self.pressed:
            near, axes = _near(found, points), found.window.axes
            for weight, load in zip(found.term.gathered(p), found.sources, strict=True):
                out[~near] += weight * displacements(points[~near], load, found.material).sum(axis=0)
            below = Pressed.of(found.window, p, found.material)
            out[near] += below.displacement(found.window.coordinates(points[near])) @ axes.T
        return out

    def strain(self, points: Array) -> Array:
        """Strains (n, 6) at points (n, 3)."""
        out = np.zeros((len(points), 6))
        for found, p in self.pressed:
            near, axes, stress = _near(found, points), found.window.axes, np.zeros((*points.shape, 3))
            for weight, load in zip(found.term.gathered(p), found.sources, strict=True):
                stress[~near] += weight * stresses(points[~near], load, found.material).sum(axis=0)
            below = Pressed.of(found.window, p, found.material)
            stress[near] = axes @ below.stress(found.window.coordinates(points[near])) @ axes.T
            out += strain_of(components(stress), found.material)
        return out


def _near(found: Remainder, points: Array) -> Mask:
    window = found.window
    local = window.coordinates(points)
    beside = np.maximum(np.abs(local[:, :2]) - window.half, 0.0)
    return np.asarray(np.hypot(np.linalg.norm(beside, axis=1), local[:, 2]) < NEAR * np.linalg.norm(2 * window.half))


@dataclass(frozen=True, eq=False)
class NodalFields:
    """Displacements below one window, as `BelowWindows` gives them, at fixed points and for many pressures.

    Attributes
    ----------
    found : Remainder
    points : (n, 3) array
    near : (n,) bool array
        Points near the window.
    far : (3 n_far, k) array
        Displacements of the others by unit forces at the window's nodes.
    """

    found: Remainder
    points: Array
    near: Mask
    far: Array

    @classmethod
    def of(cls, found: Remainder, points: Array) -> NodalFields:
        """At points (n, 3) of the body."""
        near = _near(found, points)
        each = [displacements(points[~near], load, found.material).sum(axis=0).ravel() for load in found.sources]
        return cls(found, points, near, np.stack(each, axis=1))

    def displacement(self, p: Array) -> Array:
        """Displacements (n, 3) by pressures (nx, ny) on the cells."""
        window, u = self.found.window, np.zeros(self.points.shape)
        u[~self.near] = (self.far @ self.found.term.gathered(p)).reshape(-1, 3)
        below = Pressed.of(window, p, self.found.material)
        u[self.near] = below.displacement(window.coordinates(self.points[self.near])) @ window.axes.T
        return u
