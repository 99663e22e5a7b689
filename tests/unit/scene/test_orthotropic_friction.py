"""Orthotropic friction in scenes: the ellipse, its limits, the axis and the body that it turns with, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from common_scenes import BLOCK_ON_FLOOR
from refusals import refused

import fecontact as fc
from fecontact import read_scene
from fecontact.ancf import AncfSolid, AncfSpace, Assembly
from fecontact.contact.contact import Lay

MU = (0.1, 0.3)
PRESSED = (0.0, 0.0, -0.01)


def block_on(mu: object, kind: str = "rigid", turn: float = 0.0, **options: object) -> tuple[fc.Scene, fc.ElasticBody]:
    """A unit block, held at its top, on a rigid floor or on blocks whose faces match or do not; turned about z."""
    material = fc.Material(E=1.0, nu=0.3)
    block = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), material, "bottom", {"top": "xyz"}, name="block"
    )
    cells = {"nodal": (2, 2, 2), "mortar": (3, 3, 2)}.get(kind)
    floor: fc.RigidBody | fc.ElasticBody = fc.RigidBody(fc.Plane(), name="floor")
    if cells is not None:
        under = fc.shapes.block((1.0, 1.0, 1.0), cells).translated((0, 0, -1.0))
        floor = fc.ElasticBody(under, material, "top", {"bottom": "xyz"}, name="floor")
    both = [body.placed(rotation=fc.rotation_about((0, 0, 1), turn)) for body in (block, floor)]
    return fc.Scene(both, [fc.Contact(*both, friction=mu, **options)]), both[0]


def dragged(scene: fc.Scene, block: fc.ElasticBody, x: float, y: float) -> fc.ContactResult:
    """Pressed, then dragged."""
    steps = [{"motions": {block: dict(zip("xyz", to, strict=True))}} for to in (PRESSED, (x, y, PRESSED[2]))]
    return scene.solve_path(steps)[1]


@pytest.mark.parametrize("kind", ["rigid", "nodal", "mortar"])
def test_sliding_points_slip_normal_to_the_ellipse(kind: str) -> None:
    """Source: t_k = -mu_k^2 s_k p / |mu s|, from the ellipse and its normal; work p |mu s|."""
    scene, block = block_on(MU, kind, friction_axis=(1, 0, 0), axis_of="master")
    result = dragged(scene, block, 0.02, 0.015)
    c = result.contacts[0]
    f, mu = c.friction, np.array([*MU, 0.0])
    assert f.sliding.sum() >= 9
    rate = np.linalg.norm(mu * f.slip, axis=1)
    exact = -(mu**2) * f.slip * (c.pressure / rate)[:, None]
    assert np.abs(f.traction - exact)[f.sliding].max() <= 1e-9 * np.abs(exact).max()
    assert abs(f.friction_work / (rate * c.pressure @ c.weights) - 1) <= 1e-9
    np.testing.assert_allclose(
        f.sliding_integral[f.sliding], (c.pressure * np.linalg.norm(f.slip, axis=1))[f.sliding], rtol=1e-9
    )
    assert np.abs(result.contacts[0].friction.force + result.reaction(scene.bodies[0])[:3] * [1, 1, 0]).max() <= 1e-12
    assert result.friction.residuals.worst <= 1e-10
    # neither the pull nor the slip is parallel to the force
    drag, slid = -f.force[:2] / np.linalg.norm(f.force), f.slip.mean(axis=0)[:2]
    assert drag @ (0.8, 0.6) < 0.9
    assert drag @ slid < 0.9 * np.linalg.norm(slid)


def test_equal_coefficients_are_isotropic_friction() -> None:
    found = [dragged(*block_on(mu, "mortar", **axis), 0.01, 0.007).contacts[0] for mu, axis in
             ((0.3, {}), ((0.3, 0.3), {"friction_axis": (1, 2, 0)}))]  # fmt: skip
    one, other = found
    assert 0 < one.friction.sliding.sum() < one.friction.touching.sum()
    np.testing.assert_allclose(other.friction.traction, one.friction.traction, atol=1e-12 * one.pressure.max())
    np.testing.assert_allclose(other.friction.slip, one.friction.slip, atol=1e-12)


def test_wear_is_of_pressure_and_slip_in_any_direction() -> None:
    """Source: Archard's h = k p |s| of points that slide with all their pressure."""
    scene, block = block_on(MU, friction_axis=(1, 0, 0))
    path = scene.solve_path([{"motions": {block: {"x": 0.3, "y": 0.2, "z": -0.01}}}])
    c = path[0].contacts[0]
    assert c.friction.sliding.all()
    worn = 2.0 * c.pressure * np.linalg.norm(c.friction.slip, axis=1)
    np.testing.assert_allclose(path.wear_depth(0, 2.0), worn, rtol=1e-9)


