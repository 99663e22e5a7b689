"""What a result says of contacts that its faces do not resolve: overlap left, and pressures that may be off."""

import json
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import hertz
from fecontact.common.error_estimate import ErrorEstimate, UnboundedPeak
from fecontact.results.warnings import _cause, coarse_pressures, overlap_left, springs_at_nodes
from fecontact.surfaces import Cylinder, FunctionSurface

SOLID = fc.Material(E=1000.0, nu=0.3)
UNBOUNDED = UnboundedPeak("punch", (1.0, 0.0, 0.0), 0.5)


def crossed(push, element, cells=(4, 2, 2), coupling="mortar", scale=1.0):
    """Half cylinders of radius 1 crossed at right angles, pushed together by `push` from first touch."""
    mesh = fc.shapes.thick_ring(0.4, 1.0, 2.0, cells, sector="half", element=element).translated((0, 0, -1.0))
    mesh = mesh.scaled(scale)
    half = fc.ElasticBody(mesh, SOLID, "outer", {"sym_y": "xyz"})
    # the crown is at y = 1; one half is turned to look down, the other to look up and a right angle round
    upper = half.placed((0, 0, scale), fc.rotation_about((1, 0, 0), -np.pi / 2), name="upper")
    turn = fc.rotation_about((0, 0, 1), np.pi / 2) @ fc.rotation_about((1, 0, 0), np.pi / 2)
    lower = half.placed((0, 0, -scale), turn, name="lower")
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower, coupling=coupling)])
    return scene.solve(motions={upper: {"z": -push * scale}})


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_an_overlap_that_mortar_does_not_see_is_told_with_its_size(scale):
    """Source: geometry. Vertex on vertex, pushed by 0.05 of the radius: weighted gaps stay open."""
    result = crossed(0.05, "hex8", scale=scale)
    assert result.status == "no-contact"
    (text,) = overlap_left(result)
    assert text in result.warnings
    assert abs(float(text.split("overlap by ")[1].split(",")[0]) / (0.05 * scale) - 1) < 0.03  # along the mean normal
    assert "100 % of the approach, and no point" in text


@pytest.mark.full
def test_a_resolved_contact_leaves_none():
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=1.0, level=2)
    held = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    upper = fc.ElasticBody(mesh, SOLID, "cap", held, name="upper")
    coarser = fc.shapes.quarter_sphere(10.0, contact_radius=0.83, level=2)
    lower = fc.ElasticBody(coarser, SOLID, "cap", held, name="lower").placed(
        rotation=fc.rotation_about((1, 1, 0), np.pi)
    )
    result = fc.Scene([upper, lower], [fc.Contact(upper, lower)]).solve(forces={upper: (0, 0, -15.0)})
    assert result.contacts[0].coupling == "mortar"
    for check in (overlap_left, coarse_pressures):
        assert list(check(result)) == []


def ball(force):
    """On a floor, with rings for a contact radius of 1."""
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=1.0, level=1)
    body = fc.ElasticBody(mesh, SOLID, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"}, name="ball")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(forces={body: (0, 0, force)})


@pytest.mark.parametrize(("force", "words"), [(-1e-6, r"carried by \d points? only"), (-1.0, "may be off by about")])
def test_coarse_pressures_are_warned_of(force, words):
    """Loads so small that the contact is narrower than the rings that were made for a larger one."""
    result = ball(force)
    (text,) = coarse_pressures(result)
    assert text in result.warnings
    assert re.search(words, text)


def test_the_faces_across_are_those_of_the_diameter():
    """Source: counting. A rigid ball on an even grid: the diameter of the contact over the faces' size."""
    n = 24
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (n, n, 3), element="hex8").translated((-2, -2, -2))
    block = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="block")
    sphere = fc.RigidBody(fc.Sphere(4.0), name="ball")
    result = fc.Scene([block, sphere], [fc.Contact(block, sphere)]).solve(motions={sphere: {"z": -0.12}})
    contact = result.contacts[0]
    exact = hertz.spheres((4.0, np.inf), (None, SOLID), force=contact.total_force)
    # a block half as deep as wide is stiffer than a half-space and its contact a few percent narrower
    assert abs(contact.error_estimate.faces_across / (2 * exact.a * n / 4.0) - 1) < 0.1


