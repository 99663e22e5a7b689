"""Surfaces and solids trimmed by planes, boxes and spheres: areas, volumes, names, and what is refused."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.surfaces.repair import enclosed_volume

pytest.importorskip("manifold3d")

BLOCK = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2))
SKIN = fc.SurfaceMesh(BLOCK.points, BLOCK.skin)


def volume(surface):
    return enclosed_volume(surface.points, surface.facets)


def test_a_plane_leaves_the_side_against_its_normal():
    """Source: a prism of trapezia, whose volume and area are those of the mean length."""
    cut = ((0.7, 0.5, 0.0), (2.0, 1.0, 0.0))
    kept, rest = (fc.trimmed(SKIN, plane=cut, outside=outside) for outside in (False, True))
    assert kept.is_closed
    assert abs(volume(kept) - 0.7) < 1e-12
    assert abs(volume(rest) - 1.3) < 1e-12
    assert abs(kept.areas.sum() - (2 * 0.7 + 2 * 0.7 + 1 + np.sqrt(5) / 2)) < 1e-12
    # the unit and the place round nothing away
    far = fc.SurfaceMesh(1e3 * BLOCK.points + 5e3, BLOCK.skin)
    there = fc.trimmed(far, plane=((5700.0, 5500.0, 5000.0), cut[1]))
    assert abs(volume(there) / 1e9 - 0.7) < 1e-9


def test_a_box_and_a_sphere_leave_what_lies_within():
    assert abs(volume(fc.trimmed(SKIN, box=((0.5, 0.25, -1), (1.5, 2, 0.5)))) - 0.375) < 1e-12
    assert abs(volume(fc.trimmed(SKIN, box=((0.5, 0.25, -1), (1.5, 2, 0.5)), outside=True)) - 1.625) < 1e-12
    # an eighth of a ball, as a polyhedron of 128 sides
    ball = volume(fc.trimmed(SKIN, sphere=((0, 0, 0), 0.8)))
    assert 0 < 1 - ball / (np.pi / 6 * 0.8**3) < 2e-3


def test_a_trimmed_solid_keeps_names():
    """Source: the volume and the areas of a block."""
    mesh = fc.trimmed(BLOCK, plane=((1.2, 0, 0), (1, 0, 0)), size=0.6)
    assert list(mesh.kinds) == ["tet10"]
    assert abs(moments_of_volume(mesh)[0] - 1.2) < 1e-9
    areas = {name: fc.SurfaceMesh.of(mesh, name).areas.sum() for name in mesh.boundaries}
    wanted = {"cut": 1.0, "x_min": 1.0, "y_min": 1.2, "y_max": 1.2, "bottom": 1.2, "top": 1.2}
    assert set(areas) == set(wanted)
    assert max(abs(areas[name] - wanted[name]) for name in wanted) < 1e-9


def test_what_cannot_be_trimmed_is_refused():
    plane = ((0.7, 0, 0), (1, 0, 0))
    with refused(fc.InputError, "input", "Give one of plane, box and sphere; found none"):
        fc.trimmed(SKIN)
    with refused(fc.InputError, "input", "plane and sphere"):
        fc.trimmed(SKIN, plane=plane, sphere=((0, 0, 0), 1.0))
    with refused(fc.InputError, "input", "Nothing is left"):
        fc.trimmed(SKIN, plane=((-1, 0, 0), (1, 0, 0)))
    with refused(fc.InputError, "input", "Everything is left"):
        fc.trimmed(SKIN, sphere=((0, 0, 0), 9.0))
    with refused(fc.InputError, "input", "normal"):
        fc.trimmed(SKIN, plane=((0, 0, 0), (0, 0, 0)))
    with refused(fc.InputError, "input", "corners"):
        fc.trimmed(SKIN, box=((0, 0, 0), (1, -1, 1)))
    with refused(fc.InputError, "input", "size="):
        fc.trimmed(SKIN, plane=plane, size=0.5)
    with refused(fc.InputError, "input", "a pair"):
        fc.trimmed(SKIN, box=3.0)
    with refused(fc.MeshError, "open-surface"):
        fc.trimmed(fc.SurfaceMesh(BLOCK.points, BLOCK.skin[1:]), plane=plane)


def test_without_the_package_it_is_named(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with refused(fc.MissingPackageError, "missing-package", "fecontact[solids]"):
        fc.trimmed(SKIN, plane=((0.7, 0, 0), (1, 0, 0)))
