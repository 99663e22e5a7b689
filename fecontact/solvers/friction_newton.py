"""Semismooth Newton method for contact with Coulomb friction.

Newton's method on the natural map of Alart & Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991) 353), with z the trial
forces x - y of scaled forces x and gaps or slips y (unit compliances):

    x_n = max(0, z_n),    x_t = P(z_t),  P the projection on the disc of radius mu max(0, z_n)

Open points have no force: they are eliminated from the step. The system is that of the touching points and of the rigid
motion. Steps are halved until the residual is below the largest of the last few (Grippo, Lampariello & Lucidi, SIAM J.
Numer. Anal. 23 (1986) 707): demanding that it falls in every step keeps the iterates in narrow valleys.

Strong friction is brought in by doubling: from forces without tangential part the first step is that of a coefficient
of 1/2 at most, the second that of 1, and so on. Pressures and directions of slip settle before they drag each other
along.

In a structure far more flexible than its material, such as a belt, forces say little of the state of the points: the
first step throws the residual up. Its states are then told by gaps and slips alone, z = x - R y with a large R: what
penetrates is pressed, and what slips slides. Where that does not converge soon, all steps are judged so.

Under much friction the smallest pressure holds a point, and its trial force no longer tells whether it slides. Points
may be given that slide: their pressure is |x_t| / mu. Under infinite friction they are bare, closed without pressure
and sliding against a tangential force; without this limit of a growing coefficient there need not be a state.

Block Gauss-Seidel sweeps for contact with Coulomb friction: slow and safe, the fall-back of Newton's method.

One point after the other takes the forces that close its own gap and stop its own slip, projected on its cone (Jean,
Comput. Methods Appl. Mech. Eng. 177 (1999) 235). Equilibrium is an augmented Lagrangian: V^T V of the orthonormal
rows V is added to the compliance, and the multiplier follows after every few sweeps (Hestenes 1969).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError, cho_solve, cholesky, lstsq, solve_triangular
from scipy.linalg.lapack import dgecon, dgetrf, dgetrs, dlange, dpotrf, dpotri

from fecontact.common.arrays import mirrored
from fecontact.solvers.coulomb import friction_limit
from fecontact.solvers.problem import Outcome, Status
from fecontact.solvers.scaling import ROUNDING, ScaledProblem

HALVINGS = 10
"""Halvings of a step after which it is taken although the residual has not fallen."""

MEMORY = 3
"""Residuals of the last iterates, below the largest of which a step counts as progress."""

DIVERGED_GROWTH = 100.0
"""Growth of the residual by the first step from which points are judged by gaps and slips instead of forces."""

GAP_WEIGHT = 1e4
"""Weight R of gaps and slips in the trial forces that judge by them."""

PATIENCE = 10
"""Steps after such a start from which all steps are judged by gaps and slips, from the beginning."""

GAP_WEIGHT_ALL_STEPS = 1e6
"""Weight R for that: the compliance of a belt over that of its material."""

REDUCED_FRICTION = 0.5
"""Largest coefficient of friction in the first step from forces without tangential part; it doubles in every step."""

DIVERGED = 1e12
"""Largest force or motion, relative to those of the start and to the data: the rounding of larger ones is above the
tolerance. Strips and belts stay below ten; no bound holds for a compliance that is not definite.
"""

SINGULAR = 1e-14
"""Reciprocal condition number below which the smallest step is taken: forces of rigid bodies are not unique."""

MANY = 1000
"""Unknowns from which steps are solved by the inverse of their points' compliance, which few changes bring up to date.
"""

FEW = 10
"""Rows over those that change up to which an inverse is computed anew."""

SHARP = 1e-10
"""Share of the right side that the solution of a step may leave: Newton's method goes on from it."""

RATE = 0.1
"""Share of the residual that a refinement may leave."""


@dataclass(frozen=True, eq=False)
class _Trial:
    """Residual of an iterate, and the state of each point that its trial forces tell."""

    y: np.ndarray
    weight: float
    pressed: np.ndarray
    limit: np.ndarray
    size: np.ndarray
    direction: np.ndarray
    residual: np.ndarray
    balance: np.ndarray

    @property
    def merit(self) -> float:
        return float(np.hypot(np.linalg.norm(self.residual), np.linalg.norm(self.balance)))


