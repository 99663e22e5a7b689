"""Surface files: which side is outside, facets that are there twice, and polygons."""

import re
import struct
import warnings

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import SurfaceMesh
from fecontact.mesh.mending import cut
from fecontact.mesh.orient import oriented, signed_volume
from fecontact.mesh.surface_mesh import joined
from fecontact.surfaces import Facets

RUBBER = fc.Material(E=1.0, nu=0.3)


def ball(radius=1.0):
    """Points and outward triangles of a closed ball that rests on z = 0."""
    mesh = fc.shapes.sphere(radius, contact_radius=0.3 * radius, level=1, element="hex8")
    corners = mesh.face_nodes(mesh.outer_faces)
    used, number = np.unique(corners, return_inverse=True)
    corners = number.reshape(-1, 4)
    return mesh.points[used], np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def text_stl(path, points, triangles):
    lines = ["solid thing"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in points[t].tolist())]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid thing"]))
    return path


def binary_stl(path, points, triangles):
    records = [struct.pack("<12fH", 0, 0, 0, *points[t].ravel(), 0) for t in triangles]
    path.write_bytes(b"solid but binary".ljust(80) + struct.pack("<I", len(records)) + b"".join(records))
    return path


def obj(path, points, polygons):
    path.write_text(
        "\n".join(
            [f"v {x} {y} {z}" for x, y, z in points.tolist()]
            + ["f " + " ".join(f"{k + 1}/1/1" for k in p) for p in polygons]
        )
    )
    return path


def ply(path, points, polygons):
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [f"property double {c}" for c in "xyz"]
    head += [f"element face {len(polygons)}", "property list uchar int vertex_indices", "end_header"]
    rows = [" ".join(map(str, x)) for x in points.tolist()] + [" ".join(map(str, (len(p), *p))) for p in polygons]
    path.write_text("\n".join(head + rows) + "\n")
    return path


WRITERS = {"text.stl": text_stl, "binary.stl": binary_stl, "a.obj": obj, "a.ply": ply}


def pushed(rigid):
    """Upward force of a block on a rigid ball pushed into its top by 0.05."""
    block = fc.shapes.block((1.6, 1.6, 0.8), (4, 4, 2)).mapped(lambda p: p - np.array([0.8, 0.8, 0.8]))
    body = fc.ElasticBody(block, RUBBER, "top", {"bottom": "xyz"})
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -0.05}})
    return result.contacts[0].force[2], result


@pytest.mark.parametrize("name", WRITERS)
def test_a_ball_that_faces_inwards_or_has_turned_facets_is_mended_with_a_note(name, tmp_path):
    points, triangles = ball()
    some = triangles.copy()
    some[::7] = some[::7, ::-1]
    right = fc.read_surface(WRITERS[name](tmp_path / name, points, triangles))
    assert right.notes == ()
    volume = signed_volume(right.points, right.facets)
    inside_out = fc.read_surface(WRITERS[name](tmp_path / name, points, triangles[:, ::-1]))
    assert re.search("faced inwards and was turned", " ".join(inside_out.notes))
    mixed = fc.read_surface(WRITERS[name](tmp_path / name, points, some))
    assert f"{len(some[::7])} of {len(some)} facets were turned" in " ".join(mixed.notes)
    for mended in (inside_out, mixed):
        # sums of the same terms in another order
        assert abs(signed_volume(mended.points, mended.facets) / volume - 1) < 1e-12
    assert abs(signed_volume(right.points, right.flipped().facets) / volume + 1) < 1e-12


def test_forces_do_not_depend_on_the_winding_and_the_result_says_what_was_mended(tmp_path):
    points, triangles = ball()
    one = triangles.copy()
    one[3] = one[3, ::-1]
    rigid = [
        fc.RigidBody.from_surface(text_stl(tmp_path / f"{k}.stl", points, t))
        for k, t in enumerate((triangles, triangles[:, ::-1], one))
    ]
    (force, clean), (inwards, turned), (mixed, _) = (pushed(r) for r in rigid)
    # the same points and facets; inward normals gave another sign and a hundred times the force, one facet -14 %
    assert abs(inwards / force - 1) < 1e-9
    assert abs(mixed / force - 1) < 1e-9
    assert not any("stl" in note for note in clean.notes)
    assert any("faced inwards and was turned" in note for note in turned.notes)
    assert "faced inwards" in rigid[1].describe()


