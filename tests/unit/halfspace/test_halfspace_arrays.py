"""Half-spaces with the arrays of another library: a stand-in that has nothing but what the standard asks for."""

import sys
import types

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.halfspace.fft import array_module
from fecontact.surfaces import Paraboloid

PLAIN, LIKE_STEEL = fc.Material(E=1.0, nu=0.0), fc.Material(E=1.0, nu=0.3)


class Held:
    """An array that numpy's functions cannot see: products and sums among its like, parts, and DLPack."""

    __array_ufunc__ = None

    def __init__(self, values):
        self._values = values

    def __array__(self, *args, **kwargs):
        raise TypeError("not an array of numpy")

    def __mul__(self, other):
        return Held(self._values * other._values)

    def __add__(self, other):
        return Held(self._values + other._values)

    def __getitem__(self, part):
        assert isinstance(part, tuple)
        return Held(self._values[part])

    def __dlpack__(self, **options):
        return self._values.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._values.__dlpack_device__()


@pytest.fixture
def library(monkeypatch):
    """The stand-in as a module, with the number of forward transforms of rows that it did."""
    module = types.ModuleType("stand_in")
    module.transforms = 0
    module.asarray = lambda values: Held(np.array(values))
    module.stack = lambda arrays: Held(np.stack([one._values for one in arrays]))
    module.fft = types.SimpleNamespace(
        **{
            name: lambda x, *, n=None, axis=-1, name=name: Held(getattr(np.fft, name)(x._values, n=n, axis=axis))
            for name in ("irfft", "fft", "ifft")
        }
    )

    def rfft(x, *, n=None, axis=-1):
        module.transforms += 1
        return Held(np.fft.rfft(x._values, n=n, axis=axis))

    module.fft.rfft = rfft
    monkeypatch.setitem(sys.modules, "stand_in", module)
    return module


@pytest.mark.parametrize("periodic", [False, True])
def test_pressures_are_those_of_numpy(library, periodic):
    size, load = (3.0, 3.0), {"force": 4 / 3} if not periodic else {"force": 0.5}
    ball = Paraboloid(1.0)
    plain = fc.HalfSpace(PLAIN, size, (40, 36), periodic).press(ball, symmetry=False, **load)
    other = fc.HalfSpace(PLAIN, size, (40, 36), periodic, arrays="stand_in").press(ball, **load)
    assert np.abs(other.pressure - plain.pressure).max() < 1e-6 * plain.max_pressure  # both to a tolerance of 1e-8
    assert other.residuals.within(1e-8)
    assert other.solver.symmetric == (False, False)
    # every product there is of the library: those of the compliance, and preconditionings
    assert library.transforms > other.solver.products > 5


def test_friction_is_that_of_numpy(library):
    drag = {"force": 4 / 3, "friction": 0.3, "tangential": (0.2, 0.0)}
    plain = fc.HalfSpace(LIKE_STEEL, (3.0, 3.0), (24, 24)).press(Paraboloid(1.0), **drag)
    other = fc.HalfSpace(LIKE_STEEL, (3.0, 3.0), (24, 24), arrays="stand_in").press(Paraboloid(1.0), **drag)
    assert np.abs(other.traction - plain.traction).max() < 1e-8 * plain.max_pressure
    assert other.residuals.within(1e-10)
    assert library.transforms > 50


def test_a_scene_with_it(library):
    half = fc.HalfSpace(PLAIN, (8.0, 8.0), (44, 44), arrays="stand_in", name="half")
    ball = fc.RigidBody(Paraboloid(1.0), name="ball")
    result = fc.Scene([half, ball], [fc.Contact(ball, half)]).solve(forces={ball: (0.0, 0.0, -4 / 3)})
    assert result.solution.solver == "nested-grid"
    assert result.contacts[0].pressure.max() == pytest.approx(2 / np.pi, rel=0.02)  # Hertz, cells of 0.18 a
    assert library.transforms > 20


def test_modules_that_cannot_serve_are_refused(library):
    with refused(fc.MissingPackageError, "missing-package", "'no_such_arrays'"):
        fc.HalfSpace(PLAIN, (3.0, 3.0), (8, 8), arrays="no_such_arrays")
    del library.fft.ifft
    with refused(fc.InputError, "incomplete-arrays", "fft.ifft"):
        fc.HalfSpace(PLAIN, (3.0, 3.0), (8, 8), arrays="stand_in")


def test_the_strict_implementation_of_the_standard():
    pytest.importorskip("array_api_strict")
    assert array_module("array_api_strict")
    other = fc.HalfSpace(PLAIN, (3.0, 3.0), (32, 32), arrays="array_api_strict").press(Paraboloid(1.0), force=4 / 3)
    plain = fc.HalfSpace(PLAIN, (3.0, 3.0), (32, 32)).press(Paraboloid(1.0), force=4 / 3)
    assert np.abs(other.pressure - plain.pressure).max() < 1e-6 * plain.max_pressure
