"""A body's stiffness, factorised once: displacements under loads and given displacements of what is held."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

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
    """

    model: Model
    solved: IntArray
    held: IntArray

    @classmethod
    def of(cls, model: Model, origins: Array) -> Factored:
        """Of a model; one that floats is held at nodes far from points (n, 3), where the loads will be."""
        held = np.union1d(model.held, _grounded(model, origins))
        solved = np.setdiff1d(np.arange(model.n_coordinates), held, assume_unique=True)
        made = cls(model, solved, held)
        made._parts  # noqa: B018 - made here
        return made

    def __getstate__(self) -> dict[str, Any]:
        """State for other processes: without the factor, which is a library's memory."""
        return {name: getattr(self, name) for name in ("model", "solved", "held")}

    def serves(self, origin: Array) -> bool:
        """Whether what is held artificially is far from a point (3,)."""
        return not np.isin(np.setdiff1d(self.held, self.model.held), _near(self.model, origin[None])).any()

    @cached_property
    def _parts(self) -> tuple[Factor, sp.csr_matrix]:
        """Factor, and the stiffness (n_solved, n_held) between what is solved and what is held."""
        K = self.model.coordinates.stiffness(self.model.stiffness)
        vars(self.model).pop("stiffness", None)
        beside = K[self.solved][:, self.held] + K[self.held][:, self.solved].T
        return factorise(restricted(K, self.solved), self.model.backend), sp.csr_matrix(beside)

    def solve(self, forces: Array, given: Array | None = None) -> Array:
        """Displacements (n_dofs, m) under forces (n_dofs, m), with those of `given` (n_dofs, m) where it is held."""
        coordinates, (factor, beside) = self.model.coordinates, self._parts
        f = coordinates.forces(forces)[self.solved]
        v = np.zeros((self.model.n_coordinates, forces.shape[1]))
        if given is not None:
            v[self.held] = coordinates.of_displacements(given)[self.held]
            f = f - beside @ v[self.held]
        v[self.solved] = factor.solve(np.ascontiguousarray(f.T)).T
        return coordinates.displacements(v)


def _near(model: Model, origins: Array) -> IntArray:
    """Coordinates that are near points (n, 3)."""
    points = model.coordinates.of_functions(model.mesh.points)
    distance = np.linalg.norm(points[:, None] - origins, axis=2).min(axis=1)
    return np.flatnonzero(np.repeat(distance < FAR * distance.max(), 3))


def _grounded(model: Model, origins: Array) -> IntArray:
    """Coordinates far from points, one for each free motion."""
    if model.free_motions.shape[1] == 0:
        return np.zeros(0, dtype=np.int64)
    held = np.union1d(model.held, _near(model, origins))
    return fix_null_space(model.nodal_modes @ model.free_motions, held, model.size)
