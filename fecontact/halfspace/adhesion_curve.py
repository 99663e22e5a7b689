"""Curves of a surface that adheres to a half-space: coming on and off, with jumps and the pull-off."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import percent
from fecontact.common.path import Steps
from fecontact.common.units import Units
from fecontact.halfspace.adhesion import Adhesive, Given, State
from fecontact.halfspace.path import Curve, prints_of
from fecontact.halfspace.pictures import draw_adhesion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Energy lost in a step of a curve, over force times approach, from which it is halved, how often, and the difference
#: of forces to which the pull-off is located.
LOST, HALVINGS, PULLED = 0.05, 7, 2e-3
#: Columns of a curve.
FIGURES = (
    "approach", "force", "area", "adhesive_area", "max_pressure", "energy", "stability", "force_error", "area_error",
    "worst_residual",
)  # fmt: skip


class Jump(NamedTuple):
    """A jump of a curve: approach just after it, forces before and after, energy lost, and whether surfaces come on."""

    approach: float
    before: float
    after: float
    lost: float
    on: bool

    def __str__(self) -> str:
        way = "on" if self.on else "off"
        return f"Jumps {way} at the approach {self.approach:.6g}: force {self.before:.6g} to {self.after:.6g}"


@compact_repr
@dataclass(frozen=True, eq=False)
class AdhesionCurve(Curve):
    """States of a surface that adheres, one after the other; made by `HalfSpace.curve` with `adhesion`.

    Drawn is the force over the approach, coming on and off, with the pull-off.

    Attributes
    ----------
    steps : tuple of dict
        Of each approach in the order given, and of others between them where the curve jumps or the pull-off is
        located: approach, force, area, adhesive_area, max_pressure, energy, stability, force_error and area_error
        (estimated, relative), worst_residual, warnings, and the jump to it or None.
    """

    by: ClassVar = "approach"

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Jumps in their order."""
        return tuple(Jump(*row["jump"]) for row in self.steps if row["jump"])

    @cached_property
    def _least(self) -> int:
        """State of the smallest force while coming off; of all, if the path only comes on."""
        off = coming_off(self.steps)
        return int(np.where(off | (not off.any()), self.force, np.inf).argmin())

    @property
    def pull_off(self) -> float:
        """Largest tensile force while coming off; 0 without any."""
        return max(0.0, -float(self.force[self._least]))

    @property
    def pull_off_approach(self) -> float:
        """Approach at the pull-off."""
        return float(self.approach[self._least])

    @property
    def hysteresis(self) -> float:
        """Energy lost: work of the force, by the rule of trapezoids, less the energy gained; in a loop its area."""
        return float(np.trapezoid(self.force, self.approach) - np.diff(self.figures["energy"][[0, -1]])[0])

    def _draw_in(self, ax: Axes, units: Units) -> None:
        draw_adhesion(ax, self, units)

    @property
    def _notes(self) -> list[str]:
        error = percent(self.figures["force_error"][self._least])
        pulled = f"Pull-off {self.pull_off:.6g} at the approach {self.pull_off_approach:.6g}, error about {error}"
        return [*([pulled] if self.pull_off else []), *map(str, self.jumps), f"Energy lost {self.hysteresis:.6g}"]


def coming_off(rows: Sequence[Mapping[str, Any]]) -> Mask:
    """Whether the approach falls to states (n,)."""
    return np.diff([row["approach"] for row in rows], prepend=-np.inf) < 0


class Point(NamedTuple):
    """A point of a curve; those from files have no state."""

    row: Mapping[str, Any]
    share: Array
    state: State | None = None

    def lost_to(self, other: Point) -> float:
        """Energy lost up to another point, but for the rule of trapezoids."""
        step = other.row["approach"] - self.row["approach"]
        return (self.row["force"] + other.row["force"]) / 2 * step - (other.row["energy"] - self.row["energy"])


