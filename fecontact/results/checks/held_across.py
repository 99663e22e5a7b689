"""Check of the constraint force across the load of a body.

A force frees a body along its own direction and holds it across (`contact.rigid_motion`). Where contacts push it aside,
the constraint carries a force that a free body could not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array
from fecontact.fem.support import is_plane
from fecontact.results.solved_scene import SolvedScene

#: Constraint force across the load, as a share of the load, above which a result warns.
SILENT_SHARE = 0.1


def held_across(result: SolvedScene) -> Iterator[str]:
    """Warnings of bodies held across their load against contact forces.

    Reactions of planes of symmetry, which represent the half that is not modelled, do not count.
    """
    loaded = [f for f in result.loading.frames if f.load[:3].any() and not f.spread]
    mirrored = _mirror_normals(result.scene.bodies) if loaded else np.zeros((0, 3))
    for frame in loaded:
        size = float(np.linalg.norm(frame.load[:3]))
        meant = np.concatenate([frame.free[:3].T, np.eye(3)[[c for c in frame.prescribed_components if c < 3]]])
        across = result.reaction(frame.body)[:3]
        for direction in (mirrored, meant):
            across = across - np.linalg.pinv(direction) @ (direction @ across)
        share = float(np.linalg.norm(across)) / size
        if share > SILENT_SHARE:
            force = np.array2string(across, precision=4)
            yield (
                f"The frame of {frame.body.name!r} is held across its load by the force {force}, {100 * share:.0f} % "
                "of the load: contacts push it aside like a wedge. Release it with free=, or say with motions= that "
                "it is held."
            )


def _mirror_normals(bodies: Sequence[Body]) -> Array:
    """World normals (n, 3) of the planes of symmetry that support bodies."""
    found = [np.zeros((0, 3))]
    for body in elastic_among(bodies):
        for name, support in body.supports.items():
            if is_plane(support) and isinstance(support, str) and support in "xyz":
                found.append(body.pose.rotation[:, ["xyz".index(support)]].T)
            elif is_plane(support) and name in body.mesh.boundaries:
                nodes = body.mesh.points[body.mesh.boundary_nodes(name)]
                found.append(np.linalg.svd(nodes - nodes.mean(axis=0))[2][-1:] @ body.pose.rotation.T)
    return np.concatenate(found)
