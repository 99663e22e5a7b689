"""Pictures of two spheres: pressure against Hertz, and pressure map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fecontact.app.spheres.figures import SpheresFigures
from fecontact.common.files import save_figure
from fecontact.common.units import Units
from fecontact.results.field_map import FINENESS
from fecontact.results.pictures.contact_map import draw_field
from fecontact.results.pictures.section_curve import draw_curve


def plot_spheres(out: SpheresFigures, path: str | Path | None = None) -> Figure:
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
        draw_curve(right, contact, "gap", units)
        right.axvline(exact.a, linestyle="--", color="tab:cyan", linewidth=1.5, label="Hertz radius")
    else:
        draw_field(right, contact, contact.pressure, "pressure", units)
        angle = np.linspace(0.0, np.pi / 2, 100)
        rim = exact.a * np.stack([np.cos(angle), np.sin(angle)])
        right.plot(*rim, "--", color="tab:cyan", linewidth=1.5, label="Hertz radius")
    right.legend(loc="upper left" if contact.is_curve else "upper right")
    right.set_title(
        f"{out.options['element']}, {out.options['pressure']} pressures, {out.result.n_dofs} dofs, "
        f"{out.seconds['total']:.1f} s"
    )
    return save_figure(figure, path)
