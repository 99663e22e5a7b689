"""The estimate of a contact's errors: its parts against fields that are known, and what it must not depend on."""

import json
import re

import numpy as np
import pytest
from scipy.spatial import cKDTree

import fecontact as fc
from fecontact.analytic import hertz
from fecontact.mesh.facets import TRIANGLE_COLUMNS, facet_nodes, shapes_on_square
from fecontact.mesh.refine import refined, touching
from fecontact.results.error_estimate import unseen_profile
from fecontact.results.facet_samples import facet_samples, hats, without
from fecontact.results.recovery import recovered
from fecontact.surfaces import Cylinder, FlatPunch, Paraboloid

SOLID = fc.Material(E=1000.0, nu=0.3)
SQUARE = np.stack(np.meshgrid(*[(np.arange(7) + 0.5) / 7] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
UPRIGHT = np.eye(3)
TRIANGLE = np.array([[0, 1, 2, 2, 3, 4, 2, 5, 6]])


def sheet(element, n=6):
    """Nodes and facets of the top of a flat block of side 2, and their nodes' areas."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (n, n, 1), element=element)
    body = fc.ElasticBody(mesh, SOLID, "top")
    surface = body.surface("top")
    return surface.points, surface.facets, np.bincount(surface.facets.ravel(), minlength=len(surface.points)) / n**2


def figures(estimate):
    return [value for value in vars(estimate).values() if isinstance(value, float)]


def everywhere(points):
    return np.ones(len(points))


@pytest.mark.parametrize("columns", [4, 8, 9])
def test_hats_are_one_at_their_node_and_sum_to_one(columns):
    """Source: the definition of piecewise linear functions; one of eight nodes has none in its middle."""
    facets = np.arange(columns)[None]
    at_nodes = hats(facets, facet_nodes(columns, False)[: min(columns, 8)], False)[0]
    assert np.abs(at_nodes - np.eye(len(at_nodes), columns)).max() < 1e-15
    assert np.abs(hats(facets, SQUARE, False).sum(axis=2) - 1).max() < 1e-15


@pytest.mark.parametrize("columns", [8, 9])
def test_hats_of_a_triangle_are_linear_round_its_centroid(columns):
    """Source: linear fields, which hats through all nodes hold, and the roof over the centroid, 3 min(L1, L2, L3)."""
    facets = TRIANGLE[:, :columns]
    found = hats(facets, SQUARE, False)[0]
    s, t = SQUARE.T
    L = np.stack([(1 - s) * (1 - t), s * (1 - t), t], axis=1)
    places = facet_nodes(columns, True)
    linear = found @ places
    assert np.abs(linear - np.stack([L[:, 1], L[:, 2]], axis=1)).max() < 1e-15
    unused = np.setdiff1d(np.arange(columns), TRIANGLE_COLUMNS[columns])
    assert not found[:, unused].any()
    if columns == 9:
        assert np.abs(found[:, 8] - 3 * L.min(axis=1)).max() < 1e-15
    assert np.abs(hats(facets, SQUARE, True)[0, :, :3] - L).max() < 1e-15  # those of a mortar coupling: corners only


def test_samples_measure_a_facet_and_carry_its_own_functions():
    nodes, facets, _ = sheet("hex20", 2)
    samples = facet_samples(nodes, facets, False, everywhere, 5)
    assert abs(samples.areas.sum() - 4.0) < 1e-12
    assert np.array_equal(samples.shapes, shapes_on_square(facets, samples.local)[0])


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_a_half_ellipsoid_is_recovered_wherever_its_edge_lies(element):
    """Source: its square is a quadratic polynomial, which least squares return."""
    nodes, facets, areas = sheet(element, 12 if element == "hex8" else 6)
    turn = fc.rotation_about((1, 2, 3), 0.7)

    def pressure(x):
        y = (x @ turn)[..., :2] - [0.83, 1.1]
        return np.sqrt(np.maximum(1 - (y[..., 0] / 0.74) ** 2 - (y[..., 1] / 0.9) ** 2 + y[..., 0] * y[..., 1] / 3, 0))

    turned = nodes @ turn.T
    exact = pressure(turned)
    chosen = np.flatnonzero((exact[facets] > 0).all(axis=1))
    samples = facet_samples(turned, facets[chosen], False, everywhere, 4).points
    found = recovered(turned, facets, chosen, exact, areas)
    assert np.abs(found.at(samples) - pressure(samples)).max() < 1e-10
    # over the edge too: only nodes within count, and the polynomial does not press at any other
    across = np.flatnonzero((exact[facets] > 0).any(axis=1))
    samples = facet_samples(turned, facets[across], False, everywhere, 4).points
    close = np.abs(recovered(turned, facets, across, exact, areas).at(samples) - pressure(samples))
    assert np.mean(close) < 0.02 * exact.max()


def test_a_linear_edge_is_recovered_from_the_pressure_itself():
    nodes, facets, areas = sheet("hex20")
    exact = np.maximum(1.13 - nodes[:, 0], 0.0)
    chosen = np.flatnonzero((exact[facets] > 0).any(axis=1))
    samples = facet_samples(nodes, facets[chosen], False, everywhere, 4).points
    found = recovered(nodes, facets, chosen, exact, areas, power=1).at(samples)
    assert np.abs(found - np.maximum(1.13 - samples[..., 0], 0.0)).max() < 1e-12


def test_unknown_nodes_do_not_count():
    nodes, facets, areas = sheet("hex20")
    rng = np.random.default_rng(3)
    exact = np.sqrt(4 - nodes[:, 0] ** 2 / 4)
    known = np.where(rng.random(len(nodes)) < 0.2, np.nan, exact)
    chosen = np.arange(len(facets))
    samples = facet_samples(nodes, facets, False, everywhere, 3).points
    found = recovered(nodes, facets, chosen, known, areas).at(samples)
    assert np.abs(found - np.sqrt(4 - samples[..., 0] ** 2 / 4)).max() < 1e-10


def indented(scale=1.0, unit=1.0, turn=UPRIGHT, seed=None, n=8, coupling="auto", load=0.02):
    """A rigid ball on a block with an even grid of faces, in some units, pose and numbering."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (n, n, 2)).translated((-1.0, -1.0, -1.0)).scaled(scale)
    if seed is not None:
        order = np.random.default_rng(seed).permutation(len(mesh.cells))
        place = np.argsort(order)
        faces = {k: np.stack([place[f[:, 0]], f[:, 1]], axis=1) for k, f in mesh.boundaries.items()}
        mesh = fc.Mesh(mesh.points, mesh.cells[order], faces)
    material = fc.Material(E=unit, nu=0.3)
    block = fc.ElasticBody(mesh, material, "top", {"bottom": "xyz"}, name="block").placed(rotation=turn)
    ball = fc.RigidBody(fc.Sphere(2.0 * scale), name="ball").placed(rotation=turn)
    force = tuple(turn @ (0, 0, -load * unit * scale**2))
    return fc.Scene([block, ball], [fc.Contact(block, ball, coupling=coupling)]).solve(forces={ball: force})


@pytest.mark.by_day("mortar-renumbered", "nodal-turned")
@pytest.mark.parametrize(
    "other",
    [{"scale": 1e-3}, {"unit": 1e9}, {"turn": fc.rotation_about((1, 2, 3), 0.7)}, {"seed": 5}],
    ids=["lengths", "moduli", "turned", "renumbered"],
)
@pytest.mark.parametrize("coupling", ["nodal", "mortar"])
def test_the_estimate_depends_on_no_unit_pose_or_numbering(other, coupling):
    """Source: each other. Tolerance: that of the solution, 1e-9, relative to the estimate."""
    one, two = (indented(**kind, coupling=coupling).contacts[0].error_estimate for kind in ({}, other))
    assert np.allclose(figures(one), figures(two), rtol=1e-6)


def test_uniform_pressure_has_no_error():
    """Source: a patch test, whose answer lies in every reading."""
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (3, 2, 2)), fc.Material(1.0, 0.0), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    contact = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}}).contacts[0]
    assert contact.error_estimate.pressure < 1e-9
    assert contact.error_estimate.peak < 1e-9
    assert abs(contact._whole.area - 1.0) < 1e-9
    assert np.abs(contact.error_indicators).max() < 1e-9 * contact.max_pressure


