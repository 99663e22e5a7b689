"""Load steps that are cut in halves where they have no certified solution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

from fecontact.common.errors import SolverError, SupportError

Step = TypeVar("Step")
Result = TypeVar("Result")

#: Halvings of a step.
HALVINGS = 5


def in_parts(
    solve: Callable[[Step, Step, Result | None], Result],
    start: Step,
    end: Step,
    last: Result | None,
    halfway: Callable[[Step, Step], Step],
    halvings: int = HALVINGS,
) -> Iterator[Result]:
    """Results of a load step: one, or those of its halves, one after the other.

    Parameters
    ----------
    solve : callable
        Function ``solve(start, end, last)`` of loads at both ends and the result at the start.
    start, end : loads
    last : result, optional
        At the start.
    halfway : callable
        Loads half way between two.
    halvings : int

    Raises
    ------
    SolverError
        That of the smallest part. Loads that nothing holds are refused at once.

    Examples
    --------
    >>> def solve(start, end, last):
    ...     if end - start > 1:
    ...         raise SolverError("too far")
    ...     return end
    >>> list(in_parts(solve, 0.0, 3.0, None, lambda a, b: (a + b) / 2))
    [0.75, 1.5, 2.25, 3.0]
    """
    try:
        found = solve(start, end, last)
    except SolverError as error:
        if isinstance(error, SupportError) or not halvings:
            raise
    else:
        yield found
        return
    middle = halfway(start, end)
    for first, second in ((start, middle), (middle, end)):
        for part in in_parts(solve, first, second, last, halfway, halvings - 1):
            yield part
            last = part
