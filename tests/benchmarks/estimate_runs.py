"""All runs in which estimates of the error are held against the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import estimate_half_spaces
import estimate_more
import estimate_response
from estimate_cases import FAMILIES, Case, Judged, judged

#: Families by what they were used for.
GROUPS = {
    "families the estimate was made with": list(FAMILIES),
    "families added later, the estimate unchanged": list(estimate_more.FAMILIES),
    "half-spaces": list(estimate_half_spaces.FAMILIES),
    "bodies of all kinds, forces and approaches": list(estimate_response.FAMILIES),
}
#: Families whose answer is a series of hats: its edge is known to a hat only, and areas are not compared.
SERIES = ("receding", "pin")


def runs() -> Iterator[tuple[str, object, Callable[[], Judged]]]:
    """Family, size of the mesh or grid, and what solves it."""
    for name, (sizes, solve) in {**FAMILIES, **estimate_more.FAMILIES}.items():
        for size in sizes:
            yield name, size, partial(_judged, solve, name, size)
    for name, (sizes, solve) in {**estimate_half_spaces.FAMILIES, **estimate_response.FAMILIES}.items():
        for size in sizes:
            yield name, size, partial(solve, size)


def _judged(solve: Callable[..., Case], name: str, size: object) -> Judged:
    found = judged(solve(size))
    if name.startswith(SERIES):
        found.figures.pop("area", None)
    return found
