"""Which tests run which code, by coverage with a context for each test: worked out once for each test file.

Code is known by its function and its text, not by file and line, so that a map stands when files are moved or edited.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import signal
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import coverage
import pytest
from judging import DAY
from mutants import PACKAGE, Mutant

LONGEST = 5.0
"""Processor time in seconds, with coverage, that a test may take to judge mutants."""

Code = tuple[str, str]
"""A function's qualified name and the text of one of its lines."""


class Touching:
    """The map, kept in a file.

    Parameters
    ----------
    root : Path
    path : Path
    day : bool
        Only tests that are not marked as full.
    """

    def __init__(self, root: Path, path: Path, day: bool) -> None:
        self.root, self.path, self.day = root, path, day
        self.files: dict[str, dict[str, Any]] = json.loads(path.read_text()) if path.exists() else {}

    def collect(self, files: Sequence[Path], jobs: int) -> None:
        """Run the files that are new or changed, each in a process of its own, so many at a time."""
        digests = {path: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
        new = [path for path in files if not self._known(self._name(path), digests[path])]
        with ThreadPoolExecutor(jobs) as pool:
            for path, told in zip(new, pool.map(self._run, new), strict=True):
                self.files[self._name(path)] = {"digest": digests[path], "day": self.day, "told": told}
                self.path.write_text(json.dumps(self.files))
        self._by_code: dict[str, dict[Code, set[str]]] = {}
        self._seconds: dict[str, float] = {}
        for name in map(self._name, files):
            told, found = self.files[name]["told"], self._by_code.setdefault(name, defaultdict(set))
            for test, (seconds, numbers) in told["tests"].items():
                self._seconds[test] = seconds
                if not (self.day and test in told["full"]):
                    for number in numbers:
                        found[tuple(told["code"][number])].add(test)

    def tests(self, mutant: Mutant, path: Path, files: Sequence[Path], budget: float) -> list[str]:
        """Tests of some files that run the changed code, the fastest first, as many as fit into a time in seconds."""
        codes = _uses(self.root, mutant.module, mutant.name) if mutant.name else _codes(path, mutant.lines)
        maps = [self._by_code[self._name(each)] for each in files]
        found = set().union(*(some.get(code, ()) for some in maps for code in codes))
        if not found and mutant.function:
            found = set().union(*(tests for some in maps for (f, _), tests in some.items() if f == mutant.function))
        out, spent = [], 0.0
        for test in sorted(found, key=lambda each: (self._seconds[each], each)):
            spent += self._seconds[test]
            if out and spent > budget:
                break
            out.append(test)
        return out

    def _name(self, path: Path) -> str:
        return str(path.relative_to(self.root))

    def _known(self, name: str, digest: str) -> bool:
        """Whether the map has a file as it is: one that was run by day may lack tests."""
        have = self.files.get(name, {"digest": "", "day": False})
        return bool(have["digest"] == digest and (self.day or not have["day"]))

    def _run(self, path: Path) -> dict[str, Any]:
        began = time.time()
        told = _in_child(self.root, path, self.day)
        print(f"  {self._name(path)}: {len(told['tests'])} tests, {time.time() - began:.0f} s", flush=True)
        return told


def _in_child(root: Path, path: Path, day: bool) -> dict[str, Any]:
    """Tests of one file that pass: the code they run, and for each its time and the numbers of its code."""
    with tempfile.NamedTemporaryFile() as file:  # a pipe would stay open in the children of other threads
        if child := os.fork():
            os.waitpid(child, 0)
            told = Path(file.name).read_text()
            return json.loads(told) if told else {"code": [], "tests": {}, "full": []}
        try:
            plugin = _Contexts(root)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            options = ["-q", "-p", "no:cacheprovider", "-o", "addopts=", *(DAY if day else ())]
            pytest.main([str(path), *options], plugins=[plugin])
            Path(file.name).write_text(json.dumps(plugin.told()))
        finally:
            os._exit(0)


class _Contexts:
    """Pytest plugin: a coverage context for each test, one for what all tests of a file share."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.coverage = coverage.Coverage(data_file=None, config_file=False, source=[str(root / PACKAGE)])
        self.seconds: dict[str, float] = {}
        self.passed: set[str] = set()
        self.full: set[str] = set()

    def pytest_sessionstart(self) -> None:
        self.coverage.start()
        signal.signal(signal.SIGVTALRM, _late)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self.coverage.switch_context("setup")

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        self.coverage.switch_context(item.nodeid)
        if item.get_closest_marker("full"):
            self.full.add(item.nodeid)
        began = time.process_time()
        signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            self.seconds[item.nodeid] = time.process_time() - began

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)

    def told(self) -> dict[str, Any]:
        self.coverage.stop()
        data = self.coverage.get_data()
        code: dict[str, set[Code]] = defaultdict(set)
        for name in data.measured_files():
            text = _texts(Path(name))
            for line, contexts in data.contexts_by_lineno(name).items():
                for context in contexts:
                    code[context].add(text.get(line, ("", "")))
        every = sorted(set().union(*code.values()))
        number = {each: k for k, each in enumerate(every)}
        # what a fixture does is the business of every test that shares it
        return {
            "code": every,
            "tests": {
                test: (round(self.seconds[test], 3), sorted(number[each] for each in code[test] | code["setup"]))
                for test in sorted(self.passed)
            },
            "full": sorted(self.full),
        }


def _late(number: int, frame: object) -> None:
    raise TimeoutError("a test that takes too long to judge mutants")


@cache
def _texts(path: Path) -> dict[int, Code]:
    """Function and text by line number."""
    source = path.read_text()
    lines = source.splitlines()
    out = {}

    def visit(node: ast.AST, function: str) -> None:
        for child in ast.iter_child_nodes(node):
            inner = function
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = f"{function}.{child.name}".lstrip(".")
                for k in range(child.body[0].lineno, (child.end_lineno or 0) + 1):
                    out[k] = (inner, lines[k - 1].strip())
            visit(child, inner)

    visit(ast.parse(source), "")
    return out


def _codes(path: Path, lines: Iterable[int]) -> list[Code]:
    text = _texts(path)
    return [text[line] for line in lines if line in text]


@cache
def _uses(root: Path, module: str, name: str) -> list[Code]:
    """Code that uses a constant of a module, there or where it is imported, also as a default."""
    out = []
    for path in sorted((root / PACKAGE).rglob("*.py")):
        tree = ast.parse(path.read_text())
        own = path.relative_to(root).with_suffix("").as_posix().replace("/", ".") == module
        if not own and not any(_imports(each, name) for each in tree.body):
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                defaults = [*node.args.defaults, *(each for each in node.args.kw_defaults if each)]
                if any(_is(name, each) for default in defaults for each in ast.walk(default)):
                    out += _codes(path, range(node.body[0].lineno, (node.end_lineno or 0) + 1))
            elif _is(name, node):
                out += _codes(path, range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return out


def _imports(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.ImportFrom) and any(each.name == name for each in node.names)


def _is(name: str, node: ast.AST) -> bool:
    return name == (getattr(node, "id", "") or getattr(node, "attr", ""))
