"""Hyperelastic laws of finite strain: energy, Kirchhoff stress and spatial moduli at many points.

A law carries its constants and tends to Hooke's law for small strains, whose moduli `Law.at_rest` tells. Its energy per
initial volume is W = W_c(F) + kappa/2 (ln J)^2, J = det F; the second part may be integrated at other points against
locking. Laws of the invariants I1 = tr b, I2 = (I1^2 - tr b^2) / 2 and y = ln J, with b = F F^T, need derivatives of
W_c only. With A_1 = b, A_2 = I1 b - b^2, A_y = 1/2, the derivatives of the invariants by C = F^T F carried to the
present shape (Holzapfel, Nonlinear Solid Mechanics, 2000, sections 6.2 and 6.6),

    tau = 2 sum_p W_p A_p,    c = 4 sum_pq W_pq A_p (x) A_q + 4 W_2 (b (x) b - b [x] b) - 2 W_y I_sym
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, number, positive
from fecontact.common.errors import FecontactError, InputError, shown
from fecontact.common.material import FIRST, SECOND, Material
from fecontact.fem.element_stiffness import determinant_3x3, inverse_3x3

#: Unit tensor and symmetric unit tensor of fourth order, as (6,) and (6, 6).
UNIT = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
SYMMETRIC_UNIT = np.diag([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])
#: Relative difference of two principal stretches below which the limit of their quotient is taken: the limit is off by
#: its square, and the quotient by rounding over it.
EQUAL = 1e-5
#: Largest exponent: its exponential, and that squared, are within the range of floating point.
MAX_EXPONENT = 300.0


class InvertedError(FecontactError):
    """The deformation inverts material (det F <= 0); take a smaller step."""

    code = "inverted-material"


@dataclass(frozen=True, eq=False)
class Response:
    """Energy, stress and moduli at points.

    Attributes
    ----------
    energy : (...) array
        Per initial volume.
    stress : (..., 3, 3) array
        Kirchhoff stress tau = J sigma.
    lame, shear : (...) arrays
        Of the part lame 1 (x) 1 + 2 shear I_sym of the spatial moduli c: the Lie derivative of tau is c : d.
    moduli : (..., 6, 6) array or None
        What c has beside that part, by components in the order of `VOIGT`; None where it has nothing.
    metric : (..., 3, 3) array or None
        What that part has in place of the unit tensor, in the initial shape (see `Law.pulled`).
    """

    energy: Array
    stress: Array
    lame: Array
    shear: Array
    moduli: Array | None = None
    metric: Array | None = None

    @property
    def all_moduli(self) -> Array:
        """C (..., 6, 6), whole."""
        c = isotropic(self.lame, self.shear)
        return c if self.moduli is None else c + self.moduli


def isotropic(lame: Array, shear: Array) -> Array:
    """Moduli lame 1 (x) 1 + 2 shear I_sym (..., 6, 6)."""
    return lame[..., None, None] * np.outer(UNIT, UNIT) + 2 * shear[..., None, None] * SYMMETRIC_UNIT


@dataclass(frozen=True, eq=False)
class Dilatation:
    """A measure v of the change of volume, with a modulus times v^2 / 2 in the energy.

    Attributes
    ----------
    value : (...) array
        v.
    rate : (..., 3, 3) array
        X = dv/dE.
    bend : float
        k of its second derivative -k (X_IK X_JL + X_IL X_JK).
    """

    value: Array
    rate: Array
    bend: float


class Law:
    """A hyperelastic law with its constants, in any consistent units.

    Attributes
    ----------
    density : float, optional
        Mass per initial volume; needed only for gravity and dynamics.
    bulk : float
        Kappa of the part kappa/2 (ln J)^2 of the energy that may be integrated apart; 0 where there is none.
    caution : str
        What a result should warn of, with these constants; empty where there is nothing.
    n_memory : int
        Numbers that it remembers at a point, see `fem.plastic`.
    isotropic : bool
        Whether its moduli at rest are those of `at_rest`.
    """

    density: float | None
    bulk: float
    caution: str = ""
    n_memory: int = 0
    isotropic: bool = True

    @property
    @abstractmethod
    def at_rest(self) -> Material:
        """The linear material that it is at small strains."""

    @abstractmethod
    def distortion(self, F: Array, J: Array) -> Response:
        """Response of W_c to deformation gradients F (..., 3, 3) with determinants J (...)."""

    @property
    def volumetric(self) -> float:
        """Modulus of the part of the energy that depends on the dilatation of `dilated`."""
        return self.bulk

    def dilated(self, F: Array) -> Dilatation:
        """The dilatation v = ln J under deformation gradients F (..., 3, 3), with v^2 volumetric / 2 in the energy."""
        return Dilatation(np.log(determinants(F)), inverse_3x3(np.swapaxes(F, -1, -2) @ F)[0], 1.0)

    def pulled(self, F: Array, volume: float = 1.0, rest: float = 1.0) -> Response:
        """Response in the initial shape: second Piola-Kirchhoff stress S and the moduli dS/dE.

        With H = F^-1: S = H tau H^T and D_IJKL = H_Ii H_Jj H_Kk H_Ll c_ijkl (Holzapfel 2000, sections 3.4 and 6.6), so
        that the unit tensor of c becomes the metric X = C^-1 of lame X_IJ X_KL + shear (X_IK X_JL + X_IL X_JK).

        Parameters
        ----------
        F : (..., 3, 3) array
            Deformation gradients.
        volume, rest : {0, 1}
            Whether with the volumetric part and with the rest.

        Raises
        ------
        InvertedError
            If det F <= 0 somewhere.
        """
        if volume and rest:
            found = self.response(F)
        else:
            J = determinants(F)
            found = self.distortion(F, J) if rest else dilatation(np.asarray(self.bulk), J)
        H, moduli = inverse_3x3(F)[0], found.moduli
        other = np.swapaxes(H, -1, -2)
        if moduli is not None:
            T = carried(H)
            moduli = T @ moduli @ np.swapaxes(T, -1, -2)
        return replace(found, stress=H @ found.stress @ other, moduli=moduli, metric=H @ other)

    def at(self, places: Array, in_section: bool = False) -> Law:
        """The law at points (..., 3) of the initial shape, or of a section y = 0: another one if it has directions."""
        return self

    def remembering(self, memory: Array) -> Law:
        """The law after a memory (..., n_memory) of its points."""
        return self

    def response(self, F: Array) -> Response:
        """Response of the whole law to deformation gradients F (..., 3, 3).

        Raises
        ------
        InvertedError
            If det F <= 0 somewhere.
        """
        J = determinants(F)
        part, volume = self.distortion(F, J), dilatation(np.asarray(self.bulk), J)
        return Response(
            part.energy + volume.energy,
            part.stress + volume.stress,
            part.lame + volume.lame,
            part.shear + volume.shear,
            part.moduli,
        )

    def cauchy(self, F: Array) -> Array:
        """Cauchy stress (..., 3, 3) under deformation gradients F (..., 3, 3).

        Raises
        ------
        InvertedError
            If det F <= 0 somewhere.

        Examples
        --------
        >>> rubber = NeoHookean(E=1.0, nu=0.45)
        >>> float(abs(rubber.cauchy(np.eye(3))).max())
        0.0
        """
        return np.asarray(self.response(F).stress / determinant_3x3(F)[..., None, None])


def laws_of(given: object) -> tuple[Law, ...]:
    """Laws among what a body is given: one, or those of a mapping of element sets; () where there are none.

    Raises
    ------
    InputError
        If only some sets have a law: the others' strains are as large.
    """
    found = list(given.values()) if isinstance(given, Mapping) else [given]
    laws = tuple(each for each in found if isinstance(each, Law))
    if laws and len(laws) < len(found):
        raise InputError(
            "A body has a law of finite strain in all its element sets or in none: give NeoHookean(E=, nu=) for a "
            "Material.",
            code="some-laws",
        )
    return laws


def at_rest(given: Any) -> Any:
    """The linear materials, of small strains, in place of laws."""
    if isinstance(given, Law):
        return given.at_rest
    if isinstance(given, Mapping):
        return {name: at_rest(each) for name, each in given.items()}
    return given


def law_of(given: Any, kind: Callable[..., Law]) -> Any:
    """Laws of a kind in place of linear materials.

    Raises
    ------
    InputError
        If the kind is not a class of laws.
    """
    of_laws = isinstance(kind, type) and issubclass(kind, Law)
    if not of_laws:
        raise InputError(
            f"A law takes the place of the material, as fecontact.NeoHookean(E=, nu=); found {kind!r}.",
            code="wrong-class",
        )
    if isinstance(given, Mapping):
        return {name: law_of(each, kind) for name, each in given.items()}
    return kind(given.E, given.nu, given.density) if isinstance(given, Material) else given


def without_law(kind: str, given: Any) -> Any:
    """What a kind of body is given, refused if it is a law.

    Raises
    ------
    InputError
    """
    if laws_of(given):
        raise InputError(
            f"A law of finite strain is for an ElasticBody; {kind} takes a Material.", code="finite-strain"
        )
    return given


def determinants(F: Array) -> Array:
    """Determinants (...) of deformation gradients (..., 3, 3).

    Raises
    ------
    InvertedError
        If one is not positive.
    """
    J = determinant_3x3(F)
    if not (J > 0).all():
        raise InvertedError(
            f"The deformation turns the material inside out at {int((~(J > 0)).sum())} points (smallest det F "
            f"{np.min(J):.3g}). Apply the load in smaller steps."
        )
    return J


def exponential(Q: Array) -> Array:
    """Exp Q of exponential laws.

    Raises
    ------
    InvertedError
        If it is beyond all numbers.
    """
    if not (Q < MAX_EXPONENT).all():
        raise InvertedError(
            f"An exponential law grows beyond all numbers at {int((~(Q < MAX_EXPONENT)).sum())} points. Apply the load "
            "in smaller steps.",
            code="overflow",
        )
    return np.exp(Q)


def dilatation(kappa: Array, J: Array) -> Response:
    """Response of kappa/2 (ln J)^2, by kappa that broadcasts over J (...)."""
    y = np.log(J)
    pressure = kappa * y
    stress = pressure[..., None, None] * np.eye(3)
    return Response(pressure * y / 2, stress, kappa + np.zeros_like(y), -pressure)


class InvariantLaw(Law):
    """A law of the invariants I1, I2 and y = ln J, by derivatives of its W_c: base of own laws, too.

    A subclass defines `at_rest`, `density` and `derivatives`, and `bulk` if a part of the energy is kappa/2 (ln J)^2.
    """

    @abstractmethod
    def derivatives(self, I1: Array, I2: Array, y: Array) -> tuple[Array, Sequence[Array], Sequence[Sequence[Array]]]:
        """Energy W_c, its three derivatives, and rows (3, 3) of the second ones, () where these and W_2 vanish."""

    def distortion(self, F: Array, J: Array) -> Response:
        """Response of W_c."""
        b = F @ np.swapaxes(F, -1, -2)
        I1, y = np.trace(b, axis1=-2, axis2=-1), np.log(J)
        square = b @ b
        I2 = (I1**2 - np.trace(square, axis1=-2, axis2=-1)) / 2
        energy, (W1, W2, Wy), second = self.derivatives(I1, I2, y)
        W1, W2, Wy = (np.broadcast_to(w, y.shape) for w in (W1, W2, Wy))
        tensor = I1[..., None, None] * b - square
        stress = 2 * W1[..., None, None] * b + Wy[..., None, None] * np.eye(3)
        zero = np.zeros_like(y)
        if not len(second):
            return Response(energy, stress, zero, -Wy)
        stress += 2 * W2[..., None, None] * tensor
        A = np.stack([b[..., FIRST, SECOND], tensor[..., FIRST, SECOND], np.broadcast_to(UNIT / 2, (*y.shape, 6))], -2)
        H = np.stack([np.stack([np.broadcast_to(w, y.shape) for w in row], -1) for row in second], -2)
        c = np.swapaxes(A, -1, -2) @ (4 * H) @ A
        first = A[..., 0, :]
        c += 4 * W2[..., None, None] * (first[..., :, None] * first[..., None, :] - crossed(b))
        return Response(energy, stress, zero, -Wy, c)


def carried(H: Array) -> Array:
    """T (..., 6, 6) with T C T^T = H_Ii H_Jj H_Kk H_Ll C_ijkl for moduli C by components."""
    T = H[..., FIRST[:, None], FIRST] * H[..., SECOND[:, None], SECOND]
    T += (FIRST != SECOND) * H[..., FIRST[:, None], SECOND] * H[..., SECOND[:, None], FIRST]
    return np.asarray(T)


def crossed(b: Array) -> Array:
    """B [x] b (..., 6, 6): (b_ik b_jl + b_il b_jk) / 2, of a symmetric b (..., 3, 3)."""
    straight = b[..., FIRST[:, None], FIRST] * b[..., SECOND[:, None], SECOND]
    return np.asarray(straight + b[..., FIRST[:, None], SECOND] * b[..., SECOND[:, None], FIRST]) / 2


class _Checked(Law):
    """A law that refuses bad constants when it is made."""

    def __post_init__(self) -> None:
        self.at_rest  # noqa: B018 - refuses bad input


@dataclass(frozen=True)
class _ByModuli(_Checked):
    """A law with Young's modulus and Poisson's ratio of small strains."""

    E: float
    nu: float
    density: float | None = None

    @cached_property
    def at_rest(self) -> Material:
        """The linear material that it is at small strains."""
        return Material(self.E, self.nu, self.density)

    @cached_property
    def _lame(self) -> tuple[float, float]:
        return self.at_rest.lame, self.at_rest.shear_modulus


class NeoHookean(_ByModuli):
    """Compressible: W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2.

    For rubber and soft tissue. Source: Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2008),
    section 6.4.3, equations 6.27-6.31.

    Parameters
    ----------
    E, nu : float
        Young's modulus and Poisson's ratio at small strains.
    density : float, optional

    Examples
    --------
    >>> rubber = NeoHookean(E=1.0, nu=0.45)
    >>> rubber.cauchy(np.diag([0.5, 1.0, 1.0])).diagonal().round(4).tolist()
    [-4.8195, -4.3023, -4.3023]
    """

    @property
    def bulk(self) -> float:  # type: ignore[override]
        """The first Lame constant."""
        return self._lame[0]

    def distortion(self, F: Array, J: Array) -> Response:
        """Response of W_c."""
        mu, b = self._lame[1], F @ np.swapaxes(F, -1, -2)
        energy = mu / 2 * (np.trace(b, axis1=-2, axis2=-1) - 3) - mu * np.log(J)
        return Response(energy, mu * (b - np.eye(3)), np.zeros_like(J), mu + np.zeros_like(J))

    def pulled(self, F: Array, volume: float = 1.0, rest: float = 1.0) -> Response:
        """Response in the initial shape: S = mu (1 - X) + lambda ln J X with X = C^-1 (Bonet & Wood, equation 6.28)."""
        lame, mu, log = volume * self._lame[0], rest * self._lame[1], np.log(determinants(F))
        C = np.swapaxes(F, -1, -2) @ F
        X, pressure = inverse_3x3(C)[0], lame * log
        energy = mu * ((np.trace(C, axis1=-2, axis2=-1) - 3) / 2 - log) + pressure * log / 2
        stress = mu * np.eye(3) + (pressure - mu)[..., None, None] * X
        return Response(energy, stress, np.asarray(lame), mu - pressure, None, X)


class StVenantKirchhoff(_ByModuli):
    """W = lambda/2 (tr E)^2 + mu E : E of the Green-Lagrange strain E = (F^T F - 1)/2.

    Suitable for large rotations with small strains; it softens under strong compression. Source: Bonet & Wood (2008),
    section 6.4.1.

    Parameters
    ----------
    E, nu : float
        Young's modulus and Poisson's ratio at small strains.
    density : float, optional

    Examples
    --------
    >>> law = StVenantKirchhoff(E=2.5, nu=0.25)
    >>> law.cauchy(np.diag([1.1, 1.0, 1.0])).diagonal().round(6).tolist()
    [0.3465, 0.095455, 0.095455]
    """

    bulk = 0.0

    def distortion(self, F: Array, J: Array) -> Response:
        """Response of W: that of the initial shape, whose unit tensor becomes b = F F^T."""
        found, other = self.pulled(F), np.swapaxes(F, -1, -2)
        b, zero = F @ other, np.zeros_like(J)
        v = b[..., FIRST, SECOND]
        moduli = self._lame[0] * (v[..., :, None] * v[..., None, :]) + 2 * self._lame[1] * crossed(b)
        return Response(found.energy, F @ found.stress @ other, zero, zero, moduli)

    @property
    def volumetric(self) -> float:
        """The first Lame constant."""
        return self._lame[0]

    def dilated(self, F: Array) -> Dilatation:
        """The dilatation v = tr E."""
        trace = np.trace(np.swapaxes(F, -1, -2) @ F, axis1=-2, axis2=-1)
        return Dilatation((trace - 3) / 2, np.broadcast_to(np.eye(3), F.shape), 0.0)

    def pulled(self, F: Array, volume: float = 1.0, rest: float = 1.0) -> Response:
        """Response in the initial shape, its own measure; of any F."""
        lame, mu = volume * self._lame[0], rest * self._lame[1]
        E = (np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2
        trace = np.trace(E, axis1=-2, axis2=-1)
        energy = lame / 2 * trace**2 + mu * (E * E).sum(axis=(-1, -2))
        stress = (lame * trace)[..., None, None] * np.eye(3) + 2 * mu * E
        return Response(energy, stress, np.asarray(lame), np.asarray(mu), None, np.broadcast_to(np.eye(3), F.shape))


@dataclass(frozen=True)
class HolmesMow(_ByModuli, InvariantLaw):
    """Cartilage: W = c/2 (exp Q - 1), Q = beta/M ((2 mu - lambda)(I1 - 3) + lambda (I2 - 3) - 2 M ln J).

    With the confined modulus M = lambda + 2 mu and c = M / (2 beta). It stiffens under compression. Source: Holmes &
    Mow, J. Biomech. 23 (1990) 1145, as in the FEBio user's manual.

    Parameters
    ----------
    E, nu : float
        Young's modulus and Poisson's ratio at small strains. With nu above 1/3 the coefficient of I1 is negative: where
        the law is stretched at constant volume by nu / (3 nu - 1), no stress is left.
    beta : float
        Exponential stiffening, positive.
    density : float, optional

    Examples
    --------
    >>> cartilage = HolmesMow(E=1.0, nu=0.2, beta=0.3)
    >>> cartilage.cauchy(np.diag([0.8, 1.0, 1.0])).diagonal().round(5).tolist()
    [-0.25656, -0.06414, -0.06414]
    """

    _: KW_ONLY
    beta: float
    bulk = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("the exponential stiffening beta", self.beta)

    @property
    def caution(self) -> str:  # type: ignore[override]
        """A negative coefficient of I1."""
        if self.nu <= 1 / 3:
            return ""
        return (
            f"HolmesMow with nu = {self.nu:g} softens where it is stretched, at constant volume to nothing at a "
            f"stretch of nu / (3 nu - 1) = {self.nu / (3 * self.nu - 1):.3g}: take nu up to 1/3, or NeoHookean."
        )

    def derivatives(self, I1: Array, I2: Array, y: Array) -> tuple[Array, Sequence[Array], Sequence[Sequence[Array]]]:
        """Energy and derivatives of W."""
        lame, mu = self._lame
        M = lame + 2 * mu
        rates = np.array([self.beta * (2 * mu - lame) / M, self.beta * lame / M, -2 * self.beta])
        Q = rates[0] * (I1 - 3) + rates[1] * (I2 - 3) + rates[2] * y
        c = M / (4 * self.beta)
        grown = c * exponential(Q)
        return (
            c * np.expm1(Q),
            grown * rates.reshape(3, *(1,) * grown.ndim),
            [[grown * p * q for q in rates] for p in rates],
        )


class _Rubber(_Checked):
    """A law with a shear and a bulk modulus of small strains."""

    @property
    @abstractmethod
    def _shear(self) -> float:
        """The shear modulus at small strains."""

    @cached_property
    def at_rest(self) -> Material:
        """The linear material that it is at small strains."""
        G, K = self._shear, positive("the bulk modulus", self.bulk)
        return Material(9 * K * G / (3 * K + G), (3 * K - 2 * G) / (2 * (3 * K + G)), self.density)


@dataclass(frozen=True)
class MooneyRivlin(_Rubber, InvariantLaw):
    """Rubber: W = c10 (I1' - 3) + c01 (I2' - 3) + bulk/2 (ln J)^2 of I1' = J^(-2/3) I1 and I2' = J^(-4/3) I2.

    The shear modulus at small strains is 2 (c10 + c01). Source: Holzapfel, Nonlinear Solid Mechanics (2000), section
    6.5; with ln J as in FEBio.

    Parameters
    ----------
    c10, c01 : float
        Half moduli (force / length^2); their sum is positive.
    bulk : float
        Bulk modulus, positive.
    density : float, optional

    Examples
    --------
    >>> rubber = MooneyRivlin(c10=0.4, c01=0.1, bulk=50.0)
    >>> round(rubber.at_rest.E, 4), round(rubber.at_rest.nu, 4)
    (2.9801, 0.4901)
    """

    c10: float
    c01: float
    bulk: float
    density: float | None = None

    @property
    def _shear(self) -> float:
        return 2 * positive("the sum c10 + c01", number(self.c10) + number(self.c01))

    def derivatives(self, I1: Array, I2: Array, y: Array) -> tuple[Array, Sequence[Array], Sequence[Sequence[Array]]]:
        """Energy and derivatives of W_c."""
        W1, W2 = self.c10 * np.exp(-2 * y / 3), self.c01 * np.exp(-4 * y / 3)
        one, two, none = W1 * I1, W2 * I2, np.zeros_like(y)
        second = (
            (none, none, -2 / 3 * W1),
            (none, none, -4 / 3 * W2),
            (-2 / 3 * W1, -4 / 3 * W2, 4 / 9 * one + 16 / 9 * two),
        )
        return one + two - 3 * (self.c10 + self.c01), (W1, W2, -2 / 3 * one - 4 / 3 * two), second


class StretchLaw(Law):
    """A law of the principal stretches, by derivatives of its W_c by their logarithms.

    Moduli as in Holzapfel (2000), section 6.6, with their limits where stretches are equal.
    """

    @abstractmethod
    def principal(self, logs: Array) -> tuple[Array, Array, Array]:
        """Energy W_c of logarithms (..., 3), its first (..., 3) and second derivatives (..., 3, 3)."""

    def distortion(self, F: Array, J: Array) -> Response:
        """Response of W_c."""
        squares, axes = np.linalg.eigh(F @ np.swapaxes(F, -1, -2))
        energy, tau, second = self.principal(np.log(squares) / 2)
        stress = (axes * tau[..., None, :]) @ np.swapaxes(axes, -1, -2)
        i, j = np.array([0, 1, 0]), np.array([1, 2, 2])
        step = squares[..., i] - squares[..., j]
        near = np.abs(step) <= EQUAL * squares[..., i]
        own = np.diagonal(second, axis1=-2, axis2=-1)
        limit = (own[..., i] + own[..., j]) / 4 - second[..., i, j] / 2 - (tau[..., i] + tau[..., j]) / 2
        quotient = (tau[..., i] * squares[..., j] - tau[..., j] * squares[..., i]) / np.where(near, 1.0, step)
        shears = np.where(near, limit, quotient)
        n = np.moveaxis(axes, -1, 0)
        dyads = np.stack([_symmetric(n[a], n[b]) for a, b in ((0, 0), (1, 1), (2, 2), *zip(i, j, strict=True))], -2)
        D = np.zeros((*J.shape, 6, 6))
        D[..., :3, :3] = second - 2 * tau[..., None] * np.eye(3)
        D[..., [3, 4, 5], [3, 4, 5]] = 4 * shears
        zero = np.zeros_like(J)
        return Response(energy, stress, zero, zero, np.swapaxes(dyads, -1, -2) @ D @ dyads)


@dataclass(frozen=True)
class _Powers(_Checked, StretchLaw):
    """A law with a sum of powers of the stretches, of moduli mu_k and exponents alpha_k."""

    mu: Sequence[float]
    alpha: Sequence[float]

    def __post_init__(self) -> None:
        for name in ("mu", "alpha"):
            found = array_of(getattr(self, name))
            if found is None or found.ndim != 1 or not len(found) or not np.isfinite(found).all():
                raise InputError(
                    f"{name} of Ogden's law must be a sequence of numbers; found {shown(getattr(self, name))}.",
                    code="exponents",
                )
            object.__setattr__(self, name, tuple(found.tolist()))
        if len(self.mu) != len(self.alpha) or 0 in self.alpha:
            raise InputError(
                f"Ogden's law needs as many exponents alpha as moduli mu, none zero; found {self.alpha} and {self.mu}.",
                code="exponents",
            )
        super().__post_init__()

    @property
    def _shear(self) -> float:
        return positive("the sum of the moduli mu", sum(self.mu))

    def _powers(self, logs: Array) -> tuple[Array, Array, Array]:
        """Sum of 2 mu / alpha^2 (l^alpha - 1) over stretches of logarithms (..., 3), and its derivatives (..., 3)."""
        exponents, weights = np.array(self.alpha), 2 * np.array(self.mu)
        powers = np.exp(exponents[:, None] * logs[..., None, :])  # (..., k, 3)
        energy = (powers.sum(axis=-1) - 3) @ (weights / exponents**2)
        first, second = (np.einsum("...ki,k->...i", powers, w) for w in (weights / exponents, weights))
        return energy, first, second


@dataclass(frozen=True)
class Ogden(_Powers, _Rubber):
    """Rubber: W = sum_k 2 mu_k / alpha_k^2 (sum_i (J^(-1/3) l_i)^alpha_k - 3) + bulk/2 (ln J)^2 of stretches l_i.

    The shear modulus at small strains is the sum of mu_k. Source: Ogden, Proc. R. Soc. Lond. A 326 (1972) 565; moduli
    by principal stretches as in Holzapfel (2000), section 6.6.

    Parameters
    ----------
    mu : sequence of float
        Moduli (force / length^2); their sum is positive.
    alpha : sequence of float
        As many exponents, none zero.
    bulk : float
        Bulk modulus, positive.
    density : float, optional

    Examples
    --------
    >>> rubber = Ogden(mu=(0.4, 0.1), alpha=(2.0, -2.0), bulk=50.0)
    >>> round(rubber.at_rest.shear_modulus, 4)
    0.5
    """

    bulk: float
    density: float | None = None

    def principal(self, logs: Array) -> tuple[Array, Array, Array]:
        """Energy W_c and derivatives, by the deviator P = 1 - 1/3."""
        P = np.eye(3) - 1 / 3
        energy, first, second = self._powers(logs @ P)
        return energy, first @ P, P @ (second[..., None] * P)


@dataclass(frozen=True)
class CompressibleOgden(_Powers):
    """W = sum_k 2 mu_k / alpha_k^2 (sum_i l_i^alpha_k - 3 - alpha_k ln J) + lame/2 (J - 1)^2 of stretches l_i.

    For soft tissue and foam: FEBio's "Ogden unconstrained", with c_k = 2 mu_k and cp = lame. The Lame constants at
    small strains are `lame` and the sum of mu_k. Source: FEBio User Manual, section "Ogden Unconstrained".

    Parameters
    ----------
    mu : sequence of float
        Moduli (force / length^2); their sum is positive.
    alpha : sequence of float
        As many exponents, none zero.
    lame : float
        First Lame constant, above -2/3 of the sum of mu.
    density : float, optional

    Examples
    --------
    >>> foam = CompressibleOgden(mu=(0.5,), alpha=(2.0,), lame=0.5)
    >>> round(foam.at_rest.nu, 12), foam.cauchy(np.diag([0.5, 1.0, 1.0])).diagonal().round(4).tolist()
    (0.25, [-1.0, -0.25, -0.25])
    """

    lame: float
    density: float | None = None

    @cached_property
    def at_rest(self) -> Material:
        """The linear material that it is at small strains."""
        mu = self._shear
        both = positive("the sum of lame and the moduli mu", number(self.lame) + mu)
        return Material(mu * (3 * self.lame + 2 * mu) / both, self.lame / (2 * both), self.density)

    @property
    def bulk(self) -> float:  # type: ignore[override]
        """The Lame constant: (J - 1)^2 differs from (ln J)^2 by (J - 1)^3 only."""
        return max(self.lame, 0.0)

    def principal(self, logs: Array) -> tuple[Array, Array, Array]:
        """Energy W_c, all but bulk/2 (ln J)^2, and derivatives."""
        energy, first, second = self._powers(logs)
        y, J = logs.sum(axis=-1), np.exp(logs.sum(axis=-1))
        rate = 2 * sum(m / a for m, a in zip(self.mu, self.alpha, strict=True))
        pressure = self.lame * J * (J - 1) - self.bulk * y - rate
        bend = self.lame * J * (2 * J - 1) - self.bulk
        return (
            energy - rate * y + self.lame / 2 * (J - 1) ** 2 - self.bulk / 2 * y**2,
            first + pressure[..., None],
            second[..., None] * np.eye(3) + bend[..., None, None],
        )


def _symmetric(a: Array, b: Array) -> Array:
    """Components (..., 6) of the symmetric part of a (x) b, of vectors (..., 3)."""
    return (a[..., FIRST] * b[..., SECOND] + a[..., SECOND] * b[..., FIRST]) / 2
