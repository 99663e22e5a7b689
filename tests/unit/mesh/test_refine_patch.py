"""Divided meshes in mechanics: rigid motions, linear and quadratic displacements across hanging nodes."""

import numpy as np
import pytest
import scipy.sparse as sp
from refine_cases import AFFINE, CASES, bent, locally_refined, mesh_of, refined_near

from fecontact.fem.rigid import rigid_modes
from fecontact.fem.stiffness import assemble_stiffness, body_force
from fecontact.mesh.check import check_mesh
from fecontact.mesh.refine import refined

pytestmark = pytest.mark.rounding(0)

LAME, SHEAR = 0.7, 0.4
# residuals relative to the largest entry of the stiffness: sums of some hundred products of size one, of fields of
# size ten; a wrong tie gives 1e-2
ROUNDING = 1e-13
LINEAR = np.array([[0.3, -0.2, 0.5], [0.1, 0.7, -0.4], [-0.6, 0.2, 0.9]])
QUADRATIC = np.random.default_rng(0).standard_normal((3, 3, 3))


def tied_stiffness(mesh):
    """K of all points and T of three displacements a point."""
    ones = np.ones(len(mesh.cells))
    upper = assemble_stiffness(mesh, LAME * ones, SHEAR * ones)
    return upper + sp.triu(upper, 1).T, sp.kron(mesh.hanging.transform, sp.eye(3)).tocsr()


def inner(mesh):
    """Degrees of freedom of free points inside the solid."""
    rows = np.flatnonzero(~np.isin(mesh.hanging.free, mesh.face_nodes(mesh.outer_faces)))
    assert len(rows) > 100
    return (3 * rows[:, None] + np.arange(3)).ravel()


@pytest.mark.by_day(
    "hexahedra-8-straight",
    "wedges-8-curved",
    "all kinds-20-straight",
    "pyramids-8-straight",
    "tetrahedra-8-curved",
    "hexahedra-27-straight",
    "hexahedra-20-curved",
)
@pytest.mark.parametrize("shape", ["straight", "curved"])
@pytest.mark.parametrize(("kind", "width"), CASES)
def test_linear_patch_and_rigid_motions(kind, width, shape):
    straight = mesh_of(kind, width)
    place = np.array([[1.2, 1.4, straight.points[:, 2].max() - 1.1]])

    def shaped(x):
        return bent(x @ AFFINE.T) if shape == "curved" else x @ AFFINE.T

    mesh = refined_near(straight.mapped(shaped), shaped(place)[0], [1.2, 0.7, 0.35])
    check_mesh(mesh)
    K, T = tied_stiffness(mesh)
    x, scale = mesh.points, abs(K).max()
    assert np.abs(T @ (x[mesh.hanging.free] @ LINEAR).ravel() - (x @ LINEAR).ravel()).max() < ROUNDING * 10
    residual = T.T @ (K @ (x @ LINEAR).ravel())
    assert np.abs(residual[inner(mesh)]).max() < ROUNDING * scale
    modes = rigid_modes(x, np.zeros(3)).reshape(-1, 3, 6)[mesh.hanging.free].reshape(-1, 6)
    assert np.abs(K @ (T @ modes)).max() < ROUNDING * scale


@pytest.mark.parametrize(("kind", "width"), [c for c in CASES if c[1] > 8])
def test_quadratic_patch_on_straight_cells(kind, width):
    # u_i = x Q_i x, with the body force -div sigma that belongs to it
    mesh = locally_refined(kind, width, 3).mapped(lambda x: x @ AFFINE.T)
    Q = (QUADRATIC + QUADRATIC.swapaxes(1, 2)) / 2
    u = np.einsum("nj,ijk,nk->ni", mesh.points, Q, mesh.points)
    force = -2 * (SHEAR * np.einsum("ijj->i", Q) + (LAME + SHEAR) * np.einsum("jji->i", Q))
    K, T = tied_stiffness(mesh)
    assert np.abs(T @ u[mesh.hanging.free].ravel() - u.ravel()).max() < ROUNDING * 100
    load = body_force(mesh, lambda x: np.tile(force, (len(x), 1)), np.ones(len(mesh.cells)))
    residual = T.T @ (K @ u.ravel() - np.ravel(load))
    assert np.abs(residual[inner(mesh)]).max() < ROUNDING * abs(K).max() * np.abs(u).max()


def test_untied_the_patch_fails():
    # the guard has two sides: hanging nodes left free open cracks
    mesh = locally_refined("hexahedra", 20)
    K, _ = tied_stiffness(mesh)
    rows = 3 * mesh.hanging.nodes
    assert np.abs((K @ (mesh.points @ LINEAR).ravel())[rows]).max() > 1e-3 * abs(K).max()


def test_strain_energy_of_a_divided_mesh_is_that_of_the_coarse_one_for_its_own_functions():
    # the coarse mesh's functions are among those of the divided one: the same field, the same energy
    coarse = mesh_of("hexahedra", 20)
    fine = refined(coarse, [13, 14, 22])
    ones = np.ones(len(coarse.cells))
    u = np.random.default_rng(1).standard_normal((len(coarse.points), 3))
    upper = assemble_stiffness(coarse, LAME * ones, SHEAR * ones)
    energy = u.ravel() @ ((upper + sp.triu(upper, 1).T) @ u.ravel())
    # points carry displacements as they carry positions
    wide = fine.points.copy()
    for axis in range(3):
        moved = coarse.mapped(lambda x, axis=axis: np.column_stack([x[:, :2], u[:, axis]]))
        wide[:, axis] = refined(moved, [13, 14, 22]).points[:, 2]
    K, _ = tied_stiffness(fine)
    assert abs(wide.ravel() @ (K @ wide.ravel()) / energy - 1) < 1e-12
