"""Local bodies: their window, their compliance, what they refuse, and that nothing depends on axes and place."""

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact.bodies.local.remainder import _divided, remainder
from fecontact.bodies.local.window import coefficients, interpolation, nodes
from fecontact.common.stopwatch import Stopwatch
from fecontact.halfspace.fft import SmoothTerm

SOLID = fc.Material(E=2.0, nu=0.3)
SIDES = np.array([4.0, 4.0, 2.0])


def block(turn=None, **options):
    """A clamped block, its axes permuted cyclically: the loaded face is normal to z, x or y."""
    mesh = fc.shapes.block(tuple(SIDES), (5, 5, 4))
    if turn:
        mesh = mesh.drawn_at(np.roll(mesh.points, turn, axis=1))
    return fc.ElasticBody(mesh, SOLID, **{"supports": {"bottom": "xyz"}, "name": "block", **options})


def pressed(local, top, normal, force=0.02, **options):
    """The local body under a ball pressed against its window; the result and the ball."""
    turn = {0: fc.rotation_about((0, 1, 0), np.pi / 2), 1: fc.rotation_about((1, 0, 0), -np.pi / 2), 2: np.eye(3)}
    pose = fc.Pose(turn[int(np.argmax(normal))], np.asarray(top, dtype=float))
    ball = fc.RigidBody(fc.Sphere(10.0), pose=pose)
    result = fc.Scene([local, ball], [fc.Contact(local, ball)]).solve(
        forces={ball: -force * np.asarray(normal, dtype=float)}, **options
    )
    return result, ball


def approach(result, ball):
    return float(np.linalg.norm(result.rigid_motion(ball).translation))


def test_polynomials_are_interpolated_exactly_also_by_halves() -> None:
    x = np.linspace(0.05, 1.9, 7)
    for even, powers in ((False, (0, 1, 5)), (True, (0, 2, 4))):
        places = nodes(2.0, 6, even)
        for power in powers:
            found = interpolation(x, 2.0, 6, even) @ places**power
            assert np.abs(found - x**power).max() < 1e-12
    # 2 T_2(x / 2) + 2 = x^2
    assert np.allclose(coefficients(2.0, 6, False) @ nodes(2.0, 6, False) ** 2, [2, 0, 2, 0, 0, 0])


def test_a_smooth_term_on_coarser_cells_gives_the_same_to_second_order() -> None:
    core = np.array([[2.0, 0.5], [0.5, 1.0]])
    x = (np.arange(40) - 19.5) / 20
    term = SmoothTerm(interpolation(x, 1.0, 2, False), np.ones((4, 1)), core, 0.01)
    p = np.ones((40, 4))
    coarse = term.coarser().apply(np.ones((20, 2)))
    assert np.allclose(term.apply(p)[::2, 0] / 2 + term.apply(p)[1::2, 0] / 2, coarse[:, 0])


@pytest.mark.by_day("1")
@pytest.mark.parametrize("turn", [1, 2])
def test_the_axes_of_the_mesh_do_not_matter(turn: int) -> None:
    normal, at = np.array([0.0, 0, 1]), np.array([1.8, 2.0, 2.0])
    one, ball = pressed(fc.LocalBody(block(), at, 1.2, (32, 32)), at, normal)
    normal, at = np.roll(normal, turn), np.roll(at, turn)
    other, rolled = pressed(fc.LocalBody(block(turn), at, 1.2, (32, 32)), at, normal)
    assert abs(approach(other, rolled) / approach(one, ball) - 1) < 1e-7
    assert abs(other.contacts[0].pressure.max() / one.contacts[0].pressure.max() - 1) < 1e-7


def test_a_pose_does_not_matter() -> None:
    at, force = (2.0, 2.0, 2.0), 0.02
    local = fc.LocalBody(block(), at, 1.2, (32, 32))
    here, ball = pressed(local, at, (0, 0, 1), force)
    Q, t = fc.rotation_about((1, 2, 3), 0.7), np.array([30.0, -20.0, 10.0])
    moved, there = local.placed(t, Q), ball.placed(t, Q)
    assert moved.remainder is local.remainder
    result = fc.Scene([moved, there], [fc.Contact(moved, there)]).solve(forces={there: -force * Q[:, 2]})
    assert abs(approach(result, there) / approach(here, ball) - 1) < 1e-9


