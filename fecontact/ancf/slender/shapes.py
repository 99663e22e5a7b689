"""Shape functions of slender elements: polynomials fixed by positions and gradients at the nodes.

An element is a box of the lengths (lx, ly, lz) in its own axes. Its functions span a list of monomials; the coordinates
at each node are the position and some of the gradients dr/dx, dr/dy, dr/dz. The inverse of the values of the monomials
at the nodes gives the functions, once for the unit box; lengths scale them.

Sources: A. A. Shabana, Computational Continuum Mechanics, sections 5.7 to 5.12; for the planar beam of 12 coordinates
M. A. Omar & A. A. Shabana, J. Sound Vib. 243 (2001); for the plate A. Adini & R. W. Clough (1961); for that with r_xy
F. K. Bogner, R. L. Fox & L. A. Schmit (1965), with a gradient across J. Gerstmayr, H. Sugiyama & A. Mikkola, J. Comput.
Nonlinear Dyn. 8 (2013), eq. 11 to 13.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array

Order = tuple[int, int, int]
#: In place of a derivative: the way from the first node of an element to its second over its length.
CHORD: Order = (-1, 0, 0)

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
XX, YY, XY, XZ, YZ = (2, 0, 0), (0, 2, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)


#: Lobatto's points (n, 3) and weights (n,) on an element's axis.
ENDS_AND_MIDDLE = (np.array([[0.0, 0.5, 0.5], [0.5, 0.5, 0.5], [1.0, 0.5, 0.5]]), np.array([1.0, 4.0, 1.0]) / 6)

_CUBIC = ((0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0))
_ADINI = tuple((i, j, 0) for i in range(4) for j in range(4) if i + j < 4 or (i, j) in ((3, 1), (1, 3)))


@dataclass(frozen=True)
class Shape:
    """Polynomials of an element.

    Attributes
    ----------
    name : str
    powers : tuple of (int, int, int)
        Monomials x^i y^j z^k.
    nodes : tuple of (float, float, float)
        In the unit box; across a beam or plate its axis or middle surface is at zero.
    gradients : tuple of int
        Directions of the gradients that are coordinates of a node.
    mixed : bool
        Whether the second derivative r_xy is a coordinate of a node too, after the gradients.

    Examples
    --------
    >>> [(s.name, 3 * s.n_functions) for s in (LINE, PLATE)]
    [('line', 12), ('plate', 36)]
    """

    name: str
    powers: tuple[Order, ...]
    nodes: tuple[tuple[float, float, float], ...]
    gradients: tuple[int, ...]
    mixed: bool = False

    @property
    def orders(self) -> tuple[Order, ...]:
        """Derivatives of the position that are a node's vectors."""
        unit = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
        return ((0, 0, 0), *(unit[d] for d in self.gradients), *(((1, 1, 0),) if self.mixed else ()))

    @property
    def per_node(self) -> int:
        """Vectors of coordinates at a node."""
        return len(self.orders)

    @property
    def n_functions(self) -> int:
        """Functions of an element; three coordinates each."""
        return len(self.nodes) * self.per_node

    def _monomials(self, points: Array, order: Order) -> Array:
        """Derivatives (n, n_powers) of the monomials at points (n, 3) of the unit box."""
        columns = []
        for powers in self.powers:
            column = np.ones(len(points))
            for x, p, d in zip(points.T, powers, order, strict=True):
                if p or d:
                    column = column * (math.perm(p, d) * x ** max(p - d, 0))
            columns.append(column)
        return np.stack(columns, axis=1)

    @cached_property
    def _coefficients(self) -> Array:
        """Monomials' coefficients (n_powers, n_functions)."""
        places = np.array(self.nodes, dtype=float)
        rows = np.stack([self._monomials(places, o) for o in self.orders], axis=1)
        return np.asarray(np.linalg.inv(rows.reshape(self.n_functions, -1)), dtype=float)

    def functions(self, lengths: Array, points: Array, order: Order = (0, 0, 0)) -> Array:
        """Derivatives (n_elements, n_points, n_functions) of the functions along the element's axes.

        Parameters
        ----------
        lengths : (n_elements, 3) array
        points : (n_points, 3) array
            In the unit box.
        order : (int, int, int)
            Number of derivatives along each axis.
        """
        if order == CHORD:
            ends = self._monomials(np.array(self.nodes), (0, 0, 0)) @ self._coefficients
            unit = np.broadcast_to(ends[1] - ends[0], (len(points), self.n_functions))
            return np.asarray(unit[None] * (self._sized(lengths) / lengths[:, :1])[:, None])
        unit = self._monomials(points, order) @ self._coefficients
        scale = self._sized(lengths) / np.prod(lengths ** np.array(order), axis=1)[:, None]
        return np.asarray(unit[None] * scale[:, None])

    def functions_each(self, lengths: Array, points: Array, order: Order = (0, 0, 0)) -> Array:
        """Derivatives (n, n_functions) at a point (n, 3) of each element (n, 3), by coordinates of the unit box."""
        return np.asarray(self._monomials(points, order) @ self._coefficients * self._sized(lengths))

    def _sized(self, lengths: Array) -> Array:
        """Factors (n_elements, n_functions): one, and for derivatives the lengths along them."""
        scale = np.ones((len(lengths), self.n_functions))
        for k, order in enumerate(self.orders):
            scale[:, k :: self.per_node] = np.prod(lengths ** np.array(order), axis=1)[:, None]
        return scale


