"""Line search of statics: the share of Newton's step that lowers the exact penalty function, see `statics`."""

from __future__ import annotations

import numpy as np

from fecontact.ancf.assembly import Assembly, Conditions
from fecontact.ancf.laws import InvertedError
from fecontact.ancf.newton import UnstableError
from fecontact.ancf.slip import Slips, SlipStart, slips
from fecontact.common.arrays import Array

MOST_HALVINGS = 10


def searched(
    a: Assembly,
    q: Array,
    direction: Array,
    load: Array,
    internal: Array,
    conditions: Conditions,
    slip: Slips,
    multipliers: tuple[Array, Array],
    since: SlipStart,
    driven: bool,
) -> tuple[Array, Conditions | None]:
    """New coordinates, after a share of the step that lowers the penalty function, and the conditions there if known.

    With friction its work mu l |s| under the present normal forces is added, of which the step is a minimiser. Under
    prescribed motions the energy may rise; then only inversion shortens the step, as under loads that follow.

    Parameters
    ----------
    a : Assembly
    q, direction : (n_dofs,) arrays
        Coordinates and Newton's step.
    load, internal : (n_dofs,) arrays
        Loads and elastic forces at q.
    conditions, slip, since
        Contact conditions and slip at q, and whence slip counts.
    multipliers : (n_multipliers,) and (6 n_hubs,) arrays
        Contact forces and stresses of rigid hubs of the step; the strains of hubs are penalised, too.
    driven : bool
        Whether there is no energy to lower.

    Raises
    ------
    UnstableError
        If no share of the step lowers it.
    """
    forces, stresses = multipliers
    weight, of_hubs = 2 * float(forces.max(initial=0.0)), 2 * float(np.abs(stresses).max(initial=0.0))
    limit = slip.limit(forces)

    def friction_work(s: Array) -> float:
        size = np.linalg.norm(s.reshape(2, -1), axis=0)
        return float(np.multiply(limit, size, out=np.zeros(len(size)), where=np.isfinite(limit)).sum())

    def merit(x: Array, c: Conditions, s: Array) -> float:
        penetrated = float(np.maximum(-c.gap, 0.0).sum())
        strained = float(np.abs(a.hub_strains(x)).sum())
        return a.energy(x) - float(load @ x) + weight * penetrated + of_hubs * strained + friction_work(s)

    before = None if driven else merit(q, conditions, slip.slip)
    slope = float((internal - load) @ direction) - weight * float(np.maximum(-conditions.gap, 0.0).sum())
    slope -= of_hubs * float(np.abs(a.hub_strains(q)).sum())
    slope += friction_work(slip.slip + slip.T @ direction) - friction_work(slip.slip)
    tiny = np.abs(a.lengths * direction).max(initial=0.0) < 1e-6 * a.size
    share = 1.0
    for _ in range(MOST_HALVINGS):
        trial = q + share * direction
        try:
            if before is None:
                a.energy(trial)
                return trial, None
            if tiny:
                return trial, None
            c = a.conditions(trial)
            s = slips(a.touches, c.parts, trial, since).slip
            if merit(trial, c, s) <= before + 1e-4 * share * min(slope, 0.0):
                return trial, c
        except InvertedError:
            pass
        share /= 2
    raise UnstableError("No share of Newton's step lowers the energy.")
