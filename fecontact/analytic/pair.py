"""Contact modulus and relative radius of a pair of bodies."""

from __future__ import annotations

import math

import numpy as np

from fecontact.common.arguments import instance
from fecontact.common.checks import array_of, check_magnitude
from fecontact.common.errors import InputError, shown
from fecontact.common.material import Material


def contact_modulus(first: Material, second: Material | None = None) -> float:
    """Return E*, with 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

    Parameters
    ----------
    first : Material
        Material of one body.
    second : Material or None
        Material of the other body; None for a rigid one.

    Returns
    -------
    float
        Contact modulus E* (force / length^2).

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, chapter 4.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> round(contact_modulus(steel, steel), 2), round(contact_modulus(steel), 2)
    (115384.62, 230769.23)
    """
    instance("the first material", first, Material)
    instance("the second material", second, (Material, type(None)))
    compliance = 1 / first.plane_strain_modulus
    if second is not None:
        compliance += 1 / second.plane_strain_modulus
    return 1 / compliance


def pair_modulus(materials: tuple[Material | None, Material | None]) -> float:
    """Return E* of a pair of materials, of which at most one is None (rigid).

    Raises
    ------
    InputError
        If the pair is not two materials, or both are rigid.

    Examples
    --------
    >>> round(pair_modulus((None, Material(E=210e3, nu=0.3))), 2)
    230769.23
    """
    try:
        first, second = materials
    except (TypeError, ValueError):
        raise InputError(f"Expected materials=(m1, m2), None for a rigid body; found {shown(materials)}.") from None
    for material in (first, second):
        if not (material is None or isinstance(material, Material)):
            raise InputError(f"Expected a Material, or None for a rigid body; found {shown(material)}.", code="no-body")
    if first is None:
        first, second = second, first
    if first is None:
        raise InputError("Expected at least one elastic body; found both rigid (None). Give one a Material.")
    return contact_modulus(first, second)


def dundurs(first: Material | None, second: Material | None = None) -> float:
    """Return Dundurs' second constant beta, by which tangential tractions displace the surfaces along their normal.

    Parameters
    ----------
    first, second : Material or None
        Materials of the two bodies, None for a rigid one.

    Returns
    -------
    float
        ((1 - 2 nu1)/G1 - (1 - 2 nu2)/G2)/(2 (1 - nu1)/G1 + 2 (1 - nu2)/G2), from -1/2 to 1/2; zero for equal materials,
        and for an incompressible one on a rigid one.

    Raises
    ------
    InputError
        If both bodies are rigid.

    References
    ----------
    J. Dundurs, J. Appl. Mech. 36 (1969) 650; K. L. Johnson, Contact Mechanics, 1985, section 5.1.

    Examples
    --------
    >>> steel = Material(E=210e3, nu=0.3)
    >>> round(dundurs(steel), 12), round(dundurs(None, steel), 12), dundurs(steel, steel)
    (0.285714285714, -0.285714285714, 0.0)
    """
    pair_modulus((first, second))
    above, below = 0.0, 0.0
    for material, sign in ((first, 1), (second, -1)):
        if material is not None:
            above += sign * (1 - 2 * material.nu) / material.shear_modulus
            below += 2 * (1 - material.nu) / material.shear_modulus
    return above / below


def poisson_ratio(materials: tuple[Material | None, Material | None], body: int) -> float:
    """Return Poisson's ratio of body 0 or 1 of a pair, to evaluate a stress in it.

    Raises
    ------
    InputError
        If there is no such body, or it is rigid.

    Examples
    --------
    >>> poisson_ratio((None, Material(E=210e3, nu=0.3)), 1)
    0.3
    """
    if not (isinstance(body, int) and body in (0, 1)):
        raise InputError(f"Expected body 0 (the first) or 1 (the second); found {shown(body)}.", code="unknown-body")
    material = materials[body]
    if material is None:
        raise InputError(f"Body {body} is rigid: it has no stress. Ask for body {1 - body}.", code="rigid-body")
    return material.nu


def relative_radius(radii: tuple[float, float]) -> float:
    """Return R, with 1/R = 1/R1 + 1/R2.

    Parameters
    ----------
    radii : tuple of (float, float)
        Radii of the two surfaces; negative for a concave one, `inf` for a plane.

    Returns
    -------
    float
        Relative radius, positive.

    Raises
    ------
    InputError
        If a radius is zero or not a number, or 1/R1 + 1/R2 is not positive.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, chapter 4.

    Examples
    --------
    >>> relative_radius((10.0, math.inf)), relative_radius((10.0, -20.0))
    (10.0, 20.0)
    """
    found = array_of(radii)
    if found is None or found.shape != (2,):
        raise InputError(f"Expected radii=(R1, R2), two numbers; found {shown(radii)}.", code="radii")
    first, second = found.tolist()
    check_magnitude("a radius", found[np.isfinite(found)])
    if math.isnan(first) or math.isnan(second) or 0 in (first, second):
        raise InputError(f"Expected radii that are not zero (negative: concave, inf: plane); found {radii!r}.")
    if math.isinf(first) or math.isinf(second):
        curvature = 1 / first + 1 / second
        R = 1 / curvature if curvature != 0 else math.inf
    else:
        R = second / (1 + second / first) if first + second != 0 else math.inf
    if not 0 < R < math.inf:
        raise InputError(
            f"Expected 1/R1 + 1/R2 > 0, so that the surfaces touch at one point; found radii {first} and {second}. "
            "The radius of a concave surface must be larger than that of the ball in it.",
            code="surfaces-do-not-touch",
        )
    return R
