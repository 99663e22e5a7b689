"""Picture of a mesh: outer faces or a section, named boundaries in colours and numbered. Needs matplotlib only.

Renderer of curved facets: parallel projection, depth buffer, light, element edges.

Every facet is divided into flat triangles, finely enough for its outline, field and light, and each pixel shows the
triangle nearest to the eye. Light is that at nine points of a facet, interpolated. Curved faces stay curved, and hidden
surfaces do not depend on the order of the bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from fecontact.common.arguments import label
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import vector
from fecontact.common.errors import InputError
from fecontact.common.files import save_figure
from fecontact.common.units import UnitNames, Units
from fecontact.mesh.facets import shapes_on_square

#: Positions of the eye by name, as (azimuth, elevation) in degrees.
VIEWS = {
    "iso": (-60.0, 25.0),
    "x": (0.0, 0.0),
    "-x": (180.0, 0.0),
    "y": (90.0, 0.0),
    "-y": (-90.0, 0.0),
    "z": (-90.0, 90.0),
    "-z": (-90.0, -90.0),
    "below": (-60.0, -30.0),
}
#: Oversampling of pixels per direction, against jagged edges.
OVERSAMPLING = 2
#: Largest distance of a facet from its flat triangles, and their overlap that closes gaps between them, in pixels of
#: the oversampled drawing; largest difference of the field over its range, and of light.
FLATNESS, FIELD_STEP, LIGHT_STEP = 0.25, 1 / 250, 1 / 60
#: Shortest side of a triangle into which a facet is divided, in such pixels.
SHORTEST = 4.0
#: Places of the nine normals of a facet along its coordinates; at the corner of a triangle there is none.
INNER = np.array([0.01, 0.5, 0.99])
#: Share of ambient light, and the direction of the rest in the eye's axes (right, up, to the eye).
AMBIENT = 0.7
LIGHT = np.array([-0.35, 0.55, 0.76])
#: Size in pixels below which edges of facets are not drawn; they are fully drawn at five times it.
MIN_OUTLINED = 3.0
DARKEST = 0.5
#: Translucent surfaces: grey level and opacity.
VEIL = np.array([0.55, 0.6, 0.66])
OPACITY = 0.4
#: Depth over the picture's size up to which such a surface behind a face still covers it.
TOUCHING = 0.01
#: Pixels per block.
CHUNK = 40_000


@dataclass(frozen=True, eq=False)
class Camera:
    """Parallel projection.

    Attributes
    ----------
    axes : (3, 3) array
        Rows: right, up, towards the eye.
    """

    axes: Array

    @classmethod
    def looking(cls, view: str | tuple[float, float] = "iso") -> Camera:
        """Camera at an azimuth and an elevation (degrees), z upwards, or at one of `VIEWS`.

        Raises
        ------
        InputError
            Unknown view.

        Examples
        --------
        >>> Camera.looking("-y").axes.round(12).tolist()
        [[1.0, 0.0, 0.0], [-0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
        """
        if isinstance(view, str):
            if view not in VIEWS:
                raise InputError(f"Unknown view {view!r}; expected one of {', '.join(VIEWS)} or (azimuth, elevation).")
            view = VIEWS[view]
        azimuth, elevation = np.radians(vector("the view", view, 2))
        eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
        right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        return cls(np.stack([right, np.cross(eye, right), eye]))


@dataclass(frozen=True, eq=False)
class Image:
    """A drawing.

    Attributes
    ----------
    rgba : (height, width, 4) array
        Row 0 at the bottom; transparent where there is nothing.
    extent : (left, right, bottom, top)
        Extent along the camera's axes, in lengths.
    """

    rgba: Array
    extent: tuple[float, float, float, float]


def draw_facets(
    points: Array,
    facets: IntArray,
    values: Array,
    colours: Callable[[Array], Array],
    camera: Camera,
    size: tuple[int, int] = (1000, 800),
    edges: bool = True,
    closed: bool = False,
    veil: tuple[Array, IntArray] | None = None,
) -> Image:
    """Draw facets in the colours of a nodal field.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array
        As in `fecontact.mesh.facets`.
    values : (n_points,) array
    colours : callable
        Function from values (n,) to red, green, blue in [0, 1], (n, 3).
    camera : Camera
    size : (width, height)
        Largest width and height in pixels.
    edges : bool
        Whether to draw the sides of the facets.
    closed : bool
        Whether the facets enclose bodies, corners counter-clockwise seen from outside: back faces are then left out.
    veil : (points, facets), optional
        Surfaces drawn translucent over the facets behind them.

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    >>> grey = lambda v: np.repeat(v[:, None], 3, axis=1)
    >>> image = draw_facets(square, np.array([[0, 1, 2, 3]]), np.ones(4), grey, Camera.looking("z"), (20, 20))
    >>> image.rgba.shape, bool((image.rgba[..., 3] == 1.0)[2:-2, 2:-2].all())
    ((20, 20, 4), True)
    """
    seen = points @ camera.axes.T
    veiled = np.zeros((0, 3)) if veil is None else (veil[0] @ camera.axes.T)[np.unique(veil[1])]
    canvas = _Canvas.fitting(np.concatenate([seen[np.unique(facets)], veiled]), size)
    # columns: position in pixels along the camera's axes and value
    patches = _patches(np.column_stack([canvas.in_pixels(seen), values]), facets)
    triangles, facet = _triangles(patches, closed)
    canvas.draw(triangles)
    drawn, value, light = canvas.seen()
    if edges:
        dark = np.zeros(len(canvas.depth))
        for xyz, strength in _edge_samples(patches[np.unique(facet)]):
            canvas.mark(dark, xyz, strength)
        light = light * (1 - dark[drawn])
    rgba = np.zeros((len(canvas.depth), 4), dtype=np.float32)
    rgba[drawn, :3], rgba[drawn, 3] = colours(value) * light[:, None], 1.0
    if veil is not None and len(veil[1]):
        _draw_veil(canvas, rgba, veil[0] @ camera.axes.T, veil[1])
    return canvas.image(rgba)


def _draw_veil(canvas: _Canvas, rgba: Any, seen: Array, facets: IntArray) -> None:
    """Blend a translucent grey over the pixels (n, 4) behind facets, with points in the eye's axes."""
    sheet = _Canvas(canvas.lower, canvas.pixel, canvas.shape)
    nodal = np.column_stack([sheet.in_pixels(seen), np.zeros(len(seen))])
    sheet.draw(_triangles(_patches(nodal, facets), closed=False)[0])
    hit, _, light = sheet.seen()
    # in a contact the depths of both bodies differ by the mismatch of their faces only
    over = sheet.depth[hit] > canvas.depth[hit] - TOUCHING * max(canvas.shape)
    hit, light = hit[over], light[over]
    under = rgba[hit, 3:]
    # over white where nothing is behind
    rgba[hit, :3] = OPACITY * VEIL * light[:, None] + (1 - OPACITY) * (under * rgba[hit, :3] + 1 - under)
    rgba[hit, 3] = 1.0


def _patches(nodal: Array, facets: IntArray) -> Array:
    """Values (n_facets, 3, 3, k) of nodal fields (n_points, k) at s, t = 0, 1/2, 1 of the square over each facet.

    Their biquadratic interpolation is the facet itself, of 4, 8 or 9 nodes or a triangle of 3 or 6.
    """
    t = np.array([0.0, 0.5, 1.0])
    N, _ = shapes_on_square(facets, np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2))
    return (N @ nodal[facets]).reshape(len(facets), 3, 3, -1)


def subdivided(nodal: Array, facets: IntArray, n: int) -> tuple[Array, IntArray]:
    """Facets divided into n x n flat quadrilaterals.

    Parameters
    ----------
    nodal : (n_points, k) array
        Positions and other values to interpolate.
    facets : (n_facets, 4 | 8 | 9) int array
    n : int

    Returns
    -------
    (n_facets (n + 1)^2, k) array
    (n_facets n^2, 4) int array
    """
    N = _quadratics(np.linspace(0.0, 1.0, n + 1))
    fine = _at(_patches(nodal, facets), N, N).reshape(-1, nodal.shape[1])
    index = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    starts = (n + 1) ** 2 * np.arange(len(facets))
    return fine, (starts[:, None, None] + quads).reshape(-1, 4)


def _at(patches: Array, along: Array, across: Array) -> Array:
    """Sums (n_facets, n, m, k) of facets' values (n_facets, 3, 3, k) by functions (n, 3) and (m, 3)."""
    return np.asarray(np.einsum("si,fijk,tj->fstk", along, patches, across, optimize=True))


def _quadratics(t: Array) -> Array:
    """Functions (n, 3) that are one at t = 0, 1/2 and 1."""
    return np.stack([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)], axis=1)


