"""Thermal strains beside closed forms: free expansion, clamped bars, hot cylinders, rings shrunk on each other.

Sources: B. A. Boley and J. H. Weiner, Theory of Thermal Stresses, 1960, sections 3.9 (fields without stress) and 9.10
(hollow cylinders); S. Timoshenko and J. N. Goodier, Theory of Elasticity, 3rd ed., article 28 (Lame), 150 and 151.
"""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc

A, T, E, NU = 2e-5, 50.0, 210e3, 0.3
STEEL = fc.Material(E, NU, expansion=A)
ROUNDING = 1e-10


def heated(body, change):
    """Fields inside a body that nothing touches."""
    hot, none = body._heated(change), sp.csr_matrix((0, body.n_dofs))
    u = body.displacement(none, np.zeros(0), hot.forces)
    return replace(body._inner_fields(u, none, np.zeros(0)), heated=hot)


def stressing(inner):
    """Strains at the Gauss points that have stress."""
    return np.nan_to_num(inner.model.stressing(inner.u, inner.heated))


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
@pytest.mark.parametrize("integration", ["full", "selective"])
def test_free_expansion_is_without_stress(element, integration):
    """Also of crooked cells: strains are a T in every direction."""
    mesh = fc.shapes.block((1.0, 2.0, 3.0), (2, 2, 3), element=element)
    mesh = mesh.mapped(lambda x: x + 0.03 * np.sin(3 * x[:, [1, 2, 0]]))
    body = fc.ElasticBody(mesh, STEEL, integration=integration)
    inner = heated(body, lambda x: np.full(len(x), T))
    assert np.abs(stressing(inner)).max() <= ROUNDING * A * T
    # up to a turn, as nothing holds it: lengths between points
    x, u = body.mesh.points, inner.u.reshape(-1, 3)
    longer = np.einsum("ni,ni->n", u[1:] - u[0] - A * T * (x[1:] - x[0]), x[1:] - x[0])
    assert np.abs(longer).max() <= 1e-9 * A * T


def test_temperatures_linear_in_place_are_without_stress():
    """u_x = a (c x^2 / 2 - c (y^2 + z^2) / 2) and so on: quadratic cells have it exactly."""
    body = fc.ElasticBody(fc.shapes.block((1.0, 2.0, 3.0), (2, 2, 3)), STEEL)
    assert np.abs(stressing(heated(body, lambda x: x @ [10.0, -20.0, 5.0]))).max() <= 1e-9 * A * 50


@pytest.mark.parametrize("kind", ["stress", "strain", "axis"])
def test_free_sections_expand(kind):
    """Plane stress and bodies of revolution freely; plane strain by (1 + nu) a T, with E a T across."""
    mesh = fc.sections.ring(1.0, 2.0, 1.0, (3, 2))
    revolved = kind == "axis"
    body = fc.AxisymmetricBody(mesh, STEEL) if revolved else fc.PlaneBody(mesh, STEEL, plane=kind, thickness=2.0)
    inner = heated(body, lambda x: np.full(len(x), T))
    stress, strain = inner.stress() / (E * A * T), inner.strain() / (A * T)
    across = -1.0 if kind == "strain" else 0.0
    assert np.abs(stress - [0, across, 0, 0, 0, 0]).max() <= 1e-9
    wanted = [1 + NU, 0, 1 + NU, 0, 0, 0] if kind == "strain" else [1, 1, 1, 0, 0, 0]
    assert np.abs(strain - wanted).max() <= 1e-9


@pytest.mark.parametrize("gap", [0.0, 1e-3])
def test_a_bar_between_two_walls(gap):
    """It presses by E (a T L - gap) / L, and stores E e^2 / 2."""
    L = 3.0
    mesh = fc.shapes.block((1.0, 1.0, L), (1, 1, 3))
    bar = fc.ElasticBody(mesh, STEEL, "top", {"bottom": "z", "x_min": "x", "y_min": "y"})
    wall = fc.RigidBody(fc.Plane()).placed((0, 0, L + gap), np.diag([1.0, -1.0, -1.0]))
    result = fc.Scene([bar, wall], [fc.Contact(bar, wall)]).solve(temperatures={bar: T})
    e = A * T - gap / L
    assert np.abs(result.contacts[0].pressure - E * e).max() <= 1e-9 * E * e
    assert np.abs(result.stress(bar)[:, 2] + E * e).max() <= 1e-9 * E * e
    assert abs(result.reaction(bar, "bottom")[2] - E * e) <= 1e-9 * E * e
    assert abs(result.strain_energy(bar) - L * E * e**2 / 2) <= 1e-9 * E * e**2
    assert np.abs(result.strain(bar)[:, 2] - gap / L).max() <= 1e-9 * A * T
    _, inside = result.fields_at(bar, [[0.3, 0.4, 1.1]])
    assert abs(inside[0, 2] + E * e) <= 1e-9 * E * e
    assert result.residuals().equilibrium <= ROUNDING


