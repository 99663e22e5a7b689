"""Hard cases: conforming, receding, crossed, multiply connected and rounded-edge contacts."""

import numpy as np
import pytest
from references import layer_on_rigid_plane, pin_in_hole

import fecontact as fc
from fecontact.analytic import axisymmetric
from fecontact.surfaces import Torus

STEEL = fc.Material(E=210e3, nu=0.3)


def along_edge(contact, coordinate):
    """Pressure of a slab's contact in its lower plane, sorted by a coordinate of the points."""
    lower = np.abs(contact.points[:, 2]) < 1e-9
    s = coordinate(contact.points[lower])
    order = np.argsort(s)
    return s[order], contact.pressure[lower][order]


def pressed_pin(clearance, approach):
    """A ring on a rigid core in the hole of a ring held outside, half of it, plane strain."""
    inwards, outwards = [0, 2.0, 3.5, 4.5, 5.2, 5.7, 6 - clearance], [0, 0.3, 0.8, 1.5, 2.5, 4, 6.5, 10, 14, 20]
    hub = fc.shapes.thick_ring(4.0, 10.0 - clearance, 1.0, (24, inwards, 1), sector="half")
    tyre = fc.shapes.thick_ring(10.0, 30.0, 1.0, (24, outwards, 1), sector="half")
    plane = {"bottom": "z", "top": "z", "sym_y": "y"}
    pin = fc.ElasticBody(hub, STEEL, "outer", {**plane, "inner": "xyz"}, name="pin")
    plate = fc.ElasticBody(tyre, STEEL, "inner", {**plane, "outer": "xyz"}, name="plate")
    # the source's gaps are linear in the approach
    scene = fc.Scene([pin, plate], [fc.Contact(pin, plate)])
    return scene.solve(motions={pin: {"x": approach}}, finite_motion=False)


@pytest.mark.by_day("0.01-0.02", "0.0-0.01")
@pytest.mark.parametrize(("clearance", "approach"), [(0.01, 0.02), (0.01, 0.03), (1e-3, 0.02), (0.0, 0.01)])
def test_pin_in_a_hole(clearance, approach, row):
    """Conforming contact: a pin in a hole. Source: Michell's series for both rings, hats of pressure, one LCP.

    The contact spans 53 to 85 degrees to either side. The meshes have 24 elements per quadrant: the edge of the contact
    falls inside an element, which costs a few thousandths.
    """
    result = pressed_pin(clearance, approach)
    angle, exact = pin_in_hole(10.0, clearance, approach, (4.0, STEEL), (30.0, STEEL), n=200)
    found_at, found = along_edge(result.contacts[0], lambda x: np.arctan2(np.abs(x[:, 1]), x[:, 0]))
    target = np.interp(found_at, angle, exact)
    case = f"pin in a hole, clearance {clearance}, approach {approach}"
    row(case, "pressure L2", 0.0, np.linalg.norm(found - target) / np.linalg.norm(target), 5e-3, result.n_dofs)
    row(case, "pressure in the middle", exact[0], found[0], 3e-3, result.n_dofs)
    force = 20.0 * np.trapezoid(exact * np.cos(angle), angle)
    row(case, "force", force, -2 * result.contacts[0].force[0], 1e-3, result.n_dofs)


def test_snug_pin_needs_no_increments(row):
    """A pin without clearance: the contact's extent does not depend on the load, and pressure is linear in it.

    Source: the scaling of linear elasticity. Coordinates are rounded at 1e-15 of the radius, 1e-10 of
    the smaller approach.
    """
    small, large = (pressed_pin(0.0, approach).contacts[0] for approach in (1e-4, 1e-2))
    change = np.abs(large.pressure / 100 - small.pressure).max() / small.pressure.max()
    row("pin without clearance", "change of pressure / load", 0.0, change, 1e-8)


