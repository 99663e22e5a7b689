"""Pairing restricted to what can come near: the same forces, and bounds that hold."""

import numpy as np
import pytest
from common_scenes import knee

import fecontact as fc
from fecontact.contact import search_region as search
from fecontact.contact.coupling.mortar import pair_mortar
from fecontact.contact.coupling.nodal import SurfacePair, pair
from fecontact.contact.loads import LoadStep
from fecontact.mesh.element import QUAD_CORNERS
from fecontact.mesh.facets import facet_shapes
from fecontact.scene import local_search
from fecontact.surfaces.closest_point import BULGE
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.normals import normals_of, project_along

SOLID = fc.Material(E=1000.0, nu=0.3)


def grid(n, height, side=2.0, quadratic=False):
    """A surface of n x n facets over a square, as high as height(x, y)."""
    m = 2 * n if quadratic else n
    x, y = np.meshgrid(*[np.linspace(-side, side, m + 1)] * 2, indexing="ij")
    points = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)
    index = np.arange((m + 1) ** 2).reshape(m + 1, m + 1)
    if not quadratic:
        facets = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    else:
        a, b = slice(0, -2, 2), slice(2, None, 2)
        c = slice(1, None, 2)
        facets = [index[s] for s in ((a, a), (b, a), (b, b), (a, b), (c, a), (b, c), (c, b), (a, c), (c, c))]
    return FacetSurface(points, np.stack([f.ravel() for f in facets], axis=1))


def bowl(x, y):
    """A paraboloid."""
    return (x**2 + y**2) / 4


def turned_over(surface):
    """The same surface facing down."""
    columns = [0, 3, 2, 1] if surface.facets.shape[1] == 4 else [0, 3, 2, 1, 7, 6, 5, 4, 8]
    return FacetSurface(surface.points, surface.facets[:, columns])


HERE = np.eye(3), np.zeros(3)


@pytest.mark.parametrize("quadratic", [False, True])
def test_clearance_is_a_lower_bound_and_within_reach_nothing_is_missed(quadratic):
    slave, master = turned_over(grid(10, bowl, quadratic=quadratic)), grid(13, lambda x, y: 0.1 * x * y - 0.02)
    part = search.search_region(slave, master, *HERE, search_radius=0.2)
    # against the distances of many points of every part from the master
    cut = search.parts_of(slave)
    assert len(cut.owner) == len(slave.facets) * (4 if quadratic else 1)
    facet, places = samples(cut.surface)
    projection = master.project(places)
    distance = least(facet, np.linalg.norm(places - projection.points, axis=1))
    assert part.within[distance <= 0.2].all()
    # not so cautious as to be useless: half of what is out of reach by far is recognised
    assert (~part.within).sum() > 30
    assert (~part.within[distance > 0.5]).mean() > 0.5
    assert part.facets[cut.owner[part.within]].all()
    # all facets of a kept node are paired, and all nodes of what is within reach are kept
    assert part.facets[np.isin(slave.facets, np.flatnonzero(part.nodes)).any(axis=1)].all()
    assert part.nodes[slave.facets[cut.owner[part.within]][cut.columns[part.within]]].all()
    assert part.opposite[np.unique(projection.facet[part.facets[cut.owner[facet]]])].all()


def samples(surface):
    """Many points of every facet: facet and place."""
    X = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 2, indexing="ij"), -1).reshape(-1, 2)
    facet = np.repeat(np.arange(len(surface.facets)), len(X))
    return facet, surface.evaluate(facet, np.tile(X, (len(surface.facets), 1)))[0]


def least(facet, values):
    """The smallest value on every facet."""
    out = np.full(facet.max() + 1, np.inf)
    np.minimum.at(out, facet, values)
    return out


