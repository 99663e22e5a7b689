"""Thin layers as the ready meshes cut them: a rigid ball on a layer bonded to a rigid base."""

import math

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic.layer import paraboloid

UPSIDE_DOWN = fc.rotation_about((1, 0, 0), math.pi)
#: p0 R / (E* a) of the table of the thin bonded layer (Lebedev & Ufliand 1958), by a/b and Poisson's ratio.
TABLE = {(2.0, 0.3): 1.37248}


def pressed(body, ball, force):
    """Pressure at the centre under a force on the ball."""
    contact = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(forces={ball: (0, 0, force)}).contacts[0]
    points, pressure, _ = contact.sampled(contact.pressure, 12)
    return pressure[np.argmin(np.hypot(points[:, 0], points[:, 1]))]


def layer_under_a_ball(ratio, nu):
    """Closed form of a contact `ratio` times as wide as the layer is thick, and the ball that stands for it.

    Its radius is 1000 a, so that the ball is a paraboloid to (a/R)^2/4, a quarter of a millionth.
    """
    material = fc.Material(E=1.0, nu=nu)
    exact = paraboloid(radius=1000 * ratio, thickness=1.0, material=material, a=ratio)
    if (ratio, nu) in TABLE:
        assert abs(exact.p0 * exact.R / (exact.E_star * exact.a) - TABLE[ratio, nu]) < 1e-5
    return material, exact, fc.RigidBody(fc.Sphere(exact.R)).placed(rotation=UPSIDE_DOWN)


@pytest.mark.by_day(every=4)
@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
@pytest.mark.parametrize("nu", [0.3, 0.49, 0.499])
@pytest.mark.parametrize("element", ["quad8", "quad9"])
def test_section_of_a_thin_bonded_layer(ratio, nu, element, row):
    """Ready section of a thin bonded layer under a rigid ball, default level.

    Source: the integral equation of Lebedev & Ufliand (VERIFICATION 10). One percent was asked for; 0.6 % is the most
    that was found, by the nodes next to the axis. With one or two cells through the depth it was up to 46 %.
    """
    material, exact, ball = layer_under_a_ball(ratio, nu)
    mesh = fc.sections.cap(math.inf, ratio + 8, 1.0, contact_radius=ratio, element=element)
    body = fc.AxisymmetricBody(mesh, material, "cap", {"base": "xz"})
    found = pressed(body, ball, exact.force)
    row(
        f"10 layer, {element}, a/b {ratio:g}, nu {nu}", "pressure at the centre", exact.p0, found, 0.01, body.n_unknowns
    )


@pytest.mark.by_day("1.0-0.49")
@pytest.mark.parametrize(("ratio", "nu"), [(1.0, 0.49), (5.0, 0.499)])
def test_quarter_of_a_thin_bonded_layer(ratio, nu, row):
    """Ready quarter of a thin bonded layer in space, default level; source and bound as for the section."""
    material, exact, ball = layer_under_a_ball(ratio, nu)
    mesh = fc.shapes.cap(math.inf, ratio + 5, 1.0, contact_radius=ratio, sector="quarter")
    body = fc.ElasticBody(mesh, material, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"})
    found = pressed(body, ball, exact.force / 4)
    row(f"10 layer in space, a/b {ratio:g}, nu {nu}", "pressure at the centre", exact.p0, found, 0.01, body.n_dofs)
