"""One Newton step of bodies in contact, a linearised contact problem.

    K d = r + G^T l + H^T s,    g + G d >= 0,    l >= 0,    l . (g + G d) = 0,    C d = -c

Unit forces along the rows give compliances S = G K^-1 G^T, and l follows from a complementarity problem (sequential
quadratic programming; Nocedal & Wright, Numerical Optimization, 2006, chapter 18). Equations C d = -c, whose forces s
act along H, are eliminated by their Schur complement. K has to be positive definite. Where a body is stable through
contact only, it is not, and w G^T (g + G d) of the active conditions is added to the forces. It vanishes with them, so
that the solution is the same (augmented Lagrangian, section 17.3 there).

Where supports leave rigid motions W free, they are held at as many coordinates P instead. Without load along W nothing
acts there, and the contact problem has the motions and their equilibrium as in scenes:

    K_P = K + P P^T,    d = K_P^-1 (r + G^T l) + W p,    W^T (r + G^T l) = 0

In a state under load turns are not quite free of forces; where d vanishes the residual does so too.

With friction, tangential rows T with their slip stand beside G (`slip.Slips`), and Coulomb's law is solved as in linear
scenes. Where bodies are stable only because slip would turn round, a drag on it is added, which vanishes with d.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fecontact.ancf.system.tangent import Tangent, UnstableError
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.solvers import ContactProblem, solve
from fecontact.solvers.coulomb import friction_limit, sticks, with_held_directions
from fecontact.solvers.friction import solve_friction

#: Resistance of the active conditions to free motions, relative to the largest, from which it is one.
RESISTED = 1e-6
#: Weights of active conditions in a tangent that is not positive definite without them, over the largest stiffness.
WEIGHTS = (1.0, 1e2, 1e4)
#: Drag on slip, relative to the stiffness, tried where friction slides and the tangent is not positive definite.
DRAGS = (1e-6, 1e-4, 1e-2, 1.0)
#: Singular values of equations, relative to the largest, of those that hold by themselves.
DEPENDENT = 1e-12


@dataclass(frozen=True, eq=False)
class Ties:
    """Equations that coordinates obey, at some coordinates.

    Attributes
    ----------
    rows : (e, n) csr_matrix
        Their derivative C.
    columns : (e, n) csr_matrix
        H, along which their forces act; C in statics.
    value : (e,) array
        c, zero where they hold.
    """

    rows: sp.csr_matrix
    columns: sp.csr_matrix
    value: Array

    def along(self, Z: sp.csr_matrix, jump: Array) -> Ties:
        """The same in the free directions Z, after a given change of the coordinates.

        What rounding leaves of equations that supports obey is no derivative: along it forces would be large.
        """

        def free(C: sp.csr_matrix) -> sp.csr_matrix:
            out = sp.csr_matrix(C @ Z)
            out.data[np.abs(out.data) <= DEPENDENT * np.abs(C.data).max(initial=0.0)] = 0.0
            return out

        return Ties(free(self.rows), free(self.columns), self.value + self.rows @ jump)


@dataclass(frozen=True, eq=False)
class ContactRows:
    """Contact conditions and, of those with friction, slip.

    Attributes
    ----------
    gap : (m,) array
    G : (m, n) csr_matrix
        Its gradient.
    points : (f,) int array
        Conditions with friction.
    mu : (f,) array
    slip : (2 f,) array
        Along the first tangents, then along the second.
    T : (2 f, n) csr_matrix
        Its gradient.
    guess : (m + 2 f,) array
        Forces along all these rows, from which the solver begins; none if they are zero.
    """

    gap: Array
    G: sp.csr_matrix
    points: IntArray
    mu: Array
    slip: Array
    T: sp.csr_matrix
    guess: Array

    @classmethod
    def frictionless(cls, gap: Array, G: sp.csr_matrix, guess: Array | None = None) -> ContactRows:
        """Conditions without friction."""
        none, rows = np.zeros(0), sp.csr_matrix((0, G.shape[1]))
        return cls(gap, G, np.zeros(0, np.int64), none, none, rows, np.zeros(len(gap)) if guess is None else guess)

    @cached_property
    def both(self) -> sp.csr_matrix:
        """Rows (m + 2 f, n) of G, then of T."""
        return sp.csr_matrix(sp.vstack([self.G, self.T])) if len(self.slip) else self.G

    @property
    def pressing(self) -> Mask:
        """Conditions (m,) that are active at first."""
        return self.guess[: len(self.gap)] > 0

    def sticking(self, forces: Array) -> Mask:
        """Which conditions with friction (f,) stick under forces (m + 2 f,)."""
        return sticks(forces[len(self.gap) :].reshape(2, -1), friction_limit(self.mu, forces[self.points]))


class Step(NamedTuple):
    """Change (n,) of the coordinates, forces (m + 2 f,) along contact rows and forces (e,) of equations."""

    change: Array
    forces: Array
    stresses: Array


def newton_step(
    tangent: Tangent, r: Array, rows: ContactRows, *, ties: Ties | None = None, motions: Array | None = None
) -> Step:
    """The step by a positive definite tangent.

    Parameters
    ----------
    tangent : Tangent
    r : (n,) array
        Residual forces, without those of contact and of equations.
    rows : ContactRows
    ties : Ties, optional
        Equations; the least forces where they hold by themselves.
    motions : (n, k) array, optional
        Rigid motions W that nothing but contact resists; the tangent holds them.

    Raises
    ------
    UnstableError
        If it is not positive definite, or no condition resists the motions.
    SolverError
        If the contact problem has no certified solution.

    Examples
    --------
    >>> K, G = sp.csr_matrix(np.diag([2.0, 4.0])), sp.csr_matrix(np.array([[0.0, 1.0]]))
    >>> rows = ContactRows.frictionless(np.array([0.5]), G)
    >>> change, forces, _ = newton_step(Tangent(K), np.array([1.0, -8.0]), rows)
    >>> change.round(12).tolist(), forces.round(12).tolist()
    ([0.5, -0.5], [6.0])
    >>> C, none = sp.csr_matrix([[1.0, 1.0]]), ContactRows.frictionless(np.zeros(0), sp.csr_matrix((0, 2)))
    >>> tied = newton_step(Tangent(sp.eye_array(2).tocsr()), np.array([3.0, 1.0]), none, ties=Ties(C, C, np.zeros(1)))
    >>> tied.change.round(12).tolist(), tied.stresses.round(12).tolist()
    ([1.0, -1.0], [-2.0])
    """
    m, n_motions = rows.both.shape[0], 0 if motions is None else motions.shape[1]
    if n_motions and not m:
        raise UnstableError("Nothing near resists the rigid motions that supports leave free.")
    along = rows.both
    if ties is not None:
        along = sp.csr_matrix(sp.vstack([rows.both, ties.columns]))
        # where the equations do not hold yet, only what they leave free need be positive definite
        tangent = tangent if tangent.order is not None else Tangent(tangent.K, symmetric=False)
    touched, u, X, every = tangent.responses(r, along)
    of_ties = np.zeros((along.shape[0] - m, 1 + m))
    if ties is not None:
        C, by = ties.rows[:, touched], X[:, m:]
        missing = np.column_stack([C @ u + ties.value, C @ X[:, :m]])
        of_ties = -np.linalg.pinv(C @ by, rcond=DEPENDENT) @ missing
        u, X = u + by @ of_ties[:, 0], X[:, :m] + by @ of_ties[:, 1:]
    forces, motion = np.zeros(m), np.zeros(n_motions)
    if m:
        rows_at = rows.both[:, touched]
        B, F = np.zeros((0, m)), np.zeros(0)
        if motions is not None:
            B, F = (rows.both @ motions).T, -(motions.T @ r)
        S = rows_at @ X
        start = np.concatenate([rows.gap, rows.slip]) + rows_at @ u
        forces, motion = _solution(ContactProblem((S + S.T) / 2, start, B, F), rows)
    stresses = of_ties[:, 0] + of_ties[:, 1:] @ forces
    change = every(np.concatenate([forces, stresses]))
    return Step(change if motions is None else change + motions @ motion, forces, stresses)


def _solution(problem: ContactProblem, rows: ContactRows) -> tuple[Array, Array]:
    """Forces along all rows, and the free motion."""
    if not len(rows.points):
        found = solve(problem)
        return found.forces, found.q
    tangents = len(rows.gap) + np.arange(len(rows.slip)).reshape(2, -1).T
    S = with_held_directions(problem.matrix, tangents, problem.B)
    begin = (rows.guess, np.zeros(problem.m)) if rows.guess.any() else None
    answer = solve_friction(replace(problem, S=S, points=rows.points, tangents=tangents, mu=rows.mu), begin)
    return answer.forces, answer.q


def stable_step(tangent: Tangent, r: Array, rows: ContactRows, loose: Array | None = None) -> Step:
    """The step by a tangent that may be positive definite with the active conditions, or with a drag on slip, only.

    Parameters
    ----------
    tangent, r, rows
        As in `newton_step`.
    loose : (n, k) array, optional
        Rigid motions that nothing but contact resists.

    Raises
    ------
    UnstableError
        If it is not positive definite even then.
    SolverError
        If the contact problem has no certified solution.
    """
    try:
        return _undragged(tangent, r, rows, loose)
    except UnstableError as error:
        if not rows.pressing[rows.points].any():
            raise
        drag, last = _drag(tangent.K, rows), error
    for share in DRAGS:
        try:
            return _undragged(tangent.plus(share * drag), r, rows, loose)
        except UnstableError as error:
            last = error
    raise last


def _undragged(tangent: Tangent, r: Array, rows: ContactRows, loose: Array | None) -> Step:
    """The step as it is or with the active conditions added, or held in free motions."""
    try:
        return newton_step(tangent, r, rows) if loose is None else _held(tangent, r, rows, loose)
    except UnstableError:
        if loose is not None:
            return _floating(tangent, r, rows, loose)
        if not rows.pressing.any():
            raise
    return _held(tangent, r, rows, np.zeros((len(r), 0)))


def _drag(K: sp.csr_matrix, contact: ContactRows) -> sp.csr_matrix:
    """Resistance (n, n) to the slip of active conditions, as stiff as K.

    Friction that slides on does not resist, and the stiffness of a string that runs round a pulley is nothing along
    itself: what is left of it, by the elements' functions, may be negative. A small drag is added to the steps; it
    vanishes with them (proximal point; R. T. Rockafellar, SIAM J. Control Optim. 14, 1976).
    """
    rows = sp.csr_matrix(contact.T[np.tile(contact.pressing[contact.points], 2)])
    return sp.csr_matrix(K.diagonal().max() / rows.power(2).sum(axis=1).max() * (rows.T @ rows))


def _held(tangent: Tangent, r: Array, contact: ContactRows, W: Array) -> Step:
    """The step with the active conditions added to the tangent, which have to resist the motions W.

    Conditions that open, and sticking ones that slide, must not be added.
    """
    pressing, sticking, m = contact.pressing, contact.sticking(contact.guess), len(contact.gap)
    while pressing.any():
        both = np.tile(sticking, 2)
        rows = sp.csr_matrix(sp.vstack([contact.G[pressing], contact.T[both]]))
        start = np.concatenate([contact.gap[pressing], contact.slip[both]])
        resisted = rows @ W
        if W.shape[1] and np.linalg.matrix_rank(resisted, RESISTED * np.abs(resisted).max()) < W.shape[1]:
            break
        found = _added(tangent, r, contact, rows, start)
        opening = pressing & (found.forces[:m] == 0)
        slipping = sticking & ~contact.sticking(found.forces)
        if not opening.any() and not slipping.any():
            return found
        pressing, sticking = pressing & ~opening, sticking & ~slipping
    raise UnstableError("The tangent stiffness is not positive definite, even with the active contacts.")


def _added(tangent: Tangent, r: Array, contact: ContactRows, rows: sp.csr_matrix, start: Array) -> Step:
    """The step with rows that stay closed added to the tangent, with a weight that makes it positive definite.

    There is one where K is so on what the rows leave free (P. Finsler, Comment. Math. Helv. 9, 1936): the larger, the
    more negative K is across, and the less the rows differ.
    """
    weight, last = tangent.K.diagonal().max() / rows.power(2).sum(axis=1).max(), UnstableError("")
    for factor in WEIGHTS:
        try:
            added = tangent.plus(factor * weight * (rows.T @ rows))
            return newton_step(added, r - factor * weight * (rows.T @ start), contact)
        except UnstableError as error:
            last = error
    raise last


def _floating(tangent: Tangent, r: Array, rows: ContactRows, W: Array) -> Step:
    """The step of bodies that are free in the motions W."""
    stiff = np.maximum(tangent.K.diagonal(), 0.0)
    # the coordinates at which springs as stiff as the body resist the motions most
    held = scipy.linalg.qr((W * np.sqrt(stiff)[:, None]).T, mode="r", pivoting=True)[1][: W.shape[1]]
    springs = np.zeros(len(r))
    springs[held] = stiff[held]
    return newton_step(tangent.plus(sp.diags_array(springs)), r, rows, motions=W)
