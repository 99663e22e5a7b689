"""Coupling of curved faces that do not match: orders of convergence, both bodies swapped, triangles."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import hertz
from fecontact.mesh.shapes import Level

pytestmark = pytest.mark.rounding(0)

SOLID = fc.Material(E=1000.0, nu=0.3)
RADIUS, FORCE = 10.0, 40.0


def uniform(n):
    """Rings of equal width, n of them in the contact radius."""
    return Level(core=n, rings=2 * n, edge=0.999 / (3 * n), layer=0.5 / n, growth=1.6)


def balls(upper_cut, lower_cut, coupling="auto", swap="auto", first="upper"):
    """Quarter spheres with rings in different places; relative pressure error and the solution."""
    exact = hertz.spheres((RADIUS, RADIUS), (SOLID, SOLID), force=FORCE)
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    bodies = []
    for cut, shift, name in ((upper_cut, 1.0, "upper"), (lower_cut, 0.83, "lower")):
        mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=shift * exact.a, level=cut)
        bodies.append(fc.ElasticBody(mesh, SOLID, "cap", supports, name=name))
    upper = bodies[0]
    lower = bodies[1].placed(rotation=fc.rotation_about((1, 1, 0), np.pi))
    pair = (upper, lower) if first == "upper" else (lower, upper)
    scene = fc.Scene([upper, lower], [fc.Contact(*pair, coupling=coupling, swap=swap)])
    result = scene.solve(forces={upper: (0, 0, -FORCE / 4)})
    contact = result.contacts[0]
    points, pressure, area = contact.sampled(contact.pressure, 12)
    r = np.hypot(points[:, 0], points[:, 1])
    inside, target = r <= 1.2 * exact.a, exact.pressure(r)
    error = np.sqrt((area * (pressure - target) ** 2)[inside].sum() / (area * target**2)[inside].sum())
    return float(error), result


@pytest.mark.full
def test_curved_faces_that_do_not_match_converge(row):
    """Mortar coupling of curved faces that do not match: convergence.

    Source: Hertz. The pressure's square-root edge falls inside elements: first order at best, whatever the degree;
    asserted: halved elements leave less than 0.6 of the error.
    """
    errors = []
    for n in (1, 2):
        error, result = balls(uniform(2 * n), uniform(3 * n))
        errors.append(row(f"7b spheres {2 * n}:{3 * n}, mortar", "pressure L2", 0.0, error, dofs=result.n_dofs))
    row("7b spheres that do not match", "error, halved elements over first", 0.0, errors[1] / errors[0], 0.6)


@pytest.mark.full
def test_the_coarser_side_is_made_the_slave():
    """The coarser side is made the slave of a mortar coupling. Source: the result's own statement."""
    for first in ("upper", "lower"):
        _, result = balls(uniform(2), uniform(4), first=first)
        assert result.contacts[0].slave.name == "upper"
        assert result.contacts[0].coupling == "mortar"


@pytest.mark.full
def test_swapping_the_sides_changes_resultants_less_than_the_mesh_and_equilibrium_not_at_all(row):
    """Spheres that do not match, sides swapped.

    Source: each other. The resultants agree within the pressure error of the better one; equilibrium holds to rounding.
    """
    solutions = [balls(uniform(2), uniform(3), "mortar", "never", first) for first in ("upper", "lower")]
    for error, result in solutions:
        case = f"7b spheres that do not match, {result.contacts[0].slave.name} slave"
        row(case, "pressure L2", 0.0, error, dofs=result.n_dofs)
        assert abs(result.residuals().equilibrium) < 1e-10
        assert abs(abs(result.contacts[0].force[2]) / (FORCE / 4) - 1) < 1e-10
    approach = [r.rigid_motion(r.scene.bodies[0]).translation[2] for _, r in solutions]
    allowed = min(e for e, _ in solutions)
    row("spheres that do not match, sides swapped", "approach", approach[0], approach[1], within=allowed)
    # moments about the middle of a quarter's contact: the arm of the resultant
    arms = [np.hypot(*r.contacts[0].centre_of_pressure[:2]) for _, r in solutions]
    row("spheres that do not match, sides swapped", "arm of the resultant", arms[0], arms[1], within=allowed)


