"""Patch tests: uniform and linear stress through elements and through contacts."""

import numpy as np
import pytest
from hanging_meshes import SPATIAL, boxed, part

import fecontact as fc
from fecontact import Mesh, merge
from fecontact.fem.stiffness import body_force
from fecontact.fem.stress import gauss_strain, hooke
from fecontact.mesh.element import CORNERS, EDGES

ELASTIC = fc.Material(E=1.0, nu=0.3)
# condition numbers of some 1e3 in the condensed problem, times a few units of rounding
EXACT = 1e-11
# sums of 27 points and 20 to 27 nodes, relative to the largest stiffness entry
ELEMENT = 1e-12


def floor():
    return fc.RigidBody(fc.Plane())


def stress_range(result, bodies, component=2):
    """Smallest and largest stress component over the Gauss points of bodies."""
    values = []
    for body in bodies:
        u = result._state.displacements[result.scene.bodies.index(body)].reshape(-1, 3)
        strain, _ = gauss_strain(body.mesh, u)
        values.append(hooke(strain, body.model.lame[:, None], body.model.shear[:, None])[..., component].ravel())
    return min(v.min() for v in values), max(v.max() for v in values)


# (a) a block pressed on a rigid flat


def pressed_block(element, pressure):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element=element)
    body, plane = fc.ElasticBody(mesh, ELASTIC, contact="bottom", pressure=pressure), floor()
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(pressures={(body, "top"): 1.0})
    return body, result


@pytest.mark.parametrize(("element", "pressure"), [("hex20", "midface"), ("hex8", "midface"), ("hex27", "midface")])
def test_uniform_pressure_is_exact(element, pressure, row):
    """A block on a frictionless flat under uniform pressure.

    Source: uniform stress, exact in any element. Rounding times condition numbers of some 1e3.
    """
    body, result = pressed_block(element, pressure)
    contact = result.contacts[0]
    worst = np.abs(contact.pressure - 1).max()
    row(f"7a block on a flat, {element} {pressure}", "largest pressure error", 0.0, worst, EXACT, result.n_dofs)
    assert contact.active.all()
    assert contact.gap.max() < EXACT
    low, high = stress_range(result, [body])
    assert abs(low + 1) < EXACT
    assert abs(high + 1) < EXACT


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize("kind", SPATIAL)
@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("integration", ["auto", "selective"])
def test_uniform_pressure_on_cells_of_every_kind_and_integration(kind, nu, integration, row):
    """A block of cells that are curved inside, pressed on a frictionless plane; the volume change at reduced points.

    Source: uniaxial stress, exact if a uniform pressure has its full nodal forces at reduced points too.
    """
    mesh = part(kind, (0, 0, 0), (1, 1, 1), (2, 2, 2))
    if kind not in ("hex8", "tet4", "wedge6"):  # whose curved faces are no faces of theirs
        bulge = np.array([0.05, -0.04, 0.06])
        mesh = mesh.mapped(lambda x: x + np.outer(np.prod(np.sin(np.pi * x), axis=1), bulge))
    held = {"x_min": "x", "y_min": "y", "top": "z"}
    body = fc.ElasticBody(boxed(mesh), fc.Material(1.0, nu), "bottom", held, integration=integration)
    plane = floor()
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(motions={plane: {"z": 0.01}})
    error = np.abs(result.contacts[0].pressure / 0.01 - 1).max()
    row(f"7a {kind}, nu = {nu}, {integration}", "largest pressure error", 0.0, error, EXACT)


def test_plain_hex20_releases_all_corners_and_lifts(row):
    """A block of plain 20-node elements on a flat loses its corners.

    Source: a serendipity face answers uniform pressure by corner forces of -1/12, which a contact cannot give; the lift
    of a tenth of the shortening is this mesh's own figure, kept to one percent.
    """
    body, result = pressed_block("hex20", "nodal")
    contact = result.contacts[0]
    corners = np.unique(body.mesh.cells[:, :8])
    released = corners[body.mesh.points[corners][:, 2] == 0]
    number = {tuple(x): k for k, x in enumerate(contact.points.tolist())}
    off = [number[tuple(x)] for x in body.mesh.points[released].tolist()]
    assert len(off) == 16
    assert set(np.flatnonzero(~contact.active)) == set(off)
    # the block shortens by 1 (E = p = L = 1)
    row("7a block on a flat, plain hex20", "lift / shortening", 0.0998, contact.gap.max(), 0.01, result.n_dofs)
    row("7a block on a flat, plain hex20", "corner nodes released of 16", 16, len(off), 1e-15, result.n_dofs)


