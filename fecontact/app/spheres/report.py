"""Cases of the report, compared with its figures."""

from __future__ import annotations

from typing import Any

from fecontact.analytic import hertz
from fecontact.app.spheres.case import STEEL, Spheres
from fecontact.app.spheres.spheres import solve_spheres


def report_table(level: int = 2, **options: Any) -> str:
    """Table of all cases of the report, with its figures and Hertz.

    The report's three figures for 726.4 kgf (a = 1.7845 mm, p0 = 9990 kgf/cm2, approach 0.02548 mm) are Hertz's for 666
    kgf. They are shown but are not a target.
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
