"""The brick's functions, forces and tangent against what they do not compute themselves."""

import itertools

import numpy as np
import pytest
import scipy.linalg
from differences import off_differences
from refusals import refused

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, gauss, shapes
from fecontact.mesh.element import CORNERS

LAWS = {
    "svk": fc.StVenantKirchhoff(1.0, 0.3),
    "neo-hookean": fc.NeoHookean(1.0, 0.3),
    "mooney": fc.MooneyRivlin(c10=0.15, c01=0.05, bulk=2.0),
    "ogden": fc.Ogden(mu=(0.3, 0.1), alpha=(2.0, -2.0), bulk=2.0),
    "holmes-mow": fc.HolmesMow(1.0, 0.2, beta=0.3),
    "fibres": fc.Fibres(fc.NeoHookean(1.0, 0.3), (1.0, 2.0, -1.0), ksi=0.2, alpha=1.0, beta=4.0),
}
#: Laws and rules that go together.
RULES = [(law, rule) for law in LAWS for rule in (None, 2, "linear") if rule is None or law != "holmes-mow"]


def distorted(n=(3, 2, 2), size=(3.0, 2.0, 2.0), element="hex8", amount=0.12, seed=1, curved=False):
    """Block with all its points moved about at random; with `curved` smoothly, so that 20-node edges bend."""
    mesh = fc.shapes.block(size, n, element="hex8" if not curved else "hex20")
    if curved:

        def bend(x):
            return x + 0.12 * np.stack([np.sin(x[:, 1] + x[:, 2]), np.sin(1.3 * x[:, 0]), np.cos(x[:, 0] - x[:, 1])], 1)

        return mesh.mapped(bend)
    rng = np.random.default_rng(seed)
    points = mesh.points + amount * rng.uniform(-1, 1, mesh.points.shape)
    return fc.Mesh(points, mesh.cells, mesh.boundaries)


def turned(angle, axis=(1.0, 2.0, -0.5)):
    w = np.asarray(axis) / np.linalg.norm(axis) * angle
    return scipy.linalg.expm(np.cross(np.eye(3), w).T)


@pytest.mark.parametrize("powers", list(itertools.product(range(4), repeat=3)))
def test_polynomials_held(powers):
    """All cubics, nine quartics and three quintics, and no other monomial of degree 3 per direction."""

    def monomial(x):
        return np.prod(x ** np.array(powers), axis=1)

    def slope(x, d):
        p = np.array(powers)
        if p[d] == 0:
            return np.zeros(len(x))
        p[d] -= 1
        return powers[d] * np.prod(x**p, axis=1)

    X = np.random.default_rng(0).uniform(0, 1, (20, 3))
    nodal = np.stack([monomial(CORNERS), *(slope(CORNERS, d) for d in range(3))], axis=1).ravel()
    N, dN = shapes(X)
    ordered = sorted(powers, reverse=True)
    held = sum(powers) <= 3 or ordered in ([3, 1, 0], [2, 1, 1], [3, 1, 1])
    # held ones to rounding; every other monomial is missed by more than a hundredth
    error = np.abs(N @ nodal - monomial(X)).max()
    assert (error < 1e-14) if held else (error > 1e-2)
    if held:
        assert np.abs(np.einsum("qaj,a->qj", dN, nodal) - np.stack([slope(X, d) for d in range(3)], 1)).max() < 1e-13


def test_functions_are_those_of_the_source():
    """Against the published formulas in coordinates -1 ... 1, for an element of edge lengths 2."""
    x = np.random.default_rng(1).uniform(-1, 1, (10, 3))
    N, _ = shapes((x + 1) / 2)
    for k, corner in enumerate(2 * CORNERS - 1):
        s = x * corner
        p = 1 + s
        value = p.prod(axis=1) * (2 + s.sum(axis=1) - (x**2).sum(axis=1)) / 16
        assert np.abs(N[:, 4 * k] - value).max() < 1e-15
        for d in range(3):
            slope = 2 / 32 * corner[d] * p[:, d] * p.prod(axis=1) * (s[:, d] - 1)
            # derivatives along axes of length 1 instead of 2
            assert np.abs(N[:, 4 * k + 1 + d] - slope / 2).max() < 1e-15


