"""Bodies that overlap between the nodes of their faces, and shapes that vary there: never without a word."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import fecontact as fc
from fecontact import ContactResult
from fecontact.surfaces.between_nodes import smallest_gaps

SOFT = fc.Material(E=1.0, nu=0.3)
MODULUS = 1 / (1 - 0.3**2)


def rigid(shape: object, at: tuple[float, float, float]) -> fc.RigidBody:
    return fc.RigidBody(shape, pose=fc.Pose(translation=at), name="rigid")


def pressed(body: fc.Body, other: fc.Body, depth: float, **options: object) -> ContactResult:
    """Result of moving the other body down by a depth from where the two just meet."""
    return fc.Scene([body, other], [fc.Contact(body, other)]).solve(motions={other: {"z": -depth}}, **options)


def block(kind: type = fc.ElasticBody, element: str = "hex8", n: int = 2) -> fc.ElasticBody:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, n, n), element=element)
    return kind(mesh, SOFT, contact="top", supports={"bottom": "xyz"}, name="block")


def ball_on(body: fc.Body, depth: float, **options: object) -> ContactResult:
    return pressed(body, rigid(fc.Sphere(2.0), (0.27, 0.31, 1.0)), depth, **options)


def cylinder_on_plane(depth: float) -> ContactResult:
    mesh = fc.sections.rectangle((2.0, 1.0), (7, 4))
    body = fc.PlaneBody(mesh, SOFT, thickness=1.0, contact="top", supports={"bottom": "xz"})
    return pressed(body, rigid(fc.surfaces.Cylinder(3.0), (0.93, 0.0, 1.0)), depth)


def ball_on_section(depth: float) -> ContactResult:
    mesh = fc.sections.rectangle((2.0, 1.0), (4, 4))
    body = fc.AxisymmetricBody(mesh, SOFT, contact="top", supports={"bottom": "xz"})
    return pressed(body, rigid(fc.Sphere(3.0), (0.0, 0.0, 1.0)), depth)


def ball_on_cells(depth: float) -> ContactResult:
    half = fc.HalfSpace(SOFT, size=(2.0, 2.0), cells=(16, 16))
    return pressed(half, rigid(fc.Sphere(2.0), (0.0, 0.0, 0.0)), depth)


def ball_on_window(depth: float) -> ContactResult:
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (4, 4, 3))
    body = fc.LocalBody(fc.ElasticBody(mesh, SOFT, supports={"bottom": "xyz"}), (2.0, 2.0, 2.0), 1.0, (8, 8))
    return pressed(body, rigid(fc.Sphere(2.0), (2.0, 2.0, 2.0)), depth)


def dome(element: str) -> fc.ElasticBody:
    """A body whose bottom is a dome of radius 5 about (0.4, 0.3)."""

    def bent(x: np.ndarray) -> np.ndarray:
        return x + np.array([0.0, 0.0, 0.1]) * ((x[:, :2] - [0.4, 0.3]) ** 2).sum(axis=1, keepdims=True)

    mesh = fc.shapes.block((0.8, 0.6, 0.5), (4, 4, 1), element=element).mapped(bent)
    return fc.ElasticBody(mesh, SOFT, contact="bottom", supports={"top": "xyz"}, name="dome")


def dome_on_block(depth: float, element: str = "hex8") -> ContactResult:
    return pressed(block(element=element), dome(element).placed((-0.13, -0.05, 1.0)), depth)


def first_step_of_a_path(depth: float) -> ContactResult:
    body, ball = block(), rigid(fc.Sphere(2.0), (0.27, 0.31, 1.0))
    scene = fc.Scene([body, ball], [fc.Contact(body, ball, friction=0.3)])
    return scene.solve_path([{"motions": {ball: {"z": -depth}}}]).steps[0]


SCENE = """
materials.soft = {{ E = 1.0, nu = 0.3 }}
contacts = [{{ slave = "block", master = "ball" }}]
[bodies.block]
shape = {{ kind = "block", size = [1.0, 1.0, 1.0], divisions = [2, 2, 2], element = "hex8" }}
material = "soft"
contact = "top"
supports = {{ bottom = "xyz" }}
[bodies.ball]
type = "rigid"
shape = {{ kind = "sphere", radius = 2.0 }}
pose = {{ translation = [0.27, 0.31, {height:.12f}] }}
"""


def scene_of_a_file(depth: float) -> ContactResult:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(SCENE.format(height=1.0 - depth), encoding="utf-8")
        return fc.read_scene(path).solve()


DOORS: dict[str, Callable[[float], ContactResult]] = {
    "hexahedra": lambda depth: ball_on(block(), depth),
    "27-node hexahedra": lambda depth: ball_on(block(element="hex27"), depth),
    "bricks": lambda depth: ball_on(block(fc.AncfBody), depth),
    "cone": lambda depth: pressed(block(), rigid(fc.surfaces.Cone(0.5), (0.27, 0.31, 1.0)), depth),
    "two meshes": dome_on_block,
    "two quadratic meshes": lambda depth: dome_on_block(depth, "hex20"),
    "plane": cylinder_on_plane,
    "axisymmetric": ball_on_section,
    "half-space": ball_on_cells,
    "local body": ball_on_window,
    "path": first_step_of_a_path,
    "scene file": scene_of_a_file,
}


@pytest.mark.by_day(
    "1e-08-half-space",
    "0.001-plane",
    "1e-08-hexahedra",
    "1e-05-plane",
    "0.001-scene file",
    "1e-08-27-node hexahedra",
    "1e-08-cone",
    "1e-08-axisymmetric",
    "1e-08-path",
    "1e-05-local body",
    "1e-05-two meshes",
)
@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("depth", [1e-8, 1e-5, 1e-3])
def test_bodies_that_overlap_carry_force_or_warn(door: str, depth: float) -> None:
    result = DOORS[door](depth)
    told = [text for text in result.warnings if "overlap by" in text]
    assert result.contacts[0].total_force > 0 or told
    if not result.contacts[0].total_force:
        assert "overlap" in result.message
        # between the depth itself and that along a cone's flank
        assert 0.85 * depth < result.contacts[0]._between_nodes.overlap.depth < 1.001 * depth


@pytest.mark.parametrize("door", DOORS)
def test_bodies_a_hair_apart_are_not_warned_of(door: str) -> None:
    result = DOORS[door](-1e-8)
    assert result.status == "no-contact"
    assert "overlap" not in result.message
    assert not result.warnings


def test_figures_of_the_warning_are_those_of_hertz() -> None:
    """R 2, depth 1e-4: force 4/3 E* sqrt(R) d^1.5; the cap's area 2 pi R d (Johnson 1985, section 4.2)."""
    found = ball_on(block(), 1e-4).contacts[0]._between_nodes.overlap
    assert abs(found.force / (4 / 3 * MODULUS * 2.0**0.5 * 1e-4**1.5) - 0.94) < 0.02  # 0.94 by its formula
    assert abs(found.width / (2 * np.pi * 2.0 * 1e-4) ** 0.5 - 1) < 0.02
    assert np.abs(found.points[0] - [0.27, 0.31, 1.0]).max() < 1e-6


