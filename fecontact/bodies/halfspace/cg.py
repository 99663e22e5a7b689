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
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fecontact.bodies.halfspace.fft import ROUGHNESS, Convolution
from fecontact.bodies.halfspace.smooth import Product
from fecontact.common.arrays import Array, Mask

PER_ROUND = 0.2
"""Factor by which the gaps on the set shrink before the set is updated."""

MOST_ROUNDS = 150
MOST_STEPS = 60
"""Conjugate gradient steps on one set; the preconditioned method needs a dozen for ten digits."""

SMALLEST = 1e-300


@dataclass(frozen=True, eq=False)
class GridProblem:
    """Frictionless contact on a grid: gap = A p + g + B^T q >= 0, p >= 0, p . gap = 0, B p = F.

    Attributes
    ----------
    compliance : Convolution or Corrected
        A: displacement due to pressure.
    rough : Convolution or Corrected
        The same in single precision, for corrections.
    preconditioner : Convolution
        Approximate inverse of A, positive definite.
    g : (nx, ny) array
        Gap without pressure.
    allowed : (nx, ny) bool array
        Cells that have a counter-surface.
    B : (m, nx, ny) array
        Equilibrium rows.
    F : (m,) array
        Loads.
    """

    compliance: Product
    rough: Product
    preconditioner: Convolution
    g: Array
    allowed: Mask
    B: Array
    F: Array


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
    active = active & problem.allowed
    p = carry(problem, np.where(active, np.maximum(start, 0.0), 0.0))
    u = problem.compliance.apply(p)
    at = GridIterate(p, u, np.zeros(len(problem.F)), active, 0, 0, False, ())
    changed = True
    while at.rounds < MOST_ROUNDS:
        at = _equalise(problem, at, tolerance, PER_ROUND if changed else 0.0)
        gap = at.u + problem.g + np.tensordot(at.q, problem.B, 1)
        scale = _largest(at.u, problem.allowed)
        pulling = at.active & (at.p < 0)
        entering = problem.allowed & ~at.active & (gap < -tolerance * scale)
        left = float(np.abs(np.where(at.active, gap, np.minimum(gap, 0.0))[problem.allowed]).max(initial=0.0)) / scale
        at = replace(at, history=(*at.history, left))
        changed = bool(pulling.any() or entering.any())
        if not changed and left <= tolerance:
            if at.drift <= 0.1 * tolerance * scale:
                return replace(at, converged=True)
            at = replace(at, u=problem.compliance.apply(at.p), drift=0.0)
        if changed:
            p = at.p
            if pulling.any():
                p = carry(problem, np.maximum(p, 0.0))
                at = replace(at, u=problem.compliance.apply(p), drift=0.0)
            at = replace(at, p=p, active=(at.active & ~pulling) | entering)
    return at


def _largest(u: Array, allowed: Mask) -> float:
    """Largest displacement under the counter-surface; in holes between it may be larger."""
    return max(float(np.max(u, where=allowed, initial=0.0)), -float(np.min(u, where=allowed, initial=0.0)), SMALLEST)


def carry(problem: GridProblem, p: Array) -> Array:
    """Pressures scaled by a factor linear in the rows until they balance the loads."""
    if len(problem.F) == 0:
        return p
    flat, rows = p.ravel(), problem.B.reshape(len(problem.F), -1)
    gram = (rows * flat) @ rows.T
    factors = np.linalg.lstsq(gram, problem.F - rows @ flat, rcond=1e-12)[0]
    return p * (1 + np.tensordot(factors, problem.B, 1))


@dataclass(frozen=True, eq=False)
class _Balance:
    """Equilibrium rows on a set, and the preconditioner in the subspace of pressures that do not change the loads."""

    problem: GridProblem
    mask: Array
    rows: Array
    images: Array
    inverse: Array

    def direction(self, gap: Array) -> tuple[Array, Array]:
        """Preconditioned gap (nx, ny) without change of the loads, and the change of the multiplier (m,)."""
        z = self.problem.preconditioner.apply(gap)
        z *= self.mask
        if len(self.rows) == 0:
            return z, np.zeros(0)
        dq = -self.inverse @ np.tensordot(self.rows, z, 2)
        z += np.tensordot(dq, self.images, 1)
        return z, dq

    def missing(self, p: Array) -> Array:
        """Change of pressure that makes p balance the loads."""
        return np.tensordot(self.inverse @ (self.problem.F - np.tensordot(self.rows, p, 2)), self.images, 1)


def _balance(problem: GridProblem, active: Mask) -> _Balance:
    mask = active.astype(float)
    rows = problem.B * mask
    images = np.array([problem.preconditioner.apply(row) * mask for row in rows]).reshape(rows.shape)
    gram = np.tensordot(rows, images, ((1, 2), (1, 2)))
    inverse = np.asarray(np.linalg.pinv((gram + gram.T) / 2, rcond=1e-12, hermitian=True), dtype=float)
    return _Balance(problem, mask, rows, images, inverse)


def _equalise(problem: GridProblem, at: GridIterate, tolerance: float, factor: float) -> GridIterate:
    """Conjugate gradients on the set until the gaps have shrunk by a factor or are closed."""
    balance = _balance(problem, at.active)
    mask = balance.mask
    p, u, q, drift = at.p.copy(), at.u.copy(), at.q, at.drift
    if len(q) and np.abs(correction := balance.missing(p)).max() > 1e-14 * np.abs(p).max():
        p += correction
        u += problem.compliance.apply(correction)
    gap = (u + problem.g + np.tensordot(q, problem.B, 1)) * mask
    z, dq = balance.direction(gap)
    d, rho, first, steps = z.copy(), np.nan, np.nan, 0
    while True:
        gap += np.tensordot(dq, balance.rows, 1)
        q = q + dq
        before, rho = rho, float(np.vdot(gap, z))
        first = rho if steps == 0 else first
        largest = max(float(gap.max()), -float(gap.min()))
        if steps == MOST_STEPS or largest <= 0.3 * tolerance * _largest(u, problem.allowed) or rho <= factor**2 * first:
            break
        if steps:
            d *= rho / before
            d += z
        image = problem.rough.apply(d)
        curvature = float(np.vdot(d, image))
        if curvature <= 0:
            break
        length = rho / curvature
        p -= length * d
        image *= length
        drift += ROUGHNESS * max(float(image.max()), -float(image.min()))
        u -= image
        image *= mask
        gap -= image
        steps += 1
        z, dq = balance.direction(gap)
    return replace(at, p=p, u=u, q=q, nit=at.nit + steps, rounds=at.rounds + 1, drift=drift)
