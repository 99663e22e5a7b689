"""Scenes from the contents of decks: bodies are the parts of the mesh that share no node."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from fecontact.app.decks.conditions import BodyConditions, of_body, with_supports_along
from fecontact.app.decks.content import DeckContent, DeckCut, DeckFrame, DeckPair, DeckRigid, DeckStep
from fecontact.app.decks.gaps import with_gaps
from fecontact.app.decks.heat import changes
from fecontact.app.decks.sections import AXES, thickness_of
from fecontact.app.scene_file.contents import SceneFile
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.rigid import Plane, RigidBody
from fecontact.bodies.section import AxisymmetricBody, PlaneBody
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, not_done
from fecontact.contact.contact import Contact
from fecontact.contact.loads import KEYED
from fecontact.contact.springs import Spring
from fecontact.fem.laws import laws_of
from fecontact.fem.rigid import COMPONENTS
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.mesh.build import MIXED
from fecontact.mesh.element import EDGES
from fecontact.mesh.facets import components, sides_of
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.scene.scene import Scene
from fecontact.scene.tension import Tension
from fecontact.surfaces import Facets
from fecontact.surfaces.tied import followers, joined_by

M = TypeVar("M", bound=BaseMesh)


def tied(mesh: M, ties: Sequence[DeckPair]) -> M:
    """The mesh with the slaves of ties on their masters, see `surfaces.tied`; warnings name the line of the deck.

    Raises
    ------
    InputError
        If no node of a slave lies on its master.
    """
    found = []
    for tie in ties:
        sides = tie.slave, tie.master
        if tie.of_faces:
            sides = min(sides, sides[::-1], key=lambda pair: _spacing(mesh, pair[0]))
        try:
            one = followers(mesh, *sides, tie.reach)
        except InputError as error:
            raise InputError(f"{tie.place}: {error}", code=error.code) from None
        loose, moved = (text and f"{tie.place}: {text}" for text in (one.loose, one.moved))
        found.append(replace(one, loose=loose, moved=moved))
    return joined_by(mesh, found)


def _spacing(mesh: BaseMesh, boundary: str) -> float:
    """Mean distance of the nodes of a boundary to the next."""
    points = mesh.points[mesh.boundary_nodes(boundary)]
    return float(cKDTree(points).query(points, k=2)[0][:, 1].mean())


#: Deviation of prescribed displacements from a rigid motion, relative to the largest, that is rounding of a deck.
ROUNDING = 1e-6
#: Part of a component in the motions that supports leave free, of unit length, that is rounding.
LOOSE = 1e-9


@dataclass(frozen=True, eq=False)
class DeckBody:
    """A body of a deck.

    Attributes
    ----------
    body : ElasticBody
    nodes : (n_points,) int array
        Points of its mesh among those of the deck.
    conditions : BodyConditions, optional
        Between its nodes, reference nodes and supports along axes of their own.
    """

    body: ElasticBody
    nodes: IntArray
    conditions: BodyConditions | None = None


def make_scene(deck: DeckContent, path: Path) -> SceneFile:
    """Scene of a deck.

    Parameters
    ----------
    deck : DeckContent
    path : Path
        Of the deck.

    Returns
    -------
    SceneFile
        One step: its loads. Several: steps of a load path with friction or laws of finite strain, else cases, for the
        answer to each does not depend on the others.

    Raises
    ------
    InputError
        If a cell has no material, or no contact joins two bodies.
    """
    deck = _of_one_set_of_contacts(_with_added_nodes(deck))
    alone = deck.conditions is None and not (deck.ties or deck.springs)
    deck = replace(deck, mesh=with_gaps(deck.mesh, deck.contacts, alone))
    deck, forces = _with_shortenings(deck)
    parts = _parts(deck)
    _refuse_contact_within(deck, parts)
    known: dict[Any, DeckBody] = {}
    rigid = {r.name: _rigid(r) for r in deck.rigid if r.surface is not None or r.normal is not None}
    held = [[_held(deck, step, name, cells, known) for name, cells in parts.items()] for step in deck.steps]
    made = held[0]
    contacts, unused = _contacts(deck, made, rigid, deck.steps[0])
    springs = _springs(deck, made)
    if not contacts and not springs and (unused or not any(m.body._is_tied for m in made)):
        raise InputError(
            f"{deck.source} brings no two bodies into contact. {' '.join(unused)} A scene needs a contact between "
            "surfaces of two bodies, parts of the mesh that share no node.",
            code="no-contact",
        )
    loads = [_loads(deck, step, own, rigid) for step, own in zip(deck.steps, held, strict=True)]
    bodies: list[ElasticBody | RigidBody] = [*(m.body for m in made), *rigid.values()]
    soft = any(laws_of(m.body.material) for m in made)
    along = soft or any(c.mu > 0 for c in contacts) or any(any(step.friction.values()) for step in deck.steps)
    several = len(loads) > 1
    names = [step.name for step in deck.steps]
    mixed = any(m.body.mesh.file_nodes is not None and (m.body.mesh.file_nodes < 0).any() for m in made)
    # a path has no 'auto', which stops to carry poses where it changes nothing
    options: dict[str, Any] = {} if deck.finite_motion is None else {"finite_motion": False}
    warnings = [*deck.warnings]
    if deck.finite_motion:
        loose = _loose(loads) if several and along and not soft else []
        options = {"finite_motion": not loose} if several and along else {}
        warnings += [
            f"{deck.source}: NLGEOM is not used, as prescribed displacements of {name!r} deform it while it is free to "
            "turn: motions are linearised."
            for name in loose
        ]
    notes = (*(n for n in deck.notes if MIXED not in n or mixed), *unused)
    scene = Scene(bodies, contacts, springs, notes=notes, warnings=warnings)
    scenes = _scenes(deck, held, rigid, scene)
    if soft:
        options = {}  # motions are finite
        if any(own is not scene for own in scenes):
            raise InputError(
                f"{deck.source}: supports or friction change between steps, which is not done with laws of finite "
                "strain.",
                code="supports-change",
            )
    cases = tuple({"name": n, **load} for n, load in zip(names, loads, strict=True)) if several and not along else ()
    steps = [{**load, "scene": own} if own is not scene else load for load, own in zip(loads, scenes, strict=True)]
    return SceneFile(
        path,
        deck.title,
        scene,
        {b.name: b for b in bodies},
        {} if several else loads[0],
        options,
        (),
        cases,
        tuple(steps) if several and along else (),
        notes,
        scenes if cases else (),
        tuple(_tension(deck, held, cut, force) for cut, force in forces),
    )


def _with_shortenings(deck: DeckContent) -> tuple[DeckContent, list[tuple[DeckCut, float]]]:
    """The deck with the shortenings of its cuts prescribed, and the forces of those that bear one instead.

    Raises
    ------
    InputError
        If there is such a force after the first step, or another on the nodes of a cut; or what is held as it is
        (FIXED) has no force before.
    """
    found, steps = dict[int, tuple[DeckCut, float]](), []
    for k, step in enumerate(deck.steps):
        held, forces = step.held.copy(), step.forces.copy()
        known = set(found)
        for cut in deck.cuts:
            if step.forces[cut.twins].any():
                raise not_done(f"{cut.place}: {step.name} has forces on nodes of the section, which is not done here.")
            free = np.isnan(held[cut.node, 0]) and cut.node not in step.fixed
            force = float(forces[cut.node, 0]) if free else 0.0
            if force and k:
                raise not_done(
                    f"{cut.place}: a force tightens the section in {step.name}; here it does in the first step alone. "
                    "Then hold what it has shortened by *BOUNDARY, FIXED, or prescribe how much by *BOUNDARY."
                )
            if force:
                found[cut.node] = cut, force
            if force or cut.node in known & step.fixed:
                held[cut.node, 0] = forces[cut.node, 0] = 0.0
            elif cut.node in known:
                raise not_done(
                    f"{cut.place}: {step.name} neither holds what a force has shortened before (*BOUNDARY, FIXED) nor "
                    "has that force, which is not done here."
                )
        if wrong := step.fixed - known:
            raise not_done(
                f"{deck.source}: {step.name} holds {len(wrong)} nodes as they are (*BOUNDARY, FIXED); here this is for "
                "reference nodes of pre-tension sections, after a force."
            )
        steps.append(replace(step, held=held, forces=forces))
    return replace(deck, steps=steps), list(found.values())


def _tension(deck: DeckContent, held: Sequence[Sequence[DeckBody]], cut: DeckCut, force: float) -> Tension:
    """The force in a cut of a body, which each step holds in its way."""
    bodies, values = [], []
    for made in held:
        m = next(m for m in made if np.isin(cut.twins, m.nodes).all())
        assert m.conditions is not None
        bodies.append(m.body)
        values.append(np.asarray(m.conditions.given[:, [3 * cut.node]].todense()).ravel())
    nodes = np.searchsorted(m.nodes, cut.twins[:, 0])
    direction = cut.direction[AXES] if deck.mesh.is_flat else cut.direction
    later = list(zip(bodies[1:], values[1:], strict=True))
    return Tension(bodies[0], values[0], nodes, direction, force, later)


def _loose(loads: Sequence[Mapping[str, Any]]) -> list[str]:
    """Names of bodies with prescribed displacements whose supports leave rigid motions free."""
    places = [place for load in loads for place in load.get("displacements", {})]
    bodies = [place[0] if isinstance(place, tuple) else place for place in places]
    return list(dict.fromkeys(body.name for body in bodies if body.free_motions.any()))


def _held(deck: DeckContent, step: DeckStep, name: str, cells: IntArray, known: dict[Any, DeckBody]) -> DeckBody:
    """The body of some cells as a step holds it: the same object for steps that hold it alike."""
    key = name, step.held_as(np.unique(deck.mesh.cells[cells]), len(deck.mesh.points))
    if key not in known:
        known[key] = _body(deck, step, name, cells)
    return known[key]


def _scenes(
    deck: DeckContent, held: Sequence[Sequence[DeckBody]], rigid: Mapping[str, RigidBody], first: Scene
) -> list[Scene]:
    """Scenes of the steps: that of the step before where supports and friction are the same."""
    out = [first]
    for k, (step, own) in enumerate(zip(deck.steps, held, strict=True)):
        before = deck.steps[k - 1]
        if k and all(map(operator.is_, own, held[k - 1])) and step.friction == before.friction:
            out.append(out[-1])
        elif k:
            bodies, contacts = [*(m.body for m in own), *rigid.values()], _contacts(deck, own, rigid, step)[0]
            out.append(replace(first, bodies=bodies, contacts=contacts, springs=_springs(deck, own)))
    return out


def _with_added_nodes(deck: DeckContent) -> DeckContent:
    """The deck with nodes in the middles of edges of linear cells held as both ends are, and without forces of sets."""
    ids = deck.mesh.file_nodes
    if ids is None or (ids >= 0).all():
        return deck
    if deck.between is None:
        nodes, ends = deck.mesh.cells[:, 8:20].ravel(), deck.mesh.cells[:, EDGES].reshape(-1, 2)
        nodes, ends = nodes[added := ids[nodes] < 0], ends[added]
    else:
        nodes, ends = deck.between[:, 0], deck.between[:, 1:]
    steps = []
    for s in deck.steps:
        held = s.held.copy()
        for _ in range(2):  # parts of divided triangles lie between such nodes
            held[nodes] = held[ends].mean(axis=1)
        forces = s.forces.copy()
        forces[: len(ids)][ids < 0] = 0.0
        heat = s.heat if deck.between is None or s.heat is None else _heat_between(deck, s.heat)
        steps.append(replace(s, held=held, forces=forces, heat=heat))
    return replace(deck, steps=steps)


def _heat_between(deck: DeckContent, given: Array) -> Array:
    """Temperatures at all points of sections, by those of nodes: in the middles of sides and of triangles."""
    ids, between, out = deck.mesh.file_nodes, deck.between, given.copy()
    assert ids is not None
    assert between is not None
    inner = np.setdiff1d(np.flatnonzero(ids < 0), between[:, 0])
    sides = sides_of(deck.mesh.cells[:, :8]).reshape(-1, 2)
    sides = np.concatenate([sides, sides[:, ::-1]])
    sides = sides[np.isin(sides[:, 0], inner)]
    for _ in range(2):
        out[between[:, 0]] = out[between[:, 1:]].mean(axis=1)
        out[inner] = 0.0
        np.add.at(out, sides[:, 0], out[sides[:, 1]] / np.bincount(sides[:, 0], minlength=len(out))[sides[:, 0]])
    return out


def _of_one_set_of_contacts(deck: DeckContent) -> DeckContent:
    """The deck with the steps of as many contact pairs as there are in any of them; others are warned of.

    Raises
    ------
    InputError
        If an answer would depend on the steps that are left out.
    """
    fewest = min(len(step.removed) for step in deck.steps)
    removed = next(step.removed for step in deck.steps if len(step.removed) == fewest)
    kept = [step for step in deck.steps if step.removed == removed]
    contacts = [pair for pair in deck.contacts if (pair.slave.upper(), pair.master.upper()) not in removed]
    if len(kept) == len(deck.steps):
        return replace(deck, contacts=contacts)
    if laws_of(deck.materials) or any(pair.friction for pair in contacts):
        raise not_done(
            f"{deck.source} adds or removes contact pairs between steps (*MODEL CHANGE) of a load path, with friction "
            "or laws of finite strain, which is not done here."
        )
    left = ", ".join(step.name for step in deck.steps if step.removed != removed)
    warning = f"{deck.source}: {left} left out, in which *MODEL CHANGE has removed contact pairs; without friction the "
    warning += "answers to the others do not depend on them."
    return replace(deck, contacts=contacts, steps=kept, warnings=[*deck.warnings, warning])


def _columns(mesh: Mesh, cells: IntArray) -> int:
    """Nodes of each of some cells: 8 where the others were added to linear cells on reading."""
    own = np.setdiff1d(mesh.cells[cells, 8:], mesh.cells[cells, :8])
    added = mesh.file_nodes is not None and (mesh.file_nodes[own] < 0).all()
    return 8 if added else mesh.cells.shape[1]


def _parts(deck: DeckContent) -> dict[str, IntArray]:
    """Cells of the parts of the mesh by name; parts are connected by nodes or ties."""
    mesh = deck.mesh
    n_cells, width = mesh.cells.shape
    ends = [(np.repeat(np.arange(n_cells), width), n_cells + mesh.cells.ravel())]
    for tie in deck.ties:
        slave = np.flatnonzero(np.isin(mesh.cells, mesh.boundary_nodes(tie.slave)).any(axis=1))
        chain = np.union1d(slave, mesh.faces(tie.master)[:, 0])
        ends.append((chain[:-1], chain[1:]))
    n = n_cells + len(mesh.points)
    if deck.conditions is not None:
        # what is prescribed joins nothing
        free = np.any([np.isnan(step.held) for step in deck.steps], axis=0)
        G = deck.conditions @ sp.diags(free.ravel().astype(float))
        entries = G.tocoo()
        entries.eliminate_zeros()
        place = np.where(entries.col < 3 * len(mesh.points), entries.col // 3, entries.col + len(mesh.points))
        ends.append((n + G.shape[1] + entries.row, n_cells + place))
        n += G.shape[1] + G.shape[0]
    label = components(n, np.stack([np.concatenate(side) for side in zip(*ends, strict=True)], axis=1))[:n_cells]
    label = np.unique(label, return_inverse=True)[1]
    names: dict[str, IntArray] = {}
    for k in range(label.max() + 1):
        cells = np.flatnonzero(label == k)
        whole = (name for name, group in mesh.groups.items() if np.array_equal(np.unique(group), cells))
        name = next((name for name in whole if name not in names), f"body_{k + 1}")
        names[name] = cells
    return names


def _refuse_contact_within(deck: DeckContent, parts: Mapping[str, IntArray]) -> None:
    """Refuse contact between parts that conditions join to one body.

    Raises
    ------
    InputError
    """
    if deck.conditions is None:
        return
    boundaries = deck.mesh.boundaries
    for pair in deck.contacts:
        sides = [boundaries[name][:, 0] for name in (pair.slave, pair.master) if name in boundaries]
        both = np.concatenate([np.zeros(0, np.int64), *sides])
        for name, cells in parts.items():
            if len(sides) == 2 and np.isin(both, cells).all():
                raise InputError(
                    f"{pair.place}: {pair.slave!r} and {pair.master!r} are surfaces of one body, {name!r}, whose parts "
                    "linear conditions join; contact within a body is not done here.",
                    code="contact-within-body",
                )


def _body(deck: DeckContent, step: DeckStep, name: str, cells: IntArray) -> DeckBody:
    """The elastic body of some cells, with its materials, supports in a step and contact surfaces."""
    whole: Any = deck.mesh
    groups: dict[str, IntArray] = {}
    for own, named in deck.sections:
        key = f"material {named}"
        groups[key] = np.union1d(groups.get(key, cells[:0]), np.intersect1d(own, cells))
    covered = np.concatenate([np.zeros(0, np.int64), *groups.values()])
    if len(lost := np.setdiff1d(cells, covered)):
        numbers = lost if whole.file_elements is None else whole.file_elements[lost]
        raise InputError(
            f"{deck.source}: {len(lost)} elements of {name!r} have no material; the first is {numbers[0]}.",
            code="no-material",
        )
    if deck.state is None:
        # the scene has the notes
        whole = replace(whole, cells=whole.cells[:, : _columns(whole, cells)], notes=())
    mesh: Any = replace(whole, groups={name: cells, **{k: g for k, g in groups.items() if len(g)}}).part(name)
    nodes = np.unique(whole.cells[cells])
    if len(nodes) != len(mesh.points):
        raise InputError(f"{deck.source}: {name!r} has nodes that are not its own.")
    mesh, supports = _supported(mesh, step.held[nodes])
    sets = {*mesh.boundaries, *mesh.node_sets}
    mesh = tied(mesh, [t for t in deck.ties if t.slave in sets and t.master in mesh.boundaries])
    materials = {k: deck.materials[k.removeprefix("material ")] for k in mesh.groups if k != name}
    touching = dict.fromkeys(n for pair in deck.contacts for n in (pair.slave, pair.master) if n in sets)
    material: Any = next(iter(materials.values())) if len(materials) == 1 else materials
    conditions = _conditions(deck, step, nodes)
    rows = None if conditions is None else conditions.rows
    options: dict[str, Any] = {"name": name, "conditions": rows}
    given = (material, tuple(touching), supports)
    body: ElasticBody
    if deck.state is None:
        body = ElasticBody(mesh, *given, geometry="plain", **options)
    else:
        section = SectionMesh(
            mesh.points,
            mesh.cells,
            mesh.boundaries,
            mesh.groups,
            mesh.node_sets,
            hanging=mesh.hanging,
            file_nodes=mesh.file_nodes,
            warnings=mesh.warnings,
        )
        if deck.state == "axis":
            body = AxisymmetricBody(section, *given, **options)
        else:
            thickness = thickness_of(cells, deck.sections, deck.thicknesses, name)
            body = PlaneBody(section, *given, thickness=thickness, plane=deck.state, **options)
    return DeckBody(body, nodes, conditions)


def _conditions(deck: DeckContent, step: DeckStep, nodes: IntArray) -> BodyConditions | None:
    """Linear conditions of a body of some points of the mesh."""
    found = None
    if deck.conditions is not None:
        found = of_body(deck.conditions, np.isfinite(step.held).ravel(), nodes, len(deck.mesh.points))
    found = with_supports_along(found, deck.axes, step.along, nodes, step.held.size)
    return found if found is not None and found.rows.shape[0] + found.forces.nnz else None


def _supported(mesh: Any, held: Array) -> tuple[Any, dict[str, str]]:
    """The mesh with the nodes (n_points, 3) held in each component as node sets, and the supports of these."""
    fixed = np.isfinite(held)
    sets: dict[str, IntArray] = {}
    for axes in ("xyz", "xy", "xz", "yz", "x", "y", "z"):
        columns = fixed[:, ["xyz".index(c) for c in axes]]
        taken = set("".join(sets))
        if not taken & set(axes) and columns.any() and (columns == columns[:, :1]).all():
            sets[axes] = np.flatnonzero(columns[:, 0])
    named = {f"held in {axes}": nodes for axes, nodes in sets.items()}
    return replace(mesh, node_sets={**mesh.node_sets, **named}), {f"held in {c}": c for c in sets}


def _rigid(given: DeckRigid) -> RigidBody:
    """A rigid body whose axes begin at its centre; the third one of a wall is its normal."""
    if given.normal is not None:
        along = np.linalg.svd(given.normal[None])[2][1]
        axes = np.stack([along, np.cross(given.normal, along), given.normal], axis=1)
        return RigidBody(Plane(), given.name).placed(given.centre, axes)
    assert given.surface is not None
    own = given.surface.mapped(lambda x: x - given.centre)
    return RigidBody(Facets(own), given.name).placed(given.centre)


def _contacts(
    deck: DeckContent, made: Sequence[DeckBody], rigid: Mapping[str, RigidBody], step: DeckStep
) -> tuple[list[Contact], list[str]]:
    """Contacts of the pairs on every two bodies in a step, and notes on pairs that cannot be used."""
    out, notes = [], []

    def ends(name: str) -> list[tuple[ElasticBody | RigidBody, str]]:
        stiff = [(rigid[r.name], "surface") for r in deck.rigid if name in r.names]
        return [*((m.body, name) for m in made if name in m.body.contact), *stiff]

    for pair in deck.contacts:
        slaves, masters = ends(pair.slave), ends(pair.master)
        both = [(s, m) for s in slaves for m in masters if s[0] is not m[0] and not (s[0].is_rigid and m[0].is_rigid)]
        for one, other in both:
            slave, master = (other, one) if one[0].is_rigid else (one, other)
            names, mu = (slave[1], master[1]), step.friction.get(pair.interaction, pair.friction)
            out.append(Contact(slave[0], master[0], names, friction=mu, overclosure=pair.overclosure))
        if not both:
            why = "are on one body" if slaves and masters else "are not both on solids"
            notes.append(f"{pair.place}: not used, as the surfaces {pair.slave!r} and {pair.master!r} {why}.")
    return out, notes


def _springs(deck: DeckContent, made: Sequence[DeckBody]) -> list[Spring]:
    """Springs between nodes of two bodies, or of one and the ground.

    Raises
    ------
    InputError
        If both ends are on one body.
    """
    out = []
    for spring in deck.springs:
        ends: list[tuple[ElasticBody | None, Any]] = []
        for place, where in ((spring.start, spring.first), (spring.end, spring.second)):
            own = next((m for m in made if place is not None and place in m.nodes), None)
            at = where if own is None else own.body.mesh.points[np.flatnonzero(own.nodes == place)[0]]
            ends.append((None if own is None else own.body, at))
        if ends[0][0] is ends[1][0]:
            raise InputError(
                f"{deck.source}: the spring {spring.name!r} has both ends on one body or none, which is not done here.",
                code="spring-ends",
            )
        out.append(Spring(spring.stiffness, ends[0], ends[1], kind="linear", name=spring.name))
    return out


def _loads(
    deck: DeckContent, step: DeckStep, made: Sequence[DeckBody], rigid: Mapping[str, RigidBody]
) -> dict[str, Any]:
    """Arguments of `Scene.solve` of a step."""
    given: dict[str, dict[Any, Any]] = {kind: {} for kind in KEYED}
    for m in made:
        points = m.body.mesh.points
        own = step.forces[m.nodes] + _through(m, step, deck.source)
        given["forces"] |= {
            (m.body, tuple(points[k].tolist())): own[k] for k in np.flatnonzero(own.any(axis=1)).tolist()
        }
        for kind, values in (("pressures", step.pressures), ("tractions", step.tractions)):
            found = {(m.body, name): v for name, v in values.items() if name in m.body.mesh.boundaries and np.any(v)}
            given[kind] |= found
        if step.heat is not None and step.heat[m.nodes].any():
            given["temperatures"][m.body] = changes(m.body.mesh, step.heat, m.nodes)
        held = step.held[m.nodes]
        motion = None if m.conditions is not None else _frame_motion(m.body, held)
        if motion is None:
            given["displacements"] |= _displacements(m, _turned(deck, step, m))
        elif motion:
            given["motions"] |= {m.body: motion}
    for frame in step.frames:
        _move(deck, frame, made, rigid, given)
    loads = {kind: value for kind, value in given.items() if value}
    if not (callable(step.gravity) or np.any(step.gravity)):
        return loads
    unknown = {part.name for part in deck.rigid if part.mass is None}
    if lost := [frame.rigid for frame in step.frames if frame.is_free and frame.rigid in unknown]:
        raise not_done(
            f"{deck.source}: the rigid part {lost[0]!r} is free to move, and its mass is not known here: a body load "
            "on it would be lost."
        )
    return loads | {"gravity": step.gravity}


def _through(m: DeckBody, step: DeckStep, source: str) -> Array:
    """Forces (n, 3) on the points of a body by those on reference nodes.

    Raises
    ------
    InputError
        If one has nothing to resist it.
    """
    if m.conditions is None:
        return np.zeros((len(m.nodes), 3))
    given = step.forces.ravel()
    lost = np.abs(m.conditions.loose @ given)
    if (lost > ROUNDING * (np.abs(m.conditions.loose) @ np.abs(given))).any():
        raise InputError(
            f"{source}: a load on a reference node of {m.body.name!r} is along a motion that its conditions leave "
            "free; hold it there.",
            code="load-would-be-lost",
        )
    return np.asarray(m.conditions.forces @ given).reshape(-1, 3)


def _turned(deck: DeckContent, step: DeckStep, m: DeckBody) -> DeckStep:
    """The step with the displacements of nodes on rigid parts that turn: finite ones for bodies of finite strain."""
    held = step.held.copy()
    for frame in step.frames if m.body._finite_strain is not None else ():
        shift, turn = np.array([frame.motions.get(c, 0.0) for c in COMPONENTS]).reshape(2, 3)
        if turn.any() and not frame.is_free:
            part = next(r for r in deck.rigid if r.name == frame.rigid)
            lever = deck.mesh.points[part.attached] - part.centre
            held[part.attached] = shift + Rotation.from_rotvec(turn).apply(lever) - lever
    return replace(step, held=held)


def _displacements(m: DeckBody, step: DeckStep) -> dict[Any, Array]:
    """Prescribed displacements of the supports of a body, and the values of its conditions."""
    held = np.nan_to_num(step.held)
    out: dict[Any, Array] = {}
    for name, support in m.body.supports.items():
        nodes = m.body.mesh.boundary_nodes(name)
        values = np.zeros((len(nodes), 3))
        for c in ("xyz".index(str(w)) for w in support):
            values[:, c] = held[m.nodes[nodes], c]
        out |= {(m.body, name): values} if values.any() else {}
    if m.conditions is not None:
        values = held if step.along is None else np.where(np.isfinite(step.along), step.along, held)
        of_conditions = np.asarray(m.conditions.given @ values.ravel())
        out |= {m.body: of_conditions} if of_conditions.any() else {}
    return out


def _move(
    deck: DeckContent,
    frame: DeckFrame,
    made: Sequence[DeckBody],
    rigid: Mapping[str, RigidBody],
    given: dict[str, dict[Any, Any]],
) -> None:
    """Motions and loads of a rigid part: of its body, or of the frame of the body that is attached to it.

    Raises
    ------
    InputError
        If a rigid part whose motion is unknown has both, or several.
    """
    part = next(r for r in deck.rigid if r.name == frame.rigid)
    held = [m.body for m in made if np.isin(part.attached, m.nodes).any()]
    bodies: list[ElasticBody | RigidBody] = [rigid[part.name]] if part.name in rigid else []
    if frame.is_free:
        bodies += held
    if frame.is_free and len(bodies) > 1:
        raise InputError(
            f"{deck.source}: the rigid part {part.name!r} is free to move and joins {len(bodies)} bodies; here a rigid "
            "part that joins bodies must be held or moved."
        )
    for body in bodies:
        lever = part.centre - body.pose.to_world(body.reference_point)
        loads = {"forces": frame.force, "moments": frame.moment + np.cross(lever, frame.force)}
        given |= {kind: given[kind] | {body: value} for kind, value in loads.items() if value.any()}
        given["free"] |= {body: frame.free} if frame.free else {}
        given["motions"] |= {body: dict(frame.motions)} if frame.motions else {}


def _frame_motion(body: ElasticBody, held: Array) -> dict[str, float] | None:
    """Motion of a body's frame that gives prescribed displacements (n_points, 3), NaN where free.

    None where there is none, as the displacements deform the body, or where its supports let it turn so that its
    reference point moves along: a motion of the frame would hold that.
    """
    node, component = np.nonzero(np.isfinite(held))
    values = held[node, component]
    if not values.any():
        return {}
    A = body.rigid_modes.reshape(-1, 3, 6)[node, component]
    scale = np.array([1.0] * 3 + [1 / body.size] * 3)
    for columns in (slice(0, 3), slice(0, 6)):
        q = np.zeros(6)
        q[columns] = np.linalg.lstsq((A * scale)[:, columns], values, rcond=1e-9)[0]
        q *= scale
        if np.abs(A @ q - values).max() <= ROUNDING * np.abs(values).max():
            q[np.abs(q / scale) <= ROUNDING * np.abs(values).max()] = 0.0
            if np.abs(body.free_motions[q != 0]).max(initial=0.0) > LOOSE:
                return None
            return {COMPONENTS[c]: float(q[c]) for c in np.flatnonzero(q).tolist()}
    return None
