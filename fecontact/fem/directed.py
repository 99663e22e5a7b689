"""Orthotropic and anisotropic bodies that turn: Hooke's law of Green-Lagrange strains in axes of the initial shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fecontact.common.anisotropic import DirectedMaterial
from fecontact.common.arrays import Array
from fecontact.common.material import Material
from fecontact.fem.laws import FIRST, SECOND, Law, Response, carried


@dataclass(frozen=True, eq=False)
class DirectedLaw(Law):
    """S = C : E, as St. Venant and Kirchhoff's for an isotropic material: for small strains and any turn.

    Source: G. A. Holzapfel, Nonlinear Solid Mechanics (2000), section 6.5.

    Parameters
    ----------
    material : DirectedMaterial
    moduli : (..., 6, 6) array, optional
        C at points, by `at`.
    """

    material: DirectedMaterial
    moduli: Array | None = None
    bulk: float = 0.0

    isotropic = False

    @property
    def density(self) -> float | None:  # type: ignore[override]
        """Of the material."""
        return self.material.density

    @property
    def at_rest(self) -> Material:
        """The isotropic material of the same mean over all directions."""
        return self.material.average

    def at(self, places: Array, in_section: bool = False) -> DirectedLaw:
        """The law with its moduli at points (..., 3) of the initial shape."""
        C = self.material.at(places.reshape(-1, 3))
        return replace(self, moduli=C[0] if len(C) == 1 else C.reshape(*places.shape[:-1], 6, 6))

    def pulled(self, F: Array, volume: float = 1.0, rest: float = 1.0) -> Response:
        """Response in the initial shape, its own measure; of any F."""
        E = ((np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2)[..., FIRST, SECOND] * np.where(FIRST == SECOND, 1.0, 2.0)
        assert self.moduli is not None
        C = rest * np.broadcast_to(self.moduli, (*E.shape, 6))
        s = (C @ E[..., None])[..., 0]
        S, zero = np.zeros(F.shape), np.zeros(())
        S[..., FIRST, SECOND] = S[..., SECOND, FIRST] = s
        return Response((s * E).sum(axis=-1) / 2, S, zero, zero, C, np.broadcast_to(np.eye(3), F.shape))

    def distortion(self, F: Array, J: Array) -> Response:
        """Response of the present shape."""
        found, T = self.pulled(F), carried(F)
        stress = F @ found.stress @ np.swapaxes(F, -1, -2)
        return Response(found.energy, stress, 0 * J, 0 * J, T @ np.asarray(found.moduli) @ np.swapaxes(T, -1, -2))


def directed(given: Any) -> Any:
    """Laws in place of materials whose stiffness depends on the direction, of one or a mapping."""
    if isinstance(given, Mapping):
        return {name: directed(each) for name, each in given.items()}
    return DirectedLaw(given) if isinstance(given, DirectedMaterial) else given
