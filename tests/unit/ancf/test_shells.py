"""Shells of any shape: metric of the initial shape, taper, layers on general meshes, and what is refused."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from refusals import refused

import fecontact as fc
from fecontact.ancf import FollowerPressure
from fecontact.ancf.slender import Joints, Lamina, Laminate, Surface, beam, plate, shell, thick_plate

MATERIAL = fc.Material(E=3.0, nu=0.3, density=2.0)


def uneven(n, seed=0):
    """A unit square in n x n cells of uneven shape."""
    flat = Surface.rolled([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (n, n))
    inner = ((flat.nodes[:, :2] > 1e-9) & (flat.nodes[:, :2] < 1 - 1e-9)).all(axis=1)
    moved = flat.nodes.copy()
    moved[inner, :2] += np.random.default_rng(seed).uniform(-0.25, 0.25, (inner.sum(), 2)) / n
    return moved, flat.cells


def arch(n=4, angle=1.2, radius=2.0, width=0.7):
    """A cylindrical shell of a radius about the axis x, its normal outwards."""

    def position(u, v):
        return np.stack([width * u, -radius * np.sin(angle * v), -radius * np.cos(angle * v)], axis=-1)

    return Surface.mapped(position, (1, n))


def strained(s, volume):
    """Energy of r = F X over its density times the volume, by a random F; of isotropic continua."""
    F = np.eye(3) + 0.1 * np.random.default_rng(1).normal(size=(3, 3))
    E = (F.T @ F - np.eye(3)) / 2
    lame = 3.0 * 0.3 / (1.3 * 0.4)
    density = lame / 2 * np.trace(E) ** 2 + 3.0 / 2.6 * (E * E).sum()
    return s.energy((s.q0.reshape(-1, 3) @ F.T).ravel()) / (density * volume)


def volume_of(s):
    along = s.translation(np.array([0, 0, 1.0]))
    return along @ s.mass @ along / MATERIAL.density


@pytest.mark.parametrize("taper", [False, True])
def test_volume_and_energy_of_a_homogeneous_strain(taper):
    """Of a thick arch, as a continuum: r = F X is one of its states, with the energy W V by hand, to rounding.

    V is w t R a, but for the fibres, bilinear between unit normals at an angle d: shorter by d^2 / 12 on average.
    """
    radius, angle, width, t = 2.0, 1.2, 0.7, 0.8
    each = t * np.tile(np.linspace(0.5, 1.5, 5), 2) if taper else t
    s = shell(arch(4, angle, radius, width), MATERIAL, each, thick=True, approach="continuum")
    assert abs(volume_of(s) / (width * t * radius * angle) - (1 - 0.3**2 / 12)) < 1e-4
    assert abs(strained(s, volume_of(s)) - 1) < 1e-12
    # by its middle surface it weighs all
    thin = shell(arch(4, angle, radius, width), MATERIAL, each, thick=True)
    assert abs(volume_of(thin) / (width * t * radius * angle) - 1) < 1e-4


def test_a_thick_curved_beam_under_a_homogeneous_strain():
    """The same of a beam on an arc of one radius, as high as half of it."""
    a = np.linspace(0, 1.2, 5)
    points, tangents = np.stack([np.sin(a), 1 - np.cos(a), 0 * a], 1), np.stack([np.cos(a), np.sin(a), 0 * a], 1)
    s = beam(points, MATERIAL, width=0.5, height=0.4, tangents=tangents, approach="continuum")
    assert abs(volume_of(s) / (1.2 * 0.2) - (1 - 0.3**2 / 12)) < 1e-4
    assert abs(strained(s, volume_of(s)) - 1) < 1e-12


def test_pressure_and_skin_of_an_arch():
    """The resultant of a pressure on top is that on its chord; the areas of its skin add up to R a w."""
    s = arch(4)
    arched = shell(s, MATERIAL, 0.1)
    radius, angle, width = 2.0, 1.2, 0.7
    f = FollowerPressure(0, "top", 3.0).forces(arched, arched.q0)
    # pressed inwards, towards the axis x: normals are outwards
    chord = radius * np.array([0.0, 1 - np.cos(angle), np.sin(angle)])
    assert np.allclose([arched.translation(e) @ f for e in np.eye(3)], 3.0 * width * chord, atol=1e-4)
    assert abs(arched.side(0.05).quadrature[2].sum() / (radius * angle * width) - 1) < 1e-4


@pytest.mark.parametrize("smooth", [False, True])
def test_a_cylinder_that_grows(smooth):
    """By a factor: membrane strain (f^2 - 1) / 2 both ways, and its curvature f / R from 1 / R. Of Koiter's energy."""
    f, h, radius = 1.1, 0.3, 2.0
    s = shell(arch(), MATERIAL, h, smooth=smooth)
    e, k = (f**2 - 1) / 2, (f - 1) / radius
    plane = 3.0 / (1 - 0.3**2)
    energy = 0.7 * radius * 1.2 * (plane * h * (1 + 0.3) * e**2 + plane * h**3 / 24 * k**2)
    assert abs(s.energy(f * s.q0) / energy - 1) < 1e-4


