"""Nested iteration: the solution on a coarse grid, interpolated to the next finer one, is the start there.

Every grid is solved only around the expected contact. The gaps of the whole grid are checked afterwards: where the
surfaces penetrate outside the part, it is enlarged and solved again.

Active sets and projected, preconditioned conjugate gradients on a grid of cells.

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
import scipy.fft

from fecontact.common.arrays import Array, Mask
from fecontact.common.threads import each
from fecontact.halfspace.fft import (
    ROUGHNESS,
    Convolution,
    Corrected,
    DampedInverse,
    DiagonalTerm,
    Product,
    Tally,
    Term,
    kernel_spectrum,
    padded,
    strips,
)
from fecontact.halfspace.grid import Even, block_sums

#: Factor by which the gaps on the set shrink before the set is updated.
PER_ROUND = 0.2

MAX_ROUNDS = 150
#: Conjugate gradient steps on one set; the preconditioned method needs a dozen for ten digits.
MAX_ITERATIONS = 60

#: Share of the tolerance that the error of a result due to single precision may take; on the way, ten times as much.
DRIFT = 0.1

#: Change of the largest pressure, relative to it, up to which loads out of balance count as rounding.
CARRIED = 1e-12

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
        Threads, see `common.threads`.
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
    active, work = active & problem.allowed, _Work.of(problem.g.shape, len(problem.F))
    p = np.where(active, np.maximum(start, 0.0), 0.0)
    p = carry(problem, p if problem.bound is None else np.minimum(p, problem.bound))
    full = None if problem.bound is None else active & problem.at_bound(p)
    u = problem.compliance.apply(p)
    at = _with_free(problem, GridIterate(p, u, np.zeros(len(problem.F)), active, 0, 0, False, (), full=full))
    changed = True
    while at.rounds < MAX_ROUNDS:
        at = _equalise(problem, at, tolerance, PER_ROUND if changed else 0.0, work)
        found = _judged(problem, at, tolerance)
        if found.closes(tolerance) and at.drift > DRIFT * tolerance * found.scale:
            at = replace(at, u=problem.compliance.apply(at.p, at.u), drift=0.0)
            found = _judged(problem, at, tolerance)
        at = replace(at, history=(*at.history, found.left))
        if found.closes(tolerance):
            carry(problem, at.p)  # what preconditioning in single precision has left of the loads, some 1e-11 of them
            return replace(at, converged=True)
        changed = found.pulling or found.entering
        if found.pulling:
            at = _without_tension(problem, at, tolerance * found.scale, work)
        at = _with_free(problem, replace(at, active=found.active, full=found.full))
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
    scale = _largest(problem, at.u)
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


def _with_free(problem: GridProblem, at: GridIterate) -> GridIterate:
    """The iterate with free cells where all are at their bounds and do not bear the force.

    Those with the smallest gaps enter, or those with the smallest dents come back, as many as bear the difference.
    """
    if at.full is None or problem.bound is None or not len(problem.F) or at.free.any():
        return at
    lack = float(problem.F[0] - np.vdot(problem.B[0], at.p))
    candidates = np.flatnonzero(problem.allowed & ~at.active if lack > 0 else at.full)
    if abs(lack) <= CARRIED * problem.F[0] or not len(candidates):
        return at
    gap = (at.u + problem.g + problem.motion(at.q, slice(None))).ravel()[candidates]
    order = candidates[np.argsort(gap if lack > 0 else -gap, kind="stable")]
    bears = np.cumsum(problem.B[0].ravel()[order] * problem.bound.ravel()[order])
    some, active, full = order[: 1 + int(np.searchsorted(bears, abs(lack)))], at.active.copy(), at.full.copy()
    active.ravel()[some], full.ravel()[some] = True, False
    return replace(at, active=active, full=full)


def _largest(problem: GridProblem, u: Array) -> float:
    """Largest displacement under the counter-surface; in holes between it may be larger."""

    def largest(strip: slice) -> float:
        part, allowed = u[strip], problem.allowed[strip]
        return max(float(part.max(where=allowed, initial=0.0)), -float(part.min(where=allowed, initial=0.0)))

    return max(*problem.each(largest), SMALLEST)


def _without_tension(problem: GridProblem, at: GridIterate, most_drift: float, work: _Work) -> GridIterate:
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
class _Work:
    """Arrays that the rounds overwrite: gaps on the set, preconditioned ones, direction and its image (nx, ny).

    And `images` (m, nx, ny), the preconditioned rows.
    """

    gap: Array
    z: Array
    d: Array
    image: Array
    images: Array

    @classmethod
    def of(cls, shape: tuple[int, int], m: int) -> _Work:
        gap, z, d, image = (np.empty(shape) for _ in range(4))
        return cls(gap, z, d, image, np.empty((m, *shape)))


@dataclass(frozen=True, eq=False)
class _Balance:
    """Equilibrium rows on a set, and the preconditioner in the subspace of pressures that do not change the loads."""

    problem: GridProblem
    active: Mask
    work: _Work
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


def _balance(problem: GridProblem, active: Mask, work: _Work) -> _Balance:
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


def _equalise(problem: GridProblem, at: GridIterate, tolerance: float, factor: float, work: _Work) -> GridIterate:
    """Conjugate gradients on the set until the gaps have shrunk by a factor or are closed, in the iterate's arrays."""
    free = at.free
    balance = _balance(problem, free, work)
    p, u, q, drift = at.p, at.u, at.q, at.drift
    missing = balance.missing(p)
    if sum(abs(f) * _size(image) for f, image in zip(missing, work.images, strict=True)) > CARRIED * _size(p):
        correction = np.tensordot(missing, work.images, 1)
        p += correction
        u += problem.compliance.apply(correction)
    closed = 0.3 * tolerance * _largest(problem, u)

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


