"""A user's scene at several accuracies: errors, files, what is refused."""

import csv
import json

import numpy as np
import pytest
from common_scenes import BALL_ON_BLOCK
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.studies.compare import compare_scene

BALL_ON_HALF_SPACE = """
[materials.soft]
E = 1.0
nu = 0.3
[bodies.half]
type = "half-space"
material = "soft"
size = [1.0, 1.0]
cells = [16, 16]
[bodies.ball]
type = "rigid"
shape = {kind = "sphere", radius = 2.0}
[[contacts]]
slave = "half"
master = "ball"
[loads]
motions.ball = {z = -0.03}
"""


@pytest.mark.full
def test_a_scene_is_compared_with_the_run_of_the_smallest_estimate(tmp_path, written, capsys):
    path = written(BALL_ON_BLOCK)
    assert main(["compare", str(path), "--json", str(tmp_path / "c.json")]) == 0
    rows = json.loads((tmp_path / "c.json").read_text())["rows"]
    assert [row["accuracy"] for row in rows] == [0.2, 0.1, 0.05]
    assert [row["dofs"] for row in rows] == sorted(row["dofs"] for row in rows)
    assert rows[2]["pressure L2"] is None
    assert rows[1]["pressure L2"] < rows[0]["pressure L2"] < 0.2
    assert "largest" in capsys.readouterr().out


def test_grids_of_half_spaces_get_more_cells(tmp_path, written, capsys):
    path = written(BALL_ON_HALF_SPACE)
    files = [str(tmp_path / name) for name in ("c.csv", "c.png")]
    assert main(["compare", str(path), "--runs", "2", "--csv", files[0], "--plot", files[1]]) == 0
    first, last = list(csv.DictReader((tmp_path / "c.csv").read_text().splitlines()))
    assert [first["points"], last["points"]] == [str(16**2), str(32**2)]
    # a ball of radius 2 pressed by .03: Hertz's area pi R d; a quarter of the cells along each side lies within it
    assert last["area"] == ""
    assert abs(float(first["area"])) <= 0.1
    assert 0 < float(first["pressure L2"]) <= 0.2
    assert (tmp_path / "c.png").stat().st_size > 3000
    found = compare_scene(path, 2)
    assert np.isfinite([row["estimate"] for row in found.data["rows"]]).all()
    assert "Errors are those beside the run without one" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "found"), [([], "found no scene"), (["hertz"], "found 'hertz'"), (["x.step"], "found 'x.step'")]
)
def test_without_a_scene_it_says_what_it_compares_and_where_the_rest_is(given, found, capsys):
    assert main(["compare", *given]) == 2
    said = capsys.readouterr().err
    assert all(text in said for text in (found, "scene file", "tests/benchmarks/compare", "docs/compare.md"))


@pytest.mark.parametrize(
    ("more", "said"),
    [("[[cases]]\nname = 'one'\nmotions.ball = {z = -0.02}\n", ("several-cases", "has 1")), (None, ("no-contact",))],
)
def test_scenes_of_several_cases_or_without_contact_are_refused(more, said, tmp_path):
    path = tmp_path / "scene.toml"
    spring = "[[springs]]\nstiffness = 1.0\nstart = {body = 'ball', point = [0, 0, 0]}\nend = {point = [0, 0, 1]}\n"
    text = (
        BALL_ON_BLOCK.replace('[[contacts]]\nslave = "block"\nmaster = "ball"\n', spring)
        if more is None
        else BALL_ON_BLOCK + more
    )
    path.write_text(text)
    with refused(fc.InputError, *said):
        compare_scene(path, 2)


def test_one_run_is_no_comparison(tmp_path):
    with refused(fc.InputError, "one-run"):
        compare_scene(tmp_path / "scene.toml", 1)
