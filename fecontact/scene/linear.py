"""Small motion: bodies, contacts and loads reduced to one complementarity problem on the candidate contact points.

    minimise 1/2 l^T S l + g^T l   subject to   l >= 0,  B l = F
    S = sum_b C_b K_b^+ C_b^T,   g = gaps + sum_b C_b (K_b^+ f_b + prescribed motions),   B = [R_b^T C_b^T]

Steps: pair, choose candidates, condense, solve, check for penetration outside the candidates, enlarge these if needed.

Settings of a solve, checked before any work.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fecontact.common.arguments import mapping
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import among, share
from fecontact.common.errors import InputError, SolverError, SupportError, shown
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.candidates import MIN_CANDIDATES, KnownContact, first_candidates, grow, widen
from fecontact.contact.condensed_problem import CondensedProblem, assemble, check_balance, motion_texts
from fecontact.contact.coupling.choose import build_interface, matrix_free
from fecontact.contact.friction_rows import TangentialRows, friction_problem
from fecontact.contact.hold import Hold
from fecontact.contact.interface import NothingMeets, UnilateralConstraints
from fecontact.contact.loads import Loading
from fecontact.contact.model import SceneModel
from fecontact.contact.search_region import SearchRadius
from fecontact.contact.springs import spring_rows
from fecontact.contact.step_end import StepEnd
from fecontact.results.friction_fields import friction_fields
from fecontact.results.result import ContactResult, make_result
from fecontact.solvers import (
    TOLERANCE,
    CustomSolver,
    InfeasibleLoadError,
    SlidingLoadError,
    Status,
    solve,
    solve_friction,
    validate_options,
)

SEARCHES = ("global", "local")


@dataclass(frozen=True)
class Settings:
    """Settings of a solve, as the arguments of `Scene.solve` of the same names; `options` are the solver's."""

    solver: str | CustomSolver = "auto"
    tolerance: float = TOLERANCE
    options: Mapping[str, Any] = field(default_factory=dict)
    search: str = "global"
    finite_motion: bool | str = "auto"

    def check(self) -> None:
        """Refuse what is out of range before any work.

        Raises
        ------
        InputError
        """
        among("search", self.search, SEARCHES)
        share("the tolerance", self.tolerance)
        validate_options(self.solver, self.options)
        finite = self.finite_motion
        if not isinstance(finite, bool) and not (isinstance(finite, str) and finite == "auto"):
            raise InputError(f"finite_motion must be 'auto', True or False; found {shown(finite)}.", code="motion")


def solver_options(max_iterations: int | None, others: Mapping[str, object] | None) -> dict[str, object]:
    """The solver's options from two arguments of `Scene.solve`."""
    limit = {} if max_iterations is None else {"max_iterations": max_iterations}
    return {**limit, **mapping("options", others)}


#: Largest number of enlargements of the candidates.
MAX_ROUNDS = 12
#: Largest number of times that points of soft contacts change the line of their table.
MAX_LINES = 50
#: Penetration outside the candidates, relative to the largest displacement of the surfaces, that counts as rounding.
OUTSIDE_TOLERANCE = 1e-9
#: Solvers that need products with the compliance only.
MATRIX_FREE = ("auto", "projected-cg")


