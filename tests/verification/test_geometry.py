"""Geometry of contact faces: divisions of coarse meshes converge to the contact of the part, not of its facets."""

import meshio
import numpy as np
import pytest
from references import pin_in_hole

import fecontact as fc
from fecontact import extrude, merge
from fecontact.mesh.shapes import lattice

SOFT, STEEL = fc.Material(E=1.0, nu=0.3), fc.Material(E=210e3, nu=0.3)
RADIUS, CONTACT = 10.0, 0.5
LEVEL = fc.shapes.Level(core=2, rings=3, edge=0.08, layer=0.2)
QUARTER = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
#: Where divisions of the meshes as they are end: their errors do not fall.
MAX_DOFS = 30000


def pressure_error(contact, exact):
    """Relative L2 error of the pressure of a contact against that at points (n, 3)."""
    x, p, area = contact.sampled(contact.pressure, 8)
    target = exact(x)
    return np.sqrt((area * (p - target) ** 2).sum() / (area * target**2).sum())


def hertz(x):
    """Hertz's pressure at points (n, 3) of the plane."""
    peak = 2 * SOFT.plane_strain_modulus * CONTACT / (np.pi * RADIUS)
    return peak * np.sqrt(np.maximum(1 - (np.hypot(x[:, 0], x[:, 1]) / CONTACT) ** 2, 0))


def quarter_ball(mesh, geometry, accuracy):
    """A quarter of a ball on a rigid plane under the force of Hertz's contact."""
    ball, plane = fc.ElasticBody(mesh, SOFT, "cap", QUARTER, geometry=geometry), fc.RigidBody(fc.Plane())
    force = SOFT.plane_strain_modulus * CONTACT**3 / (3 * RADIUS)
    scene = fc.Scene([ball, plane], [fc.Contact(ball, plane)])
    return scene.solve(forces={plane: (0, 0, force)}, accuracy=accuracy, max_dofs=MAX_DOFS)


def hold(row, case, results, exact, within):
    """Rows of the errors on faces as they are, claiming nothing, and on smooth ones."""
    for geometry, result in results.items():
        error = pressure_error(result.contacts[0], exact)
        claimed = within if geometry == "auto" else None
        row(f"{case}, geometry {geometry!r}", "pressure L2", 0.0, error, claimed, result.n_dofs)


@pytest.mark.full
def test_a_ball_of_linear_cells_converges(row):
    """A ball of 8-node cells on a rigid plane, divided until 3 % are expected.

    Source: Hertz. On the chords that divisions leave, the contact is that of a polyhedron and its error does not fall;
    Hertz's own assumption of a half-space costs 0.3 % here.
    """
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=CONTACT, level=LEVEL, element="hex8")
    results = {g: quarter_ball(mesh, g, 0.03) for g in ("plain", "auto")}
    hold(row, "ball, hex8", results, hertz, 0.03)
    assert pressure_error(results["plain"].contacts[0], hertz) > 0.06


@pytest.fixture(scope="module")
def cad_ball(tmp_path_factory, gmsh):
    """STEP file of a quarter of half a ball that stands on its pole at the origin."""
    path = tmp_path_factory.mktemp("cad") / "ball.step"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    ball = gmsh.model.occ.addSphere(0, 0, RADIUS, RADIUS)
    box = gmsh.model.occ.addBox(0, 0, 0, RADIUS, RADIUS, RADIUS)
    gmsh.model.occ.intersect([(3, ball)], [(3, box)])
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    return path


@pytest.mark.full
@pytest.mark.parametrize("element", ["hex20", "tet10"])
def test_a_ball_from_a_cad_file(element, cad_ball, row):
    """A ball from a STEP file, cut by gmsh into faces of half the contact's radius, divided until 2 % are expected.

    Source: Hertz.
    """
    mesh = fc.mesh_solid(cad_ball, size=2.5, element=element, near=(0, 0, 0), near_size=CONTACT / 2, growth=0.45)
    for name, normal, at in (("sym_x", (1, 0, 0), 0), ("sym_y", (0, 1, 0), 0), ("base", (0, 0, 1), RADIUS)):
        mesh = mesh.with_boundary(name, fc.pick.plane(np.multiply(normal, at), normal))
    mesh = mesh.with_boundary("cap", lambda x: np.abs(np.linalg.norm(x - [0, 0, RADIUS], axis=1) - RADIUS) < 1e-2)
    results = {g: quarter_ball(mesh, g, 0.02) for g in ("plain", "auto")}
    hold(row, f"ball from STEP, {element}", results, hertz, 0.02)


def polygon(sides, radii, turn=0.0):
    """A prism with a hole, both of some straight sides, of length 1 along z."""
    mesh = lattice((len(radii) - 1, sides, 1), ("inner", "outer", None, None, "bottom", "top"), "hex8")

    def shape(index):
        angle, r = turn + 2 * np.pi * index[:, 1] / sides, np.interp(index[:, 0], np.arange(len(radii)), radii)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), index[:, 2]])

    return merge([mesh.mapped(shape)], 1e-9).upgraded(20)


