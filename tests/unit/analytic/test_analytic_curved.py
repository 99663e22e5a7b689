import numpy as np
import pytest
from refusals import refused
from scipy.integrate import dblquad

from fecontact import InputError, Material
from fecontact.analytic import boussinesq, curvature_field, curved_kernel
from fecontact.analytic.face_loads import FaceLoads, fields

CURVATURE = np.array([[1.3, 0.4], [0.4, -0.5]])
LOADS = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.3, -0.7, 0.5)]


def _bent(load, material, curvature=CURVATURE):
    return lambda p: curvature_field.fields(p, force=load, curvature=curvature, length=0.7, material=material)


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.3, 0.49])
@pytest.mark.parametrize("load", LOADS)
def test_curvature_field_is_elastic_and_in_equilibrium(nu, load, hooke, divergence):
    material = Material(2.0, nu)
    field = _bent(load, material)
    for place in ([0.5, -0.3, 0.4], [0.0, 0.0, 1.0], [-0.8, 0.5, -0.2]):
        point = np.array(place)
        # Fourth-order differences, step 1e-3, of fields that vary over 0.6; the bulk modulus multiplies their error.
        expected = hooke(lambda p: field(p)[0], point, material, 1e-3)
        np.testing.assert_allclose(field(point)[1], expected, rtol=0, atol=1e-9)
        np.testing.assert_allclose(divergence(lambda p: field(p)[1], point, 1e-3), 0.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("load", LOADS)
def test_only_a_bounded_traction_is_left_on_the_curved_face(nu, load):
    material = Material(2.0, nu)
    angle = 2 * np.pi * np.arange(12) / 12

    def left(r):
        planar = r * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        slope = planar @ CURVATURE
        points = np.concatenate([planar, (planar * slope).sum(axis=1, keepdims=True) / 2], axis=1)
        normals = np.concatenate([slope, -np.ones((12, 1))], axis=1)
        plane = boussinesq.stress(points, force=load, material=material, above=0.5)
        bent = _bent(load, material)(points)[1]
        return [np.abs(np.einsum("nij,nj->ni", s, normals)).max() for s in (plane, plane + bent)]

    (far_plane, far), (near_plane, near) = left(1e-3), left(1e-5)
    assert near_plane > 50 * far_plane  # as 1/r, a hundred times
    assert near == pytest.approx(far, rel=0.02)  # the next term is of the order r


def test_length_of_the_logarithm_is_a_translation():
    points = np.random.default_rng(3).uniform(0.1, 1.0, (6, 3))
    found = [
        curvature_field.fields(points, force=LOADS[3], curvature=CURVATURE, length=scale, material=Material(2.0, 0.3))
        for scale in (1.0, 5.0)
    ]
    np.testing.assert_array_equal(found[0][1], found[1][1])
    shift = found[1][0] - found[0][0]
    assert np.linalg.norm(shift[0]) > 0.01
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), rtol=0, atol=1e-15)


def test_fields_of_a_curved_face_do_not_depend_on_the_axes():
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    place, normal, force = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([[0.3, -0.2, 1.0]])
    curvature = np.zeros((1, 3, 3))
    curvature[0, :2, :2] = CURVATURE
    points = np.array([[0.5, -0.3, 0.4], [0.1, 0.2, 0.3]])
    there = FaceLoads(place, normal, force, curvature, 1.0)
    here = FaceLoads(place, normal @ turn.T, force @ turn.T, turn @ curvature @ turn.T, 1.0)
    u, s = fields(points, there, Material(2.0, 0.3))
    v, t = fields(points @ turn.T, here, Material(2.0, 0.3))
    np.testing.assert_allclose(v, u @ turn.T, rtol=0, atol=1e-14)
    np.testing.assert_allclose(t, turn @ s @ turn.T, rtol=0, atol=1e-13)


