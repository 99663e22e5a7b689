"""Bolts tightened to a force: how far a cut in a body is to be shortened.

A bolt that is cut between its head and its nut has a motion of its own there, which only contacts resist, if anything.
So the shortening d is prescribed, as values of linear conditions of the body, and sought by the tension, the sum of
what the elements on one side of the cut take up at its nodes, less loads on these. Without friction the tension is
piecewise linear in d, and the secants of Broyden's method end on it exactly; with friction it is that of one step from
the unloaded state.

Source: C. G. Broyden, A class of methods for solving nonlinear simultaneous equations, Math. Comp. 19 (1965) 577.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import SolverError
from fecontact.results.result import ContactResult

if TYPE_CHECKING:
    from fecontact.scene.scene import Scene

#: First shortening, over the size of the body.
FIRST = 1e-5
#: Difference of a tension from what is asked, over it, that is accepted, and the largest number of solutions.
CLOSE, MOST = 1e-9, 40


@dataclass(frozen=True, eq=False)
class Tension:
    """A force in a cut of a body.

    Attributes
    ----------
    body : ElasticBody
    values : (m,) array
        Values of the body's linear conditions for a unit shortening.
    nodes : (k,) int array
        On one side of the cut.
    direction : (3,) array
        In which the shortening moves them, as a unit vector in the axes of the body.
    force : float
    later : sequence of (ElasticBody, (m,) array)
        Body and values in each step after the one in which it is tightened, which keep the shortening.
    """

    body: ElasticBody
    values: Array
    nodes: IntArray
    direction: Array
    force: float
    later: Sequence[tuple[ElasticBody, Array]] = ()

    def of(self, result: ContactResult) -> float:
        """The tension in a result: what elements take up at the nodes, without what acts on them from elsewhere."""
        k = result._number(self.body)
        part, forces = result._condensed.parts[k], (result.friction or result.solution).forces
        given = part.rows.T @ forces[part.index] + (0.0 if part.loads is None else part.loads)
        inside = result._forces_inside(self.body) - given.reshape(-1, 3)
        return float(inside[self.nodes].sum(axis=0) @ self.direction)


@dataclass(frozen=True, eq=False)
class Tightened:
    """Shortenings (n,) by which cuts bear their tensions, and the result of the step in which they do."""

    tensions: Sequence[Tension]
    shortenings: Array
    result: ContactResult

    @property
    def note(self) -> str:
        """The shortenings in words."""
        each = zip(self.tensions, self.shortenings.tolist(), strict=True)
        told = ", ".join(f"{d:.6g} in {t.body.name!r} for {t.force:g}" for t, d in each)
        return f"Cuts are shortened to bear their tensions: {told}."

    def loads(self, k: int, given: Mapping[str, Any]) -> dict[str, Any]:
        """Loads of step k with the shortenings."""
        return shortened(given, self.tensions, self.shortenings, k)


def shortened(loads: Mapping[str, Any], tensions: Sequence[Tension], shortenings: Array, k: int = 0) -> dict[str, Any]:
    """Loads of a step with shortenings (n,) of cuts."""
    given = dict(loads.get("displacements", {}))
    for t, d in zip(tensions, shortenings.tolist(), strict=True):
        body, values = t.later[k - 1] if k else (t.body, t.values)
        given[body] = given.get(body, 0.0) + d * values
    return {**loads, "displacements": given}


def tightened(
    scene: Scene, tensions: Sequence[Tension], loads: Mapping[str, Any], options: Mapping[str, Any]
) -> Tightened:
    """Shorten the cuts of a scene until they bear their tensions.

    Raises
    ------
    SolverError
        If no shortening does, as nothing resists a cut.
    """
    wanted = np.array([t.force for t in tensions])

    def solved(shortening: Array) -> tuple[ContactResult, Array]:
        result = scene.solve(**shortened(loads, tensions, shortening), **options)
        return result, np.array([t.of(result) for t in tensions])

    d = FIRST * np.sign(wanted) * np.array([t.body.size for t in tensions])
    result, force = solved(d)
    slopes = np.diag(force / d)
    for _ in range(MOST):
        off = force - wanted
        if np.abs(off).max() <= CLOSE * np.abs(wanted).max():
            return Tightened(tensions, d, result)
        change = -np.linalg.lstsq(slopes, off, rcond=None)[0]
        d = d + change
        result, then = solved(d)
        slopes += np.outer(then - force - slopes @ change, change) / (change @ change)
        force = then
    raise SolverError(
        f"No shortening of the cuts was found by which they bear {wanted.tolist()}; the last one, {d.tolist()}, gives "
        f"{force.tolist()}. Does anything resist them?",
        code="tension",
    )
