"""Loads, supports and released gradients of the brick."""

import numpy as np
import pytest
import scipy.sparse.linalg
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    body_force,
    dead_pressure,
    hold,
    nodal_force,
    point_force,
    pressure_forces,
    pressure_tangent,
    reentrant_points,
    released_at,
    sides_by_label,
    traction,
    weight,
)


@pytest.fixture
def space():
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (3, 2, 2), element="hex20")
    return AncfSpace(mesh.mapped(lambda x: x + 0.1 * np.stack([np.sin(x[:, 1]), x[:, 0] ** 2, np.sin(x[:, 0])], 1)))


def resultant(space, Q):
    """Force and moment about the origin: work on the six rigid motions."""
    return Q @ space.rigid_modes()


def test_weight(space):
    solid = AncfSolid(space, fc.Material(1.0, 0.3, density=2.0))
    Q = weight(solid, (0.0, 0.0, -9.0))
    assert np.abs(resultant(space, Q)[:3] - [0, 0, -18 * space.volumes.sum()]).max() < 1e-12 * 40
    assert np.abs(Q - body_force(space, (0.0, 0.0, -18.0))).max() < 1e-13
    # work on any field is that of the mass matrix on a uniform acceleration
    assert np.abs(Q - solid.mass @ space.affine(np.zeros((3, 3)), (0, 0, -9.0))).max() < 1e-6


def test_point_forces(space):
    X = np.array([0.3, 0.6, 0.2])
    x = space.points_at(space.q0, np.array([4]), X[None])[0]
    force = np.array([1.0, -2.0, 0.5])
    expected = np.concatenate([force, np.cross(x, force)])
    assert np.abs(resultant(space, point_force(space, 4, X, force)) - expected).max() < 1e-13 * 10
    point = int(space.nodes[7])
    expected = np.concatenate([force, np.cross(space.mesh.points[point], force)])
    assert np.abs(resultant(space, nodal_force(space, point, force)) - expected).max() < 1e-13 * 10
    middle = np.setdiff1d(np.arange(len(space.mesh.points)), space.nodes)[0]
    with refused(fc.InputError, "input", "no corner"):
        nodal_force(space, int(middle), force)
    with refused(fc.InputError, "not-a-vector", "three"):
        nodal_force(space, point, (1.0, 2.0))


def test_dead_load_is_that_of_the_surface(space):
    from fecontact.mesh.facets import facet_integrals

    mesh = space.mesh
    N, x, dA = facet_integrals(mesh.points, mesh.face_nodes(mesh.faces("top")), order=9)
    area = np.linalg.norm(dA, axis=2).sum()
    Q = traction(space, "top", (0.0, 1.0, 0.0))
    # the area of a curved face is no polynomial
    assert abs(resultant(space, Q)[1] / area - 1) < 1e-8
    Q = dead_pressure(space, "top", 2.0)
    assert np.abs(resultant(space, Q)[:3] + 2 * dA.sum(axis=(0, 1))).max() < 1e-12
    assert np.abs(resultant(space, Q)[3:] + 2 * np.cross(x, dA).sum(axis=(0, 1))).max() < 1e-12
    assert len(N) == len(mesh.faces("top"))


def test_pressure_follows(space):
    """On all faces of the body it is the gradient of p times the volume enclosed; alone it turns with the surface."""
    sides = ("x_min", "x_max", "y_min", "y_max", "bottom", "top")
    Q = sum(pressure_forces(space, space.q0, side, 3.0) for side in sides)
    # no resultant, and the work on a uniform stretch is -p dV
    assert np.abs(resultant(space, Q)).max() < 1e-12 * 10
    assert abs(Q @ space.affine(np.eye(3)) + 3 * 3.0 * space.volumes.sum()) < 1e-11
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = pressure_forces(space, space.affine(quarter), "top", 3.0).reshape(-1, 3)
    still = pressure_forces(space, space.q0, "top", 3.0).reshape(-1, 3)
    assert np.abs(turned - still @ quarter.T).max() < 1e-13
    assert np.abs(still.ravel() - dead_pressure(space, "top", 3.0)).max() < 1e-13