@pytest.mark.parametrize("quadratic", [False, True])
def test_gaps_of_parts_left_out_stay_open_under_the_drift_they_were_left_out_for(quadratic):
    slave, master = turned_over(grid(10, bowl, quadratic=quadratic)), grid(13, lambda x, y: 0.1 * x * y - 0.1)
    increment = search.RigidIncrement(np.array([0.2, -0.1, -0.15]), np.array([0.05, -0.3, 0.1]))
    part = search.search_region(slave, master, *HERE, 0.1, increment)
    facet, places = samples(search.parts_of(slave).surface)
    cut = search.parts_of(slave)
    owner, corner = np.repeat(cut.owner, 25), np.tile([0.0, 0.25, 0.5, 0.75, 1.0], 5 * len(cut.owner))
    assert len(owner) == len(places)
    across = np.tile(np.repeat([0.0, 0.25, 0.5, 0.75, 1.0], 5), len(cut.owner))
    local = np.stack([across, corner], axis=1)
    if quadratic:
        local = 0.5 * local + 0.5 * np.tile(np.repeat(QUAD_CORNERS, 25, axis=0), (len(slave.facets), 1))
    assert np.abs(slave.evaluate(owner, local)[0] - places).max() < 1e-14
    normals = -normals_of(slave).at(owner, local)
    assert (~part.within).mean() > 0.3
    for share in (0.0, 0.5, 0.95):
        projection = project_along(master, places, normals, share)
        # a linearised gap as the whole pairing has it; its lines lie between the cones
        gap = least(facet, projection.gap + np.einsum("ni,ni->n", projection.normals, increment.at(places)))
        assert gap[~part.within].min() > 0.1
    # a drift that opens leaves out more than no drift
    away = search.search_region(
        slave, master, *HERE, 0.1, search.RigidIncrement(np.array([0.0, 0.0, 0.3]), np.zeros(3))
    )
    assert away.within.sum() < search.search_region(slave, master, *HERE, 0.1).within.sum()


def test_lines_between_two_cones_close_gaps_no_faster_than_the_bound():
    rng = np.random.default_rng(3)
    n, tried = 400, 200
    axes = [np.array([0.0, 0.0, 1.0]), fc.rotation_about((1, 2, 0), 0.6)[:, 2]]
    angles = (0.25, 0.4)
    motion = rng.normal(size=(n, 3))
    cones = [search.Cones(np.tile(a, (n, 1)), np.full(n, angle)) for a, angle in zip(axes, angles, strict=True)]
    bound = search.least_along_lines(motion, *cones)
    inside = [within_cone(rng, a, angle, tried) for a, angle in zip(axes, angles, strict=True)]
    share = rng.uniform(size=(tried, 1))
    lines = share * inside[0] + (1 - share) * inside[1]
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    least_found = (motion @ lines.T).min(axis=1)
    assert (bound <= least_found + 1e-12).all()
    # the bound is no worse than the whole motion, and the slave's cone matters: the master's alone is no bound
    assert (bound >= -np.linalg.norm(motion, axis=1) - 1e-12).all()
    alone = search.least_along_lines(motion, cones[1], cones[1])
    assert (alone > least_found + 0.05).any()
    # where both cones are one and narrow it is what one normal gives
    thin = search.Cones(np.tile(axes[0], (n, 1)), np.zeros(n))
    assert np.abs(search.least_along_lines(motion, thin, thin) - motion[:, 2]).max() < 1e-12


def within_cone(rng, axis, angle, n):
    """Directions (n, 3) within a cone, its edge among them."""
    other = rng.normal(size=(n, 3))
    other -= (other @ axis)[:, None] * axis
    other /= np.linalg.norm(other, axis=1, keepdims=True)
    lean = angle * np.sqrt(rng.uniform(size=(n, 1)))
    lean[::2] = angle
    return np.cos(lean) * axis + np.sin(lean) * other


@pytest.mark.parametrize("quadratic", [False, True])
def test_interpolated_normals_lie_in_the_cones(quadratic):
    surface = grid(6, lambda x, y: 0.3 * np.sin(2 * x) * np.cos(y), quadratic=quadratic)
    cones = search.cones_of(surface)
    t = np.linspace(0, 1, 7)
    X = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    facet = np.repeat(np.arange(len(surface.facets)), len(X))
    normals = normals_of(surface).at(facet, np.tile(X, (len(surface.facets), 1)))
    cosine = np.einsum("ni,ni->n", normals, cones.axis[facet]) / np.linalg.norm(normals, axis=1)
    assert (np.arccos(np.clip(cosine, -1, 1)) <= cones.angle[facet] + 1e-9).all()


