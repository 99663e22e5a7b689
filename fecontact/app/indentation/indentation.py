"""Indentation of a half-space by a rigid shape, with its closed form where there is one, for one or several loads.

Half-space and load of an indentation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fecontact.app.indentation.closed_forms import asked, closed_form
from fecontact.app.indentation.figures import Curve, Indentation
from fecontact.bodies import HalfSpace
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace import HalfSpaceContact, Layer


@dataclass(frozen=True)
class Ground:
    """A half-space without its grid.

    Attributes
    ----------
    material : Material or None
        None: a rigid base under layers.
    layers : tuple of Layer
    against : Material or None
        Material of an elastic counter-body.
    periodic : bool
    """

    material: Material | None
    layers: tuple[Layer, ...] = ()
    against: Material | None = None
    periodic: bool = False

    def on(self, size: tuple[float, float], cells: tuple[int, int]) -> HalfSpace:
        """The half-space with a grid."""
        return HalfSpace(self.material, size, cells, self.periodic, layers=self.layers, against=self.against)

    @property
    def softest(self) -> Ground:
        """The homogeneous half-space of its softest material, for the widest contact."""
        materials = [m for m in (self.material, *(layer.material for layer in self.layers)) if m is not None]
        soft = min(materials, key=lambda m: m.plane_strain_modulus)
        return Ground(soft, (), self.against, False)


@dataclass(frozen=True)
class IndentationLoad:
    """Force or approach, and the moment of the force about the origin or its point of action.

    Attributes
    ----------
    force, approach : float or None
    point : (float, float) or None
        Point of action of the force; the shape is then free to tilt.
    """

    force: float | None = None
    approach: float | None = None
    point: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        given = [(n, v) for n, v in (("force", self.force), ("approach", self.approach)) if v is not None]
        if len(given) != 1:
            raise InputError(f"Give exactly one of a force and an approach; found {len(given)}.")
        name, value = given[0]
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"The {name} must be positive (pressing together); found {value!r}. A frictionless contact without "
                "adhesion carries no tension, and without load nothing is pressed."
            )
        if self.point is not None and self.force is None:
            raise InputError("A load point or moment goes with a force: with a prescribed approach nothing tilts.")

    @classmethod
    def of_moment(cls, force: float, moment: tuple[float, float]) -> IndentationLoad:
        """A force downwards with moments about x and y through the origin.

        Examples
        --------
        >>> IndentationLoad.of_moment(10.0, (0.0, 5.0)).point
        (0.5, 0.0)
        """
        return cls(force, None, (moment[1] / force if moment[1] else 0.0, -moment[0] / force if moment[0] else 0.0))


BOX = 3.0
"""Default side of a grid, in half-widths of the contact."""

MIN_BOX = 2.2
"""Least side of a free grid in half-widths of the contact; less is refused before a solve."""

STEEP = 5.0
"""Jump of heights across the border of a period, in rms differences of neighbours, above which they do not repeat."""


def indent(
    shape: Any,
    ground: Ground,
    load: IndentationLoad,
    *,
    cells: tuple[int, int] = (256, 256),
    size: tuple[float, float] | None = None,
    name: str | None = None,
    tolerance: float = 1e-8,
) -> Indentation:
    """Press a rigid shape on a half-space.

    Parameters
    ----------
    shape : surface with `heights`, or (nx, ny) array of heights
    ground : Ground
    load : IndentationLoad
    cells : (int, int)
        Cells of the grid; an array of heights defines its own.
    size : (float, float), optional
        Size of the grid; by default three half-widths of the contact from the closed form.
    name : str, optional
        Name of the shape, for the table.
    tolerance : float

    Returns
    -------
    Indentation

    Raises
    ------
    InputError
        If the grid is smaller than the contact (the message gives the size needed) or has no size and no closed form,
        if periodic and free are mixed up, or if the load is too large for the geometry.

    Examples
    --------
    >>> import fecontact as fc
    >>> steel = fc.Material(E=210e3, nu=0.3)
    >>> found = indent(fc.Sphere(10.0), Ground(steel), IndentationLoad(force=100.0), cells=(64, 64))
    >>> abs(found.errors["approach"]) < 1e-3
    True
    """
    half = _grid(shape, ground, load, cells, size)
    _check_depth(ground, load)
    if half.periodic and load.point is not None:
        raise InputError(
            "A periodic surface cannot tilt, for then it would not repeat: leave out the load point (or moment), or "
            "make the half-space free."
        )
    exact = closed_form(shape, half, load.force, load.approach, load.point)
    contact = half.press(shape, force=load.force, approach=load.approach, load_point=load.point, tolerance=tolerance)
    _check_outline(shape, contact)
    return Indentation(name or type(shape).__name__, shape, half, contact, exact)


def _grid(
    shape: Any, ground: Ground, load: IndentationLoad, cells: tuple[int, int], size: tuple[float, float] | None
) -> HalfSpace:
    """The half-space with a grid that contains the contact."""
    if ground.periodic:
        if size is None:
            raise InputError("A periodic half-space needs a size: that of its period.")
        _check_repeats(shape)
        return ground.on(size, cells)
    if asked(shape).is_endless:
        raise InputError(
            "An endless cylinder on a free half-space would touch it to the border of any grid: give it a length, or "
            "make the half-space periodic."
        )
    # the closed form does not depend on the trial half-space's grid
    trial = closed_form(shape, ground.softest.on((1.0, 1.0), (2, 2)), load.force, load.approach)
    if size is None and trial is None:
        raise InputError(
            "There is no closed form for the width of this contact: give the grid a size that contains it."
        )
    if trial is None or ground.layers:
        widths = None if trial is None else tuple(1.2 * w for w in trial.half_widths)
    else:
        widths = trial.half_widths
    if size is None:
        assert widths is not None
        return ground.on((BOX * widths[0], BOX * widths[1]), cells)
    if widths is not None and not ground.layers:
        for axis, (side, w) in enumerate(zip(size, widths, strict=True)):
            if side < MIN_BOX * w:
                raise InputError(
                    f"The grid is smaller than the contact along {'xy'[axis]}: its side is {side:g}, the contact will "
                    f"be {2 * w:.4g} wide. Give it {BOX * w:.4g}."
                )
    return ground.on(size, cells)


def _check_repeats(shape: Any) -> None:
    """Refuse heights that are not periodic."""
    if np.ndim(shape) != 2 or not np.isfinite(z := np.asarray(shape, dtype=float)).all():
        return  # a shape has no borders; other arrays are checked later
    for axis in (0, 1):
        usual = float(np.sqrt((np.diff(z, axis=axis) ** 2).mean()))
        lines = np.moveaxis(z, axis, 0)
        jump = float(np.sqrt(((lines[0] - lines[-1]) ** 2).mean()))
        if jump > STEEP * usual:
            raise InputError(
                f"The heights do not repeat along {'xy'[axis]}: from the last row to the first they jump by "
                f"{jump:.3g}, neighbours differ by {usual:.3g}. Take off the trend (--trend plane), window it, "
                "or make the half-space free."
            )


def _check_depth(ground: Ground, load: IndentationLoad) -> None:
    """Refuse an approach comparable to the thickness of layers on a rigid base."""
    total = sum(layer.thickness for layer in ground.layers)
    if ground.material is None and load.approach is not None and load.approach >= total:
        raise InputError(
            f"The load is beyond what the geometry allows: an approach of {load.approach:g} through layers of "
            f"{total:g} on a rigid base. Small strains need a fraction of the thickness."
        )


def _check_outline(shape: Any, contact: HalfSpaceContact) -> None:
    """Refuse a contact that reaches the outline of a round shape."""
    if np.ndim(shape):  # not for an array of heights
        return
    none = ~np.isfinite(contact.gap)
    active = contact.active
    beside = (
        (active[1:] & none[:-1]).any() or (active[:-1] & none[1:]).any(),
        (active[:, 1:] & none[:, :-1]).any() or (active[:, :-1] & none[:, 1:]).any(),
    )
    if any(b and not is_open for b, is_open in zip(beside, asked(shape).open_ends, strict=True)):
        raise InputError(
            f"The load is beyond what the geometry allows: the contact reaches the outline of the "
            f"{type(shape).__name__.lower()}, beyond which it has no lower side. Take a smaller load."
        )


def curve(shape: Any, ground: Ground, loads: Sequence[IndentationLoad], **options: Any) -> Curve:
    """Press a shape with several loads; options as in `indent`, with one grid for the largest load.

    Examples
    --------
    >>> import fecontact as fc
    >>> ball, ground = fc.Sphere(10.0), Ground(fc.Material(E=1.0, nu=0.0))
    >>> found = curve(ball, ground, [IndentationLoad(force=f) for f in (0.01, 0.08)], cells=(64, 64))
    >>> bool(abs(found.column("approach")[1] / found.column("approach")[0] / 4 - 1) < 0.01)
    True
    """
    if not loads:
        raise InputError("A curve needs at least one load.")
    if options.get("size") is None:
        largest = max(loads, key=lambda load: load.force or load.approach or 0.0)
        cells = options.get("cells", (256, 256))
        options = {**options, "size": _grid(shape, ground, largest, cells, None).grid.size}
    return Curve(tuple(indent(shape, ground, load, **options) for load in loads))
