"""Limit of friction along the motion that a load drives, by pressures that are found and not assumed.

The cones of friction under arbitrary pressures (`friction_balance`) are a necessary bound. Where deflections set the
pressures, as in a press fit, or where a torque would need them at the rim, less holds. The limit is found by moving
the body instead of loading it. Rigid motions that neither open nor close what touches are its mechanism; the part c of
the load that works on them is left to a guide, which moves the body by d:

    B x = F - (1 - share) c,    c . p = -d |c|

d grows until the share that friction takes does not: then everything slides. For given pressures it is the limit load
of Drucker (Q. Appl. Math. 11 (1954) 411).

Whether forces inside the cones of friction can balance a load: a necessary condition, and the friction it takes.

Forces on a cone are non-negative combinations of its edges n + mu (cos a t_1 + sin a t_2). The edges that matter are
found one by one: the residual of the non-negative least-squares problem of those known is a motion, and each point
adds the edge that resists it most (column generation; Gilmore & Gomory 1961). If none resists, the motion is free by
Farkas' lemma. Coulomb's law is not associated: forces that balance may exist and the body slide nevertheless.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import nnls

from fecontact.solvers.friction_newton import friction_newton, stick_solution
from fecontact.solvers.problem import InfeasibleLoadError, Status
from fecontact.solvers.scaling import DEPENDENT_ROW, ROUNDING, UNBALANCED, ScaledProblem

OPENS = 0.01
"""Share of the squared motion of touching points along their normals, up to which a rigid motion counts as sliding."""

SLIDES = 0.5
"""The same for motions that friction may hold: up slopes of 45 degrees."""

FIRST = 1e-3
"""First motion of the guide, relative to the data of the problem."""

GROWTH = 8.0
"""Growth of the guide's motion from one step to the next."""

STEPS = 12
"""Largest number of steps: motions of the guide from 1e-3 to 1e7."""

LEVEL = 1e-3
"""Relative growth of the share in a step up to which it is about to be constant: what is left falls as 1 / d."""

CORRECTIONS = 5
"""Corrections of the friction that holds; one suffices where pressures do not depend on it."""

NEWTON_STEPS = 30
"""Newton steps after which a guided body is tried from another start."""


class SlidingLoadError(InfeasibleLoadError):
    """A load under which all that touches slides.

    Parameters
    ----------
    message : str
    direction : ndarray, shape (m,)
        The motion, of unit norm.
    forces, motion : ndarrays, shapes (N,) and (m,)
        Of the body that a guide keeps from sliding further.
    """

    code = "slides-as-a-whole"

    def __init__(self, message: str, direction: np.ndarray, forces: np.ndarray, motion: np.ndarray) -> None:
        super().__init__(message, direction)
        self.forces, self.motion = forces, motion


@dataclass(frozen=True, eq=False)
class Guided:
    """A guided body.

    Attributes
    ----------
    load : (r,) array
        Part c of the load that is left to the guide.
    x, p : (N,) and (r,) arrays
        Forces and motion.
    moved : float
        Motion d of the guide.
    share : float
        Share of c that friction takes.
    bound : float
        The same if the guide goes on, estimated; infinite while it grows.
    """

    load: np.ndarray
    x: np.ndarray
    p: np.ndarray
    moved: float
    share: float
    bound: float = np.inf


def driving_load(problem: ScaledProblem, touching: np.ndarray) -> np.ndarray | None:
    """Part c (r,) of the load that works on motions along the tangents of touching points (n,); None without any."""
    basis = _along_tangents(problem, touching, np.eye(problem.r), OPENS)
    c = basis @ (basis.T @ problem.F)
    return np.asarray(c) if np.linalg.norm(c) > UNBALANCED * np.linalg.norm(problem.F) else None


def sliding_modes(problem: ScaledProblem) -> np.ndarray:
    """Motions (r, k) that friction may hold alone where what is closed, if anything, slides or does not move at all."""
    closed = problem.g[problem.normals] < 0
    touching = closed if closed.any() else ~closed
    along = _along_tangents(problem, touching, np.eye(problem.r), OPENS)
    size, axes = np.linalg.eigh(
        along @ along.T + np.outer(problem.F, problem.F) / max(problem.F @ problem.F, ROUNDING**2)
    )
    across = axes[:, size <= DEPENDENT_ROW]
    return np.concatenate([along, across @ _along_tangents(problem, touching, across, SLIDES, True)], axis=1)


def _along_tangents(
    problem: ScaledProblem,
    touching: np.ndarray,
    motions: np.ndarray,
    most: float,
    still: bool = False,
) -> np.ndarray:
    """Basis (j, k) of motions (r, j) with at most a share of the squared motion of touching points along normals.

    `still`: with those that do not move the points at all.
    """
    tangents = problem.tangents[np.isin(problem.points, problem.normals[touching])].ravel()
    normal, across = (problem.B[:, each] for each in (problem.normals[touching], tangents))
    least = DEPENDENT_ROW * (np.linalg.norm(normal) ** 2 + np.linalg.norm(across) ** 2)
    normal, across = motions.T @ normal, motions.T @ across
    total = normal @ normal.T + across @ across.T
    size, axes = np.linalg.eigh(total)
    moving = size > least
    axes, rest = axes[:, moving], axes[:, ~moving & still]
    opening, modes = eigh(axes.T @ normal @ normal.T @ axes, axes.T @ total @ axes)
    return np.concatenate([np.linalg.qr(axes @ modes[:, opening <= most])[0], rest], axis=1)