def _advance(problem: GridProblem, at: GridIterate, free: Mask, length: float, work: _Work) -> float:
    """Go a length back along the direction: pressures, displacements and gaps; the largest change of displacement."""

    def advance(strip: slice) -> float:
        moved = length * work.image[strip]
        at.p[strip] -= length * work.d[strip]
        at.u[strip] -= moved
        work.gap[strip] -= moved * free[strip]
        return _size(moved)

    return float(max(problem.each(advance)))


def _turn(problem: GridProblem, factor: float, work: _Work) -> None:
    """Turn the direction d to z + factor d."""

    def turn(strip: slice) -> None:
        work.d[strip] *= factor
        work.d[strip] += work.z[strip]

    problem.each(turn)


def _size(values: Array) -> float:
    """Largest size of a value."""
    return max(float(values.max()), -float(values.min()))


#: Largest number of cells per side of the coarsest grid.
COARSEST = 24

#: Tolerance on the coarser grids, below their discretisation error.
COARSE_TOLERANCE = 1e-3

#: Tolerance from which single precision suffices throughout.
ROUGH_ENOUGH = 1e-4

#: Cells added round the expected contact, besides a thirtieth of its width.
MARGIN = 2

#: Mean gap, over the largest, at which the force on a periodic surface counts as unbounded.
MEAN_PLANE = 1e-9

#: Share of the grid above which the whole grid is solved instead of a part.
WORTHWHILE = 0.75


@dataclass(frozen=True, eq=False)
class GridLevel:
    """The contact problem on one grid, on the half or quarter with positive coordinates where it is symmetric.

    Attributes
    ----------
    kernel : (kx, ky) array
        Free: displacements at offsets 0, 1, ... cells by unit pressure on a cell. Periodic: spectrum (half the number
        of cells plus one in each direction).
    periodic : bool
    g : (nx, ny) array
        Gap without pressure; any finite number where there is no counter-surface.
    allowed : (nx, ny) bool array
    B : (m, nx, ny) array
    F : (m,) array
        Loads; with symmetry, those of the modelled part.
    symmetric : (bool, bool)
    smooth : tuple of Term
        Additions to the compliance, over the modelled part.
    arrays : str, optional
        Module whose arrays are transformed, see `array_module`.
    bound : (nx, ny) array, optional
        Largest pressures, see `GridProblem`.
    depth : int
        How often the grid was coarsened by two.
    """

    kernel: Array
    periodic: bool
    g: Array
    allowed: Mask
    B: Array
    F: Array
    symmetric: Even
    smooth: tuple[Term, ...] = ()
    arrays: str | None = None
    bound: Array | None = None
    depth: int = 0

    @property
    def whole(self) -> tuple[slice, slice]:
        """The part that covers the whole grid."""
        return slice(0, self.g.shape[0]), slice(0, self.g.shape[1])

    @property
    def is_bounded(self) -> bool:
        """False if no pressures open the gaps: beyond the mean plane of a periodic surface, which none displaces."""
        stiff = self.periodic and not self.kernel[0, 0] and not len(self.F) and self.allowed.all()
        size = float(np.abs(self.g).max()) if stiff else 0.0
        return not (size and self.g.min() < 0 and self.g.mean() <= MEAN_PLANE * size)


