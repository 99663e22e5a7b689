"""Generalised forces of loads on members: weight, forces at points, dead tractions, follower pressure, moments.

A force acts through the shape functions on all coordinates, including gradients: Q_a = int S_a b dV or int S_a t dA.

Loads that change with the deformation: pressure that follows its surface, and moments.

A moment m does the work m . dtheta on the virtual rotation dtheta of the place where it acts. Its rotation R is that of
the polar decomposition A = R S of a matrix that is linear in the coordinates,

    A = sum_f q_f (x) B_f:    at a node, the deformation gradient;    on a boundary, int r (x) (X - X_mean) dA,

so that on a boundary R is the rotation of the rigid motion that fits the surface best (least squares). From dA follow
the forces, see `ancf.rotation`,

    Q_f = R [g]x B_f,    T g = R^T m.

On a plane section Q is a
traction linear in X - X_mean that turns with it, which is the stress of pure bending.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.ancf.bricks.hexahedron import gauss
from fecontact.ancf.bricks.solid import AncfSolid
from fecontact.ancf.bricks.space import AncfSpace, SurfaceRule, vector_areas
from fecontact.ancf.rotation import EPS, Rotation, skew
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import number, vector
from fecontact.common.errors import InputError


class Carrier(Protocol):
    """What a force acts on."""

    def place_rows(self, where: Any) -> list[sp.csr_matrix]:
        """Rows (n, n_functions) of the position and each gradient at places."""


class Surfaced(Protocol):
    """What tractions and pressures act on: a space of bricks, or a slender structure."""

    @property
    def functions(self) -> IntArray:
        """Numbers of its elements' functions."""

    @property
    def q0(self) -> Array:
        """Initial coordinates (n_dofs,)."""

    @property
    def joining(self) -> sp.csr_matrix | None:
        """Functions of elements by those that neighbours share; None where they are the same."""

    def spread(self, q: Array) -> Array:
        """Vectors (n, 3) of the functions, from q (n_dofs,)."""

    def gather(self, f: Array) -> Array:
        """Generalised forces (n_dofs,) from those on the functions (n, 3)."""

    def surface_rule(self, boundary: str) -> SurfaceRule:
        """Quadrature on a boundary."""


def weight(solid: AncfSolid, acceleration: ArrayLike) -> Array:
    """Forces (n_dofs,) of gravity or of another uniform acceleration (3,) on the mass."""
    g = vector("The acceleration", acceleration)
    return body_force(solid.space, g, solid.density)


def body_force(space: AncfSpace, force: ArrayLike | Callable[[Array], Array], density: ArrayLike = 1.0) -> Array:
    """Forces (n_dofs,) of a force per initial mass (per volume for unit density).

    Parameters
    ----------
    space : AncfSpace
    force : (3,) array or callable
        ``force(points (n, 3)) -> (n, 3)``, points of the initial shape.
    density : float or (n_cells,) array
    """
    rho = np.broadcast_to(np.asarray(density, dtype=float), len(space.corners))
    e0 = space.spread(space.q0)
    total = np.zeros_like(e0)
    for batch in space.batches(*gauss(4)):
        x = batch.S @ e0[batch.functions]
        if callable(force):
            b = np.asarray(force(x.reshape(-1, 3)), dtype=float).reshape(x.shape)
        else:
            b = np.broadcast_to(vector("The force", force), x.shape)
        weighted = b * (batch.dV * rho[batch.cells, None])[..., None]
        np.add.at(total, batch.functions, np.swapaxes(batch.S, 1, 2) @ weighted)
    return space.gather(total)


def point_force(space: AncfSpace, cell: int, X: ArrayLike, force: ArrayLike) -> Array:
    """Forces (n_dofs,) of a force (3,) at reference coordinates X (3,) of a cell."""
    rows = space.rows_at(np.array([cell]), vector("The reference coordinates", X)[None, :])
    return np.asarray(rows.T @ vector("The force", force)[None, :]).ravel()


def force_at(space: Carrier, point: ArrayLike, force: ArrayLike) -> Array:
    """Forces (n_dofs,) of a force (3,) at any point (3,) of the initial shape; it goes with the material point.

    Parameters
    ----------
    space : AncfSpace, AncfSolid or Structure
    point : (3,) array
        Of a solid, an axis or a middle surface.
    force : (3,) array

    Raises
    ------
    InputError
        If the point lies outside.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSpace
    >>> space = AncfSpace(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
    >>> Q = force_at(space, (1.5, 0.5, 1.0), (0.0, 0.0, -2.0))
    >>> (Q @ space.rigid_modes()).round(12).tolist()  # the force and its moment about the origin
    [0.0, 0.0, -2.0, -1.0, 3.0, 0.0]
    """
    rows = space.place_rows(vector("The point", point)[None, :])[0]
    return np.asarray(rows.T @ vector("The force", force)[None, :]).ravel()