def _slopes(t: Array) -> Array:
    """Their derivatives (n, 3)."""
    return np.stack([4 * t - 3, 4 - 8 * t, 4 * t - 1], axis=1)


class _Canvas:
    """Depth buffer of the oversampled drawing, with the visible triangle; lengths in its pixels."""

    def __init__(self, lower: Array, pixel: float, shape: tuple[int, int]) -> None:
        self.lower, self.pixel, self.shape = lower, pixel, shape
        n = shape[0] * shape[1]
        self.depth, self.triangle = np.full(n, -np.inf), np.full(n, -1, dtype=np.int64)
        self.triangles = np.zeros((0, 3, 5))

    @classmethod
    def fitting(cls, seen: Array, size: tuple[int, int]) -> _Canvas:
        """Canvas over the visible points, with a narrow margin."""
        low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
        span = np.maximum(high - low, 1e-6 * max((high - low).max(), 1e-300))
        pixel = float((span / (np.array(size) - 2)).max()) / OVERSAMPLING
        width, height = (np.ceil(span / pixel / OVERSAMPLING).astype(int) + 2).tolist()
        return cls(low - OVERSAMPLING * pixel, pixel, (OVERSAMPLING * height, OVERSAMPLING * width))

    def in_pixels(self, seen: Array) -> Array:
        """Points (n, 3) in pixels; the centres of pixels have whole numbers."""
        return np.asarray((seen - [*self.lower, 0.0]) / self.pixel - [0.5, 0.5, 0.0])

    def draw(self, triangles: Array) -> None:
        """Draw triangles (n, 3, 5), counter-clockwise, of position, value and light; each pixel keeps the nearest."""
        self.triangles = triangles
        low, high = (f(triangles[..., 2], axis=1) for f in (np.min, np.max))
        planes = np.stack([*_planes(triangles, (2,))[:, 0].T, low, high])
        box = np.ceil(np.ptp(triangles[..., :2], axis=1) + 2 * FLATNESS).prod(axis=1)
        blocks = np.searchsorted(np.cumsum(box), np.arange(CHUNK, box.sum(), CHUNK))
        for some in np.split(np.arange(len(triangles)), np.unique(blocks)):
            which, row, column = _covered(triangles[some, :, :2], self.shape)
            k = some[which]
            at, along, up, least, most = np.take(planes, k, axis=1)
            # a steep triangle keeps to its depths beyond its sides
            z = np.clip(at + along * column + up * row, least, most)
            pixel = row * self.shape[1] + column
            np.maximum.at(self.depth, pixel, z)
            wins = np.flatnonzero(z >= self.depth[pixel])
            self.triangle[pixel[wins]] = k[wins]

    def seen(self) -> tuple[IntArray, Array, Array]:
        """Pixels (n,) that show something, the field there and the light."""
        drawn = np.flatnonzero(self.triangle >= 0)
        ends = [f(self.triangles[..., 3:], axis=1) for f in (np.min, np.max)]
        planes = np.stack([*_planes(self.triangles, (3, 4)).T, *(end.T for end in ends)])
        found = np.zeros((2, len(drawn)))
        for start in range(0, len(drawn), CHUNK):
            some = drawn[start : start + CHUNK]
            row, column = np.divmod(some, self.shape[1])
            at, along, up, low, high = np.take(planes, self.triangle[some], axis=2)
            found[:, start : start + CHUNK] = np.clip(at + along * column + up * row, low, high)
        return drawn, found[0], AMBIENT + (1 - AMBIENT) * np.clip(found[1], 0.0, 1.0)

    def mark(self, dark: Array, xyz: Array, strength: Array) -> None:
        """Add to `dark` (n_pixels,) the darkening by visible samples of lines."""
        place = xyz[:, :2].astype(np.int64)
        first = np.clip(place[:, 1], 0, self.shape[0] - OVERSAMPLING) * self.shape[1]
        first += np.clip(place[:, 0], 0, self.shape[1] - OVERSAMPLING)
        for i, j in np.ndindex(OVERSAMPLING, OVERSAMPLING):
            pixel = first + i * self.shape[1] + j
            visible = xyz[:, 2] + 4 >= self.depth[pixel]
            np.maximum.at(dark, pixel[visible], strength[visible])

    def image(self, rgba: Any) -> Image:
        """Mean colour of the oversampled pixels (n, 4)."""
        rows, columns = (k // OVERSAMPLING for k in self.shape)
        every = rgba.reshape(*self.shape, 4)
        shifts = np.ndindex(OVERSAMPLING, OVERSAMPLING)
        mean = np.mean([every[i::OVERSAMPLING, j::OVERSAMPLING] for i, j in shifts], axis=0)
        cover = mean[..., 3:]
        mean[..., :3] = np.divide(mean[..., :3], cover, out=np.ones_like(mean[..., :3]), where=cover > 0)
        step = OVERSAMPLING * self.pixel
        left, bottom = self.lower.tolist()
        return Image(np.clip(mean, 0.0, 1.0), (left, left + columns * step, bottom, bottom + rows * step))


def _facing(patches: Array) -> Array:
    """Cosine (n_facets, 3, 3, 1) between the normal and the light at `INNER` points of facets."""
    N, slopes = _quadratics(INNER), _slopes(INNER)
    along, across = (_at(patches[..., :3], a, b) for a, b in ((slopes, N), (N, slopes)))
    normal = np.cross(along, across)
    size = np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), np.finfo(float).tiny)
    return np.asarray((normal / size) @ (LIGHT / np.linalg.norm(LIGHT)))[..., None]


