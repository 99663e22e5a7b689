"""Local fits of a smooth surface round its nodes, by weighted least squares.

In axes u, v, w at a node, w along its normal, a fit is the zero level of

    F = w - (c1 u + c2 v + c3 u^2 + ... ),

which passes through the node. Three kinds are tried: a quadratic in u, v, a **quadric** (terms u w, v w, w^2 besides)
and a quartic in u, v. On every quadric (plane, sphere, cylinder, cone, ellipsoid, ...) the second is exact, however
coarse the facets; on other shapes the third converges with the fifth power of their size. The one with the least
generalised cross-validation, residual^2 / (data - unknowns)^2, is taken (Golub, Heath and Wahba 1979), so that noise
in the nodes favours few terms.

Fitting heights over tangent planes follows Cazals and Pouget (2005), *Estimating differential quantities using
polynomial fitting of osculating jets*; blending such fits (`surfaces.smooth`) follows Jiao and Wang (2012),
*Reconstructing high-order surfaces for meshing*. The quadric is our addition.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import comb

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import distinct_columns, sides_of, triangular
from fecontact.mesh.surface_mesh import averaged_normals

#: Powers of u, v and w in the terms of all fits.
TERMS = np.array(
    [(1, 0, 0), (0, 1, 0), (2, 0, 0), (1, 1, 0), (0, 2, 0), (1, 0, 1), (0, 1, 1), (0, 0, 2)]
    + [(k - j, j, 0) for k in (3, 4) for j in range(k + 1)]
)
#: Terms of the quadratic, the quadric and the quartic.
KINDS = (np.arange(5), np.arange(8), np.r_[:5, 8:17])
#: Neighbours of a node that a fit should have, in the interior and on the rim of a part, where they are on one side
#: only, and rings of facets within which they are looked for.
NEIGHBOURS, AT_RIM, MAX_RINGS = 24, 36, 5
#: Data beyond the unknowns, per unknown, that a fit must have.
SURPLUS = 0.25
#: Cosines of the angle to a node's normal below which neighbours do not count: of a polynomial in u, v, which steepens
#: there, and of a quadric, which may turn away.
MIN_COSINE, MIN_COSINE_OF_QUADRIC = 0.45, 0.1
#: Weight of a term: of all solutions the least is taken, whatever the axes (Bombieri's norm), and low powers first.
SIZE = np.array([0.7 ** (a + b + c) * np.sqrt(comb(a + b, a)) for a, b, c in TERMS.tolist()])
#: Largest ratio of the sizes of terms, in neighbourhoods far longer than wide.
MAX_SIZE = 1e4
#: Singular value, relative to the largest, below which data do not tell terms apart, of each kind.
CUT = (1e-4, 1e-4, 1e-3)
#: Least slope of F along w at the nearer data of a quadric: where it vanishes the surface folds.
MIN_SLOPE = 0.25
#: Validation, relative to that of fits with fewer terms, below which a quartic is taken: on few nodes it fits anything.
BETTER = 0.25
#: Residual, relative to the spread of the data, that is rounding, and validation, relative to its square, below which a
#: fit is exact.
ROUNDING, EXACT = 1e-12, 100.0
#: Spread of neighbours along an axis, relative to the largest, below which it is not scaled.
MIN_SPREAD = 1e-3
#: Residual of a fit, relative to how far the surface departs from its tangent plane, above which it is no fit: noise,
#: or an edge.
WORST = 0.3
#: Nodes that are fitted together, and those that are looked for or evaluated together: what bounds the memory.
BLOCK, ROWS = 2**11, 2**14


@dataclass(frozen=True, eq=False)
class LocalFits:
    """Fits round n nodes.

    Attributes
    ----------
    origins : (n, 3) array
        The nodes.
    axes : (n, 3, 3) array
        Rows u, v and w; w is the unit normal.
    scale : (n, 3) array
        Lengths in which u, v and w are measured.
    coefficients : (n, 17) array
        Of `TERMS`.
    is_fitted : (n,) bool array
        Whether the fit represents the neighbours; the others are to be left alone.
    """

    origins: Array
    axes: Array
    scale: Array
    coefficients: Array
    is_fitted: Mask

    def offsets(self, node: IntArray, points: Array, directions: Array, steps: int = 12) -> Array:
        """Distance (n,) along unit directions (n, 3) from points (n, 3) to the fits of nodes (n,); nan where none."""
        scale = self.scale[node]
        start = np.einsum("nij,nj->ni", self.axes[node], points - self.origins[node]) / scale
        along = np.einsum("nij,nj->ni", self.axes[node], directions) / scale
        t, size = np.zeros(len(node)), scale.max(axis=1)
        for _ in range(steps):
            value, slope = self._level(node, start + t[:, None] * along)
            rate = np.einsum("ni,ni->n", slope, along)
            steep = rate * scale[:, 2] > MIN_SLOPE / 2
            step = np.clip(value / np.where(steep, rate, np.inf), -0.5 * size, 0.5 * size)
            t = t - step
            if (np.abs(step) <= 1e-15 * size).all():
                break
        found = steep & (np.abs(step) <= 1e-10 * size)
        return np.where(found, t, np.nan)

    def normals(self, node: IntArray, points: Array) -> Array:
        """Unit normals (n, 3) of the fits of nodes (n,) at points (n, 3) on them."""
        scale = self.scale[node]
        local = np.einsum("nij,nj->ni", self.axes[node], points - self.origins[node]) / scale
        slope = np.einsum("nij,ni->nj", self.axes[node], self._level(node, local)[1] / scale)
        return slope / np.linalg.norm(slope, axis=1, keepdims=True)

    def _level(self, node: IntArray, local: Array) -> tuple[Array, Array]:
        """F (n,) and its gradient (n, 3) at scaled coordinates (n, 3)."""
        value, slope = np.empty(len(node)), np.empty_like(local)
        for start in range(0, len(node), ROWS):
            rows = slice(start, start + ROWS)
            c, power = self.coefficients[node[rows]], _powers(local[rows])
            factor = [power[k][:, TERMS[:, k]] for k in range(3)]
            value[rows] = local[rows, 2] - np.einsum("nk,nk->n", c, factor[0] * factor[1] * factor[2])
            for k in range(3):
                lowered = TERMS[:, k] * power[k][:, np.maximum(TERMS[:, k] - 1, 0)]
                slope[rows, k] = (k == 2) - np.einsum("nk,nk->n", c, lowered * factor[k - 1] * factor[k - 2])
        return value, slope


def local_fits(points: Array, facets: IntArray, wanted: IntArray) -> LocalFits:
    """Fit a smooth surface round some of its nodes.

    Parameters
    ----------
    points : (n_points, 3) array
        Nodes, all of them on the surface.
    facets : (n_facets, 4 | 8) int array
        One smooth part, or several without common nodes.
    wanted : (n,) int array
        Nodes round which fits are wanted.

    Returns
    -------
    LocalFits

    Examples
    --------
    >>> from fecontact.mesh.shapes import lattice
    >>> mesh = lattice((6, 6, 1), (None,) * 5 + ("top",), "hex8").mapped(lambda x: x + [-3, -3, 9.0])
    >>> points = 10 * mesh.points / np.linalg.norm(mesh.points, axis=1)[:, None]  # onto a sphere
    >>> fits = local_fits(points, mesh.face_nodes(mesh.faces("top")), np.array([97]))
    >>> up = np.array([[0.0, 0.0, 1.0]])
    >>> fits.offsets(np.array([0]), 9 * up, up).round(12).tolist()
    [1.0]
    """
    normals = averaged_normals(points, facets)[0]
    size = (len(wanted), 3)
    out = LocalFits(
        points[wanted], np.zeros((*size, 3)), np.ones(size), np.zeros((size[0], len(TERMS))), np.zeros(size[0], bool)
    )
    rim, ends, beside = _rim_and_rulings(facets, len(points))
    data = np.concatenate([points, points[ends].mean(axis=1)])
    facing = normals[ends].sum(axis=1)
    facing = np.concatenate([normals, facing / np.linalg.norm(facing, axis=1, keepdims=True)])
    facet, column = np.nonzero(distinct_columns(facets))
    node = np.concatenate([facets[facet, column], np.repeat(len(points) + np.arange(len(ends)), 2)])
    facet = np.concatenate([facet, beside.ravel()])
    belongs = sp.csr_matrix((np.ones(len(facet), np.float32), (node, facet)), shape=(len(data), len(facets)))
    wish = np.where(rim[wanted], AT_RIM, NEIGHBOURS)
    for first in range(0, len(wanted), ROWS):
        some = slice(first, first + ROWS)
        for rows, near in _neighbourhoods(belongs, wanted[some], wish[some]):
            for start in range(0, len(rows), BLOCK):
                part = slice(start, start + BLOCK)
                _fit(out, data, facing, wanted, first + rows[part], near[part])
    return out


def _rim_and_rulings(facets: IntArray, n: int) -> tuple[Mask, IntArray, IntArray]:
    """Which of n nodes are on the rim, ends (k, 2) of straight sides from rim to rim, and the facets (k, 2) at these.

    A row of linear quadrilaterals, one from rim to rim, does not say how it is bent that way: its sides are taken as
    rulings. Their middles count as nodes.
    """
    sides = sides_of(facets).reshape(-1, 2)
    order = np.argsort(np.sort(sides, axis=1) @ np.array([n, 1]), kind="stable")
    key = np.sort(sides[order], axis=1) @ np.array([n, 1])
    first = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    uses = np.diff(np.r_[first, len(key)])
    rim = np.zeros(n, bool)
    rim[sides[order[first[uses == 1]]]] = True
    shared = first[uses == 2]
    beside = np.stack([order[shared], order[shared + 1]], axis=1) // 4
    ends = sides[order[shared]]
    straight = rim[ends].all(axis=1) & ~triangular(facets)[beside].any(axis=1) & (facets.shape[1] == 4)
    return rim, ends[straight], beside[straight]


def _neighbourhoods(belongs: sp.csr_matrix, wanted: IntArray, wish: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Rows (k,) of `wanted` and the nodes (k, most) round them, -1 for none: rings of facets until they are as wished.

    `belongs` tells which nodes belong to which facets.
    """
    rows = np.arange(len(wanted))
    ring = belongs[wanted]
    for k in range(MAX_RINGS):
        near = (ring @ belongs.T).tocsr()
        count = np.diff(near.indptr)
        enough = (count > wish[rows]) | (k == MAX_RINGS - 1)
        for chosen in np.array_split(np.flatnonzero(enough)[np.argsort(count[enough], kind="stable")], 3):
            if len(chosen):
                of = near[chosen]
                length = np.diff(of.indptr)
                nodes = np.full((len(chosen), length.max()), -1, dtype=np.int64)
                nodes[np.arange(length.max()) < length[:, None]] = of.indices
                yield rows[chosen], nodes
        rows = rows[~enough]
        if len(rows) == 0:
            return
        ring = (near[~enough] @ belongs).tocsr()


