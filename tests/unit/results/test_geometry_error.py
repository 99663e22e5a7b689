"""What faces that are not smooth do to pressures: kinks, and what a mesh bears of them."""

import numpy as np
import pytest

import fecontact as fc
from fecontact import SurfaceMesh
from fecontact.analytic import hertz
from fecontact.results.geometry_error import BENT, kinks, seen_by_hats
from fecontact.results.warnings import coarse_pressures
from fecontact.surfaces import Facets

SOLID = fc.Material(E=1000.0, nu=0.3)


def test_the_pressure_of_chords_is_that_of_a_half_space():
    """Source: a half-space pressed by rows of parabolas, by transforms. The grid has 256 cells to a parabola."""
    n, angle = 256, 1e-3
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(1.0, 8 / n), cells=(n, 8), periodic=True)
    chords = angle / 2 * half.grid.x[:, None] ** 2 * np.ones(8)
    contact = half.press(chords, force=0.01 * 8 / n)
    assert contact.active.all()
    # one kink a length of one: parabolas of height angle / 8
    assert abs(np.std(contact.pressure) / (BENT * angle) - 1) < 0.02


def test_hats_see_of_chords_what_their_means_keep():
    """Source: gaps of a parabola under hats at random phases, averaged; a smooth wave's pressure goes with its gap."""
    period, width = 1.0, 0.31
    x = np.linspace(-width, width, 4001)
    hat = np.maximum(1 - np.abs(x) / width, 0)
    phase = np.linspace(0, period, 200, endpoint=False)
    s = (phase[:, None] + x) % period - period / 2
    means = (s**2 * hat).sum(axis=1) / hat.sum()
    waves = np.abs(np.fft.rfft(means))[1:9] * np.arange(1, 9)
    whole = np.abs(np.fft.rfft(((phase % period) - period / 2) ** 2))[1:9] * np.arange(1, 9)
    assert abs(np.sqrt((waves**2).sum() / (whole**2).sum()) / seen_by_hats(width / period) - 1) < 0.1


def ball(n, hollow=False):
    """A patch of a ball of radius 2, of linear facets."""
    t = np.linspace(-0.3, 0.3, n + 1)
    u, v = (c.ravel() for c in np.meshgrid(t, t, indexing="ij"))
    points = np.stack([2 * np.sin(u) * np.cos(v), 2 * np.sin(v), 2 * np.cos(u) * np.cos(v)], axis=1)
    k = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    facets = np.stack([k, k + n + 1, k + n + 2, k + 1], axis=1)
    return Facets(SurfaceMesh(points, facets[:, ::-1] if hollow else facets)), points


@pytest.mark.parametrize(("degrees", "n"), [(4, 3), (5, 10), (6, 6)])
def test_sides_that_all_turn_alike_are_all_of_them_but_for_rounding(degrees, n):
    """Their share is 1; rounding made it 1 + 2e-16 here, and a root of what is left of it no number."""
    t, k = np.radians(degrees * np.arange(n + 1)), np.arange(n)
    ring = np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    sides = np.stack([k, k + 1, k + n + 2, k + n + 1], axis=1)
    found = kinks(Facets(SurfaceMesh(np.concatenate([ring, ring + np.array([0, 0, 1])]), sides)), ring)
    assert 1 - 1e-12 < found.spread <= 1


@pytest.mark.parametrize("hollow", [False, True])
def test_kinks_of_a_ball(hollow):
    """Source: geometry. Facets of a size h turn by h / R in two directions."""
    n = 12
    surface, points = ball(n, hollow)
    found = kinks(surface, points)
    assert abs(found.angle / (0.6 / n) - 1) < 0.03
    assert abs(found.period / (2 * 0.6 / n) - 1) < 0.05
    assert abs(found.directions - 2) < 0.05
    assert found.spread > 0.99
    assert found.sign == (-1 if hollow else 1)


def test_edges_and_flat_faces_have_no_kinks():
    corner = fc.shapes.block((1.0, 1.0, 1.0), (3, 3, 3), element="hex8")
    body = fc.ElasticBody(corner, SOLID, ("top", "x_max"))
    surface = body.surface("top")
    assert kinks(surface, surface.points[surface.nodes]) is None
    skin = Facets(SurfaceMesh(corner.points, corner.face_nodes(corner.outer_faces)))
    assert kinks(skin, corner.points) is None


