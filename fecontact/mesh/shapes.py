"""Ready-made bodies: block, ball, cylinder, thick ring, and spheres graded towards the contact point.

All sizes are lengths in the user's unit. Round shapes are **ring meshes**: a square core on the axis (no collapsed edge
inside a contact), then rings whose edges are circles. With ``contact_radius=a`` one ring lies at r = a exactly; the
rings narrow towards it from inside and widen from it outwards, because the pressure falls to zero there as a square
root: an element edge along it reduces the error more than refinement. Away from the contact widths grow by `growth` per
ring and per layer. The pole of a sphere is the local origin and its body lies in z >= 0, so that the sagitta
r^2 / (R + sqrt(R^2 - r^2)) is accurate.

Hexahedra on an index box, to be mapped to a shape, and the positions of its indices.

Patches of a meridian plane, interpolated between four curves.

Ring meshes: a square core on the axis, rings round it, and repetition of a quarter to a half or whole body.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import items, spelled
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, array_of, lengths, number, whole
from fecontact.common.errors import InputError, shown
from fecontact.mesh.grading import LEVELS, Level, RingGrading, as_level, geometric, grading
from fecontact.mesh.layer import extrude
from fecontact.mesh.mesh import Mesh, merge
from fecontact.mesh.refine import divided

__all__ = ["LEVELS", "Level", "RingGrading", "as_level", "geometric", "grading"]
__all__ += [
    "ball",
    "block",
    "cap",
    "cylinder",
    "divided",
    "extrude",
    "half_sphere",
    "merge",
    "quarter_sphere",
    "sphere",
]
__all__ += ["thick_ring"]


def __dir__() -> list[str]:
    """The public names."""
    return __all__


#: Largest deviation of the end positions, as a share of the size, that is corrected as rounding.
SAME_POSITION = 1e-9

#: Largest numbers of cells, of a mesh and along one line; beyond, arrays of nodes alone fill tens of gigabytes.
MAX_CELLS, MAX_ALONG = 10**8, 10**6

_NODES = {"hex8": 8, "hex20": 20, "hex27": 27}


def lattice(divisions: Sequence[int], names: Sequence[str | None], element: str = "hex20") -> Mesh:
    """Mesh of an index box [0, n1] x [0, n2] x [0, n3], to be mapped to its true shape.

    Parameters
    ----------
    divisions : three ints
    names : six names or None
        Boundaries at i = 0, i = n1, j = 0, j = n2, k = 0, k = n3.
    element : {'hex8', 'hex20', 'hex27'}
    """
    among("element", element, _NODES)
    given = items("the divisions", divisions, "three counts")
    if len(given) != 3:
        raise InputError(f"Divisions must be three positive integers; found {shown(divisions)}.")
    n = np.array([whole("a division", count) for count in given])
    if np.prod(n.astype(float)) > MAX_CELLS:
        raise InputError(f"{given} divisions are {np.prod(n.astype(float)):.3g} cells, more than {MAX_CELLS:.0e}.")
    index = np.arange(np.prod(n + 1)).reshape(n + 1)
    points = np.stack(np.meshgrid(*(np.arange(k + 1.0) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([index[tuple(slice(c, c + k) for c, k in zip(cor, n, strict=True))].ravel() for cor in corners], 1)
    number = np.arange(len(cells)).reshape(n)
    boundaries: dict[str, IntArray] = {}
    for face, name in enumerate(names):
        if name is not None:
            layer = np.take(number, -1 if face % 2 else 0, axis=face // 2).ravel()
            faces = np.stack([layer, np.full_like(layer, face)], axis=1)
            boundaries[name] = np.concatenate([boundaries[name], faces]) if name in boundaries else faces
    mesh = Mesh(points, cells, boundaries)
    return mesh if element == "hex8" else mesh.upgraded(_NODES[element])


def division(size: float, given: int | ArrayLike, what: str) -> Array:
    """Positions 0 ... size: an equal division, or the given increasing positions.

    Raises
    ------
    InputError
        If they do not increase or do not run from 0 to `size`; `what` names them in the message.
    """
    if isinstance(given, int | np.integer):
        return np.linspace(0.0, size, whole(f"the {what}", given, most=MAX_ALONG) + 1)
    found = array_of(given)
    positions = np.zeros(0) if found is None else found
    if positions.ndim != 1 or len(positions) < 2 or not (np.diff(positions) > 0).all():
        raise InputError(f"The {what} must be a count or increasing positions; found {shown(given)}.", code="divisions")
    if np.abs(positions[[0, -1]] - [0.0, size]).max() > SAME_POSITION * size:
        raise InputError(
            f"The positions of the {what} must run from 0 to {size:g}; found {positions[0]:g} to {positions[-1]:g}.",
            code="divisions",
        )
    inner = positions[1:-1]
    return np.concatenate([[0.0], inner[(inner > 0) & (inner < size)], [size]])


def interpolated(index: Array, positions: Array) -> Array:
    """Positions at fractional indices, linear between integer ones."""
    return np.interp(index, np.arange(len(positions)), positions)


Curve = Callable[[Array], Array]
Patch = Callable[[Array, Array], Array]


def coons(top: Curve, bottom: Curve, left: Curve, right: Curve) -> Patch:
    """Transfinite interpolation of curves [0, 1] -> (rho, z); top and bottom run along s, left and right along t."""
    zero, one = np.zeros(1), np.ones(1)
    c00, c10, c01, c11 = top(zero), top(one), bottom(zero), bottom(one)

    def patch(s: Array, t: Array) -> Array:
        a, b = s[:, None], t[:, None]
        corners = (1 - a) * (1 - b) * c00 + a * (1 - b) * c10 + (1 - a) * b * c01 + a * b * c11
        blended = ((1 - b) * top(s) + b * bottom(s)) + ((1 - a) * left(t) + a * right(t)) - corners
        return np.where(b == 0, top(s), blended)  # keeps the relative accuracy of a small sagitta

    return patch


def line(start: ArrayLike, end: ArrayLike) -> Curve:
    """Straight line (rho, z) from `start` to `end` over [0, 1]."""
    p, q = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    return lambda x: (1 - x)[:, None] * p + x[:, None] * q


def sagitta(r: Array, radius: float) -> Array:
    """Depth of a sphere's surface below its pole's tangent plane, r^2/(R + sqrt(R^2 - r^2)), without cancellation."""
    return r**2 / (radius + np.sqrt(np.maximum((radius - r) * (radius + r), 0.0)))


def spherical(extent: float, radius: float) -> Curve:
    """Surface of a sphere from its pole out to the distance `extent` from the axis; flat if the radius is infinite."""

    def curve(s: Array) -> Array:
        r = s * extent
        return np.stack([r, np.zeros_like(r) if np.isinf(radius) else sagitta(r, radius)], 1)

    return curve


def spherical_flank(radius: float) -> Curve:
    """Surface of a sphere from 45 degrees off its pole to the equator."""

    def curve(s: Array) -> Array:
        angle = np.pi / 4 * (1 + s)
        return radius * np.stack([np.sin(angle), 2 * np.sin(angle / 2) ** 2], 1)

    return curve


def cap_height(radius: float, extent: float) -> float:
    """Depth of the rim of a spherical or flat cap below its pole."""
    return float(spherical(extent, radius)(np.ones(1))[0, 1])


def cap_patch(radius: float, extent: float, depth: float) -> Patch:
    """Meridian of a block with a spherical or flat end."""
    rim = cap_height(radius, extent)
    sides = line((0, 0), (0, depth)), line((extent, rim), (extent, depth))
    return coons(spherical(extent, radius), line((0, depth), (extent, depth)), *sides)


def half_sphere_patches(radius: float) -> tuple[float, float, tuple[Patch, Patch, Patch]]:
    """Meridian of half a sphere: extent and depth of the contact block, and its patch, those round it and below it."""
    extent, depth = radius * math.sqrt(0.5), 0.55 * radius
    on_axis, inner, below = (0.0, depth), (0.5 * radius, 0.6 * radius), (0.55 * radius, radius)
    rim, equator, centre = (extent, radius - extent), (radius, radius), (0.0, radius)
    contact = coons(spherical(extent, radius), line(on_axis, inner), line((0, 0), on_axis), line(rim, inner))
    around = coons(spherical_flank(radius), line(inner, below), line(rim, inner), line(equator, below))
    under = coons(line(on_axis, inner), line(centre, below), line(on_axis, centre), line(inner, below))
    return extent, depth, (contact, around, under)


SECTORS = {"quarter": 1, "half": 2, "full": 4}


def disc(n_layers: int, ring: RingGrading, names: Mapping[str, str | None], element: str) -> tuple[Mesh, Mesh]:
    """Quarter disc times layers in plan coordinates (x, y, layer index): the core and the rings."""
    m, radii = ring.core, ring.radii
    top, bottom, side = names["top"], names["bottom"], names["side"]
    core = lattice((m, m, n_layers), ("sym_x", None, "sym_y", None, top, bottom), element)
    rings = lattice((2 * m, len(radii), n_layers), ("sym_y", "sym_x", None, side, top, bottom), element)
    # the corner of the square core lies on its circle, so that all angles round it are obtuse
    c, d = ring.core_radius, ring.core_radius * np.sqrt(0.5)

    def boundary(j: Array) -> Array:
        """Outer side of the core for ring index j in [0, 2m]: (c, 0) to (d, d) to (0, c)."""
        v = np.minimum(j, 2 * m - j) / m
        x, y = c + (d - c) * v, d * v
        return np.where((j <= m)[:, None], np.stack([x, y], 1), np.stack([y, x], 1))

    def core_plan(index: Array) -> Array:
        u, v = index[:, 0] / m, index[:, 1] / m
        x = c * u + (d - c) * u * v
        y = c * v + (d - c) * u * v
        return np.stack([x, y, index[:, 2]], 1)

    def ring_plan(index: Array) -> Array:
        j, k = index[:, 0], index[:, 1]
        angle = np.pi / 2 * j / (2 * m)
        direction = np.stack([np.cos(angle), np.sin(angle)], 1)
        direction[angle == np.pi / 2] = (0.0, 1.0)
        r = np.interp(k, np.arange(1, len(radii) + 1), radii)
        inner = np.minimum(k, 1.0)[:, None]
        xy = np.where(inner < 1, (1 - inner) * boundary(j) + inner * radii[0] * direction, r[:, None] * direction)
        return np.stack([xy[:, 0], xy[:, 1], index[:, 2]], 1)

    # the ring lattice runs (around, outwards, down): left-handed against (x, y, down), corrected by `right_handed`
    return core.mapped(core_plan), rings.mapped(ring_plan)


def revolved(mesh: Mesh, patch: Patch, s_of: Curve, t_of: Curve) -> Mesh:
    """Points in space from plan coordinates (x, y, layer index), by a meridian map (s, t) -> (rho, z)."""

    def shape(plan: Array) -> Array:
        r = np.hypot(plan[:, 0], plan[:, 1])
        meridian = patch(s_of(r), t_of(plan[:, 2]))
        stretch = np.divide(meridian[:, 0], r, out=np.zeros_like(r), where=r > 0)
        return np.stack([stretch * plan[:, 0], stretch * plan[:, 1], meridian[:, 1]], 1)

    return mesh.mapped(shape)


def right_handed(mesh: Mesh) -> Mesh:
    """Reorder left-handed cells (corner test; the shapes have no folded cells)."""
    x = mesh.points[mesh.cells[:, :8]]
    det = np.einsum(
        "ni,ni->n", np.cross(x[:, [1]] - x[:, [0]], x[:, [3]] - x[:, [0]])[:, 0], x[:, 4:].mean(1) - x[:, :4].mean(1)
    )
    left = det < 0
    if not left.any():
        return mesh
    swap_nodes = [4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19, 20, 21, 22, 23, 25, 24, 26]
    n = mesh.cells.shape[1]
    cells = mesh.cells.copy()
    cells[left] = cells[left][:, swap_nodes[:n]]
    swap_faces = np.array([0, 1, 2, 3, 5, 4])
    boundaries = {
        k: np.stack([f[:, 0], np.where(left[f[:, 0]], swap_faces[f[:, 1]], f[:, 1])], 1)
        for k, f in mesh.boundaries.items()
    }
    return replace(mesh, cells=cells, boundaries=boundaries)


def repeated(quarter: Mesh, sector: str, tolerance: float) -> Mesh:
    """Half (y >= 0) or full body from a quarter model (x, y >= 0), by rotating and joining it."""
    among("sector", sector, SECTORS)
    quarter = right_handed(quarter)
    if sector == "quarter":
        return quarter
    turns = []
    for k in range(SECTORS[sector]):
        cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][k]
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        turned = replace(quarter, points=quarter.points @ turn.T)
        # a quarter turn brings the plane y = 0 to x = 0 and back; only y = 0 is left as a boundary of the half
        names = {"sym_x": "sym_y", "sym_y": "sym_x"} if k % 2 else {}
        turns.append(replace(turned, boundaries={names.get(n, n): f for n, f in turned.boundaries.items()}))
    return merge(turns, tolerance)


@spelled
def block(
    size: Sequence[float],
    divisions: Sequence[int | ArrayLike],
    *,
    element: str = "hex20",
) -> Mesh:
    """Rectangular block with one corner at the origin.

    Parameters
    ----------
    size : three lengths
    divisions : three counts, or increasing positions from 0 to the size
    element : {'hex8', 'hex20', 'hex27'}

    Returns
    -------
    Mesh
        Boundaries `x_min, x_max, y_min, y_max, bottom, top`.

    Examples
    --------
    >>> block((2.0, 1.0, 1.0), (4, 2, 2)).cell_type
    'hex20'
    """
    size, divisions = items("size", size, "three lengths"), items("divisions", divisions, "three counts")
    if len(size) != 3 or len(divisions) != 3:
        raise InputError(f"A block takes three sizes and three divisions; found {size!r} and {divisions!r}.")
    lengths(**{f"size[{i}]": s for i, s in enumerate(size)})
    positions = [division(s, d, "divisions") for s, d in zip(size, divisions, strict=True)]
    mesh = lattice([len(p) - 1 for p in positions], ("x_min", "x_max", "y_min", "y_max", "bottom", "top"), element)
    return mesh.mapped(lambda i: np.stack([interpolated(i[:, k], positions[k]) for k in range(3)], axis=1))


@spelled
def thick_ring(
    inner: float,
    outer: float,
    height: float,
    divisions: tuple[int, int | ArrayLike, int | ArrayLike] = (8, 4, 1),
    *,
    sector: str = "quarter",
    element: str = "hex20",
) -> Mesh:
    """Thick cylinder about the z axis.

    Parameters
    ----------
    inner, outer, height : float
        Radii and height.
    divisions : (around a quarter, through the thickness, along z)
        The last two as counts or as positions (from 0).
    sector : {'quarter', 'half', 'full'}
    element : {'hex8', 'hex20', 'hex27'}

    Returns
    -------
    Mesh
        Boundaries `inner, outer, bottom, top` and the symmetry planes `sym_x` (x = 0) and `sym_y` (y = 0).
    """
    lengths(inner=inner, outer=outer, height=height)
    if outer <= inner:
        raise InputError(f"The outer radius must exceed the inner one; found inner = {inner}, outer = {outer}.")
    divisions = items("divisions", divisions, "three counts")
    if len(divisions) != 3:
        raise InputError(f"A thick ring takes three divisions; found {shown(divisions)}.")
    across = inner + division(outer - inner, divisions[1], "radial division")
    along = division(height, divisions[2], "axial division")
    n = (len(across) - 1, divisions[0], len(along) - 1)
    base = lattice(n, ("inner", "outer", "sym_y", "sym_x", "bottom", "top"), element)

    def shape(index: Array) -> Array:
        r, angle = interpolated(index[:, 0], across), index[:, 1] * (np.pi / 2 / divisions[0])
        return np.stack([r * np.cos(angle), r * np.sin(angle), interpolated(index[:, 2], along)], axis=1)

    return repeated(base.mapped(shape), sector, 1e-9 * outer)


@spelled
def cap(
    radius: float,
    extent: float,
    depth: float,
    *,
    contact_radius: float | None = None,
    level: int | Level = 2,
    sector: str = "full",
    element: str = "hex20",
) -> Mesh:
    """Part of a sphere at its pole: a cylinder of radius `extent` and height `depth` with a spherical top.

    Parameters
    ----------
    radius : float
        Of the sphere; ``math.inf`` for a flat top (then the shape is a cylinder).
    extent, depth : float
        Radius of the cylinder and distance from the pole to the flat base.
    contact_radius : float, optional
        Where the rings are fitted; a tenth of `extent` unless given.
    level : int or Level
        1 (coarse) to 5 (fine), see `grading`.
    sector : {'quarter', 'half', 'full'}
    element : {'hex8', 'hex20', 'hex27'}

    Returns
    -------
    Mesh
        Pole at the origin, body in z >= 0; boundaries `cap, base, side` and the planes `sym_x`, `sym_y`.
    """
    lengths(extent=extent, depth=depth)
    if not number(radius) >= extent:
        raise InputError(f"The radius must be positive and not below the extent; found {shown(radius)} and {extent!r}.")
    if not math.isinf(radius):
        lengths(radius=radius)
    top_depth = cap_height(radius, extent)
    if top_depth >= depth:
        raise InputError(f"The depth {depth:g} must exceed the cap's own height {top_depth:g}.", code="cap-too-deep")
    ring = grading(extent / 10 if contact_radius is None else contact_radius, extent, depth, level)
    patch = cap_patch(radius, extent, depth)
    names = {"top": "cap", "bottom": "base", "side": "side"}
    parts = [
        revolved(part, patch, lambda r: r / extent, lambda i: interpolated(i, ring.depths) / depth)
        for part in disc(len(ring.depths) - 1, ring, names, element)
    ]
    tolerance = 1e-9 * extent
    return repeated(right_handed(merge([right_handed(p) for p in parts], tolerance)), sector, tolerance)


@spelled
def cylinder(
    radius: float,
    height: float,
    *,
    contact_radius: float | None = None,
    level: int | Level = 2,
    sector: str = "full",
    element: str = "hex20",
) -> Mesh:
    """Cylinder about the z axis with its contact end in the plane z = 0 and its body in z >= 0.

    Takes the options of `cap`; boundaries `cap` (z = 0), `base` (z = height), `side`, `sym_x`, `sym_y`.
    """
    return cap(math.inf, radius, height, contact_radius=contact_radius, level=level, sector=sector, element=element)


@spelled
def ball(radius: float, divisions: int = 4, *, element: str = "hex20") -> Mesh:
    """A whole sphere of cells of like size about the origin: a rounded cube of cells and layers of them around it.

    For scenes of many bodies, or contacts at any place; `sphere` has its cells at a pole, for one contact there.

    Parameters
    ----------
    radius : float
    divisions : int
        Cells along each edge of the cube: 4 are 256 cells, 8 are 2048.
    element : {'hex8', 'hex20', 'hex27'}

    Returns
    -------
    Mesh
        Boundaries `surface`, and its sixths `x_min`, `x_max`, `y_min`, `y_max`, `z_min`, `z_max`.

    Examples
    --------
    >>> ball(10.0)
    Mesh(hex20, 256 cells, 1201 points, boundaries: surface, x_min, x_max, y_min, y_max, z_min, z_max)
    """
    lengths(radius=radius)
    n = whole("the divisions", divisions, most=MAX_ALONG)
    layers = max(1, n // 2)

    def rounded(q: Array) -> Array:
        """Smooth map of the cube [-1, 1]^3 to the ball (P. Nowell, Mapping a cube to a sphere, 2005)."""
        s, t = np.roll(q, -1, axis=1) ** 2, np.roll(q, -2, axis=1) ** 2
        return np.asarray(q * np.sqrt(1 - s / 2 - t / 2 + s * t / 3))

    def inner(index: Array) -> Array:
        q = 2 * index / n - 1
        return radius / 4 * (q + rounded(q))

    def around(index: Array, axis: int, side: int) -> Array:
        face = index[:, [0, 1, 1]] * 2 / n - 1
        face[:, 2] = 1.0
        face, share = np.roll(face, axis + 1, axis=1), index[:, 2:] / layers
        face[:, axis] = side
        return (1 - share) * radius / 4 * (face + rounded(face)) + share * radius * rounded(face)

    parts = [lattice((n, n, n), (None,) * 6, element).mapped(inner)]
    for axis, side in itertools.product(range(3), (-1, 1)):
        name = "xyz"[axis] + ("_min" if side < 0 else "_max")
        shell = lattice((n, n, layers), (None,) * 5 + (name,), element)
        shell = right_handed(shell.mapped(partial(around, axis=axis, side=side)))
        parts.append(replace(shell, boundaries={"surface": shell.boundaries[name], **shell.boundaries}))
    return merge(parts, 1e-9 * radius)


@spelled
def half_sphere(
    radius: float,
    *,
    contact_radius: float | None = None,
    level: int | Level = 2,
    sector: str = "full",
    element: str = "hex20",
) -> Mesh:
    """Half of a solid sphere, graded towards the contact point at its pole.

    In the meridian plane it is three blocks: the contact block under the pole (out to 45 degrees on the surface), one
    round it and one below it.

    Parameters
    ----------
    radius : float
    contact_radius : float, optional
        Expected contact radius, where the rings are fitted (a/R down to 1e-4 and below); R/100 unless given.
    level : int or Level
        1 (coarse) to 5 (fine), see `grading`.
    sector : {'quarter', 'half', 'full'}
        How much of it is modelled; the planes of symmetry are the boundaries `sym_x` (x = 0) and `sym_y` (y = 0).
    element : {'hex8', 'hex20', 'hex27'}

    Returns
    -------
    Mesh
        Pole at the origin, body in z >= 0; boundaries `cap` (the surface out to 45 degrees), `flank` (the rest of
        it), `base` (the flat face z = R) and the planes of symmetry.

    Examples
    --------
    >>> half_sphere(250.0, contact_radius=1.8, level=1, sector="quarter").cell_type
    'hex20'
    """
    lengths(radius=radius)
    extent, depth, (contact, around, under) = half_sphere_patches(radius)
    ring = grading(radius / 100 if contact_radius is None else contact_radius, extent, depth, level)
    n_layers, n_outer = len(ring.depths) - 1, 2

    def layer(i: Array) -> Array:
        return interpolated(i, ring.depths) / depth

    def outer(i: Array) -> Array:
        return i / n_outer

    upper = disc(n_layers, ring, {"top": "cap", "bottom": None, "side": None}, element)
    lower = disc(n_outer, ring, {"top": None, "bottom": "base", "side": None}, element)
    parts = [revolved(p, contact, lambda r: r / extent, layer) for p in upper]
    parts += [revolved(p, under, lambda r: r / extent, outer) for p in lower]
    parts.append(_collar(ring, n_layers, n_outer, around, layer, element))
    tolerance = 1e-9 * radius
    return repeated(merge([right_handed(p) for p in parts], tolerance), sector, tolerance)


def _collar(
    ring: RingGrading,
    n_layers: int,
    n_outer: int,
    patch: Patch,
    layer: Curve,
    element: str,
) -> Mesh:
    """Rings outside the contact block: from the 45 degree rim to the equator."""
    names = ("sym_y", "sym_x", None, "base", "flank", None)
    mesh = lattice((2 * ring.core, n_outer, n_layers), names, element)

    def shape(index: Array) -> Array:
        angle = np.pi / 2 * index[:, 0] / (2 * ring.core)
        direction = np.stack([np.cos(angle), np.sin(angle)], 1)
        direction[angle == np.pi / 2] = (0.0, 1.0)
        meridian = patch(index[:, 1] / n_outer, layer(index[:, 2]))
        return np.concatenate([meridian[:, :1] * direction, meridian[:, 1:]], axis=1)

    return mesh.mapped(shape)


@spelled
def quarter_sphere(
    radius: float, *, contact_radius: float | None = None, level: int | Level = 2, element: str = "hex20"
) -> Mesh:
    """A quarter (x, y >= 0) of `half_sphere`, for a scene with two planes of symmetry."""
    return half_sphere(radius, contact_radius=contact_radius, level=level, sector="quarter", element=element)


@spelled
def sphere(
    radius: float,
    *,
    contact_radius: float | None = None,
    level: int | Level = 2,
    sector: str = "full",
    element: str = "hex20",
) -> Mesh:
    """A whole sphere with its graded pole at the origin: `half_sphere` and its mirror image below the equator.

    Boundaries `cap` (round the pole at the origin), `far_cap` (round the opposite pole) and `flank`. With the options
    of `half_sphere` at their defaults these are 15,600 cells; `ball` has 256 of like size.
    """
    upper = half_sphere(radius, contact_radius=contact_radius, level=level, sector=sector, element=element)
    lower = right_handed(upper.mapped(lambda x: np.stack([x[:, 0], x[:, 1], 2 * radius - x[:, 2]], 1)))
    renamed = {("far_cap" if n == "cap" else n): f for n, f in lower.boundaries.items()}
    return merge([upper, replace(lower, boundaries=renamed)], 1e-9 * radius)
