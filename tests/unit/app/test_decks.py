"""Scenes from Abaqus and CalculiX decks: all keywords that are used, by problems with known answers."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.decks.materials import from_moduli, hyperelastic, hyperfoam, of_febio

# stresses and displacements that are linear in the coordinates are exact
ROUNDING = 1e-9


def nodes_of(mesh, first):
    return "".join(f"{k + first}, {x!r}, {y!r}, {z!r}\n" for k, (x, y, z) in enumerate(mesh.points.tolist()))


def cells_of(mesh, first, first_node):
    return "".join(
        f"{k + first}, {', '.join(str(n + first_node) for n in cell)}\n" for k, cell in enumerate(mesh.cells.tolist())
    )


def numbers(values, first):
    return "".join(f"{v + first},\n" for v in values.tolist())


def faces(mesh, name, first):
    # local faces -x, +x, -y, +y, -z, +z as Abaqus's S6, S4, S3, S5, S1, S2
    label = np.array([6, 4, 3, 5, 1, 2])
    return "".join(f"{cell + first}, S{label[face]}\n" for cell, face in mesh.faces(name).tolist())


LOWER = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
UPPER = fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 1), element="hex8").translated((0.0, 0.0, 1.0))
CAP = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1), element="hex8").translated((0.0, 0.0, 1.5))

#: Three blocks, the upper two tied to each other, the slave's facets nested in the master's; nodes and elements from 1,
#: 101 and 201.
MESHES = "*HEADING\nthree blocks\n" + "".join(
    f"*NODE, NSET=N{name}\n{nodes_of(mesh, first)}*ELEMENT, TYPE=C3D8, ELSET={name}\n{cells_of(mesh, first, first)}"
    f"*NSET, NSET={name}_x\n{numbers(mesh.boundary_nodes('x_min'), first)}"
    f"*NSET, NSET={name}_y\n{numbers(mesh.boundary_nodes('y_min'), first)}"
    f"*NSET, NSET={name}_foot\n{numbers(mesh.boundary_nodes('bottom'), first)}"
    f"*NSET, NSET={name}_head\n{numbers(mesh.boundary_nodes('top'), first)}"
    f"*SURFACE, NAME={name}_below\n{faces(mesh, 'bottom', first)}"
    f"*SURFACE, NAME={name}_above\n{faces(mesh, 'top', first)}"
    for name, mesh, first in (("Lower", LOWER, 1), ("Upper", UPPER, 101), ("Cap", CAP, 201))
)
MODEL = """*MATERIAL, NAME=Cork
*ELASTIC
10., 0.
*DENSITY
2.,
*MATERIAL, NAME=Rubber
*HYPERELASTIC, NEO HOOKE
2.5, 0.6
*PLASTIC
1., 0.
*SOLID SECTION, ELSET=Lower, MATERIAL=cork
*SOLID SECTION, ELSET=Upper, MATERIAL=Cork
*SOLID SECTION, ELSET=Cap, MATERIAL=Cork
*TIE, NAME=Glue, POSITION TOLERANCE=0.1
Upper_above, Cap_below
*SURFACE INTERACTION, NAME=Dry
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
1e6,
*FRICTION
{friction}, 1e5
*CONTACT PAIR, INTERACTION=Dry, TYPE=SURFACE TO SURFACE
Upper_below, Lower_above
*BOUNDARY
Lower_foot, 3, 3
Lower_foot, 1, 2, 0.
Upper_x, XSYMM
Upper_y, 2
Cap_x, 1
Cap_y, YSYMM
*AMPLITUDE, NAME=Half
0., 0., 1., 0.5
*INITIAL CONDITIONS, TYPE=TEMPERATURE
NLower, 20.
"""


@pytest.fixture
def deck(written):
    """Path of a deck of the three blocks with given steps."""

    def make(steps, friction="0.0", change=("", "")):
        path = written((MESHES + MODEL.format(friction=friction)).replace(*change) + steps, "blocks.inp")
        return path

    return make


def force(result):
    """Force on the upper body, whichever the deck names first."""
    whole, (first, _) = result.contacts[0]._whole, result.contacts[0].bodies
    return whole.force if first.name != "Lower" else -whole.force


def step(loads, head="*STEP\n*STATIC\n1., 1.\n"):
    return f"{head}{loads}*NODE PRINT, NSET=NLower\nU\n*END STEP\n"


def test_a_pressure_goes_through_tie_and_contact(deck):
    scene = fc.read_scene(deck(step("*DSLOAD, AMPLITUDE=Half\nCap_above, P, 0.2\n")))
    assert scene.title == "three blocks"
    assert [b.name for b in scene.scene.bodies] == ["Lower", "body_2"]
    result = scene.solve()
    (contact,) = result.contacts
    assert np.abs(force(result) - [0, 0, 0.1]).max() < ROUNDING
    assert np.abs(contact.pressure - 0.1).max() < ROUNDING
    # by hand: sigma / E times the height, nu = 0, through the tie too
    for body in scene.scene.bodies:
        u = result.displacement(body)
        assert np.abs(u - np.array([0, 0, -0.01]) * body.mesh.points[:, 2:]).max() < ROUNDING


@pytest.mark.parametrize(
    "load",
    [
        "*DLOAD\nCap, P2, 0.1\n",
        "*CLOAD\nCap_head, 3, {0}\nCap_head, 3, {0}\n",
        "*DLOAD\n, GRAV, 0.05, 0., 0., -1.\n",
    ],
)
def test_loads_of_every_kind(load, deck):
    # the nine nodes of the head, each named twice; gravity on a volume of one and a density of two
    load = load.format(-0.1 / 18)
    result = fc.read_scene(deck(step(load))).solve()
    assert np.abs(force(result) - [0, 0, 0.1]).max() < ROUNDING


def test_a_prescribed_displacement_moves_the_supports(deck):
    change = ("Cap_y, YSYMM\n", "Cap_y, YSYMM\nCap_head, 3\n")
    path = deck(step("*BOUNDARY\nCap_head, 3, 3, -0.02\n"), change=change)
    result = fc.read_scene(path).solve()
    # two blocks of height two in series
    assert abs(force(result)[2] - 0.1) < ROUNDING
    # and one that deforms the body, as one of its nodes is moved
    assert fc.read_scene(deck(step("*BOUNDARY\n201, 3, 3, -0.02\n"), change=change)).loads["displacements"]


def test_steps_without_friction_are_cases(deck):
    push = "*DSLOAD\nCap_above, P, 0.1\n"
    more = step("*DSLOAD, OP=NEW\nCap_above, P, 0.3\n*CLOAD\nCap_head, 3, 0.\n", "*STEP, NLGEOM\n*STATIC\n")
    other = "*STEP\n*FREQUENCY\n5\n*END STEP\n"
    scene = fc.read_scene(deck(step(push) + other + more))
    assert [case["name"] for case in scene.cases] == ["step 1", "step 3"]
    rows = scene.sweep()
    forces = np.abs([row["contacts"][0]["force"][2] for row in rows])
    assert np.abs(forces - [0.1, 0.3]).max() < ROUNDING
    assert any("step 2 is left out: it is not static" in text for text in scene.scene.warnings)


def test_steps_with_friction_are_a_load_path(deck):
    push = step("*DSLOAD\nCap_above, P, 0.1\n")
    change = ("Upper_x, XSYMM\nUpper_y, 2\nCap_x, 1\n", "Upper_y, 2\n")
    drag = step(f"*CLOAD\nCap_head, 1, {0.02 / 9}\n")
    scene = fc.read_scene(deck(push + drag, "0.4", change))
    assert len(scene.steps) == 2
    path = scene.solve_path()
    forces = [force(result) for result in path.steps]
    assert np.abs(np.array(forces)[:, [0, 2]] - [[0, 0.1], [-0.02, 0.1]]).max() < 1e-6


@pytest.mark.parametrize(
    ("keyword", "mu", "note"),
    [
        ("*FRICTION\n0.4, 1e5", 0.4, False),
        ("*FRICTION, ANISOTROPIC\n0.4, 0.2", 0.4, True),
        ("*FRICTION, ROUGH\n", np.inf, False),
        ("*FRICTION, SLIP TOLERANCE=0.01\n0.4,", 0.4, False),
    ],
)
def test_friction_of_a_deck(deck, keyword, mu, note):
    path = deck(step("*DSLOAD\nCap_above, P, 0.1\n"), "0.4", ("*FRICTION\n0.4, 1e5", keyword))
    scene = fc.read_scene(path)
    assert scene.scene.contacts[0].mu == mu
    assert any("friction is the first coefficient, everywhere; ANISOTROPIC" in n for n in scene.scene.warnings) == note


def test_what_is_not_used_is_listed_by_line(deck):
    path = deck(step("*DSLOAD\nCap_above, P, 0.1\n*TEMPERATURE\nNLower, 30.\n"))
    lines = path.read_text().splitlines()
    scene = fc.read_scene(path)

    def place(keyword):
        return f"blocks.inp, line {next(k for k, text in enumerate(lines, start=1) if text.startswith(keyword))}"

    for keyword in ("*INITIAL CONDITIONS", "*TEMPERATURE"):
        assert f"{place(keyword)}: {keyword} is not used." in scene.notes
    asked = f"{place('*NODE PRINT')} and after: requests for output are not used: *NODE PRINT."
    assert asked in scene.notes
    assert any("the contact is hard, without the linear overclosure, a penalty" in note for note in scene.notes)
    yields = f"{place('*PLASTIC')}: *PLASTIC is not used: the material stays elastic above 1."
    assert scene.scene.warnings == (yields,)
    result = scene.solve()
    assert yields in result.warnings
    assert asked in result.notes
    assert yields in result.summary()["warnings"]
    assert f"Warning:   {yields}" in str(result)


def test_the_command_line_solves_decks(deck, tmp_path, capsys):
    path = deck(step("*DSLOAD\nCap_above, P, 0.1\n"))
    assert main(["solve", str(path), "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr()
    assert "three blocks" in told.out
    assert "Warning:   blocks.inp, line 342: *PLASTIC is not used" in told.out
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["blocks.json", "blocks.vtu"]
    assert main(["solve", str(path), "--dry-run"]) == 0
    assert "*PLASTIC is not used" in capsys.readouterr().out
    assert main(["solve", str(tmp_path / "absent.inp")]) == 2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("Lower, MATERIAL=cork", "Lower, MATERIAL=Steel"), ("unknown-material", "'STEEL'")),
        (("*SOLID SECTION, ELSET=Lower, MATERIAL=cork\n", ""), ("no-material", "blocks.inp: 8", "'Lower'")),
        (("ELSET=Lower, MATERIAL", "ELSET=Lowest, MATERIAL"), ("input", "element", "set of solids 'Lowest'")),
        (("Upper_below, Lower_above", "Upper_below, Lower_rim"), ("input", "surface", "of solids 'Lower_rim'")),
        (("Upper_below, Lower_above", "Upper_below, Cap_above"), ("no-contact", "are on one body")),
        (("Upper_above, Cap_below", "Upper_above, Lower_below"), ("tie-apart", "no node of the tied surface")),
        (("INTERACTION=Dry, TYPE", "INTERACTION=Wet, TYPE"), ("unknown-interaction", "'Wet'")),
        (("Lower_foot, 3, 3", "Lower_feet, 3, 3"), ("input", "'Lower_feet'")),
        (("*ELASTIC\n10., 0.", "*ELASTIC\n10., zero"), ("bad-value",)),
        (("*ELASTIC\n10.", "*ELASTIC, TYPE=ORTHO\n10."), ("elastic", "ORTHOTROPIC (9 constants)", "2 constants")),
        (("Lower, MATERIAL=cork", "Lower, MATERIAL=cork, ORIENTATION=grain"), ("unknown-orientation", "'grain'")),
        (
            ("*BOUNDARY\n", "*TRANSFORM, NSET=NLower\n1., 0., 0.\n*BOUNDARY\n"),
            ("transform", "two points"),
        ),
    ],
)
def test_decks_that_cannot_be_used(change, words, deck):
    with refused(fc.InputError, *words):
        fc.read_scene(deck(step("*DSLOAD\nCap_above, P, 0.1\n"), change=change))


def test_supports_that_change_make_cases_of_their_own(deck):
    """Each beside the deck of its step alone."""
    first = "*DSLOAD\nCap_above, P, 0.1\n"
    second = "*BOUNDARY, OP=NEW\nLower_foot, 1, 3\nCap_head, 1, 2\nCap_head, 3, 3, -.01\n"
    both = fc.read_scene(deck(step(first) + step(second)))
    assert [set(scene.bodies[1].supports.values()) for scene in both.scenes] == [{"x", "y"}, {"xyz"}]
    assert both.scenes[0].bodies[0] is both.scenes[1].bodies[0]
    alone = [fc.read_scene(deck(step(first))), fc.read_scene(deck(step(first + second)))]
    forces = np.array([result.solve().contacts[0].total_force for result in alone])
    assert abs(forces[1] - forces[0]) > 0.01
    assert np.abs(both.sweep().column("force") - forces).max() < ROUNDING
    assert abs(both.last_case()[1].contacts[0].total_force - forces[1]) < ROUNDING


def test_friction_that_changes_between_steps(deck):
    """Sliding blocks, by hand: mu times the force."""
    drag = "*BOUNDARY\nCap_head, 1, 1, {}\n"
    press = "*BOUNDARY, OP=NEW\nLower_foot, 1, 3\nCap_head, 1, 2\nCap_head, 3, 3, -.01\n"
    change = "*CHANGE FRICTION, INTERACTION=Dry\n*FRICTION\n0.1, 1e5\n"
    steps = step(press) + step(drag.format(0.05)) + step(drag.format(0.1) + change)
    path = fc.read_scene(deck(steps, friction="0.3")).solve_path()
    normal, across = path.forces[:, 0, 2], path.forces[:, 0, 0]
    assert abs(normal[1]) > 0.01
    assert np.abs(np.abs(across[1:]) - np.array([0.3, 0.1]) * np.abs(normal[1:])).max() < ROUNDING
    with refused(fc.InputError, "supports-change", "finite strain"):
        fc.read_scene(deck(steps, change=("*ELASTIC\n10., 0.\n", "*HYPERELASTIC, NEO HOOKE\n2.5, 0.6\n")))


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ("", ("input", "no static step")),
        (step("*BOUNDARY, TYPE=VELOCITY\nLower_foot, 3, 3, 1.\n"), ("input", "expected displacements")),
        (step("*CLOAD, AMPLITUDE=Whole\nCap_head, 3, -1.\n"), ("unknown-amplitude", "'Whole'")),
        (step("*DLOAD\nCap, P9, 1.\n"), ("bad-value", "face 'S9'")),
    ],
)
def test_steps_that_cannot_be_used(steps, words, deck):
    with refused((fc.InputError, fc.MeshError), *words):
        fc.read_scene(deck(steps))


def test_materials_at_rest():
    # mu and K by hand from each law's constants
    assert from_moduli(1.0, None).nu == 0.475
    cases = {
        ("MOONEY-RIVLIN", 1, (0.3, 0.2, 1.2)): (1.0, 2 / 1.2),
        ("YEOH", 3, (0.5, 9, 9, 1.2, 9, 9)): (1.0, 2 / 1.2),
        ("POLYNOMIAL", 2, (0.3, 0.2, 9, 9, 9, 1.2, 9)): (1.0, 2 / 1.2),
        ("OGDEN", 2, (0.4, 3.0, 0.6, -2.0, 1.2, 9)): (1.0, 2 / 1.2),
    }
    for (form, order, c), (mu, K) in cases.items():
        made = hyperelastic(form, order, c, None)
        assert abs(made.shear_modulus - mu) < ROUNDING
        assert abs(made.E / (3 * (1 - 2 * made.nu)) - K) < ROUNDING
    # stiff chains: Arruda-Boyce is neo-Hookean
    assert abs(hyperelastic("ARRUDA-BOYCE", 1, (1.0, 1e6, 1.2), None).shear_modulus - 1) < ROUNDING
    assert abs(hyperfoam(1, [1.0, 2.0, 0.25], None).E - 2.5) < ROUNDING
    for kind, values in (
        ("Ogden", {"c1": 2.0, "m1": 3.0, "k": 5 / 3}),
        ("Ogden unconstrained", {"c1": 2.0, "m1": 3.0, "cp": 1.0}),
        ("Veronda-Westmann", {"c1": 0.5, "c2": 2.0, "k": 5 / 3}),
        ("Arruda-Boyce", {"mu": 1.0, "N": 1e12, "k": 5 / 3}),
    ):
        made = of_febio(kind, values)
        assert abs(made.E - 2.5) < ROUNDING
        assert abs(made.nu - 0.25) < ROUNDING
    assert of_febio("muscle material", {}) is None
    # at finite strain the constants are those of the sums, with K = 2 / D, or 19.7 mu (nu = .475)
    finite = "finite-strain"
    assert hyperelastic("MOONEY-RIVLIN", 1, [0.3, 0.2, 0.5], 2.0, finite) == fc.MooneyRivlin(0.3, 0.2, 4.0, 2.0)
    assert hyperelastic("NEO HOOKE", 1, [0.5, 0.0], None, finite).at_rest.nu == pytest.approx(0.475, abs=1e-12)
    ogden = hyperelastic("OGDEN", 2, [0.4, 3.0, 0.6, -2.0, 0.5, 0.0], None, finite)
    assert ogden == fc.Ogden((0.4, 0.6), (3.0, -2.0), 4.0)
    for wrong in (("YEOH", 3, [0.5, 9, 9, 1.2, 9, 9]), ("OGDEN", 2, [0.4, 3.0, 0.6, -2.0, 0.5, 0.1])):
        with refused(fc.InputError, "unknown-law", wrong[0], "small-strain"):
            hyperelastic(*wrong, None, finite)
    with refused(fc.InputError, "unknown-law", "HYPERFOAM", "small-strain"):
        hyperfoam(1, [1.0, 2.0, 0.25], None, finite)
    for code, wrong in (("constants", ("NEO HOOKE", 1, [])), ("unknown-law", ("VAN DER WAALS", 1, [1.0]))):
        with refused(fc.InputError, code, wrong[0]):
            hyperelastic(*wrong, None)
