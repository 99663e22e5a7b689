"""Equilibrium at large deformation with contact: Newton's method, line search, adaptive load steps.

At every level of the load the energy U(q) - f . q is made stationary under g(q) >= 0. Each iteration solves the
linearised contact problem of `newton.contact_step`; a line search on the exact penalty function

    U(q) - f . q + m sum max(0, -g_k(q)),    m > max l_k

(Nocedal & Wright 2006, section 18.4; m is not a stiffness: the minimum does not depend on it) ensures convergence.
Where a level fails, the load step is reduced; the last equilibrium is kept. A level with the loads of the last one has
its state, which is certified, not solved.

A start state need not be in equilibrium at its level: its residual is added as a load, and as a motion of the supports,
which decreases linearly with the level and is zero at the end.

Line search of statics: the share of Newton's step that lowers the exact penalty function, see `statics`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from tqdm import tqdm

from fecontact.ancf.bricks.laws import InvertedError
from fecontact.ancf.system.assembly import Assembly, Conditions
from fecontact.ancf.system.free_motion import check_supports, free_motions
from fecontact.ancf.system.newton import UnstableError, contact_step, is_symmetric, tied_step, unsymmetric_step
from fecontact.ancf.system.slip import FrictionEnd, Slips, SlipStart, initial_friction, slips
from fecontact.ancf.system.stage import Stage, Start
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import share
from fecontact.common.errors import InputError, SolverError
from fecontact.common.one_line import one_line

MOST_HALVINGS = 10


def searched(
    a: Assembly,
    q: Array,
    direction: Array,
    load: Array,
    internal: Array,
    conditions: Conditions,
    slip: Slips,
    multipliers: tuple[Array, Array],
    since: SlipStart,
    driven: bool,
) -> tuple[Array, Conditions | None]:
    """New coordinates, after a share of the step that lowers the penalty function, and the conditions there if known.

    With friction its work mu l |s| under the present normal forces is added, of which the step is a minimiser. Under
    prescribed motions the energy may rise; then only inversion shortens the step, as under loads that follow.

    Parameters
    ----------
    a : Assembly
    q, direction : (n_dofs,) arrays
        Coordinates and Newton's step.
    load, internal : (n_dofs,) arrays
        Loads and elastic forces at q.
    conditions, slip, since
        Contact conditions and slip at q, and whence slip counts.
    multipliers : (n_multipliers,) and (6 n_hubs,) arrays
        Contact forces and stresses of rigid hubs of the step; the strains of hubs are penalised, too.
    driven : bool
        Whether there is no energy to lower.

    Raises
    ------
    UnstableError
        If no share of the step lowers it.
    """
    forces, stresses = multipliers
    weight, of_hubs = 2 * float(forces.max(initial=0.0)), 2 * float(np.abs(stresses).max(initial=0.0))
    limit = slip.limit(forces)

    def friction_work(s: Array) -> float:
        size = np.linalg.norm(s.reshape(2, -1), axis=0)
        return float(np.multiply(limit, size, out=np.zeros(len(size)), where=np.isfinite(limit)).sum())

    def merit(x: Array, c: Conditions, s: Array) -> float:
        penetrated = float(np.maximum(-c.gap, 0.0).sum())
        strained = float(np.abs(a.hub_strains(x)).sum())
        return a.energy(x) - float(load @ x) + weight * penetrated + of_hubs * strained + friction_work(s)

    before = None if driven else merit(q, conditions, slip.slip)
    slope = float((internal - load) @ direction) - weight * float(np.maximum(-conditions.gap, 0.0).sum())
    slope -= of_hubs * float(np.abs(a.hub_strains(q)).sum())
    slope += friction_work(slip.slip + slip.T @ direction) - friction_work(slip.slip)
    tiny = np.abs(a.lengths * direction).max(initial=0.0) < 1e-6 * a.size
    share = 1.0
    for _ in range(MOST_HALVINGS):
        trial = q + share * direction
        try:
            if before is None:
                a.energy(trial)
                return trial, None
            if tiny:
                return trial, None
            c = a.conditions(trial)
            s = slips(a.touches, c.parts, trial, since).slip
            if merit(trial, c, s) <= before + 1e-4 * share * min(slope, 0.0):
                return trial, c
        except InvertedError:
            pass
        share /= 2
    raise UnstableError("No share of Newton's step lowers the energy.")


MOST_ITERATIONS = 30
#: Whole steps without a search, where there is no contact.
MOST_WHOLE_STEPS = 15
#: Smallest load step, as a share of the whole load.
SMALLEST_STEP = 1e-4
#: Iterations up to which the next load step is enlarged.
EASY = 8
#: Conditions with a gap above this multiple of their width are left out of an iteration.
REACH = 2.0
#: Strain of a rigid hub that is rounding.
STRAIN = 1e-12
#: Relative rounding of a coordinate.
ROUNDING = float(np.finfo(float).eps)


@one_line
@dataclass(frozen=True, eq=False)
class State:
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
        Strain energy.
    nit : int
        Newton iterations of this level; 0 where the loads of the last one left nothing to do.
    residual : float
        Residual force, relative to the largest force; above the tolerance only where it is rounding.
    penetration : float
        Largest penetration of a mean gap, relative to the size of the bodies.
    friction : FrictionEnd
        Tangential forces, slip since the last state, its work and the defect of Coulomb's law.
    stresses : (6 n_hubs,) array
        Multipliers of the rigid hubs, see `hubs`.
    overlaps : tuple of float
        Of each contact that carries nothing, as its mean gaps are open: how deep points of it overlap.
    """

    level: float
    q: Array
    forces: tuple[Array, ...]
    gaps: tuple[Array, ...]
    reactions: Array
    energy: float
    nit: int
    residual: float
    penetration: float
    friction: FrictionEnd
    stresses: Array = field(default_factory=lambda: np.zeros(0))
    overlaps: tuple[float, ...] = ()

    @property
    def begin(self) -> Start:
        """A motion from here, at rest."""
        return Start(self.q, None, np.concatenate([np.zeros(0), *self.forces]), 0.0)


