"""Elastic forces, exact tangent, energy and mass of a mesh of bricks, in batches of cells.

With F = sum_a e_a (x) grad S_a, the first Piola-Kirchhoff stress P = F S and its tangent A = dP/dF,

    energy  U = int W dV,     forces  Q_a = int P grad S_a dV,     K_aibj = int grad_J S_a A_iJjL grad_L S_b dV,

    A_iJjL = delta_ij S_JL + F_iM D_MJNL F_jN,     D = dS/dE

(Bonet & Wood 2008, section 9.4; Shabana, sections 4.10 and 5.5). Q is the gradient of U and K that of Q, both exact for
the chosen Gauss rule. A rigid motion r = R X + b has F = R and no forces, at any angle.

Elastic forces between two states whose work is exactly the change of strain energy (discrete gradient).

    Q = int F_mid S* grad S_a dV,    S* = S(E_mid) + (W_1 - W_0 - S(E_mid) : dE) / (dE : dE) dE

with F_mid and E_mid the means of both states and dE = E_1 - E_0, so that Q . (q_1 - q_0) = U_1 - U_0; linear and
angular momentum are conserved too, since S* is symmetric (O. Gonzalez, Exact energy and momentum conserving algorithms
for general models in nonlinear elasticity, Comput. Methods Appl. Mech. Engrg. 190, 2000; J. C. Simo & N. Tarnow, ZAMP
43, 1992, for St. Venant-Kirchhoff, where S* is the mean of both stresses).

A dilatation v that is projected in each cell has the energy lambda/2 (Pv)^2, whose change over a cell is the sum of
lambda P(v_0 + v_1)/2 (v_1 - v_0), as P is self-adjoint; the derivative of v is corrected in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, Literal, cast

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.ancf.bricks.faces import Faces
from fecontact.ancf.bricks.hexahedron import gauss
from fecontact.ancf.bricks.space import AncfSpace, GradientBatch, deformation_gradients
from fecontact.ancf.bricks.tangents import PAIRS, Pattern, element_tangents
from fecontact.ancf.bricks.viscosity import Viscosity, drag, relaxing, viscous_response
from fecontact.ancf.system.member import Drawing
from fecontact.ancf.system.memory import Remembering, Strained
from fecontact.common.anisotropic import DirectedMaterial
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.renamed import warn
from fecontact.common.viscoelastic import Viscoelastic
from fecontact.fem.directed import directed
from fecontact.fem.element_stiffness import determinant_3x3, element_stiffness
from fecontact.fem.laws import InvertedError, Law, Response, StVenantKirchhoff, at_rest, law_of, laws_of
from fecontact.fem.model import materials_of_cells
from fecontact.fem.plastic import Plastic, PlasticLaw, flowing
from fecontact.mesh.element import CORNERS, EDGES

#: Change of strain, relative to the largest strain, below which the second term of S* is rounding.
MIN_CHANGE = 1e-6
#: The same for any strain: energies are rounded to 1e-16 of the modulus, which divided by the change is an error of the
#: stress; without the term the error is the square of the change. Both are equal at the third root of 1e-16.
ROUNDED_CHANGE = 5e-6


def _discrete(rate: Array, difference: Array, change: Array, large: Mask, size: Array) -> Array:
    """A derivative (.., 3, 3) at the middle, corrected along the change such that it gives the difference."""
    missing = difference - (rate * change).sum(axis=(2, 3))
    return np.asarray(rate + np.where(large, missing / np.where(large, size, 1.0), 0.0)[..., None, None] * change)


#: What a solid may be made of.
Solid = Material | DirectedMaterial | Law | Viscoelastic | Plastic
#: Shear modulus over Lame's first one, below which only pressure resists.
FLUID = 1e-7
#: Corners and mid-sides of a cell, in VTK's order.
NODES = np.vstack([CORNERS, CORNERS[EDGES].mean(axis=1)])
#: Bytes of shape functions cached between calls; larger models recompute them.
KEPT_BYTES = 600_000_000


def linear_functions(X: Array) -> Array:
    """1, x, y, z (n, 4) of reference coordinates (n, 3) relative to the middle of the cell."""
    return np.column_stack([np.ones(len(X)), X - 0.5])


@dataclass(frozen=True, eq=False)
class Part:
    """Cells of one law in a batch.

    Attributes
    ----------
    number : int
        Of the batch.
    own : (n_all,) array
        Whether a cell of the batch is among them.
    batch : GradientBatch
        Of these cells alone.
    law : Law
        At their places.
    volume, rest : float
        Factors of its volumetric part and of the rest.
    """

    number: int
    own: Mask
    batch: GradientBatch
    law: Law
    volume: float
    rest: float

    def among_all(self, values: Array) -> Array:
        """Values (n_all, ...) of the batch by those of the cells, zero elsewhere."""
        if self.own.all():
            return values
        out = np.zeros((len(self.own), *values.shape[1:]))
        out[self.own] = values
        return out


@dataclass(frozen=True, eq=False)
class AncfSolid(Remembering):
    """A solid of bricks with an elastic law.

    Parameters
    ----------
    space : AncfSpace
    material : Material, DirectedMaterial, Law, Viscoelastic or Plastic, or mapping of element set to one
        A law of finite strain, such as ``fc.NeoHookean(E=, nu=)``; that of St. Venant and Kirchhoff for a Material, one
        like it for an ``fc.OrthotropicMaterial``.
        Visco-elastic ones relax in motion; statics has their moduli after a long time. Plastic ones keep their volume
        as they flow: take ``volumetric="linear"``.
    law : optional
        Former way to choose the law of Materials; it warns.
    points : {2, 3, 4, 5}
        Gauss points per direction. Two leave 48 zero-energy modes in an element, the others six. Four are exact for
        the linear stiffness of a parallelepiped.
    volumetric : int or "linear", optional
        Against locking of nearly incompressible material. Points per direction, fewer than `points`, at which the
        volumetric part of the law is integrated (selective reduced integration); or ``"linear"``: its dilatation, tr E
        or ln J, is projected on 1, x, y, z in each cell, which keeps pressures accurate at any deformation (J. C. Simo,
        R. L. Taylor & K. S. Pister, Comput. Methods Appl. Mech. Engrg. 51, 1985, with more functions than the mean).
    viscosity : Viscosity, optional
        A damper, for motion in time; statics has the elastic law only.

    Examples
    --------
    >>> import numpy as np, fecontact as fc
    >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    >>> solid = AncfSolid(space, fc.Material(E=1.0, nu=0.0))
    >>> float(round(solid.energy(space.affine(np.diag([1.1, 1.0, 1.0]))), 9))  # E (0.105)^2 / 2
    0.0055125
    """

    space: AncfSpace
    material: Solid | Mapping[str, Solid]
    law: type[Law] | None = None
    points: int = 4
    volumetric: int | Literal["linear"] | None = None
    viscosity: Viscosity | None = None
    _relaxing: tuple[Any, Viscosity | None] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.points not in (2, 3, 4, 5):
            raise InputError(f"points must be 2, 3, 4 or 5 per direction; found {self.points!r}.", code="gauss")
        if self.volumetric not in (None, "linear", *range(1, self.points)):
            raise InputError(
                f"volumetric must be None, 'linear' or a number of points from 1 to {self.points - 1}, fewer than "
                f"points; found {self.volumetric!r}.",
                code="volumetric",
            )
        if self.law is not None:
            material = law_of(self.material, self.law)
            warn("AncfSolid(law=) is now the material, as fecontact.NeoHookean(E=, nu=); law= will be removed.", 4)
            object.__setattr__(self, "material", material)
            object.__setattr__(self, "law", None)
        object.__setattr__(self, "_relaxing", relaxing(directed(flowing(self.material)), self.viscosity))
        for law, rest in zip(self._laws, self.materials, strict=True):
            if self.volumetric is not None and rest.lame and not law.volumetric:
                raise InputError(
                    f"{type(law).__name__} has no volumetric part to integrate apart: take NeoHookean, MooneyRivlin or "
                    "Ogden, or volumetric=None.",
                    code="needs-dilatation",
                )
            if self.volumetric is not None and rest.shear_modulus < FLUID * rest.lame:
                raise InputError(
                    "A liquid takes volumetric=None: where its dilatation is projected, what the projection leaves out "
                    "is unstable under its weight.",
                    code="liquid",
                )
        if self.viscous is not None and not all(law.isotropic for law in self._laws):
            raise InputError("Viscosity is that of isotropic materials; this one has directions.", code="directed")
        if self.n_flowing and self.viscous is not None and len(self.viscous.branches):
            raise InputError(
                "A solid that flows plastically takes a damper, Viscosity(retardation=), but no Prony series.",
                code="prony-series",
            )

    @cached_property
    def _materials(self) -> tuple[IntArray, list[Material]]:
        return materials_of_cells(self.space.mesh, at_rest(self._relaxing[0]))

    @cached_property
    def _laws(self) -> list[Law]:
        """A law for each of the materials."""
        return list(laws_of(law_of(self._relaxing[0], StVenantKirchhoff)))

    @property
    def viscous(self) -> Viscosity | None:
        """Damper, and branches beside the moduli after a long time; None if it is elastic."""
        return self._relaxing[1]

    def side(self, boundary: str) -> Faces:
        """A boundary as a side of a `Contact`.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
        >>> cube = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.3))
        >>> fc.Contact(cube.side("bottom"), fc.RigidBody(fc.Plane()), friction=0.2).mu
        0.2
        """
        self.space.mesh.faces(boundary)
        return Faces(self, boundary)

    @property
    def materials(self) -> list[Material]:
        """Its materials."""
        return self._materials[1]

    def _per_cell(self, name: str) -> Array:
        index, materials = self._materials
        return np.array([getattr(m, name) for m in materials], dtype=float)[index]

    @cached_property
    def lame(self) -> Array:
        """First Lame constant (n_cells,)."""
        return self._per_cell("lame")

    @cached_property
    def shear(self) -> Array:
        """Shear modulus (n_cells,)."""
        return self._per_cell("shear_modulus")

    @cached_property
    def bulk(self) -> Array:
        """Modulus (n_cells,) of the laws' volumetric part."""
        return np.array([law.volumetric for law in self._laws])[self._materials[0]]

    @cached_property
    def density(self) -> Array:
        """Density (n_cells,).

        Raises
        ------
        InputError
            If a material has none.
        """
        if any(m.density is None for m in self._materials[1]):
            raise InputError("Mass and gravity need a density for every material: Material(E, nu, density=...).")
        return self._per_cell("density")

    @cached_property
    def _kept(self) -> dict[int, list[GradientBatch]]:
        return {}

    def _batches(self, points: int) -> Iterable[GradientBatch]:
        """Shape functions at a Gauss rule, cached if memory allows."""
        if points in self._kept:
            return self._kept[points]
        X, W = gauss(points)
        if len(self.space.corners) * len(X) * 32 * 4 * 8 > KEPT_BYTES:
            return self.space.batches(X, W)
        self._kept[points] = list(self.space.batches(X, W))
        return self._kept[points]

    def rules(self) -> list[tuple[Iterable[GradientBatch], float, float]]:
        """Gauss rules, with the factors of the volumetric part and of the rest in each."""
        if self.volumetric is None:
            return [(self._batches(self.points), 1.0, 1.0)]
        if self.volumetric == "linear":  # the volumetric part is that of `dilatation`
            return [(self._batches(self.points), 0.0, 1.0)]
        return [(self._batches(self.points), 0.0, 1.0), (self._batches(self.volumetric), 1.0, 0.0)]

    def parts(self) -> Iterator[Part]:
        """The cells of each law in the batches of all rules, which follow the memory."""
        start = 0
        for batches, volume, rest in self.rules():
            for k, batch in enumerate(batches):
                for own, some, law in self._of_laws(batch):
                    if law.n_memory and rest:
                        stop = start + law.n_memory * some.dV.size
                        law = law.remembering(self.memory[start:stop].reshape(*some.dV.shape, -1))
                        start = stop
                    yield Part(k, own, some, law, volume, rest)

    def _flowing(self) -> Iterator[tuple[GradientBatch, PlasticLaw]]:
        """Cells that may flow, and their laws."""
        for part in self.parts() if self.n_flowing else ():
            if part.law.n_memory and part.rest:
                yield part.batch, cast(PlasticLaw, part.law)

    def _of_laws(self, batch: GradientBatch) -> list[tuple[Mask, GradientBatch, Law]]:
        """Cells of a batch by their laws, kept if its shape functions are."""
        key = int(batch.cells[0]), batch.dV.shape[1]
        if key in self._by_law:
            return self._by_law[key]
        kind, out = self._materials[0][batch.cells], []
        for k, law in enumerate(self._laws):
            if (own := kind == k).any():
                some = batch if own.all() else batch.some(own)
                places = some.S @ self.space.spread(self.space.q0)[some.functions]
                out.append((own, some, law.at(places)))
        if batch.dV.shape[1] in {points**3 for points in self._kept}:
            self._by_law[key] = out
        return out

    @cached_property
    def _by_law(self) -> dict[tuple[int, int], list[tuple[Mask, GradientBatch, Law]]]:
        return {}

    def moduli(self, cells: IntArray, volume: float, rest: float) -> tuple[Array, Array]:
        """Lame's constants of small strains of cells, with the factors of the volumetric part and of the rest."""
        bulk = self.bulk[cells]
        return volume * bulk + rest * (self.lame[cells] - bulk), rest * self.shear[cells]

    def _respond(self, e: Array, part: Part) -> tuple[Array, Response]:
        """Deformation gradients (n_cells, n_q, 3, 3) and the response of the law."""
        F, batch = deformation_gradients(e, part.batch), part.batch
        response = part.law.pulled(F, part.volume, part.rest)
        if self.volumetric != "linear":
            return F, response
        v = part.law.dilated(F)
        mean = self.projected(v.value, batch)
        pressure = self.bulk[batch.cells, None] * mean
        energy = response.energy + pressure * mean / 2
        stress = response.stress + pressure[..., None, None] * v.rate
        return F, replace(response, energy=energy, stress=stress, shear=response.shear - v.bend * pressure)

    def projected(self, values: Array, batch: GradientBatch) -> Array:
        """Projection on 1, x, y, z in each cell of values (n_cells, n_q) at the Gauss points, by least squares."""
        coefficients = self._fit(batch) @ values[..., None]
        return np.asarray((linear_functions(gauss(self.points)[0]) @ coefficients)[..., 0])

    def _fit(self, batch: GradientBatch) -> Array:
        """`linear_fit` of a batch, kept."""
        first = int(batch.cells[0])
        if first not in self._fits:
            self._fits[first] = self.linear_fit(batch.dV)
        return self._fits[first]

    @cached_property
    def _fits(self) -> dict[int, Array]:
        return {}

    def energy(self, q: Array) -> float:
        """Strain energy at coordinates q (n_dofs,)."""
        e, total = self.space.spread(q), 0.0
        for part in self.parts():
            total += float((self._respond(e, part)[1].energy * part.batch.dV).sum())
        return total

    def check_inverted(self, q: Array) -> None:
        """Refuse coordinates q (n_dofs,) that turn material inside out, det F <= 0, at a Gauss point.

        The energy of St. Venant and Kirchhoff is finite there. Under uniaxial stress its nominal stress E (s^3 - s)/2
        has its minimum -E/(3 sqrt(3)) at the stretch s = 1/sqrt(3), and only an inverted state, s < -1, balances more.

        Raises
        ------
        InvertedError
            Names how many points, and of the worst its cell, initial place and det F.

        Examples
        --------
        >>> import numpy as np, fecontact as fc
        >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
        >>> solid = AncfSolid(space, fc.Material(E=1.0, nu=0.0))
        >>> solid.check_inverted(space.affine(np.diag([0.1, 1.0, 1.0])))
        """
        e, count, worst, cell, place = self.space.spread(q), 0, np.inf, 0, np.zeros(3)
        for part in self.parts():
            batch = part.batch
            det = determinant_3x3(deformation_gradients(e, batch))
            count += int((~(det > 0)).sum())
            k, point = np.unravel_index(np.argmin(det), det.shape)
            if not det[k, point] >= worst:
                worst, cell = float(det[k, point]), int(batch.cells[k])
                place = batch.S[k, point] @ self.space.spread(self.space.q0)[batch.functions[k]]
        if count:
            at = ", ".join(f"{x:.4g}" for x in place)
            raise InvertedError(
                f"Material is turned inside out at {count} Gauss points, worst in cell {cell}, at ({at}) of the "
                f"initial shape: det F = {worst:.3g}, and it must be positive. Take a smaller load or smaller steps, a "
                "law that resists it (NeoHookean), or a finer mesh there."
            )

    @property
    def n_dofs(self) -> int:
        """Number of coordinates."""
        return self.space.n_dofs

    @property
    def q0(self) -> Array:
        """Initial coordinates (n_dofs,)."""
        return self.space.q0

    @property
    def extent(self) -> float:
        """Largest extent of the mesh along an axis."""
        return float(np.ptp(self.space.mesh.points, axis=0).max())

    @cached_property
    def scales(self) -> Array:
        """Factors (n_dofs,) that turn changes of coordinates into lengths.

        One for positions; for gradients the side of a cube of the mean volume of the cells, so that tolerances do not
        depend on units.
        """
        each = np.full(self.space.n_functions, np.cbrt(self.space.volumes.mean()))
        each[self.space.start] = 1.0
        return np.repeat(each, 3)

    @property
    def is_slender(self) -> bool:
        """No."""
        return False

    @cached_property
    def rigid_modes(self) -> Array:
        """Changes (n_dofs, 6) of the coordinates by the rigid motions about the middle of the mesh's points."""
        return self.space.rigid_modes(self.space.mesh.points.mean(axis=0))

    def translation(self, direction: Array) -> Array:
        """Change (n_dofs,) of the coordinates by a translation (3,)."""
        return self.space.affine(np.zeros((3, 3)), direction)

    def place_rows(self, where: ArrayLike) -> list[sp.csr_matrix]:
        """Rows of its space, see `AncfSpace.place_rows`."""
        return self.space.place_rows(where)

    def forces_between(self, q0: Array, q1: Array) -> Array:
        """Conserving elastic forces (n_dofs,) between coordinates q0 and q1, see the module.

        Raises
        ------
        InvertedError
            If the mean of C = F^T F of both states is singular at a point.

        Examples
        --------
        >>> import numpy as np, fecontact as fc
        >>> space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
        >>> solid = AncfSolid(space, fc.NeoHookean(E=1.0, nu=0.3))
        >>> a, b = space.affine(np.diag([1.0, 1.1, 0.9])), space.affine(np.diag([1.2, 1.0, 1.0]))
        >>> work = solid.forces_between(a, b) @ (b - a)
        >>> bool(abs(work - (solid.energy(b) - solid.energy(a))) < 1e-14)
        True
        """
        e0, e1 = self.space.spread(q0), self.space.spread(q1)
        total = np.zeros_like(e0)
        for part in self.parts():
            batch, law = part.batch, part.law
            F0, F1 = deformation_gradients(e0, batch), deformation_gradients(e1, batch)
            C0, C1 = (np.swapaxes(F, 2, 3) @ F for F in (F0, F1))
            try:
                middle = np.swapaxes(np.linalg.cholesky((C0 + C1) / 2), 2, 3)  # any F with F^T F = C_mid will do
            except np.linalg.LinAlgError as error:
                raise InvertedError("Material is flattened to nothing in both states of a step.") from error
            half, before, after = (law.pulled(F, part.volume, part.rest) for F in (middle, F0, F1))
            change = (C1 - C0) / 2
            size = (change * change).sum(axis=(2, 3))
            strain = max(np.abs(C0 - np.eye(3)).max(), np.abs(C1 - np.eye(3)).max()) / 2
            large = size > max(MIN_CHANGE * strain, ROUNDED_CHANGE) ** 2
            S = _discrete(half.stress, after.energy - before.energy, change, large, size)
            if self.volumetric == "linear":
                v, v0, v1 = (law.dilated(F) for F in (middle, F0, F1))
                # half the difference of projected squares: their mean times the change of v
                pressure = self.bulk[batch.cells, None] * self.projected((v0.value + v1.value) / 2, batch)
                S = S + pressure[..., None, None] * _discrete(v.rate, v1.value - v0.value, change, large, size)
            batch.add_forces(total, (F0 + F1) / 2 @ S)
        return self.space.gather(total)

    def drawn(self, q: Array) -> Drawing:
        """Every cell separately with twenty nodes, to show its curved edges."""
        n = len(self.space.corners)
        cells, X = np.repeat(np.arange(n), 20), np.tile(NODES, (n, 1))
        connectivity = np.arange(20 * n).reshape(-1, 20)
        start = self.space.points_at(self.space.q0, cells, X)
        return Drawing(
            "hexahedron20", start, self.space.points_at(q, cells, X), connectivity, self.cauchy_at(q, cells, X)
        )

    def cauchy_at(self, q: Array, cells: IntArray, X: Array) -> Array:
        """Cauchy stress F S F^T / det F (n, 6) at material points, cell (n,) and reference coordinates X (n, 3).

        Components xx, yy, zz, xy, yz, xz, in world axes.

        Raises
        ------
        InputError
            If it would flow to q but does not remember how.
        """
        if self.n_flowing and not self.memory.any() and self.flowed(q).any():
            raise InputError(
                "The stress of a solid that has flowed depends on how: ask the solid of a state, which remembers, "
                "state.assembly.solids[k].",
                code="memory",
            )
        F, S = self.space.gradient_at(q, cells, X), np.zeros((len(cells), 3, 3))
        places, projected = self.space.points_at(self.space.q0, cells, X), self.volumetric == "linear"
        if projected:
            each, fitted = self.space.spread(q), np.zeros((len(self.lame), 4))
            for part in self.parts():
                values = part.law.dilated(deformation_gradients(each, part.batch)).value
                fitted[part.batch.cells] = (self._fit(part.batch) @ values[..., None])[..., 0]
            pressure = self.bulk[cells] * (linear_functions(X) * fitted[cells]).sum(axis=1)
        for k, law in enumerate(self._laws):
            if (own := self._materials[0][cells] == k).any():
                there = law.at(places[own])
                there = there.remembering(self._memory_at(cells[own], X[own])) if there.n_memory else there
                S[own] = there.pulled(F[own], 0.0 if projected else 1.0).stress
                if projected:
                    S[own] += pressure[own, None, None] * law.dilated(F[own]).rate
        sigma = F @ S @ F.swapaxes(1, 2) / determinant_3x3(F)[:, None, None]
        return np.asarray(sigma[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]])

    def forces(self, q: Array) -> Array:
        """Elastic forces (n_dofs,) at coordinates q: the gradient of the energy."""
        e = self.space.spread(q)
        total = np.zeros_like(e)
        for part in self.parts():
            F, response = self._respond(e, part)
            part.batch.add_forces(total, F @ response.stress)
        return self.space.gather(total)

    def tangent(self, q: Array) -> sp.csr_matrix:
        """Derivative (n_dofs, n_dofs) of the elastic forces at coordinates q, symmetric."""
        return self._tangent(q, self._respond, self.volumetric == "linear")

    @cached_property
    def n_flowing(self) -> int:
        """Numbers that plastic flow remembers."""
        each = np.bincount(self._materials[0], minlength=len(self._laws)) * self.points**3
        return int((each * [law.n_memory for law in self._laws]).sum())

    def _share(self) -> None:
        _ = self._kept, self._by_law, self._fits, self._pattern

    def flowed(self, q: Array) -> Array:
        """The memory of plastic flow (n,) after a step to coordinates q."""
        e = self.space.spread(q)
        each = [law.returned(deformation_gradients(e, batch)).memory.ravel() for batch, law in self._flowing()]
        return np.concatenate([np.zeros(0), *each])

    @property
    def dissipated(self) -> float:
        """Energy lost to plastic flow up to its memory."""
        return sum(law.dissipated(batch.dV) for batch, law in self._flowing())

    @property
    def plastic_strain(self) -> Array:
        """Accumulated plastic strain (n_cells, n_q) at the Gauss points, up to its memory; zero in elastic cells."""
        out = np.zeros((len(self.space.corners), self.points**3))
        for batch, law in self._flowing():
            out[batch.cells] = law.memory[..., -1]
        return out

    @property
    def cautions(self) -> tuple[str, ...]:
        """What results should warn of: large plastic strains, and cells that lock as they flow."""
        if self.volumetric is not None or not self.plastic_strain.any():
            return super().cautions
        lock = (
            'It flows, which keeps its volume, so that its cells lock: take volumetric="linear", or distrust stresses.'
        )
        return (*super().cautions, lock)

    def _memory_at(self, cells: IntArray, X: Array) -> Array:
        """The memory of plastic flow (n, 10), fitted linearly in each cell, at material points."""
        fitted = np.zeros((len(self.space.corners), 4, 10))
        for batch, law in self._flowing():
            fitted[batch.cells] = self._fit(batch) @ law.memory
        found = (linear_functions(X)[:, None] @ fitted[cells])[:, 0]
        found[:, -1] = np.maximum(found[:, -1], 0.0)
        return found

    def plastic_strain_at(self, cells: IntArray, X: Array) -> Array:
        """The same (n,) at material points, cell (n,) and reference coordinates X (n, 3), linear in each cell."""
        return self._memory_at(cells, X)[:, -1]

    def strained(self) -> list[Strained]:
        """Green-Lagrange strains (n_cells, n_q, 9) of its parts."""

        def strain(part: Part, q: Array) -> Array:
            F = deformation_gradients(self.space.spread(q), part.batch)
            E = (np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2
            return E.reshape(*E.shape[:-2], 9)

        def stress(part: Part, E: Array) -> Array:
            lame, shear = self.moduli(part.batch.cells[:, None], part.volume, part.rest)
            trace = lame * E[..., ::4].sum(axis=-1)
            return np.asarray(trace[..., None] * np.eye(3).ravel() + 2 * shear[..., None] * E)

        def dragged(part: Part, q: Array, rate: Array) -> Array:
            eta = 0.0 if self.viscous is None else part.rest * self.viscous.newtonian
            return drag(eta, deformation_gradients(self.space.spread(q), part.batch), rate)

        return [
            Strained(partial(strain, part), partial(stress, part), partial(dragged, part), part.batch.dV)
            for part in self.parts()
        ]

    def step_forces(self, q0: Array, q1: Array, stresses: Sequence[Array]) -> Array:
        """Forces (n_dofs,) whose work from q0 to q1 is that of stresses of the parts by the change of their strains."""
        e = self.space.spread((q0 + q1) / 2)
        total = np.zeros_like(e)
        for part, stress in zip(self.parts(), stresses, strict=True):
            F = deformation_gradients(e, part.batch)
            part.batch.add_forces(total, F @ stress.reshape(F.shape))
        return self.space.gather(total)

    def viscous_tangent(self, q: Array, h: float) -> sp.csr_matrix:
        """Derivative (n_dofs, n_dofs) of the viscous forces of a step of length h by its end, at its middle q.

        Without the part of the stress, which is small beside the elastic one.
        """

        def respond(e: Array, part: Part) -> tuple[Array, Response]:
            F = deformation_gradients(e, part.batch)
            return F, viscous_response(self, h, part, F)

        return self._tangent(q, respond)

    def _tangent(
        self, q: Array, respond: Callable[[Array, Part], tuple[Array, Response]], coupled: bool = False
    ) -> sp.csr_matrix:
        e = self.space.spread(q)
        pattern = self._pattern
        data = pattern.zeros(6)
        for part in self.parts():
            F, response = respond(e, part)
            blocks = element_tangents(F, response, part.batch)
            if coupled and response.metric is not None:  # the rate of the dilatation, see `Law.dilated`
                blocks = blocks + self._coupled(F, response.metric, part.batch)
            pattern.add(data, part.number, part.among_all(blocks))
        return pattern.matrix(data)

    def _coupled(self, F: Array, X: Array, batch: GradientBatch) -> Array:
        """Blocks (n_cells, 32, 32, 6) of bulk (projection of dv) (projection of dv), with dv = X : dE."""
        n, n_q, n_functions, _ = batch.gradients.shape
        rate = (batch.gradients @ np.swapaxes(F @ X, 2, 3)).reshape(n, n_q, -1)
        fitted = self._fit(batch) @ rate
        B = linear_functions(gauss(self.points)[0])
        moments = np.einsum("qi,eq,qj->eij", B, batch.dV * self.bulk[batch.cells, None], B, optimize=True)
        K = (np.swapaxes(fitted, 1, 2) @ moments @ fitted).reshape(n, n_functions, 3, n_functions, 3)
        return np.stack([K[:, :, i, :, j] for i, j in zip(*PAIRS, strict=True)], axis=3)

    @cached_property
    def stiffness(self) -> sp.csr_matrix:
        """Linear stiffness (n_dofs, n_dofs) of the initial shape by Hooke's law, the limit of every law."""
        if not all(law.isotropic for law in self._laws):
            return self.tangent(self.q0)
        return self.stiffness_of_linear_dilatation if self.volumetric == "linear" else self._linear(self.rules())

    @cached_property
    def stiffness_of_linear_dilatation(self) -> sp.csr_matrix:
        """The same, with the divergence in the part with lambda projected on linear functions in each cell.

        The mean dilatation of J. C. Nagtegaal, D. M. Parks & J. R. Rice (Comput. Methods Appl. Mech. Engrg. 4, 1974)
        with three more functions: the mean alone gives no resistance to volumetric bending.
        """
        projected = (replace(b, gradients=self._projected(b.gradients, b.dV)) for b in self._batches(self.points))
        return self._linear([(self._batches(self.points), 0.0, 1.0), (projected, 1.0, 0.0)])

    def linear_fit(self, dV: Array) -> Array:
        """Coefficients (n_cells, 4, n_q) of 1, x, y, z from values at the Gauss points, by least squares."""
        B = linear_functions(gauss(self.points)[0])
        moments = np.einsum("qi,eq,qj->eij", B, dV, B, optimize=True)
        return np.asarray(np.linalg.solve(moments, B.T * dV[:, None, :]))

    def _projected(self, gradients: Array, dV: Array) -> Array:
        shape = gradients.shape
        B = linear_functions(gauss(self.points)[0])
        return np.asarray(B @ (self.linear_fit(dV) @ gradients.reshape(*shape[:2], -1))).reshape(shape)

    def _linear(self, rules: Iterable[tuple[Iterable[GradientBatch], float, float]]) -> sp.csr_matrix:
        pattern = self._pattern
        data = pattern.zeros(6)
        for batches, volume, rest in rules:
            for k, batch in enumerate(batches):
                constants = self.moduli(batch.cells, volume, rest)
                pattern.add(data, k, element_stiffness(batch, *constants)[..., *PAIRS])
        return pattern.matrix(data)

    @cached_property
    def scalar_mass(self) -> sp.csr_matrix:
        """Consistent mass (n_functions, n_functions) of one component: int rho S_a S_b dV."""
        X, W = gauss(5 if self.space.mesh.cells.shape[1] > 8 else 4)
        data = self._pattern.zeros()
        for k, batch in enumerate(self.space.batches(X, W)):
            weighted = batch.S * (batch.dV * self.density[batch.cells, None])[..., None]
            self._pattern.add(data, k, np.swapaxes(weighted, 1, 2) @ batch.S)
        return self._pattern.scalar(data)

    @cached_property
    def mass(self) -> sp.csr_matrix:
        """Consistent mass (n_dofs, n_dofs), constant in any motion."""
        return sp.kron(self.scalar_mass, sp.eye_array(3), format="csr")

    @cached_property
    def _pattern(self) -> Pattern:
        return Pattern(self.space.functions, self.space.joining)
