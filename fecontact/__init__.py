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
    from fecontact.app.joint.cartilage import cartilage_sides, thickness_between
    from fecontact.app.joint.joint import Joint
    from fecontact.app.joint.knee_angles import GroodSuntay
    from fecontact.app.joint.ligament import Ligament, read_ligaments
    from fecontact.app.joint.motion_file import Motion, read_motion
    from fecontact.app.joint.opensim import OpenSimModel, read_osim
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
    from fecontact.common.anisotropic import AnisotropicMaterial, CylindricalAxes, OrthotropicMaterial
    from fecontact.common.error_estimate import ErrorEstimate
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
    from fecontact.common.region import Region
    from fecontact.common.viscoelastic import Viscoelastic
    from fecontact.contact.contact import Contact
    from fecontact.contact.overclosure import SoftContact
    from fecontact.contact.springs import Spring
    from fecontact.contact.strands import WrapCylinder
    from fecontact.fem.fibres import Fibres
    from fecontact.fem.laws import HolmesMow, MooneyRivlin, NeoHookean, Ogden, StVenantKirchhoff
    from fecontact.halfspace import (
        AdhesionCurve,
        AdhesiveContact,
        CreepCoefficients,
        CreepCurve,
        Dugdale,
        FallingFriction,
        FrictionContact,
        FrictionPath,
        HalfSpaceContact,
        Layer,
        LoadCurve,
        MovingContact,
        PressStep,
        RollingContact,
    )
    from fecontact.mesh import pick, shapes
    from fecontact.mesh import section_shapes as sections
    from fecontact.mesh.layer import extrude
    from fecontact.mesh.mesh import Mesh, merge
    from fecontact.mesh.read import read_mesh, read_section, read_surface
    from fecontact.mesh.section_mesh import SectionMesh
    from fecontact.mesh.surface_mesh import SurfaceMesh
    from fecontact.results.case_table import CaseTable
    from fecontact.results.contact_fields import ContactFields
    from fecontact.results.convergence import Convergence
    from fecontact.results.friction_fields import FrictionFields
    from fecontact.results.result import ContactResult
    from fecontact.results.resultants import DividingPlane
    from fecontact.scene.cost import Explanation
    from fecontact.scene.load_path import LoadPath
    from fecontact.scene.scene import Scene
    from fecontact.scene.wheel_rail import WheelRail, WheelRailContact, WheelRailPath
    from fecontact.solvers import available_solvers
    from fecontact.surfaces.repair import repair_surface
    from fecontact.surfaces.solid import mesh_solid
    from fecontact.surfaces.tied import tied
    from fecontact.surfaces.trim import trimmed

__all__ = [
    "AdhesionCurve",
    "AdhesiveContact",
    "AncfBody",
    "AnisotropicMaterial",
    "AssembledBody",
    "AxisymmetricBody",
    "Body",
    "CaseTable",
    "Contact",
    "ContactFields",
    "ContactResult",
    "Convergence",
    "CreepCoefficients",
    "CreepCurve",
    "CylindricalAxes",
    "DividingPlane",
    "Dugdale",
    "ElasticBody",
    "ElasticLayer",
    "ErrorEstimate",
    "Explanation",
    "FallingFriction",
    "FecontactError",
    "Fibres",
    "FrictionContact",
    "FrictionFields",
    "FrictionPath",
    "GroodSuntay",
    "HalfSpace",
    "HalfSpaceContact",
    "HolmesMow",
    "InputError",
    "Joint",
    "Layer",
    "Ligament",
    "LoadCurve",
    "LoadPath",
    "LocalBody",
    "Material",
    "Mesh",
    "MeshError",
    "MissingPackageError",
    "MooneyRivlin",
    "Motion",
    "MovingContact",
    "NeoHookean",
    "Ogden",
    "OpenSimModel",
    "OrthotropicMaterial",
    "Plane",
    "PlaneBody",
    "Pose",
    "PressStep",
    "Region",
    "RigidBody",
    "RollingContact",
    "Scene",
    "SectionMesh",
    "SoftContact",
    "SolverError",
    "SolverNotFoundError",
    "Sphere",
    "Spring",
    "StVenantKirchhoff",
    "SupportError",
    "SurfaceMesh",
    "Viscoelastic",
    "WheelRail",
    "WheelRailContact",
    "WheelRailPath",
    "WindowedBody",
    "WrapCylinder",
    "available_solvers",
    "cartilage_sides",
    "extrude",
    "hertz",
    "merge",
    "mesh_solid",
    "pick",
    "read_ligaments",
    "read_mesh",
    "read_motion",
    "read_osim",
    "read_scene",
    "read_section",
    "read_surface",
    "repair_surface",
    "rotation_about",
    "sections",
    "shapes",
    "surfaces",
    "thickness_between",
    "tied",
    "trimmed",
]

