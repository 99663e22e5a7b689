"""Steady rolling of a curved body on a plane of the same material, at one creepage or several."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fecontact.app.studies.closed_forms import closed_form
from fecontact.app.studies.study import Figure, Study
from fecontact.bodies import HalfSpace
from fecontact.common import checks
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.table import Table
from fecontact.halfspace import CreepCurve
from fecontact.halfspace.pressing import Load
from fecontact.surfaces import Paraboloid

#: Side of the grid in half-widths of the contact.
BOX = 2.4


def run(options: Mapping[str, Any]) -> Study:
    """Roll a body, or follow creep curves.

    Parameters
    ----------
    options : mapping
        Options of ``fecontact roll --help``; ``creepage`` is a list of pairs.

    Raises
    ------
    InputError
        For creepages with a tangential force, or numbers that do not fit.

    Examples
    --------
    >>> given = {"radius": 1.0, "radius_y": None, "E": 1.0, "nu": 0.25, "force": 1e-4, "friction": 0.3, "cells": 24}
    >>> given |= {"tangential": None, "spin": [0.0], "towards": (1.0, 0.0), "rule": "blended"}
    >>> round(1e5 * run({**given, "creepage": [(1.0, 0.0)]}).figures["force_along"].found, 4)
    3.0
    """
    creepages, forces, spins = options.get("creepage"), options.get("tangential"), options["spin"]
    if creepages and forces:
        raise InputError("Give --creepage or --tangential: one follows from the other.", code="one-of")
    if len(spins) > 1 and not creepages:
        raise InputError("Several spins are a family of creep curves: give --creepage, too.")
    checks.lengths(radius=options["radius"], force=options["force"])
    material, force = Material(options["E"], options["nu"]), options["force"]
    body = Paraboloid(options["radius"], options["radius_y"] or options["radius"])
    exact = closed_form(body, HalfSpace(material, (1.0, 1.0), (2, 2), against=material), Load(force, None, None))
    assert exact is not None
    x, y = exact.half_widths
    half = HalfSpace(material, (BOX * x, BOX * y), (options["cells"],) * 2, against=material)
    given = {name: options[name] for name in ("force", "friction", "rule")} | {"towards": tuple(options["towards"])}
    if creepages:
        curve = half.creep_curve(body, creepages, spins=spins, **given)
    else:
        curve = CreepCurve((half.roll(body, tangential=tuple(forces or (0.0, 0.0)), spin=spins[0], **given),), (1,))
    rows, one = curve.rows(), curve.last if len(curve) == 1 else None
    notes = [*(f"Warning: {text}" for text in curve.warnings), *([f"error of {one.rolling_error}"] if one else [])]
    more = (
        {"normal force": force, "largest pressure": one.max_pressure, "work of friction": one.friction_work}
        if one
        else {}
    )
    solved = one or curve
    return Study(
        "steady rolling; forces along the direction of rolling and to its left, work per length rolled",
        {name: Figure(value) for name, value in {**more, **rows[0]}.items() if name != "error"} if one else {},
        Table(list(rows[0]), [list(row.values()) for row in rows]),
        lambda units: solved.plot(units=units.stress, length=units.length, force=units.force),
        one.summary() if one else {"rows": rows},
        solved,
        notes=notes,
    )