def _trial(problem: ScaledProblem, x: np.ndarray, p: np.ndarray, weight: float = 1.0) -> _Trial:
    y = problem.gap(x, p)
    z = x - weight * y
    pressed = z > 0
    pressed[problem.tangents] = False
    tangents, points = problem.tangents[problem.slides], problem.points[problem.slides]
    pressed[points] = True
    limit = friction_limit(problem.mu, z[problem.points])
    limit[problem.slides] = np.linalg.norm(x[tangents], axis=1)
    tangential = z[problem.tangents]
    size = np.linalg.norm(tangential, axis=1)
    direction = np.divide(tangential, size[:, None], out=np.zeros_like(tangential), where=size[:, None] > 0)
    residual = x.copy()
    residual[problem.normals] -= np.maximum(z[problem.normals], 0.0)
    residual[problem.tangents] -= direction * np.minimum(size, limit)[:, None]
    pressure = limit[problem.slides] / problem.mu[problem.slides]
    residual[tangents] += direction[problem.slides] * (x[points] - pressure)[:, None]
    residual[points] = y[points]
    return _Trial(y, weight, pressed, limit, size, direction, residual, problem.B @ x - problem.F)


def friction_newton(
    problem: ScaledProblem,
    x: np.ndarray,
    p: np.ndarray,
    *,
    max_iterations: int = 50,
    weight: float = 1.0,
) -> tuple[Outcome, int]:
    """Solve by Newton's method.

    Parameters
    ----------
    problem : ScaledProblem
        With one scale for the components of a point.
    x, p : ndarrays, shapes (N,) and (r,)
        First forces and motion.
    max_iterations : int
    weight : float
        Weight R of gaps and slips in the trial forces by which steps are made and judged.

    Returns
    -------
    Outcome
        ``solved`` where the residual is rounding, or ``iteration-limit`` with the best iterate; the history is the
        residual over the largest force.
    orientation : int
        Sign of the Jacobian's determinant at the end, +1 as without friction. -1: the solution is not the only one,
        or not stable (Klarbring 1990); 0: singular.
    """
    trial = _trial(problem, x, p, weight)
    history: list[float] = []
    merits: list[float] = []
    last: list[_Inverse] = []
    best = (np.inf, x, p)
    largest = bound(problem, x, p)
    orientation, eases, thrown, first = 1, not x[problem.tangents].any(), False, (x, p)
    for nit in range(max_iterations + 1):
        merit = trial.merit if weight == 1 else _trial(problem, x, p).merit
        error = merit / max(float(np.linalg.norm(x)), float(np.linalg.norm(problem.F)), ROUNDING)
        history.append(error)
        if error < best[0]:
            best = (error, x, p)
        stalled = len(history) > 2 and error < 1e3 * ROUNDING and error > 0.5 * history[-2]
        if error <= ROUNDING or stalled:
            return Outcome(best[1], best[2], Status.SOLVED, "solved", nit, history), orientation
        if nit == max_iterations or (thrown and nit == PATIENCE):
            break
        eased = _with_reduced_friction(problem, nit) if eases else problem
        if eased is not problem:
            trial, merits = _trial(eased, x, p, weight), []
        dx, dp, orientation = _step(eased, x, trial, last)
        merits = [*merits, trial.merit][-MEMORY:]
        trial = _trial(problem, x + dx, p + dp, weight)
        share = 1.0
        thrown = thrown or (nit == 0 and weight == 1 and trial.merit > DIVERGED_GROWTH * merits[0])
        if nit == 0 and thrown:
            dx, dp, orientation = _step(problem, x, _trial(problem, x, p, GAP_WEIGHT), last)
            trial, merits, eases = _trial(problem, x + dx, p + dp), [], False
        elif eased is problem:
            for _ in range(HALVINGS):
                if trial.merit < (1 - 1e-4 * share) * max(merits):
                    break
                share /= 2
                trial = _trial(problem, x + share * dx, p + share * dp, weight)
        x, p = x + share * dx, p + share * dp
        if not max(np.abs(x).max(), np.abs(p).max(initial=0.0)) <= largest:
            break
    if thrown and nit < max_iterations:
        left = max_iterations - nit
        found, orientation = friction_newton(problem, *first, max_iterations=left, weight=GAP_WEIGHT_ALL_STEPS)
        return replace(found, nit=nit + found.nit, history=history + found.history), orientation
    message = f"{max_iterations} Newton steps were not enough"
    return Outcome(best[1], best[2], Status.ITERATION_LIMIT, message, max_iterations, history), orientation


