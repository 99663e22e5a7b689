"""Which rigid components of a body are held, moved, loaded or free; and the loads."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import InputError, SupportError
from fecontact.contact.loads import LoadStep
from fecontact.contact.rigid_motion import constrain_rigid_motion
from fecontact.fem.rigid import COMPONENTS

STEEL = fc.Material(E=210e3, nu=0.3, density=2.0)
Q = fc.rotation_about((1, 2, 3), 0.7)


def cube(supports=None, **options):
    mesh = fc.shapes.block((1.0, 1.2, 0.9), (2, 2, 2))
    return fc.ElasticBody(mesh, STEEL, contact="top", supports=supports or {}, **options)


def components(motions):
    """Names of the pure components that span motions, or None if they do not."""
    scaled = motions / np.linalg.norm(motions, axis=0) if motions.size else motions
    projector = scaled @ scaled.T
    names = [c for k, c in enumerate(COMPONENTS) if abs(projector[k, k] - 1) < 1e-9]
    return set(names) if len(names) == motions.shape[1] else None


HELD = {"bottom": "xyz"}
# two planes of symmetry leave only z
SLIDE = {"x_min": "x", "y_min": "y"}


@pytest.mark.parametrize(
    ("supports", "arguments", "released", "mean_held"),
    [
        (HELD, {}, set(), set()),
        (HELD, {"force": (0, 0, -1)}, {"z"}, set()),
        (HELD, {"force": (0, 0, -1), "free": "rx ry"}, {"z", "rx", "ry"}, set()),
        (HELD, {"moment": (0, 2, 0)}, {"ry"}, set()),
        (HELD, {"motion": {"z": 0.1}}, set(), set()),
        (HELD, {"motion": {"z": 0.1}, "free": ["rx"]}, {"rx"}, set()),
        ({}, {}, set(COMPONENTS), set()),
        ({}, {"motion": {"z": 0.1}}, {"x", "y", "rx", "ry", "rz"}, {"z"}),
        ({}, {"motion": dict.fromkeys(COMPONENTS, 0.0)}, set(), set(COMPONENTS)),
        (SLIDE, {}, {"z"}, set()),
        (SLIDE, {"motion": {"z": -0.1}}, set(), {"z"}),
        (SLIDE, {"force": (1, 0, -1)}, {"x", "z"}, set()),
        (HELD, {"moment": (0, 2, 0), "force": (0, 0, -1)}, {"z", "ry"}, set()),
        ({"bottom": "z"}, {}, {"x", "y", "rz"}, set()),
    ],
)
def test_sorting_of_components(supports, arguments, released, mean_held):
    frame = constrain_rigid_motion(cube(supports), **arguments)
    assert components(frame.free) == released
    assert components(frame.mean_held) == mean_held


def test_a_hinge_that_is_not_a_component():
    # a turn about the bottom's middle line is a mixture of a turn and a translation of the centre of mass
    body = cube({"bottom": "xy", "x_min": "x"})
    frame = constrain_rigid_motion(body)
    assert frame.free.shape == (6, 2)
    field = frame.modes(frame.free).reshape(-1, 3, 2)
    assert np.abs(field[body.mesh.boundary_nodes("bottom")][:, :2]).max() < 1e-12
    assert np.abs(field[body.mesh.boundary_nodes("x_min")][:, 0]).max() < 1e-12
    assert components(frame.free) is None


@pytest.mark.parametrize("value", [1, 1.0, np.int64(1), np.float32(1.0)])
def test_numbers_of_every_kind_are_taken(value):
    assert constrain_rigid_motion(cube(HELD), motion={"z": value}).prescribed[2] == 1.0


def test_components_of_a_turned_body_are_world_components():
    body = cube(SLIDE).placed(rotation=fc.rotation_about((0, 1, 0), np.pi / 2))
    assert components(constrain_rigid_motion(body).free) == {"x"}
    turned = cube().placed(rotation=Q, translation=(5, 6, 7))
    frame = constrain_rigid_motion(turned, motion={"z": 0.1})
    field = turned.pose.rotation @ frame.modes(frame.prescribed[:, None])[:3, 0]
    assert np.abs(field - [0, 0, 0.1]).max() < 1e-15


def test_modes_are_displacements_about_the_reference_point():
    body = cube().placed(rotation=Q, translation=(5, 6, 7))
    frame = constrain_rigid_motion(body)
    motion = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    world = body.pose.to_world(body.mesh.points)
    expected = motion[:3] + np.cross(motion[3:], world - frame.point)
    found = frame.modes(motion[:, None])[:, 0].reshape(-1, 3) @ Q.T
    assert np.abs(found - expected).max() < 1e-13


def test_a_spread_load_has_the_resultant_it_stands_for():
    body = cube().placed(rotation=Q, translation=(5, 6, 7))
    loading = LoadStep({body: (1, 2, 3)}, {body: (-1, 0.5, 2)}).on([body])
    assert loading.frames[0].spread
    assert np.abs(loading.resultant(0) - [1, 2, 3, -1, 0.5, 2]).max() < 1e-12
    f = loading.distributed[0].reshape(-1, 3) @ Q.T
    assert np.abs(f.sum(axis=0) - [1, 2, 3]).max() < 1e-12


def test_a_load_on_a_supported_body_acts_through_its_supports():
    body = cube(HELD)
    loading = LoadStep({body: (0, 0, -3)}).on([body])
    assert not loading.frames[0].spread
    assert loading.distributed[0] is None
    assert np.array_equal(loading.resultant(0), [0, 0, -3, 0, 0, 0])


def test_boundary_forces_pressures_and_gravity():
    body = cube(HELD).placed(rotation=Q, translation=(5, 6, 7))
    volume = 1.0 * 1.2 * 0.9

    def resultant(**given):
        return LoadStep.of(given).on([body]).resultant(0)

    force = resultant(forces={(body, "x_max"): (1, 2, 3)})
    arm = Q @ ([1.0, 0.6, 0.45] - body.reference_point)
    assert np.abs(force - [1, 2, 3, *np.cross(arm, [1, 2, 3])]).max() < 1e-12
    assert np.abs(resultant(gravity=(0, 0, -9.81)) - [0, 0, -9.81 * 2 * volume, 0, 0, 0]).max() < 1e-11
    pressed = resultant(pressures={(body, "top"): 4.0})
    assert np.abs(pressed[:3] - Q @ [0, 0, -4.0 * 1.2]).max() < 1e-12
    both = resultant(forces={(body, "x_max"): (1, 2, 3), body: (0, 0, 1)}, pressures={(body, "top"): 4.0})
    assert np.abs(both - force - pressed - [0, 0, 1, 0, 0, 0]).max() < 1e-12


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"force": (1, 2)}, ("not-a-vector", "The force on 'body'", "three")),
        ({"force": (1, 2, np.nan)}, ("not-a-vector", "The force on 'body'", "three")),
        ({"moment": "a lot"}, ("not-a-vector", "The moment on 'body'", "three")),
        ({"motion": {"w": 1.0}}, ("unknown-component", "'w'", "x, y, z, rx, ry, rz")),
        ({"motion": {"z": "far"}}, ("not-finite", "The motion 'z' of 'body'")),
        ({"motion": {"z": np.inf}}, ("not-finite", "The motion 'z' of 'body'")),
        ({"free": "rx rw"}, ("unknown-component", "['rw']")),
        ({"force": (0, 0, 1), "motion": {"z": 1.0}}, ("input", "in z")),
        ({"free": "z", "motion": {"z": 1.0}}, ("input", "in z")),
    ],
)
def test_bad_arguments(arguments, words):
    with refused(InputError, *words):
        constrain_rigid_motion(cube(HELD), **arguments)


def test_bad_loads():
    body, other, rigid = cube(HELD), cube(HELD, name="other"), fc.RigidBody(fc.Plane())

    def loading(**given):
        return LoadStep.of(given).on([body, rigid])

    for given, words in [
        ({"forces": {other: (0, 0, 1)}}, ("not-in-scene", "'other'")),
        ({"forces": {"body": (0, 0, 1)}}, ("load-key", "'body', 'rigid'")),
        ({"forces": {("body", "top"): (0, 0, 1)}}, ("load-key", "'body'")),
        ({"forces": {("body", (0, 0, 0)): (0, 0, 1)}}, ("load-key", "'body'")),
        ({"moments": {"body": (0, 0, 1)}}, ("load-key", "'body'")),
        ({"motions": {"body": {"z": 1.0}}}, ("load-key", "'body'")),
        ({"free": {"body": "z"}}, ("load-key", "'body'")),
        ({"pressures": {("body", "top"): 1.0}}, ("load-key", "'body'")),
        ({"forces": {(other, "top"): (0, 0, 1)}}, ("not-in-scene", "'other'")),
        ({"forces": {body.placed(): (0, 0, 1)}}, ("not-in-scene", "One of that name is, but it is another object")),
        ({"moments": {other: (0, 0, 1)}}, ("not-in-scene", "'other'")),
        ({"motions": {other: {"z": 1.0}}}, ("not-in-scene", "'other'")),
        ({"free": {other: "z"}}, ("not-in-scene", "'other'")),
        ({"pressures": {(other, "top"): 1.0}}, ("not-in-scene", "'other'")),
        ({"pressures": {(body, "lid"): 1.0}}, ("unknown-boundary", "'lid'", "'top'")),
        ({"pressures": {(body, "top"): np.nan}}, ("not-finite", "The pressure on 'top' of 'body'")),
        ({"pressures": {body: 1.0}}, ("load-key",)),
        ({"pressures": {(rigid, "surface"): 1.0}}, ("needs-elastic-body", "'rigid'")),
        ({"forces": {(rigid, "surface"): (0, 0, 1)}}, ("needs-elastic-body", "'rigid'")),
        ({"forces": {(body, "lid"): (0, 0, 1)}}, ("unknown-boundary", "'lid'", "'top'")),
        ({"forces": {(body, "top"): (0, 1)}}, ("not-a-vector", "three")),
        ({"forces": {(body, "top", 1): (0, 0, 1)}}, ("load-key",)),
        ({"gravity": (0, 0)}, ("not-a-vector", "Gravity", "three")),
    ]:
        with refused(InputError, *words):
            loading(**given)
    weightless = fc.ElasticBody(body.mesh, fc.Material(E=1.0, nu=0.3), pressure="nodal", supports=HELD)
    with refused(InputError, "no-density"):
        LoadStep(gravity=(0, 0, -1)).on([weightless])


def test_an_oblique_load_releases_its_own_direction_only():
    # so that a scene turned together with its load is the same scene
    frame = constrain_rigid_motion(cube(HELD), force=(0.0, 0.6, -0.8))
    assert frame.free.shape == (6, 1)
    direction = frame.free[:3, 0] / np.linalg.norm(frame.free[:3, 0])
    assert abs(abs(direction @ [0.0, 0.6, -0.8]) - 1) < 1e-12


def test_force_at_a_point_of_the_frame_has_its_moment():
    # statics: a force beside the centre of a supported block is that force and its moment on the frame
    body = cube(HELD, name="block")
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, 5.0), fc.rotation_about((1, 0, 0), np.pi))
    point, force = np.array([2.0, -1.0, 0.0]), np.array([1.0, 2.0, 3.0])
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={(body, tuple(point)): force})
    reaction = result.reaction(body)
    expected = np.concatenate([-force, -np.cross(point - body.reference_point, force)])
    assert np.abs(reaction - expected).max() < 1e-9


def test_force_at_a_node_is_carried_by_the_body():
    body = cube(HELD, name="block")
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, 5.0), fc.rotation_about((1, 0, 0), np.pi))
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    result = scene.solve(forces={(body, (1.0, 1.2, 0.9)): (0, 0, -1.0)})
    corner = np.argmin(np.linalg.norm(body.mesh.points - [1.0, 1.2, 0.9], axis=1))
    assert result.displacement(body)[corner, 2] < 0
    assert np.abs(result.reaction(body)[:3] - [0, 0, 1.0]).max() < 1e-9


def test_large_strains_and_turns_are_warned_of():
    soft = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), fc.Material(1.0, 0.3), "bottom", {"top": "xyz"})
    plane = fc.RigidBody(fc.Plane())
    scene = fc.Scene([soft, plane], [fc.Contact(soft, plane)])
    assert scene.solve(motions={soft: {"z": -0.001}}).warnings == ()
    pressed = scene.solve(motions={soft: {"z": -0.2}})
    assert any("strained by" in text for text in pressed.warnings)
    assert "Warning:" in str(pressed)
    turned = scene.solve(motions={soft: {"rx": 0.1}}, finite_motion=False)
    assert any("finite_motion='auto'" in text for text in turned.warnings)


EXTREME = [1e300, 1e150, 1e101, 1e-101, 1e-160, 1e-300, 5e-324]


@pytest.mark.parametrize("size", EXTREME)
def test_numbers_beyond_reckoning_are_refused(size):
    # their squares overflow or vanish: a force of 1e300 came back as F = 0
    body = cube(HELD)
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, 0.9), fc.rotation_about((1, 0, 0), np.pi))
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    with refused(InputError, "out-of-scale", "The force on 'body'", f"{size:g}"):
        scene.solve(forces={body: (0, 0, size)})
    with refused(InputError, "out-of-scale", "The force on 'top'"):
        scene.solve(forces={(body, "top"): (0, 0, size)})
    with refused(InputError, "out-of-scale", "The moment on 'body'"):
        scene.solve(moments={body: (0, size, 0)})
    with refused(InputError, "out-of-scale", "The motion 'z' of 'body'"):
        scene.solve(motions={body: {"z": size}})
    with refused(InputError, "out-of-scale", "The pressure on 'top'"):
        scene.solve(pressures={(body, "top"): size})
    with refused(InputError, "out-of-scale", "Gravity"):
        scene.solve(gravity=(0, 0, size))
    with refused(InputError, "out-of-scale", "Young's modulus E"):
        fc.Material(E=size, nu=0.3)


@pytest.mark.parametrize("force", [1e-100, 1e-99, 1e99, 1e100])
def test_forces_up_to_the_limits_are_carried(force):
    # two-sided: the last decades that are accepted give the force, not zero; small components beside it are fine
    body = cube(HELD)
    plane = fc.RigidBody(fc.Plane()).placed((0, 0, 0.9), fc.rotation_about((1, 0, 0), np.pi))
    scene = fc.Scene([body, plane], [fc.Contact(body, plane)])
    result = scene.solve(forces={body: (1e-320, 0, force)})
    assert abs(result.contacts[0].total_force / force - 1) < 1e-12


@pytest.mark.parametrize("length", [1e-100, 1e-31, 1e31, 1e100])
def test_meshes_beyond_reckoning_are_refused(length):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)).scaled(length)
    with refused(InputError, "out-of-scale", "The size of the mesh"):
        fc.ElasticBody(mesh, STEEL)
    section = fc.sections.rectangle((1.0, 1.0), (1, 1))
    with refused(InputError, "out-of-scale", "The size of the mesh"):
        fc.PlaneBody(type(section)(section.points * length, section.cells), STEEL)


@pytest.mark.parametrize("length", [1e-28, 1e28])
def test_meshes_up_to_the_limits_are_solved(length):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)).scaled(length)
    body, plane = fc.ElasticBody(mesh, STEEL, "bottom", {"top": "xyz"}), fc.RigidBody(fc.Plane())
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={body: (0, 0, -1.0)})
    assert abs(result.contacts[0].total_force - 1) < 1e-12


def on_a_floor(turn):
    block = cube(HELD, name="block").placed(rotation=turn)
    floor = fc.RigidBody(fc.Plane()).placed(turn @ [0, 0, 0.9], turn @ fc.rotation_about((1, 0, 0), np.pi))
    return block, fc.Scene([block, floor], [fc.Contact(block, floor)])


@pytest.mark.parametrize("turn", [np.eye(3), Q])
def test_a_load_across_what_contacts_resist_is_refused(turn):
    # 10 sideways and 1 upwards against a frictionless ceiling: the wedge carried 101
    block, scene = on_a_floor(turn)
    with refused(SupportError, "free-motion", "motion that nothing resists - block: translation along"):
        scene.solve(forces={block: turn @ [10, 0, 1]})
    # from both sides of the tolerance of 1e-5
    with refused(SupportError, "free-motion", "block: translation along"):
        scene.solve(forces={block: turn @ [1.1e-5, 0, 1]})
    for sideways in (0.0, 0.9e-5):
        force = scene.solve(forces={block: turn @ [sideways, 0, 1]}).contacts[0].total_force
        assert abs(force - 1) < 1e-9
    with refused(SupportError, "free-motion", "block: rotation about"):
        scene.solve(forces={block: turn @ [0, 0, 1]}, moments={block: turn @ [0.01, 0, 0.1]})


def test_the_component_that_nothing_resists_is_named_and_can_be_held():
    block, scene = on_a_floor(np.eye(3))
    with refused(SupportError, "free-motion", "block: translation along x."):
        scene.solve(forces={block: (10, 0, 1)})
    held = scene.solve(forces={block: (0, 0, 1)}, motions={block: {"x": 0.0}})
    assert abs(held.contacts[0].total_force - 1) < 1e-9


@pytest.mark.parametrize("at", [(0.6, 0.9, 0.3), (1.0, 1.0, 0.0), (0.2, 0.5, -2.0)])
def test_a_force_at_a_point_of_a_rigid_body_is_carried_with_its_moment(at):
    # a rigid plate on three legs, its reference point elsewhere: the legs' resultant is the force, at its point
    legs = [
        fc.ElasticBody(fc.shapes.block((0.2, 0.2, 1.0), (1, 1, 2)), STEEL, "top", HELD, name=f"leg {k}").placed(t)
        for k, t in enumerate([(0, 0, -1), (2, 0, -1), (0, 3, -1)])
    ]
    plate = fc.RigidBody(fc.Plane(), name="plate").placed((5, 5, 0), fc.rotation_about((1, 0, 0), np.pi))
    scene = fc.Scene([*legs, plate], [fc.Contact(leg, plate) for leg in legs])
    point = tuple(plate.pose.to_body(np.array(at)))
    result = scene.solve(forces={(plate, point): (0, 0, -0.1)})
    forces = np.array([c.total_force for c in result.contacts])
    centres = np.array([c.centre_of_pressure for c in result.contacts])
    assert forces.min() > 1e-3
    assert abs(forces.sum() - 0.1) < 1e-9
    assert np.abs(forces @ centres[:, :2] / 0.1 - at[:2]).max() < 1e-6
    # beyond the legs the plate tips, and a point that may not turn is held by its moment
    with refused(SupportError, "free-motion", "plate: rotation about"):
        scene.solve(forces={(plate, tuple(plate.pose.to_body(np.array([3.0, 3.0, 0.0])))): (0, 0, -0.1)})
    upright = scene.solve(forces={(plate, point): (0, 0, -0.1)}, motions={plate: dict.fromkeys(("rx", "ry", "rz"), 0)})
    assert abs(upright.reaction(plate)[3:]).max() > 1e-3


def test_a_force_at_a_point_in_plane_and_axisymmetric_scenes():
    section = fc.sections.rectangle((1.0, 1.0), (2, 2))
    punch = fc.RigidBody(fc.Plane(), name="punch").placed((0, 0, 1), fc.rotation_about((1, 0, 0), np.pi))
    slab = fc.PlaneBody(section, STEEL, "top", {"bottom": "xz"})
    result = fc.Scene([slab, punch], [fc.Contact(slab, punch)]).solve(forces={(punch, (0.45, 0.0, 0.0)): (0, 0, -1.0)})
    contact = result.contacts[0]
    assert abs(contact.total_force - 1) < 1e-9
    assert abs(contact.centre_of_pressure[0] - 0.45) < 1e-6
    with refused(InputError, "motion-not-in-plane", "in rx"):
        fc.Scene([slab, punch], [fc.Contact(slab, punch)]).solve(forces={(punch, (0.45, 0.1, 0.0)): (0, 0, -1.0)})
    disc = fc.AxisymmetricBody(section, STEEL, "top", {"bottom": "xz"})
    ring = fc.Scene([disc, punch], [fc.Contact(disc, punch)]).solve(forces={(punch, (0.45, 0.0, 0.0)): (0, 0, -1.0)})
    assert abs(ring.contacts[0].force[2]) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    ("supports", "arguments", "in_vain"),
    [
        ({}, {"free": "z"}, {"z"}),  # all six are free
        ({}, {"free": "z", "motion": dict.fromkeys(("x", "y", "rx", "ry", "rz"), 0.0)}, set()),  # z alone is left
        (SLIDE, {"free": "z"}, set()),  # only z is free, as is said
        (SLIDE, {"free": "x"}, set()),  # x is supported
        (HELD, {"free": "z rx"}, set()),
    ],
)
@pytest.mark.parametrize("turn", [np.eye(3), Q])
def test_components_that_are_freed_in_vain_are_known(supports, arguments, in_vain, turn):
    body = cube(supports)
    if not supports or turn is not Q:  # turned planes of symmetry do not span world components
        found = constrain_rigid_motion(body.placed((3.0, 1.0, 0.0), turn), **arguments)
        assert {COMPONENTS[c] for c in found.freed_in_vain} == in_vain


def test_a_result_notes_components_that_are_freed_in_vain():
    block = cube().placed((0.5, 0.6, 0.9), fc.rotation_about((1, 0, 0), np.pi))
    plane = fc.RigidBody(fc.Plane(), name="plane")
    scene = fc.Scene([block, plane], [fc.Contact(block, plane)])
    held = dict.fromkeys(("x", "y", "rx", "ry", "rz"), 0.0)
    for motions, n in (({}, 1), ({block: held}, 0)):
        result = scene.solve(forces={block: (0, 0, -10.0)}, free={block: "z"}, motions=motions, finite_motion=False)
        assert len([text for text in result.notes if "changes nothing" in text]) == n


def test_motions_that_hold_tilts_of_their_body_are_warned_of():
    """A block guided at its top slides on a floor.

    With the tilt free it turns about its top, by 0.004 over its height, and the floor drags it an eighth as much.
    """
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3))
    body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3, density=1.0), "bottom", {"top": "xy"}, name="body")
    scene = fc.Scene([body, floor := fc.RigidBody(fc.Plane())], [fc.Contact(body, floor, friction=0.3)])
    moved = {"motions": {body: {"x": 0.004}}}, {"displacements": {(body, "top"): (0.004, 0.0, 0.0)}}
    both = {"motions": {body: {"x": 0.004, "ry": 0.0}}}
    results = [scene.solve(forces={body: (0, 0, -0.02)}, finite_motion=False, **given) for given in (*moved, both)]
    drags = [-result.contacts[0].force[0] for result in results]
    assert abs(drags[0] / drags[2] - 1) < 1e-9
    assert 7 < drags[0] / drags[1] < 10
    told = [[text for text in result.warnings if "by the mean position" in text] for result in results]
    assert [len(texts) for texts in told] == [1, 0, 0]
    assert "'body' in x holds" in told[0][0]
    assert not constrain_rigid_motion(cube(SLIDE), motion={"z": -0.1}).held_beside
    assert not constrain_rigid_motion(cube(), motion={"z": -0.1, "x": 0.0}).held_beside
    assert not constrain_rigid_motion(cube(HELD), motion={"z": -0.1}).held_beside
