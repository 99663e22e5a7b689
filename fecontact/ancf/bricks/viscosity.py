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

    def __post_init__(self) -> None:
        times = np.array([self.retardation, *prony_pairs(self.prony).ravel()], dtype=float)
        if not (np.isfinite(times).all() and (times >= 0).all() and (times[1:] > 0).all() and times.any()):
            raise InputError(
                "Viscosity needs a retardation time or a Prony series of positive shares and times, all finite; found "
                f"retardation {self.retardation!r} and {self.prony!r}.",
                code="retardation",
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
    return relaxed, Viscosity(viscosity.retardation if viscosity else 0.0, pairs) if len(pairs) else viscosity


def stiffening(viscosity: Viscosity, h: float) -> float:
    """Multiple of Hooke's moduli by which the end of a step of length h is resisted."""
    g, t = viscosity.branches.T
    return float(viscosity.retardation / h + (g / (2 + h / t)).sum())


def viscous_response(solid: AncfSolid, h: float, part: Part) -> Response:
    """Moduli of some cells for the tangent of a step, without the stress."""
    assert solid.viscous is not None
    shape, share = part.batch.dV.shape, stiffening(solid.viscous, h)
    lame, shear = solid.moduli(part.batch.cells[:, None], part.volume, part.rest)
    unit = np.broadcast_to(np.eye(3), (*shape, 3, 3))
    return Response(np.zeros(shape), np.zeros((*shape, 3, 3)), share * lame, share * shear, None, unit)
