"""Decks of two blocks beside the same scene in Python, and beside CalculiX 2.20, whose figures are recorded."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from tests.deck_text import blocks, deck_of, listed, scene_of, step

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


def test_sets_have_the_nodes_added_between_their_members(written):
    path = written(mixed_column()[0], "mixed.inp")
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


PRESS = "*DSLOAD\nUP_face_top, P, {0}\n"
PRESS_NEW = "*DSLOAD, OP=NEW\nUP_face_top, P, "
#: Free to spread, so that the contact's force is the load's.
SLIDES = "*BOUNDARY\nLOW_bottom, 3\nLOW_x_min, 1\nLOW_y_min, 2\nUP_x_min, 1\nUP_y_min, 2\n"


def forces_of(scene):
    """Total forces of its cases, or of the one."""
    if scene.cases:
        return [
            row["contacts"][0]["force"][2] * (-1) ** (row["contacts"][0]["slave"] == "LOW") for row in scene.sweep()
        ]
    contact = scene.solve().contacts[0]
    return [contact.total_force]


LINEAR = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{},\n"
RUBBER = "*HYPERELASTIC, NEO HOOKE\n2.5, 0.6"
SMALL = blocks(divisions=((1, 1, 1), (1, 1, 1)))


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        # OP=NEW twice in a step: the second does not drop the first
        (step("*CLOAD, OP=NEW\nUP_top, 3, -1.\n*CLOAD, OP=NEW\nUP_top, 3, -.5\n"), [6.0]),
        (step(PRESS.format(1)) + step(f"{PRESS_NEW}2.\n*DSLOAD, OP=NEW\nLOW_face_x_min, P, 0.\n"), [1.0, 2.0]),
        # loads on one surface add up in a step; those by cells and by surfaces are renewed together
        (step(PRESS.format(1) + PRESS.format(1)), [2.0]),
        (step("*DLOAD\nUP, P2, 1.\n") + step(f"{PRESS_NEW}2.\n"), [1.0, 2.0]),
        # a blank field, and a period of one by default
        (step("*DSLOAD, AMPLITUDE=A\nUP_face_top, P, 2.\n", static="*STATIC\n, 2., , .1\n"), [2.0]),
        (step("*DSLOAD, AMPLITUDE=A\nUP_face_top, P, 2.\n", static="*STATIC\n.1,\n"), [1.0]),
        (step("*DSLOAD, AMPLITUDE=A\nUP_face_top, P, 2.\n", static="*STATIC\n"), [1.0]),
        # over the total time a load goes on in steps that do not repeat it, over a step's time it stays
        (step("*DSLOAD, AMPLITUDE=T\nUP_face_top, P, 2.\n") + step("") + step(""), [1.0, 2.0, 3.0]),
        (step("*DSLOAD, AMPLITUDE=A\nUP_face_top, P, 2.\n") + step(""), [1.0, 1.0]),
        # absolute values replace the load's; shifts of times and values
        (step("*DSLOAD, AMPLITUDE=B\nUP_face_top, P, 7.\n"), [0.5]),
        (step("*DSLOAD, AMPLITUDE=S\nUP_face_top, P, 2.\n"), [4.5]),
    ],
)  # fmt: skip
def test_loads_of_steps_and_amplitudes(steps, expected, read):
    # CalculiX 2.20 gives the same, but for absolute values, which it does not have
    tables = (
        "*AMPLITUDE, NAME=A\n0., 0., 2., 1.\n*AMPLITUDE, NAME=B, VALUE=ABSOLUTE\n0., 0., 1., .5\n"
        "*AMPLITUDE, NAME=T, TIME=TOTAL TIME\n0., 0., 4., 2.\n"
        "*AMPLITUDE, NAME=S, SHIFTX=-1., SHIFTY=.25\n0., 0., 2., 2.\n"
    )
    scene = read(deck_of(SMALL, steps, tables + SLIDES))
    assert np.abs(np.array(forces_of(scene)) - expected).max() < 1e-9


@pytest.mark.parametrize("rubber", [RUBBER, "*HYPERELASTIC, NEO HOOKE\n2.5", "*HYPERELASTIC, NEO HOOKE\n2.5, 0."])
def test_rubber_is_at_finite_strain_with_another_bulk_energy(rubber, read):
    text = deck_of(SMALL, step(PRESS.format(0.5)), SLIDES).replace("*ELASTIC\n100.0, 0.3", rubber)
    scene = read(text)
    # without D: K / mu = 2 (1 + nu) / 3 / (1 - 2 nu) with nu = .475
    law, bulk = scene.scene.bodies[0].material, 2 / 0.6 if rubber == RUBBER else 5.0 * 2.95 / 0.15
    assert law.c10 == 2.5
    assert abs(law.bulk - bulk) < 1e-12 * bulk
    (said,) = (note for note in scene.scene.warnings if "(ln J)^2 / D in place of (J - 1)^2 / D" in note)
    small = read(text, laws="small-strain").scene
    (rest,) = (note for note in small.warnings if "linear, with the moduli at rest" in note)
    for told in (said, rest):
        assert ("nu = 0.475 as no D is given (CalculiX and Abaqus/Explicit take the same" in told) == (rubber != RUBBER)


def test_an_amplitude_that_bends_within_a_step_and_softer_elements_are_said(read):
    pressed = step("*DSLOAD, AMPLITUDE=A\nUP_face_top, P, 2.\n", static="*STATIC\n1., 2.\n")
    for form, middle, bends in (("", 1.0, True), (", TIME=TOTAL TIME", -0.1, True), ("", 0.3, False)):
        table = f"*AMPLITUDE, NAME=A{form}\n0., 0., 1., {middle}, 2., .5\n"
        warnings = read(deck_of(SMALL, pressed, table + SLIDES)).scene.warnings
        assert any("'A' goes beyond its ends within a step" in text for text in warnings) == bends
    softer = read(deck_of(SMALL, step(PRESS.format(1)), SLIDES).replace("TYPE=C3D8,", "TYPE=C3D8I,"))
    assert [note for note in softer.notes if "type C3D8I are integrated in full" in note]


@pytest.mark.parametrize(("line", "mu"), [("*FRICTION\n, 1e5\n", 0.0), ("*FRICTION\n 3.D-1, \n", 0.3)])
def test_a_blank_coefficient_of_friction(line, mu, read):
    scene = read(deck_of(SMALL, step(PRESS.format(1)), SLIDES, line))
    assert scene.scene.contacts[0].mu == mu


def test_several_steps_are_not_solved_as_one(read, tmp_path):
    two = step(PRESS.format(1)) + step(PRESS.format(2))
    cases = read(deck_of(SMALL, two, SLIDES))
    path = read(deck_of(SMALL, two, SLIDES, "*FRICTION\n.3,\n"))
    one = read(deck_of(SMALL, step(PRESS.format(1)), SLIDES))
    with refused(fc.InputError, "input", "has 2", "cases", "sweep"):
        cases.solve()
    with refused(fc.InputError, "input", "has 2", "steps of a load path", "solve_path"):
        path.solve()
    for verb in (one.solve_path, one.sweep):
        with pytest.raises(fc.InputError, match=r"call solve\(\) instead") as caught:
            verb()
        assert caught.value.code in ("no-steps", "no-cases")


@pytest.mark.parametrize(
    ("model", "steps", "words"),
    [
        ("*COUPLING, REF NODE=9999, SURFACE=UP_face_top\n*KINEMATIC\n1, 3\n", "", ("unknown-node", "9999")),
        ("*CLEARANCE, MASTER=LOW_face_top, SLAVE=UP_face_bottom\n", "", ("not-supported", "CLEARANCE")),
        ("", "*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\nUP_face_bottom, LOW_face_top\n", ("no-contact", "no two")),
        ("", "*MODEL CHANGE, TYPE=ELEMENT, REMOVE\nUP\n", ("not-supported", "adds or removes elements")),
        ("", "*CHANGE SURFACE BEHAVIOR, INTERACTION=I\n*SURFACE BEHAVIOR\n", ("not-supported", "CHANGE")),
        ("*TIE, CYCLIC SYMMETRY, NAME=T\nLOW_face_x_min, LOW_face_y_min\n", "", ("cyclic-symmetry", "'T'")),
        ("*INITIAL CONDITIONS, TYPE=STRESS\n1, 1., 0., 0., 0., 0., 0.\n", "", ("input", "begin without stress")),
        (
            "*SURFACE, NAME=N, TYPE=NODE\n1,\n*CONTACT PAIR, INTERACTION=I\nUP_face_bottom, N\n",
            "",
            ("surface-of-nodes", "'N'"),
        ),
        ("", "*DLOAD\nUP, BX, 1.\n", ("load-would-be-lost", "expected P1, P2")),
        ("", "*CLOAD\nUP_top, 4, 1.\n", ("load-would-be-lost", "nodes of solids have no component 4")),
        ("*NODE, NSET=ALONE\n9999, 0., 0., 9.\n", "*CLOAD\nALONE, 3, -1.\n", ("load-would-be-lost", "ALONE")),
        ("", "*CLOAD, USER\nUP_top, 3, -1.\n", ("not-supported", "CLOAD", "USER")),
        ("*AMPLITUDE, NAME=A\n1., 0., 0., 1.\n", "", ("growing", "['1., 0., 0., 1.']")),
        ("*INCLUDE, INPUT=absent.inp\n", "", ("missing-files", "absent", "inp")),
    ],
)  # fmt: skip
def test_what_changes_the_question_is_refused(model, steps, words, read):
    with refused(fc.InputError, *words):
        read(deck_of(SMALL, step(PRESS.format(1) + steps), SLIDES + model))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"interaction": LINEAR.format(50)}, None),
        (
            {"interaction": "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=QUADRATIC\n1., .1\n"},
            "without the soft quadratic",
        ),
        ({"model": SLIDES + "*SOMETHING NEW\n"}, r"*SOMETHING NEW is not used: what it changes is left out"),
        ({"interaction": LINEAR.format(1e6)}, None),
    ],
)
def test_what_may_change_the_answer_is_a_warning_of_the_result(options, words, read):
    scene = read(deck_of(SMALL, step(PRESS.format(1)), **{"model": SLIDES, **options}))
    warnings = scene.solve().warnings
    assert any(words in text for text in warnings) if words else not scene.scene.warnings


#: CalculiX 2.20, surface to surface with K = 500: total force on LOW_bottom.
SOFT = {("hex8", "hex8"): 2.393616, ("hex20", "hex20"): 2.352843}


@pytest.mark.parametrize("kinds", list(SOFT))
def test_a_linear_overclosure_is_a_soft_contact_unless_it_is_a_penalty(kinds, read):
    def force(stiffness):
        text = deck_of(blocks(*kinds), step(DOWN), HELD, interaction=LINEAR.format(stiffness))
        scene = read(text)
        (contact,) = scene.solve().contacts
        given = scene.scene.contacts[0].overclosure
        assert (contact.overclosure is None) == (given is None)
        return contact.total_force, None if given is None else given.stiffness

    soft, stiffness = force(500)
    assert stiffness == 500
    assert abs(soft - SOFT[kinds]) < 1e-4  # its quadrature of the overlap is another one
    hard, stiffness = force(1e6)
    assert stiffness is None
    assert abs(hard - CCX[kinds]) < 1e-4


@pytest.mark.parametrize("kinds", [("hex8", "hex8"), ("hex20", "hex20"), ("hex8", "hex20")])
def test_surfaces_of_nodes_that_fill_faces_are_these_faces(kinds, read):
    """Linear cells beside quadratic ones of a body, whose nodes in the middles of edges are in no set, too."""
    meshes = blocks(*kinds)
    text = deck_of(meshes, step(PRESS.format(0.1)), SLIDES)
    nodes = "*SURFACE, NAME=NODES, TYPE=NODE\nUP_bottom,\n"
    by_nodes = text.replace("*CONTACT PAIR", f"{nodes}*CONTACT PAIR").replace("UP_face_bottom, LOW", "NODES, LOW")
    one, other = (read(given).solve().contacts[0] for given in (text, by_nodes))
    assert np.abs(one.pressure - other.pressure).max() <= 1e-12 * one.max_pressure


def test_a_surface_of_a_node_that_fills_no_face_has_a_force_on_it(read):
    """CalculiX 2.20, node to surface with K = 5e7: 1.57097 in all."""
    meshes = blocks(divisions=((1, 1, 1), (2, 2, 1)))
    text = deck_of(meshes, step(DOWN), HELD)
    (foot,) = np.flatnonzero((meshes[1].points == [0.5, 0.5, 1.0]).all(axis=1)) + 5001
    alone = text.replace("UP_face_bottom, LOW_face_top\n", "FOOT, LOW_face_top\n")
    alone = alone.replace("*CONTACT PAIR", f"*SURFACE, NAME=FOOT, TYPE=NODE\n{foot},\n*CONTACT PAIR")
    (contact,) = read(alone).solve().contacts
    assert len(contact.forces) == 1
    assert abs(contact.total_force - 1.57097) < 1e-5


def test_a_tie_of_single_nodes_is_a_scene_without_contact(read):
    """Four corners of the upper block on the lower one: the deck has no other contact, and no face for the tie."""
    meshes = blocks(divisions=((1, 1, 1), (2, 2, 1)))
    text = deck_of(meshes, step("*DSLOAD\nUP_face_top, P, .1\n"), SLIDES)
    x = meshes[1].points
    feet = np.flatnonzero((x[:, 2] == 1) & np.isin(x[:, :2], (0, 1)).all(axis=1))
    corners = "".join(f"{n},\n" for n in (feet + 5001).tolist())
    tie = f"*SURFACE, NAME=FEET, TYPE=NODE\n{corners}*TIE, NAME=T\nFEET, LOW_face_top\n"
    pair = "*CONTACT PAIR, INTERACTION=I\nUP_face_bottom, LOW_face_top\n"
    scene = read(text.replace(pair, tie))
    assert scene.scene.contacts == ()
    assert scene.scene.warnings == ()
    # what lies on its master is not moved anyway
    assert read(text.replace(pair, tie.replace("NAME=T\n", "NAME=T, ADJUST=NO\n"))).scene.warnings == ()
    result = scene.solve()
    (body,) = scene.scene.bodies
    assert len(body.mesh.hanging.nodes) == 4
    foot = sum(result.reaction(body, name)[:3] for name in body.supports)
    assert np.abs(foot - [0, 0, 0.1]).max() <= 1e-12
    assert result.status == "solved"


def test_a_soft_law_of_bodies_at_finite_strain_is_warned_of(read):
    text = deck_of(SMALL, step(PRESS.format(1)), SLIDES, interaction=LINEAR.format(50))
    scene = read(text.replace("*ELASTIC\n100.0, 0.3", RUBBER))
    assert scene.scene.contacts[0].overclosure is None
    assert any("without the soft linear" in warning for warning in scene.scene.warnings)


def test_the_soft_law_that_is_refused_at_once(read):
    with refused(fc.InputError, "input", "never part"):
        read(deck_of(SMALL, step(PRESS.format(1)), SLIDES, interaction="*SURFACE BEHAVIOR, NO SEPARATION\n"))


@pytest.mark.parametrize(("reach", "loose"), [("", True), (", POSITION TOLERANCE=0.15", False)])
def test_ties_reach_as_far_as_the_deck_says(reach, loose, read):
    cap = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1), element="hex8").translated((0.0, 0.0, 2.0))
    # one corner of four lies a tenth above the block below, of size one
    cap = cap.mapped(lambda x: x + 0.1 * np.outer((x[:, 2] < 2.1) & (x[:, 0] + x[:, 1] > 1.9), [0, 0, 1]))
    model = (
        f"{listed('CAP', cap, 9001)}*SOLID SECTION, ELSET=CAP, MATERIAL=M\n*TIE, NAME=T{reach}\n"
        f"CAP_face_bottom, UP_face_top\n{SLIDES}CAP_x_min, 1\nCAP_y_min, 2\n"
    )
    result = read(deck_of(SMALL, step("*DSLOAD\nCAP_face_top, P, 1.\n"), model)).solve()
    found = [text for text in result.warnings if "stay loose" in text]
    assert bool(found) == loose
    if loose:
        assert "1 of 9 nodes of the tied 'CAP_face_bottom' lie up to 0.1 from 'UP_face_top'" in found[0]


#: A deck as Abaqus/CAE writes it: sections within parts, one part of which stands twice.
CAE = """*Heading
** Job name: blocks Model name: Model-1
*Preprint, echo=NO, model=NO, history=NO, contact=NO
*Part, name=Cube
{mesh}*Nset, nset=Set-1, generate
  1,  8,  1
