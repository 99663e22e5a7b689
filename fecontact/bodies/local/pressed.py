"""Displacements and stresses in a body below pressures on the cells of its window.

Forces act along the window's normal, as those of a contact do, on the half-space below the tangent plane of the
surface at the cell, with the first effect of curvature. Cells near a point are rectangles under pressure (Love) and,
where the surface inclines, shear. Farther ones are taken together in blocks that grow with their distance: forces at a
few Chebyshev nodes of a block stand for the pressures on it, as the field of a force is smooth there in the place of
the force.

Fields of the half-space's part of a local body's answer, at points of the body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.analytic import rectangle
from fecontact.analytic.face_loads import FaceLoads, displacements, stresses, tangent_axes
from fecontact.bodies.local.remainder import Remainder
from fecontact.bodies.local.window import Window, interpolation, nodes
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.material import Material
from fecontact.fem.stress import components, strain_of
from fecontact.halfspace.grid import unfold
from fecontact.halfspace.inside import ON_EDGE, in_cells, mean_distance

#: Nodes along a side of a block.
ORDER = 4

#: Distance of a point from a block, relative to half the block's diagonal, from which its nodes stand for it.
APART = 2.0

#: Largest blocks along the shorter side of a window.
LARGEST = 4

#: Points at a time, for memory.
CHUNK = 2000

DOWNWARDS = np.array([0.0, 0.0, -1.0])
HALVES = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])

OfLoads = Callable[[Array, FaceLoads, Material], Array]
ByCells = Callable[["_Near", Array], Array]


def depth_at(window: Window, places: Array) -> Array:
    """Depths (...) of the surface of a window at places (..., 2) of its plane."""
    relief = window.relief
    return np.zeros(places.shape[:-1]) if relief is None else relief.depth(places[..., 0], places[..., 1])


def inwards_at(window: Window, places: Array) -> Array:
    """Normals (..., 3) of the surface at places (..., 2), into the body, of height one."""
    out = np.zeros((*places.shape[:-1], 3))
    out[..., 2] = -1.0
    if window.relief is not None:
        out[..., :2] = -window.relief.slopes(places[..., 0], places[..., 1])
    return out


@dataclass(frozen=True, eq=False)
class Block:
    """Squares of cells of one size, (bx, by) of them over a window.

    Attributes
    ----------
    centres : (bx, by, 3) array
        In the window's coordinates.
    radius : float
        Half a diagonal.
    forces : (bx, by, k) array
        Forces at the nodes against the window's normal.
    places, normals : (bx, by, k, 3) arrays
        Nodes on the surface, and its normals into the body.
    curvatures : (bx, by, k, 3, 3) array or None
        Curvatures of the surface; None where it is flat.
    """

    centres: Array
    radius: float
    forces: Array
    places: Array
    normals: Array
    curvatures: Array | None


@dataclass(frozen=True, eq=False)
class Pressed:
    """Pressures on all cells of a window, those beyond planes of symmetry too.

    Attributes
    ----------
    window : Window
    pressure : (nx, ny) array
    material : Material

    Examples
    --------
    >>> from fecontact.halfspace.grid import Grid
    >>> window = Window(np.zeros(3), np.eye(3), Grid((2.0, 2.0), (16, 16)), (False, False))
    >>> below = Pressed.of(window, np.ones((16, 16)), Material(E=1.0, nu=0.25))
    >>> below.stress(np.array([[0.0, 0.0, 0.0]])).diagonal(axis1=1, axis2=2).round(3)
    array([[-0.75, -0.75, -1.  ]])
    """

    window: Window
    pressure: Array
    material: Material

    @classmethod
    def of(cls, window: Window, pressure: Array, material: Material) -> Pressed:
        """From pressures (nx, ny) on the modelled cells."""
        return cls(window, unfold(pressure, window.mirrored), material)

    @cached_property
    def _blocks(self) -> tuple[Block, ...]:
        """Blocks of 2, 4, 8, ... cells along a side."""
        most = max(1, int(np.log2(max(2, min(self.pressure.shape) // LARGEST))))
        return tuple(self._of_size(2**level) for level in range(1, most + 1))

    def _of_size(self, size: int) -> Block:
        window, cell = self.window, self.window.grid.cell
        short = [-n % size for n in self.pressure.shape]
        p = np.pad(self.pressure, [(0, short[0]), (0, short[1])])
        counts = (p.shape[0] // size, p.shape[1] // size)
        # the mean of a polynomial over a cell, by two points of Gauss
        ends = (np.arange(size)[:, None] + 0.5 + np.array([-1.0, 1.0]) / np.sqrt(12)) / size * 2 - 1
        spread = interpolation(ends.ravel(), 1.0, ORDER, False).reshape(size, 2, ORDER).mean(axis=1)
        forces = np.einsum("asbt,si,tj->abij", p.reshape(counts[0], size, counts[1], size), spread, spread)
        middles = [
            -half + (np.arange(n) + 0.5) * size * h for half, n, h in zip(window.half, counts, cell, strict=True)
        ]
        along = [m[:, None] + nodes(size * h / 2, ORDER, False) for m, h in zip(middles, cell, strict=True)]
        shape = (*counts, ORDER, ORDER)
        x = np.broadcast_to(along[0][:, None, :, None], shape).reshape(*counts, -1)
        y = np.broadcast_to(along[1][None, :, None, :], shape).reshape(*counts, -1)
        plane = np.stack([x, y], axis=-1)
        centre = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1)
        relief = window.relief
        return Block(
            np.concatenate([centre, -depth_at(window, centre)[..., None]], axis=-1),
            size * float(np.hypot(*cell)) / 2,
            forces.reshape(x.shape) * window.grid.area,
            np.concatenate([plane, -depth_at(window, plane)[..., None]], axis=-1),
            inwards_at(window, plane),
            None if relief is None else relief.curvature(x, y),
        )

    def displacement(self, points: Array) -> Array:
        """Displacements (n, 3) at points (n, 3) of the body, both in the window's coordinates."""
        return self._summed(points, np.zeros(points.shape), displacements, self._displacement_by_cells)

    def stress(self, points: Array) -> Array:
        """Stresses (n, 3, 3) at points (n, 3) of the body, both in the window's coordinates."""
        return self._summed(points, np.zeros((*points.shape, 3)), stresses, self._stress_by_cells)

    def _summed(self, points: Array, out: Array, of_loads: OfLoads, by_cells: ByCells) -> Array:
        """A field (n, ...) at points (n, 3), added to `out`."""
        for first in range(0, len(points), CHUNK):
            part = slice(first, first + CHUNK)
            for i, share in self._shares(points[part], of_loads, by_cells):
                np.add.at(out[part], i, share)
        return out

    def _shares(self, points: Array, of_loads: OfLoads, by_cells: ByCells) -> Iterator[tuple[IntArray, Array]]:
        """Points (m,) of pairs of point and block, and the field (m, ...) there by the block."""
        blocks = np.argwhere(self._blocks[-1].forces.any(axis=2))
        i, b = np.repeat(np.arange(len(points)), len(blocks)), np.tile(blocks, (len(points), 1))
        for level in range(len(self._blocks) - 1, -1, -1):
            block = self._blocks[level]
            apart = np.linalg.norm(points[i] - block.centres[b[:, 0], b[:, 1]], axis=1)
            far = apart > APART * block.radius
            if far.any():
                yield i[far], self._by_nodes(points[i[far]], block, b[far], of_loads)
            i = np.repeat(i[~far], len(HALVES))
            b = (2 * b[~far, None] + HALVES).reshape(-1, 2)
            smaller = self.pressure[..., None] if level == 0 else self._blocks[level - 1].forces
            loaded = np.asarray(smaller.any(axis=2))
            there = (b < loaded.shape).all(axis=1)
            there[there] = loaded[b[there, 0], b[there, 1]]
            i, b = i[there], b[there]
        yield i, by_cells(_Near.of(self.window, points[i], b), self.pressure[b[:, 0], b[:, 1]])

    def _by_nodes(self, points: Array, block: Block, b: IntArray, of_loads: OfLoads) -> Array:
        """Field (m, ...) at points (m, 3) by blocks b (m, 2)."""
        where = (b[:, 0], b[:, 1])
        forces = block.forces[where]
        loads = FaceLoads(
            block.places[where].reshape(-1, 3),
            block.normals[where].reshape(-1, 3),
            DOWNWARDS * forces.reshape(-1, 1),
            None if block.curvatures is None else block.curvatures[where].reshape(-1, 3, 3),
            None if block.curvatures is None else self.window.grid.size[0],
        )
        found = of_loads(np.repeat(points, forces.shape[1], axis=0)[:, None], loads, self.material)[:, 0]
        return np.asarray(found.reshape(*forces.shape, *found.shape[1:]).sum(axis=1))

    def _displacement_by_cells(self, near: _Near, pressure: Array) -> Array:
        u = rectangle.displacement(near.offsets, half_sides=near.half, pressure=1.0, material=self.material)
        return ((u * near.traction(pressure)[:, 2:])[:, None] @ near.axes)[:, 0]

    def _stress_by_cells(self, near: _Near, pressure: Array) -> Array:
        traction, stress = near.traction(pressure)[..., None, None], np.zeros((len(pressure), 3, 3))
        for axis in (2,) if self.window.relief is None else (2, 0, 1):
            stress += traction[:, axis] * rectangle.stress(
                near.offsets,
                half_sides=near.half,
                material=self.material,
                pressure=float(axis == 2),
                traction=(float(axis == 0), float(axis == 1)),
                corner_distance=mean_distance(*near.half),
            )
        return np.asarray(np.swapaxes(near.axes, 1, 2) @ stress @ near.axes)


