"""Solution of contact problems with Coulomb friction: start, Newton's method, fall-back and certificate.

Examples
--------
A block of unit weight on two points, dragged by 0.5 at mu = 0.3, slides unless it is held:

>>> import numpy as np
>>> B, F = np.array([[1.0, 0.0]]), np.array([1.0])
>>> held = ContactProblem(np.eye(2), np.zeros(2), B, F, np.array([0]), np.array([[1]]), np.array([0.3]))
>>> solution = solve_friction(held)
>>> solution.forces.round(12).tolist(), solution.slip.round(12).tolist()
([1.0, 0.0], [[0.0]])
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.errors import SolverError
from fecontact.solvers.active_set import least_motion
from fecontact.solvers.coulomb import friction_limit, sticks, with_held_directions
from fecontact.solvers.friction_newton import friction_newton, friction_sweeps, stick_solution
from fecontact.solvers.friction_slide import (
    SlidingLoadError,
    driving_load,
    holding_factor,
    least_friction,
    slide,
    sliding_modes,
    unbalanced_motion,
)
from fecontact.solvers.problem import ContactProblem, FrictionOperator, InfeasibleLoadError, Solution, Status
from fecontact.solvers.registry import TOLERANCE, attempt
from fecontact.solvers.scaling import ScaledProblem

ATTEMPTS = 3
"""Times that sweeps are followed by Newton's method, each with ten times sharper sweeps."""

FIRST_STEPS = 50
"""Largest number of Newton steps from the first start."""

LATER_STEPS = 120
"""The same from later ones: thin strips that slide back take up to all of them, in less time than sweeps."""

NEARLY_ROUGH = 10.0
"""Coefficient of friction whose solution is the start for an infinite one."""

MUCH = (1e2, 1e3, 1e4, 1e5)
"""Coefficients by which larger ones are reached, each ten times the last."""

FIRST_SWEEPS = 1e-3
"""Relative change of forces to which the first sweeps converge."""


def solve_friction(
    problem: ContactProblem, start: tuple[Array, Array] | None = None, *, tolerance: float = TOLERANCE
) -> Solution:
    """Certified solution of a contact problem with friction, or an error that says why there is none.

    Parameters
    ----------
    problem : ContactProblem
    start : ((N,), (m,)) arrays, optional
        Forces and motion to begin with, such as those of the last load step.
    tolerance : float
        Largest residual of a certified solution; ten times that for the penetration.

    Returns
    -------
    Solution

    Raises
    ------
    InfeasibleLoadError
        If no forces within the cones balance the load, or all that touches slides under it (`SlidingLoadError`); its
        ``direction`` is the motion, the message has the friction that would hold.
    SolverError
        If no certified solution was found.
    """
    began = time.perf_counter()
    if isinstance(problem.S, FrictionOperator):
        if (own := problem.S.solve_friction(problem, tolerance)) is not None:
            return replace(own, seconds=time.perf_counter() - began)
        problem = replace(problem, S=with_held_directions(problem.S.array(), problem.tangents, problem.B))
    scaled = problem.scaled()
    direction = unbalanced_motion(scaled)
    if direction is not None:
        raise InfeasibleLoadError(_cannot_hold(scaled), direction)
    closed = bool((scaled.g[scaled.normals] < 0).any())
    best: Solution | None = None
    apart: Solution | None = None
    adrift: Solution | None = None
    starts = _starts(problem, scaled, start)
    while (begin := next(starts, None)) is not None:
        scaled, x, p, name = begin
        steps = FIRST_STEPS if best is None else LATER_STEPS
        outcome, orientation = friction_newton(scaled, x, p, max_iterations=steps)
        forces = scaled.forces(_without_rounding(scaled, outcome.x))
        found = Solution(
            problem, forces, scaled.motion(_nearest(scaled, outcome.x, outcome.p)), outcome.status,
            outcome.message, outcome.nit, name, time.perf_counter() - began, tuple(outcome.history),
            orientation=orientation,
        )  # fmt: skip
        nearest = found.residuals.within(tolerance)
        if not nearest:  # what is open would be closed
            found = replace(found, q=scaled.motion(outcome.p))
        if found.residuals.within(tolerance):
            if forces.any() or not closed:
                status = Status.SOLVED if forces.any() else Status.NO_CONTACT
                found = replace(found, status=status, message="solved")
                if nearest or (start is not None and best is None):
                    return found
                # it drifted where nothing that touches resists: the answer only if no rest without that is found
                adrift = adrift or found
                continue
            # what was closed has drifted apart: the answer only if no other is found
            apart = apart or replace(found, status=Status.NO_CONTACT, message="solved")
        if best is None:
            starts = chain(_held(scaled, outcome.x, outcome.p), starts)
        best = found if best is None or found.residuals.worst < best.residuals.worst else best
    for loose in (adrift, apart):
        if loose is not None:
            return loose
    assert best is not None
    raise SolverError(
        f"No certified answer of the problem with friction: {best.message} ({best.residuals}; tolerance "
        f"{tolerance:.0e}). Take smaller load steps; with much friction there may be no solution or several.",
        code="not-certified",
    )


def _without_rounding(scaled: ScaledProblem, x: Array) -> Array:
    """Forces (N,) without those that are rounding; where a point is pressed small tangential ones hold its slip."""
    small = np.abs(x) < scaled.rounding_of(x)
    small[scaled.tangents] &= small[scaled.points][:, None]
    return np.where(small, 0.0, x)


