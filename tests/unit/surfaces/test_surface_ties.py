"""Surfaces with hanging nodes: rims, feet, normals, areas and multipliers across divided sides."""

import numpy as np
import pytest
import scipy.sparse as sp
from hanging_meshes import SPATIAL, boxed, part, stairs, step
from refusals import refused

import fecontact as fc
from fecontact import MeshError
from fecontact.contact.coupling.mortar import multiplier_areas
from fecontact.contact.coupling.mortar_basis import multiplier_shapes, tied_multipliers
from fecontact.contact.coupling.nodal import SurfacePair, pair
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import contact_weights, facet_weights
from fecontact.surfaces.normals import normals_of

pytestmark = pytest.mark.rounding

# a few dozen products of numbers of size one
ROUNDING = 1e-12


def bent(x):
    return x + 0.08 * np.stack([0 * x[:, 0], 0 * x[:, 0], np.sin(2 * x[:, 0] + x[:, 1])], axis=1)


def surface(kind, name="top", mapping=lambda x: x, make=stairs):
    mesh = make(kind)
    if mesh.cells.shape[1] == 20:
        mesh = mesh.with_midface_nodes((name,))
    mesh = mesh.mapped(mapping)
    return FacetSurface(mesh.points, mesh.face_nodes(mesh.faces(name)), name, hanging=mesh.hanging)


def both_sides(s):
    """For points on divided sides: facet and coordinates on the one facet, and on the two."""
    ties, t = s.ties, np.array([0.1, 0.3, 0.45])
    ends = {
        False: np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]),
        True: np.array([[0, 0], [1, 0], [0, 1], [0, 1.0]]),
    }
    one, two = [], []
    for k in range(len(ties.edges)):
        if ties.whole[k] < 0:
            continue
        for half in range(2):
            for u in t:
                place = []
                for number in (ties.whole[k], ties.halves[k, half]):
                    facet, side = divmod(int(number), 4)
                    corner = ends[bool(s.triangle[facet])]
                    a, b = corner[side], corner[(side + 1) % 4]
                    # from the end that the half and the whole share
                    shared = ties.edges[k, 2 * half]
                    if s.facets[facet, side] != shared:
                        assert s.facets[facet, (side + 1) % 4] == shared
                        a, b = b, a
                    v = u if number == ties.whole[k] else 2 * u
                    place.append((facet, a + v * (b - a)))
                one.append(place[0])
                two.append(place[1])
    return [(np.array([f for f, _ in p]), np.array([x for _, x in p])) for p in (one, two)]


