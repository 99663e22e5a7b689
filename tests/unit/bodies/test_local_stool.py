"""A plate on three round feet: statics tells the forces, and large windows are solved together."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.bodies.local import body as local_body

MATERIAL = fc.Material(E=1000.0, nu=0.3)
FEET = np.array([(1.0, 1.0, 0.0), (5.0, 1.2, 0.0), (2.5, 4.0, 0.0)])
AT, FORCE = np.array([2.25, 15 / 7, 1.5]), 3.0


@pytest.fixture(scope="module")
def plate() -> fc.ElasticBody:
    return fc.ElasticBody(fc.shapes.block((6.0, 5.0, 1.5), (8, 7, 3)), MATERIAL, name="plate")


def standing(plate: fc.ElasticBody, cells: int, **options) -> fc.ContactResult:
    """The floating plate under a force at a node of its upper side."""
    stool = fc.WindowedBody(*(fc.LocalBody(plate, foot, 0.8, (cells, cells)) for foot in FEET))
    over = fc.rotation_about((1, 0, 0), np.pi)
    feet = [fc.RigidBody(fc.Sphere(4.0), pose=fc.Pose(over, foot), name=f"foot {foot[0]}") for foot in FEET]
    contacts = [fc.Contact(stool, f, surfaces=(w, "surface")) for f, w in zip(feet, stool.contact, strict=True)]
    load = {(stool, tuple(AT)): (0.0, 0.0, -FORCE)}
    result = fc.Scene([stool, *feet], contacts).solve(
        forces=load, free={stool: "z rx ry"}, finite_motion=False, **options
    )
    assert result.residuals().worst < 1e-8
    return result


@pytest.fixture(scope="module")
def large(plate: fc.ElasticBody) -> fc.ContactResult:
    """With 3 x 1600 cells."""
    return standing(plate, 40)


@pytest.mark.full
def test_the_feet_carry_what_statics_says(large: fc.ContactResult) -> None:
    """Balance of forces and of moments about their points of action, to the tolerance of the solution."""
    forces = np.array([contact.force[2] for contact in large.contacts])
    centres = np.array([c.forces @ c.points / c.forces.sum() for c in large.contacts])
    assert forces.sum() == pytest.approx(FORCE, rel=1e-9)
    np.testing.assert_allclose(forces @ centres[:, :2], FORCE * AT[:2], rtol=1e-8)
    # the plate inclines, so that it is not borne quite at the tops of the feet
    tops = np.linalg.solve(np.vstack([np.ones(3), FEET[:, :2].T]), FORCE * np.array([1.0, *AT[:2]]))
    np.testing.assert_allclose(forces, tops, rtol=3e-3)


@pytest.mark.full
def test_large_windows_are_solved_together(plate: fc.ElasticBody, large: fc.ContactResult, monkeypatch) -> None:
    """By active sets on all windows, as by projected conjugate gradients with products alone."""
    assert large.solution.solver == "joint-grids"
    monkeypatch.setattr(local_body, "DENSE_LIMIT", 100)
    ours, plain = standing(plate, 14), standing(plate, 14, solver="projected-cg")
    assert (ours.solution.solver, plain.solution.solver) == ("joint-grids", "projected-cg")
    for one, other in zip(ours.contacts, plain.contacts, strict=True):
        np.testing.assert_allclose(one.pressure, other.pressure, rtol=0, atol=1e-6 * other.pressure.max())
