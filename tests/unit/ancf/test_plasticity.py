"""Elasto-plastic bricks and lines: cyclic bar, Hill's tube, bent beam, indentation, tangents, balance of energy."""

import numpy as np
import pytest
from differences import off_differences
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    FollowerPressure,
    GeneralisedAlpha,
    Plastic,
    Stage,
    Viscosity,
    equilibrium,
    force_at,
    move,
    traction,
)
from fecontact.ancf.bricks.hexahedron import gauss
from fecontact.ancf.picture import save_motion
from fecontact.ancf.slender import Joints, line, straight

E, Y = 200.0, 1.0


def cube(plastic, volumetric="linear", held=None, **given):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), plastic, points=3, volumetric=volumetric, **given)
    return Assembly.of([solid], [held or {"x_min": "x", "x_max": "x", "y_min": "y", "bottom": "z"}])


def bar(plastic, stretches, steps, volumetric="linear"):
    """States of a cube stretched along x through these stretches, at equal levels, and its nominal stresses."""
    a = cube(plastic, volumetric)
    space, levels = a.solids[0].space, np.linspace(0.0, 1.0, len(stretches))
    along = a.held(space.affine(np.diag([1.0, 0.0, 0.0])))
    path = equilibrium(lambda s: Stage(a, motion=np.interp(s, levels, stretches) * along), steps=steps)
    assert path.success
    pull = np.zeros((space.n_functions, 3))
    pull[::4, 0] = space.q0.reshape(-1, 3)[::4, 0] > 0.5
    return path, np.array([pull.ravel() @ state.reactions for state in path])


@pytest.mark.parametrize(("K", "H"), [(10.0, 0.0), (0.0, 10.0), (4.0, 6.0)])
def test_a_cyclic_bar_is_exact(K, H):
    """Elastic ranges of 2 (Y + K a) about H p between branches of slope E_t, in the measure E = (s^2 - 1)/2."""
    turns = [0.0, 0.02, -0.03]
    path, nominal = bar(Plastic(fc.Material(E, 0.3), Y, K, H), turns, 2)
    strain = [((1 + u) ** 2 - 1) / 2 for u in turns]
    plastic = (strain[1] - Y / E) * E / (E + K + H)
    first = E * (strain[1] - plastic)
    # turned round it flows at the stress H p - (Y + K p)
    again = (H * plastic - (Y + K * plastic) - first) / E + strain[1]
    last = (H - K) * plastic - Y + (strain[2] - again) * E * (K + H) / (E + K + H)
    assert np.abs(nominal / [1.02, 0.97] - [first, last]).max() < 1e-9
    solid = path.last.assembly.solids[0]
    accumulated = plastic + (again - strain[2]) * E / (E + K + H)
    assert np.abs(solid.plastic_strain - accumulated).max() < 1e-9
    assert abs(solid.dissipated - Y * accumulated) < 1e-9
    # at the end, Hooke's and the hardening's energies
    back = plastic - (accumulated - plastic)
    assert abs(path.last.energy - (last**2 / E + K * accumulated**2 + H * back**2) / 2) < 1e-9
    assert path.warnings == path.last.assembly.warnings
    assert len(path.warnings) == (accumulated > 0.05)
    assert all(text in str(path) for text in path.warnings)


def test_moderate_strains_are_not_warned_of_and_large_ones_are():
    path, _ = bar(Plastic(fc.Material(E, 0.3), Y), [0.0, 0.045], 1)
    assert path.warnings == ()
    path, _ = bar(Plastic(fc.Material(E, 0.3), Y), [0.0, 0.06], 1)
    assert "0.057" in path.warnings[0]
    path, _ = bar(Plastic(fc.Material(E, 0.3), Y), [0.0, 0.045], 1, None)
    assert [("lock" in text) for text in path.warnings] == [True]
    path, _ = bar(Plastic(fc.Material(E, 0.3), Y), [0.0, 0.004], 1, None)
    assert path.warnings == ()


@pytest.mark.parametrize("scheme", [EnergyMomentum(), GeneralisedAlpha()], ids=["energy", "alpha"])
def test_what_is_at_rest_stays_and_springs_back_when_let_go(scheme):
    a = cube(Plastic(fc.Material(E, 0.3, density=1.0), Y, 5.0), held={"x_min": "x", "y_min": "y", "bottom": "z"})
    pull = traction(a.solids[0].space, "x_max", (1.1, 0.0, 0.0))
    still = equilibrium(lambda s: Stage(a, s * pull), steps=1).last
    motion = move(a, until=0.02, step=0.01, start=still, forces=pull, scheme=scheme)
    assert np.abs(motion.now.q - still.q).max() < 1e-9
    assert motion.strain[0] == still.energy
    let_go = move(a, until=0.02, step=0.01, start=still, scheme=scheme)
    assert np.abs(let_go.now.q - still.q).max() > 1e-3


