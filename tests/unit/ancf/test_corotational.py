"""Corotational beams: derivatives by differences, rigid motions, a linear cantilever, joints, motion, refusals."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from differences import off_differences
from refusals import refused

import fecontact as fc
from fecontact.ancf import Assembly, EnergyMomentum, Joints, move
from fecontact.ancf.slender import CorotationalBeam, straight

POINTS = straight((0, 0, 0), (2, 1, 0), 3)


@pytest.fixture(params=["modern", "1986"])
def beam(request):
    return CorotationalBeam(POINTS, EA=5.0, EI=0.3, mass_per_length=2.0, rotary=0.01, procedure=request.param)


def turned(beam, angle, place):
    """Coordinates after a rigid motion."""
    c, s = np.cos(angle), np.sin(angle)
    nodes = beam.q0.reshape(-1, 3)
    return np.column_stack([nodes[:, :2] @ np.array([[c, s], [-s, c]]) + place, nodes[:, 2] + angle]).ravel()


def test_forces_and_tangent_are_derivatives_of_the_energy(beam):
    rng = np.random.default_rng(0)
    q, d = beam.q0 + 0.3 * rng.normal(size=beam.n_dofs), rng.normal(size=beam.n_dofs)
    work, turn = off_differences(beam, q, d)
    assert work < 1e-8
    assert turn < 1e-7
    K = beam.tangent(q)
    assert abs(K - K.T).max() < 1e-12 * abs(K).max()


@pytest.mark.parametrize("angle", [1.0, 3.0, -9.0])
def test_rigid_motions_are_free_of_forces(beam, angle):
    """By more than a turn too."""
    q = turned(beam, angle, (3.0, -2.0))
    assert np.abs(beam.forces(q)).max() < 1e-13
    values = np.linalg.eigvalsh(beam.tangent(q).toarray())
    assert (values < 1e-10 * values[-1]).sum() == 3
    assert np.abs(beam.tangent(beam.q0) @ beam.rigid_modes).max() < 1e-13 * values[-1]


def test_mass_is_that_of_the_body(beam):
    """Mass 2 L, moment of inertia (2 L^2 / 12 + rotary) L about the middle, L^2 = 5."""
    R, L = beam.rigid_modes, np.sqrt(5)
    inertia = R.T @ beam.mass @ R
    assert np.allclose(np.diag(inertia), [2 * L, 2 * L, 0, 0, 0, (2 * 5 / 12 + 0.01) * L], rtol=1e-14)


def test_a_linear_cantilever_is_exact(beam):
    """Nodal values of cubic functions under a force at the tip: F L^3 / (3 E I)."""
    joints = Joints([beam])
    Z = joints.free([joints.clamped((0, 0))])
    across = np.array([-1.0, 2.0, 0.0]) / np.sqrt(5)
    f = np.zeros(beam.n_dofs)
    f[-3:] = across
    u = Z @ spla.spsolve((Z.T @ beam.tangent(beam.q0) @ Z).tocsc(), Z.T @ f)
    assert abs(u[-3:] @ across / (5**1.5 / (3 * 0.3)) - 1) < 1e-12


def test_a_pinned_chain_moves_with_its_energy(beam):
    """Two bars joined by a pin, a slot across z, fall from rest about another pin."""
    joints = Joints([beam, beam])
    # the second bar starts where the first one does and lies on it
    pins = [joints.pinned((0, 0), np.eye(3)[:2]), joints.slot((0, -1), (1, -1), (0, 0, 1))]
    chain = Assembly([beam, beam], pins)
    motion = move(chain, until=0.5, step=0.02, gravity=(0, -9.81, 0), scheme=EnergyMomentum(), every=1)
    assert motion.success
    assert motion.drift < 1e-8
    ends = motion.frames.reshape(len(motion.frames), 2, -1, 3)[:, :, -1, :2]
    assert np.abs(ends[:, 0] - ends[:, 1]).max() < 1e-13
    assert np.abs(ends[-1, 0] - ends[0, 0]).max() > 0.5


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"points": [(0, 0, 0)]}, ("axis-nodes",)),
        ({"points": [(0, 0, 0), (1, 0, 0), (1, 1, 0)]}, ("bent",)),
        ({"points": [(0, 0, 1), (1, 0, 1)]}, ("not-in-plane",)),
        ({"EA": 0.0}, ("not-positive", "EA")),
        ({"rotary": -1.0}, ("negative-mass", "-1.0")),
        ({"procedure": "best"}, ("unknown-name", "procedure")),
    ],
)
def test_bad_input(given, message):
    with refused(fc.InputError, *message):
        CorotationalBeam(**{"points": POINTS, "EA": 5.0, "EI": 0.3} | given)
