"""Linear visco-elastic material: an elastic one at once, whose moduli fall by a Prony series, and its creep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.optimize
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array
from fecontact.common.checks import array_of
from fecontact.common.errors import InputError, shown
from fecontact.common.material import Material

#: Accuracy of times of creep, relative, a few roundings, and absolute; and steps to find them between times far apart.
ROOT, SMALLEST, MAX_STEPS = 1e-15, 1e-300, 1000


@dataclass(frozen=True)
class Viscoelastic:
    """Linear visco-elastic material, whose shear modulus falls with time, at a constant Poisson's ratio.

    G(t) = G [1 - sum g (1 - exp(-t/tau))]. As nu is constant, Young's and the bulk modulus fall in proportion.

    Parameters
    ----------
    material : Material
        As it responds at once, at t = 0. For bricks of gradient coordinates also a law with E, such as
        ``fc.NeoHookean(E=, nu=)``.
    prony : sequence of (float, float)
        Pairs (g, tau): share of the shear modulus at t = 0 that relaxes, and its time. The shares add up to less than
        1.

    Raises
    ------
    InputError
        If the material has no E, shares or times are not positive, or nothing would remain.

    References
    ----------
    R. M. Christensen, Theory of Viscoelasticity, 2nd ed., 1982, chapter 1.

    Examples
    --------
    >>> rubber = Viscoelastic(Material(E=10.0, nu=0.49), prony=[(0.5, 1.0), (0.3, 100.0)])
    >>> round(rubber.relaxed.E, 12), rubber.remaining(0.0), round(rubber.remaining(10.0), 3)
    (2.0, 1.0, 0.471)
    """

    material: Material
    prony: Sequence[tuple[float, float]]

    def __post_init__(self) -> None:
        if not hasattr(self.material, "E") or isinstance(self.material, Viscoelastic):
            raise InputError(
                "A visco-elastic material is given by its moduli at t = 0, as Material(E=, nu=); "
                f"found {shown(self.material)}.",
                code="wrong-class",
            )
        pairs = prony_pairs(self.prony)
        if not (len(pairs) and np.isfinite(pairs).all() and (pairs > 0).all()):
            raise InputError(
                f"Shares and times of a Prony series must be positive and finite; found {self.prony!r}.",
                code="prony-series",
            )
        if (total := float(pairs[:, 0].sum())) >= 1:
            raise InputError(
                f"The shares of a Prony series are of the modulus at t = 0 and must add up to less than 1; found "
                f"{total:g}, which leaves nothing. If yours are over the modulus after a long time, divide each by 1 "
                "plus their sum and multiply E by it.",
                code="prony-sum",
            )
        object.__setattr__(self, "prony", tuple((float(g), float(tau)) for g, tau in pairs))

    @property
    def relaxed(self) -> Any:
        """The material after a long time."""
        return replace(self.material, E=self.material.E * (1 - sum(g for g, _ in self.prony)))

    def remaining(self, t: ArrayLike) -> Any:
        """Share of the moduli that remains at the time t, or at times (n,)."""
        g, tau = np.array(self.prony).T
        found = 1 + np.expm1(-np.asarray(t, dtype=float)[..., None] / tau) @ g
        return found if np.ndim(t) else float(found)

    @cached_property
    def creep(self) -> tuple[Array, Array]:
        """Shares s (n,) and times theta (n,): displacements by a constant force are 1 + sum s (1 - exp(-t/theta)).

        They are over those at once. In Laplace's variable p the moduli are those at once times f(p) = 1 - sum g / (1 +
        p tau). The times are at its zeros p = -1/theta, one between any two times tau and one above the largest, and
        the shares are theta/f'(p) there.
        """
        taus = np.unique([tau for _, tau in self.prony])
        g = np.array([sum(share for share, tau in self.prony if tau == each) for each in taus])

        def f(theta: float) -> float:
            return float(1 - (g * theta / (theta - taus)).sum())

        ends = zip(np.nextafter(taus, np.inf), [*np.nextafter(taus[1:], 0), 2 * taus[-1] / (1 - g.sum())], strict=True)
        thetas = np.array(
            [scipy.optimize.brentq(f, *pair, xtol=SMALLEST, rtol=ROOT, maxiter=MAX_STEPS) for pair in ends]
        )
        slopes = (g * taus / (1 - taus / thetas[:, None]) ** 2).sum(axis=1)
        return thetas / slopes, thetas


def prony_pairs(given: ArrayLike) -> Array:
    """Shares and times (n, 2) of a Prony series.

    Raises
    ------
    InputError
        If it is no list of pairs.
    """
    found = array_of(given)
    if found is None or not (found.size == 0 or (found.ndim == 2 and found.shape[1] == 2)):
        raise InputError(f"A Prony series is a list of (share, time); found {given!r}.", code="prony-series")
    return found.reshape(-1, 2)


def beside(given: Any) -> tuple[Any, Array]:
    """Materials, one or a mapping, after a long time, and their series (n, 2), its shares beside and over those moduli.

    Raises
    ------
    InputError
        If there are several materials of which not all relax alike.

    Examples
    --------
    >>> beside(Viscoelastic(Material(E=2.0, nu=0.3), prony=[(0.5, 1.0)]))
    (Material(E=1.0, nu=0.3, density=None, expansion=None), array([[1., 1.]]))
    """
    sets = given if isinstance(given, Mapping) else {"": given}
    series = {m.prony if isinstance(m, Viscoelastic) else () for m in sets.values()}
    if series == {()}:
        return given, np.zeros((0, 2))
    if len(series) > 1:
        raise InputError(
            "The materials of a body relax by one Prony series: give the same to all element sets, or make bodies of "
            "their own.",
            code="prony-series",
        )
    pairs = np.array(series.pop())
    pairs[:, 0] /= 1 - pairs[:, 0].sum()
    relaxed = {name: m.relaxed for name, m in sets.items()}
    return relaxed if isinstance(given, Mapping) else relaxed[""], pairs
