"""How a contact is coupled is chosen before it is paired: once, whatever is chosen."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import fecontact as fc
from fecontact.contact.coupling import choose
from fecontact.contact.coupling.nodal import SurfacePair, nested

pytestmark = pytest.mark.rounding(0)

SOLID = fc.Material(E=1.0, nu=0.3)


def block(n: int, name: str, contact: str, element: str = "hex20") -> fc.ElasticBody:
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (n, n, 1), element=element)
    held = {"top": "bottom", "bottom": "top"}[contact]
    return fc.ElasticBody(mesh, SOLID, contact, {held: "xyz"}, name=name)


def blocks(upper: int, lower: int, **options: str) -> Callable[[], tuple[fc.Scene, fc.ElasticBody]]:
    def made() -> tuple[fc.Scene, fc.ElasticBody]:
        above = block(upper, "upper", "bottom").placed((0.0, 0.0, 0.5))
        below = block(lower, "lower", "top")
        return fc.Scene([above, below], [fc.Contact(above, below, **options)]), above

    return made


def narrow(wide: int) -> Callable[[], tuple[fc.Scene, fc.ElasticBody]]:
    """A block of 5 x 5 faces on the middle of one of n x n faces: it covers two of 4 in part, and four of 8."""

    def made() -> tuple[fc.Scene, fc.ElasticBody]:
        mesh = fc.shapes.block((0.4, 0.4, 0.2), (5, 5, 1), element="hex20").translated((0.3, 0.3, 0.0))
        above = fc.ElasticBody(mesh, SOLID, "bottom", {"top": "xyz"}, name="upper").placed((0.0, 0.0, 0.5))
        below = block(wide, "lower", "top")
        return fc.Scene([above, below], [fc.Contact(above, below)]), above

    return made


def on_cells() -> tuple[fc.Scene, fc.ElasticBody]:
    above = block(2, "upper", "bottom").placed((-0.5, -0.5, 0.0))
    half = fc.HalfSpace(SOLID, size=(2.0, 2.0), cells=(12, 12))
    return fc.Scene([above, half], [fc.Contact(half, above)]), above


CASES = {
    "match": (blocks(3, 3), "nodal", "upper"),
    "nest": (blocks(4, 2), "nodal", "upper"),
    "do not match": (blocks(2, 3), "mortar", "upper"),
    "swap to the coarser": (blocks(3, 2), "mortar", "lower"),
    "coarser, with a face amid others": (narrow(8), "mortar", "lower"),
    "coarser, with none": (narrow(4), "mortar", "upper"),
    "nodal, swap to the finer": (blocks(2, 3, coupling="nodal"), "nodal", "lower"),
    "mortar": (blocks(3, 3, coupling="mortar"), "mortar", "upper"),
    "cells of a half-space": (on_cells, None, None),
}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    made: list[str] = []
    for name in ("pair", "pair_mortar", "pair_cells"):
        one = getattr(choose, name)
        monkeypatch.setattr(choose, name, lambda *a, one=one, name=name: made.append(name) or one(*a))
    return made


@pytest.mark.parametrize("case", CASES)
def test_a_contact_is_paired_once(case: str, calls: list[str]) -> None:
    made, coupling, slave = CASES[case]
    scene, above = made()
    first = scene.solve(motions={above: {"z": -0.01}})
    assert len(calls) == 1
    if coupling is not None:
        assert (first.contacts[0].coupling, first.contacts[0].slave.name) == (coupling, slave)
    # another load that suits the same pairs finds them paired
    second = scene.solve(motions={above: {"z": -0.02}})
    assert len(calls) == 1
    ratio = second.contacts[0].force / first.contacts[0].force[2]
    # all of these blocks are wholly in touch, so force is proportional to approach; 1e-9: rounding of a solution
    assert abs(ratio[2] - 2) < 1e-9


def test_faces_that_do_not_nest_are_told_by_a_few_of_their_nodes() -> None:
    fine, coarse = block(12, "fine", "bottom").surface("bottom"), block(7, "coarse", "top").surface("top")
    surfaces = SurfacePair(fine, coarse, np.eye(3), np.array([0.0, 0.0, 0.5]), share=0.5)
    assert not nested(surfaces, np.arange(len(surfaces.nodes)))
    assert "along_lines" not in vars(surfaces)
