"""Adaptive solution: solve, estimate, divide cells where the error is large, repeat (`Scene.solve(accuracy=...)`).

Bodies are divided where possible (`Body.divided`), with hanging nodes; loads, supports and poses are kept. It ends when
the estimate times a measured safety factor is within the accuracy, at a limit, or where the error does not fall; then
with the best solution and the reason. Bodies at finite strain are divided as they were before, and solved from there.

Faces to divide are those at the edge of a contact, those with most of the error, and those under the peak. With the
first two kinds only, the L2 error falls while the peak error stays at some percent. Most of the error means a fixed
share of its square (W. Dörfler, SIAM J. Numer. Anal. 33, 1996).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among, of_one_model
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import positive
from fecontact.common.error_estimate import ErrorEstimate, ResponseError
from fecontact.common.errors import InputError
from fecontact.common.progress import say_done
from fecontact.contact.candidates import KnownContact
from fecontact.contact.interface import Interface
from fecontact.contact.loads import LoadStep
from fecontact.contact.model import SceneModel
from fecontact.fem.condensation import memory_budget
from fecontact.mesh.facets import facet_centres
from fecontact.results.contact_fields import ContactFields
from fecontact.results.convergence import FIGURES, Convergence, Step, asked
from fecontact.results.result import ContactResult
from fecontact.scene.carried import CarriedScene, with_bodies
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
        faces are marked: not those at the edge without much of the error.
    """
    read = contact._readings
    assert read is not None
    active = (contact._at_nodes @ contact.pressure > 0)[contact.facets]
    share = _share(contact.error_estimate.pressure, tolerance)
    out = active.any(axis=1) & ~active.all(axis=1) & (share >= BULK)
    out[read.facets[_most(read.misfit, share)]] = True
    unseen = contact._between_nodes.unseen[contact._facet_numbers]
    out |= unseen > tolerance * np.sqrt((contact.pressure**2 @ contact.weights) / contact.point_area)
    sideways = _share(contact.error_estimate.traction or 0.0, tolerance)
    if contact._traction_misfit is not None and sideways > 0:
        out[read.facets[_most(contact._traction_misfit[0], sideways)]] = True
    if read.peak_offset <= AIM * tolerance * read.peak:
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
    error = np.concatenate([e.error for e in contact._energy_errors])
    # half-spaces and rigid bodies have no cells
    if contact.error_estimate.interior < WORTH * tolerance or not len(error):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    chosen = np.zeros(len(error), bool)
    chosen[_most(error, _share(contact.error_estimate.pressure, tolerance))] = True
    ours, theirs = contact._energy_errors
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


def undeformed(body: Body, name: str, points: Array) -> Array:
    """Points (n, 3) on a surface of a body, in its axes, where they were before it deformed at finite strain."""
    if body._deformation is None or not len(points):
        return points
    weights = with_nodes(body.surface(name)).project(points).weights
    assert weights is not None
    return np.asarray(points - weights @ body._deformation)


def divided_to(body: Body, name: str, points: Array, size: float) -> Body:
    """The body with its facets at points (n, 3), in its axes, divided until none there is larger than a size."""
    while True:
        surface, facets = with_nodes(body.surface(name)), facets_at(points, body, name)
        wide = facets[surface.mean_facet_size[facets] > size]
        finer = body._divided({name: wide}) if len(wide) else body
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


#: Safety factor of an estimate: the smallest ratio of estimate and error in docs/error_estimates.md is 0.92.
SAFETY = 1.1
#: Largest number of divisions, and of divisions in a row without a lower error.
MAX_DIVISIONS, PATIENCE = 12, 2
#: Ratio to the last error below which a division counts as progress.
PROGRESS = 0.9
#: Share of a face by which candidates on the divided mesh reach beyond the edge of the last contact. The farthest point
#: that touched was at 0.22 of 20-node hexahedra's faces, 0.12 of tetrahedra's and 0.27 of 8-node hexahedra's; a miss
#: costs another factorisation.
BEYOND = 0.35
#: Estimate, and estimate over the target, from which meshes are divided twice before the next solution. Nearly all
#: faces of a contact with an error of some tens of percent are marked, so that the second marks need no solution of
#: their own; with less, they are the faces at the edge of the contact, which is known better than the faces are wide.
#: Below the smaller ratio a single division halves the error enough.
WIDE, FAR, NEAR = 0.1, 4.0, 1.65
#: Largest growth of a body's unknowns by two divisions at once.
TWICE = 4.0
#: Size of faces, relative to the width of an overlap between their nodes, down to which they are divided at once.
SEEN = 0.5
#: Growth of the unknowns that the next division is expected to bring.
GROWTH = 1.6
#: Power of the unknowns by which time and memory of a factor grow: 4/3 for nested dissection of a solid.
COST = 4 / 3


