"""Two methods that are not exact, on the same condensed problem: a penalty, and gap elements in load increments.

They are to be compared with, on ``result.problem`` of any contact without friction, and are not among
`available_solvers`: both put springs between the bodies, and the answer moves with a stiffness that somebody has to
guess. With a spring of compliance c_k at every candidate point both come down to linear solves of

    (S + diag c) l + B^T q = -(g, or what is left of it),     B l = F

so the exact method and its baselines differ in nothing but the springs.

**Penalty.** A spring of stiffness k at every point that penetrates, l = k max(-w, 0): the exact conditions for the
compliance S + 1/k. Its error and its penetration l / k fall like 1/k, and the condition number of the equations grows
like k.

**Gap elements.** Contact elements of a bilinear stress-strain curve (Elangovan 1978, section IV.2, as the MARC system
had them in 1974): an element fills the gap of each pair; it is soft until its strain reaches -1, that is until the gap
is closed, and hard from there on. The load is applied in increments, each with the stiffness that the elements have at
its beginning; repeated cycles within an increment use their average stiffness over it.

Examples
--------
>>> import numpy as np
>>> from fecontact.solvers import ContactProblem
>>> problem = ContactProblem(S=np.eye(2), g=np.array([0.0, 9.0]), B=np.ones((1, 2)), F=np.array([1.0]))
>>> penalty(problem, stiffness=1e3).gap.round(6).tolist()
[-0.001, 7.999]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SolverError
from fecontact.solvers.coulomb import Residuals
from fecontact.solvers.problem import ContactProblem

STEP_TOLERANCE = 1e-10
"""Change of the forces within one increment, relative to the largest, at which its cycles end."""


@dataclass(frozen=True)
class Increment:
    """One load increment, or one iteration of the penalty method.

    Attributes
    ----------
    share : float
        Share of the load that acts at its end.
    solves : int
        Linear solves it took.
    touching : int
        Points with a closed gap at its end.
    change : float
        Change of the forces in its last solve, relative to the largest force.
    """

    share: float
    solves: int
    touching: int
    change: float


@dataclass(frozen=True, eq=False)
class Approximation:
    """What a method that is not exact gives.

    Attributes
    ----------
    forces : (n,) array
        Forces of the springs, compression positive; those of open gap elements included.
    q : (m,) array
        Rigid motion.
    gap : (n,) array
        S l + g + B^T q; negative where the bodies penetrate.
    residuals : Residuals
        Of the exact contact conditions, recomputed from the problem.
    settled : bool
        Whether the iterations came to an end by themselves.
    history : tuple of Increment
    """

    forces: Array
    q: Array
    gap: Array
    residuals: Residuals
    settled: bool
    history: tuple[Increment, ...]

    @property
    def solves(self) -> int:
        """Linear solves in all."""
        return sum(increment.solves for increment in self.history)

    @property
    def penetration(self) -> float:
        """Deepest penetration, as a length."""
        return float(np.maximum(-self.gap, 0.0).max())


def penalty(problem: ContactProblem, stiffness: ArrayLike, *, max_iterations: int = 100) -> Approximation:
    """Solve by the penalty method: springs where the bodies penetrate, Newton's method for who does.

    Parameters
    ----------
    problem : ContactProblem
        With S as an array, for example ``result.problem``.
    stiffness : float or (n,) array
        Of each spring, force per length. A foundation of even stiffness has springs in proportion to the areas of the
        points, ``contact.weights[contact.candidates]``.
    max_iterations : int
        Largest number of linear solves. The first one is made with the points nearest to touch.

    Returns
    -------
    Approximation
        ``settled`` is False if the points in touch still changed.

    Raises
    ------
    InputError
        For a stiffness that is not positive or an S that is an operator.
    SolverError
        If the points in touch leave a motion open that the load drives.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers import ContactProblem
    >>> problem = ContactProblem(S=np.eye(1), g=-np.ones(1))
    >>> [round(float(penalty(problem, k).forces[0]), 6) for k in (1.0, 1e2, 1e4)]
    [0.5, 0.990099, 0.9999]
    """
    S, (k,) = _checked(problem, stiffness=stiffness)
    compliance = 1 / k
    touching = _first_guess(problem)
    forces = np.zeros(problem.n)
    history: list[Increment] = []
    settled = False
    while not settled and len(history) < max_iterations:
        before = forces
        points = np.flatnonzero(touching)
        forces, q = np.zeros(problem.n), np.zeros(problem.m)
        forces[points], q = _solve(S, compliance, problem.B, points, -problem.g, problem.F)
        gap = problem.gap(forces, q)
        penetrating = gap < 0
        # the last set stands where every spring of it pushes and every other point is open
        settled = bool((penetrating == touching).all())
        history.append(Increment(1.0, 1, int(penetrating.sum()), _change(forces, before)))
        touching = penetrating
    return Approximation(forces, q, gap, problem.residuals(forces, q), settled, tuple(history))


def gap_elements(
    problem: ContactProblem, soft: ArrayLike, hard: ArrayLike, increments: int, *, cycles: int = 1
) -> Approximation:
    """Solve with gap elements of a bilinear law, the load in increments.

    Parameters
    ----------
    problem : ContactProblem
        With S as an array. Without equilibrium rows the approach is incremented instead of a load: the bodies begin
        where they just touch.
    soft, hard : float or (n,) array
        Stiffness of an element before and after its gap is closed, force per length. The report gives moduli; over the
        length of the element, its gap, they are stiffnesses.
    increments : int
        Equal parts of the load.
    cycles : int
        Largest number of solves in an increment: 1 takes the stiffness at its beginning, more the average over it.

    Returns
    -------
    Approximation
        ``settled`` is False if the cycles of some increment did not settle; with one cycle nobody knows, and it is
        False as well.

    Raises
    ------
    InputError
        For stiffnesses that are not 0 < soft < hard, numbers that are not positive, or an S that is an operator.

    Notes
    -----
    P. T. Elangovan, A general numerical formulation for elastic contact of solids, Eindhoven 1978, section IV.2.
    The report names the trade: increments must be small, or elements pass the strain -1 with their soft stiffness
    within one of them.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers import ContactProblem
    >>> problem = ContactProblem(S=np.eye(2), g=np.array([0.0, 1.0]), B=np.ones((1, 2)), F=np.array([3.0]))
    >>> [gap_elements(problem, 1e-6, 1e6, m).forces.round(3).tolist() for m in (1, 4, 400)]
    [[3.0, 0.0], [2.25, 0.75], [2.002, 0.998]]
    """
    S, (k_soft, k_hard) = _checked(problem, soft=soft, hard=hard)
    if not (k_soft < k_hard).all():
        raise InputError(f"A gap element is soft before it closes; found soft = {soft!r}, hard = {hard!r}.")
    for name, number in (("increments", increments), ("cycles", cycles)):
        if not (isinstance(number, int) and number > 0):
            raise InputError(f"{name} must be a positive integer; found {number!r}.")
    lift = max(0.0, -float(problem.g.min())) if problem.m == 0 else 0.0
    closing = np.full(problem.n, -lift / increments)
    load = problem.F / increments
    gap, forces, q = problem.g + lift, np.zeros(problem.n), np.zeros(problem.m)
    everywhere = np.arange(problem.n)
    history: list[Increment] = []
    for k in range(increments):
        stiffness = np.where(gap > 0, k_soft, k_hard)
        change = np.inf
        step = np.zeros(problem.n)
        solves = 0
        while solves < cycles and change > STEP_TOLERANCE:
            before = step
            # l + step = l + k (gap before - gap after), and gap after - before = S step + closing + B^T motion
            step, motion = _solve(S, 1 / stiffness, problem.B, everywhere, -closing, load)
            moved = S @ step + closing + problem.B.T @ motion
            stiffness = _average(gap, gap + moved, k_soft, k_hard)
            change = _change(step, before)
            solves += 1
        forces, q, gap = forces + step, q + motion, gap + moved
        history.append(Increment((k + 1) / increments, solves, int((gap <= 0).sum()), change))
    settled = all(increment.change <= STEP_TOLERANCE for increment in history)
    return Approximation(forces, q, gap, problem.residuals(forces, q), settled, tuple(history))


def condition_number(problem: ContactProblem, stiffness: ArrayLike) -> float:
    """Condition number of the equations that a displacement method solves: the bodies' stiffness and the springs'.

    Parameters
    ----------
    problem : ContactProblem
        With S as a regular array; lengths are taken relative to the square root of its diagonal.
    stiffness : float or (n,) array
        Of the springs; zero where there is none.

    Returns
    -------
    float
        Of S^-1 + diag k on the condensed points, rigid motions held.

    Raises
    ------
    InputError
        If S is an operator or singular.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers import ContactProblem
    >>> problem = ContactProblem(S=np.eye(2), g=np.zeros(2))
    >>> round(condition_number(problem, np.array([0.0, 99.0])), 9)
    100.0
    """
    S = _array(problem)
    d = np.sqrt(S.diagonal())
    if d.min() <= 0:
        raise InputError("A point that is rigid has no stiffness: the diagonal of S must be positive.")
    try:
        K = np.linalg.inv(S / d / d[:, None])
    except np.linalg.LinAlgError as error:
        raise InputError("The compliance is singular and has no stiffness; thin out the candidates.") from error
    springs = np.broadcast_to(np.asarray(stiffness, dtype=float), d.shape) * d**2
    return float(np.linalg.cond((K + K.T) / 2 + np.diag(springs)))


def _array(problem: ContactProblem) -> Array:
    if not isinstance(problem.S, np.ndarray):
        raise InputError("The baselines need the compliance as an array, and it is an operator.")
    return problem.S


def _checked(problem: ContactProblem, **stiffnesses: ArrayLike) -> tuple[Array, list[Array]]:
    """The compliance, and the stiffnesses (n,) of the springs."""
    springs = []
    for name, given in stiffnesses.items():
        k = np.asarray(given, dtype=float)
        if k.shape not in ((), (problem.n,)):
            raise InputError(f"{name} must be one number or one per point, {problem.n}; found shape {k.shape}.")
        if not (np.isfinite(k).all() and (k > 0).all()):
            raise InputError(f"{name} must be a positive stiffness, force per length; found {given!r}.")
        springs.append(np.broadcast_to(k, (problem.n,)))
    return _array(problem), springs


def _first_guess(problem: ContactProblem) -> NDArray[np.bool_]:
    """Points that penetrate, or those that close first: as many as hold the rigid motions."""
    touching = problem.g < 0
    if problem.m and touching.sum() < 3 * problem.m:
        touching[np.argsort(problem.g, kind="stable")[: 3 * problem.m]] = True
    return touching


def _solve(
    S: Array, compliance: Array, B: Array, points: NDArray[np.int64], right: Array, F: Array
) -> tuple[Array, Array]:
    """Forces (a,) on the points and motion (m,) of (S + diag c) l + B^T q = right, B l = F."""
    rows = B[:, points]
    scale = np.abs(rows).max(axis=1, initial=0.0)
    seen = scale > 0
    if F[~seen].any():
        raise SolverError("The springs that push leave a motion open that the load drives; use a softer penalty.")
    H = S[np.ix_(points, points)] + np.diag(compliance[points])
    rows = rows[seen] / scale[seen, None]
    solved = np.linalg.solve(H, np.column_stack([right[points], rows.T]))
    schur = rows @ solved[:, 1:]
    q = np.zeros(len(F))
    # of least norm where the points leave a motion open
    q[seen] = np.linalg.lstsq(schur, rows @ solved[:, 0] - F[seen] / scale[seen], rcond=1e-12)[0]
    forces = solved[:, 0] - solved[:, 1:] @ q[seen]
    q[seen] /= scale[seen]
    return forces, q


def _average(before: Array, after: Array, soft: Array, hard: Array) -> Array:
    """Average stiffness (n,) of the bilinear law between two gaps: what the force changes by over what the gap does."""
    open_part = np.maximum(before, 0.0) - np.maximum(after, 0.0)
    closed_part = np.minimum(before, 0.0) - np.minimum(after, 0.0)
    both = open_part + closed_part
    tangent = np.where(before > 0, soft, hard)
    return np.divide(soft * open_part + hard * closed_part, both, out=tangent, where=both != 0)


def _change(now: Array, before: Array) -> float:
    largest = float(np.abs(now).max(initial=0.0))
    return float(np.abs(now - before).max(initial=0.0)) / largest if largest else 0.0
