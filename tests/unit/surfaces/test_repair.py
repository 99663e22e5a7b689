"""Repair of surfaces: slivers, holes, noise and size, each with its figures, and what stays as it is."""

import itertools

import meshio
import numpy as np
from refusals import refused
from test_solid import geodesic, surface, turned, volume_of_triangles

import fecontact as fc
from fecontact.mesh.mending import BACK, SLIVER, TOWARDS, _measured, smoothed, without_slivers


def faulty_ball():
    """A ball with a cap, a cap without any height, a needle, a facet that is turned, one twice and a lost point."""
    points, triangles = geodesic(6)
    a, b, c = triangles[10]
    triangles = [t for k, t in enumerate(triangles.tolist()) if k != 10]
    # a facet divided at a point nearly, and one exactly, on its side
    new = len(points)
    flat = 0.5 * (points[a] + points[b]) + 1e-5 * (points[c] - points[a])
    triangles += [[a, b, new], [b, c, new], [c, a, new]]
    d, e, f = triangles[200]
    del triangles[200]
    triangles += [[d, e, new + 1], [e, f, new + 1], [f, d, new + 1]]
    exact = 0.5 * (points[d] + points[e])
    # a corner that is two: a needle on either side of the side between them
    triangles = np.array(triangles)
    centre = 100
    around = np.flatnonzero((triangles == centre).any(axis=1))
    first = triangles[around[0]]
    g, h = (first[(list(first).index(centre) + k) % 3] for k in (1, 2))
    fan = around[0]
    triangles[fan][triangles[fan] == centre] = new + 2
    twin = points[centre] + 1e-4 * (points[g] + points[h] - 2 * points[centre])
    extra = [[centre, g, new + 2], [centre, new + 2, h]]
    points = np.concatenate([points, [flat, exact, twin, [5.0, 5.0, 5.0]]])
    triangles = np.concatenate([triangles, extra, triangles[50:51]])
    triangles[70] = triangles[70][::-1]
    return points, triangles


def test_slivers_copies_and_turned_facets_are_mended(tmp_path):
    points, triangles = faulty_ball()
    meshio.Mesh(points, [("triangle", triangles)]).write(tmp_path / "scan.off")
    read = fc.read_surface(tmp_path / "scan.off")
    assert np.sort(_measured(read.points, read.facets[:, :3])[1])[1] < 1e-4
    mended = fc.repair_surface(tmp_path / "scan.off", scale=1e-3)
    assert mended.is_closed
    x, t = mended.points, mended.facets[:, :3]
    assert (mended.facets[:, 2] == mended.facets[:, 3]).all()
    assert _measured(x, t)[1].min() > SLIVER
    whole = volume_of_triangles(*geodesic(6))
    assert abs(volume_of_triangles(x, t) / (1e-9 * whole) - 1) < 1e-3
    said = " ".join(mended.notes)
    for words in ("scan.off: ", "facets were turned to face", "are there again: each", "sliver facets were mended"):
        assert words in said, said


def test_good_facets_are_left_alone():
    """The other side of the guard: nothing is said or moved, and all corners keep their order."""
    points, triangles = geodesic(4)
    same = fc.repair_surface(surface(points, triangles), holes=10)
    assert same.notes == ()
    assert (same.points == points).all()
    assert (same.facets[:, :3] == triangles).all()


def test_caps_are_swapped_in_any_unit():
    x = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 1e-3, 0]])
    t = np.array([[0, 1, 4], [1, 0, 3], [4, 1, 2], [0, 4, 2]])
    for scale in (1.0, 1e-6):
        new, mended = without_slivers(scale * x, t)[1:]
        assert mended == 1
        assert sorted(map(sorted, new[:2].tolist())) == [[0, 3, 4], [1, 3, 4]]