@pytest.mark.parametrize("kind", SPATIAL)
def test_divided_sides_lie_inside_the_surface(kind):
    s = surface(kind)
    assert len(s.ties.edges) > 0
    facet, side = s.rim_sides
    ends = s.points[np.stack([s.facets[facet, side], s.facets[facet, (side + 1) % 4]])]
    assert abs(np.linalg.norm(ends[1] - ends[0], axis=1).sum() - 12.0) < ROUNDING
    inner = (s.points[:, :2] > 1e-9).all(axis=1) & (s.points[:, :2] < [4 - 1e-9, 2 - 1e-9]).all(axis=1)
    assert not (s.rim_nodes & inner).any()
    # only with the whole edge's facet among them
    halves = FacetSurface(
        s.points, s.facets[np.setdiff1d(np.arange(len(s.facets)), s.ties.whole // 4)], "h", hanging=s.hanging
    )
    assert halves.ties is None or len(halves.ties.inner_sides) == 0
    assert halves.on_rim.sum() > 0


@pytest.mark.parametrize("kind", SPATIAL)
def test_feet_are_the_nearest_of_all_facets(kind):
    s = surface(kind, mapping=bent)
    rng = np.random.default_rng(5)
    # beside divided sides, where the nearest nodes may all hang
    middle = s.points[s.ties.edges[:, [1, 0, 2, 1]]].reshape(-1, 3)
    x = (middle[:, None] + rng.uniform(-0.2, 0.2, (len(middle), 12, 3))).reshape(-1, 3)
    found = s.project(x, n_near=1)
    every = np.repeat(np.arange(len(s.facets)), len(x))
    nearest = s.distance_to_facet(np.tile(x, (len(s.facets), 1)), every).reshape(len(s.facets), -1).min(axis=0)
    distance = np.linalg.norm(found.points - x, axis=1)
    # one node's facets do not do everywhere, on undivided surfaces neither; three do
    assert np.abs(np.linalg.norm(s.project(x).points - x, axis=1) - nearest).max() < 1e-9
    assert (np.abs(distance - nearest) < 1e-9).mean() > 0.9


@pytest.mark.parametrize("kind", SPATIAL)
def test_the_surface_and_its_normals_are_continuous(kind):
    s = surface(kind, mapping=bent)
    one, two = both_sides(s)
    assert np.abs(s.evaluate(*one)[0] - s.evaluate(*two)[0]).max() < ROUNDING
    normals = normals_of(s)
    assert np.abs(normals.at(*one) - normals.at(*two)).max() < ROUNDING
    assert np.abs(s.mean_normals - normals.nodal)[s.nodes].max() < ROUNDING


@pytest.mark.parametrize("kind", SPATIAL)
def test_areas_are_integrals_of_the_functions_of_free_nodes(kind):
    s = surface(kind, mapping=bent)
    weights, own = contact_weights(s), facet_weights(s)
    free = np.intersect1d(s.nodes, s.hanging.free)
    expected = s.hanging.transform.T @ own
    assert np.abs(weights[s.hanging.free] - expected).max() < ROUNDING
    assert weights[free].min() > 0
    assert not weights[s.hanging.nodes].any()
    assert abs(weights.sum() - own.sum()) < ROUNDING * own.sum()


@pytest.mark.parametrize("kind", SPATIAL)
def test_pressures_are_continuous_sums_of_hats(kind):
    s = surface(kind)
    G = tied_multipliers(s)
    k = s.facets.shape[1]
    p = G @ np.random.default_rng(2).uniform(size=len(s.points))
    one, two = both_sides(s)
    values = [np.einsum("na,na->n", multiplier_shapes(k, s.triangle[f], x), p[s.facets[f]]) for f, x in (one, two)]
    assert np.abs(values[0] - values[1]).max() < ROUNDING
    assert G.min() >= 0
    assert np.abs(np.asarray(G.sum(axis=1)).ravel() - 1).max() < ROUNDING
    assert abs(multiplier_areas(s).sum() - 8.0) < 1e-10
    assert abs(multiplier_areas(s)[tied_multipliers(s).getnnz(axis=0) == 0]).max() == 0


def test_middles_of_divided_sides_are_tied_on_four_nodes_and_triangles_only():
    for kind, tied in (("hex8", True), ("hex20", False), ("hex27", False), ("tet10", True), ("wedge15", True)):
        s = surface(kind, make=step)
        middles = s.ties.edges[:, 1]
        alone = tied_multipliers(s)[middles, middles]
        assert bool((np.asarray(alone) == 0).all()) == tied


def test_what_follows_from_lost_nodes_follows_from_the_others():
    s = surface("hex20", make=step)
    ties, lost = s.ties, np.zeros(len(s.points), bool)
    assert abs(ties.onto(lost) - ties.weights).max() == 0
    lost[ties.edges[0, [0, 1]]] = True
    onto = ties.onto(lost)
    assert not onto[:, np.flatnonzero(lost)].nnz
    assert onto.min() >= -0.125 - ROUNDING
    total = np.asarray(onto.sum(axis=1)).ravel()
    near = np.isin(ties.nodes, ties.edges[0, 3:])
    # with one end and the middle gone, the quarter beside the other end still follows from that alone
    end = np.where(near, onto[:, [ties.edges[0, 2]]].toarray().ravel(), 1.0)
    assert sorted(np.round(end[near], 12)) == [0.0, 1.0]
    assert np.abs(total[~near] - 1).max() < ROUNDING


def test_no_ties_where_no_node_of_the_surface_hangs():
    mesh = stairs("hex20")
    s = FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("x_min")), hanging=mesh.hanging)
    assert s.ties is None
    assert FacetSurface(mesh.points, s.facets).ties is None
    assert tied_multipliers(s) is None


