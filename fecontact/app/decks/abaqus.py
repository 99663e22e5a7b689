"""Scenes from Abaqus and CalculiX decks: materials, supports, loads, contact pairs, ties and steps.

Keywords as in the Abaqus Keywords Reference and in Dhondt, CalculiX CrunchiX User's Manual. What is not used is listed
with its line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

from fecontact.app.decks.abaqus_steps import (
    OF_LINES,
    Names,
    StepState,
    apply,
    follows_motion,
    friction_of,
    steps_of,
    unused,
)
from fecontact.app.decks.conditions import (
    CONDITIONS,
    OF_COUPLING,
    Nodes,
    conditions_of,
    reference_names,
    transformed,
)
from fecontact.app.decks.content import DeckContent, DeckCut, DeckPair, DeckStep, Remarks, look_up
from fecontact.app.decks.cyclic import sector, sector_conditions, sectors_of
from fecontact.app.decks.divided import divided_deck
from fecontact.app.decks.elastic import linear_elastic, orientation
from fecontact.app.decks.gaps import apart, keeps_apart
from fecontact.app.decks.heat import expansion_of, temperatures_of
from fecontact.app.decks.materials import compressibility, hyperelastic, hyperfoam
from fecontact.app.decks.pretension import cut_conditions, cut_sections, on_both_sides, with_twins_between
from fecontact.app.decks.sections import (
    AXES,
    axes_in_section,
    conditions_in_section,
    even_on,
    face_surfaces,
    in_section,
    state_of,
)
from fecontact.app.decks.springs import springs_of
from fecontact.app.options import FINITE
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, not_done
from fecontact.contact.overclosure import SoftContact
from fecontact.fem.laws import Law, at_rest, laws_of
from fecontact.fem.model import AnyMaterial
from fecontact.fem.stiffness import surface_traction
from fecontact.mesh.base_mesh import BaseMesh
from fecontact.mesh.build import build
from fecontact.mesh.facets import places_among
from fecontact.mesh.formats.abaqus import mesh_of
from fecontact.mesh.formats.abaqus_deck import (
    KeywordSection,
    missing_files,
    one_spelling,
    read_sections,
    values_of,
)
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.read import plane_parts
from fecontact.mesh.section_mesh import PlaneCells

M = TypeVar("M", bound=BaseMesh)
#: Keywords of the mesh, which `read_mesh` reads.
MESH = {"NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "INSTANCE"}
MESH |= {"END INSTANCE", "INCLUDE", "HEADING"}
#: Keywords that stand inside of *MATERIAL and *SURFACE INTERACTION.
OF_MATERIAL = {"ELASTIC", "DENSITY", "EXPANSION", "HYPERELASTIC", "HYPERFOAM"}
OF_INTERACTION = {"SURFACE BEHAVIOR", "FRICTION"}
#: Ties whose surfaces do not lie on each other.
OF_TIES = ("MULTISTAGE", "FLUID PERIODIC")
#: Overclosure of a linear law under a pressure, relative to the shortening of the mesh's size under it, below which the
#: law is a penalty, as programs need one, and not meant as a soft layer.
PENALTY = 0.01
#: Types of elements that bend more than those of full integration, and linear ones of sections.
SOFTER, LINEAR = r"C3D8[RI]|C(PS|PE|AX)8R", r"C(PS|PE|AX)[34]"


@dataclass
class Found:
    """Contents of a deck's model part, as far as read; `part` is the one whose keywords are being read."""

    instances: dict[str, list[str]]
    types: dict[str, str]
    by_nodes: frozenset[str]
    part: str = ""
    sections: list[tuple[IntArray, str]] = field(default_factory=list)
    thicknesses: list[float] = field(default_factory=list)
    materials: dict[str, list[KeywordSection]] = field(default_factory=dict)
    interactions: dict[str, list[KeywordSection]] = field(default_factory=dict)
    pairs: list[tuple[KeywordSection, str]] = field(default_factory=list)
    ties: list[DeckPair] = field(default_factory=list)
    clearances: dict[tuple[str, str], float] = field(default_factory=dict)
    orientations: dict[str, KeywordSection] = field(default_factory=dict)
    oriented: dict[str, KeywordSection] = field(default_factory=dict)
    heated: bool = False
    remarks: Remarks = field(default_factory=Remarks)

    @classmethod
    def of(cls, keywords: Sequence[KeywordSection]) -> Found:
        """Names of instances by part, types of elements by set, and surfaces of nodes; else empty."""
        instances: dict[str, list[str]] = {}
        for s in keywords:
            if s.keyword == "INSTANCE":
                instances.setdefault(s.parameters.get("PART", "").upper(), []).append(s.parameters.get("NAME", ""))
        given = [s.parameters for s in keywords if s.keyword == "ELEMENT"]
        types = {p.get("ELSET", "").upper(): p.get("TYPE", "").upper() for p in given}
        given_surfaces = [s.parameters for s in keywords if s.keyword == "SURFACE"]
        by_nodes = {p.get("NAME", "").upper() for p in given_surfaces if p.get("TYPE", "").upper() == "NODE"}
        # a name that is one of elements too is that one
        of_elements = {p.get("NAME", "").upper() for p in given_surfaces if p.get("TYPE", "").upper() != "NODE"}
        heated = {s.keyword for s in keywords} >= {"EXPANSION", "TEMPERATURE"}
        return cls(instances, types, frozenset(by_nodes - of_elements), heated=heated)

    def cells(self, s: KeywordSection, mesh: BaseMesh) -> IntArray:
        """Cells of the set that a keyword names, in a part those of all its instances.

        Raises
        ------
        InputError
            If there is no such set.
        """
        name = s.parameters.get("ELSET", "")
        known = {k.upper(): v for k, v in mesh.groups.items()}
        # a set of one instance alone is called without it
        inside = [[f"{i}.{name}", name] for i in self.instances.get(self.part, [])] if self.part else [[name]]
        found = [
            known[next(n for n in own if n.upper() in known).upper()]
            for own in map(list, inside)
            if any(n.upper() in known for n in own)
        ]
        if found:
            return np.unique(np.concatenate(found))
        if self.part and not self.instances.get(self.part):
            return np.zeros(0, np.int64)
        return mesh.groups[look_up(name, mesh.groups, "element set of solids", s.place)]

    def surface(self, name: str, place: str, mesh: BaseMesh, follows: bool = False) -> str:
        """Spelling of a surface's name; one that `follows` another may be nodes alone.

        Raises
        ------
        InputError
            If there is none, or its nodes fill no faces.
        """
        known = {k.upper() for k in mesh.boundaries}
        if name.upper() in self.by_nodes and name.upper() not in known:
            if follows:
                return look_up(name, mesh.node_sets, "surface of nodes", place)
            raise InputError(
                f"{place}: {name!r} is a surface of nodes (TYPE=NODE), some of which are on no face of elements with "
                "all its nodes among them; make it one of elements.",
                code="surface-of-nodes",
            )
        if "." in name and name.upper() not in known:
            name = name.partition(".")[2]
        return look_up(name, mesh.boundaries, "surface of solids", place)


