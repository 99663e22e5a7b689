"""Rigid frictionless indenter of any axisymmetric profile on a half-space (Galin-Sneddon integrals)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq
from scipy.special import elliprf

from fecontact.analytic._contact import RoundIndentation
from fecontact.analytic._functions import double_exponential
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

Function = Callable[[Array], Array]

# Differences of eighth order (one-sided second: seventh): central at -4 ... 4 steps, one-sided at 0 ... 8 steps.
_CENTRAL_FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_CENTRAL_SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
_SIDE_FIRST = np.array([-761 / 280, 8, -14, 56 / 3, -35 / 2, 56 / 5, -14 / 3, 8 / 7, -1 / 8])
_SIDE_SECOND = np.array(
    [29531 / 5040, -962 / 35, 621 / 10, -4006 / 45, 691 / 8, -282 / 5, 2143 / 90, -206 / 35, 363 / 560]
)


@dataclass(frozen=True, eq=False)
class Profile:
    """Profile of an indenter, f(0) = 0, given by its slope or its height; kinks only at the breaks.

    Derivatives not given are taken by eighth-order differences with a step of one hundredth of the radius, one-sided
    beside a break, with relative errors of 1e-13 in first and 1e-11 in second derivatives of smooth profiles.

    Parameters
    ----------
    slope : callable or None
        f'(r), accepting arrays of r > 0.
    height : callable or None
        f(r), accepting arrays of r > 0; used where `slope` is None.
    breaks : tuple of float
        Radii at which f or f' is not smooth, increasing.

    Examples
    --------
    >>> Profile(slope=None, height=lambda r: r**2 / 2, breaks=()).first(np.array([3.0])).round(9)
    array([3.])
    """

    slope: Function | None
    height: Function | None
    breaks: tuple[float, ...]

    def first(self, r: Array) -> Array:
        """Return f'(r)."""
        if self.slope is not None:
            return np.asarray(self.slope(r), dtype=float)
        assert self.height is not None
        return self._difference(self.height, r, second=False)

    def second(self, r: Array) -> Array:
        """Return f''(r)."""
        if self.slope is not None:
            return self._difference(self.slope, r, second=False)
        assert self.height is not None
        return self._difference(self.height, r, second=True)

    def kink(self, radius: float) -> float:
        """Return the jump of f' at a break."""
        step = 1e-6 * radius
        beside = radius + np.array([-step, step])
        value, rate = self.first(beside), self.second(beside)
        return float(value[1] - value[0] - step * (rate[0] + rate[1]))

    def _difference(self, function: Function, r: Array, *, second: bool) -> Array:
        """Return the first or second derivative of `function`, with differences that do not cross a break."""
        step, near, away = 0.01 * r, np.zeros(r.shape, dtype=bool), np.ones_like(r)
        edges = (0.0, *self.breaks, math.inf)
        for low, high in pairwise(edges):
            within = (r > low) & (r <= high)
            step = np.where(within, np.minimum(step, (high - low) / 16), step)
            room = np.minimum(r - low if low > 0 else np.inf, high - r)
            near |= within & (room < 4 * step)
            away = np.where(within & (high - r < r - low), -1.0, away)
        total = np.zeros_like(r)
        for j in range(9):
            place = r + np.where(near, away * j, j - 4.0) * step
            side, central = (
                (_SIDE_SECOND[j], _CENTRAL_SECOND[j]) if second else (away * _SIDE_FIRST[j], _CENTRAL_FIRST[j])
            )
            total += np.where(near, side, central) * function(place)
        return np.asarray(total / step**2 if second else total / step)


def _at_each(value: Callable[[float], float], radii: Array) -> Array:
    """Values at radii of any shape; repeated radii, as on a grid, are evaluated once."""
    different, which = np.unique(radii, return_inverse=True)
    return np.array([value(float(radius)) for radius in different])[which].reshape(radii.shape)


