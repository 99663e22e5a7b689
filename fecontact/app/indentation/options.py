"""Shapes of ``fecontact halfspace`` and their options; needs no numerical package."""

from __future__ import annotations

#: Options of each shape.
OWN: dict[str, tuple[str, ...]] = {
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

SHAPES = tuple(OWN)
