"""Derivatives of figures of a half-space's contact by heights, load and modulus, see `solvers.gradient`.

The area has its edge within its cells (`grid_error`): each of its terms depends on pressures and gaps up to two cells
away. They are differentiated by central differences of all cells that are five apart at once; all else is exact.

With friction the adjoint is that of the pressures and tractions of the cells in contact, by a full matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import product as pairs
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import among, number_array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.fft import Tally
from fecontact.halfspace.grid_error import edge_cells
from fecontact.halfspace.nested import compliance
from fecontact.halfspace.operator import CellModel
from fecontact.halfspace.pressing import Load, grid_level
from fecontact.halfspace.traction_contact import FrictionContact
from fecontact.solvers import ContactProblem
from fecontact.solvers.gradient import WEAK, adjoint, by_products, of_largest, saddle, weakly_active

#: Figures that can be differentiated, and cells between those that share no term of the area.
FIGURES, APART = ("max_pressure", "force", "area", "approach"), 5
#: Cells in contact of which the matrix with friction is made.
MOST_CELLS = 1500
#: Relative step of central differences of the terms of the area.
STEP = 1e-6


@compact_repr
@dataclass(frozen=True, eq=False)
class PressGradient:
    """Derivatives of a figure of a contact on a half-space.

    Attributes
    ----------
    value : float
        The figure.
    heights : (nx, ny) array
        Derivatives by the heights of the surface pressed; zero where there is none.
    load : float
        By the force, or by the approach where that was prescribed.
    E : float or None
        By Young's modulus of the half-space, its Poisson's ratio fixed; None for layers.
    weak : (n, 2) int array
        Cells about to open or to close, with friction to stick or to slide: derivatives are one-sided there.
    tangential : (2,) array or None
        With friction: by the tangential force, or by the shift where that was prescribed.
    """

    value: float
    heights: Array
    load: float
    E: float | None
    weak: IntArray
    tangential: Array | None = None


def press_gradient(
    body: SurfaceCompliance,
    material: Any,
    contact: HalfSpaceContact,
    what: str | ArrayLike,
    load_point: tuple[float, float] | None,
    share: float,
) -> PressGradient:
    """Derivatives of a figure, see `HalfSpace.gradient`; `share` is the material's own part of the displacements."""
    shape, active, allowed = contact.grid.shape, contact.active, np.isfinite(contact.gap)
    given = contact.given == "approach"
    load = Load(None, contact.approach, None) if given else Load(contact.force, None, load_point)
    level = grid_level(body, np.zeros(shape), allowed, load, symmetry=False)
    operator = compliance(level, level.whole, Tally(contact.grid.n_cells), None)
    B = level.B.reshape(len(level.F), *shape)
    value, by_pressure, by_gap = _figure(contact, what)
    motions = -np.array([1.0, *(-p / (s / 2) for p, s in zip(load_point or (), contact.grid.size, strict=False))])
    by_motion = (motions if isinstance(what, str) and what == "approach" else 0.0) + np.zeros(len(B))
    if by_gap.any():
        by_pressure = by_pressure + operator.apply(by_gap)
        by_motion = by_motion + np.einsum("kij,ij->k", B, by_gap)

    def product(x: Array) -> Array:
        full = np.zeros(shape)
        full[active] = x
        return np.asarray(operator.apply(full)[active])

    response = -by_gap
    response[active], found = saddle(partial(by_products, product), B[:, active], by_pressure[active], by_motion)
    by_load = float(response.sum()) if given else float(found[0]) / contact.grid.area
    by_modulus = None if contact.layers else share * float((response * contact.displacement).sum()) / material.E
    return PressGradient(value, -response, by_load, by_modulus, _weak(contact, allowed))


def _figure(contact: HalfSpaceContact, what: str | ArrayLike) -> tuple[float, Array, Array]:
    """A figure, and its derivatives by pressures and by gaps."""
    p, none = contact.pressure, np.zeros(contact.grid.shape)
    if not isinstance(what, str):
        weights = number_array("the weights of the pressures", what)
        if weights.shape != p.shape:
            raise InputError(f"Weights of pressures have the grid's shape {p.shape}; found {weights.shape}.")
        return float((weights * p).sum()), weights, none
    among("figure", what, FIGURES)
    if what == "max_pressure":
        return contact.max_pressure, of_largest(p), none
    if what == "area":
        by_pressure, by_gap = (contact.grid.area * d for d in _by_edge(contact))
        return contact.figures["area"], by_pressure, by_gap
    return (contact.force, none + contact.grid.area, none) if what == "force" else (contact.approach, none, none)


