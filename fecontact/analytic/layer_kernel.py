"""Elastic layer on a rigid foundation: transform compliance.

A pressure p cos(k x) on the layer displaces its surface by 2 M/(E' k) p cos(k x), E' = E/(1 - nu^2), where M = 1 for a
half-space. M is the kernel here; it tends to 1 where the wavelength is short compared with the thickness.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic._functions import sinh_excess
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

Base = Literal["bonded", "frictionless"]


def bonded_kernel(k: ArrayLike, thickness: float, material: Material) -> Array:
    """Return the compliance of a layer bonded to a rigid foundation, relative to a half-space.

    Parameters
    ----------
    k : array_like
        Wave number (1 / length), any shape, zero or positive.
    thickness : float
        Thickness h of the layer.
    material : Material
        Material of the layer.

    Returns
    -------
    numpy.ndarray
        M = (2 g sinh y - 2 y)/(2 g cosh y + y^2 + g^2 + 1) with y = 2 k h and g = 3 - 4 nu; shape of `k`, from 0 at
        k = 0 to 1.

    Raises
    ------
    InputError
        If a wave number is negative or not finite, or the thickness not positive.

    Notes
    -----
    The numerator is formed as 2 (g - 1) sinh y + 2 (sinh y - y), which does not cancel for an incompressible layer
    under long waves, where M falls as k^3.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 5.8; I. I. Vorovich & I. A. Ustinov, J. Appl. Math. Mech. 23 (1959).

    Examples
    --------
    >>> bonded_kernel([0.0, 0.1, 100.0], 1.0, Material(E=1.0, nu=0.3)).round(6)
    array([0.      , 0.040845, 1.      ])
    """
    y = 2 * checks.depths("k", k) * checks.positive("the thickness", thickness)
    g = 3 - 4 * material.nu
    decay, S = np.exp(-y), -np.expm1(-2 * y) / 2  # all terms times exp(-y), to avoid overflow
    excess = np.where(y < 1, sinh_excess(np.minimum(y, 1.0)) * decay, S - y * decay)
    return np.asarray((2 * (g - 1) * S + 2 * excess) / _bonded_denominator(y, g))


def frictionless_kernel(k: ArrayLike, thickness: float, material: Material | None = None) -> Array:
    """Return the compliance of a layer on a frictionless rigid foundation, relative to a half-space.

    Parameters
    ----------
    k, thickness
        As in `bonded_kernel`.
    material : Material, optional
        Unused; accepted so that both kernels have the same signature.

    Returns
    -------
    numpy.ndarray
        M = (cosh y - 1)/(sinh y + y) with y = 2 k h; shape of `k`, from 0 at k = 0 to 1.

    Raises
    ------
    InputError
        If a wave number is negative or not finite, or the thickness not positive.

    References
    ----------
    I. N. Sneddon, Fourier Transforms, 1951, section 46; Johnson 1985, section 5.8.

    Examples
    --------
    >>> frictionless_kernel([0.0, 0.1, 100.0], 1.0).round(6)
    array([0.  , 0.05, 1.  ])
    """
    y = 2 * checks.depths("k", k) * checks.positive("the thickness", thickness)
    denominator = np.where(y > 0, -np.expm1(-2 * y) / 2 + y * np.exp(-y), 1.0)
    return np.asarray(np.expm1(-y) ** 2 / 2 / denominator)


def compliance(k: ArrayLike, thickness: float, material: Material, base: Base = "bonded") -> Array:
    """Return the surface displacement of a layer per unit of sinusoidal pressure, finite at k = 0.

    Parameters
    ----------
    k, thickness, material
        As in `bonded_kernel`.
    base : {"bonded", "frictionless"}
        How the layer rests on the rigid foundation.

    Returns
    -------
    numpy.ndarray
        2 M/(E' k) (length^3 / force), shape of `k`; at k = 0 it is h (1 + nu)(1 - 2 nu)/((1 - nu) E) bonded and h/E'
        frictionless (long waves in one direction, no strain in the other).

    Raises
    ------
    InputError
        If a wave number is negative or not finite, the thickness not positive, or the base unknown.

    References
    ----------
    Johnson 1985, section 5.8.

    Examples
    --------
    >>> compliance([0.0, 1e-6], 2.0, Material(E=1.0, nu=0.0)).round(6)
    array([2., 2.])
    """
    kernel = bonded_kernel if checked_base(base) == "bonded" else frictionless_kernel
    waves = checks.depths("k", k)
    h, nu = checks.positive("the thickness", thickness), material.nu
    still = h * (1 - 2 * nu) / (2 * (1 - nu) ** 2) if base == "bonded" else h / 2  # limit of M/k
    ratio = np.where(waves > 0, kernel(waves, h, material) / np.where(waves > 0, waves, 1.0), still)
    return np.asarray(2 * ratio / material.plane_strain_modulus)


def checked_base(base: str) -> str:
    """Return `base` if it is "bonded" or "frictionless"; refuse it otherwise."""
    if base not in ("bonded", "frictionless"):
        raise InputError(f'Expected base="bonded" or base="frictionless"; found {base!r}.')
    return base


def _bonded_denominator(y: Array, g: float) -> Array:
    """Return (2 g cosh y + y^2 + g^2 + 1) exp(-y)."""
    return np.asarray(g * (1 + np.exp(-2 * y)) + (y**2 + g**2 + 1) * np.exp(-y))


def deficit(kappa: Array, nu: float, base: Base) -> Array:
    """Return 1 - M at kappa = k h > 0, without cancellation."""
    y = 2 * kappa
    if base == "frictionless":
        return np.asarray((y + 1 - np.exp(-y)) * np.exp(-y) / (-np.expm1(-2 * y) / 2 + y * np.exp(-y)))
    g = 3 - 4 * nu
    return np.asarray((2 * g * np.exp(-y) + (y + 1) ** 2 + g**2) * np.exp(-y) / _bonded_denominator(y, g))
