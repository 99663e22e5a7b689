"""Bodies that can be stood somewhere else, and move by their nodes unless they know better."""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.answers import Answers
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.nodal_weights import components_along


class Placed(Answers):
    """A body with a pose of its own, apart from its coordinates."""

    pose: Pose

    @property
    def notes(self) -> tuple[str, ...]:
        """What was mended in its mesh or surface when that was read."""
        return ()

    def trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) that take the displacement at feet along directions (n, 3): that of the nodes round them."""
        assert projection.weights is not None
        return components_along(projection.weights, directions)

    def _described(self, what: str) -> str:
        """One line: what it is, and what was mended in it."""
        return "; ".join((f"{self.name}: {what}", *self.notes))

    def placed(
        self,
        translation: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike | None = None,
        name: str | None = None,
    ) -> Self:
        """The same body turned about the world's origin by `rotation` (3, 3) and then moved by `translation`.

        What belongs to the body itself (stiffness, factor, surfaces) is shared by both. A plane body stays in the plane
        y = 0: it turns about y, or half round about an axis in the plane; a body of revolution stays on its axis: it
        moves along z, and turns half round about x to stand on its head.

        Parameters
        ----------
        translation : (3,), optional
        rotation : (3, 3), optional
        name : str, optional
            The same as before unless given.

        Returns
        -------
        Body
            Of the same class.

        Examples
        --------
        >>> import fecontact as fc
        >>> floor = fc.RigidBody(fc.Plane(), name="floor")
        >>> floor.placed((0.0, 0.0, -1.0), name="cellar").pose.translation
        array([ 0.,  0., -1.])
        """
        Q = np.eye(3) if rotation is None else np.asarray(rotation, dtype=float)
        other = copy.copy(self)
        # bodies are frozen; the copy is not handed out before it stands
        object.__setattr__(other, "pose", self.pose.then(Q, np.asarray(translation, dtype=float)))
        object.__setattr__(other, "name", self.name if name is None else name)
        return other
