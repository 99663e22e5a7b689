"""Pressure with its square root at the edge: a better reading of a contact that has been found.

Polynomials on facets cannot follow a pressure that falls to zero as the square root of the distance from the edge: most
of their error lies in the outermost twentieth of the radius (docs/accuracy.py). Here

    p = sqrt(phi) c

with phi the smooth function of `results.contact_outline`, zero on the edge. Near the outline c is bilinear in the
corners of facets, and forces are integrals against the nodes' functions: with as many coefficients as nodes the problem
would be unstable. Inside, where c varies and sqrt(phi) is smooth, c has the shape functions of the facets, and the
force of a node is its coefficient times the integral of sqrt(phi) N, as that of a nodal pressure is. Hanging nodes
follow from the others. c follows from the condensed problem of the solution by Galerkin's method: with forces f = P c,

    P^T (S f + g + B^T q) = 0,   B f = F,

the gap vanishes in the mean over every function. A factor that carries the singularity: the partition of unity method
(Melenk & Babuska 1996); the square root at the free edge of smooth bodies: Johnson 1985, *Contact Mechanics*, ch. 4.

On a wrong outline the pressure has an inverse square root at the edge, and c leaves it: with a radius 0.1 % too large c
falls by a tenth in the outermost facets. Moving the outline by da_k changes the pressure by -c h_k da_k / (2
sqrt(phi)), and with it c by dc_k. Newton's method takes the outline on which c near the edge is smoothest: least
squares of c + sum_k dc_k da_k less a function that is linear in phi with the angular terms of the outline.

What is certified is the nodal problem. Displacements, stresses and gaps of the result follow its forces. This pressure
has residuals and forces of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.facets import nodal_areas, shapes_on_square
from fecontact.results.contact_fields import ContactFields
from fecontact.results.contact_outline import Mirror, Outline, ellipse_of_moments, planes_of_symmetry
from fecontact.results.edge_functions import RegionFunctions, nearly_bilinear, region_functions
from fecontact.solvers import ContactProblem
from fecontact.solvers.active_set import solve_on

#: Fewest points of a region with an outline of its own.
MIN_POINTS = 12
#: Width of points over their length that counts as a line.
ON_A_LINE = 1e-6


@dataclass(frozen=True, eq=False)
class EdgeRegion:
    """A connected contact area with its outline.

    Attributes
    ----------
    number : int
        As in `ContactFields.region`.
    outline : Outline
    mirrors : tuple of Mirror
        Planes of symmetry at which it ends.
    near : (k,) int array
        Facets of the contact on which it may lie.
    """

    number: int
    outline: Outline
    mirrors: tuple[Mirror, ...]
    near: IntArray


def regions_with_edge(contact: ContactFields) -> list[EdgeRegion]:
    """Regions with enough points, with the ellipses of their moments scaled to the area of the recovered edge.

    Moments give the place and the axes of an outline, whatever the mesh; its size only if the pressure is that of
    Hertz. The outline (`results.contact_outline`) gives the size.
    """
    of_node = contact._node_region
    of_facet = of_node[contact.facets]
    areas = contact.outline.areas
    out = []
    for k in range(1, int(contact.region.max(initial=0)) + 1):
        points = np.flatnonzero(contact.region == k)
        if len(points) < MIN_POINTS or _flat(contact.points[points]):
            continue
        own, alien = (of_facet == k).any(axis=1), ((of_facet != k) & (of_facet > 0)).any(axis=1)
        near = np.isin(contact.facets, contact.facets[own]).any(axis=1) & ~alien
        mirrors = planes_of_symmetry(contact._surface, contact.slave.pose, contact._node_numbers[of_node == k])
        forces = contact.forces[points]
        outline = ellipse_of_moments(contact.points[points], forces, forces @ contact.normals[points], mirrors)
        if areas[near].sum() == 0:
            continue
        scale = np.sqrt(areas[near].sum() * 2 ** len(mirrors) / outline.area)
        outline = replace(outline, axes=outline.axes / scale)
        out.append(EdgeRegion(k, outline, mirrors, np.flatnonzero(near)))
    return out


def _flat(points: Array) -> bool:
    """Whether points (n, 3) lie on a line."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= ON_A_LINE * spread[0])