def read_deck(path: Path, laws: str = FINITE, divide: int = 0) -> DeckContent:
    """Contents of a deck, with its laws of finite strain or their moduli at rest, its cells divided so many times.

    Raises
    ------
    InputError, MeshError
        For names that are missing, values that cannot be read, and keywords that would change the meaning of others.
    """
    keywords = one_spelling(list(read_sections(path)))
    if missing := missing_files(keywords):
        raise InputError(f"Files that {path.name} includes are missing: {', '.join(missing)}.", code="missing-files")
    keywords = divided_deck(keywords, path.name, divide)
    found = Found.of(keywords)
    first = next((k for k, s in enumerate(keywords) if s.keyword == "STEP"), len(keywords))
    mesh: Mesh | PlaneCells
    between, surfaces = None, dict[tuple[str, str], str]()
    if (state_of_cells := state_of(keywords)) is None:
        raw = mesh_of(keywords, path.name)
        mesh = build(raw, path.name)
    else:
        loaded, surfaces = face_surfaces(keywords)
        raw = mesh_of([*keywords, *loaded], path.name, plane=True)
        mesh, between = plane_parts(raw, path.name)
    mesh, cuts = cut_sections(_with_faces(mesh, found.by_nodes), keywords[:first], raw)
    between = with_twins_between(between, cuts)
    names = _names(keywords[:first], raw, mesh, path.name)
    names.faces |= surfaces
    for s in keywords:
        if s.keyword == "ELEMENT" and re.match(SOFTER, kind := s.parameters.get("TYPE", "").upper()):
            found.remarks.note(f"{path.name}: elements of type {kind} are integrated in full, so they bend less here.")
        elif s.keyword == "ELEMENT" and re.match(LINEAR, kind := s.parameters.get("TYPE", "").upper()):
            found.remarks.note(f"{path.name}: elements of type {kind} are solved as quadrilaterals of 8 nodes.")
    try:
        cuts = [replace(cut, node=names.special.one(cut.reference, cut.place)) for cut in cuts]
        conditions = _conditions(keywords[:first], names, found, state_of_cells, cuts)
        springs = springs_of(keywords[:first], raw, _places(raw, mesh))
        if springs and state_of_cells is not None:
            raise InputError(f"{path.name}: springs of plane and axisymmetric parts are not done here.", code="springs")
        shape = (names.special.count, 3)
        state = StepState(np.full(shape, np.nan), np.zeros(shape), np.zeros(shape, bool))
        if found.heated:
            state.initial, state.temperatures = np.full((2, shape[0]), np.nan)
        owner: list[KeywordSection] = []
        for s in keywords[:first]:
            owner = _model(s, owner, found, state, names)
        steps = steps_of(keywords[first:], state, names, found.remarks)
        if cuts:
            steps = [replace(s, heat=None if s.heat is None else on_both_sides(s.heat, cuts)) for s in steps]
        axes = names.special.axes
        if state_of_cells is not None:
            moving = names.special.moving
            steps = [in_section(each, moving, path.name) for each in steps]
            conditions, axes = conditions_in_section(conditions, moving), axes_in_section(axes)
        _tell_of_conditions(keywords[:first], steps, names, found.remarks)
        materials = _materials(found, laws)
        if state_of_cells is not None:
            given: dict[str, Any] = dict(materials)
            materials = {k: made.exchanged() if at_rest(made).directed else made for k, made in given.items()}
        contacts, tied = _pairs(found, mesh, materials)
    except (ValueError, IndexError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path.name} holds a value that cannot be read: {error}.", code="bad-value") from error
    for _, name in found.sections:
        if name not in materials:
            raise InputError(
                f"{path.name}: there is no *MATERIAL {name!r}; there are: {', '.join(found.materials) or 'none'}.",
                code="unknown-material",
            )
    title = next((s.lines[0] for s in keywords if s.keyword == "HEADING" and s.lines), "")
    return DeckContent(
        path.name,
        title,
        names.mesh,
        found.sections,
        materials,
        steps,
        contacts,
        [*found.ties, *tied],
        [*getattr(mesh, "notes", ()), *found.remarks.all_notes],
        warnings=found.remarks.warnings,
        finite_motion=follows_motion(keywords),
        conditions=conditions,
        axes=axes,
        state=state_of_cells,
        thicknesses=found.thicknesses,
        between=between,
        springs=springs,
        cuts=cuts,
    )


