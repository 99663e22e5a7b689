"""Hertz contact over a line: parallel cylinders under plane strain."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from fecontact.analytic._contact import PlaneContact
from fecontact.analytic._functions import trough_gap
from fecontact.analytic.pair import pair_modulus, poisson_ratio, relative_radius
from fecontact.analytic.stress import SymmetryPlaneStress
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.material import Material


@dataclass(frozen=True)
class LineContact(PlaneContact):
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
