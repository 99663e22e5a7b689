"""Orthotropic sections, and expansions that depend on the direction, by closed forms and beside solids."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

# stresses of order one that are uniform are exact
ROUNDING = 1e-9
#: Axes x, y, z of space; y lies across sections.
WOOD = fc.OrthotropicMaterial(E=(9.0, 3.0, 2.0), nu=(0.3, 0.25, 0.2), G=(1.5, 0.7, 1.1))


def alone(body, **loads):
    """Displacements (n, 3), strains and stresses of a body that touches nothing, at its nodes."""
    away = fc.RigidBody(fc.Plane()).placed((0, 0, 50.0), fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([body, away], [fc.Contact(body, away)]).solve(**loads)
    return result.displacement(body), result.strain(body), result.stress(body)


def about_y(angle):
    """Axes turned in the plane of a section."""
    c, s = np.cos(angle), np.sin(angle)
    return ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c))


def rectangle(plane, material, supports=None):
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    return fc.PlaneBody(mesh, material, "top", supports or {"left": "x", "bottom": "z"}, plane=plane, thickness=2.0)


def test_plane_stress_has_the_engineering_constants():
    body = rectangle("stress", WOOD)
    _, strain, stress = alone(body, pressures={(body, "right"): -1.0})
    assert np.abs(stress - [1, 0, 0, 0, 0, 0]).max() < ROUNDING
    assert np.abs(strain[:, :3] - np.array([1.0, -0.3, -0.25]) / 9.0).max() < ROUNDING
    assert any("scales, are those of its mean" in note for note in body.notes)


@pytest.mark.parametrize("angle", [0.3, 1.1])
def test_a_turned_lamina_in_plane_stress(angle):
    """1 / E across the grain by Lekhnitskii, Theory of Elasticity of an Anisotropic Body, section 9."""
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    pins = {f"pin {x:g}": np.flatnonzero(np.abs(mesh.points - [x, 0, 0]).max(axis=1) < 1e-12) for x in (0.0, 1.0)}
    mesh = replace(mesh, node_sets=pins)
    wood = replace(WOOD, axes=about_y(angle))
    body = fc.PlaneBody(mesh, wood, "top", {"pin 0": "xz", "pin 1": "z"}, plane="stress")
    _, strain, stress = alone(body, pressures={(body, "left"): -1.0, (body, "right"): -1.0})
    c, s = np.cos(angle), np.sin(angle)
    (e1, _, e3), (_, nu13, _), (_, g13, _) = WOOD.E, WOOD.nu, WOOD.G
    exact = c**4 / e1 + s**4 / e3 + (1 / g13 - 2 * nu13 / e1) * (s * c) ** 2
    assert np.abs(strain[:, 0] - exact).max() < ROUNDING
    assert np.abs(stress - [1, 0, 0, 0, 0, 0]).max() < ROUNDING


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_a_section_is_a_solid_beside_it(plane, angle):
    """The same rectangle as a solid of one cell across, of other elements: fields that are linear are exact in both."""
    material = replace(WOOD, axes=about_y(angle))
    u = np.array([[0.01, 0.0, 0.004], [0.0, 0.0, 0.0], [-0.003, 0.0, 0.02]])
    flat = rectangle(plane, material, dict.fromkeys(("left", "right", "bottom", "top"), "xz"))
    flat = replace(flat, contact="inner", mesh=with_inner(flat.mesh))
    moved = {(flat, name): flat.mesh.points[flat.mesh.boundary_nodes(name)] @ u.T for name in flat.supports}
    _, strain, stress = alone(flat, displacements=moved)
    C = material.at(np.zeros((1, 3)))[0]
    gamma = np.array([u[0, 0], 0.0, u[2, 2], 0.0, 0.0, u[0, 2] + u[2, 0]])
    if plane == "stress":
        J, inside = [1, 3, 4], [0, 2, 5]
        gamma[J] = -np.linalg.solve(C[np.ix_(J, J)], C[np.ix_(J, inside)] @ gamma[inside])
    assert np.abs(stress - C @ gamma).max() < ROUNDING
    assert np.abs(strain - gamma / [1, 1, 1, 2, 2, 2]).max() < ROUNDING


def with_inner(mesh):
    """With a node of its top as what might touch."""
    middle = np.flatnonzero(np.abs(mesh.points - [0.5, 0, 1]).max(axis=1) < 1e-12)
    return replace(mesh, node_sets={"inner": middle})


def test_an_orthotropic_tube_under_pressure():
    """Without Poisson's ratios, E_t / E_r = k^2: u = A r^k + B r^-k (Lekhnitskii, Anisotropic Plates, section 29)."""
    k, p, a, b = 2.0, 0.1, 1.0, 2.0
    tube = fc.OrthotropicMaterial(E=(1.0, k**2, 1.0), nu=(0, 0, 0), G=(1.0, 1.0, 1.0))
    mesh = fc.sections.rectangle((1.0, 0.25), (16, 1)).translated((a, 0, 0))
    body = fc.AxisymmetricBody(mesh, tube, "top", {"bottom": "z"})
    u, _, stress = alone(body, pressures={(body, "left"): p})
    # k (A r^(k-1) - B r^(-k-1)) is -p inside and zero outside
    A, B = np.linalg.solve(k * np.array([[a ** (k - 1), -(a ** (-k - 1))], [b ** (k - 1), -(b ** (-k - 1))]]), [-p, 0])
    r = mesh.points[:, 0]
    exact = A * r**k + B * r**-k
    assert np.abs(u[:, 0] - exact).max() < 1e-5 * np.abs(exact).max()
    assert np.abs(stress[:, 1] - k**2 * exact / r).max() < 1e-2 * p


