"""Fibres in a hyperelastic ground law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import number, point_array, positive
from fecontact.common.errors import InputError, shown
from fecontact.common.material import FIRST, SECOND, Material
from fecontact.fem.laws import Law, Response, exponential

#: Squared stretch, less one, from which a fibre counts as taut: at rest it does, however its direction is rounded.
TAUT = -1e-12
#: Component out of the plane of a section, of a unit vector in it.
OUT_OF_PLANE = 1e-9


@dataclass(frozen=True, eq=False)
class Fibres(Law):
    """A family of fibres in a ground law: ksi / (alpha beta) (exp(alpha (I4 - 1)^beta) - 1) is added where I4 > 1.

    For ligaments and menisci. I4 = |F a|^2 is the squared stretch along the fibres a, the whole one also in a ground
    law that is nearly incompressible (Nolan et al., J. Mech. Behav. Biomed. Mater. 39 (2014) 48). Shortened fibres
    carry nothing. Source: Holzapfel, Gasser & Ogden, J. Elasticity 61 (2000) 1 with k1 = ksi, k2 = alpha, beta = 2; the
    general power is FEBio's "fiber-exp-pow". The linear material at small strains is that of the ground law. Several
    families: the ground law is one with fibres.

    Parameters
    ----------
    law : Law
        The ground law.
    direction : (3,) array or callable
        Of the fibres in the initial shape, in the body's axes, of any length; or a function of points (n, 3) that
        returns (n, 3). In a section along y, the circumference, or in its plane.
    ksi : float
        Modulus (force / length^2), positive.
    alpha : float
        Exponential stiffening, positive or zero: a power law.
    beta : float
        Power, at least 2.

    Examples
    --------
    >>> import fecontact as fc
    >>> ligament = fc.Fibres(fc.NeoHookean(E=1.0, nu=0.3), (0, 0, 1), ksi=5.0, alpha=2.0)
    >>> stress = [law.cauchy(np.diag([1.0, 1.0, 1.1])).diagonal() for law in (ligament, ligament.law)]
    >>> (stress[0] - stress[1]).round(4).tolist()
    [0.0, 0.0, 2.523]
    """

    law: Law
    direction: ArrayLike | Callable[[Array], Array]
    _: KW_ONLY
    ksi: float
    alpha: float
    beta: float = 2.0

    def __post_init__(self) -> None:
        instance("the ground law of fibres", self.law, Law)
        positive("the modulus ksi", self.ksi)
        for name, least in (("alpha", 0.0), ("beta", 2.0)):
            if not least <= number(getattr(self, name)) < np.inf:
                raise InputError(
                    f"{name} of fibres must be {least:g} or more; found {shown(getattr(self, name))}.", code="exponents"
                )
        if not callable(self.direction):
            given = point_array("directions of fibres", self.direction, 3)
            size = np.linalg.norm(given, axis=-1, keepdims=True)
            if not size.all():
                raise InputError("A direction of fibres is zero.", code="axis-zero")
            object.__setattr__(self, "direction", given / size)

    @property
    def density(self) -> float | None:  # type: ignore[override]
        """That of the ground law."""
        return self.law.density

    @property
    def bulk(self) -> float:  # type: ignore[override]
        """That of the ground law."""
        return self.law.bulk

    @property
    def caution(self) -> str:  # type: ignore[override]
        """That of the ground law."""
        return self.law.caution

    @property
    def at_rest(self) -> Material:
        """That of the ground law."""
        return self.law.at_rest

    def at(self, places: Array, in_section: bool = False) -> Fibres:
        """The law with its directions at points (..., 3) of the initial shape.

        Raises
        ------
        InputError
            For directions that are not one, or one for each point, or that leave a section and its normal.
        """
        points = places.reshape(-1, 3)
        along = self.direction(points) if callable(self.direction) else self.direction
        found = replace(self, law=self.law.at(places, in_section), direction=along)
        d = np.asarray(found.direction)
        if d.shape != (3,) and not (callable(self.direction) and d.shape == points.shape):
            raise InputError(
                f"Directions of fibres are one vector, or a function that has one for each of n points (n, 3); found "
                f"shape {d.shape}. For one of each cell take that of the nearest centre in a function.",
                code="wrong-shape",
            )
        if in_section and (np.abs(np.abs(d[..., 1]) - 0.5) < 0.5 - OUT_OF_PLANE).any():
            raise InputError(
                "Fibres of a section lie in its plane or along y, its normal or circumference; found others, which "
                "would shear it out of its plane. Give a body in space.",
                code="finite-strain-section",
            )
        return found if d.shape == (3,) else replace(found, direction=d.reshape(places.shape))

    def distortion(self, F: Array, J: Array) -> Response:
        """Response of W_c of the ground law with the fibres."""
        if callable(self.direction):
            raise InputError("The direction of the fibres depends on the place: law.at(points).", code="no-place")
        ground = self.law.distortion(F, J)
        a = (F @ np.asarray(self.direction)[..., None])[..., 0]
        longer = (a * a).sum(axis=-1) - 1
        s, alpha, beta = np.maximum(longer, 0.0), self.alpha, self.beta
        Q = alpha * s**beta
        grown = self.ksi * exponential(Q)
        energy = self.ksi / beta * (np.expm1(Q) / alpha if alpha else s**beta)
        rate = grown * s ** (beta - 1)
        bend = grown * ((beta - 1) * s ** (beta - 2) + alpha * beta * s ** (2 * beta - 2)) * (longer > TAUT)
        dyad = a[..., FIRST] * a[..., SECOND]
        own = (4 * bend)[..., None, None] * (dyad[..., :, None] * dyad[..., None, :])
        return replace(
            ground,
            energy=ground.energy + energy,
            stress=ground.stress + (2 * rate)[..., None, None] * (a[..., :, None] * a[..., None, :]),
            moduli=own if ground.moduli is None else ground.moduli + own,
        )