# (b) two blocks, matching, nested and neither


def two_blocks(n_upper, n_lower, rotation=None):
    """Two cubes, one on the other, with n x n faces where they meet; the upper one is the slave."""
    lower = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (n_lower, n_lower, 2)),
        ELASTIC,
        contact="top",
        supports={"bottom": "z", "x_min": "x", "y_min": "y"},
    )
    upper = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (n_upper, n_upper, 2)),
        ELASTIC,
        contact="bottom",
        supports={"x_min": "x", "y_min": "y"},
    ).placed((0, 0, 1))
    if rotation is not None:
        lower, upper = lower.placed((3, -2, 5), rotation), upper.placed((3, -2, 5), rotation)
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower, swap="never", coupling="nodal")])
    result = scene.solve(pressures={(upper, "top"): 1.0}, finite_motion=False)  # strains of one: linear or senseless
    return result, stress_range(result, [upper, lower])


@pytest.mark.parametrize(("upper", "lower"), [(1, 1), (2, 2), (4, 2), (5, 1), (6, 3)])
@pytest.mark.parametrize("angle", [0, 30])
def test_matching_and_nested_faces_are_exact(upper, lower, angle, row):
    """Two blocks whose faces match or nest, upright and turned, under uniform pressure.

    Source: Taylor and Papadopoulos 1991. Rounding times condition numbers of some 1e3.
    """
    rotation = fc.rotation_about((1, 2, 0.5), np.radians(angle)) if angle else None
    result, stress = two_blocks(upper, lower, rotation)
    assert result.contacts[0].note.startswith("faces match or nest")
    case = f"7b two blocks {upper}:{lower}, turned by {angle} degrees"
    row(case, "largest stress error", 0.0, np.abs(np.array(stress) + 1).max(), EXACT, result.n_dofs)
    assert np.abs(result.contacts[0].pressure - 1).max() < EXACT


@pytest.mark.parametrize("upper", ["hex8", "hex20", "hex27"])
@pytest.mark.parametrize("lower", ["hex8", "hex20", "hex27"])
def test_faces_of_different_order_are_exact(upper, lower, row):
    """Two blocks of cells of other orders, face on face, under uniform pressure.

    Source: Taylor and Papadopoulos 1991. Rounding times condition numbers of some 1e3.
    """
    meshes = [fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1), element=e) for e in (lower, upper)]
    held = {"x_min": "x", "y_min": "y"}
    below = fc.ElasticBody(meshes[0], ELASTIC, "top", {**held, "bottom": "z"})
    above = fc.ElasticBody(meshes[1].translated((0.0, 0.0, 1.0)), ELASTIC, "bottom", held)
    result = fc.Scene([below, above], [fc.Contact(above, below)]).solve(pressures={(above, "top"): 1.0})
    worst = np.abs(np.array(stress_range(result, [above, below])) + 1).max()
    row(f"7b {upper} on {lower}", "largest stress error", 0.0, worst, EXACT, result.n_dofs)


@pytest.mark.parametrize(
    ("upper", "lower", "least", "most"),
    # nodal forces are Simpson's rule for the master's load; across the master's edges its kinks are missed. The
    # stresses at the Gauss points (exact: -1) lie within these bounds; 1:5 leaves whole master faces unloaded
    [(2, 3, -1.2, -0.8), (3, 2, -1.2, -0.8), (1, 5, -8.0, 1.0)],
)
def test_faces_that_do_not_nest_err_and_say_so(upper, lower, least, most, row):
    """Two blocks whose faces do not nest, coupled by nodal forces: what it costs.

    Source: uniform stress -1. Nodal forces are Simpson's rule for the master's load; across the master's edges its
    kinks are missed. The stresses at the Gauss points lie within stated bounds, equilibrium holds to rounding.
    """
    result, (low, high) = two_blocks(upper, lower)
    assert "do not match" in result.contacts[0].note
    row(f"7b two blocks {upper}:{lower}, nodal forces", "lowest stress", -1.0, low)
    row(f"7b two blocks {upper}:{lower}, nodal forces", "highest stress", -1.0, high)
    assert least < low < -1.01
    assert -0.99 < high < most
    # equilibrium holds all the same
    assert abs(result.contacts[0].force[2] - 1) < EXACT