def test_indicators_add_up_to_the_estimate_and_are_largest_at_the_edge():
    result = indented(n=12)
    contact = result.contacts[0]
    surface = result.scene.bodies[0].surface("top")
    assert contact.error_indicators.shape == (len(surface.facets),)
    _, pressure, areas = contact.sampled(contact.pressure, 24)
    total = np.sqrt((contact.error_indicators**2 * surface.mean_facet_size**2).sum())
    norm = np.sqrt((areas * pressure**2).sum())
    estimate = contact.error_estimate
    by_faces = np.sqrt(estimate.pressure**2 - estimate.geometry**2 - estimate.interior**2)
    assert abs(total / norm / by_faces - 1) < 0.01  # 24 and 6 samples a side
    worst = surface.facets[np.argmax(contact.error_indicators)]
    active = contact._at_nodes @ contact.pressure > 0
    pressed = np.isin(worst, contact._node_numbers[active])
    assert pressed.any()
    assert not pressed.all()


def test_without_contact_there_is_nothing_to_estimate():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane()).placed((0, 0, -0.1))
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    contact = result.contacts[0]
    assert np.isnan(contact.error_estimate.pressure)
    assert "nothing to estimate" in str(contact.error_estimate)
    assert contact._whole.area == 0.0
    assert not contact.error_indicators.any()
    assert json.loads(json.dumps(result.summary()))["contacts"][0]["error_estimate"]["pressure"] is None


