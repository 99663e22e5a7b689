"""Complementarity problems of frictionless contact and their solvers."""

from fecontact.solvers.problem import ComplementarityProblem, InfeasibleLoadError, Residuals, Solution, Status
from fecontact.solvers.registry import attempt, available_solvers, solve
from fecontact.solvers.scaling import ScaledProblem

__all__ = [
    "ComplementarityProblem",
    "InfeasibleLoadError",
    "Residuals",
    "ScaledProblem",
    "Solution",
    "Status",
    "attempt",
    "available_solvers",
    "solve",
]
