"""Names that commands take, and what they mean: cases, shapes, studies and problems; needs no numerical package."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Any

#: Exit status of a program that Ctrl-C ends: 128 and the number of the signal.
STOPPED = 130
#: Radii and load of the report's test problems (Elangovan 1978, section IV), in cm and kgf; 'light' is the load without
#: a solution in the report.
CASES = {"equal": ((25.0, 25.0), 726.4), "unequal": ((25.0, 2.5), 454.0), "light": ((25.0, 25.0), 45.4)}
ELEMENTS = ("hex8", "hex20", "hex27", "ancf")
PRESSURES = ("midface", "nodal")
MODELS = ("two-bodies", "symmetric", "axisymmetric")
#: The package's own, or that of the report (`studies.report`).
ROUTES = ("fast", "1978")
#: Hyperelastic laws of decks: as they are, or by their moduli at rest.
FINITE, SMALL = LAWS = ("finite-strain", "small-strain")


@dataclass(frozen=True)
class Parameter:
    """A parameter of a rigid shape, by its key in scene files: a number, or a list of `count` numbers.

    `argument` of the constructor and `option` of the command line are named where they differ from the key; `unit` is
    that of the key in the constructor's.
    """

    key: str
    required: bool = True
    count: int = 1
    argument: str = ""
    option: str = ""
    unit: float = 1.0


@dataclass(frozen=True)
class Shape:
    """A rigid shape: its class, its parameters, and its name on the command line, if it is there."""

    place: str
    parameters: tuple[Parameter, ...]
    option: str = ""

    @property
    def options(self) -> dict[str, Parameter]:
        """Parameters by their options of the command line."""
        return {p.option or p.key: p for p in self.parameters}

    def make(self, **given: Any) -> Any:
        """The shape of values by key."""
        values = {p: given[p.key] for p in self.parameters if p.key in given}
        return resolve_name(self.place)(
            **{p.argument or p.key: v if p.unit == 1.0 else p.unit * v for p, v in values.items()}
        )


#: Rigid shapes by their kind in scene files; `studies.closed_forms` has closed forms by the same kind.
SHAPES = {
    "plane": Shape("fecontact.bodies:Plane", (Parameter("size", False),)),
    "sphere": Shape("fecontact.bodies:Sphere", (Parameter("radius"),), "sphere"),
    "paraboloid": Shape(
        "fecontact.surfaces:Paraboloid",
        (Parameter("radius_x", option="radius"), Parameter("radius_y", False)),
        "paraboloid",
    ),
    "cylinder": Shape("fecontact.surfaces:Cylinder", (Parameter("radius"), Parameter("length", False)), "cylinder"),
    "cone": Shape(
        "fecontact.surfaces:Cone",
        (Parameter("angle_deg", argument="angle", option="angle", unit=math.pi / 180),),
        "cone",
    ),
    "flat_punch": Shape(
        "fecontact.surfaces:FlatPunch", (Parameter("radius", False), Parameter("sides", False, 2)), "flat"
    ),
    "ellipsoid": Shape("fecontact.surfaces:Ellipsoid", (Parameter("semi_axes", count=3),), "ellipsoid"),
    "torus": Shape("fecontact.surfaces:Torus", (Parameter("ring"), Parameter("tube")), "torus"),
}
#: Shapes of ``fecontact halfspace`` and the options of each: rigid ones, and surfaces.
OPTIONS: dict[str, tuple[str, ...]] = {
    **{s.option: tuple(s.options) for s in SHAPES.values() if s.option},
    "wave": ("amplitude", "wavelength"),
    "rough": ("rms_slope", "rms_height", "longest", "shortest", "hurst", "seed"),
    "heights": ("file", "height_unit", "peaks_up", "trend", "holes"),
}

#: Studies of ``fecontact friction`` and what they show.
STUDIES: dict[str, str] = {
    "mindlin": "a ball dragged within friction, beside Cattaneo and Mindlin",
    "fretting": "the same to and fro, beside Mindlin and Deresiewicz",
    "carter": "a roller that starts to roll under a tangential force, beside Carter",
    "block": "a block of finite elements on a rigid plane, held, then dragged to and fro, beside Coulomb's law",
}

#: Problems of ``fecontact ancf`` and what they show.
PROBLEMS: dict[str, str] = {
    "elastica": "a cantilever under a compressive force beyond the critical one, beside the closed form",
    "circle": "a bar bent into a full circle by a moment",
    "pendulum": "a very flexible bar that falls, beside a fine solution",
    "fourbar": "a four-bar mechanism that all but folds, over two revolutions, beside rigid bars",
}
