"""Self-affine rough surfaces from a power spectrum and a seed, and detrending of measured ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import scipy.sparse.linalg
from numpy.typing import ArrayLike, NDArray

from fecontact.common.arguments import items
from fecontact.common.arrays import Array
from fecontact.common.checks import among, number_array, one_of, positive, positives, share, whole
from fecontact.common.errors import InputError, shown
from fecontact.common.files import save_figure
from fecontact.common.panels import panel
from fecontact.common.units import UnitNames, Units

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Points along one side.
MAX_POINTS = 10**5
TRENDS = ("mean", "plane", "quadratic")


@dataclass(frozen=True, eq=False)
class RoughSurface:
    """A rough surface and its rms values; made by `self_affine`.

    Attributes
    ----------
    z : (nx, ny) array
        Heights, of mean zero, periodic.
    size : (float, float)
    rms_height : float
    rms_slope : float
        Root of the mean of |grad z|^2, by the spectrum.
    rms_curvature : float
        Root of the mean of ((z_xx + z_yy)/2)^2, by the spectrum.
    """

    z: Array
    size: tuple[float, float]
    rms_height: float
    rms_slope: float
    rms_curvature: float


def self_affine(
    shape: tuple[int, int],
    size: tuple[float, float],
    *,
    hurst: float,
    seed: int,
    rms_height: float | None = None,
    rms_slope: float | None = None,
    roll_off: float | None = None,
    longest: float | None = None,
    shortest: float | None = None,
) -> RoughSurface:
    """Return a periodic, isotropic, Gaussian surface with a power-law spectrum.

    Parameters
    ----------
    shape : (int, int)
    size : (float, float)
    hurst : float
        Hurst exponent, between 0 and 1: the spectrum falls as |k|^(-2 - 2 H).
    seed : int
        The same seed gives the same surface.
    rms_height, rms_slope : float, optional
        Exactly one; achieved to rounding.
    roll_off : float, optional
        Wavelength above which the spectrum is flat; none by default.
    longest, shortest : float, optional
        Wavelengths beyond which it is zero; the size and four cells by default.

    Returns
    -------
    RoughSurface

    Raises
    ------
    InputError
        If values are out of range, or no wave lies between the cut-offs.

    References
    ----------
    B. N. J. Persson et al., J. Phys.: Condens. Matter 17 (2005) R1; T. D. B. Jacobs, T. Junge, L. Pastewka, Surf.
    Topogr.: Metrol. Prop. 5 (2017) 013001.

    Examples
    --------
    >>> surface = self_affine((64, 64), (1.0, 1.0), hurst=0.8, seed=1, rms_slope=0.1)
    >>> round(surface.rms_slope, 12), abs(float(surface.z.mean())) < 1e-15
    (0.1, True)
    """
    share("the Hurst exponent", hurst)
    whole("the seed", seed, 0, 2**63)
    positives("the size", size, 2)
    nx, ny = (whole("a number of points", n, 2, MAX_POINTS) for n in _pair(shape))
    shape = (nx, ny)
    for name, wavelength in (("roll_off", roll_off), ("longest", longest), ("shortest", shortest)):
        if wavelength is not None:
            positive(name, wavelength)
    given, target = one_of(rms_height=rms_height, rms_slope=rms_slope)
    kx, ky = (2 * math.pi * np.fft.fftfreq(n, s / n) for n, s in zip(shape, size, strict=True))
    k = np.hypot(kx[:, None], ky[None, :])
    lowest = 2 * math.pi / (longest if longest is not None else max(size))
    cells = max(s / n for s, n in zip(size, shape, strict=True))
    highest = 2 * math.pi / (shortest if shortest is not None else 4 * cells)
    band = (k >= lowest * (1 - 1e-12)) & (k <= highest * (1 + 1e-12)) & (k > 0)
    if not band.any():
        raise InputError(
            f"No wave of the grid lies between the cut-offs {2 * math.pi / highest:g} and {2 * math.pi / lowest:g}.",
            code="no-wave",
        )
    flat = 2 * math.pi / roll_off if roll_off is not None else 0.0
    amplitude = np.zeros(k.shape)
    amplitude[band] = np.maximum(k[band], flat) ** (-1 - hurst)
    white = np.fft.fft2(np.random.default_rng(seed).standard_normal(shape))
    spectrum = amplitude * white
    moments = [_root_mean_square(spectrum * factor) for factor in (1.0, k, k**2 / 2)]
    scale = target / moments[("rms_height", "rms_slope").index(given)]
    z = np.fft.ifft2(spectrum).real * scale
    height, slope, curvature = (m * scale for m in moments)
    return RoughSurface(z, (float(size[0]), float(size[1])), height, slope, curvature)


def _pair(shape: object) -> tuple[Any, ...]:
    found = items("the shape", shape, "two numbers of points")
    if len(found) != 2:
        raise InputError(f"The shape must be two numbers of points; found {shown(shape)}.")
    return found


def _root_mean_square(spectrum: NDArray) -> float:
    """Root mean square of the field of a spectrum, by Parseval's theorem."""
    return float(np.linalg.norm(spectrum)) / spectrum.size


