"""Finite element model of a stiffness assembled elsewhere, by scikit-fem or another program."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sp

from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.model import Model
from fecontact.fem.support import Support
from fecontact.mesh.mesh import Mesh

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
        self.given = self._checked(stiffness)

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
        return self.given
