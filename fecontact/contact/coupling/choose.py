"""How a contact is coupled: which side is the slave, nodal forces or mortar, and which parts are paired.

It is chosen by the projections of the slave's nodes alone, before anything is paired; then the contact is paired once.

Refusal of contacts whose surfaces do not face each other, or meet on a line, a point or a sliver only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fecontact.bodies.body import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.contact.candidates import likely_nodes
from fecontact.contact.contact import Contact
from fecontact.contact.coupling.mortar import multiplier_areas, pair_mortar
from fecontact.contact.coupling.mortar_basis import has_mortar_basis
from fecontact.contact.coupling.nodal import (
    NONE_AVERTED,
    STEEPEST,
    TIE,
    Averted,
    Pairing,
    SurfacePair,
    nested,
    pair,
    pair_cells,
)
from fecontact.contact.dimension import check_rigid_surface
from fecontact.contact.interface import Interface
from fecontact.contact.loads import Loading
from fecontact.contact.overclosure import SoftContact
from fecontact.contact.search_region import STILL, SearchRadius, SearchRegion, plain_facets, search_region
from fecontact.surfaces.between_nodes import samples_of
from fecontact.surfaces.facet_surface import FacetSurface, Surface, facets_of, has_cells
from fecontact.surfaces.nodal_weights import contact_weights, facet_weights

#: Least share of the faces that lies over the other body: less is due to rounding and chords of curved sides on bodies
#: that meet on a line.
MIN_SHARE = 1e-3


def check_faced(interface: Interface, seen: Averted | None = None) -> None:
    """Refuse a contact of which no part faces the other body, or where excluded parts would touch first.

    Parameters
    ----------
    interface : Interface
    seen : Averted, optional
        Of the nodes of either side, where they were looked at before the contact was paired.

    Raises
    ------
    InputError
        Gives the angle between the normals, or the share of the faces that lies over the other body.
    """
    surface, pairing = interface.slave_surface, interface.pairing
    empty = len(pairing.nodes) == 0
    found = pairing.averted if seen is None else seen
    if empty or (seen is None and pairing.coupling == "mortar" and surface.cell_area is None):
        found = _averted(interface, surface)
    one = f"{interface.surfaces[0]!r} of {interface.slave.name!r}"
    other = f"{interface.surfaces[1]!r} of {interface.master.name!r}"
    if not empty and found.gap < found.facing - TIE * surface.size:
        found = found._replace(facing=min(found.facing, _between_nodes(interface, surface)))
    if np.isfinite(found.gap) and (empty or found.gap < found.facing - TIE * surface.size):
        nearest = "where they are nearest " if np.isfinite(found.facing) else ""
        raise InputError(
            f"The surfaces {one} and {other} do not face each other: {nearest}their outward normals are "
            f"{found.angle:.0f} degrees apart; expected about 180. Check the poses, and name as contact the boundaries "
            "that face each other.",
            code="not-facing",
        )
    if empty and found.facing == np.inf:
        raise InputError(
            f"The surfaces {one} and {other} do not face each other: no point of the one projects on the other. "
            "Check the poses and which boundaries are named, or refine faces that are wider than the other surface.",
            code="not-facing",
        )
    share = 0.0 if empty else _covered_share(interface, surface)
    if share < MIN_SHARE:
        raise InputError(
            f"The surfaces {one} and {other} meet on a line, a point or a sliver only: the area in which they face "
            f"each other is {pairing.weights.sum():.3g}, {share:.1e} of the faces there; expected "
            f"{MIN_SHARE:g} or more. Check the poses and which boundaries are named, or refine the faces there.",
            code="sliver",
        )


def _covered_share(interface: Interface, surface: FacetSurface) -> float:
    """Area of overlap over that of the slave's faces there, or of the whole master if that is less."""
    pairing = interface.pairing
    if surface.cell_area is not None:
        return 1.0
    whole = multiplier_areas(surface) if pairing.coupling == "mortar" else contact_weights(surface)
    area = float(whole[pairing.nodes].sum())
    master = facets_of(interface.master.surface(interface.surfaces[1]))
    if master is not None and master.out_of_plane is None:
        area = min(area, float((master.mean_facet_size**2).sum()))
    return float(pairing.weights.sum()) / area