def _heights(z: ArrayLike, holes: bool = False) -> Array:
    """Heights (nx, ny), without holes unless they may be."""
    heights = number_array("the heights", z)
    if heights.ndim != 2 or heights.size == 0 or not (holes or np.isfinite(heights).all()):
        raise InputError("Heights must be an array (nx, ny), of a spectrum without holes: see surfaces.fill_holes.")
    return heights


def detrend(z: ArrayLike, trend: str = "plane") -> Array:
    """Heights less their mean, their best plane, or their best quadratic surface.

    Parameters
    ----------
    z : (nx, ny) array_like
        Those that are not finite, the holes of a measurement, do not count and stay.
    trend : {'mean', 'plane', 'quadratic'}

    Returns
    -------
    (nx, ny) array

    Raises
    ------
    InputError
        If the trend is unknown, or there are too few finite heights.

    Examples
    --------
    >>> import numpy as np
    >>> x, y = np.meshgrid(np.arange(4.0), np.arange(5.0), indexing="ij")
    >>> float(np.abs(detrend(3 + 2 * x - y)).max()) < 1e-12
    True
    """
    heights = _heights(z, holes=True)
    among("trend", trend, TRENDS)
    x, y = (np.linspace(-1.0, 1.0, n) for n in heights.shape)
    X, Y = x[:, None] + 0 * y, y[None, :] + 0 * x[:, None]
    terms = [np.ones_like(X), X, Y, X**2, X * Y, Y**2]
    basis = np.stack(terms[: {"mean": 1, "plane": 3, "quadratic": 6}[trend]], axis=-1).reshape(heights.size, -1)
    known = np.isfinite(heights).ravel()
    if known.sum() < basis.shape[1]:
        raise InputError(f"A trend needs {basis.shape[1]} finite heights; found {known.sum()}.", code="few-heights")
    factors = np.linalg.lstsq(basis[known], heights.ravel()[known], rcond=None)[0]
    return np.asarray(heights - (basis @ factors).reshape(heights.shape))


