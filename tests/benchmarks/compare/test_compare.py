"""Comparison of methods: registry, errors, resuming, orders, other programs, the command line."""

import csv
import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from compare import machine, run
from compare.__main__ import main
from compare.methods import METHODS, default_variants, variant
from compare.peers import find_peers
from compare.precision import against_peers, cheapest, quickest, sentence
from compare.problems import PROBLEMS, problem
from compare.run import Plan, compare
from compare.table import order

QUICK = Plan("hertz", ("half-space",), refinements=2, repeats=1)

ADAPTER = """
import json, sys
if sys.argv[1] == "--about":
    print("loading ...")
    about = {"method": "Other", "kind": "half-space", "version": "1.0", "problems": ["hertz"], "settings": [8, 16]}
    print(json.dumps(about))
else:
    n = int(sys.argv[2])
    print(json.dumps({"dofs": n * n, "errors": {"pressure_l2": 0.1 / n}, "seconds": 0.5 * n, "peak_mb": 10.0}))
"""


def row(method="a", seconds=1.0, error=0.01, **more):
    base = {"method": method, "kind": "solid", "peer": False, "failed": None, "dofs": 100, "repeats": 1}
    return {**base, "seconds": seconds, "errors": {"pressure_l2": error}, **more}


@pytest.mark.parametrize("name", PROBLEMS)
def test_every_problem_has_methods_and_its_pressure_carries_its_force(name):
    which = problem(name)
    assert len(default_variants(name)) >= 4
    a, b = which.semi_axes
    # Gauss's rule in the angle of r = a sin(t), for which half ellipsoids and edges 1/sqrt are smooth
    t, w = np.polynomial.legendre.leggauss(60)
    t, w = (t + 1) * np.pi / 4, w * np.pi / 4
    if math.isinf(b):
        total = 2 * a * (w * np.cos(t)) @ which.pressure(a * np.sin(t), 0 * t)
    else:
        total = 2 * np.pi * a * b * (w * np.cos(t) * np.sin(t)) @ which.pressure(a * np.sin(t), 0 * t)
    # the rule's own error; the layer's pressure is a series of its own
    assert abs(total / which.force - 1) < 1e-6


@pytest.mark.parametrize("name", PROBLEMS)
def test_exact_pressure_has_no_error(name):
    which = problem(name)
    x = (np.arange(400) + 0.5) / 400 * 1.5 * which.semi_axes[0]
    points = np.stack([x, 0 * x], axis=1)
    exact = np.where(x < which.semi_axes[0], which.pressure(np.minimum(x, 0.999 * which.semi_axes[0]), 0 * x), 0.0)
    errors = which.errors(points, exact, np.ones(400) if math.isinf(which.semi_axes[1]) else x)
    # the layer's table and the last cells below the edge
    assert abs(errors["pressure_l2"]) < 1e-2
    assert abs(errors.get("edge_radius", 0.0)) < 1e-3
    assert abs(which.centre_error(points, exact)) < 1e-12


@pytest.mark.by_day("hertz-symmetric-0.035", "line-plane-0.035", "punch-half-space-0.035")
@pytest.mark.parametrize(
    ("name", "spec", "most"),
    [
        # what each is known to reach at its coarsest: rings 4 %, cells h/a, springs by their model
        ("hertz", "symmetric", 0.035),
        ("unequal", "half-space", 0.02),
        ("ellipse", "hex20", 0.035),
        ("hertz", "hex20-root", 0.002),
        ("ellipse", "hex20-root", 0.005),
        ("ellipse", "boussinesq", 0.1),
        ("hertz", "axisymmetric", 0.035),
        ("line", "hex20", 0.035),
        ("line", "plane", 0.035),
        ("line", "ancf", 0.05),
        ("layer", "hex20", 0.035),
        ("layer", "half-space", 0.035),
        ("layer", "local", 0.015),
        ("hertz", "local", 0.02),
        ("layer", "winkler", 0.1),
        ("punch", "hex20", 0.1),
        ("punch", "half-space", 0.035),
    ],
)
def test_methods_solve_their_problems(name, spec, most):
    chosen = variant(spec, name)
    found = chosen.method.run(problem(name), chosen.method.settings[0], chosen.options)
    assert abs(found.errors["pressure_l2"]) < most
    assert abs(found.residual) < 1e-7
    assert found.dofs > 0