@dataclass(frozen=True)
class Target:
    """An accuracy and limits of its cost.

    Attributes
    ----------
    accuracy : float or mapping of str to float
        Relative error of the pressure in L2 over the contact, and of the tractions of friction; or errors of the
        figures `results.convergence.FIGURES` by name.
    max_dofs : int, optional
    max_seconds : float, optional
    """

    accuracy: float | Mapping[str, float]
    max_dofs: int | None = None
    max_seconds: float | None = None

    def __post_init__(self) -> None:
        unknown = [name for name in asked(self.accuracy) if name not in FIGURES]
        if unknown or not asked(self.accuracy):
            found = repr(unknown[0]) if unknown else "none"
            raise InputError(f"accuracy by name is asked of {', '.join(FIGURES)}; found {found}.", code="no-figure")
        for name, value in asked(self.accuracy).items():
            of = f" of the {name}" if isinstance(self.accuracy, Mapping) else ""
            positive(f"The accuracy{of}", value)
            if value >= 1:
                raise InputError(f"accuracy{of} is a relative error below 1, such as 0.02 for 2 %; found {value!r}.")
        for name in ("max_dofs", "max_seconds"):
            if getattr(self, name) is not None:
                positive(f"The limit {name}", getattr(self, name))

    @property
    def of_response(self) -> bool:
        """Whether errors of forces or motions are asked for."""
        return not asked(self.accuracy).keys().isdisjoint(vars(ResponseError()))

    def pressure(self, estimate: ErrorEstimate) -> float | None:
        """Error of the pressure of a contact at which it, its peak and its area are as asked; None where none is."""
        found = {"pressure": estimate.worst, "peak": estimate.peak, "area": estimate.area}
        of_figure = [wanted * estimate.worst / found[n] for n, wanted in self._wanted(found) if found[n] > 0]
        if not estimate.resolved:
            of_figure += [wanted for n, wanted in asked(self.accuracy).items() if n in ("peak", "area")]
        return min(of_figure, default=None)

    def response(self, result: ContactResult) -> tuple[str, float] | None:
        """Name of the error of forces and motions that is farthest above what is asked, and how far; None: none is."""
        if not self.of_response:
            return None
        found = {n: e for n, e in vars(result.response_error).items() if e is not None and n in asked(self.accuracy)}
        over = {n: SAFETY * found[n] / wanted for n, wanted in self._wanted(found)}
        worst = max(over, key=over.__getitem__, default=None)
        return None if worst is None or over[worst] <= 1 else (worst, over[worst])

    def _wanted(self, found: Mapping[str, float]) -> list[tuple[str, float]]:
        return [(n, wanted) for n, wanted in asked(self.accuracy).items() if n in found and np.isfinite(found[n])]


Solve = Callable[[SceneModel, LoadStep, Sequence[KnownContact | None], Sequence[Pose]], ContactResult]


def solve_to_accuracy(scene: SceneModel, step: LoadStep, target: Target, solve: Solve) -> ContactResult:
    """Solution whose estimated error of the pressure is within a target, or the best one within its limits.

    Parameters
    ----------
    scene : SceneModel
    step : LoadStep
    target : Target
    solve : callable
        Function ``solve(scene, step, known, poses)`` for one solution.
    """
    if scene.has_overclosure:
        raise InputError("accuracy is not offered with soft contacts: leave it out, and refine.", code="soft-contact")
    if scene.has_nodes_alone:
        raise InputError("accuracy is not offered with sets of nodes as slaves: give boundaries.", code="nodes-alone")
    start = time.perf_counter()
    now = CarriedScene(scene, tuple(scene.bodies))
    steps: list[Step] = []
    known: list[KnownContact | None] = []
    poses: list[Pose] = []
    while True:
        result = solve(now.scene, now.step(step), known, poses)
        steps.append(_step(result, target, time.perf_counter() - start))
        factors = sum({id(c): c.memory for b in result._elastic_bodies if (c := b.model.condensation)}.values())
        reason, finer = _reason_to_end(steps, target, factors), None
        say_done(_division(steps, target, bool(reason)))
        if not reason:
            finer = _divided(now.scene, result, target, not _reason_to_end(steps, target, factors, TWICE))
            reason = "" if finer is not None else "no cell of the bodies in contact can be divided"
        if finer is None:
            met = SAFETY * steps[-1].over(target.accuracy) <= 1
            unknown = result._response_errors.reason if target.of_response else ""
            if met and unknown:
                met, reason = False, f"errors of forces and motions are {unknown}"
            steps[-1] = replace(steps[-1], **_response(result))
            told = Convergence(target.accuracy, tuple(steps), met, reason)
            out = replace(result, _unrefined=tuple(scene.bodies), convergence=told)
            vars(out)["_response_errors"] = result._response_errors
            return out
        moved = any(b.pose is not before.pose for b, before in zip(result.scene.bodies, now.scene.bodies, strict=True))
        poses = [b.pose for b in result.scene.bodies] if moved else []
        now = CarriedScene(finer, tuple(scene.bodies))
        known = [_known(c, i) for c, i in zip(result.contacts, result._interfaces, strict=True)]


