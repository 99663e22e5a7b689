"""Surfaces, extrusion, picking, and solids from CAD files."""

import struct

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import merge
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.gmsh import load_gmsh
from fecontact.mesh.orient import crossing_triangles

ROUNDING = 1e-12


def icosahedron(times=2):
    """Triangulated unit sphere."""
    p = (1 + 5**0.5) / 2
    x = np.array([[0, s, t * p] for s in (-1, 1) for t in (-1, 1)], dtype=float)
    points = np.concatenate([x, np.roll(x, 1, 1), np.roll(x, 2, 1)])
    d = np.linalg.norm(points[:, None] - points, axis=2)
    near = np.abs(d - 2) < 1e-9
    triangles = [
        (i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]
    ]
    soup = points[np.array(triangles)]
    outward = np.einsum("ni,ni->n", np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0]), soup[:, 0]) > 0
    soup[~outward] = soup[~outward][:, ::-1]
    for _ in range(times):
        a, b, c = np.moveaxis(soup, 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        soup = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return soup / np.linalg.norm(soup, axis=2, keepdims=True)


def write_stl(path, soup):
    with path.open("wb") as file:
        file.write(b"solid".ljust(80, b" ") + struct.pack("<I", len(soup)))
        for triangle in soup:
            file.write(struct.pack("<12fH", *np.zeros(3), *triangle.ravel(), 0))
    return path


def test_stl_points_are_joined_and_a_layer_grows_on_them(tmp_path):
    surface = fc.read_surface(write_stl(tmp_path / "ball.stl", icosahedron()), scale=10.0)
    assert len(surface.points) == 10 * 4**2 + 2
    assert surface.is_closed
    # single precision in the file
    assert np.abs(surface.normals - surface.points / 10).max() < 0.02
    layer = fc.shapes.extrude(surface, 0.5, layers=2)
    assert layer.kinds == {"wedge15": 2 * 320}
    assert set(layer.boundaries) == {"base", "top"}
    check_mesh(layer)
    inner, outer = surface.areas.sum(), moments_of_volume(layer)[0] / 0.5
    assert 1.03 < outer / inner < 1.07  # (r + t/2)^2 / r^2 = 1.0506 on the ball itself
    with refused(fc.MeshError, "layer-folds"):
        fc.shapes.extrude(surface.flipped(), 12.0)


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_other_surface_files(suffix, tmp_path):
    path = tmp_path / f"square{suffix}"
    points = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
    if suffix == ".obj":
        path.write_text("".join(f"v {p}\n" for p in points) + "f 1 2 3 4\n")
    else:
        head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        path.write_text(head + "\n".join(points) + "\n4 0 1 2 3\n")
    surface = fc.read_surface(path, scale=2.0)
    assert abs(surface.areas.sum() - 4) < ROUNDING
    assert not surface.is_closed


def test_bad_surfaces(tmp_path):
    (tmp_path / "a.stl").write_text("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n")
    with refused(fc.MeshError, "mesh", "coordinates"):
        fc.read_surface(tmp_path / "a.stl")
    with refused(fc.InputError, "file-type"):
        fc.read_surface(tmp_path / "a.xyz")
    with refused(fc.InputError, "no-file"):
        fc.read_surface(tmp_path / "b.stl")
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], dtype=float)
    with refused(fc.MeshError, "mesh", "branches"):
        fc.SurfaceMesh(x, np.array([[0, 1, 2, 2], [0, 1, 3, 3], [0, 1, 4, 4]]))
    with refused(fc.MeshError, "mesh", "no area"):
        fc.SurfaceMesh(x[[0, 1, 1]] * [1, 0, 0], np.array([[0, 1, 2, 2]]))


def test_cartilage_on_a_curved_bone_fits_it_node_by_node():
    bone = fc.shapes.half_sphere(10.0, contact_radius=2.0, level=1)
    layer = fc.shapes.extrude(fc.SurfaceMesh.of(bone, "cap"), 0.5, layers=[0, 0.3, 1], names=("bone", "free", "rim"))
    r = np.linalg.norm(layer.points[layer.boundary_nodes("free")] - [0, 0, 10], axis=1)
    # averaged normals of quadratic facets: facets of 2 mm on a radius of 10 mm
    assert np.abs(r - 10.5).max() < 5e-5
    whole = merge([bone, layer], 1e-9)
    assert len(whole.points) == len(bone.points) + len(layer.points) - len(layer.boundary_nodes("bone"))
    check_mesh(whole)
    total = moments_of_volume(bone)[0] + moments_of_volume(layer)[0]
    assert abs(moments_of_volume(whole)[0] / total - 1) < ROUNDING


