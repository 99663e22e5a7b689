"""Estimated cost of solving a scene: degrees of freedom, candidates, route of condensation, memory and time.

Points are paired and candidates chosen as in a solve, so these numbers are exact for its first round. Memory and time
are estimates. PARDISO's factor of a solid takes about 220 n^(4/3) bytes and of a section 66 n log2(n) (n unknowns; the
powers are those of nested dissection, George 1973 and Lipton, Rose & Tarjan 1979; the factors were measured on spheres
and blocks of 6,000 to 37,000 unknowns and on sections of 10,000 to 87,000); SuperLU's is about three times as large.
The rest is arrays of known size. Seconds are scaled from a small block that is factorised on this machine.

Whether a local body would serve in the contacts of elastic bodies, in one sentence each.
"""

from __future__ import annotations

import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.local import LocalBody
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.html import cell
from fecontact.common.material import Material
from fecontact.common.stopwatch import Stopwatch, peak_memory
from fecontact.contact.contact import Contact
from fecontact.contact.interface import Interface, UnilateralConstraints
from fecontact.contact.loads import Loading, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.fem.condensation import choose_route, memory_budget
from fecontact.fem.factor import available_backends, has_bordered
from fecontact.fem.model import Model
from fecontact.mesh import shapes
from fecontact.results.convergence import accuracy_text, asked
from fecontact.results.report import modelled
from fecontact.scene.adaptive import GROWTH, SAFETY, Target
from fecontact.scene.engine import advice
from fecontact.scene.linear import prepared
from fecontact.scene.windows import WIDE, window_at_touch

#: Cells along a side of the window that is tried; only its place and its sides matter.
CELLS = 64

#: Faces across a contact with which finite elements alone resolve it to about 1 %.
FINE = 12

FIRST = re.compile(r"\. (?=[A-Z])")


def local_choices(model: SceneModel, loading: Loading) -> tuple[str, ...]:
    """For each contact of elastic bodies in space: whether local bodies serve, and why."""
    return tuple(f"{_sides(contact)}: {_told(contact, loading)}" for contact in model.contacts if _meshed(contact))


def _sides(contact: Contact) -> str:
    assert contact.surfaces is not None
    return f"{contact.slave.name}.{contact.surfaces[0]} on {contact.master.name}.{contact.surfaces[1]}"


def _meshed(contact: Contact) -> tuple[ElasticBody, ...]:
    """Its elastic bodies with displacements at the nodes of a mesh in space."""
    both = elastic_among((contact.slave, contact.master))
    return tuple(b for b in both if not b.mesh.is_flat and b.n_dofs == 3 * len(b.mesh.points))


def _told(contact: Contact, loading: Loading) -> str:
    """The sentence."""
    if contact.mu > 0:
        return "no local body, since it gives along its normal only and this contact has friction."
    try:
        windows = [_window(body, contact, loading) for body in _meshed(contact)]
    except InputError as error:
        # its first sentence; the others advise on local bodies
        return f"no local body, but finite elements with accuracy=: {FIRST.split(str(error))[0].rstrip('.')}."
    return " ".join(windows)


def _window(body: ElasticBody, contact: Contact, loading: Loading) -> str:
    assert contact.surfaces is not None
    turn = 1 if body is contact.slave else -1
    own, other = contact.surfaces[::turn]
    partner = contact.bodies[::turn][1]
    surface = body.surface(own)
    placed = window_at_touch(LocalBody(body, cells=(CELLS, CELLS)), surface, (body, partner), other, loading)
    sides = placed.window.grid.size
    k = np.argmin(np.linalg.norm(surface.points[surface.nodes] - placed.window.origin, axis=1))
    contact_sides = (sides[0] / WIDE, sides[1] / WIDE)
    across = min(contact_sides) / float(surface.mean_facet_size[surface.facets_of_node[k]].mean())
    resolved = "which resolve it too" if across >= FINE else f"of {FINE} or more that are needed without it"
    return (
        f"a local body of {body.name!r} serves: the contact is about {contact_sides[0]:.3g} x {contact_sides[1]:.3g}, "
        f"its window of {sides[0]:.3g} x {sides[1]:.3g} lies within one smooth face, and {across:.2g} faces lie across "
        f"the contact, {resolved}."
    )


