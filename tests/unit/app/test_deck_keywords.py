"""Decks with sectors, temperatures, rotations, gaps and contacts of steps, and soft laws by a table.

Sources: closed forms, named at each.
"""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from tests.deck_text import blocks, deck_of, listed, step

PRESS = "*DSLOAD\nUP_face_top, P, {0}\n"
#: Free to spread, so that the contact's force is the load's.
SLIDES = "*BOUNDARY\nLOW_bottom, 3\nLOW_x_min, 1\nLOW_y_min, 2\nUP_x_min, 1\nUP_y_min, 2\n"
SMALL = blocks(divisions=((1, 1, 1), (1, 1, 1)))


def sector_deck(loads, sectors=8, model="", turn=0.0, at="*BOUNDARY\nS_bottom, 3\n"):
    """A sector of a ring, 1 to 2, of hex20, its sides x_min and y_min the two ends of the angle."""
    angle = 2 * np.pi / sectors
    block = fc.shapes.block((1.0, 1.0, 0.5), (4, 2, 1))

    def bent(x):
        r, phi = 1 + x[:, 0], turn + angle * x[:, 1]
        return np.stack([r * np.cos(phi), r * np.sin(phi), x[:, 2]], axis=1)

    mesh = block.mapped(bent)
    text = listed("S", mesh, 1)
    faces = {name: mesh.faces(name).tolist() for name in ("y_max", "x_max")}
    labels = (6, 4, 3, 5, 1, 2)
    for name, own in faces.items():
        text += f"*SURFACE, NAME=S_face_{name}\n" + "".join(f"{c + 1}, S{labels[f]}\n" for c, f in own)
    text += "*MATERIAL, NAME=M\n*ELASTIC\n100., .3\n*DENSITY\n2.,\n" + model
    text += "*SOLID SECTION, ELSET=S, MATERIAL=M\n*TIE, NAME=T, CYCLIC SYMMETRY\nS_face_y_max, S_face_y_min\n"
    text += f"*CYCLIC SYMMETRY MODEL, N={sectors}, TIE=T\n0., 0., 0., 0., 0., 1.\n{at}"
    return text + step(loads), mesh


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_a_sector_under_pressure_is_lames_ring(turn, read):
    """u_r by Lame, free along the axis (plane stress), on every node alike; nothing turns about the axis."""
    text, mesh = sector_deck("*DSLOAD\nS_face_x_min, P, .01\n", turn=turn, at=hold_turn())
    result = read(text).solve()
    (body,) = result.scene.bodies
    x, u = mesh.points, result.displacement(body)
    r = np.hypot(x[:, 0], x[:, 1])
    radial = (u[:, :2] * x[:, :2]).sum(axis=1) / r
    a, b, p, E, nu = 1.0, 2.0, 0.01, 100.0, 0.3
    exact = p * a**2 / (E * (b**2 - a**2)) * ((1 - nu) * r + (1 + nu) * b**2 / r)
    assert np.abs(radial - exact).max() <= 3e-3 * exact.max()
    around = (x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]) / r
    assert np.abs(around).max() <= 3e-3 * exact.max()
    assert result.status == "solved"


def hold_turn():
    """Supports of a sector: its bottom, and against a turn about the axis one node of the side at angle zero."""
    return "*BOUNDARY\nS_bottom, 3\n*TRANSFORM, NSET=S_y_min, TYPE=C\n0., 0., 0., 0., 0., 1.\n*BOUNDARY\n1, 2\n"


def test_a_spinning_sector_is_a_spinning_ring(read):
    """Timoshenko and Goodier, article 32: u_r of a rotating disc with a hole, plane stress."""
    w2 = 0.3
    loads = f"*DLOAD\nS, CENTRIF, {w2}, 0., 0., 0., 0., 0., 1.\n"
    text, mesh = sector_deck(loads, at=hold_turn())
    result = read(text).solve()
    (body,) = result.scene.bodies
    a, b, E, nu, rho = 1.0, 2.0, 100.0, 0.3, 2.0
    x = mesh.points
    r = np.hypot(x[:, 0], x[:, 1])
    radial = (result.displacement(body)[:, :2] * x[:, :2]).sum(axis=1) / r
    middle = np.abs(x[:, 2] - 0.25) < 1e-9  # the disc is thick: its mean over the height is that of plane stress
    exact = rho * w2 * (3 + nu) * (1 - nu) / (8 * E) * r
    exact *= a**2 + b**2 - (1 + nu) / (3 + nu) * r**2 + (1 + nu) / (1 - nu) * a**2 * b**2 / r**2
    assert middle.any()
    assert np.abs(radial - exact)[middle].max() <= 0.02 * exact.max()


