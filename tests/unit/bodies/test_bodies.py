"""Poses, rigid shapes and elastic bodies."""

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import InputError, MeshError
from fecontact.common.stopwatch import Stopwatch

Q = fc.rotation_about((1, 2, 3), 0.7)
STEEL = fc.Material(E=210e3, nu=0.3)


def cube(**options):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element=options.pop("element", "hex20"))
    return fc.ElasticBody(mesh, STEEL, **{"contact": "top", "supports": {"bottom": "xyz"}, **options})


def test_rotation_about():
    assert np.abs(Q @ Q.T - np.eye(3)).max() < 1e-15
    assert abs(np.linalg.det(Q) - 1) < 1e-15
    assert np.abs(Q @ [1, 2, 3] - [1, 2, 3]).max() < 1e-15
    # small angles keep their digits: the rotation less the identity is W to first order
    tiny = fc.rotation_about((0, 0, 1), 1e-9)
    assert tiny[1, 0] == 1e-9
    with refused(InputError, "input", "not zero"):
        fc.rotation_about((0, 0, 0), 1.0)


def test_pose_there_and_back():
    pose = fc.Pose(Q, np.array([1.0, 2.0, 3.0]))
    x = np.random.default_rng(1).normal(size=(5, 3))
    assert np.abs(pose.to_body(pose.to_world(x)) - x).max() < 1e-15 * 10
    further = pose.then(Q.T, np.array([0.0, 0.0, 5.0]))
    assert np.abs(further.to_world(x) - (pose.to_world(x) @ Q + [0, 0, 5])).max() < 1e-14


def test_relative_pose_drops_a_common_offset():
    x = np.random.default_rng(2).normal(size=(5, 3))
    a, b = fc.Pose(Q, np.array([1.0, 0.5, 0.25])), fc.Pose(Q.T, np.array([0.0, 0.25, 0.5]))
    seen = a.relative_to(b)
    assert np.abs(seen.to_world(x) - b.to_body(a.to_world(x))).max() < 1e-14
    # a shift by a power of two leaves these translations exact, so nothing at all may change
    far = np.full(3, 2.0**20)
    moved = fc.Pose(Q, a.translation + far).relative_to(fc.Pose(Q.T, b.translation + far))
    assert np.array_equal(moved.translation, seen.translation)


@pytest.mark.parametrize(
    ("rotation", "translation", "words"),
    [
        (np.diag([1.0, 1.0, -1.0]), np.zeros(3), ("no-rotation",)),
        (1.1 * np.eye(3), np.zeros(3), ("no-rotation",)),
        (np.eye(2), np.zeros(3), ("no-rotation",)),
        (np.full((3, 3), np.nan), np.zeros(3), ("no-rotation",)),
        (np.eye(3), np.array([0.0, np.nan, 0.0]), ("not-a-vector", "three")),
        (np.eye(3), np.zeros(2), ("not-a-vector", "three")),
    ],
)
def test_bad_poses(rotation, translation, words):
    with refused(InputError, *words):
        fc.Pose(rotation, translation)


def test_rigid_sphere_keeps_digits_near_its_pole():
    R = 3.0
    r = np.array([1e-6, 1e-4, 1e-2])
    z = r**2 / (R + np.sqrt(R**2 - r**2))  # on the sphere
    gap = np.array([1e-12, 1e-8, 1e-3])
    n = np.column_stack([r, np.zeros(3), z - R]) / R
    projection = fc.Sphere(R).project(np.column_stack([r, np.zeros(3), z]) + gap[:, None] * n)
    # coordinates of size r, z and gap only: 1e-16 of them
    assert np.abs(projection.gap - gap).max() < 1e-16
    assert np.abs(projection.gap / gap - 1).max() < 1e-9
    assert np.abs(np.linalg.norm(projection.points - [0, 0, R], axis=1) - R).max() < 1e-15 * R * 2
    with refused(InputError, "not-positive", "A sphere's radius"):
        fc.Sphere(-1.0)


def test_rigid_body_traces_its_motion():
    body = fc.RigidBody(fc.Sphere(2.0))
    x = np.random.default_rng(3).normal(size=(7, 3))
    projection = body.surface("surface").project(x)
    directions = np.random.default_rng(4).normal(size=(7, 3))
    motion = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    field = motion[:3] + np.cross(motion[3:], projection.points)
    assert np.abs(body._trace(projection, directions) @ motion - (field * directions).sum(axis=1)).max() < 1e-14
    reduced = body.reduce(body._trace(projection, directions), None, Stopwatch())
    assert reduced.compliance is None
    with refused(InputError, "unknown-surface", "'cap'"):
        body.surface("cap")


