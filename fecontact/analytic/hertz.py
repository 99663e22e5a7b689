"""Hertz contact: over a circle, an ellipse or a line."""

from fecontact.analytic.hertz_circle import CircularContact, spheres
from fecontact.analytic.hertz_ellipse import EllipticalContact, ellipse
from fecontact.analytic.hertz_line import LineContact, line
from fecontact.analytic.pair import contact_modulus

__all__ = [
    "CircularContact",
    "EllipticalContact",
    "LineContact",
    "contact_modulus",
    "ellipse",
    "line",
    "spheres",
]
