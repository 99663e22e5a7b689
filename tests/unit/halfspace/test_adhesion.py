"""Adhesion on half-spaces: the attraction's energy, states, curves, what is refused and warned of."""

from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import adhesion
from fecontact.halfspace.adhesion import Adhesive, Given
from fecontact.halfspace.attraction import Centres, cut_triangles
from tests.refusals import refused

BALL = fc.surfaces.Paraboloid(1.0)
WORK = 1e-5
#: Units of force and approach of a ball of radius 1 on E* = 1.
FORCE, APPROACH = np.pi * WORK, (np.pi * WORK * 0.75) ** (2 / 3)


def half(cells, size=0.12, **options):
    return fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(size, size), cells=(cells, cells), **options)


def law(lam):
    traction = lam / 2 * (np.pi * WORK * (4 / 3) ** 2) ** (1 / 3)
    return fc.Dugdale(work=WORK, range=WORK / traction)


@pytest.fixture(scope="module")
def loop():
    on = np.linspace(-8.6e-4, -2e-4, 4)
    return half(24, 0.096).curve(BALL, approaches=np.r_[on, on[::-1]], adhesion=law(1.0))


def test_positive_part_over_triangles_by_points():
    values = np.random.default_rng(0).normal(size=(40, 3))
    moments, mean, *_ = cut_triangles(values)
    n = 400
    x, y = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
    fold = x + y > 1
    shapes = np.stack([np.where(fold, 1 - x, x), np.where(fold, 1 - y, y)])
    shapes = np.stack([1 - shapes.sum(axis=0), *shapes]).reshape(3, -1)
    f = values @ shapes
    assert np.abs(np.maximum(f, 0).mean(axis=1) - mean).max() < 2e-5
    assert np.abs((f > 0) @ shapes.T / shapes.shape[1] - moments).max() < 1e-3  # points are 1/400 apart


@pytest.mark.parametrize("closed", [(False, False), (True, False)])
def test_shares_are_the_slopes_of_the_depth_and_points_those_of_the_shares(closed):
    gap = np.random.default_rng(1).normal(size=(6, 7))
    gap[2, 3] = np.inf
    centres = Centres(gap.shape, closed)
    at, step = centres.zone(gap, 0.3), 1e-6
    moved = np.random.default_rng(2).normal(size=gap.shape)
    more, less = (centres.zone(gap + s * step * moved, 0.3) for s in (1, -1))
    moved[2, 3] = 0.0
    # what lies beside a missing cell takes part in its quadrilateral by a mean, which is not differentiated
    near = np.zeros(gap.shape, bool)
    near[1:4, 2:5] = True
    gap[2, 3] = 1.0
    at = centres.zone(gap, 0.3)
    more, less = (centres.zone(gap + s * step * moved, 0.3) for s in (1, -1))
    assert abs((more.depth - less.depth) / (2 * step) + np.vdot(at.share, moved)) < 1e-6
    slope = at.points.T @ (at.weights * (at.points @ moved.ravel()))
    assert np.abs((more.share - less.share).ravel() / (2 * step) + slope).max() < 1e-5


def test_missing_cells_carry_nothing_and_do_not_weaken_their_neighbours():
    gap = np.zeros((6, 6))
    gap[4:] = np.inf
    assert np.abs(Centres(gap.shape, (False, False)).zone(gap, 1.0).share - (gap == 0)).max() < 1e-15


def test_pull_off_of_a_ball_is_that_of_maugis(loop):
    exact = adhesion.maugis(1.0, 1.0, WORK, law(1.0).range)
    assert abs(loop.pull_off / exact.pull_off - 1) < 0.01
    assert (
        abs(loop.pull_off_approach - exact.approach[exact.force.argmin()]) < 0.1 * APPROACH
    )  # flat: 0.2 % of the force


def test_jumps_are_where_the_theory_has_them(loop):
    """A ball comes on at a gap of the range, and off where Maugis' curve turns back; steps are halved seven times."""
    on, off = loop.jumps
    assert (on.on, off.on, on.before, off.after) == (True, False, 0.0, 0.0)
    assert abs(on.approach + law(1.0).range) < 0.01 * APPROACH
    least = adhesion.maugis(1.0, 1.0, WORK, law(1.0).range).approach.min()
    assert abs(off.approach - least) < 0.02 * APPROACH


def test_hysteresis_is_what_the_jumps_lose(loop):
    lost = sum(jump.lost for jump in loop.jumps)
    assert abs(loop.hysteresis / lost - 1) < 0.05  # trapezoids of four steps
    assert loop.figures["stability"].min() > 0


