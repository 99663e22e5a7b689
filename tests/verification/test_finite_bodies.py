"""Finite bodies: stress below a contact, tilted punch, ball in a socket, edges, artificial supports."""

import math

import numpy as np
import pytest

import fecontact as fc

STEEL = fc.Material(E=210e3, nu=0.3)
OVER = fc.rotation_about((1, 0, 0), math.pi)


def test_largest_shear_stress_lies_below_the_surface(row):
    """Stress below two spheres on the axis.

    Source: Johnson 1985, equations 3.45 and 3.46: sigma_z = -p0/(1 + s^2), sigma_r = -p0 ((1 + nu)(1 - s atan(1/s)) -
    1/(2 (1 + s^2))) with s = z/a; the shear is largest, 0.310 p0, at 0.481 a. Stresses go through nodes of elements of
    a tenth of a or more: two percent; the curve is flat round its maximum, which is looked for among nodes, so its
    place is good to an element.
    """
    hertz = fc.hertz.spheres((25.0, 25.0), (STEEL, STEEL), force=100.0)
    cut = fc.shapes.Level(core=6, rings=8, edge=0.012, layer=0.07)
    mesh = fc.sections.half_disc(25.0, contact_radius=hertz.a, level=cut, element="quad9")
    body = fc.AxisymmetricBody(mesh, STEEL, "cap", {"base": "xz"}, name="ball")
    plane = fc.RigidBody(fc.Plane())
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={body: (0, 0, -100.0)})
    hertz = fc.hertz.spheres((25.0, np.inf), (STEEL, None), force=100.0)
    axis = np.flatnonzero(np.abs(mesh.points[:, 0]) < 1e-12)
    axis = axis[np.argsort(mesh.points[axis, 2])]
    s = mesh.points[axis, 2] / hertz.a
    shear = np.abs(result.stress(body)[axis, 2] - result.stress(body)[axis, 0]) / 2
    near = (s > 0.1) & (s < 3)
    depth = s[near]
    radial = (1 + STEEL.nu) * (1 - depth * np.arctan(1 / depth)) - 0.5 / (1 + depth**2)
    exact = hertz.p0 * np.abs(1 / (1 + depth**2) - radial) / 2
    case, n = "1 sphere on a plane, stress on the axis", result.n_dofs
    row(
        case,
        "shear, largest error / p0, z from 0.1 a to 3 a",
        0.0,
        np.abs(shear[near] - exact).max() / hertz.p0,
        0.02,
        n,
    )
    row(case, "largest shear / p0", 0.310, shear[near].max() / hertz.p0, 0.02, n)
    row(case, "its depth / a", 0.481, depth[shear[near].argmax()], 0.15, n)


@pytest.mark.full
@pytest.mark.parametrize(("offset", "full"), [(0.2, True), (0.5, False)])
def test_tilted_punch_on_a_block(offset, full, row):
    """A flat punch under an eccentric load on a block of finite elements, free to tilt.

    Source: p = P/(2 pi a^2)(1 + 3 e x/a^2)/sqrt(1 - r^2/a^2), full contact up to e = a/3 (Johnson 1985). Statics holds
    to rounding. The singular edge is smeared over the last ring, and a block of 30 radii is a few percent stiffer than
    a half-space: four percent in the pressure inside 0.8 a, where 2.9 was found, six in tilt, where it was 2.6.
    """
    a, extent, load = 1.0, 30.0, 1000.0
    mesh = fc.shapes.cylinder(extent, extent, contact_radius=a, level=2, sector="half")
    symmetry = next(name for name in mesh.boundaries if name.startswith("sym"))
    held = {"base": "xyz", symmetry: symmetry[-1]}
    block = fc.ElasticBody(mesh, STEEL, "cap", held, name="block").placed(rotation=OVER)
    rigid = fc.RigidBody(fc.surfaces.FlatPunch(radius=a * (1 + 1e-9)), name="punch")
    across = "y" if symmetry[-1] == "x" else "x"
    lever = {"x": (0.0, offset * load / 2, 0.0), "y": (-offset * load / 2, 0.0, 0.0)}[across]
    about = {"x": "ry", "y": "rx"}[across]
    scene = fc.Scene([block, rigid], [fc.Contact(block, rigid)])
    # the source's tilt is small: no follower effects
    loads = {"forces": {rigid: (0, 0, -load / 2)}, "moments": {rigid: lever}, "free": {rigid: about}}
    result = scene.solve(**loads, finite_motion=False)
    contact, axis = result.contacts[0], "xy".index(across)
    case, n = f"4 tilted punch on a block, e = {offset} a", result.n_dofs
    centre = contact.forces @ contact.points[:, axis] / contact.forces.sum()
    row(case, "centre of pressure / a", offset, centre, 1e-9, n)
    row(case, "force", load / 2, contact.total_force, 1e-9, n)
    r = np.hypot(*contact.points[:, :2].T)
    inside = r < 0.8 * a
    if full:
        exact = fc.analytic.punch.flat(radius=a, modulus=STEEL.plane_strain_modulus, force=load, offset=offset)
        target = (
            load
            / (2 * np.pi * a**2)
            * (1 + 3 * offset * contact.points[:, axis])
            / np.sqrt(1 - np.minimum(r, 0.8) ** 2)
        )
        error = np.linalg.norm((contact.pressure - target)[inside]) / np.linalg.norm(target[inside])
        row(case, "pressure L2, r < 0.8 a", 0.0, error, 0.04, n)
        tilt = np.abs(result.rigid_motion(rigid).rotation).max()
        row(case, "tilt", abs(exact.tilt), tilt, 0.06, n)
    else:
        lifted = inside & (contact.points[:, axis] < -0.6 * a)
        row(case, "force where it lifts", 0.0, contact.forces[lifted].sum() / load, 1e-12, n)


