"""Half-space and load of an indentation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fecontact.bodies import HalfSpace, Layer
from fecontact.common.errors import InputError
from fecontact.common.material import Material


@dataclass(frozen=True)
class Ground:
    """A half-space without its grid.

    Attributes
    ----------
    material : Material or None
        None: a rigid base under layers.
    layers : tuple of Layer
    against : Material or None
        Material of an elastic counter-body.
    periodic : bool
    """

    material: Material | None
    layers: tuple[Layer, ...] = ()
    against: Material | None = None
    periodic: bool = False

    def on(self, size: tuple[float, float], cells: tuple[int, int]) -> HalfSpace:
        """The half-space with a grid."""
        return HalfSpace(self.material, size, cells, self.periodic, layers=self.layers, against=self.against)

    @property
    def softest(self) -> Ground:
        """The homogeneous half-space of its softest material, for the widest contact."""
        materials = [m for m in (self.material, *(layer.material for layer in self.layers)) if m is not None]
        soft = min(materials, key=lambda m: m.plane_strain_modulus)
        return Ground(soft, (), self.against, False)


@dataclass(frozen=True)
class IndentationLoad:
    """Force or approach, and the moment of the force about the origin or its point of action.

    Attributes
    ----------
    force, approach : float or None
    point : (float, float) or None
        Point of action of the force; the shape is then free to tilt.
    """

    force: float | None = None
    approach: float | None = None
    point: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        given = [(n, v) for n, v in (("force", self.force), ("approach", self.approach)) if v is not None]
        if len(given) != 1:
            raise InputError(f"Give exactly one of a force and an approach; found {len(given)}.")
        name, value = given[0]
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"The {name} must be positive (pressing together); found {value!r}. A frictionless contact without "
                "adhesion carries no tension, and without load nothing is pressed."
            )
        if self.point is not None and self.force is None:
            raise InputError("A load point or moment goes with a force: with a prescribed approach nothing tilts.")

    @classmethod
    def of_moment(cls, force: float, moment: tuple[float, float]) -> IndentationLoad:
        """A force downwards with moments about x and y through the origin.

        Examples
        --------
        >>> IndentationLoad.of_moment(10.0, (0.0, 5.0)).point
        (0.5, 0.0)
        """
        return cls(force, None, (moment[1] / force if moment[1] else 0.0, -moment[0] / force if moment[0] else 0.0))
