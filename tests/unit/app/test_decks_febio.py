"""Scenes from FEBio decks of all versions, by problems with known answers."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.cli import main
from fecontact.app.decks.assemble import make_scene
from fecontact.app.decks.febio import read_feb
from fecontact.app.decks.febio_steps import LoadCurve
from fecontact.app.decks.materials import law_of_febio

# displacements that are linear in the coordinates are exact
ROUNDING = 1e-9
# answers by hand are those of small strains
small_strain = partial(fc.read_scene, laws="small-strain")

LOWER = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
UPPER = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1), element="hex8").translated((0.0, 0.0, 1.0))


def part(mesh, name, first, material):
    nodes = "".join(f'<node id="{k + first}">{x},{y},{z}</node>' for k, (x, y, z) in enumerate(mesh.points.tolist()))
    cells = "".join(
        f'<elem id="{k + first}">{",".join(str(n + first) for n in cell)}</elem>'
        for k, cell in enumerate(mesh.cells.tolist())
    )
    return f'<Nodes>{nodes}</Nodes><Elements type="hex8" name="{name}"{material}>{cells}</Elements>'


def sets(mesh, name, first):
    out = ""
    for side, faces in mesh.boundaries.items():
        facets = mesh.face_nodes(faces) + first
        rows = "".join(f'<quad4 id="{k + 1}">{",".join(map(str, f))}</quad4>' for k, f in enumerate(facets.tolist()))
        listed = ",".join(map(str, (mesh.boundary_nodes(side) + first).tolist()))
        out += f'<Surface name="{name}_{side}">{rows}</Surface><NodeSet name="{name}_{side}">{listed}</NodeSet>'
    return out


def mesh_of(attributes=("", "")):
    return (
        part(LOWER, "Low", 1, attributes[0])
        + part(UPPER, "Up", 101, attributes[1])
        + sets(LOWER, "Low", 1)
        + sets(UPPER, "Up", 101)
    )


def hold(sides, version):
    """Supports normal to the named sides."""
    tags = {
        2: '<fix bc="{c}" node_set="{s}"/>',
        3: '<bc type="fix" node_set="{s}"><dofs>{c}</dofs></bc>',
        4: '<bc type="zero displacement" node_set="{s}"><{c}_dof>1</{c}_dof></bc>',
    }
    return "".join(tags[version].format(s=s, c=c) for s, c in sides)


SIDES = [("Low_bottom", "z"), ("Low_x_min", "x"), ("Low_y_min", "y"), ("Up_x_min", "x"), ("Up_y_min", "y")]
MATERIALS = """<Material><material id="1" name="Gel" type="{law}"><E>1</E><v>0</v><density>2</density></material>
<material id="2" name="Gum" type="neo-Hookean"><E>1</E><v>0</v></material></Material>"""
PAIR = '<SurfacePair name="Pair"><primary>Up_bottom</primary><secondary>Low_top</secondary></SurfacePair>'
DOMAINS = '<MeshDomains><SolidDomain name="Low" mat="Gel"/><SolidDomain name="Up" mat="Gum"/></MeshDomains>'
CONTACT = '<Contact><contact type="{kind}" surface_pair="Pair"><fric_coeff>{mu}</fric_coeff></contact></Contact>'
CURVE = """<LoadData>
<load_controller id="1" type="loadcurve"><points><pt>0,0</pt><pt>1,1</pt></points></load_controller>
<load_controller id="2" type="loadcurve"><points><pt>0,0</pt><pt>0.5,0</pt><pt>1,1</pt></points></load_controller>
</LoadData>"""
CONTROL = "<Control><time_steps>10</time_steps><step_size>0.1</step_size></Control>"
DOWN = """<bc type="prescribed displacement" node_set="Up_top"><dof>z</dof><value lc="1">-0.2</value>
<relative>0</relative></bc>"""
PRESS = '<Loads><surface_load type="pressure" surface="Up_top"><pressure lc="1">0.1</pressure></surface_load></Loads>'


@pytest.fixture
def deck(written):
    """Path of a deck of two blocks, version 4, with some text exchanged."""

    def make(loads=PRESS, bcs="", kind="sliding-elastic", mu=0.0, law="neo-Hookean", more="", sides=SIDES, pairs=PAIR):
        text = (
            f'<?xml version="1.0"?>\n<febio_spec version="4.0">{CONTROL}{MATERIALS.format(law=law)}'
            f"<Mesh>{mesh_of()}{pairs}</Mesh>{DOMAINS}<Boundary>{hold(sides, 4)}{bcs}</Boundary>{loads}"
            f"{CONTACT.format(kind=kind, mu=mu)}{CURVE}\n{more}</febio_spec>"
        )
        path = written(text, "blocks.feb")
        return path

    return make


def force(result):
    """Force on the upper body, whichever the deck names first."""
    whole, (first, _) = result.contacts[0]._whole, result.contacts[0].bodies
    return whole.force if first.name != "Low" else -whole.force


def check_pressed(scene):
    """By hand: a pressure of 0.1 on blocks of E = 1, nu = 0."""
    result = scene.solve()
    assert np.abs(force(result) - [0, 0, 0.1]).max() < ROUNDING
    for body in scene.scene.bodies:
        expected = np.array([0, 0, -0.1]) * body.mesh.points[:, 2:]
        assert np.abs(result.displacement(body) - expected).max() < ROUNDING


def test_a_pressure_or_a_displacement_on_a_sliding_contact(deck):
    scene = small_strain(deck())
    assert [b.name for b in scene.scene.bodies] == ["Low", "Up"]
    at_rest = "neo-Hookean is linear, with the moduli at rest: E = 1, nu = 0."
    assert sum(at_rest in text for text in scene.scene.warnings) == 2
    check_pressed(scene)
    check_pressed(small_strain(deck(loads="", bcs=DOWN)))


@pytest.mark.parametrize(
    "loads",
    [
        '<Loads><surface_load type="traction" surface="Up_top"><scale lc="1">0.1</scale><traction>0,0,-1</traction>'
        "</surface_load></Loads>",
        '<Loads><nodal_load type="nodal_force" node_set="Up_top"><value lc="1">0,0,{0}</value></nodal_load></Loads>',
        '<Loads><nodal_load type="nodal_load" node_set="@surface:Up_top"><dof>z</dof><scale lc="1">{0}</scale>'
        "</nodal_load></Loads>",
    ],
)
def test_loads_of_every_kind(loads, deck):
    result = small_strain(deck(loads.format(-0.1 / 9))).solve()
    assert np.abs(force(result) - [0, 0, 0.1]).max() < ROUNDING


@pytest.mark.parametrize("version", ["2.5", "3.0"])
def test_older_versions(version, written):
    old = version == "2.5"
    pairs = '<SurfacePair name="Pair"><master surface="Low_top"/><slave surface="Up_bottom"/></SurfacePair>'
    mesh = mesh_of((' mat="1"', ' mat="2"')) + pairs if old else mesh_of() + PAIR
    tag, domains = ("Geometry", "") if old else ("Mesh", DOMAINS)
    down = (
        '<prescribe bc="z" node_set="Up_top"><scale lc="1">-0.2</scale><relative>0</relative></prescribe>'
        if old
        else '<bc type="prescribe" node_set="Up_top"><dof>z</dof><scale lc="1">-0.2</scale></bc>'
    )
    curve = '<LoadData><loadcurve id="1" type="linear"><point>0,0</point><point>1,1</point></loadcurve></LoadData>'
    path = written(
        f'<febio_spec version="{version}">{CONTROL}{MATERIALS.format(law="neo-Hookean")}<{tag}>{mesh}</{tag}>{domains}'
        f"<Boundary>{hold(SIDES, int(version[0]))}{down}</Boundary>"
        f"{CONTACT.format(kind='sliding-elastic', mu=0)}{curve}</febio_spec>",
        "old.feb",
    )
    check_pressed(small_strain(path))


def test_a_symmetry_plane_and_blocks_that_are_tied(deck):
    sides = [s for s in SIDES if s[0] != "Low_x_min"]
    mirror = '<Constraints><constraint type="symmetry plane" surface="Low_x_min"/></Constraints>'
    check_pressed(small_strain(deck(sides=sides, more=mirror)))
    assert not small_strain(deck(kind="tied-elastic")).scene.contacts


def test_tied_blocks_without_a_contact_at_finite_strain(deck):
    # no contact is left, and both blocks of E = 1, nu = 0 are stretched alike, by 0.9
    path = deck("", kind="tied-elastic", bcs=DOWN)
    path.write_text(path.read_text().replace("<density>2</density>", ""))
    scene = fc.read_scene(path)
    assert not scene.scene.contacts
    result = scene.solve()
    (body,) = scene.scene.bodies
    moved = result.displacement(body)
    assert np.abs(moved - np.array([0, 0, -0.1]) * body.mesh.points[:, 2:]).max() < 1e-9
    # what the laws leave on free nodes, and what the support below carries
    assert result.finite_strain
    strain = result.strain(body)
    assert abs(np.abs(strain).max() - np.log(1 / 0.9)) < 1e-9
    assert "equilibrium" in str(result)


def test_load_curves_with_a_bend_are_steps(deck):
    drag = '<scale lc="2">0.02</scale><traction>1,0,0</traction></surface_load></Loads>'
    loads = PRESS.replace("</Loads>", f'<surface_load type="traction" surface="Up_top">{drag}')
    sides = [s for s in SIDES if s[0] != "Up_x_min"]
    scene = small_strain(deck(loads, mu=0.5, sides=sides))
    assert len(scene.steps) == 2
    path = scene.solve_path()
    # half of the pressure without drag, then both
    assert np.abs([force(r) for r in path.steps] - np.array([[0, 0, 0.05], [-0.02, 0, 0.1]])).max() < 1e-6
    cases = small_strain(
        deck(PRESS.replace('lc="1"', 'lc="2"'), bcs=DOWN.replace('"1"', '"1"').replace("Up_top", "Up_bottom"))
    )
    assert [case["name"] for case in cases.cases] == ["t = 0.5", "t = 1"]


RIGID = """<Rigid><rigid_bc type="rigid_fixed"><rb>Gel</rb><Rx_dof>1</Rx_dof><Ry_dof>1</Ry_dof><Ru_dof>1</Ru_dof>
<Rv_dof>1</Rv_dof><Rw_dof>1</Rw_dof></rigid_bc>{0}</Rigid>"""
UP_HELD = [("Up_top", "z"), ("Up_x_min", "x"), ("Up_y_min", "y")]


@pytest.mark.parametrize(
    "drive",
    [
        '<rigid_bc type="rigid_displacement"><rb>Gel</rb><dof>z</dof><value lc="1">0.1</value></rigid_bc>',
        '<rigid_load type="rigid_force"><rb>1</rb><dof>Rz</dof><value lc="1">0.1</value></rigid_load>',
    ],
)
def test_a_rigid_part_that_is_moved_or_pushed(drive, deck):
    scene = small_strain(deck("", law="rigid body", sides=UP_HELD, more=RIGID.format(drive)))
    assert [b.name for b in scene.scene.bodies] == ["Up", "Gel"]
    assert np.abs(force(scene.solve()) - [0, 0, 0.1]).max() < ROUNDING


@pytest.mark.parametrize("axis", ["moved", "pushed"])
def test_nodes_that_a_rigid_part_holds(axis, deck):
    # a rigid part without cells carries the head of the upper block
    glue = '<bc type="rigid" node_set="Up_top"><rb>Cap</rb></bc>'
    cap = '<Material><material id="3" name="Cap" type="rigid body"/></Material>'
    drive = {
        "moved": '<rigid_bc type="rigid_displacement"><rb>Cap</rb><dof>z</dof><value lc="1">-0.2</value></rigid_bc>',
        "pushed": '<rigid_load type="rigid_force"><rb>Cap</rb><dof>Rz</dof><value lc="1">-0.1</value></rigid_load>',
    }[axis]
    rigid = RIGID.format(drive).replace("<rb>Gel", "<rb>Cap")
    scene = small_strain(deck("", bcs=glue, more=cap + rigid, sides=SIDES[:3]))
    assert np.abs(force(scene.solve()) - [0, 0, 0.1]).max() < ROUNDING


def test_nodes_on_a_rigid_part_that_turns_far_go_round_its_centre(deck):
    glue = '<bc type="rigid" node_set="Up_top"><rb>Cap</rb></bc>'
    cap = '<Material><material id="3" name="Cap" type="rigid body"/></Material>'
    turn = '<rigid_bc type="rigid_rotation_vector"><rb>Cap</rb><vz lc="1">0.4</vz></rigid_bc>'
    rigid = RIGID.format(turn).replace("<rb>Gel", "<rb>Cap").replace("<Ru_dof>", "<Rz_dof>1</Rz_dof><Ru_dof>")
    below = [("Low_bottom", c) for c in "xyz"]
    path = deck("", kind="tied-elastic", bcs=glue, more=cap + rigid, sides=below)
    text = path.read_text().replace("<density>2</density>", "")
    for laws in ("finite-strain", "small-strain"):
        path.write_text(text)
        scene = fc.read_scene(path, laws=laws)
        (body,) = scene.scene.bodies
        top = body.mesh.points[:, 2] == 2.0
        lever = body.mesh.points[top] - [0.5, 0.5, 2.0]
        moved = scene.solve().displacement(body)[top]
        c, s = np.cos(0.4), np.sin(0.4)
        finite, small = np.array([[c, -s], [s, c]]) - np.eye(2), np.array([[0.0, -0.4], [0.4, 0.0]])
        exact = lever[:, :2] @ (finite if laws == "finite-strain" else small).T
        assert np.abs(moved - np.column_stack([exact, 0 * exact[:, 0]])).max() < 1e-9


def test_what_is_not_used_is_a_warning_of_the_result(deck):
    more = "<Initial>\n</Initial><Boundary><bc type='zero fluid pressure' node_set='Up_top'/></Boundary>"
    result = small_strain(deck(more=more)).solve()
    for words in ("<Initial> is not used", "<bc type='zero fluid pressure'> is not used"):
        assert any(words in text and "blocks.feb, line " in text for text in result.warnings), words
    assert any("neo-Hookean is linear, with the moduli at rest" in text for text in result.warnings)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("<Contact><contact type='sticky' surface_pair='Pair'/></Contact>", ("not-supported", "'sticky'", "lost")),
        ("<Constraints><constraint type='tied-line'/></Constraints>", ("not-supported", "'tied-line'", "lost")),
        ("<Rigid><rigid_connector type='rigid joint'/></Rigid>", ("not-supported", "'rigid joint'", "lost")),
        ("<Rigid><rigid_bc type='rigid_euler_angles'><rb>Gel</rb></rigid_bc></Rigid>", ("not-supported", "euler")),
        ("<Control><analysis>DYNAMIC</analysis></Control>", ("dynamic", "inertia")),
        ("<MeshDomains><ShellDomain name='Skin' mat='Gum'/></MeshDomains>", ("not-supported", "'Skin'", "no solids")),
        (
            "<Step><step id='1'/><step id='2'><Contact><contact type='tied-elastic' surface_pair='Pair'/></Contact>"
            "</step></Step>",
            ("not-supported", "later step"),
        ),
    ],
)
def test_what_would_be_lost_is_refused(more, words, deck):
    with refused(fc.InputError, *words):
        small_strain(deck(more=more))


#: Times, and values by hand of each curve through (1, 1), (2, 4), (3, 9), (4, 9).
CURVES = {
    ("LINEAR", "CONSTANT"): {0.0: 1, 1.5: 2.5, 3.5: 9, 7.0: 9},
    ("STEP", "CONSTANT"): {0.0: 1, 1.0: 1, 1.5: 4, 2.0: 4, 2.1: 9, 5.0: 9},
    ("LINEAR", "EXTRAPOLATE"): {0.0: -2, 5.0: 9},
    ("LINEAR", "REPEAT"): {4.5: 2.5, 7.0: 9, 7.5: 2.5, -1.5: 2.5},
    ("LINEAR", "REPEAT OFFSET"): {4.5: 10.5, 7.0: 17, 7.5: 18.5},
    # parabolas x^2 through the first three, and -2.5 x^2 + 17.5 x - 21 through the last three
    ("SMOOTH", "CONSTANT"): {1.5: 2.25, 2.5: (6.25 + 7.125) / 2, 3.5: 9.625, 9.0: 9},
    # slope -2.5 at the end
    ("SMOOTH", "EXTRAPOLATE"): {5.0: 9 - 2.5 + 2.5 * 3 * 0.001},
}


@pytest.mark.parametrize(("how", "expected"), list(CURVES.items()))
def test_load_curves_of_every_kind(how, expected):
    points = "<pt>1,1</pt><pt>2,4</pt><pt>3,9</pt><pt>4,9</pt>"
    text = f"<interpolate>{how[0]}</interpolate><extend>{how[1]}</extend><points>{points}</points>"
    new = LoadCurve.of(ElementTree.fromstring(f'<load_controller id="1" type="loadcurve">{text}</load_controller>'))
    given = f'type="{how[0].lower()}" extend="{how[1].lower()}"'
    old = LoadCurve.of(ElementTree.fromstring(f'<loadcurve id="1" {given}>{points}</loadcurve>'))
    for time, value in expected.items():
        assert abs(new.at(time) - value) < 1e-9
        assert old.at(time) == new.at(time)


@pytest.mark.parametrize(("control", "end"), [(CONTROL.replace("10<", "5<"), 0.5), ("<Control/>", 1.0), ("", 1.0)])
def test_a_deck_ends_after_its_steps(control, end, deck):
    path = deck()
    path.write_text(path.read_text().replace(CONTROL, control))
    assert abs(force(small_strain(path).solve())[2] - 0.1 * end) < ROUNDING


def test_a_curve_that_repeats_bends_in_every_period(deck):
    repeated = CURVE.replace(
        "<points><pt>0,0</pt><pt>1,1</pt>", "<extend>REPEAT</extend><points><pt>0,0</pt><pt>.5,1</pt>"
    )
    path = deck()
    path.write_text(path.read_text().replace(CURVE, repeated))
    scene = small_strain(path)
    # the end of the second period equals that of the first, and is no step of its own
    assert abs(force(scene.solve())[2] - 0.1) < ROUNDING


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"law": "fluid"}, ("unknown-law", "'fluid'")),
        ({"loads": ""}, ("no-load",)),
        ({"loads": PRESS.replace("0.1", "1*scale")}, ("numbers", "'1*scale'")),
        ({"loads": PRESS.replace('lc="1"', 'lc="7"')}, ("unknown-curve", "'7'")),
        ({"pairs": ""}, ("input", "'Pair'")),
        ({"pairs": PAIR.replace("primary", "first")}, ("no-pair", "'Pair'", "primary")),
        ({"more": RIGID.format("")}, ("unknown-rigid-material", "'Gel'")),
        ({"bcs": DOWN.replace("<relative>0", "<relative>1")}, ("input", "relative")),
        ({"bcs": DOWN.replace("<dof>z", "<dof>w")}, ("input", "expected a component")),
        ({"loads": PRESS.replace("</Loads>", "<body_load type='point'/></Loads>")}, ("not-supported",)),
        ({"loads": PRESS.replace('surface="Up_top"', 'surface="Up_rim"')}, ("input", "no surface of solids")),
        ({"more": "<LoadData><loadcurve id='9' type='cubic spline'/></LoadData>"}, ("load-curve", "'cubic spline'")),
        ({"mu": "0.1</fric_coeff><tension>1</tension><fric_coeff>0.1"}, ("tension",)),
        (
            {"bcs": DOWN.replace("<value", "<valve").replace("</value", "</valve")},
            ("missing-element", "value> or <scale"),
        ),
    ],
)
def test_decks_that_cannot_be_used(options, words, deck):
    with refused(fc.InputError, *words):
        small_strain(deck(**options))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<E>1</E>", '<E lc="1">1</E>', ("not-supported", "E")),
        ("<fric_coeff>", '<fric_coeff lc="1">', ("not-supported",)),
        ("<Mesh>", '<Mesh from="other.feb"/><Mesh>', ("missing-files", "other.feb")),
    ],
)
def test_what_changes_with_time_or_is_missing(old, new, words, deck):
    path = deck()
    path.write_text(path.read_text().replace(old, new, 1))
    with refused(fc.InputError, *words):
        small_strain(path)


PAD = Path(fc.__file__).parents[1] / "meshes" / "pad_febio.feb"


WALL = """<Constraints><constraint type="rigid_wall" surface="Low_bottom"><plane>0,0,{scale},0</plane>
<offset lc="{curve}">{offset}</offset></constraint></Constraints>"""


def walled(deck, **wall):
    """The two blocks tied, on a wall; their head is held."""
    sides = [("Up_top", "z"), *SIDES[1:]]
    path = deck("", kind="tied-elastic", sides=sides, more=WALL.format(**wall))
    path.write_text(path.read_text().replace("<density>2</density>", ""))
    return path


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_a_rigid_wall_moves_along_its_normal(scale, deck):
    # FEBio measures gaps in lengths of the plane's normal, so an offset moves a plane a . x = d by offset / a^2
    scene = fc.read_scene(walled(deck, scale=scale, curve=1, offset=0.4 * scale**2))
    assert [b.name for b in scene.scene.bodies] == ["body_1", "wall of Low_bottom"]
    (contact,) = scene.solve().contacts
    # two blocks of nu = 0, shortened by a fifth: sigma = mu (l^2 - 1) / l
    assert abs(contact.total_force - 0.5 * (1 - 0.8**2) / 0.8) < 1e-8


def test_load_curves_with_laws_are_a_path(deck):
    curve = "<point>0,0</point><point>0.5,1</point><point>1,0.5</point>"
    path = walled(deck, scale=1.0, curve=3, offset=0.4)
    path.write_text(path.read_text().replace("<LoadData>", f'<LoadData><loadcurve id="3">{curve}</loadcurve>'))
    scene = fc.read_scene(path)
    assert not scene.cases
    forces = [result.contacts[0].total_force for result in scene.solve_path().steps]
    exact = [0.5 * (1 - stretch**2) / stretch for stretch in (0.8, 0.9)]
    assert np.abs(np.array(forces) - exact).max() < 1e-8


@pytest.mark.parametrize(
    "load", ["<body_load type='const'><z lc='1'>{0}</z>", "<body_load type='body force'><force lc='1'>0,0,{0}</force>"]
)
def test_body_loads_are_weights_with_the_sign_turned_over(load, deck):
    # a positive force of FEBio pulls down; the upper block has a volume of one and a density of three
    text = f"<Loads>{load.format(0.1)}</body_load></Loads>"
    materials = MATERIALS.format(law="neo-Hookean").replace(
        "<v>0</v></material></", "<v>0</v><density>3</density></material></"
    )
    path = deck(text)
    path.write_text(path.read_text().replace(MATERIALS.format(law="neo-Hookean"), materials))
    assert abs(force(small_strain(path).solve())[2] - 0.3) < ROUNDING
    with refused(fc.InputError, "not-supported", "part alone"):
        small_strain(deck(text.replace("<body_load", "<body_load elem_set='Up'")))


def test_walls_and_weights_that_cannot_be_used(deck):
    with refused(fc.InputError, "numbers", "plane"):
        fc.read_scene(walled(deck, scale="up", curve=1, offset=0.1))
    twice = walled(deck, scale=1.0, curve=1, offset=0.1)
    wall = WALL.format(scale=1.0, curve=1, offset=0.2)
    twice.write_text(twice.read_text().replace("<LoadData>", f"{wall}<LoadData>"))
    with refused(fc.InputError, "not-supported", "rigid_wall", "of its own"):
        fc.read_scene(twice)
    path = deck(PULL, law="rigid body", sides=UP_HELD, more=RIGID.format(PUSH))
    content = read_feb(path, "small-strain")
    (part,) = content.rigid
    with refused(fc.InputError, "not-supported", "'Gel' is free to move, and its mass is not known"):
        make_scene(replace(content, rigid=[replace(part, mass=None)]), path)


PULL = "<Loads><body_load type='const'><z>-0.05</z></body_load></Loads>"
PUSH = '<rigid_load type="rigid_force"><rb>1</rb><dof>Rz</dof><value lc="1">0.1</value></rigid_load>'


def test_a_rigid_part_that_is_free_has_weight(deck):
    def heavy(more):
        path = deck(PULL, law="rigid body", sides=UP_HELD, more=more)
        path.write_text(path.read_text().replace("<v>0</v></material></", "<v>0</v><density>3</density></material></"))
        return small_strain(path).solve()

    # the lower block, of volume one and density two, is pulled up by 2 * 0.05 and pushed by 0.1
    assert np.abs(force(heavy(RIGID.format(PUSH))) - [0, 0, 0.2]).max() < ROUNDING
    # a part that is held has its weight on its support; half of the upper block's, 3 * 0.05 upwards, is off the contact
    moved = '<rigid_bc type="rigid_displacement"><rb>Gel</rb><dof>z</dof><value lc="1">0.1</value></rigid_bc>'
    assert np.abs(force(heavy(RIGID.format(moved))) - [0, 0, 0.1 - 0.075]).max() < ROUNDING


def test_a_rigid_part_turns_about_its_centre_of_mass(deck):
    turn = '<rigid_bc type="rigid_rotation_vector"><rb>Gel</rb><vx/><vy lc="1">0.02</vy><vz lc="2">0.3</vz></rigid_bc>'
    rigid = RIGID.format(turn).replace("<Rw_dof>1</Rw_dof>", "<Rw_dof>1</Rw_dof><Rz_dof>1</Rz_dof>")
    rigid = rigid.replace("<vx/>", '<vx lc="1">0</vx>')
    content = read_feb(deck("", law="rigid body", sides=UP_HELD, more=rigid), "small-strain")
    assert np.abs(content.rigid[0].centre - 0.5).max() < 1e-14
    # nodes that crowd on one side do not move it
    path = deck("", law="rigid body", sides=UP_HELD, more=rigid)
    low = fc.shapes.block((1.0, 1.0, 1.0), (2, 1, 1), element="hex8").mapped(lambda x: x ** [2, 1, 1])
    text = path.read_text().replace(part(LOWER, "Low", 1, ""), part(low, "Low", 1, ""))
    path.write_text(text.replace(sets(LOWER, "Low", 1), sets(low, "Low", 1)))
    assert np.abs(read_feb(path, "small-strain").rigid[0].centre - 0.5).max() < 1e-14
    assert abs(content.rigid[0].mass - 2.0) < 1e-12
    assert content.steps[-1].frames[0].motions == {"ry": 0.02, "rz": 0.3}


#: FEBio's energies by principal stretches (l1, l2, l3), from its source and user's manual.
def energy_of(kind, v, stretches):
    J, squares = np.prod(stretches), stretches**2
    I1, I2 = squares.sum(), (squares.sum() ** 2 - (squares**2).sum()) / 2
    bulk = v.get("k", 0) / 2 * np.log(J) ** 2
    if "E" in v:
        lame, mu = v["E"] * v["v"] / ((1 + v["v"]) * (1 - 2 * v["v"])), v["E"] / (2 + 2 * v["v"])
    match kind:
        case "isotropic elastic":
            strain = (squares - 1) / 2
            return lame / 2 * strain.sum() ** 2 + mu * (strain**2).sum()
        case "neo-Hookean":
            return mu * ((I1 - 3) / 2 - np.log(J)) + lame / 2 * np.log(J) ** 2
        case "Holmes-Mow":
            Ha = lame + 2 * mu
            Q = np.exp(v["beta"] * ((2 * mu - lame) * (I1 - 3) + lame * (I2 - 3)) / Ha) / J ** (2 * v["beta"])
            return Ha / (4 * v["beta"]) * (Q - 1)
        case "Mooney-Rivlin":
            return v["c1"] * (I1 * J ** (-2 / 3) - 3) + v["c2"] * (I2 * J ** (-4 / 3) - 3) + bulk
        case "incomp neo-Hookean":
            return v["G"] / 2 * (I1 * J ** (-2 / 3) - 3) + bulk
        case "Ogden":
            own = stretches * J ** (-1 / 3)
            return sum(v[f"c{i}"] / v[f"m{i}"] ** 2 * ((own ** v[f"m{i}"]).sum() - 3) for i in (1, 2)) + bulk
        case "Ogden unconstrained":
            terms = ((v[f"c{i}"], v[f"m{i}"]) for i in (1, 2))
            parts = sum(c / m**2 * ((stretches**m).sum() - 3 - m * np.log(J)) for c, m in terms)
            return parts + v["cp"] / 2 * (J - 1) ** 2


OGDEN = {"c1": 2.0, "m1": 3.0, "c2": -0.5, "m2": -2.0}


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("isotropic elastic", {"E": 2.5, "v": 0.25}),
        ("neo-Hookean", {"E": 2.5, "v": 0.25}),
        ("Holmes-Mow", {"E": 2.5, "v": 0.25, "beta": 0.3}),
        ("Mooney-Rivlin", {"c1": 0.4, "c2": 0.1, "k": 5.0}),
        ("incomp neo-Hookean", {"G": 1.0, "k": 5.0}),
        ("Ogden", {**OGDEN, "k": 5.0}),
        ("Ogden unconstrained", {**OGDEN, "cp": 0.7}),
    ],
)
def test_constants_are_those_of_the_laws_energies(kind, values):
    law = law_of_febio(kind, values)
    for stretches in np.array([[1.3, 0.9, 0.7], [0.6, 1.1, 1.2], [1.0, 1.0, 1.0]]):
        # energies are of the order of the moduli, 1 to 5
        assert abs(float(law.response(np.diag(stretches)).energy) - energy_of(kind, values, stretches)) < 1e-13


def test_laws_that_are_not_offered_are_refused_by_name(deck):
    muscle, pressure = "trans iso Mooney-Rivlin", "<pressure_model>2</pressure_model>"
    solid = MATERIALS.replace("<E>1</E><v>0</v><density>2", '<solid type="{law}"><E>1</E><v>0</v></solid><density>2', 1)
    for old, new, words in (
        ("neo-Hookean", "isotropic Hencky", ("'isotropic Hencky'", "small-strain", "Holmes-Mow")),
        ("neo-Hookean", muscle, (muscle,)),
        ("</E><v>0</v><density>", f"</E><v>0</v>{pressure}<density>", ("pressure_model",)),
        ("</E><v>0</v><density>", "</E><v>0</v><pressure_model>Abaqus</pressure_model><density>", ("pressure_model",)),
    ):
        path = deck()
        path.write_text(path.read_text().replace(old, new, 1))
        with refused(fc.InputError, "unknown-law", *words):
            fc.read_scene(path)
    path = deck()
    path.write_text(path.read_text().replace(MATERIALS.format(law="neo-Hookean"), solid.format(law="neo-Hookean")))
    path.write_text(path.read_text().replace('name="Gel" type="neo-Hookean"', 'name="Gel" type="biphasic"'))
    with refused(fc.InputError, "unknown-law", "biphasic", "neo-Hookean", "small-strain"):
        fc.read_scene(path)
    warnings = small_strain(path).scene.warnings
    assert any("the solid of the biphasic material, neo-Hookean is linear" in text for text in warnings)


def test_laws_are_for_decks_and_have_two_names(deck, tmp_path, capsys):
    with refused(fc.InputError, "unknown-name", "'hooke'", "small-strain"):
        fc.read_scene(deck(), laws="hooke")
    (tmp_path / "scene.toml").write_text("")
    with refused(fc.InputError, "not-a-deck"):
        small_strain(tmp_path / "scene.toml")
    for laws, told in (("small-strain", True), ("finite-strain", False)):
        assert main(["solve", str(PAD), "--laws", laws, "--dry-run"]) == 0
        assert ("with the moduli at rest" in capsys.readouterr().out) == told
