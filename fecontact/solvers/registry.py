"""Entry point of all solvers: names, options, certificate and fall-back.

The outcome of a solver is mapped to the units of the problem and polished by an equality solve on its active set. Its
residuals are recomputed from the problem, and only a solution within the tolerance is returned.

=================  ====================================================================================
``wolfe``          Wolfe's simplex, short form: the reference; S positive definite on the free motions
``active-set``     primal-dual active set: the fastest; S positive definite on the active points
``projected-cg``   matrix products only: large n, S may be a `scipy.sparse.linalg.LinearOperator`
``nnls``           Lawson and Hanson's method with equality rows: any semidefinite S, finite
others             back-ends of `qpsolvers` that are installed
a function         of the user, see `CustomSolver`
=================  ====================================================================================

Polish an answer on its active set, so that all solvers agree to rounding.

The equality problem is solved on the active set. Where its points depend on each other the forces are not unique; then
the smallest change of the forces that closes the gaps and balances the load is made, which keeps them positive.

Back-ends of `qpsolvers`, on the nondimensional problem.

Most of them stop at their own tolerance, before the active set is exact. The registry polishes their answer on the set
they found and certifies it; an answer that fails is refused.

User-defined solvers: functions from the problem to forces and motions, checked for the form of their answer.
"""

from __future__ import annotations

import inspect
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Protocol, runtime_checkable

import numpy as np
from scipy.linalg import lstsq
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator

from fecontact.common.arguments import known_names
from fecontact.common.errors import InputError, SolverError, SolverNotFoundError
from fecontact.solvers.active_set import active_set, least_motion
from fecontact.solvers.nnls import nnls
from fecontact.solvers.problem import ContactProblem, InfeasibleLoadError, Outcome, Solution, Status
from fecontact.solvers.projected_cg import projected_cg
from fecontact.solvers.scaling import ROUNDING, ScaledProblem
from fecontact.solvers.wolfe import wolfe

ACCURATE: dict[str, dict[str, object]] = {
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 50_000},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0},
    "piqp": {"eps_abs": 1e-10, "eps_rel": 1e-10},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 50_000},
}
"""Settings tighter than the back-ends' defaults, by their own names; the user's override them."""


def backends() -> tuple[str, ...]:
    """Names of the installed back-ends.

    Returns
    -------
    tuple of str
        Empty if `qpsolvers` is not installed.

    Examples
    --------
    >>> isinstance(backends(), tuple)
    True
    """
    try:
        import qpsolvers
    except ImportError:
        return ()
    return tuple(sorted(qpsolvers.available_solvers))


def backend(
    problem: ScaledProblem,
    start: np.ndarray | None = None,
    *,
    name: str,
    settings: Mapping[str, object] | None = None,
) -> Outcome:
    """Solve with one back-end.

    Parameters
    ----------
    problem : ScaledProblem
    start : ndarray of bool, shape (n,), optional
        Initial active set; only some back-ends use it.
    name : str
        One of `backends`.
    settings : mapping, optional
        Passed on to the back-end under its own names.

    Returns
    -------
    Outcome
        ``solved`` as the back-end claims it, or ``refused`` if it returned nothing. The number of iterations is zero
        where the back-end does not report it.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(2), np.array([-1.0, 1.0]), np.empty((0, 2)), np.empty(0))
    >>> backend(problem, name="osqp").x.round(6).tolist()
    [1.0, 0.0]
    """
    import qpsolvers

    sparse = name not in qpsolvers.dense_solvers
    matrix = csc_matrix if sparse else np.asarray
    rows = (matrix(problem.B), problem.F) if problem.r else (None, None)
    given = qpsolvers.Problem(matrix(problem.matrix), problem.g, A=rows[0], b=rows[1], lb=np.zeros(problem.n))
    x, p = np.zeros(problem.n), np.zeros(problem.r)
    chosen: dict[str, Any] = {**ACCURATE.get(name, {}), **(settings or {})}
    try:
        with warnings.catch_warnings():
            # warnings about accuracy are ignored: the certificate decides
            warnings.simplefilter("ignore")
            answer = qpsolvers.solve_problem(
                given, solver=name, initvals=None if start is None else start.astype(float), **chosen
            )
    except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError) as error:
        return Outcome(x, p, Status.REFUSED, f"the back-end gave up: {error}", 0)
    if answer.x is None or not np.isfinite(answer.x).all():
        return Outcome(x, p, Status.REFUSED, "the back-end found no answer", 0)
    p = answer.y if answer.y is not None and len(answer.y) == problem.r else p
    return Outcome(answer.x, np.asarray(p, dtype=float), Status.SOLVED, "solved", _iterations(answer.extras))


