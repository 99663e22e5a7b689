"""Scenes of divided bodies: what goes with a body goes with one whose nodes hang."""

from dataclasses import replace

import matplotlib as mpl
import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from hanging_meshes import boxed, part, section_step
from refine_cases import near, refined_near
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.ancf import AncfSpace
from fecontact.bodies.rims import rim_of_surface
from fecontact.mesh.refine import refined, touching
from fecontact.scene.cost import explain

mpl.use("Agg")
SOLID = fc.Material(E=1.0, nu=0.3, density=2.0)
RADIUS, LOAD = 20.0, 0.1
# solutions of the same equations by other ways: rounding times condition numbers of some 1e5
SAME = 1e-9


def block(element="hex20", radii=(1.2, 0.4)):
    """A block 4 x 4 x 3 about the z axis, divided below the middle of its top."""
    mesh = fc.shapes.block((4.0, 4.0, 3.0), (4, 4, 3), element=element).translated((-2, -2, -3))
    for radius in radii:
        faces = mesh.faces("top")
        centres = mesh.points[mesh.face_nodes(faces)[:, :4]].mean(axis=1)
        mesh = refined(mesh, touching(mesh, faces[np.linalg.norm(centres, axis=1) < radius]))
    return mesh


def ball(**options):
    return fc.RigidBody(fc.Sphere(RADIUS), name="ball", **options).placed((0.05, 0.02, 0.0))


def pressed(body, rigid=None, **options):
    rigid = rigid or ball()
    scene = fc.Scene([body, rigid], [fc.Contact(body, rigid)])
    return scene.solve(forces={rigid: (0, 0, -LOAD)}, **options), rigid


@pytest.fixture(scope="module")
def body():
    return fc.ElasticBody(block(), SOLID, "top", {"bottom": "xyz"}, name="block")


@pytest.fixture(scope="module")
def result(body):
    return pressed(body)[0]


def test_unknowns_are_those_of_free_nodes_and_the_report_tells_of_the_others(body, result):
    mesh = body.mesh
    assert result.n_dofs == 3 * len(mesh.hanging.free) == body.n_dofs - 3 * len(mesh.hanging.nodes)
    assert f"with {len(mesh.hanging.nodes)} hanging nodes, {result.n_dofs} dofs" in str(result)
    told = explain(result.scene, {"forces": {result.scene.bodies[1]: (0, 0, -LOAD)}})
    assert told.n_dofs == result.n_dofs
    assert "hanging nodes" in str(told)
    section = fc.PlaneBody(section_step("quad8"), SOLID)
    assert f"with {len(section.mesh.hanging.nodes)} hanging nodes" in section.describe()
    assert "hanging" not in fc.ElasticBody(fc.shapes.block((1, 1, 1), (1, 1, 1)), SOLID).describe()


def test_hanging_nodes_carry_no_force_and_follow(body, result):
    contact, ties = result.contacts[0], body.mesh.hanging
    assert not np.isin(result._interfaces[0].pairing.nodes, ties.nodes).any()
    u = result.displacement(body)
    assert np.abs(u[ties.nodes] - ties.weights @ u).max() < 1e-15
    # their pressure is shown: that of the faces they follow
    shown = contact._at_nodes @ contact.pressure
    pressure = np.zeros(len(body.mesh.points))
    pressure[contact._node_numbers] = shown
    on = np.isin(ties.nodes, contact._node_numbers)
    assert np.abs(pressure[ties.nodes[on]]).max() > 0
    assert np.abs(pressure[ties.nodes] - ties.weights @ pressure)[on].max() < 1e-15
    # the points that are no candidates are checked where the body's displacement takes them
    assert result.residuals().penetration < 1e-10
    assert len(contact.gap) > len(contact._candidates)
    points = contact.points + u[result._interfaces[0].pairing.nodes]
    motion = result.rigid_motion(result.scene.bodies[1]).translation
    centre = np.array([0.05, 0.02, RADIUS]) + motion
    distance = np.linalg.norm(points - centre, axis=1) - RADIUS
    # the gap is linear in displacements, of three thousandths of the radius
    assert np.abs(distance - contact.gap).max() < 2e-4
    assert contact.gap.min() > -1e-12


def test_forces_balance(body):
    result, _ = pressed(body, gravity=(0.0, 0.0, -1e-6))
    weight = 1e-6 * 2.0 * 48.0
    force = result.reaction(body, "bottom")
    assert np.abs(force[:3] - result.reaction(body)[:3]).max() < 1e-12
    assert abs(force[2] - LOAD - weight) < 1e-12
    assert np.abs(result.reaction(body, "bottom") - result.reaction(body)).max() < 1e-12
    assert np.abs(result.contacts[0].force + result.reaction(body)[:3] - [0, 0, weight]).max() < 1e-12


