"""Decks of two blocks beside the same scene in Python, and beside CalculiX 2.20, whose figures are recorded."""

import numpy as np
import pytest

import fecontact as fc
from tests.deck_text import blocks, deck_of, listed, scene_of, step


@pytest.fixture
def read(tmp_path):
    """Scene of a deck's text."""

    def made(text):
        path = tmp_path / "blocks.inp"
        path.write_text(text)
        return fc.read_scene(path)

    return made


HELD = "*BOUNDARY\nLOW_bottom, 1, 3\nUP_top, 1, 2\n"
DOWN = "*BOUNDARY\nUP_top, 3, 3, -0.05\n"
#: CalculiX 2.20, surface to surface with K = 1e7: total force on LOW_bottom.
CCX = {("hex8", "hex8"): 2.647074, ("hex8", "hex20"): 2.621753, ("hex20", "hex8"): 2.622172}
CCX[("hex20", "hex20")] = 2.597322


@pytest.mark.parametrize("kinds", list(CCX))
def test_linear_cells_beside_quadratic_ones(kinds, read):
    meshes = blocks(*kinds)
    scene = read(deck_of(meshes, step(DOWN), HELD))
    assert [b.mesh.cell_type for b in scene.scene.bodies] == list(kinds)
    force = scene.solve().contacts[0].total_force
    python = scene_of(meshes)
    same = python.solve(motions={python.bodies[1]: {"z": -0.05}}).contacts[0].total_force
    assert abs(force - same) < 1e-9 * same
    # K of the other program: .05 / 2 of 1e7 would be 2.5e5, so its penetration is 1e-5 of the motion
    assert abs(force - CCX[kinds]) < 1e-4


def mixed_column():
    """Text of a column of a linear cell below a quadratic one, which share corners, and numbers of its foot."""
    low, up = blocks("hex8", "hex8", ((1, 1, 1), (1, 1, 1)))
    top = up.upgraded(20)
    number = np.arange(1, 9)
    for k in low.boundary_nodes("top"):
        number[k] = 5001 + np.argmin(np.linalg.norm(top.points - low.points[k], axis=1))
    own = low.boundary_nodes("bottom")
    nodes = "".join(f"{number[k]}, {', '.join(map(str, low.points[k].tolist()))}\n" for k in own)
    foot = "".join(f"{n},\n" for n in number[own])
    cell = ", ".join(map(str, number[low.cells[0]].tolist()))
    text = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=LOW\n1, {cell}\n*NSET, NSET=FOOT\n{foot}"
    return listed("UP", top, 5001) + text, low, number


def test_sets_have_the_nodes_added_between_their_members(tmp_path):
    path = tmp_path / "mixed.inp"
    path.write_text(mixed_column()[0])
    mesh = fc.read_mesh(path)
    # four corners, and the middles of four edges
    assert len(mesh.node_sets["FOOT"]) == 8
    assert np.abs(mesh.points[mesh.node_sets["FOOT"], 2]).max() == 0


def test_supports_and_forces_at_nodes_added_within_a_body(read):
    column, low, number = mixed_column()
    cap = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8").translated((0.0, 0.0, 2.0))
    sides = "".join(f"{number[k]}, {c}\n" for c, side in ((1, "x_min"), (2, "y_min")) for k in low.boundary_nodes(side))
    held = "*BOUNDARY\nFOOT, 3\n" + sides + "".join(f"{b}_x_min, 1\n{b}_y_min, 2\n" for b in ("UP", "CAP"))
    text = (
        f"{column}{listed('CAP', cap, 9001)}*ELSET, ELSET=ALL\nLOW, UP, CAP\n*MATERIAL, NAME=M\n*ELASTIC\n100., 0.3\n"
        "*SOLID SECTION, ELSET=ALL, MATERIAL=M\n*SURFACE INTERACTION, NAME=I\n*CONTACT PAIR, INTERACTION=I\n"
        f"CAP_face_bottom, UP_face_top\n{held}{step('*DSLOAD' + chr(10) + 'CAP_face_top, P, 2.' + chr(10))}"
    )
    result = read(text).solve()
    assert abs(result.contacts[0].total_force - 2) < 1e-9
    # by hand: uniform pressure 2, free to spread
    for body in result.scene.bodies:
        exact = body.mesh.points * [0.006, 0.006, -0.02]
        assert np.abs(result.displacement(body) - exact).max() < 1e-12
    # a force at each of four nodes of the foot, not at those added between them
    path = read(text.replace("*DSLOAD", "*CLOAD\nFOOT, 1, 0.5\n*DSLOAD"))
    assert abs(sum(f[0] for f in path.loads["forces"].values()) - 2) < 1e-12
