"""Ready-made shapes: volumes against closed forms, boundaries where they should lie, valid at every grading."""

import math

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError, merge
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.facets import facet_integrals

shapes = fc.shapes
PARTS = {"quarter": 1 / 4, "half": 1 / 2, "full": 1.0}
# quadratic sides on arcs of at most 22.5 degrees (two elements per 45 degrees); measured 5.4e-4 and below
CURVED = 6e-4
# straight sides of hex8 on the same arcs; measured 6.2 percent and below
STRAIGHT = 0.07
OFF = {"hex8": STRAIGHT, "hex20": CURVED, "hex27": CURVED}


def area(mesh, name):
    _, _, dA = facet_integrals(mesh.points, mesh.face_nodes(mesh.faces(name)))
    return dA.sum(axis=(0, 1))


def radius_from(mesh, name, centre):
    return np.linalg.norm(mesh.points[mesh.boundary_nodes(name)] - centre, axis=1)


def all_outer_faces_are_named(mesh):
    named = sorted(tuple(f) for n in mesh.boundaries for f in mesh.faces(n).tolist())
    return named == sorted(map(tuple, mesh.outer_faces.tolist()))


def closed(mesh):
    """Vector area of all outer faces, zero for a body without holes; all normals point outwards."""
    _, x, dA = facet_integrals(mesh.points, mesh.face_nodes(mesh.outer_faces))
    return dA.sum(axis=(0, 1)), np.einsum("fqi,fqi->", x, dA) / 3


BUILD = {
    "half_sphere": lambda **o: shapes.half_sphere(2.0, contact_radius=0.05, level=1, **o),
    "cap": lambda **o: shapes.cap(5.0, 1.0, 1.2, contact_radius=0.2, level=1, **o),
    "cylinder": lambda **o: shapes.cylinder(1.0, 1.5, contact_radius=0.2, level=1, **o),
    "thick_ring": lambda **o: shapes.thick_ring(1.0, 2.0, 0.5, (4, 2, 1), **o),
    "sphere": lambda **o: shapes.sphere(2.0, contact_radius=0.05, level=1, **o),
}
VOLUME = {
    "half_sphere": 2 / 3 * math.pi * 8,
    # the cylinder below the rim and the spherical segment above it, of height h
    "cap": math.pi * (1.2 - (h := 5 - math.sqrt(24))) + math.pi * h**2 * (15 - h) / 3,
    "cylinder": math.pi * 1.5,
    "thick_ring": math.pi * 3 * 0.5,
    "sphere": 4 / 3 * math.pi * 8,
}


@pytest.mark.by_day(
    "thick_ring-quarter-hex20",
    "thick_ring-half-hex27",
    "thick_ring-full-hex8",
    "half_sphere-quarter-hex20",
    "cap-quarter-hex8",
    "cylinder-quarter-hex8",
    "sphere-quarter-hex8",
    "sphere-half-hex20",
    "half_sphere-full-hex8",
)
@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
@pytest.mark.parametrize("sector", list(PARTS))
@pytest.mark.parametrize("name", list(BUILD))
def test_shape_is_valid_closed_named_and_of_the_right_volume(name, sector, element):
    mesh = BUILD[name](sector=sector, element=element)
    check_mesh(mesh)
    assert all_outer_faces_are_named(mesh)
    volume = moments_of_volume(mesh)[0]
    exact = VOLUME[name] * PARTS[sector]
    assert abs(volume / exact - 1) < OFF[element]
    vector, by_divergence = closed(mesh)
    assert np.abs(vector).max() < 1e-12 * exact ** (2 / 3)
    # the divergence theorem holds on the mesh itself; curved faces are of degree up to six, integrated to five
    assert abs(by_divergence / volume - 1) < 1e-6


@pytest.mark.parametrize("name", ["half_sphere", "cap", "thick_ring"])
@pytest.mark.parametrize("sector", ["quarter", "half"])
def test_symmetry_planes(name, sector):
    mesh = BUILD[name](sector=sector)
    assert ("sym_x" in mesh.boundaries) == (sector == "quarter")
    size = np.ptp(mesh.points, axis=0).max()
    for plane, axis in (("sym_x", 0), ("sym_y", 1)):
        if plane in mesh.boundaries:
            assert np.abs(mesh.points[mesh.boundary_nodes(plane)][:, axis]).max() < 1e-15 * size
            # outwards is towards negative coordinates
            normal = area(mesh, plane)
            assert normal[axis] < 0
            assert np.abs(np.delete(normal, axis)).max() < 1e-12 * size**2


