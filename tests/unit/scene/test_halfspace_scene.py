"""Half-spaces and elastic layers in scenes."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.bodies.layer import foundation_modulus
from fecontact.contact.coupling.nodal import straight_above
from fecontact.halfspace.grid import grid_surface
from fecontact.surfaces import Paraboloid

STEEL = fc.Material(210e3, 0.3)


def half_space(n=64, size=0.6, **options):
    return fc.HalfSpace(STEEL, size=(size, size), cells=(n, n), **options)


def test_ball_on_a_half_space():
    half, ball = half_space(), fc.RigidBody(fc.Sphere(radius=10.0), name="ball")
    result = fc.Scene([half, ball], [fc.Contact(ball, half)]).solve(forces={ball: (0, 0, -100.0)})
    contact = result.contacts[0]
    hertz = fc.hertz.spheres((10.0, np.inf), (STEEL, None), force=100.0)
    assert result.solution.solver == "nested-grid"
    assert result.residuals().worst < 1e-10
    assert contact.points.shape == (64 * 64, 3)
    assert contact.pressure.shape == (64 * 64,)
    with pytest.warns(PendingDeprecationWarning, match="force is that on 'ball', which the contact names first"):
        assert abs(contact.force[2] - 100.0) < 1e-10
    assert abs(-result.rigid_motion(ball).translation[2] / hertz.approach - 1) < 5e-4  # 16 cells per radius
    own = half.press(fc.Sphere(radius=10.0), force=100.0, tolerance=1e-10)
    # the same problem by both doors, at tolerance 1e-10
    assert np.abs(contact.pressure - own.pressure.ravel()).max() < 1e-7 * own.max_pressure


def test_prescribed_motion_and_tilted_pose():
    half = half_space(n=48)
    ball = fc.RigidBody(fc.Sphere(radius=10.0), name="ball")
    down = fc.Scene([half, ball], [fc.Contact(half, ball)]).solve(motions={ball: {"z": -2e-3}})
    turned = ball.placed(translation=(0.0, 0.0, -10.0)).placed(rotation=fc.rotation_about((1, 2, 0), 0.3))
    turned = turned.placed(translation=(0.0, 0.0, 10.0))
    same = fc.Scene([half, turned], [fc.Contact(half, turned)]).solve(motions={turned: {"z": -2e-3}})
    # a ball turned about its centre is the same ball; 1e-16 of its radius over the approach of 2e-3
    assert np.abs(same.contacts[0].pressure - down.contacts[0].pressure).max() < 1e-7 * down.contacts[0].max_pressure


def test_whole_scene_moved_and_turned():
    Q, t = fc.rotation_about((1.0, 2.0, 3.0), 0.7), np.array([100.0, -50.0, 20.0])
    half, ball = half_space(n=48), fc.RigidBody(fc.Sphere(radius=10.0), name="ball")
    first = fc.Scene([half, ball], [fc.Contact(ball, half)]).solve(forces={ball: (0, 0, -100.0)})
    half2, ball2 = half.placed(t, Q), ball.placed(t, Q)
    second = fc.Scene([half2, ball2], [fc.Contact(ball2, half2)]).solve(forces={ball2: -100.0 * Q[:, 2]})
    # the relative pose loses 1e-16 * 110, an approach is 2e-3
    assert (
        np.abs(second.contacts[0].pressure - first.contacts[0].pressure).max() < 1e-6 * first.contacts[0].max_pressure
    )


def test_two_balls_share_the_cells():
    half = fc.HalfSpace(STEEL, size=(3.0, 1.5), cells=(96, 48))
    one = fc.RigidBody(fc.Sphere(10.0), name="one").placed((-0.7, 0.0, 0.0))
    two = fc.RigidBody(fc.Sphere(5.0), name="two").placed((0.7, 0.0, 0.001))
    scene = fc.Scene([half, one, two], [fc.Contact(one, half), fc.Contact(two, half)])
    result = scene.solve(forces={one: (0, 0, -100.0), two: (0, 0, -50.0)})
    assert result.residuals().worst < 1e-10
    assert [round(float(c._whole.force[2]), 8) for c in result.contacts] == [100.0, 50.0]
    assert abs(result.contacts[0].centre_of_pressure[0] + 0.7) < 0.002


def test_finite_elements_on_a_half_space():
    block = fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 2))
    body = fc.ElasticBody(block, fc.Material(1.0, 0.0), "bottom", {"top": "xyz"}, name="block")
    body = body.placed(translation=(-0.5, -0.5, 0.0))
    half = fc.HalfSpace(fc.Material(1.0, 0.0), size=(2.0, 2.0), cells=(8, 8))
    result = fc.Scene([body, half], [fc.Contact(body, half)]).solve(forces={body: (0, 0, -0.01)})
    contact = result.contacts[0]
    assert abs(abs(contact.force[2]) - 0.01) < 1e-12
    assert np.abs(contact.centre_of_pressure[:2]).max() < 1e-10  # symmetric
    assert result.residuals().worst < 1e-10
    u = result._state.displacements[1].reshape(-1, 3)[:, 2]
    assert u.min() < 0
    assert np.abs(result._state.displacements[1].reshape(-1, 3)[:, :2]).max() == 0.0


def test_spread_forces_keep_force_and_moment():
    surface = grid_surface(half_space(n=8).grid, "surface")
    points = np.random.default_rng(0).uniform(-0.25, 0.25, (20, 3))
    projection = surface.project(points)
    assert not projection.outside.any()
    assert np.abs(projection.weights @ surface.points - projection.points).max() < 1e-15
    assert surface.project(np.array([[1.0, 0.0, 0.0]])).outside.all()


def test_straight_above_by_heights_and_by_steps():
    points = np.stack([np.linspace(-0.5, 0.5, 9), np.linspace(0.3, -0.3, 9), np.zeros(9)], axis=1)
    shape = Paraboloid(2.0, 3.0)
    told = straight_above(points, shape, np.eye(3), np.array([0.1, 0.2, -0.05]))
    tiny = fc.rotation_about((1, 0, 0), 1e-15)
    found = straight_above(points, shape, tiny, np.array([0.1, 0.2, -0.05]))
    assert np.abs(found.gap - told.gap).max() < 1e-13


@pytest.mark.parametrize("law", ["bonded", "frictionless", "uniaxial"])
def test_layer_under_a_ball(law):
    plate = fc.shapes.block((2.0, 2.0, 0.1), (40, 40, 1), element="hex8")
    material = fc.Material(5.0, 0.3)
    layer = fc.ElasticLayer(material, thickness=0.5, surface=(plate, "top"), law=law)
    ball = fc.RigidBody(fc.Sphere(10.0), name="ball").placed((1.0, 1.0, 0.1))
    result = fc.Scene([layer, ball], [fc.Contact(layer, ball)]).solve(motions={ball: {"z": -0.02}})
    exact = np.pi * foundation_modulus(material, law) * 10.0 * 0.02**2 / 0.5
    # elastic foundation under a paraboloid, P = pi H R d^2/h; 12 cells per contact radius
    assert abs(abs(result.contacts[0].force[2]) / exact - 1) < 0.02
    assert result.residuals().worst < 1e-12


def test_bad_layers():
    plate = fc.shapes.block((1.0, 1.0, 0.1), (2, 2, 1), element="hex8")
    with refused(InputError, "not-positive", "A layer's thickness"):
        fc.ElasticLayer(STEEL, thickness=-1.0, surface=(plate, "top"))
    with refused(InputError, "unknown-name", "law"):
        fc.ElasticLayer(STEEL, thickness=1.0, surface=(plate, "top"), law="magic")
    with refused(InputError, "input", "surface="):
        fc.ElasticLayer(STEEL, thickness=1.0, surface="top")
    with refused(InputError, "unknown", "'cap'"):
        half_space(n=8).surface("cap")


@pytest.mark.parametrize("shape", [Paraboloid(1.0), fc.surfaces.Cone(0.2), fc.surfaces.FlatPunch(0.4)], ids=repr)
@pytest.mark.parametrize("load", ["force", "approach"])
def test_a_contact_on_cells_has_one_estimate_and_one_area(shape, load):
    half = fc.HalfSpace(fc.Material(1.0, 0.3), size=(2.0, 2.0), cells=(32, 32))
    body = fc.RigidBody(shape, name="shape")
    scene = fc.Scene([half, body], [fc.Contact(half, body)])
    alone = half.press(shape, **{load: 0.1}, tolerance=1e-10)
    loads = {"forces": {body: (0, 0, -0.1)}} if load == "force" else {"motions": {body: {"z": -0.1}}}
    result = scene.solve(**loads)
    found, own = result.contacts[0].error_estimate, alone.error_estimate
    figures = ("pressure", "peak", "area", "interior", "faces_across")
    # coarser grids are solved to 1e-3 of the same start
    assert [getattr(found, f) for f in figures] == pytest.approx([getattr(own, f) for f in figures], rel=1e-5)
    assert result.contacts[0]._whole.area == pytest.approx(alone.figures["area"], rel=1e-6)
    assert (found.unbounded is None) == (own.unbounded is None)
    given = {"force": "approach", "approach": "force"}[load]
    # in a scene the bodies meet first at the middle of a cell, not at the tip between four
    assert getattr(result.response_error, given) == pytest.approx(getattr(alone.response_error, given), rel=0.1)


def test_a_contact_with_friction_on_cells_has_one_estimate_and_one_area_of_stick():
    half, ball = half_space(n=36, size=2.0), fc.RigidBody(Paraboloid(1.0), name="ball")
    force = 0.2 * STEEL.E
    alone = half.press(Paraboloid(1.0), force=force, friction=0.3, tangential=(0.15 * force, 0.0))
    scene = fc.Scene([half, ball], [fc.Contact(half, ball, friction=0.3)])
    result = scene.solve(forces={ball: (0.15 * force, 0, -force)}, free={ball: "x z"})
    contact = result.contacts[0]
    assert contact.stick_area == pytest.approx(alone.stick_area, rel=1e-6)
    # alone it is of the first turn of pressures and tractions
    assert contact.error_estimate.pressure == pytest.approx(alone.error_estimate.pressure, rel=0.01)
    assert result.response_error.approach == pytest.approx(alone.response_error.approach, rel=0.02)
