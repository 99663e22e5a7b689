"""On what a measurement was made."""

from __future__ import annotations

import os
import platform
from pathlib import Path

#: Variables that tell the libraries how many threads to use; read when they are loaded.
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NGS_NUM_THREADS")


def machine() -> str:
    """Processor and number of cores.

    Examples
    --------
    >>> machine().endswith("cores")
    True
    """
    return f"{_processor()}, {os.cpu_count()} cores"


def environment(threads: int) -> dict[str, str]:
    """This process's environment with the number of threads set."""
    return {**os.environ, **dict.fromkeys(THREADS, str(threads))}


def _processor() -> str:
    """Model of the processor, or its architecture where the system does not tell."""
    file = Path("/proc/cpuinfo")
    if file.is_file():
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return " ".join(value.split())
    return platform.processor() or platform.machine()
