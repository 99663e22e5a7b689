"""A liquid that hardly changes its volume: pressure by a penalty, no resistance to shear."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import positive
from fecontact.common.material import Material
from fecontact.fem.laws import Law, Response

#: Shear modulus over the bulk modulus of the linear material that stands for it where one is asked for.
HARDLY = 1e-9


@dataclass(frozen=True)
class Liquid(Law):
    """A liquid: W = bulk/2 (ln J)^2, for motion in time; its viscosity is ``Viscosity(newtonian=)`` of the solid.

    Without shear stiffness it has no stable state of statics. Its cells follow the liquid, so that it may slosh but not
    break. Source: C. Wei, L. Wang & A. A. Shabana, J. Comput. Nonlinear Dynam. 10 (2015) 051014 (a total Lagrangian
    liquid of bricks; the penalty in place of their condition).

    Parameters
    ----------
    bulk : float
        A thousand times the largest pressure keeps the volume to a thousandth; waves of pressure are as fast as the
        root of bulk over density.
    density : float, optional

    Examples
    --------
    >>> water = Liquid(bulk=2.2e9, density=1000.0)
    >>> float(water.cauchy(np.diag([1.0, 1.0, 1.0 - 1e-6]))[0, 0].round())
    -2200.0
    """

    bulk: float
    density: float | None = None

    def __post_init__(self) -> None:
        positive("the bulk modulus", self.bulk)
        _ = self.at_rest

    @cached_property
    def at_rest(self) -> Material:
        """The linear material that it is at small strains, which has hardly any shear stiffness."""
        return Material(9 * HARDLY * self.bulk / (3 + HARDLY), (3 - 2 * HARDLY) / (6 + 2 * HARDLY), self.density)

    def distortion(self, F: Array, J: Array) -> Response:
        """Nothing."""
        zero = np.zeros_like(J)
        return Response(zero, np.zeros_like(F), zero, zero)