def slide(problem: ScaledProblem, load: np.ndarray, x: np.ndarray, p: np.ndarray) -> Iterator[Guided]:
    """The body under growing motions of the guide, until friction takes the load or will not.

    Parameters
    ----------
    problem : ScaledProblem
    load : ndarray, shape (r,)
        From `driving_load`.
    x, p : ndarrays, shapes (N,) and (r,)
        Forces and motion to begin with.
    """
    moved = FIRST * float(np.linalg.norm(load)) / max(float(np.abs(load @ problem.B).max()), ROUNDING)
    last = -np.inf
    for _ in range(STEPS):
        found = guided(problem, load, moved, x, p)
        moved *= GROWTH
        if found is None:
            continue
        growth = found.share - last
        if growth < LEVEL * abs(found.share):
            found = replace(found, bound=found.share + max(growth, 0.0))
        yield found
        if found.share >= 1 or found.bound < 1:
            return
        x, p, last = found.x, found.p, found.share


def guided(problem: ScaledProblem, load: np.ndarray, moved: float, x: np.ndarray, p: np.ndarray) -> Guided | None:
    """The body moved by its guide, from forces x (N,) and a motion p (r,); None where Newton's method fails."""
    size = float(np.linalg.norm(load))
    along = load / size
    rest = np.linalg.svd(along[None])[2][1:]
    held = replace(
        problem, B=rest @ problem.B, F=rest @ problem.F, g=problem.g - moved * (along @ problem.B),
        motion_map=problem.motion_map @ rest.T,
    )  # fmt: skip
    x, p = x, rest @ p
    for _ in range(2):
        outcome, _ = friction_newton(held, x, p, max_iterations=NEWTON_STEPS)
        if outcome.status is Status.SOLVED:
            motion = rest.T @ outcome.p - moved * along
            return Guided(load, outcome.x, motion, moved, float(along @ (problem.B @ outcome.x)) / size)
        x, p = stick_solution(held, np.zeros(held.n), np.zeros(held.r), x[problem.normals] > 0)
    return None


def holding_factor(problem: ScaledProblem, limit: Guided) -> float | None:
    """Factor on all coefficients of friction with which the load is just held; None where it is not found."""
    factor, found = 1.0, limit
    for _ in range(CORRECTIONS):
        if found.share <= 0:
            return None
        factor /= found.share
        more = replace(problem, mu=factor * problem.mu)
        next_one = guided(more, limit.load, limit.moved * factor, found.x, found.p)
        if next_one is None:
            return None
        found = next_one
        if abs(found.share - 1) < LEVEL:
            return factor / found.share
    return None


ROUNDS = 60
"""Largest number of edges tried at each point."""

MU_STEPS = 40
"""Bisections for the least coefficient of friction."""

MAX_FRICTION = 1e3
"""Coefficient from which more friction is taken not to help."""


def unbalanced_motion(problem: ScaledProblem) -> np.ndarray | None:
    """Motion (m,) along which the load does work and no cone resists, of unit norm; None if the load can be balanced.

    Parameters
    ----------
    problem : ScaledProblem
    """
    if problem.inconsistency.any():
        return problem.inconsistency
    size = float(np.linalg.norm(problem.F))
    if size == 0:
        return None
    B, normals = problem.B, problem.normals
    edges = B[:, normals]
    rough = np.isinf(problem.mu)
    sides = B[:, problem.tangents[rough].ravel()]
    # a rough point bears any tangential force once it is pressed: of both signs
    edges = np.concatenate([edges, sides, -sides], axis=1)
    finite = np.flatnonzero(~rough & (problem.mu > 0))
    points, tangents, mu = problem.points[finite], problem.tangents[finite], problem.mu[finite]
    for _ in range(ROUNDS):
        x, distance = nnls(edges, problem.F, maxiter=30 * edges.shape[1] + 100)
        if distance <= UNBALANCED * size:
            return None
        residual = problem.F - edges @ x
        pull = np.einsum("r,rfk->fk", residual, B[:, tangents])
        length = np.linalg.norm(pull, axis=1)
        direction = np.divide(pull, length[:, None], out=np.zeros_like(pull), where=length[:, None] > 0)
        gain = residual @ B[:, points] + mu * length
        useful = gain > UNBALANCED * distance
        if not useful.any():
            break
        best = np.argsort(gain[useful])[-8 * problem.r :]
        chosen = np.flatnonzero(useful)[best]
        side = np.einsum("fk,rfk->rf", direction[chosen], B[:, tangents[chosen]])
        edges = np.concatenate([edges[:, np.r_[: len(normals)]], edges[:, len(normals) :][:, x[len(normals) :] > 0],
                                B[:, points[chosen]] + mu[chosen] * side], axis=1)  # fmt: skip
    else:
        return None  # at the limit: the solver decides
    motion = problem.motion(-residual)
    return motion / float(np.linalg.norm(motion))


def least_friction(problem: ScaledProblem) -> float:
    """Least coefficient of friction, the same at all frictional points, with which the load can be balanced.

    Returns
    -------
    float
        Infinite if no friction balances it.
    """

    def balanced(mu: float) -> bool:
        every = np.where(problem.mu > 0, mu, 0.0)
        return unbalanced_motion(replace(problem, mu=every)) is None

    low, high = 0.0, 1.0
    while not balanced(high):
        low, high = high, 4 * high
        if high > MAX_FRICTION:
            return np.inf
    for _ in range(MU_STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if balanced(middle) else (middle, high)
        if high - low < 1e-6 * high:
            break
    return high
