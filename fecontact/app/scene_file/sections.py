"""Sections of a scene file: the shapes of plane and axisymmetric bodies."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from fecontact.app.scene_file.meshes import Arguments, choice, divisions, integer, number, numbers
from fecontact.mesh import section_shapes as sections
from fecontact.mesh.section_mesh import SectionMesh


def _cap(radius: float = math.inf, **given: Any) -> SectionMesh:
    """A cap, flat unless it has a radius."""
    return sections.cap(radius, **given)


_ELEMENT = choice(tuple(sections.ELEMENTS))
_GRADED: Arguments = {"level": integer, "element": _ELEMENT}

SHAPES: dict[str, tuple[Callable[..., SectionMesh], Arguments]] = {
    "rectangle": (
        sections.rectangle,
        {"size!": numbers(2), "divisions!": divisions(2), "start": number, "element": _ELEMENT},
    ),
    "ring": (
        sections.ring,
        {"inner!": number, "outer!": number, "height!": number, "divisions!": divisions(2), "element": _ELEMENT},
    ),
    "annulus": (
        sections.annulus,
        {"inner!": number, "outer!": number, "divisions": divisions(2), "element": _ELEMENT},
    ),
    "cap": (_cap, {"radius": number, "extent!": number, "depth!": number, "contact_radius!": number, **_GRADED}),
    "half_disc": (sections.half_disc, {"radius!": number, "contact_radius": number, **_GRADED}),
}
