"""Material turned inside out is refused where a law does not notice it: in equilibrium, in motion, on going on.

The law is St. Venant and Kirchhoff's with nu = 0. Under a nominal stress p along one axis the stretch s solves
E (s^3 - s)/2 = p; the left side has its minimum -E/(3 sqrt(3)) = -0.19245 E at s = 1/sqrt(3), so that only s < -1
balances more pressure than that.
"""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    GeneralisedAlpha,
    InvertedError,
    Stage,
    equilibrium,
    move,
    traction,
)
from fecontact.ancf.system.schemes import _settled
from fecontact.ancf.system.tangent import UnstableError

MOST = 1 / (3 * np.sqrt(3))  # the greatest pressure over E


def column(volumetric=None):
    """A unit cube of two bricks that can only be squeezed and stretched along z."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 2), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.0, density=1.0), volumetric=volumetric)
    return Assembly.of([solid], [{"bottom": "xyz", "x_min": "x", "x_max": "x", "y_min": "y", "y_max": "y"}])


def pressed(assembly, pressure, **options):
    load = traction(assembly.solids[0].space, "top", (0.0, 0.0, -pressure))
    return equilibrium(lambda level: Stage(assembly, level * load), **options)


def stretch(assembly, q):
    z = assembly.solids[0].space.affine(np.zeros((3, 3)), (0.0, 0.0, 1.0)) != 0
    return q[z].max() - q[z].min()


def unguarded(monkeypatch):
    monkeypatch.setattr(Assembly, "check_inverted", lambda self, q: None)


def smallest_det(assembly, q):
    solid = assembly.solids[0]
    cells = np.repeat(np.arange(2), 27)
    X = np.tile(np.stack(np.meshgrid(*3 * [[0.1, 0.5, 0.9]]), axis=-1).reshape(-1, 3), (2, 1))
    return np.linalg.det(solid.space.gradient_at(q, cells, X)).min()


def test_a_pressure_that_the_law_bears_is_reached():
    a = column()
    path = pressed(a, 0.95 * MOST)
    assert path.success, path.message
    s = max(np.roots([0.5, 0.0, -0.5, 0.95 * MOST]).real)
    # the tolerance of the balance, over a stiffness of a third of E near the extreme
    assert abs(stretch(a, path.last.q) - s) < 1e-6


def test_an_absurd_pressure_is_refused_and_was_balanced_inside_out(monkeypatch):
    a = column()
    path = pressed(a, 30.0)
    assert not path.success
    assert smallest_det(a, path.last.q) > 0
    # what the law bears, less the shortest step and the one that was cut
    assert MOST / 30 - 3e-4 < path.last.level <= MOST / 30
    unguarded(monkeypatch)
    blind = pressed(a, 30.0)
    assert blind.success
    s = min(np.roots([0.5, 0.0, -0.5, 30.0]).real)
    assert abs(smallest_det(a, blind.last.q) / s - 1) < 1e-6


def test_the_refusal_names_place_figure_and_remedy():
    a = column()
    q = a.q0.reshape(-1, 3).copy()
    top = 4 * np.flatnonzero(a.solids[0].space.mesh.points[:, 2] == 1.0)
    q[top, 2] = -0.5  # the top face below the middle one: the upper brick is inside out, the lower is not
    with refused(InvertedError, "inverted-material", "Solid 1") as told:
        a.check_inverted(q.ravel())
    said = str(told.value)
    assert "cell 1" in said
    assert "det F = -" in said
    assert "NeoHookean" in said
    height = float(said.partition("at (")[2].partition(")")[0].split(",")[2])
    assert 0.5 < height < 1.0
    a.check_inverted(a.q0)


@pytest.mark.parametrize("volumetric", [None, 2])
def test_only_det_f_counts(volumetric):
    a = column(volumetric)
    space = a.solids[0].space
    for good in (np.diag([-1.0, -1.0, 1.0]), np.diag([1e-3, 1.0, 1.0])):  # half a turn; nearly flat
        a.check_inverted(space.affine(good))
    for bad in (np.diag([1.0, 1.0, -1.0]), np.diag([1.0, 1.0, 0.0]), np.diag([1.0, np.nan, 1.0])):
        with refused(InvertedError, "inverted-material", f"at {128 + (16 if volumetric else 0)} Gauss"):
            a.check_inverted(space.affine(bad))


def test_an_inverted_state_is_nothing_to_go_on_from():
    a = column()
    good = pressed(a, 0.5 * MOST, steps=2).last
    bad = replace(good, q=a.solids[0].space.affine(np.diag([1.0, 1.0, -1.0])))
    with refused(InvertedError, "inverted-material", "inside out"):
        pressed(a, 0.5 * MOST, start=bad)
    assert pressed(a, 0.6 * MOST, start=good).success


@pytest.mark.parametrize("scheme", [GeneralisedAlpha(), EnergyMomentum()], ids=["alpha", "energy-momentum"])
def test_a_blow_that_inverts_is_refused_and_a_lighter_one_is_not(scheme, monkeypatch):
    """Ends that run at each other: strain energy to flatten it is E/8, kinetic energy c^2/24 by volume."""
    a = column()
    a = Assembly.of(a.solids)
    inwards = a.solids[0].space.affine(np.diag([0.0, 0.0, -1.0]), (0.0, 0.0, 0.5))

    def blow(c):
        return move(a, until=0.6, step=0.02, scheme=scheme, velocity=c * inwards, every=1)

    light = blow(0.8)  # a fifth of the energy
    assert light.success, light.message
    hard = blow(3.0)  # three times the energy
    assert not hard.success
    assert "inside out" in hard.message
    assert all(smallest_det(a, q) > 0 for q in hard.frames)
    # steps that shrink towards the instant end there, and do not wear out the energy on the way
    assert len(hard.time) < 60
    assert hard.drift < 3e-3
    unguarded(monkeypatch)
    blind = blow(3.0)
    assert min(smallest_det(a, q) for q in blind.frames) < 0


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e9])
def test_iterations_that_run_away_are_told_before_they_overflow(unit):
    mesh = fc.shapes.block((unit, unit, unit), (1, 1, 1), element="hex8")
    a = Assembly.of([AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.3))])
    change = a.translation(np.array([unit, 0.0, 0.0]))
    assert not _settled(a, 1e5 * change, change, 1e-9)
    for far in (1e7, np.inf, np.nan):
        with refused(UnstableError, "diverged"):
            _settled(a, np.where(change > 0, far * unit, 0.0), change, 1e-9)
