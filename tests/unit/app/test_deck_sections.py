"""Sections in decks: CAX, CPE and CPS elements as bodies of revolution and plane bodies.

Figures named ccx are those of CalculiX 2.20 for the same deck, with a penalty of 1e5: the largest displacement of the
upper part and the contact force, of the whole ring or thickness.
"""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.decks.ccx import FrdField, compared

LOWER = fc.sections.rectangle((2.0, 1.0), (4, 2)).translated((1.0, 0, 0))
UPPER = fc.sections.rectangle((1.0, 1.0), (3, 2)).translated((1.5, 0, 1.0))
WIDE = fc.sections.rectangle((2.0, 1.0), (2, 2)).translated((1.0, 0, 1.0))
FIXED = "*BOUNDARY\nLOW_bottom, 1, 2\n"
DOWN = "*BOUNDARY\nUP_top, 2, 2, -.02\n"
PRESSED = "*DLOAD\n" + "".join(f"{501 + c}, P3, 1.5\n" for c in (3, 4, 5)) + "*CLOAD\nUP_top, 2, -.1\n"
FRICTION = "*FRICTION\n.3, 1e5\n"


def sheet(name, mesh, first, kind):
    """Nodes, elements, sets and surfaces of a section as elements of a type; triangles halve its cells."""
    n = int(kind[-1])
    cells = mesh.cells[:, : 8 if n > 4 else 4]
    x, added = mesh.points, np.arange(len(cells))[:, None] + len(mesh.points)
    if n == 6:
        # and nodes in the middles of diagonals
        x = np.concatenate([x, (x[cells[:, 0]] + x[cells[:, 2]]) / 2])
        one = np.concatenate([cells[:, [0, 1, 2, 4, 5]], added], axis=1)
        other = np.concatenate([cells[:, [0, 2, 3]], added, cells[:, [6, 7]]], axis=1)
        cells = np.concatenate([one, other])
    elif n == 3:
        cells = np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    used = np.unique(cells)
    out = "*NODE\n" + "".join(f"{first + k}, {x[k, 0].item()!r}, {x[k, 2].item()!r}\n" for k in used.tolist())
    out += f"*ELEMENT, TYPE={kind}, ELSET={name}\n"
    out += "".join(f"{first + k}, {', '.join(map(str, c))}\n" for k, c in enumerate((cells + first).tolist()))
    count = len(mesh.cells)
    for side in ("bottom", "top", "left", "right"):
        nodes = np.intersect1d(mesh.boundary_nodes(side), used) + first
        out += f"*NSET, NSET={name}_{side}\n" + "".join(f"{v},\n" for v in nodes.tolist())
        out += f"*SURFACE, NAME={name}_face_{side}\n"
        for cell, k in mesh.faces(side).tolist():
            # sides 0 and 1 of a cell are those of its first triangle, 2 and 3 the second and third of the other
            own = (cell, k) if n in (4, 8) or k < 2 else (cell + count, k - 1)
            out += f"{first + own[0]}, S{own[1] + 1}\n"
    return out


def deck(kind, loads, model=FIXED, friction="", lower=LOWER, upper=UPPER, nu=0.3, thickness=0.5, pair="bottom, top"):
    low, high = pair.split(", ")
    sections = "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=M\n{thickness}\n" for name in ("LOW", "UP"))
    return (
        f"{sheet('LOW', lower, 1, kind)}{sheet('UP', upper, 501, kind)}*MATERIAL, NAME=M\n*ELASTIC\n100., {nu}\n"
        f"*DENSITY\n1.,\n{sections}*SURFACE INTERACTION, NAME=I\n"
        f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E5,\n{friction}"
        f"*CONTACT PAIR, INTERACTION=I, TYPE=SURFACE TO SURFACE\nUP_face_{low}, LOW_face_{high}\n{model}"
        f"*STEP\n*STATIC\n{loads}*END STEP\n"
    )


