"""Faces of a mesh that look along a direction."""

from __future__ import annotations

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.mesh.mesh import Mesh

LEAST_FACING = 0.5
"""Cosine between the normal of a face and the direction from which the face looks along it."""


def facing(mesh: Mesh, faces: IntArray, direction: Array) -> IntArray:
    """Those of faces (n, 2) that look along a direction (3,), out of their cells.

    Examples
    --------
    >>> from fecontact.mesh import shapes
    >>> cube = shapes.block((1.0, 1.0, 1.0), (2, 1, 1))
    >>> len(facing(cube, cube.outer_faces, np.array([0.0, 0.0, 1.0])))
    2
    """
    corners = mesh.points[mesh.face_nodes(faces)[:, :4]]
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    triangle = np.linalg.norm(corners[:, 3] - corners[:, 2], axis=1) == 0
    across[triangle] = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[triangle]
    return faces[across @ direction > LEAST_FACING * np.linalg.norm(across, axis=1)]