@dataclass(frozen=True, eq=False)
class AxisymmetricContact(RoundIndentation):
    """Indentation by a rigid axisymmetric profile; made by `indent`.

    Parameters
    ----------
    force : float
        Load P.
    approach : float
        Displacement delta of the indenter from first touch. The pressure is infinite at kinks of the profile and at a
        sharp tip.
    a : float
        Radius of the contact.
    E_star : float
        Contact modulus.
    profile : Profile
        The indenter's profile.

    References
    ----------
    L. A. Galin, Contact Problems, 1953; I. N. Sneddon, Int. J. Engng Sci. 3 (1965) 47.

    Examples
    --------
    >>> print(indent(slope=lambda r: r / 10, modulus=3.0, a=1.0))
    Axisymmetric indenter
      force            P      0.4
      approach         delta  0.1
      contact radius   a      1
      mean pressure    pm     0.127324
      stiffness        dP/dd  6
      contact modulus  E*     3
    >>> contact = indent(slope=lambda r: r, modulus=np.pi / 2, a=1.0)
    >>> contact.pressure([0.0, 0.6, 2.0]).round(9)
    array([1. , 0.8, 0. ])
    >>> contact.displacement([0.0, 1.0, 2.0]).round(6)
    array([1.      , 0.5     , 0.217996])
    """

    force: float
    approach: float
    a: float
    E_star: float
    profile: Profile

    _title = "Axisymmetric indenter"
    _rows = ("force", "approach", "a", "mean_pressure", "stiffness", "E_star")

    def _pressure(self, r: Array) -> Array:
        return _at_each(self._pressure_at, r)

    def _pressure_at(self, r: float) -> float:
        """(E*/pi) times the integral of d(t G)/dt with 1/sqrt(t^2 - r^2) over t = r ... a (Sneddon 1965).

        It is taken in t = r cosh(tau). A jump of the slope at b adds b [f'] times an elliptic integral of the first
        kind, taken in closed form.
        """
        if r >= self.a:
            return 0.0
        tiny = 1e-60 * self.a  # stands for r = 0: the error is (tiny/a)^(n - 1) for a tip like r^n
        if r == 0 and float(self.profile.first(np.array([tiny]))[0]) > 1e-3 * self.approach / self.a:
            return math.inf
        radius = max(r, tiny)
        # Near the axis the range of tau is long and the integrand exponential in it: panels by powers of t help.
        scales = self.a * np.array([1e-20, 1e-5, 0.03])
        inner = sorted(point for point in (*self.profile.breaks, *scales) if radius < point < self.a)
        edges = np.arccosh(np.array([radius, *inner, self.a]) / radius)
        x, w = double_exponential(3)
        total = 0.0
        for start, end in pairwise(edges):
            t = radius * np.cosh(start + (end - start) * x)
            total += float((end - start) * w @ self._rate(t))
        for point in self.profile.breaks:
            jump = self.profile.kink(point)
            if point < self.a and abs(jump) > 1e-9 * self.approach / self.a:  # smaller ones are rounding
                total += point * jump * _green(radius, point, self.a)
        return self.E_star / math.pi * total

    def _rate(self, t: Array) -> Array:
        """Return d(t G)/dt without the contribution of kinks: the integral of f' + x f'' over x = t sin(theta)."""
        x, w = double_exponential(3)
        angles = [np.arcsin(np.minimum(point / t, 1.0)) for point in self.profile.breaks if point < np.median(t)]
        edges = [np.zeros_like(t), *angles, np.full_like(t, np.pi / 2)]
        total = np.zeros_like(t)
        for start, end in pairwise(edges):
            width = (end - start)[:, None]
            place = t[:, None] * np.sin(start[:, None] + width * x)
            integrand = self.profile.first(place) + place * self.profile.second(place)
            total += (width * w * integrand).sum(axis=1)
        return total

    def _displacement(self, r: Array) -> Array:
        return _at_each(self._displacement_at, r)

    def _displacement_at(self, r: float) -> float:
        """Delta - f(r) inside (Sneddon 1965), the inner integral taken in closed form."""
        end = min(r, self.a)
        if end == 0:
            return self.approach
        points, weights = _panels(end, self.profile.breaks)
        slope = self.profile.first(points)
        if r <= self.a:
            return self.approach - float(weights @ slope)
        share = np.arctan2(np.sqrt(np.maximum(self.a**2 - points**2, 0.0)), math.sqrt((r - self.a) * (r + self.a)))
        return 2 / math.pi * (self.approach * math.asin(self.a / r) - float(weights @ (slope * share)))


