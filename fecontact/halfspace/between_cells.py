"""Overlap of a counter-surface with a half-space between the middles of its cells, where its contact is judged."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.ndimage

from fecontact.common.arrays import Array, IntArray
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.surfaces.between_nodes import FALL, ROUNDING, overlap_outline, smallest_gaps, star_area


def overlap_between_cells(contact: HalfSpaceContact, heights: Callable[[Array, Array], Array], modulus: float) -> str:
    """Warning of heights, a function of x and y, that reach below the surface between cells without pressure; or none.

    The surface is displaced between the middles of the cells as they are, bilinearly. The force is that of
    `search.candidates.approach_for_load`, E* times depth times the root of the area over two.
    """
    grid, ny = contact.grid, contact.grid.shape[1]
    finite = np.isfinite(contact.gap)
    gap = np.where(finite, contact.gap, contact.gap[finite].max())
    lowest, highest = _of_four(np.minimum, gap), _of_four(np.maximum, gap)
    rise = scipy.ndimage.maximum_filter(highest - lowest, 3)
    beside = _of_four(np.maximum, scipy.ndimage.maximum_filter(contact.active, 3))
    facets = np.flatnonzero((beside == 0) & (lowest < FALL * rise))
    if len(facets) == 0:
        return ""
    tilt = contact.tilt[0] * grid.x[:, None] + contact.tilt[1] * grid.y[None, :]
    moved = (contact.displacement - contact.approach + tilt).ravel()

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


def _of_four(choose: np.ufunc, values: Array) -> Array:
    """Values (nx - 1, ny - 1) of the four cells round each corner, of which one is chosen."""
    pairs = choose(values[1:], values[:-1])
    return np.asarray(choose(pairs[:, 1:], pairs[:, :-1]))
