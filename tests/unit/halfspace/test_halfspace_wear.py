"""Wear that changes the shape of what is pressed on a half-space, by Archard's law."""

from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact import PressStep
from fecontact.app.cli import main
from fecontact.common import wear
from tests.refusals import refused

PLAIN = fc.Material(E=1.0, nu=0.0)
HALF = fc.HalfSpace(PLAIN, size=(2.6, 2.6), cells=(20, 20), against=PLAIN)
BALL = fc.surfaces.Paraboloid(5.0)
FORCE = 0.01


def slid(surface, distances, mu=0.0, half=HALF, k=1.0, **options):
    steps = [PressStep(force=FORCE, shift=(x, 0.0)) for x in distances]
    return half.press_path(surface, steps, mu, wear=k, **options)


def explicit(steps: int, distance: float) -> np.ndarray:
    """Worn depth of the ball by explicit Archard steps at a given force."""
    worn = np.zeros(HALF.grid.shape)
    z = HALF.heights_of(BALL)
    for _ in range(steps):
        worn += distance / steps * HALF.press(z + worn, force=FORCE).pressure
    return worn


@pytest.fixture
def uncut(monkeypatch):
    """Steps as they are given."""
    monkeypatch.setattr(wear, "WEAR_ERROR", np.inf)


def test_worn_volume_is_k_times_force_and_slip():
    path = slid(BALL, (0.0, 1.0, 4.0), k=0.5)
    np.testing.assert_allclose(path.worn_volume, [0.0, 0.5 * FORCE, 2.0 * FORCE], rtol=1e-12)
    assert path.last.wear_error < 0.05
    assert not any("worn depth" in text for text in path.warnings)
    assert path.last.columns()["worn"] is path.last.worn
    assert path.last.summary()["worn_volume"] == path.rows()[-1]["worn_volume"] == path.last.worn_volume
    # the contact is that of the worn shape
    again = HALF.press(HALF.heights_of(BALL) + path.last.worn, force=FORCE)
    np.testing.assert_allclose(path.last.pressure, again.pressure, rtol=0, atol=1e-8)
    assert path.last.figures["area"] > 2 * path[0].figures["area"]


def test_a_flat_punch_wears_to_a_uniform_pressure(uncut):
    r = np.hypot(HALF.grid.x[:, None], HALF.grid.y[None, :])
    path = slid(np.where(r <= 1, 0.0, np.inf), (0.0, 1e5))
    p = path.last.pressure[r <= 1]
    assert abs(p / p.mean() - 1).max() < 1e-4
    assert path.last.worn_volume == pytest.approx(1e5 * FORCE, rel=1e-12)


def test_any_step_is_stable_and_converges_to_explicit_ones(uncut):
    true = explicit(50, 4.0)
    errors = [abs(slid(BALL, np.linspace(0, 4, n + 1)).last.worn - true).max() / true.max() for n in (1, 3, 9)]
    assert errors[0] < 0.04
    assert errors[2] < errors[1] / 2 < errors[0] / 4
    # two explicit ones are not
    assert abs(explicit(2, 4.0) - true).max() / true.max() > 0.2


def test_steps_are_cut_by_their_error():
    true = explicit(50, 4.0)
    path = slid(BALL, (0.0, 4.0))
    error = abs(path.last.worn - true).max() / true.max()
    assert path.cuts[1] > 3
    assert error < 0.02
    assert error < path.last.wear_error < 0.05


def test_steps_that_are_too_large_are_warned_of(uncut):
    half = fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(16, 16), against=PLAIN)
    ends = [PressStep(force=FORCE, tangential=(t * FORCE, 0.0)) for t in (0.0, -0.3, 0.3)]
    path = half.press_path(BALL, [*ends[:2], replace(ends[2], cycles=100.0)], 0.5, wear=1.0)
    assert "worn depth may be off" in path.warnings[-1]
    assert path.last.wear_error > 0.05


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_volume_of_partial_slip_is_that_of_pressure_and_slip(nu, uncut):
    """The slip is that of the shape before: the difference falls with the depth."""
    body = fc.Material(E=1.0, nu=nu)
    half = fc.HalfSpace(body, size=(1.6, 1.6), cells=(16, 16), against=None if nu else body)
    pull = [PressStep(force=FORCE, tangential=(t * FORCE, 0.0)) for t in (0.0, 0.2)]
    off = []
    for k in (1e-2, 1e-6):
        path = half.press_path(BALL, pull, 0.3, wear=k)
        assert path.last.sticking.any()
        slid = sum(contact.sliding_integral.sum() for contact in path) * half.grid.area
        off.append(abs(path.last.worn_volume / (k * slid) - 1))
    assert off[1] < max(2e-4 * off[0], 1e-8)


