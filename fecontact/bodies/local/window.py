"""Window of a local body: the tangent plane round the contact, its cells, the relief of the surface over it.

Its surface in a scene, and half-spaces with their cells opposite those of a window.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.polynomial import chebyshev as series

from fecontact.analytic import curved_kernel
from fecontact.analytic.face_loads import FaceLoads, displacements
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace.fft import InclinedTerm
from fecontact.halfspace.grid import Even, Grid, GridSurface, between_cells, part_of
from fecontact.halfspace.operator import CellModel
from fecontact.mesh.facets import sides_of
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import Projection


def nodes(half: float, order: int, mirrored: bool) -> Array:
    """Chebyshev nodes on (-half, half), increasing; of an even number, the positive ones where it is mirrored.

    Examples
    --------
    >>> nodes(1.0, 2, True).round(4).tolist()
    [0.7071]
    """
    x = -half * np.cos(np.pi * (np.arange(order) + 0.5) / order)
    return np.asarray(x[order // 2 :] if mirrored else x)


def polynomials(x: Array, half: float, order: int, mirrored: bool) -> Array:
    """Chebyshev polynomials (n, k) of x / half below an order; where it is mirrored, the even ones.

    Examples
    --------
    >>> polynomials(np.array([0.5]), 1.0, 4, True).round(12).tolist()
    [[1.0, -0.5]]
    """
    degree = np.arange(0, order, 2 if mirrored else 1)
    return np.asarray(np.cos(degree * np.arccos(np.clip(x / half, -1.0, 1.0))[:, None]))


def coefficients(half: float, order: int, mirrored: bool) -> Array:
    """Matrix (k, k) from values at `nodes` to the coefficients of `polynomials`.

    Source: discrete orthogonality at the zeros of T_order (J. C. Mason, D. C. Handscomb, Chebyshev Polynomials, 2003,
    section 4.6).

    Examples
    --------
    >>> values = nodes(2.0, 4, False) ** 2
    >>> bool(np.allclose(coefficients(2.0, 4, False) @ values, [2.0, 0.0, 2.0, 0.0]))
    True
    """
    T = polynomials(nodes(half, order, mirrored), half, order, mirrored)
    scale = np.full(T.shape[1], 2.0 / len(T))
    scale[0] /= 2
    return np.asarray(scale[:, None] * T.T)


def interpolation(x: Array, half: float, order: int, mirrored: bool) -> Array:
    """Matrix (n, k) from values at `nodes` to the interpolating polynomial at x (n,).

    Examples
    --------
    >>> x = np.array([0.3, 1.5])
    >>> (interpolation(x, 2.0, 3, False) @ nodes(2.0, 3, False) ** 2).round(12).tolist()
    [0.09, 2.25]
    """
    return np.asarray(polynomials(x, half, order, mirrored) @ coefficients(half, order, mirrored))


#: Extent of the polynomial, relative to the window.
REACH = 1.5

#: Degree of the polynomial along either direction.
DEGREE = 8

#: Points along either side at which the surface is sampled.
FITTED = 25

Depths = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class Relief:
    """Depth of a surface below its tangent plane, as a polynomial over a window and its surroundings.

    Attributes
    ----------
    reach : (2,) array
        Half the sides of the rectangle.
    terms : (n, n) array
        Coefficients of products of Chebyshev polynomials of x / reach and y / reach.
    misfit : float
        Largest distance of the samples from it.

    Examples
    --------
    >>> ball = fit(lambda x, y: 10 - np.sqrt(100 - x**2 - y**2), np.array([1.0, 1.0]), (True, True))
    >>> ball.slopes(np.array([0.6]), np.array([0.0])).round(6).tolist()
    [[0.060108, 0.0]]
    """

    reach: Array
    terms: Array
    misfit: float

    def _derivative(self, x: Array, y: Array, along_x: int, along_y: int) -> Array:
        terms = series.chebder(series.chebder(self.terms, along_x, axis=0), along_y, axis=1)
        values = series.chebval2d(x / self.reach[0], y / self.reach[1], terms)
        return np.asarray(values / self.reach[0] ** along_x / self.reach[1] ** along_y)

    def covers(self, x: Array, y: Array) -> Mask:
        """Whether places lie within its extent."""
        return np.asarray((np.abs(x) <= self.reach[0]) & (np.abs(y) <= self.reach[1]))

    def depth(self, x: Array, y: Array) -> Array:
        """Depths (n,)."""
        return self._derivative(x, y, 0, 0)

    def slopes(self, x: Array, y: Array) -> Array:
        """Slopes (n, 2) of the depth."""
        return np.stack([self._derivative(x, y, 1, 0), self._derivative(x, y, 0, 1)], axis=-1)

    def hessian(self, x: Array, y: Array) -> Array:
        """Second derivatives (n, 2, 2) of the depth, positive where the body is convex."""
        xx, xy, yy = (self._derivative(x, y, *k) for k in ((2, 0), (1, 1), (0, 2)))
        return np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)

    def curvature(self, x: Array, y: Array) -> Array:
        """Curvature tensors (n, 3, 3) of the surface, along the plane's directions and its outward normal."""
        slopes, bend = self.slopes(x, y), self.hessian(x, y)
        up = np.concatenate([slopes, np.ones((*slopes.shape[:-1], 1))], axis=-1)
        length = np.linalg.norm(up, axis=-1)
        n = up / length[..., None]
        P = np.eye(3) - n[..., :, None] * n[..., None, :]
        tensor = np.zeros((*x.shape, 3, 3))
        tensor[..., :2, :2] = bend / length[..., None, None]
        return np.asarray(P @ tensor @ P)