def test_the_estimate_is_printed_summed_up_and_written(tmp_path):
    import meshio

    result = indented(n=12)
    contact = result.contacts[0]
    (line,) = (line for line in str(result).splitlines() if "error of pressure" in line)
    assert re.search(r"about \d+ % \(peak .* %, area .* %\), resolved by [\d.]+ faces across", line)
    summary = json.loads(json.dumps(result.summary()))["contacts"][0]["error_estimate"]
    assert summary == vars(contact.error_estimate) | {"resolved": True}
    written = meshio.read(result.save(tmp_path / "block.vtu")).point_data["contact_pressure_error"]
    assert 0.5 * contact.error_indicators.max() < written.max() <= contact.error_indicators.max()


def test_elements_that_are_coarse_below_fine_faces_are_told_of():
    """Source: Hertz. Linear cells divided at the surface only: pressures stay off, what faces tell falls below half."""
    radius, a = 10.0, 0.5
    modulus = SOLID.plane_strain_modulus
    exact = hertz.spheres((radius, np.inf), (None, SOLID), force=4 * modulus * a**3 / (3 * radius))
    x = np.array([0.0, 0.25, 0.5, 0.75, 1.2, 2.0, 3.5, 6.0, 10.0])
    mesh = fc.shapes.block((10.0, 10.0, 10.0), (x, x, x), element="hex8")
    held = {"top": "xyz", "x_min": "x", "y_min": "y"}
    for _ in range(4):
        near = np.hypot(*mesh.points[mesh.face_nodes(mesh.faces("bottom"))].mean(axis=1)[:, :2].T) < 1.1 * a
        mesh = refined(mesh, touching(mesh, mesh.faces("bottom")[near]))
    block = fc.ElasticBody(mesh, SOLID, "bottom", held, name="block")
    ball = fc.RigidBody(Paraboloid(radius), name="ball").placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([block, ball], [fc.Contact(block, ball)]).solve(forces={ball: (0, 0, exact.force / 4)})
    contact = result.contacts[0]
    points, pressure, areas = contact.sampled(contact.pressure, 8)
    target = exact.pressure(np.hypot(points[:, 0], points[:, 1]))
    error = np.sqrt(areas @ (pressure - target) ** 2 / (areas @ target**2))
    estimate = contact.error_estimate
    assert np.sqrt(estimate.pressure**2 - estimate.interior**2) < 0.5 * error
    assert 0.8 < estimate.pressure / error < 1.5


