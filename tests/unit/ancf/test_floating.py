"""Bodies with modes: derivatives, turns, frequencies beside the full model, motion beside lines, files."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from differences import off_differences
from refusals import refused
from scipy.integrate import solve_ivp

import fecontact as fc
from fecontact.ancf import Assembly, EnergyMomentum, FloatingBody, Joints, move
from fecontact.fem.factor import symmetric
from fecontact.fem.modes import Modes, mass_of

STEEL = fc.Material(E=200.0, nu=0.3, density=2.0)


def bar(cells=(8, 2, 2), size=(10.0, 1.0, 1.2), material=STEEL, **given):
    return fc.ElasticBody(fc.shapes.block(size, cells), material, **given)


@pytest.fixture(scope="module")
def body():
    return FloatingBody(bar((4, 1, 1)).with_modes(4, kept=[0, 5]))


def test_forces_and_tangent_are_derivatives_of_the_energy(body):
    rng = np.random.default_rng(0)
    q, d = body.q0 + 0.1 * rng.normal(size=body.n_dofs), rng.normal(size=body.n_dofs)
    assert max(off_differences(body, q, d)) < 1e-7


def test_rigid_motions_and_mass(body):
    """No force by any turn, nothing else is free; mass and moments of inertia of the box."""
    turned = (body.q0.reshape(-1, 3) @ fc.rotation_about((1, 2, 3), 2.0).T).ravel()
    values = np.linalg.eigvalsh(body.tangent(turned).toarray())
    assert np.abs(body.forces(turned)).max() < 1e-12 * values[-1]
    assert (values < 1e-9 * values[-1]).sum() == 6
    R, mass = body.rigid_modes, 2.0 * 12.0
    found = np.diag(R.T @ body.mass @ R)
    known = [mass] * 3 + [mass * s / 12 for s in (1 + 1.44, 100 + 1.44, 100 + 1)]
    assert np.allclose(found, known, rtol=1e-10)


def test_frequencies_beside_the_full_model():
    """The first ten of a free bar within 1 % of those of all its nodes, from above; kept nodes or none."""
    whole = bar(contact="x_max")
    model = whole.model
    K, M = symmetric(model.stiffness), sp.kron(mass_of(model), sp.eye_array(3)).tocsc()
    values = spla.eigsh(K, 16, M, sigma=-0.01, return_eigenvectors=False)
    full = np.sqrt(np.sort(values)[6:]) / (2 * np.pi)
    for modes in (whole.with_modes(20), whole.with_modes(20, kept=[])):
        off = modes.frequencies(10) / full - 1
        assert off.min() > -1e-8
        assert off.max() < 0.01


def test_a_stiff_bar_is_a_compound_pendulum():
    """From level for 0.3 s: a'' = -(g L / 2) cos a / (L^2 / 3 + h^2 / 12); its sag and steps of 5 ms are 1e-3 late."""
    h, g = 0.1, 9.81
    mesh = fc.shapes.block((1.0, h, h), (4, 2, 2), element="hex8").translated((0.0, -h / 2, -h / 2))
    ends = [int(np.linalg.norm(mesh.points - [x, 0, 0], axis=1).argmin()) for x in (0, 1)]
    body = FloatingBody(fc.ElasticBody(mesh, fc.Material(E=2e6, nu=0.3, density=2.0)).with_modes(2, kept=ends))
    joints = Joints([body])
    held = [joints.pinned((0, ends[0])), *(joints.pinned((0, k), [(0, 0, 1)]) for k in range(3))]
    motion = move(Assembly([body], held), until=0.3, step=0.005, scheme=EnergyMomentum(), gravity=(0, -g, 0))
    tip = body.positions(motion.now.q)[ends[1]]
    pull = g / 2 / (1 / 3 + h**2 / 12)
    angle = solve_ivp(lambda _, y: [y[1], -pull * np.cos(y[0])], (0, 0.3), [0, 0], rtol=1e-9, atol=1e-9).y[0, -1]
    assert abs(np.arctan2(tip[1], tip[0]) / angle - 1) < 1e-3
    assert motion.drift < 1e-7


def test_modes_are_saved(tmp_path, body):
    body.modes.save(tmp_path / "bar.npz")
    again = Modes.load(tmp_path / "bar.npz")
    assert np.array_equal(again.stiffness, body.modes.stiffness)
    assert np.array_equal(again.mass, body.modes.mass)
    assert again.kept.tolist() == [0, 5]


def test_what_has_no_modes():
    for make, code in (
        (lambda: bar(supports={"x_min": "xyz"}).with_modes(2), "modes-of-held"),
        (lambda: bar(material=fc.Material(E=1.0, nu=0.3)).with_modes(2), "modes"),
        (lambda: bar(material=fc.NeoHookean(E=1.0, nu=0.3, density=1.0)).with_modes(2), "modes"),
        (lambda: bar((1, 1, 1)).with_modes(100), "number-of-modes"),
        (lambda: bar((1, 1, 1)).with_modes(2, kept=[1000]), "unknown-node"),
        (lambda: FloatingBody(bar((1, 1, 1)).with_modes(2)).place_rows(-500), "unknown-node"),
        (lambda: Joints([FloatingBody(bar((1, 1, 1)).with_modes(2))]).guided((0, 1), 1), "too-few-gradients"),
    ):
        with refused(fc.InputError, code):
            make()
