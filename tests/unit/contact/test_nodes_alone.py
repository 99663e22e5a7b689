"""Sets of nodes as slaves: a force on each node, in place of pressures on faces."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from tests.deck_text import listed

# forces and displacements are of order one; what remains is rounding of small systems
ROUNDING = 1e-9
STEEL = fc.Material(E=100.0, nu=0.3)


def block(n=(2, 2, 2), element="hex20", **sets):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), n, element=element)
    named = {name: np.flatnonzero((np.abs(mesh.points - place) < 1e-9).all(axis=1)) for name, place in sets.items()}
    return _with(mesh, named)


def _with(mesh, named):
    return replace(mesh, node_sets={**mesh.node_sets, **named})


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_a_node_pressed_by_a_plane_bears_what_a_support_there_does(element):
    """Beside prescribed displacements of the same node, which know nothing of contact."""
    mesh = block(element=element, tip=(0.5, 0.5, 1.0), corner=(1.0, 1.0, 1.0))
    body = fc.ElasticBody(mesh, STEEL, contact="tip", supports={"bottom": "xyz"})
    floor = fc.RigidBody(fc.Plane()).placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    (contact,) = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={floor: {"z": -0.01}}).contacts
    assert contact.note == "nodes alone, each with its share of all faces round it"
    assert contact.active.tolist() == [True]
    assert str(contact.error_estimate) == "pressure: forces on single nodes, no field to estimate"
    # faces in contact would get nodes in their middles
    held = fc.ElasticBody(mesh, STEEL, contact="corner", supports={"bottom": "xyz", "tip": "z"})
    away = fc.RigidBody(fc.Plane()).placed((0, 0, 3.0), fc.rotation_about((1, 0, 0), np.pi))
    moved = fc.Scene([held, away], [fc.Contact(held, away)]).solve(displacements={(held, "tip"): [0, 0, -0.01]})
    assert abs(contact.force[2] - moved.reaction(held, "tip")[2]) < ROUNDING


def test_all_nodes_alone_are_the_face_with_nodal_forces():
    mesh = block(element="hex8")
    mesh = _with(mesh, {"feet": mesh.boundary_nodes("bottom")})
    floor = fc.RigidBody(fc.Plane())
    found = []
    for name in ("bottom", "feet"):
        body = fc.ElasticBody(mesh, STEEL, contact=name, supports={"top": "xyz"})
        contact = fc.Contact(body, floor, coupling="nodal", friction=0.2)
        found.append(fc.Scene([body, floor], [contact]).solve(motions={body: {"z": -0.01, "x": 0.002}}).contacts[0])
    assert np.abs(found[0].forces - found[1].forces).max() < ROUNDING
    assert np.abs(found[0].force - found[1].force).max() < ROUNDING


@pytest.mark.parametrize("first", [True, False])
def test_a_node_within_a_face_shares_its_force_by_shape_functions(first):
    """By hand: columns without lateral strain, E = 100, of length 1: the node at (1/4, 1/4) of a face of four nodes
    loads them by 9, 3, 3 and 1 sixteenths; whichever side is named first."""
    lower = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    upper = _with(
        fc.shapes.block((0.5, 0.5, 1.0), (1, 1, 1), element="hex8").translated((0.25, 0.25, 1.0)),
        {"foot": np.array([0])},
    )
    assert upper.points[0].tolist() == [0.25, 0.25, 1.0]
    below = fc.ElasticBody(lower, STEEL, contact="top", supports={"bottom": "xyz"}, name="below")
    above = fc.ElasticBody(upper, STEEL, contact="foot", supports={"top": "xyz"}, name="above")
    pair = (above, below) if first else (below, above)
    result = fc.Scene([above, below], [fc.Contact(*pair)]).solve(motions={above: {"z": -0.01}})
    force = abs(result.contacts[0]._whole.force[2])
    corners = below.mesh.boundary_nodes("top")
    x = below.mesh.points[corners]
    shares = np.prod(np.where(x[:, :2] == 0, 0.75, 0.25), axis=1)
    loads = {(below, tuple(p)): [0, 0, -force * s] for p, s in zip(x.tolist(), shares, strict=True)}
    away = fc.RigidBody(fc.Plane()).placed((0, 0, 9.0), fc.rotation_about((1, 0, 0), np.pi))
    alone = fc.Scene([below, away], [fc.Contact(below, away)]).solve(forces=loads)
    assert force > 0.05
    assert np.abs(alone.displacement(below) - result.displacement(below)).max() < ROUNDING


def test_a_node_of_a_section():
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    tip = np.flatnonzero((np.abs(mesh.points - [0.5, 0, 1.0]) < 1e-9).all(axis=1))
    mesh = _with(mesh, {"tip": tip})
    body = fc.PlaneBody(mesh, STEEL, contact="tip", supports={"bottom": "xz"}, thickness=2.0)
    floor = fc.RigidBody(fc.Plane()).placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={floor: {"z": -0.01}})
    held = fc.PlaneBody(mesh, STEEL, contact="top", supports={"bottom": "xz", "tip": "z"}, thickness=2.0)
    away = fc.RigidBody(fc.Plane()).placed((0, 0, 3.0), fc.rotation_about((1, 0, 0), np.pi))
    moved = fc.Scene([held, away], [fc.Contact(held, away)]).solve(displacements={(held, "tip"): [0, 0, -0.01]})
    assert abs(result.contacts[0].force[2] - moved.reaction(held, "tip")[2]) < ROUNDING


def test_a_scene_file_names_a_set_of_nodes(tmp_path):
    """Two nodes of a mesh of a file, beside the same in Python."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    (tmp_path / "up.inp").write_text(listed("UP", mesh, 1) + "*NSET, NSET=TIPS\n1,\n2,\n")
    text = """
    [materials.steel]
    E = 100.0
    nu = 0.3
    [bodies.up]
    mesh = "up.inp"
    material = "steel"
    contact = "TIPS"
    supports = {UP_top = "xyz"}
    [bodies.floor]
    type = "rigid"
    shape = {kind = "plane"}
    [[contacts]]
    slave = "up"
    master = "floor"
    [loads]
    motions.up = {z = -0.01}
    """
    (tmp_path / "scene.toml").write_text(text)
    found = fc.read_scene(tmp_path / "scene.toml").solve().contacts[0]
    body = fc.ElasticBody(_with(mesh, {"tips": np.array([0, 1])}), STEEL, "tips", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    (alone,) = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}}).contacts
    assert np.abs(found.forces - alone.forces).max() < ROUNDING


def test_what_nodes_alone_are_not_for():
    mesh = block(tip=(0.5, 0.5, 0.0), core=(0.5, 0.5, 0.5))
    body = fc.ElasticBody(mesh, STEEL, contact="tip", supports={"top": "xyz"})
    other = fc.ElasticBody(mesh.translated((0, 0, -1.0)), STEEL, contact="tip", supports={"top": "xyz"}, name="other")
    floor = fc.RigidBody(fc.Plane())
    with refused(fc.InputError, "nodes-alone", "one side of a contact needs faces"):
        fc.Scene([body, other], [fc.Contact(body, other)]).solve(motions={body: {"z": -0.01}})
    with refused(fc.InputError, "nodes-alone", "'tip'"):
        fc.Scene([body, floor], [fc.Contact(body, floor, coupling="mortar")]).solve(motions={body: {"z": -0.01}})
    with refused(fc.InputError, "nodes-alone", "accuracy"):
        fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}}, accuracy=0.1)
    with refused(fc.InputError, "nodes-inside", "'core'"):
        fc.Contact(fc.ElasticBody(mesh, STEEL, contact="core", supports={"top": "xyz"}), floor)
