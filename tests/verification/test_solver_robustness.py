"""Stability of the solvers on a half-space pressed by a paraboloid: units, ill-made compliances, starts, cycling.

Forces may be non-unique where the compliance is singular; the gap, the motion and the resultants are unique, and it
is these that are compared.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.sparse.linalg import LinearOperator
from solver_cases import half_space

from fecontact.solvers import ContactProblem, Solution, available_solvers, solve

Row = Callable[..., float]
ANY_COMPLIANCE = ("auto", "nnls")


def pressed_half_space(size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """S, g and B (force and two moments): radius 1, E* = 1, point loads on a square grid (Boussinesq)."""
    problem = half_space(size, 3)
    return problem.S, problem.g, problem.B


HERTZ_LOAD = np.array([4 / 3, 0.0, 0.0])
"""Presses a contact radius of 1 and an approach of 1."""


def assert_same(
    problem: ContactProblem, first: Solution, second: Solution, tolerance: float, row: Row, case: str
) -> None:
    deflection = np.abs(problem.S @ first.forces).max()
    row(case, "largest gap change", 0.0, np.abs(first.gap - second.gap).max() / deflection, tolerance)
    assert np.abs(problem.S @ (first.forces - second.forces)).max() <= tolerance * deflection
    resultants = problem.B @ (first.forces - second.forces)
    assert np.abs(resultants).max() <= tolerance * np.abs(problem.B).max() * first.forces.sum()


def test_hertz(row: Row) -> None:
    """A paraboloid on a half-space of point loads, all solvers' common problem.

    Source: Hertz. Cells of 0.07 a: the point-load compliance and the jagged edge cost about one percent.
    """
    S, g, B = pressed_half_space(41)
    solution = solve(ContactProblem(S=S, g=g, B=B, F=HERTZ_LOAD))
    radius = np.sqrt(2.5 * (solution.forces @ (2 * g)) / solution.forces.sum())
    # cells of 0.07 a: the point-load compliance and the jagged edge cost about one per cent
    row("15 half-space of 41 x 41 points", "contact radius", 1.0, radius, 0.01)
    row("15 half-space of 41 x 41 points", "approach", 1.0, -solution.q[0], 0.01)
    pressure = solution.forces.max() / (2.8 / 40) ** 2
    row("15 half-space of 41 x 41 points", "peak pressure", 2 / np.pi, pressure, 0.02)


@pytest.mark.by_day("1e-09-0.001", "1000000000.0-1000.0")
@pytest.mark.parametrize("length", [1e-3, 1e3])
@pytest.mark.parametrize("modulus", [1e-9, 1e9])
def test_units(length: float, modulus: float, row: Row) -> None:
    """Units of the complementarity problem.

    Source: the same problem in other units. 1e-9: nothing but rounding, times the condition of S (about 1e3).
    """
    S, g, B = pressed_half_space(13)
    first = solve(ContactProblem(S=S, g=g, B=B, F=HERTZ_LOAD))
    force, arms = modulus * length**2, np.array([1.0, length, length])
    other = ContactProblem(S=S / (modulus * length), g=g * length, B=B * arms[:, None], F=HERTZ_LOAD * force * arms)
    second = solve(other)
    # 1e-9: nothing but rounding, times the condition of S (about 1e3)
    change = np.abs(first.forces - second.forces / force).max() / first.forces.max()
    row(f"14 lengths x {length:g}, moduli x {modulus:g}, solver", "largest force change", 0.0, change, 1e-9)
    assert np.abs(first.gap - second.gap / length).max() <= 1e-9 * first.gap.max()
    assert np.abs(first.q - second.q * arms / length).max() <= 1e-9
    for name in ("penetration", "tension", "complementarity", "equilibrium"):
        assert abs(getattr(first.residuals, name) - getattr(second.residuals, name)) <= 1e-12


@pytest.mark.parametrize("distance", [1e2, 1e4])
def test_moments_about_a_far_point(distance: float, row: Row) -> None:
    """Moments of the load about a far point.

    Source: the same problem with moments about the middle. The moment about the far point carries its rounding,
    distance times 2e-16, into the forces, here times 100.
    """
    S, g, B = pressed_half_space(13)
    first = solve(ContactProblem(S=S, g=g, B=B, F=HERTZ_LOAD))
    shift = np.array([[0.0], [distance], [0.0]])
    F = HERTZ_LOAD + shift[:, 0] * HERTZ_LOAD[0]
    second = solve(ContactProblem(S=S, g=g, B=B + shift * B[:1], F=F))
    # the moment about the far point carries its rounding, distance times 2e-16, into the forces, here times 100
    change = np.abs(first.forces - second.forces).max() / first.forces.max()
    case = f"14 moments about a point {distance:g} away"
    row(case, "largest force change", 0.0, change, max(1e-9, 1e-13 * distance))


@pytest.mark.by_day("False-4")
@pytest.mark.parametrize(("si", "finer"), [(False, 4), (False, 10), (True, 10)])
def test_candidates_much_finer_than_the_mesh(si: bool, finer: int, row: Row) -> None:
    """A surface of 5 x 5 nodes seen through up to 50 x 50 candidates: a compliance of rank 25 of 2500, also in SI."""
    S, _, _ = pressed_half_space(5)
    nodes, points = np.linspace(-1.4, 1.4, 5), np.linspace(-1.4, 1.4, 5 * finer)
    hat = np.maximum(0.0, 1 - np.abs(points[:, None] - nodes) / (nodes[1] - nodes[0]))
    N = np.kron(hat, hat)
    x, y = (each.ravel() for each in np.meshgrid(points, points))
    g, B = (x**2 + y**2) / 2, np.vstack([np.ones_like(x), x, y])
    # SI: compliance 1e-12 m/N, gaps 1e-6 m, arms in 1e-3 m
    compliance, length, arms = (1e-12, 1e-6, np.array([1.0, 1e-3, 1e-3])) if si else (1.0, 1.0, np.ones(3))
    problem = ContactProblem(
        S=N @ S @ N.T * compliance,
        g=g * length,
        B=B * arms[:, None],
        F=HERTZ_LOAD * arms * length / compliance,
    )
    reference = solve(problem, "osqp")
    for solver in ANY_COMPLIANCE:
        case = f"15 candidates {finer} times finer than the mesh, {solver}{', SI' if si else ''}"
        assert_same(problem, reference, solve(problem, solver), 1e-8, row, case)


@pytest.mark.parametrize("solver", ANY_COMPLIANCE)
def test_duplicates_and_bad_scaling_together(solver: str, row: Row) -> None:
    """Twin candidates and rows scaled by 1e-8 to 1e8.

    Source: the problem without. Forces of twins added up are those of the single point.
    """
    S, g, B = pressed_half_space(11)
    rng = np.random.default_rng(4)
    picked = np.concatenate([np.arange(121), rng.integers(0, 121, 60)])
    d = 10.0 ** rng.uniform(-8, 8, picked.size)
    problem = ContactProblem(
        S=S[np.ix_(picked, picked)] * d * d[:, None], g=g[picked] * d, B=B[:, picked] * d, F=HERTZ_LOAD
    )
    plain = solve(ContactProblem(S=S, g=g, B=B, F=HERTZ_LOAD))
    solution = solve(problem, solver)
    merged = np.bincount(picked, weights=solution.forces * d, minlength=121)
    # the forces of twins added up are those of the single point
    change = np.abs(merged - plain.forces).max() / plain.forces.max()
    row(f"15 twins and scales of 1e16, {solver}", "largest force change", 0.0, change, 1e-8)
    assert np.abs(solution.gap / d - plain.gap[picked]).max() <= 1e-8 * plain.gap.max()


@pytest.mark.parametrize("solver", available_solvers())
def test_every_solver_on_one_problem(solver: str, row: Row) -> None:
    """Every solver under an eccentric load.

    Source: the default solver. Every answer is sharpened on its set, so they differ by rounding only.
    """
    S, g, B = pressed_half_space(15)
    problem = ContactProblem(S=S, g=g, B=B, F=np.array([4 / 3, 0.2, -0.1]))
    reference, solution = solve(problem), solve(problem, solver)
    # an eccentric load; every answer is sharpened on its set, so they differ by rounding only
    change = np.abs(reference.forces - solution.forces).max() / reference.forces.max()
    row(f"15 eccentric load, {solver}", "largest force change", 0.0, change, 1e-8)
    assert np.abs(reference.q - solution.q).max() <= 1e-8


@pytest.mark.parametrize("load", [1e-2, 1e-6, 1e-12])
def test_light_loads(load: float, row: Row) -> None:
    """Loads down to 1e-12.

    Source: Wolfe's simplex method on the same problem, which shares nothing with the default one.
    """
    S, g, B = pressed_half_space(13)
    problem = ContactProblem(S=S, g=g, B=B, F=HERTZ_LOAD * load)
    solution = solve(problem)
    assert abs(solution.forces.sum() - 4 / 3 * load) <= 1e-9 * load
    assert_same(problem, solve(problem, "wolfe"), solution, 1e-8, row, f"18 load x {load:g}")


def test_many_patches_with_ties_from_any_start(row: Row) -> None:
    """Sixteen patches alike, from random starts: ties and cycling.

    Source: symmetry; the answer from the default start. At most 100 steps for 400 points.
    """
    S, g, B = pressed_half_space(5)
    patches = 16
    compliance = block_diag(*[S] * patches)
    gap = np.tile(g, patches)
    far = np.repeat(np.arange(patches, dtype=float), 25)
    rows = np.vstack([np.ones_like(gap), far - far.mean(), np.tile(B[1], patches)])
    problem = ContactProblem(S=compliance, g=gap, B=rows, F=np.array([patches * 4 / 3, 0.0, 0.0]))
    reference = solve(problem)
    # all patches are alike, and so are their shares
    share = reference.forces.reshape(patches, -1).sum(axis=1)
    row("19 sixteen patches alike", "largest difference of a share", 0.0, np.abs(share - 4 / 3).max(), 1e-9)
    rng, worst = np.random.default_rng(0), 0.0
    for _ in range(12):
        start = rng.random(problem.n) < rng.random()
        solution = solve(problem, start=start)
        # 400 points: even the hardest start must not wander
        assert solution.nit <= 100
        worst = max(worst, np.abs(solution.forces - reference.forces).max() / reference.forces.max())
    row("19 sixteen patches, 12 random starts", "largest force change", 0.0, worst, 1e-8)


def test_an_operator_of_ten_thousand_points(row: Row) -> None:
    """Convolution by fast Fourier transforms on 101 x 101 cells: the array would take 0.8 GB."""
    size, half_width = 101, 1.4
    h = 2 * half_width / (size - 1)
    lag = np.arange(-(size - 1), size) * h
    distance = np.hypot(lag[:, None], lag)
    distance[size - 1, size - 1] = h / (4 * np.log(1 + np.sqrt(2)))
    shape = (2 * size - 1, 2 * size - 1)
    kernel = np.fft.rfft2(np.fft.ifftshift(1 / (np.pi * distance)))

    def deflect(forces: np.ndarray) -> np.ndarray:
        spectrum = np.fft.rfft2(forces.reshape(size, size), shape)
        return np.fft.irfft2(kernel * spectrum, shape)[:size, :size].ravel()

    line = np.linspace(-half_width, half_width, size)
    x, y = (each.ravel() for each in np.meshgrid(line, line))
    S = LinearOperator((size**2, size**2), matvec=deflect, dtype=float)
    problem = ContactProblem(
        S=S, g=(x**2 + y**2) / 2, B=np.vstack([np.ones_like(x), x, y]), F=np.array([4 / 3, 0.0, 0.0])
    )
    solution = solve(problem)
    radius = np.sqrt(2.5 * (solution.forces @ (x**2 + y**2)) / solution.forces.sum())
    # cells of 0.028 a
    row("15 operator of 101 x 101 points", "contact radius", 1.0, radius, 0.004)
    row("15 operator of 101 x 101 points", "approach", 1.0, -solution.q[0], 0.004)
