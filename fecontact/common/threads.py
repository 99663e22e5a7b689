"""Work in threads: as many as there are cores, or as ``OMP_NUM_THREADS`` says, as the numerical libraries have it.

Array operations release Python's lock, so threads work at the same time where each has arrays of its own.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def default_threads() -> int:
    """Number of threads: ``OMP_NUM_THREADS`` if it is a positive number, else the cores that this process may use.

    Examples
    --------
    >>> default_threads() >= 1
    True
    """
    asked = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0].strip()
    if asked.isdecimal() and int(asked) > 0:
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def each(function: Callable[[Item], Result], items: Sequence[Item], threads: int | None = None) -> list[Result]:
    """Results of a function of each item, in order; items are taken by several threads.

    Parameters
    ----------
    function : callable
        Safe to be called from several threads at once; it must not call `each` itself.
    items : sequence
    threads : int, optional
        `default_threads` unless given. With one, or a single item, the function is called here.

    Examples
    --------
    >>> each(lambda n: n * n, [1, 2, 3], threads=2)
    [1, 4, 9]
    """
    threads = min(default_threads() if threads is None else threads, len(items))
    return list(map(function, items) if threads <= 1 else _pool(threads).map(function, items))


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads kept for the next call."""
    return ThreadPoolExecutor(threads, "fecontact")
