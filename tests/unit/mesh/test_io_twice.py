"""The same cell, face or node twice: taken once where a file says so, refused where it cannot be meant."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import Mesh, SectionMesh, merge
from fecontact.mesh.build import build
from fecontact.mesh.check import check_cells, check_mesh
from fecontact.mesh.formats.generic import teach_meshio
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.kinds import KINDS

RUBBER = fc.Material(E=1.0, nu=0.3)


def pressed(mesh, **options):
    """Result of a cube between a held bottom and a plane, pushed by 0.01 from above."""
    body = fc.ElasticBody(mesh, RUBBER, contact="top", supports={"bottom": "xyz"})
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    return fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(motions={plane: {"z": -0.01}}, **options)


@pytest.fixture
def twice(tmp_path):
    """A cube of 8 hexahedra in gmsh's format 2, all of it in one volume group, half of it in a second one as well."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    half = mesh.cells[mesh.points[mesh.cells].mean(axis=1)[:, 0] < 0.5]
    faces = {n: mesh.face_nodes(mesh.faces(n)) for n in ("bottom", "top")}
    cells = [("hexahedron", mesh.cells), ("hexahedron", half), ("quad", faces["bottom"]), ("quad", faces["top"])]
    tags = [np.full(len(c), k + 1) for k, (_, c) in enumerate(cells)]
    names = {n: np.array([k + 1, 3 if k < 2 else 2]) for k, n in enumerate(("all", "half", "bottom", "top"))}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    teach_meshio()
    out = meshio.Mesh(mesh.points, cells, cell_data=data, field_data=names)
    meshio.gmsh.write(tmp_path / "cube.msh", out, fmt_version="2.2", binary=False)
    return mesh, tmp_path / "cube.msh"


def test_a_volume_in_two_physical_groups_is_one_volume(twice):
    mesh, path = twice
    read = fc.read_mesh(path)
    assert len(read.cells) == 8
    assert sorted(map(len, read.groups.values())) == [4, 8]
    assert (read.points[read.cells[read.groups["half"]]].mean(axis=1)[:, 0] < 0.5).all()
    assert read.notes == ("cube.msh lists 4 of its 12 cells again: each is taken once.",)
    found, expected = pressed(read), pressed(mesh)
    # the same matrix up to the order of its sums; a stiffness taken twice is 40 % off
    assert abs(found.contacts[0].force[2] / expected.contacts[0].force[2] - 1) < 1e-9
    assert found.notes[0] == "'body': " + read.notes[0]
    assert read.notes[0] in found.scene.bodies[0].describe()
    assert read.part("half").notes == read.notes


@pytest.mark.parametrize("kind", ["hex8", "tet4", "wedge6"])
def test_copies_in_another_order_keep_their_surfaces(kind):
    """A copy that begins at another corner is a copy; its faces become those of the first."""
    corners = {"hex8": [3, 0, 1, 2, 7, 4, 5, 6], "tet4": [1, 2, 0, 3], "wedge6": [1, 2, 0, 4, 5, 3]}[kind]
    points = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8").points
    n = len(corners)
    cell = {"hex8": [0, 4, 6, 2, 1, 5, 7, 3], "tet4": [0, 4, 2, 1], "wedge6": [0, 4, 2, 1, 5, 3]}[kind][:n]
    cells = np.array([cell, np.array(cell)[corners]])
    hexes = KINDS[kind].to_hexahedra(cells)
    bare = Mesh(points, hexes)
    for face in bare.outer_faces if len(bare.outer_faces) else [(1, f) for f in range(6)]:
        raw = RawMesh(points, [(kind, cells)], {"a": np.array([0]), "b": np.array([1])}, {}, {"s": np.array([face])})
        nodes = set(Mesh(points, hexes).face_nodes(np.array([face]))[0])
        if len(nodes) < 3:
            continue
        mesh = build(raw, "copy")
        assert len(mesh.cells) == 1
        used = np.unique(hexes)
        assert {int(used[k]) for k in mesh.face_nodes(mesh.faces("s"))[0]} == {int(k) for k in nodes}
        assert mesh.groups["a"].tolist() == mesh.groups["b"].tolist() == [0]


