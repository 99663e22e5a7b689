"""Closed forms for comparison with a contact on a half-space, by the shape of the indenter, where they exist."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fecontact.analytic import axisymmetric, hertz, layer, punch, sinusoid
from fecontact.bodies import HalfSpace
from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import positive
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.surfaces.rigid.shapes import ClosedForms, Indenter, T

SINGULAR = 0.8
"""Share of the radius of a punch or a cone within which pressures are compared; they are singular at it, or at 0."""

WIDEST = 0.7
"""Contact radius over that of a sphere beyond which a half-space is not a valid model."""


@dataclass(frozen=True)
class Wave(Indenter):
    """The sinusoidal surface amplitude (1 - cos(2 pi x/wavelength)), a crest at x = 0 (Westergaard).

    Examples
    --------
    >>> import numpy as np
    >>> Wave(0.5, 2.0).heights(np.array([0.0, 1.0]), np.zeros(2)).round(12).tolist()
    [0.0, 1.0]
    """

    amplitude: float
    wavelength: float

    def __post_init__(self) -> None:
        for name, value in (("amplitude", self.amplitude), ("wavelength", self.wavelength)):
            positive(f"a wave's {name}", value)

    def closed_form(self, forms: ClosedForms[T]) -> T | None:
        """Its closed form."""
        return forms.wave(self.amplitude, self.wavelength)

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        return np.asarray(2 * self.amplitude * np.sin(np.pi * np.asarray(x) / self.wavelength) ** 2 + 0 * np.asarray(y))


@dataclass(frozen=True, eq=False)
class Exact:
    """A closed form.

    Attributes
    ----------
    source : str
        Source of the solution, and its assumptions.
    half_widths : (float, float)
        Half-widths of the contact along x and y.
    figures : dict of str to float
        Figures by the names of `indent.FIGURES`.
    pressure : function of x, y, or None
    compared : function of x, y
        Range in which pressures are compared.
    """

    source: str
    half_widths: tuple[float, float]
    figures: dict[str, float]
    pressure: Callable[[Array, Array], Array] | None = None
    compared: Callable[[Array, Array], Mask] = field(default=lambda x, y: np.ones(np.shape(x + y), bool))


def closed_form(
    shape: Any, half: HalfSpace, force: float | None, approach: float | None, offset: tuple[float, float] | None = None
) -> Exact | None:
    """The closed form for a shape pressed on a half-space, or None.

    Parameters
    ----------
    shape : surface with `heights`
    half : HalfSpace
    force, approach : float or None
        Exactly one.
    offset : (float, float), optional
        Point of action of the force, if the shape is free to tilt.
    """
    load: dict[str, Any] = {"force": force} if force is not None else {"approach": approach}
    if half.pressure != "uniform":
        return None
    if half.periodic:
        return None if half.layers or force is None else asked(shape).closed_form(_OnPeriod(half, force))
    if half.layers:
        return None if offset else asked(shape).closed_form(_OnLayer(half, load))
    return asked(shape).closed_form(_OnHalfSpace(half.compliance.modulus, load, offset))


def asked(shape: Any) -> Indenter:
    """The object with a shape's closed form: the shape, or defaults for user-defined shapes and heights."""
    return shape if isinstance(shape, Indenter) else Indenter()


def _unit(modulus: float) -> Material:
    """A material with the given E/(1 - nu^2)."""
    return Material(E=modulus, nu=0.0)


def _round(
    figures: Any,
    source: str,
    pressure: Callable[[Array], Array],
    extra: dict[str, float] | None = None,
    **more: Any,
) -> Exact:
    """Closed form of a circular contact with force, approach, a and stiffness."""
    known = {
        "force": figures.force,
        "approach": figures.approach,
        "area": math.pi * figures.a**2,
        "stiffness": figures.stiffness,
    }
    return Exact(
        source,
        (figures.a, figures.a),
        {**known, **(extra or {})},
        lambda x, y: pressure(np.hypot(x, y)),
        **more,
    )


def _within(radius: float) -> Callable[[Array, Array], Mask]:
    return lambda x, y: np.asarray(np.hypot(x, y) < radius)


