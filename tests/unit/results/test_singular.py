"""Pressures without bound: reported with place and order where a sharp edge presses, and nowhere else."""

import json

import numpy as np
import pytest

import fecontact as fc
from fecontact.bodies import AxisymmetricBody, PlaneBody
from fecontact.mesh import section_shapes
from fecontact.results.field_map import scale_top
from fecontact.results.recovery import nodal_pressure
from fecontact.results.singular import rough_eigenvalue, wedge_eigenvalue
from fecontact.surfaces import FlatPunch, FunctionSurface
from fecontact.surfaces.rigid.shapes import sharpest

SOLID = fc.Material(E=1.0, nu=0.3)
#: Distances from an edge, halved down to 0.3 %.
NEAR = np.array([1.0, 0.7, 0.4, *0.2 * 0.5 ** np.arange(7), 0.0])


def dundurs_lee(root, alpha):
    """Equation (14) of Dundurs & Lee (1972) for a right-angled end, by their parameter of the two stiffnesses."""
    corner = np.cos(np.pi * root) * (np.sin(np.pi * root / 2) ** 2 - root**2)
    return (1 + alpha) * corner + (1 - alpha) * np.sin(np.pi * root) ** 2 / 2


@pytest.mark.parametrize("alpha", [-0.6, 0.0, 0.3, 0.8])
def test_right_angled_end_against_dundurs_and_lee(alpha):
    root = wedge_eigenvalue(np.pi / 2, (1 + alpha) / (1 - alpha))
    assert 0.5 < root < 1
    assert abs(dundurs_lee(root, alpha)) < 1e-9


@pytest.mark.parametrize("nu", [0.1, 0.3, 0.45])
def test_right_angled_end_stuck_on_a_rigid_plane_against_williams(nu):
    """Williams (1952), clamped and free sides; a smooth plane is one of symmetry, so that the end is none."""
    kappa = 3 - 4 * nu
    root = rough_eigenvalue((kappa, 1.0), None, None)
    assert 0.5 < root < 1
    assert abs(np.sin(root * np.pi / 2) ** 2 - ((kappa + 1) ** 2 - 4 * root**2) / (4 * kappa)) < 1e-9
    assert rough_eigenvalue((kappa, 1.0), None, 0.0) == 1.0


def test_a_tip_is_found_on_heights_far_from_zero():
    """A cone of slope 0.1, lifted by a million times the square it is looked for in; rounding has no tip."""
    tip = sharpest(lambda x, y: 1e6 + 0.1 * np.hypot(x - 0.1, y), np.zeros(2), 0.3)
    assert tip.power == pytest.approx(1.0, abs=0.01)
    assert tip.slope == pytest.approx(0.1, rel=1e-3)
    noise = np.random.default_rng(0)
    assert sharpest(lambda x, y: 1e6 * (1 + 1e-15 * noise.normal(size=np.shape(x + y))), np.zeros(2), 0.3).power == 2.0


def end_on_half_plane(E):
    """The right-angled end of a strip of modulus E on a large block of modulus 1, cut fine at the edge."""
    beyond = np.concatenate([1 - NEAR, 1 + NEAR[::-1][1:], [3.0, 6.0, 10.0]])
    depth = np.concatenate([[-10.0, -6.0, -3.0, -1.7], -NEAR]) + 10
    below = section_shapes.rectangle((10.0, 10.0), (beyond, depth)).translated((0, 0, -10.0))
    above = section_shapes.rectangle((1.0, 1.0), (1 - NEAR, NEAR[::-1]))
    lower = PlaneBody(below, SOLID, "top", {"bottom": "xz", "left": "x"}, name="lower")
    upper = PlaneBody(above, fc.Material(E, 0.3), "bottom", {"top": "z", "left": "x"}, name="upper")
    return fc.Scene([upper, lower], [fc.Contact(upper, lower)]).solve(motions={upper: {"z": -0.01}})


