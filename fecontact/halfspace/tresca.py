"""Tangential tractions of given limits on a grid: semismooth Newton and preconditioned conjugate gradients.

With the pressures fixed, the limits of friction are too (Tresca's law) and the tractions minimise a convex energy. Each
Newton step keeps the cells that stick, whose slip is to vanish, and turns the tractions of those that slip: with z = q
- r s outside the disc of radius f, n = z/|z| and t across it, q . n = f and s . t + D q . t = 0, D = (|z| - f)/(r f).
In the unknowns left, two for a cell that sticks and one for a cell that slips, the matrix is that of the energy plus
the diagonal D, symmetric and positive definite.

The slip is recomputed after each Newton step; within it the changes are in single precision.

A compliance that is monotone but not symmetric, as of steady rolling, has no energy; the same equations are then solved
by GMRES. There limits may depend on the slip, f(s): where it slips q . n = f turns into d q . n = (df/ds) . d s, a
second unknown of the cell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from fecontact.common.arrays import Array, Mask
from fecontact.halfspace.compliance import TangentialCompliance
from fecontact.halfspace.grid import block_sums
from fecontact.halfspace.nested import COARSE_TOLERANCE, COARSEST, finer
from fecontact.solvers.coulomb import projected

#: 1/r over the displacement of a cell by itself; with 1, many cells that stick are taken to slip, far from the answer.
#: The compliance of rolling is a difference of neighbours: 2 there; with 4 and more Newton's method may go in circles.
WEIGHED, WEIGHED_ROLLING = 16, 2

MAX_ROUNDS = 20
#: How often limits follow the slip, how closely tractions are solved for over the defect, its fall from which Newton's
#: method is tried, near one solution of several, and how often it is tried without.
MAX_LIMITS, HELD, CONTRACTS, EVERY = 100, 0.03, 0.5, 10
PATIENCE = 6
PROGRESS = 0.7
ALTERNATIONS = 30
#: Conjugate gradient steps in one Newton step.
MAX_ITERATIONS = 200

#: Shares of a Newton step taken where it goes astray without an energy, and steps whose defects it is to be below.
SHORTER, MEMORY = (0.5, 0.25), 5

#: Steps of GMRES in one Newton step, and its least relative residual: products are in single precision.
MAX_GMRES, FINEST = 80, 1e-4

#: Defect of a start from which Newton's method is tried without coarser grids.
CLOSE = 0.05

#: Factor by which conjugate gradients reduce the residual in one Newton step, while cells change.
PER_NEWTON = 1e-2


@dataclass(frozen=True, eq=False)
class TrescaProblem:
    """Tractions q on the cells of a box: s = A q + c - B^T m, |q| <= f, s opposite to q where |q| = f, 0 elsewhere.

    Attributes
    ----------
    compliance : TangentialCompliance
        A.
    limit : (bx, by) array
        f; zero where nothing touches, infinite where surfaces are rough.
    c : (2, bx, by) array
        Slip without tractions and motion.
    B : (k, 2, bx, by) array
        Displacements by the free rigid motions of the counter-surface.
    F : (k,) array
        Loads on them: B q = F.
    alone : (bx, by) array, or 0
        Compliance of cells by themselves, added to A.
    law : function of slips (2, bx, by), optional
        Limits, and their derivatives (2, bx, by), where they depend on the slip; `limit` is then where to start from.
    """

    compliance: TangentialCompliance
    limit: Array
    c: Array
    B: Array
    F: Array
    alone: Array | float = 0.0
    law: Callable[[Array], tuple[Array, Array]] | None = None

    def limits(self, s: Array) -> tuple[Array, Array | None]:
        """Limits at slips (2, bx, by), and their derivatives if they depend on them."""
        return (self.limit, None) if self.law is None else self.law(s)

    @property
    def touching(self) -> Mask:
        """Cells that may carry tractions."""
        return self.limit > 0

    def slip(self, q: Array, m: Array) -> Array:
        """Slip (2, bx, by) by tractions and motions."""
        return self.compliance.apply(q) + self.alone * q + self.c - np.tensordot(m, self.B, 1)

    def correct(self, change: Array) -> Array:
        """Change of slip by one of tractions, in single precision."""
        return self.compliance.correct(change) + self.alone * change


@dataclass(frozen=True, eq=False)
class TrescaIterate:
    """Tractions, motions and slip.

    Attributes
    ----------
    q, s : (2, bx, by) arrays
    m : (k,) array
    newton, nit : int
        Newton steps and steps of conjugate gradients.
    defect : float
        Largest |q - P(q - r s)| over the largest limit, with r = 1/`TangentialCompliance.own`, and error of B q = F.
    """

    q: Array
    s: Array
    m: Array
    newton: int = 0
    nit: int = 0
    defect: float = np.inf


def solve_nested_tresca(
    problem: TrescaProblem,
    compliance_of: Callable[[int, tuple[int, int]], TangentialCompliance],
    q: Array,
    m: Array,
    tolerance: float,
    level: int = 0,
    finest: int = 0,
) -> TrescaIterate:
    """Solve a problem, starting from its solution on cells twice as large, and so on.

    Parameters
    ----------
    problem : TrescaProblem
    compliance_of : function of int and (int, int)
        Compliance of the grid coarsened that many times by two, among as many cells.
    q : (2, bx, by) array
        Tractions to start from; taken as they are if they solve the problem.
    m : (k,) array
        Motions to start from.
    tolerance : float
    level : int
        How often the problem has been coarsened.
    finest : int
        How often it is to be: on finer cells tractions are interpolated.

    Returns
    -------
    TrescaIterate
    """
    q = np.where(problem.touching, q, 0.0)
    at = _measured(problem, TrescaIterate(q, problem.slip(q, m), m))
    if at.defect <= tolerance:
        return at
    if at.defect <= CLOSE and (near := solve_tresca(problem, q, m, tolerance)).defect <= tolerance:
        return near
    shape = problem.limit.shape
    halves = ((shape[0] + 1) // 2, (shape[1] + 1) // 2)
    odd = problem.compliance.periodic and (halves[0] % 2 or halves[1] % 2)
    if max(shape) > COARSEST and min(shape) >= 4 and not odd:
        coarse = coarser_tresca(problem, compliance_of(level + 1, halves))
        start = _means(q, problem.touching)
        within = max(tolerance, COARSE_TOLERANCE)
        below = solve_nested_tresca(coarse, compliance_of, start, m, within, level + 1, finest)
        q, m = _finer(coarse, below.q, problem), below.m
        if level < finest:
            q = projected(q, problem.limit)
            return replace(below, q=q, s=problem.slip(q, m))
    return solve_tresca(problem, q, m, tolerance)


def _finer(coarse: TrescaProblem, q: Array, problem: TrescaProblem) -> Array:
    """Tractions of a problem on cells half as large: shares of the limits are interpolated, 1 where it slips."""
    least, periodic = np.where(coarse.touching, coarse.limit, np.inf), problem.compliance.periodic
    over, most = (np.where(np.isfinite(limit), limit, 1.0) for limit in (least, problem.limit))

    def interpolated(values: Array) -> Array:
        return finer(values, problem.limit.shape, (False, False), periodic)

    known = np.maximum(interpolated(coarse.touching.astype(float)), 1e-300)
    return np.stack([interpolated(part / over) / known for part in q]) * most


def coarser_tresca(problem: TrescaProblem, compliance: TangentialCompliance) -> TrescaProblem:
    """The problem on cells twice as large, with the means of limits, slip and rows over the touching cells."""
    c, B = _means(problem.c, problem.touching), _means(problem.B, problem.touching)
    return TrescaProblem(compliance, block_sums(problem.limit) / 4, c, B, problem.F / 4)


def _means(values: Array, touching: Mask) -> Array:
    """Means (..., mx, my) over the touching cells of blocks of 2 x 2; zero where none is touching."""
    count = block_sums(touching.astype(float))
    return np.asarray(block_sums(np.where(touching, values, 0.0)) / np.maximum(count, 1))


def solve_tresca(problem: TrescaProblem, q: Array, m: Array, tolerance: float) -> TrescaIterate:
    """Solve from tractions (2, bx, by) and motions (k,); the caller judges the `defect`.

    Newton's method, and where it does not converge, alternating directions from where it started, and so on.
    """
    q = projected(np.where(problem.touching, q, 0.0), problem.limit)
    at = _measured(problem, TrescaIterate(q, problem.slip(q, m), m))
    if problem.law is not None:
        return _following(problem, at, tolerance)
    for _ in range(MAX_ROUNDS):
        found = _newton(problem, at, tolerance)
        if found.defect <= tolerance:
            return found
        at = _alternate(problem, replace(at, newton=found.newton, nit=found.nit))
    return at


def _following(problem: TrescaProblem, at: TrescaIterate, tolerance: float) -> TrescaIterate:
    """Limits follow the slip before, and by Newton's method where that comes closer, or never does."""
    for k in range(1, MAX_LIMITS + 1):
        if at.defect <= tolerance:
            break
        held = replace(problem, law=None, limit=problem.limits(at.s)[0])
        by = solve_tresca(held, at.q, at.m, max(tolerance, HELD * at.defect))
        before, at = at, _measured(problem, replace(by, newton=at.newton + by.newton, nit=at.nit + by.nit))
        if at.defect > tolerance and (at.defect < CONTRACTS * before.defect or k % EVERY == 0):
            found = _newton(problem, at, tolerance)
            if found.defect <= tolerance:
                return found
            at = replace(at, newton=found.newton, nit=found.nit)
    return at