@pytest.mark.parametrize("supports", [{"bottom": "xyz"}, {"bottom": (0, 0, 1), "x_min": "n", "y_min": (0, 1, 1)}])
def test_loads_and_reactions(supports):
    mesh = refined_near(block(radii=()), np.array([-2.0, -2.0, -3.0]), [1.5, 0.8])
    body = fc.ElasticBody(mesh, SOLID, (), supports)
    ties = mesh.hanging
    hung = ties.nodes[np.argmax(mesh.points[ties.nodes, 2])]
    loads = {
        "force": body._boundary_force("x_max", np.array([1.0, 2.0, 3.0])),
        "pressure": body._boundary_traction("y_max", lambda x, n: -0.5 * n),
        "point": body._point_force(mesh.points[hung], np.array([1.0, -1.0, 0.5])),
        "weight": body._body_force(lambda x: np.broadcast_to([0.0, 0.0, -1.0], x.shape)),
    }
    R, none = body.rigid_modes, sp.csr_matrix((0, body.n_dofs))
    expected = {"force": [1, 2, 3], "pressure": [0, -6, 0], "point": [1, -1, 0.5], "weight": [0, 0, -96]}
    for name, f in loads.items():
        assert np.abs((R.T @ f)[:3] - expected[name]).max() < SAME
        u = body.displacement(none, np.zeros(0), f)
        K = body.model.stiffness
        rest = K @ u + K.T @ u - K.diagonal() * u - f
        given = sum(body.model.support_forces(name, rest) for name in supports)
        # forces and moments of the supports answer the load
        assert np.abs(R.T @ (given + f)).max() < SAME * np.abs(R.T @ f).max()
        assert not given.reshape(-1, 3)[ties.nodes].any()


def test_springs_at_hanging_nodes():
    mesh = refined_near(block(radii=()), np.array([2.0, 0.0, -1.0]), [1.2])
    body = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"})
    on_side = mesh.hanging.nodes[mesh.points[mesh.hanging.nodes, 0] == 2.0]
    point = mesh.points[on_side[0]]
    spring = fc.Spring(0.01, (body, point), (None, point + np.array([1.0, 0, 0])), slack_length=0.8)
    flat = fc.RigidBody(fc.Plane()).placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    scene = fc.Scene([body, flat], [fc.Contact(body, flat)], springs=[spring])
    result = scene.solve(forces={flat: (0, 0, -LOAD)})
    tension = result.springs[0].tension
    assert tension > 0
    # forces of a flat have no part along x
    assert abs(result.reaction(body)[0] + tension) < 1e-9
    assert abs(result.reaction(body, "bottom")[0] + tension) < 1e-9


@pytest.mark.full
def test_ways_of_condensing_and_backends_agree(body, result):
    pressure = result.contacts[0].pressure
    for option in (
        {"condensation": "columns"},
        {"condensation": "operator"},
        {"backend": "superlu"},
        {"backend": "amg"},
    ):
        if option.get("backend") == "amg":
            pytest.importorskip("pyamg")
        other, _ = pressed(replace(body, **option))
        assert np.abs(other.contacts[0].pressure - pressure).max() < 1e-7 * pressure.max()  # of the iterations


def test_the_pose_does_not_matter(body, result):
    Q, shift = fc.rotation_about((1, 2, 0.5), 0.7), np.array([3.0, -2.0, 5.0])
    posed, rigid = body.placed(shift, Q), ball().placed(shift, Q)
    scene = fc.Scene([posed, rigid], [fc.Contact(posed, rigid)])
    other = scene.solve(forces={rigid: Q @ [0, 0, -LOAD]})
    assert np.abs(other.contacts[0].pressure - result.contacts[0].pressure).max() < SAME
    assert np.abs(other.displacement(posed) - result.displacement(body) @ Q.T).max() < SAME


def test_all_is_searched_or_what_is_near(body, result):
    other, _ = pressed(body, search="global")
    assert np.abs(other.contacts[0]._at_nodes @ other.contacts[0].pressure).max() > 0
    pressures = []
    for r in (result, other):
        p = np.zeros(len(body.mesh.points))
        p[r.contacts[0]._node_numbers] = r.contacts[0]._at_nodes @ r.contacts[0].pressure
        pressures.append(p)
    assert np.abs(pressures[0] - pressures[1]).max() < SAME
    two = fc.ElasticBody(block("hex20", (1.2,)), SOLID, "top", {"bottom": "xyz"}, name="other")
    over = two.placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    found = [
        fc.Scene([body, over], [fc.Contact(body, over, coupling="mortar", swap="never")])
        .solve(motions={over: {"z": -0.01}}, search=search)
        .contacts[0]
        for search in ("local", "global")
    ]
    assert abs(found[0].total_force / found[1].total_force - 1) < SAME
    assert np.abs(found[0].max_pressure / found[1].max_pressure - 1) < 1e-7


