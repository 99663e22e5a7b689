"""Grids of cells on the surfaces of local bodies, with their fields, for files and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from fecontact.bodies.halfspace.surface import GridSurface
from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array, IntArray
from fecontact.contact.interface import Interface
from fecontact.fem.stress import von_mises
from fecontact.results.contact_fields import ContactFields
from fecontact.results.solved_scene import SolvedScene
from fecontact.surfaces.facet_surface import has_cells

LINES = 32
"""Lines of cells along a side at which displacement and stress are evaluated; between them they are interpolated."""


@dataclass(frozen=True, eq=False)
class WindowPatch:
    """The cells of a contact on a body with a mesh.

    Attributes
    ----------
    body : Body
    points : (n, 3) array
        Centres of the cells, in the body's own axes.
    quads : (m, 4) int array
        Quadrilaterals between them.
    fields : mapping of str to (n,) or (n, k) arrays
        Those of `files.body_fields`, and the gap.
    """

    body: Body
    points: Array
    quads: IntArray
    fields: Mapping[str, Array]


def on_window(result: SolvedScene, interface: Interface) -> bool:
    """Whether the contact of an interface is on cells of a body with a mesh."""
    k = result.scene.bodies.index(interface.slave)
    meshed = interface.slave.at_points(result.state.displacements[k]) is not None
    return meshed and has_cells(interface.slave_surface)


def window_patches(result: SolvedScene) -> Iterator[WindowPatch]:
    """The patches of all contacts on windows of local bodies."""
    for interface, contact in zip(result.interfaces, result.contacts, strict=True):
        if on_window(result, interface):
            yield _patch(result, interface, contact)


def _patch(result: SolvedScene, interface: Interface, contact: ContactFields) -> WindowPatch:
    body, surface, shown = interface.slave, interface.slave_surface, contact.node_numbers
    u, stress = _inside(result, interface, shown)
    pressure, gap = (contact.at_nodes @ values for values in (contact.pressure, contact.gap))
    fields = {
        "displacement": u,
        "stress": stress,
        "von_mises": von_mises(stress),
        "contact_pressure": pressure,
        "contact_pressure_error": np.zeros(len(shown)),
        "gap": gap,
    }
    return WindowPatch(body, surface.points[shown], contact.facets, fields)


def _inside(result: SolvedScene, interface: Interface, shown: IntArray) -> tuple[Array, Array]:
    """Displacement in world axes (n, 3) and stress (n, 6) at cells (n,) of a window."""
    surface = cast(GridSurface, interface.slave_surface)
    first = int(surface.facets.min())
    shape = tuple(len(x) for x in surface.axes)
    lines = [np.unique(np.linspace(0, n - 1, min(n, LINES)).round().astype(int)) for n in shape]
    number = first + np.add.outer(lines[0] * shape[1], lines[1])
    found = result.fields_at(interface.slave, surface.points[number.ravel()])
    values = np.concatenate(found, axis=1).reshape(*number.shape, -1)
    cells = np.stack(np.divmod(shown - first, shape[1]), axis=1)
    between = RegularGridInterpolator(tuple(map(np.asarray, lines)), values)(cells)
    return between[:, :3], between[:, 3:]
