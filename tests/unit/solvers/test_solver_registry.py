"""Names, options, refusals, and the one limit that is part of the method: Wolfe's short form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.sparse.linalg import aslinearoperator

import fecontact.solvers.registry
from fecontact import InputError, SolverError, SolverNotFoundError
from fecontact.solvers import ContactProblem, Outcome, Status, attempt, available_solvers, solve, validate_options
from fecontact.solvers.scaling import ROUNDING


def test_names() -> None:
    names = available_solvers()
    assert names[:4] == ("wolfe", "active-set", "projected-cg", "nnls")
    assert "osqp" in names


def test_unknown_solver_lists_the_others(half_space) -> None:
    with refused(SolverNotFoundError, "unknown-solver", "'simplex'", "wolfe"):
        solve(half_space(3), "simplex")


def test_a_removed_solver_names_what_to_use() -> None:
    with refused(SolverNotFoundError, "removed-solver", "'lemke'", "'nnls'"):
        validate_options("lemke", {})


def test_without_qpsolvers_our_own_remain(half_space, monkeypatch) -> None:
    monkeypatch.setattr(fecontact.solvers.registry, "backends", lambda: ())
    assert available_solvers() == ("wolfe", "active-set", "projected-cg", "nnls")
    with pytest.raises(SolverNotFoundError):
        solve(half_space(3), "osqp")


@pytest.mark.parametrize("solver", ["auto", "wolfe", "osqp"])
def test_unknown_option_is_refused(half_space, solver: str) -> None:
    with refused(InputError, "unknown-option", "'epsilon'"):
        solve(half_space(3), solver, epsilon=1e-3)


def test_options_are_checked_and_used(half_space) -> None:
    problem = half_space(8, 1)
    for wrong in (0, -1, 2.5, None):
        with refused(InputError, "max-iterations"):
            solve(problem, "wolfe", max_iterations=wrong)
    for solver in ("wolfe", "active-set", "projected-cg", "nnls"):
        start = np.ones(64, dtype=bool)
        assert attempt(problem, solver, start=start, max_iterations=1).status is Status.ITERATION_LIMIT
    with refused(SolverError, "not-certified", "iteration-limit", "solver='auto'"):
        solve(problem, "wolfe", max_iterations=1)
    assert solve(problem, "osqp", settings={"eps_abs": 1e-6}).success


def test_start_must_fit(half_space) -> None:
    with refused(InputError, "input", "one entry per point"):
        solve(half_space(3), start=np.ones(8, dtype=bool))


def test_a_loose_back_end_is_sharpened_or_refused(half_space) -> None:
    problem = half_space(8, 1)
    rough = attempt(problem, "osqp", settings={"eps_abs": 1e-1, "eps_rel": 1e-1, "max_iter": 5})
    assert rough.success or rough.status is Status.REFUSED
    assert rough.success == rough.residuals.within(1e-10)


def test_an_impossible_tolerance_is_refused(half_space) -> None:
    solution = attempt(half_space(8, 3), tolerance=1e-20)
    assert solution.status is Status.REFUSED
    assert "active-set" in solution.message
    assert "nnls" in solution.message


def test_wolfes_short_form_on_singular_compliances_is_detected(random_problem) -> None:
    """Of 300 random problems of rank 6 of 12, and of rank 3, some end with artificials left: never returned."""
    for rank, fewest in ((6, 1), (3, 30)):
        left = 0
        for seed in range(60):
            problem = random_problem(seed, 12, 1, rank)
            solution = attempt(problem, "wolfe")
            assert solution.success or solution.status is Status.ARTIFICIAL
            if solution.status is Status.ARTIFICIAL:
                left += 1
                assert "left positive" in solution.message
                with refused(SolverError, "not-certified", "artificial", "solver='auto'"):
                    solve(problem, "wolfe")
                assert solve(problem).success
        assert left >= fewest


def test_auto_falls_back_and_says_so(random_problem) -> None:
    used = {solve(random_problem(seed, 12, 0, 3)).solver for seed in range(10)}
    assert "nnls" in used


def test_operator(half_space) -> None:
    problem = half_space(8, 3)
    operator = ContactProblem(S=aslinearoperator(problem.S), g=problem.g, B=problem.B, F=problem.F)
    with refused(SolverError, "needs-array"):
        solve(operator, "wolfe")
    reference, solution = solve(problem), solve(operator)
    assert solution.solver == "projected-cg"
    # conjugate gradients end at 1e-12 of the deflection; times the condition of S
    assert np.abs(solution.forces - reference.forces).max() <= 1e-8 * reference.forces.max()
    assert np.abs(solution.q - reference.q).max() <= 1e-8


def test_history_and_time(half_space) -> None:
    for solver in ("wolfe", "active-set", "projected-cg", "nnls"):
        solution = solve(half_space(8, 1), solver)
        assert len(solution.history) > 0
        assert solution.seconds > 0
        assert solution.nit > 0


@pytest.mark.parametrize(("share", "carries"), [(0.5, False), (2.0, True)])
def test_a_point_whose_force_is_rounding_carries_none(share: float, carries: bool) -> None:
    # one point more or less counted in the area, by the order of the points alone
    problem = ContactProblem(S=np.eye(2), g=np.array([-1.0, 0.0]))
    scaled = problem.scaled()
    found = Outcome(np.array([1.0, share * ROUNDING]), np.zeros(scaled.r), Status.SOLVED, "", 1)
    forces = fecontact.solvers.registry._unscaled(problem, scaled, found).x
    assert (forces > 0).tolist() == [True, carries]
    # what is no number stays so, and tension too: the certificate sees them
    wrong = replace(found, x=np.array([np.nan, -1.0]))
    assert np.isnan(fecontact.solvers.registry._unscaled(problem, scaled, wrong).x[0])
    assert fecontact.solvers.registry._unscaled(problem, scaled, wrong).x[1] < 0


@pytest.mark.parametrize("off", [0.0, 1e-6])
def test_the_certificate_decides_where_rounding_keeps_solvers_from_their_end(monkeypatch, off):
    """Two solvers that stop before their end: an answer within the tolerance counts, another does not."""
    problem = ContactProblem(S=np.eye(2), g=np.array([0.0, 9.0]), B=np.ones((1, 2)), F=np.array([1.0]))

    def stopped(scaled, start=None, *, max_iterations=1):
        found = wolfe(scaled, start)
        return replace(found, x=found.x * (1 + off), status=Status.CYCLING, message="came back")

    registry, wolfe = fecontact.solvers.registry, fecontact.solvers.registry.NATIVE["wolfe"]
    for name in registry.FALL_BACK:
        monkeypatch.setitem(registry.NATIVE, name, stopped)
    found = attempt(problem)
    assert found.success == (off == 0.0)
    assert found.status is (Status.SOLVED if off == 0.0 else Status.CYCLING)
