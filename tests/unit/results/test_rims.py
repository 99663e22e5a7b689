"""Contacts cut off by the declared boundary are warned of with their share of force; those at true edges are not."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.bodies.rims import rim_of_surface
from fecontact.mesh import pick
from fecontact.surfaces import Cylinder, FlatPunch, HeightMap

STEEL = fc.Material(E=210e3, nu=0.3)
LAYERS = np.array([0.0, 1.5, 2.5, 3.2, 3.6, 3.8, 4.0])


def graded(n):
    """Positions from 0 to 8, close together in the middle."""
    t = np.linspace(-1, 1, n)
    return 4 + 4 * np.sign(t) * np.abs(t) ** 2.2


def rim_warnings(result):
    return [w for w in result.warnings if "within one face of the rim" in w]


def ball_on_block(half, scale=1.0, pose=None, elastic=False):
    """A rigid ball of radius 4 on a steel block 8 x 8 x 4 with a contact patch of width 2 `half`; radius a = 0.4."""
    mesh = fc.shapes.block((8.0, 8.0, 4.0), (graded(15), graded(15), LAYERS)).translated((-4, -4, -4)).scaled(scale)
    mesh = mesh.with_boundary("patch", pick.box((-half * scale, -half * scale, 0), (half * scale, half * scale, 0)))
    block = fc.ElasticBody(mesh, STEEL, "patch", {"bottom": "xyz"}, name="block")
    ball = fc.RigidBody(fc.Sphere(4.0 * scale), name="ball")
    turn = np.eye(3) if pose is None else pose
    block, ball = block.placed(rotation=turn), ball.placed(rotation=turn)
    force = turn @ np.array([0, 0, -5000.0 * scale**2])
    return fc.Scene([block, ball], [fc.Contact(block, ball)]).solve(forces={ball: force})


def test_a_patch_that_is_too_small_is_warned_of_with_its_share_of_the_force():
    exact = fc.hertz.spheres((4.0, np.inf), (STEEL, fc.Material(E=1e12, nu=0.3)), force=5000.0)
    result = ball_on_block(0.3)
    contact = result.contacts[0]
    assert contact.max_pressure > 1.5 * exact.p0
    (text,) = rim_warnings(result)
    assert "'patch' of 'block', beyond which the body goes on" in text
    # the force of nodes on the outermost faces, counted by their coordinates
    edge = np.abs(contact.points[:, :2]).max()
    lines = np.unique(np.abs(contact.points[:, 0]).round(9))
    outermost = edge - lines[lines < edge - 1e-9][-2] if len(lines) > 3 else edge
    size = max(outermost, 1e-12)
    share = contact.forces[np.abs(contact.points[:, :2]).max(axis=1) >= edge - 1.01 * size].sum() / contact.forces.sum()
    said = float(text.split(" %")[0])
    assert abs(said / (100 * share) - 1) < 0.25  # faces there are not square; the share is rounded to three digits


@pytest.mark.full
def test_the_warning_is_the_same_in_other_units_and_poses():
    texts = [
        rim_warnings(r)[0].split(" %")[0]
        for r in (
            ball_on_block(0.3),
            ball_on_block(0.3, scale=1e-3),
            ball_on_block(0.3, pose=fc.rotation_about((1, 2, 3), 0.9)),
        )
    ]
    assert texts[0] == texts[1] == texts[2]


def test_a_patch_that_is_large_enough_is_not():
    exact = fc.hertz.spheres((4.0, np.inf), (STEEL, fc.Material(E=1e12, nu=0.3)), force=5000.0)
    result = ball_on_block(1.2)
    assert abs(result.contacts[0].max_pressure / exact.p0 - 1) < 0.15
    assert rim_warnings(result) == []


@pytest.mark.parametrize("coupling", ["nodal", "mortar"])
@pytest.mark.parametrize("whole", [True, False])
def test_blocks_whose_contact_ends_at_sharp_edges_are_not(coupling, whole):
    """A block on a larger one: whole faces, or a patch of the larger one that is just the smaller one's face."""
    mesh = fc.shapes.block((3.0, 3.0, 1.0), (6, 6, 2))
    mesh = mesh.with_boundary("patch", pick.box((1, 1, 1), (2, 2, 1)))
    lower = fc.ElasticBody(mesh, STEEL, "top" if whole else "patch", {"bottom": "xyz"}, name="lower")
    upper = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), STEEL, "bottom", {"top": "xyz"}, name="upper")
    upper = upper.placed((1.0, 1.0, 1.0))
    for pair in ((upper, lower), (lower, upper)):
        contact = fc.Contact(*pair, swap="never", coupling=coupling)
        result = fc.Scene([lower, upper], [contact]).solve(motions={upper: {"z": -0.001}})
        assert result.n_active > 0
        assert rim_warnings(result) == []


@pytest.mark.by_day("lower")
@pytest.mark.parametrize("slave", ["upper", "lower"])
def test_a_master_whose_patch_is_too_small_is_warned_of(slave):
    """An elastic ball on a patch of a block, narrower than the contact."""
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (16, 16, 4), element="hex8").translated((-2, -2, -2))
    mesh = mesh.with_boundary("patch", pick.box((-0.25, -0.25, 0), (0.25, 0.25, 0)))
    lower = fc.ElasticBody(mesh, STEEL, "patch", {"bottom": "xyz"}, name="block")
    ball = fc.shapes.half_sphere(4.0, contact_radius=0.5, level=1, element="hex8")
    upper = fc.ElasticBody(ball, STEEL, "cap", {"base": "xyz"}, name="ball")
    pair = (upper, lower) if slave == "upper" else (lower, upper)
    scene = fc.Scene([lower, upper], [fc.Contact(*pair, swap="never", coupling="mortar")])
    (text,) = rim_warnings(scene.solve(motions={upper: {"z": -0.06}}))
    assert "'patch' of 'block'" in text


