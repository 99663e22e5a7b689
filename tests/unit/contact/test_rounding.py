"""Pairs of surfaces whose sides, nodes and rims fall together: what is paired does not depend on rounding."""

import numpy as np
import pytest
from hanging_meshes import part, stairs
from rounding import change_by_rounding

import fecontact as fc
from fecontact.contact.coupling.choose import COARSER
from fecontact.contact.coupling.mortar import pair_mortar
from fecontact.contact.coupling.nodal import SurfacePair, pair
from fecontact.scene.adaptive import _most
from fecontact.surfaces import Cone, Cylinder, FlatPunch
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.normals import normals_of

pytestmark = pytest.mark.rounding

SAME = 1e-9
KINDS = ["hex8", "hex20", "tet4", "tet10"]
UPRIGHT = np.eye(3)


def side(mesh, name, mapping=None):
    if mesh.cells.shape[1] == 20:
        mesh = mesh.with_midface_nodes((name,))
    mesh = mesh if mapping is None else mesh.mapped(mapping)
    return FacetSurface(mesh.points, mesh.face_nodes(mesh.faces(name)), name, hanging=mesh.hanging)


def block(kind, cells, name, size=(1.0, 1.0, 1.0), mapping=None):
    """The side z = 0 or z = 1 of a block."""
    at = {"bottom": 0.0, "top": size[2]}[name]
    mesh = part(kind, (0, 0, 0), size, cells).with_boundary(name, lambda x: np.abs(x[:, 2] - at) < 1e-9)
    return side(mesh, name, mapping)


def ball():
    return side(fc.shapes.half_sphere(1.0, contact_radius=0.3, level=1), "cap")


def bent(x):
    return x + 0.08 * np.stack([0 * x[:, 0], 0 * x[:, 0], np.sin(2 * x[:, 0] + x[:, 1])], axis=1)


def figures(pairing, slave):
    """Area, sums of areas, gaps, forces and moments, and numbers of points and faces."""
    nodal = (pairing.slave_rows.T @ np.stack([pairing.weights, pairing.weights * pairing.gap], axis=1)).T
    forces = nodal.reshape(2, -1, 3)
    counts = len(pairing.weights), pairing.n_beyond, len(pairing.covered)
    sums = pairing.weights.sum(), (pairing.weights**2).sum(), pairing.weights @ pairing.gap
    return np.concatenate(
        [counts, sums, forces.sum(axis=1).ravel(), np.cross(slave.points[None], forces).sum(axis=1).ravel()]
    )


def same_under(changes, sides, rotation, shift, share, pairs=(pair, pair_mortar)):
    """Compare what is paired as it is and under changes by rounding."""
    for paired in pairs:
        out = []
        for seed in [0, *changes]:
            with pytest.MonkeyPatch.context() as patch:
                if seed:
                    change_by_rounding(patch, seed)
                slave, master = sides()
                out.append(figures(paired(SurfacePair(slave, master, rotation, shift, share=share)), slave))
        assert np.abs(np.array(out) - out[0]).max() < SAME


@pytest.mark.by_day(every=3)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("cells", "shift"), [(2, (0.0, 0.0)), (4, (0.5, 0.0)), (2, (0.25, 0.25)), (3, (0.125, 0.5)), (3, (1 / 3, 0.2))]
)
def test_blocks_whose_sides_fall_together(kind, cells, shift, changes):
    # a rim along sides of faces, through their middles and corners, and through nothing in particular
    def sides():
        return block(kind, (cells, 2, 1), "bottom"), block(kind, (2, 2, 1), "top")

    same_under(changes, sides, UPRIGHT, np.array([*shift, 1.0]), 0.5)


@pytest.mark.by_day(every=4)
@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10"])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.5, 0.0), (1 / 6, 0.0)])
def test_bent_faces_whose_sides_fall_together(kind, shift, changes):
    def sides():
        top = block(kind, (6, 6, 1), "top", (2.0, 2.0, 1.0), bent)
        return block(kind, (3, 3, 1), "bottom", mapping=bent), top

    for gap in (0.0, 1e-3):
        same_under(changes, sides, UPRIGHT, np.array([*shift, 1.0 + gap]), 0.5)