def _averted(interface: Interface, surface: FacetSurface) -> Averted:
    """`Averted` of the slave's nodes, for any coupling."""
    relative = interface.slave.pose.relative_to(interface.master.pose)
    master = interface.master.surface(interface.surfaces[1])
    return SurfacePair(surface, master, relative.rotation, relative.translation, interface.region).averted


def _between_nodes(interface: Interface, surface: FacetSurface) -> float:
    """Smallest gap of samples of the slave's faces that face the master: a tip may stand between the nodes."""
    relative = interface.slave.pose.relative_to(interface.master.pose)
    facet, local = samples_of(np.arange(len(surface.facets)), surface.triangle)
    x, tangents, _ = surface.evaluate(facet, local)
    normals = np.cross(tangents[:, :, 0], tangents[:, :, 1]) @ relative.rotation.T
    foot = interface.master.surface(interface.surfaces[1]).project(x @ relative.rotation.T + relative.translation)
    facing = np.einsum("ni,ni->n", normals, foot.normals) < -STEEPEST * np.linalg.norm(normals, axis=1)
    return float(foot.gap[facing & ~foot.outside].min(initial=np.inf))


#: Relative difference of sizes that counts as rounding.
EQUAL = 1e-9
#: Note on a contact whose slave faces each lie within one of the master's.
NESTED = "faces match or nest, nodal forces"
#: Note on a contact of a set of nodes.
ALONE = "nodes alone, each with its share of all faces round it"
#: Ratio of face sizes above which one side counts as coarser; ten cells beside eleven are not.
COARSER = 1.1 + EQUAL
#: Ratio of a half-space's cells to an elastic body's faces below which the cells may be the slave: their pressure
#: oscillates by some percent when a face holds only a few of them (see docs/half-space.md).
FINEST_CELLS = 0.25


#: Rings of facets paired round those within reach: the edge of a contact is located by gaps that far from it.
EDGE_RINGS = 2


@dataclass(frozen=True, eq=False)
class CouplingChoice:
    """How a contact is to be paired.

    Attributes
    ----------
    slave, master : Body
        After a possible swap.
    surfaces : (str, str)
    kind : str
        'nodal' or 'mortar'.
    note : str
        What was found about the two meshes.
    search_radius : SearchRadius, optional
        With the sides as they are here.
    friction : bool
        Whether tangential rows are needed too.
    overclosure : SoftContact, optional
    """

    slave: Body
    master: Body
    surfaces: tuple[str, str]
    kind: str = "nodal"
    note: str = ""
    search_radius: SearchRadius | None = None
    friction: bool = False
    overclosure: SoftContact | None = None

    def turned_over(self) -> CouplingChoice:
        """The same with the sides swapped."""
        radius = None if self.search_radius is None else self.search_radius.turned_over()
        return replace(self, slave=self.master, master=self.slave, surfaces=self.surfaces[::-1], search_radius=radius)

    @property
    def slave_surface(self) -> FacetSurface:
        """Facets of the slave."""
        surface = facets_of(self.slave.surface(self.surfaces[0]))
        if surface is None:
            raise InputError(
                f"Neither {self.slave.name!r} nor {self.master.name!r} is elastic: one body of a contact must deform.",
                code="none-elastic",
            )
        return surface

    @property
    def master_surface(self) -> Surface:
        """Surface of the master."""
        return self.master.surface(self.surfaces[1])

    def region(self) -> SearchRegion | None:
        """Parts of both surfaces within the search radius; None to pair whole surfaces."""
        radius = self.search_radius
        surfaces = None if radius is None else plain_facets((self.slave, self.master), self.surfaces)
        if radius is None or surfaces is None:
            return None
        relative = self.slave.pose.relative_to(self.master.pose)
        reach: float | tuple[Array, Array] = radius.distance
        increment = STILL
        if self.kind == "mortar" and radius.increment is not None:
            reach, increment = radius.elastic, radius.increment_in(self.master.pose)
            if radius.local is not None:
                reach = radius.local.here(surfaces, (self.slave.pose, self.master.pose))
        one, other = surfaces
        near = search_region(one, other, relative.rotation, relative.translation, reach, increment, EDGE_RINGS)
        return near if near.nodes.any() else None

    def surface_pair(self, region: SearchRegion | None) -> SurfacePair:
        """Both surfaces, as far as they are to be paired."""
        relative = self.slave.pose.relative_to(self.master.pose)
        share = line_share(self.slave, self.master)
        at_state = any(body._inner_forces is not None for body in (self.slave, self.master))
        return SurfacePair(
            self.slave_surface, self.master_surface, relative.rotation, relative.translation, region, share,
            self.friction or at_state,
        )  # fmt: skip


