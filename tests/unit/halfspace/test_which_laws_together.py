"""Which laws of half-spaces are served together: every pair of the table in docs/half-space.md is tried."""

from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

PLAIN = fc.Material(E=1.0, nu=0.0)
RUBBER = fc.Viscoelastic(PLAIN, prony=[(0.5, 1.0)])
BALL, WAVE, FORCE = fc.surfaces.Paraboloid(1.0), 0.01, 0.02
PAGE = Path(__file__).parents[3] / "docs" / "half-space.md"
LAWS = (
    "friction", "hardness", "wear", "adhesion", "rubber, in time", "rubber, moving", "rolling", "layers", "periodic",
    "tilt",
)  # fmt: skip


def table():
    """Cells of the page's table by pairs of laws."""
    text = PAGE.read_text(encoding="utf-8")
    lines = text[text.index("| together |") :].split("\n\n")[0].splitlines()
    head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert tuple(row[0] for row in rows) == LAWS[:-1]
    return {frozenset((row[0], other)): c for row in rows for other, c in zip(head[1:], row[1:], strict=True) if c}


def tried(laws):
    """A contact with some laws, each asked for as its how-to does."""
    memory = laws & {"rubber, in time", "rubber, moving"}
    periodic = "periodic" in laws
    layers = (fc.Layer(fc.Material(E=2.0, nu=0.3), 0.2),) if "layers" in laws else ()
    half = fc.HalfSpace(
        RUBBER if memory else PLAIN, (1.0, 1.0) if periodic else (1.4, 1.4), (12, 12), layers=layers, periodic=periodic
    )
    surface = half.heights_of(BALL)
    if periodic:
        surface = WAVE * np.cos(2 * np.pi * half.grid.x)[:, None] * np.cos(2 * np.pi * half.grid.y)
    mu = 0.3 if "friction" in laws else 0.0
    more = {"hardness": 0.08} if "hardness" in laws else {}
    point = {"load_point": (0.02, 0.0)} if "tilt" in laws else {}
    if "rolling" in laws:
        more |= {"adhesion": fc.Dugdale(1e-4, 1e-2)} if "adhesion" in laws else {}
        found = half.roll(surface, force=FORCE, friction=0.3, creepage=(0.02, 0.0), **more, **point)
        if "wear" in laws:
            assert found.worn_per_pass(1e-3).sum() > 0
        return found
    if "adhesion" in laws or "rubber, moving" in laws:
        more |= {"adhesion": fc.Dugdale(1e-4, 1e-2)} if "adhesion" in laws else {}
        more |= {"velocity": (1.0, 0.0)} if "rubber, moving" in laws else {}
        more |= {"friction": 0.3} if "friction" in laws else {}
        more |= {"wear": 1e-3} if "wear" in laws else {}
        return half.press(surface, force=FORCE, **point, **more)
    if laws & {"wear", "rubber, in time", "friction"}:
        more |= {"wear": 1e-3} if "wear" in laws else {}
        times = (0.5, 1.0) if "rubber, in time" in laws else (None, None)
        steps = [fc.PressStep(force=FORCE, shift=(0.01 * k, 0.0), time=t, **point) for k, t in enumerate(times)]
        return half.press_path(surface, steps, mu, **more).last
    return half.press(surface, force=FORCE, **point, **more)


@pytest.mark.parametrize("pair", list(combinations(LAWS, 2)), ids=" and ".join)
def test_each_pair_is_as_the_page_says(pair):
    said = table()[frozenset(pair)]
    if said == "one":  # of two ways to move or to be cut none has both
        return
    if said == "no argument":
        with refused(fc.InputError, "unknown-option"):
            tried(set(pair))
        return
    if said != "yes":
        with refused(fc.InputError, said.strip("`")):
            tried(set(pair))
        return
    found = tried(set(pair))
    assert found.residuals.worst < 1e-8
    assert abs(found.force / FORCE - 1) < 1e-9


def test_rubber_that_yields_is_elastic_at_once_and_after_long():
    """At once the half-space is that of t = 0, loaded slowly that of the relaxed moduli; dents only grow."""
    half, hard = fc.HalfSpace(RUBBER, (1.4, 1.4), (24, 24)), 0.06
    for time, material in ((0.0, PLAIN), (1e12, RUBBER.relaxed)):
        soon = half.press_path(BALL, [fc.PressStep(force=FORCE, time=time)], 0.0, hardness=hard).last
        same = fc.HalfSpace(material, (1.4, 1.4), (24, 24)).press(BALL, force=FORCE, hardness=hard, tolerance=1e-10)
        assert np.abs(soon.pressure - same.pressure).max() < 1e-8 * hard
        assert np.abs(soon.dent - same.dent).max() < 1e-8 * same.dent.max()
        assert same.plastic_area > 0
    steps = [fc.PressStep(force=FORCE, time=t) for t in (0.0, 0.2, 1.0, 5.0)]
    path = half.press_path(BALL, steps, 0.0, hardness=hard)
    assert all((b.dent >= a.dent - 1e-12).all() for a, b in pairwise(path))
    free = half.press_path(BALL, steps, 0.0).last
    assert (half.press_path(BALL, steps, 0.0, hardness=1e3).last.pressure == free.pressure).all()
    off = half.press_path(BALL, [*steps, fc.PressStep(force=0.1 * FORCE, time=5.0)], 0.0, hardness=hard)
    assert (off.last.dent == path.last.dent).all()  # what was yielded stays
