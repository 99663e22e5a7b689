"""Middle surfaces of shells: nodes, their tangents, and quadrilateral cells of any shape.

A cell is a map of the unit square onto the surface, fixed by positions and derivatives at its corners. The derivatives
are combinations of the tangents that its nodes own, the same at all times (A. A. Shabana, Computational Continuum
Mechanics, sections 5.2 and 5.4): cells of any shape share them, and the surface is smooth at nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import lengths
from fecontact.common.errors import InputError

#: Step of the differences by which a map of the unit square is derived; those used are of order four.
STEP = 1e-3
#: Sine of an angle between the normals of neighbouring cells below which a surface is flat but for rounding.
FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class Surface:
    """A middle surface.

    Attributes
    ----------
    nodes : (n, 3) array
    tangents : (n, 2, 3) array
        Unit vectors of each node, in the surface: its gradients. The normal is first x second.
    cells : (n_cells, 4) int array
        Corners in turn, seen from where the normal points to.
    edges : (n_cells, 4, 2, 3) array
        Derivatives of the position by the coordinates of the unit square, at its corners in turn from (0, 0).
    mixed : (n, 3) array, optional
        Second derivatives along both tangents, of surfaces whose cells are images of a grid.

    Raises
    ------
    InputError
        For cells that are turned over or have an angle of 180 degrees or more.

    Examples
    --------
    >>> dome = Surface.mapped(lambda u, v: np.stack([u, v, 1 - u**2 - v**2], axis=-1), (4, 4))
    >>> dome.nodes.shape, dome.cells.shape
    ((25, 3), (16, 4))
    """

    nodes: Array
    tangents: Array
    cells: IntArray
    edges: Array
    mixed: Array | None = None

    def __post_init__(self) -> None:
        turned = np.einsum("cai,cai->ca", np.cross(self.edges[:, :, 0], self.edges[:, :, 1]), self.normals[self.cells])
        size = np.linalg.norm(self.edges, axis=3).prod(axis=2)
        bad = np.flatnonzero(~(turned > 1e-6 * size).all(axis=1))
        if len(bad):
            raise InputError(
                f"{len(bad)} cells of the surface are turned over, or have an angle of 180 degrees or more: "
                f"the first is {int(bad[0])}, nodes {self.cells[bad[0]].tolist()}.",
                code="cell-turned",
            )

    @property
    def normals(self) -> Array:
        """Unit vectors (n, 3)."""
        n = np.cross(self.tangents[:, 0], self.tangents[:, 1])
        return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))

    @property
    def lengths(self) -> Array:
        """Mean lengths (n_cells, 2) of the sides along both coordinates."""
        return np.asarray(np.linalg.norm(self.edges, axis=3).mean(axis=1))

    @property
    def frames(self) -> Array:
        """Derivatives along a cell's coordinates, over `lengths`, by the tangents of its nodes (n_cells, 4, 2, 2)."""
        inverse = np.linalg.pinv(self.tangents)[self.cells]
        return np.asarray(self.edges @ inverse / self.lengths[:, None, :, None])

    @classmethod
    def rolled(cls, corners: Sequence[ArrayLike], divisions: tuple[int, int], radius: float | None = None) -> Self:
        """A rectangle from three corners (o, along x, y), rolled along y round an axis along x if it has a radius.

        Raises
        ------
        InputError
            For sides that are not at right angles.
        """
        o, a, b = (np.asarray(c, dtype=float) for c in corners)
        x, y = a - o, b - o
        sides = np.linalg.norm(x), np.linalg.norm(y)
        if abs(x @ y) > 1e-12 * sides[0] * sides[1]:
            raise InputError("The sides of a plate must be at right angles.", code="plate-not-rectangular")
        (i, j), cells = _grid(divisions)
        nodes = o + i[:, None] * x + j[:, None] * y
        ex, ey = x / sides[0], y / sides[1]
        ez = np.cross(ex, ey)
        along = np.broadcast_to(ey, nodes.shape)
        if radius is not None:
            lengths(radius=radius)
            angle = (j * sides[1] / radius)[:, None]
            along = np.cos(angle) * ey + np.sin(angle) * ez
            nodes = o + i[:, None] * x + radius * (np.sin(angle) * ey + (1 - np.cos(angle)) * ez)
        tangents = np.stack([np.broadcast_to(ex, nodes.shape), along], axis=1)
        edges = tangents[cells] * (np.array(sides) / divisions)[:, None]
        return cls(nodes, tangents, cells, edges, np.zeros_like(nodes))

    @classmethod
    def mapped(cls, position: Callable[[Array, Array], Array], divisions: tuple[int, int]) -> Self:
        """The image of a grid on the unit square.

        Parameters
        ----------
        position : callable
            Points (.., 3) of coordinates u, v, each an array. It is derived by differences, and so must be defined up
            to 0.002 outside the square.
        divisions : (int, int)
            Cells along u and v. u to v turns about the normal.

        Examples
        --------
        >>> tube = Surface.mapped(lambda u, v: np.stack([np.cos(u), np.sin(u), v], axis=-1), (2, 1))
        >>> np.allclose(tube.normals[0], (1.0, 0.0, 0.0))
        True
        """
        (u, v), cells = _grid(divisions)
        weights = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12 * STEP)
        away = STEP * np.arange(-2, 3)
        both = np.broadcast_arrays(u[:, None, None] + away[:, None], v[:, None, None] + away)
        around = np.asarray(position(*both), dtype=float)
        along = (around[:, :, 2], around[:, 2])
        first = np.stack([np.einsum("a,nai->ni", weights, each) for each in along], axis=1)
        sizes = np.linalg.norm(first, axis=2, keepdims=True)
        mixed = np.einsum("a,b,nabi->ni", weights, weights, around) / sizes.prod(axis=1)
        edges = first[cells] / np.array(divisions)[:, None]
        return cls(around[:, 2, 2], first / sizes, cells, edges, mixed)

    @classmethod
    def of(
        cls, nodes: ArrayLike, cells: ArrayLike, normals: ArrayLike | None = None, along: ArrayLike = (1.0, 0.0, 0.0)
    ) -> Self:
        """A general quadrilateral mesh: sides of cells are as straight as the surface allows.

        Parameters
        ----------
        nodes : (n, 3) array
        cells : (n_cells, 4) int array
        normals : (n, 3) array, optional
            Of the surface at its nodes; of a flat mesh they are known.
        along : (3,) array, optional
            The first tangent lies along its projection; layers of laminates have their angles from there. Where it is
            a normal, the next axis takes its place.

        Raises
        ------
        InputError
            Without normals, if the mesh is not flat; for nodes that no cell uses.

        Examples
        --------
        >>> kite = Surface.of([(0, 0, 0), (2, 0, 0), (1.5, 1.5, 0), (0, 2, 0)], [(0, 1, 2, 3)])
        >>> kite.edges[0, 2, :, :2].tolist()
        [[1.5, -0.5], [-0.5, 1.5]]
        """
        x, corners = np.asarray(nodes, dtype=float), np.asarray(cells, dtype=np.int64)
        if x.ndim != 2 or x.shape[1] != 3 or corners.ndim != 2 or corners.shape[1] != 4 or not np.isfinite(x).all():
            raise InputError(f"A surface has nodes (n, 3) and cells (n, 4); found arrays {x.shape}, {corners.shape}.")
        if not np.array_equal(np.unique(corners), np.arange(len(x))):
            raise InputError(f"Cells must use all of the {len(x)} nodes, counted from 0, and no others.", code="nodes")
        n = _flat(x, corners) if normals is None else np.asarray(normals, dtype=float)
        if n.shape != x.shape or not (np.linalg.norm(n, axis=1) > 0).all():
            raise InputError(f"normals must be vectors {x.shape}, not zero; found an array {n.shape}.", code="normals")
        n = n / np.linalg.norm(n, axis=1, keepdims=True)
        guide = np.broadcast_to(np.asarray(along, dtype=float) / np.linalg.norm(along), x.shape)
        upright = np.abs((guide * n).sum(axis=1)) > np.cos(np.radians(5.0))
        guide = np.where(upright[:, None], np.roll(guide, 1, axis=1), guide)
        t = guide - (guide * n).sum(axis=1)[:, None] * n
        t /= np.linalg.norm(t, axis=1, keepdims=True)
        # of corners 0 to 3 the neighbours along both coordinates, and the sense in which these are passed
        towards, sense = np.array([[1, 3], [0, 2], [3, 1], [2, 0]]), np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        chords = x[corners[:, towards]] - x[corners][:, :, None]
        up = n[corners][:, :, None]
        lift = (chords * up).sum(axis=3, keepdims=True)
        size = np.linalg.norm(chords, axis=3, keepdims=True)
        within = chords - lift * up
        # an arc leaves its chord by an angle a and is longer by a / sin(a)
        sine = np.clip(np.abs(lift) / size, 0.0, 1.0)
        arc = size * np.where(sine > 1e-9, np.arcsin(sine) / np.maximum(sine, 1e-9), 1.0)
        edges = sense[..., None] * within / np.linalg.norm(within, axis=3, keepdims=True) * arc
        return cls(x, np.stack([t, np.cross(n, t)], axis=1), corners, edges)


def _grid(divisions: tuple[int, int]) -> tuple[tuple[Array, Array], IntArray]:
    """Coordinates (n,) of nodes on the unit square, the second counted first, and cells (n_cells, 4)."""
    nx, ny = divisions
    i, j = np.meshgrid(np.arange(nx + 1) / nx, np.arange(ny + 1) / ny, indexing="ij")
    first = (np.arange(nx)[:, None] * (ny + 1) + np.arange(ny)).ravel()
    return (i.ravel(), j.ravel()), first[:, None] + np.array([0, ny + 1, ny + 2, 1])


def _flat(x: Array, cells: IntArray) -> Array:
    """The normal (n, 3) of a flat mesh, at all nodes."""
    ways = np.roll(x[cells], -1, axis=1) - x[cells]
    n = np.cross(ways, np.roll(ways, -1, axis=1)).reshape(-1, 3)
    mean = n.sum(axis=0)
    off = np.linalg.norm(np.cross(n, mean), axis=1)
    if not (off <= FLAT * np.linalg.norm(mean) * np.linalg.norm(n, axis=1)).all():
        raise InputError("The surface is not flat: give its normals at the nodes, normals=.", code="normals")
    return np.broadcast_to(mean, x.shape)