def test_an_area_that_is_not_positive_is_refused():
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    row = np.flatnonzero((mesh.points[:, 1] == 0) & (mesh.points[:, 2] == 1))
    a, m, b = row[np.argsort(mesh.points[row, 0])]
    weights = sp.csr_matrix(([2.0, -1.0], ([0, 0], [a, b])), shape=(1, len(mesh.points)))
    hanging = HangingNodes(np.array([m]), weights, np.array([[a, m, b, -1, -1]]))
    s = FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("top")), "lid", hanging=hanging)
    with refused(MeshError, "no-area", "'lid'", "[2. 0. 1.]"):
        contact_weights(s)


@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10"])
def test_a_master_that_ends_beside_hanging_nodes(kind):
    # the covered area is that of the overlap wherever the rim runs: through coarse faces, fine faces, along their sides
    upper, still = surface(kind, "bottom"), (np.eye(3), np.array([0.0, 0.0, 1.0]))
    for end in (1.3, 2.0, 2.3, 2.5, 3.2):
        below = part(kind, (0, 0, 0), (end, 2, 1), (4, 3, 1)).with_boundary("lid", lambda x: x[:, 2] > 1 - 1e-9)
        if below.cells.shape[1] == 20:
            below = below.with_midface_nodes(("lid",))
        lid = FacetSurface(below.points, below.face_nodes(below.faces("lid")), "lid")
        pairing = pair(SurfacePair(upper, lid, *still))
        assert abs(pairing.weights.sum() - 2 * end) < 1e-9
        assert pairing.weights.min() > 0
        assert not np.isin(pairing.nodes, upper.hanging.nodes).any()
        shown = np.flatnonzero(np.diff(pairing.at_nodes.indptr))
        assert np.abs(np.asarray(pairing.at_nodes.sum(axis=1)).ravel()[shown] - 1).max() < ROUNDING


@pytest.mark.parametrize("kind", SPATIAL)
def test_the_part_that_is_searched_has_whole_shapes(kind):
    s = surface(kind, "bottom", make=stairs)
    G = tied_multipliers(s)
    for node in s.nodes:
        nodes = np.zeros(len(s.points), bool)
        nodes[node] = True
        wider = s.ties.with_tied(nodes)
        assert wider[node]
        # all that the node's own multiplier is made of, and all that is made of those
        masters = G[[node]].indices
        assert wider[masters].all()
        assert wider[np.flatnonzero(G[:, [node]].toarray())].all()
        assert wider[np.flatnonzero(G[:, masters].toarray().any(axis=1))].all()
        # but not on and on along the divided sides
        assert wider.sum() < 0.8 * len(s.nodes)
    assert not s.ties.with_tied(np.zeros(len(s.points), bool)).any()


@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10"])
def test_near_parts_give_the_pressures_of_all(kind):
    # a punch round one corner of a divided block: what is far is left out, multipliers of what is near are whole
    mesh = boxed(part(kind, (0, 0, 0), (1.7, 1.2, 1), (2, 2, 1)))
    punch = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "bottom", {"top": "xyz"}).placed((2.4, 0.3, 2.0))
    below = fc.ElasticBody(stairs(kind), fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"})
    scene = fc.Scene([below, punch], [fc.Contact(below, punch, coupling="mortar", swap="never")])
    near, every = (
        scene.solve(motions={punch: {"z": -0.01}}, search=search, finite_motion=False).contacts[0]
        for search in ("local", "global")
    )
    assert abs(near.total_force / every.total_force - 1) < 1e-9
    assert np.abs(np.sort(near.forces[near.active]) - np.sort(every.forces[every.active])).max() < 1e-9
