"""Problems of contact, without friction and with it, and their solvers, without meshes or bodies.

Examples
--------
>>> import numpy as np
>>> problem = ContactProblem(S=np.eye(2), g=np.array([0.0, 3.0]), B=np.ones((1, 2)), F=np.array([1.0]))
>>> solution = solve(problem)
>>> (solution.forces + 0.0).round(12).tolist(), solution.residuals.within(1e-10)
([1.0, 0.0], True)
"""

from fecontact.common.renamed import renamed_names
from fecontact.solvers.coulomb import Residuals
from fecontact.solvers.friction import solve_friction
from fecontact.solvers.friction_slide import SlidingLoadError
from fecontact.solvers.problem import ContactProblem, InfeasibleLoadError, Outcome, Solution, Status
from fecontact.solvers.registry import TOLERANCE, CustomSolver, attempt, available_solvers, solve, validate_options
from fecontact.solvers.scaling import ScaledProblem

__all__ = [
    "TOLERANCE",
    "ContactProblem",
    "CustomSolver",
    "InfeasibleLoadError",
    "Outcome",
    "Residuals",
    "ScaledProblem",
    "SlidingLoadError",
    "Solution",
    "Status",
    "attempt",
    "available_solvers",
    "solve",
    "solve_friction",
    "validate_options",
]

__getattr__ = renamed_names(
    globals(),
    ComplementarityProblem="ContactProblem",
    FrictionResiduals="Residuals",
    FrictionSolution="Solution",
)
