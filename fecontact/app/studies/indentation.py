"""Indentation of a half-space by a rigid shape, with its closed form where there is one, for one or several loads."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Picture

from fecontact.app.options import OPTIONS, SHAPES
from fecontact.app.studies.closed_forms import Exact, Wave, closed_form
from fecontact.app.studies.study import Figure, Study, compared, finite
from fecontact.bodies import HalfSpace
from fecontact.common.arrays import Array, without_rounding
from fecontact.common.checks import among, positive
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.common.viscoelastic import Viscoelastic
from fecontact.halfspace import Dugdale, HalfSpaceContact, Layer
from fecontact.halfspace.friction import PressStep
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.pictures import plot_over_force
from fecontact.halfspace.pressable import PASSES
from fecontact.halfspace.pressing import Load
from fecontact.mesh.read import POLYGON_READERS, read_surface
from fecontact.results.report import peak_memory
from fecontact.surfaces import Facets, detrend, fill_holes, read_topography, self_affine
from fecontact.surfaces.rigid.shapes import Indenter

Options = Mapping[str, Any]
Size = tuple[float, float]
Cells = tuple[int, int]

BOX = 3.0
"""Default side of a grid, in half-widths of the contact."""

MIN_BOX = 2.2
"""Least side of a free grid in half-widths of the contact; less is refused before a solve."""

STEEP = 5.0
"""Jump of heights across the border of a period, in rms differences of neighbours, above which they do not repeat."""

LONGEST, SHORTEST = 4, 8
"""Defaults for a rough surface: its size over the longest wave, and the shortest wave in cells."""

#: Figures in the rows, in this order.
ROW = ("force", "approach", "area", "mean gap", "maximum pressure", "stiffness", "drag", "adhesive area", *PASSES)


#: Words for figures that only some contacts have.
MORE = {
    "plastic_area": "plastic area", "max_dent": "largest dent", "drag": "drag", "drag_error": "error of the drag",
    "worn_volume": "worn volume", "worn_depth": "worn depth", "adhesive_area": "adhesive area", "energy": "energy",
    "stability": "stability", "law_residual": "law residual",
}  # fmt: skip


@dataclass(frozen=True)
class Ground:
    """A half-space without its grid.

    Attributes
    ----------
    material : Material, Viscoelastic or None
        None: a rigid base under layers.
    layers : tuple of Layer
    against : Material or None
        Material of an elastic counter-body.
    periodic : bool
    """

    material: Material | Viscoelastic | None
    layers: tuple[Layer, ...] = ()
    against: Material | None = None
    periodic: bool = False

    def on(self, size: Size, cells: Cells) -> HalfSpace:
        """The half-space with a grid."""
        return HalfSpace(self.material, size, cells, self.periodic, layers=self.layers, against=self.against)

    @property
    def softest(self) -> Ground:
        """The homogeneous half-space of its softest material, for the widest contact."""
        base: Any = getattr(self.material, "relaxed", self.material)
        materials = [m for m in (base, *(layer.material for layer in self.layers)) if m is not None]
        soft = min(materials, key=lambda m: m.plane_strain_modulus)
        return Ground(soft, (), self.against, False)


def indent(
    shape: Any,
    ground: Ground,
    load: Load,
    *,
    cells: Cells = (256, 256),
    size: Size | None = None,
    name: str | None = None,
    tolerance: float = 1e-8,
    dent: Array | float = 0.0,
    also: Sequence[str] = (),
    **law: Any,
) -> Study:
    """Press a rigid shape on a half-space.

    Parameters
    ----------
    shape : surface with `heights`, or (nx, ny) array of heights
    ground : Ground
    load : Load
        With a point if the shape is free to tilt.
    cells : (int, int)
        Cells of the grid; an array of heights defines its own.
    size : (float, float), optional
        Size of the grid; by default three half-widths of the contact from the closed form.
    name : str, optional
        Name of the shape, for the table.
    tolerance : float
    dent : (nx, ny) array
        By loads before.
    also : sequence of str
        More figures, of `PASSES`.
    **law
        hardness, velocity or adhesion, as in `HalfSpace.press`; closed forms are elastic and left out.

    Returns
    -------
    Study
        `solved` is the `HalfSpaceContact`.

    Raises
    ------
    InputError
        If the grid is smaller than the contact (the message gives the size needed) or has no size and no closed form,
        if periodic and free are mixed up, or if the load is too large for the geometry.

    Examples
    --------
    >>> import fecontact as fc
    >>> steel = fc.Material(E=210e3, nu=0.3)
    >>> found = indent(fc.Sphere(10.0), Ground(steel), Load(100.0, None, None), cells=(64, 64))
    >>> abs(found.errors["approach"]) < 1e-3
    True
    """
    if load.approach is not None:
        positive("the approach", load.approach)
    half = _grid(shape, ground, load, cells, size)
    _check_depth(ground, load)
    if half.periodic and load.point is not None:
        raise InputError(
            "A periodic surface cannot tilt, for then it would not repeat: leave out the load point (or moment), or "
            "make the half-space free."
        )
    exact = None if law else closed_form(shape, half, load)
    pressed = half.heights_of(shape) + dent if np.any(dent) else shape
    contact = half.press(
        pressed, force=load.force, approach=load.approach, load_point=load.point, tolerance=tolerance, **law
    )
    _check_outline(shape, contact)
    return _study(name or type(shape).__name__, half, contact, exact, also)


def curve(shape: Any, ground: Ground, loads: Sequence[Load], **options: Any) -> Study:
    """Press a shape with several loads; options as in `indent`, with one grid for the largest load.

    With a hardness each load meets the dents of those before.

    Examples
    --------
    >>> import fecontact as fc
    >>> ball, ground = fc.Sphere(10.0), Ground(fc.Material(E=1.0, nu=0.0))
    >>> found = curve(ball, ground, [Load(f, None, None) for f in (0.01, 0.08)], cells=(64, 64))
    >>> first, last = (step.figures["approach"].found for step in found.solved)
    >>> abs(last / first / 4 - 1) < 0.01
    True
    """
    if not loads:
        raise InputError("A curve needs at least one load.")
    if options.get("size") is None:
        largest = max(loads, key=lambda load: load.force or load.approach or 0.0)
        cells = options.get("cells", (256, 256))
        options = {**options, "size": _grid(shape, ground, largest, cells, None).grid.size}
    steps: list[Study] = []
    dent: Array | float = 0.0
    for load in loads:
        steps.append(indent(shape, ground, load, dent=dent, **options))
        dent = dent if steps[-1].solved.dent is None else dent + steps[-1].solved.dent
    contacts = [step.solved for step in steps]
    error = max((contact.error_estimate for contact in contacts), key=lambda estimate: estimate.pressure)
    notes = [f"residuals: {max(c.residuals.worst for c in contacts):.1e}", f"largest error of {error}"]
    notes += [f"Warning: At the force {c.force:g}: {text}" for c in contacts for text in c.warnings]
    title = f"{steps[0].data['shape']}, {len(steps)} loads"
    rows = Table(steps[0].rows.columns, [row for step in steps for row in step.rows.rows])
    data = {"shape": steps[0].data["shape"], "loads": [step.data for step in steps]}
    return Study(title, {}, rows, lambda units: _over_force(steps, title, units), data, tuple(steps), notes=notes)


def _over_force(steps: Sequence[Study], title: str, units: Units) -> Picture:
    """Approach, area, stiffness and mean gap over the force, with the closed form where there is one."""
    stiffness = "stiffness" + (f" [{units.force}/{units.length}]" if units.force and units.length else "")
    labels = {
        "approach": units.axis_label("approach", "length"),
        "area": "area" + (f" [{units.length}²]" if units.length else ""),
        "stiffness": stiffness,
        "drag": units.axis_label("drag", "force"),
        **{name: name for name in PASSES},
        "mean gap": units.axis_label("mean gap", "length"),
    }
    panels = {}
    for name, label in labels.items():
        if name not in steps[0].figures:
            continue
        figures = [step.figures[name] for step in steps]
        known = np.array([np.nan if f.exact is None else f.exact for f in figures])
        panels[label] = {"found": np.array([f.found for f in figures]), "exact": known}
    forces, yields = np.array([step.figures["force"].found for step in steps]), steps[0].solved.dent is not None
    return plot_over_force(forces, panels, title, units, in_order=yields)


def _study(name: str, half: HalfSpace, c: HalfSpaceContact, exact: Exact | None, also: Sequence[str] = ()) -> Study:
    """The study of a contact, with the tilt under an eccentric load."""
    found = {
        "force": c.force,
        "approach": c.approach,
        "area": c.figures["area"],
        "area of its cells": c.point_area,
        "maximum pressure": c.max_pressure,
        "mean pressure": c.figures["mean_pressure"],
        "mean gap": c.mean_gap,
    }
    if c.has_stiffness:
        found["stiffness"] = half.stiffness(c)
    found |= {what: c.figures[name] for name, what in MORE.items() if name in c.figures}
    found |= {what: PASSES[what](c) for what in also}
    if any(c.tilt):
        found["tilt (rad)"] = math.hypot(*c.tilt)
    known = exact.figures if exact else {}
    figures = {what: Figure(value, known.get(what)) for what, value in found.items()}
    beside = compared(figures)
    if exact is not None and exact.pressure is not None:
        figures["pressure, L2"] = Figure(_pressure_error(c, exact), 0.0)
        beside["errors"]["pressure, L2"] = figures["pressure, L2"].found
    data = {
        "shape": name,
        "periodic": c.periodic,
        "cells": list(c.grid.shape),
        "size": list(c.grid.size),
        **beside,
        "centre_of_pressure": [v if math.isfinite(v) else None for v in c.centre_of_pressure],
        "regions": c.n_regions,
        "exact": None if exact is None else {"source": exact.source, **finite(known)},
        "error_estimate": c.error_estimate.summary(),
        "warnings": list(c.warnings),
        "residuals": c.residuals.as_dict(),
        "iterations": c.solver.nit,
        "transforms": c.solver.transforms,
        "seconds": c.solver.seconds,
        "peak_rss_mb": peak_memory(),
    }
    kind, stack = "periodic" if c.periodic else "free", f", {len(c.layers)} layer(s)" if c.layers else ""
    cells, sides = " x ".join(map(str, c.grid.shape)), " x ".join(f"{side:.6g}" for side in c.grid.size)
    centre = without_rounding(np.array(c.centre_of_pressure), max(c.grid.size))
    notes = [
        f"regions: {c.n_regions}",
        f"centre of pressure: {', '.join(f'{x:.6g}' for x in centre)}",
        f"residuals: {c.residuals}",
        f"error of {c.error_estimate}",
        *(f"Warning: {text}" for text in c.warnings),
        f"{c.solver.nit} iterations, {c.solver.transforms:.1f} transforms, {c.solver.seconds:.3f} s",
    ]
    row = {**{column.replace(" ", "_"): found[column] for column in ROW if column in found}, "regions": c.n_regions}
    return Study(
        f"{name} on a {kind} half-space{stack}, {cells} cells on {sides}",
        figures,
        Table(list(row), [tuple(row.values())]),
        lambda units: _picture(c, exact, units, name),
        data,
        c,
        exact.source if exact else "",
        notes,
    )


def _pressure_error(contact: HalfSpaceContact, exact: Exact) -> float:
    """Relative difference of the pressures from the closed form in the L2 norm."""
    assert exact.pressure is not None
    x, y = contact.grid.x[:, None], contact.grid.y[None, :]
    where = np.broadcast_to(exact.compared(x, y), contact.grid.shape)
    target = np.broadcast_to(exact.pressure(x, y), contact.grid.shape)[where]
    return float(np.linalg.norm(contact.pressure[where] - target) / np.linalg.norm(target))


def _picture(contact: HalfSpaceContact, exact: Exact | None, units: Units, name: str) -> Picture:
    """Pressure, gap, displacement and stress below the peak, with the edge of the closed form's contact."""
    picture = contact.picture(units, name)
    if exact is not None and exact.pressure is not None and not contact.periodic:
        axes, angle, (a, b) = picture.axes[0], np.linspace(0, 2 * np.pi, 200), exact.half_widths
        axes.plot(a * np.cos(angle), b * np.sin(angle), "--", color="tab:cyan", linewidth=1.2, label="exact edge")
        axes.legend(loc="upper right", fontsize="small")
    return picture


