"""Outlines of contacts: circles, rings, several regions, planes of symmetry, ends of surfaces and divided meshes."""

import math
from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import hertz
from fecontact.bodies import PlaneBody
from fecontact.mesh import section_shapes
from fecontact.results.contact_outline import Mirror, _loops, contact_outline, smoothed
from fecontact.surfaces import Cylinder, Paraboloid, Torus

SOFT = fc.Material(E=1.0, nu=0.3)
MODULUS = SOFT.plane_strain_modulus
RADIUS, CONTACT, SIZE = 10.0, 0.5, 10.0


def graded(step: float, core: float = 0.65) -> np.ndarray:
    """Positions of one step up to a length, then growing to the size of the block."""
    x = list(np.arange(0.0, core, step))
    while x[-1] < SIZE / 1.6:
        x.append(1.6 * x[-1])
    return np.array([*x, SIZE])


def quarter(element: str, step: float, unit: float = 1.0, **options) -> fc.ContactResult:
    """A quarter of a block on a rigid ball, Hertz's contact radius 0.5 units."""
    x, z = graded(step), graded(step, 0.3)
    mesh = fc.shapes.block((SIZE,) * 3, (x, x, z), element=element).mapped(lambda p: unit * p)
    held = {"top": "xyz", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, fc.Material(E=1.0 / unit**2, nu=0.3), "bottom", held, name="block")
    ball = fc.RigidBody(Paraboloid(unit * RADIUS)).placed(rotation=fc.rotation_about((1, 0, 0), math.pi))
    force = 4 * MODULUS * CONTACT**3 / (3 * RADIUS)
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    return scene.solve(forces={body: (0, 0, -force / 4)}, **options)


def radii(contact) -> np.ndarray:
    """Distances of the points of the edge from the axis."""
    (curve,) = contact.outline.curves
    # the last point of a stretch belongs to the segment after it
    edge = curve.is_edge | np.roll(curve.is_edge, 1)
    return np.linalg.norm(curve.points[edge][:, :2], axis=1)


def exact(points: np.ndarray) -> np.ndarray:
    """Hertz's pressure."""
    r2 = (points[:, :2] ** 2).sum(axis=1) / CONTACT**2
    return 2 * MODULUS * CONTACT / (math.pi * RADIUS) * np.sqrt(np.maximum(1 - r2, 0))


# four faces a radius, of which none ends at the edge; the bounds are twice what is found
@pytest.mark.by_day("hex8-0.05-0.03")
@pytest.mark.parametrize(("element", "area", "off"), [("hex20", 0.02, 0.01), ("hex8", 0.05, 0.03)])
def test_circle_of_hertz(element, area, off):
    contact = quarter(element, 0.125).contacts[0]
    assert abs(contact._whole.area / (math.pi * CONTACT**2 / 4) - 1) < area
    assert abs(radii(contact) / CONTACT - 1).max() < off
    (curve,) = contact.outline.curves
    # the curve, seen along the axis, and the facets have one area but for the smoothing
    assert abs(curve.area / contact._whole.area - 1) < 2e-3
    points, nodal, areas = contact.sampled(contact.pressure, 8)
    error, own = (np.sqrt(areas @ (p - exact(points)) ** 2) for p in (contact.recovered.sampled(8)[1], nodal))
    assert error < 0.6 * own  # found: 0.3 and 0.5 times


def test_divided_mesh_has_one_closed_curve():
    contact = quarter("hex8", 0.25, accuracy=0.05).contacts[0]
    assert contact._surface.hanging is not None
    assert abs(contact._whole.area / (math.pi * CONTACT**2 / 4) - 1) < 5e-3
    assert abs(radii(contact) / CONTACT - 1).max() < 5e-3


@pytest.mark.full
def test_outline_scales_with_the_model():
    one, two = (quarter("hex20", 0.25, unit).contacts[0].outline for unit in (1.0, 1e-3))
    assert np.abs(1e3 * two.curves[0].points - one.curves[0].points).max() < 1e-9
    assert abs(1e6 * two.area / one.area - 1) < 1e-9


