"""Steady rolling of half-spaces against closed forms, tables and finer grids: Carter, Kalker, CONTACT, random cases."""

import math

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

import fecontact as fc
from fecontact.surfaces import Paraboloid

G, NU, MU = 82000.0, 0.28, 0.3
STEEL = fc.Material(E=2 * G * (1 + NU), nu=NU)


def roller(n, creepage, offset):
    """Force over the limit of friction, Carter's, and the error of the tractions, of a long roller n cells across."""
    a, R, length = 1.0, 500.0, 4000.0
    modulus = fc.hertz.contact_modulus(STEEL, STEEL)
    side, force = 2 * a / n, math.pi * modulus * a**2 / (4 * R) * length / 2
    half = fc.HalfSpace(STEEL, ((n + 4) * side, length), (n + 4, 4), against=STEEL)
    x = half.grid.x + offset * side
    z = np.full(half.grid.shape, np.inf)
    z[:, 1:3] = (x**2 / (2 * R))[:, None]  # two cells, each as long as a quarter of the grid
    found = half.roll(z, force=force, friction=MU, creepage=(creepage, 0.0))
    sticks = a - creepage * R / MU
    parts = x[:, None] + side * (np.arange(16) - 7.5) / 16
    p0 = modulus * a / (2 * R)
    inner = sticks / a * np.sqrt(np.maximum(0, 1 - ((parts - a + sticks) / sticks) ** 2))
    exact = MU * p0 * (np.sqrt(np.maximum(0, 1 - (parts / a) ** 2)) - inner).mean(axis=1)
    error = np.linalg.norm(found.traction[0][:, 1] - exact) / np.linalg.norm(exact)
    return found.tangential[0] / (MU * force), 1 - (sticks / a) ** 2, error


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("creepage", [1e-4, 2.4e-4])
def test_carter(creepage, offset, row):
    """A roller at 50 cells across, with edges anywhere in their cells: its force to 2e-4 of the limit of friction.

    Source: Carter 1926; Johnson, Contact Mechanics, section 8.3. The tractions are of first order in the cells.
    """
    case, errors = f"creepage {creepage:g}, edge {offset:g} cells off", {}
    for n in (25, 50, 100):
        force, exact, errors[n] = roller(n, creepage, offset)
        if n == 50:
            row(case, "force over the limit", exact, force)
            assert abs(force - exact) < 2e-4
    row(
        f"creepage {creepage:g}, edge {offset:g} cells off",
        "order of the tractions",
        1.0,
        math.log2(errors[25] / errors[100]) / 2,
    )
    assert errors[100] < 0.6 * errors[25] or errors[25] < 0.01


#: C11, C22, C23 by a/b, each for nu = 0, 1/4, 1/2: Kalker 1990, table E3, as in CONTACT's source (m_hertz, 2023).
KALKER = {
    0.1: ((2.51, 3.31, 4.85), (2.51, 2.52, 2.53), (0.334, 0.473, 0.731)),
    0.2: ((2.59, 3.37, 4.81), (2.59, 2.63, 2.66), (0.483, 0.603, 0.809)),
    0.5: ((2.88, 3.62, 4.83), (2.88, 3.01, 3.14), (0.827, 0.929, 1.07)),
    1.0: ((3.40, 4.12, 5.20), (3.40, 3.67, 3.98), (1.33, 1.47, 1.63)),
    2.0: ((4.37, 5.10, 6.11), (4.37, 4.90, 5.56), (2.35, 2.62, 2.96)),
    5.0: ((6.96, 7.78, 8.82), (6.96, 8.14, 9.79), (5.72, 6.63, 7.89)),
    10.0: ((10.7, 11.7, 12.9), (10.7, 12.8, 16.0), (12.2, 14.6, 18.0)),
}

#: C33 likewise: Kalker's table, as in public programs of vehicle dynamics.
KALKER_C33 = {
    0.1: (6.42, 8.28, 11.7), 0.2: (3.46, 4.27, 5.66), 0.5: (1.74, 1.93, 2.22), 1.0: (1.21, 1.19, 1.16),
    2.0: (0.958, 0.819, 0.650), 5.0: (0.828, 0.601, 0.341), 10.0: (0.795, 0.526, 0.228),
}  # fmt: skip


