"""What a measurement was made on: processor, threads, and the package's code as it is."""

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


@cache
def code() -> str:
    """Fingerprint of the package's sources: what is measured is what they do now."""
    return of_sources(Path(__file__).parents[2])


def of_sources(folder: Path) -> str:
    """Fingerprint of the Python files in a folder and below."""
    files = sorted(folder.rglob("*.py"))
    return fingerprint([(str(file.relative_to(folder)), file.read_bytes()) for file in files])


def threads_as_set() -> dict[str, str | None]:
    """The variables that tell the libraries how many threads to use."""
    return {name: os.environ.get(name) for name in THREADS}


def _processor() -> str:
    """Model of the processor, or its architecture where the system does not tell."""
    file = Path("/proc/cpuinfo")
    if file.is_file():
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return " ".join(value.split())
    return platform.processor() or platform.machine()
