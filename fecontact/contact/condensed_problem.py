"""Complementarity problem of bodies and contacts, the balance of its loads, and the displacements of its solution."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, aslinearoperator

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SupportError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.hold import Hold, held, held_inside, semidefinite
from fecontact.contact.interface import UnilateralConstraints
from fecontact.contact.loads import Loading, mass_weighted
from fecontact.contact.rigid_motion import RigidMotionConstraints
from fecontact.fem.condensation import Compliance
from fecontact.fem.multigrid import JointCompliance
from fecontact.fem.stiffness import symmetric_product
from fecontact.solvers import ContactProblem
from fecontact.solvers.problem import formed

#: Share of the largest opening by a unit motion up to which contacts do not resist a motion (flat facets from files
#: have seven digits), and share of a load allowed in such a motion.
UNRESISTED, SWALLOWED = 1e-6, 1e-5


def opening_by_motions(rows: sp.csr_matrix, modes: Array, rounding: float) -> Array:
    """Opening (n, k) by rigid motions with fields (n_dofs, k), with rounding set to zero, see `Loading.rounding`.

    A motion without opening is usually a combination of components, such as sliding along an oblique plane. Singular
    vectors find it in any axes, so that the result does not change with a rotation of the scene.
    """
    opening = np.asarray(rows @ modes)
    if not opening.any():
        return opening
    largest = abs(rows).sum(axis=1).max() * np.abs(modes).max(axis=0)
    largest[largest == 0] = 1.0
    n, m = opening.shape
    _, singular, Vt = np.linalg.svd(np.linalg.qr(opening / largest, mode="r"))
    none = np.concatenate([singular, np.zeros(m - len(singular))]) < rounding * np.sqrt(n)
    if none.any():
        opening -= ((opening / largest) @ Vt[none].T) @ Vt[none] * largest
    opening[np.abs(opening) < rounding * largest] = 0.0
    return opening


def check_balance(interfaces: Sequence[UnilateralConstraints], loading: Loading) -> None:
    """Refuse loads that no contact forces can balance, before anything is condensed.

    By Farkas' lemma either B l = F has a solution l >= 0, or the load does work along a rigid motion that closes no
    gap; non-negative least squares finds one or the other.

    Raises
    ------
    SupportError
        Describes the motion, and says whether forces at single points, nearer to a rim, would balance the load.
    """
    _check_across(interfaces, loading)
    _, motion = _balanced(interfaces, loading)
    if motion is None:
        return
    hints = [i.infeasibility_hint for i in interfaces]
    found = [None if i.as_contact is None else i.as_contact.pointwise for i in interfaces]
    if any(found):
        single = [one or i for one, i in zip(found, interfaces, strict=True)]
        forces, left = _balanced(single, loading)
        parts = np.split(forces, np.cumsum([(1 + i.two_sided) * len(i.gap) for i in single])[:-1])
        if left is None:
            hints += [i.as_contact.reach_hint(f) for i, f in zip(interfaces, parts, strict=True) if i.as_contact]
    raise unbalanced(motion_texts(motion, loading), hints)


def _balanced(interfaces: Sequence[UnilateralConstraints], loading: Loading) -> tuple[Array, Array | None]:
    """Forces (n,) that balance the load, those of two-sided conditions twice; the motion (m,) that nothing resists.

    None where the load is balanced.
    """
    blocks, load = [], []
    for k, frame in enumerate(loading.frames):
        if frame.free.shape[1] == 0:
            continue
        modes = frame.modes(frame.free)
        parts = [i.rows(frame.body) for i in interfaces]
        columns = []
        for i, r in zip(interfaces, parts, strict=True):
            opening = np.zeros((len(i.gap), modes.shape[1]))
            opening = opening if r is None else opening_by_motions(r, modes, loading.rounding)
            columns += [opening, -opening] if i.two_sided else [opening]
        blocks.append(np.concatenate(columns).T)
        load.append(-loading.driving(k, frame.free))
    F = np.concatenate(load) if blocks else np.zeros(0)
    if not F.any():
        return np.zeros(sum((1 + i.two_sided) * len(i.gap) for i in interfaces)), None
    B = np.concatenate(blocks)
    scale = np.abs(B).max(axis=1, initial=0.0)
    # a zero row is compared with the others, in their units
    scale[scale == 0] = scale.max() or 1.0
    B, F = B / scale[:, None], F / scale
    forces, rest = scipy.optimize.nnls(B, F, maxiter=50 * sum(B.shape))
    return forces, None if rest <= 1e-8 * np.linalg.norm(F) else (B @ forces - F) / scale


def motion_texts(direction: Array, loading: Loading) -> list[str]:
    """A motion (m,) of the free rigid components, body by body in words."""
    texts, start = [], 0
    for frame in loading.frames:
        part = direction[start : start + frame.free.shape[1]]
        start += len(part)
        arm = np.array([1.0] * 3 + [frame.body.size] * 3)
        motion = frame.free @ part
        if np.linalg.norm(arm * motion) > 1e-6 * np.linalg.norm(direction):
            texts.append(frame.describe(motion))
    return texts


def unbalanced(texts: Sequence[str], hints: Sequence[str]) -> SupportError:
    """Error that describes the motions without resistance."""
    return SupportError(
        "No contact forces can balance the load; it drives a motion that nothing resists - "
        + "; ".join(texts)
        + ". "
        + "".join(hints)
        + "Support the body in that motion, prescribe it with motions=, or change the load."
    )


def _check_across(interfaces: Sequence[UnilateralConstraints], loading: Loading) -> None:
    """Refuse a load on a body as a whole with a component in which no contact resists the body.

    The body moves along the load only and is held across it. On a frictionless floor, a load of 10 sideways and 1
    downwards would thus act like a wedge with a contact force of 101. Across a guide, supports hold. Resistance is
    judged by the contacts' lines of action, so that the result does not change with a rotation of the scene.

    Raises
    ------
    SupportError
        Describes the component as a motion.
    """
    texts = []
    for frame in loading.frames:
        if not frame.load.any():
            continue
        rows = [r for i in interfaces if (r := i.rows(frame.body)) is not None]
        modes = frame.modes(np.eye(6))
        opening = np.concatenate([np.zeros((0, 6)), *(r @ modes for r in rows)])
        for kind, guided in zip((range(3), range(3, 6)), frame.guided, strict=True):
            left = [c for c in kind if c not in frame.prescribed_components]
            if guided or not frame.load[left].any():
                continue
            _, singular, Vt = np.linalg.svd(np.linalg.qr(opening[:, left], mode="r"))
            resisting = int((singular > UNRESISTED * singular.max(initial=0.0)).sum())
            swallowed = Vt[resisting:].T @ (Vt[resisting:] @ frame.load[left])
            # directions of faces are known to `UNRESISTED`, and turn what is free by as much over the least resistance
            slope = singular[resisting - 1] / singular[0] if resisting else 1.0
            share = SWALLOWED + UNRESISTED * (1 / slope - 1)
            if np.linalg.norm(swallowed) > share * np.linalg.norm(frame.load[left]):
                motion = np.zeros(6)
                motion[left] = swallowed
                texts.append(frame.describe(motion))
    if texts:
        raise unbalanced(texts, ())


#: Share of the largest compliance, with pairs scaled to equal size, that counts as rounding: normals are accurate to
#: 1e-10.
NO_COMPLIANCE = 1e-20


@dataclass(frozen=True, eq=False)
class MeanConstraint:
    """A floating body with some rigid motions held by its mean position.

    The constraint force is distributed over the mass and follows from equilibrium, so that the rows C become C (I - R
    m), with m the mass-weighted mean of the held motions R (m R = I).

    Attributes
    ----------
    modes : (n_dofs, j) array
        R, in the body's axes.
    mean : (j, n_dofs) array
        m.
    body : Body
    """

    modes: Array
    mean: Array
    body: Body

    @cached_property
    def answers(self) -> Array:
        """Displacements (n_dofs, j) without rigid motion by the rows of m as loads."""
        rows, forces = sp.csr_matrix((0, self.body.n_dofs)), np.zeros(0)
        return np.stack([self.body.displacement(rows, forces, m) for m in self.mean], axis=1)

    def of_elastic(self, f: Array) -> Array:
        """The mean (j,) of the displacements without rigid motion by forces (n_dofs,) and what holds the body.

        By Betti's theorem, so that it is the one in the compliance. The mean of a local body's nodes is another, up to
        the error of the mesh: they do not integrate the field of its contact.
        """
        return np.asarray(self.answers.T @ self.balanced(f))

    def balanced(self, f: Array) -> Array:
        """Loads (n_dofs,) plus the distributed forces that hold the body against them."""
        return f - self.mean.T @ (self.modes.T @ f)


def _mean_hold(body: Body, frame: RigidMotionConstraints) -> MeanConstraint | None:
    if frame.mean_held.shape[1] == 0:
        return None
    modes = frame.modes(frame.mean_held)
    weighted = mass_weighted(frame, frame.mean_held)
    mean = np.asarray(np.linalg.solve(modes.T @ weighted, weighted.T), dtype=np.float64)
    return MeanConstraint(modes, mean, body)


@compact_repr
@dataclass(frozen=True, eq=False)
class BodyBlock:
    """Rows and rigid motions of one body in the problem; `loads` (n_dofs,) has the forces of imposed displacements."""

    body: Body
    frame: RigidMotionConstraints
    rows: sp.csr_matrix
    index: IntArray
    loads: Array | None
    free: Array
    hold: MeanConstraint | None

    @property
    def external(self) -> Array:
        """Loads (n_dofs,) without forces inside: of finite strain, imposed displacements and temperatures."""
        inner, loads = self.body._inner_forces, np.zeros(self.body.n_dofs) if self.loads is None else self.loads
        loads = loads if inner is None else loads + inner
        loads = loads if self.frame.heated is None else loads - self.frame.heated.forces
        return loads if self.frame.imposed is None else loads - _resisting(self.body, self.frame.imposed)

    def answer(self, forces: Array) -> Array:
        """Displacements (n_dofs,) by forces along its rows alone, up to a rigid motion."""
        loads = None
        if self.hold is not None:
            f = self.rows.T @ forces
            loads = self.hold.balanced(f) - f
        return self.body.displacement(self.rows, forces, loads)


@compact_repr
@dataclass(frozen=True, eq=False)
class DisplacementState:
    """Displacements and gaps of a solution.

    Attributes
    ----------
    displacements : tuple of (n_dofs,) arrays
        Displacements of each body in its axes, including rigid motion.
    motions : tuple of (6,) arrays
        Rigid motion of each body's frame in world axes (for floating components: see `ContactResult.rigid_motion`).
    gaps : tuple of (n_pairs,) arrays
        Gap of all pairs of each contact.
    scale : float
        Largest displacement, the scale of penetration.
    """

    displacements: tuple[Array, ...]
    motions: tuple[Array, ...]
    gaps: tuple[Array, ...]
    scale: float


@compact_repr
@dataclass(frozen=True, eq=False)
class CondensedProblem:
    """The condensed problem, and the data to recover displacements.

    Attributes
    ----------
    problem : ContactProblem
    parts : tuple of BodyBlock
        One for each body.
    interfaces : tuple of Interface
    by_products : bool
        Whether the compliance of an elastic body is an operator only.
    held_motions : function of forces (n,), optional
        Free motions (m,) of a problem whose closed points are held, see `contact.hold`; None elsewhere.
    pulled : function of motions (m,), optional
        Forces (n,) of the springs inside held bodies, by their gaps without deformation.
    bare : Uncondensed, optional
        The problem before any solve with a stiffness.
    closed : (n,) bool array, optional
        Rows that were known to stay closed or to stick, see `Hold`.
    """

    problem: ContactProblem
    parts: tuple[BodyBlock, ...]
    interfaces: tuple[UnilateralConstraints, ...]
    by_products: bool = False
    held_motions: Callable[[Array], Array] | None = None
    pulled: Callable[[Array], Array] | None = None
    bare: Uncondensed | None = None
    closed: Mask | None = None

    def state(self, forces: Array, motions: Array) -> DisplacementState:
        """Displacements of all bodies and gaps of all pairs, candidates or not, by forces (n,) and motions (m,)."""
        if self.held_motions is not None:
            motions = self.held_motions(forces)
        if self.pulled is not None:
            forces = forces - self.pulled(motions)
        displacements, found = [], []
        start = 0
        for part in self.parts:
            q = motions[start : start + part.free.shape[1]]
            start += part.free.shape[1]
            u, motion = _displacement(part, forces[part.index], q)
            displacements.append(u)
            found.append(motion)
        gaps = []
        scale = max((float(np.abs(u).max(initial=0.0)) for u in displacements), default=0.0)
        for interface in self.interfaces:
            change = np.zeros(len(interface.gap))
            for part, u in zip(self.parts, displacements, strict=True):
                rows = interface.rows(part.body)
                if rows is not None:
                    change += rows @ u
            gaps.append(interface.gap + change)
        return DisplacementState(tuple(displacements), tuple(found), tuple(gaps), scale)


def _displacement(part: BodyBlock, forces: Array, q: Array) -> tuple[Array, Array]:
    frame, loads = part.frame, part.loads
    if part.hold is not None:
        f = part.rows.T @ forces + (0.0 if loads is None else loads)
        loads = part.hold.balanced(f) - part.rows.T @ forces
    u = part.body.displacement(part.rows, forces, loads)
    motion = frame.prescribed + frame.free @ q
    u = u + frame.modes(motion[:, None])[:, 0]
    u = u if frame.imposed is None else u + frame.imposed
    if part.hold is not None:
        correction = part.hold.mean @ frame.modes((frame.prescribed - motion)[:, None])[:, 0] - part.hold.of_elastic(f)
        u = u + part.hold.modes @ correction
        motion = motion + frame.mean_held @ correction
    return u, motion


def assemble(
    bodies: Sequence[Body],
    interfaces: Sequence[UnilateralConstraints],
    chosen: Sequence[IntArray],
    loading: Loading,
    timer: Stopwatch,
    dense: bool = False,
    hold: Hold | None = None,
) -> CondensedProblem:
    """Condense every body onto the chosen pairs and sum.

    Parameters
    ----------
    chosen : sequence of int arrays
        Candidate pairs of each interface.
    dense : bool
        Whether the compliance of elastic bodies must be an array, for a direct solver.
    hold : Hold, optional
        Closed points, for bodies at a state that may not be stable by themselves.
    """
    _condense_shared(bodies, interfaces, chosen, timer)
    bare = uncondensed(bodies, interfaces, chosen, loading)
    rows = np.zeros(len(bare.g), bool) if hold is None else hold.rows(interfaces, chosen)
    alone = _alone(bare, rows)
    stiffness = _turning(bare.parts, () if hold is None or not rows.any() else hold.turns)
    turns = np.any(stiffness)
    S: Array | LinearOperator | None = None
    if not (alone and hold is not None and (hold.at_once or turns)):
        for part in bare.parts:
            if part.body._inner_forces is not None:
                part.body._stiffen(part.rows[:0])
        S, response, by_products, unstable = _condensed(bare, dense, timer, hold is not None)
        if not unstable and not turns:
            problem = ContactProblem(S, bare.g + response, bare.B, bare.F)
            return CondensedProblem(problem, tuple(bare.parts), tuple(interfaces), by_products, bare=bare, closed=rows)
    springs = np.zeros(len(rows))
    if alone:
        for part in bare.parts:
            own = rows[part.index]
            if part.body._inner_forces is not None and own.any():
                springs[part.index[own]] = part.body._stiffen(part.rows[own])
        S, response, by_products, _ = _condensed(bare, True, timer)
        with timer("condense"):
            found = held_inside(cast(Array, S), bare.g, response, bare.B, bare.F, springs, stiffness)
    else:
        with timer("condense"):
            found = held(cast(Array, S), bare.g + response, bare.B, bare.F, rows, stiffness)
    problem = ContactProblem(found.S, found.g, found.B, found.F)
    return CondensedProblem(
        problem, tuple(bare.parts), tuple(interfaces), by_products, found.motions,
        lambda q: np.asarray(springs * (bare.g + bare.B.T @ q)), bare, rows,
    )  # fmt: skip


def _turning(parts: Sequence[BodyBlock], turns: Sequence[Array]) -> Array | float:
    """Stiffness (m, m) of the free motions by that (3, 3) of the bodies' rotations; zero without any."""
    if not turns:
        return 0.0
    each = zip(parts, turns, strict=True)
    return np.asarray(scipy.linalg.block_diag(*(part.free[3:].T @ turn @ part.free[3:] for part, turn in each)))


