"""Contents of a deck, with node and cell numbers of its mesh, before bodies are made."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.contact.overclosure import SoftContact
from fecontact.fem.laws import Law
from fecontact.fem.model import AnyMaterial
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import PlaneCells
from fecontact.mesh.surface_mesh import SurfaceMesh


@dataclass(frozen=True, eq=False)
class DeckFrame:
    """What moves a rigid part in a step.

    Attributes
    ----------
    rigid : str
        Its name.
    motions : mapping of component to float
        Prescribed motions that are not zero.
    free : str
        Components that are neither held nor prescribed nor loaded.
    force, moment : (3,) arrays
        About its centre.
    """

    rigid: str
    motions: Mapping[str, float]
    free: str
    force: Array
    moment: Array

    @property
    def is_free(self) -> bool:
        """Whether its motion is unknown."""
        return bool(self.free or self.force.any() or self.moment.any())


@dataclass(frozen=True, eq=False)
class DeckStep:
    """Supports and loads at the end of a step.

    Attributes
    ----------
    name : str
    held : (n_all, 3) array
        Prescribed displacements, 0 where held, NaN where free, of the mesh's points and then of reference nodes.
    forces : (n_all, 3) array
        Forces on nodes.
    pressures : mapping of boundary to float
    tractions : mapping of boundary to (3,) array
    gravity : (3,) array, or function of points
    frames : sequence of DeckFrame
    along : (n_all, 3) array, optional
        Prescribed displacements along the axes of nodes that have their own, oblique ones.
    heat : (n_all,) array, optional
        Changes of temperature.
    removed : frozenset of (str, str)
        Contact pairs, slave and master in capitals, that the step has removed.
    friction : mapping of str to float
        Coefficients that have changed, by the name of the interaction in capitals.
    fixed : frozenset of int
        Nodes that are held where they are.
    """

    name: str
    held: Array
    forces: Array
    pressures: Mapping[str, float] = field(default_factory=dict)
    tractions: Mapping[str, Array] = field(default_factory=dict)
    gravity: Array | Callable[[Array], Array] = field(default_factory=lambda: np.zeros(3))
    frames: Sequence[DeckFrame] = ()
    along: Array | None = None
    heat: Array | None = None
    removed: frozenset[tuple[str, str]] = frozenset()
    friction: Mapping[str, float] = field(default_factory=dict)
    fixed: frozenset[int] = frozenset()

    def held_as(self, nodes: IntArray | slice, others: int) -> tuple[bytes, ...]:
        """What it holds of points of the mesh, and of reference nodes, which begin at `others`."""
        every = [self.held] if self.along is None else [self.held, self.along]
        return tuple(np.isfinite(held[part]).tobytes() for held in every for part in (nodes, slice(others, None)))


@dataclass(frozen=True)
class DeckPair:
    """Two surfaces that touch, or that are tied: names of boundaries, the slave first, and their line in the deck."""

    slave: str
    master: str
    friction: float
    place: str
    #: Distance up to which nodes are tied; None for the default.
    reach: float | None = None
    overclosure: SoftContact | None = None
    #: Distance up to which nodes of the slave are moved onto the master, and the gap they get; None leaves them.
    adjust: float | None = None
    #: Node set of those that are moved; empty where it is all.
    adjusted: str = ""
    clearance: float | None = None
    #: Of its interaction, in capitals.
    interaction: str = ""
    #: Of ties: whether faces are tied to faces, so that the side of closer nodes follows, whichever is named first.
    of_faces: bool = False


@dataclass(frozen=True, eq=False)
class DeckSpring:
    """A linear spring between two points of the mesh, or one and the ground (None), at places (3,) in the deck.

    `nodes` are the nodes of the file by their order there.
    """

    name: str
    start: int | None
    end: int | None
    first: Array
    second: Array
    stiffness: float
    nodes: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class DeckCut:
    """A pre-tension section: its reference node, which has its shortening, and where both sides of the cut are.

    Attributes
    ----------
    reference, place : str
    twins : (n, 2) int array
        Points of its sides A and B.
    direction : (3,) array
        Unit vector in the axes of the deck.
    node : int
        Place of the reference node.
    """

    reference: str
    place: str
    twins: IntArray
    direction: Array
    node: int = -1


@dataclass
class Remarks:
    """Remarks on a deck: notes, warnings of what may change its answer, and keywords that ask for output."""

    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def note(self, text: str) -> None:
        """Add a note."""
        self.notes.append(text)

    def warn(self, text: str) -> None:
        """Add a warning."""
        self.warnings.append(text)

    @property
    def all_notes(self) -> tuple[str, ...]:
        """Notes, each once, and one on all requests for output."""
        some = ", ".join(dict.fromkeys(r.rpartition(": ")[2] for r in self.requests))
        places = f"{self.requests[0].partition(': ')[0]} and after: " if self.requests else ""
        return tuple(
            dict.fromkeys([*self.notes, *([f"{places}requests for output are not used: {some}."] * bool(some))])
        )


@dataclass(frozen=True, eq=False)
class DeckRigid:
    """A rigid part.

    Attributes
    ----------
    name : str
    centre : (3,) array
        About which it turns.
    surface : SurfaceMesh, optional
        Its contact surfaces; None if it has none.
    names : frozenset of str
        Names of these.
    attached : int array
        Points of elastic cells that move with it.
    normal : (3,) array, optional
        Of a plane wall through the centre, which has no mesh.
    mass : float, optional
        None where it is not known.
    """

    name: str
    centre: Array
    surface: SurfaceMesh | None
    names: frozenset[str]
    attached: IntArray
    normal: Array | None = None
    mass: float | None = None


@dataclass(frozen=True, eq=False)
class DeckContent:
    """Contents of a deck.

    Attributes
    ----------
    source, title : str
    mesh : Mesh or PlaneCells
    sections : sequence of (IntArray, str)
        Cells of each material.
    materials : mapping of str to Material or Law
    steps : sequence of DeckStep
        At least one.
    contacts, ties : sequence of DeckPair
    notes : sequence of str
        What was changed, and what is not used, with its line.
    rigid : sequence of DeckRigid
    warnings : sequence of str
        The same of what may change the answer.
    springs : sequence of DeckSpring
    finite_motion : bool, optional
        Whether poses are carried along; None where the deck leaves it open.
    conditions : (m, 3 n_all) csr_matrix, optional
        Linear conditions between displacements, see `conditions`.
    axes : mapping of int to (3, 3) array
        Axes of nodes that have their own, as rows.
    state : str, optional
        'axis', 'strain' or 'stress' of sections, whose mesh is of `PlaneCells`; None for solids.
    thicknesses : sequence of float
        Of the sections, in their order.
    between : (n, 3) int array, optional
        Points of sections that are no nodes of the deck and lie between two others: their numbers, and those of these.
    cuts : sequence of DeckCut
    """

    source: str
    title: str
    mesh: Mesh | PlaneCells
    sections: Sequence[tuple[IntArray, str]]
    materials: Mapping[str, AnyMaterial | Law]
    steps: Sequence[DeckStep]
    contacts: Sequence[DeckPair]
    ties: Sequence[DeckPair]
    notes: Sequence[str]
    rigid: Sequence[DeckRigid] = ()
    warnings: Sequence[str] = ()
    finite_motion: bool | None = None
    springs: Sequence[DeckSpring] = ()
    conditions: sp.csr_matrix | None = None
    axes: Mapping[int, Array] = field(default_factory=dict)
    state: str | None = None
    thicknesses: Sequence[float] = ()
    between: IntArray | None = None
    cuts: Sequence[DeckCut] = ()


def look_up(name: str, known: Mapping[str, IntArray], what: str, place: str) -> str:
    """The spelling of a name, whose case these files ignore.

    Raises
    ------
    InputError
        If there is no such name.
    """
    for k in known:
        if k.upper() == name.upper():
            return k
    raise InputError(f"{place}: there is no {what} {name!r}; there are: {', '.join(map(repr, known)) or 'none'}.")


def numbered(ids: IntArray | None, wanted: Sequence[int], what: str, place: str) -> IntArray:
    """Positions of a file's numbers among `ids`.

    Raises
    ------
    InputError
        If one is not there, or there more than once (in several instances).
    """
    given = np.zeros(0, np.int64) if ids is None else ids
    order = np.argsort(given, kind="stable")
    number = np.asarray(wanted, dtype=np.int64)
    first, last = (np.searchsorted(given, number, side=side, sorter=order) for side in ("left", "right"))
    if (last - first != 1).any():
        k = int(np.argmax(last - first != 1))
        found = "is none of the solids" if last[k] == first[k] else "is in several parts; name a set instead"
        raise InputError(f"{place}: the {what} {number[k]} {found}.")
    return np.asarray(order[first], dtype=np.int64)