def test_thickness_may_vary(block):
    surface = fc.SurfaceMesh.of(block("mixed", amount=0.0), "top")
    by_function = fc.shapes.extrude(surface, lambda x: 0.1 + 0.2 * x[:, 0])
    assert by_function.kinds == {"hex20": 2, "wedge15": 4}
    assert abs(moments_of_volume(by_function)[0] - 0.2) < ROUNDING
    by_array = fc.shapes.extrude(surface, 0.1 + 0.2 * surface.points[:, 0])
    assert np.abs(by_array.points - by_function.points).max() < ROUNDING
    with refused(fc.InputError, "thickness-not-positive"):
        fc.shapes.extrude(surface, lambda x: x[:, 0])
    with refused(fc.InputError, "input", "one per point"):
        fc.shapes.extrude(surface, [0.1, 0.2])
    for layers in (0, [0.1, 1.0], [0, 0.6, 0.5, 1]):
        with pytest.raises(fc.InputError):
            fc.shapes.extrude(surface, 0.1, layers=layers)


def test_two_sheets_that_face_each_other():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1.0]])
    sheets = fc.SurfaceMesh(points, np.array([[0, 1, 2, 3], [4, 5, 6, 7]]))
    assert abs(moments_of_volume(fc.shapes.extrude(sheets, 0.45))[0] - 0.9) < ROUNDING
    with refused(fc.MeshError, "layer-crosses-itself"):
        fc.shapes.extrude(sheets, 0.55)


def test_crossing_triangles():
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [2, 2, 0.0]])
    assert len(crossing_triangles(x, np.array([[0, 1, 2], [3, 4, 5]]))) > 0
    assert len(crossing_triangles(x + [0, 0, 3] * (np.arange(6) > 2)[:, None], np.array([[0, 1, 2], [3, 4, 5]]))) == 0


@pytest.mark.parametrize("kind", ["hex8", "hex20", "mixed", "tet10"])
def test_picks(kind, block):
    mesh = block(kind, (2, 2, 2), amount=0.0)
    pick = fc.pick
    top = {tuple(f) for f in mesh.faces("top").tolist()}

    def picked(choice):
        return {tuple(f) for f in mesh.with_boundary("p", choice).faces("p").tolist()}

    assert picked(pick.plane((0, 0, 1), (0, 0, -2))) == top
    assert picked(pick.facing((0.1, 0, 1), angle=20)) == top
    assert picked(pick.flood((0.4, 0.6, 1.1))) == top
    assert picked(pick.flood((0.4, 0.6, 1.1), angle=95)) == {tuple(f) for f in mesh.outer_faces.tolist()}
    assert picked(pick.box((-1, -1, 0.9), (2, 2, 1.1))) == top
    assert picked(~pick.facing((0, 0, 1)) | pick.plane((0, 0, 1), (0, 0, 1))) == {
        tuple(f) for f in mesh.outer_faces.tolist()
    }
    other = block("hex20").translated((0, 0, 1.05))
    assert picked(pick.near(other, 0.1)) == top
    assert picked(pick.near(fc.SurfaceMesh.of(other, "bottom"), 0.1) & pick.facing((0, 0, 1))) == top
    body = fc.ElasticBody(other, fc.Material(E=1.0, nu=0.3), contact="bottom")
    assert picked(pick.near(body.surface("bottom"), 0.1)) == top
    assert picked(pick.near(other.points, 0.5) & pick.facing((0, 0, 1))) == top
    with refused(fc.InputError, "empty-boundary", "face"):
        mesh.with_boundary("p", pick.plane((0, 0, 2), (0, 0, 1)))


def test_flood_stops_at_the_rim_of_a_ball():
    ball = fc.shapes.half_sphere(10.0, contact_radius=2.0, level=1)
    mesh = ball.with_boundary("round", fc.pick.flood((0, 0, 0)))
    assert len(mesh.faces("round")) == len(ball.faces("cap")) + len(ball.faces("flank"))


def test_bad_picks():
    pick = fc.pick
    for call in (
        lambda: pick.plane((0, 0), (0, 0, 1)),
        lambda: pick.facing((0, 0, 0)),
        lambda: pick.box((1, 0, 0), (0, 1, 1)),
        lambda: pick.near(np.zeros((1, 3)), -1.0),
        lambda: fc.shapes.block((1, 1, 1), (1, 1, 1)).with_boundary("p", pick.near("there", 1.0)),
    ):
        with pytest.raises((fc.InputError, ValueError)):
            call()


@pytest.fixture(scope="module")
def plate(tmp_path_factory, gmsh):
    """STEP and BREP files of a plate with a hole, and its volume."""
    folder = tmp_path_factory.mktemp("cad")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    box = gmsh.model.occ.addBox(0, 0, 0, 4, 3, 2)
    hole = gmsh.model.occ.addCylinder(2, 1.5, -1, 0, 0, 4, 0.8)
    gmsh.model.occ.cut([(3, box)], [(3, hole)])
    gmsh.model.occ.synchronize()
    for name in ("plate.step", "plate.brep"):
        gmsh.write(str(folder / name))
    gmsh.finalize()
    return folder, 24 - np.pi * 0.64 * 2


