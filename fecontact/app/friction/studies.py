"""Ready studies of friction beside closed forms: equal bodies as half-spaces, a block on a plane."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.analytic import friction, hertz
from fecontact.app.friction.block import BlockStudy, block_study
from fecontact.app.friction.figures import HalfSpaceFigures
from fecontact.bodies import HalfSpace
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace import FrictionPath, PressStep
from fecontact.surfaces import Paraboloid

BOX = 2.4
"""Side of the grid in radii of the contact."""

PERIOD = 16.0
"""Period of a roller in widths of its contact."""

ROLLED = 2.0
"""Distance a roller rolls in widths of its contact; it then rolls steadily to 1e-3."""

CELLS = {"mindlin": 128, "fretting": 128, "carter": 32, "block": 8}

BRANCH = 8
"""Steps of a branch of a fretting cycle."""


@dataclass(frozen=True, eq=False)
class FrictionStudy(HalfSpaceFigures):
    """A study, with methods to draw and save it."""

    def save(self, path: str | Path) -> Path:
        """Write a CSV file, one row per step."""
        return self.path.save(path)

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Any:
        """Stick, slip and tractions, and curves beside the closed form, see `pictures.plot_study`."""
        from fecontact.app.friction.figures import plot_study
        from fecontact.common.units import Units

        return plot_study(self, path, Units(length, force, stress))


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


def run(name: str, options: Mapping[str, Any]) -> FrictionStudy | BlockStudy:
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
    checks.among("study", name, CELLS)
    cells = options.get("cells") or CELLS[name]
    material, mu = Material(options["E"], options["nu"]), options["friction"]
    if name == "block":
        return block_study(material, options["radius"], options["force"], mu, options.get("tangential"), cells)
    return _RUN[name](Setting(material, options["radius"], options["force"], mu, options.get("tangential"), cells))


def _study(name: str, source: str, path: FrictionPath, exact: Any, figures: Any, rolls: bool = False) -> FrictionStudy:
    """A study of a path, with its setting and its worst residual."""
    last = path.last
    cells = " x ".join(map(str, last.grid.shape))
    setting = f"friction {last.friction:g}, {cells} cells, {len(path.contacts)} step(s)"
    worst = max(contact.residuals.worst for contact in path.contacts)
    return FrictionStudy(name, source, figures, setting, worst, path, exact, rolls)


def _mindlin(setting: Setting) -> FrictionStudy:
    exact = setting.ball
    path = setting.half_space(exact.a).press_path(Paraboloid(setting.radius), setting.steps(np.ones(1)), setting.mu)
    last = path.last
    figures: dict[str, tuple[float, float | None]] = {
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


def _fretting(setting: Setting) -> FrictionStudy:
    exact = setting.ball
    there = np.cos(np.linspace(0, np.pi, BRANCH + 1))
    shares = np.concatenate([there, -there[1:]])
    path = setting.half_space(exact.a).press_path(Paraboloid(setting.radius), setting.steps(shares), setting.mu)
    middle = BRANCH // 2
    figures: dict[str, tuple[float, float | None]] = {
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


def _carter(setting: Setting) -> FrictionStudy:
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
    figures: dict[str, tuple[float, float | None]] = {
        "creepage": (float(np.diff(path.shift[-2:, 0])[0]) / cell, exact.creepage),
        "half-width of contact": (last.figures["area"] / width / 2, line.a),
        "half-width of stick": (last.stick_area / width / 2, exact.c),
        "tractions, L2 difference": (float(np.linalg.norm(found - known) / np.linalg.norm(known)), 0.0),
    }
    return _study("roller", "Carter", path, exact, figures, rolls=True)


_RUN: dict[str, Callable[[Setting], FrictionStudy]] = {"mindlin": _mindlin, "fretting": _fretting, "carter": _carter}
