"""Scene: bodies, contacts and loads, reduced to one complementarity problem on the candidate contact points.

    minimise 1/2 l^T S l + g^T l   subject to   l >= 0,  B l = F
    S = sum_b C_b K_b^+ C_b^T,   g = gaps + sum_b C_b (K_b^+ f_b + prescribed motions),   B = [R_b^T C_b^T]

`Scene.solve` goes: pair - choose candidates - condense - solve - look for penetration outside - perhaps grow, again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, SolverError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.condensed_problem import assemble
from fecontact.contact.coupling.choose import matrix_free, paired_contact, well_coupled
from fecontact.contact.dimension import check_contacts, setting_of
from fecontact.contact.equilibrium import check_balance, check_rest
from fecontact.contact.interface import Interface, Rows
from fecontact.contact.loads import Loading, make_loading
from fecontact.contact.search.candidates import FEWEST, approach_for_load, choose, grow, widen
from fecontact.contact.search.radius import Reach
from fecontact.contact.springs import Spring, spring_rows
from fecontact.fem.support import is_plane
from fecontact.results.result import ContactResult, make_result
from fecontact.scene.finite_rotation import follow, solve_finite
from fecontact.scene.local_search import Settings, solve_partly
from fecontact.solvers import TOLERANCE, InfeasibleLoadError, solve
from fecontact.surfaces.section_curve import CurveSurface

#: Largest number of times the candidates are enlarged before the search is given up.
MOST_ROUNDS = 12
#: Share of the elastic displacement that may bridge a gap, up to which points are first candidates after the drift.
LIKELY = 0.4
#: Penetration outside the candidates that is taken for rounding, relative to the largest displacement of the surfaces.
OUTSIDE_TOLERANCE = 1e-9
#: Names of solvers that need products with the compliance only.
MATRIX_FREE = ("auto", "projected-cg")


@dataclass(frozen=True, eq=False)
class Contact:
    """Two surfaces that may touch, the slave first.

    Contact pressures live on the slave. Where its faces lie inside the master's faces (equal or nested meshes) forces
    on its nodes are exact; elsewhere mortar coupling takes over, whichever side is the slave.

    Parameters
    ----------
    slave, master : Body
    surfaces : (str, str), optional
        Names of their surfaces; may be left out where a body has declared only one.
    swap : {'auto', 'never'}
        Whether sides may be swapped where faces do not match: mortar coupling wants the coarser side as slave, nodal
        forces the finer one.
    coupling : {'auto', 'nodal', 'mortar'}
        'nodal': forces on slave nodes; 'mortar': non-negative pressure shapes and weighted gaps over the exact overlap;
        'auto': nodal where faces match or nest and on rigid surfaces, mortar elsewhere.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="bottom", supports={"top": "xyz"})
    >>> fc.Contact(body, fc.RigidBody(fc.Plane())).surfaces
    ('bottom', 'surface')
    """

    slave: Body
    master: Body
    surfaces: tuple[str, str] | None = None
    swap: str = "auto"
    coupling: str = "auto"

    def __post_init__(self) -> None:
        if self.coupling not in ("auto", "nodal", "mortar"):
            raise InputError(f"coupling must be 'auto', 'nodal' or 'mortar'; found {self.coupling!r}.")
        if self.swap not in ("auto", "never"):
            raise InputError(f"swap must be 'auto' or 'never'; found {self.swap!r}.")
        if self.slave is self.master:
            raise InputError(f"{self.slave.name!r} cannot be in contact with itself; give two bodies.")
        if self.surfaces is None:
            for body in (self.slave, self.master):
                if len(body.contact) != 1:
                    raise InputError(
                        f"{body.name!r} declares {len(body.contact)} contact surfaces "
                        f"({', '.join(body.contact) or 'none'}); say which: Contact(..., surfaces=(slave, master))."
                    )
            object.__setattr__(self, "surfaces", (self.slave.contact[0], self.master.contact[0]))
        elif len(self.surfaces) != 2:
            raise InputError(f"surfaces must be a pair of names, the slave's first; found {self.surfaces!r}.")
        assert self.surfaces is not None
        self.slave.surface(self.surfaces[0])
        self.master.surface(self.surfaces[1])


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies and the contacts between them.

    Parameters
    ----------
    bodies : sequence of Body
    contacts : sequence of Contact
    springs : sequence of Spring, optional
        Springs and ligaments.

    Raises
    ------
    InputError
        Bodies named twice or missing, no contact.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    >>> result = scene.solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]), 12)
    0.01
    """

    bodies: Sequence[Body]
    contacts: Sequence[Contact]
    springs: Sequence[Spring] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "bodies", tuple(self.bodies))
        object.__setattr__(self, "contacts", tuple(self.contacts))
        object.__setattr__(self, "springs", tuple(self.springs))
        if not self.contacts and not self.springs:
            raise InputError("A scene needs at least one Contact or Spring.")
        if len({id(b) for b in self.bodies}) != len(self.bodies):
            raise InputError("A body is listed twice; use body.placed(...) to stand the same model in two places.")
        setting = setting_of(self.bodies)
        for contact in self.contacts:
            for body in (contact.slave, contact.master):
                if not any(body is b for b in self.bodies):
                    raise InputError(
                        f"{body.name!r} is in a contact but not among the scene's bodies (compared by identity)."
                    )
        check_contacts(self.contacts)
        for spring in self.springs:
            setting.check_spring(spring)
            for owner, _ in (spring.start, spring.end):
                if owner is not None and not any(owner is b for b in self.bodies):
                    raise InputError(
                        f"{owner.name!r}, to which {spring.name!r} is tied, is not among the scene's bodies."
                    )

    @cached_property
    def _interfaces(self) -> tuple[Interface, ...]:
        return tuple(paired_contact(c) for c in self.contacts)

    def solve(
        self,
        forces: Mapping[object, ArrayLike] | None = None,
        *,
        moments: Mapping[Body, ArrayLike] | None = None,
        motions: Mapping[Body, Mapping[str, float]] | None = None,
        free: Mapping[Body, str] | None = None,
        pressures: Mapping[tuple[Body, str], float] | None = None,
        gravity: ArrayLike | None = None,
        finite_motion: bool | str = "auto",
        solver: str = "auto",
        tolerance: float = TOLERANCE,
        whole: bool = True,
        **options: object,
    ) -> ContactResult:
        """Solve the frictionless contact problem.

        Parameters
        ----------
        forces : mapping, optional
            Force (3,) in world axes on a body as a whole, on one of its boundaries with the key
            ``(body, "boundary")``, spread evenly over it, or at a point of its own axes with ``(body, (x, y, z))``: a
            node, or any point of the frame that its supports stand for. A force on the body as a whole moves the frame
            along itself, across it the frame is held; a component that no contact resists is refused. At a point of a
            rigid body a force acts as through a ball joint: the body also turns about the point.
        moments : mapping of Body to (3,), optional
            About the body's reference point (its centre of mass).
        motions : mapping of Body to {component: value}, optional
            Prescribed rigid components out of x, y, z, rx, ry, rz.
        free : mapping of Body to str, optional
            Components to release although supports resist them, such as ``"rx ry"``.
        pressures : mapping of (Body, boundary) to float, optional
            Pressures against boundaries.
        gravity : (3,), optional
            Acceleration; bodies need densities.
        finite_motion : {'auto', True, False}
            Whether bodies move and turn far. True: poses are carried along until they settle, and prescribed motions
            are finite (rotation vectors). False: motions are small and linearised. 'auto': poses are carried along
            where linearised motions would change gaps or lines of action by more than 1e-3 of the approach, until
            they do no more (see `linearisation`).
        solver : str
            'auto' or one of `available_solvers()`.
        tolerance : float
            Of the certificate, see `solvers.Residuals`.
        whole : bool
            Whether the whole surfaces are paired. Otherwise only what can come near enough to touch is, which takes a
            fraction of the time and gives the same forces (see `contact.search.region`); gaps elsewhere are not known.
        **options
            Passed to the solver.

        Returns
        -------
        ContactResult

        Raises
        ------
        InputError, SupportError, SolverError
            With what was found, what was expected and what to do.
        """
        settings = Settings(solver, tolerance, options)
        settings.check()
        if finite_motion not in (True, False, "auto"):
            raise InputError(f"finite_motion must be 'auto', True or False; found {finite_motion!r}.")
        loads = {"forces": forces, "moments": moments, "motions": motions, "free": free, "pressures": pressures}
        arguments = {
            **loads, "gravity": gravity, "solver": solver, "tolerance": tolerance, "whole": whole, **options,
        }  # fmt: skip
        if finite_motion is True:
            return solve_finite(self, arguments)
        watch = Stopwatch()
        loading = make_loading(self.bodies, forces, moments, motions, free, pressures, gravity)
        result = self.solved(loading, None, settings, watch) if whole else solve_partly(self, loading, settings, watch)
        return check_rest(follow(result, arguments) if finite_motion == "auto" else result)

    def solved(
        self, loading: Loading, reaches: Sequence[Reach | None] | None, settings: Settings, watch: Stopwatch
    ) -> ContactResult:
        """Solution under sorted loads with the surfaces paired up to the given reaches; None: all of them."""
        solver, tolerance, options = settings.solver, settings.tolerance, settings.options
        with watch("pair"):
            interfaces, opening, chosen = self.prepared(loading, reaches)
            check_balance(interfaces, loading)
        start: NDArray[np.bool_] | None = None
        dense = solver not in MATRIX_FREE
        rounds = 0
        while True:
            rounds += 1
            reduction = assemble(self.bodies, interfaces, chosen, loading, watch, dense)
            try:
                with watch("solve"):
                    solution = solve(reduction.problem, solver, start=start, tolerance=tolerance, **options)
            except InfeasibleLoadError:
                # all pairs together balance the load, the candidates alone do not: there are too few of them
                wider = [widen(c, o) for c, o in zip(chosen, opening, strict=True)]
                if rounds == MOST_ROUNDS or all(len(w) == len(c) for w, c in zip(wider, chosen, strict=True)):
                    raise
                chosen, start = wider, None
                continue
            except SolverError:
                if not reduction.by_products:
                    raise
                dense = True  # conjugate gradients did not do; the exact solvers want an array
                continue
            with watch("certify"):
                state = reduction.state(solution)
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
        return make_result(self, interfaces, chosen, loading, reduction, solution, state, watch, rounds)

    def sweep(
        self,
        cases: Sequence[Mapping[str, Any]],
        path: str | Path | None = None,
        processes: int = 1,
        executor: Executor | None = None,
    ) -> list[dict[str, Any]]:
        """Solve many load cases and poses with one condensation; see `fecontact.scene.sweep.run_sweep`."""
        from fecontact.scene.sweep import run_sweep

        return run_sweep(self, cases, path, processes, executor)

    def prepared(
        self, loading: Loading, reaches: Sequence[Reach | None] | None = None
    ) -> tuple[list[Rows], list[Array], list[IntArray]]:
        """Conditions of the problem, their gaps after the prescribed motions, and the first candidates of each.

        `reaches` says for each contact up to where its surfaces are paired; None: all of them.
        """
        if reaches is None:
            paired = self._interfaces
        else:
            paired = tuple(paired_contact(c, r) for c, r in zip(self.contacts, reaches, strict=True))
        conditions: list[Rows] = []
        opening, chosen = [], []
        for interface, contact in zip(paired, self.contacts, strict=True):
            near = _first_choice(interface, interface.opening_by(loading.frames), loading)
            coupled = well_coupled(interface, near, contact)
            conditions.append(coupled)
            opening.append(coupled.opening_by(loading.frames))
            chosen.append(_candidates(coupled, opening[-1], loading))
        if not self.springs and all(matrix_free(i) for i in paired):
            chosen = [np.arange(len(gap)) for gap in opening]
        if self.springs:
            ligaments = spring_rows(self.springs)
            conditions.append(ligaments)
            opening.append(ligaments.opening_by(loading.frames))
            chosen.append(np.arange(len(ligaments.gap)))
        return conditions, opening, chosen


