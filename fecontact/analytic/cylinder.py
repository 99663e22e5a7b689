"""Thick cylinder under pressure (Lame) and the shrink fit of two cylinders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic._contact import table
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material

Plane = Literal["stress", "strain"]


@dataclass(frozen=True)
class ThickCylinder:
    """Cylinder a <= r <= b under uniform pressure inside and outside; made by `lame`.

    Parameters
    ----------
    a, b : float
        Inner radius (0 for a solid disc) and outer radius.
    inner_pressure, outer_pressure : float
        Pressure at r = a and r = b, compression positive.
    material : Material
        Material.
    plane : {"stress", "strain"}
        Free ends, or no axial strain.

    References
    ----------
    G. Lame, 1852; S. P. Timoshenko & J. N. Goodier, Theory of Elasticity, 3rd ed. 1970, art. 28.

    Examples
    --------
    >>> print(lame(inner_radius=1.0, outer_radius=2.0, inner_pressure=3.0, material=Material(100.0, 0.25)))
    Thick cylinder, plane stress
      inner radius              a     1
      outer radius              b     2
      inner pressure            p_i   3
      outer pressure            p_o   0
      hoop stress at a                5
      hoop stress at b                2
      radial displacement at a  u(a)  0.0575
      radial displacement at b  u(b)  0.04
    """

    a: float
    b: float
    inner_pressure: float
    outer_pressure: float
    material: Material
    plane: Plane

    def radial(self, r: ArrayLike) -> Array:
        """Return the radial stress.

        Parameters
        ----------
        r : array_like
            Radius, a <= r <= b, any shape.

        Returns
        -------
        numpy.ndarray
            Stress, tension positive, shape of `r`.

        Raises
        ------
        InputError
            If a radius lies outside the cylinder.

        References
        ----------
        Timoshenko & Goodier 1970, hollow cylinder under uniform pressures.

        Examples
        --------
        >>> tube = lame(inner_radius=1.0, outer_radius=2.0, inner_pressure=3.0, material=Material(100.0, 0.25))
        >>> tube.radial([1.0, 2.0])
        array([-3.,  0.])
        """
        radius = self._within(r)
        return np.asarray(0.0 - self.outer_pressure - self._share(radius) * (self.b - radius) * (self.b + radius))

    def hoop(self, r: ArrayLike) -> Array:
        """Return the hoop stress; radii, shape and sign as in `radial`.

        References
        ----------
        Timoshenko & Goodier 1970, hollow cylinder under uniform pressures.

        Examples
        --------
        >>> tube = lame(inner_radius=1.0, outer_radius=2.0, inner_pressure=3.0, material=Material(100.0, 0.25))
        >>> tube.hoop([1.0, 2.0])
        array([5., 2.])
        """
        radius = self._within(r)
        return np.asarray(0.0 - self.outer_pressure + self._share(radius) * (self.b**2 + radius**2))

    def axial(self, r: ArrayLike) -> Array:
        """Return the axial stress, the same at all radii; arguments as in `radial`.

        Zero in plane stress, nu (radial + hoop) in plane strain.

        References
        ----------
        Timoshenko & Goodier 1970, art. 28.

        Examples
        --------
        >>> steel = Material(100.0, 0.25)
        >>> tube = lame(inner_radius=1.0, outer_radius=2.0, inner_pressure=3.0, material=steel, plane="strain")
        >>> tube.axial([1.0, 2.0])
        array([0.5, 0.5])
        """
        total = self.radial(r) + self.hoop(r)
        return np.asarray(self.material.nu * total if self.plane == "strain" else np.zeros_like(total))

    def displacement(self, r: ArrayLike) -> Array:
        """Return the radial displacement, outwards positive; radii and shape as in `radial`.

        References
        ----------
        Timoshenko & Goodier 1970, art. 28; plane strain by E -> E/(1 - nu^2), nu -> nu/(1 - nu).

        Examples
        --------
        >>> disc = lame(inner_radius=0.0, outer_radius=2.0, outer_pressure=8.0, material=Material(100.0, 0.25))
        >>> disc.displacement([0.0, 2.0])
        array([ 0.  , -0.12])
        """
        hoop, radial = self.hoop(r), self.radial(r)
        E, nu = self.material.E, self.material.nu
        if self.plane == "strain":
            E, nu = E / (1 - nu**2), nu / (1 - nu)
        return np.asarray(0.0 + checks.depths("r", r) * (hoop - nu * radial) / E)

    def _share(self, r: Array) -> Array:
        """Return (p_i - p_o) (a/r)^2 / (b^2 - a^2), the term that all fields share; zero for a solid disc."""
        if self.a == 0:
            return np.zeros_like(r)
        difference = self.inner_pressure - self.outer_pressure
        return np.asarray(difference * (self.a / r) ** 2 / ((self.b - self.a) * (self.b + self.a)))

    def _within(self, r: ArrayLike) -> Array:
        radius = checks.depths("r", r)
        if np.any(radius < self.a) or np.any(radius > self.b):
            raise InputError(
                f"Expected radii within the cylinder, {self.a} <= r <= {self.b}; "
                f"found {radius.min()} ... {radius.max()}.",
                code="radius-outside",
            )
        return radius

    def __str__(self) -> str:
        rows = [
            ("inner radius", "a", self.a),
            ("outer radius", "b", self.b),
            ("inner pressure", "p_i", self.inner_pressure),
            ("outer pressure", "p_o", self.outer_pressure),
            ("hoop stress at a", "", float(self.hoop(self.a))),
            ("hoop stress at b", "", float(self.hoop(self.b))),
            ("radial displacement at a", "u(a)", float(self.displacement(self.a))),
            ("radial displacement at b", "u(b)", float(self.displacement(self.b))),
        ]
        return table(f"Thick cylinder, plane {self.plane}", rows)


def lame(
    *,
    inner_radius: float,
    outer_radius: float,
    material: Material,
    inner_pressure: float = 0.0,
    outer_pressure: float = 0.0,
    plane: Plane = "stress",
) -> ThickCylinder:
    """Return the stresses and displacements of a thick cylinder under pressure.

    Parameters
    ----------
    inner_radius, outer_radius : float
        Radii a < b; a = 0 for a solid disc (its inner pressure must then be zero).
    material : Material
        Material.
    inner_pressure, outer_pressure : float
        Pressures, compression positive.
    plane : {"stress", "strain"}
        Free ends, or no axial strain.

    Returns
    -------
    ThickCylinder
        Its methods give the fields.

    Raises
    ------
    InputError
        If the radii are not 0 <= a < b, or the plane is neither "stress" nor "strain".

    References
    ----------
    Timoshenko & Goodier 1970, art. 28.

    Examples
    --------
    >>> tube = lame(inner_radius=1.0, outer_radius=2.0, outer_pressure=3.0, material=Material(100.0, 0.25))
    >>> tube.hoop(1.0)
    array(-8.)
    """
    a, b = checks.finite("the inner radius", inner_radius), checks.positive("the outer radius", outer_radius)
    if not 0 <= a < b:
        raise InputError(f"Expected 0 <= inner_radius < outer_radius; found {inner_radius!r} and {outer_radius!r}.")
    inner, outer = checks.finite("the inner pressure", inner_pressure), checks.finite("the pressure", outer_pressure)
    if a == 0 and inner != 0:
        raise InputError(f"A solid disc has no inner surface: expected inner_pressure = 0; found {inner_pressure!r}.")
    if plane not in ("stress", "strain"):
        raise InputError(f'Expected plane="stress" or plane="strain"; found {plane!r}.', code="unknown-plane")
    return ThickCylinder(a=a, b=b, inner_pressure=inner, outer_pressure=outer, material=material, plane=plane)


@dataclass(frozen=True)
class ShrinkFit:
    """Two cylinders, one forced over the other; made by `shrink_fit`.

    Parameters
    ----------
    pressure : float
        Pressure between them.
    interference : float
        Difference of the radii before assembly.
    inner, outer : ThickCylinder
        The two parts under that pressure.

    References
    ----------
    Timoshenko, Strength of Materials II, 3rd ed. 1956, art. 41.

    Examples
    --------
    >>> steel = Material(200e3, 0.3)
    >>> fit = shrink_fit(radii=(0.0, 1.0, 2.0), materials=(steel, steel), interference=1e-3)
    >>> print(fit)
    Shrink fit, plane stress
      pressure                      p  75
      interference                  d  0.001
      radius of the joint           b  1
      hoop stress, inner part at b     -75
      hoop stress, outer part at b     125
    """

    pressure: float
    interference: float
    inner: ThickCylinder
    outer: ThickCylinder

    def __str__(self) -> str:
        b = self.inner.b
        rows = [
            ("pressure", "p", self.pressure),
            ("interference", "d", self.interference),
            ("radius of the joint", "b", b),
            ("hoop stress, inner part at b", "", float(self.inner.hoop(b))),
            ("hoop stress, outer part at b", "", float(self.outer.hoop(b))),
        ]
        return table(f"Shrink fit, plane {self.inner.plane}", rows)


def shrink_fit(
    *,
    radii: tuple[float, float, float],
    materials: tuple[Material, Material],
    interference: float,
    plane: Plane = "stress",
) -> ShrinkFit:
    """Return the pressure and the fields of a shrink fit.

    Parameters
    ----------
    radii : tuple of (float, float, float)
        a < b < c: inner radius of the inner part (0: solid), joint, outer radius of the outer part.
    materials : tuple of (Material, Material)
        Materials of the inner and the outer part.
    interference : float
        Difference d of the radii at the joint before assembly, positive.
    plane : {"stress", "strain"}
        Free ends, or no axial strain.

    Returns
    -------
    ShrinkFit
        Pressure and the two cylinders under it.

    Raises
    ------
    InputError
        If the radii do not increase or the interference is not positive.

    Notes
    -----
    The pressure is d over the sum of the radial displacements of both parts at the joint under unit pressure; in plane
    stress d/{b [((c^2+b^2)/(c^2-b^2) + nu_o)/E_o + ((b^2+a^2)/(b^2-a^2) - nu_i)/E_i]}.

    References
    ----------
    Timoshenko 1956, art. 41.

    Examples
    --------
    >>> steel = Material(200e3, 0.3)
    >>> fit = shrink_fit(radii=(0.5, 1.0, 2.0), materials=(steel, steel), interference=1e-3, plane="strain")
    >>> round(fit.pressure, 6)
    65.934066
    """
    try:
        a, b, c = radii
        first, second = materials
    except (TypeError, ValueError):
        raise InputError(f"Expected three radii and two materials; found {radii!r} and {materials!r}.") from None
    d = checks.positive("the interference", interference)

    def parts(pressure: float) -> tuple[ThickCylinder, ThickCylinder]:
        inner = lame(inner_radius=a, outer_radius=b, material=first, outer_pressure=pressure, plane=plane)
        outer = lame(inner_radius=b, outer_radius=c, material=second, inner_pressure=pressure, plane=plane)
        return inner, outer

    inner, outer = parts(1.0)
    p = d / float(outer.displacement(b) - inner.displacement(b))
    inner, outer = parts(p)
    return ShrinkFit(pressure=p, interference=d, inner=inner, outer=outer)