def _triangles(patches: Array, closed: bool) -> tuple[Array, IntArray]:
    """Flat triangles (n, 3, 5) of position, value and light, and the facets (n_facets, 3, 3, 4) that they stand for.

    Those turned away from the eye are left out if the facets enclose bodies, and turned round if not.
    """
    patches = np.concatenate([patches, _facing(patches)], axis=-1)
    found, facet = [], []
    for (n, m), chosen in _grouped(_divisions(patches)):
        s, t = np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 1.0, m + 1)
        grid = _at(patches[chosen], _quadratics(s), _quadratics(t))
        a, b, c, d = grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:]
        found += [np.stack(corners, axis=-2).reshape(-1, 3, 5) for corners in ((a, b, c), (a, c, d))]
        facet += 2 * [np.repeat(chosen, n * m)]
    every = np.concatenate(found)
    area = _double_area(every)
    kept = area > 0
    if not closed:
        behind = area < 0
        every[behind] = every[behind][:, [0, 2, 1]]
        every[behind, :, 4] *= -1
        kept |= behind
    return every[kept], np.concatenate(facet)[kept]


def _divisions(patches: Array) -> IntArray:
    """Divisions (n_facets, 2) of facets (n_facets, 3, 3, 5), powers of two, by which triangles follow them."""
    values = patches[..., 3]
    scale = np.array([FLATNESS, FLATNESS, FLATNESS, FIELD_STEP * (float(np.ptp(values)) or 1.0), LIGHT_STEP])
    counts = np.stack(
        [
            # a chord over 1/n of a parabola is off by 1/(2 n^2) of its second difference
            np.sqrt(np.abs(np.diff(patches, 2, axis=k) / (2 * scale)).max(axis=(1, 2, 3)))
            for k in (1, 2)
        ],
        axis=1,
    )
    # the middle of a twisted quadrilateral is off its diagonal by a quarter of the mixed difference
    corners = patches[:, ::2, ::2]
    twist = np.diff(np.diff(corners, axis=1), axis=2)[:, 0, 0, 2:] / (4 * scale[2:])
    counts = np.maximum(counts, np.sqrt(np.abs(twist).max(axis=1))[:, None])
    counts = np.clip(counts, 1.0, np.maximum(_extents(patches) / SHORTEST, 1.0))
    return np.asarray(2 ** np.ceil(np.log2(counts)).astype(np.int64))


