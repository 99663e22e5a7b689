"""Layered half-space under tangential tractions: compliance in wave numbers and the difference that layers make.

A traction along the wave, q sin(k x), displaces the surface by L q sin(k x) along x and W q cos(k x) into the body; the
fields are those of `layered`. By reciprocity W is also the displacement along x by a unit pressure cos(k x). A traction
across the wave displaces by T along itself: antiplane shear, with the stiffness s k at the top of a layer of depth h on
a base of stiffness s_b k

    s = G (s_b + G tanh(k h))/(G + s_b tanh(k h)),     T = 1/(s k).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import scipy.interpolate
import scipy.special

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.halfspace.layered import LARGEST_WAVE, Layer, surface_waves


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


def point_difference(
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
    panels = 8 + math.ceil(LARGEST_WAVE * reach / h / 20)  # a panel of 24 points integrates a phase of 20
    nodes, weights = np.polynomial.legendre.leggauss(24)
    edges = LARGEST_WAVE / h * np.linspace(0.0, 1.0, panels + 1)
    width = np.diff(edges)[:, None] / 2
    k = ((edges[:-1] + edges[1:])[:, None] / 2 + width * nodes).ravel()
    L, T, W = ((width * weights).ravel()[:, None] * (
        shear_compliance(k, layers, base) - half_space(layers[0].material)
    ) / (2 * math.pi)).T  # fmt: skip
    s = np.linspace(0.0, math.asinh(reach / h), max(24, math.ceil(60 * math.asinh(reach / h))))
    x = np.outer(h * np.sinh(s), k)
    order2 = scipy.special.jv(2, x)
    table = np.stack([scipy.special.j0(x) @ ((L + T) / 2), -order2 @ ((L - T) / 2), -scipy.special.j1(x) @ W], axis=1)
    spline = scipy.interpolate.CubicSpline(s, table)

    def at(x: Array, y: Array) -> tuple[Array, Array, Array, Array, Array]:
        r = np.hypot(x, y)
        mean, turning, normal = np.moveaxis(spline(np.arcsinh(r / h)), -1, 0)
        safe = np.where(r > 0, r, 1.0)
        c, s = x / safe, y / safe
        turned = turning * (c**2 - s**2)
        return mean + turned, mean - turned, 2 * turning * c * s, normal * c, normal * s

    return at
