"""Surfaces that do not face each other are refused with the angle; those that do in odd ways stay."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.contact.coupling.nodal import SurfacePair, pair

pytestmark = pytest.mark.rounding(0)

SOLID = fc.Material(E=1000.0, nu=0.3)
FLOOR = fc.RigidBody(fc.Plane(), name="floor")


def block(size=(1.0, 1.0, 1.0), cells=(2, 2, 2), name="block", **options):
    return fc.ElasticBody(fc.shapes.block(size, cells), SOLID, name=name, **options)


@pytest.mark.parametrize("coupling", ["auto", "nodal", "mortar"])
@pytest.mark.parametrize(("contact", "angle"), [("top", 0), ("x_min", 90), ("y_max", 90)])
def test_faces_that_do_not_look_at_the_floor_are_refused_with_the_angle(contact, angle, coupling):
    upper = block(contact=contact, supports={"bottom": "xyz"})
    scene = fc.Scene([upper, FLOOR], [fc.Contact(upper, FLOOR, coupling=coupling)])
    with refused(fc.InputError, "not-facing", f"'{contact}' of 'block'", "'floor'", f" {angle} degrees"):
        scene.solve(forces={upper: (0, 0, -1)})


def test_the_angle_is_that_of_the_poses():
    turn = fc.rotation_about((0, 1, 0), np.radians(-30.0))
    upper = block(contact="x_max", supports={"bottom": "xyz"}).placed(rotation=turn)
    with refused(fc.InputError, "not-facing", "are 60"):
        fc.Scene([upper, FLOOR], [fc.Contact(upper, FLOOR)]).solve(forces={upper: (0, 0, -1)})


@pytest.mark.parametrize("kind", ["elastic", "section", "half-space"])
def test_other_kinds_of_surfaces_that_look_the_same_way_are_refused(kind):
    if kind == "elastic":
        one = block(contact="top", supports={"bottom": "xyz"})
        other = block(contact="top", supports={"bottom": "xyz"}, name="other").placed((0, 0, -0.5))
    elif kind == "section":
        mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
        one, other = fc.PlaneBody(mesh, SOLID, "top", {"bottom": "xz"}), FLOOR
    else:
        one, other = fc.HalfSpace(SOLID, size=(1.0, 1.0), cells=(4, 4)), FLOOR
    with refused(fc.InputError, "not-facing", "are 0"):
        fc.Scene([one, other], [fc.Contact(one, other)]).solve(motions={one: {"z": -0.01}})


def test_an_arch_that_stands_on_the_edges_of_its_inner_face_is_refused():
    """Some of the inner face looks at the floor, but what stands on it looks sideways."""
    mesh = fc.shapes.thick_ring(1.0, 2.0, 0.5, (6, 2, 1), sector="half")
    upright = fc.rotation_about((1, 0, 0), np.pi / 2)
    arch = fc.ElasticBody(mesh, SOLID, "inner", {"outer": "xyz"}).placed(rotation=upright)
    assert np.isclose(arch.pose.to_world(mesh.points)[:, 2].min(), 0.0)
    with refused(fc.InputError, "not-facing", "where they are nearest", "are 90"):
        fc.Scene([arch, FLOOR], [fc.Contact(arch, FLOOR)]).solve(motions={arch: {"z": -0.01}})


def test_a_steep_tip_between_the_nodes_is_told_and_not_refused():
    """The nodes beside a tilted cone look at its flank, which is upright; its tip stands lower, on a face."""
    mesh = fc.shapes.block((0.946, 0.885, 0.917), (3, 5, 1), element="hex8")
    body = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"})
    turn = fc.rotation_about((0.538, -0.843, 0), 0.45)
    tip = np.array([0.235, 0.806, 0.917])
    cone = fc.RigidBody(fc.surfaces.Cone(1.1315), pose=fc.Pose(turn, tip))
    result = fc.Scene([body, cone], [fc.Contact(body, cone)]).solve(motions={cone: {"z": -7e-4}})
    found = result.contacts[0]._between_nodes.overlap
    # the depth along the flanks is less than that of the tip
    assert 4e-4 < found.depth < 7e-4
    assert np.abs(found.points[0] - tip).max() < 1e-4
    assert any("overlap by" in text for text in result.warnings)


def bottom_edge(angle):
    """A block tilted about its edge, pressed on the floor with that edge: the outcome of its bottom as contact."""
    turn = fc.rotation_about((0, 1, 0), np.radians(angle))
    upper = block(contact="bottom", supports={"top": "xyz"}).placed(rotation=turn)
    low = upper.pose.to_world(upper.mesh.points)[:, 2].min()
    upper = upper.placed((0, 0, -low))
    return fc.Scene([upper, FLOOR], [fc.Contact(upper, FLOOR)]).solve(motions={upper: {"z": -0.01}})


@pytest.mark.parametrize("angle", [5.0, 45.0, 80.0])
def test_a_block_on_its_edge_is_no_mistake(angle):
    contact = bottom_edge(angle).contacts[0]
    assert contact.force[2] > 0
    assert np.ptp(contact.points[contact.active][:, 0]) < 0.6


@pytest.mark.parametrize("angle", [86.0, 90.0])
def test_a_face_almost_upright_is(angle):
    with refused(fc.InputError, "not-facing", f" {180 - angle:.0f} degrees"):
        bottom_edge(angle)


def test_a_pin_in_its_bore_faces_it_all_round():
    """Source: geometry. Half round in a conforming bore, right up to where the load has no component."""
    pin = fc.ElasticBody(fc.shapes.thick_ring(0.3, 0.99, 0.5, (6, 2, 1), sector="full"), SOLID, "outer")
    lug = fc.ElasticBody(fc.shapes.thick_ring(1.0, 2.0, 0.5, (6, 2, 1), sector="full"), SOLID, "inner")
    for slave, master in ((pin, lug), (lug, pin)):
        relative = slave.pose.relative_to(master.pose)
        surfaces = (slave.surface(slave.contact[0]), master.surface(master.contact[0]))
        pairing = pair(SurfacePair(*surfaces, relative.rotation, relative.translation, share=0.5))
        assert pairing.n_beyond == 0
        assert len(pairing.nodes) == len(slave.surface(slave.contact[0]).nodes)


def test_the_far_side_of_a_ball_is_left_out_and_changes_no_force():
    """Source: the same ball with the face that looks at the floor only."""
    mesh = fc.shapes.sphere(1.0, contact_radius=0.2, level=1, element="hex8")
    below = mesh.faces("cap")
    whole = replace(mesh, boundaries={**mesh.boundaries, "skin": np.concatenate([below, mesh.faces("far_cap")])})
    forces = []
    for name in ("cap", "skin"):
        # both with the same faces: a boundary that goes on has its middles placed, too
        ball = fc.ElasticBody(whole, SOLID, name, {"far_cap": "xyz"}, geometry="plain")
        result = fc.Scene([ball, FLOOR], [fc.Contact(ball, FLOOR)]).solve(motions={ball: {"z": -0.02}})
        forces.append(result.contacts[0].force[2])
    assert forces[0] > 0
    assert abs(forces[1] / forces[0] - 1) < 1e-9
