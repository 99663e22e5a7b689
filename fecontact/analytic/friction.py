"""Contact with Coulomb friction: partial slip, rolling, torsion, adhesion under normal load, belts.

Stick under a normal load alone, where Poisson's ratios or materials make the surfaces slide on each other.

A belt round a drum: tension by Euler and Eytelwein.

What closed forms of contacts with friction have in common: the contact under the normal force.

Partial slip of cylinders in Hertz's line contact: a tangential force (Cattaneo) and tractive rolling (Carter).

Partial slip of spheres in Hertz contact under a tangential force: Cattaneo and Mindlin, cycles by Deresiewicz.

A ball twisted on a Hertz contact with friction: Lubkin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc, ellipkm1

from fecontact.analytic import disc
from fecontact.analytic._contact import Tabulated, dundurs
from fecontact.analytic._functions import arctan_defect, double_exponential, trough_gap
from fecontact.analytic.hertz import CircularContact, LineContact
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.renamed import renamed

__all__ = [
    "LineSlip",
    "RoundSlip",
    "TorsionSlip",
    "belt_slip_angle",
    "belt_tension",
    "carter",
    "cattaneo",
    "dundurs",
    "lubkin",
    "mindlin",
    "stick_ratio",
]


def stick_ratio(friction: float, beta: float, *, plane: bool = False) -> float:
    """Return the ratio c/a of the radii of stick and contact under a normal load that grows from zero.

    The same for every indenter whose profile is a power of the radius (self-similar contact), flat punch included. The
    effect of the shear tractions on the pressure is left out (Goodman's approximation).

    Parameters
    ----------
    friction : float
        Coulomb's mu, zero or positive; infinite: all sticks.
    beta : float
        Dundurs' second constant, see `dundurs`; zero: no tendency to slip, all sticks.
    plane : bool
        Whether the contact is a line (plane strain) instead of a circle.

    Returns
    -------
    float
        c/a, from 0 without friction to 1; of the half-widths in the plane.

    Raises
    ------
    InputError
        If friction is negative or NaN, or beta is not within -1/2 to 1/2.

    Notes
    -----
    Circle: (a/2c) ln((a + c)/(a - c)) = (mu/|beta|) K'(c/a); plane: K'(c/a)/K(c/a) = |beta|/mu, with complete elliptic
    integrals of modulus c/a and of the complementary one.

    References
    ----------
    D. A. Spence, J. Elasticity 5 (1975) 297; K. L. Johnson, Contact Mechanics, 1985, section 5.4.

    Examples
    --------
    >>> round(stick_ratio(0.3, 2 / 7), 4), round(stick_ratio(0.3, 2 / 7, plane=True), 4)
    (0.9186, 0.7438)
    """
    mu = checks.friction(friction, infinite=True)
    if not -0.5 <= beta <= 0.5:
        raise InputError(f"Dundurs' beta must lie between -1/2 and 1/2; found {beta!r}. See fc.analytic.friction.")
    if mu == 0:
        return 1.0 if beta == 0 else 0.0
    ratio = abs(beta) / mu
    if ratio < 1e-12:
        return 1.0

    def excess(log: float) -> float:
        k2, rest = _squares(log)
        if plane:
            return math.log(float(_first_kind(rest, k2) / _first_kind(k2, rest)) / ratio)
        k = math.sqrt(k2)
        left = (math.log1p(k) - math.log(rest) / 2) / k if k > 1e-4 else 1 + k2 / 3
        return math.log(float(_first_kind(rest, k2)) / (ratio * left))

    low, high = -300.0, 300.0
    if excess(low) < 0:
        return 0.0
    return math.sqrt(_squares(brentq(excess, low, high, xtol=1e-13))[0]) if excess(high) < 0 else 1.0


def _squares(log: float) -> tuple[float, float]:
    """The squared modulus and its complement, both to full relative accuracy, by the logarithm of their ratio."""
    return 1 / (1 + math.exp(-log)), 1 / (1 + math.exp(log))


def _first_kind(m: float, complement: float) -> float:
    """Complete elliptic integral K of parameter m, without cancellation for m near 1."""
    return float(ellipkm1(complement) if complement < 0.5 else ellipk(m))


def belt_tension(slack: float, friction: float, angle: float) -> float:
    """Return the tension at the tight end of a belt that slips on the whole angle of wrap, slack exp(mu angle).

    Parameters
    ----------
    slack : float
        Tension at the slack end, positive.
    friction : float
        Coulomb's mu, zero or positive.
    angle : float
        Angle of wrap in radians, zero or positive; may exceed 2 pi.

    Returns
    -------
    float
        Tension at the other end: the largest that friction holds.

    Raises
    ------
    InputError
        If the tension is not positive, or friction or angle is negative or not finite.

    References
    ----------
    L. Euler, Mem. Acad. Sci. Berlin 18 (1769) 265; J. A. Eytelwein, Handbuch der Statik fester Koerper, 1808.

    Examples
    --------
    >>> round(belt_tension(10.0, 0.3, math.pi), 4)
    25.6633
    """
    mu, wrap = checks.friction(friction), float(checks.depths("angle", angle))
    return checks.positive("the tension", slack) * math.exp(mu * wrap)


def belt_slip_angle(slack: float, tight: float, friction: float) -> float:
    """Return the angle on which a belt slips on a drum that it drives or brakes, ln(tight/slack)/mu.

    On the rest of the angle of wrap, towards the end where the belt runs on, it sticks.

    Parameters
    ----------
    slack, tight : float
        Tensions at the ends, positive, the tight one not smaller.
    friction : float
        Coulomb's mu, positive.

    Raises
    ------
    InputError
        If a value is not positive, or the tight end is the slacker one.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 8.1 (creep of a belt).

    Examples
    --------
    >>> round(belt_slip_angle(10.0, belt_tension(10.0, 0.3, 2.0), 0.3), 12)
    2.0
    """
    checks.lengths(slack=slack, tight=tight, friction=friction)
    if tight < slack:
        raise InputError(f"Expected tight >= slack; found tight={tight!r} and slack={slack!r}. Exchange them.")
    return math.log(tight / slack) / friction


C = TypeVar("C", CircularContact, LineContact)


@dataclass(frozen=True)
class Frictional(Tabulated, Generic[C]):
    """A contact with friction; a line contact is taken per length.

    Parameters
    ----------
    contact : CircularContact or LineContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    """

    contact: C
    friction: float

    @property
    def force(self) -> float:
        """Normal force."""
        return self.contact.force

    @property
    def a(self) -> float:
        """Radius or half-width of the contact."""
        return self.contact.a


@dataclass(frozen=True)
class _PartialSlip(Frictional[LineContact]):
    """A line contact with a stick zone of half-width `c`; traction on the second body along the force on the first.

    Parameters
    ----------
    contact : LineContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    tangential : float
        Tangential force Q' per length, from zero to mu P'.
    c : float
        Half-width of the zone of stick, a (1 - Q'/(mu P'))^(1/2).
    """

    tangential: float
    c: float

    @property
    def centre(self) -> float:
        """Coordinate of the middle of the zone of stick."""
        return 0.0

    def traction(self, x: ArrayLike) -> Array:
        """Return the tangential traction along the force, zero outside the contact.

        Parameters
        ----------
        x : array_like
            Coordinate across the line of contact, from its centre, any sign and shape.

        Returns
        -------
        numpy.ndarray
            mu p0 (sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - (x - d)^2/c^2)), d the centre of stick; shape of `x`.

        Raises
        ------
        InputError
            If a coordinate is not finite.

        References
        ----------
        K. L. Johnson, Contact Mechanics, 1985, sections 7.2(a) and 8.3.
        """
        offset = checks.coordinates("x", x) - self.centre
        inner = np.sqrt(np.maximum((self.c - offset) * (self.c + offset), 0.0)) / self.a
        return np.asarray(self.friction * (self.contact.pressure(x) - self.contact.p0 * inner))


class LineSlip(_PartialSlip):
    """Line contact under a constant normal force and a tangential force that grew from zero; made by `cattaneo`.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> roller = hertz.line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
    >>> print(cattaneo(roller, friction=0.3, tangential=100.0))
    Partial slip over a line (Cattaneo)
      normal force per length      P'  1000
      friction                     mu  0.3
      tangential force per length  Q'  100
      half-width                   a   0.332186
      half-width of stick          c   0.271229
    """

    _title = "Partial slip over a line (Cattaneo)"
    _rows = (
        ("normal force per length", "P'", "force"),
        ("friction", "mu", "friction"),
        ("tangential force per length", "Q'", "tangential"),
        ("half-width", "a", "a"),
        ("half-width of stick", "c", "c"),
    )

    def slip(self, x: ArrayLike) -> Array:
        """Return the slip: zero where it sticks, opposite to the traction where it slips, NaN outside the contact.

        Notes
        -----
        mu times the gap of a Hertz contact of the half-width of stick, for pressures and tangential tractions displace
        a half-plane along themselves alike.
        """
        at = np.abs(checks.coordinates("x", x))
        c = max(self.c, 1e-12 * self.a)
        slip = 0.0 - self.friction * c * (c / self.contact.R) / 2 * trough_gap(at / c)
        return np.asarray(np.where(at <= self.a, slip, np.nan))


class RollingSlip(_PartialSlip):
    """A cylinder that rolls steadily along +x under a tangential force; made by `carter`.

    The zone of stick is at the leading edge, x = a.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> roller = hertz.line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
    >>> print(carter(roller, friction=0.3, tangential=100.0))
    Tractive rolling (Carter)
      normal force per length      P'  1000
      friction                     mu  0.3
      tangential force per length  Q'  100
      half-width                   a   0.332186
      half-width of stick          c   0.271229
      creepage                     xi  0.00182872
    """

    _title = "Tractive rolling (Carter)"
    _rows = (*LineSlip._rows, ("creepage", "xi", "creepage"))

    @property
    def centre(self) -> float:
        """Coordinate of the middle of the zone of stick, a - c."""
        return self.a - self.c

    @property
    def creepage(self) -> float:
        """Difference of the bodies' speeds over the speed of rolling, mu (a - c)/R; Johnson 1985, section 8.3."""
        return self.friction * (self.a - self.c) / self.contact.R

    def slip_rate(self, x: ArrayLike) -> Array:
        """Return the slip per distance rolled: zero where it sticks, opposite to the traction, NaN outside.

        Notes
        -----
        The creepage less the difference of the tangential strains: -mu sqrt((x - d)^2 - c^2)/R behind the zone of
        stick.

        References
        ----------
        F. W. Carter, Proc. R. Soc. A 112 (1926) 151; Johnson 1985, section 8.3.
        """
        at = checks.coordinates("x", x)
        behind = np.maximum(self.centre - at, 0.0)
        root = np.sqrt(np.maximum((behind - self.c) * (behind + self.c), 0.0))
        rate = 0.0 - self.friction * root / self.contact.R
        return np.asarray(np.where(np.abs(at) <= self.a, rate, np.nan))


