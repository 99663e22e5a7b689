"""Contacts on half-spaces with known pressures: estimates of their error against the truth, in the cells' centres."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from estimate_cases import Judged

import fecontact as fc
from fecontact.analytic import hertz, layer
from fecontact.surfaces import Paraboloid, self_affine

UNIT = fc.Material(E=1.0, nu=0.0)


def judged(contact: fc.HalfSpaceContact, known: np.ndarray) -> Judged:
    error = float(np.linalg.norm(contact.pressure - known) / np.linalg.norm(known))
    return Judged(contact.grid.n_cells, {"mean": (error, contact.error_estimate.pressure)})


def hertzian(n: int, radii: tuple[float, float], size: float) -> Judged:
    half = fc.HalfSpace(UNIT, size=(size, size), cells=(n, n))
    force = 4 / 30
    exact = hertz.ellipse((radii, (math.inf, math.inf)), (None, UNIT), force=force)
    x, y = np.meshgrid(half.grid.x, half.grid.y, indexing="ij")
    return judged(half.press(Paraboloid(*radii), force=force), exact.pressure(x, y))


def in_a_scene(n: int) -> Judged:
    """A ball on a half-space that is a body of a scene."""
    half = fc.HalfSpace(UNIT, size=(3.1, 3.1), cells=(n, n))
    ball = fc.RigidBody(Paraboloid(10.0))
    exact = hertz.spheres((10.0, math.inf), (None, UNIT), force=4 / 30)
    (contact,) = fc.Scene([half, ball], [fc.Contact(half, ball)]).solve(forces={ball: (0, 0, -4 / 30)}).contacts
    known = exact.pressure(np.hypot(*contact.points.T[:2]))
    error = float(np.linalg.norm(contact.pressure - known) / np.linalg.norm(known))
    return Judged(half.grid.n_cells, {"mean": (error, contact.error_estimate.pressure)})


def on_layer(n: int, thickness: float, nu: float) -> Judged:
    material = fc.Material(1.0, nu)
    half = fc.HalfSpace(None, size=(3.0, 3.0), cells=(n, n), layers=[fc.Layer(material, thickness)])
    exact = layer.paraboloid(radius=10.0, thickness=thickness, material=material, a=1.0)
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    at = np.linspace(0, 1, 400)[:-1]
    over_root = np.interp(r, at, exact.pressure(at) / np.sqrt(1 - at**2))
    return judged(half.press(Paraboloid(10.0), force=exact.force), over_root * np.sqrt(np.maximum(0, 1 - r**2)))


def wavy(n: int, a: float, rows: int = 8) -> Judged:
    """Westergaard's wavy surface, a cylinder of period one, in contact up to the distance a from its crests."""
    half = fc.HalfSpace(UNIT, size=(1.0, rows / n), cells=(n, rows), periodic=True)
    x, s = half.grid.x, math.sin(math.pi * a) ** 2
    mean = math.pi * 0.01 * s
    contact = half.press(0.01 * (1 - np.cos(2 * np.pi * x))[:, None] * np.ones(rows), force=mean * rows / n)
    known = 2 * mean / s * np.cos(np.pi * x) * np.sqrt(np.maximum(0, s - np.sin(np.pi * x) ** 2))
    return judged(contact, known[:, None] * np.ones(rows))


@lru_cache
def fine_rough(fine: int, load: float) -> tuple[np.ndarray, np.ndarray]:
    """Heights of a rough surface, waves down to 1/24 of its size, and the pressure on a fine grid."""
    z = self_affine((fine, fine), (1.0, 1.0), hurst=0.8, seed=3, rms_slope=0.1, longest=0.25, shortest=1 / 24).z
    half = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(fine, fine), periodic=True)
    return z - z.min(), half.press(z - z.min(), force=load).pressure


def rough(n: int, load: float, fine: int = 1024) -> Judged:
    """A rough surface; the truth by a much finer grid, the mean of the four cells round each centre."""
    z, pressure = fine_rough(fine, load)
    half, k = fc.HalfSpace(UNIT, size=(1.0, 1.0), cells=(n, n), periodic=True), fine // n
    middle = slice(k // 2 - 1, k // 2 + 1)
    heights, known = (v.reshape(n, k, n, k)[:, middle, :, middle].mean(axis=(1, 3)) for v in (z, pressure))
    return judged(half.press(heights, force=load), known)


def punch(n: int, size: float) -> Judged:
    """A flat punch, away from its edge by more than the cells that the estimate leaves out."""
    half = fc.HalfSpace(UNIT, size=(size, size), cells=(n, n))
    contact = half.press(fc.surfaces.FlatPunch(radius=1.0), force=1.0)
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    inside = r < 1 - 4 * size / n
    known = 1 / (2 * np.pi * np.sqrt(1 - r[inside] ** 2))
    error = float(np.linalg.norm(contact.pressure[inside] - known) / np.linalg.norm(known))
    return Judged(half.grid.n_cells, {"mean": (error, contact.error_estimate.pressure)})


#: Family: numbers of cells, and what solves one.
FAMILIES: dict[str, tuple[tuple, Callable[..., Judged]]] = {
    "half-space, ball": ((16, 24, 64, 256), lambda n: hertzian(n, (10.0, 10.0), 3.1)),
    "half-space, ellipse": ((32, 64, 128), lambda n: hertzian(n, (30.0, 6.0), 4.4)),
    "half-space in a scene": ((16, 32, 64), in_a_scene),
    "half-space, bonded layer": ((32, 64, 128), lambda n: on_layer(n, 0.5, 0.3)),
    "half-space, thin layer, nu = 0.45": ((32, 64, 128), lambda n: on_layer(n, 0.2, 0.45)),
    "half-space, wavy, a = 0.13": ((32, 64, 128), lambda n: wavy(n, 0.13)),
    "half-space, wavy, a = 0.34": ((32, 64, 128), lambda n: wavy(n, 0.34)),
    "half-space, rough, light load": ((64, 128, 256), lambda n: rough(n, 0.003)),
    "half-space, rough, heavy load": ((64, 128, 256), lambda n: rough(n, 0.02)),
    "half-space, flat punch off its edge": ((32, 64, 128), lambda n: punch(n, 2.7)),
}
