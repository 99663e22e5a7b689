"""Shape functions of one element: regular, with mid-face nodes on chosen faces, or with coalesced edges.

A **degenerate** hexahedron repeats node numbers: a coalesced edge has one node in place of three. For the 20-node
element the sums of the coalesced functions are not the functions of the wedge; every triangular face needs the
correction of Newton and Irons (Elangovan 1978, appendix B, eq. B-17/18)

    P_c += Delta (both corners opposite the coalesced edge),  P_m -= 2 Delta (the mid-side node between them),
    Delta = (1 - xi^2)(1 - eta^2)/8 on the face, here fading linearly to zero on the opposite face.

With it the wedge (two coalesced edges of one face) and the pyramid reproduce every quadratic polynomial. The
tetrahedron does not; it takes the ten-node functions L_i (2 L_i - 1) and 4 L_i L_j directly, where the barycentric
coordinates L_i are the coalesced trilinear functions.

A **mid-face node** turns the eight nodes of a contact face into nine: with N21 of `hexahedron.midface_shape`,
N_corner += N21/4 and N_mid -= N21/2. A triangular face gets a **centroid node**: with N = 27 L1 L2 L3 on the face,
N_corner += N/9 and N_mid -= 4N/9. Both vanish on all other faces. All nodal weights of the face become positive, so
that `force >= 0` means `pressure >= 0`.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.element.hexahedron import CORNERS, EDGES, FACES, hex_nodes, hex_shapes, midface_shape

#: First local node with which each of the 20 nodes coincides; the identity if none has coalesced.
Pattern = tuple[int, ...]


@cache
def coalesced_edges(pattern: Pattern) -> Mask:
    """Edges (of twelve) whose two corners are one node."""
    p = np.asarray(pattern)
    return p[EDGES[:, 0]] == p[EDGES[:, 1]]


def _face_edges(face: int) -> list[int]:
    """Edges 0 ... 11 round one face, between its consecutive corners."""
    return [int(mid) - 8 for mid in FACES[face, 4:8]]


@cache
def triangular_faces(pattern: Pattern) -> tuple[tuple[int, int], ...]:
    """Faces with exactly one coalesced edge, each with the position 0 ... 3 of that edge on the face."""
    coalesced = coalesced_edges(pattern)
    triangles = []
    for face in range(6):
        gone = [k for k, edge in enumerate(_face_edges(face)) if coalesced[edge]]
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
