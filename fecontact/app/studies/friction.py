"""Ready studies of friction beside closed forms: equal bodies as half-spaces, a block on a plane.

The block is held by friction for ten thousand steps, refused beyond, dragged to and fro.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Picture

from fecontact.analytic import friction, hertz
from fecontact.app.options import STUDIES
from fecontact.app.studies.study import Figure, Study, compared
from fecontact.bodies import Body, ElasticBody, HalfSpace, Plane, RigidBody
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SupportError
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
"""Load, relative to the sliding limit, that must be refused."""


@dataclass(frozen=True)
class Setting:
    """Two equal bodies, one of them plane, pressed together and dragged.

    Parameters
    ----------
    material : Material
    radius : float
        Radius of the ball or the roller; side of a block.
    force : float
        Normal force; per length of a roller.
    mu : float
        Coulomb's mu.
    tangential : float or None
        Tangential force; None: 0.6 of what friction holds.
    cells : int
        Cells along a side of the grid or of a block; across the contact of a roller.
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

    @property
    def drag(self) -> float:
        """The tangential force."""
        return 0.6 * self.mu * self.force if self.tangential is None else self.tangential

    @property
    def ball(self) -> friction.RoundSlip:
        """Closed form of the ball."""
        contact = hertz.spheres((self.radius, math.inf), (self.material, self.material), force=self.force)
        return friction.mindlin(contact, self.mu, tangential=self.drag)

    @property
    def roller(self) -> friction.RollingSlip:
        """Closed form of the roller."""
        line = hertz.line((self.radius, math.inf), (self.material, self.material), force=self.force)
        return friction.carter(line, self.mu, tangential=self.drag)

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
        checks.whole("the number of cells", cells, 2)
    elif cells < 8:
        raise InputError(f"A study needs at least 8 cells; found {cells}.", code="too-few-cells")
    return _RUN[name](Setting(material, options["radius"], options["force"], mu, options.get("tangential"), cells))


def _study(
    name: str,
    source: str,
    setting: str,
    figures: Mapping[str, Figure],
    rows: Sequence[Mapping[str, Any]],
    draw: Callable[[Any, Any, Units], None],
    path: Any,
    worst: float,
    more: Mapping[str, Any],
    remark: Sequence[str] = (),
) -> Study:
    """A study with a row for each step, the largest residual of all, and a picture of two panels."""

    def picture(units: Units) -> Picture:
        drawn = Picture(figsize=(12.0, 5.0), layout="constrained")
        left, right = drawn.subplots(1, 2)
        draw(left, right, units)
        drawn.suptitle(f"{name}, {setting}")
        return drawn

    table = Table(list(rows[0]), [tuple(row.values()) for row in rows])
    data = {"study": name, "source": source, **compared(figures), **more, "steps": list(rows)}
    notes = [f"worst residual of a step: {worst:.1e}", *remark]
    return Study(f"{name}, {setting}", figures, table, picture, data, path, source, notes)


def _dragged(
    name: str, source: str, path: FrictionPath, exact: Any, figures: Mapping[str, Figure], rolls: bool = False
) -> Study:
    """A study of a path on a half-space."""
    last = path.last
    cells = " x ".join(map(str, last.grid.shape))
    setting = f"friction {last.friction:g}, {cells} cells, {len(path.steps)} step(s)"
    worst = max(contact.residuals.worst for contact in path.steps)

    def draw(left: Any, right: Any, units: Units) -> None:
        draw_tractions(left, path, exact, units, rolls)
        if rolls:
            _draw_creep(right, path, exact, units)
        elif len(path.steps) > 1:
            _draw_loop(right, path, exact, units)
        else:
            draw_stick_slip(right, last, units)

    more = path.as_dict()
    rows = more.pop("steps")
    return _study(name, source, setting, figures, rows, draw, path, worst, more)


