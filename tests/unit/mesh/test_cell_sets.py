"""What meshes of bodies and of sections share: their sets, and the verbs that return a copy."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError, MeshError
from fecontact.mesh import pick
from fecontact.mesh.base_mesh import BaseMesh, joined

BLOCK = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1)).with_group("left", lambda x: x[:, 0] < 1.0)
PLATE = fc.sections.rectangle((2.0, 1.0), (2, 1)).with_group("left", lambda x: x[:, 0] < 1.0)
BOTH = pytest.mark.parametrize("mesh", [BLOCK, PLATE], ids=["block", "plate"])


@BOTH
def test_verbs_return_the_same_kind_of_mesh_with_its_sets(mesh: BaseMesh) -> None:
    half = mesh.points[:, 0].min() + 1.0
    named = mesh.with_boundary("half", lambda x: (x[:, 2] == mesh.points[:, 2].max()) & (x[:, 0] <= half))
    moved = named.scaled(3.0).translated((0.0, 0.0, 5.0))
    assert type(moved) is type(mesh)
    np.testing.assert_allclose(moved.points, 3.0 * mesh.points + [0, 0, 5], rtol=1e-15)
    assert len(moved.faces("half")) == 1
    assert moved.groups.keys() == {"left"}
    again = pickle.loads(pickle.dumps(moved))
    assert repr(again) == repr(moved) != repr(mesh)


@BOTH
def test_two_joined_meshes_lose_the_faces_between_them(mesh: BaseMesh) -> None:
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    both = joined([mesh, mesh.translated((high[0] - low[0], 0.0, 0.0))], 1e-9)
    assert len(both.cells) == 2 * len(mesh.cells)
    assert len(both.outer) == 2 * len(mesh.outer) - 2
    assert both.groups["left"].tolist() == [0, 2]
    assert all(np.isin(f @ [8, 1], both.outer @ [8, 1]).all() for f in both.boundaries.values())
    with refused(MeshError, "mesh", "Meshes of different cells"):
        joined([fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"), BLOCK], 1e-9)


@BOTH
@pytest.mark.parametrize(
    ("kind", "members", "said"),
    [
        ("boundaries", [[2, 0]], ("boundary-shape", "below 2")),
        ("boundaries", [[0, 6]], ("boundary-shape",)),
        ("groups", [2], ("mesh", "... 1")),
        ("node_sets", [-1], ("mesh", "point numbers")),
    ],
)
def test_members_that_do_not_exist_are_refused(mesh: BaseMesh, kind: str, members: list[int], said: str) -> None:
    with refused(MeshError, *said):
        type(mesh)(mesh.points, mesh.cells, **{kind: {"wrong": np.array(members)}})


def test_picks_are_of_meshes_of_bodies() -> None:
    top = pick.facing((0, 0, 1))
    assert len(BLOCK.with_boundary("upper", top).faces("upper")) == 2
    with refused(InputError, "input", "section"):
        PLATE.with_boundary("upper", top)
