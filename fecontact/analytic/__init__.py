"""Closed forms of contact mechanics: pure functions, arrays in, arrays out, any consistent units."""

from fecontact.analytic import disc, hertz

__all__ = ["disc", "hertz"]
