"""Scene files: what they say is what is solved, and all that is wrong is told together."""

import json
import math
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.scene_file.toml_table import did_you_mean
from fecontact.fem.laws import CompressibleOgden

BLOCK = """
title = "a block on a floor"
[units]
length = "mm"
force = "N"
[materials.cork]
E = 10.0
nu = 0.0
density = 2e-6
[bodies.block]
shape = {kind = "block", size = [1, 1, 1], divisions = [2, [0, 0.3, 1], 2]}
material = "cork"
contact = "bottom"
supports = {top = "xyz"}
[bodies.floor]
type = "rigid"
shape = {kind = "plane"}
[[contacts]]
slave = "block"
master = "floor"
"""
LOADS = "[loads]\nmotions.block = {z = -0.01}\n"
DECKS = Path(__file__).parents[3] / "meshes" / "decks"
# the same numbers computed in the same way
SAME = 1e-12


def test_units_of_the_command_line_are_those_of_the_scene(tmp_path, capsys, monkeypatch):
    """They come before those of the file, and a deck has them too."""
    (tmp_path / "scene.toml").write_text(BLOCK + LOADS)
    monkeypatch.chdir(tmp_path)
    for file in (tmp_path / "scene.toml", DECKS / "spinning-disc.inp"):
        assert main(["solve", str(file), "--units", "um", "mN", "kPa", "--json", "-"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["units"] == {"length": "um", "force": "mN", "stress": "kPa"}


def test_supports_by_normals_and_directions_are_those_along_axes(written):
    oblique = BLOCK.replace(
        '{top = "xyz"}', '{top = [[1, 1, 0], [1, -1, 0], [0, 0, 2]], x_min = "n", y_min = [0, 1, 0]}'
    )
    straight = BLOCK.replace('{top = "xyz"}', '{top = "xyz", x_min = "x", y_min = "y"}')
    pressures = []
    for text in (oblique, straight):
        result = fc.read_scene(written(text + LOADS)).solve()
        pressures.append(result.contacts[0].pressure)
    # turned nodal axes: two factorisations of a small matrix
    assert np.abs(pressures[0] - pressures[1]).max() <= 1e-9 * pressures[1].max()


@pytest.mark.parametrize(
    ("constants", "law"),
    [
        ('law = "NeoHookean"\nE = 10.0\nnu = 0.4\n', fc.NeoHookean(E=10.0, nu=0.4)),
        ('law = "HolmesMow"\nE = 10.0\nnu = 0.3\nbeta = 0.2\n', fc.HolmesMow(E=10.0, nu=0.3, beta=0.2)),
        ('law = "Ogden"\nmu = [3.0]\nalpha = [4.0]\nbulk = 20.0\n', fc.Ogden(mu=(3.0,), alpha=(4.0,), bulk=20.0)),
        (
            'law = "CompressibleOgden"\nmu = [3.0]\nalpha = [4.0]\nlame = 2.0\n',
            CompressibleOgden(mu=(3.0,), alpha=(4.0,), lame=2.0),
        ),
    ],
    ids=["neo", "holmes", "ogden", "foam"],
)
def test_a_material_with_a_law_is_of_finite_strain(constants, law, written):
    text = BLOCK.replace("E = 10.0\nnu = 0.0\n", constants) + LOADS.replace("-0.01", "-0.3")
    file = fc.read_scene(written(text))
    assert file.bodies["block"].material == replace(law, density=2e-6)
    result = file.solve()
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, [0, 0.3, 1], 2))
    block, floor = fc.ElasticBody(mesh, law, "bottom", {"top": "xyz"}), fc.RigidBody(fc.Plane())
    by_hand = fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.3}})
    assert len(result.finite_strain) == len(by_hand.finite_strain) > 0
    assert np.abs(result.contacts[0].pressure - by_hand.contacts[0].pressure).max() <= SAME * law.at_rest.E


def test_fibres_stiffen_the_material_that_names_them(written):
    fibres = "fibres = [{direction = [2, 0, 0], ksi = 5.0, alpha = 1.0}, {direction = [0, 1, 0], ksi = 2.0, alpha = 0}]"
    constants = f'law = "NeoHookean"\nE = 10.0\nnu = 0.4\n{fibres}\n'
    text = BLOCK.replace("E = 10.0\nnu = 0.0\n", constants) + LOADS.replace("-0.01", "-0.3")
    file = fc.read_scene(written(text))
    law = file.bodies["block"].material
    assert (law.ksi, law.beta, law.law.ksi, law.density) == (2.0, 2.0, 5.0, 2e-6)
    assert np.allclose(law.law.direction, [1, 0, 0], atol=0)
    plain = fc.read_scene(written(text.replace(fibres, "")))
    # the block widens under pressure and stretches both families, which resist
    stiff, soft = (each.solve().contacts[0].force[2] for each in (file, plain))
    assert abs(stiff) > 1.05 * abs(soft)


