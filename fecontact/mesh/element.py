"""Elements: shape functions, degenerate hexahedra and quadrature."""

from __future__ import annotations

from functools import cache, lru_cache
from itertools import combinations

import numpy as np
from skfem.element import ElementHex1, ElementHex2, ElementHexS2, ElementQuad1, ElementQuad2, ElementQuadS2
from skfem.quadrature import get_quadrature
from skfem.refdom import RefHex, RefLine, RefQuad, RefTet, RefTri

from fecontact.common.arrays import Array, IntArray, Mask

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
    if len(X) > FEW and (X[0] == X).all():  # such as the middles of all facets
        N, dN = _remembered(kind, n_nodes, X[:1])
        return N.repeat(len(X), axis=0), dN.repeat(len(X), axis=0)
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


#: First local node with which each of the 20 nodes coincides; the identity if none has coalesced.
Pattern = tuple[int, ...]


@cache
def coalesced_edges(pattern: Pattern) -> Mask:
    """Edges (of twelve) whose two corners are one node."""
    p = np.asarray(pattern)
    return p[EDGES[:, 0]] == p[EDGES[:, 1]]


@cache
def triangular_faces(pattern: Pattern) -> tuple[tuple[int, int], ...]:
    """Faces with exactly one coalesced edge, each with the position 0 ... 3 of that edge on the face."""
    coalesced = coalesced_edges(pattern)
    triangles = []
    for face in range(6):
        # edges 0 ... 11 round the face, between its consecutive corners
        gone = [k for k, mid in enumerate(FACES[face, 4:8]) if coalesced[mid - 8]]
        if len(gone) == 1:
            triangles.append((face, gone[0]))
    return tuple(triangles)


def element_basis(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...], X: Array) -> tuple[Array, Array]:
    """Shape functions of one kind of element at reference points.

    Parameters
    ----------
    n_nodes : int
        8, 20 or 27 nodes before coalescing.
    pattern : tuple of int
        For each node the first local node with which it coincides.
    midfaces : tuple of int
        Faces (0 ... 5) that carry a mid-face node (triangular faces: a centroid node); only with 20 nodes.
    X : (n_q, 3) array
        Reference points in [0, 1]^3.

    Returns
    -------
    N : (n_q, n_distinct + n_midfaces) array
        Functions of the distinct nodes in order of first appearance, then those of the mid-face nodes.
    dN : (n_q, n_distinct + n_midfaces, 3) array

    Examples
    --------
    >>> import numpy as np
    >>> N, dN = element_basis(20, tuple(range(20)), (5,), np.array([[0.5, 0.5, 1.0]]))
    >>> N.shape, int(N.argmax())
    ((1, 21), 20)
    """
    if n_nodes == 20 and is_tetrahedron(pattern):
        N, dN = _tetrahedron(pattern, X)
    else:
        N, dN = hex_shapes(n_nodes, X)
        if n_nodes == 20:
            _correct_triangles(pattern, X, N, dN)
        N, dN = _merge(pattern, N, dN)
    place = np.searchsorted(np.unique(pattern), pattern)
    for face in midfaces:
        bubble, slope = _face_bubble(pattern, face, X)
        nodes, share = _sharing_nodes(pattern, face)
        N[:, place[nodes]] += bubble[:, None] * share
        dN[:, place[nodes]] += slope[:, None, :] * share[:, None]
        N = np.concatenate([N, bubble[:, None]], axis=1)
        dN = np.concatenate([dN, slope[:, None, :]], axis=1)
    return N, dN


def is_tetrahedron(pattern: Pattern) -> bool:
    """Whether only four corners are left."""
    return len(set(pattern[:8])) == 4


def _correct_triangles(pattern: Pattern, X: Array, N: Array, dN: Array) -> None:
    """Newton and Irons' correction of the functions, in place."""
    for face, k in triangular_faces(pattern):
        bubble, slope = midface_shape(face, X)
        far = [(k + 2) % 4, (k + 3) % 4]
        for corner in FACES[face, far]:
            N[:, corner] += bubble / 8
            dN[:, corner] += slope / 8
        opposite = FACES[face, 4 + (k + 2) % 4]
        N[:, opposite] -= bubble / 4
        dN[:, opposite] -= slope / 4


def _merge(pattern: Pattern, N: Array, dN: Array) -> tuple[Array, Array]:
    """Add up the functions of coalesced nodes."""
    distinct = np.unique(pattern)
    belongs = (np.asarray(pattern)[:, None] == distinct[None, :]).astype(float)
    return N @ belongs, np.einsum("qni,nm->qmi", dN, belongs)