def _with_faces(mesh: M, by_nodes: Collection[str]) -> M:
    """The mesh with the faces that surfaces of nodes fill as boundaries of their names; of the others nodes remain."""
    outer, found = mesh.outer, dict(mesh.boundaries)
    if any(name.upper() in by_nodes for name in mesh.node_sets):
        facets = mesh.face_nodes(outer)
        added = np.zeros(facets.shape, bool) if mesh.file_nodes is None else mesh.file_nodes[facets] < 0
    for name, nodes in mesh.node_sets.items():
        if name.upper() in by_nodes:
            filled = (added | np.isin(facets, nodes)).all(axis=1)
            found.pop(name, None)
            if np.isin(nodes, facets[filled]).all():
                found[name] = outer[filled]
    return replace(mesh, boundaries=found)


def _places(raw: RawMesh, mesh: Mesh | PlaneCells) -> IntArray:
    """Points of the mesh (n,) that all nodes of the file are, -1 for those of no solid."""
    assert raw.node_ids is not None
    assert mesh.file_nodes is not None
    _, own, other = np.intersect1d(raw.node_ids, mesh.file_nodes, return_indices=True)
    out = np.full(len(raw.node_ids), -1)
    out[own] = other
    return out


#: Prescribed turn of a reference node above which linear conditions are off by more than some percent of it.
TURN = 0.1


