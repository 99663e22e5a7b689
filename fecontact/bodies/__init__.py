"""What can take part in a scene; all bodies meet the Protocol of `protocol`."""

from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.pose import Pose, rotation_about
from fecontact.bodies.protocol import Body
from fecontact.bodies.rigid import Plane, RigidBody, Sphere

__all__ = ["Body", "ElasticBody", "Plane", "Pose", "RigidBody", "Sphere", "rotation_about"]
