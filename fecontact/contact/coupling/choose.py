"""Coupling of a contact: choice of the slave, nodal forces or mortar, and the parts to pair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError
from fecontact.contact.contact import Contact
from fecontact.contact.coupling.grid import pair_cells
from fecontact.contact.coupling.mortar import pair_mortar
from fecontact.contact.coupling.mortar_basis import has_mortar_basis
from fecontact.contact.coupling.nodal import Pairing, nested, pair
from fecontact.contact.coupling.refusals import check_faced
from fecontact.contact.dimension import check_rigid_surface
from fecontact.contact.interface import Interface
from fecontact.contact.search.radius import SearchRadius, plain_facets
from fecontact.contact.search.region import SearchRegion, search_region
from fecontact.surfaces.facet_surface import FacetSurface, Surface, facets_of, has_cells
from fecontact.surfaces.nodal_weights import contact_weights

#: Note on a contact whose slave faces each lie within one of the master's.
NESTED = "faces match or nest, nodal forces"
#: Ratio of face sizes above which one side counts as coarser.
COARSER = 1.1
#: Ratio of a half-space's cells to an elastic body's faces below which the cells may be the slave: their pressure
#: oscillates by some percent when a face holds only a few of them (see docs/half-space.md).
FINEST_CELLS = 0.25


def build_interface(contact: Contact, search_radius: SearchRadius | None = None) -> Interface:
    """Pair a contact; the side that has nodes, if only one has, is the slave.

    With a search radius, only the parts of two elastic bodies' facets that may touch within it are paired.
    """
    assert contact.surfaces is not None
    slave, master, names = contact.slave, contact.master, contact.surfaces
    note = ""
    if facets_of(slave.surface(names[0])) is None:
        slave, master, names = master, slave, names[::-1]
        note = f"{slave.name!r} has the nodes and was made the slave"
    elif contact.coupling == "mortar" and _spreads_on_cells(slave.surface(names[0]), master.surface(names[1])):
        slave, master, names = master, slave, names[::-1]
        note = f"the forces of {slave.name!r} are spread over the half-space's cells, mortar"
    if search_radius is not None and slave is not contact.slave:
        search_radius = search_radius.turned_over()
    surface, other = _slave_surface(slave, master, names), master.surface(names[1])
    if surface.out_of_plane is not None and facets_of(other) is None:
        points = slave.pose.to_world(surface.points[surface.nodes])
        check_rigid_surface(master, other, points, surface.out_of_plane)
    ring, whole = surface.revolved and contact.coupling == "auto", surface.mortar_on_quad8
    if whole and contact.coupling == "nodal":
        raise InputError(
            f"{slave.name!r} has gradient coordinates, and forces on the nodes of its faces would leave the gradients "
            "out: use coupling='auto' or 'mortar', or make the other body the slave."
        )
    coupling = "mortar" if contact.coupling == "mortar" or ring or whole else "nodal"
    interface = _made(slave, master, names, coupling, note, search_radius)
    if not len(interface.pairing.nodes) and contact.coupling == "auto" and _can_mortar(surface, other):
        # nodes of faces larger than the master may all lie outside it
        interface = _made(slave, master, names, "mortar", note, search_radius)
    check_faced(interface)
    return interface


def _slave_surface(slave: Body, master: Body, names: tuple[str, str]) -> FacetSurface:
    surface = facets_of(slave.surface(names[0]))
    if surface is None:
        raise InputError(f"Neither {slave.name!r} nor {master.name!r} is elastic: one body of a contact must deform.")
    return surface


def _can_mortar(slave: FacetSurface, master: Surface) -> bool:
    """Whether mortar coupling of two surfaces of facets is possible."""
    other = facets_of(master)
    return other is not None and slave.cell_area is None and other.cell_area is None and has_mortar_basis(slave)


def region_of(
    slave: Body, master: Body, names: tuple[str, str], coupling: str, search_radius: SearchRadius | None
) -> SearchRegion | None:
    """Parts of both surfaces within the search radius; None to pair whole surfaces."""
    surfaces = None if search_radius is None else plain_facets((slave, master), names)
    if surfaces is None:
        return None
    assert search_radius is not None
    relative = slave.pose.relative_to(master.pose)
    one, other = surfaces
    rotation, translation = relative.rotation, relative.translation
    if coupling == "mortar" and search_radius.increment is not None:
        near = search_region(
            one, other, rotation, translation, search_radius.elastic, search_radius.increment_in(master.pose)
        )
    else:
        near = search_region(one, other, rotation, translation, search_radius.distance)
    return near if near.nodes.any() else None


def _made(
    slave: Body, master: Body, names: tuple[str, str], coupling: str, note: str, search_radius: SearchRadius | None
) -> Interface:
    near = region_of(slave, master, names, coupling, search_radius)
    return Interface(slave, master, names, _paired(slave, master, names, coupling, near), note, near, search_radius)


def choose_coupling(interface: Interface, near: IntArray, contact: Contact) -> Interface:
    """Nodal forces where they are exact; elsewhere mortar coupling, with the sides swapped where that is better."""
    slave, master, names, pairing = interface.slave, interface.master, interface.surfaces, interface.pairing
    s, m = facets_of(slave.surface(names[0])), facets_of(master.surface(names[1]))
    if contact.coupling == "mortar" or s is None or m is None:
        return interface
    cells_ours, cells_theirs = s.cell_area is not None, m.cell_area is not None
    grid = cells_ours or cells_theirs
    ring = pairing.coupling == "mortar"
    if not grid and not ring and nested(s, m, pairing, near):
        return replace(interface, note=NESTED)
    touched = np.isin(s.facets, pairing.nodes_at(near)).all(axis=1)
    ours = s.mean_facet_size[touched]
    projection = pairing.projection.facet[near] if not (grid or ring) and pairing.projection.facet is not None else None
    if projection is None:
        projection = m.project(pairing.slave_points[near] @ pairing.rotation.T + pairing.translation).facet
    assert projection is not None
    opposite = np.unique(projection)
    theirs = m.mean_facet_size[opposite]
    ratio = theirs.mean() / ours.mean() if len(ours) else 1.0
    swappable = contact.swap == "auto"
    if not grid and contact.coupling == "auto" and (has_mortar_basis(s) or (swappable and has_mortar_basis(m))):
        # a fine slave resolves the kinks of a coarse master and its pressure oscillates, so the coarser side is the
        # slave; a triangle has three multipliers where a quadrilateral has nine, so quadrilaterals are the slave of
        # triangles
        mine, its = bool(s.triangle[touched].any()), bool(m.triangle[opposite].any())
        better = mine if mine != its else ratio > COARSER
        swapped = swappable and has_mortar_basis(m) and (better or not has_mortar_basis(s))
        reason = "has the quadrilaterals" if mine != its else "is coarser"
        return _recoupled(interface, swapped, "mortar", _why_mortar(s), reason)
    if grid and contact.coupling == "auto" and (swappable or not cells_ours):
        cells, faces = (ours.mean(), theirs.mean()) if cells_ours else (theirs.mean(), ours.mean())
        body = m if cells_ours else s
        if has_mortar_basis(body) and FINEST_CELLS * faces < cells <= faces:
            note = "cells a little finer than the faces, whose forces are spread over them: mortar"
            return _recoupled(interface, cells_ours, "mortar", note, "is coarser")
    # nodal forces are a quadrature rule of the slave's, so the finer side is the slave
    note = "a half-space's cells take the forces of the other's nodes"
    if not grid:
        note = "faces do not match: nodal forces err by the order of the face size"
    return _recoupled(interface, swappable and ratio < 1 / COARSER, "nodal", note)


def _why_mortar(slave: FacetSurface) -> str:
    if slave.mortar_on_quad8:
        return "gradient coordinates, mortar"
    return "rings, mortar" if slave.revolved else "faces do not match, mortar"


def _recoupled(interface: Interface, swapped: bool, coupling: str, note: str, reason: str = "is finer") -> Interface:
    """The interface with another coupling, with or without swapped sides, and a note."""
    slave, master, names = interface.slave, interface.master, interface.surfaces
    search_radius = interface.search_radius
    if swapped:
        slave, master, names = master, slave, names[::-1]
        search_radius = None if search_radius is None else search_radius.turned_over()
        note += f"; {slave.name!r} {reason} and was made the slave"
    elif coupling == interface.pairing.coupling:
        return replace(interface, note=note)
    interface = _made(slave, master, names, coupling, note, search_radius)
    check_faced(interface, first=False)
    return interface


def _spreads_on_cells(slave: Surface, master: Surface) -> bool:
    """Whether a half-space is the slave of a surface whose forces can be distributed over its cells."""
    other = facets_of(master)
    return has_cells(slave) and other is not None and other.cell_area is None


def matrix_free(interface: Interface) -> bool:
    """Whether all points can be candidates: the cells of a half-space under a rigid body."""
    return has_cells(interface.slave_surface) and np.isinf(interface.master.contact_modulus)


def _share(slave: Body, master: Body) -> float:
    """Weight of the slave's normal in the lines of action, c2 / (c1 + c2), c the compliances of slave and master.

    Compliances are 1 / E* of the softest material of either body. Against a rigid body or a half-space, which is
    displaced along its normal only, that body's normal is used.
    """
    if np.isinf(master.contact_modulus) or has_cells(master.surface(master.contact[0])):
        return 0.0
    return slave.contact_modulus / (slave.contact_modulus + master.contact_modulus)


def _paired(slave: Body, master: Body, names: tuple[str, str], coupling: str, near: SearchRegion | None) -> Pairing:
    surface = _slave_surface(slave, master, names)
    relative = slave.pose.relative_to(master.pose)
    couple = pair_mortar if coupling == "mortar" or surface.mortar_on_quad8 else pair
    if surface.cell_area is not None:
        pairing = pair_cells(
            surface, surface.cell_area, master.surface(names[1]), relative.rotation, relative.translation
        )
    else:
        share = _share(slave, master)
        pairing = couple(surface, master.surface(names[1]), relative.rotation, relative.translation, near, share)
    if slave.is_foundation and pairing.coupling == "nodal":
        # the displacement of a foundation's node depends on its whole area
        pairing = replace(pairing, weights=contact_weights(surface)[pairing.nodes])
    return pairing