def cattaneo(contact: LineContact, friction: float, *, tangential: float) -> LineSlip:
    """Return the partial slip of a line contact under a tangential force across the line.

    Exact where normal and tangential problem are not coupled: equal bodies, or Dundurs' beta = 0.

    Parameters
    ----------
    contact : LineContact
        From `hertz.line`.
    friction : float
        Coulomb's mu, positive.
    tangential : float
        Tangential force Q' per length, positive, at most mu P'.

    Returns
    -------
    LineSlip

    Raises
    ------
    InputError
        If a value is not positive, or the contact slides as a whole.

    References
    ----------
    C. Cattaneo, Rend. Accad. Lincei 27 (1938) 342; K. L. Johnson, Contact Mechanics, 1985, section 7.2(a).

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> roller = hertz.line(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=1e-4)
    >>> half = cattaneo(roller, friction=0.4, tangential=0.75 * 0.4 * roller.force)
    >>> round(half.c / half.a, 12), half.slip([0.0, 2 * half.c]) < 0
    (0.5, array([False,  True]))
    """
    return LineSlip(contact, *_stick(contact, friction, tangential))


def carter(contact: LineContact, friction: float, *, tangential: float) -> RollingSlip:
    """Return the steady rolling of cylinders under a tangential force; arguments as in `cattaneo`.

    References
    ----------
    F. W. Carter, Proc. R. Soc. A 112 (1926) 151; K. L. Johnson, Contact Mechanics, 1985, section 8.3.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> roller = hertz.line(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=1e-4)
    >>> wheel = carter(roller, friction=0.4, tangential=0.75 * 0.4 * roller.force)
    >>> round(wheel.creepage / (0.4 * wheel.a), 12)
    0.5
    """
    return RollingSlip(contact, *_stick(contact, friction, tangential))


