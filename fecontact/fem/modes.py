"""A body condensed to its vibrations with some nodes held, and to displacements of these nodes (Craig & Bampton).

Sources: R. R. Craig & M. C. C. Bampton, AIAA J. 6 (1968), 1313-1319. Each component of a mode is a function of its own
that all components of the displacement take, so that the body can turn by any angle with a constant mass: A. Pechstein,
D. Reischl & J. Gerstmayr, J. Comput. Nonlinear Dyn. 8 (2013), 011019.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Self

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.fem.factor import factorise, symmetric
from fecontact.fem.model import Model
from fecontact.fem.stiffness import batches

#: Shift of the stiffness by the mass, over the ratio of their traces, so that free motions have a factor too.
SHIFT = -1e-7
#: Part of a function's mass beside those before it, below which it is one of them.
DEPENDENT = 1e-10


@dataclass(frozen=True, eq=False)
class Modes:
    """Functions of a body's points, with their stiffness and mass.

    Attributes
    ----------
    points : (n, 3) array
        Nodes of the mesh.
    kept : (m,) int array
        Those whose displacements are among the functions.
    functions : (n, k) array
        At the nodes: 1, the three coordinates from the centre of mass, and the components of the modes, orthogonal by
        mass to the first four and to each other, each at most 1.
    stiffness : (3 k, 3 k) array
        Of their coefficients, three components each.
    mass : (k, k) array
        Of each component.
    centre : (3,) array
        Centre of mass.
    """

    points: Array
    kept: IntArray
    functions: Array
    stiffness: Array
    mass: Array
    centre: Array

    def frequencies(self, count: int) -> Array:
        """The lowest frequencies (count,) beyond the six rigid motions, cycles per time: at or above the body's own.

        Examples
        --------
        >>> import fecontact as fc
        >>> bar = fc.shapes.block((10.0, 1.0, 1.0), (4, 1, 1))
        >>> body = fc.ElasticBody(bar, fc.Material(E=1.0, nu=0.3, density=1.0))
        >>> bool(body.with_modes(2).frequencies(1)[0] > 0)
        True
        """
        values = scipy.linalg.eigh(self.stiffness, np.kron(self.mass, np.eye(3)), eigvals_only=True)
        return np.asarray(np.sqrt(np.maximum(values[6 : 6 + count], 0.0)) / (2 * np.pi))

    def save(self, path: str | Path) -> None:
        """Write a NumPy archive of all arrays."""
        with Path(path).open("wb") as file:
            np.savez_compressed(file, **{f.name: getattr(self, f.name) for f in fields(self)})

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what `save` wrote."""
        with np.load(path) as kept:
            return cls(**{f.name: kept[f.name] for f in fields(cls)})


def modes_of(model: Model, count: int, kept: IntArray) -> Modes:
    """Vibrations of a model without supports, with nodes held, and the displacements that each of these makes alone.

    Parameters
    ----------
    model : Model
    count : int
        Vibrations.
    kept : (m,) int array

    Raises
    ------
    InputError
        For a model with supports, linear conditions or hanging nodes.
    """
    if len(model.held) or model.coordinates.ties is not None or model.n_coordinates != model.n_dofs:
        raise InputError(
            "A body with modes floats freely: it has no supports, linear conditions or hanging nodes. Hold the member "
            "by joints.",
            code="modes-of-held",
        )
    K, M = symmetric(model.stiffness).tocsr(), mass_of(model)
    whole = sp.csr_matrix(sp.kron(M, sp.eye_array(3)))
    shift = SHIFT * K.diagonal().sum() / whole.diagonal().sum()
    c = (3 * np.asarray(kept, dtype=np.int64)[:, None] + np.arange(3)).ravel()
    i = np.setdiff1d(np.arange(model.n_dofs), c)
    if not 0 < count < len(i) - 6:
        raise InputError(f"Ask for 1 to {len(i) - 7} modes of this body; found {count!r}.", code="number-of-modes")
    shifted = sp.csr_matrix(K - shift * whole)
    factor = factorise(sp.csr_matrix(sp.triu(shifted[i][:, i])), model.backend)
    inverse = spla.LinearOperator((len(i),) * 2, matvec=lambda b: factor.solve(b.reshape(1, -1)).ravel())
    # a body that the kept nodes do not hold has rigid motions among its vibrations
    extra = 0 if len(c) > 6 else 6
    own = spla.eigsh(
        K[i][:, i],
        count + extra,
        whole[i][:, i],
        sigma=shift,
        OPinv=inverse,
        v0=np.ones(len(i)) + np.arange(len(i)) % 7,
    )[1]
    shapes = np.zeros((model.n_dofs, len(c) + own.shape[1]))
    shapes[c, np.arange(len(c))] = 1.0
    if len(c):
        shapes[i, : len(c)] = -factor.solve(shifted[c][:, i].toarray()).T
    shapes[i, len(c) :] = own
    centre = model.mass_and_centre[1]
    first = np.column_stack([np.ones(len(model.mesh.points)), model.mesh.points - centre])
    functions = _independent(first, shapes.reshape(len(first), 3, -1).reshape(len(first), -1), M)
    wide = sp.csr_matrix(np.kron(functions, np.eye(3)))
    stiffness = (wide.T @ K @ wide).toarray()
    return Modes(
        model.mesh.points,
        np.asarray(kept, dtype=np.int64),
        functions,
        (stiffness + stiffness.T) / 2,
        functions.T @ (M @ functions),
        centre,
    )


def mass_of(model: Model) -> sp.csr_matrix:
    """Consistent mass (n_points, n_points) of one component of the displacement."""
    rows, columns, entries = [], [], []
    for batch in batches(model.elements):
        n = batch.nodes.shape[1]
        rows.append(np.repeat(batch.nodes, n, axis=1).ravel())
        columns.append(np.tile(batch.nodes, (1, n)).ravel())
        weights = batch.dV * model.density[batch.cells, None]
        entries.append(np.einsum("qa,qb,cq->cab", batch.N, batch.N, weights, optimize=True).ravel())
    total = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return sp.csr_matrix(total, shape=(len(model.mesh.points),) * 2)


def _independent(first: Array, others: Array, M: sp.csr_matrix) -> Array:
    """The first functions and what others add, orthogonal by mass, each at most 1."""
    Q = first @ np.linalg.inv(np.linalg.cholesky(first.T @ (M @ first)).T)
    others = others / np.sqrt((others * (M @ others)).sum(axis=0) + np.finfo(float).tiny)
    for _ in range(2):  # the second time for rounding
        others = others - Q @ (Q.T @ (M @ others))
    values, vectors = np.linalg.eigh(others.T @ (M @ others))
    kept = values > DEPENDENT * max(values.max(initial=0.0), 1e-3)
    new = others @ (vectors[:, kept] / np.sqrt(values[kept]))
    new -= Q @ (Q.T @ (M @ new))
    return np.column_stack([first, new / np.abs(new).max(axis=0)])
