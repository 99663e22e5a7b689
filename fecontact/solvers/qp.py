"""Back-ends of `qpsolvers`, on the nondimensional problem.

Most of them stop at their own tolerance, before the active set is exact. The registry polishes their answer on the set
they found and certifies it; an answer that fails is refused.

User-defined solvers: functions from the problem to forces and motions, checked for the form of their answer.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

from fecontact.common.errors import InputError, SolverError
from fecontact.solvers.problem import ContactProblem, Outcome, Status
from fecontact.solvers.scaling import ScaledProblem

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
