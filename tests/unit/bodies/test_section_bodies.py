"""Sections: elements, meshes, curves, and bodies in scenes."""

import math

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.contact.coupling.mortar import multiplier_areas

STEEL = fc.Material(E=200.0, nu=0.3)
RUBBER = fc.Material(E=3.0, nu=0.4999)
UPSIDE_DOWN = fc.rotation_about((1, 0, 0), math.pi)
KINDS = (fc.PlaneBody, fc.AxisymmetricBody)


def bent(element="quad8", inner=0.5):
    """A section with distorted cells and curved sides."""
    mesh = fc.sections.rectangle((1.0, 1.2), (3, 2), element=element, start=inner)

    def shape(x):
        r, z = x[:, 0], x[:, 2]
        return np.stack([r + 0.1 * np.sin(2 * z) * r, 0 * r, z + 0.07 * np.cos(3 * r) * z + 0.05 * r], axis=1)

    return mesh.mapped(shape)


def full_stiffness(body):
    K = body.model.stiffness
    return (K + K.T).toarray() - np.diag(K.diagonal())


def unheld(body):
    return np.setdiff1d(np.arange(body.n_dofs), np.arange(1, body.n_dofs, 3))


# elements


@pytest.mark.parametrize("element", ["quad8", "quad9"])
@pytest.mark.parametrize("material", [STEEL, RUBBER])
@pytest.mark.parametrize(("kind", "modes"), [(fc.PlaneBody, 3), (fc.AxisymmetricBody, 1)])
def test_number_of_zero_modes(kind, modes, material, element):
    body = kind(bent(element), material)
    K = full_stiffness(body)[np.ix_(unheld(body), unheld(body))]
    values = np.linalg.eigvalsh(K)
    # relative to the largest; the next is far above rounding
    assert (np.abs(values) < 1e-11 * values.max()).sum() == modes
    assert values[modes] > 1e-7 * values.max()
    assert body.free_motions.shape == (6, modes)
    rigid = body.rigid_modes @ body.free_motions
    assert np.abs(full_stiffness(body) @ rigid).max() < 1e-10 * values.max()


@pytest.mark.parametrize("element", ["quad8", "quad9"])
@pytest.mark.parametrize("plane", ["strain", "stress", "ring"])
def test_patch_of_distorted_elements(plane, element):
    """Linear displacements on the rim give the same inside, with their constant stress."""
    mesh = bent(element)
    body = fc.AxisymmetricBody(mesh, STEEL) if plane == "ring" else fc.PlaneBody(mesh, STEEL, plane=plane)
    # round the axis only these keep all strains constant
    H = np.array([[0.02, 0.0], [0.0, -0.03]]) if plane == "ring" else np.array([[0.02, 0.01], [0.03, -0.03]])
    exact = np.zeros((len(mesh.points), 3))
    exact[:, [0, 2]] = mesh.points[:, [0, 2]] @ H.T
    K = full_stiffness(body)
    rim = np.unique(mesh.face_nodes(mesh.outer_sides))
    fixed = (3 * rim[:, None] + [0, 2]).ravel()
    free = np.setdiff1d(unheld(body), fixed)
    u = exact.ravel().copy()
    u[free] = np.linalg.solve(K[np.ix_(free, free)], -K[np.ix_(free, fixed)] @ u[fixed])
    assert np.abs(u - exact.ravel()).max() < 1e-14
    xx, zz, xz = H[0, 0], H[1, 1], (H[0, 1] + H[1, 0]) / 2
    lame, mu = STEEL.lame, STEEL.shear_modulus
    yy = {"strain": 0.0, "stress": -lame / (lame + 2 * mu) * (xx + zz), "ring": xx}[plane]
    strain = np.array([xx, yy, zz, 0, 0, xz])
    stress = 2 * mu * strain + lame * (xx + yy + zz) * np.array([1, 1, 1, 0, 0, 0])
    assert np.abs(body.model.nodal_strain(u) - strain).max() < 1e-13
    assert np.abs(body.model.nodal_stress(u) - stress).max() < 1e-11
    if plane == "stress":
        assert abs(stress[1]) < 1e-15


