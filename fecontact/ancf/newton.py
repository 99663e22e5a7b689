"""One Newton step of bodies in contact: linearised, it is a contact problem like any other.

    K d = r + G^T l,    g + G d >= 0,    l >= 0,    l . (g + G d) = 0

K is condensed onto the coordinates that the conditions touch, and l follows from a complementarity problem with
S = G K^-1 G^T (sequential quadratic programming; Nocedal & Wright, Numerical Optimization, 2006, chapter 18). K has to
be positive definite: along a stable path it is.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from fecontact.errors import FecontactError
from fecontact.fem.factor import condense
from fecontact.solvers import ComplementarityProblem, solve

Array = NDArray[np.float64]


class UnstableError(FecontactError):
    """The tangent is not positive definite: the state is not a stable one, or the step was too long."""


def contact_step(K: sp.csr_matrix, r: Array, G: sp.csr_matrix, gap: Array) -> tuple[Array, Array]:
    """Change of the coordinates and contact forces.

    Parameters
    ----------
    K : (n, n) csr_matrix
        Symmetric positive definite.
    r : (n,) array
        Forces that are out of balance, without those of contact.
    G : (m, n) csr_matrix
    gap : (m,) array

    Returns
    -------
    change : (n,) array
    forces : (m,) array

    Raises
    ------
    UnstableError
        If K is not positive definite.
    SolverError
        If the contact problem has no certified answer.

    Examples
    --------
    >>> import numpy as np, scipy.sparse as sp
    >>> K, G = sp.csr_matrix(np.diag([2.0, 4.0])), sp.csr_matrix(np.array([[0.0, 1.0]]))
    >>> change, forces = contact_step(K, np.array([1.0, -8.0]), G, np.array([0.5]))
    >>> change.round(12).tolist(), forces.round(12).tolist()
    ([0.5, -0.5], [6.0])
    """
    touched = np.unique(G.indices) if G.nnz else np.zeros(1, dtype=np.int64)
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
