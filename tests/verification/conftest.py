"""Figures of the verification, shown after the run and written for the manual; a plain linear solve for elements."""

import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pytest

from fecontact.fem.factor import condense
from fecontact.fem.stiffness import assemble_stiffness

FIGURES = pytest.StashKey[list]()
ENDS = pytest.StashKey[list]()


@dataclass(frozen=True)
class Figure:
    """One row of the verification manual.

    Attributes
    ----------
    test : str
        Where it was found.
    case, quantity : str
    target, obtained, error : float
        The error is relative, or the value itself where the target is zero.
    within : float or None
        Largest error allowed; None: shown beside the target, nothing claimed.
    dofs : int or None
    seconds : float
        Processor time since the test began.
    """

    test: str
    case: str
    quantity: str
    target: float
    obtained: float
    error: float
    within: float | None
    dofs: int | None
    seconds: float


def pytest_addoption(parser):
    parser.addoption("--figures", metavar="FILE", help="write the figures and the end of every test as JSON")


def pytest_configure(config):
    config.stash[FIGURES] = []
    config.stash[ENDS] = []
    config.pluginmanager.register(_Record(config), "record-of-figures")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    text = item.obj.__doc__ or item.name.removeprefix("test_").split("[")[0].replace("_", " ")
    item.user_properties.append(("text", text))
    return (yield)


class _Record:
    """Collects what tests say of themselves, whichever process runs them: their properties come with the reports."""

    def __init__(self, config):
        self.config = config

    def pytest_runtest_logreport(self, report):
        text = dict(report.user_properties).get("text")  # tests of other folders have none
        if text and (report.when == "call" or report.skipped or (report.when == "setup" and report.failed)):
            reason = report.longrepr[2] if report.skipped and isinstance(report.longrepr, tuple) else ""
            end = {"test": report.nodeid, "text": text, "outcome": report.outcome, "reason": reason}
            self.config.stash[ENDS].append(end)
        if report.when == "teardown":
            told = [value for key, value in report.user_properties if key == "figure"]
            self.config.stash[FIGURES] += [Figure(**json.loads(value)) for value in told]


def pytest_terminal_summary(terminalreporter, config):
    figures = config.stash[FIGURES]
    if figures:
        terminalreporter.section("figures")
        terminalreporter.write_line(f"{'case':<46} {'quantity':<30} {'target':>12} {'obtained':>12} {'error':>10}")
        for f in figures:
            line = f"{f.case:<46} {f.quantity:<30} {f.target:>12.6g} {f.obtained:>12.6g} {f.error:>10.2e}"
            terminalreporter.write_line(line)
    if path := config.getoption("figures"):
        record = {"figures": [asdict(f) for f in figures], "tests": config.stash[ENDS]}
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text(json.dumps(record, indent=1), encoding="utf-8")


@pytest.fixture
def row(request):
    """Record one figure and, with `within`, hold it to that; returns its error (relative, the value for target 0)."""
    start = time.process_time()

    def add(case, quantity, target, obtained, within=None, dofs=None):
        target, obtained = float(target), float(obtained)
        error = abs(obtained / target - 1) if target else abs(obtained)
        seconds = time.process_time() - start
        dofs = None if dofs is None else int(dofs)
        figure = Figure(request.node.nodeid, case, quantity, target, obtained, error, within, dofs, seconds)
        request.node.user_properties.append(("figure", json.dumps(asdict(figure))))  # plain, to go between processes
        if within is not None:
            assert error < within, f"{case}: {quantity} is {obtained:.8g}, not {target:.8g} within {within:g}"
        return error

    return add


@pytest.fixture
def linear_solve():
    """Displacements (n, 3) of a mesh with prescribed dofs (mapping of dof to value, or dofs) under nodal forces."""

    def solve(mesh, material, fixed, forces=None, values=None):
        n = len(mesh.cells)
        K = assemble_stiffness(mesh, np.full(n, material.lame), np.full(n, material.shear_modulus))
        fixed = np.asarray(fixed)
        u = np.zeros(K.shape[0])
        u[fixed] = 0.0 if values is None else values
        f = (np.zeros(K.shape[0]) if forces is None else forces) - (K @ u + K.T @ u - K.diagonal() * u)
        free = np.setdiff1d(np.arange(K.shape[0]), fixed)
        condensed = condense(K[free][:, free].tocsr(), np.array([0]))
        rest = f[free][:, None]
        u[free] = condensed.expand(condensed.reduce(rest) / condensed.stiffness, rest)[:, 0]
        return u.reshape(-1, 3)

    return solve