@pytest.mark.parametrize("element", ["quad8", "quad9"])
def test_selective_integration_recovers_a_constant_strain(element):
    mesh = bent(element)
    body = fc.AxisymmetricBody(mesh, RUBBER)
    assert body.model.selective
    u = (mesh.points * [0.01, 0, 0.02]).ravel()
    assert np.abs(body.model.nodal_strain(u) - [0.01, 0.01, 0.02, 0, 0, 0]).max() < 1e-13


def test_volume_centre_and_loads_of_a_hemisphere():
    mesh = fc.sections.half_disc(2.0, contact_radius=0.1, level=3)
    body = fc.AxisymmetricBody(mesh, fc.Material(1.0, 0.3, density=3.0))
    volume = 2 / 3 * math.pi * 8
    mass, centre = body.model.mass_and_centre
    # three quadratic sides over the outer 45 degrees stand off the circle by 1e-4 of its radius
    assert abs(mass / (3 * volume) - 1) < 5e-4
    assert np.abs(centre - [0, 0, 2 - 3 / 8 * 2]).max() < 5e-4
    weight = body.model.body_force(lambda x: np.broadcast_to([0, 0, -9.0], x.shape))
    assert abs(weight.sum() / (-9 * mass) - 1) < 1e-12
    pressure = body.model.traction("base", lambda x, n: -5.0 * n)
    assert abs(pressure.sum() / (-5 * math.pi * 4) - 1) < 1e-12


# curves


def test_weights_on_the_axis():
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 1))
    body = fc.AxisymmetricBody(mesh, STEEL, "bottom")
    surface = body.surface("bottom")
    axis = surface.nodes[np.argmin(mesh.points[surface.nodes, 0])]
    with refused(fc.MeshError, "no-area"):
        _ = surface.nodal_areas
    areas = multiplier_areas(surface)
    assert abs(areas.sum() / math.pi - 1) < 1e-13
    # 2 pi int (1 - 2s) s ds over half a side of length 1/2
    assert abs(areas[axis] / (2 * math.pi * 0.25 / 24) - 1) < 1e-12
    assert (areas[surface.nodes] > 0).all()
    floor = fc.RigidBody(fc.Plane())
    body = fc.AxisymmetricBody(mesh, STEEL, "bottom", {"top": "xz"})
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, coupling="nodal")])
    with refused(fc.MeshError, "no-area"):
        scene.solve(motions={body: {"z": -0.01}})


def test_weights_of_a_strip_are_simpsons():
    mesh = fc.sections.rectangle((1.0, 1.0), (1, 1))
    surface = fc.PlaneBody(mesh, STEEL, "bottom", thickness=2.0).surface("bottom")
    order = surface.nodes[np.argsort(mesh.points[surface.nodes, 0])]
    assert np.abs(surface.nodal_areas[order] - np.array([1, 4, 1]) / 3).max() < 1e-15


def test_feet_on_an_arc():
    level = fc.shapes.Level(core=4, rings=6, edge=0.025, layer=0.1)
    mesh = fc.sections.half_disc(2.0, contact_radius=0.2, level=level)
    surface = fc.PlaneBody(mesh, STEEL, "cap").surface("cap")
    angle = np.linspace(0.01, 0.7, 50)
    points = np.stack([2.5 * np.sin(angle), 0 * angle, 2 - 2.5 * np.cos(angle)], axis=1)
    projection = surface.project(points)
    # the outermost quadratic side stands off the circle by 1e-3, those in the contact by 1e-8
    assert np.abs(projection.gap - 0.5).max() < 2e-3
    assert np.abs(projection.gap - 0.5)[angle < 0.1].max() < 1e-7
    assert np.abs(projection.points[:, 1]).max() == 0
    assert np.abs(projection.weights @ surface.points - projection.points).max() < 1e-14
    assert not projection.outside.any()


# scenes


