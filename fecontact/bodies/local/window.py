"""Window of a local body: the tangent plane round the contact, its cells, and nodes for smooth functions on it.

Faces of a mesh that look along a direction.

Point loads at the nodes of a window, with their mirror images, and what curvature and slopes add to the kernel.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fecontact.analytic import curved_kernel
from fecontact.analytic.face_loads import FaceLoads, displacements
from fecontact.bodies.local.relief import Relief, nodes
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray
from fecontact.common.material import Material
from fecontact.halfspace.grid import Even, Grid, part_of
from fecontact.halfspace.smooth import InclinedTerm
from fecontact.mesh.mesh import Mesh

OPPOSITE = 1e-10
"""Difference of the axes of two windows, and of their middles relative to their size, that is rounding."""


@dataclass(frozen=True, eq=False)
class Window:
    """A rectangle on the tangent plane of a body's surface, in cells.

    Attributes
    ----------
    origin : (3,) array
        Its middle, on the surface, in the body's axes.
    axes : (3, 3) array
        Columns: its two directions and the outward normal; left-handed for a window that faces another one.
    grid : Grid
        Its cells, those beyond planes of symmetry too.
    mirrored : (bool, bool)
        Directions whose middle is a plane of symmetry of the body; the body has the positive side.
    relief : Relief, optional
        Depth of the surface below the plane, for slopes and curvatures; None for a flat surface.
    depths : (n_cells,) array, optional
        Depths of the surface at the modelled cells, as it is.

    Examples
    --------
    >>> window = Window(np.zeros(3), np.eye(3), Grid((2.0, 1.0), (4, 2)), (True, False))
    >>> window.shape, window.cells[0].tolist()
    ((2, 2), [0.25, -0.25, 0.0])
    """

    origin: Array
    axes: Array
    grid: Grid
    mirrored: Even
    relief: Relief | None = None
    depths: Array | None = None

    @property
    def normal(self) -> Array:
        """Outward normal (3,) of the tangent plane."""
        return self.axes[:, 2]

    @property
    def half(self) -> Array:
        """Half the sides (2,) of the whole window."""
        return np.array(self.grid.size) / 2

    @cached_property
    def along(self) -> tuple[Array, Array]:
        """Coordinates (nx,) and (ny,) of the modelled cells along either direction."""
        part = part_of(self.grid.shape, self.mirrored)
        return self.grid.x[part[0]], self.grid.y[part[1]]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of modelled cells."""
        return len(self.along[0]), len(self.along[1])

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """Coordinates (n_cells,) of the modelled cells on the plane."""
        x, y = np.meshgrid(*self.along, indexing="ij")
        return x.ravel(), y.ravel()

    @cached_property
    def cells(self) -> Array:
        """Centres (n_cells, 3) of the modelled cells on the surface, in the body's axes."""
        plane = self.at(*self.places)
        return plane if self.depths is None else plane - self.depths[:, None] * self.normal

    def node_places(self, order: int) -> tuple[Array, Array]:
        """Coordinates (k,) on the plane of the Chebyshev nodes of an order, see `chebyshev`."""
        along = (nodes(b, order, even) for b, even in zip(self.half, self.mirrored, strict=True))
        x, y = np.meshgrid(*along, indexing="ij")
        return x.ravel(), y.ravel()

    def at(self, x: Array, y: Array) -> Array:
        """Points (n, 3) of the plane in the body's axes."""
        return self.origin + np.stack([x, y], axis=-1) @ self.axes[:, :2].T

    def on_surface(self, x: Array, y: Array) -> Array:
        """Points (n, 3) of the surface, smoothed by its relief, in the body's axes."""
        plane = self.at(x, y)
        return plane if self.relief is None else plane - self.relief.depth(x, y)[..., None] * self.normal

    def faces(self, other: Window, pose: Pose) -> bool:
        """Whether its cells lie opposite those of another window, whose axes have a pose in its own."""
        if self.grid != other.grid or self.mirrored != other.mirrored:
            return False
        axes = pose.rotation @ other.axes * np.array([1.0, 1.0, -1.0])
        aside = (pose.to_world(other.origin[None])[0] - self.origin) @ self.axes[:, :2]
        return bool(np.abs(axes - self.axes).max() <= OPPOSITE and (np.abs(aside) <= OPPOSITE * self.half).all())

    def coordinates(self, points: Array) -> Array:
        """Coordinates (..., 3) along its directions and the outward normal, of points in the body's axes."""
        return (points - self.origin) @ self.axes


MIN_FACING = 0.5
"""Cosine between the normal of a face and the direction from which the face looks along it."""


def facing(mesh: Mesh, faces: IntArray, direction: Array) -> IntArray:
    """Those of faces (n, 2) that look along a direction (3,), out of their cells.

    Examples
    --------
    >>> from fecontact.mesh import shapes
    >>> cube = shapes.block((1.0, 1.0, 1.0), (2, 1, 1))
    >>> len(facing(cube, cube.outer_faces, np.array([0.0, 0.0, 1.0])))
    2
    """
    corners = mesh.points[mesh.face_nodes(faces)[:, :4]]
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    triangle = np.linalg.norm(corners[:, 3] - corners[:, 2], axis=1) == 0
    across[triangle] = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[triangle]
    return faces[across @ direction > MIN_FACING * np.linalg.norm(across, axis=1)]


MIN_EFFECT = 1e-5
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
    if abs(3 * material.nu - 1) / (2 * (1 - material.nu)) * (slopes**2).sum(axis=1).max() > MIN_EFFECT:
        depths = window.relief.depth(x, y).reshape(window.shape)
        yield InclinedTerm(depths, slopes.reshape(*window.shape, 2), window.grid.cell, material, window.mirrored)


def principal(window: Window) -> Array:
    """Curvatures (2,) of the surface along the window's directions in its middle, convex positive."""
    if window.relief is None:
        return np.zeros(2)
    middle = np.zeros(1)
    return np.diagonal(window.relief.hessian(middle, middle)[0]).copy()
