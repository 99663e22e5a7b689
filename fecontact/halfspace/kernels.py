"""Influence coefficients of a half-space: surface displacement of a cell due to pressure on another.

All are for the modulus E* = 1 and depend on the offset between the cells only, evenly in both directions: a table (nx,
ny) over offsets 0, 1, 2, ... cells suffices.

Influence coefficients of tangential tractions on a half-space, and of pressures on tangential displacements.

Mid-cell values by a unit traction on one cell, as `kernels.love`: means over a cell of the kernels of a point force
(Cerruti). All depend on the offset between the cells only, evenly or oddly in each direction, so that a table (nx, ny)
over offsets 0, 1, 2, ... cells suffices. Elastic constants are factors and not in them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.halfspace.fft import each, strips

#: Offset, in cells, up to which Love's closed form is used. It is a second difference of a function that grows as the
#: distance: rounding grows as the square of the offset, to 1e-12 here. The multipole expansion used beyond neglects its
#: sixth-order term, 2e-3 offset^-6, 2e-12 here.
NEAR = 32

#: The same for bilinear pressures, a fourth difference: 5e-10 on either side.
NEAR_BILINEAR = 20

#: Distance from an edge of a cell that stands for none, over the cell's side: x asinh(y/x) is zero there.
ON_EDGE = 1e-30

#: Second moment over 2! and fourth over 4! of a uniform and of a linear (hat) weight on cells of unit width.
BOX_MOMENTS = (1 / 24, 1 / 1920)
HAT_MOMENTS = (1 / 12, 1 / 360)

#: Self term over nearest neighbour below which point forces on square cells have a negative eigenvalue: minus the
#: alternating sum of 1/r over the square lattice (Borwein, Borwein & Taylor, J. Math. Phys. 26 (1985) 2999).
MIN_RATIO = 1.6156

#: Rule of the report for point forces (Elangovan 1978): own displacement over that of the nearest cell.
SELF_TERM_RATIO = 2.0


def love(shape: tuple[int, int], cell: tuple[float, float], shift: float = 0.0) -> Array:
    """Mid-cell displacements by unit pressure on one cell (Love's rectangle), for E* = 1.

    Parameters
    ----------
    shape : (int, int)
        Number of offsets along x and y.
    cell : (float, float)
        Sides of a cell.
    shift : float
        Added to the offsets along x, in cells, not negative.

    Returns
    -------
    (nx, ny) array
        Displacement (length^3 / force, times E*) at offset (i, j) cells.

    References
    ----------
    A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) 377; K. L. Johnson, Contact Mechanics, 1985, chapter 3.

    Examples
    --------
    >>> import numpy as np
    >>> table = love((2, 2), (1.0, 1.0))
    >>> bool(np.isclose(table[0, 0], 4 * np.log(1 + np.sqrt(2)) / np.pi))
    True
    """
    X, Y, near = cells_near(shape, cell, NEAR, shift=shift)
    X[X == 0] = ON_EDGE * cell[0]
    table = _multipole(shape, cell, BOX_MOMENTS, shift)
    potential = X * np.arcsinh(Y / np.abs(X)) + Y * np.arcsinh(X / np.abs(Y))
    table[near] = np.diff(np.diff(potential, axis=0), axis=1) / math.pi
    return table


def bilinear(shape: tuple[int, int], cell: tuple[float, float]) -> Array:
    """Displacements at the nodes by pressures that are bilinear between them, for E* = 1.

    A hat function is a uniform pressure averaged over shifts by up to half a cell, so this is also the mean
    displacement of a cell by uniform pressure on another (Galerkin's method).

    Parameters
    ----------
    shape : (int, int)
        Number of offsets along x and y.
    cell : (float, float)
        Spacings of the nodes.

    Returns
    -------
    (nx, ny) array
        Displacement at offset (i, j) by the hat function of unit height.

    Notes
    -----
    Fourth difference of x^2 y asinh(y/x)/2 + x y^2 asinh(x/y)/2 - r^3/6, whose derivative twice in x and twice in y
    is 1/r.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 5.9; T. F. Eibert & V. Hansen, IEEE Trans. Antennas Propag. 43
    (1995) 1499.

    Examples
    --------
    >>> bilinear((2, 2), (1.0, 1.0)).round(4).tolist()
    [[0.9464, 0.354], [0.354, 0.2384]]
    """
    X, Y, near = cells_near(shape, cell, NEAR_BILINEAR, nodes=True)
    table = _multipole(shape, cell, HAT_MOMENTS)
    r = np.hypot(X, Y)
    with np.errstate(divide="ignore", invalid="ignore"):
        along_y = np.where(X == 0, 0.0, X**2 * Y * np.arcsinh(Y / np.abs(X)))
        along_x = np.where(Y == 0, 0.0, X * Y**2 * np.arcsinh(X / np.abs(Y)))
    potential = (along_y + along_x) / 2 - r**3 / 6
    table[near] = np.diff(np.diff(potential, 2, axis=0), 2, axis=1) / (math.pi * cell[0] * cell[1])
    return table


def cells_near(
    shape: tuple[int, int], cell: tuple[float, float], reach: int, nodes: bool = False, shift: float = 0.0
) -> tuple[Array, Array, tuple[slice, slice]]:
    """Edges of the cells near the origin (neighbouring nodes for bilinear pressure), and their part of the table."""
    far = (reach * max(cell) / cell[0] - shift, reach * max(cell) / cell[1])
    counts = [min(n, max(math.ceil(f), 0)) for n, f in zip(shape, far, strict=True)]
    edge, more = (1.0, 2) if nodes else (0.5, 1)
    X = np.asarray((np.arange(counts[0] + more) - edge + shift) * cell[0], dtype=float)[:, None]
    Y = np.asarray((np.arange(counts[1] + more) - edge) * cell[1], dtype=float)[None, :]
    return X, Y, (slice(0, counts[0]), slice(0, counts[1]))


def _multipole(
    shape: tuple[int, int], cell: tuple[float, float], moments: tuple[float, float], shift: float = 0.0
) -> Array:
    """Mean of 1/(pi r) under a weight on a cell, times its area, by the weight's second and fourth moments."""
    a, b = cell
    x2, y2 = ((np.arange(shape[0]) + shift) * a)[:, None] ** 2, (np.arange(shape[1]) * b)[None, :] ** 2
    # derivatives of 1/r by cx, the squared direction cosine, and cy = 1 - cx: d_xx = (3 cx - 1)/r^3, d_xxxx = (105 cx^2
    # - 90 cx + 9)/r^5, d_xxyy = (105 cx cy - 12)/r^5; collected by powers of cx
    second = moments[0] * np.array([2 * b * b - a * a, 3 * (a * a - b * b)])
    mixed = (moments[0] * a * b) ** 2
    fourth = moments[1] * np.array([9 * a**4 + 24 * b**4, -90 * a**4 - 120 * b**4, 105 * (a**4 + b**4)])
    fourth += mixed * np.array([-12.0, 105.0, -105.0])
    table = np.empty(shape)

    def fill(strip: slice) -> None:
        s = x2[strip] + y2
        if strip.start == 0 and not shift:
            s[0, 0] = 1.0
        np.divide(1.0, s, out=s)
        cx = x2[strip] * s
        terms = s * (fourth[0] + cx * (fourth[1] + cx * fourth[2]))
        terms += second[0] + cx * second[1]
        terms *= s
        terms += 1.0
        np.multiply(np.sqrt(s, out=s), a * b / math.pi, out=s)
        np.multiply(terms, s, out=table[strip])

    each(fill, strips(*shape))
    return table


def points(shape: tuple[int, int], cell: tuple[float, float], self_ratio: float = SELF_TERM_RATIO) -> Array:
    """Displacements by the pressure of one cell taken as a point force (Boussinesq), for E* = 1: the report's version.

    Parameters
    ----------
    shape : (int, int)
        Number of offsets along x and y.
    cell : (float, float)
        Sides of a cell.
    self_ratio : float
        Displacement under the force itself over that at the nearest other cell. The report's rule is 2; the exact
        ratio for the mean over a square cell is 4 ln(1 + sqrt(2)) = 3.5255 (Love).

    Returns
    -------
    (nx, ny) array
        Displacement (length^3 / force, times E*) at offset (i, j) cells.

    Raises
    ------
    InputError
        If the ratio is so small that the compliance is indefinite.

    References
    ----------
    J. Boussinesq, 1885; Johnson 1985, chapter 3; Elangovan 1978.

    Examples
    --------
    >>> table = points((2, 2), (1.0, 1.0))
    >>> float(table[0, 0] / table[0, 1])
    2.0
    """
    if not (math.isfinite(self_ratio) and self_ratio > MIN_RATIO):
        raise InputError(
            f"The ratio of the self term to the nearest neighbour's must exceed {MIN_RATIO}; found {self_ratio}.",
            code="ratio-too-small",
        )
    dx, dy = cell
    r = np.hypot((np.arange(shape[0]) * dx)[:, None], (np.arange(shape[1]) * dy)[None, :])
    r[0, 0] = min(dx, dy) / self_ratio
    return dx * dy / (math.pi * r)


def symbol(kx: Array, ky: Array) -> Array:
    """Displacement by a unit wave of pressure, 2/|k|, for E* = 1; zero for the mean.

    Parameters
    ----------
    kx, ky : arrays that broadcast together
        Wave numbers (1 / length).

    References
    ----------
    H. M. Westergaard, J. Appl. Mech. 6 (1939) A-49; Johnson 1985, section 13.2.

    Examples
    --------
    >>> import numpy as np
    >>> symbol(np.array([0.0, 3.0]), np.array([0.0, 4.0])).tolist()
    [0.0, 0.4]
    """
    k = np.hypot(kx, ky)
    return np.divide(2.0, k, out=np.zeros_like(k), where=k > 0)


#: Rule on a cell beyond `kernels.NEAR`: its error there is that of the sixth derivative, 4e-13 of the value.
GAUSS = np.polynomial.legendre.leggauss(3)


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
