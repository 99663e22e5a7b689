"""A path of loads on a half-space with friction: its steps, the work of friction, wear."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.common import checks
from fecontact.common.arguments import instance, items
from fecontact.common.arrays import Array
from fecontact.common.errors import FecontactError, InputError
from fecontact.common.halving import HALVINGS, in_parts
from fecontact.common.one_line import one_line
from fecontact.common.renamed import RenamedKeys, renamed, warn
from fecontact.common.table import Table
from fecontact.halfspace.compliance import SurfaceCompliance, check_thickness
from fecontact.halfspace.contact import FrictionContact
from fecontact.halfspace.friction import Friction, PressStep, press_step

COLUMNS = (
    "force",
    "approach",
    "tangential_x",
    "tangential_y",
    "torque",
    "shift_x",
    "shift_y",
    "twist",
    "area",
    "stick_area",
    "slip_area",
    "friction_work",
    "worst_residual",
)


@one_line
@dataclass(frozen=True, eq=False)
class FrictionPath:
    """Contacts at the ends of the steps of a load path; made by `HalfSpace.press_path`.

    Attributes
    ----------
    contacts : tuple of FrictionContact
    """

    contacts: tuple[FrictionContact, ...]

    @property
    def cuts(self) -> tuple[int, ...]:
        """Parts in which every step was solved."""
        return tuple(1 + len(contact.parts) for contact in self.contacts)

    @property
    def last(self) -> FrictionContact:
        """The contact at the end of the path."""
        return self.contacts[-1]

    @cached_property
    def force(self) -> Array:
        """Normal force (n,) at the ends of the steps."""
        return np.array([contact.force for contact in self.contacts])

    @cached_property
    def tangential(self) -> Array:
        """Tangential force (n, 2) on the half-space by the counter-surface, which is the one on that from outside."""
        return np.array([contact.tangential for contact in self.contacts])

    @cached_property
    def torque(self) -> Array:
        """Torque (n,) about the normal."""
        return np.array([contact.torque for contact in self.contacts])

    @cached_property
    def shift(self) -> Array:
        """Displacement (n, 2) of the counter-surface since the unloaded state."""
        return np.array([contact.shift for contact in self.contacts])

    @cached_property
    def twist(self) -> Array:
        """Rotation (n,) of the counter-surface since the unloaded state."""
        return np.array([contact.twist for contact in self.contacts])

    @cached_property
    def friction_work(self) -> Array:
        """Work of friction (n,) in each step, not negative."""
        return np.array([contact.friction_work for contact in self.contacts])

    @cached_property
    def work_density(self) -> Array:
        """Work of friction per area (nx, ny) in all steps."""
        return np.asarray(sum(contact.work_density for contact in self.contacts))

    dissipated, work = renamed("dissipated", "friction_work"), renamed("work", "work_density")

    def wear_depth(self, coefficient: float) -> Array:
        """Wear depth (nx, ny) in all steps by Archard's law, h = k int p |ds|, not fed back into the shape.

        Parameters
        ----------
        coefficient : float
            Archard's k, as of `LoadPath.wear_depth`: volume per force and distance, one over pressure. Worn volume per
            work of friction is k over mu (Fouvry, Kapsa & Vincent, Wear 200 (1996) 186).

        Raises
        ------
        InputError
            If the coefficient is not positive, or friction is infinite.

        References
        ----------
        J. F. Archard, J. Appl. Phys. 24 (1953) 981.
        """
        k = checks.positive("the coefficient of wear", coefficient)
        return np.asarray(sum(k * contact.sliding_integral for contact in self.contacts))

    def wear(self, coefficient: float) -> Array:
        """Former `wear_depth`, with worn volume per work of friction as its coefficient: k over mu. It warns."""
        now = "wear(coefficient) is now wear_depth(coefficient * mu), by Archard's k; the old name will be removed."
        warn(f"FrictionPath.{now}", stacklevel=3)
        return checks.positive("the coefficient of wear", coefficient) * self.work_density

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the contacts, each with the first step that it concerns."""
        first: dict[str, int] = {}
        for k, contact in enumerate(self.contacts, 1):
            for text in contact.warnings:
                first.setdefault(text, k)
        return tuple(f"Step {k}: {text}" for text, k in first.items())

    def rows(self) -> list[dict[str, float]]:
        """Figures of each step by name."""
        return [RenamedKeys(zip(COLUMNS, _row(contact), strict=True)) for contact in self.contacts]

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        first = self.contacts[0]
        return {
            "cells": list(first.grid.shape),
            "size": list(first.grid.size),
            "friction": first.friction,
            "steps": self.rows(),
            "warnings": list(self.warnings),
        }

    def save(self, path: str | Path) -> Path:
        """Write a CSV file, one row per step."""
        return Table(COLUMNS, [_row(contact) for contact in self.contacts]).save(path)

    def __str__(self) -> str:
        shown = ("force", "tangential_x", "tangential_y", "shift_x", "shift_y", "stick_area", "friction_work")
        worst = max(contact.residuals.worst for contact in self.contacts)
        notes = [f"work of friction {self.friction_work.sum():.6g}, worst residual {worst:.1e}"]
        notes += [f"Warning: {text}" for text in self.warnings]
        table = Table(shown, [[row[name] for name in shown] for row in self.rows()], notes)
        return f"Half-space with friction {self.last.friction:g}, {len(self.contacts)} steps\n{table}"


