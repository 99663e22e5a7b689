"""Which facets of two surfaces may touch, judged from rough gaps before anything is paired.

A rough gap is the offset of a facet's centre from the nearest facet of the other surface along that one's normal. It
serves to condense models onto enough nodes at once; what it misses is found when the surfaces are paired.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fecontact.bodies.protocol import Body
from fecontact.interface.candidates import MARGIN, approach_for_load
from fecontact.interface.surface import FacetSurface
from fecontact.loading import Loading
from fecontact.mesh.facets import facet_centres

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Rings of facets added round those that may touch: condensing again costs more than a few nodes in excess.
RINGS = 2


def rough_gaps(one: FacetSurface, other: FacetSurface, rotation: Array, translation: Array) -> Array:
    """Offsets (n_facets,) of one surface's facets from another; `rotation`, `translation` place it in the other's axes.

    Facets whose centre lies further aside than the nearest facet is long face nothing: infinite.
    """
    middles = facet_centres(one.triangle)
    centres = one.evaluate(np.arange(len(middles)), middles)[0] @ rotation.T + translation
    theirs = facet_centres(other.triangle)
    places = other.evaluate(np.arange(len(theirs)), theirs)[0]
    _, nearest = cKDTree(places).query(centres)
    normals = other.normals(nearest, theirs[nearest])
    offset = centres - places[nearest]
    gap = np.einsum("ni,ni->n", offset, normals)
    aside = np.linalg.norm(offset - gap[:, None] * normals, axis=1)
    return np.where(aside > other.mean_facet_size[nearest] + one.mean_facet_size, np.inf, gap)


def near_nodes(bodies: Sequence[Body], surfaces: Sequence[FacetSurface], loading: Loading) -> list[IntArray]:
    """Nodes of both surfaces of a contact that may touch under a load, rings of facets round them included."""
    out = []
    poses = [b.pose for b in bodies]
    softness = sum(1 / b.contact_modulus for b in bodies)
    for k in range(2):
        one, other, relative = surfaces[k], surfaces[1 - k], poses[k].relative_to(poses[1 - k])
        gap = rough_gaps(one, other, relative.rotation, relative.translation)
        for frame in loading.frames:
            if any(frame.body is b for b in bodies) and frame.moved.any():
                gap = gap - np.linalg.norm(frame.moved[:3]) - np.linalg.norm(frame.moved[3:]) * frame.body.size
        facing = np.isfinite(gap)
        if not facing.any():
            out.append(one.nodes)
            continue
        lowest = float(gap.min())
        approach = max(0.0, -lowest)
        if loading.magnitude > 0 and softness > 0:
            areas = one.mean_facet_size[facing] ** 2
            approach = max(approach, approach_for_load(gap[facing] - lowest, areas, 1 / softness, loading.magnitude))
        near = np.asarray(gap - lowest <= MARGIN * approach)
        for _ in range(RINGS):
            touched = np.zeros(len(one.points), bool)
            touched[one.facets[near]] = True
            near = np.asarray(touched[one.facets].any(axis=1))
        out.append(np.unique(one.facets[near]))
    return out
