"""Members of rigid shapes for indentation of a half-space: their ends and their closed form."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from fecontact.common.arrays import Array

T = TypeVar("T")


class ClosedForms(Generic[T]):
    """Closed forms of contact on one kind of half-space by the shape of the indenter; None where there is none.

    Subclasses override the known ones. A shape selects its own, see `Indenter.closed_form`.
    """

    def flat(self, radius: float) -> T | None:
        """Closed form of a flat circular punch."""
        return None

    def cone(self, angle: float) -> T | None:
        """Closed form of a cone with this angle (radians) between its flank and the plane."""
        return None

    def sphere(self, radius: float) -> T | None:
        """Closed form of a sphere."""
        return None

    def paraboloid(self, radii: tuple[float, float]) -> T | None:
        """Closed form of the paraboloid with these radii of curvature along x and y."""
        return None

    def ellipsoid(self, semi_axes: tuple[float, float, float]) -> T | None:
        """Closed form of an ellipsoid with its third axis vertical."""
        return None

    def endless_cylinder(self, radius: float) -> T | None:
        """Closed form of an infinite cylinder along y."""
        return None

    def wave(self, amplitude: float, wavelength: float) -> T | None:
        """Closed form of the surface amplitude (1 - cos(2 pi x/wavelength))."""
        return None


def heights_of(shape: object) -> Callable[[Array, Array], Array] | None:
    """Function for the heights of a shape over the plane z = 0 at x and y; None where it has none."""
    return getattr(shape, "heights", None)


class Indenter:
    """Defaults for a finite shape without a closed form."""

    #: Whether contact may reach its ends along x and along y.
    open_ends: ClassVar[tuple[bool, bool]] = (False, False)

    @property
    def is_endless(self) -> bool:
        """Whether it touches a plane up to the border of any grid."""
        return False

    def closed_form(self, forms: ClosedForms[T]) -> T | None:
        """Its closed form."""
        return None
