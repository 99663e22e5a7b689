"""Smooth surfaces through the nodes of a mesh: what its facets stand for.

Over every facet of the starting mesh, the surface is at the distance

    t = sum N_a t_a      along      d = sum N_a n_a

from the facet's point, N_a being its shape functions, n_a the normal at node a of the local fit round it
(`surfaces.local_fit`) and t_a the distance of this fit along d. It passes through all nodes, is continuous over the
sides of facets, and is exact where all fits are: on planes, spheres, cylinders and all other quadrics. Where a fit does
not represent the nodes (noise, an edge that is no sharp one) t_a = 0: the surface is the facet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.surfaces.facet_surface import FacetSurface, Projection
from fecontact.surfaces.local_fit import LocalFits

#: Largest distance of the surface from a facet, in sizes of the facet, that is believed.
FARTHEST = 0.5
#: Steps by which the closest point is found, and the distance sideways, relative to the size, at which they end.
MOST_STEPS, SETTLED = 8, 1e-6


@dataclass(frozen=True, eq=False)
class SmoothSurface:
    """A smooth surface over facets.

    Attributes
    ----------
    base : FacetSurface
        The facets.
    fits : LocalFits
        Round its nodes, in their order.
    """

    base: FacetSurface
    fits: LocalFits

    @property
    def size(self) -> float:
        """Diagonal of the bounding box of its facets."""
        return self.base.size

    @cached_property
    def nodal_normals(self) -> Array:
        """Unit normals (n_nodes, 3) of the fits at their nodes; averaged ones where there is no fit."""
        fits = self.fits
        own = fits.normals(np.arange(len(fits.origins)), fits.origins)
        return np.where(fits.is_fitted[:, None], own, fits.axes[:, 2])

    def at(self, facet: IntArray, local: Array) -> tuple[Array, Array]:
        """Points (n, 3) and unit normals (n, 3) over coordinates (n, 2) of facets (n,)."""
        x, _, N = self.base.evaluate(facet, local)
        nodes = self.base.facets[facet]
        d = np.einsum("na,nai->ni", N, self.nodal_normals[nodes])
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        k = nodes.shape[1]
        each, along = nodes.ravel(), np.repeat(d, k, axis=0)
        t = self.fits.offsets(each, np.repeat(x, k, axis=0), along)
        far = FARTHEST * np.repeat(self.base.mean_facet_size[facet], k)
        # also where there is no fit or no offset
        t = np.where(self.fits.is_fitted[each] & (np.abs(t) <= far), t, 0.0).reshape(-1, k)
        x = x + np.einsum("na,na->n", N, t)[:, None] * d
        normals = self.fits.normals(each, np.repeat(x, k, axis=0)).reshape(-1, k, 3)
        normals = np.where(self.fits.is_fitted[nodes][..., None], normals, self.nodal_normals[nodes])
        mean = np.einsum("na,nai->ni", N, normals)
        return x, mean / np.linalg.norm(mean, axis=1, keepdims=True)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3): facets' closest points first, then steps along the smooth surface."""
        start = points
        for _ in range(MOST_STEPS):
            under = self.base.project(start)
            assert under.facet is not None
            assert under.local is not None
            x, normals = self.at(under.facet, under.local)
            offset = points - x
            sideways = offset - np.einsum("ni,ni->n", offset, normals)[:, None] * normals
            # on the rim nothing is left to step to
            sideways[under.outside] = 0.0
            if np.abs(sideways).max(initial=0.0) <= SETTLED * self.size:
                break
            start = under.points + sideways
        gap = np.einsum("ni,ni->n", offset, normals)
        return Projection(x, normals, gap, under.outside, None, under.facet, under.local, self.base.name)
