"""Pressures and tractions that vary over a boundary, against resultants and moments integrated by hand."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.contact.loads import LoadStep

STEEL = fc.Material(E=1.0, nu=0.3)
KINDS = ("hex8", "hex20", "hex27", "ancf", "section")


def made(kind):
    """A block over 0 < x < 2, 0 < y < 1, 0 < z < 1; as a section of unit thickness."""
    if kind == "section":
        mesh = fc.sections.rectangle((2.0, 1.0), (2, 1))
        mesh = mesh.translated(-mesh.points.min(axis=0))
        return fc.PlaneBody(mesh, STEEL, "top", {"bottom": "xz"}, name="block")
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex20" if kind == "ancf" else kind)
    mesh = mesh.translated(-mesh.points.min(axis=0))
    body = fc.AncfBody if kind == "ancf" else fc.ElasticBody
    return body(mesh, STEEL, "top", {"bottom": "xyz"}, name="block")


def resultant(body, **loads):
    """Nodal forces at the points that a rigid motion shows them at: force, and moment about the mesh's origin."""
    loading = LoadStep.of(loads).on([body])
    total = body.model.rigid_modes.T @ loading.distributed[0]
    return total[:3], total[3:] + np.cross(body.reference_point, total[:3])


def top(body):
    return body.mesh.points[body.mesh.boundary_nodes("top")]


@pytest.mark.parametrize("kind", KINDS)
def test_a_pressure_that_grows_along_x(kind):
    """p = 1 + 3 x over 2 x 1: force 8 downwards at x = 10/8; by function and by nodes."""
    body = made(kind)
    by_nodes = 1 + 3 * top(body)[:, 0]
    for given in (lambda x: 1 + 3 * x[:, 0], by_nodes, by_nodes.tolist()):
        force, moment = resultant(body, pressures={(body, "top"): given})
        assert np.abs(force - [0, 0, -8]).max() < 1e-12
        assert abs(moment[1] - 10) < 1e-12
        assert kind == "section" or abs(moment[0] + 4) < 1e-12


@pytest.mark.parametrize("kind", ["hex20", "hex27", "ancf"])
def test_values_at_nodes_are_interpolated_by_the_faces_own_functions(kind):
    """Quadratic intensities are those of the function, on faces of eight and nine nodes."""
    body = made(kind)

    def p(x):
        return 1 + x[:, 0] * x[:, 1] - x[:, 0] ** 2

    by_function = LoadStep(pressures={(body, "top"): p}).on([body]).distributed[0]
    by_nodes = LoadStep(pressures={(body, "top"): p(top(body))}).on([body]).distributed[0]
    assert np.abs(by_nodes - by_function).max() < 1e-12 * np.abs(by_function).max()


def test_tractions_are_in_world_axes_at_points_of_the_body():
    """t = (0, x, y) on a block turned by a quarter about z: force (0, 2, 1), whatever way the block is turned."""
    body = made("hex20")
    turned = body.placed(rotation=fc.rotation_about((0, 0, 1), np.pi / 2))

    def t(x):
        return np.stack([0 * x[:, 0], x[:, 0], x[:, 1]], axis=1)

    for given in (t, t(top(body))):
        for b in (body, turned):
            force, _ = resultant(b, tractions={(b, "top"): given})
            assert np.abs(b.pose.rotation @ force - [0, 2, 1]).max() < 1e-12
    force, _ = resultant(turned, tractions={(turned, "top"): (0.0, 2.0, 1.0)})
    assert np.abs(turned.pose.rotation @ force - [0, 4, 2]).max() < 1e-12


def test_a_scene_under_a_traction_is_that_under_the_same_force():
    """Uniform: force over area; and a pressure of a number or of equal values at the nodes."""
    body, floor = made("hex20"), fc.RigidBody(fc.Plane())
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1))
    body = fc.ElasticBody(mesh, STEEL, "bottom", name="block")
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    held = {body: {"x": 0.0, "y": 0.0, "rx": 0.0, "ry": 0.0, "rz": 0.0}}
    known = scene.solve(forces={(body, "top"): (0.0, 0.0, -0.02)}, motions=held).contacts[0].forces
    n = len(mesh.boundary_nodes("top"))
    for loads in (
        {"tractions": {(body, "top"): (0.0, 0.0, -0.01)}},
        {"pressures": {(body, "top"): 0.01}},
        {"pressures": {(body, "top"): np.full(n, 0.01)}},
        {"pressures": {(body, "top"): lambda x: np.full(len(x), 0.01)}},
    ):
        found = scene.solve(**loads, motions=held).contacts[0].forces
        assert np.abs(found - known).max() < 1e-10 * known.max()


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        ({"pressures": [1.0, 2.0]}, ("wrong-shape", "given by nodes", "(15,)", "(2,)")),
        ({"pressures": np.full(15, np.nan)}, ("not-finite", "finite; 15")),
        ({"pressures": lambda x: x}, ("wrong-shape", "a function of points (")),
        ({"pressures": lambda x: x[:, 0] / 0.0 * 0.0}, ("not-finite",)),
        ({"tractions": lambda x: "up"}, ("not-numbers", "'up'")),
        ({"tractions": [[1.0, 2.0]]}, ("wrong-shape", "(15, 3)")),
        ({"tractions": 1.0}, ("wrong-shape", "(15, 3)", "()")),
    ],
)
@pytest.mark.filterwarnings("ignore:.*divide:RuntimeWarning", "ignore:.*invalid:RuntimeWarning")
def test_wrong_intensities_are_refused(loads, message):
    body = made("hex27")
    with refused(fc.InputError, *message):
        resultant(body, **{kind: {(body, "top"): value} for kind, value in loads.items()})


def test_other_refusals():
    body, plane = made("section"), fc.RigidBody(fc.Plane())
    with refused(fc.InputError, "load-not-in-plane", "The traction on 'top' of 'block'"):
        resultant(body, tractions={(body, "top"): lambda x: np.ones((len(x), 3))})
    with refused(fc.InputError, "load-key", "traction"):
        resultant(body, tractions={body: (0.0, 0.0, 1.0)})
    solid = made("hex20")
    scene = fc.Scene([solid, plane], [fc.Contact(solid, plane)])
    with refused(fc.InputError, "load-at-nodes"):
        scene.solve(pressures={(solid, "top"): np.ones(len(top(solid)))}, accuracy=0.1)
    with refused(fc.InputError, "needs-elastic-body"):
        scene.solve(tractions={(plane, "surface"): (0.0, 0.0, 1.0)})
