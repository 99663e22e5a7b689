"""The jump of velocities where points stop sliding.

Over a step a point sticks if its slip vanishes, which by itself turns its velocity round: the mean of both ends is
zero. So velocities jump at the end of a step, as in T. A. Laursen & G. R. Love, Int. J. Numer. Methods Eng. 53 (2002)
for normal contact: impulses p of friction over the whole step, h t of them given, minimise the kinetic energy under
Coulomb's law for the velocities u at its end,

    u = T (v + M^-1 T^T (p - h t)) - w,    |p| <= mu h l,    u = 0 where |p| < mu h l,    |u| p = - mu h l u

with the velocity w of what they touch. Kinetic energy is lost, never won: with |h t| <= mu h l its change is the sum of
(p - h t) . u, at most zero, less the kinetic energy of the jump. Points that slide on keep their velocity.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.assembly import Assembly
from fecontact.ancf.slip import Slips
from fecontact.common.arrays import Array
from fecontact.solvers import ComplementarityProblem
from fecontact.solvers.friction import solve_friction
from fecontact.solvers.friction_problem import ON_CONE, FrictionProblem

#: Motion in a step by a velocity, relative to the size of the bodies, that is rounding.
ROUNDING = 1e-14


def stopped(
    a: Assembly, v: Array, slip: Slips, normal: Array, tangential: Array, driven: Array, h: float
) -> tuple[Array, float]:
    """Velocities after the jump, and the kinetic energy it takes.

    Parameters
    ----------
    a : Assembly
    v : (n_dofs,) array
    slip : Slips
    normal : (n_multipliers,) array
        Normal forces of all conditions over the step.
    tangential : (2 f,) array
        Forces of the rows of `slip` over the step.
    driven : (2 f,) array
        Velocities w of what they touch.
    h : float

    Returns
    -------
    v : (n_dofs,) array
    lost : float
    """
    n, limit = len(slip.points), slip.limit(normal)
    sticks = np.flatnonzero(np.linalg.norm(tangential.reshape(2, -1), axis=0) < (1 - ON_CONE) * limit)
    rows = (np.arange(2)[:, None] * n + sticks).ravel()
    T = sp.csr_matrix(slip.T[rows])
    u = T @ v - driven[rows]
    if not len(rows) or h * np.abs(u).max() <= ROUNDING * a.size:
        return v, 0.0
    spread = a.accelerated(T.T.toarray())
    S = T @ spread
    t = h * tangential[rows]
    # the limits are given: rows of their own have them as forces, with friction of one; a rough point has any
    f, unit = len(sticks), float(S.diagonal().mean())
    every = np.zeros((3 * f, 3 * f))
    every[:f, :f], every[f:, f:] = unit * np.eye(f), (S + S.T) / 2
    rough = np.isinf(limit[sticks])
    bound = h * np.where(rough, np.linalg.norm(t.reshape(2, -1), axis=0).max(), limit[sticks])
    g = np.concatenate([-unit * bound, u - S @ t])
    held = f + np.flatnonzero(every[range(f, 3 * f), range(f, 3 * f)] == 0)
    every[held, held] = unit
    problem = FrictionProblem(
        ComplementarityProblem(every, g), np.arange(f), f + np.arange(2 * f).reshape(2, -1).T,
        np.where(rough, np.inf, 1.0),
    )  # fmt: skip
    jump = spread @ (solve_friction(problem).forces[f:] - t)
    return v + jump, -float(jump @ (a.mass @ (v + jump / 2)))