@dataclass(frozen=True, eq=False)
class ApproachSteps(Steps[tuple[Point, ...]]):
    """Approaches of a surface that adheres, see `HalfSpace.curve`; of each the points after the one before."""

    adhesive: Adhesive
    approaches: Sequence[float]
    most_halvings: ClassVar = 0  # they are halved by the energy that they lose

    def part(
        self, k: int, before: tuple[Point, ...] | None, start: float, end: float, last: tuple[Point, ...] | None,
        known: Any = None,
    ) -> tuple[Point, ...]:  # fmt: skip
        """Points up to approach k."""
        if known is not None:
            return tuple(Point(**point) for point in known)
        if before is None:
            return (self.point(self.approaches[k]),)
        a = before[-1]
        if self.approaches[k] == a.row["approach"]:
            return (a,)
        b = self.point(self.approaches[k], a)
        step = abs(b.row["approach"] - a.row["approach"])
        allowed = LOST * step * max(abs(a.row["force"]), abs(b.row["force"]))
        return tuple(self.between(a, b, allowed, HALVINGS))

    def point(self, approach: float, last: Point | None = None, judged: bool = True) -> Point:
        """The point after another one, with estimates of its errors or without."""
        contact, state = self.adhesive.contact(Given(approach), *(last[1:] if last else ()))
        contact = self.adhesive.judged(contact, state) if judged else contact
        found = {"force_error": contact.response_error.force or math.nan, "area_error": contact.error_estimate.area}
        found |= {**contact.figures, "worst_residual": max(contact.residuals.worst, contact.law_residual)}
        row = {name: found[name] for name in FIGURES} | {"warnings": contact.warnings, "jump": None}
        return Point(row, state.share, state)

    def middle(self, a: Point, b: Point) -> Point:
        """The point half way to another one."""
        return self.point((a.row["approach"] + b.row["approach"]) / 2, a, judged=False)

    def between(self, a: Point, b: Point, allowed: float, depth: int) -> Iterator[Point]:
        """Points after one up to another: halved where energy is lost, and where the surfaces meet or part."""
        lost, grows = a.lost_to(b), b.row["adhesive_area"] - a.row["adhesive_area"]
        if lost <= allowed and (a.row["adhesive_area"] > 0) == (b.row["adhesive_area"] > 0):
            yield b
        elif depth == 0:
            jump = Jump(b.row["approach"], a.row["force"], b.row["force"], lost, grows > 0)
            yield b._replace(row={**b.row, "jump": tuple(jump)})
        else:
            half = self.middle(a, b)
            yield from self.between(a, half, allowed, depth - 1)
            if half.lost_to(b) > allowed:
                b = self.point(b.row["approach"], half)
            yield from self.between(half, b, allowed, depth - 1)

    def end(self, part: tuple[Point, ...]) -> Any:
        """Rows and shares."""
        return [{"row": point.row, "share": point.share} for point in part]

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each approach by its number."""
        settings = {"heights": self.adhesive.heights, "adhesion": self.adhesive.law}
        steps = [{"approach": approach} for approach in self.approaches]
        return prints_of(self.adhesive.body, steps, **settings, tolerance=self.adhesive.tolerance)

    def curve(self, parts: Sequence[tuple[Point, ...]]) -> AdhesionCurve:
        """The curve, with points put round the smallest force of coming off until it is located."""
        every = [point for part in parts for point in part]
        at = [point.row["approach"] for point in every]
        points = [point for k, point in enumerate(every) if k == 0 or at[k] != at[k - 1]]
        steps = np.abs(np.diff(self.approaches))
        least = steps[steps > 0].min(initial=np.inf) / 2**HALVINGS
        while True:
            force = np.array([point.row["force"] for point in points])
            k = int(np.where(coming_off([point.row for point in points]), force, np.inf).argmin())
            around = force[max(k - 1, 0) : k + 2]
            a, b, c = points[max(k - 1, 0)], points[k], points[min(k + 1, len(points) - 1)]
            wide = abs(c.row["approach"] - a.row["approach"]) > 2.5 * least
            if len(around) < 3 or force[k] >= 0 or not wide or around.max() - force[k] <= PULLED * abs(force[k]):
                if math.isnan(b.row["force_error"]) and force[k] < 0:  # estimates for what lies between those given
                    row = self.point(b.row["approach"], b).row
                    points[k] = b._replace(row={**row, "jump": b.row["jump"]})
                return AdhesionCurve(tuple(point.row for point in points), (1,) * len(points))
            points[k - 1 : k + 2] = [a, self.middle(a, b), b, self.middle(b, c), c]
