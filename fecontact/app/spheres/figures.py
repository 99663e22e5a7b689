"""Figures of two spheres compared with Hertz, their table and their picture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.app.spheres.case import Spheres
from fecontact.bodies import ElasticBody
from fecontact.common.arrays import Array
from fecontact.common.files import save_figure
from fecontact.common.one_line import one_line
from fecontact.common.units import Units
from fecontact.results.contact_fields import ContactFields
from fecontact.results.field_map import FINENESS, field_map
from fecontact.results.pictures.contact_map import draw_field
from fecontact.results.pictures.section_curve import draw_curve
from fecontact.results.report import peak_memory
from fecontact.results.result import ContactResult

#: Samples along each side of a face for errors of the pressure.
SAMPLES = 12


def moment_radius(contact: ContactFields, radius: Array) -> float:
    """Contact radius of a Hertz profile from its second moment; insensitive to the mesh. Zero without contact."""
    total = contact.forces.sum()
    return float(np.sqrt(2.5 * (contact.forces @ radius**2) / total)) if total > 0 else 0.0


@one_line
@dataclass(frozen=True, eq=False)
class SpheresResult:
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

    def __str__(self) -> str:
        return _table(self)

    def plot(self, path: str | Path | None = None) -> Figure:
        """Plot pressure against radius with Hertz, and the pressure map; written to `path` if given."""
        return _plot(self, path)


def _table(out: SpheresResult) -> str:
    """Aligned table of figures with Hertz's, residuals and time."""
    case, exact, o = out.case, out.case.hertz, out.options
    e = out.errors
    length, force = case.length, case.unit_force
    level = o["level"] if isinstance(o["level"], int) else "own"
    lines = [
        f"Two spheres, R = {case.radii[0]:g} and {case.radii[1]:g} {length}, P = {case.force:g} {force}: "
        f"{o['element']}, {o['pressure']} pressures, {o['model']}, level {level}",
        "",
        f"{'':24}{'fecontact':>14}{'Hertz':>14}{'error':>10}",
        _row(f"contact radius [{length}]", out.contact_radius, exact.a, e["contact_radius"]),
        _row(f"centre pressure [{force}/{length}2]", out.centre_pressure, exact.p0, e["centre_pressure"]),
        _row(f"approach [{length}]", out.approach, exact.approach, e["approach"]),
        _row(f"force [{force}]", out.total_force, case.force, out.total_force / case.force - 1),
        f"{'pressure, L2 error':24}{'':>28}{100 * out.pressure_l2_error:>9.2f}%",
        _edge(out),
        "",
        *(f"  {b.describe()}" for b in out.result.scene.bodies),
        f"  {_saved(out)}",
        f"  {out.result.n_candidates} candidates, {out.result.n_active} in contact; "
        f"{out.result.solution.solver}, {out.result.nit} iterations",
        f"  residuals: {out.result.residuals()}",
        "  seconds: " + ", ".join(f"{k} {v:.2f}" for k, v in out.seconds.items()),
    ]
    return "\n".join(lines)


def _row(name: str, value: float, exact: float, error: float) -> str:
    return f"{name:24}{value:>14.6g}{exact:>14.6g}{100 * error:>+9.2f}%"


def _edge(out: SpheresResult) -> str:
    """Line on the pressure with its square root at the edge."""
    (edge,) = out.result.edge_pressures
    if not edge.accepted:
        return f"  {edge.note}"
    return f"{'  with root at the edge':24}{'':>28}{100 * out.edge_pressure_l2_error:>9.2f}%"


def _saved(out: SpheresResult) -> str:
    """Line on the modelled part and the reductions by symmetry and shared models."""
    n, once = out.result.n_dofs, out.result.n_dofs_factorised
    if out.options["model"] == "axisymmetric":
        shared = f"; {once} factorised, as the lower is the upper in another pose" if once < n else ""
        return f"modelled: the sections of both spheres, {n} dofs{shared}"
    if out.options["model"] == "symmetric":
        return f"modelled: a quarter of one sphere, {n} of {8 * n} dofs: three planes of symmetry"
    if once < n:
        return (
            f"modelled: a quarter of each sphere, {n} of {4 * n} dofs: two planes of symmetry; "
            f"{once} factorised, as the lower is the upper in another pose"
        )
    return f"modelled: a quarter of each sphere, {n} of {4 * n} dofs: two planes of symmetry"


def _plot(out: SpheresResult, path: str | Path | None) -> Figure:
    """Plot pressure over the radius with Hertz, and the pressure map of the quarter or the gap of the section."""
    case, exact, contact = out.case, out.case.hertz, out.contact
    figure = Figure(figsize=(12.0, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    near = out.radius <= 1.35 * exact.a
    points, pressure, _ = contact.sampled(contact.pressure, FINENESS)
    r = np.hypot(points[:, 0], points[:, 1])
    inside = r <= 1.35 * exact.a
    left.plot(
        r[inside], pressure[inside], ".", color="tab:orange", markersize=2, alpha=0.5, label="interpolated in the faces"
    )
    left.plot(out.radius[near], contact.pressure[near], "o", color="tab:blue", markersize=3.5, label="contact nodes")
    line = np.linspace(0.0, 1.35 * exact.a, 600)
    left.plot(line, exact.pressure(line), color="black", linewidth=1.2, label="Hertz")
    left.set_xlabel(f"radius [{case.length}]")
    left.set_ylabel(f"pressure [{case.unit_force}/{case.length}²]")
    left.set_title(
        f"R = {case.radii[0]:g} and {case.radii[1]:g} {case.length}, P = {case.force:g} {case.unit_force}: "
        f"L2 error {100 * out.pressure_l2_error:.2f} %"
    )
    left.set_ylim(bottom=0.0)
    left.legend()
    units = Units(case.length, case.unit_force, f"{case.unit_force}/{case.length}²")
    if contact.is_curve:
        draw_curve(right, field_map(contact, "gap"), units)
        right.axvline(exact.a, linestyle="--", color="tab:cyan", linewidth=1.5, label="Hertz radius")
    else:
        draw_field(right, field_map(contact, "pressure"), units)
        angle = np.linspace(0.0, np.pi / 2, 100)
        rim = exact.a * np.stack([np.cos(angle), np.sin(angle)])
        right.plot(*rim, "--", color="tab:cyan", linewidth=1.5, label="Hertz radius")
    right.legend(loc="upper left" if contact.is_curve else "upper right")
    right.set_title(
        f"{out.options['element']}, {out.options['pressure']} pressures, {out.result.n_dofs} dofs, "
        f"{out.seconds['total']:.1f} s"
    )
    return save_figure(figure, path)
