"""Deformed ANCF solids as lines, shaded sides and pressure fields, for plane pictures.

Edges are cubic and sides bend: both are sampled by the element's functions, so that a picture shows the computed shape
instead of the polygon of its nodes.

ANCF motions for ParaView: one VTU file per frame and a PVD file that lists them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import meshio
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection

from fecontact.ancf.bricks.faces import Faces
from fecontact.ancf.bricks.hexahedron import face_points
from fecontact.ancf.bricks.solid import AncfSolid
from fecontact.ancf.bricks.space import AncfSpace
from fecontact.ancf.system.assembly import Assembly
from fecontact.ancf.system.statics import State
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable, replacing, write_collection
from fecontact.common.material import von_mises
from fecontact.mesh.element import CORNERS, EDGES, FACES, quad_nodes
from fecontact.mesh.facets import sides_of

#: Points along each edge of a picture.
SAMPLES = 9
#: Triangles between the nodes of a face, counter-clockwise: corners, middles of sides, its middle.
TRIANGLES = np.array([t for k in range(4) for t in ((k, 4 + k, 8), (4 + k, (k + 1) % 4, 8))])
#: Patches of one colour along each side of a face.
PATCHES = 16


def edges(space: AncfSpace, q: Array, boundary: str | None = None, samples: int = SAMPLES) -> Array:
    """Distinct deformed edges (n, samples, 3) of the cells.

    Parameters
    ----------
    space : AncfSpace
    q : (n_dofs,) array
    boundary : str, optional
        Only edges of the faces of this boundary.
    samples : int
        Points along each edge.

    Raises
    ------
    InputError
        For a boundary that the mesh does not have.

    Examples
    --------
    >>> from fecontact import shapes
    >>> space = AncfSpace(shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
    >>> edges(space, space.q0).shape, edges(space, space.q0, "x_min").shape
    ((20, 9, 3), (4, 9, 3))
    """
    nodes = space.corners[:, EDGES].reshape(-1, 2)
    cell, edge = np.divmod(np.arange(len(nodes)), len(EDGES))
    if boundary is not None:
        at, face = space.mesh.faces(boundary).T
        belongs = np.array([np.isin(EDGES, corners).all(axis=1) for corners in FACES[:, :4]])
        kept = np.zeros((len(space.corners), len(EDGES)), dtype=bool)
        np.logical_or.at(kept, at, belongs[face])
        rows = np.flatnonzero(kept.ravel())
        nodes, cell, edge = nodes[rows], cell[rows], edge[rows]
    _, first = np.unique(np.sort(nodes, axis=1), axis=0, return_index=True)
    t = np.linspace(0.0, 1.0, samples)[:, None]
    ends = CORNERS[EDGES[edge[first]]]
    X = ends[:, :1] * (1 - t) + ends[:, 1:] * t
    return space.points_at(q, np.repeat(cell[first], samples), X.reshape(-1, 3)).reshape(-1, samples, 3)


def multiplier_pressure(
    faces: Faces, q: Array, forces: Array, *, averaged: bool = False
) -> tuple[Array, IntArray, Array]:
    """Deformed nodes (n, 3) of multipliers and face middles, triangles (8 n_faces, 3), and pressures (n,).

    Pressure is force per present area, linear between the points.

    Parameters
    ----------
    faces : Faces
        The slave of a `ContactConstraints`.
    q : (n_dofs,) array
        Coordinates of the slave.
    forces : (n_multipliers,) array
    averaged : bool
        Distribute the force of each side's multiplier to its two corners and show the resulting corner pressures; the
        other points get the mean of the adjacent corners. On a coarse mesh corner and side multipliers oscillate about
        the pressure; this removes the oscillation and keeps the force.

    Examples
    --------
    >>> import fecontact as fc
    >>> space = AncfSpace(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
    >>> top = AncfSolid(space, fc.Material(E=1.0, nu=0.0)).side("top")
    >>> points, triangles, pressure = multiplier_pressure(top, space.q0, 3.0 * top.quadrature[2])
    >>> points.shape, triangles.shape, bool(abs(pressure - 3.0).max() < 1e-12)
    ((15, 3), (16, 3), True)
    """
    n, n_multipliers = len(faces.faces), len(forces)
    of_face = np.column_stack([faces.multipliers, n_multipliers + np.arange(n)])
    each, place = np.repeat(np.arange(n), 9), np.tile(quad_nodes(9), (n, 1))
    points = np.empty((n_multipliers + n, 3))
    points[of_face.ravel()] = faces.at(q, each, place)[0]
    areas = faces.present_areas(q)
    pressure = forces / areas
    if averaged:
        corners = np.unique(faces.multipliers[:, :4])  # corners are numbered before sides
        sides, first = np.unique(faces.multipliers[:, 4:], return_index=True)
        ends = sides_of(faces.multipliers).reshape(-1, 2)[first]
        summed = [
            x[corners] + np.bincount(ends.ravel(), np.repeat(x[sides] / 2, 2), len(corners)) for x in (forces, areas)
        ]
        at_corners = summed[0] / summed[1]
        pressure = np.concatenate([at_corners, at_corners[ends].mean(axis=1)])
    middles = pressure[faces.multipliers[:, 4:]].mean(axis=1)
    return points, of_face[:, TRIANGLES].reshape(-1, 3), np.concatenate([pressure, middles])


def draw_side(
    axes: Axes,
    solid: AncfSolid,
    q: Array,
    boundary: str,
    *,
    plane: tuple[int, int] = (0, 2),
    shaded: bool = True,
    limits: tuple[float, float] | None = None,
    cmap: str = "viridis",
    **line: Any,
) -> ScalarMappable | None:
    """Draw a deformed side of a solid: its edges, and the equivalent Cauchy stress on it.

    Parameters
    ----------
    axes : matplotlib Axes
    solid : AncfSolid
    q : (n_dofs,) array
        Coordinates of the solid.
    boundary : str
    plane : (int, int)
        World axes drawn to the right and upwards.
    shaded : bool
        Whether to draw the stress, or edges only.
    limits : (float, float), optional
        Range of the colours; that of the side unless given.
    cmap : str
    **line
        Of the edges, as in `matplotlib.collections.LineCollection`.

    Returns
    -------
    ScalarMappable or None
        For a colour bar.
    """
    drawn = None
    if shaded:
        quads, stress = _patches(solid, q, boundary)
        drawn = PolyCollection(
            list(quads[..., list(plane)]), array=stress, cmap=cmap, edgecolors="face", linewidths=0.2
        )
        if limits is not None:
            drawn.set_clim(*limits)
        axes.add_collection(drawn)
    lines = edges(solid.space, q, boundary)[..., list(plane)]
    axes.add_collection(LineCollection(list(lines), **{"colors": "black", "linewidths": 0.6, **line}))
    axes.set_aspect("equal")
    axes.autoscale_view()
    return drawn


def _patches(solid: AncfSolid, q: Array, boundary: str, n: int = PATCHES) -> tuple[Array, Array]:
    """Quadrilaterals (n_faces n^2, 4, 3) of a deformed side and the equivalent stress in the middle of each."""
    cell, face = solid.space.mesh.faces(boundary).T
    t = np.linspace(0.0, 1.0, n + 1)
    first = np.stack(np.meshgrid(t[:-1], t[:-1], indexing="ij"), axis=-1).reshape(-1, 1, 2)
    around = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) / n
    corners = (first + around).reshape(-1, 2)
    middle = (first[:, 0] + 0.5 / n).reshape(-1, 2)
    at_corners = np.concatenate([face_points(int(f), corners) for f in face])
    at_middle = np.concatenate([face_points(int(f), middle) for f in face])
    quads = solid.space.points_at(q, np.repeat(cell, len(corners)), at_corners).reshape(-1, 4, 3)
    sigma = solid.cauchy_at(q, np.repeat(cell, len(middle)), at_middle)
    return quads, von_mises(sigma)


def save_motion(assembly: Assembly, frames: Sequence[Array | State], path: str | Path, times: Sequence[float]) -> Path:
    """Write coordinates at several times as a series.

    Every cell is written separately with twenty nodes, to show its curved edges.

    Parameters
    ----------
    assembly : Assembly
    frames : sequence of (n_dofs,) arrays or States
        Such as `Motion.frames`, or a `Path`, whose states remember plastic flow.
    path : str or Path
        Ends in ``.pvd``.
    times : sequence of float
        One for each frame.

    Raises
    ------
    InputError
        For another suffix, no frame, or a number of times other than that of the frames.
    """
    path = check_writable(path)
    if path.suffix.lower() != ".pvd":
        raise InputError(f"A series is written to a .pvd file; found {path.name!r}.", code="not-pvd")
    if not len(frames) or len(frames) != len(times):
        raise InputError(f"A series needs frames and one time for each; found {len(frames)} and {len(times)}.")
    files = []
    for k, q in enumerate(cast(Sequence[Any], frames)):
        files.append(path.with_name(f"{path.stem}_{k:04d}.vtu"))
        with replacing(files[-1]) as partial:
            _mesh(getattr(q, "assembly", assembly), np.asarray(getattr(q, "q", q))).write(partial, file_format="vtu")
    return write_collection(path, files, [float(t) for t in times])


def _mesh(a: Assembly, q: Array) -> meshio.Mesh:
    """Deformed cells of all solids with displacement and equivalent Cauchy stress."""
    drawn = [s.drawn(a.part(q, k)) for k, s in enumerate(a.solids)]
    first = np.cumsum([0] + [len(d.points) for d in drawn])
    data = {
        "displacement": np.concatenate([d.points - d.start for d in drawn]),
        "von_mises": von_mises(np.concatenate([d.stress for d in drawn])),
    }
    return meshio.Mesh(
        np.concatenate([d.points for d in drawn]),
        [(d.kind, d.cells + start) for d, start in zip(drawn, first, strict=False)],
        point_data=data,
        cell_data={"body": [np.full(len(d.cells), k) for k, d in enumerate(drawn)]},
    )
