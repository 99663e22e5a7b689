"""Partial slip of spheres in Hertz contact under a tangential force: Cattaneo and Mindlin, cycles by Deresiewicz."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fecontact.analytic import disc
from fecontact.analytic._frictional import Frictional
from fecontact.analytic._functions import arctan_defect
from fecontact.analytic.hertz_circle import CircularContact
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.renamed import renamed


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
                f"{values[np.abs(values) > self.tangential].flat[0]:g}. Give the cycle a larger tangential force."
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
            f"of {most:g}; found {name}={value:g}."
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