def test_half_sphere_boundaries_lie_where_they_should():
    mesh = shapes.half_sphere(2.0, contact_radius=0.05, level=2, sector="quarter")
    centre = (0, 0, 2.0)
    corners = np.unique(mesh.cells[:, :8])
    for name in ("cap", "flank"):
        on_surface = radius_from(mesh, name, centre)
        assert np.abs(on_surface - 2.0).max() < 1e-3 * 2.0  # quadratic sides over 11 degrees and less
        nodes = np.intersect1d(mesh.boundary_nodes(name), corners)
        assert np.abs(np.linalg.norm(mesh.points[nodes] - centre, axis=1) - 2).max() < 1e-14 * 2
    assert np.abs(mesh.points[mesh.boundary_nodes("base")][:, 2] - 2).max() < 1e-14
    assert mesh.points[mesh.boundary_nodes("cap")][:, 2].max() < 2 * (1 - math.sqrt(0.5)) + 1e-9
    assert (mesh.points[0] == 0).all() or (mesh.points == 0).all(axis=1).sum() == 1


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_a_ball_of_like_cells(element):
    """Its volume and centre, all faces of its surface in one of six equal parts, nodes on the sphere."""
    mesh = shapes.ball(2.0, 4, element=element)
    check_mesh(mesh)
    volume, centre = moments_of_volume(mesh)
    assert abs(volume / (4 / 3 * math.pi * 8) - 1) < {"hex8": 0.08, "hex20": 2e-3, "hex27": 2e-3}[element]
    assert np.abs(centre).max() < 1e-14
    assert np.abs(radius_from(mesh, "surface", 0) - 2).max() < 1e-14
    sixths = [mesh.faces(f"{axis}_{end}") for axis in "xyz" for end in ("min", "max")]
    assert sorted(map(tuple, np.concatenate(sixths).tolist())) == sorted(map(tuple, mesh.outer_faces.tolist()))
    assert mesh.points[mesh.boundary_nodes("y_min")][:, 1].max() < -1.0
    assert np.ptp([np.linalg.norm(area(mesh, f"{axis}_min")) for axis in "xyz"]) < 1e-12


def test_sphere_has_two_caps():
    mesh = BUILD["sphere"](sector="full")
    assert set(mesh.boundaries) == {"cap", "far_cap", "flank"}
    assert mesh.points[mesh.boundary_nodes("far_cap")][:, 2].min() > 2.0
    assert np.abs(moments_of_volume(mesh)[1] - [0, 0, 2]).max() < 1e-12


@pytest.mark.parametrize("level", range(1, 6))
def test_a_ring_lies_at_the_contact_radius(level):
    a = 0.05
    mesh = shapes.quarter_sphere(2.0, contact_radius=a, level=level)
    facets = mesh.face_nodes(mesh.faces("cap"))
    sides = facets[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2)
    r = np.hypot(*mesh.points[sides][..., :2].transpose(2, 0, 1))
    on_edge = (np.abs(r - a) < 1e-12 * a).all(axis=1)
    # every ring side is seen from both of its facets
    assert on_edge.sum() == 2 * 2 * shapes.LEVELS[level].core


@pytest.mark.by_day(every=4)
@pytest.mark.parametrize("sector", ["quarter", "full"])
@pytest.mark.parametrize("ratio", [1e-4, 1e-2, 0.1])
@pytest.mark.parametrize("element", ["hex8", "hex20"])
def test_half_sphere_for_light_and_heavy_loads(ratio, element, sector):
    mesh = shapes.half_sphere(25.0, contact_radius=25.0 * ratio, level=1, sector=sector, element=element)
    check_mesh(mesh)
    assert abs(moments_of_volume(mesh)[0] / (2 / 3 * math.pi * 25**3 * PARTS[sector]) - 1) < OFF[element]


def test_cap_far_below_the_radius_keeps_its_sagitta():
    # the sagitta r^2/2R at r = 1e-6 R is 5e-13 R: R - sqrt(R^2 - r^2) would keep three digits of it
    mesh = shapes.half_sphere(1.0, contact_radius=1e-6, level=1, sector="quarter")
    x = mesh.points[np.intersect1d(mesh.boundary_nodes("cap"), np.unique(mesh.cells[:, :8]))]
    near = (np.hypot(x[:, 0], x[:, 1]) < 2e-6) & (np.hypot(x[:, 0], x[:, 1]) > 0)
    r2 = (x[near, :2] ** 2).sum(axis=1)
    assert np.abs(x[near, 2] / (r2 / 2) - 1).max() < 1e-11


def test_matching_bodies_of_different_size_have_the_same_rings_near_the_contact():
    small, large = (shapes.quarter_sphere(r, contact_radius=0.05, level=1) for r in (2.0, 5.0))
    radii = [np.unique(np.hypot(*m.points[m.boundary_nodes("cap")][:, :2].T).round(12)) for m in (small, large)]
    near = [r[r < 0.2] for r in radii]
    assert np.abs(near[0] - near[1]).max() < 1e-12


