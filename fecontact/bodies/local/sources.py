"""Point loads at the nodes of a window, with their mirror images, and what curvature and slopes add to the kernel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from fecontact.analytic import curved_kernel
from fecontact.analytic.face_loads import FaceLoads, displacements
from fecontact.bodies.halfspace.inclined import InclinedTerm
from fecontact.bodies.halfspace.symmetry import Even
from fecontact.bodies.local.window import Window
from fecontact.common.arrays import Array
from fecontact.common.material import Material

LEAST = 1e-5
"""Effect of slopes, relative to the compliance, below which it is left out."""

OWN, ROUND = 0.25, 8
"""Radius, relative to the distance of nodes in the middle of the window, and points of the circle round a load."""


def sources(window: Window, order: int) -> tuple[FaceLoads, ...]:
    """Unit loads against the window's normal at its nodes of an order, each with its images."""
    x, y = window.node_places(order)
    points, force = window.on_surface(x, y), -window.normal
    if window.relief is None:
        return tuple(_with_images(window, p, force) for p in points)
    slopes, bend = window.relief.slopes(x, y), window.relief.curvature(x, y)
    inwards = -np.concatenate([slopes, np.ones((len(x), 1))], axis=1) @ window.axes.T
    curvatures = window.axes @ bend @ window.axes.T
    return tuple(_with_images(window, *each) for each in zip(points, inwards, curvatures, strict=True))


def _with_images(window: Window, point: Array, inwards: Array, curvature: Array | None = None) -> FaceLoads:
    mirrors = images(window.axes, window.mirrored)
    bent = None if curvature is None else mirrors @ curvature @ mirrors
    length = None if curvature is None else window.grid.size[0]
    forces = np.tile(-window.normal, (len(mirrors), 1))
    return FaceLoads(window.origin + mirrors @ (point - window.origin), mirrors @ inwards, forces, bent, length)


def images(axes: Array, mirrored: Even) -> Array:
    """Reflections (n, 3, 3), the identity first, about the middle of a window with these axes.

    Examples
    --------
    >>> (images(np.eye(3), (True, False)) @ [1.0, 2.0, 3.0]).tolist()
    [[1.0, 2.0, 3.0], [-1.0, 2.0, 3.0]]
    """
    found = [np.eye(3)]
    for axis in (0, 1):
        if mirrored[axis]:
            mirror = np.eye(3) - 2 * np.outer(axes[:, axis], axes[:, axis])
            found += [mirror @ other for other in found]
    return np.array(found)


def singular_part(window: Window, order: int, material: Material) -> Array:
    """Displacements (k, k) into the body at nodes by unit loads there, as the kernel of the grid has them.

    Source: `analytic.curved_kernel`. A load's own displacement is left out, those of its images are not.
    """
    x, y = window.node_places(order)
    assert window.relief is not None
    depth = window.relief.depth(x, y)
    places = np.stack([x, y, depth], axis=1)
    bend = np.diag(principal(window))
    out = np.zeros((len(x), len(x)))
    for k, mirror in enumerate(images(np.eye(3), window.mirrored)):
        offset = places[:, None] - places @ mirror
        own = np.eye(len(x), dtype=bool) & (k == 0)
        offset[own] = 1.0
        length = window.grid.size[0]
        u = curved_kernel.displacement(offset, curvature=bend, length=length, material=material)
        out += np.where(own, 0.0, u)
    return out


def own_part(window: Window, order: int, loads: Sequence[FaceLoads], material: Material) -> Array:
    """What the kernel leaves (k,) of the displacements by loads at their own places.

    It has no limit there: of the order slope^2 curvature log(distance). Taken is its mean over a circle within the
    distance of the nodes, as the polynomials between them can follow it.
    """
    x, y = window.node_places(order)
    assert window.relief is not None
    angle = 2 * np.pi * np.arange(ROUND) / ROUND
    radius = OWN * np.pi * float(window.half.min()) / order
    u, v = x[:, None] + radius * np.cos(angle), y[:, None] + radius * np.sin(angle)
    around = window.on_surface(u, v)
    depths = window.relief.depth(u, v) - window.relief.depth(x, y)[:, None]
    offset = np.stack([u - x[:, None], v - y[:, None], depths], axis=-1)
    bend, length = np.diag(principal(window)), window.grid.size[0]
    kernel = curved_kernel.displacement(offset, curvature=bend, length=length, material=material)
    found = [-displacements(p, load, material)[0] @ window.normal for p, load in zip(around, loads, strict=True)]
    return np.asarray((np.array(found) - kernel).mean(axis=1))


def inclined(window: Window, material: Material) -> Iterator[InclinedTerm]:
    """The effect of slopes in a window, unless it is negligible."""
    if window.relief is None:
        return
    x, y = window.places
    slopes = window.relief.slopes(x, y)
    if abs(3 * material.nu - 1) / (2 * (1 - material.nu)) * (slopes**2).sum(axis=1).max() > LEAST:
        depths = window.relief.depth(x, y).reshape(window.shape)
        yield InclinedTerm(depths, slopes.reshape(*window.shape, 2), window.grid.cell, material, window.mirrored)


def principal(window: Window) -> Array:
    """Curvatures (2,) of the surface along the window's directions in its middle, convex positive."""
    if window.relief is None:
        return np.zeros(2)
    middle = np.zeros(1)
    return np.diagonal(window.relief.hessian(middle, middle)[0]).copy()