#: Bytes of PARDISO's factor per n^(4/3) of a solid, and per n log2(n) of a section; factor for its analysis.
SOLID_FACTOR, SECTION_FACTOR, ANALYSIS = 220.0, 66.0, 1.35
#: Bytes while a stiffness is assembled, per pair of nodes in a cell of a solid, and per entry of one of a section.
PER_PAIR, PER_ENTRY = 490.0, 80.0
#: MB of a loaded factorisation library; size of SuperLU's factor over PARDISO's; bytes of a stored entry.
LIBRARY, SUPERLU, ENTRY = 40.0, 3.0, 12.0
#: Numbers of dense square arrays of retained degrees of freedom, and of candidates, at one time.
DENSE_RETAINED, DENSE_CANDIDATES = 4, 5
#: Error of the pressure times the faces across the contact, of edges inside faces (measured on coarse Hertz contacts);
#: share of the first candidates that come into contact.
FIRST_ERROR, CANDIDATES_IN_CONTACT = {"nodal": 0.5, "mortar": 1.0}, 0.7


@compact_repr
@dataclass(frozen=True)
class ModelCost:
    """Cost of condensing one model.

    Attributes
    ----------
    name : str
        Name of its first body.
    n_unknowns, n_retained : int
        Displacement unknowns of its elements; degrees of freedom retained by the condensation.
    backend : str
    memory_mb, seconds : float
        Estimates.
    """

    name: str
    n_unknowns: int
    n_retained: int
    backend: str
    memory_mb: float
    seconds: float


@compact_repr
@dataclass(frozen=True)
class Explanation:
    """Estimated cost of a solution.

    Attributes
    ----------
    bodies : tuple of str
        One line per body.
    n_dofs : int
        Degrees of freedom of all elastic bodies, as in `ContactResult.n_dofs`.
    n_candidates, n_points : int
        Candidates of the first round; a solution may add more.
    contacts : tuple of str
        Coupling of each contact and its candidates.
    models : tuple of ModelCost
    solver : str
    saved : tuple of str
    memory_mb : float
        Peak memory of the process, including its present use.
    seconds : float
    divisions : str
        With an accuracy: what dividing the meshes may take; empty without one.
    engine : str
        Whether several processes pay off; empty if not.
    local : tuple of str
        Of each contact of elastic bodies in space: whether a local body would serve, and why.
    finite_strain : bool
        Whether the seconds are of one iteration of Newton's method, of which a load step takes mostly 5 to 15.
    """

    bodies: tuple[str, ...]
    n_dofs: int
    n_candidates: int
    n_points: int
    contacts: tuple[str, ...]
    models: tuple[ModelCost, ...]
    solver: str
    saved: tuple[str, ...]
    memory_mb: float
    seconds: float
    divisions: str = ""
    engine: str = ""
    local: tuple[str, ...] = ()
    finite_strain: bool = False

    def as_dict(self) -> dict[str, Any]:
        """All figures, ready for JSON."""
        return asdict(self)

    def _repr_html_(self) -> str:
        return cell(self)

    def __str__(self) -> str:
        lines = [
            *(f"Body:      {text}" for text in self.bodies),
            f"Unknowns:  {self.n_dofs}",
            *(f"Contact:   {text}" for text in self.contacts),
            f"Solver:    {self.solver}",
            *(
                f"Condense:  {m.name}: {m.n_unknowns} unknowns onto {m.n_retained} by {m.backend}; "
                f"about {m.memory_mb:.0f} MB, {m.seconds:.1f} s"
                for m in self.models
            ),
            *(f"Saved:     {text}" for text in self.saved),
            f"Estimate:  about {self.memory_mb:.0f} MB (peak of the process) and {self.seconds:.1f} s"
            + " an iteration of Newton's method, mostly 5 to 15 a load step" * self.finite_strain,
        ]
        lines += [f"Local:     {text}" for text in self.local]
        if self.engine:
            lines.append(f"Engine:    {self.engine}")
        if self.divisions:
            lines.append(f"Accuracy:  {self.divisions}")
        return "\n".join(lines)