def _fit(fits: LocalFits, points: Array, normals: Array, wanted: IntArray, rows: IntArray, near: IntArray) -> None:
    """Fill in the fits of some rows from the nodes (k, most) round them."""
    node = wanted[rows]
    real = (near >= 0) & (near != node[:, None])
    offset = np.where(real[..., None], points[near] - points[node][:, None], 0.0)
    cosine = np.einsum("nmi,ni->nm", normals[near], normals[node])
    real &= cosine > MIN_COSINE_OF_QUADRIC
    axes = _axes(offset, normals[node])
    local = np.einsum("nmi,nki->nmk", offset, axes)
    count = np.maximum(real.sum(axis=1), 1)
    scale = np.sqrt((local**2).sum(axis=1) / count[:, None])
    scale = np.maximum(scale, MIN_SPREAD * scale.max(axis=1, keepdims=True))
    scale = np.where(scale > 0, scale, 1.0)
    local = local / scale[:, None]
    # near neighbours count more
    weight = np.where(real, cosine / (np.linalg.norm(local[..., :2], axis=2) + 0.1) ** 2, 0.0)
    coefficients, is_fitted = _least_squares(local, weight, cosine > MIN_COSINE, scale)
    fits.axes[rows], fits.scale[rows] = axes, scale
    fits.coefficients[rows], fits.is_fitted[rows] = coefficients, is_fitted


