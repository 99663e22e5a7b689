"""Scene files: half-spaces, layers, rigid surfaces from files, picked boundaries, grown layers and sweeps."""

import csv
import json

import meshio
import numpy as np
import pytest
from PIL import Image
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main

MATERIAL = "[materials.soft]\nE = 1.0\nnu = 0.3\n[materials.stiff]\nE = 10.0\nnu = 0.3\n"
BALL = '[bodies.ball]\ntype = "rigid"\nshape = {kind = "sphere", radius = 2.0}\n'
HALF = '[bodies.half]\ntype = "half-space"\nmaterial = "soft"\nsize = [1.2, 1.2]\ncells = [24, 24]\n'
PRESSED = '[[contacts]]\nslave = "half"\nmaster = "ball"\n[loads]\nmotions.ball = {z = -0.05}\n'
BLOCK = (
    '[bodies.block]\nshape = {kind = "block", size = [1, 1, 1], divisions = [4, 4, 2]}\nmaterial = "soft"\n'
    'supports = {bottom = "xyz"}\n'
)
SOFT = fc.Material(E=1.0, nu=0.3)


def faults(path):
    with pytest.raises(fc.InputError) as told:
        fc.read_scene(path)
    return str(told.value)


@pytest.mark.parametrize(
    ("more", "options"),
    [
        ("", {}),
        ('layers = [{material = "stiff", thickness = 0.2, interface = "frictionless"}]\n', {"layers": True}),
        ('periodic = true\nagainst = "stiff"\n', {"periodic": True, "against": fc.Material(E=10.0, nu=0.3)}),
    ],
)
def test_half_spaces(more, options, written):
    found = fc.read_scene(written(MATERIAL + BALL + HALF + more + PRESSED)).solve()
    if options.pop("layers", False):
        options["layers"] = [fc.Layer(fc.Material(E=10.0, nu=0.3), 0.2, "frictionless")]
    half = fc.HalfSpace(SOFT, size=(1.2, 1.2), cells=(24, 24), **options)
    ball = fc.RigidBody(fc.Sphere(2.0))
    same = fc.Scene([half, ball], [fc.Contact(half, ball)]).solve(motions={ball: {"z": -0.05}})
    assert abs(found.contacts[0].force[2] / same.contacts[0].force[2] - 1) < 1e-12


def test_a_local_body(written):
    local = (
        '[bodies.half]\ntype = "local"\nshape = {kind = "block", size = [4, 4, 2], divisions = [4, 4, 3]}\n'
        'material = "soft"\nsupports = {bottom = "xyz"}\nat = [2, 2, 2]\nwindow = 1.2\ncells = [24, 24]\n'
    )
    ball = BALL + "pose = {translation = [2, 2, 2]}\n"
    found = fc.read_scene(written(MATERIAL + ball + local + PRESSED)).solve()
    block = fc.ElasticBody(fc.shapes.block((4, 4, 2), (4, 4, 3)), SOFT, supports={"bottom": "xyz"})
    body = fc.LocalBody(block, (2, 2, 2), 1.2, (24, 24))
    rigid = fc.RigidBody(fc.Sphere(2.0), pose=fc.Pose(translation=(2, 2, 2)))
    same = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(motions={rigid: {"z": -0.05}})
    assert abs(found.contacts[0].force[2] / same.contacts[0].force[2] - 1) < 1e-12
    wrong = local.replace("window = 1.2", 'window = "wide"').replace("24]", "24.5]")
    message = faults(written(MATERIAL + ball + wrong + PRESSED))
    assert "two whole numbers" in message


def test_a_layer_of_springs(written):
    layer = '[bodies.half]\ntype = "layer"\nmaterial = "soft"\nthickness = 0.5\ncovers = "top"\nlaw = "frictionless"\n'
    shape = 'shape = {kind = "block", size = [1, 1, 1], divisions = [8, 8, 1], element = "hex8"}\n'
    pose = "pose = {translation = [-0.5, -0.5, -1.0]}\n"
    found = fc.read_scene(written(MATERIAL + BALL + layer + shape + pose + PRESSED)).solve()
    gap = fc.Sphere(2.0).heights(*np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(-0.5, 0.5, 9)))
    weight = np.outer(*[np.r_[0.5, np.ones(7), 0.5] / 8] * 2)
    modulus = 1 / (1 - 0.3**2)  # of each node by itself: pressure = modulus strain
    exact = (modulus * np.maximum(0.05 - gap, 0) / 0.5 * weight).sum()
    # lines of action lean by the sphere's slope, at most 0.2
    assert abs(found.contacts[0].force[2] / -exact - 1) < 0.03


