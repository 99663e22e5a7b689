"""Influence coefficients against closed forms, quadrature and each other."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.analytic import layer as exact_layer
from fecontact.analytic import rectangle
from fecontact.halfspace import kernels, layered


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
    with refused(InputError, "ratio-too-small", "1.6156"):
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
    [
        ({"thickness": 0.0}, ("not-positive", "A layer's thickness")),
        ({"thickness": 1.0, "interface": "glued"}, ("unknown-name", "'bonded', 'frictionless'")),
    ],
)
def test_bad_layers(arguments, message):
    with refused(InputError, *message):
        layered.Layer(fc.Material(1.0, 0.3), **arguments)


SOFT, STEEL, GLASS = fc.Material(10.0, 0.45), fc.Material(210e3, 0.3), fc.Material(70e3, 0.22)


@pytest.mark.parametrize(
    ("materials", "base"), [([SOFT], STEEL), ([STEEL], SOFT), ([SOFT], None), ([GLASS, SOFT], STEEL)]
)
@pytest.mark.parametrize("thickness", [0.4, 0.1, 0.04])
def test_cells_wider_than_a_layer_are_the_sum_of_small_ones(materials, base, thickness):
    layers = [layered.Layer(material, thickness) for material in materials]
    half, side = 37, 1 / 75
    weights = np.where(np.arange(half + 1) > 0, 2.0, 1.0)
    own = weights @ layered.table((half + 1, half + 1), (side, side), layers, base) @ weights
    table = layered.table((8, 8), (1.0, 1.0), layers, base)
    # the small cells are narrower than the layer, where the two-point rule is good to (1/3)^4/4320 of what varies
    assert abs(table[0, 0] / own - 1) < 1e-5


@pytest.mark.parametrize("materials", [[SOFT], [STEEL], [SOFT, STEEL]])
def test_layers_of_any_thickness_take_bounded_work(materials, monkeypatch):
    waves, solve = [], layered.surface_waves
    monkeypatch.setattr(layered, "surface_waves", lambda k, *a: waves.append(len(k)) or solve(k, *a))
    tables = {}
    for thickness in 10.0 ** -np.arange(0, 11, 2):
        waves.clear()
        layers = [layered.Layer(material, thickness) for material in materials]
        tables[thickness] = layered.table((64, 64), (0.1, 0.1), layers, GLASS)
        assert sum(waves) < 5e4  # grew as 1/thickness, to 3e11
    love = kernels.love((64, 64), (0.1, 0.1)) / GLASS.plane_strain_modulus
    assert np.abs(tables[1e-10] / love - 1).max() < 2e-5  # 1e-9 of a cell, as soft as 1/7000 of the base
    assert np.abs(tables[1e-10][1:] / love[1:] - 1).max() < 1e-12


def test_a_thin_layer_on_a_rigid_base_is_a_bed_of_springs():
    # Johnson 1985, section 5.8; cells of a twentieth of the contact's radius
    layer = layered.Layer(fc.Material(1.0, 0.3), 1e-6)
    half = fc.HalfSpace(None, (0.3, 0.3), (64, 64), layers=[layer])
    force, approach, peak = exact_layer.thin_compressible(radius=1.0, thickness=1e-6, material=layer.material, a=0.1)
    ball = half.press(fc.surfaces.Paraboloid(1.0), force=force)
    assert abs(ball.approach / approach - 1) < 2e-3
    assert abs(ball.max_pressure / peak - 1) < 2e-3
    with refused(InputError, "cells-too-wide"):
        ball.stress([[0.0, 0.0, -5e-7]])
    assert "thinner than half a cell" in ball.plot().axes[3].get_title()
    with refused(InputError, "cells-too-wide", "1e-06"):
        half.press(fc.surfaces.Paraboloid(1.0), force=force, friction=0.3)


def test_the_section_below_a_thin_layer_is_that_of_what_is_below():
    coated = fc.HalfSpace(STEEL, (0.6, 0.6), (32, 32), layers=[layered.Layer(SOFT, 1e-9)])
    bare = fc.HalfSpace(STEEL, (0.6, 0.6), (32, 32))
    one, other = (half.press(fc.Sphere(10.0), force=100.0) for half in (coated, bare))
    assert abs(one.approach / other.approach - 1) < 1e-3
    titles = [contact.plot().axes[3].get_title() for contact in (one, other)]
    assert titles[0].endswith("below 1 layer(s) thinner than half a cell")
    assert titles[1].count("\n") == 1


@pytest.mark.parametrize("base", [None, GLASS])
def test_a_table_does_not_depend_on_the_reach_for_which_layers_are_tabulated(base):
    layers = [layered.Layer(fc.Material(E=0.3, nu=0.45), 0.5), layered.Layer(GLASS, 0.2)]
    near, far = (layered.table((20, 12), (0.1, 0.1), layers, base, reach) for reach in (0.0, 8.0))
    assert np.abs(near - far).max() < 1e-9 * near[0, 0]  # of the splines, whose places differ
