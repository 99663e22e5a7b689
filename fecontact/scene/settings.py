"""How a problem is to be solved, checked before any work."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fecontact.common.errors import InputError
from fecontact.solvers import CustomSolver, validate_options


@dataclass(frozen=True)
class Settings:
    """How a problem is to be solved: `solver`, `tolerance` of the certificate, and the solver's `options`."""

    solver: str | CustomSolver
    tolerance: float
    options: Mapping[str, Any]

    def check(self) -> None:
        """Refuse an unknown solver or option before any work."""
        if not (np.isfinite(self.tolerance) and 0 < self.tolerance < 1):
            raise InputError(f"The tolerance must lie between 0 and 1; found {self.tolerance!r}.")
        validate_options(self.solver, self.options)