@dataclass(frozen=True, eq=False)
class _Near:
    """Pairs of a point and a cell near it, on the half-space below the surface at the point.

    Attributes
    ----------
    offsets : (m, 3) array
        Of the point from the cell along x, against y, and below the surface.
    half : (float, float)
        Half the sides of a cell.
    axes : (m, 3, 3) array
        These directions in the window's coordinates, as rows.
    slant : (m,) array
        Area of the surface over that of the plane.
    """

    offsets: Array
    half: tuple[float, float]
    axes: Array
    slant: Array

    @classmethod
    def of(cls, window: Window, points: Array, cells: IntArray) -> _Near:
        """Pairs of points (m, 3) and cells (m, 2) of a window."""
        grid = window.grid
        inwards = inwards_at(window, points[:, :2])
        slant = np.linalg.norm(inwards, axis=1)
        below = (-points[:, 2] - depth_at(window, points[:, :2])) / slant
        below = np.where(below < ON_EDGE * min(grid.cell), 0.0, below)
        aside = (in_cells(points, grid) - cells - 0.5) * grid.cell
        half = (grid.cell[0] / 2, grid.cell[1] / 2)
        return cls(np.stack([aside[:, 0], -aside[:, 1], below], axis=1), half, tangent_axes(inwards), slant)

    def traction(self, pressure: Array) -> Array:
        """Tractions (m, 3) along the axes by pressures (m,) on the window's plane."""
        return np.asarray((pressure / self.slant)[:, None] * (self.axes @ DOWNWARDS))