def slope_at_end(contact):
    """Exponent of the pressure near the end x = 1 of a section."""
    distance = 1 - contact.points[:, 0]
    chosen = (distance > 0.005) & (distance < 0.06)
    return np.polyfit(np.log(distance[chosen]), np.log(contact.pressure[chosen]), 1)[0]


@pytest.mark.parametrize("E", [0.2, 1.0, 5.0, 1000.0])
def test_pressure_found_grows_with_the_order_reported(E):
    contact = end_on_half_plane(E).contacts[0]
    peak = contact.error_estimate.unbounded
    assert peak.body == "upper"
    # a curve is drawn up to its highest node
    assert scale_top(contact) == contact.max_pressure
    assert np.allclose(peak.point, (1, 0, 0), atol=1e-12)
    # farther off the regular part counts; under a nearly rigid end by 0.02
    assert abs(peak.exponent + slope_at_end(contact)) < 0.03


def block(n, side=1.0, element="hex20", **options):
    mesh = fc.shapes.block((side, side, 1.0), (n, n, 4), element=element)
    return fc.ElasticBody(mesh.translated((-side / 2, -side / 2, -1)), SOLID, "top", {"bottom": "xyz"}, **options)


def on_block(side, n=4, slide=0.0, coupling="auto", swap=False):
    """A block of side 1 on one of another side."""
    lower = block(round(side * n), side, name="lower")
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3)).translated((-0.5 + slide, -0.5, 0))
    upper = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, name="upper")
    pair = (lower, upper) if swap else (upper, lower)
    contact = fc.Contact(*pair, coupling=coupling)
    return fc.Scene([upper, lower], [contact]).solve(motions={upper: {"z": -0.01}})


@pytest.mark.parametrize(("coupling", "swap"), [("nodal", False), ("nodal", True), ("mortar", False), ("mortar", True)])
def test_a_block_on_a_larger_one(coupling, swap):
    peak = on_block(2.0, coupling=coupling, swap=swap).contacts[0].error_estimate.unbounded
    assert peak.body == "upper"
    # at its edge, or half a face from it where the points are those of the block below
    assert 0.5 - 0.13 <= np.abs(peak.point[:2]).max() <= 0.5 + 1e-9
    assert abs(peak.exponent - 0.226) < 1e-3


def test_blocks_of_one_side_end_together_and_are_bounded():
    assert on_block(1.0).contacts[0].error_estimate.unbounded is None


@pytest.mark.parametrize("swap", [False, True])
def test_an_edge_beside_another_one_is_unbounded_from_a_small_step_between_them(swap):
    """Faces of 0.26 to 0.33: steps of 0.03 are a tenth of a face, of 0.002 hardly a hundredth."""
    peak = on_block(1.06, swap=swap).contacts[0].error_estimate.unbounded
    assert peak.body == "upper"
    peak = on_block(0.94, swap=swap).contacts[0].error_estimate.unbounded
    assert peak.body == "lower"
    assert on_block(1.004, swap=swap).contacts[0].error_estimate.unbounded is None


def test_planes_of_symmetry_are_no_edges_of_a_quarter():
    """Only points at the two real edges carry the pressure without bound, whose sides are 0.5 long."""
    sides = {"x_min": "x", "y_min": "y"}
    below = fc.shapes.block((1.0, 1.0, 0.5), (8, 8, 2), element="hex8").translated((0, 0, -0.5))
    lower = fc.ElasticBody(below, SOLID, "top", {"bottom": "xyz"} | sides, name="lower")
    mesh = fc.shapes.block((0.5, 0.5, 0.5), (4, 4, 2), element="hex8")
    upper = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"} | sides, name="upper")
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower, swap="never")])
    contact = scene.solve(motions={upper: {"z": -0.01}}).contacts[0]
    marked = contact.points[contact._singular_edge.points]
    assert len(marked) == 9
    assert (marked[:, :2].max(axis=1) > 0.5 - 1e-9).all()


