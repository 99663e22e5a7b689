"""Rows of figures, shown after the run, and a plain linear solve for element tests."""

import numpy as np
import pytest

from fecontact.fem.factor import condense
from fecontact.fem.stiffness import assemble_stiffness

ROWS = pytest.StashKey[list]()


def pytest_configure(config):
    config.stash[ROWS] = []


def pytest_terminal_summary(terminalreporter, config):
    if config.stash[ROWS]:
        terminalreporter.section("figures")
        terminalreporter.write_line(f"{'case':<46} {'quantity':<30} {'target':>12} {'obtained':>12} {'error':>10}")
        for line in config.stash[ROWS]:
            terminalreporter.write_line(line)


@pytest.fixture
def row(request):
    """Show one figure; returns its relative error (its value where the target is zero)."""

    def add(case, quantity, target, obtained):
        error = abs(obtained / target - 1) if target else abs(obtained)
        request.config.stash[ROWS].append(f"{case:<46} {quantity:<30} {target:>12.6g} {obtained:>12.6g} {error:>10.2e}")
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