@pytest.mark.parametrize("columns", [4, 8, 9])
def test_normals_of_triangles_lie_in_the_cones(columns):
    plain = grid(5, lambda x, y: 0.3 * np.sin(2 * x) * np.cos(y), quadratic=True)
    corners = np.concatenate([plain.facets[:, [0, 1, 2, 2]], plain.facets[:, [0, 2, 3, 3]]])
    sides = np.concatenate([plain.facets[:, [4, 5, 2, 8]], plain.facets[:, [8, 6, 3, 7]]])
    middle = len(plain.points) + np.arange(len(corners))
    rng = np.random.default_rng(2)
    centres = plain.points[corners[:, :3]].mean(axis=1) + rng.uniform(-0.02, 0.02, (len(corners), 3))
    facets = np.column_stack([corners, sides, middle])[:, :columns]
    surface = FacetSurface(np.concatenate([plain.points, centres]), facets)
    cones = search.cones_of(surface)
    t = np.linspace(0, 1, 9)
    X = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    X = X[X.sum(axis=1) <= 1 + 1e-12]
    facet, local = np.repeat(np.arange(len(facets)), len(X)), np.tile(X, (len(facets), 1))
    inside = []
    for normals in (normals_of(surface).at(facet, local), surface.normals(facet, local)):
        cosine = np.einsum("ni,ni->n", normals, cones.axis[facet]) / np.linalg.norm(normals, axis=1)
        inside.append(np.arccos(np.clip(cosine, -1, 1)).reshape(len(facets), -1).max(axis=1))
        assert (inside[-1] <= cones.angle + 1e-9).all()
    # they contain the neighbours' normals too, and are still far from useless
    assert np.median(cones.angle) < 6 * np.median(np.maximum(*inside))


@pytest.mark.parametrize("quadratic", [False, True])
def test_displacements_between_nodes_are_bounded(quadratic):
    surface = grid(4, bowl, quadratic=quadratic)
    nodal = np.random.default_rng(1).normal(size=surface.points.shape)
    cut = search.parts_of(surface)
    field = FacetSurface(nodal, surface.facets)
    _, values = samples(search.parts_of(field).surface)
    facet, _ = samples(cut.surface)
    for whole, of in ((False, facet), (True, cut.owner[facet])):
        mean, rest = search.mean_displacements(surface, nodal, whole)
        assert len(mean) == of.max() + 1
        largest = -least(of, -np.linalg.norm(values - mean[of], axis=1))
        assert (largest <= rest * (1 + 1e-12)).all()
        # and not so cautious as to be useless
        assert (rest < 4 * largest).all()


def arc(half_angle):
    """A strip round a cylinder of radius 1 with its axis along y, of two facets with nine nodes."""
    flat = grid(2, lambda x, y: 0 * x, side=1.0, quadratic=True)
    x, y, _ = flat.points.T
    angle = half_angle * x
    strip = FacetSurface(np.stack([np.sin(angle), 0.5 * y, np.cos(angle)], axis=1), flat.facets)
    keep = strip.points[strip.facets[:, 8], 1] > 0
    return FacetSurface(strip.points, strip.facets[keep])


