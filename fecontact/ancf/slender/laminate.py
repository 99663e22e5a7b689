"""Sheets of plates: rigidities of membrane and bending, of one orthotropic layer or several bonded ones.

Classical lamination theory: each layer is in plane stress in its own axes, turned by an angle to those of the plate,
and strains are linear over the thickness, so that resultants N, M of strains e and curvatures k are

    N = A e + B k,    M = B e + D k,    (A, B, D) = int Q (1, z, z^2) dz.

Sources: A. A. Shabana, Computational Continuum Mechanics, eq. 5.127; R. M. Jones, Mechanics of Composite Materials, 2nd
ed., 1999, chapters 2 and 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import lengths, number, positive
from fecontact.common.errors import InputError
from fecontact.common.material import Material


@dataclass(frozen=True)
class Lamina:
    """An orthotropic layer in plane stress.

    Parameters
    ----------
    E1, E2 : float
        Moduli along its first and second axis.
    nu12 : float
        Contraction along the second axis of a stretch along the first; that along the first is nu12 E2 / E1.
    G12 : float
    density : float, optional

    Raises
    ------
    InputError
        For moduli that are not positive, or nu12^2 >= E1 / E2, at which the energy is not.

    Examples
    --------
    >>> Lamina(E1=140e3, E2=10e3, nu12=0.3, G12=5e3).stiffness.round(1).tolist()
    [[140905.8, 3019.4, 0.0], [3019.4, 10064.7, 0.0], [0.0, 0.0, 5000.0]]
    """

    E1: float
    E2: float
    nu12: float
    G12: float
    density: float | None = None

    def __post_init__(self) -> None:
        for name in ("E1", "E2", "G12", *(("density",) if self.density is not None else ())):
            positive(name, getattr(self, name))
        if not number(self.nu12) ** 2 < self.E1 / self.E2:
            raise InputError(
                f"nu12 must lie within the root of E1 / E2, {np.sqrt(self.E1 / self.E2):.4g}; found {self.nu12!r}.",
                code="poisson-ratio",
            )

    @property
    def stiffness(self) -> Array:
        """Q (3, 3) of plane stress, strains xx, yy and the full shear xy."""
        c = self.nu12 * self.E2
        within = np.array([[self.E1, c], [c, self.E2]]) / (1 - self.nu12 * c / self.E1)
        out = np.zeros((3, 3))
        out[:2, :2], out[2, 2] = within, self.G12
        return out


@dataclass(frozen=True)
class Laminate:
    """Bonded layers, from the bottom of a plate (against its normal) to the top.

    Parameters
    ----------
    layers : sequence of (Lamina or Material, float, float)
        Each with its thickness, and the angle in degrees from the plate's x to its first axis, towards y.

    Raises
    ------
    InputError
        Without layers, for thicknesses that are not positive, or if some have a density and others not.

    Examples
    --------
    >>> ply = Lamina(E1=140e3, E2=10e3, nu12=0.3, G12=5e3)
    >>> crossed = Laminate([(ply, 0.5, 0.0), (ply, 0.5, 90.0)])
    >>> crossed.thickness, crossed.coupling[0].round(1).tolist()
    (1.0, [-16355.1, 0.0, 0.0])
    """

    layers: Sequence[tuple[Lamina | Material, float, float]]

    def __post_init__(self) -> None:
        if not len(self.layers):
            raise InputError("A laminate needs a layer or more.", code="no-layers")
        for k, (_, thickness, angle) in enumerate(self.layers):
            lengths(**{f"thickness of layer {k}": thickness})
            number(angle)
        if len({material.density is None for material, _, _ in self.layers}) > 1:
            raise InputError("Give each layer a density, or none.", code="no-density")

    @property
    def thickness(self) -> float:
        """Of all layers."""
        return float(sum(thickness for _, thickness, _ in self.layers))

    @property
    def mass(self) -> float:
        """Per area; zero without densities."""
        return float(sum((material.density or 0.0) * thickness for material, thickness, _ in self.layers))

    @cached_property
    def _integrals(self) -> list[Array]:
        z = np.cumsum([-self.thickness / 2, *(thickness for _, thickness, _ in self.layers)])
        Q = np.stack([_turned(plane_stress(material), angle) for material, _, angle in self.layers])
        return [np.einsum("lij,l->ij", Q, np.diff(z**k) / k) for k in (1, 2, 3)]

    @property
    def membrane(self) -> Array:
        """A (3, 3)."""
        return self._integrals[0]

    @property
    def coupling(self) -> Array:
        """B (3, 3), by the curvature along the normal: zero where layers are symmetric about the middle."""
        B = self._integrals[1]
        return np.where(np.abs(B) > 1e-12 * np.abs(self.membrane).max() * self.thickness, B, 0.0)

    @property
    def bending(self) -> Array:
        """D (3, 3)."""
        return self._integrals[2]


def plane_stress(material: Lamina | Material) -> Array:
    """Hooke's law (3, 3) of a layer, in the order xx, yy, xy."""
    own = getattr(material, "stiffness", None)
    if own is not None:
        return np.asarray(own)
    isotropic = cast(Material, material)
    nu = isotropic.nu
    return np.asarray(isotropic.plane_strain_modulus * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]))


