"""Surfaces for projection: faces of bodies, rigid shapes, height maps, rough and measured surfaces; solids in them."""

from fecontact.surfaces.profile import Profile, read_profile
from fecontact.surfaces.rigid.heightmap import FunctionSurface, HeightMap
from fecontact.surfaces.rigid.rough import PowerSpectrum, RoughSurface, detrend, fill_holes, power_spectrum, self_affine
from fecontact.surfaces.rigid.shapes import Cone, Cylinder, Ellipsoid, FlatPunch, Paraboloid, Torus
from fecontact.surfaces.rigid.topography import Topography, read_topography
from fecontact.surfaces.rigid.triangulated import Facets

__all__ = [
    "Cone",
    "Cylinder",
    "Ellipsoid",
    "Facets",
    "FlatPunch",
    "FunctionSurface",
    "HeightMap",
    "Paraboloid",
    "PowerSpectrum",
    "Profile",
    "RoughSurface",
    "Topography",
    "Torus",
    "detrend",
    "fill_holes",
    "power_spectrum",
    "read_profile",
    "read_topography",
    "self_affine",
]
