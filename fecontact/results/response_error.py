"""Estimated errors of forces and motions, which the elements of whole bodies bring about.

Bodies of finite elements are too stiff: where a motion is given, forces are too large, and under given forces motions
are too small. With the squared energy norm e of the error (`fem.energy_error`), the approach of a body under a force P
is short by e / P, for linear bodies and, up to a fourth, for contacts that grow: the potential energy is too high by
e / 2 (Strang & Fix 1973, section 1.7), and its derivative by the load is the approach.

With one contact that is all. With several, a part of the error concerns each of them: with y the change of the contact
forces for a unit of the quantity, while what is closed stays closed, its error is the product of the errors of the
displacements by y and of those found (dual-weighted residual; Becker & Rannacher 2001, *An optimal control approach to
a posteriori error estimation*). Both errors are those of recovered strains: the dual on the same mesh alone gives zero.

Cells that are too stiff for their stresses, such as 8-node hexahedra in bending, are soft by their error over what is
left of their energy, and count by that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg

from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.common.error_estimate import percent
from fecontact.common.one_line import one_line
from fecontact.contact.condensed_problem import BodyBlock, CondensedProblem, DisplacementState
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.results.contact_fields import ContactFields
from fecontact.solvers import Solution

#: Largest share of a cell's energy that counts as its error: a cell that is too stiff by more is not known.
STIFFEST = 0.9
#: Error of forces over that of recovered strains: 1 in bending of linear cells, up to 2 beside clamped edges, where the
#: strains have no bound and those recovered are too smooth.
STIFFNESS = 1.65
#: Largest number of closed points for which changes of forces are found, by a factor of their compliance.
MOST_POINTS = 4000
#: Contacts, the most loaded, whose forces are estimated.
MOST_CONTACTS = 4
#: Share of the largest displacement below which a rotation is no tilt, and of a force below which a change is rounding.
LEAST_TILT, LEAST_CHANGE = 0.01, 1e-6


@one_line
@dataclass(frozen=True)
class ResponseError:
    """Estimated relative errors of forces and motions by the elements of the bodies; None where a figure has none.

    Attributes
    ----------
    force : float or None
        Of the forces of contacts, the largest of them; None where the given forces determine them.
    approach : float or None
        Of the elastic approach of what is pressed by given forces, weighted by these; None where motions are given.
    tilt : float or None
        Of the rotation of a body that is free to tilt, the largest of them.
    """

    force: float | None = None
    approach: float | None = None
    tilt: float | None = None

    def summary(self) -> dict[str, Any]:
        """Its figures, ready for JSON."""
        return dict(vars(self))

    @property
    def worst(self) -> float:
        """The largest of them; zero without any."""
        return max((v for v in vars(self).values() if v is not None), default=0.0)

    def __str__(self) -> str:
        return ", ".join(f"{name} about {percent(v)}" for name, v in vars(self).items() if v is not None)


@one_line
@dataclass(frozen=True, eq=False)
class ResponseErrors:
    """Estimates of a solved scene, and the cells that bring them about.

    Parameters
    ----------
    condensed : CondensedProblem
    solution : Solution
    state : DisplacementState
    contacts : sequence of ContactFields
    frictional : bool
        Whether any contact has friction.
    rotation : callable
        Rotation vector (3,) of a body.
    """

    condensed: CondensedProblem
    solution: Solution
    state: DisplacementState
    contacts: Sequence[ContactFields]
    frictional: bool
    rotation: Callable[[Body], Array]

    @cached_property
    def primal(self) -> tuple[EnergyError, ...]:
        """Errors in all cells of each body; none in bodies without."""
        pairs = zip(self.condensed.parts, self.state.displacements, strict=True)
        return tuple(_errors(part, u) for part, u in pairs)

    @cached_property
    def cells(self) -> dict[str, tuple[Array, ...]]:
        """Parts (n_cells,) of each body's cells in each relative error of `ResponseError`, signed."""
        if not any(len(each.cells) for each in self.primal):
            return {}
        found: dict[str, tuple[Array, ...]] = {}
        for name, parts in self._parts():
            if name not in found or _total(parts) > _total(found[name]):
                found[name] = parts
        return found

    @cached_property
    def estimate(self) -> ResponseError:
        """The estimates."""
        return ResponseError(**{name: _total(parts) for name, parts in self.cells.items()})

    def _parts(self) -> Iterator[tuple[str, tuple[Array, ...]]]:
        """Names of errors, and the parts of the cells in them."""
        problem, forces, parts = self.condensed.problem, self.solution.forces, self.condensed.parts
        closed = np.flatnonzero(forces > 0)
        if not len(closed):
            return
        start = np.cumsum([0] + [len(c.candidates) for c in self.contacts])
        touching = [k for k, c in enumerate(self.contacts) if c.active.any()]
        only_pressed = not self.frictional and all(part.loads is None for part in parts)
        known = problem.is_dense and not self.frictional and len(closed) <= MOST_POINTS
        alone = len(touching) == 1 and only_pressed and start[-1] == problem.n
        elastic = sum(float(each.energy.sum()) for each in self.primal)
        if only_pressed:
            elastic = float(-forces @ (problem.g + problem.B.T @ self.solution.q))
        driven = bool(np.abs(problem.F).max(initial=0.0) > 0)
        whole = tuple(_amplified(each, each.error) / elastic for each in self.primal)
        if alone or not known:
            yield "approach" if driven else "force", whole
        change = _Change.of(problem.S[np.ix_(closed, closed)], problem.B[:, closed]) if known else None
        if change is None:
            return
        for k in [] if alone else sorted(touching, key=lambda k: -self.contacts[k].total_force)[:MOST_CONTACTS]:
            contact = self.contacts[k]
            pull = contact.forces @ contact.normals
            size = float(np.linalg.norm(pull))
            along = np.zeros(problem.n)
            along[start[k] : start[k + 1]] = contact.normals[contact.candidates] @ pull
            y = change.by(along[closed] / size, np.zeros(len(problem.F)))
            if np.abs(y).max() * elastic > LEAST_CHANGE * forces.max() * size:
                yield "force", self._products(closed, y, size)
        if driven and not alone:
            yield "approach", self._products(closed, change.by(np.zeros(len(closed)), problem.F), elastic)
        first = 0
        for part in parts:
            own, free = slice(first, first + part.free.shape[1]), part.free[3:]
            first = own.stop
            if not free.any():
                continue
            turn = self.rotation(part.body)
            size = float(np.linalg.norm(turn))
            if size * part.body.size > LEAST_TILT * self.state.scale:
                wanted = np.zeros(len(problem.F))
                wanted[own] = free.T @ turn / size
                yield "tilt", self._products(closed, change.by(np.zeros(len(closed)), wanted), size)

    def _products(self, closed: IntArray, y: Array, size: float) -> tuple[Array, ...]:
        """Parts of the cells in an error relative to a size, with changes y of the forces at closed points."""
        changes = np.zeros(self.condensed.problem.n)
        changes[closed] = y
        out = []
        for part, own, u in zip(self.condensed.parts, self.primal, self.state.displacements, strict=True):
            if not len(own.cells):
                out.append(own.error)
                continue
            product = _errors(part, u, part.answer(changes[part.index])).error
            out.append(_amplified(own, product) / size)
        return tuple(out)


