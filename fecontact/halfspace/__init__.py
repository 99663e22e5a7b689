"""Half-spaces on a grid of cells: compliance, contact without friction and with it, results, pictures."""

from fecontact.halfspace.adhesion import AdhesiveContact
from fecontact.halfspace.adhesion_curve import AdhesionCurve
from fecontact.halfspace.attraction import Dugdale
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.creep import CreepCoefficients, CreepCurve
from fecontact.halfspace.friction import PressStep
from fecontact.halfspace.friction_law import FallingFriction
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.layered import Layer
from fecontact.halfspace.path import FrictionPath, LoadCurve
from fecontact.halfspace.rolling import RollingContact
from fecontact.halfspace.steady import MovingContact
from fecontact.halfspace.traction_contact import FrictionContact

__all__ = [
    "AdhesionCurve",
    "AdhesiveContact",
    "CreepCoefficients",
    "CreepCurve",
    "Dugdale",
    "FallingFriction",
    "FrictionContact",
    "FrictionPath",
    "Grid",
    "HalfSpaceContact",
    "Layer",
    "LoadCurve",
    "MovingContact",
    "PressStep",
    "RollingContact",
]
