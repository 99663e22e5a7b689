"""Solids whose stiffness depends on the direction, beside closed forms and turned axes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.common.anisotropic import turned
from fecontact.common.material import FIRST, SECOND
from tests.refusals import refused

SPRUCE = {"E": (10.0, 0.8, 0.4), "nu": (0.37, 0.42, 0.47), "G": (0.6, 0.6, 0.04)}
TURN = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix().T
BLOCK = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
TWO = replace(fc.shapes.block((1.0, 1.0, 2.0), (1, 1, 2)), groups={"low": np.array([0]), "high": np.array([1])})
SKEWED = BLOCK.mapped(lambda x: x + 0.05 * np.sin(3 * x[:, [1, 2, 0]]))


def tensor(C):
    """Moduli (3, 3, 3, 3) of a matrix (6, 6)."""
    out = np.zeros((3, 3, 3, 3))
    for k, (i, j) in enumerate(zip(FIRST, SECOND, strict=True)):
        for m, (p, q) in enumerate(zip(FIRST, SECOND, strict=True)):
            out[i, j, p, q] = out[j, i, p, q] = out[i, j, q, p] = out[j, i, q, p] = C[k, m]
    return out


def test_engineering_constants_are_those_of_bars():
    S = np.linalg.inv(fc.OrthotropicMaterial(**SPRUCE).stiffness)
    assert 1 / S.diagonal() == pytest.approx([10.0, 0.8, 0.4, 0.6, 0.04, 0.6], rel=1e-12)
    assert -S[[0, 0, 1], [1, 2, 2]] * [10.0, 10.0, 0.8] == pytest.approx([0.37, 0.42, 0.47], rel=1e-12)


def test_turned_moduli_are_those_of_the_tensor():
    C = np.random.default_rng(0).normal(size=(6, 6))
    C = C @ C.T
    whole = np.einsum("pi,qj,rk,sl,pqrs->ijkl", TURN, TURN, TURN, TURN, tensor(C), optimize=True)
    assert tensor(turned(C, TURN[None])[0]) == pytest.approx(whole, abs=1e-12)


def test_average_of_an_isotropic_stiffness_is_its_material():
    E, nu = 3.0, 0.3
    G = E / (2 * (1 + nu))
    found = fc.OrthotropicMaterial((E,) * 3, (nu,) * 3, (G,) * 3, axes=TURN).average
    assert (found.E, found.nu) == pytest.approx((E, nu), rel=1e-12)
    # and the mean over many directions of an orthotropic one
    axes = Rotation.random(20000, random_state=1).as_matrix()
    spruce = fc.OrthotropicMaterial(**SPRUCE)
    mean, isotropic = turned(spruce.stiffness, axes).mean(axis=0), spruce.average
    assert mean[0, 0] == pytest.approx(isotropic.lame + 2 * isotropic.shear_modulus, rel=0.02)
    assert mean[3, 3] == pytest.approx(isotropic.shear_modulus, rel=0.02)


@pytest.mark.parametrize("element", ["hex27", "hex20", "hex8"])
def test_off_axis_patch(element):
    """Uniform strains of distorted cells have the forces and energy of C, whatever the axes."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element=element)
    mesh = mesh.mapped(lambda x: x + 0.05 * np.sin(np.pi * x[:, [1, 2, 0]]) * np.prod(x * (1 - x), axis=1)[:, None])
    material = fc.OrthotropicMaterial(**SPRUCE, axes=TURN)
    body = fc.ElasticBody(mesh, material, supports={"x_min": "xyz"}, geometry="plain")
    H = 1e-3 * np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.4], [0.1, 0.6, 0.2]])
    u = (mesh.points @ H.T).ravel()
    strain = (H + H.T) / 2
    e = strain[FIRST, SECOND] * np.where(FIRST == SECOND, 1.0, 2.0)
    stress = material.at(np.zeros((1, 3)))[0] @ e
    assert body.model.strain_energy(u) == pytest.approx(stress @ e / 2, rel=1e-10)
    assert body.model.nodal_stress(u) == pytest.approx(np.tile(stress, (len(mesh.points), 1)), abs=1e-12)
    inner = np.ones(len(mesh.points), bool)
    inner[mesh.face_nodes(mesh.outer)] = False
    forces = body.model.internal_forces(u).reshape(-1, 3)
    assert abs(forces[inner]).max(initial=0.0) < 1e-13
    error = body.model.energy_error(u, np.arange(len(mesh.cells)))
    assert error.error.sum() < 1e-20 * error.energy.sum() + 1e-22
    assert error.energy.sum() == pytest.approx(stress @ e, rel=1e-10)


