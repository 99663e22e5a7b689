"""The problem: what it refuses, its residuals, its nondimensional form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from fecontact import InputError
from fecontact.solvers import ContactProblem, Residuals, Solution, Status, solve

EYE = np.eye(3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"S": EYE, "g": np.empty(0)}, ("no-gap",)),
        ({"S": np.eye(2), "g": np.ones(3)}, ("input", "S must have shape")),
        ({"S": EYE, "g": np.array([1.0, np.nan, 1.0])}, ("input", "g must")),
        ({"S": np.full((3, 3), np.inf), "g": np.ones(3)}, ("input", "S")),
        ({"S": np.triu(np.ones((3, 3))), "g": np.ones(3)}, ("not-symmetric",)),
        ({"S": -EYE, "g": np.ones(3)}, ("not-semidefinite",)),
        ({"S": EYE, "g": np.ones((3, 1))}, ("dimensions",)),
        ({"S": EYE, "g": ["a", "b", "c"]}, ("input", "array of numbers")),
        ({"S": EYE, "g": np.ones(3), "B": np.ones((1, 2)), "F": np.ones(1)}, ("column-shape",)),
        ({"S": EYE, "g": np.ones(3), "B": np.ones((1, 3))}, ("row-shape", "0")),
        ({"S": EYE, "g": np.ones(3), "F": np.ones(1)}, ("row-shape", "0")),
    ],
)
def test_input_is_checked(arguments: dict, message: str) -> None:
    with refused(InputError, *message):
        ContactProblem(**arguments)


def test_asymmetry_is_found_in_a_late_strip() -> None:
    S = np.eye(700)
    S[650, 20] = 1e-3
    with refused(InputError, "not-symmetric", "S[650, 20"):
        ContactProblem(S=S, g=np.ones(700))


def test_rows_are_optional_and_the_users_arrays_stay_writable() -> None:
    g = np.ones(3)
    problem = ContactProblem(S=EYE, g=g, B=None, F=None)
    assert (problem.n, problem.m) == (3, 0)
    assert g.flags.writeable
    assert not problem.g.flags.writeable


def test_residuals_measure_each_condition() -> None:
    problem = ContactProblem(S=EYE, g=np.array([-2.0, 0.0, 1.0]), B=np.ones((1, 3)), F=np.array([4.0]))
    # w = (2, -1, 1): force scale 4 (sum of |l|), gap scale 4 (largest deflection), row scale 4 + 4
    residuals = problem.residuals(np.array([4.0, -1.0, 0.0]), np.zeros(1))
    scale = 5.0
    assert residuals.tension == pytest.approx(1 / scale)
    assert residuals.penetration == pytest.approx(1 / 4)
    assert residuals.complementarity == pytest.approx(0.5)
    assert residuals.equilibrium == pytest.approx(1 / (scale + 4))
    assert residuals.worst == residuals.complementarity
    assert not residuals.within(1e-10)


def test_penetration_may_be_ten_times_the_tolerance() -> None:
    assert Residuals(9e-10, 0.0, 0.0, 0.0).within(1e-10)
    assert not Residuals(0.0, 9e-10, 0.0, 0.0).within(1e-10)


def test_residuals_refuse_wrong_shapes_and_answers_that_are_not_finite() -> None:
    problem = ContactProblem(S=EYE, g=np.ones(3))
    with refused(InputError, "residual-shape", "(2,)"):
        problem.residuals(np.zeros(2), np.zeros(0))
    assert problem.residuals(np.array([np.nan, 0, 0]), np.zeros(0)).worst == np.inf


def test_residuals_without_contact_are_exactly_zero() -> None:
    for g in (np.ones(3), np.zeros(3)):
        problem = ContactProblem(S=0 * EYE, g=g)
        assert problem.residuals(np.zeros(3), np.zeros(0)).worst == 0.0


def test_a_load_that_nothing_carries_is_out_of_equilibrium() -> None:
    problem = ContactProblem(S=EYE, g=np.ones(3), B=np.ones((1, 3)), F=np.ones(1))
    assert problem.residuals(np.zeros(3), np.zeros(1)).equilibrium == pytest.approx(0.5)


def test_residuals_follow_a_change_of_units(random_problem) -> None:
    problem = random_problem(3, 8, 2, 8)
    rng = np.random.default_rng(0)
    forces, q = rng.standard_normal(8), rng.standard_normal(2)
    before = problem.residuals(forces, q)
    length, force, rows = 1e-3, 1e5, np.array([1.0, 1e3])
    other = ContactProblem(
        S=problem.S * length / force, g=problem.g * length, B=problem.B * rows[:, None], F=problem.F * rows * force
    )
    after = other.residuals(forces * force, q * length / rows)
    for name in ("penetration", "tension", "complementarity", "equilibrium"):
        # only rounding separates them
        assert getattr(after, name) == pytest.approx(getattr(before, name), rel=1e-12)


def test_scaled_form_is_nondimensional_and_maps_back(half_space) -> None:
    problem = half_space(6, 3)
    units = ContactProblem(
        S=problem.S * 1e-12, g=problem.g * 1e-6, B=problem.B * np.array([[1.0], [1e-6], [1e-6]]), F=problem.F * 1e6
    )
    a, b = problem.scaled(), units.scaled()
    assert np.abs(a.matrix.diagonal() - 1).max() < 1e-14
    assert np.abs(a.B @ a.B.T - np.eye(3)).max() < 1e-14
    assert max(np.abs(a.g).max(), np.abs(a.F).max()) == pytest.approx(1.0)
    # both have the same nondimensional form, to rounding
    assert np.abs(a.g - b.g).max() < 1e-13
    x, p = np.arange(36.0), np.array([1.0, 2.0, 3.0])
    expected = problem.gap(a.forces(x), a.motion(p))
    assert np.abs(a.gap(x, p) * a.gap_scale - expected).max() < 1e-12 * np.abs(expected).max()


def test_dependent_and_empty_rows_are_dropped() -> None:
    B = np.array([[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [0.0, 0.0, 0.0], [1e-17, -1e-17, 0.0]])
    scaled = ContactProblem(S=EYE, g=np.ones(3), B=B, F=np.array([1.0, 2.0, 0.0, 0.0])).scaled()
    assert scaled.r == 1
    assert not scaled.inconsistency.any()
    # nothing sees these motions: the multiplier of least norm leaves them at rest
    assert not scaled.motion(np.ones(1))[2:].any()


def test_a_solution_tells_who_touches(half_space) -> None:
    solution = solve(half_space(6))
    assert isinstance(solution, Solution)
    assert solution.status is Status.SOLVED
    assert solution.status == "solved"
    assert (solution.active == (solution.forces > 0)).all()
    assert "penetration" in str(solution.residuals)


def test_a_solution_is_judged_by_its_problem_whatever_its_status_says() -> None:
    solution = solve(ContactProblem(S=EYE, g=np.array([-2.0, -1.0, 1.0])))
    assert solution.residuals.worst == 0.0
    # half the force on the first point leaves half of its overlap: gap -1 over the largest deflection, 1
    tampered = replace(solution, forces=np.array([1.0, 1.0, 0.0]))
    assert tampered.status is Status.SOLVED
    assert tampered.gap.tolist() == [-1.0, 0.0, 1.0]
    assert tampered.residuals.penetration == 1.0


def test_what_is_below_some_units_of_rounding_is_rounding() -> None:
    """Data of order one are known to 2.2e-16: the sign of a force or gap of that size says nothing."""
    eps = np.finfo(float).eps
    for F, largest in ((np.ones(1), 1e2 * eps), (np.zeros(1), 1e4 * eps)):
        scaled = ContactProblem(np.eye(2), -np.ones(2), np.ones((1, 2)), F).scaled()
        assert 2 * eps < scaled.rounding_of(np.zeros(2)) < largest
        _, of_gaps = scaled.gap_and_rounding(np.zeros(2), np.zeros(1))
        assert 2 * eps < of_gaps < 1e-12
    loaded = ContactProblem(np.eye(2), np.zeros(2), np.ones((1, 2)), np.ones(1)).scaled()
    assert 2 * eps < loaded.gap_and_rounding(np.zeros(2), np.zeros(1))[1] < 1e2 * eps