@pytest.mark.parametrize("columns", [3, 4, 8, 9])
def test_a_pressure_goes_on_beyond_the_nodes_that_have_one(columns):
    """Source: a uniform pressure, and nodes left out that take part in nothing."""
    local = SQUARE if columns > 3 else SQUARE[:7, 1:]
    left_out = np.arange(columns)[None] % 3 == 1
    found = without(hats(np.arange(columns)[None], local, False), left_out)
    assert np.abs(found.sum(axis=2) - 1).max() < 1e-14
    assert not found[:, :, left_out[0]].any()
    assert found.min() >= 0


def under_a_punch(x, half_side, element="hex20", friction=0.0):
    """A quarter of a block below a flat square punch, by the positions of its nodes along x and y."""
    z = 1 - np.array([1.0, 0.6, 0.3, 0.12, 0.04, 0.0]) if len(x) > 7 else len(x) - 1
    mesh = fc.shapes.block((0.5, 0.5, 1.0), (x, x, z), element=element)
    body = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz", "x_min": "x", "y_min": "y"})
    punch = fc.RigidBody(FlatPunch(sides=(2 * half_side, 2 * half_side))).placed((0, 0, 1.0))
    scene = fc.Scene([body, punch], [fc.Contact(body, punch, friction=friction)])
    return scene.solve(motions={punch: {"z": -0.03}}, finite_motion=False).contacts[0]


@pytest.mark.parametrize(
    ("n", "element", "friction"), [(3, "hex20", 0.0), (4, "hex20", 0.0), (2, "hex8", 0.0), (4, "hex20", 0.3)]
)
def test_below_a_punch_whose_rim_lies_within_faces(n, element, friction):
    """Source: a mesh graded towards the rim, whose sides follow it; compared half a face away, at the force found."""
    fine = under_a_punch(np.array([0, 0.1, 0.2, 0.25, 0.28, 0.293, 0.3, 0.307, 0.33, 0.4, 0.5]), 0.3 + 1e-9)
    at, known, _ = fine.sampled(fine.pressure, 8)
    found = under_a_punch(np.linspace(0, 0.5, n + 1), 0.3, element, friction)
    x, pressure, areas = found.sampled(found.pressure, 12)
    inside = (x[:, :2] < 0.3 - 0.25 / n).all(axis=1)
    true = known[cKDTree(at).query(x[inside])[1]] * found.total_force / fine.total_force
    error = np.sqrt(areas[inside] @ (pressure[inside] - true) ** 2 / (areas[inside] @ true**2))
    assert 0.5 <= found.error_estimate.pressure / error <= 3
    assert found.error_estimate.area < 0.5
    assert abs(found._readings.areas.sum() / found._whole.area - 1) < 0.35  # six samples along a face


def test_forces_at_a_rim_along_the_sides_of_faces_act_where_they_are():
    contact = under_a_punch(np.linspace(0, 0.5, 5), 0.25 + 1e-9)
    assert contact._readings.rim.max() < 1e-12
    quarter = under_a_punch(np.linspace(0, 0.5, 5), 0.3)
    assert quarter._readings.rim.sum() > 0.01
    x = np.linspace(0, 1, 9)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (x, x, 4)).translated((-0.5, -0.5, 0.0))
    body, punch = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}), fc.RigidBody(FlatPunch(sides=(0.6, 0.6)))
    punch = punch.placed((0, 0, 1.0))
    whole = fc.Scene([body, punch], [fc.Contact(body, punch)]).solve(motions={punch: {"z": -0.03}}).contacts[0]
    assert abs(whole._readings.rim.sum() - quarter._readings.rim.sum()) < 1e-9


def test_a_contact_on_less_than_a_face_errs_as_the_stresses_below_do():
    """Pressures of a clamped block on a single face are too even; without lateral strain they are right."""

    def pressed(nu, n):
        mesh = fc.shapes.block((1.5, 1.0, 0.9), (n, n, n), element="hex27")
        body = fc.ElasticBody(mesh, fc.Material(1.0, nu), "top", {"bottom": "xyz"})
        plate = fc.RigidBody(fc.Plane()).placed((0, 0, 0.9), np.diag([1.0, -1.0, -1.0]))
        scene = fc.Scene([body, plate], [fc.Contact(body, plate)])
        return scene.solve(motions={plate: {"z": -0.01}}).contacts[0]

    coarse, fine = pressed(0.499, 1), pressed(0.499, 4)
    assert coarse.error_estimate.faces_across < 1 < fine.error_estimate.faces_across
    assert 0.8 < coarse.error_estimate.peak / abs(fine.max_pressure / coarse.max_pressure - 1) < 3
    # four faces across see half of their profile
    error = fine._energy_errors[0]
    root = np.sqrt(error.error.sum() / error.energy.sum())
    assert abs(fine.error_estimate.interior - 2 / fine.error_estimate.faces_across * root) < 1e-12
    even = pressed(0.0, 1).error_estimate
    assert even.faces_across < 1
    assert max(even.peak, even.pressure) < 1e-9