@pytest.mark.parametrize(
    ("constants", "message"),
    [
        (
            'law = "NeoHook"\nE = 1.0\n',
            ".cork.law: unknown value 'NeoHook', did you mean 'NeoHookean'",
        ),
        ('law = "MooneyRivlin"\nc10 = 1.0\nE = 1.0\n', "materials.cork.c01: is missing"),
        ('law = "MooneyRivlin"\nc10 = 1.0\nc01 = 0.0\nbulk = 1.0\nE = 1.0\n', "materials.cork.E: unknown key"),
        ('law = "HolmesMow"\nE = 1.0\nnu = 0.3\nbeta = -1.0\n', "The exponential stiffening beta must be positive"),
        ('law = "Ogden"\nmu = 3.0\nalpha = [4.0]\nbulk = 20.0\n', "mu of Ogden's law must be a sequence"),
        ("E = 10.0\nnu = 0.0\nbeta = 1.0\n", "materials.cork.beta: unknown key"),
        ("E = 10.0\nnu = 0.0\nfibres = [{}]\n", "materials.cork.fibres: unknown key"),
        ('law = "NeoHookean"\nE = 1.0\nnu = 0.3\nfibres = [{ksi = 1.0, alpha = 1.0}]\n', "direction: is missing"),
    ],
)
def test_faults_of_laws_are_named(constants, message, written):
    told = faults(written(BLOCK.replace("E = 10.0\nnu = 0.0\n", constants) + LOADS))
    assert message in told
    assert "unknown material" not in told


def faults(path):
    with pytest.raises(fc.InputError) as caught:
        fc.read_scene(path)
    return str(caught.value)


# what is solved


def test_a_file_says_what_a_script_says(written):
    file = fc.read_scene(written(BLOCK + LOADS))
    result = file.solve()
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, [0, 0.3, 1], 2))
    block = fc.ElasticBody(mesh, fc.Material(10.0, 0.0), "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    by_hand = fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.01}})
    assert np.abs(result.contacts[0].pressure - by_hand.contacts[0].pressure).max() <= SAME
    assert file.title == "a block on a floor"
    assert file.scene.unit_names.stress == "N/mm²"
    assert [b.name for b in file.scene.bodies] == ["block", "floor"]


def test_loads_of_all_kinds_reach_the_bodies(written):
    text = (
        BLOCK
        + """
    [loads]
    gravity = [0, 0, -9810.0]
    forces.block = {x_max = [0.0, 0.0, -0.02]}
    forces."block.x_min" = [0.0, 0.0, -0.02]
    pressures."block.top" = 0.03
    moments.block = [0.001, 0.0, 0.0]
    free.block = ["z", "rx"]
    """
    )
    loads = fc.read_scene(written(text)).loads
    block = next(iter(loads["free"]))
    assert loads["forces"] == {(block, "x_max"): (0.0, 0.0, -0.02), (block, "x_min"): (0.0, 0.0, -0.02)}
    assert loads["pressures"] == {(block, "top"): 0.03}
    assert loads["free"] == {block: "z rx"}
    result = fc.read_scene(written(text)).solve()
    weight = 2e-6 * 9810.0
    assert abs(result.contacts[0].total_force - (0.04 + 0.03 + weight)) <= 1e-10  # equilibrium


def test_poses_and_motions_take_degrees(written):
    pose = "pose = {translation = [1, 2, 3], rotation = {axis = [0, 0, 2], angle_deg = 90}}\n"
    text = BLOCK.replace("[bodies.floor]\n", pose + "[bodies.floor]\n")
    text = text.replace('{kind = "plane"}', '{kind = "plane"}\npose = {translation = [0, 0, 3]}')
    file = fc.read_scene(written(text + "[loads]\nmotions.block = {z = -0.01, rz_deg = 90}\n"))
    block = file.bodies["block"]
    assert np.abs(block.pose.to_world(np.array([[1.0, 0, 0]])) - (1, 3, 3)).max() <= SAME
    assert abs(file.loads["motions"][block]["rz"] - math.pi / 2) <= SAME


def test_materials_by_element_set_and_springs(written, tmp_path):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 2))
    cells = [("hexahedron20", mesh.cells)]
    meshio.Mesh(1000 * mesh.points, cells).write(tmp_path / "block.vtu")
    text = """
    [materials]
    soft = {E = 1.0, nu = 0.3}
    [bodies.block]
    mesh = "block.vtu"
    scale = 1e-3
    material = "soft"
    [bodies.ball]
    type = "rigid"
    shape = {kind = "sphere", radius = 0.5}
    [[springs]]
    name = "cord"
    stiffness = 3.0
    start = {body = "ball", point = [0, 0, 1.0]}
    end = {point = [0, 0, 4.0]}
    slack_length = 2.9
    """
    file = fc.read_scene(written(text))
    (spring,) = file.scene.springs
    assert spring.start[0] is file.bodies["ball"]
    assert spring.end == (None, (0.0, 0.0, 4.0))
    assert (spring.stiffness, spring.slack_length, spring.kind, spring.name) == (3.0, 2.9, "tension", "cord")
    assert np.abs(np.ptp(file.bodies["block"].mesh.points, axis=0) - 1).max() <= SAME


