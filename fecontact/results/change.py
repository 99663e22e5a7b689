"""Change of the pressure from one mesh to the next, which estimates the error without regard to where it comes from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.error_estimate import ErrorEstimate
from fecontact.contact.coupling.mortar_basis import multiplier_shapes
from fecontact.results.contact_fields import ContactFields
from fecontact.surfaces.facet_surface import facets_of

#: Change of the pressure over the error that is left, for meshes of faces half as large: errors of first order with a
#: random sign give sqrt(2^2 + 1) = 2.2, those of one sign 1.
CHANGE = 1.7
#: Samples along each side of a face.
SAMPLES = 6


def pressure_change(contact: ContactFields, coarser: ContactFields) -> float:
    """Relative L2 norm of the difference between the pressures of a contact on two meshes.

    Parameters
    ----------
    contact, coarser : ContactFields
        The same contact, on a mesh and on the one before; the sides may have been swapped.
    """
    points, pressure, areas = contact.sampled(contact.pressure, SAMPLES)
    return float(np.sqrt(areas @ (pressure - pressure_at(coarser, points)) ** 2 / (areas @ pressure**2)))


def pressure_at(contact: ContactFields, points: Array) -> Array:
    """Pressure (n,) at the places of a contact's slave that are nearest to points (n, 3)."""
    surface = facets_of(contact.slave.surface(contact.surfaces[0]))
    assert surface is not None
    nodal = np.zeros(len(surface.points))
    nodal[contact.node_numbers] = contact.at_nodes @ contact.pressure
    found = surface.project(contact.slave.pose.to_body(points))
    if contact.coupling == "nodal":
        assert found.weights is not None
        value = found.weights @ nodal
    else:
        assert found.facet is not None
        assert found.local is not None
        shapes = multiplier_shapes(surface.facets.shape[1], surface.triangle[found.facet], found.local)
        value = np.einsum("na,na->n", shapes, nodal[surface.facets[found.facet]])
    return np.asarray(np.where(found.outside, 0.0, value))


def estimate_after(contact: ContactFields, coarser: ContactFields) -> ErrorEstimate:
    """Estimate of a contact's errors that also knows the one on a coarser mesh: the larger of both."""
    own = contact.error_estimate
    if not (contact.active.any() and coarser.active.any()):
        return own
    return replace(own, pressure=max(own.pressure, pressure_change(contact, coarser) / CHANGE))
