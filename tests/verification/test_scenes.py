"""Scenes with closed forms: two condyles, a shrink fit, a bonded layer, stiffness contrast."""

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
        from fecontact.surfaces.facet_surface import Projection

        return Projection(points - gap[:, None] * normals, normals, gap, np.zeros(len(points), bool))


def test_two_condyles_share_the_load_by_statics(row):
    """Two condyles of one rigid body on a soft flat, free to rotate.

    Source: statics, P1/P = (c2 - xp)/(c2 - c1) with the computed centres of pressure, whatever the elasticity: 1e-8.
    With the nominal places it holds to about R times the turn, a small part of their distance.
    """
    radii, places, xp, load = (20.0, 25.0), (-15.0, 15.0), 3.0, 400.0
    mesh = fc.shapes.block((60.0, 30.0, 6.0), (30, 15, 2)).translated((-30.0, -15.0, -6.0))
    flat = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "top", {"bottom": "xyz"}, name="flat")
    femur = fc.RigidBody(Bicondyle(radii, places), name="femur")
    scene = fc.Scene([flat, femur], [fc.Contact(flat, femur)])
    moment = (0.0, xp * load, 0.0)  # a load along -z at x = xp about the origin
    # in the given pose, whose pole line the places are on
    loads = {"forces": {femur: (0, 0, -load)}, "moments": {femur: moment}, "free": {femur: "rx"}}
    result = scene.solve(**loads, finite_motion=False)
    contact = result.contacts[0]
    pushed = contact.forces[:, None] * contact.normals  # on the flat
    share, centre = [], []
    for side in (contact._centres[:, 0] < 0, contact._centres[:, 0] > 0):
        force = pushed[side].sum(axis=0)
        moment_y = np.cross(contact._centres[side], pushed[side]).sum(axis=0)[1]
        share.append(-force[2] / load)
        centre.append(-moment_y / force[2])  # where the resultant crosses the plane of the pole line, z = 0
    statics = (centre[1] - xp) / (centre[1] - centre[0])
    nominal = (places[1] - xp) / (places[1] - places[0])
    assert len(contact.regions) == 2
    row("11 two condyles", "sum of the shares", 1.0, sum(share), 1e-10, result.n_dofs)
    row("11 two condyles", "share less statics", 0.0, share[0] - statics, 1e-8, result.n_dofs)
    row("11 two condyles", "share less that of nominal places", 0.0, share[0] - nominal, 0.02, result.n_dofs)


def test_shrink_fit_of_two_rings_within_half_a_percent(row):
    """Shrink fit of two rings of different metals, spatial model in plane strain.

    Source: Lame, interference d at r = b. The interference is 1e-3 of the radius; a coarse mesh: half a percent.
    """
    a, b, c, d = 20.0, 30.0, 45.0, 0.03
    inner, outer = fc.Material(E=70e3, nu=0.33), fc.Material(E=210e3, nu=0.3)
    exact = cylinder.shrink_fit(radii=(a, b, c), materials=(inner, outer), interference=d, plane="strain").pressure
    held = {"sym_x": "x", "sym_y": "y", "bottom": "z", "top": "z"}
    hub = fc.ElasticBody(fc.shapes.thick_ring(a, b + d / 2, 5.0, (6, 3, 1)), inner, "outer", held, name="hub")
    tyre = fc.ElasticBody(fc.shapes.thick_ring(b - d / 2, c, 5.0, (6, 4, 1)), outer, "inner", held, name="tyre")
    result = fc.Scene([hub, tyre], [fc.Contact(hub, tyre)]).solve()
    pressure = result.contacts[0].pressure
    row("9 shrink fit, 6 elements around", "mean pressure", exact, pressure.mean(), 0.005, result.n_dofs)
    row("9 shrink fit, 6 elements around", "spread / pressure", 0.0, np.ptp(pressure) / exact, dofs=result.n_dofs)


@pytest.mark.by_day(every=2)
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
def test_bonded_layer_under_a_rigid_paraboloid(nu, element, tolerance, row):
    """A thin layer bonded to a rigid base under a sphere so large that it is a paraboloid, a/b = 2.

    Source: layer by Hankel transforms (fecontact.analytic.layer). Level 2 is good to 2 %; 5 % near incompressibility
    for elements of 8 and 20 nodes, whose pressures alternate.
    """
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
    case = f"10 layer, nu = {nu}, {element}"
    row(case, "centre pressure", exact.p0, p0, tolerance, result.n_dofs)
    row(case, "approach", exact.approach, approach, tolerance, result.n_dofs)


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_selective_integration_passes_the_patch_test_and_has_no_hourglasses(element, row):
    """Selective integration: patch test of a distorted, nearly incompressible block, and zero-energy modes.

    Source: uniform compression; six rigid motions. 1e-9 by the condition of nu = 0.4999; stress is lambda times
    rounding, 1e-6.
    """
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element=element)
    bent = mesh.mapped(lambda x: x + 0.03 * np.prod(np.sin(np.pi * x), axis=1, keepdims=True))
    held = {"top": "z", "x_min": "x", "y_min": "y"}
    block = fc.ElasticBody(bent, fc.Material(E=1.0, nu=0.4999), "bottom", held, name="block")
    floor = fc.RigidBody(fc.Plane())
    result = fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.01}})
    assert block.model.selective
    case, n = f"25 selective integration, {element}", result.n_dofs
    row(case, "largest pressure error", 0.0, np.abs(result.contacts[0].pressure / 0.01 - 1).max(), 1e-9, n)
    stress = np.abs(result.stress(block) / 0.01 - [0, 0, -1, 0, 0, 0]).max()
    row(case, "largest stress error", 0.0, stress, 1e-6, n)
    modes = np.linalg.eigvalsh(
        fc.ElasticBody(
            fc.shapes.block((1, 1, 1), (1, 1, 1), element=element), fc.Material(1.0, 0.4999), ()
        ).model.stiffness.toarray(),
        UPLO="U",
    )
    row(case, "zero-energy modes", 6, (np.abs(modes) < 1e-9 * modes.max()).sum(), 1e-15)


def test_stiffness_contrast_tends_to_the_rigid_indenter(row):
    """Stiffness contrast of a million between two bodies.

    Source: the same scene with a rigid body; the answers differ by about 1e-6, ten times that is allowed.
    """
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
    target, found = (r.contacts[0].max_pressure for r in (rigid, elastic))
    row("12 moduli 1e6 apart", "peak pressure", target, found, 1e-5, elastic.n_dofs)
