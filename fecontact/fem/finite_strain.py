"""Energy, internal forces and tangent of bodies at finite strain, cell by cell in batches.

The stiffness is the tangent of the internal forces in the present shape: spatial gradients g = F^-T G, moduli c and the
stress tau in g_a . tau g_b (Bonet & Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008, sections 9.3
and 9.4), of which `pair_stiffness` makes the isotropic part.

The pressure p of the energy kappa/2 (ln J)^2 is an unknown at its points, eliminated there: its equation p = kappa ln J
is linearised with the others, p' = kappa (ln J + div du). With it in place of kappa ln J in the tangent Newton's method
does not take the second order of a change of volume for a pressure, which near nu = 1/2 would cost it all its reach
(Simo, Taylor & Pister, Comput. Methods Appl. Mech. Eng. 51 (1985) 177). Forces are those of displacements alone, as in
the eliminated equations. Near nu = 1/2 the points are those of a lower order against locking (Malkus & Hughes, Comput.
Methods Appl. Mech. Eng. 15 (1978) 63: they are a pressure of that order), with the gradients of `with_means`.
"""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.fem.element_stiffness import inverse_3x3, pair_stiffness, upper_pairs
from fecontact.fem.energy_error import EnergyError
from fecontact.fem.laws import Law, determinants, isotropic
from fecontact.fem.model import Model
from fecontact.fem.section_model import SectionModel
from fecontact.fem.stiffness import (
    ENTRIES,
    Batch,
    Cells,
    batches,
    moduli_stiffness,
    nodal_forces,
    sum_of_blocks,
)
from fecontact.fem.stress import components, hooke_inverse, to_nodes
from fecontact.fem.support import support_directions
from fecontact.mesh.mesh import Mesh

#: Stiffness of springs over the median of their rows by the diagonal of the tangent: far above that of the body as a
#: whole, and low enough to lose few digits.
STRENGTH = 100.0
#: Difference of unit normals of a flat boundary.
FLAT = 1e-6


def deformation(batch: Batch, u: Array) -> Array:
    """Deformation gradients (n_cells, n_q, 3, 3) by displacements (n_points, 3) of nodes."""
    return np.eye(3) + np.swapaxes(batch.displacement_gradients(u), -1, -2)


def deformed(batch: Batch, F: Array) -> Batch:
    """The batch with gradients in the present shape, and volumes of the initial one."""
    inverse, _ = inverse_3x3(F)
    hoop = None if batch.hoop is None else batch.hoop / F[..., 1, 1, None]
    return replace(batch, gradients=batch.gradients @ inverse, hoop=hoop)


def tangent_blocks(batch: Batch, stress: Array, lame: Array, shear: Array, moduli: Array | None) -> Array:
    """Stiffness (n_cells, n_pairs, 9) of stresses and spatial moduli, pairs as in `upper_pairs`."""
    n, _, m, _ = batch.gradients.shape
    if moduli is None and batch.hoop is None:
        one, weighted = np.ones(n), replace(batch, dV=batch.dV * shear)
        K = pair_stiffness(weighted, one, one, replace(batch, dV=batch.dV * lame))
    else:
        K = moduli_stiffness(batch, isotropic(lame, shear) + (0.0 if moduli is None else moduli))
    first, second = upper_pairs(m)
    g = batch.gradients.transpose(0, 1, 3, 2).reshape(n, -1, m)
    pulled = (stress * batch.dV[..., None, None]) @ np.swapaxes(batch.gradients, 2, 3)
    bent = (np.swapaxes(pulled.reshape(n, -1, m), 1, 2) @ g)[:, first, second]
    for k in (0, 4, 8):
        K[..., k] += bent
    if batch.hoop is not None:
        weighted_hoop = batch.hoop * (stress[..., 1, 1] * batch.dV)[..., None]
        K[..., 0] += (np.swapaxes(weighted_hoop, 1, 2) @ batch.hoop)[:, first, second]
    return K


@dataclass(frozen=True, eq=False)
class Part:
    """Cells of one law.

    Attributes
    ----------
    law : Law
    points : Batch
    volume : Batch
        Where kappa/2 (ln J)^2 is integrated: `points` unless it is at points of a lower order.
    carry : (n_q, n_reduced) array
        Values at `points` by those at the latter.
    """

    law: Law
    points: Batch
    volume: Batch
    carry: Array

    @property
    def together(self) -> bool:
        """Whether both are the same points."""
        return self.volume is self.points


