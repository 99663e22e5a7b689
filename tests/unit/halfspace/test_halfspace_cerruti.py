"""Kernels of tangential tractions against quadrature and Love's."""

import numpy as np
import pytest
from scipy.integrate import dblquad

from fecontact.halfspace import kernels
from fecontact.halfspace.kernels import cerruti

KERNELS = {
    "xx": lambda x, y: x * x / np.hypot(x, y) ** 3,
    "yy": lambda x, y: y * y / np.hypot(x, y) ** 3,
    "xy": lambda x, y: x * y / np.hypot(x, y) ** 3,
    "x": lambda x, y: x / (x * x + y * y),
    "y": lambda x, y: y / (x * x + y * y),
}


@pytest.mark.parametrize("cell", [(1.0, 1.0), (0.3, 1.0)])
@pytest.mark.parametrize("name", KERNELS)
def test_cells_by_quadrature(cell, name):
    table = getattr(cerruti((70, 70), cell), name)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for i, j in ((1, 0), (0, 1), (3, 2), (31, 5), (32, 31), (33, 0), (33, 34), (69, 69)):
        x, y = (i + nodes[:, None] / 2) * cell[0], (j + nodes[None, :] / 2) * cell[1]
        exact = weights @ KERNELS[name](x, y) @ weights / 4 * cell[0] * cell[1]
        # 60 Gauss points are exact to 1e-9 next to the singular cell; second differences to 1e-12 at offset 32
        assert table[i, j] == pytest.approx(exact, rel=3e-9, abs=1e-13)


@pytest.mark.parametrize("cell", [(1.0, 1.0), (1.0, 0.2)])
def test_the_cell_itself(cell):
    tables = cerruti((2, 2), cell)
    exact = 4 * dblquad(KERNELS["xx"], 0, cell[1] / 2, 0, cell[0] / 2)[0]  # dblquad's function takes (inner, outer)
    assert tables.xx[0, 0] == pytest.approx(exact, rel=1e-6)
    assert (tables.xy[0, 0], tables.x[0, 0], tables.y[0, 0]) == (0, 0, 0)


def test_squares_add_up_to_love():
    tables = cerruti((150, 90), (1.0, 0.6))
    total = (tables.xx + tables.yy) / np.pi
    np.testing.assert_allclose(total, kernels.love((150, 90), (1.0, 0.6)), rtol=1e-11)


def test_axes_can_be_exchanged():
    one, other = cerruti((40, 50), (1.0, 0.6)), cerruti((50, 40), (0.6, 1.0))
    for name, twin in (("xx", "yy"), ("xy", "xy"), ("x", "y")):
        np.testing.assert_allclose(getattr(one, name), getattr(other, twin).T, rtol=1e-11, atol=1e-13)
