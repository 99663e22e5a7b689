"""Equilibrium at large deformation with contact: Newton's method, line search, adaptive load steps.

At every level of the load the energy U(q) - f . q is made stationary under g(q) >= 0. Each iteration solves the
linearised contact problem of `newton.stable_step`; a line search on the exact penalty function

    U(q) - f . q + m sum max(0, -g_k(q)),    m > max l_k

(Nocedal & Wright 2006, section 18.4; m is not a stiffness: the minimum does not depend on it) ensures convergence.
Where a level fails, the load step is reduced; the last equilibrium is kept. A level with the loads of the last one has
its state, which is certified, not solved.

A start state need not be in equilibrium at its level: its residual is added as a load, and as a motion of the supports,
which decreases linearly with the level and is zero at the end.

Rigid motions that supports leave free are held by friction, or refused (`check_supports`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import lsmr
from tqdm import tqdm

from fecontact.ancf.system.assembly import Assembly, Conditions
from fecontact.ancf.system.contact_result import WithContacts
from fecontact.ancf.system.moving_contact import ContactConstraints
from fecontact.ancf.system.newton import newton_step, stable_step
from fecontact.ancf.system.slip import FrictionEnd, Slips, initial_friction, slips
from fecontact.ancf.system.stage import Stage, Start
from fecontact.ancf.system.tangent import UnstableError, is_symmetric
from fecontact.common.arrays import Array
from fecontact.common.checks import share
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SolverError
from fecontact.common.path import Path as BasePath
from fecontact.common.renamed import renamed
from fecontact.common.table import Column, Table
from fecontact.fem.laws import InvertedError
from fecontact.solvers.coulomb import Residuals

#: Share of a rigid motion that supports resist, below which it is free.
FREE = 1e-8
#: Motion of a combination of rigid motions, relative to each of them, that is rounding.
NO_MOTION = 1e-12


def free_motions(a: Assembly, q: Array) -> Array:
    """Rigid motions of the solids at coordinates q that are free.

    Parameters
    ----------
    a : Assembly
    q : (n_dofs,) array

    Returns
    -------
    (n_free, k) array
        Independent, of about unit length, in the free directions of the assembly.
    """
    out = [np.zeros((a.free.shape[1], 0))]
    for k in _held_by_friction(a):
        rows = slice(a.starts[k], a.starts[k + 1])
        modes, block = _modes(a, q, k), a.free[rows]
        _, singular, V = np.linalg.svd(_resisted(a, modes, k), full_matrices=False)
        out.append(block.T @ (modes @ V[singular < FREE].T))
    return np.concatenate(out, axis=1)


def _modes(a: Assembly, q: Array, k: int) -> Array:
    """Translations of a solid and its turns about the mean of its present coordinates, columns of unit size.

    The coordinates of what can touch are vectors that turn with it.
    """
    solid, own = a.solids[k], a.part(q, k)
    shifts = np.stack([solid.translation(e) for e in np.eye(3)], axis=1)
    middle = (own @ shifts) / (shifts**2).sum(axis=0)
    arms = (own - shifts @ middle).reshape(-1, 3)
    modes = np.concatenate([shifts, np.stack([np.cross(e, arms).ravel() for e in np.eye(3)], axis=1)], axis=1)
    return _sized(a, modes, k)


def _sized(a: Assembly, modes: Array, k: int) -> Array:
    """Independent combinations of modes (n_dofs, 6) of a solid, of unit length, without what does not move it."""
    lengths = a.lengths[a.starts[k] : a.starts[k + 1], None]
    size = np.linalg.norm(lengths * modes, axis=0)
    # a straight line does not turn about itself, whichever way it lies
    modes = modes[:, size > NO_MOTION * size.max()] / size[size > NO_MOTION * size.max()]
    _, singular, V = np.linalg.svd(lengths * modes, full_matrices=False)
    moving = singular > NO_MOTION
    return np.asarray(modes @ V[moving].T / singular[moving])


def _resisted(a: Assembly, modes: Array, k: int) -> Array:
    """The part of a solid's modes that supports resist, as lengths."""
    rows = slice(a.starts[k], a.starts[k + 1])
    block = a.free[rows]
    return np.asarray(a.lengths[rows, None] * (modes - block @ (block.T @ modes)))