def _alone(bare: Uncondensed, rows: Mask) -> bool:
    """Whether on each held row (n,) only one body deforms: one at a state, whose mean position is not held."""
    deforming, at_state = np.zeros(len(rows)), np.zeros(len(rows), bool)
    for part in bare.parts:
        deforming[part.index] += not part.body.is_rigid
        at_state[part.index] |= part.hold is None and part.body._inner_forces is not None
    return bool(rows.any() and ((deforming == 1) & at_state & (bare.own == 0))[rows].all())


def _condensed(
    bare: Uncondensed, dense: bool, timer: Stopwatch, at_state: bool = False
) -> tuple[Array | LinearOperator, Array, bool, bool]:
    """Compliance, response (n,) to the loads, whether a body's compliance is an operator only, whether it is unstable.

    That is, of bodies at a state, an array that is not positive semidefinite.
    """
    soft: list[Any] = []
    shares: list[tuple[IntArray, Array | LinearOperator]] = []
    total, by_products, unstable = np.zeros(len(bare.g)), False, False
    for part in bare.parts:
        reduced = part.body.reduce(part.rows, part.loads, timer)
        compliance, response = reduced.compliance, reduced.response
        with timer("condense"):
            if isinstance(compliance, Compliance):
                compliance, by_products = (compliance.dense() if dense else compliance), not dense
            if part.hold is not None:
                assert compliance is not None
                compliance, response = _held_by_mean(part, part.hold, compliance, response)
            if compliance is not None:
                shares.append((part.index, compliance))
                soft += [] if part.body._inner_forces is None else [compliance]
            total[part.index] += response
    _refuse_rigid_pairs(bare, [index for index, _ in shares])
    with timer("condense"):
        S = _total(bare.own, shares)
        array = S if isinstance(S, np.ndarray) else None
        if at_state and array is None and not all(map(semidefinite, soft)):
            S = array = np.asarray(S @ np.eye(len(bare.g)))  # springs on closed gaps need its rows
        if array is not None:
            S = array = _drop_rounding(array, bare.parts)
            unstable = at_state and not semidefinite(array)
    return S, total, by_products, unstable