@dataclass(frozen=True)
class _OnHalfSpace(ClosedForms[Exact]):
    """A free half-space; the load may have an offset if the shape can tilt."""

    modulus: float
    load: dict[str, Any]
    offset: tuple[float, float] | None

    @property
    def _tilts(self) -> bool:
        return self.offset is not None and self.offset != (0.0, 0.0)

    def flat(self, radius: float) -> Exact | None:
        """Boussinesq's punch."""
        x, y = self.offset or (0.0, 0.0)
        arm = math.hypot(x, y)
        if arm > radius / 3:
            return None
        exact = punch.flat(radius=radius, modulus=self.modulus, offset=arm, **self.load)
        along = (x / arm, y / arm) if arm else (1.0, 0.0)
        figures = {
            "force": exact.force,
            "approach": exact.approach,
            "area": math.pi * exact.a**2,
            "stiffness": exact.stiffness,
        }
        if arm:
            figures["tilt (rad)"] = exact.tilt
        return Exact(
            "flat punch (Boussinesq)" if not arm else "flat punch, load off its middle",
            (exact.a, exact.a),
            figures,
            lambda x, y: exact.pressure(along[0] * x + along[1] * y, along[0] * y - along[1] * x),
            _within(SINGULAR * exact.a),
        )

    def cone(self, angle: float) -> Exact | None:
        """Love's cone."""
        if self._tilts:
            return None
        exact = punch.cone(angle=angle, modulus=self.modulus, **self.load)
        return _round(exact, "cone (Love, Sneddon)", exact.pressure, compared=_within(SINGULAR * exact.a))

    def sphere(self, radius: float) -> Exact | None:
        """Sneddon's integral over the sphere's own profile."""
        return None if self._tilts else _sphere(radius, self.modulus, self.load)

    def paraboloid(self, radii: tuple[float, float], source: str = "Hertz") -> Exact | None:
        """Hertz's ellipse."""
        if self._tilts:
            return None
        exact = hertz.ellipse((radii, (math.inf, math.inf)), (_unit(self.modulus), None), **self.load)
        widths = (exact.a, exact.b) if radii[0] >= radii[1] else (exact.b, exact.a)
        return Exact(
            source,
            widths,
            {
                "force": exact.force,
                "approach": exact.approach,
                "area": math.pi * exact.a * exact.b,
                "maximum pressure": exact.p0,
                "stiffness": exact.stiffness,
            },
            lambda x, y: exact.p0 * np.sqrt(np.maximum(1 - (x / widths[0]) ** 2 - (y / widths[1]) ** 2, 0.0)),
        )

    def ellipsoid(self, semi_axes: tuple[float, float, float]) -> Exact | None:
        """Hertz's ellipse for the paraboloid at its pole."""
        a, b, c = semi_axes
        return self.paraboloid((a**2 / c, b**2 / c), "Hertz, for the ellipsoid's curvatures at its pole")


def _sphere(R: float, modulus: float, load: dict[str, Any]) -> Exact:
    try:
        exact = axisymmetric.indent(slope=lambda r: r / np.sqrt(R**2 - r**2), modulus=modulus, limit=WIDEST * R, **load)
    except InputError as error:
        raise InputError(
            f"The load is beyond what the geometry allows: the contact would be wider than {WIDEST:g} of the sphere of "
            f"radius {R:g}, far beyond the small slopes of a half-space. Take a smaller load or a larger sphere."
        ) from error
    # in s = sqrt(1 - r^2/a^2) the pressure is smooth
    s = np.linspace(0.0, 1.0, 30)
    spline = CubicSpline(s, exact.pressure(exact.a * np.sqrt(1 - s**2)))

    def pressure(r: Array) -> Array:
        inside = np.maximum(1 - (r / exact.a) ** 2, 0.0)
        return np.where(inside > 0, spline(np.sqrt(inside)), 0.0)

    peak = {"maximum pressure": float(exact.pressure(0.0))}
    return _round(exact, "sphere's own profile (Sneddon); Hertz where a << R", pressure, peak)


@dataclass(frozen=True)
class _OnLayer(ClosedForms[Exact]):
    """One layer on a rigid base."""

    half: HalfSpace
    load: dict[str, Any]

    def sphere(self, radius: float) -> Exact | None:
        """As the paraboloid of its curvature."""
        return self.paraboloid((radius, radius), ", for the sphere's paraboloid")

    def paraboloid(self, radii: tuple[float, float], note: str = "") -> Exact | None:
        """Lebedev & Ufliand's round paraboloid."""
        half = self.half
        if radii[0] != radii[1] or half.material is not None or len(half.layers) != 1 or half.against is not None:
            return None
        only = half.layers[0]
        base: Any = only.interface
        try:
            exact = layer.paraboloid(
                radius=radii[0], thickness=only.thickness, material=only.material, base=base, **self.load
            )
        except InputError:  # wider than the range of the method
            return None
        return Exact(
            f"layer on a rigid base (Lebedev & Ufliand){note}",
            (exact.a, exact.a),
            {
                "force": exact.force,
                "approach": exact.approach,
                "area": math.pi * exact.a**2,
                "maximum pressure": exact.p0,
            },
            lambda x, y: exact.pressure(np.hypot(x, y)),
        )


@dataclass(frozen=True)
class _OnPeriod(ClosedForms[Exact]):
    """A periodic half-space, under a force on each period."""

    half: HalfSpace
    force: float

    def endless_cylinder(self, radius: float) -> Exact | None:
        """Hertz's line contact, with the force on the length of the grid."""
        half = self.half
        exact = hertz.line(
            (radius, math.inf), (_unit(half.compliance.modulus), None), force=self.force / half.grid.size[1]
        )
        return Exact(
            "Hertz's line contact, for a cylinder far from its neighbours",
            (exact.a, half.grid.size[1] / 2),
            {"area": 2 * exact.a * half.grid.size[1], "maximum pressure": exact.p0},
            lambda x, y: exact.pressure(np.broadcast_to(x, np.broadcast_shapes(np.shape(x), np.shape(y)))),
        )

    def wave(self, amplitude: float, wavelength: float) -> Exact | None:
        """Westergaard's sinusoid, whole waves in the period."""
        half = self.half
        area = half.grid.size[0] * half.grid.size[1]
        exact = sinusoid.westergaard(
            amplitude=amplitude,
            wavelength=wavelength,
            modulus=half.compliance.modulus,
            mean_pressure=self.force / area,
        )
        return Exact(
            "Westergaard",
            (half.grid.size[0] / 2, half.grid.size[1] / 2),
            {
                "force": self.force,
                "area": exact.area_fraction * area,
                "maximum pressure": exact.max_pressure,
                "mean gap": exact.mean_gap,
            },
            lambda x, y: exact.pressure(x + 0 * y),
        )