def _asked(shape: Any) -> Indenter:
    """The shape, or defaults for user-defined shapes and heights."""
    return shape if isinstance(shape, Indenter) else Indenter()


def _grid(shape: Any, ground: Ground, load: Load, cells: Cells, size: Size | None) -> HalfSpace:
    """The half-space with a grid that contains the contact."""
    if ground.periodic:
        if size is None:
            raise InputError("A periodic half-space needs a size: that of its period.")
        _check_repeats(shape)
        return ground.on(size, cells)
    if _asked(shape).is_endless:
        raise InputError(
            "An endless cylinder on a free half-space would touch it to the border of any grid: give it a length, or "
            "make the half-space periodic."
        )
    # the closed form does not depend on the trial half-space's grid
    trial = closed_form(shape, ground.softest.on((1.0, 1.0), (2, 2)), Load(load.force, load.approach, None))
    if size is None:
        if trial is None:
            raise InputError(
                "There is no closed form for the width of this contact: give the grid a size that contains it."
            )
        box = (1.2 if ground.layers else 1.0) * BOX
        return ground.on((box * trial.half_widths[0], box * trial.half_widths[1]), cells)
    for axis, (side, w) in enumerate(zip(size, trial.half_widths if trial and not ground.layers else (), strict=False)):
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


