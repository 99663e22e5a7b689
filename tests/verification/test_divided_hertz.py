"""Contact of bodies divided below it: the answer of small cells throughout, at a fraction of their unknowns."""

import numpy as np
import pytest
from hanging_meshes import boxed, joined, part
from scipy.spatial import cKDTree

import fecontact as fc
from fecontact import merge
from fecontact.contact.coupling import mortar

RADIUS, CONTACT, SMALL = 10.0, 0.45, 0.125


def cells(kind, low, high, h):
    return part(kind, low, high, tuple(round((b - a) / h) for a, b in zip(low, high, strict=True)))


def divided(kind, reach, side=1.0):
    """A quarter of a block, cells half as large within `reach` of the middle of its top, at the origin."""
    large = [
        cells(kind, (reach, 0, -side), (side, side, 0), 2 * SMALL),
        cells(kind, (0, reach, -side), (reach, side, 0), 2 * SMALL),
        cells(kind, (0, 0, -side), (reach, reach, -reach), 2 * SMALL),
    ]
    return joined(merge(large, 1e-9), cells(kind, (0, 0, -reach), (reach, reach, 0), SMALL))


def uniform(kind, h=SMALL, side=1.0):
    return boxed(cells(kind, (0, 0, -side), (side, side, 0), h))


def pressed(mesh, nu):
    """The quarter block under a rigid ball."""
    solid = fc.Material(E=1.0, nu=nu)
    body = fc.ElasticBody(mesh, solid, "top", {"x_min": "x", "y_min": "y", "bottom": "z"})
    ball = fc.RigidBody(fc.Sphere(RADIUS))
    force = solid.plane_strain_modulus * CONTACT**3 / (3 * RADIUS)
    return fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(forces={ball: (0, 0, -force)}), ball


@pytest.mark.by_day("hex8-0.3", "hex20-0.4999")
@pytest.mark.parametrize("nu", [0.3, 0.4999])
@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10"])
def test_a_block_divided_below_a_ball(kind, nu, row):
    """A block divided below a rigid ball, nearly incompressible too, against small cells throughout.

    Source: the uniform mesh of the same faces. What large cells away from the contact leave is far below what the
    faces themselves do: the pressure differs by less than a fifth of what it does from that of large faces.
    """
    found = {}
    meshes = divided(kind, 0.75, 1.25), uniform(kind, SMALL, 1.25), uniform(kind, 2 * SMALL, 1.25)
    for name, mesh in zip(("divided", "small", "large"), meshes, strict=True):
        result, ball = pressed(mesh, nu)
        contact, approach = result.contacts[0], result.rigid_motion(ball).translation[2]
        found[name] = (contact.nodes, contact._at_nodes @ contact.pressure, approach, result.n_dofs)
        assert result.residuals().penetration < 1e-10
    points, small, approach, n = found["small"]

    def difference(name):
        distance, same = cKDTree(points).query(found[name][0])
        there = distance < 1e-9
        p, q = found[name][1][there], small[same[there]]
        return float(np.linalg.norm(p - q) / np.linalg.norm(q))

    case, one, other = f"block divided below a ball, {kind}, nu {nu}", difference("divided"), difference("large")
    row(case, "pressure, difference from small cells", 0.0, one, dofs=found["divided"][3])
    row(case, "pressure, large cells", 0.0, other, dofs=found["large"][3])
    row(case, "difference over that of large cells", 0.0, one / other, 0.2)
    row(case, "approach", approach, found["divided"][2], 0.01, n)
    assert found["divided"][3] < 0.5 * n


def two(upper, lower, coupling="mortar"):
    """Two quarter blocks with paraboloid tops; exact peak pressure, the contact and the L2 error of its pressure."""
    solid = fc.Material(E=1.0, nu=0.3)
    modulus = solid.plane_strain_modulus / 2

    def shape(x):
        height = (x[:, 0] ** 2 + x[:, 1] ** 2) / (4 * RADIUS)
        return x - np.outer(height * (1 + x[:, 2]), [0, 0, 1])

    held = {"x_min": "x", "y_min": "y", "bottom": "z"}
    low = fc.ElasticBody(lower.mapped(shape), solid, "top", held, name="low")
    up = fc.ElasticBody(upper.mapped(shape), solid, "top", held, name="up")
    up = up.placed(rotation=fc.rotation_about((1, 1, 0), np.pi))
    force = modulus * CONTACT**3 / (3 * RADIUS)
    scene = fc.Scene([up, low], [fc.Contact(up, low, coupling=coupling, swap="never")])
    result = scene.solve(forces={up: (0, 0, -force)})
    contact = result.contacts[0]
    assert abs(contact.force[2] / force - 1) < 1e-10
    assert result.residuals().equilibrium < 1e-10
    return contact, result


@pytest.mark.full
@pytest.mark.parametrize("kind", ["hex20", "hex27"])
def test_two_blocks_divided_apart(kind, row):
    """Two paraboloids, one divided within the contact and one round it, coupled by mortar.

    Source: small cells on both sides. Asserted where the slave's faces are small: the pressure differs by less than the
    large faces beside them err. Multipliers at hanging nodes, left to themselves, make peaks at the divided sides.
    """
    small, _ = two(uniform(kind), uniform(kind))
    mixed, result = two(divided(kind, 0.25), divided(kind, 0.5))
    large, _ = two(uniform(kind, 2 * SMALL), uniform(kind, 2 * SMALL))
    case = f"paraboloids divided apart, {kind}"
    peak = small.max_pressure
    tied = mixed.max_pressure / peak
    row(case, "peak over that of small cells", 1.0, tied, 0.1, result.n_dofs)
    row(case, "peak over that of small cells, large", 1.0, large.max_pressure / peak)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mortar, "tied_multipliers", lambda surface: None)
        free, _ = two(divided(kind, 0.25), divided(kind, 0.5))
    row(case, "the same, multipliers not tied", 1.0, free.max_pressure / peak)
    assert free.max_pressure / peak > 1.15


@pytest.mark.full
def test_two_blocks_divided_alike(row):
    """Two paraboloids divided alike round the contact: matching faces, nodal forces, and mortar.

    Source: small cells on both sides, coupled likewise.
    """
    for coupling in ("auto", "mortar"):
        small, reference = two(uniform("hex20"), uniform("hex20"), coupling)
        local, result = two(divided("hex20", 0.5), divided("hex20", 0.5), coupling)
        assert small.coupling == local.coupling == ("nodal" if coupling == "auto" else "mortar")
        case = f"paraboloids divided alike, {local.coupling}"
        row(case, "peak", small.max_pressure, local.max_pressure, 2e-3, result.n_dofs)
        row(case, "area of the points", small.point_area, local.point_area, 2e-3, reference.n_dofs)