def test_a_block_that_hangs_over_is_pressed_by_both_edges():
    peak = on_block(1.0, slide=0.4).contacts[0].error_estimate.unbounded
    assert abs(np.abs(peak.point[0] - 0.2)) == pytest.approx(0.3, abs=0.17)


def punched(shape, n=12):
    body, rigid = block(n, 2.0, name="block"), fc.RigidBody(shape, name="punch")
    return fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -0.01}})


def test_a_flat_punch_is_reported_and_a_ball_is_not():
    result = punched(FlatPunch(radius=0.55))
    contact = result.contacts[0]
    peak = contact.error_estimate.unbounded
    assert peak.body == "punch"
    assert peak.exponent == 0.5
    assert 0.55 - 2 / 12 <= np.hypot(*peak.point[:2]) <= 0.55
    assert punched(fc.Sphere(8.0)).contacts[0].error_estimate.unbounded is None
    (line,) = (line for line in str(result).splitlines() if "error of pressure" in line)
    assert "away from the edge of 'punch' (no peak" in line
    assert str(peak) in line
    (note,) = result.notes
    assert "Round the edge" in note
    told = json.loads(json.dumps(result.summary(), allow_nan=False))["contacts"][0]["error_estimate"]
    assert told["peak"] is None
    assert told["unbounded"]["exponent"] == 0.5


def test_faces_without_pressure_do_not_count_beside_an_edge():
    """A tilted punch, of which the lower part touches."""
    body, punch = block(8, 2.0, name="block"), fc.RigidBody(FlatPunch(sides=(1.2, 1.2)), name="punch")
    punch = punch.placed((0.0, 0.0, 0.012), fc.rotation_about((0, 1, 0), 0.02))
    contact = fc.Scene([body, punch], [fc.Contact(body, punch)]).solve(motions={punch: {"z": -0.01}}).contacts[0]
    assert contact.error_estimate.unbounded.body == "punch"
    field = nodal_pressure(contact)
    assert not field.loaded.all()
    assert (field.loaded & ~field.bounded).any()
    assert not (field.bounded & ~field.loaded).any()


@pytest.mark.parametrize("n", [10, 20])
def test_a_section_under_a_flat_punch_away_from_its_edge(n):
    """Source: Sneddon 1965, p = F / (2 pi a sqrt(a^2 - r^2)), on the points off the outermost two faces."""
    x = np.concatenate([np.linspace(0, 0.7, int(1.4 * n) + 1), [0.8, 1.0, 1.4, 2.2, 4.0, 8.0, 20.0]])
    mesh = section_shapes.rectangle((20.0, 20.0), (x, 20 - x[::-1])).translated((0, 0, -20))
    body = AxisymmetricBody(mesh, SOLID, "top", {"bottom": "xz"})
    punch = fc.RigidBody(FlatPunch(radius=0.5), name="punch")
    contact = fc.Scene([body, punch], [fc.Contact(body, punch)]).solve(forces={punch: (0, 0, -1.0)}).contacts[0]
    estimate = contact.error_estimate
    assert estimate.unbounded.body == "punch"
    assert abs(estimate.unbounded.point[0] - 0.5) < 0.5 / n
    at, pressure, areas = contact.sampled(contact.pressure, 8)
    r = np.hypot(at[:, 0], at[:, 1])
    inside = r < 0.5 - 1 / n
    known = 1 / (2 * np.pi * 0.5 * np.sqrt(0.25 - r[inside] ** 2))
    areas, difference = areas[inside], pressure[inside] - known
    error = np.sqrt(areas @ difference**2 / (areas @ known**2))
    assert 0.5 <= estimate.pressure / error <= 3


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_no_edge_on_a_rigid_floor_or_on_a_plane_of_symmetry(nu):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (4, 4, 4))
    body = fc.ElasticBody(mesh, fc.Material(1.0, nu), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    assert result.contacts[0].error_estimate.unbounded is None
    quarter = {"bottom": "z", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, SOLID, "top", quarter)
    ball = fc.RigidBody(fc.Sphere(1.0)).placed((0, 0, 1.0))
    result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.05}})
    assert result.contacts[0].error_estimate.unbounded is None


