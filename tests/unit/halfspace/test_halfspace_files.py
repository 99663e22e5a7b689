"""Contacts on half-spaces in files and pictures."""

import json

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

CORK = fc.Material(E=1.0, nu=0.0)


@pytest.fixture(scope="module")
def half():
    return fc.HalfSpace(CORK, size=(3.0, 3.0), cells=(32, 32), against=CORK)


@pytest.fixture(scope="module")
def pressed(half):
    return half.press(fc.surfaces.Paraboloid(1.0), force=2 / 3)


@pytest.fixture(scope="module")
def dragged(half):
    return half.press(fc.surfaces.Paraboloid(1.0), force=2 / 3, friction=0.5, tangential=(0.2, 0.0))


def test_a_row_for_each_cell(pressed, dragged, tmp_path):
    table = np.genfromtxt(pressed.save(tmp_path / "p.csv"), delimiter=",", names=True)
    assert abs(table["pressure"].sum() * pressed.grid.area / (2 / 3) - 1) <= 1e-12
    # rows go along y first: the first moments about both axes vanish, x is the slow one
    assert table["x"][0] == table["x"][1]
    saved = np.load(dragged.save(tmp_path / "d.npz"))
    assert np.array_equal(saved["traction_x"], dragged.traction[0])
    assert abs(saved["traction_x"].sum() * dragged.grid.area / 0.2 - 1) <= 1e-9  # the certificate's balance
    assert np.array_equal(saved["x"], dragged.grid.x)


def test_summaries_are_ready_for_json(pressed, dragged, tmp_path):
    plain = json.loads(pressed.save(tmp_path / "p.json").read_text())
    assert abs(plain["force"] / (2 / 3) - 1) <= 1e-12
    assert plain["status"] == "solved"
    rough = json.loads(dragged.save(tmp_path / "d.json").read_text())
    assert rough["friction"] == 0.5
    assert rough["stick_area"] < rough["area"]


def test_pictures_have_units(pressed, dragged, tmp_path):
    figure = pressed.plot(tmp_path / "p.png", length="mm", force="N", units="MPa")
    assert figure.axes[0].get_xlabel() == "x [mm]"
    assert figure.get_suptitle().startswith("force 0.6667 N, area ")
    assert (tmp_path / "p.png").stat().st_size > 5000
    assert dragged.plot(length="mm").axes[0].get_ylabel() == "y [mm]"


def test_other_files_and_options_are_refused(pressed, tmp_path):
    with refused(fc.InputError, "unknown-name", "suffix"):
        pressed.save(tmp_path / "p.vtk")
    with refused(fc.InputError, "no-folder", "p.csv"):
        pressed.save(tmp_path / "no" / "p.csv")
    with refused(fc.InputError, "not-a-text", "The unit of length"):
        pressed.plot(length=3)
    assert list(tmp_path.iterdir()) == []
