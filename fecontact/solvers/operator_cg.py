"""Conjugate gradients on active sets, for a compliance that is an operator: half-spaces and scenes of many points.

For a set of points thought to touch, the forces that close their gaps and balance the loads follow from preconditioned
conjugate gradients in the subspace B x = F. They are stopped early: after the gaps have shrunk by `PER_ROUND`, points
that would pull leave the set and points that penetrate enter it (the primal-dual active set method, Hintermueller, Ito
& Kunisch 2003). The last round, on the set that stays, goes down to the tolerance.

Where the preconditioner is good, as the hypersingular operator is for a half-space (McLean & Steinbach 1999), a round
takes two or three steps. Without one the method is that of Polonsky & Keer (1999), with more than one step per set.

A safeguard makes it converge for any semidefinite S. Each round ends with feasible forces, and their energy
1/2 x . S x + g . x should decrease. After `PATIENCE` rounds in which neither it nor the residual did, the best forces
so far take a projected gradient step of safe length, which lowers the energy, and from then on a round stops where a
force would pull.

Conjugate gradients correct a known answer, so their products may be less exact than the others. The error that this
may bring into the deflections is added up, and they are computed anew before it counts.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.solvers.feasible import feasible, load_size, project
from fecontact.solvers.scaling import SMALLEST

PER_ROUND = 0.2
"""Factor by which the gaps on the set shrink before the set is changed."""

MOST_STEPS = 60
"""Steps on one set; with a good preconditioner a dozen gives ten digits."""

PATIENCE = 4
"""Rounds without less energy or less residual before the safeguard."""

STANDSTILL = 200
"""Rounds without a smaller residual after which the method has nothing more to give."""

CLOSED = 0.3
"""Share of the tolerance to which the gaps of a set are closed."""

UNBALANCED = 1e-12
"""Load not carried, relative to the largest that was, from which the set cannot carry it."""

TINY = 1e-300
"""Instead of zero, where nothing deflects and all gaps are closed."""


@dataclass(frozen=True, eq=False)
class OperatorProblem:
    """Frictionless contact: gap = S x + g + B^T q >= 0, x >= 0, x . gap = 0, B x = F.

    Attributes
    ----------
    product : function
        S x (n,) of x (n,).
    g : (n,) array
        Gaps without forces.
    B : (m, n) array
        Equilibrium rows.
    F : (m,) array
        Loads.
    allowed : (n,) bool array
        Points that may touch.
    correction : function
        S x again, perhaps rougher, for steps that correct a known answer.
    precondition : function, optional
        Roughly S^-1, symmetric and positive definite.
    error, correction_error : float
        Relative error of the products.
    """

    product: Callable[[Array], Array]
    g: Array
    B: Array
    F: Array
    allowed: Mask
    correction: Callable[[Array], Array]
    precondition: Callable[[Array], Array] = np.copy
    error: float = SMALLEST
    correction_error: float = SMALLEST

    def size(self, values: Array) -> float:
        """Largest absolute value where points may touch."""
        largest = np.max(values, where=self.allowed, initial=0.0)
        return max(float(largest), -float(np.min(values, where=self.allowed, initial=0.0)))

    def gap_unit(self, u: Array, tolerance: float) -> float:
        """What gaps are compared with: the largest deflection, unless the gaps' own rounding is above the tolerance."""
        return max(self.size(u), SMALLEST / tolerance * self.size_of_g, TINY)

    @cached_property
    def size_of_g(self) -> float:
        """Largest gap without forces."""
        return self.size(self.g)


@dataclass(frozen=True, eq=False)
class Iterate:
    """Forces, what follows from them, and how they were found.

    Attributes
    ----------
    x, u : (n,) arrays
        Forces and deflections S x.
    q : (m,) array
        Multiplier of B x = F.
    active : (n,) bool array
        Points that touch.
    nit : int
        Conjugate gradient steps.
    rounds : int
        Active sets.
    converged : bool
    history : tuple of float
        Largest gap on the set or penetration, relative to the largest deflection, after each round.
    drift : float
        Bound on the error of u by rough products.
    """

    x: Array
    u: Array
    q: Array
    active: Mask
    nit: int = 0
    rounds: int = 0
    converged: bool = False
    history: tuple[float, ...] = ()
    drift: float = 0.0


