"""Defaults of the members of a body: no mesh, and no loads on boundaries.

Other modules use these members instead of the class of a body, so that a new kind of body needs no change there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Self

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.outside import Outside
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.mesh.section_mesh import Extent


class Answers:
    """Defaults of members of `protocol.Body`."""

    name: str

    @property
    def is_rigid(self) -> bool:
        """Whether the body is rigid."""
        return False

    @property
    def dimension(self) -> str | None:
        """'space', 'plane' or 'axis'; None: compatible with all."""
        return "space"

    @property
    def out_of_plane(self) -> Extent | None:
        """Out-of-plane extent of a section; None for a body in space."""
        return None

    @property
    def matrix_free(self) -> bool:
        """Whether the compliance of many rows is an operator, never a matrix."""
        return False

    @property
    def is_placed(self) -> bool:
        """Whether its contact surface is known before a scene is solved."""
        return True

    def met_by(self, partner: object) -> Self:
        """The body as it meets a partner in a contact: itself."""
        return self

    @property
    def is_foundation(self) -> bool:
        """Whether a surface node is displaced by its own pressure only."""
        return False

    @property
    def is_cut_off(self) -> bool:
        """Whether its surface is part of a larger one that is not known."""
        return False

    @property
    def farthest(self) -> float:
        """Largest coordinate of its mesh; zero without one."""
        return 0.0

    def boundary_force(self, name: str, force: Array) -> Array:
        """Refused: only elastic bodies have boundaries for it.

        Raises
        ------
        InputError
            Always.
        """
        raise self._refused("A force on a boundary")

    def boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Refused: only elastic bodies have boundaries for it.

        Raises
        ------
        InputError
            Always.
        """
        raise self._refused("A pressure or traction")

    def over_boundary(self, name: str, values: Array) -> Callable[[Array], Array]:
        """Refused, as `boundary_traction`."""
        raise self._refused("A pressure or traction")

    def count_nodes(self, name: str) -> int:
        """Refused, as `boundary_traction`."""
        raise self._refused("A pressure or traction")

    def point_force(self, point: Array, force: Array) -> Array | None:
        """None: a force at a point acts on the body as a whole."""
        return None

    def body_force(self, gravity: Array) -> Array | None:
        """None: gravity acts on elastic bodies only."""
        return None

    @property
    def weighted_modes(self) -> Array:
        """Refused: only elastic bodies have a mass.

        Raises
        ------
        InputError
            Always.
        """
        raise self._refused("A floating body")

    def _refused(self, what: str) -> InputError:
        return InputError(
            f"{what} needs an elastic body; {self.name!r} is not. Give the force on the body as a whole.",
            code="needs-elastic-body",
        )

    def shared_faces(self, one: str, other: str) -> int:
        """Number of common faces of two of its contact surfaces; 1 for a body with one surface."""
        return int(one == other)

    def energy_error(self, displacement: Array, points: Array, reach: float) -> EnergyError:
        """None: it has no elements."""
        return NO_CELLS

    def outside(self, displacement: Array) -> Outside:
        """Unknown."""
        return Outside(np.zeros((0, 3)), None, np.inf)

    def at_points(self, displacement: Array) -> Array | None:
        """None: it has no mesh."""
        return None

    def inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields | None:
        """None: it has no mesh inside."""
        return None

    def planes_through(self, nodes: IntArray) -> int:
        """Number of its planes of symmetry on which any of these nodes lies."""
        return 0

    def divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """Itself: it has no cells to divide."""
        return self

    def size_lines(self, twin: str = "") -> list[str]:
        """Report lines on the size that the model represents; `twin` names a body of the same model."""
        return []
