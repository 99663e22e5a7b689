"""Ready problems of slender beams: known figures, files, refusals."""

import json

import pytest
from refusals import refused

from fecontact import InputError
from fecontact.app.cli import main
from fecontact.app.studies import fourbar
from fecontact.app.studies.slender import run


def test_the_elastica_with_its_files(tmp_path, capsys):
    figures, picture = tmp_path / "e.json", tmp_path / "e.png"
    assert main(["ancf", "elastica", "--elements", "6", "--json", str(figures), "--plot", str(picture)]) == 0
    told = json.loads(figures.read_text())
    # order 4 from 0.0128 degrees with ten elements: 0.1
    assert told["error"] < 0.2
    assert len(told["cases"]) == 9
    assert picture.stat().st_size > 10_000
    out = capsys.readouterr().out
    assert "9.116 Pcr" in out
    assert "corotational" in out


def test_the_paper_stands_beside_ten_elements():
    """Where it gave no figure there is none; its corotational angles are off by up to 13 degrees."""
    found = run("elastica", {"elements": 10})
    first, *_, last = found.data["cases"]
    assert first["paper, ANCF"] == 21.41
    assert last["paper, ANSYS"] is None
    assert abs(last["corotational, modern"] - last["known"]) < 1e-3
    # with the paper's strains its table 2, but for the load 1.5 % above the critical one, where the last digit of the
    # load moves the angle; angles of two digits
    for case in found.data["cases"][1:]:
        assert abs(case["in the chord's frame"] - case["paper, ANCF"]) < 0.11
    assert "-" in str(found).splitlines()[-5].split()


def test_a_linkage_with_its_files(tmp_path, monkeypatch, capsys):
    """A tenth of a second of it, beside the refined motion; figures by corotational beams stand beside."""
    monkeypatch.setattr(fourbar, "UNTIL", 0.1)
    figures, picture = tmp_path / "f.json", tmp_path / "f.png"
    assert main(["ancf", "fourbar", "--step", "0.01", "--json", str(figures), "--plot", str(picture)]) == 0
    told = json.loads(figures.read_text())
    (first,) = told["cases"]
    assert first["known"] == fourbar.REFINED[0]
    assert told["error"] == abs(first["found"] - first["known"]) < 0.01
    assert abs(first["found"] - first["crank, rigid bars"]) < 0.01
    assert abs(first["follower, found"] - first["follower, corotational"]) < 0.01
    # its weight, at rest 5 w L^4 / (384 E I) = 0.0115 mm, acts at once: up to twice that
    assert 1e-3 < abs(first["coupler's middle off its chord, mm"]) < 0.025
    assert first["the same, corotational"] == pytest.approx(first["coupler's middle off its chord, mm"], abs=5e-3)
    assert picture.stat().st_size > 10_000
    assert "corotational" in capsys.readouterr().out


def test_a_pendulum_falls_with_its_energy():
    found = run("pendulum", {"elements": 6, "step": 0.01})
    assert found.data["error"] < 0.02
    assert found.data["drift of the energy"] < 1e-6


@pytest.mark.full
def test_a_pendulum_beside_corotational_beams():
    """Six elements to 0.5 s: both procedures follow to 0.4 s; turns within an element pass the 30 degrees of 1986."""
    found = run("pendulum", {"elements": 6, "step": 0.01, "until": 0.5})
    cases = found.data["cases"]
    for procedure in ("1986", "modern"):
        assert max(abs(case[f"corotational, {procedure}"] - case["known"]) for case in cases[:4]) < 0.013
        assert found.data[f"largest turn within an element, {procedure}, degrees"] > 30
    assert cases[4]["known"] is None
    assert "-" in str(found).splitlines()[-5].split()


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("pendulum", {"until": 2.0}, ("until", "1.1")),
        ("circle", {"until": 1.0}, ("until", "pendulum")),
        ("spring", {}, ("unknown-name", "problem")),
        ("circle", {"elements": -1}, ("input", "one element or more")),
        ("pendulum", {"elements": 5}, ("input", "even number")),
        ("fourbar", {"elements": 3}, ("input", "even number")),
        ("pendulum", {"gravity": 3.0}, ("input", "gravity")),
        ("pendulum", {"step": 0.0}, ("not-positive", "step")),
    ],
)
def test_refusals(name, options, message):
    with refused(InputError, *message):
        run(name, options)
