"""Pressures between zero and a hardness by descent, where active sets alone do not settle.

Of a nearly rigid body hardly a cell lies between its bounds, fewer than the loads have rows: pressures that close the
gaps of so small a set do not balance the loads, or only far beyond their bounds. Here pressures balance the loads and
keep their bounds throughout, and the complementary energy falls: a step down the gaps, then conjugate gradients among
the cells between their bounds, both brought back to the nearest admissible pressures (Moré & Toraldo 1991).

Two problems of a few unknowns come with it, both convex: the admissible pressures nearest to others, and the motion q
that leaves the least gaps where they count. Both are solutions of B clip(y + B^T q) = F.

References
----------
J. J. Moré, G. Toraldo, SIAM J. Optim. 1 (1991) 93; D. P. Bertsekas, SIAM J. Control Optim. 20 (1982) 221.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy.optimize

from fecontact.common.arrays import Array, Mask
from fecontact.halfspace.cg import SMALLEST, GridIterate, GridProblem, Work, balanced, equalise, largest_displacement

#: Steps of descent, and halvings of one.
MAX_STEPS, HALVINGS = 500, 40

#: Newton steps of the problems of a few unknowns; share of a diagonal added to a matrix that may be singular.
MAX_NEWTON, DAMPING = 200, 1e-10

#: Slope beyond the least value along a step, over that before it, that is rounding.
OVERSHOOT = 1e-6

#: Fall of the energy that is asked for, over that of the slope.
FALL = 1e-4

#: Lack of balance over sums of sizes that is rounding.
ROUNDING = 4e-16

#: Difference of a pressure from a bound, over it or the largest pressure, that is rounding.
AT_BOUND = 1e-12

#: The same on the way to large values.
ON_THE_WAY = 1e-3

#: Shrinkage of the gaps among cells between their bounds in one step.
PER_STEP = 1e-3

#: Blocks a side in which pressures are looked for first that balance loads.
BLOCKS = 16


def solve_bounded(problem: GridProblem, start: GridIterate, tolerance: float) -> GridIterate:
    """Solve a grid problem with bounds, from the pressures of an iterate; see `cg.solve_on_grid`.

    Where no pressures balance the loads, as may be on coarse cells, the iterate is returned.
    """
    box, work = _Admissible.of(problem), Work.of(problem.g.shape)
    p = box.nearest(start.p)
    if not balanced(problem, p):
        return start
    at = replace(start, p=p, u=problem.compliance.apply(p), recomputed=True)
    for _ in range(MAX_STEPS):
        empty, full = box.held(at.p)
        low, high = np.where(full & ~empty, 0.0, -np.inf), np.where(empty, 0.0, np.inf)
        low[~problem.allowed] = high[~problem.allowed] = 0.0
        q = balancing(box.B, at.u + problem.g, low, high, np.zeros(len(at.q)), at.q)
        gap = np.where(problem.allowed, at.u + problem.g + problem.motion(q, slice(None)), 0.0)
        counts = np.clip(gap, low, high)
        left = float(np.abs(counts).max()) / largest_displacement(problem, at.u)
        history = (*at.history, left)
        at = replace(at, q=q, active=~empty, full=full, rounds=len(history), history=history)
        if left <= tolerance:
            p = np.where(empty, 0.0, np.where(full, box.bound, at.p))
            return replace(at, p=p, converged=True)
        at, gap = _down(problem, box, at, gap, counts)
        free = ~np.logical_or(*box.held(at.p))
        trial = replace(at, p=at.p.copy(), u=at.u.copy(), active=free, full=None)
        reached = equalise(problem, trial, tolerance, PER_STEP, work)
        change = box.nearest(reached.p) - at.p
        if float(np.vdot(gap, change)) + float(np.vdot(change, problem.compliance.apply(change))) / 2 < 0:
            at = replace(at, p=np.clip(at.p + change, 0.0, box.bound))
        at = replace(at, u=problem.compliance.apply(at.p), nit=reached.nit)
    return at


def _down(
    problem: GridProblem, box: _Admissible, at: GridIterate, gap: Array, counts: Array
) -> tuple[GridIterate, Array]:
    """Pressures and gaps after a step down the gaps, as long as is best along a line, or shorter until they fall."""
    length = float(np.vdot(counts, counts)) / max(float(np.vdot(counts, problem.compliance.apply(counts))), SMALLEST)
    for _ in range(HALVINGS):
        change = box.nearest(at.p - length * gap) - at.p
        slope, by_change = float(np.vdot(gap, change)), problem.compliance.apply(change)
        if slope + float(np.vdot(change, by_change)) / 2 <= FALL * slope:
            return replace(at, p=at.p + change, u=at.u + by_change), gap + by_change
        length /= 2
    return at, gap


@dataclass(frozen=True, eq=False)
class _Admissible:
    """Pressures up to bounds (nx, ny), zero where there is no counter-surface, with rows (m, n) that balance loads."""

    B: Array
    F: Array
    bound: Array

    @classmethod
    def of(cls, problem: GridProblem) -> _Admissible:
        """Those of a grid problem with bounds."""
        assert problem.bound is not None
        return cls(problem.B.reshape(len(problem.F), -1), problem.F, np.where(problem.allowed, problem.bound, 0.0))

    def nearest(self, p: Array) -> Array:
        """The nearest to others; those of large ones are rounded, and balanced once more."""
        none = np.zeros(len(self.F))
        for _ in range(2):
            q = balancing(self.B, p, np.zeros(p.shape), self.bound, self.F, none)
            p = np.clip(p + (q @ self.B).reshape(p.shape), 0.0, self.bound)
        return p

    def held(self, p: Array) -> tuple[Mask, Mask]:
        """Cells at zero and at their bounds, from which rounding alone may keep them."""
        share = AT_BOUND * np.minimum(self.bound, float(p.max()))
        return p <= share, p >= self.bound - share


def balancing(B: Array, y: Array, low: Array, high: Array, F: Array, start: Array) -> Array:
    """Factors q (m,) with B clip(y + B^T q, low, high) = F, least in size of what is not determined.

    It is where half the squares of the clipped values, continued linearly beyond, less F . q, are least. Where y is
    large beside the bounds this is nearly a linear programme, all edges: y grows to it in factors of two.
    """
    if not len(F):
        return start
    most, size = float(high.max(where=np.isfinite(high), initial=0.0)), float(np.abs(y).max())
    doublings = max(0, math.ceil(math.log2(size / most))) if most > 0 and size > 0 else 0
    found, bounds = start * 0.5**doublings, (low.ravel(), high.ravel())
    for k in range(doublings, 0, -1):
        found = 2 * _newton(B, y.ravel() * 0.5**k, *bounds, F, found, ON_THE_WAY)
    return _newton(B, y.ravel(), *bounds, F, found, ROUNDING)


def _newton(B: Array, y: Array, low: Array, high: Array, F: Array, start: Array, left: float) -> Array:
    """The same for values (n,) by Newton's method, until what is left over sums of sizes is small.

    No step goes beyond the least value along it.
    """

    def at(q: Array) -> tuple[Array, Array]:
        c = np.clip(y + q @ B, low, high)
        return c, B @ c - F

    q, size = start, np.abs(B)
    c, slope = at(q)
    for _ in range(MAX_NEWTON):
        inside = (c > low) & (c < high)
        if (np.abs(slope) <= left * np.maximum(size @ np.abs(np.where(inside, y, c)), np.abs(F).max())).all():
            break
        between = B * inside
        step = -np.linalg.solve(between @ B.T + DAMPING * np.diag((B * B).sum(axis=1)), slope)
        descent = float(slope @ step)
        for _ in range(HALVINGS):
            new_c, new_slope = at(q + step)
            if float(new_slope @ step) <= -OVERSHOOT * descent:
                break
            step, descent = step / 2, descent / 2
        else:
            break
        q, c, slope = q + step, new_c, new_slope
    return q


def borne_share(B: Array, F: Array, bound: Array) -> float:
    """Largest s, up to 2, with B p = s F for pressures 0 <= p <= bound (nx, ny), a linear programme.

    It is asked for of blocks of cells first, which are equally near their bounds: what these bear all cells do.
    """
    cells = [np.minimum(np.arange(n) * BLOCKS // n, BLOCKS - 1) for n in bound.shape]
    block = (cells[0][:, None] * BLOCKS + cells[1]).ravel()
    endless = np.isinf(bound).ravel()
    rows: Array = B.reshape(len(F), -1) * np.where(endless, F[0], bound.ravel())
    number, groups = 2 * block + endless, 2 * BLOCKS**2
    sums: Array = np.stack([np.bincount(number, row, groups) for row in rows]).astype(float)
    share = _share(sums, F, np.arange(groups) % 2 > 0)
    return share if share >= 1 else _share(rows, F, endless)


def _share(rows: Array, F: Array, endless: Mask) -> float:
    """Largest s, up to 2, with rows t = s F and 0 <= t, where it is not endless t <= 1."""
    used = rows.any(axis=0)
    rows, most = rows[:, used], np.where(endless[used], np.inf, 1.0)
    scale = np.abs(F).max()
    found = scipy.optimize.linprog(
        np.r_[np.zeros(rows.shape[1]), -1.0],
        A_eq=np.column_stack([rows, -F]) / scale, b_eq=np.zeros(len(F)),
        bounds=np.column_stack([np.zeros(len(most) + 1), np.r_[most, 2.0]]), method="highs",
    )  # fmt: skip
    return -float(found.fun) if found.status == 0 else 0.0