def test_compliance_equals_the_dense_inverse():
    body = cube()
    model = body.model
    K = model.stiffness.toarray()
    K = (K + np.triu(K, 1).T)[np.ix_(model.solved_dofs, model.solved_dofs)]
    nodes = body.mesh.boundary_nodes("top")
    C = sp.random(6, body.n_dofs, density=0.0, format="lil")
    rng = np.random.default_rng(5)
    for k in range(6):
        C[k, 3 * nodes[rng.integers(len(nodes), size=3)] + rng.integers(3, size=3)] = rng.normal(size=3)
    C = C.tocsr()
    loads = rng.normal(size=body.n_dofs)
    reduced = body.reduce(C, loads, Stopwatch())
    local = C.toarray()[:, model.solved_dofs]
    S = local @ np.linalg.solve(K, local.T)
    # condition about 1e4
    assert np.abs(reduced.compliance - S).max() < 1e-11 * np.abs(S).max()
    assert np.array_equal(reduced.compliance, reduced.compliance.T)
    response = local @ np.linalg.solve(K, loads[model.solved_dofs])
    assert np.abs(reduced.response - response).max() < 1e-11 * np.abs(response).max()
    forces = rng.normal(size=6)
    u = body.displacement(C, forces, loads)
    expected = np.linalg.solve(K, (C.T @ forces + loads)[model.solved_dofs])
    assert np.abs(u[model.solved_dofs] - expected).max() < 1e-11 * np.abs(expected).max()
    assert not u[model.held].any()
    assert np.abs(C @ u - (reduced.compliance @ forces + reduced.response)).max() < 1e-11 * np.abs(u).max()


def test_placed_bodies_share_their_model():
    lower = cube()
    upper = lower.placed(translation=(0, 0, 2), rotation=Q, name="upper")
    assert upper.model is lower.model
    assert upper.name == "upper"
    assert lower.name == "body"
    twice = upper.placed(translation=(1, 0, 0))
    assert np.abs(twice.pose.translation - [1, 0, 2]).max() < 1e-15
    assert len({lower, upper, twice}) == 3


def test_midface_nodes_only_where_asked():
    assert cube().mesh.midface is not None
    assert cube(pressure="nodal").mesh.midface is None
    assert cube(element="hex8").mesh.midface is None
    assert cube(contact=()).mesh.midface is None
    assert (cube(contact=("top", "x_min")).mesh.midface >= 0).sum() == 8


def test_reference_point_is_the_centre_of_mass():
    assert np.abs(cube().reference_point - 0.5).max() < 1e-15
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    mesh = mesh.with_group("left", lambda x: x[:, 0] < 0.5).with_group("right", lambda x: x[:, 0] > 0.5)
    heavy, light = fc.Material(E=1, nu=0.3, density=3.0), fc.Material(E=1, nu=0.3, density=1.0)
    body = fc.ElasticBody(mesh, {"left": heavy, "right": light})
    assert abs(body.reference_point[0] - (3 * 0.25 + 0.75) / 4) < 1e-15
    assert body.contact_modulus == heavy.plane_strain_modulus


def test_bad_bodies(degenerate):
    with refused(InputError, "unknown-boundary", "'lid'", "'x_min'", "'top'"):
        cube(contact="lid")
    with refused(InputError, "unknown-boundary", "'lid'", "'x_min'", "'top'"):
        cube(supports={"lid": "xyz"})
    with refused(InputError, "unknown-name", "'bilinear'", "'midface', 'nodal'"):
        cube(pressure="bilinear")
    with refused(InputError, "no-contact-surface", "'top'"):
        cube().surface("bottom")
    with refused(InputError, "unknown-boundary", "'lid'"):
        cube().surface("lid")
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    with refused(MeshError, "folded-cell", "Cell 0", "left-handed"):
        fc.ElasticBody(mesh.mapped(lambda x: x * [1, 1, -1]), STEEL)
    with refused(MeshError, "mesh", "not finite"):
        fc.ElasticBody(mesh.mapped(lambda x: x * [1, np.nan, 1]), STEEL)
    with refused(InputError, "not-positive", "Young's modulus E", "found -1"):
        fc.Material(E=-1, nu=0.3)
    for nu in (0.5, -1.0, np.nan, 0.7):
        with refused(InputError, "poisson-ratio", "0.5"):
            fc.Material(E=1.0, nu=nu)
    with refused(InputError, "not-positive", "The density"):
        fc.Material(E=1.0, nu=0.3, density=0.0)


def test_bodies_describe_themselves():
    assert cube().describe() == "body: 8 hex20 cells + 4 mid-face nodes, 255 dofs"
    assert fc.RigidBody(fc.Sphere(1.0), name="ball").describe() == "ball: rigid Sphere"


def test_a_point_at_a_ball_s_centre_has_a_foot():
    projection = fc.Sphere(2.0).project(np.array([[0.0, 0.0, 2.0]]))
    assert np.abs(projection.normals - [0, 0, -1]).max() == 0
    assert projection.gap[0] == -2.0
