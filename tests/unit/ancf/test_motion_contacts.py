"""Contacts of motions in time as results, and the residuals of their steps, against statics and closed forms."""

from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, EnergyMomentum, GeneralisedAlpha, Stage, equilibrium, move
from fecontact.ancf.slender import line, straight
from fecontact.ancf.system.slip import initial_friction, slips

MU, G, MASS = 0.4, 10.0, 0.5
SCHEMES = pytest.mark.parametrize("scheme", [GeneralisedAlpha(), EnergyMomentum()], ids=["alpha", "energy"])


def block(supports=None):
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (1, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.0, density=1.0), points=3)
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return Assembly.of([solid], [supports or {}], [fc.Contact(solid.side("bottom"), floor, friction=MU)])


def resting(a, pull):
    weight = a.gravity(np.asarray(pull))
    return equilibrium(lambda s: Stage(a, forces=s * weight), steps=1).last


@SCHEMES
def test_a_block_that_slides_presses_and_drags_as_coulomb_has_it(scheme):
    """Source: the rigid block. It swings by the deceleration."""
    a = block()
    at_rest = resting(a, (0.0, 0.0, -G))
    motion = move(a, until=0.05, step=0.0125, scheme=scheme, start=at_rest, velocity=(1.0, 0, 0), gravity=(0, 0, -G))
    assert motion.success
    (contact,) = motion.contacts
    # what the last step has pressed and dragged, by another way: sums of the conditions' gradients
    assert np.abs(contact.force - motion.contact_force[-1, 0]).max() < 1e-12
    assert contact.friction is not None
    assert set(contact.friction.state) <= {"slip", "open"}
    assert abs(contact.friction.force[0] + MU * contact.total_force) < 1e-9
    assert np.abs(contact.pressure @ contact.weights - contact.total_force) < 1e-12
    slid = (1.0 - MU * G * 0.04375) * 0.0125  # by its speed in the middle of the step
    assert np.abs(contact.friction.slip[contact.forces > 0] - [slid, 0.0, 0.0]).max() < 0.1 * slid
    assert motion.residuals.slip is not None
    assert motion.residuals.worst < 1e-8
    assert f"largest {motion.residuals.worst:.1e}" in str(motion)


@SCHEMES
def test_a_block_at_rest_has_the_contact_of_statics(scheme):
    a = block()
    at_rest = resting(a, (0.2 * G, 0.0, -G))
    motion = move(a, until=0.02, step=0.01, scheme=scheme, start=at_rest, gravity=(0.2 * G, 0, -G))
    (still,), (contact,) = at_rest.contacts, motion.contacts
    forces = motion.contact_force[-2:, 0].mean(axis=0)
    assert np.abs(forces - still.force).max() < 1e-6 * MASS * G
    assert abs(contact.point_area - still.point_area) < 1e-9
    assert motion.residuals.worst < 1e-8


def test_residuals_see_a_force_that_is_not_coulombs():
    """What a motion reports would be large for other forces: turned round, above the cone, or where a gap is open."""
    a = block()
    start = initial_friction(a.constraints, a.q0).start
    q = a.q0 + a.translation(np.array([0.01, 0.0, 0.0]))
    slip = slips(a.constraints, a.conditions(q).parts, q, start)
    normal, gap = np.full(a.n_multipliers, 0.5), np.zeros(a.n_multipliers)
    drag = -MU * 0.5 * slip.slip / 0.01
    right = slip.residuals(gap, normal, drag, a.size, 0.0)
    assert right.worst < 1e-12
    assert slip.residuals(gap, normal, -drag, a.size, 0.0).dissipation == pytest.approx(2.0)
    assert slip.residuals(gap, normal, 1.5 * drag, a.size, 0.0).cone == pytest.approx(0.5 * MU)
    assert slip.residuals(gap + 0.1, normal, drag, a.size, 0.0).complementarity == pytest.approx(0.1 / a.size)
    shifted = replace(slip, slip=slip.slip + 0.01)
    assert shifted.residuals(gap, normal, drag, a.size, 0.0).slip > 1e-3


def test_a_motion_without_friction_has_four_residuals_and_one_resumed_the_same_contacts(tmp_path):
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (1, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.0, density=1.0), points=3)
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), fc.RigidBody(fc.Plane()))])
    given = {"step": 0.004, "gravity": (0, 0, -G), "velocity": (0, 0, -0.1), "every": 1}
    whole = move(a, until=0.02, **given)
    assert whole.residuals.as_dict().keys() == {"penetration", "tension", "complementarity", "equilibrium"}
    file = tmp_path / "run.npz"
    move(a, until=0.012, path=file, **given)
    resumed = move(a, until=0.02, path=file, **given)
    assert np.abs(resumed.time - whole.time).max() < 1e-15
    assert np.abs(resumed.step_residuals - whole.step_residuals).max() < 1e-11
    assert np.abs(resumed.contacts[0].forces - whole.contacts[0].forces).max() < 1e-11
    assert whole.contacts[0].total_force > 0
    assert whole.save(tmp_path / "points.csv").exists()


@SCHEMES
def test_a_cable_that_lies_on_a_floor_presses_by_its_weight_per_length(scheme):
    """Source: statics. Above the floor it presses nothing."""
    for height, pressed in ((0.1, 1.0), (0.11, 0.0)):
        cable = line(straight((0, 0, height), (1, 0, height), 4), EA=100.0, EI=0.1, mass=1.0)
        a = Assembly([cable], [], [fc.Contact(cable.side(0.1), fc.RigidBody(fc.Plane()))])
        motion = move(a, until=0.02, step=0.01, scheme=scheme, gravity=(0, 0, -1.0))
        (contact,) = motion.contacts
        assert np.abs(contact.force - [0.0, 0.0, pressed]).max() < 1e-9
        assert np.abs(contact.pressure - pressed).max() < 1e-9