def hertz_scene(kind, scale=1.0, modulus=1.0, rotation=None, shift=(0, 0, 0), seed=None):
    mesh = fc.sections.half_disc(10.0, contact_radius=0.5, level=1)
    if seed is not None:
        order = np.random.default_rng(seed).permutation(len(mesh.points))
        points = np.empty_like(mesh.points)
        points[order] = mesh.points
        mesh = fc.SectionMesh(points, order[mesh.cells], dict(mesh.boundaries))
    mesh = mesh.scaled(scale)
    material = fc.Material(modulus * 1000.0, 0.3)
    given = {"thickness": 0.7 * scale} if kind is fc.PlaneBody else {}
    supports = {"base": "xz", "sym_x": "x"} if kind is fc.PlaneBody else {"base": "xz"}
    turn = np.eye(3) if rotation is None else rotation
    upper = kind(mesh, material, "cap", supports, name="upper", **given).placed(shift, turn)
    lower = kind(mesh, material, "cap", supports, name="lower", **given).placed(rotation=UPSIDE_DOWN)
    lower = lower.placed(shift, turn)
    force = turn @ np.array([0, 0, -30.0]) * scale**2 * modulus
    result = fc.Scene([upper, lower], [fc.Contact(upper, lower)]).solve(forces={upper: force})
    return result, upper


@pytest.mark.by_day("1.0-1000000000.0-PlaneBody", "0.001-1.0-AxisymmetricBody")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("scale", "modulus"), [(1e-3, 1.0), (1e3, 1.0), (1.0, 1e9), (1.0, 1e-9)])
def test_units_do_not_matter(kind, scale, modulus):
    (one, upper), (other, upper2) = hertz_scene(kind), hertz_scene(kind, scale, modulus)
    p, q = one.contacts[0].pressure, other.contacts[0].pressure / modulus
    assert np.abs(p - q).max() < 1e-9 * p.max()
    down = one.rigid_motion(upper).translation, other.rigid_motion(upper2).translation / scale
    assert np.abs(down[0] - down[1]).max() < 1e-9 * np.abs(down[0]).max()


def test_pose_of_a_plane_scene_does_not_matter():
    (one, upper) = hertz_scene(fc.PlaneBody)
    turn = fc.rotation_about((0, 1, 0), 0.4)
    other, upper2 = hertz_scene(fc.PlaneBody, rotation=turn, shift=(3e4, 0, -1e4))
    p, q = one.contacts[0].pressure, other.contacts[0].pressure
    assert np.abs(p - q).max() < 1e-9 * p.max()
    down = turn @ one.rigid_motion(upper).translation - other.rigid_motion(upper2).translation
    assert np.abs(down).max() < 1e-9 * np.abs(one.rigid_motion(upper).translation).max()
    assert np.abs(turn @ one.contacts[0].force - other.contacts[0].force).max() < 1e-9 * 30


def test_an_axisymmetric_scene_may_stand_anywhere_on_its_axis():
    one, other = hertz_scene(fc.AxisymmetricBody)[0], hertz_scene(fc.AxisymmetricBody, shift=(0, 0, 1e5))[0]
    assert np.abs(one.contacts[0].pressure - other.contacts[0].pressure).max() < 1e-9 * one.contacts[0].max_pressure


@pytest.mark.parametrize("kind", KINDS)
def test_numbering_does_not_matter(kind):
    one, other = hertz_scene(kind)[0], hertz_scene(kind, seed=3)[0]
    p, q = np.sort(one.contacts[0].pressure), np.sort(other.contacts[0].pressure)
    assert np.abs(p - q).max() < 1e-9 * p.max()


def test_floating_block_under_an_eccentric_load():
    """Three free motions, separated: the resultant stands under the load."""
    mesh = fc.sections.rectangle((2.0, 1.0), (8, 4), start=-1.0)
    block = fc.PlaneBody(mesh, STEEL, "bottom", name="block", thickness=0.5)
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)])
    result = scene.solve(forces={block: (0, 0, -2.0)}, moments={block: (0, 0.4, 0)})
    contact = result.contacts[0]
    # the moment about +y of -2 at x is 2 x
    assert abs(contact.centre_of_pressure[0] - 0.2) < 1e-9
    assert np.abs(contact.force - [0, 0, 2]).max() < 1e-9
    assert result.residuals().equilibrium < 1e-10
    assert np.abs(result.reaction(floor)[[0, 1, 3, 5]]).max() < 1e-9
    with refused(fc.SupportError, "free-motion", "translation along x"):
        scene.solve(forces={block: (0.1, 0, -2.0)})