def solve_with_operator(
    problem: OperatorProblem,
    start: Array,
    active: Mask,
    tolerance: float,
    *,
    most_rounds: int = 150,
    most_steps: int = sys.maxsize,
) -> Iterate:
    """Solve by conjugate gradients on active sets.

    Parameters
    ----------
    problem : OperatorProblem
    start : (n,) array
        Forces to begin with.
    active : (n,) bool array
        Points to begin with.
    tolerance : float
        Largest gap on touching points and penetration on the others, relative to the largest deflection.
    most_rounds, most_steps : int
        Limits on the active sets and on the conjugate gradient steps.

    Returns
    -------
    Iterate
        With ``converged`` False if the sets did not settle within the limits. The forces do not pull.

    References
    ----------
    M. Hintermueller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2003) 865; I. A. Polonsky, L. M. Keer, Wear 231 (1999)
    206; W. McLean, O. Steinbach, Adv. Comput. Math. 11 (1999) 271.

    Examples
    --------
    >>> import numpy as np
    >>> g, everywhere = np.array([0.0, 0.0, 9.0]), np.ones(3, bool)
    >>> problem = OperatorProblem(lambda x: 2 * x, g, np.ones((1, 3)), np.ones(1), everywhere, lambda x: 2 * x)
    >>> at = solve_with_operator(problem, np.zeros(3), everywhere, 1e-12)
    >>> at.x.round(12).tolist(), at.q.round(12).tolist()
    ([0.5, 0.5, 0.0], [-1.0])
    """
    problem = replace(problem, B=problem.B * problem.allowed)
    active = active & problem.allowed
    x = np.where(active, np.maximum(start, 0.0), 0.0)
    x = feasible(problem.B, problem.F, x) if x.any() else x
    at = _with_forces(problem, Iterate(x, x, np.zeros(len(problem.F)), active | (x > 0)), x)
    guard = _Safeguard(problem, at)
    changed = True
    while at.rounds < most_rounds and at.nit < most_steps and at.rounds - guard.smallest_at <= STANDSTILL:
        before = at.nit
        factor, steps = PER_ROUND if changed else 0.0, min(MOST_STEPS, most_steps - at.nit)
        at = _equalise(problem, at, tolerance, factor, steps, guard.cautious)
        unit = problem.gap_unit(at.u, tolerance)
        pulling, entering, left = _wrong(problem, at, tolerance, unit)
        at = replace(at, history=(*at.history, left))
        changed = bool(pulling.any() or entering.any())
        missing = guard.misses_load(at.x)
        if not (changed or missing) and left <= tolerance:
            if at.drift <= 0.1 * tolerance * unit:
                return replace(at, converged=True)
            at = _with_forces(problem, at, at.x)
            continue
        at = replace(at, active=(at.active & ~pulling) | entering)
        if pulling.any() or missing:
            at = _with_forces(problem, at, feasible(problem.B, problem.F, at.x))
        at, safe = guard.judge(at, left, unit, stuck=not changed and at.nit == before)
        changed |= safe
    return at


def _with_forces(problem: OperatorProblem, at: Iterate, x: Array) -> Iterate:
    """The iterate with other forces: all that carry a force touch."""
    u = problem.product(x)
    return replace(at, x=x, u=u, active=at.active | (x > 0), drift=problem.error * problem.size(u))


def _wrong(problem: OperatorProblem, at: Iterate, tolerance: float, unit: float) -> tuple[Mask, Mask, float]:
    """Points that pull, points that penetrate, and the largest gap on the set or penetration, relative."""
    gap = at.u + problem.g + at.q @ problem.B
    entering = problem.allowed & ~at.active & (gap < -tolerance * unit)
    left = problem.size(np.where(at.active, gap, np.minimum(gap, 0.0))) / unit
    return at.active & (at.x < 0), entering, left


class _Safeguard:
    """The best forces so far, and a step from them that lowers the energy.

    Parameters
    ----------
    problem : OperatorProblem
    at : Iterate
        The first one.
    """

    def __init__(self, problem: OperatorProblem, at: Iterate) -> None:
        self.problem = problem
        self.best, self.energy = at, np.inf
        self.smallest, self.smallest_at = np.inf, 0
        self.cautious = False
        self._idle = 0
        self._length = 0.0
        self._load = 0.0

    def misses_load(self, x: Array) -> bool:
        """Whether forces do not carry the load; they get small where it is zero."""
        B, F = self.problem.B, self.problem.F
        self._load = max(self._load, load_size(B, F, x))
        return float(np.abs(F - B @ x).max(initial=0.0)) > UNBALANCED * self._load

    def judge(self, at: Iterate, left: float, unit: float, stuck: bool) -> tuple[Iterate, bool]:
        """The iterate, or one after a safe step, and whether it is that."""
        energy = float(0.5 * (at.x @ at.u) + at.x @ self.problem.g)
        slack = float(at.x.sum()) * (SMALLEST * (self.problem.size_of_g + unit) + at.drift)
        better = energy < self.energy - slack or (energy <= self.energy + slack and left < self.smallest)
        if energy < self.energy:
            self.best, self.energy = at, energy
        if left < self.smallest:
            self.smallest, self.smallest_at = left, at.rounds
        self._idle = 0 if better else self._idle + 1
        if not stuck and self._idle <= (0 if self.cautious else PATIENCE):
            return at, False
        self.cautious, self._idle = True, 0
        return self._safe_step(at), True

    def _safe_step(self, at: Iterate) -> Iterate:
        """A projected gradient step from the best forces."""
        problem, best = self.problem, self.best
        self._length = self._length or 1.0 / _largest_eigenvalue(problem)
        gap = best.u + problem.g + best.q @ problem.B
        x = project(problem.B, problem.F, np.where(problem.allowed, best.x - self._length * gap, 0.0))[0]
        at = _with_forces(problem, replace(at, q=best.q, active=np.zeros_like(at.active)), x)
        self.best, self.energy = at, float(0.5 * (x @ at.u) + x @ problem.g)
        return at