def test_units_and_the_frame_change_nothing():
    found = []
    for size, stress, Q in ((1.0, 1.0, np.eye(3)), (1e-3, 1e6, fc.rotation_about((1, 2, 3), 0.7))):
        mesh = fc.shapes.block((1.0, 1.0, 2.0), (2, 2, 2)).mapped(lambda x, size=size: size * x)
        material = fc.Material(E * stress, NU, expansion=A)
        bar = fc.ElasticBody(mesh, material, "top", {"bottom": "xyz"}).placed(rotation=Q)
        wall = fc.RigidBody(fc.Plane()).placed((0, 0, 2 * size), np.diag([1.0, -1.0, -1.0])).placed(rotation=Q)
        change = lambda x, size=size: T * (1 + x[:, 0] / size)  # noqa: E731
        result = fc.Scene([bar, wall], [fc.Contact(bar, wall)]).solve(temperatures={bar: change}, finite_motion=False)
        found.append((result.displacement(bar) @ Q / size, result.contacts[0].pressure / stress))
    for one, other in zip(*found, strict=True):
        assert np.abs(one - other).max() <= 1e-9 * np.abs(one).max()


def test_a_hot_hollow_cylinder():
    """Plane strain, T = log(b / r) / log(b / a) times the inner one: Boley and Weiner, section 9.10."""
    a, b = 1.0, 3.0
    mesh = fc.sections.ring(a, b, 0.2, (32, 1), element="quad9")
    body = fc.AxisymmetricBody(mesh, STEEL, supports={"top": "z", "bottom": "z"})
    hot = lambda x: T * np.log(b / x[:, 0]) / np.log(b / a)  # noqa: E731
    r = mesh.points[:, 0]
    inner, outer = a**2, b**2
    scale = E * A * T / (2 * (1 - NU) * np.log(b / a))
    radial = scale * (-np.log(b / r) - inner / (outer - inner) * (1 - outer / r**2) * np.log(b / a))
    hoop = scale * (1 - np.log(b / r) - inner / (outer - inner) * (1 + outer / r**2) * np.log(b / a))
    stress = heated(body, hot).stress()
    assert np.abs(stress[:, 0] - radial).max() <= 2e-3 * E * A * T
    assert np.abs(stress[:, 1] - hoop).max() <= 2e-3 * E * A * T
    along = NU * (radial + hoop) - E * A * hot(mesh.points)
    assert np.abs(stress[:, 2] - along).max() <= 2e-3 * E * A * T


def test_a_ring_shrunk_on_another():
    """Heated by T the inner ring presses as one that is a T b too large does: Lame's rings, free along the axis."""
    a, b, c = 1.0, 2.0, 3.0
    one, other = (fc.sections.ring(*radii, 0.2, (10, 1), element="quad9") for radii in ((a, b), (b, c)))
    inner = fc.AxisymmetricBody(one, STEEL, "outer", {"bottom": "z"}, name="inner")
    outer = fc.AxisymmetricBody(other, STEEL, "inner", {"bottom": "z"}, name="outer")
    scene = fc.Scene([inner, outer], [fc.Contact(inner, outer)])
    p = E * A * T * (b**2 - a**2) * (c**2 - b**2) / (2 * b**2 * (c**2 - a**2))
    result = scene.solve(temperatures={inner: T}, finite_motion=False)
    assert np.abs(result.contacts[0].pressure - p).max() <= 1e-4 * p
    assert result.warnings == ()  # forces all round a ring cancel: no estimate is of their sum
    # cooled, the outer ring grips as hard
    result = scene.solve(temperatures={outer: -T}, finite_motion=False)
    assert np.abs(result.contacts[0].pressure - p).max() <= 1e-4 * p
    # heated alike they only just touch
    result = scene.solve(temperatures={inner: T, outer: T}, finite_motion=False)
    assert np.abs(result.contacts[0].pressure).max() <= 1e-9 * p


