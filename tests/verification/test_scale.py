"""Multigrid in place of a factorisation: the same answers, and steps that grow slowly."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError

pytest.importorskip("pyamg", reason="multigrid needs pyamg: pip install 'fecontact[amg]'")

#: Both are certified to 1e-10; forces have that times the condition of the compliance, some tens.
SAME = 1e-9


def pressed(backend, divisions=(6, 5, 4), element="hex20", supports=None, **loads):
    mesh = fc.shapes.block((2.0, 1.7, 1.0), divisions, element=element)
    held = {"bottom": "xyz"} if supports is None else supports
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", held, name="block", backend=backend)
    ball = fc.RigidBody(fc.Sphere(3.0), name="ball").placed(translation=(0.1, 0.05, 4.0))
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    return body, scene.solve(**(loads or {"forces": {ball: (0.0, 0.0, -0.02)}}))


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_multigrid_gives_the_answer_of_the_factor(element, row):
    """A ball on a block, multigrid in place of a factorisation.

    Source: the factorisation. Both are certified to 1e-10; forces have that times the condition of the compliance.
    """
    (a, direct), (b, found) = pressed("auto", element=element), pressed("amg", element=element)
    assert found.solution.solver == "multigrid"
    assert found.condensation["block"].startswith("operator: multigrid")
    forces = [r.contacts[0].forces for r in (direct, found)]
    error = np.abs(forces[1] - forces[0]).max() / forces[0].max()
    row(f"ball on a block, {element}, multigrid", "largest force against the factor's", 0.0, error, SAME, b.n_dofs)
    u, v = direct.displacement(a), found.displacement(b)
    assert np.abs(u - v).max() < SAME * np.abs(u).max()


@pytest.mark.parametrize(
    ("case", "supports", "motion"),
    [
        ("prescribed motion and weight", {"top": "xyz"}, {"z": -0.01}),
        ("floating body", {}, {"x": 0.0, "y": 0.0, "rz": 0.0}),
    ],
)
def test_motions_and_weight(case, supports, motion, row):
    """Prescribed motion and weight, and a floating body, multigrid in place of a factorisation.

    Source: the factorisation. Certified to 1e-10, times the condition of the compliance.
    """
    results = []
    for backend in ("auto", "amg"):
        mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3))
        body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3, 1.0), "bottom", supports, backend=backend)
        floor = fc.RigidBody(fc.Plane())
        scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
        results.append(scene.solve(motions={body: motion}, gravity=(0.0, 0.0, -0.02)).contacts[0].forces)
    error = np.abs(results[1] - results[0]).max() / results[0].max()
    row(f"{case}, multigrid", "largest force against the factor's", 0.0, error, SAME)


def steps_of_one_solve(divisions, element):
    """Steps of multigrid for a random load."""
    body, _ = pressed("amg", divisions, element)
    factor = body.model.condensation.factor
    before = factor.steps
    factor.solve_one(np.random.default_rng(5).standard_normal(len(body.model.solved_dofs)))
    return factor.steps - before


@pytest.mark.by_day("hex8-divisions0")
@pytest.mark.parametrize(("element", "divisions"), [("hex8", (6, 6, 4)), ("hex20", (4, 4, 3))])
def test_steps_grow_less_than_without_multigrid(element, divisions, row):
    """Steps of multigrid with elements half as wide.

    Source: conjugate gradients by themselves take twice the steps; fewer is asserted.
    """
    steps = [steps_of_one_solve(tuple(times * n for n in divisions), element) for times in (1, 2)]
    ratio = steps[1] / steps[0]
    row(f"random load, {element}, multigrid", "steps with elements half as wide over steps", 1.0, ratio)
    assert ratio < 1.5


def test_elements_with_midside_nodes_take_few_steps(row):
    """Steps of 20-node elements with the corners as a level of their own, against those of 8-node elements.

    Source: on the corners both are alike; aggregates of all nodes take three times the steps.
    """
    steps = [steps_of_one_solve((8, 7, 5), element) for element in ("hex8", "hex20")]
    ratio = steps[1] / steps[0]
    row("random load, multigrid", "steps of 20-node over those of 8-node elements", 1.0, ratio)
    assert ratio < 2.0


def test_multigrid_has_no_schur_complement():
    """Multigrid has no Schur complement and says so. Source: the message."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "bottom", {"top": "xyz"}, backend="amg", condensation="schur")
    floor = fc.RigidBody(fc.Plane())
    with refused(InputError, "input", "products only"):
        fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})


def _two_blocks(backend, springs=False):
    mesh, material = fc.shapes.block((1.0, 1.0, 0.6), (3, 3, 2)), fc.Material(1.0, 0.3)
    other = fc.shapes.block((1.0, 1.0, 0.6), (4, 4, 2))
    lower = fc.ElasticBody(mesh, material, "top", {"bottom": "xyz"}, name="lower", backend=backend)
    upper = fc.ElasticBody(other, material, "bottom", {"top": "xyz"}, name="upper", backend=backend)
    upper = upper.placed(translation=(0.0, 0.0, 0.6))
    pulled = other.points[0]
    ties = (
        [fc.Spring(0.05, (upper, pulled), (None, pulled + np.array([0.0, 0.0, 2.0])), slack_length=1.0)]
        if springs
        else []
    )
    scene = fc.Scene([lower, upper], [fc.Contact(upper, lower)], springs=ties)
    return scene.solve(motions={upper: {"z": -0.01, "rx": 0.005}})


@pytest.mark.by_day("False")
@pytest.mark.parametrize("springs", [False, True])
def test_two_elastic_bodies(springs, row):
    """Two elastic blocks that do not match, both with multigrid.

    Source: the factorisation. With springs there is no solver for the sum, and projected conjugate gradients take over.
    """
    direct, found = (_two_blocks(backend, springs) for backend in ("auto", "amg"))
    assert found.solution.solver == ("projected-cg" if springs else "multigrid")
    a, b = (result.contacts[0].forces for result in (direct, found))
    error = np.abs(b - a).max() / a.max()
    what = "two blocks and a spring, multigrid" if springs else "two blocks, multigrid"
    row(what, "largest force against the factor's", 0.0, error, SAME)