def _on_quadric(place, offset):
    """A load along z on the face z = x K x/2 below a plane, at a place that inclines; points beside it."""
    slope = CURVATURE @ place
    tangents = np.concatenate([np.eye(2), slope[:, None]], axis=1)
    dual = np.linalg.inv(tangents @ tangents.T) @ tangents
    tensor = dual.T @ (CURVATURE / np.sqrt(1 + slope @ slope)) @ dual
    around = place + offset
    points = np.concatenate([around, np.einsum("ni,ij,nj->n", around, CURVATURE, around)[:, None] / 2], axis=1)
    own = np.append(place, place @ CURVATURE @ place / 2)[None]
    normal = np.append(-slope, 1.0)[None]
    return points, FaceLoads(own, normal, np.array([[0.0, 0.0, 1.0]]), tensor[None], 0.7)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
def test_kernel_is_what_the_fields_have_at_the_face(nu):
    """At the load the fields and the kernel differ by slope^2 times curvature, at a plane place by nothing."""
    material = Material(2.0, nu)
    angle = 2 * np.pi * np.arange(12) / 12
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    for slope, limit in ((0.0, 1e-5), (0.05, 6e-3)):
        points, load = _on_quadric(np.array([slope, -slope / 2]), 1e-4 * ring)
        u = fields(points, load, material)[0][0, :, 2]
        offset = points - load.places[0]
        kernel = curved_kernel.displacement(offset, curvature=CURVATURE, length=0.7, material=material)
        np.testing.assert_allclose(u, kernel, rtol=0, atol=limit)
    plane = curved_kernel.displacement(offset, curvature=np.zeros((2, 2)), length=0.7, material=material)
    level = curved_kernel.displacement(offset * [1, 1, 0], curvature=CURVATURE, length=0.7, material=material)
    inclined = abs(3 * nu - 1) / (4 * np.pi * material.shear_modulus) * 0.05**2 / 1e-4
    assert np.ptp(u - level) > 0.5 * inclined > 6e-3  # without the slopes: of the order slope^2/distance
    assert np.abs(u - plane).max() > 0.03 or nu == 0.49  # without the curvature: its logarithm


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
def test_logarithm_is_that_of_the_exact_series_of_a_ball(nu):
    """Radial displacement at the order n of a ball of unit radius under the radial pressures P_n.

    Two solutions regular at the centre, grad(r^n P_n) and r^2 grad(r^n P_n) + alpha x r^n P_n, without shear at the
    surface. A. E. H. Love, Mathematical Theory of Elasticity, 1927, arts. 172-173.
    """
    material = Material(2.0, nu)
    mu, lam = material.shear_modulus, material.lame
    n = np.array([4e3, 8e3, 16e3])
    alpha = -2 * (n * lam + (3 * n + 1) * mu) / ((n + 3) * lam + (n + 5) * mu)
    normal = 2 * mu * n * (n - 1), lam * (2 * n + alpha * (n + 3)) + 2 * mu * (n + alpha) * (n + 1)
    shear = 2 * n - 2, 2 * n + alpha
    share = -shear[1] / shear[0]
    radial = (share * n + n + alpha) / (share * normal[0] + normal[1])
    load = (2 * n + 1) / (4 * np.pi) * radial
    powers = np.linalg.solve(n[:, None] ** -np.arange(3), load)
    # sum of P_n is 1/(2 sin t/2), sum of P_n/n is -log(sin t/2 (1 + sin t/2)); 2 sin t/2 is the distance
    assert powers[0] == pytest.approx((1 - nu) / (2 * np.pi * mu), rel=1e-9)
    assert powers[1] == pytest.approx((1 - 2 * nu) ** 2 / (4 * np.pi * mu), rel=1e-4)  # of the order 1/n^2 left out
    distance = np.array([[1e-3, 0, 0], [2e-3, 0, 0]])
    bent = [
        np.diff(curved_kernel.displacement(distance, curvature=c * np.eye(2), length=1.0, material=material))
        for c in (1, 0)
    ]
    assert bent[0] - bent[1] == pytest.approx(-powers[1] * np.log(2), rel=1e-4)


