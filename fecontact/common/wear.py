"""Steps of a path whose surfaces wear by Archard's law, dh = k p |ds|: what half-spaces and scenes share.

The depth that wears off while a point slips by s, n times, grows with the pressure p at the end, h = k n s p: a
compliance k n s of each point for itself, beside that of the bodies. So a step is solved as a contact is, and is stable
however much wears off (Euler's backward rule); explicit steps are stable only while k n s is below the compliance of a
point. Slip is that of the shape before the step.

A step that is passed many times has the slip of a steady cycle: from the end of the step before to its own and back,
until that does not change. What sticks does not wear.

Each step is solved at once and in two halves: the error of the halves is about their difference, point by point. Where
it is large the step is cut. The errors of all steps are added up with their signs; in a load cycle earlier ones fade as
the pressure does, which all that wears lowers to the same limit.

References
----------
J. F. Archard, J. Appl. Phys. 24 (1953) 981; N. Stroemberg, L. Johansson, A. Klarbring, Int. J. Solids Struct. 33 (1996)
1817 (wear and contact in one implicit step).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import SolverError
from fecontact.common.path import HALVINGS

#: Error of the worn depth by the size of a step from which the step is cut, relative to the largest depth, or to the
#: largest displacement if that is more: smaller errors move no pressures.
WEAR_ERROR = 0.01

#: Error of the worn depth, over its largest, from which it is warned of.
MAX_WEAR_ERROR = 0.05

#: Change of what a passage wears, relative, at which a cycle is steady, and most cycles until then. Like bodies are
#: steady after one; the slip of unlike ones settles as a power of their number, after ten or so to this.
STEADY, MAX_CYCLES = 1e-3, 40

#: Refusal of cycles without a step before them.
NO_CYCLE = (
    "Step 1 is to be passed several times, but there is no step before it to go back to. Give the loads at the other "
    "end of the cycle as a first step, without cycles."
)

At = TypeVar("At")


def worn_in_halves(
    leg: Callable[[float, At, Array], tuple[Array, At]],
    wear: Callable[[float, float, Array, tuple[Array, At]], Array],
    span: tuple[float, float],
    last: At,
    worn: Array,
    once: bool,
) -> tuple[At, At, Array, Array]:
    """Wear during a part of a step, at once and in two halves.

    Parameters
    ----------
    leg : callable
        Slip and state on the way to a share of the step, from a state, on a shape of a worn depth.
    wear : callable
        Worn depth after a length of the step that ends at a share, by the depth before and a leg on that shape.
    span : (float, float)
        Shares of the step where the part begins and ends.
    last : state
    worn : array
        Depth before.
    once : bool
        Whether the step is passed once, and its loads change during its parts.

    Returns
    -------
    half, found : states
    worn, change : arrays
        Depth after, and its change by steps of twice the size.
    """
    start, end = span
    middle = (start + end) / 2
    first = leg(end, last, worn)
    whole = wear(end - start, end, worn, first)
    first = leg(middle, last, worn) if once else first
    worn = wear(middle - start, middle, worn, first)
    slip, half = leg(middle, last, worn)
    second = leg(end, half, worn) if once else (slip, half)
    worn = wear(end - middle, end, worn, second)
    return half, leg(end, half, worn)[1], worn, whole - worn


def check_change(change: Array, depth: Array, displacement: float, span: tuple[float, float]) -> None:
    """Refuse a part of a step whose worn depth changes much with steps of half the size, unless it is the smallest.

    Raises
    ------
    SolverError
    """
    largest, most = max(float(depth.max(initial=0.0)), displacement), float(np.abs(change).max(initial=0.0))
    if most > WEAR_ERROR * largest and span[1] - span[0] > 0.5**HALVINGS:
        raise SolverError(f"The worn depth changes by {most:.3g} with steps of half the size.")


def faded(change: Array, earlier: Array, pressure: Array, before: Array, cycling: bool) -> Array:
    """Change of worn depth by smaller steps, with that of the steps before, by pressures now and before."""
    left = np.divide(pressure, before, out=np.ones(change.shape), where=before > 0)
    return np.asarray(change + earlier * (np.minimum(left, 1.0) if cycling else 1.0))


def steady(passage: Callable[[At], tuple[Array, Array, At]], last: At, k: int) -> tuple[Array, At]:
    """Slip and state of a cycle that is steady, by passages of step k: slip, pressure and state, from a state.

    Raises
    ------
    SolverError
        If it does not become so.
    """
    slip = None
    for _ in range(MAX_CYCLES):
        earlier = slip
        slip, pressure, last = passage(last)
        if earlier is not None and np.vdot(np.abs(slip - earlier), pressure) <= STEADY * np.vdot(slip, pressure):
            return slip, last
    raise SolverError(
        f"The slip still changes after {MAX_CYCLES} cycles between the loads of step {k} and of step {k + 1}: the "
        "contact finds no steady cycle. Give its passages one by one."
    )


def wear_warnings(error: float) -> tuple[str, ...]:
    """Warning of a worn depth with a large error."""
    if not error > MAX_WEAR_ERROR:
        return ()
    off = f"The worn depth may be off by {error:.1%} of its largest, by the size of the steps."
    return (f"{off} Give more steps, growing from small ones.",)
