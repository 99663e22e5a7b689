"""Results do not depend on the number of threads."""

import json
import os
import subprocess
import sys

import pytest

from fecontact.app.cli import set_threads

RUN = "import sys; from fecontact.app.cli import main; sys.exit(main(['hertz', '--level', '1', '--json', '-']))"


@pytest.mark.full
def test_two_threads_give_what_one_gives():
    """Sums in another order: a few units of rounding, times the condition of the condensed problem."""
    found = []
    for threads in ("1", "2"):
        environment = {**os.environ, "OMP_NUM_THREADS": threads, "MKL_NUM_THREADS": threads}
        done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True, env=environment)
        found.append(json.loads(done.stdout))
    one, two = found
    for name in ("contact_radius", "max_pressure", "approach", "total_force"):
        assert two[name] == pytest.approx(one[name], rel=1e-12, abs=0), name


@pytest.mark.parametrize(("given", "expected"), [(None, "1"), ("3", "3")])
def test_small_matrices_have_one_thread_unless_told_otherwise(monkeypatch, given, expected):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given or "")
    if given is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    set_threads()
    assert os.environ["OPENBLAS_NUM_THREADS"] == expected
