"""Influence coefficients of tangential tractions on a half-space, and of pressures on tangential displacements.

Mid-cell values by a unit traction on one cell, as `kernels.love`: means over a cell of the kernels of a point force
(Cerruti). All depend on the offset between the cells only, evenly or oddly in each direction, so that a table (nx, ny)
over offsets 0, 1, 2, ... cells suffices. Elastic constants are factors and not in them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.bodies.halfspace.kernels import NEAR, cells_near
from fecontact.common.arrays import Array

GAUSS = np.polynomial.legendre.leggauss(3)
"""Rule on a cell beyond `kernels.NEAR`: its error there is that of the sixth derivative, 4e-13 of the value."""


@dataclass(frozen=True, eq=False)
class CerrutiTables:
    """Integrals over one cell of the kernels of the distance (x, y), r = hypot(x, y), to the middle of another.

    Attributes
    ----------
    xx, yy : (nx, ny) arrays
        Of x^2/r^3 and y^2/r^3, even in x and y; their sum is that of 1/r.
    xy : (nx, ny) array
        Of x y/r^3, odd in x and y.
    x, y : (nx, ny) arrays
        Of x/r^2, odd in x, and y/r^2, odd in y.
    """

    xx: Array
    yy: Array
    xy: Array
    x: Array
    y: Array


def cerruti(shape: tuple[int, int], cell: tuple[float, float]) -> CerrutiTables:
    """Tables of the kernels of tangential tractions.

    Parameters
    ----------
    shape : (int, int)
        Number of offsets along x and y.
    cell : (float, float)
        Sides of a cell.

    Returns
    -------
    CerrutiTables

    Notes
    -----
    Near, second differences over the corners of the cell of y asinh(x/y), x asinh(y/x), -r, y ln r + x atan(y/x) and x
    ln r + y atan(x/y), whose mixed derivatives are the kernels; far, where their rounding would show, Gauss points.

    References
    ----------
    V. Cerruti, Acc. Lincei Mem. 13 (1882) 81; A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) 377; K. L. Johnson,
    Contact Mechanics, 1985, sections 3.2 and 3.6.

    Examples
    --------
    >>> import numpy as np
    >>> tables = cerruti((3, 3), (1.0, 1.0))
    >>> bool(np.isclose(tables.xx[0, 0] + tables.yy[0, 0], 4 * np.log(1 + np.sqrt(2)))), float(tables.xy[0, 2])
    (True, 0.0)
    """
    far = _far(shape, cell)
    X, Y, near = cells_near(shape, cell, NEAR)
    r = np.hypot(X, Y)
    along_x, along_y = X * np.arcsinh(Y / np.abs(X)), Y * np.arcsinh(X / np.abs(Y))
    log = np.log(r)
    potentials = (along_y, along_x, -r, Y * log + X * np.arctan(Y / X), X * log + Y * np.arctan(X / Y))
    for table, potential in zip(far, potentials, strict=True):
        table[near] = np.diff(np.diff(potential, axis=0), axis=1)
    xx, yy, xy, x, y = far
    xy[0], xy[:, 0], x[0], y[:, 0] = 0.0, 0.0, 0.0, 0.0  # exactly odd
    return CerrutiTables(xx, yy, xy, x, y)


def _far(shape: tuple[int, int], cell: tuple[float, float]) -> tuple[Array, Array, Array, Array, Array]:
    """The same by Gauss points in the cell, for offsets that are not near."""
    nodes, weights = GAUSS[0] / 2, GAUSS[1] / 2
    tables = tuple(np.zeros(shape) for _ in range(5))
    for a, wa in zip(nodes, weights, strict=True):
        X = ((np.arange(shape[0]) + a) * cell[0])[:, None]
        X2 = X**2
        for b, wb in zip(nodes, weights, strict=True):
            Y = ((np.arange(shape[1]) + b) * cell[1])[None, :]
            square = X2 + Y**2
            square[0, 0] = cell[0] * cell[1]
            inverse = (wa * wb * cell[0] * cell[1]) / square
            cubed = inverse / np.sqrt(square)
            terms = (X2 * cubed, Y**2 * cubed, X * Y * cubed, X * inverse, Y * inverse)
            for table, term in zip(tables, terms, strict=True):
                table += term
    xx, yy, xy, x, y = tables
    return xx, yy, xy, x, y
