"""Algebraic multigrid in place of a factorisation: memory and work proportional to the degrees of freedom.

Smoothed aggregation with the six rigid modes as near-nullspace (Vanek, Mandel & Brezina, Computing 56 (1996) 179)
preconditions conjugate gradients. Contact is not solved by products with the compliance, each of which needs a solve,
but for displacements and forces together: an outer active set, and for each set A

    [ K    C_A^T  0     ] [ u ]   [  0    ]
    [ C_A  0      B_A^T ] [-l ] = [ -g_A  ]       K u = C_A^T l,   C_A u + g_A + B_A^T q = 0,   B_A l = F
    [ 0    B_A    0     ] [ q ]   [ -F    ]

by MINRES with a block-diagonal preconditioner (Benzi, Golub & Liesen, Acta Numerica 14 (2005) 1, section 10): one
V-cycle for K, and for the forces the compliance of a half-space between the same points (Boussinesq's 1 / r), which is
spectrally equivalent to the body's own. Every set starts from the last solution.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import FecontactError, MissingPackageError
from fecontact.fem.condensation import Compliance
from fecontact.solvers.outcome import Outcome
from fecontact.solvers.problem import ComplementarityProblem, Status
from fecontact.solvers.registry import attempt

#: Relative residual of a solve with K: a hundredth of the certificate's tolerance.
TIGHT = 1e-13
#: Relative residual of the equations of one active set, while the set changes and for the last one.
LOOSE, LAST = 1e-3, 1e-12
#: Relative residual of the product that scales the half-space.
PROBE = 1e-2
#: Passes of MINRES on the true residual, and the smallest tolerance of one pass.
PASSES, FLOOR = 8, 1e-8
#: Largest number of outer steps, and of MINRES or CG steps of one solve.
MOST_SETS, MOST_STEPS = 60, 2000
#: Boussinesq's displacement under the middle of a uniformly loaded square: 4 ln(1 + sqrt(2)) over its side.
SELF = 4 * np.log(1 + np.sqrt(2))


class AmgFactor:
    """Conjugate gradients with smoothed aggregation, in place of a factor.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Upper triangle of a symmetric positive definite matrix.
    modes : (n, 6) array
        Rigid modes.

    Raises
    ------
    MissingPackageError
        Without pyamg.
    """

    def __init__(self, K: sp.csr_matrix, modes: Array) -> None:
        if importlib.util.find_spec("pyamg") is None:
            raise MissingPackageError("The back-end 'amg' needs the package pyamg: pip install 'fecontact[amg]'.")
        import pyamg

        self.K = (K + sp.triu(K, 1).T).tocsr()
        scaled = modes / np.linalg.norm(modes, axis=0)
        smoother = ("gauss_seidel", {"sweep": "symmetric"})
        self._levels = pyamg.smoothed_aggregation_solver(
            self.K, B=scaled, strength=("symmetric", {"theta": 0.0}), presmoother=smoother, postsmoother=smoother,
            max_coarse=500, improve_candidates=None,
        )  # fmt: skip
        self.cycle = self._levels.aspreconditioner()
        #: Steps of conjugate gradients and MINRES so far.
        self.steps = 0
        self._last = np.zeros(K.shape[0])

    @property
    def memory(self) -> int:
        """Bytes of the stiffness and of its coarser levels."""
        return sum(_bytes(level.A) + _bytes(getattr(level, "P", None)) for level in self._levels.levels)

    def solve(self, b: Array) -> Array:
        """Solutions (k, n) for right-hand sides in the rows of b (k, n)."""
        return np.stack([self.solve_one(row) for row in b])

    def solve_one(self, b: Array, rtol: float = TIGHT) -> Array:
        """Solution (n,) of one right-hand side, started from the last one if that has a smaller residual than zero."""
        size, x = np.linalg.norm(b), self._last
        # a second pass on the true residual removes the error of the recurrence
        for _ in range(2):
            rest = b - self.K @ x
            if np.linalg.norm(rest) > size:
                x, rest = np.zeros_like(b), b
            left = np.linalg.norm(rest)
            if left <= rtol * size:
                break
            step, info = spla.cg(
                self.K, rest, rtol=rtol * size / left, maxiter=MOST_STEPS, M=self.cycle, callback=self.count
            )
            if info > 0:
                raise FecontactError(
                    f"Conjugate gradients with multigrid did not converge in {MOST_STEPS} steps; "
                    "badly shaped elements slow it down: use a direct back-end."
                )
            x = x + step
        self._last = x
        return x

    def remember(self, x: Array) -> None:
        """Start the next solution from x (n,)."""
        self._last = x

    def count(self, _: Array) -> None:
        """Count a step."""
        self.steps += 1


def _bytes(A: Any) -> int:
    """Bytes of a sparse matrix."""
    return 0 if A is None else int(A.data.nbytes + A.indices.nbytes + A.indptr.nbytes)


class MultigridCompliance(Compliance):
    """Compliance of rows by multigrid, with its own contact solver.

    Parameters
    ----------
    factor : AmgFactor
    C : (n_rows, n) csr_matrix
    positions : (n, 3) array
        Positions of the degrees of freedom.
    """

    solver = "multigrid"

    def __init__(self, factor: AmgFactor, C: sp.csr_matrix, positions: Array) -> None:
        super().__init__(factor, C)
        weights = abs(C)
        self.multigrid = factor
        total = np.asarray(weights.sum(axis=1)).reshape(-1, 1)
        self.points = np.asarray(weights @ positions) / np.where(total > 0, total, 1.0)

    def solve_contact(self, problem: ComplementarityProblem, tolerance: float) -> Outcome:
        """Forces and motions of the problem."""
        return solve_contact(self.multigrid, self.C, self.points, problem)


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of active sets.

    Attributes
    ----------
    factor : AmgFactor
    C : (n_rows, n) csr_matrix
    stand_in : (n_rows, n_rows) array
        Compliance of a half-space between the rows' points.
    problem : ComplementarityProblem
    """

    factor: AmgFactor
    C: sp.csr_matrix
    stand_in: Array
    problem: ComplementarityProblem

    def solve_on(self, A: IntArray, u: Array, forces: Array, q: Array, rtol: float) -> tuple[Array, Array, Array]:
        """Displacements (n,), forces (n_rows,) and motions (m,) of an active set, from those of another."""
        n, a, m = len(u), len(A), len(q)
        C, B = self.C[A], self.problem.B[:, A]
        K = self.factor.K
        inner = scipy.linalg.cho_factor(self.stand_in[np.ix_(A, A)], lower=True)
        # rows of B scaled to be of order one on the forces' block
        gram = np.atleast_2d(B @ scipy.linalg.cho_solve(inner, B.T)) if m else np.zeros((0, 0))
        gram_inverse = np.linalg.pinv(gram, rcond=1e-12, hermitian=True) if m else gram

        def product(z: Array) -> Array:
            v, lam, p = z[:n], z[n : n + a], z[n + a :]
            return np.concatenate([K @ v + C.T @ lam, C @ v + B.T @ p, B @ lam])

        def precondition(z: Array) -> Array:
            # preconditioner: for the forces the inverse of the half-space compliance, for the motions that of its Schur
            # complement
            out = [self.factor.cycle @ z[:n], scipy.linalg.cho_solve(inner, z[n : n + a]), gram_inverse @ z[n + a :]]
            return np.concatenate(out)

        size = n + a + m
        target = np.concatenate([np.zeros(n), -self.problem.g[A], -self.problem.F])
        start = np.concatenate([u, -forces[A], q])
        A_op = spla.LinearOperator((size, size), matvec=product, dtype=float)
        M_op = spla.LinearOperator((size, size), matvec=precondition, dtype=float)
        for _ in range(PASSES):
            # MINRES stops relative to its growing solution; the true residual decides
            rest = target - product(start)
            v, lam = start[:n], start[n : n + a]
            error = max(
                _relative(rest[:n], C.T @ lam),
                _relative(rest[n : n + a], C @ v),
                _relative(rest[n + a :], np.abs(B) @ np.abs(lam)),
            )
            if error <= rtol:
                break
            aim = float(np.clip(0.1 * rtol / error, FLOOR, 1e-2))
            start = start + spla.minres(A_op, rest, rtol=aim, maxiter=MOST_STEPS, M=M_op, callback=self.factor.count)[0]
        full = np.zeros(len(forces))
        full[A] = -start[n : n + a]
        return start[:n], full, start[n + a :]


