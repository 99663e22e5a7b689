"""Compliance of a half-space to pressures and tractions: materials, layers, free or periodic.

Tangential displacements are of the half-space against the counter-surface, tractions act on the half-space: with an
elastic counter-body, whose tractions are the reverse, the compliances along the surface add up and the couplings
subtract.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fecontact.analytic import curved_kernel
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace import kernels, layered
from fecontact.halfspace.fft import Convolution, Kernels, padded
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.kernels import cerruti
from fecontact.halfspace.layered import check_interfaces, tangential_difference, thin_layers, waves_difference

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


@dataclass(frozen=True)
class Memory:
    """Creep of a surface: displacements by a constant force grow as 1 + sum s (1 - exp(-t/theta)), over those at once.

    Attributes
    ----------
    shares, times : tuples of float
        s and theta.
    alike : bool
        Whether displacements by tractions creep in the same way: one body, or two of one material.
    """

    shares: tuple[float, ...]
    times: tuple[float, ...]
    alike: bool


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
    memory : Memory, optional
        Creep of visco-elastic bodies, whose materials are those at once; the kernels are without it.
    """

    grid: Grid
    material: Material | None
    layers: Sequence[layered.Layer]
    against: Material | None
    pressure: str
    self_ratio: float
    periodic: bool
    bent: tuple[Bend, ...] = ()
    memory: Memory | None = None

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
        if level not in self._kernels:
            self._kernels[level] = self._symbol(level) if self.periodic else self._free(level)
        return self._kernels[level]

    @cached_property
    def _kernels(self) -> dict[int, Array]:
        """Kernels by level that were made so far."""
        return {}

    def _free(self, level: int) -> Array:
        counts = tuple(-(-n // 2**level) + (level > 0) for n in self.grid.shape)
        shape = (min(counts[0], self.grid.shape[0]), min(counts[1], self.grid.shape[1]))
        cell = (self.grid.cell[0] * 2**level, self.grid.cell[1] * 2**level)
        if self.layers:
            # the coarsest grid of 8 cells has 4, one more, and two for the rule of its means
            table = layered.table(shape, cell, self.layers, self.material, 2 * math.hypot(*self.grid.size))
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

    def product(self) -> Convolution:
        """Displacements of all cells by pressures on them."""
        return Convolution.of_grid(self.kernel(), self.periodic, self.grid.shape)

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

    def kernel(self, level: int = 0) -> Array:
        """Kernel of the grid coarsened `level` times by two, see `nested.GridLevel.kernel`."""
        return self.parts[0].kernel(level) + self.parts[1].kernel(level)


Box = tuple[slice, slice]


@dataclass(frozen=True)
class Elasticity:
    """Elastic constants of the surface: u_x = (direct/r + poisson x^2/r^3) Q_x and so on, by unit forces.

    With layers, those of the top layer's half-space, to which what the layers change is added.

    Attributes
    ----------
    direct : float
        Sum of (1 - nu)/(2 pi G) over the bodies; the normal displacement is direct/r too.
    poisson : float
        Sum of nu/(2 pi G) over the bodies.
    coupling : float
        (1 - 2 nu)/(4 pi G) of the half-space less that of the counter-body; the normal displacement by a tangential
        force is coupling x/r^2, the tangential one by a normal force -coupling x/r^2.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6.
    """

    direct: float
    poisson: float
    coupling: float

    @classmethod
    def of(cls, body: SurfaceCompliance) -> Elasticity:
        """Constants of a half-space and its counter-body.

        Raises
        ------
        InputError
            With layers that are not bonded, or forces at points of cells.
        """
        check_interfaces(body.layers)
        top = body.layers[0].material if body.layers else body.material
        assert top is not None
        if body.pressure != "uniform":
            raise InputError(f"Friction needs pressure='uniform'; found {body.pressure!r}.", code="friction-uniform")
        pair = [(top, 1)] + ([(body.against, -1)] if body.against is not None else [])
        return cls(
            sum((1 - m.nu) / (2 * math.pi * m.shear_modulus) for m, _ in pair),
            sum(m.nu / (2 * math.pi * m.shear_modulus) for m, _ in pair),
            sum(side * (1 - 2 * m.nu) / (4 * math.pi * m.shear_modulus) for m, side in pair),
        )


@dataclass(frozen=True, eq=False)
class TangentialCompliance:
    """Products among the cells of a box; made by `tangential_compliance`.

    Attributes
    ----------
    tractions : Convolution
        u_x and u_y by q_x and q_y. Poisson's ratio zero and no layers: without u_x by q_y, and with one kernel.
    lift : Convolution or None
        Normal displacement by q_x and q_y; None without coupling.
    drag : Convolution or None
        u_x and u_y by pressures; None without coupling.
    inverse : Convolution
        Approximate inverse of `tractions`, without padding, in single precision.
    own : float
        Displacement of a cell by a unit traction on itself, the scale of the finest waves.
    periodic : bool
    symmetric : bool
        Whether `tractions` is; that of steady rolling is not.
    """

    tractions: Convolution
    lift: Convolution | None
    drag: Convolution | None
    inverse: Convolution
    own: float
    periodic: bool
    symmetric: bool = True

    @property
    def shape(self) -> tuple[int, int]:
        """Cells of the box."""
        return self.tractions.shape

    def apply(self, q: Array) -> Array:
        """Tangential displacements (2, bx, by) by tangential tractions (2, bx, by)."""
        return self.tractions.apply(q)

    def correct(self, change: Array) -> Array:
        """The same in single precision, for a change of tractions."""
        return self.tractions.rough.apply(change)

    def of_pressure(self, p: Array) -> Array:
        """Tangential displacements (2, bx, by) by pressures (bx, by)."""
        return np.zeros((2, *self.shape)) if self.drag is None else self.drag.apply(p[None])

    def normal_displacement(self, q: Array) -> Array:
        """Displacements (bx, by) into the half-space by tangential tractions (2, bx, by)."""
        return np.zeros(self.shape) if self.lift is None else self.lift.apply(q)[0]

    def precondition(self, s: Array) -> Array:
        """Approximate tractions by displacements (2, bx, by): the inverse in wave numbers, as if without end."""
        return self.inverse.apply(s)


def tangential_compliance(body: SurfaceCompliance, box: Box, workers: int | None = None) -> TangentialCompliance:
    """Compliance among the cells of a box of the grid; a periodic one is taken whole.

    Raises
    ------
    InputError
        See `Elasticity.of`.

    Examples
    --------
    >>> import numpy as np
    >>> import fecontact as fc
    >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(4.0, 4.0), cells=(4, 4))
    >>> compliance = tangential_compliance(half.compliance, (slice(0, 4), slice(0, 4)))
    >>> q = np.zeros((2, 4, 4))
    >>> q[0, 1, 2] = 1.0
    >>> u = compliance.apply(q)
    >>> bool(np.isclose(u[0, 1, 2], 8 * np.log(1 + np.sqrt(2)) / (2 * np.pi))), bool(np.abs(u[1]).max() < 1e-15)
    (True, True)
    """
    constants = Elasticity.of(body)
    if body.periodic:
        return _periodic(body, constants, workers)
    shape = (box[0].stop - box[0].start, box[1].stop - box[1].start)
    tables = cerruti(shape, body.grid.cell)
    lengths = (2 * padded(shape[0]), 2 * padded(shape[1]))
    both = constants.direct * (tables.xx + tables.yy)
    xx_table, yy_table = both + constants.poisson * tables.xx, both + constants.poisson * tables.yy
    xy_table = constants.poisson * tables.xy
    x_table, y_table = constants.coupling * tables.x, constants.coupling * tables.y
    if body.layers:
        more = _of_layers(body, shape)
        xx_table, yy_table, xy_table = xx_table + more[0], yy_table + more[1], xy_table + more[2]
        x_table, y_table = x_table + more[3], y_table + more[4]

    def spectrum(table: Array, signs: tuple[int, int]) -> NDArray:
        found = scipy.fft.rfft2(_extended(table, lengths, signs), workers=workers)
        return np.asarray(found.real if signs[0] == signs[1] else found)

    normal = None
    if is_coupled(body):
        normal = spectrum(x_table, (-1, 1)), spectrum(y_table, (1, -1))
    xx = yy = spectrum(xx_table, (1, 1))
    xy = None
    if constants.poisson != 0 or body.layers:
        yy, xy = spectrum(yy_table, (1, 1)), spectrum(xy_table, (-1, -1))
    inverse = _inverse(constants, shape, body.grid.cell, workers)
    empty = Convolution((), shape, lengths, workers=workers)
    return _compliance(((xx, xy), (xy, yy)), normal, inverse, empty, float(both[0, 0]), False)


def _compliance(
    tractions: Kernels,
    normal: tuple[NDArray, NDArray] | None,
    inverse: Convolution,
    empty: Convolution,
    own: float,
    periodic: bool,
) -> TangentialCompliance:
    """Compliance of kernels of tractions, and of normal displacements by tractions, on the cells of an empty one."""
    lift = drag = None
    if normal is not None:
        lift, drag = replace(empty, kernels=(normal,)), replace(empty, kernels=tuple((-kernel,) for kernel in normal))
    return TangentialCompliance(replace(empty, kernels=tractions), lift, drag, inverse, own, periodic)


def check_thickness(body: SurfaceCompliance) -> None:
    """Refuse friction on cells that are wider than the top layer is thick."""
    if not body.periodic and thin_layers(body.layers, max(body.grid.cell)):
        raise InputError(
            f"With friction, the top layer's thickness must be no less than a cell's width, {max(body.grid.cell):g}; "
            f"found {body.layers[0].thickness:g}. Take smaller cells, or leave out a layer that is so thin.",
            code="cells-too-wide",
        )


def is_coupled(body: SurfaceCompliance) -> bool:
    """Whether tractions lift the surface and pressures drag it along."""
    return bool(body.layers) or Elasticity.of(body).coupling != 0


def _of_layers(body: SurfaceCompliance, shape: tuple[int, int]) -> Array:
    """What layers add to the tables (5, nx, ny) of a free half-space, means over a cell by a Gauss rule of two points.

    Along and across the axes: u_x by q_x, u_y by q_y, u_x by q_y, and normal displacements by q_x and by q_y.
    """
    cell = body.grid.cell
    x, y = (np.arange(n) * side for n, side in zip(shape, cell, strict=True))
    at = tangential_difference(math.hypot(x[-1] + cell[0], y[-1] + cell[1]), body.layers, body.material)
    shift = 0.5 / math.sqrt(3)
    total = np.zeros((5, *shape))
    for sx in (-shift, shift):
        for sy in (-shift, shift):
            xs, ys = np.meshgrid(x + sx * cell[0], y + sy * cell[1], indexing="ij")
            total += body.grid.area / 4 * np.stack(at(xs, ys))
    return total


def _extended(table: Array, lengths: tuple[int, int], signs: tuple[int, int]) -> Array:
    """Table of offsets 0, 1, ... with those of negative offsets at the end, even (1) or odd (-1) in each direction."""
    nx, ny = table.shape
    full = np.zeros(lengths)
    full[:nx, :ny] = table
    full[lengths[0] - nx + 1 :, :ny] = signs[0] * table[:0:-1]
    full[:, lengths[1] - ny + 1 :] = signs[1] * full[:, ny - 1 : 0 : -1]
    return full


def _periodic(body: SurfaceCompliance, constants: Elasticity, workers: int | None) -> TangentialCompliance:
    """The same in wave numbers k: u = 2 pi (direct + poisson (1 - k k/k^2)) q/k, and -i 2 pi coupling k/k^2 normally.

    The Fourier transforms of x^2/r^3 and x/r^2 are 2 pi k_y^2/k^3 and -2 pi i k_x/k^2. The mean moves nothing,
    but layers on a rigid base; odd kernels leave out the waves of two cells, which have no sign.
    """
    shape = body.grid.shape
    kx, ky, k = _waves(shape, body.grid.cell)
    k[0, 0] = math.inf
    odd_x, odd_y = kx.copy(), ky.copy()
    odd_x[shape[0] // 2], odd_y[:, shape[1] // 2] = 0.0, 0.0
    direct, poisson = 2 * math.pi * constants.direct / k, 2 * math.pi * constants.poisson / k
    cx, cy = kx / k, ky / k
    coupling = -2j * math.pi * constants.coupling / k**2
    along, across = direct, direct + poisson
    if body.layers:
        finite = np.where(np.isinf(k), 0.0, k)
        L, T, W = waves_difference(finite, body.layers, body.material)
        along, across, coupling = along + L, across + T, coupling + 1j * W / k
    xx, yy = along * cx**2 + across * cy**2, along * cy**2 + across * cx**2
    if body.layers and body.material is None:
        xx[0, 0] = yy[0, 0] = sum(layer.thickness / layer.material.shear_modulus for layer in body.layers)
    xy = (along - across) * (odd_x / k) * (odd_y / k) if constants.poisson != 0 or body.layers else None
    return _compliance(
        ((xx, xy), (xy, yy)),
        (coupling * odd_x, coupling * odd_y) if is_coupled(body) else None,
        _inverse(constants, shape, body.grid.cell, workers),
        Convolution((), shape, shape, workers=workers),
        constants.direct * math.sqrt(body.grid.area) * 4 * math.log(1 + math.sqrt(2)),
        True,
    )


def _inverse(
    constants: Elasticity, shape: tuple[int, int], cell: tuple[float, float], workers: int | None
) -> Convolution:
    """Inverse of the compliance in wave numbers, positive definite."""
    lengths = (padded(shape[0]), padded(shape[1]))
    kx, ky, k = _waves(lengths, cell)
    k[0, 0] = min(k[0, 1], k[1, 0]) / 2
    across = k / (2 * math.pi * (constants.direct + constants.poisson))
    more = (k / (2 * math.pi * constants.direct) - across) / k**2
    xy = more * kx * ky
    kernels = ((across + more * kx**2, xy), (xy, across + more * ky**2))
    return Convolution(kernels, shape, lengths, workers=workers).rough


def _waves(shape: tuple[int, int], cell: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Wave numbers of a real transform along x and y, and their lengths."""
    kx = 2 * math.pi * scipy.fft.fftfreq(shape[0], cell[0])[:, None]
    ky = 2 * math.pi * scipy.fft.rfftfreq(shape[1], cell[1])[None, :]
    return kx, ky, np.hypot(kx, ky)