def test_block_divisions_by_positions():
    mesh = shapes.block((2.0, 1.0, 1.0), ([0, 0.1, 2.0], 1, (0, 0.9, 1.0)), element="hex8")
    assert np.unique(mesh.points[:, 0]).tolist() == [0, 0.1, 2.0]
    assert len(mesh.cells) == 4


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_divisions_whose_ends_are_off_by_rounding_are_taken(scale):
    # graded towards an end: 1 - cos(0) and the like leave 1e-16 of the size; a thousandth of it is no rounding
    for first, last in [(1.4e-16, 1.0), (-1.4e-16, 1 - 2e-16), (0.0, 1 + 3e-16)]:
        given = scale * np.array([first, 0.3, last])
        mesh = shapes.block((scale, scale, scale), (given, 1, 1), element="hex8")
        assert np.unique(mesh.points[:, 0]).tolist() == [0.0, given[1], scale]
    for wrong in ([1e-3, 0.3, 1.0], [0.0, 0.3, 1.001]):
        with refused(InputError, "divisions", "0"):
            shapes.block((scale, scale, scale), (scale * np.array(wrong), 1, 1))


def test_blocks_can_be_merged_with_a_degenerate_neighbour(degenerate):
    wedge = degenerate("wedge")
    moved = wedge.translated((5.0, 0.0, 0.0))
    assert len(merge([wedge, moved], 1e-9).cells) == 2


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: shapes.block((1.0, -1.0, 1.0), (1, 1, 1)), ("not-positive", "size[1]")),
        (lambda: shapes.block((1.0, 1.0, 1.0), (1, 0, 1)), ("not-whole", "The divisions")),
        (lambda: shapes.block((1.0, 1.0, 1.0), (1, [0, 1, 0.5], 1)), ("divisions", "[0, 1, 0.5]")),
        (lambda: shapes.block((1.0, 1.0, 1.0), ([0, 0.5], 1, 1)), ("divisions", "to 1")),
        (lambda: shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="tet4"), ("unknown-name", "'tet4'", "'hex8'")),
        (lambda: shapes.block((1.0, 1.0), (1, 1, 1)), ("input", "three")),
        (lambda: shapes.thick_ring(2.0, 1.0, 1.0), ("input", "outer radius must exceed")),
        (lambda: shapes.thick_ring(1.0, 2.0, 1.0, sector="third"), ("unknown-name", "'third'", "'quarter'")),
        (lambda: shapes.half_sphere(math.nan), ("not-positive", "radius")),
        (lambda: shapes.half_sphere(1.0, level=9), ("no-level", "9")),
        (lambda: shapes.half_sphere(1.0, contact_radius=0.9), ("contact-radius-too-large",)),
        (lambda: shapes.half_sphere(1.0, contact_radius=0.0), ("not-positive", "contact_radius")),
        (lambda: shapes.cap(1.0, 2.0, 1.0), ("input", "not below the extent")),
        (lambda: shapes.cap(1.0, 0.9, 0.1), ("cap-too-deep",)),
        (lambda: shapes.Level(core=0, rings=1, edge=0.1, layer=0.1), ("not-whole", "The core of a Level")),
    ],
)
def test_bad_sizes(call, words):
    with refused(InputError, *words):
        call()


@pytest.mark.parametrize("level", sorted(fc.shapes.LEVELS))
def test_layers_follow_the_thickness_where_the_contact_is_as_wide(level):
    """Equal cells through a thin layer and none wider inside the contact; a deep body as it was, its sizes from a."""
    cut = fc.shapes.as_level(level)
    for ratio in (1.0, 2.0, 5.0, 20.0):
        g = fc.shapes.grading(ratio, ratio + 8, 1.0, level)
        across = np.concatenate([np.linspace(0, g.core_radius, g.core + 1), g.radii])
        widths, depths = np.diff(across[across <= ratio * (1 + 1e-12)]), np.diff(g.depths)
        widest = min(0.4 / cut.core * np.sqrt(ratio / 2), 0.25) * (1 + 1e-9)
        assert np.isclose(across, ratio, rtol=1e-12).sum() == 1
        assert np.ptp(depths) < 1e-12
        assert max(widths.max(), depths.max()) < widest
        assert (np.diff(across) > 0).all()
        assert abs(across[-1] - ratio - 8) < 1e-12
    for ratio in (0.01, 0.3, 0.5):
        g = fc.shapes.grading(ratio, 9.0, 1.0, level)
        assert np.array_equal(g.depths, fc.shapes.geometric(cut.layer * ratio, cut.growth, 1.0))
    # nothing jumps between the two
    counts = [len(fc.shapes.grading(r, 9.0, 1.0, level).depths) for r in np.linspace(0.4, 1.2, 81)]
    assert np.abs(np.diff(counts)).max() <= 3
