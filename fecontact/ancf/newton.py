"""One Newton step of bodies in contact, a linearised contact problem.

    K d = r + G^T l,    g + G d >= 0,    l >= 0,    l . (g + G d) = 0

K is condensed onto the coordinates in the conditions, and l follows from a complementarity problem with S = G K^-1 G^T
(sequential quadratic programming; Nocedal & Wright, Numerical Optimization, 2006, chapter 18). K has to be positive
definite. Where a body is stable through contact only, it is not, and a multiple of G^T G of the active conditions is
added to it. With G d = -g this only shifts l and the solution is the same (augmented Lagrangian, section 17.3 there).
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.sparse.csgraph import connected_components

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import FecontactError
from fecontact.fem.factor import condense
from fecontact.solvers import ComplementarityProblem, solve

#: Coordinates up to which a dense solution is faster than a sparse one.
SMALL = 300
#: Largest difference from the transpose, relative to the largest entry, that is rounding.
SYMMETRIC = 1e-12


class UnstableError(FecontactError):
    """The tangent is not positive definite: the state is not a stable one, or the step was too long."""


def contact_step(
    K: sp.csr_matrix, r: Array, G: sp.csr_matrix, gap: Array, pressing: Mask | None = None
) -> tuple[Array, Array]:
    """Change of the coordinates and contact forces.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Symmetric positive definite.
    r : (n,) array
        Residual forces, without those of contact.
    G : (m, n) csr_matrix
    gap : (m,) array
    pressing : (m,) bool array, optional
        Conditions known to be active.

    Returns
    -------
    change : (n,) array
    forces : (m,) array

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
    >>> change, forces = contact_step(K, np.array([1.0, -8.0]), G, np.array([0.5]))
    >>> change.round(12).tolist(), forces.round(12).tolist()
    ([0.5, -0.5], [6.0])
    """
    if not G.shape[0] and len(r) <= SMALL:
        return _dense(K, r), np.zeros(0)
    try:
        return _solved(K, r, G, gap)
    except UnstableError:
        if pressing is None or not pressing.any():
            raise
    held = pressing.copy()
    while held.any():
        rows = sp.csr_matrix(G[held])
        weight = K.diagonal().max() / rows.power(2).sum(axis=1).max()
        change, forces = _solved(sp.csr_matrix(K + weight * (rows.T @ rows)), r, G, gap)
        opening = held & (forces == 0)
        if not opening.any():
            forces[held] -= weight * (rows @ change)
            return change, np.maximum(forces, 0.0)
        held &= ~opening  # an opening condition must not be added to K
    raise UnstableError("The tangent stiffness is not positive definite, even with the active contacts.")


def _dense(K: sp.csr_matrix, r: Array) -> Array:
    """K^-1 r of a few coordinates without contact."""
    try:
        return np.asarray(scipy.linalg.solve(K.toarray(), r, assume_a="pos", check_finite=False))
    except np.linalg.LinAlgError as error:
        raise UnstableError("The tangent stiffness is not positive definite.") from error


def _solved(K: sp.csr_matrix, r: Array, G: sp.csr_matrix, gap: Array) -> tuple[Array, Array]:
    touched = np.unique(G.indices) if G.nnz else np.zeros(1, dtype=np.int64)
    if not (K.diagonal() > 0).all():
        raise UnstableError("The tangent stiffness has a diagonal entry that is not positive.")
    try:
        condensed = condense(sp.csr_matrix(sp.triu(K)), touched.astype(np.int64))
        factor = scipy.linalg.cho_factor(condensed.stiffness, lower=True)
    except (FecontactError, np.linalg.LinAlgError) as error:
        raise UnstableError("The tangent stiffness is not positive definite.") from error
    load = r[:, None]
    u = scipy.linalg.cho_solve(factor, condensed.reduce(load))
    forces = np.zeros(G.shape[0])
    if G.shape[0]:
        C = G[:, touched].toarray()
        X = scipy.linalg.cho_solve(factor, C.T)
        S = C @ X
        forces = solve(ComplementarityProblem((S + S.T) / 2, gap + C @ u[:, 0])).forces
        u = u + X @ forces[:, None]
    return condensed.expand(u, load)[:, 0], forces


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
    try:
        factor = spla.splu(sp.csc_matrix(K))
    except RuntimeError as error:
        raise UnstableError("The tangent stiffness is singular.") from error
    negative = np.count_nonzero(factor.U.diagonal() < 0) + _swaps(factor.perm_r) + _swaps(factor.perm_c)
    if negative % 2:
        raise UnstableError("The tangent stiffness has a negative determinant.")
    return np.asarray(factor.solve(r))


def _swaps(order: IntArray) -> int:
    """Number of exchanges that make up a permutation: its length less the number of its cycles."""
    n = len(order)
    cycles = sp.csr_matrix((np.ones(n), (np.arange(n), order)), shape=(n, n))
    return int(n - connected_components(cycles, directed=False)[0])