def _newton(problem: TrescaProblem, at: TrescaIterate, tolerance: float) -> TrescaIterate:
    """Newton steps while `PATIENCE` of them come closer by `PROGRESS`; the closest iterate."""
    best, mark, since, recent = at, at.defect, 0, [at.defect]
    while at.defect > tolerance and since < PATIENCE:
        at = _newton_step(problem, at, tolerance, max(recent[-MEMORY:]))
        recent.append(at.defect)
        best = at if at.defect < best.defect else replace(best, newton=at.newton, nit=at.nit)
        mark, since = (at.defect, 0) if at.defect < PROGRESS * mark else (mark, since + 1)
    return best


def _alternate(problem: TrescaProblem, at: TrescaIterate) -> TrescaIterate:
    """Alternating directions: tractions with the loads in balance that keep near others on the discs, and back.

    Converges from any start, the problem being convex, if slowly.

    References
    ----------
    S. Boyd et al., Found. Trends Mach. Learn. 3 (2011) 1, sections 3 and 5.
    """
    near = problem.compliance.own * max(problem.limit.shape) ** 0.5
    D, (limit, _) = np.full(problem.limit.shape, near), problem.limits(at.s)
    weight = np.sqrt(problem.compliance.own / (problem.compliance.own + D))
    linear = LinearStep(problem, problem.touching, np.zeros(at.q.shape), D, weight)
    disc, scaled = at.q, np.where(problem.touching, -at.s / near, 0.0)
    for _ in range(ALTERNATIONS):
        at = _solve_linear(linear, at, np.zeros(at.q.shape), disc - scaled, 0.0, PER_NEWTON)
        disc = projected(at.q + scaled, limit)
        scaled = scaled + at.q - disc
    return _measured(problem, replace(at, q=disc, s=problem.slip(disc, at.m)))


