"""``fecontact halfspace``: shapes beside their closed forms, curves, pictures, and what is refused."""

import json

import meshio
import numpy as np
import pytest

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.studies.closed_forms import closed_form
from fecontact.halfspace.pressing import Load

BALL = ["sphere", "--radius", "10", "--E", "210e3", "--cells", "48"]


def run(capsys, *arguments):
    assert main(["halfspace", *arguments, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


# errors of the cells' order at 96 cells, a little above what was found
@pytest.mark.parametrize(
    ("arguments", "approach", "pressure"),
    [
        (["sphere", "--radius", "10", "--force", "0.01"], 2e-4, 6e-3),
        (["sphere", "--radius", "10", "--approach", "0.1"], 1e-12, 6e-3),
        (["paraboloid", "--radius", "5", "--radius-y", "2", "--force", "0.01"], 2e-4, 6e-3),
        (["ellipsoid", "--semi-axes", "2", "1", "1", "--force", "1e-4"], 2e-3, 8e-3),
        (["cone", "--angle", "2", "--force", "1"], 1e-4, 8e-3),
        (["flat", "--radius", "1", "--force", "1"], 6e-3, 2e-2),
        (["flat", "--radius", "1", "--force", "1", "--load-point", "0.1", "0.2"], 6e-3, 2e-2),
        (["flat", "--radius", "1", "--force", "1", "--moment", "-0.2", "0.1"], 6e-3, 2e-2),
    ],
)
def test_shapes_beside_their_closed_forms(arguments, approach, pressure, capsys):
    found = run(capsys, *arguments, "--E", "1", "--nu", "0", "--cells", "96")
    assert abs(found["errors"]["approach"]) < approach
    assert abs(found["errors"]["pressure, L2"]) < pressure
    assert max(found["residuals"].values()) < 1e-8
    if "tilt (rad)" in found["figures"]:
        assert abs(found["errors"]["tilt (rad)"]) < 0.02
        assert np.allclose(found["centre_of_pressure"], [0.1, 0.2], atol=1e-12)  # statics


def test_wave_layer_and_line(capsys):
    wave = run(capsys, "wave", "--amplitude", "0.01", "--size", "1", "--E", "1", "--periodic", "--force", "0.01")
    assert wave["exact"]["source"] == "Westergaard"
    assert abs(wave["errors"]["mean gap"]) < 1e-3
    assert abs(wave["errors"]["pressure, L2"]) < 5e-3
    layer = run(capsys, "paraboloid", "--radius", "20", "--layer", "5,0.45,2", "--force", "100", "--cells", "96")
    assert abs(layer["errors"]["approach"]) < 5e-4
    line = run(capsys, "cylinder", "--radius=5", "--E=100", "--force=1", "--periodic", "--size", "20", "1", "--cells",
               "512", "4")  # fmt: skip
    assert abs(line["errors"]["maximum pressure"]) < 5e-3  # neighbours at 44 half-widths


@pytest.mark.parametrize("arguments", [["torus", "--ring=5", "--tube=1"], ["flat", "--sides", "2", "1"],
                                       ["cylinder", "--radius=5", "--length=1"]])  # fmt: skip
def test_shapes_without_closed_form(arguments, capsys):
    found = run(capsys, *arguments, "--E", "100", "--force", "0.1", "--cells", "64")
    assert found["exact"] is None
    assert abs(found["figures"]["force"] - 0.1) < 1e-12


@pytest.mark.full
def test_curve_with_picture_and_table(tmp_path, capsys):
    files = [f"--{kind}={tmp_path / kind}.{end}" for kind, end in (("plot", "png"), ("csv", "csv"), ("json", "json"))]
    assert main(["halfspace", *BALL, "--loads", "1,8,27", *files]) == 0
    assert "3 loads" in capsys.readouterr().out
    table = np.genfromtxt(tmp_path / "csv.csv", delimiter=",", names=True)
    # powers of Hertz; 16 to 48 cells across
    assert np.abs(table["approach"] / table["approach"][0] / [1, 4, 9] - 1).max() < 5e-3
    assert np.abs(table["stiffness"] / table["stiffness"][-1] * 3 / [1, 2, 3] - 1).max() < 0.06
    assert (tmp_path / "plot.png").read_bytes()[:4] == b"\x89PNG"
    assert len(json.loads((tmp_path / "json.json").read_text())["loads"]) == 3


def test_moving_contacts_with_pictures(tmp_path, capsys):
    rubber = ["sphere", "--radius", "10", "--E", "10", "--nu", "0.49", "--prony", "0.5,0.1", "--prony", "0.3,10"]
    moves = [*rubber, "--velocity", "5", "0", "--cells", "24"]
    found = run(capsys, *moves, "--force", "1", "--plot", str(tmp_path / "one.png"))
    soft = fc.HalfSpace(fc.Viscoelastic(fc.Material(10.0, 0.49), [(0.5, 0.1), (0.3, 10.0)]), found["size"], (24, 24))
    same = soft.press(fc.Sphere(10.0), force=1.0, velocity=(5.0, 0.0))
    assert found["figures"]["drag"] == pytest.approx(same.drag, rel=1e-12)
    assert "stiffness" not in found["figures"]
    curve = run(capsys, *moves, "--loads", "0.1,1", "--plot", str(tmp_path / "curve.png"))
    assert curve["loads"][1]["figures"]["drag"] > 10 * curve["loads"][0]["figures"]["drag"] > 0
    assert len(list(tmp_path.glob("*.png"))) == 2


def test_adhesion_with_pictures(tmp_path, capsys):
    sticky = ["paraboloid", "--radius", "1", "--E", "1", "--nu", "0.49", "--adhesion", "1e-5,3e-4", "--size", "0.12"]
    one = run(capsys, *sticky, "--cells", "16", "--force=-2e-5", "--plot", str(tmp_path / "one.png"))
    assert one["figures"]["force"] == pytest.approx(-2e-5, rel=1e-6)
    assert one["figures"]["law residual"] < 1e-6
    assert one["figures"]["stability"] > 0
    on = [*sticky, "--adhesion", "1e-5,2e-3", "--size", "0.2", "--cells", "12", "--approaches=-3e-3,-1e-3,-3e-3"]
    found = run(capsys, *on, "--plot", str(tmp_path / "on.png"))
    half = fc.HalfSpace(fc.Material(1.0, 0.49), (0.2, 0.2), (12, 12))
    curve = half.curve(fc.surfaces.Paraboloid(1.0), approaches=[-3e-3, -1e-3, -3e-3], adhesion=fc.Dugdale(1e-5, 2e-3))
    assert found["pull_off"] == pytest.approx(curve.pull_off, rel=1e-12)
    assert [state["force"] for state in found["states"]] == pytest.approx(curve.force.tolist(), abs=1e-15)
    assert len(list(tmp_path.glob("*.png"))) == 2


def test_rough_surface_with_picture(tmp_path, capsys):
    options = ["rough", "--rms-slope=0.1", "--size=1", "--E=1", "--periodic", "--force=0.01", "--cells=32"]
    assert main(["halfspace", *options, f"--plot={tmp_path / 'rough.png'}"]) == 0
    assert "regions" in capsys.readouterr().out
    assert (tmp_path / "rough.png").stat().st_size > 10_000


def test_heights_and_facets_from_files(tmp_path, capsys):
    x = (np.arange(32) - 15.5) / 32
    bump = (x[:, None] ** 2 + x[None, :] ** 2) / 2
    np.save(tmp_path / "bump.npy", bump)
    np.save(tmp_path / "peak.npy", 7 - bump)
    common = ["--E=1", "--force=1e-3"]
    down = run(capsys, "heights", "--file", str(tmp_path / "bump.npy"), "--size=1", *common)
    up = run(capsys, "heights", "--file", str(tmp_path / "peak.npy"), "--peaks-up", "--size=1", *common)
    assert abs(up["figures"]["approach"] / down["figures"]["approach"] - 1) < 1e-9
    points = np.array([[-1, -1, 0.5], [1, -1, 0.5], [1, 1, 0.5], [-1, 1, 0.5], [0, 0, 0.0]])
    sides = [[4, 1, 0], [4, 2, 1], [4, 3, 2], [4, 0, 3]]
    meshio.Mesh(points, [("triangle", sides)]).write(tmp_path / "pyramid.stl")
    pyramid = run(capsys, "heights", "--file", str(tmp_path / "pyramid.stl"), "--size=1", "--cells=32", *common)
    assert pyramid["figures"]["approach"] > 0


SPHERE, WAVE = ["sphere", "--radius", "10"], ["wave", "--amplitude", "0.1"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([*BALL, "--force", "0"], "must be positive"),
        ([*BALL, "--force", "-5"], "must be positive"),
        ([*BALL, "--approach", "-0.1"], "must be positive"),
        ([*BALL, "--approach", "nan"], "must be a finite number"),
        ([*BALL, "--loads", "1,-2"], "must be positive"),
        ([*BALL, "--loads", "1,b"], "--loads reads like"),
        ([*BALL], "exactly one of --force, --approach and --loads; found none"),
        ([*BALL, "--force", "1", "--approach", "1"], "found --force and --approach"),
        ([*BALL, "--force", "100", "--size", "0.1"], "smaller than the contact along x"),
        ([*BALL, "--force", "100", "--size", "0.1"], "Give it 0.444"),
        ([*BALL, "--force", "1e9"], "beyond what the geometry allows"),
        ([*BALL, "--approach", "11"], "beyond what the geometry allows"),
        ([*BALL, "--force", "1", "--periodic"], "needs a size"),
        ([*BALL, "--force", "1", "--periodic", "--size", "1", "--load-point", "0", "0.1"], "cannot tilt"),
        ([*BALL, "--force", "1", "--size", "1", "1", "1"], "one or two numbers"),
        ([*SPHERE, "--force", "1"], "Give the half-space's modulus"),
        ([*SPHERE, "--force", "1", "--layer", "5,0.3"], "A layer reads like"),
        ([*SPHERE, "--approach", "3", "--layer", "5,0.3,2", "--size", "20"], "approach of 3 through layers of 2"),
        (["sphere", "--E", "1", "--force", "1"], "needs --radius"),
        ([*SPHERE, "--angle", "3", "--E", "1", "--force", "1"], "--angle says nothing about"),
        ([*WAVE, "--E", "1", "--force", "1"], "needs --size"),
        ([*WAVE, "--E", "1", "--force", "1", "--size", "1"], "give --periodic"),
        (["torus", "--ring=5", "--tube=1", "--E=1", "--force=1e6"], "beyond what the geometry allows"),
        (["flat", "--radius", "1", "--E", "1", "--force", "1", "--load-point", "2", "0", "--size", "3"], "tip over"),
        (["cylinder", "--radius=1", "--E=1", "--force=1", "--size=9"], "give it a length"),
        (["heights", "--file", "no.npy", "--E", "1", "--force", "1"], "no file"),
        ([*BALL, "--force", "1", "--plot", "/no/such/x.png"], "does not exist"),
        ([*BALL, "--force", "1", "--velocity", "1", "0"], "give a Viscoelastic material"),
        ([*BALL, "--force", "1", "--prony", "0.5"], "--prony reads like 1,2"),
        ([*SPHERE, "--force", "1", "--prony", "0.5,1", "--layer", "5,0.3,2"], "moduli at t = 0"),
        ([*BALL, "--approaches", "1,2"], "of a curve with --adhesion"),
        ([*BALL, "--adhesion", "1,b", "--size", "1", "--force", "1"], "--adhesion reads like 1,2"),
        ([*BALL, "--adhesion", "1,2", "--force", "1"], "give the grid a --size"),
        ([*BALL, "--adhesion", "1,2", "--size", "1", "--loads", "1,2"], "leave out --loads"),
        ([*BALL, "--adhesion", "1,2", "--size", "1", "--approaches", "1", "--force", "1"], "leave out --force"),
        ([*BALL, "--adhesion", "1,2", "--size", "1"], "exactly one of force and approach"),
    ],
)
def test_refusals(arguments, message, capsys):
    assert main(["halfspace", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_refusals_of_heights(tmp_path, capsys):
    z = 0.01 * np.random.default_rng(0).normal(size=(16, 16))
    holes = z.copy()
    holes[3, 4] = np.nan
    np.save(tmp_path / "holes.npy", holes)
    np.save(tmp_path / "slope.npy", 1e-3 * z + 0.01 * np.arange(16)[:, None])
    np.save(tmp_path / "nm.npy", 1e6 * z)
    common = ["--E=1", "--force=1", "--size=1"]
    for file, more, message in (
        ("holes.npy", [], "hold 1 NaN"),
        ("nm.npy", [], "another unit"),
        ("nm.npy", ["--height-unit=0"], "unit of the heights"),
        ("slope.npy", ["--periodic"], "do not repeat along x"),
        ("slope.npy", [], "reaches the border"),
    ):
        assert main(["halfspace", "heights", "--file", str(tmp_path / file), *common, *more]) == 2
        assert message in capsys.readouterr().err


def test_an_own_shape_has_no_closed_form_whatever_its_kind():
    class Own:
        kind = "cone"

        def heights(self, x, y):
            return x**2 + y**2

    half = fc.HalfSpace(fc.Material(1.0, 0.3), size=(1.0, 1.0), cells=(8, 8))
    assert closed_form(Own(), half, Load(1.0, None, None)) is None
    assert closed_form(fc.Sphere(1.0), half, Load(0.01, None, None)) is not None
