"""Adhesion on a half-space: surfaces attract each other by a constant traction up to a range (Dugdale's law).

The energy is that of the elastic displacements and of the attraction, an exact integral over gaps that are linear
between the cells' centres: a cell carries the share of the traction that its part within the range gives it. It is
convex but for the attraction, which is concave: contact under the tractions of the last gap lowers it (the
concave-convex procedure, Yuille & Rangarajan, Neural Comput. 15 (2003) 915). Newton's method on the shares goes on from
there, where it lowers the energy too. Its matrix is 1 - C with the softening C by attraction, found by Lanczos' method,
each product of which is a contact of a given outline; a state is a local minimum if all eigenvalues of C are below 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, cg

from fecontact.common.arrays import Array, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import ErrorEstimate, ResponseError
from fecontact.common.errors import InputError, SolverError
from fecontact.halfspace.attraction import Centres, Dugdale, Zone
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.fft import DampedInverse, Product, Tally
from fecontact.halfspace.grid import block_sums, part_of, unfold
from fecontact.halfspace.grid_error import EdgeCells, edge_cells
from fecontact.halfspace.nested import GridLevel, coarser, compliance, preconditioner
from fecontact.halfspace.pressing import Load, check_box, checked_heights, grid_level, press

#: Steps towards one state: just beyond the approach of coming off they grow as the inverse root of the distance to it.
MAX_STEPS = 1000
#: Largest residual of the law, a share of the traction, over the tolerance of the contact.
OF_LAW = 100
#: Steps of Lanczos' method, and the residual at which they end; for the eigenvalue, its change.
MAX_LANCZOS, ENOUGH, SETTLED = 40, 1e-2, 1e-3
#: Tolerance of the contact of a given outline in them.
HELD_TOLERANCE = 1e-4
#: Change to cells twice as large over the error, of forces, areas and pressures.
CHANGE = 0.7
#: Estimate without a coarser grid.
UNKNOWN = ErrorEstimate.none("not estimated, the grid has no coarser one")


@compact_repr
@dataclass(frozen=True, eq=False)
class AdhesiveContact(HalfSpaceContact):
    """Contact of a half-space with a rigid surface that adheres; made by `HalfSpace.press` with `adhesion`.

    Pressures, and the force, are net ones: tension is negative. What touches is what is pressed against attraction.

    Attributes
    ----------
    adhesion : Dugdale
    attraction : (nx, ny) array
        Tension by adhesion: the traction times the share of a cell within the range.
    law_residual : float
        Largest difference of a share to that of the gap, recomputed.
    stability : float
        Smallest eigenvalue of the energy's second derivative, over that without attraction: above 0 the state is a
        local minimum, among states of the symmetry that is modelled.
    energy : float
        Elastic energy less that of adhesion.
    zone_width : float
        Width of the zone at the edge of a large contact.
    estimate : ErrorEstimate
    response : ResponseError
    """

    adhesion: Dugdale
    attraction: Array
    law_residual: float
    stability: float
    energy: float
    zone_width: float
    estimate: ErrorEstimate = field(default=UNKNOWN, kw_only=True, repr=False)
    response: ResponseError = field(default=ResponseError(), kw_only=True, repr=False)

    @property
    def active(self) -> Mask:
        """Cells (nx, ny) that touch."""
        return self.pressure + self.attraction > 0

    @property
    def has_stiffness(self) -> bool:
        """No: the force depends on the path."""
        return False

    @property
    def is_minimum(self) -> bool:
        """Whether the state is a local minimum of the energy."""
        return self.stability > 0

    @property
    def adhesive_area(self) -> float:
        """Area within the range of adhesion, of the contact too."""
        return float(self.attraction.sum()) * self.grid.area / self.adhesion.traction

    @cached_property
    def _edge(self) -> EdgeCells:
        return edge_cells(self.pressure + self.attraction, self.gap, self.periodic)

    @property
    def error_estimate(self) -> ErrorEstimate:
        """From the change by a grid of cells twice as large."""
        return self.estimate

    @property
    def response_error(self) -> ResponseError:
        """Of the force over what presses or, if more, pulls; or of the approach over the larger of it and the range."""
        return self.response

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of a state that is no local minimum, too, and of a zone of adhesion that cells do not resolve."""
        found = super().warnings
        if not self.is_minimum:
            found += (
                f"The state is not a local minimum of the energy: an eigenvalue is {self.stability:.2g} of that "
                "without adhesion. Give the approach in smaller steps, by `HalfSpace.curve`.",
            )
        width = self.zone_width
        if self.active.any() and max(self.grid.cell) > width / 2:
            found += (
                f"Cells of {max(self.grid.cell):.3g} are wider than half the zone of adhesion, about {width:.3g} at "
                f"the edge of a large contact: it may come off in jumps from cell to cell. Take cells of "
                f"{width / 2:.2g}, or a larger range with the same work.",
            )
        return found

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures by name."""
        names = ("adhesive_area", "energy", "stability", "law_residual")
        return {**super().figures, **{name: getattr(self, name) for name in names}}

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        return super().summary() | {"adhesion": {"work": self.adhesion.work, "range": self.adhesion.range}}

    def columns(self) -> dict[str, Array]:
        """Fields (nx, ny) on the cells by name."""
        return {**super().columns(), "attraction": self.attraction}

    @property
    def _printed(self) -> dict[str, float]:
        return {**super()._printed, "adhesive area": self.adhesive_area, "energy": self.energy}

    @property
    def _reports(self) -> tuple[object, ...]:
        kind = "a local minimum" if self.is_minimum else "not a local minimum"
        law = f"law of adhesion kept to {self.law_residual:.1e}; {kind} of the energy (eigenvalue {self.stability:.2g})"
        return self.solver, law


class Given(NamedTuple):
    """What is prescribed: an approach or a force."""

    approach: float | None
    force: float | None = None


class State(NamedTuple):
    """A contact under given shares of attraction, of the modelled cells; energies are over the area of a cell."""

    given: Given
    contact: HalfSpaceContact
    share: Array
    zone: Zone
    energy: float
    potential: float
    scale: float

    @property
    def residual(self) -> float:
        """Largest difference of a share to that of the gap."""
        return float(np.abs(self.zone.share - self.share).max())


@dataclass(frozen=True, eq=False)
class Adhesive:
    """A surface with heights (nx, ny) that adheres to a half-space."""

    body: SurfaceCompliance
    heights: Array
    law: Dugdale
    tolerance: float
    symmetry: bool
    workers: int | None

    @cached_property
    def level(self) -> GridLevel:
        """The modelled cells."""
        z, allowed = checked_heights(self.heights, self.body.grid)
        return grid_level(self.body, z, allowed, Load(None, 0.0, None), self.symmetry)

    @cached_property
    def _products(self) -> tuple[Product, Product | DampedInverse]:
        make = self.level, self.level.whole, Tally(self.body.grid.n_cells), self.workers
        return compliance(*make), preconditioner(*make)

    @cached_property
    def _centres(self) -> Centres:
        x, y = (self.body.periodic and not even for even in self.level.symmetric)
        return Centres(self.level.g.shape, (x, y))

    @cached_property
    def _coarse(self) -> Adhesive | None:
        """The same on cells twice as large; None if they do not fit."""
        if any(n % 4 for n in self.body.grid.shape):
            return None
        level = coarser(self.level, self.body.kernel(1))
        heights = unfold(np.where(level.allowed, level.g, np.inf), level.symmetric)
        return replace(self, body=replace(self.body, grid=self.body.grid.coarser), heights=heights)

    def _of(self, values: Any) -> Any:
        """Values of the modelled cells."""
        return values[part_of(self.body.grid.shape, self.level.symmetric)]

    def contact(
        self, given: Given, share: Array | None = None, last: State | None = None
    ) -> tuple[AdhesiveContact, State]:
        """The state that follows one with shares (nx, ny) of modelled cells; without them from separated surfaces.

        Under a force without shares they follow the first touch.
        """
        if share is None and given.approach is None:
            last = self._settled(Given(float(self.heights.min())), np.zeros(self.level.g.shape), None)
            share = last.share
        at = self._settled(given, np.zeros(self.level.g.shape) if share is None else share, last)
        if not self.body.periodic:
            check_box(self.body.grid, at.share > 0, None, self.level.symmetric, "zone of adhesion")
        return self._certified(at), at

    def _settled(self, given: Given, share: Array, last: State | None) -> State:
        """The state by steps from given shares."""
        at = self._state(given, share, last)
        for _ in range(MAX_STEPS):
            if at.residual <= OF_LAW * self.tolerance:
                return at
            at = self._next(at)
        raise SolverError(
            f"No certified answer after {MAX_STEPS} steps of the adhesive zone: shares differ by {at.residual:.1e} "
            f"from those of the gap. Take smaller cells or a larger range.",
            code="adhesion-not-settled",
        )

    def _next(self, at: State) -> State:
        """Newton's step where it lowers the energy, else the contact under the tractions of the last gap."""
        found = at.zone.share - at.share
        B, lowered = self._outline(at), self._lowered(at)
        change, softening = lanczos(lambda y: B @ lowered(B.T @ y), B @ lowered(self.law.traction * found.ravel()))
        if softening < 1:
            step = found + (B.T @ change).reshape(found.shape) / self.law.traction
            new = self._state(at.given, np.clip(at.share + step, 0.0, 1.0), at)
            if new.energy <= at.energy + 10 * self.tolerance * at.scale:
                return new
        return self._state(at.given, at.zone.share, at)

    def _state(self, given: Given, share: Array, last: State | None) -> State:
        """The contact under given shares."""
        lifted = self._products[0].apply(self.law.traction * share)
        z = unfold(np.where(self.level.allowed, self.level.g - lifted, np.inf), self.level.symmetric)
        load, start = self._load(given, share), None if last is None else last.contact
        contact = press(self.body, z, load, self.tolerance, self.symmetry, self.workers, boxed=False, start=start)
        zone = self._centres.zone(self._of(contact.gap), self.law.range)
        net = self._of(contact.pressure) - self.law.traction * share
        elastic = float(np.vdot(net, self._of(contact.displacement) - lifted)) / 2
        adhesive = self.law.traction * zone.depth
        work = 0.0 if given.force is None else contact.approach * float(net.sum())
        return State(
            given, contact, share, zone, elastic - adhesive - work, elastic - adhesive, abs(elastic) + adhesive
        )

    def _load(self, given: Given, share: Array) -> Load:
        """The load of the contact under given shares: a force with what they pull."""
        if given.force is None:
            return Load(None, given.approach, None)
        pull = self.law.traction * float(share.sum()) * self.body.grid.area * 2 ** sum(self.level.symmetric)
        if given.force + pull <= 0:
            raise InputError(
                f"Under a tension of {-given.force:g} the surfaces come off. Take a smaller one: the largest is the "
                "pull_off of HalfSpace.curve with adhesion, which comes off by approaches.",
                code="beyond-pull-off",
            )
        return Load(given.force + pull, None, None)

    def _outline(self, at: State) -> sp.csr_matrix:
        """Rows of gaps at points of the zone's outline, times roots of what comes within the range there."""
        return sp.csr_matrix(sp.diags(np.sqrt(self.law.traction * at.zone.weights)) @ at.zone.points)

    def _lowered(self, at: State) -> Callable[[Array], Array]:
        """Function of tractions: by how much they close the gap while what touches stays so, all (n,)."""
        (A, P), held = self._products, self._of(at.contact.active)

        def among(product: Product | DampedInverse) -> LinearOperator:
            apply = lambda x: (product.apply(x.reshape(held.shape) * held) * held).ravel()  # noqa: E731
            return LinearOperator((held.size, held.size), matvec=apply, dtype=float)

        own, inverse = among(A), among(P)

        def carried(u: Array) -> Array:
            """Pressures of what touches by displacements there."""
            p = cg(own, (u * held).ravel(), rtol=HELD_TOLERANCE, maxiter=100, M=inverse)[0]
            return np.asarray(p.reshape(held.shape))

        # under a force the surface moves too: pressures by a unit of its approach
        unit = carried(np.ones(held.shape)) if at.given.force is not None and held.any() and not held.all() else None

        def lowered(tension: Array) -> Array:
            t = tension.reshape(held.shape)
            u = A.apply(t)
            if held.any():
                p = carried(u)
                moved = 0.0 if unit is None else float((t - p).sum() / unit.sum())
                u += moved - A.apply(p if unit is None else p + moved * unit)
            return np.asarray(u.ravel())

        return lowered

    def _certified(self, at: State) -> AdhesiveContact:
        """The contact with its residuals, stability and estimated errors."""
        B, lowered = self._outline(at), self._lowered(at)
        start = np.random.default_rng(1).normal(size=B.shape[0])
        softening = lanczos(lambda y: B @ lowered(B.T @ y), start, settled=True)[1]
        attraction = self.law.traction * unfold(at.share, self.level.symmetric)
        lifted = unfold(self._products[0].apply(self.law.traction * at.share), self.level.symmetric)
        fields = {name: getattr(at.contact, name) for name in HalfSpaceContact.__dataclass_fields__} | {
            "pressure": at.contact.pressure - attraction,
            "displacement": at.contact.displacement - lifted,
            "coarse": None,
            "status": "solved" if attraction.any() else at.contact.status,
            "given": "approach" if at.given.force is None else "force",
        }
        return AdhesiveContact(
            **fields,
            adhesion=self.law,
            attraction=attraction,
            law_residual=at.residual,
            stability=1 - softening,
            energy=at.potential * self.body.grid.area * 2 ** sum(self.level.symmetric),
            zone_width=self.law.zone_width(self.body.modulus),
        )

    def judged(self, contact: AdhesiveContact, at: State) -> AdhesiveContact:
        """The contact with errors by the change to cells twice as large, whose steps begin with the same shares."""
        if self._coarse is None or not at.share.any():
            return contact
        try:
            near = self._coarse._settled(at.given, block_sums(at.share) / 4, None)
        except (InputError, SolverError):
            return replace(contact, estimate=ErrorEstimate.none("not estimated, cells twice as large have no answer"))
        coarse = self._coarse._certified(near)
        means, loaded = block_sums(contact.pressure) / 4, contact.pressure + contact.attraction
        largest = max(float(loaded.sum()), float(contact.attraction.sum())) * self.body.grid.area

        def change(name: str, scale: float) -> float:
            return abs(coarse.figures[name] - contact.figures[name]) / (CHANGE * scale) if scale else 0.0

        estimate = ErrorEstimate(
            pressure=float(np.linalg.norm(means - coarse.pressure) / np.linalg.norm(means)) / CHANGE,
            geometry=0.0,
            interior=0.0,
            peak=change("max_pressure", contact.max_pressure),
            area=change("area", contact.figures["area"]),
            faces_across=float(2 * np.sqrt((contact.attraction > 0).sum() / np.pi)),
        )
        by = {"force": change("force", largest)}
        if at.given.force is not None:
            by = {"approach": change("approach", max(abs(contact.approach), self.law.range))}
        return replace(contact, estimate=estimate, response=ResponseError(**by))


