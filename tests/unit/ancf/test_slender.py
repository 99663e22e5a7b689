"""Beams, cables and plates: derivatives by differences, rigid motions, mass, joints, linear deflections."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from differences import off_differences
from refusals import refused
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Joints, Stage, equilibrium
from fecontact.ancf.slender import Surface, beam, line, plate, shell, straight, strip, thick_plate

MATERIAL = fc.Material(E=3.0, nu=0.3, density=2.0)
POINTS = straight((0, 0, 0), (2, 0, 0), 2)
CORNERS = [(0, 0, 0), (2, 0, 0), (0, 1, 0)]
SECTION = {"width": 0.3, "height": 0.4}
ARC = np.linspace(0, 1.2, 4)
CURVED = {
    "points": np.stack([np.sin(ARC), 1 - np.cos(ARC), 0 * ARC], axis=1),
    "tangents": np.stack([np.cos(ARC), np.sin(ARC), 0 * ARC], axis=1),
}
DOME = Surface.mapped(lambda u, v: np.stack([2 * u, v, 0.3 * u * v + 0.2 * u**2], axis=-1), (2, 1))
KITE = Surface.of([(0, 0, 0), (2, 0, 0), (1.5, 1.2, 0), (0, 1, 0)], [(0, 1, 2, 3)])
TAPER = np.linspace(0.1, 0.2, 6)
MADE = {
    "line, turn": lambda: line(POINTS, EA=5.0, EI=0.3, mass=1.0),
    "line, geometric": lambda: line(POINTS, EA=5.0, EI=0.3, mass=1.0, measure="geometric"),
    "line, chord": lambda: line(POINTS, EA=5.0, EI=0.3, mass=1.0, measure="chord"),
    "curved line": lambda: line(**CURVED, EA=5.0, EI=0.3, mass=1.0),
    "strip": lambda: strip(POINTS, MATERIAL, **SECTION),
    "strip, continuum": lambda: strip(POINTS, MATERIAL, **SECTION, approach="continuum"),
    "beam": lambda: beam(POINTS, MATERIAL, **SECTION),
    "curved beam": lambda: beam(**CURVED, material=MATERIAL, **SECTION),
    "beam, continuum": lambda: beam(POINTS, MATERIAL, **SECTION, approach="continuum"),
    "plate": lambda: plate(CORNERS, (2, 1), MATERIAL, 0.1),
    "thick plate": lambda: thick_plate(CORNERS, (2, 1), MATERIAL, 0.1),
    "thick plate, continuum": lambda: thick_plate(CORNERS, (2, 1), MATERIAL, 0.1, approach="continuum"),
    "shell": lambda: shell(KITE, MATERIAL, 0.1),
    "smooth shell": lambda: shell(DOME, MATERIAL, TAPER, smooth=True),
    "thick shell": lambda: shell(DOME, MATERIAL, TAPER, thick=True),
    "smooth thick shell": lambda: shell(DOME, MATERIAL, 0.1, smooth=True, thick=True),
    "thick shell, continuum": lambda: shell(DOME, MATERIAL, TAPER, thick=True, approach="continuum"),
}
#: Motions without energy: a line does not twist, a strip has nothing out of its plane.
FREE = {"line, turn": 5, "line, geometric": 5, "line, chord": 9, "strip": 12, "strip, continuum": 12}


@pytest.fixture(params=MADE)
def name(request):
    return request.param


def test_forces_and_tangent_are_derivatives_of_the_energy(name):
    """Central differences at a large random deformation, along a random direction."""
    s, rng = MADE[name](), np.random.default_rng(0)
    q, d = s.q0 + 0.1 * rng.normal(size=s.n_dofs), rng.normal(size=s.n_dofs)
    assert max(off_differences(s, q, d)) < 1e-7
    K = s.tangent(q)
    assert abs(K - K.T).max() < 1e-12 * abs(K).max()


def test_rigid_motions_are_free_of_forces(name):
    """By any angle; small ones are the null space of the stiffness, and nothing else is."""
    s = MADE[name]()
    axis = [0.0, 0.0, 2.0] if name == "curved line" else [0.7, -1.1, 2.0]
    turned = Rotation.from_rotvec(axis).apply(s.vectors.reshape(-1, 3)).reshape(s.vectors.shape)
    turned[:, 0] += [3.0, -2.0, 1.0]
    assert s.energy(turned.ravel()) < 1e-25
    values = np.linalg.eigvalsh(s.tangent(s.q0).toarray())
    # a curved line has nothing across its plane: positions and tangents of four nodes
    assert (values < 1e-10 * values[-1]).sum() == {**FREE, "curved line": 3 + 8}.get(name, 6)
    assert np.abs(s.tangent(s.q0) @ s.rigid_modes).max() < 1e-11 * values[-1]


def test_mass_is_that_of_the_body(name):
    """Of a translation the mass; of a turn the moment of inertia of the box, or of its axis or middle surface."""
    s = MADE[name]()
    R, M = s.rigid_modes, s.mass
    total = R[:, 0] @ M @ R[:, 0]
    box = {"strip": 0.48, "beam": 0.48, "plate": 0.4}
    if "shell" in name:
        return  # see `test_shells.py`
    if "curved" in name:
        # length of the arc; the cubic's is off by a few 1e-5
        expected = {"curved line": 1.2, "curved beam": 1.2 * 0.24}[name]
        assert abs(total / expected - 1) < 1e-4
        return
    kind = next((k for k in box if k in name), "line")
    expected = box.get(kind, 2.0)
    assert abs(total / expected - 1) < 1e-12
    depth = 0.4**2 if kind == "strip" else 0.3**2 if kind == "beam" else 1.0 if kind == "plate" else 0.0
    assert abs(R[:, 5] @ M @ R[:, 5] / (expected * (2.0**2 + depth) / 12) - 1) < 1e-12


def tip(s, conditions, load):
    """Displacement of the last node under a small force on it."""
    a = Assembly([s], conditions)
    f = np.zeros(s.vectors.shape)
    f[-1, 0] = load
    K = (a.free.T @ s.tangent(s.q0) @ a.free).tocsc()
    return (a.free @ spla.spsolve(K, a.free.T @ f.ravel())).reshape(s.vectors.shape)[-1, 0]


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_cantilevers(nu):
    """Against Bernoulli (line, exact: cubic) and Timoshenko, whose shear the elastic line has; order 2 in the elements.

    The section's turn is linear in an element, its bending off by (1/4) n^-2. Continuum elements lock by Poisson's
    ratio, a strip by nu^2 = 9 %, a beam by (1 - nu)/(1 + nu)/(1 - 2 nu) = 1.35, and converge to wrong values.
    """
    material, b, h, L = fc.Material(E=1000.0, nu=nu), 0.5, 1.0, 10.0
    bending, G = L**3 / (3 * 1000.0 * b * h**3 / 12), material.shear_modulus
    timoshenko = bending + L / (5 / 6 * G * b * h)
    for n in (1, 2, 8):
        nodes = straight((0, 0, 0), (L, 0, 0), n)
        s = line(nodes, EA=1000.0 * b * h, EI=1000.0 * b * h**3 / 12)
        joints = Joints([s])
        found = tip(s, [joints.flat(), joints.clamped((0, 0))], (0, 1, 0))[1]
        assert abs(found / bending - 1) < 1e-10
        for approach in ("line", "continuum"):
            s = strip(nodes, material, width=b, height=h, approach=approach)
            joints = Joints([s])
            held = [joints.flat(), joints.pinned((0, 0)), joints.guided((0, 0), 2)]
            flat = tip(s, held, (0, 1, 0))[1] / timoshenko
            s = beam(nodes, material, width=b, height=h, approach=approach)
            joints = Joints([s])
            held = [joints.pinned((0, 0)), joints.guided((0, 0), 2), joints.guided((0, 0), 3)]
            solid = tip(s, held, (0, 0, 1))[2] / timoshenko
            if approach == "line":
                assert abs(flat - (1 - 0.25 / n**2)) < 2e-3
                assert abs(solid - flat) < 1e-10
            elif n == 8 and nu:
                assert abs(flat - (1 - nu**2)) < 0.01
                assert abs(solid - (1 + nu) * (1 - 2 * nu) / (1 - nu)) < 0.01


@pytest.mark.parametrize(
    ("kind", "nu"), [("strip", 0.0), ("strip", 0.3), ("beam", 0.0), ("beam", 0.3), ("plate", 0.0), ("thick plate", 0.0)]
)
def test_a_clamped_end_stretches_and_does_not_turn(kind, nu):
    """Extension F L / (E A) exactly, of beams with their section's contraction; bending of Timoshenko and Kirchhoff.

    A clamp that held all gradients shortened the extension by 2.9 %, and had no shear. The section's
    turn is linear in an element, see `test_cantilevers`; a thick plate's 0.9 % stiff.
    """
    material, b, h, L, n = fc.Material(E=1000.0, nu=nu), 0.5, 1.0, 10.0, 4
    straight_axis, corners = straight((0, 0, 0), (L, 0, 0), n), [(0, 0, 0), (L, 0, 0), (0, b, 0)]
    make = {
        "strip": lambda: strip(straight_axis, material, width=b, height=h),
        "beam": lambda: beam(straight_axis, material, width=b, height=h),
        "plate": lambda: plate(corners, (n, 1), material, h),
        "thick plate": lambda: thick_plate(corners, (n, 1), material, h),
    }
    s, plated = make[kind](), "plate" in kind
    joints, x = Joints([s]), s.vectors[:, 0, 0]
    held = [joints.clamped((0, int(k))) for k in np.flatnonzero(x < 1e-9)]
    across = 1 if kind == "strip" else 2
    Z = joints.free([*held, *([joints.flat()] if kind == "strip" else [])])
    K, end = (Z.T @ s.tangent(s.q0) @ Z).tocsc(), np.flatnonzero(x > L - 1e-9)
    found = []
    for axis in (0, across):
        f = np.zeros(s.vectors.shape)
        f[end, 0, axis] = 1 / len(end)
        if plated:  # a uniform traction works on the gradient along the edge
            f[end, 2, axis] = b / 12 * np.array([1.0, -1.0])
        found.append((Z @ spla.spsolve(K, Z.T @ f.ravel())).reshape(s.vectors.shape)[end, 0, axis].mean())
    bending = L**3 / (3 * 1000.0 * b * h**3 / 12)
    shear = 0.0 if plated else L / (5 / 6 * material.shear_modulus * b * h)
    assert abs(found[0] / (L / (1000.0 * b * h)) - 1) < 1e-10
    short = {"plate": 0.0, "thick plate": 0.009}.get(kind, 0.25 / n**2)
    assert abs(found[1] / (bending + shear) - (1 - short)) < 2e-3


def test_torsion_of_a_beam():
    """The turn of the end section under a pair of forces: M L / (G J)."""
    material = fc.Material(E=1000.0, nu=0.25)
    s = beam(straight((0, 0, 0), (4, 0, 0), 3), material, width=1.0, height=1.0, torsion=0.1)
    joints = Joints([s])
    Z = joints.free([joints.clamped((0, 0))])
    f = np.zeros(s.vectors.shape)
    # the moment by its work on both gradients of the last section
    f[-1, 2, 2], f[-1, 3, 1] = 0.5, -0.5
    u = Z @ spla.spsolve((Z.T @ s.tangent(s.q0) @ Z).tocsc(), Z.T @ f.ravel())
    assert abs(u.reshape(s.vectors.shape)[-1, 2, 2] / (4 / (material.shear_modulus * 0.1)) - 1) < 1e-10


def deflection(s, D, clamped):
    """Middle of a clamped square plate of side 1 under a uniform load, over 0.001265 q L^4 / D."""
    x = s.vectors[:, 0, :2]
    edge = np.flatnonzero(((np.abs(x) < 1e-9) | (np.abs(x - 1) < 1e-9)).any(axis=1))
    joints = Joints([s])
    conditions = [joints.pinned((0, int(k))) for k in edge]
    conditions += [joints.guided((0, int(k)), g) for k in edge for g in clamped]
    Z = joints.free(conditions)
    f = np.zeros((s.n_dofs // 3, 3))
    points, weights = s.parts[0].points, s.parts[0].weights
    S = s.shape.functions(s.lengths, points * [1, 1, 0])
    np.add.at(f[:, 2], s.functions, np.einsum("q,e,eqa->ea", weights, s.lengths[:, 0] * s.lengths[:, 1], S))
    u = Z @ spla.spsolve((Z.T @ s.tangent(s.q0) @ Z).tocsc(), Z.T @ f.ravel())
    middle = np.argmin(np.abs(x - 0.5).sum(axis=1))
    return u.reshape(s.vectors.shape)[middle, 0, 2] * D / 0.00126532


@pytest.mark.by_day("0.4999-10", "0.0-1000")
@pytest.mark.parametrize("slenderness", [10, 1000])
@pytest.mark.parametrize("nu", [0.0, 0.4999])
def test_plates_do_not_lock(slenderness, nu):
    """A clamped square plate of 8 x 8 elements, thin to thick, nearly incompressible too.

    Source: S. P. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and Shells, table 35. Adini's functions do not
    conform and are too soft by 2.4 to 3.5 % on this mesh; with the gradient across of its own within 2 %.
    """
    h, material = 1.0 / slenderness, fc.Material(E=1000.0, nu=nu)
    D = 1000.0 * h**3 / 12 / (1 - nu**2)
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    assert abs(deflection(plate(corners, (8, 8), material, h), D, (1, 2)) - 1) < 0.04
    assert abs(deflection(thick_plate(corners, (8, 8), material, h), D, (1, 2)) - 1) < 0.02
    if slenderness == 1000:
        continuum = deflection(thick_plate(corners, (8, 8), material, h, approach="continuum"), D, (3,))
        assert continuum < 0.05  # locked


def test_joints_tie_what_they_say_and_leave_the_rest():
    one, other = (line(straight((x, 0, 0), (x + 1, 0, 0), 2), EA=1.0, EI=1.0) for x in (0.0, 1.0))
    joints, n = Joints([one, other]), 36
    for condition, rank in (
        (joints.clamped((0, 0)), 5),
        (joints.pinned((1, -1)), 3),
        (joints.pinned((1, -1), [(1, 1, 0)]), 1),
        (joints.spherical((0, 2), (1, 0)), 3),
        (joints.slot((0, 2), (1, 0), (1, 1, 1)), 2),
        (joints.revolute((0, 2), (1, 0), 1), 6),
        (joints.rigid((0, 2), (1, 0)), 6),
        (joints.flat(), 12),
    ):
        Z = joints.free([condition]).toarray()
        assert Z.shape == (n, n - rank)
        assert np.abs(Z.T @ Z - np.eye(n - rank)).max() < 1e-13
        assert np.abs(condition @ Z).max() < 1e-13
    # the same condition twice counts once
    assert joints.free([joints.spherical((0, 2), (1, 0))] * 2).shape == (n, n - 3)


def test_a_clamped_line_stretches_up_to_its_end():
    # F L / EA of a bar; with the stretch held at the clamp it was 3 % less
    bar = line(straight((0, 0, 0), (1, 0, 0), 2), EA=1e3, EI=1.0)
    joints = Joints([bar])
    a = Assembly([bar], [joints.clamped((0, 0))])
    pull = np.zeros((bar.n_dofs // 3, 3))
    pull[-2, 0] = 1.0
    last = equilibrium(lambda level: Stage(a, level * pull.ravel()), steps=1).last
    assert abs(last.q.reshape(-1, 3)[-2, 0] - 1.001) < 1e-12


def test_ties_that_stop_members_from_turning_together_are_refused():
    post, arm = (line(straight(*ends, 2), EA=1.0, EI=1.0) for ends in (((0, 0, 0), (0, 1, 0)), ((0, 1, 0), (1, 1, 0))))
    rising = line(straight((0, 1, 0), (0, 1, 1), 2), EA=1.0, EI=1.0)
    sheets = [
        plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (1, 1), fc.Material(E=1.0, nu=0.0), 0.1),
        plate([(1, 0, 0), (1, 0, 1), (1, 1, 0)], (1, 1), fc.Material(E=1.0, nu=0.0), 0.1),
    ]
    joints = Joints([post, arm, rising, *sheets])
    for tie in (
        lambda: joints.revolute((0, 2), (1, 0), 1),
        lambda: joints.rigid((0, 2), (2, 0)),
        lambda: joints.rigid((3, 2), (4, 0)),
        lambda: joints.spherical((0, 2), (1, 1)),
    ):
        with refused(fc.InputError, "members-at-an-angle"):
            tie()
    assert joints.spherical((0, 2), (1, 0)).shape[0] == 3
    assert joints.rigid((0, 2), (1, 0)).shape[0] == 7  # in their plane


def legs(kind, angle, n, side=0.1):
    """Two members of length 10 and E I = 1 that meet at an angle, the second along x."""
    corner = (10 * np.cos(angle), 10 * np.sin(angle), 0.0)
    lines = straight((0, 0, 0), corner, n), straight(corner, (corner[0] + 10, corner[1], 0), n)
    steel = fc.Material(E=12 / side**4, nu=0.0)
    if kind is line:
        return [line(p, EA=12 / side**2, EI=1.0) for p in lines]
    return [kind(p, steel, width=side, height=side) for p in lines]


@pytest.mark.parametrize(("kind", "n", "far"), [(line, 2, 1e-5), (strip, 8, 1.7e-3), (beam, 8, 1.7e-3)])
@pytest.mark.parametrize("angle", [np.pi / 2, 2.0])
def test_frames_of_two_members_bend_as_one(kind, n, far, angle):
    """Tip of a frame under a small force: L^3 P / (3 E I) of the arm, and the turn and drop of the post.

    Lines differ by their axial strain (6.3e-6 at a right angle), strips by the linear turn of their
    sections, 1 / (4 n^2), beams by the shear of their common node, see `Joints.rigid`.
    """
    members = legs(kind, angle, n)
    joints, P, L = Joints(members), 1e-8, 10.0
    ties = [joints.clamped((0, 0)), joints.rigid((0, -1), (1, 0)), *([] if kind is beam else [joints.flat()])]
    frame = Assembly(members, ties)
    load = np.zeros((frame.n_dofs // 3, 3))
    tip = (frame.starts[1] // 3) + n * members[1].shape.per_node
    load[tip, 1] = -P
    last = equilibrium(lambda level: Stage(frame, level * load.ravel()), steps=1).last
    c = np.cos(angle)
    # moment P (L + (L - s) c) at s along the post, whose end drops by its normal deflection times c
    exact = P * L**3 * (1 / 3 + (1 + c / 2) + (1 / 2 + c / 3) * c)
    assert abs((frame.q0 - last.q).reshape(-1, 3)[tip, 1] / exact - 1) < far
    turned = (frame.q0.reshape(-1, 3) @ fc.rotation_about((0, 0, 1), 0.7).T).ravel()
    assert np.abs(ties[1] @ (turned - frame.q0)).max() < 1e-14


def test_a_spoke_on_a_rigid_hub_turns_and_bends_with_it():
    """A cantilever on a hub, at any angle: turned together no force; tip P L^3 / (3 E I), pulled F L / (E A)."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8").translated((-0.5, -0.5, -0.5))
    hub, out = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.0)), fc.rotation_about((1, 2, 3), 0.9)[0]
    spoke = beam(straight(np.zeros(3), 10 * out, 8), fc.Material(E=12e4, nu=0.0), width=0.1, height=0.1)
    joints = Joints([hub, spoke])
    tie = joints.rigid((1, 0), (0, (0.0, 0.0, 0.0)))
    rest = np.concatenate([hub.q0, spoke.q0])
    turn = fc.rotation_about((3, -1, 2), np.radians(80.0))
    turned = np.concatenate([hub.space.affine(turn, np.zeros(3)), (spoke.q0.reshape(-1, 3) @ turn.T).ravel()])
    assert np.abs(tie @ (turned - rest)).max() < 1e-13
    held = joints.affine(0), joints.clamped((0, (0.0, 0.0, 0.0))), tie
    wheel = Assembly([hub, spoke], list(held), rigid=[0])
    tip = wheel.starts[1] // 3 + 8 * 4
    for along, force, exact in ((np.cross(out, (0, 0, 1)), 1e-6, 1e-3 / 3), (out, 1e-3, 1e-2 / 1200)):
        unit, load = along / np.linalg.norm(along), np.zeros((wheel.n_dofs // 3, 3))
        load[tip] = force * unit
        last = equilibrium(lambda level: Stage(wheel, level * load.ravel()), steps=1).last  # noqa: B023
        # the turn of its section is linear within elements: 1 / (4 n^2) of the deflection
        assert abs((last.q - wheel.q0).reshape(-1, 3)[tip] @ unit / exact - 1) < 5e-3


def test_a_hinge_of_members_at_an_angle():
    """Two beams on a hinge about the y of the first, which is the height of the second: they turn apart freely."""
    steel = fc.Material(E=1e4, nu=0.0)
    one = beam(straight((0, 0, 0), (1, 0, 0), 1), steel, width=0.1, height=0.1)
    other = beam(straight((1, 0, 0), (1, 0, 1), 1), steel, width=0.1, height=0.1, up=(0, 1, 0))
    joints = Joints([one, other])
    hinge = joints.revolute((0, 1), (1, 0), 2)
    arms = other.vectors - np.array([[[1.0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]])
    for axis, free in (((0, 1, 0), True), ((1, 0, 0), False)):
        moved = np.concatenate([np.zeros(one.n_dofs), (arms @ (fc.rotation_about(axis, 0.5).T - np.eye(3))).ravel()])
        assert (np.abs(hinge @ moved).max() < 1e-14) == free


def test_members_without_mass_have_no_weight_to_be_asked_for():
    bar, down = line(straight((0, 0, 0), (1, 0, 0), 2), EA=1.0, EI=1.0), np.array([0.0, -9.81, 0.0])
    a = Assembly([bar], [Joints([bar]).clamped((0, 0))])
    with refused(fc.InputError, "no-mass", "Member 0"):
        a.gravity(down)
    assert not a.gravity(np.zeros(3)).any()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: line([(0, 0, 0)], EA=1, EI=1), ("axis-nodes",)),
        (lambda: line([(0, 0, 0), (1, 0, 0), (1, 1, 0)], EA=1, EI=1), ("bent",)),
        (lambda: line([(0, 0, 0), (1, 0, 0)], EA=1, EI=1, tangents=[(2, 0, 0)] * 2), ("tangent",)),
        (lambda: line([POINTS, POINTS], EA=1, EI=1, tangents=[POINTS, POINTS]), ("axes",)),
        (lambda: line([(0, 0, 0), (0, 0, 0)], EA=1, EI=1), ("zero-length",)),
        (
            lambda: line(CURVED["points"][:, [0, 2, 1]], EA=1, EI=1, tangents=CURVED["tangents"][:, [0, 2, 1]]),
            ("in-space",),
        ),
        (lambda: line(POINTS, EA=0.0, EI=1), ("not-positive", "EA")),
        (lambda: line(POINTS, EA=1, EI=1, measure="best"), ("unknown-name", "measure")),
        (lambda: beam(POINTS, MATERIAL, width=1, height=1, up=(1, 0, 0)), ("up-axis",)),
        (lambda: plate([(0, 0, 0), (1, 0, 0), (1, 1, 0)], (1, 1), MATERIAL, 0.1), ("plate-not-rectangular",)),
        (lambda: Joints([line(POINTS, EA=1, EI=1)]).clamped((1, 0)), ("unknown", "are 1")),
        (lambda: Joints([line(POINTS, EA=1, EI=1)]).clamped((0, 3)), ("unknown-node", "has 3")),
        (lambda: Joints([line(POINTS, EA=1, EI=1)]).guided((0, 0), 2), ("too-few-gradients", "and 1")),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_bad_input(make, message):
    with refused(fc.InputError, *message):
        make()
