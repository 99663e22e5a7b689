"""Oblique supports: a turned model is the unturned one, and a wedge between skew planes is the whole ring."""

import numpy as np
import pytest

import fecontact as fc

STEEL = fc.Material(E=200.0, nu=0.3, density=1.0)
TURN = fc.rotation_about((1.0, 2.0, 0.5), np.radians(30))
# two factorisations of matrices with condition numbers of some 1e5
ROUNDING = 1e-9


def along(axes, direction):
    return tuple(axes @ np.asarray(direction, dtype=float))


def pressed(mesh, supports, axes):
    """A block on a rigid floor, pushed from the side; everything turned by `axes` within its own coordinates."""
    body = fc.ElasticBody(mesh.mapped(lambda x: x @ axes.T), STEEL, "bottom", supports, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor").placed(rotation=axes)
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    return body, scene.solve(
        forces={(body, "x_max"): axes @ [-0.3, 0.1, -0.2]},
        pressures={(body, "top"): 0.5},
        gravity=axes @ [0.0, 0.2, -1.0],
    )


@pytest.mark.parametrize("planes", ["directions", "normals"])
def test_a_turned_model_is_the_unturned_one(planes, row):
    """Oblique supports: a turned block on a turned floor is the unturned one.

    Source: the model that is not turned. Two factorisations of matrices with condition numbers of some 1e5.
    """
    mesh = fc.shapes.block((1.0, 1.2, 0.9), (3, 2, 2))
    straight, plain = pressed(mesh, {"x_min": "xy", "y_min": "y"}, np.eye(3))
    x, y = along(TURN, (1, 0, 0)), along(TURN, (0, 1, 0))
    oblique = {"x_min": [x, y], "y_min": y if planes == "directions" else "n"}
    turned, result = pressed(mesh, oblique, TURN)
    case = f"supports by {planes}, model turned by 30 degrees"
    pressure = np.abs(result.contacts[0].pressure - plain.contacts[0].pressure).max() / plain.contacts[0].max_pressure
    row(case, "largest pressure difference", 0.0, pressure, within=ROUNDING)
    u, expected = result.displacement(turned), plain.displacement(straight) @ TURN.T
    row(
        case,
        "largest displacement difference",
        0.0,
        np.abs(u - expected).max() / np.abs(expected).max(),
        within=ROUNDING,
    )
    for name in straight.supports:
        here = result.reaction(turned, name).reshape(2, 3)
        there = plain.reaction(straight, name).reshape(2, 3) @ TURN.T
        row(case, f"reaction of {name}", 0.0, np.abs(here - there).max() / np.abs(there).max(), within=ROUNDING)


def lame(r, a, b, p):
    """Radial displacement of a thick cylinder under pressure p inside, in plane strain (Timoshenko & Goodier, sec. 28).

    u = (1 + nu)/E p a^2/(b^2 - a^2) ((1 - 2 nu) r + b^2/r).
    """
    nu = STEEL.nu
    return (1 + nu) / STEEL.E * p * a**2 / (b**2 - a**2) * ((1 - 2 * nu) * r + b**2 / r)


def wedge(degrees, n, inner, outer, contact=()):
    """Sector of a ring from 0 to so many degrees."""
    mesh = fc.shapes.thick_ring(inner, outer, 0.3, (n, 4, 1))

    def bent(x):
        r, angle = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0]) * degrees / 90
        return np.stack([r * np.cos(angle), r * np.sin(angle), x[:, 2]], axis=1)

    supports = {"sym_x": "n", "sym_y": "n", "bottom": "z", "top": "n"}
    return fc.ElasticBody(mesh.mapped(bent), STEEL, contact, supports, name="wedge")


def test_wedge_between_skew_planes_is_the_whole_ring(row):
    """A sector of 36 degrees of a thick cylinder between skew planes.

    Source: Lame (Timoshenko and Goodier, section 28). Four quadratic elements through the wall: 1e-4 of the
    displacement, a factor of ten above it is allowed.
    """
    a, b, p = 1.0, 2.0, 3.0
    body = wedge(36.0, 4, a, b, "outer")
    # a rigid wall beyond its reach: the scene needs a contact
    wall = fc.RigidBody(fc.Plane()).placed((3.0, 0, 0), fc.rotation_about((0, 1, 0), -np.pi / 2))
    result = fc.Scene([body, wall], [fc.Contact(body, wall)]).solve(pressures={(body, "inner"): p})
    u = result.displacement(body)
    r = np.hypot(*body.mesh.points[:, :2].T)
    radial = np.einsum("ni,ni->n", u[:, :2], body.mesh.points[:, :2]) / r
    # 4 quadratic elements through the wall: 1e-4 of the displacement
    error = np.abs(radial / lame(r, a, b, p) - 1).max()
    row("wedge of 36 degrees, skew symmetry", "largest error against Lame", 0.0, error, within=1e-3, dofs=body.n_dofs)
    # what a plane of symmetry carries: the hoop force p a t
    hoop = result.reaction(body, "sym_x")[:3] @ [-np.sin(np.radians(36)), np.cos(np.radians(36)), 0]
    row("wedge of 36 degrees, skew symmetry", "hoop force on the skew plane", p * a * 0.3, abs(hoop), within=1e-3)


def test_shrink_fit_of_wedges_is_that_of_rings(row):
    """Shrink fit of two sectors of 36 degrees.

    Source: Lame, plane strain (Timoshenko and Goodier, equation 47). The interference of half a percent is taken at the
    mean radius, hence one percent.
    """
    inner, outer = wedge(36.0, 4, 1.0, 2.0, "outer"), wedge(36.0, 4, 1.99, 3.0, "inner")
    result = fc.Scene([inner, outer], [fc.Contact(inner, outer)]).solve()
    # plane strain, one material: p = E d / (2 (1 - nu^2) b^3) (b^2 - a^2)(c^2 - b^2)/(c^2 - a^2), Timoshenko eq. 47;
    # the interference of half a percent is taken at the mean radius
    a, b, c, d = 1.0, 1.995, 3.0, 0.01
    plane = STEEL.E / (1 - STEEL.nu**2)
    p = plane * d / b * (b**2 - a**2) * (c**2 - b**2) / (2 * b**2 * (c**2 - a**2))
    contact = result.contacts[0]
    middle = float(contact.total_force / contact.weights.sum())
    row("shrink fit of wedges of 36 degrees", "mean pressure", p, middle, within=0.01)
    assert contact.active.all()
    assert abs(result.residuals().equilibrium) < 1e-10
