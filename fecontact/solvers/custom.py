"""User-defined solvers: functions from the problem to forces and motions, checked for the form of their answer."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fecontact.common.errors import InputError, SolverError
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import ComplementarityProblem, Status
from fecontact.solvers.scaling import ScaledProblem

CustomSolver = Callable[..., Outcome | tuple[np.ndarray, np.ndarray]]
"""``solver(problem, **options)``: the forces (n,) and q (m,) of a `ComplementarityProblem` in its own units, as a pair
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
        raise InputError(f"solver must be a name or a function of a ComplementarityProblem; found {solver!r}.")
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
            f"{parameters}: {error}."
        ) from error


def solve_custom(
    problem: ComplementarityProblem, scaled: ScaledProblem, solver: CustomSolver, options: Mapping[str, object]
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
            f"found {type(answer).__name__}."
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
            f"found shape {array.shape}."
        )
    if not np.isfinite(array).all():
        count = int((~np.isfinite(array)).sum())
        raise SolverError(f"The solver {solver_name(solver)!r} returned {what} that are not finite: {count} of {n}.")
    return array