def _by_edge(contact: HalfSpaceContact) -> tuple[Array, Array]:
    """Derivatives of the area, in cells, by pressures of cells in contact and by gaps of others."""
    p, gap, shape = contact.pressure, contact.gap, contact.grid.shape
    apart = [next(k for k in range(APART, n + 1) if n % k == 0 or not contact.periodic) for n in shape]
    open_ = ~contact.active & np.isfinite(gap) & (gap > 0)
    by_pressure, by_gap = np.zeros(shape), np.zeros(shape)
    for first in pairs(*map(range, apart)):
        for field, cells, into in ((p, contact.active, by_pressure), (gap, open_, by_gap)):
            chosen = np.zeros(shape, bool)
            chosen[first[0] :: apart[0], first[1] :: apart[1]] = True
            step = np.where(chosen & cells, STEP * np.where(cells, field, 0.0), 0.0)
            terms = []
            for sign in (1.0, -1.0):
                moved = (p + sign * step, gap) if field is p else (p, gap + sign * step)
                edge = edge_cells(*moved, contact.periodic)
                terms.append(edge.excess[0])
            change = (terms[0] - terms[1]) / 2
            reach = [(f - at + 2) % k - 2 for f, at, k in zip(first, edge.place, apart, strict=True)]
            near = (reach[0] <= 2) & (reach[1] <= 2)
            place = tuple((at + r)[near] % n for at, r, n in zip(edge.place, reach, shape, strict=True))
            size = step[place]
            np.add.at(into, place, np.divide(change[near], size, out=np.zeros(len(size)), where=size > 0))
    return by_pressure, by_gap


def _weak(contact: HalfSpaceContact, allowed: Mask) -> IntArray:
    """Cells (n, 2) with hardly any pressure, or without it hardly any gap."""
    p, gap = contact.pressure, contact.gap
    opened = allowed & (p == 0)
    least = WEAK * (float(gap[opened].mean()) if opened.any() else 0.0)
    slight = (p > 0) & (p < WEAK * p[p > 0].mean()) if (p > 0).any() else p > 0
    return np.argwhere(slight | (opened & (gap <= least)))


def friction_gradient(
    body: SurfaceCompliance, E: float | None, contact: FrictionContact, what: str | ArrayLike, by_shift: bool
) -> PressGradient:
    """Derivatives of a figure of a contact with friction, pressed in one step, see `HalfSpace.gradient`."""
    active, area = contact.active, contact.grid.area
    n, flat = int(active.sum()), np.flatnonzero(active)
    if n > MOST_CELLS:
        raise InputError(
            f"With friction {n} cells in contact make a matrix of {3 * n} rows; up to {MOST_CELLS} are offered. Take "
            "coarser cells.",
            code="no-gradient",
        )
    x = np.stack([contact.pressure, *contact.traction])[:, active].ravel()
    rows = np.zeros((3, 3 * n))
    for k in range(3):
        rows[k, k * n : (k + 1) * n] = 1.0
    motion = np.array([contact.approach, *contact.shift])
    loose = np.array([contact.given != "approach", not by_shift, not by_shift])
    S = _matrix(body, contact, flat)
    place = np.arange(n)
    g = np.concatenate([_heights(contact)[active], np.zeros(2 * n)]) - motion[~loose] @ rows[~loose]
    tangents, mu = np.stack([n + place, 2 * n + place], axis=1), np.full(n, contact.friction)
    problem = ContactProblem(S, g, rows[loose], rows[loose] @ x, place, tangents, mu)
    value, by_forces, by_motion = _figure_of_friction(contact, what)
    found = adjoint(problem, x, -motion[loose], by_forces[:, active].ravel(), -by_motion[loose])
    heights = np.zeros(contact.grid.shape)
    heights[active] = -found.response[:n]
    loads = rows @ found.response + by_motion  # by motions that are given
    loads[loose] = found.load / area
    cells = np.unique(weakly_active(problem, x, -motion[loose]) % n)
    by_modulus = None if E is None else float(found.response @ (S @ x)) / E
    return PressGradient(value, heights, float(loads[0]), by_modulus, np.argwhere(active)[cells], loads[1:])


def _matrix(body: SurfaceCompliance, contact: FrictionContact, flat: IntArray) -> Array:
    """Displacements (3 n, 3 n) of the cells in contact, normal and tangential, by pressures and tractions on them."""
    n, place = len(flat), np.concatenate([3 * flat + 2, 3 * flat, 3 * flat + 1])
    sign = np.repeat([-1.0, 1.0, 1.0], n)  # pressures are inwards
    rows = sp.csr_matrix((sign, (np.arange(3 * n), place)), (3 * n, 3 * contact.grid.n_cells))
    return contact.grid.area * CellModel(body).dense_in_space(rows)


def _heights(contact: FrictionContact) -> Array:
    """Heights of the surface pressed, where it is."""
    return np.asarray(contact.gap - contact.displacement + contact.approach)


def _figure_of_friction(contact: FrictionContact, what: str | ArrayLike) -> tuple[float, Array, Array]:
    """A figure, its derivatives (3, nx, ny) by pressures and tractions, and (3,) by approach and shifts."""
    by_forces, by_motion = np.zeros((3, *contact.grid.shape)), np.zeros(3)
    if isinstance(what, str):
        among("figure of a contact with friction", what, [name for name in FIGURES if name != "area"])
        value, by_forces[0], _ = _figure(contact, what)
        by_motion[0] = what == "approach"
        return value, by_forces, by_motion
    weights = number_array("the weights of pressures and tractions", what)
    if weights.shape not in (by_forces.shape, by_forces.shape[1:]):
        raise InputError(
            f"Weights of pressures have the grid's shape {by_forces.shape[1:]}, of tractions too {by_forces.shape}; "
            f"found {weights.shape}."
        )
    by_forces[: 1 if weights.ndim == 2 else 3] = weights
    return float((by_forces * [contact.pressure, *contact.traction]).sum()), by_forces, by_motion