def _axes(offset: Array, normals: Array) -> Array:
    """Principal axes (n, 3, 3) of offsets (n, m, 3) in the planes across normals (n, 3), and these normals."""
    across = np.eye(3)[np.abs(normals).argmin(axis=1)]
    one = np.cross(normals, across)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    plane = np.stack([one, np.cross(normals, one)], axis=1)
    flat = np.einsum("nmi,nki->nmk", offset, plane)
    turn = np.linalg.eigh(np.einsum("nmi,nmj->nij", flat, flat))[1]
    return np.concatenate([np.einsum("nij,nik->njk", turn, plane), normals[:, None]], axis=1)


def _least_squares(local: Array, weight: Array, faces: Mask, scale: Array) -> tuple[Array, Mask]:
    """Coefficients (n, 17) of the best kind of fit to local coordinates (n, m, 3), and whether it is good enough.

    Only neighbours that face as the node does (n, m) count for polynomials in u, v. Coordinates are in units of a scale
    (n, 3).
    """
    u, v, w = (power[..., exponent] for power, exponent in zip(_powers(local), TERMS.T, strict=True))
    terms = u * v * w * SIZE
    size = (scale[:, :2].max(axis=1, keepdims=True) / scale)[:, None] ** TERMS
    size = np.clip(size.prod(axis=2), None, MAX_SIZE)
    best, out = np.full(len(local), np.inf), np.zeros((len(local), len(TERMS)))
    floor = ROUNDING**2 * (weight**2).sum(axis=1)
    for k, (kind, cut) in enumerate(zip(KINDS, CUT, strict=True)):
        rows, quadric = np.flatnonzero(best > EXACT * floor), k == 1
        own = (weight if quadric else weight * faces)[rows]
        x, rank, rest = _solved(
            own[..., None] * terms[rows][..., kind], own * local[rows, :, 2], cut, size[rows][:, kind]
        )
        c = x * SIZE[kind]
        count = (own > 0).sum(axis=1)
        surplus = count - rank
        score = np.where(surplus >= SURPLUS * rank, (rest + floor[rows]) / np.maximum(surplus, 1) ** 2, np.inf) * count
        if quadric:
            slope = 1 - np.einsum("nmi,ni->nm", local[rows] * [1, 1, 2], c[:, 5:8])
            score[((slope < MIN_SLOPE) & faces[rows] & (own > 0)).any(axis=1)] = np.inf
        better = score < (BETTER if k == 2 else 1.0) * best[rows]
        rows = rows[better]
        best[rows], out[rows] = score[better], 0.0
        out[np.ix_(rows, kind)] = c[better]
    own = weight * faces
    plane = np.einsum("nmp,nm->np", np.linalg.qr(own[..., None] * terms[..., :2])[0], own * local[..., 2])
    bent = ((own * local[..., 2]) ** 2).sum(axis=1) - (plane**2).sum(axis=1)
    bent /= np.maximum((own > 0).sum(axis=1) - 2, 1)
    # where all is rounding any fit will do: it moves nothing
    return out, np.isfinite(best) & (best <= WORST**2 * bent + 10 * floor)


