"""The engine 'petsc' against the direct back-end, on one and two processes; its refusals."""

import json
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from common_scenes import ball_between_blocks
from refusals import refused

import fecontact as fc
from fecontact import FecontactError, InputError, MissingPackageError
from fecontact.app.cli import main
from fecontact.fem.petsc.job import Job, environment, interpreter
from fecontact.mesh.refine import refined, touching
from fecontact.scene.cost import explain


def has_petsc():
    found = shutil.which("mpiexec") and subprocess.run(
        [*interpreter(), "-c", "import petsc4py"], capture_output=True, check=False,
        env=environment(),
    )  # fmt: skip
    return bool(found) and found.returncode == 0


needs_petsc = pytest.mark.skipif(not has_petsc(), reason="needs mpiexec and petsc4py: apt install python3-petsc4py")


@pytest.fixture(autouse=True)
def processes(monkeypatch):
    """As many processes as asked for, also as root and on few processors (variables of OpenMPI)."""
    for name in ("ALLOW_RUN_AS_ROOT", "ALLOW_RUN_AS_ROOT_CONFIRM", "MCA_rmaps_base_oversubscribe"):
        monkeypatch.setenv(f"OMPI_{name}", "1")
    monkeypatch.setenv("OMPI_MCA_mpi_yield_when_idle", "1")


def forces(result):
    return np.concatenate([contact.forces for contact in result.contacts])


@needs_petsc
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.full)])
def test_two_bodies_on_processes_carry_the_same_forces(ranks):
    """Source: the direct back-end. Loads on bodies, a floating body, rows that share displacements."""
    _, plate, ball, scene = ball_between_blocks()
    loads = {ball: (0.0, 0.0, -0.02), (plate, "x_max"): (0.002, 0.0, 0.001)}
    found = scene.solve(loads, finite_motion=False, engine="petsc", ranks=ranks)
    own = scene.solve(loads, finite_motion=False)
    assert found.success
    assert found.solution.solver == "multigrid"
    assert found.condensation["base"] == f"operator: multigrid of PETSc on {ranks} processes has products only"
    assert own.condensation["base"].startswith("columns")
    # two certificates of 1e-10 and a compliance with a condition of about 1e5; measured 1e-12
    assert np.abs(forces(found) - forces(own)).max() < 1e-8 * forces(own).max()
    here, there = own.displacement(plate), found.displacement(plate)
    assert np.abs(here - there).max() < 1e-8 * np.abs(here).max()


@needs_petsc
@pytest.mark.full
def test_one_model_in_two_poses_with_turned_axes_and_hanging_nodes(steel):
    """Source: the direct back-end. The stiffness is transformed by the processes."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    mesh = refined(mesh, touching(mesh, mesh.boundaries["top"]))
    below = fc.ElasticBody(mesh, steel, "top", {"bottom": "xyz", "x_min": (1, 0, 1)}, name="below")
    above = below.placed(translation=(0.0, 0.2, 2.001), rotation=fc.rotation_about((1, 0, 0), np.pi))
    scene = fc.Scene([below, above], [fc.Contact(above, below)])
    loads = {"motions": {above: {"z": -0.01}}, "finite_motion": False}
    own = scene.solve(**loads)
    found = scene.solve(**loads, engine="petsc", ranks=2)
    assert below.model is above.model
    assert mesh.hanging is not None
    assert np.abs(forces(found) - forces(own)).max() < 1e-8 * forces(own).max()


@needs_petsc
@pytest.mark.parametrize("finite", [False, True])
def test_cases_of_a_sweep_share_one_set_of_processes(finite, monkeypatch):
    """Source: the same sweep by the direct back-end. Poses, loads and whole runs within a case."""
    ends = []

    def job(*given):
        started = Job(*given)
        ends.append(started.close)
        return started

    monkeypatch.setattr("fecontact.scene.engine.Job", job)
    _, _, ball, scene = ball_between_blocks()
    away = ball.placed((0.01, 0.02, 0.0)).pose
    cases = [
        {"forces": {ball: (0.0, 0.0, -load)}, "poses": {ball: pose}, "finite_motion": finite}
        for load, pose in ((0.02, ball.pose), (0.03, away))
    ]
    found = scene.sweep([{**case, "engine": "petsc", "ranks": 1} for case in cases])
    own = scene.sweep(cases)
    assert len(ends) == 1
    assert not ends[0].alive
    for one, other in zip(found, own, strict=True):
        a, b = ([contact["force"] for contact in row["contacts"]] for row in (one, other))
        # as for one solution
        assert np.abs(np.subtract(a, b)).max() < 1e-8 * np.abs(b).max()


@needs_petsc
def test_a_scene_file_on_processes(tmp_path, capsys):
    path, figures = tmp_path / "scene.toml", {}
    path.write_text(SCENE)
    for engine in (["--engine", "petsc", "-n", "2"], []):
        to = tmp_path / f"{len(figures)}.json"
        assert main(["solve", str(path), *engine, "--json", str(to)]) == 0
        assert ("PETSc on 2 processes" in capsys.readouterr().out) == bool(engine)
        figures[len(figures)] = json.loads(to.read_text())
    one, other = (figures[k]["contacts"][0]["force"] for k in range(2))
    assert one == pytest.approx(other, rel=1e-8, abs=1e-12)


@needs_petsc
def test_a_preconditioner_without_numbers_is_named(monkeypatch):
    """Relaxation by 1e300, whose residuals overflow: PETSc's reason -9 is its DIVERGED_NANORINF."""
    monkeypatch.setenv(
        "PETSC_OPTIONS", "-fecontact_mg_levels_ksp_type richardson -fecontact_mg_levels_ksp_richardson_scale 1e300"
    )
    _, _, ball, scene = ball_between_blocks()
    with pytest.raises(FecontactError, match=r"engine 'petsc' failed: .*reason -9"):
        scene.solve({ball: (0.0, 0.0, -0.02)}, finite_motion=False, engine="petsc", ranks=1)


