"""Problems of ``fecontact ancf``; needs no numerical package."""

from __future__ import annotations

#: Problems and what they show.
PROBLEMS: dict[str, str] = {
    "elastica": "a cantilever under a compressive force beyond the critical one, beside the closed form",
    "circle": "a bar bent into a full circle by a moment",
    "pendulum": "a very flexible bar that falls, beside a fine solution",
    "fourbar": "a four-bar mechanism that all but folds, over two revolutions, beside rigid bars",
}
#: Elements unless given.
ELEMENTS = {"elastica": 10, "circle": 10, "pendulum": 12, "fourbar": 2}
#: Problems that measure a bar's middle, which must be a node.
EVEN = ("pendulum", "fourbar")
