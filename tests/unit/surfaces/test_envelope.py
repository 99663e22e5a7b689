"""Solids within surfaces that cross themselves, branch or have holes, and within those that gmsh does not follow."""

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.surface_mesh import averaged_normals
from fecontact.surfaces import solid
from fecontact.surfaces.repair import enclosed_volume

needs_package = pytest.mark.skipif(not solid.available(), reason="needs the package pytetwild")


def box(low, high):
    """Points and outward triangles of a box."""
    low, high = np.array(low), np.array(high)
    x = low + (high - low) * np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return x, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def together(*parts):
    start = np.cumsum([0, *(len(x) for x, _ in parts)])
    triangles = [t + s for (_, t), s in zip(parts, start[:-1], strict=True)]
    return np.concatenate([x for x, _ in parts]), np.concatenate(triangles)


def surface(points, triangles):
    return fc.SurfaceMesh(points, triangles[:, [0, 1, 2, 2]])


CROSSING = together(box((0, 0, 0), (2, 1, 1)), box((1.1, 0.25, 0.25), (3, 0.75, 0.75)))


@pytest.fixture(scope="module")
def union():
    return fc.mesh_solid(surface(*CROSSING), size=0.5)


@needs_package
def test_boxes_that_cross_are_one_body(union):
    """Source: the volume of the union of two boxes, 2 + 1 * .5 * .5; the body is pressed by a plane."""
    assert abs(moments_of_volume(union)[0] - 2.25) < 0.005 * 2.25
    check_mesh(union)
    assert list(union.groups) == ["volume_1"]
    assert any("runs through itself" in note and "wind round" in note for note in union.notes)
    assert not union.warnings
    # the bounds of the boxes, to the width of the envelope
    assert np.abs(union.points.min(axis=0) - [0, 0, 0]).max() < 0.01
    assert np.abs(union.points.max(axis=0) - [3, 1, 1]).max() < 0.01
    mesh = union.with_boundary("top", fc.pick.facing((0, 0, 1), angle=20)).with_boundary(
        "foot", fc.pick.facing((0, 0, -1), angle=20)
    )
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"foot": "xyz"}, geometry="plain")
    plate = fc.RigidBody(fc.Plane(), pose=fc.Pose(fc.rotation_about((1, 0, 0), np.pi), (0, 0, 1.0)))
    result = fc.Scene([body, plate], [fc.Contact(body, plate)]).solve(motions={plate: {"z": -0.02}})
    assert result.residuals().penetration < 1e-9
    # between the box alone in one-dimensional compression and in uniaxial stress, E eps A
    assert 0.02 * 2 * 0.5 < -result.contacts[0].force[2] < 0.02 * 2 * 1.6


@needs_package
def test_nothing_is_left_in_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fc.mesh_solid(surface(*CROSSING), size=1.0)
    assert not list(tmp_path.iterdir())


@needs_package
def test_cells_are_of_good_shape(union):
    """Source: Liu and Joe's mean ratio, 12 (3 V)^(2/3) over the sum of squared edges: 1 for a regular tetrahedron."""
    x = union.points[union.cells[:, [0, 1, 2, 4]]]
    volume = np.abs(np.linalg.det(x[:, 1:] - x[:, :1])) / 6
    squares = sum(((x[:, i] - x[:, j]) ** 2).sum(axis=1) for i in range(4) for j in range(i))
    assert (12 * (3 * volume) ** (2 / 3) / squares).min() > 0.15


@needs_package
def test_a_wall_within_is_left_out(tmp_path):
    """Source: a box of 2; sides at the wall belong to three facets, so that the file is no surface."""
    x, t = box((0, 0, 0), (2, 1, 1))
    low, high = box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))
    x, t = together(low, high)
    apart = ~(np.abs(x[t][:, :, 0] - 1.0) < 1e-12).all(axis=1)
    apart[np.argmin(apart)] = True
    apart[np.flatnonzero(~apart)[0]] = True
    meshio.Mesh(x, [("triangle", t[apart])]).write(tmp_path / "wall.stl")
    with refused(fc.MeshError, "mesh", "branches"):
        fc.read_surface(tmp_path / "wall.stl")
    mesh = fc.mesh_solid(tmp_path / "wall.stl", size=0.5, element="tet4")
    assert abs(moments_of_volume(mesh)[0] - 2) < 0.01
    assert "wall.stl is no surface with an outside" in mesh.notes[0]


def test_what_needs_the_package_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(solid, "available", lambda: False)
    with refused(fc.MeshError, "crosses-itself", "fecontact[solids]"):
        fc.mesh_solid(surface(*CROSSING))
    x, t = box((0, 0, 0), (2, 1, 1))
    meshio.Mesh(x, [("triangle", np.concatenate([t, [[0, 3, 4]]]))]).write(tmp_path / "wall.stl")
    with refused(fc.MeshError, "mesh", "fecontact[solids]"):
        fc.mesh_solid(tmp_path / "wall.stl")


def test_small_holes_are_filled_and_large_ones_refused():
    """Source: the box's own volume; a hole of 1 / 20 of its area is flat."""
    block = fc.shapes.block((1.0, 1.0, 2.0), (4, 4, 8), element="hex8")
    quads = block.skin[:, :4]
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    z, middle = block.points[triangles][:, :, 2], block.points[triangles].mean(axis=1)
    top = (z.min(axis=1) > 2 - 1e-9) & (np.abs(middle[:, :2] - 0.5).max(axis=1) < 0.3)
    mesh = fc.mesh_solid(surface(block.points, triangles[~top]), size=0.7, element="tet4")
    assert abs(enclosed_volume(mesh.points, mesh.skin) - 2) < 1e-9
    assert "a hole was filled with flat facets, 2.6 % of its area, the largest at (0.5" in mesh.notes[0]
    with refused(fc.MeshError, "open-surface", "open"):
        fc.mesh_solid(surface(block.points, triangles[middle[:, 2] < 2 - 0.3]), size=0.7, element="tet4")


@needs_package
@pytest.mark.full
def test_a_thin_torus_is_followed():
    """Source: 2 pi^2 R r^2, facets of 48 by 24; elements of a fifteenth of its size are thicker than it is."""
    n, m, R, r = 48, 24, 1.0, 0.12
    u, v = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    a, b = 2 * np.pi * u / n, 2 * np.pi * v / m
    x = np.stack([(R + r * np.cos(b)) * np.cos(a), (R + r * np.cos(b)) * np.sin(a), r * np.sin(b)], axis=1)
    c = np.stack([(u + i) % n * m + (v + j) % m for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)
    mesh = fc.mesh_solid(surface(x, np.concatenate([c[:, [0, 1, 2]], c[:, [0, 2, 3]]])))
    facets = np.sin(2 * np.pi / m) / (2 * np.pi / m) * np.sin(2 * np.pi / n) / (2 * np.pi / n)
    assert abs(moments_of_volume(mesh)[0] / (2 * np.pi**2 * R * r**2 * facets) - 1) < 0.01
    assert any("envelope of its facets" in note for note in mesh.notes)
    assert not mesh.warnings


def test_a_facet_drawn_out_to_a_line_has_no_part_in_normals():
    """Envelopes may have such facets. Source: the plane of the others."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0, 0]])
    plane = np.array([[0, 1, 2, 2], [0, 2, 3, 3]])
    normals, cosine = averaged_normals(points, np.vstack([plane, [[0, 4, 1, 1]]]))
    assert np.abs(normals[:4] - [0.0, 0.0, 1.0]).max() < 1e-15  # rounding
    assert np.abs(cosine - 1.0).max() < 1e-15
