"""Local bodies with curved windows: relief, effect of slopes, axes, refusals."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.bodies.local.window import fit
from fecontact.mesh.shapes import Level

SOLID = fc.Material(E=2.0, nu=0.0)
RADIUS, FORCE = 10.0, 1.0
COARSE = Level(1, 1, 0.9, 0.8, 2.5)
TURN = fc.rotation_about((1, 2, 3), 0.7)


def half_ball(turn=None, mesh=None, **options):
    """A clamped half-sphere that stands on its pole, and its pole; as a whole turned."""
    mesh = fc.shapes.half_sphere(RADIUS, contact_radius=2.0, level=COARSE) if mesh is None else mesh
    ball = fc.RigidBody(fc.Sphere(RADIUS))
    if turn is not None:
        mesh, ball = mesh.drawn_at(mesh.points @ turn.T), ball.placed(rotation=turn)
    given = {"contact": "cap", "geometry": ball, "supports": {"base": "xyz"}, "name": "ball", **options}
    return fc.ElasticBody(mesh, SOLID, **given)


def on_a_plane(local, force=FORCE, turn=None):
    """Pressed on a plane through its pole, which lies at the origin."""
    floor = fc.RigidBody(fc.Plane()).placed(rotation=turn)
    down = np.array([0.0, 0.0, -force]) if turn is None else turn @ [0.0, 0.0, -force]
    result = fc.Scene([local, floor], [fc.Contact(local, floor)]).solve(forces={local: down}, finite_motion=False)
    return float(np.linalg.norm(result.rigid_motion(local).translation)), result.contacts[0]


def test_a_relief_has_the_curvature_of_its_ball() -> None:
    ball = fit(lambda x, y: 10 - np.sqrt(100 - x**2 - y**2), np.array([2.0, 2.0]), (False, False))
    x, y = np.array([0.0, 1.0, -1.5]), np.array([0.0, 0.5, 1.0])
    n = np.stack([x, y, np.sqrt(100 - x**2 - y**2)], axis=1) / 10
    exact = (np.eye(3) - n[:, :, None] * n[:, None, :]) / 10
    assert np.abs(ball.curvature(x, y) - exact).max() < 1e-7
    assert ball.misfit < 1e-7


def test_a_relief_leaves_out_what_is_not_there() -> None:
    cut = fit(lambda x, y: np.where(x > 1.2, np.nan, x**2 / 20), np.array([1.0, 1.0]), (False, False))
    assert np.allclose(cut.depth(np.array([0.5]), np.array([0.7])), 0.0125)


@pytest.mark.full
def test_planes_of_symmetry_and_axes_do_not_matter() -> None:
    """A quarter, a whole, and a whole in axes askew: the same ball, the first two on the same mesh."""
    quarter = fc.shapes.quarter_sphere(RADIUS, contact_radius=2.0, level=COARSE)
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    part = fc.LocalBody(half_ball(mesh=quarter, supports=supports), (0, 0, 0), 3.8, (32, 32))
    whole = fc.LocalBody(half_ball(), (0, 0, 0), 3.8, (32, 32))
    askew = fc.LocalBody(half_ball(TURN), (0, 0, 0), 3.8, (32, 32))
    one, contact = on_a_plane(part, FORCE / 4)
    two, other = on_a_plane(whole)
    three, third = on_a_plane(askew, turn=TURN)
    assert part.window.mirrored == (True, True)
    assert abs(two / one - 1) < 1e-4
    assert abs(three / two - 1) < 1e-4
    assert other.max_pressure == pytest.approx(contact.max_pressure, rel=1e-3)
    assert third.max_pressure == pytest.approx(contact.max_pressure, rel=1e-3)
    hertz = fc.hertz.spheres((RADIUS, np.inf), (SOLID, fc.Material(1e9, 0.0)), force=FORCE)
    assert abs(two / hertz.approach - 1) < 0.05


def test_the_rim_is_told_where_the_window_ends_and_not_on_planes_of_symmetry() -> None:
    quarter = fc.shapes.quarter_sphere(RADIUS, contact_radius=2.0, level=COARSE)
    body = half_ball(mesh=quarter, supports={"base": "xyz", "sym_x": "x", "sym_y": "y"})
    floor = fc.RigidBody(fc.Plane())
    for side, warned in ((3.8, False), (2.4, True)):
        local = fc.LocalBody(body, (0, 0, 0), side, (32, 32))
        result = fc.Scene([local, floor], [fc.Contact(local, floor)]).solve(
            forces={local: (0, 0, -FORCE / 4)}, finite_motion=False
        )
        assert any("the rim of 'window'" in text for text in result.warnings) == warned


def test_the_middle_of_a_window_is_put_on_the_surface() -> None:
    local = fc.LocalBody(half_ball(), (0.0, 0.0, 0.01), 2.4, (16, 16))
    assert np.abs(local.window.origin).max() < 1e-9
    # the cells lie on the ball
    assert np.abs(np.linalg.norm(local.window.cells - [0, 0, RADIUS], axis=1) - RADIUS).max() < 1e-9


def test_a_window_too_steep_or_with_kinks_is_refused() -> None:
    with refused(fc.InputError, "surface-too-steep"):
        fc.LocalBody(half_ball(), (0, 0, 0), 8.0, (16, 16))
    flat = fc.shapes.half_sphere(RADIUS, contact_radius=2.0, level=COARSE, element="hex8")
    with refused(fc.InputError, "surface-has-kinks"):
        fc.LocalBody(half_ball(mesh=flat, geometry="plain"), (0, 0, 0), 2.4, (16, 16))