@pytest.mark.parametrize(
    "shape",
    [
        'kind = "sphere", radius = 1.0, level = 1',
        'kind = "quarter_sphere", radius = 1.0, level = 1, contact_radius = 0.05',
        'kind = "cylinder", radius = 1.0, height = 2.0, level = 1, sector = "half"',
        'kind = "cap", radius = 9.0, extent = 1.0, depth = 1.0, level = 1, element = "hex8"',
        'kind = "thick_ring", inner = 1.0, outer = 2.0, height = 1.0, divisions = [2, 1, 1]',
    ],
)
def test_shapes_of_elastic_bodies(written, shape):
    pad = f'[bodies.pad]\nshape = {{{shape}}}\nmaterial = "cork"\n'
    assert fc.read_scene(written(BLOCK + pad)).bodies["pad"].n_dofs > 0


@pytest.mark.parametrize(
    "shape",
    [
        'kind = "paraboloid", radius_x = 2.0, radius_y = 3.0',
        'kind = "cylinder", radius = 2.0',
        'kind = "cone", angle_deg = 10.0',
        'kind = "flat_punch", sides = [1.0, 2.0]',
        'kind = "ellipsoid", semi_axes = [1, 2, 3]',
        'kind = "torus", ring = 2.0, tube = 0.5',
    ],
)
def test_shapes_of_rigid_bodies(written, shape):
    file = fc.read_scene(written(BLOCK.replace('kind = "plane"', shape)))
    assert file.bodies["floor"].shape.size > 0


# what is wrong


