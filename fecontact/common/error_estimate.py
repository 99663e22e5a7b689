"""Estimated discretisation errors of a contact, and of the forces and motions of a solution."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from fecontact.common.compact_repr import compact_repr

#: Estimated error of the pressure, its peak or the area above which a result warns.
MAX_ERROR = 0.1
#: Faces across a contact below which its peak and area carry no figure: what a few faces tell may be off by any amount.
MIN_ACROSS = 3.0
#: Error of the energy over the squared one of the pressure on half-spaces, whose pressures are judged in the centres of
#: their cells; on faces and foundations it is one.
OF_CELLS = 3.0
#: Least squared error, times the squared number of cells across, on layers: where a pressure depends on its own cell
#: alone it is right in the centres, but not its sum over cells that the edge cuts.
OF_LAYERS = 0.3
#: Reason for no estimate.
NO_CONTACT = "no contact, nothing to estimate"
#: The same of a set of nodes.
NO_FIELD = "forces on single nodes, no field to estimate"


class UnboundedPeak(NamedTuple):
    """A pressure that grows without bound towards an edge or a tip.

    Attributes
    ----------
    body : str
        Name of the body with the edge.
    point : (float, float, float)
        Point of the contact at the edge where the pressure found is largest.
    exponent : float
        Of the inverse distance from the edge; zero for a logarithm, as under the tip of a cone or the ridge of a wedge.
    """

    body: str
    point: tuple[float, float, float]
    exponent: float

    @property
    def where(self) -> str:
        """The edge or tip in words."""
        return f"the {'edge' if self.exponent else 'tip'} of {self.body!r}"

    def __str__(self) -> str:
        place = ", ".join(f"{v:.4g}" for v in self.point)
        order = f"as distance^-{self.exponent:.2g}" if self.exponent else "as a logarithm"
        return f"unbounded at {self.where}, {order}, first at ({place})"


@compact_repr
@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated errors of one contact at the force that was found, all relative; see `ResponseError` for forces.

    A figure of 1 stands for 100 % or more.

    Where the pressure is unbounded, faces at the edge concerned count neither in `pressure` nor in its parts.

    Attributes
    ----------
    pressure : float
        Error of the pressure over the contact (L2 norm); NaN without contact.
    geometry : float
        Part of it due to faces that deviate from the smooth shape they represent; dividing the same faces does not
        reduce it.
    interior : float
        Part of it due to elements below the contact; finer faces alone reduce it little.
    peak : float
        Error of the largest pressure; infinite where it is unbounded or not resolved.
    area : float
        Error of the contact area; infinite where it is not resolved.
    faces_across : float
        Number of faces across the contact at its narrowest.
    unbounded : UnboundedPeak or None
        Edge where the pressure has no bound.
    reason : str
        Why there is no estimate; empty where there is one.
    traction : float or None
        Error of the tractions of friction (L2 norm), see `results.friction_fields`; None without friction.

    Examples
    --------
    >>> print(ErrorEstimate(0.0712, 0.01, 0.005, 0.018, 0.031, 5.2))
    pressure: about 7 % (peak 2 %, area 3 %), resolved by 5.2 faces across
    >>> print(ErrorEstimate(0.24, 0.01, 0.005, 0.06, 0.06, 1.9).within_resolution())
    pressure: about 24 % (peak and area not resolved), 1.9 faces across
    """

    pressure: float
    geometry: float
    interior: float
    peak: float
    area: float
    faces_across: float
    unbounded: UnboundedPeak | None = None
    reason: str = ""
    traction: float | None = None

    def __post_init__(self) -> None:
        for name in ("pressure", "geometry", "interior", "peak", "area", "traction"):
            if 1.0 < (getattr(self, name) or 0.0) < math.inf:
                object.__setattr__(self, name, 1.0)

    @classmethod
    def none(cls, reason: str) -> ErrorEstimate:
        """No estimate, for a reason."""
        return cls(math.nan, math.nan, math.nan, math.nan, math.nan, 0.0, None, reason)

    @property
    def resolved(self) -> bool:
        """Whether enough faces lie across the contact for an estimate of its peak and area."""
        return math.isfinite(self.area)

    def within_resolution(self) -> ErrorEstimate:
        """The estimate without figures for peak and area if fewer than `MIN_ACROSS` faces lie across the contact."""
        if self.faces_across >= MIN_ACROSS:
            return self
        return replace(self, peak=math.inf, area=math.inf)

    @property
    def largest(self) -> float:
        """The largest error of pressure, area and, where it is bounded, peak."""
        return max(self.pressure, self.area, self.peak if self.unbounded is None else 0.0)

    @property
    def worst(self) -> float:
        """The error of the pressure or, where it is larger, of the tractions of friction."""
        return max(self.pressure, self.traction or 0.0)

    @property
    def caution(self) -> str:
        """What a picture tells of the error: nothing up to `MAX_ERROR`.

        Examples
        --------
        >>> ErrorEstimate(0.24, 0.01, 0.005, 0.06, 0.06, 1.9).within_resolution().caution
        'estimated errors: pressure 24 %, peak and area not resolved'
        >>> ErrorEstimate(0.04, 0.01, 0.005, 0.018, 0.031, 5.2).caution
        ''
        """
        if not max(self.largest, self.worst) > MAX_ERROR:
            return ""
        parts = [f"pressure {percent(self.pressure)}"]
        parts += [] if self.traction is None else [f"tractions {percent(self.traction)}"]
        if not self.resolved:
            parts.append("area not resolved" if self.unbounded else "peak and area not resolved")
        else:
            parts += [*([] if self.unbounded else [f"peak {percent(self.peak)}"]), f"area {percent(self.area)}"]
        return f"estimated errors: {', '.join(parts)}"

    @property
    def amount(self) -> str:
        """How much the pressure, its peak and the area are off, in words."""
        mean, area = f"{percent(self.pressure)} in the mean", f"and the area by {percent(self.area)}"
        if self.unbounded is not None:
            mean = f"{mean} away from {self.unbounded.where}, where it has no bound"
            return f"{mean}, {area}" if self.resolved else mean
        return f"{mean} and {percent(self.peak)} at its peak, {area}" if self.resolved else mean

    def summary(self) -> dict[str, Any]:
        """Its figures, ready for JSON; None where there is no estimate."""
        figures = {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in vars(self).items()}
        unbounded = None if self.unbounded is None else self.unbounded._asdict()
        return figures | {"unbounded": unbounded, "resolved": self.resolved}

    def __str__(self) -> str:
        if self.reason:
            return f"pressure: {self.reason}"
        area = f"area {percent(self.area)}" if self.resolved else "area not resolved"
        figures, where = f"peak {percent(self.peak)}, {area}" if self.resolved else "peak and area not resolved", ""
        if self.unbounded is not None:
            figures, where = f"no peak, {area}", f" away from {self.unbounded.where}"
        if self.traction is not None:
            figures += f", tractions of friction {percent(self.traction)}"
        text = (
            f"pressure: about {percent(self.pressure)}{where} ({figures}), {'resolved by ' if self.resolved else ''}"
            f"{self.faces_across:.2g} faces across"
        )
        return text if self.unbounded is None else f"{text}; {self.unbounded}"


