"""Paths of loads on a half-space: steps with friction, their work and wear; without friction curves over the force."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any, ClassVar, cast

import numpy as np

from fecontact.common import checks
from fecontact.common.arguments import instance, items
from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import percent
from fecontact.common.errors import InputError, SolverError
from fecontact.common.fingerprint import fingerprint
from fecontact.common.html import cell
from fecontact.common.path import Path, Steps, each_step
from fecontact.common.renamed import RenamedKeys, renamed, warn
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.common.version import VERSION
from fecontact.halfspace.compliance import SurfaceCompliance, check_thickness
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.friction import Friction, PressStep, certified, press_step
from fecontact.halfspace.pictures import Drawn, plot_over_force
from fecontact.halfspace.pressing import Load
from fecontact.halfspace.traction_contact import FrictionContact
from fecontact.halfspace.viscoelastic import with_time_change

#: Loads and motions by the names of `PressStep`, or figures of a load.
Loads = Mapping[str, Any]

#: Figures of the end of a step.
OF_STEPS: Mapping[str, Callable[[FrictionContact], float]] = {
    "force": lambda contact: contact.force,
    "approach": lambda contact: contact.approach,
    "tangential_x": lambda contact: contact.tangential[0],
    "tangential_y": lambda contact: contact.tangential[1],
    "torque": lambda contact: contact.torque,
    "shift_x": lambda contact: contact.shift[0],
    "shift_y": lambda contact: contact.shift[1],
    "twist": lambda contact: contact.twist,
    "area": lambda contact: contact.figures["area"],
    "stick_area": lambda contact: contact.stick_area,
    "slip_area": lambda contact: contact.slip_area,
    "friction_work": lambda contact: contact.friction_work,
    "worst_residual": lambda contact: contact.residuals.worst,
}
#: Figures of a load of a curve.
OF_LOADS = ("force", "approach", "area", "max_pressure", "mean_pressure", "mean_gap", "regions", "pressure_error")
#: More of both with a hardness.
OF_HARDNESS = ("plastic_area", "max_dent")
#: Columns of a curve that are asked for.
BESIDE = ("stiffness", "conductance", "leakage")
#: What is in the rows of a curve beside figures.
HIDDEN = ("warnings", "dent", "jump")
#: Fields of a contact that a file keeps.
KEPT = (
    "pressure", "displacement", "gap", "traction", "slip", "coarse", "approach", "tilt", "shift", "twist", "position",
    "status", "given", "solver", "tangential_solver", "dent", "plastic",
)  # fmt: skip


@compact_repr
@dataclass(frozen=True, eq=False)
class FrictionPath(Path[FrictionContact]):
    """Contacts at the ends of the steps of a load path; made by `HalfSpace.press_path`.

    Attributes
    ----------
    steps : tuple of FrictionContact
    cuts : tuple of int
        Parts in which every step was solved.
    """

    contacts = renamed("contacts", "steps")
    dissipated, work = renamed("dissipated", "friction_work"), renamed("work", "work_density")

    force = each_step("force", "Normal force (n,) at the ends of the steps.")
    tangential = each_step("tangential", "Tangential force (n, 2) on the half-space by the counter-surface.")
    torque = each_step("torque", "Torque (n,) about the normal.")
    shift = each_step("shift", "Displacement (n, 2) of the counter-surface since the unloaded state.")
    twist = each_step("twist", "Rotation (n,) of the counter-surface since the unloaded state.")
    worn_volume = each_step("worn_volume", "Volume (n,) worn off by the ends of the steps.")
    friction_work = each_step("friction_work", "Work of friction (n,) in each step, not negative.")
    time = each_step("time", "Times (n,) at the ends of the steps; zeros unless they have times.")

    @cached_property
    def work_density(self) -> Array:
        """Work of friction per area (nx, ny) in all steps."""
        return np.asarray(sum(contact.work_density for contact in self.steps))

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
            If the coefficient is not positive, friction is infinite, or the shape has worn already.

        References
        ----------
        J. F. Archard, J. Appl. Phys. 24 (1953) 981.
        """
        k = checks.positive("the coefficient of wear", coefficient)
        if self.last.worn is not None:
            raise InputError("The surface of this path has worn: its depth is last.worn.", code="worn-already")
        return np.asarray(sum(k * contact.sliding_integral for contact in self.steps))

    def wear(self, coefficient: float) -> Array:
        """Former `wear_depth`, with worn volume per work of friction as its coefficient: k over mu. It warns."""
        now = "wear(coefficient) is now wear_depth(coefficient * mu), by Archard's k; the old name will be removed."
        warn(f"FrictionPath.{now}", stacklevel=3)
        return checks.positive("the coefficient of wear", coefficient) * self.work_density

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the contacts, each with the first step that it concerns."""
        places = [f"Step {k}" for k in range(1, len(self) + 1)]
        return self._first_warnings(places, [contact.warnings for contact in self.steps])

    def rows(self) -> list[dict[str, float]]:
        """Figures of each step by name."""
        worn = ("worn_volume", "worn_depth") if self.last.worn is not None else ()
        more = (*(OF_HARDNESS if self.last.hardness is not None else ()), *worn)
        return [
            RenamedKeys({name: read(c) for name, read in OF_STEPS.items()}, **{name: c.figures[name] for name in more})
            for c in self.steps
        ]

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts."""
        grid = self.last.grid
        return {
            "cells": list(grid.shape),
            "size": list(grid.size),
            "friction": self.last.friction,
            "steps": self.rows(),
            "warnings": list(self.warnings),
        }

    def _repr_html_(self) -> str:
        return cell(self)

    def __str__(self) -> str:
        shown = ("force", "tangential_x", "tangential_y", "shift_x", "shift_y", "stick_area", "friction_work")
        worst = self.column("worst_residual").max()
        notes = [f"work of friction {self.friction_work.sum():.6g}, worst residual {worst:.1e}"]
        notes += [f"Warning: {text}" for text in self.warnings]
        table = Table(shown, [[row[name] for name in shown] for row in self.rows()], notes)
        return f"Half-space with friction {self.last.friction:g}, {len(self)} steps\n{table}"


