"""Stress fields returned by the closed forms, tension positive, with maximum shear and von Mises stress."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from fecontact.common.arrays import Array


class _InSymmetryPlane:
    """Components at points of a plane of symmetry: the first in it, that across it, the second in it, the shear."""

    @property
    def max_shear(self) -> Array:
        """Largest shear stress at each point, over all planes."""
        first, third, second, shear = self._components
        radius = np.hypot((first - second) / 2, shear)
        # Distance of the third principal stress from the centre of the other two, formed without cancellation.
        offset = np.abs((third - first) + (third - second)) / 2
        return np.asarray(np.maximum(radius, (radius + offset) / 2))

    @property
    def von_mises(self) -> Array:
        """Equivalent stress of von Mises at each point."""
        first, third, second, shear = self._components
        squares = (first - third) ** 2 + (third - second) ** 2 + (second - first) ** 2
        return np.asarray(np.sqrt(squares / 2 + 3 * shear**2))

    @property
    def _components(self) -> list[Array]:
        return [getattr(self, field.name) for field in fields(self)]  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class AxisymmetricStress(_InSymmetryPlane):
    """Stress in cylindrical coordinates (r, theta, z), tension positive, z into the body.

    Parameters
    ----------
    rr, tt, zz, rz : numpy.ndarray
        Radial, hoop, axial and shear stress, all of the same shape.

    Examples
    --------
    >>> AxisymmetricStress(rr=np.array(-1.0), tt=np.array(-1.0), zz=np.array(-3.0), rz=np.array(0.0)).max_shear
    array(1.)
    """

    rr: Array
    tt: Array
    zz: Array
    rz: Array


@dataclass(frozen=True, eq=False)
class SymmetryPlaneStress(_InSymmetryPlane):
    """Stress in a plane of symmetry y = 0, where xy and yz vanish; tension positive, z into the body.

    Parameters
    ----------
    xx, yy, zz, xz : numpy.ndarray
        Stress components, all of the same shape.

    Examples
    --------
    >>> SymmetryPlaneStress(xx=np.array(1.0), yy=np.array(0.0), zz=np.array(-1.0), xz=np.array(0.0)).max_shear
    array(1.)
    """

    xx: Array
    yy: Array
    zz: Array
    xz: Array
