"""Warnings of cells that are deeper than wide under rolling friction; figures: docs/friction.md."""

import pytest

import fecontact as fc


def warned(solid, nu=0.49, depth=2, element=None, friction=0.3):
    """Whether a pad pressed by a round body is warned of; its cells are 0.1 wide and 0.5 / depth deep."""
    material, floor = fc.Material(E=1.0, nu=nu), fc.RigidBody(fc.Sphere(1.0) if solid else fc.surfaces.Cylinder(1.0))
    if solid:
        mesh = fc.shapes.block((0.6, 0.6, 0.5), (6, 6, depth), element=element or "hex20").translated(
            (-0.3, -0.3, -0.5)
        )
        pad = fc.ElasticBody(mesh, material, "top", {"bottom": "xyz"}, name="pad")
    else:
        mesh = fc.sections.rectangle((1.0, 0.5), (10, depth), element=element or "quad8").translated((-0.5, 0.0, -0.5))
        pad = fc.PlaneBody(mesh, material, "top", {"bottom": "xz"}, name="pad")
    scene = fc.Scene([pad, floor], [fc.Contact(pad, floor, friction=friction)])
    result = scene.solve(motions={floor: {"z": -0.02}})
    return any("times as deep as wide" in text for text in result.warnings)


@pytest.mark.parametrize("solid", [False, True], ids=["section", "solid"])
def test_tall_cells_under_friction_are_warned_of(solid):
    assert warned(solid)


@pytest.mark.parametrize(
    ("solid", "change"),
    [(True, {"depth": 5}), *((False, c) for c in ({"depth": 5}, {"nu": 0.3}, {"element": "quad9"}, {"friction": 0.0}))],
)
def test_others_are_not(solid, change):
    assert not warned(solid, **change)


@pytest.mark.parametrize("corner", [True, False])
def test_one_touching_node_is_judged_by_its_cells_if_it_has_any(corner):
    """A ball above a corner, or above the middle of a face of 20-node cells, which only the contact has."""
    at = (0.0, 0.0) if corner else (0.15, 0.15)
    mesh = fc.shapes.block((0.6, 0.6, 0.9), (2, 2, 1), element="hex20").translated((-0.3, -0.3, -0.9))
    pad = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.49), "top", {"bottom": "xyz"}, name="pad")
    ball = fc.RigidBody(fc.Sphere(1.0), name="ball").placed(translation=(*at, 0.0))
    result = fc.Scene([pad, ball], [fc.Contact(pad, ball, friction=0.3)]).solve(motions={ball: {"z": -0.001}})
    assert result.n_active == 1
    assert any("times as deep as wide" in text for text in result.warnings) is corner
