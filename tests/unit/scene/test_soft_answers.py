"""Answers of bodies at finite strain: estimates, accuracy, fields, files, the certificate, warnings."""

from __future__ import annotations

import numpy as np
import pytest

import fecontact as fc
from fecontact.results.geometry_error import geometry_error

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
