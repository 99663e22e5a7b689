"""What a result says of itself: violations outside the condensed problem are reported with their size."""

from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact.solvers import Residuals

# what is left of a solved problem of a few points, far below every violation made here
ROUNDING = 1e-10


@pytest.fixture(scope="module")
def pressed():
    """A block pressed on a floor, by its nodes and by a motion that is its largest displacement."""
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), fc.Material(E=1000.0, nu=0.3), "bottom",
                          {"top": "xyz"}, name="block")  # fmt: skip
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    return scene.solve(motions={body: {"z": -0.01}})


def with_gap(result, depth):
    """The result with its first point so deep in the floor, and the others open."""
    gap = np.full(len(result.contacts[0].gap), 1.0)
    gap[0] = -depth
    return replace(result, contacts=(replace(result.contacts[0], gap=gap),))


@pytest.mark.parametrize("depth", [1e-9, 1e-4, 0.3])
def test_overlap_outside_the_problem_is_reported_by_the_largest_displacement(pressed, depth):
    clean = pressed.residuals()
    assert clean.worst < ROUNDING
    found = with_gap(pressed, depth).residuals()
    # pushed down by 0.01 at the top and held at the bottom: the largest displacement is 0.01
    assert abs(pressed._state.scale / 0.01 - 1) < 1e-9
    assert abs(found.penetration / (depth / pressed._state.scale) - 1) < 1e-12
    assert replace(found, penetration=clean.penetration) == clean


def test_overlap_without_any_displacement_is_reported_as_it_is(pressed):
    still = replace(pressed, _state=replace(pressed._state, scale=0.0))
    assert abs(with_gap(still, 0.25).residuals().penetration / 0.25 - 1) < 1e-12


def test_the_larger_of_the_problems_penetration_and_that_outside_counts(pressed):
    # the problem's own: no forces, so that the whole approach of 0.01 is left; nothing deflects, and the floor of the
    # scale is a thousandth of the gaps
    idle = replace(pressed.solution, forces=np.zeros(pressed.solution.problem.n))
    found = with_gap(replace(pressed, solution=idle), 1e-3).residuals()
    assert abs(found.penetration / 1e3 - 1) < 1e-9
    assert found.equilibrium < ROUNDING


def test_open_gaps_and_a_scene_without_contacts_have_no_penetration(pressed):
    far = np.full(len(pressed.contacts[0].gap), 2.0)
    apart = replace(pressed, contacts=(replace(pressed.contacts[0], gap=far),))
    assert apart.residuals().penetration == pressed.solution.residuals.penetration
    alone, solved = replace(pressed, contacts=()).residuals(), pressed.solution.residuals
    assert replace(alone, equilibrium=solved.equilibrium) == solved
    assert alone.equilibrium < 1e-12  # of the forces on all nodes, anew


@pytest.mark.parametrize("shift", [1e-9, 1e-3, 0.2])
def test_lines_of_action_that_do_not_meet_the_feet_are_reported_as_moments(pressed, shift):
    """All feet moved sideways: every force then turns the pair by force times shift."""
    interface = pressed._interfaces[0]
    projection = interface.pairing.projection
    aside = replace(projection, points=projection.points + np.array([shift, 0.0, 0.0]))
    moved = replace(interface, pairing=replace(interface.pairing, projection=aside))
    tampered = replace(pressed, _condensed=replace(pressed._condensed, interfaces=(moved,)))
    found, clean = tampered.residuals(), pressed.residuals()
    # relative to the forces times the size of the slave
    assert abs(found.equilibrium / (shift / interface.slave.size) - 1) < 1e-6
    assert replace(found, equilibrium=clean.equilibrium) == clean


def test_the_problems_own_equilibrium_is_not_lost_among_the_moments():
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), fc.Material(E=1000.0, nu=0.3), "bottom",
                          {"top": "xyz"}, name="block")  # fmt: skip
    floor = fc.RigidBody(fc.Plane(), name="floor")
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(forces={body: (0.0, 0.0, -4.0)})
    light = replace(result, solution=replace(result.solution, forces=0.5 * result.solution.forces))
    # half of the load is not carried: 2 over the forces, taken as the load of 4 where they are less, and the load
    assert abs(light.residuals().equilibrium / 0.25 - 1) < 1e-9
    none = replace(result, solution=replace(result.solution, forces=0.0 * result.solution.forces),
                   contacts=(replace(result.contacts[0], forces=0.0 * result.contacts[0].forces),))  # fmt: skip
    assert abs(none.residuals().equilibrium / 0.5 - 1) < 1e-9


def test_tension_and_complementarity_are_those_of_the_problem(pressed):
    forces = pressed.solution.forces.copy()
    forces[0] = -forces[0]
    wrong = replace(pressed, solution=replace(pressed.solution, forces=forces))
    own, whole = wrong.solution.residuals, wrong.residuals()
    assert isinstance(whole, Residuals)
    assert own.tension > 1e-3
    assert own.complementarity > 0.01
    assert (whole.tension, whole.complementarity) == (own.tension, own.complementarity)


def test_the_way_of_condensation_is_told_for_every_elastic_body(pressed):
    assert list(pressed.condensation) == ["block"]
    route, why = pressed.condensation["block"].split(": ", 1)
    assert route
    assert why
    floor = fc.RigidBody(fc.Plane())
    idle = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), fc.Material(E=1.0, nu=0.3), "bottom",
                          {"top": "xyz"}, name="idle").placed((0.0, 0.0, 5.0))  # fmt: skip
    touching = pressed.scene.bodies[0]
    scene = fc.Scene([touching, floor, idle], [fc.Contact(touching, floor)])
    assert list(scene.solve(motions={touching: {"z": -0.01}}).condensation) == ["block", "idle"]


@pytest.mark.parametrize(("strain", "warned"), [(0.0499, False), (0.0501, True)])
def test_strains_are_warned_of_beyond_five_percent(strain, warned):
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 2.0), (1, 1, 1)), fc.Material(E=1.0, nu=0.0), "bottom",
                          {"top": "xyz"}, name="block")  # fmt: skip
    floor = fc.RigidBody(fc.Plane())
    # without lateral strain the column is strained by the motion over its height
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -2 * strain}})
    assert any("'block' is strained by 5.0 %" in text for text in result.warnings) is warned
