"""Load paths whose steps have scenes of their own: other supports and other friction of the same bodies."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

# forces of order 0.01 by systems of unit stiffness
ROUNDING = 1e-10


def scene(friction=0.3, top="xyz", n=2):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, n, n), element="hex8")
    block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": top}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return fc.Scene([block, floor], [fc.Contact(block, floor, friction=friction)])


def press(scene, z=-0.01, x=0.0):
    return {"motions": {scene.bodies[0]: {"z": z, "x": x}}}


@pytest.mark.parametrize("finite", [False, True])
def test_what_is_let_go_keeps_no_force_across(finite):
    """The top of a sheared block, let go sideways: by equilibrium friction has no resultant; the pressure stays."""
    first, then = scene(), scene(top="z")
    steps = [press(first), press(first, x=0.001), {"motions": {then.bodies[0]: {"z": -0.01}}, "scene": then}]
    path = first.solve_path(steps, finite_motion=finite)
    assert abs(path.forces[1, 0, 0]) > 1e-4
    assert np.abs(path.forces[2, 0] - [0, 0, 0.01]).max() < ROUNDING
    assert path[2].scene.bodies[0].supports == {"top": "z"}
    assert path.cuts[2] == 1
    assert len(path.table()) == 3


def test_friction_that_changes_is_mu_times_the_force():
    first, slippery = scene(), scene(friction=0.1)
    drag = press(slippery, x=0.04)
    path = first.solve_path([press(first), press(first, x=0.02), {**drag, "scene": slippery}])
    assert np.abs(path.forces[:, 0, 0] - [0.0, -0.003, -0.001]).max() < ROUNDING


def test_the_same_scene_made_anew_changes_nothing():
    first, again = scene(), scene()
    steps = [press(first), press(first, x=0.02), press(first, x=0.018)]
    one = first.solve_path(steps)
    new = press(again, x=0.018)
    other = first.solve_path([*steps[:2], {**new, "scene": again}])
    assert np.abs(one.forces - other.forces).max() < ROUNDING


def test_a_path_of_several_scenes_goes_on_from_its_file(tmp_path):
    first, then = scene(), scene(top="z")
    steps = [press(first), press(first, x=0.02), {"motions": {then.bodies[0]: {"z": -0.01}}, "scene": then}]
    file = tmp_path / "path.jsonl"
    whole = first.solve_path(steps, file)
    file.write_text("".join(file.read_text().splitlines(keepends=True)[:2]))
    assert np.abs(first.solve_path(steps, file).forces - whole.forces).max() < ROUNDING
    with refused(fc.InputError, "row-of-another", "3"):
        first.solve_path([*steps[:2], {"motions": {first.bodies[0]: {"z": -0.01}}}], file)


def test_what_scenes_of_steps_are_not_for():
    first, finer = scene(), scene(n=3)
    with refused(fc.InputError, "scene-of-step", "step 2"):
        first.solve_path([press(first), {**press(finer), "scene": finer}])
    free = scene(friction=0.0)
    with refused(fc.InputError, "scene-of-step", "step 2"):
        first.solve_path([press(first), {**press(free), "scene": free}])
    for options in ({"accuracy": 0.1}, {"wear": {first.contacts[0]: 1e-3}}):
        other = scene(top="z")
        step = {"motions": {other.bodies[0]: {"z": -0.01}}, "scene": other}
        with refused(fc.InputError, "scene-of-step", "Step 2"):
            first.solve_path([press(first), step], **options)
    with refused(fc.InputError, "wrong-class", "scene of step 2"):
        first.solve_path([press(first), {**press(first), "scene": replace(first.bodies[0])}])
