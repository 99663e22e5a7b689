"""Contact problems for the solvers, easy and hard, as data: tests and docs/solvers.py share them.

The answer comes first. Forces l >= 0, gaps w >= 0 with l . w = 0 and a rigid motion q are chosen, and the problem is
made from them, g = w - S l - B^T q and F = B l. So what a solver finds is judged by something that no solver has
computed. Forces may be non-unique where S is singular; S l, the gap and the resultants are unique and are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from fecontact.solvers import ContactProblem, Solution, Status

HERTZ_LOAD = 4 / 3
"""Presses a paraboloid of radius 1 into a half-space of E* = 1 over a contact radius of 1, by an approach of 1."""

HALF_WIDTH = 1.4
"""Half the side of the grid of a half-space."""


@dataclass(frozen=True, eq=False)
class Case:
    """A problem, what makes it hard, and its answer.

    Attributes
    ----------
    what : str
        In words, for a table.
    problem : ContactProblem
    expected : Status
        ``solved``, ``no-contact``, ``infeasible`` or ``unbounded``.
    forces, gap : ndarray, shape (n,), or None
        The answer, where there is one.
    pinned : bool
        Whether the points in touch leave no rigid motion open, so that the gap is unique.
    """

    what: str
    problem: ContactProblem
    expected: Status = Status.SOLVED
    forces: np.ndarray | None = None
    gap: np.ndarray | None = None
    pinned: bool = True

    def error(self, solution: Solution) -> float:
        """Largest relative error of what is unique: S l, the resultants B l and, if it is pinned, the gap."""
        assert self.forces is not None
        assert self.gap is not None
        p = self.problem
        change = solution.forces - self.forces
        deflection = np.abs(p.S @ self.forces).max()
        scale = deflection if deflection > 0 else max(np.abs(p.g).max(), 1e-300)
        sums = np.abs(p.B).max(axis=1) * (self.forces.sum() or 1.0)
        errors = [np.abs(p.S @ change).max() / scale]
        errors += list(np.abs(p.B @ change)[sums > 0] / sums[sums > 0])
        if self.pinned:
            errors.append(np.abs(solution.gap - self.gap).max() / max(scale, np.abs(self.gap).max()))
        return float(max(errors))


def made(what: str, S: np.ndarray, B: np.ndarray, answer: tuple[np.ndarray, np.ndarray, np.ndarray], **more) -> Case:
    """Case of a chosen answer: forces, gap, motion."""
    forces, gap, q = answer
    problem = ContactProblem(S=S, g=gap - S @ forces - B.T @ q, B=B, F=B @ forces)
    return Case(what, problem, forces=forces, gap=gap, **more)


def grid(size: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Points x, y (size^2,) of a square grid and its pitch."""
    line = np.linspace(-HALF_WIDTH, HALF_WIDTH, size)
    x, y = (each.ravel() for each in np.meshgrid(line, line))
    return x, y, float(line[1] - line[0])


def compliance(size: int) -> np.ndarray:
    """Half-space of E* = 1 on size x size points: point loads (Boussinesq), the cell itself under uniform pressure."""
    x, y, pitch = grid(size)
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    # the exact deflection in the centre of a uniformly loaded square (Love 1929)
    np.fill_diagonal(distance, pitch / (4 * np.log(1 + np.sqrt(2))))
    return 1 / (np.pi * distance)


def half_space(size: int, rows: int = 1, *, load: float = 1.0) -> ContactProblem:
    """Rigid paraboloid of radius 1 on an elastic half-space, size x size points: force and two moments at most.

    A load of 1 gives a contact radius of 1, see `HERTZ_LOAD`; without rows the paraboloid is pressed in by `load`.
    """
    x, y, _ = grid(size)
    gap = (x**2 + y**2) / 2
    if rows == 0:
        return ContactProblem(S=compliance(size), g=gap - load)
    B = np.vstack([np.ones_like(x), x, y])[:rows]
    return ContactProblem(S=compliance(size), g=gap, B=B, F=np.array([HERTZ_LOAD * load, 0.0, 0.0])[:rows])


def random_problem(seed: int, n: int, m: int, rank: int) -> ContactProblem:
    """Random problem that has an answer: the load is carried by some l >= 0, some motion opens all gaps."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((rank, n))
    S, B = A.T @ A, rng.standard_normal((m, n))
    carried = np.maximum(rng.standard_normal(n), 0.0)
    w = np.maximum(rng.standard_normal(n), 0.0)
    g = w - S @ rng.standard_normal(n) - B.T @ rng.standard_normal(m)
    return ContactProblem(S=S, g=g, B=B, F=B @ carried)


def hertz_answer(size: int, centre: tuple[float, float] = (0.0, 0.0)) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Hertz's forces and gaps on the grid and the motion (approach and tilt) of a contact round `centre`.

    Source: K. L. Johnson, Contact Mechanics (1985), eq. 3.39 to 3.42, with a = R = E* = 1.
    """
    x, y, pitch = grid(size)
    r = np.hypot(x - centre[0], y - centre[1])
    forces = 2 / np.pi * np.sqrt(np.maximum(1 - r**2, 0.0)) * pitch**2
    out = np.maximum(r, 1.0)
    outside = ((2 - out**2) * np.arcsin(1 / out) + np.sqrt(out**2 - 1)) / np.pi
    gap = np.where(forces > 0, 0.0, np.maximum(outside - 1 + r**2 / 2, 0.0))
    return forces, gap, np.array([np.hypot(*centre) ** 2 / 2 - 1, -centre[0], -centre[1]])