def test_a_cavity_is_left_where_it_lies_in_a_ball_or_is_asked_for():
    points, triangles = ball()
    quads = triangles[:, [0, 1, 2, 2]]
    both = np.concatenate([points, 0.5 * points + np.array([0, 0, 0.5])])
    inner = quads + len(points)
    shell = joined(both, np.concatenate([quads, inner[:, [0, 2, 1, 1]]]))
    assert shell.notes == ()
    whole = signed_volume(points, quads)
    assert abs(signed_volume(shell.points, shell.facets) / whole - (1 - 0.125)) < 1e-12
    # two balls side by side, the second inside out: that one alone is turned
    apart = np.concatenate([points, points + np.array([5.0, 0, 0])])
    two = joined(apart, np.concatenate([quads, inner[:, [0, 2, 1, 1]]]))
    assert abs(signed_volume(two.points, two.facets) / whole - 2) < 1e-12
    assert f"part of it ({len(quads)} facets)" in two.notes[0]
    cavity = fc.RigidBody(Facets(SurfaceMesh(points, quads).flipped()))
    assert "faces inwards: a cavity" in cavity.describe()


def sheet(n=4):
    x = np.arange(n + 1.0)
    points = np.stack([*(a.ravel() for a in np.meshgrid(x, x, indexing="ij")), np.zeros((n + 1) ** 2)], axis=1)
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    return points, np.stack([c.ravel() for c in corners], axis=1)


@pytest.mark.parametrize("up", [True, False])
def test_an_open_surface_keeps_the_side_of_most_facets_and_says_so(up):
    points, quads = sheet()
    quads = quads if up else quads[:, ::-1]
    given = quads.copy()
    given[[2, 7]] = given[[2, 7], ::-1]
    surface = joined(points, given)
    assert np.abs(surface.normals - [0, 0, 1.0 if up else -1.0]).max() < 1e-12
    assert "2 of 16 facets were turned" in surface.notes[0]
    assert "the surface is open" in surface.notes[1]


def test_surfaces_without_a_side_are_refused():
    points, quads = sheet()
    half = quads.copy()
    half[:8] = half[:8, ::-1]
    with refused(fc.MeshError, "unclear-outside", "50 %"):
        joined(points, half)
    with refused(fc.MeshError, "opposite-facets", "ways; 4"):
        SurfaceMesh(points, half)
    angle = np.linspace(0, 2 * np.pi, 13)[:-1]
    across = np.stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)], 1)
    middle = np.stack([2 * np.cos(angle), 2 * np.sin(angle), 0 * angle], 1)
    k = np.arange(12)
    strip = np.stack([k, (k + 1) % 12, (k + 1) % 12 + 12, k + 12], 1)
    strip[-1] = [11, 12, 0, 23]
    with refused(fc.MeshError, "one-sided"):
        oriented(np.concatenate([middle + 0.5 * across, middle - 0.5 * across]), strip)


def test_facets_that_are_there_twice_are_taken_once():
    points, quads = sheet()
    surface = joined(points, np.concatenate([quads, quads[3:5], quads[[6]][:, [2, 3, 0, 1]]]))
    assert len(surface.facets) == 16
    assert surface.notes[0] == "3 of 19 facets are there again: each is taken once."
    alone = joined(points, np.concatenate([quads[:1], quads[:1]]))
    assert len(alone.facets) == 1


# a plus sign, a pentagon with a hollow corner, one with a straight corner, an arrow head: areas by hand
PLUS = [(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)]
POLYGONS = {
    "plus": (PLUS, 5.0),
    "hollow": ([(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)], 10.0),
    "straight": ([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)], 4.0),
    "arrow": ([(0, 0), (2, 1), (0, 2), (1, 1)], 1.0),
    "hexagon": ([(np.cos(a), np.sin(a)) for a in np.arange(6) * np.pi / 3], 1.5 * np.sqrt(3)),
}


