"""What slender structures share: coordinates in vectors at nodes, and no volume."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array

#: Gauss points and weights of the straight step between two states: the mean of the forces there does the work of the
#: energy's change, to the sixth power of the strains of a step. Source: the average vector field of R. I. McLachlan,
#: G. R. W. Quispel & N. Robidoux, Phil. Trans. R. Soc. A 357 (1999).
BETWEEN = tuple(((1 + x) / 2, w / 2) for x, w in zip(*np.polynomial.legendre.leggauss(3), strict=True))


class HasVectors(Protocol):
    """What the coordinates are made of."""

    @property
    def vectors(self) -> Array:
        """Initial vectors (n_nodes, per_node, 3) of each node."""


class Nodal:
    """A slender structure whose coordinates are those of its nodes' vectors, one after the other."""

    @property
    def n_dofs(self: HasVectors) -> int:
        """Coordinates."""
        return self.vectors.size

    @property
    def q0(self: HasVectors) -> Array:
        """Initial coordinates (n_dofs,)."""
        return self.vectors.ravel()

    @property
    def is_slender(self) -> bool:
        """Yes."""
        return True

    def check_inverted(self, q: Array) -> None:
        """Slender structures have no volume to turn inside out."""