def test_all_faults_are_told_together_with_their_lines(written):
    told = faults(
        written(
            """
titel = "x"
[materials.cork]
E = -5.0
nu = "soft"
[bodies.block]
shape = {kind = "block", size = [1, 1, 1], divisions = [2, 2, 2]}
material = "crok"
contact = "botom"
supports = {top = "xyw"}
[bodies.bone]
mesh = "tibia.msh"
material = "cork"
[[contacts]]
slave = "block"
master = "flor"
[[contacts]]
slave = "bone"
surfaces = "cap"
[loads]
forces.block = [0.0, -1.0]
forces.femur = [0, 0, 1]
motions.block = {z = "down", q = 1}
pressures.block = 3
[solve]
solver = "wolf"
tolerance = 7.0
[outputs]
vtu = "none/x.vtu"
pressure = {file = "p.jpeg", style = "dots"}
von_mises = {file = "v.png", cut = "left", bodies = ["skull"], view = "front"}
"""
        )
    )
    assert "has 22 faults" in told
    for expected in (
        "line 2, titel: unknown key, did you mean 'title'",
        "line 5, materials.cork.nu: must be a finite number; found 'soft'",
        "line 8, bodies.block.material: unknown material 'crok', did you mean 'cork'",
        "line 9, bodies.block.contact: the mesh has no boundary 'botom', did you mean 'bottom'",
        "line 10, bodies.block.supports.top: must be components out of x, y, z, n such as 'xyz', or one direction",
        "line 12, bodies.bone.mesh: there is no file",
        "line 16, contacts #1.master: unknown body 'flor'; the bodies are: block, bone.",
        "line 17, contacts #2.master: is missing.",
        "line 19, contacts #2.surfaces: must be two names",
        "line 21, loads.forces.block: must be a list of 3 numbers; found [0.0, -1.0]",
        "line 22, loads.forces.femur: unknown body 'femur'",
        "line 23, loads.motions.block.z: must be a finite number; found 'down'",
        "line 23, loads.motions.block.q: unknown key",
        'line 24, loads.pressures.block: needs a boundary: "block.boundary"',
        "line 26, solve.solver: unknown value 'wolf', did you mean 'wolfe'",
        "line 27, solve.tolerance: must lie between 0 and 1",
        "line 29, outputs.vtu: Cannot write",
        "line 30, outputs.pressure.file: must end in .png or .svg or .pdf",
        "line 30, outputs.pressure.style: unknown value 'dots'",
        "line 31, outputs.von_mises.cut: reads like 'x<0'",
        "line 31, outputs.von_mises.bodies: unknown body 'skull'",
        "line 31, outputs.von_mises.view: unknown value 'front'",
    ):
        assert expected in told


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("E = 10.0", "E = -1.0", "materials.cork: Young's modulus E must be positive"),
        pytest.param("E = 10.0", f"E = {10**400}", "materials.cork.E: must be a finite number", id="400 digits"),
        ("E = 10.0", "E = true", "materials.cork.E: must be a finite number; found True"),
        ("E = 10.0\n", "", "line 6, materials.cork.E: is missing"),
        ('"cork"', '{core = "cork"}', "bodies.block.material.core: the mesh has no element set 'core'"),
        ('"cork"', "7", "must be the name of a material or a table"),
        ("size = [1, 1, 1]", "size = [1, 1]", "bodies.block.shape.size: must be a list of 3 numbers"),
        ("divisions = [2", "divisions = [-2", "bodies.block.shape.divisions: must be three counts"),
        ("size = [1, 1, 1]", "size = [1, 1, -1]", "bodies.block.shape: size[2] must be positive"),
        ('kind = "block", ', "", "bodies.block.shape.kind: is missing"),
        ('kind = "block"', 'kind = "blok"', "unknown value 'blok', did you mean 'block'"),
        (
            '"bottom"',
            '"bottom"\nmesh = "x.msh"',
            "solid and extrude (tables); found mesh and shape",
        ),
        ('"bottom"', '"bottom"\nscale = 2.0', "bodies.block.scale: belongs to a mesh from a file"),
        ("{top =", "{tip =", "bodies.block.supports.tip: the mesh has no boundary 'tip', did you mean 'top'"),
        ('type = "rigid"', 'type = "stiff"', "unknown value 'stiff'; expected elastic, local, rigid"),
        ('shape = {kind = "plane"}', "", "needs one of shape (a table; kinds: plane, sphere"),
        ('kind = "plane"', 'kind = "sphere", radius = -2', "radius must be positive and finite"),
        ('master = "floor"', 'master = "block"', "contacts #1: 'block' cannot be in contact with itself"),
        ('master = "floor"', 'master = "floor"\nsurfaces = ["side", "surface"]', "no boundary 'side'"),
        (
            'master = "floor"',
            'master = "floor"\ncoupling = "glue"',
            "unknown value 'glue'; expected auto, nodal, mortar",
        ),
        ("[[contacts]]", "[contacts]", "contacts: must be tables under [[contacts]]"),
        ("[units]", "units = 3\n[unit]", "units: must be a table; found 3"),
        ("[units]", "[axes]\nmedial = [1, 0]\n[units]", "axes.medial: must be a list of 3 numbers"),
        ("[units]", "[axes]\na = [1, 0, 0]\nb = [1, 1, 0]\n[units]", "axes: Axes are at right angles; 'a' and 'b'"),
    ],
)
def test_each_fault_is_named_with_its_place(written, old, new, message):
    assert old in BLOCK
    assert message in faults(written(BLOCK.replace(old, new, 1) + LOADS))


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        ("motions.block = {z = 1.0}\nforces.block = [0, 0, 1.0]", "both loaded (or free) and moved in z"),
        ("motions.block = {rx = 1.0, rx_deg = 3.0}", "is given together with rx"),
        ('free.block = "w"', "Unknown free components"),
        ('forces."block.tip" = [0, 0, 1]', "has no boundary 'tip', did you mean 'top'"),
        ('forces."floor.surface" = [0, 0, 1]', "'floor' is rigid and has no boundaries"),
        ("gravity = 9.81", "loads.gravity: must be a list of 3 numbers"),
        ("wind = 3", "loads.wind: unknown key"),
    ],
)
def test_loads_that_do_not_fit_are_named(written, loads, message):
    assert message in faults(written(BLOCK + "[loads]\n" + loads + "\n"))


