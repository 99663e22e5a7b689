"""Contact with Coulomb friction on condensed points: solutions, certificate, limits and refusals."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.optimize import minimize
from scipy.sparse import csc_array

from fecontact import InputError, SolverError
from fecontact.solvers import (
    ContactProblem,
    InfeasibleLoadError,
    ScaledProblem,
    SlidingLoadError,
    Status,
    solve,
    solve_friction,
)
from fecontact.solvers import friction_newton as newton
from fecontact.solvers.friction_newton import DIVERGED, _Inverse, _System, friction_newton, friction_sweeps
from fecontact.solvers.friction_slide import least_friction, unbalanced_motion


def random_problem(rng: np.random.Generator, f: int, k: int, mu: float, loaded: bool) -> ContactProblem:
    """f points with k tangents and a dense compliance; loaded: pressed by f and dragged by less than friction holds."""
    n = f * (1 + k)
    A = rng.normal(size=(n, 2 * n))
    tangents = f + np.arange(f * k).reshape(f, k)
    B, F = np.zeros((0, n)), np.zeros(0)
    if loaded:
        B = np.zeros((1 + k, n))
        B[0, :f] = 1
        for j in range(k):
            B[1 + j, tangents[:, j]] = 1
        F = np.zeros(1 + k)
        F[:2] = f, 0.3 * mu * f
    rows = ContactProblem(A @ A.T / n + 0.1 * np.eye(n), rng.normal(size=n), B, F)
    return replace(rows, points=np.arange(f), tangents=tangents, mu=np.full(f, mu))


def test_the_residual_is_that_of_forces_whatever_the_weight_of_gaps() -> None:
    """The weight changes the way; where it begins and when it ends are judged alike."""
    scaled = random_problem(np.random.default_rng(7), 6, 2, 0.4, True).scaled()
    start = np.zeros(scaled.n), np.zeros(scaled.r)
    plain, heavy = (friction_newton(scaled, *start, weight=weight)[0] for weight in (1.0, 1e3))
    assert plain.status is heavy.status is Status.SOLVED
    assert heavy.history[0] == plain.history[0]
    assert np.abs(heavy.x - plain.x).max() < 1e-10 * np.abs(plain.x).max()


def cone_programmes(problem: ContactProblem, rounds: int = 80) -> np.ndarray:
    """Forces (N,) by the fixed point of Acary & Cadoux (2013): gaps widened by mu |s| make Coulomb's law associated.

    Each round minimises the complementary energy with the slip of the last one: r . S r / 2 + (g + mu |s| e_n) . r
    over forces within the cones, subject to B r = F; its multipliers are the rigid motion.
    """
    clarabel = pytest.importorskip("clarabel")
    points, tangents, mu = problem.points, problem.tangents, problem.mu
    n, k = problem.n, tangents.shape[1]
    cones = np.zeros((len(points), 1 + k, n))
    at = np.arange(len(points))
    cones[at, 0, points] = -mu
    for j in range(k):
        cones[at, 1 + j, tangents[:, j]] = -1
    A = csc_array(np.concatenate([problem.B, cones.reshape(-1, n)]))
    b = np.concatenate([problem.F, np.zeros(len(points) * (1 + k))])
    kinds = [clarabel.ZeroConeT(len(problem.F))] if len(problem.F) else []
    kinds += [clarabel.SecondOrderConeT(1 + k)] * len(points)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    slip = np.zeros(len(points))
    for _ in range(rounds):
        widened = problem.g.copy()
        widened[points] += mu * slip
        P = csc_array(np.triu(problem.S))
        found = clarabel.DefaultSolver(P, widened, A, b, kinds, settings).solve()
        forces = np.asarray(found.x)
        moved = problem.S @ forces + problem.g + problem.B.T @ np.asarray(found.z)[: len(problem.F)]
        last, slip = slip, np.linalg.norm(moved[tangents], axis=1)
        if np.abs(slip - last).max() <= 1e-10 * max(np.abs(moved).max(), 1e-300):
            break
    return forces


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.8, 2.0])
def test_random_problems_are_certified(k: int, loaded: bool, mu: float) -> None:
    rng = np.random.default_rng(1)
    for f in (1, 3, 12, 30):
        found = solve_friction(random_problem(rng, f, k, mu, loaded))
        assert found.success
        assert found.residuals.worst < 1e-11  # rounding of a dense solve, ten times below the certificate
        assert found.friction_work > -1e-12


def test_without_friction_the_answer_is_the_frictionless_one() -> None:
    rng = np.random.default_rng(2)
    problem = random_problem(rng, 25, 2, 0.0, loaded=False)
    found = solve_friction(problem)
    bare = solve(problem.normal_problem(np.zeros(75)))
    assert np.abs(found.forces[:25] - bare.forces).max() <= 1e-12 * bare.forces.max()
    assert not found.tangential.any()


def test_sweeps_find_the_same_forces() -> None:
    """Block Gauss-Seidel shares nothing with Newton's method but the problem."""
    rng = np.random.default_rng(3)
    for mu in (0.2, 0.7):
        problem = random_problem(rng, 20, 2, mu, loaded=True)
        scaled = problem.scaled()
        swept = friction_sweeps(scaled, np.zeros(60), np.zeros(3), tolerance=1e-9, max_iterations=5000)
        assert swept.status == "solved"
        exact = solve_friction(problem).forces
        assert np.abs(scaled.forces(swept.x) - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.filterwarnings("error")
def test_sweeps_leave_a_point_that_gives_way_to_no_force() -> None:
    """Two points beside each other, the second of no compliance; the first has the force of its own gap, 1, by hand."""
    empty = np.zeros((0, 4))
    scaled = ScaledProblem(
        np.diag([1.0, 0.0, 1.0, 0.0]), np.array([-1.0, 0.0, -0.2, 0.0]), empty, np.zeros(0), np.ones(4), np.ones(4),
        np.zeros((0, 0)), np.zeros(0), np.arange(2), np.array([[2], [3]]), np.full(2, 0.5), np.zeros(2, bool),
    )  # fmt: skip
    swept = friction_sweeps(scaled, np.array([0.0, 0.3, 0.0, 0.1]), np.zeros(0))
    np.testing.assert_allclose(swept.x, [1.0, 0.3, 0.2, 0.1], rtol=0, atol=1e-15)  # no sums: no rounding but one


@pytest.mark.parametrize("coupling", [0.9, 1.5])
@pytest.mark.parametrize("size", [1e-8, 1.0, 1e8])
def test_sweeps_stop_where_they_diverge(coupling: float, size: float) -> None:
    """Two rough points pressed by `size` whose slips are coupled: every sweep multiplies their forces by coupling^2."""
    S = np.eye(4)
    S[2, 3] = S[3, 2] = coupling
    g = size * np.array([-1.0, -1.0, 1.0, 0.0])
    empty = np.zeros((0, 4))
    scaled = ScaledProblem(
        S, g, empty, np.zeros(0), np.ones(4), np.ones(4), np.zeros((0, 0)), np.zeros(0),
        np.arange(2), np.array([[2], [3]]), np.full(2, np.inf), np.zeros(2, bool),
    )  # fmt: skip
    swept = friction_sweeps(scaled, np.zeros(4), np.zeros(0))
    if coupling < 1:
        assert swept.status == "solved"
        exact = -size / (1 - coupling**2) * np.array([1, -coupling])  # by hand
        np.testing.assert_allclose(swept.x[2:], exact, rtol=1e-3)
    else:
        assert "diverged" in swept.message
        assert abs(swept.nit - np.log(DIVERGED) / np.log(coupling**2)) < 3
        assert np.abs(swept.x).max() <= DIVERGED * size
    np.testing.assert_array_equal(swept.x[:2], [size, size])


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("loaded", [False, True])
@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_cone_programmes_find_the_same_forces(k: int, loaded: bool, mu: float) -> None:
    """A method and a solver of others. Tolerance: an interior point method ends near 1e-8 at the edge of stick."""
    problem = random_problem(np.random.default_rng(5), 12, k, mu, loaded)
    found, other = solve_friction(problem), cone_programmes(problem)
    assert (np.linalg.norm(found.tangential, axis=1) > 0.99 * mu * found.forces[:12]).any()  # something slides
    assert np.abs(found.forces - other).max() <= 1e-6 * np.abs(other).max()


def test_newton_is_quadratic_at_the_end() -> None:
    problem = random_problem(np.random.default_rng(4), 40, 2, 0.3, loaded=True)
    found = solve_friction(problem)
    assert found.nit <= 12
    before, last = found.history[-2:]
    assert last < 1e-3 * before


def test_a_single_point_by_hand() -> None:
    """One point pressed by 1 and moved sideways by 1 with unit compliances: it slides at mu and gives 1 - mu."""
    rows = ContactProblem(np.eye(2), np.array([0.0, 1.0]), np.array([[1.0, 0.0]]), np.array([1.0]))
    problem = replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3]))
    found = solve_friction(problem)
    np.testing.assert_allclose(found.forces, [1.0, -0.3], atol=1e-14)
    np.testing.assert_allclose(found.slip, [[0.7]], atol=1e-14)
    assert found.sliding.all()
    assert abs(found.friction_work - 0.21) < 1e-14


