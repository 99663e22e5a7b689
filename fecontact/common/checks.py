"""Checks of numbers given by the user; a refusal says what was found, what was expected and what to do."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError


def positive(name: str, value: float) -> float:
    """Return `value` as a float, or refuse it if it is not positive and finite.

    Raises
    ------
    InputError
        If the value is not a positive, finite number.

    Examples
    --------
    >>> positive("the force", 2)
    2.0
    """
    lengths(**{_sentence(name): value})
    return float(value)


def reckonable(name: str, values: ArrayLike, power: int = 100) -> None:
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
    >>> reckonable("the force", (0.0, 0.0, 2.0))
    """
    largest = float(np.abs(values).max(initial=0.0))
    if largest != 0 and not 10.0**-power <= largest <= 10.0**power:
        raise InputError(
            f"{_sentence(name)} is {'too large' if largest > 1 else 'too small'} to be worked with: found {largest:g}, "
            f"expected a size from 1e-{power} to 1e{power}. Choose other units (or zero)."
        )


def lengths(**values: float) -> None:
    """Refuse arguments, given by name, that are not positive and finite.

    Raises
    ------
    InputError
        If one is not.

    Examples
    --------
    >>> lengths(radius=1.0, height=2.0)
    """
    for name, value in values.items():
        number = _number(value)
        if not (math.isfinite(number) and number > 0):
            raise InputError(f"{name} must be positive and finite; found {value!r}.")


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
    number = _number(value)
    if not 0 < number < 1:
        raise InputError(f"{_sentence(name)} must lie between 0 and 1; found {value!r}.")
    return number


def finite(name: str, value: float) -> float:
    """Return `value` as a float, or refuse it if it is not a finite number of a size to be worked with.

    Raises
    ------
    InputError
        If the value is not a finite number, or see `reckonable`.

    Examples
    --------
    >>> finite("the angle", 0)
    0.0
    """
    number = _number(value)
    if not math.isfinite(number):
        raise InputError(f"{_sentence(name)} must be a finite number; found {value!r}.")
    reckonable(name, number)
    return number


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
        If it is negative, NaN, no number, or infinite where that is not accepted.

    Examples
    --------
    >>> friction(0.3), friction(math.inf, infinite=True)
    (0.3, inf)
    """
    number = _number(value)
    if not 0 <= number <= math.inf or (math.isinf(number) and not infinite):
        expected = "zero or positive" + ("" if infinite else " and finite")
        raise InputError(f"The friction (Coulomb's mu) must be {expected}; found {value!r}.")
    return number


def vector(name: str, value: ArrayLike, length: int = 3) -> Array:
    """Return `value` as an array of `length` numbers, or refuse it if there are not as many or one is not finite.

    Raises
    ------
    InputError
        If they are not, or see `reckonable`.

    Examples
    --------
    >>> vector("the force", (0, 0, -1))
    array([ 0.,  0., -1.])
    """
    try:
        v = np.array(value, dtype=float)
    except (TypeError, ValueError):
        v = np.zeros(0)
    if v.shape != (length,) or not np.isfinite(v).all():
        count = {2: "two", 3: "three"}[length]
        raise InputError(f"{_sentence(name)} must be {count} finite numbers; found {value!r}.")
    reckonable(name, v)
    return v


def _number(value: float) -> float:
    """The value as a float; NaN if it is not a number (text is never a number)."""
    try:
        return math.nan if isinstance(value, str) else float(value)
    except (TypeError, ValueError):
        return math.nan


def _sentence(name: str) -> str:
    """The name with a capital first letter, symbols unchanged."""
    return name[0].upper() + name[1:] if len(name) > 1 else name


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
    if value not in names:
        raise InputError(f"Unknown {what} {value!r}; expected one of {', '.join(map(repr, names))}.")


def coordinates(name: str, values: ArrayLike) -> Array:
    """Return `values` as an array of floats of any shape, or refuse it if one of them is not finite.

    Raises
    ------
    InputError
        If a value is not a finite number.

    Examples
    --------
    >>> coordinates("r", [0, 1])
    array([0., 1.])
    """
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"Expected {name} to be an array of numbers; found {values!r}.") from None
    if not np.all(np.isfinite(array)):
        raise InputError(f"Expected finite values of {name}; found NaN or infinity. Remove those points.")
    return array


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
        raise InputError(f"Expected {name} >= 0 (measured from the axis or into the body); found {array.min()}.")
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
        raise InputError(f"Expected {name} with {dimension} coordinates on the last axis; found shape {array.shape}.")
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
        raise InputError(f"Expected exactly one of {choices}; found {found}. Give one and leave the others out.")
    name, value = given[0]
    return name, positive(f"the {name}" if len(name) > 1 else name, value)
