"""Grading of contact meshes: element widths that decrease towards the edge of the contact and grow away from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize

from fecontact.common.arrays import Array
from fecontact.common.checks import lengths, share, whole
from fecontact.common.errors import InputError, shown

#: Cells through the depth of a thin layer, at all levels.
MIN_LAYERS = 4
#: Cells along a line of a graded mesh, and their least width over the size of the block; points nearer than 1e-9 merge.
MAX_CELLS, NARROWEST = 1000, 1e-8
#: Width of cells in a thin layer, times their number along the core, over sqrt(a b / 2).
IN_THIN_LAYER = 0.4


def geometric(first: float, growth: float, total: float, widest: float = np.inf) -> Array:
    """Positions 0 ... total of intervals that begin at `first` and grow by `growth`; the last one takes up the rest.

    None but the last is wider than `widest`. Widths are not scaled to fit, so two bodies of different size graded from
    the same point match near it.

    Examples
    --------
    >>> geometric(1.0, 2.0, 7.5).tolist()
    [0.0, 1.0, 3.0, 7.5]
    """
    positions, step = [0.0], first
    while positions[-1] + 1.5 * step < total:
        if len(positions) > MAX_CELLS:
            raise InputError(f"More than {MAX_CELLS} cells would be needed between {first:g} and {total:g}; coarsen.")
        positions.append(positions[-1] + step)
        step = min(step * growth, widest)
    return np.array([*positions, total])


@dataclass(frozen=True)
class RingGrading:
    """Radii of the rings and depths of the layers of a ring mesh.

    Attributes
    ----------
    core : int
        Elements along a side of the square core (per quarter); every ring has twice as many.
    core_radius : float
        Half-diagonal of the core; the first ring lies between it and ``radii[0]``.
    radii : (n_rings,) array
        Outer radius of each ring, increasing, within the contact block.
    depths : (n_layers + 1,) array
        From 0 to the depth of the contact block.
    """

    core: int
    core_radius: float
    radii: Array
    depths: Array


@dataclass(frozen=True)
class Level:
    """Fineness of a contact mesh.

    Attributes
    ----------
    core : int
        Elements along a side of the square core (per quarter).
    rings : int
        Rings inside the contact radius.
    edge : float
        Width of the last of these, over the contact radius.
    layer : float
        Thickness of the first layer, over the contact radius.
    growth : float
        Ratio of neighbouring widths away from the contact.
    """

    core: int
    rings: int
    edge: float
    layer: float
    growth: float = 1.8

    def __post_init__(self) -> None:
        whole("the core of a Level", self.core, most=MAX_CELLS)
        whole("the number of rings of a Level", self.rings, most=MAX_CELLS)
        share("the edge of a Level", self.edge)
        lengths(layer=self.layer, growth=self.growth)
        if self.growth < 1:
            raise InputError(f"The growth of a Level must be at least 1; found {self.growth!r}.")


#: Chosen by measurement on Hertz contact: pressure error 1.0, 0.5, 0.3, 0.23 and 0.19 percent (docs/accuracy.py). The
#: pressure's square root at the edge varies as fast downwards as outwards: the first layer is one and a half to two and
#: a half times as thick as the last ring inside is wide.
LEVELS = {
    1: Level(core=2, rings=4, edge=0.04, layer=0.06),
    2: Level(core=3, rings=6, edge=0.02, layer=0.035),
    3: Level(core=4, rings=7, edge=0.01, layer=0.02),
    4: Level(core=5, rings=8, edge=0.006, layer=0.012),
    5: Level(core=6, rings=9, edge=0.004, layer=0.01),
}


def as_level(level: int | Level) -> Level:
    """The `Level` of a number; a `Level` is returned unchanged.

    Raises
    ------
    InputError
        If the number is not 1 ... 5.
    """
    if isinstance(level, Level):
        return level
    if not (isinstance(level, int | np.integer) and level in LEVELS):
        raise InputError(f"The level must be 1 (coarse) to 5 (fine) or a Level; found {shown(level)}.", code="no-level")
    return LEVELS[level]


def grading(contact_radius: float, extent: float, depth: float, level: int | Level = 2) -> RingGrading:
    """Ring mesh fitted to a contact radius.

    Inside the contact radius the rings narrow towards it in geometric progression; outside they widen from there by
    ``growth``, as do the layers with depth. Under a contact as wide as the body is deep (a layer on a hard base) the
    pressure also varies with the depth b: the layers are equal there, and no width inside the contact exceeds 0.4 /
    ``core`` times sqrt(a b / 2) or a quarter of b. Between a/b = 1/2 and 1 there is a transition.

    Parameters
    ----------
    contact_radius, extent, depth : float
        Expected contact radius and size of the contact block; its depth is the thickness of the layer.
    level : int or Level
        1 (coarse) to 5 (fine), or a `Level`.

    Raises
    ------
    InputError
        If the contact does not fit in the block.
    """
    lengths(contact_radius=contact_radius, extent=extent, depth=depth)
    if contact_radius >= extent:
        raise InputError(
            f"The contact radius {contact_radius:g} does not fit in the contact block of radius {extent:g}; "
            "give a smaller contact radius or a larger body.",
            code="contact-radius-too-large",
        )
    cut = as_level(level)
    least = contact_radius * min(cut.edge, cut.layer)
    if least < NARROWEST * max(extent, depth):
        raise InputError(
            f"The contact radius {contact_radius:g} is too small for a block of {extent:g} x {depth:g}: the narrowest "
            f"cells, {least:.3g} wide, would merge. Mesh a smaller part of the body, or give a larger contact radius."
        )
    thin = float(np.clip(2 * contact_radius / depth - 1, 0, 1))
    widest = np.inf
    if thin:
        width = IN_THIN_LAYER / cut.core * np.sqrt(contact_radius * depth / 2)
        widest = depth / np.ceil(max(depth / width, MIN_LAYERS) * (1 - 1e-12)) / thin
    inside = contact_radius * _towards_edge(cut.core, cut.rings, cut.edge)
    if inside[0] > cut.core * widest:
        inside = np.concatenate([[cut.core * widest], inside])
    inside = _cut(inside, widest)
    outside = contact_radius + geometric(cut.edge * contact_radius, cut.growth, extent - contact_radius)[1:]
    first = min(cut.layer * contact_radius, widest)
    if thin:
        first = first ** (1 - thin) * widest**thin
    depths = geometric(first, cut.growth ** (1 - thin), depth, widest)
    return RingGrading(cut.core, float(inside[0]), np.concatenate([inside[1:], outside]), depths)


def _cut(positions: Array, widest: float) -> Array:
    """Positions, with intervals wider than `widest` divided into equal ones."""
    count = np.maximum(np.ceil(np.diff(positions) / widest * (1 - 1e-12)), 1).astype(int)
    return np.interp(np.arange(count.sum() + 1), np.concatenate([[0], np.cumsum(count)]), positions)


def _towards_edge(core: int, rings: int, edge: float) -> Array:
    """Radii from the core's to 1: widths in geometric progression that end with `edge`, the core's cells the next."""

    def radius_of_core(ratio: float) -> float:
        return 1.0 - edge * (ratio ** np.arange(rings)).sum()

    most = min(1e3, 10.0 ** (300 / rings))  # its power is still a number
    ratio = scipy.optimize.brentq(lambda q: radius_of_core(q) - core * edge * q**rings, 1e-3, most)
    widths = edge * ratio ** np.arange(rings)[::-1]
    return np.concatenate([radius_of_core(ratio) + np.concatenate([[0.0], np.cumsum(widths)[:-1]]), [1.0]])
