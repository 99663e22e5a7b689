"""Rigid surfaces: simple shapes, height maps, functions, rough surfaces, and measured topographies."""

from fecontact.surfaces.facets import Facets
from fecontact.surfaces.heightmap import FunctionSurface, HeightMap
from fecontact.surfaces.rough import RoughSurface, detrend, self_affine
from fecontact.surfaces.shapes import Cone, Cylinder, Ellipsoid, FlatPunch, Paraboloid, Torus
from fecontact.surfaces.topography import Topography, read_topography

__all__ = [
    "Cone",
    "Cylinder",
    "Ellipsoid",
    "Facets",
    "FlatPunch",
    "FunctionSurface",
    "HeightMap",
    "Paraboloid",
    "RoughSurface",
    "Topography",
    "Torus",
    "detrend",
    "read_topography",
    "self_affine",
]
