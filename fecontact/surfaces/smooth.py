"""Smooth surfaces through the nodes of a mesh: what its facets stand for.

Over every facet of the starting mesh, the surface is at the distance

    t = sum N_a s_a t_a      along      d = sum N_a n_a

from the facet's point, N_a being its shape functions, n_a the normal at node a of the local fit round it
(`surfaces.local_fit`), t_a the distance of this fit along d and s_a the share of it that is taken. It passes through
all nodes, is continuous over the sides of facets, and is exact where all fits are: on planes, spheres, cylinders and
all other quadrics. Where a fit does not represent the nodes (noise, an edge that is no sharp one) t_a = 0: the surface
is the facet. Where the fits of a facet's nodes disagree within it by v (root mean square) and tell m in the
mean, as on coarse facets and in noise, the share is the linear estimate of least mean square error, m^2 / (m^2 + v^2)
(Wiener), with sums of m^2 and v^2 over the facets at a node.

Smooth surfaces fitted to contact boundaries of a mesh, once, before any cell is divided.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.mesh.check import check_size
from fecontact.mesh.facets import distinct_columns
from fecontact.mesh.hanging_nodes import HangingNodes
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.placement import Placement
from fecontact.mesh.smooth_parts import SmoothParts, smooth_parts
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.surfaces.facet_surface import FacetSurface, Projection
from fecontact.surfaces.local_fit import LocalFits, local_fits

#: Largest distance of the surface from a facet, in sizes of the facet, that is believed.
FARTHEST = 0.5
#: Steps by which the closest point is found, and the distance sideways, relative to the size, at which they end.
MAX_ITERATIONS, STEP_TOLERANCE = 8, 1e-6
#: Points of a facet at which its nodes' fits are compared, in the middles of its quarters.
IN_SQUARE = np.array([[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.75]])
IN_TRIANGLE = np.array([[1, 1], [4, 1], [1, 4], [2, 2]]) / 6


@dataclass(frozen=True, eq=False)
class SmoothSurface:
    """A smooth surface over facets.

    Attributes
    ----------
    base : FacetSurface
        The facets.
    points : (n_points, 3) array
        Nodes of these facets and of those that continue them.
    facets : (n_facets, 4 | 8 | 9) int array
        All these facets.
    nodes : (n_nodes,) int array
        Number of each node of the base among the points.
    """

    base: FacetSurface
    points: Array
    facets: IntArray
    nodes: IntArray

    @property
    def size(self) -> float:
        """Diagonal of the bounding box of its facets."""
        return self.base.size

    @cached_property
    def fits(self) -> LocalFits:
        """Fits round the nodes of the base, in their order."""
        return local_fits(self.points, self.facets, self.nodes)

    @cached_property
    def nodal_normals(self) -> Array:
        """Unit normals (n_nodes, 3) of the fits at their nodes; averaged ones where there is no fit."""
        fits = self.fits
        own = fits.normals(np.arange(len(fits.origins)), fits.origins)
        return np.where(fits.is_fitted[:, None], own, fits.axes[:, 2])

    @cached_property
    def shares(self) -> Array:
        """Shares (n_nodes,) of the fits' distances that are taken."""
        facets = self.base.facets
        samples = np.where(self.base.triangle[:, None, None], IN_TRIANGLE, IN_SQUARE)
        number, k = np.repeat(np.arange(len(facets)), samples.shape[1]), facets.shape[1]
        _, N, _, t = self._distances(number, samples.reshape(-1, 2))
        real = distinct_columns(facets)[number]
        mean = np.einsum("na,na->n", N, t)
        even = np.einsum("na,na->n", real, t) / real.sum(axis=1)
        spread = np.einsum("na,na->n", real, (t - even[:, None]) ** 2) / real.sum(axis=1)
        nodes, n = facets[number][real], len(self.fits.origins)
        told, doubt = (np.bincount(nodes, np.repeat(x, k).reshape(t.shape)[real], n) for x in (mean**2, spread))
        return np.divide(told, told + doubt, out=np.zeros(n), where=told > 0)

    def at(self, facet: IntArray, local: Array) -> tuple[Array, Array]:
        """Points (n, 3) and unit normals (n, 3) over coordinates (n, 2) of facets (n,)."""
        x, N, d, t = self._distances(facet, local)
        nodes = self.base.facets[facet]
        x = x + np.einsum("na,na,na->n", N, self.shares[nodes], t)[:, None] * d
        each = nodes.ravel()
        normals = self.fits.normals(each, np.repeat(x, nodes.shape[1], axis=0)).reshape(*nodes.shape, 3)
        normals = np.where(self.fits.is_fitted[nodes][..., None], normals, self.nodal_normals[nodes])
        mean = np.einsum("na,nai->ni", N, normals)
        return x, mean / np.linalg.norm(mean, axis=1, keepdims=True)

    def _distances(self, facet: IntArray, local: Array) -> tuple[Array, Array, Array, Array]:
        """Points (n, 3) of facets, shape functions (n, k), directions (n, 3), and distances (n, k) of nodes' fits."""
        x, _, N = self.base.evaluate(facet, local)
        nodes = self.base.facets[facet]
        d = np.einsum("na,nai->ni", N, self.nodal_normals[nodes])
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        k = nodes.shape[1]
        each = nodes.ravel()
        t = self.fits.offsets(each, np.repeat(x, k, axis=0), np.repeat(d, k, axis=0))
        far = FARTHEST * np.repeat(self.base.mean_facet_size[facet], k)
        # also where there is no fit or no offset
        t = np.where(self.fits.is_fitted[each] & (np.abs(t) <= far), t, 0.0)
        return x, N, d, t.reshape(-1, k)

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3): facets' closest points first, then steps along the smooth surface."""
        start = points
        for _ in range(MAX_ITERATIONS):
            under = self.base.project(start)
            assert under.facet is not None
            assert under.local is not None
            x, normals = self.at(under.facet, under.local)
            offset = points - x
            sideways = offset - np.einsum("ni,ni->n", offset, normals)[:, None] * normals
            # on the rim nothing is left to step to
            sideways[under.outside] = 0.0
            if np.abs(sideways).max(initial=0.0) <= STEP_TOLERANCE * self.size:
                break
            start = under.points + sideways
        gap = np.einsum("ni,ni->n", offset, normals)
        return Projection(x, normals, gap, under.outside, None, under.facet, under.local, self.base.name)


