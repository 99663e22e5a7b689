"""Processes of a job under MPI, and what is said to them.

Every process runs `fem.petsc.__main__` and connects to the program by a socket; they need petsc4py, the program does
not. Environment variables: FECONTACT_MPIEXEC is the command that starts processes (default ``mpiexec``), such as
``mpiexec --oversubscribe`` or ``srun``; FECONTACT_MPI_PYTHON their Python (by default this one if it has petsc4py, else
the system's). FECONTACT_MPI_HOST is the name by which other machines reach this one; files then go to TMPDIR, which
they must share.

Bodies whose stiffness is with the processes of a job, in place of a factor.

The outer active set is that of `fem.multigrid`; the equations of each set are solved by the processes.
"""

from __future__ import annotations

import importlib.util
import os
import secrets
import selectors
import shlex
import shutil
import socket
import subprocess
import sys
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import IO, Any, cast

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError, MissingPackageError
from fecontact.fem.amg import TIGHT
from fecontact.fem.model import Model
from fecontact.fem.multigrid import MultigridCompliance, OnRows, SparseRows
from fecontact.fem.petsc.parts import layout, rows_of, write_parts
from fecontact.fem.petsc.shared import Message, receive, send
from fecontact.solvers.problem import ContactProblem

#: What a process runs: the package is found where this one is, without other packages of its environment.
START = (
    "import sys, types; sys.path[:] = filter(None, sys.path); "
    "p = types.ModuleType('fecontact'); p.__path__ = [sys.argv.pop(1)]; "
    "sys.modules['fecontact'] = p; from fecontact.fem.petsc.__main__ import main; main()"
)
#: Seconds between looks at whether the processes still run.
LOOK = 0.5
#: How long processes may take to end.
SECONDS_TO_END = 10.0
SYSTEM_PYTHON = "/usr/bin/python3"
#: Debian's petsc4py is found by a link, which only PETSc's development package makes, or by PETSC_DIR.
DEBIAN_LINK, DEBIAN_FOLDERS = Path("/usr/lib/petsc"), Path("/usr/lib/petscdir")
HOW_TO_GET = (
    "Debian and Ubuntu: apt install python3-petsc4py openmpi-bin; or conda install -c conda-forge petsc4py openmpi. "
    "FECONTACT_MPI_PYTHON names a Python that has petsc4py."
)


