"""Bad input through every door: arguments, scene files, files of meshes and maps, the command line.

Each ends in an answer or in a sentence of the package: no other error, no hang, no file half written.
"""

from __future__ import annotations

import contextlib
import json
import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from bad_values import BAD, Outcome, outcome
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from public_calls import Call, public_calls
from sample_files import TOML, damaged, sample_files

import fecontact as fc
from fecontact.app.cli import main

#: One in so many values of the table is tried for each argument or option, another one for the next; by day and else.
STRIDE = {"day": 9, "all": 3}
#: Damaged copies of each sample.
COPIES = 16
#: Address space (bytes) that bad input may ask for.
SPACE = 8 << 30


@pytest.fixture(scope="module", autouse=True)
def bounded_memory() -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (SPACE, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.fixture(scope="module")
def calls(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Call]:
    return public_calls(tmp_path_factory.mktemp("calls"))


def named(bad: dict[str, Outcome]) -> str:
    return "\n".join(f"{where}: {o.kind}: {o.words}" for where, o in bad.items())


def test_the_calls_of_the_table_are_valid(calls: dict[str, Call]) -> None:
    without_file = {"mesh_solid"}
    found = {name: outcome(call) for name, call in calls.items() if name not in without_file}
    assert not (bad := {name: o for name, o in found.items() if o.kind != "accepted"}), named(bad)


@pytest.mark.by_day("day")
@pytest.mark.parametrize("often", STRIDE)
def test_every_bad_value_of_every_argument(
    often: str, calls: dict[str, Call], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    bad: dict[str, Outcome] = {}
    count, turn = 0, 0
    for name, call in calls.items():
        for argument in call.arguments:
            turn += 1
            for label in list(BAD)[turn % STRIDE[often] :: STRIDE[often]]:
                found = outcome(lambda call=call, argument=argument, label=label: call(**{argument: BAD[label]}))
                count += 1
                if not found.is_good or (found.kind == "python" and "unhashable" not in found.words):
                    bad[f"{name}({argument}={label})"] = found
    assert count > 18_000 / STRIDE[often]
    assert not bad, named(bad)
    assert not list(tmp_path.glob(".*.part*"))


def test_an_unknown_keyword_is_named(calls: dict[str, Call]) -> None:
    found = {name: outcome(lambda call=call: call(frction=0.3)) for name, call in calls.items()}
    assert not (bad := {name: o for name, o in found.items() if "frction" not in o.words}), named(bad)
    assert not (bad := {name: o for name, o in found.items() if not o.is_good}), named(bad)


def test_damaged_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "whole").mkdir()
    bad: dict[str, Outcome] = {}
    for name, (path, read) in sample_files(tmp_path / "whole").items():
        assert (first := outcome(lambda read=read, path=path: read(path))).kind == "accepted", (name, first)
        copy = tmp_path / f"copy{path.suffix}"
        for k, data in enumerate(damaged(path.read_bytes(), np.random.default_rng(1), COPIES)):
            copy.write_bytes(data)
            found = outcome(lambda read=read, copy=copy: read(copy))
            if not found.is_good:
                bad[f"{name} {k}"] = found
    assert not bad, named(bad)


CRAFTED = {
    "itself.inp": "*INCLUDE, INPUT=itself.inp\n",
    "still.inp": "*NODE\n1,0,0,0\n*NSET, NSET=A, GENERATE\n1, 5, 0\n",
    "far.inp": "*NODE\n1,0,0,0\n*NSET, NSET=A, GENERATE\n1, 100000000000, 1\n",
    "many.off": "OFF\n99999999999 99999999999 0\n0 0 0\n",
    "many.ply": "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n0\n",
    "bits.ply": "ply\nformat binary_little_endian 1.0\nelement vertex 99999999\nproperty double x\nend_header\n0",
    "nan.stl": "solid a\nfacet\nouter loop\nvertex NaN 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n",
    "zero.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
    "word.obj": "v a b c\nf 1 2 3\n",
    "deep.toml": "a = " + "[" * 20000 + "]" * 20000,
    "digits.toml": "a = " + "9" * 10000,
    "bomb.feb": '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "' + "c" * 99 + '">]><febio_spec version="2.5">&b;',
    "hole.msh": "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999\n1 0 0 0\n$EndNodes\n",
    "empty.vtu": "",
}


@pytest.mark.parametrize("name", CRAFTED)
def test_crafted_files(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(CRAFTED[name], encoding="utf-8")
    read = {".off": fc.read_surface, ".ply": fc.read_surface, ".stl": fc.read_surface, ".obj": fc.read_surface}
    found = outcome(lambda: read.get(path.suffix, fc.read_scene if path.suffix == ".toml" else fc.read_mesh)(path))
    assert found.kind == "refused", found


@pytest.mark.parametrize(
    "array", [np.ones((4, 4)) * 1j, np.array([["a", "b"]] * 2), np.zeros(3), np.full((2, 2), np.nan)]
)
def test_arrays_that_are_no_heights(array: np.ndarray, tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", array)
    found = outcome(lambda: fc.RigidBody.from_heights(fc.surfaces.read_topography(tmp_path / "map.npy").z, (1.0, 1.0)))
    assert found.kind == "refused", found


def test_a_header_of_more_numbers_than_a_file_holds(tmp_path: Path) -> None:
    """As from a copy that broke off: refused by its size, not by the memory it asks for."""
    path = tmp_path / "huge.npy"
    head = b"\x93NUMPY\x01\x00v\x00" + b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000, 1000000), }"
    path.write_bytes(head.ljust(127) + b"\n" + bytes(64))
    found = outcome(lambda: fc.surfaces.read_topography(path))
    assert found.kind == "refused", found


numbers = st.one_of(st.floats(), st.integers(), st.sampled_from([0, -1, 1e308, 1e-320, 10**400]))
anything = st.recursive(
    st.one_of(st.none(), st.booleans(), numbers, st.text(max_size=5)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=3), inner, max_size=2)),
    max_leaves=6,
)
quick = settings(
    max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck), database=None
)


