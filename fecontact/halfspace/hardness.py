"""Hardness of a half-space: pressures up to a largest one, at which the surface yields and keeps a dent.

With a dent d the contact is one more complementarity of the same kind:

    gap = A p + g + d + B^T q >= 0,   p >= 0,   p . gap = 0,   d >= 0,   p <= H,   d . (H - p) = 0

It is the minimum of the complementary energy over 0 <= p <= H, so its pressures are the only ones. The dent stays when
the load is taken off: the surface pressed again is g + d, and up to the same load the answer is elastic.

The material below a dent does not move: neither its volume, nor pile-up, nor the hardening of real metals is in it.
Bodies whose plastic zone is computed yield within, below the surface, where this law knows nothing, and spread the dent
(Frérot et al.); at light loads of rough surfaces areas by both agree, pressures less.

References
----------
A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih, Tribology Int. 40 (2007) 574; X. Tian, B. Bhushan, J. Tribol. 118
(1996) 33; L. Frérot, M. Bonnet, J.-F. Molinari, G. Anciaux, Comput. Methods Appl. Mech. Eng. 351 (2019) 951.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import number_array
from fecontact.common.errors import InputError
from fecontact.halfspace.bounded import borne_share
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.nested import GridLevel
from fecontact.solvers.coulomb import Residuals, ResidualScales, largest, ratio

C = TypeVar("C", bound=HalfSpaceContact)

#: Least hardness over the contact modulus: below it elastic displacements are some 1e-4 of the dents, lost in them.
LEAST_HARDNESS = 1e-4

#: Penetration over the largest displacement that a certificate allows, in tolerances.
PENETRATION = 10

#: Excess of a force over what the whole counter-surface bears that counts as rounding; the same at a load point.
ROUNDING, BALANCE = 1e-12, 1e-9


def hardness_field(hardness: ArrayLike | None, body: SurfaceCompliance) -> Array | None:
    """Hardness of the cells (nx, ny) from a number or such an array.

    Raises
    ------
    InputError
        If it is not positive, of another shape, or below 1e-4 of the contact modulus.
    """
    if hardness is None:
        return None
    values, shape = number_array("the hardness", hardness), body.grid.shape
    if values.shape not in ((), shape):
        raise InputError(
            f"The hardness must be a number or have the grid's shape {shape}; found {values.shape}.", code="wrong-shape"
        )
    least, modulus = float(values.min()), body.modulus
    if not least >= LEAST_HARDNESS * modulus:
        raise InputError(
            f"The hardness must be at least {LEAST_HARDNESS:g} of the contact modulus E*, {LEAST_HARDNESS * modulus:g};"
            f" found {least:g}. Of a softer surface hardly anything is elastic: the counter-surface cuts it, over an "
            "area of force / hardness.",
            code="hardness-too-low",
        )
    return np.broadcast_to(values, shape)


def check_bearing(level: GridLevel, grid: Grid) -> None:
    """Refuse a force that the counter-surface does not bear at the hardness, in all or at its point of action."""
    if not len(level.F) or level.bound is None:
        return
    whole = grid.area * 2 ** sum(level.symmetric)
    force, most = float(level.F[0]) * whole, float(level.bound.sum(where=level.allowed)) * whole
    if force > (1 + ROUNDING) * most:
        area = int(level.allowed.sum()) * whole
        raise InputError(
            f"The force, {force:g}, is above what the counter-surface bears: the hardness times its area, {area:g}, is "
            f"{most:g}. Take a smaller force, or a larger counter-surface.",
            code="force-above-hardness",
        )
    bound = np.where(level.allowed, level.bound, 0.0)
    if len(level.F) > 1 and (share := borne_share(level.B, level.F, bound)) < 1 - BALANCE:
        raise InputError(
            f"The force, {force:g}, is above what the counter-surface bears at this load point: pressures up to the "
            f"hardness balance at most {share * force:g} there, and {most:g} in all. Take a smaller force, or a load "
            "point nearer the middle.",
            code="force-above-hardness",
        )


def within_bounds(p: Array, bound: Array | None) -> bool:
    """Whether no pressure is negative or above its bound."""
    return bool((p >= 0).all()) and (bound is None or bool((p <= bound).all()))


def dented(heights: Array, last: HalfSpaceContact | None) -> Array:
    """Heights (nx, ny) over the surface with the dents that the last contact has left."""
    return heights if last is None or last.dent is None else heights + last.dent


def with_own_dent(contact: C, last: HalfSpaceContact | None) -> C:
    """A contact of several loads with the dent of the last one alone."""
    if contact.hardness is None or contact.dent is None or last is None or last.dent is None:
        return contact
    return replace(contact, dent=np.where(contact.pressure >= contact.hardness, contact.dent - last.dent, 0.0))


def yielded(level: GridLevel, u: Array, p: Array, q: Array, tolerance: float) -> tuple[Array, Mask]:
    """Dent (nx, ny) of pressures at their bound, by their displacements and motions, and which cells yield.

    A dent within what a certificate allows as penetration is no yielding: whether a cell is just at its hardness, as
    all are that had yielded and are pressed again, is not left to rounding.
    """
    assert level.bound is not None
    lack = -(u + level.g + np.einsum("k,kij->ij", q, level.B))
    dent = np.where(level.allowed & (p >= level.bound), np.maximum(lack, 0.0), 0.0)
    return dent, dent > PENETRATION * tolerance * np.abs(u).max(where=level.allowed, initial=0.0)


def with_hardness(found: Residuals, p: Array, dent: Array, hardness: Array, scales: ResidualScales) -> Residuals:
    """Residuals with those of the upper bound: pressures above it, negative dents, dents of pressures below it."""
    reserve, depth = ratio(hardness - p, scales.force), ratio(dent, scales.gap)
    return replace(
        found,
        penetration=max(found.penetration, -float(depth.min())),
        tension=max(found.tension, -float(reserve.min())),
        complementarity=max(found.complementarity, largest(np.minimum(np.abs(reserve), np.abs(depth)))),
    )
