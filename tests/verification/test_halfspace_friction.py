"""Half-spaces with friction against closed forms: partial slip, cycles, torsion, stick under load, rolling."""

import math
import time

import numpy as np
import pytest
from depths import product
from references import rolling_creepage

import fecontact as fc
from fecontact.analytic import friction
from fecontact.surfaces import FlatPunch, Paraboloid

PLAIN, STEEL = fc.Material(E=1.0, nu=0.0), fc.Material(E=1.0, nu=0.3)
RADIUS, MU = 100.0, 0.3
BALL = Paraboloid(RADIUS)


def hertz(material, a=1.0):
    """Two equal bodies, of which one is plane, in contact over a circle of radius a."""
    force = 4 * fc.hertz.contact_modulus(material, material) * a**3 / (3 * RADIUS)
    return fc.hertz.spheres((RADIUS, math.inf), (material, material), force=force)


def radius(grid):
    return np.hypot(grid.x[:, None], grid.y[None, :])


def l2(found, exact):
    return float(np.sqrt(((found - exact) ** 2).sum() / (exact**2).sum()))


@pytest.mark.by_day("128-0.008-0.01")
@pytest.mark.parametrize(("n", "most_l2", "most_stick"), [(128, 8e-3, 1e-2), (512, 1.5e-3, 1e-3)])
def test_mindlin(n, most_l2, most_stick, row):
    """A ball dragged by 0.6 of what friction holds, nu = 0, one step.

    Source: Cattaneo 1938, Mindlin 1949; exact for nu = 0. The edges of contact and of stick lie inside cells: first
    order in the tractions, second order in the shift. The time is that of one thread, in seconds.
    """
    exact = friction.mindlin(hertz(PLAIN), MU, tangential=0.6 * MU * hertz(PLAIN).force)
    half = fc.HalfSpace(PLAIN, size=(2.2, 2.2), cells=(n, n), against=PLAIN)
    began = time.process_time()
    found = half.press(BALL, force=exact.force, friction=MU, tangential=(exact.tangential, 0.0))
    seconds = time.process_time() - began
    case = f"ball, nu = 0, {n} x {n} cells"
    row(case, "traction L2", 0.0, l2(found.traction[0], exact.traction(radius(half.grid))), most_l2)
    row(case, "stick radius", exact.c, math.sqrt(found.stick_area / math.pi), most_stick)
    row(case, "shift", exact.shift, found.shift[0], 1e-5)
    row(case, "work of friction", exact.friction_work, found.friction_work, 1e-3)
    row(case, "processor time", 0.6, seconds)
    assert seconds < 45 * product()  # 10 were found
    assert found.residuals.worst < 1e-9


def test_classical_solution_with_poissons_ratio(row):
    """The same at nu = 0.3: by how much the classical solution, whose tractions are all along the force, is off.

    Source: none; the tractions here are certified, the figures are differences from Cattaneo and Mindlin.
    """
    exact = friction.mindlin(hertz(STEEL), MU, tangential=0.6 * MU * hertz(STEEL).force)
    half = fc.HalfSpace(STEEL, size=(2.2, 2.2), cells=(256, 256), against=STEEL)
    found = half.press(BALL, force=exact.force, friction=MU, tangential=(exact.tangential, 0.0))
    case, known = "ball, nu = 0.3, 256 x 256 cells", exact.traction(radius(half.grid))
    difference = np.hypot(found.traction[0] - known, found.traction[1])
    off = math.sqrt((difference**2).sum() / (known**2).sum())
    row(case, "difference of tractions, L2", 0.0, off)
    row(
        case,
        "largest traction across the force over mu p0",
        0.0,
        np.abs(found.traction[1]).max() / MU / exact.contact.p0,
    )
    row(case, "shift", exact.shift, found.shift[0], 1e-3)
    row(case, "stick radius", exact.c, math.sqrt(found.stick_area / math.pi), 5e-3)
    assert 0.02 < off < 0.04
    assert found.residuals.worst < 1e-9


