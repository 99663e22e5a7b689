"""Rigid surfaces: heights, feet, roughness, files."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.surfaces import (
    Cone,
    Cylinder,
    Ellipsoid,
    FlatPunch,
    FunctionSurface,
    HeightMap,
    Paraboloid,
    Torus,
    detrend,
    fill_holes,
    read_topography,
    self_affine,
)

SHAPES = [
    fc.Sphere(2.0),
    Paraboloid(2.0),
    Paraboloid(2.0, 5.0),
    Cylinder(2.0),
    Cone(0.3),
    FlatPunch(sides=(4.0, 4.0)),
    Ellipsoid((2.0, 3.0, 1.0)),
    Torus(ring=2.0, tube=1.5),
    FunctionSurface(lambda x, y: 0.1 * np.sin(x) * np.cos(y) + 0.1, size=1.0),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_feet_lie_on_the_surface_along_the_normal(shape):
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-0.6, 0.6, (40, 2)) + 0.7, rng.uniform(-0.3, 0.3, 40)])
    points[:, 0] -= 0.4
    projection = shape.project(points)
    assert not projection.outside.any()
    # heights of a function are differentiated numerically, which moves a foot by 1e-8 but leaves it on the surface
    height = shape.heights(projection.points[:, 0], projection.points[:, 1])
    assert np.abs(height - projection.points[:, 2]).max() < 1e-7
    assert np.abs(points - projection.points - projection.gap[:, None] * projection.normals).max() < 1e-12
    assert np.abs(np.linalg.norm(projection.normals, axis=1) - 1).max() < 1e-12
    # positive outside: below the surface
    below = points[:, 2] < shape.heights(points[:, 0], points[:, 1])
    assert (np.sign(projection.gap) == np.where(below, 1.0, -1.0)).all()


def test_heights_keep_their_digits_near_the_pole():
    for shape in (fc.Sphere(1.0), Ellipsoid((1.0, 1.0, 1.0)), Cylinder(1.0)):
        assert abs(float(shape.heights(np.array(1e-9), np.array(0.0))) / 5e-19 - 1) < 1e-12


def test_height_map_on_its_own_grid_and_between():
    x, y = (np.arange(20) - 9.5) / 20, (np.arange(30) - 14.5) / 30
    surface = HeightMap(5.0 + x[:, None] ** 2 + 2 * y[None, :] ** 2, (1.0, 1.0))
    assert surface.heights(x[:, None], y[None, :]).min() == 0.0
    between = surface.heights(np.array([0.1]), np.array([0.2]))
    lowest = 5.0 + x[9] ** 2 + 2 * y[14] ** 2
    assert abs(float(between[0]) - (5.0 + 0.01 + 0.08 - lowest)) < 1e-12  # a cubic spline holds a parabola
    assert np.isinf(surface.heights(np.array([0.6]), np.array([0.0]))[0])
    projection = surface.project(np.array([[0.1, 0.1, -0.2]]))
    assert abs(np.linalg.norm(projection.points - [0.1, 0.1, -0.2]) - abs(projection.gap[0])) < 1e-12


@pytest.mark.parametrize("target", [{"rms_height": 0.02}, {"rms_slope": 0.3}])
def test_rough_surface_achieves_what_was_asked(target):
    rough = self_affine((96, 128), (1.0, 2.0), hurst=0.7, seed=5, roll_off=0.5, **target)
    kx, ky = 2 * np.pi * np.fft.fftfreq(96, 1 / 96), 2 * np.pi * np.fft.fftfreq(128, 2 / 128)
    spectrum = np.fft.fft2(rough.z)
    slopes = [np.fft.ifft2(1j * k * spectrum).real for k in (kx[:, None], ky[None, :])]
    measured = {"rms_height": rough.z.std(), "rms_slope": np.sqrt(sum((s**2).mean() for s in slopes))}
    for name, value in target.items():
        assert abs(measured[name] / value - 1) < 1e-10
    assert abs(measured["rms_height"] / rough.rms_height - 1) < 1e-10
    assert abs(measured["rms_slope"] / rough.rms_slope - 1) < 1e-10


def test_rough_surface_by_seed_and_spectrum():
    make = lambda seed: self_affine((256, 256), (1.0, 1.0), hurst=0.8, seed=seed, rms_height=1.0).z  # noqa: E731
    assert np.array_equal(make(1), make(1))
    assert not np.array_equal(make(1), make(2))
    power = np.abs(np.fft.fft2(make(1))) ** 2
    k = np.hypot(*np.meshgrid(*[np.fft.fftfreq(256, 1 / 256)] * 2))
    rings = [power[(k > r / 1.2) & (k <= r * 1.2)].mean() for r in (8, 48)]
    # slope -2 - 2 H over a factor of 6; each ring averages hundreds of waves
    assert abs(np.log(rings[1] / rings[0]) / np.log(6) + 3.6) < 0.2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"hurst": 1.2, "rms_height": 1.0}, ("no-share", "The Hurst exponent")),
        ({"hurst": 0.5}, ("one-of", "rms_height=, rms_slope=")),
        ({"hurst": 0.5, "rms_height": -1.0}, ("not-positive", "The rms_height")),
        ({"hurst": 0.5, "rms_height": 1.0, "longest": 0.01}, ("no-wave",)),
    ],
)
def test_bad_roughness(options, message):
    with refused(InputError, *message):
        self_affine((16, 16), (1.0, 1.0), seed=0, **options)


def test_holes_do_not_count_in_a_trend_and_are_filled_by_harmonic_heights():
    """A plane is harmonic: what is taken out of it comes back, also over a hole of many cells."""
    x, y = np.meshgrid(np.arange(9.0), np.arange(7.0), indexing="ij")
    plane = 3.0 + 2.0 * x - y
    holed = plane.copy()
    holed[2:5, 2:4] = holed[7, 5] = np.nan
    left = detrend(holed, "plane")
    assert (np.isnan(left) == np.isnan(holed)).all()
    assert np.nanmax(np.abs(left)) < 1e-12  # rounding of heights up to 20
    assert np.abs(fill_holes(holed) - plane).max() < 1e-12
    rim = plane.copy()
    rim[0] = np.nan
    assert plane.min() <= fill_holes(rim).min()
    assert np.isclose(fill_holes(rim)[0], rim[1]).mean() < 1  # smooth along the rim, too
    with refused(InputError, "few-heights"):
        detrend(np.full((3, 3), np.nan))
    with refused(InputError, "no-heights"):
        fill_holes(np.full((3, 3), np.nan))


@pytest.mark.parametrize(("trend", "power"), [("mean", 0), ("plane", 1), ("quadratic", 2)])
def test_detrend(trend, power):
    x, y = np.meshgrid(np.arange(6.0), np.arange(9.0), indexing="ij")
    assert np.abs(detrend(2.0 + (x - 2 * y) ** power if power else np.full((6, 9), 3.0), trend)).max() < 1e-10
    with refused(InputError, "unknown-name", "trend"):
        detrend(x, "cubic")


def test_topography_files(tmp_path):
    z = np.arange(12.0).reshape(3, 4) / 16
    x, y = np.meshgrid([0.0, 0.5, 1.0], [0.0, 1.0, 2.0, 3.0], indexing="ij")
    np.save(tmp_path / "a.npy", z)
    np.savetxt(tmp_path / "a.txt", z.T)
    np.savetxt(tmp_path / "a.csv", z.T, delimiter=",")
    rows = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    np.savetxt(tmp_path / "a.xyz", np.random.default_rng(0).permutation(rows))
    header = "ncols 3\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 2\nNODATA_value -9999\n"
    lines = "\n".join(" ".join(map(str, row)) for row in z.T[::-1])
    (tmp_path / "a.asc").write_text(header + lines)
    for suffix in ("npy", "txt", "csv", "xyz", "asc"):
        assert np.array_equal(read_topography(tmp_path / f"a.{suffix}").z, z), suffix
    assert read_topography(tmp_path / "a.xyz").size == (1.5, 4.0)
    assert read_topography(tmp_path / "a.asc").size == (6.0, 8.0)


def test_heights_in_another_unit_than_the_sides_are_refused_not_guessed(tmp_path):
    z = 40 * np.random.default_rng(1).normal(size=(8, 6))
    z[2, 3], z[5] = np.nan, np.inf
    np.save(tmp_path / "nm.npy", z)
    (tmp_path / "nm.asc").write_text("ncols 2\nnrows 2\ncellsize 0.1\n0 30\n10 5\n")
    # over 0.1, they rise by -5 and 30 along x, -10 and 25 along y
    with refused(InputError, "heights-unit", "'nm.asc'", "287", "0.2"):
        read_topography(tmp_path / "nm.asc")
    assert np.allclose(read_topography(tmp_path / "nm.asc", 1e-6).z * 1e6, [[10, 0], [5, 30]])
    assert read_topography(tmp_path / "nm.asc", 1.0).z.max() == 30  # as steep, by the user's word
    assert read_topography(tmp_path / "nm.npy").size is None  # nothing to compare with
    with refused(InputError, "heights-unit"):
        read_topography(tmp_path / "nm.npy", size=(1.0, 1.0))
    assert read_topography(tmp_path / "nm.npy", size=(1000.0, 1000.0)).size == (1000.0, 1000.0)
    for bad in (0.0, -1.0, np.nan):
        with refused(InputError, "not-positive", "The unit of the heights"):
            read_topography(tmp_path / "nm.npy", bad)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.stl", "", ("input", "Cannot read")),
        ("a.asc", "ncols 2\n1 2\n", ("unreadable", "lacks")),
        ("a.xyz", "0 0 1\n1 0 1\n0 1 1\n", ("unreadable", "3 points are no full grid of 2 x 2")),
        ("a.xyz", "0 0 1\n1 0 1\n5 0 1\n0 1 1\n", ("unreadable", "equal steps")),
        ("a.txt", "a b\n", ("unreadable",)),
        ("a.txt", "1 2 3\n", ("input", "no grid")),
    ],
)
def test_bad_topographies(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with refused(InputError, *message):
        read_topography(tmp_path / name)
    with refused(InputError, "no-file"):
        read_topography(tmp_path / "missing.npy")


@pytest.mark.parametrize(
    "make",
    [
        lambda: Paraboloid(-1.0),
        lambda: Cylinder(0.0),
        lambda: Cylinder(1.0, length=-1.0),
        lambda: Cone(2.0),
        lambda: FlatPunch(),
        lambda: FlatPunch(radius=-1.0),
        lambda: Ellipsoid((1.0, 1.0)),
        lambda: Torus(1.0, 2.0),
        lambda: HeightMap(np.full((3, 3), np.nan), (1.0, 1.0)),
        lambda: HeightMap(np.zeros(3), (1.0, 1.0)),
        lambda: HeightMap(np.zeros((3, 3)), (1.0, -1.0)),
        lambda: FunctionSurface("x"),
    ],
)
def test_bad_shapes(make):
    with pytest.raises(InputError):
        make()


def test_a_map_of_three_by_three_heights_is_a_parabola_and_projects_as_one():
    """A spline of the second order is the parabola itself; its second derivatives are differences."""
    x = np.array([-1.0, 0.0, 1.0])
    heights = fc.surfaces.HeightMap(x[:, None] ** 2 / 8 + x[None, :] ** 2 / 12, (3.0, 3.0))
    points = np.array([[0.3, -0.4, 0.5], [0.0, 0.0, -0.2], [0.8, 0.7, 0.0]])
    found, exact = heights.project(points), fc.surfaces.Paraboloid(4.0, 6.0).project(points)
    assert np.allclose(found.points, exact.points, atol=1e-9)
    assert np.allclose(found.gap, exact.gap, atol=1e-9)


def test_a_surface_that_ends_is_one_where_it_is():
    # a paraboloid with a rim presses as the whole one does while it touches inside the rim; no warning of numpy's
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (6, 6, 2)).translated((-0.5, -0.5, -1.0))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"bottom": "xyz"})
    pressures = []
    for rim in (0.35, np.inf):
        heights = FunctionSurface(lambda x, y, rim=rim: np.where(np.hypot(x, y) < rim, (x**2 + y**2) / 2, np.inf), 1.0)
        ball = fc.RigidBody(heights)
        result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(forces={ball: (0, 0, -0.01)})
        pressures.append(result.contacts[0].max_pressure)
    assert abs(pressures[0] / pressures[1] - 1) <= 1e-9