def _held(scaled: ScaledProblem, x: Array, p: Array) -> Iterator[tuple[ScaledProblem, Array, Array, str]]:
    """Start at which a guided motion finds the load held, if any, from forces and motion of a failing attempt.

    Raises
    ------
    SlidingLoadError
        If everything slides under the load.
    """
    load = driving_load(scaled, x[scaled.normals] > 0)
    if load is None or np.isinf(scaled.mu).any():
        return
    before = p
    for found in slide(scaled, load, x, p):
        if found.share >= 1:
            yield scaled, found.x, found.p, "guided, newton"
        elif 0 < found.bound < 1:
            direction = scaled.motion(found.p - before)
            text = (
                "All that touches slides along the motion that the load drives; friction holds "
                f"{found.share:.4g} of that load. {_would_hold(scaled, holding_factor(scaled, found))}"
            )
            forces, motion = scaled.forces(found.x), scaled.motion(found.p)
            raise SlidingLoadError(text, direction / float(np.linalg.norm(direction)), forces, motion)
        before = found.p


def _would_hold(scaled: ScaledProblem, factor: float | None) -> str:
    """Friction that would hold a load, in words."""
    if factor is None:
        return "Reduce the load, or prescribe the motion."
    used = np.unique(scaled.mu[scaled.mu > 0])
    needed = f"mu = {factor * used[0]:.4g}" if len(used) == 1 else f"{factor:.4g} times the friction given"
    return f"It needs about {needed}, or a prescribed motion."


def _starts(
    problem: ContactProblem, scaled: ScaledProblem, start: tuple[Array, Array] | None
) -> Iterator[tuple[ScaledProblem, Array, Array, str]]:
    """Problem, first forces (N,) and motion (r,) in turn, with the method; later ones if those before fail."""
    to_p = np.linalg.pinv(scaled.motion_map)
    if start is not None:
        yield scaled, start[0] / scaled.force_scale, to_p @ start[1], "newton"
    slides = sliding_modes(scaled)
    for modes in (slides, slides[:, :0]) if slides.shape[1] else (slides,):
        # what friction alone can hold is held in the first guess: without friction the body would drift away
        x, p, touching = _pressed(scaled, modes)
        if np.isinf(scaled.mu).any():
            # a rough surface is the limit of much friction
            outcome, _ = friction_newton(replace(scaled, mu=np.minimum(scaled.mu, NEARLY_ROUGH)), x, p)
            yield scaled, outcome.x, outcome.p, "newton"
        elif x.any():
            yield scaled, x, p, "newton"
        without = x, p
        stuck = x, p = stick_solution(scaled, x, p, touching)
        if not modes.shape[1]:
            yield scaled, *stuck, "newton"
        yield from _by_more_friction(scaled, *without)
        # where a body may drift, sweeps come first: in many steps of Newton's method rounding decides where it goes
        for k in range(ATTEMPTS):
            outcome = friction_sweeps(scaled, x, p, tolerance=FIRST_SWEEPS / 10**k)
            x, p = outcome.x, outcome.p
            yield scaled, x, p, "sweeps, newton"
        if modes.shape[1]:
            yield scaled, *stuck, "newton"


def _by_more_friction(scaled: ScaledProblem, x: Array, p: Array) -> Iterator[tuple[ScaledProblem, Array, Array, str]]:
    """Starts by solutions of growing friction, each from forces x (N,) and motion p (r,) without friction or the last.

    What slides under much friction is the first guess of what slides under more.
    """
    first = last = scaled, x, p
    for much in MUCH:
        if not (scaled.mu > much).any():
            return
        for known, *begin in (last, first):
            less = replace(known, mu=np.minimum(scaled.mu, much))
            outcome, _ = friction_newton(less, *begin, max_iterations=FIRST_STEPS)
            if outcome.status is not Status.SOLVED:
                continue
            limit = friction_limit(less.mu, outcome.x[scaled.points])
            slides = (limit > 0) & ~sticks(outcome.x[scaled.tangents].T, limit)
            last = replace(scaled, slides=slides & (scaled.mu > much)), outcome.x, outcome.p
            yield *last, "newton"
            break


def _nearest(scaled: ScaledProblem, x: Array, p: Array) -> Array:
    """The least motion (r,) that is the same as p where points with forces x (N,) touch."""
    touching = (x[scaled.points] > 0) | scaled.slides
    kept = np.concatenate([scaled.normals[x[scaled.normals] > 0], scaled.tangents[touching].ravel()])
    return least_motion(scaled, kept, p)


def _pressed(scaled: ScaledProblem, held: Array) -> tuple[Array, Array, Mask]:
    """Forces (N,) without friction, motion (r,) and what touches (n,), with motions (r, k) held; all, if unsolved."""
    n, x = scaled.normals, np.zeros(scaled.n)
    left = np.linalg.svd(held)[0][:, held.shape[1] :]
    B, F = left.T @ scaled.B[:, n], left.T @ scaled.F
    bare = attempt(ContactProblem(scaled.matrix[np.ix_(n, n)], scaled.g[n], B, F))
    if not bare.success:
        return x, np.zeros(scaled.r), np.ones(len(n), bool)
    x[n] = bare.forces
    return x, left @ bare.q, bare.active


def _cannot_hold(scaled: ScaledProblem) -> str:
    least = least_friction(scaled)
    text = "No contact forces within the cones of friction balance the load: along the motion q the load does work. "
    if np.isinf(least):
        return text + "No friction would hold it: support that motion, or change the load."
    return text + f"It needs at least mu = {least:.3g}, or a support."
