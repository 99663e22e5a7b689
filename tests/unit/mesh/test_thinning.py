"""Layers whose thickness yields where they would fold: by how much, where, and where not."""

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.mesh.check import check_mesh, least_jacobians
from fecontact.mesh.layer import MIN_THICKNESS, SLOPE


def sheet(height, n=(48, 6), size=(8.0, 1.0)):
    """A height map over a rectangle, as quadrilaterals."""
    x, y = np.meshgrid(np.linspace(0, size[0], n[0] + 1), np.linspace(0, size[1], n[1] + 1), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), height(x).ravel()], axis=1)
    i = (np.arange(n[0])[:, None] * (n[1] + 1) + np.arange(n[1])).ravel()
    return fc.SurfaceMesh(points, np.stack([i, i + n[1] + 1, i + n[1] + 2, i + 1], axis=1))


def channel(x):
    """A round channel of radius 0.5, up to 53 degrees on either side, in a flat sheet."""
    off = np.abs(x - 4.0)
    return np.where(off < 0.4, -np.sqrt(0.25 - np.minimum(off, 0.4) ** 2) + 0.3, 0.0)


def thickness_of(mesh, surface):
    """Distances from the nodes of the surface to those above them."""
    base, top = mesh.face_nodes(mesh.faces("base"))[:, :4], mesh.cells[mesh.faces("top")[:, 0], 4:8]
    assert (np.sort(mesh.cells[mesh.faces("base")[:, 0], :4], axis=1) == np.sort(base, axis=1)).all()
    return np.linalg.norm(mesh.points[top] - mesh.points[mesh.cells[mesh.faces("top")[:, 0], :4]], axis=2)


def test_a_layer_yields_in_a_round_channel_and_nowhere_else():
    """Source: a layer on a channel of radius R folds if it is thicker than R; its walls meet at 53 degrees."""
    surface = sheet(channel)
    with refused(fc.MeshError, "layer-folds", "288", "("):
        fc.extrude(surface, 0.7, strict=True)
    mesh = fc.extrude(surface, 0.7)
    check_mesh(mesh)
    t, x = thickness_of(mesh, surface), mesh.points[mesh.cells[:, :4], 0]
    assert t[np.abs(x - 4) < 0.05].max() < 0.5
    assert np.allclose(t[np.abs(x - 4) > 0.45 + 0.7 / SLOPE], 0.7, rtol=1e-12)
    assert MIN_THICKNESS * 0.7 < t.min() < 0.5
    # it returns to the given thickness no faster than the slope
    side = np.linalg.norm(mesh.points[mesh.cells[:, :4]] - mesh.points[mesh.cells[:, [1, 2, 3, 0]]], axis=2)
    assert (np.abs(t - np.roll(t, -1, axis=1)) <= SLOPE * side + 1e-12).all()
    assert f"least {t.min():.3g} instead of 0.7 at (" in mesh.notes[-1]


def test_a_thin_layer_is_left_alone():
    """The other side of the guard, and the same as a strict one."""
    surface = sheet(channel)
    mesh, strict = fc.extrude(surface, 0.3), fc.extrude(surface, 0.3, strict=True)
    assert not mesh.notes
    assert (mesh.points == strict.points).all()
    assert np.allclose(thickness_of(mesh, surface), 0.3, rtol=1e-12)


def test_the_unit_and_the_place_do_not_matter():
    surface = sheet(channel)
    t = thickness_of(fc.extrude(surface, 0.7, layers=2), surface)
    small = surface.mapped(lambda x: 1e-4 * x[:, [1, 2, 0]] + [3.0, -2.0, 1.0])
    again = thickness_of(fc.extrude(small, 0.7e-4, layers=2), small)
    # the place costs digits: 1e-4 beside 3
    assert np.allclose(1e4 * again, t, rtol=1e-7)


def test_walls_of_a_slot_do_not_run_into_each_other():
    """A slot 0.5 wide, of steep walls: layers of 0.35 on both would cross, though no cell folds by itself."""
    slot = sheet(lambda x: -0.8 * np.clip((0.45 - np.abs(x - 4)) / 0.2, 0, 1), n=(160, 3))
    mesh = fc.extrude(slot, 0.35)
    check_mesh(mesh)
    t = thickness_of(mesh, slot)
    assert t.min() < 0.3
    assert t.max() == pytest.approx(0.35, rel=1e-12)
    assert fc.extrude(slot, 0.05).notes == ()


def test_a_layer_that_is_too_thick_altogether_is_refused():
    hollow = fc.SurfaceMesh.of(fc.shapes.thick_ring(1.0, 2.0, 1.0, (8, 1, 2), element="hex8"), "inner")
    with refused(fc.MeshError, "layer-folds"):
        fc.extrude(hollow, 1.5)
    assert (least_jacobians(fc.extrude(hollow, 0.5)) > 0).all()
