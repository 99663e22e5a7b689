"""The error of a finite element solution in the energy norm, against fields of known strain."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.fem.energy_error import MAX_MATERIALS, by_material, energy_density, energy_error
from fecontact.fem.stress import hooke

UNIT = fc.Material(E=1.0, nu=0.3)


def totals(found):
    """Squared energy norms of error and displacements over all cells."""
    return found.error.sum(), found.energy.sum()


def linear_strain(n, element):
    """Squared energy norms for u_x = x^2 / 2 on a unit cube of n cells along x, one across."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, 1, 1), element=element)
    lame, shear = np.full(n, UNIT.lame), np.full(n, UNIT.shear_modulus)
    u = np.stack([mesh.points[:, 0] ** 2 / 2, 0 * mesh.points[:, 0], 0 * mesh.points[:, 0]], axis=1)
    return totals(energy_error(mesh, u, lame, shear, np.arange(n)))


def test_linear_cells_miss_the_slope_of_a_strain():
    """Source: strain x, of which a cell of length h has the mean: (lambda + 2 mu) h^2 / 12 is missed.

    In the outer cells, too: there half of the slope is recovered, from the mean at one end on, (h/2)^2 / 3.
    """
    n = 20
    error, energy = linear_strain(n, "hex8")
    modulus = UNIT.lame + 2 * UNIT.shear_modulus
    whole = modulus / n**2 / 12
    assert abs(error / whole - 1) < 1e-9
    assert abs(energy / (modulus * (1 / 3 - 1 / 12 / n**2)) - 1) < 1e-9


def test_linear_cells_in_bending_miss_what_their_shear_costs():
    """Source: u = (k x z, 0, -k x^2 / 2) of pure bending, nu = 0, at the nodes of cells one or two across: their strain
    xx is that of the field, and their shear k (x - middle) / 2 instead of none costs mu k^2 L^2 / 12 for a length L.

    A uniform strain on distorted cells is missed by nothing.
    """
    for across in (1, 2):
        mesh = fc.shapes.block((4.0, 1.0, 1.0), (8, 1, across), element="hex8").translated((0, 0, -0.5))
        shear = np.full(len(mesh.cells), 0.5)
        x, z = mesh.points[:, 0], mesh.points[:, 2]
        u = np.stack([x * z, 0 * x, -(x**2) / 2], axis=1)
        error, energy = totals(energy_error(mesh, u, 0 * shear, shear, np.arange(len(shear))))
        assert abs(error / (4 * 0.5 * 0.5**2 / 12) - 1) < 1e-9
        assert abs((energy - error) / (4 / 12) - 1) < 1e-9
    skew = mesh.mapped(lambda p: p + 0.05 * np.sin(3 * p[:, [1, 2, 0]]))
    error, energy = totals(energy_error(skew, skew.points[:, [2, 0, 1]] + skew.points, shear, shear, np.arange(16)))
    assert error < 1e-24 * energy
    # of two fields: the product of their errors
    other = np.stack([0 * x, x * z, 0 * x], axis=1)
    one, two, both = (
        energy_error(mesh, v, shear, shear, np.arange(16), other=w).error.sum()
        for v, w in ((u, None), (other, None), (u + other, None))
    )
    product = energy_error(mesh, u, shear, shear, np.arange(16), other=other).error.sum()
    assert abs(both - one - two - 2 * product) < 1e-12 * both


def test_quadratic_cells_hold_it():
    error, energy = linear_strain(6, "hex20")
    assert error < 1e-12 * energy


def test_strains_of_two_materials_are_not_averaged():
    """Source: two blocks in series; their strains jump where they meet, and are exact."""
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (6, 2, 2), element="hex8")
    stiff = mesh.points[mesh.cells].mean(axis=1)[:, 0] > 1
    shear = np.where(stiff, 10.0, 1.0)
    x = mesh.points[:, 0]
    u = np.stack([np.where(x > 1, 1 + (x - 1) / 10, x), 0 * x, 0 * x], axis=1)
    every = np.arange(len(mesh.cells))
    error, energy = totals(energy_error(mesh, u, 0 * shear, shear, every))
    assert error < 1e-12 * energy
    assert totals(energy_error(mesh, u, 0 * shear, np.ones(len(shear)), every))[0] > 0.01 * energy
    assert len(by_material(0 * shear, shear, every)) == 2
    many = np.linspace(1, 2, MAX_MATERIALS + 1)
    assert len(by_material(0 * many, many, np.arange(len(many)))) == 1