def compliance(level: GridLevel, part: tuple[slice, slice], tally: Tally, workers: int | None) -> Product:
    """Compliance among the cells of a part of a grid."""
    shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
    spectrum = level.kernel
    if not level.periodic:
        cells = _cells(shape, level.symmetric)
        spectrum = kernel_spectrum(level.kernel[: cells[0], : cells[1]], (padded(cells[0]), padded(cells[1])))
    convolution = Convolution.even(spectrum, shape, level.symmetric, tally, workers=workers, arrays=level.arrays)
    return Corrected(convolution, tuple(term.part(part) for term in level.smooth)) if level.smooth else convolution


def preconditioner(
    level: GridLevel, part: tuple[slice, slice], tally: Tally, workers: int | None
) -> Convolution | DampedInverse:
    """Inverse symbol of the compliance of a part, as if periodic, without padding; with that of cells by themselves."""
    shape = (part[0].stop - part[0].start, part[1].stop - part[1].start)
    spectrum = level.kernel
    if not level.periodic:
        cells = _cells(shape, level.symmetric)
        halves = tuple(max(1, (n + 1) // 2) for n in cells)
        spectrum = kernel_spectrum(level.kernel[: cells[0], : cells[1]], (halves[0], halves[1]))
    largest = float(spectrum.max())
    inverse = 1 / np.where(spectrum > 1e-9 * largest, spectrum, largest)
    options = {"product": False, "workers": workers, "arrays": level.arrays}
    bodies = Convolution.even(inverse, shape, level.symmetric, tally, **options)
    alone = [term.own[part] for term in level.smooth if isinstance(term, DiagonalTerm)]
    if not alone:
        return bodies
    own = float(spectrum.mean())
    both = own + np.sum(alone, axis=0)
    return DampedInverse(bodies, np.sqrt(own / both), (1 - own / both) / both)


def _cells(shape: tuple[int, int], symmetric: Even) -> tuple[int, int]:
    return (shape[0] * (1 + symmetric[0]), shape[1] * (1 + symmetric[1]))


def coarser(level: GridLevel, kernel: Array) -> GridLevel:
    """The level on cells twice as large; a row that extends beyond the grid has no counter-surface.

    Gaps and bounds are means, rows are sums over the cells that have a counter-surface.
    """
    count = block_sums(level.allowed.astype(np.int8))
    everywhere = bool(level.allowed.all())
    g = block_sums(level.g if everywhere else level.g * level.allowed) / np.maximum(count, 1)
    B = block_sums(level.B if everywhere else level.B * level.allowed)
    smooth = tuple(term.coarser() for term in level.smooth)
    bound = level.bound
    if bound is not None:
        bound = block_sums(bound if everywhere else np.where(level.allowed, bound, 0.0)) / np.maximum(count, 1)
        bound = np.where(count > 0, bound, np.inf)
    return replace(level, kernel=kernel, g=g, allowed=count > 0, B=B, smooth=smooth, bound=bound, depth=level.depth + 1)


def finer(values: Array, shape: tuple[int, int], symmetric: Even, periodic: bool) -> Array:
    """Values of a coarse grid interpolated linearly at the cells of the next finer one, of the given shape."""
    for axis in (0, 1):
        v = np.moveaxis(values, axis, 0)
        closed = periodic and not symmetric[axis]
        near, far = 0.75 * v, 0.25 * v
        out = np.empty((2 * len(v), v.shape[1]))
        out[0], out[-1] = near[0] + far[-1 if closed else 0], near[-1] + far[0 if closed else -1]
        np.add(near[1:], far[:-1], out=out[2::2])
        np.add(near[:-1], far[1:], out=out[1:-1:2])
        values = np.moveaxis(out[: shape[axis]], 0, axis)
    return np.ascontiguousarray(values)


def start_on(level: GridLevel, coarse: Array) -> tuple[Array, Mask]:
    """Start (nx, ny) and active cells of a level from the pressures of the next coarser one.

    Squares of the pressure fall linearly to the edge. Continued so to the next cell outside and interpolated, they tell
    where the edge is within the coarse cells. Beyond these all is zero.
    """
    shape, whole = level.g.shape, (slice(0, coarse.shape[0]), slice(0, coarse.shape[1]))
    start, active = np.zeros(shape), np.zeros(shape, bool)
    box = whole if level.periodic else around(coarse > 0, level.symmetric)
    part = tuple(slice(2 * s.start, min(2 * s.stop, n)) for s, n in zip(box, shape, strict=True))
    squares = _continued(coarse[box] ** 2, level.symmetric, level.periodic)
    squares = finer(squares, start[part].shape, level.symmetric, level.periodic)
    np.logical_and(squares > 0, level.allowed[part], out=active[part])
    np.sqrt(np.maximum(squares, 0.0, out=squares), out=start[part])
    return start, active


def _continued(squares: Array, symmetric: Even, periodic: bool) -> Array:
    """Values (nx, ny), positive where there is contact, continued linearly to the zeros beside, where they fall."""
    total, count = np.zeros(squares.shape), np.zeros(squares.shape)
    for axis in (0, 1):
        v = np.moveaxis(squares, axis, 0)
        ends = [(2, 2), (0, 0)]
        wide = np.pad(v, ends, "wrap" if periodic else "symmetric")
        if not symmetric[axis] and not periodic:
            wide[:2] = 0.0
        if not periodic:
            wide[-2:] = 0.0
        for near, far in ((wide[1:-3], wide[:-4]), (wide[3:-1], wide[4:])):
            found = (v == 0) & (near > 0) & (far > 0)
            np.moveaxis(total, axis, 0)[found] += (2 * near - far)[found]
            np.moveaxis(count, axis, 0)[found] += 1
    return squares + np.minimum(total, 0.0) / np.maximum(count, 1)


def around(active: Mask, symmetric: Even) -> tuple[slice, slice]:
    """Part of a grid round the cells that may touch, of a size with a fast transform."""
    out = []
    for axis in (0, 1):
        hit = np.flatnonzero(active.any(axis=1 - axis))
        n = active.shape[axis]
        if len(hit) == 0:
            return slice(0, active.shape[0]), slice(0, active.shape[1])
        margin = MARGIN + int(hit[-1] - hit[0]) // 30
        first = 0 if symmetric[axis] else max(0, int(hit[0]) - margin)
        wanted = scipy.fft.next_fast_len(int(hit[-1]) + 1 + margin - first, real=True)
        last = min(n, first + wanted)
        out.append(slice(first, last))
    return out[0], out[1]


def solve_level(
    level: GridLevel, start: Array, active: Mask, tolerance: float, tally: Tally, workers: int | None
) -> GridIterate:
    """Solve on the part of a grid round the start's contact, enlarged while there is contact beyond it.

    Displacements outside the part are found with it.
    """
    part = level.whole if level.periodic else around(active, level.symmetric)
    if _share(part, level) > WORTHWHILE:
        part = level.whole
    while True:
        exact, inverse = compliance(level, part, tally, workers), preconditioner(level, part, tally, workers)
        rough = exact
        if not level.periodic:  # for a periodic one the preconditioner is the exact inverse, and the start may be exact
            rough, inverse = exact.rough, inverse.rough
        problem = GridProblem(
            exact if tolerance < ROUGH_ENOUGH else rough,
            rough,
            inverse,
            level.g[part],
            level.allowed[part],
            level.B[:, *part],
            level.F,
            bound=None if level.bound is None else level.bound[part],
        )
        at = solve_on_grid(problem, start[part], active[part], tolerance)
        if part == level.whole:
            return at
        at = _spread(at, level, part, tolerance, tally, workers)
        if _reaches_border(at.active, part):
            start, active, part = at.p, at.active, level.whole
            continue
        missed = _penetrating(at, level, tolerance)
        missed[part] = False
        if not missed.any():
            return at
        start, active = at.p, at.active | missed
        missed[part] = True
        part = around(missed, level.symmetric)
        if _share(part, level) > WORTHWHILE:
            part = level.whole


def _share(part: tuple[slice, slice], level: GridLevel) -> float:
    return (part[0].stop - part[0].start) * (part[1].stop - part[1].start) / level.g.size


def _spread(
    at: GridIterate,
    level: GridLevel,
    part: tuple[slice, slice],
    tolerance: float,
    tally: Tally,
    workers: int | None,
) -> GridIterate:
    """Solution on a part as arrays over the whole grid."""
    p, active = np.zeros(level.g.shape), np.zeros(level.g.shape, bool)
    p[part], active[part] = at.p, at.active
    operator = compliance(level, level.whole, tally, workers)
    if tolerance >= ROUGH_ENOUGH:
        operator = operator.rough
    return replace(at, p=p, u=operator.apply(p), active=active, recomputed=tolerance < ROUGH_ENOUGH)


def _penetrating(at: GridIterate, level: GridLevel, tolerance: float) -> Mask:
    """Cells whose surfaces penetrate by more than a tolerance of the largest displacement."""
    gap = at.u + level.g + np.einsum("k,kij->ij", at.q, level.B)
    largest = float(np.abs(at.u).max(where=level.allowed, initial=0.0))
    return np.asarray(level.allowed & (gap < -tolerance * largest))


def _reaches_border(active: Mask, part: tuple[slice, slice]) -> bool:
    """Whether cells in contact lie at a border of the part inside the grid."""
    touching = False
    for axis in (0, 1):
        lines = np.moveaxis(active, axis, 0)
        first, last = part[axis].start, part[axis].stop
        touching |= first > 0 and bool(lines[first].any())
        touching |= last < len(lines) and bool(lines[last - 1].any())
    return touching


#: Solution of a level from a start and active cells, as by `solve_level`.
LevelSolver = Callable[[GridLevel, Array, Mask, float, Tally, int | None], GridIterate]


def solve_nested(
    level: GridLevel,
    kernel_of: Callable[[int], Array],
    tolerance: float,
    tally: Tally,
    workers: int | None = None,
    solve: LevelSolver = solve_level,
) -> tuple[GridIterate, int, Array | None]:
    """Solve on a grid, starting from coarser ones.

    Parameters
    ----------
    level : GridLevel
        The finest level.
    kernel_of : function of int
        Kernel of the grid coarsened that many times by two.
    tolerance : float
        See `solve_on_grid`.
    tally : Tally
    workers : int, optional
    solve : callable
        Of each level.

    Returns
    -------
    iterate : GridIterate
        Solution on the finest grid.
    n_levels : int
    coarse : (mx, my) array or None
        Pressure on the next coarser grid; None without one.
    """
    start, active, n_levels, coarse = solve_coarser(level, kernel_of, tolerance, tally, workers, solve)
    return solve(level, start, active, tolerance, tally, workers), n_levels, coarse


def solve_coarser(
    level: GridLevel,
    kernel_of: Callable[[int], Array],
    tolerance: float,
    tally: Tally,
    workers: int | None = None,
    solve: LevelSolver = solve_level,
) -> tuple[Array, Mask, int, Array | None]:
    """Start (nx, ny) and active cells of a grid from coarser ones; number of grids, pressure on the next coarser."""
    levels = [level]
    while max(_cells(levels[-1].g.shape, level.symmetric)) > COARSEST and can_coarsen(levels[-1]):
        levels.append(coarser(levels[-1], kernel_of(len(levels))))
        if not levels[-1].is_bounded:  # larger cells have closed holes of the counter-surface
            levels.pop()
            break
    first, coarse = levels[-1], None
    # overlapping cells if the approach is prescribed, else all
    start, active = np.zeros(first.g.shape), first.allowed & (first.g < 0) if len(first.F) == 0 else first.allowed
    for k in range(len(levels) - 1, 0, -1):
        at = solve(levels[k], start, active, max(tolerance, COARSE_TOLERANCE), tally, workers)
        coarse = np.maximum(at.p, 0.0)
        start, active = start_on(levels[k - 1], coarse)
    return start, active, len(levels), coarse


def can_coarsen(level: GridLevel) -> bool:
    """Whether the level can be coarsened: a period must remain an even number of cells."""
    cells = _cells(level.g.shape, level.symmetric)
    return min(cells) >= 8 and (not level.periodic or (cells[0] % 4 == 0 and cells[1] % 4 == 0))