def _double_area(triangles: Array) -> Array:
    """Twice the areas (n,) of triangles in the picture, negative if they are turned away."""
    (x1, y1), (x2, y2) = (np.moveaxis(triangles[:, k, :2] - triangles[:, 0, :2], -1, 0) for k in (1, 2))
    return np.asarray(x1 * y2 - x2 * y1)


def _planes(triangles: Array, columns: tuple[int, ...]) -> Array:
    """Values at the origin and slopes along x and y (n, n_columns, 3) of columns of triangles (n, 3, 5)."""
    first, (one, two) = triangles[:, 0], (triangles[:, k] - triangles[:, 0] for k in (1, 2))
    area = _double_area(triangles)[:, None]
    k = list(columns)
    x = (one[:, k] * two[:, 1:2] - two[:, k] * one[:, 1:2]) / area
    y = (two[:, k] * one[:, 0:1] - one[:, k] * two[:, 0:1]) / area
    return np.stack([first[:, k] - x * first[:, 0:1] - y * first[:, 1:2], x, y], axis=-1)


def _covered(corners: Array, shape: tuple[int, int]) -> tuple[IntArray, IntArray, IntArray]:
    """Pixels that counter-clockwise triangles (n, 3, 2) cover, widened by `FLATNESS`: triangle, row and column."""
    low, high = corners.min(axis=1) - FLATNESS, corners.max(axis=1) + FLATNESS
    which, row = _ranges(np.ceil(np.maximum(low[:, 1], 0)), np.floor(np.minimum(high[:, 1], shape[0] - 1)))
    left, right = low[which, 0], high[which, 0]
    for k in range(3):
        start, side = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        # a side along the rows bounds these only
        rise = np.where(side[:, 1] == 0, 1.0, side[:, 1])
        slope, wide = side[:, 0] / rise, FLATNESS * np.linalg.norm(side, axis=1) / np.abs(rise)
        crossing = (start[:, 0] - start[:, 1] * slope)[which] + slope[which] * row
        falls, rises = (side[:, 1] < 0)[which], (side[:, 1] > 0)[which]
        left = np.where(falls, np.maximum(left, crossing - wide[which]), left)
        right = np.where(rises, np.minimum(right, crossing + wide[which]), right)
    span, column = _ranges(np.ceil(np.maximum(left, 0)), np.floor(np.minimum(right, shape[1] - 1)))
    return which[span], row[span], column


