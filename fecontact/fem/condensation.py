"""Three routes from a stiffness K to the compliance S = C K^-1 C^T of a contact's rows C.

==========  =========================================================================================================
schur       K condensed onto the m nodes in the rows, K_hat = L L^T, S = Y^T Y with Y = L^-1 C_c^T: factorising
            gives K_hat, later rows on the same nodes are small products; dense matrices of (3 m)^2
columns     plain factor and the dense S of n^2 only: with PARDISO the Schur complement -S of [[K, C^T], [C, 0]], which
            is part of the factorisation; otherwise blocks of right-hand sides
operator    plain factor; S x = C K^-1 (C^T x) by one forward and one backward step; nothing dense
==========  =========================================================================================================

A fourth, `gram-schmidt`, is the source report's own (`Separated`), for comparison.

A plain factor does not depend on the candidates: `operator` factorises once; `columns` with PARDISO once for each set
of rows. Times are measured in `docs/figures/scale.md`; `choose_route` decides by them and by the free memory.

Choice of a route of condensation (`fem.condensation`) by measured times and the free memory.
"""

from __future__ import annotations

import os
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator

from fecontact.common.arrays import STRIP, Array, IntArray, mirrored
from fecontact.common.errors import FecontactError, InputError
from fecontact.fem.factor import Condensed, Factor
from fecontact.fem.pardiso import SINGULAR, SMALL, PardisoBordered
from fecontact.fem.rigid import complement, gram_schmidt
from fecontact.mesh.facets import places_among

#: Name of the route among those of `fem.condensation`.
SEPARATED = "gram-schmidt"
#: Dense matrices of (n, n): K, its product with S, and S.
N_DENSE = 3

ROUTES = ("auto", "schur", "columns", "operator", SEPARATED)

#: Right-hand sides solved at once.
BLOCK = 64


class Condensation:
    """A stiffness K (n, n) over the solved degrees of freedom, prepared to give compliances.

    The defaults are those of a factor of the whole K, for any rows.

    Attributes
    ----------
    factor : Factor
    route : str
        Which of the routes.
    why : str
        Reason for it, in words.
    """

    factor: Factor
    route: str
    why: str

    @property
    def memory(self) -> int:
        """Bytes of the factorisation."""
        return self.factor.memory

    @property
    def n_retained(self) -> int:
        """Degrees of freedom of the dense condensed matrix."""
        return 0

    def invert(self) -> None:
        """Take the inverse of what is dense, if anything is, which pays off where many poses use it."""

    def covers(self, dofs: IntArray) -> bool:
        """Whether rows on these degrees of freedom can be condensed without another factorisation."""
        return True

    @abstractmethod
    def compliance(self, C: sp.csr_matrix) -> Array | LinearOperator:
        """S (n_rows, n_rows) of rows C (n_rows, n)."""

    def response(self, C: sp.csr_matrix, f: Array) -> Array:
        """C K^-1 f (n_rows,) of loads f (n,)."""
        return np.asarray(C @ self.solve(f))

    def solve(self, f: Array) -> Array:
        """K^-1 f (n,)."""
        return self.factor.solve(f[None])[0]


def _symmetric(S: Array) -> Array:
    """The mean of a matrix and its transpose, in place."""
    for start in range(0, len(S), STRIP):
        strip, end = slice(start, start + STRIP), start + STRIP
        mean = (S[strip, :end] + S[:end, strip].T) / 2
        S[strip, :end] = mean
        S[:end, strip] = mean.T
    return S


class Compliance(LinearOperator):
    """C K^-1 C^T by products; `dense` forms the array.

    Parameters
    ----------
    factor : Factor
        Of K (n, n).
    C : (n_rows, n) csr_matrix
    """

    def __init__(self, factor: Factor, C: sp.csr_matrix) -> None:
        super().__init__(np.dtype(float), (C.shape[0], C.shape[0]))
        self.factor, self.C = factor, C

    def _matvec(self, x: Array) -> Array:
        return np.asarray(self.C @ self.factor.solve((self.C.T @ np.ravel(x))[None])[0])

    def _adjoint(self) -> Compliance:
        return self

    def dense(self) -> Array:
        """The array, by blocks of right-hand sides."""
        n = self.shape[0]
        S = np.empty((n, n))
        for start in range(0, n, BLOCK):
            part = slice(start, start + BLOCK)
            S[:, part] = self.C @ self.factor.solve(self.C[part].toarray()).T
        return _symmetric(S)  # rounding makes it unsymmetric, in proportion to the condition of K


