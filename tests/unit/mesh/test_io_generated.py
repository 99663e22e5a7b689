"""Keywords of .inp files that change the mesh: done or refused by name and line, others ignored."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

NODES = "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1"
PLAIN = f"*NODE, NSET=All\n{NODES}\n*ELEMENT, TYPE=C3D8, ELSET=Solid\n1,1,2,3,4,5,6,7,8\n"


def read(folder, text):
    (folder / "m.inp").write_text(text)
    return fc.read_mesh(folder / "m.inp")


@pytest.mark.parametrize(
    "keyword",
    ["*NGEN", "*NFILL", "*NCOPY, CHANGE NUMBER=8", "*nmap", "*ELGEN, ELSET=E", "*ELCOPY", "*SYSTEM", "*Node, System=c"],
)
def test_generated_meshes_are_refused_by_keyword_and_line(keyword, tmp_path):
    name = keyword[1:].split(",")[0].upper()
    with refused(fc.MeshError, "mesh", f"m.inp, line 12: *{name}"):
        read(tmp_path, PLAIN + keyword + "\n1,2,3\n")


@pytest.mark.parametrize(
    "text", ["*NODE, INPUT=n.txt\n", "*ELEMENT, TYPE=C3D8, INPUT=e.txt\n", "*NSET, NSET=A, FILE=x\n"]
)
def test_lists_from_elsewhere_are_refused(text, tmp_path):
    with refused(fc.MeshError, "mesh", "line 12", "takes data from elsewhere"):
        read(tmp_path, PLAIN + text)


def test_what_cannot_change_the_mesh_is_ignored(tmp_path):
    plain = read(tmp_path, PLAIN)
    more = "*TRANSFORM, NSET=All, TYPE=C\n0,0,0,0,0,1\n*MATERIAL, NAME=M\n*WHATEVER\n1,2\n*NODE, SYSTEM=R\n9,5,5,5\n"
    assert np.array_equal(read(tmp_path, PLAIN + more).points, plain.points)


def test_nodes_and_elements_defined_again(tmp_path):
    same = read(tmp_path, PLAIN + "*NODE\n3,1,1,0\n*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n")
    assert len(same.cells) == 1
    assert len(same.points) == 8
    with refused(fc.MeshError, "mesh", "first defined at m", "inp, line 1"):
        read(tmp_path, PLAIN + "*NODE\n3,1,1,0.5\n")
    with refused(fc.MeshError, "mesh", "element 1 is defined again"):
        read(tmp_path, PLAIN + "*ELEMENT, TYPE=C3D8\n1,2,3,4,1,6,7,8,5\n")


def test_capitals_make_no_difference_in_names(tmp_path):
    text = PLAIN + "*NSET, NSET=top, ELSET=SOLID\n*NSET, NSET=Lid\n5,6\n*NSET, NSET=LID\n7,8\n*ELSET, ELSET=solid\n1\n"
    mesh = read(tmp_path, text + "*SURFACE, NAME=s\nSOLID,S2\n")
    assert sorted(mesh.groups) == ["Solid"]
    assert len(mesh.node_sets["top"]) == 8
    assert sorted(mesh.node_sets["Lid"].tolist()) == [4, 5, 6, 7]
    assert "LID" not in mesh.node_sets
    assert len(mesh.faces("s")) == 1
