"""Beams, cables and plates in absolute nodal coordinates, joints between them, and their ready examples."""

from collections.abc import Sequence

from fecontact.ancf.slender.corotational import CorotationalBeam
from fecontact.ancf.slender.kinds import beam, line, strip
from fecontact.ancf.slender.laminate import Lamina, Laminate
from fecontact.ancf.slender.shells import plate, shell, thick_plate
from fecontact.ancf.slender.structure import Part, Structure, straight
from fecontact.ancf.slender.surface import Surface
from fecontact.ancf.system.joints import Joints
from fecontact.bodies.rigid import RigidBody
from fecontact.common.errors import InputError
from fecontact.common.renamed import warn
from fecontact.contact.contact import Contact

__all__ = [
    "CorotationalBeam",
    "Joints",
    "Lamina",
    "Laminate",
    "Part",
    "Structure",
    "Surface",
    "beam",
    "line",
    "plate",
    "shell",
    "straight",
    "strip",
    "thick_plate",
    "touching",
    "touching_members",
]


def touching(
    structures: Sequence[Structure], number_of: int, body: RigidBody, *, offset: float = 0.0, friction: float = 0.0,
    elements: Sequence[int] | None = None,
) -> Contact:  # fmt: skip
    """Former name of `Contact` with the side of a structure; it warns."""
    warn("touching(..) is now Contact(structure.side(offset, elements), body, friction=..); it will be removed.", 3)
    return Contact(_one(structures, number_of).side(offset, elements), body, friction=friction)


def touching_members(
    structures: Sequence[Structure], slave: int, master: int, *, offsets: tuple[float, float], friction: float = 0.0,
    elements: Sequence[int] | None = None,
) -> Contact:  # fmt: skip
    """Former name of `Contact` with the sides of two structures; it warns."""
    warn("touching_members(..) is now Contact(one.side(r_1), other.side(r_2), friction=..); it will be removed.", 3)
    sides = _one(structures, slave).side(offsets[0], elements), _one(structures, master).side(offsets[1])
    return Contact(*sides, friction=friction)


def _one(structures: Sequence[Structure], k: int) -> Structure:
    if not 0 <= k < len(structures):
        raise InputError(f"There are {len(structures)} structures, counted from 0; found {k}.", code="unknown")
    return structures[k]
