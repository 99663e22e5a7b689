"""Closed forms of contact mechanics: pure functions, arrays in, arrays out, any consistent units.

Pressures are positive in compression, stresses in tension; z points into the body.
"""

from fecontact.analytic import (
    adhesion,
    axisymmetric,
    boussinesq,
    curvature_field,
    curved_kernel,
    cylinder,
    disc,
    elastica,
    face_loads,
    friction,
    hertz,
    layer,
    punch,
    rectangle,
    sinusoid,
)
from fecontact.common.renamed import renamed_names

__all__ = [
    "adhesion",
    "axisymmetric",
    "boussinesq",
    "curvature_field",
    "curved_kernel",
    "cylinder",
    "disc",
    "elastica",
    "face_loads",
    "friction",
    "hertz",
    "layer",
    "punch",
    "rectangle",
    "sinusoid",
]

__getattr__ = renamed_names(globals(), sheared_rectangle="rectangle")
