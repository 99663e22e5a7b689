"""Ready-made sections: rectangle, annulus, cap and half disc graded towards the edge of a contact.

Positions are as in `fecontact.shapes`: the contact point is the local origin, the body lies in z >= 0, one mesh line
ends at ``contact_radius`` and the mesh is graded towards it. For a body of revolution x is the radius; for a plane one
the boundary `sym_x` (x = 0) is a plane of symmetry.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import items, texts
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, finite, lengths, number, whole
from fecontact.common.errors import InputError, shown
from fecontact.mesh.grading import Level, RingGrading, grading
from fecontact.mesh.section_mesh import SectionMesh, counter_clockwise, merge_sections
from fecontact.mesh.shapes import (
    MAX_ALONG,
    MAX_CELLS,
    Patch,
    cap_patch,
    division,
    half_sphere_patches,
    interpolated,
)

__all__ = ["annulus", "cap", "half_disc", "merge_sections", "rectangle", "ring"]


def __dir__() -> list[str]:
    """The public names."""
    return __all__


ELEMENTS = {"quad8": 8, "quad9": 9}
#: Cells between the contact block of a half disc and its base.
OUTER = 3


def grid(
    divisions: Sequence[int],
    names: Sequence[str | None],
    shape: Callable[[Array], Array],
    element: str = "quad8",
) -> SectionMesh:
    """Mesh of an index rectangle [0, n1] x [0, n2], mapped by ``shape(indices (n, 2)) -> x, z (n, 2)``.

    Parameters
    ----------
    divisions : two ints
    names : four names or None
        Boundaries at j = 0, i = n1, j = n2, i = 0 (counter-clockwise).
    shape : callable
    element : {'quad8', 'quad9'}
    """
    among("element of a section", element, ELEMENTS)
    n1, n2 = divisions
    if n1 * n2 > MAX_CELLS:
        raise InputError(f"{n1} x {n2} cells are more than {MAX_CELLS:.0e}.")
    number = np.arange((2 * n1 + 1) * (2 * n2 + 1)).reshape(2 * n1 + 1, 2 * n2 + 1)
    places = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)][: ELEMENTS[element]]
    cells = np.stack([number[i : i + 2 * n1 - 1 : 2, j : j + 2 * n2 - 1 : 2].ravel() for i, j in places], axis=1)
    used, cells = np.unique(cells, return_inverse=True)
    points = shape(np.stack(np.divmod(used, 2 * n2 + 1), axis=1) / 2)
    cell = np.arange(n1 * n2).reshape(n1, n2)
    boundaries: dict[str, IntArray] = {}
    for side, (name, along) in enumerate(zip(names, (cell[:, 0], cell[-1], cell[:, -1], cell[0]), strict=True)):
        if name is not None:
            sides = np.stack([along, np.full_like(along, side)], axis=1)
            boundaries[name] = np.concatenate([boundaries[name], sides]) if name in boundaries else sides
    cells = cells.reshape(n1 * n2, -1)
    turned = counter_clockwise(points, cells)
    if turned is not cells:
        boundaries = {name: np.stack([s[:, 0], 3 - s[:, 1]], axis=1) for name, s in boundaries.items()}
    return SectionMesh(points, turned, boundaries)


def rectangle(
    size: Sequence[float],
    divisions: Sequence[int | ArrayLike],
    *,
    element: str = "quad8",
    names: Sequence[str] = ("left", "right", "bottom", "top"),
    start: float = 0.0,
) -> SectionMesh:
    """Rectangle with its lower left corner at x = `start`, z = 0.

    Parameters
    ----------
    size : two lengths
        Along x and z.
    divisions : two counts, or increasing positions from 0 to the size
    element : {'quad8', 'quad9'}
    names : four names
        Of the boundaries at x = start, x = start + size[0], z = 0 and z = size[1].
    start : float

    Returns
    -------
    SectionMesh

    Examples
    --------
    >>> rectangle((1.0, 2.0), (2, [0.0, 0.5, 2.0])).cell_type
    'quad8'
    """
    size, divisions = items("size", size, "two lengths"), items("divisions", divisions, "two counts")
    names = texts("names", names)
    if len(names) != 4:
        raise InputError(f"A rectangle takes four names; found {names!r}.")
    finite("start", start)
    if len(size) != 2 or len(divisions) != 2:
        raise InputError(f"A rectangle takes two sizes and two divisions; found {size!r} and {divisions!r}.")
    lengths(**{f"size[{i}]": s for i, s in enumerate(size)})
    x, z = (division(s, d, "divisions") for s, d in zip(size, divisions, strict=True))
    left, right, bottom, top = names

    def shape(index: Array) -> Array:
        return np.stack([start + interpolated(index[:, 0], x), interpolated(index[:, 1], z)], axis=1)

    return grid((len(x) - 1, len(z) - 1), (bottom, right, top, left), shape, element)


def ring(
    inner: float, outer: float, height: float, divisions: Sequence[int | ArrayLike], *, element: str = "quad8"
) -> SectionMesh:
    """Section of a ring or tube about the z axis: a rectangle from radius `inner` to `outer`, z from 0 to `height`.

    Boundaries `inner, outer, bottom, top`.
    """
    _check_radii(inner, outer)
    names = ("inner", "outer", "bottom", "top")
    return rectangle((outer - inner, height), divisions, element=element, names=names, start=inner)


def annulus(
    inner: float, outer: float, divisions: tuple[int, int | ArrayLike] = (8, 4), *, element: str = "quad8"
) -> SectionMesh:
    """Quarter (x, z >= 0) of a plane ring about the origin.

    Parameters
    ----------
    inner, outer : float
    divisions : (around, through the thickness)
        The second as a count or as positions from 0.

    Returns
    -------
    SectionMesh
        Boundaries `inner, outer` and the planes of symmetry `sym_x` (x = 0) and `sym_z` (z = 0).
    """
    _check_radii(inner, outer)
    divisions = items("divisions", divisions, "two counts")
    if len(divisions) != 2:
        raise InputError(f"An annulus takes two divisions; found {shown(divisions)}.")
    around = whole("the division around", divisions[0], most=MAX_ALONG)
    across = inner + division(outer - inner, divisions[1], "radial division")

    def shape(index: Array) -> Array:
        angle, r = index[:, 1] * (np.pi / 2 / around), interpolated(index[:, 0], across)
        x = np.where(index[:, 1] == around, 0.0, r * np.cos(angle))
        return np.stack([x, r * np.sin(angle)], axis=1)

    return grid((len(across) - 1, around), ("sym_z", "outer", "sym_x", "inner"), shape, element)


def _check_radii(inner: float, outer: float) -> None:
    lengths(inner=inner, outer=outer)
    if outer <= inner:
        raise InputError(f"The outer radius must exceed the inner one; found inner = {inner}, outer = {outer}.")


def _across(graded: RingGrading) -> Array:
    """Positions from the axis outwards: equal cells in the core, then those of the rings."""
    return np.concatenate([np.linspace(0, graded.core_radius, graded.core + 1), graded.radii])


def cap(
    radius: float,
    extent: float,
    depth: float,
    *,
    contact_radius: float,
    level: int | Level = 2,
    element: str = "quad8",
) -> SectionMesh:
    """Half (x >= 0) of a block with a round or flat end at the origin.

    Parameters
    ----------
    radius : float
        Of the end; infinite: flat.
    extent, depth : float
        Largest x and z.
    contact_radius : float
        Expected edge of the contact.
    level : int or Level
        1 (coarse) to 5 (fine).
    element : {'quad8', 'quad9'}

    Returns
    -------
    SectionMesh
        Boundaries `cap`, `base` (z = depth), `side` (x = extent) and `sym_x` (the axis x = 0).
    """
    lengths(extent=extent, depth=depth)
    if not number(radius) > extent:
        raise InputError(f"The end's radius must exceed the extent {extent:g} (or be infinite); found {shown(radius)}.")
    if not math.isinf(radius):
        lengths(radius=radius)
    graded = grading(contact_radius, extent, depth, level)
    across, depths = _across(graded), graded.depths
    patch = cap_patch(radius, extent, depth)

    def shape(index: Array) -> Array:
        return patch(interpolated(index[:, 0], across) / extent, interpolated(index[:, 1], depths) / depth)

    return grid((len(across) - 1, len(depths) - 1), ("cap", "side", "base", "sym_x"), shape, element)


def half_disc(
    radius: float, *, contact_radius: float | None = None, level: int | Level = 2, element: str = "quad8"
) -> SectionMesh:
    """Right half (x >= 0) of the lower half of a disc, graded towards the contact point at the origin.

    As a body of revolution it is the hemisphere `shapes.half_sphere`; as a plane section half of a half cylinder.

    Parameters
    ----------
    radius : float
    contact_radius : float, optional
        Expected edge of the contact; R/100 unless given.
    level : int or Level
        1 (coarse) to 5 (fine).
    element : {'quad8', 'quad9'}

    Returns
    -------
    SectionMesh
        Boundaries `cap` (the arc out to 45 degrees), `flank` (the rest of it), `base` (z = R) and `sym_x` (x = 0).

    Examples
    --------
    >>> sorted(half_disc(250.0, contact_radius=1.8, level=1).boundaries)
    ['base', 'cap', 'flank', 'sym_x']
    """
    lengths(radius=radius)
    extent, depth, (contact, around, under) = half_sphere_patches(radius)
    graded = grading(radius / 100 if contact_radius is None else contact_radius, extent, depth, level)
    across, layers = _across(graded) / extent, graded.depths / depth
    outwards = np.linspace(0, 1, OUTER + 1)
    parts = (
        (contact, across, layers, ("cap", None, None, "sym_x")),
        (under, across, outwards, (None, None, "base", "sym_x")),
        (around, outwards, layers, ("flank", "base", None, None)),
    )

    def made(patch: Patch, s: Array, t: Array, names: tuple[str | None, ...]) -> SectionMesh:
        divisions = (len(s) - 1, len(t) - 1)
        return grid(divisions, names, lambda k: patch(interpolated(k[:, 0], s), interpolated(k[:, 1], t)), element)

    return merge_sections([made(*part) for part in parts], 1e-9 * radius)
