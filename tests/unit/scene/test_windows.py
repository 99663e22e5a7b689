"""Windows of local bodies that the scene places: where, how large, what is refused; local bodies that float."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.mesh.shapes import Level

SOLID = fc.Material(E=2.0, nu=0.3)
COARSE = Level(1, 1, 0.9, 0.8, 2.5)


def block(**options):
    return fc.ElasticBody(
        fc.shapes.block((8.0, 8.0, 4.0), (6, 6, 4)), SOLID, supports={"bottom": "xyz"}, name="block", **options
    )


def ball(radius=3.0, at=(3.3, 4.2, 4.0)):
    return fc.RigidBody(fc.Sphere(radius), pose=fc.Pose(translation=at), name="ball")


def pressed(local, other, force=0.1, **options):
    scene = fc.Scene([local, other], [fc.Contact(local, other)])
    return scene.solve(**({"forces": {other: (0, 0, -force)}} | options))


@pytest.mark.by_day("0.5")
@pytest.mark.parametrize("gap", [0.0, 0.5])
def test_the_window_is_where_the_bodies_touch_and_fits_the_contact(gap: float) -> None:
    local, other = fc.LocalBody(block(), cells=(32, 32)), ball(at=(3.3, 4.2, 4.0 + gap))
    result = pressed(local, other)
    placed = result.solved(local)
    assert np.abs(placed.window.origin - [3.3, 4.2, 4.0]).max() < 1e-6
    hertz = fc.hertz.spheres((3.0, np.inf), (SOLID, fc.Material(1e9, 0.0)), force=0.1)
    assert 2.0 < placed.window.grid.size[0] / hertz.a < 2.6
    assert not local.is_placed
    given = fc.LocalBody(block(), (3.3, 4.2, 4.0), placed.window.grid.size, (32, 32))
    again = pressed(given, other, finite_motion=False)
    assert again.contacts[0].max_pressure == pytest.approx(result.contacts[0].max_pressure, rel=1e-6)


def test_an_ellipse_gets_a_window_of_two_sides() -> None:
    other = fc.RigidBody(fc.surfaces.Ellipsoid((9.0, 3.0, 3.0)), pose=fc.Pose(translation=(4.1, 4.2, 4.0)))
    local = fc.LocalBody(block(), cells=(32, 32))
    window = pressed(local, other).solved(local).window
    assert 1.5 < window.grid.size[0] / window.grid.size[1] < 5.0


def test_the_window_follows_a_prescribed_motion() -> None:
    """The load is an approach, and the ball moves aside before it touches."""
    local, other = fc.LocalBody(block(), cells=(32, 32)), ball(at=(3.0, 4.0, 4.2))
    result = pressed(local, other, forces=None, motions={other: {"x": 0.5, "z": -0.25}}, finite_motion=False)
    assert np.abs(result.solved(local).window.origin - [3.5, 4.0, 4.0]).max() < 1e-6
    assert result.contacts[0].active.any()


def test_a_window_of_which_one_thing_is_given_keeps_it() -> None:
    for given in ({"at": (3.3, 4.2, 4.0)}, {"window": 1.5}):
        local = fc.LocalBody(block(), cells=(32, 32), **given)
        window = pressed(local, ball()).solved(local).window
        assert np.abs(window.origin - [3.3, 4.2, 4.0]).max() < 1e-6
        assert ("window" not in given) or window.grid.size == (1.5, 1.5)


REFUSED = {
    "conform": (fc.RigidBody(fc.Plane()).placed((0, 0, 4.0), fc.rotation_about((1, 0, 0), np.pi)), {}, ("conforming",)),
    "apart": (ball(at=(4, 4, 5.0)), {"forces": None, "motions": "z"}, ("do-not-touch",)),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals(case: str) -> None:
    other, options, message = REFUSED[case]
    if "motions" in options:
        options = {**options, "motions": {other: {"z": -0.5}}}
    with refused(fc.InputError, *message):
        pressed(fc.LocalBody(block(), cells=(32, 32)), other, **options)


def test_without_a_scene_there_is_no_window() -> None:
    local = fc.LocalBody(block())
    with refused(fc.InputError, "no-window"):
        local.remainder  # noqa: B018
    assert "where it is touched" in local.describe()


def test_two_contacts_of_one_body_are_refused() -> None:
    local, one, two = fc.LocalBody(block()), ball(), ball(at=(5.5, 4.0, 4.0))
    scene = fc.Scene([local, one, two], [fc.Contact(local, one), fc.Contact(local, two)])
    with refused(fc.InputError, "several-contacts", "in 2"):
        scene.solve(forces={one: (0, 0, -0.1), two: (0, 0, -0.1)})


def half_ball(supports):
    mesh = fc.shapes.half_sphere(10.0, contact_radius=2.0, level=COARSE)
    body = fc.ElasticBody(mesh, SOLID, contact="cap", geometry=fc.Sphere(10.0), supports=supports, name="half-ball")
    return fc.LocalBody(body, (0, 0, 0), 3.4, (48, 48))


@pytest.mark.full
def test_a_floating_body_is_in_equilibrium_and_as_stiff_as_finite_elements_say() -> None:
    """A half-ball pressed by a load spread over its flat face: nothing holds it but the plane below.

    Source: finite elements refined at the contact, for the mean motion; the support taken away, the answers differ from
    those of a clamped one.
    """
    floor, load = fc.RigidBody(fc.Plane()), (0, 0, -1.0)
    local = half_ball({})
    scene = fc.Scene([local, floor], [fc.Contact(local, floor)])
    result = scene.solve(forces={(local, "base"): load}, finite_motion=False)
    assert np.abs(result.contacts[0].force + load).max() < 1e-9
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=1.4, level=1)
    fine = fc.ElasticBody(mesh, SOLID, contact="cap", supports={"sym_x": "x", "sym_y": "y"}, name="fine")
    quarter = {(fine, "base"): (0, 0, -0.25)}
    other = fc.Scene([fine, floor], [fc.Contact(fine, floor)]).solve(forces=quarter, finite_motion=False)
    found, expected = (r.rigid_motion(b).translation[2] for r, b in ((result, local), (other, fine)))
    assert found == pytest.approx(expected, rel=2e-3)
    # it is the ground that carries a held body's reactions; where a floating one is held does not matter
    assert local.remainder.defect < 0.01


def quarter_ball(material=SOLID, **options):
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=2.0, level=COARSE)
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    return fc.ElasticBody(mesh, material, contact="cap", geometry=fc.Sphere(10.0), **{"supports": supports} | options)


#: Half a turn about x = y: a quarter comes to lie on its mirror image.
OVER = fc.rotation_about((1, 1, 0), np.pi)


@pytest.mark.by_day("given1-32")
@pytest.mark.parametrize("cells", [32, 128])
@pytest.mark.parametrize("given", [{}, {"at": (0, 0, 0), "window": 3.4}])
def test_two_equal_bodies_meet_as_one_meets_a_plane(given: dict, cells: int) -> None:
    """By symmetry: each has half the approach; few cells are a matrix, many an operator."""
    body = quarter_ball()
    lower = fc.LocalBody(body, cells=(cells, cells), **given)
    upper = lower.placed(rotation=OVER, name="upper")
    floor = fc.RigidBody(fc.Plane())
    both = fc.Scene([lower, upper], [fc.Contact(lower, upper)])
    one = fc.Scene([lower, floor], [fc.Contact(lower, floor)])
    load = {lower: (0, 0, -0.25)}
    two, alone = (scene.solve(forces=load, finite_motion=False) for scene in (both, one))
    found, expected = (r.rigid_motion(lower).translation[2] for r in (two, alone))
    assert found == pytest.approx(2 * expected, rel=1e-5 if given else 3e-4)  # the windows found differ a little
    assert two.contacts[0].max_pressure == pytest.approx(alone.contacts[0].max_pressure, rel=1e-4 if given else 1e-3)
    assert two.solved(upper).window.faces(two.solved(lower).window, lower.pose.relative_to(upper.pose))


def test_other_planes_of_symmetry_are_refused() -> None:
    lower = fc.LocalBody(quarter_ball(), (0, 0, 0), 3.4, (16, 16))
    mesh = fc.shapes.half_sphere(10.0, contact_radius=2.0, level=COARSE)
    whole = fc.ElasticBody(mesh, SOLID, contact="cap", geometry=fc.Sphere(10.0), supports={"base": "xyz"})
    upper = fc.LocalBody(whole, (0, 0, 0), 3.4, (16, 16)).placed(rotation=OVER, name="upper")
    with refused(fc.InputError, "no-opposite-window"):
        fc.Scene([lower, upper], [fc.Contact(lower, upper)]).solve(forces={lower: (0, 0, -0.25)})


def test_a_window_is_placed_at_the_corner_of_two_planes_of_symmetry() -> None:
    """Their faces are no part of the surface: its normal there is that of the top, and the contact a circle."""
    mesh = fc.shapes.block((4.0, 4.0, 4.0), (4, 4, 4))
    body = fc.ElasticBody(mesh, SOLID, supports={"bottom": "xyz", "x_min": "x", "y_min": "y"}, name="quarter")
    local, other = fc.LocalBody(body, (0, 0, 4.0), cells=(32, 32)), ball(at=(0, 0, 4.0))
    result = fc.Scene([local, other], [fc.Contact(local, other)]).solve(
        forces={other: (0, 0, -1e-3)}, finite_motion=False
    )
    sides = result.solved(local).window.grid.size
    hertz = fc.hertz.spheres((3.0, np.inf), (None, SOLID), force=4e-3)
    assert np.allclose(sides, 2 * 1.15 * hertz.a, rtol=0.05)
