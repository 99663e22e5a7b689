"""``fecontact roll``: one state, creep curves, what is refused."""

import json

import numpy as np
import pytest

import fecontact as fc
from fecontact.app.cli import main

WHEEL = ["roll", "--radius", "460", "--nu", "0.28", "--force", "80e3", "--cells", "20"]


def test_one_state_is_that_of_the_half_space(tmp_path, capsys):
    picture = tmp_path / "rolling.png"
    assert main([*WHEEL, "--tangential", "0", "14.4e3", "--towards", "0", "1", "--json", "-", f"--plot={picture}"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert picture.stat().st_size > 10_000
    steel = fc.Material(E=210e3, nu=0.28)
    a = fc.hertz.spheres((460.0, np.inf), (steel, steel), force=80e3).a
    half = fc.HalfSpace(steel, (2.4 * a, 2.4 * a), (20, 20), against=steel)
    one = half.roll(
        fc.surfaces.Paraboloid(460.0), force=80e3, friction=0.3, tangential=(0.0, 14.4e3), towards=(0.0, 1.0)
    )
    np.testing.assert_allclose(found["creepage"], one.creepage, atol=1e-9)


def test_it_is_printed_with_its_error_and_rolls_freely_unless_told(capsys):
    assert main(WHEEL) == 0
    text = capsys.readouterr().out
    assert "creepage_along" in text
    assert "error of tractions" in text


def test_several_creepages_and_spins_are_curves(tmp_path, capsys):
    file = tmp_path / "curve.csv"
    options = ["--creepage", "0.001", "0", "--creepage", "-0.001", "0", "--spin", "0", "0.0002", f"--csv={file}"]
    assert main([*WHEEL, *options]) == 0
    assert "stick_share" in capsys.readouterr().out
    rows = np.genfromtxt(file, delimiter=",", names=True)
    np.testing.assert_allclose(rows["spin"], [0, 0, 2e-4, 2e-4])
    assert abs(rows["force_along"][0] + rows["force_along"][1]) < 1e-6 * 80e3


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--creepage", "0.001", "0", "--tangential", "1", "0"], "one follows from the other"),
        (["--spin", "0", "0.1"], "--creepage, too"),
        (["--tangential", "25e3", "0"], "slides"),
        (["--radius-y", "-1"], "radi"),
        (["--radius", "0"], "radius"),
    ],
)
def test_what_does_not_fit_is_refused(options, text, capsys):
    assert main([*WHEEL, *options]) == 2
    assert text in capsys.readouterr().err


@pytest.fixture
def on_rail(tmp_path):
    """A cone on a crowned rail, by files."""
    y, turn = np.linspace(-60, 60, 31), np.linspace(-0.3, 0.3, 161)
    profiles = {"cone": (y, y / 20), "crown": (300 * np.sin(turn), 300 * np.cos(turn) - 300)}
    for name, points in profiles.items():
        np.savetxt(tmp_path / f"{name}.csv", np.stack(points, axis=1), delimiter=",", fmt="%.9f")
    files = [str(tmp_path / f"{name}.csv") for name in profiles]
    place = ["--radius", "460", "--rail-position", "0", "--wheel-position", "0", "--force", "2e4", "--cells", "12"]
    return ["roll", "--profiles", *files, *place]


def test_a_wheel_on_a_rail_at_shifts_is_a_table_and_pictures(on_rail, tmp_path, capsys):
    rows, picture = tmp_path / "shifts.csv", tmp_path / "shifts.png"
    shifts = ["--shift", "0", "2", "--yaw", "0", "0.001", "--join", "4"]
    assert main([*on_rail, *shifts, f"--csv={rows}", f"--plot={picture}"]) == 0
    assert "stick_share" in capsys.readouterr().out
    found = np.genfromtxt(rows, delimiter=",", names=True)
    np.testing.assert_allclose(found["shift"], [0, 2])
    # a cone along its generator touches where the crown has its slope
    np.testing.assert_allclose(found["angle"], np.arctan(0.05), atol=2e-4)
    assert picture.stat().st_size > 10_000
    assert main([*on_rail, "--json", "-"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert abs(row["y"] + 300 * np.sin(np.arctan(0.05))) < 0.1


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--creepage", "0.001", "0"], "--creepage is for a body on a plane"),
        (["--shift", "0", "1", "2", "--yaw", "0", "1"], "as many"),
        (["--gauge", "1435", "14"], "gauge"),
    ],
)
def test_what_does_not_fit_a_wheel_is_refused(on_rail, options, text, capsys):
    on_rail = [*on_rail[:6], *on_rail[8:]] if "--gauge" in options else on_rail  # without the rail's place
    assert main([*on_rail, *options]) == 2
    assert text in capsys.readouterr().err


def test_shifts_need_profiles_and_wheels_a_radius(on_rail, capsys):
    assert main([*WHEEL, "--shift", "1"]) == 2
    assert "--profiles WHEEL RAIL" in capsys.readouterr().err
    assert main([*on_rail[:4], *on_rail[6:]]) == 2
    assert "Give --radius" in capsys.readouterr().err
