"""Compliance of a half-space: materials, layers, kind of pressure, free or periodic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.analytic import curved_kernel
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace import kernels, layered
from fecontact.halfspace.grid import Grid

PRESSURES = ("uniform", "bilinear", "point")


@dataclass(frozen=True)
class Bend:
    """Curvature of a body's surface, see `analytic.curved_kernel`.

    Attributes
    ----------
    material : Material
    curvature : (float, float)
        Principal curvatures along x and y, convex positive.
    """

    material: Material
    curvature: tuple[float, float]


@dataclass(frozen=True, eq=False)
class SurfaceCompliance:
    """Displacement of the cells of a grid by pressure on them, also for coarser grids.

    Parameters
    ----------
    grid : Grid
    material : Material or None
        Material of the half-space below the layers; None: rigid.
    layers : sequence of Layer
    against : Material or None
        Material of a counter-body whose compliance is added; None: rigid.
    pressure : {'uniform', 'bilinear', 'point'}
    self_ratio : float
        With 'point': see `kernels.points`.
    periodic : bool
    bent : tuple of Bend
        Curvatures of the surfaces of the bodies that it represents, whose first effect is added; for free ones.
    arrays : str, optional
        Module whose arrays are transformed, see `array_module`.
    """

    grid: Grid
    material: Material | None
    layers: Sequence[layered.Layer]
    against: Material | None
    pressure: str
    self_ratio: float
    periodic: bool
    bent: tuple[Bend, ...] = ()
    arrays: str | None = None

    def __post_init__(self) -> None:
        among("pressure", self.pressure, PRESSURES)
        if self.material is None and not self.layers:
            raise InputError("A half-space without material is rigid; give a material, or layers on the rigid base.")
        if (self.layers or self.periodic) and self.pressure != "uniform":
            raise InputError(
                f"pressure={self.pressure!r} is available for a homogeneous, free half-space only; use 'uniform'.",
                code="pressure-not-available",
            )
        if self.periodic and (self.grid.shape[0] % 2 or self.grid.shape[1] % 2):
            raise InputError(
                f"A periodic half-space needs even numbers of cells; found {self.grid.shape}. "
                "Drop or repeat no row: resample the surface, or use periodic=False.",
                code="odd-cells",
            )

    @property
    def modulus(self) -> float:
        """Contact modulus E* of the homogeneous bodies together; of the top layer where there are layers."""
        own = self.layers[0].material if self.layers else self.material
        assert own is not None
        return 1 / sum(1 / m.plane_strain_modulus for m in (own, self.against) if m is not None)

    @property
    def length(self) -> float:
        """Unit of length of the logarithm that curvature brings."""
        return self.grid.size[0]

    @property
    def mean_is_stiff(self) -> bool:
        """Whether a mean pressure causes no displacement: periodic surfaces, relative to their mean plane."""
        return self.material is not None

    def kernel(self, level: int = 0) -> Array:
        """Kernel of the grid coarsened `level` times by two, see `nested.GridLevel.kernel`."""
        if self.periodic:
            return self._symbol(level)
        counts = tuple(-(-n // 2**level) + (level > 0) for n in self.grid.shape)
        shape = (min(counts[0], self.grid.shape[0]), min(counts[1], self.grid.shape[1]))
        cell = (self.grid.cell[0] * 2**level, self.grid.cell[1] * 2**level)
        if self.layers:
            table = layered.table(shape, cell, self.layers, self.material)
            if self.against is not None:
                table += kernels.love(shape, cell) / self.against.plane_strain_modulus
        else:
            # 1/r has no intrinsic length: the table of a coarser grid is part of this one, scaled
            table = self._table if level == 0 else self._table[: shape[0], : shape[1]] * 2.0**level
        for bend in self.bent:
            table = table + curved_kernel.bent_table(
                shape, cell, curvature=bend.curvature, length=self.length, material=bend.material
            )
        return table

    @cached_property
    def _table(self) -> Array:
        if self.pressure == "point":
            table = kernels.points(self.grid.shape, self.grid.cell, self.self_ratio)
        else:
            make = kernels.love if self.pressure == "uniform" else kernels.bilinear
            table = make(self.grid.shape, self.grid.cell)
        table /= self.modulus
        return table

    def _symbol(self, level: int) -> Array:
        halves = [n // 2 ** (level + 1) for n in self.grid.shape]
        kx, ky = (2 * math.pi / side * np.arange(m + 1) for side, m in zip(self.grid.size, halves, strict=True))
        if not self.layers:
            return kernels.symbol(kx[:, None], ky[None, :]) / self.modulus
        values = layered.symbol(kx[:, None], ky[None, :], self.layers, self.material)
        if self.against is not None:
            values = values + kernels.symbol(kx[:, None], ky[None, :]) / self.against.plane_strain_modulus
        return values


@dataclass(frozen=True, eq=False)
class JointCompliance:
    """Displacement of the cells of two bodies towards each other, by pressure between them.

    Parameters
    ----------
    parts : (SurfaceCompliance or JointCompliance, SurfaceCompliance or JointCompliance)
        Of the same grid, free.
    """

    parts: tuple[SurfaceCompliance | JointCompliance, SurfaceCompliance | JointCompliance]

    @property
    def grid(self) -> Grid:
        """Grid of both."""
        return self.parts[0].grid

    @property
    def periodic(self) -> bool:
        """False: both are free."""
        return False

    @property
    def arrays(self) -> str | None:
        """Module whose arrays are transformed: that of the first part that has one."""
        return self.parts[0].arrays or self.parts[1].arrays

    def kernel(self, level: int = 0) -> Array:
        """Kernel of the grid coarsened `level` times by two, see `nested.GridLevel.kernel`."""
        return self.parts[0].kernel(level) + self.parts[1].kernel(level)