def _division(steps: Sequence[Step], target: Target, last: bool) -> str:
    """A solution on the way in one line: errors, unknowns, seconds, and the forecast of the next."""
    now, before = steps[-1], steps[-2] if len(steps) > 1 else None
    growth = now.n_dofs / before.n_dofs if before else GROWTH
    forecast = growth**COST * (now.seconds - (before.seconds if before else 0.0))
    more = "" if last else f"; the next takes about {forecast:.2g} s"
    errors = now.text(target.accuracy) or "not resolved"
    return f"division {len(steps) - 1}: error of {errors}, {now.n_dofs} dofs, {now.seconds:.1f} s{more}"


def _step(result: ContactResult, target: Target, seconds: float) -> Step:
    estimates = [c.error_estimate for c in result.contacts if c.active.any()]
    hanging = [b.mesh.hanging for b in result._elastic_bodies]
    # of a contact between the nodes nothing is known
    unknown = float(any(c._between_nodes.overlap for c in result.contacts))
    return Step(
        n_dofs=result.n_dofs,
        n_hanging=sum(len(h.nodes) for h in hanging if h is not None),
        n_candidates=result.n_candidates,
        pressure=max([unknown, *(e.pressure for e in estimates)]),
        traction=max((e.traction for e in estimates if e.traction is not None), default=None),
        peak=max([unknown, *(e.peak for e in estimates)]),
        max_pressure=max((c.max_pressure for c in result.contacts), default=0.0),
        area=sum(c._whole.area for c in result.contacts),
        seconds=seconds,
        area_error=max([unknown, *(e.area for e in estimates)]),
        **_response(result, target.of_response),
    )


def _response(result: ContactResult, known: bool = True) -> dict[str, Any]:
    """Errors of forces and motions where they are to be known: the whole of them where bodies overlap unseen."""
    unseen = any(c._between_nodes.overlap for c in result.contacts)
    return {n: 1.0 if unseen else e for n, e in vars(result.response_error).items()} if known else {}


def _reason_to_end(steps: Sequence[Step], target: Target, factors: int, least: float = 1.0) -> str:
    """Reason to end after these steps, the last with factors of so many bytes; empty: go on.

    `least` is the least growth of the unknowns that is expected of the next division.
    """
    last, wanted = steps[-1], target.accuracy
    if SAFETY * last.over(wanted) <= 1:
        if not isinstance(wanted, Mapping):
            return f"the estimate of {last.errors['pressure']:.2%}, times {SAFETY} for safety, is within it"
        return f"the estimates ({last.text(wanted)}), times {SAFETY} for safety, are within it"
    before = [s.over(wanted) for s in steps[: -1 - PATIENCE]]
    if len(steps) > PATIENCE + 1 and min(s.over(wanted) for s in steps[-1 - PATIENCE :]) > PROGRESS * min(before):
        return f"the last {PATIENCE + 1} divisions did not lower the error: a singular edge, or geometry"
    if len(steps) > MAX_DIVISIONS:
        return f"the meshes have been divided {MAX_DIVISIONS} times"
    growth = max(least, last.n_dofs / steps[-2].n_dofs if len(steps) > 1 else GROWTH)
    if target.max_dofs is not None and growth * last.n_dofs > target.max_dofs:
        return f"the next division would exceed max_dofs={target.max_dofs}"
    needed, free = growth**COST * factors, memory_budget()
    if needed > free:
        return f"the factors of the next division would take {needed / 1e9:.2g} GB of {free / 1e9:.2g} GB"
    taken = last.seconds - (steps[-2].seconds if len(steps) > 1 else 0.0)
    if target.max_seconds is not None and last.seconds + growth**COST * taken > target.max_seconds:
        return f"the next division would exceed max_seconds={target.max_seconds:g}"
    return ""


