"""Functions in a process of their own: results, errors, crashes and interruptions."""

import os
import subprocess
import sys
import time

from refusals import refused

import fecontact as fc
from fecontact.mesh.gmsh import run_in_subprocess


def test_results_and_errors_of_the_package_come_back():
    assert run_in_subprocess("a material", fc.Material, 2.0, 0.3) == fc.Material(2.0, 0.3)
    with refused(fc.InputError, "not-positive"):
        run_in_subprocess("a material", fc.Material, -2.0, 0.3)


def test_a_crash_is_told_with_its_last_output_and_ends_that_process_alone(capfd):
    with refused(fc.MeshError, "mesh", "The mesher", "signal SIGABRT"):
        run_in_subprocess("The mesher", os.abort)
    with refused(fc.MeshError, "mesh", "exit 1", "Last output:"):
        run_in_subprocess("The mesher", int, "x")
    assert capfd.readouterr() == ("", "")


def test_an_interruption_ends_the_process(tmp_path):
    """The child does not outlive the parent, and its folder is removed."""
    # a shell's job in the background ignores interruptions, and what it starts inherits that
    heard = "import signal, time; signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"{heard}; from fecontact.mesh.gmsh import run_in_subprocess; run_in_subprocess('sleep', time.sleep, 60)"
    parent = subprocess.Popen(
        [sys.executable, "-c", program], env={**os.environ, "TMPDIR": str(tmp_path)}, stderr=subprocess.PIPE
    )
    deadline = time.monotonic() + 60
    while not list(tmp_path.glob("fecontact-*/said")) and time.monotonic() < deadline:
        time.sleep(0.05)
    parent.send_signal(2)
    assert b"KeyboardInterrupt" in parent.communicate(timeout=30)[1]
    assert not list(tmp_path.iterdir())


def test_gmsh_does_not_touch_a_session_of_the_caller(gmsh, tmp_path, capfd):
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("mine")
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(tmp_path / "box.brep"))
        assert len(fc.mesh_solid(tmp_path / "box.brep", size=0.7).cells) > 0
        assert gmsh.model.getCurrent() == "mine"
        assert len(gmsh.model.getEntities(3)) == 1
    finally:
        gmsh.finalize()
    assert capfd.readouterr() == ("", "")