def explain(
    scene: SceneModel,
    loads: Mapping[str, Any] | None = None,
    solver: str = "auto",
    accuracy: float | Mapping[str, float] | None = None,
) -> Explanation:
    """Estimate the cost of solving a scene, without assembly or factorisation.

    Parameters
    ----------
    scene : SceneModel
    loads : mapping, optional
        Arguments of `Scene.solve`; those other than loads are ignored.
    solver : str
    accuracy : float or mapping of str to float, optional
        As of `Scene.solve`; the tightest of several.

    Returns
    -------
    Explanation

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.sections.rectangle((1.0, 1.0), (8, 4))
    >>> body = fc.PlaneBody(mesh, fc.Material(E=1.0, nu=0.3), contact="bottom", supports={"top": "xz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    >>> cost = explain(scene, {"motions": {body: {"z": -0.01}}})
    >>> cost.n_dofs, cost.n_candidates
    (242, 17)
    """
    loading = LoadStep.of(loads or {}).on(scene.bodies)
    conditions, _, chosen = prepared(scene, loading)
    elastic = elastic_among(scene.bodies)
    models = _model_costs(elastic, conditions, chosen)
    n = sum(len(c) for c in chosen)
    seconds = sum(m.seconds for m in models)
    n_dofs = sum(b.n_unknowns for b in elastic)
    dense = 0.0 if any(b._matrix_free for b in scene.bodies) else DENSE_CANDIDATES * 8 * n**2 / 1e6
    return Explanation(
        bodies=tuple(b.describe() for b in scene.bodies),
        n_dofs=n_dofs,
        n_candidates=n,
        n_points=sum(len(c.gap) for c in conditions),
        contacts=tuple(
            _coupling(c, len(k)) for i, k in zip(conditions, chosen, strict=True) if (c := i.as_contact) is not None
        ),
        models=models,
        solver=_solver(solver, n, scene),
        saved=tuple(modelled(scene.bodies)),
        memory_mb=peak_memory() + (LIBRARY if models else 0.0) + _peak(models) + dense,
        seconds=seconds,
        divisions="" if accuracy is None else _divisions(conditions, chosen, accuracy, n_dofs, seconds),
        engine=advice(scene, n_dofs, sum(m.memory_mb for m in models)),
        local=local_choices(scene, loading),
        finite_strain=any(b._finite_strain is not None for b in scene.bodies),
    )


def _divisions(
    conditions: Sequence[UnilateralConstraints],
    chosen: Sequence[np.ndarray],
    accuracy: float | Mapping[str, float],
    n_dofs: int,
    seconds: float,
) -> str:
    """What it may take to an accuracy: every division about halves the error, see `FIRST_ERROR` and `GROWTH`."""
    target, error = Target(accuracy), 0.0
    tightest, text = min(asked(target.accuracy).values()), accuracy_text(accuracy)
    for condition, candidates in zip(conditions, chosen, strict=True):
        interface = condition.as_contact
        if interface is not None:
            surface, nodes = interface.slave_surface, interface.pairing.nodes[candidates]
            faces = int(np.isin(surface.facets, nodes).all(axis=1).sum()) * 2 ** interface.slave._planes_through(nodes)
            across = np.sqrt(4 * max(CANDIDATES_IN_CONTACT * faces, 1) / np.pi)
            error = max(error, FIRST_ERROR[interface.pairing.coupling] / across)
    n = max(0, int(np.ceil(np.log2(SAFETY * error / tightest)))) if error > 0 else 0
    if n == 0:
        return f"{text}: these meshes may do"
    total = seconds * sum(GROWTH ** (k * 4 / 3) for k in range(n + 1))
    return f"{text}: about {n} divisions, to {n_dofs * GROWTH**n:.2g} unknowns and {total:.2g} s"


def _coupling(interface: Interface, n: int) -> str:
    coupled = "weighted gaps (mortar)" if interface.pairing.coupling == "mortar" else "forces on nodes"
    why = f" as {interface.note}" if interface.note else ", as one side is rigid"
    return (
        f"{interface.slave.name}.{interface.surfaces[0]} on {interface.master.name}.{interface.surfaces[1]}: "
        f"{coupled}{why}; {n} candidates out of {len(interface.gap)} points"
    )


def _solver(solver: str, n: int, scene: SceneModel) -> str:
    if solver != "auto":
        return f"{solver}, as asked for"
    if any(b._matrix_free for b in scene.bodies):
        return "conjugate gradients with a compliance that is applied by Fourier transforms"
    return f"active set on a dense compliance of {n} candidates; slower finite methods only where it is singular"