@pytest.mark.full
def test_sweeps_here_and_elsewhere(body):
    rigid = ball()
    scene = fc.Scene([body, rigid], [fc.Contact(body, rigid)])
    cases = [
        {"name": str(k), "forces": {rigid: (0, 0, -LOAD)}, "poses": {rigid: fc.Pose(translation=(0.1 * k, 0, 0))}}
        for k in range(4)
    ]
    here, elsewhere = scene.sweep(cases), scene.sweep(cases, processes=2)
    for one, other in zip(here, elsewhere, strict=True):
        assert one["status"] == other["status"] == "solved"
        a, b = (row["contacts"][0]["max_pressure"] for row in (one, other))
        assert abs(a / b - 1) < SAME
        assert one["n_dofs"] == 3 * len(body.mesh.hanging.free)


def test_large_rotations(body):
    posed = fc.RigidBody(fc.Sphere(RADIUS), name="ball")
    scene = fc.Scene([body, posed], [fc.Contact(body, posed)])
    still = scene.solve(motions={posed: {"z": -0.01}})
    turned = scene.solve(motions={posed: {"z": -0.01, "rz": 1.0}}, finite_motion=True)
    assert abs(turned.contacts[0].total_force / still.contacts[0].total_force - 1) < 1e-3  # the source is small motion


def test_files_and_pictures_show_all_nodes(body, result, tmp_path):
    file = meshio.read(result.save(tmp_path / "block.vtu"))
    used = np.unique(body.mesh.cells)
    assert len(file.points) == len(used)
    pressure = np.zeros(len(body.mesh.points))
    contact = result.contacts[0]
    pressure[contact._node_numbers] = contact._at_nodes @ contact.pressure
    assert np.abs(file.point_data["contact_pressure"] - pressure[used]).max() < 1e-15
    hanging = np.isin(used, body.mesh.hanging.nodes)
    assert np.abs(file.point_data["contact_pressure"][hanging]).max() > 0
    assert np.isfinite(file.point_data["stress"]).all()
    for what in ("pressure", "von_mises", "displacement"):
        result.plot(what, tmp_path / f"{what}.png")
        assert (tmp_path / f"{what}.png").stat().st_size > 1000


def test_one_region_over_divided_sides(result):
    contact = result.contacts[0]
    assert len(contact.regions) == 1
    points, pressure, area = contact.sampled(contact.pressure)
    assert len(points) == len(pressure)
    # the mean of the nodal pressures by their areas is the integral of what is shown
    assert abs((pressure * area).sum() / contact.total_force - 1) < 0.01  # samples per face, at a curved edge


@pytest.mark.full
def test_two_bodies_as_one_model_in_two_poses(body):
    over = body.placed(rotation=fc.rotation_about((1, 0, 0), np.pi), name="over")
    scene = fc.Scene([body, over], [fc.Contact(over, body)])
    result = scene.solve(motions={over: {"z": -0.02}})
    assert result.n_dofs == 2 * result._n_dofs_factorised
    contact = result.contacts[0]
    # flat on flat and mirror images of one another: nothing moves where they meet but sideways
    middle = result.displacement(body)[result._interfaces[0].pairing.nodes]
    assert contact.coupling == "nodal"
    assert np.abs(result.displacement(body)[:, 2] + result.displacement(over)[:, 2] + 0.02).max() < 1e-12
    assert len(middle)


