"""Measure the page of solvers: every solver on every hard case, errors, iterations and time: python docs/solvers.py.

The cases are those of the tests (tests/solver_cases.py); each has an answer that no solver has computed.
"""

from __future__ import annotations

import os
import platform
import sys
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import qpsolvers
from generated_pages import write
from tqdm import tqdm

from fecontact.common.errors import SolverError
from fecontact.solvers import ContactProblem, Solution, Status, attempt, available_solvers

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from solver_cases import CASES, HERTZ_LOAD, Case, eccentric, half_space, hertz  # noqa: E402

SIDE = 12
"""Side of the grid of the hard cases: 144 points."""

SIDES = (10, 20, 32, 50, 71)
"""Sides of the grids of the timed problems: 100 to 5041 points."""

BUDGET = 8.0
"""Seconds that a solver may be expected to take on the next larger problem; a longer run is left out."""

WRONG = 1e-6
"""Relative error of what is unique (deflection, gap, resultants) from which an answer is called wrong."""


COARSE = 1e-3
"""The same for the back-ends by themselves, whose own tolerances are coarse."""


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def timed(problem: ContactProblem, solver: str, start: Solution | None = None) -> tuple[Solution, float]:
    began = time.process_time()
    solution = attempt(problem, solver, start=start)
    return solution, time.process_time() - began


def entry(case: Case, solution: Solution) -> str:
    """What a solver gave: its residual, or the status in its own word; what should not happen stands out."""
    if solution.success:
        wrong = case.forces is None or case.error(solution) > WRONG
        return "**wrong**" if wrong else f"{solution.residuals.worst:.0e}"
    return solution.status.value


def hard_cases(names: Sequence[str], cases: Sequence[Case]) -> str:
    """Table of all cases and solvers, and the sums under it."""
    rows = []
    answers: dict[str, list[tuple[Case, Solution]]] = {name: [] for name in names}
    for case in tqdm(cases, desc="cases", disable=None, leave=False):
        cells = []
        for name in names:
            solution = attempt(case.problem, name)
            answers[name].append((case, solution))
            cells.append(entry(case, solution))
        rows.append([case.what, case.problem.n, *cells])
    return "\n\n".join([table(["case", "n", *names], rows), sums(answers)])


def sums(answers: dict[str, list[tuple[Case, Solution]]]) -> str:
    rows = []
    for name, given in answers.items():
        good = [(case, s) for case, s in given if s.success]
        errors = [case.error(s) for case, s in good if case.forces is not None]
        wrong = sum(error > WRONG for error in errors) + sum(case.forces is None for case, _ in good)
        should = [s for case, s in given if case.forces is not None]
        rows.append(
            [
                name,
                f"{sum(s.success for s in should)} of {len(should)}",
                sum(not s.success for s in should),
                wrong,
                f"{max(s.residuals.worst for _, s in good):.0e}",
                f"{max(errors):.0e}",
            ]
        )
    head = ["solver", "answered", "refused, with a status", "wrong", "largest residual", "largest error"]
    return table(head, rows)


def by_themselves(cases: Sequence[Case]) -> str:
    """The back-ends without scaling, sharpening and certificate, at their own settings."""
    given = [case for case in cases if case.forces is not None]
    rows = []
    for name in sorted(qpsolvers.available_solvers):
        right, wrong, none, largest = 0, 0, 0, 0.0
        for case in given:
            forces = _raw(case.problem, name)
            if forces is None:
                none += 1
                continue
            p = case.problem
            # the gap without the multiplier, which back-ends do not all return: deflection and resultants only
            found = Solution(p, forces, np.zeros(p.m), Status.SOLVED, "", 0, name)
            error = replace(case, pinned=False).error(found)
            right += error <= COARSE
            largest = max(largest, error)
            wrong += error > COARSE
        rows.append([name, right, wrong, none, f"{largest:.0e}"])
    return table(["back-end", f"right (of {len(given)})", "wrong", "nothing", "largest error"], rows)


def _raw(problem: ContactProblem, name: str) -> np.ndarray | None:
    rows = (problem.B, problem.F) if problem.m else (None, None)
    # copies, since some back-ends do not take arrays that are read-only
    data = [None if each is None else each.copy() for each in (problem.S, problem.g, *rows)]
    given = qpsolvers.Problem(data[0], data[1], A=data[2], b=data[3], lb=np.zeros(problem.n))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            answer = qpsolvers.solve_problem(given, solver=name)
    except (qpsolvers.exceptions.QPError, ValueError, ArithmeticError):
        return None
    found = answer.found and answer.x is not None and np.isfinite(answer.x).all()
    return np.asarray(answer.x) if found else None


