"""What sticks as a contact of its own, and the error of the tractions of friction.

The reserve of friction, d = mu p - |t|, is positive where points stick and zero where they slide. It is the pressure of
a contact, the slip outside being its gap: exactly so for similar bodies (Jaeger 1998, *A new principle in contact
mechanics*; Ciavarella 1998, *The generalized Cattaneo partial slip plane contact problem*), and near its edge for
others, since both fall to zero as the square root of the distance and slip grows as its power 3/2. So what locates the
edge of a contact within the faces locates the edge of stick too, and the reconstructions of both pressures give those
of the tractions, mu p - d, whose difference is the estimated error.
"""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array
from fecontact.results.error_estimate import PressureReadings, larger_misfit
from fecontact.results.friction_fields import FrictionFields

#: Tractions, as a share of what friction could bear (both in L2), below which their error is relative to this share.
LEAST_TRACTION = 0.1


def has_reserve(friction: FrictionFields) -> bool:
    """Whether a contact has a reserve of friction: one finite coefficient for all directions."""
    return isinstance(friction.mu, float) and 0 < friction.mu < np.inf


def reserve(friction: FrictionFields, pressure: Array) -> tuple[Array, Array]:
    """Reserve of friction (n,) as a force, and slip (n,), its gap."""
    assert isinstance(friction.mu, float)
    left = friction.mu * pressure * friction.weights - np.linalg.norm(friction.forces, axis=1)
    return np.where(friction.sticking, np.maximum(left, 0.0), 0.0), np.linalg.norm(friction.slip, axis=1)


def traction_misfit(
    pressed: PressureReadings, held: PressureReadings | None, friction: FrictionFields
) -> tuple[Array, float]:
    """Error of the tractions on the facets of a contact, as `PressureReadings.misfit`, and over all tractions.

    Parameters
    ----------
    pressed, held : PressureReadings
        Reconstructions of the pressure and of the reserve at the same samples of the facets; None where all slides.
    friction : FrictionFields
        With a single finite coefficient.

    Returns
    -------
    misfit : (n,) array
        Integral over each facet of `pressed` of the squared difference, the larger of the two.
    error : float
        Relative L2 norm, see `LEAST_TRACTION`; one where no facet counts.
    """
    mu = friction.mu
    assert isinstance(mu, float)
    fields = {name: mu * getattr(pressed, name) for name in ("interpolated", "root", "smooth")}
    counted = pressed.bounded.copy()
    if held is not None:
        _, at, own = np.intersect1d(pressed.facets, held.facets, return_indices=True)
        counted[at] &= held.bounded[own]
        for name, field in fields.items():
            field[at] -= getattr(held, name)[own]
    found = fields.pop("interpolated")
    misfit = larger_misfit(pressed.areas, found, list(fields.values())) * counted
    norm = (pressed.areas * found**2)[counted].sum()
    norm = max(norm, (LEAST_TRACTION * mu) ** 2 * pressed.norm)
    return misfit, float(np.sqrt(misfit.sum() / norm)) if counted.any() else 1.0