@dataclass(frozen=True, eq=False)
class State:
    """State of a body.

    Attributes
    ----------
    u : (n_dofs,) array
        Displacements in the body's axes.
    pressures : tuple of (n_cells, n_q) arrays
        The unknown p of each part: kappa ln J at equilibrium.
    """

    u: Array
    pressures: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Inner:
    """What the cells of a body give at a state: energy, internal forces (n_dofs,) and the tangent's upper triangle."""

    energy: float
    forces: Array
    stiffness: sp.csr_matrix | None


class FiniteStrain:
    """Cells of a model with hyperelastic laws.

    Parameters
    ----------
    model : Model
        Of the laws' materials at rest.
    laws : sequence of Law
        One for each of its materials.

    Raises
    ------
    InputError
        Where a body, or a law with Poisson's ratio above 0.48, has no form that does not lock, or a curved boundary is
        held along its normal.
    """

    def __init__(self, model: Model, laws: Sequence[Law]) -> None:
        self.model, self.laws = model, tuple(laws)
        if model.selective:
            for law in laws:
                if not law.bulk:
                    raise InputError(
                        f"{type(law).__name__} has no volumetric part to integrate apart: near nu = 1/2 take "
                        "NeoHookean, MooneyRivlin or Ogden, or integration='full'.",
                        code="no-volumetric-part",
                    )
        if isinstance(model, SectionModel) and (model.plane_stress or model.out_of_plane.torsion):
            what = "plane stress" if model.plane_stress else "torsion"
            raise InputError(
                f"A law of finite strain is not offered with {what}: give a body in space.",
                code="finite-strain-section",
            )
        for law in laws:  # refuses bad directions now
            law.at(model.mesh.points[model.mesh.cells].mean(axis=1), isinstance(model, SectionModel))
        for name, support in model.supports.items():
            if isinstance(support, str) and "n" in support:
                normals = support_directions(model.mesh, name, "n")[1][:, 0]
                if np.abs(normals - normals[0]).max() > FLAT:
                    raise InputError(
                        f"The boundary {name!r} is curved: points held along its normal 'n' would stay in their first "
                        "tangent plane at finite strain. Name flat parts or give a direction.",
                        code="finite-strain",
                    )

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The cells in batches of one kind and one law."""
        return tuple(self._parts())

    def _parts(self) -> Iterator[Part]:
        model = self.model
        for group in model.elements.groups:
            cells = Cells(model.elements.points, (group,), model.elements.count)
            size = max(1, ENTRIES // (9 * group.nodes.shape[1] ** 2))
            full = batches(cells, size)
            carry = group.element.carry() if model.selective else np.zeros((0, 0))
            reduced = batches(cells, size, reduced=True) if model.selective else itertools.repeat(None)
            for one, other in zip(full, reduced, strict=False):
                for k, law in enumerate(self.laws):
                    own = model.material_of_cell[one.cells] == k
                    if own.any():
                        points = _chosen(one, own)
                        placed = law.at(points.N @ model.mesh.points[points.nodes], isinstance(model, SectionModel))
                        yield Part(placed, points, points if other is None else _chosen(other, own), carry)

    @property
    def rest(self) -> State:
        """The state without load."""
        return State(np.zeros(self.model.n_dofs), tuple(np.zeros(p.volume.dV.shape) for p in self.parts))

    def at(self, state: State, tangent: bool = True) -> Inner:
        """Energy, forces and, if asked for, the tangent at a state.

        Raises
        ------
        InvertedError
            If det F <= 0 at a point.
        """
        u = state.u.reshape(-1, 3)
        forces, energy = np.zeros_like(u), 0.0
        blocks: list[Array] = []
        for part, p in zip(self.parts, state.pressures, strict=True):
            F = deformation(part.points, u)
            J = determinants(F)
            found, now = part.law.distortion(F, J), deformed(part.points, F)
            volume = now
            if not part.together:
                F = deformation(part.volume, u)
                J, volume = determinants(F), deformed(part.volume, F)
            y = np.log(J)
            pressure = part.law.bulk * y
            energy += float((found.energy * now.dV).sum() + (pressure * y / 2 * volume.dV).sum())
            own = nodal_forces(now, found.stress) + nodal_forces(volume, pressure[..., None, None] * np.eye(3))
            np.add.at(forces, now.nodes, own)
            if not tangent:
                continue
            pushed = p[..., None, None] * np.eye(3)
            lame, kappa = found.lame, np.full_like(p, part.law.bulk)
            if part.together:
                K = tangent_blocks(now, found.stress + pushed, lame + kappa, found.shear - p, found.moduli)
            else:
                K = tangent_blocks(now, found.stress, lame, found.shear, found.moduli)
                K += tangent_blocks(volume, pushed, kappa, -p, None)
            blocks.append(K.reshape(-1, 9))
        stiffness = None
        if tangent:
            first, second = self._pairs
            stiffness = sum_of_blocks(first, second, np.concatenate(blocks), len(u))
        return Inner(energy, forces.ravel(), stiffness)

    @cached_property
    def _pairs(self) -> tuple[IntArray, IntArray]:
        """Nodes of the pairs of all blocks."""
        out = []
        for part in self.parts:
            nodes = part.points.nodes
            out.append([nodes[:, k].ravel() for k in upper_pairs(nodes.shape[1])])
        first, second = (np.concatenate(each) for each in zip(*out, strict=True))
        return first, second

    def advanced(self, state: State, du: Array, share: float = 1.0) -> State:
        """The state after a share of a step du (n_dofs,) of Newton's method, with its pressures."""
        u, v = state.u.reshape(-1, 3), du.reshape(-1, 3)
        pressures = []
        for part, p in zip(self.parts, state.pressures, strict=True):
            F = deformation(part.volume, u)
            linear = np.log(determinants(F)) + deformed(part.volume, F).volume_change(v)
            pressures.append(p + share * (part.law.bulk * linear - p))
        return State(state.u + share * du, tuple(pressures))

    def fields(self, u: Array) -> tuple[Array, Array]:
        """Cauchy stress and logarithmic strain (n_cells, n_q, 6) at the Gauss points, by displacements (n_dofs,)."""
        u = u.reshape(-1, 3)
        n_q = max(part.points.dV.shape[1] for part in self.parts)
        stress, strain = (np.full((self.model.elements.count, n_q, 6), np.nan) for _ in range(2))
        for part in self.parts:
            F = deformation(part.points, u)
            J = determinants(F)
            y = np.log(determinants(deformation(part.volume, u)))
            if not part.together:  # the change of volume that the energy sees, as `fem.stress.gauss_strain`
                y = y @ part.carry.T
                F, J = F * np.cbrt(np.exp(y) / J)[..., None, None], np.exp(y)
            tau = part.law.distortion(F, J).stress + (part.law.bulk * y)[..., None, None] * np.eye(3)
            squares, axes = np.linalg.eigh(F @ np.swapaxes(F, -1, -2))
            logarithm = (axes * (np.log(squares) / 2)[..., None, :]) @ np.swapaxes(axes, -1, -2)
            place = part.points.cells, slice(None, J.shape[1])
            stress[place], strain[place] = components(tau / J[..., None, None]), components(logarithm)
        return stress, strain

    def nodal(self, values: Array, cells: IntArray | None = None) -> Array:
        """Values (n_cells, n_q, k) of Gauss points at the nodes (n_points, k), averaged over all cells or some."""
        return to_nodes(self.model.elements, values, cells)


