"""The law of friction at points: every figure here is known by hand, or by minimisation over directions."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact.solvers
from fecontact import InputError
from fecontact.solvers import ContactProblem, Residuals, solve, solve_friction
from fecontact.solvers.coulomb import (
    ResidualScales,
    friction_limit,
    natural_map,
    projected,
    sticks,
    with_held_directions,
)

SCALES = ResidualScales(force=4.0, gap=2.0, point=1.0)
CERTIFIED = Residuals(0.0, 0.0, 0.0, 0.0)


def residuals(t, s, limit) -> Residuals:
    return CERTIFIED.with_friction(np.array(t, float), np.array(s, float), np.array(limit, float), SCALES)


def test_an_infinite_coefficient_holds_what_is_pressed_and_nothing_else() -> None:
    normal = np.array([2.0, 0.0, -1.0])
    assert friction_limit(np.inf, normal).tolist() == [np.inf, 0.0, 0.0]
    assert friction_limit(np.array([0.5, 1.0, 1.0]), normal).tolist() == [1.0, 0.0, 0.0]


def test_the_projection_is_the_nearest_point_of_the_disc() -> None:
    rng = np.random.default_rng(0)
    t, limit = rng.normal(size=(2, 40)), rng.uniform(0.1, 1.5, 40)
    angle = np.linspace(0, 2 * np.pi, 20001)
    rim = limit[:, None] * np.stack([np.cos(angle), np.sin(angle)])[:, None]
    square = ((t[:, :, None] - rim) ** 2).sum(axis=0).min(axis=1)
    inside = np.hypot(*t) <= limit
    found = np.hypot(*(t - projected(t, limit)))
    assert not found[inside].any()
    # the nearest of the directions is half a step away at most: of forces below 4
    assert np.abs(found**2 - square)[~inside].max() < 1.5 * 4 * (np.pi / 20000) ** 2
    # along a line, discs are intervals
    assert projected(np.array([[-3.0, 0.5]]), np.ones(2)).tolist() == [[-1.0, 0.5]]


def test_what_is_on_the_rim_slides() -> None:
    limit = np.array([1.0, 1.0, 0.0, np.inf])
    assert sticks(np.array([[1.0 - 2e-9, 1.0 - 0.5e-9, 0.0, 9.0]]), limit).tolist() == [True, False, False, True]


def test_the_law_holds_where_and_only_where_the_natural_map_vanishes() -> None:
    limit = np.ones(3)
    right = np.array([[0.6, 0.3, 0.0], [0.8, 0.1, -1.0]]), np.array([[-0.3, 0.0, 0.0], [-0.4, 0.0, 2.0]])
    assert np.abs(natural_map(*right, limit, 7.0)).max() < 1e-15
    turned = right[0], np.array([[-0.4, 0.0, 0.0], [-0.3, 0.0, 2.0]])
    assert np.abs(natural_map(*turned, limit, 7.0)).max() > 0.1


@pytest.mark.parametrize("size", [2.0**-30, 2.0**-10])
def test_a_violation_is_reported_with_its_size(size: float) -> None:
    # beyond the cone, without slip: the excess over the largest force
    found = residuals([[1 + size]], [[0.0]], [1.0])
    assert (found.cone, found.slip, found.dissipation) == (size, size, 0.0)
    # a slip inside the cone: over the gap scale of 2, and no friction that dissipates over a thousandth of 2 x 4
    found = residuals([[0.0]], [[size]], [1.0])
    assert (found.cone, found.slip) == (0.0, size / 2)
    assert found.dissipation == pytest.approx(size / max(size, 8e-3), rel=1e-12)
    # friction along the slip in place of against it
    assert residuals([[1.0]], [[size]], [1.0]).dissipation == pytest.approx(2 * size / max(size, 8e-3), rel=1e-12)
    # a rough point bears any force, and does not slip
    found = residuals([[9.0]], [[size]], [np.inf])
    assert (found.cone, found.slip, found.dissipation) == (0.0, size / 2, 0.0)


def test_the_work_of_rounding_in_motions_that_cancel_is_none() -> None:
    slip = np.array([[1e-9]])
    plain, moved = (
        CERTIFIED.with_friction(np.zeros((1, 1)), slip, np.ones(1), ResidualScales(4.0, 2.0, 1.0, motion))
        for motion in (0.0, 2e5)
    )
    # a tenth of the motions takes the place of the gap scale
    assert plain.dissipation == pytest.approx(1e4 * moved.dissipation, rel=1e-12)


def test_a_direction_held_on_both_sides_bears_nothing() -> None:
    S = np.diag([1.0, 3.0, 0.0, 0.0])
    tangents = np.array([[2], [3]])
    assert with_held_directions(S, tangents).diagonal().tolist() == [1.0, 3.0, 1.0, 1.0]
    # a motion by an equilibrium row is no hold
    assert with_held_directions(S, tangents, np.array([[0.0, 0.0, 0.0, 1.0]])).diagonal().tolist() == [1, 3, 1, 0]
    assert S[2, 2] == 0.0
    g = np.array([-1.0, -3.0, 0.0, 0.0])
    held = ContactProblem(with_held_directions(S, tangents), g, points=[0, 1], tangents=tangents, mu=[0.3, 0.3])
    assert solve_friction(held).forces.round(12).tolist() == [1.0, 1.0, 0.0, 0.0]


@pytest.mark.parametrize(("compliance", "held"), [(0.0, True), (1e-6, False)])
def test_a_held_direction_that_a_tilted_tangent_misses_bears_no_force(compliance: float, held: bool) -> None:
    # two points on a body held along y; a belt is a millionth as soft along y, but not held
    C = np.kron([[1.0, 0.2], [0.2, 1.0]], np.diag([0.5, compliance, 1.0]))
    points, tangents = np.array([0, 3]), np.array([[1, 2], [4, 5]])
    moved = np.tile([0.4, 0.0, -1.0], 2)  # dragged along x, pressed along z

    def forces(tilt: float) -> np.ndarray:
        across = np.array([0.0, np.cos(tilt), np.sin(tilt)])
        normal = np.array([0.0, -np.sin(tilt), np.cos(tilt)])
        rows = np.kron(np.eye(2), np.stack([normal, across, [1.0, 0.0, 0.0]]))
        S = with_held_directions(rows @ C @ rows.T, tangents, None, points)
        assert (np.abs(S - rows @ C @ rows.T).max() > 0.1) == held
        if not held:
            return np.zeros(6)
        problem = ContactProblem(S, rows @ moved, points=points, tangents=tangents, mu=np.full(2, 0.5))
        return solve_friction(problem).forces

    assert np.abs(forces(1e-3) - forces(0.0)).max() < 2e-3
    assert np.abs(forces(1e-3) - forces(0.0))[[0, 2, 3, 5]].max() < 1e-5


def test_without_friction_there_are_four_residuals() -> None:
    assert set(CERTIFIED.as_dict()) == {"penetration", "tension", "complementarity", "equilibrium"}
    assert "cone" not in str(CERTIFIED)
    assert len(residuals([[0.0]], [[0.0]], [1.0]).as_dict()) == 7


def test_a_problem_with_friction_is_not_solved_without() -> None:
    one = np.array([0])
    problem = ContactProblem(np.eye(2), -np.ones(2), points=one, tangents=np.array([[1]]), mu=np.array([0.3]))
    with refused(InputError, "has-friction"):
        solve(problem)
    assert solve_friction(problem).success
    assert solve(ContactProblem(np.eye(2), -np.ones(2))).success


def test_former_names_work_and_warn() -> None:
    for old, new in (("ComplementarityProblem", ContactProblem), ("FrictionResiduals", Residuals)):
        with pytest.warns(DeprecationWarning, match=f"{old} is now {new.__name__}"):
            assert getattr(fecontact.solvers, old) is new
    with pytest.raises(AttributeError, match="no attribute 'Nothing'"):
        fecontact.solvers.Nothing  # noqa: B018
