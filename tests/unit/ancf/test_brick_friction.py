"""Friction of bricks: slip and its gradient, Coulomb's law in every state, no slip by common motions."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Stage, equilibrium
from fecontact.ancf.system.slip import initial_friction, slips

MU = 0.3
FLOOR = fc.RigidBody(fc.Plane(), name="floor")


def brick(divisions=(3, 3, 1), size=(1.0, 1.0, 0.5), at=(0.0, 0.0, 0.0)):
    mesh = fc.shapes.block(size, divisions, element="hex8").translated(at)
    return AncfSolid(AncfSpace(mesh), fc.Material(E=1e3, nu=0.3, density=1.0), points=3)


def dragged(solid, other=FLOOR, mu=MU):
    return Assembly.of([solid], [{"top": "xyz"}], [fc.Contact(solid.side("bottom"), other, friction=mu)])


def moved(a, by, rotation=None, point=(0.5, 0.5, 0.5)):
    """Motion of the supported coordinates: a turn about a point, then a translation."""
    R = np.eye(3) if rotation is None else rotation
    space = a.solids[0].space
    motion = space.affine(R, np.asarray(point) - R @ np.asarray(point) + np.asarray(by)) - a.q0
    return motion - a.free @ (a.free.T @ motion)


@pytest.mark.parametrize(
    ("other", "at"),
    [
        (FLOOR, (0.0, 0.0, 0.01)),
        (fc.RigidBody(fc.Sphere(0.7)).placed((0.5, 0.5, -0.71)), (0.0, 0.0, 0.0)),
        (None, (0.0, 0.0, 0.5)),
    ],
    ids=["plane", "ball", "brick"],
)
def test_slip_and_its_gradient_by_differences(other, at):
    solids = [brick((1, 1, 1), at=at)]
    if other is None:
        solids.append(brick((2, 1, 1)))
        other = solids[1].side("top")
    a = Assembly.of(solids, None, [fc.Contact(solids[0].side("bottom"), other, friction=MU)])
    rng = np.random.default_rng(1)
    q = a.q0 + 1e-3 * rng.standard_normal(a.n_dofs)
    start, step = initial_friction(a.constraints, q).start, rng.standard_normal(a.n_dofs)
    # slip since q itself is zero, so that the turn of the tangents has no part in the derivative there
    now = slips(a.constraints, a.conditions(q).parts, q, start)
    ahead, behind = (
        slips(a.constraints, a.conditions(x).parts, x, start).slip for x in (q + 1e-5 * step, q - 1e-5 * step)
    )
    assert np.abs(now.slip).max() < 1e-15
    found, known = (ahead - behind) / 2e-5, now.T @ step
    assert np.abs(found - known).max() < 1e-6 * np.abs(known).max()


def test_small_drags_are_those_of_a_linear_scene():
    """The same brick mesh at strains of 1e-4: pressed, dragged into partial slip, and back."""
    eps, solid = 1e-4, brick()
    a = dragged(solid)
    body = fc.AncfBody(solid.space.mesh, solid.material, "bottom", {"top": "xyz"}, name="body")
    drags = [(0.0, -0.5 * eps), (0.1 * eps, -0.5 * eps), (0.4 * eps, -0.5 * eps), (0.0, -0.5 * eps)]
    scene = fc.Scene([body, FLOOR], [fc.Contact(body, FLOOR, friction=MU)])
    linear = scene.solve_path([{"motions": {body: {"x": x, "z": z}}} for x, z in drags])
    last, slipped = None, []
    for (x, z), known in zip(drags, linear.steps, strict=True):
        path = equilibrium(lambda level, by=(x, 0, z): Stage(a, motion=moved(a, by)), steps=1, start=last)
        last = path.last
        assert path.success
        assert last.residuals.slip < 1e-10
        normal, tangential = last.forces[0].sum(), last.friction.forces[0].sum(axis=0)
        # strains of 1e-4, and contact pressures of another rule in faces that are partly open
        assert normal == pytest.approx(-known.reaction(body)[2], rel=2e-3)
        assert tangential[:2] == pytest.approx(-known.reaction(body)[:2], abs=1e-3 * normal)
        slipped.append(last.friction.friction_work)
    assert min(slipped) >= 0
    assert sum(slipped[1:]) == pytest.approx(linear.friction_work[1:].sum(), rel=0.05)


def test_large_drags_slide_with_exactly_mu_times_the_normal_force():
    """A neo-Hookean block dragged by half its height: everything slides, and back again."""
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=1e3, nu=0.3), points=3)
    a = dragged(solid)
    pressed = equilibrium(lambda level: Stage(a, motion=moved(a, (0, 0, -0.05 * level))), steps=1)
    path = equilibrium(lambda level: Stage(a, motion=moved(a, (0.4 * level, 0, -0.05))), steps=4, start=pressed.last)
    assert path.success
    end, normal = path.last.friction, path.last.forces[0]
    assert (normal > 0).any()
    size = np.linalg.norm(end.forces[0], axis=1)
    assert np.abs(size - MU * normal).max() < 1e-9 * normal.max()
    # across the drag the block grows a little wider or narrower
    assert -end.forces[0].sum(axis=0)[0] == pytest.approx(MU * normal.sum(), rel=1e-6)
    assert all(s.friction.friction_work >= 0 for s in path.steps)
    assert max(s.residuals.slip for s in path.steps) < 1e-9
    # the last of the work of the support goes into friction: force times distance, less what the strain energy took
    force = [-s.friction.forces[0].sum(axis=0)[0] for s in path.steps[-2:]]
    assert path.last.friction.friction_work == pytest.approx(force[1] * 0.1, rel=0.15)
    # a state that is on the rim of all its cones is in balance with its load and does not go on sliding
    again = equilibrium(lambda level: Stage(a, motion=moved(a, (0.4, 0, -0.05))), steps=3, start=path.last)
    assert len(again.steps) == 1


@pytest.mark.parametrize("mu", [0.3, np.inf])
def test_a_common_turn_is_no_slip(mu):
    """Block and floor are turned together by 1.2 rad in two steps: forces turn with them, and nothing slips."""
    a = dragged(brick((2, 2, 1)), mu=mu)
    path = equilibrium(lambda level: Stage(a, motion=moved(a, (0.01 * level, 0, -0.02))), steps=1)
    before = path.last
    middle = np.array([0.5, 0.5, 0.5])
    for k in (1, 2):
        R = fc.rotation_about((1, 2, 3), 0.6 * k)
        floor = FLOOR.placed(tuple(middle - R @ middle), R)
        by = R @ [0.01, 0, -0.02]
        stage = Stage(a.with_rigid(floor), motion=moved(a, by, R))
        path = equilibrium(lambda level, at=stage: at, steps=1, start=path.last)
        assert path.success
    after, size = path.last, before.forces[0].max()
    assert np.abs(after.friction.slip[0]).max() < 1e-9 * 0.01
    assert np.abs(after.forces[0] - before.forces[0]).max() < 1e-8 * size
    assert np.abs(after.friction.forces[0] - before.friction.forces[0] @ R.T).max() < 1e-8 * size


def test_bad_friction_is_refused():
    for wrong in (-0.1, np.nan, "much"):
        with refused(fc.InputError, "friction", "zero or positive"):
            dragged(brick((1, 1, 1)), mu=wrong)


def test_brick_on_brick_drags_it_along_with_mu_times_the_force():
    """Upper brick dragged over a lower one of another mesh: friction is equal and opposite, and mu times the force."""
    lower, upper = brick((3, 2, 1), size=(2.0, 1.4, 0.5), at=(-0.3, -0.2, -0.5)), brick((2, 2, 1))
    contact = fc.Contact(upper.side("bottom"), lower.side("top"), friction=MU)
    a = Assembly.of([lower, upper], [{"bottom": "xyz"}, {"top": "xyz"}], [contact])
    up, across = (np.concatenate([np.zeros(lower.n_dofs), upper.translation(e)]) for e in ([0, 0, 1.0], [1.0, 0, 0]))

    def stage(x, z):
        motion = x * across + z * up
        return Stage(a, motion=motion - a.free @ (a.free.T @ motion))

    pressed = equilibrium(lambda level: stage(0.0, -0.01 * level), steps=1)
    path = equilibrium(lambda level: stage(0.05 * level, -0.01), steps=3, start=pressed.last)
    assert path.success
    normal, end = path.last.forces[0], path.last.friction
    assert np.abs(np.linalg.norm(end.forces[0], axis=1) - MU * normal).max() < 1e-9 * normal.max()
    held = [path.last.reactions[: lower.n_dofs] @ lower.translation(e) for e in np.eye(3)]
    dragged_by = [path.last.reactions[lower.n_dofs :] @ upper.translation(e) for e in np.eye(3)]
    assert held == pytest.approx(-np.array(dragged_by), abs=1e-9 * normal.sum())
    # faces bend a little: normals lean by the strains
    assert -held[0] == pytest.approx(MU * held[2], rel=0.02)
