"""Wear that changes the shape: load steps of a surface that wears by Archard's law, dh = k p |ds|.

The depth that wears off while a point slips by s, n times, grows with the pressure p at the end, h = k n s p: a
compliance k n s of each cell for itself, beside that of the bodies. So a step is solved as a contact is, and is stable
however much wears off (Euler's backward rule); explicit steps are stable only while k n s is below the compliance of a
cell. Slip is that of the shape before the step, in all cells, for what is open may come to touch.

A step that is passed many times has the slip of a steady cycle: from the end of the step before to its own and back,
until that does not change. What sticks does not wear.

Each step is solved at once and in two halves: the error of the halves is about their difference, cell by cell. Where it
is large the step is cut. The errors of all steps are added up with their signs; in a load cycle earlier ones fade as
the pressure does, which all that wears lowers to the same limit.

References
----------
J. F. Archard, J. Appl. Phys. 24 (1953) 981; N. Stroemberg, L. Johansson, A. Klarbring, Int. J. Solids Struct. 33 (1996)
1817 (wear and contact in one implicit step).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SolverError
from fecontact.common.path import HALVINGS
from fecontact.halfspace.compliance import Box
from fecontact.halfspace.contact import FrictionContact
from fecontact.halfspace.friction import DraggedTractions, PressStep, press_step
from fecontact.halfspace.path import FrictionSteps
from fecontact.halfspace.pressing import Load, press

#: Error of the worn depth by the size of a step from which the step is cut, relative to the largest depth, or to the
#: largest displacement if that is more: smaller errors move no pressures.
WEAR_ERROR = 0.01

#: Change of what a passage wears, relative, at which a cycle is steady, and most cycles until then. Like bodies are
#: steady after one; the slip of unlike ones settles as a power of their number, after ten or so to this.
STEADY, MAX_CYCLES = 1e-3, 40

#: Overlap left at an approach, over the worn depth, at which all is worn off: below it pressures are rounding.
WORN_OFF = 1e-5


@dataclass(frozen=True, eq=False)
class WornSteps(FrictionSteps):
    """Steps of a path whose surfaces wear, see `HalfSpace.press_path`.

    Raises
    ------
    InputError
        If friction is infinite, a first step is to be passed several times, or a step is at another position.
    """

    wear: float
    wears: ClassVar = True

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("the coefficient of wear", self.wear)
        if np.isinf(self.friction.mu):
            raise InputError("Infinite friction has no sliding and no wear. Give a finite coefficient.", code="no-slip")
        if self.steps[0].cycles is not None:
            raise InputError(
                "Step 1 is to be passed several times, but there is no step before it to go back to. Give the loads at "
                "the other end of the cycle as a first step, without cycles.",
                code="no-cycle",
            )
        for k, step in enumerate(self.steps, 1):
            if tuple(step.position) != tuple(self.steps[0].position):
                raise InputError(
                    f"Step {k} is at the position {step.position}, the first at {self.steps[0].position}: worn depth "
                    "stays where the contact is. Slide the surface by shift instead.",
                    code="wear-position",
                )

    def part(
        self, k: int, before: FrictionContact | None, start: float, end: float, last: FrictionContact | None,
        known: None = None,
    ) -> FrictionContact:  # fmt: skip
        """Contact at the end of a part of step k, worn; a step that is passed several times has parts of its cycles."""
        middle, once = (start + end) / 2, self.steps[k].cycles is None
        worn = np.zeros(self.friction.body.grid.shape) if last is None or last.worn is None else last.worn
        leg = self._leg(k, before, end, last, worn)
        whole = self._worn(k, before, end - start, end, worn, leg)
        leg = self._leg(k, before, middle, last, worn) if once else leg
        worn = self._worn(k, before, middle - start, middle, worn, leg)
        slip, half = self._leg(k, before, middle, last, worn)
        leg = self._leg(k, before, end, half, worn) if once else (slip, half)
        worn = self._worn(k, before, end - middle, end, worn, leg)
        found = replace(self._leg(k, before, end, half, worn)[1], worn=worn, cycles=self.steps[k].cycles)
        change = whole - worn
        largest = max(float(worn.max()), float(np.abs(found.displacement).max()))
        if np.abs(change).max() > WEAR_ERROR * largest and end - start > 0.5**HALVINGS:
            raise SolverError(f"The worn depth changes by {np.abs(change).max():.3g} with steps of half the size.")
        if last is not None and last.wear_change is not None:
            left = np.divide(found.pressure, last.pressure, out=np.ones(change.shape), where=last.pressure > 0)
            change = change + last.wear_change * (np.minimum(left, 1.0) if found.cycles else 1.0)
        return replace(found, wear_change=change, parts=(half,) if once else ())

    def joined(self, parts: Sequence[FrictionContact]) -> FrictionContact:
        """The last part; of a step passed once with all before it, else it is a passage by itself."""
        if parts[-1].cycles:
            return parts[-1]
        return super().joined([replace(one, parts=()) for part in parts for one in (*part.parts, part)])

    def _loads(self, k: int, before: FrictionContact | None, share: float) -> PressStep:
        """Loads a share of the way through step k; at its end if that is passed several times."""
        return self.loads(k, before, 1.0 if self.steps[k].cycles else share)

    def _leg(
        self, k: int, before: FrictionContact | None, share: float, last: FrictionContact | None, worn: Array
    ) -> tuple[Array, FrictionContact]:
        """Slip (nx, ny) on a way to a share of step k on a worn shape, and the contact there; of a steady cycle."""
        friction, step, z = self.friction, self._loads(k, before, share), self._shape(k, worn)
        if self.steps[k].cycles is None:
            found = press_step(friction, z, step, last, self.symmetry)
            return self._slip(step, last, found), found
        slip, back = None, self.loads(k - 1, None, 1.0)
        for _ in range(MAX_CYCLES):
            there = press_step(friction, z, back, last, self.symmetry)
            last = press_step(friction, z, step, there, self.symmetry)
            slip, earlier = self._slip(step, there, last), slip
            p = last.pressure
            if earlier is not None and np.vdot(np.abs(slip - earlier), p) <= STEADY * np.vdot(slip, p):
                return slip, last
        raise SolverError(
            f"The slip still changes after {MAX_CYCLES} cycles between the loads of step {k} and of step {k + 1}: the "
            "contact finds no steady cycle. Give its passages one by one."
        )

    def _shape(self, k: int, worn: Array) -> Array:
        """Heights (nx, ny) of the surface in step k with a worn depth."""
        return self.heights(self.steps[k].position) + worn

    def _slip(self, step: PressStep, last: FrictionContact | None, found: FrictionContact) -> Array:
        """Length (nx, ny) of the slip since the last contact, zero where it sticks, also where nothing touches."""
        everywhere = _Everywhere(self.friction, found, step, last)
        motion = np.array([*found.shift, found.twist]) - everywhere.before
        slip = everywhere.problem.slip(found.traction, motion[everywhere.free])
        return np.where(found.sticking, 0.0, np.hypot(slip[0], slip[1]))

    def _worn(
        self, k: int, before: FrictionContact | None, part: float, end: float, worn: Array,
        leg: tuple[Array, FrictionContact],
    ) -> Array:  # fmt: skip
        """Worn depth (nx, ny) after a part of step k, by the slip and the tractions of a leg on the shape before."""
        (slip, found), step, cycles = leg, self._loads(k, before, end), self.steps[k].cycles
        by_traction = 0.0 if self.friction.lift is None else self.friction.lift.apply(found.traction)[0]
        own = self.wear * slip * (cycles * part if cycles else 1.0)
        pressed = press(
            self.friction.body, self._shape(k, worn) + by_traction, Load(step.force, step.approach, step.load_point),
            self.friction.tolerance, self.symmetry, self.friction.workers, own=own,
        )  # fmt: skip
        worn = worn + own * pressed.pressure
        left = math.inf if step.approach is None else step.approach - float(self._shape(k, worn).min())
        if worn.any() and left < WORN_OFF * worn.max():
            raise InputError(
                f"All is worn off: at an approach of {step.approach:g} nothing is pressed any more after a worn depth "
                f"of {worn.max():.6g}. End the path before, or prescribe the force.",
                code="worn-off",
            )
        return np.asarray(worn)


@dataclass(frozen=True, eq=False)
class _Everywhere(DraggedTractions):
    """Tractions with the slip of all cells, not of those near the contact alone."""

    @property
    def box(self) -> Box:
        """The grid."""
        return slice(0, self.normal.grid.shape[0]), slice(0, self.normal.grid.shape[1])
