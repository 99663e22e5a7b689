import numpy as np
import pytest

from fecontact import Material
from fecontact.analytic import curved_kernel
from fecontact.halfspace.fft import InclinedTerm

RUBBER = Material(2.0, 0.45)
CELL = (0.02, 0.03)


def _term(shape, mirrored=(False, False), n=1):
    """A bowl, of which a half or a quarter is modelled where it is mirrored."""
    cell = (n * CELL[0], n * CELL[1])
    x, y = (
        (np.arange(m) + 0.5) * side if even else (np.arange(m) - (m - 1) / 2) * side
        for m, side, even in zip(shape, cell, mirrored, strict=True)
    )
    depth = 0.3 * x[:, None] ** 2 + 0.2 * y**2
    slopes = np.stack(np.broadcast_arrays(0.6 * x[:, None], 0.4 * y), axis=-1)
    return InclinedTerm(depth, slopes, cell, RUBBER, mirrored)


def _pressure(shape):
    return np.random.default_rng(2).uniform(0, 1, shape)


@pytest.mark.parametrize("mirrored", [(False, False), (True, False), (False, True), (True, True)])
def test_products_are_sums_over_pairs_of_cells(mirrored):
    term = _term((7, 6), mirrored)
    p = _pressure((7, 6))
    cells = np.arange(42)
    among = term.among(cells)
    np.testing.assert_allclose(among, among.T, rtol=0, atol=1e-18)
    found = term.apply(p).ravel()
    np.testing.assert_allclose(found, among @ p.ravel() * CELL[0] * CELL[1], rtol=0, atol=1e-13 * found.max())
    whole = p
    for axis in (0, 1):
        if mirrored[axis]:
            whole = np.concatenate([np.flip(whole, axis), whole], axis=axis)
    at = [0 if not even else n for even, n in zip(mirrored, (7, 6), strict=True)]
    every = _term(whole.shape).apply(whole)[at[0] :, at[1] :]
    np.testing.assert_allclose(term.apply(p), every, rtol=0, atol=1e-13 * found.max())


def test_pairs_have_the_kernel_of_two_places():
    term = _term((9, 9))
    cells = np.array([3, 71])
    i, j = np.divmod(cells, 9)
    offset = np.array([(i[1] - i[0]) * CELL[0], (j[1] - j[0]) * CELL[1], np.diff(term.depth.ravel()[cells])[0]])
    options = {"curvature": np.zeros((2, 2)), "length": 1.0, "material": RUBBER}
    exact = curved_kernel.displacement(offset, **options)
    flat = curved_kernel.displacement(offset * [1, 1, 0], **options)
    # slope^4 beside slope^2, slope 0.1; the cell beside its middle, (1/7)^2/8
    assert term.among(cells)[0, 1] == pytest.approx(exact - flat, rel=0.03)


def test_parts_are_parts():
    term = _term((12, 10))
    part = (slice(2, 9), slice(1, 8))
    p = np.zeros((12, 10))
    p[part] = _pressure((7, 7))
    found = term.part(part).apply(p[part])
    np.testing.assert_allclose(found, term.apply(p)[part], rtol=0, atol=1e-13 * found.max())


def test_coarser_cells_give_nearly_the_same():
    term = _term((33, 24), (False, True))
    coarse = term.coarser()
    assert coarse.depth.shape == (17, 12)
    x, y = np.meshgrid(np.linspace(-1, 1, 33), np.linspace(0, 1, 24), indexing="ij")
    smooth = np.maximum(1 - x**2 - y**2, 0)
    fine = term.apply(smooth)[8:24:2, ::2]
    assert coarse.apply(smooth[::2, ::2])[4:12] == pytest.approx(fine, rel=0.15)  # two cells off in a bowl


def test_single_precision_is_nearly_double():
    term = _term((40, 40))
    p = _pressure((40, 40))
    exact = term.apply(p)
    found = term.rough.apply(p)
    assert 0 < np.abs(found - exact).max() < 1e-4 * np.abs(exact).max()  # roundings of 6e-8, times cells across


def test_a_common_height_does_nothing():
    term = _term((8, 8))
    raised = InclinedTerm(term.depth + 1e3, term.slopes, term.cell, term.material, term.mirrored)
    p = _pressure((8, 8))
    np.testing.assert_allclose(raised.apply(p), term.apply(p), rtol=1e-9)
