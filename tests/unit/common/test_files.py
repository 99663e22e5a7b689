"""Files are replaced whole or not at all, by one writer at a time."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.common.files import append_row, read_rows, replacing, sole_writer, write_atomically

FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")


def held_block() -> fc.ContactResult:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    return fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.01}})


def half_written(path: Path, error: BaseException) -> None:
    with replacing(path) as file:
        file.write_text("half")
        raise error


def test_an_error_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "figures.txt"
    write_atomically(path, "old")
    for error, caught in ((OSError(28, "No space left on device"), fc.InputError), (KeyboardInterrupt(), None)):
        with pytest.raises(caught or KeyboardInterrupt) as found:
            half_written(path, error)
        assert path.read_text() == "old"
        assert caught is None or "The file that was there is unchanged" in str(found.value)
    assert os.listdir(tmp_path) == ["figures.txt"]


@FULL
@pytest.mark.parametrize("suffix", [".vtu", ".csv", ".json", ".png"])
def test_a_full_disk_is_an_error_of_the_package(suffix: str, tmp_path: Path) -> None:
    """A link to a full device stands for a full disk; nothing is left beside it."""
    path = tmp_path / f"result{suffix}"
    path.symlink_to("/dev/full")
    result = held_block()
    with refused(fc.InputError, "cannot-write", "No space left on device"):
        result.plot("pressure", path) if suffix == ".png" else result.save(path)
    assert os.listdir(tmp_path) == [path.name]


def test_rows_do_not_run_into_each_other(written) -> None:
    path = written('{"name": "a"}', "rows.jsonl")
    assert read_rows(path, "name", "a row") == {"a": {"name": "a"}}
    append_row(path, {"name": "b"})
    assert list(read_rows(path, "name", "a row")) == ["a", "b"]


@FULL
def test_rows_are_not_read_from_a_device() -> None:
    with refused(fc.InputError, "input", "pipe or a device"):
        read_rows("/dev/full", "name", "a row")
    with refused(fc.InputError, "cannot-write", "/dev/full"):
        append_row("/dev/full", {"name": "a"})


def test_one_process_writes_to_a_file(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    lock = tmp_path / ".rows.jsonl.lock"
    with sole_writer(path):
        assert lock.exists()
        with refused(fc.InputError, "file-in-use", str(os.getpid())), sole_writer(path):
            pass
    assert not lock.exists()
    gone = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True)
    lock.write_text(gone.stdout.decode())
    with sole_writer(path):
        assert lock.read_text() == str(os.getpid())
    lock.write_text("1")  # runs always
    with refused(fc.InputError, "file-in-use", "Process 1"), sole_writer(path):
        pass


def test_arrays_of_the_caller_stay_writable() -> None:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    points, cells = np.array(mesh.points), np.array(mesh.cells)
    copy = fc.Mesh(points, cells)
    points += 1.0
    cells[:] = 0
    np.testing.assert_array_equal(copy.points, mesh.points)
    np.testing.assert_array_equal(copy.cells, mesh.cells)
