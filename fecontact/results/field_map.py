"""Fields of contacts without their bodies: little enough to keep of many cases, and enough to draw a map of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.directions import WORLD, Directions
from fecontact.common.errors import InputError
from fecontact.mesh.section_mesh import line_shapes
from fecontact.results.contact_fields import ContactFields

#: Fields of a contact.
FIELDS = ("pressure", "gap", "friction", "worn")
#: Cells per side into which a facet is divided for a smooth picture; points per side of a section.
FINENESS, ALONG = 6, 16
#: Share of the area whose pressures a scale shows where the peak is unbounded; peaks this close to a scale are on it.
SHOWN_SHARE, ROUNDING = 0.95, 1e-9


@compact_repr
@dataclass(frozen=True, eq=False)
class Ground:
    """Facets of a contact and what of them is loaded, which decide how a map is laid out.

    Attributes
    ----------
    nodes : (m, 3) array
    facets : (n_facets, 3 | 4 | 8 | 9) int array
    loaded_facets : (n_facets,) bool array
        Facets with a loaded node.
    points : (n, 3) array
        Contact points.
    active : (n,) bool array
        Points that carry force.
    centre_of_pressure : (3,) array
        NaN without contact.
    directions : Directions
        Names of directions, for the axes of the map.
    """

    nodes: Array
    facets: IntArray
    loaded_facets: Mask
    points: Array
    active: Mask
    centre_of_pressure: Array
    directions: Directions = field(default=WORLD, kw_only=True)


@compact_repr
@dataclass(frozen=True, eq=False)
class FieldMap(Ground):
    """A field of a contact in world axes.

    Attributes
    ----------
    what : str
        'pressure', 'gap', 'friction', the size of its tractions, or 'worn', the worn depth.
    values : (n,) array
        At the contact points.
    areas : (n,) array
        Areas of the contact points.
    shades : (n_facets, n_q) float32 array
        The field at `local_points` of every facet; pressures as recovered (`results.recovery`).
    curves : tuple of (k, 3) array
        Outlines of the contact.
    regions : tuple of ((3,) array, float)
        Centre of pressure and force of each connected region.
    top : float
        Upper end of a scale, see `scale_top`; of a gap the largest.
    is_ring : bool
        Whether the contact is between bodies of revolution.
    """

    what: str
    values: Array
    areas: Array
    shades: Array = field(repr=False)
    curves: tuple[Array, ...] = field(repr=False)
    regions: tuple[tuple[Array, float], ...] = field(repr=False)
    top: float
    is_ring: bool

    @property
    def is_curve(self) -> bool:
        """Whether the contact is between sections."""
        return self.facets.shape[1] == 3

    @cached_property
    def peak(self) -> float:
        """Largest value at the contact points."""
        return float(self.values.max(initial=0.0))


def local_points(facets: IntArray) -> Array:
    """Coordinates (n_q, 2 | 1) of the samples in a facet, or in a side of a section."""
    if facets.shape[1] == 3:
        return np.linspace(0.0, 1.0, ALONG)[:, None]
    t = np.linspace(0.0, 1.0, FINENESS + 1)
    return np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)


def line_points(ground: Ground | ContactFields) -> Array:
    """Positions (n_facets, n_q, 3) of the samples in the sides of a section."""
    return np.asarray(line_shapes(local_points(ground.facets)[:, 0])[0] @ ground.nodes[ground.facets])


def values_of(contact: ContactFields, what: str) -> Array:
    """A field (n,) at the points of a contact."""
    if what == "friction":
        return np.zeros(len(contact.points)) if contact.friction is None else _size(contact.friction.traction)
    if what == "worn" and contact.worn is None:
        raise InputError("This contact has not worn: solve a path with wear=, or draw another field.", code="no-wear")
    return np.asarray(getattr(contact, what))


def shades_of(contact: ContactFields, what: str, values: Array) -> Array:
    """A field (n_facets, n_q) at `local_points` of all facets, from its values (n,); pressures as recovered."""
    local = local_points(contact.facets)
    if what == "pressure" and not contact._is_curve:
        return contact.recovered.at(local)
    return contact._interpolated(values, local, values.max(initial=0.0) if what == "gap" else 0.0)


def scale_top(contact: ContactFields) -> float:
    """Upper end of a scale of pressures: the peak, or where that is a matter of the mesh, what most of the area keeps.

    A curve shows all of its values. Towards a sharp edge the pressure has no bound (`results.singular`), and its nodal
    peak would leave all else of a map pale.
    """
    peak = contact.max_pressure
    if contact._is_curve or contact._singular_edge is None or not contact.active.any():
        return peak
    pressure, area = contact.pressure[contact.active], contact.weights[contact.active]
    order = np.argsort(pressure)
    share = np.cumsum(area[order]) / area.sum()
    return float(pressure[order[int(np.argmax(share >= SHOWN_SHARE * (1 - ROUNDING)))]])


def field_map(contact: ContactFields, what: str) -> FieldMap:
    """A field of a contact without its bodies.

    Parameters
    ----------
    contact : ContactFields
    what : {'pressure', 'gap', 'friction', 'worn'}

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> result = fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.01}})
    >>> kept = field_map(result.contacts[0], "pressure")
    >>> round(kept.peak, 9), round(float(kept.values @ kept.areas), 9)
    (0.01, 0.01)
    """
    values = values_of(contact, what)
    return FieldMap(
        nodes=contact.nodes,
        facets=contact.facets.astype(np.int32),
        loaded_facets=contact.loaded_facets,
        points=contact.points,
        active=contact.active,
        centre_of_pressure=contact.centre_of_pressure,
        directions=contact.directions,
        what=what,
        values=values,
        areas=contact.weights,
        shades=shades_of(contact, what, values).astype(np.float32),
        curves=() if contact._is_curve else tuple(curve.points for curve in contact.outline.curves),
        regions=tuple((r.centre_of_pressure, float(np.linalg.norm(r.force))) for r in contact.regions),
        top=scale_top(contact) if what == "pressure" else float(values.max(initial=0.0)),
        is_ring=contact._is_curve and contact._surface.revolved,
    )


def together(maps: Sequence[Ground]) -> Ground:
    """The facets of several cases as those of one contact, for a map that is laid out the same for all."""
    start = np.cumsum([0] + [len(m.nodes) for m in maps])
    centres = np.array([m.centre_of_pressure for m in maps])
    known = centres[np.isfinite(centres).all(axis=1)]
    return Ground(
        nodes=np.concatenate([m.nodes for m in maps]),
        facets=np.concatenate([first + m.facets[:, :4] for first, m in zip(start[:-1], maps, strict=True)]),
        loaded_facets=np.concatenate([m.loaded_facets for m in maps]),
        points=np.concatenate([m.points for m in maps]),
        active=np.concatenate([m.active for m in maps]),
        centre_of_pressure=known.mean(axis=0) if len(known) else np.full(3, np.nan),
        directions=maps[0].directions,
    )


def _size(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1))
