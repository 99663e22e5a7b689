"""Orthotropic and anisotropic materials of decks, with orientations, and of scene files.

The figures are those of CalculiX 2.20 for the same deck: the largest displacement of the lower block and the contact
force. Its contact there is a penalty of 1e5, whose 50 times as stiff one changes them by less than .03 %.
"""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.app.decks.elastic import linear_elastic, orientation
from fecontact.mesh.formats.abaqus_deck import KeywordSection
from tests.deck_text import blocks, deck_of, step

CUBES = blocks("hex20", "hex20", ((2, 2, 2), (3, 3, 2)))
MODEL = "*BOUNDARY\nLOW_bottom, 1, 3\nUP_top, 1, 2\n"
LOADS = "*BOUNDARY\nUP_top, 3, 3, -.02\nUP_top, 1, 1, .005\n"
PENALTY = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E5,\n"
#: *ELASTIC and *ORIENTATION of the lower block, displacement and force.
CASES = {
    "engineering constants, turned": (
        "TYPE=ENGINEERING CONSTANTS\n10.,2.,1.,.3,.2,.25,2.,1.5\n1.", "\n1.,.2,.1, -.2,1.,.05", 0.0204941, 0.0203169,
    ),
    "orthotropic, cylindrical": (
        "TYPE=ORTHO\n8.,1.5,4.,1.,.8,3.,1.2,1.\n.7", ", SYSTEM=CYLINDRICAL\n-.5,-.5,0.,-.5,-.5,1.",
        0.0202024, 0.0549319,
    ),
    "anisotropic": (
        "TYPE=ANISO\n8.,1.5,4.,1.,.8,3.,.2,.1\n.1,1.2,.1,.05,.2,.1,1.,.1\n.2,.1,.05,.1,.9",
        "\n0.,0.,1., 1.,0.,0.", 0.0193991, 0.138455,
    ),
}  # fmt: skip


def deck(tmp_path, elastic, axes):
    text = deck_of(CUBES, step(LOADS), MODEL, "*FRICTION\n.3, 1e5\n", PENALTY)
    wood = f"*MATERIAL, NAME=WOOD\n*ELASTIC, {elastic}\n*ORIENTATION, NAME=GRAIN{axes}\n"
    text = text.replace(
        "*SOLID SECTION, ELSET=LOW, MATERIAL=M\n",
        f"{wood}*SOLID SECTION, ELSET=LOW, MATERIAL=WOOD, ORIENTATION=Grain\n",
    )
    path = tmp_path / "deck.inp"
    path.write_text(text)
    return fc.read_scene(path)


@pytest.mark.parametrize("name", CASES)
def test_ccx_finds_the_same(name, tmp_path):
    elastic, axes, moved, force = CASES[name]
    result = deck(tmp_path, elastic, axes).solve()
    low = result.scene.bodies[0]
    assert np.linalg.norm(result.displacement(low), axis=1).max() == pytest.approx(moved, rel=1e-3)
    assert np.linalg.norm(result.contacts[0].force) == pytest.approx(force, rel=1e-3)


def given(parameters, *lines, keyword="ELASTIC"):
    return KeywordSection(keyword, parameters, list(lines), "a.inp, line 1")


def test_one_elastic_material_in_all_types():
    """E and nu by two, nine and 21 constants."""
    E, nu = 5.0, 0.25
    mu, lame = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    one, zero = lame + 2 * mu, [0.0] * 3
    plain, more = linear_elastic(given({}, f"{E}, {nu}"), None, 1e-5)
    constants = [*[E] * 3, *[nu] * 3, *[mu] * 3]
    orthotropic = [one, lame, one, lame, lame, one, *[mu] * 3]
    whole = [*orthotropic[:6], *zero, mu, *zero, 0.0, mu, *zero, 0.0, 0.0, mu]
    for kind, values in (("ENGINEERING CONSTANTS", constants), ("ORTHO", orthotropic), ("ANISOTROPIC", whole)):
        lines = [",".join(map(repr, values[k : k + 8])) for k in range(0, len(values), 8)]
        made, hot = linear_elastic(given({"TYPE": kind}, *lines), None, 1e-5)
        assert (made.average.E, made.average.nu) == pytest.approx((plain.E, plain.nu), rel=1e-12)
        assert np.linalg.eigvalsh(made.stiffness) == pytest.approx([mu] * 3 + [2 * mu] * 2 + [one + 2 * lame])
        assert not hot
        assert not more
        assert linear_elastic(given({"TYPE": kind}, *lines, *lines), None, None)[1]


def test_orientations_turn_about_their_own_axis():
    axes = orientation(given({}, "0,2,0, -3,0,0", "3, 90.", keyword="ORIENTATION"))
    assert axes == pytest.approx(np.array([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]), abs=1e-15)


@pytest.mark.parametrize(
    ("parameters", "lines"),
    [
        ({}, ["1,0,0, 2,0,0"]),
        ({"SYSTEM": "SPHERICAL"}, ["1,0,0, 0,1,0"]),
        ({"DEFINITION": "NODES"}, ["1,2,3"]),
        ({"SYSTEM": "CYLINDRICAL"}, ["1,0,0, 1,0,0"]),
        ({"SYSTEM": "CYLINDRICAL"}, ["0,0,0, 0,0,1", "3, 45."]),
    ],
)
def test_orientations_without_axes_are_refused(parameters, lines):
    with refused(fc.InputError, "orientation", "two points"):
        orientation(given(parameters, *lines, keyword="ORIENTATION"))


def test_constants_of_no_elastic_material_are_refused():
    with refused(fc.InputError, "not-positive-definite", "line 1"):
        linear_elastic(given({"TYPE": "ORTHO"}, "1,2,1,0,0,1,1,1", "1"), None, None)


def test_scene_files_name_them(written):
    text = """
    [materials.wood]
    E = [10.0, 2.0, 1.0]
    nu = [0.3, 0.2, 0.25]
    G = [2.0, 1.5, 1.0]
    density = 2.0
    [materials.ring]
    moduli = [[3,1,1,0,0,0],[1,3,1,0,0,0],[1,1,3,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]]
    axes = {direction = [0, 0, 1], point = [5, 0, 0]}
    [bodies.low]
    shape = {kind = "block", size = [1, 1, 1], divisions = [1, 1, 1]}
    material = "wood"
    contact = "top"
    supports = {bottom = "xyz"}
    [bodies.up]
    shape = {kind = "block", size = [1, 1, 1], divisions = [1, 1, 1]}
    material = "ring"
    contact = "bottom"
    pose = {translation = [0, 0, 1]}
    [[contacts]]
    slave = "up"
    master = "low"
    [loads]
    motions.up = {z = -0.01}
    """
    path = written(text)
    low, up = fc.read_scene(path).bodies.values()
    assert low.material == fc.OrthotropicMaterial((10, 2, 1), (0.3, 0.2, 0.25), (2, 1.5, 1), density=2.0)
    assert up.material.axes == fc.CylindricalAxes((0, 0, 1), (5, 0, 0))
    assert up.material.stiffness[0, 1] == 1.0
    path.write_text(text.replace("E = [10.0, 2.0, 1.0]", "E = [10.0, 2.0, -1.0]"))
    with refused(fc.InputError, "scene-file", "materials.wood", "positive"):
        fc.read_scene(path)