def against_size(names: Sequence[str], sides: Sequence[int], budget: float) -> str:
    """Iterations and CPU seconds against the number of points, on a smooth problem and an eccentric load."""
    cells: dict[str, list[str]] = {name: [] for name in names}
    makes = (hertz, eccentric)
    expected = {(name, make): 0.0 for name in names for make in makes}
    last = dict.fromkeys(expected, np.inf)
    for side in tqdm(sides, desc="sizes", disable=None, leave=False):
        for make in makes:
            case = make(side)
            for name in names:
                if expected[name, make] > budget:
                    cells[name].append("-")
                    continue
                solution, seconds = timed(case.problem, name)
                assert not solution.success or case.error(solution) <= WRONG
                nit = f"{solution.nit} / " if solution.nit else ""
                cells[name].append(f"{nit}{seconds:.3f}" if solution.success else solution.status.value)
                # as it grew before, but at least by a factor of four
                expected[name, make] = seconds * max(seconds / last[name, make], 4.0)
                last[name, make] = seconds
    head = ["solver"]
    for side in sides:
        head += [f"{side**2} smooth", f"{side**2} eccentric"]
    return table(head, [[name, *cells[name]] for name in names])


def series(side: int) -> dict[str, list[ContactProblem]]:
    """Problems that follow each other: a load that grows by 5 % a step, and one that wanders."""
    p = half_space(side, 3)

    def loaded(load: float, at: float) -> ContactProblem:
        return ContactProblem(p.S, p.g, p.B, HERTZ_LOAD * load * np.array([1.0, at, 0.0]))

    return {
        "load + 5 %": [loaded(0.5 * 1.05**k, 0.0) for k in range(12)],
        "load that wanders by 0.02 a": [loaded(0.6, 0.02 * k) for k in range(12)],
    }


def warm_starts(names: Sequence[str], side: int) -> str:
    """Twelve solves in a row, each from nothing or from the answer before."""
    rows = []
    for what, problems in series(side).items():
        for name in names:
            found = []
            for warm in (False, True):
                last: Solution | None = None
                nit, seconds = 0, 0.0
                for problem in problems:
                    solution, took = timed(problem, name, last if warm else None)
                    if not solution.success:
                        raise SolverError(f"{name} gave no answer: {solution.message}")
                    last, nit, seconds = solution, nit + solution.nit, seconds + took
                found.append((nit, seconds))
            (cold, slow), (warm_nit, fast) = found
            rows.append([what, name, cold or "-", warm_nit or "-", f"{slow:.3f}", f"{fast:.3f}", f"{slow / fast:.1f}"])
    head = ["series", "solver", "iterations cold", "warm", "CPU s cold", "warm", "gain"]
    return table(head, rows)


def page(side: int = SIDE, sides: Sequence[int] = SIDES, warm_side: int = 25, budget: float = BUDGET) -> str:
    own = ("active-set", "projected-cg", "nnls", "wolfe")
    names = ("auto", *own, *(name for name in available_solvers() if name not in own))
    cases = [make(side) for make in CASES]
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    return f"""# Solvers: hard cases, iterations and time

Generated by `python docs/solvers.py` on {machine}; no figure is
typed. The cases are those of the tests (`tests/solver_cases.py`). Each is made from a given solution (forces, gaps,
rigid motion), so that errors are differences from numbers that no solver has computed. Where forces are not unique
(a singular compliance), the deflection, the gap and the resultants are, and these are compared.

## Hard cases

A number is the largest residual of a certified solution (penetration, tension, complementarity or equilibrium,
relative, recomputed from the problem); a word is the status of a solver that did not give one. Where there is no
solution, `infeasible` and `unbounded` are right; `auto` finds them all. A certified solution that differs from the
given one by more than {WRONG:.0e} would be listed as **wrong**.

{hard_cases(names, cases)}

`wolfe` is the short form of 1959 and needs a positive definite compliance; `active-set` gives up on singular ones and
`projected-cg` is slow on them, which is why `auto` continues with `nnls`.

## The back-ends by themselves

The same problems given to the back-ends of `qpsolvers` as they are, at their own settings, without scaling,
polishing and certificate: "wrong" is an answer that the back-end calls solved with an error of more than
{COARSE:.0e} in deflection or resultants. This is why every problem is scaled first and every solution certified.

{by_themselves(cases)}

## Against the number of points

Iterations (where reported) / CPU seconds, certificate included; "-": left out, expected to take longer than
{budget:g} s.

{against_size(names[1:], sides, budget)}

## Warm starts

Twelve solves in a row with {warm_side**2} points, `start=` the solution before. Solutions do not depend on it.

{warm_starts(("active-set", "projected-cg", "nnls", "daqp"), warm_side)}
"""


def main() -> None:
    print(f"wrote {write('solvers', page())}")


if __name__ == "__main__":
    main()