def test_small_holes_are_filled_and_others_stay():
    points, triangles = geodesic(6)
    hub = int(np.argmax(points[:, 2]))
    small = np.flatnonzero((triangles == np.argmin(points[:, 2])).any(axis=1))
    ring = triangles[(triangles == hub).any(axis=1)]
    large = np.flatnonzero(np.isin(triangles, ring).any(axis=1))
    open_ball = np.delete(triangles, np.union1d(small, large), axis=0)
    some = fc.repair_surface(surface(points, open_ball), holes=4)
    assert not some.is_closed
    assert "1 hole was filled, facets more: 2" in some.notes[-1]
    every = fc.repair_surface(surface(points, open_ball), holes=20)
    assert every.is_closed
    # flat lids on rims of the ball
    assert 0.9 < volume_of_triangles(every.points, every.facets[:, :3]) / volume_of_triangles(points, triangles) < 1
    # two that meet in a corner have one rim, which meets itself
    other = next(k for k in small if len(np.intersect1d(triangles[k], triangles[small[0]])) == 1)
    left = fc.repair_surface(surface(points, np.delete(triangles, [small[0], other], axis=0)), holes=20)
    assert not left.is_closed


def test_a_step_damps_a_wave_as_taubin_says():
    """Source: Taubin (1995), eq. 6: ((1 - lambda k) (1 - mu k))^n for waves of k, here of the icosahedron's corners.

    Its adjacency has the eigenvalue sqrt(5) for them (Biggs, Algebraic Graph Theory), so k = 1 - sqrt(5) / 5.
    """
    g = (1 + 5**0.5) / 2
    x = np.array([[s * a, t * b, 0] for s in (1, -1) for t in (1, -1) for a, b in ((1, g),)])
    x = np.concatenate([np.roll(x, k, axis=1) for k in range(3)])
    near = np.linalg.norm(x[:, None] - x, axis=2) < 2.1
    t = np.array([p for p in itertools.combinations(range(12), 3) if near[np.ix_(p, p)].all()])
    assert len(t) == 20
    k = 1 - 5**0.5 / 5
    assert np.allclose(smoothed(x, t, 3), ((1 - TOWARDS * k) * (1 - BACK * k)) ** 3 * x, rtol=1e-12)


def test_noise_goes_and_the_size_stays():
    points, triangles = geodesic(16)
    noise = 0.01 * np.random.default_rng(5).standard_normal(len(points))
    rough = surface(points * (1 + noise)[:, None], triangles)
    smooth = fc.repair_surface(rough, smoothing=10)
    radius = np.linalg.norm(smooth.points, axis=1)
    assert radius.std() < 0.4 * 0.01
    assert abs(radius.mean() - 1) < 0.005
    said = smooth.notes[-1]
    assert "smoothed by 10 steps, nodes by up to 0.0" in said
    assert "its volume changed by" in said


def test_facets_of_a_size_on_an_open_surface():
    """Source: a spherical cap; its rim stays where it is, and so does its outside, inwards here."""
    points, triangles = turned(*geodesic(9))
    cap = triangles[points[triangles][:, :, 2].mean(axis=1) > 0.3]
    dome = fc.repair_surface(surface(points, cap), size=0.25)
    side = np.linalg.norm(dome.points[dome.facets[:, 1]] - dome.points[dome.facets[:, 0]], axis=1)
    assert abs(np.median(side) / 0.25 - 1) < 0.15
    rim = fc.surfaces.Facets(dome).facet_surface.rim_nodes
    on_sphere = np.linalg.norm(dome.points[dome.nodes], axis=1)
    assert np.abs(on_sphere[~rim[dome.nodes]] - 1).max() < 2e-3
    lowest = points[np.unique(cap), 2].min()
    assert dome.points[dome.nodes, 2].min() > lowest - 1e-9
    inwards = np.einsum("ni,ni->n", dome.normals[dome.nodes], dome.points[dome.nodes])
    assert (inwards < -0.9).all()
    assert "its area changed by" in dome.notes[-1]


def test_what_cannot_be_repaired_is_refused(tmp_path):
    x = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]])
    meshio.Mesh(x, [("triangle", [[0, 1, 2], [0, 1, 3], [0, 1, 4]])]).write(tmp_path / "fin.off")
    for call, words in (
        (lambda: fc.repair_surface(tmp_path / "fin.off"), ("unclear-outside",)),
        (lambda: fc.repair_surface(tmp_path / "deck.inp"), ("file-type", "stl")),
        (lambda: fc.repair_surface(tmp_path / "none.stl"), ("no-file",)),
        (lambda: fc.repair_surface(surface(*geodesic(2)), holes=-1), ("not-whole", "Holes")),
        (lambda: fc.repair_surface(surface(*geodesic(2)), size=0.0), ("not-positive", "size")),
    ):
        with refused(fc.FecontactError, *words):
            call()
