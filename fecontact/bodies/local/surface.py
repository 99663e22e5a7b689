"""Surface of a local body in a scene: the cells of its window.

Half-space with its cells opposite those of a local body's window.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.local.placing import STEEPEST
from fecontact.bodies.local.relief import fit
from fecontact.bodies.local.window import OPPOSITE, Window, inclined
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, Mask
from fecontact.common.errors import InputError
from fecontact.halfspace.operator import CellModel
from fecontact.halfspace.surface import GridSurface, between_cells
from fecontact.mesh.facets import sides_of
from fecontact.surfaces.facet_surface import Projection


@dataclass(frozen=True, eq=False)
class WindowSurface(GridSurface):
    """Cell centres of a window among the nodes, quadrilaterals between them as facets; last the nodes of the mesh.

    Parameters
    ----------
    window : Window
    """

    window: Window | None = None

    @property
    def is_window(self) -> bool:
        """True."""
        return True

    @property
    def _window(self) -> Window:
        assert self.window is not None
        return self.window

    @property
    def axes(self) -> tuple[Array, Array]:
        """Coordinates of the modelled cells along the window's directions."""
        return self._window.along

    @property
    def normal(self) -> Array:
        """Outward normal (3,) of the window."""
        return self._window.normal

    @cached_property
    def on_rim(self) -> Mask:
        """Mask (n_facets, 4) of the facets' sides on the rim; on a plane of symmetry the window goes on."""
        rim = super().on_rim.copy()
        ends = sides_of(self.facets) - self.start
        for place, mirrored in zip(np.divmod(ends, len(self.axes[1])), self._window.mirrored, strict=True):
            if mirrored:
                rim &= (place > 0).any(axis=2)
        return rim

    def project(self, points: Array, n_near: int = 3) -> Projection:
        """Projection along the window's normal of points (n, 3)."""
        window = self._window
        found = super().project(window.coordinates(points), n_near)
        assert found.weights is not None
        normals = np.tile(window.normal, (len(points), 1))
        plane = window.at(found.points[:, 0], found.points[:, 1])
        if window.depths is None:
            return replace(found, points=plane, normals=normals)
        depth = found.weights[:, self.start : self.start + len(window.depths)] @ window.depths
        return replace(found, points=plane - depth[:, None] * normals, normals=normals, gap=found.gap + depth)

    def moved(self, rotation: Array, translation: Array) -> Self:
        """The surface in other axes, rotated and translated."""
        window = self._window
        moved = replace(window, origin=rotation @ window.origin + translation, axes=rotation @ window.axes)
        return replace(super().moved(rotation, translation), window=moved)


def window_surface(window: Window, points: Array, name: str, start: int = 0) -> WindowSurface:
    """The surface of a window whose cells are from number `start` on among a body's points (n, 3)."""
    facets = between_cells(*window.shape) + start
    if np.linalg.det(window.axes) < 0:  # seen from the other side
        facets = facets[:, ::-1]
    return WindowSurface(points, facets, name, grid=window.grid, window=window, start=start)


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
            f"none beyond the window; {found}. Make it with periodic=False and pressure='uniform'.",
            code="local-body-coupling",
        )
    axes = pose.rotation @ other.axes * np.array([1.0, 1.0, -1.0])
    slopes = axes[2, :2] / axes[2, 2] if axes[2, 2] > 0 else np.full(2, np.inf)
    steepest = STEEPEST_LAYERED if half.layers else STEEPEST
    if np.linalg.norm(slopes) > steepest:
        raise InputError(
            f"The surface of {names[0]!r} inclines by {np.linalg.norm(slopes):.3g} to the window of {names[1]!r}; up "
            f"to {steepest:g} is possible. Put the window where the surfaces are parallel, or check the poses.",
            code="window-inclined",
        )
    across = [side for side, even, s in zip("xy", other.mirrored, slopes, strict=True) if even and abs(s) > OPPOSITE]
    if across:
        raise InputError(
            f"{names[1]!r} is modelled up to planes of symmetry, to which {names[0]!r} is not normal. Model the body "
            "without them, or check the poses.",
            code="not-normal-to-symmetry",
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
