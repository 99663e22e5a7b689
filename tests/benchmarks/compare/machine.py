"""Benchmark conditions: processor, threads, and version of the package's code."""

from __future__ import annotations

import os
import platform
from functools import cache
from pathlib import Path

import fecontact
from fecontact.common.fingerprint import fingerprint

#: Environment variables for the number of threads of the libraries; read when these are loaded.
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
    """Fingerprint of the package's present sources."""
    return of_sources(Path(fecontact.__file__).parent)


def of_sources(folder: Path) -> str:
    """Fingerprint of the Python files in a folder and below."""
    files = sorted(folder.rglob("*.py"))
    return fingerprint([(str(file.relative_to(folder)), file.read_bytes()) for file in files])


def _processor() -> str:
    """Model of the processor, or its architecture where the model is unknown."""
    file = Path("/proc/cpuinfo")
    if file.is_file():
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return " ".join(value.split())
    return platform.processor() or platform.machine()
