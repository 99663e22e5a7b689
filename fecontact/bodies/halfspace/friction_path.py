"""A path of loads on a half-space with friction: its steps, the work of friction, wear."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.bodies.halfspace.compliance import SurfaceCompliance
from fecontact.bodies.halfspace.friction import Friction, PressStep, press_step
from fecontact.bodies.halfspace.friction_contact import FrictionContact
from fecontact.common import checks
from fecontact.common.arguments import instance, items
from fecontact.common.arrays import Array
from fecontact.common.errors import FecontactError, InputError
from fecontact.common.files import save_rows
from fecontact.common.one_line import one_line

COLUMNS = (
    "force",
    "approach",
    "tangential_x",
    "tangential_y",
    "torque",
    "shift_x",
    "shift_y",
    "twist",
    "contact_area",
    "stick_area",
    "dissipated",
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
    def dissipated(self) -> Array:
        """Work of friction (n,) in each step, not negative."""
        return np.array([contact.dissipated for contact in self.contacts])

    @cached_property
    def work(self) -> Array:
        """Work of friction per area (nx, ny) in all steps."""
        return np.asarray(sum(contact.work for contact in self.contacts))

    def wear(self, coefficient: float) -> Array:
        """Depth of wear (nx, ny) in all steps by the dissipated work, not fed back into the shape.

        Parameters
        ----------
        coefficient : float
            Worn volume per work of friction; Archard's coefficient over mu.

        Raises
        ------
        InputError
            If the coefficient is not positive.

        References
        ----------
        J. F. Archard, J. Appl. Phys. 24 (1953) 981; S. Fouvry, P. Kapsa, L. Vincent, Wear 200 (1996) 186.
        """
        return checks.positive("the coefficient of wear", coefficient) * self.work

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
        return [dict(zip(COLUMNS, _row(contact), strict=True)) for contact in self.contacts]

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
        return save_rows(path, COLUMNS, map(_row, self.contacts))

    def __str__(self) -> str:
        shown = ("force", "tangential_x", "tangential_y", "shift_x", "shift_y", "stick_area", "dissipated")
        lines = ["".join(f"{row[name]:>15.6g}" for name in shown) for row in self.rows()]
        worst = max(contact.friction_residuals.worst for contact in self.contacts)
        return "\n".join(
            [
                f"Half-space with friction {self.last.friction:g}, {len(self.contacts)} steps",
                "".join(f"{name:>15}" for name in shown),
                *lines,
                f"work of friction {self.dissipated.sum():.6g}, worst residual {worst:.1e}",
                *(f"Warning: {text}" for text in self.warnings),
            ]
        )


def _row(contact: FrictionContact) -> tuple[float, ...]:
    return (
        contact.force,
        contact.approach,
        *contact.tangential,
        contact.torque,
        *contact.shift,
        contact.twist,
        contact.area,
        contact.stick_area,
        contact.dissipated,
        contact.friction_residuals.worst,
    )


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
    for k, step in enumerate(steps, 1):
        instance(f"step {k} of the path", step, PressStep)
        if body.periodic and (step.torque or step.twist):
            raise InputError(
                f"Step {k} twists the surface, which then would not repeat: leave out torque and twist, or make the "
                "half-space free."
            )
    if not steps:
        raise InputError("A path needs at least one step; found none. Give a PressStep.")
    contacts: list[FrictionContact] = []
    for k, step in enumerate(steps, 1):
        last = contacts[-1] if contacts else None
        try:
            contacts.append(press_step(friction, heights(step.position), step, last, symmetry))
        except FecontactError as error:
            if len(steps) == 1:
                raise
            raise type(error)(f"Step {k} of {len(steps)}: {error}") from error
    return FrictionPath(tuple(contacts))