def ellipse(a, b):
    """Paraboloid whose contact at a peak of E* is an ellipse of semi-axes a and b (Johnson 1985, 4.2)."""
    if a == b:
        return Paraboloid(2 * a / math.pi)
    large, small = max(a, b), min(a, b)
    e2 = 1 - (small / large) ** 2
    K, E = ellipk(e2), ellipe(e2)
    A, B = small / (e2 * large**2) * (K - E), small / (e2 * large**2) * ((large / small) ** 2 * E - K)
    radii = (1 / (2 * A), 1 / (2 * B))
    return Paraboloid(*(radii if a > b else radii[::-1]))


@pytest.mark.by_day("0-1.0", "1-1.0", "2-0.1")
@pytest.mark.parametrize("ratio", KALKER)
@pytest.mark.parametrize("k", [0, 1, 2])
def test_kalkers_coefficients(ratio, k, row):
    """Within 1 % of Kalker's table at 64 cells, at 128 for ellipses along the rolling, 1.3 % at a/b = 10.

    At a/b = 10 and nu = 1/4 C22 on 128 x 32, 256 x 64 and 512 x 128 cells is 12.93, 12.95, 12.96 by this rule and
    13.01, 13.00, 12.99 by CONTACT's, from both sides: near 12.97, where the table has 12.8.
    """
    found = coefficients(ratio, k, (128, 128) if ratio > 1 else (64, 64))
    for name, values in zip(("c11", "c22", "c23"), KALKER[ratio], strict=True):
        row(f"a/b = {ratio:g}, nu = {(0.0, 0.25, 0.5)[k]:.2g}", name.upper(), values[k], getattr(found, name))
        assert getattr(found, name) == pytest.approx(values[k], rel=0.01 if ratio < 10 else 0.013)


@pytest.mark.full
@pytest.mark.parametrize("ratio", KALKER)
@pytest.mark.parametrize("k", [0, 1, 2])
def test_kalkers_c33(ratio, k, row):
    """Within 1 % of Kalker's table; at a/b = 10, where it is small, within its estimated error.

    There on 512 x 128 cells it is .5254 at nu = 1/4 for the table's .526; CONTACT's rule has .601, falling.
    """
    found, value = coefficients(ratio, k, (256, 64) if ratio > 2 else (128, 128)), KALKER_C33[ratio][k]
    row(f"a/b = {ratio:g}, nu = {(0.0, 0.25, 0.5)[k]:.2g}", "C33", value, found.c33)
    assert found.c33 == pytest.approx(value, rel=0.01 if ratio < 10 else max(0.01, found.errors[3]))


def coefficients(ratio, k, cells):
    """Kalker's coefficients of an ellipse for nu = 0, 1/4 or 1/2."""
    a, b = math.sqrt(ratio), 1 / math.sqrt(ratio)
    material = fc.Material(E=1.0, nu=(0.0, 0.25, 0.4999)[k])
    half = fc.HalfSpace(material, (2.24 * a, 2.24 * b), cells, against=material)
    return half.creep_coefficients(ellipse(a, b), force=2 / 3 * math.pi * half.contact_modulus)


def test_contacts_example_by_the_blended_rule(row):
    """Its example fastsim, whose own figure by cells is .6074: the limit lies within the estimate at 44 cells."""
    half = fc.HalfSpace(STEEL, (17.6, 8.8), (44, 44), against=STEEL)
    surface = Paraboloid(1 / (2 * 0.8464e-3), 1 / (2 * 0.2406e-2))
    found = half.roll(surface, force=82000.0, friction=0.3, creepage=(0.0, -6.25e-4), spin=6.25e-4)
    share, error = found.tangential[1] / 24600.0, found.rolling_error.force / 24600.0
    row("CONTACT's fastsim, 44 x 44 cells", "lateral force over the limit", 0.625, share)
    assert share - error < 0.624
    assert share + error > 0.624
    assert error < 0.01


def test_contacts_example_carter2d(row):
    """Its example carter2d, a roller in the plane, by its rule to all printed digits and cells; Carter has .64."""
    force, n, side = 35780.0, 55, 0.04
    half = fc.HalfSpace(STEEL, (n * side, 800.0), (n, 4), against=STEEL)
    z = np.full((n, 4), np.inf)
    z[:, 1] = 1e-3 * (half.grid.x + 0.03) ** 2  # one cell of 200 across
    options = {"force": force, "friction": MU, "creepage": (2.4e-4, 0.0)}
    found = half.roll(z, rule="contact", **options)
    case = "CONTACT's carter2d"
    row(case, "force over the limit", 0.6480, found.tangential[0] / MU / force, 1e-4)
    row(case, "power", 47.62, found.friction_work * 30, 2e-4)
    row(case, "approach", 6.492e-3, found.approach, 1e-4)
    row(case, "largest pressure", 113.9, found.max_pressure, 4e-4)
    assert (int(found.active.sum()), int(found.sticking.sum())) == (50, 30)
    ours = half.roll(z, **options)
    row("the same by the blended rule", "force over the limit", 0.64, ours.tangential[0] / MU / force, 1e-3)


