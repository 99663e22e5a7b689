"""Linear conditions between displacements, and prescribed displacements of supports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

import fecontact as fc
from fecontact.fem.links import Links
from tests.refusals import refused

SOFT = fc.Material(E=1000.0, nu=0.3)


@pytest.mark.parametrize("seed", range(8))
def test_conditions_hold_for_all_coordinates(seed):
    rng = np.random.default_rng(seed)
    C = sp.csr_matrix(rng.normal(size=(6, 15)) * (rng.random((6, 15)) < 0.5) * 10.0 ** rng.integers(-3, 3, (6, 1)))
    held = rng.random(15) < 0.2
    links = Links.of(C, held)
    assert len(links.dependents) == 6
    assert not held[links.dependents].any()
    c, v = rng.normal(size=6), rng.normal(size=15)
    v[links.dependents] = links.values(c, np.where(held, v, 0.0))
    assert np.abs(C @ (links.change @ v) - c).max() < 1e-10
    assert np.abs((links.change @ links.back).toarray() - np.eye(15)).max() < 1e-12


def test_conditions_that_follow_from_others_agree_or_are_refused():
    C = sp.csr_matrix([[1.0, 1, 0, 0], [0, 1, 1, 0], [1, 2, 1, 0], [0, 0, 0, 1]])
    links = Links.of(C, np.array([False, False, False, True]))
    assert len(links.dependents) == 2
    links.values(np.array([1.0, 2, 3, 4]), np.array([0, 0, 0, 4.0]))
    for c, v in (([1.0, 2, 4, 4], 4.0), ([1.0, 2, 3, 4], 5.0)):
        with refused(fc.InputError, "conditions-contradict"):
            links.values(np.array(c), np.array([0, 0, 0, v]))


def wall():
    """A wall at x = 1 that faces -x."""
    return fc.RigidBody(fc.Plane()).placed((1.0, 0, 0), np.array([[0, 0, -1.0], [0, 1, 0], [1, 0, 0]]))


def squeezed(law, rotation=None):
    """A block 1 x 1 x 2 between a wall, planes of symmetry, and a top whose displacement along z is prescribed."""
    supports = {"bottom": "z", "top": "z", "x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 2.0), (1, 1, 2)), law, "x_max", supports)
    body, side = body.placed(rotation=rotation), wall().placed(rotation=rotation)
    return body, fc.Scene([body, side], [fc.Contact(body, side)])


@pytest.mark.parametrize("turned", [False, True])
def test_a_support_whose_displacement_is_prescribed_strains_the_body(turned):
    Q = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    Q = Q * np.linalg.det(Q) if turned else np.eye(3)
    body, scene = squeezed(SOFT, Q)
    each = [
        scene.solve(displacements={(body, "top"): Q @ (0, 0, -0.02)}),
        scene.solve(displacements={(body, "top"): lambda x: np.tile(Q @ (0, 0, -0.02), (len(x), 1))}),
    ]
    for result in each:
        # Hooke's law with e_z = -0.01, e_x = 0 and s_y = 0
        stress = -0.01 * SOFT.E / (1 - SOFT.nu**2)
        assert abs(result.contacts[0].total_force + SOFT.nu * stress * 2.0) < 1e-9
        assert np.abs(result.reaction(body, "top")[:3] - Q @ (0, 0, stress)).max() < 1e-9
        assert np.abs(result.reaction(body, "bottom")[:3] + Q @ (0, 0, stress)).max() < 1e-9


def test_at_finite_strain_as_well():
    law = fc.NeoHookean(E=1.0, nu=0.3)
    body, scene = squeezed(law)
    result = scene.solve(displacements={(body, "top"): (0, 0, -0.8)})
    mu, lame = 1 / 2.6, 0.3 / (1.3 * 0.4)
    # s_i = (mu (l_i^2 - 1) + lame ln J) / J with l_x = 1, l_z = 0.6 and s_y = 0
    low, high = 0.5, 2.0
    for _ in range(80):
        y = (low + high) / 2
        low, high = (y, high) if mu * (y**2 - 1) + lame * np.log(0.6 * y) < 0 else (low, y)
    force = -lame * np.log(0.6 * y)  # over an area 2 0.6 y of the wall, and J = 0.6 y
    assert abs(result.contacts[0].total_force - 2 * force) < 1e-7


def test_prescribed_displacements_are_checked():
    body, scene = squeezed(SOFT)
    with refused(fc.InputError, "not-held", "top"):
        scene.solve(displacements={(body, "top"): (0.1, 0, 0)})
    with refused(fc.InputError, "no-support", "x_max"):
        scene.solve(displacements={(body, "x_max"): (0.1, 0, 0)})
    with refused(fc.InputError, "no-rows"):
        scene.solve(displacements={body: [0.1]})
    with refused(fc.InputError, "load-key"):
        scene.solve(displacements={(body, (0, 0, 0)): (0, 0, 1.0)})
    both = fc.ElasticBody(body.mesh, SOFT, "x_max", {"bottom": "xyz", "x_min": "x"})
    side = wall()
    with refused(fc.InputError, "supports-disagree"):
        fc.Scene([both, side], [fc.Contact(both, side)]).solve(displacements={(both, "x_min"): (0.1, 0, 0)})


def plate_of(mesh, name, component):
    """Conditions that a component of all nodes of a boundary is that of the first."""
    nodes = mesh.boundary_nodes(name)
    rows = sp.lil_matrix((len(nodes) - 1, 3 * len(mesh.points)))
    for k, node in enumerate(nodes[1:]):
        rows[k, 3 * node + component], rows[k, 3 * nodes[0] + component] = 1.0, -1.0
    return rows.tocsr()


def test_nodes_that_move_alike_carry_a_force_as_a_stiff_plate_does():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    rows, floor = plate_of(mesh, "top", 2), fc.RigidBody(fc.Plane())
    supports = {"x_min": "x", "y_min": "y"}
    body = fc.ElasticBody(mesh, SOFT, "bottom", supports, conditions=rows)
    corner = mesh.boundary_nodes("top")[0]
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(
        {(body, tuple(mesh.points[corner])): (0, 0, -3.0)}
    )
    top = result.displacement(body)[mesh.boundary_nodes("top")]
    # uniaxial stress: the plate spreads the force evenly
    assert np.abs(top[:, 2] + 3.0 / SOFT.E).max() < 1e-12
    assert np.abs(result.contacts[0].pressure - 3.0).max() < 1e-9


def test_values_of_conditions_are_prescribed():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex20")
    top, bottom = (mesh.boundary_nodes(name) for name in ("top", "bottom"))
    order = np.lexsort(mesh.points[top, :2].T), np.lexsort(mesh.points[bottom, :2].T)
    pairs = np.stack([top[order[0]], bottom[order[1]]], axis=1)
    n = len(pairs)
    place = (np.repeat(np.arange(n), 2), (3 * pairs + 2).ravel())
    rows = sp.csr_matrix((np.tile([1.0, -1.0], n), place), shape=(n, 3 * len(mesh.points)))
    body = fc.ElasticBody(mesh, SOFT, "x_max", {"bottom": "z", "x_min": "x", "y_min": "y"}, conditions=rows)
    side = wall()
    scene = fc.Scene([body, side], [fc.Contact(body, side)])
    result = scene.solve(displacements={body: np.full(n, -0.01)})
    assert abs(result.contacts[0].total_force - 0.3 * 10.0 / (1 - 0.09)) < 1e-9
    with refused(fc.InputError, "wrong-shape"):
        scene.solve(displacements={body: np.zeros(n + 1)})
    with refused(fc.InputError, "conditions-on-nodes"):
        body._divided({"x_max": np.array([0])})
    for wrong, code in ((np.zeros((1, 3)), "conditions-shape"), (np.zeros((1, rows.shape[1])), "conditions-values")):
        with refused(fc.InputError, code):
            fc.ElasticBody(mesh, SOFT, "x_max", conditions=wrong)


def test_parts_of_a_mesh_that_conditions_join_are_one_body():
    one = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    mesh = fc.mesh.mesh.merge([one, one.translated((0, 0, 1.5))], 1e-9)
    upper = np.flatnonzero(np.isclose(mesh.points[:, 2], 1.5))
    lower = np.flatnonzero(np.isclose(mesh.points[:, 2], 1.0))
    order = np.lexsort(mesh.points[upper, :2].T), np.lexsort(mesh.points[lower, :2].T)
    dofs = [(3 * nodes[k][:, None] + np.arange(3)).ravel() for nodes, k in zip((upper, lower), order, strict=True)]
    n = len(dofs[0])
    rows = sp.csr_matrix(
        (np.repeat([1.0, -1.0], n), (np.tile(np.arange(n), 2), np.concatenate(dofs))), shape=(n, 3 * len(mesh.points))
    )
    base = np.flatnonzero(np.isclose(mesh.points[:, 2], 0.0))
    faces = mesh.outer_faces
    at = mesh.points[mesh.face_nodes(faces)[:, :4], 2].min(axis=1)

    mesh = replace(mesh, node_sets={"base": base}, boundaries={"head": faces[at > 2.4]})
    body = fc.ElasticBody(mesh, fc.Material(E=1000.0, nu=0.0), "head", {"base": "xyz"}, conditions=rows)
    lid = fc.RigidBody(fc.Plane()).placed((0, 0, 2.5), np.diag([1.0, -1.0, -1.0]))
    result = fc.Scene([body, lid], [fc.Contact(body, lid)]).solve(motions={lid: {"z": -0.02}})
    assert abs(result.contacts[0].total_force - 1000.0 * 0.02 / 2.0) < 1e-8
