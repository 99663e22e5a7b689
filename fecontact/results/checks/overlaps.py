"""Bodies that overlap although no contact between them was declared: nothing keeps them apart.

Points of one body are projected on the other, in the final places: a ball's centre, whose distance tells all, the outer
nodes of an elastic body, and points spread over other rigid surfaces. Bodies whose boxes are apart cost nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations

import numpy as np

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.protocol import Body
from fecontact.bodies.rigid import Plane, RigidBody, Sphere
from fecontact.bodies.section import SectionBody
from fecontact.common.arrays import Array
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.results.solved_scene import SolvedScene
from fecontact.surfaces import Ellipsoid, Facets
from fecontact.surfaces.facet_surface import FacetSurface, Surface
from fecontact.surfaces.section_curve import CurveSurface

#: Depth, relative to the smaller body, from which an overlap counts: chords of round faces that touch make less.
LEAST_DEPTH = 1e-4
#: Points along each side of the square over which a rigid surface given by heights is looked at.
ALONG = 33


def undeclared_overlaps(result: SolvedScene) -> Iterator[str]:
    """Pairs of bodies without a contact between them that overlap."""
    declared = {frozenset((id(c.slave), id(c.master))) for c in result.scene.contacts}
    bodies = result.scene.bodies
    if len(bodies) * (len(bodies) - 1) // 2 == len(declared):
        return
    placed = [_Placed(result, body) for body in bodies]
    for one, other in combinations(placed, 2):
        if frozenset((id(one.body), id(other.body))) in declared:
            continue
        depth = max(one.depth_in(other), other.depth_in(one))
        if depth > LEAST_DEPTH * min(one.length, other.length):
            yield (
                f"{one.body.name!r} and {other.body.name!r} overlap by {depth:.4g} and no contact between them was "
                "declared, so that nothing keeps them apart: add a Contact, or move one of them."
            )


class _Placed:
    """A body where it has come to rest."""

    def __init__(self, result: SolvedScene, body: Body) -> None:
        self.result, self.body = result, body

    @property
    def length(self) -> float:
        """The body's size; infinite for a plane, which has none."""
        return np.inf if isinstance(self._shape, Plane) else self.body.size

    @property
    def _shape(self) -> object:
        return self.body.shape if isinstance(self.body, RigidBody) else None

    @property
    def _radius(self) -> float:
        """Distance from its points within which all is the body."""
        return self._shape.radius if isinstance(self._shape, Sphere) else 0.0

    @cached_property
    def points(self) -> Array:
        """Points (n, 3) of the body in world axes; none for surfaces that go on without end."""
        if isinstance(self.body, ElasticBody):
            mesh = self.body.mesh
            faces = mesh.outer_sides if isinstance(mesh, SectionMesh) else mesh.outer_faces
            return self._nodes[np.unique(mesh.face_nodes(faces))]
        shape = self._shape
        if isinstance(shape, Sphere):
            return self._moved(self.body.pose.to_world(np.array([[0.0, 0.0, shape.radius]])))
        if isinstance(shape, Facets):
            return self._moved(self.body.pose.to_world(shape.mesh.points))
        if hasattr(shape, "heights"):
            t = np.linspace(-0.5, 0.5, ALONG) * self.body.size
            x, y = (c.ravel() for c in np.meshgrid(t, t, indexing="ij"))
            z = np.asarray(shape.heights(x, y)) + np.zeros(len(x))
            known = np.isfinite(z)
            return self._moved(self.body.pose.to_world(np.stack([x, y, z], axis=1)[known]))
        return np.zeros((0, 3))

    @cached_property
    def _nodes(self) -> Array:
        """All nodes (n, 3) of an elastic body after deformation."""
        assert isinstance(self.body, ElasticBody)
        return self.body.pose.to_world(self.body.mesh.points) + self.result.displacement(self.body)

    def _moved(self, points: Array, sign: float = 1.0) -> Array:
        """Points (n, 3) after the body's small rigid motion, or before it."""
        number = next(k for k, b in enumerate(self.result.scene.bodies) if b is self.body)
        shift, turn = np.split(self.result.state.motions[number], 2)
        return points + sign * (shift + np.cross(turn, points - self.result.loading.frames[number].point))

    @cached_property
    def _box(self) -> tuple[Array, Array] | None:
        """Corners of a box round the body; None where it may go on without end."""
        bounded = isinstance(self.body, ElasticBody) or isinstance(self._shape, Sphere | Facets)
        if not bounded or not len(self.points):
            return None
        return self.points.min(axis=0) - self._radius, self.points.max(axis=0) + self._radius

    @cached_property
    def _surface(self) -> Surface | None:
        """The whole outside, in world axes for an elastic body, in its own for another; None where it is not known."""
        if isinstance(self.body, SectionBody):
            sides = self.body.mesh.face_nodes(self.body.mesh.outer_sides)
            return CurveSurface(self._nodes, sides, self.body.name, along=self.body.along)
        if isinstance(self.body, ElasticBody):
            return FacetSurface(self._nodes, self.body.mesh.face_nodes(self.body.mesh.outer_faces), self.body.name)
        if isinstance(self.body, RigidBody):
            shape = self.body.shape
            return None if isinstance(shape, Facets) and shape.is_open else shape
        return None

    def depth_in(self, other: _Placed) -> float:
        """How far points of this body lie inside another; zero where none do."""
        points, surface = self.points, other._surface
        if surface is None or not len(points):
            return 0.0
        if other._box is not None:
            low, high = other._box
            points = points[((points >= low - self._radius) & (points <= high + self._radius)).all(axis=1)]
            if not len(points):
                return 0.0
        rigid = isinstance(other.body, RigidBody)
        seen = other.body.pose.to_body(other._moved(points, -1.0)) if rigid else points
        feet = surface.project(seen)
        depth = np.where(feet.beyond, -np.inf, self._radius - feet.gap)
        if isinstance(surface, Ellipsoid):
            # its feet are on the lower half
            reach = np.array(surface.semi_axes) + self._radius
            depth[(((seen - [0.0, 0.0, surface.semi_axes[2]]) / reach) ** 2).sum(axis=1) > 1] = -np.inf
        elif rigid and not isinstance(surface, Plane):
            # a body behind a surface that ends somewhere need not be inside
            depth[depth > other.length + 2 * self._radius] = -np.inf
        return max(0.0, float(depth.max()))