def test_fretting_cycle(row):
    """A ball dragged to and fro between 0.8 of what friction holds, nu = 0.

    Source: Mindlin & Deresiewicz 1953.
    """
    exact = friction.mindlin(hertz(PLAIN), MU, tangential=0.8 * MU * hertz(PLAIN).force)
    half = fc.HalfSpace(PLAIN, size=(2.2, 2.2), cells=(128, 128), against=PLAIN)
    shares = (1.0, 0.0, -1.0, 0.0, 1.0)
    steps = [fc.PressStep(force=exact.force, tangential=(s * exact.tangential, 0.0)) for s in shares]
    path = half.press_path(BALL, steps, friction=MU)
    case = "fretting, 128 x 128 cells"
    row(case, "energy per cycle", exact.cycle_energy, path.friction_work[1:].sum(), 1e-2)
    row(case, "shift at no force, unloading", exact.shift_in_cycle(0.0), path.shift[1, 0], 1e-2)
    row(case, "shift at no force, loading", -exact.shift_in_cycle(0.0), path.shift[3, 0], 1e-2)
    row(case, "shift at the end of the cycle", exact.shift, path.shift[4, 0], 1e-3)


def test_torsion(row):
    """A ball twisted by 0.6 of what friction holds, nu = 0.3.

    Source: Lubkin 1951. First order in the cells, which the tractions cross at all angles.
    """
    ball = hertz(STEEL)
    exact = friction.lubkin(ball, MU, torque=0.6 * 3 * math.pi / 16 * MU * ball.force)
    half = fc.HalfSpace(STEEL, size=(2.2, 2.2), cells=(128, 128), against=STEEL)
    path = half.press_path(BALL, [fc.PressStep(force=ball.force, torque=exact.torque)], friction=MU)
    x, y, r = half.grid.x[:, None], half.grid.y[None, :], radius(half.grid)
    around = exact.traction(r) / r
    case = "torsion, 128 x 128 cells"
    row(case, "rotation", exact.rotation, path.twist[0], 1e-4)
    row(case, "stick radius", exact.c, math.sqrt(path.last.stick_area / math.pi), 1e-2)
    row(case, "traction L2", 0.0, l2(path.last.traction, np.stack([-y * around, x * around])), 1.2e-2)


@pytest.mark.by_day("0.49-0.01")
@pytest.mark.parametrize(("nu", "mu"), [(0.45, 0.05), (0.45, 0.1), (0.49, 0.01)])
def test_stick_under_a_flat_punch(nu, mu, row):
    """A rigid flat punch pressed on a half-space, which spreads below it and sticks in the middle.

    Source: Spence 1975 in Goodman's approximation, which leaves out the effect of shear on the pressure, hence nearly
    incompressible bodies with little friction here, where it is small.
    """
    material = fc.Material(E=1.0, nu=nu)
    half = fc.HalfSpace(material, size=(2.4, 2.4), cells=(128, 128))
    found = half.press(FlatPunch(radius=1.0), force=1.0, friction=mu)
    exact = friction.stick_ratio(mu, friction.dundurs(material))
    row(f"flat punch, nu = {nu}, mu = {mu}", "stick radius", exact, math.sqrt(found.stick_area / found.area), 1e-2)


@pytest.mark.full
def test_stick_is_the_same_for_all_indenters(row):
    """A ball pressed on in steps sticks within the same share of its contact as a flat punch.

    Source: Spence 1968: the same for all indenters whose profile is a power of the radius. The error is that of 16
    steps, of first order.
    """
    half, mu = fc.HalfSpace(STEEL, size=(2.4, 2.4), cells=(48, 48)), 0.15
    flat = half.press(FlatPunch(radius=1.0), force=1.0, friction=mu)
    most = 4 * STEEL.plane_strain_modulus / (3 * RADIUS)
    steps = [fc.PressStep(force=float(most * s**3)) for s in np.linspace(0, 1, 17)[1:]]
    ball = half.press_path(BALL, steps, mu).last
    target = math.sqrt(flat.stick_area / flat.area)
    row("ball in 16 steps, nu = 0.3, mu = 0.15", "stick radius", target, math.sqrt(ball.stick_area / ball.area), 0.05)


class Roller:
    """A cylinder along y of radius `RADIUS`, once in each period."""

    def __init__(self, period):
        self.period = period

    def heights(self, x, y):
        across = (x + self.period / 2) % self.period - self.period / 2
        return across**2 / (2 * RADIUS) + 0 * y


def strip(per_contact, period=32.0):
    """A period of two cells along y, as many cells across a contact of width 2, and the roller's force per length."""
    cells = round(per_contact * period / 2)
    half = fc.HalfSpace(STEEL, (period, 2 * period / cells), (cells, 2), periodic=True, against=STEEL)
    force = math.pi * fc.hertz.contact_modulus(STEEL, STEEL) / (4 * RADIUS)
    return half, fc.hertz.line((RADIUS, math.inf), (STEEL, STEEL), force=force)


