"""Remainder of a body's compliance after that of a half-space: smooth, from a coarse finite element model.

The response of the surface to a point load is that of a half-space, u_B, plus a remainder. The remainder is the
displacement of the body under the tractions -t(u_B) on its other faces and the displacements -u_B of its supports; it
has no singularity, so a coarse mesh gives it, and a polynomial interpolates it, in the point of observation and in that
of the load. This is subtraction of a fundamental solution, as in the treatment of point loads and cracks by finite
elements.

By Betti's theorem the remainder is symmetric in the two points. Of finite elements it is so up to their error: its
asymmetry is an estimate of that error, which costs nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.halfspace.smooth import SmoothTerm
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.sources import Source, images
from fecontact.bodies.local.window import Window, chebyshev, coefficients, interpolation
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.mesh.facets import facet_integrals
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import components_along

ORDERS = (6, 8, 10, 12)
"""Nodes along each side of a window that are tried in turn; even, so that half of them serve where it is mirrored."""

SMALL = 1e-4
"""Coefficients of the highest degree, relative to the mean compliance of the window, at which the order suffices."""

LARGEST_DEFECT = 0.01
"""Asymmetry of the remainder, relative to the mean compliance of the window, from which the model is refused."""

IN_PLANE = 1e-9
"""Distance from a plane, relative to the body's size, within which a face lies in it."""

NEAR, FINE, COARSE = 2.0, 11, 6
"""Orders of the quadrature on faces within so many of their sizes from the window, and on the others."""

UNIFORM = 2.973210
"""Mean of 1/r between the points of a unit square: 4 ln(1 + sqrt 2) - 4/3 (sqrt 2 - 1)."""


@dataclass(frozen=True, eq=False)
class Remainder:
    """Remainder at the Chebyshev nodes of a window.

    Attributes
    ----------
    window : Window
    order : int
        Nodes along each side.
    core : (k, k) array
        Displacements into the body at the nodes by unit forces there, symmetric.
    fields : (n_dofs, k) array
        Displacements of the mesh's nodes, without those of the half-space.
    sources : tuple of Source
        The unit loads at the nodes.
    defect : float
        Largest asymmetry of the core before it was made symmetric, relative to the mean compliance of the window.
    tail : float
        Largest coefficient of the highest degree, relative to the same.
    """

    window: Window
    order: int
    core: Array
    fields: Array
    sources: tuple[Source, ...]
    defect: float
    tail: float

    @cached_property
    def points(self) -> Array:
        """The nodes (k, 3), in the body's axes."""
        return node_points(self.window, self.order)

    @cached_property
    def term(self) -> SmoothTerm:
        """The remainder between the window's cells."""
        x, y = (
            interpolation(along, half, self.order, mirrored)
            for along, half, mirrored in zip(self.window.along, self.window.half, self.window.mirrored, strict=True)
        )
        return SmoothTerm(x, y, self.core, self.window.grid.area)


def remainder(factored: Factored, window: Window, material: Material) -> Remainder:
    """Remainder of a body in a window, with as many nodes as its smoothness needs.

    Parameters
    ----------
    factored : Factored
    window : Window
    material : Material
        Of the body below the window.

    Returns
    -------
    Remainder
    """
    for order in ORDERS:
        found = _at_order(factored, window, material, order)
        if found.tail <= SMALL:
            break
    return found


def checked(found: Remainder, name: str) -> Remainder:
    """The remainder of a body, unless it is too far from symmetric.

    Raises
    ------
    InputError
    """
    if found.defect > LARGEST_DEFECT:
        raise InputError(
            f"The compliance of {name!r} in its window contradicts Betti's theorem by {100 * found.defect:.2g} %, more "
            f"than {100 * LARGEST_DEFECT:g} %: its mesh is too coarse for what lies beside the window (edges, holes, "
            f"supports). Take a finer mesh there, or a smaller window; its sides are {found.window.grid.size}."
        )
    return found


def node_points(window: Window, order: int) -> Array:
    """Chebyshev nodes (k, 3) of a window, in the body's axes."""
    along = (chebyshev(b, order, even) for b, even in zip(window.half, window.mirrored, strict=True))
    return window.at(*(c.ravel() for c in np.meshgrid(*along, indexing="ij")))


def _at_order(factored: Factored, window: Window, material: Material, order: int) -> Remainder:
    points = node_points(window, order)
    frame = window.axes * np.array([1.0, 1.0, -1.0])
    sources = tuple(Source(*images(p, frame, window.origin, window.axes, window.mirrored), material) for p in points)
    fields = factored.solve(_loads(factored.model.mesh, window, sources), _at_supports(factored, sources))
    inwards = np.tile(-window.normal, (len(points), 1))
    core = components_along(surface_weights(factored.model.mesh, window, points), inwards) @ fields
    scale = _mean_compliance(window, material)
    defect = _asymmetry(core) / scale
    core = (core + core.T) / 2
    return Remainder(window, order, core, fields, sources, defect, _tail(core, window, order) / scale)


