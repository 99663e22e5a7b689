"""Figures of two spheres compared with Hertz."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fecontact.app.spheres.case import Spheres
from fecontact.bodies import ElasticBody
from fecontact.common.arrays import Array
from fecontact.results.contact_fields import ContactFields
from fecontact.results.report import peak_memory
from fecontact.results.result import ContactResult

#: Samples along each side of a face for errors of the pressure.
SAMPLES = 12


def moment_radius(contact: ContactFields, radius: Array) -> float:
    """Contact radius of a Hertz profile from its second moment; insensitive to the mesh. Zero without contact."""
    total = contact.forces.sum()
    return float(np.sqrt(2.5 * (contact.forces @ radius**2) / total)) if total > 0 else 0.0


@dataclass(frozen=True, eq=False)
class SpheresFigures:
    """Solution of two spheres compared with Hertz.

    Attributes
    ----------
    case : Spheres
    options : dict
        Options: element, pressure, model, level, edge_fit; whether there is a pressure with its root at the edge.
    result : ContactResult
    upper : ElasticBody
        The upper sphere, which is pressed down.
    fitted_radius : float
        Radius of the mesh ring.
    seconds : dict
        Wall time by stage of the main pass, 'first_pass' and 'total'.
    """

    case: Spheres
    options: dict[str, Any]
    result: ContactResult
    upper: ElasticBody
    fitted_radius: float
    seconds: dict[str, float]

    @property
    def contact(self) -> ContactFields:
        """The only contact."""
        return self.result.contacts[0]

    @cached_property
    def radius(self) -> Array:
        """Distance (n,) of the contact points from the axis."""
        return np.hypot(self.contact.points[:, 0], self.contact.points[:, 1])

    @property
    def contact_radius(self) -> float:
        """From the second moment of the forces: a^2 = 5/2 sum(F r^2) / sum(F) for a Hertz profile."""
        return moment_radius(self.contact, self.radius)

    @property
    def centre_pressure(self) -> float:
        """Pressure on the axis."""
        return float(self.contact.pressure[np.argmin(self.radius)])

    @property
    def approach(self) -> float:
        """Relative motion of the spheres' far faces."""
        down = -float(self.result.rigid_motion(self.upper).translation[2])
        return 2 * down if self.options["model"] == "symmetric" else down

    @property
    def total_force(self) -> float:
        """Force on a whole sphere; unless the model is axisymmetric, a quarter was modelled."""
        return (1 if self.options["model"] == "axisymmetric" else 4) * float(self.contact.force[2])

    @cached_property
    def pressure_l2_error(self) -> float:
        """Relative L2 error of the interpolated nodal pressure over r <= 1.2 a, weighted by area."""
        return self._l2_error(*self.contact.sampled(self.contact.pressure, SAMPLES))

    @cached_property
    def edge_pressure_l2_error(self) -> float:
        """The same of the pressure with its square root at the edge; NaN where it was not accepted."""
        (edge,) = self.result.edge_pressures
        return self._l2_error(*edge.sampled(SAMPLES)) if edge.accepted else math.nan

    def _l2_error(self, points: Array, pressure: Array, area: Array) -> float:
        exact = self.case.hertz
        r = np.hypot(points[:, 0], points[:, 1])
        inside = r <= 1.2 * exact.a
        target = exact.pressure(r[inside])
        weight = area[inside]
        return float(np.sqrt((weight * (pressure[inside] - target) ** 2).sum() / (weight * target**2).sum()))

    @property
    def errors(self) -> dict[str, float]:
        """Signed relative errors against Hertz."""
        exact = self.case.hertz
        return {
            "contact_radius": self.contact_radius / exact.a - 1,
            "centre_pressure": self.centre_pressure / exact.p0 - 1,
            "approach": self.approach / exact.approach - 1,
        }

    def as_dict(self) -> dict[str, Any]:
        """All figures, ready for JSON."""
        exact, r = self.case.hertz, self.result.residuals()
        (edge,) = self.result.edge_pressures
        return {
            "case": self.case.name,
            **self.options,
            "n_dofs": self.result.n_dofs,
            "n_dofs_factorised": self.result.n_dofs_factorised,
            "n_candidates": self.result.n_candidates,
            "n_active": self.result.n_active,
            "fitted_radius": self.fitted_radius,
            "contact_radius": self.contact_radius,
            "centre_pressure": self.centre_pressure,
            "max_pressure": self.contact.max_pressure,
            "approach": self.approach,
            "total_force": self.total_force,
            "pressure_l2_error": self.pressure_l2_error,
            "edge_pressure_l2_error": self.edge_pressure_l2_error if edge.accepted else None,
            "edge_pressure_note": edge.note,
            "errors": self.errors,
            "exact": {"a": exact.a, "p0": exact.p0, "approach": exact.approach},
            "residuals": r.as_dict(),
            "seconds": self.seconds,
            "solver": self.result.solution.solver,
            "peak_rss_mb": peak_memory(),
            "units": {"length": self.case.length, "force": self.case.unit_force},
        }
