"""A body's stiffness, factorised once: displacements under loads and given displacements of what is held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.fem.coordinates import restricted
from fecontact.fem.factor import Factor, factorise
from fecontact.fem.model import Model
from fecontact.fem.support import fix_null_space

FAR = 0.5
"""Distance from the window, relative to the body's farthest point, beyond which a floating body may be held."""


@dataclass(frozen=True, eq=False)
class Factored:
    """A factor of the stiffness over the coordinates that are not held.

    Attributes
    ----------
    model : Model
    solved, held : int arrays
        Coordinates that are solved, and those held by supports or, one for each free motion, artificially.
    factor : Factor
    beside : (n_solved, n_held) csr_matrix
        Stiffness between the two.
    """

    model: Model
    solved: IntArray
    held: IntArray
    factor: Factor
    beside: sp.csr_matrix

    @classmethod
    def of(cls, model: Model, origins: Array) -> Factored:
        """Factorise a model; one that floats is held at nodes far from points (n, 3), where the loads will be."""
        held = np.union1d(model.held, _grounded(model, origins))
        solved = np.setdiff1d(np.arange(model.n_coordinates), held, assume_unique=True)
        K = model.coordinates.stiffness(model.stiffness)
        vars(model).pop("stiffness", None)
        beside = K[solved][:, held] + K[held][:, solved].T
        return cls(model, solved, held, factorise(restricted(K, solved), model.backend), sp.csr_matrix(beside))

    def solve(self, forces: Array, given: Array | None = None) -> Array:
        """Displacements (n_dofs, m) under forces (n_dofs, m), with those of `given` (n_dofs, m) where it is held."""
        coordinates = self.model.coordinates
        f = coordinates.forces(forces)[self.solved]
        v = np.zeros((self.model.n_coordinates, forces.shape[1]))
        if given is not None:
            v[self.held] = coordinates.of_displacements(given)[self.held]
            f = f - self.beside @ v[self.held]
        v[self.solved] = self.factor.solve(np.ascontiguousarray(f.T)).T
        return coordinates.displacements(v)


def _grounded(model: Model, origins: Array) -> IntArray:
    """Coordinates far from points, one for each free motion."""
    if model.free_motions.shape[1] == 0:
        return np.zeros(0, dtype=np.int64)
    points = model.coordinates.of_functions(model.mesh.points)
    distance = np.linalg.norm(points[:, None] - origins, axis=2).min(axis=1)
    near = np.flatnonzero(np.repeat(distance < FAR * distance.max(), 3))
    return fix_null_space(model.nodal_modes @ model.free_motions, np.union1d(model.held, near), model.size)
