"""Hexahedra on an index box, to be mapped to a shape, and the positions of its indices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import items
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, array_of, whole
from fecontact.common.errors import InputError, shown
from fecontact.mesh.mesh import Mesh

#: Largest deviation of the end positions, as a share of the size, that is corrected as rounding.
SAME_POSITION = 1e-9

#: Largest numbers of cells, of a mesh and along one line; beyond, arrays of nodes alone fill tens of gigabytes.
MOST_CELLS, MOST_ALONG = 10**8, 10**6

_NODES = {"hex8": 8, "hex20": 20, "hex27": 27}


def lattice(divisions: Sequence[int], names: Sequence[str | None], element: str = "hex20") -> Mesh:
    """Mesh of an index box [0, n1] x [0, n2] x [0, n3], to be mapped to its true shape.

    Parameters
    ----------
    divisions : three ints
    names : six names or None
        Boundaries at i = 0, i = n1, j = 0, j = n2, k = 0, k = n3.
    element : {'hex8', 'hex20', 'hex27'}
    """
    among("element", element, _NODES)
    given = items("the divisions", divisions, "three counts")
    if len(given) != 3:
        raise InputError(f"Divisions must be three positive integers; found {shown(divisions)}.")
    n = np.array([whole("a division", count) for count in given])
    if np.prod(n.astype(float)) > MOST_CELLS:
        raise InputError(f"{given} divisions are {np.prod(n.astype(float)):.3g} cells, more than {MOST_CELLS:.0e}.")
    index = np.arange(np.prod(n + 1)).reshape(n + 1)
    points = np.stack(np.meshgrid(*(np.arange(k + 1.0) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([index[tuple(slice(c, c + k) for c, k in zip(cor, n, strict=True))].ravel() for cor in corners], 1)
    number = np.arange(len(cells)).reshape(n)
    boundaries: dict[str, IntArray] = {}
    for face, name in enumerate(names):
        if name is not None:
            layer = np.take(number, -1 if face % 2 else 0, axis=face // 2).ravel()
            faces = np.stack([layer, np.full_like(layer, face)], axis=1)
            boundaries[name] = np.concatenate([boundaries[name], faces]) if name in boundaries else faces
    mesh = Mesh(points, cells, boundaries)
    return mesh if element == "hex8" else mesh.upgraded(_NODES[element])


def division(size: float, given: int | ArrayLike, what: str) -> Array:
    """Positions 0 ... size: an equal division, or the given increasing positions.

    Raises
    ------
    InputError
        If they do not increase or do not run from 0 to `size`; `what` names them in the message.
    """
    if isinstance(given, int | np.integer):
        return np.linspace(0.0, size, whole(f"the {what}", given, most=MOST_ALONG) + 1)
    found = array_of(given)
    positions = np.zeros(0) if found is None else found
    if positions.ndim != 1 or len(positions) < 2 or not (np.diff(positions) > 0).all():
        raise InputError(f"The {what} must be a count or increasing positions; found {shown(given)}.")
    if np.abs(positions[[0, -1]] - [0.0, size]).max() > SAME_POSITION * size:
        raise InputError(
            f"The positions of the {what} must run from 0 to {size:g}; found {positions[0]:g} to {positions[-1]:g}."
        )
    inner = positions[1:-1]
    return np.concatenate([[0.0], inner[(inner > 0) & (inner < size)], [size]])


def interpolated(index: Array, positions: Array) -> Array:
    """Positions at fractional indices, linear between integer ones."""
    return np.interp(index, np.arange(len(positions)), positions)
