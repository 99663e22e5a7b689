"""Bodies of a result or a VTU file for pictures: meshes and fields, selection and cuts.

Patches of rigid surfaces near contacts, for pictures.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, cast

import numpy as np

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arguments import text, texts
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, did_you_mean
from fecontact.common.material import VOIGT
from fecontact.mesh.kinds import BY_MESHIO, KINDS
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh, counter_clockwise
from fecontact.results.files import body_fields, window_patches

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult

COMPONENTS = {3: ("x", "y", "z"), 6: VOIGT}
#: Distance of a window's cells over the faces below them, which are not exact, relative to the window.
LIFT = 0.01
CUT = re.compile(r"\s*([xyz])\s*([<>])\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*")


@dataclass(frozen=True, eq=False)
class Patch:
    """Quadrilaterals that lie on a body, drawn over its faces.

    Attributes
    ----------
    points : (n, 3) array
    cells : (m, 8) int array
    """

    points: Array
    cells: IntArray
    is_flat: ClassVar[bool] = False

    @property
    def skin(self) -> IntArray:
        """All of its facets."""
        return self.cells

    def native_cells(self) -> list[tuple[str, IntArray, IntArray]]:
        """None: it has no solid cells."""
        return []


@dataclass(frozen=True, eq=False)
class Solid:
    """A body to show.

    Attributes
    ----------
    name : str
    mesh : Mesh, SectionMesh or Patch
        Mesh with points in the world.
    fields : mapping of str to (n_points,) or (n_points, k) arrays
    rise : (3,) array
        By how much its displacement is shown larger, so that a patch stays over faces that are displaced less finely.
    """

    name: str
    mesh: Mesh | SectionMesh | Patch
    fields: Mapping[str, Array]
    rise: Array = field(default_factory=partial(np.zeros, 3))

    def deformed(self, scale: float) -> Array:
        """Points (n_points, 3) with `scale` times the displacement added."""
        if scale == 0 or "displacement" not in self.fields:
            return self.mesh.points
        return np.asarray(self.mesh.points + scale * (self.fields["displacement"] + self.rise))

    def scalar(self, name: str) -> Array:
        """A scalar field (n_points,): a scalar, the length of a vector, or a component such as ``stress_xx``.

        Raises
        ------
        InputError
            If there is no such field; the message lists the existing ones.
        """
        if name in self.fields and self.fields[name].ndim == 1:
            return self.fields[name]
        if name in self.fields and self.fields[name].shape[1] == 3:
            return np.asarray(np.linalg.norm(self.fields[name], axis=1))
        whole, _, component = name.rpartition("_")
        names = COMPONENTS.get(self.fields[whole].shape[-1], ()) if whole in self.fields else ()
        if component in names:
            return np.asarray(self.fields[whole][:, names.index(component)])
        known = _scalar_names(self.fields)
        hint = did_you_mean(name, known)
        raise InputError(
            f"There is no field {name!r}{hint}{'?' if hint else '.'} The fields are: {', '.join(known)}.",
            code="unknown-field",
        )


def _scalar_names(fields: Mapping[str, Array]) -> list[str]:
    out = []
    for name, values in fields.items():
        columns = values.shape[1] if values.ndim == 2 else 1
        if columns in (1, 3):
            out.append(name)
        out += [f"{name}_{c}" for c in COMPONENTS.get(columns, ())]
    return out


def solids_of_result(result: ContactResult) -> tuple[Solid, ...]:
    """The bodies of a result that have a mesh, in the world, then the windows of local bodies.

    Raises
    ------
    InputError
        If there is none.
    """
    if not result._meshed_bodies:
        raise InputError(
            "No body of this scene is meshed inside; only its contacts can be drawn: plot 'pressure' or 'gap' instead.",
            code="nothing-to-draw",
        )
    bodies = [
        Solid(b.name, b.mesh.drawn_at(result._given_points(b)), body_fields(result, b)) for b in result._meshed_bodies
    ]
    for p in window_patches(result):
        bodies.append(patch_solid(p.body.name, result._given(p.body).pose.to_world(p.points), p.quads, p.fields))
    return tuple(bodies)


def patch_solid(name: str, points: Array, quads: IntArray, fields: Mapping[str, Array]) -> Solid:
    """Quadrilaterals (m, 4) with nodal fields as a body to show, with the middles of their sides, lifted a little."""
    corners = points[quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]).sum(axis=0)
    normal /= np.linalg.norm(normal)
    lifted = points + LIFT * float(np.ptp(points, axis=0).max()) * normal
    rise = float(np.ptp(fields["displacement"] @ normal)) * normal if "displacement" in fields else np.zeros(3)

    def with_middles(values: Array) -> Array:
        sides = (values[quads] + values[np.roll(quads, -1, axis=1)]) / 2
        return np.concatenate([values, sides.reshape(-1, *values.shape[1:])])

    middles = len(points) + np.arange(4 * len(quads)).reshape(-1, 4)
    cells = np.concatenate([quads, middles], axis=1)
    return Solid(name, Patch(with_middles(lifted), cells), {k: with_middles(v) for k, v in fields.items()}, rise)


def solids_of_file(path: str | Path) -> tuple[Solid, ...]:
    """The bodies in a VTU file, as `ContactResult.save` writes it; other solid meshes are shown as one body.

    Raises
    ------
    InputError
        If the file does not exist, cannot be read, or holds no solid cells.
    """
    from fecontact.mesh.formats.generic import load

    path = Path(path)
    if not path.is_file():
        raise InputError(f"Cannot show {path}: there is no such file.", code="no-file")
    import meshio

    file, _ = load(path, meshio.read)
    numbers = file.cell_data.get("body", [np.zeros(len(block.data), dtype=np.int64) for block in file.cells])
    fields = {name: np.asarray(values, dtype=float) for name, values in file.point_data.items()}
    out: list[Solid] = []
    # cells with the same number of nodes are one mesh of mixed kinds, so that faces between them are not outer ones
    parts: dict[tuple[int, int], list[IntArray]] = {}
    patches: list[Solid] = []
    for block, number in zip(file.cells, numbers, strict=True):
        for k in np.unique(number).tolist():
            cells = np.asarray(block.data)[number == k]
            if block.type == "quad":
                used, cells = np.unique(cells, return_inverse=True)
                own = {name: values[used] for name, values in fields.items()}
                patches.append(patch_solid(str(k), file.points[used], cells.reshape(-1, 4), own))
            elif block.type in SectionMesh.cell_types.values():
                used, cells = np.unique(cells, return_inverse=True)
                cells = counter_clockwise(file.points[used], cells.reshape(-1, block.data.shape[1]))
                section = SectionMesh(file.points[used], cells)
                out.append(Solid(str(k), section, {name: values[used] for name, values in fields.items()}))
            elif block.type in BY_MESHIO:
                cells = BY_MESHIO[block.type].to_hexahedra(cells)
                parts.setdefault((k, cells.shape[1]), []).append(cells)
    out += [Solid(str(k), Mesh(file.points, np.concatenate(cells)), fields) for (k, _), cells in parts.items()]
    if not out:
        found = ", ".join(sorted({block.type for block in file.cells})) or "nothing"
        raise InputError(f"Cannot show {path}: it holds no solid cells (found {found}).")
    return (*out, *patches)


def cut(solid: Solid, where: str) -> Solid | None:
    """The cells whose centres satisfy a condition such as ``"x<0"``, with their inner faces exposed; None if none does.

    Tetrahedra, whose faces inside follow no plane, are cut at it, with straight sides; fields are linear along edges.

    Raises
    ------
    InputError
        If the condition cannot be read.
    """
    found = CUT.fullmatch(where)
    if found is None:
        raise InputError(f"A cut reads like 'x<0' or 'z>12.5', for the part to keep; found {where!r}.", code="no-cut")
    if solid.mesh.is_flat:
        raise InputError("A section shows its inside already: there is nothing to cut open.", code="section-not-cut")
    axis, sign, level = "xyz".index(found[1]), found[2], float(found[3])
    kinds = solid.mesh.native_cells()
    if kinds and all(name.startswith("tetra") for name, _, _ in kinds):
        corners = np.concatenate([cells[:, :4] for _, cells, _ in kinds])
        height = solid.mesh.points[:, axis] - level
        return _part_of_tetrahedra(solid, corners, -height if sign == "<" else height)
    centre = solid.mesh.points[solid.mesh.cells[:, :8]].mean(axis=1)[:, axis]
    kept = centre < level if sign == "<" else centre > level
    if not kept.any():
        return None
    return replace(solid, mesh=type(solid.mesh)(solid.mesh.points, solid.mesh.cells[kept]))


#: Of a tetrahedron whose first 1 to 4 corners are kept: its part, with corners (i, i) and points of edges (i, j).
_PARTS = {
    1: ("tet4", ((0, 0), (0, 1), (0, 2), (0, 3))),
    2: ("wedge6", ((0, 0), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3))),
    3: ("wedge6", ((0, 0), (1, 1), (2, 2), (0, 3), (1, 3), (2, 3))),
    4: ("tet4", ((0, 0), (1, 1), (2, 2), (3, 3))),
}
#: Orders of the corners that keep the orientation.
_TURNS = np.array([p for p in itertools.permutations(range(4)) if np.linalg.det(np.eye(4)[list(p)]) > 0])


def _part_of_tetrahedra(solid: Solid, corners: IntArray, height: Array) -> Solid | None:
    """The part of tetrahedra (n, 4) at positive heights (n_points,); None where there is none."""
    kept = height[corners[:, _TURNS]] > 0
    first = np.argmax((kept[..., :-1] >= kept[..., 1:]).all(axis=2), axis=1)
    corners, count = np.take_along_axis(corners, _TURNS[first], axis=1), kept[:, 0].sum(axis=1)
    if not count.any():
        return None
    ends = [corners[count == k][:, np.array(pairs)] for k, (_, pairs) in _PARTS.items()]
    edges, number = np.unique(np.sort(np.concatenate([e.reshape(-1, 2) for e in ends])), axis=0, return_inverse=True)
    one, other = height[edges].T
    share = np.divide(one, one - other, out=np.zeros(len(edges)), where=edges[:, 0] != edges[:, 1])
    begins = np.split(number.ravel(), np.cumsum([e.shape[0] * e.shape[1] for e in ends])[:-1])
    parts = zip(_PARTS.values(), begins, strict=True)
    cells = [KINDS[kind].to_hexahedra(own.reshape(-1, len(pairs))) for (kind, pairs), own in parts]

    def between(values: Array) -> Array:
        a, b = values[edges[:, 0]], values[edges[:, 1]]
        return np.asarray(a + share.reshape(-1, *[1] * (values.ndim - 1)) * (b - a))

    fields = {name: between(values) for name, values in solid.fields.items()}
    return replace(solid, mesh=Mesh(between(solid.mesh.points), np.concatenate(cells)), fields=fields)


def chosen(solids: Sequence[Solid], only: Sequence[str] | None, where: str | None) -> tuple[Solid, ...]:
    """The named bodies, cut.

    Raises
    ------
    InputError
        For an unknown body, or if no cell is left.
    """
    names = list(dict.fromkeys(s.name for s in solids))
    only = None if only is None else texts("the bodies", only)
    if where is not None:
        text("the cut", where)
    if unknown := [n for n in only or () if n not in names]:
        raise InputError(f"There is no body {unknown[0]!r} to show; the bodies are: {', '.join(names)}.", code="unseen")
    left = [s for s in solids if not only or s.name in only]
    shown = left if where is None else [c for c in (cut(s, where) for s in left) if c is not None]
    if not shown:
        raise InputError(f"The cut {where!r} leaves nothing to show.", code="empty-cut")
    return tuple(shown)


#: Half side of a patch over the largest distance of the contact's points from its middle.
MARGIN = 1.3
#: Quadrilaterals per side of a patch.
PIECES = 24
#: Side of a quadrilateral over that of the grid in the tangent plane above which it crosses a fold or jump.
STRETCH = 3.0


def rigid_patches(result: ContactResult, scale: float) -> tuple[Array, IntArray]:
    """Points (n, 3) and quadrilaterals (n_quads, 4) of the rigid surfaces of a result, where bodies touch them.

    Parameters
    ----------
    result : ContactResult
    scale : float
        Factor of displacements and rigid motions.
    """
    points, quads, start = [np.zeros((0, 3))], [np.zeros((0, 4), np.int64)], 0
    for contact in result.contacts:
        if contact.master.is_rigid and not contact._is_curve:
            motion = result._state.motions[result.scene.bodies.index(contact.master)]
            nearest = contact.points[[np.argmin(contact.gap)]]
            x, q = rigid_patch(contact.master, contact.surfaces[1], nearest, contact.nodes)
            begin = result._given(contact.master).pose.to_world(contact.master.pose.to_body(x))
            end = x + motion[:3] + np.cross(motion[3:], x - contact.master.pose.translation)
            points.append(begin + scale * (end - begin))
            quads.append(q + start)
            start += len(x)
    return np.concatenate(points), np.concatenate(quads)


def meshed_among(bodies: Sequence[Body]) -> list[ElasticBody]:
    """Those of some bodies that have a mesh, local ones among them."""
    return [cast(ElasticBody, b) for b in bodies if b._at_points(np.zeros(b.n_dofs)) is not None]


def rigid_patch(body: Body, name: str, nearest: Array, nodes: Array) -> tuple[Array, IntArray]:
    """Points (n, 3) and quadrilaterals (m, 4) of a surface near nodes (k, 3) of another, in the world.

    A grid in the tangent plane at the nearest point (1, 3) is projected; what is outside the surface is left out.
    """
    shape = body.surface(name)
    foot = shape.project(body.pose.to_body(nearest))
    normal = foot.normals[0]
    along = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(normal, along) / np.linalg.norm(np.cross(normal, along))
    axes = np.stack([first, np.cross(normal, first)])
    offsets = (body.pose.to_body(nodes) - foot.points) @ axes.T
    half = MARGIN * np.abs(offsets).max()
    t = half * np.linspace(-1.0, 1.0, PIECES + 1)
    grid = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2) @ axes + foot.points
    projection = shape.project(grid)
    index = np.arange((PIECES + 1) ** 2).reshape(PIECES + 1, PIECES + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    corners = projection.points[quads]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    kept = ~projection.outside[quads].any(axis=1) & (longest < STRETCH * 2 * half / PIECES)
    return body.pose.to_world(projection.points), quads[kept]
