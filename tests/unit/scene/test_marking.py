"""Which faces and cells are divided, on a row of six faces of which two in the middle touch and two more end there."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

import fecontact as fc
from fecontact.common.error_estimate import ErrorEstimate
from fecontact.results.response_error import ResponseError
from fecontact.scene.adaptive import (
    AIM,
    BULK,
    SAFETY,
    Target,
    _divided,
    facets_opposite,
    marked_by_response,
    marked_cells,
    marked_facets,
)

PRESSURE = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0])
AT_EDGE = [1, 4]
FORCE = {"force": 0.01}


def row(error, misfit, peak=0.0, off=(), unseen=(), traction=None, sideways=()):
    """A contact with an error of its pressure, of its peak, and of its tractions, and where they come from."""
    smooth, beside = np.zeros((6, 1)), np.zeros(6)
    smooth[list(off)], beside[list(unseen)] = 0.5, 10.0
    readings = SimpleNamespace(
        facets=np.arange(6), misfit=np.array(misfit, dtype=float), smooth=smooth, interpolated=np.zeros((6, 1)),
        peak=2.0, peak_offset=2.0 * peak,
    )  # fmt: skip
    tractions = np.zeros(6)
    tractions[list(sideways)] = 1.0
    return SimpleNamespace(
        _readings=readings, _at_nodes=sp.identity(7, format="csr"), pressure=PRESSURE, weights=np.ones(7),
        point_area=3.0, max_pressure=1.0, facets=np.stack([np.arange(6), np.arange(1, 7)], axis=1),
        _facet_numbers=np.arange(6), _between_nodes=SimpleNamespace(unseen=beside),
        error_estimate=SimpleNamespace(pressure=error, traction=traction),
        _traction_misfit=None if traction is None else (tractions, None),
    )  # fmt: skip


def marked(tolerance=0.01, **options):
    return np.flatnonzero(marked_facets(row(**options), tolerance)).tolist()


def test_far_from_the_tolerance_all_faces_at_the_edge_are_divided():
    one = [0, 1, 0, 0, 0, 0]
    assert marked(error=0.5, misfit=one) == AT_EDGE
    # the share that halved faces must take off the square: 1 - (AIM tolerance / error)^2 = BULK (1 - 1 / 4)
    just = AIM * 0.01 / np.sqrt(1 - 0.75 * BULK)
    assert marked(error=1.001 * just, misfit=one) == AT_EDGE
    assert marked(error=0.999 * just, misfit=one) == [1]


def test_the_largest_errors_up_to_the_share_are_divided_with_their_equals():
    assert marked(error=0.0095, misfit=[0, 4, 3, 0, 4 * (1 - 1e-9), 0]) == [1, 4]
    assert marked(error=0.0095, misfit=[0, 4, 3, 0, 3.9, 0]) == [1]
    assert marked(error=0.011, misfit=[0, 4, 3, 0, 3.9, 0]) == [1, 4]


def test_faces_under_a_peak_that_is_off_are_divided_and_none_that_touch_in_part():
    given = {"error": 0.011, "misfit": [0, 1, 0, 0, 0, 0], "off": (0, 2, 4)}
    assert marked(**given, peak=0.011) == [1, 2]
    assert marked(**given, peak=0.0089) == [1]


def test_faces_whose_shape_hides_or_whose_tractions_are_off_are_divided():
    assert marked(error=0.011, misfit=[0, 1, 0, 0, 0, 0], unseen=(3,)) == [1, 3]
    assert marked(error=0.011, misfit=[0, 1, 0, 0, 0, 0], traction=0.5, sideways=(5,)) == [1, 5]
    assert marked(error=0.011, misfit=[0, 1, 0, 0, 0, 0], traction=0.0089, sideways=(5,)) == [1]


def test_cells_below_are_divided_where_they_keep_the_estimate_up():
    sides = [
        SimpleNamespace(error=np.array(e, dtype=float), cells=np.array(c)) for e, c in (([9, 0], [4, 7]), ([8], [2]))
    ]
    for interior, expected in ((0.0049, ([], [])), (0.0051, ([4], [2]))):
        contact = SimpleNamespace(error_estimate=SimpleNamespace(interior=interior, pressure=0.5), _energy_errors=sides)
        assert tuple(part.tolist() for part in marked_cells(contact, 0.01)) == expected


def test_cells_of_every_body_are_divided_by_their_parts_in_an_error_of_the_force():
    """Of either sign; those that take it from 1.1 times what is allowed to AIM of it, quartered."""
    parts = (np.array([0.1, -1.0]), np.zeros(0), np.array([0.2, 0.0]))
    assert [part.tolist() for part in marked_by_response(parts, 1.1)] == [[1], [], []]
    assert [part.tolist() for part in marked_by_response(parts, 5.0)] == [[1], [], [0]]


@pytest.mark.parametrize(
    ("force", "approach", "expected"),
    [
        (None, None, None),
        (0.02 / SAFETY, 0.5, None),
        (0.06 / SAFETY, None, ("force", 3.0)),
        (np.inf, None, None),
    ],
)
def test_what_is_asked_of_forces_and_motions(force, approach, expected):
    """Only what is asked for by name counts, and what has an estimate."""
    found = Target({"pressure": 0.05, "force": 0.02}).response(
        SimpleNamespace(response_error=replace(ResponseError(), force=force, approach=approach))
    )
    assert found == (expected and (expected[0], pytest.approx(expected[1])))
    assert Target(0.05).response(SimpleNamespace()) is None


def test_the_pressure_is_divided_for_as_far_as_peak_and_area_need_it():
    estimate = ErrorEstimate(0.04, 0.0, 0.0, 0.1, 0.02, 9.0)
    assert Target(0.05).pressure(estimate) == pytest.approx(0.05)
    assert Target({"peak": 0.05}).pressure(estimate) == pytest.approx(0.05 * 0.04 / 0.1)
    assert Target({"area": 0.05, "peak": 0.05}).pressure(estimate) == pytest.approx(0.02)
    assert Target({"force": 0.05}).pressure(estimate) is None


def block(n, at=0.0, **options):
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (n, n, 1), element="hex8").translated((0.0, 0.0, at))
    return fc.ElasticBody(mesh, fc.Material(1.0, 0.3), **options)


def test_faces_opposite_are_divided_too_unless_they_are_finer():
    """Opposite the first half of the slave, with faces of a quarter."""
    upper = block(4, contact="bottom", supports={"top": "xyz"}, name="upper")
    for n, expected in ((2, 0.5), (4, 0.5), (6, 0.0)):
        lower = block(n, at=-0.5, contact="top", supports={"bottom": "xyz"}, name="lower")
        contact = fc.Contact(upper, lower, swap="never", coupling="mortar")
        (interface,) = fc.Scene([upper, lower], [contact]).solve(motions={upper: {"z": -0.01}}).interfaces
        slave = interface.slave_surface
        half = np.flatnonzero(slave.points[slave.facets].mean(axis=1)[:, 0] < 0.5)
        found, master = facets_opposite(interface, half), lower.surface("top")
        assert len(found) == round(expected * n * n)
        assert (master.points[master.facets[found]].min(axis=1)[:, 0] < 0.5).all()
    floor = fc.RigidBody(fc.Plane(), name="floor")
    (interface,) = fc.Scene([upper, floor], [fc.Contact(upper, floor)]).solve(motions={upper: {"z": -0.01}}).interfaces
    assert len(facets_opposite(interface, np.arange(16))) == 0


def test_faces_and_cells_are_divided_at_once_where_both_errors_are_too_large():
    """A bent beam of linear cells under a ball: cells for the force alone, faces at the ball besides."""
    mesh = fc.shapes.block((8.0, 0.5, 1.0), (10, 1, 2), element="hex8")
    beam = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"x_min": "xyz", "y_min": "y"}, name="beam")
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball").placed((6.4, 0.0, 1.0))
    scene = fc.Scene([beam, ball], [fc.Contact(beam, ball)])
    result = scene.solve(motions={ball: {"z": -0.1}}, finite_motion=False)
    assert result.response_error.force > 0.01
    assert result.contacts[0].error_estimate.pressure > 0.02
    forces, both = (_divided(scene, result, Target(each), False) for each in (FORCE, FORCE | {"pressure": 0.02}))
    assert both.bodies[0].n_dofs > forces.bodies[0].n_dofs > beam.n_dofs
