"""A rigid shape pressed on a half-space: solved, beside its closed form where there is one, and over many loads."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.app.indentation.closed_forms import Exact, closed_form
from fecontact.bodies import HalfSpace, HalfSpaceContact, Layer
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.text_files import write_atomically
from fecontact.results.report import peak_memory
from fecontact.surfaces import Cylinder, FlatPunch

FIGURES = (
    "force",
    "approach",
    "contact area",
    "area, edge fitted",
    "maximum pressure",
    "mean pressure",
    "mean gap",
    "stiffness",
)

BOX = 3.0
"""Side of a grid whose size is not given, in half-widths of the contact."""

SMALLEST_BOX = 2.2
"""Side of a free grid in half-widths of the contact below which it is refused before anything is solved."""

STEEP = 5.0
"""Jump of heights across the border of a period, in rms differences of neighbours, above which they do not repeat."""


@dataclass(frozen=True, eq=False)
class Indentation:
    """A contact with the half-space and the shape that made it; made by `indent`.

    Attributes
    ----------
    name : str
        Of the shape.
    shape : surface with `heights`, or (nx, ny) array
    half : HalfSpace
    contact : HalfSpaceContact
    exact : Exact or None
    """

    name: str
    shape: Any
    half: HalfSpace
    contact: HalfSpaceContact
    exact: Exact | None

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures of the contact by the names in `FIGURES`, and the tilt where the load was off the middle."""
        c = self.contact
        found = {
            "force": c.force,
            "approach": c.approach,
            "contact area": c.area,
            "area, edge fitted": c.edge_area,
            "maximum pressure": c.max_pressure,
            "mean pressure": c.mean_pressure,
            "mean gap": c.mean_gap,
            "stiffness": self.half.stiffness(c),
        }
        if any(c.tilt):
            found["tilt (rad)"] = math.hypot(*c.tilt)
        return found

    @cached_property
    def errors(self) -> dict[str, float]:
        """Relative differences from the closed form, and that of the pressure in the L2 norm."""
        if self.exact is None:
            return {}
        known = dict(self.exact.figures)
        if not isinstance(self.shape, FlatPunch):  # elsewhere the edge is looked for
            known["area, edge fitted"] = known["contact area"]
        out = {name: self.figures[name] / value - 1 for name, value in known.items() if value and name in self.figures}
        if self.exact.pressure is not None:
            x, y = self.contact.grid.x[:, None], self.contact.grid.y[None, :]
            where = np.broadcast_to(self.exact.compared(x, y), self.contact.grid.shape)
            target = np.broadcast_to(self.exact.pressure(x, y), self.contact.grid.shape)[where]
            difference = self.contact.pressure[where] - target
            out["pressure, L2"] = float(np.linalg.norm(difference) / np.linalg.norm(target))
        return out

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Any:
        """Pressure, gap, displacement and stress inside, see `indentplot.plot_indentation`."""
        from fecontact.app.indentation.pictures import plot_indentation
        from fecontact.common.units import Units

        return plot_indentation(self, path, Units(length, force, stress))

    def save(self, path: str | Path) -> Path:
        """Write a CSV file of one row."""
        return Curve((self,)).save(path)

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        c, s = self.contact, self.contact.solver
        return {
            "shape": self.name,
            "periodic": c.periodic,
            "cells": list(c.grid.shape),
            "size": list(c.grid.size),
            "figures": _finite(self.figures),
            "centre_of_pressure": [v if math.isfinite(v) else None for v in c.centre_of_pressure],
            "regions": c.n_regions,
            "exact": None if self.exact is None else {"source": self.exact.source, **_finite(self.exact.figures)},
            "errors": _finite(self.errors),
            "residuals": vars(c.residuals),
            "iterations": s.nit,
            "transforms": s.transforms,
            "seconds": s.seconds,
            "peak_rss_mb": peak_memory(),
        }

    def __str__(self) -> str:
        c = self.contact
        exact = self.exact.figures if self.exact else {}
        kind = "periodic" if c.periodic else "free"
        stack = f", {len(c.layers)} layer(s)" if c.layers else ""
        lines = [
            f"{self.name} on a {kind} half-space{stack}, {c.grid.shape[0]} x {c.grid.shape[1]} cells on "
            f"{c.grid.size[0]:.6g} x {c.grid.size[1]:.6g}"
        ]
        if self.exact is not None:
            lines.append(f"beside: {self.exact.source}")
            lines.append(f"  {'':20}{'found':>14}{'exact':>14}{'error':>11}")
        for name, value in self.figures.items():
            target = exact.get("contact area" if name == "area, edge fitted" and name in self.errors else name)
            compared = f"{target:>14.6g}" if target is not None else ""
            error = f"{self.errors[name]:>+11.1e}" if name in self.errors else ""
            lines.append(f"  {name:20}{value:>14.6g}{compared}{error}")
        if "pressure, L2" in self.errors:
            lines.append(f"  {'pressure, L2 error':20}{'':28}{self.errors['pressure, L2']:>11.1e}")
        lines.append(f"  {'regions':20}{c.n_regions:>14d}")
        lines.append(f"  centre of pressure  {c.centre_of_pressure[0]:>14.6g}{c.centre_of_pressure[1]:>14.6g}")
        lines.append(f"residuals: {c.residuals}")
        lines.append(f"{c.solver.nit} iterations, {c.solver.transforms:.1f} transforms, {c.solver.seconds:.3f} s")
        return "\n".join(lines)


