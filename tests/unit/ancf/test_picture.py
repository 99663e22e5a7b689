"""Lines, patches and pressures that pictures of bricks are made of."""

import numpy as np
from matplotlib.figure import Figure
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.ancf import AncfSolid, AncfSpace
from fecontact.ancf.picture import draw_side, edges, multiplier_pressure

SOFT = fc.Material(E=1.0, nu=0.0)


def bar():
    return AncfSolid(AncfSpace(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8")), SOFT)


def bent(space):
    """Coordinates of z -> z + x^2 / 4, a cubic field that the bricks hold."""
    q = space.q0.reshape(-1, 3).copy()
    x = space.mesh.points[space.nodes][:, 0]
    q[space.start, 2] += x**2 / 4
    q[space.start + 1, 2] = x / 2
    return q.ravel()


def test_edges_follow_the_deformation():
    space = bar().space
    lines = edges(space, bent(space), samples=5)
    assert lines.shape == (20, 5, 3)  # 3 x 4 across and 2 x 4 along, shared ones once
    flat = edges(space, space.q0, samples=5)
    assert np.abs(lines[..., 2] - flat[..., 2] - flat[..., 0] ** 2 / 4).max() < 1e-14
    along = edges(space, space.q0, "top")
    assert len(along) == 7
    assert np.abs(along[..., 2] - 1).max() < 1e-14
    with refused(InputError, "unknown-boundary", "'nowhere'"):
        edges(space, space.q0, "nowhere")


def test_averaging_keeps_the_force_and_uniform_pressure():
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 1), element="hex8"))
    top = AncfSolid(space, fc.Material(E=1.0, nu=0.3)).side("top")
    areas = top.quadrature[2]
    _, _, same = multiplier_pressure(top, space.q0, 2.0 * areas, averaged=True)
    assert np.abs(same - 2).max() < 1e-14
    forces = np.random.default_rng(0).random(len(areas))
    points, triangles, pressure = multiplier_pressure(top, space.q0, forces, averaged=True)
    # of a field that is linear over the triangles
    sides = points[triangles[:, 1:]] - points[triangles[:, :1]]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    assert abs((area * pressure[triangles].mean(axis=1)).sum() / forces.sum() - 1) < 1e-13


def test_side_is_shaded_by_its_stress():
    solid = bar()
    axes = Figure().subplots()
    # a stretch of 1.1 along x: E_xx = 0.105, Cauchy stress lambda^2 S / det F = 1.1 x 0.105
    drawn = draw_side(axes, solid, solid.space.affine(np.diag([1.1, 1.0, 1.0])), "y_min")
    assert np.abs(drawn.get_array() - 0.1155).max() < 1e-12
    assert draw_side(axes, solid, solid.space.q0, "y_min", shaded=False) is None
    assert axes.get_xlim()[1] >= 2.2
