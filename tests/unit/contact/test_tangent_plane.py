"""Charts of kites at and beyond their fold, and on hexahedra made of tetrahedra: finite, and no warning."""

import warnings

import numpy as np
import pytest

import fecontact as fc
from fecontact import Mesh
from fecontact.contact.coupling.segments import _nearness, degrees, tangent_plane_maps
from fecontact.mesh.kinds import KINDS
from fecontact.mesh.refine import divided
from fecontact.surfaces.facet_surface import FacetSurface

pytestmark = pytest.mark.rounding

SIX = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]


def cut_block(n, z):
    base = fc.shapes.block((1.0, 1.0, 1.0), (n, n, n), element="hex8")
    tets = Mesh(base.points, KINDS["tet4"].to_hexahedra(np.concatenate([base.cells[:, p] for p in SIX])))
    for name, at in (("bottom", 0.0), ("top", 1.0)):
        tets = tets.with_boundary(name, lambda x, at=at: np.abs(x[:, 2] - at) < 1e-9)
    return divided(tets).mapped(lambda x: x + np.array([0, 0, z]))


def test_points_on_and_beyond_the_fold_of_a_kite():
    kite = FacetSurface(np.array([[0, 0, 0], [1, 0, 0], [0.7, 0.7, 0], [0, 1, 0.0]]), np.array([[0, 1, 2, 3]]))
    with warnings.catch_warnings(), np.errstate(divide="raise", invalid="raise"):
        warnings.simplefilter("error")
        plane_map = tangent_plane_maps(kite)
        assert plane_map.taper[0] > 0
        x = np.linspace(-9, 9, 37)
        points = np.stack([a.ravel() for a in np.meshgrid(x, x)], axis=1)
        c, d = plane_map.centre[0], plane_map.twist[0]
        whole = plane_map.along_s[0, 0] * plane_map.along_t[0, 1] - plane_map.along_s[0, 1] * plane_map.along_t[0, 0]
        # lines through the centre along either side, on which one numerator is zero, as far as beyond the fold
        lines = [c + t * v[0] for v in (plane_map.along_s, plane_map.along_t) for t in np.linspace(-50, 50, 201)]
        points = np.concatenate([points, lines, [c + whole * np.array([-d[1], d[0]]) / (d @ d)]])
        facet = np.zeros(len(points), int)
        local, jacobian = plane_map.from_plane(facet, points)
        assert np.isfinite(local).all()
        assert np.isfinite(jacobian).all()
        back = plane_map.to_plane(facet, local)
        inside = ((local >= 0) & (local <= 1)).all(axis=1)
        # rounding of coordinates of order one
        assert np.abs(back - points)[inside].max() < 1e-13
        folded = points[[0]] + np.array([[[0.0, 0], [1, 0], [0, 1]]])
        assert 0 <= _nearness(plane_map, np.zeros(1, int), folded)[0] <= 1
        far = np.repeat(np.array([[[40.0, 40.0]]]), 3, axis=1)
        assert _nearness(plane_map, np.zeros(1, int), far)[0] <= 1
        assert degrees(plane_map, np.zeros(1, int), far, np.zeros(1)).shape == (1,)


def test_hexahedra_made_of_tetrahedra_meet_by_mortar_without_a_warning():
    with warnings.catch_warnings(), np.errstate(divide="raise", invalid="raise"):
        warnings.simplefilter("error")
        material = fc.Material(1.0, 0.0)
        lower = fc.ElasticBody(cut_block(2, -1.0), material, "top", {"bottom": "z", "top": "xy"}, name="lower")
        upper = fc.ElasticBody(cut_block(3, 0.0), material, "bottom", {"top": "z", "bottom": "xy"}, name="upper")
        scene = fc.Scene([lower, upper], [fc.Contact(upper, lower, coupling="mortar")])
        contact = scene.solve(motions={upper: {"z": -0.02}}).contacts[0]
        # two columns of unit length, shortened by 0.01 each: the patch test
        assert np.abs(contact.pressure - 0.01).max() < 1e-9
