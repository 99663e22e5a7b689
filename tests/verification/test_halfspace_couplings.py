"""A small elastic ball of finite elements on a half-space, beside two such balls and Hertz."""

import numpy as np
import pytest

import fecontact as fc

MATERIAL = fc.Material(E=1.0, nu=0.3)
RADIUS, FORCE = 10.0, 0.02
#: Its narrowest faces are as wide as the cells.
LEVEL = fc.shapes.Level(core=2, rings=3, edge=0.08, layer=0.2)


def figures(contact, hertz):
    r = np.linalg.norm(contact.points[:, :2], axis=1)
    exact = hertz.p0 * np.sqrt(np.maximum(1 - (r / hertz.a) ** 2, 0))
    difference = contact.weights @ (contact.pressure - exact) ** 2 / (contact.weights @ exact**2)
    return float(np.sqrt(difference)), contact.max_pressure / hertz.p0 - 1


def ball(a):
    mesh = fc.shapes.half_sphere(RADIUS, contact_radius=a, level=LEVEL)
    return fc.ElasticBody(mesh, MATERIAL, "cap", {"base": "xyz"}, name="ball")


# coupling, cells per side of a box 3a, most pressure L2, most error of the peak: 1.2 times what was found. Between
# finite elements, two balls of this fineness err by 1.9 % in L2. Cells that are the slave ring by 4 % when a face holds
# seven of them; spreading the faces' forces over the cells takes that away
@pytest.mark.by_day(every=4)
@pytest.mark.parametrize(
    ("coupling", "cells", "most_l2", "most_peak"),
    [("nodal", 32, 0.055, 0.05), ("mortar", 32, 0.05, 0.01), ("auto", 32, 0.05, 0.01), ("auto", 64, 0.025, 0.02)],
)
def test_ball_on_a_half_space(coupling, cells, most_l2, most_peak, row):
    """A ball of finite elements on a half-space of cells.

    Source: Hertz. 1.2 times what was found; between finite elements two balls of this fineness err by 1.9 % in L2.
    """
    hertz = fc.hertz.spheres((RADIUS, np.inf), (MATERIAL, MATERIAL), force=FORCE)
    half = fc.HalfSpace(MATERIAL, size=(3 * hertz.a, 3 * hertz.a), cells=(cells, cells))
    body = ball(hertz.a)
    result = fc.Scene([half, body], [fc.Contact(half, body, coupling=coupling)]).solve(forces={body: [0, 0, -FORCE]})
    (contact,) = result.contacts
    l2, peak = figures(contact, hertz)
    case = f"FE ball on a half-space, {cells} cells, {coupling}"
    row(case, "pressure L2", 0.0, l2, most_l2, result.n_dofs)
    row(case, "peak, relative error", 0.0, peak, most_peak, result.n_dofs)
    assert abs(np.abs(contact.force[2]) / FORCE - 1) < 1e-9
    # forces spread over cells keep their moment: the other side's resultant is its opposite
    assert np.abs(contact.moment).max() < 1e-6 * FORCE * RADIUS
    assert result.residuals().worst < 1e-8


@pytest.mark.full
def test_two_balls_of_the_same_fineness(row):
    """Two balls of finite elements, as fine as the ball on cells.

    Source: Hertz. Twice what was found.
    """
    hertz = fc.hertz.spheres((RADIUS, RADIUS), (MATERIAL, MATERIAL), force=FORCE)
    lower = ball(hertz.a)
    upper = lower.placed(name="upper")
    lower = lower.placed(rotation=fc.rotation_about((1, 0, 0), np.pi), name="lower")
    result = fc.Scene([lower, upper], [fc.Contact(lower, upper)]).solve(forces={upper: [0, 0, -FORCE]})
    l2, peak = figures(result.contacts[0], hertz)
    row("two FE balls", "pressure L2", 0.0, l2, 0.035, result.n_dofs)
    row("two FE balls", "peak, relative error", 0.0, peak, 0.02, result.n_dofs)
