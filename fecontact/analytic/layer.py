"""Elastic layer on a rigid foundation: transform compliance, contact with a rigid paraboloid, and its limits.

Elastic layer on a rigid foundation: transform compliance.

A pressure p cos(k x) on the layer displaces its surface by 2 M/(E' k) p cos(k x), E' = E/(1 - nu^2), where M = 1 for a
half-space. M is the kernel here; it tends to 1 where the wavelength is short compared with the thickness.

Elastic layer on a rigid foundation under a rigid paraboloid, solved by its integral equation.

Elastic layer on a rigid foundation under a rigid paraboloid: limits of a thick and of a thin layer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fecontact.analytic._contact import RoundContact
from fecontact.analytic._functions import composite_gauss, gauss, sinh_excess
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

__all__ = [
    "MAX_RATIO",
    "Base",
    "LayerContact",
    "bonded_kernel",
    "compliance",
    "frictionless_kernel",
    "paraboloid",
    "thick",
    "thin_compressible",
    "thin_incompressible",
]


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
        raise InputError(f'Expected base="bonded" or base="frictionless"; found {base!r}.', code="unknown-base")
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


# Largest contact radius over thickness for which the integral equation is solved; use the asymptotes beyond it.
MAX_RATIO = 50.0


@dataclass(frozen=True, eq=False)
class LayerContact(RoundContact):
    """Elastic layer under a rigid frictionless paraboloid r^2/(2R); made by `paraboloid`.

    Parameters
    ----------
    force : float
        Load P.
    approach : float
        Displacement delta of the indenter.
    a : float
        Radius of the contact.
    p0 : float
        Pressure at the centre.
    R : float
        Radius of curvature of the indenter.
    thickness : float
        Thickness of the layer.
    base : {"bonded", "frictionless"}
        How the layer rests on the rigid foundation.
    E_star : float
        E/(1 - nu^2) of the layer.
    coefficients : numpy.ndarray, shape (n,)
        Chebyshev coefficients in 2 t^2/a^2 - 1 of phi(t) R/a^2, where the Hankel transform of the pressure is
        (E*/pi) times the integral of phi(t) cos(k t) over t = 0 ... a.

    References
    ----------
    N. N. Lebedev & I. S. Ufliand, J. Appl. Math. Mech. 22 (1958) 442; I. N. Sneddon, Mixed Boundary Value Problems in
    Potential Theory, 1966.

    Examples
    --------
    >>> cartilage = Material(E=5.0, nu=0.45)
    >>> print(paraboloid(radius=20.0, thickness=2.0, material=cartilage, force=100.0))
    Layer under a rigid paraboloid, bonded base
      force               P      100
      approach            delta  0.513148
      contact radius      a      4.53329
      maximum pressure    p0     2.82873
      mean pressure       pm     1.5489
      radius of indenter  R      20
      thickness           h      2
      contact modulus     E*     6.26959
    >>> contact = paraboloid(radius=1.0, thickness=1e3, material=Material(E=1.0, nu=0.0), a=0.1)
    >>> (contact.pressure([0.0, 0.06, 0.2]) / contact.p0).round(6)
    array([1. , 0.8, 0. ])
    """

    force: float
    approach: float
    a: float
    p0: float
    R: float
    thickness: float
    base: Base
    E_star: float
    coefficients: Array

    _title = "Layer under a rigid paraboloid, {0.base} base"
    _rows = (
        "force",
        "approach",
        "a",
        "p0",
        "mean_pressure",
        ("radius of indenter", "R", "R"),
        ("thickness", "h", "thickness"),
        "E_star",
    )

    def _pressure(self, r: Array) -> Array:
        """-(E*/pi) times the integral of phi'(t)/sqrt(t^2 - r^2) over t = r ... a (Sneddon 1966, section 3)."""
        shape = self.E_star * self.a / (math.pi * self.R)
        return np.asarray(shape * _pressure_shape(self.coefficients, r / self.a))


