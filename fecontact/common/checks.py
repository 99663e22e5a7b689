"""Checks of numbers given by the user; a refusal says what was found, what was expected and what to do."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, did_you_mean, sentence, shown

#: Largest ratio of two coefficients of friction: slip in one direction is certified more loosely by as much.
MAX_UNLIKE = 1e3


def positive(name: str, value: float) -> float:
    """Return `value` as a float, or refuse it if it is not positive and finite.

    Raises
    ------
    InputError
        If the value is not a positive, finite number, or see `check_magnitude`.

    Examples
    --------
    >>> positive("the force", 2)
    2.0
    """
    lengths(**{sentence(name): value})
    return float(value)


def check_magnitude(name: str, values: ArrayLike, power: int = 100) -> None:
    """Refuse numbers so large or so small that their squares and products would overflow or underflow.

    Beyond 1e308 floats overflow and below 1e-308 they underflow to zero, both silently. Zero itself is accepted.

    Parameters
    ----------
    name : str
        What they are, for the message.
    values : array_like
    power : int
        Magnitudes from 10^-power to 10^power are accepted.

    Raises
    ------
    InputError
        If the largest magnitude lies outside.

    Examples
    --------
    >>> check_magnitude("the force", (0.0, 0.0, 2.0))
    """
    largest = float(np.abs(values).max(initial=0.0))
    if largest != 0 and not 10.0**-power <= largest <= 10.0**power:
        raise InputError(
            f"{sentence(name)} is {'too large' if largest > 1 else 'too small'} to be worked with: found {largest:g}, "
            f"expected a size from 1e-{power} to 1e{power}. Choose other units (or zero).",
            code="out-of-scale",
        )


def lengths(**values: float) -> None:
    """Refuse arguments, given by name, that are not positive and finite.

    Raises
    ------
    InputError
        If one is not, or see `check_magnitude`.

    Examples
    --------
    >>> lengths(radius=1.0, height=2.0)
    """
    for name, value in values.items():
        if not 0 < number(value) < math.inf:
            raise InputError(f"{name} must be positive and finite; found {shown(value)}.", code="not-positive")
        check_magnitude(name, number(value))


def positives(name: str, values: Any, count: int) -> tuple[float, ...]:
    """Return so many positive, finite numbers as a tuple, or refuse them.

    Raises
    ------
    InputError
        If there are not as many, or one is not positive and finite, or see `check_magnitude`.

    Examples
    --------
    >>> positives("the sides", (1, 2), 2)
    (1.0, 2.0)
    """
    found = array_of(values)
    if found is None or found.shape != (count,) or not (np.isfinite(found) & (found > 0)).all():
        many = {2: "two", 3: "three"}[count]
        raise InputError(
            f"{sentence(name)} must be {many} positive, finite numbers; found {shown(values)}.", code="not-positive"
        )
    check_magnitude(name, found)
    check_magnitude(name, found.min())
    return tuple(found.tolist())


def share(name: str, value: float) -> float:
    """Return `value` as a float, or refuse it if it does not lie strictly between 0 and 1.

    Raises
    ------
    InputError
        If it does not.

    Examples
    --------
    >>> share("the tolerance", 1e-8)
    1e-08
    """
    found = number(value)
    if not 0 < found < 1:
        raise InputError(f"{sentence(name)} must lie between 0 and 1; found {shown(value)}.", code="no-share")
    return found


def finite(name: str, value: float) -> float:
    """Return `value` as a float, or refuse it if it is not a finite number of a size to be worked with.

    Raises
    ------
    InputError
        If the value is not a finite number, or see `check_magnitude`.

    Examples
    --------
    >>> finite("the angle", 0)
    0.0
    """
    found = number(value)
    if not math.isfinite(found):
        raise InputError(f"{sentence(name)} must be a finite number; found {shown(value)}.", code="not-finite")
    check_magnitude(name, found)
    return found


def friction(value: float, infinite: bool = False) -> float:
    """Return Coulomb's mu as a float, or refuse it if it is negative or not a number.

    Parameters
    ----------
    value : float
    infinite : bool
        Whether infinity is accepted: surfaces that stick wherever they touch.

    Raises
    ------
    InputError
        If it is negative, NaN, no number, infinite where that is not accepted, or depends on direction or velocity.

    Examples
    --------
    >>> friction(0.3), friction(math.inf, infinite=True)
    (0.3, inf)
    """
    found = number(value)
    if callable(value):
        raise InputError(
            "Friction does not depend on the velocity of slip here: give one coefficient. Where friction falls with "
            "velocity there may be several answers; those of its largest and its smallest value show the range.",
            code="friction-velocity",
        )
    if (several := array_of(value)) is not None and several.ndim:
        raise InputError(
            "Friction is the same in all directions and places here: give one coefficient, or solve with the largest "
            f"and the smallest for the range; found {shown(value)}.",
            code="friction-isotropic",
        )
    if not 0 <= found <= math.inf or (math.isinf(found) and not infinite):
        expected = "zero or positive" + ("" if infinite else " and finite")
        raise InputError(f"The friction (Coulomb's mu) must be {expected}; found {shown(value)}.", code="friction")
    if math.isfinite(found):
        check_magnitude("the friction (Coulomb's mu)", found)
    return found


def unlike_friction(pair: Any) -> tuple[float, ...]:
    """Return two coefficients of friction for two directions, or refuse them.

    Raises
    ------
    InputError
        If they are not two positive, finite numbers, or differ by more than `MAX_UNLIKE`.

    Examples
    --------
    >>> unlike_friction((0.1, 0.3))
    (0.1, 0.3)
    """
    found = positives("the coefficients of friction", pair, 2)
    if max(found) > MAX_UNLIKE * min(found):
        raise InputError(
            f"Two coefficients of friction may differ by a factor of {MAX_UNLIKE:g}; found {found[0]:g} and "
            f"{found[1]:g}.",
            code="friction-too-unlike",
        )
    return found


def vector(name: str, value: ArrayLike, length: int = 3) -> Array:
    """Return `value` as an array of `length` numbers, or refuse it if there are not as many or one is not finite.

    Raises
    ------
    InputError
        If they are not, or see `check_magnitude`.

    Examples
    --------
    >>> vector("the force", (0, 0, -1))
    array([ 0.,  0., -1.])
    """
    v = array_of(value)
    if v is None or v.shape != (length,) or not np.isfinite(v).all():
        count = {2: "two", 3: "three"}[length]
        raise InputError(f"{sentence(name)} must be {count} finite numbers; found {shown(value)}.", code="not-a-vector")
    check_magnitude(name, v)
    return v


def number(value: Any) -> float:
    """The value as a float; NaN if it is not a number (neither text nor True is).

    Examples
    --------
    >>> number(2), number("2"), number(10**400)
    (2.0, nan, nan)
    """
    if isinstance(value, str | bytes | bool) or getattr(value, "ndim", 0) != 0 or _kind(value) not in "iufO":
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _kind(value: object) -> str:
    """Kind of numpy's type of a value; O for other objects."""
    return value.dtype.kind if isinstance(value, np.ndarray | np.generic) else "O"