def test_cattaneo_in_the_plane(row):
    """A roller dragged across its line of contact by 0.6 of what friction holds, in a period of 16 contact widths.

    Source: Cattaneo 1938; the other periods are felt by (width/period)^2.
    """
    half, line = strip(64)
    width = half.grid.size[1]
    exact = friction.cattaneo(line, MU, tangential=0.6 * MU * line.force)
    found = half.press(Roller(32.0), force=line.force * width, friction=MU, tangential=(exact.tangential * width, 0.0))
    case = "roller, 64 cells across"
    row(case, "traction L2", 0.0, l2(found.traction[0][:, 0], exact.traction(half.grid.x)), 1.5e-2)
    row(case, "half-width of stick", exact.c, found.stick_area / width / 2, 2.5e-2)


@pytest.mark.full
def test_carter(row):
    """A roller that starts to roll under a tangential force, cell by cell, until it rolls steadily.

    Source: Carter 1926. First order in the cells, by which the roller advances: the error is of the mesh, not of the
    transient or the period, for what both meshes are extrapolated to is within 0.3 %. At first it creeps at half the
    rate. The last slip of a cell, while contact leaves it, is not in its work.
    """
    coarse, exact = rolled(16, 0.04, 0.03, row)
    fine, _ = rolled(32, 0.02, 0.02, row)
    row("rolling, 16 and 32 cells across", "creepage, extrapolated", exact, 2 * fine - coarse, 3e-3)


def rolled(n, most_creep, most_l2, row):
    """Creepage at the end of the transient, found and by Carter."""
    half, line = strip(n)
    (cell, _), width = half.grid.cell, half.grid.size[1]
    exact = friction.carter(line, MU, tangential=0.6 * MU * line.force)
    steps = [fc.PressStep(force=line.force * width)]
    steps += [
        fc.PressStep(force=line.force * width, tangential=(exact.tangential * width, 0.0), position=(k * cell, 0.0))
        for k in range(round(4 / cell))
    ]
    path = half.press_path(Roller(32.0), steps, friction=MU)
    creep = np.diff(path.shift[:, 0])[1:] / cell
    ahead = half.grid.x - steps[-1].position[0]
    case = f"rolling, {n} cells across"
    row(case, "creepage", exact.creepage, creep[-1], most_creep)
    row(case, "traction L2", 0.0, l2(path.last.traction[0][:, 0], exact.traction(ahead)), most_l2)
    rate = path.friction_work[-1] / width / cell
    row(case, "work of friction per distance", exact.tangential * exact.creepage, rate, 6 * most_creep)
    assert creep[0] < 0.7 * creep[-1]  # the transient
    return creep[-1], exact.creepage


@pytest.mark.full
def test_a_ball_rolls(row):
    """A ball that starts to roll under a tenth of mu P, cell by cell, over two widths of its contact.

    Source: Kalker's linear theory, of three digits, in the law of Vermeulen and Johnson. First order in the cells; both
    grids are extrapolated to 0.5 %.
    """
    material, share = fc.Material(E=1.0, nu=0.25), 0.1
    load = hertz(material).force
    exact = rolling_creepage(share, load, MU, 1.0, 1 / 2.5, material.nu)
    found = []
    for n in (12, 24):
        cell = 2.0 / n
        half = fc.HalfSpace(material, size=(6.5, 2.5), cells=(round(6.5 / cell), round(2.5 / cell)), against=material)
        way = cell * (np.arange(2 * n + 1) - n)
        steps = [fc.PressStep(force=load, position=(way[0], 0.0))]
        steps += [fc.PressStep(force=load, tangential=(share * MU * load, 0.0), position=(x, 0.0)) for x in way]
        found.append(np.diff(half.press_path(BALL, steps, friction=MU).shift[:, 0])[-1] / cell)
    for n, creepage, most in zip((12, 24), found, (0.11, 0.055), strict=True):
        row(f"ball that rolls, {n} cells across", "creepage", exact, creepage, most)
    row("ball that rolls, 12 and 24 cells across", "creepage, extrapolated", exact, 2 * found[1] - found[0], 0.02)


