"""Conjugate gradients on active sets: preconditioner, rough corrections, allowed points, safeguard, feasible forces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solver_cases import CASES, cycling, low_rank

from fecontact.solvers import ComplementarityProblem, operator_cg, solve
from fecontact.solvers.feasible import feasible, project
from fecontact.solvers.operator_cg import OperatorProblem, solve_with_operator
from fecontact.solvers.projected_cg import projected_cg

QUICK = settings(max_examples=60, derandomize=True, deadline=None)


def given_as_operator(problem: ComplementarityProblem) -> OperatorProblem:
    S = np.array(problem.S)
    return OperatorProblem(
        product=lambda x: S @ x,
        g=problem.g,
        B=problem.B,
        F=problem.F,
        allowed=np.ones(problem.n, bool),
        correction=lambda x: S @ x,
    )


def test_a_preconditioner_saves_steps_and_rough_corrections_change_nothing(half_space: Callable) -> None:
    problem = half_space(16, 3)
    S, everywhere = np.array(problem.S), np.ones(problem.n, bool)
    plain = given_as_operator(problem)
    # the inverse of all points is a good one for some of them
    inverse, single = np.linalg.inv(S), S.astype(np.float32)
    conditioned = replace(plain, precondition=lambda r: inverse @ r)
    rough = replace(
        conditioned, correction=lambda x: (single @ x.astype(np.float32)).astype(float), correction_error=1e-5
    )
    found = [solve_with_operator(each, np.zeros(problem.n), everywhere, 1e-10) for each in (plain, conditioned, rough)]
    reference = solve(problem, "nnls").forces
    assert all(at.converged for at in found)
    assert found[1].nit < found[0].nit
    for at in found:
        # closed to 1e-10 of the deflection, times the condition of S
        assert np.abs(at.x - reference).max() < 1e-7 * reference.max()


def test_points_that_are_not_allowed_carry_nothing(half_space: Callable) -> None:
    """Source: the problem of the other points alone."""
    problem = half_space(12, 3)
    allowed = np.random.default_rng(3).random(problem.n) < 0.7
    at = solve_with_operator(
        replace(given_as_operator(problem), allowed=allowed), np.zeros(problem.n), np.ones(problem.n, bool), 1e-11
    )
    alone = ComplementarityProblem(
        problem.S[np.ix_(allowed, allowed)], problem.g[allowed], problem.B[:, allowed], problem.F
    )
    reference = solve(alone).forces
    assert at.converged
    assert not at.x[~allowed].any()
    assert np.abs(at.x[allowed] - reference).max() < 1e-8 * reference.max()


@pytest.mark.parametrize("make", [lambda: low_rank(8, 2), lambda: low_rank(8, 4), lambda: cycling(12)])
def test_the_safeguard_is_what_makes_it_converge(monkeypatch: pytest.MonkeyPatch, make: Callable) -> None:
    """Singular compliances end within tens of sets, and not at all without it; elsewhere it is not needed."""
    problem = make().problem.scaled()
    assert projected_cg(problem).status == "solved"
    monkeypatch.setattr(operator_cg, "PATIENCE", 10**9)
    needed = problem.n == 64
    assert (projected_cg(problem).status != "solved") == needed


def test_limits_are_kept_and_forces_do_not_pull() -> None:
    for make in CASES:
        case = make(8)
        if case.forces is None or not case.problem.F.any():
            continue
        outcome = projected_cg(case.problem.scaled(), max_iterations=3)
        assert outcome.nit <= 3
        assert len(outcome.history) <= 3
        assert outcome.x.min() >= 0.0


@QUICK
@given(seed=st.integers(0, 10_000), n=st.integers(3, 40), m=st.integers(1, 3), decades=st.integers(-100, 100))
def test_projection_is_the_nearest_feasible_point(seed: int, n: int, m: int, decades: int) -> None:
    """Source: the conditions of the convex problem, for forces of any unit."""
    rng = np.random.default_rng(seed)
    B, unit = rng.standard_normal((m, n)), 10.0**decades
    F, y = B @ np.maximum(rng.standard_normal(n), 0.0), rng.standard_normal(n)
    x, t = project(B, F * unit, y * unit)
    size = np.abs(B).sum() * unit
    assert np.abs(B @ x - F * unit).max() <= 1e-12 * size
    assert np.abs(x - np.maximum(y * unit + B.T @ t, 0.0)).max() <= 1e-12 * size
    assert x.min() >= 0.0


def test_feasible_forces_keep_their_points_where_little_is_missing() -> None:
    B = np.vstack([np.ones(5), np.arange(5.0) - 2])
    y = np.array([0.0, 1.0, 2.0, 1.5, -0.1])
    x = feasible(B, np.array([5.0, 0.5]), y)
    assert np.allclose(B @ x, [5.0, 0.5], rtol=1e-14)
    assert (x > 0).tolist() == [False, True, True, True, False]
    # the moment needs the point that had no force
    x = feasible(B, np.array([5.0, -9.0]), y)
    assert np.allclose(B @ x, [5.0, -9.0], rtol=1e-13)
    assert x[0] > 0