def _chosen(batch: Batch, cells: Mask) -> Batch:
    """Some cells (n_cells,) of a batch."""
    if cells.all():
        return batch
    hoop = None if batch.hoop is None else batch.hoop[cells]
    return Batch(batch.cells[cells], batch.nodes[cells], batch.N, batch.gradients[cells], batch.dV[cells], hoop)


class AtState(Model):
    """A model at a state of finite strain: the mesh at the deformed points, the tangent for the stiffness.

    Displacements are changes of the state. Supports hold the coordinates of the initial shape, mass is that of the
    initial volume, and motions turn about its centre.
    """

    #: A border makes the factor one of an indefinite matrix, as the tangent may be.
    way = "columns"
    inner: Inner
    finite: FiniteStrain
    state: State
    springs: sp.csr_matrix | None = None

    @property
    def stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the tangent (n_dofs, n_dofs)."""
        assert self.inner.stiffness is not None
        return self.inner.stiffness

    def solved_stiffness(self) -> sp.csr_matrix:
        """Upper triangle of the tangent over the solved coordinates, with springs if there are any."""
        K = super().solved_stiffness()
        return K if self.springs is None else K + self.springs

    def add(self, stiffness: sp.csr_matrix) -> None:
        """Add a symmetric stiffness (n_dofs, n_dofs) to the tangent, before it is factorised."""
        self.inner = replace(self.inner, stiffness=self.stiffness + sp.triu(stiffness, format="csr"))

    def unstressed(self) -> Model:
        """The linear model of the present shape, of the materials at rest."""
        rest = self.finite.model
        out = object.__new__(type(rest))
        own = {name: getattr(rest, name) for name in KEPT if hasattr(rest, name)}
        vars(out).update(own, mesh=self.mesh, elements=self.elements)
        return out

    def stiffen(self, rows: sp.csr_matrix) -> float:
        """Take springs along rows (n, n_dofs), see `contact.hold`, in place of others; return their stiffness."""
        if not rows.shape[0]:
            if self.springs is not None:
                self.springs, self.condensation = None, None
            return 0.0
        C, K = self.solved_rows(rows), super().solved_stiffness()
        diagonal = np.abs(K.diagonal())
        compliance = C.multiply(C) @ np.divide(1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > 0)
        strength = STRENGTH / float(np.median(compliance))
        self.springs, self.condensation = sp.triu(strength * (C.T @ C), format="csr"), None
        return strength

    @property
    def mesh_at_rest(self) -> Mesh:
        """The mesh before the deformation."""
        return self.finite.model.mesh

    def body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of a force per mass ``field(points (n, 3)) -> (n, 3)`` of present points."""
        x = self.mesh.points
        f = np.zeros_like(x)
        for part in self.finite.parts:
            b = part.points
            per_mass = field((b.N @ x[b.nodes]).reshape(-1, 3)).reshape(*b.dV.shape, 3)
            np.add.at(f, b.nodes, b.N.T @ (per_mass * (b.dV * self.density[b.cells, None])[..., None]))
        return f.ravel()

    def strain_energy(self, u: Array) -> float:
        """Energy of the state after changes (n_dofs,)."""
        return self.finite.at(replace(self.state, u=self.state.u + u), tangent=False).energy

    def internal_forces(self, u: Array) -> Array:
        """Forces (n_dofs,) inside at the state after changes (n_dofs,)."""
        return self.finite.at(replace(self.state, u=self.state.u + u), tangent=False).forces

    def gauss_strain(self, u: Array) -> Array:
        """Logarithmic strains (n_cells, n_q, 6) at the Gauss points, after changes (n_dofs,) of the state."""
        return self.finite.fields(self.state.u + u)[1]

    def nodal_strain(self, u: Array) -> Array:
        """Logarithmic strains (n_points, 6) at the nodes."""
        return self.finite.nodal(self.gauss_strain(u))

    def nodal_stress(self, u: Array, cells: IntArray | None = None) -> Array:
        """Cauchy stresses (n_points, 6) at the nodes, averaged over all cells, or some."""
        return self.finite.nodal(self.finite.fields(self.state.u + u)[0], cells)

    def energy_error(
        self, u: Array, cells: IntArray, other: Array | None = None, free: Mask | None = None
    ) -> EnergyError:
        """Error of the Cauchy stress on the deformed mesh, in the metric of the moduli at rest.

        To first order it is that of the linear body whose stiffness is the tangent; `other` are changes of the state.
        """
        stress = self.finite.fields(self.state.u + u)[0]
        strain = hooke_inverse(stress, self.lame[:, None], self.shear[:, None])
        return super().energy_error(strain, cells, other, free)