def _tell_of_conditions(
    model: Sequence[KeywordSection], steps: Sequence[DeckStep], names: Names, remarks: Remarks
) -> None:
    """Note that conditions with turns are linear, and warn of large turns."""
    curved = [s for s in model if s.keyword in CONDITIONS and s.keyword != "EQUATION"]
    if not curved:
        return
    remarks.note(f"{curved[0].place}: *{curved[0].keyword} is linear, for small turns from the initial shape.")
    turned = [names.special.rotations[k] for k in names.special.rotations]
    most = max((float(np.nanmax(np.abs(s.held[turned]), initial=0.0)) for s in steps), default=0.0)
    if most > TURN:
        remarks.warn(f"{curved[0].place}: a reference node is turned by {most:.3g}, but conditions are linear.")


def _names(model: Sequence[KeywordSection], raw: RawMesh, mesh: Mesh | PlaneCells, source: str) -> Names:
    """Nodes and sets of the mesh, and the nodes outside of it that conditions use."""
    sets = frozenset(s.parameters["NSET"].upper() for s in model if "NSET" in s.parameters)
    assert raw.node_ids is not None
    known = {k.upper(): v for k, v in raw.node_sets.items()}
    used = np.zeros(len(raw.points), bool)
    for _, cells in raw.blocks:
        used[cells] = True
    named = [known[name.upper()] for name in reference_names(model) if name.upper() in known]
    numbers = [int(name) for name in reference_names(model) if name.isdigit()]
    beside = np.unique(np.concatenate([np.flatnonzero(np.isin(raw.node_ids, numbers)), *named]))
    beside = beside[~used[beside]]
    place = places_among(beside, len(raw.points))
    inside = {name: place[members] + len(mesh.points) for name, members in known.items() if (place[members] >= 0).any()}
    reference_sets = {name: found[found >= len(mesh.points)] for name, found in inside.items()}
    names = Names(mesh, source, sets, raw.node_ids[beside], reference_sets)
    points = mesh.points[:, AXES] if mesh.is_flat else mesh.points
    names.special = Nodes(np.concatenate([points, raw.points[beside]]), len(mesh.points), names.all_nodes)
    return names


def _conditions(
    model: Sequence[KeywordSection], names: Names, given: Found, state: str | None, cuts: Sequence[DeckCut]
) -> sp.csr_matrix | None:
    """Linear conditions, those of sectors among them, after the axes of nodes that *TRANSFORM turns."""
    mesh: Any = names.mesh
    special = names.special
    for s in model:
        if s.keyword == "TRANSFORM":
            nodes = names.nodes(s.parameters.get("NSET", ""), s.place)
            special.axes |= {} if nodes is None else transformed(s, nodes, special.points)

    def faces(name: str, place: str) -> tuple[IntArray, Array]:
        named = look_up(name, {**mesh.boundaries, **mesh.node_sets}, "surface of solids", place)
        nodes = mesh.boundary_nodes(named)
        if named not in mesh.boundaries:
            return nodes, np.ones(len(nodes))
        if state is not None:
            return nodes, even_on(mesh, named, state == "axis")[nodes]
        even = surface_traction(mesh, mesh.faces(named), lambda x, n: np.broadcast_to([1.0, 0.0, 0.0], x.shape))
        return nodes, even[3 * nodes]

    def cells(name: str, place: str) -> IntArray:
        return np.unique(mesh.cells[names.cells(name, place)])

    parts = [conditions_of(model, special, faces, cells), cut_conditions(cuts, special)]
    for tie, line, cyclic in sectors_of(model):
        if state is not None:
            raise not_done(f"{tie.place}: a sector of plane elements is not done here.")
        pair = _pair(line, tie.place, 0.0, given, mesh, follows=False)
        parts.append(sector_conditions(mesh, sector(tie, (pair.slave, pair.master), cyclic), 3 * special.count))
    for s in (s for s in model if keeps_apart(s) and state is None):
        reach = s.parameters.get("POSITION TOLERANCE")
        ties = [_pair(line, s.place, 0.0, given, mesh, reach) for line in s.lines]
        parts += [apart(mesh, tie, 3 * special.count, given.remarks) for tie in ties]
    found = sp.vstack(parts, format="csr")
    return found if found.shape[0] else None


