"""Bodies with several windows: against one window over all contacts, as a matrix and as an operator, refusals."""

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact.bodies.local import body as local_body
from fecontact.common.stopwatch import Stopwatch

SOLID = fc.Material(E=1.0, nu=0.3)
PLACES = (1.3, 2.7)


def _block():
    """Its top at z = 1, its bottom clamped at z = -2."""
    mesh = fc.shapes.block((4.0, 2.0, 3.0), (8, 4, 5))
    mesh = mesh.drawn_at(mesh.points - [0.0, 0.0, 2.0])
    return fc.ElasticBody(mesh, SOLID, supports={"bottom": "xyz"}, name="block")


def _balls():
    places = [fc.Pose(translation=(x, 1.0, 1.0)) for x in PLACES]
    return [fc.RigidBody(fc.Sphere(5.0), pose=pose, name=f"ball {i}") for i, pose in enumerate(places)]


def _windowed(body, side=0.6, cells=20):
    return fc.WindowedBody(*(fc.LocalBody(body, (x, 1.0, 1.0), side, (cells, cells)) for x in PLACES))


def _pressed(body, names, forces=(0.004, 0.001)):
    balls = _balls()
    contacts = [fc.Contact(body, ball, surfaces=(name, "surface")) for ball, name in zip(balls, names, strict=True)]
    loads = {ball: (0.0, 0.0, -force) for ball, force in zip(balls, forces, strict=True)}
    result = fc.Scene([body, *balls], contacts).solve(forces=loads, finite_motion=False)
    return result, np.array([-result.rigid_motion(ball).translation[2] for ball in balls])


def _every_cell(both):
    """Rows for the displacements of all cells into the body."""
    n = both._n_cells
    rows = sp.kron(sp.eye_array(n), np.array([[0.0, 0.0, -1.0]]), format="csr")
    return sp.csr_matrix(sp.hstack([rows, sp.csr_matrix((n, both.n_dofs - 3 * n))]))


@pytest.mark.full
def test_two_windows_are_as_one_over_both():
    """Cells of the same size and place; the single window is long, so that its own remainder is less smooth."""
    body = _block()
    two, apart = _pressed(both := _windowed(body), ("window 1", "window 2"))
    one = fc.LocalBody(body, (2.0, 1.0, 1.0), (2.1, 0.6), (70, 20))
    _, together = _pressed(one, ("window", "window"))
    np.testing.assert_allclose(apart, together, rtol=2e-3)
    assert both.defect < 1e-3
    # and the coupling is no trifle: without it the light ball sinks in less
    alone = fc.LocalBody(body, (PLACES[1], 1.0, 1.0), 0.6, (20, 20))
    ball = _balls()[1]
    single = fc.Scene([alone, ball], [fc.Contact(alone, ball)]).solve(
        forces={ball: (0.0, 0.0, -0.001)}, finite_motion=False
    )
    assert -single.rigid_motion(ball).translation[2] < 0.97 * together[1]
    assert two.residuals().worst < 1e-8


def test_operator_is_the_matrix(monkeypatch):
    both = _windowed(_block(), cells=6)
    n, rows = both._n_cells, _every_cell(both)
    dense = both.reduce(rows, None, Stopwatch()).compliance
    monkeypatch.setattr(local_body, "DENSE_LIMIT", 10)
    operator = both.reduce(rows, None, Stopwatch()).compliance
    assert isinstance(operator, local_body.WindowsCompliance)
    np.testing.assert_allclose(operator @ np.eye(n), dense, rtol=0, atol=1e-13 * np.abs(dense).max())
    np.testing.assert_allclose(dense, dense.T, rtol=0, atol=1e-15 * np.abs(dense).max())
    assert np.linalg.eigvalsh(dense).min() > 0


