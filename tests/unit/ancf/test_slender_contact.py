"""Cables, belts and plates against rigid bodies, beside closed forms."""

import math

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.analytic import friction
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Joints, Stage, equilibrium
from fecontact.ancf.slender import line, plate, straight, touching, touching_members

UP = np.array([0.0, 1.0, 0.0])


def drum(x=0.0, turn=0.0, radius=1.0):
    """A cylinder along z at (x, 0), turned about its axis."""
    along = fc.rotation_about((0, 0, 1), turn) @ fc.rotation_about((1, 0, 0), math.pi / 2)
    body = fc.RigidBody(fc.surfaces.Cylinder(radius), name="drum")
    return body.placed((0, 0, -radius)).placed(rotation=along).placed((x, 0, 0))


def arc(start, end, n, radius, x=0.0):
    """Points and tangents of an arc about (x, 0), n elements."""
    angle = np.linspace(start, end, n + 1)
    c, s, zero = np.cos(angle), np.sin(angle), np.zeros(n + 1)
    sense = math.copysign(1.0, end - start)
    return np.stack([x + radius * c, radius * s, zero], axis=1), sense * np.stack([-s, c, zero], axis=1)


def spans(*pieces):
    """One axis from pieces of points and tangents, the last of each being the first of the next."""
    points, tangents = (np.concatenate([p[k][:-1] for p in pieces[:-1]] + [pieces[-1][k]]) for k in (0, 1))
    return points, tangents


def tail(start, end, n):
    points = straight(start, end, n)
    way = points[-1] - points[0]
    return points, np.tile(way / np.linalg.norm(way), (n + 1, 1))


@pytest.mark.full
def test_a_cable_laid_on_a_drum():
    """Half of a straight cable, pulled down at its end. Source: the elastica.

    Bending and tension keep T + M^2 / (2 EI) constant along a free piece (A. E. H. Love, Mathematical Theory of
    Elasticity, section 262). At the end M = 0 and T is the pull; on the drum M = EI / r. So the tension there is T - EI
    / (2 r^2), and the pressure per length that over r; the cable leaves with a single force before it hangs down.
    """
    pull, bending, thick = 1.0, 1e-2, 0.05
    r = 1 + thick
    cable = line(straight((0, r, 0), (2.6, r, 0), 13), EA=1e4, EI=bending)
    joints = Joints([cable])
    conditions = [joints.flat(), joints.pinned((0, 0)), joints.guided((0, 0), 1, UP)]
    a = Assembly([cable], conditions, [fc.Contact(cable.side(thick), drum())])
    load = np.zeros(cable.n_dofs)
    load[-5] = -pull
    path = equilibrium(lambda level: Stage(a, forces=level * load), steps=5)
    assert path.success
    forces, contact = path.last.forces[0], a.constraints[0]
    part = a.conditions(path.last.q).parts[0]
    assert a.translation(UP) @ (part.G.T @ forces) == pytest.approx(pull, rel=1e-3)
    pressure = (forces / contact.areas)[:2].mean()
    assert pressure == pytest.approx((pull - bending / (2 * r**2)) / r, rel=2e-3)
    # it leaves where cos of the rest of the quarter is the share of the pull; elements are 11 degrees long
    pressed = (part.means @ part.projection.points)[forces > 0]
    leaves = math.degrees(np.arctan2(pressed[:, 0], pressed[:, 1]).max())
    assert leaves == pytest.approx(90 - math.degrees(math.acos(1 - bending / (2 * r**2 * pull))), abs=6)
    # the skin lies on the drum within what an element's cubic leaves open
    gaps = part.projection.gap - thick
    assert np.abs(gaps[: 5 * 6]).max() < 2e-4


@pytest.mark.parametrize(("n", "most"), [(12, 4e-3), (24, 2e-3)])
def test_a_belt_slides_round_half_a_drum(n, most):
    """Source: Euler and Eytelwein. First order in the length of the elements: contact ends inside one."""
    mu, slack = 0.3, 1.0
    points, tangents = spans(
        tail((-1, -0.3, 0), (-1, 0, 0), 2), arc(math.pi, 0, n, 1.0), tail((1, 0, 0), (1, -0.3, 0), 2)
    )
    belt = line(points, EA=1e3, EI=1e-4, tangents=tangents)
    joints = Joints([belt])
    conditions = [joints.flat(), joints.pinned((0, 0), UP)]
    a = Assembly([belt], conditions, [fc.Contact(belt.side(), drum(), friction=mu)])
    load, motion = np.zeros((2, belt.n_dofs))
    load[-5], motion[1] = -slack, -0.02
    hung = equilibrium(lambda level: Stage(a, forces=level * load), steps=2)
    path = equilibrium(lambda level: Stage(a, forces=load, motion=level * motion), steps=2, start=hung.last)
    assert path.success
    assert -path.last.reactions[1] == pytest.approx(friction.belt_tension(slack, mu, math.pi), rel=most)
    end, normal = path.last.friction, path.last.forces[0]
    assert np.linalg.norm(end.forces[0], axis=1) == pytest.approx(mu * normal, abs=1e-9)
    assert end.residuals.slip < 1e-9
    assert all(s.friction.friction_work >= 0 for s in path.steps[1:])


