"""The table of many cases: columns, files, text."""

import csv
import json
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from PIL import Image
from refusals import refused
from scipy.spatial import cKDTree

import fecontact as fc
from fecontact import InputError

SOLID = fc.Material(E=10.0, nu=0.0)


@pytest.fixture(scope="module")
def blocks():
    """Two blocks side by side on a plate that moves, in this order of bodies; without bulging, pressure is uniform."""
    made = []
    for name, x in (("left", 0.0), ("right", 2.0)):
        mesh = fc.shapes.block((1.0, 2.0, 1.0), (2, 2, 1)).translated((x, 0.0, 0.0))
        made.append(fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, name=name))
    plate = fc.RigidBody(fc.Plane(), name="plate")
    scene = fc.Scene([*made, plate], [fc.Contact(plate, made[0]), fc.Contact(made[1], plate)], units=("mm", "N", "MPa"))
    cases = [
        {"name": f"up {z:g}", "motions": {plate: {"z": z}}, "parameters": {"depth": z}} for z in (0.01, 0.02, 0.03)
    ]
    return scene, cases, scene.sweep(cases)


def test_columns_are_the_figures_of_the_contacts_on_the_first_body_as_given(blocks):
    _, _, table = blocks
    depth = np.array([0.01, 0.02, 0.03])
    assert np.allclose(table.column("depth"), depth)
    assert np.allclose(table.column("motions plate z"), depth)
    # uniform pressure E depth / height on 1 x 2 mm; downwards on the plate, which is named first, upwards on the block
    for label, sign in (("plate on left", -1.0), ("right on plate", 1.0)):
        assert np.allclose(table.column(f"{label}: max_pressure"), 10 * depth, rtol=1e-9)
        assert np.allclose(table.column(f"{label}: mean_pressure"), 10 * depth, rtol=1e-9)
        assert np.allclose(table.column(f"{label}: force_z"), sign * 20 * depth, rtol=1e-9)
        assert np.allclose(table.column(f"{label}: area"), 2.0, rtol=1e-9)
        assert np.allclose(table.column(f"{label}: centre_y"), 1.0, rtol=1e-9)
    with refused(InputError, "unknown-name", "'peak'"):
        table.column("peak")


def test_a_table_is_the_sequence_of_its_rows(blocks):
    _, _, table = blocks
    assert len(table) == 3
    assert [row["name"] for row in table] == list(table.names) == ["up 0.01", "up 0.02", "up 0.03"]
    assert table[1] is table["up 0.02"] is table[-2]
    assert table[1:] == table.rows[1:]
    with refused(InputError, "unknown-name", "'up'"):
        table["up"]
    with pytest.raises(AttributeError):
        table.rows = ()


def test_text_has_one_line_for_each_case_and_contact_with_units_and_what_changes(blocks):
    _, _, table = blocks
    heads, lines = table.printed.heads, table.printed.cells
    assert heads[:4] == ["case", "depth", "motions plate z [mm]", "contact"]
    assert heads[4:8] == ["force_x [N]", "force_y [N]", "force_z [N]", "area [mm²]"]
    assert lines[5][:8] == ["up 0.03", "0.03", "0.03", "right on plate", "0", "0", "0.6", "2"]
    text = str(table).splitlines()
    assert len(text) == 1 + 6 + 2
    assert text[-2:] == ["plate on left: forces on plate", "right on plate: forces on right"]
    shown = repr(table)
    assert shown.startswith("CaseTable(3 cases, plate on left: force 0.2 to 0.6, peak 0.1 to 0.3, right on plate: ")
    assert "\n" not in shown
    page = table._repr_html_()
    assert page.count("<tr>") == 7
    assert "area [mm²]" in page


