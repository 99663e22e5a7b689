"""Elastic body of eight-node bricks with gradient coordinates (`fecontact.ancf`), for small strains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Self

import scipy.sparse as sp

from fecontact.ancf.bricks.model import AncfModel, twenty_nodes
from fecontact.ancf.bricks.space import check_bricks
from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arrays import Array, IntArray
from fecontact.common.compact_repr import compact_repr
from fecontact.fem.support import symmetry_planes
from fecontact.mesh.check import check_skin
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface, Projection
from fecontact.surfaces.nodal_weights import components_along


@compact_repr
@dataclass(frozen=True, eq=False)
class AncfBody(ElasticBody):
    """A linear elastic body of bricks whose nodes carry position and position gradients.

    It can replace an `ElasticBody` in a `Scene`. Contact acts on the trace of a face, twelve functions of its corners'
    positions and gradients: gaps and pressures are integrated over it, with one non-negative multiplier function for
    each corner and each edge, as many as the trace has coordinates along the normal.

    Parameters
    ----------
    mesh : Mesh
        Hexahedra of 8, 20 or 27 nodes, none degenerate. The corners are the element's nodes; the others define the
        edges, from which the initial gradients follow.
    material : Material, or mapping of element set to Material
        Between materials the gradient across the interface is released.
    contact : str or sequence of str
    supports : mapping of boundary name to components or directions, optional
        As for `ElasticBody`; positions and in-face gradients are held, the gradient across the face is not.
    pressure : {'eight'}
        Multiplier basis of a face: functions at corners and edges.
    name : str, optional
    backend : {'auto', 'pardiso', 'rslab', 'superlu'}
    integration : {'auto', 'full', 'selective'}
        Four Gauss points per direction; with 'selective' the divergence in the part with lambda is projected on linear
        functions in each cell. 'auto' is 'selective' for Poisson's ratios above 0.49 (docs/ancf.md).
    condensation : {'auto', 'schur', 'columns', 'operator'}
        As for `ElasticBody`.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    >>> body = fc.AncfBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]), 12)
    0.01
    """

    pressures: ClassVar = ("eight",)

    pressure: str = "eight"
    geometry: str = field(default="plain", init=False, repr=False)

    def _checked_mesh(self, names: tuple[str, ...]) -> Mesh:
        check_skin(self.mesh, names)
        check_bricks(self.mesh)
        return twenty_nodes(self.mesh)

    @cached_property
    def model(self) -> AncfModel:
        """The model of bricks, in the body's own axes; the same object in every pose of the body."""
        model = AncfModel(self.mesh, self.material, self.supports, self.backend, self.integration)
        model.way = self.condensation
        return model

    def _made_surface(self, facets: IntArray, name: str) -> FacetSurface:
        planes = symmetry_planes(self.mesh, self.supports)
        return FacetSurface(self.model.mesh.points, facets, name, mortar_on_quad8=True, planes=planes)

    @property
    def functions_per_cell(self) -> int:
        """Positions and gradients of eight nodes."""
        return 32

    def trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) for the displacement at closest points along directions (n, 3), including gradients."""
        assert projection.facet is not None
        assert projection.local is not None
        faces = self.mesh.faces(projection.surface)[projection.facet]
        return components_along(self.model.space.face_rows(faces, projection.local), directions)

    def divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """The body as it is: bricks with hanging nodes would need ties of gradients."""
        return self

    def describe(self) -> str:
        """One-line description of the model."""
        return self._described(f"{len(self.mesh.cells)} bricks with gradient coordinates, {self.n_dofs} dofs")
