"""Assembly of ANCF solids with supports, contacts and dead loads: one vector of coordinates, one set of conditions."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from fecontact.ancf.bricks.solid import AncfSolid
from fecontact.ancf.bricks.tangents import Places, has_pattern, with_data
from fecontact.ancf.system.joints import Hubs, Joints, affine_modes, free_directions
from fecontact.ancf.system.member import Member
from fecontact.ancf.system.memory import Lapse
from fecontact.ancf.system.moving_contact import ContactConstraints, ContactGaps, MovingSide, RigidMaster
from fecontact.ancf.system.newton import DEPENDENT
from fecontact.ancf.system.tangent import Reduction, Tangent
from fecontact.bodies.body import Body
from fecontact.bodies.rigid import RigidBody
from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.renamed import renamed
from fecontact.contact.contact import Contact, Side, is_side
from fecontact.fem.laws import InvertedError
from fecontact.fem.support import Support

#: What users are asked for.
A_CONTACT = "each of the contacts, such as Contact(solid.side('top'), ball),"
#: Part of the unit directions of a rigid hub that is not affine, above which it is not rounding.
AFFINE = 1e-9


@dataclass(frozen=True, eq=False)
class Conditions:
    """All contact conditions at some coordinates.

    Attributes
    ----------
    parts : tuple of ContactGaps
        One for each touch.
    gap : (m,) array
    G : (m, n_dofs) csr_matrix
    """

    parts: tuple[ContactGaps, ...]
    gap: Array
    G: sp.csr_matrix


@dataclass(frozen=True, eq=False)
class Constants:
    """What depends on members and supports only, so that it is computed once for all poses of rigid bodies."""

    solids: Sequence[Member]
    supports: Sequence[sp.csr_matrix]

    @cached_property
    def free(self) -> sp.csr_matrix:
        """Orthonormal directions (n_dofs, n_free) that supports and joints leave free."""
        return free_directions(self.supports, self.starts[-1])

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """First coordinate of each solid, and the number of all."""
        return (0, *np.cumsum([s.n_dofs for s in self.solids]).tolist())

    @cached_property
    def q0(self) -> Array:
        """Initial coordinates (n_dofs,)."""
        return np.concatenate([s.q0 for s in self.solids])

    @cached_property
    def lengths(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths."""
        return np.concatenate([s.scales for s in self.solids])

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """Consistent mass (n_dofs, n_dofs)."""
        return sp.csr_matrix(sp.block_diag([s.mass for s in self.solids]))

    @cached_property
    def _reductions(self) -> list[Reduction | None]:
        """That of the first tangent's pattern."""
        return []

    def reduced(self, K: sp.csr_matrix) -> Tangent:
        """Z^T K Z of a tangent (n_dofs, n_dofs) with the order of its band; the pattern is worked out once."""
        fits = self._places(K) is not None
        if fits and not self._reductions:
            self._reductions.append(Reduction.of(K, self.free))
        kept = self._reductions[0] if fits else None
        return Tangent(sp.csr_matrix(self.free.T @ K @ self.free)) if kept is None else kept(K)

    @cached_property
    def _patterns(self) -> list[Places]:
        """That of the first tangent."""
        return []

    def _places(self, K: sp.csr_matrix) -> Places | None:
        """Places in a tangent's pattern; None where it is not that of the first."""
        if not self._patterns:
            self._patterns.append(Places.of(K))
        kept = self._patterns[0]
        return kept if has_pattern(K, kept.indices, kept.indptr) else None

    @cached_property
    def _mass_entries(self) -> Array | None:
        """The mass at the entries of the first tangent; None where it has others."""
        return self._patterns[0].entries(self.mass)

    def with_mass(self, K: sp.csr_matrix, inertia: float) -> sp.csr_matrix:
        """A tangent (n_dofs, n_dofs) with a multiple of the mass, in the tangent's pattern if it fits."""
        mass = None if self._places(K) is None else self._mass_entries
        return sp.csr_matrix(K + inertia * self.mass) if mass is None else with_data(K, K.data + inertia * mass)

    def minus(self, K: sp.csr_matrix, *others: sp.csr_matrix | None) -> sp.csr_matrix:
        """A tangent less other matrices, in the tangent's pattern if they fit: faces have the coordinates of cells."""
        for other in others:
            if other is not None:
                places = self._places(K)
                data = None if places is None else places.entries(other)
                K = sp.csr_matrix(K - other) if data is None else with_data(K, K.data - data)
        return K

    @cached_property
    def no_rows(self) -> sp.csr_matrix:
        """Gradient (0, n_dofs) of no conditions."""
        return sp.csr_matrix((0, self.starts[-1]))

    @cached_property
    def mass_factor(self) -> spla.SuperLU:
        """Factor of the mass of the free coordinates."""
        return spla.splu(sp.csc_matrix(self.free.T @ self.mass @ self.free))


