"""Small contact problems with known structure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from fecontact.solvers import ComplementarityProblem


def half_space(size: int, rows: int = 1, *, load: float = 1.0, half_width: float = 1.4) -> ComplementarityProblem:
    """Rigid paraboloid of radius 1 on an elastic half-space (E* = 1), size x size square cells.

    A load of 1 gives a contact radius of 1 (Hertz: 4/3 of the force unit used here).
    """
    line = np.linspace(-half_width, half_width, size)
    x, y = (each.ravel() for each in np.meshgrid(line, line))
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    # point loads, and the exact centre deflection of a uniformly loaded square for the cell itself
    np.fill_diagonal(distance, (line[1] - line[0]) / (4 * np.log(1 + np.sqrt(2))))
    gap = (x**2 + y**2) / 2
    B = np.vstack([np.ones_like(x), x, y])[:rows]
    F = np.array([4 / 3 * load, 0.0, 0.0])[:rows]
    if rows == 0:
        return ComplementarityProblem(S=1 / (np.pi * distance), g=gap - load)
    return ComplementarityProblem(S=1 / (np.pi * distance), g=gap, B=B, F=F)


def random_problem(seed: int, n: int, m: int, rank: int) -> ComplementarityProblem:
    """Random problem that has an answer: the load is carried by some l >= 0, some motion opens all gaps."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((rank, n))
    S, B = A.T @ A, rng.standard_normal((m, n))
    carried = np.maximum(rng.standard_normal(n), 0.0)
    w = np.maximum(rng.standard_normal(n), 0.0)
    g = w - S @ rng.standard_normal(n) - B.T @ rng.standard_normal(m)
    return ComplementarityProblem(S=S, g=g, B=B, F=B @ carried)


@pytest.fixture(scope="session", name="half_space")
def _half_space() -> Callable[..., ComplementarityProblem]:
    return half_space


@pytest.fixture(scope="session", name="random_problem")
def _random_problem() -> Callable[..., ComplementarityProblem]:
    return random_problem
