"""Conjugate gradients on rows against the dense equations; cycles restricted to rows against cycles made anew."""

import numpy as np
import pytest
import scipy.sparse as sp

import fecontact as fc
from fecontact.fem.constrained_cg import Held, constrained_cg
from fecontact.fem.multigrid import DependentRowsError, SparseRows, half_space_compliance
from fecontact.solvers import ContactProblem, solve


def problem(seed, n=40, a=7, m=2, per_row=4):
    rng = np.random.default_rng(seed)
    K = rng.standard_normal((n, n))
    K = K @ K.T + np.eye(n)
    G = np.zeros((a, n))
    for row in G:
        row[rng.choice(n, per_row, replace=False)] = rng.standard_normal(per_row)
    B, F = rng.standard_normal((m, a)), rng.standard_normal(m)
    return K, sp.csr_matrix(G), rng.uniform(0.1, 2.0, n), rng.standard_normal(a), B, F


def exact(K, G, d, B, F):
    """Displacements, forces and motions from the whole matrix of the equations."""
    G, (a, n), m = G.toarray(), G.shape, len(F)
    zero = np.zeros
    whole = np.block([[K, -G.T, zero((n, m))], [G, zero((a, a)), B.T], [zero((m, n)), B, zero((m, m))]])
    return np.split(np.linalg.solve(whole, np.concatenate([zero(n), -d, F])), [n, n + a])


@pytest.mark.parametrize("per_row", [1, 4])
@pytest.mark.parametrize("m", [0, 2])
def test_the_equations_of_bodies_on_rows(per_row, m):
    """Source: a dense solve. The condition is below 1e4, so that 1e-12 of the residual is 1e-8 of the answer."""
    for seed in range(5):
        K, G, W, d, B, F = problem(seed, m=m, per_row=per_row)
        if per_row == 1:  # on different displacements
            G = sp.csr_matrix((G.data, np.random.default_rng(seed).permutation(40)[:7], G.indptr), shape=G.shape)
        steps = []
        V = np.diag(1.0 / K.diagonal())
        held = Held(K.dot, V.dot, SparseRows(G, W), d, B, F, np.eye(m))
        found = constrained_cg(held, np.zeros(40), np.zeros(m), 1e-12, lambda s=steps: s.append(1))
        for mine, true in zip(found, exact(K, G, d, B, F), strict=True):
            assert mine == pytest.approx(true, rel=1e-7, abs=1e-7)
        again = []
        constrained_cg(held, found[0], found[2], 1e-11, lambda s=again: s.append(1))
        assert len(steps) > 5
        assert not again


def test_a_preconditioner_without_numbers_ends_the_iteration():
    """The displacements that keep the rows remain, and are numbers."""
    K, G, W, d, B, F = problem(1)
    held = Held(K.dot, lambda r: r * np.nan, SparseRows(G, W), d, B, F, np.eye(2))
    u, _, q = constrained_cg(held, np.zeros(40), np.zeros(2), 1e-12, lambda: None)
    assert G @ u + d + B.T @ q == pytest.approx(np.zeros(7), abs=1e-12)


def test_lift_and_projection():
    """G L = 1, G P = 0, P P = P, and L^T finds the forces in G^T l."""
    _, G, W, d, _, _ = problem(3)
    rows, v = SparseRows(G, W), np.random.default_rng(0).standard_normal(40)
    assert G @ rows.lift(d) == pytest.approx(d, rel=1e-12)
    assert G @ rows.project(v) == pytest.approx(np.zeros(7), abs=1e-12)
    assert rows.project(rows.project(v)) == pytest.approx(rows.project(v), abs=1e-12)
    assert rows.forces(rows.nodal(d)) == pytest.approx(d, rel=1e-12)


@pytest.mark.parametrize("G", [[[1.0, 2.0], [2.0, 4.0]], [[1.0, 0.0], [0.0, 0.0]]])
def test_dependent_rows_are_refused(G):
    with pytest.raises(DependentRowsError):
        SparseRows(sp.csr_matrix(np.array(G)), np.ones(2))


def test_bodies_side_by_side_have_their_own_cycles():
    """Also where one has more levels. Source: the cycles by themselves, in single precision."""
    pytest.importorskip("pyamg")
    from fecontact.fem.amg import AmgFactor, Cycle

    cycles, parts = [], []
    for divisions in ((3, 3, 2), (9, 9, 8)):
        mesh = fc.shapes.block((1.0, 1.0, 1.0), divisions, element="hex8")
        model = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"bottom": "xyz"}, backend="amg").model
        cycles.append(AmgFactor(model.solved_stiffness(), model.nodal_modes[model.solved_dofs]).cycle)
        parts.append(np.random.default_rng(1).standard_normal(len(model.solved_dofs)))
    assert len(cycles[0].levels) < len(cycles[1].levels)
    both = Cycle.side_by_side(cycles)(np.concatenate(parts))
    alone = np.concatenate([cycle(r) for cycle, r in zip(cycles, parts, strict=True)])
    # the shallow body is smoothed before its exact solution, which leaves rounding times the condition
    assert both == pytest.approx(alone, abs=1e-3 * np.abs(alone).max())


