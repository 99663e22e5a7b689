"""Closed forms for comparison with a contact on a half-space, by the shape of the indenter, where they exist."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fecontact.analytic import axisymmetric, hertz, layer, punch, sinusoid
from fecontact.bodies import HalfSpace, Sphere
from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import positive
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace.pressing import Load
from fecontact.surfaces import Cone, Cylinder, Ellipsoid, FlatPunch, Paraboloid
from fecontact.surfaces.rigid.shapes import Indenter

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

    kind = "wave"
    amplitude: float
    wavelength: float

    def __post_init__(self) -> None:
        for name, value in (("amplitude", self.amplitude), ("wavelength", self.wavelength)):
            positive(f"a wave's {name}", value)

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
        Figures by the names of `indentation.FIGURES`.
    pressure : function of x, y, or None
    compared : function of x, y
        Range in which pressures are compared.
    """

    source: str
    half_widths: tuple[float, float]
    figures: dict[str, float]
    pressure: Callable[[Array, Array], Array] | None = None
    compared: Callable[[Array, Array], Mask] = field(default=lambda x, y: np.ones(np.shape(x + y), bool))


def closed_form(shape: Any, half: HalfSpace, load: Load) -> Exact | None:
    """The closed form for a shape pressed on a half-space, or None.

    Parameters
    ----------
    shape : surface with `heights`
    half : HalfSpace
    load : Load
        With a point if the shape is free to tilt.
    """
    if half.pressure != "uniform" or (half.layers and (half.periodic or load.point)):
        return None
    forms = _ON_PERIOD if half.periodic else _ON_LAYER if half.layers else _ON_HALF_SPACE
    found = forms.get(shape.kind) if isinstance(shape, Indenter) else None
    return None if found is None else found(shape, half, load)


def _unit(half: HalfSpace) -> Material:
    """A material with the half-space's E/(1 - nu^2)."""
    return Material(E=half.compliance.modulus, nu=0.0)


def _pressed(load: Load) -> dict[str, Any]:
    return {"force": load.force} if load.force is not None else {"approach": load.approach}


def _tilts(load: Load) -> bool:
    return load.point is not None and any(load.point)


def _round(source: str, exact: Any, more: Mapping[str, float] | None = None, within: float = math.inf) -> Exact:
    """Closed form of a circular contact, with its pressures compared within a radius."""
    figures = {"force": exact.force, "approach": exact.approach, "area": math.pi * exact.a**2}
    return Exact(
        source,
        (exact.a, exact.a),
        {**figures, **(more or {})},
        lambda x, y: exact.pressure(np.hypot(x, y)),
        _within(within),
    )


def _within(radius: float) -> Callable[[Array, Array], Mask]:
    return lambda x, y: np.asarray(np.hypot(x, y) < radius)


def _flat(shape: FlatPunch, half: HalfSpace, load: Load) -> Exact | None:
    """Boussinesq's punch."""
    x, y = load.point or (0.0, 0.0)
    arm, radius = math.hypot(x, y), shape.radius
    if radius is None or arm > radius / 3:
        return None
    exact = punch.flat(radius=radius, modulus=half.compliance.modulus, offset=arm, **_pressed(load))
    source = "flat punch, load off its middle" if arm else "flat punch (Boussinesq)"
    tilt = {"tilt (rad)": exact.tilt} if arm else {}
    along = (x / arm, y / arm) if arm else (1.0, 0.0)
    return Exact(
        source,
        (exact.a, exact.a),
        {**_round(source, exact).figures, "stiffness": exact.stiffness, **tilt},
        lambda x, y: exact.pressure(along[0] * x + along[1] * y, along[0] * y - along[1] * x),
        _within(SINGULAR * exact.a),
    )


def _cone(shape: Cone, half: HalfSpace, load: Load) -> Exact | None:
    """Love's cone."""
    if _tilts(load):
        return None
    exact = punch.cone(angle=shape.angle, modulus=half.compliance.modulus, **_pressed(load))
    return _round("cone (Love, Sneddon)", exact, {"stiffness": exact.stiffness}, SINGULAR * exact.a)


def _ellipse(shape: Paraboloid, half: HalfSpace, load: Load, source: str = "Hertz") -> Exact | None:
    """Hertz's ellipse."""
    if _tilts(load):
        return None
    radii = shape.curvature_radii
    exact = hertz.ellipse((radii, (math.inf, math.inf)), (_unit(half), None), **_pressed(load))
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