@one_line
@dataclass(frozen=True, eq=False)
class Path:
    """Equilibria up to the full load.

    Attributes
    ----------
    success : bool
        Whether level 1 was reached.
    message : str
    states : tuple of State
        In order of the load level.
    cuts : int
        Number of reductions of the load step.
    """

    success: bool
    message: str
    states: tuple[State, ...]
    cuts: int

    @property
    def last(self) -> State:
        """The last equilibrium.

        Raises
        ------
        SolverError
            If there is none.
        """
        if not self.states:
            raise SolverError(f"No equilibrium was found, so there is no last one. {self.message}", code="no-last")
        return self.states[-1]

    def __str__(self) -> str:
        lines = [
            self.message,
            f"{'level':>8} {'iterations':>10} {'strain energy':>14} {'residual':>9} {'penetration':>11}",
        ]
        lines += [
            f"{s.level:>8.4f} {s.nit:>10} {s.energy:>14.6g} {s.residual:>9.1e} {s.penetration:>11.1e}"
            for s in self.states
        ]
        lines += [
            f"Contact {k} carries nothing, but its sides overlap by {depth:.4g}: elements or faces, whose mean gaps "
            "count, are longer than the contact. Divide them there."
            for k, depth in enumerate(self.states[-1].overlaps if self.states else ())
            if depth > 0
        ]
        return "\n".join(lines)


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
        if _distance(stage(1.0), start) <= tolerance:
            return Path(True, "Full load reached: the state to go on from is in balance with it.", (start,), 0)
        levels = np.arange(steps) / steps
        begun = replace(start, level=float(min(levels, key=lambda s: _distance(stage(float(s)), start))))
    level, step = 0.0 if begun is None else begun.level, 1.0 / steps
    q = stage(level).assembly.q0 if begun is None else begun.q
    friction = initial_friction(stage(level).assembly.touches, q) if begun is None else begun.friction
    forces = None if begun is None else _joined(begun.forces)
    states: list[State] = [] if begun is None else [begun]
    balanced: Stage | None = None
    if begun is not None:
        stage = _fading(stage, begun, tolerance)
    cuts, trouble = 0, ""
    with tqdm(total=1.0, initial=level, desc="load", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        while level < 1 - 1e-12:
            goal = min(1.0, level + step)
            goal = 1.0 if goal > 1 - 1e-9 else goal
            now = stage(goal)
            try:
                same = balanced is not None and now.acts_as(balanced)
                still = _unmoved(now, goal, states[-1], tolerance) if same else None
                state = _balanced(now, goal, q, forces, friction, tolerance) if still is None else still
            except (UnstableError, InvertedError, SolverError) as error:
                cuts, step, trouble = cuts + 1, step / 2, str(error)
                if step < SMALLEST_STEP:
                    message = (
                        f"Stopped at level {level:.4g}: no equilibrium found with steps down to {step:.1e}. "
                        f"{trouble} The last good state is kept."
                    )
                    if isinstance(error, UnstableError):
                        message += (
                            " A body that buckles, or snaps where a contact opens, has no equilibrium nearby: "
                            "`move(.., start=path.last)` follows it in time."
                        )
                    return Path(False, message, tuple(states), cuts)
                continue
            bar.update(goal - level)
            states.append(state)
            level, q, forces, friction, balanced = goal, state.q, _joined(state.forces), state.friction, now
            if state.nit <= EASY:
                step = min(2 * step, 1.0 / steps)
    return Path(True, f"Full load reached in {len(states) - (begun is not None)} steps.", tuple(states), cuts)


def _joined(forces: tuple[Array, ...]) -> Array:
    """Contact forces of all contacts in one array, possibly empty."""
    return np.concatenate([np.zeros(0), *forces])


class _Missing(NamedTuple):
    """What a state misses at a stage: residual loads and motions (n_dofs,), and the largest force in its balance.

    With its contact conditions, the slip since its end, where rigid bodies have been moved, and tangential forces.
    """

    rest: Array
    motion: Array
    largest: float
    conditions: Conditions
    slip: Slips
    tangential: Array


def _missing(stage: Stage, state: State) -> _Missing:
    """What a state misses.

    Contact forces count for any pose of the rigid bodies, which takes effect at once.

    Raises
    ------
    InputError
        If the state is not of these solids and contacts.
    InvertedError
        If it turns material inside out.
    """
    a = stage.assembly
    multipliers = tuple(len(f) for f in state.forces)
    if state.q.shape != (a.n_dofs,) or multipliers != tuple(t.n_multipliers for t in a.touches):
        raise InputError(
            f"The state to go on from has {state.q.size} coordinates and contact forces on {multipliers} multipliers, "
            f"the assembly {a.n_dofs} and {tuple(t.n_multipliers for t in a.touches)}: start from a state of the same "
            "solids and contacts.",
            code="start-differs",
        )
    a.check_inverted(state.q)
    Z, conditions, internal = a.free, a.conditions(state.q), a.forces(state.q)
    load, motion = stage.load(state.q), -stage.jump(state.q)
    slip = slips(a.touches, conditions.parts, state.q, state.friction.start)
    tangential = state.friction.of(slip)
    rest = internal - load - _of_contact(a, conditions, slip, _joined(state.forces), tangential)
    rest = rest - _of_hubs(a, state.q, state.stresses)
    largest = max(_largest(a, load), _largest(a, internal), np.finfo(float).tiny)
    return _Missing(Z @ (Z.T @ rest), motion, largest, conditions, slip, tangential)


def _distance(stage: Stage, state: State) -> float:
    """Largest relative residual of a state at a stage, as `equilibrium` compares it with its tolerance."""
    rest, motion, largest, conditions, slip, tangential = _missing(stage, state)
    a, forces, gap = stage.assembly, _joined(state.forces), conditions.gap
    slid = np.linalg.norm(slip.slip.reshape(2, -1), axis=0)[forces[slip.points] > 0].max(initial=0.0)
    off = max(
        -gap.min(initial=0.0), gap[forces > 0].max(initial=0.0), np.abs(a.lengths * motion).max(initial=0.0), slid
    )
    off = max(off, a.size * np.abs(a.hub_strains(state.q)).max(initial=0.0))
    return float(max(_largest(a, rest) / largest, off / a.size, slip.defect(forces, tangential, a.size)))


def _fading(stage: Callable[[float], Stage], begun: State, tolerance: float) -> Callable[[float], Stage]:
    """Stages with the residual of a state at its level added, decreasing linearly to zero at level 1."""
    rest, motion, largest, *_ = _missing(stage(begun.level), begun)
    a = stage(begun.level).assembly
    rest = rest if _largest(a, rest) > tolerance * largest else np.zeros_like(rest)
    motion = motion if np.abs(a.lengths * motion).max(initial=0.0) > tolerance * a.size else np.zeros_like(motion)
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

    It costs one evaluation of the residual. The defect of Coulomb's law without slip is at most that with slip.
    """
    if _distance(stage, last) > tolerance:
        return None
    still = replace(last.friction, slip=tuple(np.zeros_like(s) for s in last.friction.slip), friction_work=0.0)
    return replace(last, level=level, nit=0, friction=still)


def _balanced(
    stage: Stage, level: float, q: Array, guess: Array | None, before: FrictionEnd, tolerance: float
) -> State:
    """Newton iterations at one level, from coordinates and contact forces of the previous level.

    Without contact of bricks whole steps are tried first: a slender member turns with little strain, and its energy
    rises on the way, so that a search along the step would only shorten it. The tangent must be positive definite
    throughout.
    """
    if not stage.assembly.touches or all(s.is_slender for s in stage.assembly.solids):
        try:
            return _iterated(stage, level, q, guess, before, tolerance, MOST_WHOLE_STEPS)
        except (UnstableError, InvertedError, SolverError):
            pass
    return _iterated(stage, level, q, guess, before, tolerance)


def _iterated(
    stage: Stage,
    level: float,
    q: Array,
    guess: Array | None,
    before: FrictionEnd,
    tolerance: float,
    whole_steps: int = 0,
) -> State:
    """The iterations, with a search along each step unless a number of whole steps is given."""
    a = stage.assembly
    Z = a.free
    load, jump = stage.load(q), stage.jump(q)
    conditions, internal = a.conditions(q), a.forces(q)
    since = before.start
    slip = slips(a.touches, conditions.parts, q, since)
    tangential = before.of(slip)
    forces = np.zeros(len(conditions.gap)) if guess is None else guess
    widths = np.concatenate([np.zeros(0), *(t.widths for t in a.touches)])
    floats, rounded, stresses = check_supports(a), 0.0, np.zeros(len(a.hub_strains(q)))
    for nit in range(1, (whole_steps or MOST_ITERATIONS) + 1):
        near = np.flatnonzero((conditions.gap < REACH * widths) | ((forces > 0) & np.isfinite(conditions.gap)))
        K = a.tangent(q)
        change, pressing, dragging, stresses = _newton_step(
            stage, q, K, load - internal, jump, conditions, slip, near, (forces, tangential, stresses), floats
        )
        forces, tangential = np.zeros(len(conditions.gap)), slip.spread(near, dragging)
        forces[near] = pressing
        direction, found = jump + Z @ change, None
        if whole_steps:
            q = q + direction
        else:
            # no energy to lower under prescribed motions and loads without a potential
            driven = bool(jump.any() or stage.follow)
            q, found = searched(a, q, direction, load, internal, conditions, slip, (forces, stresses), since, driven)
        load, jump = stage.load(q), stage.jump(q)
        jump[np.abs(a.lengths * jump) < 1e-14 * a.size] = 0.0
        conditions, internal = found or a.conditions(q), a.forces(q)
        slip = slips(a.touches, conditions.parts, q, since) if a.touches else slip
        rest = load - internal + _of_contact(a, conditions, slip, forces, tangential) + _of_hubs(a, q, stresses)
        scale = max(_largest(a, load), _largest(a, internal), np.finfo(float).tiny)
        unbalanced = _largest(a, Z @ (Z.T @ rest))
        rounded = rounded or ROUNDING * _largest(a, abs(K) @ np.abs(q))
        balanced = unbalanced <= max(tolerance * scale, rounded)
        penetration = float(max(0.0, -conditions.gap.min(initial=0.0)) / a.size)
        open_but_pressed = float(np.abs(conditions.gap[forces > 0]).max(initial=0.0) / a.size)
        friction = slip.defect(forces, tangential, a.size)
        closed = max(penetration, open_but_pressed, friction) <= tolerance and not jump.any()
        if balanced and closed and np.abs(a.hub_strains(q)).max(initial=0.0) <= STRAIN:
            a.check_inverted(q)
            gaps = np.split(conditions.gap, np.cumsum([t.n_multipliers for t in a.touches])[:-1]) if a.touches else []
            reactions = -(rest - Z @ (Z.T @ rest))
            each, residual = tuple(a.split(forces)), unbalanced / scale
            end = slip.end(a.touches, q, forces, tangential, a.size)
            depths = [t.overlap(part, f) for t, part, f in zip(a.touches, conditions.parts, each, strict=True)]
            deep = tuple(depth if depth > tolerance * a.size else 0.0 for depth in depths)
            energy = a.energy(q)
            return State(
                level, q, each, tuple(gaps), reactions, energy, nit, residual, penetration, end, stresses, deep
            )
    raise UnstableError(f"Newton's iterations did not settle in {whole_steps or MOST_ITERATIONS} steps.")


def _newton_step(
    stage: Stage,
    q: Array,
    K: sp.csr_matrix,
    rest: Array,
    jump: Array,
    conditions: Conditions,
    slip: Slips,
    near: IntArray,
    guess: tuple[Array, Array, Array],
    floats: bool,
) -> tuple[Array, Array, Array, Array]:
    """Change of the free coordinates beside the jump of supports, contact forces, those along T, stresses of hubs.

    The guess has forces of all conditions, those along their rows of slip, and stresses. Contact and hubs take the
    symmetric part of the tangent of loads that follow.
    """
    a, Z, of_loads = stage.assembly, stage.assembly.free, stage.load_tangent(q)
    if of_loads is not None and (a.touches or a.hubs is not None):
        of_loads = sp.csr_matrix((of_loads + of_loads.T) / 2)
    for less in (of_loads, a.curvature(conditions, guess[0])):
        K = K if less is None else a.constants.lessened(K, less)
    weight = 0.0
    if a.hubs is not None:
        less, weight = a.hubs.less(K, q, guess[2])
        K = a.constants.lessened(K, less)
    r = Z.T @ (rest - K @ jump if jump.any() else rest)
    free, order = a.constants.reduced(K)
    if not a.touches and a.hubs is None:
        if of_loads is None or is_symmetric(free):
            return *contact_step(free, r, conditions.G @ Z, conditions.gap, order=order), guess[2]
        return unsymmetric_step(free, r), np.zeros(0), np.zeros(0), guess[2]
    G = conditions.G[near]
    rows = slip.rows(near, Z, jump, *guess[:2]) if len(slip.slip) else None
    gap, G_free = conditions.gap[near] + G @ jump, sp.csr_matrix(G @ Z)
    if a.hubs is None:
        loose = free_motions(a, q) if floats else None
        return *contact_step(free, r, G_free, gap, guess[0][near] > 0, rows, loose, order), guess[2]
    ties = a.hubs.ties(q).along(Z, jump)
    change, forces, dragging, stresses = tied_step(free, r, G_free, gap, ties, rows, order)
    return change, forces, dragging, stresses + weight * a.hub_strains(q)


def _of_contact(a: Assembly, conditions: Conditions, slip: Slips, forces: Array, tangential: Array) -> Array:
    """Generalised forces (n_dofs,) of contact and friction."""
    if not a.touches:
        return np.zeros(a.n_dofs)
    return np.asarray(conditions.G.T @ forces + slip.T.T @ tangential)


def _of_hubs(a: Assembly, q: Array, stresses: Array) -> Array | float:
    """Generalised forces (n_dofs,) by the stresses of rigid hubs; none without any."""
    return 0.0 if a.hubs is None else np.asarray(a.hubs.derivative(q).T @ stresses)


def _largest(a: Assembly, forces: Array) -> float:
    """Largest generalised force, in units of force."""
    return float(np.abs(forces / a.lengths).max(initial=0.0))
