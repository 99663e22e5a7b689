"""Instability at finite strain: columns buckle at the load of Euler, arches snap, contact holds blocks."""

from __future__ import annotations

import re

import numpy as np
import pytest

import fecontact as fc
from fecontact.fem.factor import is_definite
from fecontact.scene.stability import weakest
from fecontact.surfaces import Cylinder
from tests.refusals import refused


def plate(z: float) -> fc.RigidBody:
    return fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, -z)).placed(rotation=np.diag([1.0, -1, -1]))


def column(nu: float, turn: np.ndarray | None = None):
    """A column of unit width and height 20 on the ground below a plate, which keeps its top level."""
    mesh = fc.sections.rectangle((1.0, 20.0), (2, 12))
    law = fc.NeoHookean(E=1.0, nu=nu)
    body = fc.PlaneBody(mesh, law, contact="top", supports={"bottom": "xz"}, name="column")
    above = plate(20.0)
    if turn is not None:
        body, above = body.placed(rotation=turn), above.placed(rotation=turn)
    return above, fc.Scene([body, above], [fc.Contact(body, above)])


def share_of(text: str) -> float:
    """Share of the load step that a text tells."""
    return float(re.search(r"([\d.]+)% of the load step", text)[1]) / 100


@pytest.mark.parametrize(("nu", "tolerance"), [(0.0, 0.01), (0.45, 0.035)])
def test_a_column_is_not_stable_from_the_load_of_euler_on(nu: float, tolerance: float) -> None:
    """Clamped below, level above: pi^2 E' I / L^2 with E' = E / (1 - nu^2).

    With nu the ground, which holds the foot across too, makes the column shorter by about 0.3 of its width.
    """
    above, scene = column(nu)
    euler = np.pi**2 / (1 - nu**2) / 12 / 20**2
    shortened = 1.4 * euler * (1 - nu**2) * 20
    for load in ({"forces": {above: (0, 0, -1.4 * euler)}}, {"motions": {above: {"z": -shortened}}}):
        result = scene.solve(**load)
        (text,) = [t for t in result.warnings if "not stable" in t]
        assert share_of(text) == pytest.approx(1 / 1.4, rel=tolerance)
        assert text.startswith("'column' is not stable from")
        assert "a motion along x, largest at" in text
    assert weakest(result).stiffness == pytest.approx(1 - 1.4, abs=1.4 * tolerance)
    below = scene.solve(forces={above: (0, 0, -0.9 * euler)})
    assert not [t for t in below.warnings if "stable" in t]
    assert weakest(below).stiffness == pytest.approx(0.1, abs=tolerance)


def test_steps_of_a_path_tell_where_it_begins() -> None:
    above, scene = column(0.0)
    step = np.pi**2 / 12 / 20 / 2.5
    path = scene.solve_path([{"motions": {above: {"z": -k * step}}} for k in (1, 2, 3, 4)])
    texts = [[t for t in result.warnings if "not stable" in t] for result in path]
    assert [len(found) for found in texts] == [0, 0, 1, 1]
    assert share_of(texts[2][0]) == pytest.approx(0.5, abs=0.02)
    assert "load step" not in texts[3][0]  # it was not stable before


def test_a_turned_column_has_the_same_motion() -> None:
    turn = fc.rotation_about((0.0, 1.0, 0.0), 0.5)
    above, scene = column(0.0, turn)
    way = turn @ [0, 0, -0.06]
    result = scene.solve(motions={above: {"x": way[0], "z": way[2]}})
    (text,) = [t for t in result.warnings if "not stable" in t]
    across = [float(v) for v in re.search(r"along \((.*?)\), largest", text)[1].split(",")]
    assert abs(np.dot(across, turn[:, 0])) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("backend", ["auto", "superlu"])
