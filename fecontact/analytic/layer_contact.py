"""Elastic layer on a rigid foundation under a rigid paraboloid, solved by its integral equation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from fecontact.analytic._contact import RoundContact
from fecontact.analytic._quadrature import composite_gauss, gauss
from fecontact.analytic.layer_kernel import Base, checked_base, deficit
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

# Largest contact radius over thickness for which the integral equation is solved; use the asymptotes beyond it.
LARGEST_RATIO = 50.0


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
    if ratio > LARGEST_RATIO:
        raise InputError(
            f"Expected a contact radius up to {LARGEST_RATIO} times the thickness; found {ratio:.4g}. "
            "Use the asymptotes thin_compressible() or thin_incompressible()."
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
    largest = math.log(LARGEST_RATIO)
    if high > largest and excess(largest) < 0:
        raise InputError(
            f"The given {name} = {value!r} makes a contact wider than {LARGEST_RATIO} times the thickness. "
            "Use the asymptotes thin_compressible() or thin_incompressible()."
        )
    high = min(high, largest)
    while excess(low) > 0:
        low -= 2.0
    return math.exp(brentq(excess, low, high, xtol=1e-14, rtol=1e-14))
