"""Supports: positions and in-face gradients held on named boundaries.

To hold a component on a whole face, hold its nodal values *and* its in-face derivatives; otherwise the face bends
between its nodes. The derivative across the face stays free, as it is a strain (a clamp that holds it too is stiffer
than a built-in end, by 4.6 % for a beam of slenderness ten and nu = 0).

On a face along the axes the held coordinates are entries of q. Elsewhere they are combinations of a node's gradients,
so the basis is rotated: q = q0 + Z y with y free and Z of orthonormal columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.space import AncfSpace
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.fem.support import SAME_DIRECTION, Support, support_directions
from fecontact.mesh.element.hexahedron import FACES

#: Share of a direction in the tangents of the faces round a node above which it counts as in the face; facets of a
#: curved boundary may be inclined by about 13 degrees to their mean.
ALONG = 0.05


@dataclass(frozen=True, eq=False)
class Supports:
    """Held coordinates.

    Attributes
    ----------
    basis : (n_dofs, n_dofs) csr_matrix
        Orthonormal columns; the identity except at nodes with oblique supports.
    held : (n_held,) int array
        Columns that are held.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSpace, hold
    >>> space = AncfSpace(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
    >>> hold(space, {"x_min": "xyz"}).held.size  # four nodes, position and two gradients
    36
    """

    basis: sp.csr_matrix
    held: IntArray

    @cached_property
    def free(self) -> sp.csr_matrix:
        """Matrix Z (n_dofs, n_free): q = q0 + Z y."""
        kept = np.setdiff1d(np.arange(self.basis.shape[1]), self.held, assume_unique=True)
        return self.basis[:, kept].tocsr()

    @cached_property
    def rows(self) -> sp.csr_matrix:
        """Matrix (n_held, n_dofs) of the held components of a change of q."""
        return self.basis[:, self.held].T.tocsr()


def hold(space: AncfSpace, supports: Mapping[str, Support]) -> Supports:
    """Hold named boundaries, such as ``{"base": "xyz", "sym_x": "x", "flank": "n", "seat": (1, 1, 0)}``.

    A node set holds positions only, a boundary holds positions and in-face derivatives.

    Raises
    ------
    InputError
        For unknown names or components, or ``"n"`` on a boundary that is not plane.
    """
    width = int(np.diff(np.append(space.start, space.n_functions)).max()) - 1
    position = np.zeros((len(space.nodes), 3, 3))
    ties = np.zeros((len(space.nodes), width, 3, width, 3))
    for name, support in supports.items():
        point, d = support_directions(space.mesh, name, support)
        here = np.isin(point, space.nodes)
        node, d = np.searchsorted(space.nodes, point[here]), d[here]
        if len(node) == 0:
            raise InputError(f"No point of {name!r} is a corner of a cell, where the nodes of this element are.")
        across = np.einsum("nki,nkj->nij", d, d)
        position[node] += across
        if name in space.mesh.boundaries:
            _refuse_curved(space, name, support)
            owner, rows = _tangent_rows(space, space.mesh.boundaries[name])
            along = _projectors(_outer_sums(space, owner, rows, width)[node])
            ties[node] += np.einsum("nab,nij->naibj", along, across)
    return _separated(space, position, ties)


def _refuse_curved(space: AncfSpace, name: str, support: Support) -> None:
    """Refuse 'n' on a curved boundary: n . u = 0 couples derivatives to positions, which is not supported."""
    if not (isinstance(support, str) and "n" in support):
        return
    faces = space.mesh.boundaries[name]
    x = space.mesh.points[space.mesh.face_nodes(faces)].reshape(-1, 3)
    thickness = np.linalg.svd(x - x.mean(axis=0), compute_uv=False)
    if thickness[2] > 1e-9 * thickness[0]:
        raise InputError(
            f"The boundary {name!r} is not plane, so the brick with gradient coordinates cannot be supported along its "
            "normal 'n'; support it in components or a direction, or use ElasticBody."
        )


def _tangent_rows(space: AncfSpace, faces: IntArray) -> tuple[IntArray, sp.csr_matrix]:
    """Nodes (n,) and unit in-face derivatives (n, n_functions), two orthonormal ones at each corner of each face."""
    cell, face = faces.T
    local = FACES[face, :4]
    J = space.nodal_jacobians[cell[:, None], local]
    axes = np.stack([(face // 2 + 1) % 3, (face // 2 + 2) % 3], axis=1)
    tangents = np.take_along_axis(J, axes[:, None, None, :], axis=3)
    t = np.linalg.qr(tangents)[0].swapaxes(2, 3).reshape(-1, 3)
    gradient = space.functions[cell[:, None], 4 * local + 1].ravel().repeat(2)[:, None] + np.arange(3)
    n = int(space.functions.max()) + 1
    rows = sp.csr_matrix((t.ravel(), gradient.ravel(), np.arange(0, t.size + 1, 3)), shape=(len(t), n))
    node = space.corners[cell[:, None], local].ravel().repeat(2)
    return node, rows if space.joining is None else (rows @ space.joining).tocsr()


def _outer_sums(space: AncfSpace, node: IntArray, rows: sp.csr_matrix, width: int) -> Array:
    """Sums (n_nodes, width, width) of the outer products of the rows over each node's gradient functions."""
    coo = rows.tocoo()
    dense = np.zeros((rows.shape[0], width))
    dense[coo.row, coo.col - space.start[node[coo.row]] - 1] = coo.data
    out = np.zeros((len(space.nodes), width, width))
    np.add.at(out, node, dense[:, :, None] * dense[:, None, :])
    return out


def _projectors(normal: Array) -> Array:
    """Projectors (n, k, k) on the eigenvectors above the share `ALONG` of the largest eigenvalue."""
    values, vectors = np.linalg.eigh(normal)
    kept = vectors * (values > ALONG * values[:, -1:])[:, None, :]
    return kept @ kept.swapaxes(1, 2)


def _separated(space: AncfSpace, position: Array, ties: Array) -> Supports:
    """Rotated positions and gradients of every node, such that each coordinate is held or free."""
    n_free = np.diff(np.append(space.start, space.n_functions)) - 1
    turns = [_turned(position, 3 * space.start[:, None] + np.arange(3))]
    for d in np.unique(n_free):
        node = np.flatnonzero(n_free == d)
        dofs = 3 * (space.start[node] + 1)[:, None] + np.arange(3 * d)
        turns.append(_turned(ties[node, :d, :, :d].reshape(-1, 3 * d, 3 * d), dofs))
    turned = np.concatenate([rows for _, rows, _, _ in turns])
    rest = np.setdiff1d(np.arange(space.n_dofs), turned)
    columns = np.concatenate([rest, *(c for _, _, c, _ in turns)])
    values = np.concatenate([np.ones(len(rest)), *(v for _, _, _, v in turns)])
    basis = sp.csr_matrix((values, (np.concatenate([rest, turned]), columns)), shape=(space.n_dofs,) * 2)
    return Supports(basis, np.unique(np.concatenate([held for held, _, _, _ in turns])))


def _turned(sums: Array, dofs: IntArray) -> tuple[IntArray, IntArray, IntArray, Array]:
    """Held coordinates, and rows, columns and values of the rotated axes, of blocks with coordinates `dofs` (n, k).

    The range of every sum (k, k) is to be held. Where it lies along the axes these are kept.
    """
    share = np.einsum("nii->ni", sums).copy()
    oblique = np.abs(sums - share[:, :, None] * np.eye(sums.shape[1])).max(axis=(1, 2)) > 1e-12
    share[oblique], vectors = np.linalg.eigh(sums[oblique])
    rows = np.broadcast_to(dofs[oblique][:, :, None], vectors.shape)
    return dofs[share > SAME_DIRECTION], rows.ravel(), rows.swapaxes(1, 2).ravel(), vectors.ravel()
