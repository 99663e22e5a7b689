"""Condensation: every back-end against dense algebra."""

import importlib.util

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import FecontactError, MissingPackageError, SolverNotFoundError
from fecontact.fem import factor
from fecontact.fem.factor import available_backends, condense

# stiffnesses of a few hundred to a few thousand unknowns, condition about 1e4
CLOSE = 1e-10


@pytest.fixture(params=["superlu", "superlu without metis", *(b for b in available_backends() if b != "superlu")])
def backend(request, monkeypatch):
    name, _, without = request.param.partition(" ")
    if without:
        find = importlib.util.find_spec
        monkeypatch.setattr(factor.importlib.util, "find_spec", lambda n: None if n == "pymetis" else find(n))
    return name


@pytest.fixture(scope="module")
def case():
    """A held block big enough for nested dissection, retained dofs out of order, and its dense stiffness."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (4, 4, 4))
    body = fc.ElasticBody(mesh, fc.Material(E=3.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
    solved = body.model.solved_dofs
    K = body.model.stiffness[solved][:, solved].tocsr()
    dense = K.toarray()
    dense += np.triu(dense, 1).T
    retained = np.random.default_rng(7).permutation(len(dense))[:40]
    return K, dense, retained


def close(a, b):
    return np.abs(a - b).max() < CLOSE * np.abs(b).max()


def test_condensed_stiffness_is_the_schur_complement(case, backend):
    K, dense, c = case
    assert len(dense) > 1000
    i = np.setdiff1d(np.arange(len(dense)), c)
    expected = dense[np.ix_(c, c)] - dense[np.ix_(c, i)] @ np.linalg.solve(dense[np.ix_(i, i)], dense[np.ix_(i, c)])
    found = condense(K, c, backend).stiffness
    assert close(found, expected)
    assert np.abs(found - found.T).max() < CLOSE * np.abs(found).max()


def test_nothing_is_left_to_eliminate(case, backend):
    """All degrees of freedom retained, in another order: the stiffness itself. PARDISO crashes here."""
    K, dense, _ = case
    n = 67
    c, f = np.roll(np.arange(n), 5), np.ones((n, 1))
    condensed = condense(K[:n, :n].tocsr(), c, backend)
    assert close(condensed.stiffness, dense[np.ix_(c, c)])
    assert close(condensed.reduce(f), f)
    assert close(condensed.expand(f, 0 * f), f)


@pytest.mark.parametrize("n_loads", [1, 3])
def test_reduce_and_expand_give_the_full_solution(case, backend, n_loads):
    K, dense, c = case
    f = np.random.default_rng(8).normal(size=(len(dense), n_loads))
    condensed = condense(K, c, backend)
    u_c = np.linalg.solve(condensed.stiffness, condensed.reduce(f))
    expected = np.linalg.solve(dense, f)
    assert close(u_c, expected[c])
    assert close(condensed.expand(u_c, f), expected)


def test_compliance_is_the_inverse(case, backend):
    K, dense, c = case
    assert close(np.linalg.inv(condense(K, c, backend).stiffness), np.linalg.inv(dense)[np.ix_(c, c)])


def test_everything_retained(backend):
    dense = np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 2]])
    condensed = condense(sp.csr_matrix(np.triu(dense)), np.array([2, 0, 1]), backend)
    assert close(condensed.stiffness, dense[np.ix_([2, 0, 1], [2, 0, 1])])
    f = np.array([[1.0], [2.0], [3.0]])
    assert close(condensed.reduce(f), f[[2, 0, 1]])
    assert close(condensed.expand(f[[2, 0, 1]], f), f)


def test_inputs_are_left_alone(case, backend):
    K, _, c = case
    before, f = K.copy(), np.ones((K.shape[0], 2))
    condensed = condense(K, c, backend)
    condensed.expand(np.zeros((len(c), 2)), f)
    condensed.reduce(f)
    assert (before != K).nnz == 0
    assert (f == 1).all()


def test_singular_stiffness_is_an_error():
    # a loose node: nothing at all on its diagonal
    K = sp.csr_matrix(np.triu([[2.0, -1, 0], [-1, 2, 0], [0, 0, 0]]))
    for backend in available_backends():
        with refused(FecontactError, "singular"):
            condense(K, np.array([0]), backend)


def test_rslab_refuses_what_is_not_definite():
    pytest.importorskip("rslab")
    loose = sp.diags([np.full(100, 2.0), np.full(99, -1.0)], [0, 1]).tolil()
    loose[50, 49:52] = loose[49, 50] = 0.0  # one node held by nothing
    for K in (loose.tocsr(), (loose - 3.0 * sp.eye(100)).tocsr()):
        with refused(FecontactError, "singular", "body is loose"):
            factor.factorise(K, "rslab")


def test_unknown_and_missing_backends(monkeypatch):
    K = sp.csr_matrix(np.eye(2))
    with refused(SolverNotFoundError, "unknown-solver", "'cholmod'", "superlu"):
        condense(K, np.array([0]), "cholmod")
    monkeypatch.setattr(factor, "available_backends", lambda: ("superlu",))
    for name, package in (("pardiso", "pypardiso"), ("rslab", "rslab")):
        with refused(MissingPackageError, "missing-package", f"pip install {package}"):
            condense(K, np.array([0]), name)
    assert condense(K, np.array([0]), "auto").stiffness[0, 0] == 1


def test_many_factors_live_side_by_side(case):
    K, _, c = case
    first = condense(K, c)
    kept = first.reduce(np.ones((K.shape[0], 1)))
    others = [condense(K * s, c[:10]) for s in (2.0, 3.0)]
    assert np.array_equal(first.reduce(np.ones((K.shape[0], 1))), kept)
    del others
    assert np.array_equal(first.reduce(np.ones((K.shape[0], 1))), kept)
