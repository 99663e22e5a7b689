"""Lines of progress: shown where asked for or where there is a terminal, one at a time."""

import io
import sys

import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.common.progress import progress_line, say_done, set_part, set_stage


class Terminal(io.StringIO):
    def isatty(self):
        return True


def small_scene():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    return body, fc.Scene([body, floor], [fc.Contact(body, floor)])


@pytest.mark.parametrize(("progress", "kind", "shown"), [
    (None, io.StringIO, False), (None, Terminal, True), (True, io.StringIO, True), (False, Terminal, False),
])  # fmt: skip
def test_shown_where_there_is_a_terminal_or_as_asked(monkeypatch, progress, kind, shown):
    monkeypatch.setattr(sys, "stderr", kind())
    body, scene = small_scene()
    scene.solve(motions={body: {"z": -0.01}}, progress=progress)
    rows = scene.sweep([{"motions": {body: {"z": -z}}} for z in (0.01, 0.02)], progress=progress)
    text = sys.stderr.getvalue()
    assert len(rows) == 2
    assert bool(text) == shown
    if shown:
        assert "solve" in text
        assert "2/2" in text


def test_stages_of_parts_in_one_line(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with progress_line("outer", None) as line, progress_line("inner", True) as same:
        set_part("pose 3")
        set_stage("factorise")
    assert same is line
    text = sys.stderr.getvalue()
    assert "pose 3, factorise" in text
    assert "inner" not in text
    set_stage("afterwards")
    assert "afterwards" not in sys.stderr.getvalue()


def test_lines_that_stay_and_short_work_that_shows_none(monkeypatch):
    """A division of a mesh has a line of its own in a terminal, and none in a file; nothing is shown before a delay."""
    for kind, shown in ((Terminal, True), (io.StringIO, False)):
        monkeypatch.setattr(sys, "stderr", kind())
        with progress_line("solve", None):
            say_done("division 0")
        assert ("division 0" in sys.stderr.getvalue()) == shown
    monkeypatch.setattr(sys, "stderr", Terminal())
    with progress_line("press", None, delay=60.0):
        set_stage("solve")
    assert "press" not in sys.stderr.getvalue()
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setitem(sys.modules, "ipykernel.zmqshell", sys)
    with progress_line("in a notebook", None):
        assert "in a notebook" in sys.stderr.getvalue()


def test_a_line_ends_with_an_error(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with pytest.raises(ZeroDivisionError), progress_line("solve", None):
        raise ZeroDivisionError
    set_stage("afterwards")
    assert "afterwards" not in sys.stderr.getvalue()


def test_other_values_are_refused():
    body, scene = small_scene()
    with refused(InputError, "input", "progress must be"):
        scene.solve(motions={body: {"z": -0.01}}, progress="yes")
