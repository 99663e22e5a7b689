"""Estimated errors of forces and motions, by the elements of whole bodies and by the faces in contact.

Bodies of finite elements are too stiff: where a motion is given, forces are too large, and under given forces motions
are too small. With the squared energy norm e of the error (`fem.energy_error`) and twice the energy W, the force of a
given approach is too large by e / W (Strang & Fix 1973, section 1.7: the energy is too high by e / 2, and its
derivative by the approach is the force). Where the force grows as a power m of the approach the energy is P d / (1 + m)
and the approach under a given force is short by e / (m W): m is 1 where the same points stay closed, 3/2 for Hertz.

With one contact that is all. With several, a part of the error concerns each of them: with y the change of the contact
forces for a unit of the quantity, while what is closed stays closed, its error is the product of the errors of the
displacements by y and of those found (dual-weighted residual; Becker & Rannacher 2001, *An optimal control approach to
a posteriori error estimation*). Both errors are those of recovered strains: the dual on the same mesh alone gives zero.

Faces meet a partner at their nodes or in the mean. Where the gap over a face is not zero, pressures work on it as on an
obstacle in a wrong place: a ball reaches into flat faces between their nodes, which makes up for part of the stiffness.
The sign is known, and the sum counts, but never less than `KEPT` of the elements' part. The squared error of the
pressure is one of the energy, of either sign, of what the bodies approach each other at the contact itself.

At finite strain the error is that of the linear body whose stiffness is the tangent, and the energy the one stored: the
potential energy is too high by e / 2, whatever the law. Forces of all contacts together get one estimate.

Cells that are too stiff for their stresses, such as 8-node hexahedra in bending, are soft by their error over what is
left of the energy, and count by that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import Array, IntArray
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import OF_CELLS, ResponseError
from fecontact.contact.condensed_problem import BodyBlock, CondensedProblem, DisplacementState
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.results.cell_contact import is_half_space
from fecontact.results.contact_fields import ContactFields
from fecontact.solvers import Solution

#: Largest share of a body's energy that counts as its error: a body that is too stiff by more is not known.
STIFFEST = 0.9
#: Least share of the elements' part that gaps between nodes leave: they are known to a part of themselves only.
KEPT = 0.6
#: Error of the energy of what bodies approach each other at a contact, over the squared one of the pressure on faces.
OF_FACES = 0.9
#: Error of forces over that of recovered strains: 1 in bending of linear cells, up to 2 beside clamped edges, where the
#: strains have no bound and those recovered are too smooth.
STIFFNESS = 1.65
#: Largest number of closed points for which changes of forces are found, by a factor of their compliance.
MAX_POINTS = 4000
#: Contacts, the most loaded, whose forces are estimated.
MAX_CONTACTS = 4
#: Share of the largest displacement below which a rotation is no tilt, and of a force below which a change is rounding.
MIN_TILT, MIN_CHANGE = 0.01, 1e-6


class AtRest(NamedTuple):
    """Of bodies at finite strain: gaps (n,) of the candidates before, and what motions of bodies close of them since.

    `driven`: whether forces press them.
    """

    gaps: Array
    closing: Array
    driven: bool


@compact_repr
@dataclass(frozen=True, eq=False)
class ResponseErrors:
    """Estimates of a solved scene, and the cells that bring them about.

    Parameters
    ----------
    condensed : CondensedProblem
    solution : Solution
    state : DisplacementState
    contacts : sequence of ContactFields
    friction : Solution, optional
        With friction, as in `ContactResult`.
    rotation : callable
        Rotation vector (3,) of a body.
    at_rest : AtRest, optional
        Of a scene with bodies at finite strain.
    """

    condensed: CondensedProblem
    solution: Solution
    state: DisplacementState
    contacts: Sequence[ContactFields]
    friction: Solution | None
    rotation: Callable[[Body], Array]
    at_rest: AtRest | None = None

    @cached_property
    def primal(self) -> tuple[EnergyError, ...]:
        """Errors in all cells of each body; none in bodies without."""
        pairs = zip(self.condensed.parts, self.state.displacements, strict=True)
        return tuple(_errors(part, self._forces, u) for part, u in pairs)

    @cached_property
    def reason(self) -> str:
        """Why nothing is estimated; empty where it is."""
        known = {id(p.body) for p, own in zip(self.condensed.parts, self.primal, strict=True) if len(own.cells)}
        touching = [c for c in self.contacts if c.active.any()]
        for body, name in ((b, n) for c in touching for b, n in zip((c.slave, c.master), c.surfaces, strict=True)):
            if not (body.is_rigid or body._is_foundation or id(body) in known or is_half_space(body.surface(name))):
                return f"not estimated with {body.name!r}, whose elements give none"
        return ""

    @cached_property
    def _found(self) -> dict[str, tuple[_Parts, float]]:
        """Parts of each error, the largest of its kind, and its estimate."""
        found: dict[str, tuple[_Parts, float]] = {}
        for name, parts in [] if self.reason else self._parts():
            if name not in found or parts.total > found[name][1]:
                found[name] = parts, parts.total
        return found

    @cached_property
    def cells(self) -> dict[str, tuple[Array, ...]]:
        """Parts (n_cells,) of each body's cells in each relative error of `ResponseError`, signed."""
        return {name: parts.cells for name, (parts, _) in self._found.items()}

    @property
    def stiff(self) -> dict[str, bool]:
        """Whether the elements make most of each error, whose sign is then known."""
        return {name: total > np.sqrt(2) * parts.local for name, (parts, total) in self._found.items()}

    @cached_property
    def estimate(self) -> ResponseError:
        """The estimates."""
        return ResponseError(**{name: value for name, (_, value) in self._found.items()})

    def _parts(self) -> Iterator[tuple[str, _Parts]]:
        """Names of errors, and their parts."""
        problem, forces, parts = self.condensed.problem, self.solution.forces, self.condensed.parts
        closed = np.flatnonzero(forces > 0)
        if not len(closed):
            return
        touching = [k for k, c in enumerate(self.contacts) if c.active.any()]
        only_pressed = self.friction is None and all(part.loads is None for part in parts)
        known = problem.is_dense and self.friction is None and len(closed) <= MAX_POINTS and self.at_rest is None
        alone = len(touching) == 1 and only_pressed and self._start[-1] == problem.n
        elastic = sum(map(self._twice_stored, range(len(parts))))
        if only_pressed or elastic == 0:
            elastic = float(forces @ self._deflection)
        if not elastic > 0:
            return
        driven = bool(np.abs(problem.F).max(initial=0.0) > 0) if self.at_rest is None else self.at_rest.driven
        if alone or not known:
            cells = tuple(_amplified(each, each.error) / elastic for each in self.primal)
            whole = self._with_faces(cells, forces, elastic)
            yield ("approach", whole.over(1 + whole.growth)) if driven else ("force", whole)
        if not known:  # free motions of held problems are eliminated: they have no rows
            return
        turned = list(self._turned())
        several = [] if alone else sorted(touching, key=lambda k: -self.contacts[k].total_force)[:MAX_CONTACTS]
        if not (several or turned):
            return
        change = _Change.of(problem.S[np.ix_(closed, closed)], problem.B[:, closed])
        if change is None:
            return
        for k in several:
            contact = self.contacts[k]
            pull = contact.forces @ contact.normals
            size = float(np.linalg.norm(pull))
            if size <= MIN_CHANGE * contact.total_force:  # all round a ring, whose forces cancel
                continue
            along = np.zeros(problem.n)
            along[self._start[k] : self._start[k + 1]] = contact.normals[contact._candidates] @ pull
            y = change.by(along[closed] / size, np.zeros(len(problem.F)))
            if np.abs(y).max() * elastic > MIN_CHANGE * forces.max() * size:
                yield "force", self._products(closed, y, size)
        wanted = [("tilt", row / size, size) for row, size in turned]
        if driven and several:
            wanted.append(("approach", problem.F, elastic))
        for name, row, size in wanted:
            yield name, self._products(closed, change.by(np.zeros(len(closed)), row), size)

    def _twice_stored(self, k: int) -> float:
        """Twice the energy stored in body k; beside bodies at finite strain also in those without elements."""
        part, own = self.condensed.parts[k], self.primal[k]
        if self.at_rest is None or part.body.is_rigid:
            return float(own.energy.sum())
        u = self.state.displacements[k] - part.frame.modes(self.state.motions[k][:, None])[:, 0]
        for body in elastic_among([part.body]):
            return 2 * body.model.strain_energy(u)
        return float(self.solution.forces[part.index] @ (part.rows @ u))

    def _turned(self) -> Iterator[tuple[Array, float]]:
        """Rows (m,) of the equilibrium by the rotation of each body that has tilted, and its size."""
        first = 0
        for part in self.condensed.parts:
            own, free = slice(first, first + part.free.shape[1]), part.free[3:]
            first = own.stop
            if not free.any():
                continue
            turn = self.rotation(part.body)
            size = float(np.linalg.norm(turn))
            if size * part.body.size > MIN_TILT * self.state.scale:
                row = np.zeros(len(self.condensed.problem.F))
                row[own] = free.T @ turn
                yield row, size

    def _products(self, closed: IntArray, y: Array, size: float) -> _Parts:
        """Parts of an error relative to a size, with changes y of the forces at closed points."""
        changes = np.zeros(self.condensed.problem.n)
        changes[closed] = y
        out = []
        for part, own, u in zip(self.condensed.parts, self.primal, self.state.displacements, strict=True):
            if len(own.cells):
                product = _errors(part, self._forces, u, part.answer(changes[part.index])).error
            else:
                product = own.error
            out.append(_amplified(own, product) / size)
        return self._with_faces(tuple(out), changes, size)

    @property
    def _forces(self) -> Array:
        """Forces of all rows, those of friction included."""
        return (self.friction or self.solution).forces

    @cached_property
    def _start(self) -> IntArray:
        """First candidate of each contact among all of them, and their number."""
        return np.cumsum([0] + [len(c._candidates) for c in self.contacts])

    @cached_property
    def _deflection(self) -> Array:
        """Elastic deflection (n,) at candidates, of both bodies and springs; rows of friction come after them."""
        problem = self.condensed.problem
        return np.asarray(-(problem.g + problem.B.T @ self.solution.q)[: len(self.solution.forces)])

    def _with_faces(self, cells: tuple[Array, ...], y: Array, size: float) -> _Parts:
        """Parts of an error with those by the faces of the contacts, with forces or their changes y (n,)."""
        work = local = growth = 0.0
        gaps_of_all = self.condensed.problem.g if self.at_rest is None else self.at_rest.gaps
        for k, contact in enumerate(self.contacts):
            of_contact = slice(self._start[k], self._start[k + 1])
            own, gaps = y[of_contact], gaps_of_all[of_contact]
            if not contact.active.any() or not own.any():
                continue
            work += float(own @ contact._between_nodes.means[contact._candidates])
            # approach of the bodies at the contact beyond that of the point where they meet first
            beyond = 2 * float(own @ (gaps - gaps.min()))
            growth += beyond
            if self.at_rest is None and (contact.slave._is_foundation or is_half_space(contact._surface)):
                beyond = float(own @ self._deflection[of_contact])
                beyond *= 1.0 if contact.slave._is_foundation else OF_CELLS
            else:
                beyond *= OF_FACES
            square = contact.error_estimate.pressure**2
            local += min(1.0, square) * abs(beyond) if np.isfinite(square) else abs(beyond)
            if self.at_rest is not None:  # P d = (1 + m) W / 2, of all contacts together
                growth -= 2 * float(own @ (gaps - self.at_rest.closing[of_contact]))
        growth -= 0.0 if self.at_rest is None else 2 * size
        return _Parts(cells, work / size, local / size, min(1.0, abs(growth) / size))