def _stick(contact: LineContact, friction: float, tangential: float) -> tuple[float, float, float]:
    """Checked friction and force, and the half-width of stick."""
    mu = checks.positive("the friction", friction)
    force = checks.positive("the tangential force", tangential)
    limit = mu * contact.force
    if force > limit * (1 + 1e-14):
        raise InputError(
            f"The contact slides as a whole: the tangential force can be at most mu P' = {limit:g}; found {force:g}.",
            code="slides-as-a-whole",
        )
    return mu, force, contact.a * math.sqrt(max(1 - force / limit, 0.0))


@dataclass(frozen=True)
class RoundSlip(Frictional[CircularContact]):
    """Circular contact under a constant normal force and a tangential force that grew from zero; made by `mindlin`.

    The traction acts on the second body along the force that pushes the first one. The slip is that of the second
    surface against the first, hence opposite to the traction.

    Parameters
    ----------
    contact : CircularContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    tangential : float
        Tangential force Q, from zero to mu P.
    c : float
        Radius of stick, a (1 - Q/(mu P))^(1/3).
    shift : float
        Displacement of points far away in the one body relative to those in the other, along the force.
    modulus : float
        Modulus of the mean tangential displacement, 1/sum((2 - nu)/(4 G)) over both bodies.

    References
    ----------
    C. Cattaneo, Rend. Accad. Lincei 27 (1938) 342, 434, 474; R. D. Mindlin, J. Appl. Mech. 16 (1949) 259; R. D. Mindlin
    & H. Deresiewicz, J. Appl. Mech. 20 (1953) 327; K. L. Johnson, Contact Mechanics, 1985, sections 7.2 and 7.4.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> ball = hertz.spheres(radii=(10.0, np.inf), materials=(steel, steel), force=100.0)
    >>> print(mindlin(ball, friction=0.3, tangential=18.0))
    Partial slip over a circle (Cattaneo, Mindlin)
      normal force          P   100
      friction              mu  0.3
      tangential force      Q   18
      contact radius        a   0.186626
      stick radius          c   0.137507
      shift                 d   0.000579978
      tangential stiffness  kt  26132.5
      energy per cycle      W   0.0020837
    """

    tangential: float
    c: float
    shift: float
    modulus: float

    _title = "Partial slip over a circle (Cattaneo, Mindlin)"
    _rows = (
        ("normal force", "P", "force"),
        ("friction", "mu", "friction"),
        ("tangential force", "Q", "tangential"),
        ("contact radius", "a", "a"),
        ("stick radius", "c", "c"),
        ("shift", "d", "shift"),
        ("tangential stiffness", "kt", "stiffness"),
        ("energy per cycle", "W", "cycle_energy"),
    )

    @property
    def stiffness(self) -> float:
        """Slope dQ/d(shift), that of a disc of the radius of stick, 2 E_t c (Mindlin 1949)."""
        return 2 * self.modulus * self.c

    @property
    def friction_work(self) -> float:
        """Work of friction while the tangential force grew from zero; a quarter of that of a cycle."""
        return self.cycle_energy / 4

    dissipated = renamed("dissipated", "friction_work")

    @property
    def cycle_energy(self) -> float:
        """Work of friction in a cycle of the tangential force between -Q and Q; Johnson 1985, section 7.4."""
        limit = self.friction * self.force
        return 3.6 * limit**2 / (self.a * self.modulus) * _loop(self.tangential / limit)

    def traction(self, r: ArrayLike) -> Array:
        """Return the tangential traction along the force, mu p in the annulus of slip, zero outside the contact.

        Parameters
        ----------
        r : array_like
            Distance from the axis, any shape.

        Returns
        -------
        numpy.ndarray
            Traction, shape of `r`.

        Raises
        ------
        InputError
            If a distance is negative or not finite.

        References
        ----------
        Johnson 1985, section 7.2(d).
        """
        inside = self.contact.pressure(r)
        if self.c > 0:
            inside = inside - disc.hertz_pressure(r, a=self.c, p0=self.contact.p0 * self.c / self.a)
        return np.asarray(self.friction * inside)

    def slip(self, r: ArrayLike) -> Array:
        """Return the slip along the force, mean over the circle of radius r; distances as in `traction`.

        Returns
        -------
        numpy.ndarray
            Zero where it sticks, negative (opposite to the traction) in the annulus of slip, NaN outside the contact.

        Notes
        -----
        mu E*/E_t times the gap of a Hertz contact of the radius of stick, for the two displacements differ by the
        factor of their kernels. For nu = 0 it is the slip itself; for others it is its mean round the circle, and a
        slip across the force, on which this solution is silent, remains.
        """
        distance, c = checks.depths("r", r), max(self.c, 1e-12 * self.a)
        s = np.sqrt(np.maximum((distance / c - 1) * (distance / c + 1), 0.0))
        gap = c * (c / self.contact.R) / np.pi * (s * arctan_defect(s) + s**2 * np.arctan(s))
        slip = 0.0 - self.friction * self.contact.E_star / self.modulus * gap
        return np.asarray(np.where(distance <= self.a, slip, np.nan))

    def shift_in_cycle(self, tangential: ArrayLike) -> Array:
        """Return the shift on the unloading branch of a cycle between Q and -Q; that of loading is -f(-tangential).

        Parameters
        ----------
        tangential : array_like
            Tangential forces between -Q and Q.

        Raises
        ------
        InputError
            If a force lies outside the cycle.

        References
        ----------
        Mindlin & Deresiewicz 1953; Johnson 1985, section 7.4.
        """
        values = checks.coordinates("tangential", tangential)
        if np.any(np.abs(values) > self.tangential):
            raise InputError(
                f"Expected forces of the cycle, from {-self.tangential:g} to {self.tangential:g}; found "
                f"{values[np.abs(values) > self.tangential].flat[0]:g}. Give the cycle a larger tangential force.",
                code="cycle-exceeds-force",
            )
        limit = self.friction * self.force
        back = np.cbrt(1 - (self.tangential - values) / (2 * limit)) ** 2
        return np.asarray(self.shift - 2 * _slide(limit, self.a, self.modulus) * (1 - back))