def sides(contact: Contact, search_radius: SearchRadius | None = None) -> CouplingChoice:
    """Coupling of a contact as far as its faces do not matter: the side that has nodes, if only one has, is the slave.

    With a search radius, only the parts of two elastic bodies' facets that may touch within it are paired.
    """
    assert contact.surfaces is not None
    given = CouplingChoice(
        *contact.bodies, contact.surfaces, search_radius=search_radius, friction=contact.mu > 0,
        overclosure=contact.overclosure,
    )  # fmt: skip
    surface = given.slave.surface(contact.surfaces[0])
    if facets_of(surface) is None:
        given = replace(given.turned_over(), note=f"{contact.master.name!r} has the nodes and was made the slave")
    elif contact.coupling == "mortar" and _spreads_on_cells(surface, given.master_surface):
        note = f"the forces of {contact.master.name!r} are spread over the half-space's cells, mortar"
        given = replace(given.turned_over(), note=note)
    elif _nodes_alone(given.master_surface) or (contact.swap == "always" and facets_of(given.master_surface)):
        given = given.turned_over()
    surface, other = given.slave_surface, given.master_surface
    if surface.out_of_plane is not None and facets_of(other) is None:
        points = given.slave.pose.to_world(surface.points[surface.nodes])
        check_rigid_surface(given.master, other, points, surface.out_of_plane)
    if surface.of_nodes:
        _check_nodes_alone(given, contact.coupling)
        return replace(given, note=ALONE)
    ring, whole = surface.revolved and contact.coupling == "auto", surface.mortar_on_quad8
    if whole and contact.coupling == "nodal":
        raise InputError(
            f"{given.slave.name!r} has gradient coordinates, and forces on the nodes of its faces would leave the "
            "gradients out: use coupling='auto' or 'mortar', or make the other body the slave.",
            code="gradients-left-out",
        )
    return replace(given, kind="mortar" if contact.coupling == "mortar" or ring or whole else "nodal")


def _nodes_alone(surface: Surface) -> bool:
    facets = facets_of(surface)
    return facets is not None and facets.of_nodes


def _check_nodes_alone(given: CouplingChoice, coupling: str) -> None:
    """Refuse nodes alone against others, and other couplings than by a force on each.

    Raises
    ------
    InputError
    """
    both = _nodes_alone(given.master_surface)
    if both or coupling == "mortar" or has_cells(given.master_surface):
        names = " and ".join(map(repr, given.surfaces if both else given.surfaces[:1]))
        why = "one side of a contact needs faces" if both else "a force acts on each, on a body's faces"
        raise InputError(
            f"{names}: a set of nodes, which has no faces; {why}. Leave coupling='mortar' and half-spaces to "
            "boundaries.",
            code="nodes-alone",
        )