def test_force_is_the_slope_of_the_energy():
    body, step = half(24), 1e-6
    at, more, less = (body.press(BALL, approach=1e-4 + s * step, adhesion=law(1.0)) for s in (0, 1, -1))
    assert abs((more.energy - less.energy) / (2 * step) - at.force) < 1e-5 * FORCE
    assert at.law_residual < 1e-6
    assert at.residuals.worst < 1e-8


def test_net_pressure_is_tension_beside_the_contact_and_none_beyond_the_range():
    contact = half(24).press(BALL, approach=1e-4, adhesion=law(1.0))
    outside = ~contact.active
    assert np.abs(contact.pressure + contact.attraction)[outside].max() == 0
    assert abs(contact.pressure.min() + law(1.0).traction) < 1e-12
    far = contact.gap > 2 * law(1.0).range
    assert not contact.attraction[far].any()


def test_symmetry_does_not_change_the_state():
    body = half(16)
    one, two = (body.press(BALL, approach=1e-4, adhesion=law(1.0), symmetry=s) for s in (True, False))
    assert np.abs(one.pressure - two.pressure).max() < 1e-5 * law(1.0).traction
    assert two.solver.symmetric == (False, False)


def test_stability_is_one_less_the_rate_of_the_plain_iteration():
    body = half(16)
    adhesive = Adhesive(body.compliance, body.heights_of(BALL), law(1.0), 1e-11, True, None)
    contact, at = adhesive.contact(Given(-3e-4))
    moved = 1e-4 * np.random.default_rng(0).normal(size=at.share.shape) * (at.share > 0) * (at.share < 1)
    for _ in range(25):
        after = adhesive._state(at.given, at.share + moved, at).zone.share - at.zone.share
        rate, moved = np.linalg.norm(after) / np.linalg.norm(moved), 1e-4 * after / np.linalg.norm(after)
    assert abs(contact.stability - (1 - rate)) < 0.02


@pytest.mark.parametrize("symmetry", [True, False])
def test_a_prescribed_force_has_the_approach_of_its_state(symmetry):
    """Also a tension, down to the pull-off; by approaches the state is stable where by forces it is hardly so."""
    body, ball = half(24, 0.15), BALL if symmetry else fc.surfaces.Paraboloid(1.0, 0.9)
    for approach in (-3.2e-4, 2e-4):
        by_approach = body.press(ball, approach=approach, adhesion=law(1.0), symmetry=symmetry)
        by_force = body.press(ball, force=by_approach.force, adhesion=law(1.0), symmetry=symmetry)
        assert abs(by_force.approach - approach) < 1e-4 * APPROACH
        assert abs(by_force.force - by_approach.force) < 1e-7 * FORCE
        assert 0 < by_force.stability < by_approach.stability
    assert 0 < by_force.response_error.approach < 0.1
    with refused(fc.InputError, "beyond-pull-off", "pull_off"):
        body.press(ball, force=-1.7 * FORCE, adhesion=law(1.0), symmetry=symmetry)


def test_stability_under_a_force_ends_at_the_pull_off():
    """There the force has its extreme: it is zero, and by the approach it is not."""
    body, exact = half(24), adhesion.maugis(1.0, 1.0, WORK, law(1.0).range)
    near = [body.press(BALL, force=-share * exact.pull_off, adhesion=law(1.0)) for share in (0.9, 0.975)]
    assert abs(near[1].stability / near[0].stability - 0.5) < 0.15  # as the root of what is left
    assert body.press(BALL, approach=near[1].approach, adhesion=law(1.0)).stability > 2 * near[1].stability


def test_errors_are_estimated_from_cells_twice_as_large():
    """Of forces from half to twelve times those against Maugis; an area is nearer by chance. Coarse cells are told."""
    for lam, cells in ((0.5, 32), (1.0, 32), (1.0, 64)):
        exact, body = adhesion.maugis(1.0, 1.0, WORK, law(lam).range), half(cells, 0.15)
        rises = slice(int(exact.approach.argmin()), None, -1)
        contact = body.press(BALL, approach=1e-4, adhesion=law(lam))
        force, a = (np.interp(1e-4, exact.approach[rises], found[rises]) for found in (exact.force, exact.a))
        pressing = float((contact.pressure + contact.attraction).sum()) * body.grid.area
        pulling = float(contact.attraction.sum()) * body.grid.area
        error = abs(contact.force - force) / max(pressing, pulling)
        assert 0.5 < contact.response_error.force / error < 12
        assert 0.3 * abs(contact.figures["area"] / (np.pi * a**2) - 1) < contact.error_estimate.area < 0.05
    assert "force about" in str(contact)
    wide = half(16, 0.15).press(BALL, approach=1e-4, adhesion=law(1.0))
    assert any("may be off by about" in text for text in wide.warnings)
    odd = half(18, 0.15).press(BALL, approach=1e-4, adhesion=law(1.0))
    assert "no coarser one" in str(odd.error_estimate)


