"""Pairs of points, their weights, and which of them are candidates."""

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import MeshError
from fecontact.contact import candidates
from fecontact.contact.coupling.nodal import SurfacePair, nested, pair
from fecontact.mesh.element import quad_nodes
from fecontact.mesh.facets import nodal_areas, tributary_areas
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along, contact_weights

pytestmark = pytest.mark.rounding(0)

IDENTITY, ORIGIN = np.eye(3), np.zeros(3)


def top(divisions, rich=True, size=(1.0, 1.0, 1.0), element="hex20"):
    mesh = fc.shapes.block(size, divisions, element=element)
    mesh = mesh.with_midface_nodes(("top",)) if rich and element == "hex20" else mesh
    return FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("top")), "top")


def bottom(divisions, rich=True, size=(1.0, 1.0, 1.0)):
    mesh = fc.shapes.block(size, divisions).translated((0, 0, size[2]))
    mesh = mesh.with_midface_nodes(("bottom",)) if rich else mesh
    return FacetSurface(mesh.points, mesh.face_nodes(mesh.faces("bottom")), "bottom")


def sphere_pair(turn=0.0):
    """Caps of two balls of radius 2 and 3 touching at the origin, one turned about z and moved."""
    upper = fc.shapes.half_sphere(2.0, contact_radius=0.1, level=1).with_midface_nodes(("cap",))
    lower = fc.shapes.half_sphere(3.0, contact_radius=0.1, level=1).with_midface_nodes(("cap",))
    flip = fc.rotation_about((1, 0, 0), np.pi)
    slave = FacetSurface(upper.points, upper.face_nodes(upper.faces("cap")))
    master = FacetSurface(lower.points @ flip.T, lower.face_nodes(lower.faces("cap")))
    return (
        slave,
        master,
        pair(SurfacePair(slave, master, fc.rotation_about((0, 0, 1), turn), np.array([0.01, 0.02, 0.001]))),
    )


def test_pair_of_equal_faces():
    slave, master = bottom((2, 2, 1)), top((2, 2, 1))
    p = pair(SurfacePair(slave, master, IDENTITY, ORIGIN))
    assert len(p.nodes) == 25
    assert p.n_beyond == 0
    assert np.abs(p.gap).max() < 1e-15
    assert abs(p.weights.sum() - 1) < 1e-14
    assert np.abs(p.slave_normals - [0, 0, 1]).max() < 1e-15


def test_points_beyond_the_master_are_left_out_and_counted():
    slave = bottom((4, 4, 1), size=(2.0, 1.0, 1.0))
    p = pair(SurfacePair(slave, top((2, 2, 1)), IDENTITY, ORIGIN))
    assert p.n_beyond > 0
    assert len(p.nodes) + p.n_beyond == len(slave.nodes)
    assert slave.points[p.nodes][:, 0].max() == 1.0


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_forces_and_moments_of_every_pair_balance(turn):
    slave, _, p = sphere_pair(turn)
    rotation, translation = fc.rotation_about((0, 0, 1), turn), np.array([0.01, 0.02, 0.001])
    forces = np.random.default_rng(5).random(len(p.nodes))
    on_slave = (p.slave_rows.T @ forces).reshape(-1, 3)
    on_master = (components_along(p.projection.weights, -p.projection.normals).T @ forces).reshape(-1, 3)
    x = slave.points @ rotation.T + translation
    y = sphere_pair(turn)[1].points
    total = on_slave.sum(axis=0) @ rotation.T + on_master.sum(axis=0)
    moment = np.cross(x, on_slave @ rotation.T).sum(axis=0) + np.cross(y, on_master).sum(axis=0)
    assert np.abs(total).max() < 1e-13 * forces.sum()
    assert np.abs(moment).max() < 1e-12 * forces.sum()


def test_gaps_do_not_depend_on_the_common_pose():
    slave, master, p = sphere_pair()
    assert np.abs(p.slave_normals - p.projection.normals).max() < 1e-15
    Q = fc.rotation_about((1, 2, -1), 1.1)
    turned = FacetSurface(master.points @ Q.T, master.facets)
    q = pair(SurfacePair(slave, turned, Q, Q @ [0.01, 0.02, 0.001]))
    assert np.array_equal(p.nodes, q.nodes)
    assert np.abs(p.gap - q.gap).max() < 1e-14
    assert np.abs(p.slave_normals - q.slave_normals).max() < 1e-9  # Newton stops at 1e-14 in facet coordinates


def test_gap_of_two_balls():
    _, _, p = sphere_pair()
    near = np.hypot(*p.slave_points[:, :2].T) < 0.15
    centres = np.array([0.01, 0.02, 2.001]), np.array([0, 0, -3.0])
    x = p.slave_points + np.array([0.01, 0.02, 0.001])
    exact = np.linalg.norm(x - centres[1], axis=1) - 3.0
    # quadratic facets of size up to 0.1 on a ball of radius 3: h^4/R^3
    assert np.abs(p.gap - exact)[near].max() < 4e-6
    assert np.abs(np.linalg.norm(x - centres[0], axis=1) - 2.0)[near].max() < 4e-6


def test_along_takes_components():
    weights = sp.csr_matrix(np.array([[0.25, 0.75, 0.0], [0.0, 0.0, 1.0]]))
    directions = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 0.0]])
    u = np.arange(9.0).reshape(3, 3)
    expected = [directions[0] @ (0.25 * u[0] + 0.75 * u[1]), -u[2, 1]]
    assert np.abs(components_along(weights, directions) @ u.ravel() - expected).max() < 1e-15