def test_rough_points_stick_while_they_touch() -> None:
    rows = ContactProblem(np.eye(2), np.array([0.0, 1.0]), np.array([[1.0, 0.0]]), np.array([1.0]))
    found = solve_friction(replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([np.inf])))
    np.testing.assert_allclose(found.forces, [1.0, -1.0], atol=1e-14)
    assert not found.sliding.any()
    apart = ContactProblem(np.eye(2), np.array([1.0, 1.0]))
    found = solve_friction(replace(apart, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([np.inf])))
    assert found.status == "no-contact"


@pytest.mark.parametrize(
    ("change", "which", "size"),
    [
        ([0, 0, 1e-3, 0], "cone", 1e-3 / 1.09),
        ([0, 0, -1e-3, 0], "slip", None),
        ([0, 0, 0, 1e-3], "slip", None),
        ([1e-3, 0, 0, 0], "penetration", None),
    ],
)
def test_a_known_violation_is_reported(change: list[float], which: str, size: float | None) -> None:
    """Two decoupled points, the first pressed in by 1 and slid by 1 along y, mu = 0.3; the second is open."""
    tangents = np.array([[2, 3], [4, 5]])
    g = np.array([-1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    problem = replace(ContactProblem(np.eye(6), g), points=np.arange(2), tangents=tangents, mu=np.full(2, 0.3))
    exact = np.array([1.0, 0.0, -0.3, 0.0, 0.0, 0.0])
    assert problem.residuals(exact, np.zeros(0)).worst < 1e-15
    wrong = exact + np.array([-change[0], change[1], -change[2], change[3], 0.0, 0.0])
    found = getattr(problem.residuals(wrong, np.zeros(0)), which)
    assert found > 1e-5
    if size is not None:
        assert abs(found / size - 1) < 0.3  # the force scale is the sum of all forces


def lifted(mu: float) -> ContactProblem:
    """A drag of 3 lifts a point pressed in by 1: stuck, its force is (1 - 3 / 2) / (3 / 4); open, it penetrates by 1.

    With a finite mu it slides under l = 1 / (1 + mu / 2), t = mu l, which is 2 in the limit.
    """
    S = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]])
    rows = ContactProblem(S, np.array([-1.0, -3.0, 0.0]))
    return replace(rows, points=np.array([0]), tangents=np.array([[1, 2]]), mu=np.array([mu]))


