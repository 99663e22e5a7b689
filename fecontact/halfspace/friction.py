"""Contact of a half-space with friction: steps of a load path, pressures and tractions by staggered iteration.

Pressures are found under the normal displacements by the tractions, then tractions under the limits and tangential
displacements by the pressures, until both certificates hold. Bodies of equal materials (more exactly, of Dundurs' beta
= 0) need one iteration, for there the two problems are not coupled.
"""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import numpy as np

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SolverError
from fecontact.halfspace.compliance import (
    Box,
    Elasticity,
    SurfaceCompliance,
    TangentialCompliance,
    is_coupled,
    tangential_compliance,
)
from fecontact.halfspace.contact import HalfSpaceContact, SolverReport
from fecontact.halfspace.fft import Convolution
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.hardness import dented, with_own_dent
from fecontact.halfspace.pressing import Load, normal_residuals, press
from fecontact.halfspace.traction_contact import FrictionContact, TangentialReport, TractionContact
from fecontact.halfspace.tresca import TrescaIterate, TrescaProblem, solve_nested_tresca, solve_tresca
from fecontact.halfspace.viscoelastic import creep_of
from fecontact.solvers.coulomb import Residuals, ResidualScales, friction_limit, ratio

#: Staggered iterations; each reduces the error by about the product of mu and Dundurs' beta.
MAX_STAGGERED = 40

#: Tolerance of the first staggered iteration; of others, relative to the worst residual of the one before.
FIRST_TOLERANCE, REDUCTION = 1e-3, 0.03

#: Share of the dissipation residual before above which tractions are solved for to a smaller tolerance, its factor, and
#: the smallest product of these factors: beyond it lies rounding.
STALLED, SHARPER, SHARPEST = 0.5, 0.1, 1e-4

#: Pairs of displacements given and found that are mixed.
MIXED = 4

#: Tolerance of the certificate unless another is given; it costs a quarter more than 1e-8.
CERTIFIED = 1e-10

#: Share of the friction limit from which a contact is taken to slide as a whole.
SLIDING = 1 - 1e-9

#: Cells to whose multiples the box round the contact is enlarged, so that several steps share tables.
QUANTUM = 8


@compact_repr
@dataclass(frozen=True)
class PressStep:
    """Loads on the counter-surface at the end of a step: normal, tangential and about the normal.

    Parameters
    ----------
    force, approach : float, optional
        Exactly one: the total normal force, positive, or the downward displacement from the given heights.
    tangential : (float, float), optional
        Force along x and y on the counter-surface; zero unless this or the shift is given.
    shift : (float, float), optional
        Displacement of the counter-surface along x and y since the unloaded state.
    torque : float, optional
        Torque on it about the normal through `position`, counter-clockwise seen from above.
    twist : float, optional
        Its rotation about the normal since the unloaded state; held at zero unless this or the torque is given.
    position : (float, float)
        Where the counter-surface's own origin is; for a shape that rolls or is set down anew. Rolling moves no
        surface against the other: the shift is not changed by it.
    load_point : (float, float), optional
        Point of action (x, y) of the normal force on a counter-surface that may tilt; without it, it does not tilt.
        Tangential forces act in the surface.
    time : float, optional
        Time at the end of the step, for visco-elastic half-spaces: loads change evenly with it, and at the same time as
        the step before at once. The unloaded state is at time 0.
    cycles : float, optional
        With wear: how often the step is passed, in a load cycle that goes on, from the end of the step before. A
        passage is one way; the way back is a step of its own.

    Raises
    ------
    InputError
        If not exactly one of each pair is given, or a number is not finite.

    Examples
    --------
    >>> PressStep(force=10.0, tangential=(1.0, 0.0)).tangential
    (1.0, 0.0)
    """

    force: float | None = None
    approach: float | None = None
    tangential: tuple[float, float] | None = None
    shift: tuple[float, float] | None = None
    torque: float | None = None
    twist: float | None = None
    position: tuple[float, float] = (0.0, 0.0)
    load_point: tuple[float, float] | None = None
    time: float | None = None
    cycles: float | None = None

    def __post_init__(self) -> None:
        if self.cycles is not None:
            checks.positive("the number of cycles", self.cycles)
        Load(self.force, self.approach, self.load_point)
        if self.time is not None and checks.finite("the time of a step", self.time) < 0:
            raise InputError(f"The time of a step must not be negative; found {self.time!r}.", code="time-backwards")
        for one, other in (("tangential", "shift"), ("torque", "twist")):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise InputError(f"Give one of {one} and {other}; found both. The other one follows from it.")
        checks.vector("the position", self.position, 2)
        for name in ("tangential", "shift"):
            if (value := getattr(self, name)) is not None:
                checks.vector(f"the {name}", value, 2)
        for name in ("torque", "twist"):
            if (value := getattr(self, name)) is not None:
                checks.finite(f"the {name}", value)

    @property
    def normal_load(self) -> Load:
        """Force or approach."""
        return Load(self.force, self.approach, self.load_point)

    @property
    def loads(self) -> tuple[float | None, float | None, float | None]:
        """Loads along x, y and about the normal; None where the motion is prescribed."""
        x, y = (self.tangential or (0.0, 0.0)) if self.shift is None else (None, None)
        return x, y, self.torque

    @property
    def motions(self) -> tuple[float | None, float | None, float | None]:
        """Motions along x, y and about the normal; None where the load is prescribed."""
        x, y = self.shift or (None, None)
        return x, y, None if self.torque is not None else (self.twist or 0.0)

    @property
    def slides_by(self) -> str:
        """Name of the motion to prescribe for sliding."""
        return "shift"


