"""Faces of bricks in contact: multiplier basis, and projection of points on the moving faces.

Pressure is a combination of the non-negative multiplier functions of mortar coupling on eight-node faces, as that of
`AncfBody` (`contact.coupling.mortar_basis`): one for each corner and one for the middle of each side, bilinear on the
four quarters of the face; in its middle the pressure is the mean of the sides'. Faces share the functions of common
corners and sides. There are as many multipliers as unknowns of the face's normal motion (three for each node); the
functions sum to one and reproduce every linear pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from fecontact.ancf.bricks.hexahedron import face_points
from fecontact.ancf.system.moving_contact import MovingSide
from fecontact.bodies.surface_body import SurfaceBody
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.contact.coupling.mortar_basis import multiplier_shapes, own_samples
from fecontact.mesh.element import FACES, quad_nodes
from fecontact.mesh.facets import sides_of
from fecontact.surfaces.closest_point import FacetPolynomials
from fecontact.surfaces.facet_surface import FacetSurface, Projection

if TYPE_CHECKING:
    from fecontact.ancf.bricks.solid import AncfSolid
    from fecontact.ancf.bricks.space import AncfSpace

#: Feet start from a grid of so many points along each side of a face.
SAMPLES = 5
#: Faces tried for each projection.
TRIED = 3
#: Relative difference of distances that is rounding.
SAME = 1e-9
#: Tangential offset outside the rim, relative to the size of a face, above which a point faces nothing.
OVERHANG = 1e-6
#: Four points along each side that determine a cubic, and the matrix from values there to powers.
GRID = np.array([0.0, 0.25, 0.75, 1.0])
TO_POWERS = np.linalg.inv(GRID[:, None] ** np.arange(4))


def multiplier_rule() -> tuple[Array, Array, Array]:
    """Points (n, 2) on the unit square, weights (n,), and the eight multipliers there (n, 8): corners, then sides.

    Examples
    --------
    >>> points, weights, multipliers = multiplier_rule()
    >>> (16 * weights @ multipliers).round(12).tolist()
    [1.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0]
    """
    _, points, weights = own_samples(np.arange(8)[None])
    return points, weights, multiplier_shapes(8, np.zeros(len(points), bool), points)


class PresentBody(SurfaceBody):
    """Faces of a solid as they lie, for results of a contact.

    Parameters
    ----------
    facets : FacetSurface
    name : str
    modulus : float
        E / (1 - nu^2) of its softest material, for estimates.
    """

    def __init__(self, facets: FacetSurface, name: str, modulus: float) -> None:
        self.facets, self.name = facets, name
        self.flexibility = sp.csr_matrix((self.n_dofs, self.n_dofs))  # it is not solved again
        self.__dict__["contact_modulus"] = modulus


@dataclass(frozen=True, eq=False)
class Faces(MovingSide):
    """A boundary of a solid of bricks.

    Parameters
    ----------
    member : AncfSolid
    name : str
        The boundary.
    """

    member: AncfSolid
    name: str

    @property
    def space(self) -> AncfSpace:
        """Coordinates of the solid."""
        return self.member.space

    @property
    def n_dofs(self) -> int:
        """Their number."""
        return self.space.n_dofs

    @cached_property
    def faces(self) -> IntArray:
        """Cell and local face (n, 2) of each."""
        return self.space.mesh.faces(self.name)

    @property
    def named(self) -> IntArray:
        """The faces by number."""
        return self.faces

    @cached_property
    def thickness(self) -> float:
        """Smallest extent of all bricks."""
        return float(np.ptp(self.space.mesh.points, axis=0).min())

    @cached_property
    def widths(self) -> Array:
        """Lengths (n_multipliers,) on which multipliers act."""
        return np.sqrt(self.quadrature[2])

    @cached_property
    def corners(self) -> IntArray:
        """Nodes (n, 4) of the faces, counted in `space.nodes`."""
        cell, face = self.faces.T
        return self.space.corners[cell[:, None], FACES[face, :4]]

    @cached_property
    def sides(self) -> IntArray:
        """Numbers (n, 4) of the sides, from corner k to k + 1."""
        ends = np.sort(sides_of(self.corners).reshape(-1, 2), axis=1)
        return np.asarray(np.unique(ends, axis=0, return_inverse=True)[1]).reshape(-1, 4)

    @cached_property
    def multipliers(self) -> IntArray:
        """Numbers (n, 8) of the multipliers of each face: its corners, then its sides."""
        nodes, shared = np.unique(self.corners, return_inverse=True)
        return np.concatenate([shared.reshape(-1, 4), len(nodes) + self.sides], axis=1)

    @cached_property
    def rim(self) -> Mask:
        """Whether a side (n, 4), from corner k to k + 1, belongs to one of the faces only."""
        return np.asarray(np.bincount(self.sides.ravel())[self.sides] == 1)

    @cached_property
    def _points(self) -> tuple[IntArray, Array, Array, Array]:
        """Faces (n,) of all quadrature points and coordinates (n, 2) there, weights and multipliers of one face."""
        local, weights, multipliers = multiplier_rule()
        n = len(self.faces)
        return np.repeat(np.arange(n), len(weights)), np.tile(local, (n, 1)), weights, multipliers

    @property
    def points(self) -> tuple[IntArray, Array]:
        """Faces (n,) of all quadrature points and coordinates (n, 2) there."""
        return self._points[:2]

    def _integrals(self, q: Array) -> sp.csr_matrix:
        """Multipliers times areas (n_multipliers, n_points) at coordinates q of the solid."""
        each, where, weights, multipliers = self._points
        n, n_q = len(self.faces), len(weights)
        _, tangents = self.at(q, each, where)
        area = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=1).reshape(n, n_q) * weights
        row = np.broadcast_to(self.multipliers[:, None, :], (n, n_q, 8))
        column = np.broadcast_to(np.arange(n * n_q).reshape(n, n_q, 1), (n, n_q, 8))
        shape = (int(self.multipliers.max()) + 1, n * n_q)
        integral = sp.csr_matrix(((area[:, :, None] * multipliers).ravel(), (row.ravel(), column.ravel())), shape=shape)
        integral.eliminate_zeros()
        return integral

    @cached_property
    def quadrature(self) -> tuple[sp.csr_matrix, sp.csr_matrix, Array]:
        """Rows N (n_points, n_functions) at quadrature points, A (n_multipliers, n_points), areas (n_multipliers,).

        Areas are those of the initial geometry.
        """
        integral = self._integrals(self.space.q0)
        areas = np.asarray(integral.sum(axis=1)).ravel()
        return self.rows(*self.points), sp.csr_matrix(sp.diags_array(1 / areas) @ integral), areas

    def present_areas(self, q: Array) -> Array:
        """Areas (n_multipliers,) at coordinates q of the solid: force over area is Cauchy's pressure."""
        return np.asarray(self._integrals(q).sum(axis=1)).ravel()

    def present(self, q: Array, name: str) -> PresentBody:
        """The faces at coordinates q of the solid, with a node at the place of every multiplier."""
        each, places = np.repeat(np.arange(len(self.faces)), 8), np.tile(quad_nodes(8), (len(self.faces), 1))
        points = np.empty((int(self.multipliers.max()) + 1, 3))
        points[self.multipliers.ravel()] = self.at(q, each, places)[0]
        surface = FacetSurface(points, self.multipliers, self.name, mortar_on_quad8=True)
        return PresentBody(surface, name, min(m.plane_strain_modulus for m in self.member.materials))

    def rows_at(self, projection: Projection) -> sp.csr_matrix:
        """Values (n, n_functions) of all functions at closest points."""
        assert projection.facet is not None
        assert projection.local is not None
        return self.rows(projection.facet, projection.local)

    def rows(self, each: IntArray, local: Array) -> sp.csr_matrix:
        """Values (n, n_functions) of all functions at coordinates (n, 2) on faces `each`."""
        cell, face = self.faces[each].T
        X = np.empty((len(each), 3))
        for f in np.unique(face):
            X[face == f] = face_points(int(f), local[face == f])
        return self.space.rows_at(cell, X)

    @cached_property
    def _grid(self) -> sp.csr_matrix:
        """Values (16 n, n_functions) at four by four points of each face."""
        local = np.stack(np.meshgrid(GRID, GRID, indexing="ij"), axis=-1).reshape(-1, 2)
        return self.rows(np.repeat(np.arange(len(self.faces)), 16), np.tile(local, (len(self.faces), 1)))

    def polynomials(self, q: Array) -> FacetPolynomials:
        """The faces at coordinates q, polynomials of degree three in each direction."""
        grid = (self._grid @ q.reshape(-1, 3)).reshape(-1, 4, 4, 3)
        origin = grid[:, 0, 0]
        offsets = grid - origin[:, None, None]
        c = np.einsum("ia,jb,nabk->ijkn", TO_POWERS, TO_POWERS, offsets, optimize=True)
        return FacetPolynomials(np.ascontiguousarray(origin.T), np.ascontiguousarray(c), np.zeros(len(grid), bool))

    def at(self, q: Array, each: IntArray, local: Array) -> tuple[Array, Array]:
        """Positions (n, 3) and tangents (n, 3, 2) at coordinates q, on faces `each` at `local` (n, 2)."""
        return self.polynomials(q).evaluate(each, local)

    @cached_property
    def _samples(self) -> tuple[sp.csr_matrix, IntArray, Array]:
        t = (np.arange(SAMPLES) + 0.5) / SAMPLES
        local = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
        each, where = np.repeat(np.arange(len(self.faces)), len(local)), np.tile(local, (len(self.faces), 1))
        return self.rows(each, where), each, where

    def project(self, q: Array, points: Array) -> Projection:
        """Projection of points (n, 3) on the faces at coordinates q; `facet` and `local` give the closest points."""
        rows, each, where = self._samples
        polynomials = self.polynomials(q)
        tree = cKDTree(rows @ q.reshape(-1, 3))
        _, near = tree.query(points, k=min(TRIED * 4, len(each)))
        near = near.reshape(len(points), -1)
        start = np.take_along_axis(near, first_of_each(each[near]), axis=1)
        facet, n = each[start], start.shape[1]
        local, distance2 = polynomials.closest(np.repeat(points, n, axis=0), facet.ravel(), start=where[start.ravel()])
        distance = np.sqrt(distance2).reshape(-1, n)
        # a face must be nearer by more than rounding: a closest point on a shared side belongs to the first face
        least = distance.min(axis=1, keepdims=True)
        best = np.argmax(distance <= least * (1 + SAME), axis=1)
        rows_of = np.arange(len(points))
        return self._projection(polynomials, points, facet[rows_of, best], local.reshape(-1, n, 2)[rows_of, best])

    def _projection(self, polynomials: FacetPolynomials, points: Array, each: IntArray, local: Array) -> Projection:
        x, t = polynomials.evaluate(each, local)
        across = np.cross(t[..., 0], t[..., 1])
        size = np.sqrt(np.linalg.norm(across, axis=1))
        normals = across / size[:, None] ** 2
        offset = points - x
        gap = np.einsum("ni,ni->n", offset, normals)
        sideways = np.linalg.norm(offset - gap[:, None] * normals, axis=1)
        ends = np.stack([local[:, 1] <= 0, local[:, 0] >= 1, local[:, 1] >= 1, local[:, 0] <= 0], axis=1)
        outside = (ends & self.rim[each]).any(axis=1) & (sideways > OVERHANG * size)
        return Projection(x, normals, gap, outside, None, each, local)


def first_of_each(faces: IntArray) -> IntArray:
    """Columns (n, TRIED) of the first occurrence of each face (n, m) in a row, padded by the first column."""
    n, m = faces.shape
    new = np.ones((n, m), bool)
    for k in range(1, m):
        new[:, k] = (faces[:, :k] != faces[:, k : k + 1]).all(axis=1)
    rank = np.cumsum(new, axis=1) - 1
    out = np.zeros((n, min(TRIED, m)), dtype=np.int64)
    for r in range(out.shape[1]):
        hit = new & (rank == r)
        out[:, r] = np.where(hit.any(axis=1), hit.argmax(axis=1), 0)
    return out
