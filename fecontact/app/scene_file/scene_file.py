"""Scenes in TOML files: reading, checks, solution and output.

All faults are reported together, each with its line and place, before any solve. Relative paths are relative to the
file. `docs/scene-file.md` has all keys.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fecontact.app.decks.read import DECKS, read_deck_scene
from fecontact.app.options import FINITE, LAWS
from fecontact.app.scene_file.bodies import AnyBody, pose_of, read_bodies, read_materials
from fecontact.app.scene_file.contents import SceneFile
from fecontact.app.scene_file.expression import Components, Expression
from fecontact.app.scene_file.outputs import Output, read_outputs, unknown_body
from fecontact.app.scene_file.toml_table import (
    Arguments,
    Faults,
    Reader,
    Table,
    choice,
    did_you_mean,
    integer,
    listed,
    number,
    numbers,
    read_toml,
)
from fecontact.bodies.elastic import elastic_among
from fecontact.common.arguments import file_path, function
from fecontact.common.checks import among
from fecontact.common.directions import Directions
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.contact.loads import LoadStep
from fecontact.contact.overclosure import SoftContact
from fecontact.contact.springs import Spring
from fecontact.fem.rigid import COMPONENTS
from fecontact.scene.adaptive import Target
from fecontact.scene.engine import ENGINES
from fecontact.scene.scene import Scene
from fecontact.scene.sweep_case import parameters_of
from fecontact.solvers import available_solvers

Bodies = Mapping[str, AnyBody | None]


def read_scene(
    path: str | Path,
    out: str | Path | None = None,
    change: Callable[[dict[str, Any]], object] | None = None,
    laws: str = FINITE,
    divide: int = 0,
) -> SceneFile:
    """Read a scene file and check all of it, including boundaries of meshes and output paths.

    Parameters
    ----------
    path : str or Path
        TOML file; relative paths in it are relative to its folder. Or a deck of Abaqus or CalculiX (``.inp``) or FEBio
        (``.feb``): its materials, supports, loads, contacts, ties and steps; `SceneFile.notes` lists what is not used.
        See docs/files.md.
    out : str or Path, optional
        Base folder of relative output paths instead. A deck names no outputs; with `out` they are a ``.vtu`` and a
        ``.json`` file, of cases a ``.csv`` file, with its name.
    change : callable, optional
        Function that modifies the file's contents in place before the checks; of a deck, its options of the solution.
    laws : {'finite-strain', 'small-strain'}
        Hyperelastic laws of a deck as they are, or by their moduli at rest, of which the result warns.
    divide : int
        How many times to divide each solid cell of a deck (``.inp``) into eight.

    Raises
    ------
    InputError
        If the file has faults; the message lists all, each with its line and place.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> text = '''
    ... [materials.cork]
    ... E = 10.0
    ... nu = 0.0
    ... [bodies.block]
    ... shape = {kind = "block", size = [1.0, 1.0, 1.0], divisions = [2, 2, 2]}
    ... material = "cork"
    ... contact = "bottom"
    ... supports = {top = "xyz"}
    ... [bodies.floor]
    ... type = "rigid"
    ... shape = {kind = "plane"}
    ... [[contacts]]
    ... slave = "block"
    ... master = "floor"
    ... [loads]
    ... motions.block = {z = -0.01}
    ... '''
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "scene.toml"
    ...     _ = path.write_text(text)
    ...     result = read_scene(path).solve()
    >>> round(result.contacts[0].total_force, 12)
    0.1
    """
    path = file_path("the path of a scene file", path)
    among("laws", laws, LAWS)
    if path.suffix.lower() in DECKS:
        return _deck(path, out, change, laws, divide)
    if laws != FINITE:
        raise InputError(f"laws={laws!r} is for decks; a scene file names its materials.", code="not-a-deck")
    if divide:
        raise InputError(f"divide={divide!r} is for decks; a scene file names its meshes.", code="not-a-deck")
    root = read_toml(path)
    if change is not None:
        values = dict(root.values)
        function("change", change)(values)
        root.values = values
    folder = root.faults.path.parent
    title = root.text("title") or ""
    units, axes = _units(root.table("units")), _axes(root.table("axes"))
    bodies = read_bodies(root.table("bodies", required=True), read_materials(root.table("materials")), folder)
    contacts = [_contact(t, bodies) for t in root.tables("contacts")]
    springs = [_spring(t, bodies) for t in root.tables("springs")]
    if not contacts and not springs:
        root.fault("contacts", "is missing: a scene needs at least one [[contacts]].")
    loads = _loads(root.table("loads"), bodies)
    options = _solve_options(root.table("solve"))
    tables = root.tables("cases")
    cases = [_case(table, k, bodies, loads) for k, table in enumerate(tables)]
    steps = [_loads(step, bodies) for step in root.tables("steps")]
    _check_steps(root, loads, cases, steps, options)
    outputs = read_outputs(root.table("outputs"), folder if out is None else file_path("out", out), bodies, bool(cases))
    root.finish()
    made = {name: body for name, body in bodies.items() if body is not None}
    if len(made) == len(bodies) and not root.faults.touched(("loads",)):
        for table, case in [(root, loads)] if not cases else zip(tables, cases, strict=True):
            if not table.faults.touched(table.place or ("loads",)):
                _check_loads(table, made, case)
    root.faults.check()
    known = [c for c in contacts if c is not None], [s for s in springs if s is not None]
    scene = Scene(list(made.values()), *known, units=units, axes=axes)
    return SceneFile(root.faults.path, title, scene, made, loads, options, outputs, tuple(cases), tuple(steps))


def _deck(
    path: Path, out: str | Path | None, change: Callable[[dict[str, Any]], object] | None, laws: str, divide: int
) -> SceneFile:
    """The scene of a deck, with options and outputs."""
    values: dict[str, Any] = {}
    if change is not None:
        change(values)
    root = Table(values, (), Faults(path, {}))
    options, units = _solve_options(root.table("solve")), _units(root.table("units"))
    root.faults.check()
    scene = read_deck_scene(path, laws, divide)
    scene = replace(scene, options={**scene.options, **options}, scene=replace(scene.scene, units=units))
    if out is None:
        return scene
    kinds = ("cases",) if scene.cases else ("vtu", "json")
    made = [Output(kind, Path(out) / f"{path.stem}.{'csv' if kind == 'cases' else kind}", {}) for kind in kinds]
    for output in made:
        check_writable(output.path)
    return replace(scene, outputs=tuple(made))


def _check_steps(
    root: Table, loads: Mapping[str, Any], cases: Sequence[Any], steps: Sequence[Any], options: Mapping[str, Any]
) -> None:
    """Refuse steps beside other ways to give loads, and settings that a load path does not have."""
    if not steps:
        return
    if loads or cases:
        root.fault("steps", "has all loads of a load path: leave [loads] and [[cases]] out.")
    if others := sorted(set(options) - {"tolerance", "finite_motion", "accuracy", "max_dofs", "max_seconds"}):
        root.fault("steps", f"is a load path with friction, which has no {', '.join(others)}.")


def _units(table: Table) -> Units:
    names = [table.text(key) or "" for key in ("length", "force", "stress")]
    table.finish()
    return Units.of(names)


def _axes(table: Table) -> Directions | None:
    """Names of directions, for maps."""
    return table.make(lambda **named: Directions.of(named), {f"{key}!": numbers(3) for key in table.values})


def _body(bodies: Bodies) -> Reader:
    """A declared body that is valid."""

    def read(table: Table, key: str, required: bool) -> AnyBody | None:
        name = table.text(key, required=required)
        if name is not None and name not in bodies:
            table.fault(key, unknown_body(name, bodies))
        return bodies.get(name or "")

    return read


def _contact(table: Table, bodies: Bodies) -> Contact | None:
    return table.make(
        Contact,
        {
            "slave!": _body(bodies),
            "master!": _body(bodies),
            "surfaces": _surfaces,
            "swap": choice(("auto", "never")),
            "coupling": choice(("auto", "nodal", "mortar")),
            "friction": _friction,
            "friction_axis": numbers(3),
            "axis_of": choice(("slave", "master")),
            "overclosure": lambda table, key, required: _overclosure(table, key) if key in table.values else None,
        },
    )


def _overclosure(table: Table, key: str) -> SoftContact | None:
    """Law of a soft contact: a stiffness, rows of overclosure and pressure, or an exponential one."""
    law = table.table(key)
    if "clearance" in law or "pressure" in law:
        return law.make(SoftContact.exponential, {"clearance!": number, "pressure!": number})
    return law.make(SoftContact, {"stiffness!": _number_or_rows})


def _number_or_rows(table: Table, key: str, required: bool) -> Any:
    """A number, or rows of numbers."""
    return table.raw(key) if isinstance(table.values.get(key), list) else table.number(key, required)


def _surfaces(table: Table, key: str, required: bool) -> tuple[str, str] | None:
    """Two names."""
    names = table.raw(key, required)
    if isinstance(names, list) and len(names) == 2 and all(isinstance(n, str) for n in names):
        return names[0], names[1]
    if names is not None:
        table.fault(key, f"must be two names, the slave's first; found {names!r}.")
    return None


def _friction(table: Table, key: str, required: bool) -> float | tuple[float, ...] | None:
    """Coefficient of friction; the word "rough" for an infinite one, or two."""
    given = table.values.get(key)
    if given == "rough":
        return math.inf if table.text(key, required=required) else None
    return table.numbers(key, 2, required) if isinstance(given, list) else table.number(key, required)


def _spring(table: Table, bodies: Bodies) -> Spring | None:
    def end(table: Table, key: str, required: bool) -> tuple[AnyBody | None, Any] | None:
        """Body (None: the ground) and point; None if the body is invalid."""
        entry = table.table(key, required)
        given = entry.read({"body": _body(bodies), f"point{'!' if entry.values else ''}": numbers(3)})
        entry.finish()
        return None if "body" in entry and "body" not in given else (given.get("body"), given.get("point"))

    kinds = choice(("tension", "linear"))
    arguments = {"stiffness!": number, "slack_length": number, "kind": kinds, "name": choice(), "toe": number}
    return table.make(Spring, {**arguments, "start!": end, "end!": end})


def _case(table: Table, index: int, bodies: Bodies, loads: Mapping[str, Any]) -> dict[str, Any]:
    """One case of a sweep: its loads replace those of the same kind under [loads]."""
    name = table.text("name") or str(index)
    poses = {}
    entries = table.table("poses")
    for key, entry in entries.subtables():
        pose = pose_of(entry)
        if key not in bodies:
            entries.fault(key, unknown_body(key, bodies))
        elif pose is not None and (body := bodies[key]) is not None:
            poses[body] = pose
    given = table.table("parameters")
    parameters = given.read({f"{key}!": number for key in given.values})
    given.attempt(lambda: parameters_of({"parameters": parameters}))
    own = _loads(table, bodies)
    more = {"poses": poses, "parameters": parameters}
    return {"name": name, **loads, **own, **{key: value for key, value in more.items() if value}}


def _loads(table: Table, bodies: Bodies) -> dict[str, Any]:
    """Arguments of `Scene.solve`, without invalid bodies."""
    found: dict[str, Any] = {
        kind: _by_body(table.table(kind), bodies, read, boundary) for kind, (read, boundary) in LOADS.items()
    }
    found["gravity"] = table.numbers("gravity")
    table.finish()
    return {kind: value for kind, value in found.items() if value}


def _components(table: Table, key: str, required: bool) -> str | None:
    names = table.texts(key, required)
    return None if names is None else " ".join(names)


def _pressure(table: Table, key: str, required: bool) -> Any:
    """A number, a formula of x, y, z, or a list of numbers for the nodes."""
    given = table.values.get(key)
    if isinstance(given, str):
        return table.attempt(lambda: Expression(table.text(key) or ""), key)
    return table.raw(key) if isinstance(given, list) else table.number(key, required)


def _traction(table: Table, key: str, required: bool) -> Any:
    """Three numbers or formulas, or a list of three numbers for each of the boundary's nodes."""
    given = table.values.get(key)
    if not isinstance(given, list) or not given or isinstance(given[0], list):
        return table.raw(key)
    if not any(isinstance(part, str) for part in given):
        return table.numbers(key, 3, required)
    parts = table.texts(key)
    if parts is None or len(parts) != 3:
        table.fault(key, f"must be three numbers or three formulas in quotation marks; found {given!r}.")
        return None
    x, y, z = parts
    return table.attempt(lambda: Components((Expression(x), Expression(y), Expression(z))), key)


