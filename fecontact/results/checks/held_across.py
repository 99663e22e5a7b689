"""Loads that become wedges: what the frame of a loaded body is held by across its load.

A force lets a body follow along its own direction and holds it across (`contact.rigid_motion`). Where contacts push it
aside, the hold takes what a body that is free to move would not bear.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array
from fecontact.fem.support import is_plane
from fecontact.results.solved_scene import SolvedScene

#: Share of its load that a frame may be held by across it without a word.
SILENT_SHARE = 0.1


def held_across(result: SolvedScene) -> Iterator[str]:
    """Bodies that a hold across their load keeps from being pushed aside.

    Planes of symmetry push aside for the half that is not modelled; what they push along does not count.
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
    """Normals (n, 3), in the world, of the planes of symmetry by which bodies are supported."""
    found = [np.zeros((0, 3))]
    for body in elastic_among(bodies):
        for name, support in body.supports.items():
            if is_plane(support) and isinstance(support, str) and support in "xyz":
                found.append(body.pose.rotation[:, ["xyz".index(support)]].T)
            elif is_plane(support) and name in body.mesh.boundaries:
                nodes = body.mesh.points[body.mesh.boundary_nodes(name)]
                found.append(np.linalg.svd(nodes - nodes.mean(axis=0))[2][-1:] @ body.pose.rotation.T)
    return np.concatenate(found)
