"""Contact with Coulomb friction: partial slip, rolling, torsion, adhesion under normal load, belts."""

from fecontact.analytic.friction_belt import belt_slip_angle, belt_tension
from fecontact.analytic.friction_line import LineSlip, carter, cattaneo
from fecontact.analytic.friction_round import RoundSlip, mindlin
from fecontact.analytic.friction_stick import stick_ratio
from fecontact.analytic.friction_torsion import TorsionSlip, lubkin
from fecontact.analytic.pair import dundurs

__all__ = [
    "LineSlip",
    "RoundSlip",
    "TorsionSlip",
    "belt_slip_angle",
    "belt_tension",
    "carter",
    "cattaneo",
    "dundurs",
    "lubkin",
    "mindlin",
    "stick_ratio",
]