def _ellipsoid(shape: Ellipsoid, half: HalfSpace, load: Load) -> Exact | None:
    """Hertz's ellipse for the paraboloid at its pole."""
    a, b, c = shape.semi_axes
    pole = Paraboloid(a**2 / c, b**2 / c)
    return _ellipse(pole, half, load, "Hertz, for the ellipsoid's curvatures at its pole")


def _sphere(shape: Sphere, half: HalfSpace, load: Load) -> Exact | None:
    """Sneddon's integral over the sphere's own profile."""
    if _tilts(load):
        return None
    R = shape.radius
    slope, modulus = lambda r: r / np.sqrt(R**2 - r**2), half.compliance.modulus
    try:
        exact = axisymmetric.indent(slope=slope, modulus=modulus, limit=WIDEST * R, **_pressed(load))
    except InputError as error:
        raise InputError(
            f"The load is beyond what the geometry allows: the contact would be wider than {WIDEST:g} of the sphere of "
            f"radius {R:g}, far beyond the small slopes of a half-space. Take a smaller load or a larger sphere."
        ) from error
    # in s = sqrt(1 - r^2/a^2) the pressure is smooth
    s = np.linspace(0.0, 1.0, 30)
    spline = CubicSpline(s, exact.pressure(exact.a * np.sqrt(1 - s**2)))

    def pressure(x: Array, y: Array) -> Array:
        inside = np.maximum(1 - (x**2 + y**2) / exact.a**2, 0.0)
        return np.where(inside > 0, spline(np.sqrt(inside)), 0.0)

    source = "sphere's own profile (Sneddon); Hertz where a << R"
    more = {"stiffness": exact.stiffness, "maximum pressure": float(exact.pressure(0.0))}
    return replace(_round(source, exact, more), pressure=pressure)


def _ball_on_layer(shape: Sphere, half: HalfSpace, load: Load) -> Exact | None:
    """The paraboloid of its curvature."""
    return _on_layer(Paraboloid(shape.radius), half, load, ", for the sphere's paraboloid")


def _on_layer(shape: Paraboloid, half: HalfSpace, load: Load, note: str = "") -> Exact | None:
    """Lebedev & Ufliand's round paraboloid on one layer on a rigid base."""
    radii = shape.curvature_radii
    if radii[0] != radii[1] or half.material is not None or len(half.layers) != 1 or half.against is not None:
        return None
    (only,) = half.layers
    base: Any = only.interface
    try:
        exact = layer.paraboloid(
            radius=radii[0], thickness=only.thickness, material=only.material, base=base, **_pressed(load)
        )
    except InputError:  # wider than the range of the method
        return None
    return _round(f"layer on a rigid base (Lebedev & Ufliand){note}", exact, {"maximum pressure": exact.p0})


def _line(shape: Cylinder, half: HalfSpace, load: Load) -> Exact | None:
    """Hertz's line contact, with the force on the length of the grid."""
    if load.force is None or not shape.is_endless:
        return None
    length = half.grid.size[1]
    exact = hertz.line((shape.radius, math.inf), (_unit(half), None), force=load.force / length)
    return Exact(
        "Hertz's line contact, for a cylinder far from its neighbours",
        (exact.a, length / 2),
        {"area": 2 * exact.a * length, "maximum pressure": exact.p0},
        lambda x, y: exact.pressure(x + 0 * y),
    )


def _wave(shape: Wave, half: HalfSpace, load: Load) -> Exact | None:
    """Westergaard's sinusoid, whole waves in the period."""
    if load.force is None:
        return None
    (length, width), modulus = half.grid.size, half.compliance.modulus
    exact = sinusoid.westergaard(
        amplitude=shape.amplitude,
        wavelength=shape.wavelength,
        modulus=modulus,
        mean_pressure=load.force / (length * width),
    )
    return Exact(
        "Westergaard",
        (length / 2, width / 2),
        {
            "force": load.force,
            "area": exact.area_fraction * length * width,
            "maximum pressure": exact.max_pressure,
            "mean gap": exact.mean_gap,
        },
        lambda x, y: exact.pressure(x + 0 * y),
    )


_Forms = dict[str, Callable[..., Exact | None]]
#: Closed forms by the kind of shape: on a free half-space, on layers, and under a force on each period.
_ON_HALF_SPACE: _Forms = {
    "flat_punch": _flat,
    "cone": _cone,
    "sphere": _sphere,
    "paraboloid": _ellipse,
    "ellipsoid": _ellipsoid,
}
_ON_LAYER: _Forms = {"sphere": _ball_on_layer, "paraboloid": _on_layer}
_ON_PERIOD: _Forms = {"cylinder": _line, "wave": _wave}
