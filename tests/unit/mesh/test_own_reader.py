"""Readers of the user's own: what they return is checked and brought into form like all others."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.mesh.formats.raw import RawMesh

CORNERS = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)


@pytest.fixture(params=["cube.mine", "cube.stl", "cube.inp"])
def path(tmp_path, request):
    file = tmp_path / request.param
    file.write_text("0 1 2 3 4 5 6 7")
    return file


def test_any_file_is_read_by_an_own_reader(path) -> None:
    def reader(file):
        cells = np.array([file.read_text().split()], dtype=np.int64)
        return RawMesh(CORNERS, [("hex8", cells)], node_sets={"floor": np.arange(4)})

    mesh = fc.read_mesh(path, scale=10.0, element="hex20", reader=reader)
    assert mesh.cells.shape == (1, 20)
    assert np.ptp(mesh.points, axis=0).tolist() == [10.0, 10.0, 10.0]
    assert len(mesh.faces("floor")) == 1
    with refused(fc.InputError, "unknown-part", "'one'"):
        fc.read_mesh(path, reader=reader, part="one")


def test_what_it_returns_is_checked(path) -> None:
    with refused(fc.InputError, "input", "tuple"):
        fc.read_mesh(path, reader=lambda file: (CORNERS, []))  # type: ignore[arg-type, return-value]
    broken = RawMesh(CORNERS, [("hex8", np.array([[0, 1, 2, 3, 4, 5, 6, 9]]))])
    with refused(fc.MeshError, "unknown-point", "point 9", "are 8"):
        fc.read_mesh(path, reader=lambda file: broken)


def test_an_unknown_type_names_the_way_out(tmp_path) -> None:
    with refused(fc.InputError, "unknown-file-type", "'.mine'"):
        fc.read_mesh(tmp_path / "cube.mine")