def test_a_curved_facet_may_be_met_along_normals_that_are_not_its_middles():
    """A small plate beside the flank of a strip, parallel to the middle of the facet there, and driven sideways.

    Along the normal in the middle of the facet it hardly comes nearer, along that at its foot it goes through: only the
    cone of normals tells that.
    """
    master = arc(0.422)
    foot, distance = -0.399, 0.467
    centre = (1 + distance) * np.array([np.sin(foot), 0.0, np.cos(foot)]) + [0.0, 0.25, 0.0]
    known = search.bounds_of(master)
    axis = known.normal[np.linalg.norm(known.centre - centre, axis=1).argmin()]
    aside = np.cross([0.0, 1.0, 0.0], -axis)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.01
    slave = FacetSurface(centre + corners[:, :1] * aside + corners[:, 1:] * np.cross(-axis, aside), np.arange(4)[None])
    increment = search.RigidIncrement(1.631 * np.array([np.sin(1.602), 0.0, np.cos(1.602)]), np.zeros(3))
    projection = master.project(slave.points)
    opening = projection.gap + projection.normals @ increment.shift
    assert not projection.outside.any()
    assert projection.gap.min() > 0.45
    # it goes through at its foot, and would stay clear along the normal in the middle
    assert opening.max() < -0.15
    assert projection.gap.min() + axis @ increment.shift > 0.05
    assert search.search_region(slave, master, *HERE, 0.0, increment).within.all()
    # left out where nothing moves, it is missed when it does
    still = search.search_region(slave, master, *HERE, 0.0)
    assert not still.within.any()
    none = unmoved(1), unmoved(len(master.facets))
    assert search.find_missed(still, slave, master, *HERE, search.STILL, none) == (False, 0.0)
    assert search.find_missed(still, slave, master, *HERE, increment, none)[0]
    # and the bound is not so cautious as to keep what moves away
    away = search.RigidIncrement(axis, np.zeros(3))
    assert not search.search_region(slave, master, *HERE, 0.0, away).within.any()


def unmoved(n, rest=0.0):
    """Displacements of n facets about zero."""
    return np.zeros((n, 3)), np.full(n, rest)


def test_displacements_that_open_gaps_miss_nothing_and_those_that_close_them_do():
    slave, master = turned_over(grid(10, lambda x, y: 0 * x + 0.1)), grid(13, lambda x, y: 0 * x)
    turn = fc.rotation_about((1, 0, 0), 0.4)
    # the slave's own axes are turned against the master's
    slave = slave.moved(turn.T, np.zeros(3))
    part = search.search_region(slave, master, turn, np.zeros(3), search_radius=0.05)
    assert not part.within.any()
    closing = search.RigidIncrement(np.array([0.0, 0.0, -0.12]), np.zeros(3))
    up, n = np.array([0.0, 0.0, 0.01]), len(part.within)
    for own, other, missed in (
        (3 * up, 0 * up, False),
        (0 * up, -3 * up, False),
        (up, 0 * up, True),
        (up, 2 * up, True),
    ):
        fields = (np.tile(own @ turn, (n, 1)), np.full(n, 0.004)), (np.tile(other, (169, 1)), np.full(169, 0.005))
        assert search.find_missed(part, slave, master, turn, np.zeros(3), closing, fields)[0] is missed


def test_what_was_missed_is_seen_and_the_reach_that_suits_it():
    slave, master = turned_over(grid(10, lambda x, y: 0 * x + 0.1)), grid(13, lambda x, y: 0 * x)
    part = search.search_region(slave, master, *HERE, search_radius=0.05)
    assert not part.within.any()
    still = unmoved(len(part.within), 0.02), unmoved(len(master.facets), 0.03)
    assert search.find_missed(part, slave, master, *HERE, search.STILL, still) == (False, 0.0)
    closing = search.RigidIncrement(np.array([0.0, 0.0, -0.06]), np.zeros(3))
    missed, search_radius = search.find_missed(part, slave, master, *HERE, closing, still)
    # flat and parallel: 0.1 apart, 0.06 of it closed by the drift, and 0.05 at most bridged further aside
    assert missed
    assert 0.04 - 1e-12 < search_radius <= 0.05


def test_what_starts_inside_is_paired_however_deep():
    slave, master = turned_over(grid(8, lambda x, y: 0 * x - 1.5)), grid(8, lambda x, y: 0 * x)
    part = search.search_region(slave, master, *HERE, search_radius=0.01)
    assert part.facets.all()
    assert part.within.all()


@pytest.mark.parametrize(("columns", "triangle"), [(4, False), (4, True), (8, False), (8, True), (9, False), (9, True)])
def test_lebesgue_and_bulge_constants_bound_the_shape_functions(columns, triangle):
    t = np.linspace(0, 1, 61)
    X = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    X = X[X.sum(axis=1) <= 1 + 1e-12] if triangle else X
    N = np.abs(facet_shapes(columns, np.full(len(X), triangle), X)[0])
    assert N.sum(axis=1).max() <= search.lebesgue(columns) + 1e-12
    assert N[:, 4:].sum(axis=1).max() <= BULGE + 1e-12


