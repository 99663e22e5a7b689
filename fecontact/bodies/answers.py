"""What a body answers to a scene's questions unless it knows better: it has no mesh, and no boundary takes a load.

Rooms above ask these instead of looking at the class of a body, so that a new kind of body need not be known there.
"""

from __future__ import annotations

import numpy as np

from fecontact.bodies.outside import Outside
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.mesh.section_mesh import Extent


class Answers:
    """Defaults of the questions in `protocol.Body`."""

    name: str

    @property
    def is_rigid(self) -> bool:
        """Whether it does not deform at all."""
        return False

    @property
    def dimension(self) -> str | None:
        """'space', 'plane' or 'axis'; None: it goes with any of them."""
        return "space"

    @property
    def out_of_plane(self) -> Extent | None:
        """How far a section goes on; None for a body of space."""
        return None

    @property
    def matrix_free(self) -> bool:
        """Whether many rows have a compliance that is applied as an operator, and never a matrix."""
        return False

    @property
    def is_foundation(self) -> bool:
        """Whether a surface node gives under its own pressure only."""
        return False

    @property
    def farthest(self) -> float:
        """Largest coordinate of the mesh that it is made of; zero where there is none."""
        return 0.0

    def boundary_force(self, name: str, force: Array) -> Array:
        """Refused: only elastic bodies have boundaries for it.

        Raises
        ------
        InputError
            Always.
        """
        raise self._refused("A force on a boundary")

    def boundary_pressure(self, name: str, pressure: float) -> Array:
        """Refused: only elastic bodies have boundaries for it.

        Raises
        ------
        InputError
            Always.
        """
        raise self._refused("A pressure")

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
        return InputError(f"{what} needs an elastic body; {self.name!r} is not. Give the force on the body as a whole.")

    def shared_faces(self, one: str, other: str) -> int:
        """Number of faces that two of its contact surfaces have in common; 1 for the only surface there is."""
        return int(one == other)

    def outside(self, displacement: Array) -> Outside:
        """Nothing is known of it."""
        return Outside(np.zeros((0, 3)), None, np.inf)

    def planes_through(self, nodes: IntArray) -> int:
        """Number of its planes of symmetry on which any of these nodes lies."""
        return 0

    def size_lines(self, twin: str = "") -> list[str]:
        """Lines for people: what it stands for more than it is made of; `twin` names a body of the same model."""
        return []
