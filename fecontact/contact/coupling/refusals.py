"""Refusal of contacts whose surfaces do not face each other, or meet on a line, a point or a sliver only."""

from __future__ import annotations

import numpy as np

from fecontact.common.errors import InputError
from fecontact.contact.coupling.facing import TIE, Averted
from fecontact.contact.coupling.mortar import multiplier_areas
from fecontact.contact.coupling.surface_pair import SurfacePair
from fecontact.contact.interface import Interface
from fecontact.surfaces.facet_surface import FacetSurface, facets_of
from fecontact.surfaces.nodal_weights import contact_weights

#: Least share of the faces that lies over the other body: less is due to rounding and chords of curved sides on bodies
#: that meet on a line.
LEAST_SHARE = 1e-3


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
    if np.isfinite(found.gap) and (empty or found.gap < found.facing - TIE * surface.size):
        nearest = "where they are nearest " if np.isfinite(found.facing) else ""
        raise InputError(
            f"The surfaces {one} and {other} do not face each other: {nearest}their outward normals are "
            f"{found.angle:.0f} degrees apart; expected about 180. Check the poses, and name as contact the boundaries "
            "that face each other."
        )
    if empty and found.facing == np.inf:
        raise InputError(
            f"The surfaces {one} and {other} do not face each other: no point of the one projects on the other. "
            "Check the poses and which boundaries are named, or refine faces that are wider than the other surface."
        )
    share = 0.0 if empty else _covered_share(interface, surface)
    if share < LEAST_SHARE:
        raise InputError(
            f"The surfaces {one} and {other} meet on a line, a point or a sliver only: the area in which they face "
            f"each other is {pairing.weights.sum():.3g}, {share:.1e} of the faces there; expected "
            f"{LEAST_SHARE:g} or more. Check the poses and which boundaries are named, or refine the faces there."
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