@pytest.mark.parametrize(
    ("element", "nu", "faces", "shape", "depth"),
    [
        ("hex8", 0.3, (3, 3), fc.Sphere(4.0), 0.14),
        ("hex8", 0.499, (2, 4), Cylinder(5.0), 0.09),
        ("hex20", 0.3, (1, 3), Cylinder(5.0), 0.09),
        ("hex20", 0.3, (1, 3), fc.Sphere(12.0), 0.05),
    ],
)
def test_a_contact_that_fills_few_faces_errs_as_the_stresses_below_do(element, nu, faces, shape, depth):
    """A column's end wholly below a shape: its peak is 8 to 16 % short at the force found, its profile shows 2 to 4."""

    def pressed(n, kind):
        mesh = fc.shapes.block((1.0, 1.0, 1.0), (*n, max(n)), element=kind)
        body = fc.ElasticBody(mesh, fc.Material(1.0, nu), "top", {"bottom": "xyz"})
        rigid = fc.RigidBody(shape).placed((0.47, 0.52, 1.0))
        return fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -depth}}).contacts[0]

    coarse, fine = pressed(faces, element), pressed((8, 8), "hex20")
    assert coarse.active.all()
    at_force = [c.max_pressure / c.total_force for c in (coarse, fine)]
    assert 0.6 < coarse.error_estimate.peak / abs(at_force[1] / at_force[0] - 1) < 3


def test_a_column_below_a_plate_is_told_small_errors_and_a_contact_within_its_faces_none_of_these():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (4, 4, 4), element="hex8")
    body = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"})
    plate = fc.RigidBody(fc.Plane()).placed((0, 0, 1.0), np.diag([1.0, -1.0, -1.0]))
    ball = fc.RigidBody(fc.Sphere(4.0)).placed((0.5, 0.5, 1.0))
    whole, part = (
        fc.Scene([body, other], [fc.Contact(body, other)]).solve(motions={other: {"z": -0.02}}).contacts[0]
        for other in (plate, ball)
    )
    # 0.2 % is true, by 16 cells across
    assert whole.active.all()
    assert whole.error_estimate.peak < 0.04
    assert not part.active.all()
    assert unseen_profile(part, part._readings) == 0


@pytest.mark.parametrize(("radius", "least"), [(8.0, 1.0), (100.0, 0.06)])
def test_a_tip_on_a_single_face_is_seen_by_its_sag_between_the_nodes(radius, least):
    """A ball on four nodes touches a block beside what it presses: the peak is a sixth of the true, or 6 % short."""

    def pressed(n):
        body = fc.ElasticBody(
            fc.shapes.block((1.0, 1.0, 1.0), (n, n, n), element="hex8"), fc.Material(1.0, 0.3), "top", {"bottom": "xyz"}
        )
        ball = fc.RigidBody(Paraboloid(radius)).placed((0.5, 0.5, 1.0))
        return fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.04}}).contacts[0]

    coarse, fine = pressed(1), pressed(4)
    assert coarse.active.all()
    true = fine.max_pressure / coarse.max_pressure - 1
    assert true > least
    assert coarse.error_estimate.peak > 0.8 * min(true, 1.0)
    assert coarse.error_estimate.peak < 3 * true
    # the sag between the nodes alone says 240 % of the pressure of the steep one
    assert (coarse._between_nodes.unseen.max() > coarse.max_pressure) == (coarse.error_estimate.peak == 1.0)
    assert max(v for v in figures(coarse.error_estimate)[:5] if np.isfinite(v)) <= 1.0
