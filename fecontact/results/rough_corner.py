"""Order of the pressure at the edge of a body pressed on another with friction, a wedge on a half-plane.

Beside the end of a wedge the stresses grow as r^(lambda - 1) also where friction holds it: a block that spreads under
pressure is held by a rough plate, and its corner carries a pressure without bound, which no mesh resolves. Williams's
stress function r^(lambda + 1) F of each body has four terms (Williams 1952, *Stress singularities resulting from
various boundary conditions in angular corners of plates in extension*). On their free sides both stresses vanish; where
they touch, stresses and displacements are continuous where they stick (Bogy 1971, *Two edge-bonded elastic wedges*),
and where they slide the shear is mu times the pressure (Comninou 1976, *Stress singularity at a sharp edge in contact
problems with friction*). lambda is the smallest root of the determinant.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from fecontact.common.arrays import Array

#: Values of lambda between which roots are looked for.
TRIED = np.linspace(0.02, 0.98, 193)
#: Angles of the wedge and of the half-plane.
WEDGE, HALF_PLANE = np.pi / 2, -np.pi


@lru_cache(maxsize=64)
def rough_eigenvalue(wedge: tuple[float, float], below: tuple[float, float] | None, shear: float | None) -> float:
    """Smallest lambda below one of a right-angled wedge on a half-plane; one where the stresses are bounded.

    Parameters
    ----------
    wedge, below : (float, float)
        Kolosov's constant and shear modulus of wedge and half-plane; None where that is rigid.
    shear : float or None
        Shear on the wedge over the pressure where it slides, positive towards its inside; None where it sticks.

    Examples
    --------
    On a rough rigid plane, sin(lambda pi / 2)^2 = ((kappa + 1)^2 - 4 lambda^2) / (4 kappa) (Williams 1952); bonded to a
    half-plane of its material it is the notch of 270 degrees:

    >>> round(rough_eigenvalue((1.8, 1.0), None, None), 3), round(rough_eigenvalue((1.8, 1.0), (1.8, 1.0), None), 4)
    (0.711, 0.5445)
    """
    values = np.array([_determinant(float(root), wedge, below, shear) for root in TRIED])
    first = np.flatnonzero(values[1:] * values[:-1] < 0)
    if not len(first):
        return 1.0
    ends = TRIED[first[0]], TRIED[first[0] + 1]
    return float(brentq(_determinant, *ends, args=(wedge, below, shear)))


def _determinant(
    root: float, wedge: tuple[float, float], below: tuple[float, float] | None, shear: float | None
) -> float:
    end, side = _fields(root, WEDGE, *wedge), _fields(root, 0.0, *wedge)
    if below is None:
        held = side[2] if shear is None else side[1] - shear * side[0]
        return float(np.linalg.det(np.stack([end[0], end[1], side[3], held])))
    free, beside = _fields(root, HALF_PLANE, *below), _fields(root, 0.0, *below)
    none = np.zeros((2, 4))
    jumps = np.concatenate([side, -beside], axis=1)
    if shear is not None:
        jumps[2] = np.concatenate([side[1] - shear * side[0], none[0]])
    rows = [np.concatenate([end[:2], none], axis=1), np.concatenate([none, free[:2]], axis=1), jumps]
    return float(np.linalg.det(np.concatenate(rows)))


def _fields(root: float, angle: float, kappa: float, shear_modulus: float) -> Array:
    """Stresses across and along a ray, displacements along and across it (4, 4) by the terms of F, over r^lambda."""
    a, b = root + 1, root - 1
    one, two = np.array([np.cos(a * angle), np.sin(a * angle)]), np.array([np.cos(b * angle), np.sin(b * angle)])
    turned_one, turned_two = np.array([-one[1], one[0]]), np.array([-two[1], two[0]])
    return np.stack(
        [
            np.concatenate([a * one, a * two]),
            -np.concatenate([a * turned_one, b * turned_two]),
            np.concatenate([-a * one, (kappa - root) * two]) / (2 * shear_modulus),
            -np.concatenate([a * turned_one, (kappa + root) * turned_two]) / (2 * shear_modulus),
        ]
    )
