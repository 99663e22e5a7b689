"""Surface of cells of a half-space: heights over it, and figures of contacts on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import number_array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.gradient import PressGradient, friction_gradient, press_gradient
from fecontact.halfspace.grid import Grid
from fecontact.halfspace.layered import Layer
from fecontact.halfspace.pressing import Load, press
from fecontact.halfspace.traction_contact import FrictionContact
from fecontact.halfspace.validity import overlap_between_cells
from fecontact.surfaces.rigid.heightmap import HeightMap
from fecontact.surfaces.rigid.shapes import heights_of

C = TypeVar("C", bound=HalfSpaceContact)


class HeightSurface(Protocol):
    """A rigid surface over the plane z = 0, with its lowest point on it."""

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together; infinite where there is no surface."""


#: What is pressed on a half-space: a shape, or heights (nx, ny) at the cells.
Pressed = HeightSurface | ArrayLike


class CellSurface:
    """Surface of cells: base of what is pressed, dragged and rolled on."""

    grid: Grid
    periodic: bool
    material: Material | None
    layers: tuple[Layer, ...]
    against: Material | None
    compliance: SurfaceCompliance

    def heights_of(self, surface: Pressed, position: tuple[float, float] = (0.0, 0.0)) -> Array:
        """Heights (nx, ny) of a surface at the cell centres; of a shape with its own origin at a position."""
        if shape := heights_of(surface):
            z = shape(self.grid.x[:, None] - position[0], self.grid.y[None, :] - position[1])
            return np.broadcast_to(np.asarray(z, dtype=float), self.grid.shape)
        if any(position):
            raise InputError(
                "Heights given as an array cannot be moved to a position: give a shape with `heights`.",
                code="heights-fixed",
            )
        return number_array("the heights", surface)

    def _between_cells(self, contact: C, surface: Pressed, position: tuple[float, float] = (0.0, 0.0)) -> C:
        """The contact, with a warning where a shape reaches below the surface between its cells."""
        # of a map nothing is known between its points
        if (heights := heights_of(surface)) is None or isinstance(surface, HeightMap):
            return contact
        x, y = position
        warning = overlap_between_cells(contact, lambda s, t: heights(s - x, t - y), self.compliance.modulus)
        return replace(contact, between=warning) if warning else contact

    def _refuse_memory(self, what: str) -> None:
        """Refuse what does not know of time, if the half-space is visco-elastic."""
        if self.compliance.memory:
            raise InputError(
                f"A visco-elastic half-space does not serve {what}: use press_path with PressStep(time=), press with "
                "velocity= for a contact that moves steadily, or an elastic half-space of its material at once "
                "(`.material`) or after a long time (`.relaxed`).",
                code="viscoelastic",
            )

    def stiffness(self, contact: HalfSpaceContact) -> float:
        """Slope of force over approach at a contact with this half-space, without tilt.

        An increment of approach displaces all cells in contact equally: the slope is the force per approach of a flat
        punch with the contact's outline (Barber, Proc. R. Soc. A 459 (2003) 53). Infinite for a periodic surface in
        full contact, whose mean plane is not displaced.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(64, 64))
        >>> ball = half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3)  # radius 1: 2 E* a
        >>> abs(half.stiffness(ball) / 2.0 - 1) < 0.01
        True
        """
        instance("the contact", contact, HalfSpaceContact)
        if not contact.has_stiffness:
            raise InputError(
                "The stiffness with adhesion, and in motion over a visco-elastic half-space, is not that of the "
                "outline: take the slope of a curve with adhesion, or of several contacts.",
                code="not-with-adhesion",
            )
        if not contact.active.any():
            return 0.0
        if self.periodic and self.compliance.mean_is_stiff and contact.active.all():
            return math.inf
        outline = np.where(contact.active, 0.0, np.inf)
        load = Load(contact.force, None, None)
        return contact.force / press(self.compliance, outline, load, 1e-8, True, None, boxed=False).approach

    def gradient(
        self,
        contact: HalfSpaceContact,
        what: str | ArrayLike = "max_pressure",
        *,
        load_point: tuple[float, float] | None = None,
        by_shift: bool = False,
    ) -> PressGradient:
        """Derivatives of a figure of a contact with this half-space, by one solution with the cells in contact.

        Parameters
        ----------
        contact : HalfSpaceContact
            Of `press`, elastic, without adhesion, hardness or velocity. With friction of up to 1500 cells in contact.
        what : {'max_pressure', 'force', 'area', 'approach'} or (nx, ny) array_like
            A figure, or the weights of a linear functional of the pressures, with friction (3, nx, ny) of pressures and
            tractions. The gradient of a function of them is that with its derivatives as weights. With friction there
            is no area.
        load_point : (float, float), optional
            As in `press`.
        by_shift : bool
            With friction: whether the shift was prescribed, not the tangential force.

        Returns
        -------
        PressGradient

        Raises
        ------
        InputError
            For another figure or contact, or weights of another shape.

        Examples
        --------
        The largest pressure under a ball grows with the cube root of the force, and with E^(2/3):

        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(32, 32))
        >>> ball = half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3)
        >>> slope = half.gradient(ball)
        >>> round(slope.load * ball.force / slope.value, 2), round(slope.E / slope.value, 2)
        (0.33, 0.67)
        """
        if type(contact) is FrictionContact and contact.dent is None and contact.retarded is None:
            return friction_gradient(self.compliance, self._modulus, contact, what, by_shift)
        elastic_contact = type(contact) is HalfSpaceContact and contact.dent is None
        if not elastic_contact or (any(contact.tilt) and load_point is None):
            raise InputError(
                "A gradient is of an elastic contact of `press`, and of one free to tilt with its "
                f"load_point; found {contact!r}.",
                code="no-gradient",
            )
        soft, other = (0.0 if m is None else 1 / m.plane_strain_modulus for m in (self.material, self.against))
        share = soft / (soft + other) if soft else 0.0
        return press_gradient(self.compliance, self.material, contact, what, load_point, share)

    @property
    def _modulus(self) -> float | None:
        """That of a homogeneous half-space below a rigid partner."""
        alone = not self.layers and self.against is None
        return self.material.E if alone and isinstance(self.material, Material) else None


def refuse_others(others: Mapping[str, object], why: str, code: str) -> None:
    """Refuse other arguments that are given."""
    if given := [f"{name}=" for name, value in others.items() if value is not None]:
        raise InputError(f"{why}: leave out {', '.join(given)}.", code=code)


def listed(name: str, values: ArrayLike | None) -> Array:
    """Values (n,) of a curve."""
    found = number_array(f"the {name} of a curve", values)
    if found.ndim != 1 or not found.size:
        raise InputError(
            f"The {name} of a curve must be numbers (n,), one or more; found shape {found.shape}.", code="wrong-shape"
        )
    return found