def _measured(problem: TrescaProblem, at: TrescaIterate) -> TrescaIterate:
    r = 1 / problem.compliance.own
    size, (limit, _) = float(np.abs(at.q).max(initial=0.0)), problem.limits(at.s)
    finite = problem.limit[np.isfinite(problem.limit)]
    scale = max(size, float(finite.max(initial=0.0)), 1e-300)
    moved = np.where(problem.touching, projected(at.q - r * at.s, limit) - at.q, 0.0)
    total = float(np.abs(at.q).sum()) + 1e-300
    missing = np.abs(problem.F - np.tensordot(problem.B, at.q, 3))
    reach = np.abs(problem.B).max(axis=(1, 2, 3), initial=0.0)
    balance = float((missing / (reach * max(total, scale))).max(initial=0.0))
    return replace(at, defect=max(float(np.abs(moved).max(initial=0.0)) / scale, balance))


@dataclass(frozen=True, eq=False)
class LinearStep:
    """Linear equations of a Newton step on the unknowns left by a projection."""

    problem: TrescaProblem
    stick: Mask
    across: Array
    D: Array
    weight: Array
    grade: Array | None = None

    def project(self, v: Array) -> Array:
        """Part of vectors (2, bx, by) in the unknowns: all where it sticks, across the traction where it slips."""
        return np.where(self.stick, v, (v * self.across).sum(axis=0) * self.across)

    def along(self, v: Array) -> Array | float:
        """Part of vectors (2, bx, by) along the traction where it slips."""
        return v - self.project(v)

    def follow(self, s: Array) -> Array | float:
        """What limits change by with slips (2, bx, by), along the tractions; zero where they do not depend on them."""
        if self.grade is None:
            return 0.0
        n = np.stack([self.across[1], -self.across[0]])
        return (self.grade * s).sum(axis=0) * n

    def image(self, s: Array) -> Array:
        """Left side of the equations by a change of slips alone."""
        return self.project(s) - self.problem.compliance.own * self.follow(s)

    def product(self, d: Array) -> tuple[Array, Array]:
        """Displacements by a change d of tractions, and the matrix times d."""
        u = self.problem.correct(d)
        found = self.project(u + self.D * d)
        if self.grade is not None:
            found += self.problem.compliance.own * (self.along(d) - self.follow(u))
        return u, found

    @cached_property
    def _rest(self) -> Array:
        """What the inverse in wave numbers leaves to that of D."""
        alone = self.D + np.maximum(self.problem.alone, 0.0)
        return np.asarray((1 - self.weight**2) / (alone + self.problem.compliance.own))

    def precondition(self, v: Array) -> Array:
        """Inverse of the compliance in wave numbers where D is small, of D where it is large."""
        own, w = self.problem.compliance.own, v if self.grade is None else self.project(v)
        inner = self.project(self.problem.compliance.precondition(self.weight * w))
        found = self.weight * inner + self._rest * w
        return found if self.grade is None else found + self.along(v) / own