def test_off_axis_bar_in_tension():
    """Modulus and coupling of extension and shear at angles (Jones, Mechanics of Composite Materials, 1999, 2.6).

    1 / E_x = c^4 / E1 + (1 / G12 - 2 nu12 / E1) s^2 c^2 + s^4 / E2, and the shear gamma_xy of sigma_x is
    (2 s^3 c / E2 - 2 s c^3 / E1 + (1 / G12 - 2 nu12 / E1) (s c^3 - s^3 c)), of the other sign by its axes.
    """
    (e1, e2, _), nu12, g12 = SPRUCE["E"], SPRUCE["nu"][0], SPRUCE["G"][0]
    for degrees in (0.0, 15.0, 40.0, 90.0):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        material = fc.OrthotropicMaterial(**SPRUCE, axes=[[c, s, 0], [-s, c, 0], [0, 0, 1]])
        body = fc.ElasticBody(fc.shapes.block((3.0, 1.0, 0.5), (3, 2, 1)), material)
        model = body.model
        pull = model.traction("x_max", lambda x, n: n) + model.traction("x_min", lambda x, n: n)
        u = body.displacement(_row(body), np.zeros(1), pull)
        strain = model.nodal_strain(u).mean(axis=0)
        inverse = c**4 / e1 + (1 / g12 - 2 * nu12 / e1) * s**2 * c**2 + s**4 / e2
        mixed = 1 / g12 - 2 * nu12 / e1
        shear = 2 * s * c**3 / e1 - 2 * s**3 * c / e2 - mixed * (s * c**3 - s**3 * c)
        assert strain[0] == pytest.approx(inverse, rel=1e-9)
        assert 2 * strain[3] == pytest.approx(shear, abs=1e-9 * inverse)


def _row(body):
    return body.attachment(body.mesh.points[0], np.array([0.0, 0.0, 1.0]))


def test_a_ring_with_cylindrical_axes_under_pressure():
    """Lekhnitskii's tube: sigma_r of powers r^(k-1), k = sqrt(E_theta / E_r) at nu = 0 along it, u_z = 0.

    With nu = 0 everywhere u = A r^k + B r^-k (Lekhnitskii, Anisotropic Plates, 1968, section 34), sigma_r = E_r u'.
    """
    er, et = 1.0, 4.0
    k = np.sqrt(et / er)
    material = fc.OrthotropicMaterial((er, et, 1.0), (0, 0, 0), (0.5, 0.5, 0.5), fc.CylindricalAxes((0, 0, 1)))
    square = fc.shapes.block((1.0, 0.5 * np.pi, 0.2), (8, 6, 1))
    mesh = square.mapped(
        lambda x: np.stack([(1 + x[:, 0]) * np.cos(x[:, 1]), (1 + x[:, 0]) * np.sin(x[:, 1]), x[:, 2]], axis=1)
    )
    supports = {"y_min": "y", "y_max": "x", "bottom": "z", "top": "z"}
    body = fc.ElasticBody(mesh, material, supports=supports, geometry="plain")
    pressed = body.model.traction("x_min", lambda x, n: -n)
    u = body.displacement(_row(body), np.zeros(1), pressed).reshape(-1, 3)
    a, b = 1.0, 2.0
    A, B = np.linalg.solve(
        er * k * np.array([[a ** (k - 1), -(a ** (-k - 1))], [b ** (k - 1), -(b ** (-k - 1))]]), [-1.0, 0.0]
    )
    r = np.linalg.norm(mesh.points[:, :2], axis=1)
    found = (u * mesh.points)[:, :2].sum(axis=1) / r
    exact = A * r**k + B * r**-k
    assert found == pytest.approx(exact, abs=2e-4 * exact.max())


