"""The reference hexahedron: node order, faces, shape functions and quadrature, all taken from scikit-fem.

Nodes follow the order of VTK and Abaqus (C3D8, C3D20, C3D27 of VTK): corners of the lower face counter-clockwise,
corners of the upper face, mid-edge nodes of the lower face, of the upper face, of the vertical edges, then (27 nodes)
the face centres -x, +x, -y, +y, -z, +z and the centre. scikit-fem's order differs; the permutation is found here once
from the node positions. Reference coordinates run over [0, 1]^3.
"""

from __future__ import annotations

from functools import cache, lru_cache

import numpy as np
from skfem.element import ElementHex1, ElementHex2, ElementHexS2, ElementQuad1, ElementQuad2, ElementQuadS2
from skfem.quadrature import get_quadrature
from skfem.refdom import RefHex, RefQuad

from fecontact.common.arrays import Array, IntArray

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
)
#: Corner pairs of the twelve edges, in the order of the mid-edge nodes 8 ... 19.
EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]], dtype=np.int64
)
#: Local nodes of the six faces -x, +x, -y, +y, -z, +z: four corners, four mid-edge nodes, the face centre. The corners
#: run counter-clockwise seen from outside, so that dx/ds x dx/dt is the outward normal of a right-handed element.
FACES = np.array(
    [
        [0, 4, 7, 3, 16, 15, 19, 11, 20],
        [1, 2, 6, 5, 9, 18, 13, 17, 21],
        [0, 1, 5, 4, 8, 17, 12, 16, 22],
        [3, 7, 6, 2, 19, 14, 18, 10, 23],
        [0, 3, 2, 1, 11, 10, 9, 8, 24],
        [4, 5, 6, 7, 12, 13, 14, 15, 25],
    ],
    dtype=np.int64,
)
QUAD_CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
QUAD_EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0]], dtype=np.int64)
#: Reference positions of a triangle's three corners, three mid-side nodes and centroid.
TRIANGLE_NODES = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5], [1 / 3, 1 / 3]])

#: Points up to which shape functions are kept.
FEW = 128
_HEX = {8: ElementHex1, 20: ElementHexS2, 27: ElementHex2}
_QUAD = {4: ElementQuad1, 8: ElementQuadS2, 9: ElementQuad2}
#: Quadrature order for the stiffness of the affine element: 2, 3 and 3 points per direction.
_ORDER = {8: 3, 20: 5, 27: 5}


def _positions(corners: Array, edges: IntArray, n_nodes: int) -> Array:
    """Reference positions of the first `n_nodes` of corners, mid-edge nodes, face centres and centre."""
    nodes = [corners, corners[edges].mean(axis=1)]
    if corners.shape[1] == 3:
        nodes.append(corners[FACES[:, :4]].mean(axis=1))
    nodes.append(corners.mean(axis=0)[None, :])
    return np.concatenate(nodes)[:n_nodes]


@cache
def hex_nodes(n_nodes: int) -> Array:
    """Reference positions (n_nodes, 3) of the 8, 20 or 27 nodes."""
    return _positions(CORNERS, EDGES, n_nodes)


@cache
def quad_nodes(n_nodes: int) -> Array:
    """Reference positions (n_nodes, 2) of the 4, 8 or 9 nodes of a quadrilateral."""
    return _positions(QUAD_CORNERS, QUAD_EDGES, n_nodes)


def _remembered(kind: str, n_nodes: int, X: Array) -> tuple[Array, Array]:
    """`_scikit_fem_shapes` of a kind of element; at few points, such as those of a rule, evaluated once."""
    if len(X) > FEW:
        return _scikit_fem_shapes(kind, n_nodes, X)
    N, dN = _at_few_points(kind, n_nodes, np.ascontiguousarray(X, dtype=float).tobytes())
    return N.copy(), dN.copy()


@lru_cache(maxsize=256)
def _at_few_points(kind: str, n_nodes: int, X: bytes) -> tuple[Array, Array]:
    return _scikit_fem_shapes(kind, n_nodes, np.frombuffer(X).reshape(-1, 3 if kind == "hex" else 2))


def _scikit_fem_shapes(kind: str, n_nodes: int, X: Array) -> tuple[Array, Array]:
    """Values (n_q, n_nodes) and gradients (n_q, n_nodes, dim) of a scikit-fem element, in this node order."""
    element, nodes = (_HEX[n_nodes](), hex_nodes(n_nodes)) if kind == "hex" else (_QUAD[n_nodes](), quad_nodes(n_nodes))
    theirs = np.asarray(element.doflocs)
    order = np.argmin(np.linalg.norm(nodes[:, None, :] - theirs[None, :, :], axis=2), axis=1)
    local = np.ascontiguousarray(X.T)
    values = [element.lbasis(local, int(i)) for i in order]
    N = np.stack([np.broadcast_to(v, local.shape[1:]) for v, _ in values], axis=-1)
    dN = np.stack([np.stack([np.broadcast_to(c, local.shape[1:]) for c in g], axis=-1) for _, g in values], axis=-2)
    return N.astype(float), dN.astype(float)


