"""Numbers by name that a case of a sweep is given: parameters of the user, loads and poses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.common.arguments import mapping, text
from fecontact.common.arrays import Array
from fecontact.common.checks import finite
from fecontact.common.errors import InputError
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.case_figures import FIGURES, GIVEN, WHOLE

AXES = ("x", "y", "z")


def parameters_of(case: Mapping[str, Any]) -> dict[str, float]:
    """Numbers that belong to a case, by name.

    Raises
    ------
    InputError
        If one is no finite number, or has the name of a column of the table.

    Examples
    --------
    >>> parameters_of({"parameters": {"angle": 30}})
    {'angle': 30.0}
    """
    return {
        _free_name(name): float(finite(f"the parameter {name!r}", value))
        for name, value in mapping("parameters", case.get("parameters")).items()
    }


def loads_of(case: Mapping[str, Any]) -> dict[str, float]:
    """Loads and poses of a valid case by kind, body and component.

    ``forces ball z``, ``poses ball rx`` (a component of the rotation vector, radians), ``pressures pad.top``. Loads
    that vary over a boundary are no numbers and left out.

    Examples
    --------
    >>> loads_of({"gravity": (0.0, 0.0, -9.81)})
    {'gravity x': 0.0, 'gravity y': 0.0, 'gravity z': -9.81}
    """
    return {" ".join(words): float(value) for *words, value in _numbers(case)}


def _free_name(name: object) -> str:
    word = text("the name of a parameter", name)
    if word in (*FIGURES, *WHOLE) or word.partition(" ")[0] in (*GIVEN, "tractions", "gravity") or ": " in word:
        raise InputError(f"The parameter {word!r} has the name of a column of the table; give it another name.")
    return word


def _numbers(case: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Kind, body and component, and the number."""
    if case.get("gravity") is not None:
        yield from (("gravity", axis, v) for axis, v in zip(AXES, case["gravity"], strict=True))
    for kind in ("forces", "moments", "tractions"):
        for key, value in (case.get(kind) or {}).items():
            if not callable(value):
                yield from ((kind, _target(key), axis, v) for axis, v in zip(AXES, value, strict=True))
    for key, value in (case.get("pressures") or {}).items():
        if not callable(value):
            yield "pressures", _target(key), value
    for body, motion in (case.get("motions") or {}).items():
        yield from (("motions", body.name, component, value) for component, value in motion.items())
    for body, pose in (case.get("poses") or {}).items():
        yield from (("poses", body.name, c, v) for c, v in zip(COMPONENTS, _six(pose), strict=True))


def _target(key: Any) -> str:
    """Body, with its boundary if there is one."""
    body, where = key if isinstance(key, tuple) else (key, None)
    return f"{body.name}.{where}" if isinstance(where, str) else str(body.name)


def _six(pose: Any) -> Array:
    """Translation and rotation vector (6,)."""
    return np.concatenate([pose.translation, Rotation.from_matrix(pose.rotation).as_rotvec()])
