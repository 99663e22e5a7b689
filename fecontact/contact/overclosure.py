"""Soft contact: surfaces that overlap under a pressure, as by a thin layer or asperities between them.

A pressure p = k d grows with the overlap d of the surfaces, the overclosure. With the gap w = -d this is

    w + p / k >= 0,   p >= 0,   p (w + p / k) = 0

which is hard contact with a compliance 1 / (k A) of each point of area A for itself, beside that of the bodies: an
elastic (Winkler) foundation between them. It is solved as exactly as hard contact, the limit of an infinite k.

Source: K. L. Johnson, Contact Mechanics, 1985, section 4.3 (the foundation).
"""

from __future__ import annotations

from dataclasses import dataclass

from fecontact.bodies.body import Body
from fecontact.common.checks import positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError


@compact_repr
@dataclass(frozen=True, eq=False)
class SoftContact:
    """Pressure by overclosure, for `Contact(..., overclosure=)`.

    Parameters
    ----------
    stiffness : float
        Pressure per overclosure (force / length^3), positive: that of a layer is its modulus over its thickness.

    Raises
    ------
    InputError
        If it is not positive and finite.

    Examples
    --------
    A column of stiffness E / h on a layer of stiffness k, pressed by u: p = u / (h / E + 1 / k).

    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor, overclosure=fc.SoftContact(3.0))])
    >>> contact = scene.solve(motions={body: {"z": -0.02}}).contacts[0]
    >>> contact.pressure.round(12).tolist()[0], contact.overclosure.round(12).tolist()[0]
    (0.015, 0.005)
    """

    stiffness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", positive("the stiffness of a soft contact", self.stiffness))

    def check(self, body: Body) -> None:
        """Refuse bodies whose contact is not served.

        Raises
        ------
        InputError
        """
        if body._finite_strain is not None or body._matrix_free:
            what = (
                "has a law of finite strain" if body._finite_strain is not None else "is a half-space or has its cells"
            )
            raise InputError(
                f"{body.name!r} {what}: a soft contact is offered for small strains on meshed and rigid surfaces. "
                "Leave overclosure out, or model the layer by cells.",
                code="soft-contact-body",
            )
