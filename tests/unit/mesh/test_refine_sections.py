"""Local division of sections: quadrilaterals into four, with hanging nodes on sides."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import scipy.sparse as sp
from refine_cases import check_levels, near, refined_near

import fecontact as fc
from fecontact.fem.section_model import section_stiffness
from fecontact.fem.stiffness import Cells, moments_of_volume
from fecontact.mesh.refine import refined, touching
from fecontact.mesh.section_mesh import Extent

# areas, positions and stiffnesses: sums of some hundred numbers of size one
ROUNDING = 1e-13
WIDTHS = (8, 9)


def section(width, n=4):
    return fc.sections.rectangle((1.0, 0.8), (n, n), element=f"quad{width}", start=0.5)


def bent(x):
    """Points of the plane moved smoothly, so that sides are curved."""
    return x + 0.05 * np.stack([np.sin(3 * x[:, 2]), 0 * x[:, 1], np.cos(2 * x[:, 0] + x[:, 2])], axis=1)


def local(width, levels=3, curved=False):
    """Divided towards a place on the upper side."""
    mesh = section(width).mapped(bent) if curved else section(width)
    place = np.array([[0.9, 0.0, 0.8]])
    return refined_near(mesh, (bent(place) if curved else place)[0], [0.4, 0.2, 0.1][:levels])


def test_two_squares_one_divided():
    mesh = refined(fc.sections.rectangle((2.0, 1.0), (2, 1)), [0])
    assert len(mesh.cells) == 5
    assert mesh.points[mesh.hanging.nodes].tolist() in ([[1, 0, 0.25], [1, 0, 0.75]], [[1, 0, 0.75], [1, 0, 0.25]])
    assert sorted(mesh.hanging.weights[0].data.tolist()) == [-0.125, 0.375, 0.75]
    assert len(mesh.hanging.edges) == 1


@pytest.mark.parametrize("width", WIDTHS)
def test_all_divided_is_the_uniform_section(width):
    fine, uniform = refined(section(width, 2), np.ones(4, bool)), section(width, 4)
    assert fine.hanging is None
    assert len(fine.points) == len(uniform.points)
    assert set(map(tuple, fine.points.round(9).tolist())) == set(map(tuple, uniform.points.round(9).tolist()))
    for name in uniform.boundaries:
        assert len(fine.faces(name)) == len(uniform.faces(name))


@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("width", WIDTHS)
def test_area_boundaries_and_sets(width, curved):
    mesh = section(width).mapped(bent) if curved else section(width)
    mesh = replace(mesh.with_group("low", lambda x: x[:, 2] < 0.5), node_sets={"top": mesh.boundary_nodes("top")})
    fine = refined_near(mesh, mesh.points[mesh.boundary_nodes("top")][3], [0.4, 0.2])
    areas = [moments_of_volume(Cells.of(m, Extent(1.0))) for m in (mesh, fine)]
    assert abs(areas[0][0] - areas[1][0]) < ROUNDING
    assert np.abs(areas[0][1] - areas[1][1]).max() < ROUNDING
    assert sorted(map(tuple, fine.outer_sides)) == sorted(
        tuple(s) for name in mesh.boundaries for s in fine.faces(name)
    )
    assert set(fine.node_sets["top"]) == set(fine.boundary_nodes("top"))
    assert np.abs(fine.hanging.followed(fine.points) - fine.points).max() < ROUNDING
    whole = replace(fine, hanging=None)
    assert len(whole.outer_sides) == len(fine.outer_sides) + 3 * len(fine.hanging.edges)


@pytest.mark.parametrize("extent", [Extent(0.7), Extent(None)], ids=["plane", "revolved"])
@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("width", WIDTHS)
def test_patch(width, curved, extent):
    """Constant strain through the thickness; round the axis rigid motion along it, and no residual of z alone."""
    mesh = local(width, curved=curved)
    ones = np.ones(len(mesh.cells))
    upper = section_stiffness(Cells.of(mesh, extent), 0.7 * ones, 0.4 * ones, selective=False)
    K, T = upper + sp.triu(upper, 1).T, sp.kron(mesh.hanging.transform, sp.eye(3)).tocsr()
    rows = np.flatnonzero(~np.isin(mesh.hanging.free, mesh.face_nodes(mesh.outer_sides)))
    inner = (3 * rows[:, None] + [0, 2]).ravel()
    x = mesh.points
    # round the axis u_x = x, u_z = -z: all strains constant, sigma_xx = sigma_yy
    plane = np.array([[0.3, 0.0, -0.4], [0.0, 0.0, 0.0], [0.7, 0.0, 0.2]])
    u = x @ (np.diag([1.0, 0.0, -1.0]) if extent.revolved else plane)
    assert len(rows) > 50
    assert np.abs((T.T @ (K @ u.ravel()))[inner]).max() < ROUNDING * abs(K).max()
    lift = np.tile([0.0, 0.0, 1.0], len(mesh.hanging.free))
    assert np.abs(K @ (T @ lift)).max() < ROUNDING * abs(K).max()


@pytest.mark.parametrize("width", WIDTHS)
def test_hanging_nodes_hold_the_polynomials_of_the_cells(width):
    mesh = local(width)
    powers = [p for p in product(range(3), repeat=2) if width == 9 or sum(k for k in p if k > 1) <= 2]
    assert len(powers) == width
    for i, j in powers:
        u = (mesh.points[:, 0] ** i * mesh.points[:, 2] ** j)[:, None]
        assert np.abs(mesh.hanging.followed(u) - u).max() < ROUNDING * 10


def test_sizes_of_squares_that_share_a_side_differ_by_two_at_most():
    mesh = local(8)
    check_levels(mesh.points[mesh.cells[:, :4]][:, :, [0, 2]])


def test_touching_finds_what_meets_a_side_in_the_plane():
    mesh = local(8, 2)
    x = mesh.points[mesh.cells[:, :4]]
    low, high = x.min(axis=1), x.max(axis=1)
    for side in mesh.faces("top"):
        ends = mesh.points[mesh.face_nodes(side[None])[0, :2]]
        met = (low <= ends.max(axis=0) + 1e-9).all(axis=1) & (high >= ends.min(axis=0) - 1e-9).all(axis=1)
        assert touching(mesh, [side]).tolist() == np.flatnonzero(met).tolist()


def test_nothing_to_divide_is_the_section_itself():
    mesh = section(8)
    assert refined(mesh, near(mesh, [9.0, 0.0, 9.0], 1.0)) is mesh