def _check_depth(ground: Ground, load: Load) -> None:
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
    if any(b and not is_open for b, is_open in zip(beside, _asked(shape).open_ends, strict=True)):
        raise InputError(
            f"The load is beyond what the geometry allows: the contact reaches the outline of the "
            f"{type(shape).__name__.lower()}, beyond which it has no lower side. Take a smaller load."
        )


def run(options: Options) -> Study:
    """Press what the options of ``fecontact halfspace`` describe; with `loads`, a curve.

    Parameters
    ----------
    options : mapping
        Options of ``fecontact halfspace --help``, with underscores; omitted ones are None.

    Raises
    ------
    InputError
        If an option is missing, does not apply, or has an invalid value.

    Examples
    --------
    >>> found = run({"shape": "sphere", "radius": 10.0, "E": 210e3, "nu": 0.3, "force": 100.0, "cells": [64]})
    >>> found.source
    "sphere's own profile (Sneddon); Hertz where a << R"
    """
    given = {name: value for name, value in options.items() if value is not None}
    name = given["shape"]
    _refuse_foreign(name, given)
    cells, size = _pair(given.get("cells", [256]), "cells"), _pair(given.get("size"), "size")
    ground = _ground(given)
    loads = [] if "adhesion" in given else _loads(given)
    shape, cells, size = _shape(name, given, cells, size, ground.periodic)
    label = Path(given["file"]).name if name == "heights" else name
    common = {"cells": cells, "size": size, "name": label, "tolerance": given.get("tolerance", 1e-8)}
    common["also"] = given.get("also", "").split(",") if "also" in given else []
    common |= {law: given[law] for law in ("hardness", "velocity") if law in given}
    if "adhesion" in given:
        return _adhesive(shape, ground, given, cells, size, label)
    for column in common["also"]:
        among("also", column, PASSES)
    if "wear" in given:
        return _worn(shape, ground, given, loads, common)
    if "loads" in given:
        return curve(shape, ground, loads, **common)
    return indent(shape, ground, loads[0], **common)