@pytest.mark.by_day("22.5-0.5")
@pytest.mark.parametrize(("degrees", "share"), [(0.0, 0.0), (22.5, 0.5)])
def test_balls_whose_nodes_meet(degrees, share, changes):
    over = fc.rotation_about((1, 0, 0), np.pi) @ fc.rotation_about((0, 0, 1), np.radians(degrees))
    same_under(changes, lambda: (ball(), ball()), over, np.zeros(3), share)


@pytest.mark.by_day("hex8")
@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10"])
def test_rims_of_rigid_shapes_through_nodes(kind, changes):
    shapes = [FlatPunch(sides=(2 / 3, 1 / 3)), FlatPunch(radius=1 / 3), FlatPunch(radius=0.5), Cylinder(3.0, 2 / 3)]
    for shape in [*shapes, Cone(0.1)]:
        same_under(
            changes, lambda shape=shape: (block(kind, (6, 6, 1), "top"), shape), UPRIGHT, np.array([-0.5, -0.5, -1]), 0
        )


@pytest.mark.by_day(every=4)
@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10"])
@pytest.mark.parametrize("end", [1.3, 2.0, 2.5, 3.2])
def test_a_rim_beside_hanging_nodes(kind, end, changes):
    def sides():
        below = part(kind, (0, 0, 0), (end, 2, 1), (4, 3, 1)).with_boundary("lid", lambda x: x[:, 2] > 1 - 1e-9)
        return side(stairs(kind), "bottom"), side(below, "lid")

    same_under(changes, sides, UPRIGHT, np.array([0.0, 0.0, 1.0]), 0.0)


@pytest.mark.parametrize("kind", ["hex8", "tet4", "tet10", "wedge15"])
def test_points_beyond_a_corner_are_outside_whichever_facet_there_is_taken(kind):
    """Source: geometry. A facet may reach the rim with one corner, and its number may be the lowest there."""
    surface = block(kind, (2, 3, 1), "top")
    beyond = np.array([[1.3, 1 / 3, 1.0], [1.3, 2 / 3, 1.0], [0.5, 1.2, 1.0], [-0.1, 2 / 3, 1.0], [1.2, 1.3, 1.0]])
    inside = np.array([[1.0, 1 / 3, 1.2], [0.5, 1.0, 0.9], [0.5, 1 / 3, 1.3]])
    for first in range(len(surface.facets)):
        turned = FacetSurface(surface.points, np.roll(surface.facets, -first, axis=0))
        assert turned.project(beyond).outside.all()
        assert not turned.project(inside).outside.any()


def test_mirror_images_are_marked_together():
    # the two halves of what counts as most differ by what a solver leaves
    errors = np.array([1.0, 3.0, 5.0, 5.0 * (1 - 1e-9), 3.0, 1.0])
    assert _most(errors, 0.1).tolist() == [2, 3]
    assert _most(errors[::-1], 0.1).tolist() == [2, 3]
    assert _most(errors, 0.6).tolist() == [1, 2, 3, 4]
    assert len(_most(np.zeros(3), 0.5)) == 0


def test_numbers_that_people_choose_are_not_at_the_limits():
    # eleven cells beside ten, and an edge of 50 degrees
    assert COARSER > 11 / 10 * (1 + 1e-12)
    for turn in (-1e-13, 0.0, 1e-13):
        ridge = np.radians(25.0 + np.array([-25.0, 25.0]) + turn)
        out = np.stack([np.cos(ridge), 0 * ridge, np.sin(ridge)], axis=1) * [[-1, 1, 1], [1, 1, -1]]
        points = np.concatenate([[[0.0, 0, 0], [0, 1, 0]], out + np.array([0, 1, 0]), out])
        facets = np.array([[4, 0, 1, 2], [0, 5, 3, 1]])
        assert normals_of(FacetSurface(points, facets)).sharp[[0, 1]].all()
