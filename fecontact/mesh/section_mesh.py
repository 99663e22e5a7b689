"""Meshes of sections: quadrilaterals in the plane y = 0 of a plate or of a body of revolution.

y runs through the thickness of a plate; of a body of revolution x is the radius and z the axis.

Points have three coordinates, the second of them zero, so that poses, surfaces and forces are those of space. Sides run
counter-clockwise seen with x to the right and z upwards; a side of three nodes has the weights 1/6, 4/6 and 1/6, all
positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from fecontact.common.arguments import known_options
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import number_array
from fecontact.common.errors import MeshError
from fecontact.common.html import cell
from fecontact.common.units import UnitNames
from fecontact.mesh.base_mesh import BaseMesh, first_alike, joined
from fecontact.mesh.element import QUAD_EDGES, quad_quadrature, quad_shapes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Distance from the plane y = 0, relative to the size of the mesh, that counts as rounding.
ON_PLANE = 1e-12
#: Permutation of the nodes of a clockwise cell to counter-clockwise order; side k becomes side 3 - k.
REVERSED = (0, 3, 2, 1, 7, 6, 5, 4, 8)
#: Local nodes of the four sides: first corner, last corner, middle.
SIDES = np.concatenate([QUAD_EDGES, 4 + np.arange(4)[:, None]], axis=1)


@dataclass(frozen=True)
class Extent:
    """Out-of-plane extent of a section: its thickness, or the circumference of a body of revolution.

    Attributes
    ----------
    thickness : float or None
        None: a body of revolution.
    torsion : bool
        Whether a body of revolution has circumferential displacements too.

    Examples
    --------
    >>> import numpy as np
    >>> Extent(2.0)(np.array([[3.0, 0.0, 0.0]])).tolist()
    [2.0]
    """

    thickness: float | None
    torsion: bool = False

    @property
    def revolved(self) -> bool:
        """Whether the section is a meridian plane of a body of revolution about z."""
        return self.thickness is None

    def __call__(self, points: Array) -> Array:
        """Area per length of curve, or volume per area of section (...,), at points (..., 3)."""
        return 2 * np.pi * points[..., 0] if self.thickness is None else np.full(points.shape[:-1], self.thickness)

    def mean(self, vectors: Array) -> Array:
        """Vectors or points (n, 3) averaged over the out-of-plane extent: of a body of revolution only z remains."""
        return vectors * np.array([0.0, 0.0, 1.0]) if self.revolved else vectors

    def couples(self, points: Array, vectors: Array) -> Array:
        """Moments (n, 3) about the axis of vectors (n, 3) at points (n, 3) of rings; zero of a thickness."""
        about = np.zeros(vectors.shape)
        if self.revolved:
            about[:, 2] = points[:, 0] * vectors[:, 1]
        return about


def line_shapes(s: Array) -> tuple[Array, Array]:
    """Shape functions (n_q, 3) and slopes (n_q, 3) of a side at s in [0, 1]; nodes: beginning, end, middle.

    Examples
    --------
    >>> import numpy as np
    >>> line_shapes(np.array([0.25]))[0].tolist()
    [[0.375, -0.125, 0.75]]
    """
    N = np.stack([(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)], axis=-1)
    return N, np.stack([4 * s - 3, 4 * s - 1, 4 - 8 * s], axis=-1)


def line_integrals(points: Array, lines: IntArray) -> tuple[Array, Array, Array]:
    """Shape functions and outward elements of length of curved sides at four Gauss points.

    Parameters
    ----------
    points : (n_points, 3) array
    lines : (n_lines, 3) int array

    Returns
    -------
    N : (n_q, 3) array
    x : (n_lines, n_q, 3) array
    ds : (n_lines, n_q, 3) array
        Outward normal times length times quadrature weight.
    """
    t, w = np.polynomial.legendre.leggauss(4)
    N, dN = line_shapes((t + 1) / 2)
    nodes = points[lines]
    tangent = np.einsum("qa,fai->fqi", dN, nodes)
    normal = np.stack([tangent[..., 2], np.zeros_like(tangent[..., 0]), -tangent[..., 0]], axis=-1)
    return N, N @ nodes, normal * (w / 2)[:, None]


@dataclass(frozen=True, eq=False, repr=False)
class PlaneCells(BaseMesh):
    """Quadrilaterals of 8 or 9 nodes, and triangles ``a b c c  ab bc c ca``, of which a section is made."""

    _noun = "section"
    _face = "side"
    _made_of = "quadrilaterals of 8 or 9 nodes"
    cell_types = MappingProxyType({8: "quad8", 9: "quad9"})
    n_corners = 4
    n_faces = 4

    @cached_property
    def outer_sides(self) -> IntArray:
        """Sides (n, 2) that belong to one cell only, as (cell, local side).

        Those at which divided cells meet undivided ones are not outer.
        """
        middles = self.cells[:, 4:8].ravel()
        count = np.bincount(middles, minlength=len(self.points))
        if self.hanging is not None:
            count[self.hanging.edges[:, [1, 3, 4]]] = 2
        return np.stack(np.divmod(np.flatnonzero(count[middles] == 1), 4), axis=1)

    @property
    def is_flat(self) -> bool:
        """It lies in a plane."""
        return True

    @property
    def skin(self) -> IntArray:
        """Its cells (n_cells, 8 | 9)."""
        return self.cells

    def native_cells(self) -> list[tuple[str, IntArray, IntArray]]:
        """Cells with their name in meshio and their numbers."""
        return [(self.cell_type, self.cells, np.arange(len(self.cells)))]

    def drawn_at(self, points: Array) -> Self:
        """The bare mesh at other points (n_points, 3); turned half round, it keeps running counter-clockwise."""
        return type(self)(points, counter_clockwise(points, self.cells))

    @property
    def outer(self) -> IntArray:
        """The same as `outer_sides`, by the name shared with `Mesh`."""
        return self.outer_sides

    def face_nodes(self, sides: IntArray) -> IntArray:
        """Node numbers (n, 3) of sides: beginning, end, middle."""
        return np.take_along_axis(self.cells[sides[:, 0]], SIDES[sides[:, 1]], axis=1)


@dataclass(frozen=True, eq=False, repr=False)
class SectionMesh(PlaneCells):
    """Quadrilaterals of 8 or 9 nodes in the plane y = 0.

    Parameters
    ----------
    points : (n_points, 3) or (n_points, 2) array
        x, y = 0, z; or x, z.
    cells : (n_cells, 8 | 9) int array
        Corners counter-clockwise (x to the right, z upwards), then the middles of the sides, then the centre.
    boundaries : mapping of str to (n, 2) int array
        Named sets of sides, each as (cell, local side 0 ... 3).
    groups : mapping of str to (n,) int array
        Named sets of cells.
    node_sets : mapping of str to (n,) int array
        Named sets of points.
    hanging : HangingNodes, optional
        Ties of the nodes at which divided cells meet undivided ones; see `fecontact.mesh.hanging_nodes`.

    Repeated members of a set count once.

    Raises
    ------
    MeshError
        For wrong shapes, points off the plane, not finite or unused, inverted, folded or repeated
        cells.

    Examples
    --------
    >>> import fecontact as fc
    >>> fc.sections.rectangle((2.0, 1.0), (4, 2))
    SectionMesh(quad8, 8 cells, 37 points, boundaries: bottom, right, top, left)
    """

    def __post_init__(self) -> None:
        points = number_array("the points of a section", self.points)
        flat = points.ndim == 2 and points.shape[1] == 2
        object.__setattr__(self, "points", np.insert(points, 1, 0.0, axis=1) if flat else points)
        super().__post_init__()
        off = np.abs(self.points[:, 1])
        if off.max() > ON_PLANE * np.linalg.norm(np.ptp(self.points, axis=0)):
            raise MeshError(
                f"A section lies in the plane y = 0; point {np.argmax(off)} has y = {self.points[off.argmax(), 1]:g}.",
                code="off-plane",
            )
        if off.any():
            object.__setattr__(self, "points", np.insert(self.points[:, ::2], 1, 0.0, axis=1))
            self.points.setflags(write=False)
        self._check()

    def _check(self) -> None:
        """Refuse an invalid mesh, which would give wrong results or a singular matrix."""
        used = np.zeros(len(self.points), bool)
        used[self.cells] = True
        self._refuse_unused(used)
        again = np.flatnonzero(first_alike(self.cells[:, :4]) != np.arange(len(self.cells)))
        middles = np.bincount(self.cells[:, 4:8].ravel(), minlength=len(self.points))
        if len(again) or middles.max() > 2:
            wrong = again[0] if len(again) else np.argmax((middles[self.cells[:, 4:8]] > 2).any(axis=1))
            raise MeshError(
                f"Cell {wrong} lies in another one: it has the corners of one before it, or a side with two others. "
                "Its stiffness would count twice; leave the copies out.",
                code="double-cells",
            )
        _, dN = quad_shapes(self.cells.shape[1], quad_quadrature()[0])
        det = jacobian_2d(self.points[self.cells], dN)[1]
        bad = ~(det > 0).all(axis=1)
        if bad.any():
            cell = int(np.argmax(bad))
            kind = "clockwise" if (det[cell] < 0).all() else "folded"
            raise MeshError(
                f"Cell {cell} is {kind} (smallest Jacobian {det[cell].min():.3g}); {bad.sum()} cells in all. Corners "
                "must run counter-clockwise seen with x to the right and z upwards.",
                code="folded-cell",
            )

    def _repr_html_(self) -> str:
        return cell(repr(self), self.plot)

    def plot(self, path: str | Path | None = None, *, units: UnitNames = (), **options: Any) -> Figure:
        """Picture of the cells, boundaries as lines in colours and numbered: a matplotlib figure.

        Arguments and errors as in `Mesh.plot`; seen with x to the right and z upwards unless ``view`` is given.

        Examples
        --------
        >>> import fecontact as fc
        >>> figure = fc.sections.rectangle((2.0, 1.0), (4, 2)).plot(units="mm")
        >>> [text.get_text() for text in figure.legends[0].get_texts()][:2]
        ['1  bottom, 4 sides', '2  right, 2 sides']
        """
        from fecontact.mesh.picture import plot_sides

        known_options(plot_sides, options)
        shapes, _ = line_shapes(np.linspace(0.0, 1.0, 9))
        sides = {name: shapes @ self.points[self.face_nodes(members)] for name, members in self.boundaries.items()}
        return plot_sides(self.points, self.cells, sides, path, self.size_line, units=units, **options)


def jacobian_2d(x: Array, dN: Array) -> tuple[Array, Array]:
    """Inverse Jacobians (n_cells, n_q, 2, 2) and determinants (n_cells, n_q) of sections' cells.

    Parameters
    ----------
    x : (n_cells, n_nodes, 3) array
    dN : (n_q, n_nodes, 2) array
    """
    J = np.einsum("cai,qaj->cqij", x[:, :, [0, 2]], dN, optimize=True)
    det = J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0]
    adjugate = np.stack(
        [np.stack([J[..., 1, 1], -J[..., 0, 1]], -1), np.stack([-J[..., 1, 0], J[..., 0, 0]], -1)], axis=-2
    )
    return adjugate / np.where(det == 0, np.inf, det)[..., None, None], det


def counter_clockwise(points: Array, cells: IntArray) -> IntArray:
    """Consistently oriented cells (n, 8 | 9), reordered to run counter-clockwise."""
    a, b, c = (points[cells[0, k]] for k in (0, 1, 3))
    clockwise = (b - a)[0] * (c - a)[-1] < (b - a)[-1] * (c - a)[0]
    return cells[:, list(REVERSED[: cells.shape[1]])] if clockwise else cells


def merge_sections(meshes: list[SectionMesh], tolerance: float) -> SectionMesh:
    """Join sections of one cell type; points closer than `tolerance` (a length) become one point.

    Sets of the same name are joined; sides that have become interior leave their boundaries.

    Raises
    ------
    MeshError
        If the cell types differ, or a hanging node would become one with a point of another section.
    InputError
        If the tolerance would join points of one cell.
    """
    return joined(meshes, tolerance)