def test_the_warning_has_place_figure_and_remedy() -> None:
    (text,) = ball_on(block(), 1e-4).warnings
    assert text == (
        "'block' and 'rigid' overlap by 0.0001 at (0.27, 0.31, 1), between nodes of a face of 'block' that carry no "
        "force: Hertz's formulas give about 1.9e-06 for it. The overlap is 0.035 wide: make faces there a third of it "
        "or solve with accuracy=0.05."
    )


@pytest.mark.parametrize(("recess", "told"), [(0.0, True), (0.004, True), (0.012, False)])
def test_a_peg_between_the_nodes_is_told_while_a_plate_presses_elsewhere(recess: float, told: bool) -> None:
    """A rigid plate and a peg of .06 within a face of .33, pushed in by .01: the peg by .01 less its recess."""

    def square(low: tuple[float, float], high: tuple[float, float], z: float) -> list[list[float]]:
        return [[x, y, z] for x, y in ((low[0], low[1]), (low[0], high[1]), (high[0], high[1]), (high[0], low[1]))]

    points = np.array(square((0.0, 0.0), (0.6, 2.0), 0.0) + square((1.45, 1.08), (1.51, 1.14), recess))
    shape = fc.surfaces.Facets(fc.SurfaceMesh(points, np.array([[0, 1, 2, 3], [4, 5, 6, 7]])))
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (6, 6, 2))
    body = fc.ElasticBody(mesh, SOFT, contact="top", supports={"bottom": "xyz"}, name="block")
    result = pressed(body, rigid(shape, (0.0, 0.0, 1.0)), 0.01)
    (contact,) = result.contacts
    found = contact._between_nodes.overlap
    assert contact.total_force > 0.01
    assert (found is not None) == any("overlap by" in text for text in result.warnings) == told
    if found is not None:
        # beside the plate the block rises, by a fiftieth of the plate's depth
        assert 0 < found.depth - (0.01 - recess) < 3e-4
        # on the peg, which the block's top has moved along by a tenth of the depth
        assert (np.abs(found.points[0, :2] - [1.48, 1.11]) < 0.03 + 1e-3).all()


