"""Warnings of contacts on half-spaces beyond small strains and slopes, which must not come for others."""

import numpy as np
import pytest
import scipy.ndimage

import fecontact as fc
from fecontact.app.cli import main
from fecontact.halfspace.validity import _largest_near
from fecontact.surfaces import FlatPunch, Paraboloid, self_affine

STEEL, SOFT = fc.Material(210e3, 0.3), fc.Material(1.0, 0.0)


def words(contact):
    """First words of the warnings, without those of the error of the grid."""
    return [text.split(":")[0] for text in contact.warnings if "cells across" not in text]


STRAINS, STEEP = "Strains are not small", "The counter-surface is steep where it touches"


@pytest.mark.parametrize(("over", "told"), [(0.25, []), (0.35, [STRAINS]), (1.7, [STRAINS, STEEP])])
def test_a_ball_beyond_small_strains_is_warned_of(over, told):
    # approach over half-width is a/R, and the rms slope of a paraboloid in its contact a/(sqrt(2) R)
    half = fc.HalfSpace(STEEL, size=(3 * over, 3 * over), cells=(32, 32))
    contact = half.press(Paraboloid(1.0), approach=over**2)
    assert words(contact) == told
    assert all(text in str(contact) and text in contact.summary()["warnings"] for text in contact.warnings)


def test_a_punch_is_warned_of_by_its_strain():
    half = fc.HalfSpace(SOFT, size=(3.0, 3.0), cells=(32, 32))
    for depth, told in ((0.2, []), (0.4, [STRAINS])):
        assert words(half.press(FlatPunch(radius=1.0), approach=depth)) == told


@pytest.mark.parametrize("periodic", [False, True])
def test_layers_on_a_rigid_base_are_warned_of_by_their_thickness(periodic):
    half = fc.HalfSpace(None, (1.0, 1.0), (32, 32), periodic, layers=[fc.Layer(SOFT, 0.01)])
    for depth, told in ((0.002, []), (0.005, [STRAINS])):
        assert words(half.press(Paraboloid(20.0), approach=depth)) == told


def test_a_press_of_a_period_is_warned_of_by_its_pressure():
    half = fc.HalfSpace(SOFT, (1.0, 1.0), (32, 32), periodic=True)
    wave = 0.02 * (1 - np.cos(2 * np.pi * half.grid.x))[:, None] * np.ones(32)
    assert words(half.press(wave, force=0.1)) == []
    assert words(half.press(wave, force=0.5)) == [STRAINS]


@pytest.mark.parametrize("periodic", [False, True])
def test_heights_in_nanometres_beside_millimetres_are_warned_of(periodic, tmp_path, capsys):
    half = fc.HalfSpace(STEEL, (1.0, 1.0), (32, 32), periodic)
    heights = self_affine((32, 32), (1.0, 1.0), hurst=0.8, seed=3, rms_height=200.0).z
    z = heights + (0 if periodic else 2000 * (half.grid.x[:, None] ** 2 + half.grid.x**2))
    contact = half.press(z - z.min(), force=10.0)
    assert STEEP in words(contact)
    assert any("cells across" in text for text in contact.warnings)  # one cell carries all
    assert words(half.press(1e-6 * (z - z.min()), force=0.1)) == []
    np.save(tmp_path / "nm.npy", z)
    command = ["halfspace", "heights", "--file", str(tmp_path / "nm.npy"), "--size=1", "--E=210e3", "--loads=5,10"]
    assert main([*command, "--height-unit=1", *(["--periodic"] if periodic else [])]) == 0
    assert "Warning: At the force 5: " in capsys.readouterr().out


def test_paths_tell_their_warnings():
    half = fc.HalfSpace(SOFT, size=(3.0, 3.0), cells=(32, 32), against=SOFT)
    steps = [fc.PressStep(force=f, tangential=(0.0, 0.0)) for f in (0.001, 0.6, 0.6)]
    path = half.press_path(Paraboloid(1.0), steps, friction=0.5)
    told = [text for text in path.warnings if STRAINS in text]
    assert len(told) == 1
    assert told[0].startswith("Step 2: ")
    assert f"Warning: {told[0]}" in str(path)
    assert path.as_dict()["warnings"] == list(path.warnings)


@pytest.mark.parametrize(("over", "told"), [(0.25, []), (0.35, [STRAINS]), (1.7, [STRAINS, STEEP])])
def test_a_scene_warns_as_the_half_space_alone_does(over, told):
    half = fc.HalfSpace(STEEL, size=(3 * over, 3 * over), cells=(32, 32), name="half")
    alone = [text for text in half.press(Paraboloid(1.0), approach=over**2).warnings if "cells across" not in text]
    ball = fc.RigidBody(Paraboloid(1.0), name="ball").placed((0.0, 0.0, 2.0))
    raised = half.placed((0.0, 0.0, 2.0))
    scene = fc.Scene([raised, ball], [fc.Contact(raised, ball)])
    result = scene.solve(motions={ball: {"z": -(over**2)}})
    assert [text.split(":")[0] for text in alone] == told
    assert [text for text in result.warnings if "small" in text or "steep" in text] == [f"'half': {t}" for t in alone]
    assert all(text in str(result) for text in result.warnings)


def test_the_largest_of_neighbours_is_that_of_scipys_filter():
    values = np.random.default_rng(2).normal(size=(7, 5))
    assert (_largest_near(values) == scipy.ndimage.maximum_filter(values, 3)).all()
    assert (_largest_near(values > 1) == scipy.ndimage.maximum_filter(values > 1, 3)).all()
