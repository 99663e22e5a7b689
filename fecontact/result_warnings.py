"""What may be wrong with a result although its certificate holds: warnings, each with a figure and a remedy.

A check is a function of the result that yields sentences; `CHECKS` lists them. A note says what a reader should know
and need not act on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from fecontact.bodies.elastic import ElasticBody

if TYPE_CHECKING:
    from fecontact.result import ContactResult

#: Rotation (radians) and strain from which a result warns; both err by their square and by their own size.
LARGEST_TURN, LARGEST_STRAIN = 0.03, 0.05


def large_turns(result: ContactResult) -> Iterator[str]:
    """Rotations beyond what a linearised one bears."""
    for body, motion in zip(result.scene.bodies, result.state.motions, strict=True):
        turn = float(np.linalg.norm(motion[3:]))
        if turn > LARGEST_TURN:
            yield (
                f"{body.name!r} turns by {turn:.3f} rad, more than a linearised rotation bears: use finite_motion=True."
            )


def large_strains(result: ContactResult) -> Iterator[str]:
    """Strains beyond small-strain elasticity."""
    for body, displacement in zip(result.scene.bodies, result.state.displacements, strict=True):
        if isinstance(body, ElasticBody) and body.model is not None:
            strain = float(np.nanmax(np.abs(body.model.gauss_strain(displacement))))
            if strain > LARGEST_STRAIN:
                yield f"{body.name!r} is strained by {100 * strain:.1f} %: small-strain elasticity is a guess there."


def mended(result: ContactResult) -> Iterator[str]:
    """What readers and surfaces have put right in what they were given."""
    notes = ((body.name, text) for body in result.scene.bodies for text in body.notes)
    yield from dict.fromkeys(f"{name!r}: {text}" for name, text in notes)


#: Everything that is looked at for `ContactResult.warnings` and for `ContactResult.notes`.
CHECKS: tuple[Callable[[ContactResult], Iterator[str]], ...] = (large_turns, large_strains)
NOTES: tuple[Callable[[ContactResult], Iterator[str]], ...] = (mended,)


def warnings_of(result: ContactResult) -> tuple[str, ...]:
    """All warnings of a result."""
    return tuple(text for check in CHECKS for text in check(result))


def notes_of(result: ContactResult) -> tuple[str, ...]:
    """All notes of a result."""
    return tuple(text for check in NOTES for text in check(result))
