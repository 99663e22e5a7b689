"""Run the tests of a mutant in a process of its own, forked from one that has imported the libraries already."""

from __future__ import annotations

import contextlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import json
import os
import resource
import signal
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import CodeType
from typing import Any

import pytest
from mutants import PACKAGE, Mutant

LONGEST = 10
"""Wall time that a mutant may take, in its limits of processor time: other programs run too."""

FIRST = 8
"""Tests that are tried before the others."""

DAY = ("-m", "not full")
"""Options of pytest for the tests of every day."""

Work = tuple[Mutant, Path, list[str]]
Given = tuple[float, Sequence[str]]
"""Processor time for a mutant in seconds, options of pytest."""


def preload(root: Path) -> None:
    """Import the libraries that the package imports, but not the package: processes forked from here have them."""
    read, write = os.pipe()
    if child := os.fork():
        os.close(write)
        with os.fdopen(read) as stream:
            names = json.loads(stream.read())
        os.waitpid(child, 0)
        for name in names:
            with contextlib.suppress(Exception):
                importlib.import_module(name)
        return
    importlib.import_module(PACKAGE)
    found = importlib.import_module(PACKAGE).__file__ or ""
    if not found.startswith(str(root)):
        print(f"The package is imported from {found}, not from {root}.", file=sys.stderr)
    importlib.import_module("hypothesis")
    names = [name for name in sys.modules if name.split(".")[0] not in (PACKAGE, "__main__")]
    with os.fdopen(write, "w") as stream:
        stream.write(json.dumps(names))
    os._exit(0)


def judge(
    root: Path, work: Sequence[Work], jobs: int, limit: float, options: Sequence[str] = ()
) -> Iterator[tuple[Mutant, dict[str, Any]]]:
    """Each mutant and what became of it, as they end.

    Parameters
    ----------
    root : Path
    work : sequence of (mutant, file, tests)
    jobs : int
        Processes at a time.
    limit : float
        Processor time for a mutant in seconds.
    options : sequence of str
        Of pytest.
    """
    given = (limit, options)
    waiting, running = list(work)[::-1], {}
    sound: dict[str, bool] = {}
    while waiting or running:
        while waiting and len(running) < jobs:
            mutant, path, tests = waiting.pop()
            tests = [each for each in tests if sound.get(each, True)]
            if not tests:
                yield mutant, {"verdict": "survived", "by": "", "tests": 0, "seconds": 0.0}
                continue
            child, read = _forked(root, mutant, path, tests, given)
            running[child] = (mutant, path, tests, read)
        if not running:
            continue
        child, status, used = os.wait3(0)
        mutant, path, tests, read = running.pop(child)
        verdict, by = _verdict(status, read)
        if by in tests and not _sound(root, mutant, path, by, given, sound):
            print(f"  {by} fails on the package as it is: left out", flush=True)
            waiting.append((mutant, path, tests))
            continue
        seconds = round(used.ru_utime + used.ru_stime, 1)
        yield mutant, {"verdict": verdict, "by": by, "tests": len(tests), "seconds": seconds}


def _sound(root: Path, mutant: Mutant, path: Path, test: str, given: Given, known: dict[str, bool]) -> bool:
    """Whether a test that fails on a mutant passes on the original; tried once."""
    if test not in known:
        child, read = _forked(root, replace(mutant, source=path.read_text()), path, [test], given)
        known[test] = _verdict(os.waitpid(child, 0)[1], read)[0] != "killed"
    return known[test]


def _forked(root: Path, mutant: Mutant, path: Path, tests: list[str], given: Given) -> tuple[int, int]:
    """A process that runs tests on a mutant, and the pipe on which it tells what fails."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        _child(root, mutant, path, tests, given, write)
    os.close(write)
    return child, read


def _verdict(status: int, read: int) -> tuple[str, str]:
    """What became of a mutant, and by which test."""
    with os.fdopen(read) as stream:
        told = stream.read()
    if os.WIFSIGNALED(status):
        late = os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGALRM)
        return ("timed out", "") if late else ("killed", f"signal {os.WTERMSIG(status)}")
    if told:
        return "killed", told
    return ("survived", "") if os.WEXITSTATUS(status) == 0 else ("killed", "collection")


def _child(root: Path, mutant: Mutant, path: Path, tests: list[str], given: Given, write: int) -> None:
    """Run the tests on the mutant and end; a test that fails is named on the pipe."""
    limit, more = given
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
    signal.alarm(int(LONGEST * limit))
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    os.chdir(root)
    code = compile(mutant.source, str(path), "exec", dont_inherit=True)
    sys.meta_path.insert(0, _Finder(mutant.module, path, code))
    try:
        importlib.import_module(PACKAGE)
        importlib.import_module(mutant.module)
    except BaseException as error:
        os.write(write, f"import: {type(error).__name__}".encode())
        os._exit(1)
    options = ["-x", "-q", "-p", "no:cacheprovider", "--no-header", "--tb=no", "-o", "addopts=", *more]
    # most mutants die at once: only the files of the first few tests are read for them
    for some in (tests[:FIRST], tests[FIRST:]):
        end = pytest.main([*options, *some], plugins=[_First(write)]) if some else 0
        if end:
            break
    os._exit(int(end))


class _First:
    """Pytest plugin: names the first test that fails."""

    def __init__(self, write: int) -> None:
        self.write = write

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            os.write(self.write, report.nodeid.encode())


class _Finder(importlib.abc.MetaPathFinder):
    """Finds one module, in its mutated form."""

    def __init__(self, name: str, path: Path, code: CodeType) -> None:
        self.name, self.path, self.code = name, path, code

    def find_spec(self, name: str, path: Any, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        if name != self.name:
            return None
        loader = _Loader(name, str(self.path))
        loader.mutated = self.code
        inner = [str(self.path.parent)] if self.path.name == "__init__.py" else None
        return importlib.util.spec_from_file_location(name, self.path, loader=loader, submodule_search_locations=inner)


class _Loader(importlib.machinery.SourceFileLoader):
    mutated: CodeType

    def get_code(self, fullname: str) -> CodeType:
        return self.mutated