def _held_by_friction(a: Assembly) -> list[int]:
    """Numbers of the solids in contacts with friction."""
    starts = {start for t in a.constraints if t.friction for start in (t.slave_start, t.master_start)}
    return [k for k, start in enumerate(a.starts[:-1]) if start in starts]


def check_supports(a: Assembly) -> bool:
    """Whether supports leave a rigid motion free, for friction to hold it.

    Raises
    ------
    InputError
        If a solid without friction is free, or any with friction beside rigid hubs; names the solid and its number of
        free rigid motions.
    """
    free, rubbing = False, _held_by_friction(a)
    for k, solid in enumerate(a.solids):
        modes = _sized(a, solid.rigid_modes, k)
        loose = int((np.linalg.svd(_resisted(a, modes, k), compute_uv=False) < FREE).sum())
        if loose and k not in rubbing:
            raise InputError(
                f"Solid {k + 1} is free in {loose} rigid motions; statics needs supports against all six, or friction. "
                "Hold more of its boundaries, or follow the motion in time (dynamics).",
                code="free-rigid-motion",
            )
        free = free or loose > 0
    if free and a.hubs is not None:
        raise InputError(
            "Statics with rigid hubs needs supports against all rigid motions of each solid; friction alone holds some "
            "here. Hold more boundaries, or leave the hub as stiff as its material (rigid=()).",
            code="free-rigid-motion",
        )
    return free


MAX_HALVINGS = 10
MAX_ITERATIONS = 30
#: Whole steps without a search, where there is no contact.
MAX_FULL_STEPS = 15
#: Smallest load step, as a share of the whole load.
MIN_STEP = 1e-4
#: Iterations up to which the next load step is enlarged.
EASY = 8
#: Conditions with a gap above this multiple of their width are left out of an iteration.
REACH = 2.0
#: Strain of a rigid hub that is rounding.
STRAIN = 1e-12
#: Change of a supported coordinate, relative to the size of the bodies, that is rounding.
STILL = 1e-14
#: Relative rounding of a coordinate.
ROUNDING = float(np.finfo(float).eps)


