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
        return each(work, strips(*self.g.shape), self.workers)

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
    active, work = active & problem.allowed, Work.of(problem.g.shape, len(problem.F))
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
    factors = np.linalg.lstsq(gram, problem.F - carried, rcond=1e-12)[0]

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
    """Arrays that the rounds overwrite: gaps on the set, preconditioned ones, direction and its image (nx, ny).

    And `images` (m, nx, ny), the preconditioned rows.
    """

    gap: Array
    z: Array
    d: Array
    image: Array
    images: Array

    @classmethod
    def of(cls, shape: tuple[int, int], m: int) -> Work:
        """Arrays of a shape, for m rows."""
        gap, z, d, image = (np.empty(shape) for _ in range(4))
        return cls(gap, z, d, image, np.empty((m, *shape)))


@dataclass(frozen=True, eq=False)
class _Balance:
    """Equilibrium rows on a set, and the preconditioner in the subspace of pressures that do not change the loads."""

    problem: GridProblem
    active: Mask
    work: Work
    inverse: Array

    def precondition(self) -> tuple[Array, float, float]:
        """Precondition the gap, without change of the loads: the change of the multiplier (m,).

        The gap follows the multiplier. Also its product with the preconditioned one, and its largest size.
        """
        problem, gap, z, images = self.problem, self.work.gap, self.work.z, self.work.images
        problem.preconditioner.apply(gap, z)

        def mask(strip: slice) -> Array:
            z[strip] *= self.active[strip]
            return problem.loads(z, strip)

        dq = -self.inverse @ sum(problem.each(mask))

        def follow(strip: slice) -> tuple[float, float]:
            if len(dq):
                z[strip] += np.einsum("k,kij->ij", dq, images[:, strip])
                gap[strip] += problem.motion(dq, strip) * self.active[strip]
            return float(np.vdot(gap[strip], z[strip])), _size(gap[strip])

        rho, largest = zip(*problem.each(follow), strict=True)
        return dq, sum(rho), max(largest)

    def take_gap(self, at: GridIterate) -> Array:
        """Gap on the set less a rigid motion (m,): beside this the preconditioner's single precision would lose it."""
        problem, gap, images = self.problem, self.work.gap, self.work.images

        def take(strip: slice) -> Array:
            gap[strip] = (at.u[strip] + problem.g[strip] + problem.motion(at.q, strip)) * self.active[strip]
            return np.einsum("kij,ij->k", images[:, strip], gap[strip])

        motion = -self.inverse @ sum(problem.each(take))

        def move(strip: slice) -> None:
            gap[strip] += problem.motion(motion, strip) * self.active[strip]

        problem.each(move)
        return np.asarray(motion)

    def missing(self, p: Array) -> Array:
        """Factors (m,) of the images that make p balance the loads."""
        carried = sum(self.problem.each(lambda strip: self.problem.loads(p, strip)))
        return np.asarray(self.inverse @ (self.problem.F - carried))


def _balance(problem: GridProblem, active: Mask, work: Work) -> _Balance:
    m = len(problem.F)
    for row, image in zip(problem.B, work.images, strict=True):
        np.multiply(row, active, out=work.z)
        problem.preconditioner.apply(work.z, image)
        image *= active
    gram = sum(
        problem.each(lambda strip: np.array([problem.loads(image, strip) for image in work.images]).reshape(m, m))
    )
    inverse = np.asarray(np.linalg.pinv((gram + gram.T) / 2, rcond=1e-12, hermitian=True), dtype=float)
    return _Balance(problem, active, work, inverse)


def equalise(problem: GridProblem, at: GridIterate, tolerance: float, factor: float, work: Work) -> GridIterate:
    """Conjugate gradients on the set until the gaps have shrunk by a factor or are closed, in the iterate's arrays."""
    free = at.free
    balance = _balance(problem, free, work)
    p, u, q, drift = at.p, at.u, at.q, at.drift
    missing = balance.missing(p)
    if sum(abs(f) * _size(image) for f, image in zip(missing, work.images, strict=True)) > CARRIED * _size(p):
        correction = np.tensordot(missing, work.images, 1)
        p += correction
        u += problem.compliance.apply(correction)
    closed = 0.3 * tolerance * largest_displacement(problem, u)

    q = q + balance.take_gap(at)
    dq, rho, largest = balance.precondition()
    work.d[...] = work.z
    first, steps, q = rho, 0, q + dq
    while steps < MAX_ITERATIONS and largest > closed and rho > factor**2 * first:
        problem.rough.apply(work.d, work.image)
        curvature = sum(problem.each(lambda strip: float(np.vdot(work.d[strip], work.image[strip]))))
        if curvature <= 0:
            break
        drift += ROUGHNESS * _advance(problem, at, free, rho / curvature, work)
        before, steps = rho, steps + 1
        dq, rho, largest = balance.precondition()
        q = q + dq
        _turn(problem, rho / before, work)
    return replace(at, q=q, nit=at.nit + steps, rounds=at.rounds + 1, drift=drift)


def _advance(problem: GridProblem, at: GridIterate, free: Mask, length: float, work: Work) -> float:
    """Go a length back along the direction: pressures, displacements and gaps; the largest change of displacement."""

    def advance(strip: slice) -> float:
        moved = length * work.image[strip]
        at.p[strip] -= length * work.d[strip]
        at.u[strip] -= moved
        work.gap[strip] -= moved * free[strip]
        return _size(moved)

    return float(max(problem.each(advance)))


def _turn(problem: GridProblem, factor: float, work: Work) -> None:
    """Turn the direction d to z + factor d."""

    def turn(strip: slice) -> None:
        work.d[strip] *= factor
        work.d[strip] += work.z[strip]

    problem.each(turn)


def _size(values: Array) -> float:
    """Largest size of a value."""
    return max(float(values.max()), -float(values.min()))
