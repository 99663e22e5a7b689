"""Ready-made bodies: block, cylinder, thick ring, and spheres graded towards the contact point.

All sizes are lengths in the user's unit. Round shapes are **ring meshes**: a square core on the axis (no collapsed edge
inside a contact), then rings whose edges are circles. With ``contact_radius=a`` one ring lies at r = a exactly; the
rings narrow towards it from inside and widen from it outwards, because the pressure falls to zero there as a square
root: an element edge along it reduces the error more than refinement. Away from the contact widths grow by `growth` per
ring and per layer. The pole of a sphere is the local origin and its body lies in z >= 0, so that the sagitta
r^2 / (R + sqrt(R^2 - r^2)) is accurate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import items, known_options
from fecontact.common.arrays import Array
from fecontact.common.checks import lengths, number
from fecontact.common.errors import InputError, shown
from fecontact.mesh.extrude import extrude as extrude
from fecontact.mesh.grading import LEVELS as LEVELS
from fecontact.mesh.grading import Level as Level
from fecontact.mesh.grading import RingGrading as RingGrading
from fecontact.mesh.grading import as_level as as_level
from fecontact.mesh.grading import geometric as geometric
from fecontact.mesh.grading import grading as grading
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.mesh import merge as merge
from fecontact.mesh.patches import Curve, beyond_45_degrees, coons, line, spherical
from fecontact.mesh.patches import sagitta as sagitta
from fecontact.mesh.ring_mesh import SECTORS as SECTORS
from fecontact.mesh.ring_mesh import disc, repeated, revolved, right_handed
from fecontact.mesh.structured import division, interpolated
from fecontact.mesh.structured import lattice as lattice
from fecontact.mesh.tet_to_hex import divided as divided


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
    top_depth = 0.0 if math.isinf(radius) else float(sagitta(np.array(extent), radius))
    if top_depth >= depth:
        raise InputError(f"The depth {depth:g} must exceed the cap's own height {top_depth:g}.")
    ring = grading(extent / 10 if contact_radius is None else contact_radius, extent, depth, level)

    top = spherical(extent, radius)
    patch = coons(
        top, line((0, depth), (extent, depth)), line((0, 0), (0, depth)), line((extent, top_depth), (extent, depth))
    )
    names = {"top": "cap", "bottom": "base", "side": "side"}
    parts = [
        revolved(part, patch, lambda r: r / extent, lambda i: interpolated(i, ring.depths) / depth)
        for part in disc(len(ring.depths) - 1, ring, names, element)
    ]
    tolerance = 1e-9 * extent
    return repeated(right_handed(merge([right_handed(p) for p in parts], tolerance)), sector, tolerance)


def cylinder(radius: float, height: float, **options: object) -> Mesh:
    """Cylinder about the z axis with its contact end in the plane z = 0 and its body in z >= 0.

    Takes the options of `cap`; boundaries `cap` (z = 0), `base` (z = height), `side`, `sym_x`, `sym_y`.
    """
    known_options(cap, options)
    return cap(math.inf, radius, height, **options)  # type: ignore[arg-type]


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
    extent, depth = radius * math.sqrt(0.5), 0.55 * radius
    ring = grading(radius / 100 if contact_radius is None else contact_radius, extent, depth, level)
    n_layers, n_outer = len(ring.depths) - 1, 2
    on_axis, inner, below = (0.0, depth), (0.5 * radius, 0.6 * radius), (0.55 * radius, radius)
    rim, equator, centre = (extent, radius - extent), (radius, radius), (0.0, radius)

    top = spherical(extent, radius)
    flank = beyond_45_degrees(radius)
    contact = coons(top, line(on_axis, inner), line((0, 0), on_axis), line(rim, inner))
    around = coons(flank, line(inner, below), line(rim, inner), line(equator, below))
    under = coons(line(on_axis, inner), line(centre, below), line(on_axis, centre), line(inner, below))

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
    patch: Callable[[Array, Array], Array],
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


def quarter_sphere(radius: float, **options: object) -> Mesh:
    """A quarter (x, y >= 0) of `half_sphere`, for a scene with two planes of symmetry."""
    known_options(half_sphere, options)
    return half_sphere(radius, **{**options, "sector": "quarter"})  # type: ignore[arg-type]


def sphere(radius: float, **options: object) -> Mesh:
    """A whole sphere with its graded pole at the origin: `half_sphere` and its mirror image below the equator.

    Boundaries `cap` (round the pole at the origin), `far_cap` (round the opposite pole) and `flank`.
    """
    known_options(half_sphere, options)
    upper = half_sphere(radius, **options)  # type: ignore[arg-type]
    lower = right_handed(upper.mapped(lambda x: np.stack([x[:, 0], x[:, 1], 2 * radius - x[:, 2]], 1)))
    renamed = {("far_cap" if n == "cap" else n): f for n, f in lower.boundaries.items()}
    return merge([upper, replace(lower, boundaries=renamed)], 1e-9 * radius)