def test_axes_swapped_turned_and_of_any_length_give_the_same() -> None:
    first = dragged(*block_on(MU, "mortar", friction_axis=(1, 0, 0)), 0.01, 0.007).contacts[0]
    swapped = dragged(*block_on(MU[::-1], "mortar", friction_axis=(0, -7, 0)), 0.01, 0.007).contacts[0]
    scale = np.abs(first.friction.traction).max()
    np.testing.assert_allclose(swapped.friction.traction, first.friction.traction, atol=1e-11 * scale)
    # the axis is one of the body, whose pose turns it; an axis out of the surface is projected on it
    angle = 0.6
    turn = fc.rotation_about((0, 0, 1), angle)
    pull = turn @ (0.01, 0.007, 0.0)
    turned = dragged(*block_on(MU, "mortar", angle, friction_axis=(1, 0, 0.8)), pull[0], pull[1]).contacts[0]
    np.testing.assert_allclose(turned.friction.traction @ turn, first.friction.traction, atol=1e-11 * scale)


@pytest.mark.parametrize("least", [3e-4, 3e-3])
def test_far_unlike_coefficients_slide_along_the_easy_way(least: float) -> None:
    """Limit: friction along the lay vanishes, across it is that of isotropic friction with the pull across."""
    result = dragged(*block_on((least, 0.3), friction_axis=(1, 0, 0)), 0.5, 0.5)
    c = result.contacts[0]
    assert c.friction.sliding.all()
    assert abs(c.friction.force[1] / (-0.3 * c.total_force) - 1) < least
    assert abs(c.friction.force[0]) < 2 * least**2 / 0.3 * c.total_force
    assert result.friction.residuals.worst <= 1e-10


