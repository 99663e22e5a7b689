"""Patch tests of flat interfaces of kites, the facets of tetrahedra cut into hexahedra; either side as slave."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import Mesh
from fecontact.fem.stress import gauss_strain, hooke

pytestmark = pytest.mark.rounding(0)

ELASTIC = fc.Material(E=1.0, nu=0.3)
# what is asked of a patch test here; degrees of quadrature are chosen for 1e-13 of a facet's area, and rounding is
# enlarged by condition numbers of some 1e3 and by forces on parts of a face
EXACT = 1e-10
#: Six tetrahedra round a diagonal of a hexahedron (H. W. Kuhn 1960).
KUHN = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]


def slab(kind, n):
    """A slab of 1 x 1 x 1/2, n x n fields in plan: 'regular', 'moved', 'tets' or 'kites'."""
    size = (1.0, 1.0, 0.5)
    mesh = fc.shapes.block(size, (n, n, 1), element="hex8")
    if kind == "regular":
        return mesh.upgraded(20)
    # nodes moved in plan, within the outline: general quadrilaterals and triangles
    x, y = mesh.points[:, 0], mesh.points[:, 1]
    bump = 0.25 * np.sin(np.pi * x) * np.sin(np.pi * y) / n
    points = mesh.points + np.column_stack([bump * np.cos(7 * x + 3 * y), bump * np.sin(5 * x - 4 * y), 0 * x])
    if kind == "moved":
        return Mesh(points, mesh.cells, mesh.boundaries).upgraded(20)
    corners = np.concatenate([mesh.cells[:, t] for t in KUHN])
    mesh = Mesh(points, corners[:, [0, 1, 2, 2, 3, 3, 3, 3]]).upgraded(20)
    for axis, (low, high) in enumerate((("x_min", "x_max"), ("y_min", "y_max"), ("bottom", "top"))):
        normal = np.eye(3)[axis]
        mesh = mesh.with_boundary(low, fc.pick.plane(0 * normal, -normal))
        mesh = mesh.with_boundary(high, fc.pick.plane(size[axis] * normal, normal))
    return fc.shapes.divided(mesh) if kind == "kites" else mesh


PAIRS = [
    (("kites", 1), ("kites", 1)),
    (("kites", 2), ("kites", 3)),
    (("kites", 3), ("kites", 2)),
    (("kites", 1), ("kites", 5)),
    (("kites", 5), ("kites", 1)),
    (("kites", 2), ("tets", 3)),
    (("tets", 2), ("kites", 3)),
    (("kites", 1), ("regular", 1)),
    (("kites", 2), ("regular", 3)),
    (("moved", 2), ("moved", 3)),
    (("moved", 1), ("moved", 5)),
    (("regular", 2), ("regular", 3)),
    (("regular", 1), ("regular", 5)),
    (("moved", 3), ("kites", 2)),
]


@pytest.mark.by_day(every=5)
@pytest.mark.parametrize(("upper", "lower"), PAIRS, ids=lambda side: f"{side[0]}{side[1]}")
@pytest.mark.parametrize("swapped", [False, True], ids=["", "swapped"])
def test_uniform_pressure_passes_an_interface_of_kites(upper, lower, swapped, row):
    sides = {"x_min": "x", "y_min": "y"}
    low = fc.ElasticBody(slab(*lower), ELASTIC, "top", {"bottom": "z", **sides}, name="low")
    up = fc.ElasticBody(slab(*upper), ELASTIC, "bottom", sides, name="up").placed((0, 0, 0.5))
    pair = (low, up) if swapped else (up, low)
    scene = fc.Scene([low, up], [fc.Contact(*pair, swap="never", coupling="mortar")])
    result = scene.solve(pressures={(up, "top"): 1.0})
    worst = 0.0
    for body, u in zip(scene.bodies, result._state.displacements, strict=True):
        strain, _ = gauss_strain(body.mesh, u.reshape(-1, 3))
        stress = hooke(strain, body.model.lame[:, None], body.model.shear[:, None])
        worst = max(worst, float(np.abs(stress - np.array([0, 0, -1.0, 0, 0, 0])).max()))
    case = f"7b {upper[0]} {upper[1]} on {lower[0]} {lower[1]}{', swapped' if swapped else ''}"
    row(case, "largest stress error", 0.0, worst, within=EXACT)
    # pressures are forces over areas: on a slave of finer facets the same error of force is so much more
    finer = max(1.0, lower[1] / upper[1] if swapped else upper[1] / lower[1])
    row(case, "largest pressure error", 0.0, np.abs(result.contacts[0].pressure - 1).max(), within=finer * EXACT)
    assert abs(result.residuals().equilibrium) < EXACT