*Elset, elset=Set-1
 1,
** Section: Section-1
*Solid Section, elset=Set-1, material=Gum
,
*End Part
*Assembly, name=Assembly
*Instance, name=Cube-1, part=Cube
*End Instance
*Instance, name=Cube-2, part=Cube
          0.,           0.,           1.
*End Instance
*Nset, nset=Foot, instance=Cube-1
{bottom}*Nset, nset=Head, instance=Cube-2
{top}*Elset, elset=_Lower_S2, internal, instance=Cube-1
 1,
*Surface, type=ELEMENT, name=Lower
_Lower_S2, S2
*Elset, elset=_Upper_S1, internal, instance=Cube-2
 1,
*Surface, type=ELEMENT, name=Upper
_Upper_S1, S1
*End Assembly
*Material, name=Gum
*Elastic
100., 0.3
*Surface Interaction, name=IntProp-1
1.,
*Friction
0.,
*Surface Behavior, pressure-overclosure=HARD
*Boundary
Foot, ENCASTRE
*Contact Pair, interaction=IntProp-1, small sliding, type=SURFACE TO SURFACE, adjust=0.0
Upper, Lower
*Step, name=Step-1, nlgeom=NO
*Static
1., 1., 1e-05, 1.
*Boundary
Head, 1, 1
Head, 2, 2
Head, 3, 3, -0.05
*Restart, write, frequency=0
*Output, field, variable=PRESELECT
*Output, history, variable=PRESELECT
*End Step
"""


#: A reference point of the assembly, with a coupling to the top of the upper cube.
POINT = """*Node
      1,  0.3,  0.4,  3.
