"""Supports, loads and steps of Abaqus and CalculiX decks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fecontact.app.decks.content import DeckStep, look_up, numbered
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.mesh.formats.abaqus_deck import labelled_faces
from fecontact.mesh.formats.abaqus_keywords import KeywordSection, numbers
from fecontact.mesh.kinds import BY_MESHIO
from fecontact.mesh.mesh import Mesh

#: Named supports and the components they hold; rotations have no place in solids.
NAMED = {"XSYMM": (0,), "YSYMM": (1,), "ZSYMM": (2,), "ENCASTRE": (0, 1, 2), "PINNED": (0, 1, 2)}
#: Procedures of steps whose loads are static.
STATIC = ("STATIC", "VISCO")


@dataclass
class Names:
    """The mesh of a deck, to which boundaries of loads are added, and the names of all node sets of the deck."""

    mesh: Mesh
    source: str
    node_sets: frozenset[str]

    def nodes(self, name: str, place: str) -> IntArray | None:
        """Nodes of a set, or one by its number; None where they belong to no solid."""
        ids = self.mesh.file_nodes
        if name.isdigit():
            return numbered(ids, [int(name)], "node", place) if ids is not None and int(name) in ids else None
        known = {k.upper(): v for k, v in self.mesh.node_sets.items()}
        if name.upper() in known or name.upper() in self.node_sets:
            return known.get(name.upper())
        raise InputError(f"{place}: there is no node set {name!r}; there are: {', '.join(map(repr, known)) or 'none'}.")

    def cells(self, name: str, place: str) -> IntArray:
        """Cells of a set, or one by its number."""
        if name.isdigit():
            return numbered(self.mesh.file_elements, [int(name)], "element", place)
        return self.mesh.groups[look_up(name, self.mesh.groups, "element set of solids", place)]

    def boundary_of(self, cells: IntArray, label: str, place: str) -> str:
        """Name of a new boundary of the faces S1, S2, ... of cells."""
        kinds = np.empty(len(self.mesh.cells), dtype="U12")
        for kind, _, cell in self.mesh.native_cells():
            kinds[cell] = BY_MESHIO[kind].name
        name = f"{label} of {place}, {len(self.mesh.boundaries)}"
        faces = labelled_faces(cells, kinds, f"S{label[1:]}", name)
        self.mesh = replace(self.mesh, boundaries={**self.mesh.boundaries, name: faces})
        return name


@dataclass
class StepState:
    """Supports and loads that hold on from step to step.

    `held` and `forces` (n_points, 3) are as in `DeckStep`; `given` (n_points, 3) marks the forces of this step, which
    replace those of steps before.
    """

    held: Array
    forces: Array
    given: Mask
    pressures: dict[str, float] = field(default_factory=dict)
    gravity: Array = field(default_factory=lambda: np.zeros(3))
    #: Boundaries made for face loads, by set and label.
    faces: dict[tuple[str, str], str] = field(default_factory=dict)
    amplitudes: dict[str, tuple[Array, bool]] = field(default_factory=dict)

    def factor(self, s: KeywordSection, times: tuple[float, float]) -> float:
        """Amplitude of a keyword at the end of the step: at its time in the step, or at the total time."""
        name = s.parameters.get("AMPLITUDE")
        if name is None:
            return 1.0
        if name.upper() not in self.amplitudes:
            raise InputError(f"{s.place}: there is no *AMPLITUDE {name!r}.")
        table, total = self.amplitudes[name.upper()]
        return float(np.interp(times[1] if total else times[0], table[:, 0], table[:, 1]))


def steps_of(keywords: Sequence[KeywordSection], state: StepState, names: Names, notes: list[str]) -> list[DeckStep]:
    """Static steps; others are noted.

    Raises
    ------
    InputError
        If there is none.
    """
    starts = [k for k, s in enumerate(keywords) if s.keyword == "STEP"]
    out, total = [], 0.0
    for number, (a, b) in enumerate(pairwise([*starts, len(keywords)]), start=1):
        procedure = next((s for s in keywords[a:b] if s.keyword in STATIC), None)
        if procedure is None:
            notes.append(f"{keywords[a].place}: step {number} is left out: it is not static.")
            continue
        if "NLGEOM" in keywords[a].parameters:
            notes.append(f"{keywords[a].place}: NLGEOM is not used; strains are small.")
        row = numbers(procedure.lines[:1], float)
        period = float(row[1]) if len(row) > 1 else 1.0
        total += period
        state.given = np.zeros(state.forces.shape, bool)
        for s in keywords[a:b]:
            if s.keyword not in ("STEP", "END STEP", *STATIC):
                apply(s, state, names, (period, total), notes)
        out.append(
            DeckStep(
                f"step {number}",
                state.held.copy(),
                state.forces.copy(),
                dict(state.pressures),
                gravity=state.gravity.copy(),
            )
        )
    if not out:
        raise InputError(f"{names.source} has no static step (*STEP with *STATIC), so there is nothing to solve.")
    return out


def apply(s: KeywordSection, state: StepState, names: Names, times: tuple[float, float], notes: list[str]) -> None:
    """Take a keyword of a step; those that are not used are noted."""
    if s.keyword == "AMPLITUDE":
        if s.parameters.get("DEFINITION", "TABULAR").upper() != "TABULAR":
            raise InputError(f"{s.place}: expected a tabular amplitude; found {s.parameters['DEFINITION']!r}.")
        total = s.parameters.get("TIME", "").upper().startswith("TOTAL")
        state.amplitudes[s.parameters.get("NAME", "").upper()] = numbers(s.lines, float).reshape(-1, 2), total
        return
    if s.keyword not in ("BOUNDARY", "CLOAD", "DLOAD", "DSLOAD"):
        notes.append(f"{s.place}: *{s.keyword} is not used.")
        return
    _reset(s, state)
    factor = state.factor(s, times)
    for line in s.lines:
        words = [word.strip() for word in line.split(",")]
        if s.keyword in ("BOUNDARY", "CLOAD"):
            nodes = names.nodes(words[0], s.place)
            if nodes is None:
                notes.append(f"{s.place}: {line!r} is not used: {words[0]} has no nodes of solids.")
            elif s.keyword == "BOUNDARY":
                _hold(s, words, nodes, state, factor, notes)
            else:
                _push(s, words, nodes, state, factor, notes)
        elif s.keyword == "DLOAD":
            _load_cells(s, words, state, names, factor, notes)
        else:
            _load_surface(s, words, state, names, factor, notes)


def _reset(s: KeywordSection, state: StepState) -> None:
    """Drop what OP=NEW replaces."""
    if s.parameters.get("OP", "MOD").upper() != "NEW":
        return
    if s.keyword == "BOUNDARY":
        state.held[:] = np.nan
    elif s.keyword == "CLOAD":
        state.forces[:] = 0.0
    else:
        state.pressures.clear()
        state.gravity[:] = 0.0


def _hold(
    s: KeywordSection, words: list[str], nodes: IntArray, state: StepState, factor: float, notes: list[str]
) -> None:
    """Supports and prescribed displacements: ``set, first, last, value`` or ``set, ENCASTRE``."""
    if s.parameters.get("TYPE", "DISPLACEMENT").upper() != "DISPLACEMENT" or "FIXED" in s.parameters:
        raise InputError(f"{s.place}: expected displacements; found *BOUNDARY with {', '.join(s.parameters)}.")
    words += [""] * 4
    if words[1].upper() in NAMED:
        components, value = NAMED[words[1].upper()], 0.0
    else:
        first, last = int(words[1]), int(words[2] or words[1])
        components, value = tuple(range(first - 1, last)), _number(words[3])
        if last > 3:
            notes.append(f"{s.place}: components above 3 of {words[0]!r} are not used.")
    for c in components:
        if c < 3:
            state.held[nodes, c] = factor * value


def _push(
    s: KeywordSection, words: list[str], nodes: IntArray, state: StepState, factor: float, notes: list[str]
) -> None:
    """Forces on nodes, ``set, component, value``; they add up in a step and replace those of steps before."""
    c = int(words[1]) - 1
    if c > 2:
        notes.append(f"{s.place}: component {c + 1} of {words[0]!r} is not used.")
        return
    old = nodes[~state.given[nodes, c]]
    state.forces[old, c] = 0.0
    state.given[nodes, c] = True
    state.forces[nodes, c] += factor * _number(words[2])


def _load_cells(
    s: KeywordSection, words: list[str], state: StepState, names: Names, factor: float, notes: list[str]
) -> None:
    """Pressures on faces, ``set, P2, value``, and gravity, ``set, GRAV, size, x, y, z``."""
    label = words[1].upper()
    if label == "GRAV":
        size, *direction = (_number(word) for word in words[2:6])
        if words[0] and len(names.cells(words[0], s.place)) < len(names.mesh.cells):
            notes.append(f"{s.place}: gravity acts on all bodies, not on {words[0]!r} alone.")
        state.gravity = factor * size * np.array(direction)
    elif label[:1] == "P" and label[1:].isdigit():
        key = (words[0].upper(), label)
        if key not in state.faces:
            state.faces[key] = names.boundary_of(names.cells(words[0], s.place), label, s.place)
        state.pressures[state.faces[key]] = factor * _number(words[2])
    else:
        notes.append(f"{s.place}: the load {label} on {words[0]!r} is not used.")


def _load_surface(
    s: KeywordSection, words: list[str], state: StepState, names: Names, factor: float, notes: list[str]
) -> None:
    """Pressures on surfaces, ``surface, P, value``."""
    if words[1].upper() != "P":
        notes.append(f"{s.place}: the load {words[1]} on {words[0]!r} is not used.")
        return
    name = look_up(words[0], names.mesh.boundaries, "surface of solids", s.place)
    state.pressures[name] = factor * _number(words[2])


def _number(word: str) -> float:
    """A number, which may be blank or ``1.0D0``."""
    return float(word.upper().replace("D", "E")) if word else 0.0
