"""Plane meshes of quadrilaterals and triangles as sections."""

import re

import numpy as np
import pytest

import fecontact as fc
from fecontact.mesh.element import quad_quadrature, quad_shapes
from fecontact.mesh.section_mesh import jacobian_2d, line_integrals

ROUNDING = 1e-12


def area(mesh):
    X, w = quad_quadrature()
    _, det = jacobian_2d(mesh.points[mesh.cells], quad_shapes(8, X)[1])
    return float((det @ w).sum())


def length(mesh, name):
    _, _, ds = line_integrals(mesh.points, mesh.face_nodes(mesh.faces(name)))
    return float(np.linalg.norm(ds, axis=2).sum())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["triangles", "quadrilaterals", "both"])
def test_a_disc_and_a_rectangle_of_gmsh(kind, order, gmsh, tmp_path):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    disc = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
    plate = gmsh.model.occ.addRectangle(2, -1, 0, 1, 2)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
    for surface in {"triangles": [], "quadrilaterals": [disc, plate], "both": [plate]}[kind]:
        gmsh.model.mesh.setRecombine(2, surface)
    left = [t for _, t in gmsh.model.getEntities(1) if abs(gmsh.model.occ.getCenterOfMass(1, t)[0] - 2) < 1e-9]
    rim = [t for _, t in gmsh.model.getBoundary([(2, disc)], oriented=False)]
    for dimension, tags, name in ((1, left, "left"), (1, rim, "rim"), (2, [disc], "disc"), (2, [plate], "plate")):
        gmsh.model.addPhysicalGroup(dimension, tags, name=name)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(order)
    gmsh.write(str(tmp_path / "two.msh"))
    gmsh.finalize()
    mesh = fc.read_section(tmp_path / "two.msh")
    whole = fc.read_section(tmp_path / "two.msh", "plate", scale=10.0)
    assert abs(area(whole) - 200) < 200 * ROUNDING
    assert abs(length(whole, "left") - 20) < 20 * ROUNDING
    # sides of a circle by chords and by parabolas: errors of h^2 and h^4
    assert abs(area(mesh) / (2 + np.pi) - 1) < (0.02 if order == 1 else 2e-4)
    assert abs(length(mesh, "rim") / (2 * np.pi) - 1) < (0.01 if order == 1 else 1e-4)
    # conforming: all sides with one cell are on the outside
    outer = mesh.outer_sides
    _, _, ds = line_integrals(mesh.points, mesh.face_nodes(outer))
    assert abs(np.linalg.norm(ds, axis=2).sum() - length(mesh, "rim") - 6) < 1e-9
    assert len(np.union1d(mesh.groups["disc"], mesh.groups["plate"])) == len(mesh.cells)


DECK = """*NODE, NSET=All
1, 0., 0.
2, 2., 0.
3, 2., 1.
4, 0., 1.
5, 3., 0.
*NSET, NSET=Foot
1, 2, 5
*ELEMENT, TYPE=CAX4, ELSET=Wall
1, 1, 4, 3, 2
*ELEMENT, TYPE=CAX3, ELSET=Tip
2, 2, 5, 3
"""


def test_a_section_of_a_deck_turned_and_in_another_plane(written):
    path = written(DECK, "section.inp")
    mesh = fc.read_section(path)
    assert abs(area(mesh) - 2.5) < ROUNDING
    assert {name: len(g) for name, g in mesh.groups.items()} == {"Wall": 4, "Tip": 3}
    assert abs(length(mesh, "Foot") - 3) < ROUNDING
    assert fc.read_section(path, "Wall").kinds == {"quad8": 1}
    upright = re.sub(r"^(\d), (\d\.), (\d\.)$", r"\1, \2, 0., \3", DECK, flags=re.MULTILINE)
    path.write_text(upright)
    assert abs(area(fc.read_section(path)) - 2.5) < ROUNDING
    body = fc.AxisymmetricBody(mesh, fc.Material(E=1.0, nu=0.3), supports={"Foot": "z"})
    assert body.free_motions.shape[1] == 0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("0., 1.\n", "0., 1., 1.\n", "no coordinate plane"),
        ("CAX", "S", "no plane cells"),
        ("1, 4, 3, 2", "1, 4, 2, 3", "folded|inverted|clockwise|same place"),
    ],
)
def test_sections_that_cannot_be_read(old, new, words, tmp_path, written):
    path = written(DECK.replace(old, new), "section.inp")
    with pytest.raises(fc.MeshError, match=words):
        fc.read_section(path)
    for name, part, told in (
        ("a.stl", None, "Unknown mesh"),
        ("a.inp", None, "no file"),
        ("section.inp", "Top", "'Top'"),
    ):
        with pytest.raises((fc.InputError, fc.MeshError), match=f"{told}|{words}"):
            fc.read_section(tmp_path / name, part)