def test_a_torque_on_a_sector_is_one_on_the_ring(read):
    """A distributing coupling to a node on the axis: u_t = M / (4 pi G h) (r / a^2 - 1 / r) of a ring held inside."""
    load = 0.05
    model = "*NODE\n9001, 0., 0., .25\n*COUPLING, REF NODE=9001, SURFACE=S_face_x_max, CONSTRAINT NAME=C\n"
    model += "*DISTRIBUTING, CYCLIC SYMMETRY\n"
    text, mesh = sector_deck(f"*CLOAD\n9001, 6, {load}\n", model=model, at="*BOUNDARY\nS_x_min, 1, 3\n")
    result = read(text).solve()
    x, u = mesh.points, result.displacement(result.scene.bodies[0])
    r = np.hypot(x[:, 0], x[:, 1])
    around = (x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]) / r
    exact = 8 * load / (4 * np.pi * 100.0 / 2.6 * 0.5) * (r - 1 / r)
    assert np.abs(around - exact).max() <= 2e-3 * exact.max()


def test_sectors_that_are_not_are_refused(read):
    text, _ = sector_deck("")
    for change, words in (
        (("N=8", "N=9"), ("tie-apart", "turned by 360/9")),
        (("N=8", "N=1"), ("cyclic-symmetry", "N of 2 or more")),
        (("N=8, TIE=T", "N=8, TIE=OTHER"), ("cyclic-symmetry", "found 0")),
        (("N=8", "N=8, CONTACT"), ("not-supported", "between the sides of a sector")),
    ):
        with refused(fc.InputError, *words):
            read(text.replace(*change))


HOT = "*EXPANSION\n1e-3,\n"


def test_temperatures_of_a_deck(read):
    """Blocks between a floor and a fixed head, nu = 0: both expand by a T, which their stiffness in series resists."""
    text = deck_of(blocks("hex20", "hex20"), step("*TEMPERATURE\nLOW_all, 70.\n"), SLIDES + "UP_top, 3\n")
    text = text.replace("100.0, 0.3\n", f"100.0, 0.0\n{HOT}")
    nodes = "".join(f"{n},\n" for n in range(1, len(blocks("hex20", "hex20")[0].points) + 1))
    initial = f"*NSET, NSET=LOW_all\n{nodes}*INITIAL CONDITIONS, TYPE=TEMPERATURE\nLOW_all, 20.\n*STEP"
    text = text.replace("*STEP", initial, 1)
    force = read(text).solve().contacts[0].total_force
    assert abs(force - 100.0 * 1e-3 * 50.0 / 2) <= 1e-9 * force


def test_temperatures_that_are_linear_between_planes(read):
    text = deck_of(blocks("hex20", "hex20"), step("*TEMPERATURE, LINTEMP\n{}"), SLIDES + "UP_top, 3\n")
    text = text.replace("100.0, 0.3\n", f"100.0, 0.0\n{HOT}")
    text = text.replace("*STEP", "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nLOW_top, 0.\n*STEP", 1)
    scene = read(text.format("0., 0., 2., -1., -10., 1., 10.\n0., 0., 1., 1.5, 7., 3., 7.\n"))
    low, up = (scene.loads["temperatures"][body] for body in scene.scene.bodies)
    z = [body.mesh.points[:, 2] for body in scene.scene.bodies]
    assert np.abs(low - 10 * z[0]).max() <= 1e-12
    expected = np.where(z[1] >= 1.5, 7.0, np.where(z[1] > 1 + 1e-9, 0.0, 10.0))
    deck_nodes = scene.scene.bodies[1].mesh.points.shape[0] - (len(up) - len(expected))
    assert np.abs(up - expected)[:deck_nodes].max() <= 1e-12
    with refused(fc.InputError, "temperature", "the same"):
        read(text.format("0., 0., 1., 1., -10., 1., 10.\n"))


def test_elements_of_two_sections_are_of_the_later_one(read):
    text = deck_of(SMALL, step(PRESS.format(1)), SLIDES)
    soft = "*MATERIAL, NAME=SOFT\n*ELASTIC\n10., .3\n*SOLID SECTION, ELSET=UP, MATERIAL=SOFT\n*SURFACE INTERACTION"
    scene = read(text.replace("*SURFACE INTERACTION", soft))
    assert [body.material.E for body in scene.scene.bodies] == [100.0, 10.0]
    assert any("an earlier *SOLID SECTION" in note for note in scene.notes)


