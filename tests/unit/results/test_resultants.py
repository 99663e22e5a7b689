"""Resultants of parts of a contact, and what holds a body."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import Mesh
from fecontact.mesh.kinds import KINDS
from fecontact.results.files import nodal_pressure

# sums of the same numbers in another order; the condensed problems have condition numbers below 1e4
ROUNDING = 1e-10


def tilted_block(centre=(0.0, 0.0)):
    """A block pressed down by a platen with a force off its centre."""
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2)).translated((-1.0, -0.5, 0.0))
    body = fc.ElasticBody(mesh, fc.Material(E=100.0, nu=0.3), "bottom", {"top": "xyz"}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    x, y = centre
    loads = {"forces": {body: (0, 0, -1.0)}, "moments": {body: (-y, x, 0)}, "free": {body: "rx ry"}}
    return body, floor, scene.solve(**loads)


@pytest.fixture(scope="module")
def tilted():
    return tilted_block((0.1, 0.05))


@pytest.fixture(scope="module")
def two_feet():
    """A bridge on two feet of different length of stride, held on its top."""
    mesh = fc.shapes.block((5.0, 1.0, 1.0), (5, 1, 2))

    def projection(x):
        return (x[:, 2] < 1e-12) & ((x[:, 0] < 1.0 + 1e-9) | (x[:, 0] > 3.0 - 1e-9))

    mesh = mesh.with_boundary("feet", projection)
    body = fc.ElasticBody(mesh, fc.Material(E=100.0, nu=0.0), "feet", {"top": "xyz"}, name="bridge")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.02}})


def test_sides_of_a_plane_add_up_to_the_whole(tilted):
    contact = tilted[2].contacts[0]
    one, other = contact.split_by_plane((0.3, 0.1, 0.0), (1.0, 2.0, 0.0))
    for name in ("force", "moment", "area"):
        whole = getattr(contact, name)
        assert np.abs(getattr(one, name) + getattr(other, name) - whole).max() <= ROUNDING * np.abs(whole).max()
    assert max(one.max_pressure, other.max_pressure) == contact.max_pressure
    assert (one.centre_of_pressure - (0.3, 0.1, 0.0)) @ (1.0, 2.0, 0.0) > 0
    assert (other.centre_of_pressure - (0.3, 0.1, 0.0)) @ (1.0, 2.0, 0.0) < 0


def test_turning_the_normal_swaps_the_sides(tilted):
    contact = tilted[2].contacts[0]
    one, other = contact.split_by_plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    again, swapped = contact.split_by_plane((0.0, 0.0, 0.0), (-3.0, 0.0, 0.0))
    assert np.abs(one.force - swapped.force).max() == 0.0
    assert np.abs(other.moment - again.moment).max() == 0.0


def test_points_on_the_plane_count_half_to_either_side():
    contact = tilted_block()[2].contacts[0]
    left, right = contact.split_by_plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert abs(left.force[2] - 0.5) <= ROUNDING
    assert abs(left.area - right.area) <= ROUNDING * contact.area


@pytest.mark.parametrize("share", [1e-12, 1e-9, 1e-6, 1e-3])
def test_a_plane_moves_across_a_point_without_a_jump(share):
    body, _, result = tilted_block()
    left, right = result.contacts[0].split_by_plane((-share * body.size, 0.0, 0.0), (1.0, 0.0, 0.0))
    # points at x = 0 carry a share of the force of 1 that is finite; what the plane passes over is its width
    assert 0 <= left.force[2] - right.force[2] <= 4 * share


def test_a_plane_anywhere_divides_a_uniform_pressure_by_its_area():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), "bottom", {"top": "xyz"}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    contact = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}}).contacts[0]
    for x in (0.05, 0.3, 0.5, 0.62, 0.99):
        right, left = contact.split_by_plane((x, 0.0, 0.0), (1.0, 0.0, 0.0))
        # in the sample that the plane cuts, a 24th of the side wide, a point's function is taken at its middle: it
        # changes by up to 3 / 8 there, which a quarter of the sample's width may get wrongly
        assert abs(left.force[2] / 0.01 - x) <= 3 / 8 / 4 / 24
        assert abs(left.area - x) <= 3 / 8 / 4 / 24
        assert abs(contact._shares(np.array([x, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))[1].mean() - (1 - x)) <= 1e-12
        assert right.max_pressure == pytest.approx(0.01)
    # a corner cut off askew: the samples are squares parallel to the plane
    _, corner = contact.split_by_plane((0.4, 0.0, 0.0), (1.0, 1.0, 0.0))
    assert abs(corner.force[2] / 0.01 - 0.4**2 / 2) < 0.5 / 24**2


def test_a_side_without_contact_is_empty(tilted):
    beyond, _ = tilted[2].contacts[0].split_by_plane((9.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert beyond.area == beyond.max_pressure == beyond.mean_pressure == 0.0
    assert not beyond.force.any()
    assert np.isnan(beyond.centre_of_pressure).all()


@pytest.mark.parametrize(
    ("normal", "code"), [((0, 0, 0), "normal-zero"), ((1, 0), "not-a-vector"), ((np.nan, 0, 1), "not-a-vector")]
)
def test_planes_that_are_none_are_refused(tilted, normal, code):
    with refused(fc.InputError, code, "normal of the dividing plane"):
        tilted[2].contacts[0].split_by_plane((0, 0, 0), normal)


def test_regions_have_moments_and_are_numbered_by_load(two_feet):
    contact = two_feet.contacts[0]
    assert len(contact.regions) == 2
    first, second = contact.regions
    assert first.force[2] > second.force[2]
    assert abs(first.area - 2.0) <= ROUNDING  # the feet are 2 x 1 and 1 x 1
    assert abs(second.area - 1.0) <= ROUNDING
    moment = first.moment + second.moment
    assert np.abs(moment - contact.moment).max() <= ROUNDING * np.abs(contact.moment).max()
    for k, region in enumerate(contact.regions, start=1):
        lever = region.centre_of_pressure - contact.reference_point
        # all normals are alike here, so the moment is that of the resultant at the centre of pressure
        assert np.abs(np.cross(lever, region.force) - region.moment).max() <= ROUNDING * np.abs(region.moment).max()
        assert contact.forces[contact.region == k].sum() == pytest.approx(region.force[2], rel=ROUNDING)
    assert (contact.forces[contact.region == 0] == 0).all()


def test_floor_takes_the_load_at_its_place(tilted):
    body, floor, result = tilted
    # a unit force through (0.1, 0.05), down on the floor, whose reference point is the origin; held by the opposite
    expected = -np.concatenate([(0, 0, -1.0), np.cross((0.1, 0.05, 0.0), (0, 0, -1.0))])
    assert np.abs(result.reaction(floor) - expected).max() <= ROUNDING
    # the platen is loaded in z and free in rx and ry; nothing pushes in the other components
    assert np.abs(result.reaction(body)).max() <= ROUNDING


def test_supported_boundary_passes_the_load_on(tilted):
    body, _, result = tilted
    from_nodes = result.reaction(body, "top")
    load = np.array([0, 0, -1.0, -0.05, 0.1, 0.0])
    # internal forces cancel to the rounding of stiffness times displacement
    assert np.abs(from_nodes - load).max() <= 1e-9


def test_reactions_of_all_supports_are_that_of_the_body():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    supports = {"top": "z", "x_min": "x", "y_min": "y", "y_max": "y"}
    body = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3, density=2.0), "bottom", supports, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    result = scene.solve(motions={body: {"z": -0.02}}, pressures={(body, "x_max"): 0.3}, gravity=(0, 0, -9.81))
    total = sum(result.reaction(body, name) for name in supports)
    whole = result.reaction(body)
    # two ways to the same force: equilibrium, and stiffness times displacement
    assert np.abs(total - whole).max() <= 1e-9 * np.abs(whole).max()
    # the pressure of 0.3 on a unit face pushes towards -x and is held by x_min
    assert abs(result.reaction(body, "x_min")[0] - 0.3) <= 1e-9


def test_floating_body_that_is_moved_is_held_by_its_mean():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "bottom", name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    result = scene.solve(motions={body: dict.fromkeys(("x", "y", "rx", "ry", "rz"), 0.0) | {"z": -0.01}})
    force = result.contacts[0].force[2]
    assert force > 0
    assert abs(result.reaction(body)[2] + force) <= ROUNDING * force


def test_springs_are_part_of_the_equilibrium():
    ball = fc.RigidBody(fc.Sphere(1.0), name="ball")
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (2, 2, 1)).translated((-1.0, -1.0, -1.0))
    block = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "top", {"bottom": "xyz"}, name="block")
    spring = fc.Spring(10.0, (ball, (0, 0, 2)), (None, (0, 0, -3)), slack_length=4.9)
    scene = fc.Scene([ball, block], [fc.Contact(block, ball)], springs=[spring])
    result = scene.solve(motions={ball: {"z": -0.01}})
    pull, push = result.springs[0].tension, result.contacts[0].total_force
    assert pull > 0
    assert push > 0
    assert abs(result.reaction(ball)[2] - (pull + result.contacts[0].force[2])) <= ROUNDING * push


def test_unknown_supports_are_refused_with_those_there_are(tilted):
    body, floor, result = tilted
    with refused(fc.InputError, "no-support", "'bottom'", "'top'"):
        result.reaction(body, "bottom")
    with refused(fc.InputError, "rigid", "'floor'"):
        result.reaction(floor, "surface")


def test_summary_and_table_name_regions_and_reactions(two_feet):
    summary = two_feet.summary()
    assert len(summary["contacts"][0]["region_resultants"]) == 2
    assert [b["name"] for b in summary["bodies"]] == ["bridge", "floor"]
    assert abs(summary["bodies"][1]["reaction"][2] - two_feet.contacts[0].force[2]) <= ROUNDING
    assert "region 2: area 1," in str(two_feet)


def test_stress_of_one_material_stops_at_its_edge():
    # a column of two materials with another ratio of Poisson's each, pressed without strain across
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 4))
    mesh = mesh.with_group("low", lambda c: c[:, 2] < 0.5).with_group("high", lambda c: c[:, 2] > 0.5)
    materials = {"low": fc.Material(E=1.0, nu=0.3), "high": fc.Material(E=10.0, nu=0.0)}
    held = {"bottom": "z", "x_min": "x", "x_max": "x", "y_min": "y", "y_max": "y"}
    body, floor = fc.ElasticBody(mesh, materials, "top", held, name="column"), fc.RigidBody(fc.Plane(), name="floor")
    upside = floor.placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([body, upside], [fc.Contact(body, upside)]).solve(motions={upside: {"z": -0.01}})
    # the stress along z is one in both, that across nu/(1 - nu) of it; E (1 - nu)/((1 + nu)(1 - 2 nu)) is the modulus
    along = -0.01 / (0.5 * 1.3 * 0.4 / 0.7 + 0.5 / 10.0)
    z = body.mesh.points[:, 2]
    for name, inside, across in (("low", z <= 0.5, 0.3 / 0.7 * along), ("high", z >= 0.5, 0.0)):
        stress = result.stress(body, name)
        assert np.isnan(stress[~inside]).all()
        assert np.abs(stress[inside, 2] - along).max() <= 1e-9
        assert np.abs(stress[inside, 0] - across).max() <= 1e-9
    with refused(fc.InputError, "input", "'middle'", "'low', 'high'"):
        result.stress(body, "middle")


def hanging_over(coupling, shift):
    """A block of 2 x 2 faces of which the outer column hangs over the rim of a block with other faces."""
    low = fc.shapes.block((1.0, 1.0, 1.0), (3, 2, 2))
    high = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).translated((shift, 0.0, 1.0))
    soft = fc.Material(E=1.0, nu=0.3)
    lower = fc.ElasticBody(low, soft, "top", {"bottom": "xyz"}, name="lower")
    upper = fc.ElasticBody(high, soft, "bottom", {"top": "xyz"}, name="upper")
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower, coupling=coupling, swap="never")])
    return scene.solve(motions={upper: {"z": -0.01}})


@pytest.mark.parametrize(("coupling", "shift"), [("mortar", 0.25), ("nodal", 0.2)])
def test_faces_that_hang_over_the_rim_are_shown(coupling, shift):
    # the outer two faces end at x = 1 + shift, the master at x = 1: their last nodes face nothing
    contact = hanging_over(coupling, shift).contacts[0]
    assert len(contact.facets) == 4
    assert abs(contact.nodes[:, 0].max() - 1 - shift) < 1e-12
    points, pressure, areas = contact.sampled(contact.pressure, 8)
    assert pressure[(points[:, 0] > 0.9) & (points[:, 0] < 1.0)].min() > 0
    assert np.abs(pressure[points[:, 0] > 1.0]).max() == 0
    # up to the rim the field's force is that of the contact: by mortar, nodal forces err by the order of the face size
    within = points[:, 0] < 1.0
    assert abs(pressure[within] @ areas[within] - contact.total_force) < 0.15 * contact.total_force


def test_fields_inside_triangles_are_linear_between_their_corners():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    six = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
    cells = np.concatenate([KINDS["tet4"].to_hexahedra(mesh.cells[:, p]) for p in six])
    mesh = Mesh(mesh.points, cells).upgraded(20)
    for name, height in (("bottom", 0.0), ("top", 1.0)):
        mesh = mesh.with_boundary(name, fc.pick.plane((0, 0, height), (0, 0, 1)))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, coupling="mortar")])
    result = scene.solve(motions={body: {"z": -0.01}})
    contact = result.contacts[0]
    assert len(contact.points) == 4
    assert len(contact.nodes) == 4 + 5 + 2  # corners, mid-side nodes, centroids
    _, pressure, areas = contact.sampled(contact.pressure, 6)
    assert abs(pressure @ areas / contact.total_force - 1) < 1e-3  # a midpoint rule on 6 x 6 cells
    nodal = nodal_pressure(result, body)
    assert abs(nodal[contact.slave.mesh.boundary_nodes("bottom")].min()) > 0.1 * contact.max_pressure
