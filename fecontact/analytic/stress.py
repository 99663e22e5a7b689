"""Stress fields returned by the closed forms, tension positive, with maximum shear and von Mises stress."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.common.arrays import Array


@dataclass(frozen=True, eq=False)
class AxisymmetricStress:
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

    @property
    def max_shear(self) -> Array:
        """Largest shear stress at each point, over all planes."""
        return _max_shear(self.rr, self.zz, self.rz, self.tt)

    @property
    def von_mises(self) -> Array:
        """Equivalent stress of von Mises at each point."""
        return _von_mises(self.rr, self.tt, self.zz, self.rz)


@dataclass(frozen=True, eq=False)
class SymmetryPlaneStress:
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

    @property
    def max_shear(self) -> Array:
        """Largest shear stress at each point, over all planes."""
        return _max_shear(self.xx, self.zz, self.xz, self.yy)

    @property
    def von_mises(self) -> Array:
        """Equivalent stress of von Mises at each point."""
        return _von_mises(self.xx, self.yy, self.zz, self.xz)


def _max_shear(first: Array, second: Array, shear: Array, third: Array) -> Array:
    """Half the difference of the largest and smallest principal stress, where `third` is one of the three."""
    radius = np.hypot((first - second) / 2, shear)
    # Distance of the third principal stress from the centre of the other two, formed without cancellation.
    offset = np.abs((third - first) + (third - second)) / 2
    return np.asarray(np.maximum(radius, (radius + offset) / 2))


def _von_mises(first: Array, second: Array, third: Array, shear: Array) -> Array:
    squares = (first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2
    return np.asarray(np.sqrt(squares / 2 + 3 * shear**2))
