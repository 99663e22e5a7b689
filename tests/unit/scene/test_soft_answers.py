"""Answers of bodies at finite strain: estimates, accuracy, fields, files, the certificate, warnings."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import meshio
import numpy as np
import pytest

import fecontact as fc
from fecontact.results.geometry_error import geometry_error
from fecontact.results.pictures.solids import solids_of_result
from fecontact.results.warnings import overlap_left
from tests.refusals import refused

SIDES = {"bottom": "z", "x_min": "x", "y_min": "y"}


def pressed(body, radius, **given):
    ball = fc.RigidBody(fc.Sphere(radius), name="ball").placed((0, 0, 1.0))
    key = "forces" if "force" in given else "motions"
    load = {ball: (0, 0, -given.pop("force"))} if key == "forces" else {ball: {"z": -given.pop("depth")}}
    return ball, fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(**{key: load}, **given)


def cylinder(material, n=6):
    mesh = fc.sections.rectangle((1.0, 1.0), (n, n))
    return fc.AxisymmetricBody(mesh, material, contact="top", supports={"bottom": "xz"}, name="rubber")


def cube(material):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 3), element="hex8")
    supports = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
    return fc.ElasticBody(mesh, material, contact="top", supports=supports, name="rubber")


@pytest.mark.parametrize("load", [{"depth": 8e-6}, {"force": 8e-7}], ids=["motion", "force"])
@pytest.mark.parametrize(("make", "nu"), [(cube, 0.3), (cylinder, 0.3), (cylinder, 0.49)])
def test_small_strains_have_the_estimates_of_linear_bodies(make, nu: float, load) -> None:
    """A different stress, energy and approach, and the same errors."""
    figures = []
    for material in (fc.Material(E=1.0, nu=nu), fc.NeoHookean(E=1.0, nu=nu)):
        result = pressed(make(material), 1e4, **load)[1]
        each, response = result.contacts[0].error_estimate, result.response_error
        figures.append([each.pressure, each.interior, response.force or response.approach])
        assert (response.force is None) == ("force" in load)
    assert min(figures[0]) > 0
    assert figures[1] == pytest.approx(figures[0], rel=1e-3)


@pytest.mark.parametrize("given", ["motion", "force"])
def test_estimates_at_finite_strain_are_of_the_size_of_the_errors(given: str) -> None:
    """A ball presses rubber by a third of its height: beside a mesh three times as fine."""
    law = fc.NeoHookean(E=1.0, nu=0.49)
    ball, fine = pressed(cylinder(law, 18), 1.0, depth=0.3)
    load = {"depth": 0.3} if given == "motion" else {"force": abs(fine.contacts[0].force[2])}
    own, result = pressed(cylinder(law), 1.0, **load)
    exact, found = fine.contacts[0], result.contacts[0]
    (x, p, dA), (x_fine, p_fine, _) = (c.sampled(c.pressure, 8) for c in (found, exact))
    order = np.argsort(x_fine[:, 0])
    wanted = np.interp(x[:, 0], x_fine[order, 0], p_fine[order])
    of_pressure = np.sqrt(dA @ (p - wanted) ** 2 / (dA @ wanted**2))
    off = found.total_force / exact.total_force - 1 if given == "motion" else None
    if off is None:
        off = 1 - result.rigid_motion(own).translation[2] / fine.rigid_motion(ball).translation[2]
    estimate, response = found.error_estimate, result.response_error
    assert 0.7 < estimate.pressure / of_pressure < 3
    assert 0.7 < estimate.peak / abs(found.max_pressure / exact.max_pressure - 1) < 3
    assert 0.7 < (response.force or response.approach) / off < 3
    assert not result._response_errors.reason


def test_bent_faces_are_no_error_of_the_shape() -> None:
    """A flat face stays one however deep the ball; chords of a round face count as at rest."""
    law = fc.NeoHookean(E=1.0, nu=0.3)
    assert pressed(cube(law), 1.0, depth=0.2)[1].contacts[0].error_estimate.geometry == 0
    mesh = fc.shapes.thick_ring(1.0, 2.0, 0.5, (8, 2, 1), sector="half", element="hex8")
    found = []
    for material in (law, law.at_rest):
        supports = {"inner": "xyz", "bottom": "z", "top": "z"}
        ring = fc.ElasticBody(mesh, material, contact="outer", supports=supports, geometry="plain")
        turn = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
        floor = fc.RigidBody(fc.Plane()).placed(rotation=turn).placed((-2.0, 0, 0))
        result = fc.Scene([ring, floor], [fc.Contact(ring, floor)]).solve(motions={floor: {"x": 0.1}})
        found.append(geometry_error(result.contacts[0]))
    assert found[0] == pytest.approx(found[1], rel=0.2)


def test_an_accuracy_is_reached() -> None:
    law = fc.NeoHookean(E=1.0, nu=0.45)
    exact = pressed(cylinder(law, 18), 1.0, depth=0.3)[1].contacts[0]
    body = cylinder(law)
    ball, result = pressed(body, 1.0, depth=0.3, accuracy={"force": 0.01, "pressure": 0.05})
    contact, convergence = result.contacts[0], result.convergence
    assert convergence.met
    assert len(convergence.steps) > 1
    assert convergence.steps[-1].n_hanging > 0
    assert contact.total_force == pytest.approx(exact.total_force, rel=0.01)
    assert result.rigid_motion(ball).translation[2] == pytest.approx(-0.3)
    assert len(result.displacement(body)) > len(body.mesh.points)
    assert result.residuals().worst < 1e-7


def test_divided_cells_pass_the_patch_test() -> None:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    law = fc.NeoHookean(E=2.0, nu=0.4)
    body = fc.ElasticBody(mesh, law, contact="top", supports=SIDES, name="block")._divided({}, np.array([7]))
    assert body.mesh.hanging is not None
    plate = fc.RigidBody(fc.Plane()).placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    result = fc.Scene([body, plate], [fc.Contact(body, plate)]).solve(motions={plate: {"z": -0.3}})
    u = result.displacement(body)
    across = float(u[:, 0].max())
    stress = law.cauchy(np.diag([1 + across, 1 + across, 0.7])).diagonal()
    assert abs(stress[0]) < 1e-8
    assert np.abs(u - body.mesh.points * [across, across, -0.3]).max() < 1e-9
    assert np.abs(result.contacts[0].pressure / -stress[2] - 1).max() < 1e-7


@pytest.fixture(scope="module")
def between():
    """A soft block with friction between a linear one and a plate."""
    law = fc.NeoHookean(E=1.0, nu=0.3)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    wide = fc.shapes.block((2.0, 2.0, 1.0), (3, 3, 2), element="hex8")
    base = fc.ElasticBody(wide, fc.Material(E=40.0, nu=0.3), "top", {"bottom": "xyz"}, name="base")
    held = {"x_min": "x", "y_min": "y"}
    pad = fc.ElasticBody(mesh, law, contact=("top", "bottom"), supports=held, name="pad").placed((0, 0, 1.0))
    plate = fc.RigidBody(fc.Plane()).placed((0, 0, -2.0)).placed(rotation=np.diag([1.0, -1, -1]))
    contacts = [fc.Contact(pad, base, ("bottom", "top"), friction=0.1), fc.Contact(pad, plate, ("top", "surface"))]
    return base, pad, fc.Scene([base, pad, plate], contacts).solve(motions={plate: {"z": -0.2}})


def test_the_certificate_is_of_the_whole_state(between) -> None:
    """Forces and displacements off by a share of the whole, not of the last change, leave about as much."""
    _, _, result = between
    clean = result.residuals()
    assert clean.worst < 1e-7
    part = 1e-3
    friction = result.friction
    start = np.cumsum([0, *(len(c._candidates) for c in result.contacts)])
    for k in range(len(result.contacts)):
        forces = friction.forces.copy()
        forces[start[k] : start[k + 1]] *= 1 + part
        found = replace(result, friction=replace(friction, forces=forces)).residuals()
        assert found.equilibrium > part / 20
    for k in range(2):
        moved = list(result._state.displacements)
        moved[k] = moved[k] * (1 + part) + (part * 0.1 * np.sin(np.arange(len(moved[k]))) if k else 0.0)
        found = replace(result, _state=replace(result._state, displacements=tuple(moved))).residuals()
        assert found.equilibrium > part / 20
    deep = result.contacts[1].gap.copy()
    deep[0] = -part * 0.2
    contacts = (result.contacts[0], replace(result.contacts[1], gap=deep))
    assert replace(result, contacts=contacts).residuals().penetration == pytest.approx(part, rel=0.2)


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("tension", lambda f, n: -0.01 * f.max() * (np.arange(len(f)) == 0)),
        ("penetration", lambda f, n: 0 * f * (np.arange(len(f)) < n)),
        ("cone", lambda f, n: np.where(np.arange(len(f)) < n, f, 2 * f)),
    ],
)
def test_the_certificate_sees_each_violation(between, name: str, change) -> None:
    result = between[2]
    n = len(result.solution.forces)
    forces = change(result.friction.forces, n)
    found = replace(result, friction=replace(result.friction, forces=forces)).residuals().as_dict()
    assert found[name] > 1e-3 > 1e2 * result.residuals().as_dict()[name]


def test_a_soft_partner_does_not_hide_the_strain_of_a_linear_body(between) -> None:
    base, _, result = between
    assert not [text for text in result.warnings if "small-strain" in text]
    soft = replace(base, material=fc.Material(E=2.0, nu=0.3))
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    law = fc.NeoHookean(E=1.0, nu=0.3)
    pad = fc.ElasticBody(mesh, law, "bottom", {"top": "z", "x_min": "x", "y_min": "y"}, name="pad").placed((0, 0, 1.0))
    strained = fc.Scene([pad, soft], [fc.Contact(pad, soft)]).solve(motions={pad: {"z": -0.3}})
    (text,) = [text for text in strained.warnings if "small-strain" in text]
    assert text.startswith("'base'")


@pytest.fixture(scope="module")
def bulged():
    """A tilted block with a glued bottom, pressed by a fifth; the plate's coordinate along the block's axis."""
    turn = fc.rotation_about((1.0, 2.0, 0.5), 0.7)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element="hex8")
    law = fc.NeoHookean(E=2.0, nu=0.4)
    body = fc.ElasticBody(mesh, law, contact="top", supports={"bottom": "xyz"}, name="block").placed(rotation=turn)
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    plate = plate.placed(rotation=turn)
    down = dict(zip("xyz", turn @ [0, 0, -0.2], strict=True))
    return body, turn, fc.Scene([body, plate], [fc.Contact(body, plate)]).solve(motions={plate: down})


def test_fields_are_asked_by_points_before_the_deformation(bulged) -> None:
    body, turn, result = bulged
    points = body.mesh.points
    u, stress = result.fields_at(body, points)
    assert np.abs(u - result.displacement(body)).max() < 1e-12
    assert np.abs(stress - result.stress(body)).max() < 1e-12
    top = body.mesh.boundary_nodes("top")
    assert np.abs((u @ turn)[top, 2] + 0.2).max() < 1e-8
    x = points + u @ turn
    outside = x[np.argmax(x[:, 0])]
    assert outside[0] > 1.02
    with refused(fc.InputError, "points-outside-body", "before its deformation"):
        result.fields_at(body, [outside])


def test_files_and_pictures_show_the_deformed_body(bulged, tmp_path) -> None:
    """One place, displacement, stress and pressure of each node in VTU, CSV, JSON and the drawn body."""
    body, turn, result = bulged
    contact = result.contacts[0]
    place = body.mesh.points @ turn.T + result.displacement(body)
    saved = meshio.read(result.save(tmp_path / "soft.vtu"))
    assert np.abs(saved.points - place).max() < 1e-9
    assert np.abs(saved.point_data["displacement"] - result.displacement(body)).max() < 1e-9
    assert np.abs(saved.point_data["stress"] - result.stress(body)).max() < 1e-9
    assert saved.point_data["contact_pressure"].max() == pytest.approx(contact.max_pressure)
    (solid,) = solids_of_result(result)
    assert np.abs(solid.deformed(1.0) - place).max() < 1e-9
    assert np.abs(solid.deformed(0.0) - body.mesh.points @ turn.T).max() < 1e-12
    assert np.abs(solid.fields["contact_pressure"] - saved.point_data["contact_pressure"]).max() < 1e-9
    top = body.mesh.boundary_nodes("top")
    rows = list(csv.DictReader(result.save(tmp_path / "soft.csv").open()))
    listed = np.array([[float(row[name]) for name in "xyz"] for row in rows])
    nearest = np.linalg.norm(listed[:, None] - place[None, top], axis=2).argmin(axis=1)
    assert np.abs(listed - place[top[nearest]]).max() < 1e-8
    pressures = [float(row["pressure"]) for row in rows]
    assert pressures == pytest.approx(saved.point_data["contact_pressure"][top[nearest]])
    told = json.loads(result.save(tmp_path / "soft.json").read_text())
    assert [step["iterations"] for step in told["finite_strain"]] == [s.iterations for s in result.finite_strain]
    assert "finite strain: 1 load step(s)" in str(result)
    # the mean of the present points by their forces
    middle = contact.forces @ listed / contact.total_force
    assert np.abs(contact.centre_of_pressure - middle).max() < 1e-12


def test_the_deflection_of_a_soft_body_is_no_overlap() -> None:
    """A bulge touches a coarse linear face between its nodes, by 2 % of what the soft body yields."""

    def bulge(x):
        return x + np.outer(0.4 * x[:, 0] ** 2 * (1 - x[:, 2]), [0.0, 0.0, 1.0])

    upper = fc.sections.rectangle((2.0, 1.0), (10, 4)).translated((-1, 0, 0)).mapped(bulge)
    lower = fc.sections.rectangle((4.0, 1.0), (11, 3)).translated((-2.1, 0, -1))
    soft = fc.PlaneBody(upper, fc.NeoHookean(E=1.0, nu=0.3), "bottom", {"top": "xz"}, name="soft")
    base = fc.PlaneBody(lower, fc.Material(30.0, 0.3), "top", {"bottom": "xz"}, name="base")
    result = fc.Scene([soft, base], [fc.Contact(soft, base)]).solve(motions={soft: {"z": -0.05}})
    assert list(overlap_left(result)) == []


def test_a_floating_soft_body_moves_by_its_mean() -> None:
    law = fc.NeoHookean(E=1.0, nu=0.3)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    body = fc.ElasticBody(mesh, law, contact=("top", "bottom"), supports={"x_min": "x", "y_min": "y"}, name="block")
    upper = fc.RigidBody(fc.Plane(), name="upper").placed((0, 0, -1.0)).placed(rotation=np.diag([1.0, -1, -1]))
    lower = fc.RigidBody(fc.Plane(), name="lower")
    contacts = [fc.Contact(body, upper, ("top", "surface")), fc.Contact(body, lower, ("bottom", "surface"))]
    result = fc.Scene([body, upper, lower], contacts).solve(motions={upper: {"z": -0.3}, lower: {"z": 0.1}})
    assert result.rigid_motion(body).translation == pytest.approx([0, 0, -0.1], abs=1e-9)
    assert result.displacement(body)[:, 2].mean() == pytest.approx(-0.1, abs=1e-9)
    assert result.rigid_motion(lower).translation == pytest.approx([0, 0, 0.1])
