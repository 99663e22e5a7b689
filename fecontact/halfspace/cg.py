"""Active sets and projected, preconditioned conjugate gradients on a grid of cells.

On a given active set, the pressures that close the gaps and balance the loads follow from conjugate gradients in the
subspace B p = F. They are stopped early: after the gaps have shrunk by `PER_ROUND`, cells in tension leave the set and
cells that penetrate enter it (the primal-dual active set method, Hintermueller, Ito & Kunisch 2003). The last round, on
the final set, is iterated to the tolerance.

The compliance of a half-space is 2/(E* |k|) in wave numbers, so its condition grows with the number of cells. The
preconditioner is its inverse symbol, |k| E*/2, on the cells of the set: the hypersingular operator, with which the
number of iterations grows with the logarithm of the number of cells only (McLean & Steinbach 1999).

Conjugate gradients correct a known iterate, so their products are in single precision. A bound of the resulting error
of the displacements is tracked, and these are recomputed in double precision before it matters.

Arithmetic is done strip by strip, so that arrays pass through the cache once for several operations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.halfspace.fft import ROUGHNESS, Convolution, DampedInverse, Product, each, strips

#: Factor by which the gaps on the set shrink before the set is updated.
PER_ROUND = 0.2

#: Active sets, and with bounds: after them pressures are found by descent.
MAX_ROUNDS, MAX_ROUNDS_BOUNDED = 150, 40
#: Conjugate gradient steps on one set; the preconditioned method needs a dozen for ten digits.
MAX_ITERATIONS = 60

#: Share of the tolerance that the error of a result due to single precision may take; on the way, ten times as much.
DRIFT = 0.1

#: Change of the largest pressure, relative to it, up to which loads out of balance count as rounding.
CARRIED = 1e-12

#: Loads out of balance, relative to them, of pressures that do not bear them.
UNBALANCED = 1e-10

SMALLEST = 1e-300


@dataclass(frozen=True, eq=False)
class GridProblem:
    """Frictionless contact on a grid: gap = A p + g + B^T q >= 0, p >= 0, p . gap = 0, B p = F.

    With bounds p <= H, gap <= 0 is allowed where p = H: there the surface yields by -gap.

    Attributes
    ----------
    compliance : Convolution or Corrected
        A: displacement due to pressure.
    rough : Convolution or Corrected
        The same in single precision, for corrections.
    preconditioner : Convolution or DampedInverse
        Approximate inverse of A, positive definite.
    g : (nx, ny) array
        Gap without pressure.
    allowed : (nx, ny) bool array
        Cells that have a counter-surface.
    B : (m, nx, ny) array
        Equilibrium rows.
    F : (m,) array
        Loads.
    workers : int, optional
        Threads, see `fft.each`.
    bound : (nx, ny) array, optional
        H, positive or infinite; none without it.
    """

    compliance: Product
    rough: Product
    preconditioner: Convolution | DampedInverse
    g: Array
    allowed: Mask
    B: Array
    F: Array
    workers: int | None = None
    bound: Array | None = None

    def each(self, work: Callable[[slice], Any]) -> list[Any]:
        """Results of a function of strips of the cells, which it may change."""
        return each(work, self._strips, self.workers)

    @cached_property
    def _strips(self) -> list[slice]:
        return strips(*self.g.shape)

    def motion(self, q: Array, strip: slice) -> Array:
        """B^T q of a strip."""
        return np.asarray(np.einsum("k,kij->ij", q, self.B[:, strip]))

    def loads(self, p: Array, strip: slice) -> Array:
        """B p of a strip (m,)."""
        return np.asarray(np.einsum("kij,ij->k", self.B[:, strip], p[strip]))

    def at_bound(self, p: Array, strip: slice = slice(None)) -> Mask:
        """Cells of a strip whose pressure is at its bound or above."""
        return np.zeros(p[strip].shape, bool) if self.bound is None else p[strip] >= self.bound[strip]

    def cut(self, p: Array, strip: slice) -> None:
        """Cut pressures of a strip at zero and at their bounds."""
        np.maximum(p[strip], 0.0, out=p[strip])
        if self.bound is not None:
            np.minimum(p[strip], self.bound[strip], out=p[strip])


@dataclass(frozen=True, eq=False)
class GridIterate:
    """Pressures, derived quantities, and statistics of the iteration.

    Attributes
    ----------
    p, u : (nx, ny) arrays
        Pressures and displacements A p.
    q : (m,) array
        Multiplier of B p = F.
    active : (nx, ny) bool array
        Active cells.
    nit : int
        Number of conjugate gradient steps.
    rounds : int
        Number of active sets.
    converged : bool
    history : tuple of float
        Largest gap on the set or penetration, relative to the largest displacement, after each round.
    drift : float
        Bound of the error of u due to single precision.
    recomputed : bool
        Whether u has been computed anew by p on the whole grid.
    full : (nx, ny) bool array, optional
        Active cells that are held at their bound; none without bounds.
    """

    p: Array
    u: Array
    q: Array
    active: Mask
    nit: int
    rounds: int
    converged: bool
    history: tuple[float, ...]
    drift: float = 0.0
    recomputed: bool = False
    full: Mask | None = None

    @property
    def free(self) -> Mask:
        """Active cells whose gaps are closed."""
        return self.active if self.full is None else np.asarray(self.active & ~self.full)


def solve_on_grid(problem: GridProblem, start: Array, active: Mask, tolerance: float) -> GridIterate:
    """Solve a grid problem.

    Parameters
    ----------
    problem : GridProblem
    start : (nx, ny) array
        Initial pressures.
    active : (nx, ny) bool array
        Initial active cells.
    tolerance : float
        Largest gap on active cells and penetration on the others, relative to the largest displacement.

    Returns
    -------
    GridIterate
        With `converged` False if the sets did not converge.

    References
    ----------
    M. Hintermueller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2003) 865; W. McLean, O. Steinbach, Adv. Comput. Math. 11
    (1999) 271; I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206.
    """
    active, work = active & problem.allowed, Work.of(problem.g.shape)
    p = np.where(active, np.maximum(start, 0.0), 0.0)
    p = carry(problem, p if problem.bound is None else np.minimum(p, problem.bound))
    full = None if problem.bound is None else active & problem.at_bound(p)
    u = problem.compliance.apply(p)
    at = GridIterate(p, u, np.zeros(len(problem.F)), active, 0, 0, False, (), full=full)
    changed = True
    while at.rounds < (MAX_ROUNDS if problem.bound is None else MAX_ROUNDS_BOUNDED):
        at = equalise(problem, at, tolerance, PER_ROUND if changed else 0.0, work)
        found = _judged(problem, at, tolerance)
        if found.closes(tolerance) and at.drift > DRIFT * tolerance * found.scale:
            at = replace(at, u=problem.compliance.apply(at.p, at.u), drift=0.0)
            found = _judged(problem, at, tolerance)
        at = replace(at, history=(*at.history, found.left))
        if found.closes(tolerance):
            carry(problem, at.p)  # what preconditioning in single precision has left of the loads, some 1e-11 of them
            return replace(at, converged=problem.bound is None or balanced(problem, at.p))
        changed = found.pulling or found.entering
        if found.pulling:
            at = _without_tension(problem, at, tolerance * found.scale, work)
        at = replace(at, active=found.active, full=found.full)
    return at


class _Judged(NamedTuple):
    """Judgement of an iterate: the next sets, whether pressures leave their bounds, gaps open or close, and scales.

    `left` is the largest gap on the set or penetration over the `scale`, the largest displacement.
    """

    active: Mask
    full: Mask | None
    pulling: bool
    entering: bool
    left: float
    scale: float

    def closes(self, tolerance: float) -> bool:
        """Whether the set stays and the gaps are closed."""
        return not (self.pulling or self.entering) and self.left <= tolerance


def _judged(problem: GridProblem, at: GridIterate, tolerance: float) -> _Judged:
    scale = largest_displacement(problem, at.u)
    following = np.empty(at.active.shape, bool)
    held = None if at.full is None else at.full.copy()

    def judge(strip: slice) -> tuple[bool, bool, float]:
        active, allowed = at.active[strip], problem.allowed[strip]
        gap = at.u[strip] + problem.g[strip] + problem.motion(at.q, strip)
        pulling = active & (at.p[strip] < 0)
        entering = allowed & ~active & (gap < -tolerance * scale)
        following[strip] = (active & ~pulling) | entering
        left = np.abs(np.where(active, gap, np.minimum(gap, 0.0)))
        if held is not None and problem.bound is not None:
            full = held[strip].copy()
            over, back = active & (at.p[strip] > problem.bound[strip]), full & (gap > tolerance * scale)
            held[strip] = (full & ~back) | over
            left[full] = np.maximum(gap[full], 0.0)
            pulling, entering = pulling | over, entering | back
        return bool(pulling.any()), bool(entering.any()), float(left.max(where=allowed, initial=0.0))

    pulling, entering, left = zip(*problem.each(judge), strict=True)
    return _Judged(following, held, any(pulling), any(entering), max(left) / scale, scale)


def balanced(problem: GridProblem, p: Array) -> bool:
    """Whether pressures bear the loads: too few cells between their bounds do not."""
    carried, reach = np.tensordot(problem.B, p, 2), np.tensordot(np.abs(problem.B), p, 2)
    return bool((np.abs(problem.F - carried) <= UNBALANCED * np.maximum(reach, np.abs(problem.F))).all())


def largest_displacement(problem: GridProblem, u: Array) -> float:
    """Largest displacement under the counter-surface; in holes between it may be larger."""

    def largest(strip: slice) -> float:
        part, allowed = u[strip], problem.allowed[strip]
        return max(float(part.max(where=allowed, initial=0.0)), -float(part.min(where=allowed, initial=0.0)))

    return max(*problem.each(largest), SMALLEST)


def _without_tension(problem: GridProblem, at: GridIterate, most_drift: float, work: Work) -> GridIterate:
    """The iterate with tensions set to zero, the loads in balance; displacements follow by the change of pressures."""
    p, u, change = at.p, at.u, work.d
    exact = at.drift > most_drift

    def clip(strip: slice) -> None:
        change[strip] = p[strip]
        problem.cut(p, strip)

    problem.each(clip)
    carry(problem, p)
    if exact:
        return replace(at, u=problem.compliance.apply(p, u), drift=0.0)

    def subtract(strip: slice) -> None:
        np.subtract(p[strip], change[strip], out=change[strip])

    def add(strip: slice) -> float:
        u[strip] += image[strip]
        return _size(image[strip])

    problem.each(subtract)
    image = problem.rough.apply(change, work.image)
    return replace(at, drift=at.drift + ROUGHNESS * max(problem.each(add)))


def carry(problem: GridProblem, p: Array) -> Array:
    """Pressures scaled by a factor linear in the rows until they balance the loads; p is lost.

    Those at their bound stay there, and none is scaled beyond it.
    """
    if len(problem.F) == 0:
        return p

    def moments(strip: slice) -> tuple[Array, Array]:
        rows = problem.B[:, strip]
        weighed = rows * p[strip]
        carried = weighed.sum(axis=(1, 2))
        if problem.bound is not None:
            weighed *= ~problem.at_bound(p, strip)
        return carried, np.einsum("kij,lij->kl", weighed, rows)

    carried, gram = (sum(parts) for parts in zip(*problem.each(moments), strict=True))
    factors = pseudo_inverse(gram) @ (problem.F - carried)

    def scale(strip: slice) -> None:
        factor = 1 + problem.motion(factors, strip)
        if problem.bound is not None:
            factor[problem.at_bound(p, strip)] = 1.0
        p[strip] *= factor
        if problem.bound is not None:
            np.minimum(p[strip], problem.bound[strip], out=p[strip])

    problem.each(scale)
    return p


@dataclass(frozen=True, eq=False)
class Work:
    """Arrays (nx, ny) that the rounds overwrite: gaps on the set, preconditioned ones, direction and its image."""

    gap: Array
    z: Array
    d: Array
    image: Array

    @classmethod
    def of(cls, shape: tuple[int, int]) -> Work:
        """Arrays of a shape."""
        gap, z, d, image = (np.empty(shape) for _ in range(4))
        return cls(gap, z, d, image)


@dataclass(frozen=True, eq=False)
class _Balance:
    """Equilibrium rows on a set of cells, and conjugate gradients among the pressures that do not change the loads.

    Gaps less a motion and preconditioned ones are both brought to that subspace by orthogonal projection: changes of
    pressures have no loads, and the gaps that they leave no part that a motion would close.
    """

    problem: GridProblem
    active: Mask
    work: Work
    inverse: Array

    @classmethod
    def of(cls, problem: GridProblem, active: Mask, work: Work) -> _Balance:
        """Rows of a problem on a set."""

        def products(strip: slice) -> Array:
            return np.einsum("kij,lij->kl", problem.B[:, strip] * active[strip], problem.B[:, strip])

        return cls(problem, active, work, pseudo_inverse(sum(problem.each(products))))

    def take_gap(self, at: GridIterate) -> tuple[Array, float]:
        """Gap on the set less the motion (m,) that leaves least of it, and its largest size."""
        problem, gap = self.problem, self.work.gap

        def take(strip: slice) -> Array:
            gap[strip] = (at.u[strip] + problem.g[strip] + problem.motion(at.q, strip)) * self.active[strip]
            return problem.loads(gap, strip)

        dq = -self.inverse @ sum(problem.each(take))

        def move(strip: slice) -> float:
            if len(dq):
                gap[strip] += problem.motion(dq, strip) * self.active[strip]
            return _size(gap[strip])

        return dq, max(problem.each(move))

    def precondition(self) -> tuple[Array, float]:
        """Precondition the gap: factors (m,) of the rows that take its loads from it, and its product with the gap."""
        problem, gap, z = self.problem, self.work.gap, self.work.z
        problem.preconditioner.apply(gap, z)

        def mask(strip: slice) -> tuple[Array, float]:
            z[strip] *= self.active[strip]
            return problem.loads(z, strip), float(np.vdot(gap[strip], z[strip]))

        loads, rho = zip(*problem.each(mask), strict=True)
        return -self.inverse @ sum(loads), sum(rho)

    def turn(self, rows: Array, factor: float) -> None:
        """Turn the direction d to the preconditioned gap without loads, and factor d."""
        problem, d = self.problem, self.work.d

        def turned(strip: slice) -> None:
            if factor:
                d[strip] *= factor
                d[strip] += self.work.z[strip]
            else:
                d[strip] = self.work.z[strip]
            if len(rows):
                d[strip] += problem.motion(rows, strip) * self.active[strip]

        problem.each(turned)

    def measure(self) -> tuple[float, Array]:
        """Product of the direction with its image, and the motion (m,) that leaves least of the image on the set."""
        problem, d, image = self.problem, self.work.d, self.work.image

        def measured(strip: slice) -> tuple[float, Array]:
            on_set = np.einsum("kij,ij->k", problem.B[:, strip], image[strip] * self.active[strip])
            return float(np.vdot(d[strip], image[strip])), on_set

        curvature, loads = zip(*problem.each(measured), strict=True)
        return sum(curvature), self.inverse @ sum(loads)

    def advance(self, at: GridIterate, length: float, dq: Array) -> tuple[float, float]:
        """Go a length back along the direction, gaps following a motion: largest change of displacement, and gap."""
        problem, work = self.problem, self.work

        def advanced(strip: slice) -> tuple[float, float]:
            moved = length * work.image[strip]
            size = _size(moved)
            at.p[strip] -= length * work.d[strip]
            at.u[strip] -= moved
            if len(dq):
                moved -= length * problem.motion(dq, strip)
            moved *= self.active[strip]
            work.gap[strip] -= moved
            return size, _size(work.gap[strip])

        changes, gaps = zip(*problem.each(advanced), strict=True)
        return max(changes), max(gaps)


def pseudo_inverse(gram: Array) -> Array:
    """Of a symmetric matrix (m, m) of few rows, where these may depend on each other."""
    if len(gram) == 1:
        return np.divide(1.0, gram, out=np.zeros((1, 1)), where=gram > 0)
    return np.asarray(np.linalg.pinv(gram, rcond=1e-12, hermitian=True), dtype=float)


def equalise(problem: GridProblem, at: GridIterate, tolerance: float, factor: float, work: Work) -> GridIterate:
    """Conjugate gradients on the set until the gaps have shrunk by a factor or are closed, in the iterate's arrays."""
    free = at.free
    balance = _Balance.of(problem, free, work)
    p, u, q, drift = at.p, at.u, at.q, at.drift
    missing = balance.inverse @ (problem.F - sum(problem.each(lambda strip: problem.loads(p, strip))))
    if missing.any():
        correction = problem.motion(missing, slice(None)) * free
        if np.abs(correction).max() > CARRIED * _size(p):
            p += correction
            u += problem.compliance.apply(correction)
    closed = 0.3 * tolerance * largest_displacement(problem, u)

    dq, largest = balance.take_gap(at)
    q, steps, before, first = q + dq, 0, 0.0, 0.0
    while steps < MAX_ITERATIONS and largest > closed:
        rows, rho = balance.precondition()
        first = first if steps else rho
        if rho <= factor**2 * first:
            break
        balance.turn(rows, rho / before if steps else 0.0)
        problem.rough.apply(work.d, work.image)
        curvature, motion = balance.measure()
        if curvature <= 0:
            break
        change, largest = balance.advance(at, rho / curvature, motion)
        q, drift = q + rho / curvature * motion, drift + ROUGHNESS * change
        before, steps = rho, steps + 1
    return replace(at, q=q, nit=at.nit + steps, rounds=at.rounds + 1, drift=drift)


def _size(values: Array) -> float:
    """Largest size of a value."""
    return max(float(values.max()), -float(values.min()))
