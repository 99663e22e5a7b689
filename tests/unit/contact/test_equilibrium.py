"""What is rounding among loads, motions and openings, and what is a load that nothing balances: from both sides."""

import numpy as np
import pytest
import refusals
import scipy.sparse as sp

import fecontact as fc
from fecontact import SupportError
from fecontact.contact.condensed_problem import check_balance, opening_by_motions
from fecontact.contact.loads import Loading, LoadStep
from fecontact.contact.rigid_motion import constrain_rigid_motion

STEEL = fc.Material(E=210e3, nu=0.3, density=2.0)
# of the side of the square on which legs stand
HALF = 0.5


class Legs:
    """Four legs of a rigid plate, each of which takes a force along z only."""

    infeasibility_hint = ""
    two_sided = False
    as_contact = None

    def __init__(self, body):
        self.body = body
        self.places = np.array([[x, y] for x in (-HALF, HALF) for y in (-HALF, HALF)])
        self.gap = np.zeros(4)

    def rows(self, body):
        if body is not self.body:
            return None
        x, y = self.places.T
        zero = np.zeros(4)
        return sp.csr_matrix(np.stack([zero, zero, zero + 1, y, -x, zero], axis=1))


def plate(name="plate"):
    return fc.RigidBody(fc.Plane(), name=name)


def tipped(aside, *others):
    """A plate pressed down at x = aside, free to tilt; others are not loaded."""
    body = plate()
    frame = constrain_rigid_motion(body, force=(0, 0, -1.0), moment=(0, aside, 0), free="z ry")
    return Legs(body), Loading(
        (frame, *(constrain_rigid_motion(b, free="z") for b in others)), (None,) * (1 + len(others))
    )


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_load_beyond_the_legs_is_refused_from_1e_8_on(sign):
    # the share that stays unbalanced is half of that by which the load stands beyond the legs
    for beyond in (0.0, 1.8e-8):
        legs, loading = tipped(sign * HALF * (1 + beyond))
        check_balance([legs], loading)
    legs, loading = tipped(sign * HALF * (1 + 2.2e-8))
    with refusals.refused(SupportError, "free-motion", "No contact forces can balance"):
        check_balance([legs], loading)


def test_only_bodies_that_move_are_named_and_only_loads_that_are_there_are_asked_for():
    resting = plate("resting")
    legs, loading = tipped(2 * HALF, resting)
    under = Legs(resting)
    with pytest.raises(SupportError) as caught:
        check_balance([legs, under], loading)
    assert "plate: " in str(caught.value)
    assert "resting" not in str(caught.value)
    # what has no load, or nothing released, has nothing to balance
    still = constrain_rigid_motion(resting, free="z")
    check_balance([under], Loading((still,), (None,)))
    check_balance([under], Loading((constrain_rigid_motion(resting, motion={"z": -1.0}),), (None,)))


@pytest.mark.parametrize(("share", "named"), [(0.8e-6, False), (1.3e-6, True)])
def test_a_body_is_named_where_it_moves_by_more_than_1e_6_of_all(share, named):
    one, other = plate("one"), plate("other")
    frames = constrain_rigid_motion(one, force=(0, 0, 1.0)), constrain_rigid_motion(other, force=(0, 0, share))
    with pytest.raises(SupportError) as caught:
        check_balance([Legs(one), Legs(other)], Loading(frames, (None, None)))
    assert "one: translation" in str(caught.value)
    assert ("other: " in str(caught.value)) is named


def test_a_body_that_nothing_touches_is_refused():
    with refusals.refused(SupportError, "free-motion", "alone"):
        check_balance([Legs(plate())], Loading((constrain_rigid_motion(plate("alone"), force=(0, 0, -1.0)),), (None,)))


@pytest.mark.parametrize("length", [1e-9, 1.0, 1e9])
def test_what_no_row_sees_is_compared_with_the_others_in_whatever_unit(length):
    """Moments of the same size on a plate with legs, which carry its moment, and on one without."""
    standing, alone = plate("standing"), plate("alone")
    legs = Legs(standing)
    legs.places *= length
    tilt = constrain_rigid_motion(standing, moment=(0, length, 0), motion={"z": 0.0})
    check_balance([legs], Loading((tilt,), (None,)))
    with refusals.refused(SupportError, "free-motion", "alone:"):
        check_balance([legs], Loading((tilt, constrain_rigid_motion(alone, moment=(0, 0, length))), (None, None)))


@pytest.mark.parametrize(("share", "kept"), [(0.9e-12, False), (1.2e-12, True)])
def test_an_opening_is_rounding_up_to_its_share_of_the_largest(share, kept):
    rows, modes = sp.csr_matrix([[1.0, share]]), np.eye(2)
    # the row adds up to 1, and each mode moves by 1: the largest opening there could be
    found = opening_by_motions(rows, modes, 1e-12)
    assert abs(found[0, 0] - 1) < 1e-15
    assert (found[0, 1] != 0) == kept
    # in another unit of length and of the motions the same entries are rounding
    other = opening_by_motions(1e-3 * rows, 1e6 * modes, 1e-12)
    assert (other[0, 1] != 0) == kept


