"""Orthotropic friction: the direction of a surface's lay, along which its coefficient differs from that across.

With coefficients mu_1 along the lay and mu_2 across, tangential forces lie in an ellipse, and slip does the most work
on the force among all of them (maximum dissipation: slip is opposite to the normal of the ellipse):

    (t_1 / mu_1)^2 + (t_2 / mu_2)^2 <= l^2,    t . s = min

With mu the larger coefficient, forces t'_k = t_k mu / mu_k lie in the disc |t'| <= mu l, and slips s'_k = s_k mu_k / mu
do the same work, t' . s' = t . s: in these variables friction is isotropic. Only the rows of slip change, by mu_k / mu.

Sources: Michalowski & Mroz, Arch. Mech. 30 (1978) 259; Zmitrowicz, Int. J. Solids Struct. 43 (2006) 4407.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array, Mask
from fecontact.common.errors import InputError
from fecontact.common.one_line import one_line

#: Sine of the angle between the lay and a point's normal below which the lay has no direction in its tangent plane.
NEARLY_NORMAL = 0.1


@one_line
@dataclass(frozen=True, eq=False)
class Lay:
    """Direction of a surface's lay, with the coefficients of friction along and across it.

    Parameters
    ----------
    mu : (2,) array
        Coefficients of slip along the lay and across.
    axis : (3,) array
        Unit vector in world axes.
    body : str
        Name of the body that it turns with.

    Examples
    --------
    >>> lay = Lay(np.array([0.1, 0.2]), np.array([1.0, 0.0, 0.0]), "floor")
    >>> lay.tangents(np.array([[0.0, 0.0, 1.0]]))[:, 0].tolist()
    [[0.5, 0.0, 0.0], [0.0, 1.0, 0.0]]
    """

    mu: Array
    axis: Array
    body: str

    def tangents(self, normals: Array) -> Array:
        """Tangents (2, n, 3) along the lay and across, of lengths mu_k / mu, at points with unit normals (n, 3).

        Where the lay is normal to the surface, any.
        """
        along = self.axis - (normals @ self.axis)[:, None] * normals
        any_across = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
        along = np.where(self._normal_to(normals)[:, None], any_across, along)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        return np.stack([along, np.cross(normals, along)]) * (self.mu / self.mu.max())[:, None, None]

    def check(self, normals: Array, points: Array, touching: Mask) -> None:
        """Refuse points (n, 3) that touch (n,) where the lay is normal to the surface.

        Raises
        ------
        InputError
        """
        lost = np.flatnonzero(self._normal_to(normals) & touching)
        if len(lost):
            at = np.array2string(points[lost[0]], precision=4, separator=", ")
            raise InputError(
                f"friction_axis is normal to the surface at {len(lost)} points that touch, such as {at}: the lay of "
                f"{self.body!r} has no direction there. Give an axis that lies in the surface, or one coefficient."
            )

    def _normal_to(self, normals: Array) -> Mask:
        return np.asarray(np.linalg.norm(np.cross(normals, self.axis), axis=1) < NEARLY_NORMAL)
