"""All runs in which estimates of the error are held against the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import estimate_half_spaces
import estimate_more
from estimate_cases import FAMILIES, Case, Judged, judged

#: Families by what they were used for.
GROUPS = {
    "families the estimate was made with": list(FAMILIES),
    "families added later, the estimate unchanged": list(estimate_more.FAMILIES),
    "half-spaces": list(estimate_half_spaces.FAMILIES),
}


def runs() -> Iterator[tuple[str, object, Callable[[], Judged]]]:
    """Family, size of the mesh or grid, and what solves it."""
    for name, (sizes, solve) in {**FAMILIES, **estimate_more.FAMILIES}.items():
        for size in sizes:
            yield name, size, partial(_judged, solve, size)
    for name, (sizes, grid) in estimate_half_spaces.FAMILIES.items():
        for size in sizes:
            yield name, size, partial(grid, size)


def _judged(solve: Callable[..., Case], size: object) -> Judged:
    return judged(solve(size))
