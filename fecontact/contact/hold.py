"""Closed gaps that hold bodies whose tangent is not positive definite.

Pressed bodies are often stable through their contact only (rubber from 25 % of compression on): their tangent, and with
it the compliance S of the problem, is not positive semidefinite. With springs w on the gaps y of rows a that are known
to stay closed, and forces l' = l + w y there, which are l where they are closed, the conditions y = S l + g + B^T q and
B l = F become those of

    S' = S - S_a (1/w + S_aa)^-1 S_a^T,   g' and B' likewise,   D q = B' l' - F - w B_a g'_a,   D = w B_a B'_a^T

(augmented Lagrangian; Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, section 17.3). Free motions q, which the
closed rows resist, are eliminated too. Bodies stay condensed one by one.

A tangent may be nearly singular too, and S then mostly rounding. Where only one of the bodies of each held row deforms,
its stiffness gets the springs before it is factorised: T = C (K + C_a^T w C_a)^-1 C^T is S' itself, and with the gaps
h = g + B^T q without deformation the springs, which act on whole gaps, load it by -w h_a:

    S' = T,   g' = g + r - T_a w g_a,   B'^T = B^T - T_a w B_a^T,   r the response of K + C_a^T w C_a to the loads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import SolverError
from fecontact.contact.interface import UnilateralConstraints

#: Springs over the median stiffness of the rows that they hold: far above that of bodies as a whole, and low enough to
#: lose few digits of what the springs leave of the compliance.
STRENGTH = 100.0
#: Shift, relative to the largest compliance, by which one with rounding is positive definite.
ROUNDING = 1e-10
#: Largest gap without compliance, relative to the largest one, that is rounding of the springs.
NO_GAP = 1e-8


class IndefiniteError(SolverError):
    """The compliance is not positive semidefinite, and the closed gaps that are known do not make it so."""

    code = "indefinite"


@dataclass(frozen=True, eq=False)
class Hold:
    """Slave nodes of the points of each contact that are closed, and of those that stick.

    They are known by nodes, as points are renumbered when surfaces are paired anew. `at_once`: whether bodies get their
    springs without a look at the compliance, as it was not semidefinite last time. `forces`: of the closed points, zero
    of those that stick, for `contact.turning`. `turns`: of each body, the stiffness (3, 3) by which forces of points
    that stick resist its rotations.
    """

    closed: Sequence[IntArray]
    stuck: Sequence[IntArray]
    at_once: bool = False
    forces: Sequence[Array] = ()
    turns: Sequence[Array] = ()

    def pressing(self, k: int, nodes: IntArray) -> Array:
        """Forces (n,) of points of contact k by their nodes."""
        out = np.zeros(len(nodes))
        if k < len(self.forces):
            _, mine, its = np.intersect1d(nodes, self.closed[k], return_indices=True)
            out[mine] = self.forces[k][its]
        return out

    def rows(self, interfaces: Sequence[UnilateralConstraints], chosen: Sequence[IntArray]) -> Mask:
        """Rows (n,) of the problem that are held, out of those chosen of contacts, springs and tangents."""
        # contacts come first
        closed = [*self.closed, *[np.zeros(0, np.int64)] * len(interfaces)]
        every = zip(interfaces, chosen, closed, strict=False)
        return np.concatenate([interface.held(rows, own, self.stuck) for interface, rows, own in every])

    def within(self, other: Hold) -> bool:
        """Whether all its points are among another's."""
        pairs = zip([*self.closed, *self.stuck], [*other.closed, *other.stuck], strict=True)
        return all(np.isin(mine, theirs).all() for mine, theirs in pairs)

    def common(self, other: Hold) -> Hold:
        """The points of both; what sticks is closed."""
        closed = [np.intersect1d(a, b) for a, b in zip(self.closed, other.closed, strict=True)]
        stuck = [np.intersect1d(a, b) for a, b in zip(self.stuck, other.stuck, strict=True)]
        return Hold(closed, [np.intersect1d(a, b) for a, b in zip(stuck, closed, strict=True)], self.at_once)

    def same(self, other: Hold) -> bool:
        """Whether both are the same points."""
        return self.within(other) and other.within(self)


@dataclass(frozen=True, eq=False)
class Held:
    """A problem with held rows: `S`, `g`, `B`, `F`, and its eliminated motions as a function of the forces."""

    S: Array
    g: Array
    B: Array
    F: Array
    motions: Callable[[Array], Array]


