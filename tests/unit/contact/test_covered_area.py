"""Overlaps that end within faces: force over covered area, and none where bodies meet on a line only."""

import re

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.contact.coupling.nodal import SurfacePair, pair, rim_of
from fecontact.results.contact_fields import FACES_ACROSS
from fecontact.surfaces import FlatPunch
from fecontact.surfaces.facet_surface import FacetSurface

pytestmark = pytest.mark.rounding(0)

# without lateral contraction and with tops and bottoms held, blocks stand under uniform stress where they overlap whole
SOLID = fc.Material(E=1000.0, nu=0.0)


def solid(name, contact, held, cells, element="hex20", size=(1.0, 1.0, 1.0)):
    mesh = fc.shapes.block(size, cells, element=element)
    return fc.ElasticBody(mesh, SOLID, contact, {held: "xyz"}, name=name)


def hanging(overlap, cells=(2, 2, 2), coupling="auto", element="hex20"):
    """A block that hangs over the rim of another by all but `overlap`, pressed down with the force 1."""
    lower = solid("lower", "top", "bottom", (2, 2, 2), element)
    upper = solid("upper", "bottom", "top", cells, element).placed((1.0 - overlap, 0.0, 1.0))
    scene = fc.Scene([lower, upper], [fc.Contact(upper, lower, coupling=coupling)])
    return scene.solve(forces={upper: (0, 0, -1)}).contacts[0]


@pytest.mark.by_day(
    "cells0-auto-0.1", "cells1-nodal-0.37", "cells0-mortar-0.01", "cells0-auto-0.5", "cells1-mortar-0.1"
)
@pytest.mark.parametrize("overlap", [0.5, 0.37, 0.1, 0.01])
@pytest.mark.parametrize("coupling", ["auto", "nodal", "mortar"])
@pytest.mark.parametrize("cells", [(2, 2, 2), (3, 3, 2)])
def test_the_area_is_that_of_the_overlap(overlap, coupling, cells):
    """Source: geometry. The whole overlap of two blocks is 1 wide; the mean pressure is the force over it."""
    contact = hanging(overlap, cells, coupling)
    assert contact.active.all()
    assert abs(contact.point_area / overlap - 1) < 1e-9
    assert abs(contact._whole.area / overlap - 1) < 1e-12
    assert abs(contact._whole.mean_pressure * overlap - 1) < 1e-9


@pytest.mark.parametrize("element", ["hex8", "hex27"])
def test_the_area_for_other_elements(element):
    assert abs(hanging(0.37, coupling="nodal", element=element)._whole.area / 0.37 - 1) < 1e-12


@pytest.mark.parametrize("coupling", ["nodal", "mortar"])
def test_the_rim_runs_through_faces_of_which_two_nodes_face_nothing(coupling):
    """Source: geometry; also where the pressure of the nodes past the rim is zero."""
    contact = hanging(0.63, (8, 4, 2), coupling, "hex8")
    assert contact._readings.across >= FACES_ACROSS
    assert abs(contact._whole.area / 0.63 - 1) < 1e-12
    assert abs(hanging(0.37, (3, 3, 2), coupling, "hex8")._whole.area / 0.37 - 1) < 1e-12


def test_the_corner_of_the_other_body_within_a_face():
    """Source: geometry; the overlap is .7 by .9."""
    lower = solid("lower", "top", "bottom", (2, 2, 2), "hex8")
    upper = solid("upper", "bottom", "top", (5, 4, 2), "hex8").placed((0.3, 0.1, 1.0))
    scene = fc.Scene([lower, upper], [fc.Contact(upper, lower, coupling="mortar")])
    contact = scene.solve(motions={upper: {"z": -1e-3}}).contacts[0]
    assert contact.active.all()
    assert abs(contact._whole.area / 0.63 - 1) < 1e-12