def _adhesive(shape: Any, ground: Ground, given: Options, cells: Cells, size: Size | None, name: str) -> Study:
    """The study of one state of a shape that adheres, or of a curve through approaches."""
    if size is None:
        raise InputError("With --adhesion the contact has no closed form for its width: give the grid a --size.")
    half, law = ground.on(size, cells), Dugdale(*_numbers(given["adhesion"], "adhesion", 2))
    refused = ["hardness", "velocity", "load_point", "moment", "loads"]
    refused += ["force", "approach"] if "approaches" in given else []
    if others := ", ".join("--" + key.replace("_", "-") for key in refused if key in given):
        raise InputError(f"With --adhesion {'and --approaches ' * ('approaches' in given)}leave out {others}.")
    if ground.periodic:
        _check_repeats(shape)
    common = {"adhesion": law, "tolerance": given.get("tolerance", 1e-8)}
    if "approaches" not in given:
        contact = half.press(shape, force=given.get("force"), approach=given.get("approach"), **common)
        return _study(name, half, contact, None)
    found = half.curve(shape, approaches=_numbers(given["approaches"], "approaches"), **common)
    data = {"shape": name, "states": [finite(row) for row in found.rows()], "pull_off": found.pull_off}
    data |= {"hysteresis": found.hysteresis, "warnings": list(found.warnings)}
    return Study(f"{name} with adhesion", {}, found.table, lambda units: found.plot(units=units), data, found)