def test_registry_is_complete():
    assert {"hex8", "hex20", "hex20-plain", "hex27", "tet10", "symmetric"} <= set(METHODS)
    assert {"half-space", "boussinesq", "winkler", "ancf", "axisymmetric", "plane"} <= set(METHODS)
    for name, method in METHODS.items():
        assert method.name == name
        assert set(method.problems) <= set(PROBLEMS)
        assert json.loads(json.dumps(method.settings)) == list(method.settings)


@pytest.mark.full
def test_options_of_a_variant_reach_the_solution():
    plain, mortar = (variant(s, "hertz") for s in ("hex20", "hex20:coupling=mortar"))
    a, b = (v.method.run(problem("hertz"), 1, v.options).errors["pressure_l2"] for v in (plain, mortar))
    assert abs(a - b) > 1e-4
    assert mortar.spec == "hex20:coupling=mortar"


@pytest.mark.full
def test_finished_runs_are_kept_and_a_cut_line_is_run_again(tmp_path):
    path = tmp_path / "rows.jsonl"
    first = compare(QUICK, path)
    assert [r["dofs"] for r in first] == [1024, 4096]
    lines = path.read_text().splitlines(keepends=True)
    kept = json.loads(lines[0])
    kept["seconds"] = 12.5  # a mark by which a kept row is known again
    path.write_text(json.dumps(kept) + "\n" + lines[1][:40])
    again = compare(QUICK, path)
    assert again[0]["seconds"] == 12.5
    assert again[1]["dofs"] == 4096
    assert len(path.read_text().splitlines()) == 2


@pytest.mark.full
def test_runs_with_other_threads_are_others(tmp_path):
    path = tmp_path / "rows.jsonl"
    for threads in (1, 2):
        compare(Plan("hertz", ("half-space",), refinements=1, repeats=1, threads=threads), path)
    assert [json.loads(line)["threads"] for line in path.read_text().splitlines()] == [1, 2]


@pytest.mark.full
def test_runs_of_other_code_repeats_or_adapters_are_others(tmp_path, monkeypatch):
    path, folder = tmp_path / "rows.jsonl", tmp_path / "peers"
    folder.mkdir()
    (folder / "other.py").write_text(ADAPTER)
    plan = Plan("hertz", ("half-space",), refinements=1, repeats=1)

    def runs(plan=plan):
        """What was run, ours and the other program's: a kept row has the mark that it was given."""
        rows = compare(plan, path, find_peers(folder, sys.executable)[0])
        new = [r["peak_mb"] > 0 for r in rows]
        lines = [json.dumps(json.loads(line) | {"peak_mb": -1.0}) for line in path.read_text().splitlines()]
        path.write_text("\n".join(lines) + "\n")
        return new

    assert runs() == [True, True]
    assert runs() == [False, False]
    assert runs(replace(plan, repeats=2)) == [True, True]
    monkeypatch.setattr(run, "code", lambda: "of tomorrow")
    assert runs() == [True, False]
    (folder / "other.py").write_text(ADAPTER.replace('"1.0"', '"1.1"'))
    assert runs() == [False, True]
    (folder / "other.py").write_text(ADAPTER.replace("0.1 / n", "0.2 / n"))
    assert runs() == [False, True]
    (folder / "_shared.py").write_text("R = 2\n")
    assert runs() == [False, True]


@pytest.mark.full
def test_a_slow_method_is_not_refined():
    rows = compare(Plan("hertz", ("half-space",), repeats=1, enough=1e-6))
    assert len(rows) == 1


def test_failed_run_says_why():
    (found,) = compare(Plan("hertz", ("half-space",), refinements=1, repeats=1, patience=0.01))
    assert "longer than 0.01 s" in found["failed"]
    assert "none" in sentence([found])


def test_order_is_found_again():
    rows = [row(dofs=n**3, seconds=float(n), error=0.3 / n**2) for n in (2, 3, 5, 8)]
    assert abs(order(rows, "seconds") - 2) < 1e-12
    assert abs(order(rows, "dofs") - 2 / 3) < 1e-12
    assert math.isnan(order(rows[:1], "dofs"))


def test_cheapest_is_a_measured_run_within_the_error():
    rows = [row("a", 1.0, 0.02), row("a", 4.0, 0.004), row("b", 0.1, 0.2), row("b", 2.0, 0.009)]
    assert cheapest(rows, 0.05)["seconds"] == 1.0
    assert cheapest(rows, 0.01)["method"] == "b"
    assert cheapest(rows, 1e-3) is None
    text = sentence(rows)
    assert "5 %, a (1 s, 2 %)" in text
    assert "0.1 %, none (the least is a (4 s, 0.4 %))" in text