def test_swapping_the_sides_of_blocks_that_do_not_match(row):
    """Blocks that do not match, sides swapped: a block that overhangs another and opens in part.

    Source: each other. Statics holds to rounding for either side as slave.
    """
    forces, moments = [], []
    for swapped in (False, True):
        lower_mesh = fc.shapes.block((2.0, 1.0, 0.5), (6, 3, 2))
        upper_mesh = fc.shapes.block((1.2, 1.0, 0.5), (5, 4, 2)).translated((1.0, 0.0, 0.5))
        lower = fc.ElasticBody(lower_mesh, SOLID, "top", {"bottom": "xyz"}, name="lower")
        upper = fc.ElasticBody(upper_mesh, SOLID, "bottom", {"top": "xyz"}, name="upper")
        pair = (lower, upper) if swapped else (upper, lower)
        scene = fc.Scene([lower, upper], [fc.Contact(*pair, swap="never", coupling="mortar")])
        loads = {"forces": {upper: (0, 0, -3.0)}, "moments": {upper: (0.1, 0.7, 0.0)}, "free": {upper: "rx ry"}}
        result = scene.solve(**loads, finite_motion=False)  # in the given pose, in which all forces are upright
        assert abs(result.residuals().equilibrium) < 1e-10
        assert 0 < result.n_active < result.n_candidates
        reaction = result.reaction(lower)
        expected = np.array([0, 0, -3.0])
        assert np.abs(reaction[:3] + expected).max() < 1e-10 * 3
        forces.append(reaction[:3])
        moments.append(reaction[3:])
    case = "blocks that do not match, sides swapped"
    row(case, "largest force difference", 0.0, np.abs(forces[0] - forces[1]).max() / 3, within=1e-10)
    row(case, "largest moment difference", 0.0, np.abs(moments[0] - moments[1]).max(), within=1e-9)


@pytest.mark.full
def test_mortar_beats_nodal_forces_on_coarse_slaves(row):
    """A coarse slave on a fine master: mortar against nodal forces.

    Source: Hertz. Asserted: mortar leaves less than a fifth of the error.
    """
    errors = [balls(1, 3, coupling, "never")[0] for coupling in ("mortar", "nodal")]
    mortar, nodal = (
        row(f"7b coarse slave on a fine master, {coupling}", "pressure L2", 0.0, error)
        for coupling, error in zip(("mortar", "nodal"), errors, strict=True)
    )
    assert abs(mortar) < 0.2 * abs(nodal)


@pytest.mark.full
def test_a_side_whose_faces_are_wider_than_the_contact_is_not_made_the_slave(row):
    """A ridge on a block of wide faces: a mean gap over such a face hides what overlaps.

    Source: the same with all cells divided in eight, by either side; the wide faces as slave are off by twice and more.
    """

    def approach(n, **choice):
        lower = fc.shapes.block((1.0, 1.0, 1.0), (3 * n, 3 * n, 3 * n))
        upper = fc.shapes.block((0.4, 0.4, 0.4), (3 * n, 3 * n, 3 * n)).translated((0.3, 0.3, 1.0))
        upper = upper.mapped(lambda x: x + np.outer((x[:, 0] - 0.5) ** 2 * (1.4 - x[:, 2]) / 0.4, [0.0, 0.0, 1.0]))
        one = fc.ElasticBody(lower, fc.Material(210e3, 0.0), "top", {"bottom": "xyz"}, name="lower")
        other = fc.ElasticBody(upper, fc.Material(210e3, 0.0), "bottom", {"top": "xy"}, name="upper")
        scene = fc.Scene([one, other], [fc.Contact(other, one, **choice)])
        result = scene.solve(pressures={(other, "top"): 100.0})
        return result.contacts[0].slave.name, -float(result.displacement(other)[:, 2].mean())

    slave, found = approach(2)
    _, wide = approach(2, swap="always")
    fine = [approach(4, swap=swap)[1] for swap in ("never", "always")]
    assert slave == "upper"
    # the finer meshes' sides differ by a seventh
    row("ridge on wide faces", "approach", fine[0], found, within=0.05)
    assert fine[0] < fine[1] < 1.2 * fine[0]
    assert wide > 1.5 * fine[1]
