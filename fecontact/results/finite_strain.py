"""Equilibrium of bodies at finite strain, as Newton's method found it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Equilibrium:
    """How a load step at finite strain ended.

    Attributes
    ----------
    iterations : int
    change : float
        Largest displacement of the last iteration, relative to the size of the bodies.
    residual : float
        Largest force on a node that is not balanced, relative to the largest force inside.
    """

    iterations: int
    change: float
    residual: float
