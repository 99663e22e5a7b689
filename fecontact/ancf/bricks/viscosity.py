"""Visco-elastic bricks: Kelvin and Voigt's damper and Maxwell's branches (Prony series) beside the elastic law.

With Green-Lagrange strains E, Hooke's moduli D of the material, and an internal strain A_i of each branch,

    S = S_elastic + t_r D : dE/dt + sum_i g_i D : (E - A_i),    dA_i/dt = (E - A_i) / t_i,

which is linear visco-elasticity in material axes, so that a rigid motion dissipates nothing: suitable for large
rotations and moderate strains (J. C. Simo & T. J. R. Hughes, Computational Inelasticity, 1998, chapter 10). `memory`
integrates a step; as F_m^T (F_1 - F_0) has the symmetric part E_1 - E_0, forces int F_m S_m grad S_a dV do the work of
its stresses. At rest the branches relax, so that statics knows the elastic law only. D and g_i are beside the law after
a long time: those of a `Viscoelastic` are over the moduli at t = 0, from which these follow, D (1 - sum g) and g_i / (1
- sum g).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.renamed import warn
from fecontact.common.viscoelastic import beside, prony_pairs
from fecontact.fem.element_stiffness import determinant_3x3, inverse_3x3
from fecontact.fem.laws import Response

if TYPE_CHECKING:
    from fecontact.ancf.bricks.solid import AncfSolid, Part


@dataclass(frozen=True)
class Viscosity:
    """Viscosity of a solid of bricks.

    Parameters
    ----------
    retardation : float
        Time t_r of Kelvin and Voigt: creep under a constant force approaches its end as exp(-t/t_r).
    newtonian : float
        Dynamic viscosity of a liquid, in place of the others: Cauchy stress 2 eta dev d of the rate of deformation d.
    prony : sequence of (float, float)
        Former way to give branches (g, t), as shares beside the moduli after a long time; a solid that takes them
        warns. Now they are of its material, ``fc.Viscoelastic(material, prony=)``, as shares of the moduli at t = 0.

    Raises
    ------
    InputError
        For negative or infinite numbers, times of zero, or if nothing is viscous.

    Examples
    --------
    >>> Viscosity(prony=[(0.5, 1.0), (0.2, 10.0)]).branches.tolist()
    [[0.5, 1.0], [0.2, 10.0]]
    """

    retardation: float = 0.0
    prony: ArrayLike = ()
    newtonian: float = 0.0

    def __post_init__(self) -> None:
        times = np.array([self.retardation, self.newtonian, *prony_pairs(self.prony).ravel()], dtype=float)
        if not (np.isfinite(times).all() and (times >= 0).all() and (times[2:] > 0).all() and times.any()):
            raise InputError(
                "Viscosity needs a retardation time, a Prony series of positive shares and times, or that of a liquid, "
                f"all finite; found retardation {self.retardation!r}, {self.prony!r} and newtonian {self.newtonian!r}.",
                code="retardation",
            )
        if self.newtonian and times.sum() > self.newtonian:
            raise InputError(
                "A liquid, newtonian=, has no moduli for a retardation time or a Prony series.", code="liquid"
            )

    @property
    def branches(self) -> Array:
        """Shares and times (n, 2)."""
        return np.asarray(self.prony, dtype=float).reshape(-1, 2)


def relaxing(material: Any, viscosity: Viscosity | None) -> tuple[Any, Viscosity | None]:
    """The materials after a long time, and all that is viscous beside them.

    Raises
    ------
    InputError
        For branches given twice, and see `beside`.
    """
    relaxed, pairs = beside(material)
    if viscosity is not None and len(viscosity.branches):
        if len(pairs):
            raise InputError(
                "A Prony series is given twice: leave it to Viscoelastic(material, prony=), without Viscosity(prony=).",
                code="prony-series",
            )
        warn(
            "Viscosity(prony=) is now that of the material: Viscoelastic(material, prony=), with E times 1 + sum g and "
            "each g over 1 + sum g; prony= will be removed.",
            stacklevel=5,
        )
        return material, viscosity
    return relaxed, Viscosity(
        viscosity.retardation if viscosity else 0.0, pairs, viscosity.newtonian if viscosity else 0.0
    ) if len(pairs) else viscosity


def stiffening(viscosity: Viscosity, h: float) -> float:
    """Multiple of Hooke's moduli by which the end of a step of length h is resisted."""
    g, t = viscosity.branches.T
    return float(viscosity.retardation / h + (g / (2 + h / t)).sum())


def drag(eta: float, F: Array, rate: Array) -> Array:
    """Second Piola-Kirchhoff stress (..., 9) of a liquid by the rate (..., 9) of Green-Lagrange strains.

    As d = F^-T dE/dt F^-1, it is 2 eta J C^-1 dE/dt C^-1 less its pressure.

    Examples
    --------
    >>> drag(0.5, np.eye(3), np.array([0.0, 1, 0, 1, 0, 0, 0, 0, 0])).reshape(3, 3).tolist()  # sheared at a rate of 2
    [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    """
    X, J = inverse_3x3(np.swapaxes(F, -1, -2) @ F)[0], determinant_3x3(F)
    turned = X @ rate.reshape(F.shape) @ X
    spread = (X * rate.reshape(F.shape)).sum(axis=(-1, -2))[..., None, None] * X
    return np.asarray(2 * eta * (J[..., None, None] * (turned - spread / 3)).reshape(rate.shape))


def viscous_response(solid: AncfSolid, h: float, part: Part, F: Array) -> Response:
    """Moduli of some cells for the tangent of a step, without the stress, at deformation gradients F of its middle."""
    assert solid.viscous is not None
    if solid.viscous.newtonian:
        eta = part.rest * solid.viscous.newtonian / h * determinant_3x3(F)
        X = inverse_3x3(np.swapaxes(F, -1, -2) @ F)[0]
        return Response(0 * eta, np.zeros_like(F), -2 / 3 * eta, eta, None, X)
    shape, share = part.batch.dV.shape, stiffening(solid.viscous, h)
    lame, shear = solid.moduli(part.batch.cells[:, None], part.volume, part.rest)
    unit = np.broadcast_to(np.eye(3), (*shape, 3, 3))
    return Response(np.zeros(shape), np.zeros((*shape, 3, 3)), share * lame, share * shear, None, unit)