def receding_layer(thickness=1.0, strip=0.25, load=1.0):
    """Results of half a free layer on a plane under a strip, at the load and at a thousandth of it."""
    material = fc.Material(E=1 - 0.3**2, nu=0.3)
    along = [*np.linspace(0, 1.2, 25), 1.4, 1.7, 2.1, 2.7, 3.5, 5.0]
    mesh = fc.shapes.block((5.0, 0.2, thickness), (along, 1, 8))
    mesh = mesh.with_boundary("strip", lambda x: (x[:, 2] > thickness - 1e-9) & (x[:, 0] < strip + 1e-9))
    plane_strain = {"x_min": "x", "y_min": "y", "y_max": "y"}
    layer = fc.ElasticBody(mesh, material, "bottom", plane_strain, name="layer")
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene([layer, floor], [fc.Contact(layer, floor)])
    return [scene.solve(pressures={(layer, "strip"): q}) for q in (load / strip / 2, 1e-3 * load / strip / 2)]


def test_receding_layer(row):
    """Receding contact: a free layer on a frictionless plane under a strip. Source: Filon's layer by transforms."""
    thickness, strip, load = 1.0, 0.25, 1.0
    results = receding_layer(thickness, strip, load)
    exact_at, exact = layer_on_rigid_plane(thickness, 1.0, strip, load, n=200)
    x, found = along_edge(results[0].contacts[0], lambda points: points[:, 0])
    target = np.interp(x, exact_at, exact, right=0.0)
    n = results[0].n_dofs
    # corner nodes lie one way and mid-side nodes the other (3e-4), and the edge falls inside an element (3e-3)
    row("layer that recedes", "pressure L2", 0.0, np.linalg.norm(found - target) / np.linalg.norm(target), 5e-3, n)
    row("layer that recedes", "pressure below the load", exact[0], found[0], 1e-3, n)
    # the edge lies between the last node in contact and the next, half an element of 0.025 apart
    row("layer that recedes", "half-width / thickness", exact_at[exact > 0].max(), x[found > 0].max(), 0.04, n)
    # a receding contact does not grow with the load: pressures are proportional to it
    light = along_edge(results[1].contacts[0], lambda points: points[:, 0])[1]
    row("layer that recedes", "pressure / load, light", 0.0, np.abs(1e3 * light - found).max() / found.max(), 1e-9, n)


@pytest.mark.by_day("radii0-0.008")
@pytest.mark.parametrize(("radii", "most"), [((50.0, 50.0), 8e-3), ((50.0, 20.0), 8e-3)])
def test_crossed_cylinders(radii, most, row):
    """Two cylinders crossed at right angles: a circle or an ellipse. Source: Hertz; Johnson 1985, chapter 4."""
    force = 500.0
    hertz = fc.hertz.ellipse(((radii[0], np.inf), (radii[1], np.inf)), (STEEL, STEEL), force=force, angle=np.pi / 2)
    extent = 12 * hertz.a
    disc = fc.shapes.cylinder(extent, extent, contact_radius=np.sqrt(hertz.a * hertz.b), sector="quarter")

    def body(radius, name):
        def bend(x):
            drop = x[:, 0] ** 2 / (radius + np.sqrt(radius**2 - x[:, 0] ** 2))
            return x + np.stack([0 * drop, 0 * drop, drop * (1 - x[:, 2] / extent)], axis=1)

        return fc.ElasticBody(disc.mapped(bend), STEEL, "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"}, name=name)

    upper = body(radii[0], "upper")
    lower = body(radii[1], "lower").placed(rotation=fc.rotation_about((1, 1, 0), np.pi))
    result = fc.Scene([upper, lower], [fc.Contact(upper, lower)]).solve(forces={upper: (0, 0, -force / 4)})
    contact = result.contacts[0]
    case = f"crossed cylinders, radii {radii[0]:.0f} and {radii[1]:.0f}"
    centre = contact.pressure[np.argmin(np.hypot(*contact.points[:, :2].T))]
    row(case, "centre pressure", hertz.p0, centre, most, result.n_dofs)
    for axis, length, which in ((0, hertz.a, "longer"), (1, hertz.b, "shorter")):
        # sum(F x^2) / sum(F) = a^2 / 5 for Hertz's ellipsoid of pressure
        found = np.sqrt(5 * (contact.forces @ contact.points[:, axis] ** 2) / contact.forces.sum())
        row(case, f"{which} semi-axis, by moments", length, found, 4e-3, result.n_dofs)


