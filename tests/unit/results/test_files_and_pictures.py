"""Results on paper, on screen and in files."""

import csv
import json
import os
import stat
import threading
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.common.files import check_writable, save_json
from fecontact.results.files import nodal_pressure, save_series


@pytest.fixture(scope="module")
def pressed():
    """A block pressed on a plane by two percent of its height, uniaxially: sigma = E * 0.02."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    supports = {"top": "z", "x_min": "x", "y_min": "y"}
    block = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), contact="bottom", supports=supports, name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return block, fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.02}})


def test_print_shows_forces_pressures_residuals_and_time(pressed):
    text = str(pressed[1])
    for word in ("solved", "block.bottom on floor.surface", "force on block", "pressure max", "Residuals", "Seconds"):
        assert word in text


def test_json_summary(pressed, tmp_path):
    data = json.loads(pressed[1].save(tmp_path / "r.json").read_text())
    assert abs(data["contacts"][0]["force"][2] - 1.0) < 1e-12  # E * strain * area, exact for a uniform state
    assert data["contacts"][0]["regions"] == 1


def test_csv_has_one_row_per_point(pressed, tmp_path):
    rows = list(csv.DictReader(pressed[1].save(tmp_path / "r.csv").open()))
    assert len(rows) == len(pressed[1].contacts[0].points)
    assert abs(sum(float(r["force"]) for r in rows) - 1.0) < 1e-12


def test_picture_of_pressure_and_gap(pressed, tmp_path):
    for what in ("pressure", "gap"):
        pressed[1].plot(what, tmp_path / f"{what}.png")
        assert (tmp_path / f"{what}.png").stat().st_size > 5000


def test_a_contact_whose_facets_all_hang_over_is_drawn(tmp_path):
    # each face of the slave hangs over the punch
    plate = fc.ElasticBody(
        fc.shapes.block((3.0, 3.0, 1.0), (2, 2, 1)), fc.Material(E=50.0, nu=0.3), "top", {"bottom": "xyz"}, name="plate"
    )
    mesh = fc.shapes.block((1.8, 1.8, 1.0), (3, 3, 1)).translated((0.6, 0.6, 1.0))
    punch = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "bottom", {"top": "xyz"}, name="punch")
    scene = fc.Scene([plate, punch], [fc.Contact(plate, punch, swap="never")])
    result = scene.solve(motions={punch: {"z": -0.02}})
    assert result.contacts[0].total_force > 0
    result.plot("pressure", tmp_path / "p.png")
    assert (tmp_path / "p.png").stat().st_size > 2000


def test_unknown_field_and_file_type_are_refused(pressed, tmp_path):
    with refused(fc.InputError, "unknown-name", "'pressure', 'gap'"):
        pressed[1].plot("colour")
    with refused(fc.InputError, "input", "'.xyz'"):
        pressed[1].save(tmp_path / "r.xyz")


def test_unwritable_paths_are_refused(tmp_path):
    with refused(fc.InputError, "no-folder", "x.json"):
        check_writable(tmp_path / "none" / "x.json")
    with refused(fc.InputError, "is-a-folder", "test_unwritable_paths_are_refu0"):
        check_writable(tmp_path)


def test_an_interrupted_write_leaves_the_old_file(pressed, tmp_path, written):
    path = written("old", "r.json")
    pressed[1].save(path)
    assert json.loads(path.read_text())["status"] == "solved"
    assert stat.S_IMODE(path.stat().st_mode) & stat.S_IROTH
    assert list(tmp_path.iterdir()) == [path]


def test_stress_and_strain_of_a_uniform_state(pressed):
    block, result = pressed
    stress, strain = result.stress(block), result.strain(block)
    expected = np.array([0, 0, -1.0, 0, 0, 0])
    assert np.abs(stress - expected).max() < 1e-12  # linear fields are reproduced exactly
    assert np.abs(strain[:, 0] - 0.3 * 0.02).max() < 1e-12


def test_csv_names_the_region_of_each_point(pressed, tmp_path):
    rows = list(csv.DictReader(pressed[1].save(tmp_path / "r.csv").open()))
    assert {r["region"] for r in rows} == {"1"}


def test_series_for_paraview(pressed, tmp_path):
    path = save_series([pressed[1], pressed[1]], tmp_path / "gait & more.pvd", times=[0.0, 0.5])
    sets = ElementTree.parse(path).getroot().findall("Collection/DataSet")
    assert [float(s.get("timestep")) for s in sets] == [0.0, 0.5]
    for s in sets:
        assert set(meshio.read(tmp_path / s.get("file")).point_data) >= {"displacement", "von_mises"}
    with refused(fc.InputError, "input", "found 1", "and 2"):
        save_series([pressed[1]], path, times=[0.0, 1.0])
    with refused(fc.InputError, "not-pvd", "'x.vtu'"):
        save_series([pressed[1]], tmp_path / "x.vtu")


def test_master_shows_the_pressure_opposite_its_nodes():
    """Two equal blocks pressed together uniformly: E * strain on both faces, nothing elsewhere."""
    cork = fc.Material(E=10.0, nu=0.0)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    upper = fc.ElasticBody(mesh, cork, "bottom", {"top": "xyz"}, name="upper").placed((0, 0, 1))
    lower = fc.ElasticBody(mesh, cork, "top", {"bottom": "xyz"}, name="lower").placed((0, 0, 0))
    result = fc.Scene([upper, lower], [fc.Contact(upper, lower)]).solve(motions={upper: {"z": -0.02}})
    for body, boundary in ((upper, "bottom"), (lower, "top")):
        pressure = nodal_pressure(result, body)
        nodes = body.mesh.boundary_nodes(boundary)
        assert np.abs(pressure[nodes] - 0.1).max() <= 1e-10  # uniaxial state, exact for these elements
        assert np.count_nonzero(pressure) == len(nodes)


def test_maps_have_units_forces_and_outlines(pressed):
    units = {"units": "MPa", "length": "mm", "force": "N"}
    figure = pressed[1].plot("pressure", **units)
    axes, bar = figure.axes
    assert bar.get_ylabel() == "contact pressure [MPa]"
    assert axes.get_xlabel() == "x [mm]"
    assert axes.get_title() == "block.bottom on floor.surface\nforce 1 N, area 1 mm², peak 1 MPa, mean 1 MPa"
    assert pressed[1].plot("gap", **units).axes[1].get_ylabel() == "gap [mm]"


def test_sensels_feel_the_whole_force(pressed):
    # nine sensels and a bit: those at the rim are covered in part and feel less
    figure = pressed[1].plot("pressure", style="sensels", pitch=0.3, units="MPa", length="mm")
    felt = figure.axes[0].collections[0].get_array()
    # samples shared by overlap: exact for a uniform pressure on squares, up to what is left out below 2 %
    assert abs(felt.filled(0.0).sum() * 0.09 - 1.0) <= 1e-12
    assert abs(felt.max() - 1.0) <= 1e-12
    assert figure.axes[1].get_ylabel() == "pressure on sensels [MPa], pitch 0.3 mm"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"style": "dots"}, ("unknown-name", "'smooth', 'sensels'")),
        ({"what": "gap", "style": "sensels"}, ("input", "Sensels feel pressure")),
        ({"pitch": -1.0}, ("not-positive", "The pitch of the sensels")),
        ({"contacts": [3]}, ("input", "contact 3", "has 1")),
        ({"what": "von_mises", "pixels": (0, 10)}, ("not-whole", "Each of pixels", "from 16")),
        ({"what": "von_mises", "pixels": (99,)}, ("pixels", "(99,)")),
        ({"what": "von_mises", "limits": (0.0, 1.0, 2.0)}, ("not-a-vector", "Limits", "two")),
        ({"what": "von_mises", "view": 30.0}, ("not-a-vector", "The view", "two")),
        ({"what": "von_mises", "scale": None}, ("not-finite", "The scale")),
    ],
)
def test_maps_that_cannot_be_drawn_are_refused(pressed, options, message):
    with refused(fc.InputError, *message):
        pressed[1].plot(**options)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_written_to_and_not_replaced(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    save_json(pipe, {"a": 1.0})
    reader.join(timeout=10)
    assert json.loads(read[0]) == {"a": 1.0}
    assert pipe.is_fifo()


def test_an_unbounded_peak_does_not_take_the_scale():
    # an elastic plate under a rigid punch with a sharp edge: nodal peaks there are a matter of the mesh
    x = np.array([-4.0, -2.0, -1.4, -1.15, -1.0, -0.85, -0.6, 0.0, 0.6, 0.85, 1.0, 1.15, 1.4, 2.0, 4.0]) + 4
    mesh = fc.shapes.block((8.0, 8.0, 4.0), (x, x, [0.0, 2.0, 3.2, 3.7, 4.0])).translated((-4.0, -4.0, -4.0))
    plate = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "top", {"bottom": "xyz"}, name="plate")
    punch = fc.RigidBody(fc.surfaces.FlatPunch(1.0), name="punch")
    result = fc.Scene([plate, punch], [fc.Contact(plate, punch)]).solve(motions={punch: {"z": -0.01}})
    (contact,) = result.contacts
    assert contact._singular_edge is not None
    axes, bar = result.plot("pressure").axes
    top = bar.get_ylim()[1]
    below = contact.weights[contact.pressure <= top].sum() - contact.weights[~contact.active].sum()
    assert 0.9 <= below / contact.weights[contact.active].sum() <= 1.0
    assert top < contact.max_pressure
    assert f"peak {contact.max_pressure:.4g}" in axes.get_title()
