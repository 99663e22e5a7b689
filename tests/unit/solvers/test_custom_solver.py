"""Solvers of the user's own: certified like all others, refused when wrong, and told what was expected."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused
from scipy.optimize import nnls

import fecontact as fc
from fecontact.scene.linear import Settings
from fecontact.solvers import Outcome, Status, attempt, solve, validate_options


def penalised(problem, *, weight=1e4):
    """Non-negative least squares on the square root of S, the equilibrium rows weighted."""
    values, vectors = np.linalg.eigh(problem.S)
    root = (vectors * np.sqrt(np.maximum(values, 1e-12 * values[-1]))) @ vectors.T
    rows = weight * np.abs(root).max() * problem.B / np.abs(problem.B).max(initial=1e-300)
    load = weight * np.abs(root).max() * problem.F / np.abs(problem.B).max(initial=1e-300)
    forces, _ = nnls(np.vstack([root, rows]), np.concatenate([-np.linalg.solve(root, problem.g), load]))
    on = forces > 0
    q = -np.linalg.lstsq(problem.B[:, on].T, (problem.S @ forces + problem.g)[on], rcond=None)[0]
    return forces, q


@pytest.fixture
def scene():
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (3, 3, 2))
    block = fc.ElasticBody(mesh, fc.Material(E=1000.0, nu=0.3), contact="bottom", supports={"top": "xyz"}, name="block")
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball").placed((0, 0, 0), np.diag([1.0, -1.0, -1.0]))
    return fc.Scene([block, ball], [fc.Contact(block, ball)]), {block: (0.0, 0.0, -1.0)}


def test_an_own_solver_gives_the_same_forces(half_space) -> None:
    problem = half_space(8, 1)
    mine, theirs = solve(problem, penalised, weight=1e3), solve(problem)
    assert mine.solver == "penalised"
    # both are certified to 1e-10 of the force scale; S has condition numbers of some hundreds
    np.testing.assert_allclose(mine.forces, theirs.forces, atol=1e-8 * theirs.forces.sum())
    np.testing.assert_allclose(mine.q, theirs.q, rtol=1e-8)


def test_an_own_solver_of_a_scene(scene) -> None:
    scene, forces = scene
    mine = scene.solve(forces, solver=penalised)
    usual = scene.solve(forces)
    assert mine.solution.solver == "penalised"
    assert mine.solution.residuals.within(1e-10)
    np.testing.assert_allclose(mine.contacts[0].forces, usual.contacts[0].forces, atol=1e-8)


def test_an_outcome_is_taken_too_and_its_failure_is_told(half_space) -> None:
    problem = half_space(4, 1)
    right = solve(problem)

    def told(problem):
        return Outcome(right.forces, right.q, Status.SOLVED, "solved", 7)

    def lost(problem):
        return Outcome(right.forces, right.q, Status.ITERATION_LIMIT, "I gave up", 9)

    assert solve(problem, told).nit == 7
    with refused(fc.SolverError, "not-certified", "'lost'", "I gave up"):
        solve(problem, lost)


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_wrong_answer_is_refused_with_its_residuals(half_space, share) -> None:
    problem = half_space(8, 1)
    right = solve(problem)
    least = int(right.forces.argmax())

    def one_point(problem):
        """All the load on one point, or share of it: no answer of the contact problem."""
        forces = np.zeros(problem.n)
        forces[least] = share * problem.F[0] / problem.B[0, least]
        return forces, 1e3 * np.abs(right.q)

    found = attempt(problem, one_point)
    assert found.status is Status.REFUSED
    assert not found.success
    with refused(fc.SolverError, "not-certified", "'one_point'", "penetration"):
        solve(problem, one_point)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda p: np.zeros(p.n), ("solver-answer", "ndarray")),
        (lambda p: None, ("solver-answer", "NoneType")),
        (lambda p: (np.zeros(p.n + 1), np.zeros(p.m)), ("solver-answer", "forces", "(16,)", "point")),
        (lambda p: (np.zeros(p.n), 0.0), ("solver-answer", "return q", "(1,)", "row of B")),
        (lambda p: (np.full(p.n, np.nan), np.zeros(p.m)), ("not-solved", "forces", "finite: 16", "of 16")),
        (lambda p: (["a"] * p.n, np.zeros(p.m)), ("not-solved", "forces")),
    ],
)
def test_an_answer_of_the_wrong_form_is_told_what_was_expected(half_space, answer, said) -> None:
    with refused(fc.SolverError, *said):
        solve(half_space(4, 1), answer)


def test_options_are_checked_without_a_problem(monkeypatch) -> None:
    validate_options(penalised, {"weight": 2.0})
    validate_options("auto", {"max_iterations": 3})
    with refused(fc.InputError, "solver-call", ", wait=...", "unexpected keyword"):
        validate_options(penalised, {"wait": 2.0})
    with refused(fc.InputError, "solver-call", "too many positional arguments"):
        validate_options(lambda: None, {})
    with refused(fc.InputError, "input", "found 3"):
        validate_options(3, {})  # type: ignore[arg-type]
    # nothing is solved to check them
    monkeypatch.setattr("fecontact.solvers.registry.attempt", None)
    Settings("wolfe", 1e-10, {"max_iterations": 3}).check()
    with refused(fc.InputError, "unknown-option", "'epsilon'"):
        Settings("wolfe", 1e-10, {"epsilon": 3}).check()