def _mindlin(setting: Setting) -> Study:
    exact = setting.ball
    path = setting.half_space(exact.a).press_path(Paraboloid(setting.radius), setting.steps(np.ones(1)), setting.mu)
    last = path.last
    figures = {
        "contact radius": Figure(math.sqrt(last.figures["area"] / math.pi), exact.a),
        "stick radius": Figure(math.sqrt(last.stick_area / math.pi), exact.c),
        "shift": Figure(last.shift[0], exact.shift),
        "work of friction": Figure(last.friction_work, exact.friction_work),
        "tractions, L2 difference": Figure(_round_difference(path, exact), 0.0),
        "traction across, over mu p0": Figure(float(np.abs(last.traction[1]).max()) / setting.mu / exact.contact.p0),
    }
    return _dragged("ball in partial slip", _source("Cattaneo, Mindlin", setting), path, exact, figures)


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
    unloaded = exact.shift_in_cycle(path.tangential[middle, 0])
    figures = {
        "energy per cycle": Figure(float(path.friction_work[1:].sum()), exact.cycle_energy),
        "shift at the ends": Figure(float(path.shift[0, 0]), exact.shift),
        "shift without force": Figure(float(path.shift[middle, 0]), float(unloaded)),
        "greatest work per area": Figure(float(path.work_density.max())),
    }
    return _dragged("fretting of a ball", _source("Mindlin & Deresiewicz", setting), path, exact, figures)


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
    exact = setting.roller
    cell, cells = 2 * exact.a / setting.cells, round(PERIOD * setting.cells / 4) * 4
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
    figures = {
        "creepage": Figure(float(np.diff(path.shift[-2:, 0])[0]) / cell, exact.creepage),
        "half-width of contact": Figure(last.figures["area"] / width / 2, exact.a),
        "half-width of stick": Figure(last.stick_area / width / 2, exact.c),
        "tractions, L2 difference": Figure(float(np.linalg.norm(found - known) / np.linalg.norm(known)), 0.0),
    }
    return _dragged("roller", "Carter", path, exact, figures, rolls=True)


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
    axes.set_xlabel(names.axis_label("x", "length"))
    axes.set_ylabel(names.axis_label("traction", "stress"))
    axes.legend()


def _draw_loop(axes: Any, path: FrictionPath, exact: friction.RoundSlip, names: Units) -> None:
    """Draw force over shift, with the closed form."""
    axes.plot(path.shift[:, 0], path.tangential[:, 0], "o", markersize=4, color="tab:blue", label="found")
    force = np.linspace(-exact.tangential, exact.tangential, 400)
    axes.plot(exact.shift_in_cycle(force), force, color="black", linewidth=1.0, label="closed form")
    axes.plot(-exact.shift_in_cycle(-force), force, color="black", linewidth=1.0)
    axes.set_xlabel(names.axis_label("shift", "length"))
    axes.set_ylabel(names.axis_label("tangential force", "force"))
    axes.grid(alpha=0.3)
    axes.legend()


def _draw_creep(axes: Any, path: FrictionPath, exact: Any, names: Units) -> None:
    """Draw the creepage over the distance rolled, with the steady one."""
    contacts = path.steps[1:]
    at = np.array([contact.position[0] for contact in contacts])
    creep = np.diff(path.shift[1:, 0]) / np.diff(at)
    axes.plot(at[1:], creep, color="tab:blue", label="found")
    axes.axhline(exact.creepage, color="black", linewidth=1.0, linestyle="--", label="steady (Carter)")
    axes.set_xlabel(names.axis_label("distance rolled", "length"))
    axes.set_ylabel("creepage")
    axes.grid(alpha=0.3)
    axes.legend()