def _iterations(extras: Mapping[str, Any]) -> int:
    """Return the number of iterations that the back-end reports, zero if none."""
    told = extras.get("iterations", getattr(extras.get("info"), "iter", 0))
    return int(np.ravel(told)[0])


CustomSolver = Callable[..., Outcome | tuple[np.ndarray, np.ndarray]]
"""``solver(problem, **options)``: the forces (n,) and q (m,) of a `ContactProblem` in its own units, as a pair
or as an `Outcome` with a status. The name in results and messages is the function's."""


def solver_name(solver: str | CustomSolver) -> str:
    """Name for results and messages."""
    return solver if isinstance(solver, str) else getattr(solver, "__name__", type(solver).__name__)


def check_custom(solver: CustomSolver, options: Mapping[str, object]) -> None:
    """Refuse a function that cannot be called with a problem and these options.

    Raises
    ------
    InputError
        If it is not callable, or its parameters do not fit.
    """
    if not callable(solver):
        raise InputError(f"solver must be a name or a function of a ContactProblem; found {solver!r}.")
    try:
        parameters = inspect.signature(solver)
    except (TypeError, ValueError):  # compiled functions may have no signature
        return
    try:
        parameters.bind(None, **options)
    except TypeError as error:
        given = "".join(f", {name}=..." for name in options)
        raise InputError(
            f"The solver {solver_name(solver)!r} is called as solver(problem{given}), and its parameters are "
            f"{parameters}: {error}.",
            code="solver-call",
        ) from error


def solve_custom(
    problem: ContactProblem, scaled: ScaledProblem, solver: CustomSolver, options: Mapping[str, object]
) -> Outcome:
    """Call the user's function; return its outcome in scaled variables.

    Raises
    ------
    SolverError
        If the answer is not (forces, q), or has wrong shapes.
    """
    answer = solver(problem, **options)
    if isinstance(answer, tuple) and len(answer) == 2:
        answer = Outcome(*answer, Status.SOLVED, "solved", 0)
    if not isinstance(answer, Outcome):
        raise SolverError(
            f"The solver {solver_name(solver)!r} must return the pair (forces, q) or an Outcome; "
            f"found {type(answer).__name__}.",
            code="solver-answer",
        )
    forces = _entries(solver, "forces", answer.x, problem.n, "point")
    q = _entries(solver, "q", answer.p, problem.m, "row of B")
    p = scaled.B @ (problem.B.T @ q / scaled.gap_scale)  # the rows of scaled.B are orthonormal
    return replace(answer, x=forces / scaled.force_scale, p=p)


def _entries(solver: CustomSolver, what: str, value: object, n: int, per: str) -> np.ndarray:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise SolverError(f"The {what} from the solver {solver_name(solver)!r} are not numbers: {error}.") from error
    if array.shape != (n,):
        raise SolverError(
            f"The solver {solver_name(solver)!r} must return {what} of shape {(n,)}, one per {per}; "
            f"found shape {array.shape}.",
            code="solver-answer",
        )
    if not np.isfinite(array).all():
        count = int((~np.isfinite(array)).sum())
        raise SolverError(f"The solver {solver_name(solver)!r} returned {what} that are not finite: {count} of {n}.")
    return array


NEGLIGIBLE = 1e-12
"""Relative singular value ignored by the least-norm correction."""


def polish(problem: ScaledProblem, x: np.ndarray, p: np.ndarray, *, solves: int) -> list[Outcome]:
    """Improved candidates for an answer, unverified.

    Parameters
    ----------
    problem : ScaledProblem
    x : ndarray, shape (n,)
    p : ndarray, shape (r,)
    solves : int
        Equality solves allowed: one for an exact method, a few for one whose set may be inexact.

    Returns
    -------
    list of Outcome
        With status ``solved``; may be empty.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(2), np.array([-1.0, 1.0]), np.empty((0, 2)), np.empty(0))
    >>> polish(problem, np.array([0.999, 1e-5]), np.empty(0), solves=1)[0].x.tolist()
    [1.0, 0.0]
    """
    # a force of rounding size must not resist a free motion
    touching = x > np.maximum(problem.gap(x, p), ROUNDING * x.max())
    solved = active_set(problem, touching, max_iterations=solves)
    if solved.status is Status.SOLVED:
        return [solved]
    changed = _smallest_change(problem, x, p, touching)
    return [Outcome(np.maximum(changed[0], 0.0), changed[1], Status.SOLVED, "solved", 0)]


