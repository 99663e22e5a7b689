"""The certificate sees what is wrong, as large as it is, and nothing else: every violation here is known by hand."""

from __future__ import annotations

import numpy as np
import pytest
import refusals
from scipy.sparse.linalg import LinearOperator

import fecontact.solvers.registry
from fecontact import InputError, SolverError
from fecontact.solvers import ContactProblem, Outcome, Residuals, Status, attempt, solve
from fecontact.solvers.scaling import scale

TOLERANCE = 1e-10
# a few roundings of numbers of order one, relative to the residual that is compared
ROUNDING = 1e-9


def residuals(S, g, forces, B=None, F=None, q=()) -> Residuals:
    problem = ContactProblem(S=np.asarray(S, float), g=np.asarray(g, float), B=B, F=F)
    return problem.residuals(np.asarray(forces, float), np.asarray(q, float))


def same(found: Residuals, penetration=0.0, tension=0.0, complementarity=0.0, equilibrium=0.0) -> None:
    """All four numbers, from above and from below."""
    expected = {
        "penetration": penetration,
        "tension": tension,
        "complementarity": complementarity,
        "equilibrium": equilibrium,
    }
    for name, value in expected.items():
        assert abs(getattr(found, name) - value) <= ROUNDING * value, name


EYE = np.eye(2)


@pytest.mark.parametrize("size", [2.0**-40, 2.0**-20, 0.25])
def test_a_violation_is_reported_with_its_size(size: float) -> None:
    # one point carries 1 and is deflected by 1: the scales of forces and of gaps
    same(residuals(EYE, [-1.0, -size], [1.0, 0.0]), penetration=size)
    # a force of the wrong sign: it also enters the sum that is the force scale, and its gap is open
    same(residuals(EYE, [-1.0, size], [1.0, -size]), tension=size / (1 + size))
    # an open gap under a force; of the two numbers the smaller one counts, on either side
    same(residuals(EYE, [size - 1.0, 0.0], [1.0, 0.0]), complementarity=size)
    same(residuals(EYE, [-1.0, 1.0], [1.0, size]), complementarity=size / (1 + size))
    # a load of 1 carried but for a share: over the row's entry times the forces, and the load
    row = np.array([[1.0, 0.0]])
    found = residuals(EYE, [-1.0, 0.0], [1.0, 0.0], row, np.array([1 - size]), [0.0])
    same(found, equilibrium=size / (2 - size))


def test_the_worst_and_the_certificate_look_at_all_four() -> None:
    for k in range(4):
        numbers = [0.0] * 4
        numbers[k] = 0.3
        assert Residuals(*numbers).worst == 0.3
        allowed = TOLERANCE * (10 if k == 0 else 1)
        for factor, within in ((0.99, True), (1.01, False)):
            numbers[k] = factor * allowed
            assert Residuals(*numbers).within(TOLERANCE) is within


def test_what_is_not_finite_is_infinitely_wrong() -> None:
    problem = ContactProblem(S=EYE, g=np.zeros(2), B=np.ones((1, 2)), F=np.zeros(1))
    for forces, q in (([np.nan, 0.0], [0.0]), ([0.0, np.inf], [0.0]), ([0.0, 0.0], [np.nan])):
        found = problem.residuals(np.array(forces), np.array(q))
        assert min(found.penetration, found.tension, found.complementarity, found.equilibrium) == np.inf


@pytest.mark.parametrize("load", [1e-300, 1e-20, 1e-8])
def test_a_load_on_a_row_of_zeros_is_left_unbalanced_by_all_of_itself(load: float) -> None:
    """Not by a load over nothing, which is infinite, nor by infinity over infinity, which is no number."""
    rows, loads = np.array([[1.0, 1.0], [0.0, 0.0]]), np.array([1.0, load])
    found = residuals(EYE, [-1.0, 1.0], [1.0, 0.0], rows, loads, [0.0, 0.0])
    # the least scale of a row is 1e-6 of the largest
    assert abs(found.equilibrium - load / (1e-6 + load)) < 1e-9 * found.equilibrium
    nothing = residuals(EYE, [-1.0, 1.0], [1.0, 0.0], np.zeros((1, 2)), np.array([load]), [0.0])
    assert nothing.equilibrium == 1


@pytest.mark.parametrize(("depth", "certified"), [(1e-12, True), (1e-9, False)])
def test_rounding_of_motions_that_cancel_is_no_penetration(depth: float, certified: bool) -> None:
    """Motions of 1e3 whose sum closes a gap of 1: their rounding is 1e-13."""
    rows, q = np.array([[1.0, 1.0], [1.0, 1.001]]), [1e3, -1e3]
    found = residuals(EYE, [-depth, 1.0], [0.0, 0.0], rows, np.zeros(2), q)
    assert found.within(TOLERANCE) is certified
    assert abs(found.penetration / (depth / (1e-4 * 2001.0)) - 1) < 1e-3