__version__ = VERSION

#: Modules of the public names, imported on first use (PEP 562), so that numerical packages are not imported before.
_MODULES = {
    "ancf.bricks.body": "AncfBody",
    "app.joint.cartilage": "cartilage_sides thickness_between",
    "app.joint.joint": "Joint",
    "app.joint.knee_angles": "GroodSuntay",
    "app.joint.ligament": "Ligament read_ligaments",
    "app.joint.motion_file": "Motion read_motion",
    "app.joint.opensim": "OpenSimModel read_osim",
    "app.scene_file.scene_file": "read_scene",
    "bodies": "AssembledBody AxisymmetricBody Body ElasticBody ElasticLayer HalfSpace LocalBody Plane PlaneBody Pose "
    "RigidBody Sphere WindowedBody rotation_about",
    "common.anisotropic": "AnisotropicMaterial CylindricalAxes OrthotropicMaterial",
    "common.error_estimate": "ErrorEstimate",
    "common.errors": "FecontactError InputError MeshError MissingPackageError SolverError SolverNotFoundError "
    "SupportError",
    "common.material": "Material",
    "common.region": "Region",
    "common.viscoelastic": "Viscoelastic",
    "contact.contact": "Contact",
    "contact.overclosure": "SoftContact",
    "contact.springs": "Spring",
    "contact.strands": "WrapCylinder",
    "fem.fibres": "Fibres",
    "fem.laws": "HolmesMow MooneyRivlin NeoHookean Ogden StVenantKirchhoff",
    "halfspace": "AdhesionCurve AdhesiveContact CreepCoefficients CreepCurve Dugdale FallingFriction FrictionContact "
    "FrictionPath HalfSpaceContact Layer LoadCurve MovingContact PressStep RollingContact",
    "mesh.layer": "extrude",
    "mesh.mesh": "Mesh merge",
    "mesh.read": "read_mesh read_section read_surface",
    "mesh.section_mesh": "SectionMesh",
    "mesh.surface_mesh": "SurfaceMesh",
    "results.case_table": "CaseTable",
    "results.contact_fields": "ContactFields",
    "results.convergence": "Convergence",
    "results.friction_fields": "FrictionFields",
    "results.result": "ContactResult",
    "results.resultants": "DividingPlane",
    "scene.cost": "Explanation",
    "scene.load_path": "LoadPath",
    "scene.scene": "Scene",
    "scene.wheel_rail": "WheelRail WheelRailContact WheelRailPath",
    "solvers": "available_solvers",
    "surfaces.repair": "repair_surface",
    "surfaces.solid": "mesh_solid",
    "surfaces.tied": "tied",
    "surfaces.trim": "trimmed",
}
#: Place of each public name; some are modules.
_PLACES = {name: f"fecontact.{module}:{name}" for module, names in _MODULES.items() for name in names.split()} | {
    "hertz": "fecontact.analytic.hertz",
    "pick": "fecontact.mesh.pick",
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