def test_below_three_faces_across_peak_and_area_carry_no_figure():
    """Source: Hertz. On two faces the largest pressure is off by more than any share of the mean error tells."""
    result = ball(-0.5)
    (contact,) = result.contacts
    estimate = contact.error_estimate
    assert 1 < estimate.faces_across < 3
    assert math.isinf(estimate.peak)
    assert math.isinf(estimate.area)
    (line,) = (line for line in str(result).splitlines() if "error of pressure" in line)
    assert re.search(r"about \d+ % \(peak and area not resolved\), [\d.]+ faces across", line)
    told = json.loads(json.dumps(result.summary(), allow_nan=False))["contacts"][0]["error_estimate"]
    assert (told["peak"], told["area"], told["resolved"]) == (None, None, False)
    (text,) = coarse_pressures(result)
    assert "its peak and area are not resolved" in text
    assert text.endswith("Refine the faces there or solve with accuracy=0.05.")
    assert "not resolved" not in str(ball(-15.0).contacts[0].error_estimate)


@pytest.mark.parametrize("part", ["pressure", "peak", "area"])
def test_any_of_the_three_figures_is_warned_of(part):
    """Each by itself above a tenth; a peak without bound is not one."""
    estimate = replace(ErrorEstimate(0.05, 0.0, 0.0, 0.05, 0.05, 5.0), **{part: 0.2})
    body, active = SimpleNamespace(name="body"), np.array([True, False, True, True, True])
    contact = SimpleNamespace(slave=body, master=body, active=active, error_estimate=estimate, _unseen=0.0)
    contact._surface = SimpleNamespace(of_nodes=False)
    result = SimpleNamespace(contacts=[contact], _elastic_bodies=(), finite_strain=None)
    (text,) = coarse_pressures(result)
    assert "20 %" in text
    contact.error_estimate = replace(estimate, pressure=0.05, area=0.05, peak=math.inf, unbounded=UNBOUNDED)
    assert list(coarse_pressures(result)) == []


def test_whole_faces_in_contact_are_not_noted():
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), SOLID, "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    assert list(coarse_pressures(result)) == []
    # as wide as its faces, few as they are
    assert result.contacts[0].error_estimate.resolved


@pytest.mark.parametrize("ring", [False, True])
def test_sections_are_counted_along_their_line(ring):
    """Source: counting. Sides in contact with a roll or ball; a ring's count on both sides of the axis."""
    mesh = fc.sections.rectangle((2.0, 2.0), (12, 4))
    mesh = mesh.translated((0.0 if ring else -1.0, 0.0, -2.0))
    body = (fc.AxisymmetricBody if ring else fc.PlaneBody)(mesh, SOLID, "top", {"bottom": "xz"})
    round_shape = fc.RigidBody(fc.Sphere(4.0) if ring else Cylinder(4.0))
    result = fc.Scene([body, round_shape], [fc.Contact(body, round_shape)]).solve(motions={round_shape: {"z": -0.02}})
    contact = result.contacts[0]
    x = contact.points[contact.active][:, 0]
    # the contact ends half a point beyond the last ones, a quarter of a side
    n = ((2 * x.max() if ring else np.ptp(x)) / (2.0 / 12)) + 0.5
    assert abs(contact.error_estimate.faces_across - n) < 1.0


def test_the_cause_of_the_error_is_named():
    """Which of the three parts is the largest decides what is advised."""
    said = {
        part: _cause(replace(ErrorEstimate(0.2, 0.0, 0.0, 0.1, 0.1, 5.0), **{part: 0.19}), " or so")
        for part in ("geometry", "interior")
    }
    assert "kinks" in said["geometry"]
    assert "elements below" in said["interior"]
    assert "5 faces across" in _cause(ErrorEstimate(0.2, 0.1, 0.1, 0.1, 0.1, 5.0), " or so")


