"""The contact problem on its candidate points, without friction or with it, and its solution.

    minimise 1/2 l^T S l + g^T l   subject to   l >= 0,  B l = F
    gap      w = S l + g + B^T q >= 0,   l . w = 0,   q the multiplier of B l = F (the rigid motion)

With friction rows of tangential forces t stand among those of l, and their gaps are slips s; both obey the law of
`solvers.coulomb`:

    (w, s) = S (l, t) + g + B^T q,   B (l, t) = F

Slip is the change of the tangential displacement since the last step: g has the displacement at its end, with the sign
reversed. Nothing here knows of meshes or bodies; compression and opening are positive.

Examples
--------
>>> import numpy as np
>>> problem = ContactProblem(S=np.eye(2), g=np.array([-1.0, 1.0]))
>>> problem.residuals(forces=np.array([1.0, 0.0]), q=np.zeros(0)).worst
0.0

Unverified answer of a solver.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.sparse.linalg import LinearOperator

from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SolverError
from fecontact.common.renamed import renamed
from fecontact.solvers.coulomb import Residuals, ResidualScales, friction_limit, largest, ratio, sizes, sticks
from fecontact.solvers.scaling import ContactRows, ScaledProblem, scale

SYMMETRY_TOLERANCE = 1e-8
"""Largest |S - S^T|, relative to the largest entry, that counts as rounding; more is refused."""

GAP_FLOOR = 1e-3
"""Share of the largest gap below which the elastic deflection is not used as the scale of gaps."""

TERM_FLOOR = 1e-4
"""The same for g and the motions in B^T q, where these cancel each other: rounding of them must not count. Of 45 units
in the last place, 1e-14 of the largest term, it reaches the tolerance of 1e-10."""

ROW_FLOOR = 1e-6
"""Least scale of a row of B, as a share of the largest row: smaller rows are rounding residues."""


class Status(StrEnum):
    """How a solver ended; only the first two are success.

    ===================  ===================================================================================
    ``solved``           certified: the recomputed residuals are within the tolerance
    ``no-contact``       certified: nothing touches, all forces are exactly zero
    ``infeasible``       no forces l >= 0 balance the load: a body can move freely along it
    ``unbounded``        an interference that no elastic deflection and no rigid motion can remove
    ``singular``         a dependent set of points that the solver cannot treat
    ``artificial``       artificial variables stayed positive (Wolfe's short form on a singular S)
    ``cycling``          active sets repeated
    ``iteration-limit``  the allowed number of iterations was spent
    ``refused``          the answer did not pass the certificate
    ===================  ===================================================================================
    """

    SOLVED = "solved"
    NO_CONTACT = "no-contact"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    SINGULAR = "singular"
    ARTIFICIAL = "artificial"
    CYCLING = "cycling"
    ITERATION_LIMIT = "iteration-limit"
    REFUSED = "refused"


class InfeasibleLoadError(SolverError):
    """No non-negative contact forces balance the load.

    Attributes
    ----------
    direction : ndarray, shape (m,)
        A motion y of the rigid components with B^T y >= 0 (no gap closes) and F . y < 0 (the load does work along it):
        by Farkas' lemma the proof that no solution exists.
    """

    code = "no-balance"

    def __init__(self, message: str, direction: np.ndarray) -> None:
        super().__init__(message)
        self.direction = direction


@compact_repr
@dataclass(frozen=True, eq=False)
class ContactProblem(ContactRows):
    """Contact on n candidate points with m rigid components in equilibrium.

    Parameters
    ----------
    S : ndarray, shape (n, n), or scipy.sparse.linalg.LinearOperator
        Compliance, symmetric positive semidefinite: gap opened at a point by unit forces at the others.
    g : ndarray, shape (n,)
        Gap without contact forces and rigid motion, opening positive; negative is interference.
    B : ndarray, shape (m, n), optional
        Equilibrium rows: B l are the resultants of the contact forces on the free rigid components. May be dependent.
    F : ndarray, shape (m,), optional
        Load to be balanced by the contact forces.
    points : ndarray of int, shape (f,), optional
        Normal row of each point with friction.
    tangents : ndarray of int, shape (f, k), optional
        Its tangential rows, k of 1 or 2, along orthogonal directions. All other rows are normal ones.
    mu : ndarray, shape (f,), optional
        Coefficient of friction; zero or infinite ones are allowed.

    Raises
    ------
    InputError
        For shapes or indices that do not fit, entries that are not finite, an S that is not symmetric or has a
        negative diagonal entry, a mu that is negative or not a number, or friction with an operator for S.

    Examples
    --------
    >>> import numpy as np
    >>> problem = ContactProblem(S=np.eye(3), g=np.arange(3.0), B=np.ones((1, 3)), F=np.array([1.0]))
    >>> problem.n, problem.m
    (3, 1)

    A point pressed down by 1 and dragged by 0.2 does not slip at mu = 0.3:

    >>> one = np.array([0])
    >>> F = np.array([1.0, 0.2])
    >>> dragged = ContactProblem(np.eye(2), np.zeros(2), np.eye(2), F, one, np.array([[1]]), np.array([0.3]))
    >>> dragged.residuals(np.array([1.0, 0.2]), np.array([-1.0, -0.2])).worst
    0.0
    """

    S: np.ndarray | LinearOperator
    g: np.ndarray
    B: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    F: np.ndarray = field(default_factory=lambda: np.empty(0))
    points: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    tangents: np.ndarray = field(default_factory=lambda: np.empty((0, 1), dtype=np.int64))
    mu: np.ndarray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        g = _array("g", self.g, 1)
        if g.size == 0:
            raise InputError("The problem has no candidate point: g is empty. Give at least one point.", code="no-gap")
        B = np.empty((0, g.size)) if self.B is None or np.size(self.B) == 0 else _array("B", self.B, 2)
        F = np.empty(0) if self.F is None else _array("F", self.F, 1)
        if B.shape[1] != g.size:
            raise InputError(f"B must have one column per point, {g.size}; found shape {B.shape}.", code="column-shape")
        if B.shape[0] != F.size:
            raise InputError(f"F must have one entry per row of B, {B.shape[0]}; found {F.size}.", code="row-shape")
        S = self.S if isinstance(self.S, LinearOperator) else _array("S", self.S, 2)
        if S.shape != (g.size, g.size):
            raise InputError(f"S must have shape {(g.size, g.size)}, one row per entry of g; found {S.shape}.")
        if isinstance(S, np.ndarray):
            _check_compliance(S)
        points, tangents = np.asarray(self.points, dtype=np.int64), np.asarray(self.tangents, dtype=np.int64)
        mu = np.asarray(self.mu, dtype=float)
        if points.size or tangents.size or mu.size:
            _check_friction(S, g.size, points, tangents, mu)
        given = {"S": S, "g": g, "B": B, "F": F, "points": points, "tangents": tangents, "mu": mu}
        for name, value in given.items():
            object.__setattr__(self, name, value)

    @property
    def is_dense(self) -> bool:
        """Whether the compliance is a matrix, no operator."""
        return isinstance(self.S, np.ndarray)

    @property
    def m(self) -> int:
        """Number of equilibrium rows."""
        return int(self.F.size)

    def normal_problem(self, forces: np.ndarray) -> ContactProblem:
        """Problem of the normal forces, under the tangential part of given forces (N,)."""
        n, t = self.normals, self.tangents.ravel()
        F = self.F - self.B[:, t] @ forces[t]
        along = np.zeros(self.n)
        along[t] = forces[t]
        S = self.S.normal(n) if isinstance(self.S, FrictionOperator) else self.matrix[np.ix_(n, n)]
        return ContactProblem(S, self.g[n] + (self.S @ along)[n], self.B[:, n], F)

    def slip(self, forces: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Slip of the points during the step, shape (f, k)."""
        return np.asarray(self.gap(forces, q)[self.tangents])

    def limit(self, forces: np.ndarray) -> np.ndarray:
        """Largest tangential force mu l of the points, shape (f,); infinite where rough and pressed, |t| where bare."""
        limit = friction_limit(self.mu, forces[self.points])
        return np.where(self._bare(forces), sizes(forces[self.tangents].T), limit)

    def _bare(self, forces: np.ndarray) -> np.ndarray:
        """Rough points without pressure, (f,) bool: mu l is any number there, see `solvers.coulomb`."""
        return np.isinf(self.mu) & (forces[self.points] == 0)

    def residual_scales(self, forces: np.ndarray, q: np.ndarray) -> ResidualScales:
        """Scales of the residuals of finite forces (n,) and motions q (m,)."""
        return self._scales(forces, np.asarray(self.S @ forces), self.g + self.B.T @ q, q)

    def _scales(self, forces: np.ndarray, deflection: np.ndarray, rigid: np.ndarray, q: np.ndarray) -> ResidualScales:
        row = np.abs(self.B).max(axis=1, initial=0.0)
        row = np.maximum(row, ROW_FLOOR * row.max(initial=0.0))
        # a load on a row of zeros is no scale of forces: it is left unbalanced, by all of itself
        load = np.divide(self.F, row, out=np.zeros_like(row), where=row > 0)
        force = max(float(np.abs(forces).sum()), largest(load))
        # where the motion exceeds g by more than a tenth, the floor of the sum is the higher one
        terms = max(largest(self.g), largest(np.abs(self.B).T @ np.abs(q)))
        gap = max(largest(deflection), GAP_FLOOR * largest(rigid), TERM_FLOOR * terms)
        point = largest(forces) if self.points.size else 0.0
        return ResidualScales(force, gap, point, terms, row * force + np.abs(self.F))

    def residuals(
        self,
        forces: np.ndarray,
        q: np.ndarray,
        scales: ResidualScales | None = None,
        deflection: np.ndarray | None = None,
    ) -> Residuals:
        """Residuals of a solution, recomputed from the problem alone.

        Parameters
        ----------
        forces : ndarray, shape (n,)
        q : ndarray, shape (m,)
        scales : ResidualScales, optional
            Of a problem of which this is a part; by default its own.
        deflection : ndarray, shape (n,), optional
            S l, where the caller has just computed it.

        Returns
        -------
        Residuals
            Infinite where the solution is not finite.

        Examples
        --------
        >>> import numpy as np
        >>> problem = ContactProblem(S=np.eye(2), g=np.array([-1.0, 1.0]))
        >>> problem.residuals(np.array([0.5, 0.0]), np.zeros(0)).penetration
        1.0
        """
        forces, q = np.asarray(forces, dtype=float), np.asarray(q, dtype=float)
        if forces.shape != (self.n,) or q.shape != (self.m,):
            raise InputError(
                f"Residuals need forces of shape {(self.n,)} and q of shape {(self.m,)}; "
                f"found {forces.shape} and {q.shape}.",
                code="residual-shape",
            )
        if not (np.isfinite(forces).all() and np.isfinite(q).all()):
            return Residuals(np.inf, np.inf, np.inf, np.inf)
        deflection, rigid = np.asarray(self.S @ forces) if deflection is None else deflection, self.g + self.B.T @ q
        scales = self._scales(forces, deflection, rigid, q) if scales is None else scales
        unbalanced = largest(ratio(self.B @ forces - self.F, scales.row))
        gap = np.add(deflection, rigid, out=rigid)
        if not self.points.size:
            return _normal_residuals(forces, gap, scales, unbalanced)
        borne, bare = forces.copy(), self._bare(forces)
        # a gap bears no tangential force either
        borne[self.points[bare]] = sizes(forces[self.tangents[bare]].T)
        normal = _normal_residuals(borne[self.normals], gap[self.normals], scales, unbalanced)
        return normal.with_friction(forces[self.tangents].T, gap[self.tangents].T, self.limit(forces), scales)

    def scaled(self) -> ScaledProblem:
        """Nondimensional form with unit diagonal and orthonormal rows, and its inverse maps.

        Returns
        -------
        ScaledProblem

        Examples
        --------
        >>> import numpy as np
        >>> scaled = ContactProblem(S=4e-12 * np.eye(2), g=np.array([-1e-6, 1e-6])).scaled()
        >>> scaled.S.diagonal().tolist(), scaled.g.round(12).tolist()
        ([1.0, 1.0], [-1.0, 1.0])
        """
        friction = (self.points, self.tangents, self.mu) if self.points.size else None
        return scale(self.S, self.g, self.B, self.F, friction)


@runtime_checkable
class FrictionOperator(Protocol):
    """A compliance operator with a solver of friction of its own."""

    def __matmul__(self, x: np.ndarray) -> np.ndarray:
        """Displacements along the rows."""

    def normal(self, rows: np.ndarray) -> LinearOperator:
        """Compliance among normal rows."""

    def array(self) -> np.ndarray:
        """The compliance as an array."""

    def solve_friction(self, problem: ContactProblem, tolerance: float) -> Solution | None:
        """Certified solution; None if none is found, or the problem is not of its kind."""


def formed(compliance: Array | LinearOperator) -> Array | LinearOperator:
    """A compliance that is to be added to others: one that solves friction alone as an array, others as they are."""
    return compliance.array() if isinstance(compliance, FrictionOperator) else compliance


@compact_repr
@dataclass(frozen=True, eq=False)
class Solution:
    """Solution of a contact problem. Its residuals are recomputed from the problem.

    Parameters
    ----------
    problem : ContactProblem
    forces : ndarray, shape (n,)
        Contact forces, compression positive; with friction tangential ones at their rows.
    q : ndarray, shape (m,)
        Multiplier of the equilibrium rows, the rigid motion; for status ``infeasible`` the direction
        that proves it (see `InfeasibleLoadError`).
    status : Status
        Status, see the table at `Status`.
    message : str
        The status in a sentence.
    nit : int
        Iterations or pivots.
    solver : str
        Name of the solver.
    seconds : float
        Wall time.
    history : tuple of float
        The solver's own residual, one entry per iteration; may be empty.
    scales : ResidualScales, optional
        Of the problem of which this is a part; by default its own.
    orientation : int
        With friction, the sign of the determinant of Newton's matrix at the end, +1 as without; -1: the solution is not
        the only one, or not stable (Klarbring 1990); 0: singular, forces are not unique.
    """

    problem: ContactProblem = field(repr=False)
    forces: np.ndarray
    q: np.ndarray
    status: Status
    message: str
    nit: int
    solver: str
    seconds: float = 0.0
    history: tuple[float, ...] = ()
    scales: ResidualScales | None = None
    orientation: int = 1

    @property
    def success(self) -> bool:
        """Whether the solution is certified."""
        return self.status in (Status.SOLVED, Status.NO_CONTACT)

    @cached_property
    def gap(self) -> np.ndarray:
        """S l + g + B^T q, shape (n,)."""
        return self.problem.gap(self.forces, self.q)

    @cached_property
    def residuals(self) -> Residuals:
        """Residuals of forces and motion, recomputed from the problem."""
        return self.problem.residuals(self.forces, self.q, self.scales)

    @property
    def active(self) -> np.ndarray:
        """Points with a positive force, shape (n,), bool; a warm start for the next problem."""
        return self.forces > 0

    @cached_property
    def normal(self) -> Solution:
        """Solution of the normal forces alone, under the tangential forces found."""
        problem = self.problem
        return replace(
            self, problem=problem.normal_problem(self.forces), forces=self.forces[problem.normals],
            scales=problem.residual_scales(self.forces, self.q), orientation=1,
        )  # fmt: skip

    @property
    def tangential(self) -> np.ndarray:
        """Tangential forces of the points with friction, shape (f, k)."""
        return self.forces[self.problem.tangents]

    @cached_property
    def slip(self) -> np.ndarray:
        """Slip of the points with friction during the step, shape (f, k)."""
        return self.problem.slip(self.forces, self.q)

    @property
    def touching(self) -> np.ndarray:
        """Points with friction that have a force, shape (f,), bool; of infinite friction it may be a tangential one."""
        return np.asarray((self.forces[self.problem.points] > 0) | self.tangential.any(axis=1))

    @cached_property
    def sliding(self) -> np.ndarray:
        """Touching points on the rim of their cone, shape (f,), bool; the other touching ones stick."""
        return self.touching & ~sticks(self.tangential.T, self.problem.limit(self.forces))

    @property
    def friction_work(self) -> float:
        """Work of friction during the step, - sum t . s."""
        return -float((self.tangential * self.slip).sum())

    dissipated = renamed("dissipated", "friction_work")


def _array(name: str, value: object, ndim: int) -> np.ndarray:
    """Return a read-only float view of `value`, checked for its dimension and for finite entries."""
    try:
        array = np.asarray(value, dtype=float).view()
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be an array of numbers; found {type(value).__name__} ({error}).") from error
    if array.ndim != ndim:
        raise InputError(f"{name} must have {ndim} dimension(s); found shape {array.shape}.", code="dimensions")
    if not np.isfinite(array).all():
        raise InputError(f"{name} must be finite; found {int((~np.isfinite(array)).sum())} entries that are not.")
    array.flags.writeable = False
    return array


def _check_friction(S: object, n: int, points: np.ndarray, tangents: np.ndarray, mu: np.ndarray) -> None:
    """Refuse points with friction, their tangential rows or coefficients that do not fit a problem of n rows."""
    if not isinstance(S, np.ndarray | FrictionOperator):
        raise InputError("Friction needs the compliance as an array; found an operator. Form the array.")
    if points.ndim != 1 or tangents.ndim != 2 or tangents.shape[1] not in (1, 2) or len(points) != len(tangents):
        raise InputError(
            f"Expected points (f,) and tangents (f, 1) or (f, 2); found shapes {points.shape} and {tangents.shape}."
        )
    if mu.shape != points.shape:
        raise InputError(f"Expected one coefficient of friction per point, {points.shape}; found {mu.shape}.")
    if not (mu >= 0).all():
        raise InputError(f"A coefficient of friction is a number from 0 on, or inf; found {mu[~(mu >= 0)][0]!r}.")
    used = np.concatenate([points, tangents.ravel()])
    if len(used) and (used.min() < 0 or used.max() >= n or len(np.unique(used)) != len(used)):
        raise InputError(f"points and tangents must be different rows out of 0 to {n - 1}.")


def _check_compliance(S: np.ndarray) -> None:
    size = max(S.max(), -S.min())
    diagonal = S.diagonal()
    if diagonal.min() < -SYMMETRY_TOLERANCE * size:
        k = int(diagonal.argmin())
        raise InputError(
            f"S must be positive semidefinite; found the diagonal entry S[{k}, {k}] = {diagonal[k]:.3g}. "
            "A force must open the gap where it acts: check the sign of the coupling.",
            code="not-semidefinite",
        )
    # in strips: no second copy of a large S
    for first in range(0, len(S), 512):
        strip = slice(first, first + 512)
        difference = np.abs(S[strip, : first + 512] - S[: first + 512, strip].T)
        if difference.max() > SYMMETRY_TOLERANCE * size:
            i, k = (int(index) for index in np.unravel_index(int(difference.argmax()), difference.shape))
            raise InputError(
                f"S must be symmetric; found S[{first + i}, {k}] = {S[first + i, k]:.6g} and "
                f"S[{k}, {first + i}] = {S[k, first + i]:.6g}.",
                code="not-symmetric",
            )


def _sizes(values: np.ndarray, scale: float) -> np.ndarray:
    """Sizes of values over a scale, in place."""
    np.abs(values, out=values)
    return np.divide(values, scale, out=values) if scale > 0 else ratio(values, scale)


def _normal_residuals(forces: np.ndarray, gap: np.ndarray, scales: ResidualScales, unbalanced: float) -> Residuals:
    """Residuals of normal forces (n,) and gaps (n,), which are overwritten."""
    penetration = abs(float(ratio(np.minimum(gap.min(), 0.0), scales.gap)))
    # in place: of many points each new array takes as long as its arithmetic
    both = np.minimum(_sizes(forces.copy(), scales.force), _sizes(gap, scales.gap), out=gap)
    tension = abs(float(ratio(np.minimum(forces.min(), 0.0), scales.force)))
    return Residuals(penetration, tension, largest(both), unbalanced)


@dataclass(frozen=True, eq=False)
class Outcome:
    """Unverified answer of a solver.

    In scaled variables from the package's solvers, in those of the problem from a user's function.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Forces.
    p : ndarray, shape (r,)
        Multiplier of the equilibrium rows.
    status : Status
    message : str
    nit : int
        Iterations.
    history : list of float
    """

    x: np.ndarray
    p: np.ndarray
    status: Status
    message: str
    nit: int
    history: list[float] = field(default_factory=list)
