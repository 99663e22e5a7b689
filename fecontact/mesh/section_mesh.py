"""Meshes of sections: quadrilaterals in the plane y = 0 of a plate or of a body of revolution.

y runs through the thickness of a plate; of a body of revolution x is the radius and z the axis.

Points have three coordinates, the second of them zero, so that everything behind a mesh - poses, surfaces, forces - is
that of space. Sides run counter-clockwise seen with x to the right and z upwards; a side of three nodes has the weights
1/6, 4/6 and 1/6, all positive.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import positive
from fecontact.common.errors import InputError, MeshError
from fecontact.mesh.element.hexahedron import QUAD_EDGES, quad_quadrature, quad_shapes
from fecontact.mesh.hanging_nodes import HangingNodes, check_hanging, joined_hanging
from fecontact.mesh.mesh import first_alike, representatives, sets_of_members

CELL_TYPES = {8: "quad8", 9: "quad9"}
#: Distance from the plane y = 0, relative to the size of the mesh, that is rounding.
ON_PLANE = 1e-12
#: Nodes of a cell that runs clockwise in counter-clockwise order; side k becomes side 3 - k.
REVERSED = (0, 3, 2, 1, 7, 6, 5, 4, 8)
#: Local nodes of the four sides: the corners where it begins and ends, and the middle.
SIDES = np.concatenate([QUAD_EDGES, 4 + np.arange(4)[:, None]], axis=1)


@dataclass(frozen=True)
class Extent:
    """How far a section goes on: through a thickness, or round the axis.

    Attributes
    ----------
    thickness : float or None
        None: a body of revolution.

    Examples
    --------
    >>> import numpy as np
    >>> Extent(2.0)(np.array([[3.0, 0.0, 0.0]])).tolist()
    [2.0]
    """

    thickness: float | None

    @property
    def revolved(self) -> bool:
        """Whether the section is turned about the z axis."""
        return self.thickness is None

    def __call__(self, points: Array) -> Array:
        """Area per length of curve, or volume per area of section (...,), at points (..., 3)."""
        return 2 * np.pi * points[..., 0] if self.thickness is None else np.full(points.shape[:-1], self.thickness)

    def mean(self, vectors: Array) -> Array:
        """Vectors or points (n, 3) of the section averaged over what each stands for: round the axis only z is left."""
        return vectors * np.array([0.0, 0.0, 1.0]) if self.revolved else vectors


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


@dataclass(frozen=True, eq=False)
class SectionMesh:
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

    A member that a set lists more than once counts once.

    Raises
    ------
    MeshError
        Wrong shapes, points off the plane or not finite, unused or doubled points, inverted, folded or repeated cells.

    Examples
    --------
    >>> import fecontact as fc
    >>> fc.sections.rectangle((2.0, 1.0), (4, 2))
    SectionMesh(quad8, 8 cells, 37 points, boundaries: bottom, right, top, left)
    """

    points: Array
    cells: IntArray
    boundaries: Mapping[str, IntArray] = field(default_factory=dict)
    groups: Mapping[str, IntArray] = field(default_factory=dict)
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    hanging: HangingNodes | None = None

    def __post_init__(self) -> None:
        points = np.array(self.points, dtype=float)
        cells = np.array(self.cells, dtype=np.int64)
        if points.ndim == 2 and points.shape[1] == 2:
            points = np.insert(points, 1, 0.0, axis=1)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise MeshError(
                f"The points of a section must be finite and of shape (n, 3) or (n, 2); found {points.shape}."
            )
        if cells.ndim != 2 or cells.shape[1] not in CELL_TYPES or len(cells) == 0:
            raise MeshError(
                f"The cells of a section are quadrilaterals of 8 or 9 nodes; found the shape {cells.shape}."
            )
        if cells.min() < 0 or cells.max() >= len(points):
            raise MeshError(
                f"A cell refers to point {cells.max()}, but there are only {len(points)} points (0, 1, ...)."
            )
        off = np.abs(points[:, 1])
        if off.max() > ON_PLANE * np.linalg.norm(np.ptp(points, axis=0)):
            raise MeshError(
                f"A section lies in the plane y = 0; point {np.argmax(off)} has y = {points[off.argmax(), 1]:g}."
            )
        points[:, 1] = 0.0
        check_hanging(self.hanging, len(points))
        for name, value in {"points": points, "cells": cells}.items():
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        for name in ("boundaries", "groups", "node_sets"):
            sets = {k: np.asarray(v, dtype=np.int64) for k, v in getattr(self, name).items()}
            object.__setattr__(self, name, MappingProxyType(sets))
        self._check()
        for name in ("boundaries", "groups", "node_sets"):
            object.__setattr__(self, name, sets_of_members(getattr(self, name)))

    def _check(self) -> None:
        """Refuse what would be found as a wrong answer or a singular matrix much later."""
        used = np.zeros(len(self.points), bool)
        used[self.cells] = True
        if not used.all():
            raise MeshError(f"{(~used).sum()} points belong to no cell; the first is point {np.argmin(used)}.")
        size = np.linalg.norm(np.ptp(self.points, axis=0))
        pairs = cKDTree(self.points).query_pairs(1e-12 * size, output_type="ndarray")
        if len(pairs):
            raise MeshError(
                f"Points {pairs[0, 0]} and {pairs[0, 1]} lie in the same place; join them (merge_sections)."
            )
        for name, sides in self.boundaries.items():
            if sides.ndim != 2 or sides.shape[1] != 2 or (sides < 0).any() or (sides >= [len(self.cells), 4]).any():
                raise MeshError(
                    f"The boundary {name!r} must be (n, 2) pairs (cell, side), cells below {len(self.cells)} and sides "
                    f"0 ... 3; found the shape {sides.shape}."
                )
        for name, members in (*self.groups.items(), *self.node_sets.items()):
            if members.ndim != 1:
                raise MeshError(f"The set {name!r} of a section must be a list of numbers; found {members.shape}.")
        again = np.flatnonzero(first_alike(self.cells[:, :4]) != np.arange(len(self.cells)))
        middles = np.bincount(self.cells[:, 4:8].ravel(), minlength=len(self.points))
        if len(again) or middles.max() > 2:
            wrong = again[0] if len(again) else np.argmax((middles[self.cells[:, 4:8]] > 2).any(axis=1))
            raise MeshError(
                f"Cell {wrong} lies in another one: it has the corners of one before it, or a side with two others. "
                "Its stiffness would count twice; leave the copies out."
            )
        _, dN = quad_shapes(self.cells.shape[1], quad_quadrature()[0])
        det = jacobian_2d(self.points[self.cells], dN)[1]
        bad = ~(det > 0).all(axis=1)
        if bad.any():
            cell = int(np.argmax(bad))
            kind = "clockwise" if (det[cell] < 0).all() else "folded"
            raise MeshError(
                f"Cell {cell} is {kind} (smallest Jacobian {det[cell].min():.3g}); {bad.sum()} cells in all. Corners "
                "must run counter-clockwise seen with x to the right and z upwards."
            )

    def __reduce__(self) -> tuple[Any, ...]:
        """What goes to another process, or into a copy: what it was made from."""
        given = (getattr(self, f.name) for f in fields(self))
        return type(self), tuple(dict(v) if isinstance(v, Mapping) else v for v in given)

    def __repr__(self) -> str:
        names = ", ".join(self.boundaries) or "none"
        return f"SectionMesh({self.cell_type}, {len(self.cells)} cells, {len(self.points)} points, boundaries: {names})"

    @property
    def cell_type(self) -> str:
        """'quad8' or 'quad9'."""
        return CELL_TYPES[self.cells.shape[1]]

    @cached_property
    def outer_sides(self) -> IntArray:
        """Sides (n, 2) that belong to one cell only, as (cell, local side)."""
        middles = self.cells[:, 4:8].ravel()
        count = np.bincount(middles, minlength=len(self.points))
        return np.stack(np.divmod(np.flatnonzero(count[middles] == 1), 4), axis=1)

    def faces(self, name: str) -> IntArray:
        """Sides (n, 2) of a named boundary.

        Raises
        ------
        InputError
            If there is no such boundary; the message lists those there are.
        """
        if name not in self.boundaries:
            known = ", ".join(map(repr, self.boundaries)) or "none"
            raise InputError(f"The section has no boundary {name!r}. Its boundaries are: {known}.")
        return self.boundaries[name]

    def face_nodes(self, sides: IntArray) -> IntArray:
        """Node numbers (n, 3) of sides: beginning, end, middle."""
        return np.take_along_axis(self.cells[sides[:, 0]], SIDES[sides[:, 1]], axis=1)

    def boundary_nodes(self, name: str) -> IntArray:
        """Distinct node numbers of a named boundary, or of a node set where no boundary has that name."""
        if name in self.node_sets and name not in self.boundaries:
            return np.unique(self.node_sets[name])
        return np.unique(self.face_nodes(self.faces(name)))

    def mapped(self, mapping: Callable[[Array], ArrayLike]) -> SectionMesh:
        """Move every point by ``mapping(points) -> points``; hanging nodes follow the others."""
        points = np.asarray(mapping(self.points), dtype=float)
        return replace(self, points=points if self.hanging is None else self.hanging.followed(points))

    def translated(self, offset: ArrayLike) -> SectionMesh:
        """Move the mesh; to pose a body without touching its coordinates use `placed`."""
        shift = np.asarray(offset, dtype=float)
        return self.mapped(lambda x: x + shift)

    def scaled(self, factor: float) -> SectionMesh:
        """Multiply all coordinates."""
        scale = positive("a scale", factor)
        return self.mapped(lambda x: scale * x)

    def with_boundary(self, name: str, where: Callable[[Array], NDArray[np.bool_]]) -> SectionMesh:
        """Name outer sides: those of which ``where(points (n, 3)) -> (n,) bool`` holds at both ends and the middle.

        Raises
        ------
        InputError
            If no outer side is chosen.
        """
        inside = np.asarray(where(self.points), dtype=bool)
        chosen = self.outer_sides[inside[self.face_nodes(self.outer_sides)].all(axis=1)]
        if len(chosen) == 0:
            raise InputError(f"No outer side lies wholly in the region given for the boundary {name!r}.")
        return replace(self, boundaries={**self.boundaries, name: chosen})

    def with_group(self, name: str, where: Callable[[Array], NDArray[np.bool_]]) -> SectionMesh:
        """Name the cells whose mean corner satisfies ``where(centres (n, 3)) -> (n,) bool``."""
        centres = self.points[self.cells[:, :4]].mean(axis=1)
        return replace(self, groups={**self.groups, name: np.flatnonzero(where(centres))})


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
    """Cells (n, 8 | 9) that all run the one way or all the other, turned so that they run counter-clockwise."""
    a, b, c = (points[cells[0, k]] for k in (0, 1, 3))
    clockwise = (b - a)[0] * (c - a)[-1] < (b - a)[-1] * (c - a)[0]
    return cells[:, list(REVERSED[: cells.shape[1]])] if clockwise else cells