def test_the_energy_is_that_of_the_stiffness():
    """Source: u^T K u, on distorted cells, wedges among them, and selectively integrated ones."""
    mesh = fc.shapes.cylinder(1.0, 1.0, level=1, sector="quarter")
    rng = np.random.default_rng(1)
    for nu in (0.3, 0.4999):
        body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=nu), "cap")
        model = body.model
        if model.selective:
            continue
        u = rng.standard_normal(model.n_dofs) * 1e-3
        K = model.stiffness
        energy = u @ (K @ u + K.T @ u - K.diagonal() * u)
        assert abs(totals(model.energy_error(u, np.arange(len(model.mesh.cells))))[1] / energy - 1) < 1e-9


@pytest.mark.parametrize("kind", ["plane", "axis"])
def test_sections_have_it_too(kind):
    """Source: u^T K u; a uniform strain in the plane is recovered."""
    section = fc.sections.rectangle((1.0, 1.0), (4, 4))
    body = (fc.PlaneBody if kind == "plane" else fc.AxisymmetricBody)(section, UNIT, "top")
    model = body.model
    u = (section.points * [0.1, 0.0, 0.1]).ravel()
    error, energy = totals(model.energy_error(u, np.arange(len(section.cells))))
    K = model.stiffness
    assert abs(energy / (u @ (K @ u + K.T @ u - K.diagonal() * u)) - 1) < 1e-9
    assert error < 1e-12 * energy


def test_cells_near_points_are_looked_at_and_bodies_without_cells_have_none():
    mesh = fc.shapes.block((4.0, 1.0, 1.0), (8, 2, 2), element="hex8")
    body = fc.ElasticBody(mesh, UNIT, "top")
    x = mesh.points[:, 0]
    u = np.stack([np.where(x > 2, (x - 2) ** 2, 0.0), 0 * x, 0 * x], axis=1).ravel()
    near, far = (body._energy_error(u, np.array([[place, 0.5, 0.5]]), 1.0) for place in (3.0, 1.0))
    assert near.error.sum() > 0.01 * near.energy.sum() > 0
    middles = mesh.points[mesh.cells].mean(axis=1)
    assert np.array_equal(near.cells, np.flatnonzero(np.linalg.norm(middles - [3.0, 0.5, 0.5], axis=1) < 1))
    assert len(far.cells) > 0
    assert totals(far) == (0.0, 0.0)
    floor = fc.RigidBody(fc.Plane())
    assert len(floor._energy_error(np.zeros(6), np.zeros((1, 3)), 1.0).cells) == 0
    bricks = fc.AncfBody(mesh, UNIT, "top")
    assert len(bricks._energy_error(np.zeros(bricks.n_dofs), np.zeros((1, 3)), 9.0).cells) == 0


def test_the_density_is_stress_times_strain():
    strain = np.random.default_rng(2).standard_normal((5, 6))
    lame, shear = np.full(5, 0.7), np.full(5, 0.4)
    stress = hooke(strain, lame, shear)
    twice = np.where(np.arange(6) < 3, 1.0, 2.0)
    assert np.allclose(energy_density(strain, lame, shear), (stress * strain * twice).sum(axis=1))


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_no_cells_have_no_error(element):
    """Where no middle of a cell is as near to a narrow contact as that is wide: a refusal of a mesh without cells."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element=element)
    body = fc.ElasticBody(mesh, UNIT, contact="top", supports={"bottom": "xyz"})
    found = body._energy_error(np.zeros(body.n_dofs), np.array([[0.0, 0.0, 1.0]]), 0.1)
    assert [len(each) for each in (found.cells, found.error, found.energy)] == [0, 0, 0]
    flat = fc.PlaneBody(fc.sections.rectangle((1.0, 1.0), (1, 1)), UNIT, "top", {"bottom": "xz"})
    found = flat._energy_error(np.zeros(flat.n_dofs), np.array([[0.0, 0.0, 1.0]]), 0.1)
    assert [len(each) for each in (found.cells, found.error, found.energy)] == [0, 0, 0]
