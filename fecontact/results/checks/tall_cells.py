"""Check of cells under contacts with friction: those deeper than wide drag surfaces along under pressure.

Check of the constraint force across the load of a body.

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

#: Poisson's ratio from which, and depth over width above which, cells of 8 and 20 nodes distort tangential strains. A
#: roller on cells 2.5 times as deep as wide has 0.3 to 0.6 of mu P too much, on square ones less than 0.1.
NEARLY_INCOMPRESSIBLE, TALL = 0.45, 2.0
#: Nodes of cells without a node in their middle, by the nodes of a cell.
SERENDIPITY = (8, 20)


def tall_cells(result: SolvedScene) -> Iterator[str]:
    """Warnings of nearly incompressible slaves with friction whose touching cells are much deeper than wide."""
    for contact, interface in zip(result.contacts, result.interfaces, strict=True):
        for body in elastic_among([interface.slave]):
            if contact.friction is None or not contact.active.any() or body.mesh.cells.shape[1] not in SERENDIPITY:
                continue
            if max(m.nu for m in body.model.materials) < NEARLY_INCOMPRESSIBLE:
                continue
            touching = interface.pairing.nodes[contact.active]
            shared = np.isin(body.mesh.cells, touching).sum(axis=1)
            if not shared.any():  # a node in the middle of a face, which cells of 20 nodes do not have
                continue
            cells = body.mesh.cells[shared >= min(2, shared.max())]
            normal = contact.normals[contact.active].mean(axis=0) @ body.pose.rotation
            across = np.linalg.svd(normal[None])[2]
            extent = np.ptp(body.mesh.points[cells] @ across.T, axis=1)
            # a section has no extent across its plane
            widths = np.where(extent[:, 1:] > 0, extent[:, 1:], np.inf).min(axis=1)
            depth = float(np.median(extent[:, 0] / widths))
            if depth > TALL:
                yield (
                    f"Cells of {body.name!r} are {depth:.2g} times as deep as wide where it touches: as it is nearly "
                    "incompressible, pressures drag its surface along, and the friction of rolling may be off by half "
                    "of mu P. Make them as deep as wide, or of 9 or 27 nodes."
                )


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
