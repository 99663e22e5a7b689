"""Settings of a solve, checked before any work."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from fecontact.common.checks import among, share
from fecontact.common.errors import InputError
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


def renamed(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `Scene.solve` or of a case with a checked ``search``, in place of the former ``whole``, which warns.

    Raises
    ------
    InputError
        For an unknown search, or for both names at once.
    """
    out = dict(arguments)
    if "whole" in out:
        whole = bool(out.pop("whole"))
        if "search" in out:
            raise InputError(f"search={out['search']!r} and whole={whole} are the same setting; give search alone.")
        out["search"] = SEARCHES[0 if whole else 1]
        warnings.warn(
            f"whole={whole} is now search={out['search']!r}; the old keyword will be removed.",
            DeprecationWarning,
            stacklevel=3,  # the caller of Scene.solve or Scene.sweep
        )
    if "search" in out:
        among("search", out["search"], SEARCHES)
    return out
