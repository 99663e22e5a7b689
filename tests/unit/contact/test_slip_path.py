"""Paths of contact points during a step and the time at which they touch, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import Pose, rotation_about
from fecontact.contact.friction_rows import screw_paths, touching_points


def test_a_screw_ends_where_it_should_and_is_one_in_every_frame() -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(5, 3))
    start = Pose(rotation_about(rng.normal(size=3), 0.7), rng.normal(size=3))
    end = start.then(rotation_about(rng.normal(size=3), 1.9), rng.normal(size=3))
    path = screw_paths(points, start, end)
    np.testing.assert_allclose(path[[0, -1]], [start.to_world(points), end.to_world(points)], atol=1e-14)
    turn, shift = rotation_about((1.0, 2.0, -1.0), 1.1), np.array([3.0, -1.0, 2.0])
    other = screw_paths(points, start.then(turn, shift), end.then(turn, shift))
    np.testing.assert_allclose(other, path @ turn.T + shift, atol=1e-13)
    # a screw has a constant rate: equal chords from one time to the next
    chords = np.linalg.norm(np.diff(path, axis=0), axis=2)
    np.testing.assert_allclose(chords, chords[:1].repeat(len(chords), axis=0), rtol=1e-10)


def test_an_open_point_slips_from_where_it_touches() -> None:
    """Points over a plane, moved by (1, 0, -0.2): from a gap of 0.05 one touches after a quarter of the way."""
    paths = screw_paths(np.array([[0.0, 0, 0.05]] * 3 + [[0.0, 0, 0.5]]), Pose(), Pose(np.eye(3), [1.0, 0.0, -0.2]))
    normals, pressed = np.tile([0.0, 0.0, 1.0], (4, 1)), np.array([False, True, False, False])
    gaps = paths[-1, :, 2] + np.array([0.0, 0.0, -0.05, 0.0])  # the third is displaced onto the plane before
    found = touching_points(paths, gaps, normals, pressed)[:, 0]
    np.testing.assert_allclose(found, [0.25, 0.0, 0.0, 1.0], atol=1e-12)
    # along the plane at a gap of rounding: from the start
    along = screw_paths(np.array([[0.0, 0, 1e-17]]), Pose(), Pose(np.eye(3), [1.0, 0.0, 0.0]))
    assert touching_points(along, np.array([1e-17]), normals[:1], pressed[:1])[0, 0] < 1e-12


@pytest.mark.parametrize("n_steps", [1, 4])
def test_rolling_by_many_widths_is_no_slip(n_steps: int) -> None:
    """A rigid roller turned by 0.8 rad, ten widths of its contact, while it goes on by its arc.

    Sliding it by the same way takes mu P. Some friction is left: the first step slips at the rims of the contact while
    it is pressed in.
    """
    mesh = fc.sections.rectangle((3.0, 0.5), (60, 4)).translated((-1.0, 0.0, -0.5))
    pad = fc.PlaneBody(mesh, fc.Material(E=1.0, nu=0.49), "top", {"bottom": "xz"}, name="pad")
    roller = fc.RigidBody(fc.surfaces.Cylinder(1.0), name="roller")
    scene = fc.Scene([pad, roller], [fc.Contact(pad, roller, friction=0.3)])

    def step(turn: float, way: float) -> dict[str, object]:
        lowest = np.array([way, 0.0, 0.998]) - rotation_about((0, 1, 0), turn)[:, 2]
        return {"motions": {roller: {"x": lowest[0], "z": lowest[2], "ry": turn}}}

    turns = np.linspace(0.0, 0.8, n_steps + 1)
    rolled = scene.solve_path([step(a, a) for a in turns], finite_motion=True)
    slid = scene.solve_path([step(0.0, a) for a in turns], finite_motion=True)
    shares = [
        abs(result.contacts[0].friction.force[0]) / (0.3 * result.contacts[0].total_force)
        for result in (*rolled.steps, slid[-1])
    ]
    assert max(shares[:-1]) < 0.2
    assert abs(shares[-1] - 1) < 1e-3  # normals of the contact lean by up to its half width over the radius
    assert rolled.friction_work[1:].max() < 2e-3 * slid.friction_work[1:].max()


@pytest.mark.by_day("13.0-None", "0.2-1")
@pytest.mark.parametrize(("turn", "cuts"), [(0.2, 1), (2 * np.pi, 32), (13.0, None)])
def test_spins_on_the_spot_are_cut(turn: float, cuts: int | None) -> None:
    """A block pressed on a floor and turned: the work of friction is its torque times the turn, of whole turns, too."""
    block = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 0.5), (1, 1, 1)).translated((-0.5, -0.5, 0.0)), fc.Material(E=1.0, nu=0.0), "bottom",
        {"top": "xyz"}, name="block",
    )  # fmt: skip
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.3)])
    steps = [{"motions": {block: {"z": -0.01, "rz": a}}} for a in (0.0, 0.5, 0.5 + turn)]
    if cuts is None:
        with refused(fc.SolverError, "not-solved", "Give smaller load steps"):
            scene.solve_path(steps, finite_motion=True)
        return
    path = scene.solve_path(steps, finite_motion=True)
    assert path.cuts[2] == cuts
    torque = abs(path[2].reaction(block)[5])
    assert abs(path.friction_work[2, 0] / (torque * turn) - 1) < 0.01
