"""Grid problem of a rigid surface and a load, and the contact from its solution."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.linalg import LinearOperator

from fecontact.common.arguments import flag
from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import finite, number_array, share, vector, whole
from fecontact.common.errors import InputError, SolverError
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact, SolverReport
from fecontact.halfspace.fft import DiagonalTerm, Product, Tally, each, padded, strips
from fecontact.halfspace.grid import Even, Grid, even_axes, part_of, unfold
from fecontact.halfspace.hardness import check_bearing, with_hardness, within_bounds, yielded
from fecontact.halfspace.nested import GridLevel, compliance, solve_level, solve_nested
from fecontact.solvers import ContactProblem, Residuals

if TYPE_CHECKING:
    from fecontact.halfspace.steady import Motion

#: Least tolerance of a certificate: rounding of the transforms alone leaves some 1e-15.
MIN_TOLERANCE = 1e-14


@dataclass(frozen=True)
class Load:
    """Force or approach of the counter-surface, and point of action of the force if the surface may tilt.

    Attributes
    ----------
    force, approach : float or None
        Exactly one.
    point : (float, float) or None
        None: the surface does not tilt.
    """

    force: float | None
    approach: float | None
    point: tuple[float, float] | None

    def __post_init__(self) -> None:
        given = [v for v in (self.force, self.approach) if v is not None]
        if len(given) != 1:
            raise InputError(
                f"Give exactly one of force and approach; found force={self.force!r}, approach={self.approach!r}.",
                code="one-of",
            )
        finite("the force" if self.force is not None else "the approach", given[0])
        if self.force is not None and self.force <= 0:
            raise InputError(
                f"The force must be positive (compression); found {self.force!r}. A frictionless, non-adhesive contact "
                "carries no tension, and without force nothing is pressed.",
                code="force-not-positive",
            )
        if self.point is not None:
            if self.force is None:
                raise InputError(
                    "A load point goes with a force: with a prescribed approach the surface does not tilt.",
                    code="load-point-without-force",
                )
            vector("the load point (x, y)", self.point, 2)


def check_settings(tolerance: float, symmetry: bool, workers: int | None) -> None:
    """Refuse settings of a solve that are of another kind, or a tolerance that rounding does not reach.

    Raises
    ------
    InputError
    """
    if share("the tolerance", tolerance) < MIN_TOLERANCE:
        raise InputError(f"The tolerance must be at least {MIN_TOLERANCE:g}, above rounding; found {tolerance!r}.")
    flag("symmetry", symmetry)
    if workers is not None:
        whole("workers", workers, most=10**4)


def checked_heights(heights: ArrayLike, grid: Grid) -> tuple[Array, Mask]:
    """Heights above the lowest (zero where there is no surface), and the mask of the surface.

    Raises
    ------
    InputError
        For a wrong shape, NaN, minus infinity, or no surface at all.
    """
    z = number_array("the heights", heights)
    if z.shape != grid.shape:
        raise InputError(f"The heights must have the grid's shape {grid.shape}; found {z.shape}.", code="heights-shape")
    if math.isfinite(float(z.sum())):
        return z, np.ones(z.shape, bool)
    if np.isnan(z).any():
        raise InputError(
            f"The heights hold {int(np.isnan(z).sum())} NaN. Fill the holes of a measurement "
            "(surfaces.fill_holes, --holes fill), or leave them open by plus infinity (--holes open).",
            code="heights-nan",
        )
    if (z == -np.inf).any():
        raise InputError("A height of minus infinity lies inside the body; plus infinity means no counter-surface.")
    allowed = np.isfinite(z)
    if not allowed.any():
        raise InputError("There is no counter-surface: all heights are infinite.", code="no-counter-surface")
    return np.where(allowed, z, 0.0), allowed


def press(
    body: SurfaceCompliance,
    heights: ArrayLike,
    load: Load,
    tolerance: float,
    symmetry: bool,
    workers: int | None,
    boxed: bool = True,
    start: HalfSpaceContact | None = None,
    own: Array | None = None,
    hardness: Array | None = None,
    motion: Motion | None = None,
) -> HalfSpaceContact:
    """Solve one contact, see `HalfSpace.press`; without `boxed` contact may reach the border of a free grid.

    It starts from coarser grids, or from a contact nearby of the same symmetry. Compliances `own` (nx, ny) of the cells
    by themselves are beside that of the bodies: own p is part of the gap, and none of the displacement. The dent is
    that by this load. With a motion the compliance is that in axes that move with the contact, see `steady`.
    """
    began = time.perf_counter()
    z, allowed = checked_heights(heights, body.grid)
    level = grid_level(body, z, allowed, load, symmetry, own, hardness)
    if not level.is_bounded:
        most, lowest = float(z.mean()), float(z.min())
        raise InputError(
            f"An approach of {load.approach:g} reaches the mean plane of the periodic surface, beyond which its force "
            f"is unbounded: the approach must be below {most:.6g}, the mean height ({most - lowest:.6g} over the "
            "lowest point). Prescribe the force instead.",
            code="approach-too-large",
        )
    symmetric = level.symmetric
    tally = Tally(4 * padded(body.grid.shape[0]) * padded(body.grid.shape[1]))
    if body.periodic:
        tally = Tally(body.grid.n_cells)
    if len(level.F):
        _check_load_point(body, allowed, load.point)
    check_bearing(level, body.grid)
    if start is not None and start.solver.symmetric == symmetric:
        part = part_of(body.grid.shape, symmetric)
        at = solve_level(level, start.pressure[part], start.active[part], tolerance, tally, workers)
        n_levels, coarse = 1, start.coarse
    else:
        solve = solve_level if motion is None else motion.solve
        at, n_levels, coarse = solve_nested(level, body.kernel, tolerance, tally, workers, solve)
    if not body.periodic and boxed:
        check_box(body.grid, at.active, at.p, symmetric)
    operator: Product = compliance(level, level.whole, tally, workers)
    if motion is not None:
        operator = motion.compliance(level, tally).tractions
    recomputed = at.recomputed and within_bounds(at.p, level.bound)
    p = np.clip(at.p, 0.0, level.bound, out=at.p)
    u = at.u if recomputed else operator.apply(p, at.u)
    dent, plastic = (None, None) if level.bound is None else yielded(level, u, p, at.q, tolerance)
    residuals = _residuals(level, operator, u, p, at.q, dent)
    if not (at.converged and residuals.within(tolerance)):
        raise SolverError(_failure(at.rounds, residuals, tolerance, load))
    gap = _gap(level, u if dent is None else u + dent, at.q, workers)
    approach, tilt = _motion(body.grid, at.q, load, symmetric)
    u = u if own is None else u - level.smooth[0].apply(p)
    seconds, work = time.perf_counter() - began, (tally.products, tally.transforms)
    report = SolverReport(at.nit, at.rounds, n_levels, *work, symmetric, seconds, at.history)
    return HalfSpaceContact(
        grid=body.grid,
        periodic=body.periodic,
        material=body.material,
        layers=tuple(body.layers),
        pressure=unfold(p, symmetric),
        pressure_kind=body.pressure,
        displacement=unfold(u, symmetric),
        gap=unfold(gap, symmetric),
        approach=approach,
        tilt=tilt,
        residuals=residuals,
        status="solved" if p.any() else "no-contact",
        solver=report,
        coarse=coarse,
        given="approach" if load.force is None else "force",
        hardness=hardness,
        dent=None if dent is None else unfold(dent, symmetric),
        plastic=None if plastic is None else unfold(plastic, symmetric),
    )


def grid_level(
    body: SurfaceCompliance,
    z: Array,
    allowed: Mask,
    load: Load,
    symmetry: bool,
    own: Array | None = None,
    hardness: Array | None = None,
) -> GridLevel:
    """The finest level: unknowns are pressures, loads are in units of pressure times cells.

    The moment rows are about the load point, in units of half the grid's size. Along an axis of symmetry there is no
    tilt and no such row.
    """
    grid = body.grid
    point = load.point
    finite = None if hardness is None else np.where(np.isinf(hardness), 0.0, hardness)
    fields = np.array([field for field in (own, finite) if field is not None]).reshape(-1, *grid.shape)
    even = even_axes(z, allowed, fields) if symmetry else (False, False)
    symmetric = (even[0] and not (point and point[0]), even[1] and not (point and point[1]))
    part = part_of(grid.shape, symmetric)
    rows = []
    if load.force is not None:
        rows.append(np.broadcast_to(1.0, grid.shape))
        if point is not None:
            x, y = ((c - p) / (s / 2) for c, p, s in zip((grid.x, grid.y), point, grid.size, strict=True))
            arms = (np.broadcast_to(x[:, None], grid.shape), np.broadcast_to(y[None, :], grid.shape))
            rows += [arm for arm, mirrored in zip(arms, symmetric, strict=True) if not mirrored]
    F = np.zeros(len(rows))
    if load.force is not None:
        F[0] = load.force / grid.area / 2 ** sum(symmetric)
    g = z if load.approach is None else z - load.approach
    return GridLevel(
        kernel=body.kernel(),
        periodic=body.periodic,
        g=np.ascontiguousarray(g[part]),
        allowed=np.ascontiguousarray(allowed[part]),
        # the row of a force alone is no array in memory
        B=rows[0][None, *part] if len(rows) == 1 else np.array([row[part] for row in rows]).reshape(-1, *z[part].shape),
        F=F,
        symmetric=symmetric,
        smooth=() if own is None else (DiagonalTerm(own[part], grid.area),),
        bound=None if hardness is None else np.ascontiguousarray(hardness[part]),
    )


def _motion(grid: Grid, q: Array, load: Load, symmetric: Even) -> tuple[float, tuple[float, float]]:
    """Approach at the origin and slopes, from the multipliers."""
    if load.approach is not None:
        return load.approach, (0.0, 0.0)
    slopes, rest = [0.0, 0.0], list(q[1:])
    if load.point is not None:
        for axis in (0, 1):
            if not symmetric[axis]:
                slopes[axis] = float(rest.pop(0)) / (grid.size[axis] / 2)
    point = load.point or (0.0, 0.0)
    lift = float(q[0]) - slopes[0] * point[0] - slopes[1] * point[1]
    return -lift, (slopes[0], slopes[1])


def _gap(level: GridLevel, u: Array, q: Array, workers: int | None) -> Array:
    """Gaps (nx, ny) under displacements and motions; infinite where there is no counter-surface."""
    gap = np.empty(u.shape)

    def fill(strip: slice) -> None:
        np.add(u[strip], level.g[strip], out=gap[strip])
        gap[strip] += np.einsum("k,kij->ij", q, level.B[:, strip])
        gap[strip][~level.allowed[strip]] = np.inf

    each(fill, strips(*u.shape), workers)
    return gap


def _residuals(
    level: GridLevel, operator: Product, u: Array, p: Array, q: Array, dent: Array | None = None
) -> Residuals:
    """Residuals of the complementarity problem of all cells with a counter-surface, recomputed; u = A p.

    With a hardness those of gaps and pressures, under the dent, and those of dents and what pressures lack of it.
    """
    cells = slice(None) if level.allowed.all() else np.flatnonzero(level.allowed.ravel())
    g = level.g if dent is None else level.g + dent
    g, deflection, forces = (field.ravel()[cells] for field in (g, u, p))

    def product(x: Array) -> Array:
        full = np.zeros(level.g.size)
        full[cells] = x
        return operator.apply(full.reshape(level.g.shape)).ravel()[cells]

    S = LinearOperator((len(g), len(g)), matvec=product, dtype=float)
    B = level.B.reshape(len(level.F), level.g.size)[:, cells]
    problem = ContactProblem(S, g, B, level.F)
    found = problem.residuals(forces, q, deflection=deflection)
    if dent is None or level.bound is None:
        return found
    return with_hardness(found, p, dent, level.bound, problem.residual_scales(forces, q))


def normal_residuals(body: SurfaceCompliance, heights: ArrayLike, load: Load, contact: HalfSpaceContact) -> Residuals:
    """Residuals of a contact's pressures, approach, tilt and dent, recomputed on the whole grid for given heights."""
    z, allowed = checked_heights(heights, body.grid)
    level = grid_level(body, z, allowed, load, symmetry=False, hardness=contact.hardness)
    operator = compliance(level, level.whole, Tally(body.grid.n_cells), None)
    lift = float(np.dot(contact.tilt, load.point or (0.0, 0.0))) - contact.approach
    turns = [slope * side / 2 for slope, side in zip(contact.tilt, body.grid.size, strict=True)]
    p = contact.pressure
    return _residuals(level, operator, operator.apply(p), p, np.array([lift, *turns])[: len(level.F)], contact.dent)


