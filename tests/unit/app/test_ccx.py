"""Decks beside CalculiX: its results files, the comparison, and the command, where it is installed."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.decks.ccx import (
    STIFFER,
    FrdField,
    _in_full,
    _of_faces,
    _small,
    _stiffened,
    beside_ccx,
    check_ccx,
    compared,
    read_frd,
)
from fecontact.mesh.formats.abaqus_deck import KeywordSection
from tests.deck_text import blocks, deck_of, step

HELD = "*BOUNDARY\nLOW_bottom, 1, 3\nUP_top, 1, 2\n"
DOWN = "*BOUNDARY\nUP_top, 3, 3, -0.05\n"
LINEAR = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n500.,\n"


def block_of(name: str, heads: list[str], rows: dict[int, list[float]]) -> str:
    """A block of a results file as ccx writes it."""
    out = f"  100CL  101 1.000000000{len(rows):12d}                     0    1           1\n"
    out += f" -4  {name:<8}{len(heads):5d}    1\n"
    out += "".join(f" -5  {head:<8}    1    2    1    0{'    1ALL' * (head == 'ALL')}\n" for head in heads)
    for node, values in rows.items():
        out += f" -1{node:10d}" + "".join(f"{value:12.5E}" for value in values[:6]) + "\n"
        if values[6:]:
            out += " -2" + " " * 10 + "".join(f"{value:12.5E}" for value in values[6:]) + "\n"
    return out + " -3\n"


MOVED = ["D1", "D2", "D3", "ALL"]
PRESSED = ["COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2"]


def test_fields_of_the_last_time_are_read(tmp_path) -> None:
    path = tmp_path / "deck.frd"
    first = block_of("DISP", MOVED, {1: [9.0, 9.0, 9.0]})
    wide = block_of("OTHER", [f"C{k}" for k in range(8)], {1: [float(k) for k in range(8)]})
    last = block_of("DISP", MOVED, {1: [1.0, -2.0, 3e-12], 1234567890: [-1.5e-31, 0.0, -1e30]})
    contact = block_of("CONTACT", PRESSED, {7: [0.0, 0.0, 0.0, 4.5, 0.0, 0.0]})
    path.write_text("    1C\n" + first + wide + last + contact + " 9999\n")
    found = read_frd(path)
    assert sorted(found) == ["CONTACT", "DISP"]
    assert found["DISP"].nodes.tolist() == [1, 1234567890]
    assert found["DISP"].values.tolist() == [[1.0, -2.0, 3e-12], [-1.5e-31, 0.0, -1e30]]
    assert found["CONTACT"].values[0, 3] == 4.5


def test_files_that_are_cut_off_are_refused(tmp_path) -> None:
    path = tmp_path / "deck.frd"
    whole = block_of("DISP", MOVED, {1: [1.0, 2.0, 3.0], 2: [1.0, 2.0, 3.0]})
    path.write_text(whole.replace(" -3\n", ""))
    with refused(fc.InputError, "frd", "ends within DISP"):
        read_frd(path)
    path.write_text(whole.replace(" 3.00000E+00\n -3", "\n -3"))
    with refused(fc.InputError, "frd", "rows of 3 numbers"):
        read_frd(path)


def test_figures_are_of_the_same_nodes_and_forces(written) -> None:
    """Of a result's own displacements nothing differs; with one moved by 1 % of the largest, that is said."""
    path = written(deck_of(blocks(), step(DOWN), HELD), "blocks.inp")
    result = fc.read_scene(path).solve()
    bodies = result.scene.bodies
    nodes = np.concatenate([b.mesh.file_nodes for b in bodies])
    u = np.concatenate([result.displacement(b) for b in bodies])
    order = np.random.default_rng(1).permutation(len(nodes))
    forces = np.zeros_like(u)
    force = result.contacts[0].total_force
    forces[0, 2], forces[-1, 2] = force, -force
    pressure = np.zeros((1, 6))
    pressure[0, 3] = 2 * result.contacts[0].max_pressure
    fields = {"DISP": FrdField(nodes[order], u[order]), "FORC": FrdField(nodes, forces)}
    same = compared(result, {**fields, "CONTACT": FrdField(nodes[:1], pressure)}, 3.0)
    rows = {name: (ours, theirs) for name, ours, theirs in same.rows}
    assert set(same.apart.values()) == {0.0}
    assert rows["largest pressure"][1] == 2 * rows["largest pressure"][0]
    assert rows["seconds"][1] == 3.0
    for name in ("LOW", "UP"):
        assert abs(rows[f"contact force on {name}"][0] - force) <= 1e-12 * force
        assert abs(rows[f"contact force on {name}"][1] - force) <= 1e-12 * force
    assert "+100.000 %" in str(same)
    u[-1, 0] += 0.01 * 0.05
    other = compared(result, {"DISP": FrdField(nodes, u)}, 3.0)
    assert other.apart["LOW"] == 0
    assert abs(other.apart["UP"] - 0.01) <= 1e-4


