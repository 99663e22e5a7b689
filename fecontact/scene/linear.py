"""Small motion: bodies, contacts and loads reduced to one complementarity problem on the candidate contact points.

    minimise 1/2 l^T S l + g^T l   subject to   l >= 0,  B l = F
    S = sum_b C_b K_b^+ C_b^T,   g = gaps + sum_b C_b (K_b^+ f_b + prescribed motions),   B = [R_b^T C_b^T]

Steps: pair, choose candidates, condense, solve, check for penetration outside the candidates, enlarge these if needed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import SolverError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.condensed_problem import assemble
from fecontact.contact.coupling.choose import build_interface, matrix_free
from fecontact.contact.equilibrium import check_balance
from fecontact.contact.first_candidates import KnownContact, first_candidates
from fecontact.contact.interface import UnilateralConstraints
from fecontact.contact.loads import Loading
from fecontact.contact.model import SceneModel
from fecontact.contact.search.candidates import FEWEST, grow, widen
from fecontact.contact.search.radius import SearchRadius
from fecontact.contact.springs import spring_rows
from fecontact.results.result import ContactResult, make_result
from fecontact.scene.settings import Settings
from fecontact.solvers import InfeasibleLoadError, solve

#: Largest number of enlargements of the candidates.
MOST_ROUNDS = 12
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
) -> ContactResult:
    """Solution under sorted loads.

    Parameters
    ----------
    model, loading, settings, timer
    search_radii : sequence of SearchRadius or None
        Search radius of each contact; None: whole surfaces.
    known : sequence of KnownContact or None, optional
        Data of each contact from a similar case; they save time and do not change the solution.
    """
    solver, tolerance, options = settings.solver, settings.tolerance, settings.options
    with timer("pair"):
        interfaces, opening, chosen = prepared(model, loading, search_radii)
        check_balance(interfaces, loading)
        chosen, start = _from_known(interfaces, chosen, known)
    dense = solver not in MATRIX_FREE
    rounds = 0
    while True:
        rounds += 1
        condensed = assemble(model.bodies, interfaces, chosen, loading, timer, dense)
        try:
            with timer("solve"):
                solution = solve(condensed.problem, solver, start=start, tolerance=tolerance, **options)
        except InfeasibleLoadError:
            # all pairs together can balance the load, the candidates cannot: there are too few
            wider = [widen(c, o) for c, o in zip(chosen, opening, strict=True)]
            if rounds == MOST_ROUNDS or all(len(w) == len(c) for w, c in zip(wider, chosen, strict=True)):
                raise
            chosen, start = wider, None
            continue
        except SolverError:
            if not condensed.by_products:
                raise
            dense = True  # CG failed; direct solvers need a dense S
            continue
        with timer("certify"):
            state = condensed.state(solution)
            penetrating = [_outside(c, w, state.scale) for c, w in zip(chosen, state.gaps, strict=True)]
        if not any(p.any() for p in penetrating):
            break
        before = chosen
        chosen = [grow(c, o, p) if p.any() else c for c, o, p in zip(chosen, opening, penetrating, strict=True)]
        start = _warm_start(before, chosen, solution.active)
        if rounds == MOST_ROUNDS:
            raise SolverError(
                f"The candidates still grew after {MOST_ROUNDS} rounds; the contact does not settle. "
                "Check the loads and the initial gap."
            )
    return make_result(model, interfaces, chosen, loading, condensed, solution, state, timer, rounds)


def prepared(
    model: SceneModel, loading: Loading, search_radii: Sequence[SearchRadius | None] | None = None
) -> tuple[list[UnilateralConstraints], list[Array], list[IntArray]]:
    """Conditions of the problem, their gaps after the prescribed motions, and the first candidates of each.

    `search_radii` are the search radii of the contacts; None: whole surfaces.
    """
    if search_radii is None:
        paired = model.interfaces(loading)
    else:
        both = zip(model.contacts, search_radii, strict=True)
        paired = tuple(build_interface(contact, loading, radius) for contact, radius in both)
    conditions: list[UnilateralConstraints] = list(paired)
    opening = [interface.opening_by(loading.frames) for interface in paired]
    chosen = [first_candidates(i, o, loading) for i, o in zip(paired, opening, strict=True)]
    if not model.springs and all(matrix_free(i) for i in paired):
        chosen = [np.arange(len(gap)) for gap in opening]
    if model.springs:
        ligaments = spring_rows(model.springs)
        conditions.append(ligaments)
        opening.append(ligaments.opening_by(loading.frames))
        chosen.append(np.arange(len(ligaments.gap)))
    return conditions, opening, chosen


def _from_known(
    conditions: Sequence[UnilateralConstraints], chosen: list[IntArray], known: Sequence[KnownContact | None]
) -> tuple[list[IntArray], Mask | None]:
    """First candidates and their active set from a similar case; the given ones where it has none."""
    if not any(known):
        return chosen, None
    start = [np.zeros(len(c), bool) for c in chosen]
    for k, (condition, tells) in enumerate(zip(conditions, known, strict=False)):
        contact = condition.as_contact
        if contact is not None and tells is not None:
            found = tells.candidates(contact)
            if len(found) >= FEWEST:
                chosen[k], start[k] = found, tells.touching(contact, found)
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