@pytest.mark.parametrize("mu", [0.5, 1e3, 1e6])
def test_a_drag_that_lifts_slides_under_any_friction(mu: float) -> None:
    found = solve_friction(lifted(mu))
    np.testing.assert_allclose(found.forces, np.array([1.0, mu, 0.0]) / (1 + mu / 2), atol=1e-12)


def test_infinite_friction_is_the_limit_of_growing_friction() -> None:
    found = solve_friction(lifted(np.inf))
    np.testing.assert_allclose(found.forces, [0.0, 2.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(found.slip, [[-1.0, 0.0]], atol=1e-14)
    assert found.touching.all()
    assert found.sliding.all()


@pytest.mark.parametrize(("forces", "why"), [
    ([0.0, 2.0, 0.5], "its force is not against its slip"),
    ([0.0, 3.5, 0.0], "the force drives the slip, and it penetrates"),
    ([0.0, 1.0, 0.0], "it penetrates"),
    ([0.0, 2.0 + 1e-6, 0.0], "it slides at a gap"),
    ([1.0, 2.0, 0.0], "it is pressed, and slides"),
])  # fmt: skip
def test_what_slides_without_pressure_is_closed_and_dragged(forces: list[float], why: str) -> None:
    assert not lifted(np.inf).residuals(np.array(forces), np.zeros(0)).within(1e-10), why


@pytest.mark.parametrize("k", [1, 2])
def test_held_bodies_have_a_state_under_infinite_friction(k: int) -> None:
    """Where stuck points would be lifted, too: there is one as the limit of bounded states of growing friction."""
    rng = np.random.default_rng(4)
    found = [solve_friction(random_problem(rng, 6, k, np.inf, loaded=False)) for _ in range(27 // k**2)]
    assert max(each.residuals.worst for each in found) < 1e-11
    assert sum(each.sliding.sum() for each in found) >= 1


def test_dissipation_tells_forces_that_do_not_oppose_slip() -> None:
    g, first = np.array([-1.0, 1.0, 0.0]), np.array([0])
    problem = ContactProblem(np.eye(3), g, points=first, tangents=np.array([[1, 2]]), mu=np.array([0.3]))
    turned = np.array([1.0, 0.0, -0.3])  # across the slip, on the rim of the cone
    found = problem.residuals(turned, np.zeros(0))
    assert found.cone < 1e-15
    assert found.dissipation > 0.5
    assert found.slip > 0.1


@pytest.mark.parametrize("mu", [0.5, 50.0])
@pytest.mark.parametrize(
    ("share", "certified"), [(0.0, True), (1e-15, True), (1e-14, True), (1e-12, False), (1e-9, False)]
)
def test_rounding_of_what_sticks_is_no_dissipation(mu: float, share: float, certified: bool) -> None:
    """Eight points that stick: a slip of 45 units of rounding of what cancels in it is none, a hundred times it counts.

    Tangential forces are too large by a share, which is a slip of 0.3 shares of a limit of mu.
    """
    points, tangents = np.arange(8), np.arange(8, 16)[:, None]
    g = np.repeat([-1.0, 0.3], 8)
    problem = replace(ContactProblem(np.eye(16), g), points=points, tangents=tangents, mu=np.full(8, mu))
    found = problem.residuals(np.repeat([1.0, -0.3 * (1 + share)], 8), np.zeros(0))
    assert found.within(1e-10) is certified
    slip = 0.3 * (1 + share) - 0.3
    work = 1e-3 * max(8 * mu, 8 * 1.3)
    np.testing.assert_allclose(found.dissipation, 8 * slip * (mu + 0.3) / work, rtol=1e-3, atol=1e-18)


def test_the_work_of_rounding_is_no_dissipation() -> None:
    """A stuck point whose slip is the difference of motions of 1: rounding of 1e-15; a slip of 1e-9 still counts."""
    rows = ContactProblem(1e-3 * np.eye(2), np.zeros(2), np.array([[0.0, 1.0], [0.0, 1.0]]), np.zeros(2))
    problem = replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3]))
    for slip, certified in ((3e-16, True), (1e-9, False)):
        found = problem.residuals(np.array([1.0, 0.1]), np.array([1.0, -1.0 - 1e-4 + slip]))
        assert (found.dissipation <= 1e-10) is certified


def test_small_forces_hold_the_slip_of_what_is_pressed() -> None:
    """Points pressed by 1, one dragged, the others by less than rounding of the pressures; an open one has no force."""
    n, drift = 31, 9e-14
    g = np.concatenate([np.full(n - 1, -1.0), [1.0], [1e-3], np.full(n - 1, drift)])
    rows = ContactProblem(np.eye(2 * n), g, np.zeros((0, 2 * n)), np.zeros(0))
    problem = replace(rows, points=np.arange(n), tangents=n + np.arange(n)[:, None], mu=np.full(n, 3.0))
    found = solve_friction(problem)
    assert found.residuals.within(1e-10)
    assert np.abs(found.tangential[1:-1] + drift).max() < 1e-16
    assert found.forces[n - 1] == found.tangential[-1, 0] == 0.0


def test_a_motion_that_nothing_feels_is_none() -> None:
    """One of two points touches and sticks; the body is free to turn about it, and came from a turn of 5."""
    B = np.array([[0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]])  # shift of both; turn about the first, opens the second
    rows = ContactProblem(np.eye(4), np.array([-1.0, 1.0, 0.0, 0.0]), B, np.zeros(2))
    problem = replace(rows, points=np.arange(2), tangents=np.array([[2], [3]]), mu=np.full(2, 0.3))
    solution = solve_friction(problem, (np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 5.0])))
    np.testing.assert_allclose(solution.forces, [1.0, 0.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(solution.q, 0.0, atol=1e-12)
    # where the second would be closed by it, the motion stays
    over = replace(problem, g=np.array([-1.0, -2.0, 0.0, 0.0]))
    kept = solve_friction(over, (np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 5.0])))
    assert kept.residuals.worst < 1e-10
    assert abs(kept.q[1] - 5) < 1e-12


