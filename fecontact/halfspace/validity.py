"""Whether a contact on a half-space keeps to what its theory assumes: small strains, small slopes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, Mask

#: A `HalfSpace` or a `HalfSpaceContact`, which ask for their own warnings: `grid`, `material`, `layers`, `periodic`.
OnCells = Any

LARGEST_STRAIN = 0.3
"""Displacement over half-width, a/R of a ball, from which results are warned of: linear theory errs by its square."""

LARGEST_SLOPE = 0.3
"""Rms slope of the counter-surface in the contact from which results are warned of."""


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
    if strain > LARGEST_STRAIN:
        yield (
            f"Strains are not small: {by} is {strain:.2g}, and errors are of the order of its square. Linear "
            "elasticity needs less than some 0.3: take a smaller load, and check the units of load, modulus and sizes."
        )
    slope = rms_slope(gap - displacement, body.grid.cell, active)
    if slope > LARGEST_SLOPE:
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
