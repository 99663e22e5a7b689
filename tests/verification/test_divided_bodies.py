"""Bodies with hanging nodes: patch tests, rigid motions, nearly incompressible material."""

import numpy as np
import pytest
import scipy.sparse as sp
from hanging_meshes import SPATIAL, boxed, joined, part, section_step, stairs, step

import fecontact as fc
from fecontact.fem.factor import factorise
from fecontact.fem.model import Model
from fecontact.fem.section_model import SectionModel
from fecontact.mesh.section_mesh import Extent

ELASTIC = fc.Material(E=1.0, nu=0.3)
# the issue's own: patches are exact to the rounding of sums and solutions
PATCH = 1e-10
QUADRATIC = ("hex20", "hex27", "tet10", "wedge15")
SHEAR = np.array([[1.0, 0.3, 0.1], [0.0, 0.9, -0.2], [0.2, 0.0, 1.1]])
GRADIENT = np.array([[0.1, -0.2, 0.3], [0.05, 0.4, -0.1], [0.2, 0.1, -0.3]])


def solved(model, wanted, outside, forces):
    """Displacements (n_points, 3) where those of the free nodes `outside` are as wanted, under nodal forces."""
    c = model.coordinates
    K = c.stiffness(model.stiffness)
    whole = sp.csr_matrix(K + sp.triu(K, 1).T)
    given = np.repeat(c.of_functions(outside), 3)
    given[model.held] = True
    v = c.of_displacements(wanted.ravel())
    rest = np.flatnonzero(~given)
    f = c.forces(forces) - whole[:, given] @ v[given]
    v[rest] = factorise(sp.csr_matrix(sp.triu(whole[rest][:, rest]))).solve(f[rest][None])[0]
    return c.displacements(v).reshape(-1, 3)


def on_box(points):
    """Points on the box's sides, before anything is mapped."""
    return (np.isclose(points, points.min(axis=0)) | np.isclose(points, points.max(axis=0))).any(axis=1)


def bent(x):
    return x + 0.05 * np.stack([np.sin(2 * x[:, 1] + x[:, 2]), np.cos(x[:, 0] - x[:, 2]), np.sin(x[:, 0] + x[:, 1])], 1)


@pytest.mark.parametrize("make", [step, stairs])
@pytest.mark.parametrize("kind", SPATIAL)
def test_linear_displacements_pass_hanging_nodes(kind, make, row):
    """Patches of curved cells of two and of three sizes under linear displacements.

    Source: a linear field, exact in any isoparametric element whose hanging nodes lie where they follow.
    """
    mesh = make(kind)
    outside = on_box(mesh.points)
    mesh = mesh.mapped(bent)
    model = Model(mesh, ELASTIC, {})
    u = mesh.points @ GRADIENT.T
    error = np.abs(solved(model, u, outside, np.zeros(model.n_dofs)) - u).max()
    row(f"patch with hanging nodes, {make.__name__} of {kind}", "largest displacement error", 0.0, error, PATCH)
    strain = model.nodal_strain(u.ravel())
    expected = (GRADIENT + GRADIENT.T)[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]] / 2
    row(f"patch with hanging nodes, {make.__name__} of {kind}", "largest strain error", 0.0,
        np.abs(strain - expected).max(), PATCH)  # fmt: skip


@pytest.mark.parametrize("midface", [False, True])
@pytest.mark.parametrize("kind", QUADRATIC)
def test_quadratic_displacements_pass_hanging_nodes(kind, midface, row):
    """Patches of affine cells of three sizes under quadratic displacements, with and without mid-face nodes.

    Source: a random quadratic field with the body force -(lambda + mu) grad div u - mu laplace u that it needs.
    """
    if midface and kind == "hex27":
        pytest.skip("27-node cells have mid-face nodes anyway")
    mesh = stairs(kind)
    if midface:
        mesh = mesh.with_midface_nodes(("top", "x_min"))
    outside = on_box(mesh.points)
    mesh = mesh.mapped(lambda x: x @ SHEAR.T)
    A = np.random.default_rng(1).normal(size=(3, 3, 3))
    A = (A + A.transpose(0, 2, 1)) / 2
    model = Model(mesh, ELASTIC, {})
    lame, mu = ELASTIC.lame, ELASTIC.shear_modulus
    force = -2 * ((lame + mu) * np.einsum("jji->i", A) + mu * np.einsum("ijj->i", A))
    u = np.einsum("ijk,nj,nk->ni", A, mesh.points, mesh.points)
    found = solved(model, u, outside, model.body_force(lambda x: np.broadcast_to(force, x.shape)))
    error = np.abs(found - u).max() / np.abs(u).max()
    also = ", mid-face nodes" if midface else ""
    row(f"second-order patch with hanging nodes, {kind}{also}", "largest displacement error", 0.0, error, PATCH)