# (c) linear pressure


@pytest.mark.parametrize("element", ["hex20", "hex27"])
@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_bending_pressure_on_a_flat_is_exact(element, nu, row):
    """Linear pressure of a bent block on a flat.

    Source: u_z = -p(x) z/E with p = p0 + p1 (x - 1/2), u_x and u_y quadratic: bending, held in the elements' space.
    Rounding times condition numbers of some 1e3.
    """
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 2, 2), element=element)
    body = fc.ElasticBody(mesh, fc.Material(1.0, nu), contact="bottom", supports={"top": "z", "y_min": "y"})
    plane = floor()
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    result = scene.solve(motions={body: {"z": -1e-2, "ry": 1.5e-2}}, finite_motion=False)
    contact = result.contacts[0]
    expected = 1e-2 + 1.5e-2 * (contact.points[:, 0] - 0.5)
    worst = np.abs(contact.pressure - expected).max() / 1e-2
    row(f"7c bending on a flat, {element}, nu = {nu}", "largest pressure error", 0.0, worst, EXACT, result.n_dofs)


@pytest.mark.parametrize(("upper", "lower"), [(2, 2), (4, 2), (3, 1)])
def test_bending_through_two_blocks_is_exact(upper, lower, row):
    """Linear pressure through two blocks whose faces match or nest.

    Source: the same bending field. Rounding times condition numbers of some 1e3.
    """
    low = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (lower, lower, 1)),
        ELASTIC,
        contact="top",
        supports={"bottom": "z", "y_min": "y"},
    )
    up = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (upper, upper, 1)),
        ELASTIC,
        contact="bottom",
        supports={"top": "z", "y_min": "y"},
    ).placed((0, 0, 1))
    scene = fc.Scene([up, low], [fc.Contact(up, low)])
    contact = scene.solve(motions={up: {"z": -2e-2, "ry": 3e-2}}, finite_motion=False).contacts[0]
    expected = 1e-2 + 1.5e-2 * (contact.points[:, 0] - 0.5)
    worst = np.abs(contact.pressure - expected).max() / 1e-2
    row(f"7c bending through two blocks {upper}:{lower}", "largest pressure error", 0.0, worst, EXACT)


# (d) elements


def from_corners(cells):
    """20-node mesh with straight edges from the corner positions (n, 8, 3) of its cells, repeated where coalesced."""
    cells = np.asarray(cells, dtype=float)
    all_nodes = np.concatenate([cells, cells[:, EDGES].mean(axis=2)], axis=1)
    points, number = np.unique(all_nodes.reshape(-1, 3).round(12), axis=0, return_inverse=True)
    return Mesh(points, number.reshape(len(cells), 20))


def star(kind):
    """A cube cut into pyramids, tetrahedra or wedges round an inner point or line off its centre."""
    apex = np.array([0.45, 0.55, 0.4])
    quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [3, 7, 6, 2], [0, 4, 7, 3], [1, 2, 6, 5]]
    bases = [CORNERS[q][::-1] for q in quads]
    if kind == "pyramid":
        return from_corners([[*b, apex, apex, apex, apex] for b in bases])
    if kind == "tetrahedron":
        halves = [(b[0], b[1], b[2]) for b in bases] + [(b[0], b[2], b[3]) for b in bases]
        return from_corners([[a, b, c, c, apex, apex, apex, apex] for a, b, c in halves])
    low, high = np.array([0.45, 0.55, 0.0]), np.array([0.45, 0.55, 1.0])
    ring = [(CORNERS[k], CORNERS[(k + 1) % 4]) for k in range(4)]
    up = np.array([0.0, 0.0, 1.0])
    return from_corners([[a, b, low, low, a + up, b + up, high, high] for a, b in ring])


def patches(curved):
    for element in ("hex8", "hex20", "hex27"):
        yield f"{element} curved", curved(element, (3, 3, 3), amount=0.05)
    yield "hex20 curved, mid-face nodes", curved("hex20", (3, 3, 3), amount=0.05).with_midface_nodes(("top", "x_min"))
    for kind in ("wedge", "pyramid", "tetrahedron"):
        yield f"{kind}s", star(kind)


