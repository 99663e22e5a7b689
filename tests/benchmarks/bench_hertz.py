"""Stages of the main job, two equal spheres at level 2, each by itself (`make bench`; docs/benchmarks.md).

Every benchmark is one stage, so that a slowdown is seen where it is. Run with OMP_NUM_THREADS=1.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from fecontact.app.studies.spheres import CASES, solve_spheres
from fecontact.contact.coupling.mortar import pair_mortar
from fecontact.contact.coupling.nodal import SurfacePair, pair
from fecontact.fem.factor import condense
from fecontact.fem.stiffness import assemble_stiffness
from fecontact.mesh import shapes
from fecontact.solvers import solve

LEVEL = 2


@pytest.fixture(scope="module")
def job():
    """The solved job and what its stages take and give."""
    out = solve_spheres("equal", level=LEVEL)
    upper, lower = out.solved.scene.bodies
    model = upper.model
    nodes = out.solved._interfaces[0].pairing.nodes[out.solved.contacts[0]._candidates]
    K = model.stiffness[model.solved_dofs][:, model.solved_dofs]
    touched = np.setdiff1d((3 * nodes[:, None] + np.arange(3)).ravel(), model.held)
    return SimpleNamespace(
        out=out,
        upper=upper,
        lower=lower,
        model=model,
        K=K,
        retained=np.searchsorted(model.solved_dofs, np.intersect1d(touched, model.solved_dofs)),
        problem=out.solved._condensed.problem,
        displacement=out.solved.displacement(upper).ravel(),
    )


def test_mesh(benchmark, job):
    R = CASES["equal"].radii[0]
    mesh = benchmark(lambda: shapes.quarter_sphere(R, contact_radius=job.out.data["fitted_radius"], level=LEVEL))
    assert len(mesh.cells) == len(job.upper.mesh.cells)


def test_assembly(benchmark, job):
    K = benchmark(assemble_stiffness, job.model.mesh, job.model.lame, job.model.shear)
    assert K.shape[0] == job.upper.n_dofs


def test_factor(benchmark, job):
    """One degree of freedom is kept: the plain factorisation."""
    factor = benchmark.pedantic(condense, (job.K, job.retained[:1]), rounds=3)
    assert factor.stiffness.shape == (1, 1)


def test_factor_and_schur_complement(benchmark, job):
    """The candidates' degrees of freedom are kept; the difference to `test_factor` is the price of the condensation."""
    factor = benchmark.pedantic(condense, (job.K, job.retained), rounds=3)
    assert factor.stiffness.shape == (len(job.retained),) * 2


@pytest.mark.parametrize("coupling", ["nodal", "mortar"])
def test_pairing(benchmark, job, coupling):
    relative = job.upper.pose.relative_to(job.lower.pose)
    couple = pair if coupling == "nodal" else pair_mortar
    arguments = (job.upper.surface("cap"), job.lower.surface("cap"), relative.rotation, relative.translation)
    pairing = benchmark.pedantic(lambda: couple(SurfacePair(*arguments)), rounds=3)
    assert len(pairing.nodes) > 0


@pytest.mark.parametrize("solver", ["active-set", "nnls"])
def test_solve(benchmark, job, solver):
    solution = benchmark(solve, job.problem, solver)
    assert solution.success


def test_stress_recovery(benchmark, job):
    stress = benchmark(job.model.nodal_stress, job.displacement)
    assert stress.shape == (len(job.model.mesh.points), 6)


def test_vtu(benchmark, job, tmp_path):
    path = benchmark.pedantic(job.out.solved.save, (tmp_path / "spheres.vtu",), rounds=3)
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize("model", ["two-bodies", "symmetric", "axisymmetric"])
def test_whole_job(benchmark, model):
    out = benchmark.pedantic(solve_spheres, kwargs={"level": LEVEL, "model": model}, rounds=3, warmup_rounds=1)
    assert out.figures["pressure, L2"].found < 0.02