def choose_coupling(contact: Contact, given: CouplingChoice, seen: SurfacePair, loading: Loading) -> CouplingChoice:
    """Nodal forces where they are exact; elsewhere mortar, and the sides swapped where that is better.

    Parameters
    ----------
    contact : Contact
    given : CouplingChoice
        See `sides`.
    seen : SurfacePair
        Of its slave's nodes.
    loading : Loading
        Selects the faces near the contact.
    """
    s, m = given.slave_surface, facets_of(given.master_surface)
    if contact.coupling == "mortar" or m is None or s.of_nodes:
        return given
    cells_ours, cells_theirs = s.cell_area is not None, m.cell_area is not None
    if cells_ours and cells_theirs:
        return replace(given, note="cells on cells")
    grid = cells_ours or cells_theirs
    areas = multiplier_areas(s) if given.kind == "mortar" else facet_weights(s)
    near = likely_nodes(seen, areas, (given.slave, given.master), loading)
    if not grid and given.kind == "nodal" and nested(seen, near):
        return replace(given, note=NESTED)
    touched = np.isin(s.facets, seen.nodes[near]).all(axis=1)
    assert seen.closest.facet is not None
    opposite = np.unique(seen.closest.facet[near])
    ours, theirs = (_mean(of.mean_facet_size[chosen]) for of, chosen in ((s, touched), (m, opposite)))
    ratio = theirs / ours if ours and theirs else 1.0
    swappable = contact.swap == "auto"
    if not grid and contact.coupling == "auto" and (has_mortar_basis(s) or (swappable and has_mortar_basis(m))):
        # a fine slave follows every kink of a coarse master and its pressure oscillates, so the coarser side is the
        # slave; a triangle has three multipliers where a quadrilateral has nine, so quadrilaterals are the slave. A
        # weighted gap is a mean over a face of the slave: over one wider than the contact it hides what overlaps
        mine, its = bool(s.triangle[touched].any()), bool(m.triangle[opposite].any())
        better = mine if mine != its else ratio > COARSER and _resolves(m, opposite)
        swapped = swappable and has_mortar_basis(m) and (better or not has_mortar_basis(s))
        reason = "has the quadrilaterals" if mine != its else "is coarser"
        return _chosen(given, swapped, "mortar", _why_mortar(s), reason)
    if grid and contact.coupling == "auto" and (swappable or not cells_ours):
        cells, faces = (ours, theirs) if cells_ours else (theirs, ours)
        body = m if cells_ours else s
        if has_mortar_basis(body) and (1 + EQUAL) * FINEST_CELLS * faces < cells <= (1 + EQUAL) * faces:
            note = "cells a little finer than the faces, whose forces are spread over them: mortar"
            return _chosen(given, cells_ours, "mortar", note, "is coarser")
    # nodal forces are a quadrature rule of the slave's, so the finer side is the slave
    note = "a half-space's cells take the forces of the other's nodes"
    if not grid:
        note = "faces do not match: nodal forces err by the order of the face size"
    return _chosen(given, swappable and ratio < 1 / COARSER, "nodal", note)


def _resolves(surface: FacetSurface, likely: IntArray) -> bool:
    """Whether one of the facets that are likely to touch has all its neighbours among them."""
    others = np.ones(len(surface.facets), bool)
    others[likely] = False
    rim = np.zeros(len(surface.points), bool)
    rim[surface.facets[others]] = True
    return bool((~rim[surface.facets[likely]].any(axis=1)).any())


def _mean(sizes: Array) -> float:
    """Mean size of facets; zero where there are none."""
    return float(sizes.mean()) if len(sizes) else 0.0


def _why_mortar(slave: FacetSurface) -> str:
    if slave.mortar_on_quad8:
        return "gradient coordinates, mortar"
    return "rings, mortar" if slave.revolved else "faces do not match, mortar"


