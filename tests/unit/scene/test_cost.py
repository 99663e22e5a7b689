"""What is said of a scene before it is solved, against what solving it then takes."""

import json
import subprocess
import sys

import pytest

from fecontact.app.cli import main

SPHERE = """
title = "a ball on a floor"
[materials.steel]
E = 2.0e6
nu = 0.3
[bodies.ball]
shape = {kind = "quarter_sphere", radius = 25.0, contact_radius = 0.18, level = 2}
material = "steel"
contact = "cap"
supports = {base = "xyz", sym_x = "x", sym_y = "y"}
[bodies.floor]
type = "rigid"
shape = {kind = "plane"}
[[contacts]]
slave = "ball"
master = "floor"
[loads]
forces.ball = [0, 0, -180.0]
"""

BLOCKS = """
[materials.steel]
E = 200.0
nu = 0.3
[bodies.upper]
shape = {kind = "block", size = [1, 1, 1], divisions = [9, 9, 9]}
material = "steel"
contact = "bottom"
supports = {top = "xyz"}
pose = {translation = [0, 0, 1]}
[bodies.lower]
shape = {kind = "block", size = [1, 1, 1], divisions = [7, 7, 7]}
material = "steel"
contact = "top"
supports = {bottom = "xyz"}
[[contacts]]
slave = "upper"
master = "lower"
[loads]
motions.upper = {z = -0.01}
"""

# in a process of its own, whose memory is not that of the tests before it
BOTH = """
import json, sys
from fecontact.scene.cost import explain
from fecontact.app.scene_file.scene_file import read_scene
from fecontact.common.stopwatch import peak_memory

file = read_scene(sys.argv[1])
told = explain(file.scene, file.loads).as_dict()
result = file.solve()
taken = {"n_dofs": result.n_dofs, "n_candidates": result.n_candidates, "memory_mb": peak_memory(),
         "retained": [b.model.n_retained for b in result._elastic_bodies], "seconds": result.seconds["total"]}
print(json.dumps([told, taken]))
"""


@pytest.mark.full
@pytest.mark.parametrize(("name", "text"), [("sphere", SPHERE), ("blocks", BLOCKS)])
def test_estimates_hold(name, text, written):
    path = written(text)
    done = subprocess.run([sys.executable, "-c", BOTH, str(path)], capture_output=True, text=True, check=True)
    told, taken = json.loads(done.stdout.splitlines()[-1])
    assert told["n_dofs"] == taken["n_dofs"]
    assert [m["n_retained"] for m in told["models"]] == taken["retained"]
    # exact unless the solution takes in more points
    assert abs(told["n_candidates"] / taken["n_candidates"] - 1) < 0.3
    # the promise: within a factor of two
    assert 0.5 < told["memory_mb"] / taken["memory_mb"] < 2
    ratios = told["memory_mb"] / taken["memory_mb"], told["seconds"] / taken["seconds"]
    print(f"{name}: memory, told over taken {ratios[0]:.2f}; time {ratios[1]:.2f}")


def test_the_command_line_says_it(tmp_path, written, capsys):
    path, figures = written(SPHERE.replace("level = 2", "level = 1")), tmp_path / "cost.json"
    assert main(["explain", str(path), "--json", str(figures)]) == 0
    text = capsys.readouterr().out
    for part in ("a ball on a floor", "Unknowns:", "forces on nodes", "active set", "1/4 of the whole", "Estimate:"):
        assert part in text
    assert "finite strain" not in text
    told = json.loads(figures.read_text())
    assert told["n_candidates"] <= told["n_points"]
    assert main(["explain", str(tmp_path / "none.toml")]) == 2


def test_a_law_of_finite_strain_is_told(written, capsys):
    path = written(SPHERE.replace("level = 2", "level = 1").replace("]\nE =", ']\nlaw = "NeoHookean"\nE =', 1))
    assert main(["explain", str(path)]) == 0
    text = capsys.readouterr().out
    assert "finite strain by NeoHookean" in text
    assert "an iteration of Newton's method" in text
