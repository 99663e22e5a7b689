"""What a solution did not have to compute: points that were no candidates, degrees of freedom condensed, symmetry."""

from __future__ import annotations

from collections.abc import Sequence

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.protocol import Body
from fecontact.results.solved_scene import SolvedScene


def model_size(result: SolvedScene) -> list[str]:
    """Lines for people: what was modelled of the scene, and what that saved."""
    lines = []
    points = sum(len(c.gap) for c in result.contacts)
    if points:
        lines.append(f"{result.n_candidates} candidates out of {points} contact points")
    models = {id(b.model): b.model for b in result.elastic_bodies}
    kept = sum(m.n_retained for m in models.values())
    if kept:
        lines.append(f"{result.n_dofs_factorised} degrees of freedom condensed to {kept}")
    return lines + modelled(result.scene.bodies)


def modelled(bodies: Sequence[Body]) -> list[str]:
    """Lines for people: which bodies stand for more than they are made of."""
    first: dict[int, ElasticBody] = {}
    twins: dict[int, str] = {}
    for elastic in elastic_among(bodies):
        before = first.setdefault(id(elastic.model), elastic)
        if before is not elastic:
            twins[id(elastic)] = before.name
    return [line for body in bodies for line in body.size_lines(twins.get(id(body), ""))]
