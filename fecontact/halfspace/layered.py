"""Layered half-space: compliance in wave numbers and the resulting influence coefficients.

A pressure cos(k x) on the surface displaces it by C(k) cos(k x). In every layer the displacements U sin(k x) along x
and W cos(k x) into the body are a sum of four fields, two that decay downwards and two that decay upwards,

    (U, W) = (1, 1) e^(-k z)   and   (k z, k z + 3 - 4 nu) e^(-k z),      z -> h - z and W -> -W for the others,

whose factors follow from the conditions at the surface, the interfaces and the base. No exponential grows with k h.

Layered half-space under tangential tractions: compliance in wave numbers and the difference that layers make.

A traction along the wave, q sin(k x), displaces the surface by L q sin(k x) along x and W q cos(k x) into the body; the
fields are those of `layered`. By reciprocity W is also the displacement along x by a unit pressure cos(k x). A traction
across the wave displaces by T along itself: antiplane shear, with the stiffness s k at the top of a layer of depth h on
a base of stiffness s_b k

    s = G (s_b + G tanh(k h))/(G + s_b tanh(k h)),     T = 1/(s k).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
import scipy.special

from fecontact.common.arguments import instance
from fecontact.common.arrays import Array
from fecontact.common.checks import among, positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace import kernels
from fecontact.halfspace.fft import each, strips

#: Wave number times total thickness below which a layer's fields are linearly dependent; the limit is used.
MIN_WAVE = 1e-4

#: Wave number times thickness of the top layer at which the influence of its base is exp(-2 22) = 8e-20.
MAX_WAVE = 22.0

#: Share of the compliance, at all wave numbers of a grid, within which a layer adds the same as one of no thickness.
THIN = 1e-3

#: Distance in thicknesses at which what a layer adds is (1/100)^2 of what is below it, and a next term of that square.
FELT = 100.0

#: Panels by which the first one is halved: stiff layers change what is below them at waves much longer than they are.
LONG_WAVES = 10

#: Mean over a cell of a smooth function by its values in the middles of five, exact for polynomials of degree 5; and
#: the thickness of the top layer, in cells, below which what layers add is integrated by finer rules, at offsets below
#: `NEAR`.
MEAN, STEEP, NEAR = np.array([-17, 308, 5178, 308, -17]) / 5760, 3.0, 6

#: Thickness of the top layer, in cells, from which the stress inside is integrated to a few hundredths of a pressure's
#: jump from cell to cell.
STRESSED = 0.5

#: Distance from an interface, relative to its depth, that counts as rounding of sums of thicknesses.
ON_INTERFACE = 1e-12

#: Signs of u, w, sigma and tau of a field under reversal of z.
MIRROR = np.array([1.0, -1.0, 1.0, -1.0])[:, None]


@compact_repr
@dataclass(frozen=True)
class Layer:
    """A layer of a layered half-space.

    Parameters
    ----------
    material : Material
    thickness : float
    interface : {'bonded', 'frictionless'}
        Interface to the layer or base below.

    Examples
    --------
    >>> Layer(Material(E=10.0, nu=0.4), thickness=2.0).interface
    'bonded'
    """

    material: Material
    thickness: float
    interface: str = "bonded"

    def __post_init__(self) -> None:
        instance("a layer's material", self.material, Material)
        positive("a layer's thickness", self.thickness)
        among("interface of a layer", self.interface, ("bonded", "frictionless"))


def thin_layers(layers: Sequence[Layer], width: float) -> int:
    """Number of layers at the top that are thinner than a width.

    Examples
    --------
    >>> thin_layers([Layer(Material(E=1.0, nu=0.3), h) for h in (0.1, 2.0, 0.1)], 1.0)
    1
    """
    return next((n for n, layer in enumerate(layers) if layer.thickness >= width), len(layers))


def compliance(k: Array, layers: Sequence[Layer], base: Material | None) -> Array:
    """Surface displacement by a unit wave of pressure, times the wave number: k C(k).

    Parameters
    ----------
    k : (n,) array
        Wave numbers (1 / length), not negative.
    layers : sequence of Layer
        Layers from the surface downwards.
    base : Material or None
        The half-space below; None: rigid.

    Returns
    -------
    (n,) array
        k C(k) (length^2 / force); 2/E' of the top layer for short waves, of the base for long ones.

    References
    ----------
    I. N. Sneddon, Fourier Transforms, 1951, section 46; K. L. Johnson, Contact Mechanics, 1985, sections 5.8 and 13.2.

    Examples
    --------
    >>> import numpy as np
    >>> soft = Material(E=1.0, nu=0.0)
    >>> compliance(np.array([0.5, 3.0]), [Layer(soft, 1.0)], soft).round(12).tolist()
    [2.0, 2.0]
    """
    return surface_waves(k, layers, base)[:, 1]


def surface_waves(k: Array, layers: Sequence[Layer], base: Material | None, shear: bool = False) -> Array:
    """Displacements (n_k, 2) of the surface along x and into the body by a unit wave, times k.

    The wave is a pressure cos(k x), or with `shear` a traction sin(k x) along x; displacements are the factors of sin(k
    x) and cos(k x).
    """
    total = sum(layer.thickness for layer in layers)
    waves = np.maximum(k, MIN_WAVE / total)
    top = _fields(waves, layers[0])[0]
    values = np.einsum("kij,kj->ki", top[:, :2], _factors(waves, layers, base, shear)[:, 0:4])
    if base is None:  # the compliance itself has a limit there
        values = values * np.where(k < waves, k / waves, 1.0)[:, None]
    return np.asarray(values)


def _factors(k: Array, layers: Sequence[Layer], base: Material | None, shear: bool = False) -> Array:
    """Factors (n_k, 4 n_layers (+ 2)) of the fields, times k, under a unit wave of pressure, or of shear.

    Conditions on the rows (u, w, sigma/(2 k), tau/(2 k)) at the top and bottom of every layer.
    """
    n = 4 * len(layers) + (2 if base is not None else 0)
    A = np.zeros((len(k), n, n))
    b = np.zeros((len(k), n))
    tops, bottoms = zip(*(_fields(k, layer) for layer in layers), strict=True)
    A[:, 0:2, 0:4] = tops[0][:, 2:4]
    b[:, int(shear)] = -0.5  # sigma or tau = -1 is -1/(2 k), scaled by k
    row = 2
    for j, layer in enumerate(layers):
        here, last = slice(4 * j, 4 * j + 4), j == len(layers) - 1
        below = None if last and base is None else slice(4 * j + 4, 4 * j + 6 if last else 4 * j + 8)
        under = _half_space(k, base) if last and base is not None else None if last else tops[j + 1]
        bonded = layer.interface == "bonded"
        if below is None or under is None:
            A[:, row : row + 2, here] = bottoms[j][:, 0:2] if bonded else bottoms[j][:, [1, 3]]
            row += 2
        elif bonded:
            A[:, row : row + 4, here], A[:, row : row + 4, below] = bottoms[j], -under
            row += 4
        else:
            A[:, row : row + 2, here], A[:, row : row + 2, below] = bottoms[j][:, 1:3], -under[:, 1:3]
            A[:, row + 2, here], A[:, row + 3, below] = bottoms[j][:, 3], under[:, 3]
            row += 4
    return np.asarray(np.linalg.solve(A, b[..., None])[..., 0])


def wave_stress(k: Array, depth: float, layers: Sequence[Layer], base: Material | None) -> Array:
    """Stresses at a depth under a unit wave of pressure on the surface.

    Parameters
    ----------
    k : (n,) array
        Wave numbers, positive.
    depth : float
        Depth below the surface; on an interface the upper side counts.
    layers : sequence of Layer
    base : Material or None

    Returns
    -------
    (n, 4) array
        Normal stresses along the wave, across it and normal to the surface (factors of cos(k x)), and shear of the
        first and third axis (of sin(k x)); tension positive, z into the body.

    Notes
    -----
    Plane strain along the wave: sigma_xx = E' k U + nu/(1 - nu) sigma_zz and sigma_yy = nu (sigma_xx + sigma_zz).

    Examples
    --------
    >>> import numpy as np
    >>> soft = Material(E=1.0, nu=0.25)
    >>> under = wave_stress(np.array([2.0]), 1.5, [Layer(soft, 1.0)], soft)  # -(1 + k z) e^(-k z) along z
    >>> bool(np.isclose(under[0, 2], -4 * np.exp(-3.0)))
    True
    """
    waves = np.maximum(k, MIN_WAVE / sum(layer.thickness for layer in layers))
    factors = _factors(waves, layers, base)
    above = 0.0
    for j, layer in enumerate(layers):
        if depth <= (above + layer.thickness) * (1 + ON_INTERFACE):
            down = _decaying(waves, waves * (depth - above), layer.material)
            up = MIRROR * _decaying(waves, waves * (above + layer.thickness - depth), layer.material)
            rows, share = np.concatenate([down, up], axis=2), factors[:, 4 * j : 4 * j + 4]
            material = layer.material
            break
        above += layer.thickness
    else:
        if base is None:
            raise InputError(f"There is no stress at depth {depth:g}: the base below the layers, {above:g}, is rigid.")
        rows, share, material = _decaying(waves, waves * (depth - above), base), factors[:, -2:], base
    u, _, sigma, tau = np.einsum("kij,kj->ik", rows, share)
    nu = material.nu
    normal, shear = 2 * sigma, 2 * tau
    along = material.plane_strain_modulus * u + nu / (1 - nu) * normal
    return np.stack([along, nu * (along + normal), normal, shear], axis=1)


def _fields(k: Array, layer: Layer) -> tuple[Array, Array]:
    """Rows (n_k, 4, 4) of the four fields of a layer at its top and at its bottom."""
    h = layer.thickness
    down, up = _decaying(k, 0 * k, layer.material), _decaying(k, k * h, layer.material)
    return np.concatenate([down, MIRROR * up], axis=2), np.concatenate([up, MIRROR * down], axis=2)


def _half_space(k: Array, base: Material) -> Array:
    """Rows (n_k, 4, 2) of the two fields that decay downwards at the top of a half-space."""
    return _decaying(k, 0 * k, base)


def _decaying(k: Array, kz: Array, material: Material) -> Array:
    """Rows u, w, sigma/(2 k), tau/(2 k) of the two fields that decay with z: (n_k, 4, 2)."""
    nu, G = material.nu, material.shear_modulus
    e = np.exp(-kz)
    out = np.empty((len(k), 4, 2))
    out[:, 0, 0] = out[:, 1, 0] = e
    out[:, 2, 0] = out[:, 3, 0] = -G * e
    out[:, 0, 1], out[:, 1, 1] = kz * e, (kz + 3 - 4 * nu) * e
    out[:, 2, 1] = -G * (2 - 2 * nu + kz) * e
    out[:, 3, 1] = -G * (1 - 2 * nu + kz) * e
    return out


def table(
    shape: tuple[int, int], cell: tuple[float, float], layers: Sequence[Layer], base: Material | None,
    reach: float = 0.0,
) -> Array:  # fmt: skip
    """Mid-cell displacements by unit pressure on one cell.

    Love's table of a half-space of the top layer's material plus the smooth difference due to the layers: the integral
    of (k C(k) - 2/E') J_0(k r)/(2 pi) over k, tabulated in r and averaged over the cell.

    Parameters
    ----------
    shape : (int, int)
        Number of offsets along x and y.
    cell : (float, float)
        Sides of a cell.
    layers : sequence of Layer
    base : Material or None
    reach : float
        Distance up to which what layers add is tabulated, at least to the last offset: once for grids of one reach.

    Returns
    -------
    (nx, ny) array
        Displacement (length^3 / force) at offset (i, j) cells.

    Examples
    --------
    >>> import numpy as np
    >>> soft = Material(E=1.0, nu=0.0)
    >>> same = table((3, 3), (1.0, 1.0), [Layer(soft, 1.0)], soft)
    >>> bool(np.allclose(same, kernels.love((3, 3), (1.0, 1.0))))
    True
    """
    total, local = np.zeros(shape), 0.0
    while layers and (thin := _of_thin_layer(layers, base, min(cell))) is not None:
        local, layers = local + thin, layers[1:]
    top = layers[0].material if layers else base
    if top is not None:
        total += kernels.love(shape, cell) / top.plane_strain_modulus
    if layers:
        x, y = (np.arange(n + len(MEAN) // 2) * side for n, side in zip(shape, cell, strict=True))
        difference = point_difference(max(reach, math.hypot(x[-1], y[-1])), layers, base)
        smooth = np.empty((len(x), len(y)))

        def fill(strip: slice) -> None:
            smooth[strip] = difference(np.sqrt(x[strip, None] ** 2 + y**2))

        each(fill, strips(*smooth.shape))
        for axis in (0, 1):
            smooth = scipy.ndimage.correlate1d(smooth, MEAN, axis, mode="mirror")
        smooth = smooth[: shape[0], : shape[1]]
        if layers[0].thickness < STEEP * max(cell):  # too steep for that rule nearby
            near = (min(NEAR, shape[0]), min(NEAR, shape[1]))
            smooth[: near[0], : near[1]] = _near_means(difference, near, cell, layers[0].thickness)
        total += cell[0] * cell[1] * smooth
    total[0, 0] += local
    return total


def _of_thin_layer(layers: Sequence[Layer], base: Material | None, cell: float) -> float | None:
    """Displacement by unit pressure that the top layer adds where the pressure is; None if it is not so thin.

    As its thickness goes to zero it adds the same at all wave numbers: no more than its own cell is displaced.
    """
    total = sum(layer.thickness for layer in layers)
    k = np.maximum(2 * math.pi / cell * np.geomspace(1e-3, 1.0, 16), 2 * MIN_WAVE / total)
    whole, added = compliance(k, layers, base), _added(k, layers, base)
    found = float(added[-4] / k[-4])  # at a period of four cells
    return found if (np.abs(added - found * k) <= THIN * np.abs(whole)).all() else None


def _added(k: Array, layers: Sequence[Layer], base: Material | None) -> Array:
    """Compliance of layers, times the wave number, less that without the top one."""
    rest = compliance(k, layers[1:], base) if layers[1:] else 2 / base.plane_strain_modulus if base else 0.0
    return compliance(k, layers, base) - rest


def _near_means(
    difference: Callable[[Array], Array], shape: tuple[int, int], cell: tuple[float, float], finest: float
) -> Array:
    """Means over the cells at small offsets of a function of distance, which varies over a length at the origin."""
    axes = []
    nodes, weights = np.polynomial.legendre.leggauss(6)
    for n, side in zip(shape, cell, strict=True):
        halvings = max(0, math.ceil(math.log2(side / finest)))
        edges = np.concatenate([[0.0], side * 2.0 ** np.arange(-halvings - 1, 0), side * np.arange(1.5, n)])
        widths = np.diff(edges)
        share = np.where(edges[1:] <= side / 2, 2.0, 1.0) / side  # the cell at the origin by its half
        places = (edges[:-1, None] + widths[:, None] * (nodes + 1) / 2).ravel()
        starts = 6 * np.concatenate([[0], np.arange(halvings + 1, halvings + n)])
        axes.append((places, ((share * widths)[:, None] * weights / 2).ravel(), starts))
    (x, wx, first), (y, wy, second) = axes
    values = difference(np.hypot(x[:, None], y[None, :])) * wx[:, None] * wy[None, :]
    return np.asarray(np.add.reduceat(np.add.reduceat(values, first, axis=0), second, axis=1))


def point_difference(reach: float, layers: Sequence[Layer], base: Material | None) -> Callable[[Array], Array]:
    """Point-force displacement less that of the top layer's half-space, as a function of distances up to a reach.

    Examples
    --------
    >>> import numpy as np
    >>> soft = Material(E=1.0, nu=0.0)
    >>> bool((point_difference(2.0, [Layer(soft, 1.0)], None)(np.array([0.0, 2.0])) < 0).all())
    True
    """
    parts = [_added_by_top(reach, tuple(layers[j:]), base) for j in range(len(layers))]
    return lambda r: np.asarray(sum(part(r) for part in parts))


def hankel_rule(reach: float, length: float, deepest: float, long_waves: int = 0) -> tuple[Array, Array]:
    """Wave numbers (n,) and weights of integrals dk/(2 pi) up to a distance, for fields that vary over a length.

    Up to the wave number deepest/length, by Gauss's rule on panels, the first one halved `long_waves` times.
    """
    panels = 8 + math.ceil(deepest * reach / length / 20)  # a panel of 24 points integrates a phase of 20
    nodes, weights = np.polynomial.legendre.leggauss(24)
    edges = deepest / length * np.linspace(0.0, 1.0, panels + 1)
    edges = np.concatenate([[0.0], edges[1] * 2.0 ** np.arange(-long_waves, 0), edges[1:]])
    width = np.diff(edges)[:, None] / 2
    k = ((edges[:-1] + edges[1:])[:, None] / 2 + width * nodes).ravel()
    return k, (width * weights).ravel() / (2 * math.pi)


def _spaced(reach: float, density: int) -> Array:
    """Places asinh(r/length) of tables up to a distance, over the length."""
    return np.linspace(0.0, math.asinh(reach), max(2 * density // 5, math.ceil(density * math.asinh(reach))))


@dataclass(frozen=True, eq=False)
class Hankel:
    """Hankel transforms of orders 0, 1 and 2 of spectra with a largest wave number, tabulated in the distance.

    Attributes
    ----------
    k, weights : (n,) arrays
        See `hankel_rule`.
    length : float
        Length over which fields vary.
    s : (m,) array
        Places asinh(r/length).
    bessel : (3, m, n) array
    """

    k: Array
    weights: Array
    length: float
    s: Array
    bessel: Array

    @classmethod
    def up_to(cls, reach: float, length: float, deepest: float) -> Hankel:
        """Table for distances up to `reach` and fields that vary over `length`."""
        k, weights = hankel_rule(reach, length, deepest)
        s = _spaced(reach / length, 60)
        x = np.outer(length * np.sinh(s), k)
        j0, j1 = scipy.special.j0(x), scipy.special.j1(x)
        j2 = np.where(x > 1e-3, 2 * j1 / np.where(x > 0, x, 1.0) - j0, x**2 / 8)
        return cls(k, weights, length, s, np.stack([j0, j1, j2]))

    def of(self, *spectra: tuple[int, Array]) -> Callable[[Array, Array], list[Array]]:
        """Transforms of orders of spectra (n,) as functions of x and y; then the cosine and sine of the direction."""
        table = np.stack([self.bessel[order] @ (self.weights * spectrum) for order, spectrum in spectra], axis=1)
        spline = scipy.interpolate.CubicSpline(self.s, table)

        def at(x: Array, y: Array) -> list[Array]:
            r = np.hypot(x, y)
            safe = np.where(r > 0, r, 1.0)
            return [*np.moveaxis(spline(np.arcsinh(r / self.length)), -1, 0), x / safe, y / safe]

        return at


@lru_cache(16)
def _added_by_top(reach: float, layers: tuple[Layer, ...], base: Material | None) -> Callable[[Array], Array]:
    """Point-force displacement that the top layer adds to those below, less that of its half-space to theirs.

    Tabulated as far as the layer is felt, beyond which what it adds falls as the distance cubed.
    """
    h, top = layers[0].thickness, layers[0].material
    below = layers[1].material if layers[1:] else base  # None: rigid
    less = 2 / top.plane_strain_modulus - (2 / below.plane_strain_modulus if below else 0.0)
    stiffer = top.plane_strain_modulus / below.plane_strain_modulus if below else 0.0
    softer = (top.lame / top.shear_modulus + 2) ** 0.5  # resists volume more than shear: felt farther
    far = min(reach, FELT * h * max(1.0, stiffer ** (1 / 3), softer / 2))
    k, weights = hankel_rule(far, h, MAX_WAVE, LONG_WAVES)
    spectrum = weights * (_added(k, layers, base) - less)
    s = _spaced(far / h, 40)
    values = np.array([spectrum @ scipy.special.j0(k * r) for r in h * np.sinh(s)])
    spline = scipy.interpolate.CubicSpline(s, values)
    last = (values[-1] + less / (2 * math.pi * far)) * far**3

    def at(r: Array) -> Array:
        out, near = np.empty(r.shape), r <= far
        out[near] = spline(np.arcsinh(r[near] / h))
        inverse = 1 / r[~near]
        out[~near] = inverse * (last * inverse * inverse - less / (2 * math.pi))
        return out

    return at


def symbol(kx: Array, ky: Array, layers: Sequence[Layer], base: Material | None) -> Array:
    """Displacement by a unit wave of pressure, C(k), for periodic surfaces.

    Parameters
    ----------
    kx, ky : arrays that broadcast together
    layers : sequence of Layer
    base : Material or None

    Returns
    -------
    array
        C(|k|). At k = 0 it is zero on an elastic base and the compliance of the stack on a rigid one.

    Examples
    --------
    >>> import numpy as np
    >>> stack = [Layer(Material(E=2.0, nu=0.0), 4.0)]
    >>> symbol(np.zeros(1), np.zeros(1), stack, None).round(6).tolist()
    [2.0]
    """
    k = np.hypot(kx, ky)
    total = sum(layer.thickness for layer in layers)
    s = np.linspace(0.0, math.asinh(float(k.max()) * total) + 1e-9, 4000)
    spline = scipy.interpolate.CubicSpline(s, compliance(np.sinh(s) / total, layers, base))
    mean = 0.0 if base is not None else _stack(layers)
    return np.where(k > 0, spline(np.arcsinh(k * total)) / np.where(k > 0, k, 1.0), mean)


def _stack(layers: Sequence[Layer]) -> float:
    """Compliance under uniform pressure, without strain along the surface."""
    constrained = [m.lame + 2 * m.shear_modulus for m in (layer.material for layer in layers)]
    return sum(layer.thickness / c for layer, c in zip(layers, constrained, strict=True))


def check_interfaces(layers: Sequence[Layer]) -> None:
    """Refuse layers that would slide off under a tangential force.

    Raises
    ------
    InputError
    """
    if any(layer.interface == "frictionless" for layer in layers):
        raise InputError("With friction, layers are bonded: one on a frictionless interface slides off as a whole.")


def shear_compliance(k: Array, layers: Sequence[Layer], base: Material | None) -> Array:
    """Compliances of the surface to tangential tractions, times the wave number: k L, k T and k W.

    Parameters
    ----------
    k : (n,) array
        Wave numbers (1 / length), positive.
    layers : sequence of Layer
        Bonded layers from the surface downwards.
    base : Material or None
        The half-space below; None: rigid.

    Returns
    -------
    (n, 3) array

    References
    ----------
    As of `layered.compliance`; K. L. Johnson, Contact Mechanics, 1985, section 2.5.

    Examples
    --------
    A half-space: (1 - nu)/G, 1/G and -(1 - 2 nu)/(2 G)

    >>> import numpy as np
    >>> soft = Material(E=2.5, nu=0.25)  # G = 1
    >>> shear_compliance(np.array([0.5, 3.0]), [Layer(soft, 1.0)], soft).round(12).tolist()
    [[0.75, 1.0, -0.25], [0.75, 1.0, -0.25]]
    """
    along = surface_waves(k, layers, base, shear=True)
    s = np.full(len(k), np.inf if base is None else base.shear_modulus)
    for layer in reversed(layers):
        G, t = layer.material.shear_modulus, np.tanh(k * layer.thickness)
        rigid = np.isinf(s)
        below = np.where(rigid, 0.0, s)
        s = np.where(rigid, G / t, G * (below + G * t) / (G + below * t))
    return np.stack([along[:, 0], 1 / s, along[:, 1]], axis=1)


def half_space(material: Material) -> Array:
    """The same (3,) for a homogeneous half-space, at all wave numbers."""
    nu, G = material.nu, material.shear_modulus
    return np.array([(1 - nu) / G, 1 / G, -(1 - 2 * nu) / (2 * G)])


def waves_difference(k: Array, layers: Sequence[Layer], base: Material | None) -> Array:
    """L, T and W (3, ...) at wave numbers (...), less those of the top layer's half-space; zero at k = 0."""
    total = sum(layer.thickness for layer in layers)
    least = float(k[k > 0].min())
    s = np.linspace(math.asinh(least * total), math.asinh(float(k.max()) * total) + 1e-9, 2000)
    waves = np.sinh(s) / total
    table = (shear_compliance(waves, layers, base) - half_space(layers[0].material)).T / waves
    out = scipy.interpolate.CubicSpline(s, table, axis=1)(np.arcsinh(np.maximum(k, least) * total))
    return np.asarray(np.where(k > 0, out, 0.0))


def tangential_difference(
    reach: float, layers: Sequence[Layer], base: Material | None
) -> Callable[[Array, Array], tuple[Array, Array, Array, Array, Array]]:
    """Displacements by a unit tangential force, less those of the top layer's half-space, up to a distance `reach`.

    Returns
    -------
    function of x and y
        u_x by Q_x, u_y by Q_y, u_x by Q_y, and the normal displacements by Q_x and by Q_y: Hankel transforms of orders
        0 and 2 of (L + T)/2 and (L - T)/2, and of order 1 of W.
    """
    h = layers[0].thickness
    waves = Hankel.up_to(reach, h, MAX_WAVE)
    L, T, W = (shear_compliance(waves.k, layers, base) - half_space(layers[0].material)).T
    transforms = waves.of((0, (L + T) / 2), (2, (T - L) / 2), (1, -W))

    def at(x: Array, y: Array) -> tuple[Array, Array, Array, Array, Array]:
        mean, turning, normal, c, s = transforms(x, y)
        turned = turning * (c**2 - s**2)
        return mean + turned, mean - turned, 2 * turning * c * s, normal * c, normal * s

    return at
