"""Beams, cables and plates in absolute nodal coordinates, joints between them, and their ready examples."""

from fecontact.ancf.slender.corotational import CorotationalBeam
from fecontact.ancf.slender.kinds import beam, line, plate, strip, thick_plate
from fecontact.ancf.slender.members import touching_members
from fecontact.ancf.slender.structure import Part, Structure, straight
from fecontact.ancf.slender.trace import touching
from fecontact.ancf.system.joints import Joints

__all__ = [
    "CorotationalBeam",
    "Joints",
    "Part",
    "Structure",
    "beam",
    "line",
    "plate",
    "straight",
    "strip",
    "thick_plate",
    "touching",
    "touching_members",
]
