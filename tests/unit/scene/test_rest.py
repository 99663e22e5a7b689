"""Results in which a body has found no rest: a motion that slight slopes, corners of facets or rounding resist."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import SupportError
from fecontact.scene.finite_rotation import MAX_SHIFT, MAX_TURN, check_rest

STEEL = fc.Material(E=210e3, nu=0.3)


def lug_on_a_pin(around, outer):
    """A ring held outside on a ring held inside, with polygonal surfaces turned against each other."""
    lug = fc.ElasticBody(
        fc.shapes.thick_ring(1, 2, 0.5, (8, 2, 1), sector="full"), STEEL, "inner", {"outer": "xyz"}, name="lug"
    )
    pin = fc.ElasticBody(
        fc.shapes.thick_ring(0.3, outer, 0.5, (around, 2, 1), sector="full"), STEEL, "outer", {"inner": "xyz"}
    ).placed(rotation=fc.rotation_about((0, 0, 1), 0.1))
    return lug, fc.Scene([lug, pin], [fc.Contact(lug, pin)])


def test_a_lug_that_only_facets_keep_from_turning_is_refused():
    lug, scene = lug_on_a_pin(6, 0.99)
    case = {"forces": {(lug, (2.0, 0.0, 0.25)): (0.0, -1.0, 0.0)}, "free": {lug: "x y rz"}, "finite_motion": False}
    # by statics where lines of action are radial, else by the motion found: the motion is named either way
    with refused(SupportError, "free-motion", "lug: rotation about z through"):
        scene.solve(**case)
    with refused(SupportError, "free-motion", "lug: rotation about z through"):
        scene.sweep([case])
    # held in the turn, it is at rest
    held = scene.solve(**{**case, "free": {lug: "x y"}})
    assert abs(held.contacts[0].force[1]) == pytest.approx(1.0, rel=1e-9)


@pytest.fixture(scope="module")
def at_rest():
    block = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), STEEL, "bottom", name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(forces={block: (0, 0, -1.0)})


def adrift(result, motion):
    """The result with its first body moved further, and no more strained."""
    motion, first = np.array(motion, dtype=float), result._state.motions[0]
    moved = result._state.displacements[0] + result._loading.frames[0].modes((motion - first)[:, None])[:, 0]
    state = replace(result._state, motions=(motion, np.zeros(6)), displacements=(moved, np.zeros(6)))
    return replace(result, _state=state)


def test_no_rest_is_said_from_one_radian_and_a_thousand_bodies_on(at_rest):
    # known violations just within and just beyond, with their size in the message
    known = np.sqrt(3.0)  # the block's diagonal; all gaps are zero
    assert check_rest(at_rest) is at_rest
    for share, wrong in ((0.99, False), (1.01, True)):
        for motion, words in (
            ([0, 0, 0, 0, share * MAX_TURN, 0], ("block: rotation about y", f", by {share:.3g} rad")),
            (
                [share * MAX_SHIFT * known, 0, 0, 0, 0, 0],
                ("block: translation along x", f", by {share * 1732.05:.3g}"),
            ),
        ):
            if wrong:
                with refused(SupportError, "no-rest", *words):
                    check_rest(adrift(at_rest, motion))
            else:
                check_rest(adrift(at_rest, motion))


def test_a_long_fall_is_a_rest():
    # what stops a body may be far away: the gap counts
    block = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), STEEL, "bottom", name="block")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    high = block.placed((0, 0, 1e5))
    result = fc.Scene([high, floor], [fc.Contact(high, floor)]).solve(forces={high: (0, 0, -1.0)}, finite_motion=False)
    assert result.contacts[0].total_force == pytest.approx(1.0, rel=1e-9)