def test_a_twisted_rod_has_its_own_shear_modulus():
    """M = G J w / L, by hand, G that of the shear yz."""
    mesh = fc.sections.rectangle((1.0, 2.0), (2, 4))
    body = fc.AxisymmetricBody(mesh, WOOD, "top", {"bottom": "xyz", "top": "xyz"}, torsion=True)
    turn = np.zeros((len(mesh.boundary_nodes("top")), 3))
    turn[:, 1] = 0.01 * mesh.points[mesh.boundary_nodes("top"), 0]
    away = fc.RigidBody(fc.Plane()).placed((0, 0, 50.0), fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([body, away], [fc.Contact(body, away)]).solve(displacements={(body, "top"): turn})
    assert abs(abs(result.reaction(body, "top")[5]) - 1.1 * np.pi / 2 * 0.01 / 2) < 1e-9


def test_a_block_expands_along_the_axes_of_its_material():
    """Free: the strains are a_p T along the axes, wherever these point; between walls the stress is -C a T."""
    turn = fc.rotation_about((1.0, 2.0, 0.5), 0.7)
    wood = replace(WOOD, axes=turn, expansion=(1e-3, 2e-3, -5e-4))
    free = turn.T @ np.diag(wood.expansion) @ turn * 10.0
    along = np.array([free[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))])
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body = fc.ElasticBody(mesh, wood, "top", {"bottom": "xyz"})
    loose = replace(body, supports={})
    fields = loose.model.heated(np.full(len(loose.model.mesh.points), 10.0))
    assert (
        np.abs(loose.model.internal_forces((loose.model.mesh.points @ free).ravel()) - fields.forces).max() < ROUNDING
    )
    whole = dict.fromkeys(mesh.boundaries, "xyz")
    middle = np.flatnonzero(np.abs(mesh.points - [0.5, 0.5, 1]).max(axis=1) < 1e-12)
    held = fc.ElasticBody(replace(mesh, node_sets={"middle": middle}), wood, "middle", whole)
    _, strain, stress = alone(held, temperatures={held: 10.0})
    doubled = along * [1, 1, 1, 2, 2, 2]
    assert np.abs(stress + wood.at(np.zeros((1, 3)))[0] @ doubled).max() < ROUNDING
    assert np.abs(strain).max() < ROUNDING
    assert wood.average.expansion == pytest.approx(2.5e-3 / 3, abs=1e-15)


def test_a_ring_that_expands_otherwise_around_than_outwards():
    """E = 1, nu = 0: r^2 u'' + r u' - u = (a_r - a_t) T r, u = A r + B / r + (a_r - a_t) T r ln(r) / 2."""
    out, around, T, a, b = 2e-3, 1e-3, 5.0, 1.0, 2.0
    ring = fc.OrthotropicMaterial(E=(1, 1, 1), nu=(0, 0, 0), G=(0.5, 0.5, 0.5), expansion=(out, around, 0.0))
    mesh = fc.sections.rectangle((1.0, 0.25), (16, 1)).translated((a, 0, 0))
    body = fc.AxisymmetricBody(mesh, ring, "top", {"bottom": "z"})
    u, strain, stress = alone(body, temperatures={body: T})
    c = (out - around) * T / 2
    # u' - out T vanishes at both sides
    rows = np.array([[1.0, -1 / a**2], [1.0, -1 / b**2]])
    A, B = np.linalg.solve(rows, [out * T - c * (1 + np.log(x)) for x in (a, b)])
    r = mesh.points[:, 0]
    exact = A * r + B / r + c * r * np.log(r)
    assert np.abs(u[:, 0] - exact).max() < 1e-6 * np.abs(exact).max()
    assert np.abs(strain[:, 1] - exact / r).max() < 1e-3 * np.abs(exact / r).max()
    assert np.abs(stress[:, 1] - (exact / r - around * T)).max() < 2e-5


def test_a_heated_lamina_between_walls():
    """By hand, held along x alone: s = -E1 a1 T, and the strains across are a T + nu1j a1 T."""
    a, T = (1e-3, 2e-3, -5e-4), 10.0
    body = rectangle("stress", replace(WOOD, expansion=a), {"left": "x", "right": "x", "bottom": "z"})
    _, strain, stress = alone(body, temperatures={body: T})
    assert np.abs(stress - [-9.0 * a[0] * T, 0, 0, 0, 0, 0]).max() < ROUNDING
    expected = np.array([0.0, a[1] + 0.3 * a[0], a[2] + 0.25 * a[0], 0, 0, 0]) * T
    assert np.abs(strain - expected).max() < ROUNDING


def test_what_is_not_offered_of_them():
    mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    with refused(fc.InputError, "selective-anisotropic"):
        fc.PlaneBody(mesh, WOOD, "top", {"bottom": "xz"}, integration="selective")
    with refused(fc.InputError, "not-a-vector"):
        replace(WOOD, expansion=(1.0, 2.0))
