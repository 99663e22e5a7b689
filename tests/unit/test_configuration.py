"""The tests' own configuration: threads, time limits, and figures that come together from several processes."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info

import fecontact as fc
from fecontact.fem.factor import available_backends, factorise
from fecontact.scene.workers import THREADS

ROOT = Path(__file__).parents[2]


def test_every_library_has_the_threads_that_the_environment_says():
    assert set(THREADS) <= set(os.environ)
    # the block is large enough for PARDISO, so that its library is loaded
    body = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), fc.Material(E=1.0, nu=0.3))
    factorise(body.model.solved_stiffness())
    found = {pool["internal_api"]: pool["num_threads"] for pool in threadpool_info()}
    assert "openblas" in found or "mkl" in found
    assert "mkl" in found or "pardiso" not in available_backends()
    own = int(os.environ["OMP_NUM_THREADS"])
    assert set(found.values()) <= {own, int(os.environ["OPENBLAS_NUM_THREADS"])}


def run(folder, text, *options):
    """Outcome of pytest on a file of tests under the project's configuration."""
    (folder / "test_it.py").write_text(text)
    command = [sys.executable, "-m", "pytest", "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(folder)]
    command += ["-p", "no:cacheprovider", "-p", "xdist.plugin", "-p", "pytest_timeout", *options, "test_it.py"]
    environment = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}  # others take a second to load
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, env=environment)


def test_a_test_that_hangs_ends_with_the_stacks_of_all_threads(tmp_path):
    text = (
        "import threading, time\n"
        "def waits_below(): time.sleep(600)\n"
        "def test_hangs():\n"
        "    threading.Thread(target=waits_below, daemon=True).start()\n"
        "    time.sleep(600)\n"
    )
    done = run(tmp_path, text, "--timeout=1")
    assert done.returncode != 0
    said = done.stdout + done.stderr
    assert "Timeout" in said
    assert "waits_below" in said
    assert "test_hangs" in said


def test_every_test_has_a_time_limit(request):
    assert 0 < float(request.config.getini("timeout")) <= 300


@pytest.mark.by_day("0")
@pytest.mark.parametrize("processes", [0, 2])
def test_figures_are_collected_from_all_processes(processes, tmp_path):
    text = (
        "import numpy as np, pytest\n"
        "@pytest.mark.parametrize('k', range(4))\n"
        "def test_one(row, k):\n"
        "    'What it shows.'\n"
        "    row(f'case {k}', 'quantity', 2.0, 2.0 + 0.01 * k, np.float64(0.0149), dofs=np.int64(k))\n"
        "def test_left_out():\n"
        "    pytest.skip('for a reason')\n"
    )
    (tmp_path / "conftest.py").write_text((ROOT / "tests" / "verification" / "conftest.py").read_text())
    done = run(tmp_path, text, "-n", str(processes), "--figures", "figures.json")
    assert done.returncode == 1  # the last is off by more than is allowed
    record = json.loads((tmp_path / "figures.json").read_text())
    errors = {f["case"]: f["error"] for f in record["figures"]}
    assert set(errors) == {f"case {k}" for k in range(4)}
    assert np.allclose([errors[f"case {k}"] for k in range(4)], [0.0, 0.005, 0.01, 0.015], atol=1e-12)
    ends = {e["test"].split("::")[1]: e for e in record["tests"]}
    assert len(ends) == len(record["tests"]) == 5
    assert ends["test_one[0]"]["text"] == "What it shows."
    assert ends["test_left_out"]["outcome"] == "skipped"
    assert "for a reason" in ends["test_left_out"]["reason"]
    assert "case 3" in done.stdout


DEPTHS = """
import time, pytest
def spend(seconds):
    until = time.process_time() + seconds
    while time.process_time() < until: pass
def test_long(): spend(0.3)
@pytest.mark.full
def test_full(): spend(0.3)
@pytest.mark.by_day("1-x")
@pytest.mark.parametrize("b", ["x", "y"])
@pytest.mark.parametrize("a", [1, 2])
def test_named(a, b): pass
@pytest.mark.by_day(every=3)
@pytest.mark.parametrize("k", range(6))
def test_every(k): pass
"""


def run_depths(folder, *options, text=DEPTHS):
    """The same with the plugin of the two depths, which calls a test of a tenth of a second long."""
    plugin = (ROOT / "tests" / "depths.py").read_text().replace("spent > 1.0", "spent > 0.1")
    (folder / "depths.py").write_text(plugin.replace("PRODUCTS, SIZE = 65, 1000", "PRODUCTS, SIZE = 3, 300"))
    return run(folder, text, "-p", "depths", "-o", "pythonpath=.", *options)


def test_by_day_what_is_marked_full_is_left_out(tmp_path):
    done = run_depths(tmp_path, "-m", "not full", "-vv")
    passed = set(re.findall(r"::(\S+) PASSED", done.stdout))
    assert passed == {"test_long", "test_named[1-x]", "test_every[0]", "test_every[3]"}
    wrong = run_depths(tmp_path, text=DEPTHS.replace('"1-x"', '"3-x"'))
    assert wrong.returncode == pytest.ExitCode.USAGE_ERROR
    assert "3-x" in wrong.stderr + wrong.stdout


@pytest.mark.by_day("options0", "options1")
@pytest.mark.parametrize("options", [(), ("--no-slow",), ("--no-slow", "-n", "1")])
def test_what_takes_long_without_the_mark_is_listed_and_fails_only_if_asked(options, tmp_path):
    done = run_depths(tmp_path, *options)
    assert done.returncode == (1 if options else 0)
    assert "12 passed" in done.stdout
    listed = done.stdout[done.stdout.index("not marked full") :]
    assert "test_long" in listed
    assert "test_full" not in listed
