"""Patches of rigid surfaces near contacts, for pictures."""

from __future__ import annotations

import numpy as np

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.results.contact_fields import ContactFields
from fecontact.results.solved_scene import SolvedScene

#: Half side of a patch over the largest distance of the contact's points from its middle.
MARGIN = 1.3
#: Quadrilaterals per side of a patch.
PIECES = 24
#: Side of a quadrilateral over that of the grid in the tangent plane above which it crosses a fold or jump.
STRETCH = 3.0


def rigid_patches(result: SolvedScene, scale: float) -> tuple[Array, IntArray]:
    """Points (n, 3) and quadrilaterals (n_quads, 4) of the rigid surfaces of a result, where bodies touch them.

    Parameters
    ----------
    result : SolvedScene
    scale : float
        Factor of displacements and rigid motions.
    """
    points, quads, start = [np.zeros((0, 3))], [np.zeros((0, 4), np.int64)], 0
    for contact in result.contacts:
        if contact.master.is_rigid and not contact.is_curve:
            motion = result.state.motions[result.scene.bodies.index(contact.master)]
            x, q = _patch(contact, contact.master)
            begin = result.given(contact.master).pose.to_world(contact.master.pose.to_body(x))
            end = x + motion[:3] + np.cross(motion[3:], x - contact.master.pose.translation)
            points.append(begin + scale * (end - begin))
            quads.append(q + start)
            start += len(x)
    return np.concatenate(points), np.concatenate(quads)


def _patch(contact: ContactFields, body: Body) -> tuple[Array, IntArray]:
    """Projection of a grid in the tangent plane at the least gap; quadrilaterals outside the surface are left out."""
    shape = body.surface(contact.surfaces[1])
    nearest = body.pose.to_body(contact.points[[np.argmin(contact.gap)]])
    foot = shape.project(nearest)
    normal = foot.normals[0]
    along = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(normal, along) / np.linalg.norm(np.cross(normal, along))
    axes = np.stack([first, np.cross(normal, first)])
    offsets = (body.pose.to_body(contact.nodes) - foot.points) @ axes.T
    half = MARGIN * np.abs(offsets).max()
    t = half * np.linspace(-1.0, 1.0, PIECES + 1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2) @ axes + foot.points
    projection = shape.project(grid)
    index = np.arange((PIECES + 1) ** 2).reshape(PIECES + 1, PIECES + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    corners = projection.points[quads]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    kept = ~projection.outside[quads].any(axis=1) & (longest < STRETCH * 2 * half / PIECES)
    return body.pose.to_world(projection.points), quads[kept]
