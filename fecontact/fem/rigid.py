"""Rigid modes: null space under constraints, orthonormalisation by Gram-Schmidt, description in words.

The route of the source report: elastic displacements and rigid motions separated by Gram-Schmidt.

Total displacements are u = S (S^T K S)^-1 S^T F + R a, where the orthonormal columns of S span what is orthogonal to
the free rigid motions R of the body. Nothing is held artificially. The compliance of a contact's rows C is C S (S^T K
S)^-1 S^T C^T; that of a body held at some nodes differs by rigid motions only, so that contact forces are the same.
Source: P. T. Elangovan (1978), appendix A, equations A-2 and A-9 to A-13.

S and S^T K S are dense: the route serves for comparison, on models of up to some thousand degrees of freedom.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array

#: The six components of a rigid motion: translations, then rotations about axes through the reference point.
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


def rigid_modes(points: Array, origin: ArrayLike) -> Array:
    """Displacement fields of the six small rigid motions about `origin`.

    Parameters
    ----------
    points : (n, 3) array
    origin : (3,) array

    Returns
    -------
    (3 n, 6) array
        Columns in the order of `COMPONENTS`; rotations in radians.

    Examples
    --------
    >>> import numpy as np
    >>> R = rigid_modes(np.array([[1.0, 0.0, 0.0]]), (0.0, 0.0, 0.0))
    >>> abs(R[:, 5]).tolist()  # a turn about z moves a point on the x axis along y
    [0.0, 1.0, 0.0]
    """
    x, y, z = (np.asarray(points, dtype=float) - np.asarray(origin, dtype=float)).T
    R = np.zeros((len(x), 3, 6))
    R[:, 0, 0] = R[:, 1, 1] = R[:, 2, 2] = 1.0
    R[:, 1, 3], R[:, 2, 3] = -z, y
    R[:, 0, 4], R[:, 2, 4] = z, -x
    R[:, 0, 5], R[:, 1, 5] = -y, x
    return R.reshape(-1, 6)


def gram_schmidt(R: Array, tolerance: float = 1e-10) -> Array:
    """Orthonormal basis of the columns of R by modified Gram-Schmidt with re-orthogonalisation.

    Columns whose remainder falls below `tolerance` of their own length depend on the earlier ones and are dropped.
    Source: Elangovan (1978), appendix A; "twice is enough" after Kahan and Parlett.

    Parameters
    ----------
    R : (n, m) array

    Returns
    -------
    (n, rank) array
    """
    basis: list[Array] = []
    for column in R.T:
        length = np.linalg.norm(column)
        if length == 0:
            continue
        v = column / length
        for _ in range(2):
            for q in basis:
                v = v - (q @ v) * q
        remainder = np.linalg.norm(v)
        if remainder > tolerance:
            basis.append(v / remainder)
    return np.stack(basis, axis=1) if basis else np.zeros((len(R), 0))


def complement(Q: Array) -> Array:
    """Orthonormal basis of all vectors orthogonal to the orthonormal columns of Q, by Gram-Schmidt of unit vectors.

    The unit vectors of the k rows in which Q is largest are left out; the others, without their parts along Q, are
    orthonormalised one after the other. All at once this is a Cholesky factor of their products, done twice because of
    rounding. Source: Elangovan (1978), equations A-15 and A-16.

    Parameters
    ----------
    Q : (n, k) array

    Returns
    -------
    (n, n - k) array

    Examples
    --------
    >>> Q = np.array([[0.6], [0.8], [0.0]])
    >>> S = complement(Q)
    >>> bool(abs(Q.T @ S).max() < 1e-15), bool(abs(S.T @ S - np.eye(2)).max() < 1e-15)
    (True, True)
    """
    n, k = Q.shape
    left_out = scipy.linalg.qr(Q.T, mode="r", pivoting=True)[1][:k] if k else np.zeros(0, dtype=np.int64)
    S = np.delete(np.eye(n), left_out, axis=1)
    if k == 0:
        return S
    for _ in range(2):
        S -= Q @ (Q.T @ S)
        factor = np.linalg.cholesky(S.T @ S)
        S = scipy.linalg.solve_triangular(factor, S.T, lower=True, check_finite=False).T
    return S


def null_space(constraints: Array, length: float, rounding: float = 1e-9) -> Array:
    """Rigid motions that a set of constraints does not resist.

    Parameters
    ----------
    constraints : (n, 6) array
        Displacement of each held component under the six unit motions.
    length : float
        Size of the body: the arm by which rotations are compared with translations.
    rounding : float
        Part of the most that is resisted, up to which a motion is not resisted.

    Returns
    -------
    (6, n_free) array
        Motions (columns) in the order of `COMPONENTS`; pure components where these span the null space.
    """
    scale = np.array([1.0] * 3 + [1.0 / length] * 3)
    if len(constraints) == 0:
        return np.eye(6)
    # many rows, six columns: the triangular factor has the same null space and singular values
    triangle = np.zeros((6, 6))
    factor = np.linalg.qr(constraints * scale, mode="r")
    triangle[: len(factor)] = factor
    _, singular, Vt = np.linalg.svd(triangle)
    rank = int((singular > rounding * singular[0]).sum()) if singular[0] > 0 else 0
    free = Vt[rank:].T
    projector = free @ free.T
    # a component in the null space is a column of its own, so that a free z is reported as z
    pure = [c for c in range(6) if abs(projector[c, c] - 1) < 1e-12]
    rest = gram_schmidt(np.concatenate([np.eye(6)[:, pure], free], axis=1), tolerance=1e-8)
    return rest * scale[:, None]


def describe_motion(motion: ArrayLike, origin: ArrayLike, length: float) -> str:
    """Description of a rigid motion in words.

    Parameters
    ----------
    motion : (6,) array
        Translation of the reference point and rotation vector.
    origin : (3,) array
        Reference point.
    length : float
        Size of the body, to weigh rotation against translation.

    Examples
    --------
    >>> describe_motion([0, 0, 1, 0, 0, 0], (0, 0, 0), 1.0)
    'translation along z'
    >>> describe_motion([0, 0, 0, 0, 2, 0], (0.5, 0, 0), 1.0)
    'rotation about y through (0.5, 0, 0)'
    """
    m = np.asarray(motion, dtype=float)
    m = np.where(np.abs(m) < 1e-9 * np.abs(m * ([1] * 3 + [length] * 3)).max() / np.array([1] * 3 + [length] * 3), 0, m)
    translation, rotation = m[:3], m[3:]
    angle = np.linalg.norm(rotation)
    if angle * length < 1e-6 * np.linalg.norm(translation):
        return f"translation along {_axis(translation)}"
    # the screw axis: the point that moves only along the axis, nearest the reference point
    point = np.asarray(origin, dtype=float) + np.cross(rotation, translation) / angle**2
    point = np.where(np.abs(point) < 1e-9 * length, 0.0, point)
    text = f"rotation about {_axis(rotation)} through ({', '.join(f'{p:.4g}' for p in point)})"
    along = rotation @ translation / angle**2
    if abs(along) > 1e-6 * length:
        text += f", with {along:.4g} of translation along it per radian"
    return text


def _axis(v: Array) -> str:
    """'x', '-x', ... for a coordinate direction, else the unit vector."""
    unit = v / np.linalg.norm(v)
    k = int(np.argmax(np.abs(unit)))
    if abs(abs(unit[k]) - 1) < 1e-6:
        return "xyz"[k]
    return f"({', '.join(f'{u:.3g}' for u in unit)})"