*Nset, nset=m_Set-1
 1,
*Elset, elset=_Top_S2, internal, instance=Cube-2
 1,
*Surface, type=ELEMENT, name=s_Surf-1
_Top_S2, S2
*Coupling, constraint name=Constraint-1, ref node=m_Set-1, surface=s_Surf-1
*Kinematic
*End Assembly
"""


@pytest.mark.parametrize("point", [False, True])
def test_the_form_of_abaqus_cae(point, read):
    cube = SMALL[0]
    mesh = listed("X", cube, 1).partition("*NSET")[0].replace(", ELSET=X", "")
    sets = {side: "".join(f"{n + 1},\n" for n in cube.boundary_nodes(side).tolist()) for side in ("bottom", "top")}
    text = CAE.replace("*End Assembly\n", POINT) if point else CAE
    if point:
        head = "Head, 1, 1\nHead, 2, 2\nHead, 3, 3, -0.05\n"
        text = text.replace(head, "m_Set-1, 1, 2\nm_Set-1, 3, 3, -0.05\nm_Set-1, 4, 6\n")
    scene = read(text.format(mesh=mesh, **sets))
    assert [b.name for b in scene.scene.bodies] == ["Cube-1", "Cube-2"]
    assert not scene.scene.warnings
    assert scene.options == {"finite_motion": False}
    python = scene_of(SMALL)
    expected = python.solve(motions={python.bodies[1]: {"z": -0.05}}).contacts[0].total_force
    assert abs(scene.solve().contacts[0].total_force - expected) < 1e-9 * expected
    asked = "requests for output are not used: *PREPRINT, *RESTART, *OUTPUT."
    assert any(asked in note for note in scene.notes)


def tilt_of(result):
    """Slope of the top's settlement along x, by least squares."""
    body = result.scene.bodies[1]
    top = body.mesh.boundary_nodes("UP_face_top")
    x = body.mesh.points[top]
    columns = np.stack([np.ones(len(x)), x[:, 0], x[:, 1]], axis=1)
    return np.linalg.lstsq(columns, result.displacement(result._given(body))[top, 2], rcond=None)[0][1]


