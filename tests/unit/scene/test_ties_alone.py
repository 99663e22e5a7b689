"""Scenes whose parts are tied to each other and that have no contact."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc

E = 10.0
ROUNDING = 1e-10


def column(lower=(2, 2, 2), upper=(4, 4, 1), gap=0.0, element="hex20", ties=None, reach=None):
    """Two unit cubes on each other, by default the upper one tied to the lower one."""
    one = fc.shapes.block((1.0, 1.0, 1.0), lower, element=element)
    other = fc.shapes.block((1.0, 1.0, 1.0), upper, element=element).translated((0, 0, 1 + gap))
    one = fc.Mesh(one.points, one.cells, {"foot": one.faces("bottom"), "master": one.faces("top")})
    other = fc.Mesh(other.points, other.cells, {"slave": other.faces("bottom"), "head": other.faces("top")})
    return fc.tied(fc.merge([one, other], 0.0), ties or {"slave": "master"}, reach)


def body_of(mesh, **options):
    return fc.ElasticBody(mesh, fc.Material(E, 0.0), supports={"foot": "xyz"}, **options)


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27"])
def test_a_tied_column_is_solved_and_certified(element):
    """By hand: u = z s / E through the tie; the reaction is the load."""
    body = body_of(column(element=element))
    result = fc.Scene([body], []).solve(tractions={(body, "head"): (0, 0, 0.1)})
    assert np.abs(result.displacement(body) - body.mesh.points * [0, 0, 0.1 / E]).max() <= ROUNDING
    assert np.abs(result.stress(body)[:, 2] - 0.1).max() <= ROUNDING
    assert np.abs(result.reaction(body, "foot")[:3] - [0, 0, -0.1]).max() <= ROUNDING
    assert result.status == "solved"
    assert result.n_candidates == 0
    assert 0 < result.residuals().equilibrium <= ROUNDING
    assert "Tied parts" in str(result)
    assert result.summary()["contacts"] == []


def test_units_and_the_frame_change_nothing():
    turn = fc.rotation_about((1, 2, 3), 0.7)
    found = []
    for size, stress, Q in ((1.0, 1.0, np.eye(3)), (1e-3, 1e6, turn)):
        mesh = column(element="hex8").mapped(lambda x, size=size: size * x)
        body = fc.ElasticBody(mesh, fc.Material(E * stress, 0.3), supports={"foot": "xyz"}).placed(rotation=Q)
        load = {(body, "head"): Q @ [0.02 * stress, 0.0, 0.05 * stress]}
        found.append(fc.Scene([body], []).solve(tractions=load, finite_motion=False).displacement(body) @ Q / size)
    assert np.abs(found[1] - found[0]).max() <= 1e-9 * np.abs(found[0]).max()


def test_forces_that_do_not_balance_are_refused(monkeypatch):
    body = body_of(column(element="hex8"))
    scene = fc.Scene([body], [])
    scene.solve(tractions={(body, "head"): (0, 0, 0.1)})
    # what the body answers to its loads, made wrong by a thousandth
    monkeypatch.setattr(
        fc.ElasticBody, "displacement",
        lambda self, rows, forces, loads, own=fc.ElasticBody.displacement: 1.001 * own(self, rows, forces, loads),
    )  # fmt: skip
    with refused(fc.SolverError, "not-certified", "do not balance"):
        scene.solve(tractions={(body, "head"): (0, 0, 0.1)})


def test_what_cannot_be_tied_is_refused_or_told():
    with refused(fc.InputError, "tie-apart", "'slave'", "0.2 away"):
        column(gap=0.2)
    (closed,) = column(gap=0.2, reach=0.25).warnings
    assert "65 nodes of the tied 'slave' are moved by up to 0.2 onto 'master'" in closed
    # from both sides of a thousandth of a facet of a half
    assert "up to 0.000505" in column(gap=1.01e-3 / 2).warnings[0]
    assert column(gap=0.99e-3 / 2).warnings == column().warnings == ()
    with refused(fc.InputError, "unknown-boundary", "'lid'"):
        column(ties={"slave": "lid"})
    plain = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1)), fc.Material(E, 0.0), supports={"bottom": "xyz"})
    with refused(fc.InputError, "no-contact", "fc.tied"):
        fc.Scene([plain], [])


@pytest.mark.parametrize(("gap", "told"), [(0.0, 0), (0.025, 1)])
def test_rings_of_faces_that_do_not_match_close_no_gap(gap, told):
    """Nodes of the finer ring lie up to 0.03 faces off the chords of the coarser one, and are moved without a word."""
    one = fc.shapes.thick_ring(0.5, 1.0, 0.2, (6, 2, 1), element="hex8")
    other = fc.shapes.thick_ring(1.0 + gap, 1.5, 0.2, (11, 2, 1), element="hex8")
    one = fc.Mesh(one.points, one.cells, {"master": one.faces("outer")})
    other = fc.Mesh(other.points, other.cells, {"slave": other.faces("inner")})
    mesh = fc.tied(fc.merge([one, other], 0.0), {"slave": "master"}, 0.05)
    assert len(mesh.warnings) == told


def test_a_slave_that_reaches_beside_its_master_warns():
    one = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex8")
    other = fc.shapes.block((2.0, 1.0, 1.0), (5, 3, 1), element="hex8").translated((0, 0, 1))
    one = fc.Mesh(one.points, one.cells, {"foot": one.faces("bottom"), "master": one.faces("top")})
    other = fc.Mesh(other.points, other.cells, {"slave": other.faces("bottom"), "head": other.faces("top")})
    body = body_of(fc.tied(fc.merge([one, other], 0.0), {"slave": "master"}))
    result = fc.Scene([body], []).solve(tractions={(body, "head"): (0, 0, 1e-3)})
    assert any("12 of 22 nodes of the tied 'slave'" in text for text in result.warnings)


def test_a_node_set_follows_too():
    mesh = column(ties={"slave": "master"})
    by_nodes = fc.Mesh(mesh.points, mesh.cells, mesh.boundaries, node_sets={"some": mesh.boundary_nodes("slave")})
    assert (fc.tied(by_nodes, {"some": "master"}).hanging.nodes == mesh.hanging.nodes).all()


def test_a_tied_column_of_rubber_is_its_closed_form():
    """NeoHookean with nu = 0: a dead traction t stretches by l, mu (l - 1/l) = t, without any change across."""
    body = fc.ElasticBody(column(element="hex8"), fc.NeoHookean(E, 0.0), supports={"foot": "xyz"})
    t, mu = 2.0, E / 2
    result = fc.Scene([body], []).solve(tractions={(body, "head"): (0, 0, t)})
    stretch = (t / mu + np.sqrt((t / mu) ** 2 + 4)) / 2
    assert np.abs(result.displacement(body) - body.mesh.points * [0, 0, stretch - 1]).max() < 1e-8
    assert result.residuals().equilibrium < 1e-8
    assert result.warnings == ()
