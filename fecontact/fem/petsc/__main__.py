"""One process of a job: assembles its rows of the stiffness and solves with the others, as the program asks.

Needs NumPy, petsc4py and the modules beside it that need no more; `fem.petsc.job` starts it. The preconditioner is
PETSc's smoothed aggregation (GAMG) with the rigid modes, no entries dropped (threshold 0), and Chebyshev's iteration
with the diagonal on all levels: aggregates of one node leave zeros on the diagonals of coarse levels, by which
relaxation (SOR) divides. PETSc's options, in PETSC_OPTIONS, have the prefix ``-fecontact_``.
"""

from __future__ import annotations

import resource
import socket
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from petsc4py import PETSc

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.fem.constrained_cg import Held, constrained_cg
from fecontact.fem.petsc.shared import ElasticCells, Message, block_rows, receive, send

WORLD = PETSc.COMM_WORLD
#: Options of the preconditioner where PETSC_OPTIONS has none.
OPTIONS = {
    "pc_type": "gamg",
    "pc_gamg_type": "agg",
    "pc_gamg_threshold": 0.0,
    "pc_gamg_agg_nsmooths": 1,
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_pc_type": "jacobi",
    "mg_levels_ksp_max_it": 2,
}
PREFIX = "fecontact_"
#: Largest number of steps of one solve, of passes on its true residual, and solutions kept to start from.
MAX_ITERATIONS, PASSES, KEPT = 2000, 2, 2


class Sums:
    """Sums of arrays over the processes."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[Any, Any, Any]] = {}

    def __call__(self, x: Array) -> Array:
        """Sum of x (n,), the same on all processes."""
        if WORLD.size == 1 or len(x) == 0:
            return np.asarray(x)
        if len(x) not in self._known:
            v = PETSc.Vec().createMPI(len(x))
            self._known[len(x)] = (v, *PETSc.Scatter.toAll(v))
        v, scatter, whole = self._known[len(x)]
        v.set(0.0)
        whole.setArray(x)
        scatter.scatter(whole, v, addv=PETSc.InsertMode.ADD_VALUES, mode=PETSc.ScatterMode.REVERSE)
        scatter.scatter(v, whole)
        return np.asarray(whole.getArray().copy())


class Rows:
    """Rows G of an active set, see `fem.constrained_cg`: every process has its columns, and all forces.

    Attributes
    ----------
    G : PETSc.Mat
        Columns (a, n_own) of this process.
    gram : PETSc.Mat
        G W G^T (a, a), whole.
    W : (n_own,) array
    """

    def __init__(self, G: Any, gram: Any, W: Array, total: Callable[[Array], Array]) -> None:
        self.G, self.W, self.total = G, W, total
        self._solver = PETSc.KSP().create(PETSc.COMM_SELF)
        self._solver.setOperators(gram)
        self._solver.setType("preonly")
        self._solver.getPC().setType("cholesky")
        self._u, self._b = G.createVecs()
        self._x = self._b.duplicate()

    def _solved(self, d: Array) -> Array:
        self._b.setArray(d)
        self._solver.solve(self._b, self._x)
        return np.asarray(self._x.getArray().copy())

    def gap(self, u: Array) -> Array:
        """G u."""
        self._u.setArray(u)
        self.G.mult(self._u, self._x)
        return self.total(self._x.getArray().copy())

    def nodal(self, forces: Array) -> Array:
        """G^T l, this process' part."""
        self._b.setArray(forces)
        self.G.multTranspose(self._b, self._u)
        return np.asarray(self._u.getArray().copy())

    def lift(self, d: Array) -> Array:
        """L d, this process' part."""
        return self.W * self.nodal(self._solved(d))

    def project(self, v: Array) -> Array:
        """P v."""
        return v - self.lift(self.gap(v))

    def forces(self, r: Array) -> Array:
        """L^T r."""
        return self._solved(self.gap(self.W * r))