def test_what_is_no_number_is_not_certified() -> None:
    for k in range(4):
        assert not Residuals(*np.where(np.arange(4) == k, np.nan, 0.0)).within(TOLERANCE)
    for k in range(7):
        assert not Residuals(*np.where(np.arange(7) == k, np.nan, 0.0)).within(TOLERANCE)
    assert Residuals(*np.zeros(7)).within(TOLERANCE)


@pytest.mark.parametrize(("forces", "q"), [(np.zeros(3), np.zeros(1)), (np.zeros(2), np.zeros(2))])
def test_shapes_that_do_not_fit_are_refused(forces, q) -> None:
    problem = ContactProblem(S=EYE, g=np.zeros(2), B=np.ones((1, 2)), F=np.zeros(1))
    with refusals.refused(InputError, "residual-shape", "(2,)"):
        problem.residuals(forces, q)


def test_rigid_bodies_are_judged_by_a_thousandth_of_their_gaps() -> None:
    # nothing deflects: 1e-6 beside a gap of 1 is 1e-6 / 1e-3
    same(residuals(0 * EYE, [-1e-6, 1.0], [0.0, 0.0]), penetration=1e-3)
    # a deflection that is larger than that takes its place, a smaller one does not
    same(residuals(np.diag([0.0, 1.0]), [-1e-6, 1.0], [0.0, 2e-3]), penetration=5e-4, complementarity=1.0)
    same(residuals(np.diag([0.0, 1.0]), [-1e-6, 1.0], [0.0, 5e-4]), penetration=1e-3, complementarity=1.0)


def test_gaps_that_a_motion_cancels_are_judged_by_a_ten_thousandth_of_them() -> None:
    row = np.ones((1, 2))
    # after the motion one gap is left, -2^-27: its scale is 1e-4 of the gap of 1 that was there before
    g = [1.0, 1.0 - 2.0**-27]
    same(residuals(0 * EYE, g, [0.0, 0.0], row, np.zeros(1), [-1.0]), penetration=2.0**-27 / 1e-4)


def test_rows_that_are_rounding_are_judged_by_a_millionth_of_the_largest() -> None:
    rows = np.array([[1.0, 1.0], [1e-12, 0.0]])
    # the second row gives 1e-12 where nothing is asked: over 1e-6 of the largest entry, times the force
    same(residuals(EYE, [-1.0, 0.0], [1.0, 0.0], rows, np.array([1.0, 0.0]), [0.0, 0.0]), equilibrium=1e-6)
    # a row above that share is judged by itself: 1e-5 over 1e-5
    rows[1, 0] = 1e-5
    same(residuals(EYE, [-1.0, 0.0], [1.0, 0.0], rows, np.array([1.0, 0.0]), [0.0, 0.0]), equilibrium=1.0)


def test_forces_are_judged_by_the_load_where_there_are_none_yet() -> None:
    row = np.array([[2.0, 1.0]])
    # a load of 4 on a row of 2 is a force of 2: -0.5 of it is a quarter, the load 4 + 1 of the scale 4 + 4 is missing
    found = residuals(EYE, [1.0, 0.5], [0.0, -0.5], row, np.array([4.0]), [0.0])
    same(found, tension=0.25, equilibrium=4.5 / 8)


@pytest.mark.parametrize(("share", "refused"), [(0.9, False), (1.1, True)])
def test_asymmetry_and_a_negative_diagonal_are_refused_beyond_1e_8(share: float, refused: bool) -> None:
    # relative to the largest entry, which is -2 here
    skew = np.array([[1.0, -2.0], [-2.0 + 2e-8 * share, 1.0]])
    sunk = np.array([[1.0, -2.0], [-2.0, -2e-8 * share]])
    for S, message in ((skew, ("not-symmetric",)), (sunk, ("not-semidefinite",))):
        if refused:
            with refusals.refused(InputError, *message):
                ContactProblem(S=S, g=np.zeros(2))
        else:
            ContactProblem(S=S, g=np.zeros(2))


def _claims(monkeypatch, *names: str, off: float = 0.0, status: Status = Status.SOLVED) -> None:
    """Solvers that claim an answer, off by a share of the force on the only point in touch."""

    def claimed(problem, start=None, *, max_iterations=None):
        x = np.array([1.0 - off, 0.0])
        return Outcome(x, np.zeros(0), status, "so it is claimed", 1)

    for name in names:
        monkeypatch.setitem(fecontact.solvers.registry.NATIVE, name, claimed)


TOUCHING = ContactProblem(S=EYE, g=np.array([-1.0, 1.0]))


