"""Elastic half-spaces on a grid of cells: Boussinesq and Love, layers, free and periodic, by fast transforms."""

from fecontact.bodies.halfspace.contact import HalfSpaceContact
from fecontact.bodies.halfspace.friction import PressStep
from fecontact.bodies.halfspace.friction_contact import FrictionContact
from fecontact.bodies.halfspace.friction_path import FrictionPath
from fecontact.bodies.halfspace.grid import Grid
from fecontact.bodies.halfspace.halfspace import HalfSpace
from fecontact.bodies.halfspace.layered import Layer
from fecontact.bodies.halfspace.load_curve import LoadCurve

__all__ = [
    "FrictionContact",
    "FrictionPath",
    "Grid",
    "HalfSpace",
    "HalfSpaceContact",
    "Layer",
    "LoadCurve",
    "PressStep",
]
