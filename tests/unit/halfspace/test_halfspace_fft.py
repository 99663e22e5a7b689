"""Convolutions against direct sums; nested grids."""

import numpy as np
import pytest
from refusals import refused

from fecontact import InputError
from fecontact.halfspace import Grid, kernels
from fecontact.halfspace.fft import ROUGHNESS, Convolution, Tally, kernel_spectrum, padded
from fecontact.halfspace.grid import even_axes, part_of, unfold
from fecontact.halfspace.nested import GridLevel, around, finer, start_on


def direct(p, table):
    nx, ny = p.shape
    dx, dy = (
        np.abs(np.subtract.outer(np.arange(nx), np.arange(nx))),
        np.abs(np.subtract.outer(np.arange(ny), np.arange(ny))),
    )
    return np.einsum("ikjl,kl->ij", table[dx[:, :, None, None], dy[None, None]], p)


@pytest.mark.parametrize("shape", [(12, 10), (7, 16), (2, 31), (33, 5)])
def test_free_convolution(shape):
    table = kernels.love(shape, (1.0, 0.7))
    p = np.random.default_rng(0).random(shape)
    spectrum = kernel_spectrum(table, (padded(shape[0]), padded(shape[1])))
    found = Convolution.even(spectrum, shape, (False, False), Tally(1)).apply(p)
    exact = direct(p, table)
    assert np.abs(found - exact).max() < 1e-13 * exact.max()  # rounding of a transform


@pytest.mark.parametrize("units", [1.0, 1e-30, 1e45])
@pytest.mark.parametrize("shape", [(12, 10), (7, 16), (64, 48)])
def test_single_precision_errs_by_its_bound_in_any_units(shape, units):
    table = kernels.love(shape, (1.0, 0.7))
    p = np.random.default_rng(2).standard_normal(shape)
    spectrum = kernel_spectrum(units * table, (padded(shape[0]), padded(shape[1])))
    rough = Convolution.even(spectrum, shape, (False, False), Tally(1)).rough
    exact = direct(p, table)
    for size in (1.0, 1e-60, 1e60):
        found = rough.apply(size * p) / (size * units)
        assert found.dtype == np.float64
        assert 0 < np.abs(found - exact).max() < ROUGHNESS * np.abs(exact).max()
    assert np.array_equal(rough.apply(np.zeros(shape)), np.zeros(shape))


@pytest.mark.parametrize("symmetric", [(True, True), (True, False), (False, True)])
def test_symmetric_convolution(symmetric):
    shape = (12, 10)
    p = np.random.default_rng(1).random(shape)
    for axis in (0, 1):
        p = p + np.flip(p, axis) if symmetric[axis] else p
    table = kernels.love(shape, (1.0, 0.7))
    part = part_of(shape, symmetric)
    spectrum = kernel_spectrum(table, (padded(12), padded(10)))
    half = Convolution.even(spectrum, p[part].shape, symmetric, Tally(1)).apply(p[part])
    exact = direct(p, table)
    assert np.abs(unfold(half, symmetric) - exact).max() < 1e-13 * exact.max()  # rounding of a transform
    assert even_axes(p, p > 0, np.ones((1, *shape))) == symmetric


def test_strips_of_columns_make_no_difference(monkeypatch):
    p = np.random.default_rng(2).random((40, 60))
    spectrum = kernel_spectrum(kernels.love((40, 60), (1.0, 1.0)), (40, 60))
    convolution = Convolution.even(spectrum, (40, 60), (False, False), Tally(1))
    whole = convolution.apply(p)
    monkeypatch.setattr("fecontact.halfspace.fft.STRIP", 1)
    assert np.abs(convolution.apply(p) - whole).max() < 1e-14 * whole.max()


def test_threads_make_no_difference(monkeypatch):
    monkeypatch.setattr("fecontact.halfspace.fft.STRIP", 500)
    p = np.random.default_rng(2).random((40, 60))
    spectrum = kernel_spectrum(kernels.love((40, 60), (1.0, 1.0)), (40, 60))
    one, two = (Convolution.even(spectrum, (40, 60), (False, False), Tally(1), workers=n) for n in (1, 2))
    assert np.array_equal(one.apply(p), two.apply(p))
    assert np.array_equal(one.rough.apply(p), two.rough.apply(p))