def test_a_step_that_does_not_heat_leaves_expansion_out(read):
    text = deck_of(SMALL, step(PRESS.format(0.1)), SLIDES).replace("100.0, 0.3\n", f"100.0, 0.3\n{HOT}")
    assert abs(read(text).solve().contacts[0].total_force - 0.1) <= 1e-12
    for more in ("*EXPANSION, TYPE=ANISO\n1., 1., 1., 0., 0., 0.\n", "*EXPANSION\n1., 0.\n2., 9.\n"):
        hot = text.replace(HOT, more).replace("*DSLOAD", "*TEMPERATURE\nLOW_bottom, 30.\n*DSLOAD")
        with refused(fc.InputError, "expansion", "one or three coefficients"):
            read(hot)


@pytest.mark.parametrize(("adjust", "closed"), [("", False), (", ADJUST=.05", False), (", ADJUST=.15", True)])
def test_adjust_closes_gaps_within_its_reach(adjust, closed, read):
    """The upper block hangs a tenth above the lower one; moved down by .05 it presses only if the gap was closed."""
    lower, upper = SMALL
    text = deck_of((lower, upper.translated((0, 0, 0.1))), step("*BOUNDARY\nUP_top, 3, 3, -.05\n"), SLIDES)
    text = text.replace("*CONTACT PAIR, INTERACTION=I\n", f"*CONTACT PAIR, INTERACTION=I{adjust}\n")
    contact = read(text).solve().contacts[0]
    assert (contact.total_force > 0) == closed
    # columns of heights 1 and 1.1 in series
    assert abs(contact.total_force - (0.05 * 100 / 2.1 if closed else 0)) <= 1e-9


@pytest.mark.parametrize("given", ["UP_bottom", "UP_top", "nothing"])
def test_adjust_moves_the_nodes_of_a_set(given, read):
    """At any distance; a set without nodes of the slave moves none."""
    lower, upper = SMALL
    text = deck_of((lower, upper.translated((0, 0, 0.1))), step("*BOUNDARY\nUP_top, 3, 3, -.05\n"), SLIDES)
    text = text.replace("*CONTACT PAIR, INTERACTION=I\n", f"*CONTACT PAIR, INTERACTION=I, ADJUST={given}\n")
    if given == "nothing":
        with refused(fc.InputError, "input", "there is no node set 'nothing'"):
            read(text)
        return
    assert abs(read(text).solve().contacts[0].total_force - 0.05 * 100 / 2.1 * (given == "UP_bottom")) <= 1e-9


@pytest.mark.parametrize("spring", ["", "*ELEMENT, TYPE=SPRING1, ELSET=SP\n99999, 5001\n*SPRING, ELSET=SP\n3\n1e-9,\n"])
@pytest.mark.parametrize("value", [0.02, -0.02])
def test_clearance_sets_the_gap(value, spring, read):
    """Of a part by itself as a whole, whose cells keep their height; of one that is joined to others by its nodes."""
    text = deck_of(SMALL, step("*BOUNDARY\nUP_top, 3, 3, -.05\n"), SLIDES)
    clear = f"{spring}*CLEARANCE, SLAVE=UP_face_bottom, MASTER=LOW_face_top, VALUE={value}\n*STEP"
    result = read(text.replace("*STEP", clear, 1)).solve()
    height = 1 - value if spring else 1.0
    assert abs(result.contacts[0].total_force - (0.05 - value) * 100 / (1 + height)) <= 1e-9
    assert any("*CLEARANCE moves" in text and "by up to 0.02," in text for text in result.warnings) == bool(spring)


CHANGE = "*MODEL CHANGE, TYPE=CONTACT PAIR, {}\nUP_face_bottom, LOW_face_top\n"


def test_contacts_of_steps(read):
    off, on = (CHANGE.format(word) for word in ("REMOVE", "ADD"))
    push = "*BOUNDARY\nUP_top, 3, 3, -.05\n"
    held = SLIDES + "UP_top, 3\n"
    scene = read(deck_of(SMALL, step(off) + step(on + push), held))
    assert any("step 1 left out" in text for text in scene.scene.warnings)
    assert abs(scene.solve().contacts[0].total_force - 2.5) <= 1e-9
    last = read(deck_of(SMALL, step(push) + step(off), held))
    assert any("step 2 left out" in text for text in last.scene.warnings)
    with refused(fc.InputError, "not-supported", "MODEL CHANGE", "friction"):
        read(deck_of(SMALL, step(off) + step(on + push), held, "*FRICTION\n.3,\n"))