def _candidates(interface: Interface, opening: Array, loading: Loading) -> IntArray:
    """First candidates; where the drift is known, the points that it leaves near, as far as they are condensed onto."""
    reach = interface.reach
    first = _first_choice(interface, opening, loading)
    if reach is None or reach.drift is None or interface.pairing.coupling != "mortar":
        return first
    drift = reach.drift_in(interface.slave.pose).at(interface.slave_nodes)
    near = np.flatnonzero(interface.gap + interface.slave_rows @ drift.ravel() <= LIKELY * reach.elastic)
    ready = np.ones(len(near), bool)
    for body in (interface.slave, interface.master):
        rows = interface.rows(body)
        if isinstance(body, ElasticBody) and body.model is not None and rows is not None:
            ready &= body.model.has_condensed(rows[near])
    return near[ready] if ready.all() and len(near) >= FEWEST else np.union1d(first, near[ready])


def _first_choice(interface: Interface, opening: Array, loading: Loading) -> IntArray:
    """Candidates from the gap, the prescribed motions and the size of the loads."""
    approach = max(0.0, -float(opening.min()))
    force = loading.magnitude
    if force > 0:
        compliances = [1 / b.contact_modulus for b in (interface.slave, interface.master)]
        if sum(compliances) > 0:
            images = _mirror_images(interface, opening)
            area = images * interface.pairing.weights
            surface = interface.slave.surface(interface.surfaces[0])
            thickness = surface.along.thickness if isinstance(surface, CurveSurface) else None
            scale = approach_for_load(opening - opening.min(), area, 1 / sum(compliances), images * force, thickness)
            approach = max(approach, scale)
    return choose(opening, approach)


def _mirror_images(interface: Interface, opening: Array) -> int:
    """How many times the modelled part stands for the whole, guessed to judge the load against the area.

    A boundary held in one component only that passes through the point nearest contact is taken for a plane of
    symmetry. A wrong guess costs time, never accuracy.
    """
    supports = getattr(interface.slave, "supports", {})
    nearest = interface.pairing.nodes[np.argmin(opening)]
    planes = [name for name, support in supports.items() if is_plane(support)]
    return 2 ** sum(nearest in interface.slave.mesh.boundary_nodes(name) for name in planes)  # type: ignore[attr-defined]


def _outside(chosen: IntArray, gaps: Array, scale: float) -> NDArray[np.bool_]:
    """Pairs that are no candidates and penetrate."""
    penetrating = gaps < -OUTSIDE_TOLERANCE * scale
    penetrating[chosen] = False
    return penetrating


def _warm_start(before: list[IntArray], after: list[IntArray], active: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The active set of smaller candidate sets on larger ones."""
    ends = np.cumsum([0] + [len(b) for b in before])
    parts = [np.isin(a, b[active[s:e]]) for a, b, s, e in zip(after, before, ends[:-1], ends[1:], strict=True)]
    return np.concatenate(parts)
