"""Structures of slender elements: coordinates, energy, forces, tangent and constant mass.

Coordinates are numbered by node: its position, then its gradients, three components each. All elements of a structure
are of one shape. An element's energy is a sum of parts, each with its strain measure, rigidities and quadrature, so
that a part can be integrated at fewer points against locking.

What slender structures share: coordinates in vectors at nodes, and no volume.

Axes of slender members: nodes in order, their tangents, elements and lengths.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Protocol, Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.ancf.bricks.viscosity import Viscosity, stiffening
from fecontact.ancf.slender.closest import Middle
from fecontact.ancf.slender.contact import Skin
from fecontact.ancf.slender.layers import Layers
from fecontact.ancf.slender.shapes import Order, Shape
from fecontact.ancf.slender.strains import Measure
from fecontact.ancf.system.member import Drawing
from fecontact.ancf.system.memory import Remembering, Strained
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among
from fecontact.common.errors import InputError

#: Gauss points and weights of the straight step between two states: the mean of the forces there does the work of the
#: energy's change, to the sixth power of the strains of a step. Source: the average vector field of R. I. McLachlan,
#: G. R. W. Quispel & N. Robidoux, Phil. Trans. R. Soc. A 357 (1999).
BETWEEN = tuple(((1 + x) / 2, w / 2) for x, w in zip(*np.polynomial.legendre.leggauss(3), strict=True))


#: Distance of a point from an axis or middle surface, relative to its extent, below which it lies on it.
ON_AXIS = 1e-6


class HasVectors(Protocol):
    """What the coordinates are made of."""

    @property
    def vectors(self) -> Array:
        """Initial vectors (n_nodes, per_node, 3) of each node."""


class Nodal:
    """A slender structure whose coordinates are those of its nodes' vectors, one after the other."""

    @property
    def n_dofs(self: HasVectors) -> int:
        """Coordinates."""
        return self.vectors.size

    @property
    def q0(self: HasVectors) -> Array:
        """Initial coordinates (n_dofs,)."""
        return self.vectors.ravel()

    @property
    def is_slender(self) -> bool:
        """Yes."""
        return True

    def check_inverted(self, q: Array) -> None:
        """Slender structures have no volume to turn inside out."""

    def place_rows(self: HasVectors, where: Any) -> list[sp.csr_matrix]:
        """Rows (1, n_vectors) of the position and of each gradient at a node.

        Raises
        ------
        InputError
            For unknown nodes, counted from 0 or from the end.
        """
        n_nodes, per_node = self.vectors.shape[:2]
        if not (isinstance(where, int | np.integer) and -n_nodes <= where < n_nodes):
            raise InputError(f"The member has {n_nodes} nodes, counted from 0; found {where!r}.", code="unknown-node")
        rows = sp.eye_array(n_nodes * per_node, format="csr")
        first = per_node * (int(where) % n_nodes)
        return [rows[[first + v]] for v in range(per_node)]


@dataclass(frozen=True, eq=False)
class Part:
    """A part of the energy of every element.

    Attributes
    ----------
    orders : tuple of (int, int, int)
        Derivatives of the position that the measure takes.
    measure : Measure
    rigidity : (m, m) or (n_elements, n_q, m, m) array
        Stress resultants of strains, per unit of `size`.
    points, weights : (n_q, 3) and (n_q,) arrays
        Quadrature on the unit box.
    size : (n_elements,) or (n_elements, n_q) array
        Length, area or volume of each element, and by points where it varies within.
    layers : Layers, optional
        That flow plastically; the rigidity is that of elastic ones.
    """

    orders: tuple[Order, ...]
    measure: Measure
    rigidity: Array
    points: Array
    weights: Array
    size: Array
    layers: Layers | None = None

    @property
    def weighted(self) -> Array:
        """Length, area or volume (n_elements, n_q) or (n_elements, 1) of each point."""
        return np.asarray(self.weights * np.atleast_2d(self.size.T).T)

    def elastic(self, strains: Array) -> Array:
        """Stress resultants (..., n_elements, n_q, m) of strains."""
        if self.rigidity.ndim == 2:
            return np.asarray(strains @ self.rigidity)
        return np.asarray((self.rigidity @ strains[..., None])[..., 0])


