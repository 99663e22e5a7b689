"""Patch tests of interfaces: tilted under hydrostatic pressure, partly covered, turned, bent; either side as slave.

VERIFICATION 7b and 7c; the partly covered foundation is that of R. L. Taylor and P. Papadopoulos, On a patch test for
contact problems in two dimensions, in: Computational Methods in Nonlinear Mechanics, 1991, p. 690.
"""

from dataclasses import replace

import numpy as np
import pytest

import fecontact as fc
from fecontact.fem.stress import gauss_strain, hooke

ELASTIC = fc.Material(E=1.0, nu=0.3)
TURN = fc.rotation_about((1.0, 2.0, 0.5), np.radians(30))
# what is asked of a patch test here; rounding times condition numbers of some 1e3
EXACT = 1e-10
MESHES = [(1, 1), (2, 3), (1, 5)]


def stress_error(result, exact):
    """Largest difference of any stress component at any Gauss point from exact (6,), or from exact(points)."""
    worst = 0.0
    for body, u in zip(result.scene.bodies, result._state.displacements, strict=True):
        strain, points = gauss_strain(body.mesh, u.reshape(-1, 3))
        stress = hooke(strain, body.model.lame[:, None], body.model.shear[:, None])
        target = exact(points @ body.pose.rotation.T + body.pose.translation) if callable(exact) else exact
        worst = max(worst, float(np.abs(stress - target).max()))
    return worst


def in_order(first, second, swapped):
    return (second, first) if swapped else (first, second)


def held_block(mesh, contact, extra, name, turn):
    body = fc.ElasticBody(mesh, ELASTIC, contact, {"x_min": "x", "y_min": "y", **extra}, name=name)
    return body if turn is None else body.placed((3.0, -2.0, 5.0), turn)


# (b) a tilted interface under hydrostatic pressure


def tilted(n_upper, n_lower, swapped, turn):
    """A cube cut by a plane that leans both ways, pressed by 1 from all sides."""

    def height(x):
        return 0.5 + 0.3 * (x[:, 0] - 0.5) + 0.2 * (x[:, 1] - 0.5)

    def below(x):
        return np.column_stack([x[:, :2], x[:, 2] * height(x)])

    def above(x):
        return np.column_stack([x[:, :2], 1 - (1 - x[:, 2]) * (1 - height(x))])

    cube = (1.0, 1.0, 1.0)
    low = held_block(fc.shapes.block(cube, (n_lower, n_lower, 2)).mapped(below), "top", {"bottom": "z"}, "low", turn)
    up = held_block(fc.shapes.block(cube, (n_upper, n_upper, 2)).mapped(above), "bottom", {}, "up", turn)
    scene = fc.Scene([low, up], [fc.Contact(*in_order(up, low, swapped), swap="never")])
    pressed = {(up, "top"): 1.0, **{(b, side): 1.0 for b in (low, up) for side in ("x_max", "y_max")}}
    return scene.solve(pressures=pressed)


@pytest.mark.parametrize(("upper", "lower"), MESHES)
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("turn", [None, TURN], ids=["upright", "turned"])
def test_hydrostatic_pressure_passes_a_tilted_interface(upper, lower, swapped, turn, row):
    """A tilted interface of two blocks under hydrostatic pressure.

    Source: uniform stress; uniaxial stress cannot cross a frictionless tilted interface. Rounding times condition
    numbers of some 1e3.
    """
    result = tilted(upper, lower, swapped, turn)
    contact = result.contacts[0]
    case = (
        f"7b tilted interface {upper}:{lower}{', swapped' if swapped else ''}{', turned' if turn is not None else ''}"
    )
    stress = stress_error(result, np.array([-1.0, -1, -1, 0, 0, 0]))
    row(case, "largest stress error", 0.0, stress, within=EXACT)
    row(case, "largest pressure error", 0.0, np.abs(contact.pressure - 1).max(), within=EXACT)
    assert abs(result.residuals().equilibrium) < EXACT


# (b) a punch that covers a part of a block; the pressure acts beside it too