def test_an_accuracy_is_met_away_from_the_edge():
    """The faces at the edge are not divided for ever: it ends by the error elsewhere."""
    body, punch = block(4, 2.0, name="block"), fc.RigidBody(FlatPunch(radius=0.6), name="punch")
    scene = fc.Scene([body, punch], [fc.Contact(body, punch)])
    result = scene.solve(motions={punch: {"z": -0.01}}, accuracy=0.08, max_dofs=60_000)
    assert result.convergence.met
    assert result.contacts[0].error_estimate.unbounded.body == "punch"
    json.dumps(result.convergence.as_dict(), allow_nan=False)
    assert "inf" not in str(result.convergence)


@pytest.mark.parametrize("n", [32, 64, 128])
def test_a_flat_punch_on_a_half_space(n):
    """Source: Sneddon 1965, away from the edge by the two cells that do not count."""
    half = fc.HalfSpace(fc.Material(1.0, 0.0), size=(2.7, 2.7), cells=(n, n))
    contact = half.press(FlatPunch(radius=1.0), force=1.0)
    estimate = contact.error_estimate
    assert estimate.unbounded.exponent == 0.5
    assert abs(np.hypot(*estimate.unbounded.point[:2]) - 1) < 2.7 / n
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    inside = r < 1 - 4 * 2.7 / n
    known = 1 / (2 * np.pi * np.sqrt(1 - r[inside] ** 2))
    error = np.linalg.norm(contact.pressure[inside] - known) / np.linalg.norm(known)
    assert 0.8 <= estimate.pressure / error <= 3
    json.dumps(estimate.summary(), allow_nan=False)
    assert half.press(fc.Sphere(10.0), force=0.05).error_estimate.unbounded is None


def rough_end(mu, nu, n=9):
    """The right-angled end of a block pressed on a rigid plane with friction, fine at the corner, in plane strain."""
    near = np.array([*2.0 ** -np.arange(n), 0.0])
    mesh = section_shapes.rectangle((1.0, 1.0), (1 - near, near[::-1]))
    block = PlaneBody(mesh, fc.Material(1.0, nu), "bottom", {"top": "z", "left": "x"}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return fc.Scene([block, floor], [fc.Contact(block, floor, friction=mu)]).solve(motions={block: {"z": -0.01}})


@pytest.mark.parametrize(("mu", "nu"), [(np.inf, 0.3), (0.5, 0.3), (0.1, 0.3), (np.inf, 0.45)])
def test_the_corner_of_a_rough_block_grows_with_the_order_reported(mu, nu):
    """Stuck but for its last node at mu = 0.5, sliding at 0.1; the slope found has 2 % of the regular part."""
    result = rough_end(mu, nu)
    contact = result.contacts[0]
    peak = contact.error_estimate.unbounded
    assert peak.body == "block"
    assert np.allclose(peak.point, (1, 0, 0), atol=1e-12)
    assert abs(peak.exponent + slope_at_end(contact)) < 0.03
    assert "unbounded at the edge of 'block'" in str(result)


def test_a_rough_block_in_uniform_pressure_has_no_unbounded_corner():
    """Source: a uniform state. Without Poisson's ratio nothing spreads; frictionless, nothing holds it."""
    for mu, nu in ((0.5, 0.0), (0.0, 0.3)):
        assert rough_end(mu, nu, n=4).contacts[0].error_estimate.unbounded is None


def test_the_rim_of_a_rough_block_in_space():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 4))
    block = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "z", "x_min": "x", "y_min": "y"}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.5)])
    estimate = scene.solve(motions={block: {"z": -0.01}}).contacts[0].error_estimate
    assert abs(estimate.unbounded.exponent - 0.289) < 1e-3  # Williams 1952, nu = 0.3
    assert max(estimate.unbounded.point[:2]) == pytest.approx(1.0)
    assert estimate.pressure < 0.05


