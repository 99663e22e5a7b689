"""Wear that changes the shape on half-spaces: load steps of a surface that wears, see `common.wear`.

Slip is needed in all cells, for what is open may come to touch. Worn depth is that of both surfaces together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.fingerprint import fingerprint
from fecontact.common.wear import NO_CYCLE, check_change, faded, steady, worn_in_halves
from fecontact.halfspace.compliance import Box
from fecontact.halfspace.friction import DraggedTractions, PressStep, certified, press_step, restored
from fecontact.halfspace.path import KEPT, FrictionSteps
from fecontact.halfspace.pressing import press
from fecontact.halfspace.traction_contact import FrictionContact

#: Overlap left at an approach, over the worn depth, at which all is worn off: below it pressures are rounding.
WORN_OFF = 1e-5

#: Fields of a contact that a file keeps, with wear.
OF_WEAR = ("worn", "wear_change", "cycles")


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
            raise InputError(NO_CYCLE, code="no-cycle")
        for k, step in enumerate(self.steps, 1):
            if tuple(step.position) != tuple(self.steps[0].position):
                raise InputError(
                    f"Step {k} is at the position {step.position}, the first at {self.steps[0].position}: worn depth "
                    "stays where the contact is. Slide the surface by shift instead.",
                    code="wear-position",
                )

    def part(
        self, k: int, before: FrictionContact | None, start: float, end: float, last: FrictionContact | None,
        known: Any = None,
    ) -> FrictionContact:  # fmt: skip
        """Contact at the end of a part of step k, worn; a step that is passed several times has parts of its cycles."""
        if known is not None:
            return self._again(k, before, end, known)
        none, once = np.zeros(self.friction.body.grid.shape), self.steps[k].cycles is None
        half, found, worn, change = worn_in_halves(
            lambda share, at, depth: self._leg(k, before, share, at, depth),
            lambda length, share, depth, leg: self._worn(k, before, length, share, depth, leg),
            (start, end), last, none if last is None or last.worn is None else last.worn, once,
        )  # fmt: skip
        assert found is not None
        check_change(change, worn, float(np.abs(found.displacement).max()), (start, end))
        if last is not None and last.wear_change is not None:
            change = faded(change, last.wear_change, found.pressure, last.pressure, not once)
        cycles, parts = self.steps[k].cycles, (replace(half, origin=None),) if once and half is not None else ()
        return replace(found, worn=worn, wear_change=change, cycles=cycles, parts=parts)

    def _again(self, k: int, before: FrictionContact | None, end: float, known: Mapping[str, Any]) -> FrictionContact:
        """The same of an earlier run: what touches and slips on the worn shape is certified, its depth is as it was."""
        fields, more = {name: known[name] for name in KEPT}, {name: known[name] for name in OF_WEAR}
        origin = known["origin"] and restored(self.friction, FrictionContact, known["origin"])
        z = self._shape(k, more["worn"])
        found = certified(self.friction, z, self._loads(k, before, end), origin, fields)
        return replace(found, **more, origin=origin, parts=() if more["cycles"] or not origin else (origin,))

    def end(self, part: FrictionContact) -> Mapping[str, Any]:
        """Fields that are not those of the half-space, and those of the state from which slip is counted."""
        worn = {name: getattr(part, name) for name in OF_WEAR}
        return {**super().end(part), **worn, "origin": part.origin and super().end(part.origin)}

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each step by its number."""
        return {k: {**parts, "wear": fingerprint(self.wear)} for k, parts in super().prints().items()}

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
    ) -> tuple[Array, FrictionContact | None]:
        """Slip (nx, ny) on a way to a share of step k on a worn shape, and the contact there; of a steady cycle."""
        friction, step, z = self.friction, self._loads(k, before, share), self._shape(k, worn)

        def passage(start: FrictionContact | None) -> tuple[Array, Array, FrictionContact | None]:
            if self.steps[k].cycles is not None:
                start = press_step(friction, z, self.loads(k - 1, None, 1.0), start, self.symmetry)
            found = press_step(friction, z, step, start, self.symmetry)
            origin = start and replace(start, origin=None, parts=())
            return self._slip(step, start, found), found.pressure, replace(found, origin=origin)

        if self.steps[k].cycles is not None:
            return steady(passage, last, k)
        slip, _, found = passage(last)
        return slip, found

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
        leg: tuple[Array, FrictionContact | None],
    ) -> Array:  # fmt: skip
        """Worn depth (nx, ny) after a part of step k, by the slip and the tractions of a leg on the shape before."""
        (slip, found), step, cycles = leg, self._loads(k, before, end), self.steps[k].cycles
        assert found is not None
        by_traction = 0.0 if self.friction.lift is None else self.friction.lift.apply(found.traction)[0]
        own = self.wear * slip * (cycles * part if cycles else 1.0)
        pressed = press(
            self.friction.body, self._shape(k, worn) + by_traction, step.normal_load,
            self.friction.tolerance, self.symmetry, self.friction.workers, own=own,
        )  # fmt: skip
        worn = worn + own * pressed.pressure
        left = math.inf  # also where the surfaces, not worn, are apart
        if step.approach is not None and step.approach > self._shape(k, 0.0 * worn).min():
            left = step.approach - float(self._shape(k, worn).min())
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