@pytest.mark.by_day("tet10")
@pytest.mark.parametrize("element", ["tet10", "hex20", "tet4", "hex8"])
def test_solids_from_step(element, plate):
    folder, volume = plate
    mesh = fc.mesh_solid(folder / "plate.step", size=0.7, element=element)
    assert list(mesh.kinds) == [element]
    check_mesh(mesh)
    # a circle of 0.8 by sides of 0.7: chords lose a fifth of the hole's 4 units of volume, parabolas a hundredth of it
    assert abs(moments_of_volume(mesh)[0] / volume - 1) < (1e-3 if element in ("tet10", "hex20") else 0.05)
    assert len(mesh.boundaries) == 7
    assert sum(len(f) for f in mesh.boundaries.values()) == len(mesh.outer_faces)
    if element in ("tet10", "hex20"):
        # the chords of linear elements turn by more than the angle up to which the flood goes
        named = mesh.with_boundary("hole", fc.pick.flood((2, 0.7, 1)))
        assert len(named.faces("hole")) in [len(f) for f in mesh.boundaries.values()]


@pytest.mark.by_day("hex20-0.001")
@pytest.mark.parametrize(("element", "scale"), [("tet10", 1.0), ("hex20", 1.0), ("hex20", 1e-3)])
def test_nodes_lie_on_the_faces_and_edges_of_the_model(element, scale, plate):
    """Source: the cylinder of the hole; parabolas through three of its points are 1e-3 off at these sizes.

    The edges of the hole are curves of OpenCASCADE's, true to 1e-7.
    """
    mesh = fc.mesh_solid(plate[0] / "plate.step", size=0.7, element=element, scale=scale)
    off = np.abs(np.hypot(mesh.points[:, 0] / scale - 2, mesh.points[:, 1] / scale - 1.5) - 0.8)
    hole = [n for n in map(mesh.boundary_nodes, mesh.boundaries) if off[n].max() < 0.1]
    assert len(hole) == 1
    assert off[hole[0]].max() < 1e-6
    for axis, ends in enumerate(((0, 4), (0, 3), (0, 2))):
        for name in mesh.boundaries:
            x = mesh.points[mesh.boundary_nodes(name), axis] / scale
            if np.ptp(x) < 0.1:
                assert np.abs(x[:, None] - ends).min(axis=1).max() < 1e-12


def test_sizes_are_graded_to_the_contact(plate):
    folder, _ = plate
    mesh = fc.mesh_solid(folder / "plate.brep", size=1.0, near=(0, 0, 2), near_size=0.1)
    ends = mesh.points[mesh.cells[:, [0, 1]]]
    length, middle = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), ends.mean(axis=1)
    at = np.linalg.norm(middle - [0, 0, 2], axis=1)
    # gmsh keeps to the field within a factor of two
    assert np.median(length[at < 0.2]) < 0.2
    assert np.median(length[at > 2]) > 0.5


def test_geo_scripts_and_defaults(written, gmsh):
    path = written(
        'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhysical Surface("end") = {1};\n'
        'Physical Volume("all") = {1};\n',
        "cube.geo",
    )
    for read in (fc.read_mesh, fc.mesh_solid):
        with refused(fc.InputError, "script-not-allowed"):
            read(path)
    mesh = fc.mesh_solid(path, scale=10.0, run_script=True)
    assert list(mesh.kinds) == ["tet10"]
    assert abs(moments_of_volume(mesh)[0] - 1000) < 1e-9
    assert len(mesh.groups["all"]) == len(mesh.cells)
    assert (mesh.faces("end") == mesh.faces("surface_1")).all()


def test_cad_requests_that_cannot_be_met(tmp_path, plate):
    folder, _ = plate
    (tmp_path / "bad.step").write_text("no step")
    for call, words in (
        (lambda: fc.mesh_solid(tmp_path / "bad.step"), ("mesh", "bad")),
        (lambda: fc.mesh_solid(tmp_path / "none.step"), ("no-file",)),
        (lambda: fc.mesh_solid(tmp_path / "none.txt"), ("input", "Unknown CAD")),
        (lambda: fc.mesh_solid(folder / "plate.step", element="hex27"), ("unknown-name", "of gmsh 'hex27'")),
        (lambda: fc.mesh_solid(folder / "plate.step", size=-1.0), ("not-positive", "size")),
        (lambda: fc.mesh_solid(folder / "plate.step", near=(0, 0)), ("wrong-shape", "near")),
    ):
        with refused((fc.InputError, fc.MeshError), *words):
            call()


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (
            OSError("libGLU.so.1: cannot open shared object file"),
            ("missing-package", "libGLU"),
        ),
        (ImportError("No module named 'gmsh'"), ("missing-package", "pip install gmsh")),
    ],
)
def test_gmsh_missing_is_said(error, words, monkeypatch):
    import builtins

    real = builtins.__import__

    def refuse(name, *args, **kwargs):
        if name == "gmsh":
            raise error
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with refused(fc.MissingPackageError, *words):
        load_gmsh()