@pytest.mark.parametrize(("off", "certified"), [(0.99e-10, True), (1.01e-10, False)])
def test_a_claim_is_certified_up_to_the_tolerance(monkeypatch, off: float, certified: bool) -> None:
    _claims(monkeypatch, "active-set", off=off)
    # without a word the tolerance is 1e-10
    found = attempt(TOUCHING, "active-set")
    assert found.success is certified
    assert found.status is (Status.SOLVED if certified else Status.REFUSED)
    # the overlap that is left, over the deflection; 1 - (1 - off) has the rounding of 1
    assert abs(found.residuals.penetration / off - 1) < 1e-5
    if not certified:
        with refusals.refused(SolverError, "not-certified", "refused", "penetration 1.0e-10"):
            solve(TOUCHING, "active-set")
    assert solve(TOUCHING, "active-set", **({} if certified else {"tolerance": 2e-10})).success


def test_a_failure_is_never_certified_however_good_its_numbers(monkeypatch) -> None:
    _claims(monkeypatch, "active-set", status=Status.CYCLING)
    found = attempt(TOUCHING, "active-set")
    assert found.residuals.worst == 0.0
    assert not found.success
    with refusals.refused(SolverError, "not-certified", "cycling"):
        solve(TOUCHING, "active-set")


class Knowing(LinearOperator):
    """A compliance of two points that has a solver of its own."""

    solver = "own"

    def __init__(self, force):
        super().__init__(float, (2, 2))
        self.force, self.asked = force, 0

    def _matvec(self, x):
        return x

    def solve_contact(self, problem, tolerance):
        self.asked += 1
        return Outcome(np.array([self.force, 0.0]), np.zeros(0), Status.SOLVED, "solved", 1)


@pytest.mark.parametrize(("force", "solver"), [(1.0, "own"), (0.5, "projected-cg")])
def test_an_operators_own_solver_is_asked_first_and_believed_if_it_is_right(force: float, solver: str) -> None:
    S = Knowing(force)
    found = attempt(ContactProblem(S=S, g=TOUCHING.g))
    assert found.success
    assert found.solver == solver
    assert S.asked == 1
    assert found.residuals.worst < TOLERANCE


def test_an_operator_is_solved_by_products_where_that_is_asked_for_and_by_nothing_else() -> None:
    S = Knowing(1.0)
    problem = ContactProblem(S=S, g=TOUCHING.g)
    assert solve(problem, "projected-cg").solver == "projected-cg"
    with refusals.refused(SolverError, "needs-array"):
        solve(problem, "nnls")
    assert S.asked == 0


def test_the_best_of_several_failures_is_told(monkeypatch) -> None:
    _claims(monkeypatch, "active-set", off=1e-3)
    monkeypatch.setattr(fecontact.solvers.registry, "FALL_BACK", ("active-set", "nnls"))
    monkeypatch.setitem(
        fecontact.solvers.registry.NATIVE,
        "nnls",
        lambda problem, start=None: Outcome(np.zeros(2), np.zeros(0), Status.ITERATION_LIMIT, "too few", 1),
    )
    found = attempt(TOUCHING)
    assert found.status is Status.REFUSED
    assert found.solver == "active-set"
    assert found.message == "active-set: the answer does not pass the certificate; nnls: too few"


def test_a_claim_is_sharpened_where_that_helps(monkeypatch) -> None:
    _claims(monkeypatch, "nnls", off=1e-3)
    # one equality solve on the point that the claim says is in touch finds the force
    assert solve(TOUCHING, "nnls").residuals.worst == 0.0


def test_scaled_rows_by_the_tolerances_of_rank() -> None:
    # the second row: of length 1e-15 beside the first says nothing, of 1e-13 it is a row
    for length, rank in ((1e-15, 1), (1e-13, 2)):
        B = np.array([[1.0, 0.0], [0.0, length]])
        assert scale(EYE, np.ones(2), B, np.zeros(2)).r == rank
    # rows at an angle of 1e-12 are one, of 1e-10 two
    for angle, rank in ((1e-12, 1), (1e-10, 2)):
        B = np.array([[1.0, 0.0], [1.0, angle]])
        assert scale(EYE, np.ones(2), B, np.ones(2)).r == rank


@pytest.mark.parametrize(("share", "refused"), [(0.9e-10, False), (1.2e-10, True)])
def test_loads_that_contradict_each_other_or_cannot_be_carried_are_refused_beyond_1e_10(share, refused) -> None:
    # twice the same row: what is left of the loads (1, 1 + e) along (1, -1) is e / 2 of their norm
    twice = scale(EYE, np.ones(2), np.ones((2, 2)), np.array([1.0, 1.0 + 2 * share]))
    assert bool(twice.inconsistency.any()) is refused
    assert (twice.free_direction() is not None) is refused
    # two rows, one of which is asked to pull a little: the share of the load that stays unbalanced
    pulled = scale(EYE, np.ones(2), EYE, np.array([1.0, -share]))
    assert (pulled.free_direction() is not None) is refused
