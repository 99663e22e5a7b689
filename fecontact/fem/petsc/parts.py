"""What the processes of a job read: meshes, supports and materials, with nodes numbered by process.

Nodes are divided by recursive bisection of coordinates (M. J. Berger, S. H. Bokhari, IEEE Trans. Comput. C-36 (1987)
570). No stiffness is written: every process integrates its own cells, see `fem.petsc.shared`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.model import Model
from fecontact.fem.petsc.shared import ElasticCells
from fecontact.mesh.element import element_basis, element_quadrature, reduced_quadrature


@dataclass(frozen=True, eq=False)
class Layout:
    """Where the unknowns of several models are in the job's vector.

    Attributes
    ----------
    nodes : tuple of arrays
        Number of each node of each model.
    places : tuple of arrays
        Position of each solved degree of freedom of each model in the vector.
    node_ends : (n_ranks + 1,) array
        First node of each process.
    ends : (n_ranks + 1,) array
        First position of each process in the vector.
    """

    nodes: tuple[IntArray, ...]
    places: tuple[IntArray, ...]
    node_ends: IntArray
    ends: IntArray

    @property
    def size(self) -> int:
        """Length of the vector."""
        return int(self.ends[-1])


def cells_of(model: Model, number: IntArray) -> list[ElasticCells]:
    """Cells of a model by kind, with their nodes numbered anew by `number` (n_points,)."""
    width, out = model.mesh.cells.shape[1], []
    for group in model.mesh.cell_groups:
        points = [element_quadrature(width, group.pattern, group.midfaces)]
        if model.selective:
            points.append(reduced_quadrature(width))
        rules = [(element_basis(width, group.pattern, group.midfaces, X)[1], W) for X, W in points]
        out.append(ElasticCells(number[group.nodes], model.lame[group.cells], model.shear[group.cells], rules))
    return out


def bisected(points: Array, n: int) -> IntArray:
    """Part 0..n - 1 (n_points,) of each point, of equal size, by halving along the widest coordinate.

    Examples
    --------
    >>> bisected(np.array([[0.0, 0, 0], [3, 0, 0], [1, 0, 0], [2, 0, 0]]), 2).tolist()
    [0, 1, 0, 1]
    """
    part = np.zeros(len(points), dtype=np.int64)
    stack = [(np.arange(len(points)), 0, n)]
    while stack:
        own, first, count = stack.pop()
        if count == 1 or len(own) == 0:
            part[own] = first
            continue
        low = count // 2
        x = points[own]
        order = own[np.argsort(x[:, np.ptp(x, axis=0).argmax()], kind="stable")]
        cut = len(own) * low // count
        stack += [(order[:cut], first, low), (order[cut:], first + low, count - low)]
    return part


def layout(models: Sequence[Model], n_ranks: int) -> Layout:
    """Number nodes and coordinates by process, models side by side."""
    points = np.concatenate([m.mesh.points for m in models])
    part = bisected(points, n_ranks)
    number = np.empty(len(points), dtype=np.int64)
    number[np.argsort(part, kind="stable")] = np.arange(len(points))
    nodes = np.split(number, np.cumsum([len(m.mesh.points) for m in models])[:-1])
    free = np.zeros(len(points), bool)  # by number: hanging nodes have no coordinates
    for model, own in zip(models, nodes, strict=True):
        free[model.coordinates.of_functions(own)] = True
    position = np.cumsum(free) - 1
    node_ends = np.concatenate([[0], np.cumsum(np.bincount(part, minlength=n_ranks))])
    ends = 3 * np.concatenate([[0], np.cumsum(free)])[node_ends]
    places = tuple(
        _triples(position[model.coordinates.of_functions(own)])[model.solved_dofs]
        for model, own in zip(models, nodes, strict=True)
    )
    return Layout(tuple(nodes), places, node_ends, ends)


def write_parts(folder: Path, models: Sequence[Model], placed: Layout) -> None:
    """Write what `fem.petsc.__main__` reads."""
    size = placed.size
    arrays: dict[str, NDArray[Any]] = {"node_ends": placed.node_ends, "ends": placed.ends}
    points = np.empty((placed.node_ends[-1], 3))
    modes, model_of, held = np.zeros((size, 6)), np.zeros(size, dtype=np.int8), np.ones(size, bool)
    count = 0
    for k, (model, number, places) in enumerate(zip(models, placed.nodes, placed.places, strict=True)):
        points[number] = model.mesh.points
        own = np.linalg.qr(model.nodal_modes[model.solved_dofs])[0]
        modes[places], model_of[places], held[places] = own, k, False
        for cells in cells_of(model, number):
            save(folder / f"cells{count}.npz", {"lame": cells.lame, "shear": cells.shear, **_rules(cells)})
            np.save(folder / f"nodes{count}", cells.nodes)
            count += 1
    arrays |= {"n_kinds": np.array(count), "held": held, "model_of": model_of}
    for name, array in {**arrays, "points": points, "modes": modes}.items():
        np.save(folder / name, array)
    if not all(m.coordinates.are_displacements for m in models):
        save(folder / "coordinates.npz", rows_of("T", _transform(models, placed)))


def save(path: Path, arrays: dict[str, NDArray[Any]]) -> None:
    """Write arrays by name."""
    np.savez(path, allow_pickle=False, **arrays)


def rows_of(name: str, A: sp.csr_matrix) -> dict[str, NDArray[Any]]:
    """Compressed rows as arrays by name."""
    A = sp.csr_matrix(A)
    return {f"{name}_data": A.data, f"{name}_indices": A.indices, f"{name}_indptr": A.indptr}


def _rules(cells: ElasticCells) -> dict[str, NDArray[Any]]:
    """Rules as arrays by name."""
    return {f"{name}{k}": a for k, rule in enumerate(cells.rules) for name, a in zip(("dN", "W"), rule, strict=True)}


def _triples(numbers: IntArray) -> IntArray:
    return np.asarray((3 * numbers[:, None] + np.arange(3)).ravel())


def _transform(models: Sequence[Model], placed: Layout) -> sp.csr_matrix:
    """Displacements of the job's nodes by the coordinates in its vector."""
    rows, columns, values = [], [], []
    position = np.full(3 * placed.node_ends[-1], -1, dtype=np.int64)
    for model, number in zip(models, placed.nodes, strict=True):
        position[_triples(model.coordinates.of_functions(number))] = 0
    position[position == 0] = np.arange(placed.size)
    for model, number in zip(models, placed.nodes, strict=True):
        T = model.coordinates.rows(sp.eye_array(model.n_dofs, format="csr")).tocoo()
        rows.append(_triples(number)[T.row])
        columns.append(position[_triples(model.coordinates.of_functions(number))][T.col])
        values.append(T.data)
    shape = (len(position), placed.size)
    return sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
