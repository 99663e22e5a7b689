"""Soft contact against closed forms: columns in series, Winkler's foundation, the hard limit; refusals."""

from __future__ import annotations

import numpy as np
import pytest
from common_scenes import BLOCK_ON_FLOOR
from refusals import refused

import fecontact as fc
from fecontact import read_scene

E, K, DOWN = 1000.0, 2000.0, 0.01


def stacked(n: int = 2, mu: float = 0.0, k: float | None = K, size: float = 1.0, unit: float = 1.0, **options):
    """Two unit blocks, free to spread, the lower one with n cells across; in other units of length and stress."""
    overclosure = None if k is None else fc.SoftContact(k * unit / size)
    upper = fc.shapes.block((size, size, size), (2, 2, 2)).translated((0, 0, size))
    a = fc.ElasticBody(upper, fc.Material(E * unit, 0.0), "bottom", {"top": "xyz"}, name="upper")
    lower = fc.shapes.block((size, size, size), (n, n, 2))
    b = fc.ElasticBody(lower, fc.Material(2 * E * unit, 0.0), "top", {"bottom": "xyz"}, name="lower")
    return fc.Scene([a, b], [fc.Contact(a, b, friction=mu, overclosure=overclosure, **options)]), a


@pytest.mark.parametrize(("n", "coupling"), [(2, "nodal"), (3, "mortar")])
@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("gap", [0.0, 0.004])
def test_columns_and_layer_in_series(n: int, coupling: str, mu: float, gap: float) -> None:
    """u - gap = p (1 / E + 1 / 2 E + 1 / k), to rounding, on meshes that match or do not."""
    scene, upper = stacked(n, mu)
    moved = upper.placed((0, 0, gap))
    scene = fc.Scene([moved, scene.bodies[1]], [fc.Contact(moved, scene.bodies[1], overclosure=fc.SoftContact(K))])
    result = scene.solve(motions={moved: {"z": -DOWN}})
    (contact,) = result.contacts
    p = (DOWN - gap) / (1 / E + 1 / (2 * E) + 1 / K)
    assert contact.coupling == coupling
    assert np.abs(contact.pressure - p).max() <= 1e-12 * p
    assert np.abs(contact.overclosure - p / K).max() <= 1e-12 * p / K
    assert np.abs(contact.gap + contact.overclosure).max() <= 1e-14  # of lengths of 1
    assert result.residuals().worst <= 1e-10
    assert result.warnings == ()
    assert abs(result.summary()["contacts"][0]["max_overclosure"] - p / K) <= 1e-12 * p / K
    assert "overclosure, largest" in str(result)


#: Stiffening and softening; one that acts before surfaces meet; an exponential one.
LAWS = {
    "stiffening": fc.SoftContact([(0.0, 0.0), (1e-3, 0.5), (2e-3, 2.0), (3e-3, 5.0)]),
    "softening": fc.SoftContact([(0.0, 0.0), (1e-3, 3.0), (5e-3, 4.0)]),
    "early": fc.SoftContact([(-5e-3, 0.0), (0.0, 1.0), (1e-3, 4.0)]),
    "exponential": fc.SoftContact.exponential(5e-3, 0.5),
}


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize(("n", "coupling"), [(2, "nodal"), (3, "mortar")])
@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("law", list(LAWS))
def test_columns_and_a_table_in_series(n: int, coupling: str, mu: float, law: str) -> None:
    """u - d(p) = p (1 / E + 1 / 2 E): the overlap d interpolated in the table, or the logarithm, by bisection."""
    soft = LAWS[law]
    scene, upper = stacked(n, mu)
    scene = fc.Scene([upper, scene.bodies[1]], [fc.Contact(upper, scene.bodies[1], friction=mu, overclosure=soft)])
    result = scene.solve(motions={upper: {"z": -DOWN}})
    (contact,) = result.contacts
    rows = None if law == "exponential" else np.array(soft.stiffness)

    def overlap(p: float) -> float:
        if rows is None:
            return 5e-3 * np.log(p / 0.5) / np.log(100)
        end = (rows[-1, 0] - rows[-2, 0]) / (rows[-1, 1] - rows[-2, 1]) * (p - rows[-1, 1])
        return float(np.interp(p, rows[:, 1], rows[:, 0]) + max(0.0, end))

    low, high = 1e-9, 20.0
    for _ in range(200):
        p = (low + high) / 2
        low, high = (p, high) if overlap(p) + p * 1.5 / E < DOWN else (low, p)
    assert contact.coupling == coupling
    exact = 1e-3 if law == "exponential" else 1e-10  # its table
    assert np.abs(contact.pressure - p).max() <= exact * p
    assert np.abs(contact.overclosure - overlap(p)).max() <= exact * DOWN
    assert np.abs(contact.gap + contact.overclosure).max() <= 1e-13
    assert result.residuals().worst <= 1e-10


