"""Bodies of any shape with the accuracy of a half-space at their contact: Boussinesq's field and a smooth remainder."""

from fecontact.bodies.local.body import LocalBody

__all__ = ["LocalBody"]