def test_estimates_are_those_of_the_stress():
    """A block heated evenly has no stress by it: pressed by a ball it errs as a cold one does."""
    mesh = fc.shapes.block((4.0, 4.0, 2.0), (8, 8, 4))
    block = fc.ElasticBody(mesh, STEEL, "top", {"bottom": "z", "x_min": "x", "y_min": "y"})
    ball = fc.RigidBody(fc.Sphere(10.0)).placed((2.0, 2.0, 2.0))
    scene = fc.Scene([block, ball], [fc.Contact(block, ball)])
    hot, cold = (scene.solve(forces={ball: (0, 0, -2e3)}, temperatures={block: t}) for t in (5.0, 0.0))
    assert abs(hot.contacts[0].error_estimate.interior / cold.contacts[0].error_estimate.interior - 1) <= 0.02
    assert abs(hot.contacts[0].max_pressure / cold.contacts[0].max_pressure - 1) <= 0.01


def test_a_spinning_bar():
    """Forces per mass as a function of place: rho w^2 (L^2 - x^2) / 2 along a bar that turns about its end."""
    L, rho, w = 2.0, 3.0, 5.0
    mesh = fc.shapes.block((L, 0.2, 0.2), (8, 1, 1)).translated((0, -0.1, 0))
    material = fc.Material(E, 0.0, density=rho)
    bar = fc.ElasticBody(mesh, material, "top", {"x_min": "xyz"}).placed(rotation=fc.rotation_about((0, 0, 1), 0.5))
    floor = fc.RigidBody(fc.Plane()).placed((0, 0, 0.2), np.diag([1.0, -1.0, -1.0]))
    spin = lambda x: w**2 * x * [1, 1, 0]  # noqa: E731
    result = fc.Scene([bar, floor], [fc.Contact(bar, floor)]).solve(gravity=spin, finite_motion=False)
    x = bar.mesh.points[:, 0]
    # the part across the bar bends it by a thousandth of that
    assert np.abs(result.stress(bar)[:, 0] - rho * w**2 * (L**2 - x**2) / 2).max() <= 0.02 * rho * w**2 * L**2 / 2


def test_what_cannot_be_heated_is_refused():
    block = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    floor = fc.RigidBody(fc.Plane())
    for material, change, words in (
        (fc.Material(E, NU), T, ("no-expansion", "expansion=")),
        (fc.NeoHookean(E, NU), T, ("finite-strain", "small strains")),
        (STEEL, np.ones(3), ("wrong-shape", "(8,)")),
        (STEEL, lambda x: np.full(len(x), np.nan), ("not-finite",)),
    ):
        body = fc.ElasticBody(block, material, "bottom", {"top": "xyz"})
        with refused(fc.InputError, *words):
            fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(temperatures={body: change})
    body = fc.ElasticBody(block, STEEL, "bottom", {"top": "xyz"})
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    with refused(fc.InputError, "needs-elastic-body", "change of temperature"):
        scene.solve(temperatures={floor: T})
    with refused(fc.InputError, "load-at-nodes"):
        scene.solve(temperatures={body: np.ones(8)}, accuracy=0.1)
    with refused(fc.InputError, "not-finite"):
        fc.Material(E, NU, expansion=np.inf)


@pytest.mark.parametrize("change", ["50.0", "'50 + 10 * (z - 1)'"])
def test_temperatures_of_scene_files(change, tmp_path):
    """A bar of unit cells between floor and support: the mean of what it would expand by, kept from it."""
    (tmp_path / "scene.toml").write_text(
        f"""[materials.steel]
E = {E}
nu = 0.0
expansion = {A}
[bodies.bar]
type = "elastic"
shape = {{kind = "block", size = [1.0, 1.0, 2.0], divisions = [1, 1, 2]}}
material = "steel"
contact = "bottom"
supports = {{top = "xyz"}}
[bodies.floor]
type = "rigid"
shape = {{kind = "plane"}}
[[contacts]]
slave = "bar"
master = "floor"
[loads]
temperatures.bar = {change}
"""
    )
    contact = fc.read_scene(tmp_path / "scene.toml").solve().contacts[0]
    assert abs(contact.total_force - E * A * T) <= 1e-9 * E * A * T
