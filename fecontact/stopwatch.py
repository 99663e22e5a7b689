"""Time by stage: how long meshing, assembly, factorisation and the rest have taken."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Stopwatch:
    """Adds up wall seconds by stage; a stage may be entered many times, stages are not nested.

    Examples
    --------
    >>> watch = Stopwatch()
    >>> with watch("assemble"):
    ...     pass
    >>> list(watch.seconds)
    ['assemble']
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the time spent inside ``with watch(stage):``."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start