def _largest_eigenvalue(problem: OperatorProblem) -> float:
    """An upper estimate of the largest eigenvalue of S: twenty power iterations and a margin."""
    v = np.where(problem.allowed, np.random.default_rng(0).uniform(0.5, 1.5, len(problem.g)), 0.0)
    size = 1.0
    for _ in range(20):
        v = problem.product(v / np.linalg.norm(v)) * problem.allowed
        size = float(np.linalg.norm(v))
        if size == 0.0:
            return 1.0
    return 1.2 * size


@dataclass(frozen=True, eq=False)
class _Subspace:
    """Equilibrium rows on a set, and the preconditioner in the subspace of forces that do not change the loads."""

    problem: OperatorProblem
    mask: Array
    rows: Array
    images: Array
    inverse: Array

    def direction(self, gap: Array) -> tuple[Array, Array]:
        """Preconditioned gap (n,) without change of the loads, and the change of the multiplier (m,)."""
        z = self.problem.precondition(gap)
        z *= self.mask
        if len(self.rows) == 0:
            return z, np.zeros(0)
        dq = -self.inverse @ (self.rows @ z)
        z += dq @ self.images
        return z, dq

    def missing(self, x: Array) -> Array:
        """Change of the forces (n,) that makes them carry the loads."""
        return np.asarray((self.inverse @ (self.problem.F - self.rows @ x)) @ self.images)


def _subspace(problem: OperatorProblem, active: Mask) -> _Subspace:
    mask = active.astype(float)
    rows = problem.B * mask
    images = np.array([problem.precondition(row) * mask for row in rows]).reshape(rows.shape)
    gram = rows @ images.T
    inverse = np.asarray(np.linalg.pinv((gram + gram.T) / 2, rcond=1e-12, hermitian=True), dtype=float)
    return _Subspace(problem, mask, rows, images, inverse)


def _equalise(
    problem: OperatorProblem, at: Iterate, tolerance: float, factor: float, most: int, cautious: bool
) -> Iterate:
    """Conjugate gradients towards closed gaps on the set, until they have shrunk by a factor or are closed.

    A cautious one stops where a force pulls.
    """
    space = _subspace(problem, at.active)
    x, u, q, drift = at.x.copy(), at.u.copy(), at.q, at.drift
    if len(q) and np.abs(correction := space.missing(x)).max() > 1e-14 * np.abs(x).max():
        x += correction
        u += problem.product(correction)
    gap = (u + problem.g + q @ problem.B) * space.mask
    z, dq = space.direction(gap)
    d, rho, first, steps = z.copy(), np.nan, np.nan, 0
    while True:
        gap += dq @ space.rows
        q = q + dq
        before, rho = rho, float(gap @ z)
        first = rho if steps == 0 else first
        closed = max(float(gap.max()), -float(gap.min())) <= CLOSED * tolerance * problem.gap_unit(u, tolerance)
        if closed or steps == most or rho <= factor**2 * first or (cautious and x.min() < 0):
            break
        if steps:
            d *= rho / before
            d += z
        image = problem.correction(d)
        curvature = float(d @ image)
        if curvature <= 0:
            break
        length = rho / curvature
        x -= length * d
        image *= length
        drift += problem.correction_error * max(float(image.max()), -float(image.min()))
        u -= image
        image *= space.mask
        gap -= image
        steps += 1
        z, dq = space.direction(gap)
    return replace(at, x=x, u=u, q=q, nit=at.nit + steps, rounds=at.rounds + 1, drift=drift)
