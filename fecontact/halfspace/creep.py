"""Creep curves of steady rolling, and Kalker's coefficients of the contact of a surface."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any, ClassVar

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.path import Path, Steps, each_step
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.friction import recertified, restored
from fecontact.halfspace.path import prints_of
from fecontact.halfspace.pictures import Drawn, plot_creep
from fecontact.halfspace.pressing import press
from fecontact.halfspace.rolling import (
    RULES,
    STICKING,
    RollingContact,
    RollingError,
    RollingFriction,
    RollingStep,
    RollingTractions,
    on_coarser,
    roll,
)
from fecontact.halfspace.tresca import TrescaProblem, solve_nested_tresca
from fecontact.solvers.coulomb import friction_limit


@dataclass(frozen=True)
class CreepCoefficients:
    """Kalker's coefficients, the limit of small creepages, in which all that touches sticks.

    With creepages xi, eta and spin phi, in Kalker's signs (see `HalfSpace.roll`),

        Fx = -G c^2 C11 xi,  Fy = -G c^2 (C22 eta + c C23 phi),  Mz = -G c^3 (-C23 eta + c C33 phi).

    Attributes
    ----------
    c11, c22, c23, c33 : float
    length : float
        c: root of the area over pi, that of the product of an ellipse's semi-axes.
    shear_modulus : float
        G of both bodies, 2 / G = 1 / G1 + 1 / G2; of the top layer.
    errors : (float, float, float, float)
        Estimated relative errors, from cells twice as large.

    References
    ----------
    J. J. Kalker, Three-dimensional elastic bodies in rolling contact, 1990, section 2.2 and table E3.
    """

    c11: float
    c22: float
    c23: float
    c33: float
    length: float
    shear_modulus: float
    errors: tuple[float, float, float, float]

    def forces(self, creepage: tuple[float, float], spin: float = 0.0) -> tuple[float, float, float]:
        """Tangential force along the direction of rolling and to its left, and torque, in the signs of `roll`."""
        (x, y), c = creepage, self.length
        scale = self.shear_modulus * c**2
        torque = scale * c * (self.c33 * c * spin - self.c23 * y)
        return scale * self.c11 * x, scale * (self.c22 * y + c * self.c23 * spin), torque

    def __str__(self) -> str:
        values = zip(("C11", "C22", "C23", "C33"), (self.c11, self.c22, self.c23, self.c33), self.errors, strict=True)
        return ", ".join(f"{name} {value:.4g} (off by about {100 * off:.1g} %)" for name, value, off in values)


def creep_coefficients(friction: RollingFriction, normal: HalfSpaceContact, step: RollingStep) -> CreepCoefficients:
    """Kalker's coefficients of a contact's outline; of an infinite friction."""
    modulus = 1 / (math.pi * (friction.constants.direct + friction.constants.poisson))
    grid, pressure, (x, y), _ = on_coarser(normal)
    coarse = replace(normal, grid=grid, pressure=pressure)
    length = math.sqrt(normal.figures["area"] / math.pi)
    values = _coefficients(friction, normal, step, modulus, length)
    others = _coefficients(friction.on(grid), coarse, replace(step, position=(-x, -y)), modulus, length)
    c11, c22, c23, c33 = values.tolist()
    errors = np.abs(others / values - 1).tolist()
    return CreepCoefficients(c11, c22, c23, c33, length, modulus, (errors[0], errors[1], errors[2], errors[3]))


def _coefficients(
    friction: RollingFriction, normal: HalfSpaceContact, step: RollingStep, modulus: float, c: float
) -> Array:
    """C11, C22, C23 and C33 (4,) for a length c."""
    tractions = RollingTractions(friction, normal, step)
    compliance, rows, p = tractions.compliance, tractions.rows, normal.pressure[tractions.box]
    limit, none = friction_limit(math.inf, p), np.zeros((0, 2, *p.shape))
    units = [TrescaProblem(compliance, limit, -row, none, np.zeros(0), tractions._alone) for row in rows]
    q = [solve_nested_tresca(unit, friction.compliance, 0 * unit.c, np.zeros(0), STICKING).q for unit in units]
    ahead = RULES[step.rule][1] * step.axes[0] * normal.grid.cell
    arms = rows[2] - np.multiply.outer([-ahead[1], ahead[0]], np.ones(p.shape))  # the torque is about the true middle
    matrix = np.tensordot(np.stack(q), np.stack([rows[0], rows[1], arms]), ((1, 2, 3), (1, 2, 3))) * normal.grid.area
    C23 = (matrix[2, 1] - matrix[1, 2]) / (2 * c)  # equal by Betti's theorem, but for the cells
    return np.array([matrix[0, 0], matrix[1, 1], C23, matrix[2, 2] / c**2]) / (modulus * c**2)


@dataclass(frozen=True, eq=False)
class CreepSteps(Steps[RollingContact]):
    """Points of a creep curve, of one load and direction, for `follow`; their first pressures are the same."""

    friction: RollingFriction
    heights: Array
    steps: Sequence[RollingStep]
    start: RollingContact | None
    symmetry: bool
    most_halvings: ClassVar = 0

    @cached_property
    def first(self) -> HalfSpaceContact:
        """Pressures without tractions."""
        setting, load = self.friction, self.steps[0].normal_load
        return press(setting.body, self.heights, load, setting.first_tolerance, self.symmetry, setting.workers)

    def part(
        self, k: int, before: RollingContact | None, start: float, end: float, last: RollingContact | None,
        known: Any = None,
    ) -> RollingContact:  # fmt: skip
        """Point k, from the one before."""
        step, setting = self.steps[k], self.friction
        if known is None:
            return roll(setting, self.heights, step, before or self.start, self.symmetry, self.first)
        edge = RollingTractions(setting, self.first, step).at_leading_edge()
        known = {**known, "rolling_error": RollingError(**known["rolling_error"])}
        contact = replace(restored(setting, RollingContact, known), law=setting.law)
        tractions = RollingTractions(setting, contact, step, edge)
        return recertified(tractions, contact, self.heights, step.normal_load, contact)

    def end(self, part: RollingContact) -> dict[str, Any]:
        """Fields that are not those of the half-space."""
        return {name: getattr(part, name) for name in KEPT}

    def row(self, result: RollingContact) -> dict[str, Any]:
        """The summary."""
        return result.summary()

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each point by its number."""
        setting = self.friction
        friction = setting.mu if setting.law is None else setting.law.figures
        more = {"friction": friction, "tolerance": setting.tolerance, "heights": self.heights}
        return prints_of(setting.body, [vars(step) for step in self.steps], **more)