#: As in its file catt_to_cart.ref_out of 2025: shift, cells that stick; creepages of the first ten cells, the last one.
ONSET = (1.774e-2, 305), (1.824e-3, 1.882e-3, 1.955e-3, 2.050e-3, 2.140e-3, 2.221e-3, 2.334e-3, 2.428e-3, 2.551e-3)
STEADY = 3.101e-3


def test_contacts_example_from_cattaneo_to_carter(row):
    """Its example catt_to_cart to all printed digits: a ball is dragged, then rolls cell by cell, then steadily."""
    ball, force, mu = Paraboloid(1 / (2 * 0.002963)), 0.4705, 0.4013
    pull, body = (0.657 * mu * force, 0.0), fc.Material(E=2 * (1 + NU), nu=NU)
    half = fc.HalfSpace(body, (44 * 0.25, 33 * 0.25), (44, 33), against=body)
    where = -1.125 + 0.25 * np.r_[0, np.arange(10)]  # the middle of a cell
    path = half.press_path(ball, [fc.PressStep(force=force, tangential=pull, position=(x, 0.0)) for x in where], mu)
    (shift, sticking), creepages = ONSET
    row("CONTACT's catt_to_cart", "shift of the drag", shift, path.shift[0, 0], 3e-4)
    row(
        "CONTACT's catt_to_cart",
        "creepage of the first cell",
        creepages[0],
        np.diff(path.shift[1:3, 0])[0] / 0.25,
        4e-4,
    )
    assert path.shift[0, 0] == pytest.approx(shift, abs=6e-6)
    assert int(path[1].sticking.sum()) == sticking
    assert int(path[2].sticking.sum()) == 422
    np.testing.assert_allclose(np.diff(path.shift[1:, 0]) / 0.25, creepages, atol=6e-7)
    steady = fc.HalfSpace(body, (33 * 0.25, 33 * 0.25), (33, 33), against=body).roll(
        ball, force=force, friction=mu, tangential=pull, rule="contact"
    )
    row("CONTACT's catt_to_cart", "steady creepage", STEADY, steady.creepage[0], 3e-4)
    assert steady.creepage[0] == pytest.approx(STEADY, abs=6e-7)
    assert int(steady.sticking.sum()) == 346


def random_case(seed):
    """A half-space size, materials, surface and options of rolling."""
    rng = np.random.default_rng(seed)
    nu = rng.uniform(0, 0.5)
    like = rng.random() < 0.6
    one = fc.Material(E=1.0, nu=nu)
    two = one if like else fc.Material(E=rng.uniform(0.5, 2), nu=rng.uniform(0, 0.5))
    mu, root = rng.uniform(0.1, 0.6), 10 ** rng.uniform(-0.25, 0.25)
    surface, force = Paraboloid(root, 1 / root), 1e-4
    probe = fc.HalfSpace(one, (1.0, 1.0), (64, 64), against=two).press(surface, force=force)
    size = [1.25 / 64 * int(probe.active.any(axis=1 - k).sum()) for k in (0, 1)]
    full = mu * probe.max_pressure * probe.approach * math.sqrt(size[0] * size[1]) / 1.25 / force
    creepage, tangential = [full * rng.uniform(-1, 1), full * rng.uniform(-1, 1)], [None, None]
    spin = full / math.sqrt(size[0] * size[1]) * rng.uniform(-3, 3) * (rng.random() < 0.7)
    kind, angle, held = rng.integers(4), rng.uniform(0, 2 * np.pi), mu * force * rng.uniform(0, 0.9)
    for axis, part in ((0, math.cos(angle)), (1, math.sin(angle))):
        if kind == 3 or kind == axis + 1:
            creepage[axis], tangential[axis] = None, held * part
    options = {"creepage": tuple(creepage), "tangential": tuple(tangential), "spin": spin * (0.3 if kind == 3 else 1)}
    return tuple(size), (one, two), surface, {"force": force, "friction": mu, **options}


