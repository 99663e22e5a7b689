"""Shape functions of one element: plain, with mid-face nodes on chosen faces, or with coalesced edges.

A **degenerate** hexahedron repeats node numbers: an edge whose three nodes are one node has coalesced. For the 20-node
element, adding up the coalesced functions does not give the functions of the wedge; every face that has become a
triangle needs the correction of
Newton and Irons (Elangovan 1978, appendix B, eq. B-17/18)

    P_c += Delta (both corners opposite the coalesced edge),  P_m -= 2 Delta (the mid-side node between them),
    Delta = (1 - xi^2)(1 - eta^2)/8 on the face, here fading linearly to zero on the opposite face.

With it the wedge (two coalesced edges of one face) and the pyramid hold every quadratic polynomial. The tetrahedron
does not, so it takes the ten-node functions L_i (2 L_i - 1) and 4 L_i L_j directly, with the barycentric coordinates
L_i that the coalesced trilinear functions are.

A **mid-face node** turns the eight nodes of a contact face into nine: with N21 of `reference.midface_shape`,
N_corner += N21/4 and N_mid -= N21/2. All nodal weights of the face become positive, so that `force >= 0` means
`pressure >= 0`.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from fecontact.mesh.reference import EDGES, FACES, hex_shapes, midface_shape

Array = NDArray[np.float64]

#: Which local node each of the 20 nodes coincides with (the first of its kind); the identity if none has coalesced.
Pattern = tuple[int, ...]


@cache
def coalesced_edges(pattern: Pattern) -> NDArray[np.bool_]:
    """Of the twelve edges, those whose two corners are one node."""
    p = np.asarray(pattern)
    return p[EDGES[:, 0]] == p[EDGES[:, 1]]


def _face_edges(face: int) -> list[int]:
    """Edges 0 ... 11 round one face, between its consecutive corners."""
    return [int(mid) - 8 for mid in FACES[face, 4:8]]


def triangular_faces(pattern: Pattern) -> list[tuple[int, int]]:
    """Faces with exactly one coalesced edge, each with the position 0 ... 3 of that edge on the face."""
    coalesced = coalesced_edges(pattern)
    triangles = []
    for face in range(6):
        gone = [k for k, edge in enumerate(_face_edges(face)) if coalesced[edge]]
        if len(gone) == 1:
            triangles.append((face, gone[0]))
    return triangles


def element_basis(n_nodes: int, pattern: Pattern, midfaces: tuple[int, ...], X: Array) -> tuple[Array, Array]:
    """Shape functions of one kind of element at reference points.

    Parameters
    ----------
    n_nodes : int
        8, 20 or 27 nodes before coalescing.
    pattern : tuple of int
        For each node the first local node with which it coincides.
    midfaces : tuple of int
        Faces (0 ... 5) that carry a mid-face node; only with 20 nodes.
    X : (n_q, 3) array
        Reference points in [0, 1]^3.

    Returns
    -------
    N : (n_q, n_distinct + n_midfaces) array
        Functions of the distinct nodes in order of first appearance, then of the mid-face nodes.
    dN : (n_q, n_distinct + n_midfaces, 3) array

    Examples
    --------
    >>> import numpy as np
    >>> N, dN = element_basis(20, tuple(range(20)), (5,), np.array([[0.5, 0.5, 1.0]]))
    >>> N.shape, int(N.argmax())
    ((1, 21), 20)
    """
    if n_nodes == 20 and len(set(pattern[:8])) == 4:
        return _tetrahedron(pattern, X)
    N, dN = hex_shapes(n_nodes, X)
    if n_nodes == 20:
        for face, k in triangular_faces(pattern):
            bubble, slope = midface_shape(face, X)
            far = [(k + 2) % 4, (k + 3) % 4]
            for corner in FACES[face, far]:
                N[:, corner] += bubble / 8
                dN[:, corner] += slope / 8
            opposite = FACES[face, 4 + (k + 2) % 4]
            N[:, opposite] -= bubble / 4
            dN[:, opposite] -= slope / 4
    extra, d_extra = [], []
    for face in midfaces:
        bubble, slope = midface_shape(face, X)
        N[:, FACES[face, :4]] += bubble[:, None] / 4
        dN[:, FACES[face, :4]] += slope[:, None, :] / 4
        N[:, FACES[face, 4:8]] -= bubble[:, None] / 2
        dN[:, FACES[face, 4:8]] -= slope[:, None, :] / 2
        extra.append(bubble)
        d_extra.append(slope)
    N, dN = _merge(pattern, N, dN)
    if midfaces:
        N = np.concatenate([N, np.stack(extra, axis=1)], axis=1)
        dN = np.concatenate([dN, np.stack(d_extra, axis=1)], axis=1)
    return N, dN


def _merge(pattern: Pattern, N: Array, dN: Array) -> tuple[Array, Array]:
    """Add up the functions of coalesced nodes."""
    distinct = np.unique(pattern)
    belongs = (np.asarray(pattern)[:, None] == distinct[None, :]).astype(float)
    return N @ belongs, np.einsum("qni,nm->qmi", dN, belongs)


def _tetrahedron(pattern: Pattern, X: Array) -> tuple[Array, Array]:
    """Ten-node tetrahedron on the collapsed hexahedron: corners and mid-edge nodes in order of first appearance."""
    L, dL = _merge(pattern[:8], *hex_shapes(8, X))
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
