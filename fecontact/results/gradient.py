"""Derivatives of figures of a solved scene by gaps, loads and moduli, see `solvers.gradient`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.common.arguments import items
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, number_array, whole
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.contact.condensed_problem import BodyBlock
from fecontact.results.contact_fields import ContactFields
from fecontact.solvers.gradient import adjoint, of_largest, weakly_active

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult
#: Figures of a contact that can be differentiated, and by what.
FIGURES, BY = ("max_pressure", "force"), ("gaps", "loads", "E")


@compact_repr
@dataclass(frozen=True, eq=False)
class Gradient:
    """Derivatives of a figure of one contact of a scene, or of rigid motions; empty those that were not asked for.

    Attributes
    ----------
    value : float
        The figure.
    gaps : tuple of (n,) arrays
        Derivatives by the gaps before the load at the points of each contact; zero where these are no candidates.
    loads : mapping of Body to (6,) array
        By force and moment on a body as a whole, about its reference point, in world axes; zero along what is held.
        Floating bodies are left out.
    E : mapping of Body to float
        By Young's modulus of bodies of one linear material, its Poisson's ratio fixed.
    weak : tuple of int arrays
        Points of each contact about to open, to close or to slide: derivatives are one-sided there.
    """

    value: float
    gaps: tuple[Array, ...]
    loads: Mapping[Body, Array]
    E: Mapping[Body, float]
    weak: tuple[IntArray, ...]


def result_gradient(
    result: ContactResult, what: str | ArrayLike | Mapping[Body, ArrayLike], contact: int, of: Sequence[str] = BY
) -> Gradient:
    """Derivatives of a figure, see `ContactResult.gradient`."""
    _refuse(result)
    for name in (of := items("of", of, "names")):
        among("derivative", name, BY)
    number = whole("the number of the contact", contact, 0, len(result.contacts) - 1)
    solution = result.friction or result.solution
    problem, forces, q = solution.problem, solution.forces, solution.q
    rows = _rows(result)
    by_forces, by_motions = np.zeros(problem.n), np.zeros(problem.m)
    if isinstance(what, Mapping):
        value, by_motions = _of_motions(result, what)
    else:
        value, weights = _figure(result.contacts[number], what)
        by_forces[rows[number]] = weights[result.contacts[number]._candidates]
    found, weak = adjoint(problem, forces, q, by_forces, by_motions), weakly_active(problem, forces, q)
    gaps = []
    for at, fields in zip(rows, result.contacts, strict=True) if "gaps" in of else ():
        gaps.append(np.zeros(len(fields.gap)))
        gaps[-1][fields._candidates] = -found.response[at]
    loads, moduli = {}, {}
    for body, part, own in _by_body(result, found.load):
        if "loads" in of and part.hold is None and not part.frame.spread:
            loads[body] = -part.free @ own
        asked = "E" in of and part.hold is None and part.frame.imposed is None
        modulus = body._modulus if asked else None
        if modulus is not None:
            moved = part.rows @ part.body.displacement(part.rows, forces[part.index], part.loads)
            moduli[body] = float(found.response[part.index] @ moved) / modulus
    each = tuple(c._candidates[np.isin(at, weak)] for at, c in zip(rows, result.contacts, strict=True))
    return Gradient(value, tuple(gaps), loads, moduli, each)


def _by_body(result: ContactResult, values: Array) -> Iterator[tuple[Body, BodyBlock, Array]]:
    """Each body with its part of the condensed problem, and of values (m,) those at its own free motions."""
    parts = result._condensed.parts
    ends = np.cumsum([part.free.shape[1] for part in parts])
    return zip(result.scene.bodies, parts, np.split(values, ends[:-1]), strict=True)


def _of_motions(result: ContactResult, what: Mapping[Body, ArrayLike]) -> tuple[float, Array]:
    """A linear functional of rigid motions, and its derivatives (m,) by those that are free."""
    value, slopes, bodies = 0.0, [], result.scene.bodies
    if unknown := [body for body in what if body not in bodies]:
        raise InputError(f"{unknown[0]!r} is no body of the scene.", code="not-in-scene")
    for k, (body, part, own) in enumerate(_by_body(result, np.zeros(result._condensed.problem.m))):
        if body in what:
            weights = number_array(f"the weights of the motion of {body.name!r}", what[body])
            if weights.shape != (6,):
                raise InputError(
                    f"A rigid motion has 6 components; found weights of {weights.shape}.", code="weights-shape"
                )
            if part.hold is not None or body.free_motions.shape[1]:
                raise InputError(
                    f"{body.name!r} floats: its mean motion depends on its strain, of which no gradient is offered.",
                    code="no-gradient",
                )
            value += float(weights @ result._motions[k])
            own = part.free.T @ weights
        slopes.append(own)
    return value, np.concatenate(slopes)


def _refuse(result: ContactResult) -> None:
    """Refuse results whose condensed problem depends on its own solution, or on steps before."""
    reasons = {
        "its poses were carried along with the motions: solve with finite_motion=False": result._originals,
        "bodies have laws of finite strain": result.finite_strain,
        "it is a step of a load path, which depends on those before": result._follows_step,
    }
    for reason, found in reasons.items():
        if found:
            raise InputError(f"No gradient is offered of this result, as {reason}.", code="no-gradient")


def _rows(result: ContactResult) -> list[IntArray]:
    """Rows of the candidates of each contact in the problem, where springs have rows too."""
    rows, start, contacts = [], 0, iter(result.contacts)
    for interface in result._condensed.interfaces:
        if interface.as_contact is None:
            start += len(interface.gap)
            continue
        count = len(next(contacts)._candidates)
        rows.append(start + np.arange(count))
        start += count
    return rows


def _figure(contact: ContactFields, what: str | ArrayLike) -> tuple[float, Array]:
    """A figure of a contact, and its derivatives (n,) by the normal forces at its points."""
    if not isinstance(what, str):
        weights = number_array("the weights of the pressures", what)
        if weights.shape != contact.forces.shape:
            raise InputError(
                f"The contact has {len(contact.forces)} points, and each a weight of its pressure; found "
                f"{weights.shape}.",
                code="weights-shape",
            )
        return float(weights @ contact.pressure), weights / contact.weights
    among("figure", what, FIGURES)
    if what == "force":
        return contact.total_force, np.ones(len(contact.forces))
    return contact.max_pressure, of_largest(contact.pressure) / contact.weights
