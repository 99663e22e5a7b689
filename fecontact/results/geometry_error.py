"""Error of pressures due to faces that deviate from the smooth shape they represent.

Between facets that turn by an angle t at every side of length H the surface lies on chords: a row of parabolas of
height H t / 8, which refinement within the facets does not remove. To the pressure of the smooth shape a periodic one
is added. By Westergaard's solution of a wavy half-plane, p* = pi E* A / lambda for an amplitude A of the gap (Johnson
1985, section 13.2), for each harmonic of the parabolas, its root mean square is

    p = E* t / (4 sqrt(3))

for any H; the squares of two directions and of both bodies add up. Angles are weighted by themselves, t = sum(t^2
L) / sum(t L) over sides of length L, so that the flat sides within a facet that has been divided do not count.

The contact points resolve a part of it. Gaps at nodes: all of the other body's part; none of their own linear faces'
part, as the nodes lie on the shape itself, except within divided facets. Means over multiplier functions of width d:
the share sinc^2(k d / H) of the k-th harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.contact.coupling.choose import NESTED
from fecontact.mesh.facets import facet_centres, triangular
from fecontact.mesh.pick import shared_sides, side_normals
from fecontact.surfaces.facet_surface import FacetSurface, Surface, facets_of, own_facets

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Largest angle between neighbouring faces of a round shape; above it they form an edge.
EDGE = np.radians(40.0)
#: Angle that counts as rounding.
FLAT = 1e-12
#: Root mean square of the pressure over E* and the angle, of a surface bent in one direction.
BENT = 1 / (4 * np.sqrt(3))
#: Number of harmonics.
HARMONICS = np.arange(1, 33)


@dataclass(frozen=True)
class Kinks:
    """Angles between neighbouring facets of a surface.

    Attributes
    ----------
    angle : float
        Mean angle between facets, weighted by itself.
    period : float
        Distance between sides with an angle.
    spread : float
        Share of sides with an angle; 1 if the angle is the same at each.
    directions : float
        Number of directions of curvature: 2 on a sphere, 1 on a cylinder.
    sign : float
        1 on a convex surface, -1 on a concave one.
    size : float
        Mean size of the facets.
    """

    angle: float
    period: float
    spread: float
    directions: float
    sign: float
    size: float

    @property
    def pressure(self) -> float:
        """Root mean square of the pressure over E*, signed."""
        return self.sign * BENT * self.angle * float(np.sqrt(self.directions))


def geometry_error(contact: ContactFields) -> float:
    """Root mean square of the pressure due to the kinks between faces of a contact."""
    if contact.slave._is_foundation:
        return 0.0  # springs at nodes, which lie on the shape
    bodies = (contact.slave, contact.master)
    points = contact.points[contact.active]
    slave, master = (
        kinks(body.surface(name), body.pose.to_body(points), body._deformation)
        for body, name in zip(bodies, contact.surfaces, strict=True)
    )
    surface = facets_of(contact.slave.surface(contact.surfaces[0]))
    assert surface is not None
    linear = surface.facets.shape[1] == 4
    modulus = 1 / sum(1 / body.contact_modulus for body in bodies)
    if contact.note == NESTED and slave is not None and master is not None:
        # both have the same kinks: for a pin in its hole they cancel, for two spheres they add up
        return modulus * abs(slave.pressure + master.pressure)
    total = 0.0
    for side in (slave, master):
        if side is None:
            continue
        seen = 1.0
        if contact.coupling == "mortar" and slave is not None:
            width = slave.size if linear or bool(surface.triangle.all()) else slave.size / 2
            seen = seen_by_hats(width / side.period)
        elif side is slave and linear:
            seen = float(np.sqrt(1 - side.spread**2))
        total += (seen * side.pressure) ** 2
    return float(modulus * np.sqrt(total))


def seen_by_hats(width: float) -> float:
    """Share of the pressure of parabolas in means over multiplier functions, by their width over the parabolas'.

    Examples
    --------
    >>> [round(seen_by_hats(x), 2) for x in (0.0, 0.25, 0.5, 1.0)]
    [0.99, 0.65, 0.32, 0.0]
    """
    k = HARMONICS
    return float(np.sqrt(6 / np.pi**2 * (np.sinc(k * width) ** 4 / k**2).sum()))


def kinks(surface: Surface, points: Array, deformation: Array | None = None) -> Kinks | None:
    """Kinks of a surface at points (n, 3) on it; None without facets or without kinks.

    Those before a deformation (n_points, 3) of its points: what bends faces at finite strain is an error of elements.

    Examples
    --------
    A prism of 36 sides, an angle of ten degrees at each:

    >>> from fecontact.mesh.surface_mesh import SurfaceMesh
    >>> from fecontact.surfaces import Facets
    >>> angle = np.radians(10 * np.arange(9))
    >>> ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    >>> k = np.arange(8)
    >>> sides = np.stack([k, k + 1, k + 10, k + 9], axis=1)
    >>> prism = kinks(Facets(SurfaceMesh(np.concatenate([ring, ring + [0, 0, 1]]), sides)), ring)
    >>> round(float(np.degrees(prism.angle)), 9), prism.sign
    (10.0, 1.0)
    """
    facets = own_facets(surface)
    if facets is None or facets.cell_area is not None or len(points) == 0:
        return None
    _, near = facets.tree.query(points)
    chosen = np.unique(facets.facets_of_node[near])
    if deformation is not None:
        facets = replace(facets, points=facets.points - deformation)
    turn, apart, length = _turns(facets, chosen)
    angle = 2 * np.arcsin(np.minimum(np.linalg.norm(turn, axis=1) / 2, 1.0))
    angle = np.where((angle <= EDGE) & (angle > FLAT), angle, 0.0)
    if not angle.any():
        return None
    mean = float(angle**2 @ length / (angle @ length))
    # at most one, by Cauchy and Schwarz, but for rounding
    spread = min(1.0, float((angle @ length) ** 2 / (angle**2 @ length * length.sum())))
    size = float(facets.mean_facet_size[chosen].mean())
    convex = float(np.sign(np.einsum("ni,ni->n", turn, apart) @ (angle * length)))
    return Kinks(mean, size / spread, spread, _directions(facets, chosen), convex, size)


def _turns(surface: FacetSurface, chosen: IntArray) -> tuple[Array, Array, Array]:
    """Differences (n, 3) of normals and of centres between chosen facets with a common side, and its length (n,)."""
    centres = surface.evaluate(chosen, facet_centres(surface.triangle[chosen]))[0]
    if surface.out_of_plane is not None:
        first, second = _consecutive(surface.facets[chosen])
        ends = [np.tile([s, 0.5], (len(first), 1)) for s in (1.0, 0.0)]
        turn = surface.normals(chosen[second], ends[1]) - surface.normals(chosen[first], ends[0])
        return turn, centres[second] - centres[first], np.ones(len(first))
    facets = surface.facets[chosen]
    first, second, _ = shared_sides(surface.points, facets)
    normals = side_normals(surface.points, facets, triangular(facets)).reshape(-1, 3)
    corners = surface.points[facets[:, :4]]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).ravel()[first]
    return normals[second] - normals[first], centres[second // 4] - centres[first // 4], length


def _consecutive(sides: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of adjacent sides of a section, in terms of the sides (n, 3)."""
    order = np.argsort(sides[:, 0])
    place = np.minimum(np.searchsorted(sides[order, 0], sides[:, 1]), len(order) - 1)
    first = np.flatnonzero(sides[order[place], 0] == sides[:, 1])
    return first, order[place[first]]


def _directions(surface: FacetSurface, chosen: IntArray) -> float:
    """Number of directions of curvature, from the spread of the facets' normals."""
    if surface.out_of_plane is not None:
        return 1.0
    normals = surface.normals(chosen, facet_centres(surface.triangle[chosen]))
    _, two, one = np.linalg.eigvalsh(np.cov(normals.T, bias=True))
    return float((one + two) ** 2 / (one**2 + two**2)) if one > 0 else 1.0