@dataclass(frozen=True, eq=False)
class _Change:
    """Changes of contact forces at closed points: factor of their compliance, equilibrium B (m, n), its inverse."""

    factor: tuple[Array, bool]
    B: Array
    balance: Array

    @classmethod
    def of(cls, S: Array, B: Array) -> _Change | None:
        """Those with a compliance S (n, n); None where it leaves forces unknown, as between rigid bodies."""
        try:
            factor = scipy.linalg.cho_factor(S)
        except np.linalg.LinAlgError:
            return None
        resisted = B @ scipy.linalg.cho_solve(factor, B.T)
        return cls(factor, B, np.linalg.pinv(resisted, rcond=1e-10, hermitian=True))

    def by(self, a: Array, b: Array) -> Array:
        """Changes y with S y + B^T z = a and B y = b."""
        x = scipy.linalg.cho_solve(self.factor, a)
        z = self.balance @ (self.B @ x - b)
        return np.asarray(x - scipy.linalg.cho_solve(self.factor, self.B.T @ z))


def _errors(part: BodyBlock, u: Array, other: Array | None = None) -> EnergyError:
    """Errors in all cells of an elastic body; none in other bodies."""
    for body in elastic_among([part.body]):
        loaded = np.zeros(body.n_dofs, bool) if part.loads is None else part.loads != 0
        loaded[part.rows.indices] = True
        plain = body.n_dofs == 3 * len(body.mesh.points)
        free = np.asarray(~loaded.reshape(-1, 3).any(axis=1)) if plain else None
        return body.model.energy_error(u, np.arange(len(body.mesh.cells)), other, free)
    return NO_CELLS


def _amplified(own: EnergyError, product: Array) -> Array:
    """Products of errors (n,), by what their error leaves of the energy of cells."""
    share = np.divide(own.error, own.energy, out=np.zeros_like(own.error), where=own.energy > 0)
    return np.asarray(STIFFNESS * product / (1 - np.minimum(share, STIFFEST)))


def _total(parts: tuple[Array, ...]) -> float:
    return abs(float(sum(part.sum() for part in parts)))
