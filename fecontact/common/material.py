"""Isotropic linear elastic material."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fecontact.common.arguments import spelled
from fecontact.common.arrays import Array
from fecontact.common.checks import check_magnitude, finite, number, positive
from fecontact.common.errors import InputError, shown

#: Order of the six components of symmetric tensors, as in VTK files.
VOIGT = ("xx", "yy", "zz", "xy", "yz", "xz")
#: Components at the places of a tensor.
SYMMETRIC = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
#: Their places in a tensor.
FIRST, SECOND = np.array(["xyz".index(k) for v in VOIGT for k in v]).reshape(6, 2).T


@spelled
@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic material, in any consistent units.

    Parameters
    ----------
    E : float
        Young's modulus (force / length^2), positive.
    nu : float
        Poisson's ratio, strictly between -1 and 0.5.
    density : float, optional
        Mass per volume, positive; needed only for gravity and dynamics.
    expansion : float, optional
        Coefficient of linear thermal expansion, strain per change of temperature; needed only for ``temperatures=``.

    Raises
    ------
    InputError
        If a value is not finite or outside its physical range.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> round(steel.plane_strain_modulus, 1)
    230769.2
    """

    E: float
    nu: float
    density: float | None = None
    expansion: float | None = None
    #: Whether the stiffness depends on the direction, and whether that is another at other points.
    directed: ClassVar[bool] = False
    varies: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_magnitude("Young's modulus E", positive("Young's modulus E", self.E))
        if not -1 < number(self.nu) < 0.5:
            raise InputError(
                f"Poisson's ratio must lie strictly between -1 and 0.5; found nu = {shown(self.nu)}. "
                "For a nearly incompressible material use a value such as 0.4999.",
                code="poisson-ratio",
            )
        if self.density is not None:
            check_magnitude("the density", positive("the density", self.density))
        if self.expansion is not None:
            check_magnitude("the coefficient of expansion", finite("the coefficient of expansion", self.expansion))

    @property
    def average(self) -> Material:
        """Itself: its mean over all directions."""
        return self

    def at(self, points: Array) -> Array:
        """Stiffness C (1, 6, 6), the same at all points, components as in `VOIGT`, shears doubled in the strain."""
        mu = self.shear_modulus * np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
        return np.asarray(self.lame * np.outer(FIRST == SECOND, FIRST == SECOND) + np.diag(mu))[None]

    @property
    def lame(self) -> float:
        """First Lame constant, E nu / ((1 + nu)(1 - 2 nu))."""
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))

    @property
    def shear_modulus(self) -> float:
        """Shear modulus, E / (2 (1 + nu))."""
        return self.E / (2 * (1 + self.nu))

    @property
    def plane_strain_modulus(self) -> float:
        """E / (1 - nu^2), the indentation modulus of a half-space."""
        return self.E / (1 - self.nu**2)


def von_mises(stress: Array) -> Array:
    """Equivalent stress (...) of components (..., 6)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + yz**2 + xz**2))