class Job:
    """Models whose stiffness is shared by the processes of a job.

    Parameters
    ----------
    models : sequence of Model
    n_ranks : int
        Number of processes.

    Raises
    ------
    MissingPackageError
        Without mpiexec or petsc4py.
    FecontactError
        If the processes end.

    Attributes
    ----------
    layout : Layout
    close : callable
        Ends the processes, at the latest when nothing refers to the job any more.
    """

    def __init__(self, models: Sequence[Model], n_ranks: int) -> None:
        command = [*_launcher(), "-n", str(n_ranks), *interpreter(), "-c", START, _package()]
        self.n_ranks = n_ranks
        self._folder = tempfile.TemporaryDirectory(prefix="fecontact-")
        folder = Path(self._folder.name)
        self.layout = layout(models, n_ranks)
        write_parts(folder, models, self.layout)
        key = secrets.token_hex(16)
        (folder / "key").write_text(key)
        host = os.environ.get("FECONTACT_MPI_HOST", "localhost")
        self._said = (folder / "said").open("w+b")
        with socket.create_server(("" if "FECONTACT_MPI_HOST" in os.environ else host, 0)) as server:
            address = f"{host}:{server.getsockname()[1]}"
            self._processes = subprocess.Popen(
                [*command, str(folder), address], stdin=subprocess.DEVNULL, stdout=self._said, stderr=self._said,
                env=environment(),
            )  # fmt: skip
            self._ranks: list[socket.socket] = []
            self.close = weakref.finalize(self, _end, self._processes, self._ranks, self._said, self._folder)
            try:
                self._ranks += self._connected(server, key)
            except BaseException:
                self.close()
                raise

    def ask(
        self, what: str, common: Mapping[str, Any] | None = None, own: Sequence[Mapping[str, Any]] = ()
    ) -> list[Message]:
        """Answers of all processes to a request, with arrays for all of them and for each."""
        for k, rank in enumerate(self._ranks):
            try:
                send(rank, what=what, **(common or {}), **(own[k] if own else {}))
            except OSError:
                break  # what it said before it ended is read below
        answers: list[Message] = [{} for _ in self._ranks]
        with selectors.DefaultSelector() as waiting:
            for k, rank in enumerate(self._ranks):
                waiting.register(rank, selectors.EVENT_READ, k)
            while waiting.get_map():
                for key, _ in waiting.select():
                    answers[key.data] = self._answer(key.fileobj)
                    waiting.unregister(key.fileobj)
        return answers

    def split(self, x: Array) -> list[Array]:
        """Part of each process of a vector or of columns (..., N)."""
        return np.split(x, self.layout.ends[1:-1], axis=-1)

    @cached_property
    def softness(self) -> Array:
        """Inverse (N,) of the diagonal of the stiffness."""
        return np.concatenate([answer["softness"] for answer in self.ask("softnesses")])

    def usage(self) -> list[tuple[int, float, float]]:
        """Steps, processor seconds and peak memory in MB of each process."""
        return [(int(a["steps"]), float(a["seconds"]), float(a["peak"])) for a in self.ask("usage")]

    def _connected(self, server: socket.socket, key: str) -> list[socket.socket]:
        """Sockets of all processes."""
        server.settimeout(LOOK)
        found: dict[int, socket.socket] = {}
        while len(found) < self.n_ranks:
            try:
                other, _ = server.accept()
            except TimeoutError:
                if self._processes.poll() is not None:
                    raise self._ended() from None
                continue
            other.settimeout(None)
            hello = receive(other)
            if secrets.compare_digest(str(hello["key"]), key):
                found[int(hello["rank"])] = other
                if int(hello["size"]) != self.n_ranks:
                    raise FecontactError(
                        f"mpiexec started processes of {int(hello['size'])} at a time, not {self.n_ranks}: it belongs "
                        "to another MPI than PETSc's. FECONTACT_MPIEXEC names the right one."
                    )
        return [found[k] for k in range(self.n_ranks)]

    def _answer(self, rank: Any) -> Message:
        try:
            answer = receive(rank)
        except OSError:
            raise self._ended() from None
        if "error" in answer:
            raise FecontactError(f"A process of the engine 'petsc' failed: {answer['error']}")
        return answer

    def _ended(self) -> FecontactError:
        self._said.flush()
        self._said.seek(0)
        said = self._said.read().decode(errors="replace").strip()[-2000:]
        if "No module named" in said:
            return MissingPackageError(
                f"The engine 'petsc' needs NumPy and petsc4py: {said.splitlines()[-1]}. {HOW_TO_GET}"
            )
        return FecontactError(f"The processes of the engine 'petsc' ended; they said: {said or 'nothing'}")


def _end(
    processes: subprocess.Popen[bytes], ranks: list[socket.socket], said: IO[bytes], folder: tempfile.TemporaryDirectory
) -> None:
    """Leave the processes, which then end, and what they have read."""
    for rank in ranks:
        rank.close()
    try:
        processes.wait(timeout=SECONDS_TO_END if ranks else 0)
    except subprocess.TimeoutExpired:
        processes.terminate()
        processes.wait()
    said.close()
    folder.cleanup()


def _launcher() -> list[str]:
    """Command that starts processes."""
    command = shlex.split(os.environ.get("FECONTACT_MPIEXEC", "mpiexec"))
    if not command or shutil.which(command[0]) is None:
        raise MissingPackageError(f"The engine 'petsc' needs mpiexec, which is not on the PATH. {HOW_TO_GET}")
    return command


def interpreter() -> list[str]:
    """Command of the processes' Python, see the module."""
    given = os.environ.get("FECONTACT_MPI_PYTHON")
    if given:
        return shlex.split(given)
    if importlib.util.find_spec("petsc4py") is not None or not Path(SYSTEM_PYTHON).exists():
        return [sys.executable]
    return [SYSTEM_PYTHON]


def _package() -> str:
    return str(Path(__file__).resolve().parents[2])


def environment() -> dict[str, str]:
    """Environment of the processes: one thread each; another Python does not take this one's paths."""
    keep = interpreter() == [sys.executable]
    kept = {k: v for k, v in os.environ.items() if keep or not k.startswith("PYTHON")}
    if not keep and not DEBIAN_LINK.exists():
        for folder in sorted(DEBIAN_FOLDERS.glob("*/*-real")):
            kept.setdefault("PETSC_DIR", str(folder))
    return {**kept, "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


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

    def held(self, active: IntArray, problem: ContactProblem, Q: Array) -> OnRows:
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
