"""Elastic forces between two states whose work is exactly the change of strain energy (discrete gradient).

    Q = int F_mid S* grad S_a dV,    S* = S(E_mid) + (W_1 - W_0 - S(E_mid) : dE) / (dE : dE) dE

with F_mid and E_mid the means of both states and dE = E_1 - E_0, so that Q . (q_1 - q_0) = U_1 - U_0; linear and
angular momentum are conserved too, since S* is symmetric (O. Gonzalez, Exact energy and momentum conserving algorithms
for general models in nonlinear elasticity, Comput. Methods Appl. Mech. Engrg. 190, 2000; J. C. Simo & N. Tarnow, ZAMP
43, 1992, for St. Venant-Kirchhoff, where S* is the mean of both stresses).

A dilatation v that is projected in each cell has the energy lambda/2 (Pv)^2, whose change over a cell is the sum of
lambda P(v_0 + v_1)/2 (v_1 - v_0), as P is self-adjoint; the derivative of v is corrected in the same way.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np

from fecontact.ancf.laws import Dilatation, InvertedError, Law
from fecontact.ancf.space import AncfSpace, GradientBatch, deformation_gradients
from fecontact.common.arrays import Array, Mask

#: Change of strain, relative to the largest strain, below which the second term of S* is rounding.
SMALLEST_CHANGE = 1e-6
#: The same for any strain: energies are rounded to 1e-16 of the modulus, which divided by the change is an error of the
#: stress; without the term the error is the square of the change. Both are equal at the third root of 1e-16.
ROUNDED_CHANGE = 5e-6


class Elastic(Protocol):
    """What a solid of bricks has to tell; see `solid.AncfSolid`."""

    @property
    def space(self) -> AncfSpace:
        """Coordinates and functions."""

    @property
    def law(self) -> Law:
        """Stress and energy of a deformation."""

    @property
    def lame(self) -> Array:
        """First Lame constant of each cell."""

    @property
    def shear(self) -> Array:
        """Shear modulus of each cell."""

    def rules(self) -> list[tuple[Iterable[GradientBatch], float, float]]:
        """Gauss rules, with the factors of lambda and mu in each."""

    def dilatation(self, F: Array) -> Dilatation | None:
        """The law's measure of volume where it is projected in each cell."""

    def projected(self, values: Array, batch: GradientBatch) -> Array:
        """Its projection."""


def forces_between(solid: Elastic, q0: Array, q1: Array) -> Array:
    """Conserving elastic forces (n_dofs,) between coordinates q0 and q1.

    Raises
    ------
    InvertedError
        If the mean of C = F^T F of both states is singular at a point.

    Examples
    --------
    >>> import numpy as np, fecontact as fc
    >>> from fecontact.ancf import AncfSolid, AncfSpace, NeoHookean
    >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    >>> solid = AncfSolid(space, fc.Material(E=1.0, nu=0.3), NeoHookean())
    >>> a, b = space.affine(np.diag([1.0, 1.1, 0.9])), space.affine(np.diag([1.2, 1.0, 1.0]))
    >>> work = forces_between(solid, a, b) @ (b - a)
    >>> bool(abs(work - (solid.energy(b) - solid.energy(a))) < 1e-14)
    True
    """
    e0, e1 = solid.space.spread(q0), solid.space.spread(q1)
    total = np.zeros_like(e0)
    for batches, lame, shear in solid.rules():
        for batch in batches:
            F0, F1 = deformation_gradients(e0, batch), deformation_gradients(e1, batch)
            constants = lame * solid.lame[batch.cells, None], shear * solid.shear[batch.cells, None]
            C0, C1 = (np.swapaxes(F, 2, 3) @ F for F in (F0, F1))
            try:
                middle = np.swapaxes(np.linalg.cholesky((C0 + C1) / 2), 2, 3)  # any F with F^T F = C_mid will do
            except np.linalg.LinAlgError as error:
                raise InvertedError("Material is flattened to nothing in both states of a step.") from error
            S = solid.law(middle, *constants, tangent=False).stress
            before, after = (solid.law(F, *constants, tangent=False).energy for F in (F0, F1))
            change = (C1 - C0) / 2
            size = (change * change).sum(axis=(2, 3))
            strain = max(np.abs(C0 - np.eye(3)).max(), np.abs(C1 - np.eye(3)).max()) / 2
            large = size > max(SMALLEST_CHANGE * strain, ROUNDED_CHANGE) ** 2
            S = _discrete(S, after - before, change, large, size)
            v, v0, v1 = (solid.dilatation(F) for F in (middle, F0, F1))
            if v is not None and v0 is not None and v1 is not None:
                # half the difference of projected squares: their mean times the change of v
                pressure = solid.lame[batch.cells, None] * solid.projected((v0.value + v1.value) / 2, batch)
                S = S + pressure[..., None, None] * _discrete(v.rate, v1.value - v0.value, change, large, size)
            P = (F0 + F1) / 2 @ S * batch.dV[..., None, None]
            n, n_q = batch.dV.shape
            G = batch.gradients.swapaxes(2, 3).reshape(n, 3 * n_q, -1)
            np.add.at(total, batch.functions, np.swapaxes(G, 1, 2) @ P.swapaxes(2, 3).reshape(n, 3 * n_q, 3))
    return solid.space.gather(total)


def _discrete(rate: Array, difference: Array, change: Array, large: Mask, size: Array) -> Array:
    """A derivative (.., 3, 3) at the middle, corrected along the change such that it gives the difference."""
    missing = difference - (rate * change).sum(axis=(2, 3))
    return np.asarray(rate + np.where(large, missing / np.where(large, size, 1.0), 0.0)[..., None, None] * change)
