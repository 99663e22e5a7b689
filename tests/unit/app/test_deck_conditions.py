"""Linear conditions and axes of nodes in decks: *EQUATION, *MPC, *COUPLING, *RIGID BODY, *TRANSFORM.

Figures named ccx are those of CalculiX 2.20 for the same deck: the largest displacement of either block and the contact
force. Its contact there is a penalty of 1e5, its reference nodes turn at any angle; both matter less than .3 % here.
"""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from tests.deck_text import MATERIAL, blocks, deck_of, step

CUBES = blocks("hex20", "hex20", ((2, 2, 2), (3, 3, 2)))
SMALL = blocks(divisions=((1, 1, 1), (1, 1, 1)))
PENALTY = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E5,\n"
FIXED = "*BOUNDARY\nLOW_bottom, 1, 3\n"
SLIDING = "*BOUNDARY\nUP_top, 1, 2\n"
PLANES = "*BOUNDARY\nUP_x_min, 1\nUP_y_min, 2\n"
NODES = "*NODE, NSET=REF\n9001, 0.3, 0.4, 2.6\n*NODE, NSET=ROT\n9002, 0.3, 0.4, 2.6\n"
RIGID = "*RIGID BODY, NSET=UP_top, REF NODE=9001, ROT NODE=9002\n"
COUPLED = "*COUPLING, REF NODE=9001, SURFACE=UP_face_top, CONSTRAINT NAME=K\n"
ROUND = "*TRANSFORM, NSET=UP_top, TYPE=C\n.3,-.5,0., .3,-.5,1.\n"
FRICTION = "*FRICTION\n.3, 1e5\n"


def node_at(*place):
    return int(np.linalg.norm(CUBES[1].points - place, axis=1).argmin()) + 5001


TOP = (CUBES[1].boundary_nodes("top") + 5001).tolist()
CORNERS = [node_at(*p) for p in ((0, 0, 2), (1, 0, 2), (0, 1, 2), (1, 1, 2), (0.5, 0.5, 2))]


def forces(*values):
    given = zip(CORNERS, values, strict=True)
    return "*CLOAD\n" + "".join(f"{node}, 3, {-value}\n" for node, value in given if value)


def alike(master):
    """Equations that all nodes of the top have the height of one."""
    return "*EQUATION\n" + "".join(f"2\n{n}, 3, 1., {master}, 3, -1.\n" for n in TOP if n != master)


PLATE = ", ".join(map(str, CORNERS[:3] + [n for n in TOP[:14] if n not in CORNERS[:3]]))
BENT = "".join(f"{n}, 3, 3, {-0.02 - 0.02 * CUBES[1].points[n - 5001, 0] ** 2}\n" for n in TOP)