def _smallest_change(
    problem: ScaledProblem, x: np.ndarray, p: np.ndarray, touching: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return forces on the active points and the multiplier after two least-norm corrections."""
    points = np.flatnonzero(touching)
    rows = problem.B[:, points]
    K = np.block([[problem.matrix[np.ix_(points, points)], rows.T], [rows, np.zeros((problem.r, problem.r))]])
    x, p = np.where(touching, x, 0.0), p.copy()
    for _ in range(2):
        missing = np.concatenate([-problem.gap(x, p)[points], problem.F - problem.B @ x])
        change = lstsq(K, missing, cond=NEGLIGIBLE, lapack_driver="gelsy")[0] if len(missing) else missing
        x[points] += change[: len(points)]
        p += change[len(points) :]
    return x, p


NATIVE: dict[str, Callable[..., Outcome]] = {
    "wolfe": wolfe,
    "active-set": active_set,
    "projected-cg": projected_cg,
    "nnls": nnls,
}

TOLERANCE = 1e-10
"""Default for the largest relative residual of a certified solution; ten times that for the penetration."""

REMOVED = {"lemke": "nnls"}
"""Solvers of earlier versions, and which one answers the same problems now."""

FALL_BACK = ("active-set", "nnls")
"""Solvers that ``auto`` tries in turn: the fastest, then the one that is finite for every semidefinite S."""

FEW_SOLVES = 10
"""Equality solves to polish the answer of a back-end; exact methods and user functions get one."""


def available_solvers() -> tuple[str, ...]:
    """Names that `solve` accepts besides ``auto``: the package's solvers, then the installed back-ends of `qpsolvers`.

    Returns
    -------
    tuple of str

    Examples
    --------
    >>> available_solvers()[:4]
    ('wolfe', 'active-set', 'projected-cg', 'nnls')
    """
    return (*NATIVE, *backends())


def solve(
    problem: ContactProblem,
    solver: str | CustomSolver = "auto",
    *,
    start: np.ndarray | Solution | None = None,
    tolerance: float = TOLERANCE,
    **options: object,
) -> Solution:
    """Certified solution of a contact problem, or an error that says why there is none.

    Parameters
    ----------
    problem : ContactProblem
    solver : str or callable
        ``auto`` or one of `available_solvers`. ``auto`` tries the fast method and falls back on the finite one. Or a
        function of the problem that returns (forces, q), see `CustomSolver`; its answer is certified too.
    start : ndarray of bool or float, shape (n,), or Solution, optional
        Initial active set, or forces that are positive there. It is a hint: some methods ignore it, and the solution
        does not depend on it.
    tolerance : float
        Largest relative residual of a certified solution; ten times that for the penetration.
    **options
        ``max_iterations`` of the package's solvers; ``settings`` (a mapping) of the back-ends; keywords of a function.

    Returns
    -------
    Solution
        With ``success`` True.

    Raises
    ------
    InputError
        For an option that the solver does not have, a start that does not fit, or a problem with friction.
    SolverNotFoundError
        For a solver that is unknown or not installed.
    InfeasibleLoadError
        If no forces l >= 0 balance the load; its ``direction`` is the motion.
    SolverError
        If no certified solution was found.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers import ContactProblem, solve
    >>> problem = ContactProblem(
    ...     S=np.eye(3), g=np.array([0.0, 0.0, 9.0]), B=np.ones((1, 3)), F=np.array([1.0])
    ... )
    >>> solution = solve(problem)
    >>> solution.forces.round(12).tolist(), solution.q.round(12).tolist(), solution.status.value
    ([0.5, 0.5, 0.0], [-0.5], 'solved')
    """
    solution = attempt(problem, solver, start=start, tolerance=tolerance, **options)
    if solution.status is Status.INFEASIBLE:
        raise InfeasibleLoadError(solution.message, solution.q)
    if not solution.success:
        advice = (
            "Check that S is positive semidefinite and that the interference can be removed by a deflection."
            if solver == "auto"
            else "Use solver='auto', which falls back on a method for a singular compliance."
        )
        raise SolverError(
            f"No certified answer from solver {solver_name(solver)!r}: {solution.message} "
            f"(status {solution.status.value}; {solution.residuals}; tolerance {tolerance:.0e}). {advice}",
            code="not-certified",
        )
    return solution


def attempt(
    problem: ContactProblem,
    solver: str | CustomSolver = "auto",
    *,
    start: np.ndarray | Solution | None = None,
    tolerance: float = TOLERANCE,
    **options: object,
) -> Solution:
    """As `solve`, but a failure is returned as a `Solution` with ``success`` False; for comparisons.

    Parameters
    ----------
    problem, solver, start, tolerance, **options
        As in `solve`.

    Returns
    -------
    Solution

    Raises
    ------
    InputError, SolverNotFoundError
        As in `solve`.
    SolverError
        If the compliance is an operator and the solver needs an array, or a function's answer has the wrong form.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers import ContactProblem
    >>> pulled = ContactProblem(S=np.eye(1), g=np.ones(1), B=np.ones((1, 1)), F=np.array([-1.0]))
    >>> solution = attempt(pulled)
    >>> solution.success, solution.status.value, solution.q.tolist()
    (False, 'infeasible', [1.0])
    """
    began = time.perf_counter()
    if problem.points.size:
        raise InputError("The problem has friction: solve it by `solve_friction`.", code="has-friction")
    validate_options(solver, options)
    chain = _chain(problem, solver)
    touching = _touching(problem, start)
    scaled = problem.scaled()
    simple = _without_solver(problem, scaled, solver)
    if simple is not None:
        return replace(simple, seconds=time.perf_counter() - began)
    failures: list[Solution] = []
    if solver == "auto" and isinstance(problem.S, SolvingOperator):
        outcome = problem.S.solve_contact(problem, tolerance)
        solution = _certified(_claimed(problem, outcome, problem.S.solver), tolerance)
        if solution.success:
            return replace(solution, seconds=time.perf_counter() - began)
        failures.append(solution)
    for each in chain:
        solution = _certified(_found(problem, scaled, each, touching, tolerance, options), tolerance)
        solution = replace(solution, seconds=time.perf_counter() - began)
        if solution.success:
            return solution
        failures.append(solution)
    best = min(failures, key=lambda failure: failure.residuals.worst)
    if len(failures) == 1:
        return best
    if best.status in (Status.CYCLING, Status.ITERATION_LIMIT) and best.residuals.within(tolerance):
        return replace(best, status=Status.SOLVED)  # rounding kept it from its end: the certificate decides
    status = Status.UNBOUNDED if failures[-1].status is Status.UNBOUNDED else best.status
    message = "; ".join(f"{failure.solver}: {failure.message}" for failure in failures)
    return replace(best, status=status, message=message, seconds=failures[-1].seconds)


@runtime_checkable
class SolvingOperator(Protocol):
    """A compliance operator with its own solver."""

    @property
    def solver(self) -> str:
        """Name of the solver."""

    def solve_contact(self, problem: ContactProblem, tolerance: float) -> Outcome:
        """Forces and motions of the problem in its own units."""


def _certified(solution: Solution, tolerance: float) -> Solution:
    """The solution, with status ``refused`` if it is claimed solved and its residuals exceed the tolerance."""
    if solution.status is not Status.SOLVED or solution.residuals.within(tolerance):
        return solution
    return replace(solution, status=Status.REFUSED, message="the answer does not pass the certificate")


def _claimed(problem: ContactProblem, outcome: Outcome, solver: str) -> Solution:
    """An outcome in the problem's own units, unverified."""
    return Solution(
        problem, outcome.x, outcome.p, outcome.status, outcome.message, outcome.nit, solver,
        history=tuple(outcome.history),
    )  # fmt: skip


def validate_options(solver: str | CustomSolver, options: Mapping[str, object]) -> None:
    """Refuse an unknown solver or unknown options, before a problem is built.

    Parameters
    ----------
    solver : str or callable
        As in `solve`.
    options : mapping

    Raises
    ------
    InputError
        For an option that the solver does not have, or a function that cannot be called with them.
    SolverNotFoundError
        For a solver that is unknown or not installed.

    Examples
    --------
    >>> validate_options("wolfe", {"max_iterations": 100})
    >>> validate_options("nnls", {"settings": {}})
    Traceback (most recent call last):
    fecontact.common.errors.InputError: The solver 'nnls' has no 'settings'. It takes: max_iterations.
    """
    if not isinstance(solver, str):
        check_custom(solver, options)
        return
    if solver in REMOVED:
        raise SolverNotFoundError(
            f"The solver {solver!r} was removed. Use solver={REMOVED[solver]!r}, which answers the same problems, "
            "or solver='auto'.",
            code="removed-solver",
        )
    if solver != "auto" and solver not in NATIVE and solver not in backends():
        raise SolverNotFoundError(
            f"There is no solver {solver!r} here. Available: auto, {', '.join(available_solvers())}. "
            "More come with the back-ends of qpsolvers: pip install 'fecontact[qp]'."
        )
    for name in (*FALL_BACK, "projected-cg") if solver == "auto" else (solver,):
        parameters = inspect.signature(NATIVE.get(name, backend)).parameters.values()
        allowed = {each.name for each in parameters if each.kind is each.KEYWORD_ONLY} - {"name"}
        known_names(f"The solver {name!r}", options, allowed)
    iterations = options.get("max_iterations", 1)
    if not (isinstance(iterations, int) and iterations > 0):
        raise InputError(f"max_iterations must be a positive integer; found {iterations!r}.", code="max-iterations")


def _chain(problem: ContactProblem, solver: str | CustomSolver) -> tuple[str | CustomSolver, ...]:
    """Solvers to try in turn."""
    operator = isinstance(problem.S, LinearOperator)
    if solver == "auto":
        return ("projected-cg",) if operator else FALL_BACK
    if operator and isinstance(solver, str) and solver != "projected-cg":
        raise SolverError(
            f"The solver {solver!r} needs the compliance as an array, and it is an operator. "
            "Use solver='projected-cg' or 'auto', or form the array.",
            code="needs-array",
        )
    return (solver,)


def _touching(problem: ContactProblem, start: np.ndarray | Solution | None) -> np.ndarray | None:
    if start is None:
        return None
    mask = start.active if isinstance(start, Solution) else np.asarray(start) > 0
    if mask.shape != (problem.n,):
        raise InputError(f"start must have one entry per point, shape {(problem.n,)}; found {mask.shape}.")
    return mask


def _without_solver(problem: ContactProblem, scaled: ScaledProblem, solver: str | CustomSolver) -> Solution | None:
    """Solution of the two cases that need no solver: no contact, or a load that cannot be balanced."""
    zero, still, name = np.zeros(problem.n), np.zeros(problem.m), solver_name(solver)
    if not problem.F.any() and problem.g.min() >= 0:
        return Solution(problem, zero, still, Status.NO_CONTACT, "nothing touches", 0, name)
    direction = scaled.free_direction()
    if direction is None:
        return None
    message = (
        "No contact forces l >= 0 balance the load: along the motion q the load does work and no gap closes. "
        "Hold that motion, or change the load."
    )
    return Solution(problem, zero, direction, Status.INFEASIBLE, message, 0, name)


def _found(
    problem: ContactProblem,
    scaled: ScaledProblem,
    solver: str | CustomSolver,
    start: np.ndarray | None,
    tolerance: float,
    options: dict[str, object],
) -> Solution:
    """Polished outcomes of one solver."""
    name = solver_name(solver)
    if not isinstance(solver, str):
        outcome = solve_custom(problem, scaled, solver, options)
    else:
        outcome = NATIVE.get(solver, partial(backend, name=solver))(scaled, start, **options)
    claimed = _claimed(problem, _unscaled(problem, scaled, outcome), name)
    if outcome.status is not Status.SOLVED or not isinstance(scaled.S, np.ndarray):
        return claimed
    if solver == "active-set":
        return _least_motion(scaled, claimed, outcome.p, tolerance)
    solves = FEW_SOLVES if isinstance(solver, str) and solver not in NATIVE else 1
    sharper = [_unscaled(problem, scaled, each) for each in polish(scaled, outcome.x, outcome.p, solves=solves)]
    # the polished one first: where the active points leave a motion free, it has the smallest
    every = [*(replace(claimed, forces=each.x, q=each.p) for each in sharper), claimed]
    passing = (each for each in every if each.residuals.within(tolerance))
    return next(passing, None) or min(every, key=lambda each: each.residuals.worst)


def _least_motion(scaled: ScaledProblem, claimed: Solution, p: np.ndarray, tolerance: float) -> Solution:
    """The solution without the part of its motion p (r,) that points with forces leave free.

    An active point without force holds that part, and rounding decides whether there is one.
    """
    carrying = np.flatnonzero(claimed.forces > 0)
    if len(carrying) == 0 or (motion := least_motion(scaled, carrying, p)) is p:
        return claimed
    least = replace(claimed, q=scaled.motion(motion))
    return least if least.residuals.within(tolerance) else claimed


def _unscaled(problem: ContactProblem, scaled: ScaledProblem, outcome: Outcome) -> Outcome:
    """An outcome in the units of the problem; a point whose force is rounding carries none."""
    rounding = ROUNDING * outcome.x.max() if problem.F.any() else scaled.rounding_of(outcome.x)
    x = np.where(np.abs(outcome.x) <= rounding, 0.0, outcome.x)
    return replace(outcome, x=scaled.forces(x), p=scaled.motion(outcome.p))
