"""A contact between two surfaces."""

from __future__ import annotations

from dataclasses import dataclass

from fecontact.bodies.protocol import Body, check_body
from fecontact.common.arguments import texts
from fecontact.common.checks import among, friction
from fecontact.common.errors import InputError
from fecontact.common.one_line import one_line


@one_line
@dataclass(frozen=True, eq=False)
class Contact:
    """Two surfaces that may touch, the slave first.

    Contact pressures are defined on the slave. Where its faces lie inside the master's faces (equal or nested meshes)
    forces on its nodes are exact; elsewhere mortar coupling is used, with either side as the slave.

    Parameters
    ----------
    slave, master : Body
    surfaces : (str, str), optional
        Names of their surfaces; optional for a body with one contact surface.
    swap : {'auto', 'never'}
        Whether sides may be swapped where faces do not match: the slave should be the coarser side for mortar coupling,
        the finer one for nodal forces.
    coupling : {'auto', 'nodal', 'mortar'}
        'nodal': forces on slave nodes; 'mortar': non-negative multipliers and weighted gaps over the exact overlap;
        'auto': nodal where faces match or nest and on rigid surfaces, mortar elsewhere.
    friction : float
        Coulomb's coefficient of friction, from 0 (the default, frictionless) to inf (rough: what touches sticks).
        Friction depends on the order of loads, see `Scene.solve_path`; `Scene.solve` is one step from the unloaded
        state.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="bottom", supports={"top": "xyz"})
    >>> fc.Contact(body, fc.RigidBody(fc.Plane())).surfaces
    ('bottom', 'surface')
    """

    slave: Body
    master: Body
    surfaces: tuple[str, str] | None = None
    swap: str = "auto"
    coupling: str = "auto"
    friction: float = 0.0

    def __post_init__(self) -> None:
        friction(self.friction, infinite=True)
        among("coupling", self.coupling, ("auto", "nodal", "mortar"))
        among("swap", self.swap, ("auto", "never"))
        for body in (self.slave, self.master):
            check_body(body)
        if self.slave is self.master:
            raise InputError(f"{self.slave.name!r} cannot be in contact with itself; give two bodies.")
        if self.surfaces is None:
            for body in (self.slave, self.master):
                if len(body.contact) != 1:
                    raise InputError(
                        f"{body.name!r} declares {len(body.contact)} contact surfaces "
                        f"({', '.join(body.contact) or 'none'}); say which: Contact(..., surfaces=(slave, master))."
                    )
            object.__setattr__(self, "surfaces", (self.slave.contact[0], self.master.contact[0]))
        elif len(pair := texts("surfaces", self.surfaces)) != 2:
            raise InputError(f"surfaces must be a pair of names, the slave's first; found {self.surfaces!r}.")
        else:
            object.__setattr__(self, "surfaces", pair)
        assert self.surfaces is not None
        self.slave.surface(self.surfaces[0])
        self.master.surface(self.surfaces[1])