@pytest.mark.parametrize("volumetric", [None, 2, "linear"])
def test_forces_and_tangent_are_derivatives_of_the_energy_of_a_step(volumetric):
    rng = np.random.default_rng(0)
    solid = cube(Plastic(fc.Material(E, 0.3), Y, 5.0, 3.0), volumetric).solids[0]
    before = solid.q0 + 0.01 * rng.standard_normal(solid.n_dofs)
    solid = solid.remembering(solid.relaxed(before))
    q, d = before + 0.004 * rng.standard_normal(solid.n_dofs), rng.standard_normal(solid.n_dofs)
    flowed = solid.remembering(solid.relaxed(q))
    assert (flowed.plastic_strain > solid.plastic_strain).mean() > 0.5  # where derivatives are of interest
    work, turn = off_differences(solid, q, d)
    assert work < 1e-7
    assert turn < 1e-6  # on the edge of flow the tangent jumps: no point lies there
    assert abs(solid.tangent(q) - solid.tangent(q).T).max() < 1e-12 * abs(solid.tangent(q)).max()
    assert np.abs(flowed.forces(q) - solid.forces(q)).max() < 1e-12 * np.abs(solid.forces(q)).max()
    assert abs(solid.forces_between(before, q) @ (q - before) - solid.energy(q) + solid.energy(before)) < 1e-13
    turn = fc.rotation_about((1, 2, 3), 1.1)
    turned = (q.reshape(-1, 3) @ turn.T).ravel()
    assert np.abs(solid.relaxed(turned) - solid.relaxed(q)).max() < 1e-14


def test_a_thick_tube_under_pressure_is_hills():
    """Plane strain, incompressible: p = 2 k (ln c/a + (1 - c^2/b^2)/2), k = Y/sqrt 3, u = k c^2 / (2 G r).

    R. Hill, The Mathematical Theory of Plasticity, 1950, chapter V, with von Mises' condition.
    """
    inner, outer, edge, nu, stiff = 1.0, 2.0, 1.5, 0.499, 1e5
    k, G = Y / np.sqrt(3), stiff / (2 * (1 + nu))
    p = 2 * k * (np.log(edge / inner) + (1 - edge**2 / outer**2) / 2)

    def quarter(x):
        r = inner + x[:, 0]
        return np.stack([r * np.cos(x[:, 2]), x[:, 1], r * np.sin(x[:, 2])], axis=1)

    mesh = fc.shapes.block((outer - inner, 0.2, np.pi / 2), (6, 1, 4), element="hex20").mapped(quarter)
    tube = AncfSolid(AncfSpace(mesh), Plastic(fc.Material(stiff, nu), Y), points=3, volumetric="linear")
    a = Assembly.of([tube], [{"bottom": "z", "top": "x", "y_min": "y", "y_max": "y"}])
    path = equilibrium(lambda s: Stage(a, follow=[FollowerPressure(0, "x_min", s * p)]), steps=2)
    assert path.success
    solid, q = path.last.assembly.solids[0], path.last.q
    r = np.array([1.001, 1.25, 1.5, 1.75, 1.998])
    cells, X = tube.space.located(np.stack([r * np.cos(0.3), 0 * r + 0.1, r * np.sin(0.3)], axis=1))
    n = np.array([np.cos(0.3), 0.0, np.sin(0.3)])
    moved = (tube.space.points_at(q, cells, X) - tube.space.points_at(tube.q0, cells, X)) @ n
    assert np.abs(moved * 2 * G * r / (k * edge**2) - 1).max() < 3e-3  # 1 - 2 nu, of the elastic volume
    s = solid.cauchy_at(q, cells, X)
    radial = s[:, 0] * n[0] ** 2 + s[:, 2] * n[2] ** 2 + 2 * s[:, 5] * n[0] * n[2]
    exact = np.where(r < edge, 2 * k * np.log(r / inner) - p, k * edge**2 * (1 / outer**2 - 1 / r**2))
    assert np.abs(radial - exact).max() < 0.01 * p
    points, n_cells = gauss(3)[0], len(mesh.cells)
    places = tube.space.points_at(tube.q0, np.repeat(np.arange(n_cells), 27), np.tile(points, (n_cells, 1)))
    radius, flowed = np.hypot(places[:, 0], places[:, 2]), solid.plastic_strain.ravel() > 0
    # to the distance of Gauss points
    assert edge - 0.04 < radius[flowed].max() < edge < radius[~flowed].min() + 0.01
    with refused(fc.InputError, "memory"):
        tube.cauchy_at(q, cells, X)


