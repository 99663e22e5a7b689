"""Slender structures by their sections: lines (cables and Bernoulli beams), strips and beams; plates are in `shells`.

===============  ======================  =============================================================================
`line`           12 coordinates, 8 flat  axis stretches and bends (Berzeri & Shabana, J. Sound Vib. 235, 2000)
`strip`          18, 12 flat             planar beam that shears, continuum (Omar & Shabana 2001)
`beam`           24                      continuum, or elastic line (A. L. Schwab & J. P. Meijaard, DETC 2005-85104)
`plate`          36                      thin, Kirchhoff
`thick_plate`    48                      continuum, or middle surface
===============  ======================  =============================================================================

Continuum elements take Green-Lagrange strains over their volume; bending couples with the strain across the section, so
they are too stiff where Poisson's ratio is not zero (Poisson locking), and in bending by shear. The elastic line and
the middle surface separate stretch, shear, bending and strains of the section, with shear integrated at fewer points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from fecontact.ancf.slender import shapes
from fecontact.ancf.slender.laminate import in_space, plane_stress, referred
from fecontact.ancf.slender.layers import layers_of
from fecontact.ancf.slender.shapes import ENDS_AND_MIDDLE, XX, XY, XZ, X, Y, Z, at_nodes, rule
from fecontact.ancf.slender.strains import (
    ChordFrame,
    LineCurvature,
    Measure,
    Products,
    Stretch,
    Together,
    green_lagrange,
)
from fecontact.ancf.slender.structure import Part, Structure, axes_of, axis_of
from fecontact.common.arrays import Array
from fecontact.common.checks import among, lengths
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.plastic import Plastic


def _bent() -> tuple[Array, Array]:
    """Points (n, 3) and weights (n,) of a cubic axis' bending, exact for the linear curvature of a straight one.

    On an arc the curvature of a cubic varies by about the square of its angle, whose square makes it too stiff. Three
    points at -a, 0 and a on [-1, 1] take away what that adds: of an element of angle 2 t with |r'| = 1 at both ends and
    in the middle, e = 1 - cos t, the mean of the squared curvature is 2 e + e^2 / 3 + (2 - 2 a^2) e^3 / 3, and t^2 is
    2 e + e^2 / 3 + 4 e^3 / 45: equal for a^2 = 13/15; Gauss's is 3/5. An axis that stretches does best between, at 4/5.
    """
    a, w = np.sqrt(0.2), 5 / 24
    return np.array([[0.5 - a, 0.5, 0.5], [0.5, 0.5, 0.5], [0.5 + a, 0.5, 0.5]]), np.array([w, 1 - 2 * w, w])


def line(
    points: ArrayLike | Sequence[ArrayLike],
    *,
    EA: float,
    EI: float,
    mass: float = 0.0,
    tangents: ArrayLike | None = None,
    measure: str = "turn",
    plastic: Plastic | None = None,
) -> Structure:
    """A cable or Bernoulli beam along nodes in order, bending alike in all directions, without twist.

    Parameters
    ----------
    points : (n, 3) array, or a sequence of them
        Of one axis, or of several straight ones: bars that joints may tie, as one structure, which is faster.
    EA, EI : float
        Rigidities of stretch and bending.
    mass : float
        Per length.
    tangents : (n, 3) array, optional
        Unit tangents at the nodes of a curved axis, which is free of stress. It lies in the plane x, y and bends in it
        only, for without twist it has no section to bend out of it.
    measure : {'turn', 'geometric', 'chord'}
        'turn': strain |r'| - 1 and turn of the tangent per initial length. 'geometric': Green-Lagrange strain and the
        curvature of the present axis (Shabana's book). They differ where the axis stretches. 'chord': linear in the
        frame of each element's chord, the model of 1999, for comparison; in the plane x, y.
    plastic : Plastic, optional
        Of a section that flows by layers: the rectangle of these rigidities, bent in the plane x, y only. Its stretch
        and bending count at the ends and the middle of each element.

    Examples
    --------
    >>> from fecontact.ancf.slender import straight
    >>> cable = line(straight((0, 0, 0), (1, 0, 0), 4), EA=100.0, EI=1.0)
    >>> cable.n_dofs
    30
    """
    lengths(EA=EA, EI=EI)
    among("measure", measure, ("turn", "geometric", "chord"))
    nodes, t, cells, size = axes_of(points, tangents)
    box = np.column_stack([size, np.ones((len(size), 2))])
    four = rule(4)
    kind = "curved" if tangents is not None else "plastic" if plastic is not None else "'chord'"
    flat = kind != "'chord'" or measure == "chord"
    if flat and np.ptp(nodes[:, 2]) + np.abs(t[:, 2]).max() > 1e-12 * size.sum():
        raise InputError(f"A {kind} line must lie in the plane x, y; take `beam` for one in space.", code="in-space")
    bent = EI * np.diag([float(not flat), float(not flat), 1.0])
    inertia = (four[0], mass * four[1], size)
    if plastic is not None:
        if measure != "turn":
            raise InputError(f"A plastic line has the measure 'turn'; found {measure!r}.", code="measure")
        both = Together(Stretch(), 1, LineCurvature(2))
        rigidity = np.diag([EA, *np.diag(bent)])
        parts = [Part((X, XX), both, rigidity, *ENDS_AND_MIDDLE, size, layers_of(plastic, EA, EI))]
        return Structure(shapes.LINE, np.stack([nodes, t], axis=1), cells, box, parts, inertia)
    if measure == "chord":
        parts = [Part((X, XX, shapes.CHORD), ChordFrame(), np.diag([EA, EI]), *four, size)]
        return Structure(shapes.LINE, np.stack([nodes, t], axis=1), cells, box, parts, inertia)
    stretch: Measure = Stretch() if measure == "turn" else green_lagrange((0,))
    parts = [
        *_stretch(stretch, EA, EI, size),
        Part((X, XX), LineCurvature(2 if measure == "turn" else 3), bent, *_bent(), size),
    ]
    return Structure(shapes.LINE, np.stack([nodes, t], axis=1), cells, box, parts, inertia)


def _stretch(measure: Measure, EA: float, EI: float, size: Array) -> list[Part]:
    """Stretch of a cubic axis, at Lobatto's points where its elements are long and stiff, else everywhere.

    A cubic axis that bends cannot keep its length everywhere, and locks. Lobatto's point at a node serves two elements,
    so that each has two conditions beside its four coordinates in a plane and bends freely, and no form is left without
    energy (J. Gerstmayr & H. Irschik, J. Sound Vib. 318, 2008). Large strains that vary within an element want all
    points. Locking and varying strains are told apart by EA l^2 / EI; where it is 4000 both have equal shares.
    """
    whole = 1 / (1 + (EA * size**2 / (4000 * EI)) ** 2)
    rigidity = np.array([[EA]])
    return [
        Part((X,), measure, rigidity, *ENDS_AND_MIDDLE, size * (1 - whole)),
        Part((X,), measure, rigidity, *rule(5), size * whole),
    ]


def strip(points: ArrayLike, material: Material, *, width: float, height: float, approach: str = "line") -> Structure:
    """A planar beam in the plane x, y that shears.

    Parameters
    ----------
    points : (n, 3) array
        Nodes of a straight axis, with z constant.
    material : Material
    width, height : float
        The height lies in the plane.
    approach : {'line', 'continuum'}
        'line': elastic line. 'continuum': plane stress over the height, which locks.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf.slender import straight
    >>> strip(straight((0, 0, 0), (1, 0, 0), 4), fc.Material(E=1.0, nu=0.3), width=0.1, height=0.1).n_dofs
    45
    """
    lengths(width=width, height=height)
    among("approach", approach, ("line", "continuum"))
    nodes = np.asarray(points, dtype=float)
    t, cells, size = axis_of(nodes, None)
    across = np.cross((0.0, 0.0, 1.0), t)
    box = np.column_stack([size, np.full(len(size), height), np.ones(len(size))])
    inside, weights = rule(4, 2, across=(True, False))
    volume = size * height * width
    if approach == "continuum":
        parts = [Part((X, Y), green_lagrange((0, 1)), plane_stress(material), inside, weights, volume)]
    else:
        parts = _flat_line(material, width, height, size)
    inertia = (inside, _density(material) * weights, volume)
    return Structure(shapes.STRIP, np.stack([nodes, t, across], axis=1), cells, box, parts, inertia)


def beam(
    points: ArrayLike,
    material: Material,
    *,
    width: float,
    height: float,
    up: ArrayLike = (0.0, 0.0, 1.0),
    tangents: ArrayLike | None = None,
    approach: str = "line",
    torsion: float | None = None,
) -> Structure:
    """A beam of a rectangular section with three gradients at each node.

    Parameters
    ----------
    points : (n, 3) array
    material : Material
    width, height : float
        Along the section's y and z; z is `up` made normal to the axis.
    up : (3,) array
    tangents : (n, 3) array, optional
        Of a curved axis; its section keeps `up`.
    approach : {'line', 'continuum'}
        'line': elastic line. 'continuum': Green-Lagrange strains over the volume, which locks.
    torsion : float, optional
        Torsion constant J; of the rectangle unless given.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf.slender import straight
    >>> steel = fc.Material(E=210e3, nu=0.3)
    >>> beam(straight((0, 0, 0), (100, 0, 0), 4), steel, width=5.0, height=10.0).n_dofs
    60
    """
    lengths(width=width, height=height)
    among("approach", approach, ("line", "continuum"))
    nodes = np.asarray(points, dtype=float)
    t, cells, size = axis_of(nodes, tangents)
    across = np.cross(np.asarray(up, dtype=float), t)
    if (np.linalg.norm(across, axis=1) < 1e-6).any():
        raise InputError(f"up = {tuple(np.ravel(up))} lies along the axis; give a direction across it.", code="up-axis")
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    vectors = np.stack([nodes, t, across, np.cross(t, across)], axis=1)
    box = np.column_stack([size, np.full(len(size), width), np.full(len(size), height)])
    inside, weights = rule(4, 2, 2, across=(True, True))
    mass, volume = _density(material) * weights, box.prod(axis=1)
    bare = Structure(shapes.BEAM, vectors, cells, box, (), (inside, mass, volume))
    if approach == "continuum":
        J0 = bare.fields(inside, (X, Y, Z))
        volume = np.linalg.det(J0) * volume[:, None]
        D = referred(in_space(material), J0)
        parts = [Part((X, Y, Z), green_lagrange((0, 1, 2)), D, inside, weights, volume)]
        return replace(bare, parts=parts, inertia=(inside, mass, volume))
    J = rectangle_torsion(width, height) if torsion is None else torsion
    return replace(bare, parts=_elastic_line(material, width, height, J, size))


def rectangle_torsion(width: float, height: float) -> float:
    """Torsion constant of a rectangle, by its series.

    Source: S. P. Timoshenko & J. N. Goodier, Theory of Elasticity, section 109.

    Examples
    --------
    >>> round(rectangle_torsion(1.0, 1.0), 4)
    0.1406
    """
    short, long = sorted((width, height))
    k = np.arange(1, 40, 2)
    series = (np.tanh(k * np.pi * long / (2 * short)) / k**5).sum()
    return float(long * short**3 / 3 * (1 - 192 * short / (np.pi**5 * long) * series))


def _elastic_line(material: Material, width: float, height: float, J: float, size: Array) -> list[Part]:
    """Stretch; strains of the section at nodes; shear at two points; bending and torsion by the section's gradients.

    Gradients across are linear between nodes and so shorten where the section turns: with a unit length inside, an
    element could not bend. Their strains count at its nodes, where neighbours share them.

    With a linear turn of the section and a cubic axis, shear at two points leaves the axis one free form in each
    element. The change of shear along the axis resists it, with the rigidity of bending, so that the linear part of the
    curvature counts, or that of shear where elements are short, so that it vanishes with them.
    """
    E, G, A = material.E, material.shear_modulus, width * height
    shear_rigidity = 5 / 6 * G * A
    one, two = rule(3, across=(True, True)), rule(2, across=(True, True))
    # the section's strains have moduli of their own: nothing couples them to bending
    section = green_lagrange((0, 1))
    shear = Products((((1.0, 0, 1),), ((1.0, 0, 2),)), (0.0, 0.0))
    # of r_x, r_y, r_z, r_xy, r_xz
    turns = Products((((1.0, 0, 3),), ((1.0, 0, 4),), ((0.5, 2, 3), (-0.5, 1, 4))), (0.0, 0.0, 0.0))
    # of r_x, r_y, r_z, r_xx, r_xy, r_xz
    change = Products((((1.0, 3, 1), (1.0, 0, 4)), ((1.0, 3, 2), (1.0, 0, 5))), (0.0, 0.0))
    bending = E * A * np.array([width**2, height**2]) / 12
    return [
        Part((X,), green_lagrange((0,)), A * E * np.eye(1), *one, size),
        Part((Y, Z), section, A * np.diag([E, E, G]), *at_nodes(shapes.BEAM), size),
        Part((X, Y, Z), shear, shear_rigidity * np.eye(2), *two, size),
        Part((X, Y, Z, XY, XZ), turns, np.diag([*bending, G * J]), *two, size),
        *(
            Part(
                (X, Y, Z, XX, XY, XZ),
                change,
                np.diag(b * (np.arange(2) == k)),
                *one,
                size * _short(b, shear_rigidity, size),
            )
            for k, b in enumerate(bending)
        ),
    ]


def _flat_line(material: Material, width: float, height: float, size: Array) -> list[Part]:
    """The elastic line in a plane, see `_elastic_line`."""
    E, A, G = material.E, width * height, material.shear_modulus
    one, two = rule(3, across=(True, False)), rule(2, across=(True, False))
    # r_x . r_y is the shear, r_x . r_xy the turn of the section
    product = Products((((1.0, 0, 1),),), (0.0,))
    change = Products((((1.0, 2, 1), (1.0, 0, 3)),), (0.0,))
    bending = E * A * height**2 / 12
    return [
        Part((X,), green_lagrange((0,)), A * E * np.eye(1), *one, size),
        Part((Y,), green_lagrange((0,)), A * E * np.eye(1), *at_nodes(shapes.STRIP), size),
        Part((X, Y), product, 5 / 6 * G * A * np.eye(1), *two, size),
        Part((X, XY), product, bending * np.eye(1), *two, size),
        Part((X, Y, XX, XY), change, bending * np.eye(1), *one, size * _short(bending, 5 / 6 * G * A, size)),
    ]


def _short(bending: float, shear: float, size: Array) -> Array:
    """Share (n_elements,) of the bending rigidity against a change of shear within an element."""
    return np.asarray(1 / (1 + 60 * bending / (shear * size**2)))


def _density(material: Material) -> float:
    return 0.0 if material.density is None else material.density
