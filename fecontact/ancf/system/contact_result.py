"""Contacts of a state, or of the end of a motion, as results: pressure per present area, resultants, area and outline.

A contact of bricks is one of `results.ContactFields`, as a scene's, on the faces as they lie: a point of contact is a
multiplier, its area the integral of the multiplier over the present face, so that force over area is Cauchy's pressure.
Contacts of slender members act along axes and have no faces: `ContactPoints`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.system.moving_contact import ContactConstraints, ContactGaps
from fecontact.bodies.body import Body
from fecontact.bodies.surface_body import SurfaceBody
from fecontact.common.arrays import Array, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.units import UnitNames, Units
from fecontact.results.contact_fields import ContactFields, facets_of_points
from fecontact.results.files import save_csv
from fecontact.results.friction_fields import FrictionFields
from fecontact.solvers.coulomb import friction_limit, sticks

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@compact_repr
@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Contact of a slender member, in world axes; forces are those on the slave.

    Attributes
    ----------
    label : str
    points : (n, 3) array
        Mean places of the multipliers on axis or middle surface.
    normals : (n, 3) array
        Force vectors per unit of contact force.
    weights : (n,) array
        Present lengths of a line, areas of a plate.
    forces, gap : (n,) arrays
    tangential, slip : (n, 3) arrays
        Friction, and slip since the last state.
    """

    label: str
    points: Array
    normals: Array
    weights: Array
    forces: Array
    gap: Array
    tangential: Array
    slip: Array

    @property
    def pressure(self) -> Array:
        """Force (n,) per present length of a line, per area of a plate."""
        return self.forces / self.weights

    @property
    def active(self) -> Mask:
        """Points (n,) that carry force."""
        return self.forces > 0

    @property
    def area(self) -> float:
        """Length or area of the points that carry force."""
        return float(self.weights[self.active].sum())

    @property
    def total_force(self) -> float:
        """Sum of the forces along their normals."""
        return float(self.forces.sum())

    @property
    def force(self) -> Array:
        """Resultant (3,), friction included."""
        return np.asarray(self.forces @ self.normals + self.tangential.sum(axis=0))

    @property
    def max_pressure(self) -> float:
        """Largest of `pressure`."""
        return float(self.pressure.max(initial=0.0))


@dataclass(frozen=True)
class _OnFaces:
    """Contacts of faces, for maps."""

    contacts: tuple[ContactFields, ...]
    unit_names: Units = field(default_factory=Units)


class WithContacts:
    """A state of statics or the end of a motion, whose contacts are results.

    Attributes
    ----------
    constraints : tuple of ContactConstraints
    """

    if TYPE_CHECKING:
        constraints: tuple[ContactConstraints, ...]

    @property
    @abstractmethod
    def _on_contacts(self) -> tuple[Array, Sequence[Sequence[Array]]]:
        """Coordinates (n_dofs,); of each contact forces (n_multipliers,), tangential forces and slip, both (.., 3)."""

    @cached_property
    def contacts(self) -> tuple[ContactFields | ContactPoints, ...]:
        """Every contact at the present coordinates: fields as in a scene, of slender members `ContactPoints`."""
        q, found = self._on_contacts
        return tuple(
            _contact(t, k, q, *each) for k, (t, *each) in enumerate(zip(self.constraints, *found, strict=True))
        )

    def plot(
        self, what: str = "pressure", path: str | Path | None = None, *, units: UnitNames = (), **options: Any
    ) -> Figure:
        """Map a field of every contact of bricks, see `results.pictures.draw.plot_contacts`."""
        from fecontact.results.pictures.draw import plot_contacts

        on_faces = self._on_faces
        if not on_faces:
            raise InputError("The state has no contact of faces to draw; axes of members are in `contacts`.")
        return plot_contacts(_OnFaces(on_faces), what, path, units=units, **options)

    def save(self, path: str | Path, *, units: UnitNames = ()) -> Path:
        """Write the points of its contacts of bricks as a table, .csv; see `results.files.save_csv`."""
        return save_csv(self._on_faces, path, Units.of(units))

    @property
    def _on_faces(self) -> tuple[ContactFields, ...]:
        """The contacts of bricks."""
        pairs = zip(self.contacts, self.constraints, strict=True)
        return tuple(cast(ContactFields, c) for c, t in pairs if not t.slave.member.is_slender)


def _contact(
    touch: ContactConstraints, number: int, q: Array, forces: Array, tangential: Array, slip: Array
) -> ContactFields | ContactPoints:
    """A contact at coordinates q (n_dofs,) of all members, with a number for names."""
    part = touch.at(q)
    x = part.projection.points + part.projection.gap[:, None] * part.projection.normals
    x = np.where(part.projection.outside[:, None], 0.0, x)  # not among the means
    points, normals, weights = part.means @ x, part.means @ part.projection.normals, touch.present_areas(q)
    bodies = touch.present(q, number)
    if bodies is None:
        return ContactPoints(f"contact {number}", points, normals, weights, forces, part.gap, tangential, slip)
    return _on_faces(bodies, part, x, touch.friction, (forces, tangential, slip), weights)


def _on_faces(
    bodies: tuple[SurfaceBody, Body],
    part: ContactGaps,
    x: Array,
    mu: float,
    found: tuple[Array, Array, Array],
    weights: Array,
) -> ContactFields:
    (slave, master), (forces, tangential, slip) = bodies, found
    surface = slave.facets
    facing = np.flatnonzero(np.isfinite(part.gap))
    covered = np.flatnonzero(np.isin(surface.facets, facing).any(axis=1))
    shown, local = np.unique(surface.facets[covered], return_inverse=True)
    means, n, reference = part.means[facing], part.projection.normals, slave.reference_point
    at_nodes = sp.csr_matrix((np.ones(len(facing)), (facing, np.arange(len(facing)))), (len(weights), len(facing)))
    forces, weights = forces[facing], weights[facing]
    return ContactFields(
        slave=slave, master=master, surfaces=(slave.contact[0], master.contact[0]),
        points=surface.points[facing], normals=means @ n, weights=weights, forces=forces, gap=part.gap[facing],
        reference_point=reference, coupling="mortar", note="", _centres=means @ x,
        _couples=means @ np.cross(x - reference, n), _candidates=np.arange(len(facing)), nodes=surface.points[shown],
        _node_numbers=shown, _at_nodes=at_nodes[shown], facets=local.reshape(-1, surface.facets.shape[1]),
        _facet_numbers=covered, _sharing=facets_of_points(at_nodes, surface.facets), _surface=surface,
        _displacements=(np.zeros(slave.n_dofs), np.zeros(master.n_dofs)),
        friction=_friction(mu, forces, weights, tangential[facing], slip[facing]),
    )  # fmt: skip


def _friction(mu: float, forces: Array, weights: Array, tangential: Array, slip: Array) -> FrictionFields | None:
    """Fields of friction at the points of a contact; None without."""
    if not mu:
        return None
    touching = forces > 0
    held = sticks(np.linalg.norm(tangential, axis=1)[None], friction_limit(np.full(len(forces), mu), forces))
    return FrictionFields(
        mu=mu, forces=tangential, weights=weights, slip=slip, touching=touching,
        sliding=touching & ~held, moved=slip, resultants=tangential,
        couples=np.zeros_like(tangential), mu_along_slip=np.full(len(forces), mu),
    )  # fmt: skip
