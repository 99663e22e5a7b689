"""Time integration of bodies in contact, step by step: generalised-alpha, and an energy-momentum scheme.

Both solve one contact problem per iteration, like statics, with the mass added to the tangent.

**Generalised-alpha** (Chung & Hulbert 1993, in the form of M. Arnold & O. Bruls, Convergence of the generalized-alpha
scheme for constrained mechanical systems, Multibody Syst. Dyn. 18, 2007): second order, unconditionally stable for
linear systems, high frequencies damped by `rho` per step. Contact is imposed at the end of each step, g(q1) >= 0, and
its part of the acceleration is integrated separately and fully implicitly, so that it never adds energy (C. Kane, E. A.
Repetto, M. Ortiz & J. E. Marsden, Comput. Methods Appl. Mech. Engrg. 180, 1999); within the weighted accelerations
contact forces would persist after the impact, and the energy would grow.

**Energy-momentum**: mid-point rule with conserving elastic forces (`AncfSolid.forces_between`) and contact as a
persistency condition (T. A. Laursen & V. Chawla, Int. J. Numer. Methods Eng. 40, 1997): a condition violated at the
beginning of a step may carry a force, l >= 0, while its gap does not close further, g1 - g0 >= 0, l (g1 - g0) = 0. No
work is done, and energy and momentum are conserved to the tolerance of the iterations; penetrations reach the motion of
one step.

**Friction** obeys Coulomb's law with the slip of the step, so that its work is never positive and what sticks does not
move; where points stop, velocities jump (`stopping`).

The factor of the tangent is reused over the iterations of a step while they contract (modified Newton).
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, field, replace
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.system.assembly import Assembly
from fecontact.ancf.system.memory import Lapse
from fecontact.ancf.system.newton import Ties, newton_step, stable_step
from fecontact.ancf.system.slip import Slips, SlipStart, slips, stopped
from fecontact.ancf.system.stage import Stage, StageAt, Start, rate
from fecontact.ancf.system.tangent import Tangent, UnstableError
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError

#: Contraction of the iterations below which the tangent is kept, and the smaller tolerance of changes by a kept one.
CONTRACTION, OLD = 0.1, 1e-3


@dataclass
class ModifiedNewton:
    """Tangent of the free coordinates; without contact its factor is reused as long as the iterations contract.

    Attributes
    ----------
    tangent : Tangent or None
    last : float
        Largest change of the last iteration.
    fresh, again : bool
        Whether the factor may be used in the next iteration; whether it has been used before.
    stresses : (6 n_hubs,) array
        Multipliers of rigid hubs.
    weight : float
        Of their equations in the tangent.
    """

    tangent: Tangent | None = None
    last: float = np.inf
    fresh: bool = False
    again: bool = False
    stresses: Array = field(default_factory=lambda: np.zeros(0))
    weight: float = 0.0

    def reusable(self, near: IntArray) -> bool:
        """Whether no new tangent is needed."""
        self.again = self.fresh and not len(near)
        return self.again

    def refactor(
        self, a: Assembly, K: sp.csr_matrix, other: sp.csr_matrix | None, near: IntArray, q: Array, share: float
    ) -> None:
        """Take the tangent K (n_dofs, n_dofs) less another matrix, with a share of the second derivative of hubs."""
        K = a.constants.minus(K, other)
        if a.hubs is not None:
            stresses = self.stresses if len(self.stresses) else np.zeros(6 * len(a.rigid))
            of_hubs, self.weight = a.hubs.subtracted(K, q, stresses, share)
            K = a.constants.minus(K, of_hubs)
        self.tangent = a.constants.reduced(K)
        self.fresh = self.tangent.order is not None and not len(near)

    def step(
        self, a: Assembly, rest: Array, G: sp.csr_matrix, gap: Array, near: IntArray, slip: Slips,
        guess: tuple[Array, Array], ties: Ties | None,
    ) -> tuple[Array, Array, Array]:  # fmt: skip
        """Change of all coordinates, the forces of all conditions and those along the rows of slip."""
        assert self.tangent is not None
        Z, still = a.free, np.zeros(a.n_dofs)
        along = None if ties is None else ties.along(Z, still)
        rows = slip.rows(G, gap, near, Z, still, guess)
        # what walls hold, as a liquid, may be stable through its active contacts only
        step = (
            stable_step(self.tangent, Z.T @ rest, rows)
            if along is None
            else newton_step(self.tangent, Z.T @ rest, rows, ties=along)
        )
        if ties is not None:
            self.stresses = step.stresses + self.weight * ties.value
        return Z @ step.change, *slip.spread(near, step.forces, len(gap))

    def by_hubs(self, ties: Ties | None) -> Array | float:
        """Generalised forces (n_dofs,) of rigid hubs."""
        return 0.0 if ties is None else np.asarray(ties.columns.T @ self.stresses)

    def unbalanced(self, a: Assembly, change: Array, *forces: Array) -> float:
        """Largest force out of balance before a change (n_dofs,), over the largest of some forces (n_dofs,)."""
        assert self.tangent is not None
        rest = a.free @ (self.tangent.K @ (a.free.T @ change))
        return a.largest_force(rest) / max(np.finfo(float).tiny, *map(a.largest_force, forces))

    def tolerance(self, a: Assembly, change: Array, tolerance: float) -> float:
        """Tolerance of this change, smaller where an old tangent makes the error one of the first order."""
        size = a.largest_change(change)
        self.fresh = self.fresh and size <= CONTRACTION * self.last
        self.last = size
        return tolerance * (OLD if self.again else 1.0)


MAX_ITERATIONS = 25
#: Change of a coordinate, relative to the size of the bodies, that counts as rounding.
ROUNDING = 1e-14
#: Change of a coordinate in one iteration, relative to the size of the bodies, from which iterations have run away.
RUNAWAY = 1e6
#: Conditions with a gap above this multiple of their width are left out of a step.
REACH = 1.0
#: Share of a step from whose length the velocity of prescribed motions is differenced.
RATE = 1e-2


@dataclass(frozen=True, eq=False)
class Instant:
    """State of motion.

    Attributes
    ----------
    time : float
    q, v, a : (n_dofs,) arrays
        Coordinates, velocities, accelerations.
    b : (n_dofs,) array
        The auxiliary acceleration of generalised-alpha.
    forces : (n_multipliers,) array
        Contact forces at the end of the step (generalised-alpha) or over it (energy-momentum).
    applied : (n_dofs,) array
        Loads and support forces.
    work : float
        Work from the start of all loads, of supports that move, and of rigid bodies that move.
    memory : (n,) array
        Of the members, see `system.memory`.
    tangential, residual_slip, slip : (n_multipliers, 3) arrays
        Forces of friction, slip that is left to the next step, see `slip`, and slip in this one.
    friction_work : float
        Work of friction from the start.
    viscous_work, stored : float
        Energy lost to viscosity and plastic flow from the start, and that of branches.
    nit : int
        Number of iterations of the step.
    residuals : (7,) array
        Those of `Residuals` in the step, in their order; zero where there is no friction.
    """

    time: float
    q: Array
    v: Array
    a: Array
    b: Array
    forces: Array
    applied: Array
    memory: Array
    tangential: Array
    residual_slip: Array
    slip: Array
    work: float = 0.0
    viscous_work: float = 0.0
    stored: float = 0.0
    friction_work: float = 0.0
    nit: int = 0
    residuals: Array = field(default_factory=lambda: np.zeros(7))

    @property
    def begin(self) -> Start:
        """A motion that goes on from here."""
        return Start(self.q, self.v, self.forces, self.time, self.memory, self.stored)

    def after(
        self, h: float, lapse: Lapse, q: Array, v: Array, a: Array, b: Array, forces: Array, applied: Array,
        work: float, nit: int,
    ) -> Instant:  # fmt: skip
        """The state at the end of a step of length h, without what friction adds."""
        return Instant(
            self.time + h, q, v, a, b, forces, applied, lapse.memory, self.tangential, self.residual_slip,
            self.slip, work, self.viscous_work + lapse.lost, lapse.stored, self.friction_work, nit,
        )  # fmt: skip


class Scheme(Protocol):
    """A time integration scheme."""

    def step(self, at: StageAt, begin: Stage, now: Instant, h: float, tolerance: float) -> tuple[Instant, Stage]:
        """State and stage after a step of length h, from the stage now, of what is there and acts at every time."""

    def error(self, before: Instant, after: Instant, h: float) -> float:
        """Estimate of the largest local error of a coordinate."""


@dataclass(frozen=True)
class GeneralisedAlpha:
    """Generalised-alpha.

    Parameters
    ----------
    rho : float
        Amplitude factor of the highest frequencies per step, from 0 to 1; 1 does not damp.
    """

    rho: float = 0.8

    def __post_init__(self) -> None:
        if not 0 <= self.rho <= 1:
            raise InputError(f"rho must lie between 0 and 1; found {self.rho!r}.", code="rho-range")

    @property
    def constants(self) -> tuple[float, float, float, float]:
        """alpha_m, alpha_f, beta, gamma."""
        am, af = (2 * self.rho - 1) / (self.rho + 1), self.rho / (self.rho + 1)
        return am, af, (1 - am + af) ** 2 / 4, 0.5 - am + af

    def step(self, at: StageAt, begin: Stage, now: Instant, h: float, tolerance: float) -> tuple[Instant, Stage]:
        """One step; the prescribed motion of supports is integrated like any other coordinate."""
        end = at(now.time + h).remembering(now.memory)
        a = end.assembly
        if not _same_supports(begin.assembly, a):  # accelerations jump
            anew = a.accelerated(end.load(now.q) - a.forces(now.q), now.q, now.v)
            now = replace(now, a=anew, b=anew)
        am, af, beta, gamma = self.constants
        inertia = (1 - am) / ((1 - af) * beta * h**2)
        # contact changes q by h^2/2 c and v by h c, with M c = G^T l: the tangent scales it accordingly
        share = inertia * h**2 / 2
        c, forces = _accelerated_by_contact(begin.assembly, now), now.forces
        q = now.q + h * now.v + h**2 / 2 * (now.b + c)
        q = q + end.jump(q)
        kept, since = ModifiedNewton(), _since(begin.assembly, now)
        tangential = now.tangential
        for nit in range(1, MAX_ITERATIONS + 1):
            b = (q - now.q - h * now.v - h**2 / 2 * c) / (beta * h**2) - (0.5 / beta - 1) * now.b
            acceleration = ((1 - am) * b + am * now.b - af * now.a) / (1 - af)
            conditions = a.conditions(q)
            lapse = a.lapse(now.q, q, h)
            balance = end.load(q), a.forces(q) + lapse.forces, a.mass @ acceleration
            rest = balance[0] - balance[1] - balance[2] - share * (a.mass @ c)
            near = np.flatnonzero(conditions.gap < REACH * a.widths)
            if not kept.reusable(near):
                K = a.constants.with_mass(a.step_tangent(q, h, 1.0), inertia)
                less = _sum(end.load_tangent(q), 1.0, a.curvature(conditions, share * forces))
                kept.refactor(a, K, less, near, q, 1.0)
            slip = slips(a.constraints, conditions.parts, q, since)
            guess = share * forces, share * slip.of(tangential)
            ties = None if a.hubs is None else a.hubs.ties(q)
            change, pressing, dragging = kept.step(a, rest, conditions.G, conditions.gap, near, slip, guess, ties)
            forces, t = pressing / share, dragging / share
            tangential = slip.everywhere(t, len(forces))
            c = a.accelerated(conditions.G.T @ forces + slip.T.T @ t, q) if len(near) else np.zeros_like(q)
            q = q + change
            if _settled(a, change, q - now.q, kept.tolerance(a, change, tolerance)):
                b = (q - now.q - h * now.v - h**2 / 2 * c) / (beta * h**2) - (0.5 / beta - 1) * now.b
                acceleration = ((1 - am) * b + am * now.b - af * now.a) / (1 - af)
                v = now.v + h * ((1 - gamma) * now.b + gamma * b) + h * c
                applied = acting(end, q, acceleration, lapse.forces - kept.by_hubs(ties))
                work = now.work + float((now.applied + applied) @ (q - now.q)) / 2 + _by_tools(begin, end, q, forces)
                after = now.after(h, lapse, q, v, acceleration, b, forces, applied, work, nit)
                gap = conditions.gap + conditions.G @ change
                unbalanced = kept.unbalanced(a, change, *balance)
                return _judged(a, now, after, gap, slip.moved(change), t, unbalanced, h), end
        raise UnstableError(f"The step from t = {now.time:.6g} of length {h:.3g} did not settle.")

    def error(self, before: Instant, after: Instant, h: float) -> float:
        """h^2 |beta - 1/6| |b1 - b0| (O. C. Zienkiewicz & Y. M. Xie, Earthquake Eng. Struct. Dyn. 20, 1991)."""
        return float(abs(self.constants[2] - 1 / 6) * h**2 * np.abs(after.b - before.b).max())


@dataclass(frozen=True)
class EnergyMomentum:
    """Mid-point rule that conserves energy and momentum."""

    def step(self, at: StageAt, begin: Stage, now: Instant, h: float, tolerance: float) -> tuple[Instant, Stage]:
        """One step, with loads of its middle; supported coordinates have the velocity of their prescribed motion."""
        half, end = (at(now.time + x).remembering(now.memory) for x in (h / 2, h))
        a = end.assembly
        q = now.q + h * now.v
        q, driven = q + end.jump(q), rate(at, end, now.time + h, RATE * h)
        before = begin.assembly.conditions(now.q)
        halfway, kept = half.assembly if _moved(begin, end) else None, ModifiedNewton()
        since, forces, tangential = _since(begin.assembly, now), now.forces, now.tangential
        for nit in range(1, MAX_ITERATIONS + 1):
            middle = (now.q + q) / 2
            internal = np.concatenate(
                [s.forces_between(a.part(now.q, k), a.part(q, k)) for k, s in enumerate(half.assembly.solids)]
            )
            lapse = a.lapse(now.q, q, h)
            internal = internal + lapse.forces
            load, v = half.load(middle), 2 / h * (q - now.q) - now.v
            v = v - a.held(v) + driven
            inertia = a.mass @ ((v - now.v) / h)
            after = a.conditions(q)
            # a condition that was pressed by the start state is active, too
            active = (before.gap < 0) | (now.forces > 0)
            pressing = np.flatnonzero(active & np.isfinite(after.gap) & np.isfinite(before.gap))
            closing = np.where(np.isfinite(after.gap), after.gap, 0.0) - np.where(active, before.gap, 0.0)
            G, done, parts = after.G, closing, after.parts
            if len(pressing):
                conditions = (halfway or a).conditions(middle)
                G, parts = conditions.G, conditions.parts
                if halfway is not None:
                    done = _finite(halfway.conditions(q).gap) - _finite(halfway.conditions(now.q).gap)
            G = _working(a, G, pressing, done, q - now.q)
            if not kept.reusable(pressing):
                K = a.constants.with_mass(a.step_tangent(middle, h, 0.5), 2 / h**2)
                kept.refactor(a, K, _sum(half.load_tangent(middle), 0.5, None), pressing, q, 0.5)
            slip = slips(a.constraints, parts, q, since)
            guess = forces, slip.of(tangential)
            ties = None if a.hubs is None else a.hubs.ties(q, middle)
            change, forces, t = kept.step(a, load - internal - inertia, G, closing, pressing, slip, guess, ties)
            tangential = slip.everywhere(t, len(forces))
            moved = q - now.q
            q = q + change
            if _settled(a, change, q - now.q, kept.tolerance(a, change, tolerance)):
                v = 2 / h * (q - now.q) - now.v
                v = v - a.held(v) + driven
                contact = G.T @ forces + slip.T.T @ t + kept.by_hubs(ties)
                supports = a.held(internal - load - contact), a.held(inertia)
                work = load @ (q - now.q) + supports[0] @ moved + h / 2 * supports[1] @ (v + now.v)
                work += float(forces @ done) if halfway is not None else 0.0
                applied = load + supports[0] + supports[1]
                acceleration = (v - now.v) / h
                end_of_step = now.after(
                    h, lapse, q, v, acceleration, acceleration, forces, applied, now.work + float(work), nit
                )
                gap = np.where(np.isin(np.arange(len(closing)), pressing), closing + G @ change, np.inf)
                unbalanced = kept.unbalanced(a, change, load, internal, inertia)
                return _judged(a, now, end_of_step, gap, slip.moved(change), t, unbalanced, h), end
        raise UnstableError(f"The step from t = {now.time:.6g} of length {h:.3g} did not settle.")

    def error(self, before: Instant, after: Instant, h: float) -> float:
        """h^2 |a1 - a0| / 12, the leading term of the mid-point rule."""
        return float(h**2 / 12 * np.abs(after.a - before.a).max())


def acting(stage: Stage, q: Array, acceleration: Array, viscous: Array | float = 0.0) -> Array:
    """Loads and support forces (n_dofs,) at coordinates q, without contact, beside viscous forces (n_dofs,)."""
    a, load = stage.assembly, stage.load(q)
    return np.asarray(load + a.held(a.mass @ acceleration + a.forces(q) + viscous - load))


def _sum(of_loads: sp.csr_matrix | None, share: float, curvature: sp.csr_matrix | None) -> sp.csr_matrix | None:
    """What is subtracted from the tangent: a share of the loads' symmetric part, and the contacts' curvature."""
    if of_loads is None:
        return curvature
    L = share / 2 * (of_loads + of_loads.T)
    return L if curvature is None else L + curvature


def _moved(begin: Stage, end: Stage) -> bool:
    """Whether rigid bodies have moved."""
    pairs = zip(begin.assembly.constraints, end.assembly.constraints, strict=True)
    return any(one.master is not other.master for one, other in pairs)


def _same_supports(one: Assembly, other: Assembly) -> bool:
    """Whether both leave the same directions free."""
    A, B = one.free, other.free
    if A is B:
        return True
    return A.shape == B.shape and np.array_equal(A.indices, B.indices) and np.array_equal(A.data, B.data)


def _finite(gap: Array) -> Array:
    return np.where(np.isfinite(gap), gap, 0.0)


def _accelerated_by_contact(a: Assembly, now: Instant) -> Array:
    """Accelerations (n_dofs,) by the contact forces of a state; what is at rest is predicted to stay there."""
    if not now.forces.any():
        return np.zeros_like(now.q)
    parts = a.conditions(now.q)
    slip = slips(a.constraints, parts.parts, now.q, _since(a, now))
    return a.accelerated(parts.G.T @ now.forces + slip.T.T @ slip.of(now.tangential), now.q)


def _by_tools(begin: Stage, end: Stage, q: Array, forces: Array) -> float:
    """Work of rigid bodies that move in a step: forces times what their motion alone closes the gaps."""
    if not (_moved(begin, end) and forces.any()):
        return 0.0
    gaps = (stage.assembly.conditions(q).gap for stage in (begin, end))
    return float(forces @ np.subtract(*map(_finite, gaps)))


def _since(a: Assembly, now: Instant) -> SlipStart:
    """State from which the slip of a step counts."""
    return SlipStart(now.q, tuple(t.master.pose for t in a.constraints), now.residual_slip)


def _judged(
    a: Assembly, now: Instant, after: Instant, gap: Array, slip: Slips, t: Array, unbalanced: float, h: float
) -> Instant:
    """The end of a step with what friction made of it, and its residuals.

    Parameters
    ----------
    a : Assembly
    now, after : Instant
    gap : (n_multipliers,) array
        Of the conditions of the step: gaps, or their changes.
    slip : Slips
    t : (2 f,) array
        Forces along the slip.
    unbalanced : float
        Relative force out of balance.
    h : float

    Notes
    -----
    Velocities jump where points stop; rigid bodies that move do work by friction, too.
    """
    n = len(after.forces)
    found = slip.residuals(gap, after.forces, t, a.size, unbalanced)
    after = replace(
        after, residual_slip=slip.residual_slip(after.forces, t, slip.slip), tangential=slip.everywhere(t, n),
        slip=slip.everywhere(slip.slip, n), residuals=np.array([x or 0.0 for x in astuple(found)]),
    )  # fmt: skip
    if not t.any():
        return after
    moved = slip.T @ (after.q - now.q)
    v, lost = stopped(a, after.v, slip, after.forces, t, (moved - slip.slip) / h, h)
    friction_work = after.friction_work + lost - float(t @ slip.slip)
    return replace(after, v=v, friction_work=friction_work, work=after.work + float(t @ (moved - slip.slip)))


def _settled(a: Assembly, change: Array, moved: Array, tolerance: float) -> bool:
    """Whether the last change is small compared with the motion of the step, or rounding.

    The residual is the tangent times that change, so it has converged too.

    Raises
    ------
    UnstableError
        If the iterations have run away, long before their numbers overflow.
    """
    largest = a.largest_change(change)
    if not largest <= RUNAWAY * a.size:
        raise UnstableError(
            f"The iterations of a step ran away: a coordinate changed by {largest:.3g}.", code="diverged"
        )
    return largest <= max(tolerance * a.largest_change(moved), ROUNDING * a.size)


def _working(a: Assembly, G: sp.csr_matrix, pressing: IntArray, closing: Array, moved: Array) -> sp.csr_matrix:
    """Gradients of the active conditions whose work is exactly force times change of gap (discrete gradient).

    With d the motion of the step and W the squares of `lengths`, W d (change of gap - G . d) / (d . W d) is added to
    each row. Where a face does not move in the step, the correction (of the order of d) would be rounding over
    rounding; a term added to the denominator makes it vanish. The error of the work is less than force times rounding
    of the gap.
    """
    if not len(pressing):
        return G
    rows = G[pressing].tocoo()
    weighed = (a.lengths**2 * moved)[rows.col]
    size = np.bincount(rows.row, weighed * moved[rows.col], minlength=len(pressing))
    missing = closing[pressing] - G[pressing] @ moved
    share = missing / (size + ROUNDING * a.size**2)
    data = rows.data + share[rows.row] * weighed
    return sp.csr_matrix((data, (pressing[rows.row], rows.col)), shape=G.shape)
