"""Surfaces of triangles whose facets gmsh replaces by others of a wanted size, and tetrahedra within closed ones.

gmsh divides the surface along its sharp edges, maps each piece to a plane and meshes it there (Remacle, Geuzaine,
Compere and Marchandise (2010), *High-quality surface remeshing using harmonic maps*, Int. J. Numer. Meth. Engng 83,
403-425), so that the new facets have their corners on the old ones.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.apart import run_apart
from fecontact.mesh.build import build
from fecontact.mesh.gmsh_session import Sizes, generate, load_gmsh, raw_mesh, set_sizes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.orient import components
from fecontact.mesh.pick import shared_sides
from fecontact.mesh.shells import Shells
from fecontact.mesh.smooth_parts import SMOOTH

#: Angles (radians) between facets above which their side stays an edge of the mesh: the second one, at which none
#: does, where gmsh cannot map the pieces of the first, as on rough surfaces.
SHARP = (float(np.arccos(SMOOTH)), float(np.pi))
#: Note on a mesh of the second angle.
ROUNDED = "gmsh could not divide the surface along its sharp edges, so they are rounded off by an element"


def tetrahedra_within(
    points: Array, triangles: IntArray, shells: Shells, sizes: Sizes, source: str
) -> tuple[Mesh, IntArray]:
    """Linear tetrahedra within a closed surface, made by gmsh in a process of its own.

    Parameters
    ----------
    points : (n_points, 3) array
    triangles : (n, 3) int array
    shells : Shells
    sizes : Sizes
    source : str
        Name of the surface, for messages.

    Returns
    -------
    Mesh
        Boundaries 'surface_1', 'surface_2', ... from the largest: the parts of the surface between sharp edges, its
        whole where it has none. Element sets 'volume_1', ...: its solids.
    (n,) int array
        The part that each of the triangles belongs to, from 0.

    Raises
    ------
    MissingPackageError
    MeshError
        If gmsh fails; its message is passed on.
    """
    middle, unit = _unit(points)
    what, given = f"gmsh, which was to mesh {source},", ((points - middle) / unit, triangles, shells)
    mesh, part = run_apart(what, _meshed, *given, sizes.measured(middle, unit), source)
    return replace(mesh, points=unit * mesh.points + middle), part


def _unit(points: Array) -> tuple[Array, float]:
    """Middle (3,) of points and diagonal of their box: gmsh has tolerances in units of length."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low))


def facets_of_size(
    points: Array, triangles: IntArray, sizes: Sizes, source: str
) -> tuple[Array, IntArray, IntArray, IntArray, tuple[str, ...]]:
    """Other triangles on a surface, open or closed, with corners on the old ones; by gmsh in a process of its own.

    Parameters and errors as in `tetrahedra_within`.

    Returns
    -------
    points : (n_new_points, 3) array
    triangles : (n_new, 3) int array
    part_of_new, part : (n_new,) and (n,) int arrays
        The part between sharp edges that each new and each old triangle belongs to.
    notes : tuple of str
    """
    middle, unit = _unit(points)
    what, given = f"gmsh, which was to mesh {source},", ((points - middle) / unit, triangles)
    x, new, part_of_new, part, notes = run_apart(what, _remeshed, *given, sizes.measured(middle, unit), source)
    return unit * x + middle, new, part_of_new, part, notes


def _meshed(points: Array, triangles: IntArray, shells: Shells, sizes: Sizes, source: str) -> tuple[Mesh, IntArray]:
    """`tetrahedra_within` in the process that ends with it."""
    gmsh, entity, part, notes = _generated(points, triangles, shells, sizes, source)
    mesh = _named(build(raw_mesh(gmsh, source), source), entity, part)
    return replace(mesh, notes=(*mesh.notes, *notes)), part


def _remeshed(
    points: Array, triangles: IntArray, sizes: Sizes, source: str
) -> tuple[Array, IntArray, IntArray, IntArray, tuple[str, ...]]:
    """`facets_of_size` in the process that ends with it."""
    gmsh, entity, part, notes = _generated(points, triangles, None, sizes, source)
    tags, first = np.unique(entity, return_index=True)
    new = [np.reshape(gmsh.model.mesh.getElements(2, tag)[2][0], (-1, 3)) for tag in tags]
    ids, coordinates, _ = gmsh.model.mesh.getNodes()
    of = np.repeat(part[first], [len(t) for t in new])
    used, number = np.unique(np.concatenate(new), return_inverse=True)
    order = np.argsort(ids)
    x = np.reshape(coordinates, (-1, 3))[order[np.searchsorted(ids[order], used)]]
    return x, number.reshape(-1, 3), of, part, notes