def fit(depths: Depths, half: Array, mirrored: Even) -> Relief:
    """The relief that fits a surface best, given its depths at places x (n,) and y (n,); NaN where there is none.

    Near the middle the samples are dense, in least squares of all that lie on the surface.
    """
    reach = REACH * half
    along = [nodes(r, 2 * FITTED if even else FITTED, even) for r, even in zip(reach, mirrored, strict=True)]
    x, y = (c.ravel() for c in np.meshgrid(*along, indexing="ij"))
    z = depths(x, y)
    there = np.isfinite(z)
    steps = [2 if even else 1 for even in mirrored]
    basis = series.chebvander2d(x / reach[0], y / reach[1], [DEGREE, DEGREE]).reshape(-1, DEGREE + 1, DEGREE + 1)
    chosen = basis[there, :: steps[0], :: steps[1]]
    count = chosen.shape[1:]
    found = np.linalg.lstsq(chosen.reshape(len(chosen), -1), z[there], rcond=1e-12)[0]
    terms = np.zeros((DEGREE + 1, DEGREE + 1))
    terms[:: steps[0], :: steps[1]] = found.reshape(count)
    return Relief(reach, terms, float(np.abs(chosen.reshape(len(chosen), -1) @ found - z[there]).max(initial=0.0)))


#: Largest slope of a surface over its tangent plane: effects of slope^4 are left out of the kernel.
MAX_SLOPE = 0.5

#: Difference of the axes of two windows, and of their middles relative to their size, that is rounding.
OPPOSITE = 1e-10


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
        """Coordinates (k,) on the plane of the Chebyshev nodes of an order, see `nodes`."""
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


#: Cosine between the normal of a face and the direction from which the face looks along it.
MIN_FACING = 0.5


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


#: Effect of slopes, relative to the compliance, below which it is left out.
MIN_EFFECT = 1e-5

#: Radius, relative to the distance of nodes in the middle of the window, and points of the circle round a load.
OWN, ROUND = 0.25, 8


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


@dataclass(frozen=True, eq=False)
class WindowSurface(GridSurface):
    """Cell centres of a window among the nodes, quadrilaterals between them as facets; last the nodes of the mesh.

    Parameters
    ----------
    window : Window
    """

    window: Window | None = None

    @property
    def is_window(self) -> bool:
        """True."""
        return True

    @property
    def _window(self) -> Window:
        assert self.window is not None
        return self.window

    @property
    def axes(self) -> tuple[Array, Array]:
        """Coordinates of the modelled cells along the window's directions."""
        return self._window.along

    @property
    def normal(self) -> Array:
        """Outward normal (3,) of the window."""
        return self._window.normal

    @cached_property
    def on_rim(self) -> Mask:
        """Mask (n_facets, 4) of the facets' sides on the rim; on a plane of symmetry the window goes on."""
        rim = super().on_rim.copy()
        ends = sides_of(self.facets) - self.start
        for place, mirrored in zip(np.divmod(ends, len(self.axes[1])), self._window.mirrored, strict=True):
            if mirrored:
                rim &= (place > 0).any(axis=2)
        return rim

    def project(self, points: Array, n_near: int = 3) -> Projection:
        """Projection along the window's normal of points (n, 3)."""
        window = self._window
        found = super().project(window.coordinates(points), n_near)
        assert found.weights is not None
        normals = np.tile(window.normal, (len(points), 1))
        plane = window.at(found.points[:, 0], found.points[:, 1])
        if window.depths is None:
            return replace(found, points=plane, normals=normals)
        depth = found.weights[:, self.start : self.start + len(window.depths)] @ window.depths
        return replace(found, points=plane - depth[:, None] * normals, normals=normals, gap=found.gap + depth)

    def moved(self, rotation: Array, translation: Array) -> Self:
        """The surface in other axes, rotated and translated."""
        window = self._window
        moved = replace(window, origin=rotation @ window.origin + translation, axes=rotation @ window.axes)
        return replace(super().moved(rotation, translation), window=moved)