def test_a_law_that_acts_before_surfaces_meet() -> None:
    """At a distance of 2e-3 the table has 0.6: blocks that are held apart by it push each other off."""
    scene, upper = stacked(2)
    apart = upper.placed((0, 0, 2e-3))
    scene = fc.Scene([apart, scene.bodies[1]], [fc.Contact(apart, scene.bodies[1], overclosure=LAWS["early"])])
    (contact,) = scene.solve(finite_motion=False).contacts
    p = 3e-3 / (1.5 / E + 5e-3)
    assert np.abs(contact.pressure - p).max() <= 1e-10 * p
    assert (contact.gap > 0).all()


def test_a_table_of_one_line_is_a_stiffness() -> None:
    found = []
    for law in (K, [(0.0, 0.0), (1e-3, 1e-3 * K)], [(0.0, 0.0), (1e-3, 1e-3 * K), (4e-3, 4e-3 * K)]):
        scene, upper = stacked(3)
        contact = fc.Contact(upper, scene.bodies[1], overclosure=fc.SoftContact(law))
        found.append(fc.Scene(scene.bodies, [contact]).solve(motions={upper: {"z": -DOWN}}).contacts[0].pressure)
    for other in found[1:]:
        assert np.abs(other - found[0]).max() <= 1e-10 * found[0].max()


@pytest.mark.parametrize(
    "table", [[(0.0, 1.0), (1.0, 2.0)], [(0.0, 0.0), (1.0, 0.0)], [(0.0, 0.0)], [(0.0, 0.0), (0.0, 1.0)], [1.0, 2.0]]
)
def test_tables_that_do_not_grow_are_refused(table) -> None:
    with refused(fc.InputError, "soft-contact-table", "both growing"):
        fc.SoftContact(table)


def test_paraboloid_on_a_foundation() -> None:
    """p = k (d - r^2 / 2 R), P = pi k R d^2, area 2 pi R d (Johnson 1985, 4.3): a body that hardly gives."""
    radius, depth, k = 10.0, 0.1, 10.0
    mesh = fc.shapes.block((4.0, 4.0, 0.5), (16, 16, 1)).translated((-2, -2, -0.5))
    body = fc.ElasticBody(mesh, fc.Material(1e9, 0.0), "top", {"bottom": "xyz"})
    ball = fc.RigidBody(fc.surfaces.Paraboloid(radius, radius))
    scene = fc.Scene([body, ball], [fc.Contact(body, ball, overclosure=fc.SoftContact(k))])
    result = scene.solve(motions={ball: {"z": -depth}})
    (contact,) = result.contacts
    assert abs(contact.max_pressure / (k * depth) - 1) <= 1e-7  # the body gives 1e-8 of the layer
    # faces of a ninth of the radius: their edge is located within them
    assert abs(contact.total_force / (np.pi * k * radius * depth**2) - 1) <= 0.01
    assert abs(contact.outline.area / (2 * np.pi * radius * depth) - 1) <= 0.02
    squares = (contact.points[:, :2] ** 2).sum(axis=1)
    exact = k * np.maximum(depth - squares / (2 * radius), 0.0)
    # gaps are along normals, which turn by up to a / R = .14: half its square of the depth
    assert np.abs(contact.pressure - exact).max() <= 0.01 * k * depth
    assert result.warnings == ()


def hertz(k: float | None, scale: float = 1.0, turn: float = 0.0) -> fc.ContactResult:
    """A ball on a block, soft or hard."""
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (10, 10, 4)).translated((-2, -2, -2)).scaled(scale)
    rotation = fc.rotation_about((1, 2, 3), turn)
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"bottom": "xyz"}).placed(rotation=rotation)
    ball = fc.RigidBody(fc.Sphere(8.0 * scale)).placed(rotation=rotation)
    law = None if k is None else fc.SoftContact(k / scale)
    scene = fc.Scene([body, ball], [fc.Contact(body, ball, overclosure=law)])
    return scene.solve(forces={ball: rotation @ (0, 0, -0.02 * scale**2)})


def test_hard_contact_is_the_limit_and_softer_ones_are_wider_and_lower() -> None:
    hard, stiff, soft = hertz(None).contacts[0], hertz(1e9).contacts[0], hertz(0.5).contacts[0]
    # a layer of 1e-9 of the body's compliance
    assert np.abs(stiff.pressure - hard.pressure).max() <= 1e-7 * hard.max_pressure
    assert hard.overclosure is None
    assert np.count_nonzero(soft.active) > np.count_nonzero(hard.active)
    assert soft.max_pressure < 0.8 * hard.max_pressure
    assert np.abs(soft.overclosure - soft.pressure / 0.5).max() <= 1e-12


