"""Which tests run which code, by coverage with a context for each test: worked out once for each test file.

Code is known by its function and its text, not by file and line, so that a map stands when files are moved or edited.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import time
from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import coverage
import pytest
from mutants import PACKAGE, Mutant

Code = tuple[str, str]
"""A function's qualified name and the text of one of its lines."""


class Touching:
    """The map, kept in a file.

    Parameters
    ----------
    root : Path
    path : Path
    """

    def __init__(self, root: Path, path: Path) -> None:
        self.root, self.path = root, path
        self.files: dict[str, dict[str, Any]] = json.loads(path.read_text()) if path.exists() else {}
        self.slowest = 0.0

    def collect(self, files: Sequence[Path]) -> None:
        """Run the files that are new or changed, each in a process of its own."""
        for path in files:
            name, digest = str(path.relative_to(self.root)), hashlib.sha256(path.read_bytes()).hexdigest()
            if self.files.get(name, {}).get("digest") == digest:
                continue
            began = time.time()
            told = _in_child(self.root, path)
            self.files[name] = {"digest": digest, "told": told}
            self.path.write_text(json.dumps(self.files))
            print(f"  {name}: {len(told['tests'])} tests, {time.time() - began:.0f} s", flush=True)
        wanted = {str(path.relative_to(self.root)) for path in files}
        self._by_code: dict[Code, set[str]] = defaultdict(set)
        self._seconds: dict[str, float] = {}
        for name in wanted:
            told = self.files[name]["told"]
            for test, (seconds, numbers) in told["tests"].items():
                self._seconds[test] = seconds
                for number in numbers:
                    self._by_code[tuple(told["code"][number])].add(test)

    def tests(self, mutant: Mutant, path: Path, budget: float) -> list[str]:
        """Tests that run the changed code, the fastest first, as many as fit into a time in seconds."""
        codes = _uses(self.root, mutant.module, mutant.name) if mutant.name else _codes(path, mutant.lines)
        found = set().union(*(self._by_code.get(code, ()) for code in codes))
        if not found and mutant.function:
            found = set().union(*(tests for (f, _), tests in self._by_code.items() if f == mutant.function))
        out, spent = [], 0.0
        for test in sorted(found, key=lambda each: (self._seconds[each], each)):
            spent += self._seconds[test]
            if out and spent > budget:
                break
            out.append(test)
        return out


def _in_child(root: Path, path: Path) -> dict[str, Any]:
    """Tests of one file that pass: the code they run, and for each its time and the numbers of its code."""
    read, write = os.pipe()
    if child := os.fork():
        os.close(write)
        with os.fdopen(read) as stream:
            told = stream.read()
        os.waitpid(child, 0)
        return json.loads(told) if told else {"code": [], "tests": {}}
    try:
        plugin = _Contexts(root)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        pytest.main([str(path), "-q", "-p", "no:cacheprovider", "-o", "addopts="], plugins=[plugin])
        with os.fdopen(write, "w") as stream:
            stream.write(json.dumps(plugin.told()))
    finally:
        os._exit(0)


class _Contexts:
    """Pytest plugin: a coverage context for each test, one for what all tests of a file share."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.coverage = coverage.Coverage(data_file=None, config_file=False, source=[str(root / PACKAGE)])
        self.seconds: dict[str, float] = defaultdict(float)
        self.passed: set[str] = set()

    def pytest_sessionstart(self) -> None:
        self.coverage.start()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self.coverage.switch_context("setup")

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_call(self, item: pytest.Item) -> None:
        self.coverage.switch_context(item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] += report.duration
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
        }


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