def _loop(q: float) -> float:
    """1 - (1 - q)^(5/3) - (5 q/6)(1 + (1 - q)^(2/3)), for small q by its series, which begins with q^3."""
    if q > 0.05:
        left = math.cbrt(1 - q) ** 2
        return 1 - left * (1 - q) - 5 / 6 * q * (1 + left)
    # of q^n: (5/6 - 5/(3 n)) times the coefficient of q^(n-1) in -(1 - q)^(2/3)
    total, coefficient = 0.0, 2 / 3
    for n in range(3, 15):
        coefficient *= (n - 2 - 2 / 3) / (n - 1)
        total += 5 / 6 * (1 - 2 / n) * coefficient * q**n
    return total


def _slide(limit: float, a: float, modulus: float) -> float:
    """Shift at which all slips, 3 mu P/(4 a E_t)."""
    return 3 * limit / (4 * a * modulus)


def mindlin(
    contact: CircularContact, friction: float, *, tangential: float | None = None, shift: float | None = None
) -> RoundSlip:
    """Return the partial slip of a Hertz contact under a tangential force.

    Exact where the normal and the tangential problem are not coupled and nu = 0. For nu > 0 of equal bodies, the
    tractions across the force, a few per cent of mu p0, are left out; for unlike bodies also the change of pressure.

    Parameters
    ----------
    contact : CircularContact
        From `hertz.spheres`.
    friction : float
        Coulomb's mu, positive.
    tangential : float, optional
        Tangential force Q, positive, at most mu P.
    shift : float, optional
        Relative displacement of the bodies; give this or the force.

    Returns
    -------
    RoundSlip

    Raises
    ------
    InputError
        If not exactly one of force and shift is given, a value is not positive, or the contact slides as a whole.

    References
    ----------
    C. Cattaneo, Rend. Accad. Lincei 27 (1938) 342; R. D. Mindlin, J. Appl. Mech. 16 (1949) 259.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> ball = hertz.spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=4e-3 / 3)
    >>> half = mindlin(ball, friction=0.5, tangential=0.5 * 0.5 * ball.force)
    >>> round(half.c / half.a, 6), float(half.traction(half.a))
    (0.793701, 0.0)
    """
    mu = checks.positive("the friction", friction)
    compliance = sum((2 - m.nu) / (4 * m.shear_modulus) for m in contact.materials if m is not None)
    modulus, limit = 1 / compliance, mu * contact.force
    most = _slide(limit, contact.a, modulus)
    name, value = checks.one_of(tangential=tangential, shift=shift)
    if value > (limit if name == "tangential" else most) * (1 + 1e-14):
        raise InputError(
            f"The contact slides as a whole: the tangential force can be at most mu P = {limit:g}, reached at a shift "
            f"of {most:g}; found {name}={value:g}.",
            code="slides-as-a-whole",
        )
    if name == "tangential":
        force = min(value, limit)
        c = contact.a * math.cbrt(1 - force / limit)
        moved = -most * math.expm1(2 / 3 * math.log1p(-force / limit)) if force < limit else most
    else:
        moved = min(value, most)
        left = math.sqrt(1 - moved / most)
        c, force = contact.a * left, -limit * math.expm1(1.5 * math.log1p(-moved / most)) if left else limit
    return RoundSlip(contact, mu, force, c, moved, modulus)


