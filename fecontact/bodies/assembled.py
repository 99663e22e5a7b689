"""A body given by its assembled stiffness."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy.sparse as sp
from skfem import CellBasis

from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arguments import instance
from fecontact.common.arrays import Array, IntArray
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.expansion import Heated
from fecontact.fem.laws import without_law
from fecontact.fem.model import Model
from fecontact.fem.support import Support
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.skfem_mesh import from_skfem_basis

#: Largest relative asymmetry of a stiffness or resistance to a rigid motion. Assembly leaves 1e-12 by rounding;
#: supports or springs in the matrix give 1e-3 and more.
ROUNDING = 1e-8


class AssembledModel(Model):
    """Mesh, supports and a given stiffness; materials are used for stresses and the contact modulus.

    Parameters
    ----------
    mesh : Mesh
    materials, supports, backend, condensation
        As for `Model`.
    stiffness : (3 n_points, 3 n_points) sparse matrix
        The full matrix without supports, degrees of freedom 3 * node + component.

    Raises
    ------
    InputError
        If the stiffness has another shape, is not finite or symmetric, or resists a rigid motion.
    """

    def __init__(
        self,
        mesh: Mesh,
        materials: Material | Mapping[str, Material],
        supports: Mapping[str, Support],
        stiffness: sp.sparray | sp.spmatrix,
        backend: str = "auto",
        condensation: str = "auto",
    ) -> None:
        super().__init__(mesh, materials, supports, backend, "full", condensation)
        self.assembled = self._checked(stiffness)

    def _checked(self, stiffness: sp.sparray | sp.spmatrix) -> sp.csr_matrix:
        """Upper triangle of the given stiffness, checked to be that of a free body."""
        if not sp.issparse(stiffness) or stiffness.shape != (self.n_dofs, self.n_dofs):
            raise InputError(
                f"Expected the stiffness as a sparse matrix of shape ({self.n_dofs}, {self.n_dofs}), three rows for "
                f"each of the {len(self.mesh.points)} points; found {type(stiffness).__name__} of shape "
                f"{np.shape(stiffness)}."
            )
        K = sp.csr_matrix(stiffness, dtype=float)
        if not np.isfinite(K.data).all():
            raise InputError(
                f"{(~np.isfinite(K.data)).sum()} entries of the stiffness are not finite.", code="not-finite"
            )
        largest = np.abs(K.data).max(initial=0.0)
        asymmetry = np.abs((K - K.T).data).max(initial=0.0)
        if largest == 0 or asymmetry > ROUNDING * largest:
            raise InputError(
                f"The stiffness is not symmetric: entries differ across the diagonal by {asymmetry:.3g}, the "
                f"largest entry is {largest:.3g}. If it holds one triangle only, give both.",
                code="stiffness-not-symmetric",
            )
        modes = self.rigid_modes / np.abs(self.rigid_modes).max(axis=0)
        resistance = np.abs(K @ modes).max() / largest
        if resistance > ROUNDING:
            raise InputError(
                f"The stiffness resists rigid motions, by {resistance:.3g} of its largest entry. Give it without "
                "supports, springs or condensed rows; supports=... holds the body.",
                code="stiffness-holds",
            )
        upper = sp.csr_matrix(sp.triu(K))
        upper.sort_indices()
        return upper

    @property
    def stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the stiffness (n_dofs, n_dofs)."""
        return self.assembled


