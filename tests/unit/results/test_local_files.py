"""Files and pictures of scenes with local bodies: the body's mesh and the cells of its window."""

import csv
import json

import meshio
import numpy as np
import pytest

import fecontact as fc
from fecontact.results.pictures.solids import chosen, solids_of_file, solids_of_result

SOLID = fc.Material(E=1.0, nu=0.3)
AT = np.array([2.0, 2.0, 2.0])


@pytest.fixture(scope="module")
def solved():
    """A clamped block, rotated and away from the origin, under a ball."""
    body = fc.ElasticBody(fc.shapes.block((4.0, 4.0, 2.0), (4, 4, 3)), SOLID, supports={"bottom": "xyz"}, name="block")
    local = fc.LocalBody(body, AT, 0.8, (24, 20)).placed([1.0, 2.0, 3.0], fc.rotation_about((1, 0, 0), 0.4))
    ball = fc.RigidBody(fc.Sphere(10.0), pose=fc.Pose(local.pose.rotation, local.pose.to_world(AT[None])[0]))
    force = {ball: -0.003 * local.pose.rotation[:, 2]}
    return local, fc.Scene([local, ball], [fc.Contact(local, ball)]).solve(forces=force, finite_motion=False)


def test_vtu_holds_the_mesh_and_the_window(solved, tmp_path) -> None:
    local, result = solved
    file = meshio.read(result.save(tmp_path / "r.vtu"))
    (quads,) = [block.data for block in file.cells if block.type == "quad"]
    assert sum(len(b.data) for b in file.cells if b.type == "hexahedron20") == len(local.mesh.cells)
    cells, data = np.unique(quads), file.point_data
    contact = result.contacts[0]
    assert data["contact_pressure"][cells].max() == contact.max_pressure
    assert np.isnan(data["gap"]).sum() == len(file.points) - len(cells)
    assert abs(data["gap"][cells].min()) < 1e-9
    # on the block's top, and at its own places among the contact's points
    own = local.pose.to_body(file.points[cells])
    assert np.abs(own[:, 2] - 2).max() < 1e-12
    assert np.isin(own[:, :2].round(9), local.window.cells[:, :2].round(9)).all()
    # zz at the cells is the pressure, where it is evaluated and between
    p = data["contact_pressure"][cells]
    assert np.abs(data["stress"][cells, 2] + p).max() < 0.05 * p.max()
    u = result.displacement(local)
    assert np.abs(data["displacement"][: len(u)] - u).max() < 1e-12


def test_cells_move_with_the_indenter(solved, tmp_path) -> None:
    """Where the surfaces touch, the displacement of a cell is that of the ball less the gap before."""
    local, result = solved
    file = meshio.read(result.save(tmp_path / "r.vtu"))
    cells = np.unique(next(block.data for block in file.cells if block.type == "quad"))
    touching = cells[file.point_data["contact_pressure"][cells] > 0.1 * result.contacts[0].max_pressure]
    normal = local.pose.rotation[:, 2]
    r2 = ((local.pose.to_body(file.points[touching]) - AT) ** 2).sum(axis=1)
    expected = result.rigid_motion(result.scene.bodies[1]).translation @ normal + r2 / 20
    # linear between the lines at which it is evaluated
    assert np.abs(file.point_data["displacement"][touching] @ normal / expected - 1).max() < 2e-3


def test_csv_and_json(solved, tmp_path) -> None:
    _, result = solved
    rows = list(csv.DictReader(result.save(tmp_path / "r.csv").open(encoding="utf-8")))
    assert sum(float(row["force"]) for row in rows) == pytest.approx(0.003)
    told = json.loads(result.save(tmp_path / "r.json").read_text(encoding="utf-8"))
    assert told["contacts"][0]["max_pressure"] == result.contacts[0].max_pressure


def test_bodies_of_a_result_and_of_its_file_are_the_same(solved, tmp_path) -> None:
    _, result = solved
    ours, theirs = solids_of_result(result), solids_of_file(result.save(tmp_path / "r.vtu"))
    assert [s.name for s in ours] == ["block", "block"]
    assert [s.name for s in theirs] == ["0", "0"]
    for field in ("von_mises", "displacement_z", "stress_xx", "contact_pressure"):
        for one, other in zip(ours, theirs, strict=True):
            values = one.scalar(field)[one.mesh.cells], other.scalar(field)[other.mesh.cells]
            assert np.allclose(values[0].max(), values[1].max(), rtol=1e-12)
    assert len(chosen(ours, ["block"], "x<3")) == 2
    assert len(chosen(ours, None, "x<2")) == 1


def test_pictures_show_the_window(solved) -> None:
    local, result = solved
    figure = result.plot("contact_pressure", edges=False, scale=0.0, pixels=(200, 150))
    low, high = figure.axes[1].get_ylim()
    assert (low, high) == (0.0, result.contacts[0].max_pressure)
    result.plot("von_mises", edges=False, pixels=(200, 150))
    # the mesh alone knows nothing of the pressure
    assert solids_of_result(result)[0].scalar("contact_pressure").max() == 0.0
    assert local.name == "block"
