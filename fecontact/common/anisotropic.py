"""Linear elastic materials whose stiffness depends on the direction, and the axes that they lie along.

Stress = C strain, with components in the order xx, yy, zz, xy, yz, xz (`VOIGT`) and shears doubled in the strain. In
other axes, the rows a_p of a rotation, strains are eps'_pq = a_pi a_qj eps_ij = T eps, and C = T^T C' T as the energy
stays the same. Engineering constants give the compliance C^-1: 1 / E_i on its diagonal, -nu_ij / E_i beside it,
1 / G_ij of the shears (Lekhnitskii, Theory of Elasticity of an Anisotropic Body, 1963, sections 3 to 5).
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Any, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import spelled
from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, check_magnitude, finite, positive, positives, vector
from fecontact.common.errors import InputError, shown
from fecontact.common.material import FIRST, SECOND, Material

#: Smallest eigenvalue of a stiffness or compliance of unit diagonal that is positive beyond rounding of its constants.
POSITIVE = 1e-9
#: Error of the entries of C, relative to its largest, or of axes, that is rounding of what was written down.
ROUNDING = 1e-6
#: Distance from the line of cylindrical axes, relative to the largest coordinate, that counts as on it.
ON_AXIS = 1e-9


@spelled
@dataclass(frozen=True)
class CylindricalAxes:
    """Axes about a line: radial, tangential, along it; at points of the line itself any radius.

    Parameters
    ----------
    direction : (3,) array_like
        Along the line.
    point : (3,) array_like, optional
        On it.

    Examples
    --------
    >>> CylindricalAxes((0, 0, 1))(np.array([[0.0, 2.0, 5.0]]))[0].tolist()
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """

    direction: ArrayLike
    point: ArrayLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("direction", "point"):
            object.__setattr__(self, name, tuple(vector(f"the {name} of the axes", getattr(self, name)).tolist()))
        if not any(np.ravel(self.direction)):
            raise InputError("The direction of cylindrical axes must not be zero.", code="no-direction")

    def __call__(self, points: Array) -> Array:
        """Axes (n, 3, 3) at points (n, 3)."""
        along = np.array(self.direction) / np.linalg.norm(self.direction)
        out = points - np.array(self.point)
        out = out - np.outer(out @ along, along)
        length = np.linalg.norm(out, axis=1)
        on = length <= ON_AXIS * np.abs(points).max(initial=0.0)
        out[on], length[on] = np.linalg.svd(along[None])[2][1], 1.0
        radial = out / length[:, None]
        return np.stack([radial, np.cross(along, radial), np.broadcast_to(along, radial.shape)], axis=1)


class DirectedMaterial:
    """A material with a stiffness in axes of its own."""

    axes: Any
    density: float | None
    expansion: float | tuple[float, float, float] | None
    #: Whether its stiffness depends on the direction.
    directed = True

    @property
    def varies(self) -> bool:
        """Whether its axes differ from point to point."""
        return callable(self.axes)

    @property
    @abstractmethod
    def stiffness(self) -> Array:
        """C (6, 6) in its axes."""

    def at(self, points: Array) -> Array:
        """C (n, 6, 6) at points (n, 3), or (1, 6, 6) where it is the same everywhere.

        Raises
        ------
        InputError
            If a function gives no axes for each point.
        """
        axes = self._axes_at(points)
        return self.stiffness[None] if axes is None else turned(self.stiffness, axes)

    def expansion_at(self, points: Array) -> Array:
        """Strains (n or 1, 6) per change of temperature at points (n, 3), shears not doubled.

        Examples
        --------
        >>> wood = OrthotropicMaterial((9.0, 1, 1), (0.3, 0.3, 0.3), (1.0, 1, 1), expansion=(1.0, 2.0, 3.0))
        >>> wood.expansion_at(np.zeros((1, 3)))[0].tolist()
        [1.0, 2.0, 3.0, 0.0, 0.0, 0.0]
        """
        along = np.broadcast_to(np.asarray(self.expansion, float), 3)
        axes = self._axes_at(points)
        axes = np.eye(3)[None] if axes is None else axes
        return np.einsum("p,npi,npi->ni", along, axes[..., FIRST], axes[..., SECOND])

    def _axes_at(self, points: Array) -> Array | None:
        """Axes (n or 1, 3, 3) at points (n, 3); None of those of the body."""
        if not self.varies:
            return None if self.axes is None else np.array([self.axes])
        found = array_of(self.axes(points))
        if found is None or found.shape != (len(points), 3, 3):
            raise InputError(
                f"The axes of a material at {len(points)} points must be an array ({len(points)}, 3, 3); found "
                f"{shown(found)}.",
                code="wrong-shape",
            )
        return _checked(found)

    def exchanged(self) -> Self:
        """The same material where y and z are exchanged.

        Its axes stay right-handed, as the third one is turned back, which changes the sign of what is odd in it.

        Examples
        --------
        >>> wood = OrthotropicMaterial((9.0, 2, 1), (0.3, 0.3, 0.3), (1.0, 1, 1)).exchanged()
        >>> (1 / np.linalg.inv(wood.at(np.zeros((1, 3)))[0]).diagonal()[:3]).round(12).tolist()
        [9.0, 1.0, 2.0]
        """
        axes, order, back = self.axes, [0, 2, 1], np.array([[1.0], [1.0], [-1.0]])

        def everywhere(x: Array) -> Array:
            return np.asarray(axes(x[:, order])[..., order] * back)

        once = None if self.varies else (np.eye(3) if axes is None else np.array(axes))[:, order] * back
        return cast(Self, replace(cast(Any, self), axes=everywhere if self.varies else once))

    @property
    def average(self) -> Material:
        """The isotropic material of the same mean over all directions (Voigt's; Hill, Proc. Phys. Soc. A 65, 1952)."""
        C = self.stiffness
        normal, shear = C[:3, :3], np.trace(C[3:, 3:])
        K = normal.sum() / 9
        G = (1.5 * np.trace(normal) - normal.sum() / 2 + 3 * shear) / 15
        nu = (3 * K - 2 * G) / (2 * (3 * K + G))
        mean = None if self.expansion is None else float(np.mean(self.expansion))
        return Material(float(9 * K * G / (3 * K + G)), float(nu), self.density, mean)

    def _check(self, C: Array) -> None:
        """Refuse what is not elastic, and normalise the axes.

        Raises
        ------
        InputError
        """
        scale = np.sqrt(np.abs(np.diag(C)))
        if not (np.diag(C) > 0).all() or np.linalg.eigvalsh(C / np.outer(scale, scale))[0] <= POSITIVE:
            raise InputError(
                f"A strain would take no energy, or give some: the stiffness of {type(self).__name__} is not positive "
                "definite. With engineering constants nu_ij^2 < E_i / E_j, and 1 - nu_12 nu_21 - nu_23 nu_32 - "
                "nu_13 nu_31 - 2 nu_21 nu_32 nu_13 > 0, where nu_ji = nu_ij E_j / E_i.",
                code="not-positive-definite",
            )
        if self.density is not None:
            positive("the density", self.density)
        if self.expansion is not None and np.ndim(self.expansion):
            along = vector("the coefficients of expansion along the axes", self.expansion)
            object.__setattr__(self, "expansion", tuple(along.tolist()))
        elif self.expansion is not None:
            finite("the coefficient of expansion", cast(float, self.expansion))
        if self.axes is not None and not callable(self.axes):
            found = array_of(self.axes)
            if found is None or found.shape != (3, 3):
                raise InputError(
                    f"The axes of a material are an array (3, 3), a row each, or a function of points; found "
                    f"{shown(self.axes)}.",
                    code="wrong-shape",
                )
            object.__setattr__(self, "axes", tuple(map(tuple, _checked(found[None])[0].tolist())))


def _checked(axes: Array) -> Array:
    """Axes (n, 3, 3) of unit length.

    Raises
    ------
    InputError
        If they are not at right angles, or left-handed.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = axes / np.linalg.norm(axes, axis=2, keepdims=True)
    wrong = ~(np.abs(unit @ np.swapaxes(unit, 1, 2) - np.eye(3)).max(axis=(1, 2)) <= ROUNDING)
    wrong |= np.linalg.det(np.nan_to_num(unit)) < 0
    if wrong.any():
        raise InputError(
            f"The axes of a material must be at right angles and right-handed; found {shown(axes[np.argmax(wrong)])}.",
            code="axes",
        )
    return np.asarray(unit)


def turned(C: Array, axes: Array) -> Array:
    """C (6, 6) in axes, rows (n, 3, 3), as (n, 6, 6) in those that the rows are given in.

    Examples
    --------
    A quarter turn about z changes x and y:

    >>> C = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    >>> turned(C, np.array([[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]))[0].diagonal().tolist()
    [2.0, 1.0, 3.0, 4.0, 6.0, 5.0]
    """
    p, q = axes[:, FIRST], axes[:, SECOND]
    both = p[..., FIRST] * q[..., SECOND] + p[..., SECOND] * q[..., FIRST]
    # doubled shears of both: those found count twice, and those given half of what is found of a single one
    double = np.where(FIRST != SECOND, 2.0, 1.0)
    T = both / 2 * double[:, None]
    return np.asarray(np.swapaxes(T, 1, 2) @ C @ T)


@spelled
@dataclass(frozen=True)
class OrthotropicMaterial(DirectedMaterial):
    """Linear elastic material with three planes of symmetry: wood, laminae of fibres, cortical bone.

    For `ElasticBody`, `PlaneBody` and `AxisymmetricBody`. What needs an isotropic material (half-spaces, local bodies,
    laws of finite strain) refuses it. Estimates of errors use the stiffness as it is; scales, as the modulus by which
    contacts are searched, use `average`.

    Parameters
    ----------
    E : (3,) floats
        Young's moduli E1, E2, E3 along its axes (force / length^2), positive.
    nu : (3,) floats
        Poisson's ratios nu12, nu13, nu23: nu12 is the contraction along 2 over the elongation along 1 under a stress
        along 1.
    G : (3,) floats
        Shear moduli G12, G13, G23, positive.
    axes : (3, 3) array_like, or function, optional
        Its axes 1, 2, 3 as rows, in the axes of the body's mesh; or a function of points (n, 3) that gives (n, 3, 3),
        such as `CylindricalAxes`. Those of the body by default.
    density : float, optional
        As in `Material`.
    expansion : float or (3,) floats, optional
        As in `Material`; or a coefficient along each of its axes.

    Raises
    ------
    InputError
        If a modulus is not positive, the stiffness is not positive definite, or the axes are no rotation.

    Examples
    --------
    >>> spruce = OrthotropicMaterial(E=(10.0, 0.8, 0.4), nu=(0.37, 0.42, 0.47), G=(0.6, 0.6, 0.04))
    >>> compliance = np.linalg.inv(spruce.stiffness)
    >>> float(round(1 / compliance[0, 0], 12)), float(round(-compliance[0, 1] * 10.0, 12))
    (10.0, 0.37)
    """

    E: tuple[float, float, float]
    nu: tuple[float, float, float]
    G: tuple[float, float, float]
    axes: Any = None
    density: float | None = None
    expansion: float | tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "E", positives("Young's moduli E1, E2, E3", self.E, 3))
        object.__setattr__(self, "G", positives("the shear moduli G12, G13, G23", self.G, 3))
        object.__setattr__(self, "nu", tuple(vector("Poisson's ratios nu12, nu13, nu23", self.nu).tolist()))
        check_magnitude("the moduli", (*self.E, *self.G))
        self._check(self._compliance)

    @property
    def _compliance(self) -> Array:
        (e1, e2, _), (nu12, nu13, nu23), (g12, g13, g23) = self.E, self.nu, self.G
        S = np.diag([*(1 / e for e in self.E), 1 / g12, 1 / g23, 1 / g13])
        for i, j, value in ((0, 1, -nu12 / e1), (0, 2, -nu13 / e1), (1, 2, -nu23 / e2)):
            S[i, j] = S[j, i] = value
        return S

    @property
    def stiffness(self) -> Array:
        """C (6, 6) in its axes, components xx, yy, zz, xy, yz, xz, shears doubled in the strain."""
        return np.asarray(np.linalg.inv(self._compliance))


@spelled
@dataclass(frozen=True)
class AnisotropicMaterial(DirectedMaterial):
    """Linear elastic material of any stiffness, see `OrthotropicMaterial`.

    Parameters
    ----------
    moduli : (6, 6) array_like
        C in stress = C strain, symmetric and positive definite; components xx, yy, zz, xy, yz, xz, shears doubled in
        the strain (force / length^2).
    axes, density, expansion : optional
        As in `OrthotropicMaterial`.

    Raises
    ------
    InputError
        If the moduli are not symmetric or not positive definite, or the axes are no rotation.

    Examples
    --------
    >>> crystal = AnisotropicMaterial(np.diag([3.0, 3.0, 3.0, 1.0, 1.0, 1.0]))
    >>> round(crystal.average.E, 12), round(crystal.average.nu, 12)
    (2.571428571429, 0.071428571429)
    """

    moduli: Any
    axes: Any = None
    density: float | None = None
    expansion: float | tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        C = array_of(self.moduli)
        if C is None or C.shape != (6, 6) or not np.abs(C - C.T).max() <= ROUNDING * np.abs(C).max():
            raise InputError(
                f"The moduli of a material are a symmetric array (6, 6); found {shown(self.moduli)}.", code="moduli"
            )
        check_magnitude("the moduli", C)
        object.__setattr__(self, "moduli", tuple(map(tuple, C.tolist())))
        self._check((C + C.T) / 2)

    def exchanged(self) -> Self:
        """The same material where y and z are exchanged; moduli of yz and xz beside others are odd."""
        odd = np.array([1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
        return replace(super().exchanged(), moduli=np.array(self.moduli) * odd * odd[:, None])

    @property
    def stiffness(self) -> Array:
        """The moduli."""
        C = np.array(self.moduli)
        return np.asarray((C + C.T) / 2)
