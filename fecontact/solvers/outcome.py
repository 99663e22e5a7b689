"""Unverified answer of a solver."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fecontact.solvers.problem import Status


@dataclass(frozen=True, eq=False)
class Outcome:
    """Unverified answer of a solver.

    In scaled variables from the package's solvers, in those of the problem from a user's function.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Forces.
    p : ndarray, shape (r,)
        Multiplier of the equilibrium rows.
    status : Status
    message : str
    nit : int
        Iterations.
    history : list of float
    """

    x: np.ndarray
    p: np.ndarray
    status: Status
    message: str
    nit: int
    history: list[float] = field(default_factory=list)