TURNED = "*TRANSFORM, NSET=UP_top, TYPE=R\n1., .2, 0., -.2, 1., 0.\n*BOUNDARY\nUP_top, 2\n"
#: Type, loads, model, friction, and what ccx finds.
CASES = {
    "a ring that is moved": ("CAX8", DOWN, FIXED, "", 0.0219763, 15.4885),
    "a ring with friction": ("CAX8", DOWN, FIXED, FRICTION, 0.0210201, 16.334),
    "a ring that is pressed": ("CAX8", PRESSED, FIXED, "", 0.0436761, 21.6439),
    "turned axes in plane strain": (
        "CPE8", DOWN + "*CLOAD\nUP_top, 1, .001\n", FIXED + TURNED, FRICTION, 0.0241564, 0.588797,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_ccx_finds_the_same(name, read):
    kind, loads, model, friction, moved, force = CASES[name]
    result = read(deck(kind, loads, model, friction)).solve()
    u = np.linalg.norm(result.displacement(result.scene.bodies[1]), axis=1).max()
    assert abs(u - moved) < 0.003 * moved
    assert abs(np.linalg.norm(result.contacts[0].force) - force) < 0.001 * force


WOOD = "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n200., 100., 50., .3, .2, .25, 40., 30.\n20.,\n"
#: Type, data lines of *ORIENTATION, and the contact force by ccx, under `DOWN`, and heated by 10 between walls.
DIRECTED = [
    ("CPE8", "", 0.601499),
    ("CPE8", "NAME=O\n0., 0., 1., 1., 0.3, 0.\n", 0.292127),
    ("CPS8", "NAME=O\n1., .5, 0., -.5, 1., 0.\n", 0.585565),
    ("CAX8", "NAME=O, SYSTEM=CYLINDRICAL\n0., 0., 0., 0., 1., 0.\n", 7.51207),
]


def of_wood(text, axes):
    text = text.replace("*ELASTIC\n100., 0.3\n", WOOD)
    if axes:
        text = text.replace("*SOLID SECTION", f"*ORIENTATION, {axes}*SOLID SECTION", 1)
        text = text.replace("MATERIAL=M\n", "MATERIAL=M, ORIENTATION=O\n")
    return text


@pytest.mark.parametrize(("kind", "axes", "force"), DIRECTED)
def test_orthotropic_sections_press_as_those_of_ccx(kind, axes, force, read):
    result = read(of_wood(deck(kind, DOWN), axes)).solve()
    assert abs(result.contacts[0].total_force - force) < 0.001 * force


@pytest.mark.parametrize(("kind", "force"), [("CPE8", 1.54416), ("CAX8", 38.9726)])
def test_expansions_along_axes_press_as_those_of_ccx(kind, force, read):
    walls = "*BOUNDARY\nLOW_bottom, 1, 2\nUP_top, 1, 2\n"
    numbers = [k + first for mesh, first in ((LOWER, 1), (UPPER, 501)) for k in range(len(mesh.points))]
    nodes = "*NSET, NSET=ALL\n" + "".join(f"{n},\n" for n in numbers)
    initial = f"{nodes}*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 0.\n"
    text = of_wood(deck(kind, "*TEMPERATURE\nALL, 10.\n", walls + initial), "NAME=O\n1., .5, 0., -.5, 1., 0.\n")
    result = read(text.replace(WOOD, f"{WOOD}*EXPANSION, TYPE=ORTHO\n1e-3, 3e-3, -2e-3\n")).solve()
    assert abs(result.contacts[0].total_force - force) < 0.001 * force


def test_any_material_of_a_section_is_that_of_the_deck():
    """The material of a section, z of the deck as y, beside a rotation that does the same but for a reflection."""
    rng = np.random.default_rng(3)
    root = rng.normal(size=(6, 6))
    axes = fc.rotation_about((1.0, 0.4, -2.0), 0.8)
    given = fc.AnisotropicMaterial(root @ root.T + 6 * np.eye(6), axes=axes, expansion=(1.0, 2.0, 3.0))
    points = np.zeros((1, 3))
    order = np.array([0, 2, 1, 5, 4, 3])  # xx, zz, yy, xz, zy, xy
    made = given.exchanged()
    assert np.abs(made.at(points) - given.at(points)[:, order[:, None], order]).max() < 1e-12
    assert np.abs(made.expansion_at(points) - given.expansion_at(points)[:, order]).max() < 1e-12


@pytest.mark.parametrize("kind", ["CAX8", "CAX4", "CAX6", "CAX3"])
def test_rings_on_each_other_are_a_thick_cylinder(kind, read):
    """Lame: the radial stress where two rings meet is that of one, a <= r <= b, under an inner pressure p."""
    inner = fc.sections.rectangle((1.0, 0.5), (4, 1)).translated((1.0, 0, 0))
    outer = fc.sections.rectangle((1.0, 0.5), (4, 1)).translated((2.0, 0, 0))
    ends = "*BOUNDARY\nLOW_bottom, 2\nLOW_top, 2\nUP_bottom, 2\nUP_top, 2\n"
    text = deck(kind, "*DSLOAD\nLOW_face_left, P, 2.\n", ends, lower=inner, upper=outer, pair="left, right")
    result = read(text).solve()
    a, b, r, p = 1.0, 3.0, 2.0, 2.0
    expected = p * (b**2 / r**2 - 1) / (b**2 / a**2 - 1)
    assert np.abs(result.contacts[0].pressure - expected).max() < 0.01 * expected
    assert isinstance(result.scene.bodies[0], fc.AxisymmetricBody)
    assert not result.warnings  # the resultant is zero, of which no error is told


def test_a_ring_that_is_heated_presses_the_one_round_it(read):
    """ccx of the same deck, with a penalty of 1e7: how far the rings widen."""
    inner = fc.sections.rectangle((0.1, 0.1), (1, 1)).translated((0.95, 0, 0))
    outer = fc.sections.rectangle((0.1, 0.1), (1, 1)).translated((1.05, 0, 0))
    model = "*BOUNDARY\nLOW_bottom, 2\nUP_bottom, 2\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nLOW_top, 20.\n"
    hot = "".join(f"LOW_{side}, 120.\n" for side in ("bottom", "top", "left", "right"))
    text = deck("CAX8", f"*TEMPERATURE\n{hot}", model, lower=inner, upper=outer, pair="left, right")
    every = "".join(f"LOW_{side}, 20.\n" for side in ("bottom", "left", "right"))
    text = text.replace("*DENSITY\n", "*EXPANSION\n12.E-6,\n*DENSITY\n").replace(
        "LOW_top, 20.\n", f"LOW_top, 20.\n{every}"
    )
    result = read(text).solve()
    sizes = [np.linalg.norm(result.displacement(body), axis=1).max() for body in result.scene.bodies]
    assert np.abs(np.array(sizes) / (6.91884e-4, 6.77964e-4) - 1).max() < 3e-4


@pytest.mark.parametrize("state", ["CPE", "CPS"])
@pytest.mark.parametrize("nodes", [8, 6, 4, 3])
def test_two_blocks_in_a_plane_press_each_other_evenly(state, nodes, read):
    """Uniaxial stress: E in plane stress, E / (1 - nu^2) in plane strain, on a width of 2 and a thickness of .5."""
    model = "*BOUNDARY\nLOW_bottom, 2\nLOW_left, 1\nUP_left, 1\n"
    lower = fc.sections.rectangle((2.0, 1.0), (2, 2)).translated((1.0, 0, 0))
    result = read(deck(f"{state}{nodes}", DOWN, model, lower=lower, upper=WIDE)).solve()
    stiffness = 100.0 if state == "CPS" else 100.0 / (1 - 0.09)
    assert abs(result.contacts[0].total_force - stiffness * 0.01 * 2.0 * 0.5) < 1e-9
    assert {body.thickness for body in result.scene.bodies} == {0.5}


def test_weights_of_sets_and_sides_of_elements(read):
    """Gravity given set by set is one, and the number of an element names its side."""
    model = "*BOUNDARY\nLOW_bottom, 2\nLOW_left, 1\nUP_left, 1\n"
    lower = fc.sections.rectangle((2.0, 1.0), (2, 2)).translated((1.0, 0, 0))
    loads = "*DLOAD\nUP, GRAV, 3., 0., -1., 0.\nLOW, GRAV, 3., 0., -1., 0.\n"
    loads += "".join(f"{501 + cell}, P{side + 1}, .25\n" for cell, side in WIDE.faces("top").tolist())
    for kind, area in (("CPS8", 1.0), ("CAX8", 8 * np.pi)):
        result = read(deck(kind, loads, model, lower=lower, upper=WIDE, nu=0.0)).solve()
        assert abs(result.contacts[0].total_force - 3.25 * area) < 1e-8
    with refused(fc.InputError, "gravity-differs", "'UP'"):
        read(deck("CPS8", "*DLOAD\nUP, GRAV, 3., 0., -1., 0.\n", model))


def test_ties_and_reference_nodes_of_sections(read):
    """A tied column pushed at a reference node through a coupling: uniaxial stress, and no contact is left."""
    lower = fc.sections.rectangle((2.0, 1.0), (2, 2)).translated((1.0, 0, 0))
    model = "*BOUNDARY\nLOW_bottom, 2\nLOW_left, 1\nUP_left, 1\n*NODE, NSET=REF\n901, 2.2, 3.\n"
    tie = "*TIE, NAME=T\n"
    pushes = {
        "*COUPLING, REF NODE=901, SURFACE=UP_face_top\n*KINEMATIC\n2\n*BOUNDARY\n901, 1\n901, 6\n": "901, 2, -2.\n",
        "*COUPLING, REF NODE=901, SURFACE=UP_face_top\n*DISTRIBUTING\n1, 6\n": "901, 2, -2.\n901, 6, .4\n",
        "*EQUATION\n2\nUP_top, 2, 1., 901, 2, -1.\n": "901, 2, -2.\n",
    }
    for coupling, load in pushes.items():
        text = deck("CPS8", f"*CLOAD\n{load}", model + coupling, lower=lower, upper=WIDE, nu=0.0)
        text = text.replace("*CONTACT PAIR, INTERACTION=I, TYPE=SURFACE TO SURFACE\n", tie)
        result = read(text).solve()
        (body,) = result.scene.bodies
        top = result.displacement(body)[np.isclose(body.mesh.points[:, 2], 2.0), 2]
        # a force of 2 on an area of 1, which acts .2 beside the middle, and the moment that undoes it
        assert np.abs(top + 2 * 2.0 / 100.0).max() < 1e-9


def test_figures_of_ccx_are_in_its_axes(read):
    result = read(deck("CAX8", DOWN)).solve()
    numbers = np.concatenate([body.mesh.file_nodes for body in result.scene.bodies])
    u = np.concatenate([result.displacement(body) for body in result.scene.bodies])[:, [0, 2, 1]]
    found = compared(result, {"DISP": FrdField(numbers, u), "FORC": FrdField(numbers, 0 * u)}, 1.0)
    assert set(found.apart.values()) == {0.0}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("TYPE=CAX8, ELSET=UP", "TYPE=CPE8, ELSET=UP"), ("elements-mixed", "CAX8, CPE8")),
        (("TYPE=CAX8, ELSET=UP", "TYPE=CGAX8, ELSET=UP"), ("elements-mixed", "CGAX8")),
        (("UP_top, 2, 2, -.02", "UP_top, 3, 3, -.02"), ("across-section", "along z")),
        (("*STATIC\n", "*STATIC\n*CLOAD\nUP_top, 1, 1.\n"), ("load-not-in-plane", "axisymmetric")),
        (("1, 1.0, 0.0\n", "1, 1.0, 0.0, 0.5\n"), ("out-of-plane", "z varies")),
    ],
)
def test_what_cannot_be_done_is_said(change, words, read):
    text = deck("CAX8", DOWN)
    assert change[0] in text
    with refused((fc.InputError, fc.MeshError), *words):
        read(text.replace(*change, 1)).solve()


def test_a_body_has_one_thickness(read):
    text = deck("CPS8", DOWN).replace("*SOLID SECTION, ELSET=UP", "*ELSET, ELSET=HALF\n501,\n*SOLID SECTION, ELSET=UP")
    half = "*SOLID SECTION, ELSET=HALF, MATERIAL=M\n.7\n*SURFACE INTERACTION"
    with refused(fc.InputError, "thickness", "0.5, 0.7"):
        read(text.replace("*SURFACE INTERACTION", half))