@pytest.mark.full
def test_a_pin_of_12_sides_in_a_bore_of_17(row):
    """A conforming seat of two polygons that do not match, each of a single row of straight cells.

    Source: Michell's series for the round pin in its round hole, see test_hard_cases. As meshed nothing touches: the
    pin's sides lie up to 0.34 within its circle, and it moves by 0.03.
    """
    clearance, approach = 0.01, 0.03
    flat = {"bottom": "z", "top": "z"}
    pin = polygon(12, [4.0, 6.5, 8.5, RADIUS - clearance], turn=0.1)
    plate = polygon(17, [RADIUS, 12.0, 16.0, 30.0])
    pin = fc.ElasticBody(pin, STEEL, "outer", {**flat, "inner": "xyz"}, name="pin")
    plate = fc.ElasticBody(plate, STEEL, "inner", {**flat, "outer": "xyz"}, name="plate")
    scene = fc.Scene([pin, plate], [fc.Contact(pin, plate)])
    # the source's gaps are linear in the approach
    result = scene.solve(motions={pin: {"x": approach}}, finite_motion=False, accuracy=0.05)
    angle, pressure = pin_in_hole(RADIUS, clearance, approach, (4.0, STEEL), (30.0, STEEL), n=200)

    def exact(x):
        return np.interp(np.abs(np.arctan2(x[:, 1], x[:, 0])), angle, pressure, right=0.0)

    contact, n = result.contacts[0], result.n_dofs
    case = "pin of 12 sides in a bore of 17"
    row(case, "pressure L2", 0.0, pressure_error(contact, exact), 0.02, n)
    # the peak scatters with the divisions at the corners: 2.3 % here, .9 % at accuracy=0.02; estimated 4.8 and 1.2 %
    row(case, "peak pressure", pressure.max(), contact.max_pressure, 0.03, n)
    row(case, "force", 2 * RADIUS * np.trapezoid(pressure * np.cos(angle), angle), -contact.force[0], 0.01, n)


def triangulated_pole(radius, divisions, angle):
    """Points and triangles of a sphere within an angle of the pole -z: an icosahedron divided again and again."""
    golden = (1 + np.sqrt(5)) / 2
    x = np.array([[s, t * golden, 0] for s in (-1, 1) for t in (-1, 1)])
    x = np.concatenate([np.roll(x, k, axis=1) for k in range(3)])
    near = np.abs(np.linalg.norm(x[:, None] - x, axis=2) - 2) < 1e-9
    triples = np.array([(i, j, k) for i in range(12) for j in range(i) for k in range(j)])
    triangles = triples[near[triples, np.roll(triples, -1, axis=1)].all(axis=1)]
    flipped = np.einsum("ni,ni->n", np.cross(*np.moveaxis(np.diff(x[triangles], axis=1), 1, 0)), x[triangles[:, 0]]) < 0
    triangles[flipped] = triangles[flipped][:, ::-1]
    for _ in range(divisions):
        sides = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
        ends, middle = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        a, b, c = triangles.T
        ab, bc, ca = len(x) + middle.reshape(-1, 3).T
        x = np.concatenate([x, x[ends].mean(axis=1)])
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
        x /= np.linalg.norm(x, axis=1, keepdims=True)
    centre = x[triangles].mean(axis=1)
    return radius * x, triangles[centre[:, 2] < -np.cos(angle) * np.linalg.norm(centre, axis=1)]


@pytest.mark.full
def test_a_layer_on_an_stl_file(tmp_path, row):
    """A layer grown on the triangles of a sphere's STL file, bonded to it, against a rigid plane.

    Source: the same layer, round, by an axisymmetric section of 30 cells over the contact and 6 through the thickness.
    The surface fitted to the triangles is not quite round: 4 % of the pressure however fine the division, which the
    estimate, of the discretisation, does not know; so 5.6 % where 5 % is asked.
    """
    radius, thickness, approach = 20.0, 2.0, 0.12
    points, triangles = triangulated_pole(radius, 4, np.radians(24.0))
    meshio.Mesh(points, [("triangle", triangles)]).write(tmp_path / "pole.stl", binary=True)
    mesh = extrude(fc.read_surface(tmp_path / "pole.stl"), thickness, layers=2)
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, approach - radius - thickness))
    section = fc.sections.annulus(radius, radius + thickness, (450, 6))
    shell, over = fc.AxisymmetricBody(section, SOFT, "outer", {"inner": "xz"}), fc.rotation_about((1, 0, 0), np.pi)
    shell = shell.placed(rotation=over)
    reference = fc.Scene([shell, plane], [fc.Contact(shell, plane)]).solve().contacts[0]
    results = {}
    for geometry in ("plain", "auto"):
        layer = fc.ElasticBody(mesh, SOFT, "top", {"base": "xyz"}, geometry=geometry)
        scene = fc.Scene([layer, plane], [fc.Contact(layer, plane)])
        results[geometry] = scene.solve(accuracy=0.05, max_dofs=MAX_DOFS)
    order = np.argsort(reference.points[:, 0])

    def exact(x):
        at, pressure = reference.points[order, 0], reference.pressure[order]
        return np.interp(np.hypot(x[:, 0], x[:, 1]), at, pressure, right=0.0)

    hold(row, "layer on an STL file", results, exact, 0.06)
    force, (plain, smooth) = reference.force[2], (r.contacts[0].force[2] for r in results.values())
    row("layer on an STL file, geometry 'plain'", "force", force, plain)
    row("layer on an STL file, geometry 'auto'", "force", force, smooth, 0.01)