def _model(
    s: KeywordSection, owner: list[KeywordSection], found: Found, state: StepState, names: Names
) -> list[KeywordSection]:
    """Take a keyword of the model part; returns the list of keywords of the material or interaction it belongs to."""
    if s.keyword in ("PART", "END PART", "INSTANCE", "END INSTANCE"):
        begins = not s.keyword.startswith("END")
        found.part = s.parameters.get("NAME" if s.keyword == "PART" else "PART", "").upper() if begins else ""
    taken = s.keyword == "TIE" and "CYCLIC SYMMETRY" in s.parameters
    if s.keyword in (*MESH, *CONDITIONS, *OF_COUPLING, "TRANSFORM", "CYCLIC SYMMETRY MODEL", "SPRING") or taken:
        return owner
    if s.keyword in ("MATERIAL", "SURFACE INTERACTION"):
        kept = found.materials if s.keyword == "MATERIAL" else found.interactions
        return kept.setdefault(s.parameters.get("NAME", "").upper(), [])
    if s.keyword in OF_MATERIAL | OF_INTERACTION:
        owner.append(s)
    elif s.keyword == "SOLID SECTION":
        name = s.parameters.get("MATERIAL", "").upper()
        if "ORIENTATION" in s.parameters:
            name = f"{name} in {s.parameters['ORIENTATION'].upper()}"
            found.oriented[name] = s
        cells = found.cells(s, names.mesh)
        if any(np.isin(own, cells).any() for own, _ in found.sections):
            found.remarks.note(f"{s.place}: elements of an earlier *SOLID SECTION too are of this one, as in CalculiX.")
            found.sections = [(np.setdiff1d(own, cells), other) for own, other in found.sections]
        found.sections.append((cells, name))
        given = values_of(s.lines[0]) if s.lines and s.lines[0].strip(", ") else [1.0]
        found.thicknesses.append(given[0] or 1.0)
    elif s.keyword == "ORIENTATION":
        found.orientations[s.parameters.get("NAME", "").upper()] = s
    elif s.keyword == "CONTACT PAIR":
        found.pairs += [(s, line) for line in s.lines]
    elif s.keyword == "CLEARANCE" and "VALUE" in s.parameters:
        names_of = (s.parameters.get("SLAVE", "").upper(), s.parameters.get("MASTER", "").upper())
        found.clearances[names_of] = values_of(s.parameters["VALUE"])[0]
    elif s.keyword == "INITIAL CONDITIONS" and s.parameters.get("TYPE", "").upper() == "TEMPERATURE" and found.heated:
        temperatures_of(
            s, lambda name: names.nodes(name, s.place), lambda value: value, state.initial, names.special.points
        )
    elif s.keyword == "TIE":
        if wrong := [p for p in OF_TIES if p in s.parameters]:
            raise InputError(f"{s.place}: *TIE, {wrong[0]} ties surfaces that are apart, which is not done here.")
        reach = s.parameters.get("POSITION TOLERANCE")
        if keeps_apart(s):
            if not names.mesh.is_flat:
                return owner
            found.remarks.warn(f"{s.place}: ADJUST=NO is not used: tied nodes are moved onto their master.")
        found.ties += [_pair(line, s.place, 0.0, found, names.mesh, reach) for line in s.lines]
    elif s.keyword in ("PLASTIC", "CREEP", "VISCOELASTIC"):
        at = f" above {values_of(s.lines[0])[0]:g}" if s.keyword == "PLASTIC" and s.lines else ""
        found.remarks.warn(f"{s.place}: *{s.keyword} is not used: the material stays elastic{at}.")
    elif s.keyword in (*OF_LINES, "AMPLITUDE"):
        apply(s, state, names, (0.0, 0.0), found.remarks)
    else:
        unused(s, found.remarks)
    return owner