def test_ring_has_a_hole():
    mesh = fc.shapes.block((3.2, 3.2, 1.0), (22, 22, 2)).translated((-1.6, -1.6, -1.0))
    body = fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz"})
    torus = fc.RigidBody(Torus(1.0, 0.9))
    contact = fc.Scene([body, torus], [fc.Contact(body, torus)]).solve(motions={torus: {"z": -0.05}}).contacts[0]
    outer, hole = contact.outline.curves
    assert outer.area > 0 > hole.area
    assert outer.is_edge.all()
    assert hole.is_edge.all()
    assert abs((outer.area + hole.area) / contact._whole.area - 1) < 5e-3
    for curve in (outer, hole):
        radius = np.linalg.norm(curve.points[:, :2], axis=1)
        assert np.ptp(radius) < 0.02 * radius.mean()  # a sixth of a face
    # against itself on the same mesh turned by 45 degrees below the torus
    turned = body.placed(rotation=fc.rotation_about((0, 0, 1), np.pi / 4))
    other = fc.Scene([turned, torus], [fc.Contact(turned, torus)]).solve(motions={torus: {"z": -0.05}}).contacts[0]
    assert abs(other._whole.area / contact._whole.area - 1) < 0.01


def punched(swap: str) -> fc.ContactResult:
    """A block below a punch with sharp edges, 1.7 by 1.7."""
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (13, 13, 3)).translated((-2.0, -2.0, -2.0))
    block = fc.ElasticBody(mesh, SOFT, "top", {"bottom": "xyz"}, name="block")
    end = fc.shapes.block((1.7, 1.7, 1.0), (6, 6, 2)).translated((-0.85, -0.85, 0.0))
    punch = fc.ElasticBody(end, SOFT, "bottom", {"top": "xyz"}, name="punch")
    return fc.Scene([block, punch], [fc.Contact(block, punch, swap=swap)]).solve(motions={punch: {"z": -0.03}})


@pytest.mark.by_day("never")
@pytest.mark.parametrize("swap", ["auto", "never"])
def test_sharp_punch_has_its_own_outline(swap):
    """Source: the punch's end, a square, whichever body has the contact points."""
    contact = punched(swap).contacts[0]
    (curve,) = contact.outline.curves
    assert not curve.is_edge.any()
    assert abs(contact._whole.area / 1.7**2 - 1) < 1e-5  # halvings of a face to 1e-6
    assert abs(np.abs(curve.points[:, :2]).max(axis=1) - 0.85).max() < 1e-5


def test_section_against_hertz():
    force = math.pi * MODULUS * CONTACT**2 / (4 * RADIUS)
    far = 160 * CONTACT
    x = np.concatenate([np.arange(0, 0.7, 0.125), np.geomspace(0.8, far, 14)])
    z = np.concatenate([np.arange(0, 0.35, 0.125), np.geomspace(0.5, far, 14)])
    mesh = section_shapes.rectangle((far, far), (x, z), names=("sx", "side", "cap", "base"), element="quad8")
    body = PlaneBody(mesh, SOFT, "cap", {"base": "z", "sx": "x"}, name="body")
    rigid = fc.RigidBody(Cylinder(RADIUS)).placed(rotation=fc.rotation_about((1, 0, 0), math.pi))
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, force / 2)})
    exact = hertz.line((RADIUS, math.inf), (None, SOFT), force=force).a
    assert abs(exact / CONTACT - 1) < 1e-12
    assert abs(result.contacts[0]._whole.area / exact - 1) < 0.01
    assert result.contacts[0].outline.curves == ()


def test_foundation_ends_where_the_ball_leaves_its_plane():
    """Source: springs under a paraboloid touch out to the radius sqrt(2 R d)."""
    plate = fc.shapes.block((2.0, 2.0, 0.1), (14, 14, 1), element="hex8").translated((-1.0, -1.0, -0.1))
    layer = fc.ElasticLayer(SOFT, thickness=0.1, surface=(plate, "top"), law="bonded")
    ball = fc.RigidBody(Paraboloid(RADIUS))
    result = fc.Scene([layer, ball], [fc.Contact(layer, ball)]).solve(motions={ball: {"z": -0.0125}})
    assert abs(result.contacts[0]._whole.area / (math.pi * 0.25) - 1) < 5e-3


def test_thin_layer_is_read_like_springs():
    """Source: springs; a layer's radius is larger by a part of its thickness, here 4 % of the radius."""
    mesh = fc.shapes.block((1.0, 1.0, 0.02), (7, 7, 2))
    held = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.2), "top", held)
    ball = fc.RigidBody(Paraboloid(RADIUS)).placed((0, 0, 0.02))
    contact = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.0125}}).contacts[0]
    assert abs(contact._whole.area / (math.pi * 0.25 / 4) - 1) < 0.04


