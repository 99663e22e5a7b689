"""Checks of arguments that are no numbers: what is accepted, what is refused and in what words."""

from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.common import arguments, checks
from fecontact.common.errors import shown


@pytest.mark.parametrize(
    ("check", "good", "bad", "code"),
    [
        (arguments.text, "femur", ["", None, 1, b"femur", ["femur"], "\udcc2m"], "not-a-text"),
        (arguments.texts, ["a", "b"], [None, 1, {"a": 1}], "not-a-sequence"),
        (arguments.texts, ["a", "b"], [["a", 2], [""]], "not-a-text"),
        (arguments.flag, False, [None, 0, 1.0, "no"], "not-true-or-false"),
        (arguments.function, print, [None, 1, "print"], "not-a-function"),
        (arguments.mapping, {"a": 1}, [1, "a", [("a", 1)]], "not-a-mapping"),
        (arguments.file_path, Path("knee.inp"), [None, "", 3, b"a", "a\0b", "n" * 300, ["a"]], "not-a-path"),
        (checks.whole, 3, [0, 1.5, "3", None, True, 10**10], "not-whole"),
        (checks.number_array, [1.0, np.inf], [None, "1", [1j], [[1], [1, 2]], [None], ["1"]], "not-numbers"),
        (checks.index_array, [0, 7], [[0.5], [np.nan], [10**400], "1", [None]], "not-whole"),
    ],
)
def test_each_accepts_what_it_is_for_and_refuses_the_rest(check, good, bad, code):
    assert np.array_equal(check("the thing", good), good)
    for value in bad:
        with refused(InputError, code, "he thing"):
            check("the thing", value)


def test_sequences_instances_and_flags_of_points():
    assert arguments.items("the bodies", (b for b in "ab"), "bodies") == ("a", "b")
    for value in (None, "ab", {"a": 1}, 3):
        with refused(InputError, "not-a-sequence", "bodies"):
            arguments.items("the bodies", value, "bodies")
    assert arguments.instance("the number", 2, (int, type(None))) == 2
    with refused(InputError, "wrong-class", "a int or None", "'x'"):
        arguments.instance("the number", "x", (int, type(None)))
    assert checks.flags("where", np.array([True, False]), 2).tolist() == [True, False]
    for values in (None, [True], [0.5, 1.0], "ab"):
        with refused(InputError, "not-true-or-false", "give 2"):
            checks.flags("where", values, 2)


def test_three_positive_numbers():
    assert checks.positives("the sides", [1, 2, 3], 3) == (1.0, 2.0, 3.0)
    for values in (None, [1, 2], [1, 2, -3], [1, 2, np.inf], "123"):
        with refused(InputError, "not-positive", "three"):
            checks.positives("the sides", values, 3)
    for values in ([1, 1e-200, 1], [1, 1, 1e200]):
        with refused(InputError, "out-of-scale", "The sides"):
            checks.positives("the sides", values, 3)


def test_a_message_repeats_a_value_cut_and_survives_one_that_does_not_print():
    class Mute:
        def __repr__(self) -> str:
            raise RuntimeError

    assert shown("x") == "'x'"
    assert len(shown(list(range(1000)))) == 120
    assert shown(Mute()) == "a Mute that cannot be printed"
    with refused(InputError, "not-positive", "a Mute that cannot be printed"):
        checks.positive("the force", Mute())


def test_a_misspelt_argument_is_answered_with_the_one_that_was_meant():
    """Of functions, methods and classes, also before missing ones; plain Python errors stay as they are."""
    steel = fc.Material(1.0, 0.3)
    half = fc.HalfSpace(steel, size=(1.0, 1.0), cells=(4, 4))
    for call, meant in (
        (lambda: fc.Material(E=1.0, v=0.3), "Material() has no 'v'"),
        (lambda: fc.HalfSpace(steel, size=1.0, cell=4), "'cell', did you mean 'cells'?"),
        (lambda: fc.RigidBody(fc.Plane(), names="floor"), "'names', did you mean 'name'?"),
        (lambda: fc.ElasticBody(None, steel, contacts="top"), "'contacts', did you mean 'contact'?"),
        (lambda: fc.shapes.sphere(1.0, levels=1), "'levels', did you mean 'level'?"),
        (lambda: half.press(fc.Sphere(1.0), forces=1.0), "press() has no 'forces', did you mean 'force'?"),
        (lambda: fc.hertz.spheres((1.0, 1.0), (steel, steel), forse=1.0), "'forse', did you mean 'force'?"),
    ):
        with refused(InputError, "unknown-option", meant):
            call()
    assert half.press(fc.Sphere(1.0), force=1e-4).max_pressure > 0
    with pytest.raises(TypeError, match="nu"):
        fc.Material(1.0)
