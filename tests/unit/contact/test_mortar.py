"""Mortar coupling: hats, clipping, overlaps, patch tests, edges."""

import numpy as np
import pytest
import refusals

import fecontact as fc
from fecontact.contact.coupling.mortar import multiplier_areas, pair_mortar
from fecontact.contact.coupling.mortar_basis import cut, multiplier_shapes, own_samples, piece_samples, sub_faces
from fecontact.contact.coupling.nodal import SurfacePair
from fecontact.contact.coupling.segments import clip
from fecontact.mesh.element import TRIANGLE_NODES, quad_nodes
from fecontact.surfaces.facet_surface import FacetSurface

pytestmark = pytest.mark.rounding(0)

SOLID = fc.Material(1.0, 0.3)


def top(n, size=(1.0, 1.0)):
    mesh = fc.shapes.block((*size, 1.0), (*n, 1)).with_midface_nodes(("top", "bottom"))
    return mesh, FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("top")))


def bottom(n, size=(1.0, 1.0), shift=(0.0, 0.0, 1.0)):
    mesh = fc.shapes.block((*size, 1.0), (*n, 1)).with_midface_nodes(("top", "bottom")).translated(shift)
    return mesh, FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("bottom")))


KINDS = [(4, False), (8, False), (9, False), (4, True), (8, True), (9, True)]


@pytest.mark.parametrize(("n_columns", "triangle"), KINDS)
def test_hats_are_a_non_negative_partition_of_unity(n_columns, triangle):
    X = np.random.default_rng(0).random((200, 2))
    X = np.where(triangle & (X.sum(axis=1, keepdims=True) > 1), 1 - X, X)
    multipliers = multiplier_shapes(n_columns, np.full(200, triangle), X)
    assert multipliers.min() >= 0
    assert np.abs(multipliers.sum(axis=1) - 1).max() < 1e-15


