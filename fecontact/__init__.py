"""fecontact: frictionless elastic contact of solids, without penalties and with a certificate.

Examples
--------
>>> import fecontact as fc
>>> steel = fc.Material(E=210e3, nu=0.3)
>>> hertz = fc.hertz.spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
>>> round(hertz.a, 3)
1.795
"""

from fecontact import surfaces
from fecontact.analytic import hertz
from fecontact.ancf.body import AncfBody
from fecontact.app.scene_file.scene_file import read_scene
from fecontact.bodies import (
    AxisymmetricBody,
    Body,
    ElasticBody,
    ElasticLayer,
    HalfSpace,
    HalfSpaceContact,
    Layer,
    Plane,
    PlaneBody,
    Pose,
    RigidBody,
    Sphere,
    rotation_about,
)
from fecontact.common.errors import (
    FecontactError,
    InputError,
    MeshError,
    MissingPackageError,
    SolverError,
    SolverNotFoundError,
    SupportError,
)
from fecontact.common.material import Material
from fecontact.contact.contact import Contact
from fecontact.contact.springs import Spring
from fecontact.mesh import pick, shapes
from fecontact.mesh import section_shapes as sections
from fecontact.mesh.cad import mesh_solid
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.read import read_mesh
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.mesh.surface_mesh import SurfaceMesh, read_surface
from fecontact.results.result import ContactResult
from fecontact.scene.scene import Scene
from fecontact.solvers import available_solvers

__all__ = [
    "AncfBody",
    "AxisymmetricBody",
    "Body",
    "Contact",
    "ContactResult",
    "ElasticBody",
    "ElasticLayer",
    "FecontactError",
    "HalfSpace",
    "HalfSpaceContact",
    "InputError",
    "Layer",
    "Material",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "Plane",
    "PlaneBody",
    "Pose",
    "RigidBody",
    "Scene",
    "SectionMesh",
    "SolverError",
    "SolverNotFoundError",
    "Sphere",
    "Spring",
    "SupportError",
    "SurfaceMesh",
    "available_solvers",
    "hertz",
    "mesh_solid",
    "pick",
    "read_mesh",
    "read_scene",
    "read_surface",
    "rotation_about",
    "sections",
    "shapes",
    "surfaces",
]

__version__ = "0.1.0"