@pytest.mark.parametrize("kind", KINDS)
def test_no_pressure_is_sampled_beyond_the_edge_of_the_master(kind):
    # the last side of the upper body, from 1 to 1.5, hangs over the edge of the lower one at 1.2
    low = kind(fc.sections.rectangle((1.2, 1.0), (5, 3)), STEEL, "top", {"bottom": "z"}, name="low")
    mesh = fc.sections.rectangle((1.5, 1.0), (3, 2)).translated((0, 0, 1.0))
    up = kind(mesh, STEEL, "bottom", {"top": "xz"}, name="up")
    scene = fc.Scene([low, up], [fc.Contact(up, low, coupling="mortar", swap="never")])
    contact = scene.solve(motions={up: {"z": -0.01}}).contacts[0]
    points, pressure, areas = contact.sampled(contact.pressure, 50)
    assert points[:, 0].max() > 1.4
    assert pressure[points[:, 0] > 1.2].max() == 0
    assert pressure[points[:, 0] < 1.19].min() > 0
    # a midpoint rule on 50 pieces of a side, one of which the edge may cut: 1 % of the length
    assert abs(pressure @ areas / contact.total_force - 1) < 0.02


def test_a_spring_in_a_plane():
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    block = fc.PlaneBody(mesh, STEEL, "bottom", name="block")
    floor = fc.RigidBody(fc.Plane())
    rope = fc.Spring(0.5, (block, (1.0, 0.0, 1.0)), (None, (3.0, 0.0, 1.0)), name="rope")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[rope])
    result = scene.solve(forces={block: (-0.01, 0.0, -2.0)}, finite_motion=False)  # the rope keeps its direction
    assert abs(result.springs[0].tension - 0.01) < 1e-10
    leaving = fc.Spring(0.5, (block, (1.0, 0.0, 1.0)), (None, (1.0, 3.0, 1.0)))
    with refused(fc.InputError, "spring-off-plane"):
        fc.Scene([block, floor], [fc.Contact(block, floor)], springs=[leaving])


def test_a_load_that_floats_is_spread_round_the_axis():
    mesh = fc.sections.rectangle((1.0, 1.0), (3, 3))
    body = fc.AxisymmetricBody(mesh, STEEL, "bottom", name="plug")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(forces={body: (0, 0, -5.0)})
    assert np.abs(result.contacts[0].force - [0, 0, 5]).max() < 1e-9
    # on a rigid body too the pushes all round are added up
    assert (
        np.abs(result.reaction(floor) - [0, 0, -5, 0, 0, 0]).max() < 1e-9
        or np.abs(result.reaction(floor) - [0, 0, 5, 0, 0, 0]).max() < 1e-9
    )


def test_rigid_ball_in_a_cup_pushes_along_the_axis_only():
    mesh = fc.sections.cap(math.inf, 10.0, 10.0, contact_radius=1.0, level=1)
    body = fc.AxisymmetricBody(mesh, STEEL, "cap", {"base": "xz"}).placed(rotation=UPSIDE_DOWN)
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball")
    result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.1}})
    reaction = result.reaction(ball)
    assert reaction[2] < 0
    assert np.abs(np.delete(reaction, 2)).max() < 1e-12 * abs(reaction[2])
    assert (
        np.abs(result.contacts[0].force + reaction[:3]).max() < 1e-9
        or np.abs(result.contacts[0].force - reaction[:3]).max() < 1e-9
    )


