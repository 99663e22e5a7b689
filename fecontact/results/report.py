"""Report of a result: the table that ``print(result)`` shows.

Reduction of a problem's size by candidates, condensation and symmetry.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.common.arrays import Array, without_rounding
from fecontact.common.stopwatch import peak_memory as peak_memory

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult


def model_size(result: ContactResult) -> list[str]:
    """Report lines on the size of the problem and its reduction."""
    lines = []
    points = sum(len(c.gap) for c in result.contacts)
    if points:
        lines.append(f"{result.n_candidates} candidates out of {points} contact points")
    models = {id(b.model): b.model for b in result._elastic_bodies}
    kept = sum(m.n_retained for m in models.values())
    if kept:
        lines.append(f"{result._n_dofs_factorised} degrees of freedom condensed to {kept}")
    return lines + modelled(result.scene.bodies)


def modelled(bodies: Sequence[Body]) -> list[str]:
    """Report lines of bodies that represent more than is modelled (symmetry, sections, half-spaces)."""
    first: dict[int, ElasticBody] = {}
    twins: dict[int, str] = {}
    for elastic in elastic_among(bodies):
        before = first.setdefault(id(elastic.model), elastic)
        if before is not elastic:
            twins[id(elastic)] = before.name
    return [line for body in bodies for line in body._size_lines(twins.get(id(body), ""))]


def report(result: ContactResult) -> str:
    """The table that `print(result)` shows."""
    units = result.scene.unit_names
    what = "Tied parts" if result._only_tied else "Contact"
    lines = [f"{what} of {len(result.scene.bodies)} bodies: {result.status} by {result.solution.solver}"]
    lines += [f"  {b.describe()}" for b in result.scene.bodies]
    lines.append(
        f"  {result.n_candidates} candidates, {result.n_active} in contact, {result.nit} iterations, "
        f"{result.rounds} round(s)"
    )
    lines += [f"  compliance of {name} by {how}" for name, how in result.condensation.items()]
    if steps := result.finite_strain:
        count = " + ".join(str(each.iterations) for each in steps)
        lines.append(f"  finite strain: {len(steps)} load step(s) of {count} iterations")
    square = units.suffix("length", "²")
    for c in result.contacts:
        force = float(np.linalg.norm(c._whole.force))
        lines += [
            f"{c.label} ({c.note})" if c.note else c.label,
            f"  force on {c.bodies[0].name:<12} {_numbers(c._whole.force)}{units.suffix('force')}",
            f"  moment                {_numbers(c._whole.moment, force * c.bodies[0].size)}{units.suffix('moment')}",
            f"  area                  {c._whole.area:>13.6g}{square}   in {len(c.regions)} region(s)",
            f"  pressure max, mean    {c.max_pressure:>13.6g} {c._whole.mean_pressure:>13.6g}{units.suffix('stress')}",
        ]
        if c.active.any():
            lines.append(f"  error of {c.error_estimate}")
            lines.append(
                f"  centre of pressure    {_numbers(c.centre_of_pressure, c.bodies[0].size)}{units.suffix('length')}"
            )
        if c.overclosure is not None:
            lines.append(f"  overclosure, largest  {c.overclosure.max():>13.6g}{units.suffix('length')}")
        if c.friction is not None:
            f = c.friction
            mu = ", ".join(f"{each:g}" for each in np.atleast_1d(f.mu))
            lines += [
                f"  friction, mu {mu:<9} {_numbers(f.force, force)}{units.suffix('force')}",
                f"  area stuck, sliding   {c.stick_area:>13.6g} {c.slip_area:>13.6g}{square}",
                f"  work of friction      {f.friction_work:>13.6g}{units.suffix('moment')}   in this step",
            ]
        if len(c.regions) > 1:
            lines += [
                f"  region {k + 1}: area {r.area:.6g}, pressure max {r.max_pressure:.6g}, force {_numbers(r.force)}"
                for k, r in enumerate(c.regions)
            ]
    if text := str(result.response_error) or result._response_errors.reason:
        lines.append(f"  errors of forces and motions by the meshes: {text}")
    for s in result.springs:
        lines.append(f"{s.spring.name:<24}tension {s.tension:>13.6g}   elongation {s.elongation:>13.6g}")
    lines.append(f"Residuals: {result.residuals()}")
    lines += [f"Warning:   {text}" for text in result.warnings]
    lines += [f"Note:      {text}" for text in result.notes]
    if result.convergence is not None:
        lines += [f"  {line}" for line in str(result.convergence).splitlines()]
    stages = "  ".join(f"{k} {v:.3f}" for k, v in result.seconds.items())
    lines.append(f"Seconds:   {stages}")
    needed = "  ".join(f"{k} {v:.0f}" for k, v in result.memory.items())
    lines.append(f"Peak MB:   {needed} (of the process, by the end of each stage)")
    lines += [f"{'Saved:' if k == 0 else '':<11}{text}" for k, text in enumerate(model_size(result))]
    return "\n".join(lines)


def _numbers(v: Array, size: float = 0.0) -> str:
    return " ".join(f"{x:>13.6g}" for x in without_rounding(v, size))