def closed_belt(EI, mus, distance=3.0, n=12, m=4):
    """A closed belt without stress on two pulleys, n elements on each and m on each span, which nothing holds."""
    points, tangents = spans(
        arc(math.pi / 2, 1.5 * math.pi, n, 1.0), tail((0, -1, 0), (distance, -1, 0), m),
        arc(-math.pi / 2, math.pi / 2, n, 1.0, distance), tail((distance, 1, 0), (0, 1, 0), m),
    )  # fmt: skip
    belt = line(points, EA=100.0, EI=EI, tangents=tangents)
    joints, left = Joints([belt]), [len(belt.cells) - 1, *range(n + 1)]
    conditions, right = [joints.flat(), joints.rigid((0, 0), (0, -1))], range(n + m - 1, 2 * n + m + 1)
    touches = [
        fc.Contact(belt.side(elements=each), drum(x), friction=mu)
        for x, mu, each in zip((0.0, distance), mus, (left, right), strict=True)
    ]
    return belt, Assembly([belt], conditions, touches)


def tightened(a, turn=0.0, start=None):
    """One pulley 0.02 away, or on its way there from nothing, the other turned."""
    path = equilibrium(
        lambda level: Stage(a.with_rigid(drum(turn=turn), drum(3 + 0.02 * (1 if start else level)))),
        steps=1,
        start=start,
    )
    assert path.success
    return path.last