def _model_costs(
    elastic: Sequence[ElasticBody], conditions: Sequence[UnilateralConstraints], chosen: Sequence[np.ndarray]
) -> tuple[ModelCost, ...]:
    """Costs of all models, each condensed once onto the candidates of all its bodies."""
    touched: dict[int, set[int]] = {}
    n_rows: dict[int, int] = {}
    first: dict[int, ElasticBody] = {}
    for body in elastic:
        first.setdefault(id(body.model), body)
        nodes = touched.setdefault(id(body.model), set())
        for condition, candidates in zip(conditions, chosen, strict=True):
            rows = condition.rows(body)
            if rows is not None:
                nodes.update(body.model.touched(rows[candidates]).tolist())
                n_rows[id(body.model)] = n_rows.get(id(body.model), 0) + len(candidates)
    if not first:
        return ()
    rate = _measured_rate()
    return tuple(
        _model_cost(first[key], np.array(sorted(nodes), dtype=np.int64), n_rows.get(key, 0), rate)
        for key, nodes in touched.items()
    )


def _model_cost(body: ElasticBody, nodes: np.ndarray, n_rows: int, rate: float) -> ModelCost:
    model = body.model
    mask = np.zeros(model.n_coordinates, bool)
    mask[(3 * nodes[:, None] + np.arange(3)).ravel()] = True
    mask[model.held] = mask[model.pinned_dofs] = False
    retained = max(int(mask.sum()), 1)
    backend = available_backends()[0] if body.backend == "auto" else body.backend
    route = body.condensation
    if route == "auto":
        one_by_one = not has_bordered(body.backend)
        route, _ = choose_route(len(model.solved_dofs), retained, memory_budget(), 1, one_by_one, n_rows)
    retained = {"schur": retained, "columns": n_rows if has_bordered(body.backend) else 0}.get(route, 0)
    assembling, stored, factor = _arrays(body, model)
    factor *= SUPERLU if backend == "superlu" else 1.0  # the factor of rslab is as large as PARDISO's
    dense = DENSE_RETAINED * 8 * retained**2
    needed = max(assembling, 2 * stored + ANALYSIS * factor + dense)
    return ModelCost(body.name, body.n_unknowns, retained, backend, needed / 1e6, rate * factor)


def _arrays(body: ElasticBody, model: Model) -> tuple[float, float, float]:
    """Bytes while the stiffness is assembled, of its upper triangle, and of PARDISO's factor."""
    n, n_cells = len(model.solved_dofs), len(body.mesh.cells)
    if body._out_of_plane is not None:
        width = 2 * body.mesh.cells.shape[1]
        return PER_ENTRY * n_cells * width**2, ENTRY * 17 * n, SECTION_FACTOR * n * np.log2(max(n, 2))
    functions = body.functions_per_cell
    pairs = n_cells * functions * (functions + 1) / 2
    # about two fifths of the entries of all cells remain after shared ones are summed
    return PER_PAIR * pairs, ENTRY * 9 * 0.6 * pairs, SOLID_FACTOR * n ** (4 / 3)


def _measured_rate() -> float:
    """Seconds per byte of factor on this machine: a block of 216 hexahedra, assembled and condensed."""
    mesh = shapes.block((1.0, 1.0, 1.0), (6, 6, 6))
    body = ElasticBody(mesh, Material(E=1.0, nu=0.3), "bottom", {"top": "xyz"})
    nodes = body.surface("bottom").nodes[:20]
    body.model.condensed(nodes[:1], Stopwatch())  # the first call loads the library
    start = time.perf_counter()
    fresh = ElasticBody(mesh, Material(E=1.0, nu=0.3), "bottom", {"top": "xyz"})
    fresh.model.condensed(nodes, Stopwatch())
    return (time.perf_counter() - start) / _arrays(fresh, fresh.model)[2]


def _peak(models: Sequence[ModelCost]) -> float:
    """Peak MB of the largest model with all other factors kept."""
    if not models:
        return 0.0
    needed = [m.memory_mb for m in models]
    return max(needed) + 0.7 * (sum(needed) - max(needed))