def test_a_turned_body_answers_as_one_of_turned_axes():
    """A press of a body, and of the body and its axes turned in space."""
    ball = fc.RigidBody(fc.Sphere(2.0), name="ball")
    forces = []
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for mesh, axes in ((BLOCK, None), (BLOCK.mapped(lambda x: x @ quarter), quarter)):
        body = fc.ElasticBody(mesh, fc.OrthotropicMaterial(**SPRUCE, axes=axes), "top", {"bottom": "xyz"})
        at = mesh.points.mean(axis=0) + np.array([0.0, 0.0, 0.5])
        pressed = ball.placed(at)
        result = fc.Scene([body, pressed], [fc.Contact(body, pressed)]).solve(motions={pressed: {"z": -0.05}})
        forces.append(np.linalg.norm(result.contacts[0].force))
        assert any("mean over all directions" in note for note in result.notes)
    assert forces[1] == pytest.approx(forces[0], rel=1e-9)


def test_heated_along_its_axes():
    """Free expansion has no stress; held ends have those of C times the strain."""
    material = fc.OrthotropicMaterial(**SPRUCE, axes=TURN, expansion=1e-3)
    body = fc.ElasticBody(SKEWED, material, geometry="plain")
    heated = body.model.heated(np.full(len(SKEWED.points), 2.0))
    u = body.displacement(_row(body), np.zeros(1), heated.forces)
    assert body.model.gauss_strain(u) == pytest.approx(heated.strain, abs=1e-12)
    assert abs(body.model.stress(body.model.stressing(u, heated))).max() < 1e-11


def test_mixed_with_an_isotropic_part():
    """Two layers in series under uniform compression, each by its own modulus (no lateral strain by nu = 0)."""
    mesh = TWO
    wood = fc.OrthotropicMaterial((1.0, 2.0, 4.0), (0, 0, 0), (1.0, 1.0, 1.0))
    body = fc.ElasticBody(mesh, {"low": wood, "high": fc.Material(2.0, 0.0)}, supports={"bottom": "z"})
    u = body.displacement(_row(body), np.zeros(1), body.model.traction("top", lambda x, n: -n)).reshape(-1, 3)
    top = mesh.boundary_nodes("top")
    assert u[top, 2] == pytest.approx(np.full(len(top), -(1 / 4.0 + 1 / 2.0)), rel=1e-10)


def test_refused():
    isotropic = (1.0, 1.0, 1.0)
    with refused(fc.InputError, "not-positive-definite", "positive"):
        fc.OrthotropicMaterial(isotropic, (0.6, 0.6, 0.6), isotropic)
    fc.OrthotropicMaterial(isotropic, (0.49, 0.49, 0.49), isotropic)
    with pytest.raises(fc.InputError, match="positive"):
        fc.OrthotropicMaterial((1.0, -1.0, 1.0), (0, 0, 0), isotropic)
    for axes in ([[1, 0, 0], [0.1, 1, 0], [0, 0, 1]], np.diag([1, 1, -1]), np.zeros((3, 3))):
        with refused(fc.InputError, "axes", "right angles"):
            fc.OrthotropicMaterial(**SPRUCE, axes=axes)
    with refused(fc.InputError, "wrong-shape"):
        fc.OrthotropicMaterial(**SPRUCE, axes=[1, 0, 0])
    with refused(fc.InputError, "wrong-shape"):
        fc.ElasticBody(BLOCK, fc.OrthotropicMaterial(**SPRUCE, axes=lambda x: np.eye(3))).model.moduli  # noqa: B018
    with refused(fc.InputError, "no-direction"):
        fc.CylindricalAxes((0, 0, 0))
    with refused(fc.InputError, "moduli", "symmetric"):
        fc.AnisotropicMaterial(np.arange(36.0).reshape(6, 6))


def test_refused_where_an_isotropic_material_is_needed():
    wood = fc.OrthotropicMaterial(**SPRUCE)
    with refused(fc.InputError, "selective-anisotropic"):
        fc.ElasticBody(BLOCK, wood, integration="selective")
    with refused(fc.InputError, "anisotropic"):
        fc.LocalBody(
            fc.ElasticBody(BLOCK, wood, supports={"bottom": "xyz"}), at=(0.5, 0.5, 1.0), window=0.3, cells=(8, 8)
        )
    with pytest.raises(fc.InputError, match="Material"):
        fc.HalfSpace(wood, size=(1.0, 1.0), cells=(8, 8))
    with refused(fc.InputError, "some-laws"):
        fc.ElasticBody(TWO, {"low": wood, "high": fc.NeoHookean(1.0, 0.3)})