class Process:
    """State of one process.

    Parameters
    ----------
    folder : Path
        What `fem.petsc.parts` wrote.
    """

    def __init__(self, folder: Path) -> None:
        ends = np.load(folder / "ends.npy")
        self.first, self.last = ends[WORLD.rank], ends[WORLD.rank + 1]
        own, self.size = slice(self.first, self.last), int(ends[-1])
        self.total = Sums()
        self.steps = 0
        self.model_of = np.load(folder / "model_of.npy", mmap_mode="r")[own].copy()
        self.modes = np.load(folder / "modes.npy", mmap_mode="r")[own].copy()
        self.K = self._stiffness(folder, np.load(folder / "held.npy", mmap_mode="r")[own])
        #: Vectors to and from all products; new ones would be kept until all processes destroy them together.
        self.pair = (self.K.createVecRight(), self.K.createVecLeft())
        self.softness = 1.0 / self.K.getDiagonal().getArray()
        self.u = np.zeros(self.last - self.first)
        self.kept: list[Array] = []
        self.C: Any = None
        self.held: Held | None = None
        #: Multigrid of the stiffness of free bodies, or of bodies held along the active rows.
        self.solver: Any = None
        self.free = True

    def _stiffness(self, folder: Path, held: Mask) -> Any:
        """Distributed stiffness; held coordinates, which have no loads, keep a diagonal."""
        node_ends = np.load(folder / "node_ends.npy")
        first, last = node_ends[WORLD.rank : WORLD.rank + 2]
        points = np.load(folder / "points.npy", mmap_mode="r")
        kinds = [_cells(folder, k) for k in range(int(np.load(folder / "n_kinds.npy")))]
        indptr, indices, blocks = block_rows(points, kinds, first, last)
        size = (3 * (last - first), 3 * len(points))
        csr = (indptr.astype(PETSc.IntType), indices.astype(PETSc.IntType), blocks)
        K = PETSc.Mat().createBAIJ((size, size), 3, csr=csr, comm=WORLD).convert("aij")
        if (folder / "coordinates.npz").exists():
            T = _rows(np.load(folder / "coordinates.npz"), "T", slice(3 * first, 3 * last))
            K = K.ptap(self.distributed(T, len(points) * 3, size[0], block=3))
        K.zeroRowsColumns((self.first + np.flatnonzero(held)).astype(PETSc.IntType), diag=_mean(K.getDiagonal()))
        K.setOption(PETSc.Mat.Option.SPD, True)
        return K

    def distributed(self, csr: tuple[IntArray, IntArray, Array], n_rows: int, own_rows: int, block: int = 1) -> Any:
        """Matrix (n_rows, size) of which this process has own_rows rows."""
        size = ((own_rows, n_rows), (self.last - self.first, self.size))
        return PETSc.Mat().createAIJ(size, bsize=block, csr=csr, comm=WORLD)

    def _solver(self, K: Any, modes: Array) -> Any:
        """Conjugate gradients with multigrid of K."""
        K.setNearNullSpace(PETSc.NullSpace().create(vectors=[self.vector(mode) for mode in modes.T]))
        ksp = PETSc.KSP().create(WORLD)
        ksp.setOptionsPrefix(PREFIX)
        ksp.setOperators(K)
        ksp.setType("cg")
        ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
        ksp.setInitialGuessNonzero(True)
        ksp.setFromOptions()
        ksp.setUp()
        return ksp

    def vector(self, values: Array) -> Any:
        """New distributed vector of values (n_own,)."""
        v = PETSc.Vec().createMPI((len(values), self.size), comm=WORLD)
        v.setArray(values)
        return v

    def _product(self, A: Callable[[Any, Any], None], x: Array) -> Array:
        self.pair[0].setArray(x)
        A(*self.pair)
        return np.asarray(self.pair[1].getArray().copy())

    def _cycle(self, ksp: Any, r: Array) -> Array:
        z = self._product(ksp.getPC().apply, r)
        if not np.isfinite(z).all():
            raise ArithmeticError("the preconditioner returned NaN: its options divide by a zero on a coarse diagonal")
        return z

    # what the program asks for

    def softnesses(self, message: Message) -> dict[str, Any]:
        """The inverse of the diagonal of the stiffness."""
        return {"softness": self.softness}

    def solve(self, message: Message) -> dict[str, Any]:
        """K^-1 b for loads on one model, from the known displacement whose residual is smallest."""
        b, rtol, own = message["b"], float(message["rtol"]), self.model_of == int(message["model"])
        size = self._norm(b)
        best, x = size, np.zeros_like(b)
        for known in self.kept:
            mine = np.where(own, known, 0.0)
            if (left := self._norm(b - self._product(self.K.mult, mine))) < best:
                best, x = left, mine
        for _ in range(PASSES):
            if size == 0.0 or best <= rtol * size:
                break
            solver = self._free_solver()
            solver.setTolerances(rtol=rtol, atol=0.0, max_it=MAX_ITERATIONS)
            self.pair[0].setArray(b)
            self.pair[1].setArray(x)
            solver.solve(*self.pair)
            x = self.pair[1].getArray().copy()
            self.steps += solver.getIterationNumber()
            if solver.getConvergedReason() < 0:
                raise ArithmeticError(f"conjugate gradients ended with PETSc's reason {solver.getConvergedReason()}")
            best = self._norm(b - self._product(self.K.mult, x))
        self._keep(x)
        return {"x": x}

    def rows(self, message: Message) -> dict[str, Any]:
        """Take this process' columns of all rows."""
        self.C = _local(message, "C", self.last - self.first)
        self.u = np.zeros(self.last - self.first)
        return {}

    def hold(self, message: Message) -> dict[str, Any]:
        """Make the equations of an active set, with multigrid of the restricted stiffness in place of the free one."""
        gram = _local(message, "gram", len(message["gram_indptr"]) - 1)
        rows = Rows(_local(message, "G", self.last - self.first), gram, self.softness, self.total)
        self._destroy()  # two hierarchies at once take twice the memory
        solver = self._restricted(message) if "S_data" in message else self._free_solver()
        self.held = Held(
            lambda u: self._product(self.K.mult, u), lambda r: self._cycle(solver, r), rows,
            message["d"], message["B"], message["F"], message["Q"], self.total,
        )  # fmt: skip
        return {}

    def _restricted(self, message: Message) -> Any:
        """Multigrid of (I - S)^T K (I - S) and a stiffness of what S removes, see `fem.amg.Cycle.restricted`."""
        n = self.last - self.first
        S, stiffness = (self.distributed(_rows(message, name), self.size, n, block=3) for name in "SA")
        KS = self.K.matMult(S)
        A, SK, SKS = self.K.duplicate(copy=True), KS.transpose(PETSc.Mat()), S.transposeMatMult(KS)
        for factor, change in ((-1.0, KS), (-1.0, SK), (1.0, SKS), (1.0, stiffness)):
            A.axpy(factor, change)
        modes = np.stack([mode - self._product(S.mult, mode) for mode in self.modes.T], axis=1)
        for used in (S, stiffness, KS, SK, SKS):
            used.destroy()
        self.solver = self._solver(A, modes)
        self.free = False
        return self.solver

    def _free_solver(self) -> Any:
        """Multigrid of the stiffness, made when it is needed."""
        if self.solver is None or not self.free:
            self._destroy()
            self.solver, self.free = self._solver(self.K, self.modes), True
        return self.solver

    def _destroy(self) -> None:
        """Destroy the multigrid that there is, and the restricted stiffness with it."""
        self.held = None
        if self.solver is not None:
            A, _ = self.solver.getOperators()
            self.solver.destroy()
            if not self.free:
                A.destroy()
        self.solver = None

    def on_rows(self, message: Message) -> dict[str, Any]:
        """Solve the equations of the active set."""
        assert self.held is not None
        self.u, forces, q = constrained_cg(self.held, self.u, message["q"], float(message["rtol"]), self._count)
        u, deflection = self.C.createVecs()
        u.setArray(self.u)
        self.C.mult(u, deflection)
        every = self.total(deflection.getArray())
        return {"forces": forces, "q": q, "deflection": every} if WORLD.rank == 0 else {}

    def keep(self, message: Message) -> dict[str, Any]:
        """Start later solutions from the displacements."""
        self._keep(self.u)
        return {}

    def usage(self, message: Message) -> dict[str, Any]:
        """Steps, processor seconds and peak memory in MB."""
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        return {"steps": self.steps, "seconds": time.process_time(), "peak": peak}

    def _norm(self, x: Array) -> float:
        return float(np.sqrt(self.total(np.array([x @ x]))[0]))

    def _keep(self, x: Array) -> None:
        self.kept = [x.copy(), *self.kept][:KEPT]

    def _count(self) -> None:
        self.steps += 1