def roller(divided):
    """Half a roller of radius 10 whose surface is chords of 0.25, each divided, on a plane: error and result."""
    radius, a, far = 10.0, 0.5, 40.0
    exact = hertz.line((radius, np.inf), (None, SOLID), force=np.pi * SOLID.plane_strain_modulus * a**2 / 4 / radius)
    chords = np.concatenate([np.arange(0, 0.76, 0.25), np.geomspace(1.3, far, 8)])
    x = np.interp(np.arange(divided * (len(chords) - 1) + 1) / divided, np.arange(len(chords)), chords)
    z = np.concatenate([np.arange(0, 0.6, 0.25 / divided), np.geomspace(0.9, far, 8)])
    mesh = fc.sections.rectangle((far, far), (x, z), names=("middle", "side", "tip", "base"))
    height = np.where(chords < 2, chords**2, 4 * (chords - 1)) / (2 * radius)

    def bent(p):
        return p + np.stack(
            [0 * p[:, 0], 0 * p[:, 0], np.interp(p[:, 0], chords, height) * (1 - p[:, 2] / far)], axis=1
        )

    body = fc.PlaneBody(mesh.mapped(bent), SOLID, "tip", {"base": "z", "middle": "x"}, name="roller")
    plane = fc.RigidBody(fc.Plane(), name="plane")
    result = fc.Scene([body, plane], [fc.Contact(body, plane)]).solve(forces={plane: (0, 0, exact.force / 2)})
    contact = result.contacts[0]
    points, pressure, areas = contact.sampled(contact.pressure, 24)
    target = exact.pressure(points[:, 0])
    return float(np.sqrt((areas * (pressure - target) ** 2).sum() / (areas * target**2).sum())), result


@pytest.mark.parametrize("divided", [2, 4, 8])
def test_dividing_chords_does_not_mend_a_roller_and_the_estimate_knows(divided):
    """Source: Hertz. The error stays at a fifth; what estimates tell of the mesh alone falls below a tenth."""
    error, result = roller(divided)
    estimate = result.contacts[0].error_estimate
    assert 0.15 < error < 0.25
    assert 0.8 < estimate.pressure / error < 1.5
    assert estimate.geometry > 0.8 * error
    (text,) = coarse_pressures(result)
    assert "dividing the present ones does not help" in text


def rings(inner, outer, element="hex8", interference=0.01):
    """A ring of radius 1 shrunk on another, their faces of so many sides a quarter."""
    planes = {"sym_x": "x", "sym_y": "y", "bottom": "z", "top": "z"}
    pin = fc.shapes.thick_ring(0.5, 1.0 + interference, 0.2, (inner, 3, 1), element=element)
    hub = fc.shapes.thick_ring(1.0, 1.5, 0.2, (outer, 3, 1), element=element)
    one = fc.ElasticBody(pin, SOLID, "outer", planes, name="pin")
    other = fc.ElasticBody(hub, SOLID, "inner", planes, name="hub")
    contact = fc.Scene([one, other], [fc.Contact(one, other)]).solve().contacts[0]
    mean = contact.total_force / contact.weights.sum()
    spread = np.sqrt(contact.weights @ (contact.pressure / mean - 1) ** 2 / contact.weights.sum())
    return float(spread), contact.error_estimate


@pytest.mark.parametrize("sides", [(12, 17), (17, 12), (24, 12), (30, 41)])
def test_rings_of_polygons_are_off_by_about_what_is_estimated(sides):
    """Source: rotational symmetry, by which the pressure is uniform."""
    spread, estimate = rings(*sides)
    assert spread > 0.05
    assert 0.5 < estimate.pressure / spread < 3


@pytest.mark.parametrize(("inner", "outer", "element"), [(12, 12, "hex8"), (12, 17, "hex20"), (12, 24, "hex20")])
def test_matching_or_quadratic_rings_are_not(inner, outer, element):
    """Their geometry is no cause of error; what linear cells are too stiff by is another (`interior`)."""
    spread, estimate = rings(inner, outer, element)
    assert spread < 0.01
    assert estimate.geometry < 0.01
    assert estimate.pressure < 0.025
