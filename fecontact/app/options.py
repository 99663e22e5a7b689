"""Names that commands take, and what they mean: cases, shapes, studies and problems; needs no numerical package."""

from __future__ import annotations

#: Radii and load of the report's test problems (Elangovan 1978, section IV), in cm and kgf; 'light' is the load without
#: a solution in the report.
CASES = {"equal": ((25.0, 25.0), 726.4), "unequal": ((25.0, 2.5), 454.0), "light": ((25.0, 25.0), 45.4)}
ELEMENTS = ("hex8", "hex20", "hex27", "ancf")
PRESSURES = ("midface", "nodal")
MODELS = ("two-bodies", "symmetric", "axisymmetric")
#: The package's own, or that of the report (`source_route`).
ROUTES = ("fast", "1978")

#: Shapes of ``fecontact halfspace`` and the options of each.
SHAPES: dict[str, tuple[str, ...]] = {
    "sphere": ("radius",),
    "paraboloid": ("radius", "radius_y"),
    "cylinder": ("radius", "length"),
    "cone": ("angle",),
    "flat": ("radius", "sides"),
    "ellipsoid": ("semi_axes",),
    "torus": ("ring", "tube"),
    "wave": ("amplitude", "wavelength"),
    "rough": ("rms_slope", "rms_height", "longest", "shortest"),
    "heights": ("file",),
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
