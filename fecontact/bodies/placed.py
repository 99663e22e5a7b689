"""Bodies with a pose; by default their displacements are nodal."""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.answers import Answers
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import text
from fecontact.common.arrays import Array
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.nodal_weights import components_along


class Placed(Answers):
    """A body with a pose separate from its coordinates."""

    pose: Pose

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh or surface was read."""
        return ()

    def trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) for the displacement at closest points along directions (n, 3), interpolated from nodes."""
        assert projection.weights is not None
        return components_along(projection.weights, directions)

    def _described(self, what: str) -> str:
        """One-line description with notes."""
        return "; ".join((f"{self.name}: {what}", *self.notes))

    def placed(
        self,
        translation: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike | None = None,
        name: str | None = None,
    ) -> Self:
        """The same body rotated about the world's origin by `rotation` (3, 3), then translated by `translation`.

        Stiffness, factor and surfaces are shared by both. A plane body stays in the plane y = 0: it rotates about y, or
        by pi about an axis in the plane. A body of revolution stays on its axis: it is translated along z, or rotated
        by pi about x.

        Parameters
        ----------
        translation : (3,), optional
        rotation : (3, 3), optional
        name : str, optional
            Name of the copy; unchanged unless given.

        Returns
        -------
        Body
            A body of the same class.

        Examples
        --------
        >>> import fecontact as fc
        >>> floor = fc.RigidBody(fc.Plane(), name="floor")
        >>> floor.placed((0.0, 0.0, -1.0), name="cellar").pose.translation
        array([ 0.,  0., -1.])
        """
        pose = self.pose.then(np.eye(3) if rotation is None else rotation, translation)
        other = copy.copy(self)
        # bodies are frozen; set before the copy escapes
        object.__setattr__(other, "pose", pose)
        object.__setattr__(other, "name", self.name if name is None else text("the name of a body", name))
        return other
