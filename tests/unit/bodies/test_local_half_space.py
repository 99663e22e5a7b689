"""Local bodies on half-spaces: against the layered half-space's own solution, and wherever the half-space's grid is."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.halfspace.operator import CellModel
from fecontact.mesh.shapes import Level
from fecontact.surfaces import Paraboloid

SOLID, OTHER, HARD = fc.Material(E=1.0, nu=0.3), fc.Material(E=2.0, nu=0.45), fc.Material(E=6.0, nu=0.2)
OVER = fc.rotation_about((1, 0, 0), np.pi)
COARSE = Level(1, 1, 0.9, 0.8, 2.5)
RADIUS, FORCE, SIDE, CELLS = 400.0, 3e-4, 1.4, 48


@pytest.fixture(scope="module")
def crown() -> fc.LocalBody:
    """A bonded layer of thickness 1, a quarter, whose face is a paraboloid; half the window's width touches."""
    along = np.array([0, 0.35, 0.7, 1.1, 1.6, 2.4, 4.0])
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (along, along, np.linspace(0, 1, 5)))
    top = fc.RigidBody(Paraboloid(RADIUS)).placed((0, 0, 1.0), OVER)
    supports = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, SOLID, contact="top", geometry={"top": top}, supports=supports, name="layer")
    return fc.LocalBody(body, (0, 0, 1), SIDE, (CELLS, CELLS))


@pytest.fixture(scope="module")
def ball() -> fc.ElasticBody:
    """A half-ball, its flat face clamped."""
    mesh = fc.shapes.half_sphere(10.0, contact_radius=2.0, level=COARSE)
    return fc.ElasticBody(
        mesh, SOLID, contact="cap", geometry=fc.Sphere(10.0), supports={"base": "xyz"}, name="half-ball"
    )


def pressed(one, two, load, **options):
    result = fc.Scene([one, two], [fc.Contact(one, two)]).solve(forces=load, finite_motion=False, **options)
    assert result.residuals().worst < 1e-8
    return result


@pytest.fixture(scope="module")
def on_half_space(crown: fc.LocalBody) -> fc.ContactResult:
    return pressed(crown, fc.HalfSpace(OTHER).placed((0, 0, 1.0), OVER), {crown: (0, 0, FORCE / 4)})


