"""Plates and shells on a middle surface of any shape, thin or with a gradient across of their own.

Strains are taken by coordinates of the cells and count in orthonormal axes of the initial shape, which its gradients J0
give at each point, as they give areas and volumes: a curved shape is free of stress as made. Source: A. A. Shabana,
Computational Continuum Mechanics, section 5.4, eq. 5.40, 5.41.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.ancf.slender import shapes
from fecontact.ancf.slender.laminate import Lamina, Laminate, in_space, plane_stress, referred, sheet
from fecontact.ancf.slender.shapes import XX, XY, XZ, YY, YZ, X, Y, Z, at_nodes, rule
from fecontact.ancf.slender.strains import Products, SurfaceCurvature, Together, green_lagrange
from fecontact.ancf.slender.structure import Part, Structure
from fecontact.ancf.slender.surface import Surface
from fecontact.common.arrays import Array
from fecontact.common.checks import among, lengths
from fecontact.common.errors import InputError
from fecontact.common.material import Material

KINDS = {
    (False, False): shapes.PLATE,
    (True, False): shapes.THICK_PLATE,
    (False, True): shapes.SMOOTH_PLATE,
    (True, True): shapes.SMOOTH_THICK_PLATE,
}


def plate(
    corners: Sequence[ArrayLike],
    divisions: tuple[int, int],
    material: Material | Lamina | Laminate,
    thickness: ArrayLike | None = None,
    radius: float | None = None,
) -> Structure:
    """A thin rectangular plate or cylindrical shell (Kirchhoff), with two gradients at each node.

    Parameters
    ----------
    corners : three points
        A corner and its neighbours along x and y.
    divisions : (int, int)
    material : Material, Lamina or Laminate
        Orthotropic layers have their angles from the plate's x.
    thickness : float or (n_nodes,) array
        Of one material; a laminate has its own.
    radius : float, optional
        Of a cylindrical shell: the plate is rolled along y towards its normal, x cross y, and free of stress so.

    Examples
    --------
    >>> import fecontact as fc
    >>> plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], (2, 2), fc.Material(E=1.0, nu=0.3), 0.01).n_dofs
    81
    """
    return shell(Surface.rolled(corners, divisions, radius), material, thickness)


def thick_plate(
    corners: Sequence[ArrayLike],
    divisions: tuple[int, int],
    material: Material,
    thickness: ArrayLike,
    approach: str = "surface",
    radius: float | None = None,
) -> Structure:
    """A rectangular plate or cylindrical shell with three gradients at each node.

    Parameters
    ----------
    corners, divisions, material, thickness, radius
        As for `plate`.
    approach : {'surface', 'continuum'}
        'surface': thin, with a gradient across of its own. 'continuum': Green-Lagrange strains over the volume,
        which locks.
    """
    return shell(Surface.rolled(corners, divisions, radius), material, thickness, thick=True, approach=approach)


def shell(
    surface: Surface,
    material: Material | Lamina | Laminate,
    thickness: ArrayLike | None = None,
    *,
    thick: bool = False,
    smooth: bool = False,
    approach: str = "surface",
) -> Structure:
    """A plate or shell of any shape, free of stress as made.

    Parameters
    ----------
    surface : Surface
        Its middle surface: a mapped grid, or any mesh of quadrilaterals.
    material : Material, Lamina or Laminate
        Orthotropic layers have their angles from the first tangents of the surface. A thick shell is of a `Material`.
    thickness : float or (n_nodes,) array
        Of one material; a laminate has its own.
    thick : bool
        With a gradient across of its own at each node, as `thick_plate`; else by Kirchhoff, as `plate`.
    smooth : bool
        With r_xy as a coordinate of the nodes too, of a mapped grid (48 coordinates an element, 60 of a thick one).
        Slopes are then continuous, else at nodes only.
    approach : {'surface', 'continuum'}
        Of a thick shell, see `thick_plate`.

    Raises
    ------
    InputError
        For thicknesses that are not positive, a laminate that tapers or is thick, a smooth shell of a general mesh.

    Examples
    --------
    >>> import fecontact as fc
    >>> saddle = Surface.mapped(lambda u, v: np.stack([u, v, 0.2 * u * v], axis=-1), (2, 2))
    >>> shell(saddle, fc.Material(E=1.0, nu=0.3), 0.01, smooth=True).n_dofs
    108
    """
    among("approach", approach, ("surface", "continuum"))
    shape = KINDS[thick, smooth]
    if smooth and surface.mixed is None:
        raise InputError("A smooth shell needs a mapped grid: a general mesh has no common r_xy.", code="smooth")
    taper, mean = _tapered(surface, thickness)
    made = sheet(material, mean)
    single = getattr(material, "layers", None) is None
    if not single and (taper != 1).any():
        raise InputError("A laminate does not taper: its thickness is that of its layers.", code="thickness")
    if thick and getattr(material, "lame", None) is None:
        raise InputError("A thick shell is of one isotropic material; take a thin one.", code="thick-layers")
    vectors = [surface.nodes, *np.swapaxes(surface.tangents, 0, 1)]
    vectors += [surface.normals * taper[:, None]] if thick else []
    vectors += [cast(Array, surface.mixed)] if smooth else []
    frames = np.broadcast_to(np.eye(shape.per_node - 1), (*surface.cells.shape, *[shape.per_node - 1] * 2)).copy()
    frames[:, :, :2, :2] = surface.frames
    if smooth:
        frames[:, :, -1, -1] = surface.frames[..., 0, 0] * surface.frames[..., 1, 1]
    box = np.column_stack([surface.lengths, np.full(len(surface.cells), made.thickness if thick else 1.0)])
    nothing = (np.zeros((0, 3)), np.zeros(0), box[:, 0])
    bare = Structure(shape, np.stack(vectors, axis=1), surface.cells, box, (), nothing, frames=frames)
    middle = _Middle(bare, surface, taper, made)
    if not thick:
        four = rule(4, 4)
        inertia = (*four, made.mass * middle.taper(four[0]) * middle.area(four[0]))
        return replace(bare, parts=middle.thin(four), inertia=inertia)
    inside, weights = rule(4, 4, 2, across=(False, True))
    density, isotropic = made.mass / made.thickness * weights, cast(Material, material)
    if approach == "continuum":
        J0 = bare.fields(inside, (X, Y, Z))
        volume = np.linalg.det(J0) * box.prod(axis=1)[:, None]
        parts = [Part((X, Y, Z), green_lagrange((0, 1, 2)), referred(in_space(isotropic), J0), inside, weights, volume)]
        return replace(bare, parts=parts, inertia=(inside, density, volume))
    volume = made.thickness * middle.taper(inside) * middle.area(inside * [1, 1, 0])
    return replace(bare, parts=middle.with_fibres(isotropic), inertia=(inside, density, volume))


def _tapered(surface: Surface, thickness: ArrayLike | None) -> tuple[Array, float | None]:
    """Thickness of each node (n_nodes,) over the mean one, and that."""
    if thickness is None:
        return np.ones(len(surface.nodes)), None
    each = np.asarray(thickness, dtype=float)
    if each.ndim and each.shape != (len(surface.nodes),):
        raise InputError(f"Give one thickness, or one of each of the {len(surface.nodes)} nodes; found {each.shape}.")
    lengths(thickness=float(np.min(each)))
    mean = float(each.mean())
    return np.broadcast_to(each / mean, len(surface.nodes)), mean


@dataclass(frozen=True, eq=False)
class _Middle:
    """The parts of a shell's energy on its middle surface.

    Attributes
    ----------
    bare : Structure
        Without parts.
    surface : Surface
    relative : (n_nodes,) array
        Thickness over that of `made`.
    made : Laminate
    """

    bare: Structure
    surface: Surface
    relative: Array
    made: Laminate

    def by_nodes(self, values: Array, points: Array) -> Array:
        """Bilinear interpolation (n_cells, n_q, ..) of values (n_nodes, ..)."""
        x, y = points[:, 0], points[:, 1]
        N = np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)
        return np.asarray(
            np.tensordot(values[self.surface.cells], N, (1, 1)).swapaxes(1, -1)
            if values.ndim > 1
            else values[self.surface.cells] @ N.T
        )

    def taper(self, points: Array) -> Array:
        """Thickness (n_cells, n_q) over that of `made`."""
        return self.by_nodes(self.relative, points)

    def area(self, points: Array) -> Array:
        """Area (n_cells, n_q) by which points weigh."""
        a, b = np.moveaxis(self.bare.fields(points, (X, Y)), 2, 0)
        return np.asarray(np.linalg.norm(np.cross(a, b), axis=2) * self.bare.lengths[:, :2].prod(axis=1)[:, None])

    def axes(self, points: Array) -> Array:
        """Derivatives J0 (n_cells, n_q, 2, 2) of the position in axes of the surface, the first by the tangents."""
        first = self.bare.fields(points, (X, Y))
        n = np.cross(first[:, :, 0], first[:, :, 1])
        n /= np.linalg.norm(n, axis=2, keepdims=True)
        guide = self.by_nodes(self.surface.tangents[:, 0], points)
        across = np.cross(n, guide)
        across /= np.linalg.norm(across, axis=2, keepdims=True)
        return np.asarray(first @ np.stack([np.cross(across, n), across], axis=3))

    def thin(self, at: tuple[Array, Array]) -> list[Part]:
        """Membrane and Kirchhoff's bending, which layers about the middle may couple."""
        J0, area, t = self.axes(at[0]), self.area(at[0]), self.taper(at[0])[..., None, None]
        orders = (X, Y, XX, YY, XY)
        A, B, D = self.made.membrane, self.made.coupling, self.made.bending
        if B.any():
            # along the normal fibres shorten where the curvature r_xx . n is positive
            both = np.block([[A, -B], [-B, D]])
            return [
                Part(orders, Together(green_lagrange((0, 1)), 2, SurfaceCurvature()), referred(both, J0), *at, area)
            ]
        return [
            Part((X, Y), green_lagrange((0, 1)), t * referred(A, J0), *at, area),
            Part(orders, SurfaceCurvature(), t**3 * referred(D, J0), *at, area),
        ]

    def with_fibres(self, material: Material) -> list[Part]:
        """A thin shell's parts, the strain of the gradient across, and its shear against the middle surface.

        The gradient across is bilinear and the surface's normal is not, so that their shear is taken in the middle of
        an element; its change within the element is resisted with the rigidity of bending, so that nothing locks. Its
        length counts at the nodes, see `kinds._elastic_line`. Where the thickness varies it does by the gradient.
        """
        h, flat = self.made.thickness, plane_stress(material)
        four, middle = rule(4, 4, across=(False, True)), rule(1, 1, across=(False, True))
        nodes = at_nodes(shapes.THICK_PLATE)
        shear = Products((((1.0, 0, 2),), ((1.0, 1, 2),)), (0.0, 0.0))
        # of r_x, r_y, r_z, r_xx, r_yy, r_xy, r_xz, r_yz
        change = Products(
            (((1.0, 3, 2), (1.0, 0, 6)), ((1.0, 4, 2), (1.0, 1, 7)), ((2.0, 5, 2), (1.0, 0, 7), (1.0, 1, 6))),
            (0.0, 0.0, 0.0),
        )
        t, t4 = (self.taper(at[0])[..., None, None] for at in (nodes, four))
        K = np.linalg.inv(self.axes(middle[0]))
        sheared = (
            5 / 6 * h * material.shear_modulus * np.swapaxes(K, -1, -2) @ K / self.taper(middle[0])[..., None, None]
        )
        bent = h**3 / 12 * t4 * referred(flat, self.axes(four[0]))
        return [
            *self.thin(four),
            Part((Z,), green_lagrange((0,)), h * material.E / t**3, *nodes, self.area(nodes[0])),
            Part((X, Y, Z), shear, sheared, *middle, self.area(middle[0])),
            Part((X, Y, Z, XX, YY, XY, XZ, YZ), change, bent, *four, self.area(four[0])),
        ]
