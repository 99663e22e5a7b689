"""Checks of numbers given by the user: what is accepted, what is refused and in what words."""

import numpy as np
import pytest
from refusals import refused

from fecontact import InputError
from fecontact.common import checks


@pytest.mark.parametrize(
    ("check", "good", "bad", "words"),
    [
        (checks.positive, 1e-100, [0.0, -1.0, np.inf, np.nan, "1", None, True], ("not-positive", "The size")),
        (checks.positive, 1e100, [10**101, 1e-101], ("out-of-scale", "The size")),
        (checks.share, 1e-12, [0.0, 1.0, np.nan, "0.5", None], ("no-share", "The size")),
        (checks.finite, -1e100, [np.inf, np.nan, "1", None, (1.0, 2.0)], ("not-finite", "The size")),
        (checks.finite, 0.0, [1e101], ("out-of-scale", "The size", "too large")),
        (checks.finite, 1e-100, [1e-101, -1e-101], ("out-of-scale", "The size", "too small")),
        (checks.vector, (0.0, 1e-320, 1.0), [(1, 2), (1, 2, np.nan), "far", 1.0, None], ("not-a-vector", "three")),
        (checks.vector, (0, 0, 1e100), [(0, 0, 1e101)], ("out-of-scale", "The size", "too large")),
    ],
)
def test_each_accepts_to_its_limit_and_refuses_beyond(check, good, bad, words):
    assert np.array_equal(check("the size", good), good)
    for value in bad:
        with refused(InputError, *words):
            check("the size", value)


def test_lengths_are_refused_by_the_name_of_the_argument():
    checks.lengths(inner=1.0, outer=2)
    with refused(InputError, "not-positive", "outer", "found -2"):
        checks.lengths(inner=1.0, outer=-2)


def test_a_vector_is_a_copy_of_the_length_asked_for():
    given = np.array([1.0, 2.0])
    taken = checks.vector("the point", given, 2)
    taken[0] = 5.0
    assert given.tolist() == [1.0, 2.0]
    with refused(InputError, "not-a-vector", "two"):
        checks.vector("the point", (1.0, 2.0, 3.0), 2)
