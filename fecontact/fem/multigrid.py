"""Contact of bodies whose stiffness is on levels of algebraic multigrid, see `fem.amg`.

Contact is not solved by products with the compliance, each of which needs a solve, but for displacements and forces
together: an outer active set, and for each set the equations of bodies on its rows, by conjugate gradients with a
V-cycle (`fem.constrained_cg`), from the last solution: roughly while the set changes, then to the tolerance. The first
set, and the scale of the motions, are those of a half-space in place of each body, with its planes of symmetry.

Rows that hold bodies together: the lift of their gaps, the projection on displacements that keep them. Only G W G^T is
factorised.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol, cast

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.sparse.linalg import LinearOperator
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.fem.amg import TIGHT, AmgFactor, Cycle
from fecontact.fem.condensation import Compliance, Condensation
from fecontact.fem.constrained_cg import Held, Product, constrained_cg
from fecontact.fem.factor import Factor
from fecontact.solvers.problem import ContactProblem, Outcome, Status
from fecontact.solvers.registry import attempt

#: Relative residual of the equations of one active set while the set changes.
LOOSE = 1e-3
#: Relative residual of the product that scales the half-space.
PROBE = 0.1
#: Share of the active points that may be others than those of a cycle: each takes about a step, a new cycle those of
#: fifty.
CHANGED = 0.05
#: Largest number of active sets.
MAX_SETS = 60
#: Boussinesq's displacement under the middle of a uniformly loaded square: 4 ln(1 + sqrt(2)) over its side.
SELF = 4 * np.log(1 + np.sqrt(2))
#: Planes of symmetry of a whole body.
NO_PLANES = np.zeros((0, 4))
#: Smallest pivot of G W G^T, relative to its largest entry, at which rows count as dependent.
DEPENDENT = 1e-12
#: Entries of (G W G^T)^-1, relative to its diagonal, that are dropped from a preconditioner.
DROPPED = 1e-2
#: Rows with common displacements up to which their dense inverse is taken.
MAX_INVERTED = 3000


class DependentRowsError(ValueError):
    """Rows of an active set that are not independent on the solved displacements."""


class SparseRows:
    """Rows G (a, n) with weights W (n,): the lift L = W G^T (G W G^T)^-1 and the projection P = I - L G.

    Raises
    ------
    DependentRowsError
        For dependent rows.

    Examples
    --------
    >>> rows = SparseRows(sp.csr_matrix([[0.0, 2.0, 0.0]]), np.ones(3))
    >>> rows.lift(np.array([1.0])).tolist(), rows.project(np.array([3.0, 4.0, 5.0])).tolist()
    ([0.0, 0.5, 0.0], [3.0, 0.0, 5.0])
    """

    def __init__(self, G: sp.csr_matrix, W: Array) -> None:
        self.G = G
        weighted = sp.csr_matrix(G.multiply(W))
        self._weighted_transpose, self._transpose = weighted.T.tocsr(), G.T.tocsr()
        self.gram = gram = (G @ weighted.T).tocsc()
        diagonal = gram.diagonal()
        if diagonal.min(initial=np.inf) <= DEPENDENT * diagonal.max(initial=0.0):
            raise DependentRowsError("a row does not act on any solved displacement")
        #: Whether no two rows act on one displacement.
        self.apart = gram.nnz == len(diagonal)
        if self.apart:
            self._solve: Product = lambda b: b / diagonal
            return
        try:
            factor = spla.splu(gram, options={"SymmetricMode": True}, diag_pivot_thresh=0.0, permc_spec="MMD_AT_PLUS_A")
        except RuntimeError as error:
            raise DependentRowsError("dependent rows") from error
        pivots = np.abs(factor.U.diagonal())
        if pivots.min() <= DEPENDENT * pivots.max():
            raise DependentRowsError("dependent rows")
        self._solve = factor.solve

    def gap(self, u: Array) -> Array:
        """G u."""
        return np.asarray(self.G @ u)

    def lift(self, d: Array) -> Array:
        """L d."""
        return np.asarray(self._weighted_transpose @ self._solve(d))

    def forces(self, r: Array) -> Array:
        """L^T r: the forces along the rows in nodal forces r (n,)."""
        return self._solve(self._weighted_transpose.T @ r)

    def nodal(self, forces: Array) -> Array:
        """G^T l."""
        return np.asarray(self._transpose @ forces)

    def project(self, v: Array) -> Array:
        """P v."""
        return v - self.lift(self.gap(v))

    @property
    def invertible(self) -> bool:
        """Whether `removed` is affordable."""
        return self.apart or self.G.shape[0] <= MAX_INVERTED

    def removed(self) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """L G, which projects on what P removes, and G^T (G W G^T)^-1 G, a stiffness on it alone.

        Small entries of the inverse are dropped: away from the diagonal they decay exponentially.
        """
        if self.apart:
            few = sp.diags_array(1.0 / self.gram.diagonal(), format="csr")
        else:
            inverse = np.linalg.inv(self.gram.toarray())
            size = np.sqrt(inverse.diagonal())
            inverse[np.abs(inverse) < DROPPED * size * size[:, None]] = 0.0
            few = sp.csr_matrix(inverse)
        scaled = few @ self.G
        return sp.csr_matrix(self._weighted_transpose @ scaled), sp.csr_matrix(self._transpose @ scaled)


class IterativeFactor(Factor, Protocol):
    """Solutions by iteration."""

    def solve_one(self, b: Array, rtol: float) -> Array:
        """Solution (n,) of one right-hand side, to a relative residual."""


class MultigridCompliance(Compliance):
    """Compliance of rows on one body, with its own contact solver.

    Parameters
    ----------
    factor : IterativeFactor
    C : (n_rows, n) csr_matrix
    positions : (n, 3) array
        Positions of the degrees of freedom.
    planes : (k, 4) array, optional
        Planes of symmetry that bound the body, see `fem.support.mirrors`.
    system : callable, optional
        Makes the `System` of n rows and all bodies; by default an `Assembly`.
    """

    solver = "multigrid"
    factor: IterativeFactor

    def __init__(
        self,
        factor: IterativeFactor,
        C: sp.csr_matrix,
        positions: Array,
        planes: Array = NO_PLANES,
        system: MakeSystem | None = None,
    ) -> None:
        super().__init__(factor, C)
        self.system: MakeSystem = system or Assembly
        self.planes = planes
        weights = abs(C)
        total = np.asarray(weights.sum(axis=1)).reshape(-1, 1)
        self.points = np.asarray(weights @ positions) / np.where(total > 0, total, 1.0)

    @cached_property
    def half_space(self) -> Array:
        """Compliance (n_rows, n_rows) of a half-space between the points, scaled by one product with the body's own."""
        S = half_space_compliance(self.points, self.planes)
        ones = np.ones(len(S))
        size = float(ones @ (self.C @ self.factor.solve_one(self.C.T @ ones, PROBE)))
        return S * (size / float(S.sum()))

    def mean_diagonal(self) -> float:
        """Mean compliance of the points, about."""
        return float(self.half_space.diagonal().mean())

    def solve_contact(self, problem: ContactProblem, tolerance: float) -> Outcome:
        """Forces and motions of the problem."""
        return solve_contact([(np.arange(problem.n), self)], problem, tolerance)