@pytest.mark.full
def test_nlgeom_is_followed_and_what_it_changes_is_said(read):
    meshes = blocks(divisions=((3, 3, 3), (3, 3, 3)))
    top = meshes[1].boundary_nodes("top")
    at = top[np.argmin(np.linalg.norm(meshes[1].points[top] - [2 / 3, 1 / 3, 2], axis=1))] + 5001
    # a block that is free to tilt about y, under a force beside its middle
    held = "*BOUNDARY\nLOW_bottom, 1, 3\nLOW_y_min, 2\nUP_y_min, 2\n5001, 1\n"
    load = f"*CLOAD\n{at}, 3, -1.\n"
    linear = read(deck_of(meshes, step(load), held))
    assert linear.options == {"finite_motion": False}
    one = linear.solve()
    # CalculiX 2.20, surface to surface, K = 1e6
    assert abs(tilt_of(one) + 0.03255059) < 5e-6
    assert any("linearised motions leave out" in text for text in one.warnings)
    finite = read(deck_of(meshes, step(load, "*STEP, NLGEOM\n"), held))
    two = finite.solve()
    # the same with NLGEOM in ten increments, with finite strains of some percent under the force too
    assert abs(tilt_of(two) + 0.03847803) < 0.03 * 0.0385
    three = finite.scene.solve(**finite.loads, finite_motion=True)
    assert abs(tilt_of(two) / tilt_of(three) - 1) < 1e-4
    assert not any("Bodies move" in text for text in (*two.warnings, *three.warnings))
    for result in (two, three):
        assert any("rigid motions differ by 21 % and forces of contacts by 0.026 %" in text for text in result.notes)
    # of an order that the force overturns
    with_more = read(deck_of(meshes, step(load.replace("-1.", "-3."), "*STEP, NLGEOM\n"), held)).solve()
    assert any("the poses have not settled" in text for text in with_more.warnings)
