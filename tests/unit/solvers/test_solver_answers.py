"""Every solver, the same answer: conditions, invariance, agreement."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fecontact.solvers import ContactProblem, Solution, attempt, available_solvers, solve

FINITE = ("auto", "nnls")
DIRECT = ("auto", "active-set", "wolfe", "nnls")
QUICK = settings(max_examples=60, derandomize=True, deadline=None)


def assert_conditions(problem: ContactProblem, solution: Solution) -> None:
    """Contact conditions, written out here and not taken from the residuals."""
    forces, motion = solution.forces, problem.B.T @ solution.q
    w = problem.S @ forces + problem.g + motion
    # nothing at all is zero over anything
    gap_scale = max(np.abs(problem.S @ forces).max(), np.abs(problem.g).max(), np.abs(motion).max()) or 1.0
    force_scale = forces.sum() or 1.0
    # 1e-10 was certified on scales that are not larger than these
    assert forces.min() >= 0.0
    assert w.min() >= -1e-9 * gap_scale
    assert np.minimum(forces / force_scale, np.abs(w) / gap_scale).max() <= 1e-10
    carried = max(np.abs(problem.B).max(initial=0) * forces.sum(), 1)
    assert np.abs(problem.B @ forces - problem.F).max(initial=0) <= 1e-9 * carried
    assert np.abs(solution.gap - w).max() <= 1e-12 * gap_scale


def energy(problem: ContactProblem, forces: np.ndarray) -> float:
    return float(0.5 * forces @ problem.S @ forces + problem.g @ forces)


@pytest.mark.parametrize("solver", DIRECT)
@QUICK
@given(seed=st.integers(0, 10_000), n=st.integers(1, 20), m=st.integers(0, 3))
def test_positive_definite(random_problem, solver: str, seed: int, n: int, m: int) -> None:
    problem = random_problem(seed, n, min(m, n), n + 3)
    assert_conditions(problem, solve(problem, solver))


@pytest.mark.parametrize("solver", FINITE)
@QUICK
@given(seed=st.integers(0, 10_000), n=st.integers(2, 20), m=st.integers(0, 3), share=st.sampled_from([0, 4, 2]))
def test_singular(random_problem, solver: str, seed: int, n: int, m: int, share: int) -> None:
    problem = random_problem(seed, n, min(m, n), n // share if share else 0)
    solution = solve(problem, solver)
    assert_conditions(problem, solution)
    # the gap and the energy are unique where the forces are not
    other = attempt(problem, "osqp")
    if not other.success:  # on some linear programmes, S = 0, its steps do not settle
        other = solve(problem, "wolfe")
    assert np.abs(problem.S @ (solution.forces - other.forces)).max() <= 1e-8 * max(np.abs(problem.g).max(), 1)
    scale = max(abs(energy(problem, other.forces)), 1.0)
    assert abs(energy(problem, solution.forces) - energy(problem, other.forces)) <= 1e-8 * scale


@QUICK
@given(seed=st.integers(0, 10_000), n=st.integers(2, 12))
def test_whole_numbers_full_of_ties(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    A, B = rng.integers(-1, 2, (3, n)).astype(float), rng.integers(-1, 2, (2, n)).astype(float)
    S = A.T @ A
    g = rng.integers(0, 2, n) - S @ rng.integers(-1, 2, n) - B.T @ rng.integers(-1, 2, 2)
    problem = ContactProblem(S=S, g=g, B=B, F=B @ rng.integers(0, 2, n).astype(float))
    for solver in FINITE:
        assert_conditions(problem, solve(problem, solver))


@pytest.mark.parametrize("rows", [0, 1, 3])
@pytest.mark.parametrize("solver", available_solvers())
def test_all_solvers_agree(half_space, solver: str, rows: int) -> None:
    problem = half_space(9, rows)
    reference, solution = solve(problem), solve(problem, solver)
    # all are sharpened on the same set: what is left is rounding times the condition of S, far below 1e-8
    assert np.abs(solution.forces - reference.forces).max() <= 1e-8 * reference.forces.max()
    assert np.abs(solution.gap - reference.gap).max() <= 1e-8 * np.abs(reference.gap).max()
    assert np.abs(solution.q - reference.q).max(initial=0) <= 1e-8
    assert solution.solver == solver


@pytest.mark.parametrize("solver", [*DIRECT, "projected-cg"])
def test_order_of_points_and_rows_does_not_matter(half_space, solver: str) -> None:
    problem = half_space(8, 3)
    rng = np.random.default_rng(5)
    points, rows = rng.permutation(problem.n), rng.permutation(3)
    shuffled = ContactProblem(
        S=problem.S[np.ix_(points, points)], g=problem.g[points], B=problem.B[np.ix_(rows, points)], F=problem.F[rows]
    )
    first, second = solve(problem, solver), solve(shuffled, solver)
    assert np.abs(first.forces[points] - second.forces).max() <= 1e-9 * first.forces.max()
    assert np.abs(first.q[rows] - second.q).max() <= 1e-9 * np.abs(first.q).max()


@pytest.mark.parametrize("solver", [*DIRECT, "projected-cg"])
@pytest.mark.parametrize(("length", "force"), [(1e-3, 1.0), (1e3, 1.0), (1.0, 1e9), (1.0, 1e-9), (1e-6, 1e6)])
def test_units_do_not_matter(half_space, solver: str, length: float, force: float) -> None:
    problem = half_space(7, 3)
    arms = np.array([1.0, length, length])
    other = ContactProblem(
        S=problem.S * length / force, g=problem.g * length, B=problem.B * arms[:, None], F=problem.F * arms * force
    )
    first, second = solve(problem, solver), solve(other, solver)
    # the issue is rounding in the change of units, amplified by the condition of S
    assert np.abs(first.forces - second.forces / force).max() <= 1e-9 * first.forces.max()
    assert np.abs(first.q - second.q * arms / length).max() <= 1e-9 * np.abs(first.q).max()


@pytest.mark.parametrize("solver", FINITE)
def test_rows_that_differ_by_sixteen_orders(half_space, solver: str) -> None:
    problem = half_space(8, 3)
    d = 10.0 ** np.random.default_rng(1).uniform(-8, 8, problem.n)
    scaled = ContactProblem(S=problem.S * d * d[:, None], g=problem.g * d, B=problem.B * d, F=problem.F)
    first, second = solve(problem, solver), solve(scaled, solver)
    assert np.abs(first.forces - second.forces * d).max() <= 1e-8 * first.forces.max()


@pytest.mark.parametrize("solver", FINITE)
def test_duplicate_points_share_the_force(half_space, solver: str) -> None:
    problem = half_space(7, 3)
    twice = np.repeat(np.arange(problem.n), 2)
    doubled = ContactProblem(S=problem.S[np.ix_(twice, twice)], g=problem.g[twice], B=problem.B[:, twice], F=problem.F)
    first, second = solve(problem, solver), solve(doubled, solver)
    # forces of twins are not unique, their sum and the gap are
    assert np.abs(first.forces - second.forces.reshape(-1, 2).sum(axis=1)).max() <= 1e-8 * first.forces.max()
    assert np.abs(first.gap[twice] - second.gap).max() <= 1e-8 * first.gap.max()


@pytest.mark.parametrize("solver", available_solvers())
@pytest.mark.parametrize("seed", range(6))
def test_a_singular_compliance_is_solved_or_refused(random_problem, solver: str, seed: int) -> None:
    problem = random_problem(seed, 12, 1, 4)
    solution = attempt(problem, solver)
    assert solution.success == (solution.status in ("solved", "no-contact"))
    if solution.success:
        assert_conditions(problem, solution)
