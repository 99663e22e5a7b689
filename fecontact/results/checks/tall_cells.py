"""Check of cells under contacts with friction: those deeper than wide drag surfaces along under pressure."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fecontact.bodies.elastic import elastic_among
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
