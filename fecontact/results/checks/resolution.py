"""Checks of the resolution of a contact: remaining overlaps, errors of pressures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, Mask
from fecontact.common.error_estimate import LARGEST_ERROR, ErrorEstimate, percent
from fecontact.contact.coupling.surface_pair import STEEPEST, opposition
from fecontact.contact.search.region import with_rings
from fecontact.results.checks.rims import node_sizes
from fecontact.results.contact_fields import ContactFields
from fecontact.results.solved_scene import SolvedScene
from fecontact.surfaces.facet_surface import FacetSurface, has_cells

#: Overlap of nodes, relative to the sum of elastic displacement and overlap, above which a result warns, and relative
#: to a face, below which it is rounding.
LEAST_OVERLAP, ROUNDING = 0.2, 1e-4
#: Excess of a second moment above which a result warns.
LARGEST_EXCESS = 0.01


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


def overlap_between_nodes(result: SolvedScene) -> Iterator[str]:
    """Warnings of faces that the other body reaches between their nodes, none of which carries force."""
    for contact in result.contacts:
        if (found := contact.between_nodes.overlap) is not None:
            place = ", ".join(f"{x:.4g}" for x in contact.slave.pose.to_world(found.points[:1])[0])
            nodes, faces = ("cells", "cells") if has_cells(contact.surface) else ("nodes of a face", "faces")
            yield (
                f"{contact.slave.name!r} and {contact.master.name!r} overlap by {found.depth:.3g} at ({place}), "
                f"between {nodes} of {contact.slave.name!r} that carry no force: Hertz's formulas give about "
                f"{found.force:.2g} for it. The overlap is {found.width:.2g} wide: make {faces} there a third of it"
                f"{_remedy(result, contact)}."
            )


def _remedy(result: SolvedScene, contact: ContactFields) -> str:
    meshed = any(body is b for b in result.elastic_bodies for body in (contact.slave, contact.master))
    return " or solve with accuracy=0.05" if meshed else ""


def coarse_pressures(result: SolvedScene) -> Iterator[str]:
    """Warnings of contacts not resolved, or whose pressure, peak or area may be off by more than `LARGEST_ERROR`."""
    for contact in result.contacts:
        if not contact.active.any():
            continue
        between = f"{contact.slave.name!r} and {contact.master.name!r}"
        number = int(contact.active.sum())
        estimate = contact.error_estimate
        remedy = _remedy(result, contact)
        # a contact that fills its faces is as wide as they are
        if number <= 3 and not contact.active.all():
            yield (
                f"The contact of {between} is carried by {number} {'point' if number == 1 else 'points'} only: its "
                "peak and area are not resolved, forces and approach may be off by tens of percent. Refine the faces "
                f"there{remedy}."
            )
        elif not estimate.resolved:
            yield (
                f"The contact of {between} is {estimate.faces_across:.2g} faces across: its peak and area are not "
                f"resolved, and its pressure may be off by about {estimate.amount}. Refine the faces there{remedy}."
            )
        elif estimate.largest > LARGEST_ERROR:
            cause = (
                f"the shape of {contact.master.name!r} varies between the nodes. Refine the faces there{remedy}."
                if contact.unseen**2 > estimate.pressure**2 / 2
                else _cause(estimate, remedy)
            )
            yield f"The pressure between {between} may be off by about {estimate.amount}: {cause}"
        elif estimate.worst > LARGEST_ERROR:
            yield (
                f"The tractions of friction between {between} may be off by about {percent(estimate.worst)} in the "
                "mean, most at the edge of what sticks. Refine the faces there or solve the path with accuracy=0.05."
            )


def _cause(estimate: ErrorEstimate, remedy: str) -> str:
    """Origin of the largest part of the error, and what reduces it."""
    half = estimate.pressure**2 / 2
    if estimate.geometry**2 > half:
        return (
            "the faces deviate from the round shape they represent, and pressures follow their kinks. Mesh the shape "
            "again with finer or quadratic faces; dividing the present ones does not help."
        )
    if estimate.interior**2 > half:
        return (
            "the elements below the contact are too coarse. Refine them as deep as the contact is wide, several "
            "through a thin layer, or use quadratic ones."
        )
    return f"it is resolved by {estimate.faces_across:.2g} faces across. Refine the faces there{remedy}."


def springs_at_nodes(result: SolvedScene) -> Iterator[str]:
    """Warnings of layers of springs covered up to their rim, whose moments are those of springs at the nodes.

    The second moment of n linear faces by the trapezoidal rule is 1 + 2 / n^2 of the true one, by Simpson's rule, that
    of quadratic faces, it is exact.
    """
    for contact in result.contacts:
        if not contact.slave.is_foundation or not contact.active.all() or contact.facets.shape[1] != 4:
            continue
        # the faces across count an ellipse of as many faces as the rectangle has
        excess = 8 / (np.pi * contact.error_estimate.faces_across**2)
        if excess > LARGEST_EXCESS:
            yield (
                f"The springs of {contact.slave.name!r} stand at its nodes, and it is covered up to its rim: its "
                f"resistance to tilt may be {percent(excess)} too large. Give it quadratic faces, by "
                "mesh.upgraded(20), which are exact, or more faces."
            )
