"""Local search: pair the parts that may touch, solve, check that no other part can have touched, else pair more.

The parts are predicted from a similar case, by its rigid motion and the size of its elastic displacements. The
prediction affects the time but not the solution, by the check of `fecontact.contact.search_region`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import FecontactError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.candidates import MARGIN, approach_for_load
from fecontact.contact.contact import Contact
from fecontact.contact.interface import Interface
from fecontact.contact.loads import Loading
from fecontact.contact.model import SceneModel
from fecontact.contact.search_region import (
    STILL,
    LocalReach,
    RigidIncrement,
    SearchRadius,
    bounds_of,
    find_missed,
    in_axes,
    mean_displacements,
    plain_facets,
    with_rings,
)
from fecontact.results.result import ContactResult
from fecontact.scene.linear import Settings, solved
from fecontact.surfaces.facet_surface import FacetSurface, with_nodes

#: Rings of facets added round those that may touch: a few extra nodes cost less than another condensation.
RINGS = 2


#: Initial search radius in estimated approaches of the bodies: both sides move, and a tilt adds to the approach.
APPROACHES = 2.0


#: Margin of an enlarged search radius over the one needed.
SPARE = 1.25


#: Elastic displacements allowed beyond the predicted motion in the next pose, relative to those of this one, which open
#: gaps where bodies are pressed together.
FOLLOWING = 1.0


def centroid_gaps(one: FacetSurface, other: FacetSurface, rotation: Array, translation: Array) -> Array:
    """Offsets (n_facets,) of one surface's facets from another; `rotation`, `translation` place it in the other's axes.

    Infinite for facets whose centre is offset tangentially by more than the size of the nearest facet.
    """
    centres = bounds_of(one).centre @ rotation.T + translation
    theirs = bounds_of(other)
    _, nearest = theirs.all_centres.query(centres)
    normals = theirs.normal[nearest]
    offset = centres - theirs.centre[nearest]
    gap = np.einsum("ni,ni->n", offset, normals)
    aside = np.linalg.norm(offset - gap[:, None] * normals, axis=1)
    return np.where(aside > other.mean_facet_size[nearest] + one.mean_facet_size, np.inf, gap)


def near_nodes(
    bodies: Sequence[Body], surfaces: Sequence[FacetSurface], loading: Loading, known: SearchRadius | None = None
) -> list[IntArray]:
    """Nodes of both surfaces of a contact that may touch under a load, including rings of facets round them.

    With the search radius of a similar case: those within it after its predicted motion.
    """
    out = []
    poses = [b.pose for b in bodies]
    if known is not None and known.increment is not None:
        poses[0] = poses[0].then(*_finite(known.increment))
        rings = 1
    else:
        known, rings = None, RINGS
    softness = sum(1 / b.contact_modulus for b in bodies)
    for k in range(2):
        one, other, relative = surfaces[k], surfaces[1 - k], poses[k].relative_to(poses[1 - k])
        gap = centroid_gaps(one, other, relative.rotation, relative.translation)
        if not np.isfinite(gap).any():
            out.append(one.nodes)
            continue
        if known is not None:
            near = np.asarray(gap <= known.elastic)
        else:
            gap = gap - _travel(bodies, loading)
            near = np.asarray(gap - float(gap.min()) <= MARGIN * _approach(one, gap, softness, loading))
        out.append(np.unique(one.facets[with_rings(one, near, rings)]))
    return out


def _finite(increment: RigidIncrement) -> tuple[Array, Array]:
    """Rotation (3, 3) about the world's origin and translation (3,) of a predicted motion that is not small."""
    return Rotation.from_rotvec(increment.turn).as_matrix(), increment.shift