def test_a_drag_beyond_friction_is_refused_with_the_friction_that_holds() -> None:
    rows = ContactProblem(np.eye(2), np.zeros(2), np.eye(2), np.array([1.0, 0.31]))
    with refused(InfeasibleLoadError, "no-balance", "0.31") as caught:
        solve_friction(replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3])))
    slid = caught.value.direction
    assert slid @ rows.F < 0
    assert solve_friction(replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3101]))).success


def test_a_drag_that_no_pressures_found_can_hold_is_told() -> None:
    """A point pressed in by 1 with unit compliance holds 0.3; the load of 0.31 is within a cone, but not this one's."""
    rows = ContactProblem(np.eye(2), np.array([-1.0, 0.0]), np.array([[0.0, 1.0]]), np.array([0.31]))
    with refused(InfeasibleLoadError, "slides-as-a-whole", "0.9677", "0.31"):
        solve_friction(replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3])))
    held = replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.32]))
    assert solve_friction(held).tangential[0, 0] == pytest.approx(0.31, rel=1e-12)


def clamped(mu: float, load: np.ndarray) -> ContactProblem:
    """Four points on a unit circle, pressed in by 1, 2, 3 and 4; the body is free along x and y and about z."""
    angle = np.arange(4) * np.pi / 2
    tangents = 4 + np.arange(8).reshape(2, 4).T
    B = np.zeros((3, 12))
    B[0, tangents[:, 0]] = B[1, tangents[:, 1]] = 1.0
    B[2, tangents] = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    g = np.concatenate([-np.arange(1.0, 5.0), np.zeros(8)])
    return replace(ContactProblem(np.eye(12), g, B, load), points=np.arange(4), tangents=tangents, mu=np.full(4, mu))


