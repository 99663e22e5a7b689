"""Settings of a solve, checked before any work."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from fecontact.common.checks import among, share
from fecontact.solvers import CustomSolver, validate_options


@dataclass(frozen=True)
class Settings:
    """Settings of a solve: `solver`, `tolerance` of the certificate, and the solver's `options`."""

    solver: str | CustomSolver
    tolerance: float
    options: Mapping[str, Any]

    def check(self, arguments: Iterable[str] = ()) -> None:
        """Refuse an unknown solver or option before any work; it may be one of some arguments, misspelt."""
        share("the tolerance", self.tolerance)
        validate_options(self.solver, self.options, arguments)


SEARCHES = ("global", "local")


def checked_search(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `Scene.solve` or of a case with a checked ``search``.

    Raises
    ------
    InputError
        For an unknown search.
    """
    if "search" in arguments:
        among("search", arguments["search"], SEARCHES)
    return dict(arguments)