def test_pressure_tangent(space):
    rng = np.random.default_rng(0)
    q = space.q0 + 0.05 * rng.uniform(-1, 1, space.n_dofs)
    v = rng.uniform(-1, 1, space.n_dofs)
    h = 1e-4
    difference = (pressure_forces(space, q + h * v, "top", 2.0) - pressure_forces(space, q - h * v, "top", 2.0)) / 2 / h
    exact = pressure_tangent(space, q, "top", 2.0) @ v
    # the forces are quadratic in q, so that central differences are exact but for rounding
    assert np.abs(difference - exact).max() < 1e-10 * np.abs(exact).max()


def test_supports_along_the_axes():
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    s = hold(space, {"bottom": "xyz", "x_min": "x"})
    f, component = np.divmod(s.held, 3)
    kind = f % 4
    assert abs(s.basis - scipy.sparse.eye_array(space.n_dofs)).max() == 0
    # on the bottom dr/dZ stays free, but for its x component where x_min holds that
    assert set(zip(kind.tolist(), component.tolist(), strict=True)) == {
        *((k, c) for k in (0, 1, 2) for c in range(3)),
        (3, 0),
    }
    assert s.free.shape[1] + len(s.held) == space.n_dofs
    assert np.abs(s.rows @ s.free.toarray()).max() == 0


def test_supports_turn_with_the_body():
    """A clamped block in any orientation gives the same answer, so oblique faces are held as straight ones are."""
    material = fc.Material(1.0, 0.3)
    block = fc.shapes.block((3.0, 1.0, 1.0), (3, 1, 1), element="hex8")
    R = fc.rotation_about((1.0, 2.0, 3.0), 0.7)
    tips = []
    for Q in (np.eye(3), R):
        space = AncfSpace(block.mapped(lambda x, Q=Q: x @ Q.T))
        supports = hold(space, {"x_min": "xyz", "y_min": "xyz"})
        Z = supports.free
        load = traction(space, "x_max", Q @ [0.1, 0.5, 0.2])
        u = Z @ scipy.sparse.linalg.spsolve((Z.T @ AncfSolid(space, material).stiffness @ Z).tocsc(), Z.T @ load)
        tips.append(u.reshape(-1, 4, 3)[:, 0] @ Q)
    assert np.abs(tips[0] - tips[1]).max() < 1e-12 * np.abs(tips[0]).max()


def test_supports_refused(space):
    with refused(fc.InputError, "unknown-boundary"):
        hold(space, {"nowhere": "xyz"})
    with refused(fc.InputError, "support-components", "'xq'"):
        hold(space, {"top": "xq"})
    with refused(fc.InputError, "boundary-not-plane"):
        hold(space, {"top": "n"})
    middle = fc.Mesh(space.mesh.points, space.mesh.cells, node_sets={"middle": space.mesh.cells[0, 8:10]})
    with refused(fc.InputError, "input", "corner of a cell"):
        hold(AncfSpace(middle), {"middle": "xyz"})


def test_rollers_along_normals_and_directions():
    """A plane face held along its normal, its direction or its component is the same."""
    block = fc.shapes.block((2.0, 1.0, 1.0), (2, 2, 1), element="hex8")
    space = AncfSpace(block)
    for support in ("n", (0, 0, 2.0)):
        s = hold(space, {"bottom": support})
        projector = s.basis[:, s.held] @ s.basis[:, s.held].T
        s = hold(space, {"bottom": "z"})
        assert abs(projector - s.basis[:, s.held] @ s.basis[:, s.held].T).max() < 1e-15
    R = fc.rotation_about((1.0, 2.0, 3.0), 0.7)
    turned = AncfSpace(block.mapped(lambda x: x @ R.T))
    assert np.abs(hold(turned, {"bottom": "n"}).rows @ turned.affine(np.zeros((3, 3)), R[:, 0])).max() < 1e-14
    assert len(hold(turned, {"bottom": "n"}).held) == len(hold(space, {"bottom": "z"}).held)


