"""Curves of a half-space over the force, beside Hertz."""

import json

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main

SOFT = fc.Material(E=1.0, nu=0.0)
LENGTH = 0.01 ** (1 / 3)  # keeps strains and slopes small
FORCES = np.geomspace(0.001, 0.012, 5)


@pytest.fixture(scope="module")
def curve():
    """A paraboloid of radius 1 on E* = 1, whose contact is Hertz's; given in no order."""
    half = fc.HalfSpace(SOFT, size=(2.2 * LENGTH, 2.2 * LENGTH), cells=(64, 64))
    return half, half.curve(fc.surfaces.Paraboloid(1.0), FORCES[[2, 0, 4, 1, 3]])


def test_a_ball_follows_hertz_over_a_decade_of_forces(curve):
    _, found = curve
    a = (3 * found.force / 4) ** (1 / 3)
    # errors of the grid: 13 to 31 cells across, second order inside, the edge within the cells
    assert np.abs(found.approach / a**2 - 1).max() < 2e-3
    assert np.abs(found.area / (np.pi * a**2) - 1).max() < 1.5e-2
    assert np.abs(found.column("max_pressure") / (2 * a / np.pi) - 1).max() < 1e-2
    slope = np.polyfit(np.log(found.force), np.log(found.approach), 1)[0]
    assert abs(slope - 2 / 3) < 5e-4
    assert np.allclose(found.column("mean_pressure") * found.area, found.force, rtol=1e-12)


def test_a_load_of_a_curve_is_that_load_alone(curve):
    half, found = curve
    alone = half.press(fc.surfaces.Paraboloid(1.0), force=float(found.force[2]))
    assert found.approach[2] == pytest.approx(alone.approach, rel=1e-9)
    assert found.column("pressure_error")[2] == pytest.approx(alone.error_estimate.pressure, rel=1e-6)


def test_an_interrupted_curve_goes_on(curve, tmp_path, monkeypatch):
    (half, found), forces = curve, FORCES[[2, 0, 4, 1, 3]]
    ball, file = fc.surfaces.Paraboloid(1.0), tmp_path / "curve.jsonl"
    half.curve(ball, forces, path=file)
    monkeypatch.setattr("fecontact.halfspace.pressable.press", lambda *_: pytest.fail("pressed"))
    again = half.curve(ball, forces, path=file)
    assert {name: values.tolist() for name, values in again.figures.items()} == {
        name: values.tolist() for name, values in found.figures.items()
    }
    with refused(fc.InputError, "row-of-another", "force"):
        half.curve(ball, 2 * forces, path=file)


def test_a_tilting_surface_and_warnings_of_coarse_loads(monkeypatch):
    monkeypatch.setattr("fecontact.halfspace.contact.MAX_ERROR", 0.06)  # between the two estimates
    half = fc.HalfSpace(SOFT, size=(3 * LENGTH, 3 * LENGTH), cells=(16, 16))
    found = half.curve(fc.surfaces.Paraboloid(1.0), [0.0002, 0.002], load_point=(0.05 * LENGTH, 0.0))
    assert len(found) == 2
    assert len(found.warnings) == 1
    assert found.warnings[0].startswith("At the force 0.0002: ")
    assert "Warning: At the force 0.0002" in str(found)


def test_files_and_pictures(curve, tmp_path):
    _, found = curve
    table = np.genfromtxt(found.save(tmp_path / "curve.csv"), delimiter=",", names=True)
    assert table["approach"].tolist() == found.approach.tolist()
    assert table.dtype.names == tuple(found.figures)
    figure = found.plot(tmp_path / "curve.png", length="mm", force="N", units="MPa")
    assert (tmp_path / "curve.png").stat().st_size > 2000
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "approach [mm]",
        "area [mm²]",
        "pressure [MPa]",
        "mean gap [mm]",
    ]
    assert figure.axes[0].lines[0].get_xdata() == pytest.approx(FORCES)
    assert repr(found) == "LoadCurve(steps=5 x dict, cuts=(1, 1, 1, 1, 1))"
    assert len(str(found).splitlines()) == 6


def test_the_commands_curves_stand_beside_the_closed_form(tmp_path):
    picture, figures = tmp_path / "c.png", tmp_path / "c.json"
    line = f"halfspace sphere --radius 10 --E 1 --nu 0 --loads 0.08,0.01 --cells 32 --plot {picture} --json {figures}"
    assert main(line.split()) == 0
    assert picture.stat().st_size > 2000
    first, last = (step["figures"]["approach"] for step in json.loads(figures.read_text())["loads"])
    assert abs(first / last / 4 - 1) < 0.02  # 8 times the force, to the power 2/3


@pytest.mark.parametrize(
    ("forces", "told"),
    [
        ([], ("wrong-shape", "one or more")),
        ([[1.0]], ("wrong-shape", "one or more")),
        ([0.1, -1.0], ("force-not-positive", "-1.0")),
        ("many", ("not-numbers", "the forces of a curve")),
    ],
)
def test_forces_that_are_none_are_refused_before_any_is_pressed(curve, forces, told, monkeypatch):
    half, _ = curve
    monkeypatch.setattr("fecontact.halfspace.pressable.press", lambda *_: pytest.fail("pressed"))
    with refused(fc.InputError, *told):
        half.curve(fc.surfaces.Paraboloid(1.0), forces)


def test_a_column_that_is_none_is_refused(curve):
    with refused(fc.InputError, "unknown-name", "'stiffness'"):
        curve[1].column("stiffness")