@dataclass(frozen=True, eq=False)
class Retained(Condensation):
    """Condensed onto some degrees of freedom.

    Attributes
    ----------
    position : (n,) array
        Position of each degree of freedom among the retained ones; -1 for inner ones.
    dense : (n_c, n_c) array
        The condensed stiffness: its inverse or its factor.
    why : str
    """

    position: IntArray
    dense: Array
    why: str
    route: str = field(default="schur", init=False)

    @property
    def n_retained(self) -> int:
        """Degrees of freedom that are retained."""
        return len(self.dense)

    @property
    def inverted(self) -> bool:
        """Whether the inverse is available."""
        return True

    @abstractmethod
    def carried(self, factorised: Callable[[], Factor]) -> Carried | None:
        """Picklable form for another process, if there is one."""

    def covers(self, dofs: IntArray) -> bool:
        """Whether all given degrees of freedom are retained."""
        return bool((self.position[dofs] >= 0).all())

    def _local(self, C: sp.csr_matrix) -> sp.csr_matrix:
        """Rows over the retained degrees of freedom."""
        return sp.csr_matrix((C.data, self.position[C.indices], C.indptr), shape=(C.shape[0], self.n_retained))

    def _by_inverse(self, C: sp.csr_matrix, inverse: Array) -> Array:
        """Compliance C K_hat^-1 C^T from the inverse of the condensed stiffness."""
        own, rows = self._local(C), inverse.T  # symmetric, and in the order of C
        used = np.unique(own.indices)
        if len(used) < len(inverse):
            own, rows = own[:, used], rows[np.ix_(used, used)]
        S = np.empty((C.shape[0], C.shape[0]))
        for start in range(0, len(S), STRIP):
            end = start + STRIP
            S[start:end, :end] = (own[:end] @ np.ascontiguousarray((own[start:end] @ rows).T)).T
        return mirrored(S)


@dataclass(frozen=True, eq=False)
class Schur(Retained):
    """Condensed by a factor that is kept; `dense` is the Cholesky factor.

    Attributes
    ----------
    dense : (n_c, n_c) array
        Lower Cholesky factor of the condensed stiffness; entries above the diagonal are arbitrary.
    condensed : Condensed
    """

    condensed: Condensed
    _inverse: list[Array] = field(default_factory=list, init=False, repr=False)
    _known: list[tuple[sp.csr_matrix, Array]] = field(default_factory=list, init=False, repr=False)

    def invert(self) -> None:
        """Invert the condensed stiffness; it pays off for many poses."""
        if self._inverse:
            return
        inverse, info = scipy.linalg.lapack.dpotri(self.dense, lower=1)
        if info != 0:
            raise FecontactError(SINGULAR, code="singular")
        self._inverse.append(mirrored(inverse))

    @property
    def inverted(self) -> bool:
        """Whether the inverse is available."""
        return bool(self._inverse)

    @classmethod
    def of(cls, factor: Condensed, n: int, dofs: IntArray, why: str) -> Schur:
        """From a condensed stiffness on `dofs`; its array is overwritten."""
        position = places_among(dofs, n)
        return cls(position, _cholesky(factor.stiffness), why, factor)

    @property
    def memory(self) -> int:
        """Bytes of the factorisation."""
        return self.condensed.memory

    def carried(self, factorised: Callable[[], Factor]) -> Carried | None:
        """Picklable form for another process; None without the inverse."""
        return Carried(self.position, self._inverse[0], self.why, factorised) if self._inverse else None

    def compliance(self, C: sp.csr_matrix) -> Array:
        """S = Y^T Y with Y = L^-1 C^T, or C K_hat^-1 C^T where the inverse is available, or quicker for many rows."""
        if 2 * C.shape[0] >= self.n_retained:
            self.invert()
        if self._inverse:
            for rows, S in self._known:
                if rows.shape == C.shape and (rows != C).nnz == 0:
                    return S
            S = self._by_inverse(C, self._inverse[0])
            S.flags.writeable = False
            # parts of a load step have the same rows; so have the two bodies of a contact that share a model
            self._known[:] = [*self._known[-1:], (C, S)]
            return S
        right = self._local(C).T.toarray(order="F")
        Y = scipy.linalg.solve_triangular(self.dense, right, lower=True, overwrite_b=True, check_finite=False)
        return np.asarray(Y.T @ Y)

    def response(self, C: sp.csr_matrix, f: Array) -> Array:
        """C K^-1 f."""
        return np.asarray(self._local(C) @ self._retained(f)[:, 0])

    def _retained(self, f: Array) -> Array:
        return scipy.linalg.cho_solve((self.dense, True), self.condensed.reduce(f[:, None]), check_finite=False)

    def solve(self, f: Array) -> Array:
        """K^-1 f."""
        return self.condensed.expand(self._retained(f), f[:, None])[:, 0]