def tipped(shape, kind=AxisymmetricBody):
    """A rigid shape pressed into a section by a hundredth of its width."""
    mesh = section_shapes.rectangle((1.0, 1.0), (10, 6)).translated((0.0 if kind is AxisymmetricBody else -0.5, 0, -1))
    body = kind(mesh, SOLID, "top", {"bottom": "xz"}, name="body")
    rigid = fc.RigidBody(shape, name="tip")
    return fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -0.05}}).contacts[0]


@pytest.mark.parametrize(
    ("shape", "kind", "exponent"),
    [
        (fc.surfaces.Cone(0.2), AxisymmetricBody, 0.0),
        (FunctionSurface(lambda x, y: 0.2 * np.abs(x - 0.02) + 0 * y), PlaneBody, 0.0),
        (FunctionSurface(lambda x, y: 0.2 * np.sqrt(np.hypot(x, y))), AxisymmetricBody, 0.5),
    ],
    ids=["cone", "wedge between nodes", "r^0.5"],
)
def test_tips_of_rigid_shapes_are_reported_with_their_order(shape, kind, exponent):
    """Source: the pressure below r^n varies as r^(n - 1) (Sneddon 1965), for a kink as a logarithm."""
    peak = tipped(shape, kind).error_estimate.unbounded
    assert peak.body == "tip"
    assert peak.exponent == pytest.approx(exponent, abs=0.02)
    assert ("as a logarithm" in str(peak)) is (exponent == 0)
    assert abs(peak.point[0]) < 0.06


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        (fc.Sphere(1.0), AxisymmetricBody),
        (fc.surfaces.Cylinder(1.0), PlaneBody),
        (FunctionSurface(lambda x, y: 0.2 * np.hypot(x, y) ** 1.3), AxisymmetricBody),
        (FunctionSurface(lambda x, y: np.hypot(x, y) ** 2 + 1e-3 * np.hypot(x, y)), AxisymmetricBody),
    ],
    ids=["ball", "roller", "r^1.3", "faint kink"],
)
def test_blunt_tips_are_not(shape, kind):
    assert tipped(shape, kind).error_estimate.unbounded is None


def test_springs_carry_a_cone_with_a_bounded_pressure():
    """Source: the pressure of springs is that of their depth."""
    mesh = fc.shapes.block((2.0, 2.0, 0.1), (8, 8, 1), element="hex8").translated((-1.0, -1.0, -0.1))
    springs = fc.ElasticLayer(SOLID, thickness=0.5, surface=(mesh, "top"))
    cone = fc.RigidBody(fc.surfaces.Cone(0.3), name="cone")
    contact = fc.Scene([springs, cone], [fc.Contact(springs, cone)]).solve(motions={cone: {"z": -0.1}}).contacts[0]
    assert contact.error_estimate.unbounded is None


def test_a_cone_on_a_block_is_reported_in_every_pose_and_unit():
    turn = fc.rotation_about((1, 2, 3), 0.7)
    for scale, rotation in ((1.0, np.eye(3)), (1e-3, turn)):
        mesh = fc.shapes.block((2.0, 2.0, 1.0), (6, 6, 3), element="hex8").translated((-0.9, -1.1, -1.0)).scaled(scale)
        block = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}).placed(rotation=rotation)
        cone = fc.RigidBody(fc.surfaces.Cone(0.3), name="cone").placed(rotation=rotation)
        scene = fc.Scene([block, cone], [fc.Contact(block, cone)])
        contact = scene.solve(forces={cone: tuple(rotation @ (0, 0, -0.1 * scale**2))}).contacts[0]
        assert contact.error_estimate.unbounded.exponent == 0
