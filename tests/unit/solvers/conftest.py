"""Small contact problems with known structure."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import solver_cases

from fecontact.solvers import ContactProblem


@pytest.fixture(scope="session")
def half_space() -> Callable[..., ContactProblem]:
    return solver_cases.half_space


@pytest.fixture(scope="session")
def random_problem() -> Callable[..., ContactProblem]:
    return solver_cases.random_problem