@pytest.mark.parametrize(("n_columns", "triangle"), KINDS)
def test_hats_are_one_at_their_nodes_and_sub_faces_tile_the_facet(n_columns, triangle):
    X = TRIANGLE_NODES[:3] if triangle else quad_nodes(n_columns)
    multipliers = multiplier_shapes(n_columns, np.full(len(X), triangle), X)
    assert np.abs(multipliers.max(axis=1) - 1).max() < 1e-15
    assert len(np.unique(multipliers.argmax(axis=1))) == len(X)
    x, y = np.moveaxis(sub_faces(n_columns, triangle), 2, 0)
    areas = (x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum(axis=1) / 2
    assert areas.min() > 0
    assert abs(areas.sum() - (0.5 if triangle else 1.0)) < 1e-15


def test_hat_areas_of_a_seven_node_triangle():
    # linear hats: a third of the area 1/2 at each corner, nothing at the other nodes
    row = np.array([[0, 1, 2, 2, 3, 4, 2, 5, 6]])
    points = np.concatenate([TRIANGLE_NODES, np.zeros((7, 1))], axis=1)
    assert np.abs(multiplier_areas(FacetSurface(points, row)) - np.array([1, 1, 1, 0, 0, 0, 0]) / 6).max() < 2e-14
    assert abs(own_samples(row)[2].sum() - 0.5) < 1e-15


def test_clipping_random_triangles_keeps_their_area_over_four_quarters():
    # four rectangles tile the square [-1, 1]^2 that holds all triangles: their shares add up
    triangles = np.random.default_rng(1).uniform(-1, 1, (500, 3, 2))
    total = np.zeros(500)
    for low in ((-1, -1), (0, -1), (-1, 0), (0, 0)):
        corner = np.tile(np.array(low, float), (500, 1))
        square = corner[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
        polygons, count = clip(triangles, square)
        x, y = np.moveaxis(polygons, 2, 0)
        after = np.where(np.arange(x.shape[1]) + 1 < count[:, None], np.arange(x.shape[1]) + 1, 0)
        cross = x * np.take_along_axis(y, after, 1) - y * np.take_along_axis(x, after, 1)
        total += np.abs(np.where(np.arange(x.shape[1]) < count[:, None], cross, 0).sum(axis=1)) / 2
    edges = triangles[:, 1:] - triangles[:, :1]
    area = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
    assert np.abs(total - area).max() < 1e-14  # sums of a few products of order one


def test_weights_of_a_partial_overlap_are_its_area():
    # a slave of 1 x 1 that hangs over the rim of the master by 0.37 along x
    _, master = top((3, 2))
    _, slave = bottom((2, 2), shift=(0.37, 0.0, 1.0))
    pairing = pair_mortar(SurfacePair(slave, master, np.eye(3), np.zeros(3)))
    assert abs(pairing.weights.sum() - 0.63) < 1e-14
    assert np.abs(pairing.average.sum(axis=1) - 1).max() < 1e-14
    assert np.abs(pairing.gap).max() < 1e-14


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize("divisions", [(1, 1), (2, 3), (3, 2), (1, 5), (5, 1)])
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("turn", [0.0, np.pi / 6])
def test_patch_test_of_taylor_and_papadopoulos(divisions, swapped, turn):
    # uniform pressure through a flat interface of any two meshes, either side as slave, the model turned with its load
    n1, n2 = divisions
    low = fc.shapes.block((1.0, 1.0, 1.0), (n1, n1, 2))
    high = fc.shapes.block((1.0, 1.0, 1.0), (n2, n2, 2))
    sides = {"x_min": "x", "y_min": "y"}
    Q = fc.rotation_about((1.0, 0.3, 0.0), turn)
    lower = fc.ElasticBody(low, SOLID, "top", {"bottom": "z", **sides}, name="lower").placed(rotation=Q)
    upper = fc.ElasticBody(high, SOLID, "bottom", sides, name="upper").placed((0, 0, 1.0)).placed(rotation=Q)
    pair = (lower, upper) if swapped else (upper, lower)
    result = fc.Scene([lower, upper], [fc.Contact(*pair, coupling="mortar")]).solve(pressures={(upper, "top"): 1.0})
    expected = np.array([0, 0, -1.0, 0, 0, 0])
    # 1e-10 is asked for; rounding through the factorisation leaves 1e-12
    for body in (lower, upper):
        assert np.abs(result.stress(body) - expected).max() < 1e-10
    assert np.abs(result.contacts[0].pressure - 1).max() < 1e-10
    assert abs(result.residuals().equilibrium) < 1e-10


def test_partly_covered_punch_carries_no_pressure_beyond_the_edge():
    # a block on a wider one whose faces do not match: all its force stays inside the block's outline
    low = fc.shapes.block((2.0, 2.0, 1.0), (5, 5, 2)).translated((-0.6, -0.6, -1.0))
    high = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2))
    lower = fc.ElasticBody(low, SOLID, "top", {"bottom": "xyz"}, name="lower")
    upper = fc.ElasticBody(high, SOLID, "bottom", {"top": "xyz"}, name="upper")
    for pair in ((upper, lower), (lower, upper)):
        result = fc.Scene([lower, upper], [fc.Contact(*pair)]).solve(motions={upper: {"z": -0.01}})
        contact = result.contacts[0]
        assert contact.coupling == "mortar"
        pushed = contact._centres[contact.active]
        assert pushed.min(axis=0)[:2].min() > -1e-12
        assert pushed.max(axis=0)[:2].max() < 1 + 1e-12
        # the resultant is on the middle of the block to its share of the off-centre lower one
        assert np.abs(contact.centre_of_pressure[:2] - 0.5).max() < 0.01
        assert abs(result.residuals().equilibrium) < 1e-10


def test_swapping_slave_and_master_changes_the_force_less_than_the_mesh_does():
    def force(pair_first, n):
        low = fc.shapes.block((2.0, 2.0, 1.0), (n + 2, n + 2, 2)).translated((-0.5, -0.5, -1.0))
        high = fc.shapes.block((1.0, 1.0, 1.0), (n, n, 2))
        lower = fc.ElasticBody(low, SOLID, "top", {"bottom": "xyz"}, name="lower")
        upper = fc.ElasticBody(high, SOLID, "bottom", {"top": "xyz"}, name="upper")
        pair = (upper, lower) if pair_first == "upper" else (lower, upper)
        return (
            fc.Scene([lower, upper], [fc.Contact(*pair)]).solve(motions={upper: {"z": -0.01}}).contacts[0].total_force
        )

    coarse, swapped, fine = force("upper", 3), force("lower", 3), force("upper", 6)
    print(f"\nforce {coarse:.6f}, swapped {swapped:.6f}, refined {fine:.6f}")
    assert abs(coarse - swapped) < abs(coarse - fine)