@pytest.mark.parametrize(("points", "modes"), [(2, 48), (3, 6), (4, 6), (5, 6)])
def test_zero_modes(points, modes):
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    K = AncfSolid(space, fc.Material(E=1.0, nu=0.3), points=points).stiffness.toarray()
    values = np.linalg.eigvalsh(K)
    assert (values < 1e-12 * values[-1]).sum() == modes


def test_four_points_are_exact_for_parallelepipeds():
    space = AncfSpace(fc.shapes.block((1.0, 2.0, 0.5), (1, 1, 1), element="hex8"))
    four, five = (AncfSolid(space, fc.Material(1.0, 0.3), points=p).stiffness for p in (4, 5))
    assert abs(four - five).max() < 1e-14 * abs(five).max()


def test_mass_of_the_unit_cube():
    """M[0, 0] = 394.784391534 for rho = 7850; total mass; no change with the position."""
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    solid = AncfSolid(space, fc.Material(1.0, 0.3, density=7850.0))
    assert abs(solid.mass[0, 0] - 394.784391534) < 1e-9
    t = space.affine(np.zeros((3, 3)), (1.0, 0.0, 0.0))
    assert abs(t @ solid.mass @ t / 7850 - 1) < 1e-14


def test_inertia_of_a_curved_body_is_that_of_its_shape():
    """q0^T M q0 = int rho X.X dV, integrated over the 20-node geometry."""
    from fecontact.fem.stiffness import volume_elements

    mesh = distorted(curved=True)
    space = AncfSpace(mesh)
    M = AncfSolid(space, fc.Material(1.0, 0.3, density=3.0)).mass
    exact = sum(float((3.0 * dV * (x**2).sum(axis=2)).sum()) for _, x, dV in volume_elements(mesh))
    # the 27 points of the other integral are not exact on curved cells
    assert abs(space.q0 @ M @ space.q0 / exact - 1) < 1e-5
    with refused(fc.InputError, "input", "density"):
        _ = AncfSolid(space, fc.Material(1.0, 0.3)).mass


@pytest.mark.parametrize("mesh", [distorted(), distorted(curved=True)], ids=["distorted", "curved"])
@pytest.mark.parametrize(("law", "volumetric"), RULES)
def test_rigid_motions_cost_nothing(mesh, law, volumetric):
    space = AncfSpace(mesh)
    solid = AncfSolid(space, LAWS[law], volumetric=volumetric)
    for angle in (0.0, 0.5, np.pi, 5.0):
        q = space.affine(turned(angle), (10.0, -3.0, 2.0))
        assert np.abs(solid.forces(q)).max() < 1e-10
        assert abs(solid.energy(q)) < 1e-10
    scale = abs(solid.stiffness).max()
    assert np.abs(solid.stiffness @ space.rigid_modes((0.3, 0.2, 0.1))).max() < 1e-12 * scale


@pytest.mark.parametrize("mesh", [distorted(amount=0.0), distorted(), distorted(curved=True)],
                         ids=["affine", "distorted", "curved"])  # fmt: skip