def test_a_block_that_its_contact_holds_is_stable(backend: str) -> None:
    """Its tangent alone is not definite at half the height."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    supports = {"bottom": "z", "x_min": "x", "y_min": "y"}
    law = fc.NeoHookean(E=2.0, nu=0.4)
    body = fc.ElasticBody(mesh, law, contact="top", supports=supports, name="block", backend=backend)
    above = plate(1.0)
    result = fc.Scene([body, above], [fc.Contact(body, above)]).solve(motions={above: {"z": -0.5}})
    (at_state,) = result._elastic_bodies
    at_state.model.springs = None
    assert not is_definite(at_state.model.solved_stiffness())
    assert not [t for t in result.warnings if "stable" in t]
    assert weakest(result).stiffness > 0.05


def arch():
    """A shallow arch, clamped at both ends, below a cylinder."""
    mesh = fc.sections.rectangle((20.0, 0.5), (12, 1))
    mesh = mesh.mapped(lambda x: x + np.outer(np.cos(np.pi * (x[:, 0] - 10) / 20), [0, 0, 1.0]) - [10.0, 0, 0])
    law, ends = fc.NeoHookean(E=1.0, nu=0.3), {"left": "xz", "right": "xz"}
    body = fc.PlaneBody(mesh, law, contact="top", supports=ends, name="arch")
    roller = fc.RigidBody(Cylinder(2.0), name="roller").placed((0, 0, 1.5))
    return body, roller, fc.Scene([body, roller], [fc.Contact(body, roller)])


def test_an_arch_snaps_at_the_largest_force_that_motions_find() -> None:
    _, roller, scene = arch()
    path = scene.solve_path([{"motions": {roller: {"z": -z}}} for z in (0.4, 0.5, 0.6)])
    force = -path.forces[:, 0, 2]
    top = np.polyfit([-1, 0, 1], force, 2)
    largest = np.polyval(top, -top[1] / top[0] / 2)
    assert force[2] < largest
    with refused(fc.SolverError, "unstable", "'arch'") as caught:
        scene.solve(forces={roller: (0, 0, -1.3 * largest)})
    assert "a motion along z, largest at (0, 0, " in str(caught.value)
    # a step is halved five times
    assert 0 <= 1 / 1.3 - share_of(str(caught.value)) < 1 / 32
    assert scene.solve(forces={roller: (0, 0, -0.9 * largest)}).finite_strain[-1].unstable == ""


def test_a_snap_that_newtons_method_passes_is_found() -> None:
    """Half way through the step it is on the other side, at an equilibrium that is stable."""
    body, _, _ = arch()
    far = plate(20.0)
    scene = fc.Scene([body, far], [fc.Contact(body, far)])
    with refused(fc.SolverError, "unstable", "'arch'"):
        scene.solve(tractions={(body, "top"): (0, 0, -1e-4)})


def test_a_body_without_support_has_its_own_error() -> None:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    body = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.3), contact="top", name="block")
    above = plate(1.0)
    with refused(fc.SupportError, "free-motion", "block"):
        fc.Scene([body, above], [fc.Contact(body, above)]).solve(forces={above: (0, 0, -0.1)})


def test_a_free_body_between_two_plates_does_not_jump() -> None:
    """Its nodes move far against those that pin it, but not in the world."""
    mesh = fc.shapes.block((1.0, 0.5, 2.0), (3, 1, 4), element="hex8")
    mesh = mesh.mapped(lambda x: (x - [0, 0, 1]) * np.stack([x[:, 0] ** 0, x[:, 0] ** 0, 1 - 0.3 * x[:, 0] ** 2], 1))
    ends, sides = ("top", "bottom"), {"x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.3), contact=ends, supports=sides, name="barrel")
    up = fc.RigidBody(fc.Plane(), name="up").placed((0, 0, 1.0), rotation=np.diag([1.0, -1, -1]))
    low = fc.RigidBody(fc.Plane(), name="low").placed((0, 0, -1.0))
    contacts = [fc.Contact(body, plane, surfaces=(name, "surface")) for plane, name in ((up, "top"), (low, "bottom"))]
    result = fc.Scene([body, up, low], contacts).solve(motions={up: {"z": -0.3}, low: {"z": 0.3}})
    assert len(result.finite_strain) == 1
