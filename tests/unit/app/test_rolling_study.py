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