def test_rigid_surfaces_from_files(written, tmp_path):
    x = (np.arange(24) - 11.5) / 20
    np.save(tmp_path / "bump.npy", 3 - (x[:, None] ** 2 + x[None, :] ** 2) / 4)
    points = np.array([[-2, -2, 1], [2, -2, 1], [2, 2, 1], [-2, 2, 1], [0, 0, 0]], dtype=float)
    triangles = [[4, 1, 0], [4, 2, 1], [4, 3, 2], [4, 0, 3]]
    meshio.Mesh(points, [("triangle", triangles)]).write(tmp_path / "tip.stl")
    for entry in (
        'heights = {file = "bump.npy", size = [1.2, 1.2], peaks_up = true}',
        'surface = {file = "tip.stl", scale = 1}',
    ):
        text = f'[bodies.ball]\ntype = "rigid"\n{entry}\n'
        found = fc.read_scene(written(MATERIAL + text + HALF + PRESSED)).solve()
        assert found.contacts[0].force[2] < 0


@pytest.mark.parametrize(
    ("conditions", "count"),
    [
        ("facing = {direction = [0, 0, 1]}\nbox = [[0, 0, 0], [0.5, 1, 1]]", 8),
        ("plane = {point = [0, 0, 1], normal = [0, 0, 1]}", 16),
        ("flood = {seed = [0.1, 0.1, 1.0], angle_deg = 20}", 16),
    ],
)
def test_picked_boundaries(conditions, count, written):
    text = MATERIAL + BALL + BLOCK + f'contact = "here"\n[bodies.block.boundaries.here]\n{conditions}\n'
    file = fc.read_scene(written(text + PRESSED.replace("half", "block")))
    assert len(file.bodies["block"].mesh.faces("here")) == count


def test_a_layer_grown_on_a_body_and_on_a_file(written, tmp_path):
    points = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)
    meshio.Mesh(points, [("triangle", [[0, 1, 2], [0, 2, 3]])]).write(tmp_path / "flat.stl")
    for source in ('body = "block", boundary = "top"', 'surface = "flat.stl"'):
        grown = f'[bodies.half]\nextrude = {{{source}, thickness = 0.25, layers = 2}}\nmaterial = "soft"\n'
        more = 'contact = "top"\nsupports = {base = "xyz"}\n'
        file = fc.read_scene(written(MATERIAL + BALL + BLOCK + grown + more + PRESSED))
        mesh = file.bodies["half"].mesh
        assert np.isclose(mesh.points[:, 2].max(), 1.25)
        assert set(mesh.boundaries) == {"base", "top", "side"}


def test_a_solid_within_a_surface_repaired(written, tmp_path):
    """Source: the block itself; a facet of its file is missing, and in another one more than a quarter."""
    block = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element="hex8")
    triangles = block.skin[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    meshio.Mesh(block.points, [("triangle", triangles[30:])]).write(tmp_path / "open.stl")
    body = '[bodies.half]\nsolid = {{file = "open.stl", size = 0.4, element = "tet4"{}}}\nmaterial = "soft"\n'
    body += 'contact = "top"\nsupports = {{base = "xyz"}}\n'
    for name, z in (("base", 0), ("top", 1)):
        body += f"[bodies.half.boundaries.{name}]\nplane = {{{{point = [0, 0, {z}], normal = [0, 0, 1]}}}}\n"
    assert "open.stl is open" in faults(written(MATERIAL + BALL + body.format("") + PRESSED))
    meshio.Mesh(block.points, [("triangle", triangles[1:])]).write(tmp_path / "open.stl")
    file = fc.read_scene(written(MATERIAL + BALL + body.format(", holes = 3, near = [[0.5, 0.5, 1]]") + PRESSED))
    mesh = file.bodies["half"].mesh
    assert list(mesh.kinds) == ["tet4"]
    assert np.isclose(fc.SurfaceMesh.of(mesh, "top").areas.sum(), 1.0, rtol=1e-9)
    assert any("1 hole was filled, facets more: 1" in note for note in mesh.notes)


def test_a_layer_on_a_repaired_surface(written, tmp_path):
    points = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0.5, 1e-6, 1]])
    facets = [[0, 1, 4], [1, 2, 4], [0, 4, 3], [4, 2, 3]]
    meshio.Mesh(points, [("triangle", facets)]).write(tmp_path / "flat.off")
    grown = '[bodies.half]\nextrude = {surface = "flat.off", thickness = 0.25, smoothing = 1, strict = true}\n'
    more = 'material = "soft"\ncontact = "top"\nsupports = {base = "xyz"}\n'
    file = fc.read_scene(written(MATERIAL + BALL + grown + more + PRESSED))
    assert len(file.bodies["half"].mesh.cells) == 3
    of_body = grown.replace('surface = "flat.off"', 'body = "block", boundary = "top"')
    assert "half.extrude.smoothing: belongs to a surface" in faults(written(MATERIAL + BLOCK + of_body + more))


