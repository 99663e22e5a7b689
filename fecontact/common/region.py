"""A part of a contact, with its area, force and pressures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.renamed import RenamedKeys


@compact_repr
@dataclass(frozen=True, eq=False)
class Region:
    """A part of a contact area: a connected one, or one side of a plane.

    Attributes
    ----------
    area : float
        As that of the whole contact, so that parts add up to it.
    force, moment : (3,) arrays
        On the first body of a contact of a scene, about the contact's `reference_point`; on a half-space about the
        origin of its grid. World axes, friction included.
    max_pressure, mean_pressure : float
        Zero without contact.
    centre_of_pressure : (3,) array
        NaN without contact.
    point_area : float
        Sum of the areas of its points or cells.
    """

    area: float
    force: Array
    moment: Array
    max_pressure: float
    mean_pressure: float
    centre_of_pressure: Array
    point_area: float

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON; no centre of pressure without contact."""
        plain = RenamedKeys({name: np.asarray(value).tolist() for name, value in vars(self).items()})
        return plain if self.area > 0 else RenamedKeys(plain, centre_of_pressure=None)
