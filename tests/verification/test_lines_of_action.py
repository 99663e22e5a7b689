"""One line of action between both normals, weighted by compliance (VERIFICATION 1, 12).

Mirror images press on each other as one of them does on the plane between them, and a body of a modulus 1e6 times as
high is rigid, whichever side is the slave.
"""

import numpy as np
import pytest

import fecontact as fc

pytestmark = pytest.mark.rounding(0)

RADIUS = 25.0
STEEL = fc.Material(E=2.0e6, nu=0.3)
PLANE = fc.RigidBody(fc.Plane())
#: What the issue asks for; nodal coupling and sections hold it to rounding.
SAME = 1e-6


def quarter(a, element):
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=a, level=1, element=element)
    return fc.ElasticBody(mesh, STEEL, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"}, name="ball")


def section(a, element):
    mesh = fc.sections.half_disc(RADIUS, contact_radius=a, level=1, element=element)
    return fc.AxisymmetricBody(mesh, STEEL, "cap", {"base": "xz"}, name="ball")


def pressed(body, other, motion, coupling):
    """Pressure of the contact at the body's nodes and the result, the body moved down."""
    contact = fc.Contact(body, other, coupling=coupling)
    result = fc.Scene([body, other], [contact]).solve(motions={body: {"z": -motion}})
    assert result._interfaces[0].slave.name == body.name
    pressure = np.zeros(len(body.surface("cap").points))
    pressure[result._interfaces[0].pairing.nodes] = result.contacts[0].pressure
    return pressure, result


@pytest.mark.by_day("hex8-auto-1e-10-0.1", "hex20-mortar-1e-05-0.2", "quad8-auto-1e-10-0.1")
@pytest.mark.parametrize("ratio", [0.1, 0.2])
@pytest.mark.parametrize(
    ("element", "coupling", "within"),
    [
        ("hex20", "auto", 1e-10),
        ("hex8", "auto", 1e-10),
        # against the plane whole faces are sampled, against the image pieces of them, by rules of degree six both: they
        # differ by 6e-6 where the pressure drops to zero; by rules of degree 14 they agree to 1e-11
        ("hex20", "mortar", 1e-5),
        ("hex8", "mortar", 1e-5),
        ("quad8", "auto", 1e-10),
    ],
)
def test_mirror_images_are_one_body_on_the_plane_between_them(ratio, element, coupling, within, row):
    """Two equal spheres against one on a rigid plane, the same mesh.

    Source: symmetry; the line of action is the mean of both normals, which is the plane's. Rounding where both are
    integrated by one rule; the force 1e-6 in any case.
    """
    a = ratio * RADIUS
    ring = element == "quad8"
    body = section(a, element) if ring else quarter(a, element)
    image = body.placed(rotation=fc.rotation_about((1, 0, 0) if ring else (1, 1, 0), np.pi), name="image")
    motion = a**2 / (2 * RADIUS)
    one, alone = pressed(body, PLANE, motion, "mortar" if ring else coupling)
    two, both = pressed(body, image, 2 * motion, coupling)
    case = f"1 mirror images, {element}, {both.contacts[0].coupling}, a/R = {ratio:g}"
    row(case, "largest change of pressure / peak", 0.0, np.abs(one - two).max() / one.max(), within, both.n_dofs)
    row(case, "force", alone.contacts[0].force[2], both.contacts[0].force[2], min(within, SAME), both.n_dofs)
    assert np.abs(both.contacts[0].force[:2]).max() < 1e-12 * both.contacts[0].force[2]
    assert both.residuals().equilibrium < 1e-13


FORCE = 4 / 3 * STEEL.plane_strain_modulus * (0.2 * RADIUS) ** 3 / RADIUS / 4


def on_block(contrast, slave, coupling="mortar"):
    """A quarter ball pressed on a block of higher modulus, or on a rigid plane: peak pressure and approach."""
    a = 0.2 * RADIUS
    ball = quarter(a, "hex20")
    block = PLANE
    if contrast is not None:
        mesh = fc.shapes.block((1.6 * a, 1.6 * a, a), (3, 3, 2)).translated((0, 0, -a))
        material = fc.Material(contrast * STEEL.E, STEEL.nu)
        block = fc.ElasticBody(mesh, material, "top", {"bottom": "z", "x_min": "x", "y_min": "y"}, name="block")
    pair = (block, ball) if slave == "block" else (ball, block)
    contact = fc.Contact(*pair, coupling=coupling, swap="never")
    result = fc.Scene([ball, block], [contact]).solve(forces={ball: (0, 0, -FORCE)})
    assert result._interfaces[0].slave.name == slave
    assert result.residuals().equilibrium < 1e-12
    return result.contacts[0].max_pressure, -result.rigid_motion(ball).translation[2]


@pytest.mark.parametrize("coupling", ["nodal", "mortar"])
def test_a_much_stiffer_master_is_rigid(coupling, row):
    """A ball on a block of a modulus 1e6 times as high, against the same ball on a rigid plane.

    Source: the limit. 1e-6: the block gives 1e-6 of what the ball gives.
    """
    peak, approach = on_block(None, "ball", coupling)
    found = on_block(1e6, "ball", coupling)
    case = f"12 ball on a block 1e6 times stiffer, {coupling}"
    row(case, "peak pressure", peak, found[0], SAME)
    row(case, "approach", approach, found[1], SAME)


def test_a_much_stiffer_slave_is_rigid(row):
    """The block as the slave: its normal rules, as the plane's does, though its own faces carry the pressure.

    Source: the limit of the same pairs, from 1e6 to 1e9; and the ball on a rigid plane. Another discretisation of the
    same contact (the pressure lives on the block's faces, of half a contact radius), so 2e-3 of the approach; with the
    master's normal it was 8e-3.
    """
    _, rigid = on_block(None, "ball")
    stiff, stiffer = on_block(1e6, "block"), on_block(1e9, "block")
    case = "12 block 1e6 times stiffer as the slave of a ball"
    row(case, "peak pressure, against 1e9", stiffer[0], stiff[0], SAME)
    row(case, "approach, against 1e9", stiffer[1], stiff[1], SAME)
    row(case, "approach, against a rigid plane", rigid, stiff[1], 2e-3)
    row(case, "approach, against the ball as the slave", on_block(1e6, "ball")[1], stiff[1], 2e-3)