def nodal_force(space: AncfSpace, point: int, force: ArrayLike) -> Array:
    """Forces (n_dofs,) of a force (3,) at a mesh point that is a node.

    Raises
    ------
    InputError
        If the point is not a corner of a cell.
    """
    f = np.zeros((space.n_functions, 3))
    f[space.start[space.node_of(point)]] = vector("The force", force)
    return f.ravel()


def traction(space: Surfaced, boundary: str, field: ArrayLike | Callable[[Array, Array], Array]) -> Array:
    """Forces (n_dofs,) of a dead load: force per initial area on a boundary, which keeps its direction.

    Parameters
    ----------
    space : AncfSpace or Structure
    boundary : str
        Of a solid; ``"top"`` or ``"bottom"`` of a plate, whose normal is x cross y or its opposite; ``"axis"`` of a
        line, a strip or a beam, whose load is a force per initial length.
    field : (3,) array or callable
        ``field(points (n, 3), unit outward normals (n, 3)) -> (n, 3)``, both of the initial shape; tangents of an axis.

    Examples
    --------
    >>> from fecontact.ancf.slender import line, straight
    >>> bar = line(straight((0, 0, 0), (2, 0, 0), 2), EA=1.0, EI=1.0)
    >>> Q = traction(bar, "axis", (0.0, -3.0, 0.0))
    >>> ((Q @ bar.rigid_modes).round(12) + 0.0).tolist()  # force, and no moment about the middle
    [0.0, -6.0, 0.0, 0.0, 0.0, 0.0]
    """
    functions, S, dS, W = space.surface_rule(boundary)
    e = space.spread(space.q0)[functions]
    dA = vector_areas(e, dS) * W[:, None]
    area = np.linalg.norm(dA, axis=2)
    x = S @ e
    if callable(field):
        t = np.asarray(field(x.reshape(-1, 3), (dA / area[..., None]).reshape(-1, 3)), dtype=float).reshape(x.shape)
    else:
        t = np.broadcast_to(vector("The traction", field), x.shape)
    return _summed(space, functions, np.einsum("fqa,fqi,fq->fai", S, t, area))


def dead_pressure(space: Surfaced, boundary: str, pressure: float) -> Array:
    """Forces (n_dofs,) of a pressure on the initial shape that keeps its direction; positive pushes inwards."""
    return traction(space, boundary, lambda x, n: -pressure * n)


def pressure_forces(space: Surfaced, q: Array, boundary: str, pressure: float) -> Array:
    """Forces (n_dofs,) of a pressure that follows the surface at coordinates q; positive pushes inwards.

    -p int S_a (dr/ds x dr/dt) ds dt (Bonet & Wood 2008, section 9.3.5).
    """
    functions, S, dS, W = space.surface_rule(boundary)
    dA = vector_areas(space.spread(q)[functions], dS) * W[:, None]
    return _summed(space, functions, -pressure * np.swapaxes(S, 1, 2) @ dA)


def pressure_tangent(space: Surfaced, q: Array, boundary: str, pressure: float) -> sp.csr_matrix:
    """Derivative (n_dofs, n_dofs) of `pressure_forces` by q; symmetric only for a closed or edge-held surface."""
    functions, S, dS, W = space.surface_rule(boundary)
    along = np.einsum("fqaj,fai->fqji", dS, space.spread(q)[functions])
    # d(r_s x r_t)_i = eps_ikm (dS_s r_t,m - dS_t r_s,m) dq_k
    cross_t, cross_s = (np.einsum("ikm,fqm->fqik", EPS, along[:, :, j]) for j in (1, 0))
    change = dS[..., 0][..., None, None] * cross_t[:, :, None] - dS[..., 1][..., None, None] * cross_s[:, :, None]
    blocks = np.einsum("fqa,fqbik,q->faibk", S, change, -pressure * W, optimize=True)
    dofs = (3 * functions[:, :, None] + np.arange(3)).reshape(len(functions), -1)
    n, k = 3 * (int(space.functions.max()) + 1), dofs.shape[1]
    where = np.repeat(dofs, k, axis=1).ravel(), np.tile(dofs, (1, k)).ravel()
    K = sp.csr_matrix((blocks.reshape(-1), where), shape=(n, n))
    if space.joining is None:
        return K
    T = sp.kron(space.joining, sp.eye_array(3), format="csr")
    return (T.T @ K @ T).tocsr()


def _summed(space: Surfaced, functions: IntArray, own: Array) -> Array:
    total = np.zeros((int(space.functions.max()) + 1, 3))
    np.add.at(total, functions, own)
    return space.gather(total)


class Follower(Protocol):
    """A load on a solid of bricks or a slender structure that depends on its coordinates."""

    @property
    def solid(self) -> int:
        """Number of the member in its assembly."""

    def forces(self, space: Any, q: Array) -> Array:
        """Generalised forces (n_dofs,) at coordinates q of the member, given its space or structure."""

    def tangent(self, space: Any, q: Array) -> sp.csr_matrix:
        """Their derivative (n_dofs, n_dofs)."""