@compact_repr
@dataclass(frozen=True, eq=False)
class State(WithContacts):
    """An equilibrium.

    Attributes
    ----------
    level : float
    q : (n_dofs,) array
    forces : tuple of (n_multipliers,) arrays
        Contact forces of each contact.
    gaps : tuple of (n_multipliers,) arrays
    reactions : (n_dofs,) array
        Generalised forces of the supports.
    energy : float
        Strain energy, with what hardening stores.
    nit : int
        Newton iterations of this level; 0 where the loads of the last one left nothing to do.
    friction : FrictionEnd
        Tangential forces, slip since the last state and its work.
    stresses : (6 n_hubs,) array
        Multipliers of the rigid hubs, see `hubs`.
    overlaps : tuple of float
        Of each contact that carries nothing, as its mean gaps are open: how deep points of it overlap.
    assembly : Assembly
        After its memory: ``state.assembly.solids[k].plastic_strain``.

    Examples
    --------
    A cube of a soft material squeezed to nine tenths between plates; force over present area is Cauchy's pressure:

    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Stage, equilibrium
    >>> cube = AncfSolid(AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")), fc.Material(1.0, 0.0))
    >>> press = fc.RigidBody(fc.Plane())
    >>> a = Assembly.of([cube], [{"top": "xyz"}], [fc.Contact(cube.side("bottom"), press)])
    >>> state = equilibrium(lambda s: Stage(a.with_rigid(press.placed((0, 0, 0.1 * s)))), steps=1).last
    >>> (contact,) = state.contacts
    >>> round(contact.max_pressure, 9), round(contact.point_area, 9)  # E s (1 - s^2) / 2
    (0.0855, 1.0)
    """

    level: float
    q: Array
    forces: tuple[Array, ...]
    gaps: tuple[Array, ...]
    reactions: Array
    energy: float
    nit: int
    friction: FrictionEnd
    stresses: Array = field(default_factory=lambda: np.zeros(0))
    overlaps: tuple[float, ...] = ()
    assembly: Assembly = field(kw_only=True, repr=False)

    @property
    def constraints(self) -> tuple[ContactConstraints, ...]:  # type: ignore[override]
        """The contacts of its assembly."""
        return self.assembly.constraints

    def reaction(self, k: int) -> Array:
        """Forces along the rows of the assembly's k-th support or joint: what it bears.

        Of those that hold the same coordinates, the smallest that do.
        """
        supports = self.assembly.supports
        found = lsmr(sp.vstack(supports).T, self.reactions, atol=1e-14, btol=1e-14, conlim=0)[0]
        return np.split(found, np.cumsum([C.shape[0] for C in supports])[:-1])[k]

    @property
    def _on_contacts(self) -> tuple[Array, Sequence[Sequence[Array]]]:
        return self.q, (self.forces, self.friction.forces, self.friction.slip)

    @property
    def residuals(self) -> Residuals:
        """Of contact, friction and equilibrium; lengths relative to the size of the bodies, forces to the largest.

        That of equilibrium is above the tolerance only where it is rounding.
        """
        return self.friction.residuals

    residual = renamed("residual", "residuals.equilibrium", lambda state: state.residuals.equilibrium)
    penetration = renamed("penetration", "residuals.penetration", lambda state: state.residuals.penetration)

    @property
    def begin(self) -> Start:
        """A motion from here, at rest."""
        return Start(self.q, None, np.concatenate([np.zeros(0), *self.forces]), 0.0, self.assembly.memory)