@pytest.mark.parametrize(("load", "most"), [(0.003, 0.01), (0.03, 0.02)])
def test_torus_on_a_half_space(load, most, row):
    """A ring of contact (multiply connected): a torus on a half-space. Source: Hertz's strip along a ring load.

    A ring of line load q gives 2q/(pi E*) ln(8R/s) near itself, and the mean of ln(1/s) under a half-ellipse of
    half-width a is ln(2/a) + 1/2, so that approach = 2q/(pi E*) (ln(16R/a) + 1/2) for a << R (Argatov, Li, Pohrt &
    Popov, Proc. R. Soc. A 472, 2016, have the same leading terms). The next terms are of order (a/R)^2 ln(R/a).
    """
    ring, tube, n = 1.0, 0.25, 512
    unit = fc.Material(E=1.0, nu=0.0)
    contact = fc.HalfSpace(unit, size=(3.0, 3.0), cells=(n, n)).press(Torus(ring=ring, tube=tube), force=load)
    q = load / (2 * np.pi * ring)
    a = np.sqrt(4 * q * tube / np.pi)
    case = f"torus, a/R = {a:.3f}"
    row(case, "approach", 2 * q / np.pi * (np.log(16 * ring / a) + 0.5), contact.approach, most)
    row(case, "peak pressure", 2 * q / (np.pi * a), contact.pressure.max(), 3 * most)
    row(case, "width of the ring, to half a cell at each edge", 2 * a, contact.area / (2 * np.pi * ring), 1.5 / n / a)
    row(case, "regions", 1, contact.n_regions, 1e-12)


def rounded_punch_pressure(exact, flat, r):
    """The exact pressure inside the contact, from a table of p / sqrt(1 - r^2): good to 1e-5, a hundredth of the error.

    Each exact value is a double integral; a grid of 512 cells has ten thousand different radii.
    """
    spread = (1 - np.cos(np.linspace(0, np.pi, 150))) / 2  # radii crowd at both ends, the end of the flat among them
    table = np.concatenate([flat * spread, flat + (1 - flat) * spread[1:-1]])
    return np.sqrt(1 - r**2) * np.interp(r, table, exact.pressure(table) / np.sqrt(1 - table**2))


@pytest.mark.by_day("128")
@pytest.mark.parametrize("n", [128, 256, 512])
def test_punch_with_a_rounded_edge(n, row):
    """A flat punch with a rounded edge: pressure is finite but steep. Source: Galin-Sneddon integrals of the profile.

    The profile is flat to b = 0.6 and rises as (r - b)^2/2 beyond; the contact ends at a = 1. Errors are of first order
    in the cell, as everywhere at a square-root edge.
    """
    flat = 0.6
    unit = fc.Material(E=1.0, nu=0.0)
    exact = axisymmetric.indent(modulus=1.0, slope=lambda r: np.maximum(r - flat, 0), breaks=(flat,), a=1.0)
    half = fc.HalfSpace(unit, size=(3.0, 3.0), cells=(n, n))
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    contact = half.press(np.maximum(r - flat, 0) ** 2 / 2, force=exact.force)
    target = np.zeros_like(r)
    target[r < 1] = rounded_punch_pressure(exact, flat, r[r < 1])
    error = np.linalg.norm((contact.pressure - target)[r < 1.2]) / np.linalg.norm(target)
    case = f"punch with a rounded edge, {n} cells"
    row(case, "pressure L2", 0.0, error, 2.0 / n)
    row(case, "approach", exact.approach, contact.approach, 0.1 / n)
    row(case, "area", np.pi, contact.area, 3.0 / n)