def hex_shapes(n_nodes: int, X: Array) -> tuple[Array, Array]:
    """Shape functions of the 8-, 20- or 27-node hexahedron.

    Parameters
    ----------
    n_nodes : int
        8 (trilinear), 20 (serendipity) or 27 (triquadratic).
    X : (n_q, 3) array
        Reference points.

    Returns
    -------
    N : (n_q, n_nodes) array
    dN : (n_q, n_nodes, 3) array
        Gradients with respect to the reference coordinates.

    Examples
    --------
    >>> import numpy as np
    >>> N, dN = hex_shapes(20, np.array([[0.3, 0.2, 0.9]]))
    >>> bool(abs(N.sum() - 1) < 1e-14), bool(abs(dN.sum()) < 1e-13)
    (True, True)
    """
    return _remembered("hex", n_nodes, X)


def quad_shapes(n_nodes: int, X: Array) -> tuple[Array, Array]:
    """Shape functions (n_q, n_nodes) and gradients (n_q, n_nodes, 2) of the 4-, 8- or 9-node quadrilateral."""
    return _remembered("quad", n_nodes, X)


def triangle_shapes(n_nodes: int, X: Array) -> tuple[Array, Array]:
    """Shape functions (n_q, n_nodes) and gradients (n_q, n_nodes, 2) of the triangle of 3, 6 or 7 nodes.

    The seventh function, 27 L1 L2 L3, is one at the centroid; with it the corner functions grow by a ninth and the
    mid-side functions shrink by four ninths of it, so that all weights are positive: 1/20, 2/15 and 9/20 of the area.

    Examples
    --------
    >>> import numpy as np
    >>> int(triangle_shapes(7, np.array([[1 / 3, 1 / 3]]))[0].argmax())
    6
    """
    L = np.stack([1 - X[:, 0] - X[:, 1], X[:, 0], X[:, 1]], axis=1)
    dL = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    if n_nodes == 3:
        return L, np.broadcast_to(dL, (len(X), 3, 2)).copy()
    following = L[:, [1, 2, 0]], dL[[1, 2, 0]]
    N = np.concatenate([L * (2 * L - 1), 4 * L * following[0]], axis=1)
    d_corner = (4 * L - 1)[:, :, None] * dL
    d_middle = 4 * (L[:, :, None] * following[1] + following[0][:, :, None] * dL)
    dN = np.concatenate([d_corner, d_middle], axis=1)
    if n_nodes == 6:
        return N, dN
    share = np.array([1 / 9] * 3 + [-4 / 9] * 3)
    bubble = 27 * L.prod(axis=1)
    slope = 27 * sum((L[:, (i + 1) % 3] * L[:, (i + 2) % 3])[:, None] * dL[i] for i in range(3))
    N = np.concatenate([N + bubble[:, None] * share, bubble[:, None]], axis=1)
    return N, np.concatenate([dN + slope[:, None, :] * share[:, None], slope[:, None, :]], axis=1)


def midface_shape(face: int, X: Array) -> tuple[Array, Array]:
    """Shape function of the mid-face node of one face: (1 - xi^2)(1 - eta^2)(1 + zeta)/2 for the face zeta = +1.

    It vanishes on the other five faces, so a neighbour without such a node still conforms and two faces of one element
    are independent. Returned are its values (n_q,) and gradients (n_q, 3) in reference coordinates on [0, 1].
    """
    axis, upper = divmod(face, 2)
    factors, slopes = [], []
    for i in range(3):
        x = X[:, i]
        if i == axis:
            factors.append(x if upper else 1 - x)
            slopes.append(np.full_like(x, 1.0 if upper else -1.0))
        else:
            factors.append(4 * x * (1 - x))
            slopes.append(4 - 8 * x)
    value = factors[0] * factors[1] * factors[2]
    gradient = np.stack([slopes[i] * factors[(i + 1) % 3] * factors[(i + 2) % 3] for i in range(3)], axis=-1)
    return value, gradient


@cache
def hex_quadrature(n_nodes: int) -> tuple[Array, Array]:
    """Gauss points (n_q, 3) and weights (n_q,) for stiffness: 8 for the 8-node element, 27 for 20 and 27 nodes.

    scikit-fem's default order for the 20-node element gives 125 points; order 3 gives 8 points and twelve zero-energy
    modes; order 5 gives the 27 that are needed.
    """
    X, W = get_quadrature(RefHex, _ORDER[n_nodes])
    return np.ascontiguousarray(X.T), W


@cache
def quad_quadrature(order: int = 5) -> tuple[Array, Array]:
    """Gauss points (n_q, 2) and weights (n_q,) on the reference quadrilateral, exact to `order`."""
    X, W = get_quadrature(RefQuad, order)
    return np.ascontiguousarray(X.T), W