def solved(
    model: SceneModel,
    loading: Loading,
    search_radii: Sequence[SearchRadius | None] | None,
    settings: Settings,
    timer: Stopwatch,
    known: Sequence[KnownContact | None] = (),
    past: StepEnd | None = None,
    hold: Hold | None = None,
) -> ContactResult:
    """Solution under sorted loads.

    Parameters
    ----------
    model, loading, settings, timer
    search_radii : sequence of SearchRadius or None
        Search radius of each contact; None: whole surfaces.
    known : sequence of KnownContact or None, optional
        Data of each contact from a similar case; they save time and do not change the solution.
    past : StepEnd, optional
        End of the last load step, from which slip is counted; by default the unloaded state in these poses.
    hold : Hold, optional
        Of bodies at a state of finite strain: the closed points of the last iteration.
    """
    solver, tolerance, options = settings.solver, settings.tolerance, settings.options
    with timer("pair"):
        interfaces, opening, chosen = prepared(model, loading, search_radii, past)
        friction = tangential_rows(model, interfaces, past)
        every = [*interfaces, *friction]
        check_balance(every, loading)
        chosen, start = _from_known(interfaces, chosen, known)
        if past is not None:
            chosen = past.candidates(interfaces, chosen)
    dense = solver not in MATRIX_FREE or bool(friction) or hold is not None
    rounds = lines = 0
    while True:
        rounds += 1
        condensed = assemble(model.bodies, every, with_tangents(chosen, friction), loading, timer, dense, hold)
        try:
            with timer("solve"):
                frictional = None
                if friction:
                    problem = friction_problem(condensed.problem, chosen, friction)
                    begin = None if past is None else past.start(chosen, problem.n, problem.m)
                    frictional = solve_friction(problem, begin, tolerance=tolerance)
                    solution = frictional.normal
                else:
                    solution = solve(condensed.problem, solver, start=start, tolerance=tolerance, **options)
        except InfeasibleLoadError as error:
            # all pairs together can balance the load, the candidates cannot: there are too few
            wider = [widen(c, o) for c, o in zip(chosen, opening, strict=True)]
            complete = all(len(w) == len(c) for w, c in zip(wider, chosen, strict=True))
            if rounds == MAX_ROUNDS or complete or _slides_within(error, condensed, chosen):
                if friction:
                    raise slides(error, loading, friction) from error
                raise
            chosen, start = wider, None
            continue
        except SolverError:
            if not condensed.by_products:
                raise
            dense = True  # CG failed; direct solvers need a dense S
            continue
        with timer("certify"):
            state = condensed.state((frictional or solution).forces, solution.q)
            penetrating = [_outside(c, w, state.scale) for c, w in zip(chosen, state.gaps, strict=False)]
        if not any(p.any() for p in penetrating):
            if not (moved := _off_their_lines(interfaces, chosen, solution.forces)):
                break
            lines += 1
            if lines == MAX_LINES:
                raise SolverError(
                    f"Points of a soft contact still changed the lines of its table after {MAX_LINES} rounds; give a "
                    "table with fewer rows or smaller changes of slope.",
                    code="soft-contact-lines",
                )
            interfaces = moved
            friction = tangential_rows(model, interfaces, past)
            every, start = [*interfaces, *friction], solution.active
            continue
        smaller = chosen
        chosen = [grow(c, o, p) if p.any() else c for c, o, p in zip(chosen, opening, penetrating, strict=True)]
        start = _warm_start(smaller, chosen, solution.active)
        if rounds == MAX_ROUNDS:
            raise SolverError(
                f"The candidates still grew after {MAX_ROUNDS} rounds; the contact does not settle. "
                "Check the loads and the initial gap."
            )
    found = model, interfaces, chosen, loading, condensed, solution, state, timer, rounds
    if frictional is None:
        result = make_result(*found, {})
        return certified_tie(result, tolerance) if result._only_tied and hold is None else result
    fields = friction_fields(friction, chosen, frictional, state)
    for each in friction:
        each.check_lay(fields[each.place].touching)
    nodes = [each.interface.pairing.nodes for each in friction]
    end = StepEnd(
        poses=tuple(body.pose for body in model.bodies),
        q=frictional.q,
        forces=frictional.forces,
        chosen=chosen,
        contact=np.repeat([each.place for each in friction], [len(own) for own in nodes]),
        nodes=np.concatenate(nodes),
        displacement=np.concatenate([fields[each.place].moved for each in friction]),
        pressed=np.concatenate([fields[each.place].touching for each in friction]),
        change=np.zeros(sum(map(len, nodes))),
        worn={} if past is None else past.worn,
    )
    return replace(make_result(*found, fields), friction=frictional, _step_end=end)


def certified_tie(result: ContactResult, tolerance: float) -> ContactResult:
    """A result without any condition of contact, whose forces balance on every node.

    Raises
    ------
    SolverError
        If they do not.
    """
    if (off := result.residuals().equilibrium) > tolerance:
        raise SolverError(
            f"Forces on nodes of tied bodies do not balance: {off:.3g} of the largest, tolerance {tolerance:.0e}.",
            code="not-certified",
        )
    solution = replace(result.solution, status=Status.SOLVED, message="forces balance on every node")
    return replace(result, solution=solution)


def prepared(
    model: SceneModel,
    loading: Loading,
    search_radii: Sequence[SearchRadius | None] | None = None,
    past: StepEnd | None = None,
) -> tuple[list[UnilateralConstraints], list[Array], list[IntArray]]:
    """Conditions of the problem, their gaps after the prescribed motions, and the first candidates of each.

    `search_radii` are the search radii of the contacts; None: whole surfaces. Surfaces are worn as at the end of a last
    load step.
    """
    if search_radii is None:
        paired = model.interfaces(loading)
    else:
        both = zip(model.contacts, search_radii, strict=True)
        paired = tuple(build_interface(contact, loading, radius) for contact, radius in both)
    if past is not None:
        paired = tuple(past.worn_shapes(paired))
    conditions: list[UnilateralConstraints] = list(paired)
    opening = [interface.opening_by(loading.frames) for interface in paired]
    each = zip(paired, opening, model.contacts, strict=True)
    chosen = [first_candidates(interface, o, loading, contact.mu > 0) for interface, o, contact in each]
    if not (model.springs or model.has_friction) and all(matrix_free(i) for i in paired):
        chosen = [np.arange(len(gap)) for gap in opening]
    if model.springs:
        ligaments = spring_rows(model.springs)
        conditions.append(ligaments)
        opening.append(ligaments.opening_by(loading.frames))
        chosen.append(np.arange(len(ligaments.gap)))
    if not conditions:
        return [NothingMeets()], [np.ones(1)], [np.zeros(1, np.int64)]
    return conditions, opening, chosen


