"""Fields inside local bodies against Hertz, layers, sections and equilibrium."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import layer as layers
from fecontact.app.studies.spheres import Spheres, solve_spheres
from fecontact.common.material import von_mises
from fecontact.mesh.shapes import Level
from fecontact.surfaces import Paraboloid


def pressed(local, shape, force):
    """The local body under a rigid shape with its pole in the middle of the window, pressed along -z."""
    body = fc.RigidBody(shape, pose=fc.Pose(translation=local.window.origin))
    scene = fc.Scene([local, body], [fc.Contact(local, body)])
    return scene.solve(forces={body: (0, 0, -force)}, finite_motion=False)


def quarter_block(along, material):
    """A quarter of a clamped block, its elements graded alike from its planes of symmetry and from its top."""
    mesh = fc.shapes.block((along[-1],) * 3, (along, along, along[-1] - along[::-1]))
    return fc.ElasticBody(mesh, material, supports={"bottom": "xyz", "x_min": "x", "y_min": "y"})


# Found: 0.14 % in the largest von Mises stress and 0.16 % of p0 at any point; the block's supports, 20 contact radii
# away, make 0.1 %. 1 % is asked.
def test_hertz_in_a_large_block(row):
    """A paraboloid on a block of 40 x 40 x 20 contact radii: stresses on the axis and off it.

    Source: Huber's stresses of Hertz's contact (`analytic.hertz`).
    """
    material, side = fc.Material(E=1.0, nu=0.3), 20.0
    hertz = fc.hertz.spheres((50.0, np.inf), (material, None), force=0.03)
    body = quarter_block(np.array([0, 1, 2, 3.5, 5.5, 8, 12, 16, 20]) * hertz.a, material)
    local = fc.LocalBody(body, (0, 0, side * hertz.a), 2.3 * hertz.a, (96, 96))
    result = pressed(local, Paraboloid(50.0), hertz.force / 4)
    r, z = (c.ravel() * hertz.a for c in np.meshgrid([0.0, 0.5, 0.95, 1.2, 2.0], [0.02, 0.3, 0.48, 1.0, 2.5]))
    at = np.stack([0.6 * r, 0.8 * r, side * hertz.a - z], axis=1)
    found = result.fields_at(local, at)[1]
    exact = hertz.stress(r, z)
    radial = 0.36 * found[:, 0] + 0.64 * found[:, 1] + 2 * 0.48 * found[:, 3]
    hoop = 0.64 * found[:, 0] + 0.36 * found[:, 1] - 2 * 0.48 * found[:, 3]
    shear = 0.6 * found[:, 5] + 0.8 * found[:, 4]
    pairs = ((radial, exact.rr), (hoop, exact.tt), (found[:, 2], exact.zz), (-shear, exact.rz))
    worst = max(float(np.abs(one - other).max()) for one, other in pairs) / hertz.p0
    row("Hertz in a large block", "largest error of stress over p0", 0.0, worst, 4e-3, body.n_dofs)
    axis = np.linspace(0.3, 0.7, 41) * hertz.a
    on_axis = result.fields_at(local, np.stack([0 * axis, 0 * axis, side * hertz.a - axis], axis=1))[1]
    largest = float(hertz.stress_on_axis(axis).von_mises.max())
    row(
        "Hertz in a large block",
        "largest von Mises stress",
        largest,
        float(von_mises(on_axis).max()),
        5e-3,
        body.n_dofs,
    )


# Found: at most 0.7 and 1.5 % of the peak pressure, at the base, where six elements lie across the thickness, and 0.2
# and 0.35 % in the mean of squares.
@pytest.mark.by_day("0.45-0.02-0.005")
@pytest.mark.parametrize(("nu", "most", "mean"), [(0.3, 0.01, 3e-3), (0.45, 0.02, 5e-3)])
def test_bonded_layer(nu, most, mean, row):
    """A paraboloid on a bonded layer, a/h = 0.5: stresses through the layer.

    Source: transforms of a layer on a rigid base under the pressures on it (`HalfSpaceContact.stress`).
    """
    material, a = fc.Material(E=1.0, nu=nu), 0.5
    exact = layers.paraboloid(radius=1.0, thickness=1.0, material=material, a=a)
    along = np.array([0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.9, 2.4, 3, 4, 6.0])
    mesh = fc.shapes.block((6.0, 6.0, 1.0), (along, along, np.linspace(0, 1, 7)))
    body = fc.ElasticBody(mesh, material, supports={"bottom": "xyz", "x_min": "x", "y_min": "y"})
    local = fc.LocalBody(body, (0, 0, 1), 2.3 * a, (64, 64))
    result = pressed(local, Paraboloid(1.0), exact.force / 4)
    half = fc.HalfSpace(None, local.window.grid.size, (32, 32), layers=[fc.Layer(material, 1.0)])
    layer = half.press(Paraboloid(1.0), force=exact.force)
    r, z = (c.ravel() for c in np.meshgrid([0.0, 0.25, 0.45, 0.7, 1.2], [0.05, 0.3, 0.6, 0.9]))
    at = np.stack([0.6 * r, 0.8 * r, 1 - z], axis=1)
    error = np.abs(result.fields_at(local, at)[1] - layer.stress(at - [0, 0, 1])).max(axis=1) / exact.pressure(0.0)
    case = f"paraboloid on a bonded layer, nu = {nu}"
    row(case, "largest error of stress over p0", 0.0, float(error.max()), most, body.n_dofs)
    row(case, "mean error of stress over p0", 0.0, float(np.sqrt((error**2).mean())), mean, body.n_dofs)


#: A section with 40 faces across the contact and rings that grow slowly.
SECTION = Level(core=36, rings=30, edge=0.06, layer=0.06, growth=1.12)


# Found: 0.3 % in the largest von Mises stress and 0.1 % of p0 in the mean of squares, of which the section makes most:
# finer ones come nearer. With forces along the normals of the face, not of the contact, stresses are 10 % of p0 off.
@pytest.mark.full
def test_half_sphere_on_a_plane(row):
    """A half-sphere with its flat face clamped, on a rigid plane, a/R = 0.1: stresses below the curved face.

    Source: a section refined for this contact (axisymmetric finite elements).
    """
    material, ratio = fc.Material(E=1.0, nu=0.3), 0.1
    force = 4 / 3 * material.plane_strain_modulus * ratio**3
    fine = solve_spheres(
        Spheres("half", (1.0, 1.0), force, material), model="axisymmetric", level=SECTION, element="hex27"
    )
    mesh = fc.shapes.quarter_sphere(1.0, contact_radius=1 / 6, level=Level(2, 2, 0.4, 0.4, 2.0))
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    body = fc.ElasticBody(mesh, material, contact="cap", geometry=fc.Sphere(1.0), supports=supports)
    local = fc.LocalBody(body, (0, 0, 0), 2.3 * ratio, (64, 64))
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([local, floor], [fc.Contact(local, floor)])
    result = scene.solve(forces={local: (0, 0, -force / 4)}, finite_motion=False)
    upper = fine.solved.scene.bodies[0]
    points, stress = upper.mesh.points, fine.solved.stress(upper)
    away = np.hypot(points[:, 0], points[:, 2])
    near = np.flatnonzero((away < 0.8 * ratio) | ((away > 1.3 * ratio) & (away < 3 * ratio)))[::31]
    found = result.fields_at(local, points[near])[1]
    p0 = result.contacts[0].max_pressure
    error = float(np.sqrt(((found - stress[near]) ** 2).mean(axis=0).max())) / p0
    row("half-sphere on a plane", "mean error of stress over p0", 0.0, error, 5e-3, body.n_dofs)
    axis = np.flatnonzero((points[:, 0] == 0) & (points[:, 2] < ratio))
    largest = (von_mises(s).max() for s in (stress[axis], result.fields_at(local, points[axis])[1]))
    row("half-sphere on a plane", "largest von Mises stress", *map(float, largest), 5e-3, body.n_dofs)