@pytest.mark.parametrize("law", LAWS)
def test_finite_patch(mesh, law):
    """A uniform large deformation: the law's stress everywhere, and forces inside the body in balance."""
    space = AncfSpace(mesh)
    solid = AncfSolid(space, LAWS[law], points=5)
    A = np.eye(3) + 0.3 * np.random.default_rng(3).uniform(-1, 1, (3, 3))
    q = space.affine(A, (1.0, 2.0, 3.0))
    X = np.array([[0.3, 0.8, 0.1]])
    for cell in range(len(mesh.cells)):
        assert np.abs(space.gradient_at(q, np.array([cell]), X) - A).max() < 1e-12
    P = np.linalg.det(A) * LAWS[law].cauchy(A) @ np.linalg.inv(A).T
    # virtual work of uniform stress: P : grad(du) V for any affine du
    B = np.random.default_rng(4).uniform(-1, 1, (3, 3))
    work = solid.forces(q) @ space.affine(B)
    assert abs(work - (P * B).sum() * space.volumes.sum()) < 1e-12 * np.abs(P).max() * space.volumes.sum()
    outer = np.unique(mesh.face_nodes(mesh.outer_faces)[:, :4])
    inner = np.setdiff1d(space.nodes, outer)
    mesh_inner = np.searchsorted(space.nodes, inner)
    forces = solid.forces(q).reshape(-1, 4, 3)
    # cof(J) S is of degree nine at most in each direction, which five points integrate exactly
    assert len(inner)
    assert np.abs(forces[mesh_inner]).max() < 1e-12 * np.abs(forces).max()


@pytest.mark.parametrize(("law", "volumetric"), RULES)
def test_forces_and_tangent_are_derivatives(law, volumetric):
    """Against central differences, whose error falls with the square of the step."""
    space = AncfSpace(distorted((2, 1, 1), (2.0, 1.0, 1.0)))
    solid = AncfSolid(space, LAWS[law], volumetric=volumetric)
    rng = np.random.default_rng(5)
    q = space.affine(turned(1.0) @ np.diag([1.1, 0.95, 1.05])) + 0.03 * rng.uniform(-1, 1, space.n_dofs)
    v = rng.uniform(-1, 1, space.n_dofs)
    K = solid.tangent(q)
    assert abs(K - K.T).max() < 1e-12 * abs(K).max()
    order = np.log2(np.divide(*(off_differences(solid, q, v, h) for h in (2e-3, 1e-3))))
    assert (np.abs(order - 2) < 0.1).all()
    # rounding of the difference is about 1e-16 / 1e-5
    assert off_differences(solid, q, v, 1e-5)[1] < 1e-8


@pytest.mark.parametrize(("law", "volumetric"), RULES)
def test_linear_stiffness_is_the_first_tangent(law, volumetric):
    space = AncfSpace(distorted(curved=True))
    solid = AncfSolid(space, LAWS[law], volumetric=volumetric)
    K = solid.tangent(space.q0)
    assert abs(K - solid.stiffness).max() < 1e-13 * abs(K).max()


def test_neighbours_conform():
    """Values on shared faces are the same from both cells, on a distorted mesh and for any coordinates."""
    for mesh in (distorted(), distorted(curved=True)):
        space = AncfSpace(mesh)
        q = np.random.default_rng(6).uniform(-1, 1, space.n_dofs)
        s, t = np.random.default_rng(7).uniform(0, 1, (2, 10))
        upper, lower = mesh.cells[:, [1, 2, 6, 5]], mesh.cells[:, [0, 3, 7, 4]]
        a, b = np.argwhere((upper[:, None] == lower[None]).all(axis=2))[0]
        left = space.points_at(q, np.full(10, a), np.stack([np.ones(10), s, t], 1))
        right = space.points_at(q, np.full(10, b), np.stack([np.zeros(10), s, t], 1))
        assert np.abs(left - right).max() < 1e-14 * 10


def test_geometry_is_that_of_the_mesh():
    from fecontact.mesh.element import hex_shapes

    for mesh, n in ((distorted(), 8), (distorted(curved=True), 20)):
        space = AncfSpace(mesh)
        X = np.random.default_rng(8).uniform(0, 1, (15, 3))
        for cell in (0, 5):
            exact = hex_shapes(n, X)[0] @ mesh.points[mesh.cells[cell]]
            assert np.abs(space.points_at(space.q0, np.full(15, cell), X) - exact).max() < 1e-14 * 10


def test_rules_refused():
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    with refused(fc.InputError, "gauss", "6"):
        AncfSolid(space, fc.Material(1.0, 0.3), points=6)
    with refused(fc.InputError, "volumetric"):
        AncfSolid(space, fc.Material(1.0, 0.3), volumetric=4)
    with refused(fc.InputError, "gauss", "7"):
        gauss(7)
