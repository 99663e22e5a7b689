"""The command ``fecontact halfspace``: an indentation or a curve from options, as a mapping."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.app.indentation.closed_forms import Wave
from fecontact.app.indentation.figures import Curve, Indentation
from fecontact.app.indentation.indentation import Ground, IndentationLoad, curve, indent
from fecontact.app.options import SHAPES
from fecontact.bodies import Sphere
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace import Layer
from fecontact.halfspace.grid import Grid
from fecontact.mesh.read import POLYGON_READERS, read_surface
from fecontact.surfaces import (
    Cone,
    Cylinder,
    Ellipsoid,
    Facets,
    FlatPunch,
    Paraboloid,
    Torus,
    detrend,
    read_topography,
    self_affine,
)

Options = Mapping[str, Any]
Size = tuple[float, float]
Cells = tuple[int, int]
#: A shape, and the size of the grid for finite shapes without a closed form for the contact width.
Made = tuple[Any, Size | None]

LONGEST, SHORTEST = 4, 8
"""Defaults for a rough surface: its size over the longest wave, and the shortest wave in cells."""


def run(options: Options) -> Indentation | Curve:
    """Press what the options describe.

    Parameters
    ----------
    options : mapping
        Options of ``fecontact halfspace --help``, with underscores; omitted ones are None.

    Returns
    -------
    Indentation or Curve
        A curve where `loads` are given.

    Raises
    ------
    InputError
        If an option is missing, does not apply, or has an invalid value.

    Examples
    --------
    >>> found = run({"shape": "sphere", "radius": 10.0, "E": 210e3, "nu": 0.3, "force": 100.0, "cells": [64]})
    >>> found.exact.source
    "sphere's own profile (Sneddon); Hertz where a << R"
    """
    given = {name: value for name, value in options.items() if value is not None}
    name = given["shape"]
    _refuse_foreign(name, given)
    cells, size = _pair(given.get("cells", [256]), "cells"), _pair(given.get("size"), "size")
    ground = _ground(given)
    loads = _loads(given)
    shape, cells, size = _shape(name, given, cells, size, ground.periodic)
    label = Path(given["file"]).name if name == "heights" else name
    common = {"cells": cells, "size": size, "name": label, "tolerance": given.get("tolerance", 1e-8)}
    if "loads" in given:
        return curve(shape, ground, loads, **common)
    return indent(shape, ground, loads[0], **common)


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
    base = Material(given["E"], given["nu"]) if "E" in given else None
    against = Material(*given["against"]) if "against" in given else None
    return Ground(base, layers, against, bool(given.get("periodic")))


def _layer(text: str) -> Layer:
    parts = text.split(",")
    try:
        E, nu, thickness = (float(part) for part in parts[:3])
    except ValueError:
        raise InputError(f"A layer reads like 5,0.45,2 or 5,0.45,2,frictionless; found {text!r}.") from None
    return Layer(Material(E, nu), thickness, *(part.strip() for part in parts[3:4]))


def _loads(given: Options) -> list[IndentationLoad]:
    kinds = [name for name in ("force", "approach", "loads") if name in given]
    if len(kinds) != 1:
        found = " and ".join(f"--{kind}" for kind in kinds) or "none"
        raise InputError(f"Give exactly one of --force, --approach and --loads; found {found}.")
    if "load_point" in given and "moment" in given:
        raise InputError("Give --load-point or --moment, not both: they say the same.")
    if "approach" in given:
        point = given.get("load_point", given.get("moment"))
        return [IndentationLoad(None, given["approach"], None if point is None else (point[0], point[1]))]
    forces = [given["force"]] if "force" in given else _numbers(given["loads"])
    if "moment" in given:
        IndentationLoad(forces[0])  # a force of zero has no arm
        return [IndentationLoad.of_moment(force, tuple(given["moment"])) for force in forces]
    point = tuple(given["load_point"]) if "load_point" in given else None
    return [IndentationLoad(force, None, point) for force in forces]


def _numbers(text: str) -> list[float]:
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--loads reads like 1,2,5,10; found {text!r}.") from None
    return found


def _need(given: Options, *names: str) -> list[Any]:
    missing = [name for name in names if name not in given]
    if missing:
        listed = ", ".join("--" + name.replace("_", "-") for name in missing)
        raise InputError(f"The shape {given['shape']!r} needs {listed}.")
    return [given[name] for name in names]


def _cylinder(given: Options) -> Made:
    shape = Cylinder(_need(given, "radius")[0], given.get("length", math.inf))
    return shape, None if shape.is_endless else (2.0 * shape.radius, 1.2 * shape.length)


def _flat(given: Options) -> Made:
    if "radius" not in given and "sides" not in given:
        raise InputError("The shape 'flat' needs --radius or --sides.")
    sides = tuple(given["sides"]) if "sides" in given else None
    shape = FlatPunch(given.get("radius"), sides)
    return shape, None if sides is None else (1.5 * sides[0], 1.5 * sides[1])


def _torus(given: Options) -> Made:
    shape = Torus(*_need(given, "ring", "tube"))
    return shape, (1.1 * shape.size, 1.1 * shape.size)


#: Constructors of simple shapes.
MADE: dict[str, Callable[[Options], Made]] = {
    "sphere": lambda given: (Sphere(*_need(given, "radius")), None),
    "paraboloid": lambda given: (Paraboloid(_need(given, "radius")[0], given.get("radius_y")), None),
    "cylinder": _cylinder,
    "cone": lambda given: (Cone(math.radians(*_need(given, "angle"))), None),
    "flat": _flat,
    "ellipsoid": lambda given: (Ellipsoid(tuple(*_need(given, "semi_axes"))), None),
    "torus": _torus,
}


def _refuse_foreign(shape: str, given: Options) -> None:
    """Refuse options that do not apply to the shape."""
    every = {name for names in SHAPES.values() for name in names}
    if foreign := sorted((every - set(SHAPES[shape])) & set(given)):
        known = ", ".join("--" + name.replace("_", "-") for name in SHAPES[shape])
        raise InputError(f"--{foreign[0].replace('_', '-')} says nothing about the shape {shape!r}, which has {known}.")
    own = given.get("trend", "none") != "none" or given.get("peaks_up") or "height_unit" in given
    if own and shape != "heights":
        raise InputError("--trend, --peaks-up and --height-unit go with heights from a file.")


def _shape(
    name: str, given: Options, cells: Cells, size: Size | None, periodic: bool
) -> tuple[Any, Cells, Size | None]:
    """The shape, and the cells and size of the grid, which some shapes define."""
    if name in MADE:
        shape, own_size = MADE[name](given)
        return shape, cells, size or own_size
    if name == "heights":
        return _heights(given, cells, size)
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
    return z - np.nanmin(z), (z.shape[0], z.shape[1]), surface.size