def test_gravity_and_no_contact():
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    body = fc.AxisymmetricBody(mesh, fc.Material(10.0, 0.2, density=2.0), "bottom")
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    result = scene.solve(gravity=(0, 0, -3.0))
    assert abs(result.contacts[0].force[2] / (6 * math.pi) - 1) < 1e-9
    held = fc.AxisymmetricBody(mesh, STEEL, "bottom", {"top": "z"}).placed((0, 0, 1.0))
    result = fc.Scene([held, floor], [fc.Contact(held, floor)]).solve()
    assert result.status == "no-contact"
    assert not result.contacts[0].forces.any()


def test_a_sweep_and_a_finite_motion(tmp_path):
    mesh = fc.sections.rectangle((2.0, 1.0), (6, 3), start=-1.0)
    block = fc.PlaneBody(mesh, STEEL, "bottom", {"top": "xz"}, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)])
    rows = scene.sweep([{"motions": {block: {"z": -0.01 * k}}} for k in (1, 2)])
    assert abs(rows[1]["contacts"][0]["force"][2] / rows[0]["contacts"][0]["force"][2] - 2) < 1e-9
    tilted = block.placed(rotation=fc.rotation_about((0, 1, 0), 0.1))
    scene = fc.Scene([tilted, floor], [fc.Contact(tilted, floor)])
    result = scene.solve(forces={tilted: (0, 0, -1.0)}, free={tilted: "ry"}, finite_motion=True)
    assert abs(result.rigid_motion(tilted).rotation[1] + 0.1) < 1e-6


def test_files(tmp_path):
    result, upper = hertz_scene(fc.AxisymmetricBody)
    written = meshio.read(result.save(tmp_path / "pressed.vtu"))
    assert written.cells[0].type == "quad8"
    assert len(written.points) == 2 * len(upper.mesh.points)
    assert abs(written.point_data["contact_pressure"].max() / result.contacts[0].max_pressure - 1) < 1e-9
    assert "axisymmetric" in str(result)
    assert result.n_dofs == 4 * len(upper.mesh.points)


# what is refused


def test_mixed_scenes_are_refused():
    section = fc.sections.rectangle((1.0, 1.0), (1, 1))
    solid = fc.ElasticBody(fc.shapes.block((1, 1, 1), (1, 1, 1)), STEEL, "top", name="block")
    flat = fc.PlaneBody(section, STEEL, "bottom", name="strip")
    ring = fc.AxisymmetricBody(section, STEEL, "bottom", name="ring")
    for one, other in ((flat, solid), (ring, solid), (flat, ring)):
        with refused(fc.InputError, "mixed-dimensions"):
            fc.Scene([one, other], [fc.Contact(one, other)])
    thick = fc.PlaneBody(section, STEEL, "top", name="thick", thickness=2.0)
    with refused(fc.InputError, "thickness-differs", "[1.0, 2.0]"):
        fc.Scene([flat, thick], [fc.Contact(flat, thick)])


def test_poses_out_of_the_plane_or_off_the_axis_are_refused():
    section = fc.sections.rectangle((1.0, 1.0), (1, 1))
    floor = fc.RigidBody(fc.Plane())
    flat, ring = (kind(section, STEEL, "bottom", {"top": "xz"}) for kind in KINDS)
    wrong = [
        (flat.placed((0, 0.1, 0)), ("off-plane", "plane y = 0")),
        (flat.placed(rotation=fc.rotation_about((1, 0, 0), 0.1)), ("input", "plane y = 0")),
        (ring.placed((0.1, 0, 0)), ("off-plane", "axis")),
        (ring.placed(rotation=fc.rotation_about((0, 1, 0), 0.1)), ("input", "axis")),
        (ring.placed(rotation=fc.rotation_about((0, 1, 0), math.pi)), ("input", "axis")),
    ]
    for body, message in wrong:
        with refused(fc.InputError, *message):
            fc.Scene([body, floor], [fc.Contact(body, floor)])


