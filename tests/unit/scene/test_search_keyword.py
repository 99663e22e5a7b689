"""``search="global" | "local"`` of solutions and sweeps, and its former name ``whole``, which works and warns."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import fecontact as fc

SOLID = fc.Material(E=1000.0, nu=0.3)


def ball_on_pad() -> tuple[fc.Scene, dict]:
    """An elastic ball on a wide elastic pad, most of which is out of its reach."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (8, 8, 1)).translated((-2.0, -2.0, -1.0))
    pad = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="pad")
    mesh = fc.shapes.half_sphere(5.0, contact_radius=1.0, level=1)
    ball = fc.ElasticBody(mesh, SOLID, "cap", {"base": "xyz"}, name="ball")
    scene = fc.Scene([pad, ball], [fc.Contact(ball, pad, coupling="nodal")])
    return scene, {"forces": {ball: (0.0, 0.0, -5.0)}, "finite_motion": False}


def is_local(result: fc.ContactResult) -> bool:
    """Whether only near parts were paired."""
    return result.interfaces[0].region is not None


def test_global_is_the_default_and_local_gives_the_same_force() -> None:
    scene, loads = ball_on_pad()
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        default, everywhere, near = (scene.solve(**loads, **s) for s in ({}, {"search": "global"}, {"search": "local"}))
    assert [is_local(r) for r in (default, everywhere, near)] == [False, False, True]
    forces = [r.contacts[0].total_force for r in (default, everywhere, near)]
    # the same equations; differences are rounding times the condition of the compliance
    assert np.ptp(forces) < 1e-10 * forces[0]


@pytest.mark.parametrize(("whole", "search"), [(True, "global"), (False, "local")])
def test_the_former_keyword_works_and_warns_where_it_is_used(whole: bool, search: str) -> None:
    scene, loads = ball_on_pad()
    with pytest.warns(DeprecationWarning, match=rf"whole={whole} is now search='{search}'") as told:
        result = scene.solve(**loads, whole=whole)
    assert is_local(result) == (search == "local")
    assert [Path(w.filename).name for w in told] == [Path(__file__).name]


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
    with pytest.warns(DeprecationWarning, match="whole=True is now search='global'") as warned:
        scene.sweep([{**loads, "whole": True}])
    assert [Path(w.filename).name for w in warned] == [Path(__file__).name]
    assert asked == ["global", "global"]


def test_a_row_of_the_former_keyword_is_that_of_the_new_one(tmp_path: Path) -> None:
    scene, loads = ball_on_pad()
    path = tmp_path / "rows.jsonl"
    rows = scene.sweep([{**loads, "search": "global"}], path)
    with pytest.warns(DeprecationWarning, match="is now search"):
        assert list(scene.sweep([{**loads, "whole": True}], path)) == list(rows)


@pytest.mark.parametrize("search", ["near", True, None])
def test_another_search_is_refused(search: object) -> None:
    scene, loads = ball_on_pad()
    with pytest.raises(fc.InputError, match=rf"Unknown search {search!r}; expected one of 'global', 'local'"):
        scene.solve(**loads, search=search)
    with pytest.raises(fc.InputError, match=r"Case 'a'.*'global', 'local'"):
        scene.sweep([{**loads, "search": search, "name": "a"}])


def test_both_names_at_once_are_refused() -> None:
    scene, loads = ball_on_pad()
    with pytest.raises(fc.InputError, match="give search alone"):
        scene.solve(**loads, search="local", whole=True)
