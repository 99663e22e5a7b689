"""Smoothing of triangulated surfaces without shrinking.

Taubin (1995), *Curve and surface smoothing without shrinkage*, ICCV 852-857: a step towards the mean of a node's
neighbours, and a slightly longer one back. Together they damp what is shorter than the pass band and keep the rest.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.mesh.shells import rims

#: Steps towards and from the mean of the neighbours: pass band 1 / TOWARDS + 1 / BACK = 0.1, as in the paper.
TOWARDS, BACK = 0.6307, -0.6732


def smoothed(points: Array, triangles: IntArray, steps: int) -> Array:
    """Points (n_points, 3) after so many pairs of steps; those on the rim of an open surface stay.

    Examples
    --------
    >>> x = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 0.3]])
    >>> smoothed(x, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]), 2)[4].round(3).tolist()
    [0.0, 0.0, 0.115]
    """
    n = len(points)
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    beside = sp.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
    beside = ((beside + beside.T) > 0).astype(float)
    mean = sp.diags_array(1 / np.maximum(np.asarray(beside.sum(axis=1)).ravel(), 1)) @ beside
    moves = np.ones((n, 1))
    moves[rims(triangles[:, [0, 1, 2, 2]])[0]] = 0.0
    x = points
    for _ in range(steps):
        for share in (TOWARDS, BACK):
            x = x + share * moves * (mean @ x - x)
    return x
