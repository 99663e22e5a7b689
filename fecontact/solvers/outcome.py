"""What a solver hands back, in scaled variables and before anybody has checked it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fecontact.solvers.problem import Status


@dataclass(frozen=True, eq=False)
class Outcome:
    """Claim of a solver; the certificate is not its business.

    Parameters
    ----------
    x : ndarray, shape (n,)
    p : ndarray, shape (r,)
    status : Status
    message : str
    nit : int
    history : list of float
    """

    x: np.ndarray
    p: np.ndarray
    status: Status
    message: str
    nit: int
    history: list[float] = field(default_factory=list)
