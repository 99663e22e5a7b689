"""Fingerprints: a short text that is equal for equal models or cases and differs for different ones.

Values are compared, not object identity: arrays, lists and tuples of the same numbers are equal, so are 1 and 1.0, and
mappings in any order. Cached properties are ignored. Files of finished rows carry fingerprints, so that rows of another
model are not reused.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cached_property, partial
from pathlib import PurePath
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np
import scipy.sparse as sp

from fecontact.common.errors import InputError

#: Largest n such that floats represent every integer up to n.
EXACT = 2**53


def fingerprint(*things: Any) -> str:
    """Fingerprint of the arguments together: 32 hexadecimal digits, the same in every process.

    Parameters
    ----------
    *things
        Numbers, strings, None, arrays, sequences, sets, mappings, sparse matrices; dataclasses by their fields, and
        other objects by their attributes (bodies, meshes, materials, poses, laws); functions by their code, the values
        they enclose and the numbers and functions of their module that they use. An object may define its own contents
        by a method ``fingerprinted()`` that returns any of these.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If an object has no attributes to compare, such as an open file.

    Examples
    --------
    >>> import fecontact as fc
    >>> a = fingerprint(fc.Material(E=1.0, nu=0.3), {"x": (0, 1), "y": "free"})
    >>> a == fingerprint(fc.Material(E=1, nu=0.3), {"y": "free", "x": np.array([0.0, 1.0])})
    True
    >>> a == fingerprint(fc.Material(E=1.1, nu=0.3), {"x": (0, 1), "y": "free"})
    False
    """
    return _Print().of(things).hex()


class _Print:
    """One traversal of the arguments; an object that occurs in several places is visited once."""

    def __init__(self) -> None:
        # the objects are kept as well: the id of a deleted object may be reused
        self._known: dict[int, tuple[Any, bytes]] = {}

    def of(self, thing: Any) -> bytes:
        """Digest of one thing."""
        if thing is None or isinstance(thing, (str, bytes)):
            return _digest(type(thing).__name__, repr(thing).encode())
        if isinstance(thing, (bool, int, float, complex, np.number, np.bool_)):
            return _of_numbers(np.asarray(thing))
        key = id(thing)
        if key not in self._known:
            self._known[key] = (thing, b"itself")
            self._known[key] = (thing, self._anew(thing))
        return self._known[key][1]

    def _anew(self, thing: Any) -> bytes:
        if isinstance(thing, (np.ndarray, Sequence)):
            return self._of_sequence(thing)
        if isinstance(thing, Mapping):
            return _digest("mapping", *sorted(self.of(k) + self.of(v) for k, v in thing.items()))
        if isinstance(thing, AbstractSet):
            return _digest("set", *sorted(map(self.of, thing)))
        if sp.issparse(thing):
            coo = thing.tocsr().sorted_indices().tocoo()
            return _digest("sparse", self.of(coo.shape), self.of(coo.row), self.of(coo.col), self.of(coo.data))
        if isinstance(thing, PurePath):
            return self.of(str(thing))
        if isinstance(thing, (FunctionType, MethodType, partial)):
            return self._of_function(thing)
        if isinstance(thing, CodeType):
            return _digest("code", thing.co_code, self.of(thing.co_names), self.of(thing.co_consts))
        if isinstance(thing, (type, ModuleType)) or (callable(thing) and hasattr(thing, "__name__")):
            return _digest("named", f"{getattr(thing, '__module__', '')}.{thing.__name__}")
        return self._of_object(thing)

    def _of_sequence(self, thing: Any) -> bytes:
        """Digest of numbers as one array; of anything else, item by item."""
        try:
            array = np.asarray(thing)
        except (TypeError, ValueError):  # ragged
            array = np.zeros(0, object)
        if array.dtype.kind in "biufc":
            return _of_numbers(array)
        return _digest("sequence", *map(self.of, thing.tolist() if isinstance(thing, np.ndarray) else thing))

    def _of_function(self, thing: Any) -> bytes:
        if isinstance(thing, partial):
            return _digest("partial", self.of(thing.func), self.of(thing.args), self.of(thing.keywords))
        if isinstance(thing, MethodType):
            return _digest("method", self.of(thing.__self__), self.of(thing.__func__))
        assert isinstance(thing, FunctionType)
        enclosed = [cell.cell_contents for cell in thing.__closure__ or ()]
        used = {name: thing.__globals__[name] for name in _names(thing.__code__) if name in thing.__globals__}
        defaults = (thing.__defaults__, thing.__kwdefaults__)
        return _digest("function", self.of(thing.__code__), self.of(enclosed), self.of(used), self.of(defaults))

    def _of_object(self, thing: Any) -> bytes:
        kind = f"{type(thing).__module__}.{type(thing).__qualname__}"
        if hasattr(thing, "fingerprinted"):
            return _digest("object", kind, self.of(thing.fingerprinted()))
        if isinstance(thing, Enum):
            return _digest("enum", kind, self.of(thing.name))
        if is_dataclass(thing):
            return _digest("object", kind, self.of({f.name: getattr(thing, f.name) for f in fields(thing) if f.init}))
        if not hasattr(thing, "__dict__"):
            raise InputError(
                f"Two runs cannot be told apart by {thing!r} ({kind}), which has no attributes to compare; "
                "give its class a method fingerprinted() that returns numbers, arrays or strings.",
                code="no-fingerprint",
            )
        own = {k: v for k, v in vars(thing).items() if not isinstance(getattr(type(thing), k, None), cached_property)}
        return _digest("object", kind, self.of(own))


def _names(code: CodeType) -> Iterator[str]:
    """Names that a function may look up in its module, including those used by nested functions."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _of_numbers(array: np.ndarray[Any, Any]) -> bytes:
    """Digest of shape and values; integers as floats where exact, -0 as 0, all NaN alike."""
    if array.dtype.kind in "iuO" and array.size and max(map(abs, (array.max(), array.min()))) > EXACT:
        return _digest("whole numbers", repr(array.tolist()))
    values = array.astype("<c16" if array.dtype.kind == "c" else "<f8")
    values = np.where(np.isnan(values), np.nan, values + 0.0)
    return _digest("numbers", repr(array.shape), values.tobytes())


def _digest(*parts: str | bytes) -> bytes:
    """Digest of parts, each with its length, so that different lists of parts cannot concatenate to the same bytes."""
    total = hashlib.blake2b(digest_size=16)
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        total.update(len(data).to_bytes(8, "little"))
        total.update(data)
    return total.digest()
