"""The neutral file, and PETSc on two processes through it."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from common_scenes import ball_between_blocks
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.scene.export import export_problem

SCRIPT = Path(__file__).parents[3] / "examples" / "petsc" / "solve.py"
PYTHON = "/usr/bin/python3"


def compliance(file, key):
    K, C = (
        sp.csr_matrix((file[f"{key}_{name}_data"], file[f"{key}_{name}_indices"], file[f"{key}_{name}_indptr"]))
        for name in ("stiffness", "coupling")
    )
    C.resize(C.shape[0], K.shape[0])
    return C @ np.linalg.solve(K.toarray(), C.T.toarray()), C @ np.linalg.solve(K.toarray(), file[f"{key}_loads"])


def test_the_file_holds_the_whole_problem(tmp_path):
    """Solved from its arrays alone, by dense algebra."""
    _, plate, ball, scene = ball_between_blocks()
    loads = {ball: (0.0, 0.0, -0.02), (plate, "x_max"): (0.002, 0.0, 0.001)}
    file = np.load(export_problem(scene, tmp_path / "p.npz", loads))
    S, g = np.diag(file["own_compliance"]), file["gap"].copy()
    for k in range(int(file["n_bodies"])):
        rows = file[f"body{k}_coupling_rows"]
        part, response = compliance(file, f"body{k}")
        S[np.ix_(rows, rows)] += part
        g[rows] += response
    problem = fc.solvers.ContactProblem((S + S.T) / 2, g, file["equilibrium"], file["load"])
    forces = fc.solvers.solve(problem).forces
    expected = np.concatenate([c.forces for c in scene.solve(loads, finite_motion=False).contacts])
    # dense algebra with a condition of about 1e5
    assert np.abs(forces - expected).max() < 1e-9 * expected.max()


def test_refusals(tmp_path):
    *_, ball, scene = ball_between_blocks()
    loads = {ball: (0.0, 0.0, -0.02)}
    with refused(InputError, "not-npz", "'p.h5'"):
        export_problem(scene, tmp_path / "p.h5", loads)
    with refused(InputError, "no-folder", "p.npz"):
        export_problem(scene, tmp_path / "none" / "p.npz", loads)
    assert not list(tmp_path.iterdir())


def petsc_environment():
    """Environment in which the system's Python has petsc4py, or None."""
    if not Path(PYTHON).exists() or shutil.which("mpiexec") is None:
        return None
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1"}
    # Debian keeps the module beside the library it was made for
    folders = sorted(Path("/usr/lib/petscdir").glob("petsc*/*-real/lib/python3/dist-packages"))
    environment["PYTHONPATH"] = os.pathsep.join(map(str, folders))
    found = subprocess.run([PYTHON, "-c", "import numpy, petsc4py"], env=environment, capture_output=True, check=False)
    return environment if found.returncode == 0 else None


@pytest.mark.full
def test_petsc_on_two_processes_gives_the_same_answer(tmp_path):
    environment = petsc_environment()
    if environment is None:
        pytest.skip("the system's Python has no petsc4py, or there is no mpiexec: apt-get install python3-petsc4py")
    _, plate, ball, scene = ball_between_blocks()
    loads = {ball: (0.0, 0.0, -0.02), (plate, "x_max"): (0.002, 0.0, 0.001)}
    problem = export_problem(scene, tmp_path / "problem.npz", loads)
    answer = tmp_path / "forces.npz"
    command = ["mpiexec", "--oversubscribe", "-n", "2", PYTHON, str(SCRIPT), str(problem), str(answer)]
    out = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert out.returncode == 0, out.stderr
    assert "2 processes" in out.stdout
    found = np.load(answer)["forces"]
    expected = np.concatenate([c.forces for c in scene.solve(loads, finite_motion=False).contacts])
    # both are exact on the same set; what is left is the condition of the compliance times rounding
    assert np.abs(found - expected).max() < 1e-8 * expected.max()