@pytest.mark.full
def test_many_cells_in_both_windows_give_the_same(monkeypatch):
    body = _block()
    names = ("window 1", "window 2")
    _, dense = _pressed(_windowed(body), names)
    monkeypatch.setattr(local_body, "DENSE_LIMIT", 10)
    result, operator = _pressed(_windowed(body), names)
    np.testing.assert_allclose(operator, dense, rtol=1e-6)
    assert result.residuals().worst < 1e-8


def test_displacements_are_those_of_the_compliance():
    """Along the rows, and at a node of the mesh in the window that carries nothing."""
    both = _windowed(_block(), side=0.65, cells=13)
    rows = _every_cell(both)
    forces = np.zeros(rows.shape[0])
    forces[169:] = np.random.default_rng(1).uniform(0, 1e-5, 169)
    u = both.displacement(rows, forces, None)
    S = both.reduce(rows, None, Stopwatch()).compliance
    np.testing.assert_allclose(rows @ u, S @ forces, rtol=0, atol=1e-12 * np.abs(S @ forces).max())
    u = u.reshape(-1, 3)
    points = np.concatenate([*(part.window.cells for part in both.parts), both.body.model.mesh.points])
    (node,) = both._n_cells + np.flatnonzero((np.abs(points[both._n_cells :] - [1.5, 1.0, 1.0]) < 1e-9).all(axis=1))
    cell = np.argmin(np.linalg.norm(points[:169] - [1.5, 1.0, 1.0], axis=1))
    assert np.linalg.norm(points[cell] - points[node]) < 1e-9
    assert u[node, 2] == pytest.approx(u[cell, 2], rel=1e-3)  # one by the nodes' loads, one by interpolation


def test_windows_on_different_faces_see_each_other_alike():
    mesh = fc.shapes.block((2.0, 2.0, 2.0), (5, 5, 5))
    cube = fc.ElasticBody(mesh, SOLID, supports={"bottom": "xyz"})
    both = fc.WindowedBody(
        fc.LocalBody(cube, (1.0, 1.0, 2.0), 0.5, (8, 8)), fc.LocalBody(cube, (2.0, 1.0, 1.0), 0.5, (8, 8))
    )
    assert 0 < both.defect < 5e-3
    core = both._across[0, 1]
    assert core.shape == both._across[1, 0].T.shape
    np.testing.assert_array_equal(core, both._across[1, 0].T)
    # pressed on top it bulges at the side: outward there, against the load
    assert core.mean() < 0


def test_a_floating_body_has_one_hold_for_all_windows():
    mesh = fc.shapes.block((4.0, 2.0, 1.0), (6, 4, 3))
    free = fc.ElasticBody(mesh, SOLID)
    at = ((2.0, 1.0, 1.0), (2.0, 1.0, 0.0))
    both = fc.WindowedBody(*(fc.LocalBody(free, place, 0.5, (10, 10)) for place in at))
    assert both.free_motions.shape == (6, 6)
    assert both._windows[0].factored is both._windows[1].factored
    assert both.defect < 5e-3


def test_bad_parts_are_refused():
    body = _block()
    part = fc.LocalBody(body, (1.0, 1.0, 1.0), 0.6, (8, 8))
    with refused(fc.InputError, "too-few-windows"):
        fc.WindowedBody(part)
    with refused(fc.InputError, "input", "of one elastic body"):
        fc.WindowedBody(part, fc.LocalBody(_block(), (3.0, 1.0, 1.0), 0.6, (8, 8)))
    with refused(fc.InputError, "input", "placed when it is touched"):
        fc.WindowedBody(part, fc.LocalBody(body))
    near = fc.LocalBody(body, (1.65, 1.0, 1.0), 0.6, (8, 8))
    with refused(fc.InputError, "windows-too-close"):
        fc.WindowedBody(part, near)
    far = fc.LocalBody(body, (1.95, 1.0, 1.0), 0.6, (8, 8))
    both = fc.WindowedBody(part, far)
    with refused(fc.InputError, "input", "window 1, window 2"):
        both.surface("window")
