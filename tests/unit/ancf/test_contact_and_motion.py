"""Contact of bricks, equilibrium and motion: gradients by differences, balances, supports, restarts, bad input."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    GeneralisedAlpha,
    Stage,
    equilibrium,
    move,
    save_motion,
    traction,
)
from fecontact.ancf.bricks.faces import multiplier_rule
from fecontact.ancf.system.newton import ContactRows, stable_step
from fecontact.ancf.system.tangent import Tangent, UnstableError

SOFT = fc.Material(E=1.0, nu=0.3, density=1.0)
FLOOR = fc.RigidBody(fc.Plane())


def brick(divisions=(2, 2, 1), size=(1.0, 1.0, 0.5), at=(0.0, 0.0, 0.0), material=SOFT):
    mesh = fc.shapes.block(size, divisions, element="hex8").translated(at)
    return AncfSolid(AncfSpace(mesh), material)


def shaken(assembly, amount, seed=0):
    return assembly.q0 + amount * np.random.default_rng(seed).standard_normal(assembly.n_dofs)


def test_hats_are_positive_and_add_up_to_one():
    points, weights, multipliers = multiplier_rule()
    assert (multipliers >= -1e-15).all()
    assert np.abs(multipliers.sum(axis=1) - 1).max() < 1e-14
    assert abs(weights.sum() - 1) < 1e-14
    # the hats interpolate linear functions
    places = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5]])
    assert np.abs(multipliers @ places - points).max() < 1e-14


def test_areas_of_hats_cover_the_faces():
    solid = brick()
    faces = solid.side("bottom")
    assert abs(faces.quadrature[2].sum() - 1) < 1e-13
    assert (faces.quadrature[2] > 0).all()


def test_faces_as_patches_are_those_of_the_element():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 2, 2)).mapped(lambda x: x + 0.05 * np.sin(3 * x[:, ::-1]))
    space, rng = AncfSpace(mesh), np.random.default_rng(0)
    faces = AncfSolid(space, fc.Material(E=1.0, nu=0.3)).side("top")
    q = space.q0 + 0.1 * rng.standard_normal(space.n_dofs)
    each, local = rng.integers(0, 6, 50), rng.random((50, 2))
    S, dS = space.face_functions(faces.faces[each], local)
    e = space.spread(q)[space.functions[faces.faces[each, 0]]]
    x, tangents = faces.at(q, each, local)
    assert np.abs(x - np.einsum("na,nai->ni", S, e)).max() < 1e-13
    assert np.abs(tangents - np.einsum("nax,nai->nix", dS, e)).max() < 1e-12


def test_feet_on_curved_faces_are_found_from_points_along_their_normals():
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (4, 4, 1)).mapped(lambda x: x + 0.03 * np.sin(3 * x[:, ::-1]))
    space, rng = AncfSpace(mesh), np.random.default_rng(1)
    faces = AncfSolid(space, fc.Material(E=1.0, nu=0.3)).side("top")
    q = space.q0 + 0.002 * rng.standard_normal(space.n_dofs)
    each, local, height = rng.integers(0, 16, 200), 0.05 + 0.9 * rng.random((200, 2)), 0.02 * rng.random(200)
    x, tangents = faces.at(q, each, local)
    normals = np.cross(tangents[..., 0], tangents[..., 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = faces.project(q, x + height[:, None] * normals)
    assert (found.facet == each).all()
    assert np.abs(found.local - local).max() < 1e-11  # a step of 1e-13 on faces a quarter wide, curved little
    assert np.abs(found.gap - height).max() < 1e-14
    assert not found.outside.any()


@pytest.mark.parametrize(
    "obstacle",
    [
        fc.RigidBody(fc.Sphere(3.0)).placed((0.5, 0.4, 0.52)),
        fc.RigidBody(fc.surfaces.Cylinder(2.0)).placed((0.5, 0.4, 0.52)),
    ],
    ids=["sphere", "cylinder"],
)
def test_gap_gradient_and_curvature_by_differences(obstacle):
    solid = brick()
    a = Assembly.of([solid], None, [fc.Contact(solid.side("top"), obstacle)])
    q, h = shaken(a, 1e-2), 1e-5
    d, forces = shaken(a, 1.0, 1) - a.q0, np.random.default_rng(2).random(a.n_multipliers)
    at, ahead, behind = (a.conditions(x) for x in (q, q + h * d, q - h * d))
    # central differences err by h^2 = 1e-10 times third derivatives, and by rounding 1e-16 / h
    assert np.abs((ahead.gap - behind.gap) / (2 * h) - at.G @ d).max() < 1e-8
    bend = (ahead.G - behind.G).T @ forces / (2 * h)
    assert np.abs(bend - a.curvature(at, forces) @ d).max() < 1e-6 * np.abs(bend).max()


def test_gap_gradient_between_bricks_by_differences():
    # the slave lies well inside the master, so that no point crosses the rim in a difference
    upper, lower = brick((2, 2, 1), (0.6, 0.6, 0.3), (0.2, 0.17, 0.52)), brick()
    a = Assembly.of([upper, lower], None, [fc.Contact(upper.side("bottom"), lower.side("top"))])
    q, h = shaken(a, 2e-3), 1e-5
    d = shaken(a, 1.0, 1) - a.q0
    at, ahead, behind = (a.conditions(x) for x in (q, q + h * d, q - h * d))
    assert np.abs((ahead.gap - behind.gap) / (2 * h) - at.G @ d).max() < 1e-6
    # forces are equal and opposite, and collinear: no resultant force or moment on both bodies together
    forces = np.random.default_rng(2).random(len(at.gap))
    for direction in np.eye(3):
        assert abs(a.translation(direction) @ (at.G.T @ forces)) < 1e-12
        spin = np.cross(direction, np.eye(3)).T
        turned = np.concatenate([(a.part(q, k).reshape(-1, 3) @ spin.T).ravel() for k in range(2)])
        assert abs(turned @ (at.G.T @ forces)) < 1e-10


@pytest.mark.parametrize("law", [fc.StVenantKirchhoff, fc.NeoHookean])
@pytest.mark.parametrize("volumetric", [None, "linear"])
def test_conserving_forces_do_the_work_of_the_energy_and_keep_momenta(law, volumetric):
    solid = replace(brick(material=law(SOFT.E, SOFT.nu, SOFT.density)), volumetric=volumetric)
    rng = np.random.default_rng(0)
    q0, q1 = (solid.space.q0 + 0.03 * rng.standard_normal(solid.space.n_dofs) for _ in range(2))
    f = solid.forces_between(q0, q1)
    work = solid.energy(q1) - solid.energy(q0)
    assert abs(f @ (q1 - q0) - work) < 1e-12 * max(solid.energy(q0), solid.energy(q1))
    for direction in np.eye(3):
        assert abs(solid.space.affine(np.zeros((3, 3)), direction) @ f) < 1e-13
        spin = np.cross(direction, np.eye(3)).T
        assert abs(((q0 + q1).reshape(-1, 3) @ spin.T).ravel() @ f) < 1e-12
    # between a state and itself they are the elastic forces
    assert np.abs(solid.forces_between(q0, q0) - solid.forces(q0)).max() < 1e-12


def test_newton_step_refuses_an_unstable_tangent():
    with pytest.raises(UnstableError):
        stable_step(
            Tangent(sp.csr_matrix(np.diag([1.0, -1.0]))),
            np.ones(2),
            ContactRows.frictionless(np.zeros(0), sp.csr_matrix((0, 2))),
        )


@pytest.mark.parametrize("negative", [0.5, 50.0, 5000.0])
def test_what_a_contact_holds_may_be_unstable_without_it(negative):
    """A gap of 0.5 is closed against a negative stiffness: the force is that and the load, however negative it is."""
    K, G = sp.csr_matrix(np.diag([1.0, -negative])), sp.csr_matrix(np.array([[0.0, 1.0]]))
    rows = ContactRows.frictionless(np.array([0.5]), G, guess=np.ones(1))
    change, forces, _ = stable_step(Tangent(K), np.array([1.0, -8.0]), rows)
    np.testing.assert_allclose(change, [1.0, -0.5], atol=1e-12)
    np.testing.assert_allclose(forces, [8.0 + 0.5 * negative], rtol=1e-9)


def test_what_floats_with_nothing_near_is_refused_and_what_touches_is_not():
    K, along = sp.csr_matrix([[1.0, -1.0], [-1.0, 1.0]]), np.array([[0.5**0.5], [0.5**0.5]])
    nothing = ContactRows.frictionless(np.zeros(0), sp.csr_matrix((0, 2)))
    with pytest.raises(UnstableError, match="Nothing near resists"):
        stable_step(Tangent(K), np.array([0.0, -1.0]), nothing, along)
    floor = ContactRows.frictionless(np.array([0.5]), sp.csr_matrix([[1.0, 0.0]]))
    change, forces, _ = stable_step(Tangent(K), np.array([0.0, -1.0]), floor, along)
    np.testing.assert_allclose(change, [-0.5, -1.5], atol=1e-12)  # a bar on the floor, shorter by its load
    np.testing.assert_allclose(forces, [1.0], atol=1e-12)


def test_a_ball_is_pressed_far_into_a_brick_that_its_contact_keeps_from_buckling():
    """By a quarter of its height; steps stopped at 0.19, where rows weighed too little. The energy is its work."""
    mesh, ball = fc.shapes.block((1.3, 0.74, 1.0), (1, 1, 1), element="hex8"), fc.RigidBody(fc.Sphere(2.0))
    solid = AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=1.0, nu=0.0), points=3)
    a = Assembly.of([solid], [{"bottom": "xyz"}], [fc.Contact(solid.side("top"), ball)])
    path = equilibrium(lambda s: Stage(a.with_rigid(ball.placed((0.65, 0.37, 1 - 0.25 * s)))), steps=16)
    assert path.success
    assert not any(path.cuts)
    force = [0.0, *(float(s.reactions @ a.translation(np.array([0.0, 0.0, 1.0]))) for s in path.steps)]
    depth = 0.25 * np.array([0.0, *(s.level for s in path.steps)])
    work = float(((np.array(force)[1:] + force[:-1]) / 2 * np.diff(depth)).sum())
    assert abs(work / path.last.energy - 1) < 5e-3  # trapezoidal rule


@pytest.mark.parametrize("depth", [-1e-6, 1e-6, 2e-3])
def test_a_ball_between_the_quadrature_points_of_a_face_is_named(depth):
    """Source: geometry; the mean gaps are open, and nothing presses."""
    ball = fc.RigidBody(fc.Sphere(0.5)).placed((0.45, 0.36, 0.5 - depth))
    solid = brick((1, 1, 1))
    a = Assembly.of([solid], [{"bottom": "xyz"}], [fc.Contact(solid.side("top"), ball)])
    path = equilibrium(lambda _: Stage(a), steps=1)
    assert not path.last.forces[0].any()
    assert path.last.overlaps == pytest.approx((max(0.0, depth),), abs=1e-12)
    assert ("its sides overlap" in str(path)) == (depth > 0)


@pytest.mark.parametrize("depth", [-1e-6, 2e-3])
def test_a_motion_names_what_overlaps_and_never_presses(depth, tmp_path):
    """Source: geometry; a ball beside a brick that rests, between the quadrature points of its face."""
    ball = fc.RigidBody(fc.Sphere(0.5)).placed((0.45, 0.36, 0.5 - depth))
    solid = brick((1, 1, 1))
    a = Assembly.of([solid], [{"bottom": "xyz"}], [fc.Contact(solid.side("top"), ball)])
    for until in (0.2, 0.3):  # the second one reads the first one's record
        motion = move(a, until=until, step=0.1, path=tmp_path / "record.npz")
    assert not motion.contact_force.any()
    assert motion.overlaps == pytest.approx(np.full((4, 1), max(0.0, depth)), abs=1e-12)
    assert ("Contact 0 never carries" in str(motion)) == (depth > 0)


@pytest.mark.parametrize("law", [fc.StVenantKirchhoff, fc.NeoHookean])
def test_uniform_compression_against_a_plane_is_exact(law):
    # patch test at large strain, nu = 0: a column shortened by a fifth has the same pressure on every hat
    solid = brick(material=law(E=1.0, nu=0.0), at=(0.0, 0.0, 0.0))
    a = Assembly.of([solid], [{"top": "xyz"}], [fc.Contact(solid.side("bottom"), FLOOR)])
    path = equilibrium(lambda s: Stage(a.with_rigid(FLOOR.placed((0, 0, 0.1 * s)))), steps=2)
    stretch = 0.8
    law_stress = law(E=1.0, nu=0.0).cauchy(np.diag([1.0, 1.0, stretch]))[2, 2]
    pressure = path.last.forces[0] / a.constraints[0].areas
    assert path.success
    assert np.abs(pressure / -law_stress - 1).max() < 1e-9  # ten times Newton's tolerance
    # the supports carry what the floor pushes
    lift = a.translation(np.array([0.0, 0.0, 1.0]))
    assert abs(path.last.reactions @ lift + path.last.forces[0].sum()) < 1e-9
    assert path.last.residuals.equilibrium < 1e-9


def test_brick_on_brick_with_other_meshes_passes_the_patch_test():
    # meshes 2 x 2 on 3 x 3, nu = 0, uniform compression: hats and quadrature points straddle the master's faces
    upper = brick((2, 2, 1), at=(0.0, 0.0, 0.5), material=fc.Material(E=1.0, nu=0.0))
    lower = brick((3, 3, 1), material=fc.Material(E=1.0, nu=0.0))
    contact = fc.Contact(upper.side("bottom"), lower.side("top"))
    a = Assembly.of([upper, lower], [{"top": "xyz"}, {"bottom": "xyz"}], [contact])
    drop = np.zeros(a.n_dofs)
    top = upper.space.mesh.points[upper.space.nodes][:, 2] > 1 - 1e-9
    drop.reshape(-1, 3)[upper.space.start[top], 2] = -0.02
    path = equilibrium(lambda s: Stage(a, motion=s * drop), steps=1)
    pressure = path.last.forces[0] / a.constraints[0].areas
    # shape functions have kinks across the master's sides, the rule on the slave does not see them: 1e-3
    strain = -0.02 + 0.02**2 / 2
    assert np.abs(pressure / np.mean(pressure) - 1).max() < 5e-2
    assert abs(pressure.mean() / (-strain * 0.98) - 1) < 2e-2


def test_statics_needs_supports_and_says_which_solid_lacks_them():
    solid = brick()
    a = Assembly.of([solid], [{"top": "z"}], [fc.Contact(solid.side("bottom"), FLOOR)])
    with refused(fc.InputError, "free-rigid-motion", "Solid 1", "in 3"):
        equilibrium(lambda s: Stage(a))


def test_a_load_that_cannot_be_reached_ends_with_the_last_good_state():
    # St. Venant-Kirchhoff softens in compression until it is unstable: no equilibrium beyond
    a = Assembly.of([brick(material=fc.Material(E=1.0, nu=0.0))], [{"bottom": "xyz", "x_min": "x", "y_min": "y"}])
    load = traction(a.solids[0].space, "top", (0.0, 0.0, -1.0))
    path = equilibrium(lambda s: Stage(a, forces=s * load), steps=4)
    assert not path.success
    assert "last good state is kept" in path.message
    assert path.steps[-1].residuals.equilibrium < 1e-9
    # uniform shortening carries -E s (s^2 - 1) / 2, at most 0.19245 E at s = 1/sqrt(3); other modes give way before
    assert 0.15 < path.last.level < 0.19245


@pytest.mark.parametrize("angle", [0.01, 1e-4])
def test_forces_that_are_rounding_count_as_balanced(angle):
    """A slender bar bent a little: its forces are so small beside stiffness times coordinates that rounding of the
    coordinates is more than a billionth of them. No number of iterations or smaller steps would help."""
    length, thickness = 10.0, 0.1
    size, corner = (length, thickness, thickness), (0.0, -thickness / 2, -thickness / 2)
    solid = brick((12, 1, 1), size, corner, material=fc.Material(E=1e4, nu=0.0))
    a = Assembly.of([solid], [{"x_min": "xyz", "x_max": "xyz"}])
    space = solid.space
    end = np.flatnonzero(space.mesh.points[space.nodes][:, 0] > length - 1e-9)
    held = (space.start[end][:, None] + [0, 2, 3]).ravel()
    centre = np.array([length * np.sin(angle) / angle, 0.0, length * (1 - np.cos(angle)) / angle])
    turn = fc.rotation_about((0, 1, 0), -angle)
    motion = np.zeros((space.n_functions, 3))
    motion[held] = (space.affine(turn, centre - turn @ [length, 0, 0]) - a.q0).reshape(-1, 3)[held]
    path = equilibrium(lambda s: Stage(a, motion=s * motion.ravel()), steps=1)
    assert path.success
    assert not any(path.cuts)
    assert path.last.nit <= 8
    # Euler, E I angle^2 / (2 L); the ends are placed for an axis that is a circle, as it is to order angle^2
    exact = 1e4 * thickness**4 / 12 * angle**2 / (2 * length)
    assert abs(path.last.energy / exact - 1) < 1e-4


def test_free_fall_is_exact_and_touches_nothing():
    solid = brick(at=(0, 0, 5.0))
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), FLOOR)])
    for scheme in (GeneralisedAlpha(0.9), EnergyMomentum()):
        motion = move(a, until=0.5, step=0.05, scheme=scheme, velocity=(1.0, 0, 0), gravity=(0, 0, -10.0))
        fallen = a.q0 + a.translation(np.array([0.5, 0, -10 * 0.5**2 / 2]))
        assert np.abs(motion.now.q - fallen).max() < 1e-10  # both are exact for constant acceleration
        assert not motion.contact_force.any()
        assert motion.drift < 1e-12


def test_unstrained_flight_is_not_disturbed_by_rounding():
    """A neo-Hookean brick in free fall: rounded energies over vanishing strains must not become stresses."""
    turn = fc.rotation_about((0, 1, 0), 0.35)
    mesh = fc.shapes.block((1.0, 0.5, 0.5), (2, 1, 1), element="hex8").mapped(lambda x: x @ turn.T + [0.0, 0.0, 3.0])
    a = Assembly.of([AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=400.0, nu=0.3, density=1.0), points=3)])
    motion = move(a, until=0.2, step=0.02, scheme=EnergyMomentum(), velocity=(2.0, 0, 0), gravity=(0, 0, -10.0))
    assert motion.success
    assert motion.nit.max() <= 3
    exact = a.q0 + a.translation(np.array([0.4, 0.0, -0.2]))
    assert np.abs(motion.now.q - exact).max() < 1e-9


def dropped_flat(unit=1.0, on_brick=False):
    """Motion of one brick, dropped flat on a plane or on a brick that is held below, with another unit of length."""
    material = fc.Material(E=500.0 / unit, nu=0.3, density=unit**-3)
    size = (unit, unit, unit / 2)
    upper = brick((1, 1, 1), size, (0, 0, 0.05 * unit), material=material)
    a = Assembly.of([upper], None, [fc.Contact(upper.side("bottom"), FLOOR)])
    if on_brick:
        lower = brick((1, 1, 1), size, (0, 0, -unit / 2), material=material)
        a = Assembly.of([upper, lower], [{}, {"bottom": "xyz"}], [fc.Contact(upper.side("bottom"), lower.side("top"))])
    speed, gravity = np.zeros(a.n_dofs), np.zeros(a.n_dofs)
    down = upper.space.affine(np.zeros((3, 3)), np.array([0, 0, -unit]))
    speed[: len(down)], gravity[: len(down)] = down, 10 * upper.mass @ down
    # twice the way down and back on the plane, once on the softer brick
    return a, move(a, until=0.24, step=0.01, scheme=EnergyMomentum(), velocity=speed, forces=gravity)


@pytest.mark.by_day("plane")
@pytest.mark.parametrize("on_brick", [False, True], ids=["plane", "brick"])
def test_one_brick_dropped_flat_bounces_and_keeps_its_energy(on_brick):
    """The whole contact face comes to rest at once, so that its motion in a step is nothing but rounding."""
    _, motion = dropped_flat(on_brick=on_brick)
    assert motion.success
    assert np.abs(np.diff(motion.time) - 0.01).max() < 1e-9  # no step was halved
    pressed = motion.contact_force[:, 0, 2] > 0
    assert pressed.any()
    assert not pressed[-1]
    assert motion.drift < 1e-8
    assert motion.penetration.max() < 0.02  # the way in one step
    if not on_brick:
        assert motion.momentum[:, 2].max() > 0.5
        assert np.abs(motion.momentum[:, :2]).max() < 1e-9


@pytest.mark.full
def test_motion_does_not_depend_on_the_unit_of_length():
    (a, metres), (_, microns) = dropped_flat(), dropped_flat(unit=1e6)
    scaled = microns.now.q / np.where(a.lengths == 1, 1e6, 1.0)
    assert np.abs(scaled - metres.now.q).max() < 1e-8  # iterations stop at 1e-9 of the motion of each of 24 steps


def test_interrupted_motion_goes_on_where_it_stopped(tmp_path):
    solid = brick(at=(0, 0, 0.01))
    a = Assembly.of([solid], None, [fc.Contact(solid.side("bottom"), FLOOR)])
    chosen = {"step": 0.02, "scheme": EnergyMomentum(), "velocity": (0, 0, -0.2), "every": 3}
    whole = move(a, until=0.24, **chosen)
    part = move(a, until=0.12, path=tmp_path / "run.npz", **chosen)
    rest = move(a, until=0.24, path=tmp_path / "run.npz", **chosen)
    assert len(part.time) == 7
    assert np.abs(rest.time - whole.time).max() < 1e-14
    # the file holds the state to the last digit
    assert np.abs(rest.now.q - whole.now.q).max() < 1e-13
    assert np.abs(rest.energy - whole.energy).max() < 1e-13


def test_series_for_paraview(tmp_path):
    a = Assembly.of([brick()])
    motion = move(a, until=0.2, step=0.1, velocity=(0, 0, 1.0), every=1)
    file = save_motion(a, motion.frames, tmp_path / "fall.pvd", motion.frame_times)
    parts = sorted(tmp_path.glob("*.vtu"))
    assert len(parts) == 3
    assert all(p.name in file.read_text() for p in parts)
    last = meshio.read(parts[-1])
    assert np.abs(last.point_data["displacement"] - [0, 0, 0.2]).max() < 1e-12
    assert np.abs(last.point_data["von_mises"]).max() < 1e-12
    with refused(fc.InputError, "not-pvd", "'fall.vtu'"):
        save_motion(a, motion.frames, tmp_path / "fall.vtu", motion.frame_times)


def test_a_file_of_something_else_is_refused_and_kept(written):
    a = Assembly.of([brick()])
    file = written("notes", "run.npz")
    with refused(fc.InputError, "no-record"):
        move(a, until=1.0, step=0.1, path=file)
    assert file.read_text() == "notes"


@pytest.mark.full
def test_adaptive_steps_follow_the_accuracy():
    a = Assembly.of([brick()], [{"bottom": "xyz"}])
    start = a.translation(np.array([0.1, 0.0, 0.0]))
    counts = [
        len(move(a, until=1.0, step=0.2, velocity=start, accuracy=accuracy).time) for accuracy in (1e-3, 1e-4, 1e-5)
    ]
    assert counts[0] < counts[1] < counts[2]


@pytest.mark.parametrize(
    ("wrong", "match"),
    [
        ({"step": 0.0}, ("not-positive", "step")),
        ({"accuracy": -1.0}, ("not-positive", "accuracy")),
        ({"every": 0}, ("every-below-one", "0")),
        ({"velocity": (1.0, np.nan, 0.0)}, ("input", "velocity must be")),
        ({"forces": np.zeros(3)}, ("force-shape",)),
    ],
)
def test_bad_input_of_a_motion(wrong, match):
    with refused(fc.InputError, *match):
        move(Assembly.of([brick()]), **{"until": 1.0, "step": 0.1, **wrong})


def test_bad_contacts_are_refused():
    solid = brick()
    for solids, how in (([brick()], "not"), ([solid, solid], "twice")):
        with refused(fc.InputError, "not-in-assembly", f"is {how} in the assembly"):
            Assembly.of(solids, None, [fc.Contact(solid.side("bottom"), FLOOR)])
    with refused(fc.InputError, "contact-with-itself"):
        fc.Contact(solid.side("bottom"), solid.side("top"))
    with refused(fc.InputError, "unknown-boundary", "'lid'"):
        solid.side("lid")
    for sides in ((FLOOR, solid.side("top")), (solid.side("top"), solid), (solid.side("top"), "floor")):
        with refused(fc.InputError, "contact-sides"):
            fc.Contact(*sides)
    for option in ({"surfaces": ("top", "surface")}, {"coupling": "mortar"}, {"friction_axis": np.eye(3)[0]}):
        with refused(fc.InputError, "input", f"{next(iter(option))}: for bodies of scenes"):
            fc.Contact(solid.side("top"), FLOOR, **option)
    for mu in (-0.1, np.nan):
        with refused(fc.InputError, "friction"):
            fc.Contact(solid.side("top"), FLOOR, friction=mu)
    with refused(fc.InputError, "contact-of-members", "AncfBody"):
        fc.Scene([FLOOR], [fc.Contact(solid.side("top"), FLOOR)])
    for given in ((0, "bottom", FLOOR), 5):
        with refused(fc.InputError, "wrong-class", "solid.side('top')"):
            Assembly.of([solid], None, [given])
    with refused(fc.InputError, "contact-of-bodies", "solid.side"):
        Assembly.of([solid], None, [fc.Contact(fc.RigidBody(fc.Sphere(1.0)), FLOOR)])
    with refused(fc.InputError, "input", "supports must be given"):
        Assembly.of([solid], [{}, {}])
    with refused(fc.InputError, "rho-range", "1.5"):
        GeneralisedAlpha(1.5)


def test_contact_with_a_curved_tool_keeps_the_band():
    """The second derivative B of the gaps lies in the pattern of the tangent, and Z^T (K - B) Z in its band."""
    mesh = fc.shapes.block((3.0, 1.0, 1.0), (3, 1, 1), element="hex8").translated((0.0, -0.5, -1.0))
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.3), points=3)
    ball = fc.RigidBody(fc.Sphere(2.0)).placed((2.0, 0.0, -0.1))
    a = Assembly.of([solid], [{"x_min": "xyz"}], [fc.Contact(solid.side("top"), ball)])
    K, conditions = a.tangent(a.q0), a.conditions(a.q0)
    B = a.curvature(conditions, np.ones(len(conditions.gap)))
    found = a.constants.reduced(a.constants.minus(K, B))
    assert found.order is not None
    assert abs(B).max() > 1e-3
    assert abs(found.K - a.free.T @ (K - B) @ a.free).max() < 1e-14 * abs(K).max()
    elsewhere = sp.csr_matrix(([1.0], ([0], [a.n_dofs - 1])), shape=K.shape)  # no cell has both
    found = a.constants.reduced(a.constants.minus(K, elsewhere))
    assert found.order is None
    assert abs(found.K - a.free.T @ (K - elsewhere) @ a.free).max() < 1e-14 * abs(K).max()


@pytest.mark.by_day("ball-conserving")
@pytest.mark.parametrize("scheme", [GeneralisedAlpha(0.8), EnergyMomentum()], ids=["alpha", "conserving"])
@pytest.mark.parametrize("other", ["ball", "brick"])
def test_nothing_flies_through_another_body_in_a_long_step(scheme, other):
    # a step of two thicknesses, then of half of one: shorter where they meet, not before
    hard = fc.Material(E=1e3, nu=0.3, density=1.0)
    thrown = brick((1, 1, 1), material=hard)
    if other == "ball":
        ball = fc.RigidBody(fc.Sphere(0.5)).placed((0.5, 0.5, -2.1))
        a = Assembly.of([thrown], None, [fc.Contact(thrown.side("bottom"), ball)])
    else:
        lower = brick((1, 1, 1), at=(0.0, 0.0, -1.6), material=hard)
        a = Assembly.of([thrown, lower], None, [fc.Contact(thrown.side("bottom"), lower.side("top"))])
    speed = np.zeros((a.n_dofs // 3, 3))
    speed[: thrown.space.n_functions : 4, 2] = -1.0
    for step in (1.0, 0.25):
        motion = move(a, until=3.0, step=step, scheme=scheme, velocity=speed.ravel())
        assert motion.success
        assert np.abs(motion.contact_force).max() > 0.5
        height = motion.now.q.reshape(-1, 3)[::4, 2]  # positions, then gradients
        below = -1.1 if other == "ball" else height[len(height) // 2 :].max()
        assert height[: thrown.space.n_functions // 4].min() > below - 0.1
        assert np.diff(motion.time)[0] == step


def test_a_long_step_along_a_body_is_not_cut():
    upper, lower = brick((1, 1, 1)), brick((1, 1, 1), (9.0, 1.0, 0.5), (-4.0, 0.0, -0.51))
    a = Assembly.of([upper, lower], None, [fc.Contact(upper.side("bottom"), lower.side("top"))])
    speed = np.zeros((a.n_dofs // 3, 3))
    speed[: a.n_dofs // 6 : 4, 0] = 1.0
    motion = move(a, until=3.0, step=1.0, velocity=speed.ravel())
    assert np.diff(motion.time).tolist() == [1.0, 1.0, 1.0]
