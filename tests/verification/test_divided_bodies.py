"""Bodies with hanging nodes: patch tests of displacements and of contact, nearly incompressible material."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from hanging_meshes import SPATIAL, boxed, joined, part, section_step, stairs, step
from refine_cases import CASES, locally_refined, mesh_of, refined_near

import fecontact as fc
from fecontact.fem.factor import factorise
from fecontact.fem.model import Model
from fecontact.fem.section_model import SectionModel
from fecontact.fem.stress import gauss_strain, hooke
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


@pytest.mark.by_day(every=3)
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


@pytest.mark.by_day(every=3)
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


@pytest.mark.by_day(every=3)
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
        u = body.displacement(none, np.zeros(0), body._boundary_traction("x_min", lambda x, n: -1.0 * n)).reshape(-1, 3)
        inner = mesh.boundary_nodes("x_min")
        r = np.linalg.norm(mesh.points[inner, :2], axis=1)
        exact = (1 + nu) * a**2 / (b**2 - a**2) * ((1 - 2 * nu) * r + b**2 / r)
        found = (u[inner, :2] * mesh.points[inner, :2]).sum(axis=1) / r
        errors[how] = np.abs(found / exact - 1).max()
        case = f"ring with hanging nodes, {kind}, nu {nu}"
        row(case, f"displacement inside, {how}", 0.0, errors[how], dofs=body.model.n_unknowns)
    row(case, "error, divided over fine", 0.0, errors["divided"] / errors["fine"], 2.4)
    row(case, "error, divided over coarse", 0.0, errors["divided"] / errors["coarse"], 0.5)


# contact: blocks 4 x 2 x 2


def turned_over(mesh):
    """The mesh of a block turned by half a turn about the x axis through its middle, so that its top is below."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    names = {"top": "bottom", "bottom": "top", "y_min": "y_max", "y_max": "y_min"}
    over = mesh.mapped(lambda x: np.stack([x[:, 0], *(low + high - x)[:, 1:].T], axis=1))
    return replace(over, boundaries={names.get(name, name): faces for name, faces in mesh.boundaries.items()})


def whole(kind, n):
    """A block of cells of one size."""
    return boxed(part(kind, (0, 0, 0), (4, 2, 2), n))


def stress_range(result, body):
    """Smallest and largest stress (2, 6) at the Gauss points of a body of an unmixed mesh."""
    model = body.model
    u = result._state.displacements[result.scene.bodies.index(body)]
    stress = hooke(gauss_strain(model.mesh, u.reshape(-1, 3))[0], model.lame[:, None], model.shear[:, None])
    return np.nanmin(stress, axis=(0, 1)), np.nanmax(stress, axis=(0, 1))


def worst(result, bodies):
    """Largest error of any stress but -1 along z."""
    exact = np.array([0.0, 0, -1, 0, 0, 0])
    return max(np.abs(np.array(stress_range(result, b)) - exact).max() for b in bodies)


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize("make", [step, stairs])
@pytest.mark.parametrize("kind", SPATIAL)
def test_a_divided_block_on_a_flat_is_exact(kind, make, row):
    """A block with hanging nodes on its contact face under uniform pressure on a rigid flat.

    Source: uniform stress, exact in any element.
    """
    for name, mesh in (("below", make(kind)), ("above", turned_over(make(kind)))):
        body = fc.ElasticBody(mesh, ELASTIC, contact="bottom", supports={"x_min": "x", "y_min": "y"})
        plane = fc.RigidBody(fc.Plane())
        result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(
            pressures={(body, "top"): 1.0}, finite_motion=False
        )
        contact, case = result.contacts[0], f"{make.__name__} of {kind} on a flat, its {name} side"
        assert contact.coupling == "nodal"
        # shown at all nodes of the faces, hanging ones too
        assert len(contact.nodes) > len(contact.points)
        error = max(np.abs(contact._at_nodes @ contact.pressure - 1).max(), worst(result, [body]))
        row(case, "largest pressure or stress error", 0.0, error, PATCH, result.n_dofs)
        assert abs(contact.area - np.prod(np.ptp(mesh.points[:, :2], axis=0))) < PATCH
        assert np.abs(contact.gap).max() < PATCH
        _, pressure, area = contact.sampled(contact.pressure)
        assert np.abs(pressure - 1).max() < PATCH
        assert abs(area.sum() - contact.area) < PATCH


