"""Warnings of a contact on a half-space: strains and slopes that are not small, overlaps between middles of cells."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask
from fecontact.halfspace.fft import each, strips
from fecontact.surfaces.between_nodes import FALL, overlap_outline, smallest_gaps, star_area

#: A `HalfSpace` or a `HalfSpaceContact`, which ask for their own warnings: `grid`, `material`, `layers`, `periodic`.
OnCells = Any

#: Displacement over half-width, a/R of a ball, from which results are warned of: linear theory errs by its square.
MAX_STRAIN = 0.3

#: Rms slope of the counter-surface in the contact from which results are warned of.
MAX_SLOPE = 0.3


def validity_warnings(body: OnCells, pressure: Array, gap: Array, displacement: Array) -> Iterator[str]:
    """Warnings of strains and slopes that are not small, from fields (nx, ny) of a contact.

    Parameters
    ----------
    body : HalfSpace or HalfSpaceContact
    pressure, gap, displacement : (nx, ny) arrays
        Gaps after deformation and displacements into the body, without rigid motions.
    """
    active = pressure > 0
    if not active.any():
        return
    strain, by = _strain(body, active, pressure, displacement)
    if strain > MAX_STRAIN:
        yield (
            f"Strains are not small: {by} is {strain:.2g}, and errors are of the order of its square. Linear "
            "elasticity needs less than some 0.3: take a smaller load, and check the units of load, modulus and sizes."
        )
    slope = rms_slope(gap - displacement, body.grid.cell, active)
    if slope > MAX_SLOPE:
        yield (
            f"The counter-surface is steep where it touches: its rms slope is {slope:.2g}, and a half-space's contact "
            "assumes less than some 0.3. Check that heights and sizes are in the same unit."
        )


def _strain(body: OnCells, active: Mask, pressure: Array, displacement: Array) -> tuple[float, str]:
    """A strain that is typical of a contact, and its name."""
    largest = float(np.abs(displacement[active]).max())
    total = sum(layer.thickness for layer in body.layers)
    if body.material is None and body.periodic:
        return largest / total, "the displacement over the thickness of the layers"
    if body.periodic:
        top = body.layers[0].material if body.layers else body.material
        return float(pressure[active].mean()) / top.plane_strain_modulus, "the mean pressure over the modulus"
    sides = [(np.ptp(np.flatnonzero(active.any(axis=1 - axis))) + 1) * body.grid.cell[axis] for axis in (0, 1)]
    half_width = float(np.sqrt(sides[0] * sides[1])) / 2
    if body.material is None and total < half_width:
        return largest / total, "the displacement over the thickness of the layers"
    return largest / half_width, "the displacement over the half-width of the contact"


def rms_slope(z: Array, cell: tuple[float, float], counted: Mask | None = None) -> float:
    """Root of the mean squared slope between neighbouring cells, of which one counts; without any, zero.

    Examples
    --------
    >>> x = np.arange(4.0)[:, None] + np.zeros(3)
    >>> rms_slope(3.0 * x, (1.0, 1.0))
    3.0
    """
    squares = 0.0
    for axis, side in enumerate(cell):
        lines = np.moveaxis(z, axis, 0)
        with np.errstate(invalid="ignore"):  # infinite heights beside each other
            steps = np.diff(lines, axis=0) / side
        kept = np.isfinite(steps)
        if counted is not None:
            touching = np.moveaxis(counted, axis, 0)
            kept &= touching[1:] | touching[:-1]
        if kept.any():
            squares += float((steps[kept] ** 2).mean())
    return float(np.sqrt(squares))


def overlap_between_cells(contact: OnCells, heights: Callable[[Array, Array], Array], modulus: float) -> str:
    """Warning of heights, a function of x and y, that reach below the surface between cells without pressure; or none.

    The surface is displaced between the middles of the cells as they are, bilinearly. The force is that of
    `search.candidates.approach_for_load`, E* times depth times the root of the area over two.
    """
    grid, ny = contact.grid, contact.grid.shape[1]
    active, farthest = contact.active, contact.gap.max(where=np.isfinite(contact.gap), initial=-np.inf)

    def low_facets(strip: slice) -> IntArray:
        """Facets beside no pressure over which the gap may be negative; one row more is looked at on both sides."""
        first, last = max(strip.start - 1, 0), strip.stop + 2
        gap = np.minimum(contact.gap[first:last], farthest)
        lowest, highest = _of_four(np.minimum, gap), _of_four(np.maximum, gap)
        highest -= lowest
        if lowest.min() >= FALL * highest.max():
            return np.zeros(0, np.int64)
        beside = _of_four(np.maximum, _largest_near(active[first:last]))
        low = ~beside & (lowest < FALL * _largest_near(highest))
        return np.flatnonzero(low[strip.start - first :][: strip.stop - strip.start]) + strip.start * (ny - 1)

    facets = np.concatenate(each(low_facets, strips(grid.shape[0] - 1, ny)))
    if len(facets) == 0:
        return ""
    tilt = contact.tilt[0] * grid.x[:, None] + contact.tilt[1] * grid.y[None, :]
    sunk = contact.displacement if contact.dent is None else contact.displacement + contact.dent
    moved = (sunk - contact.approach + tilt).ravel()

    def place(facet: IntArray, local: Array) -> Array:
        first = np.stack(np.divmod(facet, ny - 1), axis=1)
        return np.array([grid.x[0], grid.y[0]]) + (first + local) * grid.cell

    def gap_at(facet: IntArray, local: Array) -> Array:
        (x, y), (s, t) = place(facet, local).T, local.T
        shapes = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        first, cell = facet + facet // (ny - 1), np.array([0, ny, ny + 1, 1])
        return np.asarray(heights(x, y) + np.einsum("na,na->n", shapes, moved[first[:, None] + cell]))

    size = grid.area**0.5
    least, local = smallest_gaps(gap_at, facets, np.zeros(len(facets), bool), np.full(len(facets), size))
    k = int(np.argmin(least))
    if least[k] >= -ROUNDING * size:
        return ""
    edge = overlap_outline(gap_at, int(facets[k]), local[k], False)
    x = np.zeros((len(edge) + 1, 3))
    x[:, :2] = place(np.full(len(x), facets[k]), np.vstack([local[k], edge]))
    width = star_area(x[0], x[1:]) ** 0.5
    return (
        f"The counter-surface overlaps the half-space by {-least[k]:.3g} at ({x[0, 0]:.4g}, {x[0, 1]:.4g}), between "
        f"cells that carry no pressure: Hertz's formulas give about {-modulus * least[k] * width / 2:.2g} for it. The "
        f"overlap is {width:.2g} wide: take cells of {width / 3:.1g}."
    )


def _largest_near(values: NDArray) -> NDArray:
    """Largest value (nx, ny) of a place and its eight neighbours."""
    for _ in range(2):  # along one axis, then along the other
        out = values.copy()
        np.maximum(out[1:], values[:-1], out=out[1:])
        np.maximum(out[:-1], values[1:], out=out[:-1])
        values = out.T
    return values


def _of_four(choose: np.ufunc, values: NDArray) -> NDArray:
    """Values (nx - 1, ny - 1) of the four cells round each corner, of which one is chosen."""
    pairs = choose(values[1:], values[:-1])
    return np.asarray(choose(pairs[:, 1:], pairs[:, :-1]))