def paraboloid(
    *,
    radius: float,
    thickness: float,
    material: Material,
    base: Base = "bonded",
    force: float | None = None,
    approach: float | None = None,
    a: float | None = None,
) -> LayerContact:
    """Return the contact of an elastic layer with a rigid frictionless paraboloid.

    Parameters
    ----------
    radius : float
        Radius of curvature R of the paraboloid r^2/(2R).
    thickness : float
        Thickness h of the layer.
    material : Material
        Material of the layer.
    base : {"bonded", "frictionless"}
        How the layer rests on the rigid foundation.
    force, approach, a : float, optional
        Load, displacement or contact radius, positive; exactly one.

    Returns
    -------
    LayerContact
        Force, approach, radius, pressure.

    Raises
    ------
    InputError
        If a number is not positive, not exactly one of the three is given, or the contact radius exceeds 50 times the
        thickness (use the asymptotes there).

    Notes
    -----
    The dual integral equations of the mixed problem become one Fredholm equation of the second kind with the smooth
    kernel 1 - M, solved by Gauss quadrature; a follows from phi(a) = 0 (no pressure at the edge).

    References
    ----------
    Lebedev & Ufliand 1958; Sneddon 1966.

    Examples
    --------
    >>> contact = paraboloid(radius=1.0, thickness=0.2, material=Material(E=1.0, nu=0.0), a=0.1)
    >>> round(contact.force * 1000, 5), round(contact.approach * 100, 5), round(contact.p0 * 10, 5)
    (1.38565, 0.78284, 0.66309)
    """
    R, h = checks.positive("the radius", radius), checks.positive("the thickness", thickness)
    checked_base(base)
    name, value = checks.one_of(force=force, approach=approach, a=a)
    E_star, nu = material.plane_strain_modulus, material.nu
    ratio = value / h if name == "a" else _ratio(name, value, R, h, E_star, nu, base)
    if ratio > MAX_RATIO:
        raise InputError(
            f"Expected a contact radius up to {MAX_RATIO} times the thickness; found {ratio:.4g}. "
            "Use the asymptotes thin_compressible() or thin_incompressible().",
            code="layer-too-thin",
        )
    width = ratio * h
    coefficients, shape_delta, shape_force = _solve(ratio, nu, base)
    return LayerContact(
        force=shape_force * E_star * width**3 / R,
        approach=shape_delta * width**2 / R,
        a=width,
        p0=float(_pressure_shape(coefficients, np.zeros(1))[0]) * E_star * width / (math.pi * R),
        R=R,
        thickness=h,
        base=base,
        E_star=E_star,
        coefficients=coefficients,
    )


def _solve(ratio: float, nu: float, base: Base) -> tuple[Array, float, float]:
    """Solve the integral equation at a/h = `ratio`, in units of a, R and E*.

    Returns
    -------
    tuple
        Chebyshev coefficients of phi in 2 t^2 - 1, approach delta R/a^2, force P R/(E* a^3).
    """
    # exp(-2 kappa) cuts the kernel off at kappa = 25; a panel of 40 points integrates a phase of 20 to rounding.
    panels = 8 + math.ceil(50 * ratio / 20)
    unit, weight = composite_gauss(panels, 40)
    kappa = 25 * unit
    spectrum = 25 * weight * deficit(kappa, nu, base) * 2 * ratio / math.pi
    order = 32 * math.ceil((24 + 6 * ratio) / 32)  # the kernel's width is h; orders in steps of 32 reuse cached nodes
    t, w = gauss(order)
    angles = (np.arange(order) + 0.5) * math.pi / order
    samples = np.sqrt((1 + np.cos(angles)) / 2)  # Chebyshev points in 2 t^2 - 1

    def waves(points: Array) -> Array:
        return np.asarray(np.cos(ratio * np.outer(points, kappa)))

    inner = waves(t)
    smooth = (spectrum[:, None] * inner.T) * w  # (n_kappa, n_t)
    solved = np.linalg.solve(np.eye(order) - inner @ smooth, np.stack([np.ones(order), t**2], axis=1))
    outside = np.append(samples, 1.0)
    values = np.stack([np.ones(order + 1), outside**2], axis=1) + waves(outside) @ (smooth @ solved)
    delta = values[-1, 1] / values[-1, 0]
    phi = delta * values[:-1, 0] - values[:-1, 1]
    modes = np.cos(np.outer(np.arange(order), angles))
    coefficients = 2 / order * (modes @ phi)
    coefficients[0] /= 2
    force = 2 * float(w @ (delta * solved[:, 0] - solved[:, 1]))
    return coefficients, float(delta), force


def _pressure_shape(coefficients: Array, xi: Array) -> Array:
    """Return p pi R/(E* a) at r/a = xi: minus the integral of phi'(t)/sqrt(t^2 - xi^2), t^2 = xi^2 + (1 - xi^2) w^2."""
    rate = 4 * np.polynomial.chebyshev.chebder(coefficients)  # phi'(t)/t as a series in 2 t^2 - 1
    w, weight = gauss(len(coefficients))
    inside = np.minimum(xi, 1.0)
    open_part = (1 - inside) * (1 + inside)
    argument = 2 * (inside[..., None] ** 2 + open_part[..., None] * w**2) - 1
    values = np.polynomial.chebyshev.chebval(argument, rate)
    return np.asarray(-np.sqrt(open_part) * (values @ weight))


def _ratio(name: str, value: float, R: float, h: float, E_star: float, nu: float, base: Base) -> float:
    """Return a/h at which the force or the approach has the given value."""

    def excess(log_ratio: float) -> float:
        ratio = math.exp(log_ratio)
        _, delta, force = _solve(ratio, nu, base)
        found = force * E_star * (ratio * h) ** 3 / R if name == "force" else delta * (ratio * h) ** 2 / R
        return math.log(found / value)

    # Hertz is a lower bound of the force at a given radius, and an upper bound of the approach within a factor of 4.
    hertz = math.cbrt(3 * value * R / (4 * E_star)) if name == "force" else math.sqrt(R * value)
    low = math.log(hertz / h) - (3.0 if name == "force" else 0.1)
    high = math.log(hertz / h) + 1.0
    largest = math.log(MAX_RATIO)
    if high > largest and excess(largest) < 0:
        raise InputError(
            f"The given {name} = {value!r} makes a contact wider than {MAX_RATIO} times the thickness. "
            "Use the asymptotes thin_compressible() or thin_incompressible().",
            code="layer-too-thin",
        )
    high = min(high, largest)
    while excess(low) > 0:
        low -= 2.0
    return math.exp(brentq(excess, low, high, xtol=1e-14, rtol=1e-14))


