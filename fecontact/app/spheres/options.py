"""The cases of ``fecontact hertz`` and the values of its options; needs no numerical package."""

from __future__ import annotations

#: Radii and load of the report's test problems (Elangovan 1978, section IV), in cm and kgf; 'light' is the load without
#: a solution in the report.
CASES = {"equal": ((25.0, 25.0), 726.4), "unequal": ((25.0, 2.5), 454.0), "light": ((25.0, 25.0), 45.4)}

ELEMENTS = ("hex8", "hex20", "hex27", "ancf")
PRESSURES = ("midface", "nodal")
MODELS = ("two-bodies", "symmetric", "axisymmetric")
#: The package's own, or that of the report (`source_route`).
ROUTES = ("fast", "1978")
