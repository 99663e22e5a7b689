"""Hertz's contact on meshes divided where it touches: each division halves the error, with few more unknowns."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import Mesh
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.refine import refined, touching

RADIUS, SIZE, A = 10.0, 8.0, 0.5
SOFT = fc.Material(E=1.0, nu=0.3)
PLANE_STRAIN = SOFT.E / (1 - SOFT.nu**2)
HELD = {"x_min": "x", "y_min": "y"}
# a cube in six tetrahedra around its diagonal
KUHN = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]


def positions(first):
    """From 0 to SIZE, cells of size `first` up to beyond the contact, then growing."""
    x, step = [0.0], first
    while x[-1] < 0.8 * SIZE:
        x.append(x[-1] + step)
        step *= 1.9 if x[-1] >= 0.7 else 1.0
    return np.array(x) * (SIZE / x[-1]) if x[-1] > SIZE else np.array([*x, SIZE])


def quarter(kind, first):
    """A quarter of a block below z = 0, as coarse as two cells a contact radius."""
    x = positions(first)
    element = {"tet10": "hex8"}.get(kind, kind)
    mesh = fc.shapes.block((SIZE,) * 3, (x, x, SIZE - x[::-1]), element=element).translated((0, 0, -SIZE))
    if kind != "tet10":
        return mesh
    cells = np.concatenate([mesh.cells[:, list(corners)] for corners in KUHN])
    tetrahedra = Mesh(mesh.points, KINDS["tet4"].to_hexahedra(cells)).upgraded(20)
    for name, axis, value in (("bottom", 2, -SIZE), ("top", 2, 0.0), ("x_min", 0, 0.0), ("y_min", 1, 0.0)):
        tetrahedra = tetrahedra.with_boundary(name, lambda x, axis=axis, value=value: x[:, axis] == value)
    return tetrahedra


def upper(first):
    """The quarter above it, its lower side a paraboloid."""
    x = positions(first)
    block = fc.shapes.block((SIZE,) * 3, (x, x, x))
    rise = [0.0, 0.0, 1.0]
    return block.mapped(lambda p: p + np.outer((p[:, :2] ** 2).sum(axis=1) / 2 / RADIUS * (1 - p[:, 2] / SIZE), rise))


def divided(body, boundary):
    """The body's mesh, its cells divided that touch faces of the contact within Hertz's radius."""
    mesh = body.mesh
    faces = mesh.faces(boundary)
    corners = mesh.points[mesh.face_nodes(faces)[:, :4]]
    inside = np.linalg.norm(corners[..., :2], axis=2).min(axis=1) < A
    return refined(mesh, touching(mesh, faces[inside]))


def hertz(modulus):
    """Force on a quarter and peak pressure for the contact radius A (Johnson, Contact Mechanics, 1985, eq. 4.22-24)."""
    return modulus * A**3 / 3 / RADIUS, 2 * modulus * A / np.pi / RADIUS


def errors(contact, peak):
    """Relative L2 error of the pressure over 1.2 contact radii, and the error of its peak."""
    x, p, area = contact.sampled(contact.pressure, 8)
    r = np.linalg.norm(x[:, :2], axis=1)
    near = r < 1.2 * A
    true = peak * np.sqrt(np.maximum(0.0, 1 - (r / A) ** 2))
    norms = [np.sqrt(area[near] @ v[near] ** 2) for v in (p - true, true)]
    return norms[0] / norms[1], contact.max_pressure / peak - 1


def halved(case, found, within, row):
    """Rows of the errors, level by level; the last within what was measured, and how fast they fall."""
    for level, (field, peak, n_dofs) in enumerate(found):
        last = level == len(found) - 1
        row(f"{case}, divided {level} times", "pressure L2", 0.0, field, within[0] if last else None, n_dofs)
        row(
            f"{case}, divided {level} times", "peak pressure error", 0.0, abs(peak), within[1] if last else None, n_dofs
        )
    fields, dofs = np.array([f for f, _, _ in found]), [n for _, _, n in found]
    # first order, which square-root edges of the pressure allow in L2, would be 0.5
    row(case, "largest ratio of successive errors", 0.0, (fields[1:] / fields[:-1]).max(), 0.65)
    # uniform division would take 60 times as many
    row(case, "unknowns, divided twice over undivided", 0.0, dofs[-1] / dofs[0], 1.6)


@pytest.mark.by_day("hex8-within0", "hex20-within1")
@pytest.mark.parametrize(
    ("kind", "within"),
    [("hex8", (0.07, 0.03)), ("hex20", (0.027, 0.005)), ("hex27", (0.028, 0.005)), ("tet10", (0.037, 0.003))],
)
def test_a_rigid_ball_on_a_divided_block(kind, within, row):
    """A rigid ball on a coarse block divided twice where it touches.

    Source: Hertz. Tolerances are a tenth above what is found; the error halves while the unknowns grow by half.
    """
    force, peak = hertz(PLANE_STRAIN)
    mesh, found = quarter(kind, 0.29), []
    for _ in range(3):
        block = fc.ElasticBody(mesh, SOFT, "top", {**HELD, "bottom": "z"})
        ball = fc.RigidBody(fc.Sphere(RADIUS))
        result = fc.Scene([ball, block], [fc.Contact(block, ball)]).solve(forces={ball: (0, 0, -force)})
        found.append((*errors(result.contacts[0], peak), result.n_dofs))
        mesh = divided(block, "top")
    halved(f"rigid ball on {kind}", found, within, row)


@pytest.mark.full
@pytest.mark.parametrize(("kind", "within"), [("hex20", (0.047, 0.002)), ("tet10", (0.08, 0.002))])
def test_two_blocks_divided_where_they_touch(kind, within, row):
    """Two elastic blocks by mortar coupling, cells of different sizes and kinds, divided twice where they touch.

    Source: Hertz. Tolerances are a tenth above what is found.
    """
    force, peak = hertz(PLANE_STRAIN / 2)
    low, up, found = quarter(kind, 0.29), upper(0.33), []
    for _ in range(3):
        lower = fc.ElasticBody(low, SOFT, "top", {**HELD, "bottom": "z"}, name="lower")
        other = fc.ElasticBody(up, SOFT, "bottom", {**HELD, "top": "xy"}, name="upper")
        scene = fc.Scene([lower, other], [fc.Contact(lower, other, coupling="mortar")])
        result = scene.solve(forces={other: (0, 0, -force)})
        found.append((*errors(result.contacts[0], peak), result.n_dofs))
        low, up = divided(lower, "top"), divided(other, "bottom")
    halved(f"paraboloid of hex20 on {kind}, mortar", found, within, row)