def _mean(diagonal: Any) -> float:
    return float(diagonal.sum() / diagonal.getSize())


def _cells(folder: Path, k: int) -> ElasticCells:
    kind = np.load(folder / f"cells{k}.npz")
    rules = [(kind[f"dN{r}"], kind[f"W{r}"]) for r in range(2) if f"W{r}" in kind]
    return ElasticCells(np.load(folder / f"nodes{k}.npy", mmap_mode="r"), kind["lame"], kind["shear"], rules)


def _rows(arrays: Any, name: str, own: slice = slice(None)) -> tuple[IntArray, IntArray, Array]:
    """Some rows of a matrix in a message or file."""
    indptr = arrays[f"{name}_indptr"][own.start : None if own.stop is None else own.stop + 1]
    part = slice(indptr[0], indptr[-1])
    integers = ((indptr - indptr[0]).astype(PETSc.IntType), arrays[f"{name}_indices"][part].astype(PETSc.IntType))
    return (*integers, arrays[f"{name}_data"][part])


def _local(message: Message, name: str, n_columns: int) -> Any:
    """Matrix of this process alone."""
    csr = _rows(message, name)
    return PETSc.Mat().createAIJ((len(csr[0]) - 1, n_columns), csr=csr, comm=PETSc.COMM_SELF)


def main() -> None:
    """Connect to the program and do what it asks for, until it leaves."""
    folder = Path(sys.argv[1])
    host, port = sys.argv[2].rsplit(":", 1)
    options = PETSc.Options(PREFIX)
    for name, value in OPTIONS.items():
        if not options.hasName(name):
            options[name] = value
    with socket.create_connection((host, int(port))) as program:
        send(program, key=(folder / "key").read_text(), rank=WORLD.rank, size=WORLD.size)
        process: Process | None = None
        while True:
            try:
                message = receive(program)
            except ConnectionError:
                return
            try:
                process = process or Process(folder)
                answer = getattr(process, str(message["what"]))(message)
            except ArithmeticError as error:
                send(program, error=str(error))
                return
            except Exception:
                send(program, error=traceback.format_exc())
                return
            send(program, **answer)


if __name__ == "__main__":
    main()
