"""Influence coefficients against closed forms, quadrature and each other."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import layer as exact_layer
from fecontact.analytic import rectangle
from fecontact.bodies.halfspace import kernels, layered
from fecontact.common.errors import InputError


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 0.1), (0.02, 0.05)])
def test_love_against_the_rectangle(cell):
    table = kernels.love((150, 200), cell)
    i, j = np.array([0, 1, 5, 20, 31, 32, 33, 149]), np.array([0, 3, 31, 32, 33, 100, 199])
    exact = rectangle.surface_displacement(
        (i * cell[0])[:, None],
        (j * cell[1])[None, :],
        half_sides=(cell[0] / 2, cell[1] / 2),
        pressure=1.0,
        modulus=1.0,
    )
    # rounding of the second difference near, dropped sixth-order term far: both 2e-12 at the switch
    assert np.abs(table[np.ix_(i, j)] / exact - 1).max() < 1e-11


def test_bilinear_is_the_mean_of_love_over_a_cell():
    table = kernels.bilinear((30, 30), (1.0, 0.5))
    t, w = np.polynomial.legendre.leggauss(12)
    for i, j in ((3, 0), (5, 7), (0, 9), (25, 29)):
        x, y = i + t / 2, 0.5 * (j + t / 2)
        u = rectangle.surface_displacement(x[:, None], y[None, :], half_sides=(0.5, 0.25), pressure=1.0, modulus=1.0)
        # 12-point Gauss over a cell at least one cell away, and 5e-10 of the fourth difference
        assert abs(w @ u @ w / 4 / table[i, j] - 1) < 2e-9


def test_bilinear_self_term():
    # mean over the unit square of 1/r to itself: 4 ln(1 + sqrt 2) + 4 (1 - sqrt 2)/3 (Eibert & Hansen 1995)
    exact = (4 * np.log(1 + np.sqrt(2)) + 4 * (1 - np.sqrt(2)) / 3) / np.pi
    assert abs(kernels.bilinear((2, 2), (1.0, 1.0))[0, 0] / exact - 1) < 1e-14


def test_points_far_away_are_rectangles():
    points, love = kernels.points((64, 64), (1.0, 1.0)), kernels.love((64, 64), (1.0, 1.0))
    # the second moment of a cell counts 1/24 of the square of its size over the distance
    assert np.abs(points[40:, 40:] / love[40:, 40:] - 1).max() < 2e-5
    assert points[0, 0] == 2 * points[0, 1]


def test_points_with_a_small_self_term_are_refused():
    with pytest.raises(InputError, match=r"exceed 1\.6156"):
        kernels.points((4, 4), (1.0, 1.0), 1.5)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.4999])
@pytest.mark.parametrize("base", ["bonded", "frictionless"])
def test_one_layer_on_a_rigid_base(nu, base):
    material = fc.Material(E=2.0, nu=nu)
    k = np.array([1e-3, 1e-2, 0.1, 1.0, 3.0, 10.0, 100.0])
    found = layered.compliance(k, [layered.Layer(material, 0.7, base)], None) / k
    # four fields that nearly coincide at k h = 1e-3: 1e-16 (k h)^-3 (1 - 2 nu)^-1 at the worst
    assert np.abs(found / exact_layer.compliance(k, 0.7, material, base) - 1).max() < 1e-8


def test_layers_of_one_material_are_one_layer():
    stiff, soft = fc.Material(3.0, 0.2), fc.Material(1.0, 0.4)
    k = np.geomspace(1e-2, 100.0, 30)
    two = layered.compliance(k, [layered.Layer(stiff, 0.5), layered.Layer(stiff, 0.7)], soft)
    one = layered.compliance(k, [layered.Layer(stiff, 1.2)], soft)
    assert np.abs(two / one - 1).max() < 1e-12  # rounding of two small linear systems
    # short waves see the top, long waves the base
    assert abs(two[-1] / (2 / stiff.plane_strain_modulus) - 1) < 1e-12
    assert abs(two[0] / (2 / soft.plane_strain_modulus) - 1) < 0.02  # k h = 0.012


def test_frictionless_interface_is_softer():
    stiff, soft = fc.Material(3.0, 0.2), fc.Material(1.0, 0.4)
    k = np.geomspace(0.1, 3.0, 10)
    bonded = layered.compliance(k, [layered.Layer(stiff, 1.0)], soft)
    assert (layered.compliance(k, [layered.Layer(stiff, 1.0, "frictionless")], soft) > bonded).all()


def test_layered_table_of_the_same_material_is_love():
    soft = fc.Material(E=1.0, nu=0.3)
    table = layered.table((20, 30), (0.1, 0.07), [layered.Layer(soft, 0.5)], soft)
    love = kernels.love((20, 30), (0.1, 0.07)) / soft.plane_strain_modulus
    assert np.abs(table / love - 1).max() < 1e-12  # the difference is zero up to rounding


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"thickness": 0.0}, "thickness"), ({"thickness": 1.0, "interface": "glued"}, "'bonded', 'frictionless'")],
)
def test_bad_layers(arguments, message):
    with pytest.raises(InputError, match=message):
        layered.Layer(fc.Material(1.0, 0.3), **arguments)
