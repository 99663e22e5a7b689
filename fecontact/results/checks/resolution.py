"""Checks of the resolution of a contact: remaining overlaps, errors of pressures, chords of round faces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.error_estimate import percent
from fecontact.contact.coupling.facing import STEEPEST, opposition
from fecontact.contact.search.region import with_rings
from fecontact.mesh.facets import facet_centres
from fecontact.mesh.pick import shared_sides
from fecontact.results.checks.rims import node_sizes
from fecontact.results.solved_scene import SolvedScene
from fecontact.surfaces.facet_surface import FacetSurface

#: Overlap of nodes, relative to the sum of elastic displacement and overlap, above which a result warns, and relative
#: to a face, below which it is rounding.
LEAST_OVERLAP, ROUNDING = 0.2, 1e-4
#: Estimated error of the pressure above which a result warns.
LARGEST_ERROR = 0.1
#: Distance of faces from the round shape they represent, relative to the elastic displacement, above which a note is
#: given.
LEAST_CHORD = 0.15
#: Cosine of the angle between neighbouring faces below which they form an edge.
EDGE = np.cos(np.radians(40.0))


class _Side(NamedTuple):
    """One elastic side of a contact, in its own axes: its surface, deformed, and elastic displacements of its nodes."""

    body: Body
    before: FacetSurface
    after: FacetSurface
    elastic: Array


def _side(result: SolvedScene, body: Body, name: str) -> _Side | None:
    for elastic in elastic_among([body]):
        return _elastic_side(result, elastic, name)
    return None


def _elastic_side(result: SolvedScene, body: ElasticBody, name: str) -> _Side:
    surface = body.surface(name)
    k = next(k for k, b in enumerate(result.scene.bodies) if b is body)
    u, frame = result.state.displacements[k], result.loading.frames[k]
    rest = body.at_points(u - frame.modes(result.state.motions[k][:, None])[:, 0])
    return _Side(body, surface, replace(surface, points=surface.points + body.at_points(u)), rest)


def overlap_left(result: SolvedScene) -> Iterator[str]:
    """Warnings of contacts with nodes inside the other body although the gaps of the problem are open."""
    for contact, interface in zip(result.contacts, result.interfaces, strict=True):
        slave = _side(result, interface.slave, interface.surfaces[0])
        master = _side(result, interface.master, interface.surfaces[1])
        if slave is None or master is None:
            continue
        ours = interface.pairing.nodes[contact.candidates]
        one, elastic, size, facets = _deepest(slave, master, np.asarray(np.isin(slave.before.facets, ours).any(axis=1)))
        other, yielded, _, _ = _deepest(master, slave, facets)
        depth, given = max(one, other), elastic + yielded
        if depth > LEAST_OVERLAP * (depth + given) and depth > ROUNDING * size:
            points = int(contact.active.sum())
            carry = "no point" if points == 0 else "1 point" if points == 1 else f"{points} points"
            carry += " of the contact between them " + ("carries" if points < 2 else "carry")
            yield (
                f"Nodes of {contact.slave.name!r} and {contact.master.name!r} overlap by {depth:.3g}, "
                f"{depth / size:.2g} of a face and {100 * depth / (depth + given):.0f} % of the approach, "
                f"and {carry} force: their faces are too coarse for this contact. Refine them there."
            )


def _deepest(one: _Side, other: _Side, chosen: Mask) -> tuple[float, float, float, Mask]:
    """Depth to which nodes of chosen facets of one side, and of their neighbours, lie in the other.

    Returns
    -------
    depth, elastic, size : float
        The largest depth and elastic displacement, and the mean size of the faces.
    facets : (n_facets,) bool array
        Facets of the other side with the closest points.
    """
    surface = one.after
    nodes = np.unique(surface.facets[with_rings(surface, chosen, 1)])
    touched = np.zeros(len(other.after.facets), bool)
    if len(nodes) == 0:
        return 0.0, 0.0, 1.0, touched
    relative = one.body.pose.relative_to(other.body.pose)
    projection = other.after.project(surface.points[nodes] @ relative.rotation.T + relative.translation)
    assert projection.facet is not None
    touched[projection.facet] = True
    facing = opposition(surface, nodes, projection.normals @ relative.rotation) >= STEEPEST
    depth = np.where(projection.outside | ~facing, 0.0, -projection.gap).max(initial=0.0)
    elastic = np.linalg.norm(one.elastic[nodes], axis=1).max()
    return float(depth), float(elastic), float(node_sizes(surface)[nodes].mean()), touched


def coarse_pressures(result: SolvedScene) -> Iterator[str]:
    """Warnings of contacts whose estimated pressure error exceeds `LARGEST_ERROR`."""
    for contact in result.contacts:
        # a contact that fills its faces is as wide as they are, and not sought
        if not contact.active.any() or contact.active.all():
            continue
        between = f"{contact.slave.name!r} and {contact.master.name!r}"
        number = int(contact.active.sum())
        estimate = contact.error_estimate
        if number <= 3:
            yield (
                f"The contact of {between} is carried by {number} {'point' if number == 1 else 'points'} only: forces "
                "and approach may be off by tens of percent, pressures more. Refine the faces there."
            )
        elif estimate.pressure > LARGEST_ERROR:
            yield (
                f"The pressure between {between} may be off by about {percent(estimate.pressure)} in the mean and "
                f"{percent(estimate.peak)} at its peak: {estimate.faces_across:.2g} faces across resolve it. Refine "
                "the faces there."
            )


def chords(result: SolvedScene) -> Iterator[str]:
    """Notes of contacts of round faces whose chord error is comparable to the elastic displacement."""
    for contact, interface in zip(result.contacts, result.interfaces, strict=True):
        if not contact.active.any() or interface.note.startswith("faces match or nest"):
            continue
        chord, given = 0.0, 0.0
        nodes = interface.pairing.nodes[contact.active]
        for body, name in zip((interface.slave, interface.master), interface.surfaces, strict=True):
            side = _side(result, body, name)
            if side is None:
                continue
            if body is interface.slave:
                touched: Mask = np.asarray(np.isin(side.before.facets, nodes).any(axis=1))
            else:
                relative = interface.slave.pose.relative_to(body.pose)
                points = interface.pairing.slave_points[contact.active] @ relative.rotation.T + relative.translation
                touched = np.zeros(len(side.before.facets), bool)
                touched[side.before.project(points).facet] = True
            chord += _chord(side.before, touched)
            given += float(np.linalg.norm(side.elastic[np.unique(side.before.facets[touched])], axis=1).max())
        if chord > LEAST_CHORD * given:
            yield (
                f"Faces of {contact.slave.name!r} and {contact.master.name!r} depart from the round shapes they stand "
                f"for by about {chord:.2g}, {100 * chord / given:.0f} % of the elastic displacement there: pressures "
                "may vary by as much about their mean. Take finer faces, or quadratic ones."
            )


def _chord(surface: FacetSurface, chosen: Mask) -> float:
    """Mean over chosen facets of their distance from a round shape through their sides."""
    return float(surface.once(_sagittas)[chosen].mean())


def _sagittas(surface: FacetSurface) -> Array:
    """Distance (n_facets,) of each facet from its arc: step to a neighbour times the angle between them over 8.

    The largest over the sides counts; edges are ignored.
    """
    if surface.out_of_plane is not None:
        a, b, cosine = _shared_ends(surface)
    else:
        a, b, cosine = shared_sides(surface.points, surface.facets, surface.hanging)
        a, b = a // 4, b // 4
    centres = surface.evaluate(np.arange(len(surface.facets)), facet_centres(surface.triangle))[0]
    angle = np.where(cosine >= EDGE, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    sagitta = np.linalg.norm(centres[a] - centres[b], axis=1) * angle / 8
    out = np.zeros(len(surface.facets))
    np.maximum.at(out, a, sagitta)
    np.maximum.at(out, b, sagitta)
    return out


def _shared_ends(surface: FacetSurface) -> tuple[IntArray, IntArray, Array]:
    """Pairs of adjacent sides, and the cosine between their tangents there."""
    order = np.argsort(surface.facets[:, 0])
    place = np.searchsorted(surface.facets[order, 0], surface.facets[:, 1])
    place = np.minimum(place, len(order) - 1)
    a = np.flatnonzero(surface.facets[order[place], 0] == surface.facets[:, 1])
    b = order[place[a]]
    ends = [np.tile([s, 0.5], (len(a), 1)) for s in (1.0, 0.0)]
    return a, b, np.einsum("ni,ni->n", surface.normals(a, ends[0]), surface.normals(b, ends[1]))
