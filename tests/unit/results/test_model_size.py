"""What a result says of time, memory and what was not computed."""

import math

import numpy as np
import pytest

import fecontact as fc

STEEL = fc.Material(E=200.0, nu=0.3)


@pytest.fixture(scope="module")
def quarter():
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=0.5, level=1)
    upper = fc.ElasticBody(mesh, STEEL, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"}, name="upper")
    lower = upper.placed(rotation=fc.rotation_about((1, 1, 0), math.pi), name="lower")
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower)])
    return scene.solve(forces={upper: (0, 0, -1.0)})


def test_memory_rises_by_stage(quarter):
    stages = ["before", "pair", "assemble", "factorise", "condense", "solve", "certify"]
    assert sorted(quarter.memory) == sorted(stages)
    ordered = [quarter.memory[s] for s in ("before", "pair", "factorise", "solve", "certify")]
    assert ordered[0] > 10
    assert (np.diff(ordered) >= 0).all()
    summary = quarter.summary()
    assert summary["memory_mb"] == quarter.memory
    assert set(summary["seconds"]) - {"before"} == {*stages[1:], "total"}  # 'before' where it takes its time
    assert "Peak MB" in str(quarter)


def test_what_was_saved(quarter):
    text = "\n".join(quarter.summary()["saved"])
    points = len(quarter.contacts[0].gap)
    assert f"{quarter.n_candidates} candidates out of {points} contact points" in text
    kept = quarter.scene.bodies[0].model.n_retained
    assert 0 < kept < 0.1 * quarter._n_dofs_factorised
    assert f"{quarter._n_dofs_factorised} degrees of freedom condensed to {kept}" in text
    assert "upper: held along the normal only on sym_x, sym_y; as planes of symmetry these make it 1/4" in text
    assert "lower: the model of 'upper' in another pose" in text
    assert text.splitlines()[0] in str(quarter)


def test_what_rigid_bodies_and_sections_save():
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    body = fc.AxisymmetricBody(mesh, STEEL, "bottom", {"top": "xz"}, name="plug")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    assert result.summary()["saved"][-2:] == [
        "plug: a section instead of a solid",
        "floor: rigid, nothing to factorise",
    ]
