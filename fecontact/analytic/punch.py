"""Rigid frictionless punches on a half-space: flat, tilted flat, cone and power law."""

from fecontact.analytic.punch_flat import FlatPunch, flat
from fecontact.analytic.punch_power import PowerPunch, cone, power

__all__ = ["FlatPunch", "PowerPunch", "cone", "flat", "power"]