@compact_repr
@dataclass(frozen=True, eq=False)
class AssembledBody(ElasticBody):
    """A linear elastic body with a given stiffness on a `Mesh`.

    Surface, loads and supports are those of the mesh, as in `ElasticBody`. Contact faces get no mid-face nodes, which
    are not in the stiffness: use hexahedra of 8 or 27 nodes for smooth nodal pressures.

    Parameters
    ----------
    mesh : Mesh
    material : Material, or mapping of element set to Material
        For stresses from strains and for the contact modulus. The stiffness is not changed.
    contact, supports
        As in `ElasticBody`.
    stiffness : (3 n_points, 3 n_points) sparse matrix
        Full symmetric matrix without supports, degrees of freedom 3 * node + component. For a matrix in scikit-fem's
        order see `from_skfem`.
    name, backend, condensation
        As in `ElasticBody`.

    Raises
    ------
    InputError, MeshError
        As in `ElasticBody`; if the stiffness has another shape, is not symmetric, or resists a rigid motion.
    """

    pressure: str = field(default="nodal", init=False, repr=False)
    integration: str = field(default="full", init=False, repr=False)
    geometry: str = field(default="plain", init=False, repr=False)
    stiffness: sp.sparray | sp.spmatrix | None = field(default=None, kw_only=True, repr=False)

    def __post_init__(self) -> None:
        if self.stiffness is None:
            raise InputError(f"{self.name!r} needs stiffness=...; a body of a mesh and a material is an ElasticBody.")
        instance("stiffness", self.stiffness, (sp.sparray, sp.spmatrix))
        super().__post_init__()

    @cached_property
    def model(self) -> AssembledModel:
        """The given stiffness with its mesh, in the body's own axes; the same object in every pose of the body."""
        assert self.stiffness is not None
        material = without_law("an AssembledBody", self.material)
        return AssembledModel(self.mesh, material, self.supports, self.stiffness, self.backend, self.condensation)

    def _heated(self, change: Callable[[Array], Array]) -> Heated:
        """Refused: the forces of a temperature would not be those of the stiffness."""
        raise InputError(
            f"{self.name!r} is an AssembledBody, whose stiffness need not be that of its material: temperatures are "
            "offered for an ElasticBody. Give their nodal forces as loads.",
            code="heated-assembled",
        )

    def _divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """The body as it is: the stiffness of other cells is not known."""
        return self

    @classmethod
    def from_skfem(
        cls,
        basis: CellBasis,
        stiffness: sp.sparray | sp.spmatrix,
        material: Material | Mapping[str, Material],
        contact: str | Sequence[str] = (),
        supports: Mapping[str, Support] | None = None,
        **options: Any,
    ) -> AssembledBody:
        """Body from a scikit-fem basis and a stiffness assembled with it.

        Points of the body's mesh are in the order of the basis's degrees of freedom along x. The element may be of a
        higher order than the mesh. The mesh's boundaries and subdomains keep their names.

        Parameters
        ----------
        basis : skfem.CellBasis
            Of an `ElementVector` of hexahedra (8, 20, 27 nodes), tetrahedra (4, 10) or wedges (6). For wedges pass
            ``quadrature=``: the weights of scikit-fem's default rule sum to half the volume (version 12.0.2).
        stiffness : (basis.N, basis.N) sparse matrix
        material, contact, supports
            As in the class.
        **options
            `name`, `backend`, `condensation`, `pose`.

        Examples
        --------
        >>> import fecontact as fc
        >>> from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex
        >>> from skfem.models.elasticity import lame_parameters, linear_elasticity
        >>> basis = Basis(MeshHex().refined(1).with_defaults(), ElementVector(ElementHex2()), intorder=5)
        >>> K = linear_elasticity(*lame_parameters(1.0, 0.3)).assemble(basis)
        >>> rubber = fc.Material(E=1.0, nu=0.3)
        >>> AssembledBody.from_skfem(basis, K, rubber, contact="front", supports={"back": "xyz"}).n_dofs
        375
        """
        if not sp.issparse(stiffness) or stiffness.shape != (basis.N, basis.N):
            raise InputError(
                f"Expected a sparse stiffness of shape ({basis.N}, {basis.N}), as the basis has it; found "
                f"{type(stiffness).__name__} of shape {np.shape(stiffness)}.",
                code="no-sparse-stiffness",
            )
        mesh, dofs = from_skfem_basis(basis)
        own = sp.csr_matrix(stiffness)[dofs.ravel()][:, dofs.ravel()]
        return cls(Mesh(*mesh), material, contact, supports or {}, stiffness=own, **options)
