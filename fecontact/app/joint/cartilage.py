"""Layers of cartilage: bodies extruded from surfaces of bones, and their thickness from two surfaces."""

from __future__ import annotations

from typing import cast

import numpy as np

from fecontact.bodies.elastic import ElasticBody
from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.laws import Law
from fecontact.mesh.layer import Thickness, extrude
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface

#: Newton steps along a normal; each halves what is left where the surfaces are at 60 degrees, far more elsewhere.
MAX_ITERATIONS = 60
#: Least cosine between the normals of both surfaces.
STEEPEST = 0.2
#: Step, relative to the size of the bone, at which the thickness is found.
STEP_TOLERANCE = 1e-10


def cartilage_body(
    bone: SurfaceMesh, thickness: Thickness | SurfaceMesh, material: Material | Law, layers: int, name: str
) -> ElasticBody:
    """Layer on a bone, tied to it: the bone is the body's frame.

    Parameters
    ----------
    bone : SurfaceMesh
        Its outside is where the cartilage is.
    thickness : float, (n_points,) array, callable or SurfaceMesh
        As `mesh.layer.extrude` takes it; or the free surface of the cartilage, see `thickness_between`.
    material : Material or Law
    layers : int
        Elements through the thickness.
    name : str
    """
    if getattr(thickness, "facets", None) is not None:
        thickness = thickness_between(bone, cast(SurfaceMesh, thickness))
    mesh = extrude(bone, cast(Thickness, thickness), layers)
    return ElasticBody(mesh, material, contact="top", supports={"base": "xyz"}, name=name)


def thickness_between(bone: SurfaceMesh, outer: SurfaceMesh) -> Array:
    """Thickness (n_points,) of cartilage at the points of a bone: the way along its normals to the free surface.

    Found by Newton's method: each step is the distance from the surface's nearest point over the cosine between both
    normals.

    Parameters
    ----------
    bone, outer : SurfaceMesh
        In the same axes, both with the cartilage's free side outside.

    Raises
    ------
    InputError
        Where the free surface does not lie over the bone.

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> bone = SurfaceMesh(square, np.array([[0, 1, 2, 3]]))
    >>> slope = SurfaceMesh(3 * square - 1 + [0, 0, 1] * (2 + 3 * square[:, :1]), np.array([[0, 1, 2, 3]]))
    >>> thickness_between(bone, slope).round(12).tolist()
    [2.0, 3.0, 3.0, 2.0]
    """
    instance("the bone", bone, SurfaceMesh)
    instance("the free surface of the cartilage", outer, SurfaceMesh)
    surface = FacetSurface(outer.points, outer.facets, "the free surface")
    nodes, size = bone.nodes, float(np.linalg.norm(np.ptp(bone.points, axis=0)))
    start, along = bone.points[nodes], bone.normals[nodes]
    way = np.zeros(len(nodes))
    for _ in range(MAX_ITERATIONS):
        found = surface.project(start + way[:, None] * along)
        cosine = np.einsum("ni,ni->n", along, found.normals)
        step = found.gap / np.maximum(cosine, STEEPEST)
        way -= step
        if np.abs(step).max() <= STEP_TOLERANCE * size:
            break
    wrong = found.outside | ~(way > 0) | (cosine < STEEPEST) | (np.abs(step) > STEP_TOLERANCE * size)
    if wrong.any():
        point = start[np.argmax(wrong)]
        raise InputError(
            f"The free surface of the cartilage does not lie over {wrong.sum()} of the bone's {len(nodes)} points, the "
            f"first at ({', '.join(f'{x:.6g}' for x in point)}). Cut the bone to the part with cartilage, and let both "
            "surfaces face the same way (surface.flipped()).",
            code="cartilage-off-bone",
        )
    thickness = np.zeros(len(bone.points))
    thickness[nodes] = way
    return thickness