#: Degrees of outlines tried in turn, and steps of Newton's method on each.
DEGREES, STEPS = (2, 4, 6), 8
#: Largest change of a coefficient in a step, and largest movement, relative to the size, when the outline has settled,
#: and the one accepted after the last step.
MAX_STEP, STEP_TOLERANCE, ACCEPTED_STEP = 0.1, 2e-5, 5e-4
#: Movement by terms of the next degree, relative to the size, up to which they are not needed.
FOUND = 2e-3
#: Layers of facets from the edge on which c is to be smooth.
SMOOTH_LAYERS = 4
#: Accepted tension over the peak, overlap outside over the elastic deflection, and change of area beyond the surface.
TENSION, OVERLAP, AREA = 1e-2, 2e-3, 0.05
#: Most difference from the nodal pressure over the misfit of its reconstructions, and samples of a facet to find it.
MAX_CHANGE, SAMPLES = 1.5, 6
#: Accepted imbalance and mean gap, relative.
BALANCE = 1e-10


@dataclass(frozen=True)
class EdgeResiduals:
    """Residuals of an edge pressure; all numbers are relative and dimensionless.

    Attributes
    ----------
    tension : float
        Largest negative coefficient, over the largest positive one.
    overlap : float
        Largest negative gap at points wholly outside the outlines, over the largest elastic deflection.
    equilibrium : float
        Largest imbalance of forces and moments, over the load.
    weak_gap : float
        Largest mean gap over a function of the pressure, over its mean elastic deflection.
    outline : float
        Movement of the outline, over its size, in the last step.
    change : float
        L2 norm of its difference from the nodal pressure, over the latter's.
    """

    tension: float
    overlap: float
    equilibrium: float
    weak_gap: float
    outline: float
    change: float


@dataclass(frozen=True, eq=False)
class EdgePressure:
    """Pressure of a contact with its square root at the edge, or the reason why there is none.

    Attributes
    ----------
    contact : ContactFields
    regions : tuple of EdgeRegion
        Connected regions with their outlines, the most loaded first.
    functions : tuple of RegionFunctions
    coefficients : tuple of (n_nodes,) arrays
        c at the contact's nodes, for each region.
    forces : (n,) array
        Contact forces at the points with the same virtual work.
    residuals : EdgeResiduals, optional
    note : str
        Why the nodal pressure has to do; empty if this pressure passed its checks.
    """

    contact: ContactFields
    regions: tuple[EdgeRegion, ...]
    functions: tuple[RegionFunctions, ...]
    coefficients: tuple[Array, ...]
    forces: Array
    residuals: EdgeResiduals | None
    note: str = ""

    @property
    def accepted(self) -> bool:
        """Whether it passed its checks."""
        return not self.note

    @property
    def outlines(self) -> tuple[Outline, ...]:
        """Outlines of the regions."""
        return tuple(region.outline for region in self.regions)

    def sampled(self, n: int = 4) -> tuple[Array, Array, Array]:
        """Pressure sampled inside the facets, as `ContactFields.sampled`; the nodal one where it was not accepted.

        Parameters
        ----------
        n : int
            Samples per side of a facet.

        Returns
        -------
        points : (n_samples, 3) array
        values : (n_samples,) array
        areas : (n_samples,) array
        """
        contact = self.contact
        points, nodal, areas = contact.sampled(contact.pressure, n)
        if not self.accepted:
            return points, nodal, areas
        values = nodal.reshape(len(contact.facets), -1)
        places = points.reshape(*values.shape, 3)
        t = (np.arange(n) + 0.5) / n
        local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
        s, t = local.T
        hats = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=1)
        for region, found, c in zip(self.regions, self.functions, self.coefficients, strict=True):
            facets = contact.facets[found.facets]
            smooth = np.einsum("fqa,fa->fq", shapes_on_square(facets, local)[0], c[facets])
            inside = np.where(found.bilinear[:, None], c[facets[:, :4]] @ hats.T, smooth)
            root = np.sqrt(np.maximum(region.outline.level(places[found.facets]), 0.0))
            values[region.near] = 0.0
            values[found.facets] = root * inside
        return points, values.ravel(), areas


