"""What a rigid shape answers where it is pressed on a half-space: how it ends, and which closed form is its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from fecontact.common.arrays import Array

T = TypeVar("T")


class ClosedForms(Generic[T]):
    """Closed forms of contact on one kind of ground by the shape of the indenter; None where there is none.

    A kind of ground overrides what it knows. A shape picks its own, see `Indenter.closed_form`.
    """

    def flat(self, radius: float) -> T | None:
        """Of a flat circular punch."""
        return None

    def cone(self, angle: float) -> T | None:
        """Of a cone with this angle (radians) between its flank and the plane."""
        return None

    def sphere(self, radius: float) -> T | None:
        """Of a ball."""
        return None

    def paraboloid(self, radii: tuple[float, float]) -> T | None:
        """Of the paraboloid with these radii of curvature along x and y."""
        return None

    def ellipsoid(self, semi_axes: tuple[float, float, float]) -> T | None:
        """Of an ellipsoid, resting on the end of its third axis."""
        return None

    def endless_cylinder(self, radius: float) -> T | None:
        """Of a cylinder along y without end."""
        return None

    def wave(self, amplitude: float, wavelength: float) -> T | None:
        """Of the surface amplitude (1 - cos(2 pi x/wavelength))."""
        return None


def heights_of(shape: object) -> Callable[[Array, Array], Array] | None:
    """How a shape tells its heights over the plane z = 0 at x and y; None where it does not."""
    return getattr(shape, "heights", None)


class Indenter:
    """Defaults of the answers, which do for a shape without closed form that ends where its lower side does."""

    #: Whether it may be in contact up to where it ends, along x and along y.
    open_ends: ClassVar[tuple[bool, bool]] = (False, False)

    @property
    def is_endless(self) -> bool:
        """Whether it would touch a plane to the border of any grid."""
        return False

    def closed_form(self, forms: ClosedForms[T]) -> T | None:
        """Its own among closed forms."""
        return None
