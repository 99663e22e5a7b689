"""Problems of ``fecontact ancf``; needs no numerical package."""

from __future__ import annotations

#: Problems and what they show.
PROBLEMS: dict[str, str] = {
    "elastica": "a cantilever under a compressive force beyond the critical one, beside the closed form",
    "circle": "a bar bent into a full circle by a moment",
    "pendulum": "a very flexible bar that falls, beside a fine solution",
}
#: Elements unless given.
ELEMENTS = {"elastica": 10, "circle": 10, "pendulum": 12}
