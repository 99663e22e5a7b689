"""Contacts of a state as results: pressure per present area, area, resultants, friction, outline, files."""

import csv

import numpy as np
import pytest
from scipy.optimize import brentq

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Stage, equilibrium
from fecontact.ancf.slender import Joints, line, plate, straight

UP = np.array([0.0, 0.0, 1.0])


def solid(size, divisions, material, at=(0.0, 0.0, 0.0), **options):
    mesh = fc.shapes.block(size, divisions, element="hex8").translated(at)
    return AncfSolid(AncfSpace(mesh), material, **options)


def squeezed(stretch):
    """A neo-Hookean block between smooth plates, free at the sides, with one Poisson ratio that widens it."""
    block = solid((1.0, 1.0, 1.0), (2, 2, 1), fc.NeoHookean(E=1.0, nu=0.3), points=3)
    press = fc.RigidBody(fc.Plane())
    a = Assembly.of([block], [{"top": "z", "x_min": "x", "y_min": "y"}], [fc.Contact(block.side("bottom"), press)])
    return equilibrium(lambda s: Stage(a.with_rigid(press.placed((0, 0, (1 - stretch) * s)))), steps=3).last


def test_pressure_is_force_per_present_area_and_cauchys():
    """W = mu (tr C - 3 - 2 ln J) / 2 + lambda ln(J)^2 / 2; the sides carry nothing (Bonet & Wood 2008, section 6.4)."""
    stretch, mu, lame = 0.7, 1 / 2.6, 0.3 / (1.3 * 0.4)
    wide = brentq(lambda w: mu * (w**2 - 1) + lame * np.log(w**2 * stretch), 1.0, 2.0, xtol=1e-15)
    J = wide**2 * stretch
    cauchy = (mu * (stretch**2 - 1) + lame * np.log(J)) / J
    (contact,) = squeezed(stretch).contacts
    assert wide > 1.1  # so that present and initial areas differ by a fifth
    assert np.abs(contact.pressure + cauchy).max() < 1e-9  # Newton's tolerance
    assert abs(contact.point_area - wide**2) < 1e-9
    assert abs(contact._whole.area - wide**2) < 1e-9
    assert np.abs(contact.force - [0.0, 0.0, -cauchy * wide**2]).max() < 1e-9
    assert np.abs(contact.centre_of_pressure - [wide / 2, wide / 2, 1 - stretch]).max() < 1e-9
    assert contact.regions[0].max_pressure == contact.max_pressure


