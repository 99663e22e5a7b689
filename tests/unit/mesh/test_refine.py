"""Local division of meshes: what the children fill, what is carried over, what hangs and what is refused."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from refine_cases import CASES, bent, check_levels, locally_refined, mesh_of, near, one_edge_pair, refined_near
from refusals import refused
from scipy.spatial import cKDTree

import fecontact as fc
from fecontact import InputError, Mesh
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.element import EDGES, FACES
from fecontact.mesh.facets import facet_integrals, nodal_areas
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.pick import neighbouring_sides
from fecontact.mesh.refine import refined, touching

# volumes, areas and positions: sums of a few thousand numbers of size one
ROUNDING = 1e-12


def block(element="hex20", divisions=(3, 3, 3), **options):
    return fc.shapes.block((1.0, 1.0, 1.0), divisions, element=element, **options)


def corner(element="hex20", levels=3):
    """A block divided again and again towards a place near its top."""
    return refined_near(block(element), np.array([0.35, 0.4, 1.0]), [0.5, 0.3, 0.2][:levels])


def area(mesh, name):
    _, _, dA = facet_integrals(mesh.points, mesh.face_nodes(mesh.faces(name)))
    return float(np.linalg.norm(dA, axis=2).sum())


def places(points):
    """Points as a set, rounded so that rounding does not tell them apart."""
    return set(map(tuple, (np.round(points, 9) + 0.0).tolist()))


# what hangs, by hand


def test_two_cubes_of_eight_nodes_one_divided():
    mesh = refined(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"), [0])
    ties = mesh.hanging
    assert len(mesh.cells) == 9
    assert len(ties.nodes) == 5
    assert (mesh.points[ties.nodes, 0] == 1).all()
    for node, row in zip(ties.nodes, ties.weights.toarray(), strict=True):
        x = mesh.points[node]
        # in the middle of an edge, or of the face
        ends = np.abs(mesh.points - x).max(axis=1) <= 0.5
        coarse = ends & np.isin(mesh.points, [0, 1]).all(axis=1) & (mesh.points[:, 0] == 1)
        coarse &= (np.abs(mesh.points - x)[:, 1:] == (np.mod(x, 1) != 0)[1:] * 0.5).all(axis=1)
        assert coarse.sum() == (4 if (x[1:] == 0.5).all() else 2)
        assert np.abs(row - coarse / coarse.sum()).max() < ROUNDING


def test_two_cubes_of_twenty_nodes_one_divided():
    mesh = refined(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1)), [0])
    ties = mesh.hanging
    # on the face between: 8 halfway points of its edges, its centre, 4 points between centre and edges
    assert len(ties.nodes) == 13
    assert len(ties.edges) == 4
    assert len(ties.quads) == 1
    at = {tuple(x): k for k, x in enumerate(mesh.points.tolist())}
    rows = dict(zip(ties.nodes.tolist(), ties.weights.toarray(), strict=True))
    centre = rows[at[1.0, 0.5, 0.5]]
    assert sorted(centre[centre != 0].round(12)) == [-0.25] * 4 + [0.5] * 4
    quarter = rows[at[1.0, 0.25, 0.0]]
    for x, weight in (((1.0, 0.0, 0.0), 0.375), ((1.0, 0.5, 0.0), 0.75), ((1.0, 1.0, 0.0), -0.125)):
        assert abs(quarter[at[x]] - weight) < ROUNDING
    for a, m, b, near_a, near_b in mesh.points[ties.edges]:
        assert np.abs(m - (a + b) / 2).max() == 0
        assert np.abs(near_a - (a + m) / 2).max() == 0
        assert np.abs(near_b - (m + b) / 2).max() == 0


def test_two_tetrahedra_of_ten_nodes_one_divided():
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1.0]])
    mesh = refined(Mesh(x, np.array([[0, 1, 2, 2, 3, 3, 3, 3], [1, 0, 2, 2, 4, 4, 4, 4]])).upgraded(20), [0])
    # on the triangle between: two halfway points on each edge, three between the middles of edges
    assert len(mesh.hanging.nodes) == 9
    assert (mesh.points[mesh.hanging.nodes, 2] == 0).all()
    at = {tuple(p): k for k, p in enumerate(mesh.points.tolist())}
    row = mesh.hanging.weights.toarray()[mesh.hanging.nodes.tolist().index(at[0.25, 0.25, 0.0])]
    # L = (1/2, 1/4, 1/4): L (2 L - 1) at corners, 4 L L between them
    expected = {(0, 0): 0, (1, 0): -1 / 8, (0, 1): -1 / 8, (0.5, 0): 1 / 2, (0, 0.5): 1 / 2, (0.5, 0.5): 1 / 4}
    assert all(abs(row[at[(*p, 0.0)]] - weight) < ROUNDING for p, weight in expected.items())


# shape and sets


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize(("kind", "width"), CASES)
def test_children_fill_their_parents(kind, width, curved):
    mesh = mesh_of(kind, width).mapped(bent) if curved else mesh_of(kind, width)
    fine = refined_near(mesh, np.array([1.2, 1.4, mesh.points[:, 2].max() - 1.1]), [1.0, 0.5])
    check_mesh(fine)
    assert np.abs(fine.points[: len(mesh.points)] - mesh.points).max() == 0
    volume, centre = moments_of_volume(mesh)
    new_volume, new_centre = moments_of_volume(fine)
    assert abs(new_volume / volume - 1) < ROUNDING
    # of curved cells the quadrature gives no exact first moments
    assert np.abs(new_centre - centre).max() < (1e-6 if curved else ROUNDING)
    assert np.abs(fine.hanging.followed(fine.points) - fine.points).max() < ROUNDING
    before, after = (nodal_areas(m.points, m.face_nodes(m.outer_faces)).sum() for m in (mesh, fine))
    assert abs(after / before - 1) < (1e-6 if curved else ROUNDING)


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_all_divided_is_the_uniform_mesh(element):
    fine = refined(block(element, (2, 2, 2)), np.arange(8))
    uniform = block(element, (4, 4, 4))
    assert fine.hanging is None
    assert places(fine.points) == places(uniform.points)
    assert len(fine.points) == len(uniform.points)
    centres = [m.points[m.cells].mean(axis=1) for m in (fine, uniform)]
    assert places(centres[0]) == places(centres[1])
    for name in uniform.boundaries:
        assert places(fine.points[fine.boundary_nodes(name)]) == places(uniform.points[uniform.boundary_nodes(name)])


@pytest.mark.parametrize(("kind", "width"), CASES)
def test_what_is_divided_bit_by_bit_is_in_the_end_divided_as_at_once(kind, width):
    mesh = mesh_of(kind, width, n=2)
    left = mesh.points[mesh.cells[:, :8]].mean(axis=1)[:, 0] < 1
    parts = refined(mesh, left)
    assert parts.hanging is not None
    # undivided cells come first
    parts = refined(parts, np.arange(len(mesh.cells) - left.sum()))
    assert parts.hanging is None
    whole = refined(mesh, np.arange(len(mesh.cells)))
    assert whole.hanging is None
    check_mesh(whole)
    assert places(parts.points) == places(whole.points)
    assert len(parts.points) == len(whole.points)


def test_boundaries_groups_and_node_sets_are_carried():
    mesh = block().with_group("left", lambda x: x[:, 0] < 0.3)
    mesh = replace(mesh, node_sets={"floor": mesh.boundary_nodes("bottom"), "edge": line(mesh), "one": np.array([7])})
    fine = refined_near(mesh, np.array([0.3, 0.4, 0.0]), [0.5, 0.3, 0.2])
    assert places(fine.points[fine.node_sets["floor"]]) == places(fine.points[fine.points[:, 2] == 0])
    assert set(fine.node_sets["edge"]) == set(line(fine))
    assert fine.node_sets["one"].tolist() == [7]
    named = np.concatenate([fine.faces(n) for n in mesh.boundaries])
    assert sorted(map(tuple, named)) == sorted(map(tuple, fine.outer_faces))
    for name in mesh.boundaries:
        assert abs(area(fine, name) - 1) < ROUNDING
        assert np.ptp(fine.points[fine.boundary_nodes(name)], axis=0).min() == 0
    centres = fine.points[fine.cells[:, :8]].mean(axis=1)
    assert set(fine.groups["left"]) == set(np.flatnonzero(centres[:, 0] < 1 / 3))


def line(mesh):
    return np.flatnonzero((mesh.points[:, 0] == 0) & (mesh.points[:, 2] == 0))


@pytest.mark.parametrize("kind", ["hexahedra", "tetrahedra", "all kinds"])
def test_children_of_faces_with_midface_nodes_get_theirs(kind):
    mesh = mesh_of(kind, 20).with_boundary("cap", lambda x: x[:, 2] == mesh_of(kind, 8).points[:, 2].max())
    plain = refined(mesh, touching(mesh, mesh.faces("cap")[:1]))
    fine = refined(mesh.with_midface_nodes(("cap",)), touching(mesh, mesh.faces("cap")[:1]))
    expected = plain.with_midface_nodes(("cap",))
    assert list(fine.boundaries) == ["cap"]
    assert places(fine.points) == places(expected.points)
    assert (fine.midface >= 0).sum() == len(expected.faces("cap"))
    assert np.abs(fine.hanging.followed(fine.points) - fine.points).max() < ROUNDING
    check_mesh(fine)


def test_notes_stay_and_nothing_to_divide_is_the_mesh_itself():
    mesh = replace(block(), notes=("mended",))
    assert refined(mesh, []) is mesh
    assert refined(mesh, np.zeros(27, bool)) is mesh
    assert refined(mesh, [3]).notes == ("mended",)


# hanging nodes


@pytest.mark.parametrize(("kind", "width"), CASES)
def test_hanging_nodes_hold_every_polynomial_that_the_cells_hold(kind, width):
    mesh = locally_refined(kind, width, 3)
    if kind == "hexahedra":
        order = {8: 1, 20: 2, 27: 2}[width]
        powers = list(product(range(order + 1), repeat=3))
        # 20 nodes: no monomial of superlinear degree beyond two (Arnold and Awanou 2011)
        powers = [p for p in powers if width != 20 or sum(k for k in p if k > 1) <= 2]
        assert len(powers) == width
    else:
        powers = [p for p in product(range(3), repeat=3) if sum(p) <= (1 if width == 8 else 2)]
    for p in powers:
        u = np.prod((mesh.points - 1.3) ** p, axis=1)[:, None]
        assert np.abs(mesh.hanging.followed(u) - u).max() < ROUNDING * 10, p


@pytest.mark.by_day("hexahedra-8", "hexahedra-27", "wedges-8")
@pytest.mark.parametrize(("kind", "width"), CASES)
def test_no_whole_edge_or_face_has_two_points_in_it(kind, width):
    """By geometry alone: corners strictly inside every edge and face of every cell, straight cells."""
    mesh = locally_refined(kind, width, 3)
    corners = mesh.points[np.unique(mesh.cells[:, :8])]
    tree = cKDTree(corners)
    seen = {"edge": 0, "face": 0}
    for cell in mesh.cells[:, :8]:
        for a, b in mesh.points[cell[EDGES]]:
            if np.abs(b - a).max() == 0:
                continue
            x = corners[tree.query_ball_point((a + b) / 2, 0.499 * np.linalg.norm(b - a))]
            off = np.linalg.norm(np.cross(x - a, b - a), axis=1) / np.linalg.norm(b - a)
            inside = x[off < 1e-9]
            assert len(inside) <= 1
            assert len(inside) == 0 or np.abs(inside[0] - (a + b) / 2).max() < 1e-9
            seen["edge"] += len(inside)
        for face in FACES[:, :4]:
            ring = mesh.points[list(dict.fromkeys(cell[face]))]
            if len(ring) < 3:
                continue
            x = corners[
                tree.query_ball_point(ring.mean(axis=0), np.linalg.norm(ring - ring.mean(axis=0), axis=1).max())
            ]
            normal = np.cross(ring[1] - ring[0], ring[2] - ring[0])
            normal /= np.linalg.norm(normal)
            x = x[np.abs((x - ring[0]) @ normal) < 1e-9]
            along = np.roll(ring, -1, axis=0) - ring
            within = [((np.cross(along[k], x - ring[k]) @ normal) > 1e-9) for k in range(len(ring))]
            inside = x[np.all(within, axis=0)]
            assert len(inside) <= (1 if len(ring) == 4 else 0)
            seen["face"] += len(inside)
    # every divided edge was seen, once for each undivided cell at it or more
    assert seen["edge"] >= len(mesh.hanging.edges)
    assert seen["face"] == len(mesh.hanging.quads)


def test_levels_of_cubes_differ_by_no_more_than_one_over_faces_and_edges():
    mesh = corner("hex8")
    check_levels(mesh.points[mesh.cells])


@pytest.mark.parametrize(("kind", "width"), [("hexahedra", 20), ("tetrahedra", 20), ("all kinds", 8)])
def test_numbers_of_points_and_cells_do_not_matter(kind, width):
    rng = np.random.default_rng(3)
    mesh = mesh_of(kind, width, n=2)
    point, cell = rng.permutation(len(mesh.points)), rng.permutation(len(mesh.cells))
    points = np.empty_like(mesh.points)
    points[point] = mesh.points
    other = Mesh(points, point[mesh.cells[cell]])
    place = np.array([0.4, 0.6, 1.1])
    one, two = (refined_near(m, place, [0.8, 0.5]) for m in (mesh, other))
    assert places(one.points) == places(two.points)
    _, match = cKDTree(two.points).query(one.points)
    T = [m.hanging.weights for m in (one, two)]
    order = {node: k for k, node in enumerate(two.hanging.nodes.tolist())}
    rows = [order[match[node]] for node in one.hanging.nodes]
    assert np.abs(T[0].toarray() - T[1].toarray()[rows][:, match]).max() < ROUNDING
    sets = [{tuple(sorted(c)) for c in cells[:, :8].tolist()} for cells in (match[one.cells], two.cells)]
    assert sets[0] == sets[1]


@pytest.mark.parametrize(("scale", "offset"), [(1.0, 1e3), (1e-6, 0.0), (1e6, 1e9)])
def test_neither_size_nor_place_chooses_among_equal_diagonals(scale, offset):
    # the three diagonals of these tetrahedra are partly equal
    mesh = mesh_of("tetrahedra", 20, n=2)
    moved = mesh.mapped(lambda x: scale * x + offset)
    cells = near(mesh, [0.5, 0.5, 1.0], 0.8)
    assert (refined(mesh, cells).cells == refined(moved, cells).cells).all()


def test_the_inner_diagonal_is_the_shortest():
    # a flat tetrahedron: the middles of edges 01 and 23 lie nearest to one another
    x = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0.1], [0, 1, 0.1]])
    fine = refined(Mesh(x, np.array([[0, 1, 2, 2, 3, 3, 3, 3]])), [0])
    pairs = {tuple(sorted(e)) for c in fine.cells[:, [0, 1, 2, 4]].tolist() for e in product(c, c) if e[0] != e[1]}
    lengths = {tuple(sorted((a, b))): np.linalg.norm(fine.points[a] - fine.points[b]) for a, b in pairs}
    assert abs(min(lengths.values()) - 0.1) < ROUNDING


# cells in other forms


@pytest.mark.parametrize("kind", ["wedge", "pyramid", "tetrahedron"])
@pytest.mark.parametrize("width", [8, 20])
def test_cells_collapsed_otherwise_turn_into_the_usual_form(degenerate, kind, width):
    mesh = degenerate(kind, width)
    mesh = replace(mesh, boundaries={str(f): np.array([[c, f]]) for c, f in mesh.outer_faces})
    fine = refined(mesh, [0])
    check_mesh(fine)
    names = {"wedge": ("wedge6", "wedge15"), "pyramid": ("pyramid5", "pyramid13"), "tetrahedron": ("tet4", "tet10")}
    assert names[kind][width == 20] in fine.kinds
    assert abs(moments_of_volume(fine)[0] / moments_of_volume(mesh)[0] - 1) < ROUNDING
    for name in mesh.boundaries:
        assert len(fine.faces(name)) == 4
        assert abs(area(fine, name) / area(mesh, name) - 1) < ROUNDING
    assert fine.notes == ()


@pytest.mark.parametrize("width", [8, 20])
def test_odd_cells_become_stars_which_the_notes_say(width):
    mesh = one_edge_pair(width)
    mesh = replace(mesh, boundaries={"skin": mesh.outer_faces}, groups={"left": np.array([0])})
    fine = refined(mesh, [0])
    check_mesh(fine)
    assert fine.notes[-1].startswith("1 collapsed hexahedra were converted to pyramids and tetrahedra")
    # four pyramids and two tetrahedra, divided into ten and eight
    assert len(fine.cells) == 1 + 4 * 10 + 2 * 8
    assert len(fine.groups["left"]) == 56
    assert len(fine.faces("skin")) == 5 + 5 * 4
    assert sorted(map(tuple, fine.faces("skin"))) == sorted(map(tuple, fine.outer_faces))
    assert abs(moments_of_volume(fine)[0] / moments_of_volume(mesh)[0] - 1) < ROUNDING
    assert np.abs(fine.hanging.followed(fine.points) - fine.points).max() < ROUNDING
    both = refined(fine, [0])
    assert both.hanging is None
    check_mesh(both)


def test_a_star_beside_what_is_divided_already():
    # the second cell becomes a star when its neighbour is divided twice; its face keeps its hanging nodes till then
    mesh = one_edge_pair(20)
    first = refined(mesh, [0])
    wall = (
        np.unique(first.hanging.quads[:, :4]) if len(first.hanging.quads) else np.unique(first.hanging.triangles[:, :3])
    )
    at = np.flatnonzero(np.isin(first.cells[1:, :8], wall).any(axis=1)) + 1
    second = refined(first, at)
    check_mesh(second)
    assert len(second.notes) == 2
    assert np.abs(second.hanging.followed(second.points) - second.points).max() < ROUNDING
    assert abs(moments_of_volume(second)[0] / moments_of_volume(mesh)[0] - 1) < ROUNDING


# what touches


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_touching_finds_what_meets_the_face_in_space(element):
    mesh = corner(element, 2)
    x = mesh.points[mesh.cells[:, :8]]
    low, high = x.min(axis=1), x.max(axis=1)
    counts = []
    for face in mesh.faces("top"):
        corners = mesh.points[mesh.cells[face[0], FACES[face[1], :4]]]
        met = (low <= corners.max(axis=0) + 1e-9).all(axis=1) & (high >= corners.min(axis=0) - 1e-9).all(axis=1)
        # a corner in the middle of another cell's inner face touches it in no node, and no surface has one
        assert touching(mesh, [face]).tolist() == np.flatnonzero(met).tolist()
        counts.append(met.sum())
    assert min(counts) < 9 < max(counts)


@pytest.mark.parametrize(("kind", "width"), CASES)
def test_where_all_that_touches_is_divided_no_node_of_the_faces_hangs(kind, width):
    mesh = mesh_of(kind, width)
    mesh = mesh.with_boundary("cap", lambda x: x[:, 2] == mesh.points[:, 2].max())
    faces = mesh.faces("cap")
    middle = mesh.points[mesh.face_nodes(faces)].mean(axis=1)
    marked = faces[np.argsort(np.linalg.norm(middle - [1.3, 1.4, 0], axis=1))[:2]]
    fine = refined(replace(mesh, boundaries={"cap": faces, "marked": marked}), touching(mesh, marked))
    assert not np.isin(fine.boundary_nodes("marked"), fine.hanging.nodes).any()


# refusals


def test_what_cannot_be_divided_is_refused():
    mesh = block()
    with refused(InputError, "input", "... 26", "[27]"):
        refined(mesh, [27])
    with refused(InputError, "input", "... 26"):
        refined(mesh, [-1])
    with refused(InputError, "input", "... 26"):
        refined(mesh, [0.5])
    with refused(InputError, "input", "27", "(3,)"):
        refined(mesh, np.ones(3, bool))
    with refused(InputError, "face-pair", "of 27"):
        touching(mesh, [[27, 0]])
    with refused(InputError, "face-pair", "of 27"):
        touching(mesh, [[0, 6]])


def test_collapsed_cells_of_27_nodes_are_refused():
    plain = block("hex27", (1, 1, 1))
    cells = plain.cells.copy()
    cells[0, [2, 9]] = cells[0, 1]
    with refused(InputError, "input", "Cell 0"):
        refined(Mesh(plain.points, cells), [0])


def test_hanging_nodes_that_no_division_made_are_refused():
    mesh = corner(levels=1)
    ties = HangingNodes(mesh.hanging.nodes, mesh.hanging.weights)
    other = replace(mesh, hanging=ties)
    with refused(InputError, "hanging-of-others", f"{len(ties.nodes)} hanging nodes"):
        refined(other, [0])
    assert refined(other, []) is other
    assert len(touching(other, other.faces("top"))) > 0


def test_points_put_elsewhere_take_hanging_nodes_along():
    mesh = corner(levels=1)
    moved = mesh.with_points(
        np.where(np.isin(np.arange(len(mesh.points)), mesh.hanging.nodes)[:, None], 7.0, mesh.points)
    )
    assert np.abs(moved.points - mesh.points).max() < ROUNDING
    with refused(InputError, "input", "(4, 3)"):
        mesh.with_points(np.zeros((4, 3)))


@pytest.mark.parametrize("kind", ["hexahedra", "tetrahedra", "all kinds"])
@pytest.mark.parametrize("width", [8, 20])
def test_picks_go_on_over_divided_sides_and_stop_at_edges(kind, width):
    mesh = locally_refined(kind, width, 2)
    top = mesh.points[:, 2].max()
    picked = mesh.with_boundary("cap", fc.pick.flood([0.4, 0.4, top + 0.5]))
    assert np.ptp(picked.points[picked.boundary_nodes("cap"), 2]) == 0
    assert abs(area(picked, "cap") - 9) < ROUNDING * 10
    round_corner = mesh.with_boundary("all", fc.pick.flood([0.4, 0.4, top + 0.5], angle=100))
    assert len(round_corner.faces("all")) == len(mesh.outer_faces)


def test_divided_sides_are_shared_with_both_their_parts():
    mesh = refined(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1)), [0])
    first, second, cosine = neighbouring_sides(mesh, mesh.faces("top"))
    # four small faces about their middle, two of them beside the large one
    assert len(first) == 4 + 2
    assert np.abs(cosine - 1).max() < ROUNDING
    assert sorted(np.bincount(np.concatenate([first, second]) // 4).tolist()) == [2, 2, 2, 3, 3]