class _NotFoundError(Exception):
    """Why there is no edge pressure."""


@dataclass(frozen=True, eq=False)
class _Problem:
    """The condensed problem, and the rows of one contact in it."""

    contact: ContactFields
    problem: ContactProblem
    rows: IntArray
    forces: Array
    corner_areas: Array

    def on_rows(self, nodal: Array) -> Array:
        """Forces (n_candidates, k) of the problem from nodal ones (n_nodes, k) of the contact."""
        at_points = np.asarray(self.contact._at_nodes.T @ nodal)
        out = np.zeros((self.problem.n, nodal.shape[1]))
        known = self.rows >= 0
        if at_points[~known].any():
            raise _NotFoundError("it reaches points that were no candidates")
        out[self.rows[known]] = at_points[known]
        return out


@dataclass(frozen=True, eq=False)
class _Answer:
    """Solution on given outlines, and its change as they move."""

    functions: list[RegionFunctions]
    coefficients: list[Array]
    changes: list[Array]
    columns: Array
    forces: Array
    q: Array


def edge_pressure(contact: ContactFields, problem: ContactProblem, first: int, forces: Array) -> EdgePressure:
    """Edge pressure of a contact.

    Parameters
    ----------
    contact : ContactFields
    problem : ContactProblem
        The condensed problem of the solution.
    first : int
        Row of the contact's first candidate in it.
    forces : (n,) array
        Its solution.
    """
    none = EdgePressure(contact, (), (), (), contact.forces, None)
    if reason := _unsuitable(contact):
        return replace(none, note=reason)
    rows = np.full(len(contact.points), -1)
    rows[contact._candidates] = first + np.arange(len(contact._candidates))
    areas = nodal_areas(contact.nodes, contact.facets[:, :4])
    setting = _Problem(contact, problem, rows, forces, areas)
    try:
        regions = regions_with_edge(contact)
        if not regions:
            raise _NotFoundError("no connected region has enough points for an outline")
        regions, smooth, moved = _settled(setting, regions)
        answer = _answer(setting, regions, smooth)
    except _NotFoundError as reason:
        return replace(none, note=f"nodal pressure: {reason}")
    at_points = np.zeros(len(contact.points))
    at_points[contact._candidates] = answer.forces[rows[contact._candidates]]
    parts = tuple(regions), tuple(answer.functions), tuple(answer.coefficients)
    out = EdgePressure(contact, *parts, at_points, None)
    residuals = _residuals(setting, answer, moved, _change(out))
    return replace(out, residuals=residuals, note=_objection(out, residuals))


def _change(found: EdgePressure) -> float:
    """Relative L2 norm of the difference from the nodal pressure."""
    contact = found.contact
    (_, nodal, areas), (_, values, _) = contact.sampled(contact.pressure, SAMPLES), found.sampled(SAMPLES)
    return float(np.sqrt(areas @ (values - nodal) ** 2 / (areas @ nodal**2)))


def _unsuitable(contact: ContactFields) -> str:
    """Why a contact has no pressure with a square root on facets; empty if it may have one."""
    reasons = (
        (not contact.active.any(), "nothing touches"),
        (contact._is_curve, "the bodies are sections"),
        (contact.coupling != "nodal", "with mortar coupling forces are means over multiplier functions"),
        (contact.friction is not None, "with friction the pressures follow from the tractions too"),
        (contact._surface.cell_area is not None, "the surface is a grid of cells"),
        (
            contact.slave._is_foundation or contact.master._is_foundation,
            "on an elastic foundation the pressure falls to zero linearly",
        ),
    )
    return next((f"nodal pressure: {reason}" for found, reason in reasons if found), "")


