"""Supports, loads and steps of Abaqus and CalculiX decks.

Keywords of Abaqus and CalculiX decks that are not used: refused, warned of, or noted, by what they change.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise

import numpy as np

from fecontact.app.decks.conditions import Nodes
from fecontact.app.decks.content import DeckStep, Remarks, look_up, numbered
from fecontact.app.decks.heat import Rotation, temperatures_of, together
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, not_done
from fecontact.mesh.formats.abaqus_deck import KeywordSection, labelled_faces, values_of
from fecontact.mesh.kinds import BY_MESHIO
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import PlaneCells

#: Keywords that change the question, and how; a scene without them would answer another one.
REFUSED = {
    "SYSTEM": "turns coordinates",
    **dict.fromkeys(("EQUATION", "MPC", "NETWORK MPC"), "ties displacements of nodes to each other"),
    **dict.fromkeys(("COUPLING", "RIGID BODY", "DISTRIBUTING COUPLING", "KINEMATIC COUPLING"), "ties nodes to one"),
    **dict.fromkeys(("KINEMATIC", "DISTRIBUTING"), "belongs after *COUPLING"),
    "TRANSFORM": "turns the axes of nodes in a step",
    **dict.fromkeys(("EMBEDDED ELEMENT", "SHELL TO SOLID COUPLING"), "ties elements to others"),
    **dict.fromkeys(("PRE-TENSION SECTION", "BOLT"), "pretensions a section in a step"),
    "MODEL CHANGE": "adds or removes elements in a step",
    "CHANGE CONTACT TYPE": "changes a contact in a step",
    "CHANGE SURFACE BEHAVIOR": "changes a contact in a step",
    **dict.fromkeys(("CLEARANCE", "CONTACT INTERFERENCE"), "changes the gap of a contact"),
    **dict.fromkeys(("COHESIVE BEHAVIOR",), "makes a contact stick together"),
    **dict.fromkeys(("CONTACT", "CONTACT INCLUSIONS"), "is general contact; write each as *CONTACT PAIR"),
    **dict.fromkeys(("SUBMODEL", "SUBSTRUCTURE PROPERTY"), "takes results of another model"),
    "PERIODIC MEDIA": "ties one side of a part to the other",
    **dict.fromkeys(("USER MATERIAL", "HYPOELASTIC", "DEFORMATION PLASTICITY"), "is a law without elastic moduli"),
    **dict.fromkeys(
        ("SHELL SECTION", "SHELL GENERAL SECTION", "BEAM SECTION", "BEAM GENERAL SECTION", "MEMBRANE SECTION"),
        "gives stiffness to elements that are no solids",
    ),
    **dict.fromkeys(
        ("MASS", "DASHPOT", "GAP", "GAP UNIT", "CONNECTOR SECTION", "FRICTION CHANGE"),
        "gives a law to elements that are no solids",
    ),
    "SOLID SECTION": "stands inside of a step",
}
#: Keywords that ask for output.
OUTPUT = {
    "NODE PRINT", "EL PRINT", "NODE FILE", "EL FILE", "CONTACT FILE", "CONTACT PRINT", "NODE OUTPUT", "ELEMENT OUTPUT",
    "CONTACT OUTPUT", "ENERGY OUTPUT", "ENERGY FILE", "ENERGY PRINT", "OUTPUT", "SECTION PRINT", "SECTION FILE",
    "FILE FORMAT", "MONITOR", "PRINT", "PREPRINT", "RESTART", "MODAL FILE", "TIME POINTS", "FILTER",
    "INTEGRATED OUTPUT", "INTEGRATED OUTPUT SECTION",
}  # fmt: skip
#: Keywords that change how a step is solved, not its solution, or of what statics have nothing.
HARMLESS = {
    "CONTROLS", "CONTACT CONTROLS", "SOLVER CONTROLS", "SOLUTION TECHNIQUE", "CONTACT DAMPING", "DAMPING",
    "PHYSICAL CONSTANTS", "CONDUCTIVITY", "SPECIFIC HEAT", "EXPANSION", "DEPVAR", "SURFACE",
    "HOURGLASS STIFFNESS", "SECTION CONTROLS", "TEMPERATURE", "GAP CONDUCTANCE", "GAP HEAT GENERATION",
}  # fmt: skip


def unused(s: KeywordSection, remarks: Remarks) -> None:
    """Note a keyword that is not used, or warn of it.

    Raises
    ------
    InputError
        If it changes the question.
    """
    if s.keyword in REFUSED:
        raise not_done(f"{s.place}: *{s.keyword} {REFUSED[s.keyword]}, which is not done here.")
    if s.keyword == "INITIAL CONDITIONS" and s.parameters.get("TYPE", "").upper() == "STRESS":
        raise InputError(f"{s.place}: *INITIAL CONDITIONS, TYPE=STRESS are not done here: bodies begin without stress.")
    beginning = s.keyword == "INITIAL CONDITIONS" and s.parameters.get("TYPE", "").upper() == "TEMPERATURE"
    if s.keyword in OUTPUT:
        remarks.requests.append(f"{s.place}: *{s.keyword}")
    elif s.keyword in HARMLESS or beginning:
        remarks.note(f"{s.place}: *{s.keyword} is not used.")
    else:
        remarks.warn(f"{s.place}: *{s.keyword} is not used: what it changes is left out.")


#: Named supports and the components they hold; rotations have no place in solids.
NAMED = {"XSYMM": (0,), "YSYMM": (1,), "ZSYMM": (2,), "ENCASTRE": (0, 1, 2), "PINNED": (0, 1, 2)}
#: Procedures of steps whose loads are static.
STATIC = ("STATIC", "VISCO")
#: Difference of values of an amplitude, relative to the largest, that is rounding of a file.
ROUNDING = 1e-9
#: Parameters of *FRICTION that make it differ by direction, speed or pressure.
OF_FRICTION = ("ANISOTROPIC", "EXPONENTIAL DECAY", "TAUMAX", "USER")
#: Parameters that change the meaning of loads and supports.
MEANING = ("USER", "SUBMODEL", "TIME DELAY", "SECTOR", "FOLLOWER", "CYCLIC MODE", "OMEGA0", "PHASE")


@dataclass
class Names:
    """The mesh of a deck, to which boundaries of loads are added, and the names of all node sets of the deck.

    `faces` are the boundaries made for face loads, by set and label. `references` are the numbers of the reference
    nodes, `reference_sets` their places by set, `special` what conditions say of nodes.
    """

    mesh: Mesh | PlaneCells
    source: str
    node_sets: frozenset[str]
    references: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    reference_sets: dict[str, IntArray] = field(default_factory=dict)
    faces: dict[tuple[str, str], str] = field(default_factory=dict)
    special: Nodes = field(init=False)

    def all_nodes(self, name: str, place: str) -> IntArray:
        """The same with reference nodes, at least one.

        Raises
        ------
        InputError
            If there is none.
        """
        found = self.nodes(name, place)
        if found is None:
            raise InputError(f"{place}: {name!r} has no node that is used here.", code="unknown-node")
        return found

    def nodes(self, name: str, place: str) -> IntArray | None:
        """Nodes of a set, or one by its number; None where they belong to no solid and are no reference nodes."""
        if name.isdigit():
            ids = self.references if self.mesh.file_nodes is None else np.append(self.mesh.file_nodes, self.references)
            return numbered(ids, [int(name)], "node", place) if int(name) in ids else None
        known = {k.upper(): v for k, v in self.mesh.node_sets.items()}
        for other, members in self.reference_sets.items():
            known[other] = np.append(known.get(other, members[:0]), members)
        # a set of one instance alone is called without it
        name = name if name.upper() in known or "." not in name else name.partition(".")[2]
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


@dataclass(frozen=True, eq=False)
class Amplitude:
    """Values over the time in a step or the total time, that are factors of loads or, if absolute, loads themselves."""

    times: Array
    values: Array
    total: bool
    absolute: bool

    @classmethod
    def of(cls, s: KeywordSection) -> Amplitude:
        """Of its keyword, with CalculiX's shifts.

        Raises
        ------
        InputError
            If it is no table over growing times.
        """
        if s.parameters.get("DEFINITION", "TABULAR").upper() != "TABULAR" or "USER" in s.parameters:
            raise InputError(f"{s.place}: expected a tabular amplitude; found {', '.join(s.parameters.values())}.")
        flat = np.array([v for line in s.lines for v in values_of(line)])
        shifts = [values_of(s.parameters.get(name, "0"))[0] for name in ("SHIFTX", "SHIFTY")]
        if len(flat) == 0 or len(flat) % 2 or (np.diff(flat[::2]) < 0).any():
            raise InputError(f"{s.place}: expected pairs of growing times and values; found {s.lines}.", code="growing")
        total = s.parameters.get("TIME", "").upper().startswith("TOTAL")
        return cls(
            flat[::2] + shifts[0], flat[1::2] + shifts[1], total, s.parameters.get("VALUE", "").upper() == "ABSOLUTE"
        )

    def goes_beyond(self, start: float, end: float) -> bool:
        """Whether its values between two times exceed those at them, but for rounding."""
        inside = self.values[(self.times > start) & (self.times < end)]
        low, high = sorted(float(np.interp(time, self.times, self.values)) for time in (start, end))
        slack = ROUNDING * float(np.abs(self.values).max())
        return bool(len(inside) and (inside.min() < low - slack or inside.max() > high + slack))

    def at(self, time: float, given: float) -> float:
        """The load at a time, of the value given with it."""
        found = float(np.interp(time, self.times, self.values))
        return found if self.absolute else found * given


@dataclass
class StepState:
    """Supports and loads that hold on from step to step.

    `held` and `forces` (n_points, 3) are as in `DeckStep`, as `removed`, `friction` and `fixed` are; `initial` and
    `temperatures` (n_points,) are NaN where none is given; `changing` is the interaction whose friction the next
    keyword changes. Loads add up in a step and replace those of steps before: `given` (n_points, 3) marks the forces of
    this step, `fresh` are the names of its other loads, and `renewed` are the kinds of which it has dropped all before.
    """

    held: Array
    forces: Array
    given: Mask
    pressures: dict[str, float] = field(default_factory=dict)
    gravity: dict[str, tuple[IntArray | slice, Array]] = field(default_factory=dict)
    rotations: list[Rotation] = field(default_factory=list)
    initial: Array = field(default_factory=lambda: np.zeros(0))
    temperatures: Array = field(default_factory=lambda: np.zeros(0))
    removed: frozenset[tuple[str, str]] = frozenset()
    friction: dict[str, float] = field(default_factory=dict)
    changing: str = ""
    fixed: set[int] = field(default_factory=set)
    amplitudes: dict[str, Amplitude] = field(default_factory=dict)
    renewed: set[str] = field(default_factory=set)
    fresh: set[str] = field(default_factory=set)

    def value(self, s: KeywordSection, times: tuple[float, float], given: float) -> float:
        """Value of a load at the end of the step, by its amplitude at the time in the step or at the total time."""
        name = s.parameters.get("AMPLITUDE")
        if name is None:
            return given
        if name.upper() not in self.amplitudes:
            raise InputError(f"{s.place}: there is no *AMPLITUDE {name!r}.", code="unknown-amplitude")
        amplitude = self.amplitudes[name.upper()]
        return amplitude.at(times[1] if amplitude.total else times[0], given)

    def begin_step(self) -> None:
        """Loads of before may be replaced."""
        self.given[:] = False
        self.renewed.clear()
        self.fresh.clear()

    def press(self, name: str, value: float) -> None:
        """Add a pressure on a boundary."""
        self.pressures[name] = value + (self.pressures[name] if name in self.fresh else 0.0)
        self.fresh.add(name)

    def pull(self, name: str, cells: IntArray | slice, gravity: Array) -> None:
        """Add to gravity on a set of cells."""
        before = self.gravity[name][1] if f"GRAV {name}" in self.fresh else 0.0
        self.gravity[name] = cells, gravity + before
        self.fresh.add(f"GRAV {name}")

    def weight(self, n_cells: int, name: str) -> Array:
        """Gravity (3,) on all cells.

        Raises
        ------
        InputError
            If it differs from cell to cell.
        """
        each = np.zeros((n_cells, 3))
        for cells, gravity in self.gravity.values():
            each[cells] += gravity
        if (np.ptp(each, axis=0) > ROUNDING * np.abs(each).max()).any():
            raise InputError(
                f"{name}: gravity differs between elements (GRAV of {', '.join(map(repr, self.gravity))}); here it is "
                "the same on all of them.",
                code="gravity-differs",
            )
        return each[0]

    def turn(self, rotation: Rotation) -> None:
        """Add to the forces of rotations."""
        self.rotations = [*(self.rotations if "CENTRIF" in self.fresh else []), rotation]
        self.fresh.add("CENTRIF")

    @property
    def heat(self) -> Array | None:
        """Changes of temperature (n_points,) since the beginning, zero where none is given; None without any."""
        change = np.where(np.isnan(self.temperatures), 0.0, self.temperatures - np.nan_to_num(self.initial))
        return change if change.any() else None


def steps_of(keywords: Sequence[KeywordSection], model: StepState, names: Names, remarks: Remarks) -> list[DeckStep]:
    """Static steps; others are warned of.

    What holds on from earlier steps is taken anew in each, for amplitudes over the total time go on.

    Raises
    ------
    InputError
        If there is none.
    """
    starts = [k for k, s in enumerate(keywords) if s.keyword == "STEP"]
    out: list[DeckStep] = []
    done: list[tuple[Sequence[KeywordSection], float]] = []
    total = 0.0
    for number, (a, b) in enumerate(pairwise([*starts, len(keywords)]), start=1):
        procedure = next((s for s in keywords[a:b] if s.keyword in STATIC), None)
        if procedure is None:
            remarks.warn(f"{keywords[a].place}: step {number} is left out: it is not static.")
            continue
        if "PERTURBATION" in keywords[a].parameters:
            raise InputError(
                f"{keywords[a].place}: a step of perturbation adds to the one before; write its loads in full."
            )
        # a blank or zero period is one (Abaqus Keywords Reference: *STATIC)
        period = ([*values_of(procedure.lines[0]), 0.0, 0.0][1] if procedure.lines else 0.0) or 1.0
        total += period
        done.append((keywords[a:b], period))
        state = copy.deepcopy(model)
        for k, (step, its) in enumerate(done, start=1):
            state.begin_step()
            for s in step:
                if s.keyword not in ("STEP", "END STEP", *STATIC):
                    apply(s, state, names, (its, total), remarks if k == len(done) else Remarks())
                _warn_of_bends(s, state, (its, total, period), k == len(done), remarks)
        weight = state.weight(len(names.mesh.cells), f"{names.source}, step {number}")
        out.append(_ended(f"step {number}", state, weight, names.special.axes))
    if not out:
        raise InputError(f"{names.source} has no static step (*STEP with *STATIC), so there is nothing to solve.")
    return out


def _ended(name: str, state: StepState, weight: Array, axes: Mapping[int, Array]) -> DeckStep:
    """The end of a step, in the axes of space where these or their supports allow it."""
    held, forces, along = state.held.copy(), state.forces.copy(), np.full(state.held.shape, np.nan)
    for node, own in axes.items():
        forces[node] = state.forces[node] @ own
        fixed = np.isfinite(state.held[node])
        held[node] = np.nan
        if fixed.all():
            held[node] = state.held[node] @ own
            continue
        for c in np.flatnonzero(fixed).tolist():
            k = int(np.abs(own[c]).argmax())
            if np.abs(own[c]).sum() - abs(own[c, k]) < ROUNDING:
                held[node, k] = state.held[node, c] * np.sign(own[c, k])
            else:
                along[node, c] = state.held[node, c]
    oblique = along if np.isfinite(along).any() else None
    pull = together(weight, state.rotations)
    return DeckStep(
        name, held, forces, state.pressures, gravity=pull, along=oblique, heat=state.heat, removed=state.removed,
        friction=state.friction, fixed=frozenset(state.fixed),
    )  # fmt: skip


def _warn_of_bends(
    s: KeywordSection, state: StepState, times: tuple[float, float, float], own: bool, remarks: Remarks
) -> None:
    """Warn of an amplitude that goes beyond its ends within a step, of which only the end is solved."""
    found = state.amplitudes.get(s.parameters.get("AMPLITUDE", "").upper())
    its, total, period = times
    if found is None or not (own or found.total):
        return
    start, end = (total - period, total) if found.total else (0.0, its)
    if found.goes_beyond(start, end):
        remarks.warn(
            f"{s.place}: the amplitude {s.parameters['AMPLITUDE']!r} goes beyond its ends within a step, of which only "
            "the end is solved; with friction make each bend the end of a step."
        )


def follows_motion(keywords: Sequence[KeywordSection]) -> bool:
    """Whether a step is geometrically nonlinear, and with it those after it."""
    steps = (s.parameters for s in keywords if s.keyword == "STEP")
    return any("NLGEOM" in given and given["NLGEOM"].upper() != "NO" for given in steps)


def apply(s: KeywordSection, state: StepState, names: Names, times: tuple[float, float], remarks: Remarks) -> None:
    """Take a keyword of a step; for those that are not used see `unused`.

    Raises
    ------
    InputError
        If a load would be lost.
    """
    if s.keyword == "AMPLITUDE":
        state.amplitudes[s.parameters.get("NAME", "").upper()] = Amplitude.of(s)
        return
    if s.keyword == "TEMPERATURE" and len(state.initial):
        value, points = partial(state.value, s, times), names.special.points
        temperatures_of(s, lambda name: names.nodes(name, s.place), value, state.temperatures, points)
        return
    if s.keyword == "MODEL CHANGE" and "CONTACT" in s.parameters.get("TYPE", "").upper():
        sides = ([word.strip().upper() for word in f"{line},".split(",")] for line in s.lines)
        pairs = frozenset((slave, master) for slave, master, *_ in sides)
        state.removed = state.removed | pairs if "REMOVE" in s.parameters else state.removed - pairs
        return
    if s.keyword == "CHANGE FRICTION":
        state.changing = s.parameters.get("INTERACTION", "").upper()
        return
    if s.keyword == "FRICTION" and state.changing:
        state.friction[state.changing], state.changing = friction_of(s, remarks), ""
        return
    if s.keyword not in OF_LINES:
        unused(s, remarks)
        return
    if wrong := [p for p in MEANING if p in s.parameters]:
        raise not_done(f"{s.place}: *{s.keyword} with {', '.join(wrong)} is not done here.")
    _reset(s, state)
    for line in s.lines:
        words = [*(word.strip() for word in line.split(",")), *[""] * 4]
        OF_LINES[s.keyword](Line(s, words, state, names, times, remarks))


def friction_of(part: KeywordSection, remarks: Remarks) -> float:
    """Coefficient of friction of its keyword: the first one, infinite where rough."""
    if "ROUGH" in part.parameters:
        return math.inf
    if left := [word for word in OF_FRICTION if word in part.parameters]:
        remarks.warn(f"{part.place}: friction is the first coefficient, everywhere; {', '.join(left)} is not used.")
    return values_of(part.lines[0])[0] if part.lines and part.lines[0].strip(", ") else 0.0


@dataclass(frozen=True, eq=False)
class Line:
    """A data line of a keyword of `OF_LINES`, with what it changes."""

    s: KeywordSection
    words: list[str]
    state: StepState
    names: Names
    times: tuple[float, float]
    remarks: Remarks

    def value(self, k: int) -> float:
        """The load in word k at the end of the step."""
        return self.state.value(self.s, self.times, _number(self.words[k]))

    def nodes(self, k: int) -> IntArray:
        """Nodes of its set; without nodes of solids none, where the value in word k must be zero."""
        found = self.names.nodes(self.words[0], self.s.place)
        if found is None:
            self.lost(f"{self.words[0]} has no nodes of solids", k)
        return np.zeros(0, np.int64) if found is None else found

    def turned(self, nodes: IntArray) -> IntArray:
        """Places of the rotations of those nodes that have one."""
        rotations = self.names.special.rotations
        return np.array([rotations[k] for k in nodes.tolist() if k in rotations], dtype=np.int64)

    def lost(self, why: str, k: int) -> None:
        """Note that the line has no effect here; refuse it where the value in word k is not zero."""
        s, value = self.s, self.value(k)
        if value:
            raise InputError(f"{s.place}: *{s.keyword} of {value:g} would be lost: {why}.", code="load-would-be-lost")
        self.remarks.note(f"{s.place}: a line of *{s.keyword} is not used: {why}.")


def _reset(s: KeywordSection, state: StepState) -> None:
    """Drop what the first OP=NEW of a kind in a step replaces; *DLOAD and *DSLOAD are one kind, as in CalculiX."""
    kind = "DLOAD" if s.keyword == "DSLOAD" else s.keyword
    if s.parameters.get("OP", "MOD").upper() != "NEW" or kind in state.renewed:
        return
    state.renewed.add(kind)
    if kind == "BOUNDARY":
        state.held[:] = np.nan
        state.fixed.clear()
    elif kind == "CLOAD":
        state.forces[:] = 0.0
    else:
        state.pressures.clear()
        state.gravity.clear()
        state.rotations = []


def _hold(line: Line) -> None:
    """Supports and prescribed displacements: ``set, first, last, value`` or ``set, ENCASTRE``."""
    s, words, nodes = line.s, line.words, line.nodes(3)
    if not len(nodes):
        return
    if s.parameters.get("TYPE", "DISPLACEMENT").upper() != "DISPLACEMENT":
        raise InputError(f"{s.place}: expected displacements; found *BOUNDARY, TYPE={s.parameters['TYPE']}.")
    if "FIXED" in s.parameters:
        line.state.fixed.update(nodes.tolist())
        return
    line.state.fixed.difference_update(nodes.tolist())
    components, size = NAMED.get(words[1].upper()), 0.0
    if components is None:
        first, last = int(words[1]), int(words[2] or words[1])
        components, size = tuple(range(first - 1, last)), line.value(3)
    turns = {"ENCASTRE": (3, 4, 5), "XSYMM": (4, 5), "YSYMM": (3, 5), "ZSYMM": (3, 4)}.get(words[1].upper(), ())
    for c in (*components, *turns):
        if c < 3:
            line.state.held[nodes, c] = size
        elif len(turned := line.turned(nodes)):
            line.state.held[turned, c - 3] = size
    if len(nodes) > len(line.turned(nodes)) and max(components) > 2:
        line.remarks.note(f"{s.place}: components above 3 of nodes of solids in {words[0]!r} are not used.")


def _push(line: Line) -> None:
    """Forces on nodes, ``set, component, value``; they add up in a step and replace those of steps before."""
    nodes, state = line.nodes(2), line.state
    if not len(nodes):
        return
    c = int(line.words[1]) - 1
    if c > 2:
        turned = line.turned(nodes)
        if len(turned) < len(nodes):
            line.lost(f"nodes of solids have no component {c + 1}", 2)
            return
        nodes, c = turned, c - 3
    old = nodes[~state.given[nodes, c]]
    state.forces[old, c] = 0.0
    state.given[nodes, c] = True
    state.forces[nodes, c] += line.value(2)


def _load_cells(line: Line) -> None:
    """Pressures on faces, ``set, P2, value``, gravity, ``set, GRAV, size, x, y, z``, and forces of rotations."""
    words, names, place = line.words, line.names, line.s.place
    label = words[1].upper()
    if label == "GRAV":
        cells = names.cells(words[0], place) if words[0] else slice(None)
        line.state.pull(words[0].upper(), cells, line.value(2) * np.array([_number(word) for word in words[3:6]]))
    elif label == "CENTRIF":
        if words[0] and len(names.cells(words[0], place)) < len(names.mesh.cells):
            line.remarks.warn(f"{place}: CENTRIF acts on all bodies with a density, not on {words[0]!r} alone.")
        line.state.turn(Rotation.of(line.value(2), [_number(word) for word in words[3:9]], place))
    elif label[:1] == "P" and label[1:].isdigit():
        key = (words[0].upper(), label)
        if key not in names.faces:
            names.faces[key] = names.boundary_of(names.cells(words[0], place), label, place)
        line.state.press(names.faces[key], line.value(2))
    else:
        line.lost(f"expected P1, P2, ..., GRAV or CENTRIF; found {label!r} on {words[0]!r}", 2)


def _load_surface(line: Line) -> None:
    """Pressures on surfaces, ``surface, P, value``."""
    name, label = line.words[:2]
    if label.upper() != "P":
        line.lost(f"expected P; found {label!r} on {name!r}", 2)
        return
    line.state.press(look_up(name, line.names.mesh.boundaries, "surface of solids", line.s.place), line.value(2))


#: What takes the data lines of loads and supports.
OF_LINES = {"BOUNDARY": _hold, "CLOAD": _push, "DLOAD": _load_cells, "DSLOAD": _load_surface}


def _number(word: str) -> float:
    """A number, which may be blank or ``1.0D0``."""
    return float(word.upper().replace("D", "E")) if word else 0.0
