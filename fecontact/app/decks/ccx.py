"""A deck beside CalculiX: the same deck solved by ccx, where it is installed, and both answers in one table.

ccx solves a copy of the deck, with included files in it, in a temporary folder. Every step is asked for displacements,
forces and contact stresses at nodes (*NODE FILE, *CONTACT FILE), from which figures of the last time are taken. Forces
at the nodes of a body are reactions and loads; their sum is what contacts take away. Node to surface or face to face,
its contact gives way by a penalty, of which the deck states the stiffness or ccx takes its own.

Source: G. Dhondt, CalculiX CrunchiX User's Manual 2.20, *NODE FILE, *CONTACT FILE; the format of results files
(.frd), whose numbers are of single precision, in CalculiX GraphiX, "Results Format". A second run solves what is
solved here. Its penalties are `STIFFER` times as stiff: overlap is pressure over the one of *SURFACE BEHAVIOR,
`DEFAULT` times Young's modulus where none is given, and what sticks slips by shear over the one of *FRICTION; a
pressure over overlap that is meant, and solved here as it is, stays. Nodes that touch faces become faces that do: node
to surface fails the patch test. Elements of reduced integration become those of full, and strains are small (no
NLGEOM), unless poses were carried along here, or laws are of finite strain. Rigid motions that neither supports nor
contact determine, as a sector's turn about its axis, are held, and displacements compared up to them.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg
from scipy.spatial import cKDTree

from fecontact.app.decks.abaqus_steps import STATIC
from fecontact.app.decks.divided import divided_deck
from fecontact.app.decks.pretension import FIRST
from fecontact.app.decks.sections import AXES, state_of
from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.common.arrays import Array, IntArray
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, MissingPackageError, SolverError
from fecontact.common.files import save_figure
from fecontact.common.units import UnitNames, Units
from fecontact.fem.rigid import null_space
from fecontact.mesh.facets import components
from fecontact.mesh.formats.abaqus_deck import KeywordSection, read_sections, values_of
from fecontact.results.result import ContactResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Requests for results, in every step.
REQUESTS = "*NODE FILE\nU, RF\n*CONTACT FILE\nCSTR\n"
#: The same of sections, of which ccx makes solids: at the nodes of the deck.
PLANE_REQUESTS = "*NODE FILE, OUTPUT=2D\nU, RF\n"
#: Fields of .frd files that are read; the fourth component of the last is the pressure.
DISPLACEMENTS, FORCES, CONTACT = "DISP", "FORC", "CONTACT"
#: Contact of faces in ccx, and laws of overlap that its nodes alone follow.
FACES, OF_NODES = "SURFACE TO SURFACE", ("TABULAR", "EXPONENTIAL")
#: How many times as stiff the penalties of the second run are.
STIFFER = 50.0
#: The penalty of hard contact in ccx over the largest Young's modulus (measured; per length).
DEFAULT = 50.0
#: Part of the most that is resisted of rigid motions, below which it is rounding of a deck's coordinates.
LOOSE = 1e-4
#: Lines of a log that are shown of a run that failed.
LAST = 5


@dataclass(frozen=True, eq=False)
class FrdField:
    """A field at nodes: numbers (n,) and values (n, k)."""

    nodes: IntArray
    values: Array

    def at(self, nodes: IntArray) -> Array:
        """Values (m, k) at those of some nodes that it has."""
        return np.asarray(self.values[np.isin(self.nodes, nodes)])


def read_frd(path: Path) -> dict[str, FrdField]:
    """Displacements, forces and contact stresses of the last time of a results file in ASCII, by name.

    Raises
    ------
    InputError
        If a block is not as long or as wide as it says.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "small.frd"
    >>> lines = " -4  DISP        2    1", " -5  D1", " -5  D2", " -1         7 1.00000E+00-2.00000E+00", " -3"
    >>> _ = file.write_text(chr(10).join(lines))
    >>> read_frd(file)["DISP"].values.tolist()
    [[1.0, -2.0]]
    """
    lines = path.read_text(encoding="ascii", errors="replace").splitlines()
    heads = [k for k, line in enumerate(lines) if line.startswith(" -4")]
    last = {name: k for k in heads if (name := lines[k][5:13].strip()) in (DISPLACEMENTS, FORCES, CONTACT)}
    return {name: _field(path.name, name, lines, start) for name, start in last.items()}


def _field(file: str, name: str, lines: list[str], start: int) -> FrdField:
    """The field whose block begins at a line."""
    end = next((k for k in range(start, len(lines)) if lines[k].startswith(" -3")), None)
    if end is None:
        raise InputError(f"{file} ends within {name}: ccx was stopped.", code="frd")
    block = lines[start + 1 : end]
    width = sum(line.startswith(" -5") and not line.endswith("ALL") for line in block)
    rows = [line for line in block if line.startswith(" -1")]
    kind = [("key", "S3"), ("node", "S10"), ("values", "S12", (width,))]
    try:
        raw = np.frombuffer("".join(rows).encode(), kind)
        return FrdField(raw["node"].astype(np.int64), raw["values"].astype(float))
    except ValueError as error:
        raise InputError(f"{file}: {name} is not in rows of {width} numbers.", code="frd") from error


@compact_repr
@dataclass(frozen=True, eq=False)
class BesideCcx:
    """Figures of a result and of ccx.

    Attributes
    ----------
    rows : sequence of (str, float, float)
        Name of a figure, ours and that of ccx.
    apart : mapping of str to float
        Largest difference of the displacements of each body, over the largest of ccx.
    alike : mapping of str to float
        The figures of the second run of ccx; empty where nothing is to be changed, or it does not solve it.
    alike_apart : mapping of str to float
        As `apart`, of these.
    changes : str
        What the second run changes.
    moved : mapping of str to (2, n) array
        Size of the displacement of each node of a body: ours and that of ccx.
    """

    rows: Sequence[tuple[str, float, float]]
    apart: Mapping[str, float]
    alike: Mapping[str, float] = field(default_factory=dict)
    alike_apart: Mapping[str, float] = field(default_factory=dict)
    changes: str = ""
    moved: Mapping[str, Array] = field(default_factory=dict)

    def plot(self, path: str | Path | None = None, *, units: UnitNames = ()) -> Figure:
        """Displacements of all nodes by both, and by how much the figures of ccx differ.

        Parameters
        ----------
        path : str or Path, optional
            File to write.
        units : (length, ...) or str
            Names of units for labels, of which that of length counts; or it alone.
        """
        from matplotlib.figure import Figure

        figure = Figure(figsize=(11.0, 4.5), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1, 1.3))
        end = max((float(sizes.max(initial=0.0)) for sizes in self.moved.values()), default=0.0)
        left.plot([0, end], [0, end], color="0.6", linewidth=0.8)
        for name, sizes in self.moved.items():
            left.plot(*sizes, ".", markersize=3, label=name)
        names = Units.labels(units, "length")
        left.set(xlabel=names.axis_label("displacement of a node, fecontact", "length"), ylabel="ccx")
        left.legend(frameon=False)
        compared = [(name, ours, theirs) for name, ours, theirs in self.rows if ours and name != "seconds"]
        sets = {"ccx": {name: theirs for name, _, theirs in compared}}
        if self.alike:
            sets[f"ccx, {self.changes}"] = dict(self.alike)
        for k, (label, figures) in enumerate(sets.items()):
            off = [100 * (figures[name] / ours - 1) for name, ours, _ in compared]
            bars = right.barh(np.arange(len(compared)) + 0.4 * k, off, height=0.4, label=label)
            right.bar_label(bars, fmt="%.2g", padding=3)
        right.margins(x=0.15)
        right.set_yticks(np.arange(len(compared)) + 0.2 * (len(sets) - 1), [name for name, _, _ in compared])
        right.invert_yaxis()
        right.axvline(0.0, color="0.3", linewidth=0.8)
        right.set_xlabel("figure of ccx over that of fecontact, less 1 [%]")
        right.legend(frameon=False)
        return save_figure(figure, path)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        figures: dict[str, Any] = {name: {"fecontact": ours, "ccx": theirs} for name, ours, theirs in self.rows}
        for name, value in self.alike.items():
            figures[name]["ccx_alike"] = value
        figures["displacements_apart"] = dict(self.apart)
        return figures | ({"displacements_apart_alike": dict(self.alike_apart)} if self.alike else {})

    def __str__(self) -> str:
        width = max(len(name) for name, _, _ in self.rows)
        more = f" {'ccx alike':>13}  difference" if self.alike else ""
        lines = [f"{'Beside CalculiX':{width}}  {'fecontact':>13} {'ccx':>13}  difference {more}".rstrip()]
        for name, ours, theirs in self.rows:
            line = f"{name:{width}}  {ours:>13.6g}"
            for value in (theirs, *([self.alike[name]] if self.alike else [])):
                share = f"{100 * (value / ours - 1):+9.3f} %" if ours and name != "seconds" else ""
                line += f" {value:>13.6g}  {share:11}"
            lines.append(line.rstrip())
        sets = {"": self.apart, ", alike": self.alike_apart}
        for which, apart in sets.items():
            if off := ", ".join(f"{name} {100 * value:.2g} %" for name, value in apart.items()):
                lines.append(f"Displacements differ by at most, over the largest{which}: {off}")
        return "\n".join([*lines, *([f"Alike: {self.changes}"] * bool(self.changes))])


def check_ccx(deck: Path) -> str:
    """Path of ccx, for a deck that it can read.

    Raises
    ------
    InputError, MissingPackageError
    """
    if deck.suffix.lower() != ".inp":
        raise InputError(f"--beside ccx is for decks, .inp; found {deck.name}.", code="not-a-deck")
    if (found := shutil.which("ccx")) is None:
        raise MissingPackageError(
            "ccx was not found: --beside ccx runs CalculiX beside. Install it (Debian and Ubuntu: apt-get install "
            "calculix-ccx), and let it be found on PATH; without --beside the deck is solved here alone."
        )
    return found


def beside_ccx(deck: Path, result: ContactResult, n_steps: int | None = None, divide: int = 0) -> BesideCcx:
    """Solve a deck by ccx and compare with a result of it, of its last step, or the last of its first `n_steps`.

    Its cells are divided so many times as those of the result.

    Raises
    ------
    InputError, MissingPackageError
        See `check_ccx`.
    SolverError
        If ccx fails, with the end of what it said.
    """
    program, sections = check_ccx(deck), divided_deck(list(read_sections(deck)), deck.name, divide)
    ends = [k + 1 for k, section in enumerate(sections) if section.keyword == "END STEP"]
    sections = _static(sections if n_steps is None else sections[: ends[n_steps - 1]])
    beside = compared(result, *_solved(program, deck.name, sections))
    modulus = max((m.E for body in elastic_among(result.scene.bodies) for m in body.model.materials), default=0.0)
    soft = any(contact.overclosure is not None for contact in result.scene.contacts)
    changes = []
    for what, change in (
        ("faces on faces", _of_faces),
        (f"penalties x {STIFFER:g}", partial(_stiffened, modulus=modulus, soft=soft)),
        ("full integration", _in_full),
        ("small strains", list if result._originals or result.finite_strain else _small),
        ("held where nothing resists", partial(_held, result=result)),
    ):
        changed = change(sections)
        changes += [what] * (changed != sections)
        sections = changed
    if not changes:
        return beside
    try:
        alike = compared(result, *_solved(program, deck.name, sections))
    except SolverError:
        return replace(beside, changes=f"ccx does not solve it with {', '.join(changes)}.")
    figures = {name: value for name, _, value in alike.rows}
    return replace(beside, alike=figures, alike_apart=alike.apart, changes=", ".join(changes))


def _static(sections: list[KeywordSection]) -> list[KeywordSection]:
    """Without the steps that are not static, as those of frequencies: the answer is that of the last static step."""
    kept, step = [], list[KeywordSection]()
    for section in sections:
        if step or section.keyword == "STEP":
            step.append(section)
        else:
            kept.append(section)
        if section.keyword == "END STEP":
            kept += step if any(part.keyword in STATIC for part in step) else []
            step = []
    return kept + step


def _of_faces(sections: list[KeywordSection]) -> list[KeywordSection]:
    """Sections with contact of faces in place of nodes, where the slave has faces and the law is one of faces too."""
    nodes = {s.parameters.get("NAME", "").upper() for s in sections if s.parameters.get("TYPE", "").upper() == "NODE"}
    owner, of_nodes = "", set[str]()
    for s in sections:
        owner = s.parameters.get("NAME", "").upper() if s.keyword == "SURFACE INTERACTION" else owner
        if s.keyword == "SURFACE BEHAVIOR" and s.parameters.get("PRESSURE-OVERCLOSURE", "HARD").upper() in OF_NODES:
            of_nodes.add(owner)
    return [
        replace(s, parameters={k: v for k, v in s.parameters.items() if k != "SMALL SLIDING"} | {"TYPE": FACES})
        if s.keyword == "CONTACT PAIR"
        and s.parameters.get("TYPE", "").upper() == "NODE TO SURFACE"
        and s.parameters.get("INTERACTION", "").upper() not in of_nodes
        and not any(line.split(",")[0].strip().upper() in nodes for line in s.lines)
        else s
        for s in sections
    ]


def _held(sections: list[KeywordSection], result: ContactResult) -> list[KeywordSection]:
    """Sections with a support of one node for each rigid motion that is not determined."""
    lines = []
    for body in elastic_among(result.scene.bodies):
        modes, numbers = _undetermined(result, body), body.mesh.file_nodes
        assert numbers is not None
        used = np.zeros(len(modes), bool) if body.conditions is None else np.diff(body.conditions.tocsc().indptr) > 0
        choice = np.flatnonzero(~used & np.repeat(numbers >= 0, 3))
        order = scipy.linalg.qr(modes[choice].T, mode="economic", pivoting=True)[2]
        for node, component in zip(*np.divmod(choice[order[: modes.shape[1]]], 3), strict=True):
            lines.append(f"{numbers[node]},{component + 1}")
    first = next(k for k, s in enumerate(sections) if s.keyword == "STEP")
    if not lines or any(s.keyword == "TRANSFORM" for s in sections):
        return sections
    return [*sections[:first], KeywordSection("BOUNDARY", {}, lines), *sections[first:]]


def _undetermined(result: ContactResult, body: ElasticBody) -> Array:
    """Rigid motions (3 n, k) of a body that its supports and conditions leave free where nothing touches."""
    if result.contacts or result.springs or body._dimension != "space":
        return np.zeros((3 * len(body.mesh.points), 0))
    return body.rigid_modes @ null_space(body.model.nodal_modes[body.model.held], body.size, LOOSE)


def _in_full(sections: list[KeywordSection]) -> list[KeywordSection]:
    """Sections with elements of full integration in place of reduced."""
    reduced = re.compile(r"(?<=\d)R$", re.IGNORECASE)
    return [
        replace(s, parameters={k: reduced.sub("", v) if k == "TYPE" else v for k, v in s.parameters.items()})
        if s.keyword == "ELEMENT"
        else s
        for s in sections
    ]


def _small(sections: list[KeywordSection]) -> list[KeywordSection]:
    """Sections with steps of small strains."""
    return [
        replace(s, parameters={k: v for k, v in s.parameters.items() if k != "NLGEOM"}) if s.keyword == "STEP" else s
        for s in sections
    ]


def _stiffened(sections: list[KeywordSection], modulus: float, soft: bool) -> list[KeywordSection]:
    """Sections with penalties `STIFFER` times as stiff, those of overlap unless they are meant to be soft.

    One of what sticks, which decks often take far softer, becomes that of hard contact at least.
    """
    hard = STIFFER * DEFAULT * modulus
    out = list[KeywordSection]()
    for section in sections:
        form = section.parameters.get("PRESSURE-OVERCLOSURE", "HARD").upper()
        overlap = section.keyword == "SURFACE BEHAVIOR" and not soft
        if overlap and form == "HARD":
            section = replace(section, parameters={"PRESSURE-OVERCLOSURE": "LINEAR"}, lines=[f"{hard:.12g}"])
        elif overlap and form in ("LINEAR", "TIED"):
            section = _scaled(section, 0, 0.0)
        elif section.keyword == "FRICTION":
            section = _scaled(section, 1, hard)
        out.append(section)
    return out


def _scaled(section: KeywordSection, word: int, least: float) -> KeywordSection:
    """A keyword with a number of its first line, zero where it is left out, `STIFFER` times as large or `least`."""
    first, *others = section.lines or [""]
    words = [*first.split(","), *[""] * word]
    if not words[0].strip():
        return section
    words[word] = f"{max(STIFFER * values_of(words[word] + ',')[0], least):.12g}"
    words = words[: max(word + 1, len(first.split(",")))]
    return replace(section, lines=[",".join(words), *others])


def _solved(program: str, name: str, sections: list[KeywordSection]) -> tuple[dict[str, FrdField], float]:
    """Fields of the last time by ccx, and its seconds."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "deck.inp"
        requests = REQUESTS if state_of(sections) is None else PLANE_REQUESTS
        copy.write_text("".join(_text(section, requests) for section in sections), encoding="utf-8")
        start = time.perf_counter()
        ran = subprocess.run(
            [program, "deck"], cwd=folder, capture_output=True, text=True, errors="replace", check=False
        )
        seconds = time.perf_counter() - start
        results = copy.with_suffix(".frd")
        fields = read_frd(results) if ran.returncode == 0 and results.is_file() else {}
    if DISPLACEMENTS not in fields:
        said = " / ".join([line.strip() for line in ran.stdout.splitlines() if line.strip(" _")][-LAST:])
        raise SolverError(f"ccx did not solve {name} (status {ran.returncode}): {said}", code="ccx-failed")
    return fields, seconds