class JointCompliance(LinearOperator):
    """Sum of the compliances of several bodies, each on some of the rows, with its own contact solver.

    Parameters
    ----------
    n : int
        Number of rows.
    shares : sequence of (index, MultigridCompliance)
        Rows (k,) of each body.
    """

    solver = "multigrid"

    @classmethod
    def of(cls, n: int, shares: Sequence[tuple[IntArray, Array | LinearOperator]]) -> JointCompliance | None:
        """The sum, if all bodies have multigrid."""
        levels = [(index, own) for index, own in shares if isinstance(own, MultigridCompliance)]
        return cls(n, levels) if len(levels) == len(shares) else None

    def __init__(self, n: int, shares: Sequence[tuple[IntArray, MultigridCompliance]]) -> None:
        super().__init__(np.dtype(float), (n, n))
        self.shares = tuple(shares)

    def mean_diagonal(self) -> float:
        """Mean compliance of the rows, about."""
        return sum(len(index) * own.mean_diagonal() for index, own in self.shares) / self.shape[0]

    def _matvec(self, x: Array) -> Array:
        out = np.zeros(self.shape[0])
        for index, compliance in self.shares:
            out[index] += compliance @ np.ravel(x)[index]
        return out

    def solve_contact(self, problem: ContactProblem, tolerance: float) -> Outcome:
        """Forces and motions of the problem."""
        return solve_contact(self.shares, problem, tolerance)


class System(Protocol):
    """Displacements of all bodies, from which each solve starts."""

    def held(self, active: IntArray, problem: ContactProblem, Q: Array) -> OnRows:
        """Solve on active rows of a problem; Q as in `constrained_cg.Held`."""

    def keep(self) -> None:
        """Start later products from the displacements."""


