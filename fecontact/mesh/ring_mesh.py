"""Ring meshes: a square core on the axis, rings round it, and repetition of a quarter to a half or whole body."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.mesh.grading import RingGrading
from fecontact.mesh.mesh import Mesh, merge
from fecontact.mesh.patches import Curve
from fecontact.mesh.structured import lattice

SECTORS = {"quarter": 1, "half": 2, "full": 4}


def disc(n_layers: int, ring: RingGrading, names: Mapping[str, str | None], element: str) -> tuple[Mesh, Mesh]:
    """Quarter disc times layers in plan coordinates (x, y, layer index): the core and the rings."""
    m, radii = ring.core, ring.radii
    top, bottom, side = names["top"], names["bottom"], names["side"]
    core = lattice((m, m, n_layers), ("sym_x", None, "sym_y", None, top, bottom), element)
    rings = lattice((2 * m, len(radii), n_layers), ("sym_y", "sym_x", None, side, top, bottom), element)
    # the corner of the square core lies on its circle, so that all angles round it are obtuse
    c, d = ring.core_radius, ring.core_radius * np.sqrt(0.5)

    def boundary(j: Array) -> Array:
        """Outer side of the core for ring index j in [0, 2m]: (c, 0) to (d, d) to (0, c)."""
        v = np.minimum(j, 2 * m - j) / m
        x, y = c + (d - c) * v, d * v
        return np.where((j <= m)[:, None], np.stack([x, y], 1), np.stack([y, x], 1))

    def core_plan(index: Array) -> Array:
        u, v = index[:, 0] / m, index[:, 1] / m
        x = c * u + (d - c) * u * v
        y = c * v + (d - c) * u * v
        return np.stack([x, y, index[:, 2]], 1)

    def ring_plan(index: Array) -> Array:
        j, k = index[:, 0], index[:, 1]
        angle = np.pi / 2 * j / (2 * m)
        direction = np.stack([np.cos(angle), np.sin(angle)], 1)
        direction[angle == np.pi / 2] = (0.0, 1.0)
        r = np.interp(k, np.arange(1, len(radii) + 1), radii)
        inner = np.minimum(k, 1.0)[:, None]
        xy = np.where(inner < 1, (1 - inner) * boundary(j) + inner * radii[0] * direction, r[:, None] * direction)
        return np.stack([xy[:, 0], xy[:, 1], index[:, 2]], 1)

    # the ring lattice runs (around, outwards, down): left-handed against (x, y, down), corrected by `right_handed`
    return core.mapped(core_plan), rings.mapped(ring_plan)


def revolved(mesh: Mesh, patch: Callable[[Array, Array], Array], s_of: Curve, t_of: Curve) -> Mesh:
    """Points in space from plan coordinates (x, y, layer index), by a meridian map (s, t) -> (rho, z)."""

    def shape(plan: Array) -> Array:
        r = np.hypot(plan[:, 0], plan[:, 1])
        meridian = patch(s_of(r), t_of(plan[:, 2]))
        stretch = np.divide(meridian[:, 0], r, out=np.zeros_like(r), where=r > 0)
        return np.stack([stretch * plan[:, 0], stretch * plan[:, 1], meridian[:, 1]], 1)

    return mesh.mapped(shape)


def right_handed(mesh: Mesh) -> Mesh:
    """Reorder left-handed cells (corner test; the shapes have no folded cells)."""
    x = mesh.points[mesh.cells[:, :8]]
    det = np.einsum(
        "ni,ni->n", np.cross(x[:, [1]] - x[:, [0]], x[:, [3]] - x[:, [0]])[:, 0], x[:, 4:].mean(1) - x[:, :4].mean(1)
    )
    left = det < 0
    if not left.any():
        return mesh
    swap_nodes = [4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19, 20, 21, 22, 23, 25, 24, 26]
    n = mesh.cells.shape[1]
    cells = mesh.cells.copy()
    cells[left] = cells[left][:, swap_nodes[:n]]
    swap_faces = np.array([0, 1, 2, 3, 5, 4])
    boundaries = {
        k: np.stack([f[:, 0], np.where(left[f[:, 0]], swap_faces[f[:, 1]], f[:, 1])], 1)
        for k, f in mesh.boundaries.items()
    }
    return replace(mesh, cells=cells, boundaries=boundaries)


def repeated(quarter: Mesh, sector: str, tolerance: float) -> Mesh:
    """Half (y >= 0) or full body from a quarter model (x, y >= 0), by rotating and joining it."""
    among("sector", sector, SECTORS)
    quarter = right_handed(quarter)
    if sector == "quarter":
        return quarter
    turns = []
    for k in range(SECTORS[sector]):
        cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][k]
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        turned = replace(quarter, points=quarter.points @ turn.T)
        # a quarter turn brings the plane y = 0 to x = 0 and back; only y = 0 is left as a boundary of the half
        names = {"sym_x": "sym_y", "sym_y": "sym_x"} if k % 2 else {}
        turns.append(replace(turned, boundaries={names.get(n, n): f for n, f in turned.boundaries.items()}))
    return merge(turns, tolerance)