def test_seconds_between_runs_follow_a_power_law():
    rows = [row("a", 1.0, 0.04), row("a", 4.0, 0.01), row("b", 9.0, 0.001)]
    method, seconds = quickest(rows, 0.02)
    assert method == "a"
    assert abs(seconds - 2.0) < 1e-12  # error ~ 1 / seconds
    assert quickest(rows, 0.005) == ("b", 9.0)
    assert quickest(rows, 1e-4) is None


def test_ratio_to_other_programs():
    rows = [row("ours", 0.5, 0.01), row("peer", 10.0, 0.012, peer=True)]
    assert "20 times" in against_peers(rows)
    rows[1]["errors"]["pressure_l2"] = 0.1
    assert "no other program reached" in against_peers(rows)


@pytest.mark.full
def test_adapters_are_run_and_absent_ones_named(tmp_path):
    (tmp_path / "other.py").write_text(ADAPTER)
    (tmp_path / "missing.py").write_text("import no_such_program_at_all\n")
    peers, absent = find_peers(tmp_path, sys.executable)
    assert [p.method for p in peers] == ["Other"]
    assert len(absent) == 1
    assert "no_such_program_at_all" in absent[0]
    rows = compare(Plan("hertz", ("half-space",), refinements=1, repeats=1), peers=peers)
    assert [r["peer"] for r in rows] == [False, True]
    assert rows[1]["method"] == "Other 1.0"
    assert rows[1]["dofs"] == 64


@pytest.mark.full
def test_command_line_writes_all_files(tmp_path, capsys):
    (tmp_path / "peers").mkdir()
    published = [{"problem": "hertz", "program": "Elsewhere", "method": "Elsewhere", "source": "a table", "dofs": 1e4}]
    published[0] |= {"seconds": 3.0, "errors": {"pressure_l2": 0.03}}
    (tmp_path / "peers" / "published.json").write_text(json.dumps(published))
    out = tmp_path / "out"
    command = ["hertz", "--methods", "half-space", "boussinesq", "--refinements", "2", "--repeats", "1"]
    command += ["--out", str(out), "--peers", str(tmp_path / "peers")]
    assert main(command) == 0
    shown = capsys.readouterr().out
    assert "The cheapest by pressure error" in shown
    assert (out / "compare_hertz.png").read_bytes()[:4] == b"\x89PNG"
    page = (out / "compare_hertz.md").read_text()
    assert "![" in page
    assert "Elsewhere" in page
    data = json.loads((out / "compare_hertz.json").read_text())
    assert len(data["rows"]) == 4
    with (out / "compare_hertz.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["magic"], "no problem 'magic'"),
        (["hertz", "--methods", "hex21"], "no method 'hex21'"),
        (["line", "--methods", "tet10"], "does not solve 'line'"),
        (["hertz", "--methods", "hex20:colour=red"], "no option 'colour=red'"),
        (["hertz", "--methods", "hex20:coupling=glue"], "must be one of auto, nodal, mortar"),
        (["hertz", "--repeats", "0"], "repeats must be at least 1"),
        (["hertz", "--refinements", "0"], "refinements must be at least 1"),
        (["hertz", "--threads", "0"], "threads must be at least 1"),
        (["hertz", "--enough", "0"], "positive number of seconds"),
        (["hertz", "--methods", "half-space", "--peers", "no/such/folder"], "no folder"),
        (["hertz", "--methods", "half-space", "--plot", "no/such/folder/x.png"], "does not exist"),
    ],
)
def test_bad_input_is_explained_before_any_run(arguments, message, capsys):
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


def test_a_file_of_something_else_is_not_touched(tmp_path):
    path = tmp_path / "notes.jsonl"
    path.write_text("not rows\n{}\n")
    with refused(fc.InputError, "bad-line", "a row of a comparison"):
        compare(QUICK, path)
    assert path.read_text() == "not rows\n{}\n"


def test_the_sources_of_every_room_are_part_of_the_code(monkeypatch):
    read = []
    monkeypatch.setattr(machine, "fingerprint", lambda files: read.extend(name for name, _ in files))
    machine.code.__wrapped__()
    assert {Path(name).parts[0] for name in read} >= {"common", "mesh", "solvers", "scene", "app"}


def test_the_code_is_told_apart_by_what_it_says(monkeypatch):
    now = machine.code()
    assert machine.code() == now
    machine.code.cache_clear()
    monkeypatch.setattr(machine.Path, "read_bytes", lambda self: b"changed")
    assert machine.code() != now
    machine.code.cache_clear()
