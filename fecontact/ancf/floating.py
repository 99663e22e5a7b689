"""A body of small strains that moves and turns by any angle: a floating frame with the modes of its condensed model.

Its points move by r(X) = sum_a c_a p_a(X), with functions p_a of `fem.modes`: 1, the coordinates X, and components of
modes. The vectors c_a are its coordinates, so that its mass is constant, and joints are linear as of other members. Its
frame is the rotation R of the mean gradient F = (c_1, c_2, c_3), and displacements seen from there have the linear
energy

    E = u . K u / 2,    u_a = R^T c_a - c_a0.

Modes are orthogonal by mass to X, so that the frame is that of the body's mean motion (F. de Veubeke, Int. J. Eng. Sci.
14, 1976). Source: A. Pechstein, D. Reischl & J. Gerstmayr, J. Comput. Nonlinear Dyn. 8 (2013), 011019.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.rotation import Rotation, axial
from fecontact.ancf.slender.structure import BETWEEN
from fecontact.ancf.system.member import Drawing
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.fem.modes import Modes


@dataclass(frozen=True, eq=False)
class FloatingBody:
    """A member of an `Assembly` with the modes of an elastic body.

    Parameters
    ----------
    modes : Modes
        From ``ElasticBody.with_modes(20)``, or a file of it. Nodes at which joints act should be kept.

    Examples
    --------
    >>> import fecontact as fc
    >>> bar = fc.shapes.block((4.0, 1.0, 1.0), (4, 1, 1))
    >>> body = FloatingBody(fc.ElasticBody(bar, fc.Material(E=1.0, nu=0.3, density=1.0)).with_modes(3))
    >>> turned = (body.q0.reshape(-1, 3) @ fc.rotation_about((0, 0, 1), 2.0).T).ravel()
    >>> bool(abs(body.forces(turned)).max() < 1e-12)
    True
    """

    modes: Modes

    @property
    def name(self) -> str:
        """What it is."""
        return "body with modes"

    @property
    def n_dofs(self) -> int:
        """Coordinates: twelve of an affine motion, and nine of each mode."""
        return 3 * self.modes.functions.shape[1]

    @cached_property
    def q0(self) -> Array:
        """Initial coordinates (n_dofs,)."""
        c = np.zeros((self.modes.functions.shape[1], 3))
        c[0], c[1:4] = self.modes.centre, np.eye(3)
        return c.ravel()

    @property
    def extent(self) -> float:
        """Largest extent of its points."""
        return float(np.ptp(self.modes.points, axis=0).max())

    @property
    def scales(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths."""
        each = np.ones((self.modes.functions.shape[1], 3))
        each[1:4] = self.extent
        return each.ravel()

    @property
    def is_slender(self) -> bool:
        """It turns with little strain."""
        return True

    def translation(self, direction: Array) -> Array:
        """Change (n_dofs,) of the coordinates by a translation (3,)."""
        out = np.zeros(self.n_dofs)
        out[:3] = direction
        return out

    @property
    def rigid_modes(self) -> Array:
        """Changes (n_dofs, 6) by the rigid motions about the centre of mass."""
        arms = self.q0.reshape(-1, 3).copy()
        arms[0] = 0.0
        turns = [np.cross(e, arms).ravel() for e in np.eye(3)]
        return np.stack([*map(self.translation, np.eye(3)), *turns], axis=1)

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """Constant mass (n_dofs, n_dofs)."""
        return sp.csr_matrix(sp.kron(self.modes.mass, sp.eye_array(3)))

    def place_rows(self, where: Any) -> list[sp.csr_matrix]:
        """Rows (1, n_vectors) of the position of a node of the mesh, by its number.

        Raises
        ------
        InputError
            For unknown nodes.
        """
        n = len(self.modes.points)
        if not (isinstance(where, int | np.integer) and -n <= where < n):
            raise InputError(f"The body has {n} nodes, counted from 0; found {where!r}.", code="unknown-node")
        return [sp.csr_matrix(self.modes.functions[int(where)][None])]

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """What loads need in every iteration."""
        return {}

    def gradient_weights(self, at: Any) -> Array:
        """B (n_vectors, 3) of what turns by a `Moment` at "frame": its frame, so that the body's mean motion does.

        Raises
        ------
        InputError
            For other places: a node has no rotation.
        """
        among("place of a moment on a body with modes", at, ("frame",))
        return np.eye(self.modes.functions.shape[1], 3, -1)

    def positions(self, q: Array) -> Array:
        """Nodes (n, 3)."""
        return np.asarray(self.modes.functions @ q.reshape(-1, 3))

    def _seen(self, q: Array) -> tuple[Rotation, Array, Array]:
        """The frame, the coordinates (k, 3) seen from it, and the elastic forces (k, 3) there."""
        c = q.reshape(-1, 3)
        frame = Rotation(c[1:4].T)
        y = c @ frame.R
        u = y - self.q0.reshape(-1, 3)
        u[0] = 0.0  # translations are free
        return frame, y, (self.modes.stiffness @ u.ravel()).reshape(-1, 3)

    def energy(self, q: Array) -> float:
        """Strain energy."""
        _, y, f = self._seen(q)
        u = y - self.q0.reshape(-1, 3)
        return float((u[1:] * f[1:]).sum()) / 2

    def forces(self, q: Array) -> Array:
        """Its gradient (n_dofs,)."""
        frame, y, f = self._seen(q)
        out = f @ frame.R.T
        out[1:4] += frame.forces(axial(y.T @ f)).T
        return np.asarray(out.ravel())

    def tangent(self, q: Array) -> sp.csr_matrix:
        """Its second derivative (n_dofs, n_dofs)."""
        frame, y, f = self._seen(q)
        n, R = len(y), frame.R
        J = np.kron(np.eye(n), R.T)
        # unit changes of F, row by row, are those of these coordinates
        of_frame = (3 * (1 + np.arange(3)) + np.arange(3)[:, None]).ravel()
        J[:, of_frame] += np.einsum("ax,nxy->ayn", y, frame.spin).reshape(3 * n, 9)
        K = J.T @ self.modes.stiffness @ J
        mixed = np.einsum("ix,nxy,ay->ain", R, frame.spin, f).reshape(3 * n, 9)
        K[:, of_frame] += mixed
        K[of_frame] += mixed.T
        N = y.T @ f
        K[np.ix_(of_frame, of_frame)] += frame.tangent(axial(N), -axial(frame.spin @ N)).reshape(9, 9)
        return sp.csr_matrix((K + K.T) / 2)

    def forces_between(self, q0: Array, q1: Array) -> Array:
        """Elastic forces (n_dofs,) whose work from q0 to q1 is the change of energy, see `BETWEEN`."""
        return np.sum([w * self.forces(q0 + x * (q1 - q0)) for x, w in BETWEEN], axis=0, dtype=float)

    def check_inverted(self, q: Array) -> None:
        """Its strains are small: nothing turns inside out."""

    def drawn(self, q: Array) -> Drawing:
        """Its nodes."""
        n = len(self.modes.points)
        return Drawing("vertex", self.modes.points, self.positions(q), np.arange(n)[:, None], np.zeros((n, 6)))