def test_files_have_all_columns_and_rows(blocks, tmp_path):
    _, _, table = blocks
    with table.save(tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["case"] for line in lines] == list(table.names)
    for name, values in table.figures.items():
        assert [float(line[name]) for line in lines] == values.tolist()
    assert json.loads(table.save(tmp_path / "a.json").read_text())["cases"] == json.loads(json.dumps(list(table)))
    assert [json.loads(line)["name"] for line in table.save(tmp_path / "a.jsonl").open()] == list(table.names)
    with refused(InputError, "unknown-name", "suffix"):
        table.save(tmp_path / "a.xls")


def test_a_name_is_no_formula_of_a_spreadsheet(blocks, tmp_path):
    scene, cases, _ = blocks
    table = scene.sweep([{**cases[0], "name": "=1+1"}])
    with table.save(tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        assert [line["case"] for line in csv.DictReader(file)] == ["'=1+1"]


def test_a_resumed_table_has_the_loads_and_the_parameters_of_now(blocks, tmp_path):
    scene, cases, _ = blocks
    path = tmp_path / "rows.jsonl"
    (first,) = scene.sweep(cases[:1], path)
    (row,) = scene.sweep([{**cases[0], "parameters": {"angle": 3.0}}], path)
    assert row["parameters"] == {"angle": 3.0}
    assert row["loads"] == {"motions plate z": 0.01}
    assert row["contacts"] == json.loads(json.dumps(first["contacts"]))


@pytest.mark.parametrize(
    ("parameters", "code", "found"),
    [
        ({"angle": "up"}, "not-finite", "angle"),
        ({"angle": np.nan}, "not-finite", "angle"),
        ({"area": 1.0}, "input", "'area'"),
        ({"forces of mine": 1.0}, "input", "'forces of mine'"),
        ({"": 1.0}, "not-a-text", "name of a parameter"),
        ([1.0], "not-a-mapping", "[1.0]"),
    ],
)
def test_parameters_that_are_none_are_refused_with_their_case(blocks, parameters, code, found):
    scene, cases, _ = blocks
    with refused(InputError, code, "'up 0.01'", found):
        scene.sweep([{**cases[0], "parameters": parameters}])


def test_no_cases_are_an_empty_table(blocks):
    table = blocks[0].sweep([])
    assert len(table) == 0
    assert repr(table) == "CaseTable(0 cases)"


def test_curves_are_drawn_over_the_cases_or_a_parameter(blocks, tmp_path):
    _, _, table = blocks
    figure = table.plot(path=tmp_path / "cases.png")
    assert (tmp_path / "cases.png").stat().st_size > 2000
    assert [axes.get_ylabel() for axes in figure.axes] == ["force [N]", "area [mm²]", "max pressure [MPa]"]
    assert [t.get_text() for t in figure.axes[-1].get_xticklabels()] == list(table.names)
    assert [line.get_label() for line in figure.axes[0].lines] == ["plate on left", "right on plate"]
    (axes,) = table.plot("plate on left: force_z", over="depth").axes
    assert axes.lines[0].get_xdata().tolist() == [0.01, 0.02, 0.03]
    assert np.allclose(axes.lines[0].get_ydata(), [-0.2, -0.4, -0.6])
    for wrong in ({"over": "time"}, {"over": 3.0}):
        with refused(InputError, "unknown-name", "column"):
            table.plot(**wrong)
    with refused(InputError, "unknown-name", "'peak'"):
        table.plot("peak")
    with refused(InputError, "no-cases"):
        blocks[0].sweep([]).plot()


@pytest.fixture(scope="module")
def rolled(tmp_path_factory):
    """A ball beside the middle of a pad in three poses, with fields, sides and files."""
    mesh = fc.shapes.block((3.0, 3.0, 1.0), (8, 8, 1)).translated((-1.5, -1.5, -1.0))
    pad = fc.ElasticBody(mesh, fc.Material(E=1000.0, nu=0.3), "top", {"bottom": "xyz"}, name="pad")
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball")
    scene = fc.Scene([pad, ball], [fc.Contact(ball, pad)], units=("mm", "N", "MPa"))
    cases = [
        {
            "name": f"x{x:g}",
            "poses": {ball: fc.Pose(translation=(x, 0.0, 0.0))},
            "forces": {ball: (0.0, 0.0, -f)},
            "parameters": {"time": 10 * x},
        }
        for x, f in ((-0.5, 40.0), (0.0, 80.0), (0.5, 40.0))
    ]
    folder = tmp_path_factory.mktemp("rolled")
    plane = fc.DividingPlane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), ball, ("right", "left"))
    given = {"keep": ("pressure", "gap"), "split": plane, "save": folder / "run.pvd"}
    return scene, cases, given, folder, scene.sweep(cases, folder / "rows.jsonl", **given)


