"""Scenes: small ones with known answers, free motions, and input that must be refused."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError, SolverNotFoundError, SupportError
from fecontact.contact import candidates

STEEL = fc.Material(E=210e3, nu=0.3)
CORK = fc.Material(E=1000.0, nu=0.0)
COARSE = fc.shapes.Level(core=1, rings=2, edge=0.25, layer=0.4, growth=2.5)
# small condensed problems; two different ways to the same numbers
SAME = 1e-9


def cube(material=CORK, contact="bottom", supports=None, element="hex20", divisions=(2, 2, 2), **options):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), divisions, element=element)
    return fc.ElasticBody(mesh, material, contact=contact, supports={"top": "xyz"} if supports is None else supports)


def floor(z=0.0):
    return fc.RigidBody(fc.Plane(), name="floor").placed(translation=(0, 0, z))


def ball(supports=None, element="hex8", material=STEEL):
    mesh = fc.shapes.sphere(1.0, contact_radius=0.05, level=COARSE, element=element)
    return fc.ElasticBody(mesh, material, contact="cap", supports=supports or {}, name="ball")


def dome(element="hex20", contact_radius=0.05, **options):
    mesh = fc.shapes.quarter_sphere(1.0, contact_radius=contact_radius, level=COARSE, element=element)
    supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    return fc.ElasticBody(mesh, STEEL, contact="cap", supports=supports, name="dome", **options)


def pressed(body, obstacle, **loads):
    return fc.Scene([body, obstacle], [fc.Contact(body, obstacle)]).solve(**loads)


def close(a, b, tolerance=SAME):
    return np.abs(np.asarray(a) - b).max() <= tolerance * np.abs(b).max()


# known answers


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_uniform_compression_without_poisson_effect(element):
    body, plane = cube(element=element), floor()
    result = pressed(body, plane, motions={body: {"z": -0.01}})
    (contact,) = result.contacts
    assert contact.active.all()
    assert close(contact.pressure, np.full(len(contact.points), 10.0))
    assert close(contact.force, [0, 0, 10.0])
    assert close(contact.centre_of_pressure, [0.5, 0.5, 0.0])
    assert np.abs(contact.gap).max() < 1e-15
    z = body.mesh.points[:, 2]
    assert np.abs(result.displacement(body) - np.outer(-0.01 * z, [0, 0, 1])).max() < 1e-14
    stress = result.stress(body)
    assert np.abs(stress - [0, 0, -10, 0, 0, 0]).max() < 1e-10
    assert result.residuals().worst < 1e-12
    assert result.status == "solved"
    assert result.success


def test_force_and_motion_are_two_ways_to_the_same_answer():
    body, plane = cube(STEEL), floor()
    moved = pressed(body, plane, motions={body: {"z": -0.01}})
    force = moved.contacts[0].force
    loaded = pressed(body, plane, forces={body: -force})
    assert close(loaded.contacts[0].forces, moved.contacts[0].forces)
    assert abs(loaded.rigid_motion(body).translation[2] + 0.01) < SAME * 0.01


def test_the_plane_may_be_pushed_instead_of_the_body():
    body, plane = cube(STEEL), floor()
    down = pressed(body, plane, motions={body: {"z": -0.01}})
    up = pressed(body, plane, motions={plane: {"z": 0.01}})
    by_force = pressed(body, plane, forces={plane: down.contacts[0].force})
    for other in (up, by_force):
        assert close(other.contacts[0].forces, down.contacts[0].forces)


def test_interference_of_two_blocks():
    # overlap d of two blocks of length 1 held at their far ends: stress E d / 2
    lower = cube(contact="top", supports={"bottom": "xyz"})
    upper = cube().placed(translation=(0, 0, 0.98), name="upper")
    result = pressed(upper, lower)
    assert close(result.contacts[0].pressure, np.full(len(result.contacts[0].points), CORK.E * 0.02 / 2))
    assert abs(result.displacement(lower)[:, 2].min() + 0.01) < SAME * 0.01


def test_block_between_two_plates():
    middle, below, above = cube(STEEL, contact=("bottom", "top"), supports={}), floor(), floor()
    above = fc.RigidBody(fc.Plane(), name="lid").placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    contacts = [fc.Contact(middle, below, ("bottom", "surface")), fc.Contact(middle, above, ("top", "surface"))]
    result = fc.Scene([middle, below, above], contacts).solve(motions={above: {"z": -0.01}})
    first, second = (c.pressure for c in result.contacts)
    # uniaxial stress of a floating block, whatever Poisson's ratio
    assert close(first, np.full(len(first), STEEL.E * 0.01))
    assert close(second, np.full(len(second), STEEL.E * 0.01))
    assert np.abs(result.contacts[0].force + result.contacts[1].force).max() < SAME * STEEL.E * 0.01


@pytest.mark.parametrize("offset", [(0.05, 0.0), (0.1, -0.08)])
def test_centre_of_pressure_lies_under_the_load(offset):
    # statics: a block free to turn on a floor; the load's moment about the centre fixes the centre of pressure
    body, plane = cube(STEEL, supports={}), floor()
    x, y = offset
    result = pressed(body, plane, forces={body: (0, 0, -100.0)}, moments={body: (-100.0 * y, 100.0 * x, 0)})
    assert np.abs(result.contacts[0].centre_of_pressure[:2] - [0.5 + x, 0.5 + y]).max() < SAME


def test_soft_on_stiff_tends_to_the_rigid_answer():
    soft = dome()
    plate = fc.shapes.block((1.5, 1.5, 0.5), (3, 3, 1)).translated((0, 0, -0.5))
    rigid = pressed(soft, floor(), motions={soft: {"z": -0.005}}).contacts[0].total_force
    errors = []
    for contrast in (1e3, 1e6):
        stiff = fc.ElasticBody(plate, fc.Material(STEEL.E * contrast, 0.3), contact="top", supports={"bottom": "xyz"})
        found = pressed(soft, stiff, motions={soft: {"z": -0.005}}).contacts[0].total_force
        errors.append(abs(found / rigid - 1))
    assert errors[1] < 1e-5
    # proportional to the compliance of the plate
    assert 500 < errors[0] / errors[1] < 2000


# free motions, supports and fix_null_space


@pytest.mark.parametrize("kind", ["force", "gravity"])
def test_ball_resting_on_a_plate_free_in_everything(kind):
    heavy = fc.Material(STEEL.E, STEEL.nu, density=1.0)
    body, plane = ball(material=heavy), floor()
    mass = body.model.mass_and_centre[0]
    loads = {"forces": {body: (0, 0, -50.0)}} if kind == "force" else {"gravity": (0, 0, -50.0 / mass)}
    result = pressed(body, plane, **loads)
    assert close(result.contacts[0].force, [0, 0, 50.0])
    assert np.abs(result.contacts[0].centre_of_pressure[:2]).max() < 1e-10
    # motions without load stay where they are
    motion = result.rigid_motion(body)
    assert np.abs(motion.translation[:2]).max() < 1e-9 * abs(motion.translation[2])
    assert np.abs(motion.rotation).max() < 1e-9 * abs(motion.translation[2])


@pytest.mark.parametrize(
    ("force", "moment", "words"),
    [
        ((0, 0, 10.0), (0, 0, 0), ("free-motion", "body: translation along z")),
        ((5.0, 0, -10.0), (0, 0, 0), ("free-motion", "body: translation along x")),
        ((0, 0, -10.0), (0, 0, 1.0), ("free-motion", "body: rotation about z")),
        ((0, 0, -10.0), (0, 8.0, 0), ("free-motion", "1")),
        ((0, 0, 0), (3.0, 0, 0), ("free-motion", "body: rotation about")),
    ],
)
def test_loads_that_no_contact_can_balance(force, moment, words):
    body, plane = cube(supports={}), floor()
    with refused(SupportError, *words) as caught:
        pressed(body, plane, forces={body: force}, moments={body: moment})
    assert "prescribe it with motions=" in str(caught.value)


def test_a_body_that_falls_free_is_named_with_its_motion():
    heavy = fc.Material(E=10.0, nu=0.0, density=1.0)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    body, plane = fc.ElasticBody(mesh, heavy, "top", name="body"), floor()
    ceiling = plane.placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    with refused(SupportError, "free-motion", "body: translation along z"):
        pressed(body, ceiling, gravity=(0, 0, -9.81))


@pytest.mark.parametrize("support", ["n", (1.0, 0.0, 1.0)])
def test_a_body_on_an_oblique_slide_is_named_with_its_motion(support):
    # the left face is cut under 45 degrees and held along its normal: gravity drives the block down the slide
    heavy = fc.Material(E=10.0, nu=0.0, density=1.0)
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).mapped(lambda x: x + np.outer(1 - x[:, 2], (1.0, 0, 0)))
    body = fc.ElasticBody(mesh, heavy, "top", {"x_min": support, "y_min": "y"}, name="body")
    ceiling = floor().placed((0, 0, 1.0), fc.rotation_about((1, 0, 0), np.pi))
    with refused(SupportError, "free-motion", "707", "-0"):
        pressed(body, ceiling, gravity=(0, 0, -9.81))


def test_a_load_just_inside_the_support_polygon_is_carried_by_the_edge():
    body, plane = cube(supports={}), floor()
    result = pressed(body, plane, forces={body: (0, 0, -10.0)}, moments={body: (0, 10.0 * 0.4999, 0)})
    assert abs(result.contacts[0].centre_of_pressure[0] - 0.9999) < SAME
    with pytest.raises(SupportError):
        pressed(body, plane, forces={body: (0, 0, -10.0)}, moments={body: (0, 10.0 * 0.5001, 0)})


def test_partly_held_components():
    # guided by two planes of symmetry and pressed by a force: the same as the quarter of a free block
    whole, plane = cube(STEEL, supports={}, divisions=(4, 4, 2)), floor()
    quarter = fc.ElasticBody(
        fc.shapes.block((0.5, 0.5, 1.0), (2, 2, 2)), STEEL, contact="bottom", supports={"x_min": "x", "y_min": "y"}
    )
    full = pressed(whole, plane, forces={whole: (0, 0, -4.0)})
    part = pressed(quarter, plane, forces={quarter: (0, 0, -1.0)})
    assert close(4 * part.contacts[0].force, full.contacts[0].force)
    assert abs(part.rigid_motion(quarter).translation[2] / full.rigid_motion(whole).translation[2] - 1) < SAME


@pytest.mark.parametrize("turned", [False, True])
def test_a_floating_body_is_moved_by_its_mean(turned):
    body, plane = ball(), floor()
    if turned:
        body = body.placed((0, 0, -1.0)).placed((0, 0, 1.0), fc.rotation_about((0, 0, 1), 0.4))
    down = {"x": 0.0, "y": 0.0, "z": -0.01, "rx": 0.0, "ry": 0.0, "rz": 0.0}
    result = pressed(body, plane, motions={body: down})
    motion = result.rigid_motion(body)
    assert np.abs(motion.translation - [0, 0, -0.01]).max() < SAME * 0.01
    assert np.abs(motion.rotation).max() < SAME * 0.01
    opposite = pressed(body, plane, motions={body: dict.fromkeys(down, 0.0), plane: {"z": 0.01}})
    assert close(opposite.contacts[0].forces, result.contacts[0].forces)
    assert np.abs(opposite.rigid_motion(body).translation).max() < SAME * 0.01
    # and the same as its load prescribed, which is spread over the mass in both cases
    loaded = pressed(body, plane, forces={body: -result.contacts[0].force})
    assert close(loaded.contacts[0].forces, result.contacts[0].forces, 1e-8)
    assert abs(loaded.rigid_motion(body).translation[2] + 0.01) < 1e-8 * 0.01


def test_a_floating_body_partly_moved_and_partly_free():
    body, plane = ball(), floor()
    result = pressed(body, plane, motions={body: {"z": -0.01}})
    fixed = pressed(body, plane, motions={body: dict.fromkeys(("x", "y", "rx", "ry", "rz"), 0.0) | {"z": -0.01}})
    assert abs(result.rigid_motion(body).translation[2] + 0.01) < SAME * 0.01
    assert close(result.contacts[0].forces, fixed.contacts[0].forces, 1e-8)


def test_mean_hold_with_distributed_loads():
    # a block held by its mean under pressure on one side: the side's force is taken by the held component
    body, plane = cube(STEEL, supports={"x_min": "x", "y_min": "y"}), floor()
    still = pressed(body, plane, motions={body: {"z": -0.001}})
    pushed = pressed(body, plane, motions={body: {"z": -0.001}}, pressures={(body, "top"): 5.0})
    assert abs(pushed.rigid_motion(body).translation[2] + 0.001) < SAME * 0.001
    # spread over the mass the same force would not squeeze the block; from the top it does, against the mean
    assert pushed.contacts[0].total_force != still.contacts[0].total_force
    assert pushed.residuals().worst < 1e-10


def test_forces_do_not_depend_on_the_grounded_dofs(monkeypatch):
    body, plane = ball(), floor()
    loads = {"forces": {body: (0, 0, -50.0)}}
    forces = pressed(body, plane, **loads).contacts[0].forces
    mesh = body.mesh
    nodes = np.unique(np.concatenate([mesh.boundary_nodes("flank"), mesh.boundary_nodes("far_cap")]))
    rng = np.random.default_rng(11)
    for _ in range(3):
        other = ball()
        modes = other.model.rigid_modes
        while True:
            dofs = np.sort(rng.choice((3 * nodes[:, None] + np.arange(3)).ravel(), 6, replace=False))
            if np.linalg.cond(modes[dofs]) < 100:
                break
        other.model.__dict__["pinned_dofs"] = dofs
        again = pressed(other, plane, forces={other: (0, 0, -50.0)})
        assert np.array_equal(other.model.pinned_dofs, dofs)
        assert close(again.contacts[0].forces, forces)


# touching, not touching, growing


def test_surfaces_that_never_meet_give_exact_zeros():
    body, plane = dome(), floor(-1.0)
    result = pressed(body, plane, motions={body: {"z": -0.5}})
    assert result.status == "no-contact"
    assert result.success
    contact = result.contacts[0]
    assert not contact.forces.any()
    assert contact.area == contact.total_force == contact.max_pressure == contact.mean_pressure == 0
    assert np.isnan(contact.centre_of_pressure).all()
    assert contact.regions == ()
    assert np.abs(result.displacement(body) - [0, 0, -0.5]).max() < 1e-15
    assert abs(contact.gap.min() - 0.5) < 1e-15
    assert result.residuals().worst == 0
    assert "no-contact" in str(result)


def test_moved_apart():
    body, plane = dome(), floor()
    assert pressed(body, plane, motions={body: {"z": 0.1}}).status == "no-contact"


@pytest.mark.parametrize("extra", [0.0, 1e-9])
def test_first_touch_is_at_one_node(extra):
    body, plane = dome(), floor(-0.01)
    result = pressed(body, plane, motions={body: {"z": -0.01 - extra}})
    contact = result.contacts[0]
    assert result.success
    assert contact.active.sum() <= 1
    if extra:
        assert contact.points[contact.active].tolist() == [[0.0, 0.0, 0.0]]
        assert abs(contact.gap[contact.active][0]) < 1e-15


def test_light_load_on_the_first_node():
    body, plane = dome(), floor()
    contact = pressed(body, plane, forces={body: (0, 0, -1e-6)}).contacts[0]
    assert contact.active.sum() == 1
    assert abs(contact.total_force - 1e-6) < 1e-15


@pytest.mark.parametrize("loads", ["force", "motion"])
def test_candidates_that_were_too_few_grow(monkeypatch, loads):
    body, plane = dome(), floor()
    given = {"forces": {body: (0, 0, -300.0)}} if loads == "force" else {"motions": {body: {"z": -0.005}}}
    enough = pressed(body, plane, **given)
    monkeypatch.setattr(candidates, "MARGIN", 0.01)
    monkeypatch.setattr(candidates, "MIN_CANDIDATES", 1)
    few = pressed(body, plane, **given)
    assert few.rounds > 1
    assert enough.n_active > 10
    assert close(few.contacts[0].forces, enough.contacts[0].forces)
    assert few.residuals().penetration < 1e-9


def test_everything_in_contact_and_regions():
    mesh = fc.shapes.block((3.0, 1.0, 1.0), (6, 2, 2))
    projection = mesh.with_boundary("left", lambda x: (x[:, 2] == 0) & (x[:, 0] <= 1)).with_boundary(
        "right", lambda x: (x[:, 2] == 0) & (x[:, 0] >= 2)
    )
    body = fc.ElasticBody(projection, CORK, contact=("left", "right"), supports={"top": "xyz"})
    plane = floor()
    both = [fc.Contact(body, plane, (name, "surface")) for name in ("left", "right")]
    result = fc.Scene([body, plane], both).solve(motions={body: {"z": -0.01}})
    left, right = result.contacts
    assert len(left.regions) == len(right.regions) == 1
    assert close(left.forces.sum(), right.forces.sum())
    assert left.active.any()
    region = left.regions[0]
    assert abs(region.area - left.area) < 1e-14
    assert close(region.force, left.force)


def test_two_contacts_give_two_regions():
    # one boundary, lifted in the middle: a foot at each end
    mesh = fc.shapes.block((3.0, 1.0, 1.0), (6, 2, 2)).mapped(
        lambda x: x + np.outer(0.1 * (1 - x[:, 2]) * np.exp(-8 * (x[:, 0] - 1.5) ** 2), [0, 0, 1])
    )
    body = fc.ElasticBody(mesh, STEEL, contact="bottom", supports={"top": "xyz"})
    contact = pressed(body, floor(), motions={body: {"z": -0.001}}).contacts[0]
    assert len(contact.regions) == 2
    assert abs(sum(r.area for r in contact.regions) - contact.area) < 1e-14
    assert close(sum(r.force for r in contact.regions), contact.force)
    ends = sorted(r.centre_of_pressure[0] for r in contact.regions)
    assert ends[0] < 1.2
    assert ends[1] > 1.8


# choices


def test_the_side_with_nodes_is_the_slave_whichever_is_named_first():
    body, plane = cube(), floor()
    result = fc.Scene([body, plane], [fc.Contact(plane, body)]).solve(motions={body: {"z": -0.01}})
    assert result.contacts[0].slave is body
    assert "made the slave" in result.contacts[0].note
    with pytest.warns(PendingDeprecationWarning, match="force is that on 'floor', which the contact names first"):
        assert close(result.contacts[0].force, [0, 0, -10.0])


def test_the_finer_side_is_made_the_slave_and_it_is_said():
    coarse, fine = cube(divisions=(2, 2, 1)), cube(contact="top", supports={"bottom": "xyz"}, divisions=(3, 3, 1))
    fine = fine.placed((0, 0, -1.0), name="fine")
    scene = fc.Scene([coarse, fine], [fc.Contact(coarse, fine, coupling="nodal")])
    contact = scene.solve(motions={coarse: {"z": -0.01}}).contacts[0]
    assert contact.slave is fine
    assert "do not match" in contact.note
    assert "'fine' is finer and was made the slave" in contact.note
    kept = fc.Scene([coarse, fine], [fc.Contact(coarse, fine, swap="never")])
    contact = kept.solve(motions={coarse: {"z": -0.01}}).contacts[0]
    assert contact.slave is coarse
    assert "do not match" in contact.note


def test_backends_give_the_same_answer():
    forces = []
    for backend in ("auto", "superlu"):
        body = dome(backend=backend)
        forces.append(pressed(body, floor(), forces={body: (0, 0, -300.0)}).contacts[0].forces)
    assert close(forces[1], forces[0])


def test_every_solver_gives_the_same_answer():
    body, plane = dome(), floor()
    loads = {"forces": {body: (0, 0, -300.0)}}
    reference = pressed(body, plane, **loads).contacts[0].forces
    for solver in ("wolfe", "active-set", "nnls", "projected-cg"):
        if solver in fc.available_solvers():
            # all certified answers agree to 1e-8
            assert close(pressed(body, plane, solver=solver, **loads).contacts[0].forces, reference, 1e-8), solver


# the result


def test_result_speaks():
    body, plane = dome(), floor()
    result = pressed(body, plane, forces={body: (0, 0, -300.0)})
    text = str(result)
    for word in ("dome", "floor", "Residuals", "Seconds", "pressure max"):
        assert word in text
    summary = result.summary()
    assert summary["n_dofs"] == body.n_dofs
    assert summary["n_active"] == result.n_active == result.contacts[0].active.sum()
    assert abs(summary["contacts"][0]["force"][2] - 300) < 1e-9
    assert set(result.seconds) >= {"pair", "assemble", "factorise", "condense", "solve", "total"}
    contact = result.contacts[0]
    points, values, areas = contact.sampled(contact.pressure)
    # nodal weights and samples are two quadratures of one field; the midpoint rule of 4 x 4 samples leaves 0.3 percent
    assert abs(values @ areas / 300 - 1) < 5e-3
    assert points.shape == (len(values), 3)
    moment = np.cross(contact.points - contact.reference_point, contact.forces[:, None] * contact.normals).sum(axis=0)
    assert np.abs(contact.moment - moment).max() < 1e-12 * np.abs(moment).max()
    base = result.boundary_motion(body, "base")
    assert np.abs(base - result.rigid_motion(body).translation).max() < 1e-15
    assert result.strain(body).shape == (len(body.mesh.points), 6)


def test_result_refuses_strangers():
    body, plane = cube(), floor()
    result = pressed(body, plane, motions={body: {"z": -0.01}})
    with refused(InputError, "input", "not a body of this result"):
        result.displacement(cube())
    with refused(InputError, "rigid", "'floor'"):
        result.stress(plane)
    with refused(InputError, "unknown-boundary", "'lid'"):
        result.boundary_motion(body, "lid")


def test_the_one_pair_of_surfaces_that_faces_is_taken():
    """In a stack of blocks and in a row of balls; not where two pairs do, or none is near."""
    low = cube(contact=("bottom", "top"), supports={})
    high = low.placed((0, 0, 1.0), name="high")
    assert fc.Contact(low, high).surfaces == ("top", "bottom")
    assert fc.Contact(high, low).surfaces == ("bottom", "top")
    assert fc.Contact(low, floor()).surfaces == ("bottom", "surface")
    sixths = tuple(f"{axis}_{end}" for axis in "xyz" for end in ("min", "max"))
    ball = fc.ElasticBody(fc.shapes.ball(1.0), fc.Material(1.0, 0.3), contact=sixths)
    assert fc.Contact(ball, ball.placed((0, 2.0, 0), name="next")).surfaces == ("y_max", "y_min")
    for place, count in (((1.42, 1.42, 0), "4 of their"), ((0, 3.0, 0), "0 of their")):
        with refused(InputError, "several-surfaces", count):
            fc.Contact(ball, ball.placed(place, name="next"))


# input that must be refused


def test_bad_contacts():
    body, plane, two = cube(), floor(), cube(contact=("bottom", "top"), supports={})
    for call, words in [
        (lambda: fc.Contact(body, body), ("one-body",)),
        (lambda: fc.Contact(two, plane.placed((0, 0, -1.0))), ("several-surfaces", "'bottom', 'top'", "0 of their")),
        (lambda: fc.Contact(cube(contact=()), plane), ("several-surfaces", "none")),
        (lambda: fc.Contact(body, plane, ("top", "surface")), ("no-contact-surface", "'top'", "'body'")),
        (lambda: fc.Contact(body, plane, ("lid", "surface")), ("unknown-boundary", "'lid'", "'x_min'")),
        (lambda: fc.Contact(body, plane, ("bottom",)), ("input", "pair of names")),
        (lambda: fc.Contact(body, plane, swap="sometimes"), ("unknown-name", "'auto', 'never'")),
    ]:
        with refused(InputError, *words):
            call()


def test_bad_scenes():
    body, plane = cube(), floor()
    contact = fc.Contact(body, plane)
    with refused(InputError, "no-contact"):
        fc.Scene([body, plane], [])
    with refused(InputError, "not-in-scene", "'floor'"):
        fc.Scene([body], [contact])
    with refused(InputError, "input", "listed twice"):
        fc.Scene([body, body, plane], [contact])
    ceiling = floor(1.0)
    with refused(InputError, "none-elastic"):
        fc.Scene([plane, ceiling], [fc.Contact(plane, ceiling)]).solve()


def test_surfaces_that_do_not_face_each_other():
    lower = cube(contact="top", supports={"bottom": "xyz"})
    upper = cube().placed((7.0, 0, 1.0), name="upper")
    with refused(InputError, "not-facing", "'bottom' of 'upper'", "'top' of 'body'"):
        pressed(upper, lower)


def test_bad_solve_arguments():
    body, plane, stranger = cube(), floor(), cube()
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    with refused(InputError, "not-in-scene"):
        scene.solve(forces={stranger: (0, 0, -1)})
    with refused(SolverNotFoundError, "unknown-solver", "'simplex'", "active-set"):
        scene.solve(motions={body: {"z": -0.01}}, solver="simplex")
    for tolerance in (-1.0, 0.0, np.nan):
        with refused(InputError, "no-share", "The tolerance"):
            scene.solve(motions={body: {"z": -0.01}}, tolerance=tolerance)
    with refused(InputError, "unknown-option", "'speed'"):
        scene.solve(motions={body: {"z": -0.01}}, speed=9)
    with refused(InputError, "unknown-option", "'motion', did you mean 'motions'?"):
        scene.solve(motion={body: {"z": -0.01}})


def test_nothing_long_happens_before_a_bad_load_is_refused(monkeypatch):
    body, plane = cube(supports={}), floor()
    monkeypatch.setattr("fecontact.fem.model.assemble_stiffness", lambda *a: pytest.fail("assembled"))
    with pytest.raises(SupportError):
        pressed(body, plane, forces={body: (0, 0, 1.0)})
    with pytest.raises(SolverNotFoundError):
        pressed(body, plane, forces={body: (0, 0, -1.0)}, solver="simplex")


def test_rounding_in_normals_does_not_open_a_contact():
    # a block free to slide along x: normals off by 1e-17 once let a slide of 1e11 lift nodes that were no candidates
    low = cube(STEEL, "top", {"bottom": "z", "y_min": "y"}, divisions=(1, 1, 1))
    up = cube(STEEL, "bottom", {"top": "z", "y_min": "y"}, divisions=(3, 3, 1)).placed((0, 0, 1), name="up")
    result = pressed(up, low, motions={up: {"z": -2e-2, "ry": 3e-2}}, finite_motion=False)
    contact = result.contacts[0]
    assert close(contact.pressure, STEEL.E * (1e-2 + 1.5e-2 * (contact.points[:, 0] - 0.5)))
    assert np.abs(result.rigid_motion(up).translation[0]) < 1.0


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_rounding_in_normals_does_not_balance_a_tangential_load(angle):
    Q = fc.rotation_about((1, 2, 0), angle)
    low = cube(STEEL, "top", {"bottom": "xyz"}, divisions=(1, 1, 1)).placed(rotation=Q)
    up = cube(STEEL, "bottom", {}, divisions=(3, 3, 1)).placed((0, 0, 1)).placed(rotation=Q, name="up")
    with refused(SupportError, "free-motion", "up: translation"):
        pressed(up, low, forces={up: Q @ [1.0, 0, -100.0]})


def test_load_that_the_first_candidates_cannot_balance_takes_in_more():
    # a block a little tilted, whose lower end alone gives the candidates: they do not hold a load on its middle
    mesh = fc.shapes.block((4.0, 1.0, 1.0), (8, 2, 2))
    body = fc.ElasticBody(
        mesh.mapped(lambda x: x + [0, 0, 1] * (0.01 * (4 - x[:, :1]))), CORK, "bottom", {"top": "xyz"}
    )
    plane = fc.RigidBody(fc.Plane())
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    result = scene.solve(forces={body: (0, 0, -1e-6)}, free={body: "ry"})
    assert abs(result.contacts[0].total_force / 1e-6 - 1) < 1e-9
    assert abs(result.residuals().equilibrium) < 1e-9
    assert result.rounds > 1


def test_steady_rolling_is_refused_with_what_to_take():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    with refused(InputError, "rolling-of-scenes", "HalfSpace.roll"):
        fc.Scene([body, floor], [fc.Contact(body, floor)]).roll(creepage=(1e-3, 0.0))