@dataclass(frozen=True, eq=False)
class Structure(Nodal, Remembering):
    """Elements of one shape, joined at their nodes.

    Parameters
    ----------
    shape : Shape
    vectors : (n_nodes, per_node, 3) array
        Initial position and gradients of each node.
    cells : (n_elements, n) int array
        Nodes of each element.
    lengths : (n_elements, 3) array
        Of each element along its own axes.
    parts : sequence of Part
    inertia : (points, weights, size)
        Quadrature of the mass: weights include the density.
    viscous : Viscosity, optional
        Damper and branches beside the rigidities, see `damped`.
    frames : (n_elements, n_nodes, n, n) array, optional
        Derivatives along each element's own axes at its nodes by the nodes' own; equal unless given.

    Raises
    ------
    InputError
        For shapes that do not fit.
    """

    shape: Shape
    vectors: Array
    cells: IntArray
    lengths: Array
    parts: Sequence[Part]
    inertia: tuple[Array, Array, Array]
    viscous: Viscosity | None = None
    frames: Array | None = None

    def __post_init__(self) -> None:
        if self.vectors.shape[1:] != (self.shape.per_node, 3) or not np.isfinite(self.vectors).all():
            raise InputError(
                f"A node of a {self.shape.name} has {self.shape.per_node} vectors of three finite numbers; found an "
                f"array {self.vectors.shape}."
            )

    @property
    def name(self) -> str:
        """Of its elements."""
        return self.shape.name

    @property
    def n_along(self) -> int:
        """Gradients along the axis, 1, or the middle surface, 2."""
        return 1 if len(self.shape.nodes) == 2 else 2

    def damped(self, retardation: float) -> Self:
        """The same structure with Kelvin and Voigt's damper: stress resultants t_r D de/dt beside D e.

        A free vibration of angular frequency w is damped by the ratio t_r w / 2; a rigid motion is not.
        Source: D. Garcia-Vallejo, J. Valverde & J. Dominguez, Nonlinear Dynamics 42 (2005), 347-369.

        Raises
        ------
        InputError
            For a time that is not positive.

        Examples
        --------
        >>> from fecontact.ancf.slender import line
        >>> line(straight((0, 0, 0), (1, 0, 0), 1), EA=1.0, EI=1.0).damped(0.1).viscous
        Viscosity(retardation=0.1, prony=(), newtonian=0.0)
        """
        return replace(self, viscous=Viscosity(retardation))

    def side(self, offset: float = 0.0, elements: Sequence[int] | None = None) -> Skin:
        """The skin as a side of a `Contact`.

        Of two members that run along each other the one with the longer elements should be the slave, or pressures
        alternate. Of a plate and another member, the plate is the master.

        Parameters
        ----------
        offset : float
            Distance of the skin from the axis or middle surface: a radius, or half a thickness.
        elements : sequence of int, optional
            Elements that may touch; all unless given.

        Raises
        ------
        InputError
            For unknown elements, or an offset that is negative or not a number.

        Examples
        --------
        >>> import fecontact as fc
        >>> from fecontact.ancf import Assembly
        >>> from fecontact.ancf.slender import line, straight
        >>> cable = line(straight((0, 0, 0.1), (1, 0, 0.1), 4), EA=1.0, EI=1.0)
        >>> post = line(straight((0.4, -1, -0.1), (0.4, 1, -0.1), 3), EA=1.0, EI=1.0)
        >>> contacts = [fc.Contact(cable.side(0.1), other) for other in (fc.RigidBody(fc.Plane()), post.side(0.05))]
        >>> a = Assembly([cable, post], [], contacts)
        >>> [float(abs(part.gap[1]).round(12)) for part in a.conditions(a.q0).parts]
        [0.0, 0.05]
        """
        return Skin(self, offset, elements)

    def positions(self, q: Array) -> Array:
        """Nodes (n_nodes, 3)."""
        return q.reshape(self.vectors.shape)[:, 0]

    def gradients(self, q: Array) -> Array:
        """Gradients (n_nodes, n, 3)."""
        return q.reshape(self.vectors.shape)[:, 1:]

    @property
    def extent(self) -> float:
        """Largest extent of its nodes."""
        return float(np.ptp(self.vectors[:, 0], axis=0).max())

    @cached_property
    def scales(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths: one, and an element's length."""
        each = np.full(self.vectors.shape, self.lengths[:, 0].mean())
        each[:, 0] = 1.0
        return each.ravel()

    def translation(self, direction: Array) -> Array:
        """Change (n_dofs,) of the coordinates by a translation (3,)."""
        out = np.zeros(self.vectors.shape)
        out[:, 0] = direction
        return out.ravel()

    def turn(self, axis: Array, point: Array) -> Array:
        """Change (n_dofs,) of the initial coordinates by a small turn about an axis (3,) through a point (3,)."""
        arms = self.vectors.copy()
        arms[:, 0] -= point
        return np.cross(axis, arms).ravel()

    @property
    def rigid_modes(self) -> Array:
        """Changes (n_dofs, 6) by the rigid motions about the middle of the nodes."""
        middle, axes = self.vectors[:, 0].mean(axis=0), np.eye(3)
        return np.stack([*map(self.translation, axes), *(self.turn(e, middle) for e in axes)], axis=1)

    @cached_property
    def functions(self) -> IntArray:
        """Numbers (n_elements, n_functions) of each element's vectors of coordinates."""
        k = self.shape.per_node
        return (k * self.cells[:, :, None] + np.arange(k)).reshape(len(self.cells), -1)

    def rows(self, points: Array, order: Order = (0, 0, 0)) -> Array:
        """Derivatives (n_elements, n_points, n_functions) of the functions along the elements' axes, see `Shape`."""
        return self._by_nodes(self.shape.functions(self.lengths, points, order), self.frames)

    def rows_each(self, each: IntArray, points: Array, order: Order = (0, 0, 0)) -> Array:
        """Derivatives (n, n_functions) at a point (n, 3) of each element (n,), by coordinates of the unit box."""
        values = self.shape.functions_each(self.lengths[each], points, order)
        return self._by_nodes(values[:, None], None if self.frames is None else self.frames[each])[:, 0]

    def _by_nodes(self, values: Array, frames: Array | None) -> Array:
        """Functions (n, n_q, n_functions) of gradients along elements' axes, as those of the nodes' own."""
        if frames is None:
            return values
        split = values.reshape(*values.shape[:2], len(self.shape.nodes), self.shape.per_node).copy()
        split[..., 1:] = np.einsum("eqad,eadg->eqag", split[..., 1:], frames)
        return split.reshape(values.shape)

    def fields(self, points: Array, orders: Sequence[Order]) -> Array:
        """Derivatives (n_elements, n_q, n_g, 3) of the initial position."""
        vectors = self.vectors.reshape(-1, 3)[self.functions]
        return np.stack([self.rows(points, order) @ vectors for order in orders], axis=2)

    @cached_property
    def _derivatives(self) -> list[Array]:
        """Of each part (n_elements, n_q * n_g, n_functions)."""
        out = []
        for part in self.parts:
            each = [self.rows(part.points, order) for order in part.orders]
            out.append(np.stack(each, axis=2).reshape(len(self.cells), -1, self.shape.n_functions))
        return out

    @cached_property
    def _initial(self) -> list[Array]:
        """Strains of each part in the initial shape, which is free of stress."""
        return [p.measure.strain(self._fields(self.q0, k)) for k, p in enumerate(self.parts)]

    def _fields(self, q: Array, k: int) -> Array:
        """Derivatives (n_elements, n_q, n_g, 3) of part k."""
        part = self.parts[k]
        fields = self._derivatives[k] @ q.reshape(-1, 3)[self.functions]
        return np.asarray(fields.reshape(len(self.cells), len(part.points), len(part.orders), 3))

    def strains(self, q: Array, k: int) -> Array:
        """Strains (n_elements, n_q, m) of part k."""
        return self.parts[k].measure.strain(self._fields(q, k)) - self._initial[k]

    def energy(self, q: Array) -> float:
        """Strain energy."""
        total = 0.0
        for k, part in enumerate(self.parts):
            total += float((part.weighted * self._responses(k, self.strains(q, k))[0]).sum())
        return total

    def angles(self, q: Array) -> Array:
        """Angles (n_nodes,) of the first gradients in the plane x, y, followed from node to node."""
        t = self.gradients(q)[:, 0]
        return np.asarray(np.unwrap(np.arctan2(t[:, 1], t[:, 0])))

    def place_rows(self, where: Any) -> list[sp.csr_matrix]:
        """Rows (n, n_vectors) of the position and the gradients at a node, or at points (3,) or (n, 3) of the axis.

        Raises
        ------
        InputError
            For unknown nodes, and for points off the initial axis or middle surface.
        """
        if np.ndim(where) == 0:
            return super().place_rows(where)
        points = np.atleast_2d(np.asarray(where, dtype=float))
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise InputError(f"A place is a node, or points of three finite numbers; found {where!r}.", code="place")
        each, local = self.middle.project(self.q0, points)
        rows = self.middle.matrix(each, local)
        off = np.linalg.norm(rows @ self.q0.reshape(-1, 3) - points, axis=1).max()
        if off > ON_AXIS * self.extent:
            raise InputError(
                f"The point {points[0].tolist()} lies off the axis or middle surface of the {self.name}, by {off:.3g}; "
                "give one on it. A force beside it is a force on it and a `Moment`.",
                code="off-axis",
            )
        at = np.zeros((len(points), 3))
        at[:, : self.n_along] = local
        out, columns = [rows], self.functions[each]
        for order in self.shape.orders[1:]:
            values = self.rows_each(each, at, order) / np.prod(self.lengths[each] ** np.array(order), axis=1)[:, None]
            row = np.arange(len(each)).repeat(values.shape[1])
            out.append(sp.csr_matrix((values.ravel(), (row, columns.ravel())), shape=rows.shape))
        return out

    @property
    def joining(self) -> None:
        """Nothing: elements share the vectors of their nodes."""

    def spread(self, q: Array) -> Array:
        """Its vectors (n_vectors, 3)."""
        return q.reshape(-1, 3)

    def gather(self, f: Array) -> Array:
        """Generalised forces (n_dofs,) from those on its vectors (n_vectors, 3)."""
        return f.ravel()

    def surface_rule(self, boundary: str) -> tuple[IntArray, Array, Array, Array]:
        """Quadrature on its axis or on a side of its middle surface, see `AncfSpace.surface_rule`.

        Raises
        ------
        InputError
            For other names than "axis" of a line, a strip or a beam, and "top" and "bottom" of a plate.
        """
        names = {"axis": (0,)} if self.n_along == 1 else {"top": (0, 1), "bottom": (1, 0)}
        among(f"boundary of a {self.name}", boundary, tuple(names))
        x, w = np.polynomial.legendre.leggauss(4)
        grid = np.stack(np.meshgrid(*[(1 + x) / 2] * self.n_along, indexing="ij"), axis=-1).reshape(-1, self.n_along)
        points = np.zeros((len(grid), 3))
        points[:, : self.n_along] = grid
        weights = w / 2 if self.n_along == 1 else np.outer(w, w).ravel() / 4
        S = self.rows(points)
        along = [self.rows(points, (1 - d, d, 0)) * self.lengths[:, d, None, None] for d in names[boundary]]
        return self.functions, S, np.stack(along, axis=-1), weights

    @cached_property
    def kept(self) -> dict[Any, Any]:
        """What loads need in every iteration."""
        return {}

    def gradient_weights(self, node: Any) -> Array:
        """B (n_vectors, 3) of what turns at a node, sum_f q_f (x) B_f: a section, a middle surface, or a tangent.

        The other gradients turn with it by shear: a moment on them would shear the elements at the node by M / (G A l).

        Raises
        ------
        InputError
            For unknown nodes.
        """
        rows = super().place_rows(node)[1:]
        rows = rows[:2] if self.n_along == 2 else rows[len(rows) > 1 :]
        axes = np.concatenate([r @ self.q0.reshape(-1, 3) for r in rows])
        return np.asarray(sp.vstack(rows).T @ np.linalg.pinv(axes).T)

    @cached_property
    def middle(self) -> Middle:
        """Its axis or middle surface."""
        return Middle(self, 0)

    def forces(self, q: Array) -> Array:
        """Elastic forces (n_dofs,), the gradient of the energy."""
        return self._forces(q[None], np.ones(1))

    def _forces(self, states: Array, shares: Array, stresses: Sequence[Array] | None = None) -> Array:
        """Sum (n_dofs,) of the elastic forces of some states (m, n_dofs) with their shares (m,), all at once.

        Or of given stress resultants (n_elements, n_q, m) of the parts.
        """
        m, n = len(states), len(self.cells)
        total = np.zeros((n, self.shape.n_functions, 3))
        vectors = states.reshape(m, -1, 3)[:, self.functions]
        for k, (part, derivatives) in enumerate(zip(self.parts, self._derivatives, strict=True)):
            g = (derivatives @ vectors).reshape(m, n, len(part.points), len(part.orders), 3)
            weights = shares[:, None, None, None] * part.weighted[..., None]
            each = stresses[k] if stresses else self._responses(k, part.measure.strain(g) - self._initial[k])[1]
            stress = each * weights
            J = part.measure.first(g)
            along = (stress[..., None, :] @ J.reshape(*J.shape[:4], -1)).reshape(m, n, -1, 3)
            total += (np.swapaxes(derivatives, 1, 2) @ along).sum(axis=0)
        return self._gathered(total)

    @property
    def n_flowing(self) -> int:
        """Numbers that plastic flow remembers."""
        return sum(map(math.prod, self._memories))

    @cached_property
    def _memories(self) -> list[tuple[int, ...]]:
        """Shape of what plastic flow remembers in each part."""
        n = len(self.cells)
        return [(0,) if p.layers is None else (n, len(p.points), len(p.layers.areas), 2) for p in self.parts]

    def _share(self) -> None:
        _ = self._derivatives, self._initial, self._by_component, self._pattern

    def _remembered(self, k: int) -> Array:
        """What plastic flow remembers in part k."""
        start = sum(map(math.prod, self._memories[:k]))
        return self.memory[start : start + math.prod(self._memories[k])].reshape(self._memories[k])

    def _flowing(self) -> Iterator[tuple[int, Part, Layers]]:
        """Parts whose layers may flow, by number."""
        for k, part in enumerate(self.parts):
            if part.layers is not None:
                yield k, part, part.layers

    def flowed(self, q: Array) -> Array:
        """The memory of plastic flow (n,) after a step to coordinates q."""
        each = [
            layers.returned(self.strains(q, k), self._remembered(k)).memory.ravel() for k, _, layers in self._flowing()
        ]
        return np.concatenate([np.zeros(0), *each])

    @property
    def dissipated(self) -> float:
        """Energy lost to plastic flow up to its memory."""
        return sum(
            layers.dissipated(self._remembered(k)[..., -1], part.weighted) for k, part, layers in self._flowing()
        )

    @property
    def plastic_strain(self) -> Array:
        """Accumulated plastic strain (n_elements, n_q, n_layers) of layers at the points of an element."""
        each = [self._remembered(k)[..., -1] for k, *_ in self._flowing()]
        return np.concatenate(each, axis=1) if each else np.zeros((len(self.cells), 0, 0))

    def _responses(self, k: int, e: Array) -> tuple[Array, Array, Array]:
        """Energy (...), stress resultants (..., m) and moduli (.., m, m) of strains (..., m) of part k."""
        part = self.parts[k]
        if part.layers is not None:
            return part.layers.respond(e, self._remembered(k))
        stress = part.elastic(e)
        return (stress * e).sum(axis=-1) / 2, stress, part.rigidity

    def strained(self) -> list[Strained]:
        """Strains of its parts."""
        return [
            Strained(partial(self.strains, k=k), part.elastic, None, part.weighted) for k, part in enumerate(self.parts)
        ]

    def step_forces(self, q0: Array, q1: Array, stresses: Sequence[Array]) -> Array:
        """Forces (n_dofs,) whose work from q0 to q1 is that of stresses by the change of strains, see `BETWEEN`."""
        x, shares = np.array(BETWEEN).T
        return self._forces(q0 + x[:, None] * (q1 - q0), shares, stresses)

    def viscous_tangent(self, q: Array, h: float) -> sp.csr_matrix:
        """Derivative (n_dofs, n_dofs) of the forces of a step of length h by its end, without that of the stress."""
        assert self.viscous is not None
        return self._tangent(q, stiffening(self.viscous, h), False)

    def tangent(self, q: Array) -> sp.csr_matrix:
        """Derivative (n_dofs, n_dofs) of the elastic forces."""
        return self._tangent(q, 1.0, True)

    def _tangent(self, q: Array, share: float, stressed: bool) -> sp.csr_matrix:
        """By a share of the rigidities, and by the present stress."""
        n, width = len(self.cells), 3 * self.shape.n_functions
        total = np.zeros((n, width, width))
        for k, part in enumerate(self.parts):
            g = self._fields(q, k)
            w = part.weighted[..., None]
            _, stress, moduli = self._responses(k, part.measure.strain(g) - self._initial[k])
            J = part.measure.first(g).reshape(n, len(part.points), part.rigidity.shape[-1], -1)
            if not stressed:
                moduli = share * part.rigidity
            inner = np.swapaxes(J, 2, 3) @ (moduli @ J * w[..., None])
            if stressed:
                inner += part.measure.second(g, stress * w).reshape(inner.shape)
            B = self._by_component[k]
            total += np.swapaxes(B.reshape(n, -1, width), 1, 2) @ (inner @ B).reshape(n, -1, width)
        return self._summed(total)

    @cached_property
    def _by_component(self) -> list[Array]:
        """Derivatives of each part for all components (n_elements, n_q, 3 n_g, 3 n_functions)."""
        out, n = [], self.shape.n_functions
        for part, derivatives in zip(self.parts, self._derivatives, strict=True):
            B = derivatives.reshape(len(self.cells), len(part.points), len(part.orders), 1, n, 1)
            wide = B * np.eye(3)[:, None, :]
            out.append(wide.reshape(len(self.cells), len(part.points), 3 * len(part.orders), 3 * n))
        return out

    @cached_property
    def _pattern(self) -> tuple[IntArray, IntArray, IntArray]:
        """Sparsity of the tangent: row pointers, columns, and the place of every entry of the elements' matrices."""
        dofs = (3 * self.functions[:, :, None] + np.arange(3)).reshape(len(self.cells), -1)
        keys, place = np.unique(dofs[:, :, None] * self.n_dofs + dofs[:, None, :], return_inverse=True)
        rows, columns = np.divmod(keys, self.n_dofs)
        return np.searchsorted(rows, np.arange(self.n_dofs + 1)), columns, place.ravel()

    def _summed(self, blocks: Array) -> sp.csr_matrix:
        pointer, columns, place = self._pattern
        data = np.bincount(place, blocks.ravel(), minlength=len(columns))
        return sp.csr_matrix((data, columns, pointer), shape=(self.n_dofs, self.n_dofs))

    def _gathered(self, nodal: Array) -> Array:
        """Sum (n_dofs,) of the elements' vectors (n_elements, n_functions, 3)."""
        numbers = self.functions.ravel()
        flat = nodal.reshape(-1, 3)
        each = [np.bincount(numbers, c, self.n_dofs // 3) for c in flat.T]
        return np.stack(each, axis=1).astype(float).ravel()

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """Consistent mass (n_dofs, n_dofs), constant in any motion."""
        points, weights, size = self.inertia
        S = self.rows(points)
        blocks = np.einsum("eq,eqa,eqb->eab", weights * np.atleast_2d(size.T).T, S, S, optimize=True)
        whole = np.einsum("eab,xy->eaxby", blocks, np.eye(3))
        return self._summed(whole)

    def forces_between(self, q0: Array, q1: Array) -> Array:
        """Elastic forces (n_dofs,) whose work from q0 to q1 is the change of energy, see `BETWEEN`."""
        x, w = np.array(BETWEEN).T
        return self._forces(q0 + x[:, None] * (q1 - q0), w)

    def drawn(self, q: Array) -> Drawing:
        """Nine points along the axis of every element; the corners of plates."""
        if len(self.shape.nodes) > 2:
            at, now = self.vectors[:, 0], self.positions(q)
            return Drawing("quad", at, now, self.cells, np.zeros((len(at), 6)))
        start, now = self.points(self.q0), self.points(q)
        number = np.arange(start.shape[0] * start.shape[1]).reshape(start.shape[:2])
        lines = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
        return Drawing("line", start.reshape(-1, 3), now.reshape(-1, 3), lines, np.zeros((number.size, 6)))

    def points(self, q: Array, n: int = 9) -> Array:
        """Points (n_elements, n, 3) along the axis of every element, or the edge y = 0 of a plate."""
        x = np.zeros((n, 3))
        x[:, 0] = np.linspace(0, 1, n)
        return np.asarray(self.rows(x) @ q.reshape(-1, 3)[self.functions])


def straight(start: ArrayLike, end: ArrayLike, n: int) -> Array:
    """Points (n + 1, 3) of n equal elements from start to end."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    return a + np.linspace(0, 1, n + 1)[:, None] * (b - a)


def axis_of(points: Array, tangents: ArrayLike | None) -> tuple[Array, IntArray, Array]:
    """Unit tangents at the nodes, elements and their lengths along an axis of nodes in order."""
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise InputError(f"An axis needs two nodes or more, (n, 3); found an array {points.shape}.", code="axis-nodes")
    chords = np.diff(points, axis=0)
    lengths_ = np.linalg.norm(chords, axis=1)
    if not (lengths_ > 0).all():
        raise InputError(f"Elements must have lengths; {(~(lengths_ > 0)).sum()} have none.", code="zero-length")
    if tangents is None:
        if not np.allclose(np.cross(chords, chords[0]), 0.0, atol=1e-12 * lengths_.max() ** 2):
            raise InputError("The axis is not straight: give the unit tangents at its nodes, tangents=.", code="bent")
        t = np.repeat(chords[:1] / lengths_[0], len(points), axis=0)
    else:
        t = np.asarray(tangents, dtype=float)
        if t.shape != points.shape or not np.allclose(np.linalg.norm(t, axis=1), 1.0):
            raise InputError(f"tangents must be unit vectors {points.shape}; found an array {t.shape}.", code="tangent")
        # length of the cubic through both ends, by arcs: chord times angle over twice its sine
        half = np.arccos(np.clip((t[1:] * t[:-1]).sum(axis=1), -1.0, 1.0)) / 2
        lengths_ = lengths_ / np.sinc(half / np.pi)
    return t, np.stack([np.arange(len(points) - 1), np.arange(1, len(points))], axis=1), lengths_


def axes_of(
    points: ArrayLike | Sequence[ArrayLike], tangents: ArrayLike | None
) -> tuple[Array, Array, IntArray, Array]:
    """Nodes (n, 3), unit tangents, elements and lengths of one axis, or of several straight ones in order."""
    if np.ndim(points[0]) == 1:  # type: ignore[index]
        return np.asarray(points, dtype=float), *axis_of(np.asarray(points, dtype=float), tangents)
    if tangents is not None:
        raise InputError("Tangents are for one curved axis; several axes in one structure are straight.", code="axes")
    nodes = [np.asarray(axis, dtype=float) for axis in points]  # type: ignore[union-attr]
    found = [axis_of(axis, None) for axis in nodes]
    starts = np.cumsum([0] + [len(axis) for axis in nodes])
    cells = np.concatenate([cells + start for (_, cells, _), start in zip(found, starts, strict=False)])
    t, size = (np.concatenate([each[k] for each in found]) for k in (0, 2))
    return np.concatenate(nodes), t, cells, size
