"""What closed forms of contact have in common: their fields by name, and a table of their quantities.

Aligned table of quantities, used to print results.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.files import new_figure, save_figure
from fecontact.common.html import cell
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
