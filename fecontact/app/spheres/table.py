"""Table of two spheres compared with Hertz."""

from __future__ import annotations

from fecontact.app.spheres.figures import SpheresFigures


def table(out: SpheresFigures) -> str:
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


def _edge(out: SpheresFigures) -> str:
    """Line on the pressure with its square root at the edge."""
    (edge,) = out.result.edge_pressures
    if not edge.accepted:
        return f"  {edge.note}"
    return f"{'  with root at the edge':24}{'':>28}{100 * out.edge_pressure_l2_error:>9.2f}%"


def _saved(out: SpheresFigures) -> str:
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
