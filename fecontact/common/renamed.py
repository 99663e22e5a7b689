"""Names of figures that have changed: for one release the old ones still work, and warn."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Container, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

T = TypeVar("T")

#: Former names of keys and columns.
FORMER = {
    "outline_area": "area",
    "dissipated": "friction_work",
    "contact_area": "area",
    "friction_residuals": "residuals",
}


class RenamedKeys(dict[str, Any]):
    """A dictionary that knows the former names of its keys; they warn."""

    def __missing__(self, key: str) -> Any:
        """The value of a former name.

        Examples
        --------
        >>> import warnings
        >>> with warnings.catch_warnings(record=True) as told:
        ...     warnings.simplefilter("always")
        ...     RenamedKeys(area=2.0)["outline_area"]
        2.0
        >>> print(told[0].message)
        'outline_area' is now 'area'; the old name will be removed.
        """
        new = present_name(key, self)
        if new == key:
            raise KeyError(key)
        return self[new]


def present_name(name: str, known: Container[str]) -> str:
    """The name of a key or column that is given by its former one, with a warning; any other as it is."""
    if not isinstance(name, str) or name in known or (new := FORMER.get(name)) not in known:
        return name
    warn(f"{name!r} is now {new!r}; the old name will be removed.", stacklevel=4)
    return str(new)


def renamed(old: str, new: str, read: Callable[[Any], Any] | None = None) -> Any:
    """A property that has the value of another, or what `read` finds, under its former name, and warns."""

    def value(self: Any) -> Any:
        warn(f"{type(self).__name__}.{old} is now {new}; the old name will be removed.", stacklevel=3)
        return getattr(self, new) if read is None else read(self)

    value.__doc__ = f"Former name of `{new}`; it warns."
    return property(value)


class FormerNames:
    """Members that begin with an underscore now, as only the package uses them: their former names work, and warn.

    Examples
    --------
    >>> import warnings
    >>> class Ball(FormerNames):
    ...     _depth = 2.0
    >>> with warnings.catch_warnings(record=True) as told:
    ...     warnings.simplefilter("always")
    ...     Ball().depth
    2.0
    >>> print(told[0].message)
    Ball.depth is used by the package alone; its name will be removed.
    """

    if not TYPE_CHECKING:  # a type checker is to find them no more

        def __getattr__(self, name: str) -> Any:
            own = f"_{name}"
            if name.startswith("_") or not (own in vars(self) or hasattr(type(self), own)):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)
            warn(f"{type(self).__name__}.{name} is used by the package alone; its name will be removed.", stacklevel=3)
            return getattr(self, own)


def renamed_names(names: Mapping[str, Any], **former: str) -> Callable[[str], Any]:
    """A module's ``__getattr__`` that finds names of the module under their former ones, and warns.

    Examples
    --------
    >>> import warnings
    >>> with warnings.catch_warnings(record=True) as told:
    ...     warnings.simplefilter("always")
    ...     renamed_names({"__name__": "shapes", "Ball": 1}, Orb="Ball")("Orb")
    1
    >>> print(told[0].message)
    shapes.Orb is now Ball; the old name will be removed.
    """

    def value(name: str) -> Any:
        if (new := former.get(name)) is None:
            raise AttributeError(f"module {names['__name__']!r} has no attribute {name!r}")
        warn(f"{names['__name__']}.{name} is now {new}; the old name will be removed.", stacklevel=3)
        return names[new]

    return value


def renamed_argument(call: str, old: str, new: str, former: T | None, value: T) -> T:
    """The value of an argument of a call, or the one that is given under its former name, with a warning."""
    if former is None:
        return value
    warn(f"{call}({old}=) is now {call}({new}=); the old name will be removed.", stacklevel=4)
    return former


def redefined(new: str, meaning: str, former: str) -> None:
    """Warn, at what asked for an attribute, that it has another meaning than before.

    The name stays, so that most who ask mean what it is now: seen where warnings are asked for, as by pytest and
    ``python -X dev``, and not by plain scripts.
    """
    text = f"{new} is {meaning}; what it was before is {former}. This warning will be removed."
    warn(text, stacklevel=5, category=PendingDeprecationWarning)


def warn(message: str, stacklevel: int, category: type[Warning] = DeprecationWarning) -> None:
    """Warn of a name that has changed."""
    warnings.warn(message, category, stacklevel=stacklevel)
