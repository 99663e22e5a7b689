"""Fields of a paired contact from the forces and gaps of its points."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.contact.interface import Interface
from fecontact.results.contact_fields import ContactFields
from fecontact.surfaces.facet_surface import FacetSurface


def _sharing(at_nodes: sp.csr_matrix, facets: IntArray) -> sp.csr_matrix:
    """Which contact points (n,) have a value at a node of which facet (n_facets,)."""
    facet = np.repeat(np.arange(len(facets)), facets.shape[1])
    around = sp.csr_matrix((np.ones(facets.size), (facets.ravel(), facet)), shape=(at_nodes.shape[0], len(facets)))
    values = abs(at_nodes)
    values.eliminate_zeros()
    return sp.csr_matrix(values.T @ around)


def contact_fields(
    interface: Interface,
    candidates: IntArray,
    forces: Array,
    gap: Array,
    displacements: tuple[Array, Array],
    swapped: bool = False,
) -> ContactFields:
    """Fields of a paired contact from the forces (n,) and gaps (n,) of its points.

    Parameters
    ----------
    swapped : bool
        Whether the slave is the body named second in the `Contact`.
    """
    slave, pairing = interface.slave, interface.pairing
    surface = interface.slave_surface
    shown, local = np.unique(surface.facets[pairing.covered], return_inverse=True)
    first = interface.master if swapped else slave
    reference = first.pose.to_world(first.reference_point)
    normals, centres, couples = _lines_of_action(interface, surface, reference)
    return ContactFields(
        slave=slave,
        master=interface.master,
        surfaces=interface.surfaces,
        points=slave.pose.to_world(pairing.slave_points),
        normals=normals,
        centres=centres,
        couples=couples,
        weights=pairing.weights,
        forces=pairing.of_points(forces),
        gap=gap,
        candidates=candidates,
        nodes=slave.pose.to_world(surface.points[shown]),
        node_numbers=shown,
        at_nodes=pairing.at_nodes[shown],
        facets=local.reshape(-1, surface.facets.shape[1]),
        facet_numbers=pairing.covered,
        sharing=_sharing(pairing.at_nodes, surface.facets),
        reference_point=reference,
        displacements=displacements,
        coupling=pairing.coupling,
        note=interface.note,
        swapped=swapped,
    )


def _lines_of_action(interface: Interface, surface: FacetSurface, reference: Array) -> tuple[Array, Array, Array]:
    """`normals`, `centres` and `couples` of `ContactFields`, the latter about a reference point (3,)."""
    slave, pairing, turn = interface.slave, interface.pairing, interface.slave.pose.rotation
    if pairing.sums is not None:
        s = pairing.sums
        couples = s.moments + np.cross(s.origin - slave.pose.to_body(reference), s.normals)
        return s.normals @ turn.T, slave.pose.to_world(s.centres), couples @ turn.T
    samples = slave.pose.to_world(pairing.slave_weights @ surface.points)
    vectors = pairing.slave_normals @ turn.T
    if surface.out_of_plane is not None:
        # the force on a ring is the sum over its circumference
        samples, vectors = surface.out_of_plane.mean(samples), surface.out_of_plane.mean(vectors)
    moments = np.cross(samples - reference, vectors)
    return pairing.average @ vectors, pairing.average @ samples, pairing.average @ moments
