"""Visco-elastic bricks: Kelvin and Voigt's damper and Maxwell's branches (Prony series) beside the elastic law.

With Green-Lagrange strains E, Hooke's moduli D of the material, and an internal strain A_i of each branch,

    S = S_elastic + t_r D : dE/dt + sum_i g_i D : (E - A_i),    dA_i/dt = (E - A_i) / t_i,

which is linear visco-elasticity in material axes, so that a rigid motion dissipates nothing: suitable for large
rotations and moderate strains (J. C. Simo & T. J. R. Hughes, Computational Inelasticity, 1998, chapter 10). A step is
integrated by the mid-point rule,

    E_m - A_m = (E_m - A_0) / (1 + h/2t_i),    A_1 - A_0 = h/t_i (E_m - A_m),    forces int F_m S_m grad S_a dV,

and as F_m^T (F_1 - F_0) has the symmetric part E_1 - E_0, the work of the forces is exactly the change of the branches'
energy (E - A):g D:(E - A)/2 and what is dissipated, (E_1 - E_0):t_r D:(E_1 - E_0)/h + h/t_i (E_m - A_m):g D:(E_m - A_m)
>= 0. At rest the branches relax, so that statics knows the elastic law only. D and g_i are beside the law after a long
time: those of a `Viscoelastic` are over the moduli at t = 0, from which these follow, D (1 - sum g) and g_i / (1 - sum
g).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.ancf.bricks.space import deformation_gradients
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


@dataclass(frozen=True, eq=False)
class ViscousStep:
    """What viscosity does in a step.

    Attributes
    ----------
    forces : (n_dofs,) array
        Over the step, to be added to the elastic ones.
    memory : (n,) array
        Internal strains at its end.
    viscous_work, stored : float
        Energy lost in the step, and that of the branches at its end.
    """

    forces: Array
    memory: Array
    viscous_work: float
    stored: float


def relaxed(solid: AncfSolid, q: Array) -> Array:
    """Internal strains (n,) of a state in which all branches are relaxed: A_i = E."""
    assert solid.viscous is not None
    e, n = solid.space.spread(q), len(solid.viscous.branches)
    each = [
        np.broadcast_to(_strain(deformation_gradients(e, part.batch)), (n, *part.batch.dV.shape, 3, 3)).ravel()
        for part in solid.parts()
    ]
    return np.concatenate([np.zeros(0), *each])


def viscous_step(solid: AncfSolid, q0: Array, q1: Array, h: float, memory: Array) -> ViscousStep:
    """Forces, memory and energies of a step of length h from coordinates q0 to q1.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSolid, AncfSpace
    >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    >>> solid = AncfSolid(space, fc.Material(E=3.0, nu=0.0), viscosity=Viscosity(retardation=2.0))
    >>> step = viscous_step(solid, space.q0, space.affine(np.diag([1.001, 1.0, 1.0])), 1.0, relaxed(solid, space.q0))
    >>> round(step.viscous_work / 1e-6, 2)  # E t_r (0.001)^2 / h
    6.01
    """
    assert solid.viscous is not None
    e0, e1, branches = solid.space.spread(q0), solid.space.spread(q1), solid.viscous.branches
    total, kept, lost, stored, start = np.zeros_like(e0), [np.zeros(0)], 0.0, 0.0, 0
    g, t = (c[:, None, None, None, None] for c in branches.T)
    for part in solid.parts():
        batch, (lame, shear) = part.batch, solid.moduli(part.batch.cells[:, None], part.volume, part.rest)
        F0, F1 = deformation_gradients(e0, batch), deformation_gradients(e1, batch)
        E0, E1 = _strain(F0), _strain(F1)
        size = len(branches) * E0.size
        A0 = memory[start : start + size].reshape(len(branches), *E0.shape)
        start += size
        away = ((E0 + E1) / 2 - A0) / (1 + h / (2 * t))
        A1 = A0 + h / t * away
        rate = solid.viscous.retardation / h * (E1 - E0)
        stress = [_hooke(x, lame, shear) for x in (rate, (g * away).sum(axis=0))]
        lost += float(((stress[0] * (E1 - E0)).sum(axis=(2, 3)) * batch.dV).sum())
        for share, time, x, y in zip(branches[:, 0], branches[:, 1], away, E1 - A1, strict=True):
            lost += float(share * h / time * (_power(x, lame, shear) * batch.dV).sum())
            stored += float(share / 2 * (_power(y, lame, shear) * batch.dV).sum())
        batch.add_forces(total, (F0 + F1) / 2 @ (stress[0] + stress[1]))
        kept.append(A1.ravel())
    return ViscousStep(solid.space.gather(total), np.concatenate(kept), lost, stored)


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


def _strain(F: Array) -> Array:
    return (np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2


def _hooke(E: Array, lame: Array, shear: Array) -> Array:
    """D : E."""
    trace = np.trace(E, axis1=2, axis2=3) * lame
    return trace[..., None, None] * np.eye(3) + 2 * shear[..., None, None] * E


def _power(E: Array, lame: Array, shear: Array) -> Array:
    """E : D : E."""
    return np.asarray((_hooke(E, lame, shear) * E).sum(axis=(2, 3)))
