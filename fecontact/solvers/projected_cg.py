"""Projected conjugate gradients: matrix products only, for many points and for compliances that are operators.

The method is that of `operator_cg`, without a preconditioner. Convergence is that of conjugate gradients once the set
is found: slow where S is nearly singular, where the direct solvers do better.
"""

from __future__ import annotations

import numpy as np

from fecontact.solvers.feasible import project
from fecontact.solvers.operator_cg import OperatorProblem, solve_with_operator
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import Status
from fecontact.solvers.scaling import ScaledProblem

CLOSED = 1e-12
"""Gap at an active point, and penetration elsewhere, relative to the largest deflection: the end."""


def projected_cg(
    problem: ScaledProblem, start: np.ndarray | None = None, *, max_iterations: int | None = None
) -> Outcome:
    """Solve by projected conjugate gradients.

    Parameters
    ----------
    problem : ScaledProblem
        Its S may be an operator.
    start : ndarray of bool, shape (n,), optional
        Points thought to be active.
    max_iterations : int, optional
        Largest number of steps, and of active sets, 1000 + 2 n by default.

    Returns
    -------
    Outcome
        ``solved`` or ``iteration-limit``. The history is the largest gap in touch or penetration, relative to the
        largest deflection, after each active set.

    References
    ----------
    I. A. Polonsky, L. M. Keer, A numerical method for solving rough contact problems based on the multi-level
    multi-summation and conjugate gradient techniques, Wear 231 (1999) 206-219.

    Examples
    --------
    >>> import numpy as np
    >>> from fecontact.solvers.scaling import scale
    >>> problem = scale(np.eye(3), np.array([0.0, 0.0, 9.0]), np.ones((1, 3)), np.array([1.0]))
    >>> outcome = projected_cg(problem)
    >>> outcome.status.value, problem.forces(outcome.x).round(12).tolist()
    ('solved', [0.5, 0.5, 0.0])
    """
    limit = 1000 + 2 * problem.n if max_iterations is None else max_iterations

    def product(x: np.ndarray) -> np.ndarray:
        return np.asarray(problem.S @ x)

    everywhere = np.ones(problem.n, dtype=bool)
    given = OperatorProblem(product, problem.g, problem.B, problem.F, everywhere, product)
    first = project(problem.B, problem.F, np.zeros(problem.n) if start is None else start.astype(float))[0]
    at = solve_with_operator(given, first, first > 0, CLOSED, most_rounds=limit, most_steps=limit)
    if at.converged:
        return Outcome(at.x, at.q, Status.SOLVED, "solved", at.nit, list(at.history))
    message = f"{at.nit} steps on {at.rounds} active sets were not enough"
    return Outcome(at.x, at.q, Status.ITERATION_LIMIT, message, at.nit, list(at.history))