#: Loads, model and friction of each deck, then what ccx finds.
CASES = {
    "equations": (f"*CLOAD\n{TOP[0]}, 3, -2.\n", SLIDING + alike(TOP[0]), "", (0.0197138, 0.0385211, 2.0)),
    "equations to a moved node": (
        "*BOUNDARY\n9001, 3, 3, -0.03\n", SLIDING + NODES + alike(9001), "", (0.015353, 0.03, 1.5576),
    ),
    "a plane": (forces(0.02, 0.02, 0.015, 0.01, 0), SLIDING + f"*MPC\nPLANE, {PLATE}\n", "", (0, 0.00306457, 0.065)),
    "a line": (
        forces(0.02, 0.012, 0.01, 0.015, 0.05) + f"{CORNERS[3]}, 1, .01\n",
        PLANES + f"*MPC\nSTRAIGHT, {CORNERS[2]}, {CORNERS[3]}, {node_at(0.5, 1, 2)}\n", "",
        (0.00132077, 0.0068636, 0.107),
    ),
    "a bar": (
        forces(0.02, 0.012, 0.01, 0.015, 0.05) + f"{CORNERS[3]}, 1, .01\n",
        PLANES + f"*MPC\nBEAM, {CORNERS[3]}, {node_at(2 / 3, 2 / 3, 2)}\n", "", (0.00135418, 0.00784923, 0.107),
    ),
    "a rigid top, pushed": (
        "*CLOAD\n9001, 3, -.02\n", NODES + RIGID + "*BOUNDARY\n9001,1,2\n9002,2,3\n", "",
        (3.43905e-4, 6.78029e-4, 0.02),
    ),
    "a rigid top, moved and turned": (
        "*BOUNDARY\n9001, 3, 3, -.03\n9002, 1, 1, .01\n", NODES + RIGID + "*BOUNDARY\n9001,1,2\n9002,2,3\n", "",
        (0.0178094, 0.0344992, 1.50427),
    ),
    "a kinematic coupling": (
        "*CLOAD\n9001, 3, -.02\n9001, 1, .001\n*BOUNDARY\n9001, 2, 2, .00002\n",
        NODES + COUPLED + "*KINEMATIC\n1, 3\n*BOUNDARY\n9001,4,4\n9001,6,6\n", "*FRICTION\n.4, 1e5\n",
        (3.29367e-4, 7.90106e-4, 0.0200256),
    ),
    "a distributing coupling": (
        "*CLOAD\n9001, 3, -.02\n", NODES + PLANES + COUPLED + "*DISTRIBUTING\n1, 3\n", "",
        (2.72735e-4, 5.97498e-4, 0.02),
    ),
    "one with a moment": (
        "*CLOAD\n9001, 4, .001\n9001, 3, -.02\n", NODES + PLANES + COUPLED + "*DISTRIBUTING\n1, 6\n", "",
        (2.85154e-4, 6.26049e-4, 0.02),
    ),
    "a support that is bent": (f"*BOUNDARY\n{BENT}", SLIDING, "", (0.0199149, 0.04, 1.39602)),
    "a top turned about a line": (
        "*BOUNDARY\nUP_top, 1, 2, .01\nUP_top,3,3,-.02\n", ROUND + "*BOUNDARY\nUP_top,1,3\n", "",
        (0.0102706, 0.0244949, 1.00515),
    ),
    "a top moved radially": (
        "*BOUNDARY\nUP_top, 1, 1, .001\nUP_top,3,3,-.02\n", ROUND + "*BOUNDARY\nUP_top,3,3\nUP_top,1,1\n5001,2\n",
        FRICTION, (0.0103858, 0.0201081, 1.02685),
    ),
    "oblique axes": (
        "*BOUNDARY\nUP_top, 3, 3, -.03\n*CLOAD\nUP_top, 1, .0005\n",
        "*TRANSFORM, NSET=UP_top, TYPE=R\n1.,.2,.1, -.2,1.,.05\n*BOUNDARY\nUP_top,2,3\n", FRICTION,
        (0.0236464, 0.0363432, 1.45165),
    ),
}  # fmt: skip


@pytest.fixture
def read(written):
    def made(loads, model, friction="", meshes=CUBES):
        text = deck_of(meshes, step(loads), FIXED + model, friction, PENALTY)
        path = written(text.replace("*CONTACT PAIR, ", "*CONTACT PAIR, TYPE=SURFACE TO SURFACE, "), "deck.inp")
        return fc.read_scene(path)

    return made


@pytest.mark.parametrize("name", CASES)
def test_ccx_finds_the_same(name, read):
    loads, model, friction, ccx = CASES[name]
    result = read(loads, model, friction).solve()
    sizes = [float(np.linalg.norm(result.displacement(body), axis=1).max()) for body in result.scene.bodies]
    for found, expected in zip((*sizes, np.linalg.norm(result.contacts[0].force)), ccx, strict=True):
        assert abs(found - expected) < 0.0065 * expected or not expected


def test_a_force_off_the_middle_presses_where_it_acts(read):
    """Statics: the resultant of the contact is on the line of the force on the reference node."""
    for kind in ("KINEMATIC", "DISTRIBUTING"):
        model = NODES + COUPLED + f"*{kind}\n1, 3\n" + FIXED.replace("LOW_bottom, 1, 3", "5001, 1, 2\n5004, 2")
        contact = read("*CLOAD\nREF, 3, -.02\n", model).solve().contacts[0]
        assert np.abs(contact.centre_of_pressure[:2] - (0.3, 0.4)).max() < 1e-8
        assert abs(contact.total_force - 0.02) < 1e-12


def test_supports_that_move_leave_free_what_they_do_not_hold(read):
    """A block is drawn along by its top, which tilts freely: the friction F at its foot, h below, moves the centre of
    pressure by F h / N (equilibrium of moments).
    """
    loads = "*BOUNDARY\nUP_top, 1, 1, .003\n*DSLOAD\nUP_face_top, P, .05\n"
    contact = read(loads, FIXED + SLIDING, "*FRICTION\n.2, 1e5\n").solve().contacts[0]
    friction = np.linalg.norm(contact.friction.forces.sum(axis=0))
    assert friction > 0.75 * 0.2 * 0.05
    # less the motion, which the equilibrium of small motions leaves out
    assert contact.centre_of_pressure[0] == pytest.approx(0.5 + friction / 0.05, abs=4e-3)


