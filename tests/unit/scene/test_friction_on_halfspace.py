"""Friction on half-spaces in scenes: beside the half-space alone, and against elastic bodies."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import InputError
from fecontact.analytic import friction as closed
from fecontact.surfaces import HeightMap, Paraboloid

PLAIN, SOFT = fc.Material(1.0, 0.3), fc.Material(2.0, 0.45)
MU, FORCE, PULLS = 0.3, 0.2, ((0.03, 0.02), (-0.01, 0.03))


def half_space(**options):
    return fc.HalfSpace(PLAIN, size=(1.6, 1.6), cells=(12, 12), **options)


def ball_on(half, pose=None):
    """Path of a ball that is pressed and dragged to and fro, the whole scene moved by a pose (t, Q)."""
    t, Q = pose or (np.zeros(3), np.eye(3))
    half, ball = half.placed(t, Q), fc.RigidBody(Paraboloid(1.0), name="ball").placed(t, Q)
    load = [{"forces": {ball: Q @ (x, y, -FORCE)}, "free": {ball: "x y z"}} for x, y in PULLS]
    return ball, fc.Scene([half, ball], [fc.Contact(half, ball, friction=MU)]).solve_path(load)


@pytest.mark.parametrize("options", [{}, {"against": SOFT}, {"layers": [fc.Layer(SOFT, 0.3)]}], ids=str)
@pytest.mark.parametrize("turned", [False, True])
def test_a_ball_dragged_in_a_scene_is_one_on_the_half_space_alone(options, turned):
    half = half_space(**options)
    pose = (np.array([3.0, -2.0, 1.0]), fc.rotation_about((1, 2, 3), 0.7)) if turned else None
    Q = np.eye(3) if pose is None else pose[1]
    ball, path = ball_on(half, pose)
    steps = [fc.PressStep(force=FORCE, tangential=pull) for pull in PULLS]
    for alone, found in zip(half.press_path(Paraboloid(1.0), steps, MU), path, strict=True):
        contact, size = found.contacts[0], alone.max_pressure
        # either door is certified to 1e-10, forces of cells at the edge are conditioned worse
        assert np.abs(contact.pressure.reshape(12, 12) - alone.pressure).max() < 1e-8 * size
        traction = np.moveaxis((contact.friction.forces @ Q / half.grid.area).reshape(12, 12, 3), 2, 0)
        assert np.abs(traction[:2] - alone.traction).max() < 1e-8 * size
        assert np.abs(traction[2]).max() < 1e-14 * size
        assert found.rigid_motion(ball).translation @ Q == pytest.approx((*alone.shift, -alone.approach), abs=1e-9)
        assert contact.friction.friction_work == pytest.approx(alone.friction_work, abs=1e-10)
        assert found.friction.residuals.within(1e-10)


def test_periodic_surfaces_drag_each_other():
    half = half_space(periodic=True)
    wave = HeightMap(0.02 * np.cos(np.pi * half.grid.x)[:, None] * np.ones(12), half.grid.size)
    body = fc.RigidBody(wave, name="wave")
    scene = fc.Scene([half, body], [fc.Contact(half, body, friction=MU)])
    result = scene.solve(motions={body: {"z": -0.005, "x": 0.004}})
    alone = half.press(wave, approach=0.005, friction=MU, shift=(0.004, 0.0))
    assert result.reaction(body)[:3] == pytest.approx((alone.tangential[0], 0.0, -alone.force), abs=1e-9)


def test_a_ball_in_partial_slip_is_mindlins():
    """Cattaneo and Mindlin, exact for nu = 0: the shift under a tangential force."""
    plain = fc.Material(1.0, 0.0)
    half = fc.HalfSpace(plain, size=(1.6, 1.6), cells=(20, 20), against=plain)
    ball = fc.RigidBody(Paraboloid(1.0), name="ball")
    hertz = fc.hertz.spheres((1.0, np.inf), (plain, plain), force=2 / 3 * 0.6**3)
    force, pull = hertz.force, 0.5 * MU * hertz.force
    result = fc.Scene([half, ball], [fc.Contact(half, ball, friction=MU)]).solve(
        forces={ball: (pull, 0.0, -force)}, free={ball: "x z"}
    )
    exact = closed.mindlin(hertz, MU, tangential=pull)
    assert result.rigid_motion(ball).translation[0] == pytest.approx(exact.shift, rel=0.01)  # 15 cells across


def test_a_stiff_elastic_block_drags_the_half_space_as_a_rigid_one():
    half = fc.HalfSpace(PLAIN, size=(3.0, 3.0), cells=(12, 12))
    mesh = fc.shapes.block((1.5, 1.5, 0.5), (3, 3, 1))
    stiff = fc.ElasticBody(mesh, fc.Material(1e8, 0.3), "bottom", {"top": "xyz"}, name="block")
    stiff = stiff.placed(translation=(-0.75, -0.75, 0.0))
    scene = fc.Scene([half, stiff], [fc.Contact(half, stiff, friction=0.4, coupling="nodal")])
    result = scene.solve(motions={stiff: {"z": -0.02, "x": 0.006}})
    heights = np.full((12, 12), np.inf)
    heights[3:9, 3:9] = 0.0
    rigid = half.press(heights, approach=0.02, friction=0.4, shift=(0.006, 0.0))
    # its compliance is 1e-8 of the half-space's
    assert result.reaction(stiff)[:3] == pytest.approx((rigid.tangential[0], 0.0, -rigid.force), abs=1e-6 * rigid.force)


def test_what_has_no_compliance_along_the_surface_is_refused():
    ball = fc.RigidBody(Paraboloid(1.0), name="ball")
    for half, message in (
        (half_space(pressure="point"), "uniform"),
        (half_space(layers=[fc.Layer(SOFT, 0.01)]), "top layer's thickness"),
    ):
        with pytest.raises(InputError, match=message):
            fc.Scene([half, ball], [fc.Contact(half, ball, friction=MU)]).solve(motions={ball: {"z": -0.1}})


@pytest.mark.parametrize("options", [{}, {"against": PLAIN}], ids=["coupled", "uncoupled"])
def test_the_grid_solves_what_the_matrix_does(options, monkeypatch):
    _, by_matrix = ball_on(half_space(**options))
    monkeypatch.setattr("fecontact.halfspace.operator.DENSE_LIMIT", 10)
    _, on_grid = ball_on(half_space(**options))
    for one, other in zip(by_matrix, on_grid, strict=True):
        assert (one.friction.solver, other.friction.solver) == ("newton", "grid")
        assert other.friction.residuals.within(1e-10)
        scale = one.contacts[0].forces.max()
        assert np.abs(one.contacts[0].forces - other.contacts[0].forces).max() < 1e-8 * scale
        assert np.abs(one.contacts[0].friction.forces - other.contacts[0].friction.forces).max() < 1e-8 * scale


def test_what_the_grid_does_not_solve_goes_to_the_matrix(monkeypatch):
    """A body that tilts about a point above the surface, one that slides, and an elastic one."""
    monkeypatch.setattr("fecontact.halfspace.operator.DENSE_LIMIT", 10)
    half, ball = half_space(), fc.RigidBody(Paraboloid(1.0), name="ball")
    scene = fc.Scene([half, ball], [fc.Contact(half, ball, friction=MU)])
    tilted = scene.solve(forces={ball: (0.02, 0.0, -FORCE)}, free={ball: "x z ry"}, moments={ball: (0, 0.01, 0)})
    assert tilted.friction.solver != "grid"
    assert tilted.friction.residuals.within(1e-10)
    with pytest.raises(fc.SupportError, match="balance the load"):
        scene.solve(forces={ball: (1.1 * MU * FORCE, 0.0, -FORCE)}, free={ball: "x z"})
    mesh = fc.shapes.block((0.5, 0.5, 0.2), (2, 2, 1)).translated((-0.25, -0.25, 0.0))
    block = fc.ElasticBody(mesh, PLAIN, "bottom", {"top": "xyz"}, name="block")
    result = fc.Scene([half, block], [fc.Contact(half, block, friction=MU)]).solve(motions={block: {"z": -0.01}})
    assert result.friction.residuals.within(1e-10)