def test_two_outputs_in_one_file_are_refused(written):
    text = BLOCK + LOADS + '[outputs]\npressure = "p.png"\ngap = {file = "p.png"}\n'
    assert "outputs.gap.file: names the same file as pressure" in faults(written(text))


def test_springs_with_faults_are_named(written):
    text = (
        BLOCK
        + LOADS
        + """
[[springs]]
stiffness = 1.0
start = {body = "floo", point = [0, 0, 0]}
end = {point = [0, 0]}
[[springs]]
stiffness = -1.0
start = {body = "floor", point = [0, 0, 0]}
end = {point = [0, 0, 1]}
"""
    )
    told = faults(written(text))
    assert "springs #1.start.body: unknown body 'floo', did you mean 'floor'" in told
    assert "springs #1.end.point: must be a list of 3 numbers" in told
    assert "springs #2: The stiffness of 'spring' must be positive" in told


def test_a_byte_order_mark_is_no_fault(written, tmp_path):
    marked = tmp_path / "marked.toml"
    marked.write_bytes(b"\xef\xbb\xbf" + written(BLOCK + LOADS).read_bytes())
    assert [b.name for b in fc.read_scene(marked).scene.bodies] == ["block", "floor"]


def test_files_that_are_none(written, tmp_path):
    assert "Cannot read" in faults(tmp_path / "none.toml")
    assert "not valid TOML" in faults(written("a = [1, 2"))
    assert "line 1" in faults(written("a = = 2"))
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    assert "not UTF-8" in faults(tmp_path / "bytes.toml")


def test_an_empty_file_says_what_a_scene_needs(written):
    told = faults(written(""))
    assert "bodies: is missing" in told
    assert "at least one [[contacts]]" in told


def test_did_you_mean():
    assert did_you_mean("suports", ["supports", "shape"]) == ", did you mean 'supports'"
    assert did_you_mean("qqq", ["supports", "shape"]) == ""


# the command line


OUTPUTS = """
[outputs]
vtu = "r.vtu"
json = "r.json"
csv = "r.csv"
table = "r.txt"
pressure = {file = "p.png", style = "sensels"}
gap = "g.svg"
von_mises = {file = "v.png", scale = 5.0, cut = "x<0.5", bodies = ["block"], limits = [0.0, 1.0], view = [30, 20]}
"""
NAMES = ("r.vtu", "r.json", "r.csv", "r.txt", "p.png", "g.svg", "v.png")


def test_solve_writes_all_outputs(written, tmp_path, capsys):
    path = written(BLOCK + LOADS + OUTPUTS)
    assert main(["solve", str(path), "--out", str(tmp_path / "deep" / "out")]) == 0
    table = capsys.readouterr().out
    assert table.startswith("a block on a floor\n")
    assert "block.bottom on floor.surface" in table
    for name in NAMES:
        assert (tmp_path / "deep" / "out" / name).stat().st_size > 500
    data = json.loads((tmp_path / "deep" / "out" / "r.json").read_text())
    assert data["title"] == "a block on a floor"
    assert abs(data["contacts"][0]["force"][2] - 0.1) <= SAME


def test_dry_run_solves_and_writes_nothing(written, tmp_path, capsys):
    path = written(BLOCK + LOADS + OUTPUTS)
    assert main(["solve", str(path), "--dry-run"]) == 0
    told = capsys.readouterr().out
    for expected in (
        "body     block: 8 hex20 cells",
        "contact  block.bottom on floor.surface",
        "load     motions: block",
    ):
        assert expected in told
    assert sorted(p.name for p in tmp_path.iterdir()) == ["scene.toml"]


def test_axes_of_maps_are_named(written):
    text = BLOCK.replace("[units]", "[axes]\nanterior = [0, 1, 0]\nmedial = [-1, 0, 0]\n[units]")
    assert fc.read_scene(written(text + LOADS)).scene.directions.names == ("anterior", "medial", "z")