@pytest.mark.by_day("planes1")
@pytest.mark.parametrize("planes", [("x_min",), ("x_min", "y_min")])
def test_planes_of_symmetry_give_the_same_answer_as_the_whole(planes: tuple[str, ...]) -> None:
    """The mesh of the whole is that of the part and its mirror image, so the answers differ by rounding alone."""
    whole = fc.LocalBody(
        fc.ElasticBody(fc.shapes.block((4.0, 4.0, 2.0), (6, 6, 4)), SOLID, supports={"bottom": "xyz"}),
        (2.0, 2.0, 2.0), 1.2, (32, 32),
    )  # fmt: skip
    size = [2.0 if f"{c}_min" in planes else 4.0 for c in "xy"]
    mesh = fc.shapes.block((*size, 2.0), (*(3 if s == 2 else 6 for s in size), 4))
    supports = {"bottom": "xyz", **{name: name[0] for name in planes}}
    at = tuple(0.0 if s == 2 else 2.0 for s in size)
    part = fc.LocalBody(fc.ElasticBody(mesh, SOLID, supports=supports), (*at, 2.0), 1.2, (32, 32))
    one, ball = pressed(whole, (2.0, 2.0, 2.0), (0, 0, 1), 0.02, finite_motion=False)
    other, rigid = pressed(part, (*at, 2.0), (0, 0, 1), 0.02 / 2 ** len(planes), finite_motion=False)
    assert len(part.window.cells) == 1024 / 2 ** len(planes)
    assert abs(approach(other, rigid) / approach(one, ball) - 1) < 1e-7
    assert abs(other.contacts[0].pressure.max() / one.contacts[0].pressure.max() - 1) < 1e-7


def test_compliance_is_symmetric_and_that_of_the_displacements() -> None:
    local = fc.LocalBody(block(), (2.0, 2.0, 2.0), 1.2, (8, 8))
    cells = sp.csr_matrix((-np.ones(64), (np.arange(64), 3 * np.arange(64) + 2)), shape=(64, local.n_dofs))
    spring = local.attachment(np.array([0.0, 0.0, 2.0]), np.array([1.0, 0.0, 0.0]))
    rows = sp.csr_matrix(sp.vstack([cells, spring]))
    S = local.reduce(rows, None, Stopwatch()).compliance
    assert np.abs(S - S.T).max() == 0
    forces = np.random.default_rng(1).random(65)
    u = rows @ local.displacement(rows, forces, None)
    # at the cells to rounding; at the node Betti's theorem holds to the error of the coarse mesh
    assert np.abs(u[:64] - (S @ forces)[:64]).max() < 1e-12 * np.abs(u).max()
    assert abs(u[64] / (S @ forces)[64] - 1) < 0.02


def test_loads_of_the_body_move_the_window() -> None:
    """Uniaxial tension by a pressure below zero: the window moves by sigma h / E, exact for these elements."""
    supports = {"bottom": "z", "x_min": "x", "y_min": "y"}
    local = fc.LocalBody(block(supports=supports), (2.0, 2.0, 2.0), 1.0, (8, 8))
    loads = local._boundary_traction("top", lambda x, n: 0.5 * n)
    u = local.displacement(sp.csr_matrix((1, local.n_dofs)), np.zeros(1), loads)
    assert np.allclose(u[: 3 * 64].reshape(-1, 3), [0, 0, 0.5 * 2.0 / SOLID.E], atol=1e-12)