@dataclass(frozen=True, eq=False)
class Uncondensed:
    """The problem before any solve with a stiffness.

    Attributes
    ----------
    parts : list of BodyBlock
    own : (n,) array
        Compliance of the constraints themselves (springs).
    g : (n,) array
        Gaps after the prescribed motions, without the elastic response to loads.
    B : (m, n) array
    F : (m,) array
    """

    parts: list[BodyBlock]
    own: Array
    g: Array
    B: Array
    F: Array


def uncondensed(
    bodies: Sequence[Body], interfaces: Sequence[UnilateralConstraints], chosen: Sequence[IntArray], loading: Loading
) -> Uncondensed:
    """Rows, gaps and equilibrium of the chosen pairs."""
    ends = np.cumsum([0] + [len(c) for c in chosen])
    n = int(ends[-1])
    own = np.concatenate([i.own_compliance[c] for i, c in zip(interfaces, chosen, strict=True)])
    g = np.concatenate([i.gap[c] for i, c in zip(interfaces, chosen, strict=True)])
    parts, B, F = [], [], []
    for k, (body, frame) in enumerate(zip(bodies, loading.frames, strict=True)):
        part = _part(body, frame, interfaces, chosen, ends, loading.distributed[k])
        columns = np.zeros((part.free.shape[1], n))
        columns[:, part.index] = opening_by_motions(part.rows, frame.modes(part.free), loading.rounding).T
        given = frame.given
        g[part.index] += 0.0 if given is None else part.rows @ given
        B.append(columns)
        F.append(-loading.driving(k, part.free))
        parts.append(part)
    return Uncondensed(parts, own, g, np.concatenate(B), np.concatenate(F))