def test_loads_that_do_not_exist_are_refused():
    section = fc.sections.rectangle((1.0, 1.0), (1, 1))
    floor = fc.RigidBody(fc.Plane())
    flat, ring = (kind(section, STEEL, "bottom", {"top": "xz"}, name="body") for kind in KINDS)
    cases = [
        (flat, {"forces": {flat: (0, 1, 0)}}, ("motion-not-in-plane", "in y")),
        (flat, {"motions": {flat: {"rx": 0.1}}}, ("motion-not-in-plane", "in rx")),
        (flat, {"free": {flat: "rz"}}, ("motion-not-in-plane", "in rz")),
        (flat, {"forces": {(flat, "top"): (0, 1, 1)}}, ("load-not-in-plane", "x, z")),
        (ring, {"forces": {ring: (1, 0, 0)}}, ("motion-not-in-plane", "in x")),
        (ring, {"moments": {ring: (0, 1, 0)}}, ("motion-not-in-plane", "in ry")),
        (ring, {"forces": {(ring, "top"): (1, 0, 0)}}, ("load-not-in-plane", "along z")),
        (ring, {"gravity": (1, 0, 0)}, ("load-not-in-plane", "Gravity")),
        (ring, {"motions": {floor: {"x": 0.1}}}, ("motion-not-in-plane", "in x")),
    ]
    for body, loads, message in cases:
        scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
        with refused(fc.InputError, *message):
            scene.solve(**loads)
    spring = fc.Spring(1.0, (ring, (0.0, 0.0, 1.0)), (None, (0.0, 0.0, 2.0)))
    with refused(fc.InputError, "input", "no springs"):
        fc.Scene([ring, floor], [fc.Contact(ring, floor)], springs=[spring])


def test_rigid_surfaces_without_the_symmetry_are_refused():
    section = fc.sections.rectangle((1.0, 1.0), (2, 2))
    flat, ring = (kind(section, STEEL, "bottom", {"top": "xz"}) for kind in KINDS)
    tilted = fc.rotation_about((0, 1, 0), 0.2)
    wrong = [
        (flat, fc.RigidBody(fc.Sphere(5.0)).placed((0, 0, -10)), ("not-along-the-axis",)),
        (ring, fc.RigidBody(fc.Plane()).placed(rotation=tilted), ("not-along-the-axis",)),
        (ring, fc.RigidBody(fc.Sphere(5.0)).placed((0.3, 0, -10)), ("not-along-the-axis",)),
    ]
    for body, rigid, message in wrong:
        scene = fc.Scene([body, rigid], [fc.Contact(body, rigid)])
        with refused(fc.InputError, *message):
            scene.solve(motions={body: {"z": -0.01}})
    right = [(flat, fc.RigidBody(fc.Plane()).placed((0, 0, -0.1), tilted)), (ring, fc.RigidBody(fc.Plane()))]
    for body, rigid in right:
        fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={body: {"z": -0.01}})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mesh": "hex"}, ("wrong-class", "a SectionMesh")),
        ({"supports": {"top": "y"}}, ("support-components", "'x' and 'z'")),
        ({"supports": {"lid": "z"}}, ("unknown-boundary", "'lid'")),
        ({"contact": "lid"}, ("unknown-boundary", "'lid'")),
        ({"integration": "half"}, ("unknown-name", "integration")),
        ({"thickness": -1.0}, ("not-positive", "The thickness")),
        ({"plane": "stretch"}, ("unknown-name", "'strain', 'stress'")),
        ({"plane": "stress", "integration": "selective"}, ("stress",)),
        ({"material": {"bone": STEEL}}, ("input", "no element set")),
    ],
)
def test_bad_bodies(change, message):
    given = {"mesh": fc.sections.rectangle((1.0, 1.0), (1, 1)), "material": STEEL, "contact": "bottom", **change}
    if given["mesh"] == "hex":
        given["mesh"] = fc.shapes.block((1, 1, 1), (1, 1, 1))
    with refused(fc.InputError, *message):
        fc.PlaneBody(**given)