def test_what_the_engine_does_not_offer_is_refused(steel):
    _, plate, ball, scene = ball_between_blocks()
    loads = {ball: (0.0, 0.0, -0.02)}
    for given, message in (
        ({"engine": "mumps"}, ("unknown-name", "engine", "'mumps'", "'own', 'petsc'")),
        ({"ranks": 2}, ("ranks-without-petsc",)),
        ({"engine": "petsc", "ranks": 0}, ("not-whole", "from 1", "found 0")),
        ({"engine": "petsc", "ranks": True}, ("not-whole", "from 1", "True")),
        ({"engine": "petsc", "accuracy": 0.1}, ("input", "does not divide meshes")),
        ({"engine": "petsc", "solver": "wolfe"}, ("input", "a solver of its own")),
    ):
        with refused(InputError, *message):
            scene.solve(loads, **given)
    rough = fc.Scene(scene.bodies, [replace(scene.contacts[0], friction=0.3), scene.contacts[1]])
    with refused(InputError, "petsc-cannot", "a contact has friction"):
        rough.solve(loads, engine="petsc")
    shared = {"forces": loads, "engine": "petsc"}
    for cases, given, message in (
        ([shared, {"forces": loads}], {}, ("engines-differ", "'own'", "'petsc'")),
        ([shared], {"processes": 2}, ("engine-and-processes",)),
        ([{**shared, "accuracy": 0.1}], {}, ("input", "does not divide meshes")),
        ([{"forces": loads, "ranks": 2}], {}, ("ranks-without-petsc",)),
    ):
        with refused(InputError, *message):
            scene.sweep(cases, **given)
    ground = fc.HalfSpace(steel)
    with refused(InputError, "petsc-cannot", "not assembled from a mesh of solids"):
        fc.Scene([ground, plate], [fc.Contact(plate, ground, surfaces=("bottom", ground.contact[0]))]).solve(
            engine="petsc"
        )
    rigid = [fc.RigidBody(fc.Sphere(1.0)).placed(translation=(0.0, 0.0, 3.0 * k)) for k in range(2)]
    with refused(InputError, "petsc-cannot", "no body is elastic"):
        fc.Scene(rigid, [], springs=[fc.Spring(1.0, (rigid[0], (0, 0, 0)), (rigid[1], (0, 0, 0)))]).solve(
            engine="petsc"
        )


def test_explain_tells_of_the_engine_where_a_model_is_large(monkeypatch):
    _, _, ball, scene = ball_between_blocks()
    loads = {"forces": {ball: (0.0, 0.0, -0.02)}}
    assert explain(scene, loads).engine == ""
    assert "Engine:" not in str(explain(scene, loads))
    monkeypatch.setattr("fecontact.scene.engine.WORTHWHILE", 900)
    assert "Engine:    backend='amg' of the bodies needs less memory" in str(explain(scene, loads))
    rough = fc.Scene(scene.bodies, [replace(scene.contacts[0], friction=0.3), scene.contacts[1]])
    assert explain(rough, loads).engine == "own: a contact has friction"


def test_what_is_missing_is_named(monkeypatch, written):
    _, _, ball, scene = ball_between_blocks()
    loads = {"forces": {ball: (0.0, 0.0, -0.02)}, "engine": "petsc", "ranks": 1}
    # a launcher that runs one process, with a Python that has no petsc4py
    launcher = written('#!/bin/sh\nshift 2\nexec "$@"\n', "launch")
    launcher.chmod(0o755)
    monkeypatch.setenv("FECONTACT_MPIEXEC", str(launcher))
    monkeypatch.setenv("FECONTACT_MPI_PYTHON", f"{sys.executable} -S")
    with refused(MissingPackageError, "missing-package", "4"):
        scene.solve(**loads)
    monkeypatch.setenv("FECONTACT_MPIEXEC", "no-such-mpiexec -n")
    with refused(MissingPackageError, "missing-package", "apt install python3-petsc4py"):
        scene.solve(**loads)


SCENE = """
[materials.steel]
E = 1.0
nu = 0.3
[bodies.block]
shape = {kind = "block", size = [2.0, 2.0, 1.0], divisions = [3, 3, 2]}
material = "steel"
contact = "top"
supports = {bottom = "xyz"}
[bodies.ball]
type = "rigid"
shape = {kind = "sphere", radius = 3.0}
pose = {translation = [0.0, 0.0, 4.0]}
[[contacts]]
slave = "block"
master = "ball"
[solve]
finite_motion = false
[loads.forces]
ball = [0.0, 0.0, -0.02]
"""
