"""Nondimensional form of a complementarity problem: unit diagonal, orthonormal rows, data of order one.

The solvers see only this form, so that one set of tolerances serves SI units (compliances of 1e-12, gaps of 1e-6) and
rows that differ by sixteen orders of magnitude.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.optimize import nnls
from scipy.sparse.linalg import LinearOperator

ZERO_ROW = 1e-14
"""Norm of a row of B, relative to the largest, below which it is a rounding residue."""

DEPENDENT_ROW = 1e-11
"""Singular value of the normalised rows below which they are linearly dependent."""

UNBALANCED = 1e-10
"""Share of the load that may stay unbalanced when no forces l >= 0 balance it exactly."""


ROUNDING = 1e-13
"""Size of a force or a gap, relative to the largest of its solve, below which its sign is rounding."""

SMALLEST = 1e-15
"""The same, relative to the data of order one."""

NO_FORCE = 1e-13
"""Size below which forces are rounding where there is no load."""


class ContactRows:
    """Compliance S, gaps g, equilibrium rows B and tangential rows of a problem, in its own units or nondimensional."""

    S: np.ndarray | LinearOperator
    g: np.ndarray
    B: np.ndarray
    tangents: np.ndarray

    @property
    def n(self) -> int:
        """Number of rows: of points, without friction."""
        return int(self.g.size)

    @property
    def matrix(self) -> np.ndarray:
        """S as an array; TypeError for an operator."""
        if not isinstance(self.S, np.ndarray):
            raise TypeError("the compliance is an operator, not an array")
        return self.S

    @cached_property
    def normals(self) -> np.ndarray:
        """Normal rows of all points, with friction or without."""
        return np.setdiff1d(np.arange(self.n), self.tangents)

    def gap(self, forces: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Gap w = S l + g + B^T q, shape (n,), of forces (n,) and motions q (m,)."""
        return np.asarray(self.S @ forces + self.g + self.B.T @ q)


