"""Bricks of orthotropic material: a bar pulled at an angle to its axes, turns, derivatives."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from differences import off_differences
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    Joints,
    Stage,
    Viscosity,
    equilibrium,
    sides_by_label,
    traction,
)

WOOD = {"E": (12.0, 0.9, 0.5), "nu": (0.4, 0.45, 0.5), "G": (0.7, 0.6, 0.1)}


def cube(angle=0.0, density=None, **given):
    turn = fc.rotation_about((0, 0, 1), angle)
    material = fc.OrthotropicMaterial(**WOOD, axes=turn.T, density=density)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    return AncfSolid(AncfSpace(mesh), material, points=3, **given)


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2])
def test_pulled_at_an_angle_to_the_grain(angle):
    """1/E_x = c^4/E1 + s^4/E2 + c^2 s^2 (1/G12 - 2 nu12/E1), and it shears (S. G. Lekhnitskii 1963, section 9)."""
    solid, pull = cube(angle), 1e-6
    joints = Joints([solid])
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    held = [joints.pinned((0, corners[0])), joints.pinned((0, corners[1]), [(0, 1, 0), (0, 0, 1)])]
    held += [joints.pinned((0, corners[2]), [(0, 0, 1)])]
    a = Assembly([solid], held)
    load = traction(solid.space, "x_max", (pull, 0, 0)) + traction(solid.space, "x_min", (-pull, 0, 0))
    q = equilibrium(lambda s: Stage(a, s * load), steps=1).last.q
    F = solid.space.gradient_at(q, np.array([0]), np.full((1, 3), 0.5))[0]
    E = (F.T @ F - np.eye(3)) / 2
    c, s, (E1, E2, _), nu, G = np.cos(angle), np.sin(angle), WOOD["E"], WOOD["nu"][0], WOOD["G"][0]
    along = c**4 / E1 + s**4 / E2 + c**2 * s**2 * (1 / G - 2 * nu / E1)
    sheared = 2 * c * s * (c**2 / E1 - s**2 / E2) - (1 / G - 2 * nu / E1) * c * s * (c**2 - s**2)
    assert abs(E[0, 0] / (pull * along) - 1) < 1e-5  # of the strain
    assert abs(2 * E[0, 1] / pull - sheared) < 1e-5 * along


def test_derivatives_and_turns():
    solid = cube(0.4)
    rng = np.random.default_rng(0)
    q, d = solid.q0 + 0.05 * rng.standard_normal(solid.n_dofs), rng.standard_normal(solid.n_dofs)
    assert max(off_differences(solid, q, d)) < 1e-7
    assert abs(solid.stiffness - solid.tangent(solid.q0)).max() == 0
    turned = (q.reshape(-1, 3) @ fc.rotation_about((1, 2, 3), 1.1).T).ravel()
    assert abs(solid.energy(turned) / solid.energy(q) - 1) < 1e-12
    # Cauchy's stress is that of the law in the present shape
    F = solid.space.gradient_at(q, np.array([1]), np.full((1, 3), 0.3))
    (law,) = solid._laws
    stress = law.at(np.zeros((1, 3))).cauchy(F)[0]
    found = solid.cauchy_at(q, np.array([1]), np.full((1, 3), 0.3))[0]
    assert np.abs(found - stress[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]).max() < 1e-12


def test_axes_about_a_line():
    """A ring with stiff hoops grows less by pressure than one with stiff radii: laws vary from point to point."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8").translated((1.0, 0.0, 0.0))
    solids = []
    for E in ((12.0, 1.0, 1.0), (1.0, 12.0, 1.0)):
        axes = fc.CylindricalAxes((0, 0, 1))
        material = fc.OrthotropicMaterial(E=E, nu=(0.0, 0.0, 0.0), G=(1.0, 1.0, 1.0), axes=axes)
        solids.append(AncfSolid(AncfSpace(mesh), material, points=3))
    small = solids[0].space.affine(np.diag([1.001, 1.0, 1.0]))
    radial, hoop = (s.energy(small) for s in solids)
    # strains of x: cos^4 of the radius' angle, mean over the block by Gauss's rule
    x, w = np.polynomial.legendre.leggauss(12)
    X, Y = np.meshgrid(1 + (1 + x) / 2, (1 + x) / 2, indexing="ij")
    c2 = X**2 / (X**2 + Y**2)
    c, s = c2, 1 - c2
    e = (1.001**2 - 1) / 2
    for energy, (E1, E2) in ((radial, (12.0, 1.0)), (hoop, (1.0, 12.0))):
        density = e**2 / 2 * (E1 * c**2 + E2 * s**2 + 4 * c * s)
        assert abs(energy / (np.outer(w, w) / 4 * density).sum() - 1) < 1e-3  # three points a direction


