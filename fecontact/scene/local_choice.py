"""Whether a local body would serve in the contacts of elastic bodies, in one sentence each."""

from __future__ import annotations

import re

import numpy as np

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.local import LocalBody
from fecontact.bodies.protocol import Body
from fecontact.common.errors import InputError
from fecontact.contact.contact import Contact
from fecontact.contact.loads import Loading
from fecontact.contact.model import SceneModel
from fecontact.scene.windows import WIDE, window_at_touch

CELLS = 64
"""Cells along a side of the window that is tried; only its place and its sides matter."""

FINE = 12
"""Faces across a contact with which finite elements alone resolve it to about 1 %."""

FIRST = re.compile(r"\. (?=[A-Z])")


def local_choices(model: SceneModel, loading: Loading) -> tuple[str, ...]:
    """For each contact of elastic bodies in space: whether local bodies serve, and why."""
    return tuple(f"{_sides(contact)}: {_told(contact, loading)}" for contact in model.contacts if _meshed(contact))


def _sides(contact: Contact) -> str:
    assert contact.surfaces is not None
    return f"{contact.slave.name}.{contact.surfaces[0]} on {contact.master.name}.{contact.surfaces[1]}"


def _meshed(contact: Contact) -> tuple[ElasticBody, ...]:
    """Its elastic bodies with displacements at the nodes of a mesh in space."""
    both = elastic_among((contact.slave, contact.master))
    return tuple(b for b in both if not b.mesh.is_flat and b.n_dofs == 3 * len(b.mesh.points))


def _told(contact: Contact, loading: Loading) -> str:
    """The sentence."""
    if contact.mu > 0:
        return "no local body, since it gives along its normal only and this contact has friction."
    try:
        windows = [_window(body, contact, loading) for body in _meshed(contact)]
    except InputError as error:
        # its first sentence; the others tell what else to do with a local body
        return f"no local body, but finite elements with accuracy=: {FIRST.split(str(error))[0].rstrip('.')}."
    return " ".join(windows)


def _window(body: ElasticBody, contact: Contact, loading: Loading) -> str:
    assert contact.surfaces is not None
    own, other = contact.surfaces if body is contact.slave else contact.surfaces[::-1]
    partner: Body = contact.master if body is contact.slave else contact.slave
    surface = body.surface(own)
    placed = window_at_touch(LocalBody(body, shape=(CELLS, CELLS)), surface, (body, partner), other, loading)
    sides = placed.window.grid.size
    k = np.argmin(np.linalg.norm(surface.points[surface.nodes] - placed.window.origin, axis=1))
    contact_sides = (sides[0] / WIDE, sides[1] / WIDE)
    across = min(contact_sides) / float(surface.mean_facet_size[surface.facets_of_node[k]].mean())
    resolved = "which resolve it too" if across >= FINE else f"of {FINE} or more that are needed without it"
    return (
        f"a local body of {body.name!r} serves: the contact is about {contact_sides[0]:.3g} x {contact_sides[1]:.3g}, "
        f"its window of {sides[0]:.3g} x {sides[1]:.3g} lies within one smooth face, and {across:.2g} faces lie across "
        f"the contact, {resolved}."
    )