PAIRS = {
    "divided on the same": (lambda k: turned_over(stairs(k)), stairs),
    "divided on otherwise divided": (stairs, stairs),
    "small on divided": (lambda k: whole(k, (8, 4, 2)), stairs),
    "divided on large": (lambda k: turned_over(stairs(k)), lambda k: whole(k, (2, 1, 1))),
    "divided on small": (stairs, lambda k: whole(k, (8, 4, 2))),
    "divided on others": (lambda k: turned_over(stairs(k)), lambda k: whole(k, (3, 2, 1))),
    "others on divided": (lambda k: whole(k, (3, 2, 1)), stairs),
}


@pytest.mark.by_day(every=9)
@pytest.mark.parametrize("coupling", ["auto", "mortar"])
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("kind", SPATIAL)
def test_uniform_pressure_passes_divided_faces(kind, pair, coupling, row):
    """Two blocks under uniform pressure, slave or master with hanging nodes where they meet, nodal forces or mortar.

    Source: uniform stress. The slave stays the slave, so that either side is divided; with 'auto' nodal forces are
    taken where faces match or nest.
    """
    upper, lower = (make(kind) for make in PAIRS[pair])
    held = {"x_min": "x", "y_min": "y"}
    low = fc.ElasticBody(lower, ELASTIC, "top", {**held, "bottom": "z"}, name="low")
    up = fc.ElasticBody(upper, ELASTIC, "bottom", held, name="up").placed((0, 0, 2))
    scene = fc.Scene([up, low], [fc.Contact(up, low, swap="never", coupling=coupling)])
    result = scene.solve(pressures={(up, "top"): 1.0}, finite_motion=False)
    contact = result.contacts[0]
    case = f"{pair}, {kind}, {contact.coupling}"
    error = max(np.abs(contact._at_nodes @ contact.pressure - 1).max(), worst(result, [up, low]))
    row(case, "largest pressure or stress error", 0.0, error, PATCH)
    assert abs(contact.area - 8) < PATCH
    assert result.residuals().equilibrium < 1e-12
    if coupling == "auto" and kind.startswith("hex"):
        nests = pair in ("divided on the same", "small on divided", "divided on large")
        assert (contact.coupling == "nodal") == nests


@pytest.mark.by_day(every=5)
@pytest.mark.parametrize("coupling", ["auto", "mortar"])
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("kind", ["hex20", "hex27"])
def test_bending_passes_divided_faces(kind, pair, coupling, row):
    """Bending through two blocks, slave or master with hanging nodes where they meet.

    Source: linear stress, which quadratic elements hold; errors are over the mean pressure.
    """
    upper, lower = (make(kind) for make in PAIRS[pair])
    low = fc.ElasticBody(lower, ELASTIC, "top", {"bottom": "z", "y_min": "y"}, name="low")
    up = fc.ElasticBody(upper, ELASTIC, "bottom", {"top": "z", "y_min": "y"}, name="up").placed((0, 0, 2))
    scene = fc.Scene([up, low], [fc.Contact(up, low, swap="never", coupling=coupling)])
    result = scene.solve(motions={up: {"z": -4e-2, "ry": 1.5e-2}}, finite_motion=False)
    contact = result.contacts[0]
    error = np.abs(contact._at_nodes @ contact.pressure - (4e-2 + 1.5e-2 * (contact.nodes[:, 0] - 2)) / 4).max()
    case = f"bending, {pair}, {kind}, {contact.coupling}"
    row(case, "largest pressure error / mean", 0.0, error / 1e-2, PATCH)
    row(case, "bending moment", 1.5e-2 / 4 * 2 * 4**3 / 12, abs(result.reaction(low)[4]), PATCH)


