"""The command line, run in this process."""

import json
import os
import signal
import subprocess
import sys

import meshio
import numpy as np
import pytest

from fecontact.app import commands
from fecontact.app.cli import main
from fecontact.common import files

KEYS = {
    "case",
    "n_dofs",
    "n_candidates",
    "n_active",
    "contact_radius",
    "centre_pressure",
    "max_pressure",
    "approach",
    "total_force",
    "pressure_l2_error",
    "errors",
    "exact",
    "residuals",
    "seconds",
    "solver",
    "peak_rss_mb",
}


@pytest.mark.full
def test_hertz_json_on_standard_output_has_all_keys(capsys):
    assert main(["hertz", "--model", "symmetric", "--level", "1", "--json", "-"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert set(data) >= KEYS
    assert set(data["errors"]) == {"contact_radius", "centre_pressure", "approach"}
    assert set(data["exact"]) == {"a", "p0", "approach"}
    assert set(data["residuals"]) == {"penetration", "tension", "complementarity", "equilibrium"}
    assert set(data["seconds"]) >= {"mesh", "assemble", "factorise", "condense", "pair", "solve", "total"}


def test_hertz_writes_picture_bodies_and_figures(tmp_path, capsys):
    files = [tmp_path / name for name in ("p.png", "b.vtu", "f.json")]
    options = [f"--{kind}={file}" for kind, file in zip(("plot", "vtu", "json"), files, strict=True)]
    assert main(["hertz", "--model=symmetric", "--level=1", *options]) == 0
    assert "contact radius" in capsys.readouterr().out
    assert files[0].read_bytes()[:4] == b"\x89PNG"
    mesh = meshio.read(files[1])
    assert {c.type for c in mesh.cells} == {"hexahedron20"}
    pressures = {"contact_pressure", "contact_pressure_error"}
    assert set(mesh.point_data) == {"displacement", "stress", "von_mises", *pressures}
    figures = json.loads(files[2].read_text())
    # the largest nodal pressure is in the file as in the table
    assert abs(np.max(mesh.point_data["contact_pressure"]) / figures["max_pressure"] - 1) < 0.05


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["hertz", "--vtu", "/no/such/folder/x.vtu"], "does not exist"),
        (["hertz", "--level", "9"], "level must be 1"),
        (["hertz", "--solver", "magic"], "no solver 'magic'"),
        (["hertz", "--case", "unequal", "--model", "symmetric"], "needs equal spheres"),
    ],
)
def test_errors_are_explained_with_status_two(arguments, message, capsys):
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


@pytest.mark.full
def test_without_edge_fit(capsys):
    assert main(["hertz", "--model=symmetric", "--level=1", "--no-edge-fit", "--json=-"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["edge_fit"] is False
    assert data["seconds"]["first_pass"] == 0


def test_the_report_case_refuses_files_that_it_would_not_write(tmp_path, capsys):
    """No option that does nothing."""
    assert main(["hertz", "--case", "report", "--json", str(tmp_path / "figures.json")]) == 2
    assert "writes no files" in capsys.readouterr().err


@pytest.mark.full
def test_a_reader_that_stops_loses_no_files(tmp_path):
    """As behind ``| head -1``: no traceback, and the files that were asked for are written."""
    command = "halfspace sphere --radius 10 --E 1 --nu 0 --force 1e-4 --cells 32 --csv"
    script = "import sys; from fecontact.app.cli import main; sys.exit(main(sys.argv[1:]))"
    words = [sys.executable, "-c", script, *command.split(), str(tmp_path / "points.csv")]
    run = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert run.stdout is not None
    assert run.stderr is not None
    run.stdout.close()
    assert run.stderr.read() == ""
    assert run.wait() == 0
    assert (tmp_path / "points.csv").exists()


def test_the_route_of_1978_is_for_the_report(capsys):
    assert main(["hertz", "--route", "1978"]) == 2
    assert "--case report" in capsys.readouterr().err


COMMAND = [sys.executable, "-m", "fecontact"]
PRESS = ["halfspace", "sphere", "--radius", "10", "--E", "1", "--nu", "0", "--force", "1e-4", "--cells", "32", "--csv"]


@pytest.mark.parametrize("signals", [0, 2])
def test_ctrl_c_is_one_line_that_names_what_is_kept(signals, tmp_path, monkeypatch, capsys, request):
    """Before anything is written, and after a file and two rows of another; no traceback."""
    # what runs in the background of a shell ignores it from the start
    kept_handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    request.addfinalizer(lambda: signal.signal(signal.SIGINT, kept_handler))

    def work(_):
        if signals:
            files.write_atomically(tmp_path / "table.csv", "1")
        for _ in range(signals):
            files.append_row(tmp_path / "rows.jsonl", {"name": "a"})
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setitem(commands.RUN, "hertz", work)
    assert main(["hertz"]) == 130
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    kept = f"kept: {tmp_path / 'table.csv'}, {tmp_path / 'rows.jsonl'} (2 rows)"
    assert (kept if signals else "nothing was written") in told


@pytest.mark.full
def test_a_path_with_an_umlaut_where_the_locale_has_none(tmp_path):
    """File names are bytes; ``python -m fecontact`` is the command."""
    plain = {**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    path = tmp_path / "Stöße.csv"
    subprocess.run([*COMMAND, *PRESS, str(path)], env=plain, check=True, stdout=subprocess.DEVNULL)
    assert path.exists()


def test_help_of_a_shape_has_its_options_alone(capsys):
    def told(*words):
        with pytest.raises(SystemExit):
            main(["halfspace", *words, "--help"])
        return capsys.readouterr().out

    options = ("--amplitude", "--hurst", "--peaks-up", "--radius ")
    for shape, expected in (("sphere", "--radius "), ("wave", "--amplitude"), ("heights", "--peaks-up")):
        assert [option for option in options if option in told(shape)] == [expected]
    assert all(option in told() for option in options)


@pytest.mark.parametrize(
    ("python", "command"),
    [
        ("or solve with accuracy=0.05.", "or solve with --accuracy 5%."),
        ("accuracy={'approach': 0.05, 'peak': 0.02}.", "--accuracy approach=5%,peak=2%."),
        ("the accuracy is fine", "the accuracy is fine"),
    ],
)
def test_remedies_are_in_the_words_of_the_command(python, command):
    assert commands._worded(python) == command
