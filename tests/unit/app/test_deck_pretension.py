"""*PRE-TENSION SECTION: bolts of closed forms, and beside CalculiX."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from tests.deck_text import blocks, deck_of, listed, step

# a bar of unit section, E = 100, without lateral strain across (nu = 0): displacements of order 0.01
ROUNDING = 1e-10
#: A bar of two cells along z, held at both ends, with a cut in its middle.
BAR = fc.shapes.block((1.0, 1.0, 2.0), (1, 1, 2), element="hex20")
HEAD = "*NODE, NSET=REF\n9000, 0., 0., 0.\n"
MATERIAL = "*MATERIAL, NAME=M\n*ELASTIC\n100., 0.\n*SOLID SECTION, ELSET=BAR, MATERIAL=M\n"
#: Faces of the lower cell (S2 is its upper one).
CUT = "*SURFACE, NAME=MIDDLE\n1, S2\n*PRE-TENSION SECTION, SURFACE=MIDDLE, NODE=9000\n{}"
HELD = "*BOUNDARY\nBAR_bottom, 1, 3\nBAR_top, 1, 3\n"


def bar(loads, direction="", surface=None):
    cut = CUT.format(direction) if surface is None else CUT.format(direction).replace("1, S2", surface)
    return listed("BAR", BAR, 1) + HEAD + MATERIAL + cut + HELD + step(loads)


@pytest.mark.parametrize(("direction", "sign"), [("", 1.0), ("0., 0., 1.\n", 1.0), ("0., 0., -2.\n", -1.0)])
def test_a_force_stretches_a_bar_held_at_both_ends(direction, sign, read):
    """By hand: each half of length 1 is stretched by F / (E A); the cut is shortened by their sum."""
    scene = read(bar("*CLOAD\n9000, 1, 5.\n", direction))
    result = scene.solve()
    (body,) = scene.scene.bodies
    x, u = body.mesh.points, result.displacement(body)
    lower = body.mesh.file_nodes >= 1_000_000_000
    assert lower.sum() == 8
    at_cut = np.abs(x[:, 2] - 1) < 1e-12
    assert at_cut.sum() == 16
    assert np.abs(u[lower, 2] - sign * 0.05).max() < ROUNDING
    assert np.abs(u[at_cut & ~lower, 2] + sign * 0.05).max() < ROUNDING
    assert np.abs(result.stress(body)[:, 2] - sign * 5.0).max() < 1e-7
    assert any("Cuts are shortened to bear their tensions: 0.1 in 'BAR' for 5" in note for note in result.notes)


def test_a_heavy_bar_has_its_tension_at_the_cut(read):
    """By hand: halves of length 1 under their weight of 3 by volume, u = F / E -+ 3 / (2 E) at the cut."""
    heavy = bar("*CLOAD\n9000, 1, 5.\n*DLOAD\nBAR, GRAV, 10., 0., 0., -1.\n")
    scene = read(heavy.replace("100., 0.\n", "100., 0.\n*DENSITY\n.3,\n"))
    result = scene.solve()
    (body,) = scene.scene.bodies
    at_cut = np.abs(body.mesh.points[:, 2] - 1) < 1e-12
    u = np.sort(result.displacement(body)[at_cut, 2])
    assert np.abs(u - np.repeat([-0.065, 0.035], 8)).max() < ROUNDING


def test_a_shortening_that_is_prescribed(read):
    scene = read(bar("*BOUNDARY\n9000, 1, 1, 0.1\n"))
    result = scene.solve()
    (body,) = scene.scene.bodies
    assert np.abs(result.stress(body)[:, 2] - 5.0).max() < 1e-7


def test_a_bolt_presses_what_it_holds(read):
    """Two bodies: the lower one a bolt that is cut below the contact and pulled towards its foot, over the upper one.

    By hand, columns in series without lateral strain: a tension of 4 where the upper block stands on the cut bolt is
    the force of the contact, as nothing else holds the head down.
    """
    meshes = blocks("hex20", "hex20", divisions=((1, 1, 2), (1, 1, 1)))
    cut = "*SURFACE, NAME=MIDDLE\n1, S2\n*PRE-TENSION SECTION, SURFACE=MIDDLE, NODE=9000\n"
    held = "*BOUNDARY\nLOW_bottom, 1, 3\nUP_top, 1, 3\nLOW_x_min, 1\nLOW_y_min, 2\n"
    text = deck_of(meshes, step("*CLOAD\n9000, 1, -4.\n"), HEAD + cut + held)
    result = read(text).solve()
    assert abs(result.contacts[0].total_force - 4.0) < 1e-7


@pytest.mark.parametrize("friction", ["", "*FRICTION\n0.2,\n"])
def test_what_a_force_has_shortened_is_held_in_later_steps(friction, read):
    """A motion of the head by -.01 then adds what it does without a cut: columns that stay pressed are linear."""
    meshes = blocks("hex20", "hex20", divisions=((1, 1, 2), (1, 1, 1)))
    held = "*BOUNDARY\nLOW_bottom, 1, 3\nUP_top, 1, 3\nLOW_x_min, 1\nLOW_y_min, 2\n"
    down = "*BOUNDARY\nUP_top, 3, 3, -.01\n"
    steps = step("*CLOAD\n9000, 1, -4.\n") + step("*BOUNDARY, FIXED\n9000, 1, 1\n" + down)
    text = deck_of(meshes, steps, HEAD + CUT.format("") + held, friction)
    scene = read(text)
    if friction:
        path = scene.solve_path()
        forces, notes = np.abs(path.forces[:, 0, 2]), path[1].notes
    else:
        forces, notes = scene.sweep().column("force"), [scene.tightened.note]
    alone = read(deck_of(meshes, step(down), held, friction)).solve().contacts[0].total_force
    assert np.abs(forces - [4.0, 4.0 + alone]).max() < 1e-6
    assert alone > 0.3
    assert any("Cuts are shortened" in note for note in notes)


def test_a_section_of_plane_elements_beside_calculix(read):
    """CalculiX 2.20, CPE8 of thickness 0.1, E = 210000: a tension of -10 parts a bar by twice 4.17100e-4."""
    points = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), None, (0.5, 0), (1.5, 0), (0, 0.5), (1, 0.5), (2, 0.5)]
    points += [(0.5, 1), (1.5, 1)]
    nodes = "".join(f"{k}, {p[0]}, {p[1]}, 0.\n" for k, p in enumerate(points, start=1) if p)
    text = (
        f"*NODE\n{nodes}7, 0., 0., 0.\n*ELEMENT, TYPE=CPE8, ELSET=E\n1, 1, 2, 5, 4, 8, 11, 13, 10\n"
        "2, 2, 3, 6, 5, 9, 12, 14, 11\n*BOUNDARY\n1, 1, 2\n3, 1, 2\n4, 1, 2\n6, 1, 2\n10, 1, 2\n12, 1, 2\n"
        "*MATERIAL, NAME=M\n*ELASTIC\n210000., .3\n*SOLID SECTION, ELSET=E, MATERIAL=M\n.1\n*SURFACE, NAME=S\n1, S2\n"
        f"*PRE-TENSION SECTION, SURFACE=S, NODE=7\n1., 0., 0.\n{step('*CLOAD' + chr(10) + '7, 1, -10.' + chr(10))}"
    )
    scene = read(text)
    result = scene.solve()
    (body,) = scene.scene.bodies
    u = result.displacement(body)[np.abs(body.mesh.points[:, 0] - 1) < 1e-12, 0]
    assert np.abs(np.abs(u) - 4.17100e-4).max() < 1e-9  # as many digits as it writes
    other = read(text.replace("1, S2\n*PRE", "2, S4\n*PRE")).solve()
    # the same direction, outward from the other side: what was pushed apart is pulled together
    u = other.displacement(other.scene.bodies[0])[np.abs(body.mesh.points[:, 0] - 1) < 1e-12, 0]
    assert np.abs(np.abs(u) - 4.17100e-4).max() < 1e-9


def test_temperatures_reach_both_sides_of_a_cut(read):
    """Without a shortening and a tension the cut is none: a heated bar between walls, sigma = -E alpha T."""
    heat = "*MATERIAL, NAME=M\n*ELASTIC\n100., 0.\n*EXPANSION\n1e-3,\n"
    text = bar("*BOUNDARY\n9000, 1, 1, 0.\n*TEMPERATURE\nALL, 10.\n").replace(
        "*MATERIAL, NAME=M\n*ELASTIC\n100., 0.\n", heat
    )
    text = text.replace(HEAD, f"{HEAD}*NSET, NSET=ALL, GENERATE\n1, {len(BAR.points)}, 1\n")
    text = text.replace("*STEP", "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 0.\n*STEP")
    result = read(text).solve()
    assert np.abs(result.stress(result.scene.bodies[0])[:, 2] + 100 * 1e-3 * 10).max() < 1e-9


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (bar("", surface="1, S1"), ("pre-tension", "'MIDDLE'")),
        (bar("").replace("SURFACE=MIDDLE, NODE", "ELEMENT=1, NODE"), ("not-supported", "without SURFACE")),
        (bar("*CLOAD\n9000, 1, 5.\n") + step(""), ("not-supported", "step 2")),
        (bar("*CLOAD\n9000, 1, 5.\n") + step("*CLOAD, OP=NEW\n9001, 1, 0.\n"), ("not-supported", "neither")),
        (bar("*BOUNDARY, FIXED\n9000, 1, 1\n"), ("not-supported", "as they are")),
        (bar("*BOUNDARY, FIXED\n5, 1, 1\n"), ("not-supported", "as they are")),
        (bar("*CLOAD\n5, 3, 5.\n"), ("not-supported", "forces on nodes")),
    ],
)  # fmt: skip
def test_sections_that_are_refused(text, words, read):
    with refused(fc.InputError, *words):
        read(text)