def test_fretting_keeps_its_stick_area_and_tends_to_the_ball_cut_there(uncut):
    approach, radius = 0.02, 5.0
    shift = 0.5 * (approach - 0.36 * approach)  # sticks within .6 of the radius at mu = .5
    half = fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(40, 40), against=PLAIN)

    def fretted(*cycles):
        ends = [PressStep(approach=approach), PressStep(approach=approach, shift=(-shift, 0.0))]
        for k, n in enumerate(cycles):
            ends.append(PressStep(approach=approach, shift=((-1) ** k * shift, 0.0), cycles=n))
        return half.press_path(fc.surfaces.Paraboloid(radius), ends, 0.5, wear=1.0)

    once, often = fretted(1e6), fretted(1e2, 1e3, 1e4, 989e3)
    begin = once[1].sticking
    assert np.sqrt(once[1].stick_area / np.pi) == pytest.approx(0.6 * np.sqrt(approach * radius), rel=0.02)
    for path in (once, often):
        assert (path.last.sticking == begin).all()
        assert path.last.worn[begin].max() == 0
    assert once.last.worn_volume == pytest.approx(often.last.worn_volume, rel=1e-3)
    limit = half.press(np.where(begin, half.heights_of(fc.surfaces.Paraboloid(radius)), np.inf), approach=approach)
    np.testing.assert_allclose(once.last.pressure, limit.pressure, rtol=0, atol=1e-4 * limit.max_pressure)
    assert often.last.wear_error < 0.02


def test_slip_of_a_cycle_is_steady_and_not_that_of_the_first_loading(uncut):
    """From zero to a shift and back: half the range of loads slips less than half as far (Mindlin & Deresiewicz)."""
    half = fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(24, 24), against=PLAIN)
    ends = [PressStep(force=FORCE), PressStep(force=FORCE, tangential=(0.2 * FORCE, 0.0), cycles=1.0)]
    given = [*ends[:1], *(PressStep(force=FORCE, tangential=(t * FORCE, 0.0)) for t in (0.2, 0.0, 0.2))]
    k = 1e-6
    steady, first = (half.press_path(BALL, steps, 0.3, wear=k) for steps in (ends, given))
    worn = np.diff(first.worn_volume)
    assert worn[0] > 3 * worn[2]
    assert steady.worn_volume[1] == pytest.approx(
        2 * k * 0.5 * first[3].sliding_integral.sum() * half.grid.area, rel=1e-3
    )


def test_unlike_bodies_wear_by_the_slip_that_they_settle_to(uncut):
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(1.2, 1.2), cells=(8, 8))
    ends = [PressStep(force=FORCE, shift=(x, 0.0)) for x in (4e-3, -4e-3)]
    k = 1e-9
    path = half.press_path(BALL, [ends[0], replace(ends[1], cycles=1.0)], 0.5, wear=k)
    often = half.press_path(BALL, ends * 6, 0.5)
    steady, first = (k * often[j].sliding_integral.sum() * half.grid.area for j in (-1, 1))
    worn = path.worn_volume[1] - path.worn_volume[0]
    assert worn == pytest.approx(steady, rel=0.02)
    assert abs(first / steady - 1) > 0.05


def test_a_lifted_surface_does_not_wear():
    half = fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(16, 16), against=PLAIN)
    steps = [PressStep(approach=a, shift=(x, 0.0)) for a, x in ((0.02, 0.0), (0.02, 0.5), (-0.01, 1.0), (-0.01, 2.0))]
    path = half.press_path(BALL, steps, 0.0, wear=1e-3)
    assert path[1].worn_volume > 0
    assert path[2].status == path[3].status == "no-contact"
    assert (path[3].worn == path[2].worn).all()


def test_all_worn_off_ends_in_words():
    steps = [PressStep(approach=0.02), PressStep(approach=0.02, shift=(1e9, 0.0))]
    with refused(fc.InputError, "worn-off", "approach of 0.02", "Step 2 of 2"):
        HALF.press_path(BALL, steps, 0.0, wear=1.0)