def test_triangles_at_the_rim_are_covered_in_part():
    """Source: geometry; faces cut in two, then cut by the master's side."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2), element="hex8")
    quads = mesh.face_nodes(mesh.faces("bottom"))
    triangles = FacetSurface(mesh.points, np.concatenate([quads[:, [0, 1, 2, 2]], quads[:, [0, 2, 3, 3]]]))
    master = solid("lower", "top", "bottom", (2, 2, 2)).surface("top")
    pairing = pair(SurfacePair(triangles, master, np.eye(3), np.array([0.6, 0.0, 1.0])))
    assert abs(pairing.weights.sum() / 0.4 - 1) < 1e-9
    assert pairing.weights.min() > 0


def test_sections_that_hang_over():
    """Source: geometry."""
    lower = fc.PlaneBody(fc.sections.rectangle((1.0, 1.0), (2, 2)), SOLID, "top", {"bottom": "xz"}, thickness=2.0)
    upper = fc.PlaneBody(fc.sections.rectangle((1.0, 1.0), (3, 2)), SOLID, "bottom", {"top": "xz"}, thickness=2.0)
    upper = upper.placed((0.63, 0.0, 1.0))
    for coupling in ("nodal", "mortar"):
        scene = fc.Scene([lower, upper], [fc.Contact(upper, lower, coupling=coupling)])
        contact = scene.solve(forces={upper: (0, 0, -1)}).contacts[0]
        assert abs(contact.weights.sum() / (2 * 0.37) - 1) < 1e-9
        assert abs(contact._whole.area / (2 * 0.37) - 1) < 1e-12


def test_faces_under_a_rigid_punch_are_covered_to_a_share_of_a_face():
    """Source: geometry. The rim of a rigid shape is found to 1/24 of a face, along both pairs of sides."""
    body = solid("body", "top", "bottom", (6, 6, 2))
    punch = fc.RigidBody(FlatPunch(sides=(0.7, 0.5))).placed((0.5, 0.5, 1.0))
    relative = body.pose.relative_to(punch.pose)
    nodes = SurfacePair(body.surface("top"), punch.surface("surface"), relative.rotation, relative.translation)
    pairing = pair(nodes)
    assert abs(pairing.weights.sum() - 0.35) < 2 * (0.7 + 0.5) / 6 / 24


@pytest.mark.parametrize("coupling", ["auto", "nodal", "mortar"])
@pytest.mark.parametrize(("overlap", "size"), [(0.0, r"0, 0\.0e\+00"), (1e-5, r"1e-05, (8\.0e-05|1\.2e-04)")])
def test_blocks_that_share_an_edge_line_are_refused_with_the_area(coupling, overlap, size):
    with refused(fc.InputError, "sliver") as caught:
        hanging(overlap, coupling=coupling)
    assert re.search(size, str(caught.value))


@pytest.mark.parametrize("coupling", ["auto", "nodal", "mortar"])
def test_blocks_that_share_a_corner_are_refused(coupling):
    lower = solid("lower", "top", "bottom", (2, 2, 2))
    upper = solid("upper", "bottom", "top", (3, 3, 2)).placed((1.0, 1.0, 1.0))
    with refused(fc.InputError, "sliver"):
        fc.Scene([lower, upper], [fc.Contact(upper, lower, coupling=coupling)]).solve(forces={upper: (0, 0, -1)})


@pytest.mark.by_day("mortar")
@pytest.mark.parametrize("coupling", ["auto", "nodal", "mortar"])
def test_quarters_of_balls_on_opposite_sides_of_a_plane_are_refused(coupling):
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=1.0, level=1)
    held = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    lower = fc.ElasticBody(mesh, SOLID, "cap", held, name="lower").placed(rotation=fc.rotation_about((1, 1, 0), np.pi))
    upper = fc.ElasticBody(mesh, SOLID, "cap", held, name="upper").placed(
        rotation=fc.rotation_about((0, 0, 1), np.pi / 2)
    )
    with refused(fc.InputError, "sliver"):
        fc.Scene([lower, upper], [fc.Contact(upper, lower, coupling=coupling)]).solve(forces={upper: (0, 0, -40)})
    # the quarter on the same side is the ordinary symmetric model
    facing = fc.ElasticBody(mesh, SOLID, "cap", held, name="upper")
    result = fc.Scene([lower, facing], [fc.Contact(facing, lower, coupling=coupling)]).solve(
        forces={facing: (0, 0, -40)}
    )
    exact = fc.hertz.spheres((10.0, 10.0), (SOLID, SOLID), force=160.0)
    assert abs(result.contacts[0].max_pressure / exact.p0 - 1) < 0.15  # one ring of faces within the contact


def test_auto_never_calls_faces_nested_that_hang_over_the_rim():
    assert hanging(0.5).coupling == "nodal"
    for overlap in (0.6, 0.37, 0.01):
        assert hanging(overlap).coupling == "mortar"


def test_a_face_larger_than_the_body_below_it_is_coupled_by_mortar():
    """Source: geometry. No node of the upper face lies over the lower body."""
    lower = solid("lower", "top", "bottom", (2, 2, 2), size=(0.3, 0.3, 0.3)).placed((0.12, 0.13, -0.3))
    upper = solid("upper", "bottom", "top", (1, 1, 1), "hex8")
    contact = fc.Scene([lower, upper], [fc.Contact(upper, lower)]).solve(forces={upper: (0, 0, -1)}).contacts[0]
    assert contact.coupling == "mortar"
    assert abs(contact._whole.area / 0.09 - 1) < 1e-9


def test_whole_surfaces_have_no_rim_and_their_own_weights():
    lower, upper = solid("lower", "top", "bottom", (2, 2, 2)), solid("upper", "bottom", "top", (4, 4, 2))
    one, other = upper.surface("bottom"), lower.surface("top")
    nodes = SurfacePair(one, other, np.eye(3), np.array([0.0, 0.0, 1.0]))
    pairing = pair(nodes)
    every = np.ones(len(one.points), bool)
    assert len(rim_of(one, other, np.eye(3), np.array([0.0, 0.0, 1.0]), every, ~every).facets) == 0
    assert len(nodes.rim.partly) == 0
    assert abs(pairing.weights.sum() - 1) < 1e-14
