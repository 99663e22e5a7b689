"""Elastic layer on a rigid foundation under a rigid paraboloid: limits of a thick and of a thin layer."""

from __future__ import annotations

import math

from fecontact.analytic.layer_kernel import Base, compliance
from fecontact.common import checks
from fecontact.common.material import Material


def thick(*, radius: float, material: Material, a: float) -> tuple[float, float, float]:
    """Return force, approach and central pressure for a contact much smaller than the thickness: Hertz.

    Parameters
    ----------
    radius : float
        Radius of curvature R of the paraboloid.
    material : Material
        Material of the layer.
    a : float
        Contact radius. Range: a/h < 0.02 for one per cent in the approach (the error grows as a/h).

    Returns
    -------
    tuple of (float, float, float)
        P = 4 E* a^3/(3R), delta = a^2/R, p0 = 2 E* a/(pi R).

    Raises
    ------
    InputError
        If a number is not positive.

    References
    ----------
    Johnson 1985, chapter 4.

    Examples
    --------
    >>> thick(radius=1.0, material=Material(E=3.0, nu=0.0), a=1.0)[:2]
    (4.0, 1.0)
    """
    R, width = checks.positive("the radius", radius), checks.positive("the contact radius", a)
    E_star = material.plane_strain_modulus
    return 4 * E_star * width**3 / (3 * R), width**2 / R, 2 * E_star * width / (math.pi * R)


def thin_compressible(
    *, radius: float, thickness: float, material: Material, a: float, base: Base = "bonded"
) -> tuple[float, float, float]:
    """Return force, approach and central pressure for a thin, compressible layer: an elastic foundation.

    Parameters
    ----------
    radius : float
        As in `thick`.
    thickness : float
        Thickness h of the layer.
    material : Material
        Material of the layer; not nearly incompressible if it is bonded.
    a : float
        Contact radius. Range: a/h > 10; see the notes.
    base : {"bonded", "frictionless"}
        How the layer rests on the rigid foundation.

    Returns
    -------
    tuple of (float, float, float)
        P = pi H a^4/(4 R h), delta = a^2/(2R), p0 = H a^2/(2 R h), with the foundation modulus
        H = E (1 - nu)/((1 + nu)(1 - 2 nu)) bonded, E/(1 - nu^2) frictionless.

    Raises
    ------
    InputError
        If a number is not positive, or the base unknown.

    Notes
    -----
    The error falls as h/a. Bonded, the exact force is larger by 7.5, 2.5, 1.5 per cent at a/h = 10, 30, 50 for nu = 0,
    by 5.0, 1.6, 1.0 per cent for nu = 0.3; for nu > 0.45 neither this limit nor the incompressible one holds.

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, section 5.8.

    Examples
    --------
    >>> thin_compressible(radius=1.0, thickness=0.5, material=Material(E=1.0, nu=0.0), a=1.0)[1:]
    (0.5, 1.0)
    """
    R, h = checks.positive("the radius", radius), checks.positive("the thickness", thickness)
    width = checks.positive("the contact radius", a)
    stiffness = 1 / float(compliance(0.0, h, material, base))  # H/h
    return math.pi * stiffness * width**4 / (4 * R), width**2 / (2 * R), stiffness * width**2 / (2 * R)


def thin_incompressible(*, radius: float, thickness: float, material: Material, a: float) -> tuple[float, float, float]:
    """Return force, approach and central pressure for a thin, incompressible, bonded layer (film).

    Parameters
    ----------
    radius, thickness : float
        As in `thin_compressible`.
    material : Material
        Material of the layer; only its shear modulus G enters.
    a : float
        Contact radius. Range: a/h large, and (1 - 2 nu) (a/h)^2 much less than 1; see the notes.

    Returns
    -------
    tuple of (float, float, float)
        P = pi G a^6/(32 R h^3), delta = a^2/(4R), p0 = 3 G a^4/(32 R h^3).

    Raises
    ------
    InputError
        If a number is not positive.

    Notes
    -----
    Material is displaced sideways by the pressure gradient as in a lubricating film, delta - r^2/(2R) = -(h^3/(3G)) lap
    p, with p and its gradient zero at the edge: p = (3 G/(32 R h^3)) (a^2 - r^2)^2. The error falls only as h/a: for nu
    = 0.499999 the exact force is 2.2, 1.33 and 1.19 times this one at a/h = 10, 30 and 50, the approach 1.25, 1.09 and
    1.06 times. Use it as an estimate, not as a reference for tests.

    References
    ----------
    J. R. Barber, J. Appl. Mech. 57 (1990) 489; Johnson 1985, chapter 5 for the plane case.

    Examples
    --------
    >>> thin_incompressible(radius=1.0, thickness=0.5, material=Material(E=3.0, nu=0.49999), a=1.0)[1]
    0.25
    """
    R, h = checks.positive("the radius", radius), checks.positive("the thickness", thickness)
    width, G = checks.positive("the contact radius", a), material.shear_modulus
    p0 = 3 * G * width**4 / (32 * R * h**3)
    return math.pi * p0 * width**2 / 3, width**2 / (4 * R), p0