def held(S: Array, g: Array, B: Array, F: Array, rows: Mask, stiffness: Array | float = 0.0) -> Held:
    """The problem with held rows (n,), of a compliance that is not positive semidefinite.

    `stiffness` (m, m) resists the free motions: B l = F + stiffness q.

    Raises
    ------
    IndefiniteError
        If it is not so with them either.
    """
    a = np.flatnonzero(rows)
    if not len(a):
        raise _indefinite()
    w = STRENGTH / float(np.median(np.abs(S.diagonal()[a])))
    inner = np.linalg.inv(np.eye(len(a)) / w + S[np.ix_(a, a)])

    def less(X: Array) -> Array:
        return np.asarray(X - S[:, a] @ (inner @ X[a]))

    S1, g1, B1 = less(S), less(g), less(B.T).T
    springs = np.where(rows, w, 0.0)
    return _without_motions((S1 + S1.T) / 2, g1, B1, B * springs, F, stiffness)


def held_inside(
    T: Array, g: Array, response: Array, B: Array, F: Array, springs: Array, stiffness: Array | float = 0.0
) -> Held:
    """The problem with springs (n,) inside the bodies, zero where no row is held: T and the response have them.

    Raises
    ------
    IndefiniteError
        If T is not positive semidefinite.
    """
    pulled = T * springs
    return _without_motions(T, g + response - pulled @ g, B - B @ pulled.T, B * springs, F, stiffness)


def _without_motions(S1: Array, g1: Array, B1: Array, Bw: Array, F: Array, stiffness: Array | float) -> Held:
    """The held problem S', g', B' without its free motions; Bw is B with springs."""
    if not len(F):
        return Held(*_without_rounding(S1, g1), B1, F, lambda forces: np.zeros(0))
    D = Bw @ B1.T + stiffness
    load = F + Bw @ g1
    try:
        factor = scipy.linalg.cho_factor((D + D.T) / 2)
    except np.linalg.LinAlgError as error:
        raise _indefinite() from error
    S2 = S1 + B1.T @ scipy.linalg.cho_solve(factor, B1)
    g2 = g1 - B1.T @ scipy.linalg.cho_solve(factor, load)
    none = np.zeros((0, len(g1))), np.zeros(0)
    S2, g2 = _without_rounding((S2 + S2.T) / 2, g2)
    return Held(S2, g2, *none, lambda forces: scipy.linalg.cho_solve(factor, B1 @ forces - load))


def _without_rounding(S: Array, g: Array) -> tuple[Array, Array]:
    """S and g without their rounding along forces that move nothing.

    Such are forces along a row of points of which supports leave one motion, as across a body one cell thick. Springs
    leave them a compliance and gaps by rounding, of the size of what they have taken away, which no force closes.

    Raises
    ------
    IndefiniteError
        If S is not positive semidefinite.
    """
    if not semidefinite(S):
        raise _indefinite()
    rows = np.flatnonzero(S.diagonal() > 0)
    root = np.sqrt(S.diagonal()[rows])
    scaled = S[np.ix_(rows, rows)] / root / root[:, None]
    if scipy.linalg.lapack.dpotrf(scaled - ROUNDING * np.eye(len(rows)))[1] == 0:
        return S, g
    values, axes = np.linalg.eigh(scaled)
    none = axes[:, values <= ROUNDING * values[-1]]
    gaps = none.T @ (g[rows] / root)
    gaps[np.abs(gaps) > NO_GAP * np.abs(g[rows] / root).max()] = 0.0
    S, g = S.copy(), g.copy()
    moving = axes * np.where(values <= ROUNDING * values[-1], 0.0, values)
    kept = moving @ axes.T * root * root[:, None]
    S[np.ix_(rows, rows)] = (kept + kept.T) / 2
    g[rows] -= (none @ gaps) * root
    return S, g


def semidefinite(S: Array) -> bool:
    """Whether a symmetric matrix is positive semidefinite up to rounding, in any scale of its rows."""
    size = np.abs(S.diagonal())
    if (S.diagonal() < -ROUNDING * size.max(initial=0.0)).any():
        return False
    root = np.sqrt(np.maximum(size, np.finfo(float).tiny))
    scaled = S / root / root[:, None]
    scaled[np.diag_indices_from(scaled)] += ROUNDING * len(S)
    return bool(scipy.linalg.lapack.dpotrf(scaled, overwrite_a=1)[1] == 0)


def _indefinite() -> IndefiniteError:
    return IndefiniteError("The bodies are not stable at this state, even with their contact: take a smaller step.")