@dataclass(frozen=True, eq=False)
class Carried(Retained):
    """Condensation received from another process: the inverse of the condensed stiffness, without the factor.

    Solutions at other degrees of freedom use a plain factor, made on first use.

    Attributes
    ----------
    dense : (n_c, n_c) array
        K_hat^-1.
    factorised : callable
        Makes the plain factor.
    """

    factorised: Callable[[], Factor]

    @cached_property
    def factor(self) -> Factor:  # type: ignore[override]
        """The plain factor."""
        return self.factorised()

    def carried(self, factorised: Callable[[], Factor]) -> Carried:
        """The same, for another process."""
        return replace(self, factorised=factorised)

    @property
    def memory(self) -> int:
        """Bytes of the plain factor, if one was made."""
        return self.factor.memory if "factor" in vars(self) else 0

    def compliance(self, C: sp.csr_matrix) -> Array:
        """S = C K_hat^-1 C^T."""
        return self._by_inverse(C, self.dense)


@dataclass(frozen=True, eq=False)
class Plain(Condensation):
    """Factor of the whole stiffness, for any rows; the compliance is dense (`columns`) or an operator.

    `n_rows` is the number of rows for which it was made, if they were known.
    """

    factor: Factor
    route: str
    why: str
    n_rows: int | None = None

    def compliance(self, C: sp.csr_matrix) -> Array | LinearOperator:
        """S as an array or an operator."""
        S = Compliance(self.factor, C)
        return S.dense() if self.route == "columns" else S


@dataclass(frozen=True, eq=False)
class Bordered(Condensation):
    """Factor of the whole stiffness together with the compliance of given rows.

    Attributes
    ----------
    factor : PardisoBordered
    rows : (n_rows, n) csr_matrix
        C.
    why : str
    """

    factor: PardisoBordered
    rows: sp.csr_matrix
    why: str
    route: str = "columns"

    @property
    def n_retained(self) -> int:
        """Rows of the border."""
        return int(self.rows.shape[0])

    def numbers(self, C: sp.csr_matrix) -> IntArray | None:
        """Numbers (n,) of rows C among the given ones; None if one is not among them."""
        probe = np.random.default_rng(0).uniform(1.0, 2.0, C.shape[1])
        mark, own = C @ probe, self.rows @ probe
        order = np.argsort(own, kind="stable")
        found = order[np.minimum(np.searchsorted(own[order], mark), len(own) - 1)]
        return found if (self.rows[found] != C).nnz == 0 else None

    def covers_rows(self, C: sp.csr_matrix) -> bool:
        """Whether the compliance of rows C follows from that of the given ones."""
        return self.numbers(C) is not None

    def compliance(self, C: sp.csr_matrix) -> Array:
        """S of some of the given rows, or of others by blocks of right-hand sides."""
        found = self.numbers(C)
        if found is None:
            return Compliance(self.factor, C).dense()
        return np.asarray(self.factor.compliance[np.ix_(found, found)])


@dataclass(frozen=True, eq=False)
class Separated(Condensation):
    """Stiffness with its rigid motions separated.

    Attributes
    ----------
    K : (n, n) csr_matrix
        The whole stiffness.
    S : (n, m) array
        Orthonormal basis of the elastic displacements.
    cholesky : (m, m) array
        Lower factor of S^T K S.
    """

    K: sp.csr_matrix
    S: Array
    cholesky: Array
    route: str = SEPARATED
    why: str = "as asked"

    @classmethod
    def of(cls, upper: sp.csr_matrix, rigid: Array, budget: float) -> Separated:
        """From the upper triangle of K (n, n), the free rigid motions (n, k), and the bytes for dense matrices.

        Raises
        ------
        InputError
            If the dense matrices exceed the budget.
        """
        n = upper.shape[0]
        needed = N_DENSE * 8.0 * n**2
        if needed > budget:
            raise InputError(
                f"condensation={SEPARATED!r} takes {needed / 1e9:.2g} GB for dense matrices of {n} degrees of freedom, "
                f"and {budget / 1e9:.2g} GB are at hand. Take a coarser mesh, or condensation='auto', which gives the "
                "same forces.",
                code="out-of-memory",
            )
        S, K = complement(gram_schmidt(rigid)), (upper + sp.triu(upper, 1).T).tocsr()
        return cls(K, S, _cholesky(S.T @ (K @ S)))

    @property
    def memory(self) -> int:
        """Bytes of S and of the factor."""
        return int(self.S.nbytes + self.cholesky.nbytes)

    @property
    def n_retained(self) -> int:
        """All elastic degrees of freedom."""
        return len(self.cholesky)

    def compliance(self, C: sp.csr_matrix) -> Array:
        """C S (S^T K S)^-1 S^T C^T, equation A-12."""
        half = C @ self.solve(C.T.toarray())
        return np.asarray(half + half.T) / 2

    def solve(self, f: Array) -> Array:
        """S (S^T K S)^-1 S^T f, equation A-9, for forces (n,) or (n, m).

        S mixes large entries of K with small ones, hence a step of iterative refinement.
        """
        u = self._elastic(f)
        return u + self._elastic(f - self.K @ u)

    def _elastic(self, f: Array) -> Array:
        return np.asarray(self.S @ scipy.linalg.cho_solve((self.cholesky, True), self.S.T @ f, check_finite=False))


