"""Settings of a solve, checked before any work."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from fecontact.common.checks import among, share
from fecontact.common.errors import InputError, shown
from fecontact.solvers import TOLERANCE, CustomSolver, validate_options

SEARCHES = ("global", "local")


@dataclass(frozen=True)
class Settings:
    """Settings of a solve, as the arguments of `Scene.solve` of the same names; `options` are the solver's."""

    solver: str | CustomSolver = "auto"
    tolerance: float = TOLERANCE
    options: Mapping[str, Any] = field(default_factory=dict)
    search: str = "global"
    finite_motion: bool | str = "auto"

    def check(self, arguments: Iterable[str] = ()) -> None:
        """Refuse what is out of range before any work; an unknown option may be one of some arguments, misspelt.

        Raises
        ------
        InputError
        """
        among("search", self.search, SEARCHES)
        share("the tolerance", self.tolerance)
        validate_options(self.solver, self.options, arguments)
        finite = self.finite_motion
        if not isinstance(finite, bool) and not (isinstance(finite, str) and finite == "auto"):
            raise InputError(f"finite_motion must be 'auto', True or False; found {shown(finite)}.", code="motion")