def rows_of(size: int) -> np.ndarray:
    """Force and two moments, (3, size^2)."""
    x, y, _ = grid(size)
    return np.vstack([np.ones_like(x), x, y])


def hertz(size: int) -> Case:
    return made("smooth: Hertz", compliance(size), rows_of(size), hertz_answer(size))


def eccentric(size: int) -> Case:
    return made("eccentric load", compliance(size), rows_of(size), hertz_answer(size, (0.23, -0.11)))


def pressed_in(size: int) -> Case:
    forces, gap, _ = hertz_answer(size)
    answer = (forces, gap, np.empty(0))
    return made("held body, negative initial gaps", compliance(size), np.empty((0, size**2)), answer)


def duplicates(size: int) -> Case:
    """Every candidate twice; the twins share their force unevenly."""
    forces, gap, q = hertz_answer(size)
    twice, share = np.repeat(np.arange(size**2), 2), np.tile([0.3, 0.7], size**2)
    S = compliance(size)[np.ix_(twice, twice)]
    return made("duplicate candidates", S, rows_of(size)[:, twice], (forces[twice] * share, gap[twice], q))


def finer(size: int, ratio: int = 10) -> Case:
    """Nodes of a surface seen through candidates `ratio` times as fine: rank n / ratio^2."""
    coarse = max(size // ratio, 2)
    nodes, points = np.linspace(-HALF_WIDTH, HALF_WIDTH, coarse), np.linspace(-HALF_WIDTH, HALF_WIDTH, size)
    hat = np.maximum(0.0, 1 - np.abs(points[:, None] - nodes) / (nodes[1] - nodes[0]))
    N = np.kron(hat, hat)
    return made("candidates 10 times finer", N @ compliance(coarse) @ N.T, rows_of(size), hertz_answer(size))


def low_rank(size: int, share: int) -> Case:
    rng = np.random.default_rng(share)
    n = size**2
    A, B = rng.standard_normal((n // share, n)), rng.standard_normal((3, n))
    touching = rng.random(n) < 0.4
    forces, gap = np.where(touching, rng.random(n), 0.0), np.where(touching, 0.0, rng.random(n))
    return made(f"random S of rank n / {share}", A.T @ A, B, (forces, gap, rng.standard_normal(3)))


def bad_rows(size: int) -> Case:
    """Units that differ from point to point by up to sixteen orders."""
    forces, gap, q = hertz_answer(size)
    d = 10.0 ** np.random.default_rng(1).uniform(-8, 8, size**2)
    S = compliance(size) * d * d[:, None]
    return made("rows scaled by 1e-8 ... 1e8", S, rows_of(size) * d, (forces / d, gap * d, q))


def si(size: int) -> Case:
    """Compliances of 1e-12 m/N, gaps of 1e-6 m, arms of 1e-3 m."""
    forces, gap, q = hertz_answer(size)
    arms = np.array([[1.0], [1e-3], [1e-3]])
    answer = (forces * 1e6, gap * 1e-6, q * 1e-6 / arms[:, 0])
    return made("SI numbers", compliance(size) * 1e-12, rows_of(size) * arms, answer)


def first_touch(size: int, load: float = 1e-12) -> Case:
    """A load so light that the point nearest to the pole carries it alone."""
    x, y, _ = grid(size)
    S = compliance(size)
    r2 = (x - 0.01) ** 2 + (y - 0.02) ** 2
    pole = int(r2.argmin())
    forces = np.zeros(size**2)
    forces[pole] = load
    gap = (r2 - r2[pole]) / 2 + load * (S[:, pole] - S[pole, pole])
    return made("first touch at one point, load 1e-12", S, rows_of(size)[:1], (forces, gap, np.array([-load])))


def light_load(size: int) -> Case:
    """The way to go before the bodies touch is ten thousand times the deflection (a/R = 1e-4 on a fixed shape)."""
    forces, gap, q = hertz_answer(size)
    far = np.array([1e4, 0.0, 0.0])
    return made("light load: gaps 1e4 times the deflection", compliance(size), rows_of(size), (forces, gap, q - far))


def everything(size: int) -> Case:
    x, y, _ = grid(size)
    answer = (1 + 0.2 * x + 0.1 * y, np.zeros(size**2), np.array([-1.0, 0.1, 0.0]))
    return made("everything in contact", compliance(size), rows_of(size), answer)


def nothing(size: int) -> Case:
    _, gap, _ = hertz_answer(size)
    problem = ContactProblem(S=compliance(size), g=gap, B=rows_of(size), F=np.zeros(3))
    return Case("nothing in contact", problem, Status.NO_CONTACT, np.zeros(size**2), gap)


def lifted(size: int) -> Case:
    """A free body that overlaps the other and has no load: it moves away, and nothing presses."""
    x, y, _ = grid(size)
    problem = ContactProblem(S=compliance(size), g=(x**2 + y**2) / 2 - 1, B=rows_of(size), F=np.zeros(3))
    return Case("overlap of a free body without load", problem, forces=np.zeros(size**2), gap=x, pinned=False)


def contrast(size: int, ratio: float = 1e6) -> Case:
    """Two places of contact of one body, the one stiffer by `ratio`."""
    half = max(round(size / np.sqrt(2)), 2)
    forces, gap, q = hertz_answer(half)
    S, B = compliance(half), rows_of(half)
    answer = (np.tile(forces, 2), np.concatenate([gap, gap / ratio]), q)
    return made("stiffness contrast 1e6", block_diag(S, S / ratio), np.tile(B, 2), answer)


def patches(size: int) -> Case:
    """Sixteen places of contact far from each other, one load."""
    small = max(size // 4, 3)
    forces, gap, _ = hertz_answer(small)
    S = block_diag(*[compliance(small)] * 16)
    lower = np.repeat(np.linspace(1.0, 2.0, 16), small**2)
    answer = (np.tile(forces, 16) * lower, np.tile(gap, 16), np.array([-1.0]))
    return made("16 separate patches", S, np.ones((1, 16 * small**2)), answer)


def ring(size: int) -> Case:
    """Points all alike, so that every choice among them is a tie."""
    n = size**2
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    S = 1.0 / (1.0 + np.minimum(lag, n - lag))
    return made("symmetric ties on a ring", S, np.ones((1, n)), (np.ones(n), np.zeros(n), np.array([-3.0])))


def degenerate(size: int) -> Case:
    """Every third point of the contact has neither force nor gap."""
    forces, gap, q = hertz_answer(size)
    idle = np.arange(size**2) % 3 == 0
    answer = (np.where(idle, 0.0, forces), np.where(idle, 0.0, gap), q)
    return made("a third of the points without force and gap", compliance(size), rows_of(size), answer)


def ball_on_plate(size: int) -> Case:
    """Motions that nothing resists and nothing drives: a row of zeros and rows that follow from others."""
    forces, gap, q = hertz_answer(size)
    B = rows_of(size)
    B = np.vstack([B, np.zeros((1, size**2)), 2 * B[:1] - B[1:2]])
    answer = (forces, gap, np.concatenate([q, [0.0, 0.0]]))
    return made("free motions without load, dependent rows", compliance(size), B, answer)


def cycling(size: int) -> Case:
    """Copies of three points on which plain primal-dual active-set steps come back to their sets (a test shows it).

    On such problems and remedies: Curtis, Han & Robinson, A globally convergent primal-dual active-set framework for
    large-scale convex quadratic optimization, Comput. Optim. Appl. 60 (2015) 311-341.
    """
    H = np.array([[4.0, 5.0, -5.0], [5.0, 9.0, -5.0], [-5.0, -5.0, 7.0]])
    copies = max(size**2 // 3, 1)
    # the second and third touch: 9 x + -5 y = -1, -5 x + 7 y = 3
    forces, gap = np.array([0.0, 4 / 19, 11 / 19]), np.array([3 / 19, 0.0, 0.0])
    answer = (np.tile(forces, copies), np.tile(gap, copies), np.empty(0))
    return made("active sets that cycle", block_diag(*[H] * copies), np.empty((0, 3 * copies)), answer)


def pulled(size: int) -> Case:
    problem = ContactProblem(S=compliance(size), g=np.ones(size**2), B=rows_of(size), F=np.array([-1.0, 0.0, 0.0]))
    return Case("load that pulls away", problem, Status.INFEASIBLE)


def tipped(size: int) -> Case:
    """The load acts outside the points that can carry it."""
    problem = ContactProblem(
        S=compliance(size), g=np.ones(size**2), B=rows_of(size), F=np.array([1.0, 1.01 * HALF_WIDTH, 0.0])
    )
    return Case("load outside the support", problem, Status.INFEASIBLE)


def rigid_overlap(size: int) -> Case:
    """Rigid where it overlaps, and held: no deflection and no motion removes the overlap."""
    S = compliance(size)
    S[0, :], S[:, 0] = 0.0, 0.0
    problem = ContactProblem(S=S, g=np.where(np.arange(size**2) == 0, -1.0, 1.0))
    return Case("overlap that nothing removes", problem, Status.UNBOUNDED)


CASES: tuple[Callable[[int], Case], ...] = (
    hertz,
    eccentric,
    pressed_in,
    light_load,
    first_touch,
    everything,
    nothing,
    lifted,
    ball_on_plate,
    contrast,
    si,
    bad_rows,
    duplicates,
    finer,
    lambda size: low_rank(size, 2),
    lambda size: low_rank(size, 4),
    patches,
    ring,
    degenerate,
    cycling,
    pulled,
    tipped,
    rigid_overlap,
)
"""All cases, as functions of the grid's side; a case has about its square of points."""