def test_sweeps_by_halves_are_sweeps():
    """Source: Gauss-Seidel's sweeps of the whole matrix by pyamg, with the residual between them."""
    pytest.importorskip("pyamg")
    from pyamg.relaxation.relaxation import gauss_seidel

    from fecontact.fem.amg import Level

    rng = np.random.default_rng(4)
    A = rng.standard_normal((30, 30)) * (rng.random((30, 30)) < 0.2)
    A = sp.csr_matrix((A @ A.T + 5.0 * np.eye(30)).astype(np.float32))
    P = sp.csr_matrix(rng.standard_normal((30, 6)).astype(np.float32))
    b, e = (rng.standard_normal(n).astype(np.float32) for n in (30, 6))
    restricted = []
    found = Level.of(A, P, P.T.tocsr()).correct(b, lambda r: restricted.append(r) or e)
    x = np.zeros_like(b)
    gauss_seidel(A, x, b, sweep="symmetric")
    assert restricted[0] == pytest.approx(P.T @ (b - A @ x), rel=1e-4, abs=1e-5)
    x += P @ e
    gauss_seidel(A, x, b, sweep="symmetric")
    assert found == pytest.approx(x, rel=1e-4, abs=1e-5)


def test_a_cycle_restricted_to_rows_is_that_of_the_restricted_matrix():
    """On every level the matrix is the one between its interpolations, and the constrained stiffness on the first.

    Source: products of the whole matrices. They are in single precision.
    """
    pytest.importorskip("pyamg")
    from fecontact.fem.amg import AmgFactor

    mesh = fc.shapes.block((1.0, 1.0, 1.0), (7, 7, 6), element="hex8")
    model = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"bottom": "xyz"}, backend="amg").model
    K, dofs = model.solved_stiffness(), model.solved_dofs
    factor = AmgFactor(K, model.nodal_modes[dofs])
    nodes = np.flatnonzero(mesh.points[:, 2] > mesh.points[:, 2].max() - 1e-9)[:20]
    number = np.searchsorted(dofs, 3 * nodes)
    normal = np.random.default_rng(1).standard_normal((20, 3))
    G = sp.csr_matrix(
        (normal.ravel(), (np.repeat(np.arange(20), 3), (number[:, None] + np.arange(3)).ravel())), (20, len(dofs))
    )
    rows = SparseRows(G, 1.0 / factor.K.diagonal())
    assert rows.apart
    cycle = factor.cycle.restricted(*rows.removed())
    P = np.eye(len(dofs)) - np.array([rows.lift(column) for column in G.T.toarray()]).T
    A = P.T @ factor.K.toarray() @ P
    assert len(cycle.levels) == 1
    level = cycle.levels[0]
    first, down, up = level.A, level.P, level.R
    v = np.random.default_rng(2).standard_normal(len(dofs))
    v = rows.project(v)
    assert first @ v == pytest.approx(A @ v, abs=1e-5 * np.abs(A @ v).max())
    assert abs(G @ down).max() < 1e-5
    assert cycle.coarsest.toarray() == pytest.approx(up @ A @ down.toarray(), abs=1e-5 * A.max())
    r = rows.G.T @ np.ones(20)
    assert cycle(r) @ (factor.K @ cycle(r)) > 0


def test_half_spaces_of_a_quarter_press_as_the_whole():
    """Forces of a ball on a symmetric grid, and on its quarter with mirror images: half of them on a plane."""
    x = np.linspace(-1.0, 1.0, 9)
    whole = np.column_stack([*(v.ravel() for v in np.meshgrid(x, x)), np.zeros(81)])
    own = (whole[:, :2] >= 0).all(axis=1)
    part = whole[own]
    planes = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, -50.0]])  # the last is far away

    def forces(points, compliance):
        return solve(ContactProblem(compliance, 0.5 * (points**2).sum(axis=1) - 0.3)).forces

    alone = forces(whole, half_space_compliance(whole))[own] / 2.0 ** (part[:, :2] == 0).sum(axis=1)
    mirrored = forces(part, half_space_compliance(part, planes))
    assert 0 < (mirrored > 0).sum() < len(part)
    assert np.abs(mirrored - alone).max() < 1e-10 * alone.max()
    without = forces(part, half_space_compliance(part))
    assert np.abs(without / without.sum() - alone / alone.sum()).max() > 0.05