K = 3.0
#: Springs at the four nodes of the upper block's top: to nodes above them, which are held; or along z to the ground.
SPRINGS = {
    "SPRINGA": (
        "*NODE, NSET=ABOVE\n{above}*ELEMENT, TYPE=SPRINGA, ELSET=SP\n{two}*SPRING, ELSET=SP\n\n3.,\n"
        "*BOUNDARY\nABOVE, 1, 3\n"
    ),
    "SPRING2": (
        "*NODE, NSET=ABOVE\n{above}*ELEMENT, TYPE=SPRING2, ELSET=SP\n{two}*SPRING, ELSET=SP\n3, 3\n3.,\n"
        "*BOUNDARY\nABOVE, 1, 3\n"
    ),
    "SPRING1": "*ELEMENT, TYPE=SPRING1, ELSET=SP\n{one}*SPRING, ELSET=SP\n3\n3.,\n",
}


def sprung(kind):
    upper = SMALL[1]
    top = upper.boundary_nodes("top")
    x = upper.points[top]
    text = SPRINGS[kind].format(
        above="".join(f"{9000 + k}, {a[0]}, {a[1]}, 5.\n" for k, a in enumerate(x.tolist())),
        two="".join(f"{9500 + k}, {9000 + k}, {5001 + n}\n" for k, n in enumerate(top.tolist())),
        one="".join(f"{9500 + k}, {5001 + n}\n" for k, n in enumerate(top.tolist())),
    )
    return deck_of(SMALL, step(PRESS.format(0.1)), text + SLIDES)


@pytest.mark.parametrize("kind", list(SPRINGS))
def test_springs_take_a_part_of_the_load(kind, read):
    """Columns 2 / E deep in parallel to four springs: F = P / (1 + 8 K / E)."""
    result = read(sprung(kind)).solve()
    force = result.contacts[0].total_force
    assert abs(force - 0.1 / (1 + 8 * K / 100)) <= 1e-9
    assert abs(sum(spring.tension for spring in result.springs) - (0.1 - force)) <= 1e-9


def test_springs_that_cannot_be_used_are_refused(read):
    for kind, change, words in (
        ("SPRINGA", ("*BOUNDARY\nABOVE, 1, 3\n", ""), ("spring-loose", "9000")),
        ("SPRINGA", ("*SPRING, ELSET=SP", "*SPRING, ELSET=SP, NONLINEAR"), ("spring-law", "linear")),
        ("SPRINGA", ("*SPRING, ELSET=SP", "*SPRING, ELSET=OTHER"), ("spring-law", "no *SPRING")),
        ("SPRING2", ("\n3, 3\n3.,", "\n1, 1\n3.,"), ("spring-axis", "SPRING2")),
        ("SPRING1", ("\n3\n3.,", "\n4\n3.,"), ("spring-axis", "no component 4")),
        ("SPRINGA", ("9500, 9000, ", "9500, 5002, "), ("spring-ends", "both ends")),
    ):
        with refused(fc.InputError, *words):
            read(sprung(kind).replace(*change))


def law(form, lines):
    return f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE={form}\n{lines}"


@pytest.mark.parametrize("form", ["TABULAR", "EXPONENTIAL"])
def test_soft_laws_by_a_table(form, read):
    """Columns in series with the law: -u = p (1 / E + 1 / E) + d(p)."""
    lines = {"TABULAR": "0., 0.\n.5, .01\n3., .02\n", "EXPONENTIAL": ".02, .5\n"}[form]
    text = deck_of(SMALL, step("*BOUNDARY\nUP_top, 3, 3, -.05\n"), SLIDES, interaction=law(form, lines))
    contact = read(text).solve().contacts[0]
    p = contact.max_pressure
    overlap = 0.05 - 2 * p / 100
    exact = np.interp(p, [0, 0.5, 3.0], [0, 0.01, 0.02]) if form == "TABULAR" else 0.02 * np.log(p / 0.5) / np.log(100)
    assert abs(overlap - exact) <= (1e-9 if form == "TABULAR" else 2e-5)


def test_tables_that_do_not_grow_are_refused(read):
    with refused(fc.InputError, "soft-contact-table", "deck.inp, line"):
        read(deck_of(SMALL, step(""), SLIDES, interaction=law("TABULAR", "1., 0.\n2., 1.\n")))