def socket(clearance, around, force=None, approach=None):
    """A hollow ball on a rigid core in a socket, both bodies of revolution; elements of equal angle."""
    steps = np.array([0.0, 0.1, 0.3, 0.7, 1.4, 2.4, 4.0])
    inwards, outwards = 6 - clearance - np.array([*steps, 6 - clearance])[::-1], [*steps, 6.0, 10.0]
    ball_mesh = fc.sections.annulus(4.0, 10.0 - clearance, (around, inwards), element="quad9")
    cup_mesh = fc.sections.annulus(10.0, 20.0, (around, outwards), element="quad9")
    ball = fc.AxisymmetricBody(ball_mesh, STEEL, "outer", {"inner": "xz"}, name="ball").placed(rotation=OVER)
    cup = fc.AxisymmetricBody(cup_mesh, STEEL, "inner", {"outer": "xz"}, name="cup").placed(rotation=OVER)
    scene = fc.Scene([ball, cup], [fc.Contact(ball, cup)])
    if force is not None:
        # in touch from the start: a motion of half the clearance ratio would not be small
        ball = ball.placed((0, 0, -clearance))
        scene = fc.Scene([ball, cup], [fc.Contact(ball, cup)])
        return ball, scene.solve(forces={ball: (0, 0, -force)})
    return ball, scene.solve(motions={ball: {"z": -approach}})


def angle_of(contact):
    """Angle from the axis at which the moment sum(F r^2)/sum(F) lies, for a contact that is far from Hertz's."""
    r2 = contact.points[:, 0] ** 2
    return math.asin(math.sqrt(contact.forces @ r2 / contact.forces.sum()) / 10.0)


def test_ball_in_a_conforming_socket(row):
    """Conforming contact: a ball in a socket, contact up to some 50 degrees from the axis.

    Source: a refinement of itself, 96 elements in the quarter. The pressure's edge lies inside an element: first order
    in its width, weighted by the little force there: one percent for 24 elements, half for 48.
    """
    fine = socket(0.01, 96, approach=0.02)[1].contacts[0]
    for around, most in ((24, 0.01), (48, 0.005)):
        result = socket(0.01, around, approach=0.02)[1]
        contact, case, n = result.contacts[0], f"ball in a socket, {around} elements in the quarter", result.n_dofs
        top, best = (c.pressure[np.argmin(c.points[:, 0])] for c in (contact, fine))
        row(case, "force", fine.force[2], contact.force[2], most, n)
        row(case, "pressure on the axis", best, top, most, n)
        row(case, "angle of the pressure's moment", angle_of(fine), angle_of(contact), most, n)


