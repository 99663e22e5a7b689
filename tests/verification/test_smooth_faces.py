"""Distance of contact faces from the part that their mesh stands for, as meshed and on the surface fitted to them."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.mesh.shapes import lattice

SOFT = fc.Material(E=1.0, nu=0.3)
#: Points of a facet at which distances are taken.
SAMPLES = (np.arange(4) + 0.5) / 4


def ball(element, contact=0.5, axes=(1.0, 1.0, 1.0)):
    """Cap of a quarter of an ellipsoid on its pole, and the distance from it."""
    mesh = fc.shapes.quarter_sphere(10.0, contact_radius=contact, level=1, element=element)
    return mesh.mapped(lambda x: x * axes), "cap", lambda x: np.linalg.norm(x / axes - [0, 0, 10.0], axis=-1) - 10.0


def bore(n, rows, length=1.0, cone=0.0, element="hex8"):
    """Cylindrical or conical bore of a quarter of a ring."""
    mesh = fc.shapes.thick_ring(1.0, 2.0, length, (n, 2, rows), element=element)
    mesh = mesh.mapped(lambda x: np.column_stack([x[:, :2] * (1 + cone * x[:, 2:]), x[:, 2]]))
    return mesh, "inner", lambda x: np.hypot(x[..., 0], x[..., 1]) - 1 - cone * x[..., 2]


def torus(n, element):
    """Part of a torus, 80 by 84 degrees."""
    mesh = lattice((n, n, 2), (None,) * 5 + ("top",), element)

    def shape(index):
        around, lean = np.radians(84 * index[:, 0] / n - 42), np.radians(80 * index[:, 1] / n - 40)
        tube = 18 + index[:, 2]
        r = 12 + tube * np.cos(around)
        return np.column_stack([tube * np.sin(around), r * np.sin(lean), r * np.cos(lean)])

    return mesh.mapped(shape), "top", lambda x: np.hypot(np.hypot(x[..., 1], x[..., 2]) - 12, x[..., 0]) - 20


def wavy(n, element, noise=0.0):
    """A block with a wavy top whose corners are off by noise."""
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (n, n, 2), element=element)
    off = noise * np.random.default_rng(0).normal(size=len(mesh.points))

    def height(x):
        return 0.3 * np.sin(1.3 * x[..., 0]) * np.cos(1.1 * x[..., 1] + 0.3)

    mesh = mesh.mapped(lambda x: x + np.outer(x[:, 2] * (height(x) + off), [0, 0, 1]))
    return mesh, "top", lambda x: x[..., 2] - 1 - height(x)


def fillet(n, element, r=0.2):
    """A flat top, a rim of radius r and a flat side, n cells each."""
    mesh = lattice((3 * n, 2, 2), (None,) * 5 + ("top",), element)

    def shape(index):
        u, t = index[:, 0] / n, index[:, 2:] / 2
        turn = np.pi / 2 * np.clip(u - 1, 0, 1)
        x = np.minimum(u, 1) * (1 - r) + r * np.sin(turn)
        z = 1 - r + r * np.cos(turn) - np.maximum(u - 2, 0) / 2
        outer = np.column_stack([x, z])
        inside = outer / 2 - [0, 0.2]
        at = inside + t * (outer - inside)
        return np.column_stack([at[:, 0], index[:, 1] / 2, at[:, 1]])

    def distance(x):
        a, b = np.maximum(x[..., 0] - (1 - r), 0), np.maximum(x[..., 2] - (1 - r), 0)
        return np.hypot(a, b) - r

    return mesh.mapped(shape), "top", distance


def straight(case):
    """The same with 20-node cells of straight sides."""
    mesh, name, distance = case
    return mesh.upgraded(20), name, distance


CASES = {
    "ball, hex8": lambda: ball("hex8"),
    "ball, straight hex20": lambda: straight(ball("hex8")),
    "ball, hex20": lambda: ball("hex20"),
    "ball, hex27": lambda: ball("hex27"),
    "ellipsoid, straight hex20": lambda: straight(ball("hex8", 3.0, np.array([1.5, 1.0, 0.7]))),
    "bore of 12 sides, one row": lambda: straight(bore(3, 1)),
    "bore of 16 sides": lambda: straight(bore(4, 2)),
    "long bore of 16 sides": lambda: straight(bore(4, 2, 10.0)),
    "bore of 32 curved sides": lambda: bore(8, 4, 0.1, element="hex20"),
    "cone of 32 sides, one row": lambda: straight(bore(8, 1, 1.0, 0.3)),
    "torus, straight hex20, facets of 20 degrees": lambda: straight(torus(4, "hex8")),
    "torus, hex20, facets of 10 degrees": lambda: torus(8, "hex20"),
    "wavy, straight hex20": lambda: straight(wavy(8, "hex8")),
    "wavy, hex20": lambda: wavy(8, "hex20"),
    "wavy, hex27, four facets a wave": lambda: wavy(4, "hex27"),
    "wavy, noise of 1 % of a facet": lambda: straight(wavy(8, "hex8", 0.005)),
    "wavy, noise of 6 % of a facet": lambda: straight(wavy(8, "hex8", 0.03)),
    "rim fillet of 4 cells": lambda: straight(fillet(4, "hex8")),
    "rim fillet of 2 curved cells": lambda: fillet(2, "hex20"),
}


def errors(body, name, distance):
    """Root mean squares over the faces of the distance and of the sine between the normals."""
    surface = body.surface(name)
    local = np.array([[s, t] for s in SAMPLES for t in SAMPLES])
    facet, local = np.repeat(np.arange(len(surface.facets)), len(local)), np.tile(local, (len(surface.facets), 1))
    x, h = surface.evaluate(facet, local)[0], 1e-6 * surface.size
    slope = np.stack([(distance(x + h * e) - distance(x - h * e)) / (2 * h) for e in np.eye(3)], axis=1)
    length = np.linalg.norm(slope, axis=1)
    sine = np.linalg.norm(np.cross(slope / length[:, None], surface.normals(facet, local)), axis=1)
    return np.array([np.sqrt(np.mean((distance(x) / length) ** 2)), np.sqrt(np.mean(sine**2))])


@pytest.mark.by_day(every=4)
@pytest.mark.parametrize("case", CASES)
def test_faces_come_nearer_to_the_part(case, row):
    """Faces on the surface fitted to them, beside faces as meshed: how far they are from the part they stand for.

    Source: the part's own equation. Distances and normals, as meshed (0) and after a division of all faces (1); 2 %
    for nodes that are exact, of which a fit to few of them need not know.
    """
    mesh, name, distance = CASES[case]()
    found = {}
    for geometry in ("plain", "auto"):
        body = fc.ElasticBody(mesh, SOFT, name, geometry=geometry)
        finer = body._divided({name: np.arange(len(body.surface(name).facets))})
        found[geometry] = np.array([errors(body, name, distance), errors(finer, name, distance)])
    ratio = found["auto"] / np.maximum(found["plain"], 1e-12)
    for k, times in enumerate(("as meshed", "divided")):
        row(case, f"distance over plain, {times}", 0.0, ratio[k, 0], 1.02, finer.n_dofs)
        row(case, f"normals over plain, {times}", 0.0, ratio[k, 1], 1.02, finer.n_dofs)