def lanczos(apply: Callable[[Array], Array], b: Array, settled: bool = False) -> tuple[Array, float]:
    """Solve (1 - C) y = b by Lanczos' method: y (n,), and the largest eigenvalue found of the symmetric C, or 0.

    With `settled` it goes on until the eigenvalue is.

    Examples
    --------
    >>> C = np.diag([0.5, 0.25, 0.0])
    >>> y, largest = lanczos(lambda x: C @ x, np.ones(3), settled=True)
    >>> bool(np.allclose(y, [2.0, 4 / 3, 1.0])), round(largest, 12)
    (True, 0.5)
    """
    size = float(np.linalg.norm(b))
    if size == 0:
        return np.zeros(len(b)), 0.0
    basis, T, largest = (b / size)[None], np.zeros((MAX_LANCZOS + 1, MAX_LANCZOS + 1)), -np.inf
    for k in range(MAX_LANCZOS):
        rest = apply(basis[k])
        for _ in range(2):  # twice is enough
            parts = basis @ rest
            T[k, k] += parts[k]
            rest = rest - parts @ basis
        beta, n, before = float(np.linalg.norm(rest)), k + 1, largest
        shares = np.linalg.lstsq(np.eye(n) - T[:n, :n], size * np.eye(n)[0])[0]
        largest = float(np.linalg.eigvalsh(T[:n, :n])[-1])
        done = largest - before <= SETTLED * abs(largest) if settled else beta * abs(shares[-1]) <= ENOUGH * size
        if done or n == len(b) or beta <= 1e-12:
            break
        T[k, n] = T[n, k] = beta
        basis = np.vstack([basis, rest / beta])
    return np.asarray(shares @ basis[:n]), largest
