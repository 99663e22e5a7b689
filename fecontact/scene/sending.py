"""Serialised scenes and cases for other processes, and the function that solves them there.

A scene is sent without factors (`Model.__getstate__`) but with the inverse of its condensed stiffness. A process keeps
the last scene, so that further cases are sent alone; a process without the scene requests it.
"""

from __future__ import annotations

import io
import pickle
import threading
from collections.abc import Mapping, Sequence
from types import FunctionType
from typing import Any

from fecontact.bodies.protocol import Body
from fecontact.common.errors import InputError
from fecontact.contact.model import SceneModel
from fecontact.scene.local_search import SearchHistory
from fecontact.scene.sweep_case import Solved, solved_case

REMEDY = (
    "Define it in a module that other processes can import (not in the main script, a notebook or by lambda), or "
    "leave out processes= and executor=."
)

#: Last scene sent to this thread and its search history, with the scene's token.
_KEPT = threading.local()


class _Pickler(pickle.Pickler):
    """Bodies known to the receiver are sent as numbers; objects of the main script are refused."""

    def __init__(self, file: io.BytesIO, bodies: Sequence[Body]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._numbers = {id(body): k for k, body in enumerate(bodies)}

    def persistent_id(self, thing: Any) -> int | None:
        return self._numbers.get(id(thing))

    def reducer_override(self, thing: Any) -> Any:
        if isinstance(thing, (FunctionType, type)) and thing.__module__ == "__main__":
            raise pickle.PicklingError(f"{thing.__qualname__} is defined in the main script")
        return NotImplemented


class _Unpickler(pickle.Unpickler):
    def __init__(self, data: bytes, bodies: Sequence[Body]) -> None:
        super().__init__(io.BytesIO(data))
        self._bodies = bodies

    def persistent_load(self, number: int) -> Body:
        return self._bodies[number]


def _packed(thing: Any, bodies: Sequence[Body] = ()) -> bytes:
    _Pickler(file := io.BytesIO(), bodies).dump(thing)
    return file.getvalue()


def packed_scene(scene: SceneModel, history: SearchHistory) -> bytes:
    """Scene and search history as bytes.

    Raises
    ------
    InputError
        If it cannot be sent; the message names the body.
    """
    try:
        return _packed((scene, history))
    except Exception as error:
        for body in scene.bodies:
            try:
                _packed(body)
            except Exception as its:
                raise InputError(f"The body {body.name!r} cannot be sent to other processes: {its}. {REMEDY}") from its
        raise InputError(f"The scene cannot be sent to other processes: {error}. {REMEDY}") from error


def packed_case(name: str, case: Mapping[str, Any], bodies: Sequence[Body]) -> bytes:
    """Case as bytes, for a receiver that has its scene.

    Raises
    ------
    InputError
        If it cannot be sent.
    """
    try:
        return _packed(dict(case), bodies)
    except Exception as error:
        raise InputError(f"The case {name!r} cannot be sent to other processes: {error}. {REMEDY}") from error


def solved_there(token: str, case: bytes, scene: bytes | None = None) -> Solved | None:
    """Row and kept fields of a case for the scene of a token; None if the scene is neither sent nor kept."""
    if getattr(_KEPT, "token", None) != token:
        if scene is None:
            return None
        _KEPT.scene, _KEPT.history = pickle.loads(scene)
        _KEPT.token = token
    return solved_case(_KEPT.scene, _Unpickler(case, _KEPT.scene.bodies).load(), _KEPT.history)
