"""Meshes from files: every format and kind of cell, names, and files that must be refused."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.build import in_order
from fecontact.mesh.check import check_mesh
from fecontact.mesh.kinds import KINDS

# text files carry 16 digits, binary ones all; coordinates are of order one
DIGITS = 1e-14
ALL = ("hex8", "hex20", "hex27", "wedge6", "wedge15", "tet4", "tet10", "mixed")


def same(read, mesh):
    assert read.kinds == mesh.kinds
    assert len(read.points) == len(mesh.points)
    assert abs(moments_of_volume(read)[0] - moments_of_volume(mesh)[0]) < DIGITS
    check_mesh(read)
    # mid-side nodes where they were, cell by cell: kinds may have been sorted
    order = np.lexsort(mesh.points[mesh.cells].mean(axis=1).round(9).T)
    other = np.lexsort(read.points[read.cells].mean(axis=1).round(9).T)
    assert np.abs(read.points[read.cells[other]] - mesh.points[mesh.cells[order]]).max() < DIGITS


#: Every kind in every format, but for hex27 in Abaqus files: that format's writer has no such cell.
ROUND_TRIPS = [(k, s) for k in ALL for s in (".vtu", ".vtk", ".msh", ".inp") if (k, s) != ("hex27", ".inp")]


@pytest.mark.parametrize(("kind", "suffix"), ROUND_TRIPS)
def test_round_trip(kind, suffix, block, write, tmp_path):
    mesh = block(kind)
    path = write(mesh, tmp_path / f"block{suffix}")
    same(fc.read_mesh(path), mesh)


@pytest.mark.parametrize("kind", ["hex20", "hex27", "wedge15", "tet10", "pyramid13"])
def test_any_order_of_mid_edge_nodes_is_understood(kind):
    k = KINDS[kind]
    mesh = fc.shapes.block((1.0, 2.0, 1.5), (2, 1, 1), element="hex27")
    corners = np.array([list(dict.fromkeys(k.embedding[:8]))])
    x = mesh.points[mesh.cells[0, :8]][[k.embedding[:8].index(c) for c in corners[0]]]
    middles = [x[list(ends)].mean(axis=0) for _, ends in sorted(k.mid_edges.items())]
    if kind == "hex27":
        middles = list(mesh.points[mesh.cells[0, 8:]])
    points = np.concatenate([x, middles])
    cells = np.arange(len(points))[None, :]
    turned = np.random.default_rng(3).permutation(np.arange(k.n_corners, len(points)))
    scrambled = np.concatenate([cells[:, : k.n_corners], turned[None, :]], axis=1)
    assert (in_order(points, k, scrambled) == cells).all()


def test_linear_cells_are_raised_on_request(block, write, tmp_path):
    for kind, element, expected in (("hex8", "hex20", "hex20"), ("hex8", "hex27", "hex27"), ("tet4", "tet10", "tet10")):
        mesh = fc.read_mesh(write(block(kind), tmp_path / f"{kind}.vtu"), element=element, scale=1e-3)
        assert list(mesh.kinds) == [expected]
        assert abs(moments_of_volume(mesh)[0] - 1e-9 * moments_of_volume(block(kind))[0]) < 1e-9 * 0.01
        check_mesh(mesh)


def test_27_nodes_come_down_to_20(block, write, tmp_path):
    mesh = fc.read_mesh(write(block("hex27", amount=0.0), tmp_path / "b.vtu"), element="hex20")
    assert list(mesh.kinds) == ["hex20"]
    assert abs(moments_of_volume(mesh)[0] - 1) < DIGITS


DECK = """*HEADING
two bricks
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
11, 0., 0., 2.
12, 1., 0., 2.
13, 1., 1., 2.
14, 0., 1., 2.
** a comment
*Element, type=C3D8R, elset=Lower
1, 1, 2, 3, 4,
5, 6, 7, 8
*Element, type=C3D8R, elset=Upper
20, 5, 6, 7, 8, 11, 12, 13, 14
*NSET, NSET=Feet, GENERATE
1, 4, 1
*NSET, NSET=Edge
5, 6
*ELSET, ELSET=Both
Lower, 20
*SURFACE, NAME=Head, TYPE=ELEMENT
Upper, S2
*SURFACE, NAME=Front
1, S3
Upper, S3
"""


def test_abaqus_keeps_its_names(written):
    path = written(DECK, "bricks.inp")
    mesh = fc.read_mesh(path)
    assert set(mesh.boundaries) == {"Head", "Front", "Feet", "ALL"}
    assert {name: len(g) for name, g in mesh.groups.items()} == {"Lower": 1, "Upper": 1, "Both": 2}
    assert (mesh.points[mesh.boundary_nodes("Head")][:, 2] == 2).all()
    assert (mesh.points[mesh.boundary_nodes("Front")][:, 1] == 0).all()
    assert len(mesh.faces("Front")) == 2
    assert (mesh.points[mesh.boundary_nodes("Feet")][:, 2] == 0).all()
    assert len(mesh.boundary_nodes("Edge")) == 2
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="Head", supports={"Edge": "xyz", "Feet": "z"})
    assert body.free_motions.shape[1] == 0
    upper = mesh.part("Upper")
    assert abs(moments_of_volume(upper)[0] - 1) < DIGITS
    assert set(upper.boundaries) == {"Head", "Front", "ALL"}
    raised = fc.read_mesh(path, element="hex20")
    assert len(raised.node_sets["Edge"]) == 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("5, 6, 7, 8\n", "5, 6, 7, 99\n", ("unknown-node", "refers to node 99")),
        ("5, 6, 7, 8\n", "5, 6, 7\n", ("mesh", "no multiple of the 9")),
        ("C3D8R", "C3D77", ("no-solid-cells", "2 elements of type C3D77")),
        ("Upper, S2", "Upper, S7", ("mesh", "face 'S7'")),
        ("Upper, S2", "Top, S2", ("mesh", "element set 'Top'")),
        ("2, 1., 0., 0.", "2, 1., zero, 0.", ("bad-line",)),
        ("1, 1, 2, 3, 4,\n5, 6, 7, 8", "1, 5, 6, 7, 8,\n1, 2, 3, 4", ("folded-cell", "left-handed")),
        ("*HEADING", "*PART, NAME=a\n*END PART\n*PART, NAME=b\n*END PART\n*HEADING", ("mesh", "outside of them")),
    ],
)
def test_damaged_decks(old, new, words, written):
    path = written(DECK.replace(old, new), "bad.inp")
    with refused(fc.MeshError, *words):
        fc.read_mesh(path)


FEB = """<?xml version="1.0"?>
<febio_spec version="4.0"><Mesh>
<Nodes name="Object"><node id="1">0,0,0</node><node id="2">1,0,0</node><node id="3">0,1,0</node>
<node id="4">0,0,1</node><node id="9">1,1,1</node></Nodes>
<Elements type="tet4" name="Bone"><elem id="1">1,2,3,4</elem></Elements>
<Elements type="tet4" name="Cartilage"><elem id="2">2,9,3,4</elem></Elements>
<NodeSet name="Held">1,2,3</NodeSet>
<NodeSet name="Listed"><n id="1"/><n id="3"/></NodeSet>
<ElementSet name="All">1,2</ElementSet>
<Surface name="Contact"><tri3 id="1">2,9,3</tri3></Surface>
</Mesh></febio_spec>
"""


def test_febio_keeps_its_names(written):
    path = written(FEB, "knee.feb")
    mesh = fc.read_mesh(path, element="tet10")
    assert mesh.kinds == {"tet10": 2}
    assert {k: len(v) for k, v in mesh.groups.items()} == {"Bone": 1, "Cartilage": 1, "All": 2}
    assert len(mesh.faces("Contact")) == 1
    assert len(mesh.faces("Held")) == 1
    assert len(mesh.node_sets["Listed"]) == 3
    assert abs(moments_of_volume(mesh.part("Bone"))[0] - 1 / 6) < DIGITS


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("</Mesh>", "", ("incomplete-xml",)),
        ("Mesh>", "Grid>", ("no-mesh",)),
        ("1,2,3,4</elem>", "1,2,3,8</elem>", ("unknown-node", "node 8")),
        ("tet4", "tet20", ("no-solid-cells", ". It holds 2 elements of type tet20")),
        (">0,0,1<", ">0,0<", ("no-point", "has 2")),
        (">0,0,1<", ">0,0,one<", ("bad-number",)),
        ("1,2,3,4</elem>", "1,3,2,4</elem>", ("folded-cell", "left-handed")),
    ],
)
def test_damaged_febio_files(old, new, words, written):
    path = written(FEB.replace(old, new), "bad.feb")
    with refused(fc.MeshError, *words):
        fc.read_mesh(path)


def test_surfaces_only_are_refused(block, tmp_path):
    import meshio

    mesh = block("hex8")
    meshio.write(tmp_path / "shell.vtu", meshio.Mesh(mesh.points, [("triangle", [[0, 1, 2]])]))
    with refused(fc.MeshError, "no-solid-cells"):
        fc.read_mesh(tmp_path / "shell.vtu")


def test_requests_that_cannot_be_met(tmp_path):
    broken = tmp_path / "broken.msh"
    broken.write_bytes(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 2")
    with refused(fc.MeshError, "mesh", "damaged"):
        fc.read_mesh(broken)
    for name, words in (("a.stl", ("is-a-surface",)), ("a.txt", ("unknown-file-type",)), ("a.msh", ("no-file",))):
        with refused(fc.InputError, *words):
            fc.read_mesh(tmp_path / name)
    with refused(fc.InputError, "not-positive", "The scale"):
        fc.read_mesh(broken, scale=0.0)
    with refused(fc.InputError, "unknown-name", "element"):
        fc.read_mesh(broken, element="hex64")


def test_gmsh_names_its_physical_groups(tmp_path, gmsh):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    box = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    for curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve[1], 3)
    for surface in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(surface[1])
        gmsh.model.mesh.setRecombine(2, surface[1])
    gmsh.model.mesh.setTransfiniteVolume(box)
    top = [t for _, t in gmsh.model.getEntities(2) if gmsh.model.occ.getCenterOfMass(2, t)[2] > 0.9]
    gmsh.model.addPhysicalGroup(2, top, name="lid")
    gmsh.model.addPhysicalGroup(3, [box], name="core")
    for order, incomplete, expected in ((1, 0, "hex8"), (2, 1, "hex20"), (2, 0, "hex27")):
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", incomplete)
        gmsh.option.setNumber("Mesh.ElementOrder", order)
        gmsh.model.mesh.generate(3)
        for version in (2.2, 4.1):
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            path = tmp_path / f"{expected}_{version}.msh"
            gmsh.write(str(path))
            mesh = fc.read_mesh(path)
            assert mesh.kinds == {expected: 8}
            assert list(mesh.boundaries) == ["lid"]
            assert len(mesh.faces("lid")) == 4
            assert (np.abs(mesh.points[mesh.boundary_nodes("lid")][:, 2] - 1) < DIGITS).all()
            assert len(mesh.groups["core"]) == 8
            assert abs(moments_of_volume(mesh)[0] - 1) < DIGITS
            check_mesh(mesh)
    gmsh.finalize()


XDMF = """<Xdmf Version="3.0"><Domain><Grid Name="Grid">
<Geometry GeometryType="XYZ"><DataItem DataType="Float" Dimensions="10 3" Format="XML" Precision="8">
0 0 0 1 0 0 0 1 0 0 0 1 .5 0 0 .5 .5 0 0 .5 0 0 0 .5 .5 0 .5 0 .5 .5</DataItem></Geometry>
<Topology TopologyType="Tetrahedron_10" NumberOfElements="1"><DataItem DataType="Int" Dimensions="1 10" Format="XML"
Precision="8">0 1 2 3 4 5 6 7 8 9</DataItem></Topology></Grid></Domain></Xdmf>
"""


def test_xdmf(written):
    path = written(XDMF, "tet.xdmf")
    mesh = fc.read_mesh(path)
    assert mesh.kinds == {"tet10": 1}
    assert abs(moments_of_volume(mesh)[0] - 1 / 6) < DIGITS
