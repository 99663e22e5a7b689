"""Which facets of two surfaces may touch, judged from rough gaps before anything is paired, and how far they move.

A rough gap is the offset of a facet's centre from the nearest facet of the other surface along that one's normal. It
serves to condense models onto enough nodes at once; what it misses is found when the surfaces are paired.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.protocol import Body
from fecontact.interface.candidates import MARGIN, approach_for_load
from fecontact.interface.near import bounds_of, largest_displacement, needed_clearance
from fecontact.interface.surface import FacetSurface
from fecontact.loading import Loading

if TYPE_CHECKING:
    from fecontact.result import ContactResult
    from fecontact.scene import Contact

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Rings of facets added round those that may touch: condensing again costs more than a few nodes in excess.
RINGS = 2
#: First reach, in estimated approaches of the bodies: both sides move, and a tilt adds to the approach.
APPROACHES = 2.0
#: By how much a reach that fell short is made larger than what turned out to be needed.
SPARE = 1.25
#: Reach in the next pose of a sweep, in displacements of both surfaces together in the last one.
FOLLOWING = 1.5


def rough_gaps(one: FacetSurface, other: FacetSurface, rotation: Array, translation: Array) -> Array:
    """Offsets (n_facets,) of one surface's facets from another; `rotation`, `translation` place it in the other's axes.

    Facets whose centre lies further aside than the nearest facet is long face nothing: infinite.
    """
    centres = bounds_of(one).centre @ rotation.T + translation
    theirs = bounds_of(other)
    _, nearest = theirs.all_centres.query(centres)
    normals = theirs.normal[nearest]
    offset = centres - theirs.centre[nearest]
    gap = np.einsum("ni,ni->n", offset, normals)
    aside = np.linalg.norm(offset - gap[:, None] * normals, axis=1)
    return np.where(aside > other.mean_facet_size[nearest] + one.mean_facet_size, np.inf, gap)


def near_nodes(bodies: Sequence[Body], surfaces: Sequence[FacetSurface], loading: Loading) -> list[IntArray]:
    """Nodes of both surfaces of a contact that may touch under a load, rings of facets round them included."""
    out = []
    poses = [b.pose for b in bodies]
    softness = sum(1 / b.contact_modulus for b in bodies)
    for k in range(2):
        one, other, relative = surfaces[k], surfaces[1 - k], poses[k].relative_to(poses[1 - k])
        gap = rough_gaps(one, other, relative.rotation, relative.translation) - _travel(bodies, loading)
        if not np.isfinite(gap).any():
            out.append(one.nodes)
            continue
        lowest = float(gap.min())
        approach = _approach(one, gap, softness, loading)
        near = np.asarray(gap - lowest <= MARGIN * approach)
        for _ in range(RINGS):
            touched = np.zeros(len(one.points), bool)
            touched[one.facets[near]] = True
            near = np.asarray(touched[one.facets].any(axis=1))
        out.append(np.unique(one.facets[near]))
    return out


def _travel(bodies: Sequence[Body], loading: Loading) -> float:
    """Largest way by which prescribed motions can bring two bodies nearer to each other."""
    return sum(
        float(np.linalg.norm(frame.moved[:3]) + np.linalg.norm(frame.moved[3:]) * frame.body.size)
        for frame in loading.frames
        if any(frame.body is b for b in bodies)
    )


def _approach(surface: FacetSurface, gap: Array, softness: float, loading: Loading) -> float:
    """Estimate of the rigid approach from rough gaps (n_facets,), from first touch; overlaps count as approach."""
    facing = np.isfinite(gap)
    lowest = float(gap.min())
    approach = max(0.0, -lowest)
    if loading.magnitude > 0 and softness > 0:
        areas = surface.mean_facet_size[facing] ** 2
        approach = max(approach, approach_for_load(gap[facing] - lowest, areas, 1 / softness, loading.magnitude))
    return approach


def first_reach(contact: Contact, loading: Loading) -> float | None:
    """Distance up to which a contact's surfaces are worth pairing; None where that cannot be told beforehand.

    A guess: `wider_reaches` finds afterwards whether it was enough.
    """
    assert contact.surfaces is not None
    bodies = (contact.slave, contact.master)
    surfaces = [b.surface(name) for b, name in zip(bodies, contact.surfaces, strict=True)]
    one, other = surfaces
    if not all(isinstance(b, ElasticBody) for b in bodies) or type(one) is not FacetSurface:
        return None
    if type(other) is not FacetSurface or one.eight_hats or other.eight_hats:
        return None
    relative = bodies[0].pose.relative_to(bodies[1].pose)
    gap = rough_gaps(one, other, relative.rotation, relative.translation)
    if not np.isfinite(gap).any():
        return None
    travel = _travel(bodies, loading)
    softness = sum(1 / b.contact_modulus for b in bodies)
    estimate = APPROACHES * _approach(one, gap - travel, softness, loading)
    # a layer on a bone gives much less than a half-space: the poses before know better
    before = one.known.get("moved before")
    if isinstance(before, float):
        estimate = min(estimate, FOLLOWING * before)
    return max(0.0, float(gap.min())) + travel + estimate


def wider_reaches(result: ContactResult) -> list[float | None]:
    """Reaches of a result's contacts, wider where something that was left out could have met the other surface.

    The argument is that of `interface.near`: what was left out is clear if its distance exceeds the displacements of
    both surfaces together, those of rigid motions included.
    """
    out: list[float | None] = []
    place = {id(b): k for k, b in enumerate(result.scene.bodies)}
    for interface in result.interfaces:
        if interface.near is None or interface.reach is None:
            out.append(interface.reach)
            continue
        moves = []
        for body in (interface.slave, interface.master):
            assert isinstance(body, ElasticBody)
            assert body.model is not None
            moves.append(body.model.at_points(result.state.displacements[place[id(body)]]))
        slave = interface.slave.surface(interface.surfaces[0])
        master = interface.master.surface(interface.surfaces[1])
        assert isinstance(slave, FacetSurface)
        assert isinstance(master, FacetSurface)
        needed = needed_clearance(slave, moves[0], largest_displacement(master, moves[1]))
        short = needed >= interface.near.clearance
        for surface in (slave, master):
            surface.known["moved before"] = float(needed.max())
        widest = SPARE * float(needed.max(where=short, initial=0.0))
        out.append(max(interface.reach * SPARE, widest) if short.any() else interface.reach)
    return out
