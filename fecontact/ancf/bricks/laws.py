"""Elastic laws of finite strain: energy, second Piola-Kirchhoff stress and its tangent at points.

Every law takes Lame's constants and is the sum of a volumetric part with lambda and a part with mu, so that the two can
be integrated at different points (see `solid`). Both laws tend to Hooke's for small strains. The part with lambda is
lambda/2 v^2 of a dilatation v, tr E or ln J, which can be projected in each cell against locking.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fecontact.common.arrays import Array
from fecontact.fem.element_stiffness import determinant_3x3, inverse_3x3
from fecontact.fem.laws import InvertedError


@dataclass(frozen=True, eq=False)
class Response:
    """Energy, stress and tangent at points.

    Attributes
    ----------
    energy : (...) array
        Per initial volume.
    stress : (..., 3, 3) array
        Second Piola-Kirchhoff stress S = dW/dE.
    tangent : (..., 3, 3, 3, 3) array or None
        dS/dE, with all its symmetries; None where it is not asked for or `moduli` tell it.
    moduli : (a, b, X) or None
        Of a tangent a X_IJ X_KL + b (X_IK X_JL + X_IL X_JK), with a and b (...) and a
        symmetric X (..., 3, 3), which costs a fraction of the full one.
    """

    energy: Array
    stress: Array
    tangent: Array | None
    moduli: tuple[Array, Array, Array] | None = None


@dataclass(frozen=True, eq=False)
class Dilatation:
    """A measure v of the change of volume, with lambda/2 v^2 in the energy.

    Attributes
    ----------
    value : (...) array
        v.
    rate : (..., 3, 3) array
        X = dv/dE.
    bend : float
        k of its second derivative -k (X_IK X_JL + X_IL X_JK).
    """

    value: Array
    rate: Array
    bend: float


class Law(Protocol):
    """An isotropic hyperelastic law."""

    def __call__(self, F: Array, lame: Array, shear: Array, tangent: bool = True) -> Response:
        """Response to deformation gradients F (..., 3, 3) with Lame's constants that broadcast over (...)."""


@dataclass(frozen=True)
class StVenantKirchhoff:
    """W = lambda/2 (tr E)^2 + mu E : E of the Green-Lagrange strain E = (F^T F - 1)/2.

    Suitable for large rotations with small strains; it softens under strong compression. Source: Bonet & Wood,
    Nonlinear Continuum Mechanics for Finite Element Analysis (2008), section 6.4.1.

    Examples
    --------
    >>> import numpy as np
    >>> out = StVenantKirchhoff()(np.diag([1.1, 1.0, 1.0]), np.array(1.0), np.array(1.0))
    >>> out.stress.diagonal().round(6).tolist()
    [0.315, 0.105, 0.105]
    """

    def __call__(self, F: Array, lame: Array, shear: Array, tangent: bool = True) -> Response:
        """Response to deformation gradients."""
        E = (np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2
        trace = np.trace(E, axis1=-2, axis2=-1)
        energy = lame / 2 * trace**2 + shear * (E * E).sum(axis=(-1, -2))
        stress = (lame * trace)[..., None, None] * np.eye(3) + 2 * np.asarray(shear)[..., None, None] * E
        if not tangent:
            return Response(energy, stress, None)
        return Response(energy, stress, None, (lame, shear, np.eye(3)))

    def dilatation(self, F: Array) -> Dilatation:
        """V = tr E."""
        E = (np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2
        return Dilatation(np.trace(E, axis1=-2, axis2=-1), np.broadcast_to(np.eye(3), F.shape), 0.0)


@dataclass(frozen=True)
class NeoHookean:
    """Compressible: W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2, with C = F^T F and J = det F > 0.

    Source: Bonet & Wood (2008), section 6.4.3, equations 6.27-6.31.

    Examples
    --------
    >>> import numpy as np
    >>> float(NeoHookean()(np.eye(3), np.array(1.0), np.array(1.0)).energy)
    0.0
    """

    def __call__(self, F: Array, lame: Array, shear: Array, tangent: bool = True) -> Response:
        """Response to deformation gradients.

        Raises
        ------
        InvertedError
            If det F <= 0 somewhere.
        """
        det = determinant_3x3(F)
        if not (det > 0).all():
            raise InvertedError(
                f"The deformation turns the material inside out at {int((~(det > 0)).sum())} points (smallest det F "
                f"{det.min():.3g}); a neo-Hookean material cannot. Apply the load in smaller steps."
            )
        log = np.log(det)
        C = np.swapaxes(F, -1, -2) @ F
        inverse, _ = inverse_3x3(C)
        energy = shear * (0.5 * (np.trace(C, axis1=-2, axis2=-1) - 3) - log) + lame / 2 * log**2
        mu = np.asarray(shear)[..., None, None]
        stress = mu * (np.eye(3) - inverse) + (lame * log)[..., None, None] * inverse
        if not tangent:
            return Response(energy, stress, None)
        return Response(energy, stress, None, (lame, shear - lame * log, inverse))

    def dilatation(self, F: Array) -> Dilatation:
        """V = ln J."""
        inverse, _ = inverse_3x3(np.swapaxes(F, -1, -2) @ F)
        return Dilatation(np.log(determinant_3x3(F)), inverse, 1.0)