def linear_shapes(pattern: Pattern, X: Array) -> tuple[Array, Array]:
    """Coalesced trilinear functions (n_q, n_corners) of the distinct corners, and their gradients.

    Of a tetrahedron they are the barycentric coordinates.
    """
    return _merge(pattern[:8], *hex_shapes(8, X))


def node_positions(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...]) -> Array:
    """Reference positions (n_functions, 3) of an element's nodes; a coalesced node has the first of its positions."""
    positions = [hex_nodes(n_nodes)[np.unique(pattern)]]
    triangles = dict(triangular_faces(pattern))
    for face in midfaces:
        weights = np.full(4, 1 / 4)
        if face in triangles:
            # a third of the way from the far edge to the coalesced one
            k = triangles[face]
            weights[[k, (k + 1) % 4]], weights[[(k + 2) % 4, (k + 3) % 4]] = 1 / 6, 1 / 3
        positions.append((weights @ CORNERS[FACES[face, :4]])[None, :])
    return np.concatenate(positions)


def _sharing_nodes(pattern: Pattern, face: int) -> tuple[IntArray, Array]:
    """Nodes of a face whose functions change when it gets a middle node, and the share of the new function in each."""
    gone = dict(triangular_faces(pattern)).get(face)
    if gone is None:
        return FACES[face, :8], np.array([1 / 4] * 4 + [-1 / 2] * 4)
    # the three distinct corners begin after the coalesced edge, the three sides with them
    turn = (gone + 1 + np.arange(3)) % 4
    return FACES[face, np.concatenate([turn, 4 + turn])], np.array([1 / 9] * 3 + [-4 / 9] * 3)


def _face_bubble(pattern: Pattern, face: int, X: Array) -> tuple[Array, Array]:
    """Function of a face's middle node, one there and zero on all other faces, and its gradient.

    Triangle: 27 L1 L2 L3, in a tetrahedron with its barycentric coordinates, elsewhere times a factor that decreases
    linearly to zero on the opposite face. Quadrilateral opposite a collapsed face, as in a wedge: that factor squared,
    which makes it a polynomial in the wedge's own coordinates.
    """
    gone = dict(triangular_faces(pattern)).get(face)
    if gone is not None and is_tetrahedron(pattern):
        L, dL = linear_shapes(pattern, X)
        corner = np.unique(pattern[:8])
        a, b, c = (int(np.searchsorted(corner, k)) for k in np.unique(np.asarray(pattern)[FACES[face, :4]]))
        slope = dL[:, a] * (L[:, b] * L[:, c])[:, None] + dL[:, b] * (L[:, a] * L[:, c])[:, None]
        return 27 * L[:, a] * L[:, b] * L[:, c], 27 * (slope + dL[:, c] * (L[:, a] * L[:, b])[:, None])
    bubble, slope = midface_shape(face, X)
    if gone is not None:
        factor, d_factor = _distance_from_edge(face, gone, X)
        scale = 27 / 16
    elif _is_line(pattern, face ^ 1):
        axis, upper = divmod(face, 2)
        factor = X[:, axis] if upper else 1 - X[:, axis]
        d_factor, scale = np.eye(3)[axis] * (1.0 if upper else -1.0), 1.0
    else:
        return bubble, slope
    return scale * bubble * factor, scale * (slope * factor[:, None] + bubble[:, None] * d_factor)


def _is_line(pattern: Pattern, face: int) -> bool:
    corners = np.asarray(pattern)[FACES[face, :4]]
    return len(np.unique(corners)) == 2


def _distance_from_edge(face: int, k: int, X: Array) -> tuple[Array, Array]:
    """Coordinate that falls from one to zero across a face towards its coalesced edge k, and its gradient (3,).

    With it 16 s (1 - s) t (1 - t) becomes proportional to L1 L2 L3 = s (1 - s) t (1 - t)^2, the edge lying at t = 1.
    """
    across = CORNERS[FACES[face, (k + 2) % 4]] - CORNERS[FACES[face, (k + 1) % 4]]
    axis = int(np.argmax(np.abs(across)))
    upper = CORNERS[FACES[face, k], axis] == 1
    factor = 1 - X[:, axis] if upper else X[:, axis]
    return factor, np.eye(3)[axis] * (-1.0 if upper else 1.0)


def _tetrahedron(pattern: Pattern, X: Array) -> tuple[Array, Array]:
    """Ten-node tetrahedron on the collapsed hexahedron: corners and mid-edge nodes in order of first appearance."""
    L, dL = linear_shapes(pattern, X)
    corner_of = {node: i for i, node in enumerate(np.unique(pattern[:8]).tolist())}
    N, dN = [], []
    for node in np.unique(pattern).tolist():
        if node < 8:
            i = corner_of[node]
            N.append(L[:, i] * (2 * L[:, i] - 1))
            dN.append(dL[:, i] * (4 * L[:, i] - 1)[:, None])
        else:
            i, j = (corner_of[pattern[c]] for c in EDGES[node - 8].tolist())
            N.append(4 * L[:, i] * L[:, j])
            dN.append(4 * (dL[:, i] * L[:, j, None] + dL[:, j] * L[:, i, None]))
    return np.stack(N, axis=1), np.stack(dN, axis=1)


