"""Layers of cartilage: bodies on surfaces of bones or under free ones, thickness between both, sides of solids."""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.layer import ElasticLayer
from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import number_array, positive, vector
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.laws import Law
from fecontact.mesh.facets import components, facet_integrals, unit_vectors
from fecontact.mesh.layer import Thickness, extrude
from fecontact.mesh.orient import neighbours
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface

#: Newton steps along a normal; each halves what is left where the surfaces are at 60 degrees, far more elsewhere.
MAX_ITERATIONS = 60
#: Least cosine between the normals of both surfaces.
STEEPEST = 0.2
#: Cosine between a facet and the bone above which it faces with or against it, and is no part of a rim.
FACING = 0.5
#: Area of the smaller side of a closed solid, relative to the larger, from which both are sides.
LEAST_SIDE = 0.5
#: Step, relative to the size of the bone, at which the thickness is found.
STEP_TOLERANCE = 1e-10


def cartilage_body(
    surface: SurfaceMesh,
    thickness: Thickness | SurfaceMesh,
    material: Material | Law,
    layers: int,
    name: str,
    *,
    free: bool = False,
    foundation: bool = False,
    least: float | None = None,
) -> ElasticBody | ElasticLayer:
    """Layer of cartilage tied to a bone, which is the body's frame.

    Parameters
    ----------
    surface : SurfaceMesh
        Of the bone, outside where the cartilage is; or the cartilage's free surface.
    thickness : float, (n_points,) array, callable or SurfaceMesh
        As `mesh.layer.extrude` takes it; or the other one of both surfaces, see `thickness_between`.
    material : Material or Law
    layers : int
        Elements through the thickness.
    name : str
    free : bool
        Whether the surface is the free one, from which the layer grows inwards.
    foundation : bool
        Whether the layer is an elastic foundation, whose points give by their own pressure only.
    least : float, optional
        As for `thickness_between`.
    """
    inwards = surface.flipped() if free else surface
    if getattr(thickness, "facets", None) is not None:
        other = cast(SurfaceMesh, thickness)
        thickness = thickness_between(inwards, other.flipped() if free else other, least)
    elif least is not None:
        raise InputError(
            "A least thickness is of a layer between two surfaces: give one as the thickness.", code="least"
        )
    if foundation:
        t = number_array("the thickness", thickness(surface.points) if callable(thickness) else thickness)
        top = surface if free else surface.mapped(lambda x: x + np.reshape(t, (-1, 1)) * surface.normals)
        return ElasticLayer(cast(Material, material), t, top, name=name)
    mesh = extrude(inwards, cast(Thickness, thickness), layers)
    touching, tied = ("base", "top") if free else ("top", "base")
    return ElasticBody(mesh, material, contact=touching, supports={tied: "xyz"}, name=name)


def thickness_between(bone: SurfaceMesh, outer: SurfaceMesh, least: float | None = None) -> Array:
    """Thickness (n_points,) of cartilage at the points of a bone: the way along its normals to the free surface.

    Found by Newton's method: each step is the distance from the surface's nearest point over the cosine between both
    normals.

    Parameters
    ----------
    bone, outer : SurfaceMesh
        In the same axes, both with the cartilage's free side outside. Flipped both, and the free surface first, they
        give the thickness at the points of the free surface.
    least : float, optional
        Thickness where there is less, or where the free surface does not lie over the bone; such points are refused
        unless it is given.

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
    if least is not None:
        way = np.where(wrong, positive("the least thickness", least), np.maximum(way, least))
    elif wrong.any():
        point = start[np.argmax(wrong)]
        raise InputError(
            f"The free surface of the cartilage does not lie over {wrong.sum()} of the bone's {len(nodes)} points, the "
            f"first at ({', '.join(f'{x:.6g}' for x in point)}). Cut the bone to the part with cartilage, and let both "
            "surfaces face the same way (surface.flipped()); thickness_between(least=) gives such points a thickness.",
            code="cartilage-off-bone",
        )
    thickness = np.zeros(len(bone.points))
    thickness[nodes] = way
    return thickness


def cartilage_sides(
    solid: SurfaceMesh, bone: SurfaceMesh | None = None, *, towards: ArrayLike | None = None, angle: float = 40.0
) -> tuple[SurfaceMesh, SurfaceMesh]:
    """The free surface of a closed solid of cartilage, and its surface on the bone, which faces the same way.

    Parameters
    ----------
    solid : SurfaceMesh
        Closed, facing outwards.
    bone : SurfaceMesh, optional
        Facing outwards: facets of the solid that face within 60 degrees as the nearest part of the bone does are the
        free ones, those that face against it lie on it.
    towards : (3,), optional
        Without a bone: a point to which the free side faces, such as the middle of the other bone. Both sides are then
        the largest two parts between edges sharper than `angle` (degrees).
    angle : float

    Returns
    -------
    free, back : SurfaceMesh
        For `Joint(free, ..., thickness=back, surfaces="cartilage")`.

    Raises
    ------
    InputError
        If the surface is open, neither bone nor point is given, or the edges do not divide it in two.

    Examples
    --------
    >>> import fecontact as fc
    >>> plate = fc.shapes.block((4.0, 4.0, 1.0), (4, 4, 1), element="hex8")
    >>> skin = fc.SurfaceMesh(plate.points, plate.skin)
    >>> free, back = cartilage_sides(skin, towards=(2.0, 2.0, 9.0))
    >>> float(free.points[free.nodes][:, 2].min()), float(back.normals[back.nodes][0, 2])
    (1.0, 1.0)
    """
    if not instance("the solid of the cartilage", solid, SurfaceMesh).is_closed:
        raise InputError("The solid of the cartilage is open: it is a surface; give it to Joint as it is.", code="open")
    if (bone is None) == (towards is None):
        raise InputError("Give the bone of the cartilage, or a point towards= which its free side faces.", code="sides")
    middles = solid.points[solid.facets[:, :4]].mean(axis=1)
    outwards = facet_integrals(solid.points, solid.facets)[2].sum(axis=1)
    if bone is not None:
        below = FacetSurface(bone.points, bone.facets, "the bone").project(middles)
        along = np.einsum("fi,fi->f", unit_vectors(outwards), below.normals)
        free, kept = along > 0, np.abs(along) > FACING
    else:
        pairs, _ = neighbours(solid.facets[:, :4])
        cosine = np.einsum("pki,pki->p", *(unit_vectors(outwards[pairs[:, k], None]) for k in (0, 1)))
        part = components(len(middles), pairs[cosine > np.cos(np.radians(angle))])
        areas = np.bincount(part, solid.areas)
        largest = np.argsort(-areas)[:2]
        if len(areas) == 1 or areas[largest[1]] < LEAST_SIDE * areas[largest[0]]:
            raise InputError(
                f"Edges sharper than {angle:g} degrees do not divide the solid in two sides: its largest parts have "
                f"{', '.join(f'{a:.4g}' for a in areas[largest])} in area. Give the bone, or another angle.",
                code="no-sides",
            )
        way = vector("the point that the free side faces", cast(ArrayLike, towards)) - middles
        facing = [float((outwards * way)[part == k].sum()) for k in largest]
        free = part == largest[int(np.argmax(facing))]
        kept = free | (part == largest[int(np.argmin(facing))])
    sides = (solid.facets[kept & side] for side in (free, ~free))
    front, back = (SurfaceMesh(solid.points, facets, solid.notes) for facets in sides)
    return front, back.flipped()
