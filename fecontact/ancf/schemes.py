"""Time integration of bodies in contact, step by step: generalised-alpha, and an energy-momentum scheme.

Both solve one contact problem per iteration, like statics, with the mass added to the tangent.

**Generalised-alpha** (Chung & Hulbert 1993, in the form of M. Arnold & O. Bruls, Convergence of the generalized-alpha
scheme for constrained mechanical systems, Multibody Syst. Dyn. 18, 2007): second order, unconditionally stable for
linear systems, high frequencies damped by `rho` per step. Contact is imposed at the end of each step, g(q1) >= 0, and
its part of the acceleration is integrated separately and fully implicitly, so that it never adds energy (C. Kane, E. A.
Repetto, M. Ortiz & J. E. Marsden, Comput. Methods Appl. Mech. Engrg. 180, 1999); within the weighted accelerations
contact forces would persist after the impact, and the energy would grow.

**Energy-momentum**: mid-point rule with conserving elastic forces (`conserving.forces_between`) and contact as a
persistency condition (T. A. Laursen & V. Chawla, Int. J. Numer. Methods Eng. 40, 1997): a condition violated at the
beginning of a step may carry a force, l >= 0, while its gap does not close further, g1 - g0 >= 0, l (g1 - g0) = 0. No
work is done, and energy and momentum are conserved to the tolerance of the iterations; penetrations reach the motion of
one step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.assembly import Assembly
from fecontact.ancf.newton import UnstableError, contact_step
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError

MOST_ITERATIONS = 25
#: Change of a coordinate, relative to the size of the bodies, that counts as rounding.
ROUNDING = 1e-14
#: Change of a coordinate in one iteration, relative to the size of the bodies, from which iterations have run away.
RUNAWAY = 1e6
#: Conditions with a gap above this multiple of their width are left out of a step.
REACH = 1.0


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
    nit : int
        Number of iterations of the step.
    """

    time: float
    q: Array
    v: Array
    a: Array
    b: Array
    forces: Array
    nit: int = 0


class Scheme(Protocol):
    """A time integration scheme."""

    def step(self, a: Assembly, now: Instant, h: float, load: Array, tolerance: float) -> Instant:
        """State after a step of length h under dead loads (n_dofs,)."""

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
            raise InputError(f"rho must lie between 0 and 1; found {self.rho!r}.")

    @property
    def constants(self) -> tuple[float, float, float, float]:
        """alpha_m, alpha_f, beta, gamma."""
        am, af = (2 * self.rho - 1) / (self.rho + 1), self.rho / (self.rho + 1)
        return am, af, (1 - am + af) ** 2 / 4, 0.5 - am + af

    def step(self, a: Assembly, now: Instant, h: float, load: Array, tolerance: float) -> Instant:
        """One step."""
        am, af, beta, gamma = self.constants
        inertia = (1 - am) / ((1 - af) * beta * h**2)
        # contact changes q by h^2/2 c and v by h c, with M c = G^T l: the tangent scales it accordingly
        share = inertia * h**2 / 2
        q, forces = now.q + h * now.v + h**2 / 2 * now.b, now.forces
        c = np.zeros_like(q)
        for nit in range(1, MOST_ITERATIONS + 1):
            b = (q - now.q - h * now.v - h**2 / 2 * c) / (beta * h**2) - (0.5 / beta - 1) * now.b
            acceleration = ((1 - am) * b + am * now.b - af * now.a) / (1 - af)
            conditions = a.conditions(q)
            bend = a.curvature(conditions, share * forces)
            K = a.tangent(q) + inertia * a.mass
            K = K if bend is None else K - bend
            rest = load - a.forces(q) - a.mass @ acceleration - share * (a.mass @ c)
            near = np.flatnonzero(conditions.gap < REACH * _widths(a))
            change, pressing = _solved(a, K, rest, conditions.G, conditions.gap, near)
            forces = pressing / share
            c = a.accelerated(conditions.G.T @ forces)
            q = q + change
            if _settled(a, change, q - now.q, tolerance):
                b = (q - now.q - h * now.v - h**2 / 2 * c) / (beta * h**2) - (0.5 / beta - 1) * now.b
                acceleration = ((1 - am) * b + am * now.b - af * now.a) / (1 - af)
                v = now.v + h * ((1 - gamma) * now.b + gamma * b) + h * c
                return Instant(now.time + h, q, v, acceleration, b, forces, nit)
        raise UnstableError(f"The step from t = {now.time:.6g} of length {h:.3g} did not settle.")

    def error(self, before: Instant, after: Instant, h: float) -> float:
        """h^2 |beta - 1/6| |b1 - b0| (O. C. Zienkiewicz & Y. M. Xie, Earthquake Eng. Struct. Dyn. 20, 1991)."""
        return float(abs(self.constants[2] - 1 / 6) * h**2 * np.abs(after.b - before.b).max())