def two_materials(n=4, release=True):
    """Bar of two materials along x, pulled: strains jump in the middle."""
    mesh = fc.shapes.block((4.0, 1.0, 1.0), (n, 2, 2), element="hex8")
    x = mesh.points[mesh.cells].mean(axis=1)[:, 0]
    groups = {"soft": np.flatnonzero(x < 2), "hard": np.flatnonzero(x > 2)}
    mesh = fc.Mesh(mesh.points, mesh.cells, mesh.boundaries, groups)
    space = AncfSpace(mesh, sides_by_label(mesh, (x > 2).astype(int)) if release else None)
    return space, AncfSolid(space, {"soft": fc.Material(1.0, 0.0), "hard": fc.Material(10.0, 0.0)})


def pulled(space, solid):
    Z = hold(space, {"x_min": "x", "y_min": "y", "bottom": "z"}).free
    load = traction(space, "x_max", (0.01, 0.0, 0.0))
    return space.q0 + Z @ scipy.sparse.linalg.spsolve((Z.T @ solid.stiffness @ Z).tocsc(), Z.T @ load)


def test_released_gradient_lets_strain_jump():
    """A bar of two materials in series is exact with the normal gradient released, and not without."""
    space, solid = two_materials()
    assert space.n_functions == 4 * len(space.nodes) + 9  # one more for each of the nine nodes of the interface
    q = pulled(space, solid)
    X = np.random.default_rng(1).uniform(0, 1, (len(space.corners), 3))
    strain = space.gradient_at(q, np.arange(len(space.corners)), X)[:, 0, 0] - 1
    exact = np.where(solid.lame * 0 + solid.shear > 1, 0.001, 0.01)
    assert np.abs(strain - exact).max() < 1e-12
    shared, same = two_materials(release=False)
    strain = shared.gradient_at(pulled(shared, same), np.arange(len(shared.corners)), X)[:, 0, 0] - 1
    assert np.abs(strain - exact).max() > 1e-3


def test_released_space_moves_rigidly():
    space, solid = two_materials()
    R = fc.rotation_about((1.0, -1.0, 0.5), 2.0)
    assert np.abs(solid.forces(space.affine(R, (1.0, 2.0, 3.0)))).max() < 1e-12
    K = solid.stiffness.toarray()
    values = np.linalg.eigvalsh(K)
    assert (values < 1e-12 * values[-1]).sum() == 6
    assert np.abs(K @ space.rigid_modes()).max() < 1e-12


def test_reentrant_points():
    """The inner edge of an angle is found and no outer one; a flat step of a few degrees is not sharp."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (2, 2, 1), element="hex8")
    centres = mesh.points[mesh.cells].mean(axis=1)
    kept = np.flatnonzero(~((centres[:, 0] > 1) & (centres[:, 1] > 1)))
    angle = fc.Mesh(mesh.points, mesh.cells, mesh.boundaries, {"angle": kept}).part("angle")
    found = angle.points[reentrant_points(angle)]
    assert sorted(found.tolist()) == [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]
    dent = mesh.mapped(lambda x: x - 0.2 * np.outer((np.abs(x[:, 0] - 1) < 1e-9) & (x[:, 2] > 0.9), [0, 0, 1]))
    assert reentrant_points(dent).size == 0
    assert reentrant_points(dent, degrees=10.0).size == 3


def test_every_cell_its_own_side():
    """At a node where all eight cells are sides of their own, what remains is what continuity leaves free."""
    mesh = fc.shapes.block((2.0, 2.0, 2.0), (2, 2, 2), element="hex8")
    middle = np.flatnonzero(np.abs(mesh.points - 1.0).max(axis=1) < 1e-12)
    space = AncfSpace(mesh, released_at(mesh, middle))
    # one derivative along each of the six half-axes that leave the node
    assert space.n_functions == 4 * 27 + 3
    # values on all common faces agree
    q = np.random.default_rng(2).uniform(-1, 1, space.n_dofs)
    s, t = np.random.default_rng(3).uniform(0, 1, (2, 6))
    cells = {tuple(np.round(c, 6)): k for k, c in enumerate(mesh.points[mesh.cells].mean(axis=1).tolist())}
    low, high = np.full(6, cells[0.5, 0.5, 0.5]), np.full(6, cells[1.5, 0.5, 0.5])
    one = space.points_at(q, low, np.stack([np.ones(6), s, t], 1))
    other = space.points_at(q, high, np.stack([np.zeros(6), s, t], 1))
    assert np.abs(one - other).max() < 1e-14 * 10