def _text(section: KeywordSection, requests: str) -> str:
    """A keyword as it is written, with requests for results before the end of a step."""
    parameters = "".join(f", {name}={value}" if value else f", {name}" for name, value in section.parameters.items())
    lines = "".join(f"{line}\n" for line in section.lines)
    return f"{requests if section.keyword == 'END STEP' else ''}*{section.keyword}{parameters}\n{lines}"


def _in_axes_of(body: ElasticBody, values: Array) -> Array:
    """Values (n, k) of ccx in the axes of a body: a section here lies in the plane of x and z, there of x and y."""
    return values if body._dimension == "space" else np.concatenate([values[:, AXES], values[:, 3:]], axis=1)


def compared(result: ContactResult, whole: Mapping[str, FrdField], seconds: float) -> BesideCcx:
    """Figures of a result and of the fields of ccx: motions and forces of each body, the largest pressure, time."""
    rows, apart, moved = [], {}, {}
    for body in elastic_among(result.scene.bodies):
        fields = {name: replace(field, values=_in_axes_of(body, field.values)) for name, field in whole.items()}
        given = fields[DISPLACEMENTS]
        numbers = body.mesh.file_nodes
        assert numbers is not None
        _, own, other = np.intersect1d(numbers, given.nodes, return_indices=True)
        ours, theirs = result.displacement(body)[own], given.values[other, :3]
        modes = _undetermined(result, body)[(3 * own[:, None] + np.arange(3)).ravel()]
        theirs = theirs - (modes @ np.linalg.lstsq(modes, (theirs - ours).ravel(), rcond=None)[0]).reshape(-1, 3)
        moved[body.name] = np.linalg.norm([ours, theirs], axis=2)
        sizes = [float(np.linalg.norm(u, axis=1).max(initial=0.0)) for u in (ours, theirs, ours - theirs)]
        rows.append((f"largest displacement of {body.name}", sizes[0], sizes[1]))
        apart[body.name] = sizes[2] / sizes[1] if sizes[1] else sizes[0]
        if FORCES in fields and any(body in contact.bodies for contact in result.contacts):
            taken = sum(_on(contact, body) for contact in result.contacts) + np.zeros(3)
            force = fields[FORCES].at(_off_cuts(body))[:, :3].sum(axis=0)
            if body._dimension == "axis":
                force[:2] = 0.0  # of a ring
            rows.append((f"contact force on {body.name}", float(np.linalg.norm(taken)), float(np.linalg.norm(force))))
        elif FORCES in fields:
            # nothing touches it, so that its forces sum to zero: those of every support by itself
            rows.append((f"forces of supports on {body.name}", *_held_forces(body, result, fields[FORCES])))
    if CONTACT in whole and result.contacts:
        peak = float(whole[CONTACT].values[:, 3].max(initial=0.0))
        rows.append(("largest pressure", max(c.max_pressure for c in result.contacts), peak))
    return BesideCcx([*rows, ("seconds", result.seconds["total"], seconds)], apart, moved=moved)


