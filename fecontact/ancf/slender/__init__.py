"""Beams, cables and plates in absolute nodal coordinates, joints between them, and their ready examples."""

from fecontact.ancf.slender.joints import Joints
from fecontact.ancf.slender.kinds import beam, line, plate, straight, strip, thick_plate
from fecontact.ancf.slender.structure import Part, Structure

__all__ = ["Joints", "Part", "Structure", "beam", "line", "plate", "straight", "strip", "thick_plate"]