def test_refused():
    with refused(fc.InputError, "directed"):
        cube(viscosity=Viscosity(0.1))
    with refused(fc.InputError, "needs-dilatation"):
        cube(volumetric="linear")
    heavy = cube(density=2.0)
    along = heavy.translation(np.array([1.0, 0.0, 0.0]))
    assert abs(along @ heavy.mass @ along - 2.0) < 1e-12
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    with pytest.raises(fc.InputError):
        fc.AncfBody(mesh, fc.OrthotropicMaterial(**WOOD), contact="top", supports={"bottom": "xyz"}).model.stiffness  # noqa: B018


def exact_deflection(plies, span, height):
    """Of the middle of a laminate bent to a cylinder by a pressure sin(pi x / span) on its top.

    Amplitudes (U, W, Z, T) of both displacements, normal stress and shear change by dy/dz = A y in a ply, and are the
    same on both sides of an interface (N. J. Pagano, J. Composite Materials 3, 1969, 398-411).
    """
    k, through = np.pi / span, np.eye(4)
    for C in plies:
        c11, c13, c33, c55 = C[0, 0], C[0, 2], C[2, 2], C[5, 5]
        A = [[0, -k, 0, 1 / c55], [k * c13 / c33, 0, 1 / c33, 0], [0, 0, 0, k]]
        A += [[k**2 * (c11 - c13**2 / c33), 0, -k * c13 / c33, 0]]
        through = scipy.linalg.expm(np.array(A) * height / len(plies)) @ through
    below = np.linalg.solve(through[2:, :2], [1.0, 0.0])
    return (through[1, :2] @ below + below[1]) / 2


@pytest.mark.parametrize("ratio", [4.0, 10.0])
def test_a_thick_laminate_is_paganos(ratio):
    """Three plies at 0, 90, 0 degrees; thin theory has about a fifth (ratio 4) and a half (10) of the deflection."""
    height, n, pull = 1.0, 6, 1e-6
    span = ratio * height
    mesh = fc.shapes.block((span / 2, 0.2, height), (n, 1, 3), element="hex8")
    ply = np.floor(3 * mesh.points[mesh.cells].mean(axis=1)[:, 2] / height).astype(int)
    mesh = replace(mesh, groups={f"ply {p}": np.flatnonzero(ply == p) for p in range(3)})
    carbon = {"E": (25.0, 1.0, 1.0), "nu": (0.25, 0.25, 0.25), "G": (0.5, 0.5, 0.2)}
    across = ((0, 1, 0), (-1, 0, 0), (0, 0, 1))
    plies = [fc.OrthotropicMaterial(**carbon, axes=axes) for axes in (None, across, None)]
    space = AncfSpace(mesh, sides_by_label(mesh, ply))
    solid = AncfSolid(space, {f"ply {p}": m for p, m in enumerate(plies)}, points=3)
    a = Assembly.of([solid], [{"x_min": "z", "x_max": "x", "y_min": "y", "y_max": "y"}])
    load = traction(space, "top", lambda x, n: pull * np.sin(np.pi * x[:, :1] / span) * np.array([[0.0, 0.0, 1.0]]))
    q = equilibrium(lambda s: Stage(a, s * load), steps=1).last.q
    cells, X = space.located([(span / 2, 0.1, z) for z in (0.0, height)])
    found = (space.points_at(q, cells, X) - space.points_at(a.q0, cells, X))[:, 2].mean() / pull
    exact = exact_deflection([m.at(np.zeros((1, 3)))[0] for m in plies], span, height)
    assert abs(found / exact - 1) < 5e-3
