"""Warnings of modelling and discretisation errors of a certified result, each with a figure and a remedy.

A check is a function of the result that yields sentences; `CHECKS` lists them. A note is for information only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.rims import Rim, ends_near, rim_of_surface
from fecontact.common.arrays import Array, Mask
from fecontact.common.error_estimate import MAX_ERROR, ErrorEstimate, percent
from fecontact.contact.coupling.nodal import STEEPEST, opposition
from fecontact.contact.interface import Interface
from fecontact.contact.search_region import with_rings
from fecontact.fem.laws import laws_of
from fecontact.fem.rigid import COMPONENTS
from fecontact.fem.support import is_plane
from fecontact.halfspace.validity import validity_warnings
from fecontact.results.contact_fields import ContactFields
from fecontact.results.convergence import accuracy_text, asked
from fecontact.results.linearisation import BEARABLE, linearisation_error
from fecontact.results.singular import ON_RIM
from fecontact.surfaces.facet_surface import FacetSurface, has_cells

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult


#: Strain above which a result warns: the relative error of small-strain elasticity is of the size of the strain.
MAX_STRAIN = 0.05
#: Motion, relative to a body's size, above which it has moved.
MIN_MOVED = 1e-9
#: Error of linearised motions above which a result warns whose poses were carried along already: nothing else mends it,
#: so that less than a percent, of the size of other errors of modelling, needs no action.
UNMENDED = 0.01
#: What errors of forces and motions do where elements are too stiff.
SIGNS = {"force": "large", "approach": "small", "tilt": "small"}


def unborne_motions(result: ContactResult) -> Iterator[str]:
    """Warnings of motions and deflections too large for linearisation."""
    error = linearisation_error(result)
    # poses take up motions of bodies, and neither deflections nor the shift of a contact by them; directions that
    # change by no more than twice the turn of a body change by its motion
    turned = error.direction <= 2 * np.sqrt(2 * error.stretch)
    carries = not result._originals and (error.deflected < 1 or turned)
    if error.worst > (BEARABLE if carries else UNMENDED) or error.friction > MAX_ERROR:
        if not np.isfinite(error.gap):
            what = "linearised motions lose or overlook the contact"
        else:
            rubbed = f", change tractions of friction by {percent(error.friction)}" if error.friction > BEARABLE else ""
            what = (
                f"linearised motions leave out {100 * error.gap / error.approach:.2g} % of the indentation in gaps and "
                f"{error.direction:.2g} rad in directions of forces{rubbed}, and stretch bodies by "
                f"{100 * error.stretch:.2g} %"
            )
        if carries:
            remedy = "Use finite_motion='auto' (or True), which carries the poses along."
        else:
            remedy = (
                "Carrying the poses along does not mend it: start nearer to the contact, hold motions that find no "
                "rest, stiffen what bends far, or use the bricks of fecontact.ancf, whose contacts follow deflections."
            )
        yield f"Bodies move or turn far: {what}. {remedy}"
    elif result._carried is not None and result._carried.rest > UNMENDED:
        yield (
            "Bodies move or turn far: the poses have not settled, and the motions would go on by "
            f"{100 * result._carried.rest:.2g} %. The load may find no rest: hold the motion, or apply less."
        )


def soft_layers(result: ContactResult) -> Iterator[str]:
    """Notes of how much soft contacts give, beside what moves."""
    most = result._state.scale
    for contact in result.contacts:
        overlap = 0.0 if contact.overclosure is None else float(np.abs(contact.overclosure).max(initial=0.0))
        if overlap > 0:
            yield (
                f"{contact.label} is soft: surfaces overlap by up to {overlap:.3g}, {100 * overlap / most:.2g} % of "
                "the largest displacement, by which hard contact (without overclosure=) would differ."
            )


def pushed_aside(result: ContactResult) -> Iterator[str]:
    """Warnings of bodies that overlap alone has moved, until nothing touched them."""
    if result._loading.magnitude or any(contact.active.any() for contact in result.contacts):
        return
    for number, (body, size) in enumerate(zip(result.scene.bodies, result.scene.sizes, strict=True)):
        given = (result._originals or result.scene.bodies)[number]
        motion = result.rigid_motion(given)
        moved = np.concatenate([motion.translation, size * motion.rotation])
        moved[list(result._loading.frames[number].prescribed_components)] = 0.0
        if (most := float(np.abs(moved).max())) > MIN_MOVED * size:
            yield (
                f"Nothing touches any more: {body.name!r} was pushed aside by what overlapped it, by {most:.2g}, as "
                "neither a support nor friction holds it. Hold that motion, if it is to be pressed."
            )


def carried_motions(result: ContactResult) -> Iterator[str]:
    """Note on what carrying the poses has changed, or on what is missing where it has not converged."""
    if (carried := result._carried) is not None:
        yield (
            f"Poses were carried along: rigid motions differ by {100 * carried.motion:.2g} % and forces of contacts by "
            f"{100 * carried.force:.2g} % from those of linearised motions (finite_motion=False); "
            f"{100 * carried.rest:.1g} % of the motions are still linearised."
        )
    elif result._originals and (error := result._linearisation) is not None and BEARABLE < error.worst <= UNMENDED:
        yield (
            f"Poses could not be carried along: linearised motions leave out {100 * error.worst:.2g} %, "
            "in gaps of the indentation, in directions of forces or in lengths."
        )


def freed_in_vain(result: ContactResult) -> Iterator[str]:
    """Notes on components that are named as free though no support holds them nor others."""
    for frame in result._loading.frames:
        if frame.freed_in_vain:
            names = " ".join(COMPONENTS[c] for c in frame.freed_in_vain)
            yield (
                f"free={{{frame.body.name!r}: {names!r}}} changes nothing: no support resists it, and other motions of "
                "this body are as free; motions= or supports= hold them."
            )


def tilts_held_by_motions(result: ContactResult) -> Iterator[str]:
    """Warnings of prescribed motions that hold tilts which the supports of their body leave free."""
    for frame in result._loading.frames:
        if frame.held_beside:
            name = frame.body.name
            names = " ".join(COMPONENTS[c] for c in frame.held_beside)
            yield (
                f"The motion of {name!r} in {names} holds what its supports leave free, such as tilts, by the mean "
                "position of the body. To move the supports alone, prescribe them: displacements={(body, boundary): "
                "(dx, dy, dz)}; to hold the tilts, give them in motions= or supports=."
            )


def unstable_bodies(result: ContactResult) -> Iterator[str]:
    """Warnings of an equilibrium at finite strain that is not stable."""
    yield from dict.fromkeys(each.unstable for each in result.finite_strain if each.unstable)


def laws_that_soften(result: ContactResult) -> Iterator[str]:
    """Warnings of laws of finite strain whose constants make them soft where they are strained."""
    for body in result._elastic_bodies:
        yield from dict.fromkeys(f"{body.name!r}: {law.caution}" for law in laws_of(body.material) if law.caution)


def parted_surfaces(result: ContactResult) -> Iterator[str]:
    """Warnings of surfaces of a contact that do not face each other any more where bodies have deformed."""
    for interface in result._interfaces if result.finite_strain else ():
        if not len(interface.gap):
            (one, other), bodies = interface.surfaces, (interface.slave.name, interface.master.name)
            yield (
                f"{one!r} of {bodies[0]!r} and {other!r} of {bodies[1]!r} do not face each other any more: the "
                "contact has no point and no force. If they touch, move the bodies less, or make a surface larger."
            )


def large_strains(result: ContactResult) -> Iterator[str]:
    """Warnings of strains too large for small-strain elasticity."""
    found = zip(result.scene.bodies, result._state.displacements, result._response_errors.primal, strict=True)
    displaced = {id(body): (u, errors) for body, u, errors in found}
    for body in result._elastic_bodies:
        if laws_of(body.material):
            continue
        u, errors = displaced[id(body)]
        strain = errors.largest if len(errors.cells) else float(np.nanmax(np.abs(body.model.gauss_strain(u))))
        if strain > MAX_STRAIN:
            yield f"{body.name!r} is strained by {100 * strain:.1f} %: small-strain elasticity is a guess there."


def strained_half_spaces(result: ContactResult) -> Iterator[str]:
    """Warnings of strains and slopes too large for the theory of half-spaces, as of a half-space alone."""
    for contact in result.contacts:
        if (cells := contact._on_cells) is not None:
            number = result.scene.bodies.index(contact.slave)
            moved = result._loading.frames[number].modes(result._motions[number][:, None])[:, 0]
            into = (moved - contact._displacements[0]).reshape(-1, 3) @ cells.surface.normal
            found = validity_warnings(contact.slave, cells.pressure, cells.gap, into.reshape(cells.pressure.shape))
            yield from (f"{contact.slave.name!r}: {text}" for text in found)


def missed_accuracy(result: ContactResult) -> Iterator[str]:
    """Warnings of a requested accuracy that was not reached, and of figures that are worse than what was asked."""
    steps = result.convergence
    if steps is None:
        return
    last, wanted = steps.steps[-1], asked(steps.accuracy)
    if not steps.met:
        yield (
            f"The accuracy {accuracy_text(steps.accuracy)} was not reached: the estimated error is "
            f"{last.text(steps.accuracy)}. {steps.reason[0].upper()}{steps.reason[1:]}."
        )
    loosest = max(wanted.values())
    worse = {name: error for name, error in last.errors.items() if name not in wanted and error > loosest}
    if worse:
        found = ", ".join(f"{name} {percent(error)}" for name, error in worse.items())
        ask = ", ".join(f"{name!r}: {value:g}" for name, value in (wanted | dict.fromkeys(worse, loosest)).items())
        yield (
            f"The accuracy {accuracy_text(steps.accuracy)} was asked of {' and '.join(wanted)}. Estimated errors of "
            f"other figures are larger: {found}. Ask for them by name, accuracy={{{ask}}}"
            f"{_better_cells(result, worse)}."
        )


def stiff_bodies(result: ContactResult) -> Iterator[str]:
    """Warning of forces and motions that are off because the elements of the bodies are too stiff."""
    found = {name: v for name, v in vars(result.response_error).items() if v is not None and v > MAX_ERROR}
    if found and result.convergence is None:
        stiff = result._response_errors.stiff
        ways = {name: f"too {SIGNS[name]}" if stiff[name] else "off" for name in found}
        off = ", ".join(f"the {name} about {percent(v)} {ways[name]}" for name, v in found.items())
        what = "" if all(stiff[name] for name in found) else " or the faces in contact too large"
        ask = ", ".join(f"{name!r}: 0.05" for name in found)
        yield (
            f"The elements of the bodies are too stiff{what}: {off}. Refine the meshes or solve{_verb(result)} with "
            f"accuracy={{{ask}}}"
            f"{_better_cells(result, found)}."
        )


def _better_cells(result: ContactResult, figures: Iterable[str]) -> str:
    """Advice on linear cells, where figures are off because cells are too stiff."""
    linear = [b.name for b in result._elastic_bodies if b.mesh.cells.shape[1] == 8]
    if not linear or not set(figures) & set(SIGNS):
        return ""
    return f"; or give {linear[0]!r} cells of 20 nodes, mesh.upgraded(20), which bend better than those of 8"


def friction_not_unique(result: ContactResult) -> Iterator[str]:
    """Warning of a solution with friction beyond which others exist or which is not stable."""
    assert result.friction is not None
    if result.friction.orientation < 0:
        yield (
            "With this much friction the solution is not the only one, or not stable (the determinant of Newton's "
            "matrix has changed its sign). Follow the load in smaller steps by Scene.solve_path, and compare."
        )


def large_steps(result: ContactResult) -> Iterator[str]:
    """Warnings of friction that smaller load steps would change."""
    end = result._step_end
    for k, contact in enumerate(result.contacts if end is not None else ()):
        if contact.friction is None or end is None:
            continue
        changes, forces = end.change[end.contact == k], np.linalg.norm(contact.friction.forces, axis=1)
        root = np.sqrt(contact.friction.weights)
        changed, friction = (float(np.linalg.norm(size / root)) for size in (changes, forces))
        if changed > MAX_ERROR * friction:
            yield (
                f"The load steps are large: the tractions of friction between {contact.slave.name!r} and "
                f"{contact.master.name!r} may be off by about {percent(changed / friction)}, as steps in halves change "
                "what is pressed anew. Press in smaller steps."
            )


def single_step(result: ContactResult) -> Iterator[str]:
    """Note on friction under loads applied at once."""
    if not result._follows_step:
        yield (
            "Friction depends on the order of loads: these act together, in one step from the unloaded state. "
            "Scene.solve_path applies them one after the other."
        )


def unbounded_pressures(result: ContactResult) -> Iterator[str]:
    """Notes of pressures without bound."""
    for contact in result.contacts:
        if not contact._surface.of_nodes and (edge := contact._singular_edge) is not None:
            yield (
                f"The pressure between {contact.slave.name!r} and {contact.master.name!r} is {edge.peak}: its largest "
                f"value, {contact.max_pressure:.3g}, depends on the mesh. Round the edge to get one that does not."
            )


#: Depth, relative to the smaller body, above which an overlap counts: chords of touching round faces make less.
MIN_DEPTH = 1e-4


def undeclared_overlaps(result: ContactResult) -> Iterator[str]:
    """Warnings of overlapping pairs of bodies without a contact."""
    declared = {frozenset((id(c.slave), id(c.master))) for c in result.scene.contacts}
    bodies = result.scene.bodies
    if len(bodies) * (len(bodies) - 1) // 2 == len(declared):
        return
    placed = [_Placed(result, k) for k in range(len(bodies))]
    for one, other in combinations(placed, 2):
        if frozenset((id(one.body), id(other.body))) in declared:
            continue
        depth = max(one.depth_in(other), other.depth_in(one))
        if depth > MIN_DEPTH * min(one.outside.length, other.outside.length):
            yield (
                f"{one.body.name!r} and {other.body.name!r} overlap by {depth:.4g} and no contact between them was "
                "declared, so that nothing keeps them apart: add a Contact, or move one of them."
            )


class _Placed:
    """A body in its final position."""

    def __init__(self, result: ContactResult, number: int) -> None:
        self.body = result.scene.bodies[number]
        self.outside = self.body._outside(result._state.displacements[number])
        self._motion, self._point = result._state.motions[number], result._loading.frames[number].point

    @cached_property
    def points(self) -> Array:
        """Points (n, 3) of the body in world axes; none for infinite surfaces."""
        return self._moved(self.body.pose.to_world(self.outside.points))

    def _moved(self, points: Array, sign: float = 1.0) -> Array:
        """Points (n, 3) after or before the small motion of a rigid body; displacements of others include it."""
        if not self.body.is_rigid:
            return points
        shift, turn = np.split(self._motion, 2)
        return points + sign * (shift + np.cross(turn, points - self._point))

    @cached_property
    def _box(self) -> tuple[Array, Array] | None:
        """Corners of a bounding box; None for a body that may be infinite."""
        if not self.outside.is_bounded or not len(self.points):
            return None
        return self.points.min(axis=0) - self.outside.radius, self.points.max(axis=0) + self.outside.radius

    def depth_in(self, other: _Placed) -> float:
        """Largest depth of points of this body inside another; zero if none are inside."""
        points, radius, it = self.points, self.outside.radius, other.outside
        if it.surface is None or not len(points):
            return 0.0
        if other._box is not None:
            low, high = other._box
            points = points[((points >= low - radius) & (points <= high + radius)).all(axis=1)]
            if not len(points):
                return 0.0
        seen = other.body.pose.to_body(other._moved(points, -1.0))
        projection = it.surface.project(seen)
        depth = np.where(projection.outside, -np.inf, radius - projection.gap)
        if it.may_hold is not None:
            depth[~it.may_hold(seen, radius)] = -np.inf
        # a point behind an open surface need not be inside
        depth[depth > it.depth + 2 * radius] = -np.inf
        return max(0.0, float(depth.max()))


#: Overlap of nodes, relative to the sum of elastic displacement and overlap, above which a result warns, and relative
#: to a face, below which it is rounding.
MIN_OVERLAP, ROUNDING = 0.2, 1e-4
#: Excess of a second moment above which a result warns.
MAX_EXCESS = 0.01


class _Side(NamedTuple):
    """One elastic side of a contact, in its own axes: its surface, deformed, and elastic displacements of its nodes."""

    body: Body
    before: FacetSurface
    after: FacetSurface
    elastic: Array


def _side(result: ContactResult, given: Body, name: str) -> _Side | None:
    """A side of a contact; None of a body that is not elastic."""
    if not (elastic := elastic_among([given])):
        return None
    (body,) = elastic
    surface = body.surface(name)
    k = next(k for k, b in enumerate(result.scene.bodies) if b is body)
    u, frame = result._state.displacements[k], result._loading.frames[k]
    rest = body._at_points(u - frame.modes(result._state.motions[k][:, None])[:, 0])
    rest = rest if body._deformation is None else rest + body._deformation
    return _Side(body, surface, replace(surface, points=surface.points + body._at_points(u)), rest)


def overlap_left(result: ContactResult) -> Iterator[str]:
    """Warnings of contacts with nodes inside the other body although the gaps of the problem are open."""
    for contact, interface in zip(result.contacts, result._interfaces, strict=True):
        slave = _side(result, interface.slave, interface.surfaces[0])
        master = _side(result, interface.master, interface.surfaces[1])
        if slave is None or master is None or contact._softness:
            continue
        ours = interface.pairing.nodes[contact._candidates]
        one, elastic, size, facets = _deepest(slave, master, np.asarray(np.isin(slave.before.facets, ours).any(axis=1)))
        other, yielded, _, _ = _deepest(master, slave, facets)
        depth, given = max(one, other), elastic + yielded
        if depth > MIN_OVERLAP * (depth + given) and depth > ROUNDING * size:
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


def overlap_between_nodes(result: ContactResult) -> Iterator[str]:
    """Warnings of faces that the other body reaches between their nodes, none of which carries force."""
    for contact in result.contacts:
        if (found := contact._between_nodes.overlap) is not None:
            place = ", ".join(f"{x:.4g}" for x in contact.slave.pose.to_world(found.points[:1])[0])
            nodes, faces = ("cells", "cells") if has_cells(contact._surface) else ("nodes of a face", "faces")
            yield (
                f"{contact.slave.name!r} and {contact.master.name!r} overlap by {found.depth:.3g} at ({place}), "
                f"between {nodes} of {contact.slave.name!r} that carry no force: Hertz's formulas give about "
                f"{found.force:.2g} for it. The overlap is {found.width:.2g} wide: make {faces} there a third of it"
                f"{_remedy(result, contact)}."
            )


def _remedy(result: ContactResult, contact: ContactFields) -> str:
    meshed = any(body is b for b in result._elastic_bodies for body in (contact.slave, contact.master))
    return f" or solve{_verb(result)} with accuracy=0.05" if meshed else ""


def _verb(result: ContactResult) -> str:
    """What to solve by, where the verb that solved does not divide meshes of bodies at finite strain."""
    return " by Scene.solve" if result.finite_strain and result._follows_step else ""


def coarse_pressures(result: ContactResult) -> Iterator[str]:
    """Warnings of contacts not resolved, or whose pressure, peak or area may be off by more than `MAX_ERROR`."""
    for contact in result.contacts:
        if not contact.active.any() or contact._surface.of_nodes:
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
        elif estimate.largest > MAX_ERROR:
            cause = (
                f"the shape of {contact.master.name!r} varies between the nodes. Refine the faces there{remedy}."
                if contact._unseen**2 > estimate.pressure**2 / 2
                else _cause(estimate, remedy)
            )
            yield f"The pressure between {between} may be off by about {estimate.amount}: {cause}"
        elif estimate.worst > MAX_ERROR:
            yield (
                f"The tractions of friction between {between} may be off by about {percent(estimate.worst)} in the "
                f"mean, most at the edge of what sticks. Refine the faces there{remedy}."
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


def springs_at_nodes(result: ContactResult) -> Iterator[str]:
    """Warnings of layers of springs covered up to their rim, whose moments are those of springs at the nodes.

    The second moment of n linear faces by the trapezoidal rule is 1 + 2 / n^2 of the true one, by Simpson's rule, that
    of quadratic faces, it is exact.
    """
    for contact in result.contacts:
        if not contact.slave._is_foundation or not contact.active.all() or contact.facets.shape[1] != 4:
            continue
        # the faces across count an ellipse of as many faces as the rectangle has
        excess = 8 / (np.pi * contact.error_estimate.faces_across**2)
        if excess > MAX_EXCESS:
            yield (
                f"The springs of {contact.slave.name!r} stand at its nodes, and it is covered up to its rim: its "
                f"resistance to tilt may be {percent(excess)} too large. Give it quadratic faces, by "
                "mesh.upgraded(20), which are exact, or more faces."
            )


#: Share of a contact's force within one face of the rim above which a result warns.
MIN_AT_RIM = 0.005


def node_sizes(surface: FacetSurface) -> Array:
    """Mean size (n_nodes,) of the facets round each node; zero off the surface."""
    k = surface.facets.shape[1]
    total = np.bincount(surface.facets.ravel(), np.repeat(surface.mean_facet_size, k), len(surface.points))
    count = np.bincount(surface.facets.ravel(), minlength=len(surface.points))
    return total / np.maximum(count, 1)


def contact_at_rims(result: ContactResult) -> Iterator[str]:
    """Warnings of contacts that reach a rim beyond which the body continues."""
    for contact, interface in zip(result.contacts, result._interfaces, strict=True):
        yield from _at_rims(contact, interface) if contact.active.any() else ()


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
        if share > MIN_AT_RIM and (mine.reached & cut_off).any():
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


class _Near(NamedTuple):
    """Points (n,) within a face of a rim where the body continues or ends, and those on it."""

    smooth: Mask
    sharp: Mask
    reached: Mask

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
    if body._is_cut_off:
        return _Near(near, none, near & ends_near(body, name, points, normals, touching))
    return _Near(none, near, none)


#: Poisson's ratio from which, and depth over width above which, cells of 8 and 20 nodes distort tangential strains. A
#: roller on cells 2.5 times as deep as wide has 0.3 to 0.6 of mu P too much, on square ones less than 0.1.
NEARLY_INCOMPRESSIBLE, TALL = 0.45, 2.0
#: Nodes of cells without a node in their middle, by the nodes of a cell.
SERENDIPITY = (8, 20)


def tall_cells(result: ContactResult) -> Iterator[str]:
    """Warnings of nearly incompressible slaves with friction whose touching cells are much deeper than wide."""
    for contact, interface in zip(result.contacts, result._interfaces, strict=True):
        for body in elastic_among([interface.slave]):
            if contact.friction is None or not contact.active.any() or body.mesh.cells.shape[1] not in SERENDIPITY:
                continue
            if max(m.nu for m in body.model.materials) < NEARLY_INCOMPRESSIBLE:
                continue
            touching = interface.pairing.nodes[contact.active]
            shared = np.isin(body.mesh.cells, touching).sum(axis=1)
            if not shared.any():  # a node in the middle of a face, which cells of 20 nodes do not have
                continue
            cells = body.mesh.cells[shared >= min(2, shared.max())]
            normal = contact.normals[contact.active].mean(axis=0) @ body.pose.rotation
            across = np.linalg.svd(normal[None])[2]
            extent = np.ptp(body.mesh.points[cells] @ across.T, axis=1)
            # a section has no extent across its plane
            widths = np.where(extent[:, 1:] > 0, extent[:, 1:], np.inf).min(axis=1)
            depth = float(np.median(extent[:, 0] / widths))
            if depth > TALL:
                yield (
                    f"Cells of {body.name!r} are {depth:.2g} times as deep as wide where it touches: as it is nearly "
                    "incompressible, pressures drag its surface along, and the friction of rolling may be off by half "
                    "of mu P. Make them as deep as wide, or of 9 or 27 nodes."
                )


#: Constraint force across the load, as a share of the load, above which a result warns.
SILENT_SHARE = 0.1


def held_across(result: ContactResult) -> Iterator[str]:
    """Warnings of bodies held across their load against contact forces.

    Reactions of planes of symmetry, which represent the half that is not modelled, do not count.
    """
    loaded = [f for f in result._loading.frames if f.load[:3].any() and not f.spread]
    mirrored = _mirror_normals(result.scene.bodies) if loaded else np.zeros((0, 3))
    for frame in loaded:
        size = float(np.linalg.norm(frame.load[:3]))
        meant = np.concatenate([frame.free[:3].T, np.eye(3)[[c for c in frame.prescribed_components if c < 3]]])
        across = result.reaction(frame.body)[:3]
        for direction in (mirrored, meant):
            across = across - np.linalg.pinv(direction) @ (direction @ across)
        share = float(np.linalg.norm(across)) / size
        if share > SILENT_SHARE:
            force = np.array2string(across, precision=4)
            yield (
                f"The frame of {frame.body.name!r} is held across its load by the force {force}, {100 * share:.0f} % "
                "of the load: contacts push it aside like a wedge. Release it with free=, or say with motions= that "
                "it is held."
            )


def _mirror_normals(bodies: Sequence[Body]) -> Array:
    """World normals (n, 3) of the planes of symmetry that support bodies."""
    found = [np.zeros((0, 3))]
    for body in elastic_among(bodies):
        for name, support in body.supports.items():
            if is_plane(support) and isinstance(support, str) and support in "xyz":
                found.append(body.pose.rotation[:, ["xyz".index(support)]].T)
            elif is_plane(support) and name in body.mesh.boundaries:
                nodes = body.mesh.points[body.mesh.boundary_nodes(name)]
                found.append(np.linalg.svd(nodes - nodes.mean(axis=0))[2][-1:] @ body.pose.rotation.T)
    return np.concatenate(found)


#: Checks for `ContactResult.warnings` and for `ContactResult.notes`; those of friction are asked of contacts with it.
CHECKS: tuple[Callable[[ContactResult], Iterator[str]], ...] = (
    unborne_motions,
    tilts_held_by_motions,
    unstable_bodies,
    laws_that_soften,
    parted_surfaces,
    pushed_aside,
    large_strains,
    strained_half_spaces,
    held_across,
    contact_at_rims,
    undeclared_overlaps,
    overlap_left,
    overlap_between_nodes,
    coarse_pressures,
    springs_at_nodes,
    stiff_bodies,
    missed_accuracy,
)
NOTES: tuple[Callable[[ContactResult], Iterator[str]], ...] = (
    carried_motions,
    freed_in_vain,
    unbounded_pressures,
    soft_layers,
)
FRICTION_CHECKS, FRICTION_NOTES = (tall_cells, friction_not_unique, large_steps), (single_step,)


def warnings_of(result: ContactResult) -> tuple[str, ...]:
    """Warnings that the scene and its meshes carry, and those of the checks."""
    meshes = (f"{b.name!r}: {text}" for b in result._elastic_bodies for text in b.mesh.warnings)
    checks = CHECKS if result.friction is None else (*CHECKS, *FRICTION_CHECKS)
    return (*result.scene.warnings, *dict.fromkeys(meshes), *(text for check in checks for text in check(result)))


def notes_of(result: ContactResult) -> tuple[str, ...]:
    """Notes that the scene carries, corrections made by readers and surfaces, and what the checks find."""
    mended = (f"{body.name!r}: {text}" for body in result.scene.bodies for text in body.notes)
    checks = NOTES if result.friction is None else (*NOTES, *FRICTION_NOTES)
    return (*result.scene.notes, *dict.fromkeys(mended), *(text for check in checks for text in check(result)))