@pytest.mark.full
@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
def test_random_cases_of_forces_near_sliding(share):
    """Like and unlike ellipses under forces of any direction up to .99 of sliding: certified, and they creep on."""
    for seed in range(15):
        size, materials, surface, options = random_case(seed)
        angle, limit = 2.4 * seed, options["friction"] * options["force"]
        pull = share * limit * np.array([math.cos(angle), math.sin(angle)])
        body = fc.HalfSpace(materials[0], [1.2 * side for side in size], (32, 32), against=materials[1])
        found = body.roll(surface, force=options["force"], friction=options["friction"], tangential=tuple(pull))
        assert found.residuals.within(1e-8)
        assert np.hypot(*np.subtract(found.tangential, pull)) < 1e-8 * limit
        assert np.dot(found.creepage, pull) > 0


@pytest.mark.full
def test_order_in_three_dimensions(row):
    """With spin sums are of first order in the cells; where the grid lies under the contact moves them less and less.

    CONTACT's example fastsim with lateral creepage and spin: lateral force and torque over the limit.
    """
    found = {n: placed(n) for n in (22, 44, 88)}
    first, second = found[44][0] - found[22][0], found[88][0] - found[44][0]
    row("fastsim, 22, 44 and 88 cells", "order of the torque", 1.0, math.log2(first[1] / second[1]), 0.3)
    assert (second > 0).all()
    assert (second < 6e-3).all()
    assert (found[88][1] < 0.4 * found[22][1]).all()


def placed(n):
    """Mean and standard deviation (2,) over places of a grid of n cells of lateral force and torque of fastsim."""
    sums, limit = [], MU * 82000.0
    for offset in np.random.default_rng(n).uniform(size=(6, 2)):
        cell = np.array([17.6, 8.8]) / n
        half = fc.HalfSpace(STEEL, tuple((n + 2) * cell), (n + 2, n + 2), against=STEEL)
        x, y = -offset * cell  # of the contact's middle, about which it spins
        z = 0.8464e-3 * (half.grid.x[:, None] - x) ** 2 + 0.2406e-2 * (half.grid.y - y) ** 2
        spin = 6.25e-4
        at = half.roll(z, force=82000.0, friction=MU, creepage=(spin * y, -6.25e-4 - spin * x), spin=spin)
        fx, fy = at.tangential
        sums.append([fy / limit, (at.torque - x * fy + y * fx) / limit / 4])
    return np.mean(sums, axis=0), np.std(sums, axis=0)


@pytest.mark.full
def test_forty_random_cases_and_their_errors(row):
    """Certified to 1e-8, tractions' errors estimated .8 to 3 times as large as against a grid four times as fine.

    The errors of sums cancel by chance, to a hundredth of what they mostly are: some estimates are far above them.
    """
    found = []
    for seed in range(40):
        size, materials, surface, options = random_case(seed)
        one, fine = (
            fc.HalfSpace(materials[0], size, (n, n), against=materials[1]).roll(surface, **options) for n in (32, 128)
        )
        assert one.residuals.within(1e-8)
        assert fine.residuals.within(1e-8)
        q = fine.traction.reshape(2, 32, 4, 32, 4).mean(axis=(2, 4))
        true = np.linalg.norm(one.traction - q) / np.linalg.norm(q)
        off = [np.hypot(*np.subtract(one.tangential, fine.tangential)), abs(one.torque - fine.torque)]
        off.append(np.hypot(*np.subtract(one.creepage, fine.creepage)))
        error = one.rolling_error
        rounding = 1e-6 * np.array([1.0, size[0], 1e3]) * options["force"] * options["friction"]
        sums = np.array([error.force, error.torque, error.creepage]) + rounding
        found.append([error.traction / true, *(sums / (off + rounding))])
    ratios = np.array(found)
    row("40 random cases", "share of estimates .8 to 3 times the error", 1.0, np.mean(np.abs(ratios[:, 0] - 1.9) < 1.1))
    row("40 random cases", "least estimate over the error, of sums", 1.0, ratios[:, 1:].min())
    for name, of in zip(("force", "torque", "creepage"), ratios[:, 1:].T, strict=True):
        prescribed = of == 1.0  # rounding over rounding
        middle = float(np.median(of[~prescribed]))
        row("40 random cases", f"median estimate over the error of the {name}", 2.0, middle)
        assert 0.8 < middle < 4
    assert np.mean((ratios[:, 0] > 0.8) & (ratios[:, 0] < 3)) >= 0.9
    assert ratios.min() > 0.5