@pytest.mark.parametrize(("scale", "turn"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 0.7)])
def test_units_and_turns_change_nothing(scale: float, turn: float) -> None:
    one, other = hertz(0.5).contacts[0], hertz(0.5, scale, turn).contacts[0]
    assert np.abs(one.pressure - other.pressure).max() <= 1e-9 * one.max_pressure
    assert np.abs(one.overclosure - other.overclosure / scale).max() <= 1e-9 * one.overclosure.max()


def test_friction_is_that_of_the_soft_pressure() -> None:
    """A block that slides: mu times p = u / (1 / E + 1 / k)."""
    block = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), fc.Material(E, 0.0), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.1, overclosure=fc.SoftContact(K))])
    path = scene.solve_path([{"motions": {block: {"z": -DOWN, "x": x}}} for x in (0.0, 0.05)])
    force = DOWN / (1 / E + 1 / K)
    assert abs(path.forces[1, 0, 0] + 0.1 * force) <= 1e-9 * force
    assert abs(path.forces[1, 0, 2] - force) <= 1e-9 * force


def test_plane_sections() -> None:
    mesh = fc.sections.rectangle((1.0, 1.0), (4, 4))
    block = fc.PlaneBody(mesh, fc.Material(E, 0.0), "bottom", {"top": "xz"}, thickness=3.0)
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, overclosure=fc.SoftContact(K))])
    (contact,) = scene.solve(motions={block: {"z": -DOWN}}).contacts
    p = DOWN / (1 / E + 1 / K)
    assert np.abs(contact.pressure - p).max() <= 1e-12 * p
    assert abs(contact.total_force - 3 * p) <= 1e-11 * p


def test_scene_file(written) -> None:
    steel = BLOCK_ON_FLOOR.replace("E = 1.0", f"E = {E}")
    path = written(f"{steel}overclosure = {{stiffness = {K}}}\n[loads]\nmotions.block = {{z = {-DOWN}}}\n")
    given = read_scene(path)
    assert abs(given.solve().contacts[0].max_pressure - DOWN / (1 / E + 1 / K)) <= 1e-12
    text = path.read_text(encoding="utf-8")
    for key, law in (
        ("stiffness = [[0, 0], [0.002, 1.0], [0.01, 25.0]]", fc.SoftContact([(0, 0), (0.002, 1.0), (0.01, 25.0)])),
        ("clearance = 0.004, pressure = 1.5", fc.SoftContact.exponential(0.004, 1.5)),
    ):
        path.write_text(text.replace(f"stiffness = {K}", key), encoding="utf-8")
        p = read_scene(path).solve().contacts[0].max_pressure
        # a column in series with the law
        assert abs(p / E + law.overclosure(np.array([p]))[0] - DOWN) <= 1e-12
    for fault in ("stiffness = 0", "stiffness = [[0, 0], [0.1, 0]]", "stiffness = ['soft']", "clearance = 0.1", ""):
        path.write_text(text.replace(f"stiffness = {K}", fault), encoding="utf-8")
        with refused(fc.InputError, "scene-file", "overclosure"):
            read_scene(path)


def test_refusals() -> None:
    for stiffness in (0.0, -1.0, np.inf, np.nan, "soft"):
        with refused(fc.InputError, "not-positive"):
            fc.SoftContact(stiffness)
    with refused(fc.InputError, "wrong-class", "SoftContact"):
        fc.Contact(*stacked()[0].bodies, overclosure=5.0)
    scene, upper = stacked(mu=0.3)
    motions = {"motions": {upper: {"z": -DOWN}}}
    with refused(fc.InputError, "soft-contact", "accuracy"):
        scene.solve(**motions, accuracy=0.1)
    with refused(fc.InputError, "wear-alone", "soft"):
        scene.solve_path([motions], wear={scene.contacts[0]: 1e-3})
    with refused(fc.InputError, "petsc-cannot", "soft"):
        stacked()[0].solve(**motions, engine="petsc")
    law = fc.SoftContact(K)
    half = fc.HalfSpace(fc.Material(E, 0.3), (1.0, 1.0), (4, 4))
    ball = fc.RigidBody(fc.Sphere(1.0))
    with refused(fc.InputError, "soft-contact-body", "half-space"):
        fc.Contact(half, ball, overclosure=law)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    rubber = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.3), "top", {"bottom": "xyz"})
    with refused(fc.InputError, "soft-contact-body", "finite strain"):
        fc.Contact(rubber, ball, overclosure=law)
