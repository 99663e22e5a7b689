"""Surface of a local body in a scene: the cells of its window."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from fecontact.bodies.halfspace.surface import GridSurface, between_cells
from fecontact.bodies.local.window import Window
from fecontact.common.arrays import Array, Mask
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
        ends = np.stack([self.facets, np.roll(self.facets, -1, axis=1)], axis=2) - self.start
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
