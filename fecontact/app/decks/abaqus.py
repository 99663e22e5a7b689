"""Scenes from Abaqus and CalculiX decks: materials, supports, loads, contact pairs, ties and steps.

Keywords as in the Abaqus Keywords Reference and in Dhondt, CalculiX CrunchiX User's Manual. What is not used is listed
with its line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fecontact.app.decks.abaqus_steps import Names, StepState, apply, steps_of
from fecontact.app.decks.content import DeckContent, DeckPair, look_up
from fecontact.app.decks.materials import hyperelastic, hyperfoam
from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.mesh.formats.abaqus_keywords import KeywordSection, numbers, one_spelling, read_sections
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.read import read_mesh

#: Keywords of the mesh, which `read_mesh` reads.
MESH = {"NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "INSTANCE"}
MESH |= {"END INSTANCE", "INCLUDE", "HEADING"}
#: Keywords that stand inside of *MATERIAL and *SURFACE INTERACTION.
OF_MATERIAL = {"ELASTIC", "DENSITY", "HYPERELASTIC", "HYPERFOAM"}
OF_INTERACTION = {"SURFACE BEHAVIOR", "FRICTION"}
#: Parameters of *FRICTION that make it differ by direction, speed or pressure.
OF_FRICTION = ("ANISOTROPIC", "EXPONENTIAL DECAY", "TAUMAX", "USER")
#: Keywords whose loads and supports need axes or constraints that there are not here.
REFUSED = {"TRANSFORM": "turns the axes of nodes", "SYSTEM": "turns coordinates"}


@dataclass
class Found:
    """What the model part of a deck has said so far."""

    sections: list[tuple[IntArray, str]] = field(default_factory=list)
    materials: dict[str, list[KeywordSection]] = field(default_factory=dict)
    interactions: dict[str, list[KeywordSection]] = field(default_factory=dict)
    pairs: list[tuple[KeywordSection, str]] = field(default_factory=list)
    ties: list[DeckPair] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def read_deck(path: Path) -> DeckContent:
    """Contents of a deck.

    Raises
    ------
    InputError, MeshError
        For names that are missing, values that cannot be read, and keywords that would change the meaning of others.
    """
    mesh = read_mesh(path)
    keywords = one_spelling(list(read_sections(path)))
    sets = frozenset(s.parameters["NSET"].upper() for s in keywords if "NSET" in s.parameters)
    found, names = Found(), Names(mesh, path.name, sets)
    shape = mesh.points.shape
    state = StepState(np.full(shape, np.nan), np.zeros(shape), np.zeros(shape, bool))
    first = next((k for k, s in enumerate(keywords) if s.keyword == "STEP"), len(keywords))
    try:
        owner: list[KeywordSection] = []
        for s in keywords[:first]:
            owner = _model(s, owner, found, state, names)
        steps = steps_of(keywords[first:], state, names, found.notes)
        materials = {name: _material(parts, found.notes) for name, parts in found.materials.items()}
        contacts, tied = _pairs(found, mesh)
    except (ValueError, IndexError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path.name} holds a value that cannot be read: {error}.") from error
    for _, name in found.sections:
        if name not in materials:
            raise InputError(
                f"{path.name}: there is no *MATERIAL {name!r}; there are: {', '.join(materials) or 'none'}."
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
        [*mesh.notes, *found.notes],
    )


def _model(
    s: KeywordSection, owner: list[KeywordSection], found: Found, state: StepState, names: Names
) -> list[KeywordSection]:
    """Take a keyword of the model part; returns the list of keywords of the material or interaction it belongs to."""
    if s.keyword in REFUSED:
        raise InputError(f"{s.place}: *{s.keyword} {REFUSED[s.keyword]}, which is not done here.")
    if s.keyword in MESH:
        return owner
    if s.keyword in ("MATERIAL", "SURFACE INTERACTION"):
        kept = found.materials if s.keyword == "MATERIAL" else found.interactions
        return kept.setdefault(s.parameters.get("NAME", "").upper(), [])
    if s.keyword in OF_MATERIAL | OF_INTERACTION:
        owner.append(s)
    elif s.keyword == "SOLID SECTION":
        elset = s.parameters.get("ELSET", "")
        named = look_up(elset, names.mesh.groups, "element set of solids", s.place)
        found.sections.append((names.mesh.groups[named], s.parameters.get("MATERIAL", "").upper()))
        if "ORIENTATION" in s.parameters:
            found.notes.append(f"{s.place}: the orientation is not used; materials are isotropic.")
    elif s.keyword == "CONTACT PAIR":
        found.pairs += [(s, line) for line in s.lines]
    elif s.keyword == "TIE":
        found.ties += [_pair(line, s.place, 0.0, names.mesh) for line in s.lines]
    elif s.keyword in ("BOUNDARY", "AMPLITUDE"):
        apply(s, state, names, (0.0, 0.0), found.notes)
    else:
        found.notes.append(f"{s.place}: *{s.keyword} is not used.")
    return owner


def _pair(line: str, place: str, friction: float, mesh: Mesh) -> DeckPair:
    """Slave and master of a data line."""
    words = [word.strip() for word in line.split(",")]
    if len(words) < 2:
        raise InputError(f"{place}: expected two surfaces, slave and master; found {line!r}.")
    slave, master = (look_up(word, mesh.boundaries, "surface of solids", place) for word in words[:2])
    return DeckPair(slave, master, friction, place)


def _pairs(found: Found, mesh: Mesh) -> tuple[list[DeckPair], list[DeckPair]]:
    """Contacts, and pairs that are tied, with what is done differently noted."""
    contacts: list[DeckPair] = []
    tied: list[DeckPair] = []
    for s, line in found.pairs:
        name = s.parameters.get("INTERACTION", "")
        if name.upper() not in found.interactions:
            raise InputError(f"{s.place}: there is no *SURFACE INTERACTION {name!r}.")
        friction, ties = 0.0, False
        for part in found.interactions[name.upper()]:
            if part.keyword == "FRICTION":
                friction = _friction(part, found.notes)
                continue
            form = part.parameters.get("PRESSURE-OVERCLOSURE", "HARD").upper()
            ties |= form == "TIED"
            if form not in ("HARD", "TIED"):
                found.notes.append(f"{part.place}: the contact is hard, without the {form.lower()} overclosure.")
        pair = _pair(line, s.place, friction, mesh)
        (tied if ties else contacts).append(pair)
        if "ADJUST" in s.parameters:
            found.notes.append(f"{s.place}: ADJUST is not used; gaps are those of the mesh.")
    return contacts, tied


def _friction(part: KeywordSection, notes: list[str]) -> float:
    """Coefficient of friction of its keyword: the first one, infinite where rough."""
    if "ROUGH" in part.parameters:
        return math.inf
    if unused := [word for word in OF_FRICTION if word in part.parameters]:
        notes.append(f"{part.place}: friction is the first coefficient, everywhere; {', '.join(unused)} is not used.")
    return float(numbers(part.lines, float)[0]) if part.lines else 0.0


def _material(parts: Sequence[KeywordSection], notes: list[str]) -> Material:
    """Material of its keywords, at rest and at the first temperature."""
    given = {s.keyword: s for s in parts}
    density = float(numbers(given["DENSITY"].lines, float)[0]) if "DENSITY" in given else None
    for keyword in ("ELASTIC", "HYPERELASTIC", "HYPERFOAM"):
        if keyword not in given:
            continue
        s = given[keyword]
        c = numbers(s.lines, float).tolist()
        order = int(s.parameters.get("N", 1))
        if keyword == "ELASTIC":
            form = s.parameters.get("TYPE", "ISO").upper()
            if not form.startswith("ISO") or len(c) < 2:
                raise InputError(
                    f"{s.place}: expected an isotropic material, E and nu; found type {form}, {s.lines[:1]}."
                )
            if len(s.lines) > 1:
                notes.append(f"{s.place}: the moduli of the first line are used at every temperature.")
            return Material(c[0], c[1], density)
        forms = [p for p in s.parameters if p not in ("N", "TEST DATA INPUT", "MODULI", "POISSON")]
        form = forms[0] if forms else "POLYNOMIAL"
        try:
            made = hyperfoam(order, c, density) if keyword == "HYPERFOAM" else hyperelastic(form, order, c, density)
        except InputError as error:
            raise InputError(f"{s.place}: {error}") from None
        notes.append(f"{s.place}: linear, with the moduli at rest: E = {made.E:.6g}, nu = {made.nu:.6g}.")
        return made
    raise InputError("A material has none of *ELASTIC, *HYPERELASTIC and *HYPERFOAM.")
