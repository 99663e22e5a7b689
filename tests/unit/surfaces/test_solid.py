"""Solids within closed surfaces: volumes, names, smooth geometry, shells, and what is refused."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.orient import closed_components, crossing_triangles, oriented
from fecontact.surfaces import solid
from fecontact.surfaces.repair import enclosed_volume, triangulated


def geodesic(n, radius=1.0, centre=(0.0, 0.0, 0.0)):
    """Points and outward triangles of a sphere: an octahedron, each face divided into n^2."""
    ij = np.array([(i, j) for i in range(n + 1) for j in range(n + 1 - i)])
    number = {tuple(p): k for k, p in enumerate(ij.tolist())}
    up = [[number[i, j], number[i + 1, j], number[i, j + 1]] for i in range(n) for j in range(n - i)]
    down = [[number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]] for i in range(n - 1) for j in range(n - 1 - i)]
    first = np.column_stack([n - ij.sum(axis=1), ij])
    points, triangles = [], []
    for sign in np.array(np.meshgrid([1, -1], [1, -1], [1, -1])).reshape(3, -1).T:
        triangles.append(np.array(up + down)[:, :: sign.prod()] + len(first) * len(points))
        points.append(first * sign)
    whole, same = np.unique(np.concatenate(points), axis=0, return_inverse=True)
    x = whole / np.linalg.norm(whole, axis=1, keepdims=True)
    return radius * x + np.array(centre), same.ravel()[np.concatenate(triangles)]


def together(*parts):
    """One surface of several."""
    start = np.cumsum([0, *(len(x) for x, _ in parts)])
    return np.concatenate([x for x, _ in parts]), np.concatenate(
        [t + s for (_, t), s in zip(parts, start[:-1], strict=True)]
    )


def turned(points, triangles):
    return points, triangles[:, ::-1]


def surface(points, triangles):
    return fc.SurfaceMesh(points, triangles[:, [0, 1, 2, 2]])


def volume_of_triangles(points, triangles):
    """By the divergence theorem."""
    return np.linalg.det(points[triangles]).sum() / 6


def skin(mesh):
    return fc.SurfaceMesh(mesh.points, mesh.skin)


@pytest.fixture
def gmsh_alone(monkeypatch):
    """As where the package of envelopes is not installed."""
    monkeypatch.setattr("fecontact.surfaces.solid.available", lambda: False)


@pytest.fixture(scope="module")
def ball():
    """A sphere of 200 facets, meshed with elements of half their size."""
    return fc.mesh_solid(surface(*geodesic(5)), size=0.2)


def test_a_coarse_ball_becomes_round(ball):
    """Source: a sphere; its facets have corners on it and lose 5.8 % of the volume."""
    points, triangles = geodesic(5)
    assert volume_of_triangles(points, triangles) / (4 / 3 * np.pi) < 0.95
    assert list(ball.kinds) == ["tet10"]
    check_mesh(ball)
    assert abs(moments_of_volume(ball)[0] / (4 / 3 * np.pi) - 1) < 2e-4
    assert list(ball.boundaries) == ["surface_1"]
    assert len(ball.faces("surface_1")) == len(ball.outer_faces)
    # the fit is exact on a sphere but for the edges between facets' fits
    assert np.abs(np.linalg.norm(ball.points[ball.boundary_nodes("surface_1")], axis=1) - 1).max() < 1e-3
    assert "200 facets were replaced by" in ball.notes[-1]
    assert "volume changed by 6.1 %" in ball.notes[-1] or "volume changed by 6.2 %" in ball.notes[-1]


def test_the_size_is_that_of_the_facets(ball):
    facets = ball.face_nodes(ball.faces("surface_1"))
    side = np.linalg.norm(ball.points[facets[:, 1]] - ball.points[facets[:, 0]], axis=1)
    assert abs(np.median(side) / 0.2 - 1) < 0.1


@pytest.fixture(scope="module")
def ellipsoid():
    points, triangles = geodesic(4)
    points = points * [1.0, 0.8, 0.5]
    return points, triangles, fc.mesh_solid(surface(points, triangles), size=0.5, element="tet4")


@pytest.mark.full
def test_the_unit_and_the_place_do_not_matter(ellipsoid):
    """The same cells in a unit of 2^-23, which rounds nothing; far away as many, and the same volume."""
    points, triangles, mesh = ellipsoid
    small = fc.mesh_solid(surface(2.0**-23 * points, triangles), size=2.0**-24, element="tet4")
    assert (small.cells == mesh.cells).all()
    assert np.allclose(2.0**23 * small.points, mesh.points, atol=1e-9)
    far = fc.mesh_solid(surface(1e3 * points + [4e3, -2e3, 1e3], triangles), size=500.0, element="tet4")
    assert abs(len(far.cells) / len(mesh.cells) - 1) < 0.1
    assert abs(moments_of_volume(far)[0] / moments_of_volume(mesh)[0] / 1e9 - 1) < 5e-3


@pytest.mark.by_day("tet4")
@pytest.mark.parametrize("element", ["tet4", "hex20"])
def test_edges_and_planes_of_a_block_stay(element, tmp_path):
    """From a file; the divergence theorem of its triangles gives the volume to rounding, whatever the elements."""
    block = fc.shapes.block((3.0, 2.0, 1.0), (6, 4, 2), element="hex8")
    points, triangles = triangulated(skin(block))
    meshio.Mesh(points, [("triangle", triangles)]).write(tmp_path / "block.stl")
    mesh = fc.mesh_solid(tmp_path / "block.stl", size=0.7, element=element, scale=1e-3)
    check_mesh(mesh)
    assert list(mesh.kinds) == [element]
    assert abs(moments_of_volume(mesh)[0] / (1e-9 * volume_of_triangles(points, triangles)) - 1) < 1e-9
    areas = [skin_area(mesh, name) for name in sorted(mesh.boundaries)]
    assert np.allclose(areas, 1e-6 * np.array([6, 6, 3, 3, 2, 2.0]), rtol=1e-9)


def skin_area(mesh, name):
    return fc.SurfaceMesh.of(mesh, name).areas.sum()


@pytest.mark.full
def test_a_cylinder_of_straight_strips_becomes_round():
    """Source: pi r^2 h; its rims are edges of the mesh, its ends stay flat."""
    solid = fc.shapes.cylinder(1.0, 1.0, contact_radius=0.4, level=1, element="hex8")
    points, triangles = triangulated(skin(solid))
    mesh = fc.mesh_solid(surface(points, triangles), size=0.3)
    assert abs(moments_of_volume(mesh)[0] / np.pi - 1) < 5e-4
    assert volume_of_triangles(points, triangles) / np.pi < 0.99
    areas = [skin_area(mesh, f"surface_{k}") for k in (1, 2, 3)]
    assert np.allclose(areas, [2 * np.pi, np.pi, np.pi], rtol=2e-3)
    ends = np.concatenate([mesh.boundary_nodes(f"surface_{k}") for k in (2, 3)])
    z = mesh.points[ends, 2]
    assert np.minimum(np.abs(z - z.min()), np.abs(z - z.max())).max() < 1e-9


def test_elements_are_small_near_the_contact():
    mesh = fc.mesh_solid(surface(*geodesic(6)), size=0.5, element="tet4", near=(0, 0, 1), near_size=0.08)
    ends = mesh.points[mesh.cells[:, [0, 1]]]
    length, at = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), np.linalg.norm(ends.mean(axis=1) - [0, 0, 1], axis=1)
    # gmsh keeps to the field within a factor of two
    assert np.median(length[at < 0.2]) < 0.2
    assert np.median(length[at > 1.2]) > 0.4


@pytest.mark.full
def test_shells_are_solids_and_voids():
    """A hollow ball with a ball within its void, and another one beside it."""
    parts = geodesic(4, 1.0), turned(*geodesic(4, 0.7)), geodesic(4, 0.4), geodesic(4, 0.5, (2.0, 0, 0))
    points, triangles = together(*parts)
    mesh = fc.mesh_solid(surface(points, triangles), size=0.3)
    volumes = [moments_of_volume(mesh.part(name))[0] for name in ("volume_1", "volume_2", "volume_3")]
    cubes = np.array([1 - 0.7**3, 0.4**3, 0.5**3])
    assert np.allclose(volumes, 4 / 3 * np.pi * cubes, rtol=1e-2)
    assert list(mesh.boundaries) == [f"surface_{k}" for k in (1, 2, 3, 4)]


def test_surfaces_that_enclose_no_solid_are_refused_with_the_place(gmsh_alone):
    points, triangles = geodesic(4)
    for parts, words in (
        ((points, triangles[:-16]), ("open-surface", "solid: 12", "in 1", "of 12")),
        (together(geodesic(3), geodesic(3, 1.0, (1.5, 0.01, 0.02))), ("crosses-itself", "(0.")),
        (turned(points, triangles), ("mesh", "faces inwards")),
        (together(geodesic(4), geodesic(3, 0.5)), ("solid-in-solid",)),
        (together(geodesic(4), turned(*geodesic(3, 0.5, (3.0, 0, 0)))), ("mesh", "near")),
    ):
        with refused(fc.MeshError, *words):
            fc.mesh_solid(surface(*parts))
    # two that are apart, by however little
    x, t = together(geodesic(3), geodesic(3, 1.0, (2.0 + 1e-6, 0, 0)))
    assert closed_components(x, t, "two balls").solids == ((0,), (1,))


def test_what_gmsh_cannot_mesh_is_refused_in_its_words(gmsh_alone):
    """Elements far larger than a thin part, whose two sides then cross."""
    x, t = geodesic(6)
    bent = np.column_stack([x[:, 0], x[:, 1], 0.02 * x[:, 2] + x[:, 0] ** 2])
    with refused(fc.MeshError, "mesh", "gmsh could not mesh the surface:"):
        fc.mesh_solid(surface(bent, t), size=2.0)


def test_crossing_triangles_against_every_pair():
    """Source: the same test of all pairs, one by one; positions, sizes and order do not matter."""
    rng = np.random.default_rng(3)
    x = rng.random((60, 1, 3)) + 0.2 * rng.standard_normal((60, 3, 3)) * rng.choice([0.1, 1.0, 3.0], (60, 1, 1))
    points, triangles = x.reshape(-1, 3), np.arange(180).reshape(60, 3)
    found = {tuple(sorted(p)) for p in crossing_triangles(points, triangles).tolist()}
    single = {
        (i, j)
        for i in range(60)
        for j in range(i + 1, 60)
        if len(crossing_triangles(np.concatenate([x[i], x[j]]), np.array([[0, 1, 2], [3, 4, 5]])))
    }
    assert found == single
    assert 20 < len(found) < 1000
    again = {tuple(sorted(p)) for p in crossing_triangles(1e-5 * points[:, [2, 0, 1]], triangles).tolist()}
    assert again == found


def test_quadratic_facets_keep_their_nodes():
    """Source: Gauss' theorem over curved facets, and the solid's own volume."""
    ball = fc.shapes.sphere(1.0, contact_radius=0.3, level=1)
    points, triangles = triangulated(skin(ball))
    assert abs(enclosed_volume(ball.points, ball.skin) / moments_of_volume(ball)[0] - 1) < 1e-3
    assert len(points) == len(np.unique(ball.skin))
    assert np.linalg.norm(points, axis=1).min() >= 0
    x = points - [0, 0, points[:, 2].mean()]
    assert volume_of_triangles(x, triangles) > 0
    assert abs(volume_of_triangles(x, triangles) / enclosed_volume(x, triangles[:, [0, 1, 2, 2]]) - 1) < 1e-12


def ring(R, r, n, m):
    """Points and outward triangles of a torus."""
    u, v = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    a, b = 2 * np.pi * u / n, 2 * np.pi * v / m
    x = np.stack([(R + r * np.cos(b)) * np.cos(a), (R + r * np.cos(b)) * np.sin(a), r * np.sin(b)], axis=1)

    def at(i, j):
        return (u + i) % n * m + (v + j) % m

    corners = np.stack([at(0, 0), at(1, 0), at(1, 1), at(0, 1)], axis=1)
    return x, np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


@pytest.mark.full
def test_elements_become_finer_until_they_follow_the_surface(gmsh_alone):
    # a ring as thick as elements of a fifteenth of its size, by which its volume is 10 % off
    points, triangles = ring(1.0, 0.12, 16, 10)
    mesh = fc.mesh_solid(surface(points, triangles), element="tet4")
    volume = enclosed_volume(mesh.points, mesh.skin)
    # between that of the facets and that of the torus
    assert volume_of_triangles(points, triangles) * 0.99 < volume < 2 * np.pi**2 * 0.12**2 * 1.01
    assert any("elements of size 0.0847, as larger ones do not follow the surface" in note for note in mesh.notes)
    assert not mesh.warnings


@pytest.mark.parametrize("many", [True, False])
def test_of_many_facets_smaller_elements_are_tried_before_an_envelope(monkeypatch, many):
    block = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2), element="hex8")
    made = {off: solid._Trial(replace(block, notes=(str(off),)), off, 0.0, None) for off in (0.05, 0.009, 0.008)}
    left = [made[0.05], made[0.009]]
    monkeypatch.setattr(solid, "available", lambda: True)
    monkeypatch.setattr(solid, "_trial", lambda *given: left.pop(0))
    monkeypatch.setattr(solid, "_enveloped", lambda *given, closed: made[0.008])
    given = skin(block)
    monkeypatch.setattr(solid, "MANY", 2 * len(given.facets) - many)
    mesh = fc.mesh_solid(given)
    assert mesh.notes[-1] == "0.009" if many else "0.008" in mesh.notes
    assert any("smaller" in note or "larger ones do not follow" in note for note in mesh.notes) == many
    assert len(left) == (0 if many else 1)


@pytest.mark.full
def test_a_size_that_is_too_large_is_kept_with_a_warning_of_the_result():
    mesh = fc.mesh_solid(surface(*ring(1.0, 0.2, 16, 12)), size=0.5, element="tet4")
    (told,) = mesh.warnings
    assert "the volume of the mesh is 32 % off" in told
    assert mesh.scaled(2.0).warnings == mesh.warnings
    held = replace(mesh, node_sets={"held": np.flatnonzero(mesh.points[:, 2] < 0)})
    body = fc.ElasticBody(held, fc.Material(1.0, 0.3), "surface_1", {"held": "xyz"}, name="ring", geometry="plain")
    above = fc.Pose(fc.rotation_about((1, 0, 0), np.pi), (0, 0, mesh.points[:, 2].max() - 1e-3))
    plate = fc.RigidBody(fc.Plane(), pose=above)
    result = fc.Scene([body, plate], [fc.Contact(body, plate)]).solve()
    assert f"'ring': {told}" in result.warnings


def test_a_surface_that_branches_is_no_moebius_strip():
    # a triangular tent with a wall within: three facets at one side
    x = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    facets = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [2, 4, 3], [1, 2, 4], [1, 3, 4], [0, 2, 4], [0, 3, 4]])
    with refused(fc.MeshError, "mesh", "points 0"):
        oriented(x, facets[:, [0, 1, 2, 2]])