#: Fields of a contact that a file keeps.
KEPT = (
    "pressure", "displacement", "gap", "traction", "slip", "coarse", "approach", "tilt", "creepage", "spin", "towards",
    "position", "status", "given", "solver", "tangential_solver", "rolling_error", "also",
)  # fmt: skip


#: Figures of a creep curve.
FIGURES = ("spin", "creepage_along", "creepage_across", "force_along", "force_across", "torque", "stick_share", "error")


@compact_repr
@dataclass(frozen=True, eq=False)
class CreepCurve(Path[RollingContact], Drawn):
    """Steady rolling at several creepages and spins; made by `HalfSpace.creep_curve`.

    Drawn are the tangential force over the friction limit, along the creepage and to its left, and the torque, over the
    creepage, a curve for each spin.

    Attributes
    ----------
    steps : tuple of RollingContact
        For each spin at all creepages.
    """

    creepage = each_step("creepage", "Creepages (n, 2) along the direction of rolling and to its left.")
    spin = each_step("spin", "Spins (n,).")
    tangential = each_step("tangential", "Tangential forces (n, 2) along the direction of rolling and to its left.")
    torque = each_step("torque", "Torques (n,).")

    def rows(self) -> list[dict[str, float]]:
        """Figures of each point by name; the error is the estimated one of the tangential force."""
        of_contacts = [
            (
                at.spin,
                *at.creepage,
                *at.tangential,
                at.torque,
                at.stick_area / at.figures["area"],
                at.rolling_error.force,
            )
            for at in self.steps
        ]
        return [dict(zip(FIGURES, values, strict=True)) for values in of_contacts]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the contacts, each once."""
        return tuple(dict.fromkeys(text for at in self.steps for text in at.warnings))

    def _drawn(self, path: str | FilePath | None, units: Units) -> Any:
        size = np.hypot(*self.creepage.T)
        x, y = self.creepage[size.argmax()] if size.any() else (1.0, 0.0)
        axis = np.array([x, y]) / math.copysign(math.hypot(x, y), x if abs(x) >= abs(y) else y)
        signed = np.where(self.creepage @ axis < 0, -size, size)
        forces, of = self.tangential @ np.array([axis, [-axis[1], axis[0]]]).T, ""
        if 0 < self.last.friction < math.inf:
            forces, of = forces / [[at.friction * at.force] for at in self.steps], " over the limit of friction"
        panels = {f"force along the creepage{of}": forces[:, 0], f"force to its left{of}": forces[:, 1]}
        return plot_creep(signed, self.spin, {**panels, "torque": self.torque}, path)

    def __str__(self) -> str:
        notes = [f"Warning: {text}" for text in self.warnings]
        return str(Table(FIGURES, [list(row.values()) for row in self.rows()], notes))