#: Forces (a,) of active rows, motions and the deflection (n,) along all rows, from motions and a tolerance.
OnRows = Callable[[Array, float], tuple[Array, Array, Array]]
MakeSystem = Callable[[int, Sequence[tuple[IntArray, MultigridCompliance]]], System]


class Assembly:
    """Displacements of all bodies in one vector (N,).

    Attributes
    ----------
    factors : tuple of AmgFactor
        One for each body.
    ends : tuple of int
        Where each body's displacements begin, and N.
    C : (n_rows, N) csr_matrix
    softness : (N,) array
        Inverse of the diagonal of the stiffness.
    """

    def __init__(self, n: int, shares: Sequence[tuple[IntArray, MultigridCompliance]]) -> None:
        self.factors = tuple(cast(AmgFactor, compliance.factor) for _, compliance in shares)
        softness = [1.0 / factor.K.diagonal() for factor in self.factors]
        self.ends = (0, *np.cumsum([len(s) for s in softness]).tolist())
        self.C = sp.hstack([_placed(n, index, compliance.C) for index, compliance in shares], format="csr")
        self.softness = np.concatenate(softness)
        self._u = np.zeros(self.ends[-1])
        self._cycle: tuple[IntArray, Callable[[Array], Array]] | None = None

    def parts(self, u: Array) -> list[Array]:
        """Displacements of each body."""
        return [u[start:end] for start, end in pairwise(self.ends)]

    def K(self, u: Array) -> Array:
        """Nodal forces (N,) of displacements."""
        return np.concatenate([factor.K @ v for factor, v in zip(self.factors, self.parts(u), strict=True)])

    def cycle(self, rows: SparseRows) -> Callable[[Array], Array]:
        """V-cycle of the bodies on their rows; of free bodies where the inverse that it takes is too large."""
        if rows.invertible:
            return Cycle.side_by_side([factor.cycle for factor in self.factors]).restricted(*rows.removed())
        return lambda r: np.concatenate([f.cycle(v) for f, v in zip(self.factors, self.parts(r), strict=True)])

    def held(self, active: IntArray, problem: ContactProblem, Q: Array) -> OnRows:
        """Conjugate gradients on active rows."""
        rows = SparseRows(self.C[active], self.softness)
        B, known = problem.B[:, active], self._cycle
        if known is None or len(np.setxor1d(active, known[0])) > CHANGED * len(active):
            known = self._cycle = active, self.cycle(rows)
        held = Held(self.K, known[1], rows, problem.g[active], B, problem.F, Q)

        def on_rows(q: Array, rtol: float) -> tuple[Array, Array, Array]:
            self._u, forces, q = constrained_cg(held, self._u, q, rtol, self.count)
            return forces, q, self.C @ self._u

        return on_rows

    def keep(self) -> None:
        """Start later products from the displacements."""
        for factor, v in zip(self.factors, self.parts(self._u), strict=True):
            factor.remember(v)

    def count(self) -> None:
        """Count a step."""
        for factor in {id(f): f for f in self.factors}.values():
            factor.steps += 1


def _placed(n: int, index: IntArray, rows: sp.csr_matrix) -> sp.csr_matrix:
    """Rows (k, N) at `index` among n."""
    to = sp.csr_matrix((np.ones(len(index)), (index, np.arange(len(index)))), shape=(n, len(index)))
    return to @ rows


def solve_contact(
    shares: Sequence[tuple[IntArray, MultigridCompliance]], problem: ContactProblem, tolerance: float
) -> Outcome:
    """Forces and motions of a contact problem by an outer active set.

    Parameters
    ----------
    shares : sequence of (index, MultigridCompliance)
        Bodies and their rows, which sum to the problem's compliance.
    problem : ContactProblem
    tolerance : float
        Of the certificate.
    """
    system = shares[0][1].system(problem.n, shares)
    try:
        return _by_active_sets(system, _half_spaces(problem.n, shares), problem, 0.1 * tolerance)
    except DependentRowsError as error:
        return Outcome(np.zeros(problem.n), np.zeros(problem.m), Status.SINGULAR, str(error), 0)