def test_recovered_pressure_of_a_uniform_contact_is_its_own():
    """Source: a patch test, whose pressure lies in every polynomial, and ends with the body, not as a square root."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (5, 5, 2))
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.0), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    contact = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}}).contacts[0]
    assert np.abs(contact.recovered.sampled()[1] / 0.01 - 1).max() < 1e-9
    assert not contact.recovered.cut.any()


def test_pressure_of_few_faces_or_at_a_sharp_edge_is_kept():
    few = quarter("hex20", 0.25).contacts[0]
    assert few.error_estimate.faces_across < 4
    assert np.array_equal(few.recovered.pressure, few._at_nodes @ few.pressure)
    contact = punched("auto").contacts[0]
    edge = contact._at_nodes @ contact._singular_edge.points > 0
    assert edge.any()
    assert np.array_equal(contact.recovered.pressure[edge], (contact._at_nodes @ contact.pressure)[edge])


def test_smoothing_keeps_ends_and_mirror_images():
    t = np.linspace(0, np.pi / 2, 40)
    rough = 1 + 0.02 * np.cos(20 * t)
    arc = np.stack([rough * np.cos(t), rough * np.sin(t), 0 * t], axis=1)
    points = np.concatenate([arc, [[0.0, 0.0, 0.0]]])
    smooth = np.append(np.ones(39, bool), [False, False])
    mirrors = (Mirror(np.zeros(3), np.array([1.0, 0, 0])), Mirror(np.zeros(3), np.array([0, 1.0, 0])))
    found, kept = smoothed(points, smooth, np.full(41, 0.25), mirrors)
    edge = found[kept]
    assert abs(np.linalg.norm(edge, axis=1) - 1).max() < 2e-3
    assert edge[0, 1] == pytest.approx(0, abs=1e-5)  # on the plane, where its image meets it
    held, kept = smoothed(points, smooth, np.full(41, 0.25))
    assert np.abs(held[kept][0] - arc[0]).max() < 1e-5  # without planes the ends stay


def test_loops_follow_every_segment_once():
    start, end = np.array([4, 0, 2, 1, 7, 8, 3]), np.array([0, 2, 1, 4, 8, 3, 7])
    loops = [start[chosen].tolist() for chosen in _loops(start, end)]
    assert sorted(map(sorted, loops)) == [[0, 1, 2, 4], [3, 7, 8]]
    assert all(np.array_equal(end[c], np.roll(start[c], -1)) for c in _loops(start, end))
    assert _loops(start[:0], end[:0]) == []


@pytest.mark.parametrize(("force", "across", "located"), [(0.001, 1.7, False), (0.01, 2.9, True)])
def test_no_edge_is_located_on_fewer_than_two_faces(force, across, located):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 4)).translated((-0.5, -0.5, -1.0))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
    ball = fc.RigidBody(fc.Sphere(1.0)).placed((0.02, 0.013, 0.0))
    (contact,) = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(forces={ball: (0, 0, -force)}).contacts
    assert abs(contact.error_estimate.faces_across - across) <= 0.1
    assert abs(contact._whole.area / (contact.outline.area if located else contact.area) - 1) < 1e-12
    # a block of 20 x 20 faces, where both have seven or three faces across
    fine = {0.001: 0.0232, 0.01: 0.1088}[force]
    assert abs(contact._whole.area / fine - 1) <= (0.01 if located else 0.3)
    if not located:  # what the outline would have been: two thirds of it
        assert abs(contact.outline.area / fine - 1) > 0.3


@pytest.mark.parametrize(("element", "pressure"), [("hex8", "midface"), ("hex20", "nodal"), ("hex20", "midface")])
def test_outline_does_not_depend_on_the_first_node_of_a_face(element, pressure):
    """Faces of four, eight and nine nodes, each from its second corner on; of three and a half faces."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 7, 2), element=element).translated((-0.5, -0.5, -1.0))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"}, pressure=pressure)
    ball = fc.RigidBody(fc.Sphere(1.0)).placed((0.05, 0.02, 0.0))
    (contact,) = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(forces={ball: (0, 0, -0.015)}).contacts
    assert contact.facets.shape[1] == (4 if element == "hex8" else 8 if pressure == "nodal" else 9)
    around = [np.roll(part, 1, axis=1) for part in np.split(contact.facets, [4, 8], axis=1)]
    turned = contact_outline(replace(contact, facets=np.concatenate(around, axis=1)))
    assert np.abs(turned.areas - contact.outline.areas).max() < 1e-12 * contact.outline.area