@pytest.mark.parametrize("load", [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.6, -0.3, 0.4)])
def test_a_clamped_body_is_held_up_to_its_limit(load: tuple[float, ...]) -> None:
    """The limit is the least work of friction on motions on which the load works 1 (upper bound theorem)."""
    F, mu = np.array(load), 0.25
    given = clamped(mu, F)
    along, across = F / (F @ F), np.linalg.svd(F[None])[2][1:]

    def work(free: np.ndarray) -> float:
        slips = (along + free @ across) @ given.B[:, given.tangents].transpose(1, 0, 2)
        return float(mu * np.arange(1.0, 5.0) @ np.linalg.norm(slips, axis=1))

    limit = min(minimize(work, at, method="Nelder-Mead", tol=1e-10).fun for at in ([0.0, 0.0], [1.0, -1.0]))
    assert solve_friction(clamped(mu, 0.999 * limit * F)).success
    with refused(SlidingLoadError, "slides-as-a-whole") as caught:
        solve_friction(clamped(mu, 1.02 * limit * F))
    assert caught.value.direction @ F < 0
    share, needed = (float(n) for n in re.findall(r"holds (\S+) of .* mu = (\S+),", str(caught.value))[0])
    assert abs(share - 1 / 1.02) < 1e-3
    assert abs(needed - 1.02 * mu) < 1e-3 * mu
    assert solve_friction(clamped(1.002 * needed, 1.02 * limit * F)).success


def test_no_friction_holds_a_pull() -> None:
    rows = ContactProblem(np.eye(2), np.zeros(2), np.eye(2), np.array([-1.0, 0.1]))
    with refused(InfeasibleLoadError, "no-balance", "No friction would hold it"):
        solve_friction(replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3])))


def test_the_cone_is_round() -> None:
    """Drags of one size in any direction need the same friction."""
    rng = np.random.default_rng(5)
    for angle in rng.uniform(0, 2 * np.pi, 5):
        F = np.array([1.0, 0.4 * np.cos(angle), 0.4 * np.sin(angle)])
        rows = ContactProblem(np.eye(3), np.zeros(3), np.eye(3), F)
        problem = replace(rows, points=np.array([0]), tangents=np.array([[1, 2]]), mu=np.array([0.39]))
        scaled = problem.scaled()
        assert unbalanced_motion(scaled) is not None
        assert abs(least_friction(scaled) - 0.4) < 1e-5
        assert unbalanced_motion(replace(scaled, mu=np.array([0.4001]))) is None


def test_units_do_not_matter() -> None:
    given = random_problem(np.random.default_rng(6), 15, 2, 0.4, loaded=True)
    base = solve_friction(given)
    force, length = 3e7, 2e-9
    other = replace(given, S=given.S * length / force, g=given.g * length, F=given.F * force)
    found = solve_friction(other)
    assert np.abs(found.forces / force - base.forces).max() < 1e-9 * np.abs(base.forces).max()