def test_an_interrupted_curve_goes_on(tmp_path, monkeypatch):
    on, body, file = [-7e-4, -2e-4, 0.0], half(16, 0.16), tmp_path / "curve.jsonl"
    whole = body.curve(BALL, approaches=on, adhesion=law(1.0), path=file)
    (jump,) = whole.jumps
    file.write_text("".join(file.read_text().splitlines(True)[:2]))
    rest = body.curve(BALL, approaches=on, adhesion=law(1.0), path=file)
    assert np.abs(rest.force - whole.force).max() < 1e-6 * FORCE
    assert np.abs(rest.figures["energy"] - whole.figures["energy"]).max() < 1e-6 * FORCE * APPROACH
    assert rest.jumps[0] == pytest.approx(jump)
    monkeypatch.setattr(Adhesive, "_settled", lambda *_: pytest.fail("solved"))
    body.curve(BALL, approaches=on, adhesion=law(1.0), path=file)
    with refused(fc.InputError, "row-of-another", "adhesion"):
        body.curve(BALL, approaches=on, adhesion=law(0.5), path=file)


def test_units_do_not_matter():
    mm, m = fc.Dugdale(work=WORK, range=law(1.0).range), fc.Dugdale(work=WORK * 1e3, range=law(1.0).range * 1e-3)
    other = fc.HalfSpace(fc.Material(E=1e6, nu=0.0), size=(0.12e-3, 0.12e-3), cells=(16, 16))
    one = half(16).press(BALL, approach=1e-4, adhesion=mm)
    two = other.press(fc.surfaces.Paraboloid(1e-3), approach=1e-7, adhesion=m)
    assert abs(two.force / one.force - 1) < 1e-9


def test_wide_cells_are_warned_of_and_narrow_ones_not():
    wide = half(16).press(BALL, approach=1e-4, adhesion=law(5.0))
    assert any("half the zone of adhesion" in text for text in wide.warnings)
    narrow = half(40, 0.2).press(BALL, approach=1e-4, adhesion=law(0.5))
    assert not narrow.warnings
    assert "a local minimum" in str(narrow)
    assert any("not a local minimum" in text for text in replace(narrow, stability=-0.1).warnings)


def test_what_does_not_combine_is_refused():
    body, sticky = half(16), law(1.0)
    for other in ({"hardness": 1.0}, {"friction": 0.3}, {"load_point": (0.0, 0.0)}, {"shift": (0.1, 0.0)}):
        with refused(fc.InputError, "not-with-adhesion", next(iter(other))):
            body.press(BALL, approach=1e-4, adhesion=sticky, **other)
    with refused(fc.InputError, "not-with-adhesion", "forces"):
        body.curve(BALL, [1.0], approaches=[0.0], adhesion=sticky)
    with refused(fc.InputError, "not-with-adhesion", "slope of a curve"):
        body.stiffness(body.press(BALL, approach=1e-4, adhesion=sticky))
    with refused(fc.InputError, "grid-too-small", "border"):
        half(16, 0.03).press(BALL, approach=1e-4, adhesion=sticky)
    with pytest.raises(fc.InputError, match="give adhesion="):
        body.curve(BALL, approaches=[0.0])
    with pytest.raises(fc.InputError, match="work of adhesion"):
        fc.Dugdale(work=-1.0, range=1.0)


def test_table_picture_and_files(loop, tmp_path):
    text = str(loop)
    assert "Pull-off" in text
    assert "Jumps off" in text
    assert "Energy lost" in text
    assert loop.plot(tmp_path / "loop.png", units="MPa").axes
    assert (tmp_path / "loop.png").stat().st_size > 10_000
    saved = loop.save(tmp_path / "loop.csv").read_text(encoding="utf-8").splitlines()
    assert len(saved) == len(loop) + 1
    assert saved[0].startswith("approach,force")


def test_closed_forms_meet_in_their_limits():
    exact = adhesion.jkr(1.0, 1.0, WORK, np.linspace(1e-3, 0.1, 20_000))
    assert abs(exact.pull_off / FORCE - 1.5) < 1e-6
    assert abs(adhesion.maugis(1.0, 1.0, WORK, law(50.0).range).pull_off / FORCE - 1.5) < 1e-3
    assert abs(adhesion.maugis(1.0, 1.0, WORK, law(1e-4).range).pull_off / FORCE - 2.0) < 2e-3
    assert abs(adhesion.transition(1.0, 1.0, WORK, law(0.7).range) - 0.7) < 1e-12