def _generated(
    points: Array, triangles: IntArray, shells: Shells | None, sizes: Sizes, source: str
) -> tuple[Any, IntArray, IntArray, tuple[str, ...]]:
    """The module gmsh with the new mesh, the entity and part (n,) of each old triangle, and notes."""
    gmsh = load_gmsh()
    gmsh.initialize(["fecontact"], readConfigFiles=False)
    said = ""
    for angle in SHARP:
        try:
            entity = _classified(gmsh, points, triangles, angle)
            set_sizes(gmsh, sizes)
            if shells is not None:
                _add_solids(gmsh, entity, shells)
            generate(gmsh, quadratic=False, dimension=2 if shells is None else 3)
            _refuse_empty(gmsh)
        except Exception as error:  # gmsh raises plain Exception with its message
            said = said or str(error)
            continue
        notes = (f"{source}: {ROUNDED}.",) if angle != SHARP[0] else ()
        return gmsh, entity, _parts(points, triangles, entity, angle), notes
    raise MeshError(
        f"gmsh could not mesh {source}: {said} Smaller elements follow the surface better, and a smoother surface has "
        "fewer sharp edges (fc.repair_surface)."
    )


def _classified(gmsh: Any, points: Array, triangles: IntArray, angle: float) -> IntArray:
    """Give gmsh the surface, divided along its sharp edges; the entity (n,) of each triangle."""
    gmsh.clear()
    gmsh.model.add("fecontact")
    gmsh.model.addDiscreteEntity(2, 1)
    gmsh.model.mesh.addNodes(2, 1, np.arange(1, len(points) + 1), points.ravel())
    gmsh.model.mesh.addElementsByType(1, 2, np.arange(1, len(triangles) + 1), (triangles + 1).ravel())
    gmsh.model.mesh.classifySurfaces(angle, True, True, np.pi)
    entity = np.zeros(len(triangles), np.int64)
    for _, tag in gmsh.model.getEntities(2):
        entity[np.asarray(gmsh.model.mesh.getElements(2, tag)[1][0], dtype=np.int64) - 1] = tag
    gmsh.model.mesh.createGeometry()
    return entity


def _add_solids(gmsh: Any, entity: IntArray, shells: Shells) -> None:
    loop = [gmsh.model.geo.addSurfaceLoop(np.unique(entity[shells.shell == k])) for k in range(shells.shell.max() + 1)]
    for solid in shells.solids:
        gmsh.model.geo.addVolume([loop[k] for k in solid])
    gmsh.model.geo.synchronize()


def _refuse_empty(gmsh: Any) -> None:
    """Refuse a solid without cells: gmsh goes on where its new facets cross."""
    if not all(gmsh.model.mesh.getElementTypes(3, tag).size for _, tag in gmsh.model.getEntities(3)):
        raise MeshError(gmsh.logger.getLastError() or "its new facets enclose no solid.")


def _parts(points: Array, triangles: IntArray, entity: IntArray, angle: float) -> IntArray:
    """Part (n,) of each triangle: entities that meet at a side that is not sharp are one; numbered from the largest."""
    facets = triangles[:, [0, 1, 2, 2]]
    first, second, cosine = shared_sides(points, facets, None)
    pairs = np.stack([first // 4, second // 4], axis=1)[cosine > np.cos(angle)]
    tags, number = np.unique(entity, return_inverse=True)
    part = components(len(tags), number[pairs])[number]
    x = points[triangles]
    area = np.bincount(part, np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1))
    rank = np.empty(len(area), np.int64)
    rank[np.argsort(-area, kind="stable")] = np.arange(len(area))
    return rank[part]


def _named(mesh: Mesh, entity: IntArray, part: IntArray) -> Mesh:
    """The mesh with a boundary for each part instead of each entity."""
    tags, first = np.unique(entity, return_index=True)
    faces = [mesh.boundaries[f"surface_{tag}"] for tag in tags]
    of = part[first]
    names = {
        f"surface_{k + 1}": np.concatenate([f for f, p in zip(faces, of, strict=True) if p == k]) for k in np.unique(of)
    }
    groups = {f"volume_{k + 1}": members for k, members in enumerate(mesh.groups.values())}
    return replace(mesh, boundaries=names, groups=groups)