@dataclass(frozen=True, eq=False)
class Assembly:
    """Several solids; q holds their coordinates one after the other.

    Parameters
    ----------
    solids : sequence of Member
        Solids of bricks, or structures of slender elements.
    supports : sequence of (k, n_dofs) csr_matrix
        Supports and joints, rows of coordinates that keep their initial values or have those of a prescribed motion:
        from `Joints`.
    contacts : sequence of Contact
        The slave is a side of a member, the master a rigid body or a side of another: ``solid.side("top")``,
        ``cable.side(offset)``.
    rigid : sequence of int
        Numbers of the solids that are rigid hubs, which need the condition `Joints.affine`, see `hubs`.

    Raises
    ------
    InputError
        For a rigid hub that is no solid of bricks, or is free to move otherwise than affinely; for contacts of bodies
        or members that are not in the assembly, or that it has twice.
    """

    solids: Sequence[Member]
    supports: Sequence[sp.csr_matrix] = ()
    contacts: Sequence[Contact] = ()
    rigid: Sequence[int] = ()

    touches = renamed("touches", "constraints")

    def __post_init__(self) -> None:
        if sp.issparse(self.supports) or any(C.shape[1] != self.n_dofs for C in self.supports):
            raise InputError(
                f"The supports and joints of an assembly are a list of those that Joints makes, with {self.n_dofs} "
                "columns each, not the directions that they leave free.",
                code="supports",
            )
        for k in self.rigid:
            space = getattr(self.solids[k], "space", None) if 0 <= k < len(self.solids) else None
            if space is None:
                raise InputError(f"A rigid hub is a solid of bricks; number {k} is none of the {len(self.solids)}.")
            free, modes = self.free[self.starts[k] : self.starts[k + 1]], affine_modes(space)
            if abs(free - modes @ (modes.T @ free)).max() > AFFINE:
                raise InputError(f"Solid {k} is to be rigid, but does not move affinely: give it joints.affine({k}).")
        _ = self.constraints

    @cached_property
    def constraints(self) -> tuple[ContactConstraints, ...]:
        """Gaps of each contact at any coordinates, and their gradients."""
        return tuple(self._bound(instance(A_CONTACT, contact, Contact)) for contact in self.contacts)

    def _bound(self, contact: Contact) -> ContactConstraints:
        if not is_side(contact.slave):
            raise InputError(
                f"The contact of {contact.slave.name!r} is one of a scene: the slave in an assembly is a side of a "
                "member, solid.side('top') or cable.side(offset).",
                code="contact-of-bodies",
            )
        slave, start = cast(MovingSide, contact.slave), cast(int, self._start(contact.slave))
        other = self._start(contact.master)
        if other is None:
            return slave.constraints(RigidMaster(cast(RigidBody, contact.master)), (start, None), self.q0, contact.mu)
        master = cast(MovingSide, contact.master)
        if master.member.is_slender != slave.member.is_slender:
            raise InputError(
                f"Contact of bricks with slender members is not available; found {slave.name!r} and {master.name!r}.",
                code="bricks-and-members",
            )
        return slave.constraints(master, (start, other), self.q0, contact.mu)

    def _start(self, side: Side | Body) -> int | None:
        """First coordinate of the member of a side, which is found by identity; None of a rigid body."""
        if not is_side(side):
            return None
        found = [k for k, s in enumerate(self.solids) if s is side.member]
        if len(found) != 1:
            raise InputError(
                f"The member of {side.name!r} is {'twice' if found else 'not'} in the assembly (compared by identity), "
                "which a contact of it needs once.",
                code="not-in-assembly",
            )
        return self.starts[found[0]]

    @classmethod
    def of(
        cls,
        solids: Sequence[AncfSolid],
        supports: Sequence[Mapping[str, Support]] | None = None,
        contacts: Sequence[Contact] = (),
    ) -> Assembly:
        """Assembly of solids, their supports by boundary, and the contacts between them.

        Parameters
        ----------
        solids : sequence of AncfSolid
        supports : sequence of mappings, optional
            For each solid, its supports by boundary, see `hold`; none unless given.
        contacts : sequence of Contact

        Examples
        --------
        >>> import fecontact as fc
        >>> from fecontact.ancf import AncfSolid, AncfSpace
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
        >>> cube = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.3))
        >>> floor = fc.RigidBody(fc.Plane())
        >>> Assembly.of([cube], [{"top": "xyz"}], [fc.Contact(cube.side("bottom"), floor)]).n_multipliers
        8
        """
        held = [{}] * len(solids) if supports is None else list(supports)
        if len(held) != len(solids):
            raise InputError(f"supports must be given for each of the {len(solids)} solids; found {len(held)}.")
        joints = Joints(solids)
        return cls(tuple(solids), [joints.held(k, given) for k, given in enumerate(held) if given], tuple(contacts))

    def with_rigid(self, *bodies: RigidBody) -> Assembly:
        """The same assembly with other poses of the rigid bodies, one for each contact with a rigid body.

        Raises
        ------
        InputError
            If their number is not that of the contacts with a rigid body.
        """
        rigid = [k for k, contact in enumerate(self.contacts) if contact.master.is_rigid]
        if len(rigid) != len(bodies):
            raise InputError(f"The assembly touches {len(rigid)} rigid bodies; found {len(bodies)}.")
        contacts, constraints = list(self.contacts), list(self.constraints)
        for k, body in zip(rigid, bodies, strict=True):
            contacts[k] = replace(contacts[k], master=body)
            constraints[k] = replace(constraints[k], master=RigidMaster(body))
        other = copy.copy(self)  # with what depends on members and supports only
        other.__dict__.update(contacts=tuple(contacts), constraints=tuple(constraints))
        return other

    @cached_property
    def constants(self) -> Constants:
        """What depends on members and supports only."""
        return Constants(self.solids, self.supports)

    @property
    def free(self) -> sp.csr_matrix:
        """Orthonormal directions (n_dofs, n_free) of the coordinates that supports and joints leave free."""
        return self.constants.free

    @cached_property
    def hubs(self) -> Hubs | None:
        """Conditions of the rigid hubs; None without any."""
        if not self.rigid:
            return None
        first = [self.starts[k] + 3 * int(self.solids[k].space.start[0]) for k in self.rigid]  # type: ignore[attr-defined]
        return Hubs(np.array(first)[:, None, None] + np.arange(3, 12).reshape(3, 3), self.n_dofs)

    def hub_strains(self, q: Array) -> Array:
        """Strains (6 n_hubs,) of the rigid hubs at coordinates q, which are to vanish."""
        return np.zeros(0) if self.hubs is None else self.hubs.strains(q)

    @property
    def starts(self) -> tuple[int, ...]:
        """First coordinate of each solid, and the number of all."""
        return self.constants.starts

    @property
    def n_dofs(self) -> int:
        """Coordinates of all solids."""
        return self.starts[-1]

    @property
    def q0(self) -> Array:
        """Initial coordinates (n_dofs,)."""
        return self.constants.q0

    @cached_property
    def size(self) -> float:
        """Largest extent of the solids."""
        return max(s.extent for s in self.solids)

    @property
    def lengths(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths; generalised forces over them are forces."""
        return self.constants.lengths

    @property
    def n_multipliers(self) -> int:
        """Contact conditions of all contacts."""
        return sum(t.n_multipliers for t in self.constraints)

    @cached_property
    def widths(self) -> Array:
        """Lengths (n_multipliers,) on which they act."""
        return np.concatenate([np.zeros(0), *(t.widths for t in self.constraints)])

    def largest_change(self, x: Array) -> float:
        """Largest change of a coordinate of a change x (n_dofs,), as a length."""
        return float(np.abs(self.lengths * x).max(initial=0.0))

    def largest_force(self, forces: Array) -> float:
        """Largest of generalised forces (n_dofs,), in units of force."""
        return float(np.abs(forces / self.lengths).max(initial=0.0))

    def held(self, x: Array) -> Array:
        """Part of a change of coordinates, or of forces, (n_dofs,) that the supports take."""
        return np.asarray(x - self.free @ (self.free.T @ x))

    def part(self, q: Array, k: int) -> Array:
        """Coordinates of solid k."""
        return q[self.starts[k] : self.starts[k + 1]]

    def energy(self, q: Array) -> float:
        """Strain energy."""
        return sum(s.energy(self.part(q, k)) for k, s in enumerate(self.solids))

    def forces(self, q: Array) -> Array:
        """Elastic forces (n_dofs,)."""
        return np.concatenate([s.forces(self.part(q, k)) for k, s in enumerate(self.solids)])

    def tangent(self, q: Array) -> sp.csr_matrix:
        """Derivative (n_dofs, n_dofs) of the elastic forces."""
        blocks = [s.tangent(self.part(q, k)) for k, s in enumerate(self.solids)]
        return blocks[0] if len(blocks) == 1 else sp.csr_matrix(sp.block_diag(blocks))

    @property
    def _remembering(self) -> list[tuple[int, Any]]:
        """Numbers and solids that remember."""
        return [(k, s) for k, s in enumerate(self.solids) if getattr(s, "remembers", False)]

    @property
    def memory(self) -> Array:
        """What all members remember (n,)."""
        return np.concatenate([np.zeros(0), *(s.memory for _, s in self._remembering)])

    def remembering(self, memory: Array) -> Assembly:
        """The same assembly after a memory (n,) of its members.

        Raises
        ------
        InputError
            If it is not one of these members.
        """
        found, start, solids = self._remembering, 0, list(self.solids)
        sizes = [len(s.memory) for _, s in found]
        if sum(sizes) != len(memory):
            raise InputError(
                f"The members of the assembly remember {sum(sizes)} numbers, the state {len(memory)}: go on from a "
                "state of the same members.",
                code="memory",
            )
        if not len(memory):
            return self
        for (k, solid), size in zip(found, sizes, strict=True):
            solids[k], start = solid.remembering(memory[start : start + size]), start + size
        _ = self.constants
        other = copy.copy(self)
        other.__dict__["solids"] = tuple(solids)
        return other

    @property
    def warnings(self) -> tuple[str, ...]:
        """Of members that have flowed by more than their law, or their cells, bear."""
        return tuple(f"Solid {k + 1}: {each}" for k, s in self._remembering for each in s.cautions)

    def relaxed(self, q: Array) -> Array:
        """The memory (n,) of all members, at rest at coordinates q."""
        return np.concatenate([np.zeros(0), *(s.relaxed(self.part(q, k)) for k, s in self._remembering)])

    def lapse(self, q0: Array, q1: Array, h: float) -> Lapse:
        """What the memory of all members does in a step of length h."""
        forces, kept, lost, stored = np.zeros(self.n_dofs), [np.zeros(0)], 0.0, 0.0
        for k, solid in self._remembering:
            own = solid.lapse(self.part(q0, k), self.part(q1, k), h)
            forces[self.starts[k] : self.starts[k + 1]] = own.forces
            kept.append(own.memory)
            lost, stored = lost + own.lost, stored + own.stored
        return Lapse(forces, np.concatenate(kept), lost, stored)

    def step_tangent(self, q: Array, h: float, share: float) -> sp.csr_matrix:
        """A share of the elastic tangent (n_dofs, n_dofs), and that of viscosity by the end of a step of length h."""
        K = self.tangent(q)
        numbers = {k: s for k, s in self._remembering if s.viscous is not None}
        if not numbers:
            return share * K
        empty = ((k, sp.csr_matrix((s.n_dofs, s.n_dofs))) for k, s in enumerate(self.solids))
        blocks = [numbers[k].viscous_tangent(self.part(q, k), h) if k in numbers else none for k, none in empty]
        return sp.csr_matrix(share * K + sp.block_diag(blocks))

    def check_inverted(self, q: Array) -> None:
        """Refuse coordinates that turn material inside out, see `AncfSolid.check_inverted`; names the solid.

        Raises
        ------
        InvertedError
            If det F <= 0 at a Gauss point.
        """
        for k, solid in enumerate(self.solids):
            try:
                solid.check_inverted(self.part(q, k))
            except InvertedError as error:
                raise InvertedError(f"Solid {k + 1}: {error}", code=error.code) from error

    @property
    def mass(self) -> sp.csr_matrix:
        """Consistent mass (n_dofs, n_dofs)."""
        return self.constants.mass

    def accelerated(self, forces: Array, q: Array | None = None, v: Array | None = None) -> Array:
        """Accelerations (n_dofs,) due to forces; the mass is constant and factorised once.

        Rigid hubs need coordinates q, and have velocities v with which the conditions are to hold on, or none.
        """
        Z, solve = self.free, self.constants.mass_factor.solve
        if self.hubs is None or q is None:
            return np.asarray(Z @ solve(Z.T @ forces))
        C = (self.hubs.derivative(q) @ Z).toarray()
        by_load, by_hubs = solve(Z.T @ forces), solve(C.T)
        missing = C @ by_load + (0.0 if v is None else self.hubs.quadratic_velocity(v))
        return np.asarray(Z @ (by_load - by_hubs @ (np.linalg.pinv(C @ by_hubs, rcond=DEPENDENT) @ missing)))

    def translation(self, direction: Array) -> Array:
        """Change (n_dofs,) of the coordinates by a translation (3,) of all solids."""
        return np.concatenate([s.translation(direction) for s in self.solids])

    def gravity(self, acceleration: Array) -> Array:
        """Weight (n_dofs,) by an acceleration (3,).

        Raises
        ------
        InputError
            If a member has no mass.
        """
        if np.any(acceleration):
            for k, member in enumerate(self.solids):
                if not member.mass.data.any():
                    raise InputError(
                        f"Member {k} has no mass, so it weighs nothing: give its material a density, a line its mass.",
                        code="no-mass",
                    )
        return np.asarray(self.mass @ self.translation(acceleration))

    def conditions(self, q: Array) -> Conditions:
        """Contact conditions at coordinates q."""
        parts = tuple(t.at(q) for t in self.constraints)
        gap = np.concatenate([p.gap for p in parts]) if parts else np.zeros(0)
        G = sp.vstack([p.G for p in parts], format="csr") if parts else self.constants.no_rows
        return Conditions(parts, gap, G)

    def split(self, forces: Array) -> list[Array]:
        """Forces of each contact, split from those of all."""
        ends = np.cumsum([t.n_multipliers for t in self.constraints])
        return list(np.split(forces, ends[:-1])) if self.contacts else []

    def curvature(self, conditions: Conditions, forces: Array) -> sp.csr_matrix | None:
        """Second derivative of forces . gap; None where it vanishes."""
        blocks = [
            t.curvature(p, f) for t, p, f in zip(self.constraints, conditions.parts, self.split(forces), strict=True)
        ]
        found = [b for b in blocks if b is not None]
        return sum(found[1:], found[0]) if found else None

    def momentum(self, velocity: Array) -> Array:
        """Linear momentum (3,)."""
        return np.array([self.translation(e) for e in np.eye(3)]) @ (self.mass @ velocity)
