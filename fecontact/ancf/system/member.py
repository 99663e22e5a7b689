"""What an assembly asks of its members: solids of bricks, and structures of beams, cables and plates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray


@dataclass(frozen=True, eq=False)
class Drawing:
    """A member for ParaView.

    Attributes
    ----------
    kind : str
        meshio's name of the cells.
    start, points : (n, 3) arrays
        Initial and present places.
    cells : (n_cells, k) int array
    stress : (n, 6) array
        Cauchy stress; zero where there is none.
    """

    kind: str
    start: Array
    points: Array
    cells: IntArray
    stress: Array


class Member(Protocol):
    """A deformable member with its own coordinates q (n_dofs,)."""

    @property
    def n_dofs(self) -> int:
        """Number of coordinates."""

    @property
    def q0(self) -> Array:
        """Initial coordinates."""

    @property
    def extent(self) -> float:
        """Largest extent along an axis."""

    @property
    def scales(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths."""

    @property
    def is_slender(self) -> bool:
        """Whether it turns with little strain."""

    @property
    def rigid_modes(self) -> Array:
        """Changes (n_dofs, 6) of the initial coordinates by small rigid motions."""

    @property
    def mass(self) -> sp.csr_matrix:
        """Constant mass (n_dofs, n_dofs)."""

    def translation(self, direction: Array) -> Array:
        """Change (n_dofs,) of the coordinates by a translation (3,)."""

    def place_rows(self, where: Any) -> list[sp.csr_matrix]:
        """Rows (n, n_dofs / 3) of the position and of each gradient at a node or at points of the initial shape."""

    def energy(self, q: Array) -> float:
        """Strain energy."""

    def forces(self, q: Array) -> Array:
        """Its gradient (n_dofs,)."""

    def tangent(self, q: Array) -> sp.csr_matrix:
        """Its second derivative (n_dofs, n_dofs)."""

    def forces_between(self, q0: Array, q1: Array) -> Array:
        """Elastic forces (n_dofs,) whose work from q0 to q1 is the change of energy."""

    def check_inverted(self, q: Array) -> None:
        """Refuse coordinates that turn material inside out."""

    def drawn(self, q: Array) -> Drawing:
        """Its present shape."""