def _linear(problem: TrescaProblem, at: TrescaIterate) -> tuple[LinearStep, Array]:
    """Equations at an iterate, and the change of tractions along themselves that puts those that slip on their disc."""
    own = problem.compliance.own
    weighed = (WEIGHED if problem.compliance.symmetric else WEIGHED_ROLLING) * own
    z = at.q - at.s / weighed
    size, (f, grade) = np.hypot(z[0], z[1]), problem.limits(at.s)
    slips = problem.touching & (size > f)
    stick = problem.touching & ~slips
    safe = np.where(slips, size, 1.0)
    n = np.where(slips, z / safe, 0.0)
    limit = np.where(slips, np.maximum(f, 1e-300), 1.0)
    D = np.where(slips, (size - limit) * weighed / limit, 0.0)
    outwards = np.where(slips, limit, 0.0) * n - (at.q * n).sum(axis=0) * n
    weight = np.sqrt(own / (own + D + np.maximum(problem.alone, 0.0)))
    grade = None if grade is None else np.where(slips, grade, 0.0)
    return LinearStep(problem, stick, np.stack([-n[1], n[0]]), D, weight, grade), outwards


def _newton_step(problem: TrescaProblem, at: TrescaIterate, tolerance: float, most: float) -> TrescaIterate:
    """One step; without an energy, halved twice at most while its defect is not below that of the last few."""
    linear, change = _linear(problem, at)
    small = 0.1 * tolerance * problem.compliance.own * float(np.abs(at.q + change).max(initial=0.0))
    factor = PER_NEWTON if at.defect > 1e3 * tolerance else 0.0
    to = _solve_linear(linear, at, change, np.zeros(at.q.shape), small, factor)
    q = projected(to.q, np.where(linear.stick, np.inf, problem.limits(to.s)[0]))
    found = _measured(problem, replace(to, q=q, s=problem.slip(q, to.m), newton=at.newton + 1))
    for share in () if problem.compliance.symmetric else SHORTER:
        if found.defect < most:
            break
        s = at.s + share * (to.s - at.s)
        q, m = projected(at.q + share * (to.q - at.q), problem.limits(s)[0]), at.m + share * (to.m - at.m)
        found = _measured(problem, replace(found, q=q, m=m, s=problem.slip(q, m)))
    return found