class Curve(Path[Mapping[str, Any]], Drawn):
    """Figures of contacts by one of them: forces or approaches that were given.

    Attributes
    ----------
    steps : tuple of dict
        Figures and warnings of each contact.
    """

    by: ClassVar[str]

    force = property(lambda self: self.figures["force"], doc="Forces (n,); tension is negative.")
    approach = property(lambda self: self.figures["approach"], doc="Approaches (n,).")
    area = property(lambda self: self.figures["area"], doc="Areas (n,), with the edge located within the cells.")

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, each with the first force or approach that it concerns."""
        places = [f"At the {self.by} {row[self.by]:g}" for row in self.steps]
        return self._first_warnings(places, [row["warnings"] for row in self.steps])

    def rows(self) -> list[dict[str, float]]:
        """Figures of each contact by name."""
        return [{name: value for name, value in row.items() if name not in HIDDEN} for row in self.steps]

    @property
    def _notes(self) -> list[str]:
        """Lines below the table."""
        return []

    @property
    def table(self) -> Table:
        """Figures, a row per contact, with what is printed below."""
        notes = [*self._notes, *(f"Warning: {text}" for text in self.warnings)]
        return Table(list(self.figures), [list(row.values()) for row in self.rows()], notes)

    def __str__(self) -> str:
        return str(self.table)


@compact_repr
@dataclass(frozen=True, eq=False)
class LoadCurve(Curve):
    """Figures of contacts over the force, whose loads do not depend on each other; made by `HalfSpace.curve`.

    Drawn are approach, area, pressures, mean gap and what was asked for beside over the force.

    Attributes
    ----------
    steps : tuple of dict
        Of each load in the order given: force, approach, area, max_pressure, mean_pressure, mean_gap, regions (their
        number), pressure_error (estimated, relative), what was asked for beside, and warnings. With a hardness also
        plastic_area, max_dent and the dent (nx, ny), from which the next load starts.
    """

    by: ClassVar = "force"
    to_csv = renamed("to_csv", "save")

    def _drawn(self, path: str | FilePath | None, units: Units) -> Any:
        panels = {
            units.axis_label("approach", "length"): {"": self.approach},
            "area" + (f" [{units.length}²]" if units.length else ""): {"": self.area},
            units.axis_label("pressure", "stress"): {n: self.figures[f"{n}_pressure"] for n in ("max", "mean")},
            units.axis_label("mean gap", "length"): {"": self.figures["mean_gap"]},
            **{name: {"": self.figures[name]} for name in BESIDE if name in self.figures},
        }
        return plot_over_force(self.force, panels, f"{len(self)} loads", units, path, "dent" in self.steps[0])


@dataclass(frozen=True, eq=False)
class FrictionSteps(Steps[FrictionContact]):
    """Steps of a surface with heights (nx, ny) by its position, see `HalfSpace.press_path`.

    Raises
    ------
    InputError
        If there are none, one is no step, or it twists a periodic surface, or layers are not bonded.
    """

    friction: Friction
    heights: Callable[[tuple[float, float]], Array]
    steps: Sequence[PressStep]
    symmetry: bool
    start: FrictionContact | None = field(default=None, kw_only=True)
    accuracy: float | None = field(default=None, kw_only=True)
    wears: ClassVar = False

    def __post_init__(self) -> None:
        check_thickness(self.friction.body)
        timed = self.accuracy is not None and checks.positive("the accuracy", self.accuracy)
        if timed and not self.friction.body.memory:
            raise InputError(
                "An elastic half-space has no error in time: leave out accuracy=.", code="accuracy-elastic"
            )
        if self.start is not None:
            instance("the start of the path", self.start, FrictionContact)
            body, mu = self.friction.body, self.friction.mu
            then = (self.start.grid, self.start.material, tuple(self.start.layers), self.start.friction)
            forgot = body.memory and self.start.retarded is None
            if forgot or then != (body.grid, body.material, tuple(body.layers), mu):
                raise InputError(
                    f"The start of the path is of another half-space, grid or friction ({self.start.friction:g}; found "
                    f"{mu:g}). Make it on the half-space of the path, with its friction.",
                    code="other-grid",
                )
        for k, step in enumerate(items("the steps of a path", self.steps, "PressStep objects"), 1):
            instance(f"step {k} of the path", step, PressStep)
            if step.cycles is not None and not self.wears:
                raise InputError(
                    f"Step {k} has {step.cycles:g} cycles, which count with wear only: give wear=, or leave them out.",
                    code="cycles-without-wear",
                )
            if self.friction.body.periodic and (step.torque or step.twist):
                raise InputError(
                    f"Step {k} twists the surface, which then would not repeat: leave out torque and twist, or make "
                    "the half-space free.",
                    code="torsion-not-periodic",
                )
        if not self.steps:
            raise InputError("A path needs at least one step; found none. Give a PressStep.", code="no-steps")

    def halvings(self, k: int, before: FrictionContact | None) -> int:
        """None where the position changes: at places in between the surface would rub."""
        before = before or self.start
        return self.most_halvings if before is None or before.position == self.steps[k].position else 0

    def part(
        self, k: int, before: FrictionContact | None, start: float, end: float, last: FrictionContact | None,
        known: Any = None,
    ) -> FrictionContact:  # fmt: skip
        """Contact at the end of a part of step k."""
        before, last = before or self.start, last or self.start
        z, loads = self.heights(self.steps[k].position), self.loads(k, before, end)
        given = self.friction, z, loads, last
        found = press_step(*given, self.symmetry) if known is None else certified(*given, known)
        if self.friction.body.memory is None:
            return found
        middle = self.loads(k, before, (start + end) / 2)
        found = with_time_change(self.friction, self.heights(middle.position), middle, last, found, self.symmetry)
        error, before_it = (max((at and at.time_error) or (0.0,)) for at in (found, last))
        cuttable = known is None and end - start > 0.5 ** self.halvings(k, before)
        # what earlier steps have left no smaller ones take away
        if cuttable and self.accuracy is not None and error > max(self.accuracy, before_it):
            raise SolverError(f"Steps in time of this size err by {percent(error)}.")
        return found

    def loads(self, k: int, before: FrictionContact | None, share: float) -> PressStep:
        """Loads a share of the way through step k."""
        step = self.steps[k]
        begin = _start(self.heights(step.position), step, before, self.steps[k - 1].load_point if k else None)
        return PressStep(**_between(begin, _end(step), share))

    def joined(self, parts: Sequence[FrictionContact]) -> FrictionContact:
        """The last part, with those before it."""
        return replace(parts[-1], parts=tuple(parts[:-1])) if len(parts) > 1 else parts[0]

    def end(self, part: FrictionContact) -> Loads:
        """Fields that are not those of the half-space."""
        return {name: getattr(part, name) for name in KEPT}

    def row(self, result: FrictionContact) -> Loads:
        """The summary."""
        return result.summary()

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each step by its number."""
        steps = [{**vars(step), "heights": self.heights(step.position)} for step in self.steps]
        if self.start is not None:
            steps[0]["start"] = self.end(self.start)
        own = self.friction
        return prints_of(own.body, steps, friction=own.mu, tolerance=own.tolerance, hardness=own.hardness)


