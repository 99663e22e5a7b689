"""Forces that carry the load and do not pull: {x >= 0, B x = F}."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array
from fecontact.solvers.scaling import SMALLEST

CARRIED = 4e-15
"""Load not carried, relative to the forces, that is rounding."""

BALANCED = 1e-13
"""The same after forces were changed in proportion, which is one step of linear algebra."""

DAMPING = 1e-3
"""Least damping of the projection's Newton steps, per share of the load that is not carried yet."""

MODERATE = 10.0
"""Factor by which their sum may change when forces are changed in proportion; beyond, the nearest ones are better."""


def feasible(B: Array, F: Array, y: Array) -> Array:
    """Forces near y that carry the load and do not pull.

    Parameters
    ----------
    B : (m, n) array
        Equilibrium rows.
    F : (m,) array
        A load that non-negative forces can carry.
    y : (n,) array

    Returns
    -------
    (n,) array
        The forces of y that do not pull, changed in proportion by a factor linear in the rows, where a moderate factor
        does, so that no other point gets a force; otherwise the nearest point, see `project`.

    References
    ----------
    For one row of ones the factor is that of I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206-219.

    Examples
    --------
    >>> import numpy as np
    >>> feasible(np.ones((1, 3)), np.array([6.0]), np.array([1.0, 2.0, -1.0])).tolist()
    [2.0, 4.0, 0.0]
    """
    x = np.maximum(y, 0.0)
    if len(F) == 0:
        return x
    changed = x * (1 + np.linalg.lstsq((B * x) @ B.T, F - B @ x, rcond=1e-12)[0] @ B)
    before, after = float(x.sum()), float(changed.sum())
    moderate = before <= MODERATE * after and after <= MODERATE * before and changed.min() >= 0
    if moderate and np.abs(F - B @ changed).max() <= BALANCED * load_size(B, F, x):
        return np.asarray(changed)
    return project(B, F, x)[0]


def load_size(B: Array, F: Array, x: Array) -> float:
    """Upper bound of the terms in B x = F."""
    if len(F) == 0:
        return 0.0
    entries = np.maximum(B.max(axis=1), -B.min(axis=1))
    return float((entries * np.linalg.norm(x, 1) + np.abs(F)).max())


def project(B: Array, F: Array, y: Array) -> tuple[Array, Array]:
    """Nearest point to y with x >= 0 and B x = F.

    Parameters
    ----------
    B : (m, n) array
        Rows, best of like size and orthogonal.
    F : (m,) array
        A load that non-negative forces can carry.
    y : (n,) array

    Returns
    -------
    x : (n,) array
        The point.
    t : (m,) array
        Its multiplier.

    Notes
    -----
    x = max(y + B^T t, 0), where t minimises the convex, piecewise quadratic 1/2 |x|^2 - F . t in m unknowns:
    Newton's method, damped in proportion to the slope and more where a step fails.

    Examples
    --------
    >>> import numpy as np
    >>> project(np.full((1, 4), 0.5), np.array([1.0]), np.array([3.0, 2.0, 0.0, -1.0]))[0].round(12).tolist()
    [1.5, 0.5, 0.0, 0.0]
    """
    x, t, damping = np.maximum(y, 0.0), np.zeros(len(F)), DAMPING
    if len(F) == 0:
        return x, t
    unit = float((B * B).sum()) / len(F)
    given = float(np.linalg.norm(F)) + np.sqrt(unit) * float(np.linalg.norm(y))
    value = 0.5 * (x @ x)
    for _ in range(100):
        slope = B @ x - F
        share = float(np.linalg.norm(slope)) / (given + np.sqrt(unit) * float(np.linalg.norm(x)) or 1.0)
        if share <= CARRIED:
            break
        rows = B[:, x > 0] if x.any() else B
        step = np.linalg.lstsq(rows @ rows.T + damping * unit * share * np.eye(len(F)), slope, rcond=None)[0]
        trial = np.maximum(y + (t - step) @ B, 0.0)
        trial_value = 0.5 * (trial @ trial) - F @ (t - step)
        # near the end the value changes less than its rounding
        if trial_value <= value + SMALLEST * abs(value):
            t, x, value, damping = t - step, trial, trial_value, max(damping / 10, DAMPING)
        else:
            damping *= 10
    return x, t
