"""Abaqus assemblies: parts and their instances in place, sets and surfaces with their names."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import Mesh, merge
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh

# numbers of order ten, turned by right angles
ROUNDING = 1e-13

BRICK = """*NODE, NSET=All
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
*ELEMENT, TYPE=C3D8R, ELSET=Lower
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8R, ELSET=Upper
20, 5, 6, 7, 8, 11, 12, 13, 14
*NSET, NSET=Feet, GENERATE
1, 4, 1
*SURFACE, NAME=Head, TYPE=ELEMENT
Upper, S2
"""
WEDGE = """*NODE
5, 0., 0., 0.
6, 2., 0., 0.
7, 0., 2., 0.
8, 0., 0., 3.
9, 2., 0., 3.
10, 0., 2., 3.
*ELEMENT, TYPE=C3D6, ELSET=Body
1, 5, 6, 7, 8, 9, 10
*SURFACE, NAME=Base, TYPE=ELEMENT
Body, S1
"""
ASSEMBLY = f"""*HEADING
*PART, NAME=Brick
{BRICK}*END PART
*PART, NAME=Wedge
{WEDGE}*END PART
*PART, NAME=Anvil
*NODE
1, 0., 0., -5.
*SURFACE, TYPE=CYLINDER, NAME=Rigid
START, 1., 0.
LINE, 0., 0.
*END PART
*ASSEMBLY, NAME=Assembly
*INSTANCE, NAME=Left, PART=Brick
*END INSTANCE
*INSTANCE, NAME=Right, PART=brick
10., 0., 0.
10., 0., 0., 10., 0., 1., 90.
*END INSTANCE
*INSTANCE, NAME=Roof, PART=Wedge
0., 0., 7.
*END INSTANCE
*INSTANCE, NAME=Anvil-1, PART=Anvil
*END INSTANCE
*NODE
1, 3., 3., 3.
*NSET, NSET=Reference
1,
*NSET, NSET=Held, INSTANCE=Left, GENERATE
1, 4, 1
*NSET, NSET=Held, INSTANCE=Right
Feet
*NSET, NSET=Corners
Left.1, Right.2, Roof.5
*NSET, NSET=Nodes, ELSET=Tops
*ELSET, ELSET=Tops, INSTANCE=Left
20
*ELSET, ELSET=Tops, INSTANCE=Right, INTERNAL
Upper
*ELSET, ELSET=Rigids, INSTANCE=Anvil-1
7
*SURFACE, NAME=Tables, TYPE=ELEMENT
Tops, S2
Roof.Body, S2
*SURFACE, NAME=Side
Assembly.Left.Lower, S3
Body, S1
*SURFACE, NAME=Points, TYPE=NODE
Held, 1.
*END ASSEMBLY
*STEP
*BOUNDARY
Held, 1, 3
*END STEP
"""


@pytest.fixture
def read(tmp_path):
    """Read an assembly with some text exchanged."""

    def make(*change, **options):
        path = tmp_path / "assembly.inp"
        text = ASSEMBLY
        for old, new in change:
            assert old in text
            text = text.replace(old, new)
        path.write_text(text)
        return fc.read_mesh(path, **options)

    return make


def corners(mesh, name):
    return {tuple(x) for x in mesh.points[mesh.boundary_nodes(name)].round(12).tolist()}


def test_instances_stand_side_by_side_where_the_assembly_puts_them(read):
    mesh = read()
    check_mesh(mesh)
    assert mesh.kinds == {"hex8": 4, "wedge6": 1}
    assert len(mesh.points) == 12 + 12 + 6
    assert abs(moments_of_volume(mesh)[0] - (2 + 2 + 6)) < ROUNDING
    # by hand: (x, y) -> (10 - y, x), translated before it is turned about the line x = 10, y = 0
    right = mesh.part("Right")
    assert abs(right.points[:, 0].min() - 9) < ROUNDING
    assert abs(right.points[:, 0].max() - 10) < ROUNDING
    assert corners(mesh, "Right.Feet") == {(10, 0, 0), (10, 1, 0), (9, 1, 0), (9, 0, 0)}
    assert corners(mesh, "Base") == {(0, 0, 7), (2, 0, 7), (0, 2, 7)}
    volumes = {name: moments_of_volume(mesh.part(name))[0] for name in ("Left", "Right", "Roof")}
    assert all(abs(volumes[name] - v) < ROUNDING for name, v in (("Left", 2), ("Right", 2), ("Roof", 6)))


def test_names_are_kept_and_told_apart(read):
    mesh = read()
    own = {"Left", "Right", "Roof"}
    twice = {f"{i}.{name}" for i in ("Left", "Right") for name in ("Lower", "Upper")}
    assert set(mesh.groups) == own | twice | {"Body", "Tops"}
    assert set(mesh.node_sets) == {"Left.All", "Right.All", "Left.Feet", "Right.Feet"} | {
        "Held",
        "Corners",
        "Nodes",
        "Points",
    }
    assert {"Left.Head", "Right.Head", "Base", "Tables", "Side"} <= set(mesh.boundaries)
    assert corners(mesh, "Held") == corners(mesh, "Left.Feet") | corners(mesh, "Right.Feet") == corners(mesh, "Points")
    assert corners(mesh, "Corners") == {(0, 0, 0), (10, 1, 0), (0, 0, 7)}
    assert len(mesh.groups["Tops"]) == 2
    assert len(mesh.boundary_nodes("Nodes")) == 16
    assert len(mesh.faces("Tables")) == 3
    assert (mesh.points[mesh.boundary_nodes("Left.Head")][:, 2] == 2).all()
    assert corners(mesh, "Side") == {(0, 0, 0), (1, 0, 0), (0, 0, 1), (1, 0, 1)} | corners(mesh, "Base")


def test_one_instance_is_read_alone(read):
    whole = read()
    for name, cells in (("Left", 2), ("right", 2), ("Roof", 1), ("Wedge", 1)):
        mesh = read(part=name)
        assert len(mesh.cells) == cells
        expected = whole.part({"right": "Right", "Wedge": "Roof"}.get(name, name))
        assert np.abs(mesh.points - expected.points).max() < ROUNDING
    right = read(part="Right", scale=2.0)
    assert {"Head", "Feet", "Held", "Tables"} <= set(right.boundaries)
    assert set(right.groups) == {"Lower", "Upper", "Tops"}
    assert abs(moments_of_volume(right)[0] - 16) < 16 * ROUNDING
    assert corners(right, "Held") == {(20, 0, 0), (20, 2, 0), (18, 2, 0), (18, 0, 0)}


def test_an_assembly_is_the_same_as_its_parts_put_together(read, tmp_path):
    (tmp_path / "brick.inp").write_text(BRICK)
    flat = fc.read_mesh(tmp_path / "brick.inp")
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    other = flat.mapped(lambda x: x @ turn.T + [10, 0, 0])
    both = merge([Mesh(flat.points, flat.cells), Mesh(other.points, other.cells)], 1e-9)
    mesh = read()
    two = mesh.points[mesh.cells[:4]]
    assert np.abs(two - both.points[both.cells]).max() < ROUNDING


def test_parts_without_an_assembly_stand_where_they_were_drawn(written):
    path = written(f"*PART, NAME=One\n{BRICK}*END PART\n", "parts.inp")
    one = fc.read_mesh(path)
    assert set(one.groups) == {"Lower", "Upper"}
    assert {"Head", "Feet"} <= set(one.boundaries)
    path.write_text(f"*PART, NAME=One\n{BRICK}*END PART\n*PART, NAME=Two\n{WEDGE}*END PART\n")
    assert set(fc.read_mesh(path).groups) == {"One", "Two", "Lower", "Upper", "Body"}
    # an orphan mesh: the instance brings its nodes itself
    path.write_text(
        f"*PART, NAME=One\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=i, PART=One\n0., 0., 1.\n{BRICK}"
        "*END INSTANCE\n*END ASSEMBLY\n"
    )
    assert abs(fc.read_mesh(path).points[:, 2].max() - 3) < ROUNDING


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ("Middle", ("input", "no part 'Middle'; its instances are: 'Left', 'Right', 'Roof', 'Anvil-1'")),
        ("Brick", ("input", "2 instances of the part 'Brick'; its instances are: 'Left', 'Right'.")),
    ],
)
def test_parts_that_are_not_there(part, words, read):
    with refused(fc.InputError, *words):
        read(part=part)


def test_part_of_files_that_have_none(read, tmp_path):
    (tmp_path / "brick.inp").write_text(BRICK)
    (tmp_path / "box.step").write_text("")
    for name, words in (
        ("brick.inp", ("unknown-part", "its element sets are: 'Lower', 'Upper'")),
        ("box.step", ("no-parts",)),
    ):
        with refused(fc.InputError, *words):
            fc.read_mesh(tmp_path / name, part="Left")
    assert len(fc.read_mesh(tmp_path / "brick.inp", part="upper").cells) == 1
    with refused(fc.MeshError, "mesh", "no solid cells in its part 'Anvil-1'"):
        read(part="Anvil-1")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("PART=brick", "PART=Bric", ("mesh", "part 'Bric'; the parts are: 'Brick', 'Wedge', 'Anvil'")),
        ("10., 0., 0.\n10", "10., 0.\n10", ("mesh", "three numbers")),
        ("10., 0., 1., 90.", "10., 0., 0., 90.", ("mesh", "are the same")),
        (
            "INSTANCE=Left, GENERATE",
            "INSTANCE=Middle, GENERATE",
            ("mesh", "instance 'Middle'; the instances are: 'Left'"),
        ),
        ("Left.1, Right.2", "Left.99, Right.2", ("unknown-node", "node 99")),
        ("Roof.Body, S2", "Roof.Bodies, S2", ("mesh", "element set 'Roof", "Bodies'")),
        ("Roof.Body, S2", "Upper, S2", ("mesh", "exists in 2 instances")),
        ("Roof.Body, S2", "Roof.Body, S9", ("mesh", "face 'S9'")),
        ("0., 0., 7.", "0., zero, 7.", ("bad-line",)),
    ],
)
def test_damaged_assemblies(old, new, words, read):
    with refused(fc.MeshError, *words):
        read((old, new))