@pytest.mark.parametrize(("share", "accuracy"), [(0.6, 1e-8), (0.9, 4e-3), (0.99, 8e-3)])
def test_a_cantilever_bends_as_its_layers_flow(share, accuracy):
    """Tip over that at first yield: (5 - (3 + f) sqrt(3 - 2 f)) / f^2, f the force over that at first yield.

    S. P. Timoshenko, Strength of Materials II, section 65 (rectangle); it collapses at 1.5 and 20/9.
    """
    L, stiff = 10.0, 2e5
    rod = line(straight((0, 0, 0), (L, 0, 0), 16), EA=stiff, EI=stiff / 12, plastic=Plastic(fc.Material(stiff, 0.3), Y))
    joints = Joints([rod])
    a = Assembly([rod], [joints.flat(), joints.clamped((0, 0))])
    f, first = 1.5 * share, Y / 6 / L
    tip = force_at(rod, (L, 0, 0), (0, -f * first, 0))
    path = equilibrium(lambda s: Stage(a, s * tip), steps=2)
    found = -rod.positions(path.last.q)[-1, 1] / (first * L**3 / (stiff / 4))
    exact = f if f <= 1 else (5 - (3 + f) * np.sqrt(3 - 2 * f)) / f**2
    assert abs(found / exact - 1) < accuracy
    # let go, what has flowed stays bent by the difference to the elastic answer
    back = equilibrium(lambda s: Stage(a, (1 - s) * tip), steps=1, start=path.last)
    left = -rod.positions(back.last.q)[-1, 1] / (first * L**3 / (stiff / 4))
    assert abs(left - (found - f)) < 1e-6
    assert (back.last.assembly.solids[0].plastic_strain.max() > 0) == (f > 1)


@pytest.mark.parametrize("bricks", [False, True], ids=["line", "bricks"])
def test_a_beam_on_three_points_collapses_at_its_plastic_moment(bricks):
    """P L / 4 = Y b h^2 / 4; half of it. A wide one would bear up to 2/sqrt 3 of it, as its width resists the hinge."""
    half, stiff, hard = 5.0, 2e4, 1e-4
    p = Plastic(fc.Material(stiff, 0.0), Y, hardening=hard * stiff)
    if bricks:
        mesh = fc.shapes.block((half, 0.2, 1.0), (8, 1, 2), element="hex8")
        solid = AncfSolid(AncfSpace(mesh), p, points=3, volumetric="linear")
        a = Assembly.of([solid], [{"x_min": "x", "y_min": "y", "x_max": "z"}])
        load = traction(solid.space, "x_min", (0.0, 0.0, -1.0))
    else:
        rod = line(straight((0, 0, 0), (half, 0, 0), 8), EA=stiff, EI=stiff / 12, plastic=p)
        joints = Joints([rod])
        a, load = Assembly([rod], [joints.flat(), joints.clamped((0, 0))]), force_at(rod, (half, 0, 0), (0, -1.0, 0))
    limit = Y / 4 / half
    before, after = (equilibrium(lambda s, x=x: Stage(a, s * x * limit * load), steps=6) for x in (0.9, 1.1))
    sizes = [np.abs(path.last.q - a.q0).max() if path.success else np.inf for path in (before, after)]
    assert sizes[0] < 3 * (limit * half**3 / (stiff / 4))
    assert sizes[1] > 10 * sizes[0]


@pytest.mark.parametrize("scheme", [EnergyMomentum(), GeneralisedAlpha(1.0)], ids=["energy", "alpha"])
def test_a_blow_is_accounted_for(scheme, tmp_path):
    p = Plastic(fc.Material(E, 0.3, density=1.0), Y, 5.0, 3.0)
    a = cube(p, held={"x_min": "xyz"}, viscosity=Viscosity(1e-4))
    blow = a.solids[0].space.affine(np.diag([0.4, 0.0, 0.0]))
    run = {"step": 0.01, "scheme": scheme, "velocity": blow, "every": 4}
    motion = move(a, until=0.08, **run)
    assert motion.success
    assert motion.drift < (1e-8 if isinstance(scheme, EnergyMomentum) else 0.02)  # it does not conserve
    assert motion.viscous_work[-1] > 0.2 * motion.energy[0]
    assert (np.diff(motion.viscous_work) > -1e-12).all()
    half = move(a, until=0.04, path=tmp_path / "run.npz", **run)
    assert np.abs(move(a, until=0.08, path=tmp_path / "run.npz", **run).now.q - motion.now.q).max() < 1e-9
    if isinstance(scheme, GeneralisedAlpha):
        return  # which begins with the accelerations of its start
    onwards = move(a, until=0.08, start=half.now, step=0.01, scheme=scheme)
    assert np.abs(onwards.now.q - motion.now.q).max() < 1e-9


