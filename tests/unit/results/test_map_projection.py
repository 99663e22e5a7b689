"""Maps of contacts: flat, and conforming ones unrolled."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import SurfaceMesh, extrude
from fecontact.mesh.shapes import Level
from fecontact.results.pictures.map_projection import CylinderMap, FlatMap, SphereMap, facet_planes, map_of

STEEL = fc.Material(E=210e3, nu=0.3)
RADIUS, HEIGHT = 10.0, 8.0


@pytest.fixture(scope="module")
def pin_in_bore():
    """A pin pressed along x into a bore that fits closely; it touches more than a third of the way round."""
    ring = fc.shapes.thick_ring(RADIUS, 20.0, HEIGHT, (8, 1, 1), sector="full")
    pin = fc.shapes.thick_ring(4.0, RADIUS - 1e-3, HEIGHT, (8, 1, 1), sector="full")
    bore = fc.ElasticBody(ring, STEEL, "inner", {"outer": "xyz"}, name="bore")
    held = fc.ElasticBody(pin, STEEL, "outer", {"inner": "yz"}, name="pin")
    return fc.Scene([bore, held], [fc.Contact(held, bore)]).solve(forces={held: (8e3, 0, 0)})


@pytest.fixture(scope="module")
def ball_in_socket():
    """A rigid ball pressed obliquely into a layer on the inside of a hemispherical shell."""
    cut = Level(core=2, rings=4, edge=0.1, layer=1.0, growth=1.2)
    disc = SurfaceMesh.of(fc.shapes.cylinder(1.0, 1.0, contact_radius=0.8, level=cut), "cap")

    def onto_sphere(x):
        r, edge = np.hypot(x[:, 0], x[:, 1]), np.radians(85.0)
        across = RADIUS * np.divide(np.sin(r * edge), r, out=np.full_like(r, edge), where=r > 0)
        return np.stack([across * x[:, 0], across * x[:, 1], -RADIUS * np.cos(r * edge)], axis=1)

    cup = fc.ElasticBody(extrude(disc.mapped(onto_sphere), 2.0), fc.Material(E=12.0, nu=0.4), "base", {"top": "xyz"})
    ball = fc.RigidBody(fc.Sphere(RADIUS - 0.05)).placed((0, 0, 0.05 - RADIUS))  # its lowest point
    return fc.Scene([cup, ball], [fc.Contact(cup, ball)]).solve(motions={ball: {"x": 0.1, "z": -0.2}})


def test_a_pin_in_a_bore_is_unrolled(pin_in_bore):
    (contact,) = pin_in_bore.contacts
    projection = map_of(contact)
    assert isinstance(projection, CylinderMap)
    assert projection.names == ("arc about z", "z")
    assert abs(projection.radius / RADIUS - 1) <= 1e-3  # the pin's is 1e-4 smaller, faces are quadratic
    assert np.abs(projection.flat(contact.centre_of_pressure) - [0.0, HEIGHT / 2]).max() <= 1e-6 * RADIUS
    # a cylinder unrolls without stretch: areas on the map are those of the facets, up to chords of the curved faces
    flat = projection.of_facets(contact.nodes[contact.facets[:, :4]])
    across = flat[:, [2, 3]] - flat[:, [0, 1]]
    mapped = np.abs(across[:, 0, 0] * across[:, 1, 1] - across[:, 0, 1] * across[:, 1, 0]) / 2
    assert np.abs(mapped.sum() / (2 * np.pi * RADIUS * HEIGHT) - 1) <= 1e-3
    assert projection.shows(*facet_planes(contact)[:2]).all()


def test_directions_on_a_cylinder_keep_their_lengths(pin_in_bore):
    (contact,) = pin_in_bore.contacts
    projection = map_of(contact)
    around = np.cross([0.0, 0.0, 1.0], contact.points) / np.hypot(*contact.points[:, :2].T)[:, None]
    for vectors, expected in ((around, [1.0, 0.0]), (np.tile([0.0, 0.0, 1.0], (len(around), 1)), [0.0, 1.0])):
        found = projection.directions(contact.points, vectors)
        # differences over 1e-6 of the radius; points lie on a circle 1e-4 smaller
        assert np.abs(found - expected).max() <= 1e-3


def test_pictures_of_a_bore_name_the_arc(pin_in_bore):
    for options in ({}, {"style": "sensels"}, {"what": "gap"}):
        axes = pin_in_bore.plot(**options).axes[0]
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("arc about z", "z")
        low, high = axes.get_xlim()
        assert -np.pi * RADIUS < low < 0 < high < np.pi * RADIUS
        assert abs(low + high) <= 1e-3 * RADIUS  # symmetric about the load


def test_maps_have_given_axes(pin_in_bore, ball_in_socket):
    """Given once on a scene or for a picture: unrolled ones name the axis, flat and laid out ones the directions."""
    given = {"distal": (0, 0, -1), "ulnar": (1, 0, 0)}
    axes = pin_in_bore.plot(axes=given, length="mm").axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("arc about distal [mm]", "distal [mm]")
    assert axes.get_ylim()[1] <= 0.05 * HEIGHT  # the bore is above z = 0
    assert ball_in_socket.plot(axes=given).axes[0].get_xlabel() == "arc towards ulnar"
    block = fc.ElasticBody(fc.shapes.block((1.0, 2.0, 1.0), (1, 1, 1)), STEEL, "bottom", {"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    anatomical = {"anterior": (0, 1, 0), "medial": (-1, 0, 0)}
    scene = fc.Scene([block, floor], [fc.Contact(block, floor)], units=("mm", "N"), axes=anatomical)
    table = scene.sweep([{"motions": {block: {"z": -1e-4}}}], keep="pressure")
    result = scene.solve(motions={block: {"z": -1e-4}})
    for drawn in (result.plot(), result.plot(style="sensels"), result.plot("gap")):
        axes = drawn.axes[0]
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("anterior → [mm]", "medial → [mm]")
        assert np.ptp(axes.get_xlim()) > np.ptp(axes.get_ylim())  # it is two wide along y
    assert "anterior → [mm]" in {a.get_xlabel() for a in table.montage().axes}
    with refused(fc.InputError, "input", "right angles"):
        result.plot(axes={"a": (1, 0, 0), "b": (1, 1, 0)})


def test_the_pressure_is_on_the_loaded_side(pin_in_bore):
    felt = pin_in_bore.plot(style="sensels").axes[0].collections[0]
    filled = felt.get_array().filled(0.0)
    corners = felt.get_coordinates()
    side = corners[0, 1, 0] - corners[0, 0, 0]
    force = filled.sum() * side**2
    # normal forces add up without directions; sensels below 2 % of the peak are left out
    assert abs(force / pin_in_bore.contacts[0].total_force - 1) <= 0.01


def test_a_flat_contact_is_shown_along_its_normal_and_leaves_out_what_faces_away():
    view = FlatMap(np.eye(3)[:2], np.eye(3)[2])
    turned = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.1]])
    assert view.shows(np.zeros((3, 3)), turned).tolist() == [True, False, True]
    assert view.names == ("x", "y")


@pytest.mark.parametrize(("turn", "names"), [(9.0, ("x", "y")), (13.0, ("x", "(0.00, 0.97, 0.22)"))])
def test_a_map_has_the_axes_of_the_world_where_they_are_near(turn, names):
    about = fc.rotation_about((1, 0, 0), np.radians(turn))
    cube = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    block = fc.ElasticBody(cube, STEEL, "bottom", {"top": "xyz"}).placed((0, 0, 0), about)
    floor = fc.RigidBody(fc.Plane()).placed((0, 0, 0), about)
    result = fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -1e-4}})
    assert map_of(result.contacts[0]).names == names


def test_a_sphere_is_laid_out_by_arcs_from_the_middle():
    sphere = SphereMap(np.eye(3), np.array([1.0, 2.0, 3.0]), 2.0)
    polar, azimuth = 1.1, 0.7
    d = np.array([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)])
    place = sphere.flat(sphere.centre + 2.0 * d)
    assert np.abs(place - 2.0 * polar * np.array([np.cos(azimuth), np.sin(azimuth)])).max() <= 1e-14
    middles = sphere.centre + 2.0 * np.array([[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0]])
    assert sphere.shows(middles, middles).tolist() == [True, False, True]


def test_a_ball_in_a_socket_is_laid_out_about_the_centre_of_pressure(ball_in_socket, tmp_path):
    (contact,) = ball_in_socket.contacts
    projection = map_of(contact)
    assert isinstance(projection, SphereMap)
    assert abs(projection.radius / RADIUS - 1) <= 1e-3
    assert np.abs(projection.centre).max() <= 1e-3 * RADIUS
    assert np.abs(projection.flat(contact.centre_of_pressure)).max() <= 1e-6 * RADIUS
    axes = ball_in_socket.plot("pressure", tmp_path / "socket.png").axes[0]
    assert axes.get_xlabel().startswith("arc towards")
    assert axes.get_xlim()[1] > 0.8 * RADIUS