def _cholesky(K: Array) -> Array:
    """Lower Cholesky factor of a symmetric matrix, which is overwritten; entries above the diagonal are arbitrary."""
    # the transpose is the same matrix in Fortran order: LAPACK factorises it in place, without a copy
    factor, info = scipy.linalg.lapack.dpotrf(K.T, lower=1, clean=0, overwrite_a=1)
    if info != 0:
        raise FecontactError(SINGULAR, code="singular")
    return np.asarray(factor)


#: Largest share of the free memory for dense matrices of a body.
MEMORY_SHARE = 0.5
#: Candidate nodes, over the root of the degrees of freedom, above which the columns of given rows are faster than the
#: Schur complement on their nodes, although that one serves other rows on the same nodes too: 500 nodes at 3e4
#: (docs/figures/scale.md).
MANY_NODES = 3.0
#: Degrees of freedom on the nodes of rows solved for one by one, over the rows, from which on columns of the rows are
#: faster, for any number of poses: 300 rows on 10,000 (a mortar coupling) take 0.2 s for each pose, as products with an
#: inverse do, which itself takes a minute.
FEW_ROWS = 4
#: Degrees of freedom on the nodes of the rows, over the rows, up to which the Schur complement and its inverse are
#: faster than columns: with friction 5,223 rows on as many of 75,228 take 14 s instead of 18 s, 2,706 of 80,760 11 s of
#: 13 s.
FULL = 1.25
#: Rows of a small model, on at least twice as many degrees of freedom, whose columns are for one pose faster one by one
#: with a plain factor than by a Schur complement: 13 rows at 3,864 unknowns in 33 ms of 45, 161 at 3,222 in 42 of 59.
FEW_COLUMNS = 100
#: The same above which products are faster than solving for columns one by one, without PARDISO.
MANY_PRODUCTS = 10.0
#: Seconds on one thread, of which only ratios matter, to a third of what was measured: layers of 15-node wedges of
#: 26,000 to 83,000 unknowns on 300 to 2,500 nodes, blocks of 20-node hexahedra of 8,400 and 46,000 unknowns. A factor
#: per entry squared over the unknowns (as of a band), and per byte.
SECONDS_PER_FACTOR, SECONDS_PER_BYTE = 3e-11, 1.5e-9
#: A Schur complement, its Cholesky factor and its inverse, per degree of freedom cubed, and rows by it, squared.
SECONDS_PER_SCHUR, SECONDS_PER_POSE = 4e-11, 1e-8