def _check_load_point(body: SurfaceCompliance, allowed: Mask, point: tuple[float, float] | None) -> None:
    """Refuse a load point of a periodic surface, or outside the outline, where the surface would tip over."""
    if point is None:
        return
    if body.periodic:
        raise InputError(
            "A periodic surface cannot tilt, for then it would not repeat: leave out the load point, or make the "
            "half-space free.",
            code="tilt-periodic",
        )
    for axis, (centres, name) in enumerate(zip((body.grid.x, body.grid.y), "xy", strict=True)):
        there = centres[allowed.any(axis=1 - axis)]
        if not there[0] <= point[axis] <= there[-1]:
            raise InputError(
                f"The load point lies at {name} = {point[axis]:g}, outside the counter-surface, which reaches from "
                f"{there[0]:g} to {there[-1]:g}: no pressures balance it, the surface would tip over.",
                code="load-point-outside",
            )


def check_box(grid: Grid, active: Mask, p: Array | None, symmetric: Even, what: str = "contact") -> None:
    """Refuse a contact that reaches the border of a free grid; the message estimates the size needed by pressures."""
    for axis in (0, 1):
        lines = np.moveaxis(active, axis, 0)
        borders = [-1] if symmetric[axis] else [0, -1]
        if not any(bool(lines[b].any()) for b in borders):
            continue
        needed = 2 * grid.size[axis]
        if p is not None:  # Hertz: p = p0 sqrt(1 - x^2/a^2) at the border x of the grid gives a
            at_border = max(float(np.moveaxis(p, axis, 0)[b].max()) for b in borders)
            ratio = min(at_border / float(p.max()), 0.99)
            needed = 1.2 * grid.size[axis] / math.sqrt(1 - ratio**2)
        raise InputError(
            f"The {what} reaches the border of the grid along {'xy'[axis]}, size {grid.size[axis]:g}: the grid is "
            f"smaller than the {what}. A size of about {needed:.3g} is needed there. If the counter-surface ends at "
            "the border, add a rim of cells with infinite height; if it repeats, use periodic=True.",
            code="grid-too-small",
        )


def _failure(rounds: int, residuals: Residuals, tolerance: float, load: Load) -> str:
    advice = "Check the heights for jumps and the load for its size."
    if load.point is not None:
        advice = "Check that the load point is inside the outline of the contact; outside, no pressures balance it."
    return f"No certified answer after {rounds} active sets ({residuals}; tolerance {tolerance:.0e}). {advice}"