@pytest.mark.parametrize("threads", [1, 2])
def test_fields_are_convolved_with_a_matrix_of_kernels(monkeypatch, threads):
    monkeypatch.setattr("fecontact.halfspace.fft.STRIP", 200)
    nx, ny, rng = 9, 7, np.random.default_rng(3)
    full = rng.standard_normal((2, 2, 2 * nx, 2 * ny))  # kernels neither even nor odd, by offsets that wrap
    kernels = tuple(tuple(np.fft.rfft2(one) for one in row) for row in full)
    values = rng.standard_normal((2, nx, ny))
    values[1] *= 1e-3
    dx, dy = (np.subtract.outer(np.arange(n), np.arange(n)) for n in (nx, ny))
    exact = np.einsum("jkacbd,kcd->jab", full[:, :, dx[:, :, None, None], dy[None, None]], values)
    product = Convolution(kernels, (nx, ny), (2 * nx, 2 * ny), workers=threads)
    assert np.abs(product.apply(values) - exact).max() < 1e-13 * np.abs(exact).max()  # rounding of a transform
    assert 0 < np.abs(product.rough.apply(1e30 * values) / 1e30 - exact).max() < ROUGHNESS * np.abs(exact).max()
    assert not product.apply(np.zeros((2, nx, ny))).any()
    lone = Convolution(((kernels[0][0], None), (None, None)), (nx, ny), (2 * nx, 2 * ny), workers=threads).apply(values)
    assert lone[0].any()
    assert not lone[1].any()


def test_tally_counts_transforms():
    tally = Tally(4 * 16 * 16)
    spectrum = kernel_spectrum(kernels.love((16, 16), (1.0, 1.0)), (16, 16))
    Convolution.even(spectrum, (16, 16), (False, False), tally).apply(np.ones((16, 16)))
    Convolution.even(spectrum, (8, 8), (True, True), tally, product=False).apply(np.ones((8, 8)))
    assert (tally.products, tally.transforms) == (1, 2.5)


@pytest.mark.parametrize("n", [6, 7])
def test_interpolation_reproduces_linear_values(n):
    coarse = Grid((7.0, 7.0), (n, n)).coarser
    values = 2.0 + 3.0 * coarse.x[:, None] - coarse.y[None, :]
    fine = finer(values, (n, n), (False, False), False)
    # inside, where no border value is repeated
    x, y = coarse.x[0] - coarse.cell[0] / 4, coarse.y[0] - coarse.cell[1] / 4
    X = x + np.arange(n) * coarse.cell[0] / 2
    Y = y + np.arange(n) * coarse.cell[1] / 2
    exact = 2.0 + 3.0 * X[:, None] - Y[None, :]
    assert np.abs((fine - exact)[1:-1, 1:-1]).max() < 1e-13


@pytest.mark.parametrize("symmetric", [(False, False), (True, False), (True, True)])
def test_the_start_ends_where_the_pressure_does(symmetric):
    # Hertz: squares fall linearly to the edge, whose place within the coarse cells is found
    coarse, fine = Grid((3.0, 3.0), (48, 48)), Grid((3.0, 3.0), (96, 96))
    part = part_of(fine.shape, symmetric)
    r = np.hypot(fine.x[:, None], fine.y)[part]
    level = GridLevel(np.zeros((0, 0)), False, 0 * r, r > -1, np.zeros((0, *r.shape)), np.zeros(0), symmetric)
    given = np.sqrt(np.maximum(1 - coarse.x[:, None] ** 2 - coarse.y**2, 0.0))[part_of(coarse.shape, symmetric)]
    start, active = start_on(level, given)
    assert np.abs(r - 1)[active != (r < 1)].max(initial=0.0) < 0.5 * fine.cell[0]
    assert np.array_equal(active, start > 0)
    inside = r < 0.9
    assert np.abs(start - np.sqrt(np.maximum(1 - r**2, 0.0)))[inside].max() < 2e-3  # interpolation of a parabola
    linear = np.linalg.norm(finer(given, r.shape, symmetric, False) - np.sqrt(np.maximum(1 - r**2, 0.0)))
    assert np.linalg.norm(start - np.sqrt(np.maximum(1 - r**2, 0.0))) < 0.5 * linear


def test_the_part_round_a_contact_holds_it():
    active = np.zeros((100, 80), bool)
    active[40:60, 70:79] = True
    part = around(active, (False, False))
    assert part[0].start <= 38
    assert part[0].stop >= 62
    assert part[1].stop == 80
    assert active[part].sum() == active.sum()


@pytest.mark.parametrize(
    ("size", "shape", "code"),
    [
        ((1.0, -1.0), (4, 4), "not-positive"),
        ((1.0, 1.0), (1, 4), "grid-shape"),
        ((1.0, 1.0), (4.5, 4), "grid-shape"),
        (1.0, (4, 4), "not-positive"),
    ],
)
def test_bad_grids(size, shape, code):
    with refused(InputError, code, "grid"):
        Grid(size, shape)
