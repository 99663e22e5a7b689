"""Solids of an assembly of STEP by their names: in Python, in scene files and on the command line."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.gmsh import Sizes, _meshed, cad_solids


@pytest.fixture(scope="module")
def assembly(tmp_path_factory, gmsh):
    """Two bolts beside each other on a plate."""
    path = tmp_path_factory.mktemp("step") / "asm.step"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 5, 2, 1)
    gmsh.model.occ.addBox(0, 0, 1, 1, 1, 2)
    gmsh.model.occ.addBox(3, 0, 1, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    text = path.read_text()
    for k, name in enumerate(("plate", "bolt", "bolt"), 1):
        text = re.sub(rf"'Open CASCADE STEP translator [0-9. ]*\.{k}'", f"'{name}'", text)
    path.write_text(text)
    return path


def test_solids_of_an_assembly_have_their_names(assembly):
    """Source: the volumes of boxes, and their places."""
    solids = {s.name: s for s in cad_solids(assembly)}
    assert list(solids) == ["plate", "bolt", "bolt_2"]
    assert np.allclose([s.volume for s in solids.values()], [10, 2, 1], rtol=1e-12)
    assert np.allclose(solids["bolt_2"].low, (3, 0, 1), atol=1e-4)
    alone = fc.mesh_solid(assembly, size=1.0, element="tet4", part="bolt_2")
    assert np.allclose(alone.points.min(axis=0), (3, 0, 1), atol=1e-9)
    assert len(alone.groups["bolt_2"]) == len(alone.cells)
    with refused(fc.InputError, "unknown", "'blot'; its solids are: 'plate', 'bolt', 'bolt_2'."):
        fc.mesh_solid(assembly, part="blot")


@pytest.mark.full
def test_a_mesh_of_an_assembly_has_its_solids_as_element_sets(assembly):
    whole = fc.mesh_solid(assembly, size=1.0, element="tet4")
    assert {"plate", "bolt", "bolt_2"} < set(whole.groups)
    assert np.allclose(np.ptp(whole.part("bolt").points, axis=0), (1, 1, 2), atol=1e-9)


def test_bodies_of_an_assembly_in_a_scene_file(assembly, tmp_path):
    """Source: uniaxial compression by E eps A."""
    (tmp_path / "asm.toml").write_text(f"""
[materials.soft]
E = 1.0
nu = 0.0
[bodies.bolt]
material = "soft"
solid = {{ file = "{assembly}", part = "bolt", size = 1.0, element = "tet10" }}
contact = "head"
supports = {{ foot = "xyz" }}
[bodies.bolt.boundaries]
foot = {{ plane = {{ point = [0, 0, 1], normal = [0, 0, 1] }} }}
head = {{ plane = {{ point = [0, 0, 3], normal = [0, 0, 1] }} }}
[bodies.floor]
type = "rigid"
shape = {{ kind = "plane" }}
pose = {{ translation = [0, 0, 3], rotation = {{ axis = [1, 0, 0], angle_deg = 180 }} }}
[[contacts]]
slave = "bolt"
master = "floor"
[loads.motions]
floor = {{ z = -0.01 }}
""")
    result = fc.read_scene(tmp_path / "asm.toml").solve()
    assert abs(abs(result.contacts[0].force[2]) - 0.01 / 2) < 1e-6


def test_explain_lists_the_solids(assembly, capsys, tmp_path):
    assert main(["explain", str(assembly), "--json", str(tmp_path / "solids.json")]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"bolt_2 +1 +6 +\(3, 0, 1\) to \(4, 1, 2\)", shown)
    assert [s["faces"] for s in json.loads((tmp_path / "solids.json").read_text())["solids"]] == [6, 6, 6]
    assert main(["explain", str(tmp_path / "missing.step")]) != 0


@pytest.mark.full
def test_a_solid_whose_curved_cells_fold_is_placed_node_by_node(gmsh, monkeypatch):
    """Source: the mesh of a bracket with a bore whose cells do not fold: its volume."""
    path = Path(fc.__file__).parents[1] / "meshes" / "bracket.step"
    sizes = Sizes.of(7.0, "tet10", None, None, 0.5)
    meshes = [_meshed(path, sizes, None)]

    def folded(mesh):
        raise fc.MeshError("it folds")

    with monkeypatch.context() as patch:
        patch.setattr("fecontact.mesh.gmsh.check_cells", folded)
        meshes.append(_meshed(path, sizes, None))
        with refused(fc.MeshError, "mesh", "it folds"):
            _meshed(path, Sizes.of(7.0, "tet4", None, None, 0.5), None)
    gmsh.finalize()
    good, again = meshes
    check_mesh(again)
    assert list(again.kinds) == ["tet10"]
    assert abs(moments_of_volume(again)[0] / moments_of_volume(good)[0] - 1) < 1e-3