def test_friction_whose_hold_wears_off_is_named():
    half = fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(16, 16), against=PLAIN)
    ends = ((0.0, None), (2.3e-4, None), (-2.3e-4, 1e9))
    pull = [PressStep(approach=0.005, tangential=(t, 0.0), cycles=n) for t, n in ends]
    with refused(fc.InputError, "slides-as-a-whole"):
        half.press_path(BALL, pull, 0.5, wear=1.0)


@pytest.mark.parametrize(
    ("code", "said", "steps", "options"),
    [
        ("no-cycle", "Step 1", [{"cycles": 5.0}], {}),
        ("wear-position", "(0.1, 0.0)", [{}, {"position": (0.1, 0.0)}], {}),
        ("no-slip", "finite", [{}], {"friction": np.inf}),
        ("wear-alone", "accuracy=", [{}], {"accuracy": 0.1}),
        ("wear-alone", "hardness=", [{}], {"hardness": 0.1}),
        ("cycles-without-wear", "5 cycles", [{}, {"cycles": 5.0}], {"wear": None}),
    ],
)
def test_what_is_not_offered_is_refused_by_name(code, said, steps, options):
    given = {"friction": 0.3, "wear": 1.0, **options}
    path = [PressStep(force=FORCE, **step) for step in steps]
    with refused(fc.InputError, code, said):
        HALF.press_path(BALL, path, **given)


@pytest.mark.parametrize("cycles", [None, 50.0])
def test_a_path_goes_on_from_its_file(tmp_path, cycles):
    """Steps passed once and many times: what is read again has all figures of the first run, and what follows too."""
    half = fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(16, 16), against=PLAIN)
    ends = ((0.0, None), (1e-3, cycles), (-1e-3, cycles), (5e-4, None))
    pull = [PressStep(force=FORCE, shift=(t, 0.0), cycles=n) for t, n in ends]
    whole = half.press_path(BALL, pull, 0.3, wear=5.0)
    first = half.press_path(BALL, pull[:3], 0.3, wear=5.0, path=tmp_path / "worn.jsonl")
    again = half.press_path(BALL, pull, 0.3, wear=5.0, path=tmp_path / "worn.jsonl")
    assert first.last.worn.any()
    for one, two in zip(whole, again, strict=True):
        for name in ("worn", "wear_change", "pressure", "traction", "slip"):
            np.testing.assert_allclose(getattr(two, name), getattr(one, name), rtol=0, atol=1e-12)
        assert (two.cycles, two.residuals.worst < 1e-10) == (one.cycles, True)
    np.testing.assert_allclose(again.friction_work, whole.friction_work, rtol=1e-9, atol=1e-15)
    with refused(fc.InputError, "row-of-another", "wear"):
        half.press_path(BALL, pull, 0.3, wear=4.0, path=tmp_path / "worn.jsonl")


def test_the_command_line_wears_and_reads_what_passes(capsys):
    """Worn volume k F s, where s has the elastic displacements along it too; columns as those of a curve."""
    words = ["halfspace", "sphere", "--radius", "10", "--E", "210e3", "--cells", "16"]
    assert main([*words, "--force", "100", "--wear", "1e-9,10", "--also", "conductance"]) == 0
    found = {line[:18].strip(): line.split()[-1] for line in capsys.readouterr().out.splitlines() if line[18:].strip()}
    assert abs(float(found["worn volume"]) - 1e-6) < 1e-10
    assert float(found["conductance"]) > 0
    assert main([*words, "--loads", "50,100", "--also", "conductance,leakage"]) == 0
    head, first, last = capsys.readouterr().out.splitlines()[1:4]
    at = head.split().index("conductance")
    assert float(last.split()[at]) > float(first.split()[at])
    for wrong in (["--wear", "1e-9,10", "--loads", "1,2"], ["--also", "pressure"], ["--wear", "1e-9,-1"]):
        assert main([*words, *([] if "--loads" in wrong else ["--force", "1"]), *wrong]) == 2


def test_wear_afterwards_is_refused_where_the_shape_has_worn():
    path = slid(BALL, (0.0, 0.1))
    with refused(fc.InputError, "worn-already"):
        path.wear_depth(1.0)