def merge_sections(meshes: list[SectionMesh], tolerance: float) -> SectionMesh:
    """Join sections of one cell type; points closer than `tolerance` (a length) become one point.

    Boundaries and groups of the same name are joined; sides that have become interior leave their boundaries.

    Raises
    ------
    MeshError
        If the cell types differ, or a hanging node would become one with a point of another section.
    """
    if len({m.cells.shape[1] for m in meshes}) != 1:
        raise MeshError(f"Sections of different cells cannot be merged: {sorted({m.cell_type for m in meshes})}.")
    point_start = np.cumsum([0] + [len(m.points) for m in meshes])[:-1]
    cell_start = np.cumsum([0] + [len(m.cells) for m in meshes])[:-1]
    points = np.concatenate([m.points for m in meshes])
    kept, number = np.unique(representatives(points, tolerance), return_inverse=True)
    cells = number[np.concatenate([m.cells + p for m, p in zip(meshes, point_start, strict=True)])]
    outer = SectionMesh(points[kept], cells).outer_sides
    is_outer = np.zeros((len(cells), 4), bool)
    is_outer[outer[:, 0], outer[:, 1]] = True
    boundaries: dict[str, list[IntArray]] = {}
    groups: dict[str, list[IntArray]] = {}
    node_sets: dict[str, list[IntArray]] = {}
    for m, c, p in zip(meshes, cell_start, point_start, strict=True):
        for name, sides in m.boundaries.items():
            moved = sides + np.array([c, 0])
            boundaries.setdefault(name, []).append(moved[is_outer[moved[:, 0], moved[:, 1]]])
        for name, members in m.groups.items():
            groups.setdefault(name, []).append(members + c)
        for name, nodes in m.node_sets.items():
            node_sets.setdefault(name, []).append(number[nodes + p])
    joined = {k: np.concatenate(v) for k, v in boundaries.items()}
    return SectionMesh(
        points[kept],
        cells,
        {k: v for k, v in joined.items() if len(v)},
        {k: np.concatenate(v) for k, v in groups.items()},
        {k: np.unique(np.concatenate(v)) for k, v in node_sets.items()},
        joined_hanging([m.hanging for m in meshes], np.split(number, point_start[1:]), len(kept)),
    )
