"""Penalty and gap elements: their limits, their orders, what they refuse."""

import numpy as np
import penalty_and_gaps
import pytest
from refusals import refused
from solver_cases import duplicates, hertz, pressed_in
from solver_cases import half_space as pressed

from fecontact import InputError
from fecontact.solvers import ContactProblem, solve
from fecontact.solvers.baselines import condition_number, gap_elements, penalty


def guess(problem):
    """Stiffness of a point, to measure springs by."""
    return 1 / np.mean(problem.S.diagonal())


@pytest.mark.parametrize("make", [hertz, pressed_in])
def test_a_stiff_penalty_tends_to_the_exact_answer_with_order_one(make):
    case = make(11)
    k = guess(case.problem)
    errors, depths = [], []
    for factor in (1e2, 1e3, 1e4, 1e5):
        found = penalty(case.problem, factor * k)
        assert found.settled
        errors.append(np.abs(found.forces - case.forces).max() / case.forces.max())
        depths.append(found.penetration)
    # order one in 1/k: a tenth each time, to the next order, 1/k^2
    assert np.abs(np.array(errors[1:]) / errors[:-1] - 0.1).max() < 0.01
    assert np.abs(np.array(depths[1:]) / depths[:-1] - 0.1).max() < 0.01


def test_a_penalty_is_a_layer_of_springs():
    """The exact solver on the compliance S + 1/k is another way to the same forces."""
    p = pressed(11, 3)
    k = 7 * guess(p)
    layered = ContactProblem(p.S + np.eye(p.n) / k, p.g, p.B, p.F)
    exact, found = solve(layered), penalty(p, k)
    assert np.abs(found.forces - exact.forces).max() < 1e-9 * exact.forces.max()
    assert np.abs(found.forces - k * np.maximum(-found.gap, 0)).max() < 1e-9 * exact.forces.max()
    assert not found.residuals.within(1e-4)


def test_a_singular_compliance_is_no_trouble_for_springs():
    case = duplicates(10)
    found = penalty(case.problem, 1e6 * guess(case.problem))
    assert found.settled
    change = case.problem.S @ (found.forces - case.forces)
    # order one in the penetration
    assert np.abs(change).max() < 1e-4 * np.abs(case.problem.S @ case.forces).max()


@pytest.mark.parametrize("rows", [0, 1, 3])
def test_increments_tend_to_the_exact_answer(rows):
    p = pressed(11, rows)
    k, exact = guess(p), solve(p)
    errors = []
    for increments in (16, 64, 256):
        found = gap_elements(p, 1e-8 * k, 1e6 * k, increments)
        assert found.solves == increments
        errors.append(np.abs(found.forces - exact.forces).max() / exact.forces.max())
    # about order one: four times the increments, at least half the error; never less than what the exact method has
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2
    assert errors[2] < 0.05


def test_soft_elements_carry_what_they_should_not():
    p = pressed(11, 1)
    k, exact = guess(p), solve(p)
    shares = []
    for soft in (1e-2, 1e-4):
        found = gap_elements(p, soft * k, 1e6 * k, 128)
        shares.append(found.forces[~exact.active].sum() / found.forces.sum())
    # the load in elements that should be open falls with their stiffness
    assert shares[0] > 5 * abs(shares[1])
    # equilibrium holds all the same
    assert found.residuals.equilibrium < 1e-9


def test_an_element_that_is_closed_from_the_start_is_one_spring():
    p = ContactProblem(S=np.eye(1), g=np.zeros(1), B=np.ones((1, 1)), F=np.array([3.0]))
    for increments in (1, 5):
        found = gap_elements(p, 1.0, 100.0, increments, cycles=3)
        assert found.settled
        assert abs(found.forces[0] - 3.0) < 1e-12
        assert abs(found.penetration - 0.03) < 1e-12


def test_condition_grows_with_the_penalty():
    p = pressed(9, 1)
    k, touching = guess(p), solve(p).active
    soft, hard = (condition_number(p, np.where(touching, factor * k, 0.0)) for factor in (1e4, 1e6))
    assert abs(hard / soft / 100 - 1) < 0.01


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: penalty(p, 0.0), ("input", "positive stiffness")),
        (lambda p: penalty(p, np.inf), ("input", "positive stiffness")),
        (lambda p: penalty(p, np.ones(3)), ("input", "one per point")),
        (lambda p: gap_elements(p, 2.0, 1.0, 3), ("input", "soft before it closes")),
        (lambda p: gap_elements(p, 1.0, 2.0, 0), ("input", "positive integer")),
        (lambda p: gap_elements(p, 1.0, 2.0, 1, cycles=0), ("input", "positive integer")),
    ],
)
def test_bad_input(call, message):
    with refused(InputError, *message):
        call(pressed(5))


@pytest.mark.full
def test_the_page_shows_what_it_says(tmp_path):
    rows = penalty_and_gaps.main(increments=(16, 256), out=tmp_path)
    errors, conditions = ([r[key] for r in rows["penalty"]] for key in ("error", "condition"))
    # order one in 1/k and in the condition number, at both ends of four decades
    assert abs(errors[-1] / errors[-5] / 1e-4 - 1) < 0.05
    assert abs(conditions[-1] / conditions[-5] / 1e4 - 1) < 0.05
    assert all(r["settled"] for r in rows["penalty"])
    coarse, fine = (r for r in rows["gap elements"] if r["soft"] == 1e-4 and r["cycles"] == 1)
    # hundreds of increments are still twenty percent off
    assert coarse["error"] > 2 * fine["error"] > 0.01
    assert (tmp_path / "penalty_and_gaps.png").stat().st_size > 2000
