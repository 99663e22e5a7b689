"""Hertz contact: circle, ellipse and line."""

from fecontact.analytic.hertz_circle import CircularContact, spheres
from fecontact.analytic.modulus import contact_modulus

__all__ = ["CircularContact", "contact_modulus", "spheres"]
