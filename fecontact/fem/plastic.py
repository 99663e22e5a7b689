"""Plastic flow with linear hardening, in one dimension as in three: von Mises' condition, by an incremental energy.

With strains x (deviators in space, a fibre's strain in a bar), plastic strains p and their accumulated size a,

    stored  c/2 |x - p|^2 + k/2 |p|^2 + K/2 a^2,    yield  |c (x - p) - k p| <= r (Y + K a),    da = r |dp|,

where c is 2 mu and E, r is sqrt(2/3) and 1, and k is r^2 times the kinematic modulus H. A step from (p0, a0) is
implicit (radial return): p moves along n, the direction of the trial stress xi, by d = f / (c + k + r^2 K), where f is
what the trial state is beyond yield. That minimises stored + Y (a - a0), which is so an energy of the step: its
gradient is the stress c (x - p), its second derivative the consistent tangent c - c^2 [n n / (c + k + r^2 K) + d / |xi|
(1 - n n)] (M. L. Wilkins 1964; J. C. Simo & R. L. Taylor, Comput. Methods Appl. Mech. Engrg. 48, 1985; M. Ortiz & L.
Stainier, Comput. Methods Appl. Mech. Engrg. 171, 1999).
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import number, positive
from fecontact.common.errors import InputError, shown
from fecontact.common.material import Material
from fecontact.fem.laws import FIRST, SECOND, Response, StVenantKirchhoff

#: Accumulated plastic strain up to which the additive split is one of metals: in simple tension the yield stress of
#: the present shape is then off by twice that, a tenth.
MODERATE = 0.05


@dataclass(frozen=True)
class Plastic:
    """Elasto-plastic material: von Mises' yield condition with linear hardening.

    Parameters
    ----------
    material : Material
        Its elastic part.
    yield_stress : float
        In simple tension, positive.
    hardening : float
        Isotropic modulus K: slope of the yield stress over the plastic strain.
    kinematic : float
        Kinematic modulus H: by it the middle of the elastic range moves with the plastic strain. Under a growing load
        both act alike, and the tangent modulus is E (K + H) / (E + K + H).

    Raises
    ------
    InputError
        If the material is no `Material`, the yield stress is not positive, or a modulus is negative.

    Examples
    --------
    >>> steel = Plastic(Material(E=210e3, nu=0.3), yield_stress=250.0, hardening=2100.0)
    >>> step = steel.along.returned(np.array([[0.01]]), np.zeros((1, 2)))
    >>> step.stress.round(2).tolist(), step.memory.round(6).tolist()  # 250 + E_t (0.01 - 250/E)
    ([[268.32]], [[0.008722, 0.008722]])
    """

    material: Material
    yield_stress: float
    hardening: float = 0.0
    kinematic: float = 0.0

    def __post_init__(self) -> None:
        instance("the elastic part of a plastic material", self.material, Material)
        positive("the yield stress", self.yield_stress)
        for name in ("hardening", "kinematic"):
            if not 0 <= number(getattr(self, name)) < np.inf:
                raise InputError(
                    f"The {name} modulus must be zero or more, and finite; found {shown(getattr(self, name))}.",
                    code="hardening",
                )

    @cached_property
    def along(self) -> Flow:
        """Its flow in simple tension."""
        return Flow(self.material.E, 1.0, self)

    @cached_property
    def law(self) -> PlasticLaw:
        """Its law in space, of a virgin material."""
        return PlasticLaw(self.material.E, self.material.nu, self.material.density, self)


def flowing(given: Any) -> Any:
    """Laws in place of plastic materials, of one or a mapping."""
    if isinstance(given, Mapping):
        return {name: flowing(each) for name, each in given.items()}
    return given.law if isinstance(given, Plastic) else given


class Returned(NamedTuple):
    """A step of plastic flow at points.

    Attributes
    ----------
    energy : (...) array
        Stored at its end, and dissipated in it.
    stress : (..., m) array
    memory : (..., m + 1) array
        Plastic strain, then the accumulated one.
    normal : (..., m) array
        Direction of the trial stress.
    along, across : (...) arrays
        By how much the tangent is less than c along that direction, and across it, as shares.
    """

    energy: Array
    stress: Array
    memory: Array
    normal: Array
    along: Array
    across: Array


@dataclass(frozen=True)
class Flow:
    """Plastic flow of strains of m components, see the module.

    Parameters
    ----------
    modulus : float
        c.
    radius : float
        r.
    given : Plastic
    """

    modulus: float
    radius: float
    given: Plastic

    def returned(self, x: Array, memory: Array) -> Returned:
        """A step to strains x (..., m) from a memory (..., m + 1)."""
        c, r, given = self.modulus, self.radius, self.given
        k, K = r**2 * given.kinematic, given.hardening
        p, a = memory[..., :-1], memory[..., -1]
        xi = c * (x - p) - k * p
        size = np.linalg.norm(xi, axis=-1)
        beyond = np.maximum(size - r * (given.yield_stress + K * a), 0.0)
        d, size = beyond / (c + k + r**2 * K), np.maximum(size, np.finfo(float).tiny)
        normal, flows = xi / size[..., None], beyond > 0
        p, a, grown = p + d[..., None] * normal, a + r * d, r * d
        e = x - p
        stored = c / 2 * (e * e).sum(axis=-1) + k / 2 * (p * p).sum(axis=-1) + K / 2 * a**2
        return Returned(
            stored + given.yield_stress * grown, c * e, np.concatenate([p, a[..., None]], axis=-1), normal,
            flows * (c / (c + k + r**2 * K)), c * d / size,
        )  # fmt: skip


@dataclass(frozen=True)
class PlasticLaw(StVenantKirchhoff):
    """Hooke's law of E - P and von Mises' condition, of Green-Lagrange strains E and second Piola-Kirchhoff stresses.

    The additive split of A. E. Green & P. M. Naghdi (Arch. Rat. Mech. Anal. 18, 1965): for any rotation, small elastic
    and moderate plastic strains, see `MODERATE`. Its energy is that of a step from what it remembers.
    """

    given: Plastic | None = None

    n_memory = 10  # the plastic strain, and its accumulated size

    @cached_property
    def flow(self) -> Flow:
        """Its flow in space."""
        assert self.given is not None
        return Flow(2 * self._lame[1], np.sqrt(2 / 3), self.given)

    def remembering(self, memory: Array) -> PlasticLaw:
        """The law after a memory (..., 10) of its points."""
        other = copy.copy(self)
        other.__dict__["memory"] = memory
        return other

    @cached_property
    def memory(self) -> Array:
        """Of a virgin material, unless it is remembering."""
        return np.zeros(self.n_memory)

    def dissipated(self, volumes: Array) -> float:
        """Energy lost up to its memory in volumes (...) at its points."""
        assert self.given is not None
        return float(self.given.yield_stress * (self.memory[..., -1] * volumes).sum())

    @property
    def volumetric(self) -> float:
        """The bulk modulus: whatever flows keeps its volume, so that nothing else resists a change of it."""
        return self._lame[0] + 2 / 3 * self._lame[1]

    def returned(self, F: Array) -> Returned:
        """The flow of a step to deformation gradients F (..., 3, 3)."""
        C = np.swapaxes(F, -1, -2) @ F
        deviator = (C - np.trace(C, axis1=-2, axis2=-1)[..., None, None] / 3 * np.eye(3)) / 2
        return self.flow.returned(deviator.reshape(*F.shape[:-2], 9), self.memory)

    def pulled(self, F: Array, volume: float = 1.0, rest: float = 1.0) -> Response:
        """Response in the initial shape, its own measure; of any F."""
        v = self.dilated(F)
        bulk, unit = volume * self.volumetric, v.rate
        energy, stress = bulk * v.value**2 / 2, (bulk * v.value)[..., None, None] * unit
        if not rest:
            return Response(energy, stress, np.asarray(bulk), np.zeros(()), None, unit)
        step = self.returned(F)
        shear = self._lame[1] * (1 - step.across)
        n = step.normal.reshape(F.shape)[..., FIRST, SECOND]
        turned = 2 * self._lame[1] * (step.along - step.across)
        return Response(
            energy + step.energy, stress + step.stress.reshape(F.shape), bulk - 2 / 3 * shear, shear,
            -turned[..., None, None] * (n[..., :, None] * n[..., None, :]) if turned.any() else None, unit,
        )  # fmt: skip
