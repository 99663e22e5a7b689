"""Points of the skin of slender members: where friction acts, at a lever from axis or middle surface.

A point of the skin is one of the axis and a fibre f to it, which moves with the section,

    f = c_x r_x + c_y r_y + c_z r_z         elements with three gradients; c is constant
    f = c_x r_x + c_y r_y + c_n n           two; n is the unit normal, dn = -a^k (n . dr_k) with the dual base a^k
    f = c_x r_x + g,  g . r_x = 0           one; g turns with the axis, dg = -r_x (g . dr_x) / |r_x|^2

and is none of their own coordinates. A line has no twist: a turn about its axis leaves its fibres where they are, and
friction across the axis has no moment about it. Over a finite turn from the tangent t to t' a fibre g becomes

    g - (g . t') / (1 + t . t') (t + t').
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.slender.closest import Middle
from fecontact.common.arrays import Array, IntArray


def skin(
    middle: Middle, states: tuple[Array, Array], each: IntArray, local: Array, fibre: Array
) -> tuple[sp.csr_matrix, Array, Array]:
    """Points of the skin, their displacements by the coordinates, and where they were in an earlier state.

    Parameters
    ----------
    middle : Middle
    states : (then, now)
        Coordinates (n_dofs,) of all members.
    each, local : (n,) int array and (n, n_axes) array
        Elements, and coordinates on them.
    fibre : (n, 3) array
        From axis or middle surface to the skin, now.

    Returns
    -------
    rows : (3 n, n_dofs) csr_matrix
    then, now : (n, 3) arrays
    """
    first = len(middle.structure.shape.gradients)
    units = np.eye(3, dtype=int)[:first]
    N, D = middle.rows(each, local), np.stack([middle.rows(each, local, tuple(e)) for e in units], axis=1)
    vectors = [middle.part(q)[middle.structure.functions[each]] for q in states]
    (x0, g0), (x, g) = ((np.einsum("nf,nfi->ni", N, v), np.einsum("nkf,nfi->nki", D, v)) for v in vectors)
    turned, C = (_with_three, _with_two, _with_one)[3 - first](g0, g, fibre)
    values = N[:, :, None, None] * np.eye(3) + np.einsum("nkij,nkf->nfij", C, D)
    rows = _assembled(middle, each, values, len(states[0]))
    return rows, x0 + turned, x + fibre


def _with_three(g0: Array, g: Array, f: Array) -> tuple[Array, Array]:
    """Earlier fibres (n, 3) and their changes (n, k, 3, 3) by the gradients (n, k, 3)."""
    c = np.linalg.solve(g.swapaxes(1, 2), f[:, :, None])[:, :, 0]
    return np.einsum("nk,nki->ni", c, g0), c[:, :, None, None] * np.eye(3)


def _with_two(g0: Array, g: Array, f: Array) -> tuple[Array, Array]:
    (base, dual), (base0, _) = _frame(g), _frame(g0)
    c = np.einsum("nki,ni->nk", dual, f)
    C = c[:, :2, None, None] * np.eye(3)
    C -= c[:, 2, None, None, None] * dual[:, :2, :, None] * base[:, 2, None, None, :]
    return np.einsum("nk,nki->ni", c, base0), C


def _frame(g: Array) -> tuple[Array, Array]:
    """Two gradients (n, 2, 3) and the unit normal, and their dual base, (n, 3, 3) each."""
    across = np.cross(g[:, 0], g[:, 1])
    base = np.concatenate([g, (across / np.linalg.norm(across, axis=1, keepdims=True))[:, None]], axis=1)
    return base, np.linalg.inv(base).swapaxes(1, 2)


def _with_one(g0: Array, g: Array, f: Array) -> tuple[Array, Array]:
    a, a0 = g[:, 0], g0[:, 0]
    size = (a * a).sum(axis=1, keepdims=True)
    c = (f * a).sum(axis=1, keepdims=True) / size
    across = f - c * a
    t, t0 = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, a0))
    share = (across * t0).sum(axis=1, keepdims=True) / (1 + (t * t0).sum(axis=1, keepdims=True))
    C = c[:, :, None] * np.eye(3) - (a / size)[:, :, None] * across[:, None, :]
    return c * a0 + across - share * (t + t0), C[:, None]


def _assembled(middle: Middle, each: IntArray, values: Array, n_dofs: int) -> sp.csr_matrix:
    """Rows (3 n, n_dofs) of values (n, f, 3, 3): a component by the components of the vectors."""
    columns = middle.start + 3 * middle.structure.functions[each][:, :, None] + np.arange(3)
    across = values.transpose(0, 2, 1, 3)
    column = np.broadcast_to(columns[:, None], across.shape)
    row = np.arange(3 * len(values)).repeat(across[0, 0].size) if len(values) else np.zeros(0, np.int64)
    return sp.csr_matrix((across.ravel(), (row, column.ravel())), shape=(3 * len(values), n_dofs))
