"""Small contact problems with known structure."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import solver_cases

from fecontact.solvers import ComplementarityProblem


@pytest.fixture(scope="session")
def half_space() -> Callable[..., ComplementarityProblem]:
    return solver_cases.half_space


@pytest.fixture(scope="session")
def random_problem() -> Callable[..., ComplementarityProblem]:
    return solver_cases.random_problem