def test_where_it_cannot_run_that_is_said(tmp_path, written, monkeypatch, capsys) -> None:
    path = written(deck_of(blocks(), step(DOWN), HELD), "blocks.inp")
    with refused(fc.InputError, "not-a-deck", ".feb"):
        check_ccx(path.with_suffix(".feb"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with refused(fc.MissingPackageError, "missing-package", "calculix-ccx"):
        check_ccx(path)
    assert main(["solve", str(path), "--beside", "ccx"]) == 2
    assert "calculix-ccx" in capsys.readouterr().err
    program = written("#!/bin/sh\necho '*ERROR reading: no such set'\nexit 201\n", "ccx")
    program.chmod(0o755)
    assert check_ccx(path) == str(program)
    with refused(fc.SolverError, "ccx-failed", "status 201", "no such set"):
        beside_ccx(path, fc.read_scene(path).solve())


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
@pytest.mark.parametrize("friction", ["", "*FRICTION\n0.3, 1e5\n"])
def test_a_deck_with_an_included_file_beside_ccx(friction, tmp_path, written, capsys) -> None:
    text = deck_of(blocks("hex20", "hex20"), step(DOWN), HELD, friction, LINEAR)
    text = text.replace("INTERACTION=I\n", "INTERACTION=I, TYPE=SURFACE TO SURFACE\n")
    (tmp_path / "held.inc").write_text(HELD)
    path = written(text.replace(HELD, "*INCLUDE, INPUT=held.inc\n"), "blocks.inp")
    picture = tmp_path / "both.png"
    asked = ["--beside", "ccx", "--beside-plot", str(picture), "--json", str(tmp_path / "figures.json")]
    assert main(["solve", str(path), *asked]) == 0
    assert picture.stat().st_size > 10_000
    assert main(["solve", str(path), "--beside-plot", str(picture)]) == 2
    assert "Beside CalculiX" in capsys.readouterr().out
    figures = json.loads((tmp_path / "figures.json").read_text())["beside_ccx"]
    force = figures["contact force on LOW"]
    # another quadrature of the overlap, and with friction an elastic slip of a hundredth of K
    assert abs(force["ccx"] / force["fecontact"] - 1) <= (1e-4 if not friction else 2e-3)
    assert max(figures["displacements_apart"].values()) <= (2e-3 if not friction else 1e-2)
    assert abs(figures["largest pressure"]["ccx"] / figures["largest pressure"]["fecontact"] - 1) <= 0.05


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_the_last_case_is_compared(tmp_path, capsys) -> None:
    """A step that removes the contact again is left out here, and with it in ccx."""
    path = tmp_path / "steps.inp"
    removed = "*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\nUP_face_bottom, LOW_face_top\n"
    deeper = DOWN.replace("0.05", "0.002")
    steps = step(DOWN.replace("0.05", "0.001")) + step(deeper) + step(removed)
    text = deck_of(blocks(), steps, HELD, "", LINEAR.replace("500.", "1.E5"))
    path.write_text(text.replace("INTERACTION=I\n", "INTERACTION=I, TYPE=SURFACE TO SURFACE\n"))
    assert main(["solve", str(path), "--beside", "ccx", "--json", str(tmp_path / "figures.json")]) == 0
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert len(figures["cases"]) == 2
    found = figures["beside_ccx"]
    assert found["largest displacement of UP"]["fecontact"] == pytest.approx(0.002, rel=1e-9)
    assert max(found["displacements_apart_alike"].values()) <= 2e-3
    force = found["contact force on LOW"]
    assert force["ccx_alike"] == pytest.approx(force["fecontact"], rel=2e-3)


def test_the_second_run_solves_what_is_solved_here() -> None:
    def one(keyword, *lines, **parameters):
        return KeywordSection(keyword, parameters, list(lines), "a.inp")

    behaviour = [
        one("SURFACE BEHAVIOR", "1e4, 3."),
        one("SURFACE BEHAVIOR", "1e4, 3.", **{"PRESSURE-OVERCLOSURE": "LINEAR"}),
        one("SURFACE BEHAVIOR", "1, 2", "3, 4", **{"PRESSURE-OVERCLOSURE": "TABULAR"}),
        one("FRICTION", ".2, 1e2"),
        one("FRICTION", ".2, 1e9"),
        one("FRICTION", ".2"),
        one("FRICTION", ROUGH=""),
    ]
    stiff = [s.lines[0] if s.lines else "" for s in _stiffened(behaviour, 100.0, soft=False)]
    assert stiff == ["250000", "500000, 3.", "1, 2", ".2,250000", ".2,50000000000", ".2,250000", ""]
    assert [s.lines[0] if s.lines else "" for s in _stiffened(behaviour, 100.0, soft=True)] == ["1e4, 3."] * 2 + stiff[
        2:
    ]
    kinds = [s.parameters["TYPE"] for s in _in_full([one("ELEMENT", TYPE=t) for t in ("C3D20R", "cps8r", "CPE4")])]
    assert kinds == ["C3D20", "cps8", "CPE4"]
    assert [s.parameters for s in _small([one("STEP", NLGEOM="", INC="9"), one("STATIC")])] == [{"INC": "9"}, {}]
    nodes = {"TYPE": "NODE TO SURFACE", "SMALL SLIDING": ""}
    pairs = [
        one("SURFACE", "1, S1", NAME="Of faces"),
        one("SURFACE", "1", NAME="Of nodes", TYPE="NODE"),
        one("SURFACE INTERACTION", NAME="Hard"),
        one("SURFACE BEHAVIOR", **{"PRESSURE-OVERCLOSURE": "HARD"}),
        one("SURFACE INTERACTION", NAME="Table"),
        one("SURFACE BEHAVIOR", "1, 2", **{"PRESSURE-OVERCLOSURE": "TABULAR"}),
        one("CONTACT PAIR", "of faces, other", INTERACTION="hard", **nodes),
        one("CONTACT PAIR", "of nodes, other", INTERACTION="hard", **nodes),
        one("CONTACT PAIR", "of faces, other", INTERACTION="table", **nodes),
    ]
    assert [s.parameters for s in _of_faces(pairs)[-3:]] == [
        {"INTERACTION": "hard", "TYPE": "SURFACE TO SURFACE"},
        {"INTERACTION": "hard", **nodes},
        {"INTERACTION": "table", **nodes},
    ]


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_rigid_motions_that_nothing_determines_are_held_there_and_not_compared(tmp_path) -> None:
    """A column of two parts that are tied, pulled by hand at both ends, free along its axis: by F h / (E A)."""
    path = tmp_path / "tied.inp"
    held = "*BOUNDARY\nLOW_x_min, 1, 1\nLOW_y_min, 2, 2\nUP_x_min, 1, 1\nUP_y_min, 2, 2\n"
    pull = "*CLOAD\nLOW_bottom, 3, -1.\nUP_top, 3, 1.\n"
    text = deck_of(blocks(divisions=((1, 1, 1), (1, 1, 1))), step(pull), held)
    text = text.replace("*CONTACT PAIR, INTERACTION=I\n", "*TIE, NAME=T\n").replace(", 0.3\n", ", 0.\n")
    path.write_text(text)
    result = fc.read_scene(path).solve()
    body = result.scene.bodies[0]
    assert abs(np.ptp(result.displacement(body)[:, 2]) - 4 * 2 / 100) <= 1e-12
    found = beside_ccx(path, result)
    assert found.changes == "held where nothing resists"
    # six digits of its displacements
    assert max(found.alike_apart.values()) <= 1e-5


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_what_the_penalty_of_ccx_costs_is_shown(tmp_path) -> None:
    """Blocks of one cell, pressed by a motion d: hard, the force is E d / 2; by a penalty K of the area it is
    d / (2 / E + 1 / K), E / (2 K) lower. A step of frequencies after it changes nothing.
    """
    E, K, d = 100.0, 2e4, 1e-4
    behaviour = f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{K}, 3.\n"
    held = "*BOUNDARY\nLOW_bottom, 3, 3\nUP_top, 1, 2\nLOW_x_min, 1, 1\nLOW_y_min, 2, 2\n"
    path = tmp_path / "column.inp"
    frequencies = step("", "*STEP, PERTURBATION\n", "*FREQUENCY\n1\n")
    text = deck_of(
        blocks(divisions=((1, 1, 1), (1, 1, 1))), step(f"*BOUNDARY\nUP_top, 3, 3, {-d}\n"), held, "", behaviour
    )
    text = text.replace(f"{E}, 0.3", f"{E}, 0.").replace(
        "*SOLID SECTION, ELSET=LOW", "*DENSITY\n1.\n*SOLID SECTION, ELSET=LOW"
    )
    text = text.replace("INTERACTION=I\n", "INTERACTION=I, TYPE=SURFACE TO SURFACE\n")
    path.write_text(text + frequencies)
    result = fc.read_scene(path).solve()
    found = beside_ccx(path, result)
    rows = {name: (ours, theirs) for name, ours, theirs in found.rows}
    hard, soft = rows["contact force on LOW"]
    assert abs(hard - E * d / 2) <= 1e-9 * hard
    # geometric nonlinearity of ccx: strains of 5e-5; six digits of its forces
    assert abs(soft / hard - 1 / (1 + E / (2 * K))) <= 1e-4
    assert abs(found.alike["contact force on LOW"] / hard - 1 / (1 + E / (2 * K * STIFFER))) <= 1e-4
    assert "Alike: penalties x 50" in str(found)
    assert found.as_dict()["contact force on LOW"]["ccx_alike"] == found.alike["contact force on LOW"]