def thick(*, radius: float, material: Material, a: float) -> tuple[float, float, float]:
    """Return force, approach and central pressure for a contact much smaller than the thickness: Hertz.

    Parameters
    ----------
    radius : float
        Radius of curvature R of the paraboloid.
    material : Material
        Material of the layer.
    a : float
        Contact radius. Range: a/h < 0.02 for one per cent in the approach (the error grows as a/h).

    Returns
    -------
    tuple of (float, float, float)
        P = 4 E* a^3/(3R), delta = a^2/R, p0 = 2 E* a/(pi R).

    Raises
    ------
    InputError
        If a number is not positive.

    References
    ----------
    Johnson 1985, chapter 4.

    Examples
    --------
    >>> thick(radius=1.0, material=Material(E=3.0, nu=0.0), a=1.0)[:2]
    (4.0, 1.0)
    """
    R, width = checks.positive("the radius", radius), checks.positive("the contact radius", a)
    E_star = material.plane_strain_modulus
    return 4 * E_star * width**3 / (3 * R), width**2 / R, 2 * E_star * width / (math.pi * R)


def thin_compressible(
    *, radius: float, thickness: float, material: Material, a: float, base: Base = "bonded"
) -> tuple[float, float, float]:
    """Return force, approach and central pressure for a thin, compressible layer: an elastic foundation.

    Parameters
    ----------
    radius : float
        As in `thick`.
    thickness : float
        Thickness h of the layer.
    material : Material
        Material of the layer; not nearly incompressible if it is bonded.
    a : float
        Contact radius. Range: a/h > 10; see the notes.
    base : {"bonded", "frictionless"}
        How the layer rests on the rigid foundation.

    Returns
    -------
    tuple of (float, float, float)
        P = pi H a^4/(4 R h), delta = a^2/(2R), p0 = H a^2/(2 R h), with the foundation modulus
        H = E (1 - nu)/((1 + nu)(1 - 2 nu)) bonded, E/(1 - nu^2) frictionless.

    Raises
    ------
    InputError
        If a number is not positive, or the base unknown.

    Notes
    -----
    The error falls as h/a. Bonded, the exact force is larger by 7.5, 2.5, 1.5 per cent at a/h = 10, 30, 50 for nu = 0,
    by 5.0, 1.6, 1.0 per cent for nu = 0.3; for nu > 0.45 neither this limit nor the incompressible one holds.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 5.8.

    Examples
    --------
    >>> thin_compressible(radius=1.0, thickness=0.5, material=Material(E=1.0, nu=0.0), a=1.0)[1:]
    (0.5, 1.0)
    """
    R, h = checks.positive("the radius", radius), checks.positive("the thickness", thickness)
    width = checks.positive("the contact radius", a)
    stiffness = 1 / float(compliance(0.0, h, material, base))  # H/h
    return math.pi * stiffness * width**4 / (4 * R), width**2 / (2 * R), stiffness * width**2 / (2 * R)


def thin_incompressible(*, radius: float, thickness: float, material: Material, a: float) -> tuple[float, float, float]:
    """Return force, approach and central pressure for a thin, incompressible, bonded layer (film).

    Parameters
    ----------
    radius, thickness : float
        As in `thin_compressible`.
    material : Material
        Material of the layer; only its shear modulus G enters.
    a : float
        Contact radius. Range: a/h large, and (1 - 2 nu) (a/h)^2 much less than 1; see the notes.

    Returns
    -------
    tuple of (float, float, float)
        P = pi G a^6/(32 R h^3), delta = a^2/(4R), p0 = 3 G a^4/(32 R h^3).

    Raises
    ------
    InputError
        If a number is not positive.

    Notes
    -----
    Material is displaced sideways by the pressure gradient as in a lubricating film, delta - r^2/(2R) = -(h^3/(3G)) lap
    p, with p and its gradient zero at the edge: p = (3 G/(32 R h^3)) (a^2 - r^2)^2. The error falls only as h/a: for nu
    = 0.499999 the exact force is 2.2, 1.33 and 1.19 times this one at a/h = 10, 30 and 50, the approach 1.25, 1.09 and
    1.06 times. Use it as an estimate, not as a reference for tests.

    References
    ----------
    J. R. Barber, J. Appl. Mech. 57 (1990) 489; Johnson 1985, chapter 5 for the plane case.

    Examples
    --------
    >>> thin_incompressible(radius=1.0, thickness=0.5, material=Material(E=3.0, nu=0.49999), a=1.0)[1]
    0.25
    """
    R, h = checks.positive("the radius", radius), checks.positive("the thickness", thickness)
    width, G = checks.positive("the contact radius", a), material.shear_modulus
    p0 = 3 * G * width**4 / (32 * R * h**3)
    return math.pi * p0 * width**2 / 3, width**2 / (4 * R), p0
