"""``search="global" | "local"`` of solutions and sweeps."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

SOLID = fc.Material(E=1000.0, nu=0.3)


def ball_on_pad() -> tuple[fc.Scene, dict]:
    """An elastic ball on a wide elastic pad, most of which is out of its reach."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 1), element="hex8").translated((-2.0, -2.0, -1.0))
    pad = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="pad")
    mesh = fc.shapes.half_sphere(5.0, contact_radius=1.0, level=1, element="hex8")
    ball = fc.ElasticBody(mesh, SOLID, "cap", {"base": "xyz"}, name="ball")
    scene = fc.Scene([pad, ball], [fc.Contact(ball, pad, coupling="nodal")])
    return scene, {"forces": {ball: (0.0, 0.0, -5.0)}, "finite_motion": False}


def is_local(result: fc.ContactResult) -> bool:
    """Whether only near parts were paired."""
    return result._interfaces[0].region is not None


def test_global_is_the_default_and_local_gives_the_same_force() -> None:
    scene, loads = ball_on_pad()
    default, everywhere, near = (scene.solve(**loads, **s) for s in ({}, {"search": "global"}, {"search": "local"}))
    assert [is_local(r) for r in (default, everywhere, near)] == [False, False, True]
    forces = [r.contacts[0].total_force for r in (default, everywhere, near)]
    # the same equations; differences are rounding times the condition of the compliance
    assert np.ptp(forces) < 1e-10 * forces[0]


def test_sweeps_search_locally_unless_they_say_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, loads = ball_on_pad()
    asked = []
    monkeypatch.setattr(
        "fecontact.scene.sweep_case.solve_scene",
        lambda scene, **given: asked.append(given["search"]) or scene.solve(**given),
    )
    (row,) = scene.sweep([loads])
    assert asked == []
    for told in ({"search": "global"}, {"search": "local"}):
        (other,) = scene.sweep([{**loads, **told}])
        assert abs(other["contacts"][0]["force"][2] / row["contacts"][0]["force"][2] - 1) < 1e-10
    assert asked == ["global"]


@pytest.mark.parametrize("search", ["near", True, None])
def test_another_search_is_refused(search: object) -> None:
    scene, loads = ball_on_pad()
    with refused(fc.InputError, "unknown-name", "search", repr(search), "'global', 'local'"):
        scene.solve(**loads, search=search)
    with refused(fc.InputError, "unknown-name", "'a'", "'global', 'local'"):
        scene.sweep([{**loads, "search": search, "name": "a"}])