def test_a_section_from_a_file(written, tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1.0]])
    meshio.Mesh(points, [("quad", [[0, 1, 2, 3]])], point_sets={"low": [0, 1], "high": [2, 3]}).write(
        tmp_path / "plate.inp"
    )
    body = '[bodies.half]\ntype = "plane"\nmesh = "plate.inp"\nscale = 2.0\nmaterial = "soft"\ncontact = "high"\n'
    body += 'thickness = 1.0\nplane = "strain"\nsupports = {low = "xz"}\n'
    file = fc.read_scene(written(MATERIAL + BALL + body + PRESSED))
    assert file.bodies["half"].mesh.points.max() == 2.0
    both = body.replace("scale = 2.0", 'shape = {kind = "rectangle"}')
    assert "half.shape: a section is from a file (mesh) or of a shape, not both" in faults(written(MATERIAL + both))
    alone = body.replace('mesh = "plate.inp"\n', 'shape = {kind = "rectangle", size = [1, 1], divisions = [1, 1]}\n')
    assert "half.scale: belongs to a section from a file" in faults(written(MATERIAL + alone))


CASES = (
    '[[contacts]]\nslave = "half"\nmaster = "ball"\n[[cases]]\nname = "light"\nmotions.ball = {z = -0.02}\n'
    "[[cases]]\nmotions.ball = {z = -0.05}\n[[cases]]\nname = 'moved'\nmotions.ball = {z = -0.02}\n"
    "poses.ball = {translation = [0, 0, -0.03]}\n"
)


@pytest.mark.parametrize("suffix", ["csv", "jsonl"])
def test_a_sweep(suffix, written, tmp_path, capsys):
    path = written(MATERIAL + BALL + HALF + CASES + f'[outputs]\ncases = "out.{suffix}"\n')
    assert main(["solve", str(path), "--json", str(tmp_path / "all.json")]) == 0
    assert "half on ball" in capsys.readouterr().out
    rows = json.loads((tmp_path / "all.json").read_text())["cases"]
    assert [row["name"] for row in rows] == ["light", "1", "moved"]
    forces = [row["contacts"][0]["force"][2] for row in rows]
    assert abs(forces[2] / forces[1] - 1) < 1e-9  # the pose and the motion add up
    text = (tmp_path / f"out.{suffix}").read_text()
    if suffix == "csv":
        table = list(csv.DictReader(text.splitlines()))
        assert [float(row["force_z"]) for row in table] == forces
    else:
        assert [json.loads(line)["contacts"][0]["force"][2] for line in text.splitlines()] == forces
    assert main(["solve", str(path), "--dry-run"]) == 0
    assert "case     light" in capsys.readouterr().out


def test_cases_have_parameters_and_are_drawn_together(written, tmp_path, capsys):
    path = written(
        MATERIAL + BALL + HALF + CASES.replace("[[cases]]\nmotions", "[[cases]]\nparameters = {angle = 30}\nmotions")
    )
    maps, moving = tmp_path / "maps.png", tmp_path / "maps.gif"
    assert main(["solve", str(path), "--montage", str(maps), "--animate", str(moving)]) == 0
    told = capsys.readouterr().out
    assert "angle" in told
    assert "half on ball: forces on half" in told
    assert f"wrote {maps}" in told
    assert maps.stat().st_size > 2000
    with Image.open(moving) as image:
        assert image.n_frames == 3
    assert main(["solve", str(path), "--animate", str(tmp_path / "maps.avi")]) == 2
    assert "suffix" in capsys.readouterr().err
    one = written(MATERIAL + BALL + HALF + PRESSED)
    assert main(["solve", str(one), "--montage", str(maps)]) == 2
    assert "no [[cases]]" in capsys.readouterr().err
    for wrong, what in (('{angle = "up"}', "angle"), ("{area = 3}", "name of a column"), ("3", "table")):
        changed = CASES.replace("[[cases]]\nmotions", f"[[cases]]\nparameters = {wrong}\nmotions")
        assert what in faults(written(MATERIAL + BALL + HALF + changed))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cells = [24, 24]", "cells = [24, 1]", "at least 2; found"),
        ("cells = [24, 24]", "cells = [24, 2.5]", "two whole numbers"),
        ('material = "soft"\nsize', "size", "half-space without material is rigid"),
        ('"soft"\nsize', '"sft"\nsize', "unknown material 'sft', did you mean 'soft'"),
        ("cells = [24, 24]", "cells = [24, 24]\nperiod = true", "unknown key, did you mean 'periodic'"),
        ("cells = [24, 24]", "cells = [24, 24]\nlayers = [{thickness = 1}]", "layers #1.material: is missing"),
        ('shape = {kind = "sphere", radius = 2.0}', 'heights = {file = "no.npy"}', "there is no file"),
        ('shape = {kind = "sphere", radius = 2.0}', "surface = {scale = 1}", "surface.file: is missing"),
    ],
)
def test_faults_are_named(old, new, message, written):
    text = MATERIAL + BALL + HALF + PRESSED
    assert old in text
    assert message in faults(written(text.replace(old, new, 1)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BLOCK + "[bodies.block.boundaries.x]\n", "at least one of plane, box, facing and flood"),
        (BLOCK + "[bodies.block.boundaries.x]\nbox = [1, 2, 3]\n", "two opposite corners"),
        (BLOCK + "[bodies.block.boundaries.x]\nplane = {point = [0, 0, 9], normal = [0, 0, 1]}\n", "boundaries.x"),
        (BLOCK.replace('shape = {kind = "block", size = [1, 1, 1], divisions = [4, 4, 2]}',
                       'extrude = {body = "ghost", boundary = "top", thickness = 1}'), "no body 'ghost' is declared"),
    ],
)  # fmt: skip
def test_faults_of_meshes_are_named(text, message, written):
    assert message in faults(written(MATERIAL + BALL + text + PRESSED.replace("half", "block")))