def bound(problem: ScaledProblem, x: np.ndarray, p: np.ndarray) -> float:
    """Size of forces and motions from which an iteration that began at x (N,) and p (r,) has diverged."""
    return DIVERGED * max(float(np.abs(part).max(initial=0.0)) for part in (x, p, problem.g, problem.F))


def _with_reduced_friction(problem: ScaledProblem, nit: int) -> ScaledProblem:
    """The problem with the friction of an early step; itself where it is all of it."""
    most = REDUCED_FRICTION * 2.0**nit
    above = (problem.mu > most) & (problem.mu < np.inf)
    return replace(problem, mu=np.where(above, most, problem.mu)) if above.any() else problem


def stick_solution(
    problem: ScaledProblem, x: np.ndarray, p: np.ndarray, pressed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Forces (N,) and motion (r,) with the gaps of `pressed` normal rows (n,) closed and without slip there."""
    chosen = np.zeros(problem.n, bool)
    chosen[problem.normals[pressed]] = True
    rough = np.full(len(problem.mu), np.inf)
    dx, dp, _ = _step(problem, x, replace(_trial(problem, x, p), pressed=chosen, limit=rough), [])
    return x + dx, p + dp


def _step(
    problem: ScaledProblem, x: np.ndarray, trial: _Trial, last: list[_Inverse]
) -> tuple[np.ndarray, np.ndarray, int]:
    """Newton step of forces (N,) and motion (r,), and the sign of the Jacobian's determinant."""
    touching = trial.pressed[problem.points]
    slips = touching & (trial.size > trial.limit)
    kept = np.union1d(np.flatnonzero(trial.pressed), problem.tangents[touching])
    released = -x
    released[kept] = 0.0
    opened = np.flatnonzero(released)
    change = released[opened] @ problem.matrix[opened]  # of gaps and slips once the open points are released
    slipping = _slip_rows(problem, x, change, trial, slips, kept)
    right = np.concatenate([-(trial.y + change)[kept], -trial.balance - problem.B @ released])
    right[slipping.places] = slipping.right
    solution, orientation = _System(problem, kept, slipping).solved(right, last)
    step = released
    step[kept] = solution[: len(kept)]
    return step, solution[len(kept) :], orientation


@dataclass(frozen=True, eq=False)
class _SlipRows:
    """Rows of f slipping points, D ds + E_t dx_t + E_n dx_n = right.

    Attributes
    ----------
    places : (f, k) array
        Of their tangents among the kept rows.
    normals : (f,) array
        Of their normals.
    gaps, own : (f, k, k) arrays
        D and E_t.
    pressures : (f, k) array
        E_n.
    right : (f, k) array
    """

    places: np.ndarray
    normals: np.ndarray
    gaps: np.ndarray
    own: np.ndarray
    pressures: np.ndarray
    right: np.ndarray

    def by_forces(self, forces: np.ndarray) -> np.ndarray:
        """E_t dx_t + E_n dx_n (f, k, m) of columns (kept rows, m)."""
        return self.own @ forces[self.places] + self.pressures[:, :, None] * forces[self.normals][:, None]


def _slip_rows(
    problem: ScaledProblem, x: np.ndarray, change: np.ndarray, trial: _Trial, slips: np.ndarray, kept: np.ndarray
) -> _SlipRows:
    """Rows of slipping points (f,) for the linearised x_t = P(z_t) in place of s = 0.

    dx_t - T (dx_t - R ds) - mu e (dx_n - R dy_n) = mu (x_n - R y_n) e - x_t
    T = mu z_n / |z_t| (I - u e^T),   e = z_t / |z_t|

    u is the mean of e and of x_t / max(mu z_n, |x_t|), which stands there in the Newton step of Hueeber, Stadler &
    Wohlmuth (SIAM J. Sci. Comput. 30 (2008) 572): the same in the solution; away from it neither alone takes as few
    steps. In a section there is no direction to turn: u = e. The gap closes, dy_n = -y_n. `change` (N,) of gaps and
    slips is the share of ds from open points that lose their force. Where it is given to slide, the row along e is
    divided by mu: e dx_t / mu - dx_n = x_n - e x_t / mu.
    """
    f, k = int(slips.sum()), problem.tangents.shape[1]
    e, mu, tangents, points = trial.direction[slips], problem.mu[slips], problem.tangents[slips], problem.points[slips]
    t, n, limit = x[tangents], x[points], trial.limit[slips]
    u, R = e, trial.weight
    if k > 1 or R > GAP_WEIGHT:  # where all is judged by gaps, it damps changes of sign, too
        most = np.maximum(limit, np.linalg.norm(t, axis=1))[:, None]
        u = (e + np.divide(t, most, out=np.zeros_like(t), where=most > 0)) / 2
    T = (limit / trial.size[slips])[:, None, None] * (np.eye(k) - u[:, :, None] * e[:, None, :])
    given, along = problem.slides[slips], e[:, :, None] * e[:, None, :]
    across = np.eye(k) - given[:, None, None] * along
    share = np.divide(given, mu, out=np.zeros(f), where=given)[:, None, None] * along
    mu = np.where(given, 1.0, mu)
    gaps = R * across @ T
    right = (mu * n)[:, None] * e - np.einsum("fij,fj->fi", across + share, t)
    right -= np.einsum("fij,fj->fi", gaps, change[tangents])
    places, normals = np.searchsorted(kept, tangents), np.searchsorted(kept, points)
    return _SlipRows(places, normals, gaps, across @ (np.eye(k) - T) + share, -mu[:, None] * e, right)


@dataclass(frozen=True, eq=False)
class _System:
    """Linear system of a step: forces of the kept rows (a,) and motion (r,)."""

    problem: ScaledProblem
    kept: np.ndarray
    slipping: _SlipRows

    def solved(self, right: np.ndarray, last: list[_Inverse]) -> tuple[np.ndarray, int]:
        """Solution, of least norm where it is singular, and the sign of its determinant times (-1)^r.

        `last` has the inverse of an earlier step, and gets that of this one.
        """
        if len(right) == 0:
            return right, 1
        if len(right) >= MANY:
            try:
                last[:] = [_Inverse.of(self.problem.matrix, self.kept, last)]
            except LinAlgError:
                last.clear()
            if last and (found := self._by_inverse(last[0], right)) is not None:
                return found
        A, r = self._array(), self.problem.r
        # by its transpose, whose columns lie one after the other
        factor, pivots, info = dgetrf(A.T)
        if info == 0 and dgecon(factor, dlange("1", A.T))[0] > SINGULAR:
            solution, _ = dgetrs(factor, pivots, right, trans=1)
            # one refinement: the bordered matrix is badly scaled where contact is stiff
            solution += dgetrs(factor, pivots, right - A @ solution, trans=1)[0]
            return np.asarray(solution), _sign(factor, pivots, r)
        try:
            return np.asarray(lstsq(A, right, cond=SINGULAR, lapack_driver="gelsy")[0]), 0
        except LinAlgError:
            return np.zeros_like(right), 0

    def _array(self) -> np.ndarray:
        """The matrix."""
        (place, normal), r, a = (self.slipping.places, self.slipping.normals), self.problem.r, len(self.kept)
        A = np.zeros((a + r, a + r))
        A[:a, :a] = self.problem.matrix[np.ix_(self.kept, self.kept)]
        A[a:, :a] = self.problem.B[:, self.kept]
        A[:a, a:] = A[a:, :a].T
        A[place] = self.slipping.gaps @ A[place]
        A[place[:, :, None], place[:, None, :]] += self.slipping.own
        A[place, normal[:, None]] += self.slipping.pressures
        return A

    def _product(self, v: np.ndarray) -> np.ndarray:
        """The matrix times (a + r,)."""
        x, rows, a = np.zeros(self.problem.n), self.slipping, len(self.kept)
        x[self.kept] = v[:a]
        y = (self.problem.matrix @ x + self.problem.B.T @ v[a:])[self.kept]
        at = (rows.gaps @ y[rows.places][:, :, None] + rows.by_forces(v[:a, None]))[:, :, 0]
        y[rows.places] = at
        return np.concatenate([y, self.problem.B @ x])

    def _by_inverse(self, inverse: _Inverse, right: np.ndarray) -> tuple[np.ndarray, int] | None:
        """The same by N = S^-1 of the kept rows; None where that, or what is left, is nearly singular.

        Gaps and slips z = S dx + B^T dp tell the forces, dx = N (z - B^T dp). They are known but for the slips of
        slipping points, whose rows and those of equilibrium are a small system. Its determinant is that of the whole
        over det S > 0.
        """
        N, B, rows, r = inverse.array, self.problem.B[:, self.kept], self.slipping, self.problem.r
        a, V, slips = len(N), N @ B.T, rows.places.ravel()
        m = len(slips)
        Q = np.empty((m + r, m + r))
        Q[:m, :m] = rows.by_forces(N[:, slips]).reshape(m, m)
        own = np.arange(m).reshape(rows.places.shape)
        Q[own[:, :, None], own[:, None, :]] += rows.gaps
        Q[:m, m:], Q[m:, :m], Q[m:, m:] = -rows.by_forces(V).reshape(m, r), V[slips].T, -B @ V
        factor, pivots = Q, np.arange(0)
        if len(Q):
            factor, pivots, info = dgetrf(Q.T)
            if info != 0 or dgecon(factor, dlange("1", Q.T))[0] <= SINGULAR:
                return None
        solution, left, size = np.zeros_like(right), right, float(np.abs(right).max())
        enough = SHARP * size
        while size > enough:
            z, motion = left[:a].copy(), left[a:]
            z[slips] = 0.0
            x = N @ z
            if len(Q):
                small = np.concatenate([left[slips] - rows.by_forces(x[:, None]).ravel(), motion - B @ x])
                small = dgetrs(factor, pivots, small, trans=1)[0]
                z[slips] = small[:m]
                x, motion = N @ z - V @ small[m:], small[m:]
            solution += np.concatenate([x, motion])
            left, before = right - self._product(solution), size
            size = float(np.abs(left).max())
            if not size <= max(RATE * before, enough):
                return None
        return solution, _sign(factor, pivots, r)


@dataclass(frozen=True, eq=False)
class _Inverse:
    """Inverse (a, a) of the compliance of some rows (a,), which the next steps need again with few rows changed."""

    rows: np.ndarray
    array: np.ndarray

    @classmethod
    def of(cls, S: np.ndarray, rows: np.ndarray, last: list[_Inverse]) -> _Inverse:
        """From S (N, N), or from the last one where few rows differ.

        Raises
        ------
        LinAlgError
            If they are not positive definite.
        """
        for known in last:
            out, new = np.isin(known.rows, rows, invert=True), np.setdiff1d(rows, known.rows)
            if FEW * (out.sum() + len(new)) <= len(rows):
                return known._without(out)._with(new, S)
        factor, info = dpotrf(S[np.ix_(rows, rows)].T, lower=1, clean=0, overwrite_a=1)
        if info != 0:
            raise LinAlgError
        return cls(rows, mirrored(dpotri(factor, lower=1, overwrite_c=1)[0]))

    def _without(self, out: np.ndarray) -> _Inverse:
        """Without some rows, by a mask."""
        if not out.any():
            return self
        kept = ~out
        half = solve_triangular(
            cholesky(self.array[np.ix_(out, out)], lower=True), self.array[np.ix_(out, kept)], lower=True
        )
        return _Inverse(self.rows[kept], self.array[np.ix_(kept, kept)] - half.T @ half)

    def _with(self, new: np.ndarray, S: np.ndarray) -> _Inverse:
        """With other rows of S (N, N)."""
        if not len(new):
            return self
        rows = np.union1d(self.rows, new)
        old, own = np.searchsorted(rows, self.rows), np.searchsorted(rows, new)
        C = S[np.ix_(new, self.rows)].T
        W = self.array @ C
        L = cholesky(S[np.ix_(new, new)] - C.T @ W, lower=True)
        half = solve_triangular(L, W.T, lower=True)
        array, grown = np.empty((len(rows), len(rows))), half.T @ half
        grown += self.array
        array[np.ix_(old, old)] = grown
        array[np.ix_(own, old)] = -solve_triangular(L, half, lower=True, trans=1)
        array[np.ix_(old, own)] = array[np.ix_(own, old)].T
        array[np.ix_(own, own)] = cho_solve((L, True), np.eye(len(new)))
        return _Inverse(rows, array)


def _sign(factor: np.ndarray, pivots: np.ndarray, r: int) -> int:
    """Sign of the determinant times (-1)^r."""
    swaps = int((pivots != np.arange(len(pivots))).sum())
    negative = int((factor.diagonal() < 0).sum())
    return -1 if (swaps + negative + r) % 2 else 1


SWEEPS = 5
"""Sweeps between two updates of the rigid motion."""


def friction_sweeps(
    problem: ScaledProblem,
    x: np.ndarray,
    p: np.ndarray,
    *,
    tolerance: float = 1e-4,
    max_iterations: int = 400,
) -> Outcome:
    """Sweep until forces change by less than a tolerance.

    Parameters
    ----------
    problem : ScaledProblem
    x, p : ndarrays, shapes (N,) and (r,)
    tolerance : float
        Of the change in a sweep and of equilibrium, relative to the forces. Newton's method sharpens the answer.
    max_iterations : int
        Largest number of sweeps.

    Returns
    -------
    Outcome
        ``solved`` within the tolerance, else ``iteration-limit``; where the sweeps diverged, with the iterate that
        changed least. Not certified.
    """
    V, weight = problem.B, float(problem.n)
    S = problem.matrix + weight * V.T @ V
    x, p = x.copy(), p.copy()
    history: list[float] = []
    best = (np.inf, x.copy(), p.copy())
    largest = bound(problem, x, p)
    frictional = {int(n): k for k, n in enumerate(problem.points)}
    for nit in range(1, max_iterations + 1):
        before = x.copy()
        y = S @ x + problem.g + V.T @ (p - weight * problem.F)
        for n in problem.normals:
            _sweep_point(S, y, x, int(n), problem, frictional.get(int(n)))
        if (size := float(np.abs(x).max())) > largest:
            return Outcome(best[1], best[2], Status.ITERATION_LIMIT, f"sweep {nit} diverged", nit, history)
        miss = V @ x - problem.F
        if nit % SWEEPS == 0:
            p += weight * miss
        history.append(max(float(np.abs(x - before).max()), float(np.abs(miss).max(initial=0.0))) / max(size, 1e-300))
        if history[-1] < best[0]:
            best = (history[-1], x.copy(), p.copy())
        if history[-1] < tolerance and nit % SWEEPS == 0:
            return Outcome(x, p, Status.SOLVED, "solved", nit, history)
    return Outcome(x, p, Status.ITERATION_LIMIT, f"{nit} sweeps were not enough", nit, history)


def _sweep_point(S: np.ndarray, y: np.ndarray, x: np.ndarray, n: int, problem: ScaledProblem, k: int | None) -> None:
    """Forces of one point from its own gap and slip; x and y are changed in place.

    A point that gives way to no force, as of parts held on both sides, keeps what it has.
    """
    if not S[n, n] > 0:
        return
    force = max(0.0, x[n] - y[n] / S[n, n])
    _set(S, y, x, np.array([n]), np.array([force]))
    if k is None:
        return
    t = problem.tangents[k]
    if not (slope := float(np.linalg.norm(S[np.ix_(t, t)], 2))) > 0:
        return
    trial = x[t] - y[t] / slope
    size, limit = float(np.linalg.norm(trial)), float(problem.mu[k] * force) if force > 0 else 0.0
    _set(S, y, x, t, trial if size <= limit else trial * (limit / size))


def _set(S: np.ndarray, y: np.ndarray, x: np.ndarray, rows: np.ndarray, forces: np.ndarray) -> None:
    y += S[rows].T @ (forces - x[rows])
    x[rows] = forces