def spanned(belt, end, n=12, m=4):
    """Tensions of the slack and the tight span."""
    tension = 100.0 * belt.strains(end.q, 0)[..., 0].mean(axis=1)
    return tension[n + m // 2], tension[-1 - m // 2]


def test_a_belt_on_two_pulleys():
    """A closed belt that nothing holds but friction: one pulley is pulled, then the other turned until the belt slides.

    Source: Euler and Eytelwein for the spans; their difference is what turns the pulley.
    """
    mu = 0.3
    belt, a = closed_belt(2e-2, (mu, mu))
    end = None
    for turn in (0.0, 0.01, 0.02):
        end = tightened(a, turn, end)
    slack, tight = spanned(belt, end)
    # twelve elements for half a turn, as in the test above
    assert tight / slack == pytest.approx(friction.belt_tension(1.0, mu, math.pi), rel=4e-3)
    part = a.conditions(end.q).parts[0]
    on_belt = np.cross((part.means @ part.projection.points), end.friction.forces[0])[:, 2].sum()
    assert on_belt == pytest.approx(tight - slack, rel=2e-3)
    # the turn is the slip of the pulley that slides, and its work; the other holds
    slid, held = (-(f * s).sum() for f, s in zip(end.friction.forces, end.friction.slip, strict=True))
    assert slid == pytest.approx(0.01 * (tight - slack), rel=0.05)
    assert -1e-9 * slid <= held < 1e-2 * slid  # rounding of a work that may be zero


def test_a_belt_with_almost_no_bending_is_tightened():
    """EI of 1e-6 and, from there, 1e-10 of EA; a pulley of less friction is turned. Source: Euler and Eytelwein."""
    mu, end = 0.3, None
    for bending in (1e-4, 1e-8):
        belt, a = closed_belt(bending, (mu, 0.4))
        end = tightened(a, start=end)
        # 2 pi + 6 long and 0.04 longer, but for what friction keeps from the arcs
        assert sum(spanned(belt, end)) / 2 == pytest.approx(100 * 0.04 / (2 * math.pi + 6), rel=0.25)
        slid = tightened(a, 0.02, tightened(a, 0.01, end))
        slack, tight = spanned(belt, slid)
        assert tight / slack == pytest.approx(friction.belt_tension(1.0, mu, math.pi), rel=2e-3)
        assert slid.residuals.slip < 1e-9


@pytest.mark.full
def test_a_plate_pressed_on_a_ball():
    """A quarter of a clamped plate, pressed by a ball twice as deep as it is thick. Source: the same plate of bricks.

    The bricks touch by their faces and have no assumption of a normal; Poisson's ratio is zero, with which they do not
    lock.
    """
    thick, depth, material, n = 0.05, 0.1, fc.Material(E=1e4, nu=0.0), 12
    quarter = plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (n, n), material, thick)
    x, y, _ = quarter.vectors[:, 0].T
    joints = Joints([quarter])
    held = [joints.clamped((0, k)) for k in np.flatnonzero((x > 1 - 1e-9) | (y > 1 - 1e-9))]
    for axis, at in ((0, x), (1, y)):
        # across a plane of symmetry nothing moves, the gradient across does not tilt, that along does not turn
        across, others = np.eye(3)[axis], np.delete(np.eye(3), axis, axis=0)
        for k in np.flatnonzero(at < 1e-9):
            held += [joints.pinned((0, k), across), joints.guided((0, k), 1 + axis, others)]
            held.append(joints.guided((0, k), 2 - axis, across))
    ball, up = fc.RigidBody(fc.Sphere(1.0)), np.array([0.0, 0.0, 1.0])
    mesh = fc.shapes.block((1.0, 1.0, thick), (n // 2, n // 2, 1), element="hex8").translated((0, 0, -thick / 2))
    solid = AncfSolid(AncfSpace(mesh), material, points=3)
    support = {"x_max": "xyz", "y_max": "xyz", "x_min": "x", "y_min": "y"}
    forces = []
    for a in (
        Assembly([quarter], held, [fc.Contact(quarter.side(thick / 2), ball)]),
        Assembly.of([solid], [support], [fc.Contact(solid.side("top"), ball)]),
    ):
        path = equilibrium(
            lambda level, a=a: Stage(a.with_rigid(ball.placed((0, 0, thick / 2 - depth * level)))), steps=2
        )
        assert path.success
        last = a.with_rigid(ball.placed((0, 0, thick / 2 - depth))).conditions(path.last.q).parts[0]
        forces.append(-a.translation(up) @ (last.G.T @ path.last.forces[0]))
    # shear, and a contact of a few elements in width
    assert forces[0] == pytest.approx(forces[1], rel=0.02)


@pytest.mark.parametrize(
    ("depth", "at", "carries"),
    [
        (0.01, (0.0, 0.0), False),
        (0.0018, (0.0, 0.0), False),
        (1e-6, (0.13, -0.07), False),
        (0.003, (1 / 3, 0.9), False),
        (0.2, (0.0, 0.0), True),
        (-1e-6, (0.13, -0.07), False),
    ],
)
def test_a_ball_within_an_element_whose_mean_gap_is_open_is_named(depth, at, carries):
    """Source: geometry; small depths lie between the quadrature points of the element."""
    sheet = plate([(-1, -1, 0), (1, -1, 0), (-1, 1, 0)], (3, 3), fc.Material(E=1e3, nu=0.3), 0.05)
    below = fc.RigidBody(fc.Sphere(1.0)).placed((*at, -0.025 + depth), fc.rotation_about((1, 0, 0), math.pi))
    joints = Joints([sheet])
    rim = np.flatnonzero(np.abs(sheet.vectors[:, 0, :2]).max(axis=1) > 1 - 1e-9)
    conditions = [joints.clamped((0, k)) for k in rim]
    path = equilibrium(lambda _: Stage(Assembly([sheet], conditions, [fc.Contact(sheet.side(0.025), below)])), steps=1)
    assert path.success
    assert (path.last.forces[0].sum() > 0) == carries
    overlap = 0.0 if carries else max(0.0, depth)
    assert path.last.overlaps == pytest.approx((overlap,), abs=1e-12)
    assert ("Contact 0 carries nothing, but its sides overlap" in str(path)) == (overlap > 0)


def test_bad_input():
    cable = line(straight((0, 0, 0), (1, 0, 0), 4), EA=1.0, EI=1.0)
    for offset in (-0.1, np.nan, np.inf):
        with refused(fc.InputError, "input", "offset must be a radius"):
            cable.side(offset)
    for elements in ([4], [-1], []):
        with refused(fc.InputError, "input", "has 4"):
            cable.side(0.1, elements)
    with refused(fc.InputError, "friction", "zero or positive"):
        fc.Contact(cable.side(), drum(), friction=-0.1)


def test_former_names_of_contacts_still_work():
    cable, post = (line(straight((0, 0, z), (1, 0, z), 4), EA=1.0, EI=1.0) for z in (0, 1))
    with pytest.warns(DeprecationWarning, match=r"touching\(..\) is now Contact"):
        found = touching([cable], 0, drum(), offset=0.1, friction=0.2, elements=[2, 1])
    assert (found.slave.member, found.slave.offset, found.mu) == (cable, 0.1, 0.2)
    assert found.slave.elements.tolist() == [1, 2]
    with pytest.warns(DeprecationWarning, match=r"touching_members\(..\) is now Contact"):
        found = touching_members([post, cable], 1, 0, offsets=(0.1, 0.2))
    assert (found.slave.member, found.master.member, found.master.offset) == (cable, post, 0.2)
    for number in (-1, 2):
        with pytest.warns(DeprecationWarning, match="now Contact"), refused(fc.InputError, "unknown", "are 2"):
            touching([cable, post], number, drum())
        with pytest.warns(DeprecationWarning, match="now Contact"), refused(fc.InputError, "unknown", "are 2"):
            touching_members([cable, post], 0, number, offsets=(0.1, 0.1))