class _Parts(NamedTuple):
    """Parts of a relative error, and how much faster than its motion a force grows.

    Attributes
    ----------
    cells : tuple of (n_cells,) arrays
        Of the cells of each body, signed.
    work : float
        Of the work on gaps between nodes, signed.
    local : float
        Of the pressure's error, where bodies approach each other at the contact itself.
    growth : float
        m - 1, for a force that grows as a power m of the approach, at most one.
    """

    cells: tuple[Array, ...]
    work: float
    local: float
    growth: float

    def over(self, m: float) -> _Parts:
        """Parts of the error of an approach from those of a force."""
        return _Parts(tuple(part / m for part in self.cells), self.work / m, self.local / m, self.growth)

    @property
    def total(self) -> float:
        """The error by all of them."""
        of_cells = float(sum(part.sum() for part in self.cells))
        return float(np.hypot(max(abs(of_cells + self.work), KEPT * abs(of_cells)), self.local))


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


def _errors(part: BodyBlock, forces: Array, u: Array, other: Array | None = None) -> EnergyError:
    """Errors in all cells of an elastic body; none in other bodies.

    Its skin is free where neither loads nor forces of contacts (n,) act, wherever else points were looked at.
    """
    for body in elastic_among([part.body]):
        loaded = np.zeros(body.n_dofs, bool) if part.loads is None else part.external != 0
        loaded[part.rows[np.flatnonzero(forces[part.index])].indices] = True
        plain = body.n_dofs == 3 * len(body.mesh.points)
        free = np.asarray(~loaded.reshape(-1, 3).any(axis=1)) if plain else None
        strain = body.model.stressing(u, part.frame.heated)
        return body.model.energy_error(strain, np.arange(len(body.mesh.cells)), other, free)
    return NO_CELLS


def _amplified(own: EnergyError, product: Array) -> Array:
    """Products of errors (n,), by what their error leaves of the body's energy."""
    energy = float(own.energy.sum())
    share = min(float(own.error.sum()) / energy, STIFFEST) if energy > 0 else 0.0
    return np.asarray(STIFFNESS * product / (1 - share))
