"""Soft contact against closed forms: columns in series, Winkler's foundation, the hard limit; refusals."""

from __future__ import annotations

import numpy as np
import pytest
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


def test_scene_file(tmp_path) -> None:
    path = tmp_path / "soft.toml"
    path.write_text(
        """
        [bodies.block]
        type = "elastic"
        shape = {kind = "block", size = [1, 1, 1], divisions = [2, 2, 2]}
        material = "steel"
        contact = "bottom"
        supports = {top = "xyz"}
        [bodies.floor]
        type = "rigid"
        shape = {kind = "plane"}
        [materials.steel]
        E = 1000.0
        nu = 0.0
        [[contacts]]
        slave = "block"
        master = "floor"
        overclosure = {stiffness = 2000.0}
        [loads]
        motions.block = {z = -0.01}
        """,
        encoding="utf-8",
    )
    given = read_scene(path)
    assert abs(given.solve().contacts[0].max_pressure - DOWN / (1 / E + 1 / K)) <= 1e-12
    path.write_text(path.read_text(encoding="utf-8").replace("stiffness = 2000.0", "stiffness = 0"), encoding="utf-8")
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