def _worn(shape: Any, ground: Ground, given: Options, loads: Sequence[Load], common: dict[str, Any]) -> Study:
    """The study of a shape that has slid in its place, without friction, and worn."""
    refused = ("hardness", "velocity", "load_point", "moment", "loads")
    if others := ", ".join("--" + key.replace("_", "-") for key in refused if key in given):
        raise InputError(f"With --wear leave out {others}.")
    coefficient, way = _numbers(given["wear"], "wear", 2)
    half, load = _grid(shape, ground, loads[0], common["cells"], common["size"]), loads[0]
    _check_depth(ground, load)
    steps = [PressStep(load.force, load.approach, shift=(x, 0.0)) for x in (0.0, positive("the length of --wear", way))]
    path = half.press_path(shape, steps, 0.0, common["tolerance"], wear=coefficient, progress=False)
    _check_outline(shape, path.last)
    return _study(f"{common['name']} worn", half, path.last, None, common["also"])


def _pair(values: Any, name: str) -> Any:
    """Two values, the second as the first unless given."""
    if values is None:
        return None
    if len(values) > 2:
        raise InputError(f"--{name} takes one or two numbers, along x and y; found {len(values)}.")
    return values[0], values[-1]


def _ground(given: Options) -> Ground:
    layers = tuple(_layer(text) for text in given.get("layer", ()))
    if "E" not in given and not layers:
        raise InputError("Give the half-space's modulus with --E (and --nu), or layers on a rigid base with --layer.")
    base: Any = Material(given["E"], given["nu"]) if "E" in given else None
    if "prony" in given:
        base = Viscoelastic(base, [(g, t) for g, t in (_numbers(text, "prony", 2) for text in given["prony"])])
    against = Material(*given["against"]) if "against" in given else None
    return Ground(base, layers, against, bool(given.get("periodic")))


def _layer(text: str) -> Layer:
    parts = text.split(",")
    try:
        E, nu, thickness = (float(part) for part in parts[:3])
    except ValueError:
        raise InputError(f"A layer reads like 5,0.45,2 or 5,0.45,2,frictionless; found {text!r}.") from None
    return Layer(Material(E, nu), thickness, *(part.strip() for part in parts[3:4]))


def _loads(given: Options) -> list[Load]:
    if "approaches" in given:
        raise InputError("--approaches are of a curve with --adhesion; for one load give --approach.")
    kinds = [name for name in ("force", "approach", "loads") if name in given]
    if len(kinds) != 1:
        found = " and ".join(f"--{kind}" for kind in kinds) or "none"
        raise InputError(f"Give exactly one of --force, --approach and --loads; found {found}.")
    if "load_point" in given and "moment" in given:
        raise InputError("Give --load-point or --moment, not both: they say the same.")
    point = tuple(given["load_point"]) if "load_point" in given else None
    if "approach" in given:
        return [Load(None, given["approach"], tuple(given["moment"]) if "moment" in given else point)]
    forces = [given["force"]] if "force" in given else _numbers(given["loads"], "loads")
    loads = [Load(force, None, point) for force in forces]
    if "moment" not in given:
        return loads
    # moments about x and y through the origin; a force of zero, which has no arm, is refused above
    about_x, about_y = given["moment"]
    return [Load(force, None, (about_y / force, -about_x / force)) for force in forces]


def _numbers(text: str, option: str, count: int | None = None) -> list[float]:
    parts = text.split(",")
    try:
        if len(parts) == (count or len(parts)):
            return [float(part) for part in parts]
    except ValueError:
        pass
    raise InputError(f"--{option} reads like {'1,2,5,10'[: 2 * count - 1 if count else None]}; found {text!r}.")


