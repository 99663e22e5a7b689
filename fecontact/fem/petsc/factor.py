"""Bodies whose stiffness is with the processes of a job, in place of a factor.

The outer active set is that of `fem.multigrid`; the equations of each set are solved by the processes.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import cast

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.held_rows import SparseRows
from fecontact.fem.multigrid import MultigridCompliance, OnRows
from fecontact.fem.petsc.job import Job
from fecontact.fem.petsc.parts import rows_of
from fecontact.solvers.problem import ComplementarityProblem

#: Relative residual of a product, as `fem.amg.TIGHT`.
TIGHT = 1e-12


class SharedFactor:
    """Solutions for one model of a job.

    Parameters
    ----------
    job : Job
    models : sequence of int
        Its numbers in the job: one for each body that uses it.
    """

    def __init__(self, job: Job, models: Sequence[int]) -> None:
        self.job, self.models = job, tuple(models)

    @property
    def memory(self) -> int:
        """Bytes in this process: none."""
        return 0

    @property
    def steps(self) -> int:
        """Steps of conjugate gradients of the job so far."""
        return self.job.usage()[0][0]

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        return np.stack([self.solve_one(row) for row in b])

    def solve_one(self, b: Array, rtol: float = TIGHT) -> Array:
        """Solution (n,) of one right-hand side."""
        job, places = self.job, self.job.layout.places[self.models[0]]
        whole = np.zeros(job.layout.size)
        whole[places] = b
        own = [{"b": part} for part in job.split(whole)]
        answers = job.ask("solve", {"rtol": rtol, "model": self.models[0]}, own)
        return np.concatenate([answer["x"] for answer in answers])[places]


class SharedSystem:
    """Displacements of all bodies, with the processes of a job; see `fem.multigrid.System`."""

    def __init__(self, n: int, shares: Sequence[tuple[IntArray, MultigridCompliance]]) -> None:
        factors = [cast(SharedFactor, compliance.factor) for _, compliance in shares]
        self.job = job = factors[0].job
        unused = {id(factor): list(factor.models) for factor in factors}
        self.C = sp.csr_matrix((n, job.layout.size))
        for factor, (index, compliance) in zip(factors, shares, strict=True):
            places = job.layout.places[unused[id(factor)].pop(0)]
            own = compliance.C.tocoo()
            self.C += sp.csr_matrix((own.data, (index[own.row], places[own.col])), shape=self.C.shape)
        job.ask("rows", None, self._columns("C", self.C))

    def held(self, active: IntArray, problem: ComplementarityProblem, Q: Array) -> OnRows:
        """Conjugate gradients on active rows."""
        rows = SparseRows(self.C[active], self.job.softness)
        parts = self._columns("G", rows.G)
        if rows.invertible:
            S, stiffness = rows.removed()
            for k, part in enumerate(parts):
                own = slice(*self.job.layout.ends[k : k + 2])
                part |= rows_of("S", S[own]) | rows_of("A", sp.csr_matrix(stiffness[own]))
        given = {"d": problem.g[active], "B": problem.B[:, active], "F": problem.F, "Q": Q}
        self.job.ask("hold", given | rows_of("gram", sp.csr_matrix(rows.gram)), parts)

        def on_rows(q: Array, rtol: float) -> tuple[Array, Array, Array]:
            found = self.job.ask("on_rows", {"q": q, "rtol": rtol})[0]
            return found["forces"], found["q"], found["deflection"]

        return on_rows

    def keep(self) -> None:
        """Start later products from the displacements."""
        self.job.ask("keep")

    def _columns(self, name: str, A: sp.csr_matrix) -> list[dict[str, np.ndarray]]:
        """Columns of each process."""
        columns, ends = A.tocsc(), self.job.layout.ends
        return [rows_of(name, columns[:, a:b]) for a, b in pairwise(ends)]
