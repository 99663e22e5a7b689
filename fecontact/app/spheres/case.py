"""Cases of two spheres, their load, and Hertz's solution."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fecontact.analytic import hertz
from fecontact.app import options
from fecontact.common.material import Material


@dataclass(frozen=True)
class Spheres:
    """Two spheres of one material, pressed together.

    Attributes
    ----------
    name : str
    radii : (float, float)
        Either may be the smaller; both are convex.
    force : float
    material : Material
    length, unit_force : str
        Units, for tables.
    """

    name: str
    radii: tuple[float, float]
    force: float
    material: Material
    length: str = "cm"
    unit_force: str = "kgf"

    @property
    def hertz(self) -> hertz.CircularContact:
        """Hertz's solution."""
        return hertz.spheres(self.radii, (self.material, self.material), force=self.force)

    @property
    def scale_radius(self) -> float:
        """Contact radius by dimensional analysis, (P R / pi E*)^(1/3): p ~ P / (pi a^2) ~ E* a / R."""
        radius = 1 / (1 / self.radii[0] + 1 / self.radii[1])
        modulus = self.material.plane_strain_modulus / 2
        return (self.force * radius / (math.pi * modulus)) ** (1 / 3)


#: In kgf and cm.
STEEL = Material(E=2.0e6, nu=0.3)
#: The report's test problems.
CASES = {name: Spheres(name, radii, force, STEEL) for name, (radii, force) in options.CASES.items()}