def _known(contact: ContactFields, interface: Interface) -> KnownContact | None:
    """Known contact for the solution on the next meshes, with margins beyond its edge by a share of a face."""
    if not (active := contact.active).any():
        return None
    largest = contact._sharing.multiply(interface.slave_surface.mean_facet_size).max(axis=1).toarray().ravel()
    points, shares = contact.points[active], contact._at_nodes.T[active]
    depth = np.maximum(shares @ contact._edge_level / (shares @ np.ones(shares.shape[1])), 0.0)
    if not active.all():
        depth = np.minimum(depth, cKDTree(contact.points[~active]).query(points)[0])
    return KnownContact(points, depth, BEYOND * largest[active])


def _divided(scene: SceneModel, result: ContactResult, target: Target, again: bool) -> SceneModel | None:
    """The scene on finer meshes, faces divided `again` where that is due; None if no body has a cell to divide."""
    marks: dict[int, dict[str, IntArray]] = {}
    below: dict[int, IntArray] = {}
    edges: dict[int, dict[str, Array]] = {}
    number = {id(b): k for k, b in enumerate(result.scene.bodies)}
    touching = [c for c in result.contacts if c.active.any()]
    overlaps = [(number[id(c.slave)], c.surfaces[0], o) for c in result.contacts if (o := c._between_nodes.overlap)]
    wanted = {id(c): target.pressure(c.error_estimate) for c in touching}
    over = max((c.error_estimate.worst / t for c in touching if (t := wanted[id(c)])), default=0.0)
    # beside an edge where the pressure has no bound, more divisions do not help
    again = again and over > NEAR and all(c.error_estimate.unbounded is None for c in touching)
    response = target.response(result)
    if response is not None:
        parts = result._response_errors.cells[response[0]]
        below = {k: cells for k, cells in enumerate(marked_by_response(parts, response[1])) if len(cells)}
        marks = {k: {} for k in below}
    for contact, interface in zip(result.contacts, result._interfaces, strict=True):
        accuracy = wanted.get(id(contact))
        if accuracy is None or (response is not None and SAFETY * contact.error_estimate.worst <= accuracy):
            continue
        both = (interface.slave, interface.master)
        own = contact._facet_numbers[marked_facets(contact, accuracy / SAFETY)]
        for body, name, facets in zip(both, interface.surfaces, (own, facets_opposite(interface, own)), strict=True):
            of_body = marks.setdefault(number[id(body)], {})
            of_body[name] = np.union1d(of_body.get(name, facets), facets)
            if again and (over <= FAR or contact.error_estimate.worst <= WIDE):
                at_edge = edges.setdefault(number[id(body)], {})
                at_edge[name] = np.concatenate([at_edge.get(name, np.zeros((0, 3))), edge_points(contact)])
        for body, cells in zip(both, marked_cells(contact, accuracy), strict=True):
            below[number[id(body)]] = np.union1d(below.get(number[id(body)], cells), cells)
    bodies = list(scene.bodies)
    for k, marked in marks.items():
        given = {name: facets for name, facets in marked.items() if len(facets)}
        if not given and not len(below[k]):
            continue
        bodies[k] = bodies[k]._divided(given, below[k])
        if again and given and bodies[k] is not scene.bodies[k]:
            once = {n: parts_of(f, scene.bodies[k], bodies[k], n) for n, f in given.items()}
            for name in once.keys() & edges.get(k, {}).keys():
                points = undeformed(result.scene.bodies[k], name, result.scene.bodies[k].pose.to_body(edges[k][name]))
                once[name] = np.intersect1d(once[name], facets_at(points, bodies[k], name))
            if any(len(p) for p in once.values()):
                more = bodies[k]._divided(once)
                bodies[k] = more if more.n_dofs <= TWICE * scene.bodies[k].n_dofs else bodies[k]
    for k, name, overlap in overlaps:
        there = undeformed(result.scene.bodies[k], name, overlap.points)
        bodies[k] = divided_to(bodies[k], name, there, SEEN * overlap.width)
    if all(new is old for new, old in zip(bodies, scene.bodies, strict=True)):
        return None
    of_one_model(bodies, scene.bodies)
    for body in elastic_among(bodies):
        body.model  # noqa: B018 - checks the mesh, and is shared by the body in other poses
    return with_bodies(scene, bodies).scene