def indent(
    *,
    modulus: float,
    slope: Function | None = None,
    height: Function | None = None,
    breaks: Sequence[float] = (),
    a: float | None = None,
    force: float | None = None,
    approach: float | None = None,
    limit: float | None = None,
) -> AxisymmetricContact:
    """Return the indentation of a half-space by a rigid axisymmetric profile.

    Parameters
    ----------
    modulus : float
        E/(1 - nu^2) of the half-space, or E* if the indenter is elastic too.
    slope, height : callable
        f'(r) or f(r) with f(0) = 0, for arrays of r > 0; exactly one. Non-decreasing, so that the contact is one disc.
        Defined to 1.08 times the contact radius (or the limit), since derivatives are taken by differences.
    breaks : sequence of float
        Radii at which the profile has kinks.
    a, force, approach : float, optional
        Contact radius, load or displacement, positive; exactly one.
    limit : float, optional
        Largest contact radius to consider when force or approach is given.

    Returns
    -------
    AxisymmetricContact
        Force, approach and radius; its methods give the fields.

    Raises
    ------
    InputError
        If not exactly one of each group is given, the limit is missing or too small, or the integrals do not converge
        because the profile has kinks that are not named in `breaks`.

    Notes
    -----
    With G(t) = integral of f'(t sin theta) over theta = 0 ... pi/2: delta = a G(a), and P = 2 E* a^2 times the integral
    of f'(a sin theta) sin^2(theta). Double-exponential quadrature on each panel between breaks.

    References
    ----------
    Galin 1953; Sneddon 1965.

    Examples
    --------
    >>> contact = indent(height=lambda r: 0.1 * r, modulus=1.0, force=1.0, limit=100.0)
    >>> bool(abs(contact.a - np.sqrt(2 / (0.1 * np.pi))) < 1e-9 * contact.a)
    True
    """
    E_star = checks.positive("the modulus", modulus)
    if (slope is None) == (height is None):
        raise InputError("Expected exactly one of slope= and height=; found " + ("none." if slope is None else "both."))
    points = tuple(sorted(checks.positive("a break", point) for point in breaks))
    profile = Profile(slope=slope, height=height, breaks=points)
    name, value = checks.one_of(a=a, force=force, approach=approach)
    radius = value if name == "a" else _radius(profile, E_star, name, value, limit)
    delta, load = _resultants(profile, E_star, radius, level=4)
    finer = _resultants(profile, E_star, radius, level=5)
    if not (math.isfinite(delta) and abs(finer[0] - delta) <= 1e-8 * abs(delta)):
        raise InputError(
            f"The integrals over the profile do not converge on r <= {radius}: {delta} and {finer[0]} by two rules. "
            "Name the radii of its kinks in breaks=, and check that it is finite and rises from zero.",
            code="integrals-diverge",
        )
    return AxisymmetricContact(force=load, approach=delta, a=radius, E_star=E_star, profile=profile)


def _radius(profile: Profile, E_star: float, name: str, value: float, limit: float | None) -> float:
    """Return the contact radius at which the approach or the force has the given value."""
    if limit is None:
        raise InputError(f"Expected limit=, the largest contact radius to consider, with {name}=; found None.")
    largest = checks.positive("the limit", limit)
    which = 0 if name == "approach" else 1

    def excess(log_radius: float) -> float:
        return _resultants(profile, E_star, math.exp(log_radius), level=4)[which] / value - 1

    low, high = math.log(largest) - 40, math.log(largest)
    reached = (excess(high) + 1) * value
    if not math.isfinite(reached):
        raise InputError(
            f"Expected a profile that is finite to 1.08 times limit = {largest}; found {reached} for the {name}. "
            "Give a smaller limit.",
            code="profile-not-finite",
        )
    if reached < value:
        raise InputError(
            f"Expected a contact radius up to limit = {largest}, at which the {name} is {reached}; found "
            f"{name} = {value}. Give a larger limit, if the profile is defined there.",
            code="limit-too-small",
        )
    # A flat end is in contact over its whole width at once: the radius is that width for any small force or approach.
    return math.exp(brentq(excess, low, high, xtol=1e-14, rtol=1e-14))


def _resultants(profile: Profile, E_star: float, a: float, *, level: int) -> tuple[float, float]:
    """Return approach and force at contact radius a."""
    x, w = double_exponential(level)
    edges = np.array([0.0, *(math.asin(point / a) for point in profile.breaks if point < a), np.pi / 2])
    G, moment = 0.0, 0.0
    for start, end in pairwise(edges):
        sine = np.sin(start + (end - start) * x)
        slope = profile.first(a * sine)
        G += float((end - start) * w @ slope)
        moment += float((end - start) * w @ (slope * sine**2))
    return a * G, 2 * E_star * a**2 * moment


def _panels(end: float, breaks: tuple[float, ...]) -> tuple[Array, Array]:
    """Return double-exponential nodes and weights on (0, end), split at the breaks."""
    x, w = double_exponential(4)
    edges = np.array([0.0, *(point for point in breaks if point < end), end])
    widths = np.diff(edges)
    return (edges[:-1, None] + widths[:, None] * x).ravel(), (widths[:, None] * w).ravel()


def _green(r: float, b: float, a: float) -> float:
    """Return the integral of 1/sqrt((t^2 - r^2)(t^2 - b^2)) over t = max(r, b) ... a."""
    lower = max(r, b) ** 2
    if r == b:
        return math.inf
    return float(elliprf(lower, lower - r**2, lower - b**2) - elliprf(a**2, a**2 - r**2, a**2 - b**2))