@pytest.mark.parametrize("share", [0.0, 0.5])
@pytest.mark.parametrize("couple", [pair, pair_mortar])
def test_parts_of_many_facets_are_paired_as_the_whole(couple, share):
    slave, master = turned_over(grid(28, bowl)), grid(28, lambda x, y: 0.02 * x, side=2.03)
    part = search.search_region(slave, master, *HERE, search_radius=0.05)
    assert part.facets.mean() < 0.25
    whole, few = (
        couple(SurfacePair(slave, master, *HERE, share=share)),
        couple(SurfacePair(slave, master, *HERE, part, share)),
    )
    same = np.isin(whole.nodes, few.nodes)
    assert np.array_equal(whole.nodes[same], few.nodes)
    # equal but for the order of sums: 1e-13 of lengths of about one
    assert np.abs(whole.gap[same] - few.gap).max() < 1e-13
    assert np.abs(whole.weights[same] / few.weights - 1).max() < 1e-11
    assert abs(whole.slave_rows[same] - few.slave_rows).max() < 1e-11
    # nothing within reach was left out
    assert whole.gap[~same].min() > 0.05


def half_spheres():
    """Two elastic half spheres whose faces do not match."""
    above = fc.ElasticBody(fc.shapes.half_sphere(5.0, contact_radius=1.5, level=1), SOLID, "cap", {"base": "xyz"})
    mesh = fc.shapes.half_sphere(7.0, contact_radius=1.7, level=1)
    below = fc.ElasticBody(mesh, SOLID, "cap", {"base": "xyz"}, name="below")
    below = below.placed(
        (0.0, 0.0, 0.0), rotation=fc.rotation_about((1, 0, 0), np.pi) @ fc.rotation_about((0, 0, 1), 0.3)
    )
    return fc.Scene([above, below], [fc.Contact(above, below)]), {"motions": {above: {"z": -0.05}}}


def blocks():
    """A ball on a block, coupled by its nodes, pressed by a force."""
    lower = fc.ElasticBody(
        fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 2)).translated((-2.0, -2.0, -1.0)), SOLID, "top", {"bottom": "xyz"}
    )
    ball = fc.shapes.half_sphere(5.0, contact_radius=1.0, level=1)
    upper = fc.ElasticBody(ball, SOLID, "cap", {"base": "xyz"}, name="ball").placed((0.3, 0.1, 0.0))
    contact = fc.Contact(upper, lower, coupling="nodal")
    return fc.Scene([lower, upper], [contact]), {"forces": {upper: (0, 0, -5.0)}}


def pressed_knee():
    """The knee, turned, pressed and free to tilt."""
    now, bone = knee(turn=0.3)
    return now, {"forces": {bone: (0, 0, -500.0)}, "free": {bone: "ry"}}


SCENES = [half_spheres, pressed_knee, blocks]


def same_forces(whole, part):
    """Forces of both results on the slave's nodes; those of the part are the whole's."""
    for a, b in zip(whole.contacts, part.contacts, strict=True):
        forces = []
        for result, contact in ((whole, a), (part, b)):
            k = result.contacts.index(contact)
            nodal = np.zeros(result._interfaces[k].slave.surface(contact.surfaces[0]).points.shape[0])
            nodal[result._interfaces[k].pairing.nodes] = contact.forces
            forces.append(nodal)
        # both solve the same equations; differences are rounding times the condition of the compliance
        assert np.abs(forces[0] - forces[1]).max() < 1e-12 * a.total_force
        assert np.abs(a.force - b.force).max() < 1e-12 * a.total_force
        # located by gaps outside the contact, which are paired too
        one, other = (contact.summary()["area"] for contact in (a, b))
        assert abs(one - other) < 1e-9 * one


@pytest.mark.full
@pytest.mark.parametrize("scene", SCENES, ids=["spheres", "knee", "nodal"])
def test_forces_are_those_of_whole_surfaces(scene):
    now, loads = scene()
    whole, part = now.solve(**loads), now.solve(**loads, search="local")
    assert part.interfaces[0].region is not None
    same_forces(whole, part)
    assert part.residuals().penetration < 1e-9