def test_planes_of_symmetry_are_no_rims():
    mesh = fc.shapes.quarter_sphere(4.0, contact_radius=0.3, level=1)
    ball = fc.ElasticBody(mesh, STEEL, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"})
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([ball, floor], [fc.Contact(ball, floor)]).solve(motions={ball: {"z": -0.02}})
    assert result.n_active > 3
    assert rim_warnings(result) == []
    assert (
        not rim_of_surface(ball, "cap").smooth[np.abs(rim_of_surface(ball, "cap").ends[..., 2]).max(axis=1) < 1].any()
    )


def test_a_round_section_goes_on_where_its_sides_meet_with_one_tangent():
    """A quarter of a ring, whose outer arc has two sides of 45 degrees; the first is the contact's."""

    def bent(p):
        radius, angle = 1 + p[:, 0], p[:, 2]
        return np.stack([radius * np.cos(angle), 0 * angle, radius * np.sin(angle)], axis=1)

    mesh = fc.sections.rectangle((1.0, np.pi / 2), (1, 2)).mapped(bent)
    mesh = mesh.with_boundary("first", lambda p: (np.linalg.norm(p, axis=1) > 1.8) & (p[:, 2] <= p[:, 0] + 1e-9))
    rim = rim_of_surface(fc.PlaneBody(mesh, STEEL, "first", {"left": "xz"}), "first")
    order = np.argsort(rim.ends[:, 0, 2])
    assert np.abs(rim.ends[order, 0] - [[2, 0, 0], [2**0.5, 0, 2**0.5]]).max() < 1e-12
    assert rim.smooth[order].tolist() == [False, True]


def test_sections_too():
    x = np.linspace(-2.0, 2.0, 33)
    mesh = fc.sections.rectangle((4.0, 2.0), (x + 2.0, 8)).translated((-2.0, 0.0, -2.0))
    for half, warned in ((0.25, True), (1.0, False), (2.0, False)):
        patch = mesh.with_boundary("patch", lambda p, h=half: (np.abs(p[:, 0]) <= h + 1e-9) & (p[:, 2] > -1e-9))
        body = fc.PlaneBody(patch, STEEL, "patch", {"bottom": "xz"})
        roll = fc.RigidBody(Cylinder(4.0))
        result = fc.Scene([body, roll], [fc.Contact(body, roll)]).solve(motions={roll: {"z": -0.05}})
        assert bool(rim_warnings(result)) is warned


def test_grids_of_half_spaces_and_measured_maps():
    """A ball whose contact is wider than the grid; a map that ends within the contact; both wide enough."""
    for size, warned in ((0.5, True), (3.0, False)):
        half = fc.HalfSpace(STEEL, size=(size, size), cells=(12, 12))
        ball = fc.RigidBody(fc.Sphere(4.0))
        result = fc.Scene([half, ball], [fc.Contact(half, ball)]).solve(motions={ball: {"z": -0.06}})
        assert bool(rim_warnings(result)) is warned
        x = (np.arange(20) - 9.5) / 20 * size
        heights = fc.RigidBody(HeightMap((x[:, None] ** 2 + x**2) / 8, (size, size)))
        block = fc.ElasticBody(
            fc.shapes.block((4.0, 4.0, 2.0), (24, 24, 2)).translated((-2, -2, -2)), STEEL, "top", {"bottom": "xyz"}
        )
        result = fc.Scene([block, heights], [fc.Contact(block, heights)]).solve(motions={heights: {"z": -0.06}})
        assert bool(rim_warnings(result)) is warned


def test_a_rigid_punch_ends_where_it_ends():
    """Its edge is real; a patch that is narrower than the punch is not."""
    mesh = fc.shapes.block((3.0, 3.0, 1.0), (12, 12, 2)).translated((-1.5, -1.5, -1))
    for half, warned in ((1.5, False), (0.5, False), (0.25, True)):
        patch = mesh.with_boundary("patch", pick.box((-half, -half, 0), (half, half, 0)))
        body = fc.ElasticBody(patch, STEEL, "patch", {"bottom": "xyz"})
        punch = fc.RigidBody(FlatPunch(sides=(1.0, 1.0)))
        result = fc.Scene([body, punch], [fc.Contact(body, punch)]).solve(motions={punch: {"z": -0.01}})
        assert bool(rim_warnings(result)) is warned


def test_rings_shrunk_on_one_another_are_looked_at_without_a_word_of_numpy():
    """Their forces are radial, so that no line of action is left of them all round."""
    held = {"bottom": "z"}
    pin = fc.AxisymmetricBody(fc.sections.rectangle((1.001, 1.0), (3, 3)), STEEL, "right", held, name="pin")
    wall = fc.sections.rectangle((1.0, 1.0), (3, 3)).translated((1.0, 0.0, 0.0))
    hub = fc.AxisymmetricBody(wall, STEEL, "left", held, name="hub")
    result = fc.Scene([pin, hub], [fc.Contact(pin, hub)]).solve()
    assert result.n_active > 0
    with np.errstate(all="raise"):
        assert rim_warnings(result) == []
        assert isinstance(result.notes, tuple)