def _pair(
    line: str, place: str, friction: float, found: Found, mesh: BaseMesh, reach: str | None = None, follows: bool = True
) -> DeckPair:
    """Slave and master of a data line; a slave that `follows` may be nodes alone."""
    words = [word.strip() for word in line.split(",")]
    if len(words) < 2 or not words[1]:
        raise InputError(f"{place}: expected two surfaces, slave and master; found {line!r}.")
    slave, master = found.surface(words[0], place, mesh, follows), found.surface(words[1], place, mesh)
    return DeckPair(slave, master, friction, place, None if reach is None else values_of(reach)[0])


def _pairs(
    found: Found, mesh: BaseMesh, materials: dict[str, AnyMaterial | Law]
) -> tuple[list[DeckPair], list[DeckPair]]:
    """Contacts, and pairs that are tied; what is solved differently is noted or warned of."""
    contacts: list[DeckPair] = []
    tied: list[DeckPair] = []
    stiffest = max((m.average.E for m in at_rest(materials).values()), default=0.0) / float(
        np.linalg.norm(np.ptp(mesh.points, axis=0))
    )
    small = not laws_of(materials)
    for s, line in found.pairs:
        name = s.parameters.get("INTERACTION", "")
        if name.upper() not in found.interactions:
            raise InputError(f"{s.place}: there is no *SURFACE INTERACTION {name!r}.", code="unknown-interaction")
        friction, ties, soft = 0.0, "TIED" in s.parameters, None
        for part in found.interactions[name.upper()]:
            if part.keyword == "FRICTION":
                friction = friction_of(part, found.remarks)
            else:
                ties |= _ties(part)
                soft = _overclosure(part, stiffest, small, found.remarks)
        adjust, nodes = _adjust(s, mesh)
        pair = replace(_pair(line, s.place, friction, found, mesh), overclosure=soft, adjust=adjust, adjusted=nodes)
        clearance = found.clearances.get((pair.slave.upper(), pair.master.upper()))
        pair = replace(pair, clearance=clearance, interaction=name.upper())
        faces = s.parameters.get("TYPE", "").upper() == "SURFACE TO SURFACE" and pair.slave in mesh.boundaries
        if soft is not None and pair.slave not in mesh.boundaries:
            found.remarks.note(
                f"{s.place}: the nodes of {pair.slave!r} fill no faces: their soft law is that of their shares of all "
                "faces round them, as in CalculiX; Abaqus takes an area of one unless the deck gives it."
            )
        (tied if ties else contacts).append(replace(pair, of_faces=ties and faces))
    return contacts, tied


def _adjust(s: KeywordSection, mesh: BaseMesh) -> tuple[float | None, str]:
    """Distance of ADJUST, None without it, or the set of nodes that are adjusted at any distance."""
    given = s.parameters.get("ADJUST")
    try:
        return None if given is None else values_of(given)[0], ""
    except ValueError:
        assert given is not None
        return math.inf, look_up(given, mesh.node_sets, "node set", s.place)


def _ties(part: KeywordSection) -> bool:
    """Whether *SURFACE BEHAVIOR ties.

    Raises
    ------
    InputError
        If surfaces cannot part.
    """
    if "NO SEPARATION" in part.parameters:
        raise InputError(f"{part.place}: surfaces that touch once never part (NO SEPARATION), which is not done here.")
    return _form(part) == "TIED"


def _form(part: KeywordSection) -> str:
    return part.parameters.get("PRESSURE-OVERCLOSURE", "HARD").upper()