def test_sides_of_a_plane_that_moves_with_a_body_add_up_to_the_contact(rolled):
    scene, cases, _, _, table = rolled
    for name in ("force_x", "force_y", "force_z", "area"):
        whole = table.column(name)
        both = table.column(f"right: {name}") + table.column(f"left: {name}")
        assert np.abs(both - whole).max() <= 1e-9 * table.column("force").max()
    # the plane goes through the ball's middle, about which pad and pressure are symmetric in the second pose
    assert abs(table.column("right: force_z")[1] / 40.0 - 1) < 1e-9
    assert abs(table.column("right: area")[1] / table.column("left: area")[1] - 1) < 1e-9
    # in the other two the two are mirror images
    assert abs(table.column("right: force_z")[0] / table.column("left: force_z")[2] - 1) < 1e-6
    # in the world's axes the plane stays in the middle, where the ball beside it is on one side only, but for its rim
    world = scene.sweep(cases[:1], split=((-1.0, 0.0, 0.0), (-2.0, 0.0, 0.0)))
    assert world.column("front: force_z")[0] + world.column("back: force_z")[0] == pytest.approx(40.0, rel=1e-9)
    assert world.column("front: max_pressure")[0] < world.column("back: max_pressure")[0]
    heads, lines = table.printed.heads, table.printed.cells
    assert heads[-7:-4] == ["right: force [N]", "right: area [mm²]", "right: max_pressure [MPa]"]
    assert lines[1][-7] == f"{table.column('right: force')[1]:.4g}"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"split": ((0, 0, 0),)}, ("split", "((0, 0, 0),)")),
        ({"split": "x"}, ("not-a-sequence", "a point and a normal")),
        ({"split": ((0, 0, 0), (0, 0, 0))}, ("normal-zero",)),
        (
            {"split": fc.DividingPlane((0, 0, 0), (1, 0, 0), fc.RigidBody(fc.Plane(), name="other"))},
            ("not-in-scene", "'other'"),
        ),
        ({"keep": "displacement"}, ("unknown-name", "field", "to keep 'displacement'")),
        ({"keep": 3}, ("not-a-sequence", "The fields to keep")),
        ({"keep": "friction"}, ("input", "No contact has friction")),
        ({"save": "same.vtu"}, ("same-file", "same.vtu")),
        ({"save": "{number}.vtu"}, ("input", "'number'")),
        ({"save": "{name.vtu"}, ("input", "cannot be read")),
        ({"save": "none/{name}.vtu"}, ("no-folder", "does not exist")),
        ({"save": "{name}.txt"}, ("unknown-name", "suffix")),
        ({"save": 3}, ("not-a-sequence", "The files of a sweep")),
    ],
)
def test_wishes_that_are_none_are_refused_before_any_case(rolled, tmp_path, given, told):
    scene, cases, *_ = rolled
    with refused(InputError, *told):
        scene.sweep(cases, tmp_path / "rows.jsonl", **given)
    assert not (tmp_path / "rows.jsonl").exists()