@pytest.mark.full
def test_mortar_against_nodal_on_matching_hertz_meshes():
    # two couplings of the same meshes: pressures differ by less than either differs from Hertz
    from fecontact.app.studies.spheres import CASES

    case = CASES["equal"]
    mesh = fc.shapes.quarter_sphere(25.0, contact_radius=case.hertz.a, level=1)
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    upper = fc.ElasticBody(mesh, case.material, "cap", supports, name="upper")
    lower = upper.placed(rotation=fc.rotation_about((1, 1, 0), np.pi), name="lower")
    results = {}
    for coupling in ("nodal", "mortar"):
        scene = fc.Scene([upper, lower], [fc.Contact(upper, lower, coupling=coupling)])
        contact = scene.solve(forces={upper: (0, 0, -case.force / 4)}).contacts[0]
        r = np.hypot(*contact.points[:, :2].T)
        points, pressure, area = contact.sampled(contact.pressure, 12)
        rs = np.hypot(*points[:, :2].T)
        inside, exact = rs <= 1.2 * case.hertz.a, case.hertz.pressure(rs)
        error = (area * (pressure - exact) ** 2)[inside].sum() / (area * exact**2)[inside].sum()
        results[coupling] = (float(np.sqrt(error)), contact.pressure[np.argmin(r)])
        print(f"\n{coupling}: L2 {100 * results[coupling][0]:.2f} %, centre {results[coupling][1]:.1f}")
    assert abs(results["mortar"][0]) < 0.05
    assert abs(results["mortar"][1] / case.hertz.p0 - 1) < 0.02


def test_plain_eight_node_slave_is_refused():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1))
    body = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, pressure="nodal")
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, coupling="mortar")])
    with refusals.refused(fc.InputError, "mortar-of-eight-nodes"):
        scene.solve(motions={body: {"z": -0.1}})


def test_mortar_on_a_rigid_plane_is_uniform():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2))
    sides = {"top": "z", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, SOLID, "bottom", sides)
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor, coupling="mortar")]).solve(motions={body: {"z": -0.01}})
    assert np.abs(result.contacts[0].pressure - 0.01).max() < 1e-14  # uniform, exact


def test_slivers_at_the_rim_keep_their_area_and_act_with_their_neighbours():
    # an overlap that leaves 2 % of the outer column of faces
    _, master = top((3, 2))
    _, slave = bottom((4, 4), shift=(0.745, 0.0, 1.0))
    pairing = pair_mortar(SurfacePair(slave, master, np.eye(3), np.zeros(3)))
    assert abs(pairing.weights.sum() - 0.255) < 1e-14
    assert np.abs(pairing.average.sum(axis=1) - 1).max() < 1e-13
    mix = pairing.mix.toarray()
    assert mix.min() >= 0
    assert np.abs(mix.sum(axis=1) - 1).max() < 1e-13
    # areas of the solver's points by which a uniform pressure is one everywhere
    areas = np.linalg.solve(mix.T, pairing.weights)
    assert areas.min() > 0
    assert abs(areas.sum() - 0.255) < 1e-13
    share = pairing.weights / multiplier_areas(slave)[pairing.nodes]
    assert share.min() < 0.01
    assert (areas / multiplier_areas(slave)[pairing.nodes])[share < 0.01].min() > 0.4


@pytest.mark.by_day("tet4")
@pytest.mark.parametrize("element", ["hex8", "hex27", "tet4"])
def test_centres_of_pressure_reach_the_rim_as_it_moves_over_a_face(element):
    """Source: geometry. A multiplier at a rim along sides of faces has its centre at a third of its width."""
    n = 2 if element == "hex27" else 4
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, 3, 1), element="hex8" if element == "tet4" else element)
    facets = mesh.face_nodes(mesh.faces("bottom"))
    if element == "tet4":
        facets = np.concatenate([facets[:, [0, 1, 2, 2]], facets[:, [0, 2, 3, 3]]])
    slave, (_, master) = FacetSurface(mesh.points, facets), top((3, 2))
    before = None
    for shift in np.linspace(0.45, 0.8, 71):
        pairing = pair_mortar(SurfacePair(slave, master, np.eye(3), np.array([shift, 0.0, 1.0])))
        places = pairing.mixed(pairing.average @ (pairing.slave_weights @ slave.points))[:, 0] + shift
        # widths of 1/4
        assert 1 - places.max() < 0.51 / 4
        # along sides of faces the number of points changes, their outermost place does not jump
        assert before is None or abs(places.max() - before) < 0.015
        before = places.max()