def _finite(figures: dict[str, float]) -> dict[str, float | None]:
    """JSON has no infinity."""
    return {name: float(value) if math.isfinite(value) else None for name, value in figures.items()}


@dataclass(frozen=True)
class Ground:
    """A half-space yet without its grid.

    Attributes
    ----------
    material : Material or None
        None: rigid, under layers.
    layers : tuple of Layer
    against : Material or None
        Of an elastic counter-body.
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
        """The homogeneous half-space of its softest part, in which a contact is at its widest."""
        materials = [m for m in (self.material, *(layer.material for layer in self.layers)) if m is not None]
        soft = min(materials, key=lambda m: m.plane_strain_modulus)
        return Ground(soft, (), self.against, False)


@dataclass(frozen=True)
class Load:
    """Force or approach, and the moment of the force about the origin or the point where it acts.

    Attributes
    ----------
    force, approach : float or None
    point : (float, float) or None
        Where the force acts; the shape is then free to tilt.
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
    def of_moment(cls, force: float, moment: tuple[float, float]) -> Load:
        """A force downwards with moments about x and y through the origin.

        Examples
        --------
        >>> Load.of_moment(10.0, (0.0, 5.0)).point
        (0.5, 0.0)
        """
        return cls(force, None, (moment[1] / force if moment[1] else 0.0, -moment[0] / force if moment[0] else 0.0))


