"""What a solution did not have to compute: points that were no candidates, degrees of freedom condensed, symmetry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.protocol import Body
from fecontact.bodies.rigid import RigidBody
from fecontact.bodies.section import SectionBody
from fecontact.fem.support import is_plane
from fecontact.results.solved_scene import SolvedScene

#: Distance from a plane, relative to the body's size, within which a boundary is flat.
FLAT = 1e-9


def savings(result: SolvedScene) -> list[str]:
    """Lines for people: what was modelled of the scene, and what that saved."""
    lines = []
    points = sum(len(c.gap) for c in result.contacts)
    if points:
        lines.append(f"{result.n_candidates} candidates out of {points} contact points")
    models = {id(b.model): b.model for b in result.elastic_bodies}
    kept = sum(m.n_retained for m in models.values() if m is not None)
    if kept:
        lines.append(f"{result.n_dofs_factorised} degrees of freedom condensed to {kept}")
    return lines + modelled(result.scene.bodies)


def modelled(bodies: Sequence[Body]) -> list[str]:
    """Lines for people: which bodies stand for more than they are made of."""
    lines = []
    first: dict[int, Body] = {}
    for body in bodies:
        if isinstance(body, ElasticBody):
            before = first.setdefault(id(body.model), body)
            if before is not body:
                lines.append(f"{body.name}: the model of {before.name!r} in another pose, factorised once for both")
            elif planes := planes_of_symmetry(body):
                lines.append(
                    f"{body.name}: held along the normal only on {', '.join(planes)}; as planes of symmetry these make "
                    f"it 1/{2 ** len(planes)} of the whole"
                )
            if isinstance(body, SectionBody):
                lines.append(f"{body.name}: a section instead of a solid")
        elif isinstance(body, RigidBody):
            lines.append(f"{body.name}: rigid, nothing to factorise")
        elif isinstance(body, HalfSpace):
            lines.append(f"{body.name}: a half-space, of which only the surface is cut")
    return lines


def planes_of_symmetry(body: ElasticBody) -> list[str]:
    """Boundaries that lie in one plane each and are held along its normal alone."""
    out = []
    for name, support in body.supports.items():
        if not (isinstance(support, str) and is_plane(support) and support in "xyz"):
            continue
        place = body.mesh.points[body.mesh.boundary_nodes(name), "xyz".index(support)]
        if np.ptp(place) <= FLAT * body.size:
            out.append(name)
    return out
