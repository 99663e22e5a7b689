"""Gmsh's own exports: .msh of every version, text and binary, .inp and .vtk, linear and quadratic cells."""

from itertools import product

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh

# flat sides; text has 16 digits
DIGITS = 1e-13
FORMATS = [(1.0, 0), (2.0, 0), (2.2, 0), (2.2, 1), (4.0, 0), (4.1, 0), (4.1, 1)]
KINDS = {("tet", 1): "tet4", ("tet", 2): "tet10", ("hex", 1): "hex8", ("hex", 2): "hex27"}
KINDS |= {("wedge", 1): "wedge6", ("wedge", 2): "wedge15"}


def build(gmsh, kind, order, named):
    """A unit cube; returns the number of its cells."""
    gmsh.clear()
    box = gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    heights = {t: gmsh.model.occ.getCenterOfMass(2, t)[2] for _, t in gmsh.model.getEntities(2)}
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.7)
    if kind != "tet":
        for _, curve in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(curve, 3)
        for surface, z in heights.items():
            gmsh.model.mesh.setTransfiniteSurface(surface)
            if kind == "hex" or abs(z - 0.5) < 0.1:
                gmsh.model.mesh.setRecombine(2, surface)
        gmsh.model.mesh.setTransfiniteVolume(box)
    if named:
        gmsh.model.addPhysicalGroup(2, [t for t, z in heights.items() if z > 0.9], name="lid")
        gmsh.model.addPhysicalGroup(3, [box], name="core")
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    return sum(len(tags) for tags in gmsh.model.mesh.getElements(3)[1])


@pytest.mark.by_day(every=4)
@pytest.mark.parametrize(("kind", "order", "named"), list(product(("tet", "hex", "wedge"), (1, 2), (False, True))))
def test_own_exports(kind, order, named, gmsh, tmp_path):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        n_cells = build(gmsh, kind, order, named)
        paths = {}
        for all_of_it, (version, binary) in product((0, 1), FORMATS):
            gmsh.option.setNumber("Mesh.SaveAll", all_of_it)
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            for suffix in ("msh", "inp") if version == 1 else ("msh", "vtk") if version == 2.2 else ("msh",):
                path = tmp_path / f"{version}_{binary}_{all_of_it}.{suffix}"
                gmsh.write(str(path))
                # before version 4, everything that is saved has the numbers of the geometry as groups
                paths[path] = named and suffix != "vtk" and version > 1 and (version >= 4 or not all_of_it)
    finally:
        gmsh.finalize()
    for path, has_names in paths.items():
        mesh = fc.read_mesh(path)
        expected = KINDS[kind, order]
        if path.suffix == ".inp":
            # gmsh calls wedges of 18 nodes C3D6
            expected = "wedge6" if kind == "wedge" else expected
        assert mesh.kinds == {expected: n_cells}, path.name
        assert abs(moments_of_volume(mesh)[0] - 1) < DIGITS, path.name
        if has_names:
            assert (mesh.points[mesh.boundary_nodes("lid")][:, 2] == 1).all(), path.name
            assert len(mesh.groups["core"]) == n_cells
            assert len(fc.read_mesh(path, part="core").cells) == n_cells
        if path.suffix == ".msh":
            check_mesh(mesh)
            assert (mesh.file_nodes > 0).all()
            assert len(np.unique(mesh.file_elements)) == n_cells


def test_cells_of_order_three_are_refused_with_what_to_do(gmsh, tmp_path):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        build(gmsh, "hex", 3, named=True)
        gmsh.write(str(tmp_path / "cubic.msh"))
    finally:
        gmsh.finalize()
    with refused(fc.MeshError, "no-solid-cells", "gmsh -order 2"):
        fc.read_mesh(tmp_path / "cubic.msh")
    # its surfaces are read by their corners
    assert abs(fc.read_surface(tmp_path / "cubic.msh", "lid").areas.sum() - 1) < 1e-12


def test_surfaces_of_an_iges_file_are_closed_to_a_solid(gmsh, tmp_path):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.write(str(tmp_path / "box.iges"))
    gmsh.finalize()
    assert abs(moments_of_volume(fc.mesh_solid(tmp_path / "box.iges", size=0.7))[0] - 1) < 1e-12


TEXT = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 5 1 5
3 1 0 5
1
2
3
4
5
0 0 0
1 0 0
0 1 0
0 0 1
5 5 5
$EndNodes
$Unknown
1 2 3
$EndUnknown
$Elements
2 2 1 2
3 1 4 1
1 1 2 3 4
3 1 29 0
$EndElements
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("4.1 0 8", "5.0 0 8", ("version", "5.0")),
        ("5 5 5\n", "5 5\n", ("mesh", "numbers are missing")),
        ("0 0 1\n", "0 zero 1\n", ("damaged",)),
        ("$EndElements", "", ("mesh", "has no end")),
        ("1 1 2 3 4", "1 1 2 3 9", ("unknown-node", "node 9")),
        ("3 1 4 1\n", "3 1 777 1\n", ("damaged",)),
        ("3 1 4 1\n", "3 1 29 1\n", ("mesh", "numbers are missing")),
        ("4.1 0 8", "4.1 1 8", ("mesh", "damaged")),
        ("0 0 1\n", "0 nan 1\n", ("not-finite",)),
        (TEXT, "nothing at all", ("mesh", "no nodes")),
    ],
)
def test_damaged_files(old, new, words, written):
    path = written(TEXT, "bad.msh")
    assert fc.read_mesh(path).kinds == {"tet4": 1}
    path.write_text(TEXT.replace("0 0 1\n", "0 1e308 1\n"))
    with refused(fc.InputError, "out-of-scale", "The size of the mesh"):
        fc.read_mesh(path)
    path.write_text(TEXT.replace(old, new))
    with refused(fc.MeshError, *words):
        fc.read_mesh(path)
