"""Soft contact: surfaces that overlap under a pressure, as by a thin layer or asperities between them.

A pressure p = k d grows with the overlap d of the surfaces, the overclosure. With the gap w = -d this is

    w + p / k >= 0,   p >= 0,   p (w + p / k) = 0

which is hard contact with a compliance 1 / (k A) of each point of area A for itself, beside that of the bodies: an
elastic (Winkler) foundation between them. It is solved as exactly as hard contact, the limit of an infinite k.

Of a table of overlaps and pressures each point is on one of its lines, d = o + c p: the same with the compliance
c / A and the gap w + o. Points that leave their line take the one of their pressure, and the problem is solved again
until all of them stay: Newton's method for a law of straight lines, which ends at its solution (Kojima & Shindo 1986,
*Extension of Newton and quasi-Newton methods to systems of PC1 equations*).

Source: K. L. Johnson, Contact Mechanics, 1985, section 4.3 (the foundation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from fecontact.bodies.body import Body
from fecontact.common.arrays import ROUNDING, Array, IntArray
from fecontact.common.checks import array_of, positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown


@compact_repr
@dataclass(frozen=True, eq=False)
class SoftContact:
    """Pressure by overclosure, for `Contact(..., overclosure=)`.

    Parameters
    ----------
    stiffness : float or sequence of (overclosure, pressure)
        Pressure per overclosure (force / length^3), positive: that of a layer is its modulus over its thickness. Or a
        table: overclosures and pressures that both grow, the first pressure zero; before it surfaces do not feel each
        other, beyond the last the last line goes on. The first overclosure is negative where they do before they meet.

    Raises
    ------
    InputError
        If it is not positive and finite, or a table does not grow.

    Examples
    --------
    A column of stiffness E / h on a layer of stiffness k, pressed by u: p = u / (h / E + 1 / k).

    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor, overclosure=fc.SoftContact(3.0))])
    >>> contact = scene.solve(motions={body: {"z": -0.02}}).contacts[0]
    >>> contact.pressure.round(12).tolist()[0], contact.overclosure.round(12).tolist()[0]
    (0.015, 0.005)
    """

    stiffness: float | Sequence[tuple[float, float]]
    #: Compliances and overclosures at zero pressure (n,) of the lines of the law, and pressures (n - 1,) between them.
    lines: tuple[Array, Array, Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if (table := array_of(self.stiffness)) is None or table.ndim == 0:
            k = positive("the stiffness of a soft contact", cast(float, self.stiffness))
            object.__setattr__(self, "stiffness", k)
            object.__setattr__(self, "lines", (np.array([1 / k]), np.zeros(1), np.zeros(0)))
            return
        grows = table.ndim == 2 and table.shape[1:] == (2,) and len(table) > 1 and np.isfinite(table).all()
        if not grows or table[0, 1] != 0 or (np.diff(table, axis=0) <= 0).any():
            raise InputError(
                "The table of a soft contact must be rows of overclosure and pressure, both growing, the first "
                f"pressure zero; found {shown(self.stiffness)}.",
                code="soft-contact-table",
            )
        compliance = np.diff(table[:, 0]) / np.diff(table[:, 1])
        start = table[:-1, 0] - compliance * table[:-1, 1]
        object.__setattr__(self, "lines", (compliance, start, table[1:-1, 1]))

    @classmethod
    def exponential(cls, clearance: float, pressure: float) -> SoftContact:
        """Law p = p_0 exp(d log(100) / c) of a pressure p_0 at zero clearance, a hundredth of it at the clearance c.

        As in CalculiX. It is a table, from that hundredth on to a million times p_0, off by a thousandth at most.

        Examples
        --------
        >>> law = SoftContact.exponential(0.1, 2.0)
        >>> round(float(law.overclosure(np.array([2.0]))[0]), 12)
        0.0
        """
        c = positive("the clearance of a soft contact", clearance)
        d = c * np.concatenate([np.arange(-100, 0), np.arange(301)]) / 100
        p = positive("the pressure of a soft contact", pressure) * np.exp(d * np.log(100) / c)
        return cls(np.stack([d, np.concatenate([[0.0], p[1:]])], axis=1).tolist())

    def line(self, pressure: Array, before: IntArray | None = None) -> IntArray:
        """Lines (n,) of pressures (n,); at the end of a line, but for rounding, the one of before."""
        ends = self.lines[2]
        found = np.searchsorted(ends, pressure, side="right")
        if before is None:
            return found
        low, high = np.append(-np.inf, ends)[before], np.append(ends, np.inf)[before]
        slack = ROUNDING * np.abs(pressure).max(initial=0.0)
        return np.where((pressure >= low - slack) & (pressure <= high + slack), before, found)

    def overclosure(self, pressure: Array) -> Array:
        """Overlaps (n,) under pressures (n,)."""
        compliance, start, _ = self.lines
        k = self.line(pressure)
        return np.asarray(start[k] + compliance[k] * pressure)

    def check(self, body: Body) -> None:
        """Refuse bodies whose contact is not served.

        Raises
        ------
        InputError
        """
        if body._finite_strain is not None or body._matrix_free:
            what = (
                "has a law of finite strain" if body._finite_strain is not None else "is a half-space or has its cells"
            )
            raise InputError(
                f"{body.name!r} {what}: a soft contact is offered for small strains on meshed and rigid surfaces. "
                "Leave overclosure out, or model the layer by cells.",
                code="soft-contact-body",
            )