@compact_repr
@dataclass(frozen=True, eq=False)
class Path(BasePath[State]):
    """Equilibria up to the full load, as a sequence in order of the load level.

    Attributes
    ----------
    cuts : tuple of int
        Number of reductions of the load step before each.
    success : bool
        Whether level 1 was reached.
    message : str
    """

    success: bool
    message: str

    states = renamed("states", "steps")

    @property
    def last(self) -> State:
        """The last equilibrium.

        Raises
        ------
        SolverError
            If there is none.
        """
        if not self.steps:
            raise SolverError(f"No equilibrium was found, so there is no last one. {self.message}", code="no-last")
        return self.steps[-1]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Of the last equilibrium, see `Assembly.warnings`; also printed."""
        return self.steps[-1].assembly.warnings if self.steps else ()

    def rows(self) -> list[dict[str, float]]:
        """Level, iterations, strain energy and residuals of each equilibrium."""
        return [
            {"level": s.level, "iterations": s.nit, "energy": s.energy, **s.residuals.as_dict()} for s in self.steps
        ]

    def __str__(self) -> str:
        notes = [*self.warnings] + [
            f"Contact {k} carries nothing, but its sides overlap by {depth:.4g}: elements or faces, whose mean gaps "
            "count, are longer than the contact. Divide them there."
            for k, depth in enumerate(self.steps[-1].overlaps if self.steps else ())
            if depth > 0
        ]
        rows = self.rows()
        heads = list(rows[0]) if rows else []
        names: list[Column | str] = [*heads[:3], *(Column(head, ".1e") for head in heads[3:])]
        return "\n".join([self.message, str(Table(names, [list(row.values()) for row in rows], notes))])


def equilibrium(
    stage: Callable[[float], Stage], *, steps: int = 10, tolerance: float = 1e-9, start: State | None = None
) -> Path:
    """Follow the equilibrium from the initial or another state to level 1.

    Parameters
    ----------
    stage : callable
        The stage at a level between 0 and 1.
    steps : int
        Initial number of load steps; it adapts.
    tolerance : float
        Tolerance of the residual force (relative to the largest force) and of penetration (relative to the size).
        Forces due to rounded coordinates, eps |K| |q|, count as zero: for a slightly bent slender bar they exceed the
        tolerance of its small forces.
    start : State, optional
        Start from this state: at its level, or, if that is 1, at the level (one of the steps) at which it is nearest to
        equilibrium. Its residual there decreases linearly to zero, so that the last state of a path can be continued to
        any loads, motions and poses of rigid bodies that `stage` has at level 1.

    Returns
    -------
    Path
        With ``success`` False, the reason and all states found, if the full load was not reached. A state with inverted
        material (det F <= 0 at a Gauss point) does not count as found.

    Raises
    ------
    InputError
        If steps or tolerance are out of range, supports leave a rigid motion of a solid without friction free, or
        `start` belongs to other solids.
    InvertedError
        If `start` turns material inside out.
    """
    share("the tolerance", tolerance)
    if steps < 1:
        raise InputError(f"Expected at least one step; found {steps}.")
    check_supports(stage(0.0).assembly)
    begun = start
    if start is not None and start.level >= 1:
        if Iterate.of(stage(1.0), start).distance <= tolerance:
            return Path((start,), (0,), True, "Full load reached: the state to go on from is in balance with it.")
        levels = np.arange(steps) / steps
        begun = replace(start, level=float(min(levels, key=lambda s: Iterate.of(stage(float(s)), start).distance)))
    level, step = 0.0 if begun is None else begun.level, 1.0 / steps
    a = stage(level).assembly
    q, forces, no_stresses = a.q0, np.zeros(a.n_multipliers), np.zeros(6 * len(a.rigid))
    friction = initial_friction(a.constraints, q)
    if begun is not None:
        q, forces, friction = begun.q, _joined(begun.forces), begun.friction
    states: list[State] = [] if begun is None else [begun]
    balanced: Stage | None = None
    if begun is not None:
        stage = _fading(stage, begun, tolerance)
    cuts, tried, trouble = [0] * len(states), 0, ""
    with tqdm(total=1.0, initial=level, desc="load", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        while level < 1 - 1e-12:
            goal = min(1.0, level + step)
            goal = 1.0 if goal > 1 - 1e-9 else goal
            now = stage(goal)
            try:
                same = balanced is not None and now.acts_as(balanced)
                still = _unmoved(now, goal, states[-1], tolerance) if same else None
                after = now if not states else now.remembering(states[-1].assembly.memory)
                state = still or _balanced(Iterate(after, q, friction, forces, no_stresses), goal, tolerance)
            except (UnstableError, InvertedError, SolverError) as error:
                tried, step, trouble = tried + 1, step / 2, str(error)
                if step < MIN_STEP:
                    message = (
                        f"Stopped at level {level:.4g}: no equilibrium found with steps down to {step:.1e}. "
                        f"{trouble} The last good state is kept."
                    )
                    if isinstance(error, UnstableError):
                        message += (
                            " A body that buckles, or snaps where a contact opens, has no equilibrium nearby: "
                            "`move(.., start=path.last)` follows it in time."
                        )
                    return Path(tuple(states), tuple(cuts), False, message)
                continue
            bar.update(goal - level)
            states.append(state)
            cuts.append(tried)
            tried = 0
            level, q, forces, friction, balanced = goal, state.q, _joined(state.forces), state.friction, now
            if state.nit <= EASY:
                step = min(2 * step, 1.0 / steps)
    message = f"Full load reached in {len(states) - (begun is not None)} steps."
    return Path(tuple(states), tuple(cuts), True, message)


def _joined(forces: tuple[Array, ...]) -> Array:
    """Contact forces of all contacts in one array, possibly empty."""
    return np.concatenate([np.zeros(0), *forces])


@dataclass(frozen=True, eq=False)
class Iterate:
    """Coordinates and forces at a stage, with all that equilibrium asks of them.

    Parameters
    ----------
    stage : Stage
    q : (n_dofs,) array
    before : FrictionEnd
        Friction at the end of the last step, from which slip counts.
    forces : (n_multipliers,) array
        Of all contact conditions.
    stresses : (6 n_hubs,) array
        Multipliers of the rigid hubs.
    dragging : (2 f,) array, optional
        Tangential forces; those at the end of the last step unless given.
    """

    stage: Stage
    q: Array
    before: FrictionEnd
    forces: Array
    stresses: Array
    dragging: Array | None = None

    @classmethod
    def of(cls, stage: Stage, state: State) -> Iterate:
        """A state at a stage; contact forces count for any pose of the rigid bodies, which takes effect at once.

        Raises
        ------
        InputError
            If the state is not of these solids and contacts.
        InvertedError
            If it turns material inside out.
        """
        a, multipliers = stage.assembly, tuple(len(f) for f in state.forces)
        own = tuple(t.n_multipliers for t in a.constraints)
        if state.q.shape != (a.n_dofs,) or multipliers != own:
            raise InputError(
                f"The state to go on from has {state.q.size} coordinates and contact forces on {multipliers} "
                f"multipliers, the assembly {a.n_dofs} and {own}: start from a state of the same solids and contacts.",
                code="start-differs",
            )
        a.check_inverted(state.q)
        return cls(
            stage.remembering(state.assembly.memory), state.q, state.friction, _joined(state.forces), state.stresses
        )

    @property
    def a(self) -> Assembly:
        """The assembly."""
        return self.stage.assembly

    @cached_property
    def conditions(self) -> Conditions:
        """Contact conditions."""
        return self.a.conditions(self.q)

    @cached_property
    def slip(self) -> Slips:
        """Slip since the end of the last step."""
        return slips(self.a.constraints, self.conditions.parts, self.q, self.before.start)

    @cached_property
    def tangential(self) -> Array:
        """Tangential forces (2 f,)."""
        return self.before.of(self.slip) if self.dragging is None else self.dragging

    @cached_property
    def load(self) -> Array:
        """Forces (n_dofs,) of all loads."""
        return self.stage.load(self.q)

    @cached_property
    def internal(self) -> Array:
        """Elastic forces (n_dofs,)."""
        return self.a.forces(self.q)

    @cached_property
    def strains(self) -> Array:
        """Of the rigid hubs (6 n_hubs,), which are to vanish."""
        return self.a.hub_strains(self.q)

    @cached_property
    def jump(self) -> Array:
        """What the supported coordinates are short of their prescribed values (n_dofs,), without rounding."""
        jump = self.stage.jump(self.q)
        return np.where(np.abs(self.a.lengths * jump) < STILL * self.a.size, 0.0, jump)

    @cached_property
    def rest(self) -> Array:
        """Forces (n_dofs,) that are not in balance, those of the supports among them."""
        a, rest = self.a, self.load - self.internal
        if a.constraints:
            rest = rest + self.conditions.G.T @ self.forces + self.slip.T.T @ self.tangential
        return rest if a.hubs is None else rest + a.hubs.derivative(self.q).T @ self.stresses

    @cached_property
    def scale(self) -> float:
        """The largest force in the balance."""
        return max(self.a.largest_force(self.load), self.a.largest_force(self.internal), np.finfo(float).tiny)

    @cached_property
    def unbalanced(self) -> float:
        """Largest residual force along the free coordinates."""
        return self.a.largest_force(self.rest - self.a.held(self.rest))

    @cached_property
    def residuals(self) -> Residuals:
        """Of contact, friction and equilibrium."""
        unbalanced = self.unbalanced / self.scale
        return self.slip.residuals(self.conditions.gap, self.forces, self.tangential, self.a.size, unbalanced)

    @cached_property
    def violation(self) -> float:
        """Largest relative violation of contact and friction."""
        return replace(self.residuals, equilibrium=0.0).worst

    @property
    def distance(self) -> float:
        """Largest relative violation of all that a state at rest, without slip, fulfils."""
        slid = np.linalg.norm(self.slip.slip.reshape(2, -1), axis=0)[self.forces[self.slip.points] > 0]
        off = max(self.a.largest_change(self.jump), slid.max(initial=0.0)) / self.a.size
        return float(max(self.unbalanced / self.scale, self.violation, off, np.abs(self.strains).max(initial=0.0)))

    def state(self, level: float, nit: int, tolerance: float) -> State:
        """The equilibrium that it is."""
        a, conditions = self.a.remembering(self.a.relaxed(self.q)), self.conditions
        each = tuple(a.split(self.forces))
        depths = [t.overlap(self.q, part, f) for t, part, f in zip(a.constraints, conditions.parts, each, strict=True)]
        return State(
            level, self.q, each, tuple(a.split(conditions.gap)), -a.held(self.rest), a.energy(self.q), nit,
            self.slip.end(a.constraints, self.q, self.forces, self.tangential, self.residuals), self.stresses,
            tuple(depth if depth > tolerance * a.size else 0.0 for depth in depths), assembly=a,
        )  # fmt: skip


def _fading(stage: Callable[[float], Stage], begun: State, tolerance: float) -> Callable[[float], Stage]:
    """Stages with the residual of a state at its level added, decreasing linearly to zero at level 1."""
    it = Iterate.of(stage(begun.level), begun)
    a, rest, motion = it.a, it.a.held(it.rest) - it.rest, -it.jump
    rest = rest if it.unbalanced > tolerance * it.scale else np.zeros_like(rest)
    motion = motion if a.largest_change(motion) > tolerance * a.size else np.zeros_like(motion)
    if not (rest.any() or motion.any()):
        return stage

    def at(level: float) -> Stage:
        plain, share = stage(level), (1 - level) / (1 - begun.level)
        if share <= 0:
            return plain
        forces = share * rest + (0.0 if plain.forces is None else plain.forces)
        return replace(plain, forces=forces, motion=share * motion + (0.0 if plain.motion is None else plain.motion))

    return at


def _unmoved(stage: Stage, level: float, last: State, tolerance: float) -> State | None:
    """The last state at a further level of the same loads, without slip, if it is still certified.

    It costs one evaluation of the residual. The residuals of Coulomb's law without slip are at most those with slip.
    """
    if Iterate.of(stage, last).distance > tolerance:
        return None
    still = replace(last.friction, slip=tuple(np.zeros_like(s) for s in last.friction.slip), friction_work=0.0)
    return replace(last, level=level, nit=0, friction=still)


def _balanced(it: Iterate, level: float, tolerance: float) -> State:
    """Newton iterations at one level, from coordinates and contact forces of the previous level.

    Without contact of bricks whole steps are tried first: a slender member turns with little strain, and its energy
    rises on the way, so that a search along the step would only shorten it. The tangent must be positive definite
    throughout.
    """
    if not it.a.constraints or all(s.is_slender for s in it.a.solids):
        try:
            return _iterated(it, level, tolerance, MAX_FULL_STEPS)
        except (UnstableError, InvertedError, SolverError):
            pass
    return _iterated(it, level, tolerance)


def _iterated(it: Iterate, level: float, tolerance: float, whole_steps: int = 0) -> State:
    """The iterations, with a search along each step unless a number of whole steps is given."""
    floats, rounded = check_supports(it.a), 0.0
    for nit in range(1, (whole_steps or MAX_ITERATIONS) + 1):
        K = it.a.tangent(it.q)
        rounded = rounded or ROUNDING * it.a.largest_force(abs(K) @ np.abs(it.q))
        direction, after = _newton(it, K, floats)
        it = replace(after, q=it.q + direction) if whole_steps else _searched(it, direction, after)
        balanced = it.unbalanced <= max(tolerance * it.scale, rounded)
        closed = it.violation <= tolerance and not it.jump.any()
        if balanced and closed and np.abs(it.strains).max(initial=0.0) <= STRAIN:
            it.a.check_inverted(it.q)
            return it.state(level, nit, tolerance)
    raise UnstableError(f"Newton's iterations did not settle in {whole_steps or MAX_ITERATIONS} steps.")


def _newton(it: Iterate, K: sp.csr_matrix, floats: bool) -> tuple[Array, Iterate]:
    """Newton's step (n_dofs,) by the elastic tangent K, and the forces after it.

    Contact and hubs take the symmetric part of the tangent of loads that follow.
    """
    a, Z, of_loads, weight = it.a, it.a.free, it.stage.load_tangent(it.q), 0.0
    constrained = bool(a.constraints) or a.hubs is not None
    if of_loads is not None and constrained:
        of_loads = sp.csr_matrix((of_loads + of_loads.T) / 2)
    K = a.constants.minus(K, of_loads, a.curvature(it.conditions, it.forces))
    if a.hubs is not None:
        of_hubs, weight = a.hubs.subtracted(K, it.q, it.stresses)
        K = a.constants.minus(K, of_hubs)
    tangent = a.constants.reduced(K)
    if of_loads is not None and not constrained:
        tangent = replace(tangent, symmetric=is_symmetric(tangent.K))
    gap = it.conditions.gap
    near = np.flatnonzero((gap < REACH * a.widths) | ((it.forces > 0) & np.isfinite(gap)))
    rows = it.slip.rows(it.conditions.G, gap, near, Z, it.jump, (it.forces, it.tangential))
    r = Z.T @ (it.load - it.internal - K @ it.jump if it.jump.any() else it.load - it.internal)
    if a.hubs is None:
        step = stable_step(tangent, r, rows, free_motions(a, it.q) if floats else None)
    else:
        step = newton_step(tangent, r, rows, ties=a.hubs.ties(it.q).along(Z, it.jump))
    forces, dragging = it.slip.spread(near, step.forces, len(gap))
    after = replace(it, forces=forces, dragging=dragging, stresses=step.stresses + weight * it.strains)
    return it.jump + Z @ step.change, after


def _searched(it: Iterate, direction: Array, after: Iterate) -> Iterate:
    """The iterate after a share of the step that lowers the penalty function, under the forces after the whole step.

    With friction its work mu l |s| under the present normal forces is added, of which the step is a minimiser, and with
    rigid hubs their strains. Under prescribed motions the energy may rise, and loads that follow may have none; then
    only inversion shortens the step.

    Raises
    ------
    UnstableError
        If no share of the step lowers it.
    """
    a, limit, driven = it.a, it.slip.limit(after.forces), bool(it.jump.any() or it.stage.follow)
    weight, of_hubs = (2 * float(np.abs(f).max(initial=0.0)) for f in (after.forces, after.stresses))

    def penalty(x: Iterate) -> float:
        penetrated = float(np.maximum(-x.conditions.gap, 0.0).sum())
        return weight * penetrated + of_hubs * float(np.abs(x.strains).sum())

    def friction_work(s: Array) -> float:
        size = np.linalg.norm(s.reshape(2, -1), axis=0)
        return float(np.multiply(limit, size, out=np.zeros(len(size)), where=np.isfinite(limit)).sum())

    def merit(x: Iterate) -> float:
        return a.energy(x.q) - float(it.load @ x.q) + penalty(x) + friction_work(x.slip.slip)

    before = 0.0 if driven else merit(it)
    slope = float((it.internal - it.load) @ direction) - penalty(it)
    slope += friction_work(it.slip.slip + it.slip.T @ direction) - friction_work(it.slip.slip)
    tiny = a.largest_change(direction) < 1e-6 * a.size
    share = 1.0
    for _ in range(MAX_HALVINGS):
        trial = replace(after, q=it.q + share * direction)
        try:
            if driven:
                a.energy(trial.q)
            if driven or tiny or merit(trial) <= before + 1e-4 * share * min(slope, 0.0):
                return trial
        except InvertedError:
            pass
        share /= 2
    raise UnstableError("No share of Newton's step lowers the energy.")