def test_cells_of_two_kinds_pass_hanging_nodes(row):
    """Small wedges beside large hexahedra under linear displacements. Source: a linear field."""
    for kinds in (("hex20", "wedge15"), ("hex8", "wedge6"), ("hex20", "hex20", "wedge15")):
        parts = [
            part(kinds[0], (0, 0, 0), (1, 2, 1), (1, 2, 1)),
            part(kinds[-1], (1, 0, 0), (2, 2, 1), (2, 4, 2)),
            part(kinds[len(kinds) // 2], (2, 0, 0), (3, 2, 1), (2, 4, 2)),
        ]
        mesh = joined(*parts)
        outside = on_box(mesh.points)
        mesh = mesh.mapped(bent)
        u = mesh.points @ GRADIENT.T
        model = Model(mesh, ELASTIC, {})
        error = np.abs(solved(model, u, outside, np.zeros(model.n_dofs)) - u).max()
        row(f"patch with hanging nodes, {' beside '.join(kinds)}", "largest displacement error", 0.0, error, PATCH)


@pytest.mark.parametrize("extent", [Extent(0.7), Extent(None)], ids=["plane", "revolved"])
@pytest.mark.parametrize("kind", ["quad8", "quad9"])
def test_displacements_pass_hanging_nodes_of_sections(kind, extent, row):
    """Sections of two sizes of quadrilaterals under a field that the elements hold.

    Source: in a plane a quadratic field with its body force; round an axis u = (c r, d z), uniformly strained.
    """
    mesh = section_step(kind)
    outside = on_box(mesh.points[:, [0, 2]])
    model = SectionModel(mesh, ELASTIC, {}, extent, False, "auto", "full")
    x, z = mesh.points[:, 0], mesh.points[:, 2]
    lame, mu = ELASTIC.lame, ELASTIC.shear_modulus
    if extent.revolved:
        u, force = np.stack([0.3 * x, 0 * x, -0.2 * z], axis=1), np.zeros(3)
    else:
        u = np.stack([x**2 - x * z, 0 * x, 0.5 * z**2 + 2 * x * z], axis=1)
        # div u = 2 x - z + z + 2 x = 4 x; laplace u = (2, 1)
        force = -np.array([(lame + mu) * 4 + mu * 2, 0.0, mu * 1])
    f = model.body_force(lambda p: np.broadcast_to(force, p.shape))
    error = np.abs(solved(model, u, outside, f) - u).max()
    case = f"patch with hanging nodes, {kind}, {'revolved' if extent.revolved else 'plane'}"
    row(case, "largest displacement error", 0.0, error, PATCH)


def ring(kind, how):
    """A quarter of a ring of radii 1 and 2, cells of one size or those inside half as large as those outside."""

    def polar(x):
        r, angle = 1 + x[:, 0], x[:, 1] * np.pi / 4
        return np.stack([r * np.cos(angle), r * np.sin(angle), x[:, 2]], axis=1)

    if how == "divided":
        parts = part(kind, (0.5, 0, 0), (1, 2, 0.5), (1, 4, 1)), part(kind, (0, 0, 0), (0.5, 2, 0.5), (2, 8, 2))
        return joined(*parts).mapped(polar)
    k = {"coarse": 1, "fine": 2}[how]
    return boxed(part(kind, (0, 0, 0), (1, 2, 0.5), (2 * k, 4 * k, k))).mapped(polar)


@pytest.mark.parametrize("nu", [0.3, 0.4999])
@pytest.mark.parametrize("kind", ["hex8", "hex20", "hex27", "tet10", "wedge15"])
def test_a_ring_divided_where_it_is_strained_most(kind, nu, row):
    """A ring under internal pressure, plane strain, divided in its inner half, nearly incompressible too.

    Source: Lame. Asserted: inside, the divided ring is nearly as good as one of small cells throughout (half as much
    again as measured, which was 1.7 of its error at most), and far better than one of large cells.
    """
    a, b, errors = 1.0, 2.0, {}
    for how in ("coarse", "divided", "fine"):
        mesh = ring(kind, how)
        planes = {"y_min": "y", "y_max": "x", "bottom": "z", "top": "z"}
        body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=nu), supports=planes)
        none = sp.csr_matrix((0, body.n_dofs))
        u = body.displacement(none, np.zeros(0), body.boundary_pressure("x_min", 1.0)).reshape(-1, 3)
        inner = mesh.boundary_nodes("x_min")
        r = np.linalg.norm(mesh.points[inner, :2], axis=1)
        exact = (1 + nu) * a**2 / (b**2 - a**2) * ((1 - 2 * nu) * r + b**2 / r)
        found = (u[inner, :2] * mesh.points[inner, :2]).sum(axis=1) / r
        errors[how] = np.abs(found / exact - 1).max()
        case = f"ring with hanging nodes, {kind}, nu {nu}"
        row(case, f"displacement inside, {how}", 0.0, errors[how], dofs=body.model.n_unknowns)
    row(case, "error, divided over fine", 0.0, errors["divided"] / errors["fine"], 2.4)
    row(case, "error, divided over coarse", 0.0, errors["divided"] / errors["coarse"], 0.5)
