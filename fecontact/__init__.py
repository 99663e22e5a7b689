"""fecontact: elastic contact of solids, with friction or without, without penalties and with a certificate.

Examples
--------
>>> import fecontact as fc
>>> steel = fc.Material(E=210e3, nu=0.3)
>>> hertz = fc.hertz.spheres(radii=(250.0, 250.0), materials=(steel, steel), force=7124.0)
>>> round(hertz.a, 3)
1.795
"""

import pkgutil
from typing import TYPE_CHECKING

from fecontact.common.version import VERSION

if TYPE_CHECKING:
    from fecontact import surfaces
    from fecontact.analytic import hertz
    from fecontact.ancf.bricks.body import AncfBody
    from fecontact.app.joint.joint import Joint
    from fecontact.app.joint.knee_angles import GroodSuntay
    from fecontact.app.joint.motion_file import read_motion
    from fecontact.app.scene_file.scene_file import read_scene
    from fecontact.bodies import (
        AssembledBody,
        AxisymmetricBody,
        Body,
        ElasticBody,
        ElasticLayer,
        HalfSpace,
        LocalBody,
        Plane,
        PlaneBody,
        Pose,
        RigidBody,
        Sphere,
        WindowedBody,
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
    from fecontact.fem.laws import HolmesMow, MooneyRivlin, NeoHookean, Ogden, StVenantKirchhoff
    from fecontact.halfspace import FrictionContact, FrictionPath, HalfSpaceContact, Layer, LoadCurve, PressStep
    from fecontact.mesh import pick, shapes
    from fecontact.mesh import section_shapes as sections
    from fecontact.mesh.layer import extrude
    from fecontact.mesh.mesh import Mesh, merge
    from fecontact.mesh.read import read_mesh, read_section, read_surface
    from fecontact.mesh.section_mesh import SectionMesh
    from fecontact.mesh.surface_mesh import SurfaceMesh
    from fecontact.results.case_table import CaseTable
    from fecontact.results.result import ContactResult
    from fecontact.results.resultants import DividingPlane
    from fecontact.scene.scene import Scene
    from fecontact.solvers import available_solvers
    from fecontact.surfaces.repair import repair_surface
    from fecontact.surfaces.solid import mesh_solid

__all__ = [
    "AncfBody",
    "AssembledBody",
    "AxisymmetricBody",
    "Body",
    "CaseTable",
    "Contact",
    "ContactResult",
    "DividingPlane",
    "ElasticBody",
    "ElasticLayer",
    "FecontactError",
    "FrictionContact",
    "FrictionPath",
    "GroodSuntay",
    "HalfSpace",
    "HalfSpaceContact",
    "HolmesMow",
    "InputError",
    "Joint",
    "Layer",
    "LoadCurve",
    "LocalBody",
    "Material",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Plane",
    "PlaneBody",
    "Pose",
    "PressStep",
    "RigidBody",
    "Scene",
    "SectionMesh",
    "SolverError",
    "SolverNotFoundError",
    "Sphere",
    "Spring",
    "StVenantKirchhoff",
    "SupportError",
    "SurfaceMesh",
    "WindowedBody",
    "available_solvers",
    "extrude",
    "hertz",
    "merge",
    "mesh_solid",
    "pick",
    "read_mesh",
    "read_motion",
    "read_scene",
    "read_section",
    "read_surface",
    "repair_surface",
    "rotation_about",
    "sections",
    "shapes",
    "surfaces",
]

__version__ = VERSION

#: Module of each public name, imported on first use (PEP 562), so that numerical packages are not imported before.
_PLACES = {
    "AncfBody": "fecontact.ancf.bricks.body:AncfBody",
    "AssembledBody": "fecontact.bodies:AssembledBody",
    "AxisymmetricBody": "fecontact.bodies:AxisymmetricBody",
    "Body": "fecontact.bodies:Body",
    "CaseTable": "fecontact.results.case_table:CaseTable",
    "Contact": "fecontact.contact.contact:Contact",
    "ContactResult": "fecontact.results.result:ContactResult",
    "DividingPlane": "fecontact.results.resultants:DividingPlane",
    "ElasticBody": "fecontact.bodies:ElasticBody",
    "ElasticLayer": "fecontact.bodies:ElasticLayer",
    "FecontactError": "fecontact.common.errors:FecontactError",
    "FrictionContact": "fecontact.halfspace:FrictionContact",
    "FrictionPath": "fecontact.halfspace:FrictionPath",
    "GroodSuntay": "fecontact.app.joint.knee_angles:GroodSuntay",
    "HalfSpace": "fecontact.bodies:HalfSpace",
    "HalfSpaceContact": "fecontact.halfspace:HalfSpaceContact",
    "HolmesMow": "fecontact.fem.laws:HolmesMow",
    "InputError": "fecontact.common.errors:InputError",
    "Joint": "fecontact.app.joint.joint:Joint",
    "Layer": "fecontact.halfspace:Layer",
    "LoadCurve": "fecontact.halfspace:LoadCurve",
    "LocalBody": "fecontact.bodies:LocalBody",
    "WindowedBody": "fecontact.bodies:WindowedBody",
    "Material": "fecontact.common.material:Material",
    "Mesh": "fecontact.mesh.mesh:Mesh",
    "MeshError": "fecontact.common.errors:MeshError",
    "MissingPackageError": "fecontact.common.errors:MissingPackageError",
    "MooneyRivlin": "fecontact.fem.laws:MooneyRivlin",
    "NeoHookean": "fecontact.fem.laws:NeoHookean",
    "Ogden": "fecontact.fem.laws:Ogden",
    "Plane": "fecontact.bodies:Plane",
    "PlaneBody": "fecontact.bodies:PlaneBody",
    "Pose": "fecontact.bodies:Pose",
    "PressStep": "fecontact.halfspace:PressStep",
    "RigidBody": "fecontact.bodies:RigidBody",
    "Scene": "fecontact.scene.scene:Scene",
    "SectionMesh": "fecontact.mesh.section_mesh:SectionMesh",
    "SolverError": "fecontact.common.errors:SolverError",
    "SolverNotFoundError": "fecontact.common.errors:SolverNotFoundError",
    "Sphere": "fecontact.bodies:Sphere",
    "Spring": "fecontact.contact.springs:Spring",
    "StVenantKirchhoff": "fecontact.fem.laws:StVenantKirchhoff",
    "SupportError": "fecontact.common.errors:SupportError",
    "SurfaceMesh": "fecontact.mesh.surface_mesh:SurfaceMesh",
    "available_solvers": "fecontact.solvers:available_solvers",
    "extrude": "fecontact.mesh.layer:extrude",
    "hertz": "fecontact.analytic.hertz",
    "merge": "fecontact.mesh.mesh:merge",
    "mesh_solid": "fecontact.surfaces.solid:mesh_solid",
    "pick": "fecontact.mesh.pick",
    "read_mesh": "fecontact.mesh.read:read_mesh",
    "read_motion": "fecontact.app.joint.motion_file:read_motion",
    "read_scene": "fecontact.app.scene_file.scene_file:read_scene",
    "read_section": "fecontact.mesh.read:read_section",
    "read_surface": "fecontact.mesh.read:read_surface",
    "repair_surface": "fecontact.surfaces.repair:repair_surface",
    "rotation_about": "fecontact.bodies:rotation_about",
    "sections": "fecontact.mesh.section_shapes",
    "shapes": "fecontact.mesh.shapes",
    "surfaces": "fecontact.surfaces",
}
#: Rooms that are attributes of the package too; the public ones are above.
_ROOMS = ("common", "analytic", "solvers", "mesh", "fem", "bodies", "ancf", "contact", "results", "scene", "app")


def __dir__() -> list[str]:
    """The public names."""
    return sorted([*__all__, "__all__", "__doc__", "__file__", "__name__", "__path__", "__version__"])


if not TYPE_CHECKING:  # for a type checker a name is public or does not exist

    def __getattr__(name: str) -> object:
        """A public name or a room, imported on first use."""
        place = f"fecontact.{name}" if name in _ROOMS else _PLACES.get(name)
        if place is None:
            rooms = () if name.startswith("_") else ("shapes", "sections", "surfaces")
            meant = [f"fecontact.{room}.{name}" for room in rooms if hasattr(pkgutil.resolve_name(_PLACES[room]), name)]
            hint = f"; did you mean {meant[0]}?" if meant else ""
            raise AttributeError(f"module 'fecontact' has no attribute {name!r}{hint}")
        globals()[name] = found = pkgutil.resolve_name(place)
        return found
