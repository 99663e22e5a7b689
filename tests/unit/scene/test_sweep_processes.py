"""Sweeps whose cases are solved by other processes: where they run from, what carries them, how they end."""

import copy
import json
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact.common.fingerprint import fingerprint
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.condensation import Carried
from fecontact.fem.pardiso import PardisoFactor
from fecontact.scene import local_search
from fecontact.scene.workers import FreshInterpreters

SOLID = fc.Material(E=1000.0, nu=0.3, density=1e-3)
#: Largest difference between rows found by one process and by several, relative or to 1.
SAME = 1e-12


def stacked(rigid=False):
    """A brick or a rigid ball over a pad."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (4, 4, 1)).translated((-2.0, -2.0, -1.0))
    pad = fc.ElasticBody(mesh, SOLID, "top", {"bottom": "xyz"}, name="pad")
    if rigid:
        over = fc.RigidBody(fc.Sphere(radius=5.0), name="ball")
    else:
        brick = fc.shapes.block((1.5, 1.5, 1.0), (2, 2, 1)).translated((-0.75, -0.75, 0.0))
        over = fc.ElasticBody(brick, SOLID, "bottom", {"top": "xyz"}, name="brick")
    return fc.Scene([pad, over], [fc.Contact(over, pad)]), over


def loaded(over, count=5):
    """Cases that differ in pose, motion and loads spread over the volume."""
    return [
        {
            "name": f"case {k}",
            "motions": {over: {"z": -0.02 - 0.002 * k}},
            "gravity": (0.1 * k, 0.0, -9.81),
            "poses": {over: fc.Pose(fc.rotation_about((0, 0, 1), 0.1 * k), (0.2 * k, 0.1, 0.0))},
        }
        for k in range(count)
    ]


def figures(value):
    """All numbers that a row says of the answer, in order; those of the way there are left out."""
    way = ("seconds", "n_candidates", "rounds", "iterations", "saved", "condensation", "memory_mb", "peak_rss_mb")
    if isinstance(value, dict):
        value = [v for k, v in value.items() if k not in way]
    if isinstance(value, list):
        return [n for v in value for n in figures(v)]
    return [value] if isinstance(value, (int, float)) else []


def assert_same(rows, others):
    for a, b in zip(rows, others, strict=True):
        assert (a["name"], a["warnings"], a["fingerprint"]) == (b["name"], b["warnings"], b["fingerprint"])
        one, other = np.array(figures(a)), np.array(figures(b))
        assert len(one) == len(other) > 20
        assert np.abs(one - other).max() <= SAME * max(1.0, np.abs(one).max())


@pytest.fixture(scope="module")
def alone():
    scene, over = stacked()
    return scene.sweep(loaded(over))


#: Where the tests' own modules are.
FOLDERS = [str(Path(__file__).parent), str(Path(__file__).parents[2])]
# no __main__ guard: the factorisation before starts the threads of MKL, which no fork would survive
PROGRAM = """
import json, sys
sys.path[:0] = FOLDERS
from test_sweep_processes import loaded, stacked
scene, over = stacked()
one = scene.sweep(loaded(over))
two = scene.sweep(loaded(over), processes=2)
print(json.dumps([list(one), list(two)]))
"""


@pytest.mark.full
@pytest.mark.parametrize("way", ["script", "standard input", "interactive"])
def test_two_workers_beside_two_threads_of_mkl_from_wherever_python_runs(way, tmp_path):
    environment = os.environ | {"OMP_NUM_THREADS": "2", "MKL_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}
    program = PROGRAM.replace("FOLDERS", repr(FOLDERS))
    (tmp_path / "program.py").write_text(program)
    arguments = {"script": ["program.py"], "standard input": ["-"], "interactive": ["-i", "-q"]}[way]
    done = subprocess.run(
        [sys.executable, *arguments],
        input=None if way == "script" else program,
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    assert_same(*json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.full
def test_the_standard_pool_carries_a_sweep(alone):
    scene, over = stacked()
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert_same(alone, scene.sweep(loaded(over), executor=pool))
        pool.submit(os.getpid).result()  # it is not shut down


@pytest.mark.filterwarnings("ignore:Sending large graph")
def test_dask_carries_a_sweep(alone):
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    scene, over = stacked()
    cluster = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.Client(**cluster) as client:
        assert_same(alone, scene.sweep(loaded(over), executor=client.get_executor(), processes=2))


def test_threads_carry_a_sweep_each_with_a_scene_of_its_own(alone):
    scene, over = stacked()
    with ThreadPoolExecutor(2) as pool:
        assert_same(alone, scene.sweep(loaded(over), executor=pool))


class Elsewhere(Executor):
    """Does every task somewhere else, where nothing is known of the tasks before."""

    def __init__(self):
        self.tasks = []

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.tasks.append(args)

        def work():
            try:
                future.set_result(fn(*args, **kwargs))
            except BaseException as error:
                future.set_exception(error)

        Thread(target=work).start()
        return future


def test_a_process_without_the_scene_asks_for_it(alone):
    scene, over = stacked()
    executor = Elsewhere()
    assert_same(alone, scene.sweep(loaded(over), executor=executor, processes=1 + len(alone)))
    assert len(executor.tasks) == 4  # all at once, each with the scene
    executor = Elsewhere()
    assert_same(alone, scene.sweep(loaded(over), executor=executor, processes=2))
    assert [args[2] is None for args in executor.tasks].count(True) == 2
    assert len(executor.tasks) == 6  # two came without the scene and had to be sent again


def test_a_pool_that_forks_is_refused():
    scene, over = stacked()
    with (
        ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool,
        refused(fc.InputError, "forking-executor"),
    ):
        scene.sweep(loaded(over), executor=pool)


def test_a_scene_that_cannot_be_sent_is_refused_by_name_before_any_work(monkeypatch):
    monkeypatch.setattr(local_search, "solved", lambda *args: pytest.fail("solved before it was refused"))
    scene, _ = stacked()
    bump = fc.RigidBody.from_function(lambda x, y: 0.1 * (x**2 + y**2), size=1.0, name="bump")
    scene = fc.Scene([scene.bodies[0], bump], [fc.Contact(scene.bodies[0], bump)])
    cases = [{"motions": {bump: {"z": -0.01}}}, {"motions": {bump: {"z": -0.02}}}]
    for way in ({"processes": 2}, {"executor": Elsewhere()}):
        with refused(fc.InputError, "input", "'bump'", "lambda"):
            scene.sweep(cases, **way)


@pytest.mark.full
def test_what_the_main_script_alone_knows_is_refused_by_name():
    program = (
        f"import sys; sys.path[:0] = {FOLDERS!r}\n"
        "import fecontact as fc\n"
        "from test_sweep_processes import stacked\n"
        "def z(x, y): return 0.1 * (x**2 + y**2)\n"
        "pad = stacked()[0].bodies[0]\n"
        "bump = fc.RigidBody.from_function(z, size=1.0, name='bump')\n"
        "scene = fc.Scene([pad, bump], [fc.Contact(pad, bump)])\n"
        "scene.sweep([{'motions': {bump: {'z': -0.01 * k}}} for k in (1, 2)], processes=2)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert "InputError: The body 'bump' cannot be sent to other processes: z is defined in the main" in done.stderr


@pytest.mark.full  # processes that import the package
def test_an_error_of_a_worker_comes_back_with_the_name_of_its_case():
    scene, ball = stacked(rigid=True)
    cases = [{"name": name, "forces": {ball: (0.0, 0.0, -force)}} for name, force in (("good", 3.0), ("up", -1.0))]
    with refused(fc.FecontactError, "free-motion", "'up'"):
        scene.sweep(cases)
    # a single worker, as each takes a second to start
    with FreshInterpreters(1) as pool, refused(fc.FecontactError, "free-motion", "'up'"):
        scene.sweep([*cases, {**cases[0], "name": "other"}], executor=pool)


def test_a_worker_that_dies_is_an_error_and_no_endless_wait():
    with refused(fc.FecontactError, "worker-ended", "(exit 5"), FreshInterpreters(1) as pool:
        pool.submit(os._exit, 5).result(timeout=60)


def test_other_errors_of_a_worker_say_where_they_come_from():
    with FreshInterpreters(1) as pool:
        with pytest.raises(ZeroDivisionError) as caught:
            pool.submit(divmod, 1, 0).result(timeout=60)
        assert "In a worker process" in caught.value.__notes__[0]
        assert pool.submit(print, "not part of the exchange").result(timeout=60) is None


@pytest.mark.full  # processes that import the package
def test_workers_share_the_cores_unless_the_environment_says_otherwise(monkeypatch):
    for given, expected in ((None, max(1, (os.cpu_count() or 1) // 2)), ("7", 7)):
        if given is None:
            monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
        else:
            monkeypatch.setenv("OMP_NUM_THREADS", given)
        with FreshInterpreters(2) as pool:
            assert int(pool.submit(os.getenv, "OMP_NUM_THREADS").result(timeout=60)) == expected


@pytest.mark.full  # three processes import the package anew
@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_a_killed_parent_leaves_no_worker_behind():
    program = (
        "import os, time\n"
        "from fecontact.scene.workers import FreshInterpreters\n"
        "pool = FreshInterpreters(2)\n"
        "busy = [pool.submit(time.sleep, 600) for _ in range(2)]\n"
        "while len(pool._started) < 2: time.sleep(0.01)\n"
        "print(*(p.pid for p in pool._started), flush=True)\n"
        "time.sleep(600)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    workers = [int(pid) for pid in parent.stdout.readline().split()]
    assert len(workers) == 2
    time.sleep(2.0)  # they are busy by now, or still starting: either way they must end
    assert all(alive(pid) for pid in workers)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    until = time.monotonic() + 60
    while any(alive(pid) for pid in workers) and time.monotonic() < until:
        time.sleep(0.1)
    left = [pid for pid in workers if alive(pid)]
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert not left


def alive(pid):
    """Whether a process runs; one that has ended and waits to be noticed does not."""
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True).stdout.strip()
    return bool(state) and not state.startswith("Z")


def test_a_model_by_value_answers_as_the_one_with_the_factor_does():
    model = stacked()[0].bodies[0].model
    nodes = model.mesh.boundary_nodes("top")
    condensation = model.condensed(nodes, Stopwatch())
    assert pickle.loads(pickle.dumps(model)).condensation is None  # without the inverse nothing of it is worth sending
    condensation.invert()
    sent = pickle.loads(pickle.dumps(model))
    assert isinstance(sent.condensation, Carried)
    assert sent.condensed(nodes[:3], Stopwatch()) is sent.condensation
    C = model.solved_rows(sp.eye_array(model.n_dofs, format="csr")[3 * nodes + 2])
    f = np.random.default_rng(0).normal(size=C.shape[1])
    for one, other in (
        (condensation.compliance(C), sent.condensation.compliance(C)),
        (condensation.response(C, f), sent.condensation.response(C, f)),
        (condensation.solve(f), sent.condensation.solve(f)),
    ):
        assert np.abs(one - other).max() <= SAME * np.abs(one).max()
    assert sent.condensation.memory > 0
    again = pickle.loads(pickle.dumps(sent))
    assert np.abs(again.condensation.solve(f) - condensation.solve(f)).max() <= SAME * np.abs(f).max()
    # nodes that were not retained: condensed again, the old ones kept
    further = np.array([np.setdiff1d(np.arange(len(model.mesh.points)), model.mesh.boundary_nodes("bottom"))[0]])
    assert sent.condensed(further, Stopwatch()).covers(np.flatnonzero(condensation.position >= 0))


def test_scenes_can_be_copied_and_factors_cannot():
    scene, ball = stacked(rigid=True)
    result = scene.solve(motions={ball: {"z": -0.02}})
    other = copy.deepcopy(scene)
    same = other.solve(motions={other.bodies[1]: {"z": -0.02}})
    assert abs(same.contacts[0].total_force / result.contacts[0].total_force - 1) < SAME
    factor = scene.bodies[0].model.factorised()
    if isinstance(factor, PardisoFactor):
        with pytest.raises(TypeError, match="cannot be copied or sent"):
            pickle.dumps(factor)
        with pytest.raises(TypeError, match="cannot be copied or sent"):
            copy.deepcopy(factor)


@pytest.mark.parametrize(
    "mesh",
    [
        replace(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).with_midface_nodes(("top",)), notes=("a note",)),
        fc.sections.rectangle((1.0, 1.0), (2, 2)),
    ],
)
def test_meshes_by_value_keep_all_they_were_made_from(mesh):
    sent = pickle.loads(pickle.dumps(mesh))
    assert fingerprint(sent) == fingerprint(mesh)
    with pytest.raises(TypeError):
        sent.boundaries["new"] = 0