def test_a_line_keeps_its_energy():
    rod = line(
        straight((0, 0, 0), (1, 0, 0), 4), EA=200.0, EI=1.0, mass=1.0, plastic=Plastic(fc.Material(200.0, 0.3), Y, 20.0)
    )
    joints = Joints([rod])
    a = Assembly([rod], [joints.flat(), joints.clamped((0, 0))])
    speed = np.zeros(rod.vectors.shape)
    speed[-1, 0, 1] = 1.0
    motion = move(a, until=0.2, step=0.01, velocity=speed.ravel(), scheme=EnergyMomentum())
    assert motion.success
    assert motion.viscous_work[-1] > 0.05 * motion.energy[0]
    # three points of a step do not see where within it layers begin to flow
    assert motion.drift < 1e-3


def test_a_ball_leaves_a_dent(tmp_path):
    """A bonded layer: as deep as an elastic one at first, then deeper, and a dent stays; memory goes with states."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (3, 3, 1), element="hex8")
    plastic = Plastic(fc.Material(E, 0.3), Y, hardening=2.0)
    forces, dents = [], []
    for material in (fc.Material(E, 0.3), plastic):
        layer = AncfSolid(AncfSpace(mesh), material, points=3, volumetric="linear")
        ball = fc.RigidBody(fc.Sphere(2.0))
        held = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
        a = Assembly.of([layer], [held], [fc.Contact(layer.side("top"), ball.placed((0, 0, 0.5)))])
        depth = lambda s: np.interp(s, [0.0, 0.5, 1.0], [0.0, 0.03, -0.01])  # noqa: E731
        path = equilibrium(lambda s: Stage(a.with_rigid(ball.placed((0, 0, 0.5 - depth(s))))), steps=4)  # noqa: B023
        assert path.success
        forces.append([-float(state.contacts[0].force[2]) for state in path])
        cells, X = layer.space.located([(0.0, 0.0, 0.5)])
        dents.append(0.5 - layer.space.points_at(path.last.q, cells, X)[0, 2])
    assert forces[1][1] < 0.7 * forces[0][1]
    assert abs(dents[0]) < 1e-12
    assert 0.3 * 0.03 < dents[1] < 0.03
    assert path.last.assembly.solids[0].plastic_strain_at(cells, X)[0] > 0.01
    save_motion(a, path, tmp_path / "dent.pvd", [state.level for state in path])
    with refused(fc.InputError, "memory"):
        save_motion(a, [state.q for state in path], tmp_path / "dent.pvd", [state.level for state in path])


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"material": 200.0}, ("wrong-class",)),
        ({"yield_stress": 0.0}, ("not-positive",)),
        ({"hardening": -1.0}, ("hardening", "-1.0")),
        ({"kinematic": np.nan}, ("hardening", "nan")),
    ],
)
def test_refused(given, match):
    with refused(fc.InputError, *match):
        Plastic(**({"material": fc.Material(E, 0.3), "yield_stress": Y} | given))


def test_plastic_materials_are_refused_where_nothing_flows():
    p = Plastic(fc.Material(E, 0.3), Y)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    for body in (fc.ElasticBody, fc.AncfBody):
        with refused(fc.InputError, "input", "Plastic"):
            body(mesh, p, contact="top", supports={"bottom": "xyz"})
    with pytest.warns(DeprecationWarning, match="Viscoelastic"), refused(fc.InputError, "prony-series"):
        cube(p, viscosity=Viscosity(prony=[(0.5, 1.0)]))
    with refused(fc.InputError, "in-space"):
        line(straight((0, 0, 0), (1, 0, 1), 2), EA=1.0, EI=1.0, plastic=p)
    with refused(fc.InputError, "measure"):
        line(straight((0, 0, 0), (1, 0, 0), 2), EA=1.0, EI=1.0, plastic=p, measure="geometric")
    elastic = cube(fc.Material(E, 0.3))
    with refused(fc.InputError, "memory"):
        elastic.remembering(np.zeros(3))