def test_solve_prints_json(written, capsys):
    assert main(["solve", str(written(BLOCK + LOADS)), "--json", "-"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["units"] == {"length": "mm", "force": "N", "stress": "N/mm²"}
    assert data["status"] == "solved"
    assert [b["name"] for b in data["bodies"]] == ["block", "floor"]


def test_faults_end_with_status_two(written, capsys):
    assert main(["solve", str(written("[bodies]\n"))]) == 2
    assert "at least one [[contacts]]" in capsys.readouterr().err
    assert main(["solve", str(written(BLOCK)), "--json", "/no/such/folder/x.json"]) == 2
    assert "does not exist" in capsys.readouterr().err


def test_view_draws_a_result(written, tmp_path, capsys):
    path = written(BLOCK + LOADS + '[outputs]\nvtu = "r.vtu"\n')
    assert main(["solve", str(path)]) == 0
    vtu = tmp_path / "r.vtu"
    assert main(["view", str(vtu)]) == 0
    assert (tmp_path / "r.png").read_bytes()[:4] == b"\x89PNG"
    options = [
        "--field=stress_zz",
        "--scale=50",
        "--view=30,-20",
        "--cut=x<0.6",
        "--bodies=0",
        "--units=MPa",
        "--length=mm",
    ]
    out = tmp_path / "s.svg"
    assert main(["view", str(vtu), f"--out={out}", "--limits", "-1", "1", "--no-edges", *options]) == 0
    assert "wrote" in capsys.readouterr().out
    assert "<svg" in out.read_text()
    for arguments, message in (
        ([str(vtu), "--field=strss_zz"], "did you mean 'stress_zz'"),
        ([str(vtu), "--view=1,b"], "AZIMUTH,ELEVATION"),
        ([str(tmp_path / "none.vtu")], "no such file"),
    ):
        assert main(["view", *arguments]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("load", "total"),
    [
        ('pressures.block.x_max = "3 * max(0, 0 * y) + 0.5 * pi / pi"', (-0.5, 0, 0)),
        ('pressures.block.y_min = "12 * x**2 + abs(-1) - 1"', (0, 4, 0)),
        ('tractions.block.x_max = ["0.1", "0", "-(z + 1 - z)"]', (0.1, 0, -1)),
        ("tractions.block.x_max = [0.1, 0.0, -0.25]", (0.1, 0, -0.25)),
        (f"pressures.block.y_min = {[0.5] * 21}", (0, 0.5, 0)),
        (f"tractions.block.y_min = {[[0.5, 0.25, 0.0]] * 21}", (0.5, 0.25, 0)),
    ],
)
def test_intensities_that_vary(written, load, total):
    file = fc.read_scene(written(BLOCK + LOADS + load + "\n"))
    reaction = file.solve().reaction(next(iter(file.loads["motions"])))
    pushed = file.solve().contacts[0].force
    assert np.abs(reaction[:3] + pushed + total).max() < 1e-10


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ('pressures.block.top = "__import__(1)"', ("scene-file",)),
        ('pressures.block.top = "x.real"', ("scene-file", "' in '")),
        ('pressures.block.top = "2 +"', ("scene-file", "2")),
        ('pressures.block.top = "(lambda: 1)()"', ("scene-file",)),
        ('pressures.block.top = "max(1)"', ("scene-file", "'max(1)'")),
        ('pressures.block.top = "t"', ("scene-file", "'t'")),
        ('pressures.block.top = "1e308 * 10"', ("scene-file",)),
        (f'pressures.block.top = "{"(" * 300}1{")" * 300}"', ("scene-file", "500")),
        ("pressures.block.top = [1, 2]", ("scene-file",)),
        ('tractions.block.top = ["1", "2"]', ("scene-file",)),
        ("tractions.block.top = 3.0", ("scene-file",)),
        ("tractions.block = [0, 0, 1]", ("scene-file",)),
    ],
)
@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_wrong_intensities_are_told_with_their_line(written, load, message):
    with refused(fc.InputError, *message) as caught:
        fc.read_scene(written(BLOCK + LOADS + load + "\n"))
    assert "loads" in str(caught.value)


def test_a_displacement_of_a_support_is_that_of_its_frame(written):
    """Cork of nu = 0 whose top alone is moved down is pressed as by the motion of its frame."""
    moved = ["[loads]\ndisplacements.block.top = [0.0, 0.0, -0.01]\n", LOADS]
    moved.append('[loads]\ndisplacements.block.top = ["0", "0", "-0.01 + 0 * x"]\n')
    found = [fc.read_scene(written(BLOCK + text)).solve().contacts[0].total_force for text in moved]
    assert np.ptp(found) < SAME
    with refused(fc.InputError, "scene-file"):
        fc.read_scene(written(BLOCK + "[loads]\ndisplacements.block.bottom = [0.0, 0.0, -0.01]\n"))