def test_outputs_of_a_sweep_and_of_one_case_are_not_mixed(written):
    assert "a sweep has cases" in faults(written(MATERIAL + BALL + HALF + CASES + '[outputs]\njson = "x.json"\n'))
    assert "needs the cases" in faults(written(MATERIAL + BALL + HALF + PRESSED + '[outputs]\ncases = "x.csv"\n'))
    wrong = CASES.replace("poses.ball", "poses.bell")
    assert "unknown body 'bell', did you mean 'ball'" in faults(written(MATERIAL + BALL + HALF + wrong))


def test_springs_on_a_half_space_are_refused(written):
    spring = "[[springs]]\nstiffness = 1.0\nstart = {body = 'half', point = [0, 0, 0]}\nend = {point = [0, 0, 1]}\n"
    with refused(fc.InputError, "input", "'half'"):
        fc.read_scene(written(MATERIAL + BALL + HALF + PRESSED + spring)).solve()


CAP = (
    '[bodies.ball]\nshape = {kind = "quarter_sphere", radius = 10.0, contact_radius = 0.5, level = 1}\n'
    'material = "soft"\ncontact = "cap"\nsupports = {base = "xyz"}\n'
)
FLOOR = '[bodies.floor]\ntype = "rigid"\nshape = {kind = "plane"}\n[[contacts]]\nslave = "ball"\nmaster = "floor"\n'


def cap_points(written, geometry):
    file = fc.read_scene(written(MATERIAL + CAP + f"geometry = {geometry}\n" + FLOOR))
    body = file.bodies["ball"]
    return body.mesh.points[body.surface("cap").nodes]


@pytest.mark.parametrize(
    "geometry",
    [
        '{kind = "sphere", radius = 10.0}',
        '{cap = {kind = "sphere", radius = 10.0}}',
        # the same sphere, turned about its own centre
        '{kind = "sphere", radius = 10.0, '
        "pose = {translation = [0, -10, 10], rotation = {axis = [1, 0, 0], angle_deg = -90}}}",
    ],
)
def test_contact_faces_on_a_shape(geometry, written):
    """The middles of faces lie off the sphere by the missing term of the 20-node map, those on the sphere do not."""
    off = {
        g: np.abs(np.linalg.norm(cap_points(written, g) - [0, 0, 10.0], axis=1) - 10.0).max()
        for g in ('"plain"', geometry)
    }
    assert off['"plain"'] > 1e-6
    assert off[geometry] < 1e-11


def test_contact_faces_fitted(written):
    fitted, by_name = (cap_points(written, g) for g in ('"auto"', '{cap = "auto"}'))
    assert (fitted == by_name).all()
    assert not (fitted == cap_points(written, '"plain"')).all()


@pytest.mark.parametrize(
    ("geometry", "told"),
    [
        ('"smooth"', "bodies.ball.geometry: unknown value 'smooth'; expected auto, plain."),
        ("3.0", "bodies.ball.geometry: must be a text in quotation marks; found 3.0."),
        ('{cap = "exact"}', "bodies.ball.geometry.cap: unknown value 'exact'"),
        ('{kind = "ball", radius = 10.0}', "bodies.ball.geometry.kind: unknown value 'ball'"),
        ('{kind = "sphere", radius = 10.0, place = 1}', "bodies.ball.geometry.place: unknown key"),
        ('{cup = "auto"}', "geometry names 'cup', which are no contact surfaces; these are 'cap'."),
        ('{kind = "sphere", radius = 3.0}', "from the given surface"),
    ],
)
def test_wrong_geometry_is_a_fault(geometry, told, written):
    assert told in faults(written(MATERIAL + CAP + f"geometry = {geometry}\n" + FLOOR))