def _ranges(first: Array, last: Array) -> tuple[IntArray, IntArray]:
    """Whole numbers from `first` to `last` (n,) of each of them: which, and the number."""
    counts = np.maximum(last - first + 1, 0).astype(np.int64)
    which = np.repeat(np.arange(len(counts)), counts)
    begin = first.astype(np.int64) - (np.cumsum(counts) - counts)
    return which, np.arange(len(which)) + begin[which]


def _extents(patches: Array) -> Array:
    """Lengths (n_facets, 2) of each facet along its two coordinates in pixels, at the rate of the faster half."""
    along = [2 * np.linalg.norm(np.diff(patches[..., :2], axis=k), axis=-1).max(axis=(1, 2)) for k in (1, 2)]
    return np.stack(along, axis=1)


def _grouped(counts: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Distinct rows of counts (n, 2), and the rows equal to each."""
    kinds, kind = np.unique(counts, axis=0, return_inverse=True)
    for k, pair in enumerate(kinds):
        yield pair, np.flatnonzero(kind.ravel() == k)


def _edge_samples(patches: Array) -> Iterator[tuple[Array, Array]]:
    """Position and strength of samples on the facets' sides."""
    extent = _extents(patches) / OVERSAMPLING
    strength = DARKEST * np.clip(extent.min(axis=1) / MIN_OUTLINED - 1, 0.0, 4.0) / 4
    for axis, end in ((0, 0), (0, 2), (1, 0), (1, 2)):
        along = 1 - axis
        shown = np.flatnonzero((strength > 0) & (extent[:, along] > 0))
        counts = 2 ** np.ceil(np.log2(2 * OVERSAMPLING * extent[shown, along] + 2)).astype(np.int64)
        for n in np.unique(counts).tolist():
            some = shown[counts == n]
            side = np.take(patches[some, ..., :3], end, axis=1 + axis)
            yield (_quadratics(np.linspace(0.0, 1.0, n + 1)) @ side).reshape(-1, 3), np.repeat(strength[some], n + 1)


#: Colour of faces in no boundary, colour map of the boundaries, and their longest list in a legend.
PLAIN, COLOURS, LISTED = (0.87, 0.87, 0.87), "tab20", 20
PIXELS = (1100, 820)
#: Cosine between a boundary's mean normal and the eye from which on its number is written on it.
FACING = 0.15
#: Size of such a number over that of the picture.
NUMBER = 0.04
#: Difference of colours, of which the brightest part is one, up to which they are the same in another light.
SAME_HUE = 0.08


def plot_faces(
    points: Array,
    facets: IntArray,
    boundaries: Mapping[str, IntArray],
    path: str | Path | None,
    title: str,
    *,
    view: str | tuple[float, float] = "iso",
    edges: bool = True,
    units: UnitNames = (),
    length: str = "",
    closed: bool = True,
    veil: tuple[Array, IntArray] | None = None,
) -> Figure:
    """Draw facets, those of each named boundary in its colour.

    Parameters
    ----------
    points : (n_points, 3) array
    facets : (n_facets, 4 | 8 | 9) int array
    boundaries : mapping of name to (k,) int array
        Facets of each boundary; of several, a facet shows the smallest.
    path : str or Path or None
        File to write.
    title : str
    view : str or (azimuth, elevation) in degrees
        Direction of view, see `renderer.VIEWS`.
    edges : bool
        Whether to draw the elements.
    units : (length, ...) or str
        Names of units as of a scene, of which the ruler shows that of length; or it alone.
    length : str
        The same.
    closed : bool
        Whether the facets enclose a body, so that those turned away need no drawing.
    veil : (points, facets), optional
        Surfaces drawn translucent over what is behind them.

    Raises
    ------
    InputError
        For an unknown direction, or a file that cannot be written.
    """
    camera = Camera.looking(view)
    number = np.zeros(len(facets))
    ranked = sorted(boundaries, key=lambda name: -len(boundaries[name]))
    order = {name: k for k, name in enumerate(boundaries, start=1)}
    for name in ranked:
        number[boundaries[name]] = order[name]
    # every facet has nodes of its own, so that colours do not run into each other
    own = np.arange(facets.size).reshape(facets.shape)
    coloured = np.array([PLAIN, *(_colour(k) for k in range(len(boundaries)))])
    image = draw_facets(
        points[facets].reshape(-1, 3),
        _alike(own, facets),
        np.repeat(number, facets.shape[1]),
        lambda v: coloured[np.rint(v).astype(int)],
        camera,
        PIXELS,
        edges,
        closed,
        veil,
    )
    figure, axes = framed(image, camera, title, Units.labels(units, "length", length=length).length)
    _number_boundaries(axes, camera, points, facets, boundaries, None if veil else image)
    _list_boundaries(figure, boundaries, "faces")
    return save_figure(figure, path)


def plot_sides(
    points: Array,
    cells: IntArray,
    boundaries: Mapping[str, Array],
    path: str | Path | None,
    title: str,
    *,
    view: str | tuple[float, float] = "-y",
    edges: bool = True,
    units: UnitNames = (),
    length: str = "",
) -> Figure:
    """Draw cells of a section, the sides of each named boundary as a line of its colour.

    Parameters
    ----------
    points : (n_points, 3) array
    cells : (n_cells, 8 | 9) int array
    boundaries : mapping of name to (k, n, 3) array
        Points along each side, an odd number.
    path, title, view, edges, units, length
        As for `plot_faces`.

    Raises
    ------
    InputError
        As for `plot_faces`.
    """
    camera = Camera.looking(view)
    image = draw_facets(
        points, cells, np.zeros(len(points)), lambda v: np.tile(PLAIN, (len(v), 1)), camera, PIXELS, edges, False
    )
    figure, axes = framed(image, camera, title, Units.labels(units, "length", length=length).length)
    for k, sides in enumerate(boundaries.values()):
        curves = sides @ camera.axes[:2].T
        axes.add_collection(LineCollection(list(curves), colors=[_colour(k)], linewidths=3.0, capstyle="round"))
        middles = curves[:, curves.shape[1] // 2]
        if len(middles):
            nearest = np.argmin(((middles - middles.mean(axis=0)) ** 2).sum(axis=1))
            _write_number(axes, k + 1, middles[nearest])
    _list_boundaries(figure, boundaries, "sides")
    return save_figure(figure, path)


def _list_boundaries(figure: Figure, boundaries: Mapping[str, Array] | Mapping[str, IntArray], members: str) -> None:
    """Legend of boundaries beside the picture; of the figure, so that the layout keeps room for any names."""
    if not boundaries:
        return
    listed = list(boundaries)[:LISTED]
    handles = [
        Patch(color=_colour(k), label=f"{k + 1}  {name}, {len(boundaries[name])} {members}")
        for k, name in enumerate(listed)
    ]
    rest = len(boundaries) - len(listed)
    more = f"and {rest} more" if rest else None
    figure.legend(handles=handles, loc="outside right center", frameon=False, title=more)


def framed(
    image: Image,
    camera: Camera,
    title: str,
    length: str,
    scale: tuple[ScalarMappable, str] | None = None,
    extend: str = "neither",
) -> tuple[Figure, Any]:
    """Figure and axes of a drawing, with a title, a ruler, the world's axes, and a scale of colours with its label.

    `extend` tells the ends of the scale beyond which there are values: 'neither', 'min', 'max' or 'both'.
    """
    left, right, bottom, top = image.extent
    width = float(np.clip(5.6 * (right - left) / (top - bottom) + 2.2, 4.6, 9.6))
    figure = Figure(figsize=(width, 6.6), layout="constrained")
    axes = figure.subplots()
    axes.imshow(image.rgba, extent=image.extent, origin="lower", interpolation="antialiased")
    axes.set_axis_off()
    axes.set_title(title, pad=12)  # above the number of a boundary on top
    if scale is not None:
        figure.colorbar(scale[0], ax=axes, shrink=0.75, pad=0.02, label=scale[1], extend=extend)
    _draw_ruler(axes, image, label("the unit of length", length))
    _draw_triad(figure, camera)
    return figure, axes


def _alike(own: IntArray, facets: IntArray) -> IntArray:
    """Facets of own nodes in which those are the same that are the same in others: corners of triangles."""
    first = np.argmax(facets[:, :, None] == facets[:, None, :], axis=2)
    return np.take_along_axis(own, first, axis=1)


def _colour(k: int) -> tuple[float, float, float]:
    red, green, blue, _ = colormaps[COLOURS]((k % 20 + 0.5) / 20)
    return red, green, blue


def _number_boundaries(
    axes: Any,
    camera: Camera,
    points: Array,
    facets: IntArray,
    boundaries: Mapping[str, IntArray],
    image: Image | None = None,
) -> None:
    """Write the number of each boundary on that of its facets which is nearest to the middle of those that are seen.

    Facets are seen that face the eye and, without a veil, whose colour is where they are in the picture. Those on which
    a number would cover another one are passed over while there are others.
    """
    corners = points[facets[:, :4]]
    middles = corners.mean(axis=1)
    areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    towards = areas @ camera.axes[2] / np.maximum(np.linalg.norm(areas, axis=1), np.finfo(float).tiny)
    places = middles @ camera.axes[:2].T
    apart, taken = NUMBER * np.ptp(places, axis=0).max(), np.empty((0, 2))
    for k, chosen in enumerate(boundaries.values(), start=1):
        facing = chosen[towards[chosen] > FACING]
        if image is not None and len(facing):
            facing = facing[_coloured(image, places[facing], _colour(k - 1))]
        if len(facing):
            off = np.linalg.norm(middles[facing] - middles[facing].mean(axis=0), axis=1)
            near = np.linalg.norm(places[facing][:, None] - taken, axis=2).min(axis=1, initial=np.inf) < apart
            taken = np.vstack([taken, places[facing[np.lexsort((off, near))[0]]]])
            _write_number(axes, k, taken[-1])


def _coloured(image: Image, places: Array, colour: tuple[float, float, float]) -> Mask:
    """Whether a picture has a colour, in whatever light, at places (n, 2) along the camera's axes."""
    left, right, bottom, top = image.extent
    height, width = image.rgba.shape[:2]
    share = (places - [left, bottom]) / [right - left, top - bottom]
    column, row = (np.clip((share * [width, height]).astype(int), 0, [width - 1, height - 1])).T
    found, wanted = image.rgba[row, column, :3].astype(float), np.array(colour)
    brightest = np.maximum(found.max(axis=1, keepdims=True), np.finfo(float).tiny)
    return np.asarray(np.abs(found / brightest - wanted / wanted.max()).max(axis=1) < SAME_HUE)


def _write_number(axes: Any, number: int, place: Array) -> None:
    box = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": "0.3", "alpha": 0.85}
    axes.annotate(str(number), tuple(place), ha="center", va="center", fontsize="small", bbox=box)


def _draw_ruler(axes: Any, image: Image, length: str) -> None:
    """A ruler of a round length below the picture; the projection is parallel, so it holds everywhere."""
    left, right, bottom, top = image.extent
    target = 0.2 * (right - left)
    decade = 10 ** np.floor(np.log10(target))
    size = max(f * decade for f in (1.0, 2.0, 5.0) if f * decade <= target)
    y = bottom - 0.05 * (top - bottom)
    axes.plot([right - size, right], [y, y], color="black", linewidth=2.5, solid_capstyle="butt", clip_on=False)
    text = f"{size:g} {length}".strip()
    axes.text(right - size / 2, y - 0.02 * (top - bottom), text, ha="center", va="top")
    axes.set_ylim(bottom - 0.12 * (top - bottom), top)
    axes.set_xlim(left, right)


def _draw_triad(figure: Figure, camera: Camera) -> None:
    """The world's axes in the lower left corner."""
    axes = figure.add_axes((0.01, 0.01, 0.11, 0.16))
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.set_xlim(-1.4, 1.4)
    axes.set_ylim(-1.4, 1.4)
    for k in np.argsort(camera.axes[2]).tolist():
        x, y = camera.axes[:2, k]
        name, colour = "xyz"[k], ("tab:red", "tab:green", "tab:blue")[k]
        axes.annotate("", (x, y), (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0})
        if np.hypot(x, y) > 0.05:
            axes.text(1.25 * x, 1.25 * y, name, color=colour, ha="center", va="center")