def _refuse_rigid_pairs(bare: Uncondensed, deforming: Sequence[IntArray]) -> None:
    """Refuse pairs of two bodies neither of which deforms, as both are held at all their nodes.

    Raises
    ------
    InputError
    """
    rigid = bare.own == 0
    rigid[np.concatenate([np.zeros(0, np.int64), *deforming])] = False
    if rigid.any():
        names = [repr(part.body.name) for part in bare.parts if rigid[part.index].any()]
        raise InputError(
            f"Neither of the bodies {' and '.join(names)} can deform where they touch: what is held at all its nodes "
            "is rigid. Leave nodes of one of them free.",
            code="all-held",
        )


def _total(own: Array, shares: Sequence[tuple[IntArray, Array | LinearOperator]]) -> Array | LinearOperator:
    """Sum of the bodies' compliances on their rows: a matrix, or an operator where one of them is."""
    n = len(own)
    if len(shares) == 1 and len(shares[0][0]) == n and not own.any():
        return shares[0][1]
    if len(shares) > 1 or own.any():
        shares = [(index, formed(compliance)) for index, compliance in shares]
    if not any(isinstance(compliance, LinearOperator) for _, compliance in shares):
        S = np.diag(own)
        for index, compliance in shares:
            S[(...,) if len(index) == n else np.ix_(index, index)] += compliance
        return S
    together = None if own.any() else JointCompliance.of(n, shares)
    if together is not None:
        return together

    if (both := _cell_on_cell(shares)) is not None and len(shares[0][0]) == n and not own.any():
        return both

    def product(x: Array) -> Array:
        out = own * np.ravel(x)
        for index, compliance in shares:
            out[index] += compliance @ np.ravel(x)[index]
        return out

    return LinearOperator((n, n), matvec=product, dtype=float)