def _by_active_sets(system: System, guess: Array, problem: ContactProblem, tolerance: float) -> Outcome:
    active, q = _set_of(guess, problem, problem.g)
    history: list[float] = []
    forces = np.zeros(problem.n)
    for nit in range(1, MAX_SETS + 1):
        A = np.flatnonzero(active)
        on_rows = system.held(A, problem, _motions(guess[np.ix_(A, A)], problem.B[:, A]))
        for rtol in (LOOSE, TIGHT):
            forces = np.zeros(problem.n)
            forces[A], q, deflection = on_rows(q, rtol)
            wrong = _wrong(deflection, forces, q, active, problem, tolerance)
            if wrong.any():
                break
        history.append(float(wrong.sum()))
        if not wrong.any():
            system.keep()
            return Outcome(np.maximum(forces, 0.0), q, Status.SOLVED, "solved", nit, history)
        active = active ^ wrong
        if nit == 1:  # what the bodies deflect more than half-spaces under the same forces counts as gap
            active, q = _set_of(guess, problem, problem.g + deflection - guess @ forces)
    return Outcome(np.maximum(forces, 0.0), q, Status.ITERATION_LIMIT, f"{MAX_SETS} sets", MAX_SETS, history)


def _wrong(deflection: Array, forces: Array, q: Array, active: Mask, problem: ContactProblem, tolerance: float) -> Mask:
    """Active points in tension and others that penetrate, by more than rounding."""
    gap = deflection + problem.g + problem.B.T @ q
    pulled = active & (forces < -tolerance * np.abs(forces).max())
    return pulled | (~active & (gap < -tolerance * np.abs(deflection).max()))


def _motions(guess: Array, B: Array) -> Array:
    """Inverse (m, m) of the stiffness B S^-1 B^T that contacts of compliance S offer to the motions."""
    if len(B) == 0:
        return np.zeros((0, 0))
    factor = scipy.linalg.cho_factor(guess, lower=True)
    return np.asarray(np.linalg.pinv(B @ scipy.linalg.cho_solve(factor, B.T), rcond=1e-12, hermitian=True))


def half_space_compliance(points: Array, planes: Array = NO_PLANES) -> Array:
    """1 / r (n, n) between points (n, 3); on the diagonal the mean over a square as wide as the nearest distance.

    K. L. Johnson, Contact Mechanics, 1985, eq. 3.25, without its factor (1 - nu^2) / (pi E). Of a body cut at planes of
    symmetry (k, 4) each force has its mirror images across those that are no farther away than the points are apart;
    on a plane it is one with its image.

    Examples
    --------
    >>> points = np.array([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    >>> mirrored = half_space_compliance(points, np.array([[1.0, 0.0, 0.0, 0.0]]))
    >>> (mirrored - half_space_compliance(points)).round(9).tolist()
    [[0.5, 0.25], [0.25, 0.166666667]]
    """
    width = cKDTree(points).query(points, k=2)[0][:, 1] if len(points) > 1 else np.ones(1)
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    least = np.maximum(width, 1e-12 * extent) / SELF
    images, S = [points], np.zeros((len(points), len(points)))
    for n, height in zip(planes[:, :3], planes[:, 3], strict=True):
        if np.abs(points @ n - height).min() <= extent:
            images += [x - 2 * np.outer(x @ n - height, n) for x in images]
    for x in images:
        S += 1.0 / np.maximum(cdist(points, x), least)
    return S


def _half_spaces(n: int, shares: Sequence[tuple[IntArray, MultigridCompliance]]) -> Array:
    """Compliance (n, n) of half-spaces in place of the bodies."""
    S = np.zeros((n, n))
    for index, compliance in shares:
        S[np.ix_(index, index)] += compliance.half_space
    return S


def _set_of(guess: Array, problem: ContactProblem, g: Array) -> tuple[Mask, Array]:
    """Active set and motions of half-spaces in place of the bodies, with gaps g (n,)."""
    found = attempt(ContactProblem((guess + guess.T) / 2, g, problem.B, problem.F), tolerance=1e-6)
    active = found.forces > 0
    if active.any():
        return active, found.q
    return g <= g.min(), np.zeros(problem.m)


@dataclass(frozen=True, eq=False)
class Multigrid(Condensation):
    """Condensation by multigrid: an operator for any rows."""

    factor: IterativeFactor
    positions: Array
    planes: Array
    system: MakeSystem | None = None
    route: str = "operator"
    why: str = "multigrid has products only"

    def compliance(self, C: sp.csr_matrix) -> MultigridCompliance:
        """S as an operator with its own solver."""
        return MultigridCompliance(self.factor, C, self.positions, self.planes, self.system)