@pytest.mark.parametrize("first", ["bricks", "wedges"])
def test_quadrilaterals_are_the_slave_of_triangles(first):
    # a triangle carries three hats and a quadrilateral nine, so that pressure is finer on the latter
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (3, 3, 1)).translated((0.0, 0.0, 0.5))
    upper = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, name="bricks")
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    layer = fc.shapes.extrude(fc.SurfaceMesh(square, np.array([[0, 1, 2, 2], [0, 2, 3, 3]])), 0.5)
    lower = fc.ElasticBody(layer, SOLID, "top", {"base": "xyz"}, name="wedges")
    pair = (upper, lower) if first == "bricks" else (lower, upper)
    contact = fc.Scene(pair, [fc.Contact(*pair)]).solve(motions={upper: {"z": -0.01}}).contacts[0]
    assert contact.slave.name == "bricks"


@pytest.mark.parametrize(("mu", "shifts"), [(0.0, range(-18, 3)), (0.3, range(-18, -8)), (np.inf, range(-18, -8))])
def test_forces_and_moments_are_continuous_as_a_rim_moves_over_the_faces(mu, shifts):
    # an upper block of three faces across that hangs over the rim of the lower one by 2 to 2.4 of them: the multipliers
    # that the rim passes come in without a jump, and their peak does
    low = fc.ElasticBody(fc.shapes.block((1.0, 1, 1), (4, 3, 2), element="hex8"), SOLID, "top", {"bottom": "xyz"})
    mesh = fc.shapes.block((0.5, 1, 1), (3, 2, 2), element="hex8")
    figures = []
    for shift in -1 / 3 + 0.004 * np.array(shifts):
        up = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, name="up").placed((shift, 0.0, 1.0))
        result = fc.Scene([low, up], [fc.Contact(up, low, friction=mu)]).solve(motions={up: {"z": -0.02, "x": 0.004}})
        (contact,) = result.contacts
        place = contact.forces @ contact._centres[:, 0] / contact.total_force
        sideways = 0.0
        if mu:
            sideways = contact.friction.forces[:, 0].sum()
            # what each point does is shared out with its work, and within its cone
            work = -(result.friction.tangential * result.friction.slip).sum()
            assert abs(contact.friction.friction_work - work) < 1e-12
            size = np.linalg.norm(contact.friction.forces, axis=1)
            assert mu == np.inf or (size <= mu * contact.forces * (1 + 1e-9) + 1e-15).all()
            assert not contact.friction.sliding[~contact.friction.touching].any()
        figures.append([contact.total_force, place, contact.max_pressure, sideways])
    # in steps of 1/40 of a face, relative to the largest: force, its place, the peak and friction
    largest = np.maximum(np.abs(figures).max(axis=0), 1e-12)
    assert (np.abs(np.diff(figures, axis=0)).max(axis=0) / largest < [0.015, 0.04, 0.1, 0.03]).all()