def _powers(local: Array) -> list[Array]:
    """Powers (..., 5) from 0 to 4 of the three coordinates (..., 3)."""
    square = local * local
    power = np.stack([np.ones_like(local), local, square, square * local, square * square], axis=-1)
    return [power[..., k, :] for k in range(3)]


def _solved(A: Array, b: Array, cut: float, size: Array) -> tuple[Array, IntArray, Array]:
    """Least squares A (n, m, p) x = b (n, m), the ranks (n,) and the sums of squares (n,) that are left.

    Singular values below `cut` times the largest count as zero. Of all solutions the one with least size x (n, p) is
    taken.
    """
    p = A.shape[2]
    if A.shape[1] < p:  # rows of zeros, so that R is square
        A, b = (np.concatenate([x, np.zeros((len(x), p - x.shape[1], *x.shape[2:]))], axis=1) for x in (A, b))
    Q, R = np.linalg.qr(A)
    U, S, V = np.linalg.svd(R)
    kept = cut * S[:, :1] < S
    z = np.einsum("npk,np->nk", U, np.einsum("nmp,nm->np", Q, b)) * kept
    x = np.einsum("nkp,nk->np", V, z / np.where(kept, S, 1.0))
    open_ = np.flatnonzero(~kept.all(axis=1))
    free = V[open_] * ~kept[open_, :, None]
    free = np.einsum("nkp,nkq->npq", free, free)
    heavy = free * size[open_, None] ** 2
    matrix = heavy @ free + np.eye(p) - free
    x[open_] -= np.einsum(
        "npq,nq->np", free, np.linalg.solve(matrix, np.einsum("npq,nq->np", heavy, x[open_])[..., None])[..., 0]
    )
    return x, kept.sum(axis=1), ((b - np.einsum("nmp,np->nm", A, x)) ** 2).sum(axis=1)