def _cell_on_cell(shares: Sequence[tuple[IntArray, Array | LinearOperator]]) -> LinearOperator | None:
    """The compliance of two bodies whose cells lie on each other; None for others."""
    if len(shares) != 2 or not np.array_equal(shares[0][0], shares[1][0]):
        return None
    one, two = (compliance for _, compliance in shares)
    plus = getattr(one, "plus", None)  # operators of cells know how
    return None if plus is None else cast(LinearOperator | None, plus(two))


def _drop_rounding(S: Array, parts: Sequence[BodyBlock]) -> Array:
    """The matrix with compliances of pairs that are rounding set to zero; itself where none is.

    Where a node is held along its normal, rounding of a rotated normal leaves 1e-32 of the compliance across the
    normal. Solvers scale pairs by their compliance: such a pair would get the weight of 1e16 others.
    """
    sizes = np.zeros(len(S))
    for part in parts:
        sizes[part.index] += np.asarray(part.rows.multiply(part.rows).sum(axis=1)).ravel()
    given = np.divide(np.abs(S.diagonal()), sizes, out=np.zeros(len(S)), where=sizes > 0)
    none = given < NO_COMPLIANCE * given.max(initial=0.0)
    if none.any():
        S = S.copy()
        S[none] = 0.0
        S[:, none] = 0.0
    return S


