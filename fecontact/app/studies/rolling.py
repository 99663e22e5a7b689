"""Steady rolling of a curved body on a plane of the same material, or of a wheel on a rail of given profiles."""

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
from fecontact.scene.wheel_rail import WheelRail
from fecontact.surfaces import Paraboloid, read_profile

#: Side of the grid in half-widths of the contact.
BOX = 2.4

#: Options of a body on a plane alone, and of a wheel on a rail.
OF_A_BODY = ("radius_y", "creepage", "tangential", "spin", "towards", "rule")
OF_A_WHEEL = ("shift", "yaw", "roll", "turning", "gauge", "rail_position", "wheel_position", "join")


def run(options: Mapping[str, Any]) -> Study:
    """Roll a body, follow creep curves, or roll a wheel on a rail at lateral shifts.

    Parameters
    ----------
    options : mapping
        Options of ``fecontact roll --help``; ``creepage`` is a list of pairs.

    Raises
    ------
    InputError
        For creepages with a tangential force, options of the other kind of bodies, or numbers that do not fit.

    Examples
    --------
    >>> given = {"radius": 1.0, "radius_y": None, "E": 1.0, "nu": 0.25, "force": 1e-4, "friction": 0.3, "cells": 24}
    >>> given |= {"tangential": None, "spin": [0.0], "towards": (1.0, 0.0), "rule": "blended"}
    >>> round(1e5 * run({**given, "creepage": [(1.0, 0.0)]}).figures["force_along"].found, 4)
    3.0
    """
    rail = options.get("profiles") is not None
    if wrong := [name for name in (OF_A_BODY if rail else OF_A_WHEEL) if options.get(name) is not None]:
        raise InputError(
            f"--{wrong[0].replace('_', '-')} is for {'a body on a plane' if rail else 'a wheel on a rail'}: "
            f"{'leave it or --profiles out' if rail else 'give --profiles WHEEL RAIL, too'}."
        )
    return _wheel_on_rail(options) if rail else _body_on_plane(options)


def _wheel_on_rail(options: Mapping[str, Any]) -> Study:
    """A wheel at lateral shifts; at a single one its patches are drawn."""

    def given(**names: str) -> dict[str, Any]:
        return {ours: value for ours, name in names.items() if (value := options.get(name)) is not None}

    if options["radius"] is None:
        raise InputError("Give --radius: that of the wheel where its profile has y = z = 0.")
    wheel, rail = map(read_profile, options["profiles"])
    places = given(gauge="gauge", rail_position="rail_position", wheel_position="wheel_position")
    pair = WheelRail(wheel, rail, options["radius"], Material(options["E"], options["nu"]), **places)
    more = given(yaws="yaw", rolls="roll", turnings="turning", friction="friction", cells="cells", join="join")
    path = pair.positions(options["force"], options.get("shift") or [0.0], **more)
    solved = path.last if len(path) == 1 else path
    return Study(
        "a wheel that rolls steadily on a rail, a row for each patch; forces on the rail",
        {},
        path.table,
        lambda units: solved.plot(units=units),
        {"rows": path.rows()},
        solved,
        notes=[f"Warning: {text}" for text in path.warnings],
    )


def _body_on_plane(options: Mapping[str, Any]) -> Study:
    """One state, or creep curves."""
    creepages, forces, spins = options.get("creepage"), options.get("tangential"), options["spin"] or [0.0]
    if creepages and forces:
        raise InputError("Give --creepage or --tangential: one follows from the other.", code="one-of")
    if len(spins) > 1 and not creepages:
        raise InputError("Several spins are a family of creep curves: give --creepage, too.")
    radius = 10.0 if options["radius"] is None else options["radius"]
    checks.lengths(radius=radius, force=options["force"])
    material, force = Material(options["E"], options["nu"]), options["force"]
    body = Paraboloid(radius, options["radius_y"] or radius)
    exact = closed_form(body, HalfSpace(material, (1.0, 1.0), (2, 2), against=material), Load(force, None, None))
    assert exact is not None
    x, y = exact.half_widths
    half = HalfSpace(material, (BOX * x, BOX * y), (options["cells"],) * 2, against=material)
    given = {name: options[name] for name in ("force", "friction")}
    given |= {"towards": tuple(options["towards"] or (1.0, 0.0)), "rule": options["rule"] or "blended"}
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
        lambda units: solved.plot(units=units),
        one.summary() if one else {"rows": rows},
        solved,
        notes=notes,
    )
