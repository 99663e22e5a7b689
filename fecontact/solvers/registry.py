"""One door to all solvers: names, options, the certificate and the fall-back.

No solver certifies itself. Its outcome is mapped back, its residuals are recomputed from the problem, and only
what passes is returned.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from fecontact.errors import InputError, SolverError, SolverNotFoundError
from fecontact.solvers.active_set import active_set
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import ComplementarityProblem, InfeasibleLoadError, Solution, Status
from fecontact.solvers.scaling import ScaledProblem

SOLVERS: dict[str, Callable[..., Outcome]] = {"active-set": active_set}


def available_solvers() -> tuple[str, ...]:
    """Names that `solve` accepts besides ``auto``."""
    return tuple(SOLVERS)


def solve(
    problem: ComplementarityProblem,
    solver: str = "auto",
    *,
    start: np.ndarray | None = None,
    tolerance: float = 1e-10,
    **options: object,
) -> Solution:
    """Certified answer of a contact problem, or an error that says why there is none."""
    solution = attempt(problem, solver, start=start, tolerance=tolerance, **options)
    if solution.status is Status.INFEASIBLE:
        raise InfeasibleLoadError(solution.message, solution.q)
    if not solution.success:
        raise SolverError(f"{solution.solver}: {solution.status}: {solution.message} ({solution.residuals}).")
    return solution


def attempt(
    problem: ComplementarityProblem,
    solver: str = "auto",
    *,
    start: np.ndarray | None = None,
    tolerance: float = 1e-10,
    **options: object,
) -> Solution:
    """As `solve`, but a failure comes back as a `Solution` with ``success`` False."""
    began = time.perf_counter()
    names = ("active-set",) if solver == "auto" else (solver,)
    if names[0] not in SOLVERS:
        raise SolverNotFoundError(f"Unknown solver {solver!r}; available: auto, {', '.join(available_solvers())}.")
    if options:
        raise InputError(f"Unknown options {sorted(options)}.")
    scaled = problem.scaled()
    if not scaled.F.any() and not scaled.inconsistency.any() and scaled.g.min() >= 0:
        nothing = Outcome(np.zeros(scaled.n), np.zeros(scaled.r), Status.NO_CONTACT, "nothing touches", 0)
        return _judge(problem, scaled, nothing, solver, tolerance, began)
    if (direction := scaled.free_direction()) is not None:
        message = "no contact forces l >= 0 balance the load; q is a motion that the load pushes and no point resists"
        zero = np.zeros(problem.n)
        residuals = problem.residuals(zero, np.zeros(problem.m))
        gap = problem.gap(zero, direction)
        seconds = time.perf_counter() - began
        return Solution(zero, direction, gap, False, Status.INFEASIBLE, message, 0, solver, residuals, seconds)
    outcome = SOLVERS[names[0]](scaled, start, **options)
    return _judge(problem, scaled, outcome, names[0], tolerance, began)


def _judge(
    problem: ComplementarityProblem,
    scaled: ScaledProblem,
    outcome: Outcome,
    name: str,
    tolerance: float,
    began: float,
) -> Solution:
    forces, q = scaled.forces(outcome.x), scaled.motion(outcome.p)
    residuals = problem.residuals(forces, q)
    claimed = outcome.status in (Status.SOLVED, Status.NO_CONTACT)
    success = claimed and residuals.within(tolerance)
    status = Status.REFUSED if claimed and not success else outcome.status
    return Solution(
        forces=forces,
        q=q,
        gap=problem.gap(forces, q),
        success=success,
        status=status,
        message=outcome.message,
        nit=outcome.nit,
        solver=name,
        residuals=residuals,
        seconds=time.perf_counter() - began,
        history=tuple(outcome.history),
    )