def _block(setting: Setting) -> Study:
    """A block pressed on a rigid plane by its top, which stays level; then pulled, or dragged along x.

    Its side is the setting's radius, and it is half as high. Coulomb's law beside: friction when everything slides, its
    work, no slip under a constant load. A load beyond what friction holds is refused.
    """
    side, force, mu, cells = setting.radius, setting.force, setting.mu, setting.cells
    limit, pull = mu * force, setting.drag
    if pull >= limit:
        raise InputError(
            f"The block slides as a whole: friction holds {limit:g}; found a tangential force of {pull:g}.",
            code="slides-as-a-whole",
        )
    mesh = shapes.block((side, side, side / 2), (cells, cells, max(cells // 2, 1)))
    block = ElasticBody(mesh, setting.material, "bottom", {"top": "xyz"}, name="block")
    plane = RigidBody(Plane(), name="plane")
    scene = Scene([block, plane], [Contact(block, plane, friction=mu)])
    pressed = _pulled(block, 0.0, force)
    held = scene.solve_path([pressed, *[_pulled(block, pull, force)] * (STEPS + 1)], progress=False)
    shift = _shifts(FAR * limit / (setting.material.shear_modulus * side**2) * side / 2)
    drag = [{"forces": {block: (0, 0, -force)}, "free": {block: "z"}, "motions": {block: {"x": x}}} for x in shift]
    dragged = scene.solve_path(drag)
    slid = abs(shift[-1] - shift[-2])
    stuck = held[-1].contacts[0]
    first, last = held[1].contacts[0].friction, stuck.friction
    assert first is not None
    assert last is not None
    figures = {
        "friction under the pull": Figure(-float(last.force[0]), pull),
        f"slip in {STEPS:,} steps of this load": Figure(float(np.abs(last.moved - first.moved).max()), 0.0),
        "share of the area that sticks": Figure(stuck.stick_area / stuck._whole.area),
        "friction when all slides": Figure(abs(float(dragged.forces[-1, 0, 0])), limit),
        "work of friction of a slide": Figure(float(dragged.friction_work[-1, 0]), limit * slid),
        "least work of a step": Figure(min(float(dragged.friction_work.min()), 0.0), 0.0),
    }
    worst = max(r.friction.residuals.worst for r in (held[0], held[1], held[-1], *dragged.steps) if r.friction)
    described = f"friction {mu:g}, {cells} x {cells} faces, {STEPS:,} steps held, {len(shift)} dragged"
    name = "block on a rigid plane"
    refusal = _refused(scene, block, limit, force)
    values = zip(shift, -dragged.forces[:, 0, 0], dragged.friction_work[:, 0], strict=True)
    rows = [{"shift": float(s), "friction": float(f), "friction_work": float(w)} for s, f, w in values]

    def draw(left: Any, right: Any, units: Units) -> None:
        draw_friction(left, stuck, units)
        left.set_title("held by friction: sticks and slides")
        _draw_drag(right, shift, -dragged.forces[:, 0, 0], limit, units)

    remark = [f"{BEYOND:g} of what friction holds is refused:", f"  {refusal}"]
    return _study(name, "Coulomb", described, figures, rows, draw, dragged, worst, {"refusal": refusal}, remark)


def _pulled(block: Body, pull: float, force: float) -> dict[str, Any]:
    return {"forces": {block: (pull, 0, -force)}, "free": {block: "x z"}}


def _shifts(far: float) -> Array:
    """Shifts of the top: out, back to the other side, and out again, in fine steps after each turn."""
    share = np.linspace(0, 1, BRANCH_OF_BLOCK + 1) ** 2
    back = 1 - 2 * share[1:]
    return far * np.concatenate([share, back, -back])


def _refused(scene: Scene, block: Body, limit: float, force: float) -> str:
    """Message of the refusal of a load beyond the sliding limit."""
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
    axes.set_xlabel(units.axis_label("shift of the top", "length"))
    axes.set_ylabel(units.axis_label("force", "force"))
    axes.set_title("dragged to and fro")
    axes.grid(alpha=0.3)
    axes.ticklabel_format(axis="x", style="sci", scilimits=(-2, 3))
    axes.legend(loc="lower center", bbox_to_anchor=(0.45, 0.12), fontsize="small")


_RUN: dict[str, Callable[[Setting], Study]] = {
    "mindlin": _mindlin,
    "fretting": _fretting,
    "carter": _carter,
    "block": _block,
}