class Driven(Protocol):
    """Loads and motions of a counter-surface along x, y and about the normal; of each pair one is None."""

    @property
    def loads(self) -> tuple[float | None, float | None, float | None]:
        """Loads."""

    @property
    def motions(self) -> tuple[float | None, float | None, float | None]:
        """Motions."""

    @property
    def position(self) -> tuple[float, float]:
        """Point about which torque and rotation are."""

    @property
    def slides_by(self) -> str:
        """Name of the motion to prescribe for sliding."""


S = TypeVar("S", bound=Driven)
C = TypeVar("C", bound=TractionContact)


@dataclass(frozen=True, eq=False)
class Friction:
    """A half-space, its counter-surface's friction, and the compliances made so far.

    Parameters
    ----------
    body : SurfaceCompliance
    mu : float
    tolerance : float
    workers : int, optional
    hardness : (nx, ny) array, optional
        Largest pressures, see `halfspace.hardness`.
    """

    body: SurfaceCompliance
    mu: float
    tolerance: float
    workers: int | None = None
    hardness: Array | None = None
    _made: dict[tuple[int, tuple[int, int]], TangentialCompliance] = field(default_factory=dict, repr=False)

    #: Staggered iterations, of many, whose tractions are those of cells twice as large: they err by less.
    on_coarser: ClassVar = 2

    @cached_property
    def constants(self) -> Elasticity:
        """Elastic constants of the surface."""
        return Elasticity.of(self.body)

    @cached_property
    def coupled(self) -> bool:
        """Whether pressures and tractions are coupled."""
        return is_coupled(self.body)

    def compliance(self, level: int, shape: tuple[int, int]) -> TangentialCompliance:
        """Compliance among as many cells of the grid coarsened `level` times by two."""
        if (level, shape) not in self._made:
            cell = (self.body.grid.cell[0] * 2**level, self.body.grid.cell[1] * 2**level)
            counts = (max(shape[0], 2), max(shape[1], 2))
            grid = Grid((cell[0] * counts[0], cell[1] * counts[1]), counts)
            box = (slice(0, shape[0]), slice(0, shape[1]))
            self._made[level, shape] = tangential_compliance(replace(self.body, grid=grid), box, self.workers)
        return self._made[level, shape]

    @property
    def ratio(self) -> Array:
        """Coefficients (2,) along both directions of the loads, over the larger."""
        return np.ones(2)

    @property
    def first_tolerance(self) -> float:
        """Tolerance of the first staggered iteration, the only one without coupling."""
        return max(FIRST_TOLERANCE, self.tolerance) if self.coupled and self.mu > 0 else self.tolerance

    @cached_property
    def lift(self) -> Convolution | None:
        """Normal displacements of the whole grid by tractions on it; None without coupling."""
        whole = (slice(0, self.body.grid.shape[0]), slice(0, self.body.grid.shape[1]))
        return tangential_compliance(self.body, whole, self.workers).lift if self.coupled else None

    def box(self, *pressures: Array) -> Box:
        """Part of the grid with all cells that touch; the whole if it is periodic."""
        shape = self.body.grid.shape
        if self.body.periodic:
            return slice(0, shape[0]), slice(0, shape[1])
        touching = np.logical_or.reduce([p > 0 for p in pressures])
        out = []
        for axis in (0, 1):
            hit = np.flatnonzero(touching.any(axis=1 - axis)) if touching.any() else [0]
            count = min(-(-(int(hit[-1]) + 1 - int(hit[0])) // QUANTUM) * QUANTUM, shape[axis])
            first = min(int(hit[0]), shape[axis] - count)
            out.append(slice(first, first + count))
        return out[0], out[1]


def press_step(
    friction: Friction, heights: Array, step: PressStep, last: FrictionContact | None, symmetry: bool = True
) -> FrictionContact:
    """Press and drag a surface of heights (nx, ny), from the state at the end of the last step or unloaded.

    Dents stay from step to step.

    Raises
    ------
    InputError, SolverError
        As from `staggered`.
    """
    start = None if last is None else (last.traction, None)
    load, z = step.normal_load, dented(heights, last)
    creep = creep_of(friction, step.time, last)

    def tractions_of(normal: HalfSpaceContact) -> DraggedTractions:
        return DraggedTractions(creep.friction, normal, step, last, creep.slip)

    found = staggered(creep.friction, creep.below(z), load, tractions_of, start, symmetry)
    return creep.remembered(found if found.dent is None else replace(found, dent=dented(found.dent, last)))


def staggered(
    friction: Friction,
    heights: Array,
    load: Load,
    tractions_of: Callable[[HalfSpaceContact], Tractions[Any, C]],
    start: tuple[Array, Array | None] | None,
    symmetry: bool = True,
    first: HalfSpaceContact | None = None,
) -> C:
    """Pressures and tractions in turn, from tractions (2, nx, ny) and motions nearby; the first pressures may be known.

    Raises
    ------
    InputError
        If the loads make the contact slide as a whole, with the friction that would hold them.
    SolverError
        If no certified solution was found.
    """
    began = time.perf_counter()
    by_traction, rounds, newton, nit = np.zeros(heights.shape), 0, 0, 0
    several, tolerance = friction.coupled and friction.mu > 0, friction.first_tolerance
    on_coarser = friction.on_coarser if several else 0
    normal, left, sharper = first, math.inf, 1.0
    tried: list[tuple[Array, Array]] = []
    while True:
        if normal is None or rounds:
            normal = press(
                friction.body, heights + by_traction, load, tolerance, symmetry, friction.workers,
                start=normal, hardness=friction.hardness,
            )  # fmt: skip
        tractions = tractions_of(normal)
        _check_holds(friction, normal, tractions.step)
        at = tractions.solve(heights, load, start, sharper * tolerance, rounds < on_coarser)
        rounds, newton, nit = rounds + 1, newton + at.newton, nit + at.nit
        start = tractions.spread(at.q), at.m if rounds > on_coarser else None
        contact = tractions.contact(heights, load, at.q, at.m)
        if contact.residuals.within(friction.tolerance):
            report = TangentialReport(rounds, newton, nit, time.perf_counter() - began)
            return replace(contact, tangential_solver=report)
        off = rounds > on_coarser and (contact.residuals.slip or 0.0) > tolerance
        if not several or rounds == MAX_STAGGERED or off:
            raise SolverError(
                f"No certified answer with friction after {rounds} staggered iterations of pressures and tractions "
                f"and {newton} Newton steps ({contact.residuals}; tolerance {friction.tolerance:.0e}). Take smaller "
                f"steps, or prescribe the {tractions.step.slides_by} instead of a force near sliding."
            )
        by_traction = mixed(tried, by_traction, contact.displacement - normal.displacement)
        # dissipation is relative to the work of slip, of which there may be hardly any
        dissipation = contact.residuals.dissipation or 0.0
        if dissipation > max(STALLED * left, friction.tolerance) and dissipation == contact.residuals.worst:
            sharper = max(SHARPER * sharper, SHARPEST)
        left = dissipation
        tolerance = max(friction.tolerance, min(tolerance, REDUCTION * contact.residuals.worst))


def mixed(tried: list[tuple[Array, Array]], given: Array, found: Array) -> Array:
    """Next displacements by tractions, from those given and found (nx, ny) so far: Anderson's mixing, of few.

    The mean, with weights of sum 1, of those found, whose mean difference to those given is the least.

    References
    ----------
    D. G. Anderson, J. ACM 12 (1965) 547; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.
    """
    tried.append((found, found - given))
    del tried[:-MIXED]
    last, difference = tried[-1]
    changes = np.array([(difference - off).ravel() for _, off in tried[:-1]]).reshape(len(tried) - 1, given.size)
    share = np.linalg.lstsq(changes @ changes.T, changes @ difference.ravel(), rcond=1e-12)[0]
    return np.asarray(last - sum(s * (last - other) for s, (other, _) in zip(share, tried, strict=False)))


def restored(friction: Friction, kind: Callable[..., C], known: Mapping[str, Any]) -> C:
    """A contact of an earlier run, by its kind and fields, with no certificate."""
    body = friction.body
    given: dict[str, Any] = {
        **known,
        "solver": SolverReport(**known["solver"]),
        "tangential_solver": TangentialReport(**known["tangential_solver"]),
    }
    unknown = Residuals(math.inf, math.inf, math.inf, math.inf)
    return kind(
        grid=body.grid, periodic=body.periodic, material=body.material, layers=tuple(body.layers),
        pressure_kind=body.pressure, residuals=unknown, friction=friction.mu, hardness=friction.hardness, **given,
    )  # fmt: skip


def recertified(tractions: Tractions[Any, C], contact: C, heights: Array, load: Load, pressed: HalfSpaceContact) -> C:
    """A contact of an earlier run with slip and certificate computed anew, of pressures with their own dents alone.

    Raises
    ------
    SolverError
        If the certificate does not hold.
    """
    q, friction = contact.traction[:, *tractions.box], tractions.friction
    slip = tractions.slip(q, (contact.motion - tractions.before)[tractions.free])
    own = normal_residuals(friction.body, heights + tractions.lift(q), load, pressed)
    residuals = tractions.residuals(replace(contact, residuals=own), q, slip)
    if not residuals.within(friction.tolerance):
        raise SolverError(f"What the file has of this step is no solution: {residuals}. Choose another file.")
    return replace(contact, slip=tractions.spread(slip), residuals=residuals)


def certified(
    friction: Friction, heights: Array, step: PressStep, last: FrictionContact | None, known: Mapping[str, Any]
) -> FrictionContact:
    """The end of a step of an earlier run, by its fields, with slip and certificate computed anew.

    Raises
    ------
    SolverError
        If the certificate does not hold.
    """
    contact, creep = restored(friction, FrictionContact, known), creep_of(friction, step.time, last)
    tractions = DraggedTractions(creep.friction, contact, step, last, creep.slip)
    load, z = step.normal_load, creep.below(dented(heights, last))
    return creep.memorised(recertified(tractions, contact, z, load, with_own_dent(contact, last)))


def _check_holds(friction: Friction, normal: HalfSpaceContact, step: Driven) -> None:
    """Refuse loads beyond the limit of friction: necessary conditions, each load alone."""
    x, y, torque = step.loads
    grid, force = normal.grid, normal.force
    if (x or y or torque) and not normal.active.any():
        raise InputError(
            "Nothing is pressed at this approach, and nothing holds a tangential force or a torque. Leave them out of "
            "this step, increase the approach, or take smaller cells.",
            code="nothing-touches",
        )
    drag, needed = math.hypot(x or 0.0, y or 0.0), math.hypot(*np.divide((x or 0.0, y or 0.0), friction.ratio))
    if needed > 0 and needed >= SLIDING * friction.mu * force:
        along = f"({(x or 0.0) / drag:.3g}, {(y or 0.0) / drag:.3g})"
        raise InputError(
            f"The contact slides along {along}: to hold a tangential force of {drag:g} under a normal force of "
            f"{force:g} it needs a friction above {needed / force:.4g}; found {friction.mu:g}. Prescribe the "
            f"{step.slides_by} to let it slide.",
            code="slides-as-a-whole",
        )
    if torque:
        arms = np.hypot(grid.x[:, None] - step.position[0], grid.y[None, :] - step.position[1])
        most = float((normal.pressure * arms).sum()) * grid.area
        if abs(torque) >= SLIDING * friction.mu * most:
            raise InputError(
                f"The contact slides round its normal: to hold a torque of {abs(torque):g} it needs a friction above "
                f"{abs(torque) / most:.4g}; found {friction.mu:g}. Prescribe the twist to let it slide.",
                code="slides-as-a-whole",
            )


@dataclass(frozen=True, eq=False)
class Tractions(Generic[S, C]):
    """Tractions under fixed pressures, and the contact that they make."""

    friction: Friction
    normal: HalfSpaceContact
    step: S

    @cached_property
    def box(self) -> Box:
        """Part of the grid with the cells that touch."""
        return self.friction.box(self.normal.pressure)

    @cached_property
    def compliance(self) -> TangentialCompliance:
        """Compliance among the cells of the box."""
        x, y = self.box
        return self.friction.compliance(0, (x.stop - x.start, y.stop - y.start))

    @cached_property
    def rows(self) -> Array:
        """Displacements (3, 2, bx, by) by unit motions along x, y and about the normal."""
        grid = self.normal.grid
        x = (grid.x - self.step.position[0])[self.box[0], None]
        y = (grid.y - self.step.position[1])[None, self.box[1]]
        rows = np.zeros((3, 2, *self.compliance.shape))
        rows[0, 0], rows[1, 1], rows[2, 0], rows[2, 1] = 1.0, 1.0, -y, x
        return rows

    @property
    def before(self) -> Array:
        """Motions (3,) from which those of the problem are counted."""
        return np.zeros(3)

    @cached_property
    def free(self) -> list[int]:
        """Motions whose load is prescribed, and that anything resists."""
        return [j for j, value in enumerate(self.step.loads) if value is not None] if self.friction.mu > 0 else []

    def _given_slip(self, p: Array) -> Array:
        """Slip (2, bx, by) by pressures on the box, and by what was before, without tractions and motions."""
        return self.compliance.of_pressure(p)

    @cached_property
    def problem(self) -> TrescaProblem:
        """The problem of the tractions; motions are those since `before`."""
        p = self.normal.pressure[self.box]
        c = self._given_slip(p)
        for j, value in enumerate(self.step.motions):
            if value is not None:
                c -= (value - self.before[j]) * self.rows[j]
        loads = np.array([self.step.loads[j] for j in self.free], dtype=float).reshape(-1)
        limit = friction_limit(self.friction.mu, p)
        F = loads / self.normal.grid.area
        return TrescaProblem(self.compliance, limit, c, self.rows[self.free], F, self._alone)

    @property
    def _alone(self) -> Array | float:
        """Compliance (bx, by) of cells by themselves beside that of the body."""
        return 0.0

    def lift(self, q: Array) -> Array:
        """Normal displacements (nx, ny) by tractions on the box."""
        lift = self.friction.lift
        return np.zeros(self.normal.grid.shape) if lift is None else lift.apply(self.spread(q))[0]

    def _superposed(self, heights: Array, load: Load) -> tuple[Array, Array]:
        """Tractions on the box and motions from contacts without friction; zero where none are known."""
        return np.zeros((2, *self.compliance.shape)), np.zeros(len(self.free))

    def solve(
        self, heights: Array, load: Load, start: tuple[Array, Array | None] | None, tolerance: float, coarse: bool
    ) -> TrescaIterate:
        """Tractions and motions, from tractions (2, nx, ny) and motions, or by superposition where it applies.

        If `coarse`, those of cells twice as large, interpolated.
        """
        friction, m = self.friction, np.zeros(len(self.free))
        q = np.zeros((2, *self.compliance.shape))
        if friction.mu == 0 or not self.normal.active.any():
            return TrescaIterate(q, q, m)
        if start is not None:
            q, m = start[0][:, *self.box], m if start[1] is None else start[1]
        elif friction.constants.poisson == 0 and not friction.coupled:
            q, m = self._superposed(heights, load)
            if q.any() and self.contact(heights, load, q, m).residuals.within(friction.tolerance):
                return TrescaIterate(q, self.slip(q, m), m)
        # of the iteration before: near, however fine the cells
        return self.reached(q, m, 0.1 * tolerance, start is not None and start[1] is not None, int(coarse))

    def reached(self, q: Array, m: Array, tolerance: float, near: bool = False, finest: int = 0) -> TrescaIterate:
        """Tractions on the box and motions, from others, by coarser grids unless they are near, or up to a level."""
        if near:
            return solve_tresca(self.problem, q, m, tolerance)
        return solve_nested_tresca(self.problem, self.friction.compliance, q, m, tolerance, finest=finest)

    def spread(self, q: Array) -> Array:
        """Values (2, nx, ny) of the grid from values of the box, zero outside."""
        whole = np.zeros((2, *self.normal.grid.shape))
        whole[:, *self.box] = q
        return whole

    def slip(self, q: Array, m: Array) -> Array:
        """Slip (2, bx, by) on the box; zero where nothing touches."""
        return np.where(self.normal.active[self.box], self.problem.slip(q, m), 0.0)

    def contact(self, heights: Array, load: Load, q: Array, m: Array) -> C:
        """The contact with tractions q on the box and motions m since `before`, and its certificate."""
        slip = self.slip(q, m)
        motion = np.array(
            [b if value is None else value for b, value in zip(self.before, self.step.motions, strict=True)]
        )
        motion[self.free] += m
        normal = self.normal
        if self.friction.coupled:
            by_traction = self.lift(q)
            residuals = normal_residuals(self.friction.body, heights + by_traction, load, normal)
            normal = replace(normal, displacement=normal.displacement + by_traction, residuals=residuals)
        known = {name: getattr(normal, name) for name in normal.__dataclass_fields__}
        known["residuals"] = self.residuals(normal, q, slip)
        fields = {"traction": self.spread(q), "slip": self.spread(slip), "position": self.step.position}
        report = TangentialReport(0, 0, 0, 0.0)
        return self._made(motion, friction=self.friction.mu, tangential_solver=report, **known, **fields)

    def residuals(self, normal: HalfSpaceContact, q: Array, slip: Array) -> Residuals:
        """Certificate of pressures, and of tractions and slip on the box, recomputed."""
        return certificate(normal, self.problem, q, slip)

    @abstractmethod
    def _made(self, motion: Array, **fields: Any) -> C:
        """The contact with motions (3,) and other fields."""


@dataclass(frozen=True, eq=False)
class DraggedTractions(Tractions[PressStep, FrictionContact]):
    """Tractions at the end of a step, whose slip is counted from the last contact.

    Of visco-elastic bodies, with the slip (2, nx, ny) by what was before.
    """

    last: FrictionContact | None
    crept: Array | None = None

    @cached_property
    def box(self) -> Box:
        """Part of the grid with the cells that touch now or did before."""
        before = () if self.last is None else (self.last.pressure,)
        return self.friction.box(self.normal.pressure, *before)

    @property
    def before(self) -> Array:
        """Motions (3,) at the end of the last step; of surfaces that are apart then where they touch on their way."""
        if self.last is None:
            return np.zeros(3)
        then, step = self.last.motion, self.step
        if self.last.active.any() or step.approach is None:
            return then
        now = np.array([old if value is None else value for old, value in zip(then, step.motions, strict=True)])
        way, gap = step.approach - self.last.approach, float(self.last.gap.min())
        return np.asarray(then + (gap / way if way > gap else 1.0) * (now - then))

    def _given_slip(self, p: Array) -> Array:
        c = self.compliance.of_pressure(p)
        if self.crept is not None:
            c += self.crept[:, *self.box]
        elif self.last is not None:
            c -= self.compliance.of_pressure(self.last.pressure[self.box])
            c -= self.compliance.apply(self.last.traction[:, *self.box])
        return c

    def _superposed(self, heights: Array, load: Load) -> tuple[Array, Array]:
        """Tractions mu (p - p') by the pressures p' of a smaller load, and motions.

        For one step from the unloaded state if nu = 0 and nothing is coupled: tractions displace the surface along
        themselves as pressures do along the normal.

        References
        ----------
        M. Ciavarella, J. Appl. Mech. 65 (1998) 998; J. Jaeger, Arch. Appl. Mech. 65 (1995) 478.
        """
        mu, p = self.friction.mu, self.normal.pressure[self.box]
        if self.step.torque or self.step.twist or not math.isfinite(mu):
            return super()._superposed(heights, load)
        driven = self.step.shift is None
        along = np.array(self.step.tangential or (0.0, 0.0)) if driven else np.array(self.step.shift)
        size = float(np.hypot(*along))
        m = np.zeros(len(self.free))
        if size == 0:
            return np.zeros((2, *p.shape)), m
        if driven:
            inner = Load(self.normal.force - size / mu, None, None)
        else:
            inner = Load(None, self.normal.approach - size / mu, None)
        z = dented(heights, self.normal)
        less = press(self.friction.body, z, inner, self.friction.tolerance, True, self.friction.workers)
        q = mu * (p - less.pressure[self.box])
        if driven:
            m[:2] = mu * (self.normal.approach - less.approach) * along / size
        return q * (along / size)[:, None, None], m

    def _made(self, motion: Array, **fields: Any) -> FrictionContact:
        x, y, twist = motion.tolist()
        return FrictionContact(**fields, shift=(x, y), twist=twist)


def certificate(
    normal: HalfSpaceContact, problem: TrescaProblem, q: Array, slip: Array, length: float = 1.0
) -> Residuals:
    """Certificate of pressures and tractions, recomputed; a slip per length is counted over a length.

    The scales of friction are the largest pressure and the largest normal displacement, for slip over a length.
    """
    p = normal.pressure
    missing = np.abs(problem.F - np.tensordot(problem.B, q, 3))
    reach = np.abs(problem.B * problem.touching).max(axis=(1, 2, 3), initial=0.0)
    balance = float(ratio(missing, reach * float(p.sum())).max(initial=0.0))
    scales = ResidualScales(float(p.sum()), float(np.abs(normal.displacement).max()) / length, float(p.max()))
    pressed = replace(normal.residuals, equilibrium=max(normal.residuals.equilibrium, balance))
    return pressed.with_friction(q, slip, problem.limits(slip)[0], scales)