def in_space(material: Material) -> Array:
    """Hooke's law (6, 6), order xx yy zz xy xz yz."""
    D = np.zeros((6, 6))
    D[:3, :3] = material.lame
    D[range(6), range(6)] += material.shear_modulus * np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
    return D


def referred(D: Array, J0: Array) -> Array:
    """Rigidity (.., m, m) for strains along coordinates with derivatives J0 (.., k, k) of the position.

    Parameters
    ----------
    D : (m, m) array
        In orthonormal axes: normal strains, then those of shear, twice the tensor's.
    J0 : (.., k, k) array
        Rows are the derivatives by each coordinate.

    Examples
    --------
    >>> referred(np.eye(1), np.array([[2.0]])).tolist()  # a strain of g . g / 2 is four times that of the length
    [[0.0625]]
    """
    K, k = np.linalg.inv(J0), J0.shape[-1]
    pairs = [(i, i) for i in range(k)] + [(i, j) for i in range(k) for j in range(i + 1, k)]
    a, b = np.array(pairs).T
    both = K[..., a[:, None], a] * K[..., b[:, None], b] + K[..., a[:, None], b] * K[..., b[:, None], a]
    B = both * np.where(a == b, 0.5, 1.0)[:, None]
    if len(D) > len(pairs):  # strains of two kinds
        B = np.concatenate([np.concatenate([B, 0 * B], axis=-1), np.concatenate([0 * B, B], axis=-1)], axis=-2)
    return np.asarray(np.swapaxes(B, -1, -2) @ D @ B)


def sheet(material: Lamina | Material | Laminate, thickness: float | None) -> Laminate:
    """What a plate is made of.

    Raises
    ------
    InputError
        If a single material lacks a thickness, or a laminate has another one.
    """
    if getattr(material, "layers", None) is None:
        if thickness is None:
            raise InputError("A plate of one material needs its thickness.", code="thickness")
        return Laminate([(cast(Material, material), thickness, 0.0)])
    made = cast(Laminate, material)
    if thickness is not None and abs(thickness - made.thickness) > 1e-9 * made.thickness:
        raise InputError(
            f"The laminate is {made.thickness:.6g} thick, and the plate {thickness!r}: leave thickness= out.",
            code="thickness",
        )
    return made


def _turned(Q: Array, angle: float) -> Array:
    """Hooke's law (3, 3) in axes from which its own are turned by an angle in degrees."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    # strains xx, yy, xy (full shear) in the layer's axes by those of the plate
    T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
    return np.asarray(T.T @ Q @ T)
