"""Tables of two spheres beside Hertz: one solution, and the report's own cases."""

from __future__ import annotations

from typing import Any

from fecontact.analytic import hertz
from fecontact.app.spheres.spheres import STEEL, Spheres, SpheresResult, solve_spheres


def table(out: SpheresResult) -> str:
    """Figures beside Hertz's, residuals and time, aligned."""
    case, exact, o = out.case, out.case.hertz, out.options
    r, e = out.result.residuals(), out.errors
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
        "",
        *(f"  {b.describe()}" for b in out.result.scene.bodies),
        f"  {_saved(out)}",
        f"  {out.result.n_candidates} candidates, {out.result.n_active} in contact; "
        f"{out.result.solution.solver}, {out.result.nit} iterations",
        f"  residuals: penetration {r.penetration:.1e}, tension {r.tension:.1e}, "
        f"complementarity {r.complementarity:.1e}, equilibrium {r.equilibrium:.1e}",
        "  seconds: " + ", ".join(f"{k} {v:.2f}" for k, v in out.seconds.items()),
    ]
    return "\n".join(lines)


def _row(name: str, value: float, exact: float, error: float) -> str:
    return f"{name:24}{value:>14.6g}{exact:>14.6g}{100 * error:>+9.2f}%"


def _saved(out: SpheresResult) -> str:
    """What was not modelled, and why it was not needed."""
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


def report_table(level: int = 2, **options: Any) -> str:
    """All cases of the report beside its own figures and Hertz.

    The report's figures for 726.4 kgf (a = 1.7845 mm, p0 = 9990 kgf/cm2, approach 0.02548 mm) all three are Hertz's for
    666 kgf; they are shown, not aimed at.
    """
    cases = [
        Spheres("equal, 454 kgf", (25.0, 25.0), 454.0, STEEL),
        Spheres("equal, 726.4 kgf", (25.0, 25.0), 726.4, STEEL),
        Spheres("equal, 45.4 kgf", (25.0, 25.0), 45.4, STEEL),
        Spheres("unequal, 454 kgf", (25.0, 2.5), 454.0, STEEL),
    ]
    head = (
        f"{'case':18}{'a [mm]':>10}{'Hertz':>10}{'error':>9}{'p0':>10}{'Hertz':>10}{'error':>9}"
        f"{'approach':>10}{'Hertz':>10}{'error':>9}{'L2':>8}{'s':>7}"
    )
    lines = [head, "-" * len(head)]
    for case in cases:
        out = solve_spheres(case, level=level, **options)
        exact, e = case.hertz, out.errors
        lines.append(
            f"{case.name:18}{10 * out.contact_radius:>10.4f}{10 * exact.a:>10.4f}{100 * e['contact_radius']:>+8.2f}%"
            f"{out.centre_pressure:>10.0f}{exact.p0:>10.0f}{100 * e['centre_pressure']:>+8.2f}%"
            f"{10 * out.approach:>10.5f}{10 * exact.approach:>10.5f}{100 * e['approach']:>+8.2f}%"
            f"{100 * out.pressure_l2_error:>7.2f}%{out.seconds['total']:>7.2f}"
        )
    at_666 = hertz.spheres((25.0, 25.0), (STEEL, STEEL), force=666.0)
    lines += [
        "",
        "The report (Elangovan 1978) prints for equal spheres at 726.4 kgf:",
        "  a = 1.7845 mm, pressure at the centre 9990 kgf/cm2, Hertz's approach 0.02548 mm, its own approach",
        "  0.04895 or 0.06131 mm (artificial support at the contact or at the sphere's centre); at 45.4 kgf no answer.",
        "Its three Hertz figures are those of 666 kgf: "
        f"{10 * at_666.a:.4f} mm, {at_666.p0:.0f} kgf/cm2, {10 * at_666.approach:.5f} mm.",
    ]
    return "\n".join(lines)