@compact_repr
@dataclass(frozen=True)
class ResponseError:
    """Estimated relative errors of forces and motions by the meshes of the bodies; None where a figure has none.

    Forces are too large by these shares of the true ones, motions too small by these shares of those found. Figures
    that are better by chance, as errors of both signs cancel, are not told: the estimates are of their usual size.

    Attributes
    ----------
    force : float or None
        Of the forces of contacts, the largest of them; None where the given forces determine them.
    approach : float or None
        Of the elastic approach of what is pressed by given forces, weighted by these; None where motions are given.
    tilt : float or None
        Of the rotation of a body that is free to tilt, the largest of them.
    """

    force: float | None = None
    approach: float | None = None
    tilt: float | None = None

    def summary(self) -> dict[str, Any]:
        """Its figures, ready for JSON."""
        return dict(vars(self))

    @property
    def worst(self) -> float:
        """The largest of them; zero without any."""
        return max((v for v in vars(self).values() if v is not None), default=0.0)

    def __str__(self) -> str:
        return ", ".join(f"{name} about {percent(v)}" for name, v in vars(self).items() if v is not None)


def percent(share: float) -> str:
    """A share in percent as text: one digit below 9.5, integers above.

    Examples
    --------
    >>> percent(0.0712), percent(0.004), percent(0.234)
    ('7 %', '0.4 %', '23 %')
    """
    value = 100 * share
    return f"{value:.0f} %" if value >= 9.5 else f"{value:.1g} %"
