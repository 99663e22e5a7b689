"""Stresses inside a half-space under the pressures and tractions of a contact: free, layered, periodic.

Free and homogeneous: Love's rectangles, and those of Cerruti's potentials for tangential tractions. Free and layered:
in the top layer Love's rectangles of its material plus the smooth difference due to the layers, below it the whole
field, both from Hankel transforms of a point force's field, summed over the cells by a Gauss rule. Periodic: the
Fourier series of the pressures, each wave with its field. Here z points into the body; in results it points out of the
body.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fecontact.analytic import boussinesq, rectangle
from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import Material
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.layered import ON_INTERFACE, Hankel, Layer, wave_stress

Field = Callable[[Array, Array, Array], Array]

#: Wave number times depth beyond which a wave is negligible: exp(-40) = 4e-18.
DEEPEST_WAVE = 40.0

#: Weights of the Gauss rule with three points in each direction of a cell.
GAUSS_WEIGHTS = np.outer([5 / 18, 8 / 18, 5 / 18], [5 / 18, 8 / 18, 5 / 18]).ravel()

#: Distance in cells within which Love's closed form replaces that rule, whose error is 1e-6 of the cell beyond.
NEARBY = 4.0

#: Distance in cells within which the point force is omitted: subtracting it later would leave rounding.
CORE = 0.1

#: Distance in cells from a cell edge or from the surface that counts as rounding of the coordinates.
ON_EDGE = 1e-9

#: Pressures of one cell alone.
ALONE = np.pad(np.ones((1, 1)), 1)

#: Pairs of points and cells at a time below a line.
LINE = 1_000_000

#: Signs of xx, yy, zz, xy, yz, xz under reversal of z.
OUTWARDS = np.array([1.0, 1.0, 1.0, 1.0, -1.0, -1.0])


def in_cells(points: Array, grid: Grid) -> Array:
    """Positions (n, 2) of points in cells of a grid from its corner; integers on edges between cells."""
    place = points[:, :2] / grid.cell + np.array(grid.shape) / 2
    edge = np.rint(place)
    return np.where(np.abs(place - edge) < ON_EDGE, edge, place)


@dataclass(frozen=True, eq=False)
class Loaded:
    """A half-space under pressures on the cells of a grid.

    Attributes
    ----------
    grid : Grid
    pressure : (nx, ny) array
    material : Material or None
        Material below the layers; None: rigid.
    layers : sequence of Layer
    """

    grid: Grid
    pressure: Array
    material: Material | None
    layers: Sequence[Layer]

    def free(self, points: Array, chunk: int, waves: Hankel | None = None) -> Array:
        """Stress (n, 6) at points (n, 3), z into the body, under a surface that is free outside the grid.

        By a table of transforms for layers, where one is at hand.
        """
        top = self.layers[0] if self.layers else None
        if top is None:
            return self._homogeneous(2, self.pressure, points, _some(self.material), chunk)
        out = np.zeros((len(points), 6))
        near = points[:, 2] <= top.thickness * (1 + ON_INTERFACE)
        out[near] = self._homogeneous(2, self.pressure, points[near], top.material, chunk)
        waves = waves or self._waves(points)
        for z in np.unique(points[:, 2]):
            here = points[:, 2] == z
            spectrum = wave_stress(waves.k, float(z), self.layers, self.material)
            if z <= top.thickness * (1 + ON_INTERFACE):
                alone = [Layer(top.material, top.thickness)]
                spectrum = spectrum - wave_stress(waves.k, float(z), alone, top.material)
            out[here] += self._summed(_field(waves, spectrum), points[here], chunk)
        return out

    def _waves(self, points: Array) -> Hankel:
        reach = math.hypot(*(float(np.ptp(points[:, k])) + self.grid.size[k] for k in (0, 1)))
        return Hankel.up_to(reach + float(np.abs(points[:, :2]).max()), self.layers[0].thickness, DEEPEST_WAVE)

    def below(self, y: float, depths: Array) -> Array:
        """Stress (nx, n, 6) below the middles of the cells on a line, at depths (n,), under a free surface.

        The field of one cell, convolved with the pressures along x.
        """
        ix, iy = np.nonzero(self.pressure)
        box = slice(ix.min(), ix.max() + 1), slice(iy.min(), iy.max() + 1)
        cell = replace(self, grid=Grid((3 * self.grid.cell[0], 3 * self.grid.cell[1]), (3, 3)), pressure=ALONE)
        dx = np.arange(1 - box[0].stop, self.grid.shape[0] - box[0].start) * self.grid.cell[0]
        offsets = np.stack([a.ravel() for a in np.meshgrid(dx, y - self.grid.y[box[1]], 0.0, indexing="ij")], axis=1)
        waves = cell._waves(offsets) if self.layers else None
        lines = []
        for depth in depths:
            field = cell.free(offsets + np.array([0.0, 0.0, depth]), LINE, waves).reshape(len(dx), -1, 6)
            lines.append(scipy.signal.fftconvolve(field, self.pressure[box][..., None], "valid", axes=0).sum(axis=1))
        return np.stack(lines, axis=1)

    def _cells(self, loads: Array) -> tuple[IntArray, Array, Array]:
        """Numbers (m, 2), centres (m, 3) and loads (m,) of the cells with a load, of loads (nx, ny)."""
        ix, iy = np.nonzero(loads)
        centres = np.stack([self.grid.x[ix], self.grid.y[iy], np.zeros(len(ix))], axis=1)
        return np.stack([ix, iy], axis=1), centres, loads[ix, iy]

    def sheared(self, points: Array, tractions: Array, chunk: int) -> Array:
        """Stress (n, 6) at points (n, 3), z into the body, by tractions (2, nx, ny) on a homogeneous half-space."""
        material = _some(self.material)
        by_axis = [self._homogeneous(axis, given, points, material, chunk) for axis, given in enumerate(tractions)]
        return np.asarray(sum(by_axis))

    def _homogeneous(self, axis: int, given: Array, points: Array, material: Material, chunk: int) -> Array:
        """Stress (n, 6) in a homogeneous half-space by loads (nx, ny) along an axis.

        Of point forces on the cells, and of rectangles for nearby cells.
        """
        half_sides, core = (self.grid.cell[0] / 2, self.grid.cell[1] / 2), CORE * min(self.grid.cell)
        unit = (float(axis == 0), float(axis == 1), float(axis == 2))

        def point(x: Array, y: Array, z: Array) -> Array:
            return boussinesq.stress_components(x, y, z, unit, material.nu, core)

        out = self._summed(point, points, chunk, given)
        number, centres, loads = self._cells(given)
        place = in_cells(points, self.grid)
        depth = np.where(points[:, 2] < ON_EDGE * min(self.grid.cell), 0.0, points[:, 2])
        near = cKDTree(points).sparse_distance_matrix(
            cKDTree(centres), NEARBY * max(self.grid.cell), output_type="ndarray"
        )
        for first in range(0, len(near), chunk):
            i, j = near["i"][first : first + chunk], near["j"][first : first + chunk]
            offsets = np.column_stack([(place[i] - number[j] - 0.5) * self.grid.cell, depth[i]])
            cell = rectangle.stress(
                offsets,
                half_sides=half_sides,
                material=material,
                pressure=unit[2],
                traction=unit[:2],
                corner_distance=mean_distance(*half_sides),
            )
            better = np.stack([cell[:, a, b] for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))], axis=1)
            # as in `_summed`, so that both omit the same
            places = points[i, None, :2] - (centres[j, None, :2] + self._gauss)
            gauss = point(places[..., 0], places[..., 1], points[i, 2, None])
            change = better - self.grid.area * np.einsum("nci,c->ni", gauss, GAUSS_WEIGHTS)
            np.add.at(out, i, change * loads[j, None])
        return out

    @property
    def _gauss(self) -> Array:
        """Gauss points (9, 2) of a cell."""
        x = math.sqrt(0.15) * np.array([-1.0, 0.0, 1.0])
        return np.array([(s, t) for s in x for t in x]) * self.grid.cell

    def _summed(self, field: Field, points: Array, chunk: int, given: Array | None = None) -> Array:
        """Field of a point force, summed over the cells with nine points each; loads (nx, ny), or the pressures."""
        _, centres, loads = self._cells(self.pressure if given is None else given)
        out = np.zeros((len(points), 6))
        step = max(1, chunk // max(1, 9 * len(points)))
        z = points[:, None, 2]
        for first in range(0, len(loads), step):
            part = slice(first, first + step)
            sources = (centres[part, None, :2] + self._gauss).reshape(-1, 2)
            weights = (loads[part, None] * self.grid.area * GAUSS_WEIGHTS).ravel()
            offsets = points[:, None, :2] - sources
            out += np.einsum("nci,c->ni", field(offsets[..., 0], offsets[..., 1], z), weights)
        return out

    def periodic(self, points: Array) -> Array:
        """Stress (n, 6) at points (n, 3), z into the body, under a periodic surface; the mean strain is zero."""
        grid = self.grid
        waves = [
            np.asarray(2 * math.pi * np.fft.fftfreq(n, s / n), dtype=float)
            for n, s in zip(grid.shape, grid.size, strict=True)
        ]
        amplitude = np.fft.fft2(self.pressure) / grid.n_cells
        layers = self.layers or [Layer(_some(self.material), max(grid.size))]
        out = np.empty((len(points), 6))
        for z in np.unique(points[:, 2]):
            here = points[:, 2] == z
            kept = [np.flatnonzero(np.abs(k) * z <= DEEPEST_WAVE) for k in waves]
            kx, ky = (k[kept_k] for k, kept_k in zip(waves, kept, strict=True))
            spectra = _wave_field(kx[:, None], ky[None, :], float(z), layers, self.material)
            spectra *= amplitude[np.ix_(*kept)]
            ex = np.exp(1j * np.outer(points[here, 0] - grid.x[0], kx))
            ey = np.exp(1j * np.outer(points[here, 1] - grid.y[0], ky))
            out[here] = np.stack([((ex @ s) * ey).sum(axis=1).real for s in spectra], axis=1)
        return out


def mean_distance(a: float, b: float) -> float:
    """Geometric mean of the distance from the middle over a rectangle with half-sides a, b."""
    return math.hypot(a, b) * math.exp(-1.5 + a / (2 * b) * math.atan(b / a) + b / (2 * a) * math.atan(a / b))


def _some(material: Material | None) -> Material:
    assert material is not None
    return material


def _wave_field(kx: Array, ky: Array, z: float, layers: Sequence[Layer], base: Material | None) -> NDArray:
    """Factors (6, nx, ny) of e^(i k x) in xx, yy, zz, xy, yz, xz under pressures e^(i k x)."""
    k = np.hypot(kx, ky)
    distinct, inverse = np.unique(k.round(12 - int(np.log10(k.max() or 1.0))), return_inverse=True)
    along, across, normal, shear = wave_stress(distinct, z, layers, base)[inverse.ravel()].T.reshape(4, *k.shape)
    safe = np.where(k > 0, k, 1.0)
    c, s = kx / safe, ky / safe
    out = np.stack(
        [
            c**2 * along + s**2 * across,
            s**2 * along + c**2 * across,
            normal,
            c * s * (along - across),
            -1j * s * shear,
            -1j * c * shear,
        ]
    )
    nu = _material_at(z, layers, base).nu
    out[:, k == 0] = -np.array([nu / (1 - nu), nu / (1 - nu), 1.0, 0.0, 0.0, 0.0])[:, None]
    return out


def _material_at(z: float, layers: Sequence[Layer], base: Material | None) -> Material:
    above = 0.0
    for layer in layers:
        above += layer.thickness
        if z <= above * (1 + ON_INTERFACE):
            return layer.material
    return _some(base)


def _field(waves: Hankel, spectrum: Array) -> Field:
    """Stress (..., 6) at offsets x, y from a unit force, from a spectrum (n_k, 4) of `layered.wave_stress`."""
    along, across, normal, shear = (spectrum * waves.k[:, None]).T
    transforms = waves.of((0, (along + across) / 2), (2, (across - along) / 2), (0, normal), (1, shear))

    def at(x: Array, y: Array, z: Array) -> Array:
        mean, difference, normal, shear, c, s = transforms(x, y)
        turned = difference * (c**2 - s**2)
        parts = [mean + turned, mean - turned, normal, 2 * difference * c * s, shear * s, shear * c]
        return np.stack(parts, axis=-1)

    return at
