"""Bodies defined by a surface and its flexibility only."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator

from fecontact.bodies.body import Body, Reduced
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.rigid import rigid_modes
from fecontact.mesh.mesh import Mesh
from fecontact.solvers.problem import SYMMETRY_TOLERANCE
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import contact_weights


def boundary_surface(mesh: Mesh, boundary: str) -> FacetSurface:
    """Contact surface of a mesh's boundary; faces of eight nodes get their centre nodes, for positive nodal areas.

    Parameters
    ----------
    mesh : Mesh
    boundary : str

    Examples
    --------
    >>> import fecontact as fc
    >>> boundary_surface(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), "top").facets.shape
    (4, 9)
    """
    if mesh.cell_type == "hex20":
        mesh = mesh.with_midface_nodes((boundary,))
    return FacetSurface(mesh.points, mesh.face_nodes(mesh.faces(boundary)), boundary, hanging=mesh.hanging)


class SurfaceBody(Body):
    """Base of bodies defined by a surface and its flexibility; the underlying body is rigid and held unless free.

    A subclass defines `facets` and `flexibility`, as attributes or properties. All else has a default: generalised
    displacements are those of the nodes of `facets.points`, (x, y, z) node by node.

    Attributes
    ----------
    facets : FacetSurface
        The contact surface, see `boundary_surface`.
    flexibility : (n_dofs, n_dofs) array, sparse matrix or LinearOperator
        Nodal displacements due to unit nodal forces; symmetric, positive semidefinite.
    name : str, optional
    """

    required: ClassVar[tuple[str, ...]] = ("facets", "flexibility")

    name: str = "surface"
    pose: Pose = Pose()
    facets: FacetSurface
    flexibility: Array | sp.spmatrix | LinearOperator

    @property
    def contact(self) -> tuple[str, ...]:
        """Its one surface."""
        return (self.facets.name,)

    @property
    def n_dofs(self) -> int:
        """Three per node."""
        return self.facets.points.size

    @property
    def size(self) -> float:
        """Diagonal of the surface's bounding box."""
        return self.facets.size

    @property
    def reference_point(self) -> Array:
        """Mean of the surface's nodes."""
        return np.asarray(self.facets.points[self.facets.nodes].mean(axis=0))

    @cached_property
    def contact_modulus(self) -> float:
        """Modulus (force / length^2) from the stiffest node under its own force, for estimates only."""
        area = contact_weights(self.facets)
        k = int(np.argmax(area))
        unit = np.zeros((self.n_dofs, 3))
        unit[3 * k + np.arange(3), np.arange(3)] = 1.0
        largest = float((unit * (self.flexibility @ unit)).sum(axis=0).max())
        return 1 / (largest * np.sqrt(area[k])) if largest > 0 else np.inf

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(self.facets.points, self.reference_point)

    @property
    def free_motions(self) -> Array:
        """None: the underlying body is held in every component that is not free."""
        return np.zeros((6, 0))

    def surface(self, name: str) -> FacetSurface:
        """Its surface."""
        if name not in self.contact:
            raise InputError(f"{self.name!r} has the one surface {self.contact[0]!r}; found {name!r}.", code="unknown")
        return self.facets

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """Refused: a point load would displace the surface without bound, or has no point to act on.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(f"A spring cannot be fastened to {self.name!r}; fasten it to the ground or to a rigid body.")

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows.

        Raises
        ------
        InputError
            If the flexibility has another shape or is not symmetric.
        """
        with timer("condense"):
            expected = (self.n_dofs, self.n_dofs)
            if (shape := np.shape(self.flexibility)) != expected:
                raise InputError(
                    f"The flexibility of {self.name!r} must have shape {expected}, three displacements per node of its "
                    f"surface's mesh; found {shape}.",
                    code="flexibility-shape",
                )
            sparse = sp.issparse(self.flexibility)
            S = rows @ (self.flexibility @ (rows.T if sparse else rows.T.toarray()))
            S = S.toarray() if sparse else np.asarray(S)
            _check_symmetry(S, self.name)
            return Reduced(S, np.zeros(rows.shape[0]))

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Displacements (n_dofs,) under forces along rows."""
        return np.asarray(self.flexibility @ (rows.T @ forces))

    def describe(self) -> str:
        """One-line description of the model."""
        return self._described(f"{type(self).__name__}, {len(self.facets.nodes)} nodes")


def _check_symmetry(S: Array, name: str) -> None:
    largest, difference = float(np.abs(S).max(initial=0.0)), float(np.abs(S - S.T).max(initial=0.0))
    if difference > SYMMETRY_TOLERANCE * largest:
        raise InputError(
            f"The flexibility of {name!r} must be symmetric (Betti); on its contact points it differs from its "
            f"transpose by {difference / largest:.2g} of its largest entry. If that is noise of a measurement, give "
            "(A + A.T) / 2.",
            code="flexibility-not-symmetric",
        )
