"""Ready studies of friction beside closed forms: equal bodies as half-spaces, a block on a plane.

The block is held by friction for ten thousand steps, refused beyond, dragged to and fro.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.analytic import friction, hertz
from fecontact.app.options import STUDIES
from fecontact.bodies import Body, ElasticBody, HalfSpace, Plane, RigidBody
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SupportError
from fecontact.common.files import save_figure
from fecontact.common.material import Material
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.halfspace import FrictionPath, PressStep
from fecontact.halfspace.pictures import draw_stick_slip
from fecontact.mesh import shapes
from fecontact.results.pictures.contact_map import draw_friction
from fecontact.scene.scene import Scene
from fecontact.surfaces import Paraboloid

BOX = 2.4
"""Side of the grid in radii of the contact."""

PERIOD = 16.0
"""Period of a roller in widths of its contact."""

ROLLED = 2.0
"""Distance a roller rolls in widths of its contact; it then rolls steadily to 1e-3."""

CELLS = {"mindlin": 128, "fretting": 128, "carter": 32, "block": 8}

BRANCH, BRANCH_OF_BLOCK = 8, 12
"""Steps of a branch of a fretting cycle, and of the drag of a block."""

STEPS = 10_000
"""Steps of constant load of a block."""

FAR = 8.0
"""Drag of a block to each side, in shifts of the top under which an elastic block that sticks would slide."""

BEYOND = 1.05
"""Load over what friction holds that is to be refused."""

#: Figures found, each with its exact value where there is one.
Figures = dict[str, tuple[float, float | None]]


@dataclass(frozen=True, eq=False)
class Study:
    """Figures of a study beside those of a closed form, its steps and its picture.

    Attributes
    ----------
    name, source : str
        Name of the study, and of the closed form.
    figures : dict of str to (float, float or None)
    setting : str
        What was solved, in a few words.
    worst_residual : float
        Largest residual of all steps.
    rows : sequence of dict
        A row for each step.
    draw : callable
        Function ``draw(left, right, units)`` that draws on two axes.
    title : str
    path : FrictionPath or LoadPath
    more : dict
        Further figures for scripts.
    remark : str
        Printed below the figures.
    """

    name: str
    source: str
    figures: Figures
    setting: str
    worst_residual: float
    rows: Sequence[Mapping[str, Any]]
    draw: Callable[[Any, Any, Units], None]
    title: str
    path: Any
    more: Mapping[str, Any] = field(default_factory=dict)
    remark: str = ""

    @cached_property
    def errors(self) -> dict[str, float]:
        """Relative errors; figures whose exact value is zero are their own error."""
        return {
            name: found / exact - 1 if exact else found
            for name, (found, exact) in self.figures.items()
            if exact is not None
        }

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts, with a row per step."""
        return {
            "study": self.name,
            "source": self.source,
            "figures": {name: found for name, (found, _) in self.figures.items()},
            "exact": {name: exact for name, (_, exact) in self.figures.items() if exact is not None},
            "errors": self.errors,
            **self.more,
            "steps": list(self.rows),
        }

    def __str__(self) -> str:
        lines = [
            f"{self.name}, {self.setting}",
            f"beside: {self.source}",
            f"  {'':32}{'found':>14}{'exact':>14}{'error':>11}",
        ]
        for name, (found, exact) in self.figures.items():
            compared = "" if exact is None else f"{exact:>14.6g}{self.errors[name]:>+11.1e}"
            lines.append(f"  {name:32}{found:>14.6g}{compared}")
        return "\n".join([*lines, f"worst residual of a step: {self.worst_residual:.1e}{self.remark}"])

    def save(self, path: str | Path) -> Path:
        """Write a CSV file, one row per step."""
        return Table(list(self.rows[0]), [tuple(row.values()) for row in self.rows]).save(path)

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Figure:
        """Stick, slip and tractions, and curves beside the closed form."""
        figure = Figure(figsize=(12.0, 5.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        self.draw(left, right, Units(length, force, stress))
        figure.suptitle(self.title)
        return save_figure(figure, path)


@dataclass(frozen=True)
class Setting:
    """Two equal bodies, one of them plane, pressed together and dragged.

    Parameters
    ----------
    material : Material
    radius : float
        Radius of the ball or the roller.
    force : float
        Normal force; per length of a roller.
    mu : float
        Coulomb's mu.
    tangential : float or None
        Tangential force; None: 0.6 of what friction holds.
    cells : int
        Cells along a side of the grid; across the contact of a roller.
    """

    material: Material
    radius: float
    force: float
    mu: float
    tangential: float | None
    cells: int

    def __post_init__(self) -> None:
        checks.lengths(radius=self.radius, force=self.force, friction=self.mu)
        if self.tangential is not None:
            checks.lengths(tangential=self.tangential)
        if self.cells < 8:
            raise InputError(f"A study needs at least 8 cells; found {self.cells}.", code="too-few-cells")

    @property
    def drag(self) -> float:
        """The tangential force."""
        return 0.6 * self.mu * self.force if self.tangential is None else self.tangential

    @property
    def ball(self) -> friction.RoundSlip:
        """Closed form of the ball."""
        contact = hertz.spheres((self.radius, math.inf), (self.material, self.material), force=self.force)
        return friction.mindlin(contact, self.mu, tangential=self.drag)

    def half_space(self, a: float) -> HalfSpace:
        """The half-space for a ball of contact radius a."""
        side = BOX * a
        return HalfSpace(self.material, (side, side), (self.cells, self.cells), against=self.material)

    def steps(self, shares: Array) -> list[PressStep]:
        """Steps under the normal force and shares of the tangential one along x."""
        return [PressStep(force=self.force, tangential=(float(share) * self.drag, 0.0)) for share in shares]


def run(name: str, options: Mapping[str, Any]) -> Study:
    """Run a study.

    Parameters
    ----------
    name : {'mindlin', 'fretting', 'carter', 'block'}
    options : mapping
        Options of ``fecontact friction --help``: radius, E, nu, force, friction, tangential and cells.

    Raises
    ------
    InputError
        For an unknown study, or numbers that do not fit.

    Examples
    --------
    >>> found = run("mindlin", {"radius": 10.0, "E": 1.0, "nu": 0.0, "force": 1e-3, "friction": 0.3, "cells": 48})
    >>> abs(found.errors["shift"]) < 1e-3
    True
    """
    checks.among("study", name, STUDIES)
    cells = options.get("cells") or CELLS[name]
    material, mu = Material(options["E"], options["nu"]), options["friction"]
    if name == "block":
        return block_study(material, options["radius"], options["force"], mu, options.get("tangential"), cells)
    return _RUN[name](Setting(material, options["radius"], options["force"], mu, options.get("tangential"), cells))


def _study(name: str, source: str, path: FrictionPath, exact: Any, figures: Figures, rolls: bool = False) -> Study:
    """A study of a path on a half-space, with its setting and its worst residual."""
    last = path.last
    cells = " x ".join(map(str, last.grid.shape))
    setting = f"friction {last.friction:g}, {cells} cells, {len(path.contacts)} step(s)"
    worst = max(contact.residuals.worst for contact in path.contacts)

    def draw(left: Any, right: Any, units: Units) -> None:
        draw_tractions(left, path, exact, units, rolls)
        if rolls:
            _draw_creep(right, path, exact, units)
        elif len(path.contacts) > 1:
            _draw_loop(right, path, exact, units)
        else:
            draw_stick_slip(right, last, units)

    title = f"{name}, friction {last.friction:g}, beside {source}"
    figures_of_path = path.as_dict()
    rows = figures_of_path.pop("steps")
    return Study(name, source, figures, setting, worst, rows, draw, title, path, figures_of_path)


def _mindlin(setting: Setting) -> Study:
    exact = setting.ball
    path = setting.half_space(exact.a).press_path(Paraboloid(setting.radius), setting.steps(np.ones(1)), setting.mu)
    last = path.last
    figures: Figures = {
        "contact radius": (math.sqrt(last.figures["area"] / math.pi), exact.a),
        "stick radius": (math.sqrt(last.stick_area / math.pi), exact.c),
        "shift": (last.shift[0], exact.shift),
        "work of friction": (last.friction_work, exact.friction_work),
        "tractions, L2 difference": (_round_difference(path, exact), 0.0),
        "traction across, over mu p0": (float(np.abs(last.traction[1]).max()) / setting.mu / exact.contact.p0, None),
    }
    return _study("ball in partial slip", _source("Cattaneo, Mindlin", setting), path, exact, figures)


def _round_difference(path: FrictionPath, exact: friction.RoundSlip) -> float:
    """Difference of the tractions from the closed form over it, in the L2 norm."""
    grid = path.last.grid
    known = exact.traction(np.hypot(grid.x[:, None], grid.y[None, :]))
    difference = np.hypot(path.last.traction[0] - known, path.last.traction[1])
    return float(np.linalg.norm(difference) / np.linalg.norm(known))


def _source(names: str, setting: Setting) -> str:
    return names if setting.material.nu == 0 else f"{names}; exact for nu = 0"


def _fretting(setting: Setting) -> Study:
    exact = setting.ball
    there = np.cos(np.linspace(0, np.pi, BRANCH + 1))
    shares = np.concatenate([there, -there[1:]])
    path = setting.half_space(exact.a).press_path(Paraboloid(setting.radius), setting.steps(shares), setting.mu)
    middle = BRANCH // 2
    figures: Figures = {
        "energy per cycle": (float(path.friction_work[1:].sum()), exact.cycle_energy),
        "shift at the ends": (float(path.shift[0, 0]), exact.shift),
        "shift without force": (float(path.shift[middle, 0]), float(exact.shift_in_cycle(path.tangential[middle, 0]))),
        "greatest work per area": (float(path.work_density.max()), None),
    }
    return _study("fretting of a ball", _source("Mindlin & Deresiewicz", setting), path, exact, figures)


@dataclass(frozen=True)
class Roller:
    """A cylinder along y, once in each period along x, with its lowest line at x = 0."""

    radius: float
    period: float

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together."""
        across = (x + self.period / 2) % self.period - self.period / 2
        return np.asarray(across**2 / (2 * self.radius) + 0 * y)


def _carter(setting: Setting) -> Study:
    material = setting.material
    line = hertz.line((setting.radius, math.inf), (material, material), force=setting.force)
    exact = friction.carter(line, setting.mu, tangential=setting.drag)
    cell, cells = 2 * line.a / setting.cells, round(PERIOD * setting.cells / 4) * 4
    half = HalfSpace(material, (cells * cell, 2 * cell), (cells, 2), periodic=True, against=material)
    width = 2 * cell
    pressed = PressStep(force=setting.force * width)
    rolling = [
        PressStep(force=setting.force * width, tangential=(setting.drag * width, 0.0), position=(k * cell, 0.0))
        for k in range(round(ROLLED * setting.cells) + 1)
    ]
    path = half.press_path(Roller(setting.radius, cells * cell), [pressed, *rolling], setting.mu)
    last = path.last
    x = (half.grid.x - rolling[-1].position[0] + cells * cell / 2) % (cells * cell) - cells * cell / 2
    known, found = exact.traction(x), last.traction[0].mean(axis=1)
    figures: Figures = {
        "creepage": (float(np.diff(path.shift[-2:, 0])[0]) / cell, exact.creepage),
        "half-width of contact": (last.figures["area"] / width / 2, line.a),
        "half-width of stick": (last.stick_area / width / 2, exact.c),
        "tractions, L2 difference": (float(np.linalg.norm(found - known) / np.linalg.norm(known)), 0.0),
    }
    return _study("roller", "Carter", path, exact, figures, rolls=True)


def draw_tractions(axes: Any, path: FrictionPath, exact: Any, names: Units, rolls: bool = False) -> None:
    """Draw tractions and their limit along the middle of the grid, beside the closed form."""
    last = path.last
    middle, period = last.grid.shape[1] // 2, last.grid.size[0]
    x = (last.grid.x - last.position[0] + period / 2) % period - period / 2
    order = np.argsort(x)
    near = order[np.abs(x[order]) <= 1.2 * exact.a]
    axes.plot(x[near], last.traction[0][near, middle], "o", markersize=3, color="tab:blue", label="traction")
    axes.plot(x[near], last.friction * last.pressure[near, middle], color="tab:orange", label="friction x pressure")
    line = np.linspace(-1.2 * exact.a, 1.2 * exact.a, 800)
    known = exact.traction(line if rolls else np.abs(line))
    axes.plot(line, known, color="black", linewidth=1.0, label="closed form")
    axes.set_xlabel(names.after("x", "length"))
    axes.set_ylabel(names.after("traction", "stress"))
    axes.legend()


def _draw_loop(axes: Any, path: FrictionPath, exact: friction.RoundSlip, names: Units) -> None:
    """Draw force over shift, with the closed form."""
    axes.plot(path.shift[:, 0], path.tangential[:, 0], "o", markersize=4, color="tab:blue", label="found")
    force = np.linspace(-exact.tangential, exact.tangential, 400)
    axes.plot(exact.shift_in_cycle(force), force, color="black", linewidth=1.0, label="closed form")
    axes.plot(-exact.shift_in_cycle(-force), force, color="black", linewidth=1.0)
    axes.set_xlabel(names.after("shift", "length"))
    axes.set_ylabel(names.after("tangential force", "force"))
    axes.grid(alpha=0.3)
    axes.legend()


def _draw_creep(axes: Any, path: FrictionPath, exact: Any, names: Units) -> None:
    """Draw the creepage over the distance rolled, with the steady one."""
    contacts = path.contacts[1:]
    at = np.array([contact.position[0] for contact in contacts])
    creep = np.diff(path.shift[1:, 0]) / np.diff(at)
    axes.plot(at[1:], creep, color="tab:blue", label="found")
    axes.axhline(exact.creepage, color="black", linewidth=1.0, linestyle="--", label="steady (Carter)")
    axes.set_xlabel(names.after("distance rolled", "length"))
    axes.set_ylabel("creepage")
    axes.grid(alpha=0.3)
    axes.legend()


def block_study(
    material: Material, side: float, force: float, mu: float, tangential: float | None, cells: int
) -> Study:
    """A block pressed on a rigid plane by its top, which stays level; then pulled, or dragged along x.

    Parameters
    ----------
    material : Material
    side : float
        Side of the square block; it is half as high.
    force : float
        Normal force.
    mu : float
        Coulomb's mu.
    tangential : float or None
        Force that pulls; None: 0.6 of what friction holds.
    cells : int
        Cells along a side, at least two.

    Returns
    -------
    Study
        Coulomb's law beside: friction when everything slides, its work, no slip under a constant load.

    Raises
    ------
    InputError
        For numbers that are not positive, or a load beyond what friction holds.
    """
    checks.lengths(radius=side, force=force, friction=mu)
    checks.whole("the number of cells", cells, 2)
    limit = mu * force
    pull = 0.6 * limit if tangential is None else checks.positive("tangential", tangential)
    if pull >= limit:
        raise InputError(
            f"The block slides as a whole: friction holds {limit:g}; found a tangential force of {pull:g}.",
            code="slides-as-a-whole",
        )
    mesh = shapes.block((side, side, side / 2), (cells, cells, max(cells // 2, 1)))
    block = ElasticBody(mesh, material, "bottom", {"top": "xyz"}, name="block")
    plane = RigidBody(Plane(), name="plane")
    scene = Scene([block, plane], [Contact(block, plane, friction=mu)])
    pressed = _pulled(block, 0.0, force)
    held = scene.solve_path([pressed, *[_pulled(block, pull, force)] * (STEPS + 1)], progress=False)
    shift = _shifts(FAR * limit / (material.shear_modulus * side**2) * side / 2)
    drag = [{"forces": {block: (0, 0, -force)}, "free": {block: "z"}, "motions": {block: {"x": x}}} for x in shift]
    dragged = scene.solve_path(drag)
    slid = abs(shift[-1] - shift[-2])
    stuck = held[-1].contacts[0]
    first, last = held[1].contacts[0].friction, stuck.friction
    assert first is not None
    assert last is not None
    figures: Figures = {
        "friction under the pull": (-float(last.force[0]), pull),
        f"slip in {STEPS:,} steps of this load": (float(np.abs(last.moved - first.moved).max()), 0.0),
        "share of the area that sticks": (stuck.stick_area / stuck.whole.area, None),
        "friction when all slides": (abs(float(dragged.forces[-1, 0, 0])), limit),
        "work of friction of a slide": (float(dragged.friction_work[-1, 0]), limit * slid),
        "least work of a step": (min(float(dragged.friction_work.min()), 0.0), 0.0),
    }
    worst = max(r.friction.residuals.worst for r in (held[0], held[1], held[-1], *dragged.steps) if r.friction)
    setting = f"friction {mu:g}, {cells} x {cells} faces, {STEPS:,} steps held, {len(shift)} dragged"
    name = "block on a rigid plane"
    refusal = _refused(scene, block, limit, force)
    values = zip(shift, -dragged.forces[:, 0, 0], dragged.friction_work[:, 0], strict=True)
    rows = [{"shift": float(s), "friction": float(f), "friction_work": float(w)} for s, f, w in values]

    def draw(left: Any, right: Any, units: Units) -> None:
        draw_friction(left, stuck, units)
        left.set_title("held by friction: sticks and slides")
        _draw_drag(right, shift, -dragged.forces[:, 0, 0], limit, units)

    return Study(
        name,
        "Coulomb",
        figures,
        setting,
        worst,
        rows,
        draw,
        f"{name}, {setting}",
        dragged,
        {"refusal": refusal},
        f"\n{BEYOND:g} of what friction holds is refused:\n  {refusal}",
    )


def _pulled(block: Body, pull: float, force: float) -> dict[str, Any]:
    return {"forces": {block: (pull, 0, -force)}, "free": {block: "x z"}}


def _shifts(far: float) -> Array:
    """Shifts of the top: out, back to the other side, and out again, in fine steps after each turn."""
    share = np.linspace(0, 1, BRANCH_OF_BLOCK + 1) ** 2
    back = 1 - 2 * share[1:]
    return far * np.concatenate([share, back, -back])


def _refused(scene: Scene, block: Body, limit: float, force: float) -> str:
    """What the refusal of a load beyond friction says."""
    try:
        scene.solve(**_pulled(block, BEYOND * limit, force))
    except SupportError as refusal:
        return str(refusal)
    return "it was not"


def _draw_drag(axes: Any, shift: Array, friction: Array, limit: float, units: Units) -> None:
    """Draw force over shift, with the limit by Coulomb's law."""
    axes.plot(shift, friction, "o-", markersize=4, linewidth=1.0, color="tab:blue", label="found")
    for side in (-limit, limit):
        axes.axhline(
            side, color="black", linewidth=1.0, linestyle="--", label="mu times the normal force" if side > 0 else None
        )
    axes.set_xlabel(units.after("shift of the top", "length"))
    axes.set_ylabel(units.after("force", "force"))
    axes.set_title("dragged to and fro")
    axes.grid(alpha=0.3)
    axes.ticklabel_format(axis="x", style="sci", scilimits=(-2, 3))
    axes.legend(loc="lower center", bbox_to_anchor=(0.45, 0.12), fontsize="small")


_RUN: dict[str, Callable[[Setting], Study]] = {"mindlin": _mindlin, "fretting": _fretting, "carter": _carter}