def array_of(values: Any) -> Array | None:
    """The values as a new array of floats; None if they are not numbers (neither text nor dates are).

    Examples
    --------
    >>> array_of([[1, 2]]), array_of(["1", "2"]), array_of([1j])
    (array([[1., 2.]]), None, None)
    """
    try:
        found = np.array(values)
        if found.dtype.kind == "O":  # such as fractions, and whole numbers beyond 64 bits
            return None if any(isinstance(v, str | bytes | None) for v in found.flat) else found.astype(float)
        return found.astype(float, copy=False) if found.dtype.kind in "biuf" else None
    except (TypeError, ValueError, OverflowError, RecursionError):
        return None


def among(what: str, value: object, known: Iterable[str]) -> None:
    """Refuse a value that is not among the known names.

    Raises
    ------
    InputError
        With the names.

    Examples
    --------
    >>> among("element", "hex8", ("hex8", "hex20"))
    """
    names = list(known)
    if not (isinstance(value, str) and value in names):
        hint = did_you_mean(value, names) if isinstance(value, str) else ""
        raise InputError(
            f"Unknown {what} {shown(value)}{hint}; expected one of {', '.join(map(repr, names))}.", code="unknown-name"
        )


def whole(name: str, value: object, least: int = 1, most: int = 10**9) -> int:
    """Return `value` as an int, or refuse it if it is not a whole number within these limits.

    Raises
    ------
    InputError
        If it is not.

    Examples
    --------
    >>> whole("the number of layers", 2)
    2
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise InputError(
            f"{sentence(name)} must be a whole number from {least} to {most:g}; found {shown(value)}.", code="not-whole"
        )
    return int(value)


def coordinates(name: str, values: ArrayLike) -> Array:
    """Return `values` as an array of floats of any shape, or refuse it if one of them is not finite.

    Raises
    ------
    InputError
        If a value is not a finite number, or larger than 1e100.

    Examples
    --------
    >>> coordinates("r", [0, 1])
    array([0., 1.])
    """
    array = number_array(name, values)
    if not np.all(np.isfinite(array)):
        raise InputError(
            f"Expected finite values of {name}; found NaN or infinity. Remove those points.", code="not-finite"
        )
    if (largest := float(np.abs(array).max(initial=0.0))) > 1e100:
        raise InputError(f"Expected values of {name} up to 1e100; found {largest:g}. Choose other units.")
    return array


def number_array(name: str, values: Any) -> Array:
    """Return `values` as a new array of floats, finite or not, or refuse what are no numbers.

    Raises
    ------
    InputError
        If a value is no number.

    Examples
    --------
    >>> number_array("points", [[0, np.inf]])
    array([[ 0., inf]])
    """
    array = array_of(values)
    if array is None:
        raise InputError(f"Expected {name} to be an array of numbers; found {shown(values)}.", code="not-numbers")
    return array


def heights_on(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    """Return heights that a function gave for points of a shape, or refuse them; one height stands for all.

    Raises
    ------
    InputError
        If they are no numbers, or of another shape.

    Examples
    --------
    >>> heights_on("the function", 0, (2,))
    array([0., 0.])
    """
    array = number_array(f"what {name} gives", values)
    if array.shape not in ((), shape):
        raise InputError(f"{sentence(name)} must give heights of shape {shape}; found shape {array.shape}.")
    return np.broadcast_to(array, shape).copy()


def index_array(name: str, values: Any) -> IntArray:
    """Return `values` as a new array of whole numbers, or refuse what are none.

    Raises
    ------
    InputError
        If a value is no whole number, or beyond 64 bits.

    Examples
    --------
    >>> index_array("cells", [0, 1.0])
    array([0, 1])
    """
    if _kind(values) == "i":
        return np.array(values, dtype=np.int64)
    array = array_of(values)
    if array is None or not (np.abs(array) < 2.0**62).all() or (array != np.rint(array)).any():
        raise InputError(f"Expected {name} to be an array of whole numbers; found {shown(values)}.", code="not-whole")
    return np.array(values, dtype=np.int64) if array.size else np.zeros(array.shape, dtype=np.int64)


def flags(name: str, values: Any, count: int) -> Mask:
    """Return so many values as an array of True and False, or refuse them.

    Raises
    ------
    InputError
        If there are not as many, or one is neither.

    Examples
    --------
    >>> flags("where(points)", [True, False], 2)
    array([ True, False])
    """
    found = array_of(values)
    if found is None or found.shape != (count,) or not np.isin(found, (0, 1)).all():
        raise InputError(
            f"{sentence(name)} must give {count} times True or False; found {shown(values)}.", code="not-true-or-false"
        )
    return found.astype(bool)


def depths(name: str, values: ArrayLike) -> Array:
    """Return `values` as an array of floats, or refuse it if one of them is negative or not finite.

    Raises
    ------
    InputError
        If a value is negative or not finite.

    Examples
    --------
    >>> depths("z", 0.5)
    array(0.5)
    """
    array = coordinates(name, values)
    if np.any(array < 0):
        raise InputError(
            f"Expected {name} >= 0 (measured from the axis or into the body); found {array.min()}.",
            code="negative-depth",
        )
    return array


def point_array(name: str, values: ArrayLike, dimension: int) -> Array:
    """Return `values` as an array of shape (..., dimension), or refuse it.

    Raises
    ------
    InputError
        If the last axis has another length or a value is not finite.

    Examples
    --------
    >>> point_array("points", [0, 0, 1], 3).shape
    (3,)
    """
    array = coordinates(name, values)
    if array.ndim == 0 or array.shape[-1] != dimension:
        raise InputError(
            f"Expected {name} with {dimension} coordinates on the last axis; found shape {array.shape}.",
            code="wrong-shape",
        )
    return array


def one_of(**alternatives: float | None) -> tuple[str, float]:
    """Return the name and the value of the one alternative that is given, checked to be positive.

    Raises
    ------
    InputError
        If not exactly one is given, or it is not positive and finite.

    Examples
    --------
    >>> one_of(force=2.0, approach=None)
    ('force', 2.0)
    """
    given = [(name, value) for name, value in alternatives.items() if value is not None]
    if len(given) != 1:
        choices = ", ".join(f"{name}=" for name in alternatives)
        found = " and ".join(name for name, _ in given) or "none"
        raise InputError(
            f"Expected exactly one of {choices}; found {found}. Give one and leave the others out.", code="one-of"
        )
    name, value = given[0]
    return name, positive(f"the {name}" if len(name) > 1 else name, value)