def _condense_shared(
    bodies: Sequence[Body], interfaces: Sequence[UnilateralConstraints], chosen: Sequence[IntArray], timer: Stopwatch
) -> None:
    """Condense a model used in several poses once, onto the candidates of all poses together."""
    shared: dict[int, list[sp.csr_matrix]] = {}
    models = {}
    for body in elastic_among(bodies):
        if body.model.all_held:
            continue
        models[id(body.model)] = body.model
        for interface, c in zip(interfaces, chosen, strict=True):
            rows = interface.rows(body)
            if rows is not None:
                shared.setdefault(id(body.model), []).append(rows[c])
    for key, lists in shared.items():
        if len(lists) > 1:
            both = sp.vstack(lists, format="csr")
            models[key].condensed(models[key].touched(both), timer, rows=models[key].solved_rows(both))


def _part(
    body: Body,
    frame: RigidMotionConstraints,
    interfaces: Sequence[UnilateralConstraints],
    chosen: Sequence[IntArray],
    ends: IntArray,
    loads: Array | None,
) -> BodyBlock:
    rows, index = [sp.csr_matrix((0, body.n_dofs))], [np.zeros(0, dtype=np.int64)]
    for interface, c, start in zip(interfaces, chosen, ends[:-1], strict=True):
        own = interface.rows(body)
        if own is not None:
            rows.append(own[c])
            index.append(start + np.arange(len(c)))
    hold = _mean_hold(body, frame)
    if frame.imposed is not None:
        if hold is not None:
            raise InputError(
                f"{body.name!r} is held by its mean position in a motion that no support resists; with displacements "
                "prescribed for its supports it needs supports against every motion.",
                code="imposed-on-floating",
            )
        loads = _resisting(body, frame.imposed) + (0.0 if loads is None else loads)
    released = frame.free
    if hold is not None and released.shape[1]:
        # make the free motions independent of the held mean
        released = released - frame.mean_held @ (hold.mean @ frame.modes(released))
    return BodyBlock(body, frame, sp.vstack(rows, format="csr"), np.concatenate(index), loads, released, hold)