def test_layers_on_an_uneven_mesh():
    """A homogeneous strain in the plane of a turned mesh: the energy of a rectangle with its layers, to rounding."""
    nodes, cells = uneven(3)
    ply = Lamina(E1=140.0, E2=10.0, nu12=0.3, G12=5.0)
    layers = Laminate([(ply, 0.01, 20.0), (ply, 0.02, -65.0)])
    turn = fc.rotation_about((1, 2, 3), 0.8)
    s = shell(Surface.of(nodes @ turn.T, cells, along=turn[:, 0]), layers)
    simple = plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (1, 1), layers)
    F = np.eye(3) + 0.1 * np.random.default_rng(1).normal(size=(3, 3))
    known = simple.energy((simple.q0.reshape(-1, 3) @ F.T).ravel())
    assert abs(s.energy((s.q0.reshape(-1, 3) @ (F @ turn.T).T).ravel()) / known - 1) < 1e-12


def bent(s):
    """Coordinates of w = (x^2 + y^2 / 2) / 1000, with their gradients."""
    q, X = s.q0.reshape(s.vectors.shape).copy(), s.vectors[:, 0]
    q[:, 0, 2] += (X[:, 0] ** 2 + X[:, 1] ** 2 / 2) / 1000
    q[:, 1:3, 2] += (2 * X[:, None, 0] * s.vectors[:, 1:3, 0] + X[:, None, 1] * s.vectors[:, 1:3, 1]) / 1000
    return q


def off_constant_curvature(surface):
    """Relative error of the bending energy of w = (x^2 + y^2 / 2) / 1000."""
    s = shell(surface, MATERIAL, 0.01)
    part, e = s.parts[1], s.strains(bent(s).ravel(), 1)
    d = 3.0 * 0.01**3 / 12 / (1 - 0.3**2) / 2 * (0.002**2 + 0.001**2 + 2 * 0.3 * 0.002 * 0.001)
    return (part.weighted * (part.elastic(e) * e).sum(axis=2)).sum() / 2 / (d * part.weighted.sum()) - 1


def test_constant_curvature():
    """To rounding on parallelograms, whose functions hold all cubics; on others off by what these lack.

    Cells become parallelograms as they are divided: the error of a kite falls with the square of their size.
    """

    def kite(n):
        def position(u, v):
            return np.stack([1.2 * u + 0.1 * u * v, v * (1 - 0.3 * u), 0 * u], axis=-1)

        grid = Surface.mapped(position, (n, n))
        return Surface.of(grid.nodes, grid.cells)

    slanted = Surface.mapped(lambda u, v: np.stack([u + 0.5 * v, v, 0 * u], axis=-1), (2, 2))
    assert abs(off_constant_curvature(slanted)) < 1e-5  # the square of the slope
    errors = np.array([off_constant_curvature(kite(n)) for n in (1, 2, 4)])
    assert (errors[:-1] / errors[1:] > 3.8).all()
    assert errors[-1] < 2e-3


@pytest.mark.parametrize(("make", "most"), [(plate, 1e-4), (thick_plate, 1e-3)])
def test_a_tapered_cantilever(make, most):
    """From h to h / 2 at its tip, nu = 0: w = P int x^2 / (E I), x from the tip, of I = b h^3 (1 + x/L)^3 / 96."""
    L, b, h, E, n = 10.0, 1.0, 0.2, 1e4, 16
    each = np.repeat(h / 2 * np.linspace(2, 1, n + 1), 2)
    s = make([(0, 0, 0), (L, 0, 0), (0, b, 0)], (n, 1), fc.Material(E=E, nu=0.0), each)
    joints = Joints([s])
    Z = joints.free([joints.clamped((0, 0)), joints.clamped((0, 1))])
    f = np.zeros(s.vectors.shape)
    f[-2:, 0, 2] = 0.5
    u = Z @ spla.spsolve((Z.T @ s.tangent(s.q0) @ Z).tocsc(), Z.T @ f.ravel())
    known = 96 * L**3 / (E * b * h**3) * (np.log(2) - 5 / 8)
    assert abs(u.reshape(s.vectors.shape)[-1, 0, 2] / known - 1) < most


def test_shells_that_are_refused():
    nodes, cells = uneven(2)
    flat, roof = Surface.of(nodes, cells), np.column_stack([nodes[:, :2], nodes[:, 0] ** 2])
    ply = Lamina(E1=140.0, E2=10.0, nu12=0.3, G12=5.0)
    for make, code in (
        (lambda: Surface.of(roof, cells), "normals"),
        (lambda: Surface.of(roof, cells, normals=0 * roof), "normals"),
        (lambda: Surface.of(nodes, cells[:-1]), "nodes"),
        (lambda: Surface.of(nodes, np.vstack([cells[:1, [0, 2, 1, 3]], cells[1:]])), "cell-turned"),
        (lambda: Surface.of(nodes, cells, normals=np.array([0, 0, -1.0]) + 0 * nodes), "cell-turned"),
        (lambda: Surface.of(nodes, cells[:, :3]), "input"),
        (lambda: shell(flat, MATERIAL, 0.1, smooth=True), "smooth"),
        (lambda: shell(flat, MATERIAL, np.linspace(-0.1, 0.2, 9)), "not-positive"),
        (lambda: shell(flat, MATERIAL, [0.1, 0.2]), "input"),
        (lambda: shell(flat, Laminate([(ply, 0.1, 0.0)]), np.linspace(0.1, 0.2, 9)), "thickness"),
        (lambda: shell(flat, ply, 0.1, thick=True), "thick-layers"),
    ):
        with refused(fc.InputError, code):
            make()
    assert shell(
        Surface.of(roof, cells, normals=np.stack([-2 * roof[:, 0], 0 * roof[:, 0], 1 + 0 * roof[:, 0]], 1)), ply, 0.1
    )