@pytest.mark.parametrize(
    ("slave", "master", "expected"),
    [
        (2, 2, True),
        (4, 2, True),
        (5, 1, True),
        (6, 3, True),
        (2, 3, False),
        (3, 2, False),
        (1, 5, False),
        (2, 4, False),
    ],
)
@pytest.mark.parametrize("rich", [True, False])
def test_nested(slave, master, expected, rich):
    s, m = bottom((slave, slave, 1), rich), top((master, master, 1), rich)
    found = SurfacePair(s, m, IDENTITY, ORIGIN)
    assert nested(found, np.arange(len(found.nodes))) is expected


def test_weights_by_kind_of_face():
    x = top((2, 2, 1))
    assert np.array_equal(contact_weights(x), nodal_areas(x.points, x.facets))
    plain = top((2, 2, 1), rich=False)
    weights = contact_weights(plain)
    assert np.array_equal(weights, tributary_areas(plain.points, plain.facets))
    assert weights[plain.nodes].min() > 0
    assert abs(weights.sum() - 1) < 1e-14
    for element in ("hex8", "hex27"):
        surface = top((2, 2, 1), element=element)
        assert contact_weights(surface)[surface.nodes].min() > 0


def test_a_badly_distorted_face_is_refused():
    # under y = 0.05 + 0.95 x^2 the area element grows like x^2, whose Simpson weight at x = 0 is -1/60
    st = quad_nodes(9)
    height = 0.05 + 0.95 * st[:, 0] ** 2
    surface = FacetSurface(np.column_stack([st[:, 0], st[:, 1] * height, np.zeros(9)]), np.arange(9)[None], "lid")
    with refused(MeshError, "no-area", "Face 0", "'lid'"):
        contact_weights(surface)


def test_approach_for_load_of_a_paraboloid():
    r = np.sqrt(np.arange(2000) + 0.5) * 0.01
    area = np.full(2000, np.pi * 1e-4)
    R, modulus, force = 5.0, 3.0, 0.01
    hertz = (9 * force**2 / (16 * modulus**2 * R)) ** (1 / 3)
    found = candidates.approach_for_load(r**2 / (2 * R), area, modulus, force)
    # E* V / sqrt(A) with V = pi R d^2, A = 2 pi R d: 1.253 E* sqrt(R) d^1.5 against 4/3; sums over rings, 1 percent
    assert abs(found / hertz - (4 / 3 / (np.pi / np.sqrt(2 * np.pi))) ** (2 / 3)) < 0.01


def test_approach_grows_with_the_load_and_passes_the_last_point():
    gap, area = np.array([0.0, 0.1, 0.3]), np.ones(3)
    found = [candidates.approach_for_load(gap, area, 1.0, f) for f in (1e-6, 1e-3, 0.1, 1.0, 100.0)]
    assert (np.diff(found) >= 0).all()
    # everything overlaps: E* (sum(d - g)) / sqrt(3) = force
    assert abs((3 * found[-1] - 0.4) / np.sqrt(3) - 100) < 1e-12


def test_choose_and_grow():
    gap = np.linspace(0, 1, 101)
    chosen = candidates.choose(gap, 0.5)
    assert np.array_equal(chosen, np.arange(int(0.5 * candidates.MARGIN * 100) + 1))
    rubbing = candidates.choose(gap, 0.5, rubs=True)
    assert np.array_equal(rubbing, np.arange(int(0.5 * candidates.RUBBING_MARGIN * 100) + 1))
    assert len(candidates.choose(gap, 0.0)) == candidates.MIN_CANDIDATES
    assert len(candidates.choose(gap[:5], 0.0)) == 5
    # of gaps that rounding alone tells apart, all or none are chosen: their order is that of the numbering
    level = 1e-16 * np.arange(40)
    assert len(candidates.choose(np.r_[level, 1.0], 0.0, equal=1e-12)) == 40
    assert len(candidates.choose(np.r_[level, 1.0], 0.0)) == candidates.MIN_CANDIDATES
    penetrating = np.zeros(101, bool)
    penetrating[[40, 61]] = True
    assert np.array_equal(candidates.grow(chosen, gap, penetrating), np.arange(92))


def test_approach_between_two_points_is_that_of_the_area_so_far():
    # the first of two areas of 1 overlaps by d: E* d = force, up to the second point at a gap of 0.2; there both do
    gap, area = np.array([0.0, 0.2]), np.ones(2)
    for d in (0.05, 0.14):
        assert abs(candidates.approach_for_load(gap, area, 3.0, 3.0 * d) / d - 1) < 1e-12


def test_widen_takes_in_twice_the_gap_and_as_many_again():
    gap = np.array([0.0, 0.1, 0.15, 0.19, 0.21, 0.3, 0.4])
    assert candidates.widen(np.array([0, 1]), gap).tolist() == [0, 1, 2, 3]
    assert candidates.widen(np.array([0]), gap).tolist() == [0, 1]
    assert candidates.widen(np.arange(5), gap).tolist() == list(range(7))
    # what was chosen stays, however far
    assert candidates.widen(np.array([0, 6]), gap).tolist() == list(range(7))


def test_grow_keeps_those_it_had():
    gap = np.array([0.0, 0.5, 0.1, 2.0])
    penetrating = np.array([False, False, True, False])
    assert candidates.grow(np.array([3]), gap, penetrating).tolist() == [0, 2, 3]


def test_mesh_of_one_cell_pairs_with_a_plane():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    surface = FacetSurface(mesh.points, mesh.face_nodes(np.array([[0, 4]])))
    p = pair(SurfacePair(surface, fc.Plane(), IDENTITY, np.array([0, 0, 0.5])))
    assert np.array_equal(p.gap, np.full(4, 0.5))
    assert p.projection.weights is None
