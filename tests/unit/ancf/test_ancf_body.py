"""The brick as a body of a scene."""

import json

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace
from fecontact.ancf.bricks.body import AncfModel

STEEL = fc.Material(E=200.0, nu=0.3, density=2.0)


def block(n=(2, 2, 2), element="hex8", **options):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), n, element=element)
    return fc.AncfBody(mesh, **{"material": STEEL, **options})


def test_rigid_modes_turn_the_gradients():
    body = block()
    R = body.rigid_modes
    assert body.free_motions.shape == (6, 6)
    K = body.model.stiffness
    full = K + K.T
    assert np.abs((full @ R) - K.diagonal()[:, None] * R).max() < 1e-12 * abs(K).max()
    # a turn about z: dr/dX turns into y
    assert np.abs(R.reshape(-1, 4, 3, 6)[:, 1, :, 5] - [0, 1, 0]).max() < 1e-15


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_any_hexahedra(element):
    """The same coordinates from meshes of 8, 20 and 27 nodes with straight edges."""
    body = block(element=element, contact="bottom")
    assert body.n_dofs == 12 * 27
    assert body.mesh.cell_type == "hex20"


def test_uniform_compression_on_a_plane():
    """Patch test: pressure, stress and reactions of a block on a rigid plane, to rounding."""
    for n in ((2, 2, 2), (3, 1, 2)):
        body = block(n, contact="bottom", supports={"top": "z", "x_min": "x", "y_min": "y"})
        floor = fc.RigidBody(fc.Plane())
        result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(forces={body: (0.0, 0.0, -2.0)})
        contact = result.contacts[0]
        assert np.abs(contact.pressure - 2.0).max() < 1e-11
        assert np.abs(result.stress(body) - [0, 0, -2, 0, 0, 0]).max() < 1e-11
        assert np.abs(result.strain(body)[:, 0] - 0.3 * 2 / 200).max() < 1e-13
        assert np.abs(result.reaction(body, "top")[:3] - [0, 0, -2]).max() < 1e-12
        assert result.residuals().equilibrium < 1e-12


@pytest.mark.parametrize("other", ["ancf", "elastic", "halfspace"])
def test_masters_of_all_kinds(other):
    upper = block((2, 2, 1), contact="bottom", supports={"top": "xyz"}, name="upper").placed((0.0, 0.0, 1.0))
    if other == "halfspace":
        lower = fc.HalfSpace(STEEL, size=(4.0, 4.0), cells=(17, 17))
        upper = upper.placed((-0.5, -0.5, -1.0))
    elif other == "ancf":
        lower = block((3, 3, 2), contact="top", supports={"bottom": "xyz"}, name="lower")
    else:
        mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 2))
        lower = fc.ElasticBody(mesh, STEEL, "top", {"bottom": "xyz"}, name="lower")
    contact = fc.Contact(upper, lower)
    result = fc.Scene([upper, lower], [contact]).solve(motions={upper: {"z": -0.01}})
    r = result.residuals()
    assert max(r.penetration, r.tension, r.complementarity, r.equilibrium) < 1e-9
    assert result.contacts[0].total_force > 0
    total = result.reaction(upper)[2] + result.reaction(lower)[2] if other != "halfspace" else 0.0
    assert abs(total) < 1e-10 * result.contacts[0].total_force


