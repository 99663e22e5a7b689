"""Scenes and cases by value: what another process needs to solve a case, as bytes, and the function that does it there.

A scene goes without factors (`Model.__getstate__`); the inverse of its condensed stiffness goes with it. A process
keeps the scene that it was sent last, so that further cases come alone; one that does not have it asks for it.
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
from fecontact.scene.sweep_case import summary_of

REMEDY = (
    "Define it in a module that other processes can import (not in the main script, a notebook or by lambda), or "
    "leave out processes= and executor=."
)

#: The scene that this thread was sent last and what it knows from the case solved last, with the scene's token.
_KEPT = threading.local()


class _Pickler(pickle.Pickler):
    """Bodies that the other side has go by their number; what only the main script knows is refused."""

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
    """A scene and what is known of where it touches.

    Raises
    ------
    InputError
        If it cannot be sent; names the body that cannot.
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
    """A case whose bodies are those of a scene that the other side has.

    Raises
    ------
    InputError
        If it cannot be sent.
    """
    try:
        return _packed(dict(case), bodies)
    except Exception as error:
        raise InputError(f"The case {name!r} cannot be sent to other processes: {error}. {REMEDY}") from error


def solved_there(token: str, case: bytes, scene: bytes | None = None) -> dict[str, Any] | None:
    """Summary of a case, by the scene that goes by a token; None if that is neither sent nor kept here."""
    if getattr(_KEPT, "token", None) != token:
        if scene is None:
            return None
        _KEPT.scene, _KEPT.history = pickle.loads(scene)
        _KEPT.token = token
    return summary_of(_KEPT.scene, _Unpickler(case, _KEPT.scene.bodies).load(), _KEPT.history)
