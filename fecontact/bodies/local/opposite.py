"""Half-space with its cells opposite those of a local body's window."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fecontact.bodies.halfspace.halfspace import HalfSpace
from fecontact.bodies.halfspace.operator import CellModel
from fecontact.bodies.local.placing import STEEPEST
from fecontact.bodies.local.relief import fit
from fecontact.bodies.local.sources import inclined
from fecontact.bodies.local.surface import WindowSurface, window_surface
from fecontact.bodies.local.window import OPPOSITE, Window
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

STEEPEST_LAYERED = 0.01
"""Largest slope of a layered half-space over the window: effects of slope^2 are left out of its kernel."""


@dataclass(frozen=True, eq=False, init=False)
class FacingHalfSpace(HalfSpace):
    """A half-space whose cells are those of a window on its surface.

    Parameters
    ----------
    half : HalfSpace
    window : Window
        In the half-space's axes; with a relief where the half-space inclines to it.
    """

    window: Window = field(repr=False)

    def __init__(self, half: HalfSpace, window: Window) -> None:
        super().__init__(
            half.material,
            window.grid.size,
            window.grid.shape,
            layers=half.layers,
            against=half.against,
            arrays=half.arrays,
            name=half.name,
        )
        for key, value in {"pose": half.pose, "window": window}.items():
            object.__setattr__(self, key, value)

    @cached_property
    def _cells(self) -> CellModel:
        slopes = () if self.material is None or self.layers else tuple(inclined(self.window, self.material))
        return CellModel(self.compliance, self.window.mirrored, slopes)

    @cached_property
    def facets(self) -> WindowSurface:  # type: ignore[override]
        """Its surface: cell centres and quadrilaterals between them."""
        return window_surface(self.window, self.window.cells, "surface")


def half_space_opposite(half: HalfSpace, other: Window, pose: Pose, names: tuple[str, str]) -> HalfSpace:
    """A half-space with its cells opposite those of a window; itself if they are.

    Parameters
    ----------
    half : HalfSpace
    other : Window
    pose : Pose
        Of the window's axes in the half-space's.
    names : (str, str)
        Of the half-space and the window's body, for messages.

    Raises
    ------
    InputError
        If the half-space does not lie opposite, is not symmetric where the window is, or has other pressures.
    """
    if isinstance(half, FacingHalfSpace) and half.window.faces(other, pose):
        return half
    if half.periodic or half.pressure != "uniform":
        found = "it is periodic" if half.periodic else f"it has pressure={half.pressure!r}"
        raise InputError(
            f"{names[0]!r} meets the local body {names[1]!r} cell on cell, with pressures uniform over the cells and "
            f"none beyond the window; {found}. Make it with periodic=False and pressure='uniform'."
        )
    axes = pose.rotation @ other.axes * np.array([1.0, 1.0, -1.0])
    slopes = axes[2, :2] / axes[2, 2] if axes[2, 2] > 0 else np.full(2, np.inf)
    steepest = STEEPEST_LAYERED if half.layers else STEEPEST
    if np.linalg.norm(slopes) > steepest:
        raise InputError(
            f"The surface of {names[0]!r} inclines by {np.linalg.norm(slopes):.3g} to the window of {names[1]!r}; up "
            f"to {steepest:g} is possible. Put the window where the surfaces are parallel, or check the poses."
        )
    across = [side for side, even, s in zip("xy", other.mirrored, slopes, strict=True) if even and abs(s) > OPPOSITE]
    if across:
        raise InputError(
            f"{names[1]!r} is modelled up to planes of symmetry, to which {names[0]!r} is not normal. Model the body "
            "without them, or check the poses."
        )
    origin = pose.to_world(other.origin[None])[0]
    origin = origin - origin[2] / axes[2, 2] * axes[:, 2]
    return FacingHalfSpace(half, _on_plane(Window(origin, axes, other.grid, other.mirrored), slopes))


def _on_plane(window: Window, slopes: Array) -> Window:
    """A window with the depths of the plane z = 0 below it, which has these slopes."""
    if np.abs(slopes).max() <= OPPOSITE:
        return window

    def depths(x: Array, y: Array) -> Array:
        return slopes[0] * x + slopes[1] * y

    relief = fit(depths, window.half, window.mirrored)
    return Window(window.origin, window.axes, window.grid, window.mirrored, relief, depths(*window.places))