def _relative(rest: Array, whole: Array) -> float:
    """Largest entry of the residual over that of the right-hand side; infinite if the latter is zero."""
    left, size = np.abs(rest).max(initial=0.0), np.abs(whole).max(initial=0.0)
    return 0.0 if left == 0 else float(left / size) if size > 0 else np.inf


def half_space_compliance(points: Array) -> Array:
    """1 / r (n, n) between points (n, 3); on the diagonal the mean over a square as wide as the nearest distance.

    K. L. Johnson, Contact Mechanics, 1985, eq. 3.25, without its factor (1 - nu^2) / (pi E).
    """
    distance = cdist(points, points)
    width = cKDTree(points).query(points, k=2)[0][:, 1] if len(points) > 1 else np.ones(1)
    np.fill_diagonal(distance, np.maximum(width, 1e-12 * distance.max()) / SELF)
    return 1.0 / distance


def solve_contact(factor: AmgFactor, C: sp.csr_matrix, points: Array, problem: ComplementarityProblem) -> Outcome:
    """Forces and motions of a contact problem by an outer active set.

    Parameters
    ----------
    factor : AmgFactor
    C : (n_rows, n) csr_matrix
        Rows: gaps from displacements.
    points : (n_rows, 3) array
        Points of the rows.
    problem : ComplementarityProblem
        With compliance C K^-1 C^T.
    """
    stand_in = half_space_compliance(points)
    # its scale follows from one product with the body's own compliance
    probe = np.ones(problem.n)
    u = factor.solve_one(C.T @ probe, PROBE)
    stand_in *= float(probe @ (C @ u)) / float(probe @ stand_in @ probe)
    equations = Equations(factor, C, stand_in, problem)
    u, forces, q = np.zeros(C.shape[1]), np.zeros(problem.n), np.zeros(problem.m)
    active = _first_set(stand_in, problem)
    history: list[float] = []
    rtol = LOOSE
    for nit in range(1, MOST_SETS + 1):
        u, forces, q = equations.solve_on(np.flatnonzero(active), u, forces, q, rtol)
        gap = C @ u + problem.g + problem.B.T @ q
        pull, sink = active & (forces < 0), ~active & (gap < 0)
        wrong = pull | sink
        history.append(float(wrong.sum()))
        if not wrong.any():
            if rtol == LAST:
                factor.remember(u)
                return Outcome(np.maximum(forces, 0.0), q, Status.SOLVED, "solved", nit, history)
            rtol = LAST
            continue
        active = active ^ wrong
    return Outcome(np.maximum(forces, 0.0), q, Status.ITERATION_LIMIT, f"{MOST_SETS} sets", MOST_SETS, history)


