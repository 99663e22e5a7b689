"""Hertz contact: over a circle, an ellipse or a line.

Hertz contact over a circle: spheres, a sphere in a seat, a sphere on a plane.

Hertz contact over a line: parallel cylinders under plane strain.

Hertz contact over an ellipse: any principal curvatures, any angle between the bodies' axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar
from scipy.special import elliprd, elliprf

from fecontact.analytic import disc
from fecontact.analytic._contact import (
    AxisymmetricStress,
    PlaneContact,
    Plotted,
    RoundIndentation,
    SymmetryPlaneStress,
    Tabulated,
    contact_modulus,
    pair_modulus,
    poisson_ratio,
    relative_radius,
)
from fecontact.analytic._functions import arctan_defect, trough_gap
from fecontact.common import checks
from fecontact.common.arguments import spelled
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

__all__ = [
    "CircularContact",
    "EllipticalContact",
    "LineContact",
    "contact_modulus",
    "ellipse",
    "line",
    "spheres",
]


@dataclass(frozen=True)
class CircularContact(Plotted, RoundIndentation):
    """Frictionless contact of two spherical surfaces under Hertz's assumptions; made by `spheres`.

    Parameters
    ----------
    force : float
        Load P.
    approach : float
        Distance delta by which points far from the contact come together, a^2 / R.
    a : float
        Radius of the contact circle, (3 P R / (4 E*))^(1/3).
    p0 : float
        Pressure at the centre, 3 P / (2 pi a^2).
    R : float
        Relative radius, 1/R = 1/R1 + 1/R2.
    E_star : float
        Contact modulus.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.

    References
    ----------
    H. Hertz, J. reine angew. Math. 92 (1882) 156; K. L. Johnson, Contact Mechanics, 1985, section 4.2.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> print(spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0))
    Hertz contact over a circle
      force             P      7124
      approach          delta  0.0257902
      contact radius    a      1.79549
      maximum pressure  p0     1055.12
      mean pressure     pm     703.411
      stiffness         dP/dd  414343
      relative radius   R      125
      contact modulus   E*     115385
    >>> contact = spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), approach=0.01)
    >>> contact.pressure([0.0, 0.06, 1.0]) / contact.p0
    array([1. , 0.8, 0. ])
    >>> contact.displacement([0.0, 0.1])
    array([0.01 , 0.005])
    """

    force: float
    approach: float
    a: float
    p0: float
    R: float
    E_star: float
    materials: tuple[Material | None, Material | None]

    _title = "Hertz contact over a circle"
    _rows = ("force", "approach", "a", "p0", "mean_pressure", "stiffness", "R", "E_star")

    def _pressure(self, r: Array) -> Array:
        """p0 sqrt(1 - r^2/a^2); Johnson 1985, chapter 3."""
        return disc.hertz_pressure(r, a=self.a, p0=self.p0)

    def _displacement(self, r: Array) -> Array:
        """`approach` at the centre; Johnson 1985, chapter 3."""
        return disc.hertz_displacement(r, a=self.a, p0=self.p0, modulus=self.E_star)

    def gap(self, r: ArrayLike) -> Array:
        """Return the distance of the deformed surfaces, zero inside the contact; distances as in `pressure`.

        Notes
        -----
        r^2/(2R) - approach + displacement, evaluated without the cancellation near the edge.

        References
        ----------
        Johnson 1985, chapters 3 and 4.

        Examples
        --------
        >>> contact = spheres(radii=(1.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), approach=0.01)
        >>> contact.gap([0.0, 0.1, 0.2]).round(8)
        array([0.        , 0.        , 0.01217996])
        """
        xi = checks.depths("r", r) / self.a
        s = np.sqrt(np.maximum((xi - 1) * (xi + 1), 0.0))
        return np.asarray(self.a * (self.a / self.R) / np.pi * (s * arctan_defect(s) + s**2 * np.arctan(s)))

    def stress(self, r: ArrayLike, z: ArrayLike, body: int = 0) -> AxisymmetricStress:
        """Return the stress at points below the surface of one body.

        Parameters
        ----------
        r, z : array_like
            Distance from the axis and depth below the surface, broadcast together.
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        AxisymmetricStress
            Stress components, tension positive, each of the broadcast shape.

        Raises
        ------
        InputError
            If a coordinate is negative or not finite, or the body is rigid.

        References
        ----------
        M. T. Huber, Ann. Physik 14 (1904) 153.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
        >>> (contact.stress(0.0, [0.0, contact.a]).zz / contact.p0).round(3)
        array([-1. , -0.5])
        """
        return disc.hertz_stress(r, z, a=self.a, p0=self.p0, nu=poisson_ratio(self.materials, body))

    def stress_on_axis(self, z: ArrayLike, body: int = 0) -> AxisymmetricStress:
        """Return the stress at depths z below the centre of the contact: `stress` at r = 0, where rr = tt.

        References
        ----------
        Johnson 1985, chapter 3.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
        >>> (contact.stress_on_axis([0.0, contact.a]).rr / contact.p0).round(3)
        array([-0.8  , -0.029])
        """
        return self.stress(0.0, z, body)

    def max_shear(self, body: int = 0) -> tuple[float, float]:
        """Return the largest shear stress on the axis and its depth.

        Parameters
        ----------
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        tuple of (float, float)
            Shear stress and depth; about 0.31 p0 and 0.48 a for nu = 0.3.

        Raises
        ------
        InputError
            If the body is rigid.

        References
        ----------
        Johnson 1985, section 4.2.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
        >>> tau, depth = contact.max_shear()
        >>> round(tau / contact.p0, 4), round(depth / contact.a, 4)
        (0.31, 0.4809)
        """
        nu = poisson_ratio(self.materials, body)

        def slope(zeta: float) -> float:
            shape = math.atan2(1.0, zeta) - zeta / (1 + zeta**2)
            return (1 + nu) * shape - 3 * zeta / (1 + zeta**2) ** 2

        # The slope is positive at the surface (any nu > -1) and negative at zeta = 1 (nu < 0.5): one root between.
        depth = self.a * brentq(slope, 0.0, 1.0, xtol=1e-15)
        return float(self.stress_on_axis(depth, body).max_shear), depth


@spelled
def spheres(
    radii: tuple[float, float],
    materials: tuple[Material | None, Material | None],
    *,
    force: float | None = None,
    approach: float | None = None,
) -> CircularContact:
    """Return the Hertz contact of two spheres.

    Parameters
    ----------
    radii : tuple of (float, float)
        Radii R1, R2; negative for a concave surface (a seat), `inf` for a plane.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.
    force : float, optional
        Load P, positive.
    approach : float, optional
        Approach delta, positive; give this or the force.

    Returns
    -------
    CircularContact
        Radius, pressure and approach; its methods give the fields.

    Raises
    ------
    InputError
        If the surfaces do not meet at one point (1/R1 + 1/R2 <= 0), both bodies are rigid, or not exactly one of
        force and approach is given and positive.

    Notes
    -----
    Valid while a is small compared with R1 and R2; a closely fitting seat leaves this range at small loads.

    References
    ----------
    Johnson 1985, chapter 4.

    Examples
    --------
    >>> rubber = Material(E=2.0, nu=0.49)
    >>> round(spheres(radii=(10.0, np.inf), materials=(rubber, None), force=1.0).a, 4)
    1.4177
    >>> round(spheres(radii=(10.0, -11.0), materials=(rubber, None), force=1.0).a, 4)
    3.153
    """
    R = relative_radius(radii)
    E_star = pair_modulus(materials)
    name, value = checks.one_of(force=force, approach=approach)
    if name == "force":
        load, a = value, math.cbrt(3 * value * R / (4 * E_star))
        delta = a * (a / R)
    else:
        delta, a = value, math.sqrt(R * value)
        load = 4 * E_star * a * delta / 3
    p0 = 2 * E_star * a / (np.pi * R)
    return CircularContact(force=load, approach=delta, a=a, p0=p0, R=R, E_star=E_star, materials=materials)


@dataclass(frozen=True)
class LineContact(Plotted, PlaneContact):
    """Frictionless contact of parallel cylinders under plane strain; made by `line`.

    There is no approach: the displacement of a half-plane grows as the logarithm of the distance, so the approach
    depends on the shape of the whole body.

    Parameters
    ----------
    force : float
        Load per length P'.
    a : float
        Half-width of the contact, (4 P' R / (pi E*))^(1/2).
    p0 : float
        Pressure on the centre line, 2 P' / (pi a).
    R : float
        Relative radius, 1/R = 1/R1 + 1/R2.
    E_star : float
        Contact modulus.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 4.2(c).

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> print(line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0))
    Hertz contact over a line
      force per length  P'  1000
      half-width        a   0.332186
      maximum pressure  p0  1916.46
      mean pressure     pm  1505.18
      relative radius   R   10
      contact modulus   E*  115385
    >>> contact = line(radii=(10.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=np.pi / 40)
    >>> contact.pressure([-0.6 * contact.a, 0.0]) / contact.p0
    array([0.8, 1. ])
    >>> contact.gap([0.0, 1.0, 2.0]).round(6)
    array([0.      , 0.      , 0.107357])
    """

    force: float
    a: float
    p0: float
    R: float
    E_star: float
    materials: tuple[Material | None, Material | None]

    _title = "Hertz contact over a line"
    _rows = (("force per length", "P'", "force"), ("half-width", "a", "a"), "p0", "mean_pressure", "R", "E_star")

    @property
    def mean_pressure(self) -> float:
        """P' / (2 a), pi/4 times the maximum."""
        return self.p0 * math.pi / 4

    def _pressure(self, x: Array) -> Array:
        """p0 sqrt(1 - x^2/a^2); Johnson 1985, chapter 4."""
        xi = np.abs(x) / self.a
        return np.asarray(self.p0 * np.sqrt(np.maximum((1 - xi) * (1 + xi), 0.0)))

    def displacement(self, x: ArrayLike) -> Array:
        """Return the normal surface displacement of both bodies together; coordinates as in `pressure`.

        Returns
        -------
        numpy.ndarray
            Displacement into the bodies less that at x = 0, hence negative; shape of `x`.

        References
        ----------
        Johnson 1985, section 2.7, integrated outside the contact.

        Examples
        --------
        >>> contact = line(radii=(10.0, np.inf), materials=(None, Material(E=1.0, nu=0.0)), force=np.pi / 40)
        >>> contact.displacement([0.0, 1.0, 2.0]).round(6)
        array([ 0.      , -0.05    , -0.092643])
        """
        xi = np.abs(checks.coordinates("x", x)) / self.a
        beyond = np.maximum(xi, 1.0)
        root = np.sqrt((beyond - 1) * (beyond + 1))
        shape = np.minimum(xi, 1.0) ** 2 * np.where(xi <= 1, 1.0, beyond / (beyond + root) + np.arccosh(beyond))
        return np.asarray(0.0 - self.a * (self.a / self.R) / 2 * shape)

    def _gap(self, x: Array) -> Array:
        """The parabola of radius R less the displacement; Johnson 1985, section 4.2(c)."""
        return np.asarray(self.a * (self.a / self.R) / 2 * trough_gap(np.abs(x) / self.a))

    def stress(self, x: ArrayLike, z: ArrayLike, body: int = 0) -> SymmetryPlaneStress:
        """Return the stress at points below the surface of one body.

        Parameters
        ----------
        x, z : array_like
            Distance from the centre line (any sign) and depth below the surface, broadcast together.
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        SymmetryPlaneStress
            Stress components, tension positive, each of the broadcast shape; yy from plane strain.

        Raises
        ------
        InputError
            If a coordinate is not finite, a depth negative, or the body rigid.

        Notes
        -----
        McEwen's m and n are the parts of sqrt(a^2 - (x + iz)^2) = m - i n. Here m - z, in which all stresses are of the
        same order far away, is taken from a^2 / (m + z - i(n + x)) = (m - z) - i(n - x), which avoids the subtraction.

        References
        ----------
        E. McEwen, Phil. Mag. 40 (1949) 454; Johnson 1985, chapter 4.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
        >>> (contact.stress(0.0, [0.0, contact.a]).zz / contact.p0).round(4)
        array([-1.    , -0.7071])
        """
        nu = poisson_ratio(self.materials, body)
        xi, zeta = np.broadcast_arrays(
            checks.coordinates("x", x) / self.a,
            checks.depths("z", z) / self.a,
        )
        root = np.sqrt((1 - xi - 1j * zeta) * (1 + xi + 1j * zeta))
        m, n = np.abs(root.real), np.abs(root.imag)  # both for |x|; the sign of x enters with the shear
        excess = (1 / (m + zeta - 1j * (n + np.abs(xi)))).real  # m - z
        size = m**2 + n**2
        inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0)  # at the edge itself all stresses are 0
        total = -2 * self.p0 * excess
        difference = 2 * self.p0 * excess * (n**2 - m * zeta) * inverse
        shear = -self.p0 * np.sign(xi) * n * excess * (m + zeta) * inverse
        return SymmetryPlaneStress(
            xx=(total - difference) / 2, yy=nu * total, zz=(total + difference) / 2, xz=np.asarray(shear)
        )

    def stress_on_axis(self, z: ArrayLike, body: int = 0) -> SymmetryPlaneStress:
        """Return the stress at depths z below the centre line: `stress` at x = 0, of the shape of `z`.

        References
        ----------
        Johnson 1985, chapter 4.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
        >>> (contact.stress_on_axis(contact.a).xx / contact.p0).round(4)
        np.float64(-0.1213)
        """
        return self.stress(0.0, z, body)

    def max_shear(self) -> tuple[float, float]:
        """Return the largest shear stress in the planes normal to the line, and its depth.

        Returns
        -------
        tuple of (float, float)
            Shear stress 0.3003 p0 and depth 0.7862 a, for all materials.

        References
        ----------
        Johnson 1985, chapter 4.

        Examples
        --------
        >>> steel = Material(E=210e3, nu=0.3)
        >>> contact = line(radii=(10.0, np.inf), materials=(steel, steel), force=1000.0)
        >>> tau, depth = contact.max_shear()
        >>> round(tau / contact.p0, 4), round(depth / contact.a, 4)
        (0.3003, 0.7862)
        """
        # tau = p0 (z - z^2 / sqrt(1 + z^2)) on the axis, in units of a.
        depth = brentq(lambda z: 1 - z * (2 + z**2) / (1 + z**2) ** 1.5, 0.0, 2.0, xtol=1e-15)
        return self.p0 * depth * (1 - depth / math.hypot(1, depth)), depth * self.a


