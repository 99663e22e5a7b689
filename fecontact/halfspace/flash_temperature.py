"""Flash temperature: the steady rise of a half-space's surface under heat that moves over it with the contact.

Heat q on a cell with sides 2a and 2b, which moves at a velocity (u, v), raises the temperature at (x, y) from it by

    T = q sqrt(kappa) / (2 k sqrt(pi)) int_0^inf X Y ds,    tau = s^2,
    X = erf((x + u tau + a)/sqrt(4 kappa tau)) - erf((x + u tau - a)/sqrt(4 kappa tau)),    Y alike,

the sum over the times tau since when it was given off (Jaeger 1942). For each tau it is a product of functions of x and
of y, so that all cells are one product of matrices, for any speed. A periodic surface has, in wave numbers, T = q / (k
sqrt(|w|^2 - i w . v / kappa)), beside its mean, which has no steady end.

References
----------
J. C. Jaeger, J. Proc. R. Soc. N.S.W. 76 (1942) 203; X. Tian & F. E. Kennedy, J. Tribology 116 (1994) 167.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft
import scipy.special

from fecontact.common.arrays import Array
from fecontact.common.files import new_figure, save_figure
from fecontact.common.units import Units
from fecontact.halfspace.fft import Convolution, kernel_spectrum, padded
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.kernels import love
from fecontact.halfspace.pictures import Drawn, draw_map

#: Gauss points in each span of times.
POINTS = 6
#: First time, over that in which heat crosses a cell, and in which the source does, by the longer of both rates.
EARLY = (1 / 400, 1 / 20)
#: Decay exponent V^2 tau / 4 kappa after which nothing is left.
FADED = 40.0


@dataclass(frozen=True, eq=False)
class FlashTemperature(Drawn):
    """Rise of the temperature of a surface by a contact that slides or rolls; made by `HalfSpaceContact`.

    Attributes
    ----------
    grid : Grid
    temperature : (nx, ny) array
        Above the body's own; of a periodic surface above its mean, which no steady state has.
    heat : (nx, ny) array
        Heat per area and time.
    """

    grid: Grid
    temperature: Array = field(repr=False)
    heat: Array = field(repr=False)

    @property
    def max(self) -> float:
        """Largest temperature."""
        return float(self.temperature.max())

    @cached_property
    def mean(self) -> float:
        """Mean temperature where heat is given off; zero without heat."""
        heated = self.heat > 0
        return float(self.temperature[heated].mean()) if heated.any() else 0.0

    def _drawn(self, path: str | Path | None, units: Units) -> Any:
        figure = new_figure((11.0, 5.0))
        left, right = figure.subplots(1, 2)
        draw_map(left, self.grid, self.heat, "YlOrRd", "heat per area and time", units)
        draw_map(right, self.grid, self.temperature, "inferno", "temperature above that of the body", units)
        figure.suptitle(f"flash temperature: largest {self.max:.4g}, mean {self.mean:.4g}")
        return save_figure(figure, path)

    def __str__(self) -> str:
        return f"flash temperature: largest {self.max:.6g}, mean where it is heated {self.mean:.6g}"


def flash_temperature(
    grid: Grid, heat: Array, periodic: bool, velocity: Array, conductivity: float, diffusivity: float
) -> FlashTemperature:
    """Steady rise of the temperature by heat (nx, ny) that moves at a velocity (2,) over the surface."""
    if periodic:
        numbers = (2 * math.pi * scipy.fft.fftfreq(n, c) for n, c in zip(grid.shape, grid.cell, strict=True))
        x, y = np.meshgrid(*numbers, indexing="ij", sparse=True)
        root = np.sqrt(x**2 + y**2 - 1j * (x * velocity[0] + y * velocity[1]) / diffusivity)
        root[0, 0] = 1.0
        waves = scipy.fft.fft2(heat - heat.mean()) / (conductivity * root)
        temperature = scipy.fft.ifft2(waves).real
        return FlashTemperature(grid, temperature, heat)
    lengths = (2 * padded(grid.shape[0]), 2 * padded(grid.shape[1]))
    if not velocity.any():
        spectrum = kernel_spectrum(love(grid.shape, grid.cell) / (2 * conductivity), (lengths[0] // 2, lengths[1] // 2))
        return FlashTemperature(grid, Convolution.even(spectrum, grid.shape).apply(heat), heat)
    offsets = [np.arange(1 - n, n) for n in grid.shape]
    table = np.zeros(lengths)
    table[np.ix_(offsets[0] % lengths[0], offsets[1] % lengths[1])] = moving_table(grid, velocity, diffusivity)
    kernels = ((scipy.fft.rfft2(table / conductivity),),)
    return FlashTemperature(grid, Convolution(kernels, grid.shape, lengths).apply(heat[None])[0], heat)


def moving_table(grid: Grid, velocity: Array, diffusivity: float) -> Array:
    """Temperatures (2 nx - 1, 2 ny - 1) by unit heat on a cell, in the middles of the cells round it; k = 1."""
    speed, cell = float(np.hypot(*velocity)), np.array(grid.cell)
    with np.errstate(divide="ignore"):
        crossing = cell / np.abs(velocity)  # times in which the source moves by a cell
    first = min(EARLY[0] * cell.min() ** 2 / diffusivity, EARLY[1] * crossing.min())
    last = max(FADED * 4 * diffusivity / speed**2, 2 * float(np.hypot(*grid.size)) / speed)
    ends = first * 2.0 ** np.arange(math.ceil(math.log2(last / first)) + 1)
    passing = [(np.arange(n) + 0.5) * t for n, t in zip(grid.shape, crossing, strict=True) if np.isfinite(t)]
    s = np.sqrt(np.unique(np.concatenate([[0.0], ends, *passing])))
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    at = (s[:-1, None] + np.diff(s)[:, None] * (nodes + 1) / 2).ravel()
    weight = (np.diff(s)[:, None] * weights / 2).ravel()
    sides = []
    for n, side, rate in zip(grid.shape, grid.cell, velocity, strict=True):
        x = np.arange(1 - n, n) * side + (rate * at**2)[:, None]
        reach = np.sqrt(4 * diffusivity) * at[:, None]
        sides.append(scipy.special.erf((x + side / 2) / reach) - scipy.special.erf((x - side / 2) / reach))
    factor = math.sqrt(diffusivity) / (2 * math.sqrt(math.pi))
    return np.asarray(factor * (sides[0] * weight[:, None]).T @ sides[1])