def test_solving_to_an_accuracy_is_advised_where_there_are_elements_to_divide():
    (text,) = coarse_pressures(ball(-1.0))
    assert "or solve with accuracy=0.05" in text
    half = fc.HalfSpace(SOLID, size=(1.0, 1.0), cells=(24, 24))
    indenter = fc.RigidBody(fc.Sphere(10.0)).placed((0, 0, 0))
    result = fc.Scene([half, indenter], [fc.Contact(half, indenter)]).solve(forces={indenter: (0, 0, -0.05)})
    (text,) = coarse_pressures(result)
    assert "Refine the faces there." in text


def test_of_many_equal_regions_one_is_counted():
    """Source: counting. 25 equal bumps with a twenty-fifth of the force each, half a period of eight faces wide."""
    mesh = fc.shapes.block((5.0, 5.0, 0.1), (40, 40, 1), element="hex8").translated((-2.5, -2.5, -0.1))
    springs = fc.ElasticLayer(SOLID, thickness=0.5, surface=(mesh, "top"))
    waves = FunctionSurface(lambda x, y: 2 - np.cos(2 * np.pi * x) - np.cos(2 * np.pi * y))
    comb = fc.RigidBody(waves, name="comb")
    contact = fc.Scene([springs, comb], [fc.Contact(springs, comb)]).solve(motions={comb: {"z": -1.0}}).contacts[0]
    assert len(contact.regions) == 25
    assert 2.5 < contact.error_estimate.faces_across < 4.0


@pytest.mark.parametrize(("later", "narrow"), [(0.0, True), (0.0195, False)])
def test_the_narrowest_region_counts_that_carries_a_twentieth_of_the_force(later, narrow):
    """Source: counting. Two rollers on a row of faces of 0.1, one ten times as sharp, which may touch later."""
    rollers = FunctionSurface(lambda x, y: np.minimum((x - 1) ** 2 / 8, later + (x - 3) ** 2 / 0.8) + 0 * y, 4.0)
    mesh = fc.sections.rectangle((4.0, 2.0), (40, 10))
    body = fc.PlaneBody(mesh, SOLID, "top", {"bottom": "xz"})
    rigid = fc.RigidBody(rollers).placed((0, 0, 2.0))
    contact = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -0.02}}).contacts[0]
    share = contact.forces[contact.points[:, 0] > 2].sum() / contact.forces.sum()
    assert share > 0
    assert bool(share > 0.05) is narrow
    assert contact.error_estimate.faces_across == pytest.approx(1.0 if narrow else 4.8, abs=0.3)


@pytest.mark.parametrize(("element", "n"), [("hex8", 4), ("hex20", 4), ("hex8", 16)])
def test_a_layer_of_springs_under_a_tilted_plate(element, n):
    """Source: k tilt / 12 of a square; springs at the nodes of n linear faces resist by 1 + 2 / n^2 more."""
    mesh = fc.shapes.block((1.0, 1.0, 0.1), (n, n, 1), element=element).translated((-0.5, -0.5, -0.1))
    layer = fc.ElasticLayer(fc.Material(50.0, 0.0), 0.5, surface=(mesh, "top"))
    plate = fc.RigidBody(fc.Plane()).placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    tilted = fc.Scene([layer, plate], [fc.Contact(layer, plate)]).solve(motions={plate: {"z": -0.01, "ry": 1e-3}})
    exact = 100.0 * 1e-3 / 12
    excess = np.abs(tilted.contacts[0].moment).max() / exact - 1
    assert abs(excess - (2 / n**2 if element == "hex8" else 0.0)) < 1e-9
    told = list(springs_at_nodes(tilted))
    assert len(told) == (excess > 0.01)
    assert all(re.search("may be 1[23] % too large", text) and text in tilted.warnings for text in told)