_ENDS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
_BICUBIC = tuple((i, j, 0) for i in range(4) for j in range(4))
_ACROSS = ((0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 1, 1))
_CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0))

#: Cable and Bernoulli beam, 12 coordinates (8 in a plane): r and dr/dx at two nodes.
LINE = Shape("line", _CUBIC, _ENDS, (0,))
#: Planar beam that shears, 18 coordinates (12 in its plane).
STRIP = Shape("strip", (*_CUBIC, (0, 1, 0), (1, 1, 0)), _ENDS, (0, 1))
#: Beam with three gradients, 24 coordinates.
BEAM = Shape("beam", (*_CUBIC, (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1)), _ENDS, (0, 1, 2))
#: Thin plate, 36 coordinates.
PLATE = Shape("plate", _ADINI, _CORNERS, (0, 1))
#: Plate with three gradients, 48 coordinates.
THICK_PLATE = Shape("thick plate", (*_ADINI, *_ACROSS), _CORNERS, (0, 1, 2))
#: The same with r_xy, 48 and 60 coordinates: bicubic, so that slopes are continuous.
SMOOTH_PLATE = Shape("smooth plate", _BICUBIC, _CORNERS, (0, 1), mixed=True)
SMOOTH_THICK_PLATE = Shape("smooth thick plate", (*_BICUBIC, *_ACROSS), _CORNERS, (0, 1, 2), mixed=True)


def rule(nx: int, ny: int = 1, nz: int = 1, across: tuple[bool, bool] = (False, False)) -> tuple[Array, Array]:
    """Gauss points (n, 3) and weights (n,) of the unit box; axes `across` run from -1/2 to 1/2."""
    each = [np.polynomial.legendre.leggauss(n) for n in (nx, ny, nz)]
    shift = (0.5, 0.0 if across[0] else 0.5, 0.0 if across[1] else 0.5)
    axes = [x / 2 + s for (x, _), s in zip(each, shift, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.einsum("i,j,k->ijk", *(w / 2 for _, w in each)).ravel()
    return points, weights


def at_nodes(shape: Shape) -> tuple[Array, Array]:
    """Nodes (n, 3) of the unit box and their equal weights (n,)."""
    return np.array(shape.nodes), np.full(len(shape.nodes), 1 / len(shape.nodes))