def test_a_rigid_block_presses_as_a_rigid_body(read):
    """All of the upper block is rigid: pushed at its reference node it is the rigid face of the same motion."""
    everything = NODES + "*RIGID BODY, ELSET=UP, REF NODE=9001, ROT NODE=9002\n*BOUNDARY\nREF, 1, 2\nROT, 1, 3\n"
    pushed = read("*CLOAD\n9001, 3, -2.\n", everything).solve()
    moved = read("*BOUNDARY\n9001, 3, 3, -0.01\n", everything).solve()
    stiffness = moved.contacts[0].total_force / 0.01
    assert abs(np.ptp(pushed.displacement(pushed.scene.bodies[1])[:, 2])) < 1e-12
    assert abs(pushed.displacement(pushed.scene.bodies[1])[0, 2] + 2.0 / stiffness) < 1e-9


@pytest.mark.parametrize("turn", [0.01, 0.2])
def test_large_turns_of_a_reference_node_are_warned_of(turn, read):
    file = read(
        f"*BOUNDARY\n9001, 1, 6\n9001, 4, 4, {turn}\n", NODES + RIGID.replace(", ROT NODE=9002", ""), meshes=SMALL
    )
    said = [text for text in file.scene.warnings if "is turned by" in text]
    assert bool(said) == (turn > 0.1)
    assert any("linear, for small turns" in note for note in file.notes)


@pytest.mark.parametrize("slant", [0.3, np.pi / 2])
def test_a_deck_in_turned_axes_is_the_same_deck(slant, written):
    """The whole scene turned about x, supports and loads along axes that *TRANSFORM turns with it."""
    Q = np.array([[1, 0, 0], [0, np.cos(slant), -np.sin(slant)], [0, np.sin(slant), np.cos(slant)]])
    axes = ", ".join(map(repr, [*Q[:, 0].tolist(), *Q[:, 1].tolist()]))
    found = []
    for turned in (False, True):
        meshes = [mesh.mapped(lambda x: x @ Q.T) for mesh in SMALL] if turned else SMALL
        model = "*NSET, NSET=ALL\nLOW_bottom, LOW_top, UP_bottom, UP_top\n"
        model += f"*TRANSFORM, NSET=ALL\n{axes}\n" if turned else ""
        model += "*BOUNDARY\nLOW_bottom, 3\nLOW_x_min, 1\nLOW_y_min, 2\nUP_x_min, 1\nUP_y_min, 2\n"
        path = written(deck_of(meshes, step("*CLOAD\nUP_top, 3, -1.\nUP_top, 1, .1\n"), model), "turned.inp")
        result = fc.read_scene(path).solve()
        u = np.concatenate([result.displacement(body) for body in result.scene.bodies])
        found.append(u @ Q if turned else u)
    assert np.abs(found[0] - found[1]).max() < 1e-10
    # uniaxial stress of 4 and 0.4 across, in two unit cubes
    assert abs(found[0][:, 2].min() + 2 * 4.0 / MATERIAL.E) < 0.01


def test_an_equation_of_a_set_is_one_for_each_of_its_nodes(read):
    """A set of equations for every node of a set, and one node beside it."""
    pairs = (
        "*EQUATION\n" + "".join(f"2\nUP_top, {c}, 1., REF, {c}, -1.\n" for c in (1, 2, 3)) + "*BOUNDARY\nREF, 1, 2\n"
    )
    result = read("*CLOAD\nREF, 3, -4.\n", NODES + pairs, meshes=SMALL).solve()
    top = result.displacement(result.scene.bodies[1])[SMALL[1].boundary_nodes("top")]
    assert np.ptp(top, axis=0).max() < 1e-12
    assert abs(result.contacts[0].total_force - 4.0) < 1e-9