def test_bricks_and_the_linear_body_have_one_multiplier_basis():
    """A flat sphere pressed in by little: the same pressure at every corner and side, but for strains of 1e-4."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (3, 3, 1), element="hex8").translated((-0.5, -0.5, -0.5))
    material, depth = fc.Material(E=1.0, nu=0.3), 5e-5
    ball = fc.RigidBody(fc.Sphere(1e4))
    body = fc.AncfBody(mesh, material, contact="top", supports={"bottom": "xyz"})
    linear = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -depth}}).contacts[0]
    solid = AncfSolid(AncfSpace(mesh), material)
    a = Assembly.of([solid], [{"bottom": "xyz"}], [fc.Contact(solid.side("top"), ball)])
    (found,) = equilibrium(lambda s: Stage(a.with_rigid(ball.placed((0, 0, -depth * s)))), steps=1).last.contacts
    order, other = (np.lexsort(np.round(c.points, 4).T) for c in (found, linear))
    assert len(order) == len(other) == 16 + 24
    assert np.abs(found.weights[order] - linear.weights[other]).max() < 1e-4 * linear.weights.max()
    assert np.abs(found.pressure[order] - linear.pressure[other]).max() < 1e-3 * found.max_pressure
    assert found.max_pressure > 5e-5  # of the order of E depth / height


def test_friction_of_a_state_is_that_of_a_result():
    block = solid((1.0, 1.0, 0.5), (2, 2, 1), fc.Material(E=1e3, nu=0.3, density=1.0), points=3)
    a = Assembly.of([block], None, [fc.Contact(block.side("bottom"), fc.RigidBody(fc.Plane()), friction=0.4)])
    weight = a.gravity(9.81 * np.array([np.sin(0.3), 0.0, -np.cos(0.3)]))
    state = equilibrium(lambda s: Stage(a, forces=s * weight), steps=1).last
    (contact,) = state.contacts
    assert contact.friction is not None
    assert np.abs(contact.friction.force - state.friction.forces[0].sum(axis=0)).max() < 1e-14
    assert abs(contact.friction.force[0] + 0.5 * 9.81 * np.sin(0.3)) < 1e-7
    assert np.abs(contact.force[2] - 0.5 * 9.81 * np.cos(0.3)) < 1e-7
    assert set(contact.friction.state) <= {"stick", "slip"}  # all of it carries weight


def test_outline_map_and_table_of_a_ball_in_a_block(tmp_path):
    block = solid((2.0, 2.0, 1.0), (8, 8, 1), fc.Material(E=1.0, nu=0.3), at=(-1.0, -1.0, -1.0), points=3)
    ball = fc.RigidBody(fc.Sphere(2.0))
    a = Assembly.of([block], [{"bottom": "xyz"}], [fc.Contact(block.side("top"), ball)])
    state = equilibrium(lambda s: Stage(a.with_rigid(ball.placed((0, 0, -0.15 * s)))), steps=1).last
    (contact,) = state.contacts
    circle = contact.outline.curves[0]
    radius = np.linalg.norm(circle.points[:, :2], axis=1)
    assert np.ptp(radius) < 0.08 * radius.mean()  # three or four faces across the contact
    # what touches lies on the ball: a cap within the outline
    cap = (
        2
        * np.pi
        * 2.0
        * (circle.points[:, 2].mean() - circle.points[:, 2].min() + 2.0 - np.sqrt(4 - radius.mean() ** 2))
    )
    assert abs(contact._whole.area / cap - 1) < 0.05
    state.plot(path=tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 0
    with state.save(tmp_path / "points.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert abs(sum(float(row["force"]) for row in rows) - contact.total_force) < 1e-12


def test_members_have_forces_per_present_length_and_no_map():
    """A cable that rests on a floor, drawn out by a tenth: its weight per present length."""
    cable = line(straight((0, 0, 0.1), (1, 0, 0.1), 4), EA=100.0, EI=1e-3)
    joints, floor = Joints([cable]), fc.RigidBody(fc.Plane())
    conditions = [joints.pinned((0, 0)), joints.pinned((0, 4))]
    flat = [joints.pinned((0, k), [(0, 1, 0)]) for k in (1, 2, 3)]
    every = [*conditions, *flat, *(joints.guided((0, k), 1, [(0, 1, 0)]) for k in range(5))]
    a = Assembly([cable], every, [fc.Contact(cable.side(0.1), floor)])
    out = joints.motion(conditions, [None, (0.1, 0.0, 0.0)])
    down = np.zeros((cable.n_dofs // 3, 3))
    down[::2, 2] = [-0.125, -0.25, -0.25, -0.25, -0.125]
    state = equilibrium(lambda s: Stage(a, forces=s * down.ravel(), motion=s * out), steps=1).last
    (contact,) = state.contacts
    assert abs(contact.area - 1.1) < 1e-5  # between nodes it sags by the weight, 2e-6 longer
    assert abs(contact.force[2] + state.reactions @ a.translation(UP) - 1.0) < 1e-9
    assert contact.force[2] > 0.7  # the ends hold their own nodes
    assert abs(contact.pressure @ contact.weights - contact.total_force) < 1e-14
    with pytest.raises(fc.InputError, match="no contact of faces"):
        state.plot()


def test_areas_of_a_plate_are_present_ones():
    sheet = plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (2, 2), fc.Material(E=1.0, nu=0.0), 0.1)
    contact = sheet.side(0.05)
    stretched = sheet.q0.reshape(-1, 3) * [1.3, 0.9, 1.0]
    assert np.abs(contact.present_areas(stretched.ravel()) - 0.25 * 1.3 * 0.9).max() < 1e-14


def test_the_former_name_of_an_assemblys_contacts_warns():
    a = Assembly.of([solid((1.0, 1.0, 1.0), (1, 1, 1), fc.Material(E=1.0, nu=0.3))])
    with pytest.warns(DeprecationWarning, match="touches is now constraints"):
        assert a.touches == a.constraints
