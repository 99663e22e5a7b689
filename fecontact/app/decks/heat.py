"""Temperatures of Abaqus and CalculiX decks, and forces of rotation.

Sources: Abaqus Keywords Reference and CalculiX manual, *EXPANSION, *INITIAL CONDITIONS, *TEMPERATURE, *DLOAD with
CENTRIF (square of the angular velocity, a point and the direction of the axis).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, not_done
from fecontact.mesh.formats.abaqus_deck import KeywordSection, values_of
from fecontact.mesh.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Rotation:
    """Force per mass w^2 r away from an axis.

    Examples
    --------
    >>> Rotation(4.0, np.zeros(3), np.array([0.0, 0.0, 1.0]))(np.array([[2.0, 0.0, 5.0]])).tolist()
    [[8.0, 0.0, 0.0]]
    """

    square: float
    point: Array
    axis: Array

    @classmethod
    def of(cls, square: float, words: Sequence[float], place: str) -> Rotation:
        """Of the words of a data line after CENTRIF's size: a point and a direction.

        Raises
        ------
        InputError
            If the direction is zero.
        """
        point, axis = np.array([*words, *[0.0] * 6][:3]), np.array([*words, *[0.0] * 6][3:6])
        if not axis.any():
            raise InputError(f"{place}: CENTRIF needs a point and a direction of its axis; found {list(words)}.")
        return cls(square, point, axis / np.linalg.norm(axis))

    def __call__(self, points: Array) -> Array:
        """Forces per mass (n, 3) at points (n, 3)."""
        away = points - self.point
        return np.asarray(self.square * (away - np.outer(away @ self.axis, self.axis)))


def together(gravity: Array, rotations: Sequence[Rotation]) -> Array | Callable[[Array], Array]:
    """Gravity alone (3,), or with forces of rotations a function of points."""
    if not rotations:
        return gravity
    return lambda points: gravity + sum((turn(points) for turn in rotations), np.zeros(3))


def expansion_of(s: KeywordSection) -> float | tuple[float, float, float]:
    """Coefficient of *EXPANSION, or those along three axes (TYPE=ORTHO), the same at every temperature.

    Raises
    ------
    InputError
        If it is another one.
    """
    rows = [values_of(line) for line in s.lines]
    form = s.parameters.get("TYPE", "ISO").upper()
    n = 1 if form.startswith("ISO") else 3 if form.startswith("ORTHO") else 0
    if not n or not rows or any(len(row) < n or row[:n] != rows[0][:n] for row in rows):
        raise InputError(
            f"{s.place}: expected *EXPANSION of type ISO or ORTHO, with one or three coefficients that are the same at "
            f"all temperatures; found type {form}, {s.lines[:2]}.",
            code="expansion",
        )
    first = rows[0]
    return first[0] if n == 1 else (first[0], first[1], first[2])


def temperatures_of(
    s: KeywordSection,
    nodes: Callable[[str], IntArray | None],
    value: Callable[[float], float],
    now: Array,
    points: Array,
) -> None:
    """Set the temperatures (n_points,) of the nodes that data lines name, in place.

    With LINTEMP lines are a vector and two distances along it with their temperatures, between which it is linear at
    points (n_points, 3); others keep theirs (CalculiX manual, *TEMPERATURE).

    Raises
    ------
    InputError
        For values from elsewhere, or a field that is no list of nodes.
    """
    if wrong := [p for p in ("USER", "FILE", "BSTEP", "SUBMODEL") if p in s.parameters]:
        raise not_done(f"{s.place}: *{s.keyword} with {', '.join(wrong)} is not done here.")
    for line in s.lines if "LINTEMP" in s.parameters else ():
        a, b, c, *ends = values_of(line)
        along = points @ (np.array([a, b, c]) / np.linalg.norm([a, b, c]))
        (first, second), levels = np.reshape(ends[:4], (2, 2)).T
        if first == second:
            raise InputError(f"{s.place}: the two distances of LINTEMP are the same, {first:g}.", code="temperature")
        share = (along - first) / (second - first)
        within = (share >= 0) & (share <= 1)
        now[within] = value(1.0) * (levels[0] + share[within] * (levels[1] - levels[0]))
    for line in s.lines if "LINTEMP" not in s.parameters else ():
        name, _, rest = line.partition(",")
        found = nodes(name.strip())
        if found is not None:
            now[found] = value(values_of(rest)[0])


def changes(mesh: Mesh, change: Array, nodes: IntArray) -> Array:
    """Changes of temperature (n,) at the points of a body's mesh, of nodes (k,) of the deck and of faces' middles."""
    own = change[nodes]
    if len(own) == len(mesh.points):
        return own
    assert mesh.midface is not None
    out = np.concatenate([own, np.zeros(len(mesh.points) - len(own))])
    cells, faces = np.nonzero(mesh.midface >= 0)
    corners = mesh.face_nodes(np.stack([cells, faces], axis=1))[:, :4]
    # the last two corners of a triangle are one node
    third = corners[:, 2] == corners[:, 3]
    weights = np.where(third[:, None], [1 / 3, 1 / 3, 1 / 6, 1 / 6], 1 / 4)
    out[mesh.midface[cells, faces]] = (weights * out[corners]).sum(axis=1)
    return out
