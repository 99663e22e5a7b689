"""Bodies of wedges and tetrahedra: patch tests, and Hertz contact of a ball meshed from its CAD geometry."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import Mesh
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.refine import divided

ELASTIC = fc.Material(E=1000.0, nu=0.3)
# condition numbers of some 1e3 in the condensed problem, times a few units of rounding
EXACT = 1e-10
SIX = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
TWO = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
# the same wedges lying, so that their quadrilaterals are in contact
LYING = [[0, 5, 1, 3, 6, 2], [0, 4, 5, 3, 7, 6]]


def block(kind, divisions=(2, 2, 3), amount=0.1):
    """Unit cube of one kind of cell, its inside curved and its outside plane."""
    base = fc.shapes.block((1.0, 1.0, 1.0), divisions, element="hex8")
    pieces, cell = {
        "tet10": (SIX, "tet4"),
        "hexahedra from tet10": (SIX, "tet4"),
        "wedge15": (TWO, "wedge6"),
        "wedge15 lying": (LYING, "wedge6"),
        "hex20 + wedge15": (TWO, "wedge6"),
    }[kind]
    cells = np.concatenate([KINDS[cell].to_hexahedra(base.cells[:, piece]) for piece in pieces])
    if kind == "hex20 + wedge15":
        left = base.points[base.cells].mean(axis=1)[:, 0] < 0.5
        cells = np.concatenate([base.cells[left], cells[np.tile(~left, 2)]])

    def bend(x):
        inside = 64 * np.prod(x * (1 - x), axis=1, keepdims=True)
        return x + amount * inside * np.stack([np.sin(3 * x[:, 1]), np.cos(2 * x[:, 0]), np.sin(4 * x[:, 0])], axis=1)

    mesh = Mesh(base.points, cells).upgraded(20).mapped(bend)
    mesh = divided(mesh) if kind == "hexahedra from tet10" else mesh
    for name, height in (("bottom", 0.0), ("top", 1.0)):
        mesh = mesh.with_boundary(name, fc.pick.plane((0, 0, height), (0, 0, 1)))
    return mesh


@pytest.mark.parametrize("kind", ["tet10", "wedge15", "wedge15 lying", "hex20 + wedge15", "hexahedra from tet10"])
def test_uniform_pressure_is_exact(kind, row):
    """Curved blocks of tetrahedra and wedges on a flat under uniform pressure.

    Source: uniform stress. Rounding times condition numbers of some 1e3.
    """
    body, plane = fc.ElasticBody(block(kind), ELASTIC, contact="bottom"), fc.RigidBody(fc.Plane())
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(pressures={(body, "top"): 1.0})
    contact = result.contacts[0]
    assert contact.active.all()
    worst = np.abs(contact.pressure - 1).max()
    row(f"7a curved block on a flat, {kind}", "largest pressure error", 0.0, worst, EXACT, result.n_dofs)
    stress = np.abs(result.stress(body) - [0, 0, -1, 0, 0, 0]).max()
    row(f"7a curved block on a flat, {kind}", "largest stress error", 0.0, stress, EXACT, result.n_dofs)
    points, pressure, areas = contact.sampled(contact.pressure)
    assert abs(areas.sum() - 1) < EXACT
    assert np.abs(pressure - 1).max() < EXACT
    assert np.abs(points[:, 2]).max() < EXACT


@pytest.mark.parametrize(("upper", "lower"), [("tet10", "tet10"), ("wedge15", "tet10"), ("wedge15 lying", "tet10")])
def test_uniform_pressure_through_two_bodies(upper, lower, row):
    """Two blocks of tetrahedra and wedges with matching triangles.

    Source: uniform stress. Wedges and tetrahedra have the same triangles on their ends; lying wedges have squares over
    two triangles each, and as the slave they take mortar coupling. Rounding times condition numbers of some 1e3.
    """
    top = fc.ElasticBody(block(upper).translated((0, 0, 1)), ELASTIC, contact="bottom", name="top")
    base = fc.ElasticBody(block(lower), ELASTIC, contact="top", supports={"bottom": "z"}, name="base")
    result = fc.Scene([top, base], [fc.Contact(top, base)]).solve(pressures={(top, "top"): 1.0})
    worst = max(np.abs(result.stress(b) - [0, 0, -1, 0, 0, 0]).max() for b in (top, base))
    row(f"7b {upper} on {lower}", "largest stress error", 0.0, worst, EXACT, result.n_dofs)


MIXED = [
    ("tet10", (2, 2, 2), "tet10", (3, 3, 2)),
    ("tet10", (2, 2, 2), "wedge15 lying", (3, 2, 2)),
    ("wedge15", (3, 3, 2), "wedge15 lying", (1, 2, 1)),
    ("hex20 + wedge15", (2, 2, 2), "tet10", (3, 3, 2)),
    ("tet10", (1, 1, 1), "tet10", (5, 5, 1)),
]


@pytest.mark.parametrize(("upper", "above", "lower", "below"), MIXED)
@pytest.mark.parametrize("swapped", [False, True])
def test_uniform_pressure_through_faces_that_do_not_match(upper, above, lower, below, swapped, row):
    """Two blocks of tetrahedra and wedges whose faces do not match.

    Source: uniform stress. Triangles on triangles and on quadrilaterals, coupled by mortar, either side as slave.
    Rounding times condition numbers of some 1e3.
    """
    top = fc.ElasticBody(block(upper, above).translated((0, 0, 1)), ELASTIC, contact="bottom", name="top")
    base = fc.ElasticBody(block(lower, below), ELASTIC, contact="top", supports={"bottom": "z"}, name="base")
    pair = (base, top) if swapped else (top, base)
    scene = fc.Scene([top, base], [fc.Contact(*pair, coupling="mortar")])
    result = scene.solve(pressures={(top, "top"): 1.0})
    assert result.contacts[0].coupling == "mortar"
    assert result.contacts[0].active.all()
    worst = max(np.abs(result.stress(b) - [0, 0, -1, 0, 0, 0]).max() for b in (top, base))
    slave = "lower" if swapped else "upper"
    row(f"7b {upper} on {lower}, mortar, {slave} slave", "largest stress error", 0.0, worst, EXACT, result.n_dofs)


@pytest.mark.parametrize("swapped", [False, True])
def test_bodies_with_plain_triangles_pass_too(swapped, row):
    """Two blocks of tetrahedra with plain triangles whose faces do not match.

    Source: uniform stress. Six-node triangles, and linear tetrahedra with three nodes. Rounding.
    """
    worst = 0.0
    for columns, pressure in ((20, "nodal"), (8, "midface")):
        bodies = []
        for n, name, shift, supports in ((2, "bottom", 1.0, {}), (3, "top", 0.0, {"bottom": "z"})):
            base = fc.shapes.block((1.0, 1.0, 1.0), (n, n, 2), element="hex8")
            cells = np.concatenate([KINDS["tet4"].to_hexahedra(base.cells[:, piece]) for piece in SIX])
            mesh = Mesh(base.points, cells) if columns == 8 else Mesh(base.points, cells).upgraded(20)
            for side, height in (("bottom", 0.0), ("top", 1.0)):
                mesh = mesh.with_boundary(side, fc.pick.plane((0, 0, height), (0, 0, 1)))
            mesh = mesh.translated((0, 0, shift))
            bodies.append(fc.ElasticBody(mesh, ELASTIC, name, supports, pressure=pressure, name=f"{name} {n}"))
        pair = bodies[::-1] if swapped else bodies
        result = fc.Scene(bodies, [fc.Contact(*pair)]).solve(pressures={(bodies[0], "top"): 1.0})
        assert result.contacts[0].coupling == "mortar"
        worst = max(worst, *(np.abs(result.stress(b) - [0, 0, -1, 0, 0, 0]).max() for b in bodies))
    row(
        f"7b plain triangles, {'lower' if swapped else 'upper'} slave", "stress error", 0.0, worst, EXACT, result.n_dofs
    )


@pytest.fixture(scope="module")
def ball(tmp_path_factory, gmsh):
    """File of the quarter of a half ball of radius 10 mm, its pole at the origin."""
    path = tmp_path_factory.mktemp("cad") / "ball.brep"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    sphere = gmsh.model.occ.addSphere(0, 0, 10, 10)
    box = gmsh.model.occ.addBox(0, 0, 0, 10, 10, 10)
    gmsh.model.occ.intersect([(3, sphere)], [(3, box)])
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    return path


def pressed_ball(path, element, near_size):
    mesh = fc.mesh_solid(path, size=3.0, element=element, near=(0, 0, 0), near_size=near_size, growth=0.35)
    mesh = mesh.with_boundary("cap", fc.pick.flood((0.5, 0.5, 0.0)) & fc.pick.box((0, 0, 0), (5, 5, 2)))
    for name, normal, point in (("x", (1, 0, 0), (0, 0, 0)), ("y", (0, 1, 0), (0, 0, 0)), ("z", (0, 0, 1), (0, 0, 10))):
        mesh = mesh.with_boundary(name, fc.pick.plane(point, normal))
    body = fc.ElasticBody(mesh, ELASTIC, contact="cap", supports={"x": "x", "y": "y", "z": "z"})
    plane = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={body: (0.0, 0.0, -FORCE / 4)})
    contact = result.contacts[0]
    r2 = (contact.points[:, :2] ** 2).sum(axis=1)
    radius = np.sqrt(2.5 * contact.forces @ r2 / contact.forces.sum())
    return result, radius, contact.pressure[np.argmin(r2)]


FORCE = 12.0


@pytest.mark.parametrize(("element", "near_size"), [("tet10", 0.1), ("hex20", 0.1)])
def test_hertz_on_a_ball_from_its_cad_file(element, near_size, ball, row):
    """A ball meshed from its CAD file on a rigid plane.

    Source: Hertz. Four irregular elements over the contact radius, no ring at its edge: both errors about 1 %,
    tolerances of two and three times that.
    """
    e_star = ELASTIC.E / (1 - ELASTIC.nu**2)
    a = (0.75 * FORCE * 10.0 / e_star) ** (1 / 3)
    p0 = 1.5 * FORCE / (np.pi * a**2)
    result, radius, centre = pressed_ball(ball, element, near_size)
    case = f"1 ball from CAD, {element}, {result.n_dofs} dofs"
    # four irregular elements over the contact radius, no ring at its edge: both errors about 1 %
    row(case, "contact radius", a, radius, 0.02, result.n_dofs)
    row(case, "centre pressure", p0, centre, 0.03, result.n_dofs)
    assert abs(result.contacts[0].force[2] / (FORCE / 4) - 1) < EXACT
    assert result.residuals().equilibrium < EXACT
