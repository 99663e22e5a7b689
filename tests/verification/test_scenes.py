"""Scenes with closed forms: two condyles, a shrink fit, a bonded layer, stiffness contrast (figures are printed)."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import cylinder, layer


class Bicondyle:
    """Two spheres of radii R1, R2 side by side at x1, x2, lowest points on z = 0; one rigid shape."""

    def __init__(self, radii, places):
        self.radii, self.places = radii, places
        self.size = 2 * max(radii)

    def project(self, points):
        centres = np.array([[x, 0.0, r] for x, r in zip(self.places, self.radii, strict=True)])
        offset = points[:, None, :] - centres
        distance = np.linalg.norm(offset, axis=2)
        nearest = (distance - np.array(self.radii)).argmin(axis=1)
        k = np.arange(len(points))
        normals = offset[k, nearest] / distance[k, nearest, None]
        gap = distance[k, nearest] - np.array(self.radii)[nearest]
        from fecontact.interface.surface import Feet

        return Feet(points - gap[:, None] * normals, normals, gap, np.zeros(len(points), bool))


def test_two_condyles_share_the_load_by_statics():
    # VERIFICATION 11: P1/P = (c2 - xp)/(c2 - c1) with the computed centres of pressure, whatever the elasticity
    radii, places, xp, load = (20.0, 25.0), (-15.0, 15.0), 3.0, 400.0
    mesh = fc.shapes.block((60.0, 30.0, 6.0), (30, 15, 2)).translated((-30.0, -15.0, -6.0))
    flat = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "top", {"bottom": "xyz"}, name="flat")
    femur = fc.RigidBody(Bicondyle(radii, places), name="femur")
    scene = fc.Scene([flat, femur], [fc.Contact(flat, femur)])
    moment = (0.0, xp * load, 0.0)  # a load along -z at x = xp about the origin
    result = scene.solve(forces={femur: (0, 0, -load)}, moments={femur: moment}, free={femur: "rx"})
    contact = result.contacts[0]
    pushed = contact.forces[:, None] * contact.normals  # on the flat
    share, centre = [], []
    for side in (contact.centres[:, 0] < 0, contact.centres[:, 0] > 0):
        force = pushed[side].sum(axis=0)
        moment_y = np.cross(contact.centres[side], pushed[side]).sum(axis=0)[1]
        share.append(-force[2] / load)
        centre.append(-moment_y / force[2])  # where the resultant crosses the plane of the pole line, z = 0
    statics = (centre[1] - xp) / (centre[1] - centre[0])
    nominal = (places[1] - xp) / (places[1] - places[0])
    print(f"\ncondyles: share {share[0]:.6f}, statics {statics:.6f}, with nominal places {nominal:.6f}")
    assert len(contact.regions) == 2
    assert abs(sum(share) - 1) < 1e-10
    assert abs(share[0] - statics) < 1e-8
    # the patches move by about R times the turn, a small part of their distance
    assert abs(share[0] - nominal) < 0.02


def test_shrink_fit_of_two_rings_within_half_a_percent():
    # VERIFICATION 9: Lame, plane strain; interference d at r = b, the outer ring heated on over the inner one
    a, b, c, d = 20.0, 30.0, 45.0, 0.03
    inner, outer = fc.Material(E=70e3, nu=0.33), fc.Material(E=210e3, nu=0.3)
    exact = cylinder.shrink_fit(radii=(a, b, c), materials=(inner, outer), interference=d, plane="strain").pressure
    held = {"sym_x": "x", "sym_y": "y", "bottom": "z", "top": "z"}
    hub = fc.ElasticBody(fc.shapes.thick_ring(a, b + d / 2, 5.0, (6, 3, 1)), inner, "outer", held, name="hub")
    tyre = fc.ElasticBody(fc.shapes.thick_ring(b - d / 2, c, 5.0, (6, 4, 1)), outer, "inner", held, name="tyre")
    result = fc.Scene([hub, tyre], [fc.Contact(hub, tyre)]).solve()
    pressure = result.contacts[0].pressure
    error = pressure.mean() / exact - 1
    print(
        f"\nshrink fit: p = {pressure.mean():.4f}, Lame {exact:.4f}, error {error:+.3%}, "
        f"spread {np.ptp(pressure) / exact:.2%}"
    )
    assert abs(error) < 0.005


@pytest.mark.parametrize(
    ("nu", "element", "tolerance"),
    [
        (0.0, "hex20", 0.02),
        (0.3, "hex20", 0.02),
        (0.45, "hex20", 0.02),
        (0.49, "hex20", 0.02),
        (0.4999, "hex20", 0.05),
        (0.4999, "hex27", 0.02),
        (0.4999, "hex8", 0.05),
    ],
)
def test_bonded_layer_under_a_rigid_paraboloid(nu, element, tolerance):
    # VERIFICATION 10, a/b = 2: a layer bonded to a rigid base, pressed by a sphere so large that it is a paraboloid
    thickness, radius = 1.0, 400.0
    solid = fc.Material(E=1.0, nu=nu)
    exact = layer.paraboloid(radius=radius, thickness=thickness, material=solid, a=2.0)
    mesh = fc.shapes.cylinder(12.0, thickness, contact_radius=2.0, level=2, sector="quarter", element=element)
    held = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    sheet = fc.ElasticBody(mesh, solid, "cap", held, name="layer")
    # the layer's body lies in z >= 0 below its surface: the ball comes from z < 0
    ball = fc.RigidBody(fc.Sphere(radius), name="ball").placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    result = fc.Scene([sheet, ball], [fc.Contact(sheet, ball)]).solve(forces={ball: (0, 0, exact.force / 4)})
    contact = result.contacts[0]
    r = np.hypot(*contact.points[:, :2].T)
    p0 = contact.pressure[np.argmin(r)]
    approach = result.rigid_motion(ball).translation[2]
    print(f"\nlayer nu = {nu}, {element}: p0 {p0 / exact.p0 - 1:+.2%}, approach {approach / exact.approach - 1:+.2%}")
    assert abs(p0 / exact.p0 - 1) < tolerance
    assert abs(approach / exact.approach - 1) < tolerance


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_selective_integration_passes_the_patch_test_and_has_no_hourglasses(element):
    # uniform compression of a distorted nearly incompressible block: exact to 1e-9, the condition of nu = 0.4999
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element=element)
    bent = mesh.mapped(lambda x: x + 0.03 * np.prod(np.sin(np.pi * x), axis=1, keepdims=True))
    held = {"top": "z", "x_min": "x", "y_min": "y"}
    block = fc.ElasticBody(bent, fc.Material(E=1.0, nu=0.4999), "bottom", held, name="block")
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.01}})
    assert block.model.selective
    assert np.abs(result.contacts[0].pressure / 0.01 - 1).max() < 1e-9
    assert np.abs(result.stress(block) / 0.01 - [0, 0, -1, 0, 0, 0]).max() < 1e-6  # stress is lambda times rounding
    modes = np.linalg.eigvalsh(
        fc.ElasticBody(
            fc.shapes.block((1, 1, 1), (1, 1, 1), element=element), fc.Material(1.0, 0.4999), ()
        ).model.stiffness.toarray(),
        UPLO="U",
    )
    assert (np.abs(modes) < 1e-9 * modes.max()).sum() == 6


def test_stiffness_contrast_tends_to_the_rigid_indenter():
    # VERIFICATION 12: moduli a million apart; the answer is that of a rigid body to about 1e-6
    mesh = fc.shapes.quarter_sphere(25.0, contact_radius=0.5, level=1)
    held = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    soft = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "cap", held, name="soft")
    block = fc.shapes.cylinder(5.0, 5.0, contact_radius=0.5, level=1, sector="quarter")
    hard = fc.ElasticBody(block, fc.Material(E=1e6, nu=0.3), "cap", held, name="hard")
    hard = hard.placed(rotation=fc.rotation_about((1, 1, 0), np.pi))
    plane = fc.RigidBody(fc.Plane())
    force = {soft: (0, 0, -0.005)}
    elastic = fc.Scene([soft, hard], [fc.Contact(soft, hard, coupling="nodal")]).solve(forces=force)
    rigid = fc.Scene([soft, plane], [fc.Contact(soft, plane)]).solve(forces=force)
    ratio = elastic.contacts[0].max_pressure / rigid.contacts[0].max_pressure
    print(f"\ncontrast 1e6: peak pressure off the rigid one by {ratio - 1:+.1e}")
    assert abs(ratio - 1) < 1e-5