def test_cells_have_the_integrals_of_the_kernel():
    material, cell, bend = Material(2.0, 0.1), (0.1, 0.07), (1.2, -0.4)
    table = curved_kernel.bent_table((3, 3), cell, curvature=bend, length=0.3, material=material)

    def kernel(x, y, curvature):
        return curved_kernel.displacement([x, y, 0.0], curvature=curvature, length=0.3, material=material)

    for i, j in ((0, 0), (0, 2), (1, 0), (2, 2)):
        parts = [
            dblquad(
                lambda y, x: float(kernel(x, y, np.diag(bend)) - kernel(x, y, np.zeros((2, 2)))),
                (i + a) * cell[0],
                (i + a + 0.5) * cell[0],
                (j + b) * cell[1],
                (j + b + 0.5) * cell[1],
                epsabs=1e-12,
            )[0]
            for a in (-0.5, 0.0)
            for b in (-0.5, 0.0)
        ]
        assert table[i, j] == pytest.approx(sum(parts), abs=1e-11)


@pytest.mark.parametrize("nu", [0.0, 0.49])
def test_slopes_of_cells_give_the_displacement_of_a_tilted_plane(nu):
    """Uniform pressure on a square of an inclined plane: convolutions against the kernel's integral."""
    material, n, slope = Material(2.0, nu), 41, np.array([0.015, 0.025])
    cell = (1.0 / n, 1.0 / n)
    along = (np.arange(n) + 0.5) / n - 0.5
    depth = slope[0] * along[:, None] + slope[1] * along
    table = curved_kernel.inclined_table((n, n), cell, material)
    reach = np.abs(np.arange(n) - n // 2)
    T, middle = table[reach[:, None], reach], depth[n // 2, n // 2]
    found = (T * (middle - depth) ** 2).sum() + curved_kernel.inclined_own(slope, cell, material)
    t, w = np.polynomial.legendre.leggauss(40)
    angle, w = (t + 1) * np.pi / 8, w * np.pi / 8  # eighths of the square; along the radius the kernel is 1/r
    total = 0.0
    for turn in range(8):
        direction = np.stack([np.cos(angle + turn * np.pi / 4), np.sin(angle + turn * np.pi / 4)], axis=-1)
        reach_out = 0.5 / np.abs(direction).max(axis=1)
        offset = np.concatenate([direction, (direction @ slope)[:, None]], axis=1)
        options = {"curvature": np.zeros((2, 2)), "length": 1.0, "material": material}
        exact = curved_kernel.displacement(offset, **options)
        flat = curved_kernel.displacement(offset * [1, 1, 0], **options)
        total += w @ (reach_out * (exact - flat))
    assert found == pytest.approx(total, rel=0.005)  # slope^4 beside slope^2, 0.2 %, and cells
    assert abs(total) > 5e-5


def test_bad_input_is_named():
    material = Material(2.0, 0.3)
    with refused(InputError, "input", "not over it"):
        curvature_field.fields([0, 0, -1.0], force=(0, 0, 1), curvature=np.eye(2), length=1.0, material=material)
    with refused(InputError, "curvature-shape", "(2,)"):
        curvature_field.fields([0, 0, 1.0], force=(0, 0, 1), curvature=np.ones(2), length=1.0, material=material)
    with refused(InputError, "input", "beside the load"):
        curved_kernel.displacement([0, 0, 0.0], curvature=np.eye(2), length=1.0, material=material)
    with refused(InputError, "curvature-shape", "(2,)"):
        curved_kernel.displacement([1, 0, 0.0], curvature=np.ones(2), length=1.0, material=material)
    one = np.array([[0.0, 0.0, 1.0]])
    with refused(InputError, "input", "length="):
        FaceLoads(0 * one, one, one, np.zeros((1, 3, 3)))
    with refused(InputError, "input", "(1, 3, 3)"):
        FaceLoads(0 * one, one, one, np.zeros((2, 3, 3)), 1.0)
