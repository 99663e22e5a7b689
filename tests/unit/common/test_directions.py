"""Names of directions: given ones, the axes of the world, and what is refused."""

import numpy as np
import pytest
from refusals import refused

from fecontact import InputError
from fecontact.common.directions import WORLD, Directions


def test_without_names_they_are_the_axes_of_the_world():
    assert Directions.of(None) is Directions.of({}) is WORLD
    assert [WORLD.name(v) for v in np.eye(3)] == ["x", "y", "z"]
    assert WORLD.name(np.array([0.6, 0.0, 0.8])) == "(0.60, 0.00, 0.80)"  # no coordinate of the world


def test_names_hold_for_what_is_nearer_to_them_than_to_others():
    knee = Directions.of({"lateral": (2, 0, 0), "anterior": (0, 1, 0), "proximal": (0, 0, 5)})
    assert knee.name(np.array([0.6, 0.0, 0.8])) == "proximal"
    assert knee.name(np.array([0.0, -1.0, 0.0])) == "-anterior"
    assert knee.name(np.ones(3) / np.sqrt(3)) == "(0.58, 0.58, 0.58)"


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_axes_of_a_plane_are_the_directions_along_it(turn):
    """Of a frame turned about x by an angle: across its normal they are x, and y turned with it."""
    about = np.array([[1, 0, 0], [0, np.cos(turn), np.sin(turn)], [0, -np.sin(turn), np.cos(turn)]])
    frame = Directions.of({"a": about[0], "b": about[1]})
    assert np.abs(frame.across(about[2]) - about[:2]).max() <= 1e-15
    # the plane normal to z is spanned by x and y, whatever the frame, up to the sign
    assert np.abs(frame.across(np.array([0, 0, 1.0])) - np.eye(3)[:2]).max() <= 1e-15
    assert np.abs(frame.beside(np.array([0, 0, 1.0]), np.cos(0.5)) - about[2]).max() <= 1e-15
    assert frame.beside(np.array([0, 0, 1.0]), 0.9999)[2] == 1.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"a": (1, 0, 0)}, ("input", "found 1", "1: a")),
        ({"a": (1, 0, 0), "b": (0, 0, 0)}, ("axis-zero", "'b'")),
        ({"a": (1, 0, 0), "b": (0, 1, 0), "c": (0, 1, 1)}, ("input", "'b'", "'c'", "at 45")),
        ({"a": (1, 0, 0), "b": (1, 0, 0)}, ("input", "at 0")),
        ({"a": (1, 0), "b": (0, 1)}, ("not-a-vector", "The axis 'a'", "three")),
        ({"": (1, 0, 0), "b": (0, 1, 0)}, ("not-a-text", "The name of an axis")),
        (("x", "y"), ("not-a-mapping", "The axes")),
    ],
)
def test_what_is_refused(given, message):
    with refused(InputError, *message):
        Directions.of(given)


def test_half_a_degree_counts_as_a_right_angle():
    for tilt, fits in ((0.009, True), (0.011, False)):
        given = {"a": (1, 0, 0), "b": (tilt, np.sqrt(1 - tilt**2), 0)}
        if fits:
            assert Directions.of(given).given
        else:
            with refused(InputError, "input", "right angles"):
                Directions.of(given)