@dataclass(frozen=True)
class EnergyMomentum:
    """Mid-point rule that conserves energy and momentum."""

    def step(self, a: Assembly, now: Instant, h: float, load: Array, tolerance: float) -> Instant:
        """One step."""
        q = now.q + h * now.v
        before = a.conditions(now.q)
        for nit in range(1, MOST_ITERATIONS + 1):
            middle = (now.q + q) / 2
            internal = np.concatenate(
                [s.forces_between(a.part(now.q, k), a.part(q, k)) for k, s in enumerate(a.solids)]
            )
            rest = load - internal - a.mass @ (2 / h**2 * (q - now.q - h * now.v))
            K = a.tangent(middle) / 2 + 2 / h**2 * a.mass
            after = a.conditions(q)
            pressing = np.flatnonzero((before.gap < 0) & np.isfinite(after.gap))
            closing = np.where(np.isfinite(after.gap), after.gap, 0.0) - np.where(before.gap < 0, before.gap, 0.0)
            G = a.conditions(middle).G if len(pressing) else after.G
            G = _working(a, G, pressing, closing, q - now.q)
            change, forces = _solved(a, K, rest, G, closing, pressing)
            q = q + change
            if _settled(a, change, q - now.q, tolerance):
                v = 2 / h * (q - now.q) - now.v
                return Instant(now.time + h, q, v, (v - now.v) / h, (v - now.v) / h, forces, nit)
        raise UnstableError(f"The step from t = {now.time:.6g} of length {h:.3g} did not settle.")

    def error(self, before: Instant, after: Instant, h: float) -> float:
        """h^2 |a1 - a0| / 12, the leading term of the mid-point rule."""
        return float(h**2 / 12 * np.abs(after.a - before.a).max())


def _widths(a: Assembly) -> Array:
    return np.sqrt(np.concatenate([t.areas for t in a.touches])) if a.touches else np.zeros(0)


def _solved(
    a: Assembly, K: sp.csr_matrix, rest: Array, G: sp.csr_matrix, gap: Array, near: IntArray
) -> tuple[Array, Array]:
    """Change of all coordinates and the forces of all conditions."""
    Z = a.free
    change, pressing, _ = contact_step(sp.csr_matrix(Z.T @ K @ Z), Z.T @ rest, sp.csr_matrix(G[near] @ Z), gap[near])
    forces = np.zeros(len(gap))
    forces[near] = pressing
    return Z @ change, forces


def _settled(a: Assembly, change: Array, moved: Array, tolerance: float) -> bool:
    """Whether the last change is small compared with the motion of the step, or rounding.

    The residual is the tangent times that change, so it has converged too.

    Raises
    ------
    UnstableError
        If the iterations have run away, long before their numbers overflow.
    """
    largest = float(np.abs(a.lengths * change).max(initial=0.0))
    if not largest <= RUNAWAY * a.size:
        raise UnstableError(f"The iterations of a step ran away: a coordinate changed by {largest:.3g}.")
    return largest <= max(tolerance * float(np.abs(a.lengths * moved).max(initial=0.0)), ROUNDING * a.size)


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
