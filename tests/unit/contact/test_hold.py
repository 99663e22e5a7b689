"""Held rows of a compliance: what forces that move nothing leave is rounding, and is taken out."""

from __future__ import annotations

import numpy as np
import pytest

from fecontact.contact.hold import IndefiniteError, held

#: Two rows of three points that move together, one stable and one that its springs hold.
TOGETHER = np.kron(np.diag([1.0, -2.0]), np.ones((3, 3)))
NONE = np.zeros((0, 6)), np.zeros(0)


def test_points_that_move_together_have_the_compliance_of_one() -> None:
    """Springs w on three points in a row of compliance s: their compliance is 1 / (1/s + 3 w), exactly of rank 1."""
    g = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    noise = 1e-13 * np.random.default_rng(0).normal(size=(6, 6))
    found = held(TOGETHER + noise + noise.T, g + noise[0], *NONE, np.ones(6, bool))
    w = 100.0 / 1.5
    expected = np.kron(np.diag([1 / (1 + 3 * w), 1 / (-1 / 2 + 3 * w)]), np.ones((3, 3)))
    assert np.abs(found.S - expected).max() < 5e-12
    assert np.linalg.matrix_rank(found.S, tol=1e-14) == 2
    assert np.ptp(found.g[:3]) < 1e-14


def test_a_gap_that_no_force_closes_stays() -> None:
    g = np.array([1.0, 1.0, 1.01, 2.0, 2.0, 2.0])
    assert np.ptp(held(TOGETHER, g, *NONE, np.ones(6, bool)).g[:3]) == pytest.approx(0.01, rel=1e-9)


def test_points_that_nothing_holds_are_refused() -> None:
    with pytest.raises(IndefiniteError):
        held(TOGETHER, np.ones(6), *NONE, np.arange(6) < 3)