def test_slave_or_master_of_a_plain_body():
    """A plain body's nodes on a brick's faces: the forces reach the gradients, and the patch test holds."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1))
    sides = {"x_min": "x", "y_min": "y"}
    upper = fc.ElasticBody(mesh, STEEL, "bottom", {"top": "z", **sides}).placed((0.0, 0.0, 1.0))
    lower = block(contact="top", supports={"bottom": "z", **sides})
    result = fc.Scene([upper, lower], [fc.Contact(upper, lower)]).solve(forces={upper: (0.0, 0.0, -2.0)})
    assert result.contacts[0].slave is upper
    for body in (upper, lower):
        assert np.abs(result.stress(body) - [0, 0, -2, 0, 0, 0]).max() < 1e-11


def test_loads():
    """Weight, boundary force, pressure and force at a point, against the reaction of the support."""
    body = block(supports={"bottom": "xyz"}, contact="top")
    floor = fc.RigidBody(fc.Plane()).placed((0.0, 0.0, 5.0), fc.rotation_about((1.0, 0.0, 0.0), np.pi))
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    held = scene.solve(gravity=(0.0, 0.0, -10.0))
    assert np.abs(held.reaction(body, "bottom") - [0, 0, 20, 0, 0, 0]).max() < 1e-10
    forces = {(body, "x_max"): (1.0, 2.0, 3.0), (body, (1.0, 1.0, 0.5)): (0.0, 1.0, 0.0)}
    held = scene.solve(forces=forces, pressures={(body, "y_max"): 4.0})
    assert np.abs(held.reaction(body, "bottom")[:3] - np.array([-1, 1, -3])).max() < 1e-11


def test_floating_body_rests():
    """A body without supports, pressed down by its weight: equilibrium, and rigid motion from mass weights."""
    body = block((2, 2, 1), contact="bottom").placed((0.0, 0.0, 0.5))
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    result = scene.solve(gravity=(0.0, 0.0, -10.0), free={body: "z rx ry"}, motions={body: {"x": 0, "y": 0, "rz": 0}})
    assert abs(result.contacts[0].force[2] - 20) < 1e-9
    motion = result.rigid_motion(body)
    assert abs(motion.translation[2] + 0.5) < 0.1
    assert np.abs(motion.rotation).max() < 1e-9


def test_posed_copies_share_the_model():
    body = block((2, 2, 1), contact="bottom", supports={"top": "xyz"}, name="upper").placed((0.0, 0.0, 1.0))
    flip = fc.rotation_about((1.0, 1.0, 0.0), np.pi)
    lower = body.placed(rotation=flip, translation=(0.0, 0.0, 2.0), name="lower")
    assert isinstance(lower, fc.AncfBody)
    assert lower.model is body.model
    result = fc.Scene([body, lower], [fc.Contact(body, lower)]).solve(motions={body: {"z": -0.01}})
    assert result.n_dofs == 2 * result.n_dofs_factorised
    u, v = (result.displacement(b) for b in (body, lower))
    # the bodies give in equal measure: relative to their frames they are images of each other
    assert np.abs((u - [0, 0, -0.01]) - v @ flip.T).max() < 1e-12


def test_two_materials_release_the_normal_gradient():
    mesh = fc.shapes.block((1.0, 1.0, 2.0), (2, 2, 4), element="hex8")
    z = mesh.points[mesh.cells].mean(axis=1)[:, 2]
    mesh = fc.Mesh(mesh.points, mesh.cells, mesh.boundaries, {"a": np.flatnonzero(z < 1), "b": np.flatnonzero(z > 1)})
    materials = {"a": fc.Material(1.0, 0.0), "b": fc.Material(50.0, 0.0)}
    body = fc.AncfBody(mesh, materials, "bottom", {"top": "z", "x_min": "x", "y_min": "y"})
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(forces={body: (0.0, 0.0, -0.01)})
    assert np.abs(result.stress(body)[:, 2] + 0.01).max() < 1e-12
    soft = result.stress(body, "a")
    assert np.array_equal(np.isnan(soft[:, 2]), body.mesh.points[:, 2] > 1.01)
    assert abs(-result.rigid_motion(body).translation[2] - 0.01 * (1 + 1 / 50)) < 1e-12


def test_oblique_supports():
    """A turned block on rollers along its own normals answers as the straight one does."""
    R = fc.rotation_about((1.0, 2.0, 3.0), 0.6)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    supports = {"top": "n", "x_min": "n", "y_min": "n"}
    pressures = []
    for Q in (np.eye(3), R):
        body = fc.AncfBody(mesh.mapped(lambda x, Q=Q: x @ Q.T), STEEL, "bottom", supports)
        floor = fc.RigidBody(fc.Plane()).placed(rotation=Q)
        scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
        result = scene.solve(pressures={(body, "x_max"): 1.0})
        pressures.append(result.contacts[0].pressure)
        assert result.reaction(body, "x_min") @ np.r_[Q[:, 0], 0, 0, 0] == pytest.approx(1.0, abs=1e-12)
    assert np.abs(pressures[0] - pressures[1]).max() < 1e-10


def test_files_and_pictures(tmp_path):
    body = block(contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    written = meshio.read(result.save(tmp_path / "body.vtu"))
    assert written.cells_dict["hexahedron20"].shape == (8, 20)
    top = np.abs(written.points[:, 2] - 1) < 1e-12
    assert np.abs(written.point_data["displacement"][top] - [0, 0, -0.01]).max() < 1e-14
    assert written.point_data["contact_pressure"].max() > 1.0
    assert json.loads(result.save(tmp_path / "body.json").read_text())["n_dofs"] == body.n_dofs
    result.plot("pressure", tmp_path / "pressure.png")
    assert (tmp_path / "pressure.png").stat().st_size > 1000
    assert "bricks" in str(result)


def test_refused():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    with refused(fc.InputError, "unknown-name", "pressure"):
        fc.AncfBody(mesh, STEEL, pressure="nodal")
    with refused(fc.InputError, "unknown-name", "integration"):
        fc.AncfBody(mesh, STEEL, integration="none")
    collapsed = fc.Mesh(mesh.points, mesh.cells[:, [0, 1, 2, 2, 4, 5, 6, 6]])
    with refused(fc.MeshError, "degenerate-cells"):
        fc.AncfBody(collapsed, STEEL)
    body = block(contact="bottom")
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor, coupling="nodal")])
    with refused(fc.InputError, "gradients-left-out"):
        scene.solve(motions={body: {"z": -0.1}})


def test_selective_integration_is_chosen_by_poissons_ratio():
    assert not AncfModel(block().mesh, fc.Material(1.0, 0.3), {}).selective
    assert AncfModel(block().mesh, fc.Material(1.0, 0.495), {}).selective


@pytest.mark.parametrize("kept", [True, False])
def test_linear_dilatation_holds_affine_states_and_adds_no_mechanism(kept, monkeypatch):
    if not kept:
        monkeypatch.setattr("fecontact.ancf.bricks.solid.KEPT_BYTES", 0)  # shape functions are made anew for each rule
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 1, 1), element="hex8").mapped(
        lambda x: x + 0.1 * np.sin(3 * x[:, ::-1])
    )
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.49))
    K, full = solid.stiffness_of_linear_dilatation, solid.stiffness
    scale = abs(full).max()
    state = solid.space.affine(np.random.default_rng(0).random((3, 3)))
    assert np.abs((K - full) @ state).max() < 1e-12 * scale  # a constant divergence is kept
    assert abs(K - K.T).max() < 1e-13 * scale
    values = np.linalg.eigvalsh(K.toarray())
    assert (np.abs(values[:6]) < 1e-12 * values[-1]).all()  # rigid motions, and no other
    assert values[6] > 1e-7 * values[-1]
    # projected, so never stiffer
    assert np.linalg.eigvalsh((full - K).toarray())[0] > -1e-12 * scale


def domed(length=1.0, modulus=1.0, shuffled=False):
    """Block whose lower face bulges, on a plane; pressures in a fixed order, over the modulus."""
    mesh = fc.shapes.block((length, length, 0.5 * length), (4, 4, 2), element="hex8")
    middle = np.array([0.5, 0.45]) * length

    def bulge(x):
        lift = 0.3 * ((x[:, :2] - middle) ** 2).sum(axis=1) / length * (1 - x[:, 2] / (0.5 * length))
        return x + lift[:, None] * np.array([0.0, 0.0, 1.0])

    mesh = mesh.mapped(bulge)
    if shuffled:
        rng = np.random.default_rng(0)
        number, order = rng.permutation(len(mesh.points)), rng.permutation(len(mesh.cells))
        points = np.empty_like(mesh.points)
        points[number] = mesh.points
        place = np.argsort(order)
        sides = {k: np.stack([place[f[:, 0]], f[:, 1]], axis=1) for k, f in mesh.boundaries.items()}
        mesh = fc.Mesh(points, number[mesh.cells[order]], sides)
    return fc.AncfBody(mesh, fc.Material(modulus, 0.3, density=1.0), "bottom", {"top": "xyz"})


def pressed(body, length=1.0, modulus=1.0):
    floor = fc.RigidBody(fc.Plane())
    load = (0.0, 0.0, -0.02 * modulus * length**2)
    contact = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(forces={body: load}).contacts[0]
    return contact.pressure[np.lexsort(np.round(contact.points / length, 6).T)] / modulus


def test_units_and_numbers_do_not_matter():
    """Other units of length and force, another numbering: the same pressures to rounding."""
    reference = pressed(domed())
    assert 0 < (reference > 0).sum() < len(reference)
    for options in ({"length": 1e-3}, {"length": 1e3}, {"modulus": 1e-9}, {"length": 1e-3, "modulus": 2e11}):
        assert np.abs(pressed(domed(**options), **options) - reference).max() < 1e-11 * reference.max()
    assert np.abs(pressed(domed(shuffled=True)) - reference).max() < 1e-11 * reference.max()


def test_finite_motion_and_sweeps():
    body = domed()
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    finite = scene.solve(motions={body: {"z": -0.01}}, finite_motion=True)
    small = scene.solve(motions={body: {"z": -0.01}})
    assert finite.contacts[0].total_force == pytest.approx(small.contacts[0].total_force, rel=1e-6)
    rows = scene.sweep([{"name": str(z), "motions": {body: {"z": z}}} for z in (-0.005, -0.01)])
    assert len(rows) == 2


@pytest.mark.full
def test_hertz_from_the_command_line(capsys):
    from fecontact.app.cli import main

    assert main(["hertz", "--element", "ancf", "--model", "symmetric", "--level", "1", "--json", "-"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["pressure_l2_error"] < 0.032  # measured 0.0293
    assert abs(figures["errors"]["contact_radius"]) < 0.004  # measured 0.0035
