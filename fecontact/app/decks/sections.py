"""Sections in decks of Abaqus and CalculiX: CAX, CPE and CPS elements as bodies of revolution and plane bodies.

In these programs sections lie in the plane of x and y, where x is the radius and y the axis; here in that of x and z.
Forces on nodes are those of the whole ring, or of the whole thickness (Abaqus Analysis User's Guide, "Choosing the
element's dimensionality"; measured in results of CalculiX 2.20).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from fecontact.app.decks.content import DeckStep
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.mesh.formats.abaqus_deck import SHEET, KeywordSection
from fecontact.mesh.section_mesh import PlaneCells, line_integrals

#: Types of plane and axisymmetric elements.
PLANE = re.compile(r"C(PS|PE|PEG|AX|GAX)\d")
STATES = {"CAX": "axis", "CPE": "strain", "CPS": "stress"}
#: Components x, z, y of space are x, y, z of a section.
AXES = [0, 2, 1]


def state_of(keywords: Sequence[KeywordSection]) -> str | None:
    """'axis', 'strain' or 'stress' of a deck whose elements are all of one of these; None for one of solids.

    Raises
    ------
    InputError
        If it has elements of several kinds, or of one that is not done.
    """
    kinds = {s.parameters.get("TYPE", "").upper(): s.place for s in keywords if s.keyword == "ELEMENT"}
    if not any(map(PLANE.match, kinds)):
        return None
    states = {kind: STATES[found[1]] if (found := SHEET.match(kind)) else "" for kind in kinds}
    if len(set(states.values())) > 1 or "" in states.values():
        wrong = next((kind for kind, state in states.items() if not state), list(states)[-1])
        raise InputError(
            f"{kinds[wrong]}: the elements are of the types {', '.join(kinds)}; expected solids alone, or one of CAX, "
            "CPE and CPS alone, of 3, 4, 6 or 8 nodes.",
            code="elements-mixed",
        )
    return next(iter(states.values()))


def face_surfaces(keywords: Sequence[KeywordSection]) -> tuple[list[KeywordSection], dict[tuple[str, str], str]]:
    """Surfaces for the pressures of *DLOAD, and their names by set and label.

    Sides are looked for before cells are divided.
    """
    names: dict[tuple[str, str], str] = {}
    out = []
    for s in keywords:
        for line in s.lines if s.keyword == "DLOAD" else ():
            words = [word.strip().upper() for word in line.split(",")]
            if re.match(r"P\d$", words[1]) and (words[0], words[1]) not in names:
                names[words[0], words[1]] = name = f"{words[1]} of {words[0]}"
                given = line.split(",")[0].strip()
                out.append(KeywordSection("SURFACE", {"NAME": name}, [f"{given}, S{words[1][1:]}"], s.place))
    return out, names


def in_section(step: DeckStep, moving: Mask, source: str) -> DeckStep:
    """A step with z of the deck as y across the section, in which nothing moves.

    Raises
    ------
    InputError
        If something acts or is moved across the section.
    """
    field = step.gravity
    weight = np.zeros(3) if callable(field) else field
    across = [np.nan_to_num(step.held[moving, 2]), step.forces[moving, 2], weight[2:]]
    if any(values.any() for values in across):
        raise InputError(
            f"{source}: {step.name} moves or loads a section along z, across its plane.", code="across-section"
        )
    held, forces = step.held.copy(), step.forces.copy()
    held[moving], forces[moving] = held[moving][:, AXES], forces[moving][:, AXES]
    held[moving, 1] = np.nan
    turned = (lambda x: field(x[:, AXES])[:, AXES]) if callable(field) else field[AXES]
    return replace(step, held=held, forces=forces, gravity=turned)


def conditions_in_section(conditions: sp.csr_matrix | None, moving: Mask) -> sp.csr_matrix | None:
    """Conditions (m, 3 n) over components of a section; those of z alone fall away."""
    if conditions is None:
        return None
    place = np.arange(len(moving))[:, None]
    order = np.where(moving[:, None], 3 * place + np.array(AXES), 3 * place + np.arange(3))
    kept = np.where(moving[:, None], [1.0, 0.0, 1.0], 1.0)
    out = sp.csr_matrix(conditions[:, order.ravel()] @ sp.diags(kept.ravel()))
    out.eliminate_zeros()
    return out[np.flatnonzero(np.diff(out.indptr))]


def axes_in_section(axes: Mapping[int, Array]) -> dict[int, Array]:
    """Axes of nodes with z of the deck as y."""
    return {node: own[:, AXES] for node, own in axes.items()}


def even_on(mesh: PlaneCells, name: str, revolved: bool) -> Array:
    """Nodal weights (n_points,) of an even pressure on a boundary."""
    sides = mesh.face_nodes(mesh.faces(name))
    N, x, ds = line_integrals(mesh.points, sides)
    width = 2 * np.pi * x[..., 0] if revolved else np.ones(x.shape[:2])
    even = np.einsum("qa,fq->fa", N, np.linalg.norm(ds, axis=2) * width)
    return np.asarray(np.bincount(sides.ravel(), even.ravel(), minlength=len(mesh.points)), float)


def thickness_of(cells: IntArray, sections: Sequence[tuple[IntArray, str]], given: Sequence[float], name: str) -> float:
    """The thickness of the cells of a body.

    Raises
    ------
    InputError
        If it is not one.
    """
    found = {float(t) for (own, _), t in zip(sections, given, strict=True) if np.isin(own, cells).any()}
    if len(found) != 1:
        raise InputError(f"The body {name!r} has the thicknesses {sorted(found)}; here it has one.", code="thickness")
    return found.pop()