def loose(angle: float, pull: float) -> tuple[fc.Scene, dict[str, object]]:
    """A free block of weight 1, pulled at the floor by a force at an angle to the lay."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1)).translated((-0.5, -0.5, 0.0))
    block = fc.ElasticBody(mesh, fc.Material(E=1e3, nu=0.0), "bottom", name="block", supports={})
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=MU, friction_axis=(1, 0, 0))])
    force = (pull * math.cos(angle), pull * math.sin(angle), -1.0)
    return scene, {"forces": {block: force}, "moments": {block: np.cross((0.0, 0.0, 0.0), force)}}


@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 2])
def test_a_block_holds_up_to_the_ellipse(angle: float) -> None:
    """A force holds within (cos / mu_1)^2 + (sin / mu_2)^2 = 1 / F^2; beyond, the coefficients needed are named."""
    limit = 1 / math.hypot(math.cos(angle) / MU[0], math.sin(angle) / MU[1])
    scene, loads = loose(angle, 0.9 * limit)
    force = scene.solve(**loads).contacts[0].friction.force
    np.testing.assert_allclose(force, -0.9 * limit * np.array([math.cos(angle), math.sin(angle), 0]), atol=1e-11)
    scene, loads = loose(angle, 1.1 * limit)
    with refused(fc.SupportError, "slides-as-a-whole", f"{1.1 * MU[1]:.3g}", "mu is the larger one"):
        scene.solve(**loads)


def test_the_axis_turns_with_its_body() -> None:
    """A floor turned by a right angle under the block: what was along its lay is now across."""
    found = {}
    for side in ("slave", "master"):
        scene, block = block_on(MU, friction_axis=(1, 0, 0), axis_of=side)
        floor = scene.bodies[1]
        at = [{"rz": 0.0}, {"rz": math.pi / 2}]
        steps = [{"motions": {block: {"z": 0.01}, floor: turn}} for turn in at]
        slid = {"motions": {block: {"x": 0.3, "z": -0.01}, floor: at[1]}}
        path = scene.solve_path([*steps, slid], finite_motion=True)
        c = path[2].contacts[0]
        assert c.friction.sliding.all()
        found[side] = -c.force[0] / c.total_force
    assert abs(found["slave"] / MU[0] - 1) < 1e-3
    assert abs(found["master"] / MU[1] - 1) < 1e-3


def test_the_axis_stays_with_its_body_where_sides_are_swapped() -> None:
    """A path keeps the sides of its first step, whichever was made the slave."""
    scene, block = block_on(MU, friction_axis=(1, 0, 0), axis_of="master")
    floor = scene.bodies[1]
    contact = fc.Contact(floor, block, friction=MU, friction_axis=(1, 0, 0))
    assert contact.lay.body == "floor"
    turned = fc.Scene(scene.bodies, [contact])
    one, other = (dragged(s, block, 0.02, 0.01).contacts[0].force for s in (scene, turned))
    np.testing.assert_allclose(one, -other, atol=1e-14)  # on the body named first


def test_a_result_tells_both_coefficients(tmp_path) -> None:
    result = dragged(*block_on(MU, friction_axis=(1, 0, 0)), 0.02, 0.01)
    assert "mu 0.1, 0.3" in str(result)
    assert result.summary()["contacts"][0]["friction"]["mu"] == MU
    result.plot("friction", tmp_path / "map.png")
    assert (tmp_path / "map.png").exists()


def test_a_scene_file_has_two_coefficients(written) -> None:
    text = f"""{BLOCK_ON_FLOOR}
    friction = [0.1, 0.3]
    friction_axis = [1, 1, 0]
    axis_of = "master"
    [loads]
    motions.block = {{z = -0.01}}
    """
    path = written(text)
    contact = read_scene(path).scene.contacts[0]
    assert (contact.friction, contact.mu, contact.lay.body) == (MU, 0.3, "floor")
    path.write_text(text.replace("friction_axis = [1, 1, 0]", ""), encoding="utf-8")
    with refused(fc.InputError, "scene-file"):
        read_scene(path)


@pytest.mark.parametrize(
    ("friction", "axis", "words"),
    [
        ((0.1, 0.3), None, ("input", "need friction_axis")),
        (0.3, (1, 0, 0), ("friction-axis",)),
        ((0.1, 0.0), (1, 0, 0), ("not-positive", "two")),
        ((0.1, np.inf), (1, 0, 0), ("not-positive", "two")),
        ((0.1, 0.2, 0.3), (1, 0, 0), ("not-positive", "two")),
        ((1e-4, 1.0), (1, 0, 0), ("friction-too-unlike", "1000")),
        ((0.1, 0.3), (0, 0, 0), ("input", "is zero")),
        ((0.1, 0.3), (1, 0), ("not-a-vector", "three")),
    ],
)
def test_senseless_pairs_are_refused(friction: object, axis: object, words: str) -> None:
    with refused(fc.InputError, *words):
        block_on(friction, friction_axis=axis)


def test_an_axis_normal_to_the_surface_is_refused_where_it_touches() -> None:
    with refused(fc.InputError, "friction-axis-normal", "lay of 'block'"):
        dragged(*block_on(MU, friction_axis=(0, 0, 1)), 0.01, 0.0)
    # away from contact it does not matter
    lay = Lay(np.array(MU), np.array([1.0, 0.0, 0.0]), "ball")
    normals = np.array([[0.0, 0.0, 1.0], [math.cos(0.05), math.sin(0.05), 0.0]])
    lay.check(normals, normals, np.array([True, False]))
    with refused(fc.InputError, "friction-axis-normal", "at 1"):
        lay.check(normals, normals, np.array([True, True]))
    across = lay.tangents(normals) / np.reshape([1 / 3, 1.0], (2, 1, 1))
    np.testing.assert_allclose(np.einsum("kni,lni->nkl", across, across), [np.eye(2)] * 2, atol=1e-15)
    np.testing.assert_allclose(np.einsum("kni,ni->kn", across, normals), 0.0, atol=1e-15)


def test_an_axis_oblique_to_a_plane_of_symmetry_is_refused() -> None:
    """Half a block gives half the force of a whole one, with the lay along the plane; an oblique one has no image."""
    material, floor = fc.Material(E=1.0, nu=0.3), fc.RigidBody(fc.Plane())
    half = fc.shapes.block((1.0, 0.5, 1.0), (2, 1, 2))
    whole = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).translated((0.0, -0.5, 0.0))
    force = []
    for mesh, held in ((half, {"y_min": "y"}), (whole, {})):
        body = fc.ElasticBody(mesh, material, "bottom", {"top": "xyz", **held})
        for axis in ((1, 0, 0), (0, 1, 0)):
            scene = fc.Scene([body, floor], [fc.Contact(body, floor, friction=MU, friction_axis=axis)])
            force.append(dragged(scene, body, 0.01, 0.0).contacts[0].force)
    np.testing.assert_allclose(2 * np.array(force[:2])[:, [0, 2]], np.array(force[2:])[:, [0, 2]], atol=1e-12)
    body = fc.ElasticBody(half, material, "bottom", {"top": "xyz", "y_min": "y"})
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, friction=MU, friction_axis=(1, 1, 0))])
    with refused(fc.InputError, "input", "oblique to the lay"):
        dragged(scene, body, 0.01, 0.0)


def test_half_spaces_and_bricks_have_one_coefficient() -> None:
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(8, 8))
    with refused(fc.InputError, "friction-isotropic", "(0.1, 0.3)"):
        half.press(fc.surfaces.Paraboloid(1.0), force=0.1, friction=MU, tangential=(0.01, 0.0))
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.0), points=3)
    with refused(fc.InputError, "friction-isotropic", "(0.1, 0.3)"):
        Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), fc.RigidBody(fc.Plane()), friction=MU)])


def test_a_section_has_one_coefficient() -> None:
    body = fc.PlaneBody(fc.sections.rectangle((1.0, 1.0), (1, 1)), fc.Material(E=1.0, nu=0.0), "bottom", {"top": "xz"})
    with refused(fc.InputError, "friction-of-section"):
        fc.Contact(body, fc.RigidBody(fc.Plane()), friction=MU, friction_axis=(1, 0, 0))
