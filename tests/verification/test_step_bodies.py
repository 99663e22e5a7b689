"""A body from a STEP file, cut into hexahedra and into tetrahedra: force, area and peak pressure."""

import functools

import numpy as np
import pytest

import fecontact as fc

STEEL = fc.Material(E=210e3, nu=0.3)
RADIUS, APPROACH = 40.0, 0.03


@pytest.fixture(scope="module")
def step(tmp_path_factory, gmsh):
    """A pin of radius 4 with a spherical end and a bore of radius 1.2 across it."""
    path = tmp_path_factory.mktemp("step") / "pin.step"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    pin = gmsh.model.occ.addCylinder(0, 0, -1.0, 0, 0, 7.0, 4.0)
    ball = gmsh.model.occ.addSphere(0, 0, RADIUS, RADIUS)
    solid, _ = gmsh.model.occ.intersect([(3, pin)], [(3, ball)])
    bore = gmsh.model.occ.addCylinder(-5, 0, 4.0, 10, 0, 0, 1.2)
    gmsh.model.occ.cut(solid, [(3, bore)])
    gmsh.model.occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    return path


@pytest.fixture(scope="module")
def pressed(step):
    """Figures of the pin pressed on a rigid plane by a cut; each cut is solved once."""

    @functools.cache
    def solved(element, near_size):
        mesh = fc.mesh_solid(step, size=2.0, element=element, near=(0, 0, 0), near_size=near_size, growth=0.25)
        mesh = mesh.with_boundary("end", lambda x: np.abs(np.linalg.norm(x - [0, 0, RADIUS], axis=1) - RADIUS) < 5e-3)
        mesh = mesh.with_boundary("shank", fc.pick.plane((0, 0, 6.0), (0, 0, 1)))
        pin, plane = fc.ElasticBody(mesh, STEEL, "end", {"shank": "xyz"}, name="pin"), fc.RigidBody(fc.Plane())
        result = fc.Scene([pin, plane], [fc.Contact(pin, plane)]).solve(motions={pin: {"z": -APPROACH}})
        contact = result.contacts[0]
        assert abs(result.residuals().equilibrium) < 1e-9
        # peak from the mean over the inner quarter of the area: p0 sqrt(1 - r^2/a^2) has 0.9282 of p0 there
        r = np.hypot(*contact.points[:, :2].T)
        inner = r <= 0.5 * np.sqrt(contact.area / np.pi)
        peak = contact.forces[inner].sum() / contact.weights[inner].sum()
        return {"force": contact.total_force, "area": contact.area, "peak pressure": float(peak)}, result.n_dofs

    return solved


#: Edge lengths near the contact, coarse and fine, where the contact's radius is 1.06: 4 and 7, 7 and 11 elements.
CUTS = {"hex20": (0.3, 0.15), "tet10": (0.15, 0.1)}
#: The area is a sum over nodes, so it goes in steps of a ring of them; the peak is a mean over the inner quarter.
WITHIN = {"force": 0.01, "area": 0.05, "peak pressure": 0.03}


@pytest.mark.full
def test_hexahedra_and_tetrahedra_of_a_step_file_agree(pressed, row):
    """A drilled pin from a STEP file: hexahedra against tetrahedra.

    Source: the two meshes of one geometry. Forces differ by the discretisation; the area is a sum over nodes and goes
    in steps of a ring of them; the peak is a mean over the inner quarter.
    """
    tets, n_tets = pressed("tet10", CUTS["tet10"][1])
    hexes, n_hexes = pressed("hex20", CUTS["hex20"][1])
    for name, within in WITHIN.items():
        case = f"pin from STEP, hex20 against tet10 ({n_tets} dofs)"
        row(case, name, tets[name], hexes[name], within=within, dofs=n_hexes)


@pytest.mark.full
@pytest.mark.parametrize("element", CUTS)
def test_cuts_of_a_step_file_agree_with_their_refinement(element, pressed, row):
    """A drilled pin from a STEP file: coarse against fine meshes.

    Source: the refined mesh. Twice what the fine meshes are held to.
    """
    (coarse, n), (fine, _) = (pressed(element, size) for size in CUTS[element])
    for name, within in WITHIN.items():
        # twice what the fine meshes are held to
        row(f"pin from STEP, {element} coarse against fine", name, fine[name], coarse[name], within=2 * within, dofs=n)
