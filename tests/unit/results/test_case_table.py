"""The table of many cases: columns, files, text."""

import csv
import json

import numpy as np
import pytest

import fecontact as fc
from fecontact.common.errors import InputError

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
    with pytest.raises(InputError, match="'peak'"):
        table.column("peak")


def test_a_table_is_the_sequence_of_its_rows(blocks):
    _, _, table = blocks
    assert len(table) == 3
    assert [row["name"] for row in table] == list(table.names) == ["up 0.01", "up 0.02", "up 0.03"]
    assert table[1] is table["up 0.02"] is table[-2]
    assert table[1:] == table.rows[1:]
    with pytest.raises(InputError, match="'up'"):
        table["up"]
    with pytest.raises(AttributeError):
        table.rows = ()


def test_text_has_one_line_for_each_case_and_contact_with_units_and_what_changes(blocks):
    _, _, table = blocks
    heads, lines = table.lines()
    assert heads[:4] == ["case", "depth", "motions plate z mm", "contact"]
    assert heads[4:8] == ["force_x N", "force_y N", "force_z N", "area mm²"]
    assert lines[5][:8] == ["up 0.03", "0.03", "0.03", "right on plate", "0", "0", "0.6", "2"]
    text = str(table).splitlines()
    assert len(text) == 1 + 6 + 2
    assert text[-2:] == ["plate on left: forces on plate", "right on plate: forces on right"]
    shown = repr(table)
    assert shown.startswith("CaseTable(3 cases, plate on left: force 0.2 to 0.6, peak 0.1 to 0.3, right on plate: ")
    assert "\n" not in shown
    page = table._repr_html_()
    assert page.count("<tr>") == 7
    assert "area mm²" in page


def test_files_have_all_columns_and_rows(blocks, tmp_path):
    _, _, table = blocks
    with table.save(tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["case"] for line in lines] == list(table.names)
    for name, values in table.figures.items():
        assert [float(line[name]) for line in lines] == values.tolist()
    assert json.loads(table.save(tmp_path / "a.json").read_text())["cases"] == json.loads(json.dumps(list(table)))
    assert [json.loads(line)["name"] for line in table.save(tmp_path / "a.jsonl").open()] == list(table.names)
    with pytest.raises(InputError, match="suffix"):
        table.save(tmp_path / "a.xls")


def test_a_resumed_table_has_the_loads_and_the_parameters_of_now(blocks, tmp_path):
    scene, cases, _ = blocks
    path = tmp_path / "rows.jsonl"
    (first,) = scene.sweep(cases[:1], path)
    (row,) = scene.sweep([{**cases[0], "parameters": {"angle": 3.0}}], path)
    assert row["parameters"] == {"angle": 3.0}
    assert row["loads"] == {"motions plate z": 0.01}
    assert row["contacts"] == json.loads(json.dumps(first["contacts"]))


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"angle": "up"}, "angle"),
        ({"angle": np.nan}, "angle"),
        ({"area": 1.0}, "name of a column"),
        ({"forces of mine": 1.0}, "name of a column"),
        ({"": 1.0}, "name of a parameter"),
        ([1.0], "mapping"),
    ],
)
def test_parameters_that_are_none_are_refused_with_their_case(blocks, parameters, told):
    scene, cases, _ = blocks
    with pytest.raises(InputError, match=f"Case 'up 0.01'.*{told}"):
        scene.sweep([{**cases[0], "parameters": parameters}])


def test_no_cases_are_an_empty_table(blocks):
    table = blocks[0].sweep([])
    assert len(table) == 0
    assert repr(table) == "CaseTable(0 cases)"