def _row(contact: FrictionContact) -> tuple[float, ...]:
    return (
        contact.force,
        contact.approach,
        *contact.tangential,
        contact.torque,
        *contact.shift,
        contact.twist,
        contact.figures["area"],
        contact.stick_area,
        contact.slip_area,
        contact.friction_work,
        contact.residuals.worst,
    )


def _step(
    friction: Friction,
    heights: Callable[[tuple[float, float]], Array],
    step: PressStep,
    last: FrictionContact | None,
    load_point: tuple[float, float] | None,
    symmetry: bool,
) -> FrictionContact:
    """Contact at the end of a step; one without certified solution is cut in halves where it has one position."""
    start = _start(heights(step.position), step, last, load_point)

    def part(_: Figures, loads: Figures, before: FrictionContact | None) -> FrictionContact:
        return press_step(friction, heights(step.position), PressStep(**loads), before, symmetry)

    halvings = HALVINGS if last is None or last.position == step.position else 0
    *parts, found = in_parts(part, start, _end(step), last, _halfway, halvings)
    return replace(found, parts=tuple(parts)) if parts else found


#: Loads and motions by the names of `PressStep`.
Figures = Mapping[str, Any]


def _start(z: Array, step: PressStep, last: FrictionContact | None, load_point: tuple[float, float] | None) -> Figures:
    """Loads and motions where a step begins: of the last contact, or of the first touch, without any load."""
    if last is None:
        touch = {"force": 0.0, "approach": float(z.min(initial=np.inf)), "load_point": step.load_point}
        still = {"tangential": (0.0, 0.0), "shift": (0.0, 0.0), "torque": 0.0, "twist": 0.0}
        return {**touch, **still, "position": step.position}
    names = ("force", "approach", "tangential", "shift", "torque", "twist", "position")
    return {**{name: getattr(last, name) for name in names}, "load_point": load_point or step.load_point}


def _end(step: PressStep) -> Figures:
    """Loads and motions at the end of a step: zero where nothing is given."""
    end = {**vars(step), "tangential": step.tangential or ((0.0, 0.0) if step.shift is None else None)}
    return {**end, "twist": step.twist or (0.0 if step.torque is None else None)}


def _halfway(start: Figures, end: Figures) -> Figures:
    """Loads and motions half way, with those prescribed that are so at the end."""
    means = {name: (np.asarray(start[name]) + end[name]) / 2 for name in end if end[name] is not None}
    return {name: tuple(v.tolist()) if (v := means.get(name)) is not None and v.ndim else v for name in end}


def solve_path(
    body: SurfaceCompliance,
    heights: Callable[[tuple[float, float]], Array],
    steps: Sequence[PressStep],
    mu: float,
    tolerance: float,
    symmetry: bool = True,
    workers: int | None = None,
) -> FrictionPath:
    """Solve the steps of a path one after the other, see `HalfSpace.press_path`."""
    friction = Friction(body, checks.friction(mu, infinite=True), tolerance, workers)
    steps = items("the steps of a path", steps, "PressStep objects")
    check_thickness(body)
    for k, step in enumerate(steps, 1):
        instance(f"step {k} of the path", step, PressStep)
        if body.periodic and (step.torque or step.twist):
            raise InputError(
                f"Step {k} twists the surface, which then would not repeat: leave out torque and twist, or make the "
                "half-space free.",
                code="torsion-not-periodic",
            )
    if not steps:
        raise InputError("A path needs at least one step; found none. Give a PressStep.", code="no-steps")
    contacts: list[FrictionContact] = []
    for k, step in enumerate(steps, 1):
        last = contacts[-1] if contacts else None
        try:
            contacts.append(_step(friction, heights, step, last, steps[k - 2].load_point if last else None, symmetry))
        except FecontactError as error:
            if len(steps) == 1:
                raise
            raise type(error)(f"Step {k} of {len(steps)}: {error}", code=error.code) from error
    return FrictionPath(tuple(contacts))
