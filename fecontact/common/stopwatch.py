"""Wall time and peak memory of each stage of a run: meshing, assembly, factorisation and others."""

from __future__ import annotations

import ctypes
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from fecontact.common.progress import set_stage


class Stopwatch:
    """Sums of wall time by stage. A stage may be entered many times; stages are not nested.

    Attributes
    ----------
    seconds : dict
        By stage.
    memory : dict
        Peak resident memory of the process, in MB, up to the last end of each stage. It never falls: the stage in which
        it rises needed it. `before` is the peak before the first stage.
    before : float

    Examples
    --------
    >>> watch = Stopwatch()
    >>> with watch("assemble"):
    ...     pass
    >>> list(watch.seconds), list(watch.memory)
    (['assemble'], ['assemble'])
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.memory: dict[str, float] = {}
        self.before = peak_memory()

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Add the time spent inside ``with watch(stage):``, and tell the line of progress."""
        set_stage(stage)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start
            self.memory[stage] = peak_memory()


class _Counters(ctypes.Structure):
    """PROCESS_MEMORY_COUNTERS of Windows."""

    _fields_ = (
        ("cb", ctypes.c_uint32),
        ("page_faults", ctypes.c_uint32),
        ("peak", ctypes.c_size_t),
        ("rest", ctypes.c_size_t * 7),
    )


def peak_memory() -> float:
    """Peak resident memory of this process so far, in MB, as counted by the operating system."""
    if sys.platform == "win32":
        counters = _Counters(cb=ctypes.sizeof(_Counters))
        kernel = ctypes.WinDLL("kernel32")
        kernel.GetCurrentProcess.restype = ctypes.c_void_p
        kernel.K32GetProcessMemoryInfo.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint32)
        kernel.K32GetProcessMemoryInfo(kernel.GetCurrentProcess(), ctypes.byref(counters), counters.cb)
        return counters.peak / 1024**2
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1024 if sys.platform != "darwin" else peak / 1024**2