def tangential_rows(
    model: SceneModel, interfaces: Sequence[UnilateralConstraints], past: StepEnd | None
) -> list[TangentialRows]:
    """Tangential rows of the contacts with friction, with slip counted from the end of the last load step."""
    out = []
    number = {id(body): k for k, body in enumerate(model.bodies)}
    for k, (contact, interface) in enumerate(zip(model.contacts, interfaces, strict=False)):
        paired = interface.as_contact
        wears = past is not None and k in past.worn
        if (contact.mu > 0 or wears) and paired is not None:
            rows = TangentialRows(paired, k, contact.mu, contact.lay)
            if past is not None:
                slave, master = (past.poses[number[id(body)]] for body in (paired.slave, paired.master))
                nodes = paired.pairing.nodes
                moved = paired.pairing.mixed(past.of(k, past.displacement, nodes))
                pressed = past.of(k, past.pressed, nodes)
                rows = replace(rows, since=slave.relative_to(master), moved=moved, pressed=pressed)
            out.append(rows)
    return out


def with_tangents(chosen: Sequence[IntArray], friction: Sequence[TangentialRows]) -> list[IntArray]:
    """Chosen rows of all interfaces, then those of the tangents of chosen points."""
    return [*chosen, *(each.numbers(chosen[each.place]).ravel() for each in friction)]


def _slides_within(error: InfeasibleLoadError, condensed: CondensedProblem, chosen: Sequence[IntArray]) -> bool:
    """Whether a load makes everything slide and no pair beyond the candidates would touch."""
    if not isinstance(error, SlidingLoadError):
        return False
    state = condensed.state(error.forces, error.motion)
    return not any(_outside(c, w, state.scale).any() for c, w in zip(chosen, state.gaps, strict=False))


def slides(error: InfeasibleLoadError, loading: Loading, friction: Sequence[TangentialRows]) -> SupportError:
    """Error that names the motion that friction cannot hold."""
    text = f"{'; '.join(motion_texts(error.direction, loading))}. {error}"
    if any(each.lay is not None for each in friction):
        text += " Of two coefficients mu is the larger one, with their ratio as given."
    return SupportError(text, code="slides-as-a-whole")


def _off_their_lines(
    interfaces: Sequence[UnilateralConstraints], chosen: Sequence[IntArray], forces: Array
) -> list[UnilateralConstraints]:
    """The conditions with points of soft contacts on the lines of their pressures; none where they are on them."""
    out, changed, start = [], False, 0
    for condition, own in zip(interfaces, chosen, strict=True):
        contact, found = condition.as_contact, None
        if contact is not None and contact.overclosure is not None:
            every = np.zeros(len(contact.gap))
            every[own] = forces[start : start + len(own)]
            found = contact.on_lines(every)
        start += len(own)
        changed |= found is not None
        out.append(condition if found is None else found)
    return out if changed else []


def _from_known(
    conditions: Sequence[UnilateralConstraints], chosen: list[IntArray], known: Sequence[KnownContact | None]
) -> tuple[list[IntArray], Mask | None]:
    """First candidates and their active set from a similar case; the given ones where it has none."""
    if not any(known):
        return chosen, None
    start = [np.zeros(len(c), bool) for c in chosen]
    for k, (condition, similar) in enumerate(zip(conditions, known, strict=False)):
        contact = condition.as_contact
        if contact is not None and similar is not None:
            found = similar.candidates(contact)
            if len(found) >= MIN_CANDIDATES:
                chosen[k], start[k] = found, similar.touching(contact, found)
    return chosen, np.concatenate(start)


def _outside(chosen: IntArray, gaps: Array, scale: float) -> Mask:
    """Penetrating pairs that are not candidates."""
    penetrating = gaps < -OUTSIDE_TOLERANCE * scale
    penetrating[chosen] = False
    return penetrating


def _warm_start(before: list[IntArray], after: list[IntArray], active: Mask) -> Mask:
    """Active set of smaller candidate sets, mapped to larger ones."""
    ends = np.cumsum([0] + [len(b) for b in before])
    parts = [np.isin(a, b[active[s:e]]) for a, b, s, e in zip(after, before, ends[:-1], ends[1:], strict=True)]
    return np.concatenate(parts)