@dataclass(frozen=True)
class FollowerPressure:
    """Pressure on a boundary, along its present normals and per present area; positive pushes inwards.

    Parameters
    ----------
    solid : int
        Number of the solid or the plate in its assembly.
    boundary : str
        ``"top"`` or ``"bottom"`` of a plate, see `traction`.
    pressure : float

    Raises
    ------
    InputError
        If the pressure is not a finite number.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSpace
    >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    >>> turned = space.affine(fc.rotation_about((0, 1, 0), np.pi / 2))  # the top faces x now
    >>> Q = FollowerPressure(0, "top", 2.0).forces(space, turned)
    >>> ((Q @ space.rigid_modes()[:, :3]).round(12) + 0.0).tolist()
    [-2.0, 0.0, 0.0]
    """

    solid: int
    boundary: str
    pressure: float

    def __post_init__(self) -> None:
        if not np.isfinite(number(self.pressure)):
            raise InputError(f"A pressure must be a finite number; found {self.pressure!r}.", code="not-finite")

    def forces(self, space: Surfaced, q: Array) -> Array:
        """Generalised forces (n_dofs,)."""
        return pressure_forces(space, q, self.boundary, self.pressure)

    def tangent(self, space: Surfaced, q: Array) -> sp.csr_matrix:
        """Their derivative (n_dofs, n_dofs)."""
        return pressure_tangent(space, q, self.boundary, self.pressure)


@dataclass(frozen=True)
class Moment:
    """A moment in space on a boundary or on the gradients of a node; see the module for the rotation it turns.

    Parameters
    ----------
    solid : int
        Number of the solid or the slender structure in its assembly.
    at : str or int
        A boundary, or a point of the mesh that is a node; a node of a structure.
    moment : (3,)
        It keeps its direction. On a line, which does not twist, it does no work along the tangent.

    Raises
    ------
    InputError
        If the moment is not three finite numbers.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSpace
    >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    >>> Q = Moment(0, "top", (0.0, 3.0, 0.0)).forces(space, space.q0)
    >>> (0.0 + (Q @ space.rigid_modes()).round(12)).tolist()  # no force, and this moment; 0.0 + -0.0 is 0.0
    [0.0, 0.0, 0.0, 0.0, 3.0, 0.0]
    """

    solid: int
    at: str | int
    moment: ArrayLike

    def __post_init__(self) -> None:
        vector("The moment", self.moment)

    def _weights(self, space: Any) -> Array:
        """What turns, see `gradient_weights`, made once for each place of a space or structure."""
        key = "turns", self.at
        if key not in space.kept:
            space.kept[key] = space.gradient_weights(self.at)
        return np.asarray(space.kept[key])

    def forces(self, space: Any, q: Array) -> Array:
        """Generalised forces (n_dofs,)."""
        B = self._weights(space)
        if B.any(axis=1).sum() == 1:
            return self._on_line(B, q)[0]
        turn = Rotation(q.reshape(-1, 3).T @ B)
        return np.asarray(B @ turn.forces(turn.R.T @ np.asarray(self.moment, dtype=float)).T).ravel()

    def tangent(self, space: Any, q: Array) -> sp.csr_matrix:
        """Their derivative (n_dofs, n_dofs); symmetric if everything turns in one plane."""
        B = self._weights(space)
        if B.any(axis=1).sum() == 1:
            return self._on_line(B, q)[1]
        turn = Rotation(q.reshape(-1, 3).T @ B)
        m = turn.R.T @ np.asarray(self.moment, dtype=float)
        dP = turn.tangent(m, -turn.spin @ m).reshape(3, 3, 3, 3)  # p, j of dA, then those of P
        used = np.flatnonzero(B.any(axis=1))
        blocks = np.einsum("ak,bj,pjrk->arbp", B[used], B[used], dP, optimize=True)
        dofs = (3 * used[:, None] + np.arange(3)).ravel()
        n = len(dofs)
        return sp.csr_matrix((blocks.ravel(), (dofs.repeat(n), np.tile(dofs, n))), shape=(space.n_dofs,) * 2)

    def _on_line(self, B: Array, q: Array) -> tuple[Array, sp.csr_matrix]:
        """Forces on a single tangent t, and their derivative: m . dtheta with dtheta = t x dt / t^2 is m x t / t^2."""
        (k,) = np.flatnonzero(B.any(axis=1))
        t, m = q.reshape(-1, 3)[k], np.asarray(self.moment, dtype=float)
        Q, size = np.zeros(len(q)), t @ t
        Q[3 * k : 3 * k + 3] = np.cross(m, t) / size
        K = sp.lil_matrix((len(q), len(q)))
        K[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = skew(m) / size - 2 * np.outer(np.cross(m, t), t) / size**2
        return Q, sp.csr_matrix(K)
