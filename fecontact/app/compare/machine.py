"""On what a measurement was made."""

from __future__ import annotations

import os
import platform
from functools import cache
from pathlib import Path

from fecontact.common.fingerprint import fingerprint

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


#: Modules of the package that show what was measured, and have no part in it.
SHOWING = ("command.py", "page.py", "picture.py", "precision.py")


@cache
def code() -> str:
    """Fingerprint of the package's sources: what is measured is what they do now."""
    root = Path(__file__).parents[1]
    files = [p for p in sorted(root.rglob("*.py")) if not (p.parent.name == "compare" and p.name in SHOWING)]
    return fingerprint([(str(p.relative_to(root)), p.read_bytes()) for p in files])


def threads_as_set() -> dict[str, str | None]:
    """The variables that tell the libraries how many threads to use."""
    return {name: os.environ.get(name) for name in THREADS}


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
