"""A user's scene at several refinements: errors, resuming, what is refused."""

import json
from pathlib import Path

import meshio
import numpy as np
import pytest
from common_scenes import BALL_ON_BLOCK
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.compare import machine, refinements
from fecontact.app.compare.refinements import WAYS, compare_scene


@pytest.mark.full
def test_a_scene_is_compared_with_its_finest_run(tmp_path, capsys):
    path, out = tmp_path / "scene.toml", tmp_path / "out"
    path.write_text(BALL_ON_BLOCK)
    command = ["compare", str(path), "--refinements", "3", "--out", str(out)]
    assert main(command) == 0
    rows = json.loads((out / "compare_scene.json").read_text())["rows"]
    ways = {
        way: [r for r in rows if r["method"] == way] for way in ("uniform refinement", "divided where the error is")
    }
    for runs in ways.values():
        assert [r["dofs"] for r in runs] == sorted(r["dofs"] for r in runs)
        assert abs(runs[1]["errors"]["pressure_l2"]) < abs(runs[0]["errors"]["pressure_l2"]) < 0.5
    # the reference is the run with the smallest estimate; a division where the error is needs fewer unknowns
    uniform, divided = ways.values()
    assert divided[-1]["errors"] == {}
    assert divided[1]["errors"]["pressure_l2"] < uniform[2]["errors"]["pressure_l2"]
    assert divided[1]["dofs"] < uniform[2]["dofs"] / 2
    kept = (out / "compare_scene.jsonl").read_text()
    assert main(command) == 0
    assert (out / "compare_scene.jsonl").read_text() == kept
    assert "largest" in capsys.readouterr().out


@pytest.mark.full  # the estimate of a punch whose rim lies within faces is too large, and divides them for minutes
def test_a_scene_that_reads_another_mesh_is_run_again(tmp_path, monkeypatch):
    """The scene file is the same to the letter, the mesh that it names is not."""
    # below a sharp edge a finer accuracy takes minutes
    monkeypatch.setattr(refinements, "COARSEST", 0.8)
    path, rows_path = tmp_path / "scene.toml", tmp_path / "rows.jsonl"
    path.write_text(BALL_ON_BLOCK.replace('shape = {kind = "sphere", radius = 2.0}', 'surface = {file = "tip.stl"}'))

    def found(half_side):
        """Contact area below a flat square punch."""
        corners = half_side * np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        meshio.Mesh(corners, [("triangle", [[0, 2, 1], [0, 3, 2]])]).write(tmp_path / "tip.stl")
        return [row["found"]["area"] for row in compare_scene(path, 2, rows_path)]

    first, second = found(0.3), found(0.4)
    assert min(second) > 1.3 * max(first)
    # samples beside the rows are those of the other punch by now: they are not mixed with rows of this one
    assert found(0.3) == first
    assert len(rows_path.read_text().splitlines()) == 6 * len(WAYS)
    assert found(0.3) == first
    assert len(rows_path.read_text().splitlines()) == 6 * len(WAYS)


@pytest.mark.full
def test_a_scene_that_cannot_be_refined_is_named(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(BALL_ON_BLOCK)
    assert main(["compare", str(path), "--refinements", "1"]) == 2
    assert "at least 2 refinements" in capsys.readouterr().err
    ball = 'shape = {kind = "half_sphere", radius = 1.0, level = 4}'
    text = BALL_ON_BLOCK.replace('shape = {kind = "block", size = [1.0, 1.0, 1.0], divisions = [4, 4, 2]}', ball)
    path.write_text(text.replace('"top"', '"cap"').replace("bottom", "base"))
    assert main(["compare", str(path), "--refinements", "3"]) == 2
    assert "5 is the finest" in capsys.readouterr().err


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


def test_the_sources_of_every_room_are_part_of_the_code(monkeypatch):
    read = []
    monkeypatch.setattr(machine, "fingerprint", lambda files: read.extend(name for name, _ in files))
    machine.code.__wrapped__()
    assert {Path(name).parts[0] for name in read} >= {"common", "mesh", "solvers", "scene", "app"}


def test_the_code_is_told_apart_by_what_it_says(monkeypatch):
    now = machine.code()
    assert machine.code() == now
    machine.code.cache_clear()
    monkeypatch.setattr(machine.Path, "read_bytes", lambda self: b"changed")
    assert machine.code() != now
    machine.code.cache_clear()