def _overclosure(part: KeywordSection, stiffest: float, small: bool, remarks: Remarks) -> SoftContact | None:
    """Law of a soft contact at small strain; others are warned of, one so stiff that it is a penalty noted."""
    form = _form(part)
    if form == "LINEAR" and part.lines:
        stiffness = values_of(part.lines[0])[0]
        if stiffest <= PENALTY * stiffness:
            remarks.note(f"{part.place}: the contact is hard, without the linear overclosure, a penalty.")
            return None
        if small:
            return SoftContact(stiffness)
    rows = [values_of(line)[:2] for line in part.lines]
    try:
        if form == "TABULAR" and small:
            return SoftContact([(overlap, pressure) for pressure, overlap in rows])
        if form == "EXPONENTIAL" and small and rows:
            remarks.note(f"{part.place}: the exponential overclosure is that of CalculiX, a hundredth of p0 at c0.")
            return SoftContact.exponential(rows[0][0], rows[0][1])
    except (InputError, ValueError) as error:
        raise InputError(f"{part.place}: {error}", code=getattr(error, "code", "bad-value")) from None
    if form not in ("HARD", "TIED"):
        remarks.warn(f"{part.place}: the contact is hard, without the soft {form.lower()} overclosure.")
    return None


def _materials(found: Found, laws: str) -> dict[str, AnyMaterial | Law]:
    """Materials of the sections, those with an orientation apart."""
    out: dict[str, AnyMaterial | Law] = {}
    for name in dict.fromkeys(name for _, name in found.sections):
        section = found.oriented.get(name)
        own = name if section is None else section.parameters.get("MATERIAL", "").upper()
        if own not in found.materials:
            continue
        made = _material(own, found.materials[own], laws, found.remarks, found.heated)
        out[name] = made if section is None else _oriented(made, section, found)
    return out


def _oriented(made: Any, section: KeywordSection, found: Found) -> AnyMaterial | Law:
    """A material along the axes of its section.

    Raises
    ------
    InputError
        If there is no such orientation.
    """
    name = section.parameters["ORIENTATION"]
    if name.upper() not in found.orientations:
        raise InputError(f"{section.place}: there is no *ORIENTATION {name!r}.", code="unknown-orientation")
    if at_rest(made).directed:
        return replace(made, axes=orientation(found.orientations[name.upper()]))
    found.remarks.note(f"{section.place}: the orientation is not used, as the material is isotropic.")
    return made


def _material(
    name: str, parts: Sequence[KeywordSection], laws: str, remarks: Remarks, heated: bool = False
) -> AnyMaterial | Law:
    """Material of its keywords, at the first temperature."""
    given = {s.keyword: s for s in parts}
    density = values_of(given["DENSITY"].lines[0])[0] if "DENSITY" in given else None
    expansion = expansion_of(given["EXPANSION"]) if "EXPANSION" in given and heated else 0.0 if heated else None
    for keyword in ("ELASTIC", "HYPERELASTIC", "HYPERFOAM"):
        if keyword not in given:
            continue
        s = given[keyword]
        c = [v for line in s.lines for v in values_of(line)]
        order = int(s.parameters.get("N", 1))
        if keyword == "ELASTIC":
            material, more = linear_elastic(s, density, expansion)
            if more:
                (remarks.warn if heated else remarks.note)(
                    f"{s.place}: the moduli of the first line are used at every temperature."
                )
            return material
        forms = [p for p in s.parameters if p not in ("N", "TEST DATA INPUT", "MODULI", "POISSON")]
        form = forms[0] if forms else "POLYNOMIAL"
        try:
            foam = keyword == "HYPERFOAM"
            made = hyperfoam(order, c, density, laws) if foam else hyperelastic(form, order, c, density, laws)
        except InputError as error:
            raise InputError(f"{s.place}: {error}", code=error.code) from None
        rest = at_rest(made)
        moduli = f"moduli at rest E = {rest.E:.6g}, nu = {rest.nu:.6g}"
        if not foam and compressibility(form, order, c) == 0:
            moduli += " as no D is given (CalculiX and Abaqus/Explicit take the same, Abaqus/Standard nu = .5)"
        remarks.warn(
            f"{s.place}: finite strain, with the bulk energy (ln J)^2 / D in place of (J - 1)^2 / D: pressures differ "
            f"by 3/2 (J - 1) of themselves; {moduli}."
            if laws == FINITE
            else f"{s.place}: linear, with the {moduli}."
        )
        return made
    raise InputError(f"The material {name!r} has none of *ELASTIC, *HYPERELASTIC and *HYPERFOAM.")