def test_a_face_that_a_surface_lists_three_times_is_one_face(tmp_path):
    lines = ["*NODE"]
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    lines += [f"{k + 1}, " + ", ".join(map(str, x)) for k, x in enumerate(mesh.points.tolist())]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=E", "1, " + ", ".join(str(k + 1) for k in mesh.cells[0])]
    lines += ["*SURFACE, NAME=lid", "E, S2", "1, S2", "E, S2", "*SURFACE, NAME=floor", "E, S1"]
    (tmp_path / "one.inp").write_text("\n".join(lines))
    read = fc.read_mesh(tmp_path / "one.inp")
    assert len(read.faces("lid")) == 1
    body = fc.ElasticBody(read, RUBBER, contact="lid", supports={"floor": "xyz"})
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(pressures={(body, "lid"): -1.0})
    # a pull of 1 on the unit face against a held plane; three times as much when each mention counted
    assert abs(abs(result.contacts[0].force[2]) - 1) < 1e-9


def test_sets_made_in_python_hold_each_member_once():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    top = mesh.faces("top")
    again = replace(
        mesh,
        boundaries={"top": np.concatenate([top, top[::-1], top])},
        groups={"g": np.array([3, 1, 3])},
        node_sets={"n": np.array([5, 5, 2])},
    )
    assert again.faces("top").tolist() == top.tolist()
    assert again.groups["g"].tolist() == [3, 1]
    assert again.node_sets["n"].tolist() == [5, 2]
    plate = fc.sections.rectangle((1.0, 1.0), (2, 2))
    sides = plate.faces("top")
    twice = replace(plate, boundaries={"top": np.concatenate([sides, sides])}, groups={"g": np.array([0, 0])})
    assert twice.faces("top").tolist() == sides.tolist()
    assert twice.groups["g"].tolist() == [0]


def test_repeated_cells_made_in_python_are_refused():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    for extra in (mesh.cells[[5]], mesh.cells[[5]][:, [3, 0, 1, 2, 7, 4, 5, 6]]):
        with refused(fc.MeshError, "double-cells", "Cells 5", "and 8", "corners; 1"):
            check_cells(Mesh(mesh.points, np.concatenate([mesh.cells, extra])))
    with refused(fc.MeshError, "double-cells", "corners; 8"):
        fc.ElasticBody(merge([mesh, mesh], 1e-9), RUBBER)
    # a wedge that lies in a hexahedron: no corners in common with one cell, but a face with two
    wedge = KINDS["wedge6"].to_hexahedra(mesh.cells[[0]][:, [0, 1, 2, 4, 5, 6]])
    with refused(fc.MeshError, "crowded-face", "to 3"):
        check_mesh(Mesh(mesh.points, np.concatenate([mesh.cells, wedge])))


def test_repeated_cells_of_sections_are_refused():
    plate = fc.sections.rectangle((2.0, 1.0), (2, 1))
    turned = plate.cells[[0]][:, [1, 2, 3, 0, 5, 6, 7, 4]]
    for extra in (plate.cells[[0]], turned):
        with refused(fc.MeshError, "double-cells", "Cell 2"):
            SectionMesh(plate.points, np.concatenate([plate.cells, extra]))


def test_points_in_one_place_are_refused_and_joined_by_merge():
    halves = [
        fc.shapes.block((1.0, 1.0, 0.5), (1, 1, 1)).mapped(lambda x, z=z: x + np.array([0, 0, z])) for z in (0.0, 0.5)
    ]
    start = len(halves[0].points)
    crack = Mesh(np.concatenate([m.points for m in halves]), np.concatenate([halves[0].cells, halves[1].cells + start]))
    with refused(fc.MeshError, "double-points", "8 pairs"):
        fc.ElasticBody(crack, RUBBER)
    check_mesh(merge([crack], 1e-9))


def test_faces_between_two_cells_cannot_be_in_contact():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 2))
    inner = replace(mesh, boundaries={"cut": np.array([[0, 5], [1, 4], [1, 5]])})
    with refused(fc.MeshError, "face-between-cells", "2 of", "the 3", "'cut'"):
        fc.ElasticBody(inner, RUBBER, contact="cut")


def test_two_contacts_of_two_bodies_share_no_faces():
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1))
    left = mesh.with_boundary("left", lambda x: (x[:, 2] == 1) & (x[:, 0] <= 1))
    body = fc.ElasticBody(left, RUBBER, contact=("top", "left"), supports={"bottom": "xyz"})
    planes = [
        fc.RigidBody(fc.Plane(), name=n).placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi)) for n in ("p", "q")
    ]
    contacts = [fc.Contact(body, planes[0], (n, "surface")) for n in ("top", "left")]
    with refused(fc.InputError, "shared-faces"):
        fc.Scene([body, planes[0]], contacts)
    fc.Scene([body, *planes], [contacts[0], fc.Contact(body, planes[1], ("left", "surface"))])