def _need(given: Options, *names: str) -> list[Any]:
    missing = [name for name in names if name not in given]
    if missing:
        listed = ", ".join("--" + name.replace("_", "-") for name in missing)
        raise InputError(f"The shape {given['shape']!r} needs {listed}.")
    return [given[name] for name in names]


def _refuse_foreign(shape: str, given: Options) -> None:
    """Refuse options that do not apply to the shape."""
    every = {name for names in OPTIONS.values() for name in names}
    if foreign := sorted((every - set(OPTIONS[shape])) & set(given)):
        known = ", ".join("--" + name.replace("_", "-") for name in OPTIONS[shape])
        raise InputError(f"--{foreign[0].replace('_', '-')} says nothing about the shape {shape!r}, which has {known}.")


def _shape(
    name: str, given: Options, cells: Cells, size: Size | None, periodic: bool
) -> tuple[Any, Cells, Size | None]:
    """The shape, and the cells and size of the grid, which some shapes define."""
    if name == "heights":
        return _heights(given, cells, size)
    if name not in ("wave", "rough"):
        shape = _rigid(name, given)
        return shape, cells, size or _own_size(name, shape)
    if size is None:
        raise InputError(f"The shape {name!r} needs --size, that of its period.")
    if not periodic:
        raise InputError(
            f"The shape {name!r} repeats: give --periodic. On a free half-space it would end abruptly at the border of "
            "the grid."
        )
    if name == "wave":
        (amplitude,) = _need(given, "amplitude")
        wavelength = given.get("wavelength", size[0])
        if abs(size[0] / wavelength - round(size[0] / wavelength)) > 1e-9:
            raise InputError(f"The size {size[0]:g} is no whole number of waves of {wavelength:g}.")
        return Wave(amplitude, wavelength), cells, size
    size, cells = Grid(size, cells).size, Grid(size, cells).shape
    longest = given.get("longest", max(size) / LONGEST)
    shortest = given.get("shortest", SHORTEST * max(s / n for s, n in zip(size, cells, strict=True)))
    rough = self_affine(
        cells,
        size,
        hurst=given.get("hurst", 0.8),
        seed=given.get("seed", 1),
        rms_height=given.get("rms_height"),
        rms_slope=given.get("rms_slope"),
        longest=longest,
        shortest=shortest,
    )
    return rough.z - rough.z.min(), cells, size


def _rigid(name: str, given: Options) -> Any:
    """A rigid shape of its options."""
    (shape,) = (s for s in SHAPES.values() if s.option == name)
    _need(given, *(option for option, p in shape.options.items() if p.required))
    if name == "flat" and "radius" not in given and "sides" not in given:
        raise InputError("The shape 'flat' needs --radius or --sides.")
    values = {p.key: given[option] for option, p in shape.options.items() if option in given}
    return shape.make(**{key: tuple(v) if isinstance(v, list) else v for key, v in values.items()})


def _own_size(name: str, shape: Any) -> Size | None:
    """Size of the grid for finite shapes without a closed form for the width of the contact."""
    if name == "cylinder" and not shape.is_endless:
        return 2.0 * shape.radius, 1.2 * shape.length
    if name == "flat" and shape.sides is not None:
        return 1.5 * shape.sides[0], 1.5 * shape.sides[1]
    return (1.1 * shape.size, 1.1 * shape.size) if name == "torus" else None


def _heights(given: Options, cells: Cells, size: Size | None) -> tuple[Any, Cells, Size | None]:
    (file,) = _need(given, "file")
    path = Path(file)
    if path.suffix.lower() in POLYGON_READERS:
        return Facets(read_surface(path)), cells, size
    surface = read_topography(path, given.get("height_unit"), None if size is None else Grid(size, (2, 2)).size)
    if surface.size is None:
        raise InputError(f"{path.name} does not give its size: set it with --size.")
    z = -surface.z if given.get("peaks_up") else surface.z
    if given.get("trend", "none") != "none":
        z = detrend(z, given["trend"])
    if holes := given.get("holes"):
        z = fill_holes(z) if holes == "fill" else np.where(np.isnan(z), np.inf, z)
    return z - np.nanmin(z), (z.shape[0], z.shape[1]), surface.size
