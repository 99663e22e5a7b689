"""Results in a notebook, as a page and in one line."""

import re
import sys
import time
from base64 import b64decode
from html.parser import HTMLParser
from importlib import util

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

CORK = fc.Material(E=50.0, nu=0.0)
VOID = {"meta", "img"}


class Outline(HTMLParser):
    """Checks that tags nest; collects headings, texts of cells and pictures."""

    def __init__(self):
        super().__init__()
        self.open, self.cells, self.pictures, self.links = [], [], [], []

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name == "src":
                self.pictures.append(value)
            if name == "href":
                self.links.append(value)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "td":
            self.cells.append(data)


@pytest.fixture(scope="module")
def result():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    block = fc.ElasticBody(mesh, CORK, "bottom", {"top": "xyz"}, name="<block>")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    return fc.Scene([block, floor], [fc.Contact(block, floor)], units=("mm", "N", "MPa")).solve(
        motions={block: {"z": -0.02}}
    )


def read(html):
    page = Outline()
    page.feed(html)
    page.close()
    assert page.open == []
    return page


def test_a_page_needs_no_other_file(result, tmp_path):
    path = result.report(tmp_path / "report.html", title="Block & floor")
    text = path.read_text(encoding="utf-8")
    page = read(text)
    assert page.links == []
    assert len(page.pictures) == 4  # pressure, gap, stress, and inside
    for picture in page.pictures:
        head, data = picture.split(",")
        assert head == "data:image/png;base64"
        assert b64decode(data).startswith(b"\x89PNG")
    assert "Block &amp; floor" in text  # names cannot break the page
    assert "<block>" not in text
    assert "<block>.bottom on floor.surface" in page.cells
    # uniaxial, nu = 0: E times the strain on a unit face; rounding is shown as zero
    assert page.cells[1:5] == ["(0, 0, 1)", "1", "1", "1"]
    for word in ("equilibrium", "factorise", "peak pressure [MPa]", "area [mm²]"):
        assert word in text
    assert all(re.search(re.escape(w.split()[0]), text) for w in result.warnings)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("r.html", {"colour": "red"}, ("unknown-option", "colour")),
        ("r.html", {"units": "mm"}, ("not-a-sequence", "units")),
        ("r.pdf", {}, ("no-html", "'.pdf'")),
        ("no/r.html", {}, ("no-folder", "r.html")),
        ("r.html", {"title": 3}, ("not-a-text", "The title")),
    ],
)
def test_pages_that_cannot_be_written_are_refused(result, tmp_path, name, options, message):
    with refused(fc.InputError, *message):
        result.report(tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_a_notebook_shows_table_and_map(result):
    page = read(result._repr_html_())
    assert len(page.pictures) == 1
    assert page.cells[0] == "<block>.bottom on floor.surface"


def test_every_object_is_one_short_line(result):
    half = fc.HalfSpace(CORK, size=(4.0, 4.0), cells=(16, 16))
    pressed = half.press(fc.Sphere(10.0), force=0.01)
    contact = result.contacts[0]
    seen = [
        result, result.scene, *result.scene.bodies, *result.scene.contacts, contact, contact.error_estimate,
        contact.recovered, contact.outline, *contact.regions, *contact._energy_errors, result.solution, result.problem,
        result._condensed, *result._condensed.parts, *result._interfaces, result._loading, result._state, half, pressed,
        fc.Pose(), fc.Material(1.0, 0.3), fc.Plane(), fc.Sphere(1.0), result.scene.bodies[0].mesh,
    ]  # fmt: skip
    for each in seen:
        line = repr(each)
        assert "\n" not in line
        assert len(line) <= 220, line  # 150 and one last word
        assert not line.startswith("<"), line
    assert repr(result).startswith("ContactResult(solved, 25 of 25 in contact; <block> on floor: force 1, peak 1")


def test_units_are_named_once_and_shown_everywhere(result):
    text = str(result)
    assert re.search(r"force on <block> .* 1 N\n", text)
    assert re.search(r"moment .* N·mm\n", text)
    assert re.search(r"area +1 mm² ", text)
    assert re.search(r"pressure max, mean +1 +1 MPa\n", text)
    assert result.plot("pressure").axes[1].get_ylabel() == "contact pressure [MPa]"
    assert result.plot("gap").axes[1].get_ylabel() == "gap [mm]"
    assert result.plot("displacement_z").axes[1].get_ylabel() == "displacement z [mm]"
    assert result.plot("pressure", units="kPa").axes[1].get_ylabel() == "contact pressure [kPa]"
    assert result.summary()["units"] == {"length": "mm", "force": "N", "stress": "MPa"}


@pytest.mark.parametrize(
    ("units", "code"),
    [("mm", "not-a-sequence"), (3, "not-a-sequence"), (("mm", "N", "MPa", "s"), "units"), ((1.0, 2.0), "not-a-text")],
)
def test_units_that_are_no_names_are_refused(result, units, code):
    with refused(fc.InputError, code, "nit"):
        fc.Scene(result.scene.bodies, result.scene.contacts, units=units)


def test_the_total_time_is_that_of_the_whole_solution(monkeypatch):
    monkeypatch.setattr(time, "perf_counter", time.process_time)  # of this process, whatever else runs
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).translated((-0.5, -0.5, -1.0))
    body = fc.ElasticBody(mesh, CORK, contact="top", supports={"bottom": "xyz"})
    ball = fc.RigidBody(fc.Sphere(1.0)).placed((0, 0, 0.02))
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    began = time.perf_counter()
    posed = scene.solve(motions={ball: {"x": 0.1, "z": -0.05}}, finite_motion=True)
    elapsed = time.perf_counter() - began
    # several poses are solved, of which the stages are those of the last; arguments are checked outside
    assert 0.5 * elapsed <= posed.seconds["total"] <= elapsed
    assert abs(sum(v for k, v in posed.seconds.items() if k != "total") / posed.seconds["total"] - 1) <= 0.05
    assert posed.seconds["before"] > 0