def _motion(table: Table, key: str, required: bool) -> dict[str, float]:
    """Components of a motion; rotations in radians, or in degrees as rx_deg, ry_deg, rz_deg."""
    entry, out = table.table(key, required), {}
    for component in COMPONENTS:
        value = entry.number(component)
        if value is not None:
            out[component] = value
        if component.startswith("r"):
            degrees = entry.number(f"{component}_deg")
            if degrees is not None and value is not None:
                entry.fault(f"{component}_deg", f"is given together with {component}; give one of them.")
            elif degrees is not None:
                out[component] = math.radians(degrees)
    entry.finish()
    return out


#: Loads by body: how a value is read, and whether a key names a boundary of the body.
LOADS: dict[str, tuple[Reader, str]] = {
    "forces": (numbers(3), "may"),
    "moments": (numbers(3), "never"),
    "motions": (_motion, "never"),
    "free": (_components, "never"),
    "pressures": (_pressure, "must"),
    "tractions": (_traction, "must"),
    "displacements": (_traction, "must"),
    "temperatures": (_pressure, "never"),
}


def _by_body(table: Table, bodies: Bodies, read: Reader, boundary: str) -> dict[Any, Any]:
    """Values by body or by (body, boundary).

    A key is the name of a body, or ``"body.boundary"``, or ``body.boundary`` as TOML's own nesting.
    """
    out: dict[Any, Any] = {}
    for key in table.values:
        nested = boundary != "never" and key in bodies and isinstance(table.values[key], dict)
        entries = [(table.table(key), key, name) for name in table.values[key]] if nested else [(table, key, None)]
        for entry, name, part in entries:
            at = key if part is None else part
            if part is None and name not in bodies and "." in name and boundary != "never":
                name, _, part = name.rpartition(".")
            value = read(entry, at, False)
            if name not in bodies:
                entry.fault(at, unknown_body(name, bodies))
            elif boundary == "must" and part is None:
                entry.fault(at, f'needs a boundary: "{name}.boundary" = ...')
            elif value is not None and _has_boundary(entry, at, bodies[name], part):
                out[bodies[name] if part is None else (bodies[name], part)] = value
    return {k: v for k, v in out.items() if k is not None}