@pytest.mark.parametrize(
    ("model", "loads", "words"),
    [
        ("*EQUATION\n2\n5001, 3, 1.\n", "", ("equation", "expected 2 terms")),
        ("*EQUATION\n2\nUP_top, 3, 1., LOW_x_min, 3, -1.\n", "", ("contact-within-body", "conditions join")),
        ("*EQUATION\n1\nNOWHERE, 3, 1.\n", "", ("input", "NOWHERE")),
        ("*MPC\nMEANROT, 5001, 5002\n", "", ("not-supported", "MEANROT")),
        ("*MPC\nSTRAIGHT, 5001, 5002\n", "", ("mpc", "needs 3 nodes")),
        ("*MPC\nSTRAIGHT, 5001, 5002, 5003\n", "", ("mpc", "off their plane or line")),
        ("*COUPLING, REF NODE=9001, SURFACE=UP_face_top\n", "", ("coupling", "KINEMATIC or ")),
        ("*COUPLING, REF NODE=9001, SURFACE=UP_face_top, ORIENTATION=O\n*KINEMATIC\n", "", ("not-supported", "ORIENT")),
        ("*COUPLING, REF NODE=REF, SURFACE=UP_face_far\n*KINEMATIC\n", "", ("input", "UP_face_far")),
        ("*RIGID BODY, NSET=UP_top\n", "", ("not-supported", "REF NODE")),
        ("*RIGID BODY, REF NODE=UP_top, NSET=UP_top\n", "", ("reference-node", "has 4")),
        ("*TRANSFORM, NSET=UP_top, TYPE=S\n1., 0., 0., 0., 1., 0.\n", "", ("transform", "found S")),
        ("*TRANSFORM, NSET=UP_top\n1., 0., 0., 2., 0., 0.\n", "", ("transform", "one line")),
        ("", "*TRANSFORM, NSET=UP_top\n1., 0., 0., 0., 1., 0.\n", ("not-supported", "in a step")),
        ("", "*EQUATION\n2\n5001, 3, 1., 5002, 3, -1.\n", ("not-supported", "ties displacements")),
        ("*RIGID BODY, REF NODE=9001, NSET=LINE\n", "*CLOAD\n9001, 6, 1.\n", ("load-would-be-lost", "leave free")),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_said(model, loads, words, read):
    line = "*NSET, NSET=LINE\n5005, 5001\n"
    with refused(fc.InputError, *words):
        read("*BOUNDARY\nUP_top, 1, 2\n" + loads, NODES + line + model, meshes=SMALL)


def test_faces_tied_to_faces_follow_the_coarser_side_whichever_is_named_first(tmp_path):
    """As ccx ties face to face; node to surface the side named first follows."""
    given = deck_of(
        CUBES, step("*BOUNDARY\nUP_top, 1, 1, .01\n"), FIXED + SLIDING.replace("1, 2", "2, 3"), "",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1.E5,\n",
    )  # fmt: skip
    path, first, turned = tmp_path / "deck.inp", "UP_face_bottom, LOW_face_top", "LOW_face_top, UP_face_bottom"
    energies = []
    for kind in ("SURFACE TO SURFACE", "NODE TO SURFACE"):
        text = given.replace("*CONTACT PAIR, ", f"*CONTACT PAIR, TYPE={kind}, ")
        for named in (first, turned):
            path.write_text(text.replace(first, named))
            result = fc.read_scene(path).solve()
            body = result.scene.bodies[0]
            energies.append(body.model.strain_energy(result.displacement(body).ravel()))
    assert energies[1] == pytest.approx(energies[0], rel=1e-12)
    assert energies[2] == pytest.approx(energies[0], rel=1e-12)
    assert energies[3] < (1 - 1e-4) * energies[0]


@pytest.mark.parametrize("adjust", ["", ", ADJUST=NO"])
def test_a_tie_that_keeps_its_gap_has_the_length_of_its_blocks(adjust, written):
    """Unit columns .125 apart under a unit force: by 2 F / (E A); moved onto the master the upper one is longer."""
    lower, upper = blocks(divisions=((1, 1, 1), (1, 1, 3)))
    pull = "*CLOAD\n" + "".join(f"{n + 5001}, 3, .25\n" for n in upper.boundary_nodes("top"))
    text = deck_of((lower, upper.translated((0, 0, 0.125))), step(pull), FIXED + SLIDING)
    pair = "*CONTACT PAIR, INTERACTION=I\n"
    text = text.replace(pair, f"*TIE, NAME=T, POSITION TOLERANCE=.2{adjust}\n").replace(", 0.3\n", ", 0.\n")
    path = written(text, "deck.inp")
    result = fc.read_scene(path).solve()
    (body,) = result.scene.bodies
    longer = 0 if adjust else 0.125
    assert abs(result.displacement(body)[:, 2].max() - (2 + longer) / MATERIAL.E) <= 1e-12
    top = body.mesh.points[body.mesh.boundary_nodes("UP_face_bottom"), 2]
    assert np.abs(top - (1.125 - longer)).max() <= 1e-12
    told = [w for w in result.warnings if "stay up to 0.125 from their master" in w]
    assert len(told) == bool(adjust)


def test_a_tie_that_keeps_its_gap_and_reaches_nothing_is_refused(written):
    lower, upper = blocks(divisions=((1, 1, 1), (1, 1, 1)))
    text = deck_of((lower, upper.translated((0, 0, 0.5))), step("*BOUNDARY\nUP_top, 3, 3, .1\n"), FIXED)
    path = written(text.replace("*CONTACT PAIR, INTERACTION=I\n", "*TIE, NAME=T, ADJUST=NO\n"), "deck.inp")
    with refused(fc.InputError, "tie-apart", "reach"):
        fc.read_scene(path)