#: Radius of stick over that of the contact, below which the rotation is refused as beyond all torque.
MIN_MODULUS = 1e-60


@dataclass(frozen=True)
class TorsionSlip(Frictional[CircularContact]):
    """Circular contact under a constant normal force and a torque about the normal that grew from zero.

    Made by `lubkin`.

    Parameters
    ----------
    contact : CircularContact
        Contact under the normal force.
    friction : float
        Coulomb's mu.
    torque : float
        Torque M about the normal, at most 3 pi mu P a/16.
    c : float
        Radius of stick.
    rotation : float
        Rotation of one body against the other about the normal, in radians.
    shear_modulus : float
        1/(1/G1 + 1/G2).

    References
    ----------
    J. L. Lubkin, J. Appl. Mech. 18 (1951) 183; K. L. Johnson, Contact Mechanics, 1985, section 7.5.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> steel = Material(E=210e3, nu=0.3)
    >>> ball = hertz.spheres(radii=(10.0, np.inf), materials=(steel, steel), force=100.0)
    >>> print(lubkin(ball, friction=0.3, torque=2.0))
    Torsion of a ball with partial slip (Lubkin)
      normal force     P      100
      friction         mu     0.3
      torque           M      2
      greatest torque  Mmax   3.29795
      contact radius   a      0.186626
      stick radius     c      0.141249
      rotation         theta  0.00208967
    """

    torque: float
    c: float
    rotation: float
    shear_modulus: float

    _title = "Torsion of a ball with partial slip (Lubkin)"
    _rows = (
        ("normal force", "P", "force"),
        ("friction", "mu", "friction"),
        ("torque", "M", "torque"),
        ("greatest torque", "Mmax", "greatest_torque"),
        ("contact radius", "a", "a"),
        ("stick radius", "c", "c"),
        ("rotation", "theta", "rotation"),
    )

    @property
    def greatest_torque(self) -> float:
        """3 pi mu P a/16, that of sliding on the whole contact."""
        return _greatest(self.contact, self.friction)

    @property
    def stiffness(self) -> float:
        """Slope dM/d(rotation), that of a disc of the radius of stick, 16 G c^3/3 (Reissner & Sagoci 1944)."""
        return 16 / 3 * self.shear_modulus * self.c**3

    def traction(self, r: ArrayLike) -> Array:
        """Return the traction round the axis, mu p in the annulus of slip, zero outside the contact.

        Parameters
        ----------
        r : array_like
            Distance from the axis, any shape.

        Returns
        -------
        numpy.ndarray
            Traction, shape of `r`.

        Raises
        ------
        InputError
            If a distance is negative or not finite.

        Notes
        -----
        In the circle of stick, with k = c/a, K' and E' of the modulus sqrt(1 - k^2), F and E of the modulus k and
        sin(phi) = sqrt((c^2 - r^2)/(a^2 - r^2))/k: (2/pi) mu p (pi/2 + (K' - E') F(phi, k) - K' E(phi, k)).

        References
        ----------
        Lubkin 1951.
        """
        pressure = self.contact.pressure(r)
        k = self.c / self.a
        if k == 0:
            return np.asarray(self.friction * pressure)
        inside = np.minimum(np.asarray(r, dtype=float), self.c) / self.c
        full, second = float(ellipkm1(k**2)), float(ellipe(1 - k**2))
        sine = np.sqrt((1 - inside) * (1 + inside) / ((1 - k * inside) * (1 + k * inside)))
        phi = np.arcsin(np.minimum(sine, 1.0))
        less = 1 + 2 / np.pi * ((full - second) * ellipkinc(phi, k**2) - full * ellipeinc(phi, k**2))
        return np.asarray(self.friction * pressure * less)


