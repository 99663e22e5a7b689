"""Bodies with a compliance, rigid modes and a surface: elastic, rigid, sections, layers, half-spaces."""

from fecontact.bodies.assembled import AssembledBody
from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.layer import ElasticLayer
from fecontact.bodies.local.body import LocalBody, WindowedBody
from fecontact.bodies.pose import Pose, rotation_about
from fecontact.bodies.rigid import Plane, RigidBody, Sphere
from fecontact.bodies.section import AxisymmetricBody, PlaneBody
from fecontact.bodies.surface_body import SurfaceBody, boundary_surface

__all__ = [
    "AssembledBody",
    "AxisymmetricBody",
    "Body",
    "ElasticBody",
    "ElasticLayer",
    "HalfSpace",
    "LocalBody",
    "Plane",
    "PlaneBody",
    "Pose",
    "RigidBody",
    "Sphere",
    "SurfaceBody",
    "WindowedBody",
    "boundary_surface",
    "rotation_about",
]
