"""Problems with a closed form, on which methods are compared: exact fields, and errors measured alike for all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from fecontact import Material
from fecontact.analytic import hertz, layer, punch
from fecontact.app.studies.spheres import CASES
from fecontact.common.arrays import Array


@dataclass(frozen=True, eq=False)
class Problem:
    """A contact whose pressure is known.

    Attributes
    ----------
    name, title : str
    semi_axes : (float, float)
        Of the contact's edge along x and y; infinite along y for a line.
    pressure : callable
        Exact pressure at x, y (n,).
    approach : float or None
        None where it depends on the shape of the whole body.
    force : float
        Total load; per length for a line.
    moment : float or None
        Square of the semi-axis over the mean square of the distance, weighted by force: 5/2 for the circle and, in
        coordinates scaled by the semi-axes, for the ellipse; 4 for the line. None where the edge is prescribed.
    reach : float
        Errors are taken where the distance, scaled by the semi-axes, is at most this.
    data : mapping
        What is needed to build it.
    """

    name: str
    title: str
    semi_axes: tuple[float, float]
    pressure: Callable[[Array, Array], Array]
    approach: float | None
    force: float
    moment: float | None
    reach: float = 1.2
    data: Mapping[str, Any] = field(default_factory=dict)

    def errors(self, points: Array, pressure: Array, areas: Array) -> dict[str, float]:
        """Errors of a sampled pressure.

        Parameters
        ----------
        points : (n, 2) array
            Samples, relative to the centre of the contact.
        pressure, areas : (n,) array
            Found there, and the area that each sample stands for.

        Returns
        -------
        dict
            'pressure_l2': relative L2 norm of the difference within the reach; 'edge_radius': signed relative error of
            the edge by the second moment of the pressure.

        Examples
        --------
        >>> x = (np.arange(300) + 0.5) / 200
        >>> line = problem("line")
        >>> points = np.stack([line.semi_axes[0] * x, 0 * x], axis=1)
        >>> exact = line.pressure(points[:, 0], points[:, 1])
        >>> errors = line.errors(points, 1.01 * exact, np.ones(300))
        >>> round(errors["pressure_l2"], 12), abs(errors["edge_radius"]) < 1e-3
        (0.01, True)
        """
        x, y = points.T
        rho2 = (x / self.semi_axes[0]) ** 2 + (y / self.semi_axes[1]) ** 2
        inside = rho2 <= self.reach**2
        exact = self.pressure(x[inside], y[inside])
        miss = areas[inside] * (pressure[inside] - exact) ** 2
        out = {"pressure_l2": float(np.sqrt(miss.sum() / (areas[inside] * exact**2).sum()))}
        if self.moment is not None:
            forces = pressure * areas
            out["edge_radius"] = float(np.sqrt(self.moment * (forces @ rho2) / forces.sum()) - 1)
        return out

    def centre_error(self, points: Array, pressure: Array) -> float:
        """Signed relative error of the pressure at the sample nearest the centre."""
        k = int(np.argmin(np.hypot(*points.T)))
        exact = self.pressure(points[k : k + 1, 0], points[k : k + 1, 1])[0]
        return float(pressure[k] / exact - 1)


def _round(name: str) -> Problem:
    case = CASES[name]
    exact = case.hertz
    title = (
        f"two spheres, R = {case.radii[0]:g} and {case.radii[1]:g} {case.length}, P = {case.force:g} {case.unit_force}"
    )
    return Problem(
        name={"equal": "hertz", "unequal": "unequal"}[name],
        title=f"Hertz contact of {title}",
        semi_axes=(exact.a, exact.a),
        pressure=lambda x, y: exact.pressure(np.hypot(x, y)),
        approach=exact.approach,
        force=case.force,
        moment=2.5,
        data={"case": name, "material": case.material, "R": exact.R, "E_star": exact.E_star},
    )


#: Of the problems below; the paraboloids are so blunt that their slopes are one percent at the edge of the contact.
SOLID = Material(E=1.0, nu=0.3)


def _ellipse() -> Problem:
    radii = (500.0, 100.0)
    exact = hertz.ellipse((radii, (math.inf, math.inf)), (None, SOLID), force=0.03)
    return Problem(
        name="ellipse",
        title=f"rigid paraboloid with radii 5:1 on a half-space, contact ellipse {exact.a / exact.b:.2f}:1",
        semi_axes=(exact.a, exact.b),
        pressure=exact.pressure,
        approach=exact.approach,
        force=exact.force,
        moment=2.5,
        data={"radii": radii, "material": SOLID},
    )


def _line() -> Problem:
    radius = 100.0
    exact = hertz.line((radius, math.inf), (None, SOLID), force=0.0086)
    return Problem(
        name="line",
        title="rigid cylinder on a half-plane, plane strain",
        semi_axes=(exact.a, math.inf),
        pressure=lambda x, y: exact.pressure(x),
        approach=None,
        force=exact.force,
        moment=4.0,
        data={"radii": (radius, math.inf), "material": SOLID},
    )


def _layer() -> Problem:
    exact = layer.paraboloid(radius=200.0, thickness=1.0, material=SOLID, a=2.0)
    # the second moment of a pressure that is no half ellipsoid, by Gauss's rule in r^2
    t, w = np.polynomial.legendre.leggauss(200)
    s = (t + 1) / 2
    p = exact.pressure(exact.a * np.sqrt(s))
    return Problem(
        name="layer",
        title="rigid paraboloid on a bonded layer, a = 2 h, nu = 0.3",
        semi_axes=(exact.a, exact.a),
        pressure=lambda x, y: exact.pressure(np.hypot(x, y)),
        approach=exact.approach,
        force=exact.force,
        moment=float((w @ p) / (w @ (p * s))),
        data={"radii": (200.0, 200.0), "thickness": 1.0, "material": SOLID},
    )


def _punch() -> Problem:
    exact = punch.flat(radius=1.0, modulus=SOLID.plane_strain_modulus, force=0.01)
    return Problem(
        name="punch",
        title="flat circular punch on a half-space; errors over r <= 0.8 a, the pressure is infinite at the edge",
        semi_axes=(1.0, 1.0),
        pressure=lambda x, y: exact.pressure(x, y),
        approach=exact.approach,
        force=exact.force,
        moment=None,
        reach=0.8,
        data={"material": SOLID},
    )


_MAKERS: dict[str, Callable[[], Problem]] = {
    "hertz": lambda: _round("equal"),
    "unequal": lambda: _round("unequal"),
    "ellipse": _ellipse,
    "line": _line,
    "layer": _layer,
    "punch": _punch,
}

#: Names of the problems.
PROBLEMS = tuple(_MAKERS)


@cache
def problem(name: str) -> Problem:
    """A problem by its name, one of `PROBLEMS`."""
    return _MAKERS[name]()