def choose_route(
    n_dofs: int,
    n_retained: int,
    budget: float,
    poses: int = 1,
    one_by_one: bool = False,
    n_rows: int | None = None,
    factor: float = 0.0,
) -> tuple[str, str]:
    """Choose a route of condensation; return it with the reason.

    Parameters
    ----------
    n_dofs : int
        Unknowns of the solve.
    n_retained : int
        Degrees of freedom of the nodes in the rows.
    budget : float
        Bytes available for dense matrices.
    poses : int
        Number of cases that share what is condensed onto these nodes. Columns are made anew for each of them.
    one_by_one : bool
        Whether columns are solved for one by one, see `fem.factor.has_bordered`.
    n_rows : int, optional
        Number of rows, if they are known; each is taken to be on one node otherwise. A row of a mortar coupling is on
        dozens of nodes.
    factor : float
        Bytes of a factor of this stiffness, for several poses.

    Examples
    --------
    >>> choose_route(40000, 900, 4e9)[0], choose_route(100000, 15000, 64e9)[0], choose_route(40000, 900, 1e6)[0]
    ('schur', 'columns', 'operator')
    >>> choose_route(400000, 30000, 1e9)[0], choose_route(400000, 30000, 1e9, n_rows=300)[0]
    ('operator', 'columns')
    """
    nodes, root = n_retained // 3, n_dofs**0.5
    rows = nodes if n_rows is None else n_rows
    # S and a solver's copies; K_hat twice (one inside PARDISO) and Y
    columns = 8.0 * 5 * rows**2
    dense = columns + 8.0 * (2 * n_retained**2 + n_retained * rows)
    if columns > budget or (one_by_one and dense > budget and n_rows is None):
        what = f"{nodes} nodes" if n_rows is None else f"{rows} rows"
        return "operator", f"a dense matrix for {what} takes {columns / 1e9:.2g} GB of {budget / 1e9:.2g} GB"
    if poses == 1 and n_rows is not None and n_rows <= min(FEW_COLUMNS, n_retained // 2) and n_dofs < SMALL:
        return "columns", f"{rows} rows of a small model"
    few = one_by_one and n_rows is not None and FEW_ROWS * rows <= n_retained
    if few and rows < MANY_PRODUCTS * root:
        return "columns", f"{rows} rows on {nodes} nodes: columns of the rows are quicker than those of the nodes"
    if poses > 1 and dense <= budget and (one_by_one or once_for_all(n_dofs, n_retained, poses, factor)):
        return "schur", f"{nodes} candidate nodes, shared by {poses} poses"
    # many rows on few nodes are few columns
    if one_by_one and min(rows, nodes) >= (many := int(MANY_PRODUCTS * root)):
        return "operator", f"{rows} candidates, from {many} on products with the factor are quicker"
    if dense > budget:
        return "columns", f"the Schur complement on {nodes} nodes takes {dense / 1e9:.2g} GB of {budget / 1e9:.2g} GB"
    if poses > 1:
        return "columns", f"columns for each of {poses} poses are quicker than a Schur complement on {nodes} nodes"
    if n_rows is not None and not one_by_one and n_retained <= FULL * n_rows:
        return "schur", f"{rows} rows on {n_retained} degrees of freedom"
    if not one_by_one and nodes >= (many := int(MANY_NODES * root)):
        return "columns", f"{nodes} candidate nodes, from {many} on only their columns are computed"
    if one_by_one and rows < nodes:
        return "schur", f"{rows} rows on {nodes} candidate nodes, fewer than {many}"
    return "schur", f"{nodes} candidate nodes, fewer than {int((MANY_PRODUCTS if one_by_one else MANY_NODES) * root)}"


def once_for_all(n_dofs: int, n_retained: int, poses: int, factor: float) -> bool:
    """Whether one Schur complement with its inverse is quicker than columns, and so a factor, for each of some poses.

    Parameters
    ----------
    n_dofs, n_retained, poses : int
    factor : float
        Bytes of a factor.

    Examples
    --------
    A layer of cartilage, 26,340 unknowns: 800 nodes are condensed for twenty poses, 2,500 nodes are not.

    >>> once_for_all(26340, 2400, 20, 53e6), once_for_all(26340, 7500, 20, 53e6), once_for_all(26340, 2400, 2, 53e6)
    (True, False, False)
    """
    entries = factor / 8
    anew = SECONDS_PER_FACTOR * entries**2 / max(n_dofs, 1) + SECONDS_PER_BYTE * factor
    once = SECONDS_PER_SCHUR * float(n_retained) ** 3
    return once + poses * SECONDS_PER_POSE * float(n_retained) ** 2 < (poses - 1) * anew


def memory_budget() -> float:
    """Bytes for dense matrices: `MEMORY_SHARE` of the memory free on this machine and in its container."""
    free = _physical_memory()
    try:
        text = Path("/proc/meminfo").read_text()
        free = 1024.0 * int(text.split("MemAvailable:")[1].split()[0])
        limit = Path("/sys/fs/cgroup/memory.max").read_text().strip()
        if limit != "max":
            free = min(free, float(limit) - float(Path("/sys/fs/cgroup/memory.current").read_text()))
    except (OSError, IndexError, ValueError):
        pass  # not Linux, or no container: keep the value found so far
    return MEMORY_SHARE * max(free, 0.0)


def _physical_memory() -> float:
    """Bytes of memory of this machine; 8 GB where unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * float(os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return 8e9