def _first_set(stand_in: Array, problem: ComplementarityProblem) -> Mask:
    """Active set of a half-space in place of the body."""
    guess = attempt(
        ComplementarityProblem((stand_in + stand_in.T) / 2, problem.g, problem.B, problem.F), tolerance=1e-6
    )
    active = guess.forces > 0
    return active if active.any() else problem.g <= problem.g.min()


@dataclass(frozen=True, eq=False)
class Multigrid:
    """Condensation by multigrid: an operator for any rows."""

    factor: AmgFactor
    positions: Array
    route: str = "operator"
    why: str = "multigrid has products only"

    @property
    def memory(self) -> int:
        """Bytes of the stiffness and of its coarser levels."""
        return self.factor.memory

    @property
    def n_retained(self) -> int:
        """None."""
        return 0

    def invert(self) -> None:
        """Nothing is dense."""

    def covers(self, dofs: IntArray) -> bool:
        """Always."""
        return True

    def compliance(self, C: sp.csr_matrix) -> MultigridCompliance:
        """S as an operator with its own solver."""
        return MultigridCompliance(self.factor, C, self.positions)

    def response(self, C: sp.csr_matrix, f: Array) -> Array:
        """C K^-1 f."""
        return np.asarray(C @ self.solve(f))

    def solve(self, f: Array) -> Array:
        """K^-1 f."""
        return self.factor.solve_one(f)
