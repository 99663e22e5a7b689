"""Check for contacts that reach the rim of a surface."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fecontact.bodies.protocol import Body
from fecontact.bodies.rims import Rim, ends_near, rim_of_surface
from fecontact.common.arrays import Array, Mask
from fecontact.contact.interface import Interface
from fecontact.results.contact_fields import ContactFields
from fecontact.results.solved_scene import SolvedScene
from fecontact.surfaces.facet_surface import FacetSurface, has_cells

#: Share of a contact's force within one face of the rim above which a result warns.
LEAST_AT_RIM = 0.005
#: Distance from its own rim, relative to a face, at which a node counts as on it.
ON_RIM = 1e-3


def node_sizes(surface: FacetSurface) -> Array:
    """Mean size (n_nodes,) of the facets round each node; zero off the surface."""
    k = surface.facets.shape[1]
    total = np.bincount(surface.facets.ravel(), np.repeat(surface.mean_facet_size, k), len(surface.points))
    count = np.bincount(surface.facets.ravel(), minlength=len(surface.points))
    return total / np.maximum(count, 1)


def contact_at_rims(result: SolvedScene) -> Iterator[str]:
    """Warnings of contacts that reach a rim beyond which the body continues."""
    for contact, interface in zip(result.contacts, result.interfaces, strict=True):
        if contact.active.any():
            yield from _at_rims(contact, interface)


def _at_rims(contact: ContactFields, interface: Interface) -> Iterator[str]:
    """Force of one contact within one face of the slave's rim and of the master's."""
    slave, master, names = interface.slave, interface.master, interface.surfaces
    active = np.flatnonzero(contact.active)
    surface, pairing = interface.slave_surface, interface.pairing
    size = surface.once(node_sizes)[pairing.nodes[active]]
    spacing = size if surface.facets.shape[1] == 4 else size / 2
    lines = contact.normals[active]
    length = np.linalg.norm(lines, axis=1, keepdims=True)
    # the radial forces of a ring have no resultant
    lines = np.divide(lines, length, out=np.zeros_like(lines), where=length > 0)
    projection = master.pose.to_body(contact.points[active] - pairing.gap[active, None] * lines)
    ours = _Near.of(slave, names[0], pairing.slave_points[active], size, ON_RIM * size)
    theirs = _Near.of(master, names[1], projection, size, spacing)
    if master.is_rigid:
        theirs = _near_rigid_end(master, names[1], projection, lines @ master.pose.rotation, size, spacing)
    forces = contact.forces[active]
    for body, name, mine, other in ((slave, names[0], ours, theirs), (master, names[1], theirs, ours)):
        cut_off = mine.smooth & ~other.sharp
        share = float(forces[cut_off].sum() / forces.sum())
        if share > LEAST_AT_RIM and (mine.reached & cut_off).any():
            yield _sentence(contact, body, name, share)


def _sentence(contact: ContactFields, body: Body, name: str, share: float) -> str:
    beyond, remedy = "the body goes on", "Declare a larger contact boundary"
    if has_cells(body.surface(name)):
        beyond, remedy = "the half-space goes on", "Take a larger grid"
    elif body.is_rigid:
        beyond, remedy = "nothing is known of the body", "Take a larger surface"
    return (
        f"{100 * share:.3g} % of the force between {contact.slave.name!r} and {contact.master.name!r} acts "
        f"within one face of the rim of {name!r} of {body.name!r}, beyond which {beyond}: the contact is cut off "
        f"there, its area too small and its pressures too high. {remedy}."
    )


class _Near:
    """Points (n,) within a face of a rim where the body continues or ends, and those on it."""

    def __init__(self, smooth: Mask, sharp: Mask, reached: Mask) -> None:
        self.smooth, self.sharp, self.reached = smooth, sharp, reached

    @classmethod
    def of(cls, body: Body, name: str, points: Array, size: Array, touching: Array) -> _Near:
        """From points (n, 3) in the body's axes, the size (n,) of their faces and a contact distance."""
        rim: Rim | None = rim_of_surface(body, name)
        none = np.zeros(len(points), bool)
        if rim is None:
            return cls(none, none, none)
        every = np.ones(len(rim.size), bool)
        if not rim.within(points, size, every, 1.0).any():
            return cls(none, none, none)
        smooth, sharp = rim.within(points, size, rim.smooth, 1.0), rim.within(points, size, ~rim.smooth, 1.0)
        return cls(smooth, sharp, rim.within(points, touching, rim.smooth))


def _near_rigid_end(body: Body, name: str, points: Array, normals: Array, size: Array, touching: Array) -> _Near:
    """The same for a rigid surface: measured maps and open facets continue beyond their rim, shapes do not."""
    near = ends_near(body, name, points, normals, size)
    none = np.zeros(len(points), bool)
    if body.is_cut_off:
        return _Near(near, none, near & ends_near(body, name, points, normals, touching))
    return _Near(none, near, none)