#: Distance from the window, relative to its diagonal, beyond which the nodes' point loads stand for its cells.
NEAR = 0.5


@dataclass(frozen=True, eq=False)
class BelowWindows:
    """Fields of half-spaces below windows under pressure, in the body's axes.

    Far from a window the forces at its Chebyshev nodes stand for the pressures: there the field is as smooth in the
    point of the load as the remainder is, and on supports both cancel. Near it, see `Pressed`.

    Attributes
    ----------
    pressed : sequence of (Remainder, (nx, ny) array)
        Windows and the pressures on their cells.
    """

    pressed: Sequence[tuple[Remainder, Array]]

    def displacement(self, points: Array) -> Array:
        """Displacements (n, 3) at points (n, 3)."""
        out = np.zeros(points.shape)
        for found, p in self.pressed:
            near, axes = _near(found, points), found.window.axes
            for weight, load in zip(found.term.gathered(p), found.sources, strict=True):
                out[~near] += weight * displacements(points[~near], load, found.material).sum(axis=0)
            below = Pressed.of(found.window, p, found.material)
            out[near] += below.displacement(found.window.coordinates(points[near])) @ axes.T
        return out

    def strain(self, points: Array) -> Array:
        """Strains (n, 6) at points (n, 3)."""
        out = np.zeros((len(points), 6))
        for found, p in self.pressed:
            near, axes, stress = _near(found, points), found.window.axes, np.zeros((*points.shape, 3))
            for weight, load in zip(found.term.gathered(p), found.sources, strict=True):
                stress[~near] += weight * stresses(points[~near], load, found.material).sum(axis=0)
            below = Pressed.of(found.window, p, found.material)
            stress[near] = axes @ below.stress(found.window.coordinates(points[near])) @ axes.T
            out += strain_of(components(stress), found.material)
        return out


def _near(found: Remainder, points: Array) -> Mask:
    window = found.window
    local = window.coordinates(points)
    beside = np.maximum(np.abs(local[:, :2]) - window.half, 0.0)
    return np.asarray(np.hypot(np.linalg.norm(beside, axis=1), local[:, 2]) < NEAR * np.linalg.norm(2 * window.half))


@dataclass(frozen=True, eq=False)
class NodalFields:
    """Displacements below one window, as `BelowWindows` gives them, at fixed points and for many pressures.

    Attributes
    ----------
    found : Remainder
    points : (n, 3) array
    near : (n,) bool array
        Points near the window.
    far : (3 n_far, k) array
        Displacements of the others by unit forces at the window's nodes.
    """

    found: Remainder
    points: Array
    near: Mask
    far: Array

    @classmethod
    def of(cls, found: Remainder, points: Array) -> NodalFields:
        """At points (n, 3) of the body."""
        near = _near(found, points)
        each = [displacements(points[~near], load, found.material).sum(axis=0).ravel() for load in found.sources]
        return cls(found, points, near, np.stack(each, axis=1))

    def displacement(self, p: Array) -> Array:
        """Displacements (n, 3) by pressures (nx, ny) on the cells."""
        window, u = self.found.window, np.zeros(self.points.shape)
        u[~self.near] = (self.far @ self.found.term.gathered(p)).reshape(-1, 3)
        below = Pressed.of(window, p, self.found.material)
        u[self.near] = below.displacement(window.coordinates(self.points[self.near])) @ window.axes.T
        return u