@pytest.mark.parametrize("kind", POLYGONS)
@pytest.mark.parametrize("name", ["a.obj", "a.ply"])
def test_polygons_are_cut_without_holes(kind, name, tmp_path):
    corners, area = POLYGONS[kind]
    turn = np.array(fc.rotation_about((1.0, 2.0, 3.0), 0.7))
    points = np.column_stack([np.array(corners, float), np.zeros(len(corners))]) @ turn.T
    for start in range(len(corners)):
        polygon = np.roll(np.arange(len(corners)), start)
        surface = fc.read_surface(WRITERS[name](tmp_path / name, points, [polygon.tolist()]))
        assert abs(surface.areas.sum() - area) < 1e-12 * area
        # no triangle against the others, so none outside the polygon
        assert np.abs(surface.normals - turn[:, 2]).max() < 1e-12
        assert len(surface.nodes) == len(corners)


def test_a_prism_of_polygons_is_closed(tmp_path):
    plus = np.array(PLUS, float)
    n = len(plus)
    points = np.concatenate([np.column_stack([plus, np.full(n, z)]) for z in (0.0, 2.0)])
    walls = [[k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n)]
    polygons = [list(range(n))[::-1], list(range(n, 2 * n)), *walls]
    for name in ("a.obj", "a.ply"):
        surface = fc.read_surface(WRITERS[name](tmp_path / name, points, polygons))
        assert surface.is_closed
        assert abs(signed_volume(surface.points, surface.facets) - 10.0) < 1e-12


def test_a_polygon_that_crosses_itself_is_refused():
    star = np.array([(np.cos(a), np.sin(a), 0.0) for a in 0.8 * np.pi * np.arange(5)])
    with refused(fc.MeshError, "mesh", "crosses itself"):
        cut(star, np.arange(5)[None, :])


def test_obj_numbers_count_back_lines_go_on_and_errors_are_told(written):
    path = written("# c\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 # here\nf -3//1 -2//1 \\\n-1//1\nv 0 1 0\nf 1 3 -1\n", "a.obj")
    surface = fc.read_surface(path)
    assert len(surface.facets) == 2
    assert abs(surface.areas.sum() - 1) < 1e-15
    for text, match in (
        ("v 0 0 0\nf 1 0 1", ("mesh", "needs three corners")),
        ("v 0 0 0\nf 1 2 3", ("mesh", "its 1")),
        ("v 0 0 0\nf 1 -4 -1", ("mesh", "not among")),
        ("v 0 0\nv 1 0\nv 1 1\nf 1 2 3", ("no-xyz",)),
        ("v 0 0 0\nf 1 x 2", ("bad-line",)),
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3", ("mesh", "not finite")),
    ):
        path.write_text(text)
        with refused(fc.MeshError, *match):
            fc.read_surface(path)


def test_stl_files_that_are_cut_short_are_refused(tmp_path):
    points, triangles = ball()
    path = binary_stl(tmp_path / "a.stl", points, triangles)
    path.write_bytes(path.read_bytes()[:-30])
    with refused(fc.MeshError, "incomplete"):
        fc.read_surface(path)
    text_stl(path, points, triangles)
    path.write_text(path.read_text().replace("vertex", "vertx", 1))
    with refused(fc.MeshError, "mesh", "no triangles of three"):
        fc.read_surface(path)


def test_no_warning_of_a_library_reaches_the_reader_of_a_text_stl(tmp_path, capfd):
    points, triangles = ball()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        text_stl(tmp_path / "a.stl", points, triangles)
        fc.read_surface(tmp_path / "a.stl")
        meshio.Mesh(points, [("triangle", triangles)]).write(tmp_path / "b.stl", binary=True)
        fc.read_surface(tmp_path / "b.stl")
    assert capfd.readouterr() == ("", "")
