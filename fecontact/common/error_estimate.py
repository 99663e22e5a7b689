"""Estimated discretisation errors of a contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: Estimated error of the pressure above which a result warns.
LARGEST_ERROR = 0.1
#: Reason for no estimate.
NO_CONTACT = "no contact, nothing to estimate"


@dataclass(frozen=True)
class ErrorEstimate:
    """Estimated errors of one contact, all relative.

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
        Error of the largest pressure.
    area : float
        Error of the contact area.
    faces_across : float
        Number of faces across the contact at its narrowest.
    reason : str
        Why there is no estimate; empty where there is one.

    Examples
    --------
    >>> print(ErrorEstimate(0.0712, 0.01, 0.005, 0.018, 0.031, 5.2))
    pressure: about 7 % (peak 2 %, area 3 %), resolved by 5.2 faces across
    """

    pressure: float
    geometry: float
    interior: float
    peak: float
    area: float
    faces_across: float
    reason: str = ""

    @classmethod
    def none(cls, reason: str) -> ErrorEstimate:
        """No estimate, for a reason."""
        return cls(math.nan, math.nan, math.nan, math.nan, math.nan, 0.0, reason)

    def summary(self) -> dict[str, float | str | None]:
        """Its figures, ready for JSON; None where there is no estimate."""
        return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in vars(self).items()}

    def __str__(self) -> str:
        if self.reason:
            return f"pressure: {self.reason}"
        return (
            f"pressure: about {percent(self.pressure)} (peak {percent(self.peak)}, area {percent(self.area)}), "
            f"resolved by {self.faces_across:.2g} faces across"
        )


def percent(share: float) -> str:
    """A share in percent as text: one digit below ten, integers above.

    Examples
    --------
    >>> percent(0.0712), percent(0.004), percent(0.234)
    ('7 %', '0.4 %', '23 %')
    """
    value = 100 * share
    return f"{value:.0f} %" if value >= 10 else f"{value:.1g} %"