def test_a_load_nearer_to_a_rim_than_half_a_face_is_refused_with_the_remedy():
    """Source: statics. The overlap ends at x = 0; a load at x = .05, .3 of the upper faces, balances finer ones."""
    steel = fc.Material(E=1.0, nu=0.3)

    def pressed(n, x, coupling="mortar"):
        low = fc.ElasticBody(fc.shapes.block((1.0, 1, 1), (4, 3, 4), element="hex8"), steel, "top", {"bottom": "xyz"})
        mesh = fc.shapes.block((0.5, 1, 1), (3 * n, 2, 2), element="hex8")
        up = fc.ElasticBody(mesh, steel, "bottom", name="up").placed((-0.25, 0.0, 1.0))
        scene = fc.Scene([low, up], [fc.Contact(up, low, coupling=coupling, swap="never")])
        held = dict.fromkeys(("x", "y", "rx", "rz"), 0.0)
        return scene.solve(forces={up: (0, 0, -1e-4)}, moments={up: (0, 1e-4 * x, 0)}, motions={up: held}).contacts[0]

    assert abs(pressed(1, 0.085).centre_of_pressure[0] - 0.085) < 1e-9
    # forces at single points do, beyond the centres of pressures of faces .167 wide
    with refusals.refused(
        fc.SupportError, "free-motion", "finer faces of 'up' there do", "of a face, from the centres"
    ):
        pressed(1, 0.05)
    # beyond the rim nothing does
    with pytest.raises(fc.SupportError) as refused:
        pressed(1, -0.01)
    assert "finer faces" not in str(refused.value)
    assert abs(pressed(3, 0.05).centre_of_pressure[0] - 0.05) < 1e-9
    # nodes of the finer faces lie at .0278 and .0833, those of the coarser ones at .0833 and beyond the rim
    assert abs(pressed(3, 0.05, "nodal").force[2] - 1e-4) < 1e-12
    with refusals.refused(
        fc.SupportError, "free-motion", "between the nodes that face", "finer faces of 'up' there do"
    ):
        pressed(1, 0.05, "nodal")
    with pytest.raises(fc.SupportError) as refused:
        pressed(1, -0.01, "nodal")
    assert "finer faces" not in str(refused.value)


def test_several_blocks_of_pairs_give_what_one_gives(monkeypatch):
    # 3 x 4 faces on 5 x 2, some of them over the rim, in poses of their own
    turn = fc.rotation_about((0, 0, 1), 0.7)
    low = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (5, 2, 1)), SOLID, "top", {"bottom": "xyz"}, name="low")
    up = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (3, 4, 1)), SOLID, "bottom", {"top": "xyz"}, name="up")
    low, up = (
        low.placed((3, 1, 2), turn),
        up.placed((0.13, 0.02, 1.0), fc.rotation_about((1, 1, 0), 1e-3)).placed((3, 1, 2), turn),
    )
    found = []
    for block in (10**6, 7):
        monkeypatch.setattr("fecontact.contact.coupling.mortar.BLOCK", block)
        scene = fc.Scene([low, up], [fc.Contact(up, low, swap="never", coupling="mortar")])
        found.append(scene.solve(motions={up: {"z": -0.01}}))
    one, several = (r._interfaces[0].pairing for r in found)
    assert one.sums is None
    assert several.sums is not None
    assert np.array_equal(one.nodes, several.nodes)
    # the same samples added up in another order
    for name in ("weights", "gap", "slave_rows", "covered"):
        assert abs(getattr(one, name) - getattr(several, name)).max() < 1e-13
    assert abs(found[0].interfaces[0].master_rows - found[1].interfaces[0].master_rows).max() < 1e-13
    first, second = (r.contacts[0] for r in found)
    for name in ("normals", "centres", "couples"):
        assert np.abs(getattr(first, name) - getattr(second, name)).max() < 1e-13
    # the solution enlarges that by the condition of the problem
    assert np.abs(first.pressure - second.pressure).max() < 1e-9
    assert max(r.residuals().equilibrium for r in found) < 1e-12


@pytest.mark.parametrize("columns", [4, 8, 9])
def test_samples_of_whole_quadrilaterals_follow_no_corner(columns):
    """The same in the reversed square and with both coordinates exchanged."""
    _, local, weight = own_samples(np.arange(columns)[None])

    def listed(at):
        rows = np.column_stack([at, weight]).round(12)
        return rows[np.lexsort(rows.T)]

    for other in (local[:, ::-1], 1 - local, local * [-1, 1] + [1, 0]):
        assert (listed(other) == listed(local)).all()
    # the square of a bilinear function on each quarter, and of any biquadratic one
    s, t = local.T
    assert abs((weight * s**4 * t**4).sum() - 1 / 25) < 1e-15


