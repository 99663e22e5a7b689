"""Supports, fix_null_space, loads and the model that brings them together."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import InputError, MeshError, merge
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.model import Model
from fecontact.fem.rigid import rigid_modes
from fecontact.fem.stiffness import body_force, moments_of_volume, surface_traction
from fecontact.fem.support import fix_null_space, nodal_coordinates, support_directions

# sums over some hundred quadrature points
ROUNDING = 1e-12


def block(element="hex20", divisions=(2, 2, 2)):
    return fc.shapes.block((1.0, 1.2, 0.9), divisions, element=element)


def test_held_dofs():
    mesh = block("hex8")
    held = nodal_coordinates(mesh, {"bottom": "xyz", "x_min": "x"})[1]
    nodes = set((held[held % 3 == 2] // 3).tolist())
    assert nodes == set(mesh.boundary_nodes("bottom").tolist())
    x_nodes = set((held[held % 3 == 0] // 3).tolist())
    assert x_nodes == nodes | set(mesh.boundary_nodes("x_min").tolist())
    assert len(nodal_coordinates(mesh, {})[1]) == 0


@pytest.mark.parametrize(
    ("supports", "words"),
    [
        ({"lid": "xyz"}, ("unknown-boundary", "'lid'", "'top'")),
        ({"top": "xw"}, ("support-components",)),
        ({"top": ""}, ("support-components",)),
        ({"top": ("x",)}, ("support-components",)),
        ({"top": (0, 0, 0)}, ("support-components",)),
        ({"top": [(1, 0, 0), (1, 0)]}, ("support-components",)),
        ({"top": ()}, ("support-components",)),
    ],
)
def test_bad_supports(supports, words, steel):
    with refused(InputError, *words):
        Model(block(), steel, supports)


@pytest.mark.parametrize(
    ("supports", "n_free"), [({}, 6), ({"bottom": "z"}, 3), ({"bottom": "xyz"}, 0), ({"x_min": "x", "y_min": "y"}, 1)]
)
def test_free_motions_and_grounding(supports, n_free, steel):
    model = Model(block(), steel, supports)
    assert model.free_motions.shape == (6, n_free)
    assert len(model.pinned_dofs) == n_free
    assert not set(model.pinned_dofs) & set(model.held)
    # what is left has no zero mode: the condition number of this small model is far below 1e8
    values = np.linalg.eigvalsh(model.solved_stiffness().toarray(), UPLO="U")
    assert values[0] > 1e-8 * values[-1]


@pytest.mark.parametrize(
    ("supports", "n_held", "n_free"),
    [
        ({"bottom": "n"}, 9, 3),
        ({"bottom": "xn"}, 18, 1),
        ({"bottom": (1, 1, 0)}, 9, 4),
        ({"bottom": (0, 0, -2.0)}, 9, 3),
        ({"bottom": [(1, 1, 0), (0, 0, 1), (1, 1, 1)]}, 18, 1),
        ({"bottom": [(1, 1, 0), (0, 0, 1), (1, 2, 1)]}, 27, 0),
        ({"x_min": "n", "y_min": "n"}, 18, 1),
        ({"x_min": "n", "y_min": (0, 1, 1)}, 18, 1),
        ({"bottom": "z", "x_min": (1, 0, 1)}, 18, 1),
    ],
)
def test_oblique_supports_hold_what_they_say(supports, n_held, n_free, steel):
    model = Model(block("hex8"), steel, supports)
    assert len(model.held) == n_held
    assert model.free_motions.shape == (6, n_free)
    # no free motion moves a held node along what is held, however it is put
    rows = [
        np.einsum("nki,nic->nkc", d, model.rigid_modes.reshape(-1, 3, 6)[nodes]).reshape(-1, 6)
        for nodes, d in (support_directions(model.mesh, name, s) for name, s in supports.items())
    ]
    assert np.abs(np.concatenate(rows) @ model.free_motions).max(initial=0.0) < 1e-12


def test_normal_of_an_edge_is_refused(steel):
    mesh = block("hex8").with_boundary("corner", lambda x: (x[:, 0] == 0) | (x[:, 1] == 0))
    with refused(InputError, "no-normal"):
        Model(mesh, steel, {"corner": "n"})
    with refused(InputError, "no-normal"):
        Model(replace(mesh, node_sets={"some": np.array([0, 1, 2])}), steel, {"some": "n"})


def test_a_ring_held_along_its_bore_may_turn_in_it(steel):
    mesh = fc.shapes.thick_ring(1.0, 2.0, 0.5, (2, 16, 1), sector="full")
    model = Model(mesh, steel, {"inner": "n"})
    # along the axis and about it; the average normals of a regular mesh are radial to rounding
    assert model.free_motions.shape == (6, 2)
    assert np.abs(model.free_motions[[0, 1, 3, 4]]).max() < 1e-9


def test_grounding_spans_the_free_motions_well():
    mesh = block()
    modes = rigid_modes(mesh.points, mesh.points.mean(axis=0))
    dofs = fix_null_space(modes, np.zeros(0, dtype=int), 1.8)
    assert np.linalg.cond(modes[dofs]) < 10


def self_equilibrated(mesh, seed):
    """Random nodal forces without resultant."""
    f = np.random.default_rng(seed).normal(size=3 * len(mesh.points))
    R = rigid_modes(mesh.points, mesh.points.mean(axis=0))
    return f - R @ np.linalg.lstsq(R, f, rcond=None)[0]


def strains_of(body, loads):
    nodes = body.model.mesh.boundary_nodes("top")
    body.model.condensed(nodes, Stopwatch())
    u = body.displacement(sp.csr_matrix((0, body.n_dofs)), np.zeros(0), loads)
    R = body.rigid_modes
    return u - R @ np.linalg.lstsq(R, u, rcond=None)[0]


def test_it_does_not_matter_which_dofs_are_grounded(steel, monkeypatch):
    mesh = block()
    loads = self_equilibrated(mesh, 9)
    bodies = [fc.ElasticBody(mesh, steel, contact="top", pressure="nodal") for _ in range(3)]
    n = 3 * len(mesh.points)
    # three nodes far apart held in 3, 2 and 1 components; and a poor choice, three neighbouring nodes
    bodies[1].model.__dict__["pinned_dofs"] = np.sort(
        [0, 1, 2, *_at(mesh, (1, 0, 0), (1, 2)), *_at(mesh, (0, 1.2, 0), (2,))]
    )
    bodies[2].model.__dict__["pinned_dofs"] = np.sort(
        [n - 3, n - 2, n - 1, *_near(mesh, n // 3 - 1, (1, 0, 0), (1, 2)), *_near(mesh, n // 3 - 1, (0, 1, 0), (2,))]
    )
    fields = [strains_of(b, loads) for b in bodies]
    for other in fields[1:]:
        assert np.abs(other - fields[0]).max() < 1e-9 * np.abs(fields[0]).max()


def _at(mesh, where, components):
    node = np.argmin(np.linalg.norm(mesh.points - where, axis=1))
    return [3 * node + c for c in components]


def _near(mesh, node, direction, components):
    """Dofs of the nearest other node along a direction."""
    offset = mesh.points - mesh.points[node]
    along = np.abs(offset @ direction)
    across = np.linalg.norm(offset, axis=1) - along
    others = np.flatnonzero((along > 1e-9) & (across < 1e-9))
    return [3 * others[np.argmin(along[others])] + c for c in components]


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_body_force_and_mass(curved, element):
    mesh = curved(element)
    volume, centre = moments_of_volume(mesh)
    f = body_force(mesh, lambda x: np.broadcast_to([1.0, -2.0, 3.0], x.shape), 0.5).reshape(-1, 3)
    assert np.abs(f.sum(axis=0) - 0.5 * volume * np.array([1, -2, 3])).max() < ROUNDING
    moment = np.cross(mesh.points - centre, f).sum(axis=0)
    assert np.abs(moment).max() < ROUNDING
    per_cell = moments_of_volume(mesh, np.arange(1.0, 1 + len(mesh.cells)))[0]
    cells = [moments_of_volume(fc.Mesh(*_only(mesh, k)))[0] for k in range(len(mesh.cells))]
    assert abs(per_cell - np.dot(cells, np.arange(1.0, 1 + len(mesh.cells)))) < ROUNDING


def _only(mesh, k):
    used, cells = np.unique(mesh.cells[k], return_inverse=True)
    return mesh.points[used], cells[None, :]


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_pressure_on_a_closed_surface_has_no_resultant(curved, element):
    mesh = curved(element)
    f = surface_traction(mesh, mesh.outer_faces, lambda x, n: -n).reshape(-1, 3)
    assert np.abs(f.sum(axis=0)).max() < ROUNDING
    # moments of curved faces are of degree seven; the rule is exact to five
    assert np.abs(np.cross(mesh.points, f).sum(axis=0)).max() < 1e-6


def test_pressure_on_a_closed_body_with_midface_nodes_and_degenerate_cells(curved, degenerate):
    rich = curved().with_midface_nodes(("top", "x_min"))
    for faces in (rich.faces("top"), rich.outer_faces):
        f = surface_traction(rich, faces, lambda x, n: -n).reshape(-1, 3)
        plain = surface_traction(curved(), faces, lambda x, n: -n).reshape(-1, 3)
        assert np.abs(f.sum(axis=0) - plain.sum(axis=0)).max() < ROUNDING
    for kind in ("one edge", "wedge", "pyramid", "tetrahedron"):
        mesh = degenerate(kind)
        f = surface_traction(mesh, mesh.outer_faces, lambda x, n: -n).reshape(-1, 3)
        assert np.abs(f.sum(axis=0)).max() < ROUNDING
        assert np.abs(np.cross(mesh.points, f).sum(axis=0)).max() < ROUNDING


def test_traction_resultant_on_a_plane(steel):
    mesh = block()
    f = surface_traction(mesh, mesh.faces("top"), lambda x, n: x[:, :1] * np.array([[0.0, 0.0, 1.0]])).reshape(-1, 3)
    assert abs(f[:, 2].sum() - 1.2 / 2) < ROUNDING
    assert abs(f[:, 2] @ mesh.points[:, 0] - 1.2 / 3) < ROUNDING


def test_materials_by_element_set(steel):
    mesh = block().with_group("low", lambda x: x[:, 2] < 0.45).with_group("high", lambda x: x[:, 2] > 0.45)
    soft = fc.Material(E=1.0, nu=0.1)
    model = Model(mesh, {"low": steel, "high": soft}, {})
    assert set(model.shear[mesh.groups["low"]]) == {steel.shear_modulus}
    assert set(model.shear[mesh.groups["high"]]) == {soft.shear_modulus}
    with refused(InputError, "input", "4 cells"):
        Model(mesh, {"low": steel}, {})
    with refused(InputError, "input", "'middle'", "low, high"):
        Model(mesh, {"middle": steel}, {})
    overlapping = mesh.with_group("all", lambda x: x[:, 2] > 0)
    with refused(InputError, "two-materials"):
        Model(overlapping, {"low": steel, "all": soft}, {})
    with refused(InputError, "input", "Material"):
        Model(mesh, 210e3, {})
    with refused(InputError, "some-densities"):
        _ = Model(mesh, {"low": steel, "high": fc.Material(E=1.0, nu=0.1, density=2.0)}, {}).density


def test_condensation_is_kept_while_it_holds_the_nodes(steel):
    model = Model(block(), steel, {"bottom": "xyz"})
    top = model.mesh.boundary_nodes("top")
    first = model.condensed(top, Stopwatch())
    assert model.condensed(top[:3], Stopwatch()) is first
    assert model.condensed(np.arange(len(model.mesh.points)), Stopwatch()) is not first


def test_parts_without_connection(steel):
    left = block()
    right = left.translated((5.0, 0.0, 0.0))
    both = merge([left, fc.Mesh(right.points, right.cells, {"far": right.faces("bottom")})], 1e-9)
    with refused(MeshError, "several-parts", "has 2", "cell 8"):
        Model(both, steel, {"bottom": "xyz"})
    with refused(MeshError, "several-parts", "has 2"):
        Model(both, steel, {"bottom": "xyz", "far": "z"})
    assert Model(both, steel, {"bottom": "xyz", "far": "xyz"}).free_motions.shape == (6, 0)


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_body_held_at_all_its_nodes_is_rigid(mu):
    steel = fc.Material(E=1.0, nu=0.3)
    one = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    lower = fc.ElasticBody(one, steel, "top", {"bottom": "xyz", "top": "xyz"})
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    upper = fc.ElasticBody(mesh, steel, "bottom", {"top": "xyz"}).placed((0, 0, 1.0))
    floor = fc.RigidBody(fc.Plane()).placed((0, 0, 1.0))
    forces = []
    for other in (lower, floor):
        contact = fc.Contact(upper, other, friction=mu)
        result = fc.Scene([upper, other], [contact]).solve(motions={upper: {"z": -0.01}})
        forces.append(result.contacts[0].total_force)
    assert abs(forces[0] - forces[1]) < 1e-12
    other = fc.ElasticBody(one, steel, "bottom", {"bottom": "xyz", "top": "xyz"}, name="other").placed((0, 0, 1.0))
    with refused(fc.InputError, "all-held", "other", "free"):
        fc.Scene([other, lower], [fc.Contact(other, lower)]).solve(motions={other: {"z": -0.01}})
