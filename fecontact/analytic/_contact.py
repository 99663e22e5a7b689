"""What closed forms of contact have in common: pairs of bodies, their fields by name, a table of their quantities.

Contact modulus and relative radius of a pair; stress fields, tension positive, with maximum shear and von Mises stress.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common import checks
from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, check_magnitude
from fecontact.common.errors import InputError, shown
from fecontact.common.files import new_figure, save_figure
from fecontact.common.html import cell
from fecontact.common.material import Material
from fecontact.common.units import UnitNames, Units

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def table(title: str, rows: Sequence[tuple[str, str, float]]) -> str:
    """Return a title and one aligned line for each (quantity, symbol, value).

    Examples
    --------
    >>> print(table("Flat punch", [("contact radius", "a", 2.0), ("force", "P", 10.0)]))
    Flat punch
      contact radius  a  2
      force           P  10
    """
    wide = max(len(row[0]) for row in rows)
    narrow = max(len(row[1]) for row in rows)
    return "\n".join([title, *(f"  {name:<{wide}}  {symbol:<{narrow}}  {value:.6g}" for name, symbol, value in rows)])


#: Quantity and symbol of attributes.
USUAL = {
    "force": ("force", "P"),
    "approach": ("approach", "delta"),
    "a": ("contact radius", "a"),
    "p0": ("maximum pressure", "p0"),
    "mean_pressure": ("mean pressure", "pm"),
    "stiffness": ("stiffness", "dP/dd"),
    "R": ("relative radius", "R"),
    "E_star": ("contact modulus", "E*"),
}


class Tabulated:
    """Prints itself as a table of its quantities: `_rows` are attributes, or (quantity, symbol, attribute)."""

    _title: ClassVar[str]
    _rows: ClassVar[tuple[str | tuple[str, str, str], ...]]

    def __str__(self) -> str:
        named = [(*USUAL[row], row) if isinstance(row, str) else row for row in self._rows]
        return table(self._title.format(self), [(name, symbol, getattr(self, key)) for name, symbol, key in named])


class Plotted(Tabulated):
    """A contact of half-width or radius `a` with a picture: pressure and gap over the distance from its middle."""

    if TYPE_CHECKING:
        a: float
        pressure: Any
        gap: Any

    def plot(self, path: str | Path | None = None, *, units: UnitNames = (), ax: Axes | None = None) -> Figure:
        """Draw pressure, and the gap beside the contact, over the distance from its middle or its axis.

        Parameters
        ----------
        path : str or Path, optional
            File to write; the suffix decides the format.
        units : (length, force) or (length, force, stress), or str
            Names for labels; a text is that of the pressure.
        ax : matplotlib Axes, optional
            Where to draw the pressure alone.

        Raises
        ------
        InputError
            If the file cannot be written, or a name is no text.

        Examples
        --------
        >>> import fecontact as fc
        >>> steel = fc.Material(E=210e3, nu=0.3)
        >>> figure = fc.hertz.spheres(radii=(10.0, 10.0), materials=(steel, steel), force=100.0).plot()
        >>> [axes.get_ylabel() for axes in figure.axes]
        ['pressure', 'gap']
        """
        names, x = Units.labels(units), np.linspace(-2.0 * self.a, 2.0 * self.a, 401)
        if ax is None:
            upper, lower = new_figure((6.4, 5.6)).subplots(2, 1, sharex=True)
        else:
            upper = lower = ax
        upper.plot(x, self.pressure(np.abs(x)), color="tab:red")
        upper.set_ylabel(names.axis_label("pressure", "stress"))
        upper.set_title(str(self).splitlines()[0], fontsize="medium")
        if ax is None:
            lower.plot(x, self.gap(np.abs(x)), color="tab:blue")
            lower.set_ylabel(names.axis_label("gap", "length"))
        lower.set_xlabel(names.axis_label("distance", "length"))
        for axes in (upper, lower):
            axes.grid(color="0.9")
        return save_figure(upper.figure, path)

    def _repr_html_(self) -> str:
        return cell(self, self.plot)


class RoundContact(Tabulated, ABC):
    """Contact over a circle of radius `a` under a load `force`."""

    force: float
    a: float

    @property
    def mean_pressure(self) -> float:
        """P / (pi a^2)."""
        return self.force / (math.pi * self.a**2)

    def pressure(self, r: ArrayLike) -> Array:
        """Return the pressure, zero outside the contact.

        Parameters
        ----------
        r : array_like
            Distance from the axis, any shape.

        Returns
        -------
        numpy.ndarray
            Pressure, compression positive, shape of `r`.

        Raises
        ------
        InputError
            If a distance is negative or not finite.
        """
        return self._pressure(checks.depths("r", r))

    @abstractmethod
    def _pressure(self, r: Array) -> Array:
        """Pressure at checked distances, with its source."""


class RoundIndentation(RoundContact):
    """The same on a half-space of contact modulus `E_star`."""

    E_star: float

    @property
    def stiffness(self) -> float:
        """Slope dP/d(delta) = 2 E* a, for every profile (Sneddon 1965)."""
        return 2 * self.E_star * self.a

    def displacement(self, r: ArrayLike) -> Array:
        """Return the normal surface displacement, of both bodies together, inside and outside the contact.

        Parameters
        ----------
        r : array_like
            Distance from the axis, any shape.

        Returns
        -------
        numpy.ndarray
            Displacement into the bodies, shape of `r`; P/(pi E* r) far away.

        Raises
        ------
        InputError
            If a distance is negative or not finite.
        """
        return self._displacement(checks.depths("r", r))

    @abstractmethod
    def _displacement(self, r: Array) -> Array:
        """Displacement at checked distances, with its source."""


class PlaneContact(Tabulated, ABC):
    """Contact along lines, plane strain."""

    def pressure(self, x: ArrayLike) -> Array:
        """Return the pressure, zero outside the contact.

        Parameters
        ----------
        x : array_like
            Coordinate across the line of contact, from its centre, any sign and shape.

        Returns
        -------
        numpy.ndarray
            Pressure, compression positive, shape of `x`.

        Raises
        ------
        InputError
            If a coordinate is not finite.
        """
        return self._pressure(checks.coordinates("x", x))

    def gap(self, x: ArrayLike) -> Array:
        """Return the distance of the deformed surfaces, zero in the contact; coordinates as in `pressure`."""
        return self._gap(checks.coordinates("x", x))

    @abstractmethod
    def _pressure(self, x: Array) -> Array:
        """Pressure at checked coordinates, with its source."""

    @abstractmethod
    def _gap(self, x: Array) -> Array:
        """Gap at checked coordinates, with its source."""


class _InSymmetryPlane:
    """Components at points of a plane of symmetry: the first in it, that across it, the second in it, the shear."""

    @property
    def max_shear(self) -> Array:
        """Largest shear stress at each point, over all planes."""
        first, third, second, shear = self._components
        radius = np.hypot((first - second) / 2, shear)
        # Distance of the third principal stress from the centre of the other two, formed without cancellation.
        offset = np.abs((third - first) + (third - second)) / 2
        return np.asarray(np.maximum(radius, (radius + offset) / 2))

    @property
    def von_mises(self) -> Array:
        """Equivalent stress of von Mises at each point."""
        first, third, second, shear = self._components
        squares = (first - third) ** 2 + (third - second) ** 2 + (second - first) ** 2
        return np.asarray(np.sqrt(squares / 2 + 3 * shear**2))

    @property
    def _components(self) -> list[Array]:
        return [getattr(self, field.name) for field in fields(self)]  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class AxisymmetricStress(_InSymmetryPlane):
    """Stress in cylindrical coordinates (r, theta, z), tension positive, z into the body.

    Parameters
    ----------
    rr, tt, zz, rz : numpy.ndarray
        Radial, hoop, axial and shear stress, all of the same shape.

    Examples
    --------
    >>> AxisymmetricStress(rr=np.array(-1.0), tt=np.array(-1.0), zz=np.array(-3.0), rz=np.array(0.0)).max_shear
    array(1.)
    """

    rr: Array
    tt: Array
    zz: Array
    rz: Array


@dataclass(frozen=True, eq=False)
class SymmetryPlaneStress(_InSymmetryPlane):
    """Stress in a plane of symmetry y = 0, where xy and yz vanish; tension positive, z into the body.

    Parameters
    ----------
    xx, yy, zz, xz : numpy.ndarray
        Stress components, all of the same shape.

    Examples
    --------
    >>> SymmetryPlaneStress(xx=np.array(1.0), yy=np.array(0.0), zz=np.array(-1.0), xz=np.array(0.0)).max_shear
    array(1.)
    """

    xx: Array
    yy: Array
    zz: Array
    xz: Array


def contact_modulus(first: Material, second: Material | None = None) -> float:
    """Return E*, with 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

    Parameters
    ----------
    first : Material
        Material of one body.
    second : Material or None
        Material of the other body; None for a rigid one.

    Returns
    -------
    float
        Contact modulus E* (force / length^2).

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, chapter 4.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> round(contact_modulus(steel, steel), 2), round(contact_modulus(steel), 2)
    (115384.62, 230769.23)
    """
    instance("the first material", first, Material)
    instance("the second material", second, (Material, type(None)))
    compliance = 1 / first.plane_strain_modulus
    if second is not None:
        compliance += 1 / second.plane_strain_modulus
    return 1 / compliance


def pair_modulus(materials: tuple[Material | None, Material | None]) -> float:
    """Return E* of a pair of materials, of which at most one is None (rigid).

    Raises
    ------
    InputError
        If the pair is not two materials, or both are rigid.

    Examples
    --------
    >>> round(pair_modulus((None, Material(E=210e3, nu=0.3))), 2)
    230769.23
    """
    try:
        first, second = materials
    except (TypeError, ValueError):
        raise InputError(f"Expected materials=(m1, m2), None for a rigid body; found {shown(materials)}.") from None
    for material in (first, second):
        if not (material is None or isinstance(material, Material)):
            raise InputError(f"Expected a Material, or None for a rigid body; found {shown(material)}.", code="no-body")
    if first is None:
        first, second = second, first
    if first is None:
        raise InputError("Expected at least one elastic body; found both rigid (None). Give one a Material.")
    return contact_modulus(first, second)


def dundurs(first: Material | None, second: Material | None = None) -> float:
    """Return Dundurs' second constant beta, by which tangential tractions displace the surfaces along their normal.

    Parameters
    ----------
    first, second : Material or None
        Materials of the two bodies, None for a rigid one.

    Returns
    -------
    float
        ((1 - 2 nu1)/G1 - (1 - 2 nu2)/G2)/(2 (1 - nu1)/G1 + 2 (1 - nu2)/G2), from -1/2 to 1/2; zero for equal materials,
        and for an incompressible one on a rigid one.

    Raises
    ------
    InputError
        If both bodies are rigid.

    References
    ----------
    J. Dundurs, J. Appl. Mech. 36 (1969) 650; K. L. Johnson, Contact Mechanics, 1985, section 5.1.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> round(dundurs(steel), 12), round(dundurs(None, steel), 12), dundurs(steel, steel)
    (0.285714285714, -0.285714285714, 0.0)
    """
    pair_modulus((first, second))
    above, below = 0.0, 0.0
    for material, sign in ((first, 1), (second, -1)):
        if material is not None:
            above += sign * (1 - 2 * material.nu) / material.shear_modulus
            below += 2 * (1 - material.nu) / material.shear_modulus
    return above / below


def poisson_ratio(materials: tuple[Material | None, Material | None], body: int) -> float:
    """Return Poisson's ratio of body 0 or 1 of a pair, to evaluate a stress in it.

    Raises
    ------
    InputError
        If there is no such body, or it is rigid.

    Examples
    --------
    >>> poisson_ratio((None, Material(E=210e3, nu=0.3)), 1)
    0.3
    """
    if not (isinstance(body, int) and body in (0, 1)):
        raise InputError(f"Expected body 0 (the first) or 1 (the second); found {shown(body)}.", code="unknown-body")
    material = materials[body]
    if material is None:
        raise InputError(f"Body {body} is rigid: it has no stress. Ask for body {1 - body}.", code="rigid-body")
    return material.nu


def relative_radius(radii: tuple[float, float]) -> float:
    """Return R, with 1/R = 1/R1 + 1/R2.

    Parameters
    ----------
    radii : tuple of (float, float)
        Radii of the two surfaces; negative for a concave one, `inf` for a plane.

    Returns
    -------
    float
        Relative radius, positive.

    Raises
    ------
    InputError
        If a radius is zero or not a number, or 1/R1 + 1/R2 is not positive.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, chapter 4.

    Examples
    --------
    >>> relative_radius((10.0, math.inf)), relative_radius((10.0, -20.0))
    (10.0, 20.0)
    """
    found = array_of(radii)
    if found is None or found.shape != (2,):
        raise InputError(f"Expected radii=(R1, R2), two numbers; found {shown(radii)}.", code="radii")
    first, second = found.tolist()
    check_magnitude("a radius", found[np.isfinite(found)])
    if math.isnan(first) or math.isnan(second) or 0 in (first, second):
        raise InputError(f"Expected radii that are not zero (negative: concave, inf: plane); found {radii!r}.")
    if math.isinf(first) or math.isinf(second):
        curvature = 1 / first + 1 / second
        R = 1 / curvature if curvature != 0 else math.inf
    else:
        R = second / (1 + second / first) if first + second != 0 else math.inf
    if not 0 < R < math.inf:
        raise InputError(
            f"Expected 1/R1 + 1/R2 > 0, so that the surfaces touch at one point; found radii {first} and {second}. "
            "The radius of a concave surface must be larger than that of the ball in it.",
            code="surfaces-do-not-touch",
        )
    return R