def covered(n_punch, n_block, swapped, turn):
    """A punch on the middle of a block of 3 x 3 fields, each of n_block faces along its side; 1 presses on all."""
    mesh = fc.shapes.block((3.0, 3.0, 1.0), (3 * n_block, 3 * n_block, 2))
    middles = mesh.points[mesh.face_nodes(mesh.faces("top"))[:, :4]].mean(axis=1)
    apart = (np.abs(middles[:, :2] - 1.5) > 0.5).any(axis=1)
    mesh = replace(mesh, boundaries={**mesh.boundaries, "beside": mesh.faces("top")[apart]})
    block = held_block(mesh, "top", {"bottom": "z"}, "block", turn)
    punch_mesh = fc.shapes.block((1.0, 1.0, 1.0), (n_punch, n_punch, 2)).translated((1.0, 1.0, 1.0))
    punch = held_block(punch_mesh, "bottom", {}, "punch", turn)
    scene = fc.Scene([block, punch], [fc.Contact(*in_order(punch, block, swapped), swap="never")])
    return scene.solve(pressures={(punch, "top"): 1.0, (block, "beside"): 1.0})


@pytest.mark.parametrize(("punch", "block"), MESHES)
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("turn", [None, TURN], ids=["upright", "turned"])
def test_partly_covered_block_is_uniformly_stressed(punch, block, swapped, turn, row):
    """A punch that covers a part of a block, pressure beside it.

    Source: Taylor and Papadopoulos 1991. Rounding times condition numbers of some 1e3.
    """
    if block == 5:
        block, punch = 2, 5  # the finer mesh on the smaller body
    result = covered(punch, block, swapped, turn)
    case = f"7b covered in part {punch}:{block}{', swapped' if swapped else ''}{', turned' if turn is not None else ''}"
    stress = stress_error(result, np.array([0.0, 0, -1, 0, 0, 0]))
    row(case, "largest stress error", 0.0, stress, within=EXACT)
    contact = result.contacts[0]
    assert abs(contact.total_force - 1) < EXACT
    if contact.coupling == "mortar" or not swapped:
        # nodal forces count a node on the punch's rim with its whole area, also that beside the punch
        assert abs(contact.area - 1) < EXACT


# (c) linear pressure


@pytest.mark.parametrize(("upper", "lower"), MESHES)
@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_bending_passes_an_interface(upper, lower, swapped, nu, row):
    """Bending through two blocks whose faces match, nest or neither.

    Source: linear stress, exact in quadratic elements; stress errors are over the mean pressure. Rounding times
    condition numbers of some 1e3.
    """
    cube, solid = (1.0, 1.0, 1.0), fc.Material(1.0, nu)
    lower_mesh = fc.shapes.block(cube, (lower, lower, 1))
    low = fc.ElasticBody(lower_mesh, solid, "top", {"bottom": "z", "y_min": "y"}, name="low")
    upper_mesh = fc.shapes.block(cube, (upper, upper, 1)).translated((0, 0, 1))
    up = fc.ElasticBody(upper_mesh, solid, "bottom", {"top": "z", "y_min": "y"}, name="up")
    scene = fc.Scene([low, up], [fc.Contact(*in_order(up, low, swapped), swap="never")])
    result = scene.solve(
        motions={up: {"z": -2e-2, "ry": 3e-2}}, finite_motion=False
    )  # the source is linear in the turn
    contact = result.contacts[0]

    def exact(x):
        return (-1e-2 - 1.5e-2 * (x[..., :1] - 0.5)) * np.array([0.0, 0, 1, 0, 0, 0])

    # a mean pressure of 1e-2
    case = f"7c bending {upper}:{lower}, nu = {nu}{', swapped' if swapped else ''}"
    row(case, "largest stress error / mean pressure", 0.0, stress_error(result, exact) / 1e-2, within=EXACT)
    moment = abs(result.reaction(low)[4])
    row(case, "bending moment", 1.5e-2 / 12, moment, within=1e-9)
    assert abs(contact.total_force / 1e-2 - 1) < EXACT