#: Node pattern of each: wedge a b c c, d e f f; tetrahedron a b c c, d d d d; pyramid.
WEDGE: Pattern = (0, 1, 2, 2, 4, 5, 6, 6, 8, 9, 2, 11, 12, 13, 6, 15, 16, 17, 18, 18)
TETRAHEDRON: Pattern = (0, 1, 2, 2, 4, 4, 4, 4, 8, 9, 2, 11, 4, 4, 4, 4, 16, 17, 18, 18)
PYRAMID: Pattern = (0, 1, 2, 3, 4, 4, 4, 4, 8, 9, 10, 11, 4, 4, 4, 4, 16, 17, 18, 19)

#: Degrees of a wedge's rule over the triangle and along the axis with 6, with 15 and with centroid nodes.
_WEDGE_DEGREE = {8: (2, 3), 20: (4, 5), "centroid": (5, 5)}
#: Rule of degree 5 with 14 points (Walkington, 2000): barycentric coordinate of the distinct one(s), and the weight.
_VERTEX_ORBITS = ((0.0673422422100982, 0.1126879257180158), (0.7217942490673264, 0.0734930431163619))
_EDGE_ORBIT = (0.0455037041256497, 0.0425460207770812)


def _tetrahedron_14() -> tuple[Array, Array]:
    """Barycentric coordinates (3, 14) of the last three corners and weights (14,)."""
    points, weights = [], []
    for odd, weight in _VERTEX_ORBITS:
        points += [np.where(np.arange(4) == k, odd, (1 - odd) / 3) for k in range(4)]
        weights += 4 * [weight]
    small, weight = _EDGE_ORBIT
    points += [np.where(np.isin(np.arange(4), pair), small, 0.5 - small) for pair in combinations(range(4), 2)]
    weights += 6 * [weight]
    return np.array(points).T[1:], np.array(weights) / np.sum(weights) / 6


@cache
def element_quadrature(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...] = ()) -> tuple[Array, Array]:
    """Points (n_q, 3) and weights (n_q,) for the stiffness of one kind of element.

    Parameters
    ----------
    n_nodes, pattern, midfaces
        As in `basis.element_basis`.

    Examples
    --------
    >>> [len(element_quadrature(20, p)[1]) for p in (tuple(range(20)), WEDGE, TETRAHEDRON)]
    [27, 18, 14]
    """
    if n_nodes in (8, 20) and pattern == TETRAHEDRON[:n_nodes]:
        (b, c, d), W = get_quadrature(RefTet, 1) if n_nodes == 8 else _tetrahedron_14()
        rest = 1 - c - d
        return np.stack([b / rest, c / (1 - d), d], axis=1), W / (rest * (1 - d))
    if n_nodes in (8, 20) and pattern == WEDGE[:n_nodes]:
        across, along = _WEDGE_DEGREE["centroid" if midfaces else n_nodes]
        (b, c), W = get_quadrature(RefTri, across)
        (z,), Wz = get_quadrature(RefLine, along)
        plane = np.stack([b / (1 - c), c], axis=1)
        X = np.concatenate([np.repeat(plane, len(z), axis=0), np.tile(z, len(b))[:, None]], axis=1)
        return X, np.repeat(W / (1 - c), len(z)) * np.tile(Wz, len(b))
    return hex_quadrature(n_nodes)


@cache
def reduced_quadrature(n_nodes: int) -> tuple[Array, Array]:
    """Points (n_q, 3) and weights (n_q,) one order lower: one for 8 nodes, eight for 20 and 27.

    For the volumetric part of nearly incompressible elements; alone they would leave zero-energy modes.
    """
    if n_nodes == 8:
        return np.full((1, 3), 0.5), np.ones(1)
    X, W = get_quadrature(RefHex, 3)
    return np.ascontiguousarray(X.T), W


@cache
def quadrature_basis(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...]) -> tuple[Array, Array]:
    """Shape functions and their derivatives of one kind of element at its quadrature points, read-only.

    Parameters
    ----------
    n_nodes, pattern, midfaces
        As in `degenerate.element_basis`.
    """
    basis = element_basis(n_nodes, pattern, midfaces, element_quadrature(n_nodes, pattern, midfaces)[0])
    for values in basis:
        values.setflags(write=False)
    return basis
