"""Compliances of cells by themselves beside that of the bodies: springs on the surface, or what wears off in a step."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.halfspace.fft import DiagonalTerm
from fecontact.halfspace.pressing import Load, press
from fecontact.solvers import ContactProblem, solve

PLAIN = fc.Material(E=1.0, nu=0.0)


def test_pressures_are_those_of_a_dense_problem_with_a_diagonal() -> None:
    half = fc.HalfSpace(PLAIN, size=(2.0, 1.6), cells=(12, 10))
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    z, own = x**2 + 0.7 * y**2, 0.3 + x + x**2 + y**2
    found = press(half.compliance, z, Load(0.05, None, None), 1e-12, True, None, own=own, boxed=False)
    unit = np.zeros(z.shape)
    S = np.empty((z.size, z.size))
    for k in range(z.size):
        unit.ravel()[k] = 1.0
        S[:, k] = half._cells.product.apply(unit).ravel()
        unit.ravel()[k] = 0.0
    area = half.grid.area
    exact = solve(ContactProblem(S / area + np.diag(own.ravel()) / area, z.ravel(), np.ones((1, z.size)), [0.05]))
    p = exact.forces.reshape(z.shape) / area
    np.testing.assert_allclose(found.pressure, p, rtol=0, atol=1e-9 * p.max())
    # the displacement is that of the bodies, the gap has both
    np.testing.assert_allclose(found.displacement.ravel(), S @ p.ravel(), rtol=0, atol=1e-9)
    gap = found.displacement + own * found.pressure + z - found.approach
    np.testing.assert_allclose(found.gap, gap, rtol=0, atol=1e-12)
    assert np.abs(found.gap[found.active]).max() < 1e-9


@pytest.mark.parametrize("periodic", [False, True])
def test_a_large_one_makes_the_pressure_of_a_flat_punch_uniform(periodic: bool) -> None:
    half = fc.HalfSpace(PLAIN, size=(2.6, 2.6), cells=(32, 32), periodic=periodic)
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    punch = np.where(r <= 1, 0.0, np.inf)
    plain = press(half.compliance, punch, Load(0.01, None, None), 1e-10, True, None)
    for size, most in ((0.0, 4.0), (1e5, 1e-4)):
        own = np.full(punch.shape, size)
        p = press(half.compliance, punch, Load(0.01, None, None), 1e-10, True, None, own=own).pressure[r <= 1]
        assert abs(p / p.mean() - 1).max() < most
        if not size:  # none is as if it were not there
            np.testing.assert_allclose(p, plain.pressure[r <= 1], rtol=1e-9)


def test_terms_of_parts_and_larger_cells() -> None:
    term = DiagonalTerm(np.arange(16.0).reshape(4, 4), 0.5)
    part = term.part((slice(0, 2), slice(1, 3)))
    assert part.own.tolist() == [[1.0, 2.0], [5.0, 6.0]]
    assert part.among(np.array([1, 2])).tolist() == [[4.0, 0.0], [0.0, 10.0]]
    assert term.coarser().own.tolist() == [[2.5, 4.5], [10.5, 12.5]]
    assert term.coarser().area == 2.0