@pytest.mark.by_day("nodal")
@pytest.mark.parametrize("scene", SCENES, ids=["spheres", "knee", "nodal"])
def test_too_short_a_reach_is_found_and_widened(scene, monkeypatch):
    now, loads = scene()
    whole = now.solve(**loads)
    tried = []
    solved = local_search.solved

    def counted(self, loading, search_radii, *rest):
        tried.append(search_radii)
        return solved(self, loading, search_radii, *rest)

    monkeypatch.setattr(local_search, "solved", counted)
    monkeypatch.setattr(
        "fecontact.scene.local_search.first_radius", lambda contact, loading: search.SearchRadius(1e-4, 1e-4)
    )
    part = now.solve(**loads, search="local")
    assert len(tried) > 1
    assert tried[0][0].distance == 1e-4
    same_forces(whole, part)


@pytest.mark.full
def test_loads_that_near_parts_cannot_balance_are_met_by_the_whole_surfaces(monkeypatch):
    now, loads = pressed_knee()
    # with no reach one condyle alone may be in reach and the free tilt unbalanced; the answer is the whole's anyway
    monkeypatch.setattr(
        "fecontact.scene.local_search.first_radius", lambda contact, loading: search.SearchRadius(0.0, 0.0)
    )
    same_forces(now.solve(**loads), now.solve(**loads, search="local"))


def test_rigid_and_plane_partners_are_paired_whole():
    lower = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), SOLID, "top", {"bottom": "xyz"})
    ball = fc.RigidBody(fc.Sphere(radius=5.0)).placed((0.5, 0.5, 1.0))
    contact = fc.Contact(lower, ball)
    loading = LoadStep({ball: (0, 0, -1.0)}).on([lower, ball])
    assert local_search.first_radius(contact, loading) is None


def test_poses_paired_round_the_last_one_are_those_paired_whole(monkeypatch):
    bulge = fc.shapes.block((2.0, 2.0, 0.4), (15, 9, 1), element="hex8").translated((-1.0, -1.0, 0.0))
    bulge = bulge.mapped(lambda x: x + (0.15 * (x[:, :2] ** 2).sum(axis=1) * (1 - x[:, 2] / 0.4))[:, None] * [0, 0, 1])
    plate = fc.shapes.block((3.0, 2.4, 0.4), (22, 11, 1), element="hex8").translated((-1.5, -1.2, -0.4))
    upper = fc.ElasticBody(bulge, SOLID, "bottom", {"top": "xyz"}, name="upper")
    lower = fc.ElasticBody(plate, SOLID, "top", {"bottom": "xyz"}, name="lower")
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower)])
    regions = []
    check = local_search.check_search_region

    def seen(result):
        regions.append((result._interfaces[0].region, result._interfaces[0].search_radius, *check(result)))
        return regions[-1][2:]

    monkeypatch.setattr(local_search, "check_search_region", seen)
    # small steps, and at last one that is driven to other parts: they are missed, found and paired
    places = [fc.Pose(fc.rotation_about((0, 1, 0), a), (a, 0, -0.01)) for a in (0.0, 0.03, 0.06, 0.3)]
    driven = [{upper: {"z": z}} for z in (0.0, 0.0, 0.0, -0.05)]
    table = scene.sweep([{"poses": {upper: p}, "motions": m} for p, m in zip(places, driven, strict=True)])
    assert [found for *_, found, _ in regions] == [True, True, True, False, True]
    assert regions[0][1].local is None
    assert all(radius.local is not None for _, radius, *_ in regions[1:])
    assert regions[2][0].within.sum() < regions[0][0].within.sum()
    for row, pose, motions in list(zip(table.rows, places, driven, strict=True))[2:]:
        there = upper.placed(pose.translation, rotation=pose.rotation)
        alone = fc.Scene([there, lower], [fc.Contact(there, lower)])
        whole = alone.solve(motions={there: motions[upper]}, search="global").contacts[0].summary()
        for name in ("area", "max_pressure", "mean_pressure"):
            # rounding times the condition of the compliance
            assert abs(row["contacts"][0][name] / whole[name] - 1) < 1e-9, name