@spelled
def line(
    radii: tuple[float, float], materials: tuple[Material | None, Material | None], *, force: float
) -> LineContact:
    """Return the Hertz contact of two parallel cylinders.

    Parameters
    ----------
    radii : tuple of (float, float)
        Radii R1, R2; negative for a concave surface, `inf` for a plane.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.
    force : float
        Load per length, positive.

    Returns
    -------
    LineContact
        Half-width and pressure; its methods give the fields.

    Raises
    ------
    InputError
        If the surfaces do not meet along one line (1/R1 + 1/R2 <= 0), both bodies are rigid, or the force is not
        positive.

    References
    ----------
    Johnson 1985, chapter 4.

    Examples
    --------
    >>> rubber = Material(E=2.0, nu=0.49)
    >>> round(line(radii=(10.0, np.inf), materials=(rubber, None), force=1.0).a, 4)
    2.1995
    """
    R = relative_radius(radii)
    E_star = pair_modulus(materials)
    load = checks.positive("the force per length", force)
    a = math.sqrt(4 * load * R / (math.pi * E_star))
    return LineContact(force=load, a=a, p0=2 * load / (math.pi * a), R=R, E_star=E_star, materials=materials)


@dataclass(frozen=True)
class EllipticalContact(Tabulated):
    """Frictionless contact of two smooth surfaces under Hertz's assumptions; made by `ellipse`.

    The x axis lies along the longer semi-axis a of the contact, the direction in which the gap A x^2 + B y^2 grows
    slowest.

    Parameters
    ----------
    force : float
        Load P.
    approach : float
        Distance delta by which points far from the contact come together.
    a, b : float
        Longer and shorter semi-axis of the contact ellipse.
    p0 : float
        Pressure at the centre, 3 P / (2 pi a b).
    A, B : float
        Coefficients of the undeformed gap A x^2 + B y^2, A <= B (1 / length).
    angle : float
        Angle in radians from the first axis of body 1 to the x axis, in (-pi/2, pi/2].
    E_star : float
        Contact modulus.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.

    References
    ----------
    H. Hertz, J. reine angew. Math. 92 (1882) 156; K. L. Johnson, Contact Mechanics, 1985, section 4.1-4.2.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> print(ellipse(radii=((20.0, 10.0), (np.inf, np.inf)), materials=(steel, steel), force=1000.0))
    Hertz contact over an ellipse
      force              P      1000
      approach           delta  0.0143073
      longer semi-axis   a      0.564599
      shorter semi-axis  b      0.356034
      maximum pressure   p0     2375.25
      mean pressure      pm     1583.5
      stiffness          dP/dd  104841
      gap along x        A      0.025
      gap along y        B      0.05
      angle of x (rad)   angle  0
      contact modulus    E*     115385
    """

    force: float
    approach: float
    a: float
    b: float
    p0: float
    A: float
    B: float
    angle: float
    E_star: float
    materials: tuple[Material | None, Material | None]

    _title = "Hertz contact over an ellipse"
    _rows = (
        "force",
        "approach",
        ("longer semi-axis", "a", "a"),
        ("shorter semi-axis", "b", "b"),
        "p0",
        "mean_pressure",
        "stiffness",
        ("gap along x", "A", "A"),
        ("gap along y", "B", "B"),
        ("angle of x (rad)", "angle", "angle"),
        "E_star",
    )

    @property
    def mean_pressure(self) -> float:
        """P / (pi a b), two thirds of the maximum."""
        return 2 * self.p0 / 3

    @property
    def stiffness(self) -> float:
        """Slope dP/d(delta) = 3 P / (2 delta)."""
        return 1.5 * self.force / self.approach

    def pressure(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Return the pressure p0 sqrt(1 - x^2/a^2 - y^2/b^2), zero outside the contact.

        Parameters
        ----------
        x, y : array_like
            Coordinates along the longer and the shorter semi-axis, broadcast together.

        Returns
        -------
        numpy.ndarray
            Pressure, compression positive, of the broadcast shape.

        Raises
        ------
        InputError
            If a coordinate is not finite.

        References
        ----------
        Johnson 1985, chapter 3.

        Examples
        --------
        >>> ball = ellipse(radii=((20.0, 10.0), (np.inf, np.inf)), materials=(Material(1.0, 0.0), None), force=1.0)
        >>> ball.pressure([0.0, 0.6 * ball.a], 0.0) / ball.p0
        array([1. , 0.8])
        """
        xi = checks.coordinates("x", x) / self.a
        eta = checks.coordinates("y", y) / self.b
        return np.asarray(self.p0 * np.sqrt(np.maximum((1 - xi) * (1 + xi) - eta**2, 0.0)))

    def displacement(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Return the normal surface displacement of both bodies together; coordinates as in `pressure`.

        Returns
        -------
        numpy.ndarray
            Displacement into the bodies, of the broadcast shape; `approach` at the centre.

        Notes
        -----
        The potential of the ellipse, an integral over the confocal coordinate from 0 inside or from that of the point
        outside, is evaluated by Carlson's symmetric integrals R_F and R_D.

        References
        ----------
        Johnson 1985, chapter 3; B. C. Carlson, Numer. Math. 33 (1979) 1.

        Examples
        --------
        >>> ball = ellipse(radii=((20.0, 10.0), (np.inf, np.inf)), materials=(Material(1.0, 0.0), None), force=1.0)
        >>> bool(abs(ball.displacement(0.0, 0.0) - ball.approach) < 1e-14 * ball.approach)
        True
        """
        xi, eta = np.broadcast_arrays(checks.coordinates("x", x) / self.a, checks.coordinates("y", y) / self.a)
        square = (self.b / self.a) ** 2
        confocal = _confocal(xi, eta, square)
        wide, narrow = 1 + confocal, square + confocal
        shape = (
            elliprf(confocal, narrow, wide)
            - xi**2 * elliprd(confocal, narrow, wide) / 3
            - eta**2 * elliprd(confocal, wide, narrow) / 3
        )
        return np.asarray(3 * self.force / (2 * np.pi * self.E_star * self.a) * shape)

    def stress_on_axis(self, z: ArrayLike, body: int = 0) -> SymmetryPlaneStress:
        """Return the stress at depths z below the centre of the contact.

        Parameters
        ----------
        z : array_like
            Depth, any shape.
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        SymmetryPlaneStress
            Principal stresses xx, yy, zz (and xz = 0), tension positive, shape of `z`.

        Raises
        ------
        InputError
            If a depth is negative or not finite, or the body is rigid.

        Notes
        -----
        The textbook formulas divide by the squared eccentricity. In Carlson's R_D it drops out, so that nearly circular
        ellipses are accurate.

        References
        ----------
        H. R. Thomas & V. A. Hoersch, Univ. Illinois Eng. Exp. Stn. Bull. 212, 1930; Johnson 1985, chapter 3.

        Examples
        --------
        >>> ball = ellipse(radii=((20.0, 10.0), (np.inf, np.inf)), materials=(Material(1.0, 0.3), None), force=1.0)
        >>> round(float(ball.stress_on_axis(0.0).zz / ball.p0), 12)
        -1.0
        """
        nu = poisson_ratio(self.materials, body)
        zeta = checks.depths("z", z) / self.a
        k = self.b / self.a
        wide, narrow = 1 + zeta**2, k**2 + zeta**2
        T = np.sqrt(narrow / wide)
        along = 2 * k / 3 * zeta * elliprd(zeta**2, narrow, wide)
        across = 2 * k / 3 * zeta * elliprd(zeta**2, wide, narrow)
        spread = k / (wide * (1 + T))
        return SymmetryPlaneStress(
            xx=np.asarray(self.p0 * (along - spread + nu * (across - 2 * spread / T))),
            yy=np.asarray(self.p0 * (across - spread / T + nu * (along - 2 * spread))),
            zz=np.asarray(-self.p0 * k / (wide * T)),
            xz=np.zeros_like(zeta),
        )

    def max_shear(self, body: int = 0) -> tuple[float, float]:
        """Return the largest shear stress on the axis and its depth.

        Parameters
        ----------
        body : int
            0 for the first body, 1 for the second.

        Returns
        -------
        tuple of (float, float)
            Shear stress (relative error 1e-12) and depth (relative error 1e-6, as the maximum is flat).

        Raises
        ------
        InputError
            If the body is rigid.

        References
        ----------
        Johnson 1985, table 4.1.

        Examples
        --------
        >>> ball = ellipse(radii=((20.0, 10.0), (np.inf, np.inf)), materials=(Material(1.0, 0.3), None), force=1.0)
        >>> tau, depth = ball.max_shear()
        >>> round(tau / ball.p0, 3), round(depth / ball.b, 3)
        (0.321, 0.586)
        """
        # The depth lies between 0 (nu = -1) and 0.79 b (line contact): a coarse scan brackets it, a search refines it.
        grid = np.linspace(0, self.b, 65)
        best = int(np.argmax(self.stress_on_axis(grid, body).max_shear))
        found = minimize_scalar(
            lambda depth: -float(self.stress_on_axis(depth, body).max_shear),
            bounds=(grid[max(best - 1, 0)], grid[min(best + 1, 64)]),
            method="bounded",
            options={"xatol": 1e-9 * self.b},
        )
        return -float(found.fun), float(found.x)


@spelled
def ellipse(
    radii: tuple[tuple[float, float], tuple[float, float]],
    materials: tuple[Material | None, Material | None],
    *,
    angle: float = 0.0,
    force: float | None = None,
    approach: float | None = None,
) -> EllipticalContact:
    """Return the Hertz contact of two smooth surfaces of any principal curvatures.

    Parameters
    ----------
    radii : tuple of two tuples of (float, float)
        Principal radii ((R1x, R1y), (R2x, R2y)) of the two bodies, each in its own principal axes: Rx is the radius of
        the section that contains the body's first axis. Negative: concave; `inf`: straight.
    materials : tuple of (Material or None)
        Materials of the two bodies, None for a rigid one.
    angle : float
        Angle in radians from the first axis of body 1 to the first axis of body 2.
    force : float, optional
        Load P, positive.
    approach : float, optional
        Approach delta, positive; give this or the force.

    Returns
    -------
    EllipticalContact
        Semi-axes, pressure and approach; its methods give the fields.

    Raises
    ------
    InputError
        If the surfaces do not meet at one point (A <= 0), both bodies are rigid, or not exactly one of force and
        approach is given and positive.

    Notes
    -----
    Hertz's condition (E/k^2 - K)/(K - E) = B/A becomes R_D(0, 1, k^2)/R_D(0, k^2, 1) = B/A in Carlson's integrals; the
    factor e^2, which vanishes for a circle, drops out. It is solved for log k.

    References
    ----------
    Johnson 1985, chapter 4; B. C. Carlson, Numer. Math. 33 (1979) 1.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> crossed = ellipse(
    ...     radii=((np.inf, 10.0), (np.inf, 10.0)), angle=np.pi / 2, materials=(steel, steel), force=100.0
    ... )
    >>> round(crossed.a, 6), round(crossed.b, 6)
    (0.186626, 0.186626)
    """
    A, B, direction = _gap_coefficients(radii, checks.finite("the angle", angle))
    E_star = pair_modulus(materials)
    name, value = checks.one_of(force=force, approach=approach)
    k = _axis_ratio(B / A)
    # a^3 = P R_D / (2 pi E* A) and delta = 3 P R_F / (2 pi E* a), in which R_F is K(e).
    second, first = float(elliprd(0.0, k**2, 1.0)), float(elliprf(0.0, k**2, 1.0))
    if name == "force":
        load, a = value, math.cbrt(value * second / (2 * math.pi * E_star * A))
        delta = 3 * load * first / (2 * math.pi * E_star * a)
    else:
        delta, a = value, math.sqrt(value * second / (3 * A * first))
        load = 2 * math.pi * E_star * a * delta / (3 * first)
    b = k * a
    return EllipticalContact(
        force=load,
        approach=delta,
        a=a,
        b=b,
        p0=3 * load / (2 * math.pi * a * b),
        A=A,
        B=B,
        angle=direction,
        E_star=E_star,
        materials=materials,
    )


def _gap_coefficients(
    radii: tuple[tuple[float, float], tuple[float, float]], angle: float
) -> tuple[float, float, float]:
    """Return A <= B of the gap A x^2 + B y^2 and the angle of its x axis from the first axis of body 1."""
    try:
        (r1x, r1y), (r2x, r2y) = radii
        k1x, k1y, k2x, k2y = (1 / float(radius) for radius in (r1x, r1y, r2x, r2y))
    except (TypeError, ValueError, ZeroDivisionError):
        raise InputError(
            f"Expected radii=((R1x, R1y), (R2x, R2y)), none zero (inf: straight, negative: concave); found {radii!r}.",
            code="radii",
        ) from None
    c, s = math.cos(angle), math.sin(angle)
    turned_x, turned_y, mixed = k2x * c * c + k2y * s * s, k2x * s * s + k2y * c * c, (k2x - k2y) * s * c
    mean = (k1x + k1y + k2x + k2y) / 4
    half_x, half_xy = (k1x - k1y + turned_x - turned_y) / 4, mixed / 2
    B = mean + math.hypot(half_x, half_xy)
    # The determinant of the sum of two quadratic forms: all terms positive for convex bodies, so that A stays accurate
    # where it is much smaller than B (cylinders crossed at a small angle).
    determinant = (k1x * k1y + k2x * k2y + k1y * turned_x + k1x * turned_y) / 4
    A = determinant / B if B > 0 else -math.inf
    if not (0 < A < math.inf):
        raise InputError(
            f"Expected surfaces that touch at one point and open in every direction; found radii {radii!r} with "
            f"angle {angle}. Straight parallel generators need line(); a concave radius must exceed its counterpart.",
            code="no-point-contact",
        )
    A = min(A, B)  # equal curvatures: rounding may place A above B
    # Written as differences from zero: a negative zero would turn the axes by pi.
    return A, B, math.atan2(0.0 - half_xy, 0.0 - half_x) / 2


def _axis_ratio(ratio: float) -> float:
    """Return b/a that belongs to B/A >= 1."""
    if ratio == 1:
        return 1.0

    def defect(log_k: float) -> float:
        square = math.exp(2 * log_k)
        return math.log(elliprd(0.0, 1.0, square) / elliprd(0.0, square, 1.0) / ratio)

    # k lies between (A/B)^1 and (A/B)^(1/2); the ends are widened for rounding at k close to 1.
    return math.exp(brentq(defect, -math.log(ratio) - 1e-15, 0.0, xtol=1e-16, rtol=1e-15))


def _confocal(xi: Array, eta: Array, square: float) -> Array:
    """Return the largest root of xi^2/(1 + w) + eta^2/(k^2 + w) = 1, zero inside the ellipse; `square` is k^2."""
    # w^2 - trace w - product = 0, with the roots' product negative exactly outside the ellipse.
    trace = xi**2 + eta**2 - 1 - square
    product = (xi - 1) * (xi + 1) * square + eta**2
    root = np.hypot(xi**2 - eta**2 - (1 - square), 2 * xi * eta)
    larger = (root + np.abs(trace)) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.where(trace >= 0, larger, np.where(larger > 0, product / larger, 0.0))
    return np.where(product > 0, w, 0.0)