def _has_boundary(table: Table, key: str, body: AnyBody | None, boundary: str | None) -> bool:
    """Whether a body is valid and has the boundary, if one is named."""
    if body is None or boundary is None:
        return body is not None
    elastic = elastic_among([body])
    if not elastic:
        table.fault(key, f"{body.name!r} is rigid and has no boundaries; load the body as a whole.")
        return False
    known = elastic[0].mesh.boundaries
    if boundary not in known:
        hint = did_you_mean(boundary, known)
        table.fault(key, f"{body.name!r} has no boundary {boundary!r}{hint}; there are: {listed(known)}.")
    return boundary in known


def _check_loads(root: Table, bodies: Mapping[str, AnyBody], loads: Mapping[str, Any]) -> None:
    """Check the loads together: components both loaded and prescribed, gravity without density."""
    root.attempt(lambda: LoadStep.of(loads).on(list(bodies.values())), "loads" if "loads" in root else None)


#: Keys of [solve].
OPTIONS: Arguments = {
    # back-ends are looked for where a solver is read, since importing them takes long
    "solver": lambda table, key, required: table.text(key, ("auto", *available_solvers()), required),
    "tolerance": number,
    "finite_motion": lambda table, key, required: table.flag(key, required, "auto"),
    "accuracy": Table.number_or_named,
    "max_dofs": integer,
    "max_seconds": number,
    "engine": choice(ENGINES),
    "ranks": integer,
}


def _solve_options(table: Table) -> dict[str, Any]:
    found = table.read(OPTIONS)
    table.finish()
    limits = [found.get(name) for name in ("max_dofs", "max_seconds")]
    if "accuracy" in found:
        table.attempt(lambda: Target(found["accuracy"], *limits), "accuracy")
    elif any(limit is not None for limit in limits):
        table.fault(None, "has a limit of unknowns or of time on the way to an accuracy, but no accuracy.")
    if "tolerance" in found and not 0 < found["tolerance"] < 1:
        table.fault("tolerance", f"must lie between 0 and 1; found {found['tolerance']!r}.")
    return found