def rim(mesh):
    """Dofs of all nodes on the outer faces."""
    nodes = np.unique(mesh.face_nodes(mesh.outer_faces))
    if mesh.midface is not None:
        nodes = np.union1d(nodes, mesh.midface[mesh.midface >= 0])
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def test_linear_displacements_are_reproduced(curved, linear_solve, row):
    """Patches of distorted, curved and degenerate elements under linear displacements.

    Source: a linear field, exact in any isoparametric element. Rounding of sums of 27 points and nodes.
    """
    gradient = np.array([[0.1, -0.2, 0.3], [0.05, 0.4, -0.1], [0.2, 0.1, -0.3]])
    for name, mesh in patches(curved):
        u = mesh.points @ gradient.T
        fixed = rim(mesh)
        found = linear_solve(mesh, ELASTIC, fixed, values=u.ravel()[fixed])
        error = np.abs(found - u).max()
        row(f"7d patch of {name}", "largest displacement error", 0.0, error, ELEMENT)


@pytest.mark.parametrize("kind", ["hex20", "hex27", "wedge", "pyramid", "tetrahedron"])
def test_quadratic_displacements_are_reproduced_by_affine_elements(kind, linear_solve, row):
    """Second-order patch test of affine elements.

    Source: a random quadratic field with the body force -(lambda + mu) grad div u - mu laplace u that it needs.
    Rounding of sums of 27 points and nodes.
    """
    shear = np.array([[1.0, 0.3, 0.1], [0.0, 0.9, -0.2], [0.2, 0.0, 1.1]])
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element=kind) if kind.startswith("hex") else star(kind)
    mesh = mesh.mapped(lambda x: x @ shear.T)
    A = np.random.default_rng(1).normal(size=(3, 3, 3))
    A = (A + A.transpose(0, 2, 1)) / 2

    def field(x):
        return np.einsum("ijk,nj,nk->ni", A, x, x)

    # -div(sigma) = -(lambda + mu) grad div u - mu laplace u, constant
    lame, mu = ELASTIC.lame, ELASTIC.shear_modulus
    force = -2 * ((lame + mu) * np.einsum("jji->i", A) + mu * np.einsum("ijj->i", A))
    f = body_force(mesh, lambda x: np.broadcast_to(force, x.shape))
    u, fixed = field(mesh.points), rim(mesh)
    found = linear_solve(mesh, ELASTIC, fixed, f, values=u.ravel()[fixed])
    error = np.abs(found - u).max() / np.abs(u).max()
    row(f"7d second-order patch of {kind}", "largest displacement error", 0.0, error, ELEMENT)


def test_hexahedra_wedges_and_their_neighbours_conform(linear_solve, row):
    """A hexahedron and a wedge that share a face, under linear displacements.

    Source: a linear field; nodes of the shared face are free and have to find their place. Rounding.
    """
    gradient = np.array([[0.1, -0.2, 0.3], [0.05, 0.4, -0.1], [0.2, 0.1, -0.3]])
    hexa = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    prism = from_corners(
        [[(1, 0, 0), (2, 0.5, 0), (2, 0.5, 0), (1, 1, 0), (1, 0, 1), (2, 0.5, 1), (2, 0.5, 1), (1, 1, 1)]]
    )
    mesh = merge([hexa, prism], 1e-9)
    assert len(mesh.points) == 20 + 15 - 8
    u = mesh.points @ gradient.T
    # the face between them is free: its eight nodes have to find their place
    free = np.flatnonzero(np.abs(mesh.points[:, 0] - 1) < 1e-12)
    fixed = np.setdiff1d(np.arange(len(mesh.points)), free)
    fixed = (3 * fixed[:, None] + np.arange(3)).ravel()
    # reactions of the free nodes on the outer faces: the traction of the constant stress
    stress = ELASTIC.lame * np.trace(gradient) * np.eye(3) + ELASTIC.shear_modulus * (gradient + gradient.T)
    from fecontact.fem.stiffness import surface_traction

    f = surface_traction(mesh, mesh.outer_faces, lambda x, n: n @ stress)
    found = linear_solve(mesh, ELASTIC, fixed, f, values=u.ravel()[fixed])
    row("7d hexahedron beside a wedge", "largest displacement error", 0.0, np.abs(found - u).max(), ELEMENT)