def test_ball_in_a_socket_under_light_loads_is_hertzian(row):
    """A ball in a wide socket under light loads tends to Hertz, and leaves it as the contact conforms.

    Source: Hertz with radii 9.5 and -10. At a/R = 0.05 the walls are twelve contact radii thick and the contact is six
    elements wide, its edge within one: one percent. The last rows show what larger contacts do to Hertz.
    """
    for share, most in ((0.05, 0.01), (0.2, None), (0.4, None)):
        effective = 1 / (1 / 9.5 - 1 / 10.0)
        modulus = STEEL.plane_strain_modulus / 2
        force = 4 * modulus * (share * 10.0) ** 3 / (3 * effective)
        hertz = fc.hertz.spheres((9.5, -10.0), (STEEL, STEEL), force=force)
        _, result = socket(0.5, 192, force=force)
        contact, case, n = result.contacts[0], f"ball in a wide socket, a/R = {share}", result.n_dofs
        radius = math.sqrt(2.5 * contact.forces @ contact.points[:, 0] ** 2 / contact.forces.sum())
        row(case, "contact radius", hertz.a, radius, most, n)
        row(case, "pressure on the axis", hertz.p0, contact.pressure[np.argmin(contact.points[:, 0])], most, n)


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("divisions", [(15, 5), (11, 7)])
def test_block_wider_than_its_support(divisions, swapped, row):
    """Edge contact: a block that is wider than its support and set out of its middle, plane strain.

    Source: statics, exact whatever the elasticity: the force is the load's, it acts where the load does, and beside the
    support there is no force: the hat of a slave node beside the support by less than its width reaches under it and is
    integrated there only. The area that can carry is the support's.
    """
    n_upper, n_lower = divisions
    upper_mesh = fc.sections.rectangle((3.0, 1.0), (n_upper, 4), element="quad9", start=-1.4)
    lower_mesh = fc.sections.rectangle((1.0, 1.0), (n_lower, 4), element="quad9", start=-0.5)
    soft = fc.Material(E=1000.0, nu=0.3)
    upper = fc.PlaneBody(upper_mesh, soft, "bottom", name="upper").placed((0, 0, 1.0))
    lower = fc.PlaneBody(lower_mesh, soft, "top", {"bottom": "xz"}, name="support")
    pair = (lower, upper) if swapped else (upper, lower)
    scene = fc.Scene([upper, lower], [fc.Contact(*pair, swap="never")])
    # the load's direction stays: a pressure that follows the tilt has 1e-5 of it sideways
    result = scene.solve(pressures={(upper, "top"): 1.0}, motions={upper: {"x": 0.0}}, finite_motion=False)
    contact, n = result.contacts[0], result.n_dofs
    case = f"block on a narrower support, {n_upper}:{n_lower}{', swapped' if swapped else ''}"
    reaction = result.reaction(lower)
    row(case, "force", 3.0, abs(reaction[2]), 1e-10, n)
    row(case, "where it acts", 0.1, abs(reaction[4] / reaction[2]), 1e-9, n)
    width = 0.0 if swapped else 3.0 / (2 * n_upper)
    beside = np.abs(contact.points[:, 0]) > 0.5 + width + 1e-9
    row(case, "forces beside the support", 0.0, contact.forces[beside].sum(), 1e-12, n)
    row(case, "area that can carry", 1.0, contact.weights.sum(), 1e-9, n)
    row(case, "residual", 0.0, result.residuals().worst, 1e-9, n)


def test_forces_do_not_depend_on_the_artificial_supports(row):
    """Section IV of the report: a floating block is held somewhere; contact forces must not depend on where.

    Source: the default choice against three others, drawn at random. Loads in equilibrium put no reaction there;
    rounding, times the condition of the choice (less than 100).
    """
    rng, forces = np.random.default_rng(11), []
    for other in range(4):
        mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3))
        block = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "bottom", name="block")
        nodes = mesh.boundary_nodes("top")
        while other:
            dofs = np.sort(rng.choice((3 * nodes[:, None] + np.arange(3)).ravel(), 6, replace=False))
            if np.linalg.cond(block.model.rigid_modes[dofs]) < 100:
                block.model.__dict__["pinned_dofs"] = dofs
                break
        dome = fc.RigidBody(fc.Sphere(5.0), name="dome").placed((0.5, 0.5, 0.0), OVER)
        scene = fc.Scene([block, dome], [fc.Contact(block, dome)])
        motions = {block: {"x": 0.0, "y": 0.0, "rz": 0.0}}
        result = scene.solve(pressures={(block, "top"): 0.01}, motions=motions)
        forces.append(result.contacts[0].forces)
        if other:
            change = np.abs(forces[other] - forces[0]).max() / forces[0].max()
            row(f"13 artificial supports, choice {other}", "largest force change", 0.0, change, 1e-9, result.n_dofs)
