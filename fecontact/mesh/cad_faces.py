"""Nodes of a mesh on the faces and edges of the CAD model that it was made from.

The middles of parabolic sides, and nodes within triangles that are divided into hexahedra, lie beside the part's
surface. As long as gmsh holds the model they are placed on it, be it a sphere, a cylinder or a free form: on the
closest point of their face, or of the edge at which faces meet (`gmsh.model.getClosestPoint`, OpenCASCADE).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.placement import unfolded

#: Distance, relative to the size of the mesh, within which a node lies on the model.
ON_MODEL = 1e-10


def on_model(gmsh: Any, mesh: Mesh) -> Mesh:
    """Place the nodes of boundaries 'surface_1', ... on the faces and edges of the model that gmsh holds.

    Where a cell would fold, its nodes are drawn back.

    Parameters
    ----------
    gmsh : module
    mesh : Mesh
        In the model's unit. Flat faces and straight edges have their nodes already.

    Returns
    -------
    Mesh
        With the same cells; the same object if nothing moves.
    """
    known = {tag for _, tag in gmsh.model.occ.getEntities(2)}
    nodes = {tag: mesh.boundary_nodes(f"surface_{tag}") for tag in known if f"surface_{tag}" in mesh.boundaries}
    points = mesh.points.copy()
    for tag, own in nodes.items():
        if gmsh.model.getType(2, tag) != "Plane":
            points[own] = _closest(gmsh, 2, tag, mesh.points[own])
    faces_of = {
        tag: [f for f in gmsh.model.getAdjacencies(1, tag)[0] if f in nodes] for _, tag in gmsh.model.occ.getEntities(1)
    }
    apart = np.full(len(points), np.inf)
    for tag, faces in faces_of.items():
        if len(faces) != 2:
            continue  # the seam of a face that closes in itself
        both = np.intersect1d(nodes[faces[0]], nodes[faces[1]])
        found = _closest(gmsh, 1, tag, mesh.points[both])
        distance = np.linalg.norm(found - mesh.points[both], axis=1)
        nearer = distance < apart[both]
        points[both[nearer]], apart[both[nearer]] = found[nearer], distance[nearer]
    moved = np.linalg.norm(points - mesh.points, axis=1) > ON_MODEL * np.linalg.norm(np.ptp(points, axis=0))
    return unfolded(mesh, np.where(moved[:, None], points, mesh.points), moved)[0] if moved.any() else mesh


def _closest(gmsh: Any, dim: int, tag: int, points: Array) -> Array:
    """Closest points (n, 3) of a face or an edge."""
    return np.reshape(gmsh.model.getClosestPoint(dim, tag, points.ravel())[0], (-1, 3)) if len(points) else points