@dataclass(frozen=True, eq=False)
class CurveSteps(Steps[Mapping[str, Any]]):
    """Loads of a curve and how heights are pressed by them, see `HalfSpace.curve`.

    They do not depend on each other, but by the dents that they leave.
    """

    body: SurfaceCompliance
    heights: Array
    loads: Sequence[Load]
    pressed: Callable[[Array, Load], HalfSpaceContact]
    tolerance: float
    hardness: Array | None = None
    also: Mapping[str, Callable[[HalfSpaceContact], float]] = field(default_factory=dict)

    def part(
        self, k: int, before: Loads | None, start: float, end: float, last: Loads | None, known: Any = None
    ) -> Loads:
        """Figures and warnings of load k."""
        if known is not None:
            return cast(Loads, known)
        dent = 0.0 if last is None or self.hardness is None else last["dent"]
        contact = self.pressed(self.heights + dent if self.hardness is not None else self.heights, self.loads[k])
        more = {"regions": float(contact.n_regions), "pressure_error": contact.error_estimate.pressure}
        found = {**contact.figures, **more}
        figures: dict[str, Any] = {name: found[name] for name in (*OF_LOADS, *OF_HARDNESS) if name in found}
        if contact.dent is not None:
            figures["dent"] = contact.dent + dent
        return {**figures, **{name: read(contact) for name, read in self.also.items()}, "warnings": contact.warnings}

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each load by its number."""
        settings = {"heights": self.heights, "tolerance": self.tolerance, "hardness": self.hardness}
        settings |= {"columns": sorted(self.also)} if self.also else {}
        return prints_of(self.body, [vars(load) for load in self.loads], **settings)


def prints_of(body: SurfaceCompliance, steps: Sequence[Loads], **settings: Any) -> dict[str, dict[str, str]]:
    """Fingerprints by part of each step by its number."""
    given = {name: fingerprint(value) for name, value in settings.items() if value is not None}
    same = {"fecontact": VERSION, "half-space": fingerprint(body), **given}
    return {str(k): {**same, **{name: fingerprint(v) for name, v in step.items()}} for k, step in enumerate(steps, 1)}


def _start(z: Array, step: PressStep, last: FrictionContact | None, load_point: tuple[float, float] | None) -> Loads:
    """Loads and motions where a step begins: of the last contact, or of the first touch, without any load."""
    if last is None:
        touch = {"force": 0.0, "approach": float(z.min(initial=np.inf)), "load_point": step.load_point}
        still = {"tangential": (0.0, 0.0), "shift": (0.0, 0.0), "torque": 0.0, "twist": 0.0}
        return {**touch, **still, "position": step.position, "time": 0.0}
    names = ("force", "approach", "tangential", "shift", "torque", "twist", "position", "time")
    return {**{name: getattr(last, name) for name in names}, "load_point": load_point or step.load_point}


def _end(step: PressStep) -> Loads:
    """Loads and motions at the end of a step: zero where nothing is given."""
    end = {**vars(step), "tangential": step.tangential or ((0.0, 0.0) if step.shift is None else None), "cycles": None}
    return {**end, "twist": step.twist or (0.0 if step.torque is None else None)}


def _between(start: Loads, end: Loads, share: float) -> Loads:
    """Loads and motions a share of the way through a step, with those prescribed that are so at its end."""
    if share == 1:
        return end
    both = {name: (np.asarray(start[name]), np.asarray(value)) for name, value in end.items() if value is not None}
    found = {name: (1 - share) * one + share * other for name, (one, other) in both.items()}
    return {name: tuple(v.tolist()) if (v := found.get(name)) is not None and v.ndim else v for name in end}