def test_a_wrong_newton_answer_is_not_returned(monkeypatch: pytest.MonkeyPatch) -> None:
    import fecontact.solvers.friction as module

    def wrong(*args: object, **options: object) -> object:
        outcome, orientation = friction_newton(*args, **options)
        return replace(outcome, x=outcome.x * 1.01), orientation

    monkeypatch.setattr(module, "friction_newton", wrong)
    with refused(SolverError, "not-certified"):
        solve_friction(random_problem(np.random.default_rng(7), 5, 2, 0.3, loaded=True))


@pytest.mark.parametrize("mu", [-0.1, np.nan])
def test_senseless_coefficients_are_refused(mu: float) -> None:
    rows = ContactProblem(np.eye(2), np.zeros(2))
    with refused(InputError, "input", "coefficient of friction"):
        replace(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([mu]))


def test_rows_that_do_not_fit_are_refused() -> None:
    rows = ContactProblem(np.eye(3), np.zeros(3))
    for points, tangents in (([0], [[0]]), ([0], [[3]]), ([0, 1], [[2]]), ([0], [[1, 2, 2]])):
        with pytest.raises(InputError):
            replace(rows, points=np.array(points), tangents=np.array(tangents), mu=np.full(len(points), 0.1))


@pytest.mark.parametrize("few", [1, 10**6], ids=["brought up to date", "anew"])
def test_steps_by_the_inverse_are_those_of_the_whole_system(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against LAPACK's solution and determinant of the whole matrix: errors of cond times 2e-16, 1e-10 with its check.

    Sections and surfaces, with equilibrium and without, bare points that are given to slide, and signs of both kinds.
    """
    signs, by_inverse = [], _System._by_inverse

    def checked(self: _System, inverse: _Inverse, right: np.ndarray) -> tuple[np.ndarray, int] | None:
        found, A = by_inverse(self, inverse, right), self._array()
        assert found is not None
        exact = np.linalg.solve(A, right)
        assert np.abs(found[0] - exact).max() <= 1e-9 * np.abs(exact).max()
        assert found[1] == np.linalg.slogdet(A)[0] * (-1) ** self.problem.r
        signs.append(found[1])
        return found

    monkeypatch.setattr(newton, "MANY", 1)
    monkeypatch.setattr(newton, "FEW", few)
    monkeypatch.setattr(_System, "_by_inverse", checked)
    for k, mu, loaded in ((1, 0.4, False), (2, 0.4, True), (2, 3.0, False), (2, np.inf, False)):
        for seed in range(3):
            problem = random_problem(np.random.default_rng(seed), 20, k, mu, loaded)
            found = solve_friction(problem)
            assert found.residuals.worst < 1e-11
    assert set(signs) == {1, -1}


def test_an_inverse_brought_up_to_date_is_that_of_its_rows() -> None:
    """Rows left out, added and both, against NumPy's inverse: errors of cond 1e2 times 2e-16."""
    rng = np.random.default_rng(0)
    A = rng.standard_normal((40, 80))
    S, first = A @ A.T / 80, np.arange(5, 35)
    known = [_Inverse.of(S, first, [])]
    for rows in (first, first[:-2], np.arange(5, 37), np.delete(np.arange(3, 35), [4, 9])):
        found = _Inverse.of(S, rows, known)
        np.testing.assert_allclose(found.array, np.linalg.inv(S[np.ix_(rows, rows)]), rtol=0, atol=1e-12)
        assert (found is known[0]) == np.array_equal(rows, first)


def test_steps_of_rows_that_depend_on_each_other_are_those_of_the_whole_system(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every point twice: its compliance has no inverse, and the forces of both together are those of one."""
    single = random_problem(np.random.default_rng(3), 6, 2, 0.3, False)
    points = np.arange(12)
    rows = np.concatenate([np.repeat(np.arange(6), 2), np.repeat(single.tangents, 2, axis=0).T.ravel()])
    tangents = 12 + np.arange(24).reshape(2, 12).T
    double = ContactProblem(single.S[np.ix_(rows, rows)], single.g[rows])
    double = replace(double, points=points, tangents=tangents, mu=np.full(12, 0.3))
    with pytest.raises(np.linalg.LinAlgError):
        _Inverse.of(double.S - 1e-12 * np.eye(36), np.arange(36), [])
    monkeypatch.setattr(newton, "MANY", 1)
    found, exact = solve_friction(double).forces, solve_friction(single).forces
    together = np.zeros(18)
    np.add.at(together, rows, found)
    assert np.abs(together - exact).max() < 1e-9 * np.abs(exact).max()