def test_names_that_cannot_be_in_a_path_are_refused(rolled, tmp_path):
    scene, cases, *_ = rolled
    with refused(InputError, "input", "'a/b'"):
        scene.sweep([{**cases[0], "name": "a/b"}], save=str(tmp_path / "{name}.vtu"))
    with refused(InputError, "side-names", "('a', 'a')"):
        fc.DividingPlane((0, 0, 0), (1, 0, 0), sides=("a", "a"))
    with refused(InputError, "input", "'x0'", "keep"):
        scene.sweep([{**cases[1], "keep": ("pressure",)}])


def test_kept_fields_are_those_of_the_results(rolled):
    table = rolled[-1]
    fields = table.fields("pressure")
    assert len(fields) == 3
    forces = table.column("mean_pressure") * table.column("area")
    for kept, force, peak in zip(fields, forces, table.column("max_pressure"), strict=True):
        assert abs(kept.values @ kept.areas / force - 1) < 1e-9
        assert kept.peak == peak
    assert [kept.centre_of_pressure[0] for kept in fields] == table.column("centre_x").tolist()
    # no kept field holds a body or its displacements: 0.4 kB a facet, and what belongs to the case as a whole
    size = len(pickle.dumps(fields[1]))
    assert size < 600 * len(fields[1].facets) + 5000
    with refused(InputError, "not-kept", "friction", "'x-0.5'"):
        table.fields("friction")
    for wrong in ({"contact": 1}, {"cases": ["y"]}, {"cases": [7]}, {"cases": []}, {"what": "stress"}):
        with pytest.raises(InputError):
            table.fields(**wrong)


def test_workers_send_the_fields_too(rolled):
    scene, cases, given, _, table = rolled
    with ThreadPoolExecutor(1) as pool:  # gets bytes and sends rows and fields, as a process does
        there = scene.sweep(cases, executor=pool, keep="pressure", split=given["split"])
    for a, b in zip(table.fields(), there.fields(), strict=True):
        assert np.allclose(a.values[a.active], b.values[b.active], rtol=1e-9)
    assert np.allclose(there.column("right: force_z"), table.column("right: force_z"), rtol=1e-9)


def test_a_montage_has_one_scale_and_names_and_the_same_window(rolled, tmp_path):
    _, _, _, _, table = rolled
    for what in ("pressure", "gap"):
        figure = table.montage(what, tmp_path / "pressure.png" if what == "pressure" else None)
        *maps, bar = figure.axes
        assert len(maps) == 3
        assert [axes.get_title().splitlines()[0] for axes in maps] == list(table.names)
        assert len({axes.collections[0].get_clim() for axes in maps}) == 1
        assert len({(axes.get_xlim(), axes.get_ylim()) for axes in maps}) == 1
        low, high = maps[0].collections[0].get_clim()
        assert bar.get_ylim() == (low, high)
        if what == "pressure":
            assert (low, high) == (0.0, max(table.column("max_pressure")))
        # all three contacts are in the window
        window = maps[0].get_xlim()
        assert window[0] < -0.9
        assert window[1] > 0.9
    with Image.open(tmp_path / "pressure.png") as image:
        assert min(image.size) > 300
    assert len(table.montage(cases=["x0"]).axes) == 2


def test_sections_are_drawn_as_curves_in_the_same_axes(tmp_path):
    mesh = fc.sections.rectangle((2.0, 1.0), (8, 3))
    strip = fc.PlaneBody(mesh, fc.Material(E=10.0, nu=0.3), "top", {"bottom": "xz"}, name="strip")
    roller = fc.RigidBody(fc.surfaces.Cylinder(3.0), name="roller").placed((1.0, 0.0, 1.0))
    scene = fc.Scene([strip, roller], [fc.Contact(strip, roller)])
    table = scene.sweep(
        [{"motions": {roller: {"z": -z}}} for z in (0.02, 0.04)], keep=("pressure", "gap"), split=((1, 0, 0), (1, 0, 0))
    )
    for what in ("pressure", "gap"):
        axes = table.montage(what).axes
        assert len(axes) == 2
        assert len({(a.get_xlim(), a.get_ylim()) for a in axes}) == 1
    peak = table.column("max_pressure")[1]
    assert table.montage().axes[0].get_ylim() == pytest.approx((0.0, 1.05 * peak))
    np.testing.assert_allclose(table.column("front: force_z"), table.column("force_z") / 2, rtol=1e-9)
    with Image.open(table.animate(tmp_path / "strip.gif", cases=[1])) as image:
        assert image.n_frames == 1