def _answer(setting: _Problem, regions: Sequence[EdgeRegion], smooth: Sequence[Mask | None]) -> _Answer:
    """Galerkin's solution on given outlines. Points with force outside the regions keep their own unknown."""
    contact, problem = setting.contact, setting.problem
    for region in regions:
        if not (region.outline.level(contact.nodes[contact.facets[region.near]]) > 0).any():
            raise _NotFoundError("its outline vanishes")
    functions = [
        region_functions(contact, region.outline, region.near, setting.corner_areas, s)
        for region, s in zip(regions, smooth, strict=True)
    ]
    own = [setting.on_rows(found.forces) for found in functions]
    others = setting.forces > 0
    covered = np.zeros(len(contact.points), bool)
    for region in regions:
        covered |= contact.region == region.number
    others[setting.rows[covered & (setting.rows >= 0)]] = False
    columns = np.concatenate([*own, np.eye(problem.n)[:, others]], axis=1)
    response = problem.S @ columns
    S, B = columns.T @ response, problem.B @ columns
    S = (S + S.T) / 2

    def solved(g: Array, F: Array) -> tuple[Array, Array]:
        small = ContactProblem(S, g, B, F).scaled()
        found = solve_on(small, np.arange(small.n))
        return small.forces(found.x), small.motion(found.p)

    c, q = solved(columns.T @ problem.g, problem.F)
    ends = np.cumsum([0] + [part.shape[1] for part in own])
    coefficients = [f.extension @ c[s:e] for f, s, e in zip(functions, ends[:-1], ends[1:], strict=True)]
    changes = []
    for f, at_nodes, s, e in zip(functions, coefficients, ends[:-1], ends[1:], strict=True):
        moved = setting.on_rows(f.by_outline(at_nodes))
        away, load = response.T @ moved, problem.B @ moved
        changes.append(
            np.stack([f.extension @ solved(a, -b)[0][s:e] for a, b in zip(away.T, load.T, strict=True)], axis=1)
        )
    return _Answer(functions, coefficients, changes, columns, columns @ c, q)


def _settled(setting: _Problem, regions: list[EdgeRegion]) -> tuple[list[EdgeRegion], list[Mask | None], float]:
    """Regions with the outlines on which c is smoothest near the edge, and the last movement."""
    smooth: list[Mask | None] = [None] * len(regions)
    for degree in DEGREES:
        regions = [replace(r, outline=r.outline.to_degree(degree, r.mirrors)) for r in regions]
        for _ in range(STEPS):
            answer = _answer(setting, regions, smooth)
            if smooth[0] is None:
                pairs = zip(answer.functions, answer.coefficients, strict=True)
                smooth = [nearly_bilinear(setting.contact, f, c) for f, c in pairs]
                answer = _answer(setting, regions, smooth)
            steps = _steps(setting, regions, answer)
            moved = max(_movement(r.outline, step) for r, step in zip(regions, steps, strict=True))
            regions = [replace(r, outline=r.outline.moved(step)) for r, step in zip(regions, steps, strict=True)]
            if moved < STEP_TOLERANCE:
                break
        if moved > ACCEPTED_STEP:
            raise _NotFoundError("its outline did not settle")
        higher = [replace(r, outline=r.outline.to_degree(degree + 2, r.mirrors)) for r in regions]
        answer = _answer(setting, higher, smooth)
        steps = _steps(setting, higher, answer)
        if max(_movement(r.outline, step) for r, step in zip(higher, steps, strict=True)) < FOUND:
            return regions, smooth, moved
    raise _NotFoundError(f"its outline is not that of a polynomial of degree {DEGREES[-1]}")


