"""Fingerprints: the same for what says the same, another for anything else, in every process."""

import subprocess
import sys
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import ancf
from fecontact.common.fingerprint import fingerprint

SOLID = fc.Material(E=1000.0, nu=0.3)
HEIGHT = 2.0


def block(material=SOLID, size=1.0, **options):
    given = {"contact": "top", "supports": {"bottom": "xyz"}, **options}
    return fc.ElasticBody(fc.shapes.block((size, 1.0, 1.0), (2, 2, 2)), material, **given)


@pytest.mark.parametrize(
    ("one", "same"),
    [
        (1, 1.0),
        (-0.0, 0),
        ((0, 0, -1), np.array([0.0, 0.0, -1.0])),
        ([[1, 2], [3, 4]], np.array([[1, 2], [3, 4]])),
        (np.float32(0.5), 0.5),
        ({"a": 1, "b": (2,)}, {"b": [2.0], "a": 1}),
        ({1, 2, 3}, {3, 2, 1}),
        (float("nan"), -np.array(np.nan)),
        (np.arange(12.0).reshape(3, 4).T, np.arange(12.0).reshape(3, 4).T.copy()),
        (sp.csr_matrix([[0.0, 1.0], [2.0, 0.0]]), sp.csc_matrix([[0.0, 1.0], [2.0, 0.0]])),
        (fc.Pose(), fc.Pose(np.eye(3), (0, 0, 0))),
    ],
)
def test_equal_contents_have_one_fingerprint(one, same):
    assert fingerprint(one) == fingerprint(same)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1, "1"),
        (None, "None"),
        (b"a", "a"),
        (1.0, 1.0 + 2.3e-16),
        (2**60, 2**60 + 1),
        (10**30, 10**30 + 1),
        ((1, 2, 3), (1, 3, 2)),
        ([[1, 2], [3, 4]], [1, 2, 3, 4]),
        (("ab", "c"), ("a", "bc")),
        ([(1, 2), "x"], [(1,), 2, "x"]),
        ({"a": 1}, {"a": 2}),
        ({"a": "b"}, {"b": "a"}),
        (SOLID, replace(SOLID, E=1001.0)),
        (SOLID, replace(SOLID, density=1.0)),
        (fc.Pose(), fc.Pose(translation=(0, 0, 1e-9))),
        (fc.Sphere(1.0), fc.Plane(1.0)),
    ],
)
def test_other_contents_have_another(one, other):
    assert fingerprint(one) != fingerprint(other)


def test_things_in_a_row_are_told_apart():
    assert fingerprint("a", "b") != fingerprint("ab") != fingerprint(("a", "b"), None)


def test_bodies_count_by_what_they_are_made_of_and_not_by_what_they_have_worked_out():
    body, floor = block(), fc.RigidBody(fc.Plane())
    floor = floor.placed((0.0, 0.0, 0.99), fc.rotation_about((1, 0, 0), np.pi))
    before = fingerprint(body)
    fc.Scene([body, floor], [fc.Contact(body, floor)]).solve()
    assert fingerprint(body) == before == fingerprint(block())
    others = [
        block(fc.Material(E=1000.0, nu=0.31)),
        block(size=1.1),
        block(supports={"bottom": "z"}),
        block(contact=("top", "x_min")),
        block(name="other"),
        block().placed((0, 0, 1e-6)),
        block(integration="selective"),
    ]
    assert len({before, *map(fingerprint, others)}) == 1 + len(others)


@pytest.mark.parametrize(
    "made",
    [
        lambda E: fc.HalfSpace(fc.Material(E=E, nu=0.3), (1.0, 1.0), (8, 8)),
        lambda E: fc.PlaneBody(fc.sections.rectangle((1.0, 1.0), (2, 2)), fc.Material(E=E, nu=0.3), "top"),
        lambda E: fc.AxisymmetricBody(fc.sections.rectangle((1.0, 1.0), (2, 2)), fc.Material(E=E, nu=0.3), "top"),
        lambda E: fc.AncfBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), fc.Material(E=E, nu=0.3), "top"),
        lambda E: fc.ElasticLayer(fc.Material(E=E, nu=0.3), 0.1, (fc.shapes.block((1, 1, 1), (1, 1, 1)), "top")),
        lambda E: fc.RigidBody.from_heights(np.array([[0.0, 1.0], [E, 0.0]]), (1.0, 1.0)),
        lambda E: fc.RigidBody.from_function(lambda x, y: x**2 / E + HEIGHT * y, size=1.0),
        lambda E: fc.RigidBody.from_function(partial(np.hypot, E), size=1.0),
        lambda E: ancf.AncfSolid(ancf.AncfSpace(fc.shapes.block((1, 1, 1), (1, 1, 1))), fc.Material(E=E, nu=0.3)),
        lambda E: ancf.GeneralisedAlpha(0.5 + E / 1e4),
    ],
)
def test_every_kind_of_body_tells_its_numbers(made):
    assert fingerprint(made(100.0)) == fingerprint(made(100.0)) != fingerprint(made(101.0))


def test_functions_count_by_their_code_and_the_values_they_use(monkeypatch):
    def scaled(by):
        return lambda x, y: by * x + HEIGHT * y

    def power(n):
        def inner(x, y=n):
            return x**y

        return inner

    before = fingerprint(scaled(1.0))
    assert before == fingerprint(scaled(1)) != fingerprint(scaled(2.0))
    assert fingerprint(power(2)) != fingerprint(power(3))
    monkeypatch.setitem(globals(), "HEIGHT", 3.0)
    assert fingerprint(scaled(1.0)) != before
    assert fingerprint(lambda x: x + 1) != fingerprint(lambda x: x - 1)
    assert fingerprint(np.sin) != fingerprint(np.cos)
    assert fingerprint(np.where) != fingerprint(np.clip)


class Slope:
    def __init__(self, steepness):
        self.steepness = steepness

    @cached_property
    def angle(self):
        return np.arctan(self.steepness)

    def at(self, x):
        return self.steepness * x


@dataclass
class Knot:
    name: str
    next: object = None


def test_objects_of_ones_own_count_by_their_attributes():
    one, same = Slope(1.0), Slope(1.0)
    assert same.angle > 0  # worked out on first use: does not count
    assert fingerprint(one) == fingerprint(same) != fingerprint(Slope(2.0))
    assert fingerprint(one.at) == fingerprint(same.at) != fingerprint(Slope(2.0).at)
    knot = Knot("a")
    knot.next = knot
    assert len(fingerprint(knot)) == 32
    with refused(fc.InputError, "no-fingerprint", "builtins.object"):
        fingerprint(object())


def test_it_is_the_same_in_another_process():
    code = (
        "import fecontact as fc; from fecontact.common.fingerprint import fingerprint; "
        "b = fc.ElasticBody(fc.shapes.block((1., 1., 1.), (2, 2, 2)), fc.Material(E=1000., nu=.3), 'top', "
        "{'bottom': 'xyz'}); print(fingerprint(b, {'x', 'y', 'z'}, {'q': 1, 'p': None}))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == fingerprint(block(), {"z", "y", "x"}, {"p": None, "q": 1.0})
