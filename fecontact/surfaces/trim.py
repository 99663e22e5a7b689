"""Parts of surfaces and solids on one side of a plane, within a box or a sphere, closed again.

Manifold (Lalish, E. (2023), *Manifold: a library for robust Boolean operations on triangle meshes*) cuts the facets.
"""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import flag, instance
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import point_array, positive
from fecontact.common.errors import InputError, MissingPackageError
from fecontact.mesh.mending import bisected
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import closed_components
from fecontact.mesh.surface_mesh import SurfaceMesh, joined
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.repair import fans, triangulated
from fecontact.surfaces.solid import mesh_solid

P = TypeVar("P", bound=Mesh | SurfaceMesh)

#: Sides of a circle round a sphere, and volume, relative, that counts as none.
SIDES, NOTHING = 128, 1e-12
#: Parts of a part's size to which facets are divided, so that each is found by nodes near it.
NEAR = 90


def trimmed(
    part: P,
    *,
    plane: tuple[ArrayLike, ArrayLike] | None = None,
    box: tuple[ArrayLike, ArrayLike] | None = None,
    sphere: tuple[ArrayLike, float] | None = None,
    outside: bool = False,
    size: float | None = None,
) -> P:
    """What lies behind a plane, or within a box or a sphere, closed by new facets there.

    Parameters
    ----------
    part : SurfaceMesh or Mesh
        A closed surface, or a solid: its skin is trimmed and meshed anew by `mesh_solid`, with tetrahedra.
    plane : (point, normal), optional
        What lies against the normal is kept.
    box : (low, high), optional
        Two opposite corners, edges along the axes.
    sphere : (centre, radius), optional
        As a polyhedron of 128 sides round the equator.
    outside : bool
        Keep the rest instead.
    size : float, optional
        Edge length of a solid's new elements, as in `mesh_solid`.

    Returns
    -------
    SurfaceMesh or Mesh
        Of triangles; boundary 'cut' of a solid has its new faces, the others are what is left of the old ones. Element
        sets and node sets are left out, with a note.

    Raises
    ------
    MissingPackageError
        Without manifold3d.
    InputError
        Unless one of the three is given; if nothing or everything lies within it; for a surface with `size`.
    MeshError
        If the surface is open or runs through itself; as `mesh_solid`.

    Examples
    --------
    >>> import fecontact as fc
    >>> block = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2), element="hex8")
    >>> skin = fc.SurfaceMesh(block.points, block.skin)
    >>> trimmed(skin, plane=((0.5, 0, 0), (1, 0, 0))).areas.sum().round(9)  # doctest: +SKIP
    4.0
    """
    instance("the part to trim", part, (Mesh, SurfaceMesh))
    flag("outside", outside)
    if size is not None and isinstance(part, SurfaceMesh):
        raise InputError(
            "size= is of a solid's new elements; the facets of a surface are only cut (fc.repair_surface)."
        )
    surface = part if isinstance(part, SurfaceMesh) else SurfaceMesh(part.points, part.skin, part.notes)
    points, triangles = triangulated(surface)
    closed_components(points, triangles, "the surface")
    x, new, origin = _cut(points, triangles, {"plane": plane, "box": box, "sphere": sphere}, outside)
    after = replace(joined(x, new[:, [0, 1, 2, 2]]), notes=surface.notes)
    if isinstance(part, SurfaceMesh):
        return cast(P, after)
    mesh = mesh_solid(after, size, "tet10" if part.cells.shape[1] > 8 else "tet4")
    sets = {"element sets": part.groups, "node sets": part.node_sets}
    left = " and ".join(f"{len(members)} {what}" for what, members in sets.items() if members)
    notes = (*mesh.notes, f"trimmed: {left} of the mesh were left out.") if left else mesh.notes
    return cast(P, replace(mesh, boundaries=_named(mesh, part, x, new, origin), notes=notes))