REFUSED = {
    "off the surface": ({"at": (2.0, 2.0, 1.9), "window": 1.0}, ("window-off-surface", "0.1")),
    "across an edge": ({"at": (0.4, 2.0, 2.0), "window": 1.0}, ("window-across-edge",)),
    "no body": ({"at": (0, 0, 0), "window": 1.0, "body": None}, ("no-elastic", "None")),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals(case: str) -> None:
    options, message = REFUSED[case]
    with refused(fc.InputError, *message):
        fc.LocalBody(**{"body": block(), **options})


def test_a_window_at_an_edge_is_refused_if_that_takes_too_many_cells(monkeypatch) -> None:
    monkeypatch.setattr("fecontact.bodies.local.remainder.MAX_CELLS", 150)  # three times its own are divided anyway
    local = fc.LocalBody(block(), (0.31, 2.0, 2.0), 0.6, (8, 8))
    with refused(fc.InputError, "compliance-not-symmetric", "it would take more than 492 cells"):
        local.remainder  # noqa: B018
    assert fc.LocalBody(block(), (2.0, 2.0, 2.0), 0.6, (8, 8)).remainder.defect < 0.01


def test_cells_are_divided_to_the_distance_from_images_beyond_an_edge() -> None:
    """By their places: an image of a point at a depth x from the side x = 0 lies as far beyond it."""
    body = block()
    window = fc.LocalBody(body, (0.3, 2.0, 2.0), 0.4, (8, 8)).window
    finer = _divided(body, window, 4, 1.0, 4000)
    corners = finer.mesh.points[finer.mesh.cells[:, :8]]
    x, y = np.meshgrid(np.linspace(0.1, 0.5, 41), np.linspace(1.8, 2.2, 41))
    feet = np.stack([0 * x, y, 0 * x + 2], axis=-1).reshape(-1, 1, 1, 3)
    away = (np.linalg.norm(corners - feet, axis=3).min(axis=2) + x.reshape(-1, 1)).min(axis=0)
    size = np.ptp(corners, axis=1).max(axis=1)
    assert (size <= 1.1 * away).all()  # images of points between those of the window count here too
    assert size.min() <= 0.2
    assert size[corners[..., 0].min(axis=1) > 2].min() > 0.7
    assert len(finer.mesh.cells) < 400


@pytest.mark.full
def test_a_mesh_too_coarse_for_the_edge_beside_the_window_is_divided() -> None:
    body = block()
    local = fc.LocalBody(body, (0.28, 2.0, 2.0), 0.4, (8, 8))
    before = remainder(local.factored, local.window, local.material)
    assert before.defect > 0.01
    assert local.remainder.defect <= 0.01
    assert len(local.remainder.fields) == len(before.fields)  # at the body's own nodes
    fine = fc.ElasticBody(fc.shapes.block((4.0, 4.0, 2.0), (12, 10, 5), element="hex20"), SOLID, supports=body.supports)
    exact = fc.LocalBody(fine, (0.28, 2.0, 2.0), 0.4, (8, 8)).remainder
    # the check allows 1 % of the mean compliance
    assert abs(local.remainder.mean / exact.mean - 1) < 0.01
    ball = fc.RigidBody(fc.Sphere(5.0), pose=fc.Pose(translation=(0.28, 2.0, 2.0)))
    result = fc.Scene([local, ball], [fc.Contact(local, ball)]).solve(forces={ball: (0.0, 0.0, -1e-3)})
    assert result.residuals().worst < 1e-8


@pytest.mark.full
def test_uniform_pressure_displaces_the_mesh_as_finite_elements_say() -> None:
    """Uniform pressure over the window, on cells and on the faces that it covers: alike, to the error of the mesh."""
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (12, 12, 6))
    patch = fc.pick.box((1.3, 1.3, 1.9), (2.7, 2.7, 2.1))
    body = fc.ElasticBody(mesh.with_boundary("patch", patch), SOLID, supports={"bottom": "xyz"}, name="block")
    local = fc.LocalBody(body, (2.0, 2.0, 2.0), 4 / 3, (8, 8))
    cells = sp.csr_matrix((-np.ones(64), (np.arange(64), 3 * np.arange(64) + 2)), shape=(64, local.n_dofs))
    found = local._at_points(local.displacement(cells, np.full(64, 0.1 * (4 / 3) ** 2 / 64), None))
    none = sp.csr_matrix((1, body.n_dofs))
    expected = body.displacement(none, np.zeros(1), body._boundary_traction("patch", lambda x, n: -0.1 * n)).reshape(
        -1, 3
    )
    assert np.abs(found - expected).max() < 0.03 * np.abs(expected).max()
    away = np.linalg.norm(mesh.points - [2.0, 2.0, 2.0], axis=1) > 1.5
    assert np.abs(found - expected)[away].max() < 0.003 * np.abs(expected).max()


@pytest.mark.parametrize("driven", ["motion", "force"])
def test_a_floating_body_touches_where_its_mean_is_held(driven: str) -> None:
    """Its nodes give another mean than Betti's theorem, by 3e-4 here; gaps and motions are those of the problem."""
    local = fc.LocalBody(block(supports={}), (2.0, 2.0, 2.0), 1.0, (24, 24))
    ball = fc.RigidBody(fc.Sphere(10.0), pose=fc.Pose(translation=(2.0, 2.0, 2.0)))
    scene = fc.Scene([local, ball], [fc.Contact(local, ball)])
    held, lift = dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), 0.0), 0.005 if driven == "motion" else 0.0
    forces = {} if driven == "motion" else {ball: (0.0, 0.0, -0.006)}
    result = scene.solve(forces, motions={local: {**held, "z": lift}}, finite_motion=False)
    (contact,) = result.contacts
    assert np.abs(contact.gap[contact.active]).max() < 1e-10 * result._state.scale
    assert result.residuals().worst < 1e-10
    assert np.allclose(result.rigid_motion(local).translation, [0, 0, lift], atol=1e-15)