class SectionAtState(AtState, SectionModel):
    """The same of a section."""

    def body_force(self, field: Callable[[Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of a force per mass of present points."""
        return self._moving(super().body_force(field))


#: What a model keeps at a state: all else follows from its points or its stiffness.
KEPT = (
    "supports", "backend", "selective", "coordinates", "held", "material_of_cell", "materials", "lame", "shear",
    "density", "mass_and_centre", "pinned_dofs", "solved_dofs", "out_of_plane", "plane_stress", "dofs_per_node",
    "across", "across_held",
)  # fmt: skip


def at_state(finite: FiniteStrain, state: State) -> AtState:
    """The model at a state, with its tangent.

    Raises
    ------
    InvertedError
        If the state turns material inside out.
    """
    rest = finite.model
    inner = finite.at(state)
    out = object.__new__(SectionAtState if isinstance(rest, SectionModel) else AtState)
    mesh = copy.copy(rest.mesh)
    points = rest.mesh.points + state.u.reshape(-1, 3)
    points.setflags(write=False)
    object.__setattr__(mesh, "points", points)
    own = {name: getattr(rest, name) for name in KEPT if hasattr(rest, name)}
    vars(out).update(
        own, mesh=mesh, elements=replace(rest.elements, points=points), inner=inner, finite=finite, state=state
    )
    return out