@pytest.mark.parametrize(("share", "kept"), [(1.3e-12, False), (1.5e-12, True)])
def test_a_combination_of_motions_that_opens_nothing_but_rounding_opens_nothing(share, kept):
    # two motions that open two rows alike but for 4 shares: over the row's sum of 2 the smaller singular value is one
    # share, and rounding is told by the root of the number of rows
    rows = sp.csr_matrix(np.array([[1.0, 1.0], [1.0, 1.0 + 4 * share]]))
    singular = np.linalg.svd(opening_by_motions(rows, np.eye(2), 1e-12))[1]
    assert abs(singular[0] - 2) < 1e-9
    assert (singular[1] > 1e-13) == kept
    assert kept or singular[1] < 1e-15


def test_nothing_is_rounding_where_nothing_opens():
    none = opening_by_motions(sp.csr_matrix((0, 3)), np.eye(3), 1e-12)
    assert none.shape == (0, 3)
    assert not opening_by_motions(sp.csr_matrix((2, 3)), np.eye(3), 1e-12).any()


def test_what_is_rounding_grows_with_the_coordinates_of_a_mesh():
    def rounding(far):
        mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)).translated((far, 0.0, 0.0))
        body = fc.ElasticBody(mesh, STEEL, "top", {"bottom": "xyz"})
        return LoadStep().on([body]).rounding * body.size

    body_size = rounding(0.0) / 1e-12
    assert abs(body_size - fc.ElasticBody(fc.shapes.block((1, 1, 1), (1, 1, 1)), STEEL, "top", {}).size) < 1e-9
    # a hundred last digits of the largest coordinate
    assert abs(rounding(1e6) / (100 * np.finfo(float).eps * (1e6 + 1)) - 1) < 1e-9


class Slopes(Legs):
    """Points whose directions lean along x by a slope to both sides, with a share of it along y."""

    def __init__(self, body, slope, share):
        super().__init__(body)
        x = slope * np.array([-1.0, 1.0, -1.0, 1.0])
        self.normals = np.stack([x, share * x, np.ones(4), *np.zeros((3, 4))], axis=1)

    def rows(self, body):
        return sp.csr_matrix(self.normals) if body is self.body else None


@pytest.mark.parametrize(("slope", "share", "refused"), [(1.0, 9e-5, False), (1.0, 1.1e-4, True), (0.01, 1e-3, False),
                                                         (0.01, 1.2e-3, True)])  # fmt: skip
def test_a_load_along_what_nothing_resists_counts_beyond_what_directions_are_known_to(slope, share, refused):
    """A load of 0.1 to 1 along x and down: of it 0.1 share lies along the axis that no point resists.

    Directions are known to 1e-6: at a slope of 0.01 the axis that nothing resists is known to 1e-4.
    """
    body = plate()
    loading = Loading((constrain_rigid_motion(body, force=(0.1, 0.0, -1.0)),), (None,))
    if not refused:
        return check_balance([Slopes(body, slope, share)], loading)
    with refusals.refused(SupportError, "free-motion", "plate: translation along y"):
        check_balance([Slopes(body, slope, share)], loading)


@pytest.mark.parametrize(("share", "works"), [(0.8e-12, False), (1.3e-12, True)])
def test_work_of_loads_that_cancel_is_rounding_up_to_its_share_of_their_sizes(share, works):
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), STEEL, "top", {"bottom": "xyz"})
    frame = constrain_rigid_motion(body, free="x")
    nodal = np.zeros(body.n_dofs)
    nodal[0], nodal[3] = 1.0, -1.0 + 2 * share
    work = Loading((frame,), (nodal,)).driving(0, frame.free)
    # the sizes of both forces add up to 2
    assert (work[0] != 0) == works
    held = Loading((constrain_rigid_motion(body, force=(share, 0, 1.0), free="x"),), (None,))
    along = np.eye(6)[:, [0]]
    assert (held.driving(0, along)[0] != 0) == works


def floating(turn):
    """A block that floats along its x only, turned by a small angle about y."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    body = fc.ElasticBody(mesh, STEEL, "top", {"bottom": "yz", "y_min": "y"})
    return body.placed(rotation=fc.rotation_about((0, 1, 0), turn))


def test_directions_are_one_up_to_1e_8():
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), STEEL, "top", {"bottom": "xyz"})
    for slant, number in ((0.8e-8, 1), (1.3e-8, 2)):
        # a force along x but for a slant, and x itself
        assert constrain_rigid_motion(body, force=(1.0, slant, 0.0), free="x").free.shape == (6, number)
    for turn, released, mean_held in ((0.8e-8, 1, 0), (1.3e-8, 0, 1)):
        # a floating direction across a prescribed one but for a turn of the body
        frame = constrain_rigid_motion(floating(turn), motion={"z": 0.1})
        assert (frame.free.shape[1], frame.mean_held.shape[1]) == (released, mean_held)
        # and a load along x beside it releases x; what is left of the floating direction is held
        loaded = constrain_rigid_motion(floating(turn), force=(1.0, 0.0, 0.0), motion={"z": 0.1})
        assert loaded.free.shape[1] == 1
        assert loaded.mean_held.shape[1] == mean_held


@pytest.mark.parametrize(("share", "spread"), [(0.8e-9, False), (1.3e-9, True)])
def test_a_load_is_spread_where_it_works_on_what_floats_by_more_than_1e_9(share, spread):
    body = floating(0.0)
    assert body.free_motions.shape == (6, 1)
    for size in (1e-6, 1.0, 1e6):
        assert constrain_rigid_motion(body, force=(size * share, size, 0.0)).spread is spread
    assert not constrain_rigid_motion(body).spread