def _off_cuts(body: ElasticBody) -> IntArray:
    """Numbers of nodes but those of pre-tension sections, at which ccx has the forces of the sections too."""
    numbers, x = body.mesh.file_nodes, body.mesh.points
    assert numbers is not None
    cut = x[numbers >= FIRST]
    return numbers if not len(cut) else numbers[cKDTree(cut).query(x)[0] > 0]


def _held_forces(body: ElasticBody, result: ContactResult, given: FrdField) -> tuple[float, float]:
    """Sizes of the forces on groups of held nodes that share cells, summed: ours and those of ccx."""
    numbers, cells = body.mesh.file_nodes, body.mesh.cells
    assert numbers is not None
    held = np.zeros(len(body.mesh.points), bool)
    for name in body.supports:
        held[body.mesh.boundary_nodes(name)] = True
    cell, column = np.nonzero(held[cells])
    nodes = cells[cell, column]
    n = len(held) + len(cells)
    group = components(n, np.stack([nodes, len(held) + cell], axis=1))[np.unique(nodes)]
    ours, theirs = result._forces_inside(body), np.zeros((len(held), 3))
    _, own, other = np.intersect1d(numbers, given.nodes, return_indices=True)
    theirs[own] = given.values[other, :3]
    sums = []
    for forces in (ours, theirs):
        total = np.zeros((n, 3))
        np.add.at(total, group, forces[np.unique(nodes)])
        sums.append(float(np.linalg.norm(total, axis=1).sum()))
    return sums[0], sums[1]


def _on(contact: Any, body: Any) -> Array:
    """Force (3,) of a contact on a body, friction included."""
    first, second = contact.bodies
    sign = 1.0 if body is first else -1.0 if body is second else 0.0
    return np.asarray(sign * contact._whole.force)
