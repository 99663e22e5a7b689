"""Bodies, contacts and springs of a scene, with checks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body, check_body
from fecontact.common.arguments import instance, items, texts
from fecontact.common.arrays import Array
from fecontact.common.directions import Directions
from fecontact.common.errors import InputError
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.contact.coupling.choose import CouplingChoice, choose_coupling, pair_chosen, sides
from fecontact.contact.coupling.nodal import SurfacePair
from fecontact.contact.dimension import check_contacts, setting_of
from fecontact.contact.interface import Interface
from fecontact.contact.loads import Loading
from fecontact.contact.springs import Spring


@dataclass(frozen=True, eq=False)
class SceneModel:
    """Bodies, contacts and springs of a scene, checked; `scene.Scene` documents them and adds what solves them."""

    bodies: Sequence[Body]
    contacts: Sequence[Contact]
    springs: Sequence[Spring] = ()
    units: Units | Sequence[str] = ()
    axes: Directions | Mapping[str, ArrayLike] | None = None
    notes: Sequence[str] = ()
    warnings: Sequence[str] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "bodies", items("the bodies of a scene", self.bodies, "bodies"))
        for name, kind in (("contacts", Contact), ("springs", Spring)):
            given = items(f"the {name} of a scene", getattr(self, name), f"{kind.__name__} objects")
            object.__setattr__(self, name, tuple(instance(f"each of the {name} of a scene", g, kind) for g in given))
        for name in ("notes", "warnings"):
            object.__setattr__(self, name, texts(f"the {name} of a scene", getattr(self, name)))
        object.__setattr__(self, "units", Units.of(self.units))
        object.__setattr__(self, "axes", Directions.of(self.axes))
        for body in self.bodies:
            check_body(body)
        if not self.contacts and not self.springs and not any(body._is_tied for body in self.bodies):
            raise InputError(
                "A scene needs a Contact, a Spring, or a body whose parts are tied (fc.tied).", code="no-contact"
            )
        if len({id(b) for b in self.bodies}) != len(self.bodies):
            raise InputError("A body is listed twice; use body.placed(...) to stand the same model in two places.")
        setting = setting_of(self.bodies)
        for contact in self.contacts:
            for body in contact.bodies:
                if not any(body is b for b in self.bodies):
                    raise InputError(
                        f"{body.name!r} is in a contact but not among the scene's bodies (compared by identity).",
                        code="not-in-scene",
                    )
        check_contacts(self.contacts)
        for spring in self.springs:
            setting.check_spring(spring)
            for owner in spring.carriers:
                if owner is not None and not any(owner is b for b in self.bodies):
                    raise InputError(
                        f"{owner.name!r}, to which {spring.name!r} is tied, is not among the scene's bodies.",
                        code="not-in-scene",
                    )

    def __getstate__(self) -> dict[str, Any]:
        """Without pairs, which are found again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def unit_names(self) -> Units:
        """Names of its units."""
        return cast(Units, self.units)

    @property
    def directions(self) -> Directions:
        """Names of directions, for axes of maps."""
        return cast(Directions, self.axes)

    @property
    def twists(self) -> bool:
        """Whether bodies of revolution turn about their axis, which leaves their surfaces as they are."""
        return any(body._dimension == "twist" for body in self.bodies)

    @cached_property
    def sizes(self) -> Array:
        """Lengths (n_bodies,) of the bodies; rigid shapes, of which some have none, take the largest of the others."""
        own = [b.size for b in self.bodies]
        largest = max((b.size for b in self.bodies if not b.is_rigid), default=max(own))
        return np.array([largest if b.is_rigid else b.size for b in self.bodies])

    @property
    def has_friction(self) -> bool:
        """Whether a contact has friction."""
        return any(contact.mu > 0 for contact in self.contacts)

    @property
    def has_overclosure(self) -> bool:
        """Whether a contact is soft."""
        return any(contact.overclosure is not None for contact in self.contacts)

    @property
    def has_nodes_alone(self) -> bool:
        """Whether a slave is a set of nodes."""
        return any(given.slave_surface.of_nodes for given, _ in self._seen)

    def interfaces(self, loading: Loading) -> tuple[Interface, ...]:
        """The contacts, paired over their whole surfaces as suits a load; kept for the next one that they suit."""
        out = []
        for k, contact in enumerate(self.contacts):
            given, seen = self._seen[k]
            chosen = choose_coupling(contact, given, seen, loading)
            key = (k, chosen.kind, chosen.slave is given.slave)
            if key not in self._paired:
                self._paired[key] = pair_chosen(given, chosen, seen)
            kept = self._paired[key]
            out.append(kept if kept.note == chosen.note else replace(kept, note=chosen.note))
        return tuple(out)

    @cached_property
    def _seen(self) -> list[tuple[CouplingChoice, SurfacePair]]:
        return [(given, given.surface_pair(None)) for given in map(sides, self.contacts)]

    @cached_property
    def _paired(self) -> dict[tuple[int, str, bool], Interface]:
        return {}