def fill_holes(z: ArrayLike) -> Array:
    """Heights with a harmonic surface in the holes of a measurement: each height there is the mean of its neighbours'.

    It has no peaks of its own. At a rim that was not measured it goes on level.

    Parameters
    ----------
    z : (nx, ny) array_like
        Holes are NaN.

    Returns
    -------
    (nx, ny) array

    Raises
    ------
    InputError
        If no height is known.

    Examples
    --------
    >>> fill_holes([[0.0, 1.0, 2.0], [1.0, np.nan, 3.0], [2.0, 3.0, 4.0]])[1, 1].round(12)
    np.float64(2.0)
    """
    heights = number_array("the heights", z)
    holes = np.isnan(heights)
    if heights.ndim != 2 or holes.all():
        raise InputError("Heights must be an array (nx, ny), of which some are known.", code="no-heights")
    number = np.arange(heights.size).reshape(heights.shape)
    pairs = [(number[:-1].ravel(), number[1:].ravel()), (number[:, :-1].ravel(), number[:, 1:].ravel())]
    i, j = (np.concatenate(each) for each in zip(*pairs, strict=True))
    A = scipy.sparse.coo_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), shape=2 * (heights.size,)).tocsr()
    rows = A[np.flatnonzero(holes)]
    L = scipy.sparse.diags_array(rows.sum(axis=1)) - rows[:, np.flatnonzero(holes)]
    out = np.where(holes, 0.0, heights)
    out[holes] = scipy.sparse.linalg.spsolve(L.tocsc(), rows @ out.ravel()) if holes.any() else 0.0
    return out


#: Power over the largest of a spectrum, up to which it is rounding: the squared one of heights, and what they sum up.
ROUNDING = 1e-28


@dataclass(frozen=True, eq=False)
class PowerSpectrum:
    """Power spectral density of a surface, mean over directions; made by `power_spectrum`.

    Attributes
    ----------
    wave_number : (n,) array
        Middles of rings in wave numbers, 2 pi over the wavelength.
    density : (n,) array
        Mean square height per area of wave numbers: its integral over these is the mean square of the heights.
    """

    wave_number: Array
    density: Array

    def plot(self, path: str | Path | None = None, *, units: UnitNames = (), ax: Axes | None = None) -> Figure:
        """Draw it over the wave number, both logarithmic.

        Parameters
        ----------
        path : str or Path, optional
            File to write.
        units : (length, ...) or str
            Names of units for labels, of which that of length counts; or it alone.
        ax : matplotlib Axes, optional
            Where to draw it.
        """
        axes, length = panel(ax, (6.4, 4.6)), Units.labels(units, "length").length
        shown = self.density > ROUNDING * self.density.max()
        axes.loglog(self.wave_number[shown], self.density[shown], marker=".")
        axes.set_xlabel("wave number, 2 pi over the wavelength" + (f" [1/{length}]" if length else ""))
        axes.set_ylabel("power spectral density" + (f" [{length}⁴]" if length else ""))
        axes.grid(alpha=0.3)
        return save_figure(cast("Figure", axes.figure), path)


def power_spectrum(z: ArrayLike, size: tuple[float, float]) -> PowerSpectrum:
    """Power spectral density of heights, as if periodic, mean over rings of one wave of the shorter side.

    Heights that do not repeat have a jump at the border, which falls as the square of the wave number: see `detrend`.

    Parameters
    ----------
    z : (nx, ny) array_like
    size : (float, float)

    Raises
    ------
    InputError
        If heights are not finite.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001.

    Examples
    --------
    >>> surface = self_affine((256, 256), (1.0, 1.0), hurst=0.8, seed=1, rms_slope=0.1)
    >>> found = power_spectrum(surface.z, surface.size)
    >>> slope = np.polyfit(np.log(found.wave_number[3:50]), np.log(found.density[3:50]), 1)[0]
    >>> round(float(slope), 1)  # -2 - 2 H
    -3.6
    """
    heights = _heights(z)
    positives("the size", size, 2)
    wave = [2 * math.pi * np.fft.fftfreq(n, s / n) for n, s in zip(heights.shape, size, strict=True)]
    k = np.hypot(wave[0][:, None], wave[1][None, :])
    ring = np.rint(k * min(size) / (2 * math.pi)).astype(np.int64)
    one = (2 * math.pi) ** 2 / (size[0] * size[1])  # area of a wave number
    power = np.abs(np.fft.fft2(heights - heights.mean()) / heights.size) ** 2 / one
    count = np.bincount(ring.ravel())[1:]
    kept = np.flatnonzero(count) + 1
    sums = [np.bincount(ring.ravel(), values.ravel())[kept] / count[kept - 1] for values in (k, power)]
    return PowerSpectrum(*sums)