# Found: 0.02 % in the pressure and 0.006 % in the approach, by the mesh; Betti's defect is 0.02 %.
def test_a_layer_against_a_half_space(crown: fc.LocalBody, on_half_space: fc.ContactResult) -> None:
    """Source: a half-space of one layer on a rigid base, whose counter-body is elastic."""
    result = on_half_space
    alone = fc.HalfSpace(None, (SIDE, SIDE), (CELLS, CELLS), layers=[fc.Layer(SOLID, 1.0)], against=OTHER)
    expected = alone.press(Paraboloid(RADIUS), force=FORCE)
    quarter = expected.pressure[CELLS // 2 :, CELLS // 2 :].ravel()
    found = result.contacts[0].pressure
    assert np.linalg.norm(found - quarter) < 1e-3 * np.linalg.norm(quarter)
    assert result.rigid_motion(crown).translation[2] == pytest.approx(expected.approach, rel=5e-4)


def test_a_layer_against_a_layered_half_space(crown: fc.LocalBody) -> None:
    """The pressures close the gap by the displacements of the layer on its rigid base and of the layered half-space."""
    layers = (fc.Layer(HARD, 0.3),)
    half = fc.HalfSpace(OTHER, layers=layers).placed((0, 0, 1.0), OVER)
    result = pressed(crown, half, {crown: (0, 0, FORCE / 4)})
    p = result.contacts[0].pressure.reshape(CELLS // 2, -1)
    whole = np.block([[p[::-1, ::-1], p[::-1]], [p[:, ::-1], p]])
    alone = fc.HalfSpace(None, (SIDE, SIDE), (CELLS, CELLS), layers=[fc.Layer(SOLID, 1.0)])
    other = fc.HalfSpace(OTHER, (SIDE, SIDE), (CELLS, CELLS), layers=layers)
    u = sum(CellModel(each.compliance).product.apply(whole) for each in (alone, other))
    depth = result.rigid_motion(crown).translation[2]
    gap = (u + alone.heights_of(Paraboloid(RADIUS)))[CELLS // 2 :, CELLS // 2 :] - depth
    assert np.abs(gap[p > 0]).max() < 5e-4 * depth
    assert gap[p == 0].min() > -5e-4 * depth


def test_the_grid_and_the_place_of_the_half_space_do_not_matter(
    crown: fc.LocalBody, on_half_space: fc.ContactResult
) -> None:
    """Nor which of the two is named first; the solver ends at 1e-8."""
    aside = fc.rotation_about((0, 0, 1), 0.4)
    half = fc.HalfSpace(OTHER, (0.1, 0.2), (4, 6)).placed(rotation=OVER @ aside).placed((30.0, -7.0, 1.0))
    there = pressed(half, crown, {crown: (0, 0, FORCE / 4)})
    assert there.contacts[0].max_pressure == pytest.approx(on_half_space.contacts[0].max_pressure, rel=1e-6)
    depths = (r.rigid_motion(crown).translation[2] for r in (on_half_space, there))
    assert next(depths) == pytest.approx(next(depths), rel=1e-7)
    assert there.solved(half).surface("surface").cell_area == crown.window.grid.area


@pytest.mark.full
def test_a_half_space_is_a_large_block() -> None:
    """Source: a local body of a block of ten contact radii; the approach differs by that of the block's far field."""
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=2.0, level=COARSE)
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    quarter = fc.ElasticBody(mesh, SOLID, contact="cap", geometry=fc.Sphere(10.0), supports=supports, name="ball")
    local = fc.LocalBody(quarter, (0, 0, 0), 3.4, (32, 32))
    mesh = fc.shapes.block((12.0, 12.0, 12.0), (4, 4, 5))
    supports = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh.drawn_at(mesh.points - [0, 0, 12.0]), OTHER, supports=supports, name="block")
    block, load = fc.LocalBody(body, cells=(32, 32)), {local: (0, 0, -0.075)}
    half, large = (pressed(local, other, load).contacts[0] for other in (fc.HalfSpace(OTHER), block))
    assert np.linalg.norm(half.pressure - large.pressure) < 1e-3 * np.linalg.norm(half.pressure)
    # by itself the window is found too; the half-space's own grid does not reach there
    free = fc.LocalBody(quarter, cells=(32, 32))
    small = fc.HalfSpace(OTHER, (0.2, 0.2), (4, 4)).placed((5.0, 5.0, 0.0))
    found = pressed(free, small, {free: (0, 0, -0.075)})
    assert found.contacts[0].max_pressure == pytest.approx(half.max_pressure, rel=2e-3)


@pytest.mark.full
def test_a_half_space_may_incline_to_the_window(ball: fc.ElasticBody) -> None:
    """The window at the pole for a contact beside it, against one at the contact: cosines are within 0.2 %."""
    turn = fc.rotation_about((0, 1, 0), 0.06)
    half = fc.HalfSpace(OTHER).placed(np.array([0, 0, 10.0]) - 10 * turn[:, 2], turn)
    held = dict.fromkeys(("rx", "ry", "rz"), 0.0)
    found = []
    for at, side, cells in ((half.pose.translation, 3.4, 32), (np.zeros(3), 5.0, 47)):
        local = fc.LocalBody(ball, at, side, (cells, cells))
        result = pressed(local, half, {local: 0.3 * local.window.normal}, motions={local: held})
        found.append((np.linalg.norm(result.rigid_motion(local).translation), result.contacts[0].max_pressure))
    np.testing.assert_allclose(found[1], found[0], rtol=4e-3)


def test_refusals(crown: fc.LocalBody, ball: fc.ElasticBody) -> None:
    local = fc.LocalBody(ball, (0, 0, 0), 3.4, (8, 8))
    steep = fc.rotation_about((0, 1, 0), 0.1)
    cases = (
        (local, fc.HalfSpace(OTHER, periodic=True), ("local-body-coupling", "it is periodic")),
        (local, fc.HalfSpace(OTHER, pressure="bilinear"), ("local-body-coupling", "it has pressure='bilinear'")),
        (
            local,
            fc.HalfSpace(OTHER, layers=(fc.Layer(HARD, 1.0),)).placed(rotation=steep),
            ("window-inclined", "0.1", "0.01"),
        ),
        (local, fc.HalfSpace(OTHER).placed(rotation=OVER), ("window-inclined", "inf")),
        (crown, fc.HalfSpace(OTHER).placed(rotation=OVER).placed((0, 0, 1.0), steep), ("not-normal-to-symmetry",)),
    )
    for body, half, message in cases:
        with refused(fc.InputError, *message):
            pressed(body, half, {body: (0, 0, -0.1)})
    scene = fc.Scene(
        [local, other := local.placed((40, 0, 0), name="next"), half := fc.HalfSpace(OTHER)],
        [fc.Contact(local, half), fc.Contact(other, half)],
    )
    with refused(fc.InputError, "two-windows"):
        scene.solve(forces={local: (0, 0, -0.1), other: (0, 0, -0.1)})
