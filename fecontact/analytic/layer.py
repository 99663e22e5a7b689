"""Elastic layer on a rigid foundation: transform compliance, contact with a rigid paraboloid, and its limits."""

from fecontact.analytic.layer_contact import LARGEST_RATIO, LayerContact, paraboloid
from fecontact.analytic.layer_kernel import Base, bonded_kernel, compliance, frictionless_kernel
from fecontact.analytic.layer_limits import thick, thin_compressible, thin_incompressible

__all__ = [
    "LARGEST_RATIO",
    "Base",
    "LayerContact",
    "bonded_kernel",
    "compliance",
    "frictionless_kernel",
    "paraboloid",
    "thick",
    "thin_compressible",
    "thin_incompressible",
]
