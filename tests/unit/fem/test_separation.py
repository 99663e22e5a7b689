"""Rigid motions separated by Gram-Schmidt, the source report's route, against the pseudo-inverse and other routes."""

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem import model as model_module
from fecontact.fem.condensation import Condensation, Separated
from fecontact.fem.rigid import complement, gram_schmidt


@pytest.mark.parametrize("k", [0, 1, 6])
def test_the_complement_is_orthonormal_and_orthogonal(k):
    """Also where the given columns are large in a few rows only, as for a node far from all others."""
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(60, k))
    columns[:4] *= 1e6
    Q = gram_schmidt(columns)
    S = complement(Q)
    assert S.shape == (60, 60 - k)
    # a few roundings of sums of sixty products
    assert np.abs(S.T @ S - np.eye(60 - k)).max() < 1e-14
    assert np.abs(Q.T @ S).max(initial=0.0) < 1e-14


def block(condensation="auto", supports=None, name="block"):
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (3, 2, 2))
    return fc.ElasticBody(
        mesh, fc.Material(E=3.0, nu=0.3), "bottom", supports or {}, condensation=condensation, name=name
    )


@pytest.mark.parametrize("supports", [{}, {"x_min": "x"}, {"x_min": "xyz"}])
def test_it_is_the_pseudo_inverse_of_a_floating_stiffness(supports):
    """S (S^T K S)^-1 S^T inverts K on what is orthogonal to the rigid motions, as its eigenvectors do."""
    body = block("gram-schmidt", supports)
    upper = body.model.solved_stiffness()
    K = (upper + sp.triu(upper, 1).T).toarray()
    values, vectors = np.linalg.eigh(K)
    elastic = values > 1e-9 * values[-1]
    assert (~elastic).sum() == body.free_motions.shape[1]
    expected = (vectors[:, elastic] / values[elastic]) @ vectors[:, elastic].T
    found = body.model.condensed(np.arange(5), Stopwatch())
    f = np.random.default_rng(1).normal(size=len(K))
    assert np.abs(found.solve(f) - expected @ f).max() < 1e-11 * np.abs(expected @ f).max()
    C = sp.csr_matrix(np.random.default_rng(2).normal(size=(4, len(K))))
    S = found.compliance(C)
    assert (S == S.T).all()
    assert np.abs(S - C @ expected @ C.T).max() < 1e-11 * np.abs(S).max()


def pressed(condensation):
    """A block on a rigid plane, which part of it leaves; two planes of symmetry, floating otherwise."""
    upper = block(condensation, {"x_min": "x", "y_min": "y"})
    plane = fc.RigidBody(fc.Plane())
    scene = fc.Scene([upper, plane], [fc.Contact(upper, plane)])
    result = scene.solve(
        forces={(upper, "top"): (0.0, 0.0, -0.01), (upper, "x_max"): (0.002, 0.0, 0.0)},
        moments={upper: (0.0, 0.0008, 0.0)},
    )
    return result, upper


def test_forces_and_displacements_are_those_of_the_other_routes():
    (one, a), (other, b) = pressed("gram-schmidt"), pressed("auto")
    assert one.condensation != other.condensation
    forces = other.contacts[0].forces
    assert 0 < (forces > 0).sum() < len(forces)
    assert np.abs(one.contacts[0].forces - forces).max() < 1e-12 * forces.max()
    expected = other.displacement(b)
    assert np.abs(one.displacement(a) - expected).max() < 1e-11 * np.abs(expected).max()


def test_a_model_too_large_for_dense_matrices_is_refused(monkeypatch):
    monkeypatch.setattr(model_module, "memory_budget", lambda: 1e6)
    with refused(fc.InputError, "out-of-memory", "0.0022", "301"):
        pressed("gram-schmidt")


def test_it_is_a_condensation():
    found: Condensation = Separated.of(sp.eye_array(3, format="csr"), np.zeros((3, 0)), 1e6)
    assert found.covers(np.arange(3))
    assert (found.n_retained, found.memory) == (3, 2 * 72)
