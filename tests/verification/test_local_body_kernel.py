"""What each part of the kernel of a curved face is worth: a half-sphere without curvature, or without slopes."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.app.studies.spheres import Spheres, solve_spheres
from fecontact.bodies.local import body as local_body
from fecontact.bodies.local import remainder
from fecontact.bodies.local import window as windows
from fecontact.mesh.shapes import Level

#: A section with 60 faces across the contact and 40 rings beyond: levels 1 to 5 are within 0.05 % of it in approach.
FINE = Level(core=60, rings=40, edge=0.05, layer=0.1, growth=1.2)
RATIO = 0.2


def _straight(loads):
    """Loads on the same tangent planes of a face without curvature."""
    return tuple(windows.FaceLoads(load.places, load.normals, load.forces) for load in loads)


def _without(part, monkeypatch):
    if part == "slopes":
        monkeypatch.setattr(local_body, "inclined", lambda window, material: iter(()))
    if part == "curvature":
        made = windows.sources
        monkeypatch.setattr(remainder, "sources", lambda window, order: _straight(made(window, order)))
        for module in (local_body, windows):
            monkeypatch.setattr(module, "principal", lambda window: np.zeros(2))


# Found: 0.003 to 0.017 % in the approach and 0.005 to 0.012 % in the centre with all parts. The bounds are those asked
# of the method; without slopes the approach is 0.22, 0.03 and -0.16 % off, see docs/theory/local-bodies.md.
@pytest.mark.by_day("nothing-0.3", "slopes-0.3", "curvature-0.3")
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("missing", ["nothing", "slopes", "curvature"])
def test_parts_of_the_kernel(missing, nu, row, monkeypatch):
    """A half-sphere with its flat face clamped, on a rigid plane, contact radius 0.2 of its own: 2500 dofs, 128 cells.

    Source: a section of 34,000 dofs refined for this contact (axisymmetric finite elements).
    """
    material = fc.Material(E=1.0, nu=nu)
    force = 4 / 3 * material.plane_strain_modulus * RATIO**3
    case = Spheres("half-spheres", (1.0, 1.0), force, material)
    fine = solve_spheres(case, model="axisymmetric", level=FINE, element="hex27")
    mesh = fc.shapes.quarter_sphere(1.0, contact_radius=1 / 6, level=Level(2, 2, 0.4, 0.4, 2.0))
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    body = fc.ElasticBody(mesh, material, contact="cap", geometry=fc.Sphere(1.0), supports=supports)
    _without(missing, monkeypatch)
    local = fc.LocalBody(body, at=(0, 0, 0), window=2.3 * RATIO, cells=(128, 128))
    floor = fc.RigidBody(fc.Plane())
    scene = fc.Scene([local, floor], [fc.Contact(local, floor)])
    result = scene.solve(forces={local: (0, 0, -force / 4)}, finite_motion=False)
    (contact,) = result.contacts
    r2 = (contact.points[:, :2] ** 2).sum(axis=1)
    centre = contact.pressure[np.argmin(r2)] * (1 + r2.min() / (2 * RATIO**2))
    approach = -result.rigid_motion(local).translation[2]
    errors = (
        abs(2 * approach / fine.figures["approach"].found - 1),
        abs(centre / fine.figures["centre pressure"].found - 1),
    )
    # the effect of slopes vanishes at nu = 1/3, that of curvature at 1/2; the mesh alone cannot follow a logarithm
    least, defect = {0.0: (1e-3, 1e-4), 0.3: (1e-4, 4e-4), 0.45: (5e-4, 4.5e-4)}[nu]
    if missing == "nothing":
        told = f"half-sphere on a plane, kernel with all parts, a/R = {RATIO}, nu = {nu}"
        row(told, "approach", fine.figures["approach"].found / 2, approach, 5e-4, body.n_dofs)
        row(told, "centre pressure", fine.figures["centre pressure"].found, float(centre), 2e-3, body.n_dofs)
        assert nu == 0.3 or 2 * max(errors) < least
        assert local.remainder.defect < defect
    elif missing == "slopes":
        assert min(errors) > least
    else:
        assert local.remainder.defect > 2 * defect
        assert nu > 0 or errors[1] > 2e-3


# Found: 0.004 % and 0.003 %; the bounds are those asked of the method.
@pytest.mark.full
def test_unequal_curvatures(row):
    """Half an ellipsoid, semi-axes 1.6, 1 and 1, clamped, on a rigid plane, nu = 0.45: a mesh of 2500 dofs.

    Source: the same with a mesh of 8600 dofs, which follows what the kernel leaves to it more closely.
    """
    material = fc.Material(E=1.0, nu=0.45)
    force = 2.2e-3 * material.plane_strain_modulus
    found = []
    for level, ring in ((Level(2, 2, 0.4, 0.4, 2.0), 1 / 6), (Level(3, 4, 0.25, 0.25, 1.7), 1 / 10)):
        mesh = fc.shapes.quarter_sphere(1.0, contact_radius=ring, level=level)
        supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
        body = fc.ElasticBody(mesh.drawn_at(mesh.points * [1.6, 1.0, 1.0]), material, contact="cap", supports=supports)
        local = fc.LocalBody(body, at=(0, 0, 0), window=(0.75, 0.5), cells=(144, 96))
        floor = fc.RigidBody(fc.Plane())
        scene = fc.Scene([local, floor], [fc.Contact(local, floor)])
        result = scene.solve(forces={local: (0, 0, -force / 4)}, finite_motion=False)
        (contact,) = result.contacts
        found.append((-result.rigid_motion(local).translation[2], contact.max_pressure, local.remainder.defect))
    (approach, peak, defect), (finer, finer_peak, _) = found
    told = "half an ellipsoid on a plane, semi-axes 1.6, 1, 1"
    row(told, "approach", finer, approach, 5e-4, 2562)
    row(told, "peak pressure", finer_peak, peak, 2e-3, 2562)
    row(told, "Betti defect", 0.0, defect, 1e-3, 2562)
