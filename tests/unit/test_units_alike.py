"""Units alike: every public plot, map, save and report takes names of units, and shows them."""

import inspect
import json
import pkgutil
import re
from importlib import import_module

import numpy as np
import pytest
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.common.units import Units
from tests.refusals import refused

UNITS = ("um", "mN", "kPa")
DOORS = ("plot", "montage", "animate", "show", "report")
STEEL = fc.Material(E=210e3, nu=0.3)


def classes():
    """Classes of the package by name, each once."""
    names = [m.name for m in pkgutil.walk_packages(fc.__path__, "fecontact.") if "petsc" not in m.name]
    found = [o for name in names for o in vars(import_module(name)).values() if inspect.isclass(o)]
    return {c.__qualname__: c for c in found if c.__module__.startswith("fecontact.")}


def doors():
    return [
        (f"{name}.{door}", vars(c)[door]) for name, c in sorted(classes().items()) for door in DOORS if door in vars(c)
    ]


@pytest.mark.parametrize(("name", "door"), doors(), ids=lambda value: value if isinstance(value, str) else "")
def test_every_picture_and_report_takes_names_of_units(name, door):
    assert "units" in inspect.signature(door).parameters, name


def test_every_picture_says_that_it_is_a_figure():
    """Or an axes, or nothing where a window opens or a file is written."""
    for name, door in doors():
        assert inspect.signature(door).return_annotation in ("Figure", "Picture", "Path", "None"), name


def scene():
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (2, 2, 1))
    block = fc.ElasticBody(mesh, STEEL, contact="top", supports={"bottom": "xyz"}, name="block")
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball").placed((1.0, 1.1, 1.0))
    return fc.Scene([block, ball], [fc.Contact(block, ball)], units=("mm", "N", "MPa"))


@pytest.fixture(scope="module")
def result():
    made = scene()
    return made.solve({made.bodies[1]: (0, 0, -3000.0)}, finite_motion=False)


@pytest.fixture(scope="module")
def table():
    made = scene()
    cases = [{"forces": {made.bodies[1]: (0, 0, -f)}, "finite_motion": False} for f in (1e3, 2e3)]
    return made.sweep(cases, keep="pressure")


@pytest.fixture(scope="module")
def pressed():
    return fc.HalfSpace(STEEL, size=(1.2, 1.2), cells=(16, 16)).press(fc.surfaces.Paraboloid(10.0), force=100.0)


def said(figure: Figure) -> str:
    axes = [f"{a.get_xlabel()} {a.get_ylabel()} {a.get_title()}" for a in figure.axes]
    return " ".join([*axes, figure.get_suptitle(), *(t.get_text() for a in figure.axes for t in a.texts)])


def test_names_given_come_before_those_of_the_scene(result, table, pressed):
    drawn = {
        "pressure": (result.plot("pressure", units=UNITS), "um mN kPa"),
        "stress": (result.plot("von_mises", units=UNITS), "um kPa"),
        "displacement": (result.plot("displacement", units=UNITS), "um"),
        "curves": (table.plot(units=UNITS), "um² mN kPa"),
        "maps": (table.montage(units=UNITS), "um kPa"),
        "scene": (scene().plot(units=UNITS), "um"),
        "mesh": (fc.shapes.ball(1.0).plot(units=UNITS), "um"),
        "section": (fc.sections.rectangle((2.0, 1.0), (4, 2)).plot(units=UNITS), "um"),
        "half-space": (pressed.plot(units=UNITS), "um mN kPa"),
        "spectrum": (fc.surfaces.power_spectrum(np.eye(8), (1.0, 1.0)).plot(units=UNITS), "1/um"),
        "hertz": (fc.hertz.spheres((10.0, 10.0), (STEEL, STEEL), force=1.0).plot(units=UNITS), "um kPa"),
    }
    for name, (figure, wanted) in drawn.items():
        text = said(figure)
        for unit in wanted.split():
            assert unit in text, (name, unit, text)
        assert "MPa" not in text, (name, text)


def test_a_text_is_the_unit_of_what_is_drawn(result):
    assert result.plot("pressure", units="kPa").axes[1].get_ylabel() == "contact pressure [kPa]"
    assert result.plot("displacement_z", units="um").axes[1].get_ylabel() == "displacement z [um]"
    assert "um" in said(fc.shapes.ball(1.0).plot(units="um"))


def test_files_have_the_units_of_the_scene_or_those_given(tmp_path, result, table, pressed):
    assert json.loads(result.save(tmp_path / "r.json").read_text())["units"]["stress"] == "MPa"
    assert json.loads(result.save(tmp_path / "r.json", units=UNITS).read_text())["units"]["stress"] == "kPa"
    assert result.save(tmp_path / "r.csv").read_text().startswith("contact,x,y,z,")
    head = result.save(tmp_path / "r.csv", units=UNITS).read_text().splitlines()[0]
    assert head.startswith("contact,x [um],")
    assert "area [um²],force [mN],pressure [kPa]" in head
    assert np.load(result.save(tmp_path / "r.npz"))["units"].tolist() == ["mm", "N", "MPa"]
    assert "max_pressure [kPa]" in table.save(tmp_path / "t.csv", units=UNITS).read_text().splitlines()[0]
    rows = json.loads(table.save(tmp_path / "t.json", units=UNITS).read_text())["cases"]
    assert rows[0]["units"]["length"] == "um"
    head = pressed.save(tmp_path / "h.csv", units=UNITS).read_text().splitlines()[0]
    assert head == "x [um],y [um],pressure [kPa],gap [um],displacement [um]"
    assert json.loads(pressed.save(tmp_path / "h.json", units=UNITS).read_text())["units"]["force"] == "mN"
    assert np.load(pressed.save(tmp_path / "h.npz", units=UNITS))["units"].tolist() == list(UNITS)
    with refused(fc.InputError, "no-place-for-units"):
        result.save(tmp_path / "r.vtu", units=UNITS)


def test_a_report_has_them_everywhere(tmp_path, result):
    page = result.report(tmp_path / "page.html", units=UNITS).read_text()
    assert "peak pressure [kPa]" in page
    assert "moment about its frame [mN·um]" in page
    assert "MPa" not in re.sub(r'src="[^"]*"', "", page)


def test_pictures_of_one_panel_are_drawn_into_given_axes(result, table, pressed):
    axes = Figure().subplots(1, 4)
    for k, draw in enumerate(
        (
            lambda ax: result.plot("pressure", ax=ax),
            lambda ax: table.plot("force", ax=ax),
            lambda ax: pressed.plot(ax=ax),
            lambda ax: fc.surfaces.power_spectrum(np.eye(8), (1.0, 1.0)).plot(ax=ax),
        )
    ):
        assert draw(axes[k]) is axes[k].figure
        assert axes[k].get_xlabel()
    with refused(fc.InputError, "one-axes"):
        table.plot(ax=axes[0])
    curve = fc.HalfSpace(STEEL, size=(1.2, 1.2), cells=(8, 8)).curve(fc.surfaces.Paraboloid(10.0), forces=[1.0, 2.0])
    with refused(fc.InputError, "several-panels"):
        curve.plot(ax=axes[0])


def test_names_are_as_given_or_those_beside():
    assert Units.labels("MPa", length="mm") == Units("mm", "", "MPa")
    assert Units.labels("mm", "length").length == "mm"
    assert Units.labels(("mm", "N")).stress == "N/mm²"
    assert Units.labels(Units("mm")) == Units("mm")
    assert Units.labels("") == Units.labels(()) == Units()