def test_an_animation_has_a_frame_for_each_case(rolled, tmp_path):
    _, _, _, _, table = rolled
    with Image.open(table.animate(tmp_path / "run.gif", rate=4)) as image:
        assert image.n_frames == 3
        assert image.info["duration"] == 250
        frames = []
        for k in range(3):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB"), float))
    assert all(np.abs(a - b).max() > 100 for a, b in pairwise(frames))
    with refused(InputError, "unknown-name", "suffix", "of an animation '.avi'"):
        table.animate(tmp_path / "run.avi")
    for wrong in (0, 2.5, "fast"):
        with refused(InputError, "not-whole", "The frames per second"):
            table.animate(tmp_path / "run.gif", rate=wrong)


def test_mp4_without_ffmpeg_is_refused_in_words(rolled, tmp_path, monkeypatch):
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with refused(fc.MissingPackageError, "missing-package", "ffmpeg"):
        rolled[-1].animate(tmp_path / "run.mp4")
    assert not (tmp_path / "run.mp4").exists()


def test_the_collection_for_paraview_lists_a_file_of_each_case_at_its_time(rolled):
    _, _, _, folder, table = rolled
    sets = ElementTree.parse(folder / "run.pvd").findall("./Collection/DataSet")
    assert [float(each.get("timestep")) for each in sets] == [-5.0, 0.0, 5.0]
    for each, name, kept in zip(sets, table.names, table.fields(), strict=True):
        assert each.get("file") == f"run_{name}.vtu"
        mesh = meshio.read(folder / each.get("file"))
        # the pad is the slave; the file's elements have no mid-face nodes
        away, nearest = cKDTree(kept.points).query(mesh.points)
        there = away < 1e-9
        assert there.sum() > 0.5 * len(kept.points)
        assert np.allclose(mesh.point_data["contact_pressure"][there], kept.values[nearest[there]], rtol=1e-9)
    # beside another folder, and with other times
    other = folder / "sub"
    other.mkdir()
    table.to_pvd(other / "x.pvd", over="poses ball x")
    moved = ElementTree.parse(other / "x.pvd").findall("./Collection/DataSet")
    assert [each.get("file") for each in moved] == [f"../run_{name}.vtu" for name in table.names]
    rows = ({**table[0], "parameters": {}}, table[1])
    with refused(InputError, "unknown-figure", "'time'"):
        replace(table, rows=rows, maps=()).save(other / "y.pvd")
    with refused(InputError, "input", "has written no .vtu file"):
        replace(table, rows=({**table[0], "files": []},)).save(other / "z.pvd")


def test_a_collection_of_a_resumed_sweep_needs_the_files_of_before(rolled, tmp_path):
    scene, cases, *_ = rolled
    path = tmp_path / "rows.jsonl"
    scene.sweep(cases[:1], path, save=tmp_path / "run.pvd")
    again = scene.sweep(cases[:2], path, save=tmp_path / "run.pvd", keep="pressure")
    assert len(ElementTree.parse(tmp_path / "run.pvd").findall("./Collection/DataSet")) == 2
    with refused(InputError, "not-kept", "'x-0.5'"):
        again.montage()
    assert len(again.montage(cases=[1]).axes) == 2
    (tmp_path / "run_x-0.5.vtu").unlink()
    with refused(InputError, "file-of-case-missing", "'x-0.5'"):
        scene.sweep(cases, path, save=tmp_path / "run.pvd")