def curved(kind, divisions, master_shift):
    """Points and node rows of a slave facet, and of its mirror image; those of bent quadrilaterals below it."""
    if kind == "quadrilateral":
        row, flat = np.arange(9)[None], quad_nodes(9)
        reverse = [1, 0, 3, 2, 4, 7, 6, 5, 8]
    else:
        row, flat = np.array([[0, 1, 2, 2, 3, 4, 2, 5]]), TRIANGLE_NODES[:6]
        reverse = [1, 0, 2, 2, 3, 5, 2, 4]
    # the slave looks down
    points = np.column_stack([flat[:, 1], flat[:, 0], 1.05 + 0.1 * np.sin(2.0 * flat[:, 0] + flat[:, 1])])
    mesh = fc.shapes.block((1.4, 1.3, 1.0), (*divisions, 1), element="hex27")
    mesh = mesh.mapped(lambda x: x + np.outer(0.05 * np.cos(3 * x[:, 0] + x[:, 1]), (0, 0, 1)) + master_shift)
    return points, row, reverse, mesh.points, mesh.face_nodes(mesh.faces("top"))


@pytest.mark.parametrize("kind", ["quadrilateral", "triangle"])
@pytest.mark.parametrize(("divisions", "shift"), [((3, 2), (-0.13, -0.2)), ((2, 1), (-0.6, -0.5))])
def test_a_mirror_image_has_the_same_gaps_and_areas(kind, divisions, shift):
    # on curved faces quadrature has an error, which may not depend on how a face's corners are numbered; in the second
    # case corners of the master lie beyond what a facet is extended by
    points, row, reverse, below, faces = curved(kind, divisions, np.array([*shift, 0.0]))
    order = [1, 0, 3, 2, 4, 7, 6, 5, 8]
    found = []
    for flip, columns, rows in (([1, 1, 1], row, faces), ([-1, 1, 1], np.array([reverse]), faces[:, order])):
        slave, master = FacetSurface(points * flip, columns), FacetSurface(below * flip, rows)
        found.append(pair_mortar(SurfacePair(slave, master, np.eye(3), np.zeros(3), share=0.4)))
    assert found[0].nodes.tolist() == found[1].nodes.tolist()
    assert found[0].weights.sum() > 0.05
    # measured 2e-16, of numbers of order .1
    assert np.abs(found[0].weights - found[1].weights).max() < 1e-13
    assert np.abs(found[0].gap - found[1].gap).max() < 1e-13


def moments(polygon, highest):
    """Integrals of s^i t^j over a polygon (k, 2), i + j <= highest, by Green's formula along its sides."""
    x, w = np.polynomial.legendre.leggauss(highest + 2)
    start, along = polygon[:, None], (np.roll(polygon, -1, axis=0) - polygon)[:, None]
    s, t = np.moveaxis(start + (x[:, None] + 1) / 2 * along, -1, 0)
    powers = [(i, j) for i in range(highest + 1) for j in range(highest + 1 - i)]
    return powers, np.array([((s ** (i + 1) / (i + 1) * t**j) * along[..., 1] * w / 2).sum() for i, j in powers])


@pytest.mark.parametrize("order", [5, 6, 8, 12])
def test_pieces_of_polygons_have_their_moments_wherever_their_lists_begin(order):
    rng = np.random.default_rng(order)
    polygons = []
    for k in (3, 4, 5, 6, 9):
        angle = np.sort(rng.uniform(0, 2 * np.pi / k, k) + 2 * np.pi * np.arange(k) / k)
        radius = np.full(k, 0.5)
        polygons.append(0.5 + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    # a reflex vertex, equal triangles all round, and one vertex twice
    polygons.append(np.array([[0.0, 0], [1, 0], [0.5, 0.2], [1, 1], [0.3, 1], [0, 0.5]]))
    polygons.append(0.5 + np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=1) / 3)
    polygons.append(np.array([[0.0, 0], [1, 0], [1, 0], [1, 1], [0.4, 1.0]]))
    for polygon in polygons:
        powers, known = moments(polygon, order)
        places = []
        for given in (polygon, polygon[::-1], np.roll(polygon, 2, axis=0)):
            # padded by vertices that do not count
            padded = np.concatenate([given, rng.uniform(size=(2, 2))])[None]
            corners, of = cut(padded, np.array([len(given)]))
            assert not of.any()
            local, weight, own = piece_samples(corners, order)
            assert set(own) == set(range(len(corners)))
            found = [(weight * local[:, 0] ** i * local[:, 1] ** j).sum() for i, j in powers]
            # rounding of sums of numbers of at most one
            assert np.abs(found - known).max() < 1e-13
            places.append(np.sort(local @ [1.0, np.sqrt(2.0)]))
        assert all(np.abs(others - places[0]).max() < 1e-12 for others in places)