@pytest.mark.by_day("1")
@pytest.mark.parametrize("seed", range(20))
def test_random_paths_dissipate(seed, row):
    """Five paths of four random steps each: forces, shifts, twists, unlike and equal bodies, mu from 0.1 to 2.

    Source: friction takes energy in every step; every step is certified to 1e-10.
    """
    rng = np.random.default_rng(seed)
    least, worst = math.inf, 0.0
    for _ in range(5):
        mu = float(rng.choice([0.1, 0.3, 0.8, 2.0]))
        against = [None, STEEL, fc.Material(E=5.0, nu=0.1)][rng.integers(3)]
        half = fc.HalfSpace(STEEL, (3.25, 3.25), (15, 15), against=against)
        scale = 4 * half.compliance.modulus / (3 * RADIUS)
        steps = []
        for _ in range(4):
            force, angle = scale * rng.uniform(0.3, 1), rng.uniform(0, 2 * np.pi)
            along = np.array([np.cos(angle), np.sin(angle)])
            twist = 0.01 * mu * rng.normal()
            if rng.random() < 0.5:
                pull = along * mu * force * rng.uniform(0, 0.95)
                steps.append(fc.PressStep(force=force, tangential=(pull[0], pull[1])))
            else:
                shift = along * mu * 0.01 * rng.uniform(0, 2)
                steps.append(fc.PressStep(force=force, shift=(shift[0], shift[1]), twist=twist))
        path = half.press_path(BALL, steps, mu)
        # work of friction of sliding by the approach, as a scale
        scales = np.array([mu * contact.force * contact.approach for contact in path.steps])
        least = min(least, float((path.friction_work / scales).min()))
        worst = max(worst, *(contact.residuals.worst for contact in path.steps))
    row(f"random paths, seed {seed}", "worst residual", 0.0, worst, 1e-9)
    row(f"random paths, seed {seed}", "least work of a step, over mu P approach", 0.0, min(least, 0.0), 1e-10)
    assert worst < 1e-9  # penetration within ten times the tolerance


def test_contacts_example_cattaneo(row):
    """CONTACT's cattaneo, a ball dragged by .875 of what friction holds: all printed digits and cells.

    Source: what it prints, file cattaneo.ref_out of 2023 (github.com/eve70a/CONTACT); work there in thousandths.
    """
    body, limit = fc.Material(E=2 * 200 * 1.42, nu=0.42), 0.4 * 9.195
    half = fc.HalfSpace(body, (19 * 0.4 / 3,) * 2, (19, 19), against=body)
    found = half.press(Paraboloid(50.0), force=9.195, friction=0.4, tangential=(0.875 * limit, 0.0))
    case = "CONTACT's cattaneo, 19 x 19 cells"
    row(case, "approach", 1.998e-2, found.approach, 3e-4)
    row(case, "largest pressure", 4.393, found.max_pressure, 2e-4)
    row(case, "shift", 8.155e-3, found.shift[0], 1e-4)
    row(case, "work of friction", 2.750e-3, found.friction_work, 2e-4)
    assert (int(found.active.sum()), int(found.sticking.sum())) == (177, 45)


@pytest.mark.full
def test_contacts_example_spence35(row):
    """CONTACT's spence35, a rigid ball pressed on in 35 steps with friction: all printed digits, and cells that stick.

    Source: what it prints, file spence35.ref_out of 2023, whose grid is 1e-4 off the ball. Of its 921 cells in contact
    a few at the edge, not symmetric there, have no pressure here.
    """
    soft, stiff = fc.Material(E=1.0, nu=0.0), fc.Material(E=2e5, nu=0.0)
    half = fc.HalfSpace(soft, (9.0, 9.0), (45, 45), against=stiff)
    x, y = half.grid.x[:, None] + 1e-4, half.grid.y + 1e-4
    steps = [fc.PressStep(force=round((k / 45) ** 3, 6)) for k in range(1, 36)]
    path = half.press_path(0.004116 * (x**2 + y**2), steps, 0.2986)
    for k, approach, peak in ((10, 8.064e-3, 6.707e-3), (35, 9.874e-2, 2.392e-2)):
        row(f"CONTACT's spence35, step {k}", "approach", approach, path[k - 1].approach, 1e-4)
        row(f"CONTACT's spence35, step {k}", "largest pressure", peak, path[k - 1].max_pressure, 3e-4)
    assert int(path.last.sticking.sum()) == 225
    assert 917 <= int(path.last.active.sum()) <= 921