def _solve_linear(
    linear: LinearStep, at: TrescaIterate, change: Array, anchor: Array, small: float, factor: float
) -> TrescaIterate:
    """Tractions with P(s + D (q - anchor)) = 0 and the loads in balance, by conjugate gradients from q + change.

    They end when the residual is `small` or has fallen by `factor`.
    """
    if not linear.problem.compliance.symmetric:
        return solve_by_gmres(linear, at, change, anchor, factor)
    problem, k = linear.problem, len(linear.problem.F)
    rows = np.array([linear.project(row) for row in problem.B]).reshape(problem.B.shape)
    images = np.array([linear.precondition(row) for row in rows]).reshape(problem.B.shape)
    gram = np.tensordot(rows, images, ((1, 2, 3), (1, 2, 3))).reshape(k, k)
    inverse = np.asarray(np.linalg.pinv((gram + gram.T) / 2, rcond=1e-12, hermitian=True), dtype=float).reshape(k, k)
    missing = problem.F - np.tensordot(problem.B, at.q + change, 3)
    change = change + np.tensordot(inverse @ missing, images, 1)
    u, m = problem.correct(change), at.m
    residual = linear.project(at.s + u + linear.D * (at.q + change - anchor))
    z, dm = _direction(linear, residual, rows, images, inverse)
    d, before, first, steps = z, 1.0, 0.0, 0
    while True:
        residual, m = residual + np.tensordot(dm, rows, 1), m - dm
        rho = float(np.vdot(residual, z))
        first = rho if steps == 0 else first
        if steps == MAX_ITERATIONS or rho <= factor**2 * first or np.abs(residual).max(initial=0.0) <= small:
            break
        d = z + (rho / before) * d if steps else z
        image, product = linear.product(d)
        curvature = float(np.vdot(d, product))
        if curvature <= 0:
            break
        length = rho / curvature
        change, u, residual = change - length * d, u - length * image, residual - length * product
        before, steps = rho, steps + 1
        z, dm = _direction(linear, residual, rows, images, inverse)
    s = at.s + u - np.tensordot(m - at.m, problem.B, 1)
    return replace(at, q=at.q + change, s=s, m=m, nit=at.nit + steps)


def solve_by_gmres(linear: LinearStep, at: TrescaIterate, change: Array, anchor: Array, factor: float) -> TrescaIterate:
    """The same for a compliance that is not symmetric, by GMRES in changes d of tractions and dm of motions.

    P(A d + D d - B^T dm) = -P r and B d = e, preconditioned by the same equations with the inverse in wave numbers.
    """
    problem, k, own, n = linear.problem, len(linear.problem.F), linear.problem.compliance.own, at.q.size
    rows = np.array([linear.image(row) for row in problem.B]).reshape(problem.B.shape)
    images = np.array([linear.precondition(row) for row in rows]).reshape(problem.B.shape)
    inverse = np.linalg.pinv(np.tensordot(problem.B, images, ((1, 2, 3), (1, 2, 3))).reshape(k, k), rcond=1e-12)
    size = np.linalg.norm(rows.reshape(k, n), axis=1)  # of the equations of balance, to be of one unit with the others
    size[size == 0] = 1.0

    def product(x: Array) -> Array:
        d = x[:n].reshape(at.q.shape)
        moved = np.tensordot(x[n:] / size, rows, 1)
        return np.concatenate([(linear.product(d)[1] - moved).ravel(), own / size * np.tensordot(problem.B, d, 3)])

    def inverted(y: Array) -> Array:
        z = linear.precondition(y[:n].reshape(at.q.shape))
        dm = inverse @ (y[n:] * size / own - np.tensordot(problem.B, z, 3))
        return np.concatenate([(z + np.tensordot(dm, images, 1)).ravel(), dm * size])

    u = problem.correct(change)
    residual = linear.project(at.s + linear.D * (at.q + change - anchor)) + linear.image(u)
    missing = problem.F - np.tensordot(problem.B, at.q + change, 3)
    A, M = (LinearOperator((n + k, n + k), matvec=f, dtype=float) for f in (product, inverted))
    b, steps = np.concatenate([-residual.ravel(), own / size * missing]), [0.0]
    told = {"callback": steps.append, "callback_type": "pr_norm"}
    x, _ = gmres(A, b, M=M, rtol=max(factor, FINEST), restart=MAX_GMRES, maxiter=1, **told)
    d, dm = x[:n].reshape(at.q.shape), x[n:] / size
    s = at.s + u + problem.correct(d) - np.tensordot(dm, problem.B, 1)
    return replace(at, q=at.q + change + d, s=s, m=at.m + dm, nit=at.nit + len(steps) - 1)


def _direction(linear: LinearStep, residual: Array, rows: Array, images: Array, inverse: Array) -> tuple[Array, Array]:
    """Preconditioned residual that does not change the loads, and the change of the multipliers."""
    z = linear.precondition(residual)
    if len(rows) == 0:
        return z, np.zeros(0)
    dm = -inverse @ np.tensordot(rows, z, 3)
    return z + np.tensordot(dm, images, 1), dm