def _steps(setting: _Problem, regions: Sequence[EdgeRegion], answer: _Answer) -> list[Array]:
    parts = zip(regions, answer.functions, answer.coefficients, answer.changes, strict=True)
    return [_step(setting, region, found, c, changes) for region, found, c, changes in parts]


def _step(setting: _Problem, region: EdgeRegion, found: RegionFunctions, c: Array, changes: Array) -> Array:
    """Change (n_terms,) of the outline that makes the coefficients (n_nodes,) near the edge smoothest."""
    contact, outline = setting.contact, region.outline
    facets = contact.facets[found.facets]
    reached = np.zeros(len(contact.nodes), bool)
    zone = (outline.level(contact.nodes[facets]) <= 0).any(axis=1)
    for _ in range(SMOOTH_LAYERS):
        reached[facets[zone, :4]] = True
        zone = reached[facets[:, :4]].any(axis=1)
    own = found.own[reached[found.own]] if reached.any() else found.own
    x = contact.nodes[own]
    angular = outline.angular_terms(x)
    smooth = np.concatenate([angular, angular * outline.level(x)[:, None]], axis=1)
    system = np.concatenate([changes[own], -smooth], axis=1)
    if system.shape[0] < system.shape[1]:
        raise _NotFoundError("too few facets lie round its edge")
    step = np.linalg.lstsq(system, -c[own], rcond=1e-10)[0][: changes.shape[1]]
    return np.clip(step, -MAX_STEP, MAX_STEP)


def _movement(outline: Outline, step: Array) -> float:
    """Largest movement of an outline, relative to its size."""
    return float(np.abs(outline.terms(outline.ring()) @ step).max() / 2)


def _residuals(setting: _Problem, answer: _Answer, moved: float, change: float) -> EdgeResiduals:
    problem = setting.problem
    deflection = problem.S @ answer.forces
    gap = deflection + problem.g + problem.B.T @ answer.q
    scale = float(np.abs(deflection).max())
    outside = ~(answer.columns != 0).any(axis=1)
    mean = np.abs(answer.columns.T) @ np.abs(deflection)
    weak = np.divide(np.abs(answer.columns.T @ gap), mean, out=np.zeros_like(mean), where=mean > 0)
    lowest = min(float(c[f.own].min()) for f, c in zip(answer.functions, answer.coefficients, strict=True))
    peak = max(float(c.max()) for c in answer.coefficients)
    return EdgeResiduals(
        tension=max(0.0, -lowest / peak) if peak > 0 else np.inf,
        overlap=max(0.0, -float(gap[outside].min(initial=0.0))) / scale if scale > 0 else np.inf,
        equilibrium=problem.residuals(answer.forces, answer.q).equilibrium,
        weak_gap=float(weak.max()),
        outline=moved,
        change=change,
    )


def _objection(found: EdgePressure, r: EdgeResiduals) -> str:
    """Why an edge pressure does not pass; empty if it does."""
    assert found.contact._readings is not None
    likely = MAX_CHANGE * found.contact._readings.error
    checks = (
        (r.tension > TENSION, f"it would pull, by {r.tension:.1%} of its peak"),
        (r.overlap > OVERLAP, f"the bodies would overlap beside it, by {r.overlap:.1%} of the elastic deflection"),
        (r.equilibrium > BALANCE, f"its forces are not in equilibrium, by {r.equilibrium:.0e}"),
        (r.weak_gap > BALANCE, f"its mean gaps are not zero, but {r.weak_gap:.0e} of the deflection"),
        (_leaves(found), "its outline leaves the surface"),
        (r.change > likely, f"it differs by {r.change:.1%}, more than the estimated error of {likely:.1%} explains"),
    )
    return next((f"nodal pressure: {words}" for failed, words in checks if failed), "")


def _leaves(found: EdgePressure) -> bool:
    """Whether facets cover less than the outlines enclose."""
    pairs = zip(found.regions, found.functions, strict=True)
    return any(f.area * 2 ** len(r.mirrors) < (1 - AREA) * r.outline.area for r, f in pairs)