@pytest.mark.full
def test_force_by_divided_meshes_is_continuous_in_the_depth() -> None:
    """Divided until the overlap is seen: forces near Hertz's at every depth, with room for meshes that stop early."""
    for depth in np.array([1e-3, 1.1e-3, 2e-3]):
        result = ball_on(block(n=4), depth, accuracy=0.2, max_dofs=2500)
        hertz = 4 / 3 * MODULUS * 2.0**0.5 * depth**1.5
        assert result.contacts[0]._between_nodes.overlap is None
        assert abs(result.contacts[0].total_force / hertz - 1) < 0.25


def test_accuracy_is_not_met_by_a_contact_that_no_node_sees() -> None:
    result = ball_on(block(), 1e-4, accuracy=0.05, max_dofs=100)
    assert not result.convergence.met
    assert result.convergence.steps[0].pressure == 1.0


def test_the_search_leaves_the_rim_of_what_is_opposite() -> None:
    """A slope that ends in nothing: the smallest gap is at the rim, where samples beside it see nothing."""

    def slope(facet: np.ndarray, local: np.ndarray) -> np.ndarray:
        return np.where(local[:, 0] < 0.71, np.inf, 0.1 * (local[:, 0] - 0.72))

    gap, local = smallest_gaps(slope, np.array([0]), np.array([False]), np.ones(1))
    assert abs(gap[0] + 0.001) < 1e-6
    assert abs(local[0, 0] - 0.71) < 1e-5


def test_a_joint_tells_of_a_light_touch_between_the_nodes() -> None:
    flat = fc.SurfaceMesh.of(fc.shapes.block((4.0, 4.0, 1.0), (5, 5, 1)), "top")
    bent = fc.shapes.block((4.0, 4.0, 1.0), (6, 6, 1)).mapped(
        lambda x: x - np.array([0.0, 0.0, 0.05]) * ((x[:, :2] - 2) ** 2).sum(axis=1, keepdims=True)
    )
    dome = fc.SurfaceMesh.of(bent, "top")
    joint = fc.Joint(flat.flipped(), dome, thickness=0.5, material=fc.Material(E=10.0, nu=0.45))
    (row,) = joint.follow([fc.Pose(translation=(0.1, 0.17, 1.0 - 1e-6))]).rows
    assert "overlap by 1e-06" in row["warnings"][0]


def wavy(amplitude: float) -> ContactResult:
    """A block pressed by 0.005 against a rigid wave with a crest at every node."""
    body = block(n=6)
    wave = fc.surfaces.FunctionSurface(lambda x, y: amplitude * (1 - np.cos(12 * np.pi * x)) + 0 * y, size=0.1)
    return pressed(body, rigid(wave, (0.0, 0.0, 1.0)), 0.005)


def test_a_wave_with_a_crest_at_every_node_is_seen() -> None:
    """Its pressure by Westergaard, pi E* A / lambda (Johnson 1985, section 13.2), over the root mean square found."""
    contact = wavy(1e-4).contacts[0]
    found = float(np.sqrt(np.mean(contact._between_nodes.unseen**2)))
    assert abs(found / (np.pi * MODULUS * 1e-4 * 6 / 2**0.5) - 1) < 0.15  # by 16 samples of a face
    assert contact.error_estimate.pressure > contact._unseen > 0.1
    (text,) = wavy(1e-4).warnings
    assert "the shape of 'rigid' varies between the nodes" in text


def test_a_flat_shape_and_a_round_one_hide_nothing() -> None:
    assert wavy(0.0).contacts[0]._unseen < 1e-9
    assert not wavy(0.0).warnings
    ball = pressed(block(n=6), rigid(fc.Sphere(1.0), (0.5, 0.5, 1.0)), 0.05).contacts[0]
    assert ball.active.sum() > 3
    assert ball._unseen < 0.03


def test_a_bump_between_the_nodes_is_divided_for() -> None:
    """Nodes see a flat plate; the bump's peak pressure is many times the mean."""
    bump = fc.surfaces.FunctionSurface(lambda x, y: -0.003 * np.exp(-((x - 0.58) ** 2 + (y - 0.58) ** 2) / 8e-4), 0.1)
    coarse = pressed(block(n=4), rigid(bump, (0.0, 0.0, 1.0)), 0.005)
    assert coarse.contacts[0].error_estimate.peak > 0.5
    fine = pressed(block(n=4), rigid(bump, (0.0, 0.0, 1.0)), 0.005, accuracy=0.15, max_dofs=4000)
    assert fine.contacts[0].max_pressure > 3 * coarse.contacts[0].max_pressure