def _resisting(body: Body, imposed: Array) -> Array:
    """Nodal forces (n_dofs,) against imposed displacements: -K u, at finite strain by the tangent K."""
    (elastic,) = elastic_among([body])
    return -symmetric_product(elastic.model.stiffness, imposed)


def _held_by_mean(
    part: BodyBlock, hold: MeanConstraint, compliance: Array | LinearOperator, response: Array
) -> tuple[Array | LinearOperator, Array]:
    """Compliance of the rows C (I - R m) and their response to loads balanced by the held mean."""
    rows = part.rows
    CR, CX, mX = rows @ hold.modes, rows @ hold.answers, hold.mean @ hold.answers
    if part.loads is not None:
        u = part.body.displacement(rows, np.zeros(rows.shape[0]), hold.balanced(part.loads))
        response = rows @ u - CR @ (hold.mean @ u)
    # the change is of low rank: L M L^T
    L = np.concatenate([CR, CX], axis=1)
    zero, one = np.zeros_like(mX), np.eye(len(mX))
    M = np.block([[(mX + mX.T) / 2, -one], [-one, zero]])
    if isinstance(compliance, LinearOperator):
        return compliance + aslinearoperator(L) @ aslinearoperator(M @ L.T), response
    compliance = compliance + L @ M @ L.T
    return (compliance + compliance.T) / 2, response
