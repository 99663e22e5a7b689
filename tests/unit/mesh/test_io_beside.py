"""Files that hold more than solids: what is solid is read, the rest is left out and listed."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh

# volumes of order one, coordinates without rounding
ROUNDING = 1e-14

NODES = """*NODE, NSET=ALL
1, 0., 0., 0.
2, 1.0D0, 0., 0.
3, 1., 1., 0.
4, 0., 1.
5, , , 1.
6, 1., 0., 1., 0., 0., 1.
 7 ,  1.,1. , 1.
8, 0, 1, 1
11, 0., 0., 2.
12, 1., 0., 2.
13, 1., 1., 2.
14, 0., 1., 2.
15, 5., 0., 0.
16, 5., 1., 0.
17, 5., 1., 1.
"""
DECK = f"""{NODES}
   *ELEMENT, TYPE=C3D8I,
      ELSET=Lower
1, 1, 2, 3, 4, 5, 6, 7, 8, 101, 102, 103,
*ELEMENT, TYPE=DC3D8, ELSET=Upper
20, 5, 6, 7, 8,
11, 12, 13, 14
*ELEMENT, TYPE=S3R, ELSET=Plate
30, 15, 16, 17
*ELEMENT, TYPE=S4, ELSET=Lid
31, 11, 12, 13, 14
*ELEMENT, TYPE=B31, ELSET=Bar
40, 8, 15
41, 15, 16
*ELSET, ELSET=Everything, GENERATE
1, 1000
*ELSET, ELSET=Both
Lower, 20, Plate, 40
*NSET, NSET=Feet, GENERATE
1, 4
*NSET, NSET=Lost
1, 2, 999
*SURFACE, NAME=Head
Upper, S2
Plate, SPOS
"""


@pytest.fixture
def file(tmp_path):
    """A file with given text."""

    def make(text, name="bricks.inp"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return make


def test_solids_of_a_deck_with_shells_and_beams(file):
    mesh = fc.read_mesh(file(DECK))
    check_mesh(mesh)
    assert mesh.kinds == {"hex8": 2}
    assert abs(moments_of_volume(mesh)[0] - 2) < ROUNDING
    assert {k: len(g) for k, g in mesh.groups.items()} == {"Lower": 1, "Upper": 1, "Everything": 2, "Both": 2}
    assert len(mesh.faces("Head")) == 1
    assert len(mesh.faces("Lid")) == 1
    assert mesh.file_nodes.tolist() == [1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 13, 14]
    assert mesh.file_elements.tolist() == [1, 20]
    (note,) = mesh.notes
    for words in (
        "2 elements of type B31",
        "1 facets of the shell 'Plate'",
        "1 nodes of the set 'Lost' that the file does not define",
        "1 entries of the surface 'Head' on other elements",
    ):
        assert words in note
    assert "Lid" not in note


def test_numbers_of_the_file_follow_the_mesh(file):
    mesh = fc.read_mesh(file(DECK), part="upper")
    assert mesh.file_elements.tolist() == [20]
    assert mesh.file_nodes.tolist() == [5, 6, 7, 8, 11, 12, 13, 14]
    assert fc.read_mesh(file(DECK)).part("Upper").file_nodes.tolist() == mesh.file_nodes.tolist()
    raised = mesh.upgraded(20)
    assert raised.file_nodes.tolist() == [*mesh.file_nodes.tolist(), *[-1] * 12]
    whole = fc.read_mesh(file(DECK))
    body = fc.ElasticBody(whole, fc.Material(E=1.0, nu=0.3), "Head", {"Feet": "xyz"})
    floor = fc.RigidBody(fc.Plane()).placed((0.0, 0.0, 2.0), np.diag([1.0, -1.0, -1.0]))
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={floor: {"z": -0.01}})
    assert result.contacts[0].error_estimate is not None
    with refused(fc.MeshError, "mesh", "file_elements", "most 1"):
        fc.Mesh(mesh.points, mesh.cells, file_elements=np.arange(2))


def test_included_files(file):
    file("*CLOAD\n1, 3, 5.\n", "there.inc")
    with_loads = DECK + "*INCLUDE, INPUT=there.inc\n*INCLUDE, INPUT=absent.inc\n"
    mesh = fc.read_mesh(file(with_loads))
    assert "file to be included, absent.inc (bricks.inp, line 43), which is missing" in mesh.notes[0]
    with refused(fc.MeshError, "mesh", "defines no nodes"):
        fc.read_mesh(file("*INCLUDE, INPUT=nodes.inc" + DECK[DECK.index("\n   *ELEM") :]))
    with refused(fc.MeshError, "mesh", "a circle without an end"):
        fc.read_mesh(file("*INCLUDE, INPUT=bricks.inp"))


def test_numbers_that_are_none(file):
    for number, code in (("1e300", "not-whole"), ("nan", "bad-line")):
        with refused((fc.InputError, fc.MeshError), code):
            fc.read_mesh(file(DECK.replace("1, 0., 0., 0.", f"{number}, 0., 0., 0.", 1)))


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [("103,\n", "103,\n2, 1, 2,\n", "no multiple of the 9"), ("1, 4\n*NSET", "1, 4, 0\n*NSET", "a step of 1 or more")],
)
def test_broken_rows_and_ranges(old, new, found, file):
    assert old in DECK
    with refused(fc.MeshError, "mesh", found):
        fc.read_mesh(file(DECK.replace(old, new)))


def test_separate_parts_of_different_order_become_quadratic(file):
    box = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    curved = "".join(f"{k + 50}, {x[0] + 3}, {x[1]}, {x[2]}\n" for k, x in enumerate(box.points.tolist()))
    cell = ", ".join(str(k + 50) for k in box.cells[0].tolist())
    text = DECK.replace(
        "*ELSET, ELSET=Every", f"*NODE\n{curved}*ELEMENT, TYPE=C3D20, ELSET=Q\n60, {cell}\n*ELSET, ELSET=Every"
    )
    mesh = fc.read_mesh(file(text))
    check_mesh(mesh)
    assert mesh.kinds == {"hex20": 3}
    assert len(mesh.points) == 20 + 32
    assert abs(moments_of_volume(mesh)[0] - 3) < ROUNDING
    assert "2 linear cells got nodes in the middles of their edges" in mesh.notes[0]
    assert len(mesh.faces("Head")) == 1
    assert fc.read_mesh(file(text), part="Lower").kinds == {"hex8": 1}


def test_a_quadratic_neighbour_gives_its_nodes():
    from fecontact.mesh.build import same_order

    box = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1)).mapped(lambda x: x + 0.02 * np.sin(9 * x[:, ::-1]))
    points, cells, _ = same_order(box.points, [box.cells[:1], box.cells[1:, :8]])
    # the four edges of the face between them, with their nodes, are shared; the others get new ones
    assert len(np.intersect1d(cells[0], cells[1])) == 8
    assert len(points) == len(box.points) + 8
    check_mesh(fc.Mesh(points[np.unique(cells)], np.unique(cells, return_inverse=True)[1].reshape(2, 20)))


FEB = """<?xml version="1.0"?>
<febio_spec version="{version}">{outside}<{tag}>{mesh}</{tag}></febio_spec>"""
PARTS = """<Nodes name="Object"><node id="1">0,0,0</node><node id="2">1,0,0</node><node id="3">0,1,0</node>
<node id="4">0,0,1</node><node id="7">3,0,0</node><node id="8">4,0,0</node><node id="9">3,1,0</node></Nodes>
<Elements type="tet4" name="Bone" mat="1"><elem id="1">1,2,3,4</elem></Elements>
<Elements type="tri3" name="Skin" mat="2"><elem id="2">7,8,9</elem></Elements>
<Elements type="line2" name="Wire" mat="3"><elem id="3">1,7</elem></Elements>
"""
SETS = """<Surface name="Outside"><tri3 id="1">1,3,2</tri3><tri3 id="2">7,8,9</tri3></Surface>
<NodeSet name="Held">1:3</NodeSet><ElementSet name="All">1,2,3</ElementSet>"""


def test_solids_of_febio_files(file):
    mesh = fc.read_mesh(file(FEB.format(version="4.0", tag="Mesh", mesh=PARTS + SETS, outside=""), "knee.feb"))
    assert mesh.kinds == {"tet4": 1}
    assert {k: len(g) for k, g in mesh.groups.items()} == {"Bone": 1, "All": 1}
    assert len(mesh.faces("Outside")) == len(mesh.faces("Held")) == 1
    assert mesh.file_nodes.tolist() == [1, 2, 3, 4]
    (note,) = mesh.notes
    for words in ("elements of type line2", "1 facets of the surface 'Outside' on no", "1 facets of the shell 'Skin'"):
        assert words in note


def test_febio_before_version_2(file):
    cells = '<Elements><tet4 id="1" mat="1">1,2,3,4</tet4><tri3 id="2" mat="2">7,8,9</tri3></Elements>'
    text = FEB.format(version="1.2", tag="Geometry", mesh=PARTS[: PARTS.index("<Elem")] + cells, outside="")
    mesh = fc.read_mesh(file(text, "old.feb"))
    assert list(mesh.groups) == ["material_1"]
    assert "1 facets of the shell 'material_2'" in mesh.notes[0]


@pytest.mark.parametrize("way", ["<Include>geometry.feb</Include>", '<Geometry from="geometry.feb"/>'])
def test_febio_meshes_in_other_files(way, file):
    file(FEB.format(version="2.5", tag="Geometry", mesh=PARTS, outside=""), "geometry.feb")
    path = file(f'<febio_spec version="2.5">{way}<Include>loads.feb</Include></febio_spec>', "model.feb")
    mesh = fc.read_mesh(path)
    assert mesh.kinds == {"tet4": 1}
    assert "file to be included, loads.feb, which is missing" in mesh.notes[0]
    (path.parent / "geometry.feb").unlink()
    with refused(fc.MeshError, "no-mesh", "missing: geometry.feb, loads.feb"):
        fc.read_mesh(path)
    with refused(fc.MeshError, "mesh", "a circle without an end"):
        fc.read_mesh(file(f'<febio_spec version="2.5">{way}</febio_spec>', "geometry.feb"))


def test_febio_parts_and_instances(file):
    turned = "<rotate>0, 0, 0.7071067811865476, 0.7071067811865476</rotate><translate>0, 0, 5</translate>"
    mesh = (
        f'<Part name="P">{PARTS}{SETS}</Part><Instance name="A" part="P"/>'
        f'<Instance name="B" part="P"><scale>2, 1, 1</scale>{turned}</Instance>'
    )
    read = fc.read_mesh(file(FEB.format(version="2.5", tag="Geometry", mesh=mesh, outside=""), "parts.feb"))
    assert {"A.Bone", "B.Bone"} <= set(read.groups)
    volumes = [moments_of_volume(read.part(f"{i}.Bone"))[0] for i in "AB"]
    assert np.abs(np.array(volumes) - [1 / 6, 1 / 3]).max() < ROUNDING
    # by hand: x twice as long, then a quarter turn about z, then up
    corners = read.part("B.Bone").points
    assert {tuple(x) for x in corners.round(12).tolist()} == {(0, 0, 5), (0, 2, 5), (-1, 0, 5), (0, 0, 6)}
    for old, new, words in (
        ('part="P"/', 'part="Q"/', ("unknown-part", "P")),
        ("<rotate>", '<rotate type="Euler">', ("mesh", "Euler")),
    ):
        with refused(fc.MeshError, *words):
            fc.read_mesh(
                file(FEB.format(version="2.5", tag="Geometry", mesh=mesh.replace(old, new), outside=""), "bad.feb")
            )