@quick
@given(data=st.data())
def test_anything_as_any_argument(calls: dict[str, Call], data: st.DataObject) -> None:
    call = calls[data.draw(st.sampled_from(sorted(calls)))]
    argument = data.draw(st.sampled_from(sorted(call.arguments)))
    value = data.draw(anything)
    found = outcome(lambda: call(**{argument: value}))
    assert found.is_good, found


def keys(table: object, place: tuple[object, ...] = ()) -> Iterator[tuple[object, ...]]:
    """Places of all values in a table of tables and lists."""
    parts = table.items() if isinstance(table, dict) else enumerate(table) if isinstance(table, list) else ()
    for key, value in parts:
        yield (*place, key)
        yield from keys(value, (*place, key))


@quick
@given(data=st.data())
def test_anything_in_a_scene_file(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_text(TOML, encoding="utf-8")
    value = data.draw(anything)

    def change(values: dict) -> None:
        copy = json.loads(json.dumps(values))
        place = data.draw(st.sampled_from(sorted(keys(copy), key=repr)))
        table = copy
        for key in place[:-1]:
            table = table[key]
        table[place[-1]] = value
        values.clear()
        values.update(copy)

    found = outcome(lambda: fc.read_scene(path, change=change))
    assert found.is_good, found


WORDS = ["nan", "1e400", "-1", "0", "x", "", "1e-320", "/dev/full", "a\0b", "9" * 400]
OPTIONS = {
    "halfspace sphere --E 1 --nu 0 --radius 1 --force 0.01 --cells 16": (
        "E nu radius force cells size layer against load-point loads tolerance json csv plot units approach moment"
    ),
    "halfspace rough --E 1 --hurst 0.8 --rms-height 0.01 --size 1 --cells 16 --force 0.01 --periodic": (
        "hurst rms-height rms-slope seed longest shortest trend file size cells"
    ),
    "solve scene.toml": "accuracy json out engine ranks",
    "view scene.toml": "field out scale",
    "explain scene.toml": "json",
}


@pytest.mark.by_day("day")
@pytest.mark.parametrize("often", STRIDE)
def test_bad_options_of_commands(often: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(TOML, encoding="utf-8")
    bad: dict[str, Outcome] = {}
    turn = 0
    for command, options in OPTIONS.items():
        for option in options.split():
            turn += 1
            for word in WORDS[turn % STRIDE[often] :: STRIDE[often]]:
                words = [*command.split(), f"--{option}", word]

                def run(words: list[str] = words) -> None:
                    with contextlib.suppress(SystemExit):  # of argparse
                        assert main(words) in (0, 2)

                if not (found := outcome(run)).is_good:
                    bad[" ".join(words[-2:]) + f" of {command[:20]}"] = found
    assert not bad, named(bad)
    assert not list(tmp_path.glob(".*.part*"))