def lubkin(
    contact: CircularContact, friction: float, *, torque: float | None = None, rotation: float | None = None
) -> TorsionSlip:
    """Return the partial slip of a Hertz contact under a torque about its normal.

    Exact for any materials: torsion displaces no point along the normal.

    Parameters
    ----------
    contact : CircularContact
        From `hertz.spheres`.
    friction : float
        Coulomb's mu, positive.
    torque : float, optional
        Torque, positive, at most 3 pi mu P a/16.
    rotation : float, optional
        Rotation of one body against the other; give this or the torque. The full torque takes an infinite one.

    Returns
    -------
    TorsionSlip

    Raises
    ------
    InputError
        If not exactly one of torque and rotation is given, a value is not positive, or the contact would slide as a
        whole.

    Notes
    -----
    As the circle of stick shrinks from t to t - dt, it turns as a bonded disc by d theta, with the torque 16 G t^3/3 d
    theta; the rotation at the radius of stick c is (mu p0/(2 G)) (K' - E').

    References
    ----------
    J. L. Lubkin, J. Appl. Mech. 18 (1951) 183; J. Jaeger, Arch. Appl. Mech. 65 (1995) 478.

    Examples
    --------
    >>> from fecontact.analytic import hertz
    >>> from fecontact.common.material import Material
    >>> ball = hertz.spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=4e-3 / 3)
    >>> slight = lubkin(ball, friction=0.5, torque=1e-9)
    >>> round(slight.torque / slight.rotation / slight.stiffness, 3)
    1.0
    """
    mu = checks.positive("the friction", friction)
    shear = 1 / sum(1 / m.shear_modulus for m in contact.materials if m is not None)
    name, value = checks.one_of(torque=torque, rotation=rotation)
    unit, greatest = mu * contact.p0 / (2 * shear), _greatest(contact, mu)
    if name == "torque":
        if value >= greatest:
            raise InputError(
                f"The contact slides as a whole: the torque must be below 3 pi mu P a/16 = {greatest:g}; found "
                f"{value:g}.",
                code="slides-as-a-whole",
            )
        share = value / greatest
        k = math.exp(brentq(lambda log: _share(math.exp(log)) - share, math.log(MIN_MODULUS), 0.0, xtol=1e-14))
        return TorsionSlip(contact, mu, value, k * contact.a, unit * _turn(k), shear)
    if value >= unit * _turn(MIN_MODULUS):
        raise InputError(
            f"The contact slides as a whole at a rotation of {value:g}: give the rotation at partial slip."
        )
    k = math.exp(brentq(lambda log: _turn(math.exp(log)) - value / unit, math.log(MIN_MODULUS), 0.0, xtol=1e-14))
    return TorsionSlip(contact, mu, greatest * _share(k), k * contact.a, value, shear)


def _greatest(contact: CircularContact, mu: float) -> float:
    return 3 * math.pi / 16 * mu * contact.force * contact.a


def _turn(k: float) -> float:
    """K' - E' of the modulus sqrt(1 - k^2), which vanishes as pi (1 - k^2)/4 near k = 1."""
    m = (1 - k) * (1 + k)
    if m < 1e-3:
        return math.pi * m / 4 * (1 + 3 * m / 8 + 15 * m**2 / 64 + 175 * m**3 / 1024 + 2205 * m**4 / 16384)
    return float(ellipkm1(k**2) - ellipe(m))


def _share(k: float) -> float:
    """Torque over its greatest value: the integral of t^2 E(1 - t^2) from k to 1 over that from 0, 3 pi^2/64."""
    nodes, weights = double_exponential(5)
    t = k + (1 - k) * nodes
    return float((1 - k) * weights @ (t**2 * ellipe((1 - t) * (1 + t))) * 64 / (3 * math.pi**2))
