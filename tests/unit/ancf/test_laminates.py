"""Orthotropic and laminated plates: Navier's series, cylindrical bending, turned layers; what is refused."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from refusals import refused

import fecontact as fc
from fecontact.ancf import Joints, traction
from fecontact.ancf.slender import Lamina, Laminate, plate

PLY = Lamina(E1=25.0, E2=1.0, nu12=0.25, G12=0.5)
SIDES = (1.0, 0.7)


def bent(made, sides=SIDES, n=(10, 10), loads=(0, 0, 1.0), thickness=None):
    """Deflection of the middle of a simply supported plate under a uniform load, by its linear stiffness."""
    s = plate([(0, 0, 0), (sides[0], 0, 0), (0, sides[1], 0)], n, made, thickness)
    x, joints = s.vectors[:, 0], Joints([s])
    rims = {d: np.flatnonzero((np.abs(x[:, d]) < 1e-9) | (np.abs(x[:, d] - sides[d]) < 1e-9)) for d in (0, 1)}
    held = [joints.pinned((0, int(k)), [(0, 0, 1)]) for k in np.union1d(rims[0], rims[1])]
    # along an edge the deflection is zero, and so is its slope
    held += [joints.guided((0, int(k)), 2, [(0, 0, 1)]) for k in rims[0]]
    held += [joints.guided((0, int(k)), 1, [(0, 0, 1)]) for k in rims[1]]
    held += [joints.pinned((0, 0)), joints.pinned((0, n[1]), [(1, 0, 0)])]
    Z = joints.free(held)
    u = Z @ spla.spsolve((Z.T @ s.tangent(s.q0) @ Z).tocsc(), Z.T @ traction(s, "top", loads))
    return u.reshape(s.vectors.shape)[np.argmin(np.linalg.norm(x[:, :2] - np.array(sides) / 2, axis=1)), 0, 2]


def navier(D, a, b):
    """S. P. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and Shells, section 85 (specially orthotropic)."""
    m, n = np.meshgrid(np.arange(1, 60, 2), np.arange(1, 60, 2))
    sign = (-1.0) ** ((m + n) // 2 - 1)
    stiff = D[0, 0] * (m / a) ** 4 + 2 * (D[0, 1] + 2 * D[2, 2]) * (m * n / (a * b)) ** 2 + D[1, 1] * (n / b) ** 4
    return 16 / np.pi**6 * (sign / (m * n * stiff)).sum()


@pytest.mark.parametrize(
    "made",
    [
        Laminate([(fc.Material(E=1.0, nu=0.3), 0.01, 0.0)]),
        Laminate([(PLY, 0.01, 0.0)]),
        Laminate([(PLY, 0.01, 90.0)]),
        Laminate([(PLY, 0.0025, 0.0), (PLY, 0.005, 90.0), (PLY, 0.0025, 0.0)]),
    ],
    ids=["isotropic", "along", "across", "crossed"],
)
def test_a_plate_bends_as_navier_has_it(made):
    # Adini's functions do not conform: 1.5 % on ten elements a side at most, four times less on twenty
    assert abs(bent(made) / navier(made.bending, *SIDES) - 1) < 0.016
    assert abs(bent(made, n=(20, 20)) / navier(made.bending, *SIDES) - 1) < 0.004


def test_one_layer_is_a_laminate_of_its_halves():
    halves = Laminate([(PLY, 0.004, 30.0), (PLY, 0.006, 30.0)])
    assert not halves.coupling.any()
    one = Laminate([(PLY, 0.01, 30.0)])
    assert np.abs(halves.bending - one.bending).max() < 1e-15
    assert abs(bent(PLY, thickness=0.01) / bent(Laminate([(PLY, 0.01, 0.0)])) - 1) < 1e-12


def test_a_turned_layer_is_hooke_s_law_in_turned_axes():
    """E of a strip at an angle: 1 / E = c^4 / E1 + (1 / G12 - 2 nu12 / E1) s^2 c^2 + s^4 / E2 (Jones, eq. 2.97)."""
    c, s = np.cos(np.radians(35.0)), np.sin(np.radians(35.0))
    A = Laminate([(PLY, 2.0, 35.0)]).membrane
    exact = c**4 / 25 + (1 / 0.5 - 2 * 0.25 / 25) * s**2 * c**2 + s**4
    assert abs(2 * np.linalg.inv(A)[0, 0] - exact) < 1e-14


def test_layers_that_differ_from_top_to_bottom_bend_what_is_pulled():
    """A strip of two layers, cylindrical: a pull N bends it by k = -b11 N, with b = -(D - B A^-1 B)^-1 B A^-1."""
    two = Laminate([(PLY, 0.05, 0.0), (PLY, 0.05, 90.0)])
    length, N = 1.0, 1e-6
    s = plate([(0, 0, 0), (length, 0, 0), (0, 0.1, 0)], (4, 1), two)
    joints = Joints([s])
    held = [joints.clamped((0, k)) for k in (0, 1)]
    # cylindrical: nothing stretches, turns or bends along y
    held += [joints.guided((0, k), 2) for k in range(10)] + [joints.pinned((0, k), [(0, 1, 0)]) for k in range(10)]
    held += [joints.guided((0, k), 1, [(0, 1, 0)]) for k in range(10)]
    Z = joints.free(held)
    f = np.zeros((s.n_dofs // 3, 3))
    f[[3 * 8, 3 * 9], 0] = N * 0.1 / 2
    u = (Z @ spla.spsolve((Z.T @ s.tangent(s.q0) @ Z).tocsc(), Z.T @ f.ravel())).reshape(s.vectors.shape)
    A, B, D = two.membrane[0, 0], two.coupling[0, 0], two.bending[0, 0]
    k = -B / (D * A - B * B) * N  # of e and k with M = 0
    # w = -k x^2 / 2: a positive k shortens the top
    assert np.abs(u[8:, 0, 2] / (-k * length**2 / 2) - 1).max() < 1e-9
    assert np.abs(u[8:, 0, 0] / (N * length * D / (A * D - B * B)) - 1).max() < 1e-9


def test_coupled_sheets_have_the_derivatives_they_say():
    s = plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (1, 1), Laminate([(PLY, 0.1, 0.0), (PLY, 0.1, 60.0)]))
    q = s.q0 + 0.05 * np.random.default_rng(0).uniform(-1, 1, s.n_dofs)
    K, h = s.tangent(q).toarray(), 1e-6 * np.eye(s.n_dofs)
    assert np.abs(K - np.stack([(s.forces(q + e) - s.forces(q - e)) / 2e-6 for e in h], axis=1)).max() < 1e-7
    assert np.abs(s.forces(q) - [(s.energy(q + e) - s.energy(q - e)) / 2e-6 for e in h]).max() < 1e-8
    turned = (s.q0.reshape(-1, 3) @ fc.rotation_about((1, 2, 3), 1.0).T).ravel()
    assert np.abs(s.forces(turned)).max() < 1e-13


def test_layers_without_sense_are_refused():
    for code, made in (
        ("no-layers", lambda: Laminate([])),
        ("poisson-ratio", lambda: Lamina(E1=1.0, E2=4.0, nu12=0.6, G12=1.0)),
        ("not-positive", lambda: Lamina(E1=1.0, E2=-4.0, nu12=0.1, G12=1.0)),
        ("no-density", lambda: Laminate([(PLY, 0.1, 0.0), (fc.Material(E=1.0, nu=0.3, density=1.0), 0.1, 0.0)])),
        ("thickness", lambda: plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (1, 1), PLY)),
        ("thickness", lambda: plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (1, 1), Laminate([(PLY, 0.1, 0.0)]), 0.2)),
    ):
        with refused(fc.InputError, code):
            made()
    assert Lamina(E1=1.0, E2=4.0, nu12=0.49, G12=1.0).stiffness[0, 0] > 1.0