@dataclass(frozen=True, eq=False)
class ScaledProblem(ContactRows):
    """Problem in x, with l = force_scale * x and q = motion_map @ p.

        w / gap_scale = S x + g + B^T p,    B x = F

    Parameters
    ----------
    S : ndarray, shape (n, n), or LinearOperator
        Unit diagonal (an operator: only its mean diagonal is one).
    g : ndarray, shape (n,)
    B : ndarray, shape (r, n)
        Orthonormal rows, r the rank of the rows given.
    F : ndarray, shape (r,)
    force_scale, gap_scale : ndarray, shape (n,)
    motion_map : ndarray, shape (m, r)
    inconsistency : ndarray, shape (m,)
        Zero, or a direction y with B^T y = 0 and F . y < 0: dependent rows whose loads contradict each other.
    points, tangents, mu
        Of friction, as in a `ContactProblem`.
    slides : (f,) bool array
        Points with friction that are given to slide.
    """

    S: np.ndarray | LinearOperator
    g: np.ndarray
    B: np.ndarray
    F: np.ndarray
    force_scale: np.ndarray
    gap_scale: np.ndarray
    motion_map: np.ndarray
    inconsistency: np.ndarray
    points: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    tangents: np.ndarray = field(default_factory=lambda: np.empty((0, 1), dtype=np.int64))
    mu: np.ndarray = field(default_factory=lambda: np.empty(0))
    slides: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=bool))

    @property
    def r(self) -> int:
        """Number of independent equilibrium rows."""
        return int(self.F.size)

    def forces(self, x: np.ndarray) -> np.ndarray:
        """Return the forces of x, shape (n,)."""
        return self.force_scale * x

    def motion(self, p: np.ndarray) -> np.ndarray:
        """Return the multiplier q of p, shape (m,); of least norm where it is not unique."""
        return self.motion_map @ p

    def rounding_of(self, x: np.ndarray) -> float:
        """Return the size below which entries of x are rounding."""
        return max(ROUNDING * float(np.abs(x).max(initial=0.0)), SMALLEST if self.F.any() else NO_FORCE)

    def gap_and_rounding(self, x: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the nondimensional gap, shape (n,), and the size below which its entries are rounding."""
        deflection = np.asarray(self.S @ x)
        motion = self.B.T @ p
        rigid = self.g + motion
        scale = max(float(np.abs(deflection).max()), float(np.abs(rigid).max()))
        return deflection + rigid, ROUNDING * scale + SMALLEST * max(1.0, float(np.abs(motion).max()))

    def free_direction(self) -> np.ndarray | None:
        """Motion (m,) along which the load does work and no point resists, or None if the load can be balanced.

        Returns
        -------
        ndarray or None
            y with B^T y >= 0 and F . y < 0, of unit norm. The residual of the non-negative least-squares
            problem B x = F is that direction (Farkas' lemma; Lawson & Hanson 1974, chapter 23).
        """
        if self.inconsistency.any():
            return self.inconsistency
        if not self.F.any():
            return None
        x, distance = nnls(self.B, self.F, maxiter=30 * self.n + 100)
        if distance <= UNBALANCED * float(np.linalg.norm(self.F)):
            return None
        direction = self.motion(self.B @ x - self.F)
        return direction / float(np.linalg.norm(direction))


@runtime_checkable
class SizedOperator(Protocol):
    """A compliance operator that knows its size without a product."""

    def mean_diagonal(self) -> float:
        """Mean of its diagonal, about; positive."""


def scale(
    S: np.ndarray | LinearOperator,
    g: np.ndarray,
    B: np.ndarray,
    F: np.ndarray,
    friction: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
) -> ScaledProblem:
    """Nondimensional form of a problem.

    Parameters
    ----------
    S : ndarray, shape (n, n), or LinearOperator
    g : ndarray, shape (n,)
    B : ndarray, shape (m, n)
    F : ndarray, shape (m,)
    friction : (points, tangents, mu), optional
        As in a `ContactProblem`. The rows of a point have one scale, that of their mean diagonal: they are components
        of a vector.

    Returns
    -------
    ScaledProblem

    Examples
    --------
    >>> import numpy as np
    >>> scaled = scale(np.diag([1e-8, 1e8]), np.array([0.0, -1.0]), np.array([[1.0, 1.0], [2.0, 2.0]]), np.ones(2) * 0)
    >>> scaled.r, scaled.S.tolist()
    (1, [[1.0, 0.0], [0.0, 1.0]])
    """
    diagonal = _diagonal(S, len(g))
    if friction is not None:
        together = np.concatenate([friction[0][:, None], friction[1]], axis=1)
        diagonal[together] = diagonal[together].mean(axis=1, keepdims=True)
    d = 1.0 / np.sqrt(diagonal)
    rows, loads, to_rows, inconsistency = _orthonormal_rows(B * d, F)
    gaps = g * d
    unit = max(float(np.abs(gaps).max()), float(np.abs(loads).max(initial=0.0)))
    unit = unit if unit > 0 else 1.0
    points = {} if friction is None else dict(zip(("points", "tangents", "mu"), friction, strict=True))
    if friction is not None:
        points["slides"] = np.zeros(len(friction[2]), dtype=bool)
    return ScaledProblem(
        S=_scaled_compliance(S, d),
        g=gaps / unit,
        B=rows,
        F=loads / unit,
        force_scale=d * unit,
        gap_scale=unit / d,
        motion_map=to_rows * unit,
        inconsistency=inconsistency,
        **points,
    )


def _diagonal(S: np.ndarray | LinearOperator, n: int) -> np.ndarray:
    """Return the diagonal of S (n,), made positive so that no scaled entry exceeds one."""
    if isinstance(S, SizedOperator):
        return np.full(n, S.mean_diagonal())
    if not isinstance(S, np.ndarray):
        # mean diagonal by one Hutchinson probe: the entries of an operator are not available
        probe = np.where(np.random.default_rng(0).random(n) < 0.5, -1.0, 1.0)
        mean = float(probe @ (S @ probe)) / n
        return np.full(n, mean if mean > 0 else 1.0)
    diagonal = np.array(S.diagonal())
    positive = diagonal > 0
    if not positive.any():
        return np.ones(n)
    if not positive.all():
        diagonal[~positive] = np.exp(np.log(diagonal[positive]).mean())
    return diagonal


def _scaled_compliance(S: np.ndarray | LinearOperator, d: np.ndarray) -> np.ndarray | LinearOperator:
    if isinstance(S, np.ndarray):
        scaled = S * d
        scaled *= d[:, None]
        return scaled
    operator = S
    return LinearOperator(S.shape, matvec=lambda x: d * (operator @ (d * np.ravel(x))), dtype=float)


def _orthonormal_rows(B: np.ndarray, F: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return orthonormal rows (r, n) with their loads (r,), the map (m, r) of their multipliers, and a contradiction.

    Rows are normalised first: forces and moments have different units, and their rank must not depend on them.
    """
    m = len(F)
    norms = np.linalg.norm(B, axis=1)
    norms = np.where(norms > ZERO_ROW * norms.max(initial=0.0), norms, np.inf)
    U, s, V = np.linalg.svd(B / norms[:, None], full_matrices=False) if m else (np.eye(0), np.empty(0), B)
    rank = int((s > DEPENDENT_ROW * s.max(initial=0.0)).sum())
    U, s, V = U[:, :rank], s[:rank], V[:rank]
    # zero rows keep their load unscaled: it must be zero too, compared with the others
    finite = np.isfinite(norms)
    loads = F / np.where(finite, norms, norms[finite].max(initial=0.0) or 1.0)
    left = loads - U @ (U.T @ loads)
    inconsistent = np.linalg.norm(left) > UNBALANCED * np.linalg.norm(loads)
    direction = -left / np.where(finite, norms, 1.0) if inconsistent else np.zeros(m)
    if inconsistent:
        direction /= np.linalg.norm(direction)
    return V, (U.T @ loads) / s, (U / s) / norms[:, None], direction
