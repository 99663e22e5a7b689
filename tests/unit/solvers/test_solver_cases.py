"""Physical limits: nothing touches, one point, all points; loads that nothing carries; many patches and ties."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused
from scipy.linalg import block_diag

from fecontact import SolverError
from fecontact.solvers import ContactProblem, InfeasibleLoadError, Status, attempt, available_solvers, solve

OWN = ("auto", "wolfe", "active-set", "projected-cg", "nnls")
ALL = ("auto", *available_solvers())


@pytest.mark.parametrize("solver", ALL)
@pytest.mark.parametrize("rows", [0, 1])
def test_no_contact_is_exactly_zero(solver: str, rows: int) -> None:
    g = np.array([0.0, 0.5, 1.0])
    problem = ContactProblem(S=np.eye(3), g=g, B=np.ones((rows, 3)), F=np.zeros(rows))
    solution = solve(problem, solver)
    assert solution.status is Status.NO_CONTACT
    assert solution.success
    assert solution.nit == 0
    assert not solution.forces.any()
    assert not solution.q.any()
    assert (solution.gap == g).all()
    assert solution.residuals.worst == 0.0


@pytest.mark.parametrize("solver", ALL)
def test_first_touch_at_one_point(half_space, solver: str) -> None:
    # an odd grid has a point at the pole; a very light load presses on it alone
    problem = half_space(7, 1, load=1e-9)
    solution = solve(problem, solver)
    assert solution.active.sum() == 1
    pole = problem.n // 2
    # one point, one force: statics, to rounding
    assert abs(solution.forces[pole] - problem.F[0]) <= 1e-12 * problem.F[0]
    assert abs(solution.q[0] + problem.S[pole, pole] * problem.F[0]) <= 1e-15


@pytest.mark.parametrize("solver", ALL)
def test_everything_in_contact(half_space, solver: str) -> None:
    problem = half_space(5, 1, load=1e3)
    solution = solve(problem, solver)
    assert solution.active.all()
    K = np.block([[problem.S, problem.B.T], [problem.B, np.zeros((1, 1))]])
    expected = np.linalg.solve(K, np.concatenate([-problem.g, problem.F]))
    # condition of K times rounding
    assert np.abs(solution.forces - expected[:-1]).max() <= 1e-10 * np.abs(expected[:-1]).max()
    assert abs(solution.q[0] - expected[-1]) <= 1e-10 * abs(expected[-1])


@pytest.mark.parametrize("solver", ALL)
def test_a_single_point(solver: str) -> None:
    pressed = ContactProblem(S=np.array([[2.0]]), g=np.array([-3.0]))
    assert abs(solve(pressed, solver).forces[0] - 1.5) <= 1e-12
    loaded = ContactProblem(S=np.array([[2.0]]), g=np.array([1.0]), B=np.ones((1, 1)), F=np.array([4.0]))
    solution = solve(loaded, solver)
    assert abs(solution.forces[0] - 4.0) <= 1e-12
    assert abs(solution.q[0] + 9.0) <= 1e-12


@pytest.mark.parametrize("solver", OWN)
def test_interference_is_removed_by_moving_a_free_body(solver: str) -> None:
    problem = ContactProblem(S=np.eye(3), g=np.array([-1.0, 0.0, 2.0]), B=np.ones((1, 3)), F=np.zeros(1))
    solution = solve(problem, solver)
    # without load the body moves away, whatever the distance, and nothing presses
    assert not solution.forces.any()
    assert solution.gap.min() >= -1e-12


@pytest.mark.parametrize("solver", OWN)
def test_negative_gaps(half_space, solver: str) -> None:
    problem = half_space(7, 1)
    sunk = ContactProblem(S=problem.S, g=problem.g - 5.0, B=problem.B, F=problem.F)
    first, second = solve(problem, solver), solve(sunk, solver)
    # the free body moves 5 further; forces are the same to the rounding of 5 over a deflection of 1
    assert np.abs(first.forces - second.forces).max() <= 1e-9 * first.forces.max()
    assert abs(second.q[0] - first.q[0] - 5.0) <= 1e-12


@pytest.mark.parametrize("solver", ALL)
def test_a_load_that_pulls_names_the_motion(solver: str) -> None:
    problem = ContactProblem(S=np.eye(3), g=np.ones(3), B=np.ones((1, 3)), F=np.array([-2.0]))
    with refused(InfeasibleLoadError, "no-balance", "balance the load") as caught:
        solve(problem, solver)
    y = caught.value.direction
    assert (problem.B.T @ y).min() >= 0
    assert problem.F @ y < 0


def test_a_load_outside_the_support_polygon_tips_the_body() -> None:
    x = np.array([-1.0, 0.0, 1.0])
    B = np.vstack([np.ones(3), x])
    inside = ContactProblem(S=np.eye(3), g=np.zeros(3), B=B, F=np.array([1.0, 0.999]))
    assert solve(inside).success
    edge = ContactProblem(S=np.eye(3), g=np.zeros(3), B=B, F=np.array([1.0, 1.0]))
    # all the load on the last point
    assert np.abs(solve(edge).forces - [0.0, 0.0, 1.0]).max() <= 1e-10
    outside = ContactProblem(S=np.eye(3), g=np.zeros(3), B=B, F=np.array([1.0, 1.001]))
    with pytest.raises(InfeasibleLoadError) as caught:
        solve(outside)
    y = caught.value.direction
    # no gap closes along it, and the load does work
    assert (B.T @ y).min() >= -1e-12
    assert outside.F @ y < 0


def test_a_tangential_load_without_friction() -> None:
    B = np.array([[1.0, 1.0], [0.0, 0.0]])
    with pytest.raises(InfeasibleLoadError) as caught:
        solve(ContactProblem(S=np.eye(2), g=np.zeros(2), B=B, F=np.array([1.0, -0.5])))
    assert np.abs(caught.value.direction - [0.0, 1.0]).max() <= 1e-12


def test_contradicting_rows() -> None:
    B = np.array([[1.0, 1.0], [2.0, 2.0]])
    with pytest.raises(InfeasibleLoadError) as caught:
        solve(ContactProblem(S=np.eye(2), g=np.zeros(2), B=B, F=np.array([1.0, 3.0])))
    y = caught.value.direction
    assert np.abs(B.T @ y).max() <= 1e-12
    assert np.array([1.0, 3.0]) @ y < 0


@pytest.mark.parametrize("solver", OWN)
def test_free_motions_without_load(half_space, solver: str) -> None:
    """A ball on a plate: spinning is seen by no point, rolling has no load."""
    problem = half_space(7, 3)
    B = np.vstack([problem.B, np.zeros((1, problem.n)), 2 * problem.B[:1] - problem.B[1:2]])
    F = np.concatenate([problem.F, [0.0], 2 * problem.F[:1] - problem.F[1:2]])
    more = ContactProblem(S=problem.S, g=problem.g, B=B, F=F)
    first, second = solve(problem, solver), solve(more, solver)
    assert np.abs(first.forces - second.forces).max() <= 1e-9 * first.forces.max()
    assert second.q[3] == 0.0


@pytest.mark.parametrize("S", [np.zeros((2, 2)), np.diag([1.0, 0.0])])
def test_interference_of_rigid_bodies_has_no_answer(S: np.ndarray) -> None:
    problem = ContactProblem(S=S, g=np.array([-1.0, -1.0]))
    assert attempt(problem).status is Status.UNBOUNDED
    with refused(SolverError, "not-certified", "unbounded"):
        solve(problem)


def test_rigid_bodies_are_statically_determinate() -> None:
    x = np.array([0.0, 1.0, 2.0])
    problem = ContactProblem(
        S=np.zeros((3, 3)), g=np.array([0.0, 1.0, 0.0]), B=np.vstack([np.ones(3), x]), F=np.array([1.0, 0.5])
    )
    for solver in ("auto", "nnls"):
        # moments about the supports: 3/4 and 1/4
        assert np.abs(solve(problem, solver).forces - [0.75, 0.0, 0.25]).max() <= 1e-12


@pytest.mark.parametrize("solver", OWN)
def test_many_separate_patches(half_space, solver: str) -> None:
    patch = half_space(4, 1)
    S = block_diag(*[patch.S] * 12)
    g = np.concatenate([patch.g + 0.01 * k for k in range(12)])
    problem = ContactProblem(S=S, g=g, B=np.ones((1, g.size)), F=12 * patch.F)
    solution = solve(problem, solver)
    share = solution.forces.reshape(12, -1).sum(axis=1)
    # the farther a patch, the less it carries; together they carry the load, to the tolerance of the certificate
    assert (np.diff(share) < 0).all()
    assert abs(share.sum() - 12 * patch.F[0]) <= 1e-9 * 12 * patch.F[0]


@pytest.mark.parametrize("solver", OWN)
def test_symmetric_ties(solver: str) -> None:
    n = 24
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    # points on a ring, all alike
    S = 1.0 / (1.0 + np.minimum(lag, n - lag))
    problem = ContactProblem(S=S, g=np.ones(n), B=np.ones((1, n)), F=np.array([float(n)]))
    assert np.abs(solve(problem, solver).forces - 1.0).max() <= 1e-9


@pytest.mark.parametrize("solver", ["auto", "active-set", "nnls", "projected-cg"])
def test_the_start_does_not_change_the_answer(half_space, solver: str) -> None:
    problem = half_space(8, 3)
    reference = solve(problem, solver)
    rng = np.random.default_rng(2)
    starts = [np.zeros(64, dtype=bool), np.ones(64, dtype=bool), rng.random(64) < 0.3, reference, rng.random(64) - 0.5]
    for start in starts:
        solution = solve(problem, solver, start=start)
        assert np.abs(solution.forces - reference.forces).max() <= 1e-9 * reference.forces.max()


def test_a_good_start_saves_solves(half_space) -> None:
    problem = half_space(16, 1)
    reference = solve(problem, "active-set")
    assert solve(problem, "active-set", start=reference).nit == 1
    assert solve(problem, "active-set", start=np.ones(256, dtype=bool)).nit > 1