def _mean_compliance(window: Window, material: Material) -> float:
    """Mean displacement of the window, as part of a half-space, per force uniform over it."""
    side = float(np.sqrt(np.prod(window.grid.size)))
    return UNIFORM / (np.pi * material.plane_strain_modulus * side) * 2 ** sum(window.mirrored)


def _asymmetry(core: Array) -> float:
    return float(np.abs(core - core.T).max()) / 2


def _tail(core: Array, window: Window, order: int) -> float:
    """Largest coefficient of the highest degree along either direction of the point of observation."""
    matrices = [
        coefficients(half, order, mirrored) for half, mirrored in zip(window.half, window.mirrored, strict=True)
    ]
    kx, ky = (len(m) for m in matrices)
    values = np.einsum("ia,jb,abn->ijn", *matrices, core.reshape(kx, ky, -1))
    return float(max(np.abs(values[-1]).max(), np.abs(values[:, -1]).max()))


def in_planes(mesh: Mesh, window: Window) -> tuple[IntArray, IntArray, IntArray]:
    """Outer faces (n, 2) in the window's plane, on its planes of symmetry, and all others."""
    faces = mesh.outer_faces
    corners = window.coordinates(mesh.points)[mesh.face_nodes(faces)[:, :4]]
    flat = np.abs(corners).max(axis=1) <= IN_PLANE * np.ptp(mesh.points, axis=0).max()
    mirror = (flat[:, :2] & np.array(window.mirrored)).any(axis=1)
    return faces[flat[:, 2]], faces[mirror & ~flat[:, 2]], faces[~mirror & ~flat[:, 2]]


def facet_groups(mesh: Mesh, faces: IntArray) -> Iterator[IntArray]:
    """Facets of faces (n, 2), those with a mid-face node apart from those without."""
    middle = np.zeros(len(faces), bool)
    if mesh.midface is not None:
        middle = mesh.midface[faces[:, 0], faces[:, 1]] >= 0
    for chosen in (middle, ~middle):
        if chosen.any():
            yield mesh.face_nodes(faces[chosen])


def _loads(mesh: Mesh, window: Window, sources: tuple[Source, ...]) -> Array:
    """Nodal forces (n_dofs, k) of the tractions, with opposite sign, of point loads on the faces beside the window."""
    f = np.zeros((len(mesh.points), 3, len(sources)))
    for facets in facet_groups(mesh, in_planes(mesh, window)[2]):
        corners = mesh.points[facets[:, :4]]
        size = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
        away = np.linalg.norm(corners - window.origin, axis=2).min(axis=1) - np.linalg.norm(window.half)
        for chosen, order in ((away < NEAR * size, FINE), (away >= NEAR * size, COARSE)):
            if not chosen.any():
                continue
            N, x, dA = facet_integrals(mesh.points, facets[chosen], order)
            for k, source in enumerate(sources):
                nodal = np.einsum("fqa,fqi->fai", N, source.traction(x, dA), optimize=True)
                np.subtract.at(f[:, :, k], facets[chosen], nodal)
    return f.reshape(-1, len(sources))


def _at_supports(factored: Factored, sources: tuple[Source, ...]) -> Array:
    """Displacements (n_dofs, k) that the supports need: those of point loads, with opposite sign; zero elsewhere."""
    model = factored.model
    points = model.mesh.points
    marks = np.zeros(model.n_coordinates)
    marks[factored.held] = 1.0
    nodes = np.flatnonzero(marks.reshape(-1, 3).any(axis=1))
    if model.coordinates.ties is not None:
        nodes = model.coordinates.ties.free[nodes]
    out = np.zeros((len(points), 3, len(sources)))
    for k, source in enumerate(sources):
        out[nodes, :, k] = -source.displacement(points[nodes])
    return out.reshape(-1, len(sources))


def surface_weights(mesh: Mesh, window: Window, points: Array) -> sp.csr_matrix:
    """Interpolation (n, n_nodes) of the surface in the window's plane, from the mesh's nodes to points (n, 3)."""
    nearest, out = np.full(len(points), np.inf), sp.csr_matrix((len(points), len(mesh.points)))
    for facets in facet_groups(mesh, in_planes(mesh, window)[0]):
        found = FacetSurface(mesh.points, facets).project(points)
        away = np.linalg.norm(points - found.points, axis=1)
        better = away < nearest
        nearest = np.minimum(nearest, away)
        assert found.weights is not None
        out = sp.diags_array((~better).astype(float)) @ out + sp.diags_array(better.astype(float)) @ found.weights
    return sp.csr_matrix(out)