def _cut(
    points: Array, triangles: IntArray, cutters: dict[str, Any], outside: bool
) -> tuple[Array, IntArray, IntArray]:
    """Points, triangles (n, 3) and the number (n,) of the old triangle each is of; -1 on the cutter."""
    if importlib.util.find_spec("manifold3d") is None:
        raise MissingPackageError("Trimming needs the package manifold3d: pip install 'fecontact[solids]'.")
    import manifold3d as m3

    kind, value = _only(cutters)
    own = m3.Manifold.reserve_ids(1)
    number = np.arange(len(triangles), dtype=np.uint64)
    middle = points.mean(axis=0)
    solid = m3.Manifold(
        m3.Mesh64(
            vert_properties=np.ascontiguousarray(points - middle),
            tri_verts=triangles.astype(np.uint64),
            run_index=np.array([0, triangles.size], dtype=np.uint64),
            run_original_id=np.array([own], dtype=np.uint32),
            face_id=number,
        )
    )
    if kind == "plane":
        # what lies along a normal is kept
        normal = value[1] if outside else -value[1]
        left = solid.trim_by_plane(normal.tolist(), float(normal @ (value[0] - middle)) / float(np.linalg.norm(normal)))
    else:
        shape = (
            m3.Manifold.sphere(value[1], SIDES)
            if kind == "sphere"
            else m3.Manifold.cube((value[1] - value[0]).tolist())
        )
        shape = shape.translate((value[0] - middle).tolist())
        left = solid - shape if outside else solid ^ shape
    share = left.volume() / solid.volume()
    if not NOTHING < share < 1 - NOTHING:
        what = "Nothing" if share < 0.5 else "Everything"
        raise InputError(f"{what} is left of the part by this {kind}; its box is {points.min(0)} to {points.max(0)}.")
    mesh = left.to_mesh64()
    run = np.searchsorted(np.asarray(mesh.run_index), 3 * np.arange(len(mesh.tri_verts)), side="right") - 1
    origin = np.where(np.asarray(mesh.run_original_id)[run] == own, np.asarray(mesh.face_id, dtype=np.int64), -1)
    return np.asarray(mesh.vert_properties)[:, :3] + middle, np.asarray(mesh.tri_verts, dtype=np.int64), origin


def _only(cutters: dict[str, Any]) -> tuple[str, Any]:
    """The cutter that is given, checked, by its name."""
    given = [name for name, value in cutters.items() if value is not None]
    if len(given) != 1:
        raise InputError(f"Give one of plane, box and sphere; found {' and '.join(given) or 'none'}.")
    kind = given[0]
    try:
        first, second = cutters[kind]
    except (TypeError, ValueError):
        raise InputError(f"{kind} must be a pair; found {cutters[kind]!r}.") from None
    start = point_array(f"the first of {kind}", first, 3)
    if kind == "sphere":
        return kind, (start, positive("the radius", second))
    end = point_array(f"the second of {kind}", second, 3)
    if kind == "box" and not (end > start).all():
        raise InputError(f"The corners of a box must be low and high in each axis; found {start} and {end}.")
    if kind == "plane" and not end.any():
        raise InputError("The normal of a plane must not be zero.")
    return kind, (start, end)


def _named(mesh: Mesh, old: Mesh, points: Array, triangles: IntArray, origin: IntArray) -> dict[str, IntArray]:
    """Boundaries of a mesh by the triangles (n, 3) under its faces and what these are of (n,); -1: of the cut."""
    size = float(np.linalg.norm(np.ptp(points, axis=0))) / NEAR
    x, facets, whole = bisected(points, triangles, size)
    under = FacetSurface(x, facets).project(mesh.points[mesh.skin[:, :3]].mean(axis=1)).facet
    assert under is not None
    of = origin[whole[under]]
    facet_of = fans(old.skin)[1]
    number = old.outer @ np.array([6, 1])
    out = {"cut": of < 0}
    for name in old.boundaries:
        own = np.isin(number, old.faces(name) @ np.array([6, 1]))[facet_of]
        out[name] = (of >= 0) & own[of] | out.get(name, False)
    return {name: mesh.outer[faces] for name, faces in out.items() if faces.any()}