def _travel(bodies: Sequence[Body], loading: Loading) -> float:
    """Largest distance by which prescribed motions can bring two bodies together."""
    return sum(
        float(np.linalg.norm(frame.prescribed[:3]) + np.linalg.norm(frame.prescribed[3:]) * frame.body.size)
        + (0.0 if frame.imposed is None else float(np.linalg.norm(frame.imposed.reshape(-1, 3), axis=1).max()))
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


def first_radius(contact: Contact, loading: Loading) -> SearchRadius | None:
    """Initial search radius; None if it cannot be estimated.

    `check_search_region` checks afterwards whether it sufficed.
    """
    assert contact.surfaces is not None
    bodies = contact.bodies
    surfaces = plain_facets(bodies, contact.surfaces)
    if surfaces is None:
        return None
    relative = bodies[0].pose.relative_to(bodies[1].pose)
    gap = centroid_gaps(surfaces[0], surfaces[1], relative.rotation, relative.translation)
    if not np.isfinite(gap).any():
        return None
    travel = _travel(bodies, loading)
    softness = sum(1 / b.contact_modulus for b in bodies)
    approach = APPROACHES * _approach(surfaces[0], gap - travel, softness, loading)
    distance = max(0.0, float(gap.min())) + travel + approach
    return SearchRadius(distance, distance)


def check_search_region(result: ContactResult) -> tuple[bool, list[SearchRadius | None]]:
    """Check that no omitted facet can have touched; return the radii needed.

    The radii include the margin `SPARE`; sides are as in the given contact.
    """
    enough, out = True, []
    for interface, contact in zip(result._interfaces, result.scene.contacts, strict=True):
        search_radius = interface.search_radius
        if interface.region is None or search_radius is None:
            out.append(search_radius)
            continue
        increment, elastic = _movement(result, interface)
        slave = interface.slave_surface
        master = with_nodes(interface.master.surface(interface.surfaces[1]))
        fields = mean_displacements(slave, elastic[0]), mean_displacements(master, elastic[1], whole=True)
        relative = interface.slave.pose.relative_to(interface.master.pose)
        own = in_axes(increment, interface.master.pose)
        missed, bridge = find_missed(
            interface.region, slave, master, relative.rotation, relative.translation, own, fields
        )
        enough = enough and not missed
        bounds = [np.linalg.norm(mean, axis=1) + rest for mean, rest in fields]
        points = interface.slave.pose.to_world(slave.points[slave.nodes])
        motion = float(np.linalg.norm(increment.at(points), axis=1).max() + bounds[0].max() + bounds[1].max())
        distance = max(SPARE * search_radius.distance, motion) if missed else search_radius.distance
        sides = bounds[0].reshape(len(slave.facets), -1).max(axis=1), bounds[1]
        local = LocalReach((SPARE * sides[0], SPARE * sides[1]), (interface.slave.pose, interface.master.pose))
        asked, swapped = SearchRadius(distance, SPARE * bridge, increment, local), interface.slave is not contact.slave
        chosen = swapped, interface.pairing.coupling, interface.note
        out.append(replace(asked.turned_over() if swapped else asked, chosen=chosen))
    return enough, out


def predict_radius(search_radius: SearchRadius | None, first: SearchRadius | None) -> SearchRadius | None:
    """Search radius for the next pose of a sweep, from that of the last one and an initial value.

    The coupling stays as it is where the last pose is an iterate of this one.
    """
    if search_radius is None or first is None or search_radius.increment is None:
        return first
    wider, local = FOLLOWING / SPARE, search_radius.local
    if local is not None:
        local = replace(local, sides=(wider * local.sides[0], wider * local.sides[1]))
    chosen = search_radius.chosen if search_radius.increment is STILL else None
    return SearchRadius(first.distance, wider * search_radius.elastic, search_radius.increment, local, chosen)


def _movement(result: ContactResult, interface: Interface) -> tuple[RigidIncrement, list[Array]]:
    """Rigid motion of the slave relative to the master, in world axes, and both sides' elastic displacements (n, 3)."""
    shift, turn, elastic = np.zeros(3), np.zeros(3), []
    for body, sign in zip(elastic_among((interface.slave, interface.master)), (1.0, -1.0), strict=True):
        k = next(k for k, b in enumerate(result.scene.bodies) if b is body)
        motion, frame = result._state.motions[k], result._loading.frames[k]
        elastic.append(body._at_points(result._state.displacements[k] - frame.modes(motion[:, None])[:, 0]))
        shift += sign * (motion[:3] - np.cross(motion[3:], frame.point))
        turn += sign * motion[3:]
    return RigidIncrement(shift, turn), elastic


#: Number of search radii tried before whole surfaces are paired.
MAX_REACHES = 4


@dataclass
class SearchHistory:
    """Search radii needed by the last of a series of similar cases, by contact; updated by `solve_local`."""

    search_radii: Sequence[SearchRadius | None] = ()

    def settle(self) -> None:
        """Reset the predicted motion."""
        self.search_radii = [None if r is None else replace(r, increment=STILL) for r in self.search_radii]


def solve_local(
    scene: SceneModel, loading: Loading, settings: Settings, timer: Stopwatch, history: SearchHistory | None = None
) -> ContactResult:
    """Solution with the near parts paired, or with all parts if these do not suffice.

    Parameters
    ----------
    scene : SceneModel
    loading : Loading
    settings : Settings
    timer : Stopwatch
    history : SearchHistory, optional
        History of a similar case; updated by this one.
    """
    search_radii = [first_radius(c, loading) for c in scene.contacts]
    if history is not None and history.search_radii:
        search_radii = [
            predict_radius(known, first) for known, first in zip(history.search_radii, search_radii, strict=True)
        ]
    tries = 0 if all(r is None for r in search_radii) else MAX_REACHES
    for _ in range(tries):
        try:
            result = solved(scene, loading, search_radii, settings, timer)
        except FecontactError:
            # omitted parts may carry the load; if not, whole surfaces give the error again
            break
        enough, search_radii = check_search_region(result)
        if enough:
            if history is not None:
                history.search_radii = search_radii
            return result
    return solved(scene, loading, None, settings, timer)