def test_bad_meshes():
    good = fc.sections.rectangle((1.0, 1.0), (1, 1))
    with refused(fc.MeshError, "folded-cell", "clockwise"):
        fc.SectionMesh(good.points, good.cells[:, [0, 3, 2, 1, 7, 6, 5, 4]])
    with refused(fc.MeshError, "off-plane"):
        good.mapped(lambda x: x + np.array([0, 1, 0]))
    with refused(fc.MeshError, "unused-points", "belong to no cell"):
        fc.SectionMesh(np.concatenate([good.points, [[5.0, 0, 0]]]), good.cells)
    with refused(fc.MeshError, "wrong-shape", "quadrilaterals of 8 or 9 nodes"):
        fc.SectionMesh(good.points, good.cells[:, :4])
    with refused(fc.MeshError, "negative-radius"):
        fc.AxisymmetricBody(good.translated((-0.5, 0, 0)), STEEL)
    with refused(fc.InputError, "unknown-name", "element"):
        fc.sections.rectangle((1.0, 1.0), (1, 1), element="hex20")
    with refused(fc.InputError, "input", "outer radius"):
        fc.sections.ring(2.0, 1.0, 1.0, (1, 1))
    with refused(fc.InputError, "empty-boundary", "side"):
        good.with_boundary("lid", lambda x: x[:, 2] > 5)
    assert len(good.with_boundary("lid", lambda x: x[:, 2] > 0.99).faces("lid")) == 1


@pytest.mark.parametrize("element", ["quad8", "quad9"])
def test_shapes(element):
    disc = fc.sections.half_disc(3.0, contact_radius=0.2, level=1, element=element)
    rim = disc.points[np.concatenate([disc.boundary_nodes("cap"), disc.boundary_nodes("flank")])]
    assert np.abs(np.hypot(rim[:, 0], rim[:, 2] - 3) - 3).max() < 1e-12
    cap = disc.points[disc.boundary_nodes("cap")]
    assert np.abs(cap[:, 0] - 0.2).min() < 1e-15
    assert not disc.points[disc.boundary_nodes("sym_x")][:, 0].any()
    assert set(disc.boundaries) == {"cap", "flank", "base", "sym_x"}
    named = sum(len(s) for s in disc.boundaries.values())
    assert named == len(disc.outer_sides)
    ring = fc.sections.annulus(1.0, 2.0, (4, 3), element=element)
    assert np.abs(np.linalg.norm(ring.points[ring.boundary_nodes("inner")], axis=1) - 1).max() < 1e-15


# pictures and the command line


def test_pictures(tmp_path):
    result, upper = hertz_scene(fc.AxisymmetricBody)
    contact = result.contacts[0]
    figure = result.plot("pressure", tmp_path / "pressure.png", units="MPa", length="mm")
    assert figure.axes[0].get_xlabel() == "radius [mm]"
    shown = figure.axes[0].lines[1].get_xydata()
    assert np.abs(shown - np.stack([contact.points[:, 0], contact.pressure], axis=1)).max() == 0
    assert result.plot("gap").axes[0].get_ylabel() == "gap"
    assert result.plot("von_mises", tmp_path / "bodies.png", scale=10).axes
    with refused(fc.InputError, "input", "no film of sensels"):
        result.plot("pressure", style="sensels")
    with refused(fc.InputError, "section-not-cut"):
        result.plot("von_mises", cut="x>0")
    from fecontact.results.pictures.bodies import plot_solids
    from fecontact.results.pictures.solids import solids_of_file

    solids = solids_of_file(result.save(tmp_path / "pressed.vtu"))
    assert [len(s.mesh.points) for s in solids] == 2 * [len(upper.mesh.points)]
    assert plot_solids(solids, "contact_pressure").axes


def test_two_spheres_from_the_command_line(tmp_path, capsys):
    import json

    from fecontact.app.cli import main

    picture = str(tmp_path / "spheres.png")
    assert main(["hertz", "--model", "axisymmetric", "--level", "1", "--json", "-", "--plot", picture]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["element"] == "quad8"
    assert abs(figures["total_force"] - 726.4) < 1e-6
    # the mesh is the coarsest; its contact radius is found by two passes, not given
    assert figures["pressure_l2_error"] < 0.035
    assert abs(figures["errors"]["contact_radius"]) < 2e-3
    assert main(["hertz", "--model", "axisymmetric", "--element", "hex8"]) == 2
    assert "hex27" in capsys.readouterr().err