def indent(
    shape: Any,
    ground: Ground,
    load: Load,
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
    load : Load
    cells : (int, int)
        Of the grid; an array of heights brings its own.
    size : (float, float), optional
        Of the grid; three half-widths of the contact where a closed form tells them.
    name : str, optional
        Of the shape, for the table.
    tolerance : float

    Returns
    -------
    Indentation

    Raises
    ------
    InputError
        A grid smaller than the contact (with the size needed), one without size where none can be guessed, periodic
        and free confused, a load beyond what the geometry allows.

    Examples
    --------
    >>> import fecontact as fc
    >>> steel = fc.Material(E=210e3, nu=0.3)
    >>> found = indent(fc.Sphere(10.0), Ground(steel), Load(force=100.0), cells=(64, 64))
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
    shape: Any, ground: Ground, load: Load, cells: tuple[int, int], size: tuple[float, float] | None
) -> HalfSpace:
    """The half-space with a grid that holds the contact."""
    if ground.periodic:
        if size is None:
            raise InputError("A periodic half-space needs a size: that of its period.")
        _check_repeats(shape)
        return ground.on(size, cells)
    if isinstance(shape, Cylinder) and math.isinf(shape.length):
        raise InputError(
            "An endless cylinder on a free half-space would touch it to the border of any grid: give it a length, or "
            "make the half-space periodic."
        )
    # the grid of a trial half-space does not matter to the closed form
    trial = closed_form(shape, ground.softest.on((1.0, 1.0), (2, 2)), load.force, load.approach)
    if size is None and trial is None:
        raise InputError(
            "There is no closed form that tells how wide this contact will be: give the grid a size that holds it."
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
            if side < SMALLEST_BOX * w:
                raise InputError(
                    f"The grid is smaller than the contact along {'xy'[axis]}: its side is {side:g}, the contact will "
                    f"be {2 * w:.4g} wide. Give it {BOX * w:.4g}."
                )
    return ground.on(size, cells)


def _check_repeats(shape: Any) -> None:
    """Refuse heights whose opposite borders do not meet."""
    if hasattr(shape, "heights"):
        return
    z = np.asarray(shape, dtype=float)
    if z.ndim != 2 or not np.isfinite(z).all():
        return  # told better when they are pressed
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


def _check_depth(ground: Ground, load: Load) -> None:
    """Refuse an approach that leaves nothing of the layers on a rigid base."""
    total = sum(layer.thickness for layer in ground.layers)
    if ground.material is None and load.approach is not None and load.approach >= total:
        raise InputError(
            f"The load is beyond what the geometry allows: an approach of {load.approach:g} through layers of "
            f"{total:g} on a rigid base. Small strains want a fraction of the thickness."
        )


def _check_outline(shape: Any, contact: HalfSpaceContact) -> None:
    """Refuse a round shape that is in contact up to where its lower half ends."""
    if isinstance(shape, FlatPunch) or not hasattr(shape, "heights"):
        return
    none = ~np.isfinite(contact.gap)
    active = contact.active
    beside = [active[1:] & none[:-1], active[:-1] & none[1:]]
    if not isinstance(shape, Cylinder):  # a cylinder's ends may well be in contact
        beside += [active[:, 1:] & none[:, :-1], active[:, :-1] & none[:, 1:]]
    if any(b.any() for b in beside):
        raise InputError(
            f"The load is beyond what the geometry allows: the contact reaches the outline of the "
            f"{type(shape).__name__.lower()}, beyond which it has no lower side. Take a smaller load."
        )


CURVE = ("force", "approach", "contact area", "area, edge fitted", "mean gap", "maximum pressure", "stiffness")


@dataclass(frozen=True, eq=False)
class Curve:
    """Figures of a shape on a half-space over a list of loads; made by `curve`.

    Attributes
    ----------
    steps : tuple of Indentation
    """

    steps: tuple[Indentation, ...]

    def column(self, name: str) -> Array:
        """One figure at all loads."""
        return np.array([step.figures[name] for step in self.steps])

    def rows(self) -> list[dict[str, float]]:
        """Figures of each load by name, with the number of regions."""
        return [{**{n: s.figures[n] for n in CURVE}, "regions": s.contact.n_regions} for s in self.steps]

    def save(self, path: str | Path) -> Path:
        """Write a CSV file, one row per load."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([name.replace(", ", " ").replace(" ", "_") for name in (*CURVE, "regions")])
        writer.writerows([list(map(repr, row.values())) for row in self.rows()])
        return write_atomically(path, text.getvalue())

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Any:
        """Draw the curves, see `indentplot.plot_curve`."""
        from fecontact.app.indentation.pictures import plot_curve
        from fecontact.common.units import Units

        return plot_curve(self, path, Units(length, force, stress))

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        return {"shape": self.steps[0].name, "loads": [step.as_dict() for step in self.steps]}

    def __str__(self) -> str:
        names = (*CURVE, "regions")
        head = "".join(f"{name:>19}" for name in names)
        lines = ["".join(f"{row[name]:>19.6g}" for name in names) for row in self.rows()]
        worst = max(step.contact.residuals.worst for step in self.steps)
        return "\n".join([f"{self.steps[0].name}, {len(self.steps)} loads", head, *lines, f"residuals: {worst:.1e}"])


def curve(shape: Any, ground: Ground, loads: Sequence[Load], **options: Any) -> Curve:
    """Press a shape with several loads; options as in `indent`, one grid that holds the largest for all.

    Examples
    --------
    >>> import fecontact as fc
    >>> ball, ground = fc.Sphere(10.0), Ground(fc.Material(E=1.0, nu=0.0))
    >>> found = curve(ball, ground, [Load(force=f) for f in (0.01, 0.08)], cells=(64, 64))
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