def window_surface(window: Window, points: Array, name: str, start: int = 0) -> WindowSurface:
    """The surface of a window whose cells are from number `start` on among a body's points (n, 3)."""
    facets = between_cells(*window.shape) + start
    if np.linalg.det(window.axes) < 0:  # seen from the other side
        facets = facets[:, ::-1]
    return WindowSurface(points, facets, name, grid=window.grid, window=window, start=start)


#: Largest slope of a layered half-space over the window: effects of slope^2 are left out of its kernel.
STEEPEST_LAYERED = 0.01


@dataclass(frozen=True, eq=False, init=False)
class FacingHalfSpace(HalfSpace):
    """A half-space whose cells are those of a window on its surface.

    Parameters
    ----------
    half : HalfSpace
    window : Window
        In the half-space's axes; with a relief where the half-space inclines to it.
    """

    window: Window = field(repr=False)

    def __init__(self, half: HalfSpace, window: Window) -> None:
        super().__init__(
            half.material,
            window.grid.size,
            window.grid.shape,
            layers=half.layers,
            against=half.against,
            name=half.name,
        )
        for key, value in {"pose": half.pose, "window": window}.items():
            object.__setattr__(self, key, value)

    @cached_property
    def _cells(self) -> CellModel:
        slopes = () if self.material is None or self.layers else tuple(inclined(self.window, self.material))
        return CellModel(self.compliance, self.window.mirrored, slopes)

    @cached_property
    def facets(self) -> WindowSurface:  # type: ignore[override]
        """Its surface: cell centres and quadrilaterals between them."""
        return window_surface(self.window, self.window.cells, "surface")


def half_space_opposite(half: HalfSpace, other: Window, pose: Pose, names: tuple[str, str]) -> HalfSpace:
    """A half-space with its cells opposite those of a window; itself if they are.

    Parameters
    ----------
    half : HalfSpace
    other : Window
    pose : Pose
        Of the window's axes in the half-space's.
    names : (str, str)
        Of the half-space and the window's body, for messages.

    Raises
    ------
    InputError
        If the half-space does not lie opposite, is not symmetric where the window is, or has other pressures.
    """
    if isinstance(half, FacingHalfSpace) and half.window.faces(other, pose):
        return half
    if half.periodic or half.pressure != "uniform":
        found = "it is periodic" if half.periodic else f"it has pressure={half.pressure!r}"
        raise InputError(
            f"{names[0]!r} meets the local body {names[1]!r} cell on cell, with pressures uniform over the cells and "
            f"none beyond the window; {found}. Make it with periodic=False and pressure='uniform'.",
            code="local-body-coupling",
        )
    axes = pose.rotation @ other.axes * np.array([1.0, 1.0, -1.0])
    slopes = axes[2, :2] / axes[2, 2] if axes[2, 2] > 0 else np.full(2, np.inf)
    steepest = STEEPEST_LAYERED if half.layers else MAX_SLOPE
    if np.linalg.norm(slopes) > steepest:
        raise InputError(
            f"The surface of {names[0]!r} inclines by {np.linalg.norm(slopes):.3g} to the window of {names[1]!r}; up "
            f"to {steepest:g} is possible. Put the window where the surfaces are parallel, or check the poses.",
            code="window-inclined",
        )
    across = [side for side, even, s in zip("xy", other.mirrored, slopes, strict=True) if even and abs(s) > OPPOSITE]
    if across:
        raise InputError(
            f"{names[1]!r} is modelled up to planes of symmetry, to which {names[0]!r} is not normal. Model the body "
            "without them, or check the poses.",
            code="not-normal-to-symmetry",
        )
    origin = pose.to_world(other.origin[None])[0]
    origin = origin - origin[2] / axes[2, 2] * axes[:, 2]
    return FacingHalfSpace(half, _on_plane(Window(origin, axes, other.grid, other.mirrored), slopes))


def _on_plane(window: Window, slopes: Array) -> Window:
    """A window with the depths of the plane z = 0 below it, which has these slopes."""
    if np.abs(slopes).max() <= OPPOSITE:
        return window

    def depths(x: Array, y: Array) -> Array:
        return slopes[0] * x + slopes[1] * y

    relief = fit(depths, window.half, window.mirrored)
    return Window(window.origin, window.axes, window.grid, window.mirrored, relief, depths(*window.places))
