"""Reduction of a problem's size by candidates, condensation and symmetry."""

from __future__ import annotations

from collections.abc import Sequence

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.protocol import Body
from fecontact.results.solved_scene import SolvedScene


def model_size(result: SolvedScene) -> list[str]:
    """Report lines on the size of the problem and its reduction."""
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
    """Report lines of bodies that represent more than is modelled (symmetry, sections, half-spaces)."""
    first: dict[int, ElasticBody] = {}
    twins: dict[int, str] = {}
    for elastic in elastic_among(bodies):
        before = first.setdefault(id(elastic.model), elastic)
        if before is not elastic:
            twins[id(elastic)] = before.name
    return [line for body in bodies for line in body.size_lines(twins.get(id(body), ""))]
