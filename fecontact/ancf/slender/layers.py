"""Layers of a section that flow plastically, each in simple tension."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array
from fecontact.fem.plastic import Flow, Plastic, Returned

#: Layers in each half of a section.
IN_A_HALF = 6


@dataclass(frozen=True, eq=False)
class Layers:
    """Layers of a section.

    Attributes
    ----------
    along : (n, m) array
        Strains of the layers by those of the section.
    areas : (n,) array
    flow : Flow
    """

    along: Array
    areas: Array
    flow: Flow

    def returned(self, e: Array, memory: Array) -> Returned:
        """A step to strains (..., m) of the section from a memory (..., n, 2)."""
        return self.flow.returned((e @ self.along.T)[..., None], memory)

    def respond(self, e: Array, memory: Array) -> tuple[Array, Array, Array]:
        """Energy (...), stress resultants (..., m) and moduli (..., m, m) of a step to strains (..., m)."""
        step = self.returned(e, memory)
        tangent = self.flow.modulus * (1 - step.along) * self.areas
        moduli = (self.along.T * tangent[..., None, :]) @ self.along
        return step.energy @ self.areas, step.stress[..., 0] * self.areas @ self.along, moduli

    def dissipated(self, strain: Array, sizes: Array) -> float:
        """Energy lost up to accumulated plastic strains (..., n), with lengths (...)."""
        return float(self.flow.given.yield_stress * ((strain @ self.areas) * sizes).sum())


def layers_of(given: Plastic, EA: float, EI: float) -> Layers:
    """Layers of the rectangle that has these rigidities, for its strain, its turns about x and y, and that about z.

    Gauss's rule in each half is exact for the elastic section and for the one that flows throughout.
    """
    x, w = np.polynomial.legendre.leggauss(IN_A_HALF)
    half, area = np.sqrt(3 * EI / EA), EA / given.material.E
    y = half * np.concatenate([(x - 1) / 2, (x + 1) / 2])
    zero = np.zeros_like(y)
    # a curvature about z shortens what lies to the left
    return Layers(np.stack([zero + 1, zero, zero, -y], axis=1), area * np.tile(w, 2) / 4, given.along)
