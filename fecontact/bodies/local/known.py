"""What the windows of one body have in common: its factor, and the remainders of the windows that come back."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.remainder import Remainder, on_divided_mesh, remainder
from fecontact.bodies.local.window import Window
from fecontact.common.material import Material
from fecontact.fem.model import Model

LAST = 4
"""Remainders that are kept."""


@dataclass(eq=False)
class Known:
    """Factors and remainders of a body, for all of its windows and poses.

    Attributes
    ----------
    factors : list of Factored
    remainders : list of (Factored, Remainder)
        The last ones.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((2.0, 2.0, 2.0), (3, 3, 3))
    >>> body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), supports={"bottom": "xyz"})
    >>> one = fc.LocalBody(body, (1.0, 1.0, 2.0), 0.5, (8, 8))
    >>> other = one.with_window((0.9, 1.0, 2.0), (0.5, 0.5))
    >>> other.factored is one.factored
    True
    """

    factors: list[Factored] = field(default_factory=list)
    remainders: list[tuple[Factored, Remainder]] = field(default_factory=list)

    def factored(self, model: Model, window: Window) -> Factored:
        """The stiffness for loads in a window."""
        for made in self.factors:
            if made.serves(window.origin):
                return made
        self.factors.append(Factored.of(model, window.origin[None]))
        return self.factors[-1]

    def remainder(self, factored: Factored, window: Window, material: Material) -> Remainder:
        """The remainder in a window."""
        for by, found in self.remainders:
            if by is factored and _same(found.window, window):
                return found
        made = remainder(factored, window, material)
        self.remainders[:] = [*self.remainders, (factored, made)][-LAST:]
        return made

    def on_divided_mesh(self, body: ElasticBody, found: Remainder, name: str) -> Remainder:
        """A remainder that is not symmetric, on a finer mesh in its stead, see `dividing.on_divided_mesh`."""
        made = on_divided_mesh(body, found.window, found.material, found, name)
        self.remainders[:] = [(by, made if other is found else other) for by, other in self.remainders]
        return made


def _same(one: Window, other: Window) -> bool:
    alike = np.array_equal(one.origin, other.origin) and np.array_equal(one.axes, other.axes)
    return alike and one.grid == other.grid and one.mirrored == other.mirrored