def test_what_a_notebook_shows_leaves_the_notebook_alone(result):
    """Rules of style apply in the package's own element; each kind of object has a text and a picture."""
    half = fc.HalfSpace(CORK, size=(3.0, 3.0), cells=(8, 8))
    shown = [
        result,
        result.scene,
        result.scene.bodies[0],
        half.press(fc.surfaces.Paraboloid(1.0), force=1.0),
        fc.hertz.spheres((1.0, 1.0), (CORK, CORK), force=1.0),
        fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)),
    ]
    block, floor = result.scene.bodies
    rubbing = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.3)])
    told = [
        rubbing.solve_path([{"motions": {block: {"z": -0.01}}}]),
        result.scene.explain(),
    ]
    for each, pictures in [*((s, 1) for s in shown), *((t, 0) for t in told)]:
        html = each._repr_html_()
        rules = re.findall(r"^([^{} ][^{}]*)\{", re.search(r"<style>(.*?)</style>", html, re.DOTALL)[1], re.MULTILINE)
        assert rules
        assert all(part.strip().startswith(".fecontact") for rule in rules for part in rule.split(","))
        assert len(re.findall("<img", html)) == pictures


def test_arrays_of_a_result(result, tmp_path):
    """The problem and its solution, from which the residuals can be recomputed elsewhere."""
    found = np.load(result.save(tmp_path / "result.npz"))
    gap = found["S"] @ found["forces"] + found["g"] + found["B"].T @ found["q"]
    assert np.abs(gap[found["forces"] > 0]).max() < 1e-12
    assert (found["pressure_0"] == result.contacts[0].pressure).all()


def test_friends_are_imported_when_they_are_asked_for(result, monkeypatch):
    """Tables, fields and bodies for pandas, xarray and pyvista; without them the package is named."""
    table = result.scene.sweep(
        [{"motions": {result.scene.bodies[0]: {"z": -0.01 * k}}, "name": f"{k}"} for k in (1, 2)]
    )
    half = fc.HalfSpace(CORK, size=(3.0, 3.0), cells=(16, 16)).press(fc.surfaces.Paraboloid(1.0), force=1.0)
    calls = {"pandas": table.to_pandas, "xarray": half.to_xarray, "pyvista": result.to_pyvista}
    for package, call in calls.items():
        with monkeypatch.context() as without:
            without.setitem(sys.modules, package, None)
            with refused(fc.MissingPackageError, "missing-package", package):
                call()
    if util.find_spec("pandas"):
        assert table.to_pandas().loc["2", "max_pressure"] == table["2"]["contacts"][0]["max_pressure"]
    if util.find_spec("xarray"):
        fields = half.to_xarray()
        assert float(fields.pressure.max()) == half.max_pressure == fields.attrs["max_pressure"]
    if util.find_spec("pyvista"):
        assert result.to_pyvista().point_data["displacement"].shape[1] == 3


def test_a_report_opens_bodies_where_they_touch(tmp_path):
    """Of a ball on a block off the middle: the plane across y, which faces the eye, through the contact."""
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (4, 4, 2))
    block = fc.ElasticBody(mesh, CORK, contact="top", supports={"bottom": "xyz"}, name="block")
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball").placed((1.0, 1.1, 1.0))
    scene = fc.Scene([block, ball], [fc.Contact(block, ball)])
    pressed = scene.solve(motions={ball: {"z": -0.02}}, finite_motion=False)
    page = pressed.report(tmp_path / "page.html").read_text()
    y = float(re.search(r"<h2>Stress, y&gt;([0-9.]+)</h2>", page)[1])
    assert abs(y - pressed.contacts[0].centre_of_pressure[1]) < 1e-3


def test_a_report_of_bodies_of_one_cell_has_no_cut(tmp_path):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    assert "Stress, " not in result.report(tmp_path / "page.html").read_text()
