"""Decks whose cells are divided: the same question on a finer mesh."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.decks.ccx import _text
from fecontact.app.decks.divided import divided_deck
from fecontact.mesh.formats.abaqus_deck import read_sections
from tests.deck_text import MATERIAL, blocks, deck_of, step

HELD = "*BOUNDARY\nLOW_bottom, 1, 3\nUP_top, 1, 2\n"
DOWN = "*BOUNDARY\nUP_top, 3, 3, -0.05\n"


@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_a_divided_deck_is_that_of_blocks_with_twice_the_divisions(element, read) -> None:
    """Beside a scene of meshes made with as many cells; sets of nodes, surfaces and pressures follow."""
    meshes = blocks(element, element, ((1, 1, 2), (2, 1, 1)))
    pressed = "*DLOAD\n" + "".join(f"{5001 + cell}, P2, 3.\n" for cell in meshes[1].faces("top")[:, 0])
    result = read(deck_of(meshes, step(pressed), HELD), divide=1).solve()
    lower, upper = blocks(element, element, ((2, 2, 4), (4, 2, 2)))
    one = fc.ElasticBody(lower, MATERIAL, "top", {"bottom": "xyz"}, name="LOW", geometry="plain")
    other = fc.ElasticBody(upper, MATERIAL, "bottom", {"top": "xy"}, name="UP", geometry="plain")
    scene = fc.Scene([one, other], [fc.Contact(other, one)])
    same = scene.solve(pressures={(other, "top"): 3.0})
    ours, theirs = result.scene.bodies[1], scene.bodies[1]
    order = [np.lexsort(np.round(body.mesh.points, 9).T) for body in (ours, theirs)]
    assert np.abs(ours.mesh.points[order[0]] - theirs.mesh.points[order[1]]).max() <= 1e-12
    moved = [r.displacement(b)[k] for r, b, k in zip((result, same), (ours, theirs), order, strict=True)]
    assert np.abs(moved[0] - moved[1]).max() <= 1e-9 * np.abs(moved[1]).max()
    assert abs(result.contacts[0].total_force - 3.0) <= 1e-9


CELLS = {
    "C3D4": (8, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], 1 / 6, "S1"),
    "C3D6": (8, [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], 1 / 2, "S1"),
    "C3D10": (
        8,
        [(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
        8 / 6,
        "S1",
    ),
}


@pytest.mark.parametrize("kind", CELLS)
def test_every_kind_of_cell_is_written_as_it_is_read(kind, tmp_path, written) -> None:
    """Volumes of cells, and the area of a face, by hand."""
    count, nodes, volume, label = CELLS[kind]
    path = tmp_path / "cell.inp"
    rows = "".join(f"{7 * k + 3},{x},{y},{z}\n" for k, (x, y, z) in enumerate(nodes))
    numbers = ",".join(str(7 * k + 3) for k in range(len(nodes)))
    path.write_text(
        f"*NODE, NSET=ALL\n{rows}*ELEMENT, TYPE={kind}, ELSET=E\n4,{numbers}\n*SURFACE, NAME=BASE\n4,{label}\n"
        "*NSET, NSET=SOME, GENERATE\n3, 10, 7\n"
    )
    before, done = fc.read_mesh(path), divided_deck(list(read_sections(path)), "cell.inp", 1)
    out = written("".join(_text(s, "") for s in done), "out.inp")
    mesh = fc.read_mesh(out)
    assert len(mesh.cells) == count
    assert list(mesh.kinds) == list(before.kinds)
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.0, density=1.0), "BASE")
    assert abs(body.model.mass_and_centre[0] - volume) <= 1e-12
    area = fc.SurfaceMesh.of(mesh, "BASE").areas.sum()
    assert abs(area - fc.SurfaceMesh.of(before, "BASE").areas.sum()) <= 1e-12
    assert len(mesh.node_sets["ALL"]) == len(mesh.points)
    # two ends of an edge, and what lies between them
    edge = mesh.points[mesh.node_sets["SOME"]]
    assert np.abs(edge[:, 1:]).max() == 0
    assert len(edge) == (3 if len(nodes) < 10 else 2)


def test_forces_on_nodes_stay_on_them(read) -> None:
    """Two unit forces on each of the four corners of a set, whatever lies between them later."""
    text = deck_of(blocks(divisions=((1, 1, 1), (1, 1, 1))), step("*CLOAD\nUP_top, 3, -2.\n"), HELD)
    for times in (0, 1, 2):
        assert abs(read(text, divide=times).solve().contacts[0].total_force - 8.0) <= 1e-9


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("*EQUATION\n2\nUP_top, 1, 1., LOW_top, 1, -1.\n", ("*EQUATION",)),
        ("*TEMPERATURE\n1, 20.\n", ("*TEMPERATURE of single nodes",)),
        ("*TEMPERATURE\nUP_top, 20.\n", ("new nodes are in none",)),
        ("*DLOAD\nUP, EDNOR1, 2.\n", ("EDNOR1",)),
    ],
)
def test_what_would_change_the_question_is_refused(model, words, read) -> None:
    with refused(fc.InputError, "not-divided", *words):
        read(deck_of(blocks(divisions=((1, 1, 1), (1, 1, 1))), step(DOWN), HELD + model), divide=1)


def test_only_decks_of_their_kind_are_divided(tmp_path, written, capsys) -> None:
    for name, code in (("a.toml", "not-a-deck"), ("a.feb", "not-divided")):
        path = tmp_path / name
        path.write_text("")
        with refused(fc.InputError, code):
            fc.read_scene(path, divide=1)
    path = written(deck_of(blocks(divisions=((1, 1, 1), (1, 1, 1))), step(DOWN), HELD), "deck.inp")
    assert main(["solve", str(path), "--divide", "4"]) == 2
    assert "number of divisions" in capsys.readouterr().err
    assert main(["solve", str(path), "--divide", "1", "--dry-run"]) == 0
    assert "8 hex8 cells" in capsys.readouterr().out