def test_quarter_models_are_the_whole(body, result):
    mesh = fc.shapes.block((2.0, 2.0, 3.0), (2, 2, 3)).translated((0, 0, -3))
    mesh = refined(mesh, near(mesh, [0.5, 0.5, -0.5], 1.0))
    quarter = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz", "x_min": "x", "y_min": "y"})
    four = [mesh.mapped(lambda x, s=s: x * s) for s in ([1, 1, 1], [-1, -1, 1])]
    assert four[0].hanging is not None
    rigid = fc.RigidBody(fc.Sphere(RADIUS))
    found = fc.Scene([quarter, rigid], [fc.Contact(quarter, rigid)]).solve(motions={rigid: {"z": -0.02}})
    whole = fc.shapes.block((4.0, 4.0, 3.0), (4, 4, 3)).translated((-2, -2, -3))
    whole = refined(whole, np.abs(whole.points[whole.cells[:, :8]].mean(axis=1) - [0, 0, -0.5]).max(axis=1) < 0.6)
    other = fc.ElasticBody(whole, SOLID, "top", {"bottom": "xyz"})
    full = fc.Scene([other, rigid], [fc.Contact(other, rigid)]).solve(motions={rigid: {"z": -0.02}})
    assert abs(4 * found.contacts[0].force[2] / full.contacts[0].force[2] - 1) < SAME
    assert abs(found.contacts[0].max_pressure / full.contacts[0].max_pressure - 1) < SAME


def test_sections_in_contact():
    # matching sections, hanging nodes inside: uniform pressure is exact whatever hangs
    mesh = section_step("quad8")
    low = fc.PlaneBody(mesh, SOLID, "top", {"bottom": "z", "left": "x"})
    other = fc.sections.rectangle((2.0, 1.0), (3, 1)).mapped(lambda x: x - x.min(axis=0))
    other = replace(other, points=other.points - other.points.min(axis=0) + [0, 0, 2])
    names = sorted(other.boundaries)
    up = fc.PlaneBody(other, SOLID, "bottom", {"left": "x"})
    assert {"bottom", "top", "left"} <= set(names)
    result = fc.Scene([up, low], [fc.Contact(up, low)]).solve(pressures={(up, "top"): 0.01}, finite_motion=False)
    assert np.abs(result.contacts[0].pressure - 0.01).max() < 1e-12


def test_rims_where_the_division_changes():
    mesh = fc.shapes.block((4.0, 2.0, 1.0), (4, 2, 1))
    # the left half of the top divided; it is the contact surface, and beyond it the top goes on
    mesh = refined(mesh, mesh.points[mesh.cells[:, :8]].mean(axis=1)[:, 0] < 2)
    mesh = mesh.with_boundary("left", lambda x: (x[:, 2] == 1) & (x[:, 0] <= 2))
    mesh = mesh.with_boundary("right", lambda x: (x[:, 2] == 1) & (x[:, 0] >= 2))
    body = fc.ElasticBody(mesh, SOLID, ("left", "right"), {"bottom": "xyz"})
    for name, n in (("left", 4), ("right", 2)):
        rim = rim_of_surface(body, name)
        on_line = np.isclose(rim.ends[:, :, 0], 2).all(axis=1)
        assert on_line.sum() == n
        assert rim.smooth[on_line].all()
        assert not rim.smooth[~on_line].any()


def test_bricks_with_gradient_coordinates_have_no_hanging_nodes():
    for element in ("hex8", "hex20"):
        mesh = block(element, (1.2,))
        with refused(InputError, "hanging-not-possible", "used with gradient coordinates"):
            fc.AncfBody(mesh, SOLID, "top", {"bottom": "xyz"})
        with refused(InputError, "hanging-not-possible", "used with gradient coordinates"):
            AncfSpace(mesh)


def test_a_stiffness_of_ones_own_is_that_of_its_elements(body):
    plain = fc.ElasticBody(block(radii=(1.2,)), SOLID, "top", {"bottom": "xyz"}, pressure="nodal")
    K = plain.model.stiffness
    whole = sp.csr_matrix(K + sp.triu(K, 1).T)
    own = fc.AssembledBody(plain.mesh, SOLID, "top", {"bottom": "xyz"}, stiffness=whole)
    a, b = (pressed(x)[0].contacts[0] for x in (plain, own))
    assert np.abs(a.forces - b.forces).max() < SAME * a.forces.max()


def test_materials_of_groups_and_floating_bodies():
    mesh = boxed(part("hex20", (0, 0, 0), (2, 2, 2), (2, 2, 2)))
    mesh = mesh.with_group("low", lambda x: x[:, 2] < 1).with_group("high", lambda x: x[:, 2] > 1)
    mesh = refined(mesh, [0])
    assert len(mesh.groups["low"]) == 11
    materials = {"low": fc.Material(1.0, 0.2, density=1.0), "high": fc.Material(2.0, 0.3, density=3.0)}
    body = fc.ElasticBody(mesh, materials, "bottom")
    assert abs(body.model.mass_and_centre[0] - 16) < 1e-12
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(gravity=(0, 0, -1e-3))
    assert abs(result.contacts[0].force[2] - 16e-3) < 1e-12
    assert np.abs(result.contacts[0].centre_of_pressure - [1, 1, 0]).max() < 1e-9
