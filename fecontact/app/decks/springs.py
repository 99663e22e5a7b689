"""Springs of Abaqus and CalculiX decks: SPRINGA along the line of its nodes, SPRING1 and SPRING2 along an axis.

An end that belongs to no solid is the ground, where it is held. Source: Abaqus Analysis User's Guide, "Springs".
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.app.decks.content import DeckSpring
from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError
from fecontact.mesh.formats.abaqus_deck import KeywordSection, values_of
from fecontact.mesh.formats.raw import RawMesh

#: Number of nodes of each type.
TYPES = {"SPRINGA": 2, "SPRING1": 1, "SPRING2": 2}


def springs_of(model: Sequence[KeywordSection], raw: RawMesh, places: IntArray) -> list[DeckSpring]:
    """Springs of *ELEMENT and *SPRING.

    Parameters
    ----------
    model : sequence of KeywordSection
    raw : RawMesh
        With all nodes of the file.
    places : (n,) int array
        Points of the mesh that these are, -1 for nodes of no solid.

    Raises
    ------
    InputError
        If a law is not linear, an axis is not that of the nodes, or an end is loose.
    """
    elements = [s for s in model if s.keyword == "ELEMENT" and s.parameters.get("TYPE", "").upper() in TYPES]
    laws = {s.parameters.get("ELSET", "").upper(): s for s in model if s.keyword == "SPRING"}
    out = []
    for element in elements:
        name, kind = element.parameters.get("ELSET", ""), element.parameters["TYPE"].upper()
        if name.upper() not in laws:
            raise InputError(f"{element.place}: there is no *SPRING of the elements {name!r}.", code="spring-law")
        law = laws[name.upper()]
        rows = [values_of(line) for line in law.lines]
        if "NONLINEAR" in law.parameters or not rows or (kind != "SPRINGA" and len(rows) < 2):
            raise InputError(
                f"{law.place}: expected a linear *SPRING: its components and a stiffness.", code="spring-law"
            )
        components = [] if kind == "SPRINGA" else [int(v) for v in rows[0][: TYPES[kind]]]
        for number, *ends in (values_of(line) for line in element.lines):
            out.append(_spring(f"{name} {number:.0f}", kind, ends, components, rows[-1][0], element.place, raw, places))
    if loose := [s for s in out if None in (s.start, s.end)]:
        _check_ground(loose, model, raw)
    return out


def _spring(
    name: str, kind: str, ends: Sequence[float], components: Sequence[int], stiffness: float, place: str, raw: RawMesh,
    places: IntArray,
) -> DeckSpring:  # fmt: skip
    assert raw.node_ids is not None
    found = [np.flatnonzero(raw.node_ids == int(end)) for end in ends[: TYPES[kind]]]
    if len(found) != TYPES[kind] or any(len(at) != 1 for at in found):
        raise InputError(f"{place}: {kind} needs {TYPES[kind]} nodes; found {ends}.", code="spring-nodes")
    nodes = [int(at[0]) for at in found]
    x = raw.points[nodes]
    first, *others = (None if places[k] < 0 else int(places[k]) for k in nodes)
    size = float(np.linalg.norm(np.ptp(raw.points, axis=0)))
    if kind == "SPRING1":
        if not 1 <= components[0] <= 3:
            raise InputError(f"{place}: nodes of solids have no component {components[0]}.", code="spring-axis")
        # along the axis the length of the spring does not matter
        return DeckSpring(name, first, None, x[0], x[0] + size * np.eye(3)[components[0] - 1], stiffness, (nodes[0],))
    if kind == "SPRING2":
        along = x[1] - x[0]
        if len(set(components)) != 1 or np.abs(np.delete(along, components[0] - 1)).max() > 1e-9 * size:
            raise InputError(
                f"{place}: SPRING2 between components {components} of nodes {along.tolist()} apart is not done here: "
                "one component, along which the nodes lie.",
                code="spring-axis",
            )
    return DeckSpring(name, first, others[0], x[0], x[1], stiffness, tuple(nodes))


def _check_ground(springs: Sequence[DeckSpring], model: Sequence[KeywordSection], raw: RawMesh) -> None:
    """Refuse an end at a node of no solid that is not held at zero in all components."""
    assert raw.node_ids is not None
    held, none = np.zeros((len(raw.points), 3), bool), np.zeros(0, np.int64)
    sets = {k.upper(): v for k, v in raw.node_sets.items()}
    for line in (line for s in model if s.keyword == "BOUNDARY" for line in s.lines):
        name, first, last, value = [*(word.strip() for word in line.split(",")), "", "", ""][:4]
        nodes = np.flatnonzero(raw.node_ids == int(name)) if name.isdigit() else sets.get(name.upper(), none)
        if first.isdigit() and not float(value or 0):
            held[nodes, int(first) - 1 : int(last or first)] = True
    for spring in springs:
        for place, node in ((spring.start, spring.nodes[0]), (spring.end, spring.nodes[-1])):
            if place is None and len(spring.nodes) == 2 and not held[node].all():
                raise InputError(
                    f"The end of the spring {spring.name!r} at node {raw.node_ids[node]} is on no solid and not held "
                    "at zero in all components by *BOUNDARY of the model.",
                    code="spring-loose",
                )
