"""Eight-node brick with positions and gradients at its nodes: shape functions and Gauss points.

Olshevskiy, Dmitrochenko & Kim (2013), also Shabana, Computational Continuum Mechanics, section 5.13. Per component
there are 32 functions, four at each corner: one for the value and three for the derivatives. They span all 20 cubic
monomials, the nine quartic ones x^3 y (six of that kind) and x^2 y z (three), and the three quintic ones x^3 y z. With
l = 1 + xi_k xi, which is 2 l below in coordinates on [0, 1], the source's functions are

    value    p q r (2 + xi xi_k + eta eta_k + zeta zeta_k - xi^2 - eta^2 - zeta^2) / 16
    d/dx     (a / 32) xi_k p^2 (xi xi_k - 1) q r        (a: edge length), and cyclic.

On a face only the value and in-face derivative functions of its four corners are nonzero: the twelve functions of
Adini's plate element. So neighbours conform if they share values and in-face derivatives.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from skfem.element import ElementH1
from skfem.refdom import RefHex

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.mesh.element import CORNERS, FACES

#: Functions of one element per component.
N_FUNCTIONS = 32
#: Possible numbers of Gauss points per direction, and the zero-energy modes of one element with each.
ZERO_MODES = {2: 48, 3: 6, 4: 6, 5: 6}


class ElementHexAncf(ElementH1):
    """scikit-fem element with value and three reference derivatives at each corner of the unit cube.

    Its functions are those of one component. On affine meshes of equal cells it can be used with scikit-fem's `Basis`;
    elsewhere derivatives must be shared in global axes, as `AncfSpace` does.

    Examples
    --------
    >>> from skfem import Basis, MeshHex
    >>> int(Basis(MeshHex(), ElementHexAncf(), intorder=7).N)
    32
    """

    nodal_dofs = 4
    maxdeg = 5
    dofnames = ["u", "u_x", "u_y", "u_z"]  # noqa: RUF012
    doflocs = np.repeat(RefHex.p.T, 4, axis=0)
    refdom = RefHex

    def lbasis(self, X: Array, i: int) -> tuple[Array, Array]:
        """Value and gradient of function i at reference points X (3, ...)."""
        node, kind = divmod(i, 4)
        corner = RefHex.p[:, node].reshape(3, *([1] * (X.ndim - 1)))
        s = 2 * corner - 1
        l = np.where(corner == 1, X, 1 - X)  # noqa: E741
        others = np.stack([l[1] * l[2], l[0] * l[2], l[0] * l[1]])
        product = l[0] * others[0]
        if kind == 0:
            factor = 1 + ((2 * l - 1) * (1 - l)).sum(axis=0)
            return product * factor, s * (others * factor + product * (3 - 4 * l))
        d = kind - 1
        e, f = (d + 1) % 3, (d + 2) % 3
        cubic = s[d] * l[d] ** 2 * (l[d] - 1)
        gradient = np.empty_like(others)
        gradient[d] = (3 * l[d] ** 2 - 2 * l[d]) * l[e] * l[f]
        gradient[e], gradient[f] = cubic * s[e] * l[f], cubic * s[f] * l[e]
        return cubic * l[e] * l[f], gradient


#: scikit-fem's number of each corner here.
_THEIRS = np.argmin(np.linalg.norm(CORNERS[:, None, :] - RefHex.p.T[None, :, :], axis=2), axis=1)


def shapes(X: Array) -> tuple[Array, Array]:
    """Shape functions at reference points, corners in VTK's order.

    Parameters
    ----------
    X : (n_q, 3) array
        Points of the unit cube.

    Returns
    -------
    N : (n_q, 32) array
        Column 4 k + 0 belongs to the value at corner k, 4 k + 1, 2, 3 to its derivatives along the reference axes.
    dN : (n_q, 32, 3) array

    Examples
    --------
    >>> import numpy as np
    >>> N, dN = shapes(np.array([[0.0, 0.0, 0.0]]))
    >>> float(N[0, 0]), dN[0, 1:4].tolist()
    (1.0, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    """
    element: Any = ElementHexAncf()
    local = np.ascontiguousarray(np.asarray(X, dtype=float).T)
    values = [element.lbasis(local, 4 * int(node) + kind) for node in _THEIRS for kind in range(4)]
    return np.stack([v for v, _ in values], axis=-1), np.stack([g.T for _, g in values], axis=1)


@cache
def gauss(n_points: int) -> tuple[Array, Array]:
    """Gauss points (n_points^3, 3) and weights of the unit cube.

    Two points per direction leave 48 zero-energy modes instead of six; three, four and five leave six. Four are exact
    for the linear stiffness and for the mass of a parallelepiped.

    Raises
    ------
    InputError
        If the number is not one of 2 ... 5 (or 1, for volume changes only).
    """
    if n_points not in (1, *ZERO_MODES):
        raise InputError(f"The Gauss rule has 2, 3, 4 or 5 points per direction; found {n_points!r}.", code="gauss")
    t, w = np.polynomial.legendre.leggauss(n_points)
    t, w = (t + 1) / 2, w / 2
    X = np.stack(np.meshgrid(t, t, t, indexing="ij"), axis=-1).reshape(-1, 3)
    return X, np.einsum("i,j,k->ijk", w, w, w).ravel()


def face_points(face: int, local: Array) -> Array:
    """Reference points (n, 3) of coordinates (n, 2) on a face, counter-clockwise seen from outside.

    Examples
    --------
    >>> import numpy as np
    >>> face_points(5, np.array([[0.25, 0.5]])).tolist()
    [[0.25, 0.5, 1.0]]
    """
    origin, along_s, _, along_t = CORNERS[FACES[face, :4]]
    return np.asarray(origin + local[:, :1] * (along_s - origin) + local[:, 1:] * (along_t - origin))
