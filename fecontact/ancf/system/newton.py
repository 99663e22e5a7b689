"""One Newton step of bodies in contact, a linearised contact problem.

    K d = r + G^T l,    g + G d >= 0,    l >= 0,    l . (g + G d) = 0

K is condensed onto the coordinates in the conditions, and l follows from a complementarity problem with S = G K^-1 G^T
(sequential quadratic programming; Nocedal & Wright, Numerical Optimization, 2006, chapter 18). K has to be positive
definite. Where a body is stable through contact only, it is not, and w G^T (g + G d) of the active conditions is added
to the forces. It vanishes with them, so that the solution is the same (augmented Lagrangian, section 17.3 there).

Where supports leave rigid motions W free, they are held at as many coordinates P instead. Without load along W nothing
acts there, and the contact problem has the motions and their equilibrium as in scenes:

    K_P = K + P P^T,    d = K_P^-1 (r + G^T l) + W p,    W^T (r + G^T l) = 0

In a state under load turns are not quite free of forces; where d vanishes the residual does so too.

With friction, tangential rows T with their slip stand beside G (`slip.Slips`), and Coulomb's law is solved as in linear
scenes. Where bodies are stable only because slip would turn round, a drag on it is added, which vanishes with d.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.sparse.csgraph import connected_components

from fecontact.ancf.system.banded import BandFactor, BandOrder
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import FecontactError
from fecontact.fem.factor import condense
from fecontact.solvers import ComplementarityProblem, solve
from fecontact.solvers.friction import solve_friction
from fecontact.solvers.friction_problem import ON_CONE, FrictionProblem, friction_limit

#: Coordinates up to which a dense solution is faster than a sparse one.
SMALL = 300
#: Resistance of the active conditions to free motions, relative to the largest, from which it is one.
RESISTED = 1e-6
#: Weights of active conditions in a tangent that is not positive definite without them, over the largest stiffness.
WEIGHTS = (1.0, 1e2, 1e4)
#: Drag on slip, relative to the stiffness, tried where friction slides and the tangent is not positive definite.
DRAGS = (1e-6, 1e-4, 1e-2, 1.0)
#: Largest difference from the transpose, relative to the largest entry, that is rounding.
SYMMETRIC = 1e-12
#: Singular values of equations, relative to the largest, of those that hold by themselves.
DEPENDENT = 1e-12


class UnstableError(FecontactError):
    """The tangent is not positive definite: the state is not a stable one, or the step was too long."""

    code = "unstable"


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
        """The same in the free directions Z, after a given change of the coordinates."""
        return Ties(sp.csr_matrix(self.rows @ Z), sp.csr_matrix(self.columns @ Z), self.value + self.rows @ jump)


@dataclass(frozen=True, eq=False)
class TangentialRows:
    """Tangential rows of conditions with friction.

    Attributes
    ----------
    points : (f,) int array
        Their conditions.
    mu : (f,) array
    T : (2 f, n) csr_matrix
        Gradient of the slip along the first tangents, then along the second.
    slip : (2 f,) array
    guess : (m + 2 f,) array
        Forces of all conditions, then of these rows, from which the solver begins; none if they are zero.
    """

    points: IntArray
    mu: Array
    T: sp.csr_matrix
    slip: Array
    guess: Array

    def sticking(self, forces: Array) -> Mask:
        """Which conditions (f,) stick under forces (m + 2 f,) of all conditions, then of these rows."""
        t = np.linalg.norm(forces[len(forces) - len(self.slip) :].reshape(2, -1), axis=0)
        return np.asarray(t < (1 - ON_CONE) * friction_limit(self.mu, forces[self.points]))


def contact_step(
    K: sp.csr_matrix,
    r: Array,
    G: sp.csr_matrix,
    gap: Array,
    pressing: Mask | None = None,
    friction: TangentialRows | None = None,
    loose: Array | None = None,
    order: BandOrder | None = None,
) -> tuple[Array, Array, Array]:
    """Change of the coordinates, contact forces and tangential forces.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Symmetric positive definite, but for free motions.
    r : (n,) array
        Residual forces, without those of contact.
    G : (m, n) csr_matrix
    gap : (m,) array
    pressing : (m,) bool array, optional
        Conditions known to be active.
    friction : TangentialRows, optional
    loose : (n, k) array, optional
        Rigid motions W that nothing but contact resists.
    order : BandOrder, optional
        Of the pattern of K, where its band is narrow.

    Returns
    -------
    change : (n,) array
    forces : (m,) array
    tangential : (2 f,) array

    Raises
    ------
    UnstableError
        If K is not positive definite, even with the active conditions added.
    SolverError
        If the contact problem has no certified solution.

    Examples
    --------
    >>> import numpy as np, scipy.sparse as sp
    >>> K, G = sp.csr_matrix(np.diag([2.0, 4.0])), sp.csr_matrix(np.array([[0.0, 1.0]]))
    >>> change, forces, _ = contact_step(K, np.array([1.0, -8.0]), G, np.array([0.5]))
    >>> change.round(12).tolist(), forces.round(12).tolist()
    ([0.5, -0.5], [6.0])
    """
    rows = G.shape[0] + (0 if friction is None else friction.T.shape[0])
    if loose is None and not rows and (order is not None or len(r) <= SMALL):
        return _plain(K, r, order), np.zeros(0), np.zeros(0)
    pressing = np.zeros(len(gap), bool) if pressing is None else pressing
    try:
        return _stable(K, r, G, gap, pressing, friction, loose, order)
    except UnstableError:
        if friction is None or not pressing[friction.points].any():
            raise
    drag = _drag(K, friction, pressing)
    for share in DRAGS[:-1]:
        try:
            return _stable(sp.csr_matrix(K + share * drag), r, G, gap, pressing, friction, loose, None)
        except UnstableError:
            pass
    return _stable(sp.csr_matrix(K + DRAGS[-1] * drag), r, G, gap, pressing, friction, loose, None)


def _drag(K: sp.csr_matrix, friction: TangentialRows, pressing: Mask) -> sp.csr_matrix:
    """Resistance (n, n) to the slip of active conditions, as stiff as K.

    Friction that slides on does not resist, and the stiffness of a string that runs round a pulley is nothing along
    itself: what is left of it, by the elements' functions, may be negative. A small drag is added to the steps; it
    vanishes with them (proximal point; R. T. Rockafellar, SIAM J. Control Optim. 14, 1976).
    """
    rows = sp.csr_matrix(friction.T[np.tile(pressing[friction.points], 2)])
    return sp.csr_matrix(K.diagonal().max() / rows.power(2).sum(axis=1).max() * (rows.T @ rows))


def _stable(
    K: sp.csr_matrix,
    r: Array,
    G: sp.csr_matrix,
    gap: Array,
    pressing: Mask,
    friction: TangentialRows | None,
    loose: Array | None,
    order: BandOrder | None,
) -> tuple[Array, Array, Array]:
    """The step where K is positive definite, with the active conditions or held in free motions if need be."""
    try:
        if loose is None:
            return _solved(K, r, G, gap, friction, order=order)
        return _held(K, r, G, gap, friction, pressing, loose)
    except UnstableError:
        if loose is not None:
            return _floating(K, r, G, gap, friction, loose)
        if not pressing.any():
            raise
    return _held(K, r, G, gap, friction, pressing, np.zeros((len(r), 0)))


def _held(
    K: sp.csr_matrix,
    r: Array,
    G: sp.csr_matrix,
    gap: Array,
    friction: TangentialRows | None,
    pressing: Mask,
    W: Array,
) -> tuple[Array, Array, Array]:
    """The step with the active conditions added to K, which have to resist the motions W.

    Conditions that open, and sticking ones that slide, must not be added.
    """
    sticking = np.zeros(0, bool) if friction is None else friction.sticking(friction.guess)
    while pressing.any():
        rows, start = sp.csr_matrix(G[pressing]), gap[pressing]
        if friction is not None and sticking.any():
            both = np.tile(sticking, 2)
            rows = sp.csr_matrix(sp.vstack([rows, friction.T[both]]))
            start = np.concatenate([start, friction.slip[both]])
        resisted = rows @ W
        if W.shape[1] and np.linalg.matrix_rank(resisted, RESISTED * np.abs(resisted).max()) < W.shape[1]:
            break
        found = _added(K, r, G, gap, friction, rows, start)
        opening = pressing & (found[1] == 0)
        slipping = sticking if friction is None else sticking & ~friction.sticking(np.concatenate(found[1:]))
        if not opening.any() and not slipping.any():
            return found
        pressing, sticking = pressing & ~opening, sticking & ~slipping
    raise UnstableError("The tangent stiffness is not positive definite, even with the active contacts.")


def _added(
    K: sp.csr_matrix,
    r: Array,
    G: sp.csr_matrix,
    gap: Array,
    friction: TangentialRows | None,
    rows: sp.csr_matrix,
    start: Array,
) -> tuple[Array, Array, Array]:
    """The step with rows that stay closed added to K, with a weight that makes it positive definite.

    There is one where K is so on what the rows leave free (P. Finsler, Comment. Math. Helv. 9, 1936): the larger, the
    more negative K is across, and the less the rows differ.
    """
    weight, last = K.diagonal().max() / rows.power(2).sum(axis=1).max(), UnstableError("")
    for factor in WEIGHTS:
        added = sp.csr_matrix(K + factor * weight * (rows.T @ rows))
        try:
            return _solved(added, r - factor * weight * (rows.T @ start), G, gap, friction)
        except UnstableError as error:
            last = error
    raise last


def _plain(K: sp.csr_matrix, r: Array, order: BandOrder | None) -> Array:
    """K^-1 r without contact, by a band or of a few coordinates."""
    try:
        if order is not None:
            return order.factor(K.data).solve(r[:, None])[:, 0]
        return np.asarray(scipy.linalg.solve(K.toarray(), r, assume_a="pos", check_finite=False))
    except np.linalg.LinAlgError as error:
        raise UnstableError("The tangent stiffness is not positive definite.") from error


def _floating(
    K: sp.csr_matrix, r: Array, G: sp.csr_matrix, gap: Array, friction: TangentialRows | None, W: Array
) -> tuple[Array, Array, Array]:
    """The step of bodies that are free in the motions W."""
    stiff = np.maximum(K.diagonal(), 0.0)
    # the coordinates at which springs as stiff as the body resist the motions most
    held = scipy.linalg.qr((W * np.sqrt(stiff)[:, None]).T, mode="r", pivoting=True)[1][: W.shape[1]]
    springs = np.zeros(len(r))
    springs[held] = stiff[held]
    return _solved(sp.csr_matrix(K + sp.diags_array(springs)), r, G, gap, friction, W)


def _solved(
    K: sp.csr_matrix,
    r: Array,
    G: sp.csr_matrix,
    gap: Array,
    friction: TangentialRows | None,
    W: Array | None = None,
    order: BandOrder | None = None,
) -> tuple[Array, Array, Array]:
    rows, start = G, gap
    if friction is not None:
        rows, start = sp.csr_matrix(sp.vstack([G, friction.T])), np.concatenate([gap, friction.slip])
    if order is None and not (K.diagonal() > 0).all():
        raise UnstableError("The tangent stiffness has a diagonal entry that is not positive.")
    try:
        u, X, expand = _condensed(K, r, rows) if order is None else _by_band(K, r, rows, order)
    except (FecontactError, np.linalg.LinAlgError) as error:
        raise UnstableError("The tangent stiffness is not positive definite.") from error
    forces = np.zeros(rows.shape[0])
    if rows.shape[0]:
        C = rows[:, np.unique(rows.indices)].toarray()
        S = C @ X
        B = np.zeros((0, len(S))) if W is None else (rows @ W).T
        F = np.zeros(0) if W is None else -(W.T @ r)
        forces, motion = _forces(ComplementarityProblem((S + S.T) / 2, start + C @ u, B, F), friction)
    change = expand(forces)
    change = change if W is None else change + W @ motion
    return change, forces[: G.shape[0]], forces[G.shape[0] :]


#: Displacements u of the touched coordinates by loads, X by unit forces of the rows, and all by given forces.
Responses = tuple[Array, Array, Callable[[Array], Array]]


def _condensed(K: sp.csr_matrix, r: Array, rows: sp.csr_matrix) -> Responses:
    """By condensation onto the touched coordinates."""
    touched = np.unique(rows.indices) if rows.nnz else np.zeros(1, dtype=np.int64)
    condensed = condense(sp.csr_matrix(sp.triu(K)), touched.astype(np.int64))
    factor = scipy.linalg.cho_factor(condensed.stiffness, lower=True)
    load = r[:, None]
    u = scipy.linalg.cho_solve(factor, condensed.reduce(load))
    X = scipy.linalg.cho_solve(factor, rows[:, touched].toarray().T)
    return u[:, 0], X, lambda forces: condensed.expand(u + X @ forces[:, None], load)[:, 0]


def _by_band(K: sp.csr_matrix, r: Array, rows: sp.csr_matrix, order: BandOrder) -> Responses:
    """By the factor of a band, for all coordinates."""
    both = order.factor(K.data).solve(np.column_stack([r, rows.T.toarray()]))
    u, X, touched = both[:, 0], both[:, 1:], np.unique(rows.indices)
    return u[touched], X[touched], lambda forces: u + X @ forces


def tied_step(
    K: sp.csr_matrix,
    r: Array,
    G: sp.csr_matrix,
    gap: Array,
    ties: Ties,
    friction: TangentialRows | None = None,
    order: BandOrder | None = None,
    factor: BandFactor | None = None,
) -> tuple[Array, Array, Array, Array]:
    """A Newton step under equations, which are eliminated by their Schur complement.

        K d = r + G^T l + H^T s,    C d = -c

    Parameters
    ----------
    K, r, G, gap, friction, order
        As in `contact_step`; K is positive definite without the equations.
    ties : Ties
    factor : BandFactor, optional
        Of K, or of a matrix near it.

    Returns
    -------
    change : (n,) array
    forces : (m,) array
    tangential : (2 f,) array
    multipliers : (e,) array
        s; the least where equations hold by themselves.

    Raises
    ------
    UnstableError
        If K is not positive definite.
    SolverError
        If the contact problem has no certified solution.

    Examples
    --------
    >>> import numpy as np, scipy.sparse as sp
    >>> K, none = sp.eye_array(2, format="csr"), sp.csr_matrix((0, 2))
    >>> C = sp.csr_matrix([[1.0, 1.0]])
    >>> change, _, _, s = tied_step(K, np.array([3.0, 1.0]), none, np.zeros(0), Ties(C, C, np.zeros(1)))
    >>> change.round(12).tolist(), s.round(12).tolist()
    ([1.0, -1.0], [-2.0])
    """
    rows, start = G, gap
    if friction is not None:
        rows, start = sp.csr_matrix(sp.vstack([G, friction.T])), np.concatenate([gap, friction.slip])
    m = rows.shape[0]
    loads = np.column_stack([r, rows.T.toarray(), ties.columns.T.toarray()])
    try:
        if factor is None and order is not None:
            factor = order.factor(K.data)
        every = _by_lu(K).solve(loads) if factor is None else factor.solve(loads)
    except np.linalg.LinAlgError as error:
        raise UnstableError("The tangent stiffness is not positive definite.") from error
    free, by_ties = every[:, : 1 + m], every[:, 1 + m :]
    missing = ties.rows @ free
    missing[:, 0] += ties.value
    s = -np.linalg.pinv(ties.rows @ by_ties, rcond=DEPENDENT) @ missing
    u, *X = (free + by_ties @ s).T
    forces = np.zeros(m)
    if m:
        S = rows @ np.array(X).T
        problem = ComplementarityProblem((S + S.T) / 2, start + rows @ u, np.zeros((0, m)), np.zeros(0))
        forces, _ = _forces(problem, friction)
        u = u + forces @ np.array(X)
    return u, forces[: G.shape[0]], forces[G.shape[0] :], s[:, 0] + s[:, 1:] @ forces


def _forces(problem: ComplementarityProblem, friction: TangentialRows | None) -> tuple[Array, Array]:
    """Forces (N,) of all rows, and the free motion."""
    if friction is None or not len(friction.points):
        found = solve(problem)
        return found.forces, found.q
    S = np.array(problem.S)
    tangents = problem.n - len(friction.slip) + np.arange(len(friction.slip)).reshape(2, -1).T
    # a direction that is held has no compliance, and no force as long as nothing drags along it
    held = tangents[S[tangents, tangents] == 0]
    S[held, held] = S.diagonal().mean()
    every = ComplementarityProblem(S, problem.g, problem.B, problem.F)
    begin = (friction.guess, np.zeros(problem.m)) if friction.guess.any() else None
    answer = solve_friction(FrictionProblem(every, friction.points, tangents, friction.mu), begin)
    return answer.forces, answer.q


def is_symmetric(K: sp.csr_matrix) -> bool:
    """Whether K is symmetric but for rounding."""
    return bool(abs(K - K.T).max() <= SYMMETRIC * abs(K).max())


def unsymmetric_step(K: sp.csr_matrix, r: Array) -> Array:
    """K^-1 r without contact, for loads without a potential.

    Their stability has no energy to be judged by. A real eigenvalue that becomes negative, a buckling, changes the sign
    of the determinant; flutter is not noticed.

    Raises
    ------
    UnstableError
        If det K <= 0.

    Examples
    --------
    >>> import scipy.sparse as sp
    >>> unsymmetric_step(sp.csr_matrix([[2.0, 1.0], [0.0, 1.0]]), np.array([4.0, 2.0])).tolist()
    [1.0, 2.0]
    """
    return np.asarray(_by_lu(K).solve(r))


def _by_lu(K: sp.csr_matrix) -> spla.SuperLU:
    """Factor of a matrix with a positive determinant."""
    try:
        factor = spla.splu(sp.csc_matrix(K))
    except RuntimeError as error:
        raise UnstableError("The tangent stiffness is singular.") from error
    negative = np.count_nonzero(factor.U.diagonal() < 0) + _swaps(factor.perm_r) + _swaps(factor.perm_c)
    if negative % 2:
        raise UnstableError("The tangent stiffness has a negative determinant.")
    return factor


def _swaps(order: IntArray) -> int:
    """Number of exchanges that make up a permutation: its length less the number of its cycles."""
    n = len(order)
    cycles = sp.csr_matrix((np.ones(n), (np.arange(n), order)), shape=(n, n))
    return int(n - connected_components(cycles, directed=False)[0])
