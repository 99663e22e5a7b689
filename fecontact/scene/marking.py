"""Faces of a contact to divide: those at its edge, those with most of the error, and those under the peak.

With the first two kinds only, the L2 error falls while the peak error stays at some percent; hence the third. Most of
the error means a fixed share of its square (W. Dörfler, SIAM J. Numer. Anal. 33, 1996).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.interface import Interface
from fecontact.mesh.facets import facet_centres
from fecontact.results.contact_fields import ContactFields
from fecontact.surfaces.facet_surface import facets_of, with_nodes

#: Largest share of the squared error in the faces marked by their indicators.
BULK = 0.8
#: Difference of squared errors, relative to them, by rounding and by the solver's tolerance.
EQUAL = 1e-6
#: Error of a divided face over its error before, and the share of the tolerance that the last division aims at.
HALVED, AIM = 0.5, 0.9
#: Error by the elements below a contact, over the tolerance, above which some of them are divided.
WORTH = 0.5
#: Size of a master's face, relative to that of the slave's faces it meets, above which it is divided with them.
COARSE = 0.75


def marked_facets(contact: ContactFields, tolerance: float) -> Mask:
    """Mask (n_facets,) of the slave's faces in `contact.facets` to divide.

    Parameters
    ----------
    contact : ContactFields
    tolerance : float
        Target error of the pressure, of its peak, and of the tractions of friction. Where it is nearly met, fewer
        faces are marked: those at the edge
        without much of the error are left out.
    """
    read = contact.readings
    assert read is not None
    active = (contact.at_nodes @ contact.pressure > 0)[contact.facets]
    share = _share(contact.error_estimate.pressure, tolerance)
    out = active.any(axis=1) & ~active.all(axis=1) & (share >= BULK)
    out[read.facets[_most(read.misfit, share)]] = True
    unseen = contact.between_nodes.unseen[contact.facet_numbers]
    out |= unseen > tolerance * np.sqrt((contact.pressure**2 @ contact.weights) / contact.point_area)
    sideways = _share(contact.error_estimate.traction or 0.0, tolerance)
    if contact.traction_misfit is not None and sideways > 0:
        out[read.facets[_most(contact.traction_misfit[0], sideways)]] = True
    if contact.error_estimate.peak <= AIM * tolerance:
        return out
    off = np.abs(read.smooth - read.interpolated).max(axis=1) > tolerance * contact.max_pressure
    out[read.facets[off & active[read.facets].all(axis=1)]] = True
    return out


def _share(error: float, tolerance: float) -> float:
    """Share of the squared error in what is divided that brings an estimate to the tolerance in one division."""
    over = error / (AIM * tolerance)
    return float((1 - over**-2) / (1 - HALVED**2)) if over > 1 else 0.0


def _most(squares: Array, share: float) -> IntArray:
    """Numbers of those with the largest squared errors, up to a share of all, `BULK` at most."""
    largest = -np.sort(-squares)
    held = np.cumsum(largest)
    least = largest[min(int(np.searchsorted(held, min(share, BULK) * held[-1])), len(held) - 1)]
    # with those that differ by rounding only, such as mirror images
    return np.flatnonzero((squares >= (1 - EQUAL) * least) & (squares > 0))


def marked_cells(contact: ContactFields, tolerance: float) -> tuple[IntArray, IntArray]:
    """Cells of slave and master below the contact to divide besides those at its faces.

    Those with most of the squared error in the energy norm, if the elements below keep the estimate above the
    tolerance whatever the faces are; fewer where it is nearly met.
    """
    if contact.error_estimate.interior < WORTH * tolerance:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    error = np.concatenate([e.error for e in contact.energy_errors])
    chosen = np.zeros(len(error), bool)
    chosen[_most(error, _share(contact.error_estimate.pressure, tolerance))] = True
    ours, theirs = contact.energy_errors
    return ours.cells[chosen[: len(ours.cells)]], theirs.cells[chosen[len(ours.cells) :]]


def marked_by_response(parts: Sequence[Array], over: float) -> list[IntArray]:
    """Cells of each body to divide by their parts in an error of forces or motions, which is so much too large.

    Halving a cell quarters its part at least: errors of forces are squares of errors of strains.
    """
    sizes = np.abs(np.concatenate(parts))
    chosen = np.zeros(len(sizes), bool)
    chosen[_most(sizes, (1 - AIM / over) / (1 - HALVED**2))] = True
    return [np.flatnonzero(c) for c in np.split(chosen, np.cumsum([len(p) for p in parts])[:-1])]


def parts_of(facets: IntArray, body: Body, finer: Body, name: str) -> IntArray:
    """Facets of a body on a finer mesh that lie in given facets of the body itself."""
    old, new = facets_of(body.surface(name)), facets_of(finer.surface(name))
    assert old is not None
    assert new is not None
    centres = new.evaluate(np.arange(len(new.facets)), facet_centres(new.triangle))[0]
    found = old.project(centres).facet
    assert found is not None
    return np.flatnonzero(np.isin(found, facets))


def edge_points(contact: ContactFields) -> Array:
    """Points (n, 3) along the edge of a contact, in world axes; none where it ends with its surfaces."""
    return np.concatenate([curve.points[curve.is_edge] for curve in contact.outline.curves] or [np.zeros((0, 3))])


def facets_at(points: Array, body: Body, name: str) -> IntArray:
    """Facets of a body that points (n, 3), in its axes, lie on."""
    surface = facets_of(body.surface(name))
    assert surface is not None
    if not len(points):
        return np.zeros(0, np.int64)
    found = surface.project(points).facet
    assert found is not None
    return np.unique(found)


def divided_to(body: Body, name: str, points: Array, size: float) -> Body:
    """The body with its facets at points (n, 3), in its axes, divided until none there is larger than a size."""
    while True:
        surface, facets = with_nodes(body.surface(name)), facets_at(points, body, name)
        wide = facets[surface.mean_facet_size[facets] > size]
        finer = body.divided({name: wide}) if len(wide) else body
        if finer is body:
            return body
        body = finer


def facets_opposite(interface: Interface, facets: IntArray) -> IntArray:
    """Facets of the master opposite facets of the slave and not much smaller; none for a surface without facets."""
    slave, master = interface.slave_surface, facets_of(interface.master.surface(interface.surfaces[1]))
    if master is None or master.cell_area is not None or not len(facets):
        return np.zeros(0, np.int64)
    relative = interface.slave.pose.relative_to(interface.master.pose)
    chosen = slave.facets[facets]
    centres = slave.evaluate(facets, facet_centres(slave.triangle[facets]))[0]
    nodes = slave.points[np.where(chosen < 0, chosen[:, :1], chosen)]
    # the middle of the face, and points halfway to its nodes: cells that touch what is found are divided too
    points = np.concatenate([centres[:, None], 0.5 * nodes + 0.5 * centres[:, None]], axis=1)
    places = points.reshape(-1, 3) @ relative.rotation.T + relative.translation
    found = master.project(places).facet
    assert found is not None
    size = np.repeat(slave.mean_facet_size[facets], points.shape[1])
    return np.unique(found[master.mean_facet_size[found] > COARSE * size])