def test_a_divided_layer_gives_evenly(row):
    """An elastic layer on a surface with hanging nodes, as slave under a flat and as master of a block.

    Source: an even approach d gives the pressure E d / t everywhere.
    """
    law = {"thickness": 0.5, "law": "uniaxial"}
    for kind in ("hex8", "hex20", "tet10"):
        layer = fc.ElasticLayer(fc.Material(E=1.0, nu=0.0), surface=(stairs(kind), "top"), **law)
        plate = fc.RigidBody(fc.Plane()).placed((0, 0, 2), fc.rotation_about((1, 0, 0), np.pi))
        result = fc.Scene([layer, plate], [fc.Contact(layer, plate)]).solve(motions={plate: {"z": -1e-2}})
        error = np.abs(result.contacts[0].pressure / 2e-2 - 1).max()
        row(f"divided layer under a flat, {kind}", "largest pressure error", 0.0, error, PATCH)
        block = fc.ElasticBody(whole(kind, (3, 2, 1)), fc.Material(E=4.0, nu=0.0), "bottom", {"top": "xyz"})
        block = block.placed((0, 0, 2))
        result = fc.Scene([block, layer], [fc.Contact(block, layer, swap="never", coupling="mortar")]).solve(
            motions={block: {"z": -1e-2}}, finite_motion=False
        )
        # two springs in series, 0.5 / 1 and 2 / 4 per area
        error = np.abs(result.contacts[0].pressure / 1e-2 - 1).max()
        row(f"block on a divided layer, {kind}", "largest pressure error", 0.0, error, PATCH)


# meshes that the package divides itself: every kind of cell, and all of them side by side


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize(("kind", "width"), CASES)
def test_linear_displacements_pass_divided_cells_of_every_kind(kind, width, row):
    """Cells of three sizes of every kind, alone and side by side, curved, under linear displacements.

    Source: a linear field, exact in any isoparametric element whose hanging nodes lie where they follow.
    """
    mesh = locally_refined(kind, width)
    outside = on_box(mesh.points)
    mesh = mesh.mapped(bent)
    model = Model(mesh, ELASTIC, {})
    u = mesh.points @ GRADIENT.T
    error = np.abs(solved(model, u, outside, np.zeros(model.n_dofs)) - u).max()
    row(f"divided {kind} of {width} nodes", "largest displacement error", 0.0, error, PATCH)


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize(("kind", "width"), CASES)
def test_uniform_pressure_passes_divided_faces_of_every_kind(kind, width, row):
    """A body of every kind of cell, its contact face of three sizes, on a flat and on a block that does not match it.

    Source: uniform stress. The face is the side of layers of all kinds of cells, quadrilaterals beside triangles.
    """
    mesh = boxed(refined_near(mesh_of(kind, width), [3.0, 1.2, 1.4], [1.2, 0.7]))
    body = fc.ElasticBody(mesh, ELASTIC, "x_max", {"y_min": "y", "bottom": "z"}, name="body")
    plane = fc.RigidBody(fc.Plane()).placed((3.0, 0, 0), fc.rotation_about((0, 1, 0), -np.pi / 2))
    height = np.ptp(mesh.points[:, 2])
    other = boxed(part("hex20", (3, 0, 0), (5, 3, height), (1, 2, 2)))
    block = fc.ElasticBody(other, ELASTIC, "x_min", {"y_min": "y", "bottom": "z", "x_max": "x"}, name="block")
    for slave, master in ((body, plane), (body, block), (block, body)):
        coupling = "nodal" if master is plane else "mortar"
        scene = fc.Scene([slave, master], [fc.Contact(slave, master, swap="never", coupling=coupling)])
        result = scene.solve(pressures={(body, "x_min"): 1.0}, finite_motion=False)
        contact = result.contacts[0]
        error = np.abs(contact._at_nodes @ contact.pressure - 1).max()
        case = f"divided {kind} of {width} nodes, {slave.name} on {'a flat' if master is plane else master.name}"
        row(case, "largest pressure error", 0.0, error, PATCH)
        assert abs(contact.area - 3 * height) < PATCH
        assert len(body.surface("x_max").ties.nodes) > 0