def _chosen(given: CouplingChoice, swapped: bool, kind: str, note: str, reason: str = "is finer") -> CouplingChoice:
    """The coupling, its sides swapped for a reason or not, with its note."""
    if swapped:
        given, note = given.turned_over(), f"{note}; {given.master.name!r} {reason} and was made the slave"
    return replace(given, kind=kind, note=note)


def build_interface(contact: Contact, loading: Loading, search_radius: SearchRadius | None = None) -> Interface:
    """Choose the coupling of a contact and pair it once, see `sides`, `choose_coupling` and `pair_chosen`."""
    given = sides(contact, search_radius)
    if search_radius is not None and search_radius.chosen is not None:
        swapped, kind, note = search_radius.chosen
        given = given if (given.slave is not contact.slave) == swapped else given.turned_over()
        given = replace(given, kind=kind, note=note)
        return pair_chosen(given, given, given.surface_pair(given.region()), checked=True)
    seen = given.surface_pair(replace(given, kind="nodal").region())
    return pair_chosen(given, choose_coupling(contact, given, seen, loading), seen)


def pair_chosen(given: CouplingChoice, chosen: CouplingChoice, seen: SurfacePair, checked: bool = False) -> Interface:
    """Pair a contact as it was chosen by the nodes `seen` of the side that was the slave before.

    An iterate of a pose is `checked` already.

    Raises
    ------
    InputError
        If the surfaces do not face each other, or meet on a line only.
    """
    radius, swapped, mortar = chosen.search_radius, chosen.slave is not given.slave, chosen.kind == "mortar"
    surfaces = seen
    if swapped or (mortar and radius is not None and radius.increment is not None and not checked):
        surfaces = chosen.surface_pair(chosen.region())
    pairing = _paired(chosen, surfaces)
    interface = Interface(
        chosen.slave, chosen.master, chosen.surfaces, pairing, chosen.note, surfaces.region, chosen.search_radius,
        overclosure=chosen.overclosure,
    )  # fmt: skip
    if checked or any(body._deformation is not None for body in (chosen.slave, chosen.master)):
        return interface  # an iteration of a contact that was checked at rest
    check_faced(interface, (NONE_AVERTED if seen.slave.cell_area is not None else seen.averted) if mortar else None)
    return interface


def _spreads_on_cells(slave: Surface, master: Surface) -> bool:
    """Whether a half-space is the slave of a surface whose forces can be distributed over its cells."""
    other = facets_of(master)
    return has_cells(slave) and other is not None and other.cell_area is None


def matrix_free(interface: Interface) -> bool:
    """Whether all points can be candidates: the cells of a half-space under a rigid body, or each on another's cell."""
    if not has_cells(interface.slave_surface):
        return False
    if np.isinf(interface.master.contact_modulus):
        return True
    weights = interface.pairing.projection.weights
    if weights is None or not has_cells(interface.master.surface(interface.surfaces[1])):
        return False
    return bool((np.diff(weights.indptr) == 1).all())


def line_share(slave: Body, master: Body) -> float:
    """Weight of the slave's normal in the lines of action, c2 / (c1 + c2), c the compliances of slave and master.

    Compliances are 1 / E* of the softest material of either body. Against a rigid body or a half-space, which is
    displaced along its normal only, that body's normal is used.
    """
    if np.isinf(master.contact_modulus) or has_cells(master.surface(master.contact[0])):
        return 0.0
    return slave.contact_modulus / (slave.contact_modulus + master.contact_modulus)


def _paired(chosen: CouplingChoice, surfaces: SurfacePair) -> Pairing:
    surface = surfaces.slave
    if surface.cell_area is not None:
        pairing = pair_cells(surfaces, surface.cell_area)
    elif chosen.kind == "mortar":
        pairing = pair_mortar(surfaces)
    else:
        pairing = pair(surfaces)
    if chosen.slave._is_foundation and pairing.coupling == "nodal":
        # a node of a foundation gives by its whole area
        pairing = replace(pairing, weights=contact_weights(surface)[pairing.nodes])
    return pairing
