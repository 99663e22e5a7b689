"""Strain and stress recovery."""

import numpy as np
import pytest

from fecontact.common.material import VOIGT, von_mises
from fecontact.fem.stress import gauss_strain, hooke, to_nodes

GRADIENT = np.array([[0.1, -0.2, 0.3], [0.0, 0.4, -0.1], [0.2, 0.1, -0.3]])
STRAIN = (GRADIENT + GRADIENT.T) / 2
COMPONENTS = [STRAIN["xyz".index(a), "xyz".index(b)] for a, b in VOIGT]
# gradients of order one over cells of size one half
ROUNDING = 1e-12


def meshes(curved, degenerate):
    yield from (curved(e) for e in ("hex8", "hex20", "hex27"))
    yield curved().with_midface_nodes(("top", "x_min"))
    yield from (degenerate(k) for k in ("one edge", "wedge", "pyramid", "tetrahedron"))


def test_linear_fields_are_exact_for_every_kind_of_element(curved, degenerate):
    for mesh in meshes(curved, degenerate):
        strain, points = gauss_strain(mesh, mesh.points @ GRADIENT.T)
        assert points.shape == (*strain.shape[:2], 3)
        assert np.abs(strain - COMPONENTS).max() < ROUNDING
        assert np.abs(to_nodes(mesh, strain) - COMPONENTS).max() < ROUNDING


@pytest.mark.parametrize("kind", ["hex20", "hex27", "midface"])
def test_linear_strain_reaches_the_nodes_exactly(kind, curved):
    # quadratic displacement on a straight mesh: strain linear in x
    mesh = curved("hex27" if kind == "hex27" else "hex20", amount=0.0)
    mesh = mesh.with_midface_nodes(("top",)) if kind == "midface" else mesh
    u = np.zeros_like(mesh.points)
    u[:, 0] = mesh.points[:, 0] ** 2
    u[:, 2] = mesh.points[:, 0] * mesh.points[:, 1]
    nodal = to_nodes(mesh, gauss_strain(mesh, u)[0])
    assert np.abs(nodal[:, 0] - 2 * mesh.points[:, 0]).max() < ROUNDING
    assert np.abs(nodal[:, 5] - mesh.points[:, 1] / 2).max() < ROUNDING
    assert np.abs(nodal[:, 4] - mesh.points[:, 0] / 2).max() < ROUNDING


def test_hooke_and_von_mises(steel):
    stress = hooke(np.array(COMPONENTS), np.array(steel.lame), np.array(steel.shear_modulus))
    tensor = steel.lame * np.trace(STRAIN) * np.eye(3) + 2 * steel.shear_modulus * STRAIN
    for value, (a, b) in zip(stress, VOIGT, strict=True):
        assert abs(value - tensor["xyz".index(a), "xyz".index(b)]) < ROUNDING * np.abs(tensor).max()
    deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
    assert abs(von_mises(stress) / np.sqrt(1.5 * (deviator**2).sum()) - 1) < ROUNDING


def test_hooke_broadcasts_over_cells():
    strain = np.ones((4, 27, 6))
    lame, shear = np.arange(1.0, 5.0)[:, None], np.arange(2.0, 6.0)[:, None]
    stress = hooke(strain, lame, shear)
    assert stress.shape == strain.shape
    assert (stress[2, :, :3] == 3 * 3 + 2 * 4).all()
    assert (stress[2, :, 3:] == 2 * 4).all()