#: Height of nodes on sides over the chords, relative to that of the arc between the corners' normals, below which sides
#: are straight: their nodes then say nothing about the surface.
STRAIGHT = 0.25


def fitted(mesh: Mesh, names: Sequence[str]) -> dict[str, Placement]:
    """Fit smooth surfaces to the curved parts of boundaries.

    Neighbouring faces of the body that continue a boundary smoothly count for the fit.

    Parameters
    ----------
    mesh : Mesh
        Without nodes in the middle of faces.
    names : sequence of str
        Boundaries; their faces are outer ones.

    Returns
    -------
    dict of str to Placement
        Of the boundaries that are not flat.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.quarter_sphere(1.0, contact_radius=0.1, level=1, element="hex8")
    >>> cap = fitted(mesh, ["cap", "sym_x"])["cap"]
    >>> bool(cap.surface.project(mesh.points[mesh.cells[0]]).gap.round(4).min() < 0)
    True
    """
    check_size(mesh.points)
    skin = mesh.outer
    if not names or len(skin) == 0:
        return {}
    # a ninth node is a point of the surface only in cells of 27
    facets = mesh.face_nodes(skin)[:, : 9 if mesh.cell_type == "hex27" else 8]
    number = skin @ np.array([6, 1])
    own = {name: np.isin(number, mesh.faces(name) @ np.array([6, 1])) for name in names}
    return fitted_facets(mesh.points, facets, own, mesh.hanging)


def fitted_facets(
    points: Array, facets: IntArray, own: Mapping[str, Mask], hanging: HangingNodes | None = None
) -> dict[str, Placement]:
    """Fit smooth surfaces to the curved ones of named facets.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array
        Of the whole body; those that continue named ones smoothly count for the fit.
    own : mapping of str to (n_facets,) bool array
    hanging : HangingNodes, optional
        Of the mesh, if it has any.

    Returns
    -------
    dict of str to Placement
        Of the names whose facets are not all flat.
    """
    parts = smooth_parts(points, facets, hanging)
    curved = {name: chosen & ~parts.flat for name, chosen in own.items() if (chosen & ~parts.flat).any()}
    if not curved:
        return {}
    among = np.any(list(curved.values()), axis=0)
    if facets.shape[1] > 4 and sides_are_straight(points, facets[among]):
        facets = facets[:, :4]
    continued = np.isin(parts.part, parts.part[among])
    sites, on_sites = _sites(facets[continued], parts.part[continued])
    out = {}
    for name, chosen in curved.items():
        used, base = np.unique(on_sites[chosen[continued]], return_inverse=True)
        surface = FacetSurface(points[sites][used], base.reshape(-1, facets.shape[1]), name)
        fit = SmoothSurface(surface, points[sites], on_sites, used)
        out[name] = Placement(fit, _planes(points, facets, parts, chosen, own[name]))
    return out


def _sites(facets: IntArray, part: IntArray) -> tuple[IntArray, IntArray]:
    """Nodes (n_sites,), each once for every part it is on, and facets in these numbers."""
    n = int(facets.max()) + 1
    key, number = np.unique(part[:, None] * n + facets, return_inverse=True)
    return key % n, number.reshape(facets.shape)


def sides_are_straight(points: Array, facets: IntArray) -> bool:
    """Whether the sides of facets (n, 8) are chords of the arcs that their corners stand for."""
    normals = averaged_normals(points, facets[:, :4])[0]
    begin, end, middle = facets[:, :4], np.roll(facets[:, :4], -1, axis=1), facets[:, 4:8]
    real = begin != end
    chord = points[end] - points[begin]
    arc = np.einsum("nai,nai->na", chord, normals[end] - normals[begin])[real] / 8
    off = points[middle] - points[begin] - chord / 2
    height = np.einsum("nai,nai->na", off, normals[begin] + normals[end])[real] / 2
    return bool((height**2).sum() <= STRAIGHT**2 * (arc**2).sum())


def bordering(mesh: Mesh, name: str) -> Array:
    """Planes (n_planes, 4) of flat outer faces that are not part of a boundary and share a node with it."""
    skin = mesh.outer
    facets = mesh.face_nodes(skin)[:, :8]
    own = np.isin(skin @ np.array([6, 1]), mesh.faces(name) @ np.array([6, 1]))
    return _planes(mesh.points, facets, smooth_parts(mesh.points, facets, mesh.hanging), own, own & False)


def _planes(points: Array, facets: IntArray, parts: SmoothParts, curved: Mask, own: Mask) -> Array:
    """Planes (n_planes, 4) of flat facets that share a node with curved ones, or are among some own ones."""
    touched = np.zeros(len(points), bool)
    touched[facets[curved]] = True
    near = parts.flat & (touched[facets].any(axis=1) & ~curved | own)
    _, first = np.unique(parts.part[near], return_index=True)
    return parts.planes(points, facets)[near][first]
